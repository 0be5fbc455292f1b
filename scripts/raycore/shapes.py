# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Building blocks of the scene generators in `scenes/`: triangle lists (n, 3, 3), outside by the right hand rule.

Points that meet are computed once and shared, so that `scene.smooth_normals` joins them by exact position.
"""

import math

import numpy as np

from raycore.scene import Scene, smooth_normals


class Builder:
    """Collects parts of one material each and makes a `Scene` of them. Normals are smoothed inside a part only."""

    def __init__(self, name):
        self.name = name
        self.materials = []
        self.parts = []  # (triangles, normals, material index)

    def material(self, material):
        """Add a material, return its index."""
        self.materials.append(material)
        return len(self.materials) - 1

    def add(self, triangles, material, crease=40.0):
        """Add triangles; edges sharper than `crease` degrees stay sharp (0: flat)."""
        triangles = np.asarray(triangles, dtype=np.float64).reshape(-1, 3, 3)
        self.parts.append((triangles, smooth_normals(triangles, math.cos(math.radians(crease))), material))

    def scene(self, camera=None, lights=(), **settings):
        """The finished `Scene`; settings as of its fields."""
        index = [np.full(len(t), m, np.int32) for t, _, m in self.parts]
        return Scene(
            self.name,
            np.concatenate([t for t, _, _ in self.parts]),
            np.concatenate([n for _, n, _ in self.parts]),
            np.concatenate(index),
            self.materials,
            camera,
            list(lights),
            **settings,
        )


def sheet(points, close_u=False, close_v=False):
    """Two triangles for each cell of a grid of points (nu, nv, 3), faces towards du x dv; may close on itself.

    Cells that shrink to an edge, as at a pole, give one triangle; cells that shrink to a point none.
    """
    points = np.asarray(points, dtype=np.float64)
    if close_u:
        points = np.concatenate((points, points[:1]))
    if close_v:
        points = np.concatenate((points, points[:, :1]), axis=1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    out = np.stack((np.stack((a, b, c), axis=2), np.stack((a, c, d), axis=2)), axis=2).reshape(-1, 3, 3)
    same = [(out[:, i] == out[:, (i + 1) % 3]).all(axis=1) for i in range(3)]
    return out[~(same[0] | same[1] | same[2])]


def quad(a, b, c, d):
    """Two triangles of a quadrangle given in order."""
    a, b, c, d = (np.asarray(p, dtype=np.float64) for p in (a, b, c, d))
    return np.array([[a, b, c], [a, c, d]])


def box(lo, hi):
    """The 12 triangles of a box, facing out."""
    x0, y0, z0 = lo
    x1, y1, z1 = hi
    return np.concatenate(
        (
            quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
            quad((x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)),
            quad((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
            quad((x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)),
            quad((x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)),
            quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
        )
    )


def lathe(profile, segments, flutes=0, depth=0.0):
    """A profile of (radius, y) turned round the y axis; from bottom to top it faces out.

    flutes: number of grooves that cut `depth` (a part of the radius) into it.
    """
    profile = np.asarray(profile, dtype=np.float64)
    angle = 2.0 * np.pi * np.arange(segments) / segments
    radius = profile[:, 0] * np.ones((segments, 1))
    if flutes:
        radius = radius * (1.0 - depth * np.abs(np.sin(flutes * angle / 2.0))[:, None])
    points = np.stack(
        (
            radius * np.cos(angle)[:, None],
            np.broadcast_to(profile[:, 1], radius.shape),
            radius * np.sin(angle)[:, None],
        ),
        axis=2,
    )
    points[:, profile[:, 0] == 0.0, 0] = 0.0
    points[:, profile[:, 0] == 0.0, 2] = 0.0
    return sheet(points, close_u=True)[:, ::-1]


def sphere(centre, radius, segments=48):
    """A sphere of rings and segments with poles on the y axis."""
    angle = np.pi * (np.arange(segments // 2 + 1) / (segments // 2) - 0.5)
    profile = np.stack((np.cos(angle), np.sin(angle)), axis=1) * radius
    profile[[0, -1], 0] = 0.0
    return lathe(profile, segments) + np.asarray(centre, dtype=np.float64)


def icosphere(levels):
    """Unit sphere: an icosahedron whose triangles are cut in four `levels` times. Returns vertices and faces."""
    g = (1.0 + 5.0**0.5) / 2.0
    vertices = np.array([[s * a, t * b, 0.0] for a, b in ((1.0, g),) for s in (-1, 1) for t in (-1, 1)])
    vertices = np.concatenate([np.roll(vertices, k, axis=1) for k in range(3)])
    # Faces: triples of vertices at the edge length 2 from each other, turned outwards.
    near = np.abs(np.linalg.norm(vertices[:, None] - vertices[None], axis=2) - 2.0) < 1e-9
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    faces = np.array(faces)
    corner = vertices[faces]
    inwards = (
        np.einsum("ij,ij->i", np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), corner[:, 0]) < 0.0
    )
    faces[inwards] = faces[inwards][:, ::-1]
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    for _ in range(levels):
        edges = np.sort(np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]])), axis=1)
        unique, index = np.unique(edges, axis=0, return_inverse=True)
        middle = vertices[unique].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        ab, bc, ca = (index.reshape(-1) + len(vertices)).reshape(3, -1)
        a, b, c = faces.T
        faces = np.concatenate([np.stack(f, axis=1) for f in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        vertices = np.concatenate((vertices, middle))
    return vertices, faces


def tube(path, radius, sides=12, close=False):
    """A round bar along points (n, 3). The cross section is carried along without twist (parallel transport)."""
    path = np.asarray(path, dtype=np.float64)
    ahead = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    if not close:
        ahead[0], ahead[-1] = path[1] - path[0], path[-1] - path[-2]
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead[0], np.eye(3)[np.argmin(np.abs(ahead[0]))])
    angle = 2.0 * np.pi * np.arange(sides) / sides
    rings = []
    for at, t in zip(path, ahead):
        side = side - t * (side @ t)
        side /= np.linalg.norm(side)
        up = np.cross(t, side)
        rings.append(at + radius * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up))
    return sheet(np.array(rings), close_u=close, close_v=True)[:, ::-1]


def torus(centre, radius, thickness, segments=96, sides=32):
    """A ring that lies flat (axis y)."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    path = np.stack((radius * np.cos(angle), np.zeros(segments), radius * np.sin(angle)), axis=1)
    return tube(path, thickness, sides, close=True) + np.asarray(centre, dtype=np.float64)


def rounded_box(size, radius, steps=8):
    """A box of `size` round the origin with rounded edges and corners: a sphere whose octants are pulled apart."""
    half = np.asarray(size, dtype=np.float64) / 2.0 - radius
    n = 4 * steps
    angle_v = np.pi * (np.arange(2 * steps + 1) / (2 * steps) - 0.5)
    angle_u = 2.0 * np.pi * np.arange(n) / n
    # The middle of each edge of the octants is doubled: once for each side that is pulled.
    rows = np.concatenate((np.arange(steps + 1), np.arange(steps, 2 * steps + 1)))
    columns = np.concatenate([np.arange(q * steps, (q + 1) * steps + 1) for q in range(4)]) % n
    high = np.concatenate((np.full(steps + 1, -1.0), np.full(steps + 1, 1.0)))
    quarter = np.repeat(np.arange(4), steps + 1)
    sx, sz = np.array([1.0, -1.0, -1.0, 1.0])[quarter], np.array([1.0, 1.0, -1.0, -1.0])[quarter]
    cos_v, sin_v = np.cos(angle_v)[rows], np.sin(angle_v)[rows]
    cos_v[[0, -1]] = 0.0
    points = np.stack(
        (
            sx[:, None] * half[0] + radius * np.cos(angle_u)[columns][:, None] * cos_v,
            np.broadcast_to(high * half[1] + radius * sin_v, (len(columns), len(rows))),
            sz[:, None] * half[2] + radius * np.sin(angle_u)[columns][:, None] * cos_v,
        ),
        axis=2,
    )
    side = sheet(points, close_u=True)[:, ::-1]
    caps = [
        points[:, 0][[0, steps + 1, 2 * steps + 2, 3 * steps + 3]],
        points[:, -1][[0, steps + 1, 2 * steps + 2, 3 * steps + 3]],
    ]
    return np.concatenate((side, quad(*caps[0]), quad(*caps[1][::-1])))


def turn(triangles, degrees, axis="y"):
    """Triangles turned round an axis through the origin."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    matrix = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }[axis]
    return triangles @ np.array(matrix, dtype=np.float64).T


def noise(points, seed=1, octaves=4, scale=1.0, gain=0.5):
    """Smooth pseudo-random values in about [-1, 1] at points (n, 3): gradient noise summed over octaves (Perlin 1985)."""
    rng = np.random.default_rng(seed)
    table = rng.permutation(256)
    gradient = rng.normal(0.0, 1.0, (256, 3))
    gradient /= np.linalg.norm(gradient, axis=1, keepdims=True)
    total, weight = np.zeros(len(points)), 1.0
    for octave in range(octaves):
        p = points * (scale * 2.0**octave) + 17.3 * octave
        cell = np.floor(p).astype(np.int64)
        f = p - cell
        fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
        value = np.zeros(len(points))
        for corner in np.ndindex(2, 2, 2):
            at = cell + corner
            hashed = table[(table[(table[at[:, 0] & 255] + at[:, 1]) & 255] + at[:, 2]) & 255]
            part = np.einsum("ij,ij->i", gradient[hashed], f - corner)
            for axis in range(3):
                part = part * (fade[:, axis] if corner[axis] else 1.0 - fade[:, axis])
            value += part
        total += weight * value
        weight *= gain
    return 1.6 * total
