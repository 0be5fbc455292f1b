# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A steel ball of `dice.json`, round the origin, its radius one unit."""

from raycore.shapes import Builder, sphere


def build():
    b = Builder("dice ball")
    b.metal("steel", (0.86, 0.88, 0.92), 0.75, 0.15)
    b.add(sphere((0.0, 0.0, 0.0), 1.0, 32), "steel", 60.0)
    return b.scene()
