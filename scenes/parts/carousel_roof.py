# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What turns in `carousel.json` but the horses: a floor, a striped roof, twelve knobs and six poles."""

import numpy as np

from raycore import patterns
from raycore.shapes import Builder, lathe, plane_map, quad, sphere, tube

GORES = 12


def _cone(radius, low, high):
    """A cone of gores, one after the other: (GORES, 2, 3, 3), each a quadrangle that ends in a small ring."""
    angle = 2.0 * np.pi * np.arange(GORES + 1) / GORES

    def ring(r, y):
        return np.stack((r * np.cos(angle), np.full(GORES + 1, y), r * np.sin(angle)), axis=1)

    outer, inner = ring(radius, low), ring(0.1, high)
    return np.array([quad(outer[i + 1], outer[i], inner[i], inner[i + 1]) for i in range(GORES)])


def build():
    b = Builder("carousel roof", ambient_light=0.2)
    b.varnish("floor", patterns.parquet((0.62, 0.42, 0.24), (0.44, 0.28, 0.16)), shine=0.2)
    b.paint("red", colour=(0.78, 0.12, 0.10), shine=0.2)
    b.paint("cream", colour=(0.93, 0.87, 0.72), shine=0.2)
    b.metal("gold", (0.98, 0.76, 0.34), 0.5, 0.3)
    b.add(lathe([(1.55, 0.18), (1.55, 0.25), (0.0, 0.25)], 48), "floor", 30.0, plane_map((1, 0, 0), (0, 0, 1), 1.2))
    for side in (1, -1):  # seen from above and from below
        gores = _cone(1.65, 1.75, 2.25)[:, :, ::side]
        for name, first in (("red", 0), ("cream", 1)):
            b.add(gores[first::2].reshape(-1, 3, 3), name, 0.0)
    for i in range(GORES):
        a = 2.0 * np.pi * i / GORES
        b.add(sphere((1.63 * np.cos(a), 1.72, 1.63 * np.sin(a)), 0.05, 12), "gold", 60.0)
    for i in range(6):
        a = 2.0 * np.pi * i / 6
        x, z = 1.15 * np.cos(a), 1.15 * np.sin(a)
        b.add(tube(((x, 0.25, z), (x, 1.88, z)), 0.022, 12), "gold", 60.0)
    return b.scene()
