# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What real files contain and nobody wants: triangles without area, twice, in one plane, thin as hairs, turned round."""

import numpy as np

from raycore.scene import Camera, Light, make_material
from raycore.shapes import Builder, box, quad, sphere


def build():
    b = Builder("nasty")
    grey = b.material(make_material("floor", (0.5, 0.5, 0.5)))
    red = b.material(make_material("twice", (0.6, 0.15, 0.1), (0.3, 0.3, 0.3)))
    blue = b.material(make_material("inside out", (0.15, 0.25, 0.6)))
    green = b.material(make_material("hairs", (0.2, 0.5, 0.15)))

    floor = quad((-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2))
    b.add(floor, grey)
    b.add(floor[:, ::-1], grey)  # the same floor, facing down
    b.add(quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)), grey)  # and a part of it again

    ball = sphere((-0.8, 0.5, 0.0), 0.5, 24)
    b.add(np.repeat(ball, 2, axis=0), red)  # each triangle twice in a row
    b.add(box((0.4, 0.0, -0.4), (1.2, 0.8, 0.4))[:, ::-1], blue)

    rng = np.random.default_rng(7)
    foot = rng.uniform(-1.8, 1.8, (200, 3)) * (1, 0, 1)
    top = foot + rng.normal(0.0, 0.1, (200, 3)) + (0.0, 0.9, 0.0)
    b.add(np.stack((foot, foot + (1e-4, 0.0, 0.0), top), axis=1), green)  # hairs

    point = rng.uniform(-1.0, 1.0, (40, 3))
    b.add(np.repeat(point[:, None], 3, axis=1), green)  # three times the same vertex
    b.add(np.stack((point, point, -point), axis=1), green)  # twice
    b.add(np.stack((point, point * 0.5, point * 0.25), axis=1), green)  # on a line: no area but for rounding
    b.add(
        point[0] + np.array([(0, 0, 0), (1e-9, 0, 0), (0, 1e-9, 0)]), green
    )  # far below the grid of 24-bit coordinates

    return b.scene(Camera((1.2, 1.8, 4.4), (0.0, 0.4, 0.0), fov=45.0), [Light((1.5, 3.5, 2.5))])
