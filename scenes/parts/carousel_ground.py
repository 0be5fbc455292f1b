# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What stands still in `carousel.json`: paving, a plinth and a pole with a ball of chrome on top."""

from raycore import patterns
from raycore.shapes import Builder, lathe, plane_map, quad, sphere


def build():
    b = Builder("carousel ground", ambient_light=0.2)
    b.paint("paving", patterns.tiles((0.62, 0.58, 0.52), (0.54, 0.52, 0.50), (0.36, 0.35, 0.34)))
    b.paint("plinth", colour=(0.50, 0.16, 0.14), shine=0.3)
    b.metal("chrome", (0.9, 0.9, 0.92), 0.7)
    b.add(
        quad((-4.5, 0, -4.5), (-4.5, 0, 4.5), (4.5, 0, 4.5), (4.5, 0, -4.5)),
        "paving",
        uv=plane_map((1, 0, 0), (0, 0, 1), 2.0),
    )
    b.add(lathe([(1.72, 0.0), (1.72, 0.12), (1.62, 0.12), (1.62, 0.17), (0.0, 0.17)], 48), "plinth", 30.0)
    b.add(lathe([(0.09, 0.17), (0.09, 2.3), (0.0, 2.3)], 20), "chrome", 40.0)
    b.add(sphere((0.0, 2.36, 0.0), 0.13, 24), "chrome", 60.0)
    return b.scene()
