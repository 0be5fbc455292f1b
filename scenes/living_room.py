# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A living room after the paper's Figure 9: cloth and wood, plants with leaves cut out by alpha, a mirror, vases; lamp and sun.

The window is in the left wall, the sofa stands at the back wall. Metres, y up, the camera looks towards -z.
"""

import numpy as np

from raycore import furniture, patterns
from raycore.scene import Camera, Light
from raycore.shapes import (
    Builder,
    box_map,
    cylinder_map,
    lathe,
    opening,
    plane_map,
    rounded_box,
    sides,
    sphere,
    sphere_map,
    tube,
    turn,
)

LEFT, RIGHT, BACK, FRONT, TOP = -2.8, 2.8, -2.4, 2.8, 2.7
WINDOW = (-0.1, 1.45, 2.2, 1.7)  # middle z, y, and size, in the left wall


def palette(b):
    """The materials."""
    b.varnish("floor", patterns.parquet((0.88, 0.72, 0.52), (0.64, 0.45, 0.30), 8, 4, seed=8), shine=0.2)
    b.paint("plaster", patterns.plaster((0.90, 0.88, 0.80)), compact=True)
    b.paint("stone", patterns.tiles((0.84, 0.70, 0.60), (0.78, 0.64, 0.55), (0.88, 0.85, 0.80), 8), compact=True)
    b.paint("wood", patterns.wood((0.66, 0.47, 0.30), (0.42, 0.27, 0.16), seed=6), shine=0.15)
    b.paint("rug", patterns.rug((0.22, 0.34, 0.40), (0.55, 0.24, 0.18), (0.90, 0.84, 0.70)))
    b.paint("sofa", patterns.weave((0.84, 0.78, 0.66), (0.90, 0.86, 0.76), 32))
    b.paint("cushion", patterns.weave((0.72, 0.34, 0.20), (0.82, 0.52, 0.26), 16), compact=True)
    b.paint("stripes", patterns.wallpaper((0.92, 0.90, 0.84), (0.25, 0.42, 0.50), 8), compact=True)
    b.paint("curtain", patterns.weave((0.86, 0.70, 0.48), (0.92, 0.80, 0.62), 32), compact=True)
    b.paint("wicker", patterns.wood((0.74, 0.56, 0.34), (0.50, 0.34, 0.18), seed=12), compact=True)
    b.paint("picture", patterns.painting(seed=23))
    b.paint("globe", patterns.marble((0.30, 0.50, 0.66), (0.78, 0.72, 0.48), seed=31), shine=0.3, sharpness=64.0)
    cut = dict(shine=0.15, wrap="clamp", alpha_mode="mask")
    b.paint("leaves", patterns.leaf((0.52, 0.74, 0.30), (0.14, 0.42, 0.14)), **cut)
    b.paint("pale leaves", patterns.leaf((0.72, 0.80, 0.45), (0.28, 0.48, 0.24)), **cut)
    for i, c in enumerate(((0.52, 0.18, 0.14), (0.16, 0.30, 0.44), (0.22, 0.40, 0.26), (0.70, 0.58, 0.34))):
        b.paint(f"book {i}", patterns.text(c, (0.90, 0.82, 0.58), 4, 8, seed=i), compact=True, shine=0.1)
    b.paint("white", colour=(0.88, 0.88, 0.86))
    b.paint("stem", colour=(0.24, 0.40, 0.16))
    b.paint("earth", colour=(0.16, 0.11, 0.08))
    b.paint("clay", colour=(0.70, 0.38, 0.24), shine=0.1)
    b.paint("lacquer", colour=(0.10, 0.10, 0.12), shine=0.5, sharpness=128.0, reflect=(0.08,) * 3, fresnel=True)
    b.metal("mirror", (0.93, 0.95, 0.95), 0.92, 0.02)
    b.metal("brass", (0.92, 0.74, 0.42), 0.6)
    b.glass("glass", (0.97, 0.985, 0.98))
    b.glass("blue glass", (0.45, 0.70, 0.95))
    b.glass("amber glass", (0.95, 0.70, 0.30))
    b.glow("bulb", (1.0, 0.95, 0.82))


def shell(b):
    """Floor, ceiling, walls with the window, curtains, rug."""
    side = sides((LEFT, 0.0, BACK), (RIGHT, TOP, FRONT))
    b.add(side["floor"], "floor", uv=box_map(1.6))
    b.add(side["ceiling"], "white")
    for name, what in (("right", "stone"), ("back", "plaster"), ("front", "plaster")):
        b.add(side[name], what, uv=box_map(1.3))
    middle, y, wide, high = WINDOW
    x0, x1 = -middle - wide / 2, -middle + wide / 2  # seen from the room, -z is to the right
    wall, reveal = opening((-FRONT, 0.0), (-BACK, TOP), (x0, y - high / 2), (x1, y + high / 2), 0.2)
    b.add(wall, "plaster", uv=box_map(1.3), at=(LEFT, 0.0, 0.0), yaw=90.0)
    b.add(reveal, "white", 0.0, at=(LEFT, 0.0, 0.0), yaw=90.0)
    panes = furniture.window(wide - 0.002, high - 0.002, (3, 2))
    for part, material in (("frame", "white"), ("glass", "glass")):
        b.add(panes[part], material, 0.0, at=(LEFT - 0.15, y, middle), yaw=90.0)
    ends = [(LEFT + 0.1, 2.5, middle + s * (wide / 2 + 0.45)) for s in (-1, 1)]
    b.add(tube(np.array(ends), 0.016, 24), "brass", 60.0)
    for s, end in zip((-1, 1), ends):
        cloth, uv = furniture.curtain(0.62, 2.42, 6, 160, 30)
        b.add(cloth, "curtain", 60.0, uv=uv / 0.4, at=(LEFT + 0.1, 0.05, middle + s * (wide / 2 + 0.22)), yaw=90.0)
        b.add(sphere((0.0, 0.0, 0.0), 0.035, 32), "brass", at=end)
    rug = rounded_box((2.5, 0.016, 1.7), 0.007, 3)
    b.add(rug, "rug", 50.0, uv=plane_map((0, 0, 1), (1, 0, 0), (1.7, 2.5), (-1.25, 0, -0.85)), at=(0.0, 0.007, 0.1))


def seats(b):
    """Sofa, armchair, cushions."""
    for width, seats_, at, yaw in ((2.1, 3, (-0.35, 0.0, -1.85), 0.0), (0.75, 1, (1.95, 0.0, 0.15), -72.0)):
        sofa = furniture.sofa(width, seats_, 10)
        b.add(sofa["cloth"], "sofa", 60.0, uv=box_map(0.25), at=at, yaw=yaw)
        b.add(sofa["feet"], "wood", 40.0, at=(at[0], -0.002, at[2]), yaw=yaw)
    for x, lean, name in ((-1.12, 18.0, "cushion"), (-0.78, -12.0, "stripes"), (0.38, -20.0, "cushion")):
        pad = turn(turn(furniture.cushion((0.40, 0.40, 0.14), 14, 0.7), -24.0, "x"), lean)
        b.add(pad, name, 60.0, uv=box_map(0.3), at=(x, 0.74, -1.62))


def coffee_table(b):
    """Before the sofa: glass on a lacquered table, with vases, glasses, books and fruit."""
    x, z, top = -0.15, -0.30, 0.44
    b.add(rounded_box((1.15, 0.05, 0.62), 0.02, 8), "lacquer", 50.0, at=(x, top - 0.025, z))
    b.add(rounded_box((1.00, 0.03, 0.50), 0.012, 6), "wood", 50.0, uv=box_map(0.7, along=0), at=(x, 0.16, z))
    for i in (-1, 1):
        for j in (-1, 1):
            b.add(
                lathe([(0.0, 0.0), (0.022, 0.002), (0.030, top - 0.03), (0.0, top - 0.03)], 32),
                "wood",
                40.0,
                at=(x + 0.50 * i, 0.013, z + 0.24 * j),
            )
    gap = top + 0.001
    b.add(furniture.vessel("vase", 128, 8), "blue glass", 60.0, at=(x - 0.36, gap, z - 0.10))
    b.add(furniture.vessel("vase", 128, 8) * (1.0, 0.62, 1.0), "amber glass", 60.0, at=(x - 0.16, gap, z + 0.14))
    b.add(furniture.vessel("bowl", 128, 8) * 1.2, "glass", 60.0, at=(x + 0.14, gap, z - 0.04))
    for i, (dx, dy, dz) in enumerate(((-0.055, 0.050, 0.02), (0.042, 0.050, 0.042), (0.015, 0.050, -0.055))):
        b.add(furniture.fruit(0.045, 56), "clay", 60.0, at=(x + 0.14 + dx, gap + dy, z - 0.04 + dz), yaw=70.0 * i)
    for dx, dz in ((0.38, 0.18), (0.46, 0.06)):
        b.add(furniture.vessel("wine", 96, 8), "glass", 70.0, at=(x + dx, gap, z + dz))
    for i in range(3):
        book = rounded_box((0.26 - 0.02 * i, 0.03, 0.19), 0.004, 3)
        b.add(
            book,
            f"book {i}",
            50.0,
            uv=box_map(0.2),
            at=(x + 0.44, top + 0.0155 + 0.031 * i, z - 0.19),
            yaw=12.0 * i - 8.0,
        )
    # Stems in the tall vase.
    rng = np.random.default_rng(5)
    for i in range(9):
        tilt = np.array([np.cos(0.7 * i), 0.0, np.sin(0.7 * i)]) * 0.085
        stem = np.array(
            [
                (0.0, 0.03, 0.0),
                0.1 * tilt + (0.0, 0.2, 0.0),
                0.3 * tilt + (0, 0.33, 0),
                tilt + (0, 0.46 + 0.06 * rng.random(), 0),
            ]
        )
        b.add(tube(stem, 0.0025, 8), "stem", 60.0, at=(x - 0.36, gap, z - 0.10))
        tris, uv = furniture.leaf(0.13, 0.07, 0.5, (8, 4))
        b.add(
            turn(tris, 90.0 - np.degrees(0.7 * i)) + stem[-1],
            "pale leaves",
            60.0,
            uv=uv,
            at=(x - 0.36, gap, z - 0.10),
        )


def plants(b):
    """Pot plants at the window and beside the sofa."""
    for at, size, count, leaves, seed in (
        ((-2.25, 0.0, -1.85), 1.35, 90, "leaves", 1),
        ((-2.35, 0.0, 1.25), 0.85, 70, "pale leaves", 2),
        ((1.25, 0.0, -2.0), 1.10, 80, "leaves", 3),
    ):
        pot = furniture.vessel("planter", 96, 6)
        b.add(pot, "clay", 50.0, at=(at[0], -0.002, at[2]))
        b.add(lathe([(0.148, 0.27), (0.0, 0.285)], 64), "earth", 60.0, at=at)
        plant = furniture.plant(count, size, seed, (10, 4))
        b.add(plant["stems"], "stem", 80.0, at=(at[0], 0.27, at[2]))
        b.add(plant["leaves"][0], leaves, 60.0, uv=plant["leaves"][1], at=(at[0], 0.27, at[2]))


def walls(b):
    """Mirror and picture, shelf with books, floor lamp, globe, basket. Returns the place of the lamp."""
    mirror = furniture.framed(1.3, 0.9, 0.07)
    b.add(mirror["frame"], "brass", 30.0, at=(RIGHT - 0.035, 1.60, -0.20), yaw=-90.0)
    b.add(mirror["picture"][0], "mirror", 0.0, at=(RIGHT - 0.035, 1.60, -0.20), yaw=-90.0)
    for x, w in ((-0.75, 0.9), (0.35, 0.6)):
        picture = furniture.framed(w, 0.5)
        b.add(picture["frame"], "wood", 30.0, uv=box_map(0.5), at=(x, 1.65, BACK + 0.032))
        b.add(picture["picture"][0], "picture", 0.0, uv=picture["picture"][1], at=(x, 1.65, BACK + 0.032))
    case, boards = furniture.shelf(1.2, 2.1, 0.32, 6)
    b.add(case, "wood", 0.0, uv=box_map(0.8, along=0), at=(2.15, 0.0, BACK + 0.002))
    for i, y in enumerate(boards[:-1]):
        for book, n in furniture.books(1.12 if i % 2 else 0.7, 0.32, 0.24, seed=i + 7):
            colour = f"book {(n * n + 3 * i) % 4}"
            b.add(book + (-0.57, 0.0, 0.27), colour, 50.0, uv=box_map((0.3, 0.1), along=1), at=(2.15, y, BACK + 0.002))
        if i % 2 == 0:
            b.add(
                furniture.vessel("vase", 64, 6) * 0.75,
                "amber glass" if i else "glass",
                60.0,
                at=(2.5, y + 0.001, BACK + 0.17),
            )
    globe = (2.45, 1.99 + 0.222, BACK + 0.17)
    b.add(sphere((0.0, 0.0, 0.0), 0.14, 96), "globe", uv=sphere_map(repeats=2), at=globe)
    b.add(
        lathe([(0.0, 0.0), (0.08, 0.0), (0.07, 0.015), (0.015, 0.03), (0.015, 0.085), (0.0, 0.085)], 48),
        "brass",
        40.0,
        at=(globe[0], 1.99 - 0.0095 + 0.001, globe[2]),
    )

    basket = [(0.20 + 0.05 * np.sin(2.2 * t), 0.02 + 0.30 * t) for t in np.linspace(0.0, 1.0, 16)]
    spokes = 36
    for i, (r, y) in enumerate(basket):
        a = np.linspace(0.0, 2.0 * np.pi, 109)[:-1]
        wave = r + 0.008 * np.sin(spokes / 2 * a + np.pi * (i % 2))
        b.add(
            tube(np.stack((wave * np.cos(a), y + 0.0 * a, wave * np.sin(a)), axis=1), 0.009, 8, close=True),
            "wicker",
            80.0,
            uv=box_map(0.3),
            at=(1.55, 0.0, 1.45),
        )
    for a in np.arange(spokes) * 2.0 * np.pi / spokes:
        b.add(
            tube(np.array([(r * np.cos(a), y, r * np.sin(a)) for r, y in basket]), 0.006, 8),
            "wicker",
            80.0,
            uv=box_map(0.3),
            at=(1.55, 0.0, 1.45),
        )
    b.add(sphere((0.0, 0.0, 0.0), 0.20, 64), "cushion", uv=sphere_map(repeats=6), at=(1.55, 0.27, 1.45))

    x, y, z = lamp = (0.98, 1.62, -1.55)
    foot = [(0.0, -0.002), (0.15, 0.0), (0.14, 0.02), (0.014, 0.035), (0.012, y - 0.08), (0.0, y - 0.07)]
    b.add(lathe(foot, 64), "brass", 40.0, at=(x, 0.0, z))
    shade = furniture.lampshade(0.24, 128)
    b.add(shade["shade"], "curtain", 40.0, uv=cylinder_map(4, 0.3), at=(x, y + 0.02, z))
    b.add(shade["bulb"], "bulb", at=lamp)
    return lamp


def build():
    b = Builder("living_room", ambient_light=0.38)
    palette(b)
    shell(b)
    seats(b)
    coffee_table(b)
    plants(b)
    x, y, z = walls(b)
    sun = np.array([-0.74, 0.52, 0.24])
    b.add(
        lathe([(0.0, -0.05), (0.14, -0.045), (0.20, 0.0), (0.21, 0.05)], 96),
        "bulb",
        60.0,
        at=(0.2, TOP - 0.045, 0.6),
    )
    lights = [
        Light((0.2, TOP - 0.15, 0.6), (1.05, 1.00, 0.90), attenuation=(0.55, 0.08, 0.03)),
        Light(tuple(sun / np.linalg.norm(sun)), (1.30, 1.18, 0.95), directional=True),
    ]
    camera = Camera((-1.05, 1.55, 2.65), (0.35, 0.88, -0.9), fov=60.0)
    return b.scene(camera, lights, background=(0.70, 0.82, 0.95), depth=10)
