# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Meshes as trimesh reads them, in the order in which it concatenates a scene, to parts of ours."""

import contextlib
import logging
import warnings
from dataclasses import dataclass, field

import numpy as np

from raycore.scene.data import make_material
from raycore.scene.materials import colour_materials, read_picture, texture_of, unit_colour


@dataclass
class Part:
    """Triangles (n, 3, 3) in place, their normals (n, 3, 3) or None, materials, index of each face's (n,), uv (n, 3, 2) or None."""

    triangles: np.ndarray
    normals: np.ndarray | None
    materials: list
    index: np.ndarray
    uv: np.ndarray | None = None


@dataclass
class Loaded:
    """What a file holds."""

    parts: list
    camera: object | None = None
    lights: list = field(default_factory=list)
    background: tuple | None = None
    duration: float = 0.0  # seconds until its last key


def read_trimesh(source, **options):
    """A file as a trimesh object, faces untouched. source: a path, or a stream with `file_type`."""
    import trimesh  # slow to import: only when a file is read

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return trimesh.load(source, process=False, **options)


def meshes(loaded):
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


def place(mesh, transform):
    """Corners of one mesh in place: triangles (n, 3, 3), normals (n, 3, 3) or None, vertex of each corner (n, 3)."""
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
    corner_normals = normals[faces].reshape(-1, 3, 3) if normals is not None and len(normals) == len(vertices) else None
    return vertices[faces].reshape(-1, 3, 3), corner_normals, faces.reshape(-1, 3)


def default_material():
    """Of meshes that have none."""
    return make_material("default", (0.66, 0.64, 0.60), (0.12, 0.12, 0.12), 32.0)


def plain_part(mesh, transform):
    """A part of a PLY or STL mesh: colours of its vertices or faces, a picture, or nothing."""
    triangles, normals, faces = place(mesh, transform)
    visual, name = mesh.visual, str(mesh.metadata.get("name") or "mesh")
    zeros = np.zeros(len(faces), np.int32)
    if visual.kind == "texture" and visual.material is not None:
        source = visual.material
        diffuse = unit_colour(source.diffuse) if getattr(source, "diffuse", None) is not None else np.ones(3)
        material, uv = make_material(str(getattr(source, "name", None) or name), diffuse), getattr(visual, "uv", None)
        picture = getattr(source, "image", None)
        if picture is not None and uv is not None and len(uv) == len(mesh.vertices):
            material.texture = texture_of(read_picture(picture), name=material.name)
            return Part(triangles, normals, [material], zeros, corner_uv(uv, faces, upwards=True))
        return Part(triangles, normals, [material], zeros)
    if visual.kind in ("vertex", "face") and len(faces):
        if visual.kind == "face":
            colours = np.asarray(visual.face_colors)[:, :3].astype(np.float64)
        else:
            colours = np.asarray(visual.vertex_colors)[:, :3].astype(np.float64)[np.asarray(mesh.faces)].mean(axis=1)
        return Part(triangles, normals, *colour_materials(colours, name))
    return Part(triangles, normals, [default_material()], zeros)


def corner_uv(uv, faces, upwards=False):
    """Coordinates of corners (n, 3, 2) from those of vertices; upwards: v grows upwards in the picture, ours downwards."""
    uv = np.asarray(uv, dtype=np.float64)[:, :2]
    if upwards:
        uv = np.stack((uv[:, 0], 1.0 - uv[:, 1]), axis=1)
    return uv[faces]
