# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Texture unit, bit for bit what `rtl/shade/rc_texture.sv` computes (docs/whitted.md, docs/texture.md; paper Sec. 3.6).

`sample24` is the unit; `sample64` the same in double precision, with coordinates, weights and the sRGB curve exact. Both are
compiled by numba, to be called once a hit from other compiled loops.

Arguments of both:

* texels: TEX region, uint8, one dimension. Blocks of 64 bytes; what lies outside reads as 0, as the memory port answers it;
* desc: texture of a material, (10,) int64: tex_base (block), log2_w, log2_h, levels, wrap_s, wrap_t, rgba5551, srgb, spare, spare;
* uv: record of the triangle, (7,) float64: u0 v0 du1 dv1 du2 dv2 mip (the last an integer, in 1/64 of a level);
* beta, gamma: barycentric weights of the hit; length: of the path up to the hit (len' of docs/whitted.md);
* mip_bias: in 1/64 of a level; trilinear: between two levels, else the nearest.
"""

import math

import numpy as np
from numba import njit

from . import fp24

MIP_FRAC_W = 6  # bits of fraction of a level
REPEAT, MIRROR, CLAMP = 0, 1, 2  # wrap_e; 3 counts as CLAMP
BLOCK = 64  # bytes
ONE = 4096  # a channel of 1
LOG_ZERO = -4096  # log2 of 0, in 1/64
COORD_LIMIT = 2**23  # fixed-point coordinates, 8 bits of fraction, are 24 bits wide

LOG = np.array([round(64 * math.log2(1 + (i + 0.5) / 64)) for i in range(64)], dtype=np.int64)


def srgb_to_linear(c):
    """sRGB in [0, 1] to linear (IEC 61966-2-1), as float64 of the shape of c."""
    c = np.asarray(c, dtype=np.float64)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(c):
    """Inverse of `srgb_to_linear`."""
    c = np.asarray(c, dtype=np.float64)
    return np.where(c <= 0.0031308, c * 12.92, 1.055 * np.maximum(c, 0.0) ** (1 / 2.4) - 0.055)


SRGB64 = srgb_to_linear(np.arange(256) / 255)
LINEAR64 = np.arange(256) / 255
SRGB = np.rint(SRGB64 * ONE).astype(np.int64)  # (256,), 13 bits
LINEAR = np.rint(LINEAR64 * ONE).astype(np.int64)  # a tie cannot happen: 255 is odd


@njit(cache=True, error_model="numpy")
def log2_fixed(x):
    """log2 |x| of an FP24 number in 1/64, to within 0.9 of these (the table's segments): an integer.

    Zero gives -4096. Infinity and NaN are read as their pattern, as if 2^64 and 1.5 * 2^64 (the one NaN of fp24).
    """
    if x == 0.0:
        return np.int64(LOG_ZERO)
    if x != x:
        return np.int64(64 * 64) + LOG[32]
    if abs(x) == math.inf:
        return np.int64(64 * 64) + LOG[0]
    u = np.float64(x).view(np.int64)
    return (((u >> 52) & 0x7FF) - 1023) * 64 + LOG[(u >> 46) & 63]


@njit(cache=True, error_model="numpy")
def wrap_texel(i, log2_size, wrap):
    """Index of a texel, any integer, brought into [0, 2^log2_size)."""
    size = np.int64(1) << log2_size
    if wrap == REPEAT:
        return i & (size - 1)
    if wrap == MIRROR:
        return (~i if i & size else i) & (size - 1)
    return min(max(i, np.int64(0)), size - 1)


@njit(cache=True, error_model="numpy")
def _blocks_log2(log2_size, level, per_block):
    """log2 of the blocks in a row (per_block: log2 of the texels that one has) or column of a level."""
    return max(log2_size - level - per_block, 0)


@njit(cache=True, error_model="numpy")
def level_offset(log2_w, log2_h, rgba5551, level):
    """Blocks of the levels above `level`, the largest being level 0."""
    n = np.int64(0)
    for k in range(level):
        n += np.int64(1) << (_blocks_log2(log2_w, k, 3 if rgba5551 else 2) + _blocks_log2(log2_h, k, 2))
    return n


@njit(cache=True, error_model="numpy")
def texel_at(texels, desc, level, x, y):
    """Channels of texel (x, y) of a level, x and y inside it, as four integers of 8 bits: red, green, blue, alpha."""
    wide = 3 if desc[6] else 2
    block = desc[0] + level_offset(desc[1], desc[2], desc[6], level)
    block += ((y >> 2) << _blocks_log2(desc[1], level, wide)) + (x >> wide)
    if desc[6]:
        at = block * BLOCK + ((y & 3) << 4) + ((x & 7) << 1)
    else:
        at = block * BLOCK + ((y & 3) << 4) + ((x & 3) << 2)
    if at + 4 > texels.size + (2 if desc[6] else 0):
        return np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    if desc[6]:
        t = np.int64(texels[at]) | np.int64(texels[at + 1]) << 8
        r, g, b = t & 31, (t >> 5) & 31, (t >> 10) & 31
        return r << 3 | r >> 2, g << 3 | g >> 2, b << 3 | b >> 2, (t >> 15) * 255
    return np.int64(texels[at]), np.int64(texels[at + 1]), np.int64(texels[at + 2]), np.int64(texels[at + 3])


@njit(cache=True, error_model="numpy")
def _remainder(x, m):
    """x less the largest multiple of m towards zero; exact, for m a power of two."""
    return x - m * np.trunc(x / m)


@njit(cache=True, error_model="numpy")
def fixed_coord(u, log2_size, wrap):
    """floor(u * 2^log2_size * 256) - 128: position of a sample among the centres of texels, 8 bits of fraction.

    The product counts modulo 2^24 if the texture repeats or is mirrored; CLAMP keeps it in 24 bits. NaN gives a product of 0.
    """
    s = u * (256.0 * float(np.int64(1) << log2_size))  # exact
    if s != s:
        s = 0.0
    elif wrap >= CLAMP:
        s = min(max(s, -float(COORD_LIMIT)), float(COORD_LIMIT - 1))
    else:
        s = 0.0 if abs(s) == math.inf else _remainder(s, 2.0 * COORD_LIMIT)
    return np.int64(math.floor(s)) - 128


@njit(cache=True, error_model="numpy")
def _bilinear24(texels, desc, level, u, v):
    """One level: four integers, 2^28 = 1."""
    lw, lh = max(desc[1] - level, 0), max(desc[2] - level, 0)
    x, y = fixed_coord(u, lw, desc[4]), fixed_coord(v, lh, desc[5])
    fx, fy = x & 255, y & 255
    x0, x1 = wrap_texel(x >> 8, lw, desc[4]), wrap_texel((x >> 8) + 1, lw, desc[4])
    y0, y1 = wrap_texel(y >> 8, lh, desc[5]), wrap_texel((y >> 8) + 1, lh, desc[5])
    a = texel_at(texels, desc, level, x0, y0)
    b = texel_at(texels, desc, level, x1, y0)
    c = texel_at(texels, desc, level, x0, y1)
    d = texel_at(texels, desc, level, x1, y1)
    curve = SRGB if desc[7] else LINEAR
    r = _mix24(curve[a[0]], curve[b[0]], curve[c[0]], curve[d[0]], fx, fy)
    g = _mix24(curve[a[1]], curve[b[1]], curve[c[1]], curve[d[1]], fx, fy)
    b_ = _mix24(curve[a[2]], curve[b[2]], curve[c[2]], curve[d[2]], fx, fy)
    return r, g, b_, _mix24(LINEAR[a[3]], LINEAR[b[3]], LINEAR[c[3]], LINEAR[d[3]], fx, fy)


@njit(cache=True, error_model="numpy")
def _mix24(a, b, c, d, fx, fy):
    top = a * (256 - fx) + b * fx
    bottom = c * (256 - fx) + d * fx
    return top * (256 - fy) + bottom * fy


@njit(cache=True, error_model="numpy")
def choose_level(length, mip, mip_bias, levels, trilinear):
    """(level, weight of the next one in 1/64). The weight is 0 where there is no next one, and unless trilinear."""
    lam = log2_fixed(length) + np.int64(mip) + np.int64(mip_bias)
    top = max(np.int64(levels), np.int64(1)) - 1
    if trilinear:
        lam = min(max(lam, np.int64(0)), top << MIP_FRAC_W)
        return lam >> MIP_FRAC_W, lam & 63
    return min(max((lam + 32) >> MIP_FRAC_W, np.int64(0)), top), np.int64(0)


@njit(cache=True, error_model="numpy")
def sample24(texels, desc, uv, beta, gamma, length, mip_bias, trilinear):
    """Colour and alpha of a texture at a hit: (r, g, b, a), FP24 numbers in [0, 1]. Arguments: see the module."""
    u = fp24.fadd(fp24.fadd(uv[0], fp24.fmul(beta, uv[2])), fp24.fmul(gamma, uv[4]))
    v = fp24.fadd(fp24.fadd(uv[1], fp24.fmul(beta, uv[3])), fp24.fmul(gamma, uv[5]))
    level, fl = choose_level(length, uv[6], mip_bias, desc[3], trilinear)
    r, g, b, a = _bilinear24(texels, desc, level, u, v)
    r, g, b, a = r << 6, g << 6, b << 6, a << 6
    if fl != 0:
        r1, g1, b1, a1 = _bilinear24(texels, desc, level + 1, u, v)
        r += (r1 - (r >> 6)) * fl
        g += (g1 - (g >> 6)) * fl
        b += (b1 - (b >> 6)) * fl
        a += (a1 - (a >> 6)) * fl
    one = 2.0**34
    return fp24.rnd(r / one), fp24.rnd(g / one), fp24.rnd(b / one), fp24.rnd(a / one)


# ---- the same in double precision --------------------------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def _coord64(u, log2_size, wrap):
    """(texel before the sample, weight of the one behind it) for a coordinate in [0, 1] times repeats."""
    size = float(np.int64(1) << log2_size)
    if wrap >= CLAMP:
        s = 0.0 if u != u else min(max(u, -1.0), 2.0) * size - 0.5
    else:
        s = _remainder(u, 2.0)  # NaN for what is not finite
        s = (0.0 if s != s else s * size) - 0.5
    f = math.floor(s)
    return np.int64(f), s - f


@njit(cache=True, error_model="numpy")
def _bilinear64(texels, desc, level, u, v):
    lw, lh = max(desc[1] - level, 0), max(desc[2] - level, 0)
    x, fx = _coord64(u, lw, desc[4])
    y, fy = _coord64(v, lh, desc[5])
    curve = SRGB64 if desc[7] else LINEAR64
    r = g = b = a = 0.0
    for j in range(2):
        for i in range(2):
            w = (fx if i else 1.0 - fx) * (fy if j else 1.0 - fy)
            t = texel_at(texels, desc, level, wrap_texel(x + i, lw, desc[4]), wrap_texel(y + j, lh, desc[5]))
            r, g, b = r + w * curve[t[0]], g + w * curve[t[1]], b + w * curve[t[2]]
            a += w * LINEAR64[t[3]]
    return r, g, b, a


@njit(cache=True, error_model="numpy")
def sample64(texels, desc, uv, beta, gamma, length, mip_bias, trilinear):
    """`sample24` with double arithmetic: coordinates, level, weights and colours are not rounded; the texels are the same."""
    u = uv[0] + beta * uv[2] + gamma * uv[4]
    v = uv[1] + beta * uv[3] + gamma * uv[5]
    top = float(max(desc[3], 1) - 1)
    # log2(0) is minus infinity, the largest level; a NaN is as far away as it can be
    lam = (math.log2(length) if length > 0.0 else -64.0 if length == 0.0 else 64.0) + (uv[6] + mip_bias) / 64.0
    if not trilinear:
        return _bilinear64(texels, desc, np.int64(min(max(math.floor(lam + 0.5), 0.0), top)), u, v)
    lam = min(max(lam, 0.0), top)
    level = np.int64(math.floor(lam))
    fl = lam - level
    r, g, b, a = _bilinear64(texels, desc, level, u, v)
    if fl == 0.0:
        return r, g, b, a
    r1, g1, b1, a1 = _bilinear64(texels, desc, level + 1, u, v)
    return r + fl * (r1 - r), g + fl * (g1 - g), b + fl * (b1 - b), a + fl * (a1 - a)
