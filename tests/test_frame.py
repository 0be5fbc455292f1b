# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The reference of a frame against closed forms and brute force, and the checks that compare it with others."""

import copy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_image import make_scene, soup

from raycore import check, sim
from raycore.image import View, build_image
from raycore.model import bvh, fp24, frame, pixbuf
from raycore.scene import Camera, Light, Material

# A square of side 2 in the plane z = 0 that faces +z, and a smaller one above it.
FLOOR = [[[-1, -1, 0], [1, -1, 0], [1, 1, 0]], [[-1, -1, 0], [1, 1, 0], [-1, 1, 0]]]
ROOF = (np.array(FLOOR) * 0.25 + (0.5, 0.0, 0.5)).tolist()
MATERIAL = Material("m", (0.05, 0.06, 0.07), (0.5, 0.4, 0.3), (0.2, 0.2, 0.2), 8.0)
EYE, LAMP = (0.0, 0.0, 3.0), (0.5, 0.25, 2.0)
WIDTH, HEIGHT = 48, 32


def plane_view(shadows=True, lights=None):
    lights = lights or [Light(LAMP, (1.0, 0.9, 0.8))]
    return View(WIDTH, HEIGHT, Camera(EYE, (0, 0, 0), (0, 1, 0), 45.0), lights, shadows)


@pytest.fixture(scope="module")
def floor():
    return build_image(make_scene(FLOOR, [MATERIAL], background=(0.125, 0.25, 0.5)), plane_view())


@pytest.fixture(scope="module")
def roof():
    return build_image(make_scene(FLOOR + ROOF, [MATERIAL], background=(0.125, 0.25, 0.5)), plane_view())


def on_plane(z=0.0):
    """World points (H, W, 3) at which the view's rays meet the plane at height z, from first principles."""
    pixel = 2.0 * np.tan(np.radians(22.5)) / HEIGHT
    x = (np.arange(WIDTH) + 0.5 - WIDTH / 2) * pixel * (EYE[2] - z)
    y = -(np.arange(HEIGHT) + 0.5 - HEIGHT / 2) * pixel * (EYE[2] - z)
    return np.stack((*np.meshgrid(x, y), np.full((HEIGHT, WIDTH), z)), axis=2)


def inside(points, centre=(0.0, 0.0), half=1.0):
    return np.all(np.abs(points[..., :2] - centre) < half, axis=2)


RENDERERS = {"fp24": (frame.render_fp24, 2.0**-11), "double": (frame.render_double, 2e-4)}


@pytest.mark.parametrize("name", RENDERERS)
def test_hits_of_a_plane(floor, name):
    render, tolerance = RENDERERS[name]
    out, points = render(floor), on_plane()
    hit = inside(points)
    assert np.array_equal(out.tri >= 0, hit)
    unit = floor.geometry.unit
    assert np.allclose(unit.length_to_world(out.t)[hit], np.linalg.norm(points - EYE, axis=2)[hit], rtol=tolerance)
    upper = points[..., 1] > points[..., 0]
    diagonal = np.abs(points[..., 1] - points[..., 0]) < 1e-3
    assert np.array_equal((out.tri == 1) | diagonal, hit & upper | diagonal)
    assert np.abs(out.rgb[~hit] - (0.125, 0.25, 0.5)).max() < 2.0**-17
    assert (out.pixels[~hit] == 0xFF804020).all()  # 127.5, 63.75, 31.875 rounded; red lowest


@pytest.mark.parametrize("name", RENDERERS)
def test_phong_of_a_plane(floor, name):
    render, tolerance = RENDERERS[name]
    out, p = render(floor), on_plane()
    to_light, to_eye = np.array(LAMP) - p, np.array(EYE) - p
    to_light /= np.linalg.norm(to_light, axis=2, keepdims=True)
    to_eye /= np.linalg.norm(to_eye, axis=2, keepdims=True)
    mirrored = 2.0 * to_light[..., 2:] * (0.0, 0.0, 1.0) - to_light
    highlight = np.maximum((mirrored * to_eye).sum(axis=2), 0.0) ** 8
    for i, (amb, diff, spec, light) in enumerate(
        zip(MATERIAL.ambient, MATERIAL.diffuse, MATERIAL.specular, (1, 0.9, 0.8))
    ):
        want = amb + light * (diff * to_light[..., 2] + spec * highlight)
        assert np.abs(out.rgb[..., i] - want)[inside(p)].max() < tolerance


@pytest.mark.parametrize("name", RENDERERS)
def test_shadow_of_a_roof(roof, name):
    out, p = RENDERERS[name][0](roof), on_plane()
    seen = inside(p) & ~inside(on_plane(0.5), (0.5, 0.0), 0.25)
    at = p + (np.array(LAMP) - p) * 0.25  # a quarter of the way to the lamp lies the roof, at height 0.5
    sure = seen & (np.abs(np.abs(at[..., :2] - (0.5, 0.0)) - 0.25).min(axis=2) > 1e-3)
    dark = inside(at, (0.5, 0.0), 0.25)
    assert dark[sure].sum() > 10
    assert np.array_equal((out.light[0] == frame.SHADOWED)[sure], dark[sure])
    assert np.abs(out.rgb[sure & dark] - MATERIAL.ambient).max() < 2.0**-17
    assert set(np.unique(out.shadow_tri[0][sure & dark])) <= {2, 3}
    assert out.rays["primary"] == WIDTH * HEIGHT and out.rays["culled"] == 0
    assert out.rays["shadow"] == np.count_nonzero(out.tri >= 0)


def test_without_shadows_no_shadow_rays(roof):
    image = build_image(roof.geometry, plane_view(shadows=False))
    out = frame.render_fp24(image)
    assert out.rays["shadow"] == 0 and out.slots[0] == WIDTH * HEIGHT
    assert not (out.light == frame.SHADOWED).any()
    assert len(check.expected_hits(out)["x"]) == WIDTH * HEIGHT


def test_light_behind_the_surface_is_culled(floor):
    below = Light((0.3, 0.1, -2.0))
    out = frame.render_fp24(build_image(floor.geometry, plane_view(lights=[below, Light(LAMP)])))
    hit = out.tri >= 0
    assert (out.light[0][hit] == frame.CULLED).all() and (out.light[1][hit] == frame.LIT).all()
    assert out.rays["culled"] == hit.sum() == out.rays["shadow"]


def test_lights_add_up(floor):
    lamps = [Light(LAMP, (0.5, 0.5, 0.5)), Light((-1, -1, 2), (0.25, 0.25, 0.25), directional=True)]
    ambient = np.array(MATERIAL.ambient)
    parts = [frame.render_double(build_image(floor.geometry, plane_view(lights=[l]))).rgb - ambient for l in lamps]
    both = frame.render_double(build_image(floor.geometry, plane_view(lights=lamps)))
    hit = both.tri >= 0
    assert np.allclose((parts[0] + parts[1] + ambient)[hit], both.rgb[hit], atol=1e-12)


def brute_force(triangles, org, d):
    """Nearest hit of one ray, all triangles at once: (triangle or -1, t)."""
    a, e1, e2 = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        # Cramer's rule on a + beta e1 + gamma e2 = org + t d
        def det(p, q, r):
            return np.einsum("ij,ij->i", np.cross(p, q), r)

        rows, s = np.broadcast_to(-d, a.shape), org - a
        whole = det(e1, e2, rows)
        beta, gamma, t = det(s, e2, rows) / whole, det(e1, s, rows) / whole, det(e1, e2, s) / whole
    t = np.where((beta >= 0) & (gamma >= 0) & (beta + gamma <= 1) & (t > 0) & (whole != 0), t, np.inf)
    return (int(t.argmin()), t.min()) if np.isfinite(t).any() else (-1, np.inf)


def test_bvh_finds_what_brute_force_finds(seed):
    rng = np.random.default_rng(seed)
    triangles = soup(rng, 500) / 8.0 - 5.0
    tree = bvh.build(triangles)
    assert sorted(tree.index) == list(range(500))
    hits = 0
    for _ in range(300):
        org = rng.uniform(-1.5, 1.5, 3)
        d = rng.normal(size=3)
        d[rng.integers(0, 3)] *= rng.integers(0, 2)  # some parallel to an axis plane
        d /= np.linalg.norm(d)
        want, t_want = brute_force(triangles, org, d)
        got, t, _, _ = bvh.trace_ray(tree, tuple(org), tuple(d), 0.0, np.inf, -1, False)
        assert got == want
        if want >= 0:
            hits += 1
            assert np.isclose(t, t_want, rtol=1e-9)
            assert bvh.trace_ray(tree, tuple(org), tuple(d), 0.0, np.inf, want, False)[0] != want
            assert bvh.trace_ray(tree, tuple(org), tuple(d), 0.0, t * 0.999, -1, True)[0] == -1
    assert hits > 20


@pytest.fixture(scope="module")
def blob():
    """Random triangles seen from outside: many edges, several materials' worth of shadows."""
    rng = np.random.default_rng(5)
    return build_image(make_scene(soup(rng, 400), [MATERIAL]), View(64, 48))


def test_24_bits_are_near_double_precision(blob):
    single, double = frame.render_fp24(blob), frame.render_double(blob)
    assert check.psnr(check.channels(single.pixels), check.channels(double.pixels)) > check.PSNR_DB
    assert np.mean(single.tri != double.tri) < 0.002


def crossed(gap):
    """A tilted square twice, its diagonals crossed and its materials different, the second one `gap` behind."""
    corner = np.array([[-1.0, -0.7, 0.1], [0.9, -0.6, -0.2], [1.0, 0.8, 0.3]])
    corner = np.concatenate((corner, [corner[0] + corner[2] - corner[1]]))
    behind = corner + gap * np.cross(corner[0] - corner[1], corner[2] - corner[1]) * (-1.0)
    triangles = np.array([*corner[[[0, 1, 2], [0, 2, 3]]], *behind[[[1, 2, 3], [1, 3, 0]]]])
    red = Material("red", (0.5, 0.0, 0.0), (0.5, 0.0, 0.0))
    scene = make_scene(triangles, [MATERIAL, red])
    return build_image(replace(scene, face_material=np.array([0, 0, 1, 1], np.int32)), View(40, 24))


def test_coincident_triangles_take_the_wanted_one():
    """Double precision shows either of two surfaces in one place when asked, and only the nearer one of two places."""
    image = crossed(0.0)
    seen = frame.render_double(image).tri >= 0
    assert seen.sum() > 100
    for pair in ((0, 1), (2, 3)):
        fits = [frame.render_double(image, np.full(seen.shape, tri)).tri == tri for tri in pair]
        assert (fits[0] | fits[1])[seen].mean() > 0.99, pair  # all but edges
    report = check.check(image)
    assert report.psnr > check.PSNR_DB > report.psnr_any and report.coincident > 0.1 * seen.sum()
    assert np.array_equal(report.double.tri, report.reference.tri)

    apart = crossed(1e-7)
    free = frame.render_double(apart)
    front = free.tri[seen].max() < 2
    wanted = frame.render_double(apart, np.where(seen, 2, -1) if front else np.where(seen, 0, -1))
    assert np.array_equal(wanted.tri, free.tri) and (front or free.tri[seen].min() >= 2)


def test_embree_agrees(blob):
    out = frame.render_fp24(blob)
    found = check.compare_embree(blob, out)
    assert found.same_hit > 0.998 and found.holes == 0 and found.false == 0 and found.steady > 0.5


def test_holes_are_counted(floor):
    out = frame.render_fp24(floor)
    base = check.compare_embree(floor, out)
    assert (base.holes, base.false, base.same_hit) == (0, 0, 1.0)
    broken = copy.deepcopy(out)
    broken.tri[16, 20:23] = -1
    broken.tri[0, 0], broken.t[0, 0] = 0, 0.5
    found = check.compare_embree(floor, broken)
    assert (found.holes, found.false) == (3, 1)
    assert np.isclose(found.same_hit, 1.0 - 4.0 / (WIDTH * HEIGHT))


# ---- RTL against reference: every kind of difference is seen ---------------------------------------------------------------


def as_simulated(out):
    """What a perfect simulation of a frame would return."""
    want = check.expected_hits(out)
    hits = np.zeros(len(want["x"]), sim.HIT_DTYPE)
    for name, values in want.items():
        hits[name] = values
    order = np.random.default_rng(1).permutation(len(hits))  # rays finish in any order
    counters = dict(zip(check.SLOT_COUNTERS, map(int, out.slots)))
    counters |= {counter: out.rays[kind] for kind, counter in check.RAY_COUNTERS.items()}
    return SimpleNamespace(frame=out.pixels.copy(), hits=hits[order], stats={"counters": counters})


def test_perfect_simulation_passes(roof):
    out = frame.render_fp24(roof)
    exact = check.compare_rtl(as_simulated(out), out)
    assert exact.same and exact.rays == out.rays["primary"] + out.rays["shadow"] and not exact.examples


def first(hits, any_hit, hit):
    return np.flatnonzero((hits["any_hit"] == any_hit) & (hits["hit"] == hit))[0]


@pytest.mark.parametrize("any_hit", [0, 1])
@pytest.mark.parametrize("name", ["tri", "t", "beta", "gamma"])
def test_one_wrong_hit_is_seen(roof, any_hit, name):
    out = frame.render_fp24(roof)
    result = as_simulated(out)
    result.hits[name][first(result.hits, any_hit, 1)] ^= 1
    exact = check.compare_rtl(result, out)
    assert (exact.pixels, exact.hits, exact.counters) == (0, 1, {}) and len(exact.examples) == 1


def test_distance_of_a_miss_means_nothing(roof):
    out = frame.render_fp24(roof)
    result = as_simulated(out)
    result.hits["t"][first(result.hits, 0, 0)] ^= 1
    assert check.compare_rtl(result, out).same
    result.hits["hit"][first(result.hits, 1, 0)] = 1
    assert check.compare_rtl(result, out).hits == 1


def test_lost_doubled_and_unknown_rays_are_seen(roof):
    out = frame.render_fp24(roof)
    result = as_simulated(out)
    whole = result.hits
    result.hits = whole[1:]
    assert check.compare_rtl(result, out).hits == 1
    result.hits = np.concatenate((whole, whole[:1]))
    assert check.compare_rtl(result, out).hits == 1
    stray = whole[:1].copy()
    stray["x"] = WIDTH
    result.hits = np.concatenate((whole, stray))
    assert check.compare_rtl(result, out).hits == 1
    stray = whole[first(whole, 1, 1) :][:1].copy()
    stray["light"] = 1
    result.hits = np.concatenate((whole, stray))
    assert check.compare_rtl(result, out).hits == 1


def test_wrong_pixels_and_counters_are_seen(roof):
    out = frame.render_fp24(roof)
    result = as_simulated(out)
    result.frame[3, 4] ^= 1
    result.stats["counters"]["SLOTS_TRAV2"] += 1
    exact = check.compare_rtl(result, out)
    assert exact.pixels == 1 and list(exact.counters) == ["SLOTS_TRAV2"]


def test_pictures():
    a = np.zeros((4, 4, 3), np.uint8)
    b = a.copy()
    b[0, 0] = 255, 0, 2
    assert check.psnr(a, a) == np.inf
    assert np.isclose(check.psnr(a, b), 10 * np.log10(255.0**2 * 48 / (255.0**2 + 4)))
    assert check.difference(a, b)[0, 0].tolist() == [255, 0, 32]
    ten = pixbuf.pack(fp24.round_to_fp24(np.array([[[1.0, 0.5, 0.0]]])), pixbuf.RGB10A2)
    assert check.channels(ten, pixbuf.RGB10A2).tolist() == [[[255, 128, 0]]]
