# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Tea for one: a cup on its saucer with a spoon, a pot, sugar, a lemon slice's plate, on a checked cloth."""

import numpy as np

from raycore import furniture, patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, curve, lathe, plane_map, sheet, tube, turn


def saucer(radius, segments):
    line = [(0.5, 0.0), (0.54, 0.02), (0.8, 0.09), (1.0, 0.20), (0.985, 0.215), (0.8, 0.12), (0.52, 0.06), (0.0, 0.055)]
    return lathe(np.concatenate(([(0.0, 0.0)], curve(line, 3))) * radius, segments)


def spoon(length):
    """Along x, the bowl at the origin."""
    t = np.linspace(0.0, 1.0, 14)
    stem = np.stack((0.028 + length * t, 0.004 + 0.010 * np.sin(np.pi * t) - 0.002 * t, 0.0 * t), axis=1)
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 20, endpoint=False), np.linspace(0.0, 1.0, 6), indexing="ij")
    bowl = np.stack((0.032 * v * np.cos(u), 0.007 * v**2 - 0.003, 0.020 * v * np.sin(u)), axis=2)
    return np.concatenate(
        (tube(stem, 0.0024, 8), sheet(bowl, close_u=True)[:, ::-1], sheet(bowl, close_u=True) + (0, 8e-4, 0))
    )


def build():
    b = Builder("cup", ambient_light=0.18)
    cloth = patterns.checker((0.92, 0.90, 0.86), (0.70, 0.22, 0.20), 8, 128)
    b.paint("cloth", cloth)
    b.varnish("china", colour=(0.82, 0.83, 0.82), shine=0.5, sharpness=128.0)
    b.varnish("blue china", colour=(0.10, 0.20, 0.45), shine=0.5, sharpness=128.0)
    b.varnish("tea", colour=(0.30, 0.11, 0.03), shine=0.4, sharpness=256.0)
    b.metal("silver", (0.93, 0.93, 0.90), 0.75, 0.08)
    b.paint("sugar", colour=(0.88, 0.87, 0.84))
    b.varnish("lemon", colour=(0.84, 0.68, 0.10), shine=0.3)

    x, z = np.meshgrid(np.linspace(-1.0, 1.0, 29), np.linspace(-1.0, 1.0, 29), indexing="ij")
    folds = 0.0022 * (np.sin(9.0 * x + 2.0 * z) * np.sin(5.0 * z - 3.0 * x) - 1.2)
    b.add(sheet(np.stack((x, folds, z), axis=2))[:, ::-1], "cloth", 80.0, plane_map((1, 0, 0), (0, 0, 1), 0.35))

    b.add(saucer(0.088, 36), "china", 60.0, at=(0.06, 0.001, 0.10))
    cup = [
        (0.026, 0.0),
        (0.029, 0.004),
        (0.040, 0.022),
        (0.047, 0.052),
        (0.050, 0.062),
        (0.048, 0.0625),
        (0.044, 0.050),
    ]
    cup = np.concatenate((cup, [(0.036, 0.022), (0.020, 0.011), (0.0, 0.010)]))
    b.add(lathe(np.concatenate(([(0.0, 0.0)], curve(cup, 3))), 44), "blue china", 60.0, at=(0.06, 0.0066, 0.10))
    a = np.radians(np.linspace(-78.0, 78.0, 17))
    ear = np.stack((0.041 + 0.024 * np.cos(a), 0.035 + 0.019 * np.sin(a), 0.0 * a), axis=1)
    b.add(turn(tube(ear, 0.0034, 10), 35.0), "blue china", 60.0, at=(0.06, 0.0066, 0.10))
    b.add(lathe([(0.0455, 0.054), (0.0, 0.0541)], 44), "tea", 60.0, at=(0.06, 0.0066, 0.10))
    b.add(turn(spoon(0.105), 28.0) + (0.02, 0.024, 0.172), "silver", 60.0)

    b.add(furniture.teapot(34) * 1.15, "china", 60.0, at=(-0.20, 0.001, -0.14), yaw=-20.0)
    b.add(saucer(0.066, 28), "china", 60.0, at=(0.28, 0.001, -0.10))
    for i, yaw in enumerate((10.0, 50.0, 85.0, 30.0)):
        at = ((0.26, 0.012, -0.115), (0.295, 0.012, -0.085), (0.30, 0.012, -0.125), (0.283, 0.0285, -0.107))[i]
        b.add(turn(box((-0.008, -0.008, -0.008), (0.008, 0.008, 0.008)), yaw), "sugar", at=np.add(at, (0, 0.003, 0)))
    b.add(furniture.fruit(0.034, 28) * (1.0, 0.9, 1.25), "lemon", 70.0, at=(-0.05, 0.001, 0.17), yaw=35.0)
    lights = [Light((-0.6, 0.9, 0.5), (0.92, 0.86, 0.76)), Light((0.9, 0.6, 0.6), (0.30, 0.34, 0.42))]
    return b.scene(Camera((0.20, 0.30, 0.56), (0.01, 0.035, 0.0), fov=42.0), lights, depth=5)
