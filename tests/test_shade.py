# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""raycore.model.shade: double precision against plain vector algebra, FP24 against double precision, decisions one by one."""

import math

import numpy as np
import pytest

from raycore import image
from raycore.model import fp24, shade
from raycore.model.shade import ALPHA_BLEND, ALPHA_MASK, ALPHA_OPAQUE

ONE, NONE = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
TWINS = pytest.mark.parametrize("twin", [shade.FP24, shade.DOUBLE], ids=["fp24", "double"])
COLUMN = {name: i for i, name in enumerate(shade.MATERIAL_COLUMNS)}


def unit(v):
    return v / np.linalg.norm(v)


def material(twin=shade.FP24, **columns):
    """A material's row: colours as amb=(r, g, b) and so on, everything else by name; FP24 numbers but for the double twin."""
    row = np.zeros(len(shade.MATERIAL_COLUMNS))
    row[[COLUMN["alpha"], COLUMN["ior"], COLUMN["inv_ior"], COLUMN["shin"]]] = 1.0
    if "ior" in columns:
        row[COLUMN["inv_ior"]] = 1.0 / columns["ior"]
    for name, value in columns.items():
        at = COLUMN[name] if name in COLUMN else COLUMN[f"{name}_r"]
        row[at : at + np.size(value)] = value
    row[COLUMN["reflects"]] = row[COLUMN["kr_r"] : COLUMN["kr_b"] + 1].any()
    row[COLUMN["transmits"]] = row[COLUMN["kt_r"] : COLUMN["kt_b"] + 1].any()
    return fp24.round_to_fp24(row) if twin is shade.FP24 else row


def random_scene(seed):
    """Records that make sense, all of them FP24 numbers: (org, d, t, beta, gamma, info, length), light, material, tex."""
    rng = np.random.default_rng(seed)
    a, e1, e2 = rng.uniform(-0.5, 0.5, 3), rng.uniform(-0.4, 0.4, 3), rng.uniform(-0.4, 0.4, 3)
    n = unit(np.cross(e1, e2))
    normals = [unit(n + 0.3 * rng.normal(size=3)) for _ in range(3)]
    beta, gamma = rng.uniform(0, 0.5, 2)
    org = rng.uniform(-1, 1, 3)
    to_hit = a + beta * e1 + gamma * e2 - org
    t = np.linalg.norm(to_hit)
    info = np.array([a, n, normals[0], normals[1] - normals[0], normals[2] - normals[0]])
    light = np.array([0.0, *rng.uniform(-1, 1, 3), *rng.uniform(0.1, 1, 3), *rng.uniform(0.2, 1, 3)])
    length = rng.choice([0.0, rng.uniform(0, 4)])
    rounded = [
        fp24.round_to_fp24(v) for v in (org, to_hit / t, t, beta, gamma, info, length, light, rng.uniform(0, 1, 3))
    ]
    colours = {name: rng.uniform(0, 1, 3) for name in ("amb", "diff", "spec", "emis", "kr")}
    flags = {"fresnel": rng.integers(2), "tex_kr": rng.integers(2), "alpha_mode": rng.integers(3)}
    if flags["alpha_mode"] == ALPHA_OPAQUE and rng.integers(3):
        colours["kt"] = rng.uniform(0, 1, 3)
    numbers = {
        "shin": rng.uniform(0, 16),
        "alpha": rng.uniform(),
        "cutoff": rng.uniform(),
        "ior": rng.uniform(0.5, 2.5),
    }
    org, d, tex = (tuple(map(float, rounded[i])) for i in (0, 1, 8))
    hit = (org, d, *map(float, rounded[2:5]), rounded[5], float(rounded[6]))
    return hit, rounded[7], material(**colours, **flags, **numbers), tex


def context(twin, hit):
    """(context, length, inside) of a hit."""
    p, g, m, md, length, inside = twin.hit_point(*hit)
    return (p, g, m, hit[1], md), length, inside


SEEDS = range(200)


def test_columns_are_those_of_the_records():
    assert shade.MATERIAL_COLUMNS == image.MATERIAL_COLUMNS
    for name in ("amb", "diff", "spec", "emis", "kr", "kt"):
        assert getattr(shade, name.upper()) == COLUMN[f"{name}_r"]
    for name in shade.MATERIAL_COLUMNS:
        if "_r" not in name[-2:] and "_g" not in name[-2:] and "_b" not in name[-2:]:
            assert getattr(shade, name.upper()) == COLUMN[name]
    assert (ALPHA_OPAQUE, ALPHA_MASK, ALPHA_BLEND) == tuple(map(image.ALPHA_MODES.index, ("opaque", "mask", "blend")))


# ---- hit point and lights ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(50))
def test_double_hit_point(seed):
    """P is on the plane but for the lift, g faces the viewer, m is the interpolated normal on g's side."""
    (org, d, t, beta, gamma, info, before), *_ = random_scene(seed)
    p, g, m, md, length, inside = map(np.array, shade.DOUBLE.hit_point(org, d, t, beta, gamma, info, before))
    a, n, n0, e1, e2 = info
    side = -1.0 if n @ d > 0 else 1.0
    assert np.array_equal(g, side * n) and g @ d <= 0
    # n is unit to within its rounding, and the correction to the plane is of first order in what is left
    assert (p - a) @ g == pytest.approx(
        shade.HIT_LIFT, abs=1e-4 * abs((np.array(org) + t * np.array(d) - a) @ n) + 1e-9
    )
    assert np.linalg.norm(np.cross(p - (np.array(org) + t * np.array(d)), n)) < 1e-12
    assert m == pytest.approx(side * unit(n0 + beta * e1 + gamma * e2), abs=1e-12)
    assert md == pytest.approx(m @ np.array(d), abs=1e-12)
    assert length == before + t and inside == (n @ d > 0)


@pytest.mark.parametrize("seed", range(50))
@pytest.mark.parametrize("directional", [False, True])
def test_double_light(seed, directional):
    """Phong's model, with the mirrored direction written out."""
    hit, light, row, tex = random_scene(seed)
    light[0] = directional
    ctx, *_ = context(shade.DOUBLE, hit)
    culled, to, t_min, t_max, k = shade.DOUBLE.light_job(ctx, light, row, tex, 0.375)
    p, g, m, d = map(np.array, ctx[:4])
    offset = light[1:4] if directional else light[1:4] - p
    dist = np.linalg.norm(offset)
    direction = offset / dist
    assert to == pytest.approx(direction, abs=1e-12)
    assert t_min == 0.375 and t_max == (2.0**62 if directional else pytest.approx(dist))
    assert culled == (g @ direction <= 0 or m @ direction <= 0)
    mirrored = 2 * (m @ direction) * m - direction
    along = mirrored @ -d
    spec = along ** row[COLUMN["shin"]] if along > 0 else 0.0
    c, l, q = light[7:]
    att = 1.0 if directional else 1 / (c + l * dist + q * dist**2)
    want = (row[3:6] * tex * (m @ direction) + row[6:9] * spec) * light[4:7] * att
    assert k == pytest.approx(want, rel=1e-9, abs=1e-12)


@TWINS
def test_shininess(twin):
    """What is straight in the mirrored direction is 1 whatever the shininess; none at all is everywhere where R . V > 0."""
    d, up, p = (0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)
    light = np.array([0, 0, 1, 0, 1, 1, 1, 1, 0, 0], dtype=float)
    for shin in (0.0, 0.5, 1.0, 2.0, 37.5, 1024.0):
        row = material(spec=ONE, shin=shin)
        assert twin.light_job((p, up, up, d, -1.0), light, row, ONE, 0.0)[4] == ONE
        tilted = (p, up, up, (0.0, -0.75, 0.0), -0.75)  # R . V = 0.75
        slack = max(2.0**-14, shin * 2.0**-16) if twin is shade.FP24 else 1e-12
        assert twin.light_job(tilted, light, row, ONE, 0.0)[4][0] == pytest.approx(0.75**shin, rel=slack)
        beside = (p, up, up, (1.0, 0.0, 0.0), 0.0)  # R . V = 0
        assert twin.light_job(beside, light, row, ONE, 0.0)[4] == NONE


def test_light_special_cases():
    """What docs/shade.md says of NaN, of a light in the hit point."""
    d, up, p = (0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)
    info = np.zeros((5, 3))
    info[1] = up  # no vertex normal
    _, g, m, md, *_ = shade.FP24.hit_point((0.0, 1.0, 0.0), d, 1.0, 0.25, 0.25, info, 0.0)
    assert g == up and all(map(math.isnan, (*m, md)))
    light = np.array([0, 0, 1, 0, 1, 1, 1, 1, 0, 0], dtype=float)
    row = material(diff=(0.5, 0.5, 0.5), spec=ONE)
    assert shade.FP24.light_job((p, up, m, d, md), light, row, ONE, 0.0)[0], "NaN is culled"
    at_point = light.copy()
    at_point[1:4] = p
    assert shade.FP24.light_job((p, up, up, d, -1.0), at_point, row, ONE, 0.0)[0], "a light in the hit point is culled"
    job = shade.FP24.light_job((p, up, up, d, -1.0), light, row, (1.0, 0.5, 0.0), 0.5)
    assert job == (False, up, 0.5, 1.0, (1.5, 1.25, 1.0))


@TWINS
def test_flip_is_a_mirror(twin):
    """Seen from the other side, all normals turn and nothing else changes but that this is inside."""
    for seed in range(20):
        (org, d, t, beta, gamma, info, length), *_ = random_scene(seed)
        turned = info.copy()
        turned[1:] *= -1
        *one, inside = twin.hit_point(org, d, t, beta, gamma, info, length)
        *other, outside = twin.hit_point(org, d, t, beta, gamma, turned, length)
        assert one == other and inside != outside


# ---- alpha, colours, transparent shadows -------------------------------------------------------------------------------


@TWINS
def test_coverage(twin):
    """alpha' by mode."""
    for ta in (0.0, 0.25, 0.5, 1.0, math.nan):
        assert twin.coverage(ta, material(alpha=0.5)) == 1.0
        blend = twin.coverage(ta, material(alpha=0.5, alpha_mode=ALPHA_BLEND))
        assert blend == 0.5 * ta or math.isnan(ta)
        masked = twin.coverage(ta, material(alpha=0.5, cutoff=0.25, alpha_mode=ALPHA_MASK))
        assert masked == (1.0 if ta >= 0.5 else 0.0)  # half of it is at least a quarter; not for NaN


@TWINS
def test_colours(twin):
    acc, w, tex = (0.5, 0.25, 0.125), (0.5, 0.25, 1.0), (1.0, 0.5, 0.25)
    assert twin.add_miss(acc, w, (1.0, 2.0, 4.0)) == (1.0, 0.75, 4.125)
    row = material(amb=(0.5, 0.5, 1.0), emis=(1.0, 0.25, 0.0))
    assert twin.add_surface(acc, w, tex, row) == (1.25, 0.375, 0.375)
    assert twin.add_light(acc, w, (0.5, 1.0, 0.0), (2.0, 1.0, 3.0)) == (1.0, 0.5, 0.125)
    assert twin.weight(0.5, w) == (0.25, 0.125, 0.5)


@TWINS
def test_transmittance_of_two_panes(twin):
    """Colours of glass multiply, of something half covered what it covers is lost."""
    glass = material(kt=(0.5, 0.75, 1.0))
    leaf = material(alpha=0.5, alpha_mode=ALPHA_BLEND)
    blocked, tr, _ = twin.shadow_through(ONE, 1.0, (1.0, 0.5, 1.0), 1.0, glass, 0.0)
    assert (blocked, tr) == (False, (0.5, 0.375, 1.0))
    blocked, tr, _ = twin.shadow_through(tr, 2.0, ONE, 1.0, glass, 0.0)
    assert (blocked, tr) == (False, (0.25, 0.28125, 1.0))
    blocked, tr, _ = twin.shadow_through(tr, 3.0, NONE, 0.5, leaf, 0.0)  # the leaf's colour is no matter
    assert (blocked, tr) == (False, (0.1875, 0.2109375, 0.75))


@TWINS
def test_mask_lets_through_or_blocks(twin):
    leaf = material(cutoff=0.5, alpha_mode=ALPHA_MASK)
    assert twin.shadow_through((0.5, 1.0, 0.25), 1.0, NONE, 0.25, leaf, 0.0)[:2] == (False, (0.5, 1.0, 0.25))
    assert twin.shadow_through(ONE, 1.0, ONE, 0.5, leaf, 0.0)[:2] == (True, NONE)
    assert twin.shadow_through(ONE, 1.0, ONE, 1.0, material(), 0.0)[:2] == (True, NONE), "what is opaque blocks"


@TWINS
def test_least_transmittance(twin):
    """Blocked if no colour is above the least weight; equal is not above."""
    glass = material(kt=(0.25, 0.0, 0.0))
    for least, blocked in ((0.125, False), (0.25, True), (0.5, True)):
        assert twin.shadow_through(ONE, 1.0, ONE, 1.0, glass, least)[0] == blocked
    assert twin.shadow_through((math.nan, 0.0, 0.0), 1.0, ONE, 1.0, glass, 0.0)[0], "NaN is not above"


def test_where_a_shadow_ray_starts_again():
    """Behind what it passed, by 2^-14 and 16 units in the last place, so that it is at least 8 of them at any distance."""
    for t in (2.0**-14, 0.5, 1.0, 1.9, 100.0, 2.0**20):
        t = fp24.rnd(t)
        again = shade.FP24.shadow_through(ONE, t, ONE, 1.0, material(kt=ONE), 0.0)[2]
        ulp = 2.0 ** (math.floor(math.log2(t)) - 16)
        assert again >= t + 2.0**-14 + 15 * ulp and again <= t + 2.0**-14 + 17 * ulp + (
            2.0**-14 if t < 2.0**-13 else 0.0
        )
        assert shade.DOUBLE.shadow_through(ONE, t, ONE, 1.0, material(kt=ONE), 0.0)[2] > t


@TWINS
def test_opaque(twin):
    assert shade.opaque(material()) and shade.opaque(material(kr=ONE))
    assert not shade.opaque(material(kt=(0.0, 0.0, 0.5)))
    assert not shade.opaque(material(alpha_mode=ALPHA_MASK)) and not shade.opaque(material(alpha_mode=ALPHA_BLEND))


# ---- bounces -----------------------------------------------------------------------------------------------------------

DEGREES = (0.0, 1.0, 20.0, 41.0, 42.5, 60.0, 80.0, 89.0)


def tolerance(twin):
    return 2.0**-12 if twin is shade.FP24 else 1e-12


def flat(degrees, twin):
    """Context of a ray that comes down at an angle to the normal +z, in the x-z plane, at the origin."""
    d = np.array([math.sin(math.radians(degrees)), 0.0, -math.cos(math.radians(degrees))])
    d = tuple(map(float, fp24.round_to_fp24(d) if twin is shade.FP24 else d))
    up = (0.0, 0.0, 1.0)
    return (NONE, up, up, d, d[2])


def bounce(twin, degrees, row, inside=False, tex=ONE, w=ONE, alpha=1.0, least=0.0):
    return twin.bounce(flat(degrees, twin), tex, w, alpha, inside, row, least)


@TWINS
@pytest.mark.parametrize("degrees", DEGREES)
def test_mirror(twin, degrees):
    """The mirrored direction, the whole weight, from the hit point; nothing goes through."""
    (traced, w, d, org), (through, *_) = bounce(twin, degrees, material(twin, kr=(1.0, 0.5, 0.25)), w=(0.5, 0.5, 1.0))
    assert traced and not through
    assert w == (0.5, 0.25, 0.25) and org == NONE
    sin, cos = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    assert d == pytest.approx((sin, 0.0, cos), abs=tolerance(twin))


@TWINS
@pytest.mark.parametrize("degrees", DEGREES)
@pytest.mark.parametrize("ior", [1.0, 1.33, 1.5, 2.4])
def test_snell(twin, degrees, ior):
    """sin i = n sin r, on entering and on leaving; beyond the critical angle all is reflected."""
    row = material(twin, kt=ONE, ior=ior)
    _, (traced, w, d, org) = bounce(twin, degrees, row)
    sin = math.sin(math.radians(degrees))
    assert traced and w == ONE and org == (0.0, 0.0, -(2.0**-16))
    assert d == pytest.approx((sin / ior, 0.0, -math.sqrt(1 - (sin / ior) ** 2)), abs=4 * tolerance(twin))
    (back, r_w, r_d, _), (traced, w, d, _) = bounce(twin, degrees, row, inside=True)
    if abs(sin * ior - 1.0) > 0.01:
        assert traced == (sin * ior < 1.0) and back != traced
    if traced:
        assert d == pytest.approx((sin * ior, 0.0, -math.sqrt(1 - (sin * ior) ** 2)), abs=64 * tolerance(twin))
    else:
        assert r_w == ONE and r_d == pytest.approx((sin, 0.0, math.cos(math.radians(degrees))), abs=tolerance(twin))


@TWINS
@pytest.mark.parametrize("ior", [1.1, 1.5, 2.0, 3.0])
def test_threshold_of_total_reflection(twin, ior):
    """Where it begins, to a hundredth of a degree; in 24 bits 1 - eta^2 + (eta c)^2 is off by 2^-16 eta^2."""
    critical = math.degrees(math.asin(1.0 / ior))
    row = material(twin, kt=ONE, ior=ior)
    # d k / d angle = eta^2 sin(2 angle), so that an error of k moves the threshold by
    slack = 0.01 if twin is shade.FP24 else 1e-9
    if twin is shade.FP24:
        slack += math.degrees(2.0**-15 * (1 + ior**2) / (ior**2 * math.sin(2 * math.radians(critical))))
    assert bounce(twin, critical - slack, row, inside=True)[1][0]
    assert not bounce(twin, critical + slack, row, inside=True)[1][0]


@TWINS
def test_pane(twin):
    """Through two parallel surfaces a ray goes on in its direction, its path reversed likewise."""
    row = material(twin, kt=ONE, ior=1.5)
    for degrees in DEGREES[:-1]:
        ctx = flat(degrees, twin)
        d = twin.bounce(ctx, ONE, ONE, 1.0, False, row, 0.0)[1][2]
        out = twin.bounce((*ctx[:3], d, d[2]), ONE, ONE, 1.0, True, row, 0.0)[1][2]
        assert out == pytest.approx(ctx[3], abs=16 * tolerance(twin) / math.cos(math.radians(degrees)))


@TWINS
def test_schlick(twin):
    """The reflectance at normal incidence is kr, at grazing incidence 1, and what is not reflected goes through."""
    for kr, kt in ((0.04, 1.0), (0.5, 0.5), (0.0, 1.0)):
        row = material(twin, kr=(kr, kr, kr), kt=(kt, kt, kt), fresnel=1, ior=1.5)
        kr, kt = row[COLUMN["kr_r"]], row[COLUMN["kt_r"]]
        for degrees in (*DEGREES, 90.0):
            one, two = bounce(twin, degrees, row)
            cos = -flat(degrees, twin)[4]
            want = kr + (1 - kr) * (1 - max(cos, 0.0)) ** 5
            assert one[1][0] == pytest.approx(want, abs=tolerance(twin))
            assert two[1][0] == pytest.approx(kt * (1 - want), abs=tolerance(twin))
            assert one[0] == (one[1][0] > 0 and kr > 0) and two[0] == (two[1][0] > 0)
        assert bounce(twin, 0.0, row)[0][1][0] == kr
        assert bounce(twin, 90.0, row)[0][1][0] == pytest.approx(1.0, abs=1e-15)
        assert bounce(twin, 90.0, row)[1][1][0] == pytest.approx(0.0, abs=1e-15)


@TWINS
def test_schlick_is_reciprocal(twin):
    """From inside the angle that counts is the one outside: both ways along one path reflect equally much."""
    row = material(twin, kr=(0.04, 0.04, 0.04), kt=ONE, fresnel=1, ior=1.5)
    for degrees in (0.0, 20.0, 40.0, 41.5):
        outside = math.degrees(math.asin(1.5 * math.sin(math.radians(degrees))))
        there, back = bounce(twin, outside, row)[0][1][0], bounce(twin, degrees, row, inside=True)[0][1][0]
        assert there == pytest.approx(back, abs=2.0**-8 if twin is shade.FP24 else 1e-9)
    assert bounce(twin, 45.0, row, inside=True)[0][1] == ONE, "all is reflected beyond the critical angle"


@TWINS
@pytest.mark.parametrize("fresnel", [0, 1])
def test_no_energy_is_made(twin, fresnel):
    """What is reflected, goes through and stays (alpha) is no more than what came."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        kr = rng.uniform(0, 1, 3)
        row = material(twin, kr=kr, kt=1 - kr, fresnel=fresnel, ior=rng.uniform(0.4, 2.5))
        one, two = bounce(twin, rng.uniform(0, 90), row, inside=bool(rng.integers(2)), w=(0.5, 0.25, 0.75))
        total = np.array(one[1]) * one[0] + np.array(two[1]) * two[0]
        assert (total <= np.array([0.5, 0.25, 0.75]) * (1 + 2.0**-14)).all()
        if not fresnel:
            assert total == pytest.approx((0.5, 0.25, 0.75), rel=2.0**-14)


@TWINS
@pytest.mark.parametrize("mode", [ALPHA_MASK, ALPHA_BLEND])
def test_alpha_goes_straight_on(twin, mode):
    """What is not covered goes on in the same direction, just behind; the covered part mirrors."""
    row = material(twin, alpha_mode=mode, kr=(0.5, 0.5, 0.5))
    one, two = bounce(twin, 60.0, row, w=(1.0, 0.5, 0.25), alpha=0.75, tex=(0.25, 0.25, 0.25))
    assert one[0] and one[1] == (0.375, 0.1875, 0.09375)
    assert two == (True, (0.25, 0.125, 0.0625), flat(60.0, twin)[3], (0.0, 0.0, -(2.0**-16)))
    assert not bounce(twin, 60.0, row, alpha=1.0)[1][0] and not bounce(twin, 60.0, row, alpha=0.0)[0][0]


@TWINS
def test_texture_tints(twin):
    """The reflection of a metal and what goes through glass, not the reflection of glass; rays behind alpha never."""
    tex = (0.5, 0.25, 1.0)
    assert bounce(twin, 30.0, material(twin, kr=ONE, tex_kr=1), tex=tex)[0][1] == tex
    one, two = bounce(twin, 30.0, material(twin, kr=(0.5, 0.5, 0.5), kt=(0.5, 0.5, 0.5)), tex=tex)
    assert one[1] == (0.5, 0.5, 0.5) and two[1] == (0.25, 0.125, 0.5)


@TWINS
def test_least_weight(twin):
    """A child is traced if one colour weighs more than the least; equal is not more."""
    row = material(twin, kr=(0.25, 0.0, 0.0), kt=(0.0, 0.0, 0.5))
    for least, want in ((0.125, (True, True)), (0.25, (False, True)), (0.375, (False, True)), (0.5, (False, False))):
        one, two = bounce(twin, 10.0, row, least=least)
        assert (one[0], two[0]) == want
    one, two = bounce(twin, 10.0, row, w=(math.nan, math.nan, math.nan))
    assert not one[0] and not two[0], "NaN weighs nothing"


@pytest.mark.parametrize("seed", range(100))
def test_children_leave_on_their_side(seed):
    """With any shading normal: reflected rays go up, transmitted ones down, both of length one."""
    rng = np.random.default_rng(seed)
    g, d, m = np.array([0.0, 0.0, 1.0]), unit(rng.normal(size=3)), unit(rng.normal(size=3) * (1, 1, 0.3))
    d[2], m[2] = -abs(d[2]), abs(m[2])
    ctx = tuple(tuple(map(float, fp24.round_to_fp24(v))) for v in (NONE, g, m, d))
    md = sum(fp24.rnd(x * y) for x, y in zip(ctx[2], ctx[3]))
    row = material(kr=ONE, kt=ONE, ior=rng.uniform(0.5, 2.0))
    one, two = shade.FP24.bounce((*ctx, fp24.rnd(md)), ONE, ONE, 1.0, bool(rng.integers(2)), row, 0.0)
    assert one[2][2] >= -(2.0**-15) and np.linalg.norm(one[2]) == pytest.approx(1.0, abs=2.0**-14)
    if two[0]:
        assert two[2][2] <= 2.0**-15 and np.linalg.norm(two[2]) == pytest.approx(1.0, abs=2.0**-14)


@TWINS
def test_refracted_over_the_horizon(twin):
    """A steep shading normal would refract a ray to the side it came from; it is mirrored at the triangle's plane."""
    d, g, m = (0.9950, 0.0, -0.0999), (0.0, 0.0, 1.0), (-0.9539, 0.0, 0.3001)
    ctx = tuple(tuple(map(float, fp24.round_to_fp24(np.array(v)))) for v in (NONE, g, m, d))
    md = fp24.rnd(sum(x * y for x, y in zip(m, d)))
    _, (traced, _, s, _) = twin.bounce((*ctx, md), ONE, ONE, 1.0, False, material(twin, kt=ONE, ior=0.5), 0.0)
    c, eta = -md, 2.0
    want = eta * np.array(d) + (eta * c - math.sqrt(1 - eta**2 + (eta * c) ** 2)) * np.array(m)
    assert want[2] > 0.05 and traced
    assert s == pytest.approx(unit(want * (1, 1, -1)), abs=1e-3)


@pytest.mark.parametrize("seed", range(50))
def test_double_bounce(seed):
    """Mirrored and refracted directions from first principles: the plane of incidence, Snell's law, reflection about g."""
    hit, _, row, tex = random_scene(seed)
    ctx, _, inside = context(shade.DOUBLE, hit)
    one, two = shade.DOUBLE.bounce(ctx, tex, ONE, 1.0, inside, row, 0.0)
    p, g, m, d = map(np.array, ctx[:4])
    n = unit(m)
    r = d - 2 * (d @ n) * n
    r = r - 2 * min(g @ r, 0.0) * g
    assert one[2] == pytest.approx(unit(r), abs=1e-9) and one[3] == ctx[0]
    assert two[3] == pytest.approx(p - 2.0**-16 * g, abs=1e-15)
    if not row[COLUMN["transmits"]]:
        assert two[2] == ctx[3]
    elif two[0] and m @ d < 0:
        s = np.array(two[2])
        turned = s - 2 * (g @ s) * g  # had it left on the wrong side
        eta = row[COLUMN["ior"]] if inside else row[COLUMN["inv_ior"]]
        snell = [np.linalg.norm(np.cross(v, n) - eta * np.cross(d, n)) for v in (s, turned)]
        assert min(snell) < 1e-4 * eta and g @ s < 0  # d is unit to within its rounding


# ---- 24 bits against double precision ----------------------------------------------------------------------------------


def test_fp24_is_close():
    """Where no decision is near: 2^-13 of one for positions, 2^-8 for colours up to 3 and for directions of children."""
    near, lit, bounced = 0, 0, 0
    worst = np.zeros(2)
    for seed in SEEDS:
        hit, light, row, tex = random_scene(seed)
        e_ctx, e_length, e_inside = context(shade.DOUBLE, hit)
        ctx, length, inside = context(shade.FP24, hit)
        if abs(np.dot(e_ctx[1], hit[1])) < 1e-3:
            near += 1
            continue
        assert inside == e_inside and length == pytest.approx(e_length, rel=2.0**-16)
        for a, b in zip(ctx[:3], e_ctx[:3]):
            assert a == pytest.approx(b, abs=2.0**-13)
        e_culled, e_to, _, e_t, e_k = shade.DOUBLE.light_job(e_ctx, light, row, tex, 0.0)
        culled, to, _, t_max, k = shade.FP24.light_job(ctx, light, row, tex, 0.0)
        assert to == pytest.approx(e_to, abs=2.0**-11) and t_max == pytest.approx(e_t, rel=2.0**-11)
        if min(abs(np.dot(e_ctx[1], e_to)), abs(np.dot(e_ctx[2], e_to))) > 1e-3:
            assert culled == e_culled
            if not culled:
                assert k == pytest.approx(e_k, abs=2.0**-8)
                lit += 1
        ours = shade.FP24.bounce(ctx, tex, ONE, 0.5, inside, row, 2.0**-8)
        exact = shade.DOUBLE.bounce(e_ctx, tex, ONE, 0.5, inside, row, 2.0**-8)
        for i, (a, b) in enumerate(zip(ours, exact)):
            if b[0] and abs(np.dot(e_ctx[1], b[2])) > 0.02:  # near the horizon sqrt(k) magnifies
                assert a[0]
                worst[i] = max(worst[i], np.abs(np.subtract(a[2], b[2])).max())
                assert a[1] == pytest.approx(b[1], abs=2.0**-9)
                bounced += 1
    assert worst[0] < 2.0**-12 and worst[1] < 2.0**-8
    assert near < 10 and lit > 40 and bounced > 200


def test_fp24_results_are_fp24():
    for seed in SEEDS:
        hit, light, row, tex = random_scene(seed)
        ctx, length, inside = context(shade.FP24, hit)
        _, to, _, t_max, k = shade.FP24.light_job(ctx, light, row, tex, 0.0)
        one, two = shade.FP24.bounce(ctx, tex, tex, 0.5, inside, row, 0.0)
        _, tr, t_min = shade.FP24.shadow_through(tex, hit[2], tex, 0.5, row, 0.0)
        others = (
            shade.FP24.add_light(k, tex, tr, k),
            shade.FP24.add_surface(k, tr, tex, row),
            shade.FP24.add_miss(k, tr, k),
        )
        for values in (*ctx[:4], [ctx[4], length], to, [t_max, t_min], k, tr, *one[1:], *two[1:], *others):
            fp24.to_bits(np.array(values))  # raises if a value is not representable
