# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_light against raycore.model.shade.light_job: every colour, shadow ray and update, bit for bit; one job in five cycles.

The test plays the context RAM. A job's context is made by the model's hit point, or of random and corner patterns.
"""

import random
from dataclasses import dataclass, field

import cocotb
import numpy as np
import pytest
import shade_tb as sh
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import shade

T_MIN, RAY_SHADOW = 0x310000, 1


@dataclass
class Job:
    """What rc_light takes and finds in the context, as patterns."""

    ray_id: int
    light: int
    mat: int
    tri: int
    axes: list                                       # P, g, m, d
    md: int
    tex: list = field(default_factory=lambda: [0x3F0000] * 3)
    t_min: int = T_MIN
    depth: int = 0
    other: int = 0                                   # 121 bits that are not for the light unit

    @property
    def word(self):
        return self.ray_id << 28 | self.light << 24 | self.t_min

    def context(self, word):
        """One of the four words of ctx_axis_t and ctx_scalar_t."""
        if word < 3:
            low = [v[word] for v in (*self.axes, self.tex)]
            return sum(b << 24 * k for k, b in enumerate(low)) | (self.other >> 24 * word & 0xFFFFFF) << 120
        return (self.md | self.mat << 24 | self.tri << 32 | (self.other >> 72 & (1 << 48) - 1) << 65 | self.depth << 113
                | (self.other >> 120 & 1) << 117)


def random_context(num):
    """([P, g, m, d], md) as patterns: a hit point that makes sense, or, when numbers are wild, anything."""
    rng = num.rng
    if num.wild and rng.random() < 0.5:
        md = num.spoil(sh.nearest([rng.uniform(-1, 0)]))[0]
        return [num.point(), num.direction(), num.direction(), num.direction()], md
    tri = sh.Triangle.random(num, 0)
    return sh.Context.of_hit(num.point(), num.direction(), *sh.random_weights(num), tri).words


@dataclass
class Bench:
    """Gives jobs to rc_light, answers its reads of context, and checks all that comes out, one cycle a step."""

    dut: object
    rng: random.Random
    p_valid: float = 1.0
    p_ready: float = 1.0
    shadows: bool = True
    cycle: int = 0
    lights: list = None
    mats: list = None
    contexts: dict = field(default_factory=dict)     # ray index: job
    ks: list = field(default_factory=list)           # (job, k, culled) expected, in order
    secs: list = field(default_factory=list)
    taken_at: list = field(default_factory=list)
    culled: int = 0
    _next: object = None
    _sec_held: object = None

    async def start(self):
        dut = self.dut
        Clock(dut.clk_i, 10, unit="ns").start()
        dut.rst_ni.value = dut.job_valid_i.value = dut.sec_ready_i.value = 0
        dut.ld_valid_i.value = 0
        for _ in range(3):
            await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1

    async def load(self, lights, mats, shadows):
        """Load records; there may be up to 16 lights and 256 materials."""
        dut = self.dut
        assert not self.ks
        self.lights, self.mats, self.shadows = lights, mats, shadows
        dut.shadows_i.value = shadows
        records = [(sh.LD_LIGHT, i, light.line) for i, light in enumerate(lights)]
        for i, mat in enumerate(mats):               # the optics, and a kind that does not exist, are not for this unit
            records.append((sh.LD_MATERIAL, i, mat.line))
            records += [(kind, i, self.rng.getrandbits(480)) for kind in (sh.LD_OPTICS, 3)]
        await sh.load(dut, records)

    def expect(self, job):
        values = (*[sh.floats(v) for v in job.axes], sh.floats([job.md])[0])
        tex, t_min = sh.floats(job.tex), sh.floats([job.t_min])[0]
        args = values, self.lights[job.light].record, self.mats[job.mat].record, tex, t_min
        culled, direction, _, t_max, k = shade.FP24.light_job(*args)
        self.ks.append((job, sh.bits(k), culled))
        if not culled and self.shadows:
            head = sh.pack((job.ray_id, 8), (RAY_SHADOW, 2), (job.light, 4), (job.depth, 4), (job.tri, 33), (job.t_min, 24))
            self.secs.append([head, *sh.bits([t_max]), sh.bits(direction), job.axes[0]])

    async def step(self):
        dut, rng = self.dut, self.rng
        if self._next is None and rng.random() < self.p_valid:
            job = self._next = next(self.jobs, None)
            if job is not None:
                dut.job_i.value = job.word
                self.contexts[job.ray_id] = job
        dut.job_valid_i.value = self._next is not None
        ready = rng.random() < self.p_ready
        dut.sec_ready_i.value = ready
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        # The RAM's port is this unit's in the four cycles after a job was taken, and in no other.
        mine = bool(self.taken_at) and 0 < self.cycle - self.taken_at[-1] < 5
        assert bool(dut.ctx_re_o.value) == mine
        if mine:
            address = int(dut.ctx_addr_o.value)
            dut.ctx_word_i.value = self.contexts[address >> 2].context(address & 3)
        else:
            dut.ctx_word_i.value = rng.getrandbits(144)
        if dut.k_valid_o.value:
            assert self.ks, "a colour nobody asked for"
            job, k, culled = self.ks.pop(0)
            assert int(dut.k_job_o.value) == job.word
            assert bool(dut.ev_culled_o.value) == culled
            assert bool(dut.upd_valid_o.value) == (culled or not self.shadows)
            if dut.upd_valid_o.value:
                assert bool(dut.upd_add_o.value) == (not culled)
            got = sh.unvec(int(dut.k_o.value))
            assert culled or got == k, f"k is {[f'{g:06x}' for g in got]}, not {[f'{w:06x}' for w in k]}"
            self.culled += culled
        else:
            assert not dut.upd_valid_o.value and not dut.ev_culled_o.value
        if dut.sec_valid_o.value:
            word = int(dut.sec_o.value)
            assert self._sec_held in (None, word), "the shadow ray changed while it waited"
            self._sec_held = word
            if ready:
                want = self.secs.pop(0)
                got = [word >> 168, word >> 144 & 0xFFFFFF, sh.unvec(word >> 72), sh.unvec(word)]
                assert got[:3] == want[:3] and sh.same(got[3], want[3]), f"{got} instead of {want}"
                self._sec_held = None
        if self._next is not None and dut.job_ready_o.value:
            self.expect(self._next)
            self.taken_at.append(self.cycle)
            self._next = None

    async def run(self, jobs):
        """Give these jobs, then wait until all is out."""
        jobs = list(jobs)
        self.jobs, goal = iter(jobs), len(self.taken_at) + len(jobs)
        limit = self.cycle + 1000 + len(jobs) * 100
        idle = 0
        while idle < 5:
            assert self.cycle < limit, f"hangs with {len(self.ks)} jobs inside"
            await self.step()
            idle = 0 if self.ks or self.secs or len(self.taken_at) < goal else idle + 1


def random_records(num):
    rng = num.rng
    lights = [sh.Light.random(num) for _ in range(rng.choice([1, 3, 16]))]
    mats = [sh.Material.random(num) for _ in range(rng.choice([1, 20, 256]))]
    for mat in mats:
        shin = rng.choice([0, 1, 1024, rng.uniform(0, 2), rng.uniform(0, 100), 2 ** rng.uniform(0, 10)])
        mat.shin = num.spoil(sh.nearest([shin]))[0]
    return lights, mats


def random_jobs(bench, num, count):
    rng = num.rng
    for i in range(count):
        light, mat = rng.randrange(len(bench.lights)), rng.randrange(len(bench.mats))
        tex = num.color() if rng.random() < 0.7 else [0x3F0000] * 3
        t_min = T_MIN if rng.random() < 0.5 else num.spoil(sh.nearest([rng.uniform(0, 2)]))[0]
        yield Job(i % 256, light, mat, rng.randrange(1 << 33), *random_context(num), tex, t_min, rng.randrange(16),
                  rng.getrandbits(121))


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(wild=[0.0, 0.02, 0.3], rates=[(1.0, 1.0), (1.0, 0.02), (0.05, 0.5)], shadows=[True, False])
async def random_lights(dut, wild, rates, shadows):
    """Lights of both kinds on both sides of surfaces, gaps and back-pressure, some or many operands being corners."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), *rates)
    num = sh.Numbers(bench.rng, wild)
    await bench.start()
    for _ in range(3):
        await bench.load(*random_records(num), shadows)
        await bench.run(random_jobs(bench, num, sh.some(60)))
    assert wild > 0.1 or 0 < bench.culled < len(bench.taken_at)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def corner_lights(dut):
    """A light at the hit point, very near, very far, grazing, straight above; any shininess; attenuation of 0, inf, NaN."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    await bench.start()
    one, zero = 0x3F0000, 0
    p = sh.nearest([0.25, 0.5, -0.5])
    up, view = [zero, one, zero], sh.nearest(np.array([1, -1, 0]) / np.sqrt(2))
    places = [p, sh.nearest([0.25, 0.5 + 2**-17, -0.5]), sh.nearest([0.25, 2.0**40, -0.5]), sh.nearest([2.0**33, 0.5, -0.5]),
              sh.nearest([0.75, 0.5, -0.5]), sh.nearest([0.75, 0.5 + 2**-16, -0.5]), sh.nearest([0.25, 1.5, -0.5]),
              sh.nearest([1.25, 1.5, -0.5]), sh.nearest([0.25, -1, -0.5])]
    attens = [[one, zero, zero], [zero, zero, zero], [zero, one, zero], [zero, zero, one], [sh.NAN_BITS, zero, zero],
              [0x7F0000, zero, zero], [0xBF0000, zero, zero]]
    shins = [zero, 0x010000, one, 0x400000, 0x411234, 0x44FFFF, 0x480000, 0x490000, 0x5F0000, 0x7EFFFF, 0x7F0000, sh.NAN_BITS,
             0x800000, 0xBF0000, 0x3E0000, 0x000001]
    mats = [sh.Material([zero] * 3, [one, 0x3E0000, zero], [one, zero, 0x3D0000], [zero] * 3, shin) for shin in shins]
    for directional in (False, True):
        for att in attens[:sh.some(len(attens))]:
            lights = [sh.Light(directional, place, [one, one, 0x3E8000], att) for place in places]
            await bench.load(lights, mats, True)
            await bench.run(Job(i, light, i % 16, 5, [p, up, up, view], sh.nearest([-np.sqrt(0.5)])[0], [0x3E0000, one, 0x3F8000])
                            for light in range(len(places)) for i in range(16 if att == attens[0] else 3))
    # 2 m.L at the end of the range and beyond it
    await bench.run(Job(i, 6, 2, 5, [p, up, [zero, size, zero], view], 0xBF0000)
                    for i, size in enumerate((0x7DFFFF, 0x7E0000, 0x7E8000, 0x7EFFFF, 0x7F0000, 0x800000, 0x010000)))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def one_job_in_five_cycles(dut):
    """The rate is that of the beats as long as jobs are offered and shadow rays taken."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    await bench.load(*random_records(num), True)
    await bench.run(random_jobs(bench, num, 100))
    assert {b - a for a, b in zip(bench.taken_at[:-1], bench.taken_at[1:])} == {5}


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def waits_for_the_exit(dut):
    """Nobody takes shadow rays for long: the unit fills, stops taking jobs, loses nothing, then goes on."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), 1.0, 0.0)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    await bench.load(*random_records(num), True)
    bench.jobs = random_jobs(bench, num, 400)
    for _ in range(3000):
        await bench.step()
    inside = len(bench.taken_at)
    for _ in range(500):
        await bench.step()
    assert len(bench.taken_at) == inside < 390 and len(bench.secs) >= 16
    bench.p_ready = 0.7
    await bench.run(bench.jobs)


@pytest.mark.parametrize("latencies", sh.LATENCIES)
def test_rc_light(latencies):
    """The same tests on builds with other latencies of the functional units."""
    sh.run("rc_light", latencies, ["shade/rc_light.sv"], "test_rc_light")
