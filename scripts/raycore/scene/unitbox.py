# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A scene in the coordinates of the hardware: centred, scaled by a power of two into [-1, 1], rounded to FP24."""

import math
from dataclasses import dataclass

import numpy as np

from raycore.errors import SceneError
from raycore.model import fp24


@dataclass
class Normalised:
    """A scene in [-1, 1]: x = (world - centre) * 2^-scale_exp, rounded to FP24.

    triangles (N, 3, 3) and normals (N, 3, 3) float64 that hold FP24 numbers; dropped (N,) bool marks triangles that
    have no area after rounding (their indices stay reserved).
    """

    triangles: np.ndarray
    normals: np.ndarray
    dropped: np.ndarray
    centre: np.ndarray
    scale_exp: int

    def to_unit(self, points):
        """World points to the unit box, not rounded."""
        return (np.asarray(points, dtype=np.float64) - self.centre) * 2.0**-self.scale_exp

    def to_world(self, points):
        """Points of the unit box to world units."""
        return np.asarray(points, dtype=np.float64) * 2.0**self.scale_exp + self.centre

    def length_to_world(self, lengths):
        """Lengths, such as the distance of a hit, to world units."""
        return np.asarray(lengths, dtype=np.float64) * 2.0**self.scale_exp


def normalise(scene):
    """Centre a scene, scale it by a power of two into [-1, 1] and round its vertices to FP24.

    Shared vertices stay shared: they round to the same number in every triangle. Triangles of less than about 2^-17 of
    the scene lose their area here. Returns `Normalised`. Raises: SceneError if no triangle keeps an area.
    """
    lo, hi = scene.bounds
    centre = lo + (hi - lo) / 2.0
    half = np.maximum(hi - centre, centre - lo).max()
    mantissa, scale_exp = math.frexp(half)  # half = mantissa * 2^scale_exp, mantissa in [1/2, 1)
    if mantissa == 0.5:
        scale_exp -= 1
    rounded = fp24.round_to_fp24((scene.triangles - centre) * 2.0**-scale_exp) + 0.0
    cross = np.cross(rounded[:, 1] - rounded[:, 0], rounded[:, 2] - rounded[:, 0])
    dropped = ~cross.any(axis=1)
    if dropped.all():
        raise SceneError(
            f"{scene.name}: no triangle keeps an area in 24-bit coordinates; is there a stray vertex far away?"
        )
    return Normalised(rounded, fp24.round_to_fp24(scene.normals), dropped, centre, scale_exp)
