# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_mem_share: every row of every writer once and in its order, answers to whom they belong, nobody waits for ever."""

import random
from collections import deque

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "prim/rc_rr_arb.sv", "mem/rc_mem_share.sv")


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(p_valid=[1.0, 0.3], p_ready=[1.0, 0.3], p_ack=[1.0, 0.15])
async def rows(dut, p_valid, p_ready, p_ack):
    writers, rows_each = len(dut.wr_valid_i), 150
    todo = [deque((random.getrandbits(27) << 5, random.getrandbits(256), random.randrange(1, 256)) for _ in range(rows_each))
            for _ in range(writers)]
    valid, sent, open_, waits = [False] * writers, deque(), [0] * writers, [0] * writers
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = dut.wr_valid_i.value = dut.port_ready_i.value = dut.port_ack_i.value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1
    while any(todo) or sent:
        for w in range(writers):
            valid[w] = valid[w] or (bool(todo[w]) and random.random() < p_valid)
        head = [t[0] if t else (0, 0, 0) for t in todo]
        dut.wr_valid_i.value = sum(v << w for w, v in enumerate(valid))
        dut.wr_addr_i.value = sum(h[0] << 32 * w for w, h in enumerate(head))
        dut.wr_data_i.value = sum(h[1] << 256 * w for w, h in enumerate(head))
        dut.wr_strb_i.value = sum(h[2] << 8 * w for w, h in enumerate(head))
        ready = len(sent) < 16 and random.random() < p_ready
        ack = bool(sent) and random.random() < p_ack
        dut.port_ready_i.value, dut.port_ack_i.value = ready, ack
        await FallingEdge(dut.clk_i)
        acks = int(dut.ack_o.value)
        assert [not int(dut.idle_o.value) >> w & 1 for w in range(writers)] == [bool(o) for o in open_]
        if ack:
            assert acks == 1 << sent[0]
            open_[sent.popleft()] -= 1
        else:
            assert acks == 0
        taken = int(dut.wr_ready_o.value) & int(dut.wr_valid_i.value)
        assert bool(dut.port_valid_o.value) or not taken
        if dut.port_valid_o.value and ready:
            assert taken.bit_count() == 1
            w = taken.bit_length() - 1
            row = int(dut.port_addr_o.value), int(dut.port_data_o.value), int(dut.port_strb_o.value)
            assert valid[w] and row == todo[w].popleft()
            sent.append(w)
            open_[w] += 1
            waits = [n + 1 if valid[i] and i != w else 0 for i, n in enumerate(waits)]
            assert max(waits) < writers, "one was passed over"
            valid[w] = False
        else:
            assert not taken
        await RisingEdge(dut.clk_i)
    assert not any(open_)


@pytest.mark.parametrize("writers", [2, 3])
def test_rc_mem_share(writers):
    run_cocotb("rc_mem_share", SOURCES, "test_rc_mem_share", parameters={"NumWriters": writers})
