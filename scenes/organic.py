# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A smooth organic mesh: a sphere of 82 K triangles that noise has pulled out of shape, on a plinth before a backdrop."""

import numpy as np

from raycore.scene import Camera, Light, make_material
from raycore.shapes import Builder, icosphere, lathe, noise, sheet


def creature():
    """The displaced sphere (n, 3, 3): soft knobs on a spiral, bent by noise, with shallow folds between them."""
    vertices, faces = icosphere(6)
    warp = np.stack([noise(vertices, seed=s, octaves=2, scale=1.2, gain=0.35) for s in (1, 2, 3)], axis=1)
    aim = vertices + 0.22 * warp
    aim /= np.linalg.norm(aim, axis=1, keepdims=True)
    knobs = 46
    n = np.arange(knobs)
    y, turn = 1.0 - 2.0 * (n + 0.5) / knobs, n * np.pi * (3.0 - 5.0**0.5)  # a spiral of equal areas
    axis = np.stack((np.sqrt(1.0 - y * y) * np.cos(turn), y, np.sqrt(1.0 - y * y) * np.sin(turn)), axis=1)
    height = 0.30 + 0.16 * np.sin(2.4 * n)
    bumps = np.exp(38.0 * (aim @ axis.T - 1.0)) @ height
    folds = np.sqrt(noise(aim, seed=4, octaves=1, scale=4.0) ** 2 + 0.01)
    radius = 0.74 + bumps - 0.06 * folds + 0.10 * warp[:, 0]
    return (vertices * radius[:, None])[faces]


def build():
    b = Builder("organic")
    skin = b.material(make_material("skin", (0.55, 0.20, 0.13), (0.35, 0.33, 0.30), 64.0))
    stone = b.material(make_material("stone", (0.36, 0.38, 0.40), (0.10, 0.10, 0.10), 16.0))
    paper = b.material(make_material("paper", (0.30, 0.42, 0.50)))

    body = creature()
    body[..., 1] -= body[..., 1].min() - 0.31
    b.add(body, skin, crease=80.0)

    arc = np.radians(np.linspace(0.0, 90.0, 9))
    rim = np.stack((1.22 + 0.06 * np.cos(arc), 0.26 + 0.06 * np.sin(arc)), axis=1)
    b.add(lathe([(1.40, 0.0), (1.40, 0.05), (1.34, 0.10), (1.28, 0.12), *rim, (0.0, 0.32)], 128), stone)

    # Floor and wall in one sheet, joined by a quarter circle.
    bend = np.radians(np.linspace(0.0, 90.0, 25))
    line = [(6.0, 0.0), *zip(-2.0 - 2.0 * np.sin(bend), 2.0 - 2.0 * np.cos(bend)), (-4.0, 9.0)]
    points = np.array([[(x, y, z) for z, y in line] for x in np.linspace(-9.0, 9.0, 13)])
    b.add(sheet(points)[:, ::-1], paper, crease=30.0)

    lights = [Light((3.5, 5.5, 4.0), (0.95, 0.92, 0.85)), Light((-4.5, 2.5, 3.0), (0.22, 0.28, 0.38))]
    return b.scene(Camera((1.15, 1.95, 3.75), (0.0, 1.17, 0.0), fov=44.0), lights)
