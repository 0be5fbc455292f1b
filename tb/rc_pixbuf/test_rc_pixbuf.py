# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_pixbuf alone: blocks anywhere in pictures of up to 65535 x 65535, and other latencies of the conversion.

Traffic and whole frames are tested in tb/rc_frame.
"""

import random

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import fp24, pixbuf
from raycore.tbutil import package_with_latencies, rtl, run_cocotb


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    for port in ("rst_ni", "open_valid_i", "map_valid_i", "done_valid_i", "wr_ready_i"):
        getattr(dut, port).value = 0
    for _ in range(3):
        await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1
    return random.Random(cocotb.RANDOM_SEED)


async def block(dut, rng, bx, by, width, height, base, stride32, fb_format):
    """Send one block through and check its rows."""
    dut.width_i.value, dut.height_i.value, dut.fb_rgb10_i.value = width, height, fb_format
    dut.fb_base_i.value, dut.fb_stride_i.value = base // 64, stride32
    cols, rows = min(8, width - 8 * bx), min(8, height - 8 * by)
    dut.open_i.value = cols * rows << 26 | bx << 13 | by
    dut.open_valid_i.value = 1
    await RisingEdge(dut.clk_i)
    assert dut.open_ready_o.value and dut.idle_o.value
    slot = int(dut.open_slot_o.value)
    dut.open_valid_i.value = 0

    # Every pixel gets an index, of which there are more than pixels; the map is complete before the first colour comes.
    pixels = [(x, y) for y in range(rows) for x in range(cols)]
    ids = dict(zip(rng.sample(range(256), len(pixels)), pixels))
    for ray_id, (x, y) in ids.items():
        dut.map_valid_i.value, dut.map_i.value = 1, ray_id << len(dut.map_i) - 8 | slot << 6 | y << 3 | x
        await RisingEdge(dut.clk_i)
    dut.map_valid_i.value = 0

    rgb = fp24.round_to_fp24(np.array([[rng.uniform(-0.1, 1.1) for _ in range(3)] for _ in pixels]))
    want = dict(zip(pixels, (int(p) for p in pixbuf.pack(rgb, fb_format))))
    colour = dict(zip(pixels, fp24.to_bits(rgb).tolist()))
    waiting = rng.sample(list(ids), len(ids))
    dut.wr_ready_i.value = 1
    row = 0
    for _ in range(4 * len(pixels) + 100):
        if waiting:
            r, g, b = colour[ids[waiting[0]]]
            dut.done_i.value = waiting[0] << 72 | b << 48 | g << 24 | r
        dut.done_valid_i.value = bool(waiting)
        await RisingEdge(dut.clk_i)
        assert bool(dut.idle_o.value) == (row == rows)
        taken = bool(waiting) and bool(dut.done_ready_o.value)
        assert bool(dut.free_valid_o.value) == taken
        if taken:
            assert int(dut.free_id_o.value) == waiting.pop(0)
        if dut.wr_valid_o.value:
            assert not waiting, "a row leaves before its block is finished"
            assert int(dut.wr_addr_o.value) == (base + 32 * (stride32 * (8 * by + row) + bx)) % 2**32
            assert int(dut.wr_strb_o.value) == (1 << cols) - 1
            data = int(dut.wr_data_o.value)
            assert [data >> 32 * x & 0xFFFFFFFF for x in range(cols)] == [want[x, row] for x in range(cols)]
            row += 1
    assert row == rows


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def anywhere(dut):
    """Blocks in the corners and in the middle of the largest pictures; any base, any stride."""
    rng = await start(dut)
    places = [(0, 0, 1, 1), (8191, 8191, 65535, 65535), (8191, 0, 65535, 1), (0, 8191, 3, 65529), (5, 4096, 48, 32775)]
    for _ in range(25):
        bx, by = rng.randrange(8191), rng.randrange(8191)
        places.append((bx, by, 8 * bx + rng.randrange(1, 30), 8 * by + rng.randrange(1, 30)))
    for bx, by, width, height in places:
        stride32 = rng.choice([-(-width // 8), rng.randrange(-(-width // 8), 1 << 19)])
        await block(dut, rng, bx, by, width, height, rng.randrange(1 << 26) * 64, stride32, rng.randrange(2))


@pytest.mark.parametrize("cycles", [1, 2, 3])
def test_rc_pixbuf(cycles):
    files = [*(f"prim/rc_{n}.sv" for n in ("delay", "ram_1r1w", "skid", "fifo", "idx_pool")),
             "fp/rc_fp_pipe.sv", "fp/rc_fp_to_unorm.sv", "rgen/rc_rgen_pkg.sv", "rgen/rc_pixbuf.sv"]
    run_cocotb("rc_pixbuf", [package_with_latencies(CONV=cycles), *rtl(*files, package=False)], "test_rc_pixbuf",
               defines={"LATENCY": cycles})
