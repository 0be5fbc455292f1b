# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Normals of meshes: their own made fit for use, or smooth ones where a file has none."""

import math

import numpy as np
from numba import njit

CREASE_COS = math.cos(math.radians(60.0))  # edges sharper than this stay sharp


def face_normals(triangles):
    """Unit normals (N, 3) by the right hand rule; zero where a triangle has no area."""
    edge1, edge2 = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    scale = np.maximum(np.abs(edge1).max(axis=1), np.abs(edge2).max(axis=1))[:, None]
    scale[scale == 0.0] = 1.0
    normal = np.cross(edge1 / scale, edge2 / scale)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0)


def _corner_angles(triangles):
    angles = np.empty(triangles.shape[:2])
    for corner in range(3):
        a = triangles[:, (corner + 1) % 3] - triangles[:, corner]
        b = triangles[:, (corner + 2) % 3] - triangles[:, corner]
        angles[:, corner] = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ij,ij->i", a, b))
    return angles


@njit(cache=True)
def _smooth(order, start, face_normal, angle, crease, limit, out):
    """Corner normals: for each corner the sum over corners at the same place whose faces are not across a crease.

    order (3N,) corners sorted by place, start (P + 1,) first of each place, angle (3N,), out (3N, 3). A face that is
    wound the other way counts as turned round. A place with more than `limit` corners stays flat (the time is
    quadratic).
    """
    for p in range(start.size - 1):
        for i in range(start[p], start[p + 1]):
            ci = order[i]
            fi = ci // 3
            x, y, z = face_normal[fi, 0], face_normal[fi, 1], face_normal[fi, 2]
            sx, sy, sz = 0.0, 0.0, 0.0
            if start[p + 1] - start[p] <= limit:
                for j in range(start[p], start[p + 1]):
                    cj = order[j]
                    fj = cj // 3
                    dot = x * face_normal[fj, 0] + y * face_normal[fj, 1] + z * face_normal[fj, 2]
                    if abs(dot) >= crease:
                        w = angle[cj] if dot >= 0.0 else -angle[cj]
                        sx += w * face_normal[fj, 0]
                        sy += w * face_normal[fj, 1]
                        sz += w * face_normal[fj, 2]
            length = (sx * sx + sy * sy + sz * sz) ** 0.5
            if length > 1e-12:
                out[ci, 0], out[ci, 1], out[ci, 2] = sx / length, sy / length, sz / length
            else:
                out[ci, 0], out[ci, 1], out[ci, 2] = x, y, z


def smooth_normals(triangles, crease_cos=CREASE_COS):
    """Corner normals (N, 3, 3) of a mesh without any: mean over the faces at a vertex, weighted by angle.

    Vertices are joined by exact position; faces that meet at more than the crease angle (60 degrees) do not mix. A
    triangle without area gets (0, 0, 1).
    """
    count = triangles.shape[0]
    flat = face_normals(triangles)
    points = np.ascontiguousarray(triangles.reshape(-1, 3) + 0.0)  # + 0.0: -0 and 0 are one place
    order = np.lexsort(points.T)
    ordered = points[order]
    new = np.concatenate(([True], np.any(ordered[1:] != ordered[:-1], axis=1)))
    start = np.concatenate((np.flatnonzero(new), [points.shape[0]]))
    out = np.empty((3 * count, 3))
    _smooth(order, start, flat, _corner_angles(triangles).reshape(-1), crease_cos, 2048, out)
    out[~out.any(axis=1)] = (0.0, 0.0, 1.0)
    return out.reshape(count, 3, 3)


def orient_normals(normals, triangles):
    """Normals of a file made fit for use: unit length, on their triangle's side, its own where useless."""
    flat = face_normals(triangles)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    good = (length > 1e-12) & np.isfinite(length)
    out = np.divide(normals, length, out=np.broadcast_to(flat[:, None], normals.shape).copy(), where=good)
    out *= np.where(np.einsum("nij,nj->ni", out, flat) < 0.0, -1.0, 1.0)[:, :, None]
    out[~out.any(axis=2)] = (0.0, 0.0, 1.0)
    return out
