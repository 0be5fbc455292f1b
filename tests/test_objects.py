# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scenes with dynamic objects, built anew or placed: what a scene file says, trees, places in memory, and frames of the RTL."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from raycore import accel, check, dynamic, image, info, kdtree, objects, render, sim, tbu
from raycore.errors import SceneError
from raycore.image import View, build_geometry, build_image
from raycore.model import fp24, frame, rgen, tracer
from raycore.model.frame import decode_tree, render_double, render_fp24
from raycore.scene import load_scene

TENT = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1 0\nf 1 3 2\nf 1 4 3\nf 1 5 4\nf 2 5 1\nf 3 5 2\n"
ERR_INST = 16


def tent(at, size=0.3, **more):
    return {"file": "tent.obj", "transform": [{"scale": size}, {"translate": at}], **more}


@pytest.fixture
def write(tmp_path):
    """Write a scene file with these meshes: its path."""
    (tmp_path / "tent.obj").write_text(TENT)

    def make(name, *meshes, **more):
        path = tmp_path / f"{name}.json"
        path.write_text(json.dumps({"meshes": list(meshes)} | more))
        return path

    return make


@pytest.fixture
def lively(write):
    """Mirrors, glass and masks that stand still, and three tents: two of which overlap, one of glass."""
    glass = {"transmit": [0.9, 0.9, 0.9], "ior": 1.5}
    return write(
        "lively",
        tent([0.2, 0.5, 0.2], dynamic=True, animation={"keys": [{"time": 0}, {"time": 1, "translate": [0, 0.5, 0]}]}),
        {"file": "tiny_glass"},
        tent([-0.5, 0.2, 0.4], 0.5, dynamic=True),
        tent([-0.4, 0.3, 0.5], 0.5, dynamic=True, material="clear"),
        materials={"clear": glass},
    )


def turned(at, axis=(1, 2, 3), degrees=50.0, size=0.3, **more):
    """A tent that is turned, a rigid object if nothing else is said."""
    steps = [{"scale": size}, {"rotate": {"axis": list(axis), "degrees": degrees}}, {"translate": at}]
    return {"file": "tent.obj", "transform": steps, "dynamic": "rigid", **more}


@pytest.fixture
def placed(write):
    """As `lively`, but all objects but one are rigid: of one shape three, one of which is of glass, and one that is larger."""
    glass = {"transmit": [0.9, 0.9, 0.9], "ior": 1.5}
    rise = {"keys": [{"time": 0}, {"time": 1, "translate": [0, 0.5, 0], "rotate": {"axis": [1, 0, 0], "degrees": 80}}]}
    return write(
        "placed",
        turned([0.2, 0.5, 0.2], animation=rise),
        {"file": "tiny_glass"},
        turned([-0.5, 0.4, 0.4], (0, 1, 0), 200.0),
        tent([0.5, 0.2, 0.5], 0.4, dynamic=True),
        turned([-0.4, 0.5, 0.5], (1, 0, 1), 30.0, material="clear"),
        turned([0.3, 0.9, -0.3], (3, 0, 1), -70.0, 0.5),
        materials={"clear": glass},
    )


def test_scene_file(lively, write):
    """Static triangles first, then object by object; objects of scene files within scene files stay objects."""
    scene = load_scene(lively)
    assert np.bincount(scene.objects).tolist() == [114, 5, 5, 5] and (np.diff(scene.objects) >= 0).all()
    plain = load_scene("tiny_glass")
    assert (scene.triangles[:114] == plain.triangles).all() and (scene.uv[:114] == plain.uv).all()
    assert len(set(scene.face_material[124:])) == 1 and scene.materials[scene.face_material[-1]].name == "clear"
    inner = write("inner", tent([0, 0, 0], dynamic=True), tent([1, 0, 0]))
    outer = load_scene(write("outer", {"file": inner.name}, tent([2, 0, 0], dynamic=True), {"file": inner.name, "dynamic": True}))
    assert np.bincount(outer.objects).tolist() == [5, 5, 5, 10]
    assert load_scene(write("still", tent([0, 0, 0]))).objects is None and plain.objects is None
    with pytest.raises(SceneError, match=r"meshes\[0\].dynamic"):
        load_scene(write("bad", tent([0, 0, 0], dynamic="yes")))


def in_world(rigid):
    return rigid.triangles @ rigid.rotation.T + rigid.translation


def test_rigid_objects(placed, write):
    """They come last, and stand where their triangles are; what moves them on the way is part of it."""
    for time in (0.0, 0.6):
        scene = load_scene(placed, time)
        assert np.bincount(scene.objects).tolist() == [114, 5, 5, 5, 5, 5] and (np.diff(scene.objects) >= 0).all()
        for k, rigid in enumerate(scene.placed, 2):
            np.testing.assert_allclose(in_world(rigid), scene.triangles[scene.objects == k], atol=1e-12)
            np.testing.assert_allclose(rigid.rotation @ rigid.rotation.T, np.eye(3), atol=1e-12)
            np.testing.assert_allclose(rigid.normals @ rigid.rotation.T, scene.normals[scene.objects == k], atol=1e-12)
    move = {"keys": [{"time": 0}, {"time": 1, "rotate": {"axis": [0, 0, 1], "degrees": 90}, "scale": 3, "translate": [1, 2, 3]}]}
    inner = write("inner", tent([0, 0, 0]), turned([1, 0, 0], animation=move), tent([2, 0, 0], dynamic=True))
    around = [{"scale": 2}, {"rotate": {"axis": [1, 1, 0], "degrees": 40}}]
    whole = {"file": inner.name, "transform": around}
    outer = load_scene(write("outer", whole, turned([3, 0, 0]), whole | {"dynamic": "rigid"}, whole | {"dynamic": True}), 0.5)
    assert np.bincount(outer.objects).tolist() == [5, 5, 15, 5, 5, 15] and len(outer.placed) == 3
    for k, rigid in enumerate(outer.placed, 3):
        np.testing.assert_allclose(in_world(rigid), outer.triangles[outer.objects == k], atol=1e-12)
    assert np.isclose(np.ptp(outer.placed[0].triangles[..., 0]), 2 * 0.3 * 2 * 2)  # width, its scale, at half time, outside
    once = load_scene(write("once", turned([0, 0, 0])))
    assert once.placed[0].triangles.tobytes() == outer.placed[1].triangles.tobytes()


@pytest.mark.parametrize(
    "change",
    [
        {"transform": [{"scale": [1, 1, -1]}]},
        {"transform": [{"scale": [1, 1.01, 1]}]},
        {"transform": [{"matrix": [1, 0.1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]},
        {"animation": {"keys": [{"time": 0, "scale": [1, 2, 1]}]}},
    ],
)
def test_what_is_not_rigid(write, change):
    """One line with the place; also if the rigid object is inside what is moved."""
    where = next(iter(change))
    inner = write("inner", turned([0, 0, 0]))
    for mesh in ({"file": "tent.obj", "dynamic": "rigid"}, {"file": inner.name}):
        with pytest.raises(SceneError, match=rf"bad.json: meshes\[1\].{where}: a rigid mesh can be turned") as error:
            load_scene(write("bad", tent([0, 0, 0]), mesh | change))
        assert "\n" not in str(error.value)
        load_scene(write("fine", tent([0, 0, 0]), mesh | change | {"dynamic": True}))
    digits = [0, 0, 2, 7, 1.414214, 1.414214, 0, 0, -1.414214, 1.414214, 0, 0, 0, 0, 0, 1]
    load_scene(write("digits", turned([0, 0, 0], transform=[{"matrix": digits}])))


def test_too_many(write):
    path = write("many", *(tent([i, 0, 0], dynamic=True) for i in range(objects.MAX_OBJECTS + 1)))
    with pytest.raises(SceneError, match="257 dynamic objects, at most 256"):
        build_geometry(load_scene(path), tbu.Params())


def test_larger_than_the_scene(write):
    """A bar along a diagonal of the scene is longer than the scene is wide."""
    bar = [{"scale": [9, 0.1, 0.1]}]
    corner = {"rotate": {"axis": [0, -1, 1], "degrees": 54.7356}}
    inner = write("inner", {"file": "tent.obj", "transform": bar})
    path = write("bar", {"file": inner.name, "transform": [corner], "dynamic": "rigid"})
    with pytest.raises(SceneError, match="larger than the scene"):
        build_geometry(load_scene(path), tbu.Params())


def rays_of(geometry, count, seed):
    """Random rays from outside and inside."""
    rng = np.random.default_rng(seed)
    org = fp24.round_to_fp24(rng.uniform(-1.1, 1.1, (count, 3)))
    aim = geometry.unit.to_unit(geometry.scene.triangles)[rng.integers(len(geometry.scene.triangles), size=count)]
    weights = rng.dirichlet((1, 1, 1), count)
    d = (weights[:, :, None] * aim).sum(1) - org
    d = fp24.round_to_fp24(d / np.linalg.norm(d, axis=1, keepdims=True))
    inverse = np.array([[rgen.inverse(x) for x in row] for row in d])
    limits = np.full(count, tracer.T_MIN), np.full(count, tracer.HUGE), np.full(count, tracer.TRI_NONE), np.zeros(count, np.int64)
    return org, d, inverse, *limits


@pytest.mark.parametrize("shadow", [False, True])
def test_same_hits_as_one_tree(lively, placed, write, seed, shadow):
    """Of the models: objects that overlap, many of them, none static, some outside the static tree's box, placed or not."""
    many = [tent([3 * (i % 8), 3 * (i // 8), i % 5], 1.7, dynamic=True) for i in range(64)]
    paths = [lively, write("many", tent([10, 10, -3], 4.0), *many), write("none", *many[:9]), placed]
    many = [turned([3 * (i % 8), 3 * (i // 8), i % 5], (i % 3, 1, i % 4), 20.0 * i, 1.7) for i in range(64)]
    paths += [write("turned", tent([10, 10, -3], 4.0), *many), write("alone", *many[:9])]
    for path in paths:
        scene = load_scene(path)
        trees = [build_geometry(s, tbu.Params()) for s in (scene, replace(scene, objects=None))]
        images = [build_image(g, View(8, 8)) for g in trees]
        assert images[0].registers["INST_COUNT"] == scene.objects.max() + 1 and "INST_COUNT" not in images[1].registers
        rays = rays_of(trees[0], 3000, seed)
        two, one = (tracer.trace_rays(decode_tree(i), *rays, np.full(3000, shadow)) for i in images)
        hit, found = one[0] != tracer.TRI_NONE, two[0] != tracer.TRI_NONE
        assert 0.3 < hit.mean() and (scene.objects[one[0][hit]] > 0).any()
        assert (found != hit).sum() <= 4
        tri = np.where(found, trees[0].in_scene(np.where(found, two[0], -1), two[6]), tracer.TRI_NONE)
        thing, first = np.where(found, scene.objects[np.where(found, tri, 0)], 0), scene.objects.max() - len(scene.placed) + 1
        assert (two[6] == np.where(thing >= first, thing, tracer.NOT_PLACED)).all()
        assert (two[6] > 0).any() == (len(scene.placed) > 0)
        if not shadow:  # ties between neighbours apart
            both = hit & found
            corners = trees[1].unit.triangles[one[0][both]]
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            slope = np.abs(np.einsum("ij,ij->i", rays[1][both], normal)) / np.linalg.norm(normal, axis=1)
            # A ray may pass an edge in one and not in the other, and then meets what lies behind: one ray in 5,000 or so.
            assert (np.abs(two[1] - one[1])[both] * slope > 1e-4).sum() <= 8 and (tri != one[0]).sum() < 60


def test_image(lively):
    """All trees in two regions, each in its own part; instances say where; boxes hold their objects."""
    geometry = build_geometry(load_scene(lively), in_hardware=True)
    things, params = geometry.objects, geometry.tree.params
    room = objects.room(things, params.cap)
    made = build_image(geometry, View(8, 8), room=room)
    r = made.registers
    assert r["NODE_COUNT"] == room.nodes == room.node_first[-1] and r["INST_COUNT"] == 4
    assert [p.first for p in things.parts] == [114, 120, 126, 1] and len(geometry.info) == 131
    ends = []
    for number, part in enumerate(things.parts):
        told = room.registers(number, made.regions, params)
        assert told["TBU_NODE_FIRST"] % tbu.NODE_EXTENT == 0 and told["TBU_LIST_FIRST"] % tbu.LIST_EXTENT == 0
        assert told["VERTEX_BASE"] % 64 == 0 and told["TRI_COUNT"] == len(part.refs)
        assert told["NODE_COUNT"] - told["TBU_NODE_FIRST"] >= 5 * len(part.refs)
        ends.append((told["TBU_NODE_FIRST"], told["NODE_COUNT"]))
    assert ends[0][0] >= things.static.nodes.size and all(a[1] == b[0] for a, b in pairwise(ends))
    words = made.memory[slice(*made.regions["instances"])].view("<u8").reshape(-1, 32)
    assert len(words) == 4 and not words[:, 4:].any()
    fields = image.unpack_records(objects.INSTANCE, words)
    assert not fields["placed"].any()
    for k in range(1, 4):
        mine = geometry.unit.triangles[geometry.rows[geometry.scene.objects == k]]
        lo, hi = (np.array([fp24.from_bits(fields[f"{s}_{a}"][k : k + 1])[0] for a in "xyz"]) for s in ("lo", "hi"))
        assert (lo < mine.min((0, 1))).all() and (hi > mine.max((0, 1))).all()
    moved = build_geometry(load_scene(lively, 0.5), in_hardware=True)
    assert (moved.unit.scale_exp, *moved.unit.centre) == (geometry.unit.scale_exp, *geometry.unit.centre)
    assert (moved.objects.static.nodes == things.static.nodes).all()


def test_even_numbers(lively, placed, write):
    """Objects that are built begin at even numbers in memory; what is padded is there twice, the second time as a point."""
    single = write("single", tent([0, 0, 0]), tent([2, 0, 0], dynamic=True), turned([0, 2, 0]), tent([0, 0, 3], dynamic=True))
    for path, padding in ((lively, [119, 125]), (placed, []), (single, [5, 11])):
        scene = load_scene(path)
        geometry = build_geometry(scene, tbu.Params())
        numbers, rows, built = geometry.objects.numbers, geometry.rows, geometry.objects.parts[:-1]
        assert np.flatnonzero(np.diff(numbers, prepend=-1) == 0).tolist() == padding
        assert all(part.first % 2 == 0 for part in built) and not geometry.objects.made[padding].any()
        assert (geometry.in_scene(rows, scene.objects) == np.arange(len(scene.triangles))).all()
        assert geometry.in_scene(np.full(1, -1), np.zeros(1, int)) == -1
        for k, part in enumerate(built, 1):
            assert (part.triangles == geometry.unit.triangles[rows[scene.objects == k]]).all()
            assert (part.triangles == geometry.unit.triangles[part.rows]).all()
        points = geometry.unit.triangles[padding]
        assert (points == geometry.unit.triangles[np.array(padding, int) - 1][:, :1]).all()
        made = build_image(geometry, View(8, 8))
        records = image.unpack_records(image.TRIACCEL, image.region_words(made, "triaccel", len(numbers), 4))
        assert (records["k"][padding] == 3).all()
        assert not np.isin(made.memory[slice(*made.regions["lists"])].view("<u4") & 0xFFFFFF, padding).any()


@pytest.mark.parametrize("name", ["lively", "placed"])
def test_image_without_records(request, name):
    """What the record unit reads is there, what it writes is not; everything else is where it is and as it is without it."""
    geometry = build_geometry(load_scene(request.getfixturevalue(name)), in_hardware=True)
    room, params = objects.room(geometry.objects, geometry.tree.params.cap), geometry.tree.params
    bare, full = (build_image(geometry, View(8, 8), room=room, records=r) for r in (True, False))
    made = geometry.objects.made
    assert made.sum() == 5 * (len(geometry.objects.parts) - 1)
    for region, words in (("triaccel", 4), ("info", 8)):
        one, two = (image.region_words(i, region, len(made), words) for i in (bare, full))
        assert not one[made].any() and two[made].any(axis=1).all() and (one[~made] == two[~made]).all()
        assert bare.regions[region] == full.regions[region]
    eye = geometry.unit.to_unit(bare.view.camera.eye)
    assert bare.registers["ACCEL_SLACK"] == accel.slack(eye, geometry.tree.bounds).least
    attributes = accel.attribute_records(geometry.kept.normals, geometry.kept.face_material)
    for number, part in enumerate(geometry.objects.parts[:-1]):
        told = room.registers(number, bare.regions, params)
        assert told["ACCEL_BASE"] == bare.regions["triaccel"][0] + 32 * part.first and told["ACCEL_BASE"] % 64 == 0
        assert told["INFO_BASE"] == bare.regions["info"][0] + 64 * part.first and told["ATTR_BASE"] % 64 == 0
        given = bare.memory[told["ATTR_BASE"] :][: 32 * 5].view("<u8").reshape(5, 4)
        assert (given == attributes[part.rows]).all()
    assert "ACCEL_BASE" not in room.registers(len(geometry.objects.parts) - 1, bare.regions, params)
    assert "ACCEL_BASE" not in room.registers(0, full.regions, params)


# ---- placed objects --------------------------------------------------------------------------------------------------------


def test_equal_shapes_share(placed, write):
    """Records and tree of a shape are there once; another material or size is another shape."""
    scene = load_scene(placed, 0.4)
    geometry = build_geometry(scene, tbu.Params())
    things = geometry.objects
    assert [[p.shape is s for p in things.places] for s in things.shapes] == [
        [True, True, False, False],
        [False, False, True, False],
        [False, False, False, True],
    ]
    assert [s.first for s in things.shapes] == [119, 124, 129] and len(geometry.info) == 134 == len(geometry.uv)
    assert things.numbers.tolist() == [*range(124), *range(129, 139)] and things.offsets.tolist() == [0, 0, 0, 5, 0, 0]
    rows = geometry.rows
    assert (geometry.kept.face_material[rows] == scene.face_material).all() and (geometry.kept.uv[rows] == scene.uv).all()
    apart = build_geometry(replace(scene, placed=[]), tbu.Params())
    assert len(apart.info) == len(scene.triangles) + 4 == 143 and apart.objects.offsets.tolist() == [0] * 6
    mat, mat_apart = (image.read_info(build_image(g, View(8, 8)))[1][g.rows] for g in (geometry, apart))
    assert (mat == mat_apart).all()
    crowd = [turned([i, i, 0], degrees=9.0 * i) for i in range(40)]
    scenes = [write(f"{n} objects", tent([0, -2, 0], 50.0), *crowd[:n]) for n in (1, 40)]
    one, many = (build_geometry(load_scene(path), tbu.Params()) for path in scenes)
    assert len(one.info) == len(many.info) == 10 and len(many.objects.places) == 40
    assert one.objects.nodes.size == many.objects.nodes.size


def test_info(placed):
    values = info.scene_info(placed)
    assert values["objects"] == {"built": 1, "placed": 4, "shapes": 3, "triangles_in_memory": 134} and values["triangles"] == 139
    assert dict(info.rows(values))["dynamic objects"].startswith("1 built for each picture, 4 placed, of 3 shapes: 134 triangles")
    assert info.scene_info("tiny")["objects"] is None


def test_records_of_places(placed):
    """Ways into and out of an object, box and root; what they say is where its triangles are."""
    scene = load_scene(placed, 0.7)
    geometry = build_geometry(scene, tbu.Params())
    made = build_image(geometry, View(8, 8))
    words = made.memory[slice(*made.regions["instances"])].view("<u8").reshape(-1, objects.INSTANCE_WORDS)
    assert made.regions["instances"][0] % 64 == 0 and made.registers["INST_COUNT"] == len(words) == 6
    head = image.unpack_records(objects.INSTANCE, words)
    assert head["placed"].tolist() == [0, 0, 1, 1, 1, 1] and not words[:2, 4:].any() and not words[:, 22:].any()
    rows = [image.unpack_records(objects.INSTANCE_ROW, words[2:, 4 * i : 4 * i + 4]) for i in (1, 2, 3)]
    out = image.unpack_records(objects.PLACE, words[2:, 16:24])
    m = np.stack([out[f"m_{a}{b}"] for a in "xyz" for b in "xyz"], axis=1).reshape(-1, 3, 3)
    origin = np.stack([out[f"o_{a}"] for a in "xyz"], axis=1)
    assert (np.stack([[r[f"r_{a}"] for a in "xyz"] for r in rows]).transpose(2, 1, 0) == m).all()  # transposed, bit for bit
    for row in rows:
        assert (np.stack([row[f"c_{a}"] for a in "xyz"], axis=1) == origin).all() and (row["root"] == head["root"][2:]).all()
    tree = decode_tree(made)
    for k, place in enumerate(geometry.objects.places, 2):
        assert head["root"][k] == place.shape.root
        local = geometry.unit.triangles[place.shape.first : place.shape.last]
        assert (np.abs(local.reshape(-1, 3).max(0) + local.reshape(-1, 3).min(0)) <= 2.0**-17).all()  # its box is round 0
        assert (local == np.rint(local * 2.0**17) * 2.0**-17).all()
        world = geometry.unit.to_unit(scene.triangles[scene.objects == k])
        matrix, at = fp24.from_bits(m[k - 2]), fp24.from_bits(origin[k - 2])
        assert np.abs(local @ matrix.T + at - world).max() < 2.0**-15
        lo, hi = (np.array([fp24.from_bits(head[f"{s}_{a}"][k : k + 1])[0] for a in "xyz"]) for s in ("lo", "hi"))
        assert (lo < world.min((0, 1)) - 2.0**-11).all() and (hi > world.max((0, 1)) + 2.0**-11).all()
        # What the tracer reads is the same, and it leads in as the other leads out.
        assert tree.inst_placed[k] and (tree.inst_place[k] == np.column_stack((matrix, at))).all()
        assert (tree.inst_rows[k, :, :3] == matrix.T).all() and (tree.inst_rows[k, :, 3:] == at).all()
        point = fp24.round_to_fp24(world[2].mean(0))
        inside, _, _ = tracer.into_object(tree.inst_rows[k], point, np.array([1.0, 0.0, 0.0]))
        assert np.abs(inside - local[2].mean(0)).max() < 2.0**-15


def test_only_places_change(placed):
    """Of a picture to the next: no tree but those of dynamic objects and the top level, and no record but instances."""
    first, later = (build_geometry(load_scene(placed, t), tbu.Params()) for t in (0.0, 0.5))
    for name in ("nodes", "lists"):
        assert getattr(first.objects, name).tobytes() == getattr(later.objects, name).tobytes()
    assert first.info.tobytes() == later.info.tobytes() and first.uv.tobytes() == later.uv.tobytes()
    assert len(objects._made) == 3  # the static tree and two more: a shape of another material has the same
    made = list(objects._made.values())
    build_geometry(load_scene(placed, 0.9), tbu.Params())
    assert all(a is b for a, b in zip(objects._made.values(), made))


def test_trees_of_shapes(placed):
    """Each is the host's tree of its shape, moved to its place among the others: the same nodes, leaves and triangles."""
    geometry = build_geometry(load_scene(placed), tbu.Params())
    things = geometry.objects
    for shape in things.shapes:
        bounds = np.stack((shape.triangles.min((0, 1)), shape.triangles.max((0, 1))))
        found = kdtree.walk(kdtree.Tree(things.nodes, things.lists, shape.root, bounds, objects.SHAPE_PARAMS))
        mine = slice(shape.first, shape.last)
        alone = kdtree.walk(kdtree.build(shape.triangles, geometry.unit.dropped[mine], objects.SHAPE_PARAMS))
        assert (found.split == alone.split).all() and (found.axis == alone.axis).all()
        assert (found.members == alone.members + shape.first).all()
        assert (found.index == alone.index + shape.root).all()
        entries = things.lists[np.isin(things.lists & 0xFFFFFF, np.arange(shape.first, shape.last))]
        assert ((entries >> 25 & 1 == 1) == geometry.opaque[entries & 0xFFFFFF]).all()


def test_edge_slack(placed):
    """A triangle of a shape has the greatest slack that an object needs, and no more."""
    scene = load_scene(placed)
    geometry = build_geometry(scene, tbu.Params())
    view = View(8, 8, camera=replace(scene.camera, eye=(9.0, 5.0, 14.0)))
    made = build_image(geometry, view)
    eye = geometry.unit.to_unit(view.camera.eye)
    codes = image.unpack_records(image.TRIACCEL, image.region_words(made, "triaccel", len(geometry.info), 4))
    slack = 2.0 ** -codes["eps_e"].astype(float) * (1.0 + codes["eps_m"] / 16.0)
    least = accel.slack(eye, geometry.tree.bounds).least
    for shape in geometry.objects.shapes:
        mine = slice(shape.first, shape.last)
        needed = []
        for place in geometry.objects.places:
            if place.shape is shape:
                seen = replace(accel.slack((eye - place.origin) @ place.rotation, geometry.tree.bounds), least=least)
                rec, _, _ = accel.records(replace(geometry.unit, triangles=geometry.unit.triangles[mine]), seen)
                needed.append(2.0 ** -(rec.eps_code >> 4).astype(float) * (1.0 + (rec.eps_code & 15) / 16.0))
        assert (slack[mine] == np.max(needed, axis=0)).all()


SHEET = "v -1 -1 0\nv 1 -1 0\nv 0 1.5 0\nf 1 2 3\n"


@pytest.fixture
def facing(write, tmp_path):
    """Two mirrors of one triangle each, of one shape, that face each other; a lamp between them and one behind the second."""
    (tmp_path / "sheet.obj").write_text(SHEET)
    near = {"file": "sheet.obj", "material": "mirror", "dynamic": "rigid"}
    far = near | {"transform": [{"rotate": {"axis": [0, 1, 0], "degrees": 180}}, {"translate": [0, 0, 2]}]}
    return write(
        "facing",
        tent([0, -4, 1], 2.0),
        near,
        far,
        materials={"mirror": {"diffuse": [0.5, 0.5, 0.5], "reflect": [0.7, 0.7, 0.7]}},
        lights=[{"position": [0, 0, 5]}],
        camera={"eye": [0.1, 0.1, 1.0], "target": [0.05, 0.05, 0]},
        depth=4,
    )


def test_skip_is_of_one_object(facing):
    """A ray that leaves a triangle of one object meets the same triangle of another: skipped is a triangle of an object."""
    geometry = build_geometry(load_scene(facing), tbu.Params())
    assert len(geometry.objects.shapes) == 1 and len(geometry.info) == 6
    made = build_image(geometry, View(9, 7))
    out = render_fp24(made)
    rays = out.pixel_rays(4, 3)
    rays = rays[rays["kind"] != frame.SHADOW]
    assert rays["inst"].tolist() == [1, 2, 1, 2, 1] and set(rays["tri"]) == {5} and (rays["hit"] == 1).all()
    shadow = out.pixel_rays(4, 3)[1]  # from the first mirror to the lamp behind the second
    assert (shadow["kind"], shadow["hit"], shadow["inst"], shadow["tri"]) == (frame.SHADOW, 1, 2, 5)
    double = render_double(made, out.tri)
    assert check.same_rays(out, double).mean() > 0.95
    # Of the tracer alone, from a point on the first mirror.
    tree, org, d = decode_tree(made), fp24.round_to_fp24(geometry.unit.to_unit((0.1, 0.2, 0.0))), np.array([0.0, 0.0, 1.0])
    ray = org, d, np.array([rgen.inverse(x) for x in d]), tracer.T_MIN, tracer.HUGE
    for skip_inst, expected in ((1, (5, 2)), (2, (tracer.TRI_NONE, 0)), (tracer.NOT_PLACED, (5, 2))):
        found = tracer.trace_ray(tree, *ray, 5, skip_inst, False, np.zeros(4, np.int64))
        assert (found[0], found[6]) == expected, skip_inst


@pytest.mark.parametrize(("name", "time"), [("placed", 0.3), ("dice", 0.4), ("dice", 1.7)])
def test_same_picture(placed, name, time):
    """As if the objects were built anew, and as in double precision: colours, objects seen, lights."""
    scene = load_scene(placed if name == "placed" else name, time)
    rigid, anew = (build_image(build_geometry(s, tbu.Params()), View(120, 80)) for s in (scene, replace(scene, placed=[])))
    assert len(rigid.geometry.info) < len(anew.geometry.info)
    one, two = render_fp24(rigid), render_fp24(anew)
    pictures = [check.channels(f.pixels) for f in (one, two)]
    assert check.psnr(*pictures) > 42.0
    seen = [np.where(f.tri < 0, -1, scene.objects[np.maximum(f.tri, 0)]) for f in (one, two)]
    assert (seen[0] != seen[1]).mean() < 0.001 and (seen[0] > 0).mean() > 0.05
    assert (one.tri != two.tri).mean() < 0.002
    report = check.check(rigid, reference=one)
    assert report.psnr > check.PSNR_BOUNCED_DB and report.agreement.same_hit > check.AGREEMENT and report.agreement.holes <= 1
    # Nothing casts a shadow on itself that does not in double precision.
    same = (one.tri == report.double.tri) & (one.tri >= 0)
    wrong = (one.light == frame.SHADOWED) & (report.double.light == frame.LIT) & same
    assert wrong.mean() < 0.001


def test_grazing_light(write, seed):
    """Light that all but runs along faces, flat and smooth ones: they do not shade themselves."""
    rng = np.random.default_rng(seed)
    meshes = []
    for i in range(9):
        axis = [0, 1, 0] if i % 2 else rng.normal(size=3).tolist()
        meshes.append(turned([3.0 * (i % 3), rng.uniform(0, 2), 3.0 * (i // 3)], axis, rng.uniform(0, 360), rng.choice([0.4, 1.3])))
        meshes[-1]["file"] = ("tent.obj", "ball.py")[i % 3 == 2]
    (write("x", tent([0, 0, 0])).parent / "ball.py").write_text(BALL)
    for height in (0.003, 0.03, 0.3):
        azimuth = rng.uniform(0, 2 * np.pi)
        lights = [{"direction": [np.cos(azimuth), height, np.sin(azimuth)]}]
        view = {"eye": [9, 7, 12], "target": [3, 1, 3]}
        made = build_image(build_geometry(load_scene(write("g", *meshes, lights=lights, camera=view)), tbu.Params()), View(120, 90))
        one = render_fp24(made)
        two = render_double(made, one.tri)
        same = (one.tri == two.tri) & (one.tri >= 0)
        assert same.mean() > 0.1
        wrong = (one.light[0] != two.light[0]) & same & (two.light[0] != frame.CULLED) & (one.light[0] != frame.CULLED)
        assert wrong.sum() <= 3


BALL = """from raycore.shapes import Builder, sphere


def build():
    b = Builder("ball")
    b.paint("dull", colour=(0.7, 0.7, 0.7))
    b.add(sphere((0.0, 0.0, 0.0), 1.0, 32), "dull", 60.0)
    return b.scene()
"""


def test_hits_in_scene_numbers(placed):
    """Triangles that leave the reference and the RTL's hit records are those of the scene."""
    scene = load_scene(placed)
    made = build_image(build_geometry(scene, tbu.Params()), View(40, 30))
    out = render_fp24(made)
    assert {0, 2, 3, 4, 5} >= set(out.log["inst"]) and len(set(out.log["inst"])) > 3
    inst = out.log["inst"]
    hit = inst > 0
    assert (scene.objects[out.log_tri[hit]] == inst[hit]).all() and (out.log_tri[out.log["hit"] == 0] == -1).all()
    want = check.expected_hits(out)
    assert (want["inst"] == inst).all() and (want["tri"][hit] < len(made.geometry.info)).all()
    result = sim.SimResult(out.pixels, want)
    tri, t = render._primary(result, made.view, made.geometry)
    assert (tri == out.tri).all() and (t[tri >= 0] == out.t[tri >= 0]).all()
    aov = render.aov(render.Rendered("model", made, out.pixels, out.tri, out.t, sim.Memory(), None, out))
    seen = aov["tri"] >= 0
    corners = aov["triangles"][aov["tri"][seen]]
    point = aov["ray_origin"][seen] + aov["t"][seen][:, None] * aov["ray_dir"][seen]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    away = np.einsum("ij,ij->i", point - corners[:, 0], normal / np.linalg.norm(normal, axis=1, keepdims=True))
    assert np.abs(away).max() < 2.0**-9


# ---- the RTL ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["lively", "placed", "facing"])
@pytest.mark.parametrize("pauses", [0.0, 0.4])
def test_rtl_with_trees_of_the_model(request, seed, pauses, name):
    """Every pixel, hit and counter, with shadows, mirrors and glass."""
    path = request.getfixturevalue(name)
    made = build_image(build_geometry(load_scene(path), tbu.Params()), View(32, 24, max_depth=3))
    memory = sim.Memory(latency=33, backpressure=pauses, seed=seed)
    result = sim.run_frame(made.memory, made.registers, memory=memory, hits=True, progress=False)
    exact = check.compare_rtl(result, render_fp24(made))
    assert exact.same, (exact.examples, exact.counters)
    assert result.stats["bytes"]["instances"] > 0


def test_bad_instance(lively):
    """A list of the top-level tree that names an object which is not there."""
    made = build_image(build_geometry(load_scene(lively), tbu.Params()), View(8, 8))
    with pytest.raises(sim.FrameError, match="instance index 2 outside") as error:
        sim.run_frame(made.memory, made.registers | {"INST_COUNT": 2}, progress=False)
    assert error.value.code == ERR_INST
    with pytest.raises(sim.FrameError, match="register 0x240"):
        sim.run_frame(made.memory, made.registers | {"INST_BASE": 0xFFFFFFC0}, progress=False)


@pytest.fixture
def mixed(write):
    """Static triangles, a placed object, and three that are built: of 5, 10 and 5 triangles."""
    pair = write("pair", tent([-0.3, 0.5, 0.1], 0.4), tent([-0.5, 0.2, 0.4], 0.3))
    return write(
        "mixed",
        turned([-0.4, 0.7, 0.5], (1, 0, 1), 30.0),
        tent([0.2, 0.5, 0.2], dynamic=True, animation={"keys": [{"time": 0}, {"time": 1, "translate": [0, 0.5, 0]}]}),
        {"file": "tiny_glass"},
        {"file": pair.name, "dynamic": True, "material": "clear"},
        tent([0.5, 0.2, 0.5], 0.4, dynamic=True),
        materials={"clear": {"transmit": [0.9, 0.9, 0.9], "ior": 1.5}},
    )


@pytest.mark.parametrize(
    ("name", "pauses", "records"),
    [("lively", 0.1, False), ("placed", 0.1, False), ("lively", 0.4, True), ("mixed", 0.0, True), ("mixed", 0.3, True)],
)
def test_rtl_builds_them(request, seed, name, pauses, records):
    """A frame for each object, one for the top-level tree, then the picture: trees, records, pixels, hits; cycles add up."""
    geometry = build_geometry(load_scene(request.getfixturevalue(name), 0.3), in_hardware=True)
    memory = sim.Memory(latency=17, backpressure=pauses, seed=seed)
    made = dynamic.render_frame(geometry, View(24, 16, max_depth=3), memory, True, True, records, progress=False)
    found = dynamic.check_frame(made)
    assert found.same, (found.exact.examples, found.exact.counters, found.difference, found.records)
    values, parts = render.stats(made), geometry.objects.parts[:-1]
    assert values["tbu"]["triangles"] == sum(len(p.refs) for p in parts) and ("records" in values) == records
    if records:
        used = values["records"]
        assert used["bytes"] == sum(96 * len(p.refs) + 128 * -(-len(p.refs) // 2) for p in parts)
        assert used["cycles"] > 30 * values["tbu"]["triangles"] and used["cycles_per_triangle"] < 200
        assert values["cycles"] - values["render_cycles"] >= max(values["tbu"]["cycles"], used["cycles"])
        for part in parts:  # of each object records are compared
            for region, size, text in (("info", 64, "records of triangle information"), ("triaccel", 32, "TriAccel records")):
                changed = replace(made.result, memory=made.result.memory.copy())
                changed.memory[made.image.regions[region][0] + size * (part.rows.stop - 1)] ^= 1
                assert dynamic._records(replace(made, result=changed), found.image).startswith(f"in 1 {text}")
    c = made.result.stats["counters"]
    assert c["TBU_NODES"] >= sum(len(p.tree(geometry.tree.params)) for p in geometry.objects.parts)
    assert 0 < c["TBU_CYCLES"] < c["CYCLES"] and c["TBU_ROWS"] >= 4
    spoilt = replace(made.result, memory=made.result.memory.copy())
    low, _ = made.image.regions["instances"]
    root = int(spoilt.memory[low + objects.INSTANCE_BYTES :][:4].view("<u4")[0] & 0xFFFFFF)
    spoilt.memory[made.image.regions["nodes"][0] + 8 * root + 1] ^= 1
    assert dynamic.check_frame(replace(made, result=spoilt)).difference.startswith("object 1, at root")


def test_more_room_for_objects(lively, monkeypatch):
    """After an overflow trees and records are made anew, in an image with more room."""
    geometry = build_geometry(load_scene(lively), in_hardware=True)
    room, asked = objects.room, []

    def small(things, cap, factor):
        asked.append(factor)
        out = room(things, cap)
        ends = [n - 17 * tbu.NODE_EXTENT * (factor == 1) * (i == 2) for i, n in enumerate(out.node_first)]
        return replace(out, node_first=ends)

    monkeypatch.setattr(objects, "room", small)
    made = dynamic.render_frame(geometry, View(8, 8), hits=True, keep_memory=True, records=True, progress=False)
    assert asked == [1, 2] and dynamic.check_frame(made).same


@pytest.mark.parametrize("records", [False, True])
def test_rtl_builds_no_placed_object(write, records):
    """Where all that moves is placed, only the tree over boxes is built."""
    path = write("rigid", tent([0, -1, 0], 3.0), *(turned([i - 1.5, 0.5, 0.3 * i], degrees=70.0 * i) for i in range(4)))
    geometry = build_geometry(load_scene(path), in_hardware=True)
    made = dynamic.render_frame(geometry, View(24, 16), hits=True, keep_memory=True, records=records, progress=False)
    assert dynamic.check_frame(made).same
    values = render.stats(made)
    nothing = {"cycles": 0, "cycles_per_triangle": None, "bytes": 0, "bytes_per_triangle": None}
    assert values.get("records") == (nothing if records else None)
    assert values["tbu"]["triangles"] == 0 and values["tbu"]["cycles_per_triangle"] is None
    assert 0 < values["tbu"]["cycles"] < 2000 and values["config"]["triangles"] == 25
    assert dict(render.summary(values))["  of these to build the tree"] == f"{values['tbu']['cycles']:,}"
