# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Cameras and lights: defaults of a scene, and those of the command line."""

import math

import numpy as np

from raycore.errors import OptionError
from raycore.scene.data import DEFAULT_FOV, Camera, Light


def _unit(v):
    return v / np.linalg.norm(v)


def default_camera(scene, aspect=5.0 / 3.0):
    """The file's own camera, or a view from the front, the right and above that just holds the scene's box."""
    if scene.camera is not None:
        return scene.camera
    lo, hi = scene.bounds
    centre = (lo + hi) / 2.0
    up = np.asarray(scene.up, dtype=np.float64)
    front = np.array([0.0, 0.0, 1.0]) if up[1] else np.array([0.0, -1.0, 0.0])
    back = _unit(front + 0.55 * np.cross(up, front) + 0.5 * up)  # from the target to the eye
    right = _unit(np.cross(up, back))
    top = np.cross(back, right)
    tan_y = math.tan(math.radians(DEFAULT_FOV) / 2.0) / 1.06  # a margin of 6 %
    corners = np.array([[x, y, z] for x in (lo[0], hi[0]) for y in (lo[1], hi[1]) for z in (lo[2], hi[2])]) - centre
    near = corners @ back
    distance = max(
        (near + np.abs(corners @ top) / tan_y).max(), (near + np.abs(corners @ right) / (tan_y * aspect)).max()
    )
    return Camera(tuple(map(float, centre + distance * back)), tuple(map(float, centre)), scene.up, DEFAULT_FOV)


def default_lights(scene, camera=None):
    """The file's own lights, or one point light above the camera's right shoulder."""
    if scene.lights:
        return scene.lights
    camera = camera or default_camera(scene)
    eye, target, up = (np.asarray(v, dtype=np.float64) for v in (camera.eye, camera.target, camera.up))
    lo, hi = scene.bounds
    size = np.linalg.norm(hi - lo)
    back = _unit(eye - target)
    right = _unit(np.cross(up, back))
    inside = np.all((eye > lo) & (eye < hi))
    if inside:  # a room: a lamp near the eye, below the ceiling
        head = max(float((hi - eye) @ np.asarray(scene.up)), 0.0)
        return [Light(tuple(map(float, eye + 0.5 * head * np.asarray(scene.up))))]
    place = eye + size * (0.35 * right + 0.55 * _unit(np.cross(back, right)))
    return [Light(tuple(map(float, place)))]


def _numbers(text, count, what):
    parts = text.split(",")
    try:
        values = tuple(float(p) for p in parts)
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        raise OptionError(f"{what}: '{text}' is not {count} finite numbers separated by commas")
    return values


def parse_camera(text):
    """`ex,ey,ez:tx,ty,tz:ux,uy,uz:fov_degrees`, the last two optional, to a `Camera`. Raises: OptionError."""
    parts = text.split(":")
    if not 2 <= len(parts) <= 4:
        raise OptionError(f"camera '{text}': expected ex,ey,ez:tx,ty,tz:ux,uy,uz:fov_degrees")
    eye, target = _numbers(parts[0], 3, "camera eye"), _numbers(parts[1], 3, "camera target")
    up = _numbers(parts[2], 3, "camera up") if len(parts) > 2 else (0.0, 1.0, 0.0)
    fov = _numbers(parts[3], 1, "camera field of view")[0] if len(parts) > 3 else DEFAULT_FOV
    if not 1.0 <= fov <= 170.0:
        raise OptionError(f"camera field of view {fov:g} is outside 1..170 degrees")
    view = np.subtract(target, eye)
    if not view.any():
        raise OptionError(f"camera '{text}': eye and target are the same point")
    side = np.cross(view / np.abs(view).max(), up)
    if not np.linalg.norm(side) > 1e-6 * np.linalg.norm(up):
        raise OptionError(f"camera '{text}': the up vector is zero or points along the view")
    return Camera(eye, target, up, fov)


def parse_light(text):
    """`x,y,z[:r,g,b]` to a point `Light` without attenuation. Raises OptionError."""
    parts = text.split(":")
    if not 1 <= len(parts) <= 2:
        raise OptionError(f"light '{text}': expected x,y,z or x,y,z:r,g,b")
    colour = _numbers(parts[1], 3, "light colour") if len(parts) > 1 else (1.0, 1.0, 1.0)
    if min(colour) < 0.0 or max(colour) > 1e6:
        raise OptionError(f"light colour {parts[1]}: expected values from 0 to 1000000")
    return Light(_numbers(parts[0], 3, "light position"), colour)
