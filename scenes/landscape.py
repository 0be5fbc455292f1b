# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Hills round a lake that mirrors them: a height field, water, some fir trees, a low sun."""

import numpy as np

from raycore.scene import Camera, Light
from raycore.shapes import Builder, lathe, noise, quad, sheet

LEVEL = 0.0  # of the water


def height(x, z):
    """Hills that fall to a basin in the middle and rise at the back."""
    p = np.stack((x, 0.0 * x, z), axis=-1).reshape(-1, 3)
    hills = noise(p, seed=8, octaves=5, scale=0.32, gain=0.48).reshape(np.shape(x))
    basin = 1.0 - np.exp(-((x + 0.6) ** 2 / 9.0 + (z + 0.5) ** 2 / 14.0))
    return 1.05 * hills * (0.25 + 0.75 * basin) - 0.55 + 0.95 * basin + 1.5 * np.clip((-z - 4.5) / 6.0, 0.0, 1.0) ** 1.4


def build():
    b = Builder("landscape", ambient_light=0.28)
    b.paint("grass", colour=(0.30, 0.40, 0.14))
    b.paint("rock", colour=(0.48, 0.43, 0.38))
    b.paint("sand", colour=(0.66, 0.56, 0.38))
    b.paint("snow", colour=(0.90, 0.91, 0.94))
    b.paint("needles", colour=(0.07, 0.20, 0.10))
    b.metal("water", (0.62, 0.74, 0.80), 0.72, 0.06, 256.0)

    cells = 70
    grid = np.linspace(-10.0, 10.0, cells + 1)
    x, z = np.meshgrid(grid, grid, indexing="ij")
    ground = sheet(np.stack((x, height(x, z), z), axis=2))[:, ::-1]
    normal = np.cross(ground[:, 1] - ground[:, 0], ground[:, 2] - ground[:, 0])
    steep = normal[:, 1] / np.linalg.norm(normal, axis=1)
    middle = ground[..., 1].mean(axis=1)
    kind = np.where(middle < LEVEL + 0.10, 2, np.where(middle > 1.75, 3, np.where(steep < 0.80, 1, 0)))
    for i, name in enumerate(("grass", "rock", "sand", "snow")):
        b.add(ground[kind == i], name, 60.0)
    b.add(quad((-10, LEVEL, -10), (-10, LEVEL, 10), (10, LEVEL, 10), (10, LEVEL, -10)), "water")

    rng = np.random.default_rng(5)
    tiers = [(0.0, 0.0), (0.20, 0.10), (0.08, 0.34), (0.15, 0.34), (0.05, 0.58), (0.10, 0.58), (0.0, 0.92)]
    planted = 0
    while planted < 26:
        x, z = rng.uniform(-8.0, 8.0), rng.uniform(-8.0, 5.0)
        y = float(height(np.array([x]), np.array([z]))[0])
        if 0.22 < y < 1.3 and not (abs(x - 1.0) < 1.6 and z > 2.0):
            size = rng.uniform(0.7, 1.3)
            b.add(lathe(np.array(tiers) * size, 8), "needles", 30.0, at=(x, y - 0.05, z), yaw=rng.uniform(0.0, 45.0))
            planted += 1
    lights = [
        Light((-0.75, 0.52, 0.30), (1.05, 0.92, 0.72), directional=True),
        Light((6.0, 9.0, 9.0), (0.14, 0.18, 0.26)),
    ]
    return b.scene(
        Camera((1.6, 1.75, 8.6), (-0.6, 0.25, -1.0), fov=44.0), lights, background=(0.36, 0.55, 0.80), depth=4
    )
