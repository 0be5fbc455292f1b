# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What stands still in `dice.json`: a tray with a rim, and a wall behind it."""

from raycore import patterns
from raycore.shapes import Builder, box, plane_map, quad


def build():
    b = Builder("dice tray", ambient_light=0.2)
    b.varnish("board", patterns.parquet((0.66, 0.46, 0.28), (0.54, 0.35, 0.20), size=256), shine=0.2)
    b.paint("rim", colour=(0.30, 0.16, 0.09), shine=0.3)
    b.paint("wall", patterns.wallpaper((0.50, 0.58, 0.56), (0.36, 0.46, 0.46), size=128))
    b.add(quad((-3, 0, -3), (-3, 0, 3), (3, 0, 3), (3, 0, -3)), "board", uv=plane_map((1, 0, 0), (0, 0, 1), 3.0))
    for lo, hi in (
        ((-3.2, -0.1, -3.2), (-3.0, 0.35, 3.2)),
        ((3.0, -0.1, -3.2), (3.2, 0.35, 3.2)),
        ((-3.0, -0.1, -3.2), (3.0, 0.35, -3.0)),
        ((-3.0, -0.1, 3.0), (3.0, 0.35, 3.2)),
    ):
        b.add(box(lo, hi), "rim", 0.0)
    b.add(
        quad((-5.5, -0.1, -3.6), (5.5, -0.1, -3.6), (5.5, 3.6, -3.6), (-5.5, 3.6, -3.6)),
        "wall",
        uv=plane_map((1, 0, 0), (0, -1, 0), 2.0),
    )
    return b.scene()
