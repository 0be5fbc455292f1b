# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What a scene takes: its triangles, its tree, its bytes in memory."""

import time

import numpy as np

from raycore import tbu
from raycore.image import OPTICS, build_geometry, build_image, unpack_records
from raycore.objects import shapes_of, stored
from raycore.scene import compact_textures, load_scene, without_textures


def kind_of(material):
    """What a material is, in a word: mirror, glass, blended, masked or plain."""
    if any(material.transmit):
        return "glass"
    if material.alpha_mode != "opaque":
        return {"mask": "masked", "blend": "blended"}[material.alpha_mode]
    return "mirror" if any(material.reflect) else "plain"


def _textures(geometry):
    """The textures of a scene as they lie in memory."""
    by_texture = {m.texture: i for i, m in enumerate(geometry.scene.materials) if m.texture is not None}
    fields = unpack_records(OPTICS, geometry.materials[:, 8:])
    return [
        {
            "name": texture.name,
            "size": [1 << int(fields["log2_w"][i]), 1 << int(fields["log2_h"][i])],
            "levels": int(fields["levels"][i]),
            "format": "RGBA5551" if texture.compact else "RGBA8",
            "wrap": [texture.wrap_s, texture.wrap_t],
        }
        for texture, i in by_texture.items()
        if len(geometry.textures)
    ]


def _objects(scene):
    """What a scene's dynamic objects are, and how many triangles memory holds of it where the unit builds; None: it has none."""
    if scene.objects is None:
        return None
    kept, _, places, _ = stored(scene, tbu.snap(scene))
    return {
        "built": int(scene.objects.max()) - len(places),
        "placed": len(places),
        "shapes": len(shapes_of(places)),
        "triangles_in_memory": len(kept.triangles),
    }


def scene_info(name, textures=True, compact=False):
    """Figures of a scene, by name, ready for JSON. textures, compact: as options of `raycore render`. Raises: SceneError."""
    began = time.perf_counter()
    scene = load_scene(name)
    scene = scene if textures else without_textures(scene)
    scene = compact_textures(scene) if compact else scene
    loaded = time.perf_counter() - began
    image = build_image(build_geometry(scene))
    geometry = image.geometry
    tree = geometry.tree.stats
    sizes = {region: size for region, size in image.sizes.items() if region != "frame"}
    kinds, faces = {}, np.bincount(scene.face_material, minlength=len(scene.materials))
    for material, count in zip(scene.materials, faces):
        entry = kinds.setdefault(kind_of(material), {"materials": 0, "textured": 0, "triangles": 0})
        entry["materials"] += 1
        entry["textured"] += material.texture is not None
        entry["triangles"] += int(count)
    return {
        "scene": scene.name,
        "triangles": len(scene.triangles),
        "without_area": int(np.count_nonzero(geometry.unit.dropped)),
        "bounds": scene.bounds.tolist(),
        "objects": _objects(scene),
        "half_size": 2.0**geometry.unit.scale_exp,
        "materials": len(scene.materials),
        "materials_by_kind": kinds,
        "textures": _textures(geometry),
        "default_depth": image.view.max_depth,
        "lights_in_file": len(scene.lights),
        "camera_in_file": scene.camera is not None,
        "nodes": tree["node_count"],
        "leaves": tree["leaf_count"],
        "empty_leaves": tree["empty_leaf_count"],
        "padding_nodes": tree["padding"],
        "depth": tree["depth"],
        "largest_leaf": tree.get("largest_leaf", 0),
        "sah_cost": tree["sah_cost"],
        "list_entries": tree["list_entries"],
        "bytes": sizes | {"total": sum(sizes.values())},
        "seconds": {n: round(s, 3) for n, s in ({"load": loaded} | geometry.seconds).items()},
        "warnings": [*scene.warnings, *geometry.notes],
    }


def rows(values):
    """(what, figure) pairs for people."""
    lo, hi = values["bounds"]
    v = values
    out = [
        ("scene", v["scene"]),
        ("triangles", f"{v['triangles']:,} ({v['without_area']:,} without area at 24 bits)"),
        ("bounds", " to ".join("(" + ", ".join(f"{x:g}" for x in p) + ")" for p in (lo, hi))),
        ("materials", f"{v['materials']}: " + ", ".join(_kind(*item) for item in v["materials_by_kind"].items())),
        *(
            (f"texture {i}", f"{t['name']}, {t['size'][0]}x{t['size'][1]}, {t['levels']} levels, {t['format']}")
            for i, t in enumerate(v["textures"])
        ),
        *([("dynamic objects", _moving(v["objects"]))] if v["objects"] else []),
        ("in the file", f"{v['lights_in_file']} lights, {'a' if v['camera_in_file'] else 'no'} camera"),
        ("default depth", f"{v['default_depth']} bounces"),
        ("nodes", f"{v['nodes']:,} and {v['padding_nodes']:,} of padding"),
        ("leaves", f"{v['leaves']:,}, and {v['empty_leaves']:,} empty ones that take no memory"),
        ("depth of the tree", f"{v['depth']}"),
        ("largest leaf", f"{v['largest_leaf']} triangles"),
        ("SAH cost", f"{v['sah_cost']:.2f}"),
        ("list entries", f"{v['list_entries']:,}"),
    ]
    out += [(f"bytes, {region}", f"{size:,}") for region, size in v["bytes"].items()]
    return out + [(f"seconds, {step}", f"{s:.2f}") for step, s in v["seconds"].items()]


def _moving(entry):
    text = f"{entry['built']} built for each picture"
    if entry["placed"]:
        text += f", {entry['placed']} placed, of {entry['shapes']} shapes: {entry['triangles_in_memory']:,} triangles in memory"
    return text


def _kind(kind, entry):
    textured = f", {entry['textured']} with a texture" if entry["textured"] else ""
    return f"{entry['materials']} {kind} ({entry['triangles']:,} triangles{textured})"
