# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Balls, rings and twisted bars of coloured glass on a pale table: their shadows are coloured."""

import math

import numpy as np

from raycore import patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, icosphere, plane_map, quad, rounded_box, sheet, torus, turn


def twisted(height, radius, rings, sides, turns):
    """An upright bar of rounded triangular cross section, twisted round its axis and closed above and below."""
    a = 2.0 * math.pi * np.arange(sides) / sides
    wall = []
    for y in np.linspace(0.0, 1.0, rings):
        r = radius * (1.0 + 0.22 * np.cos(3.0 * a)) * (0.72 + 0.28 * math.cos(2.0 * math.pi * y))
        b = a + 2.0 * math.pi * turns * y
        wall.append(np.stack((r * np.cos(b), np.full(sides, y * height), r * np.sin(b)), axis=1))
    ends = [np.broadcast_to((0.0, y, 0.0), (sides, 3)) for y in (0.0, height)]
    points = np.stack([ends[0], *wall, ends[1]], axis=1)
    return sheet(points, close_u=True)[:, ::-1]


def build():
    b = Builder("coloured_shadows", ambient_light=0.20)
    b.paint("table", patterns.plaster((0.86, 0.84, 0.80), 0.12))
    b.paint("wall", colour=(0.66, 0.68, 0.70))
    tints = {
        "red": (0.97, 0.30, 0.28), "orange": (0.98, 0.62, 0.22), "yellow": (0.97, 0.90, 0.30), "green": (0.38, 0.85, 0.45),
        "blue": (0.32, 0.52, 0.96), "violet": (0.72, 0.42, 0.92), "clear": (0.95, 0.98, 0.97),
    }  # fmt: skip
    for name, colour in tints.items():
        b.glass(f"{name} glass", colour)

    b.add(quad((-6, 0, -4), (-6, 0, 4), (6, 0, 4), (6, 0, -4)), "table", uv=plane_map((1, 0, 0), (0, 0, 1), 1.5))
    b.add(quad((-6, 0, -4), (6, 0, -4), (6, 5, -4), (-6, 5, -4)), "wall")
    vertices, faces = icosphere(4)
    ball = vertices[faces]
    for name, (x, z), r in (
        ("red", (-1.30, 0.35), 0.36), ("blue", (-0.38, 0.80), 0.30), ("yellow", (0.55, 0.62), 0.34),
        ("green", (1.45, 0.20), 0.40), ("clear", (0.10, -0.35), 0.52),
    ):  # fmt: skip
        b.add(r * ball, f"{name} glass", 70.0, at=(x, r + 0.003, z))
    for name, (x, z), height, turns in (
        ("violet", (-0.95, -0.75), 1.55, 0.6), ("orange", (1.05, -0.90), 1.75, -0.5), ("green", (-2.0, -0.35), 1.15, 0.4),
        ("red", (2.05, -0.55), 1.30, 0.45),
    ):  # fmt: skip
        b.add(twisted(height, 0.21, 72, 42, turns), f"{name} glass", 75.0, at=(x, 0.003, z))
    for name, (x, z), r in (
        ("orange", (-0.45, 1.50), 0.27),
        ("violet", (1.20, 1.15), 0.24),
        ("blue", (-1.75, 1.10), 0.25),
    ):
        b.add(torus((0.0, 0.0, 0.0), r, 0.085, 72, 24), f"{name} glass", 70.0, at=(x, 0.0883, z))
    for name, (x, z), yaw in (("yellow", (0.42, 1.62), 20.0), ("clear", (-1.05, 1.30), -15.0)):
        b.add(turn(rounded_box((0.26, 0.26, 0.26), 0.03, 6), yaw), f"{name} glass", 60.0, at=(x, 0.1335, z))
    lights = [Light((2.6, 3.6, -2.6), (0.85, 0.82, 0.76)), Light((-1.5, 3.4, 4.5), (0.42, 0.44, 0.50))]
    return b.scene(Camera((0.35, 2.05, 4.5), (0.0, 0.42, 0.15), fov=40.0), lights, depth=8)
