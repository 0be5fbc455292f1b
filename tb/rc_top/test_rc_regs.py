# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Registers of rc_top as a host sees them, over AXI4-Lite, with a stand-in for the ray-tracing unit behind them."""
import os
import random

import cocotb
import gen_regs
from cocotb.triggers import ClockCycles
from cocotbext.axi import AxiResp
from host import Host
from standin import scene, sources

from raycore import regs
from raycore.tbutil import run_cocotb

ERR_NODE = 1
SETUP = [name for name, at in regs.OFFSETS.items() if 0x020 <= at < 0x100 or at >= 0x200]


def described() -> dict[str, dict]:
    """What rc_regs.rdl says of each register: mask of bits that software writes and keeps, value after reset."""
    out = {}
    for reg in gen_regs.elaborate(gen_regs.RDL).registers():
        keeps = reset = 0
        for field in reg.fields():
            if gen_regs.access(field) == "RW":
                keeps |= (1 << field.width) - 1 << field.low
            reset |= (field.get_property("reset") or 0) << field.low
        out[reg.inst_name] = {"keeps": keeps, "reset": reset}
    return out


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def every_register(dut):
    """Values after reset; every bit that should hold what is written does, no other changes; byte strobes."""
    host, want = Host(dut), described()
    await host.reset()
    assert await host.read("ID") == 0x52435254
    for name, about in want.items():
        assert await host.read(name) == about["reset"], name
    written = {}
    for name in [*SETUP, "IRQ_ENABLE", "ID", "VERSION", "STATUS", "ERROR", "ERROR_ADDR", *regs.COUNTERS]:
        written[name] = random.getrandbits(32)
        await host.write(name, written[name])
    for name, value in written.items():
        about = want[name]
        assert await host.read(name) == (value & about["keeps"]) | (about["reset"] & ~about["keeps"]), name
    await host.bus.write(regs.OFFSETS["MAX_SLOTS"] + 1, b"\x5a")
    assert await host.read("MAX_SLOTS") == (written["MAX_SLOTS"] & 0xFF) | 0x5A00


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def outside_the_map(dut):
    host = Host(dut)
    await host.reset()
    for offset in (0x17C, 0x1AC, max(regs.OFFSETS.values()) + 4, 0xFFC):
        assert (await host.bus.read(offset, 4)).resp == AxiResp.SLVERR, hex(offset)
        assert (await host.bus.write(offset, b"\xff\xff\xff\xff")).resp == AxiResp.SLVERR, hex(offset)
    assert await host.read("ID") == 0x52435254


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def frames(dut):
    """A good frame, a broken one, a good one: interrupt, status, writes while busy, counters from zero."""
    host, seed = Host(dut), int(os.environ["RAYCORE_SEED"])
    await host.reset()
    made = scene(seed, 21, 13)
    await host.set_up(made)
    await host.write("IRQ_ENABLE", 0b01)
    cycles = []
    for broken in (False, True, False):
        if broken:
            made.command(1, 1, 77)
        else:
            made.command(1, 0)
        host.ram.write(0, bytes(made.image))
        host.ram.write(made.regs["FB_BASE"], bytes(16 * made.regs["FB_STRIDE"]))
        assert not dut.irq_o.value
        await host.write("CTRL", 1)
        assert await host.read("STATUS") == 0b001
        assert await host.read("ERROR") == 0
        await host.write("SIZE", 0xFFFFFFFF)                       # ignored: a frame runs
        await host.write("NODE_BASE", 0x12340)
        await host.write("CTRL", 1)                                # likewise
        assert await host.read("SIZE") == made.regs["SIZE"]
        await host.wait_irq()
        assert await host.read("STATUS") == (0b110 if broken else 0b010)
        assert await host.read("IRQ_STATUS") == (0b11 if broken else 0b01)
        assert (await host.read("ERROR"), await host.read("ERROR_ADDR")) == ((ERR_NODE, 77) if broken else (0, 0))
        assert await host.read("NODE_BASE") == made.regs["NODE_BASE"]
        await host.write("IRQ_STATUS", 0b10)
        assert dut.irq_o.value and await host.read("IRQ_STATUS") == 0b01
        await host.write("IRQ_STATUS", 0b01)
        assert not dut.irq_o.value and await host.read("IRQ_STATUS") == 0
        if not broken:
            host.check_frame(made)
            assert await host.read("RAYS_PRIMARY") == 6 * 64
        cycles.append(await host.read("CYCLES"))
        await ClockCycles(dut.clk_i, 50)
        assert await host.read("CYCLES") == cycles[-1]             # stands still
        assert await host.read("STATUS") & 1 == 0                  # the start while busy left nothing behind
    assert cycles[1] < cycles[0] == cycles[2]
    await host.write("IRQ_ENABLE", 0b10)                           # errors only
    await host.write("CTRL", 1)
    while await host.read("STATUS") & 1:
        pass
    assert await host.read("IRQ_STATUS") == 0b01 and not dut.irq_o.value


def test_rc_regs():
    run_cocotb("rc_top", sources(), "test_rc_regs", parameters={"Tbu": 0}, build_args=["lint/rc_top.vlt"],
               public=["s_axil*", "m_axi*"])


def test_generated():
    """Register block, host table, harness header and documentation are what rc_regs.rdl says."""
    assert gen_regs.stale() == []


def test_pack():
    assert regs.pack("SIZE", width=5, height=7) == 7 << 16 | 5
    assert regs.unpack("SIZE", 7 << 16 | 5) == {"width": 5, "height": 7}
    for bad in (-1, 1 << 16):
        try:
            regs.pack("SIZE", width=bad)
        except ValueError as error:
            assert "does not fit in 16 bits" in str(error)
        else:
            raise AssertionError(bad)
