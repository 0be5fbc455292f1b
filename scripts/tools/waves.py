# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Record a test's waveforms and write a GTKWave save file that groups signals by pipeline stage.

    python scripts/tools/waves.py TEST [--instance NAME] [--no-view]     TEST as for pytest: a file, file::name, or -k text
    python scripts/tools/waves.py FILE.fst [--instance NAME]             only the save file, for a recording there is

Groups, for each instance of that name: clock and reset, inputs, outputs, then P1, P2, ... by the stage in a signal's
name (`p3_q`, `p3_valid_q`, `opaque_p3`), then what is left. Without --instance it is the top of the recording.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
import zlib
from dataclasses import dataclass, field
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
CLOCKS = re.compile(r"^(clk|rst)(_n|_i|_ni)?$")
MODULE, STRUCT, UNION, ARRAY = 0, 6, 7, 22      # scope types of FST
PARAMETERS = (2, 4)                             # variable types that never change
STAGE = re.compile(r"(?:^|_)p(\d+)(?=_|$)")


@dataclass
class Scope:
    """An instance, generate block or struct: its variables (name, bits) and what is inside."""
    name: str
    kind: int                                   # FST's scope type
    signals: list[tuple[str, int]] = field(default_factory=list)
    inside: list[Scope] = field(default_factory=list)


def lz4_block(data: bytes, size: int) -> bytes:
    """Decompress one LZ4 block of known size (lz4_Block_format.md). Raises: ValueError if it is broken."""
    out = bytearray()
    pos = 0
    while pos < len(data):
        token = data[pos]
        pos += 1
        length = token >> 4
        if length == 15:
            while True:
                length += data[pos]
                pos += 1
                if data[pos - 1] != 255:
                    break
        out += data[pos:pos + length]
        pos += length
        if pos >= len(data):
            break
        offset = int.from_bytes(data[pos:pos + 2], "little")
        pos += 2
        length = (token & 15) + 4
        if length == 19:
            while True:
                length += data[pos]
                pos += 1
                if data[pos - 1] != 255:
                    break
        if not 0 < offset <= len(out):
            raise ValueError("broken LZ4 block")
        for _ in range(length):
            out.append(out[-offset])
    if len(out) != size:
        raise ValueError("broken LZ4 block")
    return bytes(out)


def _varint(data: bytes, pos: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[pos]
        pos += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, pos


def hierarchy_bytes(path: Path) -> bytes:
    """The hierarchy block of an FST file, decompressed. Raises: ValueError if there is none."""
    data = path.read_bytes()
    pos = 0
    while pos + 9 <= len(data):
        kind, length = data[pos], int.from_bytes(data[pos + 1:pos + 9], "big")
        body = data[pos + 9:pos + 1 + length]
        if kind in (4, 6, 7):
            size, body = int.from_bytes(body[:8], "big"), body[8:]
            if kind == 4:
                return zlib.decompress(body, 31)
            if kind == 7:
                first, start = _varint(body, 0)
                body = lz4_block(body[start:], first)
            return lz4_block(body, size)
        pos += 1 + length
    raise ValueError(f"{path}: not an FST file, or one that was not closed")


def read_hierarchy(path: Path) -> Scope:
    """Tree of the instances in an FST file. Raises: ValueError on a file that is none."""
    data = hierarchy_bytes(path)
    root = Scope("", MODULE)
    stack = [root]
    pos = 0

    def text(start: int) -> tuple[str, int]:
        end = data.index(0, start)
        return data[start:end].decode("latin-1"), end + 1

    while pos < len(data):
        tag = data[pos]
        pos += 1
        if tag == 254:
            kind = data[pos]
            name, pos = text(pos + 1)
            _, pos = text(pos)
            stack.append(Scope(name, kind))
            stack[-2].inside.append(stack[-1])
        elif tag == 255:
            stack.pop()
        elif tag == 252:
            _, pos = text(pos + 2)
            _, pos = _varint(data, pos)
        elif tag == 253:
            pass
        elif tag < 30:
            name, pos = text(pos + 1)
            bits, pos = _varint(data, pos)
            _, pos = _varint(data, pos)
            if tag not in PARAMETERS:
                stack[-1].signals.append((re.sub(r"\s+\[.*", "", name), bits))
        else:
            raise ValueError(f"{path}: unknown tag {tag} in the hierarchy")
    return root


def group_of(name: str) -> tuple[int, int, str]:
    """Sort key and title of the group that a signal belongs to."""
    stage = STAGE.search(name)
    if CLOCKS.match(name):
        return 0, 0, "clock and reset"
    if name.endswith(("_i", "_ni")):
        return 1, 0, "in"
    if name.endswith(("_o", "_no")):
        return 2, 0, "out"
    if stage:
        return 3, int(stage.group(1)), f"P{stage.group(1)}"
    return 4, 0, "other"


def with_paths(scope: Scope, path: str = "") -> list[tuple[str, Scope]]:
    """All instances below `scope` with their full names."""
    out = []
    for inner in scope.inside:
        name = f"{path}.{inner.name}" if path else inner.name
        out += [(name, inner), *with_paths(inner, name)]
    return out


def all_signals(scope: Scope, prefix: str = "") -> list[tuple[str, int]]:
    """Signals of an instance; a field of a packed struct is s.field, an element a.a[0]."""
    out = [(prefix + n, b) for n, b in scope.signals]
    for inner in scope.inside:
        if inner.kind in (STRUCT, UNION, ARRAY):
            out += all_signals(inner, f"{prefix}{inner.name}.")
    return out


def choose(root: Scope, wanted: str | None) -> list[tuple[str, Scope]]:
    """Instances to show: those called `wanted`, else the top. Raises: ValueError if there is none."""
    places = [(p, s) for p, s in with_paths(root) if s.kind == MODULE and not p.startswith("$rootio")]
    if wanted:
        found = [(p, s) for p, s in places if s.name == wanted or p.endswith(f".{wanted}")]
        if not found:
            raise ValueError(f"no instance {wanted}; there are {', '.join(sorted({s.name for _, s in places}))}")
        return found
    clocked = [(p, s) for p, s in places if any(CLOCKS.match(n) for n, _ in s.signals)]
    if not clocked:
        raise ValueError("no instance with a clock in the recording")
    return clocked[:1]


def save_file(fst: Path, wanted: str | None = None) -> str:
    """Text of a GTKWave save file. Raises: ValueError if the instance is not in the recording."""
    out = [f'[dumpfile] "{fst.resolve()}"', "[timestart] 0", "[sst_expanded] 1"]
    for path, scope in choose(read_hierarchy(fst), wanted):
        groups: dict[tuple, list[tuple[str, int]]] = {}
        for name, bits in all_signals(scope):
            groups.setdefault(group_of(name.split(".")[0]), []).append((name, bits))
        out += ["@200", f"-{path}"]
        for key in sorted(groups):
            closed = key[2] == "other"
            out += ["@c00200" if closed else "@800200", f"-{key[2]}"]
            for name, bits in sorted(groups[key], key=lambda item: natural(item[0])):
                out += ["@28" if bits == 1 else "@22", f"{path}.{name}" + (f"[{bits - 1}:0]" if bits > 1 else "")]
            out += ["@1401200" if closed else "@1000200", f"-{key[2]}"]
    return "\n".join(out) + "\n"


def natural(name: str) -> list:
    """Sort key that puts p2 before p10."""
    return [int(s) if s.isdigit() else s for s in re.split(r"(\d+)", name)]


def record(test: str) -> list[Path]:
    """Run a test with WAVES=1. Returns: the recordings it made, newest last."""
    start = time.time() - 1
    args = [test] if (REPO / test.split("::")[0]).exists() else ["-k", test]
    env = {**os.environ, "WAVES": "1"}
    code = subprocess.call([sys.executable, "-m", "pytest", "-p", "no:xdist", *args], cwd=REPO, env=env)
    made = [p for p in (REPO / "build").rglob("*.fst") if p.stat().st_mtime >= start]
    if not made:
        why = "no such test" if code in (4, 5) else "the test records nothing: it does not simulate"
        raise ValueError(f"{test}: {why}")
    return sorted(made, key=lambda p: p.stat().st_mtime)


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("test", help="pytest's name of a test, or an .fst file")
    parser.add_argument("--instance", help="instance to show")
    parser.add_argument("--no-view", action="store_true", help="do not start GTKWave")
    args = parser.parse_args(argv)
    try:
        made = [Path(args.test)] if args.test.endswith(".fst") else record(args.test)
        for fst in made:
            gtkw = fst.with_suffix(".gtkw")
            gtkw.write_text(save_file(fst, args.instance))
            print(f"{fst}\n{gtkw}")
    except (ValueError, OSError) as err:
        print(f"error: {err}", file=sys.stderr)
        return 1
    viewer = shutil.which("gtkwave")
    if args.no_view or not os.environ.get("DISPLAY"):
        print(f"look at it with: gtkwave {gtkw}")
    elif viewer:
        subprocess.Popen([viewer, str(gtkw)], start_new_session=True)
    else:
        print("gtkwave is not installed; the files above are for any viewer that reads FST")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
