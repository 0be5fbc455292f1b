# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Everything `make lint` looks at. Each check prints what it found and one closing line; any finding fails.

    python scripts/tools/lint.py [CHECK...]     all checks, or those named

files      rtl/rc.f and raycore.core name every RTL file once, in order
hygiene    SPDX line, no absolute paths, no tabs or trailing blanks, module named after its file, under 300 lines
generated  generated files are what their generators write
verilator  -Wall on the whole design and on every module by itself, waivers in lint/*.vlt
slang      full elaboration and analysis of the design
verible    style, rules in lint/verible.rules
ruff       Python, rules in pyproject.toml
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import filelist

from raycore.toolchain import REPO, verilator_env

RTL = REPO / "rtl"
BIN = Path(sys.executable).parent
TOP = "rc_top"
TOPS = (TOP,)

# Written by tools; they answer for their own style.
GENERATED = ("rtl/top/regs/", "requirements/render.txt", "requirements/dev.txt", "sim/rc_regs.h")
NO_SPDX = (".txt", ".json", ".png", ".md", ".svg", ".gtkw", ".npz", ".glb", ".obj", ".mtl", ".ply", ".stl")
NAMES_NO_SPDX = ("LICENSE",)
TEXT_ONLY = (".png", ".npz", ".glb", ".ply", ".stl", ".fst")
MAX_LINES = 300
SPDX = "SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1"

# slang: everything on, then what says nothing about hardware or what -Wall of Verilator judges better.
SLANG_ARGS = (
    "-Wextra -Wunused -Wno-unused-parameter -Wno-unused-typedef -Wno-unused-port -Wno-unused-net "
    "-Wno-unused-but-set-net -Wno-unused-but-set-variable -Wno-unused-type-parameter -Wno-unused-argument "
    "-Wno-unused-genvar -Wno-unused-package-parameter -Wno-useless-cast -Wno-shadow-value "
    "-Wno-shadow-hierarchy -Wno-unused-implicit-net -Wno-case-redundant-default -Wno-unused-import -Wno-unused-wildcard-import "
    "-Werror --error-limit=0"
)


def tracked() -> list[str]:
    """Files of the repository, those not yet committed included, ignored ones not."""
    done = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=REPO,
                          capture_output=True, check=True)
    return sorted({n for n in done.stdout.decode().split("\0") if n and (REPO / n).is_file()})


def check_files() -> list[str]:
    return [f"{p} (run `make filelist`)" for p in filelist.problems()]


def hygiene_of(name: str, text: str) -> list[str]:
    """Findings in one text file. Args: name, path in the repository; text, its content."""
    out = []
    path = Path(name)
    head = "\n".join(text.splitlines()[:4])
    needs_spdx = path.suffix not in NO_SPDX and path.name not in NAMES_NO_SPDX
    if needs_spdx and text.strip() and name not in GENERATED and SPDX not in head:
        out.append(f"{name}:1: no SPDX line")
    generated = name.startswith(GENERATED)
    for n, line in enumerate(text.splitlines(), 1):
        if re.search(r"(?<![\w./~-])/(?:home|root|work|Users|mnt|opt)/\w", line):
            out.append(f"{name}:{n}: absolute path")
        if not generated and path.suffix != ".md" and line != line.rstrip():
            out.append(f"{name}:{n}: blank at the end of the line")
        if "\t" in line and path.suffix in (".sv", ".py", ".cpp", ".h", ".rdl", ".md", ".toml"):
            out.append(f"{name}:{n}: tab")
    if text and not text.endswith("\n"):
        out.append(f"{name}: no newline at the end")
    if name.startswith("rtl/") and path.suffix == ".sv" and not generated:
        code = filelist.strip_comments(text)
        units = re.findall(r"^\s*(?:module|package)\s+(?:automatic\s+)?(\w+)", code, re.MULTILINE)
        if units != [path.stem]:
            out.append(f"{name}: holds {', '.join(units) or 'nothing'}, expected {path.stem} alone")
        lines = text.count("\n")
        if "package" not in code.split("module")[0] and lines >= MAX_LINES:
            out.append(f"{name}: {lines} lines, the limit is {MAX_LINES}")
        for word, why in (("initial", "initial block"), ("`ifdef", "`ifdef: file lists choose an implementation"),
                          ("interface", "interface"), ("always_latch", "latch"), ("real", "real"),
                          ("verilator", "pragma: waivers live in lint/*.vlt")):
            where = text if word == "verilator" else code
            pattern = r"/[/*]\s*verilator\b" if word == "verilator" else rf"(?<![\w.$]){re.escape(word)}\b"
            if re.search(pattern, where) and not (word == "initial" and "$readmem" in code):
                out.append(f"{name}: {why}")
    return out


def check_hygiene() -> list[str]:
    out = []
    for name in tracked():
        data = (REPO / name).read_bytes()
        if Path(name).suffix in TEXT_ONLY or b"\0" in data[:1024]:
            if len(data) > 4 << 20:
                out.append(f"{name}: {len(data) >> 20} MiB, too large for the repository")
            continue
        out += hygiene_of(name, data.decode("utf-8", errors="replace"))
    return out


def check_generated() -> list[str]:
    script = REPO / "scripts/tools/gen_regs.py"
    return _tool([sys.executable, script, "--check"], "registers (run `make regs`)")


def _tool(cmd: list, what: str) -> list[str]:
    """Run a tool that exits non-zero when it found something. Returns its lines, or nothing."""
    env = verilator_env()
    env["PYTHONPATH"] = str(REPO / "scripts")
    done = subprocess.run([str(c) for c in cmd], cwd=REPO, env=env, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, check=False)
    lines = [line for line in done.stdout.splitlines() if line.strip()]
    if done.returncode == 0 and not any("%Warning" in line for line in lines):
        return []
    return lines or [f"{what}: exit code {done.returncode}"]


def modules() -> list[str]:
    """Names of the modules in rtl/, generated ones left out."""
    return [Path(f).stem for f in filelist.ordered()
            if not f.endswith("_pkg.sv") and not f"rtl/{f}".startswith(GENERATED)]


def rtl_files(*, generated: bool = True) -> list[str]:
    """Paths of the RTL from the repository's root, in order: what rtl/rc.f should hold (check `files` compares)."""
    names = [f"rtl/{f}" for f in filelist.ordered()]
    return [n for n in names if generated or not n.startswith(GENERATED)]


def check_verilator() -> list[str]:
    waivers = sorted((REPO / "lint").glob("*.vlt"))

    def one(top: str) -> list[str]:
        return _tool(["verilator", "--lint-only", "-Wall", "--assert", "--top-module", top,
                      *waivers, *rtl_files()], top)

    out: list[str] = []
    with ThreadPoolExecutor(max_workers=min(2, os.cpu_count() or 1)) as pool:
        for lines in pool.map(one, modules()):
            out += [line for line in lines if line not in out]
    return [line for line in out if "%Error: Exiting due to" not in line]


def check_slang() -> list[str]:
    top = " ".join(f"--top {t}" for t in TOPS if t in modules())
    code = (f"from pyslang import driver; import sys; d = driver.Driver(); d.addStandardArgs(); "
            f"ok = d.parseCommandLine('slang {' '.join(rtl_files())} {top} {SLANG_ARGS}') and d.processOptions() and "
            f"d.parseAllSources() and d.runFullCompilation(True); sys.exit(not ok)")
    return _tool([sys.executable, "-c", code], "slang")


def check_verible() -> list[str]:
    return _tool([BIN / "verible-verilog-lint", "--rules_config", "lint/verible.rules",
                  "--waiver_files", "lint/verible.waiver", *rtl_files(generated=False)], "verible")


def check_ruff() -> list[str]:
    return _tool([BIN / "ruff", "check", "--no-cache", "--quiet", "--output-format", "concise", "."], "ruff")


CHECKS: dict[str, Callable[[], list[str]]] = {
    "files": check_files, "hygiene": check_hygiene, "generated": check_generated, "verilator": check_verilator,
    "slang": check_slang, "verible": check_verible, "ruff": check_ruff,
}


def main(argv: list[str]) -> int:
    unknown = [a for a in argv if a not in CHECKS]
    if unknown:
        print(f"error: no check {', '.join(unknown)}; there are {', '.join(CHECKS)}", file=sys.stderr)
        return 2
    bad = 0
    for name in argv or CHECKS:
        start = time.monotonic()
        found = CHECKS[name]()
        verdict = f"lint: {name:<10} {'FAILED' if found else 'clean'}  {time.monotonic() - start:5.1f} s"
        print("\n".join([*found, verdict]), flush=True)
        bad += bool(found)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
