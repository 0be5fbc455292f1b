# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""TriAccel records: the recipe's constants, their bits in memory, the edge slack, and hits computed from them."""

import itertools
import os
from fractions import Fraction

import numpy as np
import pytest

from raycore import triaccel
from raycore.model import fp24

SEED = int(os.environ.get("RAYCORE_SEED", "20140615"))


def triangles(count=2000, size=0.1):
    print(f"seed {SEED}")
    rng = np.random.default_rng(SEED)
    middle = rng.uniform(-0.8, 0.8, (count, 1, 3))
    return fp24.round_to_fp24(np.clip(middle + rng.normal(0, size, (count, 3, 3)), -1, 1))


def test_constants_in_rational_arithmetic():
    """Each constant is the exact one, rounded to nearest (the double before it may tip a near tie)."""
    tris = triangles(200)
    rec = triaccel.records(tris)
    for i, tri in enumerate(tris):
        a, b, c = ([Fraction(x) for x in v] for v in tri)
        e1, e2 = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
        n = [e1[(j + 1) % 3] * e2[(j + 2) % 3] - e1[(j + 2) % 3] * e2[(j + 1) % 3] for j in range(3)]
        k = int(rec.k[i])
        assert abs(n[k]) == max(map(abs, n))
        u, v = (k + 1) % 3, (k + 2) % 3
        det = e1[u] * e2[v] - e1[v] * e2[u]
        assert det == n[k]
        assert list(rec.a[i]) == [float(a[u]), float(a[v]), float(a[k])]
        want = [n[u] / det, n[v] / det, e2[v] / det, -e2[u] / det, -e1[v] / det, e1[u] / det]
        got = [*rec.n[i], *rec.b[i], *rec.g[i]]
        for x, y in zip(got, want):
            assert abs(Fraction(x) - y) <= abs(y) * Fraction(1, 2**17) * Fraction(100001, 100000)


def test_hits_agree_with_moeller_trumbore():
    """The recipe evaluated in double precision finds t, beta and gamma of Moeller and Trumbore (1997)."""
    tris = triangles()
    rec = triaccel.records(tris)
    rng = np.random.default_rng(SEED + 1)
    w = rng.dirichlet((1, 1, 1), len(tris))
    aim = (tris * w[:, :, None]).sum(axis=1)
    n = np.cross(tris[:, 1] - tris[:, 0], tris[:, 2] - tris[:, 0])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    d = n + rng.normal(0, 0.5, n.shape)
    o = aim - d
    rows = np.arange(len(tris))
    k = rec.k.astype(int)
    u, v = (k + 1) % 3, (k + 2) % 3
    ou, ov, ow = o[rows, u] - rec.a[:, 0], o[rows, v] - rec.a[:, 1], o[rows, k] - rec.a[:, 2]
    den = rec.n[:, 0] * d[rows, u] + rec.n[:, 1] * d[rows, v] + d[rows, k]
    t = -(rec.n[:, 0] * ou + rec.n[:, 1] * ov + ow) / den
    hu, hv = ou + t * d[rows, u], ov + t * d[rows, v]
    beta, gamma = hu * rec.b[:, 0] + hv * rec.b[:, 1], hu * rec.g[:, 0] + hv * rec.g[:, 1]
    cosine = np.abs((d * n).sum(axis=1)) / np.linalg.norm(d, axis=1)
    fat = triaccel.decode_eps(rec.eps_code) < 2.0**-10  # well-shaped enough for rounded constants
    fat &= cosine > 0.1  # a grazing ray enlarges their error by the inverse
    assert fat.mean() > 0.5
    assert np.abs(t - 1.0)[fat].max() < 1e-3
    assert np.abs(beta - w[:, 1])[fat].max() < 2e-2 and np.abs(gamma - w[:, 2])[fat].max() < 2e-2
    assert np.median(np.abs(beta - w[:, 1])) < 1e-4


def test_words_bit_by_bit():
    """One triangle, its words put together by hand from the layout in rc_pkg.sv."""
    tri = np.array([[[0.25, -0.5, 0.125], [0.75, -0.5, 0.125], [0.25, 0.5, 0.125]]])
    # e1 = (1/2, 0, 0), e2 = (0, 1, 0): N = (0, 0, 1/2), k = 2, u = 0, v = 1, det = 1/2,
    # b = (1, 0) / det = (2, -0), g = (-0, 1/2) / det = (-0, 1), |b| = 2, |g| = 1, |b + g| = sqrt 5.
    rec = triaccel.records(tri)
    one, two, quarter, minus_half, eighth = 63 << 16, 64 << 16, 61 << 16, 1 << 23 | 62 << 16, 60 << 16
    zero = 1 << 23  # minus zero where -0 / det stands
    # eps = 2^-17 sqrt 5 = 1.118 * 2^-16, rounded up to (1 + 2/16) * 2^-16: e = 16 - 8, m = 2.
    eps = 8 << 4 | 2
    words = triaccel.pack(rec, np.array([0xABC]))[0]
    assert int(words[0]) & (1 << 48) - 1 & ~(zero | zero << 24) == 0, "n_u = n_v = 0"
    assert int(words[0]) >> 48 == 1 << 11 | 2 << 9 | eps
    assert int(words[1]) == quarter | minus_half << 24 | 0xABC << 48
    b_v = int(words[2]) >> 48 | int(words[3]) >> 48 << 12
    assert int(words[2]) & (1 << 48) - 1 == eighth | two << 24 and b_v & ~zero == 0
    assert int(words[3]) & 0xFFFFFF & ~zero == 0 and int(words[3]) >> 24 & 0xFFFFFF == one
    assert not (words >> np.uint64(60)).any()
    see_through = triaccel.pack(rec, np.array([0]), np.array([False]))[0]
    assert int(see_through[0]) >> 59 == 0


def test_pack_and_unpack():
    tris = triangles()
    tris[::7] = 0.0
    rec = triaccel.records(tris)
    material, solid = np.arange(len(tris)) % 4096, np.arange(len(tris)) % 3 > 0
    words = triaccel.pack(rec, material, solid)
    back, got_material, got_solid = triaccel.unpack(words)
    for name in ("k", "n", "a", "b", "g", "eps_code"):
        assert np.array_equal(getattr(rec, name), getattr(back, name)), name
    assert np.array_equal(material, got_material) and np.array_equal(solid, got_solid)
    with pytest.raises(ValueError, match="4096"):
        triaccel.pack(rec, np.full(len(tris), 4096))


def test_without_area():
    """No area, masked, or constants beyond FP24: never hit, and every field finite."""
    tris = triangles(6)
    tris[1, 2] = tris[1, 1]
    tris[2] = tris[2, :1]
    tris[3] = [[0, 0, 0], [2.0**-60, 0, 0], [0, 2.0**-60, 0]]  # 1 / 2^-60 still fits
    tris[4] = [[0, 0, 0], [2.0**-62, 0, 0], [0, 2.0**-62, 0]]
    mask = np.array([False, False, False, False, False, True])
    rec = triaccel.records(tris, mask)
    assert list(rec.k == triaccel.NEVER_HITS) == [False, True, True, False, False, True]
    thin = np.array(
        [[[0, 0, 0], [1, 0, 0], [0.5, 2.0**-62, 2.0**-62]], [[0, 0, 0], [2.0**-62, 0, 0], [1, 2.0**-62, 0]]]
    )
    for field in (triaccel.records(thin).b, rec.b, rec.g, rec.n):
        assert np.isfinite(field).all()
    triaccel.pack(triaccel.records(thin), np.zeros(2, int))


def test_eps_code():
    """Rounded up by less than a sixteenth; clamped at both ends; every code decodes to another value."""
    codes = np.arange(512)
    values = triaccel.decode_eps(codes)
    assert len(np.unique(values)) == 512 and values.max() == 31 / 16 * 2.0**-8 and values.min() == 2.0**-39
    assert np.array_equal(triaccel.encode_eps(values), codes), "a value of the code stays itself"
    above = np.nextafter(values, 1.0)
    order = np.argsort(values)
    following = dict(itertools.pairwise(order))
    assert all(c == following.get(i, 15) for i, c in enumerate(triaccel.encode_eps(above)))
    assert list(triaccel.encode_eps(np.array([0.0, 1e-30, 1.0, 1e30, np.inf]))) == [496, 496, 15, 15, 15]


def test_edge_slack_is_a_distance():
    """eps moves each edge outwards by at least 2^-17: beta, gamma and 1 - beta - gamma fall by eps over that distance."""
    tris = triangles(500)
    rec = triaccel.records(tris)
    eps = triaccel.decode_eps(rec.eps_code)
    slope = np.maximum(np.linalg.norm(rec.b, axis=1), np.linalg.norm(rec.g, axis=1))
    slope = np.maximum(slope, np.linalg.norm(rec.b + rec.g, axis=1))
    free = eps < 31 / 16 * 2.0**-8
    assert free.sum() > 100
    assert (eps >= 2.0**-17 * slope * (1 - 2.0**-15))[free].all() and (eps <= 2.0**-17 * slope * 1.07)[free].all()


def test_triangle_info():
    """Unit geometric normals also of tiny triangles; interpolation reaches the normals of the corners."""
    tris = triangles(300)
    tris[1] = fp24.round_to_fp24(tris[1] * 2.0**-40)
    tris[2] = 0.0
    rng = np.random.default_rng(SEED + 2)
    normals = rng.normal(0, 1, (300, 3, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    info = triaccel.triangle_info(tris, normals)
    length = np.linalg.norm(info.normal, axis=1)
    assert length[2] == 0.0 and np.abs(np.delete(length, 2) - 1.0).max() < 2.0**-15
    e1, e2 = tris[:, 1] - tris[:, 0], tris[:, 2] - tris[:, 0]
    for e in (e1, e2):
        assert np.abs(np.einsum("ij,ij->i", info.normal, e)).max() < 2.0**-15
    assert (np.einsum("ij,ij->i", info.normal, np.cross(e1, e2)) >= 0).all()
    assert np.array_equal(info.vertex, tris[:, 0])
    assert np.abs(info.n0 + info.dn1 - normals[:, 1]).max() < 2.0**-15
    assert np.abs(info.n0 + info.dn2 - normals[:, 2]).max() < 2.0**-15
    for field in (info.normal, info.n0, info.dn1, info.dn2):
        assert np.array_equal(field, fp24.round_to_fp24(field))
