# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Build and run Verilated tests: cocotb for units and protocols, compiled C++ for long runs.

    from raycore.tbutil import rtl, run_cocotb

    def test_rc_fifo(width):
        run_cocotb("rc_fifo", rtl("prim/rc_fifo.sv"), "test_rc_fifo", parameters={"Width": width})

A build lives in build/tb/<top>-<hash of its parameters and options> and is kept: it is made again only when a
source, an option or the toolchain changed, by content, not by date. Several pytest workers may ask for the same
build at once; one makes it and the others wait. Each test runs in a folder of its own.

Environment: WAVES=1 records dump.fst in the folder of the run; RAYCORE_COVERAGE=1 collects line and toggle coverage
in build/coverage; RAYCORE_SEED fixes the seed (see conftest.py).
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import inspect
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from raycore.toolchain import BUILD, REPO, ToolchainError, jobs, run, verilator_env, verilator_root

RTL = REPO / "rtl"
TB_BUILD = BUILD / "tb"
COVERAGE_DIR = BUILD / "coverage"

# Ports follow STYLE: _i, _o, _ni, _no; AXI ports keep the names of the standard behind a prefix.
_PORT_PATTERNS = ("*_i", "*_o", "*_ni", "*_no", "?_axi*", "clk", "rst")
# Plain --coverage crashes Verilator 5.048. Two warnings come of the counters alone: vectors that it does not split look
# like loops, and a function that counts has a side effect.
_COVERAGE_ARGS = ("--coverage-line", "--coverage-toggle", "-Wno-UNOPTFLAT", "-Wno-SIDEEFFECT")


def rtl(*files: str, package: bool = True) -> list[Path]:
    """Paths of files below rtl/, after rc_pkg.sv unless `package` is false.

    Raises: FileNotFoundError naming the first file that does not exist.
    """
    names = [*(["rc_pkg.sv"] if package and "rc_pkg.sv" not in files else []), *files]
    paths = [RTL / name for name in names]
    for path in paths:
        if not path.is_file():
            raise FileNotFoundError(f"no RTL file {path.relative_to(REPO)}")
    return paths


def package_with_latencies(**cycles: int) -> Path:
    """A copy of rc_pkg.sv in which the latencies of functional units differ: `package_with_latencies(DIV=9)`.

    Give each set of latencies a build of its own by a define or parameter.
    Raises: ValueError for a unit that rc_pkg.sv does not know.
    """
    text = (RTL / "rc_pkg.sv").read_text()
    for unit, n in cycles.items():
        text, found = re.subn(rf"(LAT_{unit} +)= \d+;", rf"\g<1>= {n};", text)
        if found != 1:
            raise ValueError(f"LAT_{unit} is not a latency of rc_pkg.sv")
    path = TB_BUILD / f"rc_pkg-{_digest(cycles)[:10]}" / "rc_pkg.sv"
    with _locked(path.parent):
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
    return path


def flag(name: str) -> bool:
    """True if environment variable `name` is set to anything but nothing, 0, false or no."""
    return os.environ.get(name, "").lower() not in ("", "0", "false", "no")


def _digest(*parts: object) -> str:
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()


def _content(files: Iterable[Path]) -> list[tuple[str, str]]:
    return [(str(f), hashlib.sha256(f.read_bytes()).hexdigest()) for f in files]


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _included(folders: Iterable[Path]) -> list[Path]:
    """Headers in these folders: a change of one of them is a change of the build."""
    return sorted({f for d in folders for f in d.iterdir() if f.suffix in (".svh", ".vh", ".h", ".hpp")})


def _verilate(kind: str, top: str, sources: Sequence[Path], args: Sequence[str], parameters: Mapping[str, object],
              defines: Mapping[str, object], includes: Sequence[Path], cpp: Sequence[Path], opt: str,
              extra_files: Mapping[str, str]) -> tuple[Path, Path]:
    """Make the executable if it is not up to date. Returns (folder, executable)."""
    sources = [Path(s).resolve() for s in sources]
    cpp = [Path(s).resolve() for s in cpp]
    includes = [Path(s).resolve() for s in includes]
    key = _digest(kind, args, parameters, defines, opt, [str(s) for s in [*sources, *cpp]], extra_files)
    folder = TB_BUILD / f"{top}-{key[:10]}"
    exe = folder / "obj" / f"V{top}"
    stamp = folder / "stamp"
    with _locked(folder):
        for name, text in extra_files.items():
            path = folder / name
            if not path.exists() or path.read_text() != text:
                path.write_text(text)
        controls = [folder / name for name in extra_files if name.endswith(".vlt")]
        want = _digest(_content([*sources, *cpp, *_included([*includes, *{c.parent for c in cpp}])]), str(verilator_root()),
                       verilator_env(opt)["MAKEFLAGS"])
        if exe.is_file() and stamp.is_file() and stamp.read_text() == want:
            return folder, exe
        stamp.unlink(missing_ok=True)
        cmd = ["verilator", "--cc", "--exe", "--build", "-j", str(jobs()), "--Mdir", folder / "obj", "-o", exe.name,
               "--top-module", top, "--prefix", "Vtop", "--assert", "--timescale", "1ns/1ps", "-Wno-fatal",
               *args, *[f"-D{k}={v}" for k, v in defines.items()], *[f"-I{d}" for d in includes],
               *[f"-G{k}={_literal(v)}" for k, v in parameters.items()], *controls, *sources, *cpp]
        out = run(cmd, what=f"building {top}", log=folder / "build.log", opt=opt)
        if re.search(r"^%Warning", out, re.MULTILINE):
            raise RuntimeError(f"Verilator warns about {top} (all of it in {folder / 'build.log'}):\n" + "\n".join(
                line for line in out.splitlines() if line.startswith("%Warning"))[:4000])
        stamp.write_text(want)
    return folder, exe


def _literal(value: object) -> str:
    if isinstance(value, bool):
        return str(int(value))
    return f'"{value}"' if isinstance(value, str) and not re.match(r"^[\d']", value) else str(value)


def _run_dir(folder: Path, name: str) -> Path:
    """An empty folder for one run: two tests that share a build must not share results or waveforms."""
    path = folder / "runs" / re.sub(r"[^\w.=-]+", "_", name).strip("_")[:120]
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir(parents=True)
    return path


def _test_name(default: str) -> str:
    current = os.environ.get("PYTEST_CURRENT_TEST", "")
    return current.rsplit("::", 1)[-1].rsplit(" (", 1)[0] if current else default


def _coverage_file(run_dir: Path) -> Path:
    COVERAGE_DIR.mkdir(parents=True, exist_ok=True)
    return COVERAGE_DIR / f"{run_dir.parents[1].name}-{run_dir.name}-{_digest(str(run_dir))[:6]}.dat"


class Lru:
    """What a set-associative cache of lines has: a list a set, the one used longest ago first."""

    def __init__(self, sets: int, ways: int):
        self.sets, self.ways, self.lines = sets, ways, {}

    def hit(self, addr: int) -> bool:
        """Look a line up, and keep it: whether it was there."""
        lines = self.lines.setdefault(addr % self.sets, [])
        hit = addr in lines
        if hit:
            lines.remove(addr)
        lines.append(addr)
        del lines[:-self.ways]
        return hit


def session_seed() -> int:
    """Seed of this test session: RAYCORE_SEED, which conftest.py sets and prints; 1 outside pytest."""
    return int(os.environ.get("RAYCORE_SEED", "1"), 0)


def run_cocotb(top: str, sources: Sequence[str | Path], test_module: str, *,
               parameters: Mapping[str, object] | None = None, defines: Mapping[str, object] | None = None,
               includes: Sequence[str | Path] = (), build_args: Sequence[str] = (), public: Sequence[str] = (),
               testcase: str | Sequence[str] | None = None, seed: int | None = None,
               env: Mapping[str, str] | None = None, plusargs: Sequence[str] = (), opt: str = "-O1") -> Path:
    """Build `top` with Verilator and run the cocotb tests of `test_module` on it.

    Args:
        top: module under test; test_module: Python module with the cocotb tests, beside the caller's file.
        sources: in dependency order, relative paths from the repository's root.
        parameters, defines: given to Verilator; includes: folders.
        build_args: more arguments of Verilator, such as "-Wno-…" or control files.
        public: inner signals that the test reads or writes, "module.signal", wildcards allowed. Only the ports and
            the parameters of `top` are visible otherwise, which simulates half as fast again.
        testcase: run only these; seed: cocotb's seed (default: the session's); env: more variables for the tests.
        opt: compiler optimisation; -O3 pays only for runs of minutes.
    Returns: the folder of the run, with results.xml, run.log and, with WAVES=1, dump.fst.
    Raises: ToolchainError if the build fails, RuntimeError if Verilator warns, AssertionError if a test fails
        or none ran.
    """
    __tracebackhide__ = True
    from cocotb_tools import config
    from cocotb_tools.check_results import get_results
    from cocotb_tools.runner import get_runner

    caller = Path(inspect.stack()[1].filename).parent
    waves, coverage = flag("WAVES"), flag("RAYCORE_COVERAGE")
    control = ["`verilator_config", f"// what cocotb may see of {top}"]
    control += [f'public_flat_rw -module "{top}" -var "{p}"' for p in _PORT_PATTERNS]
    # Not --public-params: a constant of a package that is also a macro of <math.h> (FP_ZERO) would not compile.
    control += [f'public_flat_rd -module "{top}" -param "*"']
    for item in public:
        module, _, signal = item.rpartition(".")
        control.append(f'public_flat_rw -module "{module or top}" -var "{signal}"')
    args = ["--vpi", *build_args]
    args += ["-LDFLAGS", f"-Wl,-rpath,{config.libs_dir} -L{config.libs_dir} -lcocotbvpi_verilator"]
    args += ["--trace-fst", "--trace-structs"] if waves else []
    args += _COVERAGE_ARGS if coverage else []
    cocotb_main = config.share_dir / "lib" / "verilator" / "verilator.cpp"
    folder, exe = _verilate("cocotb", top, [_rooted(s) for s in sources], args, parameters or {}, defines or {},
                            [_rooted(d) for d in includes], [cocotb_main], opt,
                            {"public.vlt": "\n".join(control) + "\n"})

    run_dir = _run_dir(folder, _test_name(test_module))
    runner = get_runner("verilator")
    test_env = {"COCOTB_ANSI_OUTPUT": "0", "RAYCORE_SEED": str(session_seed()), **(env or {})}
    link = exe.parent / top                       # where the runner expects the executable
    if not link.exists():
        with contextlib.suppress(FileExistsError):
            link.symlink_to(exe.name)
    plus = [*plusargs, *([f"+verilator+coverage+file+{_coverage_file(run_dir)}"] if coverage else [])]
    with _environment(test_env, [caller, REPO / "scripts"]):
        try:
            runner.test(test_module=test_module, hdl_toplevel=top, hdl_toplevel_lang="verilog", testcase=testcase,
                        seed=session_seed() if seed is None else seed, build_dir=exe.parent, test_dir=run_dir,
                        results_xml=str(run_dir / "results.xml"), plusargs=plus, waves=waves, extra_env=test_env,
                        log_file=run_dir / "run.log")
            code = 0
        except (SystemExit, RuntimeError) as stop:   # the runner's ways to say that something failed
            code = stop.code if isinstance(stop, SystemExit) else 1
        except ValueError as err:
            if "libpython" not in str(err):
                raise
            raise ToolchainError("cocotb needs Python as a shared library: install libpython3-dev") from err
    log = run_dir / "run.log"
    if not (run_dir / "results.xml").is_file():
        raise AssertionError(f"{top}: the simulation died (exit {code}):\n{_tail(log)}")
    tests, failed = get_results(run_dir / "results.xml")
    if failed or code:
        raise AssertionError(f"{top}: {failed} of {tests} cocotb tests failed (exit {code}, "
                             f"all of it in {log}):\n{_tail(log)}")
    if tests == 0:
        raise AssertionError(f"{top}: {test_module} ran no cocotb test")
    return run_dir


def build_verilated(top: str, sources: Sequence[str | Path], cpp: Sequence[str | Path], *,
                    parameters: Mapping[str, object] | None = None, defines: Mapping[str, object] | None = None,
                    includes: Sequence[str | Path] = (), build_args: Sequence[str] = (), cflags: str = "",
                    opt: str = "-O3", trace: bool | None = None) -> Path:
    """Build `top` with a C++ main of our own; the model's class is Vtop (#include "Vtop.h").

    Args: as run_cocotb; cpp: C++ sources; includes: folders for `include and #include; cflags: for the compiler;
        trace: FST tracing (default: WAVES).
    Returns: the executable. A main that wants coverage calls `contextp->coveragep()->write(path)` when VM_COVERAGE
        is set; `run_verilated` gives the path as +verilator+coverage+file+.
    Raises: ToolchainError, RuntimeError as run_cocotb.
    """
    args = list(build_args)
    dirs = [_rooted(d) for d in includes]
    flags = " ".join([cflags, *[f"-I{d}" for d in dirs]]).strip()
    args += ["-CFLAGS", flags] if flags else []
    args += ["--trace-fst", "--trace-structs"] if (flag("WAVES") if trace is None else trace) else []
    args += _COVERAGE_ARGS if flag("RAYCORE_COVERAGE") else []
    return _verilate("cpp", top, [_rooted(s) for s in sources], args, parameters or {}, defines or {}, dirs,
                     [_rooted(c) for c in cpp], opt, {})[1]


def run_verilated(exe: Path, *args: str | int | Path, name: str | None = None, timeout: float | None = None) -> str:
    """Run an executable of build_verilated in a folder of its own.

    Returns: its output. Raises: AssertionError with the end of its output if it exits other than 0.
    """
    __tracebackhide__ = True
    run_dir = _run_dir(exe.parents[1], _test_name(name or exe.name))
    plus = [f"+verilator+coverage+file+{_coverage_file(run_dir)}"] if flag("RAYCORE_COVERAGE") else []
    done = subprocess.run([str(exe), *map(str, args), *plus], cwd=run_dir, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=timeout, check=False)
    (run_dir / "run.log").write_text(done.stdout)
    call = " ".join([exe.name, *map(str, args)])
    assert done.returncode == 0, f"{call} exits {done.returncode}:\n{_tail(run_dir / 'run.log')}"
    return done.stdout


def _rooted(path: str | Path) -> Path:
    return path if (path := Path(path)).is_absolute() else REPO / path


def _tail(log: Path, lines: int = 60) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-lines:]) if log.is_file() else "(no output)"


@contextlib.contextmanager
def _environment(env: Mapping[str, str], path: Sequence[Path]) -> Iterator[None]:
    """What the runner takes from this process: os.environ, which it copies over its own extra_env, and sys.path, which
    becomes PYTHONPATH. PYTEST_CURRENT_TEST would make it exit from inside; it is hidden. All of it comes back."""
    env_before, path_before = dict(os.environ), list(sys.path)
    os.environ.update(env)
    os.environ.pop("PYTEST_CURRENT_TEST", None)
    sys.path[:0] = [str(p) for p in path]
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(env_before)
        sys.path[:] = path_before
