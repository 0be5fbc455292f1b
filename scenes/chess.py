# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A game of chess in the open: the Italian opening, on a varnished board that mirrors the men."""

from raycore import furniture, patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box_map, plane_map, quad, rounded_box

SQUARE = 0.055
BACK = ("rook", "knight", "bishop", "queen", "king", "bishop", "knight", "rook")


def men():
    """(side, kind, file 0-7, rank 0-7) after 1. e4 e5 2. Nf3 Nc6 3. Bc4 Bc5."""
    moves = {("light", 4, 1): (4, 3), ("light", 6, 0): (5, 2), ("light", 5, 0): (2, 3)}
    moves |= {("dark", 4, 6): (4, 4), ("dark", 1, 7): (2, 5), ("dark", 5, 7): (2, 4)}
    for side, first, second in (("light", 0, 1), ("dark", 7, 6)):
        for file in range(8):
            for kind, rank in ((BACK[file], first), ("pawn", second)):
                yield side, kind, *moves.get((side, file, rank), (file, rank))


def build():
    b = Builder("chess", ambient_light=0.16)
    b.varnish("board", patterns.checker((0.84, 0.76, 0.60), (0.30, 0.17, 0.10), 8, 256), shine=0.3, sharpness=64.0)
    b.varnish("frame", patterns.wood((0.42, 0.25, 0.14), (0.24, 0.13, 0.07)), shine=0.2)
    b.paint("table", patterns.weave((0.16, 0.30, 0.26), (0.20, 0.38, 0.32), 64))
    b.varnish("light men", colour=(0.84, 0.74, 0.52), shine=0.4, sharpness=64.0)
    b.varnish("dark men", colour=(0.16, 0.07, 0.05), shine=0.5, sharpness=64.0)

    half = 4.0 * SQUARE
    b.add(
        quad((-1.7, 0, -2.2), (-1.7, 0, 0.9), (1.3, 0, 0.9), (1.3, 0, -2.2)),
        "table",
        uv=plane_map((1, 0, 0), (0, 0, 1), 0.5),
    )
    b.add(
        rounded_box((2 * half + 0.06, 0.024, 2 * half + 0.06), 0.006, 3) + (0.0, 0.0125, 0.0),
        "frame",
        50.0,
        box_map(0.4),
    )
    top = quad((-half, 0.0248, -half), (-half, 0.0248, half), (half, 0.0248, half), (half, 0.0248, -half))
    b.add(top, "board", uv=plane_map((1, 0, 0), (0, 0, 1), 2.0 * half, (-half, 0, -half)))
    for side, kind, file, rank in men():
        at = ((file - 3.5) * SQUARE, 0.0252, (3.5 - rank) * SQUARE)
        yaw = 180.0 if side == "light" else 0.0
        b.add(furniture.chess_piece(kind, 11, 1) * 1.15, f"{side} men", 62.0, at=at, yaw=yaw)
    lights = [Light((-0.5, 0.9, 0.4), (0.85, 0.78, 0.66)), Light((0.8, 0.6, 0.7), (0.32, 0.36, 0.44))]
    return b.scene(Camera((0.29, 0.27, 0.46), (0.01, 0.025, 0.03), fov=42.0), lights, depth=6)
