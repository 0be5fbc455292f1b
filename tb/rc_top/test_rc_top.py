# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Frames through rc_top in the C++ harness, with a stand-in for the ray-tracing unit: frame control, loader, memory
ports, counters, every way a frame can end, and the harness's own checks."""
import random
from pathlib import Path

import numpy as np
import pytest
from standin import scene, sources

from raycore.errors import OptionError, SimError
from raycore.sim import BUILD_TREE, RECORDS, RENDER, FrameError, Memory, run_frame

ERR_NODE, ERR_SLVERR, ERR_DECERR, ERR_WINDOW, ERR_CONFIG = 1, 6, 7, 8, 10
RTL = sources()


def run(made, **options):
    return run_frame(bytes(made.image), made.regs, sources=RTL, progress=False, **options)


@pytest.mark.parametrize("latency, pauses, rtus", [
    (60, 0.0, 1), (1, 0.0, 1), (400, 0.0, 1), (7, 0.5, 1), (60, 0.9, 1), (60, 0.0, 3), (1, 0.0, 3), (400, 0.3, 3), (7, 0.9, 3)])
def test_frame(seed, latency, pauses, rtus):
    """Every pixel, every hit record and the counters, whatever the memory does and however many units share it."""
    made = scene(seed)
    result = run(made, hits=True, memory=Memory(latency=latency, backpressure=pauses, seed=seed), rtus=rtus)
    np.testing.assert_array_equal(result.frame, made.expected())
    blocks = 6 * 4
    assert len(result.hits) == blocks * 64
    pixels = [(h["x"], h["y"]) for h in result.hits]
    assert len(set(pixels)) == len(pixels) and set(pixels) == {(x, y) for x in range(48) for y in range(32)}
    assert all(h["tri"] == (h["y"] % 8 * 8 + h["x"] % 8) and h["hit"] == 1 and h["t"] == 0x3F0000 for h in result.hits)
    count, size = result.stats["counters"], result.stats["bytes"]
    assert count["RAYS_PRIMARY"] == result.stats["rays"]["primary"][0] == blocks * 64
    assert count["SLOTS_TRAV2"] == 2 * blocks * 64
    assert (count["LINES_TNI"], count["LINES_TRI"], count["LINES_LOADER"]) == (blocks, blocks, 13)
    assert (count["LINES_UV"], count["LINES_TEX"]) == (blocks, blocks)
    assert (size["nodes"], size["info"], size["lights"], size["materials"]) == (blocks * 32, blocks * 64, 192, 640)
    assert (size["uv"], size["textures"]) == (blocks * 64, blocks * 64)
    assert count["FB_ROWS"] == 6 * 27 and size["frame"] == 32 * 6 * 27   # rows below the picture are not sent
    assert count["RAYS_IN_FLIGHT"] == blocks * 64 // 16                     # one cycle each
    assert (count["RD_STALL"] > 0) == (pauses > 0)
    assert 0 <= result.stats["sim"]["cycles"] - count["CYCLES"] < 1000      # the rest is the host at the registers


@pytest.mark.parametrize("width, height", [(1, 1), (8, 8), (17, 1), (3, 40)])
def test_size(seed, width, height):
    made = scene(seed, width, height, lights=0, materials=1)
    np.testing.assert_array_equal(run(made).frame, made.expected())


def test_bus_width(seed):
    mem_width = 256
    made = scene(seed)
    result = run(made, memory=Memory(width=mem_width, backpressure=0.2, seed=seed))
    np.testing.assert_array_equal(result.frame, made.expected())
    assert result.stats["axi"]["read_beats"] == result.stats["counters"]["LINES_LOADER"] * 512 // mem_width \
        + 24 * (256 + 3 * 512) // mem_width


@pytest.mark.parametrize("split", [1, 3, 5])
def test_range_of_tiles(seed, split):
    """Two frames of some tiles each leave together what one frame of all leaves, and each only its own part."""
    made = scene(seed)                                               # 3 x 2 tiles of 16 x 16
    whole = run(made, hits=True)
    parts = []
    for first, count in ((0, split), (split, 0)):
        made.regs |= {"TILE_FIRST": first // 3 << 16 | first % 3, "TILE_COUNT": count}
        parts.append(run(made, hits=True, memory=Memory(backpressure=0.2, seed=seed)))
    y, x = np.mgrid[:27, :45] // 16
    own = 3 * y + x < split
    for part, inside in zip(parts, (own, ~own), strict=True):
        np.testing.assert_array_equal(part.frame, np.where(inside, whole.frame, 0))
        assert part.stats["counters"]["FB_ROWS"] == np.count_nonzero(inside[:, ::8])
    np.testing.assert_array_equal(np.sort(np.concatenate([p.hits for p in parts])), np.sort(whole.hits))


def test_full_tables(seed):
    """As many lights and materials as there may be."""
    made = scene(seed, lights=16, materials=256)
    np.testing.assert_array_equal(run(made).frame, made.expected())


@pytest.mark.parametrize("register, value, blamed", [
    ("SIZE", 27 << 16, 0x20), ("SIZE", 45, 0x20), ("FB_STRIDE", 160, 0x28), ("NODE_COUNT", 0, 0x54),
    ("NODE_ROOT", 64, 0x58), ("MAT_COUNT", 0, 0x74), ("MAT_COUNT", 257, 0x74), ("LIGHT_COUNT", 17, 0x7C),
    ("NODE_BASE", 0xFFFFFE40, 0x50), ("LIST_BASE", 0xFFFFFE80, 0x5C), ("ACCEL_BASE", 0xFFFFFF80, 0x64),
    ("INFO_BASE", 0xFFFFFF00, 0x6C), ("MAT_BASE", 0xFFFFFF00, 0x70), ("LIGHT_BASE", 0xFFFFFF80, 0x78),
    ("UV_BASE", 0xFFFFFFC0, 0xD0), ("TEX_BASE", 0xFFFFFF40, 0xD8), ("INST_BASE", 0xFFFFFFC0, 0x240), ("INST_COUNT", 513, 0x244),
    ("TILE_FIRST", 3, 0x220), ("TILE_FIRST", 2 << 16, 0x220), ("TILE_FIRST", 0xFFF << 16 | 0xFFF, 0x220)])
def test_bad_setup(seed, register, value, blamed):
    """Registers that make no sense: nothing is read or written, the register is named."""
    made = scene(seed)
    made.regs[register] = value
    with pytest.raises(FrameError, match=f"make no sense \\(register 0x{blamed:03x}\\)") as info:
        run(made)
    assert (info.value.code, info.value.addr) == (ERR_CONFIG, blamed)
    assert info.value.stats["axi"] == {"read_bursts": 0, "read_beats": 0, "write_bursts": 0, "write_beats": 0}


@pytest.mark.parametrize("first, inside", [((2, 1), True), ((3, 0), False), ((0, 2), False)])
def test_first_tile(seed, first, inside):
    """The last tile of a picture without a part of a tile may be the first, the next ones to it may not."""
    made = scene(seed, 48, 32)
    made.regs["TILE_FIRST"] = first[1] << 16 | first[0]
    if inside:
        assert run(made).stats["counters"]["FB_ROWS"] == 2 * 16
    else:
        with pytest.raises(FrameError) as info:
            run(made)
        assert (info.value.code, info.value.addr) == (ERR_CONFIG, 0x220)


@pytest.mark.parametrize("control", [BUILD_TREE | RENDER, RECORDS, RECORDS | RENDER])
def test_no_builder(seed, control):
    """The core without a tree builder or record unit refuses to build or to make records, and names CTRL."""
    made = scene(seed)
    made.regs |= {"ATTR_BASE": 0x2000, "VERTEX_BASE": 0x2000}
    with pytest.raises(FrameError) as info:
        run(made, control=control, tbu=False)
    assert (info.value.code, info.value.addr) == (ERR_CONFIG, 0x08)


@pytest.mark.parametrize("register, value", [
    ("NODE_BASE", 0xFFFFFE00), ("LIST_BASE", 0xFFFFFE40), ("ACCEL_BASE", 0xFFFFFF40), ("UV_BASE", 0xFFFFFF80),
    ("TEX_BASE", 0xFFFFFF00)])
def test_region_may_end_with_memory(seed, register, value):
    """A region up to the last byte of 4 GB is one line away from an error."""
    made = scene(seed)
    made.regs[register] = value
    run(made)


@pytest.mark.parametrize("rtus", [1, 3])
def test_error_of_the_unit(seed, rtus):
    """A unit's error ends the frame; what the ports had begun is finished."""
    made = scene(seed)
    made.command(3, 1, 0x123456)
    with pytest.raises(FrameError, match="node index 1193046 outside") as info:
        run(made, memory=Memory(backpressure=0.3, seed=seed), rtus=rtus)
    assert (info.value.code, info.value.addr) == (ERR_NODE, 0x123456)


def test_address_outside(seed):
    """A request outside every window is not sent and ends the frame."""
    made = scene(seed)
    made.command(2, 2)
    with pytest.raises(FrameError) as info:
        run(made)
    assert (info.value.code, info.value.addr) == (ERR_WINDOW, 0xFFFFFFE0)


@pytest.mark.parametrize("kind, code, rtus", [("slverr", ERR_SLVERR, 1), ("decerr", ERR_DECERR, 1), ("decerr", ERR_DECERR, 3)])
def test_memory_error(seed, kind, code, rtus):
    """An error in any burst, of loader, unit or rows, ends the frame."""
    pick = random.Random(seed)
    made = scene(seed)
    memory = Memory(latency=pick.randint(1, 100), backpressure=pick.choice([0.0, 0.4]), seed=seed)
    for burst in [1, 8, 9, *pick.sample(range(10, 57), 2)]:
        with pytest.raises(FrameError) as info:
            run(made, memory=memory, faults=[(f"{kind}-at", burst)], rtus=rtus)
        assert info.value.code == code, burst
    with pytest.raises(FrameError) as info:
        run(made, memory=memory, faults=[(f"{kind}-addr", 0x4040)], rtus=rtus)
    assert (info.value.code, info.value.addr) == (code, 0x4040)
    for burst in [1, 6 * 27]:                                    # the last one answers when all else is done
        with pytest.raises(FrameError) as info:
            run(made, memory=memory, faults=[(f"{kind}-write-at", burst)], rtus=rtus)
        assert info.value.code == code, burst
        assert info.value.addr >= made.regs["FB_BASE"]


def test_ports_stop(seed):
    """After an error the ports take no more: of the eight rows of a block only those already under way are written."""
    with pytest.raises(FrameError) as info:
        run(scene(seed), memory=Memory(latency=1), faults=[("slverr-write-at", 1)])
    assert 1 <= info.value.stats["axi"]["write_bursts"] <= 4


@pytest.mark.parametrize("rtus", [1, 3])
def test_watchdog(seed, rtus):
    """A unit that hangs is reported with what waits for what; with several, when all do."""
    made = scene(seed)
    for line in range(8) if rtus > 1 else (5,):
        made.command(line, 3)
    with pytest.raises(SimError, match=r"nothing happened for 500 cycles.*details in (\S+)\)") as info:
        run(made, watchdog=500, rtus=rtus)
    log = Path(str(info.value).rsplit("details in ", 1)[1].rstrip(")")).read_text()
    assert f"u_core.blk: WAITS, valid {(1 << rtus) - 1} but ready 0" in log
    assert "u_core.u_ctrl.state_q = 4" in log                    # TRACE
    assert all(f"gen_rtu[{r}]" in log or f"gen_rtu__BRA__{r}__KET__" in log for r in range(rtus))
    with pytest.raises(SimError, match=r"not done after 300 cycles"):
        run(made, max_cycles=300)


def test_waves(seed, tmp_path):
    made = scene(seed, 16, 8)
    result = run(made, waves=tmp_path / "w.fst", waves_from=200, waves_cycles=100)
    np.testing.assert_array_equal(result.frame, made.expected())
    assert (tmp_path / "w.fst").stat().st_size > 1000


def test_usage(seed, tmp_path):
    made = scene(seed)
    made.regs["NODE_COUNTS"] = 1
    with pytest.raises(OptionError, match="no register NODE_COUNTS"):
        run(made)
    made = scene(seed)
    with pytest.raises(SimError, match="cannot be written|No such file"):
        run(made, waves=tmp_path / "no" / "w.fst")
    with pytest.raises(OptionError, match="memory width"):
        Memory(width=32)
