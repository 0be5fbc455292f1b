# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What the pendulum of `pendulum.json` hangs from: two posts beside the board and a beam."""

from raycore import patterns
from raycore.shapes import Builder, box_map, rounded_box, sphere

HEIGHT, HALF = 0.42, 0.275


def build():
    b = Builder("gallows", ambient_light=0.16)
    b.varnish("dark wood", patterns.wood((0.36, 0.20, 0.12), (0.20, 0.10, 0.06)), shine=0.2)
    for side in (-1.0, 1.0):
        post = rounded_box((0.024, HEIGHT + 0.012, 0.024), 0.004, 2) + (side * HALF, HEIGHT / 2 + 0.006, 0.0)
        b.add(post, "dark wood", 50.0, box_map(0.3))
        foot = rounded_box((0.05, 0.014, 0.12), 0.005, 2) + (side * HALF, 0.008, 0.0)
        b.add(foot, "dark wood", 50.0, box_map(0.3))
        b.add(sphere((side * HALF, HEIGHT + 0.03, 0.0), 0.018, 16), "dark wood", 60.0, box_map(0.3))
    beam = rounded_box((2 * HALF + 0.06, 0.02, 0.02), 0.004, 2) + (0.0, HEIGHT + 0.004, 0.0)
    b.add(beam, "dark wood", 50.0, box_map(0.3))
    return b.scene()
