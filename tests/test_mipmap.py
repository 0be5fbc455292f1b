# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Mip maps: a fine pattern seen at a grazing angle comes closer to its supersampled picture with them than without.

The supersampled picture is rendered in double precision from level 0 alone and averaged over SUPER x SUPER rays a pixel. It
owes nothing to mip maps, so that it can judge them. Shimmer is what changes when the camera moves by less than a pixel.
"""

from dataclasses import replace

import numpy as np
import pytest

from raycore.check import psnr
from raycore.image import View, build_geometry, build_image, complete_view
from raycore.model.frame import render_double, render_fp24
from raycore.scene import load_scene

SUPER = 8
WIDTH, HEIGHT = 96, 64
LEVEL_0 = -2048 & 0xFFF  # a bias by which every level is 0


@pytest.fixture(scope="module")
def geometry():
    return build_geometry(load_scene("cards"))


def picture(geometry, view, mip_maps, renderer=render_fp24):
    """RGB in [0, 1] of a view, (H, W, 3)."""
    image = build_image(geometry, view)
    if not mip_maps:
        image.registers["MIP_BIAS"] = LEVEL_0
    return np.clip(renderer(image).rgb, 0.0, 1.0)


def supersampled(geometry, view):
    fine = picture(geometry, replace(view, width=WIDTH * SUPER, height=HEIGHT * SUPER), False, render_double)
    return fine.reshape(HEIGHT, SUPER, WIDTH, SUPER, 3).mean(axis=(1, 3))


def bits8(rgb):
    return np.round(255.0 * rgb)


def view_of(geometry, **options):
    return complete_view(geometry.scene, View(WIDTH, HEIGHT, max_depth=0, **options))


@pytest.mark.parametrize("trilinear", [False, True])
def test_closer_to_the_supersampled_picture(geometry, trilinear):
    view = view_of(geometry, trilinear=trilinear)
    reference = bits8(supersampled(geometry, view))
    without = psnr(bits8(picture(geometry, view, False)), reference)
    with_maps = psnr(bits8(picture(geometry, view, True)), reference)
    print(f"PSNR with mip maps {with_maps:.1f} dB, without {without:.1f} dB (trilinear {trilinear})")
    assert with_maps > without + 1.0


def test_no_shimmer(geometry):
    """Half a pixel to the side: what changes beside what the supersampled pictures change."""
    view = view_of(geometry)
    camera = view.camera
    axis = np.subtract(camera.target, camera.eye)
    right = np.cross(axis, camera.up)
    step = 0.5 * 2.0 * np.tan(np.radians(camera.fov) / 2.0) / HEIGHT * np.linalg.norm(axis) * right / np.linalg.norm(right)
    moved = replace(view, camera=replace(camera, target=tuple(np.add(camera.target, step))))

    def change(mip_maps):
        return np.mean(np.abs(picture(geometry, moved, mip_maps) - picture(geometry, view, mip_maps)))

    with_maps, without = change(True), change(False)
    still = np.mean(np.abs(supersampled(geometry, moved) - supersampled(geometry, view)))
    print(f"mean change by half a pixel: with mip maps {with_maps:.5f}, without {without:.5f}, supersampled {still:.5f}")
    assert with_maps < without
    assert with_maps - still < 0.7 * (without - still)
