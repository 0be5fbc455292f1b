# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A kitchen after the paper's Figure 9: tiles and wood, chrome pots and taps, glasses and bottles, a window; two lamps.

x to the right, z to the viewer, y up, metres; the working counters stand along the back wall and the left one.
"""

import numpy as np

from raycore import furniture, patterns
from raycore.scene import Camera, Light
from raycore.shapes import Builder, box, box_map, cylinder_map, lathe, opening, quad, rounded_box, sides, tube, turn

LEFT, RIGHT, BACK, FRONT, TOP = -2.5, 2.5, -2.0, 2.5, 2.7
COUNTER = 0.90  # height of the worktops
DEEP = 0.60
WINDOW = (-0.55, 1.62, 1.5, 1.0)  # middle x, y, and size, in the back wall


def palette(b):
    """The materials."""
    b.varnish("floor", patterns.tiles((0.86, 0.80, 0.70), (0.66, 0.42, 0.30), (0.5, 0.48, 0.45), seed=2), shine=0.2)
    b.paint(
        "wall tiles",
        patterns.tiles((0.90, 0.93, 0.92), (0.62, 0.78, 0.80), (0.75, 0.75, 0.72)),
        shine=0.3,
        sharpness=64.0,
    )
    b.paint("plaster", patterns.plaster((0.95, 0.92, 0.84)), compact=True)
    b.paint("cupboard", patterns.wood((0.86, 0.68, 0.46), (0.62, 0.42, 0.24)), shine=0.12)
    b.paint("dark wood", patterns.wood((0.58, 0.38, 0.24), (0.34, 0.20, 0.12), seed=4), shine=0.15)
    b.varnish("worktop", patterns.marble((0.52, 0.54, 0.55), (0.24, 0.26, 0.30)), shine=0.3, sharpness=128.0)
    b.paint("check", patterns.weave((0.80, 0.22, 0.20), (0.92, 0.90, 0.84), 16), compact=True)
    b.paint("label", patterns.text((0.93, 0.90, 0.78), (0.35, 0.10, 0.10), 8, 16), compact=True)
    b.varnish("china", colour=(0.70, 0.70, 0.68), shine=0.4, sharpness=128.0)
    b.varnish("blue china", colour=(0.12, 0.25, 0.48), shine=0.5, sharpness=128.0)
    b.paint("white", colour=(0.74, 0.74, 0.72), shine=0.1)
    b.varnish("black", colour=(0.05, 0.05, 0.055), shine=0.4, sharpness=64.0)
    b.paint("apple", colour=(0.65, 0.08, 0.05), shine=0.4, sharpness=64.0)
    b.paint("pear", colour=(0.62, 0.66, 0.15), shine=0.3)
    b.paint("orange", colour=(0.90, 0.42, 0.06), shine=0.2)
    b.metal("chrome", (0.92, 0.93, 0.95), 0.75)
    b.metal("copper", (0.95, 0.62, 0.44), 0.65)
    b.glass("glass", (0.97, 0.98, 0.98))
    b.glass("green glass", (0.45, 0.75, 0.40))
    b.glass("oil", (0.95, 0.85, 0.40))
    b.glow("bulb", (1.0, 0.95, 0.85))


def shell(b):
    """Floor, ceiling, walls with the window, tiles above the worktops."""
    side = sides((LEFT, 0.0, BACK), (RIGHT, TOP, FRONT))
    b.add(side["floor"], "floor", uv=box_map(1.2))
    b.add(side["ceiling"], "white")
    for name in ("left", "right", "front"):
        b.add(side[name], "plaster", uv=box_map(1.2))
    wx, wy, wide, high = WINDOW
    x0, x1, y0, y1 = wx - wide / 2, wx + wide / 2, wy - high / 2, wy + high / 2
    wall, reveal = opening((LEFT, 0.0), (RIGHT, TOP), (x0, y0), (x1, y1), 0.22)
    b.add(wall, "plaster", uv=box_map(1.2), at=(0.0, 0.0, BACK))
    b.add(reveal, "white", 0.0, at=(0.0, 0.0, BACK))
    panes = furniture.window(wide - 0.002, high - 0.002)
    b.add(panes["frame"], "white", 0.0, at=(wx, wy, BACK - 0.18))
    b.add(panes["glass"], "glass", 0.0, at=(wx, wy, BACK - 0.18))
    b.add(
        box((x0 - 0.05, y0 - 0.03, BACK - 0.147), (x1 + 0.05, y0 + 0.004, BACK + 0.06)), "worktop", 0.0, uv=box_map(1.0)
    )
    # Tiles between worktop and wall cupboards, 4 mm before the plaster.
    low, top, gap = COUNTER - 0.002, 1.498, 0.001
    parts = ((LEFT - gap, x0 - gap, top), (x1 + gap, 1.3, top), (x0 + gap, x1 - gap, y0 - 0.025))
    for a, d, e in parts:
        b.add(box((a, low, BACK - 0.01), (d, e, BACK + 0.004)), "wall tiles", 0.0, uv=box_map(0.6))
    b.add(box((LEFT - 0.01, low, BACK + 0.001), (LEFT + 0.004, top, 0.9)), "wall tiles", 0.0, uv=box_map(0.6))


def cupboards(b, x0, x1, y0, y1, depth, yaw, at, doors):
    """A row of cupboards with doors, in its own frame: x to the right, its back at z = 0."""
    body = box((x0, y0, 0.002), (x1, y1, depth))
    if y1 < 1.0:  # the worktop covers it, or a sink hangs in it
        body = np.concatenate((body[:6], body[8:]))
    b.add(body, "dark wood", 0.0, uv=box_map(0.8, along=0), yaw=yaw, at=at)
    width = (x1 - x0) / doors
    for i in range(doors):
        door = rounded_box((width - 0.012, y1 - y0 - 0.02, 0.022), 0.006, 3)
        middle = ((x0 + (i + 0.5) * width), (y0 + y1) / 2.0, depth + 0.008)
        panel = rounded_box((width - 0.14, y1 - y0 - 0.16, 0.014), 0.006, 3) + (0.0, 0.0, 0.012)
        for part in (door, panel):
            b.add(part + middle, "cupboard", 50.0, uv=box_map(0.8, (0.0, 0.37 * i, 0.0), along=1), yaw=yaw, at=at)
        high = y1 - 0.10 if y0 < 0.5 else y0 + 0.10
        b.add(furniture.handle() + (middle[0], high, depth + 0.019), "chrome", 60.0, yaw=yaw, at=at)


def counters(b):
    """Cupboards, worktops, sink with tap, stove with pots, hood, refrigerator."""
    cupboards(b, LEFT + DEEP, -0.35, 0.1, COUNTER - 0.04, DEEP - 0.05, 0.0, (0.0, 0.0, BACK), 3)
    cupboards(b, 0.35, 1.3, 0.1, COUNTER - 0.04, DEEP - 0.05, 0.0, (0.0, 0.0, BACK), 2)
    cupboards(b, -0.9, 1.99 - DEEP, 0.1, COUNTER - 0.04, DEEP - 0.05, 90.0, (LEFT, 0.0, 0.0), 5)
    cupboards(b, 0.32, 1.3, 1.5, 2.25, 0.34, 0.0, (0.0, 0.0, BACK), 2)
    cupboards(b, 0.4, 1.985, 1.5, 2.25, 0.34, 90.0, (LEFT, 0.0, 0.0), 3)
    # Worktops: round the sink, left of the stove, on the left wall. The pieces end inside each other.
    sink, z0, z1 = (-1.15, -0.55), BACK + 0.12, BACK + 0.52
    low, high = COUNTER - 0.045, COUNTER
    front = BACK + DEEP
    tops = [(LEFT + 0.001, BACK + 0.003, sink[0], front), (sink[1], BACK + 0.003, -0.34, front)]
    tops += [(sink[0], BACK + 0.003, sink[1], z0), (sink[0], z1, sink[1], front), (0.34, BACK + 0.003, 1.31, front)]
    tops += [(LEFT + 0.001, front, LEFT + DEEP, 0.91)]
    for a, c, d, e in tops:
        b.add(box((a, low, c), (d, high, e)), "worktop", 0.0, uv=box_map(1.0))
    edge = 0.003  # its sides end inside the worktop
    basin = box((sink[0] - edge, COUNTER - 0.18, z0 - edge), (sink[1] + edge, COUNTER - 0.01, z1 + edge))
    b.add(np.concatenate((basin[:6], basin[8:]))[:, ::-1], "chrome", 0.0)  # without its lid, seen from inside
    b.add(furniture.tap(24), "chrome", 60.0, at=((sink[0] + sink[1]) / 2.0, COUNTER - 0.001, z0 - 0.05))
    # Stove: black top, oven door with a glass pane and a bar, knobs; a hood above.
    b.add(box((-0.332, 0.02, BACK + 0.003), (0.332, COUNTER - 0.01, front - 0.01)), "white", 0.0)
    b.add(rounded_box((0.67, 0.03, 0.57), 0.008, 4) + (0.0, COUNTER - 0.005, BACK + 0.31), "black", 50.0)
    b.add(rounded_box((0.60, 0.50, 0.03), 0.01, 4) + (0.0, 0.42, front - 0.004), "black", 50.0)
    b.add(furniture.handle(0.5, 16) + (0.0, 0.70, front + 0.008), "chrome", 60.0)
    knob = turn(lathe([(0.0, 0.0), (0.024, 0.0), (0.020, 0.022), (0.0, 0.024)], 40), 90.0, "x")
    for i in range(5):
        b.add(knob + (-0.24 + 0.12 * i, 0.80, front - 0.011), "chrome", 40.0)
    plates = [
        lathe([(0.0, 0.0), (0.095, 0.0), (0.09, 0.008), (0.0, 0.009)], 48) + (x, COUNTER + 0.009, BACK + z)
        for x in (-0.17, 0.17)
        for z in (0.16, 0.43)
    ]
    b.add(np.concatenate(plates), "black", 40.0)
    b.add(furniture.pot(72), "chrome", 50.0, at=(-0.17, COUNTER + 0.0185, BACK + 0.43), yaw=20.0)
    b.add(furniture.pot(72) * (0.9, 1.2, 0.9), "copper", 50.0, at=(0.17, COUNTER + 0.0185, BACK + 0.16), yaw=-30.0)
    b.add(furniture.teapot(64) * 1.1, "chrome", 50.0, at=(0.17, COUNTER + 0.0185, BACK + 0.43), yaw=150.0)
    hood = [
        (x, y, BACK + z)
        for y, w, z in ((1.62, 0.35, 0.5), (1.70, 0.35, 0.5), (1.95, 0.13, 0.25), (TOP + 0.01, 0.13, 0.25))
        for x, z in ((-w, 0.002), (-w, z), (w, z), (w, 0.002))
    ]
    rings = np.array(hood).reshape(4, 4, 3)
    for i in range(3):
        for a, c in ((0, 1), (1, 2), (2, 3)):
            b.add(quad(rings[i, a], rings[i, c], rings[i + 1, c], rings[i + 1, a]), "chrome", 0.0)
    b.add(quad(*rings[0][::-1]), "chrome", 0.0)
    # Refrigerator on the right of the back wall.
    b.add(rounded_box((0.70, 1.85, 0.64), 0.03, 8) + (1.75, 0.94, BACK + 0.34), "white", 50.0)
    for y, h in ((0.62, 1.16), (1.53, 0.62)):
        b.add(rounded_box((0.68, h, 0.05), 0.02, 8) + (1.75, y, BACK + 0.68), "white", 50.0)
    b.add(tube(np.array([(1.46, 0.75, BACK + 0.73), (1.46, 1.15, BACK + 0.73)]), 0.012, 24), "chrome", 60.0)
    b.add(tube(np.array([(1.46, 1.30, BACK + 0.73), (1.46, 1.55, BACK + 0.73)]), 0.012, 24), "chrome", 60.0)


def things(b):
    """What stands on the worktops: bottles, glasses, plates, jars."""
    gap = COUNTER + 0.001  # glass never touches: a millimetre of air
    for i, (x, z, kind) in enumerate(((0.48, 0.14, "green glass"), (0.60, 0.12, "oil"), (0.71, 0.16, "glass"))):
        b.add(furniture.vessel("bottle", 48, 5), kind, 60.0, at=(x, gap, BACK + z))
        label = lathe([(0.0386, 0.06), (0.0386, 0.15)], 48)
        b.add(label, "label", 60.0, uv=cylinder_map(2, 0.12), at=(x, gap, BACK + z), yaw=40.0 * i)
    for i in range(5):  # glasses upside up on the left worktop
        b.add(
            furniture.vessel("tumbler", 48, 5),
            "glass",
            60.0,
            at=(LEFT + 0.18 + 0.10 * (i % 2), gap, -0.95 + 0.11 * i),
        )
    for i in range(7):
        b.add(
            furniture.vessel("plate", 64),
            "china" if i % 3 else "blue china",
            40.0,
            at=(LEFT + 0.28, COUNTER + 0.001 + 0.012 * i, 0.05),
        )
    for i in range(6):
        cup = np.concatenate(
            (
                furniture.vessel("cup", 48),
                tube(
                    [(0.036 + 0.026 * np.sin(a), 0.04 + 0.024 * np.cos(a), 0.0) for a in np.linspace(0.2, 2.9, 16)],
                    0.004,
                    12,
                ),
            )
        )
        b.add(
            cup,
            "blue china" if i % 2 else "china",
            50.0,
            at=(LEFT + 0.22 + 0.13 * (i % 2), gap, 0.32 + 0.09 * i),
            yaw=30.0 * i,
        )
    board = rounded_box((0.42, 0.024, 0.28), 0.008, 4)
    b.add(board, "cupboard", 50.0, uv=box_map(0.5, along=0), at=(-1.55, COUNTER + 0.013, BACK + 0.3), yaw=15.0)
    loaf = rounded_box((0.26, 0.11, 0.12), 0.05, 12)
    b.add(loaf, "dark wood", 60.0, uv=box_map(0.7), at=(-1.55, COUNTER + 0.081, BACK + 0.3), yaw=25.0)
    for i in range(4):  # jars with lids on the window sill
        x = WINDOW[0] - 0.5 + 0.32 * i
        sill = WINDOW[1] - WINDOW[3] / 2.0 + 0.005
        b.add(furniture.vessel("tumbler", 48, 5) * 1.2, "glass" if i % 2 else "oil", 60.0, at=(x, sill, BACK - 0.05))
    for i, kind in enumerate(("wine", "wine", "tumbler", "wine")):  # on the wall cupboard's open end
        b.add(furniture.vessel(kind, 48, 5), "glass", 60.0, at=(0.86 + 0.11 * i, gap, BACK + 0.22 + 0.06 * (i % 2)))


def dining(b, at=(0.95, 0.0, 0.55)):
    """The table in front, laid for four, with chairs, and the lamp above it. Returns the place of the lamp."""
    x, _, z = at
    top = 0.75
    table = furniture.table((1.5, 0.95), top)
    b.add(table["top"], "dark wood", 50.0, uv=box_map(0.9, along=0), at=at)
    b.add(table["legs"], "dark wood", 50.0, uv=box_map(0.9, along=1), at=(x, -0.002, z))
    places = ((-0.38, 0.30, 0.0), (0.38, 0.30, 0.0), (-0.38, -0.30, 180.0), (0.38, -0.30, 180.0))
    for px, pz, yaw in places:
        chair = furniture.chair()
        spot = (x + px, -0.002, z + 2.45 * pz)
        b.add(chair["wood"], "cupboard", 50.0, uv=box_map(0.7, along=1), at=spot, yaw=yaw + 180.0 + 8.0 * px)
        b.add(chair["seat"], "check", 60.0, uv=box_map(0.35), at=spot, yaw=yaw + 180.0 + 8.0 * px)
        mat = rounded_box((0.40, 0.004, 0.28), 0.002, 2)
        b.add(mat, "check", 50.0, uv=box_map(0.3), at=(x + px, top + 0.003, z + pz))
        b.add(furniture.vessel("plate", 64), "china", 40.0, at=(x + px, top + 0.006, z + pz))
        side = 1.0 if pz > 0.0 else -1.0
        b.add(
            furniture.vessel("wine", 64, 6),
            "glass",
            70.0,
            at=(x + px + 0.185 * side, top + 0.001, z + pz - 0.19 * side),
        )
        for i, dx in enumerate((-0.165, 0.165, 0.185)):
            cutlery = rounded_box((0.012, 0.004, 0.17), 0.0018, 3)
            b.add(cutlery, "chrome", 60.0, at=(x + px + dx, top + 0.0075, z + pz + 0.01 * i))
    b.add(furniture.vessel("bowl", 72, 5) * 1.15, "glass", 60.0, at=(x, top + 0.001, z))
    for i, (dx, dy, dz, what) in enumerate(
        (
            (-0.055, 0.047, 0.02, "apple"),
            (0.042, 0.047, 0.042, "orange"),
            (0.015, 0.047, -0.055, "pear"),
            (0.0, 0.119, 0.005, "apple"),
        )
    ):
        b.add(furniture.fruit(0.044, 40), what, 60.0, at=(x + dx, top + dy, z + dz), yaw=50.0 * i)
    b.add(furniture.vessel("bottle", 64, 6), "green glass", 60.0, at=(x + 0.30, top + 0.001, z + 0.02))
    lamp = (x, 1.95, z)
    shade = furniture.lampshade(0.20, 96)
    b.add(shade["shade"], "copper", 40.0, at=lamp)
    b.add(shade["bulb"], "bulb", 60.0, at=lamp)
    b.add(tube(np.array([(x, 2.0, z), (x, TOP + 0.01, z)]), 0.005, 10), "black", 60.0)
    return lamp


def build():
    b = Builder("kitchen", ambient_light=0.34)
    palette(b)
    shell(b)
    counters(b)
    things(b)
    x, y, z = dining(b)
    b.add(
        lathe([(0.0, -0.06), (0.10, -0.055), (0.15, 0.0), (0.16, 0.05)], 64),
        "bulb",
        60.0,
        at=(-0.9, TOP - 0.045, 0.0),
    )
    lights = [
        Light((-0.9, TOP - 0.16, 0.0), (1.00, 0.97, 0.90), attenuation=(0.55, 0.08, 0.05)),
        Light((x, y - 0.06, z), (0.70, 0.62, 0.50), attenuation=(0.55, 0.10, 0.06)),
    ]
    camera = Camera((2.05, 1.62, 2.30), (-0.35, 0.98, -0.75), fov=58.0)
    return b.scene(camera, lights, background=(0.70, 0.82, 0.95), depth=10)
