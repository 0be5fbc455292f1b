# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Precomputed triangle records for the ray-triangle test, in vertex-relative form, and the normals beside them.

Source: I. Wald, "Realtime Ray Tracing and Interactive Global Illumination", 2004, Sec. 7.1 (TriAccel). The plane
equation is taken relative to vertex A here: with 17-bit significands Wald's constants n_d, b_d and c_d cancel badly far
from the origin. All constants are computed in double precision from the rounded vertices, then rounded once.

The record (32 bytes, four words of 60 used bits) is `triaccel_t` in `rtl/rc_pkg.sv`.
"""

from dataclasses import dataclass

import numpy as np

from raycore.model import fp24

NEVER_HITS = 3  # value of k for triangles without area
MAX_MATERIAL = (1 << 12) - 1
EDGE_SLACK = 2.0**-17  # distance by which a triangle's edges are moved outwards, in units of the scene's half size
EPS_TOP = 8  # the largest slack is below 2^(1 - EPS_TOP)


@dataclass
class TriAccel:
    """Fields of N records; values are float64 that hold FP24 numbers."""

    k: np.ndarray  # (N,) projection axis, argmax |normal|; 3 never hits
    n: np.ndarray  # (N, 2) n_u, n_v
    a: np.ndarray  # (N, 3) A_u, A_v, A_k
    b: np.ndarray  # (N, 2) b_u, b_v
    g: np.ndarray  # (N, 2) g_u, g_v
    eps_code: np.ndarray  # (N,) {e[4:0], m[3:0]}, see `decode_eps`


@dataclass
class TriangleInfo:
    """What shading needs of N triangles; values are float64 that hold FP24 numbers."""

    normal: np.ndarray  # (N, 3) geometric unit normal by the right hand rule; 0 if there is no area
    vertex: np.ndarray  # (N, 3) vertex A
    n0: np.ndarray  # (N, 3) shading normal at A
    dn1: np.ndarray  # (N, 3) n1 - n0: the interpolated normal is n0 + beta * dn1 + gamma * dn2
    dn2: np.ndarray  # (N, 3)


def encode_eps(eps):
    """9-bit code of the edge slack, rounded up: eps <= decode_eps(code), clamped to 31/16 * 2^-8 (float64 arrays)."""
    m, e = np.frexp(np.clip(eps, 0.0, 1.0))  # eps = 2m * 2^(e-1)
    e = 1 - EPS_TOP - e
    m = np.ceil((2.0 * m - 1.0) * 16.0).astype(np.int64)
    carry = m == 16
    e, m = np.where(carry, e - 1, e), np.where(carry, 0, m)
    low, high = (e > 31) | (eps <= 0.0), (e < 0)
    code = (np.clip(e, 0, 31) << 4) | m
    return np.where(low, 31 << 4, np.where(high, 15, code)).astype(np.uint16)


def decode_eps(code):
    """Edge slack (1 + m/16) * 2^-(8+e) of a 9-bit code {e[4:0], m[3:0]}."""
    code = np.asarray(code).astype(np.int64)
    return (1.0 + (code & 15) / 16.0) * 2.0 ** -(EPS_TOP + (code >> 4)).astype(np.float64)


def has_area(tri):
    """(N,) bool: triangles (N, 3, 3) whose normal, computed in double from the vertices, is finite and not zero."""
    n = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    return np.any(n != 0.0, axis=1) & np.isfinite(n).all(axis=1)


def records(tri24, mask=None, slack=EDGE_SLACK):
    """TriAccel fields of triangles.

    Args:
        tri24: (N, 3, 3) float64, vertices that are FP24 numbers in [-1, 1].
        mask: (N,) bool, triangles that must never be hit (no area); found here too.
        slack: distance by which edges are moved outwards, one or (N,).
    Returns: `TriAccel`. A record with a constant outside FP24 never hits either.
    """
    tri = np.asarray(tri24, dtype=np.float64)
    count = tri.shape[0]
    rows = np.arange(count)
    a, e1, e2 = tri[:, 0], tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]
    normal = np.cross(e1, e2)
    k = np.argmax(np.abs(normal), axis=1)
    u, v = (k + 1) % 3, (k + 2) % 3
    e1u, e1v, e2u, e2v = e1[rows, u], e1[rows, v], e2[rows, u], e2[rows, v]
    n_k = normal[rows, k]  # = e1u * e2v - e1v * e2u, the determinant of the projected edges
    dead = n_k == 0.0
    if mask is not None:
        dead |= np.asarray(mask, dtype=bool)
    det = np.where(dead, 1.0, n_k)[:, None]
    with np.errstate(over="ignore", invalid="ignore"):
        n = np.stack((normal[rows, u], normal[rows, v]), axis=1) / det
        b = np.stack((e2v, -e2u), axis=1) / det
        g = np.stack((-e1v, e1u), axis=1) / det
        slope = np.maximum(np.linalg.norm(b, axis=1), np.linalg.norm(g, axis=1))
        slope = np.maximum(slope, np.linalg.norm(b + g, axis=1))
    out = TriAccel(
        k=np.where(dead, NEVER_HITS, k).astype(np.uint8),
        n=fp24.round_to_fp24(n),
        a=np.stack((a[rows, u], a[rows, v], a[rows, k]), axis=1),
        b=fp24.round_to_fp24(b),
        g=fp24.round_to_fp24(g),
        eps_code=encode_eps(np.where(dead, 0.0, slack * slope)),
    )
    dead |= ~(np.isfinite(out.b).all(axis=1) & np.isfinite(out.g).all(axis=1))
    out.k[dead] = NEVER_HITS
    for field in (out.n, out.b, out.g):
        field[dead] = 0.0
    out.eps_code[dead] = 31 << 4
    return out


def pack(rec, material, opaque=None):
    """Memory words of records.

    Args: rec `TriAccel` of N triangles; material (N,) integers below 4096; opaque (N,) bool, default all.
    Returns: (N, 4) uint64, little-endian words of 60 used bits.
    Raises: ValueError if a material index does not fit.
    """
    material = np.asarray(material).astype(np.uint64)
    if material.size and int(material.max()) > MAX_MATERIAL:
        raise ValueError(f"material index {int(material.max())} is above {MAX_MATERIAL}")
    solid = np.ones(rec.k.size, bool) if opaque is None else np.asarray(opaque, dtype=bool)

    def word(low, mid, top):
        return low | (mid << np.uint64(24)) | (top << np.uint64(48))

    n, a, b, g = (fp24.to_bits(np.ascontiguousarray(x)).astype(np.uint64) for x in (rec.n, rec.a, rec.b, rec.g))
    flags = (
        rec.eps_code.astype(np.uint64)
        | (rec.k.astype(np.uint64) << np.uint64(9))
        | (solid.astype(np.uint64) << np.uint64(11))
    )
    return np.stack(
        (
            word(n[:, 0], n[:, 1], flags),
            word(a[:, 0], a[:, 1], material),
            word(a[:, 2], b[:, 0], b[:, 1] & np.uint64(0xFFF)),
            word(g[:, 0], g[:, 1], b[:, 1] >> np.uint64(12)),
        ),
        axis=1,
    )


def unpack(words):
    """Inverse of `pack`: (N, 4) uint64 to (`TriAccel`, material, opaque)."""
    w = np.asarray(words, dtype=np.uint64)

    def field(word, at, bits=24):
        return (w[:, word] >> np.uint64(at)) & np.uint64((1 << bits) - 1)

    def pair(x, y):
        return fp24.from_bits(np.stack((x, y), axis=1))

    flags = field(0, 48, 12).astype(np.int64)
    rec = TriAccel(
        k=(flags >> 9 & 3).astype(np.uint8),
        n=pair(field(0, 0), field(0, 24)),
        a=fp24.from_bits(np.stack((field(1, 0), field(1, 24), field(2, 0)), axis=1)),
        b=pair(field(2, 24), field(2, 48, 12) | (field(3, 48, 12) << np.uint64(12))),
        g=pair(field(3, 0), field(3, 24)),
        eps_code=(flags & 0x1FF).astype(np.uint16),
    )
    return rec, field(1, 48, 12).astype(np.int64), (flags >> 11 & 1).astype(bool)


def triangle_info(tri24, normals):
    """Shading data of triangles.

    Args: tri24 (N, 3, 3) rounded vertices; normals (N, 3, 3) float64 shading normals per corner, unit length.
    Returns: `TriangleInfo`; differences are taken in double precision and rounded once.
    """
    tri = np.asarray(tri24, dtype=np.float64)
    cross = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    # Tiny triangles: scale first, so that the squared length neither underflows nor loses digits.
    scale = np.abs(cross).max(axis=1, keepdims=True)
    cross = np.divide(cross, scale, out=np.zeros_like(cross), where=scale > 0.0)
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    geometric = np.divide(cross, length, out=np.zeros_like(cross), where=length > 0.0)
    n0, n1, n2 = normals[:, 0], normals[:, 1], normals[:, 2]
    rounded = fp24.round_to_fp24
    return TriangleInfo(
        normal=rounded(geometric), vertex=tri[:, 0].copy(), n0=rounded(n0), dn1=rounded(n1 - n0), dn2=rounded(n2 - n0)
    )
