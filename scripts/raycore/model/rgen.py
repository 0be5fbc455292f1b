# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Ray generation (paper Sec. 3.3): the camera's registers, and every primary ray bit for bit as `rtl/rgen/` makes it.

A pixel (x, y), row 0 on top, looks along v = c + (x + 1/2) u + (y + 1/2) v; the unit normalises it. The order of
operations is that of docs/seams.md. FP24 values are float64 that hold them exactly, see `raycore.model.fp24`.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from raycore.errors import OptionError

from . import fp24
from .fp24 import fadd3, fdiv, fmul, fsqrt

HUGE = 2.0**62  # 1/0


class Camera(NamedTuple):
    """What the camera's registers hold, as in `camera_t`: four (3,) float64 vectors."""

    org: np.ndarray  # eye
    c: np.ndarray  # direction to the upper left corner of the picture, not of unit length
    u: np.ndarray  # from one pixel to its right neighbour
    v: np.ndarray  # from one pixel to the one below


def camera_vectors(eye, target, up, fov_deg, width, height):
    """The camera in double precision: square pixels, the picture's height seen under `fov_deg`.

    Args: eye, target, up: (3,) in the scene's units, `up` of any length; fov_deg: vertical, between 0 and 180;
        width, height: pixels.
    Returns: `Camera`, not rounded. The axis from eye to target has length 1.
    Raises: OptionError if the view is not defined.
    """
    eye, target, up = (np.asarray(p, dtype=np.float64) for p in (eye, target, up))
    if not all(np.all(np.isfinite(p)) for p in (eye, target, up)):
        raise OptionError("camera: every coordinate must be a finite number")
    if not 0.0 < fov_deg < 180.0:
        raise OptionError(f"camera: field of view {fov_deg:g} is not between 0 and 180 degrees")
    if not (1 <= width <= 65535 and 1 <= height <= 65535):
        raise OptionError(f"camera: picture size {width}x{height} is not between 1x1 and 65535x65535")
    axis = target - eye
    length = np.linalg.norm(axis)
    if length == 0.0:
        raise OptionError("camera: eye and target are the same point")
    axis = axis / length
    up_length = np.linalg.norm(up)
    right = np.cross(axis, up / up_length) if up_length > 0.0 else np.zeros(3)
    side = np.linalg.norm(right)
    if side < 1e-9:
        raise OptionError("camera: the up vector is zero or parallel to the line of sight")
    right = right / side
    above = np.cross(right, axis)
    pixel = 2.0 * math.tan(math.radians(fov_deg) / 2.0) / height
    u, v = right * pixel, -above * pixel
    return Camera(eye, axis - u * (width / 2.0) - v * (height / 2.0), u, v)


def camera_registers(eye, target, up, fov_deg, width, height):
    """`camera_vectors` rounded once to FP24: the registers. Same arguments and errors."""
    return Camera(*(fp24.round_to_fp24(p) for p in camera_vectors(eye, target, up, fov_deg, width, height)))


@njit(cache=True, error_model="numpy")
def inverse(d):
    """1/d as rays carry it (docs/seams.md): 1/0 is 2^62 with the sign of the zero, and nothing is larger."""
    if d == 0.0:
        return math.copysign(HUGE, d)
    r = fdiv(1.0, d)
    return math.copysign(HUGE, r) if abs(r) > HUGE else r


@njit(cache=True, error_model="numpy")
def primary_direction(c, u, v, x, y, out):
    """Direction of the primary ray of pixel (x, y). c, u, v: (3,) FP24 values of the camera; out: (3,), the result."""
    px, py = x + 0.5, y + 0.5  # exact: 17 significant bits
    for i in range(3):
        out[i] = fadd3(c[i], fmul(px, u[i]), fmul(py, v[i]))
    len2 = fadd3(fmul(out[0], out[0]), fmul(out[1], out[1]), fmul(out[2], out[2]))
    inv = fdiv(1.0, fsqrt(len2))
    for i in range(3):
        out[i] = fmul(out[i], inv)


@njit(cache=True, error_model="numpy")
def _primary_rays(c, u, v, direction, inv_dir):
    for y in range(direction.shape[0]):
        for x in range(direction.shape[1]):
            primary_direction(c, u, v, x, y, direction[y, x])
            for i in range(3):
                inv_dir[y, x, i] = inverse(direction[y, x, i])


def primary_rays(camera, width, height):
    """Every primary ray of a picture, bit for bit.

    Args: camera: `Camera` of FP24 values; width, height: pixels.
    Returns: dir, inv_dir: (height, width, 3) float64 of FP24 values. The origin is `camera.org`. The length of a
        direction is 1 within 4.2 * 2^-17 (docs/raygen.md).
    """
    direction = np.empty((height, width, 3))
    inv_dir = np.empty_like(direction)
    _primary_rays(camera.c, camera.u, camera.v, direction, inv_dir)
    return direction, inv_dir


def primary_rays_double(camera, width, height):
    """The same rays in double precision, from `camera_vectors` (or from rounded registers, to see what those cost).

    Returns: dir, inv_dir: (height, width, 3) float64; 1/0 is +-2^62 here too.
    """
    px = (np.arange(width) + 0.5)[None, :, None]
    py = (np.arange(height) + 0.5)[:, None, None]
    direction = camera.c + px * camera.u + py * camera.v
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    small = np.abs(direction) < 1.0 / HUGE
    inv_dir = np.where(small, np.copysign(HUGE, direction), 1.0 / np.where(small, 1.0, direction))
    return direction, inv_dir
