# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_texture against raycore.model.texture: every colour, in order, bit for bit; rates, and both caches' counts."""

import os
import random
from collections import deque

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore import texture as tx
from raycore.image import pack_records
from raycore.model import fp24
from raycore.model import texture as model
from raycore.tbutil import package_with_latencies, rtl, run_cocotb

UV_BASE, TEX_BASE = 0x123456, 0x3000001
CORNERS = [0x000000, 0x800000, 0x010000, 0x3F0000, 0xBF0000, 0x7EFFFF, 0xFEFFFF, 0x7F0000, 0xFF0000, fp24.NAN_BITS, 0x7F0001,
           0xFFFFFF, 0x00FFFF, 0x460000, 0x560000, 0x4A0001, 0xCA0001]  # fmt: skip
WORD = (1 << 60) - 1
LATENCIES = {
    "paper": {},
    "one": dict(ADD=1, MUL=1, CONV=1),
    "deep": dict(ADD=5, MUL=4, CONV=3),
    "long": dict(ADD=7, MUL=6, CONV=5),
}
BUILD = os.environ.get("BUILD", "paper")  # a set of latencies, or "small"


def number(pattern):
    return float(fp24.from_bits(np.array(pattern)))


def nearest(value):
    return int(fp24.to_bits(fp24.round_to_fp24(np.float64(value))))


def some(count):
    """`count`, or a part of it on builds that are there for schedules and queues."""
    return count if BUILD == "paper" else max(1, count // 4)


class World:
    """Random textures, materials and triangles, as memory has them and as the model wants them."""

    def __init__(self, rng, wild=0.1, textures=12, triangles=40, most=(8, 6)):
        self.rng, self.wild = rng, wild
        self.descs, at = [], rng.randrange(4)
        for _ in range(textures):
            w, h = rng.randint(0, most[0]), rng.randint(0, most[1])
            if rng.random() < 0.2:
                w, h = h, w
            full = max(w, h) + 1
            levels = full if rng.random() < 0.6 else rng.randint(1, min(full + 2, 13))
            desc = np.array([at, w, h, levels, *(rng.choice([0, 0, 1, 2, 2, 3]) for _ in "st"), rng.random() < 0.5,
                             rng.random() < 0.5, 0, 0], dtype=np.int64)  # fmt: skip
            self.descs.append(desc)
            at += int(model.level_offset(w, h, desc[6], levels)) + rng.randrange(3)
        self.region = np.frombuffer(rng.randbytes(64 * at), dtype=np.uint8)
        self.materials = [rng.randrange(textures) for _ in range(256)]
        lines = [0, 1, (1 << 23) - 1, *(rng.randrange(1 << 23) for _ in range(triangles // 2))]
        self.records = {2 * line + odd: self.triangle() for line in lines for odd in (0, 1)}
        self.bias, self.trilinear = 0, False

    def pattern(self, value):
        """The FP24 pattern of a value, or sometimes of anything."""
        rng = self.rng
        if rng.random() < self.wild:
            return rng.choice(CORNERS) if rng.random() < 0.5 else rng.randrange(1 << 24)
        return nearest(value)

    def triangle(self):
        """(patterns of u0 v0 du1 dv1 du2 dv2, mip)."""
        rng = self.rng
        size = 2.0 ** rng.choice([-4, 0, 0, 0, 3])
        return [self.pattern(rng.uniform(-size, size)) for _ in range(6)], rng.randint(-150, 150)

    def uv_line(self, addr):
        line = 0
        for odd in (0, 1):
            uv, mip = self.records.get(2 * ((addr - UV_BASE) % (1 << 26)) + odd, ([0] * 6, 0))
            names = ("u0", "v0", "du1", "dv1", "du2", "dv2")
            words = pack_records(
                tx.TRI_UV, {"mip": np.array([mip & 0xFFF])} | {n: np.array([v]) for n, v in zip(names, uv)}
            )[0]
            for k, word in enumerate(words):
                line |= int(word) << (60 * (4 * odd + k))
        return line

    def block(self, addr):
        at = 64 * ((addr - TEX_BASE) % (1 << 26))
        return int.from_bytes(self.region[at : at + 64].tobytes(), "little")

    def desc_word(self, desc):
        """The low 44 bits of word 4 of optics_t."""
        word, low = 0, 0
        for value, width in zip(desc, (26, 4, 4, 4, 2, 2, 1, 1)):
            word |= int(value) << low
            low += width
        return word

    def optics(self, desc):
        """A record with rubbish in all other fields."""
        mask = WORD << 240
        return self.rng.getrandbits(480) & ~mask | (self.desc_word(desc) | self.rng.getrandbits(16) << 44) << 240

    def hit(self):
        """(hit_t, length) at random: three quarters of the lengths choose a level, the rest is anything."""
        rng = self.rng
        t = self.pattern(2.0 ** rng.uniform(-3, 8))
        length = self.pattern(rng.choice([0.0, 2.0 ** rng.uniform(-3, 8)]))
        beta, gamma = (self.pattern(rng.random() / 2) for _ in range(2))
        head = (
            rng.getrandbits(8) << 15
            | rng.getrandbits(1) << 14
            | 1 << 13
            | rng.getrandbits(1) << 12
            | rng.getrandbits(12)
        )
        surf = rng.getrandbits(9) << 24 | rng.choice(list(self.records))
        return (((head << 33 | surf) << 24 | t) << 24 | beta) << 24 | gamma, length

    def what(self, hit, length):
        """(arguments of the model for a hit)."""
        desc = self.descs[self.materials[hit >> 105 & 0xFF]]
        uv, mip = self.records[hit >> 72 & 0xFFFFFF]
        t, beta, gamma = (number(hit >> s & 0xFFFFFF) for s in (48, 24, 0))
        row = np.array([*(number(p) for p in uv), mip], dtype=np.float64)
        return desc, row, beta, gamma, fp24.fadd(number(length), t)

    def expect(self, hit, length):
        """tex_t."""
        r, g, b, a = (int(fp24.to_bits(np.float64(c)))
                      for c in model.sample24(self.region, *self.what(hit, length), self.bias, self.trilinear))  # fmt: skip
        return hit << 96 | b << 72 | g << 48 | r << 24 | a

    def blocks(self, hit, length):
        """Blocks that a hit looks up: a list of sets, one a level."""
        desc, uv, beta, gamma, path = self.what(hit, length)
        u = fp24.fadd(fp24.fadd(uv[0], fp24.fmul(beta, uv[2])), fp24.fmul(gamma, uv[4]))
        v = fp24.fadd(fp24.fadd(uv[1], fp24.fmul(beta, uv[3])), fp24.fmul(gamma, uv[5]))
        level, fl = model.choose_level(path, uv[6], self.bias, desc[3], self.trilinear)
        out = []
        for k in range(level, level + (2 if fl else 1)):
            at = []
            for coord, log2_size, wrap in ((u, desc[1], desc[4]), (v, desc[2], desc[5])):
                size = max(log2_size - k, 0)
                first = model.fixed_coord(coord, size, wrap) >> 8
                at.append([model.wrap_texel(first + i, size, wrap) for i in (0, 1)])
            out.append({(int(desc[0]), k, int(x) >> (3 if desc[6] else 2), int(y) >> 2) for x in at[0] for y in at[1]})
        return out


class Memory:
    """One client's memory: answers in order, late, when asked."""

    def __init__(self, dut, name, answer, content, latency, p_req):
        self.valid, self.ready, self.addr = (getattr(dut, f"{name}_req_{s}") for s in ("valid_o", "ready_i", "addr_o"))
        self.answer_valid, self.answer = getattr(dut, f"{name}_rsp_valid_i"), getattr(dut, f"{name}_rsp_{answer}_i")
        self.content, self.latency, self.p_req = content, latency, p_req
        self.queue, self.count, self.most, self.asked = deque(), 0, 0, None

    def drive(self, now):
        self.ready.value = random.random() < self.p_req
        due = bool(self.queue) and self.queue[0][1] <= now
        self.answer_valid.value = due
        if due:
            self.answer.value = self.content(self.queue.popleft()[0])

    def sample(self, now):
        if not self.valid.value:
            assert self.asked is None, "a request was taken back"
            return
        addr = int(self.addr.value)
        assert self.asked in (None, addr), "a request changed while it waited"
        self.asked = addr
        if self.ready.value:
            self.asked = None
            due = max(now + self.latency(), self.queue[-1][1] + 1 if self.queue else 0)
            self.queue.append((addr, due))
            self.count += 1
            self.most = max(self.most, len(self.queue))


class Bench:
    def __init__(self, dut, world, latency=lambda: 20, p_in=1.0, p_out=1.0, p_req=1.0):
        self.dut, self.world, self.p_in, self.p_out = dut, world, p_in, p_out
        self.uv = Memory(dut, "uv", "line", world.uv_line, latency, p_req)
        self.tex = Memory(dut, "tex", "block", world.block, latency, p_req)
        self.todo, self.inside, self.held, self.now, self.done = deque(), deque(), False, 0, 0
        self.events = dict.fromkeys(("uv_hit", "uv_miss", "tex_hit", "tex_miss"), 0)
        self.waits, self.lookups = None, [0, 0]

    async def load(self):
        """All materials, and records of other kinds that must not count, in any order."""
        dut = self.dut
        jobs = [(2, i, self.world.optics(self.world.descs[m])) for i, m in enumerate(self.world.materials)]
        jobs += [(random.choice([0, 1]), random.randrange(256), random.getrandbits(480)) for _ in range(60)]
        random.shuffle(jobs)
        for kind, idx, line in jobs:
            dut.ld_valid_i.value, dut.ld_kind_i.value, dut.ld_idx_i.value, dut.ld_line_i.value = 1, kind, idx, line
            await RisingEdge(dut.clk_i)
        dut.ld_valid_i.value = 0
        dut.ld_line_i.value = random.getrandbits(480)
        dut.uv_base_i.value, dut.tex_base_i.value = UV_BASE, TEX_BASE
        self.set_frame()

    def set_frame(self):
        self.dut.mip_bias_i.value = self.world.bias & 0xFFF
        self.dut.trilinear_i.value = self.world.trilinear

    async def cycle(self):
        dut = self.dut
        self.held = bool(self.todo) and (self.held or random.random() < self.p_in)
        dut.in_valid_i.value = self.held
        if self.held:
            hit, length = self.todo[0]
            dut.in_i.value = hit << 24 | length
        dut.out_ready_i.value = random.random() < self.p_out
        self.uv.drive(self.now)
        self.tex.drive(self.now)
        await FallingEdge(dut.clk_i)
        if self.held and dut.in_ready_o.value:
            job = self.todo.popleft()
            self.inside.append((self.world.expect(*job), job))
            self.lookups = [self.lookups[0] + 1, self.lookups[1] + sum(map(len, self.world.blocks(*job)))]
            self.held = False
        if dut.out_valid_o.value:
            got = int(dut.out_o.value)
            assert self.waits in (None, got), "the output changed while it waited"
            self.waits = got
            if dut.out_ready_i.value:
                self.waits = None
                assert self.inside, "a result nobody asked for"
                want, job = self.inside.popleft()
                assert got >> 96 == want >> 96, f"hit {got >> 96:x}, not {want >> 96:x}: lost, changed or out of order"
                assert got == want, (f"r g b a {[f'{got >> s & 0xFFFFFF:06x}' for s in (24, 48, 72, 0)]}, not "
                                     f"{[f'{want >> s & 0xFFFFFF:06x}' for s in (24, 48, 72, 0)]} for {self.world.what(*job)} "
                                     f"bias {self.world.bias} trilinear {self.world.trilinear}")  # fmt: skip
                self.done += 1
        else:
            assert self.waits is None, "a result was taken back"
        self.uv.sample(self.now)
        self.tex.sample(self.now)
        for name in self.events:
            self.events[name] += int(getattr(dut, f"ev_{name}_o").value)
        self.now += 1
        await RisingEdge(dut.clk_i)

    async def run(self, jobs, limit=None):
        self.todo.extend(jobs)
        limit = self.now + (limit or 3000 + 3000 * len(self.todo))
        while self.todo or self.inside:
            await self.cycle()
            assert self.now < limit, f"hangs with {len(self.inside)} hits inside"

    def check_counts(self):
        """Every hit looks up one record and each block of its footprints once; every miss is one request."""
        assert self.events["uv_hit"] + self.events["uv_miss"] == self.lookups[0]
        assert self.events["tex_hit"] + self.events["tex_miss"] == self.lookups[1]
        assert (self.events["uv_miss"], self.events["tex_miss"]) == (self.uv.count, self.tex.count)


async def reset(dut):
    dut.rst_ni.value = 0
    clients = [f"{c}_{s}_i" for c in ("uv", "tex") for s in ("req_ready", "rsp_valid")]
    for name in ("in_valid_i", "out_ready_i", "ld_valid_i", *clients):
        getattr(dut, name).value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


async def start(dut, wild=0.0, **use):
    """Clock, reset; a bench on random textures, loaded."""
    Clock(dut.clk_i, 10, unit="ns").start()
    await reset(dut)
    bench = Bench(dut, World(random.Random(random.getrandbits(32)), wild), **use)
    await bench.load()
    return bench


@cocotb.test(timeout_time=60, timeout_unit="ms")
@cocotb.parametrize(latency=[1, 30, 400], gaps=["none", "in", "out"], trilinear=[False, True])
async def random_hits(dut, latency, gaps, trilinear):
    """Textures of all shapes, coordinates of all kinds, gaps everywhere; another frame; then a reset in mid-flight."""
    use = dict(latency=lambda: random.randint(1, 2 * latency), p_in=0.1 if gaps == "in" else 1.0,
               p_out=0.1 if gaps == "out" else 1.0, p_req=random.choice([0.2, 1.0]))  # fmt: skip
    bench = await start(dut, random.choice([0.0, 0.05, 0.3]), **use)
    world = bench.world
    for _ in range(2):
        for bias in (-2048, 2047, *(random.randint(-300, 300) for _ in range(2))):
            world.bias, world.trilinear = bias, trilinear
            bench.set_frame()
            await bench.run([world.hit() for _ in range(some(50 if latency < 400 else 25))])
        bench.check_counts()
        bench.todo.extend(world.hit() for _ in range(100))
        for _ in range(random.randint(1, 400)):
            await bench.cycle()
        await reset(dut)
        bench = Bench(dut, world, **use)


async def plain(bench, log2_w, log2_h, levels, *kind):
    """Gives a bench one texture of a kind (wraps, rgba5551, srgb), empties the unit, and returns its world."""
    world = bench.world
    desc = np.array([5, log2_w, log2_h, levels, *kind, 0, 0], dtype=np.int64)
    world.descs, world.materials = [desc], [0] * 256
    blocks = int(model.level_offset(log2_w, log2_h, desc[6], levels)) + 5
    world.region = np.frombuffer(world.rng.randbytes(64 * blocks), dtype=np.uint8)
    await reset(bench.dut)
    await bench.load()
    return world


def place(u, v, mat=0):
    """A hit on triangle 0, whose record maps beta to u and gamma to v: t = 1."""
    return ((((mat | 1 << 13) << 33 | 0) << 24 | 0x3F0000) << 24 | nearest(u)) << 24 | nearest(v), 0


UNIT_RECORD = ([0, 0, 0x3F0000, 0, 0, 0x3F0000], 0)


@cocotb.test(timeout_time=60, timeout_unit="ms", skip=BUILD not in ("paper", "small"))
@cocotb.parametrize(rgba5551=[0, 1], srgb=[0, 1])
async def every_value(dut, rgba5551, srgb):
    """All bytes in all channels, or all values of 5 bits, each seen alone at the centre of its texel."""
    bench = await start(dut)
    world = await plain(bench, 4, 4, 1, 0, 0, rgba5551, srgb)
    world.records[0] = UNIT_RECORD
    if rgba5551:
        data = np.arange(256, dtype=np.uint16) * 257
    else:
        data = np.arange(256, dtype=np.uint32) * 0x01010101
    region = np.zeros(5 * 64, np.uint8)
    image = data.reshape(16, 16)
    wide = 8 if rgba5551 else 4
    blocks = image.reshape(4, 4, 16 // wide, wide).transpose(0, 2, 1, 3)
    world.region = np.concatenate([region, np.ascontiguousarray(blocks).reshape(-1).view(np.uint8)])
    await bench.run([place((x + 0.5) / 16, (y + 0.5) / 16) for y in range(16) for x in range(16)])


@cocotb.test(timeout_time=60, timeout_unit="ms", skip=BUILD not in ("paper", "small"))
async def every_length(dut):
    """Each entry of the table of logarithms, seen in the weight of the next level; lengths of all exponents."""
    bench = await start(dut)
    world = await plain(bench, 5, 5, 6, 0, 0, 0, 0)
    world.records[0], world.bias, world.trilinear = UNIT_RECORD, 70, True
    bench.set_frame()
    lengths = [(0x3F + random.randint(0, 2)) << 16 | i << 10 | random.randrange(1024) for i in range(64)]
    lengths += [e << 16 | random.randrange(1 << 16) for e in range(128)]
    place_only = place(0.37, 0.61)[0] & ~(0xFFFFFF << 48)
    await bench.run([(place_only | t << 48, 0) for t in lengths])


@cocotb.test(timeout_time=60, timeout_unit="ms", skip=BUILD not in ("paper", "small"))
@cocotb.parametrize(wrap=[0, 1, 2], rgba5551=[0, 1])
async def edges(dut, wrap, rgba5551):
    """Positions round the edges of every level of small textures, where neighbours wrap."""
    bench = await start(dut)
    for log2_w, log2_h in ((0, 0), (1, 0), (2, 1), (3, 5), (4, 2)):
        world = await plain(bench, log2_w, log2_h, 6, wrap, wrap, rgba5551, 0)
        world.records = {2 * k: (UNIT_RECORD[0], 64 * k) for k in range(6)}
        jobs = []
        for k in range(6):
            w, h = 1 << max(log2_w - k, 0), 1 << max(log2_h - k, 0)
            for _ in range(some(25)):
                x = random.choice([-w, 0, w, 2 * w]) + random.choice([-1.5, -0.5, -0.25, 0, 0.125, 0.5, 1.5])
                y = random.choice([-h, 0, h, 2 * h]) + random.choice([-1.5, -0.5, -0.25, 0, 0.125, 0.5, 1.5])
                jobs.append((place(x / w, y / h)[0] | 2 * k << 72, 0))
        await bench.run(jobs)


@cocotb.test(timeout_time=60, timeout_unit="ms", skip=BUILD != "paper")
@cocotb.parametrize(rgba5551=[0, 1])
async def all_offsets(dut, rgba5551):
    """Every level of every shape up to 4096x4096: the block asked for is the one that the model's offset tells."""
    bench = await start(dut)
    world = await plain(bench, 0, 0, 1, 2, 2, rgba5551, 0)
    shapes = [(w, h) for w in range(13) for h in range(13)]
    random.shuffle(shapes)
    world.records = {2 * k: ([0] * 6, 64 * k) for k in range(13)}  # the corner: one block a level
    world.block = lambda addr: random.Random(addr).getrandbits(512)
    for first in range(0, some(len(shapes)), 64):
        part = shapes[first : first + 64]
        world.descs = [
            np.array([1000 + i, w, h, max(w, h) + 1, 2, 2, rgba5551, 0, 0, 0]) for i, (w, h) in enumerate(part)
        ]
        world.materials = [i % len(part) for i in range(256)]
        await bench.load()
        await reset(dut)
        bench.inside.clear()
        world.expect = lambda hit, length: hit << 96  # the addresses matter here
        asked, due = [], []
        bench.tex.content = lambda addr, asked=asked: asked.append(addr) or 0
        seen = set()
        for i, (w, h) in enumerate(part):
            for k in range(max(w, h) + 1):
                bench.todo.append((place(0, 0, i)[0] | 2 * k << 72, 0))
                due.append(TEX_BASE + 1000 + i + int(model.level_offset(w, h, rgba5551, k)))
        await bench.run([])
        # blocks that the cache had already are left out of what memory saw
        for addr in asked:
            while due[0] != addr:
                assert due.pop(0) in seen, "a block was never asked for"
            seen.add(due.pop(0))
        assert all(d in seen for d in due)


@cocotb.test(timeout_time=60, timeout_unit="ms", skip=BUILD not in ("paper", "small"))
async def capacity(dut):
    """A square of as many blocks as the cache holds stays in it: sets are spread without a gap. Walked in tiles, twice."""
    log2_blocks = int(np.log2(int(dut.TexSets.value) * 8))
    log2_w, log2_h = 2 + (log2_blocks + 1) // 2, 2 + log2_blocks // 2
    bench = await start(dut)
    world = await plain(bench, log2_w, log2_h, 1, 0, 0, 0, 1)
    world.records[0] = UNIT_RECORD
    jobs = [place((x + 0.7) * 4 / (1 << log2_w), (y + 0.7) * 4 / (1 << log2_h))
            for y in range(1 << log2_h >> 2) for x in range(1 << log2_w >> 2)]  # fmt: skip
    await bench.run(jobs)
    assert bench.tex.count == 1 << log2_blocks, "blocks came more than once"
    random.shuffle(jobs)
    await bench.run(jobs)
    assert bench.tex.count == 1 << log2_blocks
    assert bench.events["tex_hit"] >= len(jobs)
    bench.check_counts()


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def shut_exit(dut):
    """Nothing may leave until the unit is full to the brim; nothing is lost, and it fills again."""
    bench = await start(dut)
    for latency in (1, 200):
        bench.uv.latency = bench.tex.latency = lambda latency=latency: random.randint(1, latency)
        bench.todo.extend(bench.world.hit() for _ in range(130))
        for _ in range(2):
            bench.p_out, taken, idle = 0.0, -1, 0
            while idle < 1500:
                await bench.cycle()
                idle = idle + 1 if taken == len(bench.todo) else 0
                taken = len(bench.todo)
            assert bench.todo, "it never fills up"
            bench.p_out = 1.0
            for _ in range(60):
                await bench.cycle()
        await bench.run([])
    bench.check_counts()


@cocotb.test(timeout_time=60, timeout_unit="ms", skip=BUILD not in ("paper", "small"))
async def replacement(dut):
    """Of two blocks in a set the one used longer ago goes."""
    bench = await start(dut)
    world = await plain(bench, 12, 0, 1, 0, 0, 0, 0)
    world.records[0] = UNIT_RECORD
    apart = 8 * int(dut.TexSets.value)  # texels; a multiple of the distance of blocks that share a set
    a, b, c = (place((apart * k + 1.0) / 4096, 0.5) for k in range(3))
    for job, misses in ((a, 1), (b, 2), (a, 2), (c, 3), (a, 3), (c, 3), (b, 4), (c, 4), (a, 5)):
        await bench.run([job])
        assert bench.tex.count == misses


@cocotb.test(timeout_time=60, timeout_unit="ms", skip=BUILD == "small")
@cocotb.parametrize(trilinear=[False, True])
async def rate(dut, trilinear):
    """Six cycles a hit, twelve between two levels, as long as the caches have what is needed."""
    bench = await start(dut)
    world = await plain(bench, 3, 3, 4, 0, 0, 0, 1)
    world.records = {0: (UNIT_RECORD[0], 20)}
    world.trilinear = trilinear
    bench.set_frame()
    jobs = [place(random.random(), random.random()) for _ in range(100)]
    await bench.run(jobs)
    assert bench.uv.count <= 1 and bench.tex.count <= 5
    for _ in range(2):
        begin = bench.now
        await bench.run(jobs)
        took = bench.now - begin
        assert took <= (12 if trilinear else 6) * len(jobs) + 90, f"{len(jobs)} hits took {took} cycles"


@cocotb.test(timeout_time=60, timeout_unit="ms", skip=BUILD not in ("paper", "small"))
async def misses_overlap(dut):
    """With slow memory as many blocks are under way as the parameters allow, in both caches."""
    bench = await start(dut, latency=lambda: 400)
    world = await plain(bench, 8, 8, 1, 0, 0, 0, 1)
    world.records = {2 * k + odd: UNIT_RECORD for k in range(200) for odd in (0, 1)}
    jobs = [(place(random.random(), random.random())[0] | 2 * k << 72, 0) for k in range(100)]
    await bench.run(jobs)
    assert bench.uv.most == int(dut.UvMiss.value)
    assert bench.tex.most > int(dut.TexMiss.value) - 4
    assert bench.now < 400 * (100 / bench.uv.most + 4 * 100 / (bench.tex.most - 3)) + 2000


SOURCES = (
    *(f"prim/rc_{n}.sv" for n in ("delay", "skid", "ram_1r1w", "fifo")),
    *(f"fp/rc_fp_{n}.sv" for n in ("pipe", "norm", "round", "add", "mul", "from_int")),
    "mem/rc_ro_cache.sv",
    *(f"shade/rc_{n}.sv" for n in ("shade_pkg", "carry", "hold")),
    *(f"shade/rc_tex_{n}.sv" for n in ("pkg", "uv", "addr", "cache", "filter")),
    "shade/rc_texture.sv",
)
SMALL = dict(UvSets=2, UvDepth=4, UvMiss=2, TexSets=2, TexDepth=4, TexMiss=4, HitDepth=6)


def run(build, package, parameters=None):
    # The define gives each set of latencies a build folder of its own.
    sources = [package, *rtl(*SOURCES, package=False)]
    run_cocotb(
        "rc_texture", sources, "test_rc_texture", parameters=parameters, defines={"BUILD": build}, env={"BUILD": build}
    )


@pytest.mark.parametrize("latencies", LATENCIES)
def test_rc_texture(latencies):
    """All tests; those that a schedule may break on builds with other latencies of the functional units."""
    package = package_with_latencies(**LATENCIES[latencies]) if LATENCIES[latencies] else rtl("rc_pkg.sv")[0]
    run(latencies, package)


def test_rc_texture_small():
    """Caches of two sets and queues of a few places: everything waits for everything."""
    run("small", rtl("rc_pkg.sv")[0], SMALL)
