# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_through against raycore.model.shade.shadow_through: every light that is blocked and every shadow ray that starts again, in
order, and the transmittance of every index, bit for bit; one blocker in eight cycles."""

import random
from collections import deque
from dataclasses import dataclass, field

import cocotb
import pytest
import shade_tb as sh
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import shade

ONE = (1.0, 1.0, 1.0)


@dataclass
class Bench:
    """Lights start at random indices; their shadow rays meet layer after layer until they are blocked or arrive."""

    dut: object
    rng: random.Random
    num: sh.Numbers
    p_valid: float = 1.0
    p_job: float = 1.0
    p_block: float = 1.0
    layers: int = 6
    cycle: int = 0
    tr: dict = field(default_factory=lambda: {i: ONE for i in range(256)})
    light: dict = field(default_factory=dict)
    met: dict = field(default_factory=dict)                  # layers so far, of rays under way
    idle: list = field(default_factory=lambda: list(range(256)))
    waiting: deque = field(default_factory=deque)            # blockers to come: id
    inside: set = field(default_factory=set)
    blocks: deque = field(default_factory=deque)
    jobs: deque = field(default_factory=deque)
    taken_at: list = field(default_factory=list)
    counts: dict = field(default_factory=lambda: dict.fromkeys(("block", "job", "arrive", "read"), 0))
    kinds: set = field(default_factory=set)
    corner_t: bool = False
    _in: tuple = None
    _read: tuple = None

    async def start(self):
        Clock(self.dut.clk_i, 10, unit="ns").start()
        for name in ("rst_ni", "in_valid_i", "k_valid_i", "ld_mat_valid_i", "ld_opt_valid_i", "start_i", "tr_re_i", "job_ready_i",
                     "block_ready_i"):
            getattr(self.dut, name).value = 0
        for _ in range(3):
            await RisingEdge(self.dut.clk_i)
        self.dut.rst_ni.value = 1

    async def frame(self, mats, min_weight):
        self.mats, self.min_weight = mats, min_weight
        self.dut.min_weight_i.value = min_weight
        for kind, name in ((sh.LD_MATERIAL, "line"), (sh.LD_OPTICS, "optics_line")):
            await sh.load(self.dut, [(kind, i, getattr(m, name)) for i, m in enumerate(mats)],
                          {sh.LD_MATERIAL: "ld_mat_valid_i", sh.LD_OPTICS: "ld_opt_valid_i"})

    def blocker(self, ray_id):
        rng, num = self.rng, self.num
        mat = rng.choice([i for i, m in enumerate(self.mats) if not m.opaque])
        t = rng.choice([0x310000, 0x310001, 0x7EFFFF, 0x7EFFF0, 0x7EFFEF, 0x7F0000, sh.NAN_BITS, 0x3FFFFF]) if self.corner_t else \
            sh.nearest([rng.uniform(2**-14, 4)])[0]
        rgb, ta = num.color(), num.spoil(sh.nearest([rng.random()]))[0]
        if rng.random() < 0.5:
            rgb, ta = [0x3F0000] * 3, 0x3F0000
        hit = sh.hit_word(ray_id, 1, 1, 0, mat, rng.randrange(1 << 33), t, rng.randrange(1 << 24), rng.randrange(1 << 24))
        return sh.tex_word(hit, rgb, ta), ray_id, mat, t, rgb, ta

    def expect(self, ray_id, mat, t, rgb, ta):
        value = sh.floats([t, ta, self.min_weight])
        blocked, tr, t_min = shade.FP24.shadow_through(self.tr[ray_id], value[0], sh.floats(rgb), value[1], self.mats[mat].record,
                                                       value[2])
        self.tr[ray_id] = tr
        self.inside.add(ray_id)
        self.kinds.add((self.mats[mat].mode, self.mats[mat].transmits, bool(blocked)))
        if blocked:
            self.blocks.append(ray_id)
        else:
            self.jobs.append(sh.pack((ray_id, 8), (self.light[ray_id], 4), (sh.bits([t_min])[0], 24)))

    def leaves(self, ray_id):
        """The shadow ray of an index leaves: it arrives, or meets one more layer."""
        self.inside.discard(ray_id)
        if self.met[ray_id] >= self.layers or self.rng.random() < 0.1:
            self.counts["arrive"] += 1
            self.idle.append(ray_id)
        else:
            self.met[ray_id] += 1
            self.waiting.insert(self.rng.randint(0, len(self.waiting)), ray_id)

    async def step(self, more=True):
        dut, rng = self.dut, self.rng
        dut.start_i.value = dut.k_valid_i.value = 0
        start = None
        if more and self.idle and rng.random() < 0.7:
            start = self.idle.pop(rng.randrange(len(self.idle)))
            dut.start_i.value, dut.start_id_i.value = 1, start
            self.light[start] = rng.randrange(16)
        # The light unit is done with one that started before: it makes a shadow ray.
        made = [i for i in self.light if i not in self.met and i != start]
        if made:
            ray_id = rng.choice(made)
            dut.k_valid_i.value = 1
            dut.k_job_i.value = sh.pack((ray_id, 8), (self.light[ray_id], 4), (rng.randrange(1 << 24), 24))
            self.met[ray_id] = 0
        if self._in is None and self.waiting and rng.random() < self.p_valid:
            self._in = self.blocker(self.waiting.popleft())
            dut.in_i.value = self._in[0]
        dut.in_valid_i.value = self._in is not None
        job_ready, block_ready = rng.random() < self.p_job, rng.random() < self.p_block
        dut.job_ready_i.value, dut.block_ready_i.value = job_ready, block_ready
        read = rng.randrange(256)
        dut.tr_re_i.value = read_now = rng.random() < 0.5 and read not in self.inside and read != start
        dut.tr_id_i.value = read
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        if self._read is not None:
            assert sh.unvec(int(dut.tr_o.value)) == self._read[1], f"transmittance of {self._read}"
            self.counts["read"] += 1
        if start is not None:
            self.tr[start] = ONE
            self.met.pop(start, None)
        if made:
            self.leaves(ray_id)
        if read_now:
            self._read = read, sh.bits(self.tr[read])
        if job_ready and dut.job_valid_o.value:
            word = int(dut.job_o.value)
            want = self.jobs.popleft()
            assert word == want, f"{word:09x}, not {want:09x}"
            self.counts["job"] += 1
            self.leaves(word >> 28)
        if block_ready and dut.block_valid_o.value:
            ray_id = int(dut.block_id_o.value)
            assert ray_id == self.blocks.popleft()
            self.counts["block"] += 1
            self.inside.discard(ray_id)
            self.idle.append(ray_id)
        if self._in is not None and dut.in_ready_o.value:
            self.expect(*self._in[1:])
            self.taken_at.append(self.cycle)
            self._in = None

    async def run(self, count):
        goal = len(self.taken_at) + count
        limit = self.cycle + 2000 + count * 300
        while len(self.taken_at) < goal:
            await self.step()
            assert self.cycle < limit
        while len(self.idle) < 256:
            await self.step(more=False)
            assert self.cycle < limit + 20000, f"{256 - len(self.idle)} lights never end"
        assert not self.jobs and not self.blocks


def materials(num):
    mats = [sh.Material.random(num) for _ in range(40)]
    mats[0].mode, mats[0].transmits = shade.ALPHA_BLEND, False
    return mats


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(wild=[0.0, 0.1], min_weight=[0x000000, 0x380000, 0x3E0000])
async def random_layers(dut, wild, min_weight):
    """Up to six layers of glass, masks and thin colours, each index at its own pace, exits open or half shut."""
    rng = random.Random(cocotb.RANDOM_SEED)
    num = sh.Numbers(rng, wild)
    bench = Bench(dut, rng, num)
    await bench.start()
    for _ in range(3):
        bench.p_valid, bench.p_job, bench.p_block = [rng.choice([1.0, 0.5, 0.1]) for _ in range(3)]
        await bench.frame(materials(num), min_weight)
        await bench.run(sh.some(300))
    dut._log.info(f"{bench.counts}, {len(bench.kinds)} kinds")
    assert all(bench.counts.values())


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def corners(dut):
    """Distances at the ends of the range, alphas around the cutoff, limits that nothing and that everything passes."""
    rng = random.Random(cocotb.RANDOM_SEED)
    num = sh.Numbers(rng, 0.3)
    bench = Bench(dut, rng, num, corner_t=True)
    await bench.start()
    for min_weight in (0x000000, 0x800000, 0xBF0000, 0x7F0000, sh.NAN_BITS, 0x3EFFFF, 0x3F0000):
        mats = materials(num)
        for mat in mats:
            mat.alpha = 0x3F0000 if rng.random() < 0.7 else mat.alpha
            mat.kt = [rng.choice([b, 0x3F0000, min_weight, min_weight + 1]) for b in mat.kt]
            mat.cutoff = rng.choice([0x3F0000, 0x3F0001, 0x3EFFFF, 0, 0x800000, sh.NAN_BITS])
        await bench.frame(mats, min_weight)
        await bench.run(sh.some(100))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def one_blocker_in_eight_cycles(dut):
    """The rate is that of the beats; nothing is lost while no shadow ray may leave."""
    rng = random.Random(cocotb.RANDOM_SEED)
    num = sh.Numbers(rng, 0.0)
    bench = Bench(dut, rng, num)
    await bench.start()
    await bench.frame(materials(num), 0)
    await bench.run(200)
    assert {b - a for a, b in zip(bench.taken_at[20:80], bench.taken_at[21:80])} == {8}
    bench.p_job = bench.p_block = 0.0
    for _ in range(4000):
        await bench.step()
    assert len(bench.jobs) + len(bench.blocks) > 200 and not bench.waiting and bench._in is None
    bench.p_job = bench.p_block = 1.0
    await bench.run(0)


@pytest.mark.parametrize("latencies", sh.LATENCIES)
def test_rc_through(latencies):
    """The same tests on builds with other latencies of the functional units."""
    sh.run("rc_through", latencies, ["shade/rc_spread.sv", "shade/rc_through.sv"], "test_rc_through")
