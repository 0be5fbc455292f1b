# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_info against raycore.model.shade.place: the information of every surface in order, bit for bit; every request of memory as
a plain LRU cache has it; rates."""

import os
import random
from collections import deque
from dataclasses import dataclass, field

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.model import fp24, shade
from raycore.tbutil import Lru, package_with_latencies, rtl, run_cocotb

ONE, ZERO, NAN, INF, HUGE = 0x3F0000, 0, fp24.NAN_BITS, fp24.INF_BITS, 0x7D0000
CORNERS = [ZERO, 0x800000, 0x010000, 0x810000, ONE, 0xBF0000, 0x7EFFFF, 0xFEFFFF, INF, 0xFF0000, NAN, 0x000001, 0x80FFFF, 0x7F0001,
           0xFFFFFF, HUGE, 0xFD0000, 0x7E0000, 0x020000]
PAPER = dict(ADD=2, MUL=1)
LATENCIES = {
    "paper": {},
    "one": dict(ADD=1, MUL=1),
    "deep": dict(ADD=4, MUL=3),
    "adds": dict(ADD=7, MUL=1),       # vertex 0, with its third addition, comes last
}
CACHES = {"full": {}, "small": {"Sets": 4, "Ways": 1, "Depth": 4, "MaxMiss": 2},
          "queue": {"Sets": 16, "Ways": 2, "Depth": 20, "MaxMiss": 3}}
FILES = [*(f"prim/rc_{n}.sv" for n in ("delay", "ram_1r1w", "skid", "fifo")),
         *(f"fp/rc_fp_{n}.sv" for n in ("pipe", "norm", "round", "add", "mul")),
         "mem/rc_ro_cache.sv", *(f"shade/rc_{n}.sv" for n in ("shade_pkg", "carry", "place", "info"))]
LINE_ADDRS = 1 << 26
MAT = 0xFFF << 48                     # of word 0 of tri_info_t
TEX_W, TRI_AT, INST_AT = 224, 168, 192     # tex_t: bits, lowest bit of tri_idx and of inst


def bits(values):
    return [int(b) for b in fp24.to_bits(np.asarray(values, dtype=np.float64)).flat]


def nearest(values):
    return bits(fp24.round_to_fp24(np.asarray(values, dtype=np.float64)))


def line_with(numbers, rest):
    """The line `rest` with FP24 patterns in place: two a word of 60 bits, as tri_info_t and place_t have them."""
    for i, b in enumerate(numbers):
        at = 60 * (i // 2) + 24 * (i % 2)
        rest = rest & ~(0xFFFFFF << at) | b << at
    return rest


def numbers_of(line, count):
    return [line >> 60 * (i // 2) + 24 * (i % 2) & 0xFFFFFF for i in range(count)]


def rotation(rng):
    """(3, 3): any, of the same likelihood."""
    q, r = np.linalg.qr(np.array([[rng.gauss(0, 1) for _ in range(3)] for _ in range(3)]))
    return q * np.sign(np.diag(r))


class World:
    """What memory holds: information of some triangles, places of some instances, by number; all else is not to be read."""

    def __init__(self, rng, tris=40, insts=5, wild=0.0):
        self.rng, self.wild = rng, wild
        tops = (LINE_ADDRS - (1 << 24), LINE_ADDRS - (512 << 2))
        while True:
            self.info_base, self.inst_base = (rng.choice([0, top, rng.randrange(top)]) for top in tops)
            if not -(512 << 2) < self.info_base - self.inst_base < 1 << 24 \
                    and not -(1 << 24) < self.inst_base - self.info_base < 512 << 2:
                break
        self.tris = {t: self.info() for t in {0, (1 << 24) - 1, *(rng.randrange(1 << 24) for _ in range(tris))}}
        self.places = {i: self.place() for i in {1, 511, *(rng.randrange(1, 512) for _ in range(insts))}}

    def spoil(self, patterns):
        rng = self.rng
        return [(rng.choice(CORNERS) if rng.random() < 0.5 else rng.randrange(1 << 24)) if rng.random() < self.wild else b
                for b in patterns]

    def info(self):
        """Bits that no field uses are set at will: nothing may look at them."""
        rng = self.rng
        vectors = [[rng.uniform(-1, 1) * rng.choice([1, 1, 1000, 1e-3]) for _ in range(3)] for _ in range(5)]
        return line_with(self.spoil(nearest(vectors)), rng.getrandbits(480))

    def place(self):
        rng = self.rng
        origin = np.array([[rng.uniform(-3, 3)] for _ in range(3)])
        return line_with(self.spoil(nearest(np.hstack([rotation(rng), origin]))), rng.getrandbits(480))

    def info_addr(self, tri):
        return self.info_base + tri

    def place_addr(self, inst):
        return self.inst_base + 4 * inst + 2

    def memory(self):
        """{line address: line}"""
        return {self.info_addr(t): line for t, line in self.tris.items()} \
            | {self.place_addr(i): line for i, line in self.places.items()}

    def expected(self, tri, inst):
        """What comes of a surface: its line, or that with the fifteen numbers that the model has."""
        line = self.tris[tri]
        if inst == 0:
            return line
        info = fp24.from_bits(np.array(numbers_of(line, 15))).reshape(5, 3)
        placed = fp24.from_bits(np.array(numbers_of(self.places[inst], 12))).reshape(3, 4)
        return line_with(bits(shade.FP24.place(info, placed)), line)

    def surface(self, p_placed):
        rng = self.rng
        inst = rng.choice(list(self.places)) if rng.random() < p_placed else 0
        return rng.choice(list(self.tris)), inst


@dataclass
class Bench:
    """One cycle a step: offers surfaces, plays memory, takes what comes, and checks all of it."""

    dut: object
    rng: random.Random
    p_in: float = 1.0
    p_out: float = 1.0
    p_req: float = 1.0
    p_switch: float = 0.0                            # another surface is offered before one was taken
    latency: int = 20                                # cycles of memory, on average
    ready_every: int = 1                             # rc_hitpoint: ready in one cycle of four
    cycle: int = 0
    world: World = None
    todo: deque = field(default_factory=deque)       # (triangle, instance)
    offered: int = None                              # the word at the input
    flying: deque = field(default_factory=deque)     # (tex_t, triangle, instance) taken
    asked: deque = field(default_factory=deque)      # (line, when) of memory
    addrs: deque = field(default_factory=deque)      # of requests that must come, in this order
    out_at: list = field(default_factory=list)       # cycles
    lookups: int = 0                                 # as events tell
    misses: int = 0

    async def start(self):
        Clock(self.dut.clk_i, 10, unit="ns").start()
        for name in ("in_i", "rsp_line_i", "info_base_i", "inst_base_i"):
            getattr(self.dut, name).value = 0
        await self.reset(World(self.rng))

    async def reset(self, world):
        """Reset, whatever is inside; then memory holds another world."""
        dut = self.dut
        dut.rst_ni.value = 0
        for name in ("in_valid_i", "out_ready_i", "req_ready_i", "rsp_valid_i"):
            getattr(dut, name).value = 0
        for _ in range(2):
            await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1
        self.world, self.lines, self.offered = world, world.memory(), None
        dut.info_base_i.value, dut.inst_base_i.value = world.info_base, world.inst_base
        for queue in (self.todo, self.flying, self.asked, self.addrs):
            queue.clear()
        self.lru, self.inst = Lru(int(dut.Sets.value), int(dut.Ways.value)), 0
        self.lookups = self.misses = self.expected_lookups = self.expected_misses = 0

    def give(self, surfaces):
        """Surfaces to offer, and the lookups that they make if they are offered one after the other."""
        for tri, inst in surfaces:
            self.todo.append((tri, inst))
            addrs = [self.world.info_addr(tri)]
            if inst not in (0, self.inst):
                self.inst = inst
                addrs.insert(0, self.world.place_addr(inst))
            missed = [a for a in addrs if not self.lru.hit(a)]
            self.addrs += missed
            self.expected_lookups += len(addrs)
            self.expected_misses += len(missed)

    def offer(self):
        tri, inst = self.todo[0]
        junk = self.rng.getrandbits(TEX_W) & ~((1 << 33) - 1 << TRI_AT)
        self.offered = junk | tri << TRI_AT | inst << INST_AT
        self.dut.in_i.value = self.offered

    async def step(self):
        dut, rng = self.dut, self.rng
        if self.offered is None:
            if self.todo and rng.random() < self.p_in:
                self.offer()
            elif rng.random() < 0.5:
                dut.in_i.value = rng.getrandbits(TEX_W)
        elif len(self.todo) > 1 and rng.random() < self.p_switch:
            other = rng.randrange(1, min(4, len(self.todo)))
            self.todo[0], self.todo[other] = self.todo[other], self.todo[0]
            self.offer()
        dut.in_valid_i.value = self.offered is not None
        dut.out_ready_i.value = ready = self.cycle % self.ready_every == 0 and rng.random() < self.p_out
        dut.req_ready_i.value = req_ready = rng.random() < self.p_req
        answers = bool(self.asked) and self.asked[0][1] <= self.cycle
        dut.rsp_valid_i.value = answers
        dut.rsp_line_i.value = self.asked.popleft()[0] if answers else rng.getrandbits(480)
        await FallingEdge(dut.clk_i)
        if self.offered is not None and dut.in_ready_o.value:
            self.flying.append((self.offered, *self.todo.popleft()))
            self.offered = None
        if dut.out_valid_o.value and ready:
            self.take()
        if dut.req_valid_o.value and req_ready:
            addr = int(dut.req_addr_o.value)
            assert addr in self.lines, f"request of {addr:#x}, where nothing is"
            if self.p_switch == 0:
                assert addr == self.addrs.popleft(), f"request of {addr:#x} out of turn"
            due = max(self.cycle + rng.randint(1, 2 * self.latency), self.asked[-1][1] + 1 if self.asked else 0)
            self.asked.append((self.lines[addr], due))
        self.misses += int(dut.ev_miss_o.value)
        self.lookups += int(dut.ev_miss_o.value) + int(dut.ev_hit_o.value)
        self.cycle += 1
        await RisingEdge(dut.clk_i)

    def take(self):
        assert self.flying, "a surface nobody gave"
        tex, tri, inst = self.flying.popleft()
        assert int(self.dut.out_o.value) == tex, "another surface, or not the one that was given"
        line, want = int(self.dut.out_info_o.value), self.world.expected(tri, inst)
        got, want_numbers = numbers_of(line, 15), numbers_of(want, 15)
        assert got == want_numbers, f"instance {inst}:\n{show(got)}, not\n{show(want_numbers)}"
        assert line & MAT == want & MAT, "material"
        assert inst or line == want
        self.out_at.append(self.cycle)

    async def run(self, surfaces=()):
        """Give these, then wait until all is out."""
        self.give(surfaces)
        slow = 60 / min(self.p_out / self.ready_every, self.p_in, self.p_req)
        limit = self.cycle + 500 + int((slow + 4 * self.latency) * (len(self.todo) + len(self.flying)))
        while self.todo or self.flying:
            await self.step()
            assert self.cycle < limit, f"hangs with {len(self.flying)} surfaces inside, {len(self.todo)} to come"
        if self.p_switch == 0:
            assert not self.addrs and (self.lookups, self.misses) == (self.expected_lookups, self.expected_misses)
        for _ in range(3):
            await self.step()
            assert not self.dut.out_valid_o.value


def show(numbers):
    return " ".join(f"{b:06x}" for b in numbers)


def some(count):
    """`count`, or a part of it on the builds with other latencies, which are there for the schedules."""
    return count if os.environ["BUILD"] == "paper-full" else max(1, count // 4)


def last_time():
    """T_OUT of rc_place: the cycle of a job in which its result can be taken, as its header says it."""
    lat = PAPER | LATENCIES[os.environ["BUILD"].split("-")[0]]
    dot = lat["MUL"] + 2 * lat["ADD"]
    return max(dot + 7, dot + lat["ADD"] + 3)


async def make(dut, **settings):
    bench = Bench(dut, random.Random(cocotb.RANDOM_SEED), **settings)
    await bench.start()
    return bench


@cocotb.test(timeout_time=60, timeout_unit="ms")
@cocotb.parametrize(wild=[0.0, 0.05, 0.5],
                    rates=[(1.0, 1.0, 1.0, 1), (0.3, 1.0, 0.3, 60), (1.0, 0.2, 1.0, 10), (0.7, 0.6, 0.5, 300)])
async def random_surfaces(dut, wild, rates):
    """Placed and not, runs of the same instance and changes, gaps everywhere, some or many numbers being corners; between worlds a
    reset in mid-flight, after which the same instances stand elsewhere."""
    bench = await make(dut, p_in=rates[0], p_out=rates[1], p_req=rates[2], latency=rates[3])
    rng = bench.rng
    for _ in range(2):
        await bench.reset(World(rng, tris=rng.choice([6, 40, 200]), insts=rng.choice([0, 6, 30]), wild=wild))
        for p_placed in (0.5, rng.choice([0.0, 0.1, 0.9, 1.0])):
            surfaces = []
            for _ in range(some(40)):
                tri, inst = bench.world.surface(p_placed)
                surfaces += [(rng.choice([tri, bench.world.surface(0)[0]]), inst) for _ in range(rng.choice([1, 1, 4]))]
            await bench.run(surfaces)
        bench.give(bench.world.surface(0.5) for _ in range(100))
        for _ in range(rng.randint(1, 150)):
            await bench.step()
    await bench.reset(World(rng))
    await bench.run(bench.world.surface(0.5) for _ in range(10))


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def reset_at_every_time(dut):
    """A reset a cycle later each time, from a job's first cycle to after its last: the next job is whole, with the new place."""
    bench = await make(dut, latency=1)
    for cycles in range(1, last_time() + 16):
        await bench.reset(World(bench.rng, tris=1, insts=0))
        bench.give([(0, 1), (0, 511)])
        for _ in range(cycles):
            await bench.step()
        await bench.reset(World(bench.rng, tris=1, insts=0))
        await bench.run([(0, 1), (0, 1)])


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def corner_numbers(dut):
    """All numbers are corners; vectors of which any other order of additions makes another sum; the axes by themselves."""
    bench = await make(dut, latency=1)
    rng = bench.rng
    big, small = nearest([2.0**20, 2.0**20 + 16]), nearest([1, -1, 0.75, 3])
    flip = 0x800000

    def cancels():
        b = rng.choice(big)
        return rng.sample([b, b ^ flip, rng.choice(small)], 3)

    for kind in ("wild", "sum", "axes"):
        for _ in range(some(8)):
            world = World(rng, tris=some(20), insts=6, wild=1.0)
            if kind == "sum":
                world.tris = {t: line_with([b for _ in range(5) for b in cancels()], line) for t, line in world.tris.items()}
                world.places = {i: line_with([b for _ in range(3) for b in (ONE, ONE, ONE, rng.choice([*small, *big]))], line)
                                for i, line in world.places.items()}
            elif kind == "axes":                     # a rotation that only picks: each number of a place by itself
                world.wild = 0.0
                world.tris = {t: world.info() for t in world.tris}
                for n, i in enumerate(world.places):
                    m = [ZERO] * 12
                    m[n % 12], m[(n + 5) % 12] = ONE, nearest([-2])[0]
                    world.places[i] = line_with(m, rng.getrandbits(480))
            await bench.reset(world)
            await bench.run((t, rng.choice(list(world.places))) for t in world.tris)


@cocotb.test(timeout_time=60, timeout_unit="ms")
@cocotb.parametrize(p_switch=[0.2, 0.6], latency=[1, 40])
async def another_is_offered(dut, p_switch, latency):
    """Until one is taken, another may be offered, of another instance or none: what comes is of those that were taken."""
    bench = await make(dut, p_switch=p_switch, latency=latency, p_out=0.7)
    for insts in (0, 6):
        await bench.reset(World(bench.rng, insts=insts))
        await bench.run(bench.world.surface(0.7) for _ in range(some(200)))
    bench.p_switch, bench.p_out = 0.0, 1.0
    await bench.reset(World(bench.rng))
    await bench.run(bench.world.surface(0.7) for _ in range(20))


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def shut_exit(dut):
    """Nobody takes what comes: the unit fills, and stays as it is; then all of it comes."""
    bench = await make(dut, p_out=0.0)
    for first in (0, 1):                             # instance of what stands at the exit
        await bench.reset(World(bench.rng))
        bench.give([(0, first), *(bench.world.surface(0.5) for _ in range(100))])
        for _ in range(1500):
            await bench.step()
        taken = len(bench.flying)
        for _ in range(200):
            await bench.step()
        assert len(bench.flying) == taken <= int(dut.Depth.value) + 3
        bench.p_out = 0.5
        await bench.run()
        bench.p_out = 0.0


async def periods(bench, surfaces):
    """Cycles from result to result, once every line is in the cache."""
    await bench.run(surfaces[:4])                    # the lines come
    bench.out_at.clear()
    misses = bench.misses
    await bench.run(surfaces)
    assert bench.misses == misses, "not all of it was in the cache"
    return set(np.diff(bench.out_at).tolist())


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def rates(dut):
    """While all of it hits: one that is not placed a cycle; a placed one as fast as rc_place is; one more cycle if the instance is
    another. With an exit that is open in one cycle of four, as rc_hitpoint's: four cycles, and the next multiple of four."""
    bench = await make(dut)
    sets = int(dut.Sets.value)
    time = last_time() + 1                           # in the last, the next one comes up
    if os.environ["BUILD"].startswith("paper"):
        assert time == 13
    for every in (1, 4):
        bench.ready_every = every
        world = World(bench.rng)
        world.info_base = world.info_base // sets * sets
        world.inst_base = (world.inst_base + sets) // sets * sets
        world.tris = {t: world.info() for t in (0, 1)}                   # in other sets than the places
        world.places = {i: world.place() for i in (2, 3)}
        await bench.reset(world)

        def rounded(cycles):
            return {-(-cycles // bench.ready_every) * bench.ready_every}

        assert await periods(bench, [(0, 0), (1, 0)] * 100) == rounded(1)
        assert await periods(bench, [(0, 2), (1, 2)] * 20) == rounded(time)
        if sets > 4:
            assert await periods(bench, [(0, 2), (1, 3)] * 20) == rounded(time + 1)


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def latency_of_one(dut):
    """A surface by itself that hits comes as soon as out of the cache alone; a placed one T_OUT later."""
    bench = await make(dut)
    through = 5 if int(dut.Depth.value) > 16 else 3
    await bench.run([(0, 1), (0, 1)])
    for inst, cycles in ((0, through), (1, through + last_time())):
        begin = bench.cycle
        await bench.run([(0, inst)])
        assert bench.out_at[-1] - begin == cycles


@pytest.mark.parametrize("latencies, cache", [("paper", "full"), ("one", "small"), ("deep", "small"), ("adds", "queue")])
def test_rc_info(latencies, cache):
    """The same tests on builds with other latencies of the functional units, and other caches."""
    run_cocotb("rc_info", [package_with_latencies(**LATENCIES[latencies]), *rtl(*FILES, package=False)], "test_rc_info",
               parameters=CACHES[cache], defines={"LATENCIES": latencies}, env={"BUILD": f"{latencies}-{cache}"})
