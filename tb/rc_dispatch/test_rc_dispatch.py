# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_dispatch against raycore.model.pixbuf.block_order: every block once, in order, fairly shared."""

import os
import random

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import pixbuf
from raycore.tbutil import rtl, run_cocotb

SIZES = [(1, 1), (7, 5), (8, 8), (9, 8), (8, 9), (16, 16), (17, 16), (16, 17), (33, 31), (100, 37), (24, 24), (320, 192)]


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = dut.start_i.value = dut.blk_ready_i.value = 0
    dut.width_i.value = dut.height_i.value = 0
    dut.tile_x_i.value = dut.tile_y_i.value = dut.tile_count_i.value = 0
    for _ in range(3):
        await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


def blocks_of(width, height, first=0, count=0):
    """Blocks of a range of tiles: those of the picture whose tile's number, from the top left one on, is in the range."""
    columns = -(-width // 16)
    last = first + count if count else 1 << 24
    order = [tuple(b) for b in pixbuf.block_order(width, height).tolist()]
    return [(x, y) for x, y in order if first <= y // 2 * columns + x // 2 < last]


async def frame(dut, width, height, ready, first=0, count=0):
    """One frame, or `count` of its tiles from number `first` on. `ready()` gives the mask of RTUs that ask in a cycle.

    Returns: a list of (cycle, rtu, (x, y)) as blocks were taken, and the cycles it took.
    """
    rtus = int(os.environ["RTUS"])
    dut.width_i.value, dut.height_i.value = width, height
    dut.tile_y_i.value, dut.tile_x_i.value = divmod(first, max(-(-width // 16), 1))
    dut.tile_count_i.value = count
    dut.start_i.value, dut.blk_ready_i.value = 1, 0
    await RisingEdge(dut.clk_i)
    dut.start_i.value = 0
    taken, total = [], len(blocks_of(width, height, first, count))
    for cycle in range(40 * total + 2000):
        mask = ready()
        dut.blk_ready_i.value = mask
        await RisingEdge(dut.clk_i)
        valid, words = int(dut.blk_valid_o.value), int(dut.blk_o.value)
        done = bool(dut.all_sent_o.value)
        assert len(taken) == total or not done, f"all_sent_o after {len(taken)} of {total} blocks"
        # Up to three blocks outside the picture may follow the last one inside.
        assert done or len(taken) < total or cycle <= taken[-1][0] + 5, "all_sent_o is late"
        if done:
            dut.blk_ready_i.value = 0
            return taken, cycle
        for i in range(rtus):
            if (valid & mask) >> i & 1:
                blk = words >> 26 * i
                taken.append((cycle, i, (blk >> 13 & 0x1FFF, blk & 0x1FFF)))
    raise AssertionError(f"hangs after {len(taken)} of {total} blocks")


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def every_block_once(dut):
    """All sizes, one frame after the other, requests at random."""
    rtus, rng = int(os.environ["RTUS"]), random.Random(cocotb.RANDOM_SEED)
    await start(dut)
    for width, height in SIZES + [(8 * rng.randrange(1, 40) + rng.randrange(8), rng.randrange(1, 300))]:
        for p in (1.0, 0.3):
            taken, _ = await frame(dut, width, height,
                                   lambda p=p: sum((rng.random() < p) << i for i in range(rtus)))
            order = [tuple(b) for b in pixbuf.block_order(width, height).tolist()]
            rank = {b: i for i, b in enumerate(order)}
            assert sorted(rank[b] for _, _, b in taken) == list(range(len(order)))
            for i in range(rtus):
                mine = [rank[b] for _, rtu, b in taken if rtu == i]
                assert mine == sorted(mine), f"RTU {i} got blocks out of order"
            # A block waits for its RTU in one register at most: the others never get more than that ahead of it.
            if rtus == 1:
                assert [b for _, _, b in taken] == order


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def range_of_tiles(dut):
    """Any first tile and any number of them: those blocks and no others, and in order; 0 or too many: all that follow."""
    rtus, rng = int(os.environ["RTUS"]), random.Random(cocotb.RANDOM_SEED)
    await start(dut)
    for width, height in SIZES + [(8 * rng.randrange(1, 30) + rng.randrange(8), rng.randrange(1, 200))]:
        tiles = -(-width // 16) * -(-height // 16)
        for count in {0, 1, tiles, tiles + 1, (1 << 24) - 1, rng.randint(1, tiles), rng.randint(1, tiles)}:
            first = rng.choice([0, tiles - 1, min(max(tiles - count, 0), tiles - 1), rng.randrange(tiles)])
            p, want = rng.choice([1.0, 0.3]), blocks_of(width, height, first, count)
            taken, _ = await frame(dut, width, height, lambda p=p: sum((rng.random() < p) << i for i in range(rtus)),
                                   first, count)
            assert sorted(b for _, _, b in taken) == sorted(want), f"{width}x{height}: {count} tiles from {first} on"
            for i in range(rtus):
                mine = [want.index(b) for _, rtu, b in taken if rtu == i]
                assert mine == sorted(mine), f"RTU {i} got blocks out of order"


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def widest_and_highest(dut):
    """A picture may have 65535 pixels a side."""
    await start(dut)
    for size in ((65535, 1), (1, 65535)):
        taken, cycles = await frame(dut, *size, lambda: (1 << int(os.environ["RTUS"])) - 1)
        assert sorted(b for _, _, b in taken) == sorted(tuple(b) for b in pixbuf.block_order(*size).tolist())
        assert cycles <= 2 * len(taken) + 8, "blocks outside must be skipped at one a cycle"


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def no_pixels(dut):
    """A picture without pixels has no blocks."""
    await start(dut)
    for size in ((0, 0), (0, 5), (5, 0)):
        taken, _ = await frame(dut, *size, lambda: 1)
        assert not taken


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def fair(dut):
    """RTUs that always ask get as many blocks; one that never asks keeps one, and the rest of the frame is not held."""
    rtus = int(os.environ["RTUS"])
    await start(dut)
    taken, cycles = await frame(dut, 256, 128, lambda: (1 << rtus) - 1)
    share = [sum(rtu == i for _, rtu, _ in taken) for i in range(rtus)]
    assert max(share) - min(share) <= 1 and cycles <= len(taken) + 8
    if rtus > 1:
        dut.width_i.value, dut.height_i.value, dut.start_i.value = 256, 128, 1
        await RisingEdge(dut.clk_i)
        dut.start_i.value, dut.blk_ready_i.value, count = 0, (1 << rtus) - 2, 0
        for _ in range(700):
            await RisingEdge(dut.clk_i)
            count += (int(dut.blk_valid_o.value) >> 1).bit_count()
        assert count == 512 - 1 and int(dut.blk_valid_o.value) == 1


@pytest.mark.parametrize("rtus", [1, 4])
def test_rc_dispatch(rtus):
    run_cocotb("rc_dispatch", rtl("prim/rc_rr_arb.sv", "rgen/rc_dispatch.sv"), "test_rc_dispatch",
               parameters={"NumRtus": rtus}, env={"RTUS": str(rtus)})
