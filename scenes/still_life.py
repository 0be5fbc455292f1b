# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A still life: spheres and boxes, a vase, a bowl and a ring on a table before a wall."""

import numpy as np

from raycore.scene import Camera, Light, make_material
from raycore.shapes import Builder, box, curve, lathe, rounded_box, sheet, sphere, torus, turn


def build():
    b = Builder("still_life")

    def paint(name, colour, shine=0.0, sharpness=32.0):
        return b.material(make_material(name, colour, (shine, shine, shine), sharpness))

    wood = [
        paint(f"wood {i}", c, 0.12, 32.0)
        for i, c in enumerate(((0.36, 0.20, 0.10), (0.32, 0.17, 0.08), (0.40, 0.23, 0.12)))
    ]
    wall = paint("wall", (0.46, 0.50, 0.46))
    cloth = paint("cloth", (0.72, 0.69, 0.62))
    glaze = paint("glaze", (0.07, 0.22, 0.36), 0.6, 128.0)
    clay = paint("clay", (0.55, 0.26, 0.14), 0.1, 16.0)
    lemon = paint("lemon", (0.80, 0.60, 0.06), 0.25, 32.0)
    apple = paint("apple", (0.55, 0.05, 0.04), 0.5, 64.0)
    plum = paint("plum", (0.16, 0.06, 0.20), 0.35, 32.0)
    pearl = paint("pearl", (0.75, 0.73, 0.70), 0.5, 128.0)
    teal = paint("teal", (0.08, 0.38, 0.36), 0.2, 32.0)
    brass = b.material(make_material("brass", (0.50, 0.34, 0.10), (0.75, 0.58, 0.28), 64.0))
    ivory = paint("ivory", (0.68, 0.62, 0.48), 0.2, 32.0)

    for i in range(9):  # table boards
        z = -1.6 + 0.4 * i
        b.add(
            rounded_box((6.4, 0.16, 0.392), 0.015, 2) + (0.0, -0.08, z + 0.2),
            wood[(5 * i + i * i) % 3],
            crease=50.0,
        )
    b.add(box((-3.2, -0.6, -1.55), (3.2, -0.18, -1.45)), wood[1])
    b.add(sheet([[(-7, -3, -2.4), (-7, 6, -2.4)], [(7, -3, -2.4), (7, 6, -2.4)]]), wall)

    # A runner across the table, with folds that hang over its front edge.
    x, z = np.linspace(-0.2, 1.9, 64), np.linspace(-1.5, 2.04, 72)
    gx, gz = np.meshgrid(x, z, indexing="ij")
    fold = 0.012 * (1.0 + np.sin(9.0 * gx + 1.3 * np.sin(2.0 * gz)) * np.sin(2.3 * gz + 0.7))
    hang = np.stack((gx + 0.25 * gz, fold + 0.002, gz), axis=2)
    down = np.linspace(0.0, 1.0, 24)
    sway = 2.04 + 0.10 * np.sin(7.0 * gx[:, -1:] + 0.6) * down
    below = np.stack((np.broadcast_to(hang[:, -1:, 0], sway.shape), np.broadcast_to(-down, sway.shape), sway), axis=2)
    below[:, 0] = hang[:, -1]
    b.add(sheet(np.concatenate((hang, below[:, 1:]), axis=1))[:, ::-1], cloth, crease=70.0)

    vase = curve(
        [
            (0.0, 0.0),
            (0.30, 0.0),
            (0.33, 0.05),
            (0.50, 0.45),
            (0.52, 0.75),
            (0.34, 1.20),
            (0.17, 1.50),
            (0.16, 1.70),
            (0.25, 1.86),
        ]
    )
    inside = [(0.22, 1.85), (0.13, 1.69), (0.13, 1.50), (0.10, 1.30), (0.0, 1.25)]
    b.add(lathe(np.concatenate((vase, curve(inside))), 96) + (-1.25, 0.0, -0.45), glaze, crease=60.0)

    bowl = curve([(0.0, 0.03), (0.28, 0.0), (0.34, 0.05), (0.62, 0.20), (0.80, 0.44), (0.84, 0.52)])
    hollow = curve([(0.80, 0.52), (0.75, 0.44), (0.56, 0.24), (0.28, 0.12), (0.0, 0.10)])
    b.add(lathe(np.concatenate((bowl, hollow)), 96) + (0.95, 0.03, -0.15), clay, crease=60.0)
    for at, r, m in (
        ((0.70, 0.46, -0.30), 0.28, apple),
        ((1.18, 0.44, -0.36), 0.26, lemon),
        ((1.05, 0.42, 0.17), 0.25, plum),
        ((0.92, 0.76, -0.14), 0.26, apple),
    ):
        b.add(sphere((at[0], at[1] + 0.03, at[2]), r, 64), m)

    b.add(turn(rounded_box((0.95, 0.42, 0.70), 0.04), 18.0) + (-0.35, 0.21, -0.75), teal, crease=60.0)
    b.add(turn(rounded_box((0.62, 0.34, 0.50), 0.04), -24.0) + (-0.32, 0.59, -0.72), ivory, crease=60.0)
    b.add(turn(rounded_box((0.36, 0.36, 0.36), 0.03), 40.0) + (-0.78, 0.18, 0.92), apple, crease=60.0)
    b.add(sphere((-0.30, 0.30, 0.55), 0.30, 80), pearl)
    b.add(sphere((-0.30, 0.93, -0.72), 0.17, 56), brass)
    b.add(sphere((0.30, 0.16, 1.05), 0.13, 48), lemon)
    b.add(sphere((-1.62, 0.20, 0.55), 0.20, 56), plum)
    b.add(torus((0.0, 0.0, 0.0), 0.26, 0.075, 96, 32) + (-1.15, 0.078, 1.10), brass)
    b.add(sphere((-1.15, 0.145, 1.10), 0.145, 48), teal)

    lights = [Light((2.6, 3.6, 3.0), (0.95, 0.88, 0.76)), Light((-4.0, 2.6, 2.4), (0.25, 0.30, 0.38))]
    return b.scene(Camera((0.15, 1.75, 4.3), (-0.12, 0.52, 0.0), fov=39.0), lights)
