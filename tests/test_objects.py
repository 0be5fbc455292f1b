# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scenes with dynamic objects: what a scene file says, the trees, their places in memory, and frames of the RTL."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from raycore import check, dynamic, image, objects, sim, tbu
from raycore.errors import SceneError
from raycore.image import View, build_geometry, build_image
from raycore.model import fp24, rgen, tracer
from raycore.model.frame import decode_tree, render_fp24
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


def test_too_many(write):
    path = write("many", *(tent([i, 0, 0], dynamic=True) for i in range(objects.MAX_OBJECTS + 1)))
    with pytest.raises(SceneError, match="257 dynamic objects, at most 256"):
        build_geometry(load_scene(path), tbu.Params())


def rays_of(geometry, count, seed):
    """Random rays from outside and inside."""
    rng = np.random.default_rng(seed)
    org = fp24.round_to_fp24(rng.uniform(-1.1, 1.1, (count, 3)))
    aim = geometry.unit.triangles[rng.integers(len(geometry.info), size=count)]
    weights = rng.dirichlet((1, 1, 1), count)
    d = (weights[:, :, None] * aim).sum(1) - org
    d = fp24.round_to_fp24(d / np.linalg.norm(d, axis=1, keepdims=True))
    inverse = np.array([[rgen.inverse(x) for x in row] for row in d])
    limits = np.full(count, tracer.T_MIN), np.full(count, tracer.HUGE), np.full(count, tracer.TRI_NONE)
    return org, d, inverse, *limits


@pytest.mark.parametrize("shadow", [False, True])
def test_same_hits_as_one_tree(lively, write, seed, shadow):
    """Of the models: objects that overlap, many of them, none static, some outside the static tree's box."""
    many = [tent([3 * (i % 8), 3 * (i // 8), i % 5], 1.7, dynamic=True) for i in range(64)]
    paths = [lively, write("many", tent([10, 10, -3], 4.0), *many), write("none", *many[:9])]
    for path in paths:
        scene = load_scene(path)
        trees = [build_geometry(s, tbu.Params()) for s in (scene, replace(scene, objects=None))]
        images = [build_image(g, View(8, 8)) for g in trees]
        assert images[0].registers["INST_COUNT"] == scene.objects.max() + 1 and "INST_COUNT" not in images[1].registers
        rays = rays_of(trees[0], 3000, seed)
        two, one = (tracer.trace_rays(decode_tree(i), *rays, np.full(3000, shadow)) for i in images)
        hit = one[0] != tracer.TRI_NONE
        assert 0.3 < hit.mean() and (scene.objects[one[0][hit]] > 0).any()
        assert ((two[0] != tracer.TRI_NONE) != hit).sum() <= 2
        if not shadow:  # ties between neighbours apart
            assert (np.abs(two[1] - one[1])[hit] > 1e-4).sum() <= 2 and (two[0] != one[0]).sum() < 60


def test_image(lively):
    """All trees in two regions, each in its own part; instances say where; boxes hold their objects."""
    geometry = build_geometry(load_scene(lively), in_hardware=True)
    things, params = geometry.objects, geometry.tree.params
    room = objects.room(things, params.cap)
    made = build_image(geometry, View(8, 8), room=room)
    r = made.registers
    assert r["NODE_COUNT"] == room.nodes == room.node_first[-1] and r["INST_COUNT"] == 4
    assert [p.first for p in things.parts] == [114, 119, 124, 1]
    ends = []
    for number, part in enumerate(things.parts):
        told = room.registers(number, made.regions, params)
        assert told["TBU_NODE_FIRST"] % tbu.NODE_EXTENT == 0 and told["TBU_LIST_FIRST"] % tbu.LIST_EXTENT == 0
        assert told["VERTEX_BASE"] % 64 == 0 and told["TRI_COUNT"] == len(part.refs)
        assert told["NODE_COUNT"] - told["TBU_NODE_FIRST"] >= 5 * len(part.refs)
        ends.append((told["TBU_NODE_FIRST"], told["NODE_COUNT"]))
    assert ends[0][0] >= things.static.nodes.size and all(a[1] == b[0] for a, b in pairwise(ends))
    words = made.memory[slice(*made.regions["instances"])].view("<u8").reshape(-1, 4)
    fields = image.unpack_records(objects.INSTANCE, words)
    for k in range(1, 4):
        mine = geometry.unit.triangles[geometry.scene.objects == k]
        lo, hi = (np.array([fp24.from_bits(fields[f"{s}_{a}"][k : k + 1])[0] for a in "xyz"]) for s in ("lo", "hi"))
        assert (lo < mine.min((0, 1))).all() and (hi > mine.max((0, 1))).all()
    moved = build_geometry(load_scene(lively, 0.5), in_hardware=True)
    assert (moved.unit.scale_exp, *moved.unit.centre) == (geometry.unit.scale_exp, *geometry.unit.centre)
    assert (moved.objects.static.nodes == things.static.nodes).all()


@pytest.mark.parametrize("pauses", [0.0, 0.4])
def test_rtl_with_trees_of_the_model(lively, seed, pauses):
    """Every pixel, hit and counter, with shadows, mirrors and glass."""
    made = build_image(build_geometry(load_scene(lively), tbu.Params()), View(32, 24, max_depth=3))
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


def test_rtl_builds_them(lively, seed):
    """A frame for each object, one for the top-level tree, then the picture: trees, pixels, hits; cycles add up."""
    geometry = build_geometry(load_scene(lively, 0.3), in_hardware=True)
    memory = sim.Memory(latency=17, backpressure=0.1, seed=seed)
    frame = dynamic.render_frame(geometry, View(24, 16, max_depth=3), memory, True, True, progress=False)
    found = dynamic.check_frame(frame)
    assert found.same, (found.exact.examples, found.exact.counters, found.difference)
    c = frame.result.stats["counters"]
    assert c["TBU_NODES"] >= sum(len(p.tree(geometry.tree.params)) for p in geometry.objects.parts)
    assert 0 < c["TBU_CYCLES"] < c["CYCLES"] and c["TBU_ROWS"] >= 4
    spoilt = replace(frame.result, memory=frame.result.memory.copy())
    low, _ = frame.image.regions["instances"]
    root = int(spoilt.memory[low + 32 :][:4].view("<u4")[0] & 0xFFFFFF)
    spoilt.memory[frame.image.regions["nodes"][0] + 8 * root + 1] ^= 1
    assert dynamic.check_frame(replace(frame, result=spoilt)).difference.startswith("object 1, at root")
