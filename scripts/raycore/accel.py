# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Host side of the record unit (docs/accel.md): what it is given, and the records of snapped scenes, which are always its own.

So a picture does not depend on who made the records of a scene on the grid: its reference is `raycore.model.accel`.
"""

import math

import numpy as np

from raycore import triaccel
from raycore.model import accel as model
from raycore.model import fp24

ATTRIBUTE_BYTES = 32  # of an attribute record: normals at the three corners, as in a vertex record, material, flat
GROWTH = 1.5  # of the edge slack's factor with the distance from the eye; the unit's arithmetic has it built in


def slack(eye, bounds):
    """What the unit needs to know of the view.

    Args: eye (3,), bounds (2, 3), in the unit box's coordinates. Returns: `model.Slack`.
    """
    eye = np.asarray(eye, dtype=np.float64)
    outside = np.linalg.norm(np.maximum(np.maximum(bounds[0] - eye, eye - bounds[1]), 0.0))
    least = math.ceil(model.SLACK_ONE * (1.0 + GROWTH * min(float(outside), 64.0)))
    near = np.clip(np.rint(eye * (1 << model.EYE_FRAC)), -model.EYE_MAX, model.EYE_MAX)
    return model.Slack(tuple(int(e) for e in near), min(least, model.SLACK_MAX))


def grid(unit):
    """Vertices of a snapped scene as (N, 3, 3) int64."""
    return np.rint(unit.triangles * 2.0**model.GRID).astype(np.int64)


def records(unit, view=None):
    """TriAccel records of a snapped scene.

    Args: unit: from `tbu.snap`; view: `model.Slack`, default the least.
    Returns: `triaccel.TriAccel`, (N, 3) float64 unit normals, (N,) float64 edge slack in half sizes.
    """
    view = view or model.Slack()
    vertices = grid(unit)
    out = model.records(vertices, view)
    k = out[:, 0]
    axes = (np.where(k == model.NEVER_HITS, 0, k)[:, None] + (1, 2, 0)) % 3
    values = fp24.from_bits(out.astype(np.uint32))
    rec = triaccel.TriAccel(
        k=k.astype(np.uint8),
        n=values[:, 1:3],
        a=np.take_along_axis(unit.triangles[:, 0], axes, axis=1),
        b=values[:, 3:5],
        g=values[:, 5:7],
        eps_code=out[:, 7].astype(np.uint16),
    )
    factors = model.slack_factors(vertices, view)
    return rec, values[:, 8:], factors * (triaccel.EDGE_SLACK / model.SLACK_ONE)


def triangle_info(unit, normals):
    """Shading data of a snapped scene, as the unit makes it.

    Args: unit: from `tbu.snap`; normals (N, 3, 3) float64, unit length.
    Returns: `triaccel.TriangleInfo`; normals are rounded, then subtracted.
    """
    geometric = records(unit)[1]
    n0, d1, d2 = model.corner_normals(fp24.round_to_fp24(normals), geometric)
    return triaccel.TriangleInfo(normal=geometric, vertex=unit.triangles[:, 0].copy(), n0=n0, dn1=d1, dn2=d2)


def attribute_records(normals, material, flat=None):
    """What the unit reads beside vertices: (N, 4) uint64, 32 bytes a triangle, low word first.

    Args: normals (N, 3, 3) float64; material (N,); flat (N,) bool: the plane's normal everywhere, default none.
    """
    bits = fp24.to_bits(fp24.round_to_fp24(normals)).reshape(-1, 9).astype(np.uint64)
    flags = np.asarray(material).astype(np.uint64) << np.uint64(model.MATERIAL_BIT % 64)
    if flat is not None:
        flags |= np.asarray(flat).astype(np.uint64) << np.uint64(model.FLAT_BIT % 64)
    return np.concatenate((pack_vectors(bits)[:, :3], (pack_vectors(bits)[:, 3] | flags)[:, None]), axis=1)


def pack_vectors(bits):
    """Nine FP24 bit patterns from bit 0 of a record of 32 bytes: (N, 9) to (N, 4) uint64."""
    words = np.zeros((len(bits), 4), np.uint64)
    for i in range(9):
        word, low = divmod(24 * i, 64)
        words[:, word] |= bits[:, i].astype(np.uint64) << np.uint64(low)
        if low > 40:
            words[:, word + 1] |= bits[:, i].astype(np.uint64) >> np.uint64(64 - low)
    return words
