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
    contexts: dict = field(default_factory=dict)     # address: word
    ks: list = field(default_factory=list)           # (id, light, k, culled) expected, in order
    secs: list = field(default_factory=list)
    taken_at: list = field(default_factory=list)
    culled: int = 0
    _next: object = None
    _sec_held: object = None

    async def start(self):
        dut = self.dut
        Clock(dut.clk_i, 10, unit="ns").start()
        dut.rst_ni.value = dut.job_valid_i.value = dut.sec_ready_i.value = 0
        dut.ld_light_valid_i.value = dut.ld_mat_valid_i.value = 0
        for _ in range(3):
            await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1

    async def load(self, lights, mats, shadows):
        """Load records; there may be up to 16 lights and 256 materials."""
        dut = self.dut
        assert not self.ks
        self.lights, self.mats, self.shadows = lights, mats, shadows
        dut.shadows_i.value = shadows
        for records, valid in ((lights, dut.ld_light_valid_i), (mats, dut.ld_mat_valid_i)):
            valid.value = 1
            for i, record in enumerate(records):
                dut.ld_idx_i.value, dut.ld_line_i.value = i, record.line
                await RisingEdge(dut.clk_i)
            valid.value = 0

    def expect(self, ray_id, light, mat, tri, axes, md):
        values = (*[sh.floats(v) for v in axes], sh.floats([md])[0])
        args = values, self.lights[light].record, self.mats[mat].record
        culled, direction, t_max, k = shade.FP24.light_job(*args)
        self.ks.append((ray_id, light, sh.bits(k), culled))
        if not culled and self.shadows:
            self.secs.append([ray_id, light, tri, *sh.bits([t_max]), sh.bits(direction), axes[0]])

    async def step(self):
        dut, rng = self.dut, self.rng
        if self._next is None and rng.random() < self.p_valid:
            job = self._next = next(self.jobs, None)
            if job is not None:
                ray_id, light, mat, tri, axes, md = job
                dut.job_i.value = ray_id << 4 | light
                for i in range(3):
                    self.contexts[ray_id << 2 | i] = sum(axes[k][i] << 24 * k for k in range(4))
                self.contexts[ray_id << 2 | 3] = tri << 32 | mat << 24 | md
        dut.job_valid_i.value = self._next is not None
        ready = rng.random() < self.p_ready
        dut.sec_ready_i.value = ready
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        if dut.ctx_re_o.value:
            dut.ctx_word_i.value = self.contexts[int(dut.ctx_addr_o.value)]
        if dut.k_valid_o.value:
            assert self.ks, "a colour nobody asked for"
            ray_id, light, k, culled = self.ks.pop(0)
            assert int(dut.k_job_o.value) == ray_id << 4 | light
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
                got = [word >> 196, word >> 192 & 15, word >> 168 & 0xFFFFFF, word >> 144 & 0xFFFFFF,
                       sh.unvec(word >> 72), sh.unvec(word)]
                assert got[:5] == want[:5] and sh.same(got[5], want[5])
                self._sec_held = None
        if self._next is not None and dut.job_ready_o.value:
            self.expect(*self._next)
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
    lights = [sh.Light.random(num) for _ in range(num.rng.choice([1, 3, 16]))]
    return lights, [sh.Material.random(num) for _ in range(num.rng.choice([1, 20, 256]))]


def random_jobs(bench, num, count):
    rng = num.rng
    for i in range(count):
        light, mat = rng.randrange(len(bench.lights)), rng.randrange(len(bench.mats))
        yield i % 256, light, mat, rng.randrange(1 << 24), *random_context(num)


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
    """A light at the hit point, very near, very far, grazing, straight above; every shininess; attenuation of 0, inf, NaN."""
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
    mats = [sh.Material([zero] * 3, [one, 0x3E0000, zero], [one, zero, 0x3D0000], shin) for shin in range(16)]
    for directional in (False, True):
        for att in attens[:sh.some(len(attens))]:
            lights = [sh.Light(directional, place, [one, one, 0x3E8000], att) for place in places]
            await bench.load(lights, mats, True)
            await bench.run((i, light, i % 16, 5, [p, up, up, view], sh.nearest([-np.sqrt(0.5)])[0])
                            for light in range(len(places)) for i in range(16 if att == attens[0] else 3))
    # 2 m.L at the end of the range and beyond it
    await bench.run((i, 6, 1, 5, [p, up, [zero, size, zero], view], 0xBF0000)
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
