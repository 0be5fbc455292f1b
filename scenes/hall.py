# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A Gothic hall: a nave between two aisles, columns, pointed arches, ribbed vaults, an apse, coloured windows, sunlight.

The nave runs along z from the entrance (z = 0) to the apse; x is across, y up; units are metres.
"""

import numpy as np

from raycore.scene import Camera, Light, make_material
from raycore.shapes import Builder, lathe, quad, sheet, tube

BAYS = 7
BAY = 4.2  # along the nave
NAVE = 4.4  # half width, to the axis of the columns
AISLE = 8.4  # half width, to the outer walls
LENGTH = BAYS * BAY
SPRING = 5.2  # arcade arches start here, on the capitals
ARCADE_RISE = 2.3
SILL = 8.9  # windows above the arcade
HIGH_SPRING = 10.4  # the high vault starts here
VAULT_RISE = 4.4
AISLE_SPRING, AISLE_RISE = 5.2, 2.2
WALL = 0.55  # half thickness of the arcade wall


def pointed(s):
    """Height of an equilateral pointed arch over its span s in [0, 1]: 0 at the ends, 1 at the apex."""
    s = np.minimum(s, 1.0 - s)
    return np.sqrt(np.maximum(1.0 - (1.0 - s) ** 2, 0.0)) / np.sqrt(0.75)


def span(n):
    """n + 1 stations over a span, closer at the ends, where a pointed arch is steep."""
    t = np.linspace(0.0, 1.0, n + 1)
    return 0.5 * (1.0 - np.cos(np.pi * t)) * 0.6 + 0.4 * t


def plane(z, y0, y1, x, steps=1):
    """A wall at x over stations z between heights y0 and y1, facing +x."""
    t = np.linspace(0.0, 1.0, steps + 1)
    y = y0[:, None] + (y1 - y0)[:, None] * t
    points = np.stack((np.full_like(y, x), y, np.broadcast_to(z[:, None], y.shape)), axis=2)
    return sheet(points)[:, ::-1]


def mirror(triangles):
    """The other side of the hall; faces keep their outside."""
    return (triangles * (-1.0, 1.0, 1.0))[:, ::-1]


def column():
    """A fluted column with base and capital, up to the springing of the arches."""
    base = [(0.0, 0.0), (0.78, 0.0), (0.78, 0.22), (0.70, 0.30), (0.74, 0.38), (0.74, 0.46), (0.62, 0.56), (0.56, 0.62)]
    neck = SPRING - 0.85
    capital = [(0.50, neck), (0.58, neck + 0.06), (0.50, neck + 0.12), (0.54, neck + 0.25), (0.66, neck + 0.46)]
    capital += [(0.80, neck + 0.60), (0.80, neck + 0.66), (0.86, neck + 0.72), (0.86, neck + 0.85), (0.0, neck + 0.85)]
    shaft = [(0.50, y) for y in np.linspace(0.64, neck - 0.04, 5)]
    return np.concatenate((lathe(base, 48), lathe(shaft, 96, flutes=12, depth=0.14), lathe(capital, 48)))


def arch_path(z0, z1, spring, rise, x, n=32):
    s = span(n)
    return np.stack((np.full_like(s, x), spring + rise * pointed(s), z0 + (z1 - z0) * s), axis=1)


def arcade_bay(z0):
    """Wall above one arch of the arcade, both faces, and the underside of the arch."""
    s = span(36)
    clear = 0.62  # the arch stands on the capitals, not on the axes of the columns
    z = z0 + clear + (BAY - 2.0 * clear) * s
    low = SPRING + ARCADE_RISE * pointed(s)
    z = np.concatenate(([z0], z, [z0 + BAY]))
    low = np.concatenate(([SPRING], low, [SPRING]))
    top = np.full_like(z, SILL)
    inner, outer = NAVE - WALL, NAVE + WALL
    under = np.stack([np.stack((np.full_like(z, x), low, z), axis=1) for x in np.linspace(inner, outer, 5)], axis=1)
    face = plane(z, low, top, inner, 3)[:, ::-1]
    return np.concatenate((face, plane(z, low, top, outer, 2), sheet(under)))


def high_wall_bay(z0):
    """The wall between arcade and vault, with an open pointed window; its top follows the vault."""
    s = span(40)
    z = z0 + BAY * s
    top = HIGH_SPRING + VAULT_RISE * pointed(s)
    w0, w1, sill, spring, rise = z0 + 1.15, z0 + BAY - 1.15, SILL + 0.5, 11.3, 1.65
    edges = np.array([w0, w1])
    z = np.unique(np.concatenate((z, edges)))
    top = HIGH_SPRING + VAULT_RISE * pointed((z - z0) / BAY)
    out = []
    x_in, x_out = NAVE - 0.25, NAVE + 0.30
    window = (z >= w0) & (z <= w1)
    arch = spring + rise * pointed(np.clip((z - w0) / (w1 - w0), 0.0, 1.0))
    bottom = np.full_like(z, SILL)
    for x, flip in ((x_in, True), (x_out, False)):
        for part in (z <= w0, z >= w1):
            piece = plane(z[part], bottom[part], top[part], x, 4)
            out.append(piece[:, ::-1] if flip else piece)
        below = plane(z[window], bottom[window], np.full(window.sum(), sill), x)
        above = plane(z[window], arch[window], top[window], x, 2)
        out += [below[:, ::-1], above[:, ::-1]] if flip else [below, above]
    zw, aw = z[window], arch[window]
    frame = np.concatenate(([(sill, w0)], np.stack((aw, zw), axis=1), [(sill, w1)]))  # jambs and arch
    reveal = np.stack(
        [np.stack((np.full(len(frame), x), frame[:, 0], frame[:, 1]), axis=1) for x in (x_in, x_out)], axis=1
    )
    out.append(sheet(reveal))
    out.append(quad((x_in, sill, w0), (x_in, sill, w1), (x_out, sill, w1), (x_out, sill, w0)))
    ledge = quad((x_in, SILL, z0), (x_in, SILL, z0 + BAY), (NAVE - WALL, SILL, z0 + BAY), (NAVE - WALL, SILL, z0))
    out.append(ledge[:, ::-1])
    mullion = lathe([(0.06, 0.0), (0.06, spring + rise - sill)], 10) + (NAVE, sill, z0 + BAY / 2.0)
    return np.concatenate(out), mullion


def vault(x0, x1, z0, z1, spring, rise, n):
    """A groin vault: the higher one of two pointed barrels, seen from below."""
    s = span(n)
    y = spring + rise * np.maximum(pointed(s)[:, None], pointed(s)[None, :])
    x, z = np.meshgrid(x0 + (x1 - x0) * s, z0 + (z1 - z0) * s, indexing="ij")
    return sheet(np.stack((x, y, z), axis=2))


def ribs(x0, x1, z0, z1, spring, rise, thick, n=28):
    """Two diagonal ribs of a vault."""
    s = span(n)
    y = spring + rise * pointed(s) - 0.03
    x, z = x0 + (x1 - x0) * s, z0 + (z1 - z0) * s
    return np.concatenate(
        (tube(np.stack((x, y, z), axis=1), thick, 8), tube(np.stack((x, y, z[::-1]), axis=1), thick, 8))
    )


def outer_wall_bay(z0):
    """Aisle wall with a recessed window; returns wall, glass panes as (triangles, colour number), and tracery."""
    s = span(32)
    w0, w1, sill, spring, rise = z0 + 0.95, z0 + BAY - 0.95, 1.9, 4.6, 1.9
    z = np.unique(np.concatenate((z0 + BAY * s, [w0, w1])))
    top = AISLE_SPRING + AISLE_RISE * pointed((z - z0) / BAY)
    window = (z >= w0) & (z <= w1)
    arch = spring + rise * pointed(np.clip((z - w0) / (w1 - w0), 0.0, 1.0))
    zero, level = np.zeros_like(z), np.full_like(z, sill)
    wall = [plane(z[p], zero[p], top[p], AISLE, 4)[:, ::-1] for p in (z <= w0, z >= w1)]
    wall += [plane(z[window], zero[window], level[window], AISLE, 2)[:, ::-1]]
    wall += [plane(z[window], arch[window], np.maximum(top, arch)[window], AISLE)[:, ::-1]]
    frame = np.concatenate(([(sill, w0)], np.stack((arch, z), axis=1)[window], [(sill, w1)]))
    deep = AISLE + 0.45
    reveal = np.stack(
        [np.stack((np.full(len(frame), x), frame[:, 0], frame[:, 1]), axis=1) for x in (AISLE, deep)], axis=1
    )
    wall += [sheet(reveal), quad((AISLE, sill, w0), (AISLE, sill, w1), (deep, sill, w1), (deep, sill, w0))]
    panes, bars = [], []
    columns, rows = 4, 9
    zs, ys = np.linspace(w0, w1, columns + 1), np.linspace(sill, spring + rise, rows + 1)
    for i in range(columns):
        for j in range(rows):
            fine = np.linspace(zs[i], zs[i + 1], 7)
            limit = spring + rise * pointed((fine - w0) / (w1 - w0))
            y0, y1 = np.minimum(ys[j], limit), np.minimum(ys[j + 1], limit)
            pane = plane(fine, y0, y1, deep - 0.05)[:, ::-1]
            if len(pane):
                panes.append((pane, (3 * i + 5 * j + i * j) % 5))
    for i in range(1, columns):
        height = spring + rise * pointed((zs[i] - w0) / (w1 - w0)) - sill
        bars.append(lathe([(0.05, 0.0), (0.05, height)], 8) + (deep - 0.08, sill, zs[i]))
    bars.append(tube(np.stack((np.full(window.sum(), deep - 0.1), arch[window] - 0.03, z[window]), axis=1), 0.07, 8))
    return np.concatenate(wall), panes, np.concatenate(bars)


def apse(radius, n=40):
    """Half a cylinder and half a dome behind the last bay, and ribs on the dome."""
    angle = np.linspace(0.0, np.pi, n + 1)
    y = np.concatenate(
        (
            np.linspace(0.0, HIGH_SPRING, 9),
            [HIGH_SPRING + VAULT_RISE * v for v in np.sin(np.linspace(0.0, np.pi / 2, 15))[1:]],
        )
    )
    r = np.concatenate((np.full(9, radius), radius * np.cos(np.linspace(0.0, np.pi / 2, 15))[1:]))
    r[-1] = 0.0
    points = np.stack(
        (r * np.cos(angle)[:, None], np.broadcast_to(y, (n + 1, len(y))), LENGTH + r * np.sin(angle)[:, None]), axis=2
    )
    points[:, -1, 0], points[:, -1, 2] = 0.0, LENGTH
    wall = sheet(points)
    bones = [tube(points[i] * (0.99, 1.0, 1.0) + (0.0, 0.0, -0.05), 0.10, 8) for i in range(5, n, 5)]
    return wall, np.concatenate(bones)


def build():
    b = Builder("hall")
    stone = b.material(make_material("stone", (0.56, 0.50, 0.41), ambient_light=0.20))
    pale = b.material(make_material("pale stone", (0.66, 0.61, 0.52), (0.05, 0.05, 0.05), 16.0, ambient_light=0.20))
    ceiling = b.material(make_material("plaster", (0.42, 0.47, 0.52), ambient_light=0.24))
    rib = b.material(make_material("ribs", (0.62, 0.50, 0.33), (0.10, 0.09, 0.07), 16.0, ambient_light=0.20))
    tiles = [
        b.material(make_material("light tile", (0.50, 0.46, 0.40), (0.25, 0.25, 0.25), 64.0, ambient_light=0.16)),
        b.material(make_material("dark tile", (0.20, 0.10, 0.08), (0.25, 0.25, 0.25), 64.0, ambient_light=0.16)),
    ]
    apse_paint = b.material(make_material("apse", (0.18, 0.22, 0.40), ambient_light=0.26))
    lead = b.material(make_material("lead", (0.10, 0.10, 0.11), (0.2, 0.2, 0.2), 16.0))
    gold = b.material(make_material("gold", (0.60, 0.42, 0.12), (0.6, 0.5, 0.3), 32.0, ambient_light=0.20))
    carpet = b.material(make_material("carpet", (0.42, 0.05, 0.06), ambient_light=0.16))
    colours = ((0.75, 0.12, 0.10), (0.10, 0.22, 0.75), (0.90, 0.62, 0.12), (0.12, 0.55, 0.25), (0.50, 0.20, 0.60))
    glass = [b.material(make_material(f"glass {i}", (0.02, 0.02, 0.02), emission=c)) for i, c in enumerate(colours)]

    # Floor: tiles of 1.05 m, a carpet along the nave.
    xs, zs = np.linspace(-AISLE, AISLE, 17), np.linspace(0.0, LENGTH, BAYS * 4 + 1)
    for i in range(16):
        for j in range(BAYS * 4):
            b.add(
                quad((xs[i], 0, zs[j]), (xs[i], 0, zs[j + 1]), (xs[i + 1], 0, zs[j + 1]), (xs[i + 1], 0, zs[j])),
                tiles[(i + j) % 2],
            )
    half = np.linspace(0.0, np.pi, 33)
    ring = np.stack((NAVE * np.cos(half), np.zeros(33), LENGTH + NAVE * np.sin(half)), axis=1)
    b.add(np.stack((np.broadcast_to((0.0, 0.0, LENGTH), (32, 3)), ring[1:], ring[:-1]), axis=1), tiles[0])
    b.add(quad((-0.9, 0.012, 1.0), (-0.9, 0.012, LENGTH), (0.9, 0.012, LENGTH), (0.9, 0.012, 1.0)), carpet)

    # Columns, and the thin shafts that rise from their capitals to the high vault.
    for n in range(BAYS + 1):
        for side in (-1.0, 1.0):
            b.add(column() + (side * NAVE, 0.0, n * BAY), pale, crease=35.0)
            shaft = lathe([(0.13, SPRING), (0.13, HIGH_SPRING - 0.3), (0.24, HIGH_SPRING), (0.0, HIGH_SPRING)], 16)
            b.add(shaft + (side * (NAVE - WALL - 0.05), 0.0, n * BAY), rib)

    for n in range(BAYS):
        z0, z1 = n * BAY, (n + 1) * BAY
        wall, mullion = high_wall_bay(z0)
        outside, panes, bars = outer_wall_bay(z0)
        bay = [
            (arcade_bay(z0), stone, 40.0),
            (wall, stone, 40.0),
            (mullion, pale, 40.0),
            (tube(arch_path(z0 + 0.62, z1 - 0.62, SPRING, ARCADE_RISE, NAVE - WALL), 0.11, 10), rib, 80.0),
            (tube(arch_path(z0 + 0.62, z1 - 0.62, SPRING, ARCADE_RISE, NAVE), 0.16, 10), pale, 80.0),
            (tube(arch_path(z0 + 0.62, z1 - 0.62, SPRING, ARCADE_RISE, NAVE + WALL), 0.11, 10), rib, 80.0),
            (tube(np.array([(NAVE - WALL, SILL, z) for z in np.linspace(z0, z1, 9)]), 0.10, 10), rib, 80.0),
            (vault(NAVE + 0.3, AISLE, z0, z1, AISLE_SPRING, AISLE_RISE, 16), ceiling, 30.0),
            (ribs(NAVE + 0.3, AISLE, z0, z1, AISLE_SPRING, AISLE_RISE, 0.09, 20), rib, 80.0),
            (outside, stone, 40.0),
            (bars, lead, 40.0),
            *((pane, glass[colour], 0.0) for pane, colour in panes),
        ]
        for triangles, material, crease in bay:
            b.add(triangles, material, crease)
            b.add(mirror(triangles), material, crease)
        b.add(vault(-NAVE + 0.25, NAVE - 0.25, z0, z1, HIGH_SPRING, VAULT_RISE, 24), ceiling, 30.0)
        b.add(ribs(-NAVE + 0.25, NAVE - 0.25, z0, z1, HIGH_SPRING, VAULT_RISE, 0.13), rib, 80.0)

    # Transverse arches of nave and aisles.
    s = span(36)
    for n in range(BAYS + 1):
        x = (NAVE - 0.25) * (2.0 * s - 1.0)
        path = np.stack((x, HIGH_SPRING + VAULT_RISE * pointed(s) - 0.04, np.full_like(s, n * BAY)), axis=1)
        b.add(tube(path, 0.20, 10), rib, 80.0)
        x = NAVE + 0.3 + (AISLE - NAVE - 0.3) * s
        path = np.stack((x, AISLE_SPRING + AISLE_RISE * pointed(s) - 0.03, np.full_like(s, n * BAY)), axis=1)
        b.add(tube(path, 0.14, 10), rib, 80.0)
        b.add(mirror(tube(path, 0.14, 10)), rib, 80.0)

    # Ends: the entrance wall, the walls of the aisles, the apse with its steps and altar.
    b.add(quad((-AISLE, 0, 0), (AISLE, 0, 0), (AISLE, 15.5, 0), (-AISLE, 15.5, 0)), stone)
    for side in (-1.0, 1.0):
        end = quad(
            (side * NAVE, 0, LENGTH), (side * AISLE, 0, LENGTH), (side * AISLE, 8, LENGTH), (side * NAVE, 8, LENGTH)
        )
        b.add(end[:, ::-1] if side > 0 else end, stone)
    wall, bones = apse(NAVE - 0.25)
    b.add(wall, apse_paint, crease=30.0)
    b.add(bones, gold, crease=80.0)
    steps = [(0.0, 0.54), (1.5, 0.54), (1.5, 0.36), (1.9, 0.36), (1.9, 0.18), (2.3, 0.18), (2.3, 0.0)]
    b.add(lathe(steps[::-1], 64) + (0.0, 0.0, LENGTH + 1.2), pale, crease=20.0)
    altar = [
        (0.0, 0.54),
        (0.62, 0.54),
        (0.62, 0.64),
        (0.42, 0.78),
        (0.34, 1.20),
        (0.46, 1.44),
        (0.70, 1.52),
        (0.70, 1.62),
        (0.0, 1.62),
    ]
    b.add(lathe(altar, 64) + (0.0, 0.0, LENGTH + 1.2), gold, crease=30.0)

    sun = np.array([0.50, 0.80, 0.22])
    lights = [
        Light(tuple(sun / np.linalg.norm(sun)), (1.30, 1.12, 0.85), directional=True),
        Light((0.0, 6.5, LENGTH - 4.0), (0.95, 0.70, 0.42), attenuation=(0.6, 0.05, 0.004)),
        Light((0.6, 6.0, 0.8), (0.62, 0.66, 0.74), attenuation=(0.7, 0.04, 0.003)),
    ]
    camera = Camera((-1.3, 2.1, 1.2), (0.3, 4.6, 16.0), fov=64.0)
    return b.scene(camera, lights, background=(0.62, 0.74, 0.90))
