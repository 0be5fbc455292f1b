# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Hit point, Phong shading, transparent shadows and bounces, bit for bit what `rtl/shade/` computes (paper Sec. 3.6), and
their double-precision twin.

The formulas and their order are those of docs/whitted.md and docs/seams.md, written once in `make_shading`, which is given
the arithmetic: `FP24` and `DOUBLE` are the two results. Each is a namespace of functions compiled by numba, to be called
from other compiled loops (bind them to module-level names there: `hit_point = shade.FP24.hit_point`).

Vectors and colours are tuples of three float64; records are float64 arrays, which for FP24 hold FP24 numbers:

* triangle information, shape (5, 3): vertex 0, plane normal n (unit), vertex normal n0, edges of the normals e1 and e2;
* light, shape (10,): directional flag (0 or 1), position or unit direction, colour, attenuation c, l, q;
* material, shape (29,): what `MATERIAL_COLUMNS` names.

A context is the tuple (P, g, m, d, md): lifted hit point, plane normal towards the viewer, shading normal (unit), direction of
the ray, m . d.
"""

import math
from types import SimpleNamespace

import numpy as np
from numba import njit

from . import fp24

HIT_LIFT = 2.0**-17  # hit points float this far above their triangle (rc_pkg)
SINK = -(2.0**-16)  # from there to where rays start that go on behind it
T_MIN = 2.0**-14  # rc_pkg
T_MIN_DOUBLE = 1e-9  # the same for rays of the double picture that leave from a triangle
T_LIMIT = 2.0**62  # FP_HUGE: no limit
RESUME_ULP = 16  # a shadow ray starts again so much behind what it passed through

# Columns of a material: Phong colours, optics and flags (0 or 1; alpha_mode is one of ALPHA_*).
MATERIAL_COLUMNS = (
    *(f"{v}_{c}" for v in ("amb", "diff", "spec", "emis") for c in "rgb"),
    *("shin", "alpha", "cutoff"),
    *(f"{v}_{c}" for v in ("kr", "kt") for c in "rgb"),
    *("ior", "inv_ior", "textured", "alpha_mode", "reflects", "transmits", "fresnel", "tex_kr"),
)
ALPHA_OPAQUE, ALPHA_MASK, ALPHA_BLEND = range(3)
AMB, DIFF, SPEC, EMIS = 0, 3, 6, 9  # first of three columns
SHIN, ALPHA, CUTOFF = 12, 13, 14
KR, KT = 15, 18
IOR, INV_IOR = 21, 22
TEXTURED, ALPHA_MODE, REFLECTS, TRANSMITS, FRESNEL, TEX_KR = range(23, 29)


@njit(error_model="numpy")
def opaque(material):
    """Whether a material's triangles end a shadow ray: the flag of their TriAccel records."""
    return material[ALPHA_MODE] == ALPHA_OPAQUE and material[TRANSMITS] == 0.0


def make_shading(add, add3, mul, div, sqrt, power, behind):
    """The shading functions for one arithmetic, given as compiled scalar functions.

    Args: arithmetic; power(a, b): a^b for a > 0; behind(t): where a shadow ray starts again that was stopped at t.
    Returns: a namespace of hit_point, longer, coverage, weight (of a scalar and a colour), light_job, shadow_through, bounce
        and, for the pixel's colour, add_miss, add_surface, add_light.
    """

    @njit(error_model="numpy")
    def dot(a, b):
        return add3(mul(a[0], b[0]), mul(a[1], b[1]), mul(a[2], b[2]))

    @njit(error_model="numpy")
    def dot2(a, b):
        """Dot product of the bounce unit: two additions."""
        return add(add(mul(a[0], b[0]), mul(a[1], b[1])), mul(a[2], b[2]))

    @njit(error_model="numpy")
    def scale(k, a):
        return mul(k, a[0]), mul(k, a[1]), mul(k, a[2])

    @njit(error_model="numpy")
    def times(a, b):
        return mul(a[0], b[0]), mul(a[1], b[1]), mul(a[2], b[2])

    @njit(error_model="numpy")
    def plus(a, b):
        return add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2])

    @njit(error_model="numpy")
    def minus(a):
        return -a[0], -a[1], -a[2]

    @njit(error_model="numpy")
    def colour(material, first):
        return material[first], material[first + 1], material[first + 2]

    @njit(error_model="numpy")
    def above(a, limit):
        """Whether a component is larger; false for NaN."""
        return a[0] > limit or a[1] > limit or a[2] > limit

    # ---- hit point --------------------------------------------------------------------------------------------------

    @njit(error_model="numpy")
    def place(info, placed):
        """Triangle information (5, 3) of a placed object in the scene's coordinates. placed (3, 4): rotation and origin."""
        out = np.empty((5, 3))
        for v in range(5):
            x = (info[v, 0], info[v, 1], info[v, 2])
            for i in range(3):
                out[v, i] = dot2((placed[i, 0], placed[i, 1], placed[i, 2]), x)
                if v == 0:
                    out[v, i] = add(out[v, i], placed[i, 3])
        return out

    @njit(error_model="numpy")
    def hit_point(org, d, t, beta, gamma, info, length):
        """Hit point and its normals, for a hit at distance t with barycentric weights beta, gamma.

        Args: origin and direction of the ray (vectors), three scalars, triangle information, length of the path so far.
        Returns: (P, g, m, md, length with t, inside): inside tells that the ray came from behind the triangle. NaN where
        the vertex normals cancel (m, md) or the operands are not finite.
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
        return lifted, g, m, dot(m, d), add(length, t), flip

    @njit(error_model="numpy")
    def longer(length, t):
        """Length of a path that goes on by t; a texture's level follows from it."""
        return add(length, t)

    @njit(error_model="numpy")
    def coverage(ta, material):
        """alpha': how much of a ray's weight stays at a surface, by the texture's alpha ta (1: no texture) and the material."""
        a = mul(material[ALPHA], ta)
        if material[ALPHA_MODE] == ALPHA_OPAQUE:
            return 1.0
        if material[ALPHA_MODE] == ALPHA_MASK:
            return 1.0 if a >= material[CUTOFF] else 0.0
        return a

    # ---- lights -----------------------------------------------------------------------------------------------------

    @njit(error_model="numpy")
    def light_job(ctx, light, material, tex, t_min):
        """One light on one hit point.

        Args: context, light, material, the texture's colour there (1, 1, 1: none), t_min of the shadow ray.
        Returns: (culled, L, t_min, t_max, k): whether the light stands behind the surface; direction towards the light and
        range of the shadow ray (its origin is P); the colour to add if nothing is in between. The rest means nothing if culled.
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
        rv = add(dot(d, to), -mul(mul(2.0, ml), md))  # R . V
        sp = power(rv, material[SHIN]) if rv > 0.0 else 0.0
        k = (
            mul(mul(add(mul(mul(material[DIFF], ml), tex[0]), mul(material[SPEC], sp)), light[4]), att),
            mul(mul(add(mul(mul(material[DIFF + 1], ml), tex[1]), mul(material[SPEC + 1], sp)), light[5]), att),
            mul(mul(add(mul(mul(material[DIFF + 2], ml), tex[2]), mul(material[SPEC + 2], sp)), light[6]), att),
        )
        return culled, to, t_min, (T_LIMIT if directional else dist), k

    @njit(error_model="numpy")
    def shadow_through(tr, t, tex, ta, material, min_weight):
        """A shadow ray ended at a triangle that is not opaque.

        Args: transmittance of the light so far; the hit's distance; the texture's colour and alpha there; the material hit.
        Returns: (blocked, tr, t_min): whether nothing worth tracing is left; the new transmittance; where the ray starts again.
        """
        if material[TRANSMITS] != 0.0:
            tau = times(colour(material, KT), tex)
        else:
            rest = add(1.0, -coverage(ta, material))
            tau = (rest, rest, rest)
        through = times(tr, tau)
        return not above(through, min_weight), through, behind(t)

    # ---- bounce -----------------------------------------------------------------------------------------------------

    @njit(error_model="numpy")
    def bounce(ctx, tex, w, alpha, inside, material, min_weight):
        """The rays that go on from a hit point.

        Args: context; the texture's colour; weight w of the ray that came; alpha' (`coverage`); whether it came from inside.
        Returns: (reflected, transmitted), each (traced, weight, direction, origin). Direction and weight of a ray that is
        not traced mean nothing.
        """
        point, g, m, d, md = ctx
        transmits = material[TRANSMITS] != 0.0
        fresnel = material[FRESNEL] != 0.0
        # angles
        c = -md if md < 0.0 else 0.0
        eta = material[IOR] if inside else material[INV_IOR]
        ce = mul(eta, c)
        k = add(add(1.0, -mul(eta, eta)), mul(ce, ce))
        tir = transmits and not k > 0.0
        sk = sqrt(k)
        b = add(ce, -sk)
        # how much goes where
        kr = colour(material, KR)
        if material[TEX_KR] != 0.0:
            kr = times(kr, tex)
        kt = colour(material, KT)
        x = add(1.0, -(sk if inside and transmits else c))
        x = x if x > 0.0 else 0.0
        x2 = mul(x, x)
        x5 = mul(mul(x2, x2), x)
        f = (
            add(kr[0], mul(add(1.0, -kr[0]), x5)),
            add(kr[1], mul(add(1.0, -kr[1]), x5)),
            add(kr[2], mul(add(1.0, -kr[2]), x5)),
        )
        if tir:
            r_part = (1.0, 1.0, 1.0) if fresnel else plus(kr, kt)
            t_part = (0.0, 0.0, 0.0)
        elif fresnel:
            r_part = f
            t_part = times(kt, (add(1.0, -f[0]), add(1.0, -f[1]), add(1.0, -f[2])))
        else:
            r_part, t_part = kr, kt
        wl = scale(alpha, w)
        # reflected
        r_weight = times(wl, r_part)
        r_traced = (material[REFLECTS] != 0.0 or tir) and above(r_weight, min_weight)
        r = plus(d, minus(scale(mul(2.0, md), m)))
        gr = dot2(g, r)
        if not gr > 0.0:
            r = plus(r, minus(scale(mul(2.0, gr), g)))
        r = scale(div(1.0, sqrt(dot2(r, r))), r)
        # transmitted
        sunk = plus(point, scale(SINK, g))
        if transmits:
            t_weight = times(wl, times(t_part, tex))
            t_traced = not tir and above(t_weight, min_weight)
            s = plus(scale(eta, d), scale(b, m))
            gs = dot2(g, s)
            if gs > 0.0:
                s = plus(s, minus(scale(mul(2.0, gs), g)))
            s = scale(div(1.0, sqrt(dot2(s, s))), s)
        else:
            t_weight = scale(add(1.0, -alpha), w)
            t_traced = material[ALPHA_MODE] != ALPHA_OPAQUE and above(t_weight, min_weight)
            s = d
        return (r_traced, r_weight, r, point), (t_traced, t_weight, s, sunk)

    # ---- the pixel's colour -----------------------------------------------------------------------------------------

    @njit(error_model="numpy")
    def add_miss(acc, w, background):
        """Colour acc after a ray of weight w that hit nothing."""
        return plus(acc, times(w, background))

    @njit(error_model="numpy")
    def add_surface(acc, wl, tex, material):
        """Colour acc with what a surface gives off without lights. wl: weight of the ray times alpha'."""
        return plus(acc, times(wl, plus(colour(material, EMIS), times(colour(material, AMB), tex))))

    @njit(error_model="numpy")
    def add_light(acc, wl, tr, k):
        """Colour acc with one light's k (`light_job`), seen through transmittance tr."""
        return plus(acc, times(times(wl, tr), k))

    return SimpleNamespace(
        place=place,
        hit_point=hit_point,
        longer=longer,
        coverage=coverage,
        weight=scale,
        light_job=light_job,
        shadow_through=shadow_through,
        bounce=bounce,
        add_miss=add_miss,
        add_surface=add_surface,
        add_light=add_light,
    )


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


@njit(error_model="numpy")
def _pow(a, b):
    return a**b


@njit(error_model="numpy")
def _behind(t):
    return t + T_MIN_DOUBLE


@njit(error_model="numpy")
def _behind24(t):
    return fp24.ulp_add(fp24.fadd(t, T_MIN), RESUME_ULP)


FP24 = make_shading(fp24.fadd, fp24.fadd3, fp24.fmul, fp24.fdiv, fp24.fsqrt, fp24.fpow, _behind24)
DOUBLE = make_shading(_add, _add3, _mul, _div, _sqrt, _pow, _behind)
