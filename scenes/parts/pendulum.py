# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The pendulum of `pendulum.json`: a rod from the origin downwards, a brass ball at its end."""

from raycore.shapes import Builder, sphere, tube

LENGTH, RADIUS = 0.24, 0.036


def build():
    b = Builder("pendulum")
    b.metal("brass", (0.95, 0.72, 0.32), 0.6, 0.25)
    b.metal("steel", (0.75, 0.78, 0.82), 0.4, 0.3)
    b.add(sphere((0.0, -LENGTH, 0.0), RADIUS, 36), "brass", 60.0)
    b.add(tube(((0.0, 0.0, 0.0), (0.0, -LENGTH + 0.9 * RADIUS, 0.0)), 0.0035, 10), "steel", 60.0)
    return b.scene()
