# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Our own scenes of Whitted ray tracing: what glass, textures and surfaces must keep to, and the blocks they are made of."""

import importlib.util

import numpy as np
import pytest
from numba import njit

from raycore import furniture, patterns, scene, shapes
from raycore.scene import generators

# Triangles from ... to; the rooms are as large as the paper's (Sec. 5, Fig. 9).
COUNTS = {
    "kitchen": (290_000, 305_000),
    "room": (237_000, 243_000),
    "living_room": (355_000, 365_000),
    "glass": (80_000, 150_000),
    "mirror_box": (10_000, 30_000),
    "cards": (2_000, 6_000),
    "tiny_glass": (50, 149),
}
ROOMS = ["kitchen", "room", "living_room"]


def module(name):
    spec = importlib.util.spec_from_file_location(f"own_{name}", generators.FOLDER / f"{name}.py")
    out = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(out)
    return out


@pytest.fixture(scope="module")
def built():
    kept = {}

    def get(name):
        if name not in kept:
            kept[name] = module(name).build()
        return kept[name]

    return get


def turned(uv):
    """Twice the signed area of triangles in a plane (n, 3, 2)."""
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


@njit(cache=True)
def _join(faces, parent):
    for f in faces:
        for k in range(1, 3):
            a, b = f[0], f[k]
            while parent[a] != a:
                a = parent[a]
            while parent[b] != b:
                b = parent[b]
            parent[max(a, b)] = min(a, b)
    for i in range(parent.size):  # parents come before their children
        parent[i] = parent[parent[i]]


def bodies(triangles):
    """Parts that hang together by vertices: [(triangles, whether closed, volume)]. Closed: each edge is there once each way."""
    rows = np.ascontiguousarray(triangles.reshape(-1, 3) + 0.0)
    points, corner = np.unique(rows.view("V24").reshape(-1), return_inverse=True)
    faces = corner.reshape(-1, 3)
    parent = np.arange(len(points))
    _join(faces, parent)
    out = []
    for label in np.unique(parent):
        mine = parent[faces[:, 0]] == label
        edges = np.concatenate([faces[mine][:, [i, (i + 1) % 3]] for i in range(3)])
        there, back = (np.unique(edges @ np.array(way)) for way in ((len(points), 1), (1, len(points))))
        closed = len(there) == len(edges) and np.array_equal(there, back)
        t = triangles[mine]
        volume = np.einsum("ij,ij->i", t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6.0
        out.append((t, closed, volume))
    return out


@pytest.mark.parametrize("name", COUNTS)
def test_counts(name, built):
    s = built(name)
    assert COUNTS[name][0] <= len(s.triangles) <= COUNTS[name][1]
    assert len(s.lights) == {"mirror_box": 4}.get(name, 2)
    assert s.camera is not None and 6 <= s.depth <= 15
    area = np.linalg.norm(
        np.cross(s.triangles[:, 1] - s.triangles[:, 0], s.triangles[:, 2] - s.triangles[:, 0]), axis=1
    )
    assert np.isfinite(s.triangles).all() and (area > 0.0).all()
    assert np.allclose(np.linalg.norm(s.normals, axis=2), 1.0)


@pytest.mark.parametrize("name", COUNTS)
def test_same_again(name, built):
    """A generator gives the same scene whenever it runs."""
    s, again = built(name), module(name).build()
    for what in ("triangles", "normals", "face_material", "uv"):
        a, b = getattr(s, what), getattr(again, what)
        assert (a is None and b is None) or np.array_equal(a, b), what
    assert (s.materials, s.camera, s.lights) == (again.materials, again.camera, again.lights)


@pytest.mark.parametrize("name", COUNTS)
def test_glass_is_closed(name, built):
    """Entering and leaving are told by the normal: what transmits is closed and faces out, and no two bodies share a vertex."""
    s = built(name)
    clear = [i for i, m in enumerate(s.materials) if any(m.transmit)]
    assert clear or name == "cards"
    for i in clear:
        assert s.materials[i].ior > 1.0 and s.materials[i].fresnel and s.materials[i].opaque is False
        for triangles, closed, volume in bodies(s.triangles[s.face_material == i]):
            assert closed and volume > 0.0, (s.materials[i].name, triangles.mean(axis=(0, 1)).round(3))


@njit(cache=True)
def crossings(points, triangles):
    """How often a slanted ray from each point crosses the triangles."""
    out = np.zeros(len(points), np.int64)
    for t in range(len(triangles)):
        # Slide each triangle along the ray (0.6133, 0.7109, 1) into the plane of the point: a question in two dimensions.
        for i in range(len(points)):
            x, y, h = np.empty(3), np.empty(3), np.empty(3)
            for k in range(3):
                h[k] = triangles[t, k, 2] - points[i, 2]
                x[k] = triangles[t, k, 0] - points[i, 0] - 0.6133 * h[k]
                y[k] = triangles[t, k, 1] - points[i, 1] - 0.7109 * h[k]
            a, b, c = x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]
            if (a > 0.0 and b > 0.0 and c > 0.0) or (a < 0.0 and b < 0.0 and c < 0.0):
                if (a * h[0] + b * h[1] + c * h[2]) / (a + b + c) > 0.0:
                    out[i] += 1
    return out


@pytest.mark.parametrize("name", [n for n in COUNTS if n != "cards"])
def test_nothing_sticks_in_glass(name, built):
    """No vertex of anything else is inside a body of glass: it would be seen through a surface that is not there."""
    s = built(name)
    corners = s.triangles.reshape(-1, 3)
    for i in np.flatnonzero([any(m.transmit) for m in s.materials]):
        mine = np.flatnonzero(s.face_material == i)
        for body, _, _ in bodies(s.triangles[mine]):
            lo, hi = body.min(axis=(0, 1)), body.max(axis=(0, 1))
            near = ((corners > lo) & (corners < hi)).all(axis=1)
            points = np.unique(corners[near], axis=0)
            own = np.unique(body.reshape(-1, 3), axis=0)
            points = np.array(sorted(set(map(tuple, points)) - set(map(tuple, own)))).reshape(-1, 3)
            points = points[:: max(len(points) // 200, 1)]
            inside = points[crossings(points, body) % 2 == 1]
            assert not len(inside), (s.materials[i].name, inside[0].round(4).tolist(), len(inside))


@pytest.mark.parametrize("name", COUNTS)
def test_normals_side_with_their_triangle(name, built):
    s = built(name)
    assert np.einsum("nij,nj->ni", s.normals, scene.face_normals(s.triangles)).min() > 0.0


@pytest.mark.parametrize("name", COUNTS)
def test_materials(name, built):
    """Every one is used and has a name of its own; none gives more light than it takes."""
    s = built(name)
    assert len({m.name for m in s.materials}) == len(s.materials) <= scene.MAX_MATERIALS
    assert set(np.unique(s.face_material)) == set(range(len(s.materials)))
    for m in s.materials:
        total = np.add(m.reflect, m.transmit)
        assert (total <= 1.03).all() and (np.add(m.diffuse, m.reflect) <= 1.06).all(), m.name
        if m.texture is None:
            continue
        image = m.texture.image
        assert image.dtype == np.uint8 and image.shape[2] == 4
        assert all(n & (n - 1) == 0 and 32 <= n <= 1024 for n in image.shape[:2]), m.name
        assert (m.alpha_mode == "mask") <= ((image[..., 3] < 10).any() and (image[..., 3] > 245).any())


@pytest.mark.parametrize("name", [n for n in COUNTS if n != "mirror_box"])
def test_coordinates(name, built):
    """Textured triangles have a picture that is neither smeared nor turned into noise: up to some repeats, no needle."""
    s = built(name)
    assert s.uv.shape == (len(s.triangles), 3, 2) and np.isfinite(s.uv).all()
    textured = np.array([m.texture is not None for m in s.materials])[s.face_material]
    assert textured.any() and not s.uv[~textured].any()
    t, uv = s.triangles[textured], s.uv[textured]
    texels = turned(uv)
    area = np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)
    assert (np.abs(texels) > 1e-12).mean() > 0.96  # the ends of rods have none
    assert np.median(np.abs(texels) / area) < 1000.0


def planes(s):
    """Groups of triangles that lie in one plane (10 um): index arrays."""
    normal = scene.face_normals(s.triangles)
    first = np.take_along_axis(normal, np.abs(normal).argmax(axis=1)[:, None], 1)
    normal = normal * np.sign(first)
    offset = np.einsum("ij,ij->i", normal, s.triangles[:, 0])
    key = np.round(np.column_stack((normal * 1e4, offset * 1e5))).astype(np.int64)
    _, group = np.unique(key, axis=0, return_inverse=True)
    order = np.argsort(group.reshape(-1), kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group.reshape(-1)[order])) + 1)


def overlap(a, b):
    """Whether two triangles (3, 2) of a plane share area: no edge separates them."""
    for p, q in ((a, b), (b, a)):
        for i in range(3):
            edge = p[(i + 1) % 3] - p[i]
            side = np.array([-edge[1], edge[0]]) / np.hypot(*edge)
            if side @ (p[(i + 2) % 3] - p[i]) < 0.0:
                side = -side
            if ((q - p[i]) @ side).max() < 1e-6 or ((q - p[i]) @ side).min() > ((p - p[i]) @ side).max() - 1e-6:
                return False
    return True


@pytest.mark.parametrize("name", COUNTS)
def test_no_coincident_surfaces(name, built):
    """Where surfaces of two materials lay in one place, rounding would choose between them."""
    s = built(name)
    for group in planes(s):
        materials = s.face_material[group]
        if len(group) < 2 or (materials == materials[0]).all():
            continue
        axis = np.abs(scene.face_normals(s.triangles[group[:1]])[0]).argmax()
        flat = np.delete(s.triangles[group], axis, axis=2)
        lo, hi = flat.min(axis=1), flat.max(axis=1)
        for i in range(len(group)):
            near = (lo < hi[i]).all(axis=1) & (hi > lo[i]).all(axis=1) & (materials != materials[i])
            near[: i + 1] = False
            for j in np.flatnonzero(near):
                who = [s.materials[m].name for m in materials[[i, j]]]
                assert not overlap(flat[i], flat[j]), (who, s.triangles[group[i]].round(3).tolist())


@pytest.mark.parametrize("name", ROOMS)
def test_rooms(name, built):
    """The camera and the lamps are inside, and all the paper's effects are there."""
    s = built(name)
    lo, hi = s.bounds
    for place in [s.camera.eye, s.camera.target] + [light.position for light in s.lights if not light.directional]:
        assert (np.asarray(place) > lo).all() and (np.asarray(place) < hi).all()
    assert (hi - lo).max() < 6.0  # nothing stands outside
    assert max(max(m.reflect) for m in s.materials) > 0.6
    assert any(m.transmit != (0.0, 0.0, 0.0) for m in s.materials)
    assert {m.texture.compact for m in s.materials if m.texture} == {False, True}
    assert any(m.alpha_mode == "mask" for m in s.materials) == (name == "living_room")


def test_moving_light():
    """Only the moving light, and the ball that shows it, move."""
    build = module("room").build
    a, b = build(), build(light_at=0.3)
    moved = [x != y for x, y in zip(a.lights, b.lights)]
    assert moved == [False, True]
    other = np.flatnonzero((a.triangles != b.triangles).any(axis=(1, 2)))
    assert {a.materials[m].name for m in a.face_material[other]} == {"bulb"}
    for s in (a, b):
        ball = s.triangles[other].reshape(-1, 3).mean(axis=0)
        assert np.linalg.norm(ball - s.lights[1].position) < 0.1
    again = build(light_at=1.0)
    assert np.allclose(again.lights[1].position, a.lights[1].position)


def test_every_wrap_and_format(built):
    s = built("cards")
    textures = [m.texture for m in s.materials if m.texture]
    assert {t.wrap_s for t in textures} == {t.wrap_t for t in textures} == {"repeat", "mirror", "clamp"}
    assert {t.compact for t in textures} == {t.srgb for t in textures} == {False, True}
    assert {m.alpha_mode for m in s.materials} == {"opaque", "mask", "blend"}


def test_tiny_glass_has_everything(built):
    materials = built("tiny_glass").materials
    assert {m.alpha_mode for m in materials} == {"opaque", "mask", "blend"}
    assert any(min(m.reflect) > 0.5 for m in materials) and any(min(m.transmit) > 0.5 for m in materials)
    assert sum(m.texture is not None for m in materials) == 2


# ---- what they are made of -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", sorted(furniture._VESSELS))
def test_vessels(kind):
    """One closed surface, outside and inside: much less of it than what its outline holds."""
    ((triangles, closed, volume),) = bodies(furniture.vessel(kind, 32, 4))
    lo, hi = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    assert closed and 0.0 < volume < 0.5 * np.prod(hi - lo)
    assert abs(lo[1]) < 1e-9 and np.allclose(lo[[0, 2]], -hi[[0, 2]], rtol=0.02)
    # Straight down into it: first its inner base, then out of it below, and nothing else.
    x = triangles[..., [0, 2]] - (0.0011, 0.0007)
    cross = x[:, :, 0] * np.roll(x[:, :, 1], -1, axis=1) - x[:, :, 1] * np.roll(x[:, :, 0], -1, axis=1)
    hit = (cross > 0.0).all(axis=1) | (cross < 0.0).all(axis=1)
    assert hit.sum() == 2


def test_plane_map():
    tris = shapes.quad((1, 0, 2), (3, 0, 2), (3, 4, 2), (1, 4, 2))
    uv = shapes.plane_map((1, 0, 0), (0, -1, 0), (2.0, 4.0), (1.0, 4.0, 0.0))(tris)
    assert uv.tolist() == [[[0, 1], [1, 1], [1, 0]], [[0, 1], [1, 0], [0, 0]]]


def test_box_map_is_upright_and_not_mirrored():
    """Seen from outside: v falls as y rises on the four sides; u and v turn the way the picture does, on all six."""
    tris = shapes.box((0, 0, 0), (1, 2, 3))
    uv = shapes.box_map()(tris)
    normal = scene.face_normals(tris)
    assert (turned(uv) < 0.0).all()  # v grows downwards
    upright = np.abs(normal[:, 1]) < 0.5
    assert np.array_equal(uv[upright, :, 1], -tris[upright, :, 1])
    assert np.allclose(np.abs(turned(uv)), 2.0 * np.array([3, 3, 3, 3, 1.5, 1.5, 1.5, 1.5, 1, 1, 1, 1]))


@pytest.mark.parametrize("axis", range(3))
def test_box_map_follows_the_grain(axis):
    tris = shapes.box((0, 0, 0), (1, 2, 3))
    uv = shapes.box_map(0.5, along=axis)(tris)
    beside = np.abs(scene.face_normals(tris)[:, axis]) < 0.5
    assert np.allclose(np.abs(uv[beside, :, 0]), np.abs(tris[beside, :, axis]) * 2.0)


@pytest.mark.parametrize("repeats", [1, 3])
def test_round_maps(repeats, seed):
    """No triangle crosses the seam; all triangles together cover each picture once."""
    centre = np.random.default_rng(seed).normal(0.0, 1.0, 3)
    ball = shapes.sphere((0, 0, 0), 0.7, 24) + centre
    uv = shapes.sphere_map(centre, repeats)(ball)
    assert np.ptp(uv[..., 0], axis=1).max() <= repeats / 24 + 1e-6
    assert np.abs(turned(uv)).sum() / 2.0 == pytest.approx(repeats * 11 / 12)
    top = ball[..., 1].argmax()
    assert uv[..., 1].reshape(-1)[top] == pytest.approx(0.0, abs=1e-6)
    rod = shapes.lathe([(0.5, 0.0), (0.4, 2.0)], 16)
    uv = shapes.cylinder_map(repeats, 2.0)(rod)
    assert np.ptp(uv[..., 0], axis=1).max() <= repeats / 16 + 1e-9
    assert np.abs(turned(uv)).sum() / 2.0 == pytest.approx(repeats)


def test_sheet_coordinates():
    """Coordinates stay with their points, also where cells shrink."""
    u, v = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 4), indexing="ij")
    points = np.stack((u * v, v, 0.0 * u), axis=2)  # the edge v = 0 shrinks to a point
    triangles, uv = shapes.sheet(points, uv=np.stack((u, v), axis=2))
    assert len(triangles) == len(uv) == len(shapes.sheet(points)) == 2 * 4 * 3 - 4
    assert np.allclose(triangles[..., 1], uv[..., 1]) and np.allclose(triangles[..., 0], uv[..., 0] * uv[..., 1])


def test_builder():
    """Names and indices of materials, parts turned and moved after they are mapped, parts without coordinates."""
    b = shapes.Builder("b")
    red = b.paint("red", colour=(1.0, 0.0, 0.0))
    b.paint("board", patterns.checker((0, 0, 0), (1, 1, 1)))
    floor = shapes.quad((0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0))
    b.add(floor, red)
    b.add(floor, "board", uv=shapes.plane_map((1, 0, 0), (0, 0, 1)), at=(5.0, 1.0, 0.0), yaw=90.0)
    s = b.scene()
    assert s.face_material.tolist() == [0, 0, 1, 1] and not s.uv[:2].any()
    assert np.array_equal(s.uv[2:], floor[..., [0, 2]])
    assert np.allclose(s.triangles[2:], floor[..., [2, 1, 0]] * (1, 1, -1) + (5, 1, 0))


@pytest.mark.parametrize(
    "image",
    [
        patterns.wood((0.8, 0.6, 0.4), (0.4, 0.2, 0.1)),
        patterns.marble((0.9, 0.9, 0.9), (0.3, 0.3, 0.3)),
        patterns.plaster((0.9, 0.8, 0.7)),
        patterns.parquet((0.8, 0.6, 0.4), (0.4, 0.2, 0.1)),
    ],
    ids=["wood", "marble", "plaster", "parquet"],
)
def test_patterns_repeat(image):
    """Across the seam of a repeated picture, neighbours differ no more than neighbours inside do."""
    x = image[..., :3].astype(float)
    for axis in (0, 1):
        inside = np.abs(np.diff(x, axis=axis)).mean(axis=(1 - axis, 2))
        seam = np.abs(x.take(0, axis) - x.take(-1, axis)).mean()
        assert seam <= inside.max() * 1.5 + 1.0


@pytest.mark.parametrize("name", COUNTS)
def test_documented(name, built):
    page = (generators.FOLDER.parent / "docs" / "scenes.md").read_text(encoding="utf-8")
    assert f"| `{name}` | {len(built(name).triangles):,} |" in page
