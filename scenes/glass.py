# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Glass and mirrors on a chequered table: spheres, a wine glass, a bottle, coloured panes that colour their shadows; two lamps."""

import numpy as np

from raycore import patterns
from raycore.furniture import fruit, vessel
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, curve, lathe, plane_map, rounded_box, sheet, sphere, torus, turn


def build():
    b = Builder("glass")

    b.varnish("board", patterns.checker((0.88, 0.84, 0.74), (0.20, 0.16, 0.15), 8, 256), shine=0.25, sharpness=64.0)
    b.paint("wood", patterns.wood((0.62, 0.44, 0.28), (0.36, 0.22, 0.12)), shine=0.15)
    b.paint("wall", patterns.plaster((0.78, 0.83, 0.83)), compact=True)
    b.varnish("apple", colour=(0.62, 0.07, 0.05), shine=0.5, sharpness=64.0)
    b.paint("lemon", colour=(0.85, 0.65, 0.06), shine=0.2)
    b.metal("silver", (0.95, 0.95, 0.96), 0.9, 0.05)
    b.metal("gold", (0.95, 0.74, 0.36), 0.85, 0.05)
    b.glass("glass", (0.97, 0.985, 0.98), sharpness=512.0)
    b.glass("bottle", (0.55, 0.80, 0.50))
    b.glass("wine", (0.70, 0.05, 0.09), ior=1.34)
    panes = {"red": (0.97, 0.42, 0.36), "gold": (0.97, 0.86, 0.40), "blue": (0.42, 0.60, 0.97)}
    for name, through in panes.items():
        b.glass(f"{name} pane", through)

    # A table with a wooden border, before a wall that meets the ground in a curve.
    b.add(
        rounded_box((5.2, 0.2, 3.2), 0.03, 4) + (0.0, -0.112, 0.0),
        "wood",
        50.0,
        uv=plane_map((1, 0, 0.3), (0, -0.7, 1), 1.2),
    )
    b.add(box((-2.45, -0.05, -1.45), (2.45, 0.0, 1.45)), "board", 0.0, uv=plane_map((1, 0, 0), (0, 0, 1), 2.0))
    bend = np.radians(np.linspace(0.0, 90.0, 17))
    line = [(5.0, -1.6), *zip(-2.2 - 1.2 * np.sin(bend), -0.4 - 1.2 * np.cos(bend)), (-3.4, 5.5)]
    points = np.array([[(x, y, z) for z, y in line] for x in np.linspace(-8.0, 8.0, 9)])
    b.add(sheet(points)[:, ::-1], "wall", 60.0, uv=plane_map((1, 0, 0), (0, -1, 1), 1.5))

    # Vessels are drawn in metres and shown larger. What is in the glass leaves an air gap of a hair.
    scale = 7.5
    b.add(vessel("wine", 96, 6) * scale + (0.95, 0.004, 0.35), "glass", crease=70.0)
    filling = curve([(0.009, 0.0985), (0.0235, 0.1075), (0.0350, 0.130), (0.0350, 0.1415)], 8)
    body = np.concatenate(([(0.0, filling[0, 1])], filling, [(0.0, filling[-1, 1])]))
    b.add(lathe(body, 96) * scale + (0.95, 0.004, 0.35), "wine", crease=50.0)
    b.add(vessel("bottle", 96, 6) * 6.0 + (-1.0, 0.004, -0.9), "bottle", crease=70.0)
    b.add(vessel("tumbler", 96, 6) * 7.0 + (1.75, 0.004, -0.35), "glass", crease=60.0)

    b.add(sphere((-0.25, 0.504, 0.45), 0.50, 128), "glass")
    b.add(sphere((0.25, 0.65, -0.75), 0.65, 128), "silver")
    b.add(sphere((-1.15, 0.263, 0.75), 0.26, 96), "gold")
    b.add(torus((0.0, 0.11, 0.0), 0.28, 0.10, 128, 48) + (0.55, 0.0, 0.98), "gold")
    b.add(sphere((0.55, 0.17, 0.98), 0.165, 64), "glass")
    b.add(fruit(0.24, 64) + (-0.75, 0.0, -0.35), "apple", at=(0.0, 0.002, 0.0))
    b.add(sphere((0.0, 0.0, 0.0), 0.19, 64) * (1.25, 1.0, 1.0) + (1.55, 0.192, 0.85), "lemon")
    for i, name in enumerate(panes):
        pane = turn(box((-0.36, 0.004, -0.025), (0.36, 1.05, 0.025)), 62.0 - 14.0 * i)
        b.add(pane + (-2.1 + 0.15 * i, 0.0, 0.75 - 0.66 * i), f"{name} pane", crease=0.0)

    lights = [Light((2.8, 4.2, 3.4), (1.00, 0.94, 0.84)), Light((-4.4, 3.4, -0.6), (0.90, 0.92, 0.96))]
    camera = Camera((0.2, 2.05, 4.9), (-0.05, 0.52, 0.0), fov=38.0)
    return b.scene(camera, lights, background=(0.20, 0.24, 0.30), depth=10)
