# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""raycore.model.shade: double precision against plain vector algebra, FP24 against double precision."""

import math

import numpy as np
import pytest

from raycore.model import fp24, shade


def unit(v):
    return v / np.linalg.norm(v)


def random_scene(seed):
    """Records that make sense, all of them FP24 numbers: (org, d, t, beta, gamma, info, light, material)."""
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
    material = np.array([*rng.uniform(0, 1, 9), rng.integers(0, 5)])
    rounded = [fp24.round_to_fp24(v) for v in (org, to_hit / t, t, beta, gamma, info, light, material)]
    vec = [tuple(map(float, v)) for v in rounded[:2]]
    return (*vec, *map(float, rounded[2:5]), *rounded[5:])


SEEDS = range(200)


@pytest.mark.parametrize("seed", range(50))
def test_double_hit_point(seed):
    """P is on the plane but for the lift, g faces the viewer, m is the interpolated normal on g's side."""
    org, d, t, beta, gamma, info, *_ = random_scene(seed)
    p, g, m, md = map(np.array, shade.DOUBLE.hit_point(org, d, t, beta, gamma, info))
    a, n, n0, e1, e2 = info
    side = -1.0 if n @ d > 0 else 1.0
    assert np.array_equal(g, side * n) and g @ d <= 0
    # n is unit to within its rounding, and the correction to the plane is of first order in what is left
    assert (p - a) @ g == pytest.approx(shade.HIT_LIFT, abs=1e-4 * abs((np.array(org) + t * np.array(d) - a) @ n) + 1e-9)
    assert np.linalg.norm(np.cross(p - (np.array(org) + t * np.array(d)), n)) < 1e-12
    assert m == pytest.approx(side * unit(n0 + beta * e1 + gamma * e2), abs=1e-12)
    assert md == pytest.approx(m @ np.array(d), abs=1e-12)


@pytest.mark.parametrize("seed", range(50))
@pytest.mark.parametrize("directional", [False, True])
def test_double_light(seed, directional):
    """Phong's model, with the mirrored direction written out."""
    *hit, light, material = random_scene(seed)
    light[0] = directional
    p, g, m, d, _ = ctx = (*(c := shade.DOUBLE.hit_point(*hit))[:3], hit[1], c[3])
    culled, to, t_max, k = shade.DOUBLE.light_job(ctx, light, material)
    p, g, m, d = map(np.array, (p, g, m, d))
    offset = light[1:4] if directional else light[1:4] - p
    dist = np.linalg.norm(offset)
    direction = offset / dist
    assert to == pytest.approx(direction, abs=1e-12)
    assert t_max == (2.0**62 if directional else pytest.approx(dist))
    assert culled == (g @ direction <= 0 or m @ direction <= 0)
    mirrored = 2 * (m @ direction) * m - direction
    spec = max(mirrored @ -d, 0.0) ** (2.0 ** material[9])
    c, l, q = light[7:]
    att = 1.0 if directional else 1 / (c + l * dist + q * dist**2)
    assert k == pytest.approx((material[3:6] * (m @ direction) + material[6:9] * spec) * light[4:7] * att, rel=1e-9, abs=1e-12)
    assert shade.DOUBLE.add_k((0.5, 0.25, 1.0), k) == pytest.approx(np.array([0.5, 0.25, 1.0]) + k)


def test_fp24_is_close():
    """FP24 against double precision, where no decision is near: 2^-13 of one for positions, 2^-8 for colours up to 3."""
    near, count = 0, 0
    for seed in SEEDS:
        *hit, light, material = random_scene(seed)
        exact = shade.DOUBLE.hit_point(*hit)
        p, g, m, md = got = shade.FP24.hit_point(*hit)
        if abs(np.dot(exact[1], hit[1])) < 1e-3:
            near += 1
            continue
        for a, b in zip(got[:3], exact[:3]):
            assert a == pytest.approx(b, abs=2.0**-13)
        e_culled, e_to, e_t, e_k = shade.DOUBLE.light_job((*exact[:3], hit[1], exact[3]), light, material)
        culled, to, t_max, k = shade.FP24.light_job((p, g, m, hit[1], md), light, material)
        assert to == pytest.approx(e_to, abs=2.0**-11) and t_max == pytest.approx(e_t, rel=2.0**-11)
        if min(abs(np.dot(exact[1], e_to)), abs(np.dot(exact[2], e_to))) < 1e-3:
            near += 1
            continue
        assert culled == e_culled
        if not culled:
            assert k == pytest.approx(e_k, abs=2.0**-8)
            count += 1
    assert near < 10 and count > 40


def test_fp24_results_are_fp24():
    for seed in SEEDS:
        *hit, light, material = random_scene(seed)
        p, g, m, md = shade.FP24.hit_point(*hit)
        _, to, t_max, k = shade.FP24.light_job((p, g, m, hit[1], md), light, material)
        for values in (p, g, m, [md], to, [t_max], k, shade.FP24.add_k(k, p)):
            fp24.to_bits(np.array(values))                # raises if a value is not representable


def test_special_cases():
    """What docs/shade.md says of NaN, of a light in the hit point, of shininess."""
    d, up, p = (0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)
    info = np.zeros((5, 3))
    info[1] = up                                          # no vertex normal
    _, g, m, md = shade.FP24.hit_point((0.0, 1.0, 0.0), d, 1.0, 0.25, 0.25, info)
    assert g == up and all(map(math.isnan, (*m, md)))
    light = np.array([0, 0, 1, 0, 1, 1, 1, 1, 0, 0], dtype=float)
    material = np.array([0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1, 0], dtype=float)
    assert shade.FP24.light_job((p, up, m, d, md), light, material)[0], "NaN is culled"
    at_point = light.copy()
    at_point[1:4] = p
    assert shade.FP24.light_job((p, up, up, d, -1.0), at_point, material)[0], "a light in the hit point is culled"
    culled, to, t_max, k = shade.FP24.light_job((p, up, up, d, -1.0), light, material)
    assert (culled, to, t_max, k) == (False, up, 1.0, (1.5, 1.5, 1.5))
    tilted = (p, up, up, (0.0, -0.75, 0.0), -0.75)        # R . V = 0.75
    for shin in range(16):
        material[9] = shin
        want = 0.75
        for _ in range(min(shin, 10)):
            want = fp24.rnd(want * want)
        assert shade.FP24.light_job(tilted, light, material)[3][0] == fp24.rnd(0.5 + want)


@pytest.mark.parametrize("twin", [shade.FP24, shade.DOUBLE])
def test_flip_is_a_mirror(twin):
    """Seen from the other side, all normals turn and nothing else changes."""
    for seed in range(20):
        org, d, t, beta, gamma, info, *_ = random_scene(seed)
        turned = info.copy()
        turned[1:] *= -1
        assert twin.hit_point(org, d, t, beta, gamma, info) == twin.hit_point(org, d, t, beta, gamma, turned)
