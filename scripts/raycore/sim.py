# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Runs frames on the Verilated RTL: builds the C++ harness of sim/ when needed, hands it a memory image and
register values, and reads back frame buffer, hit records and counters (docs/simulation.md)."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from raycore import regs as registers
from raycore.errors import OptionError, SimError
from raycore.tbutil import build_verilated
from raycore.toolchain import BUILD, REPO

MEM_WIDTHS = (64, 128, 256)
MAX_RTUS = 16  # as rc_rtus.sv

# One finished ray, as sim/rc_sim.cpp writes it; t, beta and gamma are FP24 bit patterns. kind: see RAY_KINDS. slots: what it
# took in the T&I unit, lost: of these to misses, twos: with two traversal steps.
HIT_DTYPE = np.dtype([
    ("x", "<u2"), ("y", "<u2"), ("kind", "u1"), ("light", "u1"), ("hit", "u1"), ("depth", "u1"),
    ("tri", "<u4"), ("t", "<u4"), ("beta", "<u4"), ("gamma", "<u4"),
    ("slots", "<u2"), ("lost", "<u2"), ("twos", "<u2"), ("inst", "<u2")])

RENDER, BUILD_TREE, RECORDS = 1, 2, 4  # bits of CTRL: render a picture; build the tree, make records before it
RAY_KINDS = ("primary", "shadow", "reflect", "transmit")  # ray_kind_e of rc_pkg.sv

_EXIT_FRAME_ERROR = 2


class FrameError(SimError):
    """The frame ended with STATUS.error. `code` and `addr` are ERROR and ERROR_ADDR, `stats` the counters."""

    def __init__(self, message: str, code: int, addr: int, stats: dict):
        super().__init__(message)
        self.code, self.addr, self.stats = code, addr, stats


@dataclass(frozen=True)
class Memory:
    """External memory of a simulation: the default is that of all published figures."""

    width: int = 64            # bits of the bus
    latency: int = 60          # cycles from address to first data
    outstanding: int = 16      # bursts accepted and not yet answered
    backpressure: float = 0.0  # probability that a channel pauses for a cycle
    seed: int = 1              # of the pauses

    def __post_init__(self):
        if self.width not in MEM_WIDTHS:
            raise OptionError(f"memory width must be one of {', '.join(map(str, MEM_WIDTHS))} bits, is {self.width}")
        if not 1 <= self.latency <= 1_000_000:
            raise OptionError(f"memory latency must be 1 to 1000000 cycles, is {self.latency}")
        if self.outstanding < 1:
            raise OptionError(f"outstanding bursts must be at least 1, is {self.outstanding}")
        if not 0.0 <= self.backpressure < 1.0:
            raise OptionError(f"back-pressure must be at least 0 and below 1, is {self.backpressure}")
        if self.seed < 0:
            raise OptionError(f"seed must not be negative, is {self.seed}")


def outstanding(rtus: int) -> int:
    """Bursts that a memory for so many RTUs accepts: as many as the read port sends (MaxReads of rc_core)."""
    return 16 if rtus == 1 else 32


@dataclass
class SimResult:
    """What a frame left behind."""

    frame: np.ndarray          # (height, width) uint32, pixels as in memory, see FB_FORMAT
    hits: np.ndarray           # (rays,) HIT_DTYPE in the order in which the rays finished; empty if not asked for
    stats: dict = field(default_factory=dict)  # counters, bytes, axi, rays, sim, memory, error: see docs/simulation.md
    memory: np.ndarray | None = None  # uint8 by address as the frame left it, without the frame buffer; if asked for


def rtl_sources(file_list: Path = REPO / "rtl/rc.f") -> list[Path]:
    """RTL files of a file list, in order. Raises: SimError if one does not exist."""
    names = [line.split("//")[0].strip() for line in file_list.read_text().splitlines()]
    paths = [file_list.parent / name for name in names if name]
    for path in paths:
        if not path.is_file():
            raise SimError(f"{file_list.name} names {path.name}, which does not exist")
    return paths


def build(*, mem_width: int = 64, waves: bool = False, tbu: bool = False, cap: int = 1280,
          caches: Mapping[str, int] | None = None, rtus: int = 1, sources: Sequence[Path] | None = None) -> Path:
    """The harness's executable, made if a source has changed (about a minute, seconds from ccache).

    Args: mem_width, bits of the memory bus; waves: with FST tracing, which runs several times slower;
        tbu: with record unit and tree builder, whose sorting pipelines hold `cap` references; caches: parameters of the caches
            by name, others keep their defaults: NtSets, ListSets, L2Sets, L2Ways; rtus: ray-tracing units; sources: RTL to use
            instead of rtl/rc.f.
    Raises: ToolchainError if the build fails, OptionError if there cannot be so many RTUs.
    """
    if not 1 <= rtus <= MAX_RTUS:
        raise OptionError(f"there can be 1 to {MAX_RTUS} RTUs, not {rtus}")
    sim = REPO / "sim"
    rules, rtl = [*sorted((REPO / "lint").glob("*.vlt")), sim / "watch.vlt"], list(sources or rtl_sources())
    args = ["--x-assign", "fast", "--x-initial", "fast"]
    if rtus > 1:  # seen from outside, any output of a library may depend on any input: loops, where there are none
        rules, rtl = [*rules, sim / "rtus.vlt"], _as_library(rtl, caches or {})
        args += ["--hierarchical", "-Wno-UNOPTFLAT"]
    files = [*rules, *rtl, sim / "rc_sim_top.sv"]
    parameters = {"DataW": mem_width} | ({"Tbu": 1, "Cap": cap} if tbu else {}) | dict(caches or {})
    parameters |= {"NumRtus": rtus} if rtus > 1 else {}
    return build_verilated(
        "rc_sim_top", files, [sim / "rc_sim.cpp", sim / "axi_memory.cpp", sim / "options.cpp"], includes=[sim],
        parameters=parameters, build_args=args, trace=waves)


def _as_library(rtl: Sequence[Path], caches: Mapping[str, int]) -> list[Path]:
    """RTL in which an RTU has no parameters, so that Verilator makes it once, as a library (sim/rtus.vlt).

    Without, it would make and compile as many RTUs as there are, which takes minutes each. A library with parameters is no
    way out: Verilator 5.048 compiles it and then does not use it (its issue 7009).
    """
    out = []
    for path in rtl:
        text = path.read_text()
        if path.name == "rc_rtus.sv":
            text, n = re.subn(r"rc_rtu #\([^;]*?\)\) u_rtu \(", "rc_rtu u_rtu (", text)
        elif path.name == "rc_rtu.sv":
            text, n = re.subn(r"import ([\w:*, ]+); #\(\n(.*?)\n\) \(\n(.*?)\n\);\n", _parameters_inside, text, count=1, flags=re.S)
            n = n or "#(" not in text.split(");")[0]  # none to begin with
            for name, value in caches.items():
                text = re.sub(rf"(localparam int unsigned {name}\s*=) \d+", rf"\1 {value}", text)
        else:
            out.append(path)
            continue
        if not n:
            raise SimError(f"{path.name}: cannot make a module without parameters of it; _as_library of sim.py knows how it looked")
        name = hashlib.sha256(text.encode()).hexdigest()[:10]
        made = BUILD / "rtu" / name / path.name
        made.parent.mkdir(parents=True, exist_ok=True)
        if not made.exists():
            part = made.with_suffix(f".{os.getpid()}")
            part.write_text(text)
            part.replace(made)
        out.append(made)
    return out


def _parameters_inside(match: re.Match) -> str:
    constants = match[2].replace("parameter ", "localparam ").replace(",", ";")
    constants = re.sub(r"^([^/\n]*\d)(\s*//|\s*$)", r"\1;\2", constants, flags=re.M)
    return f"import {match[1]}; (\n{match[3]}\n);\n{constants}\n"


def run_frame(image: Path | bytes | np.ndarray, regs: Mapping[str, int], *, memory: Memory = Memory(), hits: bool = False,
              waves: Path | None = None, waves_from: int = 0, waves_cycles: int | None = None,
              faults: Iterable[tuple[str, int]] = (), max_cycles: int | None = None, watchdog: int | None = None,
              progress: bool | None = None, sources: Sequence[Path] | None = None, control: int = RENDER,
              tbu: bool | None = None, cap: int = 1280, caches: Mapping[str, int] | None = None,
              rtus: int = 1, keep_memory: bool = False) -> SimResult:
    """Run one frame.

    Args:
        image: memory from address 0, a file or its bytes; regs: value of each set-up register by name (raycore.regs).
        hits: record every finished ray; waves: FST file to write, from cycle waves_from for waves_cycles.
        faults: errors of the memory, such as ("slverr-at", 3): see docs/simulation.md.
        max_cycles, watchdog: give up after so many cycles, or so many in which nothing happens.
        progress: show a progress line (default: if stderr is a terminal); sources: as in build.
        control: sum of RENDER, BUILD_TREE, RECORDS; tbu, cap, caches, rtus: as in build (default: with the builders if one is
            to work).
        keep_memory: return the memory as the frame left it.
    Raises: FrameError if the frame ends with STATUS.error; OptionError for registers that do not exist or paths that
        cannot be written; SimError if the RTL hangs, breaks a rule of AXI or leaves its regions, or an assertion fails;
        ToolchainError if the harness cannot be built.
    """
    for name, value in regs.items():
        if name not in registers.OFFSETS:
            raise OptionError(f"no register {name}")
        if not 0 <= int(value) < 1 << 32:
            raise OptionError(f"register {name}: {value} does not fit in 32 bits")
    tbu = bool(control & (BUILD_TREE | RECORDS)) if tbu is None else tbu
    exe = build(mem_width=memory.width, waves=waves is not None, tbu=tbu, cap=cap, caches=caches, rtus=rtus, sources=sources)
    show = sys.stderr.isatty() if progress is None else progress
    with tempfile.TemporaryDirectory(prefix="raycore-") as folder:
        work = Path(folder)
        if not isinstance(image, Path):
            (work / "image.bin").write_bytes(bytes(image))
            image = work / "image.bin"
        (work / "regs.txt").write_text("".join(f"{name} {int(value):#x}\n" for name, value in regs.items()))
        options = {
            "image": image, "regs": work / "regs.txt", "fb": work / "fb.bin", "stats": work / "stats.json",
            "mem-latency": memory.latency, "mem-outstanding": memory.outstanding, "backpressure": memory.backpressure,
            "seed": memory.seed, "max-cycles": max_cycles, "watchdog": watchdog,
            "control": control}
        if keep_memory:
            options["memory-after"] = work / "after.bin"
        if hits:
            options["hits"] = work / "hits.bin"
        if waves is not None:
            options |= {"waves": Path(waves).resolve(), "waves-from": waves_from, "waves-cycles": waves_cycles}
        args = [f"--{k} {v}".split(" ", 1) for k, v in [*options.items(), *faults] if v is not None]
        code, log = _run([str(exe), *(a for pair in args for a in pair), *(["--progress"] if show else []), *_coverage()])
        stats = json.loads((work / "stats.json").read_text() or "{}") if (work / "stats.json").is_file() else {}
        if code != 0:
            _fail(code, log, stats)
        frame = _frame(work / "fb.bin", regs) if control & RENDER else np.empty((0, 0), np.uint32)
        after = np.fromfile(work / "after.bin", np.uint8) if keep_memory else None
        return SimResult(frame, _hits(work / "hits.bin"), stats, after)


def _frame(path: Path, regs: Mapping[str, int]) -> np.ndarray:
    size = registers.unpack("SIZE", int(regs["SIZE"]))
    rows = np.fromfile(path, dtype="<u4")
    pitch = (int(regs["FB_STRIDE"]) & ~31) // 4
    return rows[:pitch * size["height"]].reshape(size["height"], pitch)[:, :size["width"]].copy()


def _hits(path: Path) -> np.ndarray:
    return np.fromfile(path, dtype=HIT_DTYPE) if path.is_file() else np.empty(0, HIT_DTYPE)


def _coverage() -> list[str]:
    """Where a build with coverage leaves its counts; coverage reports collect them from there."""
    if os.environ.get("RAYCORE_COVERAGE", "0") in ("", "0"):
        return []
    folder = BUILD / "coverage"
    folder.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix="rc_sim-", suffix=".dat", dir=folder)
    os.close(handle)
    return [f"+verilator+coverage+file+{name}"]


def _run(cmd: list[str]) -> tuple[int, str]:
    """Run the harness; its progress line goes to stderr as it comes, the rest is returned with the exit code."""
    log = ""
    with subprocess.Popen(cmd, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        try:
            while chunk := os.read(process.stdout.fileno(), 65536):
                text = chunk.decode(errors="replace")
                for line in re.findall(r"\r[^\r\n]*\n?", text):
                    print(line, end="", file=sys.stderr, flush=True)
                log += re.sub(r"\r[^\r\n]*\n?", "", text)
        except BaseException:
            process.kill()
            raise
    return process.returncode, log


def _fail(code: int, log: str, stats: dict) -> None:
    """Raise what the harness said."""
    said = [line.removeprefix("rc_sim: ") for line in log.splitlines() if line.startswith("rc_sim: ")]
    message = said[-1] if said else f"the simulator died (exit code {code})"
    if code == _EXIT_FRAME_ERROR:
        raise FrameError(message, stats["error"]["code"], stats["error"]["addr"], stats)
    if len(log.splitlines()) > 1:    # what every unit waits for, or a failed assertion
        kept = BUILD / "sim-failure.log"
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(log)
        message += f" (details in {os.path.relpath(kept)})"
    raise SimError(message)
