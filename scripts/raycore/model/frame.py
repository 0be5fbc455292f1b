# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A whole frame: bit for bit as the hardware computes it, and the same picture in double precision.

Both run each pixel's tree of rays through the models of the units in the order of docs/whitted.md; `_trace_row` is that
order, written once. `render_fp24` reads the memory image and the registers, nothing else, and names triangles as the scene
does. `render_double` takes the same view,
but mesh, camera, lights, materials and texture coordinates before they were rounded, and finds its hits in a structure of its
own (`bvh`); texels and the levels of triangles are the image's.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numba.extending import overload

from raycore import regs
from raycore.image import (
    INSTANCE_WORDS,
    camera_arguments,
    light_table,
    material_table,
    read_info,
    read_lights,
    read_materials,
    read_optics_textures,
    read_uv,
    region_words,
    register_vector,
)

from . import bvh, fp24, pixbuf, rgen, shade, texture, tracer

PRIMARY, SHADOW, REFLECT, TRANSMIT = range(4)  # kinds of rays, ray_kind_e
KINDS = ("primary", "shadow", "reflect", "transmit")
DEPTHS = 16
STACK = 16  # rays that a pixel may put aside
NOT_TRACED, CULLED, LIT, SHADOWED = range(4)  # what became of a light of a primary hit

# One ray. t, beta, gamma: in `render_fp24` they are FP24 numbers, which 32 bits hold exactly; where nothing was hit they and
# tri (-1) mean nothing. depth: bounces before the ray, of a shadow ray before its surface. light: of a shadow ray, else 0.
# inst: placed object that the triangle is in, whose number is then that of its record, shared by objects; `Frame.log_tri`.
RAY = np.dtype(
    [("kind", "u1"), ("light", "u1"), ("hit", "u1"), ("depth", "u1"), ("tri", "i4"), ("inst", "u2")]
    + [(name, "f4") for name in ("t", "beta", "gamma")]
)


@dataclass
class Frame:
    """A rendered frame. Distances are in the unit box; float64 values of `render_fp24` are FP24 numbers.

    tri to gamma, org and dir are those of the primary rays, light of their hits. tri is a triangle of the scene; in_scene, of
    `image.Geometry`, leads to it from the numbers of `log`.
    """

    rgb: np.ndarray  # (H, W, 3) float64, not clamped
    pixels: np.ndarray  # (H, W) uint32, as in the frame buffer
    tri: np.ndarray  # (H, W) int64, -1 where missed
    t: np.ndarray  # (H, W) float64; where missed: tracer.HUGE
    beta: np.ndarray  # (H, W)
    gamma: np.ndarray  # (H, W)
    light: np.ndarray  # (L, H, W) uint8: NOT_TRACED, CULLED, LIT (perhaps through something) or SHADOWED
    org: np.ndarray  # (3,)
    dir: np.ndarray  # (H, W, 3)
    log: np.ndarray  # (rays,) RAY: pixels row by row, in each its rays in the order in which they are issued
    start: np.ndarray  # (H * W + 1,) int64: where each pixel's rays begin in `log`
    by_depth: np.ndarray  # (4, 16) int64: rays by kind and depth
    culled: int  # lights behind their surface, which no ray was made for
    slots: np.ndarray  # (4,) int64 by tracer.BOX, TRAV1, TRAV2, ISECT; zero in double precision
    work: np.ndarray  # (H, W, 2) int64 of each pixel's rays: slots, and those with two traversal steps
    in_scene: Callable

    @property
    def log_tri(self):
        """Triangles of the scene that the rays of `log` hit: (rays,) int64, -1: none."""
        return self.in_scene(self.log["tri"].astype(np.int64), self.log["inst"])

    @property
    def rays(self):
        """Rays by type: {"primary", "shadow", "reflect", "transmit", "culled"}, the last not traced."""
        return {**dict(zip(KINDS, map(int, self.by_depth.sum(axis=1)))), "culled": self.culled}

    def pixel_rays(self, x, y):
        """The rays of a pixel, in order: (rays,) RAY."""
        pixel = y * self.tri.shape[1] + x
        return self.log[self.start[pixel] : self.start[pixel + 1]]


class Setup(NamedTuple):
    """What the rays of a frame meet; numbers as in registers, columns as in `raycore.image`."""

    org: np.ndarray  # (3,)
    info: np.ndarray  # (N, 5, 3)
    uv: np.ndarray  # (N, 7), or empty if nothing is textured
    materials: np.ndarray  # (M, 29)
    textures: np.ndarray  # (M, 10) int64
    texels: np.ndarray  # (bytes,) uint8
    lights: np.ndarray  # (L, 10)
    background: np.ndarray  # (3,)
    shadows: bool
    trilinear: bool
    mip_bias: int
    max_depth: int
    min_weight: float
    t_min: float  # of rays that leave from a triangle
    corners: np.ndarray  # double precision: the triangles (N, 3, 3), for `bvh.coincident`; else empty


# ---- the two kinds of arithmetic, told apart by the type of the structure that holds the triangles ---------------------------


def _twin(single, double):
    """A function f(tree, *args) for compiled code that calls single or double."""

    def f(tree, *args):
        raise NotImplementedError("only for compiled code")

    @overload(f)
    def choose(tree, *args):
        chosen = single if tree.instance_class is tracer.TreeArrays else double
        return lambda tree, *args: chosen(*args)

    return f


_place24 = shade.FP24.place


@njit(cache=True, error_model="numpy")
def _info24(placed, info, inst):
    return _place24(info, placed[inst]) if inst != tracer.NOT_PLACED else info


def _info(tree, info, inst):
    """Triangle information in the scene's coordinates, of a triangle in placed object inst."""
    raise NotImplementedError("only for compiled code")


@overload(_info)
def _choose_info(tree, info, inst):
    if tree.instance_class is tracer.TreeArrays:
        return lambda tree, info, inst: _info24(tree.inst_place, info, inst)
    return lambda tree, info, inst: info  # which has all triangles in the scene's coordinates


_hit_point = _twin(shade.FP24.hit_point, shade.DOUBLE.hit_point)
_coverage = _twin(shade.FP24.coverage, shade.DOUBLE.coverage)
_weight = _twin(shade.FP24.weight, shade.DOUBLE.weight)
_light_job = _twin(shade.FP24.light_job, shade.DOUBLE.light_job)
_shadow_through = _twin(shade.FP24.shadow_through, shade.DOUBLE.shadow_through)
_bounce = _twin(shade.FP24.bounce, shade.DOUBLE.bounce)
_add_miss = _twin(shade.FP24.add_miss, shade.DOUBLE.add_miss)
_add_surface = _twin(shade.FP24.add_surface, shade.DOUBLE.add_surface)
_add_light = _twin(shade.FP24.add_light, shade.DOUBLE.add_light)
_longer = _twin(shade.FP24.longer, shade.DOUBLE.longer)
_sample = _twin(texture.sample24, texture.sample64)


@njit(cache=True, error_model="numpy")
def _trace24(tree, org, d, t_min, t_max, skip, skip_inst, any_hit, slots):
    o, v, inv = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        o[i], v[i], inv[i] = org[i], d[i], rgen.inverse(d[i])
    skipped = tracer.TRI_NONE if skip < 0 else skip
    tri, t, beta, gamma, mat, opaque, inst = tracer.trace_ray(
        tree, o, v, inv, t_min, t_max, skipped, skip_inst, any_hit, slots
    )
    return (-1 if tri == tracer.TRI_NONE else tri), t, beta, gamma, mat, opaque, inst


@njit(cache=True, error_model="numpy")
def _trace64(tree, org, d, t_min, t_max, skip, skip_inst, any_hit, slots):
    tri, t, beta, gamma = bvh.trace_ray(tree, org, d, t_min, t_max, skip, any_hit)
    if tri < 0:
        return tri, t, beta, gamma, np.int64(0), False, np.int64(tracer.NOT_PLACED)
    return tri, t, beta, gamma, tree.mat[tri], tree.opaque[tri], np.int64(tracer.NOT_PLACED)


def _trace(tree, org, d, t_min, t_max, skip, skip_inst, any_hit, slots):
    """(triangle or -1, t, beta, gamma, mat, opaque, placed object) of one ray, vectors as tuples."""
    raise NotImplementedError("only for compiled code")


@overload(_trace)
def _choose_trace(tree, org, d, t_min, t_max, skip, skip_inst, any_hit, slots):
    chosen = _trace24 if tree.instance_class is tracer.TreeArrays else _trace64
    return lambda tree, org, d, t_min, t_max, skip, skip_inst, any_hit, slots: chosen(
        tree, org, d, t_min, t_max, skip, skip_inst, any_hit, slots
    )


def _settle(tree, corners, wanted, org, d, found, t, beta, gamma, mat):
    """(triangle, t, beta, gamma, mat) of a hit, on triangle `wanted` if double precision hits that at the same distance."""
    raise NotImplementedError("only for compiled code")


@njit(cache=True, error_model="numpy")
def _settle64(tree, corners, wanted, org, d, found, t, beta, gamma, mat):
    found, t, beta, gamma = bvh.coincident(corners, wanted, org, d, found, t, beta, gamma)
    return found, t, beta, gamma, (tree.mat[found] if found >= 0 else mat)


@overload(_settle)
def _choose_settle(tree, corners, wanted, org, d, found, t, beta, gamma, mat):
    if tree.instance_class is tracer.TreeArrays:
        return lambda tree, corners, wanted, org, d, found, t, beta, gamma, mat: (found, t, beta, gamma, mat)
    return lambda tree, corners, wanted, org, d, found, t, beta, gamma, mat: _settle64(
        tree, corners, wanted, org, d, found, t, beta, gamma, mat
    )


# ---- one row of pixels ---------------------------------------------------------------------------------------------------


@njit(cache=True)
def _logged(log, n, kind, light, depth, tri, inst, t, beta, gamma):
    """log with one more ray at n: the same array, or a longer one."""
    if n == log.size:
        longer = np.empty(2 * n, log.dtype)
        longer[:n] = log
        log = longer
    log[n]["kind"], log[n]["light"], log[n]["hit"], log[n]["depth"] = kind, light, tri >= 0, depth
    log[n]["tri"], log[n]["inst"], log[n]["t"], log[n]["beta"], log[n]["gamma"] = tri, inst, t, beta, gamma
    return log


@njit(cache=True, error_model="numpy")
def _texture(tree, s, tri, mat, beta, gamma, length):
    """(colour, alpha) of the texture at a hit; length: of the path up to there."""
    if s.materials[mat, shade.TEXTURED] == 0.0:
        return (1.0, 1.0, 1.0), 1.0
    r, g, b, a = _sample(tree, s.texels, s.textures[mat], s.uv[tri], beta, gamma, length, s.mip_bias, s.trilinear)
    return (r, g, b), a


@njit(cache=True, nogil=True, error_model="numpy")
def _trace_row(tree, s, dirs, wanted, log, rgb, tri, hit, light, start, by_depth, slots, work):
    """The pixels of one row: docs/whitted.md, step by step.

    Args: structure with the triangles, `Setup`, dirs (W, 3) of primary rays, wanted (W,): see `_settle`, log: empty records
    to use. Written are rgb
    (W, 3), tri (W,), hit (W, 3): t, beta, gamma, light (L, W), start (W,): rays of the row before each pixel, work (W, 2);
    by_depth and slots are added to. Returns: (records, how many of them, culled lights).
    """
    n, culled_count = 0, 0
    stack = np.empty((STACK, 10))  # direction, origin, weight, length
    stack_depth, stack_skip = np.empty(STACK, np.int64), np.empty((STACK, 2), np.int64)
    background = (s.background[0], s.background[1], s.background[2])
    for x in range(dirs.shape[0]):
        start[x] = n
        work[x, 0], work[x, 1] = -slots.sum(), -slots[tracer.TRAV2]
        acc = (0.0, 0.0, 0.0)
        sp = 0
        # the ray to trace next
        kind, depth, skip, skip_inst, t_min = PRIMARY, 0, -1, tracer.NOT_PLACED, tracer.T_MIN
        org, d = (s.org[0], s.org[1], s.org[2]), (dirs[x, 0], dirs[x, 1], dirs[x, 2])
        w, length = (1.0, 1.0, 1.0), 0.0
        while True:
            found, t, beta, gamma, mat, _, inst = _trace(
                tree, org, d, t_min, tracer.HUGE, skip, skip_inst, False, slots
            )
            if kind == PRIMARY:
                found, t, beta, gamma, mat = _settle(tree, s.corners, wanted[x], org, d, found, t, beta, gamma, mat)
            log = _logged(log, n, kind, 0, depth, found, inst, t, beta, gamma)
            n += 1
            by_depth[kind, depth] += 1
            if kind == PRIMARY:
                tri[x], hit[x, 0], hit[x, 1], hit[x, 2] = found, t, beta, gamma
            goes_on = False
            if found < 0:
                acc = _add_miss(tree, acc, w, background)
            else:
                # surface
                material = s.materials[mat]
                tex, ta = _texture(tree, s, found, mat, beta, gamma, _longer(tree, length, t))
                info = _info(tree, s.info[found], inst)
                p, g, m, md, length, inside = _hit_point(tree, org, d, t, beta, gamma, info, length)
                ctx = (p, g, m, d, md)
                alpha = _coverage(tree, ta, material)
                wl = _weight(tree, alpha, w)
                acc = _add_surface(tree, acc, wl, tex, material)
                # lights
                for l in range(s.lights.shape[0]):
                    culled, to, from_t, t_max, k = _light_job(tree, ctx, s.lights[l], material, tex, s.t_min)
                    tr = (1.0, 1.0, 1.0)
                    blocked = culled
                    traced = s.shadows and not culled
                    while traced:
                        at, t, beta, gamma, mat2, opaque, at_inst = _trace(
                            tree, p, to, from_t, t_max, found, inst, True, slots
                        )
                        log = _logged(log, n, SHADOW, l, depth, at, at_inst, t, beta, gamma)
                        n += 1
                        by_depth[SHADOW, depth] += 1
                        traced = at >= 0 and not opaque
                        blocked = at >= 0 and opaque
                        if traced:
                            behind = s.materials[mat2]
                            tex2, ta2 = _texture(tree, s, at, mat2, beta, gamma, _longer(tree, length, t))
                            blocked, tr, from_t = _shadow_through(tree, tr, t, tex2, ta2, behind, s.min_weight)
                            traced = not blocked
                    if not blocked:
                        acc = _add_light(tree, acc, wl, tr, k)
                    culled_count += culled
                    if depth == 0:
                        light[l, x] = CULLED if culled else SHADOWED if blocked else LIT
                # bounce
                goes = material[shade.REFLECTS] != 0.0 or not shade.opaque(material)
                if depth < s.max_depth and goes:
                    one, two = _bounce(tree, ctx, tex, w, alpha, inside, material, s.min_weight)
                    depth, skip, skip_inst, t_min = depth + 1, found, inst, s.t_min
                    if one[0] and two[0]:
                        if sp == STACK:
                            raise ValueError("a pixel put too many rays aside")
                        for i in range(3):
                            stack[sp, i], stack[sp, 3 + i], stack[sp, 6 + i] = two[2][i], two[3][i], two[1][i]
                        stack[sp, 9], stack_depth[sp], stack_skip[sp, 0], stack_skip[sp, 1] = length, depth, skip, skip_inst
                        sp += 1
                    goes_on = one[0] or two[0]
                    if goes_on:
                        kind = REFLECT if one[0] else TRANSMIT
                        _, w, d, org = one if one[0] else two
            if not goes_on:
                if sp == 0:
                    break
                sp -= 1
                kind = TRANSMIT
                d, org = (stack[sp, 0], stack[sp, 1], stack[sp, 2]), (stack[sp, 3], stack[sp, 4], stack[sp, 5])
                w, length = (stack[sp, 6], stack[sp, 7], stack[sp, 8]), stack[sp, 9]
                depth, skip, skip_inst, t_min = stack_depth[sp], stack_skip[sp, 0], stack_skip[sp, 1], s.t_min
        rgb[x, 0], rgb[x, 1], rgb[x, 2] = acc
        work[x, 0] += slots.sum()
        work[x, 1] += slots[tracer.TRAV2]
    return log, n, culled_count


# ---- frames --------------------------------------------------------------------------------------------------------------


def _render(view, setup, tree, dirs, in_scene, wanted=None):
    h, w = dirs.shape[:2]
    wanted = np.full((h, w), -1, np.int64) if wanted is None else wanted
    out = {
        "rgb": np.zeros((h, w, 3)),
        "tri": np.empty((h, w), np.int64),
        "hit": np.empty((h, w, 3)),
        "light": np.zeros((h, len(setup.lights), w), np.uint8),
        "start": np.empty((h, w), np.int64),
        "by_depth": np.zeros((h, len(KINDS), DEPTHS), np.int64),
        "slots": np.zeros((h, 4), np.int64),
        "work": np.empty((h, w, 2), np.int64),
    }

    def row(y):
        log, n, culled = _trace_row(tree, setup, dirs[y], wanted[y], np.empty(4 * w, RAY), *(p[y] for p in out.values()))
        return log[:n].copy(), culled

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = list(pool.map(row, range(h)))
    before = np.cumsum([0, *(log.size for log, _ in rows)])
    start = np.append((out.pop("start") + before[:-1, None]).reshape(-1), before[-1])
    hit, log = out.pop("hit"), np.concatenate([log for log, _ in rows])
    return Frame(
        rgb=out["rgb"],
        pixels=pixbuf.pack(out["rgb"], view.fb_format),
        tri=in_scene(out["tri"], log["inst"][start[:-1]].reshape(h, w)),
        t=hit[..., 0],
        beta=hit[..., 1],
        gamma=hit[..., 2],
        light=np.ascontiguousarray(out["light"].transpose(1, 0, 2)),
        org=setup.org,
        dir=dirs,
        log=log,
        start=start,
        by_depth=out["by_depth"].sum(axis=0),
        culled=sum(int(culled) for _, culled in rows),
        slots=out["slots"].sum(axis=0),
        work=out["work"],
        in_scene=in_scene,
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
        region_words(image, "instances", r["INST_COUNT"], INSTANCE_WORDS) if r.get("INST_COUNT") else (),
    )


def _registers(image):
    """What both twins take from the registers and the textures: fields of `Setup`."""
    r = image.registers
    options = regs.unpack("OPTIONS", r["OPTIONS"])
    bias = r["MIP_BIAS"] & 0xFFF
    low = image.regions["textures"][0]
    return {
        "textures": read_optics_textures(image),
        "texels": image.memory[low : low + 64 * r["TEX_LINES"]],
        "shadows": bool(options["shadows"]),
        "trilinear": bool(options["trilinear"]),
        "mip_bias": bias - 4096 if bias >= 2048 else bias,
        "max_depth": int(r["MAX_DEPTH"]),
    }


def setup_fp24(image):
    """What the hardware is given, from memory image and registers: `Setup`, `tracer.TreeArrays`."""
    setup = Setup(
        org=register_vector(image, "CAM_ORG_"),
        info=read_info(image)[0],
        uv=read_uv(image),
        materials=read_materials(image),
        lights=read_lights(image),
        background=register_vector(image, "BACKGROUND_", "RGB"),
        min_weight=float(fp24.from_bits(np.array([image.registers["MIN_WEIGHT"]]))[0]),
        t_min=shade.T_MIN,
        corners=np.empty((0, 3, 3)),
        **_registers(image),
    )
    return setup, decode_tree(image)


def render_fp24(image):
    """The frame as the hardware renders it, bit for bit.

    Args: `image.Image`; it must be sound, for the model does not check indices.
    Returns: `Frame`.
    """
    camera = rgen.Camera(*(register_vector(image, f"CAM_{n.upper()}_") for n in rgen.Camera._fields))
    dirs, _ = rgen.primary_rays(camera, image.view.width, image.view.height)
    return _render(image.view, *setup_fp24(image), dirs, image.geometry.in_scene)


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


def _uv64(image):
    """Texture coordinates as loaded, with the levels of the image: (N, 7), or empty if nothing is textured."""
    records, uv = read_uv(image), image.geometry.scene.uv
    if not len(records):
        return records
    edges = (uv[:, 1:] - uv[:, :1]).reshape(-1, 4)
    return np.ascontiguousarray(np.concatenate((uv[:, 0], edges, records[image.geometry.rows, 6:]), axis=1))


def setup_double(image):
    """The same not rounded: mesh, lights and materials as loaded, in the unit box. Returns: `Setup`, `bvh.Bvh`."""
    scene, unit, view = image.geometry.scene, image.geometry.unit, image.view
    triangles = np.ascontiguousarray(unit.to_unit(scene.triangles))
    uv = _uv64(image)
    setup = Setup(
        org=unit.to_unit(np.asarray(view.camera.eye, np.float64)),
        info=_info64(triangles, scene.normals),
        uv=uv,
        materials=material_table(scene.materials, len(uv) > 0),
        lights=light_table(view.lights, unit),
        background=np.asarray(scene.background, np.float64),
        min_weight=float(view.min_weight),
        t_min=shade.T_MIN_DOUBLE,
        corners=triangles,
        **_registers(image),
    )
    solid = np.array([m.opaque for m in scene.materials])[scene.face_material]
    return setup, bvh.build(triangles, scene.face_material, solid)


def render_double(image, wanted=None):
    """The same view in double precision, nothing of it rounded.

    Args: image; wanted (H, W) int64: triangle to show where several coincide (`bvh.coincident`), -1 or None: any.
    Returns: `Frame`.
    """
    unit, view = image.geometry.unit, image.view
    camera = rgen.camera_vectors(*camera_arguments(view.camera, unit, view.width, view.height))
    dirs, _ = rgen.primary_rays_double(camera, view.width, view.height)
    return _render(view, *setup_double(image), dirs, lambda tri, _: tri, wanted)
