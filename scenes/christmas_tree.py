# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A Christmas tree with mirror balls, candles and a star, presents under it, before a papered wall."""

import math

import numpy as np

from raycore import patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, box_map, lathe, plane_map, quad, rounded_box, sheet, sphere, tube, turn

TIERS = (
    (0.30, 0.62, 0.62),
    (0.60, 0.52, 0.55),
    (0.88, 0.42, 0.50),
    (1.13, 0.32, 0.45),
    (1.36, 0.22, 0.40),
)  # y, radius, height


def tier(radius, height, segments):
    """A skirt of branches: a wavy cone, its rim drawn out into tips that hang down."""
    u, v = np.meshgrid(np.arange(segments) / segments, np.linspace(0.0, 1.0, 7), indexing="ij")
    tips = 0.5 + 0.5 * np.cos(2.0 * math.pi * u * segments / 4.0)
    r = radius * v * (1.0 + 0.20 * tips * v**2)
    y = height * (1.0 - v) ** 1.25 + 0.06 * np.sin(5.0 * v) * v - 0.07 * tips * v**4
    top = np.stack((r * np.cos(2.0 * math.pi * u), y, r * np.sin(2.0 * math.pi * u)), axis=2)
    under = top[:, ::-1] * (0.985, 1.0, 0.985) - (0.0, 0.02, 0.0)
    return sheet(np.concatenate((top, under[:, :-1]), axis=1), close_u=True)


def build():
    b = Builder("christmas_tree", ambient_light=0.16)
    b.varnish("floor", patterns.parquet((0.70, 0.50, 0.32), (0.46, 0.29, 0.17)), shine=0.2)
    b.paint("paper", patterns.wallpaper((0.55, 0.16, 0.16), (0.68, 0.30, 0.22)))
    b.paint("needles", colour=(0.05, 0.22, 0.09), shine=0.1)
    b.paint("bark", colour=(0.26, 0.16, 0.09))
    b.paint("pot", colour=(0.50, 0.22, 0.12), shine=0.2)
    b.paint("wax", colour=(0.88, 0.84, 0.72), shine=0.2)
    b.glow("flame", (1.0, 0.80, 0.36))
    b.metal("gold", (0.98, 0.76, 0.34), 0.65, 0.25)
    for name, colour in {"red": (0.92, 0.16, 0.14), "silver": (0.93, 0.94, 0.96), "blue": (0.26, 0.42, 0.92)}.items():
        b.metal(f"{name} ball", colour, 0.60, 0.30)
    papers = [
        b.paint(f"present {i}", patterns.checker(c, d, n, 64), shine=0.25)
        for i, (c, d, n) in enumerate(
            (
                ((0.80, 0.75, 0.62), (0.70, 0.20, 0.16), 4),
                ((0.16, 0.34, 0.30), (0.20, 0.44, 0.38), 8),
                ((0.18, 0.22, 0.46), (0.62, 0.60, 0.70), 2),
            )
        )
    ]

    b.add(quad((-4, 0, -1.2), (-4, 0, 3), (4, 0, 3), (4, 0, -1.2)), "floor", uv=plane_map((1, 0, 0), (0, 0, 1), 1.4))
    b.add(quad((-4, 0, -1.2), (4, 0, -1.2), (4, 3.6, -1.2), (-4, 3.6, -1.2)), "paper", uv=box_map(0.7))
    b.add(
        lathe(
            [
                (0.0, 0.0),
                (0.13, 0.0),
                (0.19, 0.24),
                (0.20, 0.24),
                (0.20, 0.27),
                (0.17, 0.27),
                (0.16, 0.23),
                (0.0, 0.23),
            ],
            40,
        ),
        "pot",
        40.0,
        at=(0, 0.001, 0),
    )
    b.add(tube(np.array([(0.0, 0.2, 0.0), (0.0, 1.0, 0.0), (0.0, 1.7, 0.0)]), 0.035, 10), "bark", 60.0)
    names = ("red ball", "gold", "silver ball", "blue ball")
    for n, (y, radius, height) in enumerate(TIERS):
        b.add(tier(radius, height, 48 - 4 * n), "needles", 50.0, at=(0, y, 0), yaw=17.0 * n)
        count = 9 - n
        for i in range(count):
            a = 2.0 * math.pi * (i + 0.37 * n) / count
            r = radius * 1.10
            size = 0.060 - 0.006 * n
            at = np.array([r * math.cos(a), y - 0.11, r * math.sin(a)])
            b.add(sphere(at, size, 20), names[(i + n) % 4], 60.0)
            b.add(tube(np.array([at + (0, 0.99 * size, 0), at + (0, size + 0.06, 0)]), 0.004, 5), "gold", 60.0)
        for i in range(5 - n // 2):  # candles stand on the branches
            a = 2.0 * math.pi * (i + 0.5 + 0.23 * n) / (5 - n // 2)
            r, foot = 0.78 * radius, y + 0.10 * height + 0.02
            at = np.array([r * math.cos(a), foot, r * math.sin(a)])
            b.add(lathe([(0.0, 0.0), (0.012, 0.0), (0.012, 0.09), (0.0, 0.094)], 10), "wax", 40.0, at=at)
            flame = [(0.0, 0.0), (0.007, 0.010), (0.009, 0.020), (0.0, 0.048)]
            b.add(lathe(flame, 8), "flame", 60.0, at=at + (0.0, 0.096, 0.0))
    angle = np.radians(90.0 + 36.0 * np.arange(10))
    rim = np.where(np.arange(10) % 2 == 0, 0.12, 0.048)
    ring = np.stack((rim * np.cos(angle), rim * np.sin(angle), 0.0 * angle), axis=1)
    points = np.stack(
        (np.broadcast_to((0.0, 0.0, 0.03), ring.shape), ring, np.broadcast_to((0.0, 0.0, -0.03), ring.shape)), axis=1
    )
    b.add(sheet(points, close_u=True)[:, ::-1], "gold", 0.0, at=(0.0, 1.86, 0.0))
    for i, (x, z, yaw, size) in enumerate(
        (
            (-0.62, 0.42, 20.0, (0.36, 0.22, 0.28)),
            (0.60, 0.34, -25.0, (0.30, 0.34, 0.30)),
            (0.10, 0.74, 8.0, (0.40, 0.14, 0.26)),
        )
    ):
        b.add(rounded_box(size, 0.008, 2), papers[i], 50.0, box_map(0.2), at=(x, size[1] / 2 + 0.001, z), yaw=yaw)
        w, h, d = (0.5 * s + 0.002 for s in size)
        for lo, hi in (((-0.02, -h + 0.004, -d), (0.02, h, d)), ((-w, -h + 0.004, -0.02), (w, h - 0.0005, 0.02))):
            b.add(turn(box(lo, hi), yaw), "red ball" if i == 1 else "gold", at=(x, size[1] / 2 + 0.001, z))
        t = np.linspace(0.0, 2.0 * math.pi, 20, endpoint=False)
        for s in (-1.0, 1.0):
            bow = np.stack((s * 0.045 * (1.0 - np.cos(t)), 0.035 * (1.0 - np.cos(t)) * 0.6, 0.04 * np.sin(t)), axis=1)
            b.add(turn(tube(bow, 0.008, 6, close=True), yaw), "gold", 60.0, at=(x, size[1] + 0.008, z))
    lights = [Light((-1.6, 2.5, 2.4), (0.80, 0.72, 0.58)), Light((1.9, 1.3, 2.3), (0.36, 0.34, 0.36))]
    return b.scene(Camera((0.25, 1.30, 3.55), (0.0, 0.93, 0.0), fov=40.0), lights, depth=4)
