# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_accum against raycore.model.shade.add_miss, add_surface, add_light: every finished colour, every light, bounce and pop
that follows, in order, bit for bit; one update in three cycles.

The test plays all that surrounds it: a job is answered by its k and an update, a bounce by the end of the path or by a ray
that hits a surface or nothing, in any order of the indices.
"""

import random
from collections import deque
from dataclasses import dataclass, field

import cocotb
import pytest
import shade_tb as sh
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import shade

MISS, SURFACE, LIGHT, END = range(4)
F = shade.FP24


@dataclass
class Pixel:
    """What the model knows of an index."""

    acc: tuple = (0.0, 0.0, 0.0)
    first: bool = True                                # the ray is primary: until one goes on
    wl: tuple = None
    next: tuple = (False, False)                      # bounces, branch
    light: int = 0
    k: list = None
    tr: list = None
    w: list = None
    pending: int = 0                                  # rays on its stack
    levels: int = 0


@dataclass
class Bench:
    dut: object
    rng: random.Random
    num: sh.Numbers
    p_upd: float = 1.0
    p_job: float = 1.0
    p_done: float = 1.0
    delay: tuple = (1, 30)
    free: list = field(default_factory=lambda: list(range(256)))
    pixels: dict = field(default_factory=dict)
    later: list = field(default_factory=list)         # (cycle, kind, id)
    updates: deque = field(default_factory=deque)     # (kind, id)
    jobs: deque = field(default_factory=deque)        # expected, in order
    bounces: deque = field(default_factory=deque)
    dones: deque = field(default_factory=deque)
    counts: dict = field(default_factory=lambda: dict.fromkeys(("light", "bounce", "pop", "done"), 0))
    taken_at: list = field(default_factory=list)
    cycle: int = 0
    p_bounces: float = 0.5
    _upd: tuple = None
    _k: tuple = None

    async def start(self):
        Clock(self.dut.clk_i, 10, unit="ns").start()
        for name in ("rst_ni", "upd_valid_i", "k_valid_i", "ld_mat_valid_i", "job_ready_i", "done_ready_i", "pending_i"):
            getattr(self.dut, name).value = 0
        for _ in range(3):
            await RisingEdge(self.dut.clk_i)
        self.dut.rst_ni.value = 1

    async def frame(self, mats, lights):
        self.mats, self.lights, self.background = mats, lights, self.num.color()
        self.dut.background_i.value, self.dut.light_count_i.value = sh.vec(self.background), lights
        await sh.load(self.dut, [(sh.LD_MATERIAL, i, m.line) for i, m in enumerate(mats)], "ld_mat_valid_i")

    def ray_ends(self, ray_id):
        self.later.append((self.cycle + self.rng.randint(*self.delay), self.rng.choice([SURFACE, SURFACE, SURFACE, MISS]), ray_id))

    def new_pixel(self):
        ray_id = self.free.pop(self.rng.randrange(len(self.free)))
        self.pixels[ray_id] = Pixel()
        self.ray_ends(ray_id)

    def make_update(self, kind, ray_id):
        """The update as a word, what the unit is told with it, and the consequence by the model."""
        rng, num, pixel = self.rng, self.num, self.pixels[ray_id]
        mat, bounces, branch, add = rng.randrange(len(self.mats)), rng.random() < self.p_bounces, rng.randrange(2), rng.randrange(2)
        alpha, tex = num.spoil(sh.nearest([rng.choice([1.0, rng.random()])]))[0], num.color()
        bounces = bounces and pixel.levels < 15
        pixel.w = [0x3F0000] * 3 if pixel.first else num.color()
        pixel.tr = num.color() if rng.random() < 0.5 else [0x3F0000] * 3
        word = sh.pack((kind, 2), (add, 1), (sh.point_word(ray_id, mat, bounces, branch, alpha, tex), 114))
        def follow():
            self.consequence(kind, ray_id, mat, bounces, branch, add, alpha, tex)

        return word, follow, ray_id

    def consequence(self, kind, ray_id, mat, bounces, branch, add, alpha, tex):
        pixel = self.pixels[ray_id]
        if kind == MISS:
            pixel.acc = F.add_miss(pixel.acc, sh.floats(pixel.w), sh.floats(self.background))
        elif kind == SURFACE:
            pixel.wl = F.weight(sh.floats([alpha])[0], sh.floats(pixel.w))
            pixel.acc = F.add_surface(pixel.acc, pixel.wl, sh.floats(tex), self.mats[mat].record)
            pixel.next, pixel.light = (bounces, branch), 0
        elif kind == LIGHT:
            if add:
                pixel.acc = F.add_light(pixel.acc, pixel.wl, sh.floats(pixel.tr), sh.floats(pixel.k))
            pixel.light += 1
        if kind in (SURFACE, LIGHT) and pixel.light < self.lights:
            self.jobs.append(sh.pack((ray_id, 8), (pixel.light, 4), (0x310000, 24)))
        elif kind in (SURFACE, LIGHT) and pixel.next[0]:
            self.bounces.append((ray_id, 0, pixel.next[1]))
        elif pixel.pending:
            self.bounces.append((ray_id, 1, None))
        else:
            self.dones.append((ray_id, sh.bits(pixel.acc)))

    async def step(self):
        dut, rng = self.dut, self.rng
        for item in [x for x in self.later if x[0] <= self.cycle]:
            self.later.remove(item)
            self.updates.append(item[1:])
        # k is there before its update is given
        dut.k_valid_i.value = self._k is not None
        if self._k is not None:
            ray_id, light = self._k
            k = self.num.color()
            self.pixels[ray_id].k = k
            dut.k_job_i.value = sh.pack((ray_id, 8), (light, 4), (rng.randrange(1 << 24), 24))
            dut.k_i.value = sh.vec(k)
            self.later.append((self.cycle + rng.randint(*self.delay), LIGHT, ray_id))
            self._k = None
        if self._upd is None and self.updates and rng.random() < self.p_upd:
            self._upd = self.make_update(*self.updates.popleft())
            dut.upd_i.value = self._upd[0]
        dut.upd_valid_i.value = self._upd is not None
        # one job at a time, since k has one port
        job_ready, done_ready = rng.random() < self.p_job, rng.random() < self.p_done
        dut.job_ready_i.value, dut.done_ready_i.value = job_ready, done_ready
        dut.pending_i.value = sum(1 << i for i, p in self.pixels.items() if p.pending)
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        if dut.bounce_valid_o.value:
            self.take_bounce(int(dut.bounce_o.value))
        if dut.start_o.value:
            assert self.pixels[int(dut.start_id_o.value)].light < self.lights
        if job_ready and dut.job_valid_o.value:
            word = int(dut.job_o.value)
            assert word == self.jobs.popleft()
            self._k = word >> 28, word >> 24 & 15
            self.counts["light"] += 1
        if done_ready and dut.done_valid_o.value:
            word = int(dut.done_o.value)
            want_id, want = self.dones.popleft()
            assert (word >> 72, sh.unvec(word)) == (want_id, want), f"{sh.unvec(word)} of {word >> 72}, not {want} of {want_id}"
            del self.pixels[want_id]
            self.free.append(want_id)
            self.counts["done"] += 1
        assert dut.taken_o.value == (self._upd is not None and dut.upd_ready_o.value)
        if self._upd is not None and dut.upd_ready_o.value:
            _, follow, ray_id = self._upd
            assert int(dut.taken_id_o.value) == ray_id
            pixel, self._upd = self.pixels[ray_id], None
            dut.first_i.value, dut.w_i.value, dut.tr_i.value = pixel.first, sh.vec(pixel.w), sh.vec(pixel.tr)
            follow()
            self.taken_at.append(self.cycle)

    def take_bounce(self, word):
        ray_id, pop, branch = word >> 2, word >> 1 & 1, word & 1
        want = self.bounces.popleft()
        assert (ray_id, pop) == want[:2] and want[2] in (None, branch), f"{(ray_id, pop, branch)}, not {want}"
        pixel = self.pixels[ray_id]
        pixel.levels += 1
        self.counts["pop" if pop else "bounce"] += 1
        if pop:
            pixel.pending, pixel.first = pixel.pending - 1, False
            self.ray_ends(ray_id)
        elif self.rng.random() < 0.3:
            self.later.append((self.cycle + self.rng.randint(*self.delay), END, ray_id))
        else:
            pixel.first = False
            pixel.pending += branch and self.rng.randrange(2)
            self.ray_ends(ray_id)

    async def run(self, count, ahead=256):
        limit, goal = self.cycle + 20000 + count * 400 * (1 + self.lights), self.counts["done"] + count
        while self.counts["done"] < goal:
            assert self.cycle < limit, f"hangs with {len(self.pixels)} pixels under way"
            if self.free and len(self.pixels) < min(ahead, goal - self.counts["done"]):
                self.new_pixel()
            await self.step()
        for _ in range(30):
            await self.step()
        assert not self.pixels and not self.jobs and not self.bounces and not self.dones


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(lights=[0, 1, 3, 16], wild=[0.0, 0.1])
async def random_paths(dut, lights, wild):
    """Pixels of one to many levels, each index at its own pace, exits open or half shut."""
    rng = random.Random(cocotb.RANDOM_SEED)
    num = sh.Numbers(rng, wild)
    bench = Bench(dut, rng, num)
    await bench.start()
    for _ in range(3):
        bench.p_upd, bench.p_job, bench.p_done = [rng.choice([1.0, 0.5, 0.1]) for _ in range(3)]
        bench.delay, bench.p_bounces = (1, rng.choice([1, 50])), rng.choice([0.3, 0.8])
        await bench.frame([sh.Material.random(num) for _ in range(20)], lights)
        await bench.run(sh.some(150 if lights < 16 else 40), rng.choice([1, 20, 256]))
    dut._log.info(f"{bench.counts}")
    # With 16 lights there are few pixels, and it may be that none leaves a ray on its stack.
    assert all(n for name, n in bench.counts.items() if (name != "light" or lights) and (name != "pop" or lights < 16))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def shut_exits(dut):
    """All 256 indices wait for their light while no job leaves; finished pixels wait without loss."""
    rng = random.Random(cocotb.RANDOM_SEED)
    num = sh.Numbers(rng, 0.0)
    bench = Bench(dut, rng, num, p_job=0.0)
    await bench.start()
    await bench.frame([sh.Material.random(num) for _ in range(5)], 2)
    while bench.free:
        bench.new_pixel()
        await bench.step()
    for _ in range(2000):
        await bench.step()
    assert not bench.updates and len(bench.jobs) > 128
    bench.p_job, bench.p_done = 1.0, 0.0
    for _ in range(2000):
        await bench.step()
    bench.p_done = 1.0
    while bench.pixels:
        await bench.step()
        assert bench.cycle < 60000


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def one_update_in_three_cycles(dut):
    rng = random.Random(cocotb.RANDOM_SEED)
    num = sh.Numbers(rng, 0.0)
    bench = Bench(dut, rng, num, delay=(1, 1))
    await bench.start()
    await bench.frame([sh.Material.random(num) for _ in range(5)], 0)
    await bench.run(sh.some(400))
    assert {b - a for a, b in zip(bench.taken_at[50:-50], bench.taken_at[51:-50])} == {3}


@pytest.mark.parametrize("latencies", sh.LATENCIES)
def test_rc_accum(latencies):
    """The same tests on builds with other latencies of the functional units."""
    sh.run("rc_accum", latencies, ["shade/rc_accum.sv"], "test_rc_accum")
