# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_ro_cache: every request answered in order with its line and payload; hits and misses as a plain LRU has them."""

import functools
import random
from collections import deque

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.tbutil import Lru, rtl, run_cocotb

SOURCES = rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "mem/rc_ro_cache.sv")


@functools.cache
def line_of(addr):
    """What memory holds: 480 bits that no other line has."""
    return random.Random(addr).getrandbits(480)


class Bench:
    def __init__(self, dut, latency, p_in=1.0, p_out=1.0, p_req=1.0):
        self.dut, self.latency, self.p_in, self.p_out, self.p_req = dut, latency, p_in, p_out, p_req
        self.todo, self.flying, self.memory = deque(), deque(), deque()
        self.held, self.now, self.hits, self.misses, self.done, self.most = False, 0, 0, 0, 0, 0

    async def cycle(self):
        dut = self.dut
        self.held = bool(self.todo) and (self.held or random.random() < self.p_in)
        dut.in_valid_i.value = self.held
        if self.held:
            dut.in_addr_i.value, dut.in_data_i.value = self.todo[0]
        dut.out_ready_i.value = random.random() < self.p_out
        dut.req_ready_i.value = random.random() < self.p_req
        answer = self.memory and self.memory[0][1] <= self.now
        dut.rsp_valid_i.value = bool(answer)
        if answer:
            dut.rsp_line_i.value = line_of(self.memory.popleft()[0])
        await FallingEdge(dut.clk_i)
        if self.held and dut.in_ready_o.value:
            self.flying.append(self.todo.popleft())
            self.held = False
        if dut.out_valid_o.value and dut.out_ready_i.value:
            addr, data = self.flying.popleft()
            assert int(dut.out_data_o.value) == data, "payload lost or out of order"
            assert int(dut.out_line_o.value) == line_of(addr), f"wrong line for {addr:#x}"
            self.done += 1
        if dut.req_valid_o.value and dut.req_ready_i.value:
            due = max(self.now + self.latency(), self.memory[-1][1] + 1 if self.memory else 0)
            self.memory.append((int(dut.req_addr_o.value), due))
        self.most = max(self.most, len(self.memory))
        self.hits += int(dut.ev_hit_o.value)
        self.misses += int(dut.ev_miss_o.value)
        self.now += 1
        await RisingEdge(dut.clk_i)

    async def run(self, limit=60_000):
        while self.todo or self.flying:
            await self.cycle()
            assert self.now < limit, f"hangs with {len(self.flying)} requests inside"


async def reset(dut):
    dut.rst_ni.value = 0
    for name in ("in_valid_i", "out_ready_i", "req_ready_i", "rsp_valid_i"):
        getattr(dut, name).value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.in_addr_i.value = dut.in_data_i.value = dut.rsp_line_i.value = 0
    await reset(dut)
    return int(dut.Sets.value), int(dut.Ways.value)


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(latency=[1, 60, 400], p_out=[1.0, 0.2], p_req=[1.0, 0.3])
async def random_traffic(dut, latency, p_out, p_req):
    """Few sets, runs of the same line, gaps everywhere; then a reset in mid-flight."""
    sets, ways = await start(dut)
    for _ in range(2):
        tags = [0, (1 << 25) // sets, (1 << 26) // sets - 1, *random.sample(range((1 << 26) // sets), 2 * ways)]
        lines = [t * sets + s for t in tags for s in (0, 1, sets - 1)]
        bench, model = Bench(dut, lambda: random.randint(1, 2 * latency), random.choice([0.3, 1.0]), p_out, p_req), \
            Lru(sets, ways)
        hits = 0
        while len(bench.todo) < (300 if latency < 400 else 100):
            addr = random.choice(lines)
            for _ in range(random.choice([1, 1, 3])):
                bench.todo.append((addr, random.randrange(256)))
                hits += model.hit(addr)
        total = len(bench.todo)
        await bench.run()
        assert (bench.hits, bench.misses) == (hits, total - hits)
        bench.todo.extend((random.choice(lines), 0) for _ in range(200))
        for _ in range(random.randint(1, 100)):
            await bench.cycle()
        await reset(dut)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def full_rate(dut):
    """Hits: one a cycle. Misses overlap: as many as MaxMiss are under way."""
    sets, ways = await start(dut)
    bench = Bench(dut, lambda: 100)
    bench.todo.extend((a, 1) for a in range(min(sets, 64)))
    await bench.run()
    assert bench.most == int(dut.MaxMiss.value)
    assert bench.now <= 110 * len(range(min(sets, 64))) / bench.most + 110, "misses do not overlap"
    begin = bench.now
    bench.todo.extend((random.randrange(min(sets, 64)), 1) for _ in range(1000))
    await bench.run()
    assert bench.now - begin <= 1010, f"1000 hits took {bench.now - begin} cycles"
    begin = bench.now
    bench.todo.append((0, 1))
    await bench.run()                      # both cycles included, hence + 1
    assert bench.now - begin == (5 if int(dut.Depth.value) > 16 else 3) + 1


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def early_hits_pass(dut):
    """A hit behind a miss waits (order), but its own misses behind it are already on their way."""
    sets, ways = await start(dut)
    bench = Bench(dut, lambda: 200)
    bench.todo.extend((a, a & 0xFF) for a in (0, 0, 0, 1, 0, 1))
    await bench.run()
    assert bench.now < 2 * 200, "two misses one after the other"


@pytest.mark.parametrize("parameters", [
    {}, {"Sets": 4, "Ways": 1, "Depth": 4, "MaxMiss": 2}], ids=["default", "small"])
def test_rc_ro_cache(parameters):
    run_cocotb("rc_ro_cache", SOURCES, "test_rc_ro_cache", parameters=parameters)
