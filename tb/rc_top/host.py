# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The other end of rc_top's ports: a processor at the registers and a memory."""
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.axi import AxiBus, AxiLiteBus, AxiLiteMaster, AxiRam

from raycore import regs


class Host:
    """A processor and a memory."""

    def __init__(self, dut, size=1 << 17):
        self.dut = dut
        self.bus = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.clk_i, dut.rst_ni, reset_active_level=False)
        self.ram = AxiRam(AxiBus.from_prefix(dut, "m_axi"), dut.clk_i, dut.rst_ni, reset_active_level=False, size=size)

    async def reset(self):
        Clock(self.dut.clk_i, 10, unit="ns").start()
        self.dut.rst_ni.value = 0
        await ClockCycles(self.dut.clk_i, 4)
        self.dut.rst_ni.value = 1
        await ClockCycles(self.dut.clk_i, 4)

    async def read(self, name):
        return await self.bus.read_dword(regs.OFFSETS[name])

    async def write(self, name, value):
        await self.bus.write_dword(regs.OFFSETS[name], value)

    async def set_up(self, made):
        self.ram.write(0, bytes(made.image))
        for name, value in made.regs.items():
            await self.write(name, value)

    async def wait_irq(self):
        while not self.dut.irq_o.value:
            await RisingEdge(self.dut.clk_i)

    def check_frame(self, made):
        want, base, stride = made.expected(), made.regs["FB_BASE"], made.regs["FB_STRIDE"]
        for y, row in enumerate(want):
            assert self.ram.read(base + y * stride, 4 * len(row)) == row.tobytes(), f"row {y}"
