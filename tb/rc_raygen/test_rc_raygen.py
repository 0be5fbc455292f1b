# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_raygen against raycore.model.rgen: every ray, in order, bit for bit; rays from shading first; one ray in four cycles.

Cameras are random ones, plus those whose rays are parallel to an axis, tiny, of no length, or not a number at all.
The unit is also built with other latencies of the functional units: results and rate must not change.
"""

import random
from dataclasses import dataclass, field

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import fp24, rgen
from raycore.tbutil import package_with_latencies, rtl, run_cocotb

HUGE, T_MIN, NAN_BITS, TRI_NONE = 0x7D0000, 0x310000, fp24.NAN_BITS, (1 << 24) - 1
PRIMARY, SHADOW, REFLECT, TRANSMIT = range(4)  # ray_kind_e
CORNERS = [0x000000, 0x800000, 0x010000, 0x810000, 0x3F0000, 0xBF0000, 0x7EFFFF, 0xFEFFFF, 0x7F0000, 0xFF0000, NAN_BITS]


def bits(vector):
    return [int(b) for b in fp24.to_bits(np.asarray(vector, dtype=np.float64))]


def pack(*fields):
    """A packed struct from (value, width) pairs, the first field highest; a list is a vec3_t, x lowest."""
    word = 0
    for value, width in fields:
        if isinstance(value, list):
            value, width = value[0] | value[1] << 24 | value[2] << 48, 72
        assert 0 <= value < 1 << width
        word = word << width | value
    return word


def ray_word(ray_id, any_hit, skip, t_min, t_max, inv_dir, direction, org):
    return pack((ray_id, 8), (any_hit, 1), (skip, 33), (t_min, 24), (t_max, 24), (inv_dir, 72), (direction, 72), (org, 72))


def path_word(ray_id, is_primary, direction, org):
    return pack((ray_id, 8), (is_primary, 1), (direction, 72), (org, 72))


def primary(camera, ray_id, x, y):
    """(pri_t, ray_t, path_ray_t) of a pixel."""
    d = np.empty(3)
    rgen.primary_direction(camera.c, camera.u, camera.v, x, y, d)
    direction = bits(d)
    ray = ray_word(ray_id, 0, TRI_NONE, T_MIN, HUGE, bits([rgen.inverse(v) for v in d]), direction, bits(camera.org))
    return pack((ray_id, 8), (x, 16), (y, 16)), ray, path_word(ray_id, 1, direction, bits(camera.org))


def secondary(rng, ray_id):
    """(sec_t, ray_t, path_ray_t or None) of a random ray from shading; one component in four is a corner."""
    def number():
        if rng.random() < 0.25:
            return rng.choice(CORNERS)
        return fp24.to_bits(fp24.round_to_fp24(rng.uniform(-1, 1) * 2.0 ** rng.choice([0, 0, 0, -10, -30, -61]))).item()

    direction, org = [number() for _ in range(3)], [number() for _ in range(3)]
    skip, t_min, t_max = rng.randrange(1 << 33), number(), number()
    kind = rng.choice([SHADOW, SHADOW, REFLECT, TRANSMIT])
    inv = bits([rgen.inverse(v) for v in fp24.from_bits(direction)])
    sec = pack((ray_id, 8), (kind, 2), (rng.randrange(16), 4), (rng.randrange(16), 4), (skip, 33), (t_min, 24), (t_max, 24),
               (direction, 72), (org, 72))  # fmt: skip
    path = None if kind == SHADOW else path_word(ray_id, 0, direction, org)
    return sec, ray_word(ray_id, int(kind == SHADOW), skip, t_min, t_max, inv, direction, org), path


def random_camera(rng):
    eye, target = [np.array([rng.uniform(-1, 1) for _ in range(3)]) for _ in range(2)]
    return rgen.camera_registers(eye, target, [rng.uniform(-1, 1) for _ in range(3)], rng.uniform(5, 120), 800, 480)


def corner_cameras():
    zero = np.zeros(3)
    for axis in range(3):
        for sign in (1.0, -1.0):
            c = np.array([0.0, 0.0, 0.0])
            c[axis] = sign
            yield rgen.Camera(zero, c, zero, zero)                               # parallel to an axis
            yield rgen.Camera(zero, c, np.roll(c, 1) * 2.0**-10, -zero)          # in a plane of two axes
    yield rgen.Camera(zero, zero, zero, zero)                                    # no length: 0 * inf
    yield rgen.Camera(zero, np.array([2.0**-40, 0, 2.0**-62]), zero, zero)       # the square is lost
    yield rgen.Camera(zero, np.array([2.0**-30, 2.0**-31, -(2.0**-62)]), zero, zero)
    yield rgen.Camera(zero, np.array([2.0**40, 1.0, -1.0]), zero, zero)          # the square overflows
    yield rgen.Camera(zero, np.array([1.0, 2.0**-61, -(2.0**-62)]), zero, zero)  # 1/d at its largest
    yield rgen.Camera(zero, np.array([np.nan, 1.0, np.inf]), zero, zero)


@dataclass
class Bench:
    """Drives both inputs and the output of rc_raygen, one cycle a step, and checks all that comes out."""

    dut: object
    rng: random.Random
    p_pri: float = 1.0
    p_sec: float = 0.0
    p_ready: float = 1.0
    camera: object = None
    expected: list = field(default_factory=list)
    cycle: int = 0
    taken: dict = field(default_factory=lambda: {"pri": 0, "sec": 0})
    left_at: list = field(default_factory=list)
    pixels: object = None
    words: list = field(default_factory=list)
    homes: dict = field(default_factory=dict)  # ray index -> pipeline its pixel's block prefers
    _pri: object = None
    _sec: object = None
    _id: int = 0

    async def start(self):
        Clock(self.dut.clk_i, 10, unit="ns").start()
        self.dut.rst_ni.value = 0
        self.dut.pri_valid_i.value = self.dut.sec_valid_i.value = self.dut.ray_ready_i.value = 0
        for _ in range(3):
            await RisingEdge(self.dut.clk_i)
        self.dut.rst_ni.value = 1
        self._ready = 0

    def set_camera(self, camera):
        assert not self.expected, "the camera may change only between frames"
        self.camera = camera
        self.dut.cam_i.value = pack(*[(bits(v), 72) for v in camera])

    def _next_id(self):
        self._id = (self._id + 1) % 256
        return self._id

    def _pixel(self):
        if self.pixels is not None:
            return next(self.pixels)
        return tuple(self.rng.choice([0, 1, 65535, self.rng.randrange(800), self.rng.randrange(65536)]) for _ in "xy")

    async def step(self):
        """Drive new values, wait for the edge, look at what it will take."""
        dut, rng = self.dut, self.rng
        if self._pri is None and rng.random() < self.p_pri:
            ray_id, (x, y) = self._next_id(), self._pixel()
            self._pri = *primary(self.camera, ray_id, x, y), ray_id, (y >> 3 & 1) * 2 + (x >> 3 & 1)
            dut.pri_i.value = self._pri[0]
        if self._sec is None and rng.random() < self.p_sec:
            ray_id = rng.choice([*self.homes, self._next_id()])
            self._sec = *secondary(rng, ray_id), ray_id
            dut.sec_i.value = self._sec[0]
        ready = rng.random() < self.p_ready
        dut.pri_valid_i.value = self._pri is not None
        dut.sec_valid_i.value = self._sec is not None
        dut.ray_ready_i.value = ready
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        pri = self._pri is not None and bool(dut.pri_ready_o.value)
        sec = self._sec is not None and bool(dut.sec_ready_o.value)
        assert not (pri and self._sec is not None), "a primary ray went before one from shading that waits"
        leaves = bool(dut.ray_valid_o.value) and ready
        if leaves:
            assert self.expected, "a ray nobody asked for"
            ray, path, home = self.expected.pop(0)
            got = int(dut.ray_o.value)
            assert got == ray, f"ray {len(self.left_at)} is\n{got:075x}, not\n{ray:075x}"
            assert home is None or int(dut.ray_home_o.value) == home, "a ray prefers another pipeline than its block"
            self.left_at.append(self.cycle)
            self.words.append(got)
            assert bool(dut.path_ray_valid_o.value) == (path is not None)
            if path is not None:
                assert int(dut.path_ray_o.value) == path
        else:
            assert not dut.path_ray_valid_o.value
        if pri:
            ray, path, ray_id, self.homes[ray_id] = self._pri[1:]
            self.expected.append((ray, path, self.homes[ray_id]))
            self.taken["pri"] += 1
            self._pri = None
        if sec:
            ray, path, ray_id = self._sec[1:]
            self.expected.append((ray, path, self.homes.get(ray_id)))
            self.taken["sec"] += 1
            self._sec = None

    async def run(self, rays):
        """Let this many more rays in, then let all of them out."""
        limit = self.cycle + 4000 + int(rays * 40 / self.p_ready)
        goal = sum(self.taken.values()) + rays
        p = self.p_pri, self.p_sec
        while sum(self.taken.values()) < goal or self._pri or self._sec or self.expected:
            if sum(self.taken.values()) >= goal:
                self.p_pri = self.p_sec = 0.0
            assert self.cycle < limit, f"hangs with {len(self.expected)} rays inside"
            await self.step()
        self.p_pri, self.p_sec = p


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(p_pri=[1.0, 0.2], p_sec=[0.1, 0.4], p_ready=[1.0, 0.4, 0.1])
async def random_rays(dut, p_pri, p_sec, p_ready):
    """Both kinds of rays, several cameras, gaps and back-pressure."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_pri, p_sec, p_ready)
    await bench.start()
    for _ in range(4):
        bench.set_camera(random_camera(bench.rng))
        await bench.run(60)
    assert min(bench.taken.values()) > 0


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def corner_directions(dut):
    """Rays parallel to axes, tiny, without length, NaN; and corners in the directions from shading."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), 1.0, 0.05)
    await bench.start()
    for camera in corner_cameras():
        bench.set_camera(camera)
        await bench.run(20)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def whole_picture(dut):
    """All pixels of a picture against `primary_rays`, which is what the reference renderer uses."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED))
    await bench.start()
    bench.set_camera(rgen.camera_registers((0.2, 0.5, 0.9), (0, 0, 0), (0, 1, 0), 60, 24, 16))
    direction, inv_dir = rgen.primary_rays(bench.camera, 24, 16)
    bench.pixels = ((i % 24, i // 24) for i in range(24 * 16 + 1))
    await bench.run(24 * 16)
    for word, d, inv in zip(bench.words, direction.reshape(-1, 3), inv_dir.reshape(-1, 3)):
        assert [word >> s & 0xFFFFFF for s in range(72, 216, 24)] == bits(d) + bits(inv)


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize((("p_pri", "p_sec"), [(1.0, 0.0), (0.0, 1.0), (1.0, 0.1), (1.0, 1.0)]))
async def one_ray_in_four_cycles(dut, p_pri, p_sec):
    """The rate holds for any mix as long as rays are offered and taken."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), p_pri, p_sec)
    await bench.start()
    bench.set_camera(random_camera(bench.rng))
    await bench.run(200)
    gaps = {b - a for a, b in zip(bench.left_at[:190], bench.left_at[1:190])}
    assert gaps == {4}, f"cycles from ray to ray: {sorted(gaps)}"
    assert p_sec < 1.0 or bench.taken["pri"] <= 1, "rays from shading were always there: no primary ray may start"


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def waits_for_the_exit(dut):
    """Nobody takes rays for long: the unit fills, stops taking, and loses nothing. Then it goes on."""
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), 1.0, 0.2, 0.0)
    await bench.start()
    bench.set_camera(random_camera(bench.rng))
    for _ in range(400):
        await bench.step()
    full = sum(bench.taken.values())
    for _ in range(100):
        await bench.step()
    assert 8 <= full == sum(bench.taken.values()) <= 64
    bench.p_ready = 0.7
    await bench.run(100)


LATENCIES = {"paper": {}, "deep": dict(ADD=4, ADD3=5, MUL=3, CMP=2, DIV=9, SQRT=4, CONV=2),
             "one": dict(ADD=1, ADD3=1, MUL=1, CMP=1, DIV=1, SQRT=1, CONV=1),
             "odd": dict(ADD=3, ADD3=3, MUL=2, CMP=1, DIV=5, SQRT=3, CONV=1),
             "long": dict(ADD=2, ADD3=4, MUL=1, CMP=1, DIV=20, SQRT=5, CONV=3)}


@pytest.mark.parametrize("latencies", LATENCIES)
def test_rc_raygen(latencies):
    """The same tests on builds with other latencies."""
    package = package_with_latencies(**LATENCIES[latencies])
    prim = [f"prim/rc_{n}.sv" for n in ("delay", "ram_1r1w", "skid", "fifo")]
    units = [f"fp/rc_fp_{n}.sv" for n in ("pipe", "norm", "round", "from_int", "mul", "add3", "sqrt", "div")]
    run_cocotb("rc_raygen", [package, *rtl(*prim, *units, "rgen/rc_raygen.sv", package=False)], "test_rc_raygen",
               defines={"LATENCIES": latencies})
