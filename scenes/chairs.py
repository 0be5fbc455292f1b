# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Chairs round a set table on a chequered terrace."""

import math

import numpy as np

from raycore import furniture, patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, box_map, curve, lathe, plane_map, quad


def build():
    b = Builder("chairs", ambient_light=0.18)
    b.paint("terrace", patterns.tiles((0.74, 0.66, 0.56), (0.50, 0.40, 0.34), (0.36, 0.34, 0.32), 4, 0.02, 256))
    b.paint("hedge", patterns.plaster((0.16, 0.30, 0.12), 0.6))
    b.paint("wood", patterns.wood((0.62, 0.42, 0.25), (0.40, 0.24, 0.14)), shine=0.15)
    b.varnish("top", patterns.wood((0.52, 0.33, 0.19), (0.34, 0.20, 0.11), seed=4), shine=0.2)
    hues = ((0.60, 0.16, 0.12), (0.16, 0.32, 0.44), (0.72, 0.54, 0.16), (0.22, 0.40, 0.24))
    seats = [b.paint(f"seat {i}", patterns.weave(c, tuple(0.75 * v for v in c), 32)) for i, c in enumerate(hues)]
    b.varnish("china", colour=(0.84, 0.84, 0.80), shine=0.4, sharpness=96.0)
    b.glass("glass", (0.93, 0.97, 0.96))
    b.paint("fruit", colour=(0.76, 0.34, 0.06), shine=0.2)

    b.add(quad((-9, 0, -6), (-9, 0, 4), (9, 0, 4), (9, 0, -6)), "terrace", uv=plane_map((1, 0, 0), (0, 0, 1), 1.6))
    b.add(box((-9, -0.1, -4.6), (9, 1.3, -4.0)), "hedge", 0.0, box_map(0.8))
    top = [(0.0, 0.70), (0.60, 0.70), (0.64, 0.715), (0.64, 0.735), (0.63, 0.745), (0.0, 0.745)]
    b.add(lathe(top, 64), "top", 50.0, plane_map((1, 0, 0), (0, 0, 1), 0.9))
    foot = [
        (0.0, 0.0),
        (0.30, 0.0),
        (0.30, 0.02),
        (0.08, 0.06),
        (0.05, 0.12),
        (0.07, 0.35),
        (0.045, 0.60),
        (0.10, 0.69),
        (0.0, 0.699),
    ]
    b.add(lathe(np.concatenate((foot[:1], curve(foot[1:-1], 3), foot[-1:])), 28), "wood", 60.0, at=(0, 0.001, 0))
    for i in range(4):
        yaw = 90.0 * i + (8.0, -14.0, 5.0, 30.0)[i]
        a, away = math.radians(yaw), (0.80, 0.86, 0.82, 1.02)[i]
        chair = furniture.chair(3)
        at = (-away * math.sin(a), 0.002, -away * math.cos(a))
        b.add(chair["wood"], "wood", 50.0, box_map(0.7, along=1), at, yaw)
        b.add(chair["seat"], seats[i], 60.0, box_map(0.25), at, yaw)
        x, z = -0.42 * math.sin(math.radians(90.0 * i)), -0.42 * math.cos(math.radians(90.0 * i))
        plate = [(0.0, 0.0), (0.06, 0.0), (0.075, 0.006), (0.115, 0.018), (0.114, 0.021), (0.074, 0.010), (0.0, 0.008)]
        b.add(lathe(plate, 36), "china", 50.0, at=(x, 0.7462, z))
        side = np.array([math.cos(math.radians(90.0 * i)), 0.0, -math.sin(math.radians(90.0 * i))])
        b.add(
            furniture.vessel("tumbler", 22, 2),
            "glass",
            70.0,
            at=np.array([x, 0.7463, z]) * (0.85, 1, 0.85) + 0.19 * side,
        )
    bowl = curve(
        [
            (0.06, 0.0),
            (0.07, 0.01),
            (0.13, 0.06),
            (0.15, 0.09),
            (0.143, 0.092),
            (0.12, 0.06),
            (0.06, 0.016),
            (0.0, 0.014),
        ],
        3,
    )
    b.add(lathe(np.concatenate(([(0.0, 0.0)], bowl)), 36), "china", 60.0, at=(0.0, 0.7462, 0.0))
    for x, y, z in ((-0.05, 0.03, 0.03), (0.05, 0.03, 0.04), (0.0, 0.032, -0.05), (0.01, 0.10, 0.01)):
        b.add(furniture.fruit(0.042, 18), "fruit", 70.0, at=(x, 0.7462 + y, z))
    lights = [
        Light((0.55, 0.75, 0.45), (0.95, 0.88, 0.74), directional=True),
        Light((-4.0, 4.0, 5.0), (0.22, 0.28, 0.38)),
    ]
    return b.scene(
        Camera((1.10, 1.55, 2.25), (0.0, 0.50, 0.0), fov=42.0), lights, background=(0.55, 0.70, 0.88), depth=5
    )
