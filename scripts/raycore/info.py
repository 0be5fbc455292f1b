# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What a scene takes: its triangles, its tree, its bytes in memory."""

import time

import numpy as np

from raycore.image import build_geometry, build_image
from raycore.scene import load_scene


def scene_info(name):
    """Figures of a scene, by name, ready for JSON. Raises: SceneError."""
    began = time.perf_counter()
    scene = load_scene(name)
    loaded = time.perf_counter() - began
    image = build_image(build_geometry(scene))
    geometry = image.geometry
    tree = geometry.tree.stats
    sizes = {region: size for region, size in image.sizes.items() if region != "frame"}
    return {
        "scene": scene.name,
        "triangles": len(scene.triangles),
        "without_area": int(np.count_nonzero(geometry.unit.dropped)),
        "bounds": scene.bounds.tolist(),
        "half_size": 2.0**geometry.unit.scale_exp,
        "materials": len(scene.materials),
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
    }


def rows(values):
    """(what, figure) pairs for people."""
    lo, hi = values["bounds"]
    v = values
    out = [
        ("scene", v["scene"]),
        ("triangles", f"{v['triangles']:,} ({v['without_area']:,} without area at 24 bits)"),
        ("bounds", " to ".join("(" + ", ".join(f"{x:g}" for x in p) + ")" for p in (lo, hi))),
        ("materials", f"{v['materials']}"),
        ("in the file", f"{v['lights_in_file']} lights, {'a' if v['camera_in_file'] else 'no'} camera"),
        ("nodes", f"{v['nodes']:,} and {v['padding_nodes']:,} of padding"),
        ("leaves", f"{v['leaves']:,}, and {v['empty_leaves']:,} empty ones that take no memory"),
        ("depth", f"{v['depth']}"),
        ("largest leaf", f"{v['largest_leaf']} triangles"),
        ("SAH cost", f"{v['sah_cost']:.2f}"),
        ("list entries", f"{v['list_entries']:,}"),
    ]
    out += [(f"bytes, {region}", f"{size:,}") for region, size in v["bytes"].items()]
    return out + [(f"seconds, {step}", f"{s:.2f}") for step, s in v["seconds"].items()]
