# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scene files to arrays: triangles, normals, materials, cameras and lights, and their way into the unit box.

Formats: glTF and GLB, OBJ, PLY, STL, through trimesh, also inside `.gz` or `.zip`; and our own generators in `scenes/`.
Triangles keep the order in which trimesh concatenates the geometry of a scene; none is merged, dropped or turned.
"""

import contextlib
import gzip
import hashlib
import importlib.util
import json
import logging
import math
import os
import struct
import tempfile
import warnings
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numba import njit

from raycore.errors import OptionError, SceneError
from raycore.model import fp24

ROOT = Path(__file__).resolve().parents[2]
GENERATORS = ROOT / "scenes"
CACHE = ROOT / "build" / "scenes"

SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".stl")
PACKED = (".gz", ".zip")  # with one scene file inside
MAX_UNPACKED = 1 << 31  # bytes
MAX_TRIANGLES = (1 << 24) - 2  # triangle indices have 24 bits; all ones means "none"
MAX_MATERIALS = 256
MAX_COORDINATE = 1e30  # beyond this, products of coordinates leave single precision
AMBIENT_LIGHT = 0.12  # of a default scene; folded into the materials
CREASE_COS = math.cos(math.radians(60.0))  # edges sharper than this stay sharp
DEFAULT_FOV = 45.0


@dataclass(eq=False)
class Texture:
    """A picture for a material: image (H, W, 4) uint8 RGBA, sRGB unless `srgb` is off, straight alpha, row 0 at v = 0.

    The sides may have any length; `raycore.texture` scales them to powers of two. Equal pictures with equal settings are equal.
    """

    image: np.ndarray
    wrap_s: str = "repeat"  # of u: repeat, mirror or clamp
    wrap_t: str = "repeat"  # of v
    srgb: bool = True  # False: the colours are linear
    compact: bool = False  # 16 bits a texel (RGBA5551) instead of 32
    name: str = ""

    def _key(self):
        if not hasattr(self, "_digest"):
            image = np.ascontiguousarray(self.image)
            self._digest = (image.shape, hashlib.sha256(image.tobytes()).hexdigest())
        return (*self._digest, self.wrap_s, self.wrap_t, self.srgb, self.compact)

    def __eq__(self, other):
        return isinstance(other, Texture) and self._key() == other._key()

    def __hash__(self):
        return hash(self._key())


@dataclass
class Material:
    """A Phong material with optics; linear RGB. docs/whitted.md says how it is used.

    The texture multiplies ambient, diffuse and transmit, and reflect if it tints the reflection; its alpha multiplies alpha.
    """

    name: str
    ambient: tuple  # ambient light of the scene times reflectance
    diffuse: tuple
    specular: tuple = (0.0, 0.0, 0.0)
    shininess: float = 32.0  # 0 to 1024
    emission: tuple = (0.0, 0.0, 0.0)
    reflect: tuple = (0.0, 0.0, 0.0)  # share that is mirrored, at normal incidence
    transmit: tuple = (0.0, 0.0, 0.0)  # share that goes through, refracted; only with alpha_mode "opaque"
    ior: float = 1.0  # refractive index of what is behind the surface, against what is before it
    fresnel: bool = False  # reflect grows towards grazing angles (Schlick), transmit shrinks by as much
    alpha: float = 1.0
    alpha_mode: str = "opaque"  # or "mask": there or not, by the cutoff; or "blend"
    alpha_cutoff: float = 0.5
    texture: Texture | None = None
    tint_reflection: bool = False  # the texture multiplies reflect, as on metals

    @property
    def opaque(self):
        """Whether nothing passes it: such a hit ends a shadow ray."""
        return self.alpha_mode == "opaque" and not any(self.transmit)


@dataclass
class Light:
    """A point light, or a directional one with the unit direction towards it as `position`; linear RGB."""

    position: tuple
    colour: tuple = (1.0, 1.0, 1.0)
    directional: bool = False
    attenuation: tuple = (1.0, 0.0, 0.0)  # 1 / (c + l * distance + q * distance^2)


@dataclass
class Camera:
    """A pinhole camera: world units, vertical field of view in degrees."""

    eye: tuple
    target: tuple
    up: tuple = (0.0, 1.0, 0.0)
    fov: float = DEFAULT_FOV


@dataclass
class Scene:
    """A scene as loaded, in world units.

    triangles (N, 3, 3) and normals (N, 3, 3) float64, face_material (N,) int32 index into `materials`. Normals are unit
    vectors on the side of the triangle's own normal (right hand rule). camera is None and lights is empty if the file
    has none. uv (N, 3, 2) float64 texture coordinates of the corners, v downwards in the image, or None if nothing is
    textured. warnings: one line for each kind of thing in the file that could not be mapped.
    """

    name: str
    triangles: np.ndarray
    normals: np.ndarray
    face_material: np.ndarray
    materials: list
    camera: Camera | None = None
    lights: list = field(default_factory=list)
    up: tuple = (0.0, 1.0, 0.0)
    background: tuple = (0.10, 0.13, 0.18)
    uv: np.ndarray | None = None
    warnings: list = field(default_factory=list)
    depth: int | None = None  # bounces that the scene asks for

    @property
    def bounds(self):
        """(2, 3) box of all vertices."""
        return np.stack((self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))))


# ---- normals ---------------------------------------------------------------------------------------------------------


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


# ---- materials -------------------------------------------------------------------------------------------------------


def _linear(srgb):
    """sRGB in [0, 1] to linear."""
    srgb = np.asarray(srgb, dtype=np.float64)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def make_material(
    name,
    diffuse,
    specular=(0.0, 0.0, 0.0),
    shininess=32.0,
    emission=(0.0, 0.0, 0.0),
    ambient_light=AMBIENT_LIGHT,
    **optics,
):
    """A `Material` that reflects the ambient light of a default scene. optics: its further fields, by name."""

    def colour(values):
        return tuple(map(float, values))

    more = {k: colour(v) if k in ("reflect", "transmit") else v for k, v in optics.items()}
    more.setdefault("ambient", tuple(float(ambient_light * d) for d in diffuse))
    return Material(
        name,
        diffuse=colour(diffuse),
        specular=colour(specular),
        shininess=float(shininess),
        emission=colour(emission),
        **more,
    )


def _mean_colour(image):
    """Mean linear RGB of a picture, of its opaque part if it has transparent ones."""
    image = image.convert("RGBA")
    image.thumbnail((64, 64))
    pixels = np.asarray(image, dtype=np.float64).reshape(-1, 4) / 255.0
    weight = pixels[:, 3] if pixels[:, 3].sum() > 0.0 else np.ones(len(pixels))
    return (_linear(pixels[:, :3]) * weight[:, None]).sum(axis=0) / weight.sum()


def _unit_colour(value):
    """Three numbers from a colour of bytes or of floats."""
    value = np.asarray(value)
    rgb = value[:3].astype(np.float64)
    return rgb / 255.0 if value.dtype.kind in "ui" else rgb


def _convert_material(source):
    """A trimesh material to ours. Textures are replaced by their mean colour until there is a texture unit."""
    name = str(getattr(source, "name", None) or "material")
    if hasattr(source, "baseColorFactor"):  # glTF metallic-roughness
        base = np.ones(3) if source.baseColorFactor is None else _unit_colour(source.baseColorFactor)
        if source.baseColorTexture is not None:
            base = base * _mean_colour(source.baseColorTexture)
        metallic = 1.0 if source.metallicFactor is None else float(source.metallicFactor)
        rough = 1.0 if source.roughnessFactor is None else float(source.roughnessFactor)
        if source.metallicRoughnessTexture is not None:
            mean = (
                np.asarray(source.metallicRoughnessTexture.convert("RGB").resize((16, 16))).reshape(-1, 3).mean(axis=0)
                / 255.0
            )
            rough, metallic = rough * mean[1], metallic * mean[2]
        emission = np.zeros(3) if source.emissiveFactor is None else _unit_colour(source.emissiveFactor)
        if source.emissiveTexture is not None:
            emission = emission * _mean_colour(source.emissiveTexture)
        gloss = (1.0 - min(max(rough, 0.0), 1.0)) ** 2
        specular = (0.04 + metallic * (base - 0.04)) * (0.2 + 4.0 * gloss)
        # Mirrors are a matter of reflection rays; without them a metal keeps some of its colour as diffuse.
        diffuse = base * (1.0 - 0.6 * metallic)
        shininess = 2.0 ** round(2.0 + 5.0 * gloss)
    else:  # Phong, as in MTL files
        diffuse = _unit_colour(source.diffuse) if getattr(source, "diffuse", None) is not None else np.full(3, 0.7)
        if getattr(source, "image", None) is not None:
            diffuse = _mean_colour(source.image)
        specular = _unit_colour(source.specular) if getattr(source, "specular", None) is not None else np.zeros(3)
        shininess = float(getattr(source, "glossiness", None) or 32.0)
        kwargs = getattr(source, "kwargs", None) or {}
        emission = np.zeros(3)
        with contextlib.suppress(TypeError, ValueError):
            emission = np.asarray([float(v) for v in kwargs.get("ke", (0.0, 0.0, 0.0))])[:3]
    return make_material(
        name,
        np.clip(diffuse, 0.0, 1.0),
        np.clip(specular, 0.0, 1.0),
        min(max(shininess, 1.0), 1024.0),
        np.clip(emission, 0.0, 1.0),
    )


def _colour_materials(colours, name, limit=128):
    """Materials for per-face RGB bytes (N, 3): the colours, coarsened until there are at most `limit`."""
    for shift in range(8):
        coarse = (colours.astype(np.int64) >> shift) << shift
        codes, index = np.unique(coarse @ np.array([65536, 256, 1]), return_inverse=True)
        if codes.size <= limit:
            break
    index = index.reshape(-1)
    table = np.stack([np.bincount(index, colours[:, c]) / np.bincount(index) for c in range(3)], axis=1) / 255.0
    return [make_material(f"{name} colour {i}", _linear(rgb)) for i, rgb in enumerate(table)], index


def _merge_materials(materials, face_material):
    """Equal materials become one; where more than fit remain, the rarest join the nearest in colour."""
    keys, remap, merged = {}, np.empty(len(materials), np.int32), []
    for i, m in enumerate(materials):
        key = (m.name, m.ambient, m.diffuse, m.specular, m.shininess)
        if key not in keys:
            keys[key] = len(merged)
            merged.append(m)
        remap[i] = keys[key]
    face_material = remap[face_material]
    if len(merged) > MAX_MATERIALS:
        use = np.bincount(face_material, minlength=len(merged))
        kept = np.sort(np.argsort(-use, kind="stable")[:MAX_MATERIALS])
        looks = np.array([(*m.ambient, *m.diffuse, *m.specular) for m in merged])
        nearest = ((looks[:, None] - looks[kept][None]) ** 2).sum(axis=2).argmin(axis=1)
        face_material = nearest[face_material]
        merged = [merged[i] for i in kept]
    return merged, face_material.astype(np.int32)


# ---- files -----------------------------------------------------------------------------------------------------------


def _choices():
    return f"one of {', '.join(SUFFIXES)}, or that in {' or '.join(PACKED)}"


@contextlib.contextmanager
def _unpacked(path):
    """The path of the scene file itself: `path`, or what is packed in it, in a folder that goes away afterwards."""
    if path.suffix.lower() not in PACKED:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        inside = Path(folder)
        if path.suffix.lower() == ".gz":
            with gzip.open(path, "rb") as stream:
                data = stream.read(MAX_UNPACKED + 1)
            size = len(data)
            (inside / path.stem).write_bytes(data[:MAX_UNPACKED])
        else:
            with zipfile.ZipFile(path) as archive:
                size = sum(member.file_size for member in archive.infolist())
                if size <= MAX_UNPACKED:
                    archive.extractall(inside)  # turns names that would leave the folder into harmless ones
        if size > MAX_UNPACKED:
            raise SceneError(f"{path}: more than {MAX_UNPACKED >> 30} GB when unpacked; simplify the mesh")
        found = sorted(p for p in inside.rglob("*") if p.is_file() and p.suffix.lower() in SUFFIXES)
        if len(found) != 1:
            what = "no scene file" if not found else f"{len(found)} scene files"
            raise SceneError(f"{path}: {what} in it; unpack it and give {_choices()}")
        yield found[0]


def _reason(error):
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text[:120]}" if text else type(error).__name__


def _read(path):
    """The file as a trimesh object, faces untouched."""
    import trimesh  # slow to import: only when a file is read

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return trimesh.load(str(path), process=False)


def _meshes(loaded):
    """(mesh, transform) in the order in which trimesh concatenates a scene."""
    import trimesh

    if isinstance(loaded, trimesh.Scene):
        for node in loaded.graph.nodes_geometry:
            transform, name = loaded.graph[node]
            mesh = loaded.geometry[name]
            if isinstance(mesh, trimesh.Trimesh):
                yield mesh, transform
    elif isinstance(loaded, trimesh.Trimesh):
        yield loaded, None


def _convert_mesh(mesh, transform):
    """One mesh in place: triangles, normals or None, materials, material of each face."""
    import trimesh

    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
    if faces.size and (faces.min() < 0 or faces.max() >= vertices.shape[0]):
        raise ValueError(f"a face asks for vertex {int(faces.max())} of {vertices.shape[0]}")
    normals = (
        np.asarray(mesh.vertex_normals) if "vertex_normals" in mesh._cache else None
    )  # the file's own, not computed
    if transform is not None:
        # By trimesh itself, since a mirroring transform makes it turn the faces.
        placed = trimesh.Trimesh(vertices, faces, process=False, vertex_normals=normals)
        placed.apply_transform(transform)
        vertices, faces = np.asarray(placed.vertices), np.asarray(placed.faces)
        if normals is not None:
            linear = np.asarray(transform, dtype=np.float64)[:3, :3]
            with contextlib.suppress(np.linalg.LinAlgError):
                normals = normals @ np.linalg.inv(linear)
    triangles = vertices[faces].reshape(-1, 3, 3)
    corner_normals = normals[faces].reshape(-1, 3, 3) if normals is not None and len(normals) == len(vertices) else None

    visual = mesh.visual
    name = str(mesh.metadata.get("name") or "mesh")
    if visual.kind == "texture" and visual.material is not None:
        parts = getattr(visual.material, "materials", None)  # several materials in one mesh
        index = getattr(visual, "face_materials", None)
        if parts and index is not None and len(index) == len(faces):
            return triangles, corner_normals, [_convert_material(m) for m in parts], np.asarray(index)
        return triangles, corner_normals, [_convert_material(visual.material)], np.zeros(len(faces), np.int32)
    if visual.kind in ("vertex", "face") and len(faces):
        if visual.kind == "face":
            colours = np.asarray(visual.face_colors)[:, :3].astype(np.float64)
        else:
            colours = np.asarray(visual.vertex_colors)[:, :3].astype(np.float64)[np.asarray(mesh.faces)].mean(axis=1)
        return triangles, corner_normals, *_colour_materials(colours, name)
    grey = make_material("default", (0.66, 0.64, 0.60), (0.12, 0.12, 0.12), 32.0)
    return triangles, corner_normals, [grey], np.zeros(len(faces), np.int32)


def _gltf_header(path):
    """The JSON part of a glTF or GLB file."""
    if path.suffix.lower() == ".gltf":
        return json.loads(path.read_text(encoding="utf-8"))
    with path.open("rb") as stream:
        stream.read(12)
        length = struct.unpack("<I", stream.read(4))[0]
        stream.read(4)
        return json.loads(stream.read(length))


def _node_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    out = np.eye(4)
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)))
    out[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return out


def _gltf_views(path):
    """First perspective camera, and lights of KHR_lights_punctual, of a glTF file: (Camera or None, [Light])."""
    header = _gltf_header(path)
    nodes = header.get("nodes", [])
    defined = header.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    scenes = header.get("scenes") or [{"nodes": range(len(nodes))}]
    camera, lights = None, []
    todo = [(i, np.eye(4), 0) for i in reversed(list(scenes[header.get("scene", 0)].get("nodes", [])))]
    while todo:
        index, above, depth = todo.pop()
        if depth > 64 or not 0 <= index < len(nodes):
            continue
        node = nodes[index]
        matrix = above @ _node_matrix(node)
        todo += [(i, matrix, depth + 1) for i in reversed(node.get("children", []))]
        place, forward, up = matrix[:3, 3], -matrix[:3, 2], matrix[:3, 1]
        if "camera" in node and camera is None:
            lens = header["cameras"][node["camera"]].get("perspective")
            if lens:
                fov = math.degrees(lens["yfov"])
                camera = Camera(
                    tuple(map(float, place)), tuple(map(float, place + forward)), tuple(map(float, up)), fov
                )
        number = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if number is not None:
            lights.append((defined[number], place, forward))
    if not lights:
        return camera, []
    # Intensities are photometric and scenes differ by orders of magnitude: only colours and their ratio are kept.
    power = max(float(light.get("intensity", 1.0)) for light, _, _ in lights) or 1.0
    out = []
    for light, place, forward in lights[:16]:
        weight = float(light.get("intensity", 1.0)) / power
        colour = tuple(float(c) * weight for c in light.get("color", (1.0, 1.0, 1.0)))
        if light.get("type") == "directional":
            out.append(Light(tuple(map(float, -forward / np.linalg.norm(forward))), colour, directional=True))
        else:  # a spot shines into all directions here
            out.append(Light(tuple(map(float, place)), colour))
    return camera, out


def _check(triangles, where):
    """Refuse what cannot be rendered."""
    if triangles.shape[0] == 0:
        raise SceneError(f"{where}: no triangles in it; give a mesh with faces")
    if triangles.shape[0] > MAX_TRIANGLES:
        raise SceneError(
            f"{where}: {triangles.shape[0]} triangles, at most {MAX_TRIANGLES} fit 24-bit indices; simplify the mesh"
        )
    bad = ~np.isfinite(triangles).all(axis=(1, 2))
    if bad.any():
        raise SceneError(
            f"{where}: NaN or infinite vertices in {bad.sum()} triangles (first: {bad.argmax()}); repair the mesh"
        )
    largest = np.abs(triangles).max()
    if largest > MAX_COORDINATE:
        raise SceneError(f"{where}: coordinate {largest:.3g} is beyond {MAX_COORDINATE:g}; rescale the mesh")
    extent = (triangles.max(axis=(0, 1)) - triangles.min(axis=(0, 1))).max()
    if extent < 1.0 / MAX_COORDINATE:
        raise SceneError(f"{where}: all vertices lie within {extent:.3g}; there is nothing to see, rescale the mesh")
    if not face_normals(triangles).any():
        raise SceneError(f"{where}: none of its {triangles.shape[0]} triangles has an area; repair the mesh")


def _load_file(path):
    suffix = path.suffix.lower()
    if path.is_dir():
        raise SceneError(f"{path}: is a directory; give {_choices()}")
    if not path.exists():
        ours = ", ".join(scene_names()) or "none"
        raise SceneError(f"{path}: no such file, and no scene of that name; ours are: {ours}")
    if suffix not in SUFFIXES + PACKED:
        raise SceneError(f"{path}: '{suffix or 'no suffix'}' is not supported; convert it to {_choices()}")
    if path.stat().st_size == 0:
        raise SceneError(f"{path}: the file is empty")
    camera, lights = None, []
    try:
        with _unpacked(path) as file:
            suffix = file.suffix.lower()
            parts = [_convert_mesh(mesh, transform) for mesh, transform in _meshes(_read(file))]
            if suffix in (".glb", ".gltf"):
                camera, lights = _gltf_views(file)
    except (KeyboardInterrupt, SceneError):
        raise
    except Exception as error:  # whatever a parser raises on a broken file
        raise SceneError(
            f"{path}: cannot be read as {suffix[1:].upper()} ({_reason(error)}); is it complete?"
        ) from None
    parts = [p for p in parts if len(p[0])]
    if not parts:
        raise SceneError(f"{path}: no triangles in it; give a mesh with faces")
    triangles = np.concatenate([p[0] for p in parts])
    _check(triangles, path)
    materials, face_material, normals, at = [], [], np.empty_like(triangles), 0
    for tris, own, mats, index in parts:
        normals[at : at + len(tris)] = smooth_normals(tris) if own is None else orient_normals(own, tris)
        face_material.append(np.asarray(index, dtype=np.int32) + len(materials))
        materials += mats
        at += len(tris)
    materials, face_material = _merge_materials(materials, np.concatenate(face_material))
    up = (0.0, 0.0, 1.0) if suffix == ".stl" else (0.0, 1.0, 0.0)  # STL comes from machines that build upwards in z
    return Scene(path.name, triangles, normals, face_material, materials, camera, lights, up)


# ---- our own scenes --------------------------------------------------------------------------------------------------


def scene_names():
    """Names of the generators in `scenes/`."""
    return sorted(p.stem for p in GENERATORS.glob("*.py") if not p.stem.startswith("_"))


def _save(scene, path):
    """Keep a generated scene; a cache that cannot be written is no error."""
    views = {
        "name": scene.name,
        "materials": [vars(m) for m in scene.materials],
        "camera": vars(scene.camera) if scene.camera else None,
        "lights": [vars(light) for light in scene.lights],
        "up": scene.up,
        "background": scene.background,
    }
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(f".{os.getpid()}.npz")
        with part.open("wb") as stream:
            np.savez(
                stream,
                triangles=scene.triangles,
                normals=scene.normals,
                face_material=scene.face_material,
                views=np.frombuffer(json.dumps(views).encode(), np.uint8),
            )
        for old in path.parent.glob(f"{path.stem.rsplit('-', 1)[0]}-*.npz"):
            if old not in (part, path):
                old.unlink()
        part.replace(path)


def _restore(path):
    with np.load(path) as data:
        views = json.loads(data["views"].tobytes())

        def thing(kind, values):
            return kind(**{k: tuple(v) if isinstance(v, list) else v for k, v in values.items()})

        return Scene(
            views["name"],
            data["triangles"],
            data["normals"],
            data["face_material"],
            [thing(Material, m) for m in views["materials"]],
            thing(Camera, views["camera"]) if views["camera"] else None,
            [thing(Light, light) for light in views["lights"]],
            tuple(views["up"]),
            tuple(views["background"]),
        )


def _load_generator(path):
    """Run a generator, or take its scene from the cache; the key is the text of all that shapes it."""
    text = path.read_bytes() + Path(__file__).read_bytes() + Path(__file__).with_name("shapes.py").read_bytes()
    cached = CACHE / f"{path.stem}-{hashlib.sha256(text).hexdigest()[:16]}.npz"
    if cached.exists():
        with contextlib.suppress(Exception):  # a broken cache is made anew
            return _restore(cached)
    try:
        spec = importlib.util.spec_from_file_location(f"raycore_scene_{path.stem}", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        scene = module.build()
    except SceneError:
        raise
    except Exception as error:
        raise SceneError(f"{path}: the generator failed ({_reason(error)})") from None
    if not isinstance(scene, Scene):
        raise SceneError(f"{path}: build() must return a raycore.scene.Scene")
    _check(scene.triangles, path)
    _save(scene, cached)
    return scene


def load_scene(path):
    """Load a scene.

    Args: path of a file (`SUFFIXES`, `PACKED`), of a generator (`.py` with `build() -> Scene`), or the name of one in `scenes/`.
    Returns: `Scene`.
    Raises: SceneError with one line: what is wrong, where, and what to do.
    """
    path = Path(path)
    named = GENERATORS / f"{path}.py"
    try:
        if not path.exists() and path.parent == Path() and not path.suffix and named.exists():
            return _load_generator(named)
        if path.suffix == ".py" and path.is_file():
            return _load_generator(path)
        return _load_file(path)
    except OSError as error:
        raise SceneError(f"{path}: cannot be read ({error.strerror or error})") from None
    except MemoryError:
        raise SceneError(f"{path}: does not fit into this machine's memory; simplify the mesh") from None


# ---- views -----------------------------------------------------------------------------------------------------------


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


# ---- into the unit box -----------------------------------------------------------------------------------------------


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
