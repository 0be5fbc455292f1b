# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scene files of our own: what they put together, and that each mistake is named with its place in one line."""

import copy
import json
import math
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from PIL import Image as Picture

from raycore.errors import SceneError
from raycore.image import check_material
from raycore.scene import Camera, Light, Material, face_normals, load_scene, scenefile
from raycore.scene.scenefile import SCHEMA, transform_matrix

TRIANGLE = "v 0 0 0\nv 2 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
CORNER = [[0, 0, 0], [2, 0, 0], [0, 1, 0]]


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "a.obj").write_text(TRIANGLE)
    (tmp_path / "b.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    (tmp_path / "b.obj").write_text(
        "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n"
    )
    Picture.fromarray(np.full((2, 2, 3), (255, 0, 0), np.uint8)).save(tmp_path / "red.png")
    return tmp_path


def load(folder, document, name="s.json"):
    (folder / name).write_text(json.dumps(document))
    return load_scene(folder / name)


FULL = {
    "$schema": "scene.schema.json",
    "name": "everything",
    "meshes": [
        {"file": "a.obj", "material": "new"},
        {"file": "b.obj", "transform": [{"scale": 2}, {"translate": [0, 0, 5]}]},
    ],
    "materials": {
        "new": {
            "ambient": [0.1, 0.1, 0.1],
            "diffuse": [0.2, 0.3, 0.4],
            "specular": [0.5, 0.5, 0.5],
            "shininess": 99.5,
            "emission": [2, 1, 0],
            "reflect": [0.1, 0.2, 0.3],
            "transmit": [0.4, 0.5, 0.6],
            "ior": 1.5,
            "fresnel": True,
            "texture": {"file": "red.png", "wrap_s": "clamp", "wrap_t": "mirror", "srgb": False, "compact": True},
            "tint_reflection": True,
        },
        "red": {"diffuse": [0, 1, 0], "alpha": 0.5, "alpha_mode": "blend"},
    },
    "lights": [
        {"position": [1, 2, 3], "colour": [1, 0.5, 0.25], "attenuation": [1, 0.5, 0.1]},
        {"direction": [0, 2, 0]},
    ],
    "camera": {"eye": [0, 0, 9], "target": [0, 0, 0], "up": [1, 0, 0], "fov": 33},
    "background": [0, 0.5, 2],
    "up": [0, 0, 1],
    "depth": 7,
}


def test_everything(folder):
    s = load(folder, FULL)
    assert (s.name, s.depth, s.background, s.up) == ("everything", 7, (0, 0.5, 2), (0, 0, 1)) and s.warnings == []
    assert s.camera == Camera((0, 0, 9), (0, 0, 0), (1, 0, 0), 33)
    assert s.lights == [Light((1, 2, 3), (1, 0.5, 0.25), False, (1, 0.5, 0.1)), Light((0, 2, 0), directional=True)]
    by_name = {m.name: m for m in s.materials}
    new, values = by_name["new"], FULL["materials"]["new"]
    for name in ("ambient", "diffuse", "specular", "emission", "reflect", "transmit"):
        assert getattr(new, name) == tuple(values[name])
    assert (new.shininess, new.ior, new.fresnel, new.tint_reflection) == (99.5, 1.5, True, True)
    t = new.texture
    assert (t.wrap_s, t.wrap_t, t.srgb, t.compact) == ("clamp", "mirror", False, True) and t.image[0, 0].tolist() == [
        255,
        0,
        0,
        255,
    ]
    assert by_name["red"].diffuse == (0, 1, 0) and np.allclose(by_name["red"].ambient, (0, 0.12, 0))
    assert (by_name["red"].alpha, by_name["red"].alpha_mode) == (0.5, "blend")
    assert by_name["blue"].diffuse == (0, 0, 1), "not named, not changed"
    assert np.allclose(s.triangles[0], CORNER)
    found = {s.materials[m].name: t for m, t in zip(s.face_material, s.triangles)}
    assert np.allclose(found["red"], [[0, 0, 5], [2, 0, 5], [0, 2, 5]])
    assert s.uv.shape == (3, 3, 2) and np.allclose(s.uv[0], [[0, 1], [1, 1], [0, 0]]), "v grows downwards"


def test_every_material_field_can_be_given():
    schema = json.loads(SCHEMA.read_text())["$defs"]["material"]["properties"]
    assert set(schema) == set(Material.__dataclass_fields__) - {"name"}
    jsonschema.Draft202012Validator.check_schema(json.loads(SCHEMA.read_text()))


def test_our_scenes_and_other_scene_files(folder):
    """Meshes may be scenes by name or scene files; their views are used where the document says nothing."""
    inner = load(folder, {"meshes": [{"file": "tiny"}], "depth": 3}, "inner.json")
    tiny = load_scene("tiny")
    assert (
        np.array_equal(inner.triangles, tiny.triangles) and inner.camera == tiny.camera and inner.lights == tiny.lights
    )
    moved = [{"translate": [0, 10, 0]}]
    outer = load(folder, {"meshes": [{"file": "inner.json", "transform": moved}, {"file": "a.obj"}]}, "outer.json")
    assert len(outer.triangles) == len(tiny.triangles) + 1 and outer.depth == 3
    assert np.allclose(outer.camera.eye, np.add(tiny.camera.eye, (0, 10, 0)))
    assert np.allclose(outer.lights[0].position, np.add(tiny.lights[0].position, (0, 10, 0)))


def test_transforms():
    """Steps apply from the first to the last; turns are counter-clockwise, seen against the axis."""

    def at(steps, p=(1, 0, 0)):
        return (transform_matrix(steps) @ (*p, 1))[:3]

    turn = {"rotate": {"axis": [0, 0, 5], "degrees": 90}}
    assert np.allclose(at([turn]), (0, 1, 0)) and np.allclose(at([turn], (0, 0, 3)), (0, 0, 3))
    assert np.allclose(at([{"translate": [1, 0, 0]}, turn]), (0, 2, 0))
    assert np.allclose(at([turn, {"translate": [1, 0, 0]}]), (1, 1, 0))
    assert np.allclose(at([{"scale": [2, 3, 4]}, {"scale": 0.5}], (1, 1, 1)), (1, 1.5, 2))
    matrix = [0, 0, 1, 7, 0, 1, 0, 8, 1, 0, 0, 9, 0, 0, 0, 1]
    assert np.allclose(at([{"matrix": matrix}], (1, 2, 3)), (10, 10, 10))
    diagonal = {"rotate": {"axis": [1, 1, 1], "degrees": 120}}
    assert np.allclose(at([diagonal]), (0, 1, 0))


def test_moved_scenes_keep_their_sides(folder):
    """A mirroring transform turns triangles round, so that what was outside stays outside; coordinates follow."""
    s = load(
        folder,
        {
            "meshes": [
                {"file": "a.obj"},
                {"file": "a.obj", "transform": [{"scale": [1, 1, -1]}, {"translate": [0, 0, -1]}]},
            ]
        },
    )
    flat = face_normals(s.triangles)
    assert np.allclose(flat, [[0, 0, 1], [0, 0, -1]])
    assert np.einsum("nij,nj->ni", s.normals, flat).min() > 0.99
    order = [np.flatnonzero((s.triangles[1, :, :2] == p[:2]).all(axis=1))[0] for p in CORNER]
    assert np.allclose(s.uv[1][order], s.uv[0])


def test_normals_follow_the_inverse_transpose(folder):
    (folder / "n.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.6 0 0.8\nf 1//1 2//1 3//1\n")
    s = load(folder, {"meshes": [{"file": "n.obj", "transform": [{"scale": [2, 1, 1]}]}]})
    want = np.array([0.3, 0, 0.8]) / math.hypot(0.3, 0.8)
    assert np.allclose(s.normals[0], want)


def test_attenuation_follows_the_scale(folder):
    lamp = {"meshes": [{"file": "a.obj"}], "lights": [{"position": [0, 0, 1], "attenuation": [1, 2, 3]}]}
    load(folder, lamp, "lamp.json")
    s = load(folder, {"meshes": [{"file": "lamp.json", "transform": [{"scale": 10}]}]})
    assert np.allclose(s.lights[0].position, (0, 0, 10)) and np.allclose(s.lights[0].attenuation, (1, 0.2, 0.03))


def test_texture_by_name_alone(folder):
    """The file of a cow and its picture, which no MTL joins."""
    document = {
        "meshes": [{"file": "a.obj", "material": "skin"}],
        "materials": {"skin": {"diffuse": [1, 1, 1], "texture": "red.png"}},
    }
    s = load(folder, document)
    assert s.materials[0].texture.name == "red.png" and s.uv is not None
    document["meshes"][0]["file"] = "b.obj"
    s = load(folder, document)
    assert (
        s.materials[0].texture is None
        and np.allclose(s.materials[0].diffuse, (1, 0, 0))
        and "coordinates" in s.warnings[0]
    )


def test_notes_of_meshes_name_them(folder):
    (folder / "c.obj").write_text("mtllib none.mtl\n" + TRIANGLE)
    assert "c.obj: " in load(folder, {"meshes": [{"file": "c.obj"}]}).warnings[0]


def changed(*path, value=None, remove=False):
    """FULL with one place changed."""
    document = copy.deepcopy(FULL)
    place = document
    for key in path[:-1]:
        place = place[key]
    if remove:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return document


WRONG = [
    ([], "the document: .* is not of type 'object'"),
    ({}, "'meshes' is a required property"),
    ({"meshes": []}, "meshes: "),
    (changed("colour", value="red"), "'colour' was unexpected"),
    (changed("depth", value=16), "depth: 16 is greater than the maximum of 15"),
    (changed("depth", value=1.5), "depth: 1.5 is not of type 'integer'"),
    (changed("camera", "fov", value=180), "camera.fov: 180 is greater"),
    (changed("camera", "eye", value=[0, 0]), "camera.eye: .* too short"),
    (changed("camera", "eye", value=[0, 0, 0]), "camera: eye and target are the same point"),
    (changed("camera", "up", value=[0, 0, 1]), "camera: up is zero or points along the view"),
    (changed("camera", "target", remove=True), "camera: 'target' is a required property"),
    (changed("lights", 0, "direction", value=[0, 1, 0]), r"lights\[0\]: give either position or direction"),
    (changed("lights", 1, value={"colour": [1, 1, 1]}), r"lights\[1\]: give either position or direction"),
    (changed("lights", 1, "direction", value=[0, 0, 0]), r"lights\[1\]: its direction is zero"),
    (changed("lights", 0, "attenuation", value=[0, 0, 0]), r"lights\[0\]: its attenuation divides by zero"),
    (changed("lights", value=[{"position": [0, 0, 1]}] * 17), "lights: .* too long"),
    (changed("background", value=[0, 0, -1]), r"background\[2\]: -1 is less"),
    (changed("meshes", 0, "file", remove=True), r"meshes\[0\]: 'file' is a required property"),
    (changed("meshes", 0, "file", value="none.obj"), "none.obj: no such file"),
    (changed("meshes", 0, "file", value="no_such_scene"), "no_such_scene: no such file"),
    (changed("meshes", 0, "material", value="old"), r"meshes\[0\].material: no 'old' in materials"),
    (
        changed("meshes", 1, "transform", 0, value={"scale": 2, "translate": [0, 0, 0]}),
        r"meshes\[1\].transform\[0\]: .* too many",
    ),
    (
        changed("meshes", 1, "transform", 0, value={"scale": 0}),
        r"meshes\[1\].transform: the transform makes everything flat",
    ),
    (changed("meshes", 1, "transform", 0, value={"scale": "big"}), r"meshes\[1\].transform\[0\].scale: 'big' is not"),
    (
        changed("meshes", 1, "transform", 0, value={"rotate": {"axis": [0, 0, 0], "degrees": 1}}),
        "axis of a rotation is zero",
    ),
    (changed("meshes", 1, "transform", 0, value={"matrix": [1] * 16}), "last row of a matrix"),
    (changed("meshes", 1, "transform", 0, value={"shear": 1}), "'shear' was unexpected"),
    (
        changed("materials", "green", value={}),
        "materials.green: no mesh has a material of this name; there are: blue, new, red",
    ),
    (
        changed("materials", "new", "shininess", value=2000),
        "materials.new.shininess: 2000 is greater than the maximum of 1024",
    ),
    (changed("materials", "new", "reflect", value=[2, 0, 0]), r"materials.new.reflect\[0\]: 2 is greater"),
    (changed("materials", "new", "alpha_mode", value="glass"), "materials.new.alpha_mode: 'glass' is not one of"),
    (
        changed("materials", "new", "texture", value="none.png"),
        r"materials.new: texture none.png: cannot be read \(No such file",
    ),
    (changed("materials", "new", "texture", value="a.obj"), "materials.new: texture a.obj: cannot be read"),
    (changed("materials", "new", "texture", "wrap_s", value="twist"), "materials.new.texture.wrap_s: 'twist'"),
    (
        changed("materials", "new", "texture", "file", remove=True),
        "materials.new.texture: 'file' is a required property",
    ),
]


@pytest.mark.parametrize("document, says", WRONG, ids=[says[:40] for _, says in WRONG])
def test_mistakes(folder, document, says):
    with pytest.raises(SceneError, match=says) as caught:
        load(folder, document)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 500 and ("s.json" in text or "no such file" in text)


@pytest.mark.parametrize(
    "text, says",
    [
        ("{", "no JSON at line 1, column 2"),
        ('{"meshes": [{"file": "a.obj"}],\n}', "no JSON at line 2"),
        ('{"meshes": [{"file": "a.obj"}], "background": [0, NaN, 0]}', "NaN is no number of JSON"),
        ("\ud800".encode("utf-8", "surrogatepass"), "no JSON"),
        ("[" * 100_000, "no JSON"),
        ("", "no JSON at line 1"),
    ],
)
def test_no_json(folder, text, says):
    (folder / "s.json").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(SceneError, match=says) as caught:
        load_scene(folder / "s.json")
    assert "\n" not in str(caught.value) and "s.json" in str(caught.value)


def test_circles(folder):
    (folder / "a.json").write_text('{"meshes": [{"file": "b.json"}]}')
    (folder / "b.json").write_text('{"meshes": [{"file": "a.json"}]}')
    with pytest.raises(SceneError, match="in a circle"):
        load_scene(folder / "a.json")


def test_limits_of_materials_agree():
    """What the schema lets pass, the records can hold."""
    limits = json.loads(SCHEMA.read_text())["$defs"]["material"]["properties"]
    for name in ("shininess", "ior"):
        for bound in ("minimum", "maximum"):
            check_material(Material("m", (0, 0, 0), (0, 0, 0), **{name: float(limits[name][bound])}), "test")
    assert scenefile.COLOURS == ("ambient", "diffuse", "specular", "emission", "reflect", "transmit")


def test_the_example_of_the_documentation():
    """It follows the schema, and so does the mesh that moves."""
    text = (Path(__file__).resolve().parents[1] / "docs/scenes.md").read_text()
    example, mesh = re.findall(r"```json\n(.*?)```", text, re.DOTALL)
    validator = jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text()))
    validator.validate(json.loads(example))
    validator.validate({"meshes": [json.loads(mesh)]})
