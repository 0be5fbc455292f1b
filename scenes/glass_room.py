# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A small room of few triangles: coloured panes, a crystal on a table, a mirror ball, light from two sides."""

from raycore import patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, icosphere, plane_map, quad, sides, turn


def build():
    b = Builder("glass_room", ambient_light=0.18)
    b.varnish("floor", patterns.checker((0.88, 0.86, 0.80), (0.32, 0.36, 0.42), 8, 64), shine=0.2)
    b.paint("wall", colour=(0.66, 0.70, 0.68))
    b.paint("side wall", colour=(0.72, 0.52, 0.36))
    b.paint("wood", colour=(0.46, 0.28, 0.15), shine=0.2)
    b.metal("chrome", (0.95, 0.96, 0.98), 0.85, 0.05)
    b.glass("crystal", (0.95, 0.98, 0.97))
    tints = {
        "amber": (0.97, 0.72, 0.25),
        "rose": (0.95, 0.38, 0.45),
        "sea": (0.30, 0.75, 0.80),
        "lime": (0.62, 0.88, 0.32),
    }
    for name, colour in tints.items():
        b.glass(name, colour)

    room = sides((-2.2, 0.0, -2.0), (2.2, 2.6, 2.0))
    b.add(room["floor"], "floor", uv=plane_map((1, 0, 0), (0, 0, 1), 4.0))
    for name in ("back", "ceiling", "front"):
        b.add(room[name], "wall")
    for name in ("left", "right"):
        b.add(room[name], "side wall")

    b.add(box((-0.75, 0.70, -0.55), (0.75, 0.76, 0.35)), "wood")
    for x in (-0.66, 0.60):
        for z in (-0.48, 0.22):
            b.add(box((x, -0.01, z), (x + 0.06, 0.699, z + 0.06)), "wood")
    vertices, faces = icosphere(2)
    b.add((0.34 * vertices)[faces] + (-0.28, 1.105, -0.05), "crystal", 60.0)
    vertices, faces = icosphere(1)
    b.add(turn((0.20 * vertices)[faces], 20.0) + (0.40, 0.957, 0.0), "chrome", 60.0)
    for i, name in enumerate(tints):  # a folding screen in the back
        pane = turn(box((-0.36, 0.06, -0.015), (0.36, 1.9, 0.015)), 28.0 if i % 2 else -28.0)
        b.add(pane, name, at=(-1.14 + 0.76 * i, 0.0, -1.25))
    for i in range(5):  # its posts
        x, z = -1.52 + 0.76 * i, -1.25 - (0.19 if i % 2 else -0.19)
        b.add(box((x - 0.022, -0.01, z - 0.022), (x + 0.022, 2.0, z + 0.022)), "wood")
    b.add(quad((2.19, 0.5, 0.9), (2.19, 0.5, -0.9), (2.19, 2.1, -0.9), (2.19, 2.1, 0.9)), "chrome")
    lights = [Light((-1.4, 2.35, -1.85), (0.75, 0.70, 0.60)), Light((1.5, 2.3, 1.5), (0.70, 0.68, 0.66))]
    return b.scene(Camera((-0.75, 1.75, 1.9), (0.08, 0.95, -0.4), fov=58.0), lights, depth=8)
