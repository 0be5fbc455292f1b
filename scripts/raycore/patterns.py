# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Pictures for the textures of our scenes, computed: (height, width, 4) uint8 RGBA, sRGB, and periodic unless said otherwise.

Colours are sRGB in [0, 1]. Sides are powers of two, so that nothing has to be scaled.
"""

import numpy as np


def cloud(shape, seed, fall=1.0, stretch=(1.0, 1.0)):
    """Periodic noise in [0, 1]: white noise whose spectrum falls with frequency; stretch (along v, along u) smears it."""
    white = np.random.default_rng(seed).normal(0.0, 1.0, shape)
    fy = np.fft.fftfreq(shape[0])[:, None] * shape[0] * stretch[0]
    fx = np.fft.fftfreq(shape[1])[None] * shape[1] * stretch[1]
    out = np.fft.ifft2(np.fft.fft2(white) / (1.0 + np.hypot(fy, fx)) ** (1.0 + fall)).real
    lo, hi = np.percentile(out, (0.5, 99.5))
    return np.clip((out - lo) / (hi - lo), 0.0, 1.0)


def mix(a, b, t):
    """Colours from a to b by t (h, w)."""
    t = np.asarray(t)[..., None]
    return np.asarray(a) * (1.0 - t) + np.asarray(b) * t


def to_image(rgb, alpha=1.0):
    """Floats in [0, 1] (h, w, 3) to RGBA bytes."""
    rgba = np.concatenate((rgb, np.broadcast_to(alpha, rgb.shape[:2])[..., None]), axis=2)
    return np.round(np.clip(rgba, 0.0, 1.0) * 255.0).astype(np.uint8)


def _grid(height, width):
    """v and u of the texels' centres."""
    return (np.arange(height)[:, None] + 0.5) / height, (np.arange(width)[None] + 0.5) / width


def checker(a, b, cells=8, size=256):
    """Squares of two colours."""
    v, u = _grid(size, size)
    return to_image(mix(a, b, (np.floor(u * cells) + np.floor(v * cells)) % 2))


def tiles(a, b, grout, cells=4, joint=0.035, size=256, seed=1):
    """Square tiles, alternately of two colours, each a little different, with rounded looking edges and joints."""
    v, u = _grid(size, size)
    i, j = np.floor(v * cells).astype(int), np.floor(u * cells).astype(int)
    edge = np.minimum(
        np.minimum(u * cells % 1.0, 1.0 - u * cells % 1.0), np.minimum(v * cells % 1.0, 1.0 - v * cells % 1.0)
    )
    tint = 1.0 + 0.10 * (np.random.default_rng(seed).random((cells, cells))[i, j] - 0.5)
    tint = tint * (0.94 + 0.10 * cloud((size, size), seed + 1))
    colour = mix(a, b, (i + j) % 2) * (tint * (0.86 + 0.14 * np.clip((edge - joint) / 0.05, 0.0, 1.0)))[..., None]
    return to_image(mix(grout, colour, np.clip((edge - joint) * 60.0 + 0.5, 0.0, 1.0)))


def wood(light, dark, rings=7, height=256, width=256, seed=1):
    """Boards cut along the trunk: the grain runs along u."""
    v, _ = _grid(height, width)
    warp = cloud((height, width), seed, 1.6, (1.0, 5.0))
    ring = 0.5 + 0.5 * np.sin(2.0 * np.pi * (rings * v + 2.2 * warp))
    fibre = cloud((height, width), seed + 1, 0.0, (0.15, 8.0))
    return to_image(mix(light, dark, 0.55 * ring**2 + 0.45 * fibre))


def parquet(light, dark, rows=8, columns=2, size=512, seed=3):
    """Boards laid in rows, shifted against each other; the grain runs along u."""
    v, u = _grid(size, size)
    rng = np.random.default_rng(seed)
    row = np.floor(v * rows).astype(int)
    along = (u + rng.random(rows)[row]) * columns
    column = np.floor(along).astype(int) % columns
    grain = wood(light, dark, rows * 2, size, size, seed)[..., :3] / 255.0
    shade = 0.78 + 0.34 * rng.random((rows, columns))[row, column]
    # Each board shows another part of the trunk.
    shift = rng.integers(0, size, (rows, columns))[row, column]
    grain = grain[np.broadcast_to(np.arange(size)[:, None], shift.shape), (np.arange(size)[None] + shift) % size]
    joint = np.minimum(
        np.minimum(v * rows % 1.0, 1.0 - v * rows % 1.0) / rows, np.minimum(along % 1.0, 1.0 - along % 1.0) / columns
    )
    return to_image(grain * (shade * (0.35 + 0.65 * np.clip(joint * size / 1.5, 0.0, 1.0)))[..., None])


def marble(base, vein, size=256, seed=5):
    """Stone with veins."""
    v, u = _grid(size, size)
    warp = cloud((size, size), seed, 0.9)
    line = np.abs(np.sin(np.pi * (2.0 * u + v + 2.6 * warp)))
    return to_image(
        mix(base, vein, np.clip(1.0 - 2.6 * line**0.6, 0.0, 1.0) * 0.8 + 0.2 * cloud((size, size), seed + 1, 0.4))
    )


def plaster(colour, rough=0.10, size=128, seed=7):
    """A painted wall, slightly uneven."""
    return to_image(np.asarray(colour) * (1.0 - rough * cloud((size, size), seed, 0.2))[..., None])


def weave(warp, weft, threads=32, size=256, seed=9):
    """Cloth: threads over and under each other."""
    v, u = _grid(size, size)
    over = (np.floor(u * threads) + np.floor(v * threads)) % 2
    round_u, round_v = np.sin(np.pi * (u * threads % 1.0)), np.sin(np.pi * (v * threads % 1.0))
    light = np.where(over > 0, round_u, round_v) * 0.45 + 0.55
    return to_image(mix(warp, weft, over) * (light * (0.9 + 0.1 * cloud((size, size), seed)))[..., None])


def wallpaper(base, motif, columns=4, size=256):
    """Rosettes in a half-drop repeat between thin stripes."""
    v, u = _grid(size, size)
    x = (u * columns) % 1.0 - 0.5
    y = (v * columns + 0.5 * (np.floor(u * columns) % 2)) % 1.0 - 0.5
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    petal = r < 0.24 + 0.10 * np.cos(6.0 * angle)
    ring = np.abs(r - 0.07) < 0.025
    stripe = np.abs(np.abs(x) - 0.48) < 0.012
    return to_image(mix(base, motif, np.clip(petal * 0.8 - ring * 0.6, 0.0, 1.0) + 0.5 * stripe))


def rug(field, border, accent, height=512, width=256, seed=11):
    """A carpet with a border and medallions; not periodic."""
    v, u = _grid(height, width)
    x, y = (u - 0.5) * width / height, v - 0.5
    edge = np.minimum(np.minimum(u, 1.0 - u) * width / height, np.minimum(v, 1.0 - v))
    diamond = (np.abs(x) * 16.0 % 1.0 - 0.5) ** 2 + (y * 16.0 % 1.0 - 0.5) ** 2 < 0.06
    medallion = np.hypot(x * 1.6, y) - 0.03 * np.cos(8.0 * np.arctan2(y, x * 1.6))
    colour = mix(field, accent, 0.8 * diamond)
    colour = np.where(((medallion < 0.22) & (medallion > 0.19))[..., None], accent, colour)
    colour = np.where((medallion <= 0.19)[..., None], mix(border, accent, np.sin(medallion * 90.0) > 0.3), colour)
    zigzag = np.abs((u * width / height + v) * 24.0 % 1.0 - 0.5) < 0.25
    colour = np.where((edge < 0.07)[..., None], mix(border, accent, 0.85 * zigzag), colour)
    colour = np.where((np.abs(edge - 0.075) < 0.006)[..., None], accent, colour)
    return to_image(colour * (0.82 + 0.18 * np.random.default_rng(seed).random((height, width)))[..., None])


def text(paper, ink, rows=16, columns=32, cell=8, seed=13):
    """Rows of made-up letters, each a symmetric pattern of 5 x 5 dots, in words."""
    rng = np.random.default_rng(seed)
    half = rng.random((40, 5, 3)) < 0.55
    letters = np.concatenate((half, half[:, :, 1::-1]), axis=2)
    page = np.zeros((rows, columns, cell, cell), bool)
    page[:, :, 1:6, 1:6] = letters[rng.integers(0, 40, (rows, columns))]
    page &= (rng.random((rows, columns)) > 0.16)[:, :, None, None]
    page[:, 0] = page[:, -1] = False
    return to_image(mix(paper, ink, page.transpose(0, 2, 1, 3).reshape(rows * cell, columns * cell)))


def leaf(light, dark, height=128, width=64):
    """A leaf, stem at the bottom; alpha cuts it out. Not periodic. Colour reaches beyond the edge, as filters need."""
    v, u = _grid(height, width)
    x, y = np.abs(u - 0.5) * 2.0, 1.0 - v
    outline = 0.92 * np.sin(np.pi * np.clip(y, 0.0, 1.0) ** 0.75) ** 0.8
    teeth = 0.05 * np.abs((y * 14.0) % 1.0 - 0.5)
    inside = x < outline - teeth
    rib = (x < 0.05) | (np.abs((y - 0.45 * x) * 9.0 % 1.0 - 0.5) < 0.05)
    return to_image(mix(light, dark, 0.75 - 0.75 * rib - 0.3 * x), inside.astype(np.float64))


def painting(height=128, width=256, seed=17):
    """A landscape: sky, sun, two ranges of hills, a lake. Not periodic."""
    v, u = _grid(height, width)
    sky = mix((0.96, 0.80, 0.55), (0.42, 0.62, 0.82), np.clip(1.0 - 1.7 * v, 0.0, 1.0) + 0.0 * u)
    sky = mix(sky, (1.0, 0.98, 0.92), 0.5 * cloud((height, width), seed, 1.0, (3.0, 1.0)) ** 2)
    sky = np.where((np.hypot((u - 0.7) * width / height, v - 0.32) < 0.07)[..., None], (1.0, 0.93, 0.7), sky)
    for level, rough, colour in ((0.52, 0.22, (0.38, 0.45, 0.55)), (0.64, 0.16, (0.20, 0.34, 0.24))):
        ridge = level + rough * (cloud((4, width), seed + int(100 * level), 1.0)[0] - 0.5)
        sky = np.where((v > ridge)[..., None], np.asarray(colour) * (0.8 + 0.4 * (v - level))[..., None], sky)
    lake = v > 0.78 + 0.0 * u
    ripple = 0.7 + 0.3 * np.sin(140.0 * v**2 + 4.0 * cloud((height, width), seed + 2))
    return to_image(np.where(lake[..., None], mix((0.25, 0.38, 0.48), (0.85, 0.74, 0.58), 0.5 * ripple), sky))
