# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The reference of a frame against closed forms and brute force, and the checks that compare it with others."""

import copy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_image import make_scene, soup

from raycore import check, kdtree, tbu, triaccel
from raycore.image import View, build_geometry, build_image
from raycore.model import bvh, fp24, frame, pixbuf, rgen, shade, tracer
from raycore.scene import Camera, Light, Material, Texture
from raycore.scene.animation import rotation
from raycore.scene.data import Placed

# A square of side 2 in the plane z = 0 that faces +z, and a smaller one above it.
FLOOR = [[[-1, -1, 0], [1, -1, 0], [1, 1, 0]], [[-1, -1, 0], [1, 1, 0], [-1, 1, 0]]]
ROOF = (np.array(FLOOR) * 0.25 + (0.5, 0.0, 0.5)).tolist()
MATERIAL = Material("m", (0.05, 0.06, 0.07), (0.5, 0.4, 0.3), (0.2, 0.2, 0.2), 8.0)
EYE, LAMP = (0.0, 0.0, 3.0), (0.5, 0.25, 2.0)
WIDTH, HEIGHT = 48, 32


def plane_view(shadows=True, lights=None, **more):
    lights = lights or [Light(LAMP, (1.0, 0.9, 0.8))]
    return View(WIDTH, HEIGHT, Camera(EYE, (0, 0, 0), (0, 1, 0), 45.0), lights, shadows, **more)


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
    for y, x in np.argwhere(sure)[::7]:
        first, second = out.pixel_rays(x, y)
        assert (first["kind"], second["kind"]) == (frame.PRIMARY, frame.SHADOW)
        assert second["hit"] == dark[y, x] and (second["tri"] in (2, 3) if dark[y, x] else second["tri"] == -1)
        assert (first["tri"], first["t"]) == (out.tri[y, x], np.float32(out.t[y, x]))
    assert out.rays["primary"] == WIDTH * HEIGHT and out.rays["culled"] == 0
    assert out.rays["shadow"] == np.count_nonzero(out.tri >= 0)


def test_without_shadows_no_shadow_rays(roof):
    image = build_image(roof.geometry, plane_view(shadows=False))
    out = frame.render_fp24(image)
    assert out.rays["shadow"] == 0 and out.slots[0] == WIDTH * HEIGHT
    assert not (out.light == frame.SHADOWED).any()
    assert len(check.expected_hits(out)) == WIDTH * HEIGHT


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


# ---- paths -----------------------------------------------------------------------------------------------------------

BACK = (0.125, 0.25, 0.5)
BLACK = Material("black", (0, 0, 0), (0, 0, 0))


def layered(materials, heights, **view):
    """An image of squares of side 2 that face +z, one at each height, and what it is looked at through."""
    triangles = [(np.array(FLOOR) + (0, 0, z)).tolist() for z in heights]
    scene = make_scene(np.concatenate(triangles), materials, background=BACK)
    scene.face_material = np.repeat(np.arange(len(materials), dtype=np.int32), 2)
    return build_image(scene, plane_view(**view))


def centre(out):
    """Colours about the picture's centre, where rays meet every layer well inside."""
    return out.rgb[HEIGHT // 2 - 3 : HEIGHT // 2 + 3, WIDTH // 2 - 3 : WIDTH // 2 + 3]


def phong(points, material=MATERIAL, light=(1.0, 0.9, 0.8)):
    """Colour without ambient light of a plane that faces +z, under the lamp (test_phong_of_a_plane has no more to say)."""
    to_light, to_eye = np.array(LAMP) - points, np.array(EYE) - points
    to_light /= np.linalg.norm(to_light, axis=2, keepdims=True)
    to_eye /= np.linalg.norm(to_eye, axis=2, keepdims=True)
    mirrored = 2.0 * to_light[..., 2:] * (0.0, 0.0, 1.0) - to_light
    highlight = np.maximum((mirrored * to_eye).sum(axis=2), 0.0) ** material.shininess
    diffuse = to_light[..., 2:] * np.array(material.diffuse)
    return (diffuse + highlight[..., None] * np.array(material.specular)) * np.array(light)


@pytest.mark.parametrize("name", RENDERERS)
def test_mirror_shows_the_background(name):
    render, tolerance = RENDERERS[name]
    mirror = replace(MATERIAL, reflect=(0.5, 0.25, 1.0))
    out = render(layered([mirror], [0.0]))
    want = np.array(MATERIAL.ambient) + phong(on_plane()) + np.array((0.5, 0.25, 1.0)) * BACK
    hit = inside(on_plane())
    assert np.abs(out.rgb - want)[hit].max() < tolerance
    assert out.rays["reflect"] == hit.sum() == out.by_depth[frame.REFLECT, 1] and out.rays["transmit"] == 0
    without = render(layered([mirror], [0.0], max_depth=0))
    assert without.rays["reflect"] == 0
    assert np.abs(without.rgb - (want - np.array((0.5, 0.25, 1.0)) * BACK))[hit].max() < tolerance


@pytest.mark.parametrize("name", RENDERERS)
def test_two_mirrors_face_each_other(name):
    """Between mirrors that are looked at along their normal, n bounces sum up as a geometric series."""
    render, tolerance = RENDERERS[name]
    glow = Material("glow", (0, 0, 0), (0, 0, 0), emission=(0.5, 0.25, 0.125), reflect=(0.5, 0.5, 0.5))
    up = np.array(FLOOR)
    down = up[:, ::-1] + (0, 0, 1.0)
    scene = make_scene(np.concatenate((up, down)), [glow], background=BACK)
    camera = Camera((0, 0, 0.5), (0, 0, 0), (0, 1, 0), 1.0)
    for depth in (0, 1, 3, 9):
        view = View(4, 4, camera, [Light((0, 0, 0.25))], max_depth=depth, min_weight=0.0)
        out = render(build_image(scene, view))
        want = np.array(glow.emission) * sum(0.5**i for i in range(depth + 1))
        assert np.abs(out.rgb - want).max() < tolerance
        assert list(out.by_depth[frame.REFLECT, 1:]) == [16] * depth + [0] * (15 - depth)
    for least, bounces in ((0.5, 0), (0.25, 1), (0.0625, 3), (0.0624, 4)):
        view = View(4, 4, camera, [], max_depth=15, min_weight=least)
        assert render(build_image(scene, view)).rays["reflect"] == 16 * bounces


@pytest.mark.parametrize("name", RENDERERS)
def test_alpha_lets_see_what_is_behind(name):
    """Three layers, each covering some of what is behind; the last is the background."""
    render, tolerance = RENDERERS[name]
    sheets = [
        Material("lower", (0.5, 0, 0), (0, 0, 0), alpha=0.5, alpha_mode="blend"),
        Material("hole", (1, 1, 1), (0, 0, 0), alpha=0.25, alpha_mode="mask"),
        Material("upper", (0, 0.5, 0), (0, 0, 0), alpha=0.25, alpha_mode="blend"),
    ]
    out = render(layered(sheets, [0.0, 0.25, 0.5], max_depth=15, lights=[Light((0, 0, -5))]))
    want = 0.25 * np.array((0, 0.5, 0)) + 0.75 * (0.5 * np.array((0.5, 0, 0)) + 0.5 * np.array(BACK))
    assert np.abs(centre(out) - want).max() < tolerance
    rays = out.pixel_rays(WIDTH // 2, HEIGHT // 2)
    assert list(rays["kind"]) == [0, 3, 3, 3] and list(rays["depth"]) == [0, 1, 2, 3] and rays["hit"][-1] == 0
    assert np.allclose(rays["t"][1:3], 0.25, rtol=1e-3)  # each layer is seen from the one before
    shallow = render(layered(sheets, [0.0, 0.25, 0.5], max_depth=1, lights=[Light((0, 0, -5))]))
    assert np.abs(centre(shallow) - 0.25 * np.array((0, 0.5, 0))).max() < tolerance


@pytest.mark.parametrize("name", RENDERERS)
def test_shadow_through_two_panes(name):
    """Panes below the eye, above the lamp's target: light is dimmed twice, and a shadow ray is traced three times."""
    render, tolerance = RENDERERS[name]
    pane = Material("pane", (0, 0, 0), (0, 0, 0), transmit=(0.5, 0.75, 1.0))
    leaf = Material("leaf", (0, 0, 0), (0, 0, 0), alpha=0.25, alpha_mode="blend")
    image = layered([MATERIAL, pane, leaf], [0.0, 0.75, 1.5], max_depth=0)
    image = build_image(image.geometry, replace(image.view, camera=Camera((0, 0, 0.5), (0.2, 0.1, 0), (0, 1, 0), 30.0)))
    out = render(image)
    bright = render(build_image(image.geometry, replace(image.view, shadows=False)))
    ambient = np.array(MATERIAL.ambient)
    want = ambient + 0.75 * np.array((0.5, 0.75, 1.0)) * (bright.rgb - ambient)
    assert np.abs(out.rgb - want).max() < tolerance
    pixels = WIDTH * HEIGHT
    assert (out.tri < 2).all() and (out.tri >= 0).all() and (out.light[0] == frame.LIT).all()
    assert out.rays["shadow"] == 3 * pixels
    rays = out.pixel_rays(5, 7)
    assert list(rays["kind"]) == [0, 1, 1, 1] and list(rays["hit"]) == [1, 1, 1, 0]
    assert set(rays["tri"][1:3] // 2) == {1, 2} and rays["t"][1] < rays["t"][2]


@pytest.mark.parametrize("name", RENDERERS)
def test_opaque_behind_a_pane_blocks(name):
    """In whichever order they are met, and dim panes block on their own."""
    render, tolerance = RENDERERS[name]
    pane = Material("pane", (0, 0, 0), (0, 0, 0), transmit=(0.5, 0.5, 0.5))
    camera = Camera((0, 0, 0.5), (0.2, 0.1, 0), (0, 1, 0), 30.0)
    for sheets in ([MATERIAL, pane, BLACK], [MATERIAL, BLACK, pane]):
        image = layered(sheets, [0.0, 0.75, 1.5], max_depth=0)
        out = render(build_image(image.geometry, replace(image.view, camera=camera)))
        assert (out.light[0] == frame.SHADOWED).all()
        assert np.abs(out.rgb - MATERIAL.ambient).max() < tolerance
        last = out.log[out.start[1:] - 1]
        assert (last["hit"] == 1).all() and (last["tri"] // 2 == (2 if sheets[2] is BLACK else 1)).all()
    image = layered([MATERIAL, pane, pane], [0.0, 0.75, 1.5], max_depth=0)
    for least, rays in ((0.5, 1), (0.25, 2), (0.125, 3)):
        out = render(build_image(image.geometry, replace(image.view, camera=camera, min_weight=least)))
        assert out.rays["shadow"] == rays * WIDTH * HEIGHT
        assert (out.light[0] == (frame.LIT if rays == 3 else frame.SHADOWED)).all()


@pytest.mark.parametrize("name", RENDERERS)
def test_glass_slab_does_not_bend(name):
    """Through a slab a ray is as long as Snell's law says, and goes on behind it in the direction it came in."""
    render, tolerance = RENDERERS[name]
    glass = Material("glass", (0, 0, 0), (0, 0, 0), transmit=(1.0, 1.0, 1.0), ior=1.5)
    top, bottom = np.array(FLOOR) + (0, 0, 0.5), np.array(FLOOR)[:, ::-1]
    floor = np.array(FLOOR) + (0, 0, -1.0)
    scene = make_scene(np.concatenate((top, bottom, floor)), [glass, MATERIAL], background=BACK)
    scene.face_material = np.array([0, 0, 0, 0, 1, 1], np.int32)
    image = build_image(scene, plane_view(max_depth=2, lights=[Light((0, 0, -5))]))
    out, world = render(image), 2.0**image.geometry.unit.scale_exp
    pixel = 2.0 * np.tan(np.radians(22.5)) / HEIGHT
    for x, y in ((WIDTH // 2 + 4, HEIGHT // 2), (WIDTH // 2, HEIGHT // 2 - 6)):
        rays = out.pixel_rays(x, y)
        assert list(rays["kind"]) == [0, 3, 3] and list(rays["tri"] // 2) == [0, 1, 2]
        tan = pixel * np.hypot(x + 0.5 - WIDTH / 2, y + 0.5 - HEIGHT / 2)
        refracted = np.arcsin(np.sin(np.arctan(tan)) / 1.5)
        length = 0.5 / np.cos(refracted)
        assert np.isclose(rays["t"][1] * world, length, rtol=4 * tolerance)
        assert np.isclose(rays["t"][2] * world, 1.0 / np.cos(np.arctan(tan)), rtol=4 * tolerance)


# ---- textures --------------------------------------------------------------------------------------------------------


def halves(left, right, side=64):
    """A linear texture (RGBA bytes) of one colour where u < 1/2 and another beyond."""
    image = np.empty((side, side, 4), np.uint8)
    image[:, : side // 2], image[:, side // 2 :] = left, right
    return Texture(image, "clamp", "clamp", srgb=False)


def textured(materials, heights, **view):
    """As `layered`, with u from 0 at x = -1 to 1 at x = 1 and v downwards."""
    triangles = np.concatenate([np.array(FLOOR) + (0, 0, z) for z in heights])
    uv = np.stack(((triangles[..., 0] + 1) / 2, (1 - triangles[..., 1]) / 2), axis=2)
    scene = make_scene(triangles, materials, background=BACK, uv=uv)
    scene.face_material = np.repeat(np.arange(len(materials), dtype=np.int32), 2)
    return build_image(scene, plane_view(**view))


def sides(z=0.0):
    """Pixels that see the left and the right half of a layer, not near the middle: two (H, W) bool."""
    points = on_plane(z)
    return inside(points) & (points[..., 0] < -0.15), inside(points) & (points[..., 0] > 0.15)


@pytest.mark.parametrize("name", RENDERERS)
@pytest.mark.parametrize("trilinear", [False, True])
def test_texture_tints_ambient_and_diffuse(name, trilinear):
    render, tolerance = RENDERERS[name]
    painted = replace(MATERIAL, texture=halves((255, 51, 0, 255), (0, 255, 102, 255)), emission=(0.1, 0.0, 0.2))
    out = render(textured([painted], [0.0], trilinear=trilinear))
    for side, tint in zip(sides(), ((1.0, 0.2, 0.0), (0.0, 1.0, 0.4))):
        tint = np.array(tint)
        matt = replace(MATERIAL, diffuse=tuple(tint * MATERIAL.diffuse))
        want = np.array(painted.emission) + tint * MATERIAL.ambient + phong(on_plane(), matt)
        assert np.abs(out.rgb - want)[side].max() < tolerance


@pytest.mark.parametrize("name", RENDERERS)
def test_mask_of_a_texture(name):
    """A sheet with a hole: seen through it the floor, and the floor's shadow has the hole too."""
    render, tolerance = RENDERERS[name]
    sheet = Material("sheet", (0, 0.3, 0), (0, 0, 0), texture=halves((255,) * 4, (255, 255, 255, 0)), alpha_mode="mask")
    out = render(textured([MATERIAL, sheet], [0.0, 0.5], max_depth=1))
    solid, hole = sides(0.5)
    assert np.abs(out.rgb - (0, 0.3, 0))[solid].max() < tolerance
    floor = on_plane()
    at = (floor + (np.array(LAMP) - floor) * 0.25)[..., 0]  # where the shadow ray meets the sheet
    seen = hole & inside(floor)
    lit, dark = seen & (at > 0.1), seen & (at < -0.1)
    ambient = np.array(MATERIAL.ambient)
    assert np.abs(out.rgb - ambient - phong(floor))[lit].max() < tolerance
    if dark.any():
        assert np.abs(out.rgb - ambient)[dark].max() < tolerance
    # from below the sheet: more of the floor in shadow
    image = textured([MATERIAL, sheet], [0.0, 0.5], max_depth=1)
    under = replace(image.view, camera=Camera((0, 0, 0.4), (0, 0, 0), (0, 1, 0), 90.0))
    out = render(build_image(image.geometry, under))
    pixel = 2.0 * 0.4 / HEIGHT
    x = np.broadcast_to((np.arange(WIDTH) + 0.5 - WIDTH / 2) * pixel, (HEIGHT, WIDTH))
    at = x + (LAMP[0] - x) * 0.25
    lit, dark = at > 0.05, at < -0.05
    assert dark.sum() > 100 and np.abs(out.rgb - ambient)[dark].max() < tolerance
    assert lit.sum() > 100 and (out.rgb - ambient)[lit].min() > 0.1
    assert (out.light[0] == frame.SHADOWED)[dark].all() and (out.light[0] == frame.LIT)[lit].all()
    shadow_rays = np.array([(r["kind"] == frame.SHADOW).sum() for r in np.split(out.log, out.start[1:-1])])
    shadow_rays = shadow_rays.reshape(HEIGHT, WIDTH)
    assert (shadow_rays[lit] == 2).all() and (shadow_rays[dark] == 1).all()


@pytest.mark.parametrize("name", RENDERERS)
def test_stained_glass(name):
    """Glass tinted by a texture: what is behind is tinted, what is mirrored is not, and the light on the floor is."""
    render, tolerance = RENDERERS[name]
    glass = Material(
        *("glass", (0, 0, 0), (0, 0, 0)), transmit=(0.5, 0.5, 0.5), reflect=(0.25, 0.25, 0.25), ior=1.0,
        texture=halves((255, 0, 51, 255), (51, 255, 102, 255)),
    )  # fmt: skip
    out = render(textured([MATERIAL, glass], [0.0, 0.5], max_depth=1))
    floor = on_plane()
    at = (floor + (np.array(LAMP) - floor) * 0.25)[..., 0]
    tints = (np.array((1.0, 0.0, 0.2)), np.array((0.2, 1.0, 0.4)))
    compared = 0
    for pane, tint in zip(sides(0.5), tints):
        for light, stain in zip((at < -0.1, at > 0.1), tints):
            where = pane & light & inside(floor)
            compared += where.sum()
            want = 0.25 * np.array(BACK) + 0.5 * tint * (MATERIAL.ambient + 0.5 * stain * phong(floor))
            if where.any():
                assert np.abs(out.rgb - want)[where].max() < tolerance
    assert compared > 100


def test_textured_24_bits_are_near_double_precision():
    rng = np.random.default_rng(3)
    noise = Texture(rng.integers(0, 256, (128, 128, 4)).astype(np.uint8))
    sheet = Material("sheet", (0.1, 0.1, 0.1), (0.5, 0.5, 0.5), texture=noise, alpha_mode="blend", reflect=(0.2,) * 3)
    image = textured([replace(MATERIAL, texture=noise), sheet], [0.0, 0.5], max_depth=4, trilinear=True)
    single, double = frame.render_fp24(image), frame.render_double(image)
    assert check.psnr(check.channels(single.pixels), check.channels(double.pixels)) > check.PSNR_BOUNCED_DB


# ---- the order of rays, against recursion ------------------------------------------------------------------------------


def ball(centre, radius, steps=12):
    """Triangles of a sphere by longitude and latitude, and its normals."""
    lat, lon = np.linspace(0, np.pi, steps + 1), np.linspace(0, 2 * np.pi, 2 * steps + 1)
    p = np.stack(
        (np.outer(np.sin(lat), np.cos(lon)), np.outer(np.sin(lat), np.sin(lon)), np.outer(np.cos(lat), 1 + 0 * lon)),
        axis=2,
    )
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    tri = np.concatenate(
        (np.stack((a, b, c), axis=2)[:].reshape(-1, 3, 3), np.stack((a, c, d), axis=2).reshape(-1, 3, 3))
    )
    size = np.linalg.norm(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1)
    tri = tri[size > 1e-9]
    return tri * radius + np.array(centre), tri


def box_with_ball(kr=0.75, background=BACK):
    """A box with walls that mirror, open above, in it a smooth ball of glass and a leaf half transparent."""
    s = np.array(FLOOR, dtype=float)
    walls = [s - (0, 0, 1)]
    for turn in ((2, 0, 1), (1, 2, 0)):
        walls += [s[:, ::-1, turn] + np.eye(3)[turn.index(2)], s[..., turn] - np.eye(3)[turn.index(2)]]
    walls = np.concatenate(walls)
    sphere, normals = ball((0.2, 0.1, -0.3), 0.5)
    leaf = s * 0.4 + (-0.4, -0.4, 0.2)
    scene = make_scene(np.concatenate((walls, sphere, leaf)), background=background)
    scene.normals[len(walls) : len(walls) + len(sphere)] = normals
    wall = Material("wall", (0.02, 0.03, 0.04), (0.2, 0.15, 0.1), (0.2, 0.2, 0.2), 20.0, reflect=(kr, kr, kr))
    glass = Material(
        "glass",
        (0, 0, 0),
        (0, 0, 0),
        (0.5, 0.5, 0.5),
        100.0,
        reflect=(0.04,) * 3,
        transmit=(0.9, 1, 1),
        ior=1.5,
        fresnel=True,
    )
    blend = Material(
        "leaf", (0.02, 0.05, 0.01), (0.2, 0.5, 0.1), alpha=0.5, alpha_mode="blend", reflect=(0.1, 0.1, 0.1)
    )
    scene.materials = [wall, glass, blend]
    scene.face_material = np.repeat(np.arange(3, dtype=np.int32), (len(walls), len(sphere), len(leaf)))
    return scene


def box_view(width, height, lights=2, **more):
    lamps = [Light((-0.5 + 0.9 * (i % 2), -0.6 + 0.5 * (i // 2), 0.8), (0.6, 0.5, 0.4)) for i in range(lights)]
    return View(width, height, Camera((-1.1, -1.3, 1.5), (0.1, 0.1, -0.3), (0, 0, 1), 60.0), lamps, **more)


class Recursion:
    """docs/whitted.md as a recursive function, ray by ray, on the functions of the units; slow, and with no stack."""

    def __init__(self, image, double):
        self.shade = shade.DOUBLE if double else shade.FP24
        self.double, self.rays = double, []
        self.setup, self.tree = frame.setup_double(image) if double else frame.setup_fp24(image)
        self.slots = np.zeros(4, np.int64)

    def trace(self, org, d, t_min, t_max, skip, any_hit, kind, light, depth):
        if self.double:
            tri, t, beta, gamma = bvh.trace_ray(self.tree, org, d, t_min, t_max, skip[0], any_hit)
            mat, inst = self.tree.mat[tri], 0
        else:
            inverse = np.array([rgen.inverse(v) for v in d])
            none = (tracer.TRI_NONE, tracer.NOT_PLACED)
            tri, t, beta, gamma, mat, _, inst = tracer.trace_ray(
                self.tree, np.array(org), np.array(d), inverse, t_min, t_max, *(none if skip[0] < 0 else skip), any_hit, self.slots
            )
            tri = -1 if tri == tracer.TRI_NONE else tri
        self.rays.append((kind, light, tri >= 0, depth, tri, inst, *map(np.float32, (t, beta, gamma))))
        return (tri, inst), t, beta, gamma, mat

    def pixel(self, dirs):
        return self.path(
            tuple(self.setup.org), tuple(dirs), (1.0, 1.0, 1.0), 0.0, 0, frame.PRIMARY, (-1, 0), (0.0, 0.0, 0.0)
        )

    def path(self, org, d, w, length, depth, kind, skip, acc):
        s, unit, one = self.setup, self.shade, (1.0, 1.0, 1.0)
        t_min = tracer.T_MIN if kind == frame.PRIMARY else s.t_min
        surf, t, beta, gamma, mat = self.trace(org, d, t_min, tracer.HUGE, skip, False, kind, 0, depth)
        if surf[0] < 0:
            return unit.add_miss(acc, w, tuple(s.background))
        row, info = s.materials[mat], s.info[surf[0]]
        if surf[1]:  # in a placed object
            info = unit.place(info, self.tree.inst_place[surf[1]])
        p, g, m, md, length, inside = unit.hit_point(org, d, t, beta, gamma, info, length)
        alpha = unit.coverage(1.0, row)
        wl = unit.weight(alpha, w)
        acc = unit.add_surface(acc, wl, one, row)
        for l, light in enumerate(s.lights):
            culled, to, from_t, far, k = unit.light_job((p, g, m, d, md), light, row, one, s.t_min)
            if not culled:
                tr = self.light(p, to, from_t, far, surf, l, depth, one)
                acc = acc if tr is None else unit.add_light(acc, wl, tr, k)
        if depth < s.max_depth:
            children = unit.bounce((p, g, m, d, md), one, w, alpha, inside, row, s.min_weight)
            for kind, (traced, weight, direction, start) in zip((frame.REFLECT, frame.TRANSMIT), children):
                if traced:
                    acc = self.path(start, direction, weight, length, depth + 1, kind, surf, acc)
        return acc

    def light(self, p, to, from_t, far, skip, l, depth, tr):
        surf, t, _, _, mat = self.trace(p, to, from_t, far, skip, True, frame.SHADOW, l, depth)
        if surf[0] < 0:
            return tr
        row = self.setup.materials[mat]
        if shade.opaque(row):
            return None
        blocked, tr, from_t = self.shade.shadow_through(tr, t, (1.0, 1.0, 1.0), 1.0, row, self.setup.min_weight)
        return None if blocked else self.light(p, to, from_t, far, skip, l, depth, tr)


def placed(scene, parts, seed=4):
    """The scene with its last triangles as rigid objects, parts of so many; each in coordinates of its own, turned somehow."""
    rng, n = np.random.default_rng(seed), len(scene.triangles)
    numbers = np.concatenate((np.zeros(n - sum(parts), np.int32), np.repeat(np.arange(len(parts), dtype=np.int32) + 1, parts)))
    rigid = []
    for k in range(1, len(parts) + 1):
        turn, away = rotation(rng.normal(size=3), rng.uniform(0, 360)), rng.uniform(-1, 1, 3)
        mine = numbers == k
        rigid.append(Placed(turn, away, (scene.triangles[mine] - away) @ turn, scene.normals[mine] @ turn))
    return replace(scene, objects=numbers, placed=rigid)


@pytest.mark.parametrize("name", [*RENDERERS, "placed"])
def test_order_of_rays(name):
    """Every ray, every hit and every colour of some pixels, exactly."""
    scene, view = box_with_ball(), box_view(12, 8, max_depth=8, min_weight=0.01)
    if name == "placed":  # ball and leaf
        leaf = 2
        scene = placed(scene, (np.count_nonzero(scene.face_material == 1), leaf))
        image = build_image(build_geometry(scene, tbu.Params()), view)
    else:
        image = build_image(scene, view)
    out = RENDERERS.get(name, RENDERERS["fp24"])[0](image)
    assert out.by_depth[frame.TRANSMIT, 3] > 10 and out.by_depth[frame.REFLECT, 6] > 10
    assert set(out.log["inst"]) == ({0, 1, 2} if name == "placed" else {0})
    recursion = Recursion(image, name == "double")
    for y in range(8):
        for x in range(12):
            recursion.rays.clear()
            acc = recursion.pixel(out.dir[y, x])
            assert np.array_equal(out.rgb[y, x], acc)
            rays = out.pixel_rays(x, y)
            assert np.array_equal(np.array(recursion.rays, frame.RAY), rays)
    assert np.array_equal(recursion.slots, out.slots)


@pytest.mark.parametrize("name", RENDERERS)
def test_mirror_box_with_glass_at_depth_15(name):
    """It ends, and with least weight zero every path that stays in the box reaches the last depth."""
    image = build_image(box_with_ball(kr=0.9), box_view(12, 8, lights=4, max_depth=15, min_weight=0.002))
    out = RENDERERS[name][0](image)
    assert out.by_depth[frame.REFLECT, 15] > 0 and out.by_depth[frame.SHADOW, 15] > 0
    assert np.isfinite(out.rgb).all() and out.log["depth"].max() == 15
    shallow = RENDERERS[name][0](build_image(image.geometry, replace(image.view, max_depth=4)))
    assert shallow.log["depth"].max() == 4
    assert np.array_equal(shallow.by_depth[:, :4], out.by_depth[:, :4])


def test_t_min_and_what_is_not_opaque(seed):
    """A shadow ray ends at something opaque, or has found the nearest hit behind t_min; both tracers."""
    rng = np.random.default_rng(seed)
    triangles = rng.uniform(-0.5, 0.5, (200, 1, 3)) + rng.uniform(-0.45, 0.45, (200, 3, 3))  # large: leaves hold many
    triangles = fp24.round_to_fp24(triangles)
    opaque, mat = rng.random(200) < 0.1, rng.integers(0, 4096, 200)
    tree = kdtree.build(triangles, np.zeros(200, bool), None)
    words = triaccel.pack(triaccel.records(triangles), mat, opaque)
    box = fp24.round_to_fp24(np.stack((tree.bounds[0] - 2.0**-10, tree.bounds[1] + 2.0**-10)))
    arrays = tracer.decode(tree.nodes, tree.lists, words, box, tree.root)
    exact = bvh.build(triangles, mat, opaque)
    found, passed, wrong, behind = 0, 0, 0, 0
    for _ in range(1500):
        org, d = fp24.round_to_fp24(rng.uniform(-1, 1, 3)), rng.normal(size=3)
        d = fp24.round_to_fp24(d / np.linalg.norm(d))
        inverse = np.array([rgen.inverse(v) for v in d])
        t_min = float(fp24.round_to_fp24(rng.choice([tracer.T_MIN, rng.uniform(0.0, 1.0)])))
        tri, t, _, _, kind, solid, _ = tracer.trace_ray(
            arrays, org, d, inverse, t_min, tracer.HUGE, tracer.TRI_NONE, 0, True, np.zeros(4, np.int64)
        )
        tri64, t64, _, _ = bvh.trace_ray(exact, tuple(org), tuple(d), t_min, np.inf, -1, True)
        nearest, t_near = brute_force(triangles, org + t_min * d, d)  # as if the ray began there
        assert (tri64 < 0) == (nearest < 0)
        if tri64 >= 0:
            assert opaque[tri64] or tri64 == nearest
            assert t64 > t_min and (opaque[tri64] or np.isclose(t64, t_near + t_min))
        if (tri == tracer.TRI_NONE) != (nearest < 0):
            wrong += 1  # an edge
        elif nearest >= 0:
            found += 1
            assert t > t_min and kind == mat[tri] and solid == opaque[tri]
            if not solid:
                passed += 1
                wrong += tri != nearest
                behind += tri != nearest and t > t_near + t_min + 2.0**-8
    assert found > 300 and passed > 150 and wrong < 10 and behind < 3


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
    """What a perfect simulation of a frame would return: pixels interleaved, each with its rays in order."""
    want = check.expected_hits(out)
    pixel = want["y"].astype(int) * out.tri.shape[1] + want["x"]
    assert (np.diff(pixel) >= 0).all()
    hits = np.empty_like(want)
    hits[np.argsort(np.random.default_rng(1).permutation(pixel), kind="stable")] = want
    counters = dict(zip(check.SLOT_COUNTERS, map(int, out.slots)))
    counters |= {counter: out.rays[kind] for kind, counter in check.RAY_COUNTERS.items()}
    return SimpleNamespace(frame=out.pixels.copy(), hits=hits, stats={"counters": counters})


@pytest.fixture(scope="module")
def glazed():
    """The reference of a picture with rays of every kind, and the same as a perfect simulation gives it."""
    scene = box_with_ball()
    out = frame.render_fp24(build_image(scene, box_view(24, 16, max_depth=4)))
    assert (out.by_depth.sum(axis=1) > 0).all()
    return out


def test_perfect_simulation_passes(glazed):
    exact = check.compare_rtl(as_simulated(glazed), glazed)
    assert exact.same and exact.rays == glazed.by_depth.sum() == len(glazed.log) and not exact.examples


def first(hits, kind, hit):
    return np.flatnonzero((hits["kind"] == kind) & (hits["hit"] == hit))[0]


@pytest.mark.parametrize("kind", range(4), ids=frame.KINDS)
@pytest.mark.parametrize("name", ["tri", "inst", "t", "beta", "gamma", "kind", "depth", "hit"])
def test_one_wrong_hit_is_seen(glazed, kind, name):
    result = as_simulated(glazed)
    result.hits[name][first(result.hits, kind, 1)] ^= 1
    exact = check.compare_rtl(result, glazed)
    assert (exact.pixels, exact.hits, exact.counters) == (0, 1, {})
    assert len(exact.examples) == 1 and f"another {name}" in exact.examples[0]


def test_light_of_a_shadow_ray_is_compared(glazed):
    result = as_simulated(glazed)
    result.hits["light"][first(result.hits, frame.SHADOW, 0)] ^= 1
    result.hits["light"][first(result.hits, frame.PRIMARY, 1)] ^= 1  # means nothing
    assert check.compare_rtl(result, glazed).hits == 1


def test_hit_of_what_hit_nothing_means_nothing(glazed):
    for kind in range(4):
        result = as_simulated(glazed)
        missed = first(result.hits, kind, 0)
        result.hits["t"][missed] ^= 1
        assert check.compare_rtl(result, glazed).same
        result.hits["tri"][missed] ^= 1
        assert check.compare_rtl(result, glazed).hits == (kind != frame.SHADOW)
        result.hits["hit"][missed] = 1
        assert check.compare_rtl(result, glazed).hits == 1


def test_rays_of_a_pixel_in_another_order_are_seen(glazed):
    result = as_simulated(glazed)
    hits = result.hits
    one = first(hits, frame.REFLECT, 1)
    same = np.flatnonzero((hits["x"] == hits["x"][one]) & (hits["y"] == hits["y"][one]))
    hits[same[:2]] = hits[same[1::-1]]
    assert check.compare_rtl(result, glazed).hits == 2


def test_lost_doubled_and_unknown_rays_are_seen(glazed):
    result = as_simulated(glazed)
    whole = result.hits
    pixel = whole["y"].astype(int) * 24 + whole["x"]
    last = np.flatnonzero(pixel == pixel[first(whole, frame.TRANSMIT, 1)])[-1]
    result.hits = np.delete(whole, last)
    exact = check.compare_rtl(result, glazed)
    assert exact.hits == 1 and len(exact.examples) == 1
    result.hits = np.insert(whole, last + 1, whole[last])
    assert check.compare_rtl(result, glazed).hits == 1
    result.hits = whole[:0]
    assert check.compare_rtl(result, glazed).hits == len(whole)
    stray = whole[:1].copy()
    stray["x"] = 24
    result.hits = np.concatenate((whole, stray))
    exact = check.compare_rtl(result, glazed)
    assert exact.hits == 1 and len(exact.examples) == 1


def test_wrong_pixels_and_counters_are_seen(roof):
    out = frame.render_fp24(roof)
    result = as_simulated(out)
    result.frame[3, 4] ^= 1
    result.stats["counters"]["SLOTS_TRAV2"] += 1
    exact = check.compare_rtl(result, out)
    assert exact.pixels == 1 and list(exact.counters) == [check.STEPS]
    result.stats["counters"]["SLOTS_TRAV1"] -= 2    # the same steps in other slots
    assert not check.compare_rtl(result, out).counters


def test_pictures():
    a = np.zeros((4, 4, 3), np.uint8)
    b = a.copy()
    b[0, 0] = 255, 0, 2
    assert check.psnr(a, a) == np.inf
    assert np.isclose(check.psnr(a, b), 10 * np.log10(255.0**2 * 48 / (255.0**2 + 4)))
    assert check.difference(a, b)[0, 0].tolist() == [255, 0, 32]
    ten = pixbuf.pack(fp24.round_to_fp24(np.array([[[1.0, 0.5, 0.0]]])), pixbuf.RGB10A2)
    assert check.channels(ten, pixbuf.RGB10A2).tolist() == [[[255, 128, 0]]]


def test_same_rays(glazed):
    """A pixel counts if all of its rays meet the same; distances are no matter."""
    assert check.same_rays(glazed, glazed).all()
    other = copy.deepcopy(glazed)
    other.log["t"] += 0.001
    assert check.same_rays(glazed, other).all()
    other.log["tri"][(glazed.log["kind"] == frame.SHADOW) & (glazed.log["hit"] == 1)] = 0
    assert check.same_rays(glazed, other).all()
    pixels = []
    for kind, name in (
        (frame.REFLECT, "tri"),
        (frame.TRANSMIT, "tri"),
        (frame.SHADOW, "hit"),
        (frame.PRIMARY, "depth"),
    ):
        ray = np.flatnonzero(glazed.log["kind"] == kind)[40 * kind]
        other.log[name][ray] ^= 1
        pixels.append(np.searchsorted(glazed.start, ray, side="right") - 1)
    assert np.flatnonzero(~check.same_rays(glazed, other)).tolist() == sorted(set(pixels))
    other.log = np.delete(other.log, glazed.start[7])
    other.start[8:] -= 1
    assert np.flatnonzero(~check.same_rays(glazed, other)).tolist() == sorted({7, *pixels})


def test_24_bits_with_bounces_are_near_double_precision():
    """Where a pixel's rays meet the same triangles the picture is as near as without bounces."""
    image = build_image(box_with_ball(), box_view(96, 64, max_depth=6))
    single, double = frame.render_fp24(image), frame.render_double(image)
    same = check.same_rays(single, double)
    a, b = check.channels(single.pixels), check.channels(double.pixels)
    assert same.mean() > 0.8
    assert check.psnr(a, b) > check.PSNR_BOUNCED_DB and check.psnr(a[same], b[same]) > 60.0
