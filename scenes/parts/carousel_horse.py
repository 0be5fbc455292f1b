# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A horse of `carousel.json`: looks along z, its saddle at the origin."""

from raycore.shapes import Builder, sphere, tube


def build():
    b = Builder("carousel horse", ambient_light=0.2)
    b.varnish("coat", colour=(0.86, 0.84, 0.80), shine=0.4, sharpness=64.0)
    b.paint("mane", colour=(0.30, 0.17, 0.10), shine=0.1)
    b.paint("saddle", colour=(0.72, 0.10, 0.14), shine=0.4)
    unit = sphere((0.0, 0.0, 0.0), 1.0, 16)
    b.add(unit * (0.115, 0.125, 0.26) + (0.0, -0.10, 0.0), "coat", 60.0)
    b.add(unit * (0.055, 0.065, 0.115) + (0.0, 0.235, 0.36), "coat", 60.0)
    b.add(tube(((0.0, -0.06, 0.17), (0.0, 0.08, 0.25), (0.0, 0.24, 0.31)), 0.065, 10), "coat", 60.0)
    b.add(tube(((0.0, 0.04, 0.13), (0.0, 0.17, 0.21), (0.0, 0.31, 0.27)), 0.035, 8), "mane", 60.0)
    b.add(tube(((0.0, -0.06, -0.24), (0.0, -0.10, -0.33), (0.0, -0.27, -0.37)), 0.03, 8), "mane", 60.0)
    for x in (-0.06, 0.06):
        knee = 0.05 if x > 0 else -0.02
        b.add(tube(((x, -0.13, 0.16), (x, -0.27, 0.24 + knee), (x, -0.37, 0.15 + knee)), 0.026, 8), "coat", 60.0)
        b.add(tube(((x, -0.13, -0.16), (x, -0.27, -0.22 + knee), (x, -0.40, -0.17 + knee)), 0.026, 8), "coat", 60.0)
        b.add(sphere((0.6 * x, 0.31, 0.30), 0.022, 8), "coat", 60.0)
    b.add(unit * (0.122, 0.05, 0.11), "saddle", 60.0)
    return b.scene()
