# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_mem_wr: memory ends up as the rows say, pixel by pixel; errors are reported; stop ends cleanly."""

import random
from collections import deque

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "mem/rc_mem_pkg.sv", "mem/rc_mem_wr.sv")
SLVERR, DECERR, WINDOW = 6, 7, 8           # err_e of rc_pkg.sv
LO, HI = 0x40, 0x80                        # the window, in lines of 64 bytes


class Axi:
    """AXI4 write responder with a memory of bytes; addresses and data may arrive in any order to each other."""

    def __init__(self, dut, p_aw, p_w, p_b, latency, resp=lambda addr: 0):
        self.dut, self.p, self.latency, self.resp = dut, (p_aw, p_w, p_b), latency, resp
        self.memory, self.addresses, self.rows, self.answers = {}, deque(), deque(), deque()
        self.row, self.now, self.offer, self.bursts, self.most = [], 0, False, 0, 0
        self.width, self.rows_open, self.answered = len(dut.m_axi_wdata), 0, False

    def drive(self):
        dut = self.dut
        dut.m_axi_awready.value, dut.m_axi_wready.value = (random.random() < p for p in self.p[:2])
        if not self.offer and self.answers and self.answers[0][0] <= self.now and random.random() < self.p[2]:
            self.offer, dut.m_axi_bresp.value = True, self.answers[0][1]
        dut.m_axi_bvalid.value = self.offer

    def sample(self):
        dut = self.dut
        self.answered = bool(self.offer and dut.m_axi_bready.value and self.rows_open)
        if self.offer and dut.m_axi_bready.value:
            self.answers.popleft()
            self.offer = False
            self.rows_open -= self.answered
        if dut.m_axi_awvalid.value and dut.m_axi_awready.value:
            addr, n = int(dut.m_axi_awaddr.value), int(dut.m_axi_awlen.value) + 1
            assert addr % 32 == 0 and n * self.width == 256 and int(dut.m_axi_awburst.value) == 1
            assert 8 << int(dut.m_axi_awsize.value) == self.width
            assert LO <= addr // 64 < HI, f"{addr:#x} is outside the window and was sent"
            self.addresses.append(addr)
            self.bursts += 1
            self.rows_open += 1
        if dut.m_axi_wvalid.value and dut.m_axi_wready.value:
            self.row.append((int(dut.m_axi_wdata.value), int(dut.m_axi_wstrb.value)))
            assert bool(dut.m_axi_wlast.value) == (len(self.row) * self.width == 256), "WLAST in the wrong place"
            if dut.m_axi_wlast.value:
                self.rows.append(self.row)
                self.row = []
        while self.addresses and self.rows:
            addr, row = self.addresses.popleft(), self.rows.popleft()
            size = self.width // 8
            for b, (data, strb) in enumerate(row):
                for i in range(size):
                    if strb >> i & 1:
                        self.memory[addr + b * size + i] = data >> 8 * i & 0xFF
            self.answers.append((self.now + self.latency(), self.resp(addr)))
        self.most = max(self.most, len(self.answers))
        self.now += 1


class Bench:
    def __init__(self, dut, axi, p_valid=1.0):
        self.dut, self.axi, self.p_valid = dut, axi, p_valid
        self.todo, self.held, self.sent, self.errors, self.expected = deque(), False, 0, [], {}
        self.answered = False              # an answer was taken in the cycle before

    async def cycle(self, stop=False):
        dut = self.dut
        self.held = bool(self.todo) and (self.held or random.random() < self.p_valid)
        dut.stop_i.value, dut.wr_valid_i.value = stop, self.held
        if self.held:
            addr, pixels, strobes = self.todo[0]
            dut.wr_addr_i.value, dut.wr_strb_i.value = addr, strobes
            dut.wr_data_i.value = sum(p << 32 * i for i, p in enumerate(pixels))
        self.axi.drive()
        await FallingEdge(dut.clk_i)
        self.axi.sample()
        if self.held and dut.wr_ready_o.value:
            assert not stop, "took a row after stop"
            addr, pixels, strobes = self.todo.popleft()
            self.held = False
            if LO <= addr // 64 < HI:
                for i in range(32):
                    if strobes >> i // 4 & 1:
                        self.expected[addr + i] = pixels[i // 4] >> 8 * (i % 4) & 0xFF
        self.sent += int(dut.ev_row_o.value)
        assert bool(dut.ack_o.value) == self.answered, "ack_o comes one cycle after an answer to a row"
        self.answered = self.axi.answered
        if dut.err_valid_o.value:
            err = int(dut.err_o.value)
            self.errors.append((err >> 32, err & 0xFFFFFFFF))
        await RisingEdge(dut.clk_i)

    async def run(self, limit=60_000):
        for _ in range(3):
            await self.cycle()
        while self.todo or not self.dut.idle_o.value:
            await self.cycle()
            assert self.axi.now < limit, "hangs"
        for _ in range(3):
            await self.cycle()
        assert not self.axi.answers and not self.axi.rows and not self.axi.addresses
        assert self.axi.memory == self.expected, "memory differs from what was written"


def row(line=None, strobes=None):
    line = random.randrange(LO, HI) if line is None else line
    return (line * 64 + random.choice([0, 32]), [random.getrandbits(32) for _ in range(8)],
            random.choice([0xFF, 1, 0x80, random.randrange(1, 256)]) if strobes is None else strobes)


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = 0
    for name in ("wr_valid_i", "wr_addr_i", "wr_data_i", "wr_strb_i", "stop_i", "m_axi_awready", "m_axi_wready",
                 "m_axi_bvalid", "m_axi_bid", "m_axi_bresp"):
        getattr(dut, name).value = 0
    dut.window_i.value = LO << 27 | HI
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(p_aw=[1.0, 0.2], p_w=[1.0, 0.2], p_b=[1.0, 0.2])
async def random_rows(dut, p_aw, p_w, p_b):
    """Random rows and strobes; rows outside are reported and not sent; rows without pixels are left out anywhere."""
    await start(dut)
    bench = Bench(dut, Axi(dut, p_aw, p_w, p_b, lambda: random.choice([1, 100])), random.choice([0.3, 1.0]))
    bad, empty = [], 0
    for _ in range(200):
        kind = random.random()
        if kind < 0.1:
            bench.todo.append(row(random.choice([0, LO - 1, HI, 0x3FFFFFF])))
            bad.append(bench.todo[-1][0])
        elif kind < 0.2:
            bench.todo.append(row(random.choice([LO, 0, HI, LO - 1]), strobes=0))
            empty += 1
        else:
            bench.todo.append(row())
    await bench.run()
    assert bench.errors == [(WINDOW, a) for a in bad]
    assert bench.sent == bench.axi.bursts == 200 - len(bad) - empty


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def outstanding(dut):
    """Several rows on their way, never more than MaxBurst, however late the answers."""
    await start(dut)
    bench = Bench(dut, Axi(dut, 1.0, 1.0, 1.0, lambda: 500))
    bench.todo.extend(row() for _ in range(60))
    await bench.run()
    assert bench.axi.most == int(dut.MaxBurst.value)


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(code=[1, 2, 3])
async def memory_errors(dut, code):
    """SLVERR and DECERR with the row's address; EXOKAY is no error."""
    await start(dut)
    bench = Bench(dut, Axi(dut, 0.7, 0.7, 0.7, lambda: 20, lambda addr: code if addr == (LO + 9) * 64 + 32 else 0))
    bench.todo.extend(row(LO + i) for i in range(9))
    bench.todo.append(((LO + 9) * 64 + 32, [1] * 8, 0xFF))
    bench.todo.extend(row(LO + 10 + i) for i in range(9))
    await bench.run()
    name = {2: SLVERR, 3: DECERR}.get(code)
    assert bench.errors == ([(name, (LO + 9) * 64 + 32)] if name else [])


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def stray_answer(dut):
    """An answer that nobody waits for is reported; the port goes on."""
    await start(dut)
    bench = Bench(dut, Axi(dut, 1.0, 1.0, 1.0, lambda: 20))
    bench.axi.answers.append((0, 0))
    await bench.run()
    assert bench.errors == [(SLVERR, 0)]
    bench.todo.extend(row() for _ in range(10))
    await bench.run()
    assert len(bench.errors) == 1


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def stop(dut):
    """After stop nothing is taken, what was taken is written and confirmed."""
    for _ in range(10):
        await start(dut)
        bench = Bench(dut, Axi(dut, 0.5, 0.5, 0.5, lambda: 30))
        bench.todo.extend(row() for _ in range(100))
        for _ in range(random.randint(1, 200)):
            await bench.cycle()
        for _ in range(2000):
            await bench.cycle(stop=True)
        assert dut.idle_o.value and not bench.axi.answers and bench.axi.memory == bench.expected


@pytest.mark.parametrize("width", [64, 128, 256])
def test_rc_mem_wr(width):
    run_cocotb("rc_mem_wr", SOURCES, "test_rc_mem_wr", parameters={"DataW": width}, public=["m_axi_*"])
