# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Ray tracing in double precision, the yardstick for the 24-bit tracer: a plain bounding volume hierarchy.

It shares nothing with the kd-tree, so that it also shows faults of the tree builder. Build: binned SAH (I. Wald, "On fast
construction of SAH-based bounding volume hierarchies", 2007). Triangle test: T. Moeller and B. Trumbore, "Fast, minimum
storage ray/triangle intersection", 1997, edges included.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

BINS = 16
LEAF = 4  # no split below this many triangles
DEPTH = 64
NONE = -1
COINCIDENT = 2.0**-40  # relative: two hits this close lie on one surface as far as double precision can tell
_PAD = 1e-12  # boxes are enlarged by this much, in half sizes of the scene; rounding costs 1e-16


class Bvh(NamedTuple):
    """Triangles sorted into leaves, and the nodes over them; children of a node lie side by side."""

    box: np.ndarray  # (nodes, 2, 3)
    first: np.ndarray  # (nodes,) first triangle of a leaf, or first child
    count: np.ndarray  # (nodes,) triangles of a leaf, 0: inner node
    corner: np.ndarray  # (triangles, 3, 3) vertex 0 and the two edges that leave it
    index: np.ndarray  # (triangles,) numbers of the triangles
    mat: np.ndarray  # (triangles,) int64 materials, by number of the triangle
    opaque: np.ndarray  # (triangles,) bool, by number of the triangle


@njit(cache=True)
def _half_area(lo, hi):
    x, y, z = hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]
    return x * y + y * z + z * x


@njit(cache=True)
def _build(lo, hi, centre, order):
    n = order.size
    box = np.empty((2 * n + 1, 2, 3))
    first = np.zeros(2 * n + 1, np.int64)
    count = np.zeros(2 * n + 1, np.int64)
    stack = np.empty((4 * DEPTH, 4), np.int64)
    stack[0] = (0, 0, n, 0)
    top, nodes = 1, 1
    bin_n = np.empty(BINS, np.int64)
    bin_lo, bin_hi = np.empty((BINS, 3)), np.empty((BINS, 3))
    right = np.empty(BINS)
    while top > 0:
        top -= 1
        node, begin, end, depth = stack[top]
        c_lo, c_hi = np.full(3, np.inf), np.full(3, -np.inf)
        box[node, 0], box[node, 1] = np.inf, -np.inf
        for i in range(begin, end):
            t = order[i]
            for a in range(3):
                box[node, 0, a] = min(box[node, 0, a], lo[t, a])
                box[node, 1, a] = max(box[node, 1, a], hi[t, a])
                c_lo[a], c_hi[a] = min(c_lo[a], centre[t, a]), max(c_hi[a], centre[t, a])
        first[node], count[node] = begin, end - begin
        if end - begin <= LEAF or depth >= DEPTH - 1:
            continue
        best, best_axis, best_bin = np.inf, -1, 0
        for a in range(3):
            if not c_hi[a] > c_lo[a]:
                continue
            scale = BINS / (c_hi[a] - c_lo[a])
            bin_n[:], bin_lo[:], bin_hi[:] = 0, np.inf, -np.inf
            for i in range(begin, end):
                t = order[i]
                b = min(int((centre[t, a] - c_lo[a]) * scale), BINS - 1)
                bin_n[b] += 1
                for c in range(3):
                    bin_lo[b, c], bin_hi[b, c] = min(bin_lo[b, c], lo[t, c]), max(bin_hi[b, c], hi[t, c])
            r_lo, r_hi, r_n = np.full(3, np.inf), np.full(3, -np.inf), 0
            for b in range(BINS - 1, 0, -1):
                r_n += bin_n[b]
                r_lo, r_hi = np.minimum(r_lo, bin_lo[b]), np.maximum(r_hi, bin_hi[b])
                right[b] = r_n * _half_area(r_lo, r_hi) if r_n > 0 else 0.0
            l_lo, l_hi, l_n = np.full(3, np.inf), np.full(3, -np.inf), 0
            for b in range(BINS - 1):
                l_n += bin_n[b]
                l_lo, l_hi = np.minimum(l_lo, bin_lo[b]), np.maximum(l_hi, bin_hi[b])
                if 0 < l_n < end - begin:
                    cost = l_n * _half_area(l_lo, l_hi) + right[b + 1]
                    if cost < best:
                        best, best_axis, best_bin = cost, a, b
        if best_axis < 0:  # all centres in one place: halve the list
            middle = (begin + end) // 2
        else:
            scale = BINS / (c_hi[best_axis] - c_lo[best_axis])
            middle, last = begin, end - 1
            while middle <= last:
                t = order[middle]
                if min(int((centre[t, best_axis] - c_lo[best_axis]) * scale), BINS - 1) <= best_bin:
                    middle += 1
                else:
                    order[middle], order[last] = order[last], t
                    last -= 1
        first[node], count[node] = nodes, 0
        stack[top] = (nodes, begin, middle, depth + 1)
        stack[top + 1] = (nodes + 1, middle, end, depth + 1)
        top += 2
        nodes += 2
    return box[:nodes], first[:nodes], count[:nodes]


def build(triangles, mat=None, opaque=None):
    """`Bvh` of triangles (N, 3, 3) float64, N at least 1, coordinates in [-1, 1] and not rounded.

    mat (N,) materials, default 0; opaque (N,) bool, default all.
    """
    triangles = np.ascontiguousarray(triangles, dtype=np.float64)
    lo, hi = triangles.min(axis=1) - _PAD, triangles.max(axis=1) + _PAD
    order = np.arange(len(triangles))
    box, first, count = _build(lo, hi, (lo + hi) / 2.0, order)
    corner = triangles[order]
    corner[:, 1:] -= corner[:, :1]
    mat = np.zeros(len(triangles), np.int64) if mat is None else np.asarray(mat).astype(np.int64)
    opaque = np.ones(len(triangles), bool) if opaque is None else np.ascontiguousarray(opaque, dtype=bool)
    return Bvh(box.copy(), first.copy(), count.copy(), corner, order, mat, opaque)


@njit(cache=True, error_model="numpy")
def trace_ray(bvh, org, d, t_min, t_max, skip, any_hit):
    """One ray: (triangle or NONE, t, beta, gamma), the nearest hit with t_min < t < t_max.

    org, d: vectors, tuples of three; skip: triangle that is never hit, or NONE; any_hit: an opaque triangle ends the search.
    """
    best, best_tri, best_beta, best_gamma = t_max, NONE, 0.0, 0.0
    stack = np.empty(DEPTH + 2, np.int64)
    stack[0] = 0
    sp = 1
    inv = (1.0 / d[0], 1.0 / d[1], 1.0 / d[2])
    while sp > 0:
        sp -= 1
        node = stack[sp]
        near, far = 0.0, best
        for a in range(3):
            if d[a] == 0.0:
                if org[a] < bvh.box[node, 0, a] or org[a] > bvh.box[node, 1, a]:
                    far = -1.0
            else:
                t0 = (bvh.box[node, 0, a] - org[a]) * inv[a]
                t1 = (bvh.box[node, 1, a] - org[a]) * inv[a]
                near, far = max(near, min(t0, t1)), min(far, max(t0, t1))
        if near > far:
            continue
        if bvh.count[node] == 0:
            # The child whose centre lies nearer along the ray comes first.
            left = bvh.first[node]
            along = 0.0
            for a in range(3):
                along += d[a] * (
                    bvh.box[left, 0, a] + bvh.box[left, 1, a] - bvh.box[left + 1, 0, a] - bvh.box[left + 1, 1, a]
                )
            stack[sp], stack[sp + 1] = (left + 1, left) if along < 0.0 else (left, left + 1)
            sp += 2
            continue
        for i in range(bvh.first[node], bvh.first[node] + bvh.count[node]):
            if bvh.index[i] == skip:
                continue
            a, b, c = bvh.corner[i, 0], bvh.corner[i, 1], bvh.corner[i, 2]
            px, py, pz = d[1] * c[2] - d[2] * c[1], d[2] * c[0] - d[0] * c[2], d[0] * c[1] - d[1] * c[0]
            det = b[0] * px + b[1] * py + b[2] * pz
            if det == 0.0:
                continue
            sx, sy, sz = org[0] - a[0], org[1] - a[1], org[2] - a[2]
            beta = (sx * px + sy * py + sz * pz) / det
            qx, qy, qz = sy * b[2] - sz * b[1], sz * b[0] - sx * b[2], sx * b[1] - sy * b[0]
            gamma = (d[0] * qx + d[1] * qy + d[2] * qz) / det
            if beta >= 0.0 and gamma >= 0.0 and beta + gamma <= 1.0:
                t = (c[0] * qx + c[1] * qy + c[2] * qz) / det
                if t_min < t < best:
                    best, best_tri, best_beta, best_gamma = t, bvh.index[i], beta, gamma
                    if any_hit and bvh.opaque[best_tri]:
                        return best_tri, best, best_beta, best_gamma
    return best_tri, best, best_beta, best_gamma


@njit(cache=True, error_model="numpy")
def coincident(triangles, tri, org, d, found, t, beta, gamma):
    """The hit of `trace_ray`, on triangle `tri` instead if that one is hit at the same distance.

    Where triangles coincide, double precision meets one or the other as its rounding falls; this settles which.

    triangles (N, 3, 3) those of the `Bvh`; tri: wanted, or NONE; org, d: the ray; then the hit. Returns: the hit.
    """
    if found == NONE or tri == NONE or tri == found:
        return found, t, beta, gamma
    zero, one = np.zeros(1, np.int64), np.ones(1, np.int64)
    only = Bvh(np.empty((1, 2, 3)), zero, one, np.empty((1, 3, 3)), zero, zero, np.ones(1, np.bool_))
    only.box[0, 0], only.box[0, 1] = -np.inf, np.inf
    only.corner[0] = triangles[tri]
    only.corner[0, 1] -= triangles[tri, 0]
    only.corner[0, 2] -= triangles[tri, 0]
    hit, t1, beta1, gamma1 = trace_ray(only, org, d, 0.0, np.inf, NONE, False)
    if hit != NONE and abs(t1 - t) <= COINCIDENT * t:
        return tri, t1, beta1, gamma1
    return found, t, beta, gamma
