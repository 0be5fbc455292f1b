# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_shade against raycore.model.shade: every shadow ray and every finished colour, bit for bit.

The test plays ray generation (directions), the T&I unit (hits, shadow rays that come back in any order), the colour buffer
and a memory with latency and back-pressure. Ray indices are used again as soon as their pixel is finished.
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

INFO_BASE = 0x3000


@dataclass
class Pixel:
    """A pixel under way: what the model says will be asked and answered."""

    ray_id: int
    steps: list                # expected: ("sec", fields, blocked) ..., then ("done", rgb)
    dir: list
    hit: int                   # hit_t of the primary ray


@dataclass
class Bench:
    """All that surrounds rc_shade, one cycle a step."""

    dut: object
    rng: random.Random
    p_hit: float = 1.0
    p_sec: float = 1.0
    p_done: float = 1.0
    p_req: float = 1.0
    latency: tuple = (1, 20)                        # of memory and of the T&I unit, cycles
    p_miss: float = 0.2
    p_blocked: float = 0.4
    cycle: int = 0
    free: list = field(default_factory=lambda: list(range(256)))
    pixels: dict = field(default_factory=dict)      # by ray index
    to_hit: deque = field(default_factory=deque)    # hit_t words to give
    shadow: list = field(default_factory=list)      # (cycle, hit_t)
    reads: deque = field(default_factory=deque)     # (cycle, line address)
    done_at: list = field(default_factory=list)
    events: dict = field(default_factory=lambda: dict.fromkeys(("culled", "info_hit", "info_miss"), 0))
    want_culled: int = 0
    surfaces: int = 0
    errors: list = field(default_factory=list)
    hits_taken: int = 0
    _hit: object = None
    _sec_held: object = None
    _dir: object = None

    async def start(self):
        dut = self.dut
        Clock(dut.clk_i, 10, unit="ns").start()
        for name in ("rst_ni", "hit_valid_i", "sec_ready_i", "done_ready_i", "dir_valid_i", "ld_valid_i", "req_ready_i",
                     "rsp_valid_i"):
            getattr(dut, name).value = 0

    async def frame(self, num, lights, mats, triangles, shadows=True, mat_count=None):
        """Reset, which empties the cache; registers and records of a frame."""
        dut = self.dut
        assert not self.pixels
        dut.rst_ni.value = 0
        for _ in range(2):
            await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1
        self.num, self.lights, self.mats, self.triangles, self.shadows = num, lights, mats, triangles, shadows
        self.org, self.background = num.point(), num.color()
        dut.org_i.value, dut.background_i.value = sh.vec(self.org), sh.vec(self.background)
        dut.shadows_i.value, dut.light_count_i.value = shadows, len(lights)
        dut.mat_count_i.value, dut.info_base_i.value = mat_count or len(mats), INFO_BASE
        dut.ld_valid_i.value = 1
        for kind, records in ((1, lights), (0, mats)):
            for i, record in enumerate(records):
                dut.ld_light_i.value, dut.ld_idx_i.value, dut.ld_line_i.value = kind, i, record.line
                await RisingEdge(dut.clk_i)
        dut.ld_valid_i.value = 0

    def new_pixel(self):
        """A primary ray that ends now, and by the model all that follows from it."""
        rng, num = self.rng, self.num
        ray_id = self.free.pop(rng.randrange(len(self.free)))
        direction = num.direction()
        if rng.random() < self.p_miss:
            steps = [("done", self.background)]
            hit = ray_id << 98 | sh.TRI_NONE << 72 | rng.randrange(1 << 72)
        else:
            tri_idx, (t, beta, gamma) = rng.randrange(len(self.triangles)), sh.random_weights(num)
            tri = self.triangles[tri_idx]
            hit = ray_id << 98 | 1 << 96 | tri_idx << 72 | t << 48 | beta << 24 | gamma
            steps = self.surface_steps(ray_id, direction, tri_idx, tri, t, beta, gamma)
            self.surfaces += 1
        self.pixels[ray_id] = Pixel(ray_id, steps, direction, hit)
        self._dir = ray_id, direction
        self.to_hit.append(hit)

    def surface_steps(self, ray_id, direction, tri_idx, tri, t, beta, gamma):
        mat = self.mats[tri.mat] if tri.mat < len(self.mats) else None
        if mat is None:
            return None
        steps, acc = [], sh.floats(mat.ambient)
        ctx = sh.Context.of_hit(self.org, direction, t, beta, gamma, tri)
        for i, light in enumerate(self.lights):
            culled, to, t_max, k = shade.FP24.light_job(ctx.values, light.record, mat.record)
            if culled:
                self.want_culled += 1
                continue
            blocked = False
            if self.shadows:
                blocked = self.rng.random() < self.p_blocked
                fields = [i, tri_idx, *sh.bits([t_max]), sh.bits(to), sh.bits(ctx.values[0])]
                steps.append(("sec", fields, blocked))
            if not blocked:
                acc = shade.FP24.add_k(acc, k)
        return [*steps, ("done", sh.bits(acc))]

    async def step(self):
        dut, rng = self.dut, self.rng
        # what the surroundings give
        dut.dir_valid_i.value = self._dir is not None
        if self._dir is not None:
            dut.dir_id_i.value, dut.dir_i.value = self._dir[0], sh.vec(self._dir[1])
            self._dir = None
        late = [s for s in self.shadow if s[0] <= self.cycle]
        for s in late:
            self.shadow.remove(s)
            self.to_hit.insert(rng.randint(0, len(self.to_hit)), s[1])
        if self._hit is None and self.to_hit and rng.random() < self.p_hit:
            self._hit = self.to_hit.popleft()
            dut.hit_i.value = self._hit
        dut.hit_valid_i.value = self._hit is not None
        sec_ready, done_ready, req_ready = rng.random() < self.p_sec, rng.random() < self.p_done, rng.random() < self.p_req
        dut.sec_ready_i.value, dut.done_ready_i.value, dut.req_ready_i.value = sec_ready, done_ready, req_ready
        answer = bool(self.reads) and self.reads[0][0] <= self.cycle
        dut.rsp_valid_i.value = answer
        if answer:
            dut.rsp_line_i.value = self.triangles[self.reads.popleft()[1] - INFO_BASE].line
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        # what the unit did
        if self._hit is not None and dut.hit_ready_o.value:
            self._hit = None
            self.hits_taken += 1
        if req_ready and dut.req_valid_o.value:
            self.reads.append((self.cycle + rng.randint(*self.latency), int(dut.req_addr_o.value)))
        for name in self.events:
            self.events[name] += int(getattr(dut, f"ev_{name}_o").value)
        if dut.err_valid_o.value:
            self.errors.append(int(dut.err_o.value))
        if dut.sec_valid_o.value:
            word = int(dut.sec_o.value)
            assert self._sec_held in (None, word), "the shadow ray changed while it waited"
            self._sec_held = word
            if sec_ready:
                self.take_sec(word)
        if done_ready and dut.done_valid_o.value:
            self.take_done(int(dut.done_o.value))

    def take_sec(self, word):
        self._sec_held = None
        ray_id = word >> 196
        steps = self.pixels[ray_id].steps
        if steps is None:                                   # bad material: any answer will do
            blocked = True
        else:
            got = [word >> 192 & 15, word >> 168 & 0xFFFFFF, word >> 144 & 0xFFFFFF, sh.unvec(word >> 72), sh.unvec(word)]
            assert steps[0][0] == "sec", f"a shadow ray of index {ray_id} instead of its colour"
            _, want, blocked = steps.pop(0)
            assert got == want, f"shadow ray {got}, not {want}"
        tri = self.rng.randrange(1 << 24) if blocked else sh.TRI_NONE
        hit = ray_id << 98 | 1 << 97 | blocked << 96 | tri << 72 | self.rng.randrange(1 << 72)
        self.shadow.append((self.cycle + self.rng.randint(*self.latency), hit))

    def take_done(self, word):
        ray_id, got = word >> 72, sh.unvec(word)
        steps = self.pixels.pop(ray_id).steps
        if steps is not None:
            assert steps[0][0] == "done", f"index {ray_id} is finished, but {len(steps) - 1} shadow rays were due"
            assert sh.same(got, steps[0][1]), f"{[f'{g:06x}' for g in got]}, not {[f'{w:06x}' for w in steps[0][1]]}"
        self.free.append(ray_id)
        self.done_at.append(self.cycle)

    async def run(self, count, ahead=256):
        """This many pixels, at most `ahead` of them under way, then wait until all are finished."""
        limit = self.cycle + 30000 + 10 * count * (200 + len(self.lights) * 100 + 5 * self.latency[1])
        goal = len(self.done_at) + count
        while len(self.done_at) < goal:
            assert self.cycle < limit, f"hangs with {len(self.pixels)} pixels under way"
            if self.free and self._dir is None and len(self.pixels) < min(ahead, goal - len(self.done_at)):
                self.new_pixel()
            await self.step()
        assert not self.pixels and not self.shadow and not self.reads


def scene(num, lights, mats=20, triangles=60):
    rng = num.rng
    return ([sh.Light.random(num) for _ in range(lights)], [sh.Material.random(num) for _ in range(mats)],
            [sh.Triangle.random(num, rng.randrange(mats)) for _ in range(triangles)])


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(lights=[0, 1, 3, 16], wild=[0.0, 0.05])
async def random_pixels(dut, lights, wild):
    """Frames with and without shadows, new rates and latencies in each."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    num = sh.Numbers(bench.rng, wild)
    await bench.start()
    for latency in ((1, 1), (1, 60), (200, 400)):
        bench.latency = latency
        bench.p_hit, bench.p_sec, bench.p_done, bench.p_req = [bench.rng.choice([1.0, 0.5, 0.1]) for _ in range(4)]
        await bench.frame(num, *scene(num, lights), shadows=bench.rng.random() < 0.7)
        ahead = bench.rng.choice([1, 10, 256]) if latency[1] < 100 else 256
        await bench.run(sh.some(40 if lights > 3 else 100), ahead)
    assert bench.events["culled"] == bench.want_culled
    assert bench.events["info_hit"] + bench.events["info_miss"] == bench.surfaces
    assert not bench.errors


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def no_shadows(dut):
    """Colours are summed at once, in the order of the lights; no shadow ray is made."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_sec=0.0)
    num = sh.Numbers(bench.rng, 0.02)
    await bench.start()
    await bench.frame(num, *scene(num, 16, 256, 300), shadows=False)
    await bench.run(150)
    assert bench.events["culled"] == bench.want_culled > 0


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def more_triangles_than_lines(dut):
    """Triangle information is fetched again after others took its place."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_miss=0.0)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    lights, mats, few = scene(num, 0, 5, 40)
    await bench.frame(num, lights, mats, [few[i * 7 % 40] for i in range(3000)])
    await bench.run(sh.some(1500))
    assert bench.events["info_hit"] > 0 and bench.events["info_miss"] > sh.some(1000)


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def flood(dut):
    """All 256 indices come in while no shadow ray may leave: every hit is taken. Then everything drains."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_sec=0.0, p_miss=0.0, p_blocked=0.5)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    lights, mats, triangles = scene(num, 4)
    for light in lights:                                    # one on each side of any surface, none culled for ever
        light.directional = False
    await bench.frame(num, lights, mats, triangles)
    while bench.free:
        bench.new_pixel()
        await bench.step()
    for _ in range(4000):
        await bench.step()
    assert bench.hits_taken == 256 and bench._hit is None and not bench.to_hit
    assert dut.sec_valid_o.value and len(bench.pixels) > 128
    # Shadow rays leave one by one, and those that come back are taken while the next one waits.
    for _ in range(40):
        left = len(bench.shadow)
        bench.p_sec = 1.0
        while len(bench.shadow) == left:
            await bench.step()
        bench.p_sec = 0.0
        for _ in range(60):
            await bench.step()
        assert not bench.to_hit and not bench.shadow and bench._hit is None
    bench.p_sec = 1.0
    while bench.pixels:
        await bench.step()
        assert bench.cycle < 60000, f"hangs with {len(bench.pixels)} pixels under way"


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(full=["sec", "done", "memory"])
async def long_stops(dut, full):
    """One exit is shut for a thousand cycles at a time."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    await bench.frame(num, *scene(num, 2, 20, 500))
    name = {"sec": "p_sec", "done": "p_done", "memory": "p_req"}[full]
    for _ in range(3):
        setattr(bench, name, 0.0)
        for _ in range(1000):
            if bench.free:
                bench.new_pixel()
            await bench.step()
        setattr(bench, name, 1.0)
        for _ in range(500):
            await bench.step()
    limit = bench.cycle + 20000
    while bench.pixels:
        await bench.step()
        assert bench.cycle < limit


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(case=["culled", "shadow", "miss"])
async def rate(dut, case):
    """One hit and one job in six cycles, sustained: with a light that is culled, and with one whose ray comes back."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_miss=float(case == "miss"), latency=(4, 8))
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    lights, mats, triangles = scene(num, 1, 5, 5)
    light = lights[0]
    light.directional, light.pos = True, [0, 0x3F0000, 0]
    for tri in triangles:
        tri.n = tri.n0 = sh.nearest([0.0, 1.0, 0.0])
        tri.e1 = tri.e2 = [0, 0, 0]
    await bench.frame(num, lights, mats, triangles)

    def direction():                                        # from above: lit; from below: culled
        d = sh.unit(bench.rng)
        d[1] = abs(d[1]) if case == "culled" else -abs(d[1])
        return sh.nearest(d)
    num.direction = direction
    count = 400
    await bench.run(count)
    cycles = (bench.done_at[-20] - bench.done_at[99]) / (count - 119)
    dut._log.info(f"{case}: a pixel in {cycles:.2f} cycles")
    assert cycles <= {"culled": 6.05, "shadow": 6.05, "miss": 3.05}[case]
    assert (bench.events["culled"] == count) == (case == "culled")


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def unknown_material(dut):
    """A material index beyond the count is an error with that index; the unit goes on until the frame is ended."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_miss=0.1)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    lights, mats, triangles = scene(num, 2, 20, 50)
    for tri in triangles[:5]:
        tri.mat = 20
    await bench.frame(num, lights, mats, triangles)
    await bench.run(300)
    assert bench.errors and set(bench.errors) == {9 << 32 | 20}


@pytest.mark.parametrize("latencies", ["paper", "deep", "long"])
def test_rc_shade(latencies):
    """The same tests on builds with other latencies of the functional units."""
    sh.run("rc_shade", latencies, [f"shade/rc_{n}.sv" for n in ("hitpoint", "light", "accum")]
           + ["mem/rc_ro_cache.sv", "shade/rc_shade.sv"], "test_rc_shade")
