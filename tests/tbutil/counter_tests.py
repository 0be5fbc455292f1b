# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""cocotb side of test_tbutil.py."""
import os

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles


async def count(dut, cycles):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = dut.en_i.value = 0
    await ClockCycles(dut.clk_i, 2)
    dut.rst_ni.value = dut.en_i.value = 1
    await ClockCycles(dut.clk_i, cycles + 1)
    return int(dut.count_o.value)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def counts(dut):
    assert int(dut.Width.value) == int(os.environ["EXPECT_WIDTH"])
    assert await count(dut, 20) == 20 % (1 << int(dut.Width.value))


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def expects_nonsense(dut):
    assert await count(dut, 20) == 21


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def goes_past_the_limit(dut):
    await count(dut, 300)


@cocotb.test()
async def sees_inner(dut):
    assert hasattr(dut, "inner_q") == bool(int(os.environ["EXPECT_INNER"]))
