# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A whole frame: bit for bit as the hardware computes it, and the same picture in double precision.

`render_fp24` reads the memory image and the registers, nothing else, and runs each pixel through the models of the units
in the order of docs/seams.md. `render_double` takes the same view and the same shading formulas, but the mesh, the camera
and the materials before they were rounded, and finds its hits in a structure of its own (`bvh`).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from raycore.image import (
    camera_arguments,
    light_table,
    material_table,
    read_info,
    read_lights,
    read_materials,
    region_words,
    register_vector,
)

from . import bvh, pixbuf, rgen, shade, tracer
from .tracer import TRI_NONE

NOT_TRACED, CULLED, LIT, SHADOWED = range(4)  # what became of a pixel's light
SHADOW_T_MIN = 1e-9  # of the double picture

_primary_direction, _inverse, _trace = rgen.primary_direction, rgen.inverse, tracer.trace_ray
_hit24, _light24, _add24 = shade.FP24.hit_point, shade.FP24.light_job, shade.FP24.add_k
_hit64, _light64, _add64 = shade.DOUBLE.hit_point, shade.DOUBLE.light_job, shade.DOUBLE.add_k
_trace64, _coincident = bvh.trace_ray, bvh.coincident


@dataclass
class Frame:
    """A rendered frame. Distances are in the unit box; float64 values of `render_fp24` are FP24 numbers."""

    rgb: np.ndarray  # (H, W, 3) float64, not clamped
    pixels: np.ndarray  # (H, W) uint32, as in the frame buffer
    tri: np.ndarray  # (H, W) int64, -1 where missed
    t: np.ndarray  # (H, W) float64; where missed: tracer.HUGE
    beta: np.ndarray  # (H, W)
    gamma: np.ndarray  # (H, W)
    light: np.ndarray  # (L, H, W) uint8: NOT_TRACED, CULLED, LIT or SHADOWED; LIT without a ray if shadows are off
    shadow_tri: np.ndarray  # (L, H, W) int64, what the shadow ray hit, -1: nothing
    shadow_hit: np.ndarray  # (L, H, W, 3) float64: its t, beta, gamma
    org: np.ndarray  # (3,) origin of the primary rays
    dir: np.ndarray  # (H, W, 3) their directions
    slots: np.ndarray  # (4,) int64 by tracer.BOX, TRAV1, TRAV2, ISECT; zero in double precision
    shadows: bool

    @property
    def rays(self):
        """Rays by type: {"primary", "shadow", "culled"}."""
        traced = int(np.count_nonzero(self.light >= LIT)) if self.shadows else 0
        return {"primary": self.tri.size, "shadow": traced, "culled": int(np.count_nonzero(self.light == CULLED))}


@njit(parallel=True, cache=True, error_model="numpy")
def _render24(
    tree,
    org,
    c,
    u,
    v,
    info,
    mat,
    materials,
    lights,
    background,
    shadows,
    rgb,
    tri,
    hit,
    light,
    shadow_tri,
    shadow_hit,
    dirs,
):
    height, width = tri.shape
    slots = np.zeros((height, 4), np.int64)
    o = (org[0], org[1], org[2])
    for y in prange(height):
        inv = np.empty(3)
        s_org, s_dir = np.empty(3), np.empty(3)
        for x in range(width):
            _primary_direction(c, u, v, x, y, dirs[y, x])
            for i in range(3):
                inv[i] = _inverse(dirs[y, x, i])
            found, t, beta, gamma = _trace(tree, org, dirs[y, x], inv, tracer.HUGE, TRI_NONE, False, slots[y])
            hit[y, x, 0], hit[y, x, 1], hit[y, x, 2] = t, beta, gamma
            if found == TRI_NONE:
                tri[y, x] = -1
                rgb[y, x] = background
                continue
            tri[y, x] = found
            d = (dirs[y, x, 0], dirs[y, x, 1], dirs[y, x, 2])
            p, g, m, md = _hit24(o, d, t, beta, gamma, info[found])
            material = materials[mat[found]]
            acc = (material[0], material[1], material[2])
            for l in range(lights.shape[0]):
                culled, to, t_max, k = _light24((p, g, m, d, md), lights[l], material)
                if culled:
                    light[l, y, x] = CULLED
                    continue
                light[l, y, x] = LIT
                if shadows:
                    for i in range(3):
                        s_org[i], s_dir[i], inv[i] = p[i], to[i], _inverse(to[i])
                    blocker, t, beta, gamma = _trace(tree, s_org, s_dir, inv, t_max, found, True, slots[y])
                    if blocker != TRI_NONE:
                        light[l, y, x] = SHADOWED
                        shadow_tri[l, y, x] = blocker
                        shadow_hit[l, y, x, 0], shadow_hit[l, y, x, 1], shadow_hit[l, y, x, 2] = t, beta, gamma
                        continue
                acc = _add24(acc, k)
            rgb[y, x, 0], rgb[y, x, 1], rgb[y, x, 2] = acc
    return slots


@njit(parallel=True, cache=True, error_model="numpy")
def _render64(
    mesh,
    triangles,
    wanted,
    org,
    info,
    mat,
    materials,
    lights,
    background,
    shadows,
    rgb,
    tri,
    hit,
    light,
    shadow_tri,
    shadow_hit,
    dirs,
):
    height, width = tri.shape
    o = (org[0], org[1], org[2])
    for y in prange(height):
        for x in range(width):
            d = (dirs[y, x, 0], dirs[y, x, 1], dirs[y, x, 2])
            found, t, beta, gamma = _trace64(mesh, o, d, tracer.T_MIN, tracer.HUGE, -1, False)
            found, t, beta, gamma = _coincident(triangles, wanted[y, x], o, d, found, t, beta, gamma)
            hit[y, x, 0], hit[y, x, 1], hit[y, x, 2] = t, beta, gamma
            tri[y, x] = found
            if found < 0:
                rgb[y, x] = background
                continue
            p, g, m, md = _hit64(o, d, t, beta, gamma, info[found])
            material = materials[mat[found]]
            acc = (material[0], material[1], material[2])
            for l in range(lights.shape[0]):
                culled, to, t_max, k = _light64((p, g, m, d, md), lights[l], material)
                if culled:
                    light[l, y, x] = CULLED
                    continue
                light[l, y, x] = LIT
                if shadows:
                    blocker, t, beta, gamma = _trace64(mesh, p, to, SHADOW_T_MIN, t_max, found, True)
                    if blocker >= 0:
                        light[l, y, x] = SHADOWED
                        shadow_tri[l, y, x] = blocker
                        shadow_hit[l, y, x, 0], shadow_hit[l, y, x, 1], shadow_hit[l, y, x, 2] = t, beta, gamma
                        continue
                acc = _add64(acc, k)
            rgb[y, x, 0], rgb[y, x, 1], rgb[y, x, 2] = acc


def _buffers(view, lights):
    h, w, n = view.height, view.width, lights
    return {
        "rgb": np.zeros((h, w, 3)),
        "tri": np.empty((h, w), np.int64),
        "hit": np.empty((h, w, 3)),
        "light": np.zeros((n, h, w), np.uint8),
        "shadow_tri": np.full((n, h, w), -1, np.int64),
        "shadow_hit": np.zeros((n, h, w, 3)),
    }


def _frame(view, out, org, dirs, slots):
    hit = out.pop("hit")
    return Frame(
        pixels=pixbuf.pack(out["rgb"], view.fb_format),
        t=hit[..., 0],
        beta=hit[..., 1],
        gamma=hit[..., 2],
        org=org,
        dir=dirs,
        slots=slots,
        shadows=view.shadows,
        **out,
    )


def decode_tree(image):
    """What `tracer` reads, from the memory image."""
    r = image.registers
    low, high = image.regions["lists"][0], image.regions["lists"][0] + 4 * r["LIST_COUNT"]
    box = np.stack((register_vector(image, "BOX_LO_"), register_vector(image, "BOX_HI_")))
    return tracer.decode(
        region_words(image, "nodes", r["NODE_COUNT"], 1)[:, 0],
        image.memory[low:high].view("<u4"),
        region_words(image, "triaccel", r["TRI_COUNT"], 4),
        box,
        r["NODE_ROOT"],
    )


def render_fp24(image):
    """The frame as the hardware renders it, bit for bit.

    Args: `image.Image`; it must be sound, for the model does not check indices.
    Returns: `Frame`.
    """
    lights = read_lights(image)
    info, mat = read_info(image)
    camera = rgen.Camera(*(register_vector(image, f"CAM_{n.upper()}_") for n in rgen.Camera._fields))
    out = _buffers(image.view, len(lights))
    dirs = np.empty((image.view.height, image.view.width, 3))
    background = register_vector(image, "BACKGROUND_", "RGB")
    slots = _render24(
        *(decode_tree(image), camera.org, camera.c, camera.u, camera.v, info, mat, read_materials(image), lights),
        *(background, image.view.shadows, *out.values(), dirs),
    )
    return _frame(image.view, out, camera.org, dirs, slots.sum(axis=0))


def _info64(triangles, normals):
    """Triangle information (N, 5, 3), not rounded."""
    a, e1, e2 = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    cross = np.cross(e1, e2)
    scale = np.abs(cross).max(axis=1, keepdims=True)
    cross = np.divide(cross, scale, out=np.zeros_like(cross), where=scale > 0.0)
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    normal = np.divide(cross, length, out=np.zeros_like(cross), where=length > 0.0)
    n0, n1, n2 = normals[:, 0], normals[:, 1], normals[:, 2]
    return np.stack((a, normal, n0, n1 - n0, n2 - n0), axis=1)


def render_double(image, wanted=None):
    """The same view in double precision: mesh, camera, lights and materials as loaded, in the unit box.

    Args: image; wanted (H, W) int64: triangle to take where several coincide (`bvh.coincident`), -1 or None: any.
    Returns: `Frame`.
    """
    scene, unit, view = image.geometry.scene, image.geometry.unit, image.view
    triangles = np.ascontiguousarray(unit.to_unit(scene.triangles))
    lights = light_table(view.lights, unit)
    camera = rgen.camera_vectors(*camera_arguments(view.camera, unit, view.width, view.height))
    dirs, _ = rgen.primary_rays_double(camera, view.width, view.height)
    out = _buffers(view, len(lights))
    wanted = np.full(out["tri"].shape, -1, np.int64) if wanted is None else wanted
    _render64(
        *(bvh.build(triangles), triangles, wanted, camera.org),
        *(_info64(triangles, scene.normals), scene.face_material.astype(np.int64)),
        *(material_table(scene.materials), lights, np.asarray(scene.background, np.float64), view.shadows),
        *(*out.values(), dirs),
    )
    return _frame(view, out, camera.org, dirs, np.zeros(4, np.int64))
