# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A die of `dice.json`: round the origin, one unit a side, its pips a picture."""

import numpy as np

from raycore.patterns import mix, to_image
from raycore.shapes import Builder, rounded_box

CELL = 64  # texels a side of a face
IVORY, BLACK = (0.93, 0.90, 0.80), (0.06, 0.05, 0.05)
PIPS = (  # in quarters of a face; opposite faces, one after the other, have seven together
    ((0, 0),),
    ((-1, -1), (1, 1), (-1, 0), (1, 0), (-1, 1), (1, -1)),
    ((-1, -1), (1, 1)),
    ((0, 0), (-1, -1), (1, 1), (-1, 1), (1, -1)),
    ((0, 0), (-1, 1), (1, -1)),
    ((-1, -1), (1, 1), (-1, 1), (1, -1)),
)
ACROSS = ((2, 1), (0, 2), (0, 1))  # axes of u and v on the faces of x, y, z


def _picture():
    """Six faces side by side in a picture of eight."""
    v, u = (np.indices((CELL, CELL)) + 0.5) / CELL - 0.5
    faces = []
    for pips in PIPS:
        away = np.min([np.hypot(u - 0.25 * x, v - 0.25 * y) for x, y in pips], axis=0)
        faces.append(mix(IVORY, BLACK, np.clip(0.5 + (0.085 - away) * CELL, 0.0, 1.0)))
    blank = mix(IVORY, BLACK, np.zeros((CELL, 2 * CELL)))
    return to_image(np.concatenate((*faces, blank), axis=1))


def _faces(triangles):
    """Texture coordinates of the face that a triangle looks along most."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    face = 2 * axis + (np.take_along_axis(normal, axis[:, None], 1)[:, 0] > 0.0)
    along = np.array(ACROSS)[axis]
    uv = np.stack([np.take_along_axis(triangles, along[:, None, i, None], 2)[:, :, 0] for i in range(2)], axis=2)
    return (uv + 0.5 + np.stack((face, 0 * face), axis=1)[:, None]) / (8.0, 1.0)


def build():
    b = Builder("die")
    b.varnish("ivory", _picture(), shine=0.4, sharpness=80.0, wrap="clamp")
    b.add(rounded_box((1.0, 1.0, 1.0), 0.12, 5), "ivory", 40.0, _faces)
    return b.scene()
