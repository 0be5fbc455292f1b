# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A desk at night: the lamp on its jointed arm, books, a cup of pencils, a globe of brass and glass, paper."""

import math

import numpy as np

from raycore import furniture, patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, box_map, lathe, plane_map, quad, rounded_box, sphere, torus, tube, turn


def lamp(b):
    """The lamp; returns where its bulb is."""
    base, elbow, head = np.array([0.42, 0.0, -0.10]), np.array([0.55, 0.40, -0.16]), np.array([0.16, 0.62, -0.02])
    foot = [(0.0, 0.0), (0.105, 0.0), (0.108, 0.006), (0.10, 0.018), (0.03, 0.028), (0.018, 0.05), (0.0, 0.052)]
    b.add(lathe(foot, 56), "enamel", 40.0, at=base + (0, 0.001, 0))
    for a, c in ((base + (0, 0.05, 0), elbow), (elbow, head)):
        along = (c - a) / np.linalg.norm(c - a)
        side = np.cross(along, (0.0, 1.0, 0.0))
        side *= 0.014 / np.linalg.norm(side)
        for s in (-1.0, 1.0):
            b.add(tube(np.linspace(a, c, 3) + s * side, 0.005, 12), "steel", 60.0)
        turns = np.linspace(0.0, 14 * 2.0 * math.pi, 14 * 10)  # the spring between both rods
        up = np.cross(side, along)
        up *= 0.009 / np.linalg.norm(up)
        ring = np.cos(turns)[:, None] * up + np.sin(turns)[:, None] * side * (0.009 / 0.014)
        b.add(tube(a + (c - a) * np.linspace(0.15, 0.5, len(turns))[:, None] + ring, 0.0016, 5), "steel", 80.0)
    for joint in (base + (0, 0.05, 0), elbow, head):
        b.add(sphere(joint, 0.021, 20), "enamel", 60.0)
    shade = [
        (0.026, 0.10),
        (0.030, 0.07),
        (0.055, 0.03),
        (0.105, -0.055),
        (0.103, -0.056),
        (0.052, 0.028),
        (0.024, 0.068),
    ]
    shade = [(0.0, 0.104), *shade, (0.0, 0.075)]
    b.add(turn(lathe(shade, 72)[:, ::-1], 22.0, "z") + head + (-0.02, -0.09, 0.01), "enamel", 45.0)
    bulb = head + (-0.004, -0.098, 0.010)
    b.add(sphere(bulb, 0.026, 24), "bulb")
    return bulb


def build():
    b = Builder("desk_lamp", ambient_light=0.14)
    b.varnish("desk", patterns.wood((0.50, 0.32, 0.18), (0.30, 0.17, 0.09)), shine=0.2)
    b.paint("wall", patterns.plaster((0.40, 0.46, 0.52)))
    b.varnish("enamel", colour=(0.62, 0.10, 0.07), shine=0.5, sharpness=96.0)
    b.metal("steel", (0.88, 0.89, 0.92), 0.7, 0.15)
    b.metal("brass", (0.92, 0.72, 0.36), 0.6, 0.2)
    b.glass("glass", (0.90, 0.96, 0.95))
    b.glow("bulb", (1.0, 0.94, 0.78))
    b.paint("paper", patterns.text((0.93, 0.91, 0.86), (0.18, 0.18, 0.24), 32, 32))
    b.paint("cup", colour=(0.20, 0.34, 0.38), shine=0.2)
    b.paint("lead", colour=(0.10, 0.10, 0.11))
    b.paint("shaved wood", colour=(0.78, 0.60, 0.40))
    pencils = [
        b.paint(f"pencil {i}", colour=c, shine=0.3)
        for i, c in enumerate(((0.75, 0.55, 0.06), (0.60, 0.10, 0.08), (0.10, 0.28, 0.52)))
    ]
    spines = [
        b.paint(f"book {i}", patterns.text(c, (0.85, 0.76, 0.50), 4, 8, seed=i), shine=0.1)
        for i, c in enumerate(((0.45, 0.12, 0.10), (0.14, 0.26, 0.40), (0.18, 0.32, 0.20), (0.55, 0.44, 0.24)))
    ]

    b.add(rounded_box((2.2, 0.05, 1.1), 0.012, 3) + (0.0, -0.026, 0.0), "desk", 50.0, box_map(0.8, along=0))
    b.add(quad((-3, -1, -0.56), (3, -1, -0.56), (3, 2.5, -0.56), (-3, 2.5, -0.56)), "wall", uv=box_map(1.0))
    bulb = lamp(b)
    for triangles, number in furniture.books(0.62, 0.26, 0.20, 4):
        b.add(triangles, spines[number % 4], 50.0, box_map(0.12), at=(-0.92, 0.0, -0.26))
    for i, yaw in enumerate((14.0, -9.0)):  # two more lie in front of them
        book = turn(rounded_box((0.20, 0.030, 0.27), 0.004, 3), yaw)
        b.add(book, spines[i], 50.0, box_map(0.12), at=(-0.62, 0.0165 + 0.0315 * i, 0.12))
    cup = [(0.0, 0.0), (0.036, 0.0), (0.040, 0.003), (0.040, 0.098), (0.0375, 0.099), (0.0365, 0.006), (0.0, 0.005)]
    b.add(lathe(cup, 48), "cup", 40.0, at=(-0.26, 0.001, -0.30))
    for i in range(7):
        yaw, lean = 51.4 * i, 7.0 + 1.5 * (i % 3)
        body = np.array([(0.0038, 0.0), (0.0038, 0.165)])
        parts = (lathe(np.concatenate(([(0.0, 0.0)], body)), 6), pencils[i % 3])
        tip = (lathe([(0.0038, 0.165), (0.0012, 0.181)], 6), "shaved wood")
        lead = (lathe([(0.0012, 0.181), (0.0, 0.186)], 6), "lead")
        for triangles, material in (parts, tip, lead):
            b.add(turn(turn(triangles, lean, "z") + (0.006, 0.010, 0.0), yaw) + (-0.26, 0.0, -0.30), material, 40.0)
    b.add(
        turn(box((-0.105, 0.0, -0.148), (0.105, 0.0012, 0.148)), 11.0) + (0.02, 0.001, 0.22),
        "paper",
        0.0,
        plane_map((1, 0, 0), (0, 0, 1), 0.21),
    )
    pen = turn(lathe([(0.0, -0.07), (0.002, -0.066), (0.005, -0.045), (0.005, 0.06), (0.0, 0.064)], 16), 90.0, "z")
    b.add(turn(pen, 40.0) + (0.07, 0.0075, 0.25), "brass", 40.0)
    b.add(sphere((-0.28, 0.0985, 0.20), 0.062, 56), "glass", 60.0)
    for tilt in (0.0, 60.0, 120.0):
        b.add(
            turn(turn(torus((0, 0, 0), 0.072 + 0.0001 * tilt, 0.0026, 56, 8), 90.0, "x"), tilt) + (-0.28, 0.0985, 0.20),
            "brass",
            60.0,
        )
    b.add(
        lathe([(0.0, 0.0), (0.045, 0.0), (0.045, 0.006), (0.012, 0.014), (0.012, 0.020), (0.0, 0.020)], 40),
        "brass",
        40.0,
        at=(-0.28, 0.001, 0.20),
    )
    x, y, z = map(float, bulb)
    lights = [
        Light((x - 0.012, y - 0.034, z), (1.0, 0.92, 0.74), attenuation=(0.25, 0.2, 0.8)),
        Light((-1.8, 1.6, 2.0), (0.20, 0.24, 0.32)),
    ]
    return b.scene(
        Camera((0.10, 0.52, 1.42), (-0.06, 0.21, -0.05), fov=42.0), lights, background=(0.02, 0.03, 0.05), depth=6
    )
