# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Several ray-tracing units: whole frames of the RTL, whatever the memory does, are what one unit and the reference make."""

from collections import Counter

import numpy as np
import pytest

from raycore import check, render, scaling, sim
from raycore.errors import OptionError
from raycore.image import View, build_geometry, build_image, tile_count, tile_range
from raycore.model.frame import render_fp24
from raycore.scene import load_scene

RTUS = 3  # no power of two; one build for all tests here


@pytest.fixture(scope="module")
def picture():
    """Glass and mirrors, a picture that ends within a tile: 3 x 2 tiles, 15 blocks."""
    image = build_image(build_geometry(load_scene("tiny_glass")), View(37, 21, max_depth=4))
    return image, render_fp24(image)


@pytest.mark.parametrize("latency, pauses, width", [(60, 0.0, 64), (5, 0.4, 64)])
def test_same_as_reference(picture, seed, latency, pauses, width):
    image, want = picture
    memory = sim.Memory(width, latency, sim.outstanding(RTUS), pauses, seed)
    rendered = render.render(image, memory=memory, hits=True, rtus=RTUS, progress=False)
    exact = check.compare_rtl(rendered.result, want)
    assert exact.same, exact.examples
    assert exact.rays == want.by_depth.sum() > 2000
    values = render.stats(rendered)
    assert values["config"]["rtus"] == values["config"]["caches"]["rtus"] == RTUS
    assert np.isclose(values["rays_per_cycle_per_rtu"] * RTUS * values["cycles"], values["rays"]["total"])
    slots = sum(values["slots"].values())  # with those without a ray: four a cycle and RTU, but for start and end
    assert 0.5 < slots / (4 * RTUS * values["cycles"]) <= 1.0 and values["occupancy"] < 1.0


def test_ranges_of_tiles(picture, seed):
    """Parts of a picture, each a frame of its own, are the picture."""
    image, want = picture
    tiles, pixels, hits, counters = tile_count(image.view), np.zeros_like(want.pixels), [], Counter()
    for first, count in ((0, 2), (2, 1), (3, tiles - 3)):
        registers = image.registers | tile_range(image, first, count)
        memory = sim.Memory(backpressure=0.2, seed=seed)
        part = sim.run_frame(image.memory, registers, memory=memory, hits=True, rtus=RTUS, progress=False)
        assert not (pixels & part.frame).any()
        pixels |= part.frame
        hits.append(part.hits)
        counters.update(part.stats["counters"])
    exact = check.compare_rtl(sim.SimResult(pixels, np.concatenate(hits), {"counters": counters}), want)
    assert exact.same, exact.examples
    for first, count in ((-1, 1), (0, 0), (tiles, 1), (tiles - 1, 2)):
        with pytest.raises(OptionError, match="not in a picture of 6 tiles"):
            tile_range(image, first, count)


def test_scaling(picture, tmp_path, monkeypatch):
    """The curve from the statistics of frames: speedup is relative to the first number, by cycles."""
    image, want = picture
    rows = scaling.curve(image, [RTUS], reference=want)
    assert (rows[0]["speedup"], rows[0]["efficiency"]) == (RTUS, 1.0)
    assert rows[0]["bound"] == "last blocks" and 0.0 < rows[0]["bus_busy"] < 1.0
    monkeypatch.setattr(scaling, "measure", lambda image, rtus, *_: rows[0] | {"rtus": rtus, "cycles": 1000 // rtus + 10})
    said = []
    made = scaling.curve(image, [2, 5], done=said.append)
    assert [r["rtus"] for r in said] == [2, 5] and made == said
    assert np.isclose(made[1]["speedup"], 2 * 510 / 210) and np.isclose(made[1]["efficiency"], 2 * 510 / 210 / 5)
    assert scaling.table(made).row_count == 2
    assert scaling.plot({"picture": made}).startswith(b"\x89PNG")
    for counts in ([], [1, 1], [0], [17]):
        with pytest.raises(OptionError, match="numbers of RTUs"):
            scaling.curve(image, counts)
    with pytest.raises(OptionError, match="1 to 16"):
        sim.build(rtus=17)
