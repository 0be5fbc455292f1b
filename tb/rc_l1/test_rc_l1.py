# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_l1 under looping rays: right lines, one request a line, progress whatever the rays want.

21 rays go round as in a pipeline, one lookup a cycle; a ray that misses asks again in its next loop. The L2 cache
is a Python model that answers late, out of order and with gaps.
"""

import functools
import random

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "mem/rc_l1_pend.sv", "mem/rc_l1.sv")
RAYS = 21


@functools.cache
def half_of(addr):
    """What memory holds: 240 bits that no other half of a line has."""
    return random.Random(addr).getrandbits(240)


def line_of(addr, halves):
    """The line of half `addr`: these halves of it, zeros for the other."""
    return sum(half_of(addr & ~1 | h) << 240 * h for h in range(2) if halves >> h & 1)


class L2:
    """Answers each request once, `latency()` cycles later, at times with the other half as well; checks that no half is
    asked for twice."""

    def __init__(self, dut, latency, p_ready=1.0, p_fill=1.0, p_both=0.3):
        self.dut, self.latency, self.p_ready, self.p_fill, self.p_both = dut, latency, p_ready, p_fill, p_both
        self.open, self.fills, self.now, self.asked = {}, 0, 0, 0
        self.offer = None

    def drive(self):
        dut = self.dut
        if self.offer is None:
            due = [a for a, t in self.open.items() if t <= self.now]
            if due and random.random() < self.p_fill:
                self.offer = min(due, key=self.open.get)
                both = random.random() < self.p_both
                line = line_of(self.offer, 3 if both else 1 << (self.offer & 1))
                dut.fill_addr_i.value, dut.fill_both_i.value, dut.fill_line_i.value = self.offer, both, line
        dut.fill_valid_i.value = self.offer is not None
        dut.req_ready_i.value = random.random() < self.p_ready

    def sample(self):
        dut = self.dut
        if dut.req_valid_o.value and dut.req_ready_i.value:
            addr = int(dut.req_addr_o.value)
            assert addr not in self.open, f"half {addr:#x} asked for twice"
            self.open[addr] = self.now + self.latency()
            self.asked += 1
        if self.offer is not None and dut.fill_ready_o.value:
            del self.open[self.offer]
            self.offer = None
            self.fills += 1
        self.now += 1


class Ring:
    """Rays that loop: ray = cycle mod `rays`. `choose(ray)` is the line that a ray wants next."""

    def __init__(self, dut, l2, choose, rays=RAYS):
        self.dut, self.l2, self.choose, self.rays = dut, l2, choose, rays
        self.want = [choose(r) for r in range(rays)]
        self.hits, self.since, self.longest = [0] * rays, [0] * rays, 0
        self.misses = self.conflicts = self.drops = self.whole = 0
        self.last, self.quiet, self.longest_quiet = None, 0, 0

    async def run(self, cycles=None, until=None, p_lookup=1.0):
        dut, n = self.dut, 0
        while (n < cycles) if cycles is not None else not until():
            ray = n % self.rays
            look = random.random() < p_lookup
            dut.lookup_valid_i.value, dut.lookup_addr_i.value = look, self.want[ray]
            self.l2.drive()
            await FallingEdge(dut.clk_i)
            self.l2.sample()
            self.result()
            self.last = ray if look else None
            n += 1
            assert n < 200_000, "no end of it"
            await RisingEdge(dut.clk_i)
        dut.lookup_valid_i.value = 0
        self.l2.drive()
        await FallingEdge(dut.clk_i)
        self.l2.sample()
        self.result()
        self.last = None
        await RisingEdge(dut.clk_i)

    def result(self):
        dut, ray = self.dut, self.last
        hit, miss = int(dut.hit_o.value), int(dut.miss_o.value)
        assert hit + miss == (ray is not None), "a lookup has one result, one cycle later"
        self.conflicts += int(dut.ev_conflict_o.value)
        self.drops += int(dut.ev_drop_o.value)
        self.quiet = 0 if hit else self.quiet + 1
        self.longest_quiet = max(self.longest_quiet, self.quiet)
        if hit:
            want, halves, line = self.want[ray], int(dut.halves_o.value), int(dut.line_o.value)
            assert halves >> (want & 1) & 1, f"a hit without the half {want:#x}"
            for h in (h for h in range(2) if halves >> h & 1):
                assert line >> 240 * h & (1 << 240) - 1 == half_of(want & ~1 | h), f"wrong line for {want:#x}, half {h}"
            self.whole += halves == 3
            self.hits[ray] += 1
            self.longest = max(self.longest, self.l2.now - self.since[ray])
            self.want[ray], self.since[ray] = self.choose(ray), self.l2.now
        elif miss:
            self.misses += 1


async def reset(dut):
    dut.rst_ni.value = 0
    for port in (dut.lookup_valid_i, dut.req_ready_i, dut.fill_valid_i):
        port.value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.lookup_addr_i.value = dut.fill_addr_i.value = dut.fill_both_i.value = dut.fill_line_i.value = 0
    await reset(dut)


def some_lines(sets, tags, total_sets):
    """Both halves of lines of few sets, so that they compete, with tags of extreme values among them."""
    tag_w = 26 - (total_sets - 1).bit_length()
    pick = [0, 1 << tag_w - 1, (1 << tag_w) - 1, *random.sample(range(1 << tag_w), tags - 3)]
    lines = [t * total_sets + s for t in pick for s in random.sample(range(total_sets), sets)]
    return [2 * line + h for line in lines for h in range(2)]


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(p_ready=[1.0, 0.3], p_fill=[1.0, 0.4])
async def random_traffic(dut, p_ready, p_fill):
    """Every ray gets every line it wants, in bounded time; resets in between empty the cache."""
    await start(dut)
    lines = some_lines(min(4, int(dut.Sets.value)), 4, int(dut.Sets.value))
    for _ in range(3):
        l2 = L2(dut, lambda: random.choice([1, 5, 20, 100]), p_ready, p_fill)
        ring = Ring(dut, l2, lambda _: random.choice(lines))
        await ring.run(cycles=4000, p_lookup=random.choice([0.6, 1.0]))
        assert min(ring.hits) > 0 and ring.longest < 4000, f"a ray starves: {ring.hits}, longest {ring.longest}"
        if int(dut.MaxPend.value) >= RAYS:
            assert ring.drops == 0
        await ring.run(cycles=random.randrange(1, 30))    # and cut it off in mid-flight
        await reset(dut)
        assert not int(dut.busy_o.value)
        probe = Ring(dut, L2(dut, lambda: 1000), lambda _: random.choice(lines))
        await probe.run(cycles=100)
        assert sum(probe.hits) == 0, "a line survived the reset"
        await reset(dut)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def resident(dut):
    """As many lines as the cache holds: each half is asked for once and then always hits, both halves in one way."""
    await start(dut)
    sets, ways = int(dut.Sets.value), int(dut.Ways.value)
    lines = [2 * ((7 * w + s % 5) * sets + s) + h for s in range(sets) for w in range(ways) for h in range(2)]
    random.shuffle(lines)
    order = iter(lines * 3)
    l2 = L2(dut, lambda: random.randrange(1, 40), p_both=0.0)
    ring = Ring(dut, l2, lambda _: next(order, lines[0]))
    await ring.run(until=lambda: sum(ring.hits) >= 3 * len(lines))
    assert l2.asked == len(lines), f"{l2.asked} requests for {len(lines)} lines"
    await ring.run(cycles=100)
    assert not int(dut.busy_o.value) and ring.whole >= len(lines)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def other_half(dut):
    """What came along is there, and only that; and a line's second half never drives another line out."""
    await start(dut)
    sets, ways = int(dut.Sets.value), int(dut.Ways.value)
    for both in (1.0, 0.0):
        await reset(dut)
        l2 = L2(dut, lambda: 3, p_both=both)
        lines = [2 * (tag * sets + 3) for tag in range(1, 1 + ways)]
        for addr in (*lines, *(line + 1 for line in lines)):
            ring = Ring(dut, l2, lambda _, addr=addr: addr, rays=1)
            await ring.run(until=lambda ring=ring: ring.hits[0])
            assert (ring.misses == 0) == (both == 1.0 and addr & 1), f"half {addr:#x}, both {both}"
        assert l2.asked == (ways if both else 2 * ways)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def replacement(dut):
    """With one ray: an empty way first, then the line used longer ago. A locked set keeps its lines."""
    await start(dut)
    sets, ways, lock = (int(p.value) for p in (dut.Sets, dut.Ways, dut.Lock))
    if ways != 2:
        return
    l2 = L2(dut, lambda: 3)
    a, b, c = (2 * (tag * sets + 5) + tag % 2 for tag in (1, 2, 3))

    async def look(addr):
        """Look until it hits; returns the misses."""
        ring = Ring(dut, l2, lambda _: addr, rays=1)
        await ring.run(until=lambda: ring.hits[0])
        return ring.misses

    for first, second in ((a, b), (b, a)):
        await reset(dut)
        assert await look(first) and await look(second)
        assert not await look(first), "one of two lines was evicted"
        assert await look(c), "the third line cannot be there"
        assert not await look(first), "the line used last was evicted"
        assert await look(second), "the line used longer ago was kept"
    if lock:
        await reset(dut)      # ask for two lines and never come back: the third has to wait
        ring = Ring(dut, l2, lambda ray: [a, b][ray], rays=2)
        await ring.run(cycles=2)
        idle = Ring(dut, l2, lambda _: a)
        await idle.run(until=lambda: l2.fills >= 2 and not l2.open, p_lookup=0)
        begin = l2.now
        assert await look(c)
        waited = l2.now - begin
        assert lock - 15 <= waited <= 2 * lock + 15, f"a locked set was opened after {waited} cycles"


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(latency=[30, 60])
async def livelock(dut, latency):
    """21 rays, each after lines of its own, all of one set: without the lock they evict each other for ever."""
    await start(dut)
    sets, lock = int(dut.Sets.value), int(dut.Lock.value) or 64
    count = [0] * RAYS

    def choose(ray):
        count[ray] += 1
        return 2 * ((ray * 50 + count[ray] % 3) * sets + 7) + ray % 2

    ring = Ring(dut, L2(dut, lambda: latency), choose)
    await ring.run(cycles=8000)
    cocotb.log.info("%d hits, at most %d cycles without one", sum(ring.hits), ring.longest_quiet)
    assert ring.longest_quiet <= 2 * lock + latency, f"livelock: no hit for {ring.longest_quiet} cycles"
    assert min(ring.hits) >= 8000 // (2 * lock * RAYS), f"livelock: rays without progress, {ring.hits}"


@pytest.mark.parametrize("parameters", [
    {"Lock": 64}, {"Sets": 8, "Ways": 1, "MaxPend": 3, "FillFifo": 1}], ids=["default", "direct"])
def test_rc_l1(parameters):
    run_cocotb("rc_l1", SOURCES, "test_rc_l1", parameters=parameters)


def test_rc_l1_without_lock_livelocks():
    """The directed test finds the livelock that the lock cures."""
    with pytest.raises(AssertionError, match="livelock: rays without progress"):
        run_cocotb("rc_l1", SOURCES, "test_rc_l1", parameters={"Lock": 0}, testcase=r"livelock/latency=30")
