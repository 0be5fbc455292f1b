# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The record unit (rtl/accel, docs/accel.md): TriAccel records and triangle information from vertices on the grid of 2^-17.

Everything is integer arithmetic on exact edges and cross products, so a quotient is the correctly rounded one. All integers
fit in 64 bits; the functions are compiled, and plain Python under `.py_func`.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from raycore.model import fp24

GRID = 17  # a coordinate is c 2^-17, |c| < 2^17
WIDTH = 37  # bits of a component of the cross product, and of operands of the divider
ROOT_DROP = 7  # bits of the normal's largest component that its length leaves out
EYE_FRAC = 8  # fraction bits of the eye
EYE_MAX = 64 << EYE_FRAC  # and its largest coordinate: further off, the slack is the largest anyway
SLACK_FRAC = 7  # fraction bits of the slack's factor
SLACK_ONE, SLACK_MAX = 1 << SLACK_FRAC, 64 << SLACK_FRAC
NEVER_HITS, NO_EPS = 3, 31 << 4  # k and edge slack of a triangle without area
FLAT_BIT, MATERIAL_BIT = 228, 216  # of an attribute record


@dataclass(frozen=True)
class Slack:
    """What decides the edge slack of a frame: values of registers.

    eye: three integers in 2^-8, at most `EYE_MAX`; least: factor in 2^-7, `SLACK_ONE` to `SLACK_MAX`.
    """

    eye: tuple = (0, 0, 0)
    least: int = SLACK_ONE


@njit(cache=True)
def _length(x):
    """Bits of x >= 0."""
    n = 0
    while x:
        x >>= 1
        n += 1
    return n


@njit(cache=True)
def quotient(a, b, exponent):
    """a / b * 2^exponent as FP24 bits, correctly rounded; 0 is +0.

    Args: integers, |a| and |b| < 2^37, b not 0. The result must lie in the range of FP24.
    """
    if a == 0:
        return 0
    sign = int((a < 0) != (b < 0))
    a, b = abs(a), abs(b)
    shift_a, shift_b = WIDTH - _length(a), WIDTH - _length(b)
    a <<= shift_a
    b <<= shift_b
    q, rest = (a << 18) // b, (a << 18) % b
    e = fp24.BIAS + shift_b - shift_a + exponent
    if q >> 18:
        rest |= q & 1
        q >>= 1
    else:
        e -= 1
    up = q & 1 == 1 and (rest != 0 or q & 2 == 2)
    significand = (q >> 1) + int(up)  # 17 bits, or 2^17
    return sign << 23 | (e << 16) + significand - (1 << 16)


@njit(cache=True)
def root(x):
    """Integer square root of 0 <= x < 2^62, rounded down."""
    r = 0
    for i in range(30, -1, -1):
        if (r | 1 << i) * (r | 1 << i) <= x:
            r |= 1 << i
    return r


@njit(cache=True)
def slack_factor(vertices, eye, least):
    """Factor of the edge slack, in 2^-7: as `image.edge_slack`, (|sum of vertices - 3 eye| - 1) / 2 within limits.

    Args: vertices (3, 3), eye (3,) integers, least as in `Slack`.
    """
    square = 0
    for i in range(3):
        d = ((vertices[0, i] + vertices[1, i] + vertices[2, i]) >> (GRID - EYE_FRAC)) - 3 * eye[i]
        square += d * d
    return min(max((root(square) - (1 << EYE_FRAC)) >> 2, least), SLACK_MAX)


@njit(cache=True)
def eps_code(factor, longest, det):
    """Edge slack factor * sqrt(longest) / |det| * 2^-7 as the code of `triaccel.encode_eps`, rounded up.

    Args: factor from `slack_factor`; longest: square of the longest projected edge; det: of the projected edges, not 0.
    """
    det = abs(det)
    lead = WIDTH - _length(longest)
    half = (lead + 1) // 2
    scaled = longest << 2 * half  # 37 or 38 bits
    edge = root(scaled)  # 19 bits
    edge += int(edge * edge < scaled)
    a = factor * edge
    shift_a, shift_b = WIDTH - _length(a), WIDTH - _length(det)
    a <<= shift_a
    det <<= shift_b
    q, rest = (a << 18) // det, (a << 18) % det
    e = shift_b - shift_a - SLACK_FRAC - half
    drop = 14 if q >> 18 else 13
    e -= int(drop == 13)
    rest |= q & ((1 << drop) - 1)
    m = (q >> drop) + int(rest != 0)  # 16 to 32
    if m == 32:
        m, e = 16, e + 1
    return 15 if e > -8 else (-8 - e) << 4 | (m - 16)


@njit(cache=True)
def record(vertices, eye, least, out):
    """Fields of one triangle.

    Args: vertices (3, 3) integers in 2^-17; eye, least as in `Slack`; out (11,): k, n_u, n_v, b_u, b_v, g_u, g_v, edge
        slack, unit normal x, y, z, bit patterns. Without area k = 3, the slack its least, all others 0.
    """
    e1, e2 = vertices[1] - vertices[0], vertices[2] - vertices[0]
    n = np.zeros(3, np.int64)
    k, largest = 0, 0
    for i in range(3):
        u, v = (i + 1) % 3, (i + 2) % 3
        n[i] = e1[u] * e2[v] - e1[v] * e2[u]
        if abs(n[i]) > largest:
            k, largest = i, abs(n[i])
    out[:] = 0
    if largest == 0:
        out[0], out[7] = NEVER_HITS, NO_EPS
        return
    u, v = (k + 1) % 3, (k + 2) % 3
    out[0] = k
    out[1], out[2] = quotient(n[u], n[k], 0), quotient(n[v], n[k], 0)
    out[3], out[4] = quotient(e2[v], n[k], GRID), quotient(-e2[u], n[k], GRID)
    out[5], out[6] = quotient(-e1[v], n[k], GRID), quotient(e1[u], n[k], GRID)
    longest = max(
        e1[u] * e1[u] + e1[v] * e1[v],
        e2[u] * e2[u] + e2[v] * e2[v],
        (e2[u] - e1[u]) ** 2 + (e2[v] - e1[v]) ** 2,
    )
    out[7] = eps_code(slack_factor(vertices, eye, least), longest, n[k])
    shift = WIDTH - _length(largest)
    square = 0
    for i in range(3):
        part = abs(n[i]) << shift >> ROOT_DROP
        square += part * part
    length = root(square)  # of n << shift >> ROOT_DROP
    for i in range(3):
        out[8 + i] = quotient(n[i], length, shift - ROOT_DROP)


@njit(cache=True)
def _records(vertices, eye, least):
    out = np.zeros((len(vertices), 11), np.int64)
    for i in range(len(vertices)):
        record(vertices[i], eye, least, out[i])
    return out


def records(vertices, slack=Slack()):
    """Fields of triangles as in `record`: (N, 11) int64.

    Args: vertices (N, 3, 3) int64 in 2^-17, below 2^17 in size; slack `Slack`.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.int64)
    return _records(vertices, np.array(slack.eye, np.int64), slack.least)


@njit(cache=True)
def _factors(vertices, eye, least):
    out = np.zeros(len(vertices), np.int64)
    for i in range(len(vertices)):
        out[i] = slack_factor(vertices[i], eye, least)
    return out


def slack_factors(vertices, slack):
    """`slack_factor` of triangles (N, 3, 3): (N,) int64."""
    return _factors(np.ascontiguousarray(vertices, dtype=np.int64), np.array(slack.eye, np.int64), slack.least)


def corner_normals(normals, geometric, flat=None):
    """Normals at vertex 0 and what vertices 1 and 2 differ by, as the unit makes them.

    Args: normals (N, 3, 3) float64 that hold FP24 numbers; geometric (N, 3) likewise; flat (N,) bool, default none:
        triangles whose normal is the geometric one everywhere.
    Returns: n0, n1 - n0, n2 - n0, each (N, 3), differences rounded once.
    """
    flat = np.zeros(len(normals), bool) if flat is None else np.asarray(flat, dtype=bool)
    n0, n1, n2 = normals[:, 0], normals[:, 1], normals[:, 2]
    mask = flat[:, None]
    with np.errstate(invalid="ignore", over="ignore"):
        d1, d2 = fp24.round_to_fp24(n1 - n0), fp24.round_to_fp24(n2 - n0)
    return np.where(mask, geometric, n0), np.where(mask, 0.0, d1), np.where(mask, 0.0, d2)
