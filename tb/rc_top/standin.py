# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""RTL of rc_top with the stand-in rc_rtu.sv, a memory image for it, and what it then paints."""
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raycore.sim import rtl_sources
from raycore.tbutil import rtl

HERE = Path(__file__).resolve().parent


def sources(tbu: bool = False) -> list[Path]:
    """RTL of everything but what is inside the ray-tracing unit. tbu: with the tree builder (parameter Tbu)."""
    if tbu:
        return [HERE / p.name if p.name == "rc_rtu.sv" else p for p in rtl_sources()]
    return [*rtl("mem/rc_mem_pkg.sv", "tbu/rc_tbu_pkg.sv", "accel/rc_accel_pkg.sv", "top/rc_top_pkg.sv", "top/regs/rc_regs_pkg.sv",
                 "prim/rc_ram_1r1w.sv", "prim/rc_skid.sv", "prim/rc_fifo.sv", "prim/rc_rr_arb.sv", "rgen/rc_dispatch.sv",
                 "mem/rc_mem_rd.sv", "mem/rc_mem_wr.sv",
                 "top/regs/rc_regs.sv", "top/rc_csr.sv", "top/rc_counters.sv", "top/rc_loader.sv",
                 "top/rc_setup_check.sv", "top/rc_frame_ctrl.sv"),
            HERE / "rc_rtu.sv", *rtl("top/rc_rtu_port.sv", "top/rc_rtus.sv", "top/rc_core.sv", "top/rc_top.sv", package=False)]


@dataclass
class Scene:
    """Random memory and registers. Lines of nodes are harmless unless `command` changes them."""

    image: bytearray
    regs: dict[str, int]

    def command(self, line: int, what: int, operand: int = 0) -> None:
        """Make the stand-in do something odd when it reads this line of nodes: see rc_rtu.sv."""
        at = self.regs["NODE_BASE"] + 64 * line
        self.image[at + 48:at + 64] = operand.to_bytes(8, "little") + what.to_bytes(8, "little")

    def word(self, register: str, line: int, at: int = 0) -> int:
        at += self.regs[register] + 64 * line
        return int.from_bytes(self.image[at:at + 4], "little")

    def expected(self) -> np.ndarray:
        """The picture: (height, width) uint32. `image` holds memory as it is while the picture is made."""
        width, height = self.regs["SIZE"] & 0xFFFF, self.regs["SIZE"] >> 16
        last = 2 * (self.regs["MAT_COUNT"] - 1)
        table = self.word("MAT_BASE", last) + self.word("MAT_BASE", last + 1)
        if self.regs["LIGHT_COUNT"]:
            table += self.word("LIGHT_BASE", self.regs["LIGHT_COUNT"] - 1)
        out = np.zeros((height, width), np.uint32)
        for y in range(height):
            for x in range(width):
                line = self.regs["NODE_ROOT"] // 8 + x // 8 + y // 8
                node = self.word("NODE_BASE", line % (self.regs["NODE_COUNT"] // 8), 32)
                info = self.word("INFO_BASE", x // 8 % self.regs["TRI_COUNT"])
                uv = self.word("UV_BASE", y // 8 % 2, 8)
                texel = self.word("TEX_BASE", x // 8 % 4, 60)
                out[y, x] = (node + info + table + uv + texel + self.regs["NODE_ROOT"] & 0xFFFFFFFF) ^ (y << 16 | x)
        return out


def scene(seed: int, width: int = 45, height: int = 27, lights: int = 3, materials: int = 5) -> Scene:
    """A scene of the stand-in."""
    image = bytearray(np.random.default_rng(seed).integers(0, 256, 0xE000, dtype=np.uint8).tobytes())
    regs = {
        "SIZE": height << 16 | width, "FB_BASE": 0x10000, "FB_STRIDE": -(-width // 8) * 32 + 32,
        "NODE_BASE": 0x40, "NODE_COUNT": 64, "NODE_ROOT": 63, "LIST_BASE": 0x2000, "LIST_COUNT": 100,
        "ACCEL_BASE": 0x3000, "TRI_COUNT": 5, "INFO_BASE": 0x4000, "MAT_BASE": 0x6000, "MAT_COUNT": materials,
        "INST_BASE": 0x4C00, "INST_COUNT": 3, "UV_BASE": 0x4800, "UV_COUNT": 3, "TEX_BASE": 0x5000, "TEX_LINES": 4,
        "LIGHT_BASE": 0x1000, "LIGHT_COUNT": lights}
    made = Scene(image, regs)
    for line in range(8):
        made.command(line, 0)
    return made
