# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scene files of our own: JSON after `scene.schema.json`, which names meshes and says how they stand, look and are lit."""

import functools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from raycore.errors import SceneError
from raycore.scene.animation import duration, matrix_at, rotation
from raycore.scene.data import AMBIENT_LIGHT, Camera, Light, Placed, Scene, Texture, make_material
from raycore.scene.files import assemble, check_triangles
from raycore.scene.materials import Notes, read_picture, settle_alpha, times
from raycore.scene.mesh import Part

SCHEMA = Path(__file__).with_name("scene.schema.json")
MAX_NESTING = 8  # scene files within scene files
NOT_RIGID = 2.0**-16  # entries of a rotation may be off by this much, so that matrices of six digits pass
COLOURS = ("ambient", "diffuse", "specular", "emission", "reflect", "transmit")


# ---- the document ----------------------------------------------------------------------------------------------------


@functools.cache
def _validator():
    import jsonschema  # slow to import: only when a scene file is read

    return jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text(encoding="utf-8")))


def _where(path):
    """A place in the document, as people write it: meshes[0].transform[1]."""
    text = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in path)
    return text.lstrip(".") or "the document"


def _no_constant(name):
    raise ValueError(f"{name} is no number of JSON")


def read_document(path):
    """The document of a scene file, valid by the schema. Raises: SceneError with the place that is wrong."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"), parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise SceneError(f"{path}: no JSON at line {error.lineno}, column {error.colno}: {error.msg}") from None
    except (UnicodeDecodeError, ValueError, RecursionError) as error:
        raise SceneError(f"{path}: no JSON: {error}") from None
    errors = sorted(_validator().iter_errors(document), key=lambda e: (len(e.absolute_path), str(e.absolute_path)))
    if errors:
        error = errors[-1]  # the deepest one says most
        message, shown = error.message, repr(error.instance)
        if len(shown) > 60:
            message = message.replace(shown, "what is there")
        message = " ".join(message.split())
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        raise SceneError(f"{path}: {_where(error.absolute_path)}: {message[:200]}{more}; see scene.schema.json")
    return document


# ---- its parts -------------------------------------------------------------------------------------------------------


def transform_matrix(steps):
    """Matrix (4, 4) of a mesh's steps. Raises: ValueError if it cannot be undone."""
    out = np.eye(4)
    for step in steps:
        matrix = np.eye(4)
        ((kind, value),) = step.items()
        if kind == "translate":
            matrix[:3, 3] = value
        elif kind == "scale":
            matrix[:3, :3] *= np.asarray(value, dtype=np.float64)
        elif kind == "rotate":
            if not any(value["axis"]):
                raise ValueError("the axis of a rotation is zero")
            matrix[:3, :3] = rotation(**value)
        else:
            matrix = np.array(value, dtype=np.float64).reshape(4, 4)
            if (matrix[3] != (0.0, 0.0, 0.0, 1.0)).any():
                raise ValueError("the last row of a matrix is not 0 0 0 1")
        out = matrix @ out
    if not np.isfinite(out).all() or np.linalg.det(out[:3, :3]) == 0.0:
        raise ValueError("the transform makes everything flat")
    return out


def rigid_parts(matrix):
    """What a matrix (4, 4) does to a rigid mesh: rotation (3, 3), scale, translation (3,).

    The scale is rounded to 12 digits, so that meshes which are turned differently and scaled alike keep equal shapes.
    Raises: ValueError if it is none of these three.
    """
    linear = matrix[:3, :3]
    size = np.cbrt(np.linalg.det(linear))
    off = np.abs(linear @ linear.T - size**2 * np.eye(3)).max()
    if not (size > 0.0 and off <= NOT_RIGID * size**2):
        raise ValueError("a rigid mesh can be turned, moved and scaled evenly, not mirrored, sheared or scaled along an axis")
    left, _, right = np.linalg.svd(linear)
    return left @ right, float(f"{size:.12g}"), matrix[:3, 3]


def moved(scene, matrix):
    """A scene in another place: triangles, normals, camera and lights. A mirroring matrix turns the triangles round."""
    linear, offset = matrix[:3, :3], matrix[:3, 3]
    triangles = scene.triangles @ linear.T + offset
    normals = scene.normals @ np.linalg.inv(linear)
    uv = scene.uv
    if np.linalg.det(linear) < 0.0:
        triangles, normals = triangles[:, ::-1], normals[:, ::-1]
        uv = None if uv is None else uv[:, ::-1]
    scale = abs(np.linalg.det(linear)) ** (1.0 / 3.0)

    def point(p):
        return tuple(map(float, linear @ np.asarray(p, dtype=np.float64) + offset))

    def direction(d):
        return tuple(map(float, linear @ np.asarray(d, dtype=np.float64)))

    camera = scene.camera
    if camera is not None:
        camera = Camera(point(camera.eye), point(camera.target), direction(camera.up), camera.fov)
    lights = []
    for light in scene.lights:
        position = direction(light.position) if light.directional else point(light.position)
        c, l, q = light.attenuation
        lights.append(replace(light, position=position, attenuation=(c, l / scale, q / scale**2)))
    return replace(scene, triangles=triangles, normals=normals, uv=uv, camera=camera, lights=lights)


def _texture(value, folder):
    """A `Texture` or None from a document. Raises: ValueError."""
    if value is None:
        return None
    options = {"file": value} if isinstance(value, str) else dict(value)
    name = options.pop("file")
    try:
        image = read_picture(folder / name)
    except (OSError, ValueError) as error:
        said = getattr(error, "strerror", None) or type(error).__name__
        raise ValueError(f"texture {name}: cannot be read ({said})") from None
    return Texture(image, name=name, **options)


def changed(material, values, folder):
    """A material with the fields of a document. Raises: ValueError."""
    fields = {k: tuple(map(float, v)) if k in COLOURS else v for k, v in values.items() if k != "texture"}
    if "diffuse" in fields:
        fields.setdefault("ambient", times(fields["diffuse"], AMBIENT_LIGHT))
    if "texture" in values:
        fields["texture"] = _texture(values["texture"], folder)
    return settle_alpha(replace(material, **fields))


def _light(values):
    """A `Light`. Raises: ValueError."""
    if ("position" in values) == ("direction" in values):
        raise ValueError("give either position or direction")
    directional = "direction" in values
    place = tuple(map(float, values["direction" if directional else "position"]))
    if directional and not any(place):
        raise ValueError("its direction is zero")
    more = {k: tuple(map(float, values[k])) for k in ("colour", "attenuation") if k in values}
    if more.get("attenuation") == (0.0, 0.0, 0.0):
        raise ValueError("its attenuation divides by zero")
    return Light(place, directional=directional, **more)


def _camera(values):
    """A `Camera`. Raises: ValueError."""
    vectors = {k: tuple(map(float, values[k])) for k in ("eye", "target", "up") if k in values}
    camera = Camera(**vectors, **({"fov": float(values["fov"])} if "fov" in values else {}))
    view = np.subtract(camera.target, camera.eye)
    if not view.any():
        raise ValueError("eye and target are the same point")
    if not np.linalg.norm(np.cross(view / np.abs(view).max(), camera.up)) > 1e-6 * np.linalg.norm(camera.up):
        raise ValueError("up is zero or points along the view")
    return camera


# ---- together --------------------------------------------------------------------------------------------------------


def load_document(path, load, within=(), time=0.0):
    """Load a scene file as it is at a time, in seconds.

    load(path, within, time): loads a mesh's file; within: the scene files that this one is part of.

    Returns: `Scene`. Raises: SceneError with the file, the place in it, and what is wrong.
    """
    here = path.resolve()
    if here in within or len(within) >= MAX_NESTING:
        raise SceneError(f"{path}: scene files name each other in a circle, or more than {MAX_NESTING} deep")
    document, folder = read_document(path), path.parent

    def built(where, make, *arguments):
        try:
            return make(*arguments)
        except ValueError as error:
            raise SceneError(f"{path}: {_where(where)}: {error}") from None

    changes = document.get("materials", {})
    new, touched, notes, scenes = {}, set(), Notes(), []
    for i, mesh in enumerate(document["meshes"]):
        scene = load(_mesh_path(folder, mesh["file"]), (*within, here), time)
        for line in scene.warnings:
            notes.add(f"{mesh['file']}: {line}")
        placed = _placed(mesh.get("dynamic", False), scene)
        matrix = built(("meshes", i, "transform"), transform_matrix, mesh.get("transform", []))
        if placed:
            built(("meshes", i, "transform"), rigid_parts, matrix)
        if "animation" in mesh:
            matrix = built(("meshes", i, "animation"), matrix_at, mesh["animation"], time) @ matrix
            scene = replace(scene, duration=max(scene.duration, duration(mesh["animation"])))
        if placed:
            motion = built(("meshes", i, "animation"), rigid_parts, matrix)
            placed = [p.moved(*motion) for p in placed]
        scene = replace(moved(scene, matrix), placed=placed)
        if "material" in mesh:
            name = mesh["material"]
            if name not in changes:
                raise SceneError(f"{path}: meshes[{i}].material: no '{name}' in materials")
            if name not in new:
                new[name] = built(
                    ("materials", name), changed, make_material(name, (0.7, 0.7, 0.7)), changes[name], folder
                )
            touched.add(name)
            scene = replace(scene, materials=[new[name]], face_material=np.zeros_like(scene.face_material))
        else:
            names = {m.name for m in scene.materials} & set(changes)
            touched |= names
            scene = replace(
                scene,
                materials=[
                    built(("materials", m.name), changed, m, changes[m.name], folder) if m.name in names else m
                    for m in scene.materials
                ],
            )
        scenes.append(scene)
    for name in changes:
        if name not in touched:
            known = sorted({m.name for s in scenes for m in s.materials})
            listed = ", ".join(known[:8]) + (" ..." if len(known) > 8 else "")
            raise SceneError(f"{path}: materials.{name}: no mesh has a material of this name; there are: {listed}")
    check_triangles(np.concatenate([s.triangles for s in scenes]), path)
    parts = [Part(s.triangles, s.normals, s.materials, s.face_material, s.uv) for s in scenes]
    triangles, normals, uv, materials, face_material = assemble(parts, notes)
    things = _objects([mesh.get("dynamic", False) for mesh in document["meshes"]], scenes)
    if things is not None:  # static triangles first, then object by object, the rigid ones last
        order = np.argsort(things, kind="stable")
        triangles, normals, face_material, things = (a[order] for a in (triangles, normals, face_material, things))
        uv = None if uv is None else uv[order]
    lights = [light for s in scenes for light in s.lights]
    if "lights" in document:
        lights = [built(("lights", i), _light, v) for i, v in enumerate(document["lights"])]
    elif len(lights) > 16:
        notes.add(f"{len(lights)} lights, 16 fit: the others are left out")
    cameras = [s.camera for s in scenes if s.camera is not None]
    depths = [s.depth for s in scenes if s.depth is not None]
    return Scene(
        document.get("name", path.name),
        triangles,
        normals,
        face_material,
        materials,
        built(("camera",), _camera, document["camera"]) if "camera" in document else next(iter(cameras), None),
        lights[:16],
        tuple(map(float, document.get("up", scenes[0].up))),
        tuple(map(float, document.get("background", scenes[0].background))),
        uv,
        notes.lines(),
        document.get("depth", max(depths, default=None)),
        max(s.duration for s in scenes),
        things,
        [p for s in scenes for p in s.placed],
    )


def _placed(mark, scene):
    """The rigid objects of a mesh, before it moves: itself if it is marked so, or those in it if it is not marked."""
    if mark == "rigid":
        return [Placed(np.eye(3), np.zeros(3), scene.triangles, scene.normals)]
    return [] if mark else scene.placed


def _objects(marks, scenes):
    """`Scene.objects` of meshes one after the other: what is marked is one object, others keep what they have; None: no objects.

    Their rigid objects (`Scene.placed`) get the last numbers.
    """
    owned = []
    for mark, scene in zip(marks, scenes):
        n = len(scene.triangles)
        none = np.zeros(n, np.int32)
        owned.append(np.ones(n, np.int32) if mark else none if scene.objects is None else scene.objects)
    built = [int(own.max(initial=0)) - len(scene.placed) for own, scene in zip(owned, scenes)]
    next_built, next_rigid, out = 0, sum(built), []
    for own, count, scene in zip(owned, built, scenes):
        number = np.where(own > count, own - count + next_rigid, own + next_built)
        out.append(np.where(own > 0, number, 0).astype(np.int32))
        next_built, next_rigid = next_built + count, next_rigid + len(scene.placed)
    return np.concatenate(out) if next_rigid else None


def _mesh_path(folder, name):
    """A mesh's file, next to the document or as it is named; or the name of one of our scenes."""
    path = Path(name)
    beside = folder / path
    return beside if beside.exists() or path.suffix or len(path.parts) > 1 else path
