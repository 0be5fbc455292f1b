# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Texture test cards: fine patterns on planes at grazing angles, every wrap and format, a masked and a blended card."""

import numpy as np

from raycore import patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, cylinder_map, lathe, quad, sphere, sphere_map


def card(size, at, uv):
    """An upright card that faces +z, its foot's middle at a place: (triangles, coordinates); uv: at its upper left, lower right."""
    (u0, v0), (u1, v1) = uv
    x, y, z = at
    w, h = size[0] / 2.0, size[1]
    triangles = quad((x - w, y, z), (x + w, y, z), (x + w, y + h, z), (x - w, y + h, z))
    return triangles, np.array([[(u0, v1), (u1, v1), (u1, v0)], [(u0, v1), (u1, v0), (u0, v0)]])


def build():
    b = Builder("cards", ambient_light=0.45)
    black, white, sand, blue = (0.05, 0.05, 0.06), (0.95, 0.95, 0.93), (0.86, 0.78, 0.60), (0.15, 0.25, 0.55)

    fine = patterns.checker(black, white, 32, 256)
    page = patterns.text(white, black)
    arrow = patterns.tiles(sand, blue, black, 4, 0.03, 64)
    arrow[4:28, 4:12] = (200, 30, 30, 255)  # one corner tells the way up
    arrow[4:12, 4:28] = (30, 160, 60, 255)
    leaf = patterns.leaf((0.55, 0.75, 0.30), (0.12, 0.40, 0.14))
    fade = patterns.to_image(
        patterns.mix(sand, blue, np.linspace(0.0, 1.0, 64)[:, None] * np.ones(64)), np.linspace(0, 1, 64)[:, None]
    )

    # The ground: one picture a metre, seen down to the horizon; half of it chequered, half of it text, one of them compact.
    chequered, written = b.paint("fine checker", fine), b.paint("page", page, compact=True)
    for x, material in ((-12.0, chequered), (0.0, written)):
        ground = quad((x, 0, -40), (x, 0, 4), (x + 12, 0, 4), (x + 12, 0, -40))
        b.add(ground, material, 0.0, uv=lambda t: t[..., [0, 2]] / (1.0, 1.0))
    # A wall at the side that the camera looks along.
    wall = quad((-3.2, 0, 4), (-3.2, 0, -40), (-3.2, 2.4, -40), (-3.2, 2.4, 4))
    b.add(wall, b.paint("wall page", page), 0.0, uv=lambda t: np.stack((-t[..., 2], -t[..., 1] * 2.0), axis=2) / 1.5)

    # Upright cards: each wrap over two and a half pictures, then formats, then what alpha does.
    twice = ((-0.75, -0.75), (1.75, 1.75))
    whole = ((0.0, 0.0), (1.0, 1.0))
    row = [
        ("repeat", arrow, twice, {}),
        ("mirror", arrow, twice, dict(wrap_s="mirror", wrap_t="mirror")),
        ("clamp", arrow, twice, dict(wrap_s="clamp", wrap_t="clamp")),
        ("repeat and clamp, compact", arrow, twice, dict(wrap_t="clamp", compact=True)),
        ("painting", patterns.painting(), whole, {}),
        ("painting, compact", patterns.painting(), whole, dict(compact=True)),
        ("painting, linear", patterns.painting(), whole, dict(srgb=False)),
        ("masked", leaf, whole, dict(wrap_s="clamp", wrap_t="clamp", alpha_mode="mask")),
        ("masked, compact", leaf, whole, dict(wrap_s="clamp", wrap_t="clamp", alpha_mode="mask", compact=True)),
        ("blended", fade, whole, dict(wrap_s="clamp", wrap_t="clamp", alpha=0.9, alpha_mode="blend")),
    ]
    for i, (name, image, uv, more) in enumerate(row):
        at = (-2.3 + 1.15 * (i % 5), 0.001 + 1.0 * (i // 5), -2.2 - 0.9 * (i // 5))
        triangles, coordinates = card((1.0, 0.9), at, uv)
        b.add(triangles, b.paint(name, image, **more), 0.0, uv=coordinates)

    # Round things: a globe and a column, whose patterns shrink towards the edge; coordinates far from zero.
    tiles = b.paint("tiles", patterns.tiles(sand, white, black), wrap_s="repeat", wrap_t="mirror")
    b.add(sphere((0.0, 0.0, 0.0), 0.45, 64), tiles, uv=sphere_map(repeats=4), at=(2.7, 0.451, -0.6))
    column = lathe([(0.0, 0.0), (0.22, 0.0), (0.22, 2.6), (0.0, 2.6)], 64)
    b.add(column, chequered, uv=lambda t: cylinder_map(6, 0.25)(t) + (1000.0, -500.0), at=(3.6, 0.001, -3.0))

    lights = [Light((2.5, 5.0, 3.5), (0.75, 0.74, 0.70)), Light((-1.5, 4.0, 2.0), (0.25, 0.27, 0.30))]
    camera = Camera((0.35, 1.05, 3.2), (0.25, 0.95, -3.0), fov=50.0)
    return b.scene(camera, lights, background=(0.55, 0.65, 0.80), depth=6)
