# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scene files of other programs: packed or not, checked, put together to a `Scene`."""

import contextlib
import gzip
import tempfile
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from raycore.errors import SceneError
from raycore.scene import aff, gltf, obj
from raycore.scene.data import Scene
from raycore.scene.materials import Notes, flatten, merge_materials
from raycore.scene.mesh import Loaded, meshes, plain_part, read_trimesh
from raycore.scene.normals import face_normals, orient_normals, smooth_normals

SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".stl", ".aff")
PACKED = (".gz", ".zip")  # with one scene file inside
MAX_UNPACKED = 1 << 31  # bytes
MAX_TRIANGLES = (1 << 24) - 2  # triangle indices have 24 bits; all ones means "none"
MAX_COORDINATE = 1e30  # beyond this, products of coordinates leave single precision


def choices():
    """The formats, for people."""
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
            raise SceneError(f"{path}: {what} in it; unpack it and give {choices()}")
        yield found[0]


def reason(error):
    """An exception in one short line."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text[:120]}" if text else type(error).__name__


def check_triangles(triangles, where):
    """Refuse what cannot be rendered. Raises: SceneError."""
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


def assemble(parts, notes):
    """Parts to (triangles, normals, uv or None, materials, material of each face)."""
    triangles = np.concatenate([p.triangles for p in parts])
    normals, uv = np.empty_like(triangles), np.zeros((len(triangles), 3, 2))
    materials, face_material, at = [], [], 0
    has_uv = False
    for part in parts:
        count, own = len(part.triangles), list(part.materials)
        if part.normals is None:
            normals[at : at + count] = smooth_normals(part.triangles)
        else:
            normals[at : at + count] = orient_normals(part.normals, part.triangles)
        if part.uv is not None:
            uv[at : at + count] = part.uv
            has_uv = True
        elif any(m.texture is not None for m in own):
            notes.add("textures of meshes without coordinates become their mean colour", own[0].name)
            own = [flatten(m) for m in own]
        face_material.append(np.asarray(part.index, dtype=np.int32) + len(materials))
        materials += own
        at += count
    if not np.isfinite(uv).all():
        notes.add("texture coordinates that are no numbers count as 0")
        uv[~np.isfinite(uv)] = 0.0
    materials, face_material = merge_materials(materials, np.concatenate(face_material), notes)
    return triangles, normals, uv if has_uv else None, materials, face_material


def load_file(path, time=0.0):
    """A file of another program as a `Scene`; time: in seconds, for what moves in AFF. Raises: SceneError."""
    suffix = path.suffix.lower()
    if path.stat().st_size == 0:
        raise SceneError(f"{path}: the file is empty")
    notes = Notes()
    try:
        with _unpacked(path) as file:
            suffix = file.suffix.lower()
            if suffix in (".glb", ".gltf"):
                loaded = gltf.load(file, notes)
            elif suffix == ".obj":
                loaded = obj.load(file, notes)
            elif suffix == ".aff":
                loaded = aff.load(file, notes, time)
            else:
                loaded = Loaded([plain_part(*pair) for pair in meshes(read_trimesh(str(file)))])
    except (KeyboardInterrupt, SceneError):
        raise
    except Exception as error:  # whatever a parser raises on a broken file
        raise SceneError(f"{path}: cannot be read as {suffix[1:].upper()} ({reason(error)}); is it complete?") from None
    parts = [p for p in loaded.parts if len(p.triangles)]
    if not parts:
        raise SceneError(f"{path}: no triangles in it; give a mesh with faces")
    check_triangles(np.concatenate([p.triangles for p in parts]), path)
    triangles, normals, uv, materials, face_material = assemble(parts, notes)
    up = (0.0, 0.0, 1.0) if suffix == ".stl" else (0.0, 1.0, 0.0)  # STL comes from machines that build upwards in z
    scene = Scene(path.name, triangles, normals, face_material, materials, loaded.camera, loaded.lights, up)
    own = {} if loaded.background is None else {"background": loaded.background}
    return replace(scene, uv=uv, warnings=notes.lines(), duration=loaded.duration, **own)
