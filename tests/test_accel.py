# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The record unit's model: each field against its definition in exact fractions, and against the host's doubles."""

import math
from decimal import Decimal, localcontext
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from raycore import accel, image, tbu, triaccel
from raycore.model import accel as model
from raycore.model import fp24
from raycore.scene import load_scene

TOP = (1 << 17) - 1


def nearest(x):
    """A fraction or Decimal as the nearest FP24 number, ties to even, as a Fraction; x is neither tiny nor huge."""
    x = Fraction(x)
    if x == 0:
        return x
    size = abs(x)
    e = size.numerator.bit_length() - size.denominator.bit_length()
    e -= size < Fraction(2) ** e
    ulp = Fraction(2) ** (e - 16)
    return int(math.copysign(1, x)) * round(size / ulp) * ulp  # round of a Fraction: to even


def value(bits):
    return Fraction(float(fp24.from_bits(np.array([bits], np.uint32))[0]))


def some_triangles(rng):
    spread = 2 ** rng.integers(1, 18, (400, 1, 1))
    soup = np.clip(rng.integers(-TOP, TOP + 1, (400, 1, 3)) + rng.integers(-1, 2, (400, 3, 3)) * rng.integers(0, spread), -TOP, TOP)
    return np.concatenate((soup, rng.integers(-TOP, TOP + 1, (300, 3, 3)), rng.integers(-3, 4, (200, 3, 3)),
                           rng.choice([-TOP, -1, 0, 1, TOP], (200, 3, 3))))  # fmt: skip


def test_fields_are_correctly_rounded(seed):
    """Quotients exactly; normals within 2^-28 of them, so but for one in a thousand where extremes make near ties."""
    rng = np.random.default_rng(seed)
    triangles = some_triangles(rng)
    odd = flat = usual = 0
    for i, (tri, out) in enumerate(zip(triangles, model.records(triangles))):
        e1, e2 = (tri[1] - tri[0]).tolist(), (tri[2] - tri[0]).tolist()
        n = [e1[(i + 1) % 3] * e2[(i + 2) % 3] - e1[(i + 2) % 3] * e2[(i + 1) % 3] for i in range(3)]
        if not any(n):
            assert out.tolist() == [3, 0, 0, 0, 0, 0, 0, 31 << 4, 0, 0, 0]
            flat += 1
            continue
        k = max(range(3), key=lambda i: (abs(n[i]), -i))
        u, v = (k + 1) % 3, (k + 2) % 3
        assert out[0] == k
        wanted = [Fraction(n[u], n[k]), Fraction(n[v], n[k])]
        wanted += [Fraction(x << 17, n[k]) for x in (e2[v], -e2[u], -e1[v], e1[u])]
        assert [value(b) for b in out[1:7]] == [nearest(x) for x in wanted]
        with localcontext() as context:
            context.prec = 60
            length = Decimal(sum(x * x for x in n)).sqrt()
            for x, bits in zip(n, out[8:]):
                exact = Fraction(Decimal(x) / length)
                got = value(bits)
                odd += got != nearest(exact)
                usual += got != nearest(exact) and 400 <= i < 700
                assert got in (nearest(exact), nearest(exact * (1 + Fraction(1, 1 << 28))))
    assert flat >= 1 and usual <= 1 and odd <= 3 * len(triangles) // 100


def test_edge_slack(seed):
    """Never less than the exact slack of its factor, at most a step of the code and 2^-18 more; the factor as in edge_slack."""
    rng = np.random.default_rng(seed)
    triangles = some_triangles(rng)
    for _ in range(5):
        eye = rng.uniform(-1, 1, 3) * rng.choice([1.0, 5.0, 100.0])
        bounds = np.array([triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))]) * 2.0**-17
        view = accel.slack(eye, bounds)
        out, factors = model.records(triangles, view), model.slack_factors(triangles, view)
        host = image.edge_slack(eye, bounds, triangles * 2.0**-17) / triaccel.EDGE_SLACK
        np.testing.assert_allclose(factors / 128.0, host, atol=0.04)
        for tri, row, factor in zip(triangles.tolist(), out.tolist(), factors.tolist()):
            if row[0] == 3:
                continue
            u, v = (row[0] + 1) % 3, (row[0] + 2) % 3
            edges = [[b[i] - a[i] for i in (u, v)] for a, b in ((tri[0], tri[1]), (tri[0], tri[2]), (tri[1], tri[2]))]
            det = edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]
            square = Fraction(factor**2 * max(x * x + y * y for x, y in edges), det * det << 14)
            code = row[7]
            got = Fraction(16 + (code & 15), 16) / (1 << 8 + (code >> 4))
            if code == 15:  # the largest there is
                assert square > (got * Fraction(15, 16)) ** 2
                continue
            below = got - Fraction(1, 16 << 8 + (code >> 4))
            assert square <= got**2 and (below * (1 - Fraction(1, 1 << 18))) ** 2 <= square
            if code & 15 == 0:  # the step below the first of an exponent is half as long
                assert (got * Fraction(31, 32) * (1 - Fraction(1, 1 << 18))) ** 2 <= square


@pytest.mark.parametrize("name", ["tiny_glass", "chess"])
def test_as_the_host_computes(name):
    """From doubles the same, but for the sign of zeros and one normal in ten thousand."""
    unit = tbu.snap(load_scene(name))
    rec, geometric, slack = accel.records(unit)
    other = triaccel.records(unit.triangles, unit.dropped, slack)
    info = triaccel.triangle_info(unit.triangles, np.zeros((len(slack), 3, 3)))
    for field in ("k", "n", "a", "b", "g", "eps_code"):
        differ = getattr(rec, field) != getattr(other, field)
        assert np.count_nonzero(differ) <= len(differ) * (field == "eps_code") // 1000, field
    assert np.count_nonzero(geometric != info.normal) <= len(geometric) // 10_000 + 1
    assert not np.signbit(np.concatenate((rec.n, rec.b, rec.g))[np.concatenate((rec.n, rec.b, rec.g)) == 0.0]).any()


def test_plain_python(seed):
    """The compiled functions compute what the same text computes in unlimited integers."""
    rng = np.random.default_rng(seed)
    for _ in range(300):
        a = int(rng.integers(-(1 << 37) + 1, 1 << 37)) >> int(rng.integers(0, 37))
        b = (int(rng.integers(1, 1 << 37)) >> int(rng.integers(0, 36))) | 1
        assert model.quotient.py_func(a, b, 3) == model.quotient(a, b, 3)
        x = int(rng.integers(0, 1 << 62)) >> int(rng.integers(0, 62))
        assert model.root(x) == math.isqrt(x) == model.root.py_func(x)
        factor, longest = int(rng.integers(128, 8193)), int(rng.integers(1, 1 << 37))
        assert model.eps_code.py_func(factor, longest, b) == model.eps_code(factor, longest, b)


def test_corner_normals():
    n = fp24.round_to_fp24(np.array([[[0.6, 0.8, 0.0], [0.0, 1.0, 0.0], [0.6, 0.8, -0.0]]] * 2))
    plane = np.array([[0.0, 0.0, 1.0]] * 2)
    n0, d1, d2 = model.corner_normals(n, plane, [False, True])
    assert (n0[0] == n[0, 0]).all() and (n0[1] == plane[1]).all()
    assert (d1[0] == fp24.sub(n[0, 1], n[0, 0])).all() and not d1[1].any() and not d2.any()


def test_attribute_records():
    normals = np.arange(18.0).reshape(2, 3, 3)
    words = accel.attribute_records(normals, [5, 4095], [False, True])
    whole = [sum(int(w) << 64 * i for i, w in enumerate(row)) for row in words]
    for tri in range(2):
        bits = fp24.to_bits(normals[tri].reshape(-1).copy())
        assert [whole[tri] >> 24 * i & 0xFFFFFF for i in range(9)] == bits.tolist()
    assert whole[0] >> 216 == 5 and whole[1] >> 216 == 4095 | 1 << 12


def test_slack_of_a_view():
    bounds = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    assert accel.slack((0.5, -0.25, 0.0), bounds) == model.Slack((128, -64, 0), 128)
    assert accel.slack((3.0, 0.0, 0.0), bounds) == model.Slack((768, 0, 0), 512)
    assert accel.slack((1e6, 0.0, -1e6), bounds) == model.Slack((model.EYE_MAX, 0, -model.EYE_MAX), model.SLACK_MAX)


def test_records_of_no_area():
    unit = SimpleNamespace(triangles=np.array([[[0.5, 0.25, 0.0]] * 3]))
    rec, normal, _ = accel.records(unit)
    assert rec.k == 3 and rec.a.tolist() == [[0.25, 0.0, 0.5]] and not normal.any() and rec.eps_code == 31 << 4
