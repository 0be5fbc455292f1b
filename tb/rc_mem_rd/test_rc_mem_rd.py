# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_mem_rd: clients get lines and halves in order; bad addresses and bad memories are reported and hang nothing."""

import random
from collections import deque

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "prim/rc_rr_arb.sv", "mem/rc_mem_pkg.sv",
              "mem/rc_mem_rd.sv")
SLVERR, DECERR, WINDOW = 6, 7, 8           # err_e of rc_pkg.sv
TOP = 1 << 26
# line addresses, end exclusive: somewhere, a single line, up to the end of memory, and nothing
WINDOWS = [(0x100, 0x180), (0x2000, 0x2001), (TOP - 16, TOP), (0x500, 0x500)]
INSIDE = [*range(0x100, 0x180), 0x2000, *range(TOP - 16, TOP)]
OUTSIDE = [0, 0xFF, 0x180, 0x1FFF, 0x2001, 0x500, 0x4FF, TOP - 17, 0x3000100 % TOP]


def memory_words(line):
    """Eight words of 64 bits, all used: the top four bits must not come through."""
    rng = random.Random(line)
    return [rng.getrandbits(64) for _ in range(8)]


BOTH = 3


def block_of(line, halves):
    """What the port answers: the block, or one half of it in both places."""
    words = memory_words(line)
    if halves != BOTH:
        words = 2 * words[4 * (halves >> 1):][:4]
    return sum(w << 64 * i for i, w in enumerate(words))


def address(line, halves):
    """Of the first byte."""
    return 64 * line + 32 * (halves == 2)


def asks(lines, k):
    """Random requests: (line, halves)."""
    return [(line, random.choice([1, 2, BOTH, BOTH])) for line in random.choices(lines, k=k)]


class Axi:
    """AXI4 read responder. `spoil(line, beat, beats)` may change a beat: dict with resp, last or extra (more beats after)."""

    def __init__(self, dut, latency, p_ar, p_r, spoil=lambda line, beat, beats: {}):
        self.dut, self.latency, self.p_ar, self.p_r, self.spoil = dut, latency, p_ar, p_r, spoil
        self.beats, self.now, self.lines, self.offer = deque(), 0, [], False
        self.width, self.most, self.sent, self.finished = len(dut.m_axi_rdata), 0, 0, 0

    def drive(self):
        dut = self.dut
        dut.m_axi_arready.value = random.random() < self.p_ar
        due = self.beats and self.beats[0][0] <= self.now
        if not self.offer and due and random.random() < self.p_r:
            _, data, resp, last, rid, _ = self.beats[0]
            dut.m_axi_rdata.value, dut.m_axi_rresp.value, dut.m_axi_rlast.value = data, resp, last
            dut.m_axi_rid.value, self.offer = rid, True
        dut.m_axi_rvalid.value = self.offer

    def sample(self):
        dut = self.dut
        if self.offer and dut.m_axi_rready.value:
            self.finished += self.beats.popleft()[5]
            self.offer = False
        if dut.m_axi_arvalid.value and dut.m_axi_arready.value:
            addr, n = int(dut.m_axi_araddr.value), int(dut.m_axi_arlen.value) + 1
            assert addr % 32 == 0 and n * self.width in ((512, 256) if addr % 64 == 0 else (256,))
            assert int(dut.m_axi_arburst.value) == 1
            assert 8 << int(dut.m_axi_arsize.value) == self.width
            line = addr // 64
            assert line in INSIDE, f"line {line:#x} is outside the windows and was sent"
            self.lines.append(line)
            data = sum(w << 64 * i for i, w in enumerate(memory_words(line))) >> 8 * (addr % 64)
            due = self.now + self.latency()
            for b in range(n):
                bad = self.spoil(line, b, n)
                beat = (due, data >> self.width * b & (1 << self.width) - 1, bad.get("resp", 0),
                        bad.get("last", b == n - 1), bad.get("rid", 0))
                extra = bad.get("extra", 0)
                self.beats.extend([(*beat, False)] * extra + [(*beat, b == n - 1)])
            self.sent += 1
            self.most = max(self.most, self.sent - self.finished)   # bursts not finished
        self.now += 1


class Bench:
    def __init__(self, dut, axi, p_request=1.0):
        self.dut, self.axi, self.p_request = dut, axi, p_request
        self.num = int(dut.NumClients.value)
        self.todo = [deque() for _ in range(self.num)]
        self.open = [deque() for _ in range(self.num)]
        self.got = [[] for _ in range(self.num)]
        self.held = [False] * self.num
        self.errors, self.events = [], 0
        self.asked, self.tag = [0] * self.num, None  # requests taken; tag of the one that went to memory in the last cycle
        self.check = True

    @staticmethod
    def tag_of(client, n):
        """Tag of a client's n-th request."""
        return (5 * client + 3 * n + n // 8) % 8

    async def cycle(self, stop=False):
        dut = self.dut
        dut.stop_i.value = stop
        valid = addr = halves = tags = 0
        for i, todo in enumerate(self.todo):
            self.held[i] = bool(todo) and (self.held[i] or random.random() < self.p_request)
            if self.held[i]:
                valid |= 1 << i
                addr |= todo[0][0] << 26 * i
                halves |= todo[0][1] << 2 * i
                tags |= self.tag_of(i, self.asked[i]) << 3 * i
        dut.req_valid_i.value, dut.req_addr_i.value, dut.req_halves_i.value = valid, addr, halves
        dut.req_tag_i.value = tags
        self.axi.drive()
        await FallingEdge(dut.clk_i)
        self.axi.sample()
        assert not (dut.idle_o.value and any(self.open)), "idle with requests outstanding"
        ready = int(dut.req_ready_o.value) & valid
        assert not (stop and ready), "took a request after stop"
        if dut.ev_line_o.value:
            assert int(dut.ev_tag_o.value) == self.tag, "event of another tag"
        for i in range(self.num):
            if ready >> i & 1:
                self.open[i].append(self.todo[i].popleft())
                self.held[i] = False
                self.tag = self.tag_of(i, self.asked[i])
                self.asked[i] += 1
        if answer := int(dut.rsp_valid_o.value):
            client = answer.bit_length() - 1
            assert answer == 1 << client, "an answer for two"
            want, line = self.open[client].popleft(), int(dut.rsp_block_o.value)
            assert int(dut.rsp_tag_o.value) == self.tag_of(client, len(self.got[client])), "answer with another tag"
            self.got[client].append(want)
            if self.check:
                assert line == (block_of(*want) if want[0] in INSIDE else 0), f"client {client}: wrong data for {want}"
        if dut.err_valid_o.value:
            err = int(dut.err_o.value)
            self.errors.append((err >> 32, err & 0xFFFFFFFF))
        self.events += int(dut.ev_line_o.value).bit_count()
        await RisingEdge(dut.clk_i)

    async def run(self, limit=60_000):
        while any(self.todo) or any(self.open) or self.axi.beats:
            await self.cycle()
            assert self.axi.now < limit, f"hangs: {[list(o)[:3] for o in self.open]}"
        for _ in range(4):
            await self.cycle()
        assert self.dut.idle_o.value


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = 0
    for name in ("req_valid_i", "req_addr_i", "req_halves_i", "req_tag_i", "stop_i", "m_axi_arready", "m_axi_rvalid", "m_axi_rid",
                 "m_axi_rdata", "m_axi_rresp", "m_axi_rlast"):
        getattr(dut, name).value = 0
    windows = 0
    for i, (lo, hi) in enumerate(WINDOWS[:int(dut.NumWindows.value)]):
        windows |= (lo << 27 | hi) << 53 * i
    dut.window_i.value = windows
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(latency=[1, 60, 400], p_ar=[1.0, 0.3], p_r=[1.0, 0.4])
async def random_traffic(dut, latency, p_ar, p_r):
    """Lines of all windows, in and out of them; each client's answers in order; each bad address reported once."""
    await start(dut)
    bench = Bench(dut, Axi(dut, lambda: latency, p_ar, p_r), random.choice([0.2, 1.0]))
    bad = []
    for todo in bench.todo:
        for _ in range(60):
            todo += asks(OUTSIDE if random.random() < 0.1 else INSIDE, 1)
            bad += [todo[-1]] if todo[-1][0] in OUTSIDE else []
    await bench.run()
    assert bench.axi.most <= int(dut.MaxBurst.value)
    assert bench.events == len(bench.axi.lines) == 60 * bench.num - len(bad)
    assert sorted(bench.errors) == sorted((WINDOW, address(*a)) for a in bad)


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(halves=[1, BOTH])
async def full_rate(dut, halves):
    """With a fast memory the data bus is never idle, and clients have equal shares."""
    await start(dut)
    beats = (512 if halves == BOTH else 256) // len(dut.m_axi_rdata)
    bench = Bench(dut, Axi(dut, lambda: 20, 1.0, 1.0))
    for todo in bench.todo:
        todo.extend((line, halves) for line in random.choices(INSIDE, k=500))
    for _ in range(1000):
        await bench.cycle()
    done = [len(g) for g in bench.got]
    assert sum(done) * beats >= min(0.95 * 1000, 0.9 * 1000 * int(dut.MaxBurst.value) * beats / (20 + beats + 2)), done
    assert max(done) - min(done) <= 2, f"unfair: {done}"
    for todo in bench.todo:
        todo.clear()
    bench.held = [False] * bench.num
    await bench.run()


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def memory_errors(dut):
    """SLVERR and DECERR: code and address of the line; data come all the same."""
    await start(dut)
    for code, name in ((2, SLVERR), (3, DECERR)):
        for last in (False, True):
            victim = random.choice(INSIDE)
            spoil = lambda line, b, n: {"resp": code if line == victim and b == (n - 1) * last else b & 1}  # 1: EXOKAY  # noqa: E731, B023
            bench = Bench(dut, Axi(dut, lambda: 10, 0.7, 0.7, spoil))
            for todo in bench.todo:
                todo.extend(asks([a for a in INSIDE if a != victim], 5))
            bench.todo[-1].insert(3, asks([victim], 1)[0])
            await bench.run()
            assert bench.errors == [(name, address(*bench.got[-1][3]))]


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(fault=["last_early", "last_never", "extra_beat", "wrong_id"])
async def broken_memory(dut, fault):
    """RLAST in the wrong place, beats too many, foreign IDs: SLVERR is reported, nobody waits for ever."""
    await start(dut)

    def spoil(line, beat, beats):
        """Every third line comes broken; RLAST cannot be early in a burst of one beat."""
        where = 0 if fault == "last_early" else beats - 1
        change = {"last_early": {"last": 1}, "last_never": {"last": 0}, "extra_beat": {"extra": 1}, "wrong_id": {"rid": 1}}
        return change[fault] if line % 3 == 0 and beat == where and not (fault == "last_early" and beats == 1) else {}

    bench = Bench(dut, Axi(dut, lambda: 10, 0.7, 0.9, spoil), 0.3)
    bench.check = fault != "extra_beat"     # then the data are shifted, and the frame ends in an error anyway
    for todo in bench.todo:
        todo.extend(asks(INSIDE, 20))
    single = 256 // bench.axi.width == 1
    hit = sum(a % 3 == 0 and not (fault == "last_early" and single and h != BOTH) for todo in bench.todo for a, h in todo)
    await bench.run()
    assert {code for code, _ in bench.errors} == {SLVERR}
    if fault != "extra_beat":
        assert len(bench.errors) == hit


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def stop(dut):
    """After stop nothing is taken, what is outstanding is answered, then the port is idle and can be reset."""
    for _ in range(10):
        await start(dut)
        bench = Bench(dut, Axi(dut, lambda: random.choice([1, 40]), 0.5, 0.5))
        for todo in bench.todo:
            todo.extend(asks(INSIDE + OUTSIDE, 40))
        for _ in range(random.randint(1, 150)):
            await bench.cycle()
        for _ in range(3000):
            await bench.cycle(stop=True)
            if dut.idle_o.value:
                break
        assert dut.idle_o.value and not any(bench.open)
        sent = len(bench.axi.lines)
        for _ in range(10):
            await bench.cycle(stop=True)
        assert len(bench.axi.lines) == sent and not dut.m_axi_arvalid.value


@pytest.mark.parametrize("width, clients, bursts", [(64, 4, 16), (128, 4, 16), (256, 4, 16), (64, 10, 32)])
def test_rc_mem_rd(width, clients, bursts):
    run_cocotb("rc_mem_rd", SOURCES, "test_rc_mem_rd", public=["m_axi_*"],
               parameters={"DataW": width, "NumClients": clients, "MaxBurst": bursts, "TagW": 3})
