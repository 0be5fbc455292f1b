# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Every effect of Whitted ray tracing in few triangles: mirror, "glass", textures, masked and blended panes, two lights."""

from raycore import patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, icosphere, plane_map, quad, turn


def build():
    b = Builder("tiny_glass")
    b.paint("floor", patterns.checker((0.90, 0.86, 0.78), (0.30, 0.42, 0.55), 4, 32), (0.9, 0.9, 0.9), 0.2)
    b.paint("wall", colour=(0.70, 0.66, 0.58))
    b.metal("mirror", (0.98, 1.0, 0.99), 0.87, 0.03)
    b.glass("glass", (0.94, 0.98, 0.96))
    leaf = patterns.leaf((0.55, 0.75, 0.30), (0.16, 0.45, 0.16), 64, 32)
    b.paint("leaf", leaf, (0.9, 0.9, 0.9), wrap="clamp", alpha_mode="mask")
    b.paint("film", colour=(0.60, 0.12, 0.10), shine=0.3, sharpness=64.0, alpha=0.45, alpha_mode="blend")

    tile = plane_map((1, 0, 0), (0, 0, 1), 1.0)
    b.add(quad((-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2)), "floor", uv=tile)
    b.add(quad((-2, 0, -2), (2, 0, -2), (2, 3, -2), (-2, 3, -2)), "wall")
    b.add(quad((-1.9, 0.1, 0.4), (-1.0, 0.1, -1.8), (-1.0, 2.4, -1.8), (-1.9, 2.4, 0.4)), "mirror")
    vertices, faces = icosphere(1)
    b.add((0.5 * vertices)[faces] + (-0.25, 0.52, 0.35), "glass", crease=60.0)
    b.add(turn(box((-0.25, 0.01, -0.25), (0.25, 0.9, 0.25)), 30.0) + (0.75, 0.0, -0.9), "wall")
    b.add(turn(box((-0.3, 0.01, -0.06), (0.3, 0.7, 0.06)), -30.0) + (1.25, 0.0, 0.5), "glass", crease=0.0)
    card = quad((0.25, 0.9, -0.3), (1.0, 0.9, -0.5), (1.0, 2.3, -0.5), (0.25, 2.3, -0.3))
    b.add(card, "leaf", uv=plane_map((1, 0, 0), (0, -1, 0), (0.75, 1.4), (0.25, 2.3, 0.0)))
    b.add(quad((-0.9, 0.6, -0.9), (-0.1, 0.6, -1.1), (-0.1, 1.9, -1.1), (-0.9, 1.9, -0.9)), "film")

    lights = [Light((1.2, 3.4, 2.4), (0.85, 0.80, 0.70)), Light((-1.8, 2.8, 2.2), (0.35, 0.40, 0.48))]
    return b.scene(Camera((0.55, 1.55, 4.3), (0.0, 0.9, 0.0), fov=42.0), lights, depth=6)
