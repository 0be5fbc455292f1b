# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_secondary against raycore.model.shade.bounce and a stack a pixel: every ray, weight and end, bit for bit.

The test plays the context RAM, the light unit (which grants windows), the pixels that bounce, and who takes rays and ends.
A pixel is in one place at a time; of its jobs only the result is expected, in whichever order pixels come out.
"""

import os
import random
from collections import Counter
from dataclasses import dataclass, field

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import fp24, shade
from raycore.tbutil import package_with_latencies, rtl, run_cocotb

ONE, ZERO, NAN, INF, HUGE, T_MIN = 0x3F0000, 0, fp24.NAN_BITS, fp24.INF_BITS, 0x7D0000, 0x310000
CORNERS = [0x000000, 0x800000, 0x010000, 0x810000, 0x3F0000, 0xBF0000, 0x7EFFFF, 0xFEFFFF, 0x7F0000, 0xFF0000, NAN,
           0x000001, 0x80FFFF, 0x7F0001, 0xFFFFFF, 0x7E0000, 0x7DFFFF, 0x020000]
LATENCIES = {
    "paper": {},
    "one": dict(ADD=1, MUL=1, DIV=1, SQRT=1),
    "deep": dict(ADD=4, MUL=3, CMP=2, DIV=9, SQRT=4),
    "odd": dict(ADD=3, MUL=2, DIV=5, SQRT=3),
    "long": dict(ADD=2, MUL=5, CMP=4, DIV=20, SQRT=6),
}
REFLECT, TRANSMIT = 2, 3          # ray_kind_e
FILES = [*(f"prim/rc_{n}.sv" for n in ("delay", "ram_1r1w", "skid", "fifo", "idx_pool")),
         *(f"fp/rc_fp_{n}.sv" for n in ("pipe", "norm", "round", "add", "mul", "div", "sqrt", "cmp")),
         *(f"shade/rc_{n}.sv" for n in ("shade_pkg", "bounce_pkg", "carry", "hold", "spread", "gather", "trio", "bounce_dir",
                                        "bounce_weight", "bounce", "sec_stack", "secondary"))]


def bits(values):
    return [int(b) for b in fp24.to_bits(np.asarray(values, dtype=np.float64))]


def nearest(values):
    return bits(fp24.round_to_fp24(np.asarray(values, dtype=np.float64)))


def floats(patterns):
    return tuple(float(v) for v in fp24.from_bits(np.asarray(patterns)))


def unvec(word):
    return [word >> s & 0xFFFFFF for s in (0, 24, 48)]


def unit(rng):
    v = np.array([rng.gauss(0, 1) for _ in range(3)])
    return v / np.linalg.norm(v)


@dataclass
class Material:
    """Patterns of optics_t and flags of mat_flags_t."""

    kr: list
    kt: list
    ior: int
    inv_ior: int
    reflects: bool = False
    transmits: bool = False
    fresnel: bool = False
    tex_kr: bool = False
    alpha_mode: int = 0

    @property
    def branch(self):
        return self.reflects and (self.transmits or self.alpha_mode != 0)

    @property
    def blocks(self):
        """The two lines that the loader gives: material_t, of which flags count, and optics_t."""
        flags = (self.alpha_mode << 1 | self.reflects << 3 | self.transmits << 4 | self.fresnel << 5 | self.tex_kr << 6)
        junk = random.Random(repr(self))
        first = junk.getrandbits(480) & ~(0xFFF << 48) | (flags | junk.getrandbits(1)) << 48
        second = junk.getrandbits(480) & ~((1 << 240) - 1)
        for i, b in enumerate(self.kr + self.kt + [self.ior, self.inv_ior]):
            second |= b << (60 * (i // 2) + 24 * (i % 2))
        return first, second

    @property
    def record(self):
        """As the model wants it."""
        values = dict(zip(("kr_r", "kr_g", "kr_b", "kt_r", "kt_g", "kt_b", "ior", "inv_ior"),
                          floats(self.kr + self.kt + [self.ior, self.inv_ior])))
        values |= {n: float(getattr(self, n)) for n in ("reflects", "transmits", "fresnel", "tex_kr", "alpha_mode")}
        return np.array([values.get(name, np.nan) for name in shade.MATERIAL_COLUMNS])


@dataclass
class Context:
    """Patterns of the context of a hit point."""

    p: list
    g: list
    m: list
    d: list
    md: int
    tex: list
    w: list
    alpha: int
    inside: bool
    length: int
    tri: int
    mat: int
    depth: int = 0

    def words(self):
        for i in range(3):
            yield sum(v[i] << 24 * k for k, v in enumerate((self.p, self.g, self.m, self.d, self.tex, self.w)))
        yield (self.md | self.mat << 24 | self.tri << 32 | self.alpha << 65 | self.length << 89 | self.depth << 113
               | self.inside << 117)


class Numbers:
    """Random operands; `wild` is the share of patterns that are corners or random bits."""

    def __init__(self, rng, wild):
        self.rng, self.wild = rng, wild

    def spoil(self, patterns):
        rng = self.rng
        return [(rng.choice(CORNERS) if rng.random() < 0.5 else rng.randrange(1 << 24)) if rng.random() < self.wild else b
                for b in patterns]

    def vector(self, v):
        return self.spoil(nearest(v))

    def colour(self):
        return self.vector([self.rng.random() for _ in range(3)])

    def material(self, **flags):
        rng = self.rng
        ior = rng.choice([1.0, 1.33, 1.5, 2.4, rng.uniform(1, 3)])
        if not flags:
            flags = dict(reflects=rng.random() < 0.7, fresnel=rng.random() < 0.5, tex_kr=rng.random() < 0.5)
            if rng.random() < 0.5:
                flags["transmits"] = True
            else:
                flags["alpha_mode"] = rng.choice([0, 1, 2]) if flags["reflects"] else rng.choice([1, 2])
        return Material(self.colour(), self.colour(), *self.vector([ior, 1 / ior]), **flags)

    def context(self, mats, mat=None):
        """A hit point that makes sense, or, as numbers are wild, anything."""
        rng = self.rng
        mat = rng.randrange(len(mats)) if mat is None else mat
        g = unit(rng)
        m = g + rng.choice([0.0, 0.3, 0.9]) * unit(rng)
        m /= np.linalg.norm(m)
        d = unit(rng)
        d = -d if g @ d > 0 else d
        if rng.random() < 0.3:                           # grazing
            d -= 0.999 * (g @ d) * g
            d /= np.linalg.norm(d)
        # alpha' is 1 if the material is opaque (hit-point unit)
        alpha = {0: ONE, 1: rng.choice([ZERO, ONE]), 2: self.vector([rng.random()])[0]}[mats[mat].alpha_mode]
        return Context(self.vector([rng.uniform(-1, 1) for _ in range(3)]), self.vector(g), self.vector(m), self.vector(d),
                       self.vector([m @ d])[0], self.colour(), self.colour(), alpha, rng.random() < 0.5,
                       self.vector([rng.uniform(0, 5)])[0], rng.randrange(1 << 33), mat)


@dataclass
class Bench:
    """One cycle a step: gives jobs, answers reads, takes what comes, and checks all of it."""

    dut: object
    rng: random.Random
    p_job: float = 1.0
    p_gnt: float = 1.0
    p_ready: float = 1.0
    p_end: float = 1.0
    mats: list = None
    min_weight: int = ZERO
    cycle: int = 0
    words: dict = field(default_factory=dict)            # address: word
    jobs: list = field(default_factory=list)             # (id, context), context None: pop
    expected: dict = field(default_factory=dict)         # id: what comes of its job, None: an end
    paths: dict = field(default_factory=dict)            # id: path of a ray that has not come
    stacks: dict = field(default_factory=dict)           # id: list of rays
    starts: list = field(default_factory=list)           # cycles in which a job started
    out: list = field(default_factory=list)              # (id, ray or None), in the order in which they came
    seen: Counter = field(default_factory=Counter)
    max_stacks: int = 0
    _held: object = None

    async def start(self):
        dut = self.dut
        Clock(dut.clk_i, 10, unit="ns").start()
        for signal in (dut.rst_ni, dut.job_valid_i, dut.job_i, dut.ld_valid_i, dut.sec_ready_i, dut.end_ready_i, dut.start_gnt_i,
                       dut.min_weight_i, dut.ctx_word_i):
            signal.value = 0
        for _ in range(3):
            await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1

    async def load(self, mats, min_weight=ZERO):
        dut = self.dut
        assert not self.expected
        self.mats, self.min_weight = mats, min_weight
        dut.min_weight_i.value = min_weight
        lines = [(kind, i, line) for i, m in enumerate(mats) for kind, line in zip((1, 2), m.blocks)]
        # lines of lights, and of nobody, are not for this unit
        lines += [(0, self.rng.randrange(len(mats)), self.rng.getrandbits(480))]
        for kind, i, line in lines:
            dut.ld_valid_i.value, dut.ld_kind_i.value, dut.ld_idx_i.value, dut.ld_line_i.value = 1, kind, i, line
            await self.step()
        dut.ld_valid_i.value = 0
        dut.ld_line_i.value = self.rng.getrandbits(480)

    def expect(self, ray_id, ctx):
        """Note what comes of a job, and change the pixel's stack, as docs/whitted.md says."""
        assert ray_id not in self.expected
        stack = self.stacks.setdefault(ray_id, [])
        if ctx is None:
            self.expected[ray_id] = stack.pop()
            self.seen["pop"] += 1
            return
        values = (*map(floats, (ctx.p, ctx.g, ctx.m, ctx.d)), floats([ctx.md])[0])
        rays = []
        mat = self.mats[ctx.mat]
        children = shade.FP24.bounce(values, floats(ctx.tex), floats(ctx.w), floats([ctx.alpha])[0], ctx.inside, mat.record,
                                     floats([self.min_weight])[0])
        for kind, (traced, w, direction, org) in zip((REFLECT, TRANSMIT), children):
            if traced:
                rays.append((kind, ctx.depth + 1, ctx.tri, bits(direction), bits(org), bits(w), ctx.length))
        if not mat.branch:
            assert len(rays) < 2
        self.seen["".join(str(r[0]) for r in rays) or "end"] += 1
        self.seen["tir"] += bool(mat.transmits and rays and rays[0][0] == REFLECT and not children[1][0])
        if len(rays) == 2:
            stack.append(rays.pop())
            assert len(stack) <= 15
        self.expected[ray_id] = rays[0] if rays else None
        self.max_stacks = max(self.max_stacks, sum(bool(s) for s in self.stacks.values()))

    async def step(self):
        dut, rng = self.dut, self.rng
        job = None
        if self.jobs and rng.random() < self.p_job:
            job = self.jobs.pop(0)
            ray_id, ctx = job
            self.expect(ray_id, ctx)
            if ctx is not None:
                self.words.update((ray_id << 2 | i, w) for i, w in enumerate(ctx.words()))
            branch = self.mats[ctx.mat].branch if ctx else rng.randrange(2)
            dut.job_i.value = ray_id << 2 | (ctx is None) << 1 | branch
        dut.job_valid_i.value = job is not None
        gnt, ready, end_ready = rng.random() < self.p_gnt, rng.random() < self.p_ready, rng.random() < self.p_end
        dut.start_gnt_i.value, dut.sec_ready_i.value, dut.end_ready_i.value = gnt, ready, end_ready
        await RisingEdge(dut.clk_i)
        assert dut.job_ready_o.value
        want, re = bool(dut.start_o.value), bool(dut.ctx_re_o.value)
        assert not want or self.cycle % 5 == 4, "wants to start in another beat than the light unit"
        assert re == (bool(self.starts) and 1 <= self.cycle - self.starts[-1] <= 4), "reads outside its window"
        if re:
            dut.ctx_word_i.value = self.words[int(dut.ctx_addr_o.value)]
        elif rng.random() < 0.2:
            dut.ctx_word_i.value = rng.getrandbits(144)
        if want and gnt:
            self.starts.append(self.cycle)
        # a ray is told before it comes, so: first what is at the exit
        pending = int(dut.pending_o.value)
        if dut.sec_valid_o.value:
            word = int(dut.sec_o.value)
            assert self._held in (None, word), "the ray changed while it waited"
            self._held = word
            if ready:
                self.take_ray(word, pending)
                self._held = None
        if dut.end_valid_o.value and end_ready:
            ray_id = int(dut.end_id_o.value)
            assert self.expected.pop(ray_id, "nothing") is None, f"pixel {ray_id} ends"
            assert pending >> ray_id & 1 == bool(self.stacks[ray_id])
            self.out.append((ray_id, None))
        if dut.path_valid_o.value:
            word = int(dut.path_o.value)
            ray_id = word >> 100
            assert ray_id not in self.paths
            self.paths[ray_id] = unvec(word >> 28 & (1 << 72) - 1), word >> 4 & 0xFFFFFF, word & 15
        self.cycle += 1

    def take_ray(self, word, pending):
        ray_id, kind = word >> 235, word >> 233 & 3
        want = self.expected.pop(ray_id, None)
        assert want is not None, f"a ray of pixel {ray_id} nobody asked for"
        assert word >> 229 & 15 == 0
        assert word >> 168 & 0xFFFFFF == T_MIN and word >> 144 & 0xFFFFFF == HUGE
        w, length, depth = self.paths.pop(ray_id)
        assert depth == word >> 225 & 15
        got = kind, depth, word >> 192 & (1 << 33) - 1, unvec(word >> 72), unvec(word), w, length
        assert got == want, f"pixel {ray_id}: {show(got)}, not {show(want)}"
        assert pending >> ray_id & 1 == bool(self.stacks[ray_id]), f"pending of pixel {ray_id}"
        self.out.append((ray_id, got))

    async def run(self, jobs=()):
        """Give these jobs, then wait until all is out."""
        self.jobs += jobs
        patience = 3000 + 60 * len(self.jobs) / (self.p_gnt * min(self.p_ready, self.p_end) * self.p_job)
        limit = self.cycle + patience
        while self.jobs or self.expected:
            assert self.cycle < limit, f"hangs with pixels {sorted(self.expected)[:10]}"
            await self.step()
        for _ in range(4):
            await self.step()
        assert not self.dut.sec_valid_o.value and not self.dut.end_valid_o.value and not self.paths


def show(ray):
    kind, depth, tri, direction, org, w, length = ray
    return f"{kind} {depth} {tri:09x} dir {[f'{v:06x}' for v in direction]} org {[f'{v:06x}' for v in org]} " \
           f"w {[f'{v:06x}' for v in w]} len {length:06x}"


async def drain(bench):
    """Give the jobs that are left, and pop what is on the stacks, until all is out."""
    idle = 0
    while bench.jobs or bench.expected:
        count = len(bench.out)
        await bench.step()
        bench.jobs += [(i, None) for i, _ in bench.out[count:] if bench.stacks[i]]
        idle = idle + 1 if len(bench.out) == count else 0
        assert idle < 2000, f"hangs with pixels {sorted(bench.expected)[:10]}"
    assert not any(bench.stacks.values())


async def make(dut, *rates, **settings):
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), *rates, **settings)
    await bench.start()
    return bench


def some(count):
    """`count`, or a part of it on the builds with other latencies, which are there for the schedules."""
    return count if os.environ["BUILD"] == "paper-32" else max(1, count // 4)


async def walk(bench, num, pixels, bounces):
    """Whole pixels: bounce while that makes rays, now and then miss; then pop; until all are through. Checks the stacks."""
    rng = bench.rng
    waiting = list(range(pixels))                        # ids to be given a job
    left = bounces
    depth = Counter()
    done = 0
    idle = 0
    while waiting or bench.jobs or bench.expected:
        for ray_id in waiting:
            ctx = num.context(bench.mats)
            ctx.depth = depth[ray_id]
            stack = bench.stacks.get(ray_id)
            if left > 0 and depth[ray_id] < 15 and (depth[ray_id] == 0 or rng.random() < 0.8):
                bench.jobs.append((ray_id, ctx))
                left -= 1
            elif stack:
                bench.jobs.append((ray_id, None))
        waiting = []
        count = len(bench.out)
        await bench.step()
        idle = idle + 1 if count == len(bench.out) else 0
        assert idle < 20000, f"hangs with pixels {sorted(bench.expected)[:10]}"
        for ray_id, ray in bench.out[count:]:
            depth[ray_id] = ray[1] if ray else 15 if bench.stacks[ray_id] else 0
            waiting.append(ray_id)
            done += 1
    assert left <= 0 and not any(bench.stacks.values())
    assert int(bench.dut.pending_o.value) == 0
    return done


@cocotb.test(timeout_time=60, timeout_unit="ms")
@cocotb.parametrize(wild=[0.0, 0.02, 0.2], rates=[(1.0, 1.0, 1.0, 1.0), (0.3, 0.4, 0.1, 0.3), (1.0, 1.0, 0.03, 1.0)])
async def random_pixels(dut, wild, rates):
    """Paths of random materials, gaps and back-pressure, some or many operands being corners; far more pixels than stacks."""
    bench = await make(dut, *rates)
    num = Numbers(bench.rng, wild)
    for pixels, bounces in ((some(60), some(100)), (256, some(400))):
        await bench.load([num.material() for _ in range(bench.rng.choice([1, 20, 256]))],
                         bench.rng.choice([ZERO, *nearest([0.02, 0.1])]))
        await walk(bench, num, pixels, bounces)
    dut._log.info(f"{dict(bench.seen)}")


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def every_kind_of_child(dut):
    """Enough of random numbers has both children, one, none, total reflection, of every combination of flags."""
    bench = await make(dut)
    num = Numbers(bench.rng, 0.0)
    kinds = [dict(reflects=r, transmits=t, fresnel=f, tex_kr=k, alpha_mode=a)
             for r in (0, 1) for t in (0, 1) for f in (0, 1) for k in (0, 1) for a in (0, 1, 2)
             if not (t and a) and (r or t or a)]
    await bench.load([num.material(**k) for k in kinds], nearest([0.01])[0])
    await walk(bench, num, 256, some(1200))
    seen = bench.seen
    assert all(seen[k] > some(20) for k in ("2", "3", "23", "end", "pop", "tir")), seen


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def corner_contexts(dut):
    """Normal and grazing incidence, the edge of total reflection, m.d = 0 and > 0, normals of 0, NaN, infinities, weights of 0."""
    bench = await make(dut, 1.0, 0.9, 0.9, 0.9)
    num = Numbers(bench.rng, 0.0)
    rng = bench.rng
    half = np.sqrt(0.5)
    up, down, flat, slant = nearest([0, 1, 0]), nearest([0, -1, 0]), nearest([1, 0, 0]), nearest([half, -half, 0])
    iors = [*nearest([1, 1.5, 1 / 1.5, np.sqrt(2), half, 0, 2.0**40]), 0x3F0001, 0x3EFFFF, NAN, INF]
    ks = [[ONE] * 3, [ZERO] * 3, nearest([0.5, 0.25, 1]), [NAN, ONE, ZERO], [INF, ZERO, ONE], nearest([-0.5, 2, 1])]
    mats = []
    for flags in (dict(reflects=1), dict(transmits=1), dict(reflects=1, transmits=1), dict(reflects=1, alpha_mode=2),
                  dict(alpha_mode=2), dict(alpha_mode=1)):
        for fresnel in (0, 1):
            for _ in range(21):
                mats.append(Material(rng.choice(ks), rng.choice(ks), *[rng.choice(iors) for _ in range(2)], fresnel=fresnel,
                                     tex_kr=rng.randrange(2), **flags))
    await bench.load(mats)
    dirs = [down, flat, slant, up, nearest([1, -2.0**-10, 0]), nearest([1, -2.0**-17, 2.0**-9]), [ZERO] * 3, [NAN] * 3,
            [INF, ZERO, ZERO]]
    mds = [*nearest([-1, -half, -2.0**-10, -2.0**-17, 0, 1, 0.5]), 0x800000, 0x810000, 0x80FFFF, NAN, INF, 0xFF0000, 0xFE8000,
           0x7E8000]
    normals = [up, up, slant, [ZERO] * 3, [NAN, ONE, ZERO], nearest([0.1, 0.995, 0])]
    for _ in range(some(10)):
        jobs = []
        for ray_id in range(256):
            ctx = num.context(mats)
            d = rng.choice(dirs)
            md = rng.choice(mds) if rng.random() < 0.5 else bits([floats(up)[1] * floats(d)[1]])[0]
            ctx.d, ctx.md, ctx.g, ctx.m = d, md, rng.choice(normals), rng.choice(normals)
            ctx.p = rng.choice([ctx.p, [ZERO, 0x800000, 0x010000], [NAN, INF, 0xFF0000]])
            if mats[ctx.mat].alpha_mode:
                ctx.alpha = rng.choice([ZERO, ONE, ctx.alpha, NAN])
            ctx.w = rng.choice([[ONE] * 3, [ZERO] * 3, ctx.w, [0x010000, ZERO, NAN], [INF] * 3])
            jobs.append((ray_id, ctx))
        bench.jobs += jobs
        await drain(bench)


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def weight_threshold(dut):
    """A child is traced if a weight is larger than the limit, not if it is equal; never if the limit or all weights are NaN."""
    bench = await make(dut)
    num = Numbers(bench.rng, 0.0)
    mats = [Material([ONE] * 3, [ONE] * 3, ONE, ONE, reflects=True), Material([ONE] * 3, [ONE] * 3, ONE, ONE, alpha_mode=2)]
    for limit in (*nearest([0.25, 2.0**-60, 0, -1, 1]), NAN, INF, 0x800000, 0x010000):
        await bench.load(mats, limit)
        jobs = []
        for i in range(96):
            ctx = num.context(mats, i % 2)
            levels = [limit, (limit + 1) & 0xFFFFFF, (limit - 1) & 0xFFFFFF, ZERO, NAN]
            ctx.w = [levels[i // 2 % 5] if i // 10 % 3 == k else bench.rng.choice([limit, ZERO, NAN]) for k in range(3)]
            ctx.alpha, ctx.tex = (ZERO if i % 2 else ONE), [ONE] * 3
            jobs.append((i, ctx))
        await bench.run(jobs)
    assert bench.seen["end"] > 100 and bench.seen["2"] > 50 and bench.seen["3"] > 50, bench.seen


def glass(num):
    """A material whose bounces always have two children, seen from straight above."""
    return num.material(reflects=True, transmits=True, fresnel=False)


def straight(num, mats, depth=0):
    ctx = num.context(mats, 0)
    ctx.d = [b ^ 0x800000 for b in ctx.m]
    ctx.g, ctx.md, ctx.inside, ctx.depth = ctx.m, 0xBF0000, False, depth
    ctx.w = ctx.tex = [ONE] * 3
    return ctx


@cocotb.test(timeout_time=60, timeout_unit="ms")
@cocotb.parametrize(levels=[1, 3])
async def all_pixels_branch_at_once(dut, levels):
    """All 256 pixels want a stack; those that have one go on, end and pop; all get through, with no more stacks than there are."""
    bench = await make(dut, p_gnt=0.8)
    num = Numbers(bench.rng, 0.0)
    mats = [glass(num)]
    await bench.load(mats)
    bench.jobs = [(i, straight(num, mats)) for i in range(256)]
    depth = Counter()
    stacks = int(os.environ["BUILD"].split("-")[1])
    idle = 0
    while bench.jobs or bench.expected:
        count = len(bench.out)
        await bench.step()
        idle = idle + 1 if len(bench.out) == count else 0
        assert idle < 1000, "hangs"
        assert bin(int(dut.pending_o.value)).count("1") <= stacks
        for ray_id, _ in bench.out[count:]:
            depth[ray_id] += 1
            if depth[ray_id] < levels:
                bench.jobs.append((ray_id, straight(num, mats, depth[ray_id])))
            elif bench.stacks[ray_id]:
                bench.jobs.append((ray_id, None))
    assert len(bench.out) == 256 * 2 * levels


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def fifteen_rays_on_a_stack(dut):
    """As many pixels as there are stacks fill them with 15 rays each; they come back last in, first out."""
    bench = await make(dut)
    num = Numbers(bench.rng, 0.0)
    mats = [glass(num)]
    await bench.load(mats)
    ids = bench.rng.sample(range(256), min(8, int(os.environ["BUILD"].split("-")[1])))
    for depth in range(15):
        await bench.run([(i, straight(num, mats, depth)) for i in ids])
    assert all(len(bench.stacks[i]) == 15 for i in ids)
    bench.out.clear()
    for _ in range(15):
        await bench.run([(i, None) for i in ids])
    for i in ids:
        assert [ray[1] for ray_id, ray in bench.out if ray_id == i] == list(range(15, 0, -1))
    assert int(dut.pending_o.value) == 0
    # and the stacks are free again
    await bench.run([(i, straight(num, mats)) for i in ids])


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def one_ray_in_five_cycles(dut):
    """A ray is made in five cycles as long as jobs are there, rays are taken and windows granted."""
    bench = await make(dut)
    num = Numbers(bench.rng, 0.0)
    mats = [num.material(reflects=True), glass(num)]
    await bench.load(mats)
    await bench.run([(i, num.context(mats, 0)) for i in range(200)])
    starts = bench.starts[:-1]
    assert len(starts) == 199 and set(np.diff(starts)) == {5}


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def waits_for_the_exit(dut):
    """Nobody takes rays, ends go on: the unit fills, stops starting jobs, loses nothing, then goes on."""
    bench = await make(dut, 1.0, 1.0, 0.0, 1.0)
    num = Numbers(bench.rng, 0.0)
    mats = [glass(num), num.material(reflects=True)]
    await bench.load(mats)
    bench.jobs = [(i, straight(num, mats) if i % 2 else num.context(mats, 1)) for i in range(256)]
    for _ in range(1500):
        await bench.step()
    started = len(bench.starts)
    for _ in range(300):
        await bench.step()
    assert len(bench.starts) == started < 100
    bench.p_ready = 0.5
    bench.jobs += [(i, None) for i, _ in bench.out if bench.stacks[i]]
    await drain(bench)


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def shut_end_does_not_stop_rays(dut):
    """Nobody takes ends: 200 of them wait inside while rays go on."""
    bench = await make(dut, 1.0, 1.0, 1.0, 0.0)
    num = Numbers(bench.rng, 0.0)
    mats = [num.material(reflects=True), Material([ZERO] * 3, [ZERO] * 3, ONE, ONE, reflects=True)]
    await bench.load(mats)
    bench.jobs = [(i, num.context(mats, 1)) for i in range(200)] + [(i, num.context(mats, 0)) for i in range(200, 256)]
    for _ in range(1800):
        await bench.step()
    assert sorted(i for i, _ in bench.out) == list(range(200, 256)) and len(bench.expected) == 200
    bench.p_end = 1.0
    await bench.run()


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def fair_to_waiting_jobs(dut):
    """While plain jobs never run out, jobs that need a stack start too, and the other way round."""
    bench = await make(dut)
    num = Numbers(bench.rng, 0.0)
    mats = [glass(num), num.material(reflects=True)]
    await bench.load(mats)
    plain, branch = list(range(128)), list(range(128, 256))
    done = Counter()
    free = plain + branch
    for _ in range(4000):
        for i in free:
            bench.jobs.append((i, None) if bench.stacks.get(i) else (i, straight(num, mats) if i >= 128 else num.context(mats, 1)))
        count = len(bench.out)
        await bench.step()
        free = [i for i, _ in bench.out[count:]]
        done.update(free)
    assert min(done[i] for i in plain) >= 1 and sum(done[i] > 0 for i in branch) >= 20, done
    bench.jobs = [job for job in bench.jobs if job[1] is None] + [(i, None) for i in free if bench.stacks.get(i)]
    await drain(bench)


@pytest.mark.parametrize("latencies, stacks", [("paper", 32), ("paper", 1), ("paper", 2), ("one", 32), ("deep", 2), ("odd", 5),
                                               ("long", 256)])
def test_rc_secondary(latencies, stacks):
    """The same tests on builds with other latencies of the functional units, and other numbers of stacks."""
    files = rtl(*FILES, package=False)
    run_cocotb("rc_secondary", [package_with_latencies(**LATENCIES[latencies]), *files], "test_rc_secondary",
               parameters={"NumStacks": stacks}, defines={"LATENCIES": latencies}, env={"BUILD": f"{latencies}-{stacks}"})
