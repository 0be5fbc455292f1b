# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The models of ray generation and of pixels against closed forms, with the tolerances that docs/raygen.md derives."""

import math

import numpy as np
import pytest

from raycore.errors import OptionError
from raycore.model import fp24, pixbuf, rgen

EPS = 2.0**-17  # half a unit in the last place of a number in [1, 2)
LENGTH_ERROR = 4.2 * EPS


def cameras(seed, count=20):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        width, height = rng.integers(1, 200, 2)
        eye, target, up = rng.uniform(-1, 1, (3, 3))
        yield (eye, target, up, rng.uniform(2, 150), int(width), int(height))


def test_axes_by_hand():
    """Eye on +z, 90 degrees: the picture is the square [-1, 1]^2 in the plane one unit ahead, y up, row 0 on top."""
    camera = rgen.camera_vectors((0, 0, 5), (0, 0, 0), (0, 3, 0), 90, 4, 2)
    assert np.allclose(camera.org, (0, 0, 5)) and np.allclose(camera.u, (1, 0, 0)) and np.allclose(camera.v, (0, -1, 0))
    assert np.allclose(camera.c, (-2, 1, -1))
    direction, inv = rgen.primary_rays_double(camera, 4, 2)
    assert np.allclose(direction[0, 3], np.array([1.5, 0.5, -1]) / math.sqrt(3.5))
    assert np.allclose(direction * inv, 1.0)


def test_view_axis_and_angle(seed):
    """The middle of the picture looks at the target; its upper and lower edges see the given angle; pixels are square."""
    for eye, target, up, fov, width, height in cameras(seed):
        c = rgen.camera_vectors(eye, target, up, fov, width, height)
        middle = c.c + c.u * width / 2 + c.v * height / 2
        assert np.allclose(middle, (target - eye) / np.linalg.norm(target - eye))
        top, bottom = middle - c.v * height / 2, middle + c.v * height / 2
        cos = top @ bottom / np.linalg.norm(top) / np.linalg.norm(bottom)
        assert math.isclose(math.degrees(math.acos(cos)), fov, rel_tol=1e-6)
        assert math.isclose(np.linalg.norm(c.u), np.linalg.norm(c.v)) and abs(c.u @ c.v) < 1e-12
        assert up @ -c.v > 0 and np.cross(c.u, -c.v) @ middle < 0


def test_rays_against_double(seed):
    """FP24 rays against double precision from the same registers, within the sum of all rounding errors."""
    for view in cameras(seed):
        camera = rgen.camera_registers(*view)
        width, height = view[4:]
        direction, inv = rgen.primary_rays(camera, width, height)
        exact, _ = rgen.primary_rays_double(camera, width, height)
        px, py = np.arange(width)[None, :, None] + 0.5, np.arange(height)[:, None, None] + 0.5
        v = camera.c + px * camera.u + py * camera.v
        v_error = (np.abs(px * camera.u) + np.abs(py * camera.v) + np.abs(v) * (1 + EPS)) * EPS * 1.001
        length = np.linalg.norm(v, axis=2, keepdims=True)
        bound = v_error / length + np.abs(exact) * (LENGTH_ERROR + np.linalg.norm(v_error, axis=2, keepdims=True) / length)
        assert np.all(np.abs(direction - exact) <= bound * 1.001)
        assert np.all(np.abs(np.linalg.norm(direction, axis=2) - 1) <= LENGTH_ERROR)
        nonzero = direction != 0
        assert np.all(np.abs((direction * inv)[nonzero] - 1) <= EPS)
        assert np.all(np.abs(inv[~nonzero]) == 2.0**62)


def test_inverse_corners():
    big = 2.0**62
    for d, want in [(0.0, big), (-0.0, -big), (2.0**-62, big), (-(2.0**-62), -big), (1.0, 1.0), (math.inf, 0.0)]:
        got = rgen.inverse(d)
        assert got == want and math.copysign(1, got) == math.copysign(1, want)
    assert math.isnan(rgen.inverse(math.nan))


@pytest.mark.parametrize("view, words", [
    (((0, 0, 0), (0, 0, 0), (0, 1, 0), 60, 8, 8), "same point"),
    (((0, 0, 0), (0, 1, 0), (0, 2, 0), 60, 8, 8), "parallel"),
    (((0, 0, 0), (0, 1, 0), (0, 0, 0), 60, 8, 8), "zero"),
    (((0, 0, math.nan), (0, 1, 0), (1, 0, 0), 60, 8, 8), "finite"),
    (((0, 0, 0), (0, 1, 0), (1, 0, 0), 180, 8, 8), "180"),
    (((0, 0, 0), (0, 1, 0), (1, 0, 0), math.nan, 8, 8), "nan"),
    (((0, 0, 0), (0, 1, 0), (1, 0, 0), 60, 0, 8), "0x8"),
    (((0, 0, 0), (0, 1, 0), (1, 0, 0), 60, 8, 65536), "65536"),
])
def test_views_that_make_no_sense(view, words):
    with pytest.raises(OptionError, match=words):
        rgen.camera_registers(*view)


def test_order_of_pixels():
    """Hand-made beginnings, and every pixel once."""
    assert pixbuf.block_order(33, 9).tolist() == [[0, 0], [0, 1], [1, 0], [1, 1], [2, 0], [2, 1], [3, 0], [3, 1], [4, 0], [4, 1]]
    assert pixbuf.pixel_order(8, 8)[:9].tolist() == [[0, 0], [0, 1], [1, 0], [1, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 0]]
    for width, height in [(1, 1), (7, 5), (100, 37), (16, 48)]:
        order = pixbuf.pixel_order(width, height)
        assert len(order) == width * height == len({tuple(p) for p in order.tolist()})
        assert order.min() == 0 and order.max(axis=0).tolist() == [width - 1, height - 1]


def test_formats(seed):
    """Known words, and packed colours against the plain formula."""
    rgb = np.array([[0.0, 0.5, 1.0], [-1.0, math.nan, 7.0]])
    assert pixbuf.pack(rgb, pixbuf.RGBA8).tolist() == [0xFFFF8000, 0xFFFF0000]
    assert pixbuf.pack(rgb, pixbuf.RGB10A2).tolist() == [0xFFF << 20 | 512 << 10, 0xFFF << 20]
    rgb = fp24.round_to_fp24(np.random.default_rng(seed).uniform(0, 1, (50, 20, 3)))
    for fb_format, top in ((pixbuf.RGBA8, 255), (pixbuf.RGB10A2, 1023)):
        assert np.array_equal(pixbuf.unpack(pixbuf.pack(rgb, fb_format), fb_format), np.floor(rgb * top + 0.5))
        with pytest.raises(ValueError):
            pixbuf.pack(rgb, 2)
