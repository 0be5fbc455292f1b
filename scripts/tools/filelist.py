# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Keep rtl/rc.f and raycore.core complete and in dependency order.

    python scripts/tools/filelist.py check     say what is wrong, exit 1
    python scripts/tools/filelist.py write     write both from the files that are there

rtl/rc.f holds one path a line, relative to rtl/: use it as `-F rtl/rc.f` (Verilator, slang, Yosys read_slang).
Packages come before the files that use them, then folders from the leaves to the top, as in docs/architecture.md.
raycore.core names the same files in the same order.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
RTL = REPO / "rtl"
LIST = RTL / "rc.f"
CORE = REPO / "raycore.core"
FOLDERS = ("", "prim", "fp", "mem", "rgen", "tni", "shade", "tbu", "top")
HEADER = """\
// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Every RTL file of RayCore in dependency order, relative to this file: read it with -F.
// Written by `make filelist`; `make lint` checks it.
"""
CORE_MARK = ("      # rtl/rc.f, by `make filelist`", "      # end of rtl/rc.f")


def strip_comments(text: str) -> str:
    """SystemVerilog without comments and strings."""
    return re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"', " ", text, flags=re.DOTALL)


def ordered() -> list[str]:
    """All files of rtl/, packages before their users.

    Raises: SystemExit if packages depend on each other in a circle.
    """
    files = [p.relative_to(RTL).as_posix() for p in RTL.rglob("*.sv")]
    rank = {name: n for n, name in enumerate(FOLDERS)}

    def key(name: str) -> tuple:
        folder = name.split("/")[0] if "/" in name else ""
        return rank.get(folder, len(FOLDERS)), not name.endswith("_pkg.sv"), name

    files.sort(key=key)
    text = {f: strip_comments((RTL / f).read_text()) for f in files}
    package = {m.group(1): f for f in files for m in re.finditer(r"^\s*package\s+(\w+)", text[f], re.MULTILINE)}
    needs = {f: {package[p] for p in re.findall(r"\b(\w+)::", text[f]) if p in package} - {f} for f in files}
    done: list[str] = []

    def place(name: str, via: tuple[str, ...] = ()) -> None:
        if name in via:
            raise SystemExit(f"error: packages need each other in a circle: {' -> '.join([*via, name])}")
        if name not in done:
            for need in sorted(needs[name], key=key):
                place(need, (*via, name))
            done.append(name)

    for name in files:
        place(name)
    return done


def listed() -> list[str]:
    """Paths in rtl/rc.f, relative to rtl/."""
    return [s for line in LIST.read_text().splitlines() if (s := line.split("//")[0].strip())]


def core_files() -> list[str]:
    """RTL files that raycore.core names, relative to rtl/."""
    return re.findall(r"^\s*-\s+rtl/(\S+\.sv)\s*$", CORE.read_text(), re.MULTILINE)


def core_text(files: list[str]) -> str:
    text = CORE.read_text()
    start, end = (text.index(mark) for mark in CORE_MARK)
    body = "".join(f"      - rtl/{f}\n" for f in files)
    return text[:start] + CORE_MARK[0] + "\n" + body + text[end:]


def problems() -> list[str]:
    """What is wrong with the lists, one line each; empty if nothing."""
    if not LIST.is_file():
        return ["rtl/rc.f does not exist"]
    have, names, out = ordered(), listed(), []
    out += [f"rtl/rc.f lists {n} twice" for n in sorted({n for n in names if names.count(n) > 1})]
    out += [f"rtl/rc.f lacks {n}" for n in have if n not in names]
    out += [f"rtl/rc.f lists {n}, which does not exist" for n in names if n not in have]
    if not out and names != have:
        first = next(a for a, b in zip(names, have) if a != b)
        out.append(f"rtl/rc.f is not in dependency order from {first} on")
    if core_files() != names:
        out.append("raycore.core differs from rtl/rc.f")
    return out


def main(argv: list[str]) -> int:
    if argv == ["check"]:
        found = problems()
        for line in found:
            print(f"{line} (run `make filelist`)")
        return 1 if found else 0
    if argv == ["write"]:
        files = ordered()
        LIST.write_text(HEADER + "".join(f"{f}\n" for f in files))
        CORE.write_text(core_text(files))
        return 0
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
