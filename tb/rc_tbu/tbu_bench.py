# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Trees of whole scenes by the Verilated tree-building unit: compared with the model, cycles and bytes a triangle.

    python tb/rc_tbu/tbu_bench.py [--latency 60] [--refine 8192] SCENE...

A SCENE is a file or the name of one of ours. Memory: 64 bits at core clock, a beat a cycle for reads and writes together.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from tbu_tb import CFG, STAT, pack, tbu_sources

from raycore import tbu as host
from raycore.model import tbu
from raycore.model.tbu_memory import compare, pack_box, walk_memory
from raycore.tbutil import build_verilated, run_verilated

HERE = Path(__file__).resolve().parent
SCENES = HERE.parents[1] / "scenes"
LINE = 64


def build(records, refs, cap=tbu.CAP, refine_max=tbu.REFINE_MAX, latency=60, factor=1):
    """One build. Args: records (N, 4) uint64, vertex records; refs: what the model makes of them.

    Returns: (first difference from the model or None, figures of tbu_stat_t and "read", "written" beats of 8 bytes).
    Raises: AssertionError if it ends with an error.
    """
    exe = build_verilated("rc_tbu_tb", tbu_sources(), [HERE / "tbu_harness.cpp"], parameters={"Cap": cap},
                          build_args=["--x-assign", "fast", "--x-initial", "fast"])  # fmt: skip
    n, size = len(refs), host.sizes(len(refs), cap, factor)
    size = host.Sizes(size.nodes, size.entries, size.refs + 64)
    starts, total = [], 0
    for length in (32 * n, *size.bytes.values()):
        starts.append(total)
        total += -(-length // LINE) * LINE
    vertices, nodes, lists, working = starts
    box = refs.box
    cfg = pack(CFG, vertex_base=vertices // LINE, tri_count=n, node_base=nodes // LINE, node_count=size.nodes,
               list_base=lists // LINE, list_count=size.entries, ref_base=working // LINE, ref_count=size.refs,
               refine_max=refine_max, box=pack_box(box[0], box[1]))  # fmt: skip
    words = ",".join(f"{cfg >> 32 * i & 0xFFFFFFFF:x}" for i in range(-(-sum(w for _, w in CFG) // 32)))
    with tempfile.TemporaryDirectory() as folder:
        memory, out = Path(folder, "memory"), Path(folder, "out")
        image = np.zeros(total, np.uint8)
        image[: 32 * n] = records.astype("<u8").reshape(-1).view(np.uint8)
        image.tofile(memory)
        run_verilated(exe, memory, words, latency, 2000 * n + 100_000, out, name="bench")
        code, root, *stat = (int(w) for w in out.read_text().split())
        image = np.fromfile(memory, np.uint8)
    figures = dict(zip([*reversed(STAT), "read", "written"], stat, strict=True))
    assert code == 0, f"ends with code {code} after {figures['cycles']} cycles"
    found = walk_memory(image[nodes : nodes + 8 * size.nodes].view("<u8"), image[lists : lists + 4 * size.entries].view("<u4"),
                        root, box)  # fmt: skip
    return compare(tbu.build(refs, None, cap, refine_max), found), figures


def main(argv):
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--latency", type=int, default=60)
    parser.add_argument("--refine", type=int, default=tbu.REFINE_MAX)
    parser.add_argument("--cap", type=int, default=tbu.CAP)
    args = parser.parse_args(argv)
    from raycore.scene import load_scene

    for name in args.scenes:
        own = SCENES / f"{name}.py"
        unit = host.snap(load_scene(str(own if own.exists() else name)))
        refs = host.references(unit)
        n, begin = len(refs), time.monotonic()
        difference, f = build(host.vertex_records(unit), refs, args.cap, args.refine, args.latency)
        print(f"{Path(name).stem}: {n} triangles, {f['cycles'] / n:.1f} cycles, {8 * (f['read'] + f['written']) / n:.0f} bytes a "
              f"triangle, bus {(f['read'] + f['written']) / f['cycles']:.0%}; {difference or 'equal to the model'}; "
              f"{f}; {time.monotonic() - begin:.0f} s", flush=True)  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1:])
