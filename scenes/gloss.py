# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Five balls from dull to polished, on a board: highlights shrink and mirrors grow from left to right."""

import numpy as np

from raycore import patterns
from raycore.scene import Camera, Light, make_material
from raycore.shapes import Builder, plane_map, rounded_box, sheet, sphere


def build():
    b = Builder("gloss", ambient_light=0.16)
    b.varnish("board", patterns.wood((0.60, 0.40, 0.24), (0.36, 0.21, 0.12)), shine=0.2)
    b.paint("sweep", colour=(0.58, 0.60, 0.64))
    hues = [(0.62, 0.16, 0.10), (0.70, 0.38, 0.08), (0.55, 0.52, 0.14), (0.12, 0.42, 0.30), (0.12, 0.22, 0.50)]
    balls = []
    for i, hue in enumerate(hues):
        share = i / 4.0
        dull = tuple(c * (1.0 - 0.75 * share) for c in hue)
        mirror = tuple(0.8 * share**1.5 * (0.35 + 0.65 * c / max(hue)) for c in hue)
        shine = (0.05 + 0.75 * share,) * 3
        balls.append(b.material(make_material(f"ball {i}", dull, shine, 4.0 * 3.6**i, reflect=mirror)))

    for i, material in enumerate(balls):
        b.add(sphere((1.1 * (i - 2), 0.502, 0.16 * (i - 2) ** 2), 0.5, 26), material, 60.0)
    board = rounded_box((6.2, 0.12, 2.3), 0.03, 3) + (0.0, -0.061, 0.25)
    b.add(board, "board", 50.0, uv=plane_map((1, 0, 0), (0, 0, 1), (2.4, 1.2)))
    bend = np.radians(np.linspace(0.0, 90.0, 9))
    line = [(7.0, -0.125), *zip(-1.6 - 1.4 * np.sin(bend), 1.275 - 1.4 * np.cos(bend)), (-3.0, 5.0)]
    points = np.array([[(x, y, z) for z, y in line] for x in np.linspace(-8.0, 8.0, 9)])
    b.add(sheet(points)[:, ::-1], "sweep")
    lights = [Light((-3.0, 4.2, 3.6), (0.80, 0.76, 0.70)), Light((3.6, 2.6, 3.8), (0.42, 0.46, 0.55))]
    return b.scene(Camera((0.6, 1.75, 5.6), (0.0, 0.42, 0.0), fov=38.0), lights, depth=6)
