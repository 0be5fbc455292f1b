# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Runs builds on the Verilated tree-building unit: makes the harness of sim/ when needed, hands it memory and configuration."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np

from raycore import sim
from raycore.errors import OptionError, SimError
from raycore.model.tbu import CAP
from raycore.tbutil import build_verilated
from raycore.toolchain import REPO

# tbu_cfg_t of rc_tbu_pkg.sv: (field, bits), the first one highest.
CONFIG = (("node_first", 24), ("list_first", 24), ("tri_first", 19), ("vertex_base", 26),
          ("tri_count", 20), ("node_base", 26), ("node_count", 24), ("list_base", 26), ("list_count", 24),
          ("ref_base", 26), ("ref_count", 24), ("refine_max", 20), ("box", 108))  # fmt: skip
# tbu_stat_t, 32 bits each, the first one highest.
COUNTERS = ("cycles", "nodes", "entries", "jumps", "jobs", "donations", "forced", "lines", "rows", "waits")

_EXIT_HANGS = 2
_WORST_CYCLES = 4000  # a triangle: forty times the slowest build known


def config_word(config: dict) -> int:
    """tbu_cfg_t as a number. config: {field: value}, not named: 0. Raises: OptionError if a value does not fit."""
    word = 0
    for name, width in CONFIG:
        value = int(config.get(name, 0))
        if not 0 <= value < 1 << width:
            raise OptionError(f"{name} = {value} does not fit in {width} bits")
        word = word << width | value
    return word


def executable(cap: int = CAP) -> Path:
    """The harness's executable, made if a source has changed (about a minute). Raises: ToolchainError."""
    top = REPO / "sim"
    files = [*sorted((REPO / "lint").glob("*.vlt")), *sim.rtl_sources(), top / "rc_tbu_sim_top.sv"]
    return build_verilated("rc_tbu_sim_top", files, [top / "rc_tbu_sim.cpp"], parameters={"Cap": cap},
                           build_args=["--x-assign", "fast", "--x-initial", "fast"])  # fmt: skip


def run(memory: np.ndarray, config: dict, cap: int = CAP, mem: sim.Memory | None = None) -> tuple[np.ndarray, int, int, dict]:
    """One build.

    Args:
        memory: uint8 by address from 0, stays as it is. config: {field of tbu_cfg_t: value}.
        cap: references of a sorting pipeline. mem: the external memory, of 64 bits.
    Returns: memory after the build; index of the root; tbu_err_e; {field of tbu_stat_t: count}.
    Raises: SimError if it hangs or breaks a rule, OptionError, ToolchainError.
    """
    mem = mem or sim.Memory()
    if mem.width != 64:
        raise OptionError(f"the tree builder is simulated with a bus of 64 bits, not {mem.width}")
    word, exe = config_word(config), executable(cap)
    words = ",".join(f"{word >> at & 0xFFFFFFFF:x}" for at in range(0, sum(w for _, w in CONFIG), 32))
    limit = _WORST_CYCLES * (config["tri_count"] + 50) * max(1, mem.latency // 60)
    with tempfile.TemporaryDirectory(prefix="raycore-tbu-") as folder:
        image, out = Path(folder, "memory"), Path(folder, "out")
        memory.tofile(image)
        args = [exe, image, words, mem.latency, mem.outstanding, mem.backpressure, mem.seed, limit, out]
        done = subprocess.run([str(a) for a in args], cwd=folder, text=True, capture_output=True, check=False)
        if done.returncode == _EXIT_HANGS:
            raise SimError(f"the tree builder hangs: {done.stderr.strip()}")
        if done.returncode or not out.is_file():
            raise SimError(f"the simulated tree builder exits {done.returncode}: {(done.stdout + done.stderr)[-2000:].strip()}")
        code, root, *counters = (int(w) for w in out.read_text().split())
        after = np.fromfile(image, np.uint8)
    return after, root, code, dict(zip(COUNTERS, reversed(counters), strict=True))
