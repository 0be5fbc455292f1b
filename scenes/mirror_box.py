# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A closed box of mirrors with a glass sphere, a few things and four lights in it: paths end only by depth or weight."""

from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, sides, sphere, torus, turn


def build():
    b = Builder("mirror_box")
    tints = {"warm": (1.0, 0.94, 0.86), "grey": (1.0, 1.0, 1.0), "cool": (0.86, 0.94, 1.0)}
    walls = [b.metal(f"{name} wall", colour, 0.94, 0.03, 256.0) for name, colour in tints.items()]
    b.glass("glass", (0.97, 0.97, 0.97), sharpness=512.0)
    b.paint("red", colour=(0.65, 0.12, 0.08), shine=0.3, sharpness=64.0)
    b.metal("gold", (0.95, 0.74, 0.34), 0.55, 0.25, 64.0)
    b.paint("blue", colour=(0.12, 0.25, 0.60), shine=0.2)
    b.glow("lamp", (1.0, 0.97, 0.90))

    for i, wall in enumerate(sides((-2.0, 0.0, -2.0), (2.0, 3.0, 2.0)).values()):
        b.add(wall, walls[i // 2])
    b.add(sphere((0.0, 1.25, 0.0), 0.75, 96), "glass")
    b.add(turn(box((-0.3, 0.02, -0.3), (0.3, 0.62, 0.3)), 25.0) + (-1.2, 0.0, 0.2), "red")
    b.add(torus((0.0, 0.15, 0.0), 0.42, 0.13, 96, 32) + (0.9, 0.0, 0.8), "gold")
    b.add(sphere((0.95, 0.36, -0.85), 0.34, 64), "blue")
    lights = []
    for x, z in ((-1.3, -1.3), (1.3, -1.3), (-1.3, 1.3), (1.3, 1.3)):
        b.add(sphere((x, 2.62, z), 0.06, 24), "lamp")
        lights.append(Light((x, 2.50, z), (0.75, 0.72, 0.66), attenuation=(0.6, 0.1, 0.05)))
    return b.scene(Camera((0.35, 1.35, 1.9), (-0.05, 1.1, 0.0), fov=62.0), lights, background=(0.0, 0.0, 0.0), depth=15)
