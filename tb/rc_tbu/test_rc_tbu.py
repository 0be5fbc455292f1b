# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_tbu with its memory ports against raycore.model.tbu.build: every node, every list; then errors of memory."""

import os
import random
from collections import deque
from dataclasses import replace

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge
from tbu_tb import CFG, SHAPES, Memory, pack, references, vertex_records

from raycore.model import tbu
from raycore.model.tbu_memory import compare, pack_box, walk_memory
from raycore.sim import rtl_sources
from raycore.tbu_sim import COUNTERS
from raycore.tbutil import run_cocotb
from raycore.toolchain import REPO

VERTEX, REF, LIST, NODE = 0x1000, 0x20000, 0x80000, 0xC0000   # lines
SEED = int(os.environ.get("RAYCORE_SEED", "1"), 0)
OK, E_NODE, E_LIST, E_REF, E_COUNT, E_COORD, E_BUS = range(7)
BEATS = 8                                  # a line, at 64 bits


class Axi:
    """AXI4 memory: bursts in order, reads `latency` after their address; bad(byte, write) answers with an error."""

    def __init__(self, dut, p, latency):
        self.dut, self.p, self.latency = dut, p, latency
        self.beats, self.addresses, self.rows, self.row, self.answers = deque(), deque(), deque(), [], deque()
        self.read_offer = self.write_offer = False
        self.now, self.bad = 0, lambda byte, write: False

    def ready(self):
        return random.random() < self.p

    def drive(self):
        dut = self.dut
        dut.m_axi_arready.value, dut.m_axi_awready.value, dut.m_axi_wready.value = self.ready(), self.ready(), self.ready()
        if not self.read_offer and self.beats and self.beats[0][0] <= self.now and self.ready():
            _, dut.m_axi_rdata.value, dut.m_axi_rresp.value, dut.m_axi_rlast.value = self.beats[0]
            self.read_offer = True
        if not self.write_offer and self.answers and self.answers[0][0] <= self.now and self.ready():
            self.write_offer, dut.m_axi_bresp.value = True, self.answers[0][1]
        dut.m_axi_rvalid.value, dut.m_axi_bvalid.value = self.read_offer, self.write_offer

    def sample(self):
        dut = self.dut
        if self.read_offer and dut.m_axi_rready.value:
            self.beats.popleft()
            self.read_offer = False
        if self.write_offer:
            self.answers.popleft()
            self.write_offer = False
        if dut.m_axi_arvalid.value and dut.m_axi_arready.value:
            byte, due = int(dut.m_axi_araddr.value), self.now + self.latency()
            resp = 2 * self.bad(byte, False)
            for b in range(BEATS):
                self.beats.append((due, self.memory.get(byte + 8 * b, 8), resp, b == BEATS - 1))
        if dut.m_axi_awvalid.value and dut.m_axi_awready.value:
            self.addresses.append(int(dut.m_axi_awaddr.value))
        if dut.m_axi_wvalid.value and dut.m_axi_wready.value:
            self.row.append((int(dut.m_axi_wdata.value), int(dut.m_axi_wstrb.value)))
            if dut.m_axi_wlast.value:
                self.rows.append(self.row)
                self.row = []
        while self.addresses and self.rows:
            byte, row = self.addresses.popleft(), self.rows.popleft()
            for b, (data, strb) in enumerate(row):
                for half in (0, 1):
                    if strb >> 4 * half & 1:
                        self.memory.put(byte + 8 * b + 4 * half, data >> 32 * half, 4)
            self.answers.append((self.now + self.latency(), 2 * self.bad(byte, True)))
        self.now += 1


class Bench:
    def __init__(self, dut, p=1.0, latency=lambda: 30):
        self.dut, self.axi = dut, Axi(dut, p, latency)

    async def cycle(self, start=False):
        self.dut.start_i.value = start
        self.axi.drive()
        await FallingEdge(self.dut.clk_i)
        self.axi.sample()
        self.done, self.busy = bool(self.dut.done_o.value), bool(self.dut.busy_o.value)
        await RisingEdge(self.dut.clk_i)

    async def build(self, vertices, refine_max=0, nodes=64, lists=64, limit=200_000, alone=False):
        """One build, alone in its regions or behind other trees. Returns its code."""
        n, cap = len(vertices), int(self.dut.Cap.value)
        opaque = np.random.default_rng(SEED).random(n) < 0.7
        self.axi.memory = memory = Memory(SEED)
        for i, record in enumerate(vertex_records(vertices, opaque)):
            memory.put(VERTEX * 64 + 32 * i, record, 32)
        some = 0 if alone else 1
        firsts = {"node_first": some * 128 * random.choice((0, 1, 5)), "list_first": some * 256 * random.choice((0, 1, 5)),
                  "tri_first": some * random.choice((0, 1, 100_003))}  # fmt: skip
        refs = references(vertices, opaque)
        self.refs = replace(refs, tri=refs.tri + firsts["tri_first"])
        self.nodes, self.lists = 128 * nodes + firsts["node_first"], 256 * lists + firsts["list_first"]
        box = self.refs.box
        self.dut.cfg_i.value = pack(
            CFG, vertex_base=VERTEX, tri_count=n, node_base=NODE, node_count=self.nodes, list_base=LIST,
            list_count=self.lists, ref_base=REF, ref_count=16 * cap + 8 * n + 64, refine_max=refine_max,
            box=pack_box(box[0], box[1]), **firsts)  # fmt: skip
        begin = self.axi.now
        await self.cycle(start=True)
        await self.cycle()
        while not self.done:
            await self.cycle()
            assert self.axi.now - begin < limit, "hangs"
        assert not self.axi.beats and not self.axi.answers and not self.axi.rows and not self.axi.addresses
        await self.cycle()
        assert not self.busy
        return int(self.dut.err_o.value)

    def difference(self, refine_max):
        expected = tbu.build(self.refs, cap=int(self.dut.Cap.value), refine_max=refine_max)
        get = self.axi.memory.get
        nodes = np.array([get(NODE * 64 + 8 * i, 8) for i in range(self.nodes)], np.uint64)
        lists = np.array([get(LIST * 64 + 4 * i, 4) for i in range(self.lists)], np.uint32)
        found = walk_memory(nodes, lists, int(self.dut.root_o.value), self.refs.box)
        word = int(self.dut.stat_o.value)
        self.stat = {s: word >> 32 * (len(COUNTERS) - 1 - i) & 0xFFFFFFFF for i, s in enumerate(COUNTERS)}
        return compare(expected, found)


async def reset(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = 0
    for name in ("start_i", "cfg_i", "m_axi_arready", "m_axi_rid", "m_axi_rdata", "m_axi_rresp", "m_axi_rlast", "m_axi_rvalid",
                 "m_axi_awready", "m_axi_wready", "m_axi_bid", "m_axi_bresp", "m_axi_bvalid"):  # fmt: skip
        getattr(dut, name).value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(p=[1.0, 0.5])
async def trees(dut, p):
    """Builds one after the other, of all kinds of geometry."""
    await reset(dut)
    rng, cap = np.random.default_rng([SEED, int(10 * p)]), int(dut.Cap.value)
    bench = Bench(dut, p, random.choice([lambda: 30, lambda: random.choice([5, 60, 100])]))
    most = {"flat": 40, "needles": 50}                 # these make many nodes of few triangles
    sizes = [("soup", 0), ("soup", 1), ("soup", 5), ("soup", cap), ("clusters", cap)]
    sizes += [(s, 2 * cap) for s in (SHAPES if p == 1.0 else random.sample(list(SHAPES), 3))]
    donations = 0
    for shape, n in sizes:
        n = min(n, most.get(shape, n))
        refine = random.choice([0, 2 * cap])
        assert await bench.build(SHAPES[shape](rng, n), refine) == OK, f"{shape}, {n} triangles"
        difference = bench.difference(refine)
        assert difference is None, f"{shape}, {n} triangles: {difference}"
        s = bench.stat
        donations += s["donations"]
        dut._log.info(f"{shape}: {n} triangles, {s['cycles'] / max(n, 1):.0f} cycles a triangle, "
                      f"{(64 * s['lines'] + 32 * s['rows']) / max(n, 1):.0f} bytes, {s}")  # fmt: skip
    assert donations, "nothing was donated"


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def errors(dut):
    """Regions that are too small, answers with errors at any time: the code, nothing outside, and then a good build."""
    await reset(dut)
    rng, cap = np.random.default_rng(SEED), int(dut.Cap.value)
    bench = Bench(dut, 0.8, lambda: random.choice([5, 60]))
    v = SHAPES["soup"](rng, cap + 40)
    for sizes, code in (({"nodes": 1}, E_NODE), ({"lists": 1}, E_LIST)):
        assert await bench.build(v, **sizes) == code
    for line, write in ((VERTEX + 3, False), (REF + 4 * cap, True), (REF, False), (NODE + 64 * 16 - 4, True), (LIST, True)):
        bench.axi.bad = lambda byte, w, line=line, write=write: byte // 64 == line and w == write
        assert await bench.build(v, alone=True) == E_BUS, f"line {line:#x}"
        bench.axi.bad = lambda byte, write: False
    assert await bench.build(v) == OK
    assert bench.difference(0) is None


@pytest.mark.parametrize("cap", [160])            # subtrees of 64 references are worth donating
def test_rc_tbu(cap):
    run_cocotb("rc_tbu_sim_top", [*sorted((REPO / "lint").glob("*.vlt")), *rtl_sources(), "sim/rc_tbu_sim_top.sv"], "test_rc_tbu",
               parameters={"Cap": cap}, public=["m_axi_*"])  # fmt: skip
