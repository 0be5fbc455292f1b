# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A room with a box and a tetrahedron: 27 triangles, for quick tests that still show every effect."""

import numpy as np

from raycore.scene import Camera, Light, make_material
from raycore.shapes import Builder, box, quad, turn


def build():
    b = Builder("tiny")
    white = b.material(make_material("white", (0.72, 0.70, 0.66)))
    red = b.material(make_material("red", (0.62, 0.10, 0.08)))
    green = b.material(make_material("green", (0.12, 0.45, 0.15)))
    blue = b.material(make_material("blue", (0.15, 0.25, 0.60), (0.4, 0.4, 0.4), 32.0))
    gold = b.material(make_material("gold", (0.70, 0.48, 0.12), (0.5, 0.4, 0.2), 64.0))
    lamp = b.material(make_material("lamp", (0.0, 0.0, 0.0), emission=(1.0, 0.95, 0.85)))

    b.add(quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)), white)  # floor
    b.add(quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)), white)  # ceiling
    b.add(quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)), white)  # back
    b.add(quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), red)
    b.add(quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), green)
    b.add(turn(box((-0.3, 0.0, -0.3), (0.3, 1.15, 0.3)), 20.0) + (-0.38, 0.0, -0.35), blue)

    # A tetrahedron that stands on one face.
    base = [(np.cos(a), 0.0, np.sin(a)) for a in np.radians((90.0, 210.0, 330.0))]
    top = (0.0, 2.0**0.5, 0.0)
    faces = [(base[0], base[1], base[2])] + [(base[i], top, base[(i + 1) % 3]) for i in range(3)]
    b.add(np.array(faces)[:, ::-1] * 0.45 + (0.42, 0.0, 0.35), gold, crease=0.0)
    b.add(np.array([[(-0.2, 1.99, -0.2), (0.2, 1.99, -0.2), (0.0, 1.99, 0.2)]]), lamp)

    return b.scene(Camera((0.0, 1.05, 3.35), (0.0, 0.95, 0.0), fov=42.0), [Light((0.0, 1.9, 0.3), (1.0, 0.95, 0.85))])
