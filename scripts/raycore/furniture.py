# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Things for the rooms in `scenes/`: metres, y up, standing on y = 0 round the y axis, the front towards +z.

Each is a triangle list (n, 3, 3), or a dictionary of them if its parts have different materials. Vessels are one closed surface,
outside and inside, so that glass refracts as glass does.
"""

from itertools import pairwise

import numpy as np

from raycore.shapes import box, curve, lathe, quad, rounded_box, sheet, sphere, torus, tube, turn

# Vessels: smooth lines of (radius, height), up the outside, over the rim, down the inside.
_VESSELS = {
    "wine": (
        [
            (0.034, 0.0),
            (0.036, 0.002),
            (0.024, 0.006),
            (0.0055, 0.014),
            (0.0045, 0.05),
            (0.0055, 0.080),
            (0.026, 0.100),
        ],
        [(0.040, 0.130), (0.038, 0.165), (0.033, 0.195), (0.0318, 0.196), (0.0305, 0.195), (0.0352, 0.165)],
        [(0.037, 0.130), (0.025, 0.105), (0.010, 0.096), (0.0, 0.094)],
    ),
    "tumbler": (
        [(0.030, 0.0), (0.033, 0.003), (0.035, 0.04), (0.038, 0.108), (0.0368, 0.110)],
        [(0.0356, 0.108), (0.0322, 0.04), (0.029, 0.014), (0.0, 0.012)],
    ),
    "bottle": (
        [
            (0.034, 0.0),
            (0.037, 0.004),
            (0.0375, 0.10),
            (0.0375, 0.185),
            (0.030, 0.215),
            (0.0155, 0.245),
            (0.0145, 0.29),
        ],
        [(0.0155, 0.300), (0.0130, 0.303), (0.0105, 0.300), (0.0105, 0.245), (0.026, 0.213), (0.0335, 0.183)],
        [(0.0335, 0.10), (0.032, 0.012), (0.0, 0.010)],
    ),
    "vase": (
        [(0.050, 0.0), (0.056, 0.006), (0.085, 0.08), (0.090, 0.14), (0.062, 0.23), (0.048, 0.28), (0.062, 0.34)],
        [(0.060, 0.343), (0.056, 0.340), (0.043, 0.28), (0.056, 0.23), (0.084, 0.14), (0.079, 0.08)],
        [(0.050, 0.016), (0.0, 0.014)],
    ),
    "bowl": (
        [(0.050, 0.0), (0.055, 0.004), (0.060, 0.012), (0.105, 0.040), (0.140, 0.085), (0.137, 0.088)],
        [(0.133, 0.085), (0.098, 0.044), (0.052, 0.022), (0.0, 0.020)],
    ),
    "plate": (
        [(0.070, 0.0), (0.075, 0.004), (0.130, 0.018), (0.129, 0.0205)],
        [(0.126, 0.021), (0.080, 0.008), (0.0, 0.007)],
    ),
    "cup": (
        [(0.024, 0.0), (0.027, 0.003), (0.036, 0.03), (0.041, 0.080), (0.0395, 0.082)],
        [(0.038, 0.080), (0.033, 0.03), (0.022, 0.010), (0.0, 0.009)],
    ),
    "teapot": (
        [(0.050, 0.0), (0.056, 0.004), (0.085, 0.05), (0.080, 0.095), (0.050, 0.125), (0.047, 0.122)],
        [(0.075, 0.094), (0.080, 0.05), (0.050, 0.012), (0.0, 0.010)],
    ),
    "pot": (
        [(0.095, 0.0), (0.104, 0.006), (0.106, 0.06), (0.106, 0.138), (0.110, 0.142), (0.104, 0.1445)],
        [(0.101, 0.138), (0.101, 0.06), (0.094, 0.008), (0.0, 0.007)],
    ),
    "planter": (
        [(0.110, 0.0), (0.118, 0.008), (0.160, 0.26), (0.172, 0.270), (0.172, 0.300), (0.160, 0.302)],
        [(0.150, 0.295), (0.145, 0.262), (0.0, 0.258)],
    ),
}


def vessel(kind, segments=48, steps=4):
    """A vessel of `_VESSELS`; steps: points between two of its line. The base is flat."""
    line = curve(np.concatenate(_VESSELS[kind]), steps)
    line[:, 1] = np.maximum(line[:, 1], 0.0)  # the curve swings below its first point
    return lathe(np.concatenate(([(0.0, 0.0)], line)), segments)


def lid(radius, segments=48):
    """A flat dome with a knob, its rim at y = 0."""
    dome = [(radius, 0.0), (radius, 0.004), (radius * 0.7, 0.018), (0.012, 0.024), (0.008, 0.030), (0.016, 0.042)]
    return lathe(np.concatenate(([(0.0, 0.0)], curve([*dome, (0.010, 0.052), (0.0, 0.054)], 4))), segments)


def pot(segments=64):
    """A saucepan with its lid and two handles."""
    loop = np.radians(np.linspace(-90.0, 90.0, 17))
    ear = tube(np.stack((0.100 + 0.045 * np.cos(loop), np.full(17, 0.105), 0.040 * np.sin(loop)), axis=1), 0.006, 12)
    return np.concatenate((vessel("pot", segments), lid(0.1035, segments) + (0.0, 0.1455, 0.0), ear, turn(ear, 180.0)))


def teapot(segments=48):
    """Body, lid, spout and handle."""
    t = np.linspace(0.0, 1.0, 20)
    spout = np.stack((0.070 + 0.075 * t, 0.045 + 0.085 * t**1.7, 0.0 * t), axis=1)
    loop = np.radians(np.linspace(70.0, 290.0, 28))
    handle = np.stack((-0.090 + 0.045 * np.cos(loop), 0.066 + 0.038 * np.sin(loop), 0.0 * loop), axis=1)
    parts = vessel("teapot", segments), lid(0.048, segments) + (0.0, 0.126, 0.0)
    return np.concatenate((*parts, tube(spout, 0.011, 16), tube(handle, 0.006, 12)))


def tap(sides=20):
    """A kitchen tap that bends towards +z, with two handles."""
    bend = np.radians(np.linspace(0.0, 200.0, 40))
    line = [(0.0, 0.0, 0.0), (0.0, 0.1, 0.0), *((0.0, 0.2 + 0.09 * np.sin(a), 0.09 - 0.09 * np.cos(a)) for a in bend)]
    base = lathe([(0.0, 0.0), (0.026, 0.0), (0.026, 0.010), (0.020, 0.022), (0.020, 0.055), (0.0, 0.058)], 32)
    out = [tube(np.array(line), 0.011, sides), base]
    for x in (-0.11, 0.11):
        out += [
            base + (x, 0.0, 0.0),
            turn(rounded_box((0.09, 0.012, 0.016), 0.005, 4), 35.0 * x / 0.11) + (x, 0.066, 0.0),
        ]
    return np.concatenate(out)


def handle(length=0.12, sides=12):
    """A bow-shaped handle along x, before z = 0."""
    a = np.radians(np.linspace(0.0, 180.0, 25))
    return tube(np.stack((-0.5 * length * np.cos(a), 0.0 * a, 0.028 * np.sin(a) ** 0.5), axis=1), 0.005, sides)


def chair(steps=4):
    """A wooden chair whose back is at -z: {"wood": ..., "seat": ...}."""
    wood = []
    for x in (-0.19, 0.19):
        wood.append(lathe(curve([(0.014, 0.0), (0.018, 0.1), (0.022, 0.3), (0.020, 0.44)], 4), 16) + (x, 0.0, 0.19))
        y = np.linspace(0.0, 0.95, 20)
        wood.append(tube(np.stack((np.full(20, x), y, -0.20 - 0.08 * np.maximum(y - 0.45, 0.0)), axis=1), 0.018, 14))
        wood.append(tube(np.array([(x, 0.18, -0.20), (x, 0.18, 0.19)]), 0.010, 10))
    for y in (0.58, 0.72, 0.86):
        bow = np.linspace(-1.0, 1.0, 13)
        z = -0.20 - 0.08 * (y - 0.45) - 0.03 * (1.0 - bow**2)
        rail = np.stack((0.19 * bow, np.full(13, y), z), axis=1)
        slat = np.stack(
            [rail + (0.0, dy, dz) for dy, dz in ((-0.03, 0.007), (0.03, 0.007), (0.03, -0.007), (-0.03, -0.007))]
        )
        wood.append(sheet(slat.transpose(1, 0, 2), close_v=True)[:, ::-1])
    wood.append(rounded_box((0.42, 0.03, 0.42), 0.012, steps) + (0.0, 0.445, 0.0))
    return {"wood": np.concatenate(wood), "seat": rounded_box((0.38, 0.05, 0.38), 0.022, 2 * steps) + (0.0, 0.486, 0.0)}


def table(size, height=0.75, leg=0.04):
    """A table of (x, z) size: {"top": ..., "legs": ...}."""
    x, z = size[0] / 2.0 - 0.08, size[1] / 2.0 - 0.08
    turned = curve([(leg * 0.5, 0.0), (leg * 0.7, 0.1), (leg * 0.6, 0.3), (leg, 0.5), (leg * 0.8, height - 0.05)], 6)
    legs = [lathe(turned, 32) + (i * x, 0.0, j * z) for i in (-1, 1) for j in (-1, 1)]
    legs += [box((-x, height - 0.11, s * z - 0.012), (x, height - 0.041, s * z + 0.012)) for s in (-1, 1)]
    legs += [box((s * x - 0.012, height - 0.11, -z), (s * x + 0.012, height - 0.041, z)) for s in (-1, 1)]
    return {
        "top": rounded_box((size[0], 0.04, size[1]), 0.012, 4) + (0.0, height - 0.02, 0.0),
        "legs": np.concatenate(legs),
    }


def cushion(size, steps=10, puff=0.35):
    """A box of cloth, fuller in the middle."""
    out = rounded_box(size, 0.45 * min(size), steps)
    half = np.asarray(size) / 2.0
    q = np.clip(np.abs(out / half), 0.0, 1.0)
    thin = int(np.argmin(size))
    other = [i for i in range(3) if i != thin]
    out[..., thin] *= 1.0 + puff * np.prod(1.0 - q[..., other] ** 2, axis=-1)
    return out


def sofa(width=2.0, seats=3, steps=10):
    """{"cloth": ..., "feet": ...}, the back at -z."""
    cloth = [rounded_box((width, 0.20, 0.80), 0.05, steps) + (0.0, 0.22, 0.0)]
    cloth += [rounded_box((0.20, 0.52, 0.84), 0.09, steps) + (s * (width / 2.0 + 0.06), 0.36, 0.0) for s in (-1, 1)]
    cloth += [rounded_box((width + 0.1, 0.66, 0.20), 0.09, steps) + (0.0, 0.44, -0.38)]
    one = width / seats
    for i in range(seats):
        x = (i - (seats - 1) / 2.0) * one
        cloth.append(cushion((one - 0.015, 0.17, 0.66), steps, 0.2) + (x, 0.40, 0.06))
        back = turn(cushion((one - 0.03, 0.42, 0.16), steps, 0.3), -14.0, "x")
        cloth.append(back + (x, 0.66, -0.20))
    feet = [
        lathe([(0.0, 0.0), (0.02, 0.0), (0.03, 0.13), (0.0, 0.13)], 16) + (i * 0.9 * width / 2, 0, j * 0.32)
        for i in (-1, 1)
        for j in (-1, 1)
    ]
    return {"cloth": np.concatenate(cloth), "feet": np.concatenate(feet)}


def curtain(width, height, folds=9, columns=160, rows=24, depth=0.05):
    """A curtain that hangs from y = height, round x = 0: (triangles, texture coordinates in metres)."""
    u, v = np.linspace(-0.5, 0.5, columns + 1)[:, None], np.linspace(0.0, 1.0, rows + 1)[None]
    sway = np.sin(2.0 * np.pi * folds * u + 0.5 * np.sin(9.0 * u) * (1.0 - v)) * (1.1 - 0.45 * v)
    points = np.stack((u * width + 0.0 * v, height * v + 0.0 * u, depth * sway), axis=2)
    return sheet(points, uv=np.stack((u * width * 1.6 + 0.0 * v, -height * v + 0.0 * u), axis=2))


def leaf(length, width, droop, cells=(6, 2)):
    """A leaf from the origin along +z, bent down: (triangles, coordinates of a picture whose stem is at the bottom)."""
    t, s = np.linspace(0.0, 1.0, cells[0] + 1)[:, None], np.linspace(-0.5, 0.5, cells[1] + 1)[None]
    y = length * (0.45 * t - droop * t * t) + 0.25 * width * np.abs(s)
    points = np.stack((s * width + 0.0 * t, y, length * t * (1.0 - 0.2 * droop * t) + 0.0 * s), axis=2)
    return sheet(points[:, ::-1], uv=np.stack((0.5 + s + 0.0 * t, 1.0 - t + 0.0 * s), axis=2)[:, ::-1])


def plant(leaves=60, height=1.0, seed=1, cells=(6, 2)):
    """A pot plant, stems from the origin: {"stems": ..., "leaves": (triangles, coordinates)}."""
    rng = np.random.default_rng(seed)
    stems, triangles, coordinates = [], [], []
    for n in range(leaves):
        yaw, up = n * 137.508, height * (0.25 + 0.75 * (n + 0.5) / leaves)
        reach = 0.16 * height * (1.2 - up / height) + 0.03
        t = np.linspace(0.0, 1.0, 7)
        stem = turn(np.stack((0.0 * t, up * t, reach * t**2), axis=1), yaw)
        size = height * (0.24 + 0.12 * rng.random()) * (1.25 - 0.5 * up / height)
        tris, uv = leaf(size, 0.42 * size, 0.45 + 0.5 * rng.random(), cells)
        stems.append(tube(stem, 0.004, 6))
        triangles.append(turn(tris, yaw) + stem[-1])
        coordinates.append(uv)
    return {"stems": np.concatenate(stems), "leaves": (np.concatenate(triangles), np.concatenate(coordinates))}


def books(width, height, depth, seed=1):
    """A row of books on a shelf, x from 0 to width, spines at z = 0: list of (triangles, number of the book)."""
    rng = np.random.default_rng(seed)
    out, x = [], 0.0
    while True:
        thick = 0.018 + 0.034 * rng.random()
        tall, deep = height * (0.68 + 0.3 * rng.random()), depth * (0.75 + 0.2 * rng.random())
        if x + thick > width:
            return out
        book = rounded_box((thick - 0.002, tall, deep), 0.003, 2)
        out.append((book + (x + thick / 2.0, tall / 2.0 + 0.001, -deep / 2.0), len(out)))
        x += thick


def shelf(width, height, depth, boards, thick=0.025):
    """An open shelf before z = 0 ... depth, x round 0: (triangles, heights of the boards' upper sides)."""
    sides = [box((s * width / 2 - thick / 2, -0.002, 0.0), (s * width / 2 + thick / 2, height, depth)) for s in (-1, 1)]
    tops = [0.08 + (height - 0.1) * i / (boards - 1) for i in range(boards)]
    w = width / 2.0 - thick / 2.0 + 0.001  # boards end inside the sides
    boards = [box((-w, y - thick, 0.003), (w, y, depth - 0.004)) for y in tops]
    return np.concatenate(sides + boards), tops


def lampshade(radius=0.16, segments=64):
    """{"shade": an open cone, inside and outside, "bulb": a ball}; the bulb is at the origin."""
    line = [(radius, -0.09), (radius * 0.5, 0.09), (radius * 0.48, 0.09), (radius * 0.975, -0.09), (radius, -0.09)]
    return {"shade": lathe(line, segments), "bulb": sphere((0.0, 0.0, 0.0), 0.030, 24)}


def window(width, height, bars=(2, 2), frame=0.05, depth=0.06):
    """A window round the origin, facing z: {"frame": ..., "glass": closed panes}."""
    w, h = width / 2.0, height / 2.0
    frames = [box((-w, s * h - frame / 2, -depth / 2), (w, s * h + frame / 2, depth / 2)) for s in (-1, 1)]
    frames += [
        box((s * w - frame / 2, -h, -depth / 2 - 1e-3), (s * w + frame / 2, h, depth / 2 + 1e-3)) for s in (-1, 1)
    ]
    xs, ys = np.linspace(-w, w, bars[0] + 1), np.linspace(-h, h, bars[1] + 1)
    frames += [box((x - 0.015, -h, -depth / 3), (x + 0.015, h, depth / 3)) for x in xs[1:-1]]
    frames += [box((-w, y - 0.015, -depth / 3 - 1e-3), (w, y + 0.015, depth / 3 + 1e-3)) for y in ys[1:-1]]
    panes = [box((a + 0.001, c + 0.001, -0.003), (b - 0.001, d - 0.001, 0.003)) for a, b in pairwise(xs) for c, d in pairwise(ys)]
    return {"frame": np.concatenate(frames), "glass": np.concatenate(panes)}


def framed(width, height, border=0.05, depth=0.03):
    """A picture or mirror on a wall behind it (z < 0): {"frame": ..., "picture": (triangles, coordinates over 0 to 1)}."""
    w, h = width / 2.0, height / 2.0
    line = [
        (border, -depth),
        (border, 0.0),
        (border * 0.7, 0.008),
        (border * 0.35, -0.004),
        (0.0, 0.004),
        (-0.002, -0.012),
    ]
    corners = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    frame = np.array([[(sx * (w + o), sy * (h + o), z) for o, z in line] for sx, sy in corners])
    picture = quad((-w, -h, -0.010), (w, -h, -0.010), (w, h, -0.010), (-w, h, -0.010))
    uv = np.array([[(0, 1), (1, 1), (1, 0)], [(0, 1), (1, 0), (0, 0)]], dtype=np.float64)
    return {"frame": sheet(frame, close_u=True), "picture": (picture, uv)}


_CHESS = {
    "pawn": [(0.016, 0.0), (0.017, 0.006), (0.010, 0.012), (0.006, 0.030), (0.010, 0.034), (0.006, 0.036)],
    "rook": [
        (0.019, 0.0),
        (0.020, 0.008),
        (0.012, 0.014),
        (0.010, 0.040),
        (0.014, 0.044),
        (0.014, 0.056),
        (0.0, 0.055),
    ],
    "bishop": [(0.018, 0.0), (0.019, 0.008), (0.010, 0.016), (0.006, 0.046), (0.011, 0.050), (0.005, 0.053)],
    "queen": [(0.021, 0.0), (0.022, 0.009), (0.012, 0.017), (0.007, 0.060), (0.012, 0.066), (0.006, 0.069)],
}


def chess_piece(kind, segments=32, steps=4):
    """pawn, rook, knight, bishop, queen or king."""
    top = {
        "pawn": [(0.010, 0.043), (0.008, 0.051), (0.0, 0.055)],
        "bishop": [(0.010, 0.062), (0.007, 0.073), (0.002, 0.078), (0.003, 0.081), (0.0, 0.083)],
        "queen": [(0.011, 0.084), (0.013, 0.088), (0.004, 0.089), (0.004, 0.094), (0.0, 0.097)],
    }
    name = {"king": "queen", "knight": "pawn"}.get(kind, kind)
    line = [*_CHESS[name], *([] if name == "rook" else top[name])]
    out = [lathe(np.concatenate(([(0.0, 0.0)], curve(line, steps))), segments)]
    if kind == "king":
        out += [
            box((-0.002, 0.094, -0.002), (0.002, 0.112, 0.002)),
            box((-0.006, 0.102, -0.0018), (0.006, 0.106, 0.0018)),
        ]
    if kind == "knight":
        out.append(turn(rounded_box((0.014, 0.022, 0.034), 0.006, steps), 20.0, "x") + (0.0, 0.056, 0.006))
    return np.concatenate(out)


def fruit(radius, segments=32):
    """An apple-like ball with a dent above and below, its lowest point at y = 0."""
    a = np.radians(np.linspace(-90.0, 90.0, segments // 2 + 1))
    r = radius * (1.0 + 0.10 * np.cos(2.0 * a)) - 0.28 * radius * np.exp(
        -(((90.0 - np.degrees(np.abs(a))) / 22.0) ** 2)
    )
    line = np.stack((r * np.cos(a), r * np.sin(a)), axis=1)
    line[[0, -1], 0] = 0.0
    return lathe(line, segments) + (0.0, -line[:, 1].min(), 0.0)


def ring_stand(radius=0.09, segments=64):
    """A coaster: a flat ring."""
    return torus((0.0, 0.006, 0.0), radius, 0.006, segments, 12)
