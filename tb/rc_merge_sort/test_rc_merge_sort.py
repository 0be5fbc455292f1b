# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_merge_sort against Python's own stable sort: any length, duplicates, sorted and reversed input, gaps."""

import random

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.tbutil import REPO, rtl, run_cocotb

SOURCES = [
    *rtl("prim/rc_delay.sv", "prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "tbu/rc_run_sort.sv",
         "tbu/rc_merge_sort.sv"),
    REPO / "tb/rc_merge_sort/rc_merge_sort_mem.sv",
]
BUILDS = {
    "paper": dict(KeyW=20, ItemW=12, MaxLen=300, Run=16, RdLat=2),
    "short": dict(KeyW=3, ItemW=9, MaxLen=67, Run=2, RdLat=1),
    "late": dict(KeyW=6, ItemW=12, MaxLen=300, Run=4, RdLat=5),
}


class Sorter:
    """Drives one stream after the other and reads the results."""

    def __init__(self, dut):
        self.dut, self.busy, self.writes = dut, 0, 0

    async def start(self):
        dut = self.dut
        Clock(dut.clk_i, 10, unit="ns").start()
        for name in ("rst_ni", "start_i", "max_len_i", "in_valid_i", "in_key_i", "in_item_i", "end_i", "res_idx_i"):
            getattr(dut, name).value = 0
        await self.cycle()
        await self.cycle()
        dut.rst_ni.value = 1

    async def cycle(self):
        await FallingEdge(self.dut.clk_i)
        self.busy += int(self.dut.busy_o.value)
        self.writes += int(self.dut.wr_valid_o.value)
        await RisingEdge(self.dut.clk_i)

    async def sort(self, keys, max_len=None, p_valid=1.0, end_late=0):
        """Sort keys, each with its place as its item. Returns (key, item) pairs; checks length, side and order of writes."""
        dut = self.dut
        run, passes = int(dut.Run.value), 0
        max_len = len(keys) if max_len is None else max_len
        while run << 2 * passes < max_len:
            passes += 1
        self.busy = self.writes = 0
        dut.start_i.value = 1
        await self.cycle()
        dut.start_i.value = 0
        for i, key in enumerate(keys):
            while random.random() >= p_valid:
                dut.in_valid_i.value = 0
                await self.cycle()
            dut.in_valid_i.value, dut.in_key_i.value, dut.in_item_i.value = 1, key, i
            dut.end_i.value = i == len(keys) - 1 and not end_late
            dut.max_len_i.value = max_len
            await self.cycle()
        dut.in_valid_i.value = dut.end_i.value = 0
        if end_late or not keys:
            for _ in range(end_late):
                await self.cycle()
            dut.end_i.value, dut.max_len_i.value = 1, max_len
            await self.cycle()
            dut.end_i.value = 0
        for _ in range(20 * (len(keys) + 100)):
            if not dut.busy_o.value:
                break
            await self.cycle()
        assert not dut.busy_o.value, "hangs"
        assert int(dut.len_o.value) == len(keys) and self.writes == len(keys) * (passes + 1)
        assert int(dut.side_o.value) == passes % 2
        cycles, out, lat = self.busy, [], int(dut.RdLat.value)
        for i in range(len(keys) + lat):
            dut.res_idx_i.value = min(i, int(dut.MaxLen.value) - 1)
            await FallingEdge(dut.clk_i)
            if i >= lat:
                out.append(int(dut.res_o.value))
            await RisingEdge(dut.clk_i)
        bits = int(dut.ItemW.value)
        return [(w >> bits, w & (1 << bits) - 1) for w in out], cycles, passes


def streams(top, most):
    """Keys of many kinds: (name, list)."""
    yield "none", []
    yield "one", [top]
    for n in {2, 3, 15, 16, 17, 31, 33, 63, 64, 65, most - 1, most}:
        if n <= most:
            yield "random", [random.randint(0, top) for _ in range(n)]
            yield "few values", [random.choice([0, top, top // 2]) for _ in range(n)]
    for n in (most, random.randint(1, most)):
        ups = sorted(random.randint(0, top) for _ in range(n))
        yield "sorted", ups
        yield "reversed", ups[::-1]
        yield "all the same", [random.randint(0, top)] * n
        yield "saw", [i * 3 % (top + 1) for i in range(n)]
    for _ in range(12):
        yield "random", [random.randint(0, top) for _ in range(random.randint(0, most))]


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def every_kind(dut):
    """Each stream comes out sorted, equal keys in their order; several streams, one after another, without a reset."""
    s = Sorter(dut)
    await s.start()
    most = int(dut.MaxLen.value)
    for name, keys in streams((1 << int(dut.KeyW.value)) - 1, most):
        bound = random.choice([len(keys), random.randint(len(keys), most)])
        got, _, _ = await s.sort(keys, bound, random.choice([1.0, 0.5]), random.choice([0, 0, 1, 40]))
        want = sorted(((k, i) for i, k in enumerate(keys)), key=lambda e: e[0])
        assert got == want, f"{name}, {len(keys)} keys: differs first at " + str(
            next((i, g, w) for i, (g, w) in enumerate(zip(got, want)) if g != w))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def rate(dut):
    """A pass takes a cycle an item and a few a group, whatever the order of the keys."""
    s = Sorter(dut)
    await s.start()
    n, run, lat = int(dut.MaxLen.value), int(dut.Run.value), int(dut.RdLat.value)
    for name, keys in (("random", [random.getrandbits(3) for _ in range(n)]), ("sorted", [7 * i // n for i in range(n)]),
                       ("reversed", [7 - 7 * i // n for i in range(n)])):
        _, cycles, passes = await s.sort(keys)
        groups = sum(-(-n // (run << 2 * p + 2)) for p in range(passes))
        dut._log.info(f"{name}: {n} items, {passes} passes, {groups} groups, {cycles} cycles")
        assert cycles <= (passes + 1) * n + groups * (2 * lat + 10) + run + 3 * passes + 10


@pytest.mark.parametrize("build", BUILDS)
def test_rc_merge_sort(build):
    run_cocotb("rc_merge_sort_mem", SOURCES, "test_rc_merge_sort", parameters=BUILDS[build])
