# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Keys of a mesh over time (`animation` in scene files): where it is at a time, as a matrix."""

import math
from itertools import pairwise

import numpy as np

NEARLY_ALONG = 1e-9  # of an axis of unit length: two axes are one


def rotation(axis, degrees):
    """Rotation matrix (3, 3), counter-clockwise seen against the axis (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(degrees)
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def duration(animation):
    """Seconds until the last key."""
    return float(animation["keys"][-1]["time"])


def _turn(key):
    """A key's rotation: unit axis (3,) or None where it has none, and degrees. Raises: ValueError."""
    if "rotate" not in key:
        return None, 0.0
    axis = np.asarray(key["rotate"]["axis"], dtype=np.float64)
    if not axis.any():
        raise ValueError("the axis of a rotation is zero")
    return axis / np.linalg.norm(axis), float(key["rotate"]["degrees"])


def _quaternion(axis, degrees):
    half = math.radians(degrees) / 2.0
    return np.array([math.cos(half), *(math.sin(half) * axis)])


def _slerp(a, b, share):
    """Between two rotations, unit quaternions, on the short way: axis and degrees."""
    dot = float(a @ b)
    if dot < 0.0:
        b, dot = -b, -dot
    angle = math.acos(min(dot, 1.0))
    if angle < NEARLY_ALONG:
        q = a
    else:
        q = (math.sin((1.0 - share) * angle) * a + math.sin(share * angle) * b) / math.sin(angle)
    size = float(np.linalg.norm(q[1:]))
    if size < NEARLY_ALONG:
        return np.array([0.0, 1.0, 0.0]), 0.0
    return q[1:] / size, math.degrees(2.0 * math.atan2(size, q[0]))


def _between(a, b, share):
    """Translation (3,), rotation (3, 3) and scale (3,) between two keys."""

    def mixed(name, otherwise):
        x, y = (np.broadcast_to(np.asarray(k.get(name, otherwise), dtype=np.float64), 3) for k in (a, b))
        return x + share * (y - x)

    (axis_a, degrees_a), (axis_b, degrees_b) = _turn(a), _turn(b)
    axis_a = axis_b if axis_a is None else axis_a
    axis_b = axis_a if axis_b is None else axis_b
    if axis_a is None:
        matrix = np.eye(3)
    elif np.linalg.norm(axis_a - axis_b) < NEARLY_ALONG:
        matrix = rotation(axis_a, degrees_a + share * (degrees_b - degrees_a))
    else:
        matrix = rotation(*_slerp(_quaternion(axis_a, degrees_a), _quaternion(axis_b, degrees_b), share))
    return mixed("translate", 0.0), matrix, mixed("scale", 1.0)


def matrix_at(animation, time):
    """Matrix (4, 4) of a mesh at a time in seconds. Raises: ValueError if the keys make no sense."""
    keys = animation["keys"]
    if any(a["time"] >= b["time"] for a, b in pairwise(keys)):
        raise ValueError("the times of its keys do not ascend")
    for key in keys:
        _turn(key)  # refuses all that is wrong, not only what is used now
    last = duration(animation)
    if animation.get("repeat") and last > 0.0:
        time %= last
    place = max(i for i, k in enumerate(keys) if i == 0 or k["time"] <= time)
    a, b = keys[place], keys[min(place + 1, len(keys) - 1)]
    share = 0.0
    if b is not a and time > a["time"]:
        share = (time - a["time"]) / (b["time"] - a["time"])
    if animation.get("interpolation") == "smooth":
        share = 0.5 - 0.5 * math.cos(math.pi * share)
    translation, turned, scale = _between(a, b, share)
    pivot = np.asarray(animation.get("pivot", (0.0, 0.0, 0.0)), dtype=np.float64)
    out = np.eye(4)
    out[:3, :3] = turned * scale
    out[:3, 3] = translation + pivot - out[:3, :3] @ pivot
    return out
