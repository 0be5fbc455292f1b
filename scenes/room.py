# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A room with a moving light after the paper's Figure 9: parquet and wallpaper, a mirror, a glass table with a game of chess.

One lamp hangs over the table, the other one, a glowing ball, goes round the room. Metres, y up, the camera looks towards -z.
"""

import math

import numpy as np

from raycore import furniture, patterns
from raycore.scene import Camera, Light
from raycore.shapes import (
    Builder,
    box,
    box_map,
    cylinder_map,
    icosphere,
    lathe,
    plane_map,
    quad,
    rounded_box,
    sides,
    sphere,
    tube,
)

LEFT, RIGHT, BACK, FRONT, TOP = -2.3, 2.3, -2.2, 2.6, 2.7
TABLE = (0.0, -0.35)  # middle, x and z
HIGH = 0.62  # upper side of the glass


def palette(b):
    """The materials."""
    b.varnish("floor", patterns.parquet((0.82, 0.62, 0.42), (0.55, 0.36, 0.22)), shine=0.2)
    b.paint("wallpaper", patterns.wallpaper((0.92, 0.90, 0.80), (0.55, 0.68, 0.60)), compact=True)
    b.paint("wood", patterns.wood((0.62, 0.42, 0.26), (0.38, 0.22, 0.13)), shine=0.15)
    b.paint("rug", patterns.rug((0.62, 0.16, 0.14), (0.16, 0.20, 0.38), (0.90, 0.80, 0.58)))
    b.paint("velvet", patterns.weave((0.20, 0.36, 0.46), (0.28, 0.46, 0.54), 32), compact=True)
    b.paint("board", patterns.checker((0.86, 0.80, 0.68), (0.26, 0.17, 0.12), 8, 128), shine=0.3, sharpness=64.0)
    b.paint("picture", patterns.painting())
    b.varnish("marble", patterns.marble((0.88, 0.86, 0.84), (0.50, 0.48, 0.50)), shine=0.3, sharpness=64.0)
    b.paint("white", colour=(0.86, 0.86, 0.84))
    b.paint("light pieces", colour=(0.82, 0.74, 0.56), shine=0.4, sharpness=64.0)
    b.varnish("dark pieces", colour=(0.14, 0.08, 0.06), shine=0.5, sharpness=64.0)
    for i, c in enumerate(
        ((0.50, 0.14, 0.12), (0.14, 0.28, 0.45), (0.18, 0.36, 0.22), (0.62, 0.50, 0.26), (0.30, 0.18, 0.30))
    ):
        b.paint(f"book {i}", patterns.text(c, (0.88, 0.78, 0.50), 4, 8, seed=i), compact=True, shine=0.1)
    b.metal("mirror", (0.93, 0.95, 0.95), 0.92, 0.02)
    b.metal("brass", (0.92, 0.74, 0.42), 0.6)
    b.metal("steel", (0.90, 0.90, 0.92), 0.7)
    b.glass("glass", (0.96, 0.985, 0.975))
    b.glass("blue glass", (0.50, 0.65, 0.95))
    b.glow("bulb", (1.0, 0.95, 0.82))


def shell(b):
    """Floor, ceiling, walls, skirting, rug."""
    side = sides((LEFT, 0.0, BACK), (RIGHT, TOP, FRONT))
    b.add(side["floor"], "floor", uv=plane_map((0, 0, 1), (1, 0, 0), 1.4))
    b.add(side["ceiling"], "white")
    for name in ("left", "right", "back", "front"):
        b.add(side[name], "wallpaper", uv=box_map(0.9))
    for x0, x1, z0, high in (
        (LEFT - 0.01, RIGHT + 0.01, BACK - 0.01, 0.120),
        (LEFT - 0.01, LEFT + 0.018, BACK + 0.018, 0.119),
        (RIGHT - 0.018, RIGHT + 0.01, BACK + 0.018, 0.119),
    ):
        z1 = BACK + 0.018 if z0 < BACK else FRONT + 0.01
        b.add(box((x0, -0.01, z0), (x1, high, z1)), "wood", 0.0, uv=box_map(0.9))
    rug = rounded_box((2.6, 0.014, 1.9), 0.006, 3) + (TABLE[0], 0.006, TABLE[1])
    corner = (TABLE[0] - 1.3, 0.0, TABLE[1] - 0.95)
    b.add(rug, "rug", 50.0, uv=plane_map((0, 0, 1), (1, 0, 0), (1.9, 2.6), corner))


def chess(b, at, square=0.048):
    """A board and its 32 men, a few moves into a game, on y = at[1]."""
    half = 4.0 * square
    b.add(
        rounded_box((2 * half + 0.05, 0.018, 2 * half + 0.05), 0.005, 3),
        "wood",
        50.0,
        uv=box_map(0.4),
        at=(at[0], at[1] + 0.0102, at[2]),
    )
    top = quad((-half, 0, -half), (-half, 0, half), (half, 0, half), (half, 0, -half))
    b.add(
        top,
        "board",
        0.0,
        uv=plane_map((1, 0, 0), (0, 0, 1), 2.0 * half, (-half, 0, -half)),
        at=(at[0], at[1] + 0.0198, at[2]),
    )
    back = ("rook", "knight", "bishop", "queen", "king", "bishop", "knight", "rook")
    moved = {("light", 4): 2, ("dark", 4): 2, ("light", 3): 1, ("dark", 2): 1}  # pawns that have left
    for side, sign in (("light", 1), ("dark", -1)):
        for i in range(8):
            for kind, row in ((back[i], 3.5), ("pawn", 2.5 - moved.get((side, i), 0))):
                spot = (at[0] + sign * row * square, at[1] + 0.0202, at[2] + (i - 3.5) * square)
                b.add(furniture.chess_piece(kind, 46, 4), f"{side} pieces", 50.0, at=spot, yaw=-90.0 * sign)


def table(b):
    """The glass table, the game on it, a vase and two glasses; two chairs."""
    x, z = TABLE
    plate = rounded_box((1.30, 0.018, 0.80), 0.008, 6)
    b.add(plate, "glass", 50.0, at=(x, HIGH - 0.009, z))
    for i in (-1, 1):
        for j in (-1, 1):
            leg = [
                (0.0, -0.002),
                (0.03, 0.0),
                (0.03, 0.012),
                (0.014, 0.03),
                (0.014, HIGH - 0.06),
                (0.03, HIGH - 0.034),
                (0.0, HIGH - 0.032),
            ]
            b.add(lathe(leg, 32), "steel", 40.0, at=(x + 0.55 * i, 0.013, z + 0.32 * j))
        b.add(tube(np.array([(0.55 * i, 0.2, -0.32), (0.55 * i, 0.2, 0.32)]), 0.010, 16), "steel", 60.0, at=(x, 0.0, z))
    chess(b, (x, HIGH + 0.001, z))
    b.add(furniture.vessel("vase", 96, 6), "blue glass", 60.0, at=(x - 0.50, HIGH + 0.001, z - 0.18))
    for px, pz, kind in ((0.42, 0.22, "wine"), (-0.36, -0.24, "wine"), (0.48, -0.14, "tumbler")):
        b.add(furniture.vessel(kind, 64, 6), "glass", 70.0, at=(x + px, HIGH + 0.001, z + pz))
    for side, yaw in ((1, -82.0), (-1, 84.0)):
        chair = furniture.chair(6)
        spot = (x + 0.86 * side, 0.012, z + 0.04 * side)
        b.add(chair["wood"], "wood", 50.0, uv=box_map(0.7, along=1), at=spot, yaw=yaw)
        b.add(chair["seat"], "velvet", 60.0, uv=box_map(0.25), at=spot, yaw=yaw)


def walls(b):
    """Along the walls: mirror over a marble mantelpiece, shelf with books, picture, a column with a marble ball."""
    glass = furniture.framed(1.3, 0.9, 0.06)
    b.add(glass["frame"], "brass", 30.0, at=(-0.15, 1.75, BACK + 0.035))
    b.add(glass["picture"][0], "mirror", 0.0, at=(-0.15, 1.75, BACK + 0.035))
    mantel = rounded_box((1.6, 0.06, 0.30), 0.02, 6)
    b.add(mantel, "marble", 50.0, uv=box_map(0.8), at=(-0.15, 1.15, BACK + 0.151))
    for s in (-1, 1):
        b.add(
            lathe(
                [
                    (0.0, -0.01),
                    (0.11, 0.0),
                    (0.11, 0.08),
                    (0.07, 0.12),
                    (0.065, 1.02),
                    (0.10, 1.08),
                    (0.10, 1.119),
                    (0.0, 1.12),
                ],
                64,
                12,
                0.05,
            ),
            "marble",
            35.0,
            uv=cylinder_map(1, 0.8),
            at=(-0.15 + 0.62 * s, 0.0, BACK + 0.15),
        )
    b.add(box((-0.62, 0.001, BACK + 0.004), (0.32, 1.10, BACK + 0.06)), "velvet", 0.0, uv=box_map(0.4))
    candle = lathe(
        [
            (0.0, 0.0),
            (0.05, 0.002),
            (0.045, 0.012),
            (0.010, 0.03),
            (0.010, 0.16),
            (0.026, 0.18),
            (0.024, 0.19),
            (0.0, 0.19),
        ],
        48,
    )
    for s in (-1, 1):
        b.add(candle, "brass", 40.0, at=(-0.15 + 0.55 * s, 1.1805, BACK + 0.16))
        b.add(
            lathe([(0.0, 0.0), (0.012, 0.0), (0.012, 0.2), (0.0, 0.203)], 32),
            "white",
            40.0,
            at=(-0.15 + 0.55 * s, 1.3706, BACK + 0.16),
        )
    b.add(furniture.teapot(72) * 1.1, "steel", 50.0, at=(0.0, 1.1808, BACK + 0.15), yaw=20.0)

    picture = furniture.framed(0.9, 0.45)
    b.add(picture["frame"], "wood", 30.0, uv=box_map(0.5), at=(LEFT + 0.032, 1.6, -0.4), yaw=90.0)
    b.add(picture["picture"][0], "picture", 0.0, uv=picture["picture"][1], at=(LEFT + 0.032, 1.6, -0.4), yaw=90.0)

    case, boards = furniture.shelf(1.5, 2.0, 0.30, 6)
    b.add(case, "wood", 0.0, uv=box_map(0.8, along=0), at=(RIGHT - 0.002, 0.0, -0.7), yaw=270.0)
    for i, y in enumerate(boards[:-1]):
        length = 1.42 if i % 2 else 0.9
        for book, n in furniture.books(length, 0.30, 0.22, seed=i + 1):
            # The shelf's opening looks to -x; spines stand 5 cm behind its edge.
            colour = f"book {(n * n + 2 * i) % 5}"
            b.add(
                book + (-0.72, 0.0, 0.25),
                colour,
                50.0,
                uv=box_map((0.3, 0.1), along=1),
                at=(RIGHT - 0.002, y, -0.7),
                yaw=270.0,
            )
        if i % 2 == 0:
            b.add(
                furniture.vessel("vase", 72, 5) * 0.62,
                "blue glass" if i else "glass",
                60.0,
                at=(RIGHT - 0.16, y + 0.001, -0.2),
            )
    ball = lathe(
        [(0.0, -0.01), (0.16, 0.0), (0.16, 0.10), (0.11, 0.14), (0.10, 0.85), (0.15, 0.92), (0.15, 0.96), (0.0, 0.961)],
        96,
        16,
        0.06,
    )
    b.add(ball, "marble", 35.0, uv=cylinder_map(1, 0.8), at=(LEFT + 0.45, 0.0, BACK + 0.45))
    b.add(sphere((0.0, 0.0, 0.0), 0.19, 128), "steel", at=(LEFT + 0.45, 1.150, BACK + 0.45))


def build(light_at=0.0):
    """light_at: where on its way round the room the moving light is, in turns."""
    b = Builder("room", ambient_light=0.30)
    palette(b)
    shell(b)
    table(b)
    walls(b)
    lamp = (TABLE[0], 1.95, TABLE[1])
    shade = furniture.lampshade(0.22, 96)
    b.add(shade["shade"], "brass", 40.0, at=lamp)
    b.add(shade["bulb"], "bulb", at=lamp)
    b.add(tube(np.array([(0.0, 0.05, 0.0), (0.0, TOP - 1.94, 0.0)]), 0.005, 10), "brass", 60.0, at=lamp)
    turn = 2.0 * math.pi * light_at
    moving = (1.45 * math.cos(turn + 0.6), 1.75 + 0.25 * math.sin(2.0 * turn), 0.2 + 1.25 * math.sin(turn + 0.6))
    vertices, faces = icosphere(3)
    b.add(0.05 * vertices[faces], "bulb", 60.0, at=moving)
    # Lights stand a little below what glows.
    lights = [
        Light((lamp[0], lamp[1] - 0.06, lamp[2]), (0.90, 0.80, 0.62), attenuation=(0.55, 0.10, 0.06)),
        Light((moving[0], moving[1] - 0.06, moving[2]), (0.80, 0.80, 0.78), attenuation=(0.65, 0.10, 0.05)),
    ]
    return b.scene(
        Camera((-0.85, 1.72, 2.15), (0.10, 0.86, -0.9), fov=58.0), lights, background=(0.05, 0.06, 0.08), depth=10
    )
