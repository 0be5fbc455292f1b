# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scenes for Mitsuba: what is told about materials and meshes; with Mitsuba installed (`make compare`), small pictures too."""

import numpy as np
import pytest
from PIL import Image

from raycore import mitsuba, scene, shapes
from raycore.scene import Texture, make_material


def test_srgb_round_trip():
    every = np.arange(256, dtype=np.uint8)
    assert np.array_equal(mitsuba.encode(mitsuba._decode(every)), every)


def test_mesh_files(tmp_path):
    """A PLY file holds the same triangles, corner by corner."""
    ball = shapes.sphere((1.0, 2.0, 3.0), 0.5, 8)
    normals = scene.smooth_normals(ball)
    mitsuba._write_ply(tmp_path / "ball.ply", ball, normals, np.zeros((len(ball), 3, 2)))
    back = scene.load_scene(tmp_path / "ball.ply")
    assert np.allclose(back.triangles, ball, atol=1e-6) and np.allclose(back.normals, normals, atol=1e-5)


def test_materials(tmp_path):
    image = np.full((4, 4, 4), 200, np.uint8)
    glass = make_material("g", (0, 0, 0), reflect=(0.04,) * 3, transmit=(0.9,) * 3, ior=1.5, fresnel=True)
    mirror = make_material("m", (0.1, 0.1, 0.1), reflect=(0.8, 0.4, 0.2))
    coat = make_material("c", (0.5, 0.5, 0.5), reflect=(0.04,) * 3, fresnel=True)
    leaf = make_material("l", (0.5,) * 3, texture=Texture(image, "clamp"), alpha_mode="mask")
    plain = make_material("p", (0.5, 0.5, 0.5))
    shiny = make_material("s", (0.5, 0.5, 0.5), (0.3, 0.3, 0.3), 32.0)
    assert mitsuba.whole(glass, tmp_path)["type"] == "dielectric" and mitsuba.polished(plain) is None
    assert mitsuba.polished(glass)["int_ior"] == 1.5
    # Schlick at normal incidence: ((n - 1) / (n + 1))^2 = 0.04
    assert mitsuba.polished(coat)["type"] == "plastic" and mitsuba.polished(coat)["int_ior"] == pytest.approx(1.5)
    metal = mitsuba.whole(mirror, tmp_path)["inside"]
    assert metal["type"] == "blendbsdf"
    assert np.allclose(metal["weight"] * np.array(metal["b"]["specular_reflectance"]["value"]), mirror.reflect)
    cut = mitsuba.whole(leaf, tmp_path)
    assert cut["type"] == "mask" and cut["opacity"]["raw"] and cut["opacity"]["wrap_mode"] == "clamp"
    # A texture is halved as light, not as bytes.
    dull = mitsuba.dull(leaf, tmp_path)[0]["reflectance"]
    assert np.abs(mitsuba._decode(np.asarray(Image.open(dull["filename"]))) - mitsuba._decode(200) / 2).max() < 0.005
    # Phong's highlight is as high as the rough conductor's: D = 1 / (pi alpha^2), times F / 4, times pi.
    lobe = mitsuba.dull(shiny, tmp_path)[1]
    assert lobe["specular_reflectance"]["value"][0] / (4.0 * lobe["alpha"] ** 2) == pytest.approx(0.3)


@pytest.mark.parametrize("integrator", ["whitted", "path"])
def test_small_pictures(tmp_path, integrator):
    """Mitsuba's picture is ours but for what docs/pictures.md names."""
    pytest.importorskip("mitsuba")
    samples, most = (1, 0.05) if integrator == "whitted" else (64, 0.2)
    difference = mitsuba.compare("tiny_glass", tmp_path, (40, 24), samples, integrator, "double")
    assert difference < most
    assert Image.open(tmp_path / "pair.png").size == (84, 24) and (tmp_path / "scene.xml").exists()
