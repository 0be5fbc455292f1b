# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_hitpoint against raycore.model.shade.hit_point: every word of context, in order, bit for bit; one ray in four cycles."""

import random
from dataclasses import dataclass, field

import cocotb
import pytest
import shade_tb as sh
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge


@dataclass
class Bench:
    """Gives hits to rc_hitpoint, one cycle a step, and checks all that comes out."""

    dut: object
    rng: random.Random
    p_valid: float = 1.0
    org: list = None
    cycle: int = 0
    words: list = field(default_factory=list)        # (address, word, patterns may differ) expected, in order
    points: list = field(default_factory=list)
    errors: list = field(default_factory=list)
    taken_at: list = field(default_factory=list)
    hits: object = None                              # where hits come from: (id, dir, t, beta, gamma, Triangle)
    mat_count: int = 256
    _next: object = None

    async def start(self):
        Clock(self.dut.clk_i, 10, unit="ns").start()
        self.dut.rst_ni.value = self.dut.in_valid_i.value = 0
        for _ in range(3):
            await RisingEdge(self.dut.clk_i)
        self.dut.rst_ni.value = 1

    def set_frame(self, org, mat_count=256):
        assert not self.words
        self.org, self.mat_count = org, mat_count
        self.dut.org_i.value = sh.vec(org)
        self.dut.mat_count_i.value = mat_count

    def expect(self, ray_id, d, t, beta, gamma, tri):
        ctx = sh.Context.of_hit(self.org, d, t, beta, gamma, tri)
        axes, md = ctx.words
        for i in range(3):
            self.words.append((ray_id << 2 | i, [axes[k][i] for k in range(4)]))
        self.words.append((ray_id << 2 | 3, [md, tri.mat & 0xFF, ray_id * 77]))
        self.points.append((ray_id, tri.mat & 0xFF))
        if tri.mat >= self.mat_count:
            self.errors.append(9 << 32 | tri.mat)

    async def step(self):
        dut = self.dut
        if self._next is None and self.rng.random() < self.p_valid:
            self._next = next(self.hits)
            ray_id, _, t, beta, gamma, tri = self._next
            dut.in_hit_i.value = (ray_id << 98 | 1 << 96 | ray_id * 77 << 72 | t << 48 | beta << 24 | gamma)
            dut.in_info_i.value = tri.line
        dut.in_valid_i.value = self._next is not None
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        if dut.ctx_valid_o.value:
            assert self.words, "a word nobody asked for"
            address, want = self.words.pop(0)
            assert int(dut.ctx_addr_o.value) == address
            word = int(dut.ctx_word_o.value)
            if address & 3 == 3:
                assert [word & 0xFFFFFF, word >> 24 & 0xFF, word >> 32] == want
            else:
                got = [word >> s & 0xFFFFFF for s in (0, 24, 48, 72)]
                names = "P g m d"
                assert got[0] == want[0] and got[2] == want[2] and sh.same(got, want), (
                    f"{names} of word {address & 3} are {[f'{g:06x}' for g in got]}, not {[f'{w:06x}' for w in want]}")
            if address & 3 == 3:
                assert dut.out_valid_o.value
                assert (int(dut.out_id_o.value), int(dut.out_mat_o.value)) == self.points.pop(0)
            else:
                assert not dut.out_valid_o.value
        else:
            assert not dut.out_valid_o.value
        if dut.err_valid_o.value:
            assert self.errors and int(dut.err_o.value) == self.errors.pop(0)
        if self._next is not None and dut.in_ready_o.value:
            self.expect(*self._next)
            dut.dir_i.value = sh.vec(self._next[1])
            self.taken_at.append(self.cycle)
            self._next = None

    async def run(self, hits):
        """Give these hits, then wait until all is out."""
        hits = list(hits)
        self.hits, count, limit = iter(hits), len(self.taken_at) + len(hits), self.cycle + 500 + len(hits) * 60
        p, idle = self.p_valid, 0
        while idle < 5:
            if len(self.taken_at) + (self._next is not None) == count:
                self.p_valid = 0.0
            assert self.cycle < limit, f"hangs with {len(self.points)} rays inside"
            await self.step()
            idle = 0 if self.words or self._next or len(self.taken_at) < count else idle + 1
        assert not self.points and not self.errors
        self.p_valid = p


def random_hits(num, count, mats=256):
    for i in range(count):
        mat = num.rng.randrange(mats)
        yield i % 256, num.direction(), *sh.random_weights(num), sh.Triangle.random(num, mat)


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(wild=[0.0, 0.02, 0.4], p_valid=[1.0, 0.2, 0.05])
async def random_rays(dut, wild, p_valid):
    """Flat and smooth triangles seen from both sides, with gaps, some or many operands being corners."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_valid)
    num = sh.Numbers(bench.rng, wild)
    await bench.start()
    for _ in range(3):
        bench.set_frame(num.point())
        await bench.run(random_hits(num, sh.some(100)))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def corner_rays(dut):
    """Grazing rays (n . d is +-0 or tiny), no vertex normal, huge ones, the origin in the plane."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    await bench.start()
    bench.set_frame(sh.nearest([0.25, -0.5, 0.75]))
    one, zero, tiny, huge = 0x3F0000, 0, 0x010000, 0x7E8000
    hits = []
    for n in ([zero, one, zero], [zero, 0xBF0000, zero], [zero, one, tiny], [zero, one, 0x810000]):
        for d in ([one, zero, zero], [one, 0x800000, zero], [zero, zero, 0xBF0000], [zero, one, zero], [zero, tiny, one]):
            for n0 in (n, [zero] * 3, [huge] * 3, [tiny] * 3, [0x200000] * 3):
                tri = sh.Triangle(sh.nearest([0.25, -0.5, 0.75]), n, n0, [zero] * 3, [zero] * 3, 3)
                hits.append((len(hits) % 256, d, *sh.nearest([1.0, 0.3, 0.3]), tri))
    await bench.run(hits)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def unknown_material(dut):
    """A material index beyond the count is reported with its number, exactly then."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), 0.7)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    for count in (1, 7, 256):
        bench.set_frame(num.point(), count)
        hits = list(random_hits(num, 40, 14 if count < 256 else 4096))
        edges = [count - 1, count, 4095]
        hits += [(i, num.direction(), *sh.random_weights(num), sh.Triangle.random(num, m)) for i, m in enumerate(edges)]
        await bench.run(hits)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def one_ray_in_four_cycles(dut):
    """The rate is that of the beats as long as hits are offered."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    bench.set_frame(num.point())
    await bench.run(random_hits(num, 100))
    assert {b - a for a, b in zip(bench.taken_at[:-1], bench.taken_at[1:])} == {4}


@pytest.mark.parametrize("latencies", sh.LATENCIES)
def test_rc_hitpoint(latencies):
    """The same tests on builds with other latencies of the functional units."""
    sh.run("rc_hitpoint", latencies, ["shade/rc_hitpoint.sv"], "test_rc_hitpoint")
