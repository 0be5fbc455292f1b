# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Hit point and Phong shading, bit for bit what `rtl/shade/` computes (paper Sec. 3.6), and its double-precision twin.

The formulas and their order are those of docs/seams.md, written once in `make_shading`, which is given the arithmetic:
`FP24` and `DOUBLE` are the two results. Each is a namespace of functions compiled by numba, to be called from other compiled
loops (bind them to module-level names there: `hit_point = shade.FP24.hit_point`).

Vectors are tuples (x, y, z) of float64; records are float64 arrays, which for FP24 hold FP24 numbers:

* triangle information, shape (5, 3): vertex 0, plane normal n (unit), vertex normal n0, edges of the normals e1 and e2;
* light, shape (10,): directional flag (0 or 1), position or unit direction, colour, attenuation c, l, q;
* material, shape (10,): ambient (with emission), diffuse, specular colour, log2 of the shininess.

A context is the tuple (P, g, m, d, md): lifted hit point, plane normal towards the viewer, shading normal (unit), direction of
the ray, m . d.
"""

import math
from types import SimpleNamespace

import numpy as np
from numba import njit

from . import fp24

HIT_LIFT = 2.0**-17  # hit points float this far above their triangle (rc_pkg)
T_LIMIT = 2.0**62  # FP_HUGE: no limit
MAX_SQUARINGS = 10  # the RTL can square this often; a larger shin_log2 counts as this


def make_shading(add, add3, mul, div, sqrt):
    """The shading functions for one arithmetic, given as compiled scalar functions.

    Returns: a namespace of hit_point, light_job, add_k.
    """

    @njit(error_model="numpy")
    def dot(a, b):
        return add3(mul(a[0], b[0]), mul(a[1], b[1]), mul(a[2], b[2]))

    @njit(error_model="numpy")
    def scale(k, a):
        return mul(k, a[0]), mul(k, a[1]), mul(k, a[2])

    @njit(error_model="numpy")
    def plus(a, b):
        return add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2])

    @njit(error_model="numpy")
    def minus(a):
        return -a[0], -a[1], -a[2]

    @njit(error_model="numpy")
    def hit_point(org, d, t, beta, gamma, info):
        """Hit point, its normals and m . d, for a hit at distance t with barycentric weights beta, gamma.

        Args: origin and direction of the ray (vectors), three scalars, triangle information.
        Returns: (P, g, m, md). NaN where the vertex normals cancel (m, md) or the operands are not finite.
        """
        a = (info[0, 0], info[0, 1], info[0, 2])
        n = (info[1, 0], info[1, 1], info[1, 2])
        p = plus(org, scale(t, d))
        flip = dot(n, d) > 0.0
        g = minus(n) if flip else n
        delta = add(HIT_LIFT, -dot(g, plus(p, minus(a))))
        lifted = plus(p, scale(delta, g))
        s = (
            add3(info[2, 0], mul(beta, info[3, 0]), mul(gamma, info[4, 0])),
            add3(info[2, 1], mul(beta, info[3, 1]), mul(gamma, info[4, 1])),
            add3(info[2, 2], mul(beta, info[3, 2]), mul(gamma, info[4, 2])),
        )
        s = minus(s) if flip else s
        m = scale(div(1.0, sqrt(dot(s, s))), s)
        return lifted, g, m, dot(m, d)

    @njit(error_model="numpy")
    def light_job(ctx, light, material):
        """One light on one hit point.

        Args: context, light, material.
        Returns: (culled, L, t_max, k): whether the light stands behind the surface; direction towards the light and length of
        the shadow ray (its origin is P); the colour to add if nothing is in between. L and k mean nothing if culled.
        """
        point, g, m, d, md = ctx
        directional = light[0] != 0.0
        pos = (light[1], light[2], light[3])
        to = pos if directional else plus(pos, minus(point))
        dist2 = dot(to, to)
        dist = sqrt(dist2)
        to = scale(div(1.0, dist), to)
        ml = dot(m, to)
        culled = not (dot(g, to) > 0.0 and ml > 0.0)
        att = 1.0
        if not directional:
            att = div(1.0, add3(light[7], mul(light[8], dist), mul(light[9], dist2)))
        sp = add(dot(d, to), -mul(mul(2.0, ml), md))  # R . V
        if sp > 0.0:
            for _ in range(min(int(material[9]), MAX_SQUARINGS)):
                sp = mul(sp, sp)
        else:
            sp = 0.0
        k = (
            mul(mul(add(mul(material[3], ml), mul(material[6], sp)), light[4]), att),
            mul(mul(add(mul(material[4], ml), mul(material[7], sp)), light[5]), att),
            mul(mul(add(mul(material[5], ml), mul(material[8], sp)), light[6]), att),
        )
        return culled, to, (T_LIMIT if directional else dist), k

    @njit(error_model="numpy")
    def add_k(acc, k):
        """Colour acc with the contribution k of one light added."""
        return plus(acc, k)

    return SimpleNamespace(hit_point=hit_point, light_job=light_job, add_k=add_k)


@njit(error_model="numpy")
def _add(a, b):
    return a + b


@njit(error_model="numpy")
def _add3(a, b, c):
    return a + b + c


@njit(error_model="numpy")
def _mul(a, b):
    return a * b


@njit(error_model="numpy")
def _div(a, b):
    return a / b


@njit(error_model="numpy")
def _sqrt(a):
    return math.sqrt(a) if a >= 0.0 else np.nan


FP24 = make_shading(fp24.fadd, fp24.fadd3, fp24.fmul, fp24.fdiv, fp24.fsqrt)
DOUBLE = make_shading(_add, _add3, _mul, _div, _sqrt)
