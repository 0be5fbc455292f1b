# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Our own scenes, built by Python: run once, kept in `build/scenes` until the text that shapes them changes."""

import contextlib
import hashlib
import importlib.util
import json
import os
from pathlib import Path

import numpy as np

from raycore.errors import SceneError
from raycore.scene.data import Camera, Light, Material, Scene, Texture
from raycore.scene.files import check_triangles, reason

ROOT = Path(__file__).resolve().parents[3]
FOLDER = ROOT / "scenes"
CACHE = ROOT / "build" / "scenes"
# What a generator may use, of this package: its result depends on them.
SHAPERS = ("scene/data.py", "scene/normals.py", "shapes.py", "furniture.py", "patterns.py")
ARRAYS = ("triangles", "normals", "face_material", "uv")


def scene_names():
    """Names of the generators and scene files in `scenes/`."""
    return sorted(p.stem for p in FOLDER.iterdir() if p.suffix in (".py", ".json") and not p.stem.startswith("_"))


def _save(scene, path):
    """Keep a generated scene; a cache that cannot be written is no error."""
    textures = list(dict.fromkeys(m.texture for m in scene.materials if m.texture is not None))

    def values(thing):
        return {k: v for k, v in vars(thing).items() if k not in ("image", "_digest")}

    views = {
        "name": scene.name,
        "materials": [
            vars(m) | {"texture": None if m.texture is None else textures.index(m.texture)} for m in scene.materials
        ],
        "textures": [values(t) for t in textures],
        "camera": vars(scene.camera) if scene.camera else None,
        "lights": [vars(light) for light in scene.lights],
        "up": scene.up,
        "background": scene.background,
        "warnings": scene.warnings,
        "depth": scene.depth,
    }
    arrays = {n: getattr(scene, n) for n in ARRAYS if getattr(scene, n) is not None}
    arrays |= {f"image{i}": t.image for i, t in enumerate(textures)}
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(f".{os.getpid()}.npz")
        with part.open("wb") as stream:
            np.savez(stream, views=np.frombuffer(json.dumps(views).encode(), np.uint8), **arrays)
        for old in path.parent.glob(f"{path.stem.rsplit('-', 1)[0]}-*.npz"):
            if old not in (part, path):
                old.unlink()
        part.replace(path)


def _restore(path):
    with np.load(path) as data:
        views = json.loads(data["views"].tobytes())

        def thing(kind, values, **more):
            return kind(**{k: tuple(v) if isinstance(v, list) else v for k, v in values.items()} | more)

        textures = [thing(Texture, t, image=data[f"image{i}"]) for i, t in enumerate(views["textures"])]
        materials = [
            thing(Material, m, texture=None if m["texture"] is None else textures[m["texture"]])
            for m in views["materials"]
        ]
        return Scene(
            name=views["name"],
            materials=materials,
            camera=thing(Camera, views["camera"]) if views["camera"] else None,
            lights=[thing(Light, light) for light in views["lights"]],
            up=tuple(views["up"]),
            background=tuple(views["background"]),
            warnings=views["warnings"],
            depth=views["depth"],
            **{n: data[n] for n in ARRAYS if n in data.files},
        )


def _key(path):
    """Hash of all that shapes a generated scene."""
    package = Path(__file__).resolve().parents[1]
    shapers = [*(package / name for name in SHAPERS), *sorted(path.parent.glob("_*.py"))]
    text = path.read_bytes() + b"".join(p.read_bytes() for p in shapers if p.is_file()) + Path(__file__).read_bytes()
    return hashlib.sha256(text).hexdigest()[:16]


def load_generator(path):
    """Run a generator, or take its scene from the cache. Raises: SceneError."""
    cached = CACHE / f"{path.stem}-{_key(path)}.npz"
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
        raise SceneError(f"{path}: the generator failed ({reason(error)})") from None
    if not isinstance(scene, Scene):
        raise SceneError(f"{path}: build() must return a raycore.scene.Scene")
    check_triangles(scene.triangles, path)
    _save(scene, cached)
    return scene
