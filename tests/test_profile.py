# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""`raycore render --profile`: slots of every pixel add up to the counters, and without misses they are the reference's."""

import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image as Picture

from raycore import cli, profile, render, sim
from raycore.errors import OptionError, RayCoreError
from raycore.image import View, build_image
from raycore.model.frame import render_fp24
from raycore.scene import load_scene

SIZE = (36, 20)


@pytest.fixture(scope="module")
def image():
    return build_image(load_scene("tiny_glass"), View(*SIZE, max_depth=3))


@pytest.fixture(scope="module")
def reference(image):
    return render_fp24(image)


@pytest.fixture(scope="module", params=[sim.Memory(), sim.Memory(latency=300, backpressure=0.4, seed=5)], ids=["usual", "slow"])
def rendered(image, request):
    """A frame of the RTL with rays of every kind."""
    return render.render(image, "rtl", request.param, hits=True)


def test_pixels_add_up_and_steps_are_the_references(rendered, reference):
    """Slots of every pixel: in all those of the counters, without misses step for step those of the model."""
    found = profile.profile(rendered)
    found.check(reference)
    c = rendered.result.stats["counters"]
    assert found.per_pixel.sum() == sum(c[f"SLOTS_{m}"] for m in ("BOX", "TRAV1", "TRAV2", "ISECT", "MISS_NT", "MISS_LIST"))
    assert found.lost_per_pixel.sum() == c["SLOTS_MISS_NT"] + c["SLOTS_MISS_LIST"] > 0
    # A second step can only be missing, for want of its half of the line: never fewer slots than the model.
    assert (found.per_pixel - found.lost_per_pixel >= reference.work[..., 0]).all()
    hits = rendered.result.hits
    assert (hits["slots"] > hits["lost"]).all() and hits["slots"].max() < rendered.image.view.max_slots

    values = found.values()
    speed = render.stats(rendered)
    assert np.isclose(values["slots_per_ray"], speed["slots_per_ray"]) and np.isclose(values["occupancy"], speed["occupancy"])
    assert np.isclose(sum(values["share"].values()), 1.0)
    assert np.isclose(4 * values["occupancy"] / values["slots_per_ray"], speed["rays_per_cycle_per_rtu"])


@pytest.mark.parametrize("name", ["per_pixel", "lost_per_pixel", "steps_per_pixel"])
def test_what_does_not_add_up_is_seen(rendered, reference, name):
    found = profile.profile(rendered)
    pixels = getattr(found, name).copy()
    pixels[7, 11] += 1
    with pytest.raises(RayCoreError, match=r"11,7" if name == "steps_per_pixel" else "the pixels have"):
        replace(found, **{name: pixels}).check(reference)


def test_the_reference_counts_pixel_by_pixel(reference):
    """The model's slots of pixels are its slots in all."""
    assert reference.work[..., 0].sum() == reference.slots.sum() and reference.work[..., 1].sum() == reference.slots[2]
    assert (reference.work[..., 0] >= np.diff(reference.start).reshape(SIZE[::-1])).all()  # a ray takes one at least


def test_command(tmp_path, capfd, monkeypatch):
    monkeypatch.delenv("RAYCORE_DEBUG", raising=False)
    out, stats = tmp_path / "a.png", tmp_path / "a.json"
    with pytest.raises(SystemExit) as end:
        cli.app(["render", "tiny", "-o", str(out), "--size", "36x20", "--engine", "model", "--profile", "--stats", str(stats)])
    text, err = capfd.readouterr()
    assert not end.value.code, err
    assert "slots per ray" in text and "two traversal steps" in text and "misses" not in text
    values = json.loads(stats.read_text())["profile"]
    assert values["occupancy"] is None and values["pixel"]["max"] >= values["pixel"]["p99"] >= values["pixel"]["median"]
    for name in ("a.slots.png", "a.heat.png"):
        assert Picture.open(tmp_path / name).size[0] > 300


def test_an_engine_without_slots(tmp_path, capfd, image):
    with pytest.raises(SystemExit) as end:
        cli.app(["render", "tiny", "-o", str(tmp_path / "a.png"), "--engine", "double", "--profile"])
    assert end.value.code == 2 and "--profile: only the engines" in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(OptionError, match="have slots"):
        profile.profile(render.Rendered("double", image, np.empty((0, 0)), None, None, sim.Memory()))
