# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scene files in, arrays out: every format, every way to be broken, normals, views, the unit box, our own scenes."""

import gzip
import io
import json
import math
import os
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from raycore import scene
from raycore.errors import OptionError, SceneError
from raycore.model import fp24

FOLDER = os.environ.get("RAYCORE_SCENES")

# Triangles in files that others published, as their authors or the archive state them.
PUBLISHED = {
    "CornellBox-Original.obj": 36,
    "CornellBox-Mirror.obj": 36,
    "CornellBox-Sphere.obj": 2188,
    "CornellBox-Water.obj": 7088,
    "DamagedHelmet.glb": 15452,
    "GlassHurricaneCandleHolder.glb": 4126,
    "GlassVaseFlowers.glb": 14036,
    "TransmissionRoughnessTest.glb": 77792,
    "TransmissionTest.glb": 128775,
    "bart_kitchen_t0.glb": 110561,
    "conference.ply": 331179,
    "sibenik.ply": 75284,
    "sibenik_textured.glb": 76529,
    "sponza_dabrovic.zip": 66454,
    "stanford_bunny.obj": 69451,
    "stanford_dragon_res2.ply.gz": 202520,
    "stanford_dragon_res3.ply": 47794,
    "suzanne.obj": 968,
    "teapot.obj": 6320,
    "usd_shaderball.glb": 63856,
}


def blob():
    """A lopsided mesh whose triangles all differ."""
    mesh = trimesh.creation.icosphere(subdivisions=2)
    mesh.vertices *= (1.0, 2.0, 3.0)
    mesh.vertices += 0.1 * np.sin(7.0 * mesh.vertices[:, ::-1])
    return mesh


def export(mesh, path, **options):
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.name.endswith(".ply.gz"):
        path.write_bytes(gzip.compress(mesh.export(file_type="ply")))
    else:
        mesh.export(path, **options)
    return path


# ---- formats ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name, options",
    [
        ("a.obj", {}),
        ("a.ply", {"encoding": "binary"}),
        ("b.ply", {"encoding": "ascii"}),
        ("a.ply.gz", {}),
        ("a.stl", {"file_type": "stl"}),
        ("b.stl", {"file_type": "stl_ascii"}),
        ("a.glb", {}),
        ("a.gltf", {}),
        ("UPPER.OBJ", {"file_type": "obj"}),
    ],
)
def test_formats(tmp_path, name, options):
    """Each format gives the mesh that was written, triangle by triangle."""
    mesh = blob()
    path = tmp_path / name
    if name == "a.gltf":
        for part, data in trimesh.Scene(mesh).export(file_type="gltf").items():
            (tmp_path / ("a.gltf" if part == "model.gltf" else part)).write_bytes(data)
    else:
        export(mesh, path, **options)
    s = scene.load_scene(path)
    assert s.triangles.shape == (len(mesh.faces), 3, 3)
    assert np.allclose(s.triangles, mesh.triangles, rtol=0, atol=2e-6)
    assert s.normals.shape == s.triangles.shape and np.allclose(np.linalg.norm(s.normals, axis=2), 1.0)
    assert s.face_material.max() < len(s.materials)


def test_order_is_that_of_trimesh(tmp_path):
    """Instances, nested and mirroring transforms: the same triangles in the same order as trimesh's concatenation."""
    world = trimesh.Scene()
    shape, other = blob(), trimesh.creation.box((1, 2, 3))
    rng = np.random.default_rng(5)
    for i in range(6):
        matrix = trimesh.transformations.random_rotation_matrix(rng.random(3))
        matrix[:3, 3] = rng.uniform(-9, 9, 3)
        if i % 2:
            matrix = matrix @ np.diag([1.0, -2.0, 0.5, 1.0])
        parent = f"n{i - 1}" if i in (2, 5) else None
        world.add_geometry(
            (shape, other)[i % 2], node_name=f"n{i}", geom_name=f"g{i % 2}", parent_node_name=parent, transform=matrix
        )
    path = tmp_path / "world.glb"
    world.export(path)
    want = trimesh.load(path, process=False).to_geometry().triangles
    got = scene.load_scene(path)
    assert np.array_equal(got.triangles, want)
    assert np.einsum("nij,nj->ni", got.normals, scene.face_normals(got.triangles)).min() > 0.3


def test_packed_files(tmp_path):
    """A scene with its material in a zip, a text file in a gz."""
    mtl, obj = b"newmtl red\nKd 1 0 0\n", b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"
    (tmp_path / "a.zip").write_bytes(packed({"in/m.obj": obj, "in/m.mtl": mtl, "readme.txt": b"hello"}))
    s = scene.load_scene(tmp_path / "a.zip")
    assert len(s.triangles) == 1 and np.allclose(s.materials[0].diffuse, (1, 0, 0)) and s.name == "a.zip"
    (tmp_path / "a.obj.gz").write_bytes(gzip.compress(obj))
    assert len(scene.load_scene(tmp_path / "a.obj.gz").triangles) == 1


def test_n_gons(tmp_path):
    """Polygons become triangles that cover them."""
    (tmp_path / "q.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    s = scene.load_scene(tmp_path / "q.obj")
    area = np.linalg.norm(
        np.cross(s.triangles[:, 1] - s.triangles[:, 0], s.triangles[:, 2] - s.triangles[:, 0]), axis=1
    )
    assert len(s.triangles) == 2 and area.sum() == pytest.approx(2.0)


@pytest.mark.skipif(not FOLDER, reason="RAYCORE_SCENES names no folder of meshes")
@pytest.mark.parametrize("name", PUBLISHED)
def test_published_meshes(name):
    """Published meshes have their published number of triangles, in trimesh's order, and keep their zero-area ones."""
    path = Path(FOLDER) / name
    if not path.exists():
        pytest.skip(f"no {name} there")
    s = scene.load_scene(path)
    assert len(s.triangles) == PUBLISHED[name]
    assert np.isfinite(s.normals).all() and np.allclose(np.linalg.norm(s.normals, axis=2), 1.0)
    unit = scene.normalise(s)
    assert len(unit.triangles) == len(s.triangles) and 0.5 <= np.abs(unit.triangles).max() <= 1.0
    if not name.endswith((".gz", ".zip")):
        mesh = trimesh.load(path, process=False)
        assert np.array_equal(s.triangles, (mesh.to_geometry() if hasattr(mesh, "to_geometry") else mesh).triangles)


# ---- what can be wrong -----------------------------------------------------------------------------------------------


def ply(vertices, faces=("3 0 1 2",)):
    header = (
        f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
    )
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    return (header + "\n".join([*vertices, *faces]) + "\n").encode()


def cut(mesh, file_type, part=0.6, **options):
    data = mesh.export(file_type=file_type, **options)
    return data[: int(part * len(data))]


def packed(files):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return out.getvalue()


BROKEN = {
    "empty.obj": (b"", "empty"),
    "empty.ply": (b"", "empty"),
    "mesh.xyz": (b"1 2 3", "not supported"),
    "mesh": (b"1 2 3", "not supported"),
    "mesh.blend": (b"BLENDER", "not supported"),
    "noise.glb": (bytes(range(256)) * 4, "cannot be read"),
    "noise.gltf": (b"\xff\xfe{", "cannot be read"),
    "noise.ply": (bytes(range(256)) * 4, "cannot be read"),
    "noise.ply.gz": (b"no gzip at all", "cannot be read"),
    "noise.stl": (bytes(range(256)) * 4, ""),
    "noise.obj": (bytes(range(256)) * 4, ""),
    "text.tar.gz": (gzip.compress(b"text"), "no scene file"),
    "none.zip": (lambda: packed({"a.txt": b"text"}), "no scene file"),
    "two.zip": (lambda: packed({"a.obj": b"v 0 0 0", "b/b.stl": b""}), "2 scene files"),
    "noise.zip": (bytes(range(256)) * 4, "cannot be read"),
    "nan.zip": (lambda: packed({"n.ply": ply(["0 0 0", "nan 0 0", "0 1 0"])}), "NaN"),
    "cut.glb": (lambda: cut(blob(), "glb"), "cannot be read"),
    "cut.ply": (lambda: cut(blob(), "ply"), ""),
    "cut.stl": (lambda: cut(blob(), "stl"), ""),
    "cut.ply.gz": (lambda: gzip.compress(blob().export(file_type="ply"))[:900], "cannot be read"),
    "only_points.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles"),
    "only_points.ply": (ply(["0 0 0", "1 0 0"], ()), "no triangles"),
    "no_mesh.gltf": (json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": []}]}).encode(), ""),
    "nan.ply": (ply(["0 0 0", "nan 0 0", "0 1 0"]), "NaN"),
    "inf.ply": (ply(["0 0 0", "inf 0 0", "0 1 0"]), "infinite"),
    "nan.obj": (b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", ""),
    "index.ply": (ply(["0 0 0", "1 0 0", "0 1 0"], ["3 0 1 7"]), ""),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", ""),
    "line.ply": (ply(["0 0 0", "1 1 1", "2 2 2"]), "area"),
    "point.ply": (ply(["1 1 1", "1 1 1", "1 1 1"]), "nothing to see"),
    "far.ply": (ply(["0 0 0", "1e35 0 0", "0 1e35 0"]), "rescale"),
    "small.ply": (ply(["0 0 0", "1e-36 0 0", "0 1e-36 0"]), "rescale"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files(tmp_path, name):
    """Each ends in one line that names the file and says what is wrong."""
    content, says = BROKEN[name]
    path = tmp_path / name
    path.write_bytes(content() if callable(content) else content)
    with pytest.raises(SceneError) as caught:
        scene.load_scene(path)
    text = str(caught.value)
    assert name in text and says in text and "\n" not in text and len(text) < 400


def test_missing_and_directories(tmp_path):
    for path in (tmp_path / "none.obj", "no_such_scene", "", tmp_path):
        with pytest.raises(SceneError) as caught:
            scene.load_scene(path)
        assert "\n" not in str(caught.value)


def test_stray_vertex(tmp_path):
    """One vertex so far away that everything else shrinks to a point: refused where nothing is left."""
    (tmp_path / "a.ply").write_bytes(ply(["0 0 0", "1e-6 0 0", "0 1e-6 0", "1e20 1e20 1e20"], ["3 0 1 2", "3 3 3 3"]))
    with pytest.raises(SceneError, match="stray vertex"):
        scene.normalise(scene.load_scene(tmp_path / "a.ply"))


def test_broken_generator(tmp_path):
    for body, says in (("def build(): return 1", "must return"), ("def build(): 1 / 0", "failed"), ("x = 1", "failed")):
        path = tmp_path / "gen.py"
        path.write_text(body)
        with pytest.raises(SceneError, match=says):
            scene.load_scene(path)


# ---- normals ---------------------------------------------------------------------------------------------------------


def test_smooth_normals_of_a_sphere():
    """On a sphere they point away from the centre."""
    mesh = trimesh.creation.icosphere(subdivisions=3)
    tris = np.asarray(mesh.triangles)
    assert np.allclose(scene.smooth_normals(tris), tris / np.linalg.norm(tris, axis=2, keepdims=True), atol=5e-3)


def test_creases_stay_sharp():
    """A box keeps its face normals, whatever the way its faces are wound."""
    tris = np.asarray(trimesh.creation.box().triangles).copy()
    tris[::3] = tris[::3, ::-1]
    assert np.allclose(scene.smooth_normals(tris), scene.face_normals(tris)[:, None])


def test_winding_does_not_matter():
    """Turning faces of a smooth mesh round turns their normals and changes nothing else."""
    tris = np.asarray(blob().triangles)
    mixed = tris.copy()
    mixed[::2] = mixed[::2, ::-1]
    a, b = scene.smooth_normals(tris), scene.smooth_normals(mixed)
    assert np.allclose(a[1::2], b[1::2]) and np.allclose(a[::2], -b[::2, ::-1])


def test_angle_weights():
    """A corner of a box, cut into unequal numbers of triangles, has the diagonal as its normal if creases may mix."""
    x, y, z, o = np.eye(3)[0], np.eye(3)[1], np.eye(3)[2], np.zeros(3)
    tris = np.array(
        [[o, x, x + y], [o, x + y, y], [o, y, z], [o, z, x]]
    )  # two triangles in one plane, one in the others
    normals = scene.smooth_normals(tris, crease_cos=-1.0)
    assert np.allclose(normals[0, 0], np.ones(3) / math.sqrt(3.0))


def test_degenerate_triangles_have_normals():
    tris = np.zeros((3, 3, 3))
    tris[0, 1, 0] = tris[0, 2, 1] = 1.0
    assert np.allclose(np.linalg.norm(scene.smooth_normals(tris), axis=2), 1.0)


def test_many_faces_at_a_point():
    """A fan of 20000 triangles does not take quadratic time."""
    angle = np.linspace(0, 2 * np.pi, 20001)
    rim = np.stack((np.cos(angle), np.sin(angle), np.zeros_like(angle)), axis=1)
    tris = np.stack((np.zeros((20000, 3)), rim[:-1], rim[1:]), axis=1)
    assert np.allclose(scene.smooth_normals(tris), (0, 0, 1))


def test_normals_of_the_file(tmp_path):
    """They are used, made unit, turned to their triangle's side; useless ones are replaced by the triangle's own."""
    (tmp_path / "n.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.6 0 0.8\nvn 0 -3 -4\nvn 0 0 0\nf 1//1 2//2 3//3\n")
    got = scene.load_scene(tmp_path / "n.obj").normals[0]
    assert np.allclose(got, [[0.6, 0, 0.8], [0, 0.6, 0.8], [0, 0, 1]], atol=1e-6)


def test_normals_under_uneven_scale(tmp_path):
    """Normals of a glTF file follow the inverse transpose of their node's transform."""
    sphere = trimesh.creation.icosphere(subdivisions=3)
    sphere.vertex_normals = sphere.vertices  # so that the file has normals
    world = trimesh.Scene()
    world.add_geometry(sphere, transform=np.diag([1.0, 3.0, 0.5, 1.0]))
    path = tmp_path / "s.glb"
    path.write_bytes(trimesh.exchange.gltf.export_glb(world, include_normals=True))
    s = scene.load_scene(path)
    want = s.triangles / np.square([1.0, 3.0, 0.5])  # gradient of the ellipsoid
    want /= np.linalg.norm(want, axis=2, keepdims=True)
    assert np.einsum("nij,nij->ni", s.normals, want).min() > 0.9999


# ---- materials -------------------------------------------------------------------------------------------------------


def test_mtl_materials(tmp_path):
    (tmp_path / "m.mtl").write_text(
        "newmtl red\nKd 1 0 0\nKs 0.2 0.2 0.2\nNs 64\nnewmtl lamp\nKd 0 0 0\nKe 1 0.8 0.6\n"
    )
    (tmp_path / "m.obj").write_text(
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 2 3\nusemtl lamp\nf 1 2 4\n"
    )
    s = scene.load_scene(tmp_path / "m.obj")
    by_name = {m.name: m for m in s.materials}
    red, lamp = by_name["red"], by_name["lamp"]
    assert np.allclose(red.diffuse, (1, 0, 0)) and np.allclose(red.specular, 0.2) and red.shininess == 64
    assert np.allclose(lamp.emission, (1.0, 0.8, 0.6)) and not any(lamp.ambient)
    used = [s.materials[i].name for i in s.face_material]
    flat = scene.face_normals(s.triangles)
    assert [used[np.argmax(np.abs(flat[:, a]))] for a in (2, 1)] == ["red", "lamp"]


def test_vertex_colours(tmp_path):
    """Colours become materials, and not more than fit."""
    mesh = trimesh.creation.icosphere(subdivisions=4)
    mesh.visual.vertex_colors = np.concatenate(
        ((mesh.vertices * 127 + 128).astype(np.uint8), np.full((len(mesh.vertices), 1), 255, np.uint8)), axis=1
    )
    s = scene.load_scene(export(mesh, tmp_path / "c.ply"))
    assert 16 < len(s.materials) <= scene.MAX_MATERIALS
    colour = np.array([m.diffuse for m in s.materials])[s.face_material]
    centre = s.triangles.mean(axis=1)
    for axis in range(3):
        assert np.corrcoef(colour[:, axis], centre[:, axis])[0, 1] > 0.85


def test_too_many_materials():
    """Where more materials come than fit, the rarest join the nearest in colour."""
    many = [scene.make_material(f"m{i}", (i / 1000.0, 0.5, 0.5)) for i in range(1000)]
    merged, index = scene.merge_materials(many, np.arange(1000))
    assert len(merged) == scene.MAX_MATERIALS
    got = np.array([merged[i].diffuse[0] for i in index])
    assert np.abs(got[:256] - np.arange(256) / 1000.0).max() < 1e-9 and got[999] == pytest.approx(0.255)


# ---- cameras and lights ----------------------------------------------------------------------------------------------


def test_gltf_camera_and_lights(tmp_path):
    """The first perspective camera and punctual lights, through nested transforms."""
    half = math.sqrt(0.5)
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0},
            {"translation": [1, 2, 3], "children": [2, 3, 4]},
            {"rotation": [0, half, 0, half], "camera": 1},  # a quarter turn about y: -z becomes -x
            {"translation": [0, 5, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"rotation": [-half, 0, 0, half], "extensions": {"KHR_lights_punctual": {"light": 1}}},  # -z becomes -y
        ],
        "cameras": [
            {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}},
            {"type": "perspective", "perspective": {"yfov": math.radians(30), "znear": 0.1}},
        ],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {
            "KHR_lights_punctual": {
                "lights": [
                    {"type": "point", "color": [1, 0.5, 0.25], "intensity": 100},
                    {"type": "directional", "intensity": 50},
                ]
            }
        },
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)}],
        "buffers": [{"uri": "b.bin", "byteLength": len(positions)}],
    }
    (tmp_path / "b.bin").write_bytes(positions)
    (tmp_path / "c.gltf").write_text(json.dumps(document))
    s = scene.load_scene(tmp_path / "c.gltf")
    assert np.allclose(s.camera.eye, (1, 2, 3)) and np.allclose(s.camera.target, (0, 2, 3))
    assert s.camera.fov == pytest.approx(30) and np.allclose(s.camera.up, (0, 1, 0))
    point, sun = s.lights
    assert np.allclose(point.position, (1, 7, 3)) and np.allclose(point.colour, (1, 0.5, 0.25))
    assert sun.directional and np.allclose(sun.position, (0, 1, 0)) and np.allclose(sun.colour, 0.5)
    assert scene.default_camera(s) is s.camera and scene.default_lights(s) is s.lights


@pytest.mark.parametrize("size", [(1, 1, 1), (10, 1, 1), (1, 10, 1), (1, 1, 10), (1e-6, 1e-6, 1e-6), (1e6, 1, 1e6)])
@pytest.mark.parametrize("name", ["a.ply", "a.stl"])
def test_default_view_frames_the_scene(tmp_path, size, name):
    """All of the box lies in the picture and nearly fills it, from the front, the right and above."""
    mesh = trimesh.creation.box(size)
    mesh.apply_translation((5, -3, 2))
    s = scene.load_scene(export(mesh, tmp_path / name))
    for aspect in (5 / 3, 1.0, 0.5):
        c = scene.default_camera(s, aspect)
        eye, target, up = map(np.asarray, (c.eye, c.target, c.up))
        view = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(view, up) / np.linalg.norm(np.cross(view, up))
        rel = s.triangles.reshape(-1, 3) - eye
        depth = rel @ view
        tan = math.tan(math.radians(c.fov) / 2)
        x, y = rel @ right / depth / tan / aspect, rel @ np.cross(right, view) / depth / tan
        assert depth.min() > 0 and 0.85 < max(np.abs(x).max(), np.abs(y).max()) <= 1.0
        assert view @ up < 0 and right[0] > 0
        for light in scene.default_lights(s, c):
            assert np.isfinite(light.position).all()


def test_parse_camera():
    c = scene.parse_camera("1,2,3:4,5,6:0,0,1:60")
    assert c == scene.Camera((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (0.0, 0.0, 1.0), 60.0)
    assert scene.parse_camera("1,2,3:4,5,6").fov == scene.DEFAULT_FOV
    for bad in ("", "1,2,3", "1,2:3,4,5", "a,b,c:1,2,3", "1,2,3:1,2,3", "0,0,0:0,1,0:0,1,0:60", "0,0,0:1,0,0:0,0,0:60"):
        with pytest.raises(OptionError):
            scene.parse_camera(bad)
    for bad in (
        "0,0,0:1,0,0:0,1,0:0",
        "0,0,0:1,0,0:0,1,0:180",
        "0,0,0:1,0,0:0,1,0:nan",
        "0,0,inf:1,0,0",
        "0,0,0:1,0,0:0,1,0:45:1",
    ):
        with pytest.raises(OptionError):
            scene.parse_camera(bad)


def test_parse_light():
    assert scene.parse_light("1,2,3") == scene.Light((1.0, 2.0, 3.0))
    assert scene.parse_light("1,2,3:0.5,0,1").colour == (0.5, 0.0, 1.0)
    for bad in ("", "1,2", "1,2,x", "1,2,3:1", "1,2,3:1,1,-1", "1,2,nan", "1,2,3:1,1,1:1", "1,2,3:1,1,1e9"):
        with pytest.raises(OptionError):
            scene.parse_light(bad)


# ---- the unit box ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-25, 1e-3, 1.0, 1024.0, 1e9, 1e25])
def test_unit_box(scale):
    """Power-of-two scale into [-1, 1], FP24 vertices, shared vertices shared, and back to world units."""
    tris = np.asarray(blob().triangles) * scale
    s = scene.Scene("s", tris, scene.smooth_normals(tris), np.zeros(len(tris), np.int32), [])
    unit = scene.normalise(s)
    assert 0.5 < np.abs(unit.triangles).max() <= 1.0 and not unit.dropped.any()
    assert np.array_equal(unit.triangles, fp24.round_to_fp24(unit.triangles))
    back = unit.to_world(unit.triangles)
    assert np.abs(back - tris).max() <= 2.0**-17 * 2.0**unit.scale_exp
    assert np.allclose(unit.to_world(unit.to_unit(tris)), tris, rtol=1e-12, atol=1e-12 * scale)
    assert unit.length_to_world(1.0) == 2.0**unit.scale_exp
    assert len(np.unique(unit.triangles.reshape(-1, 3), axis=0)) == len(np.unique(tris.reshape(-1, 3), axis=0))


def test_power_of_two_fills_the_box():
    """A scene whose half size is a power of two reaches exactly 1; a little more halves the scale."""
    for size, scale_exp in ((2.0, 0), (2.0000001, 1), (16.0, 3), (0.5, -2)):
        tris = np.asarray(trimesh.creation.box((size, size / 2, size / 4)).triangles)
        s = scene.Scene("s", tris, scene.smooth_normals(tris), np.zeros(len(tris), np.int32), [])
        assert scene.normalise(s).scale_exp == scale_exp


def test_far_from_the_origin():
    """A scene far away loses nothing: it is centred before it is rounded."""
    tris = np.asarray(blob().triangles) + 2.0**20
    s = scene.Scene("s", tris, scene.smooth_normals(tris), np.zeros(len(tris), np.int32), [])
    unit = scene.normalise(s)
    assert unit.scale_exp == 2 and not unit.dropped.any()


def test_dropped_triangles_keep_their_place():
    """Triangles without area after rounding are marked, not removed."""
    tris = np.asarray(blob().triangles).copy()
    tris[5] = tris[5, :1] + [[0, 0, 0], [1e-9, 0, 0], [0, 1e-9, 0]]
    tris[9, 2] = tris[9, 1]
    s = scene.Scene("s", tris, scene.smooth_normals(tris), np.zeros(len(tris), np.int32), [])
    unit = scene.normalise(s)
    assert np.array_equal(np.flatnonzero(unit.dropped), [5, 9]) and len(unit.triangles) == len(tris)


# ---- our own scenes --------------------------------------------------------------------------------------------------

LEAST = {"hall": 80_000, "organic": 60_000, "still_life": 20_000, "tiny": 10, "nasty": 100}


def test_names():
    assert set(LEAST) <= set(scene.scene_names())


@pytest.mark.parametrize("name", LEAST)
def test_own_scenes(name, tmp_path, monkeypatch):
    """Each builds, the same twice over, with a view and lights; the cache returns what was built."""
    monkeypatch.setattr(scene.generators, "CACHE", tmp_path)
    s = scene.load_scene(name)
    assert len(s.triangles) >= LEAST[name] and s.camera is not None and s.lights
    assert np.isfinite(s.triangles).all() and np.allclose(np.linalg.norm(s.normals, axis=2), 1.0)
    assert len(s.materials) <= scene.MAX_MATERIALS and s.face_material.max() < len(s.materials)
    files = list(tmp_path.glob("*.npz"))
    assert len(files) == 1
    kept = scene.load_scene(name)
    files[0].write_bytes(b"broken")
    again = scene.load_scene(name)
    for other in (kept, again):
        assert np.array_equal(s.triangles, other.triangles) and np.array_equal(s.normals, other.normals)
        assert (s.materials, s.camera, s.lights, s.background) == (
            other.materials,
            other.camera,
            other.lights,
            other.background,
        )


def test_tiny_is_tiny():
    assert len(scene.load_scene("tiny").triangles) < 100


def test_nasty_is_nasty():
    """It does hold what its description says."""
    s = scene.load_scene("nasty")
    unit = scene.normalise(s)
    assert (~scene.face_normals(s.triangles).any(axis=1)).sum() >= 80 and unit.dropped.sum() > 80
    assert len(np.unique(s.triangles.reshape(len(s.triangles), -1), axis=0)) < len(s.triangles) - 200


@pytest.mark.parametrize("name", ["organic", "still_life", "hall"])
def test_faces_look_outwards(name):
    """Corner normals lie on their triangle's side (the shading unit turns both by the triangle's own)."""
    s = scene.load_scene(name)
    assert np.einsum("nij,nj->ni", s.normals, scene.face_normals(s.triangles)).min() > 0.0
