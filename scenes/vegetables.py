# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Vegetables on a board: a pumpkin, tomatoes, aubergine, cucumber, carrots, peppers, onions, lemons in a bowl."""

import numpy as np

from raycore import furniture, patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box_map, curve, lathe, plane_map, quad, rounded_box, tube, turn


def oval(length, radius, rings, segments, waist=0.0):
    """A long body along x, its lowest line at y = 0; waist: how much thinner its first half is."""
    a = np.radians(np.linspace(-90.0, 90.0, rings + 1))
    r = radius * np.cos(a) ** 0.7 * (1.0 + waist * np.sin(a)) / (1.0 + waist)
    r[[0, -1]] = 0.0
    return turn(lathe(np.stack((r, 0.5 * length * np.sin(a)), axis=1), segments), -90.0, "z") + (0.0, radius, 0.0)


def pumpkin(radius, segments):
    a = np.radians(np.linspace(-90.0, 90.0, 15))
    line = np.stack((radius * np.cos(a), 0.72 * radius * np.sin(a) - 0.16 * radius * np.sin(a) ** 8), axis=1)
    line[[0, -1], 0] = 0.0
    return lathe(line, segments, 11, 0.13) + (0.0, 0.58 * radius, 0.0)


def build():
    b = Builder("vegetables", ambient_light=0.16)
    b.paint("table", patterns.weave((0.62, 0.58, 0.50), (0.72, 0.68, 0.60), 32))
    b.paint("board", patterns.wood((0.74, 0.56, 0.36), (0.54, 0.36, 0.20)), shine=0.1)
    b.varnish("bowl", colour=(0.16, 0.28, 0.46), shine=0.4, sharpness=64.0)
    hues = {
        "pumpkin": (0.80, 0.36, 0.06), "tomato": (0.70, 0.08, 0.04), "aubergine": (0.13, 0.04, 0.14), "leaf": (0.16, 0.38, 0.08),
        "cucumber": (0.12, 0.30, 0.08), "carrot": (0.82, 0.34, 0.05), "onion": (0.68, 0.46, 0.22), "lemon": (0.84, 0.68, 0.08),
        "pepper": (0.76, 0.52, 0.04), "stalk": (0.30, 0.34, 0.14),
    }  # fmt: skip
    for name, colour in hues.items():
        b.paint(name, colour=colour, shine=0.35 if name in ("tomato", "aubergine", "pepper") else 0.15, sharpness=48.0)

    b.add(quad((-3, 0, -3), (-3, 0, 3), (3, 0, 3), (3, 0, -3)), "table", uv=plane_map((1, 0, 0), (0, 0, 1), 0.6))
    b.add(
        turn(rounded_box((1.9, 0.06, 1.05), 0.02, 3), 6.0) + (0.0, 0.031, 0.1), "board", 50.0, uv=box_map(0.9, along=0)
    )
    top = 0.0625

    def stalk(at, length, lean=0.25, r=0.022):
        t = np.linspace(0.0, 1.0, 4)[:, None]
        b.add(tube(np.asarray(at) + t * (0.0, length, 0.0) + t**2 * (lean * length, 0.0, 0.0), r, 7), "stalk", 60.0)

    b.add(pumpkin(0.42, 44), "pumpkin", 70.0, at=(-0.62, 0.003, -0.72))
    stalk((-0.62, 0.40, -0.72), 0.18, 0.5, 0.03)
    for x, z, r in ((0.62, 0.42, 0.13), (0.42, 0.56, 0.12), (0.78, 0.16, 0.12)):
        b.add(furniture.fruit(r, 18), "tomato", 70.0, at=(x, top, z))
        stalk((x, top + 1.45 * r, z), 0.06, 0.3, 0.010)
    b.add(turn(oval(0.78, 0.15, 12, 18, 0.35), 24.0) + (0.06, top, -0.18), "aubergine", 70.0)
    b.add(turn(oval(0.86, 0.085, 12, 16), -16.0) + (-0.34, top, 0.22), "cucumber", 70.0)
    for x, z, yaw in ((-0.42, 0.44, 8.0), (-0.36, 0.54, -4.0), (-0.46, 0.62, 5.0)):
        root = [(0.0, -0.30), (0.012, -0.28), (0.034, 0.0), (0.052, 0.24), (0.044, 0.285), (0.0, 0.29)]
        b.add(turn(turn(lathe(curve(root, 2), 14), 90.0, "z"), yaw) + (x, top + 0.05, z), "carrot", 60.0)
        for k in range(3):
            t = np.linspace(0.0, 1.0, 5)[:, None]
            line = t * (-0.20 - 0.03 * k, 0.05 * k, 0.05 * (k - 1)) + (-0.285, 0.0, 0.0)
            b.add(turn(tube(line, 0.007, 5), yaw) + (x, top + 0.05, z), "leaf", 60.0)
    for x, z, yaw, name in ((0.72, -0.28, 30.0, "pepper"), (0.30, 0.24, 0.0, "onion"), (0.14, 0.46, 40.0, "onion")):
        line = {
            "pepper": [(0.0, 0.012), (0.05, 0.0), (0.10, 0.06), (0.13, 0.20), (0.10, 0.27), (0.04, 0.265), (0.0, 0.25)],
            "onion": [
                (0.0, 0.0),
                (0.06, 0.01),
                (0.115, 0.09),
                (0.07, 0.165),
                (0.022, 0.20),
                (0.014, 0.26),
                (0.0, 0.262),
            ],
        }[name]
        flutes = dict(flutes=4, depth=0.12) if name == "pepper" else {}
        b.add(lathe(curve(line, 2), 20, **flutes), name, 70.0, at=(x, top, z), yaw=yaw)
    stalk((0.72, top + 0.245, -0.28), 0.10, 0.3, 0.016)
    bowl = curve(
        [(0.16, 0.0), (0.20, 0.02), (0.36, 0.16), (0.42, 0.26), (0.40, 0.26), (0.33, 0.16), (0.18, 0.05), (0.0, 0.04)],
        2,
    )
    b.add(lathe(np.concatenate(([(0.0, 0.0)], bowl)), 28), "bowl", 60.0, at=(0.75, 0.002, -0.86))
    for i, (x, y, z) in enumerate(((-0.15, 0.06, 0.08), (0.15, 0.07, 0.06), (0.0, 0.08, -0.16), (0.02, 0.24, 0.02))):
        body = turn(oval(0.30, 0.10, 10, 14), 70.0 * i + 20.0)
        b.add(body, "lemon", 70.0, at=(0.75 + x, 0.002 + y, -0.86 + z))
    lights = [Light((-1.8, 2.6, 1.6), (0.90, 0.84, 0.72)), Light((2.6, 2.0, 1.8), (0.28, 0.32, 0.40))]
    return b.scene(Camera((0.15, 1.25, 2.25), (0.05, 0.12, -0.20), fov=42.0), lights, depth=4)
