# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Building blocks of the scene generators in `scenes/`: triangle lists (n, 3, 3), outside by the right hand rule.

Points that meet are computed once and shared, so that `scene.smooth_normals` joins them by exact position. Texture
coordinates (n, 3, 2) come from `sheet`, or from a mapping (`plane_map` and so on): a function of triangles, which takes the
size of one repeat of the picture in the scene's units; v grows downwards, as in `Texture`.
"""

import math

import numpy as np

from raycore.scene import AMBIENT_LIGHT, Scene, Texture, make_material, smooth_normals


class Builder:
    """Collects parts of one material each and makes a `Scene` of them. Normals are smoothed inside a part only."""

    def __init__(self, name, ambient_light=AMBIENT_LIGHT):
        self.name = name
        self.ambient_light = ambient_light  # of what `paint` makes
        self.materials = []
        self.parts = []  # (triangles, normals, material index, texture coordinates or None)

    def material(self, material):
        """Add a material, return its index."""
        self.materials.append(material)
        return len(self.materials) - 1

    def paint(self, name, image=None, colour=(1.0, 1.0, 1.0), shine=0.0, sharpness=32.0, wrap="repeat", **more):
        """Add a dull or glossy material, with a picture (H, W, 4) if given. more: fields of `Texture` or of `Material`."""
        settings = {k: more.pop(k) for k in ("srgb", "compact", "wrap_s", "wrap_t") if k in more}
        if image is not None:
            more["texture"] = Texture(image, **{"wrap_s": wrap, "wrap_t": wrap, "name": name, **settings})
        more.setdefault("ambient_light", self.ambient_light)
        return self.material(make_material(name, colour, (shine,) * 3, sharpness, **more))

    def varnish(self, name, *args, **more):
        """Add a paint under a clear coat: it mirrors at grazing angles."""
        return self.paint(name, *args, reflect=(0.05,) * 3, fresnel=True, **more)

    def metal(self, name, colour, share, rest=0.1, sharpness=128.0):
        """Add a mirror that reflects a share of its colour, and scatters the rest."""
        reflect, dull = tuple(share * c for c in colour), tuple(rest * c for c in colour)
        return self.material(make_material(name, dull, (0.7,) * 3, sharpness, reflect=reflect))

    def glass(self, name, through, ior=1.5, sharpness=256.0):
        """Add glass; what it bounds must be closed. through: what each surface lets pass, at normal incidence."""
        optics = dict(reflect=(0.04,) * 3, transmit=through, ior=ior, fresnel=True)
        return self.material(make_material(name, (0.0,) * 3, (0.7,) * 3, sharpness, **optics))

    def glow(self, name, colour):
        """Add what shines by itself, and lights nothing."""
        return self.material(make_material(name, (0.0,) * 3, emission=colour))

    def add(self, triangles, material, crease=40.0, uv=None, at=None, yaw=0.0):
        """Add triangles; edges sharper than `crease` degrees stay sharp (0: flat).

        material: its index or its name. uv: (n, 3, 2) or a mapping. Afterwards the part is turned by `yaw` degrees round
        the y axis and moved to `at`.
        """
        triangles = np.asarray(triangles, dtype=np.float64).reshape(-1, 3, 3)
        if isinstance(material, str):
            material = [m.name for m in self.materials].index(material)
        if callable(uv):
            uv = uv(triangles)
        if yaw:
            triangles = turn(triangles, yaw)
        if at is not None:
            triangles = triangles + np.asarray(at, dtype=np.float64)
        self.parts.append((triangles, smooth_normals(triangles, math.cos(math.radians(crease))), material, uv))

    def scene(self, camera=None, lights=(), **settings):
        """The finished `Scene`; settings as of its fields."""
        index = [np.full(len(t), m, np.int32) for t, _, m, _ in self.parts]
        if any(uv is not None for *_, uv in self.parts):
            settings["uv"] = np.concatenate(
                [np.zeros((len(t), 3, 2)) if uv is None else uv for t, _, _, uv in self.parts]
            )
        return Scene(
            self.name,
            np.concatenate([t for t, _, _, _ in self.parts]),
            np.concatenate([n for _, n, _, _ in self.parts]),
            np.concatenate(index),
            self.materials,
            camera,
            list(lights),
            **settings,
        )


def sheet(points, close_u=False, close_v=False, uv=None):
    """Two triangles for each cell of a grid of points (nu, nv, 3), faces towards du x dv; may close on itself.

    Cells that shrink to an edge, as at a pole, give one triangle; cells that shrink to a point none. With texture coordinates
    uv (nu, nv, 2) of the points, which a closed sheet has once more at its end: returns (triangles, coordinates).
    """
    points = np.asarray(points, dtype=np.float64)
    if close_u:
        points = np.concatenate((points, points[:1]))
    if close_v:
        points = np.concatenate((points, points[:, :1]), axis=1)

    def cells(g):
        a, b, c, d = g[:-1, :-1], g[1:, :-1], g[1:, 1:], g[:-1, 1:]
        return np.stack((np.stack((a, b, c), axis=2), np.stack((a, c, d), axis=2)), axis=2).reshape(-1, 3, g.shape[2])

    out = cells(points)
    same = [(out[:, i] == out[:, (i + 1) % 3]).all(axis=1) for i in range(3)]
    kept = ~(same[0] | same[1] | same[2])
    return out[kept] if uv is None else (out[kept], cells(np.asarray(uv, dtype=np.float64))[kept])


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


def sides(lo, hi):
    """The six walls of a room, two triangles each, facing in: left, right, floor, ceiling, back (-z), front."""
    names = ("left", "right", "floor", "ceiling", "back", "front")
    return dict(zip(names, box(lo, hi)[:, ::-1].reshape(6, 2, 3, 3)))


def opening(lo, hi, hole_lo, hole_hi, deep):
    """A wall at z = 0 between (x, y) lo and hi that faces +z, with a hole, and the hole's sides down to z = -deep."""
    (x0, y0), (x1, y1), (u0, v0), (u1, v1) = lo, hi, hole_lo, hole_hi
    parts = ((x0, y0, u0, y1), (u1, y0, x1, y1), (u0, y0, u1, v0), (u0, v1, u1, y1))
    wall = [quad((a, c, 0.0), (d, c, 0.0), (d, e, 0.0), (a, e, 0.0)) for a, c, d, e in parts]
    ring = np.array([[(x, y, z) for z in (-deep, 0.0)] for x, y in ((u0, v0), (u1, v0), (u1, v1), (u0, v1))])
    return np.concatenate(wall), sheet(ring, close_u=True)[:, ::-1]


def curve(points, per_span=6):
    """A smooth line through (radius, y) points (Catmull and Rom 1974)."""
    p = np.asarray(points, dtype=np.float64)
    p = np.concatenate((2.0 * p[:1] - p[1:2], p, 2.0 * p[-1:] - p[-2:-1]))
    t = (np.arange(per_span) / per_span)[:, None]
    spans = [
        0.5 * (2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t**2 + (3.0 * b - 3.0 * c + d - a) * t**3)
        for a, b, c, d in zip(p, p[1:], p[2:], p[3:])
    ]
    out = np.concatenate((*spans, p[-2:-1]))
    out[:, 0] = np.maximum(out[:, 0], 0.0)
    return out


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


# ---- mappings: from triangles to texture coordinates -----------------------------------------------------------------


def plane_map(u, v, size=1.0, origin=(0.0, 0.0, 0.0)):
    """Along two directions; size: of one repeat, a number or one for u and one for v."""
    axes = np.array([u, v], dtype=np.float64).T
    return lambda triangles: (triangles - np.asarray(origin)) @ axes / size


def box_map(size=1.0, origin=(0.0, 0.0, 0.0), along=None):
    """From the six sides, upright, by the side that a triangle faces most.

    along: the axis (0, 1, 2) that u follows on every side but its own two, as the grain of a board does.
    """

    def mapping(triangles):
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        axis = np.abs(normal).argmax(axis=1)
        front = np.take_along_axis(normal, axis[:, None], 1)[:, 0] > 0.0
        p = triangles - np.asarray(origin, dtype=np.float64)
        uv = np.empty((*p.shape[:2], 2))
        for side, (u, v) in enumerate(((2, 1), (0, 2), (0, 1))):
            if along is not None and v == along:
                u, v = v, u
            mine = axis == side
            sign = 1.0 if along is not None else np.where(front[mine], (-1.0, 1.0, 1.0)[side], (1.0, -1.0, -1.0)[side])
            uv[mine, :, 0] = p[mine, :, u] * np.reshape(sign, (-1, 1))
            uv[mine, :, 1] = p[mine, :, v] * (-1.0 if v == 1 else 1.0)
        return uv / size

    return mapping


def _around(triangles, repeats):
    """Turns round the y axis times repeats: no triangle crosses the seam, a corner on the axis lies between the others."""
    x, z = triangles[..., 0], triangles[..., 2]
    on_axis = np.hypot(x, z) < 1e-9
    turns = 0.5 - np.arctan2(z, x) / (2.0 * np.pi)
    first = np.take_along_axis(turns, on_axis.argmin(axis=1)[:, None], 1)
    turns = turns - np.round(turns - first)
    count = np.maximum((~on_axis).sum(axis=1), 1)
    middle = np.where(on_axis, 0.0, turns).sum(axis=1) / count
    return np.where(on_axis, middle[:, None], turns) * repeats


def cylinder_map(repeats=1, height=1.0):
    """Round the y axis, `repeats` pictures a turn; height: of one repeat, v is 0 at y = 0."""
    return lambda triangles: np.stack((_around(triangles, repeats), -triangles[..., 1] / height), axis=2)


def sphere_map(centre=(0.0, 0.0, 0.0), repeats=1):
    """Longitude and latitude round a centre; the picture's top is at the upper pole."""

    def mapping(triangles):
        p = triangles - np.asarray(centre, dtype=np.float64)
        latitude = np.arctan2(p[..., 1], np.hypot(p[..., 0], p[..., 2]))
        return np.stack((_around(p, repeats), 0.5 - latitude / np.pi), axis=2)

    return mapping


# ---- noise -----------------------------------------------------------------------------------------------------------


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
