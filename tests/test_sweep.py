# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""`raycore sweep`: which configurations there are and what they take, that results are checked and kept, what is written."""

import csv
import inspect
import json
import re

import numpy as np
import pytest
import synth
from PIL import Image as Picture

from raycore import cli, cli_sweep, sim, sweep
from raycore.check import RAY_COUNTERS, SLOT_COUNTERS, expected_hits
from raycore.errors import OptionError, RayCoreError
from raycore.image import View, build_image
from raycore.model.frame import render_fp24
from raycore.scene import load_scene
from raycore.toolchain import REPO

TINY = ("tiny", "--size", "24x16")


@pytest.fixture
def run(capfd, monkeypatch):
    """Run the command in this process: (exit code, stdout, stderr)."""
    monkeypatch.delenv("RAYCORE_DEBUG", raising=False)

    def call(*arguments):
        with pytest.raises(SystemExit) as end:
            cli.app(["sweep", *(str(a) for a in arguments)])
        out, err = capfd.readouterr()
        return end.value.code or 0, out, err

    return call


@pytest.fixture
def hardware(monkeypatch):
    """Hardware that is always right and the slower the longer the latency; calls are noted."""
    calls = []
    frame = render_fp24(build_image(load_scene("tiny"), View(24, 16)))

    def run_frame(image, regs, *, memory, hits, caches, progress):
        calls.append((memory.width, memory.latency, dict(caches)))
        counters = dict.fromkeys(
            re.findall(r'c\["(\w+)"\]', (REPO / "scripts/raycore/render.py").read_text()), 1000
        )
        counters |= dict(zip(SLOT_COUNTERS, map(int, frame.slots))) | {"CYCLES": 10_000 + 10 * memory.latency}
        counters |= {f"SLOTS_{name}": 7 for name in ("MISS_NT", "MISS_LIST", "BUBBLE")}
        counters |= {counter: frame.rays[kind] for kind, counter in RAY_COUNTERS.items()}
        return sim.SimResult(frame.pixels.copy(), expected_hits(frame), {"counters": counters, "bytes": {"nodes": 640}})

    monkeypatch.setattr(sweep.sim, "run_frame", run_frame)
    return calls


def test_sram_is_that_of_the_elaborated_unit():
    for point in (sweep.Point(), sweep.Point(64, 128, 512, 6), sweep.Point(256, 32, 128, 16)):
        sizes = {name: getattr(point, field) for field, name in sweep.NAMES.items()}
        bits = synth.sram_bits(parameters=sizes)
        other = sum(n for row, n in bits.items() if not row.startswith(("L1", "L2"))) / 8192
        assert abs(other - sweep.OTHER_SRAM_KB) < 0.05, f"OTHER_SRAM_KB should be {other:.2f}"
        assert abs(point.sram_kb - sum(bits.values()) / 8192) < 0.05
        top = synth.sram_bits("rc_top", {"Tbu": 0} | sizes)  # the sizes reach the caches from there
        assert {row: n for row, n in top.items() if row.startswith("L")} == {
            row: n for row, n in bits.items() if row.startswith("L")
        }


def test_defaults_are_those_of_the_rtl():
    """The parameters pass through five modules, and each has defaults of its own; so has the command."""
    options = inspect.signature(cli_sweep.sweep).parameters
    assert {field: options[field].default for field in sweep.DEFAULTS} == {f: str(n) for f, n in sweep.DEFAULTS.items()}
    files = ("rtl/tni/rc_tni.sv", "sim/rc_sim_top.sv", *(f"rtl/top/rc_{top}.sv" for top in ("rtu", "rtus", "core", "top")))
    for file in files:
        text = (REPO / file).read_text()
        for field, name in sweep.NAMES.items():
            found = re.findall(rf"parameter int unsigned {name}\s*=\s*(\d+)", text)
            assert found == [str(sweep.DEFAULTS[field])], f"{file}: {name}"
    assert sweep.Point().caches == {} and sweep.Point(nt_sets=64).caches["NtSets"] == 64


def test_points_and_budget():
    lists = {"nt_sets": [64, 128], "l2_ways": [8, 14, 17], "mem_latency": [20, 400]}
    assert len(sweep.points(lists)) == 12
    kept = sweep.points(lists, 507.1)
    assert kept and all(p.sram_kb <= 507.1 for p in kept)
    assert {(p.nt_sets, p.l2_ways) for p in kept} == {(64, 8), (64, 14), (128, 8), (128, 14)}
    with pytest.raises(OptionError, match="smallest takes"):
        sweep.points(lists, 100.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--nt-sets", "96"), "--nt-sets 96: give a power of two"),
        (("--l2-ways", "1"), "--l2-ways 1"),
        (("--mem-width", "32"), "memory width"),
        (("--mem-latency", "a"), "--mem-latency a: expected whole numbers"),
        (("--budget", "3"), "--budget 3: no configuration"),
        (("--size", "12"), "--size 12"),
    ],
)
def test_wrong_options(run, tmp_path, options, message):
    code, _, err = run(*TINY, "-o", tmp_path / "out", *options)
    assert code == 2 and message in err and len(err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_scheduler_that_is_not_there(run, tmp_path):
    """Without Dask, or without a scheduler: one line either way."""
    code, _, err = run(*TINY, "-o", tmp_path, "--scheduler", "tcp://127.0.0.1:1")
    assert code == 2 and len(err.splitlines()) == 1 and "--scheduler" in err


def test_what_is_written(run, hardware, tmp_path):
    out = tmp_path / "out"
    options = (*TINY, "-o", out, "--nt-sets", "64,128", "--mem-latency", "20,200", "--jobs", "3")
    code, text, err = run(*options)
    assert code == 0, err
    assert "4 configurations; pixels, hits and counters of all are the reference's" in text
    assert sorted(p.name for p in out.iterdir()) == ["latency.png", "sram.png", "sweep.csv", "sweep.json"]
    assert sorted(c[1] for c in hardware) == [20, 20, 200, 200]
    with (out / "sweep.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(r["nt_sets"], r["mem_latency"]) for r in rows] == [("64", "20"), ("64", "200"), ("128", "20"), ("128", "200")]
    rays = sum(render_fp24(build_image(load_scene("tiny"), View(24, 16))).by_depth.reshape(-1))
    assert np.isclose(float(rows[0]["rays_per_cycle"]), rays / 10_200)
    assert float(rows[0]["sram_kb"]) == round(sweep.Point(64).sram_kb, 2)
    for name in ("sram.png", "latency.png"):
        assert Picture.open(out / name).size[0] > 300

    # What is known is not run again, unless it is asked for; another picture is another sweep.
    hardware.clear()
    assert "4 configurations, 4 of them from before" in run(*options)[1] and not hardware
    run(*TINY, "-o", out, "--nt-sets", "64,128", "--mem-latency", "20,400")
    assert sorted(c[1] for c in hardware) == [400, 400]
    assert len(json.loads((out / "sweep.json").read_text())["points"]) == 6
    hardware.clear()
    run(*options, "--fresh")
    assert len(hardware) == 4


def test_a_difference_ends_the_sweep(run, hardware, monkeypatch, tmp_path):
    right = sweep.sim.run_frame

    def wrong(*args, memory, **more):
        result = right(*args, memory=memory, **more)
        if memory.latency == 200:
            result.frame[3, 4] ^= 1
        return result

    monkeypatch.setattr(sweep.sim, "run_frame", wrong)
    code, _, err = run(*TINY, "-o", tmp_path / "out", "--mem-latency", "20,200")
    assert code == 1 and "mem_latency=200" in err and "pixel 4,3" in err and len(err.splitlines()) == 1
    points = json.loads((tmp_path / "out/sweep.json").read_text())["points"]
    assert all(p["mem_latency"] == 20 for p in points.values())


def test_results_of_another_picture_or_rtl_do_not_count(tmp_path, monkeypatch):
    one, other = (build_image(load_scene("tiny"), View(24, height)) for height in (16, 17))
    source = tmp_path / "a.sv"
    source.write_text("1")
    monkeypatch.setattr(sweep.sim, "rtl_sources", lambda: [source])
    first, second = sweep.signature(one), sweep.signature(other)
    source.write_text("2")
    third = sweep.signature(one)
    assert len({first, second, third}) == 3
    (tmp_path / "sweep.json").write_text(json.dumps({"signature": first, "points": {"a": 1}}))
    assert sweep.known(tmp_path / "sweep.json", first) == {"a": 1}
    assert sweep.known(tmp_path / "sweep.json", second) == {} == sweep.known(tmp_path / "none.json", first)


def test_a_file_of_something_else(tmp_path):
    (tmp_path / "sweep.json").write_text("[]")
    with pytest.raises(RayCoreError, match="no result of a sweep"):
        sweep.known(tmp_path / "sweep.json", "x")


def test_a_small_cache_in_the_rtl(run, tmp_path):
    """One configuration that is not the default, through the Verilated RTL: the same picture, more misses."""
    code, text, err = run(*TINY, "-o", tmp_path, "--nt-sets", "2", "--l2-ways", "2", "--l2-sets", "2")
    assert code == 0, err
    row = next(iter(json.loads((tmp_path / "sweep.json").read_text())["points"].values()))
    assert row["exact"] and row["hit_rate_l1_node"] < 0.9 and row["hit_rate_l2"] < 0.5
