# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""`raycore render --jobs`: a picture in parts is the picture; what is counted adds up."""

import json

import numpy as np
import pytest
from PIL import Image as Picture

from raycore import cli, parts, render, sim
from raycore.check import compare_rtl
from raycore.image import View, build_image, tile_count, tile_range
from raycore.model.frame import render_fp24
from raycore.scene import load_scene


@pytest.mark.parametrize("tiles", [1, 2, 7, 1500])
@pytest.mark.parametrize("jobs", [1, 2, 3, 8])
def test_every_tile_is_in_one_part(tiles, jobs):
    ranges = parts.split(tiles, jobs)
    assert [t for first, count in ranges for t in range(first, first + count)] == list(range(tiles))
    sizes = [count for _, count in ranges]
    assert len(ranges) == min(tiles, jobs) and max(sizes) - min(sizes) <= 1 and min(sizes) > 0


@pytest.mark.parametrize("jobs", [2, 5, 40])
def test_parts_are_the_whole(jobs):
    """Sizes that no tile divides, more parts than tiles: pixels, hits and counters of the reference; sums of what was counted."""
    image = build_image(load_scene("tiny_glass"), View(50, 37, max_depth=3))
    reference = render_fp24(image)
    rendered = render.render(image, "rtl", sim.Memory(), hits=True, jobs=jobs)
    exact = compare_rtl(rendered.result, reference)
    assert exact.same, exact.examples
    values = render.stats(rendered)
    assert values["parts"] == min(jobs, tile_count(image.view)) and values["rays"]["primary"] == 50 * 37
    assert {k: np.trim_zeros(n, "b") for k, n in values["rays_by_depth"].items()} == {
        k: np.trim_zeros(n, "b").tolist() for k, n in zip(sim.RAY_KINDS, reference.by_depth)
    }
    if jobs == 2:
        alone = [
            sim.run_frame(image.memory, image.registers | tile_range(image, *part)).stats
            for part in parts.split(tile_count(image.view), jobs)
        ]
        assert values["cycles"] == sum(s["counters"]["CYCLES"] for s in alone)
        assert values["bytes"]["nodes"] == sum(s["bytes"]["nodes"] for s in alone)
        assert values["counters"]["L2_MISSES"] == sum(s["counters"]["L2_MISSES"] for s in alone)


def test_command(tmp_path, capfd, monkeypatch):
    monkeypatch.delenv("RAYCORE_DEBUG", raising=False)
    out, stats = tmp_path / "a.png", tmp_path / "a.json"
    with pytest.raises(SystemExit) as end:
        cli.app(["render", "tiny", "-o", str(out), "--size", "36x20", "--jobs", "2", "--stats", str(stats), "--profile"])
    text, err = capfd.readouterr()
    assert not end.value.code, err
    assert "sum of 2 parts, caches cold in each" in text
    assert json.loads(stats.read_text())["parts"] == 2
    frame = render_fp24(build_image(load_scene("tiny"), View(36, 20)))
    assert np.array_equal(np.asarray(Picture.open(out)), np.stack([frame.pixels >> s & 255 for s in (0, 8, 16)], axis=-1))


@pytest.mark.parametrize("more", [("--engine", "model"), ("--waves", "w.fst"), ("--tree", "rtl")])
def test_what_cannot_be_split(tmp_path, capfd, more):
    more = [str(tmp_path / m) if m.endswith(".fst") else m for m in more]
    with pytest.raises(SystemExit) as end:
        cli.app(["render", "tiny", "-o", str(tmp_path / "a.png"), "--jobs", "2", *more])
    assert end.value.code == 2 and "--jobs: only pictures" in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []
