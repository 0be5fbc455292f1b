# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_dispatch, rc_setup and rc_pixbuf together: whole frames, pixel by pixel, against raycore.model.pixbuf.

The test takes primary rays, finishes their pixels in random order with random colours, and collects the rows. Every pixel
must be started once, in order, and written once, to its place, with its colour; nothing else may be written.
"""

import random
from dataclasses import dataclass, field

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import fp24, pixbuf
from raycore.tbutil import rtl, run_cocotb

CORNERS = fp24.from_bits([0x000000, 0x800000, 0x010000, 0x3EFFFF, 0x3F0000, 0x3F0001, 0xBF0000, 0x7F0000, 0xFF0000,
                          fp24.NAN_BITS, 0x370000, 0x360000, 0x35FFFF])


@dataclass
class Frame:
    """One frame: what is expected, what came, and the probabilities that make the traffic."""

    dut: object
    rng: random.Random
    width: int
    height: int
    fb_format: int = pixbuf.RGBA8
    p_pri: float = 1.0  # primary rays are taken
    p_done: float = 0.5  # a pixel is finished
    p_wr: float = 1.0  # rows are taken
    hold: int = 0  # pixels in flight before the first is finished
    in_order: bool = False
    started: list = field(default_factory=list)
    in_flight: dict = field(default_factory=dict)
    most_in_flight: int = 0
    cycles: int = 0
    done_at: list = field(default_factory=list)

    def __post_init__(self):
        n = np.random.default_rng(self.rng.randrange(1 << 32))
        rgb = fp24.round_to_fp24(n.uniform(-0.1, 1.1, (self.height, self.width, 3)))
        corner = n.random(rgb.shape) < 0.2
        self.rgb = np.where(corner, n.choice(CORNERS, rgb.shape), rgb)
        self.want = pixbuf.pack(self.rgb, self.fb_format)
        self.got = np.zeros((self.height, self.width), dtype=np.uint32)
        self.written = np.zeros((self.height, self.width), dtype=int)
        self.order = [tuple(p) for p in pixbuf.pixel_order(self.width, self.height).tolist()]
        self.stride32 = -(-self.width // 8) + self.rng.choice([0, 0, 1, 37])
        self.base = self.rng.randrange(1 << 24) * 64

    async def run(self):
        dut, rng = self.dut, self.rng
        dut.width_i.value, dut.height_i.value = self.width, self.height
        dut.fb_base_i.value, dut.fb_stride_i.value = self.base // 64, self.stride32
        dut.fb_rgb10_i.value = self.fb_format == pixbuf.RGB10A2
        dut.start_i.value = 1
        dut.pri_ready_i.value = dut.done_valid_i.value = dut.wr_ready_i.value = 0
        await RisingEdge(dut.clk_i)
        dut.start_i.value = 0
        offered, holding = None, self.hold > 0
        limit = 2000 + int(len(self.order) * 20 / min(self.p_pri, self.p_done, self.p_wr))
        while True:
            holding = holding and len(self.in_flight) < self.hold and self.cycles < 3000
            if offered is None and self.in_flight and not holding and rng.random() < self.p_done:
                offered = next(iter(self.in_flight)) if self.in_order else rng.choice(list(self.in_flight))
                x, y = self.in_flight[offered]
                r, g, b = (int(v) for v in fp24.to_bits(self.rgb[y, x]))
                dut.done_i.value = offered << 72 | b << 48 | g << 24 | r
            pri_ready, wr_ready = rng.random() < self.p_pri, rng.random() < self.p_wr
            dut.done_valid_i.value = offered is not None
            dut.pri_ready_i.value, dut.wr_ready_i.value = pri_ready, wr_ready
            await RisingEdge(dut.clk_i)
            self.cycles += 1
            assert self.cycles < limit, f"hangs: {len(self.started)} started, {self.written.sum()} written"
            if offered is not None and dut.done_ready_o.value:
                del self.in_flight[offered]
                self.done_at.append(self.cycles)
                offered = None
            if pri_ready and dut.pri_valid_o.value:
                self.take_primary(int(dut.pri_o.value))
            if wr_ready and dut.wr_valid_o.value:
                self.take_row(int(dut.wr_addr_o.value), int(dut.wr_data_o.value), int(dut.wr_strb_o.value))
            if dut.all_sent_o.value and dut.idle_o.value:
                break
        assert self.started == self.order, "not every pixel was started when the frame ended"
        assert np.all(self.written == 1), "not every pixel was written when the frame ended"
        assert np.array_equal(self.got, self.want)
        dut.wr_ready_i.value = dut.pri_ready_i.value = 1
        for _ in range(40):
            await RisingEdge(dut.clk_i)
            assert not dut.wr_valid_o.value and not dut.pri_valid_o.value and dut.idle_o.value

    def take_primary(self, word):
        ray_id, pixel = word >> 32, (word >> 16 & 0xFFFF, word & 0xFFFF)
        assert ray_id not in self.in_flight, f"ray index {ray_id} has two owners"
        assert pixel == self.order[len(self.started)], f"pixel {len(self.started)} is {pixel}"
        self.started.append(pixel)
        self.in_flight[ray_id] = pixel
        self.most_in_flight = max(self.most_in_flight, len(self.in_flight))

    def take_row(self, addr, data, strb):
        assert addr % 32 == 0
        y, x32 = divmod((addr - self.base) // 32, self.stride32)
        assert 0 <= y < self.height, f"row {y} is outside the picture"
        assert strb == (1 << min(8, self.width - 8 * x32)) - 1, f"strobes {strb:08b} in columns {8 * x32} and on"
        for i in range(8):
            if strb >> i & 1:
                self.got[y, 8 * x32 + i] = data >> 32 * i & 0xFFFFFFFF
                self.written[y, 8 * x32 + i] += 1


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    for port in ("rst_ni", "start_i", "pri_ready_i", "done_valid_i", "wr_ready_i", "width_i", "height_i"):
        getattr(dut, port).value = 0
    for _ in range(3):
        await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1
    return random.Random(cocotb.RANDOM_SEED)


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(fb_format=[pixbuf.RGBA8, pixbuf.RGB10A2])
async def sizes(dut, fb_format):
    """Pictures of all kinds of sizes, one after the other without a reset, traffic at random."""
    rng = await start(dut)
    for width, height in [(1, 1), (7, 5), (8, 8), (16, 16), (17, 1), (1, 17), (100, 37), (9, 9), (64, 24)]:
        p = {k: rng.choice([1.0, 0.5, 0.2]) for k in ("p_pri", "p_done", "p_wr")}
        await Frame(dut, rng, width, height, fb_format, **p).run()


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(p_pri=[1.0, 0.2], p_done=[1.0, 0.2], p_wr=[1.0, 0.03])
async def back_pressure(dut, p_pri, p_done, p_wr):
    """Each of the three sides slow or fast."""
    rng = await start(dut)
    await Frame(dut, rng, 29, 20, rng.randrange(2), p_pri, p_done, p_wr).run()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def all_indices_in_flight(dut):
    """256 rays are in flight before the first pixel is finished, no more; then all goes on."""
    rng = await start(dut)
    frame = Frame(dut, rng, 40, 40, p_done=1.0, hold=257)
    await frame.run()
    assert frame.most_in_flight == 256


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def all_slots_in_use(dut):
    """Seventeen blocks of one pixel row: the last waits for a slot."""
    rng = await start(dut)
    frame = Frame(dut, rng, 17 * 8, 1, hold=16 * 8 + 1)
    await frame.run()
    assert frame.most_in_flight == 16 * 8


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def rates(dut):
    """Pixels are taken one in three cycles, which is more than the one in four of ray generation."""
    rng = await start(dut)
    frame = Frame(dut, rng, 64, 64, p_done=1.0, hold=200)
    await frame.run()
    gaps = [b - a for a, b in zip(frame.done_at, frame.done_at[1:])]
    assert set(gaps[:3500]) == {3}, f"cycles from pixel to pixel: {sorted(set(gaps))}"


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def in_order(dut):
    """Pixels that finish in the order in which they began."""
    rng = await start(dut)
    await Frame(dut, rng, 33, 17, p_done=1.0, in_order=True).run()


def test_rc_frame():
    prim = [f"prim/rc_{n}.sv" for n in ("delay", "ram_1r1w", "skid", "fifo", "idx_pool", "rr_arb")]
    units = ["fp/rc_fp_pipe.sv", "fp/rc_fp_to_unorm.sv"]
    rgen = [f"rgen/rc_{n}.sv" for n in ("rgen_pkg", "dispatch", "setup", "pixbuf")]
    run_cocotb("rc_frame_tb", [*rtl(*prim, *units, *rgen), "tb/rc_frame/rc_frame_tb.sv"], "test_rc_frame")
