# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scene files to arrays: triangles, normals, materials, cameras and lights, and their way into the unit box.

Formats: glTF and GLB, OBJ, PLY, STL, AFF (BART), also inside `.gz` or `.zip`; scene files of our own (`.json`); and generators in
`scenes/`. Triangles keep the order in which trimesh concatenates the geometry of a scene; none is merged, dropped or
turned.
"""

from dataclasses import replace
from pathlib import Path

from raycore.errors import SceneError
from raycore.scene import generators
from raycore.scene.data import (
    AMBIENT_LIGHT,
    DEFAULT_FOV,
    MAX_MATERIALS,
    Camera,
    Light,
    Material,
    Scene,
    Texture,
    make_material,
)
from raycore.scene.files import MAX_TRIANGLES, PACKED, SUFFIXES, choices, load_file
from raycore.scene.generators import load_generator, scene_names
from raycore.scene.materials import flatten, merge_materials, read_picture
from raycore.scene.normals import CREASE_COS, face_normals, orient_normals, smooth_normals
from raycore.scene.scenefile import load_document
from raycore.scene.unitbox import Normalised, normalise
from raycore.scene.views import default_camera, default_lights, parse_camera, parse_light

__all__ = [
    "AMBIENT_LIGHT",
    "CREASE_COS",
    "DEFAULT_FOV",
    "MAX_MATERIALS",
    "MAX_TRIANGLES",
    "PACKED",
    "SUFFIXES",
    "Camera",
    "Light",
    "Material",
    "Normalised",
    "Scene",
    "Texture",
    "compact_textures",
    "default_camera",
    "default_lights",
    "face_normals",
    "flatten",
    "load_scene",
    "make_material",
    "merge_materials",
    "normalise",
    "orient_normals",
    "parse_camera",
    "parse_light",
    "read_picture",
    "scene_names",
    "smooth_normals",
    "without_textures",
]


def load_scene(path, time=0.0):
    """Load a scene.

    Args: path of a file (`SUFFIXES`, `PACKED`, `.json`), of a generator (`.py` with `build() -> Scene`), or the name of
        one of either kind in `scenes/`; time: in seconds, for what moves in scene files.
    Returns: `Scene`; its warnings say what could not be mapped.
    Raises: SceneError with one line: what is wrong, where, and what to do.
    """
    return _load(Path(path), (), time)


def _load(path, within, time):
    """Load a scene; within: the scene files that name it."""
    try:
        if not path.exists() and path.parent == Path() and not path.suffix:
            named = (generators.FOLDER / f"{path}{suffix}" for suffix in (".py", ".json"))
            path = next((p for p in named if p.exists()), path)
        if path.is_dir():
            raise SceneError(f"{path}: is a directory; give {choices()}")
        if not path.exists():
            ours = ", ".join(scene_names()) or "none"
            raise SceneError(f"{path}: no such file, and no scene of that name; ours are: {ours}")
        suffix = path.suffix.lower()
        if suffix == ".py":
            return load_generator(path)
        if suffix == ".json":
            return load_document(path, _load, within, time)
        if suffix not in SUFFIXES + PACKED:
            raise SceneError(f"{path}: '{suffix or 'no suffix'}' is not supported; convert it to {choices()}")
        return load_file(path, time)
    except OSError as error:
        raise SceneError(f"{path}: cannot be read ({error.strerror or error})") from None
    except MemoryError:
        raise SceneError(f"{path}: does not fit into this machine's memory; simplify the mesh") from None


def without_textures(scene):
    """The scene with each texture replaced by its mean colour."""
    return replace(scene, materials=[flatten(m) for m in scene.materials], uv=None)


def compact_textures(scene):
    """The scene with textures of 16 bits a texel."""
    compact = {m.texture: replace(m.texture, compact=True) for m in scene.materials if m.texture is not None}
    return replace(scene, materials=[replace(m, texture=compact.get(m.texture)) for m in scene.materials])
