# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Runs arrays of operands through every FP unit of the RTL (rc_fp_all and harness.cpp)."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from raycore.tbutil import build_verilated, rtl, run_verilated

HERE = Path(__file__).resolve().parent
LEAVES = ("pipe", "norm", "round", "add", "add3", "mul", "div", "cmp", "sqrt", "from_int", "to_unorm", "pow")
PORTS = ("add", "add3", "mul", "div", "cmp", "sqrt", "from_sint", "from_ufix", "unorm8", "unorm10", "pow")
CHUNK = 1 << 22  # operands a run: bounds the memory


def sources(*units: str) -> list[Path]:
    """RTL files of the units, or of all of them."""
    return rtl(*[f"fp/rc_fp_{u}.sv" for u in (units or LEAVES)], package=False)


def run_units(a, b=None, c=None, *, exp_w: int = 7, man_w: int = 16, latency: int = 0) -> dict[str, np.ndarray]:
    """Results of every unit for arrays of bit patterns of one length; missing operands are 0. latency: of all
    units, 0 for their defaults.

    Returns: port of rc_fp_all, without `_o`, to uint32 array.
    """
    exe = build_verilated("rc_fp_all", [*sources(), HERE / "rc_fp_all.sv"], [HERE / "harness.cpp"],
                          parameters={"ExpW": exp_w, "ManW": man_w, "Latency": latency})
    a = np.ascontiguousarray(a, dtype=np.uint32).ravel()
    b, c = (np.zeros_like(a) if x is None else np.ascontiguousarray(x, dtype=np.uint32).ravel() for x in (b, c))
    parts = []
    for lo in range(0, a.size, CHUNK):
        with tempfile.TemporaryDirectory() as tmp:
            operands, results = Path(tmp) / "operands", Path(tmp) / "results"
            np.concatenate([x[lo : lo + CHUNK] for x in (a, b, c)]).tofile(operands)
            run_verilated(exe, operands, results, name=f"fp-{exp_w}-{man_w}-{latency}-{lo}")
            parts.append(np.fromfile(results, dtype=np.uint32).reshape(len(PORTS), -1))
    return dict(zip(PORTS, np.concatenate(parts, axis=1), strict=True))
