# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_hitpoint against raycore.model.shade.hit_point and coverage: every word of context and every hit point told to the
shading buffer, in order, bit for bit; one ray in four cycles."""

import random
from collections import deque
from dataclasses import dataclass, field

import cocotb
import pytest
import shade_tb as sh
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import shade


@dataclass
class Hit:
    """All that the unit is told of a ray that hit something, as patterns."""

    ray_id: int
    org: list
    dir: list
    at: tuple                                        # t, beta, gamma
    tri: sh.Triangle
    w: list
    len: int
    depth: int
    tex: list
    ta: int

    @classmethod
    def random(cls, num, ray_id, tri):
        return cls(ray_id, num.point(), num.direction(), sh.random_weights(num), tri, num.color(),
                   *num.spoil(sh.nearest([num.rng.uniform(0, 20)])), num.rng.randrange(16), num.color(),
                   *num.spoil(sh.nearest([num.rng.random()])))


@dataclass
class Bench:
    """Gives hits to rc_hitpoint, one cycle a step, and checks all that comes out."""

    dut: object
    rng: random.Random
    p_valid: float = 1.0
    p_ready: float = 1.0
    cycle: int = 0
    words: list = field(default_factory=list)        # (address, patterns) expected, in order
    points: list = field(default_factory=list)
    errors: list = field(default_factory=list)
    taken_at: list = field(default_factory=list)
    hits: object = None
    max_depth: int = 15
    mats: list = field(default_factory=list)
    mat_count: int = 256
    kinds: set = field(default_factory=set)
    _next: object = None

    async def start(self):
        Clock(self.dut.clk_i, 10, unit="ns").start()
        for name in ("rst_ni", "in_valid_i", "ld_mat_valid_i", "out_ready_i"):
            getattr(self.dut, name).value = 0
        for _ in range(3):
            await RisingEdge(self.dut.clk_i)
        self.dut.rst_ni.value = 1

    async def set_frame(self, mats, max_depth=15, mat_count=256):
        assert not self.words
        self.mats, self.max_depth, self.mat_count = mats, max_depth, mat_count
        self.dut.max_depth_i.value = max_depth
        self.dut.mat_count_i.value = mat_count
        await sh.load(self.dut, [(sh.LD_MATERIAL, i, m.line) for i, m in enumerate(mats)], "ld_mat_valid_i")

    def expect(self, hit):
        index = hit.tri.mat & 0xFF
        mat = self.mats[index]
        ctx = sh.Context.of_hit(hit.org, hit.dir, *hit.at, hit.tri, hit.len)
        axes, md = ctx.words
        for i in range(3):
            self.words.append((hit.ray_id << 2 | i, [*(axes[k][i] for k in range(4)), hit.tex[i], hit.w[i]]))
        alpha = sh.bits([shade.FP24.coverage(sh.floats([hit.ta])[0], mat.record)])[0]
        length = sh.bits([ctx.length])[0]
        self.words.append((hit.ray_id << 2 | 3, [md, index, hit.ray_id * 7_777_777, alpha, length, hit.depth, int(ctx.inside)]))
        children = mat.reflects + (mat.transmits or mat.mode != shade.ALPHA_OPAQUE)
        self.points.append(sh.point_word(hit.ray_id, index, children > 0 and hit.depth < self.max_depth, children == 2, alpha,
                                         hit.tex))
        self.kinds.add((mat.mode, alpha == 0, mat.reflects, mat.transmits, hit.depth < self.max_depth, bool(ctx.inside)))
        if hit.tri.mat >= self.mat_count:
            self.errors.append(9 << 32 | hit.tri.mat)

    async def step(self):
        dut, rng = self.dut, self.rng
        if self._next is None and rng.random() < self.p_valid:
            self._next = hit = next(self.hits)
            word = sh.hit_word(hit.ray_id, 0, 1, rng.randrange(2), hit.tri.mat, hit.ray_id * 7_777_777, *hit.at)
            dut.in_i.value, dut.in_info_i.value = sh.tex_word(word, hit.tex, hit.ta), hit.tri.line
        dut.in_valid_i.value = self._next is not None
        ready = rng.random() < self.p_ready
        dut.out_ready_i.value = ready
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        if dut.ctx_valid_o.value:
            assert self.words, "a word nobody asked for"
            address, want = self.words.pop(0)
            assert int(dut.ctx_addr_o.value) == address
            word = int(dut.ctx_word_o.value)
            if address & 3 == 3:
                got = [word & 0xFFFFFF, word >> 24 & 0xFF, word >> 32 & (1 << 33) - 1, word >> 65 & 0xFFFFFF,
                       word >> 89 & 0xFFFFFF, word >> 113 & 15, word >> 117]
                assert got == want, f"md, mat, triangle, alpha', len', depth, inside are {got}, not {want}"
            else:
                got = [word >> s & 0xFFFFFF for s in range(0, 144, 24)]
                assert got[0] == want[0] and got[2] == want[2] and got[4:] == want[4:] and sh.same(got, want), (
                    f"P g m d tex w of word {address & 3} are {[f'{g:06x}' for g in got]}, not {[f'{w:06x}' for w in want]}")
        if dut.out_valid_o.value and ready:
            assert len(self.points) > len(self.words) // 4, "a hit point before its context"
            assert int(dut.out_o.value) == self.points.pop(0)
        if dut.err_valid_o.value:
            assert self.errors and int(dut.err_o.value) == self.errors.pop(0)
        if self._next is not None and dut.in_ready_o.value:
            hit, self._next = self._next, None
            self.expect(hit)
            dut.org_i.value, dut.dir_i.value, dut.w_i.value = sh.vec(hit.org), sh.vec(hit.dir), sh.vec(hit.w)
            dut.len_i.value, dut.depth_i.value = hit.len, hit.depth
            self.taken_at.append(self.cycle)

    async def run(self, hits):
        """Give these hits, then wait until all is out."""
        hits = list(hits)
        self.hits, count, limit = iter(hits), len(self.taken_at) + len(hits), self.cycle + 500 + len(hits) * 100
        p, idle = self.p_valid, 0
        while idle < 5:
            if len(self.taken_at) + (self._next is not None) == count:
                self.p_valid = 0.0
            assert self.cycle < limit, f"hangs with {len(self.points)} rays inside"
            await self.step()
            idle = 0 if self.points or self._next or len(self.taken_at) < count else idle + 1
        assert not self.words and not self.errors
        self.p_valid = p


def materials(num, count=256):
    return [sh.Material.random(num) for _ in range(count)]


def random_hits(num, count, mats=256):
    for i in range(count):
        yield Hit.random(num, i % 256, sh.Triangle.random(num, num.rng.randrange(mats)))


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(wild=[0.0, 0.02, 0.4], p_valid=[1.0, 0.2, 0.05], p_ready=[1.0, 0.1])
async def random_rays(dut, wild, p_valid, p_ready):
    """Flat and smooth triangles seen from both sides, any material, depth and texture, with gaps and back-pressure, some or
    many operands being corners."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_valid, p_ready)
    num = sh.Numbers(bench.rng, wild)
    await bench.start()
    await bench.set_frame(materials(num), bench.rng.choice([0, 1, 7, 15]))
    await bench.run(random_hits(num, sh.some(200)))
    dut._log.info(f"{len(bench.kinds)} kinds of hit point")


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def corner_rays(dut):
    """Grazing rays (n . d is +-0 or tiny), no vertex normal, huge ones, the origin in the plane."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    await bench.set_frame(materials(num))
    one, zero, tiny, huge = 0x3F0000, 0, 0x010000, 0x7E8000
    origin, hits = sh.nearest([0.25, -0.5, 0.75]), []
    for n in ([zero, one, zero], [zero, 0xBF0000, zero], [zero, one, tiny], [zero, one, 0x810000]):
        for d in ([one, zero, zero], [one, 0x800000, zero], [zero, zero, 0xBF0000], [zero, one, zero], [zero, tiny, one]):
            for n0 in (n, [zero] * 3, [huge] * 3, [tiny] * 3, [0x200000] * 3):
                hit = Hit.random(num, len(hits) % 256, sh.Triangle(origin, n, n0, [zero] * 3, [zero] * 3, 3))
                hit.org, hit.dir, hit.at = origin, d, tuple(sh.nearest([1.0, 0.3, 0.3]))
                hits.append(hit)
    await bench.run(hits)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def cutoffs(dut):
    """The texture's alpha times the material's against the cutoff, around equality and with zeros, infinities, NaN."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), 0.5)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    mats = materials(num)
    edge = [0x000000, 0x800000, 0x000001, 0x010000, 0x3E0000, 0x3EFFFF, 0x3F0000, 0xBF0000, 0x7F0000, sh.NAN_BITS]
    for mat in mats:
        mat.mode, mat.transmits = bench.rng.choice([shade.ALPHA_MASK, shade.ALPHA_MASK, shade.ALPHA_BLEND]), False
        mat.alpha, mat.cutoff = bench.rng.choice([0x3F0000, *edge]), bench.rng.choice(edge)
    await bench.set_frame(mats)
    hits = list(random_hits(num, sh.some(800)))
    for hit in hits:
        cutoff = mats[hit.tri.mat].cutoff
        hit.ta = bench.rng.choice([cutoff, max(cutoff - 1, 0), min(cutoff + 1, 0xFFFFFF), *edge])
    await bench.run(hits)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def unknown_material(dut):
    """A material index beyond the count is reported with its number, exactly then."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), 0.7)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    for count in (1, 7, 256):
        await bench.set_frame(materials(num), 15, count)
        hits = list(random_hits(num, 40, 14 if count < 256 else 4096))
        hits += [Hit.random(num, i, sh.Triangle.random(num, m)) for i, m in enumerate((count - 1, count, 4095))]
        await bench.run(hits)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def one_ray_in_four_cycles(dut):
    """The rate is that of the beats as long as hits are offered and hit points are taken; none is lost when they are not."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    await bench.set_frame(materials(num))
    await bench.run(random_hits(num, 100))
    assert {b - a for a, b in zip(bench.taken_at[:-1], bench.taken_at[1:])} == {4}
    bench.hits, bench.p_ready, before = random_hits(num, 300), 0.0, len(bench.taken_at)
    for _ in range(400):
        await bench.step()
    bench.p_ready, bench.p_valid = 1.0, 0.0
    waiting = deque(bench.hits)
    assert 12 < len(bench.taken_at) - before < 100 and waiting
    await bench.run([])


@pytest.mark.parametrize("latencies", sh.LATENCIES)
def test_rc_hitpoint(latencies):
    """The same tests on builds with other latencies of the functional units."""
    sh.run("rc_hitpoint", latencies, ["shade/rc_hitpoint.sv"], "test_rc_hitpoint")
