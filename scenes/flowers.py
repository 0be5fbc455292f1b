# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Flowers that branch like a fractal: each stem ends in a blossom and in three smaller stems."""

import math

import numpy as np

from raycore.scene import Camera, Light
from raycore.shapes import Builder, lathe, sheet, sphere, tube, turn


def petal(length, width, lift, cells=(3, 2)):
    """From the origin along +z, bent upwards like a spoon."""
    t, s = np.meshgrid(np.linspace(0.0, 1.0, cells[0] + 1), np.linspace(-1.0, 1.0, cells[1] + 1), indexing="ij")
    wide = width * np.sqrt(np.clip(t, 0.0, 1.0)) * np.sqrt(np.clip(1.06 - t**3, 0.0, 1.0))
    points = np.stack((s * wide, lift * length * t**1.6 + 0.35 * width * s * s * t, length * t), axis=2)
    return sheet(points)


def blossom(size, petals, seed):
    """{"petals": ..., "heart": ...} round the y axis."""
    rng = np.random.default_rng(seed)
    out = []
    for ring, (lift, count, scale) in enumerate(((0.20, petals, 1.0), (0.75, petals - 2, 0.72))):
        for i in range(count):
            yaw = 360.0 * (i + 0.5 * ring) / count + rng.uniform(-5.0, 5.0)
            out.append(turn(petal(size * scale, 0.30 * size * scale, lift + rng.uniform(-0.06, 0.06)), yaw))
    return {"petals": np.concatenate(out), "heart": sphere((0.0, 0.06 * size, 0.0), 0.19 * size, 8)}


def build():
    b = Builder("flowers", ambient_light=0.20)
    b.paint("earth", colour=(0.34, 0.25, 0.17))
    b.paint("stem", colour=(0.18, 0.36, 0.10))
    b.paint("heart", colour=(0.85, 0.62, 0.08))
    hues = ((0.80, 0.16, 0.30), (0.86, 0.50, 0.12), (0.62, 0.22, 0.62), (0.88, 0.80, 0.84))
    kinds = [b.paint(f"petals {i}", colour=c, shine=0.1) for i, c in enumerate(hues)]
    rng = np.random.default_rng(12)
    parts = {}

    def keep(material, triangles):
        parts.setdefault(material, []).append(triangles)

    def frame(direction):
        """Rows: two directions across, so that y becomes `direction`."""
        y = direction / np.linalg.norm(direction)
        x = np.cross(y, (0.31, 0.1, 0.95))
        x /= np.linalg.norm(x)
        return np.stack((x, y, np.cross(x, y)))

    def grow(at, direction, length, level, kind):
        bend = direction + (0.0, 0.25, 0.0)
        t = np.linspace(0.0, 1.0, 5)[:, None]
        line = at + length * (t * direction + 0.5 * t**2 * (bend - direction))
        keep("stem", tube(line, 0.016 * length + 0.003, 6))
        tip, ahead = line[-1], bend / np.linalg.norm(bend)
        size = 0.30 * length + 0.03
        flower = blossom(size, 8, level * 97 + len(parts["stem"]))
        axes = frame(ahead)
        keep(kind, flower["petals"] @ axes + tip)
        keep("heart", flower["heart"] @ axes + tip)
        if level == 0:
            return
        for i in range(3):
            a = 2.0 * math.pi * (i / 3.0 + rng.uniform(-0.07, 0.07)) + level
            where = line[1 + i]
            out = math.cos(a) * axes[0] + math.sin(a) * axes[2] + 0.75 * ahead
            grow(where, out / np.linalg.norm(out), 0.56 * length, level - 1, kind)

    for i, (x, z, length) in enumerate(((-0.95, -0.35, 1.15), (0.05, 0.15, 1.3), (1.0, -0.3, 1.1), (0.2, -1.1, 1.35))):
        grow(
            np.array([x, 0.0, z]),
            np.array([0.10 * math.sin(3.0 * i), 1.0, 0.10 * math.cos(3.0 * i)]),
            length,
            3,
            kinds[i],
        )
    for material, triangles in parts.items():
        b.add(np.concatenate(triangles), material, 65.0)
    ground = [(7.0, -0.35), (3.0, -0.06), (1.2, 0.01), (0.0, 0.02)]
    b.add(lathe(ground, 48), "earth", 60.0)
    lights = [Light((2.5, 4.5, 3.5), (0.90, 0.84, 0.74)), Light((-4.0, 2.5, 2.5), (0.28, 0.32, 0.42))]
    return b.scene(
        Camera((0.3, 1.55, 3.6), (0.05, 0.92, -0.2), fov=42.0), lights, background=(0.42, 0.58, 0.72), depth=0
    )
