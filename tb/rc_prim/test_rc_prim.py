# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The building blocks of rtl/prim/: queues lose, invent and reorder nothing and run at full rate; the arbiter is fair;
an index has one owner; delays are as long as they say. All in one build (rc_prim_all.sv)."""

import random
from collections import deque
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.tbutil import rtl, run_cocotb

DEPTHS = [2, 1, 2, 5, 16, 5, 33]           # of the queues in rc_prim_all.sv; the first is the skid buffer
LATENCY = [1, 1, 1, 1, 1, 3, 3]            # cycles from input to output of an empty queue


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = 0
    for name in ("in_valid_i", "in_data_i", "out_ready_i", "req_i", "req_ready_i", "idx_ready_i", "free_valid_i",
                 "free_idx_i", "delay_i"):
        getattr(dut, name).value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


def field(port, q, width=32):
    return int(port.value) >> q * width & (1 << width) - 1


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(p_in=[1.0, 0.3], p_out=[1.0, 0.3])
async def queues(dut, p_in, p_out):
    """Every queue against a Python deque, word for word; count and capacity; a reset empties them."""
    for _ in range(2):
        await start(dut)
        inside, offer, passed = [deque() for _ in DEPTHS], [None] * len(DEPTHS), [0] * len(DEPTHS)
        fullest = [0] * len(DEPTHS)
        for n in range(1500):
            for q in range(len(DEPTHS)):
                if offer[q] is None and random.random() < p_in:
                    offer[q] = random.getrandbits(32)
            p = 0.0 if n % 300 < 150 else p_out      # now and then nobody takes anything: they fill up
            ready = sum((random.random() < p) << q for q in range(len(DEPTHS)))
            dut.in_valid_i.value = sum((w is not None) << q for q, w in enumerate(offer))
            dut.in_data_i.value = sum((w or 0) << 32 * q for q, w in enumerate(offer))
            dut.out_ready_i.value = ready
            await FallingEdge(dut.clk_i)
            in_ready, out_valid = int(dut.in_ready_o.value), int(dut.out_valid_o.value)
            for q, depth in enumerate(DEPTHS):
                assert q == 0 or field(dut.count_o, q, 8) == len(inside[q])
                if out_valid >> q & 1:
                    assert inside[q], f"queue {q} invented a word"
                    assert field(dut.out_data_o, q) == inside[q][0], f"queue {q}: wrong word"
                    if ready >> q & 1:
                        inside[q].popleft()
                        passed[q] += 1
                if offer[q] is not None and in_ready >> q & 1:
                    inside[q].append(offer[q])
                    offer[q] = None
                assert len(inside[q]) <= depth
                fullest[q] = max(fullest[q], len(inside[q]))
            await RisingEdge(dut.clk_i)
        assert fullest == DEPTHS, "a queue does not hold what it should"
        floor = 1500 * 0.5 * min(p_in, p_out) * 0.4
        assert min(passed) > floor, f"slow: {passed}"


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def queue_rate(dut):
    """Latency of an empty queue; then a word a cycle through all that hold two or more at that latency."""
    await start(dut)
    dut.out_ready_i.value = (1 << len(DEPTHS)) - 1
    dut.in_valid_i.value = (1 << len(DEPTHS)) - 1
    first, count = [None] * len(DEPTHS), [0] * len(DEPTHS)
    for n in range(200):
        await FallingEdge(dut.clk_i)
        for q in range(len(DEPTHS)):
            if int(dut.out_valid_o.value) >> q & 1:
                first[q] = n if first[q] is None else first[q]
                count[q] += 1
        await RisingEdge(dut.clk_i)
    assert first == LATENCY
    for q, depth in enumerate(DEPTHS):
        if depth > LATENCY[q]:
            assert count[q] == 200 - LATENCY[q], f"queue {q} passes {count[q]} words in 200 cycles"


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def arbiter(dut):
    """One grant, to one who asks; the next in turn; nobody waits for more than all others once."""
    await start(dut)
    num = len(dut.req_i)
    last, waited = num - 1, [0] * num
    for _ in range(3000):
        req, ready = random.choice([random.getrandbits(num), (1 << num) - 1, 0]), random.random() < 0.7
        dut.req_i.value, dut.req_ready_i.value = req, ready
        await FallingEdge(dut.clk_i)
        turn = [(last + 1 + i) % num for i in range(num)]
        want = next((i for i in turn if req >> i & 1), None)
        assert int(dut.gnt_o.value) == (0 if want is None else 1 << want)
        if want is not None:
            assert int(dut.gnt_idx_o.value) == want
            if ready:
                last = want
                for i in range(num):
                    waited[i] = waited[i] + 1 if req >> i & 1 and i != want else 0
                assert max(waited) < num
        await RisingEdge(dut.clk_i)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def pool(dut):
    """All indices are free at first; each has one owner; freed ones come back; after a reset all are free again."""
    num = int(dut.NumIdx.value)
    for _ in range(2):
        await start(dut)
        owned, seen = [], set()
        for n in range(1500):
            take = random.random() < (0.9 if n % 200 < 100 else 0.2)
            give = bool(owned) and random.random() < (0.2 if n % 200 < 100 else 0.9)
            idx = owned.pop(random.randrange(len(owned))) if give else 0
            dut.idx_ready_i.value, dut.free_valid_i.value, dut.free_idx_i.value = take, give, idx
            await FallingEdge(dut.clk_i)
            assert int(dut.free_count_o.value) == num - len(owned) - give
            if dut.idx_valid_o.value and take:
                got = int(dut.idx_o.value)
                assert got < num and got not in owned and not (give and got == idx), f"index {got} has two owners"
                owned.append(got)
                seen.add(got)
            await RisingEdge(dut.clk_i)
        assert seen == set(range(num))
        dut.free_valid_i.value, dut.idx_ready_i.value = 0, 1
        for _ in range(num + 4):
            await FallingEdge(dut.clk_i)
            if dut.idx_valid_o.value:
                owned.append(int(dut.idx_o.value))
            await RisingEdge(dut.clk_i)
        assert sorted(owned) == list(range(num)), "an index was lost"


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def delay(dut):
    """By 0, 1 and 7 cycles."""
    await start(dut)
    sent = []
    for _ in range(100):
        sent.append(random.getrandbits(8))
        dut.delay_i.value = sent[-1]
        await FallingEdge(dut.clk_i)
        for i, cycles in enumerate((0, 1, 7)):
            if len(sent) > cycles:
                assert field(dut.delay_o, i, 8) == sent[-1 - cycles]
        await RisingEdge(dut.clk_i)


def test_rc_prim():
    run_cocotb("rc_prim_all", [*rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "prim/rc_rr_arb.sv",
                                    "prim/rc_idx_pool.sv", "prim/rc_delay.sv"),
                               Path(__file__).with_name("rc_prim_all.sv")], "test_rc_prim")
