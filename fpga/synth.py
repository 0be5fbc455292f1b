# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Resources of RayCore for Virtex-6 (xc6v) by Yosys, and its functional units beside the paper's Table I.

    python fpga/synth.py [--quick | --report] [--family xc6v|xc7] [TOP ...]

Reads rtl/ with the slang front end, synthesizes each FP unit, one T&I pipeline and the RTU, and fails on latches, loops or
multiple drivers (`check -assert`; no latch cell may remain). Hierarchy is kept and the same logic is
mapped once: in a block the FP units are black boxes, in the RTU the T&I pipelines too, and what they take is added for each.
LUTs, flip-flops, DSP blocks and block RAMs are Yosys' mapping before place and route: an estimate, not a fitter's report.

Writes build/synth/<top>.json and tables. Counts of units and bits of SRAM come from slang's elaboration of the
RTU, not from a list.
"""

import argparse
import json
import multiprocessing
import os
import re
import sys
import time
from collections import Counter
from pathlib import Path

from rich.console import Console
from rich.table import Table

REPO = Path(__file__).resolve().parents[1]
OUT = REPO / "build" / "synth"
FP_UNITS = ["rc_fp_add", "rc_fp_add3", "rc_fp_mul", "rc_fp_cmp", "rc_fp_div", "rc_fp_sqrt", "rc_fp_pow",
            "rc_fp_from_int", "rc_fp_to_unorm"]
PIPE, RTU = "rc_tni_pipe", "rc_rtu"
BLOCKS = [PIPE, RTU]
TBP_BIN, TBP_SORT, TBU, ACCEL = "rc_tbp_bin", "rc_tbp_sort", "rc_tbu", "rc_accel"

# Paper Table I, ray-tracing unit, by unit and in all: 2-input adders, 3-input adders, comparators, multipliers, dividers,
# square roots, exponential units.
PAPER = {
    "Ray generation": (3, 2, 0, 6, 1, 2, 0),
    "Traversal and intersection": (41, 4, 60, 69, 4, 0, 0),
    "Hit point and shading": (17, 6, 9, 35, 6, 2, 2),
}
PAPER_ALL = (61, 12, 71, 110, 11, 4, 2)   # its last line; two comparators are in no row
COUNTED = ["rc_fp_add", "rc_fp_add3", "rc_fp_cmp", "rc_fp_mul", "rc_fp_div", "rc_fp_sqrt", "rc_fp_pow"]
# The tree-building unit: adders, comparators, multipliers, dividers. Table I has five 3-input adders more.
PAPER_TBU = {"1 binning pipeline": (14, 92, 12, 1), "4 sorting pipelines": (132, 0, 84, 0), "all": (146, 92, 96, 1)}
PAPER_TBU_SRAM = 218.62  # KB, Sec. 5.2
OPERATORS = {"adder": ("add", "sub", "alu", "neg"), "comparator": ("lt", "le", "gt", "ge"), "multiplier": ("mul",),
             "divider": ("div", "mod", "divfloor", "modfloor")}  # fmt: skip
WORD = 18  # bits of a coordinate: narrower operators count and address
PARTS = {"u_raygen": "Ray generation", "u_tni": "Traversal and intersection", "u_shade": "Hit point and shading"}
# Paper Sec. 4.1, KB of SRAM in an RTU, and where ours are (first name that fits an instance's path).
PAPER_SRAM = (
    ("L1 node/TriAccel caches", r"u_l1_nt", 124.38),
    ("L1 list caches", r"u_l1_list", 90.38),
    ("L2 cache", r"u_l2", 124.88),
    ("triangle information, coordinates", r"u_info|u_uv_cache", 50.81),
    ("texture cache", r"u_texture\.u_cache", 16.44),
    ("internal buffers", r"", 94.48),
)
PAPER_SRAM_ALL = 507.1   # with 4.23 KB of height cache
UNIT_TITLE = "Functional units of the elaborated RTU, and the paper's (Table I)"
UNIT_COLUMNS = ("unit", "2-input adder", "3-input adder", "comparator", "multiplier", "divider", "square root", "power")
SRAM_TITLE = "SRAM of the elaborated RTU in KB, and the paper's (Sec. 4.1)"
SRAM_COLUMNS = ("memory", "KB", "paper")
VIRTEX6_LX550 = {"LUT": 343_680, "FF": 687_360, "DSP": 864, "BRAM36": 632}  # Xilinx DS150, Virtex-6 family overview


def elaborate(top, visit, parameters=None):
    """Call visit(instance, path) for every instance below `top`, as slang elaborates it; parameters: of `top`, by name."""
    import pyslang

    driver = pyslang.driver.Driver()
    driver.addStandardArgs()
    chosen = " ".join(f"-G {name}={value}" for name, value in (parameters or {}).items())
    driver.parseCommandLine(f"synth -F {REPO}/rtl/rc.f --top {top} -DSYNTHESIS {chosen}")
    if not (driver.processOptions() and driver.parseAllSources()):
        raise SystemExit("synth: slang cannot read rtl/")

    def each(node):
        if node.kind == pyslang.ast.SymbolKind.Instance and node.hierarchicalPath != top:
            visit(node, re.sub(rf"^{top}\.", "", node.hierarchicalPath))
        return True

    driver.createCompilation().getRoot().visit(each)


def unit_counts(top="rc_rtu"):
    """Functional units below each child of `top`: {child instance: Counter of modules}."""
    counts = {}

    def visit(node, path):
        if node.definition.name in (*FP_UNITS, PIPE):
            counts.setdefault(path.split(".")[0], Counter())[node.definition.name] += 1

    elaborate(top, visit)
    return counts


def sram_bits(top=RTU, parameters=None):
    """Bits of RAM in `top` by the rows of PAPER_SRAM, or in all of the tree-building unit as "all": Counter."""
    bits = Counter()

    def visit(node, path):
        if node.definition.name == "rc_ram_1r1w":
            size = {p.name: int(str(p.value).split("d")[-1]) for p in node.body if p.name in ("Width", "Depth")}
            row = "all" if top == TBU else next(name for name, where, _ in PAPER_SRAM if re.search(where, path))
            bits[row] += size["Width"] * size["Depth"]

    elaborate(top, visit, parameters)
    return bits


def operators(top):
    """Integer operators of WORD bits and more in the netlist of `top`, before anything is mapped: {kind: Counter of widths}."""
    stat = OUT / f"{top}.operators.json"
    code = run_yosys(
        OUT / f"{top}.operators.log",
        (f"read_slang --keep-hierarchy -F {REPO}/rtl/rc.f --top {top}", f"hierarchy -top {top}", "proc", "flatten",
         "opt_expr", "opt_merge", "wreduce", "opt_clean", f"tee -o {stat} stat -json -width"),
    )  # fmt: skip
    if code != 0:
        raise SystemExit(f"synth: Yosys cannot read {top}; see {OUT.relative_to(REPO)}/{top}.operators.log")
    counts = {kind: Counter() for kind in OPERATORS}
    for cell, n in json.loads(stat.read_text())["design"]["num_cells_by_type"].items():
        name, _, width = cell.lstrip("$").rpartition("_")
        for kind, names in OPERATORS.items():
            if name in names and int(width) >= WORD:
                counts[kind][int(width)] += n
    return counts


def run_yosys(log, commands):
    """Run commands in a process whose output goes to a file. Returns: its exit status."""
    child = os.fork()
    if child == 0:  # Yosys writes to the process's own output
        with log.open("w") as sink:
            os.dup2(sink.fileno(), 1)
            os.dup2(sink.fileno(), 2)
        code = 1
        try:
            from pyosys import libyosys as ys

            design = ys.Design()
            for command in commands:
                ys.run_pass(command, design)
            code = 0
        finally:
            os._exit(code)
    return os.waitpid(child, 0)[1]


def builder_table(luts):
    """Table: operators of the tree-building unit beside Table I; luts: of an FP adder and a comparator, if they are known."""
    sort, whole, one = operators(TBP_SORT), operators(TBU), operators(TBP_BIN)
    four = {kind: Counter({w: 4 * n for w, n in counts.items()}) for kind, counts in sort.items()}
    rows = {"1 binning pipeline": one, "4 sorting pipelines": four, "all": whole, "record unit, apart": operators(ACCEL)}
    table = Table(title=f"Tree-building unit: operators of {WORD} bits and more / Table I; here integers, there FP24")
    table.add_column("unit")
    for kind in (*OPERATORS, "bits of the adders", "of the comparators"):
        table.add_column(kind, justify="right")
    for name, counts in rows.items():
        bits = [f"{sum(w * n for w, n in counts[kind].items()):,}" for kind in ("adder", "comparator")]
        pairs = (f"{counts[kind].total()} / {paper}" for kind, paper in zip(OPERATORS, PAPER_TBU.get(name, "––––"), strict=True))
        table.add_row(name, *pairs, *bits, style="bold" if name == "all" else None)
    (OUT / "builder.json").write_text(json.dumps(rows, indent=1))
    if luts is not None:
        adder, comparator = luts
        ours = sum(w * n for kind in ("adder", "comparator") for w, n in whole[kind].items())
        paper = PAPER_TBU["all"][0] * adder + PAPER_TBU["all"][1] * comparator
        table.caption = (f"At a LUT a bit the adders and comparators take {ours:,} LUT; "
                         f"Table I's, as our FP units ({adder} and {comparator} LUT), {paper:,}")  # fmt: skip
    return table


def synthesize(job):
    """One top in a process of its own: (top, resources or error, seconds)."""
    top, family, again = job
    began = time.time()
    if not again:
        stat = OUT / f"{top}.json"
        return top, resources(json.loads(stat.read_text())) if stat.is_file() else "not synthesized yet", 0.0
    log = OUT / f"{top}.log"
    holes = [m for m in (*FP_UNITS, PIPE) if m != top] if top in BLOCKS else []
    status = run_yosys(log, (
        f"read_slang --keep-hierarchy -F {REPO}/rtl/rc.f --top {top}",
        *(["blackbox " + " ".join(f"={m}$*" for m in holes)] if holes else []),
        f"synth_xilinx -family {family} -noiopad -noclkbuf -flatten -top {top}",
        "check -assert" if top in FP_UNITS else "check",   # black boxes leave wires without a driver
        "select -assert-none t:LD* t:$dlatch t:$_DLATCH_*",
        f"tee -o {OUT / top}.json stat -json",
    ))
    if status != 0:
        lines = [line for line in log.read_text(errors="replace").splitlines() if "ERROR" in line or "error:" in line]
        return top, (lines or ["Yosys stopped"])[-1], time.time() - began
    return top, resources(json.loads((OUT / f"{top}.json").read_text())), time.time() - began


def unit_rows(counts):
    """Cells of Table I, counted / the paper's, from `unit_counts`: a row for each part and one for all."""
    rows, sums = [], Counter()
    for part, name in PARTS.items():
        own = counts.get(part, Counter())
        sums.update(own)
        rows.append([name, *(f"{own[c]} / {p}" for c, p in zip(COUNTED, PAPER[name], strict=True))])
    return [*rows, ["all", *(f"{sums[c]} / {p}" for c, p in zip(COUNTED, PAPER_ALL, strict=True))]]


def sram_rows(bits):
    """Cells of the SRAM table, KB here and the paper's, from `sram_bits`: a row for each memory and one for all."""
    rows = [[name, f"{bits[name] / 8192:.1f}", f"{paper:.2f}"] for name, _, paper in PAPER_SRAM]
    return [*rows, ["all", f"{sum(bits.values()) / 8192:.1f}", f"{PAPER_SRAM_ALL:.1f}"]]


def resources(stat):
    """LUT, FF, DSP, BRAM36 and distributed RAM LUTs from Yosys' statistics of a design."""
    cells = stat["design"]["num_cells_by_type"]

    def total(pattern, weight=1):
        return sum(n * weight for name, n in cells.items() if re.fullmatch(pattern, name))

    lut_ram = {"RAM32M": 4, "RAM64M": 4, "RAM32X1D": 2, "RAM64X1D": 2, "RAM128X1D": 4, "RAM16X1D": 2}
    return {
        "LUT": total(r"LUT\d|INV") + sum(n * lut_ram.get(name, 0) for name, n in cells.items()),
        "of these RAM": sum(n * lut_ram.get(name, 0) for name, n in cells.items()) + total(r"SRL\w+|SRLC\w+"),
        "FF": total(r"FD\w+"),
        "DSP": total(r"DSP48\w*"),
        "BRAM36": total(r"RAMB36\w*") + total(r"RAMB18\w*", 0.5),
    }


def main(argv):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("top", nargs="*", help="modules (default: every FP unit, one T&I pipeline, RTU, both pipelines of the TBU)")
    parser.add_argument("--family", default="xc6v", choices=["xc6v", "xc7"])
    parser.add_argument("--quick", action="store_true", help="FP units and unit counts only")
    parser.add_argument("--report", action="store_true", help="table of the last run, nothing is synthesized again")
    args = parser.parse_args(argv)
    OUT.mkdir(parents=True, exist_ok=True)
    tops = args.top or (FP_UNITS if args.quick else FP_UNITS + BLOCKS + [TBP_BIN, TBP_SORT])
    console = Console(width=120)

    counts = unit_counts()
    table = Table(title=UNIT_TITLE)
    for name in UNIT_COLUMNS:
        table.add_column(name, justify="left" if name == "unit" else "right")
    for row in unit_rows(counts):
        table.add_row(*row, style="bold" if row[0] == "all" else None)
    console.print(table)
    (OUT / "units.json").write_text(json.dumps({k: dict(v) for k, v in counts.items()}, indent=1))

    table = Table(title=SRAM_TITLE)
    for name in SRAM_COLUMNS:
        table.add_column(name, justify="left" if name == "memory" else "right")
    for row in sram_rows(sram_bits()):
        table.add_row(*row, style="bold" if row[0] == "all" else None)
    console.print(table)

    if not args.quick:
        done_before = [OUT / f"{unit}.json" for unit in ("rc_fp_add", "rc_fp_cmp")]
        luts = [resources(json.loads(f.read_text()))["LUT"] for f in done_before if f.is_file()]
        table = builder_table(luts if len(luts) == 2 else None)
        console.print(table)
        console.print(f"SRAM of the tree-building unit: {sram_bits(TBU)['all'] / 8192:.1f} KB; the paper {PAPER_TBU_SRAM} KB")

    table = Table(title=f"Yosys, {args.family}; share of a Virtex-6 LX550 in brackets")
    table.add_column("module")
    for name in ("LUT", "of these RAM", "FF", "DSP", "BRAM36", "seconds"):
        table.add_column(name, justify="right")
    failed = 0
    with multiprocessing.Pool(min(2, os.cpu_count() or 1)) as pool:
        jobs = sorted(((t, args.family, not args.report) for t in tops), key=lambda j: j[0] in FP_UNITS)   # the long ones first
        done = {}
        for top, result, seconds in pool.imap_unordered(synthesize, jobs):
            console.print(f"[dim]{top}: {seconds:.0f} s[/dim]")
            done[top] = result, seconds
    # What was a black box is added: first to the pipeline, then to the RTU, which has four of them.
    good = {t: r for t, (r, _) in done.items() if not isinstance(r, str)}
    for block in BLOCKS:
        if block not in good:
            continue
        inside = sum(unit_counts(block).values(), Counter())
        if block == RTU:
            for unit, n in sum(unit_counts(PIPE).values(), Counter()).items():
                inside[unit] -= n * inside[PIPE]
        missing = [m for m in inside if inside[m] and m not in good]
        if missing:
            console.print(f"[dim]{block}: without {', '.join(missing)}, not synthesized in this run[/dim]")
        good[block] = {k: v + sum(n * good[m][k] for m, n in inside.items() if m in good) for k, v in good[block].items()}
        done[block] = good[block], done[block][1]
    for top in tops:
        result, seconds = done[top]
        if isinstance(result, str):
            failed += 1
            table.add_row(top, result, *[""] * 4, f"{seconds:.0f}", style="red")
            continue
        cells = [f"{result[k]:,.0f}" if k not in VIRTEX6_LX550 or top in FP_UNITS
                 else f"{result[k]:,.0f} ({result[k] / VIRTEX6_LX550[k]:.0%})" for k in result]  # fmt: skip
        table.add_row(top, *cells, f"{seconds:.0f}")
    console.print(table)
    if failed:
        console.print(f"synth: {failed} of {len(tops)} failed, logs in {OUT.relative_to(REPO)}/")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
