# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Keys over time in scene files: where meshes are between them, and mistakes."""

import json
import math
from itertools import pairwise

import numpy as np
import pytest

from raycore.errors import SceneError
from raycore.scene import load_scene
from raycore.scene.animation import duration, matrix_at, rotation


def at(animation, time, point=(1, 0, 0)):
    return (matrix_at(animation, time) @ (*point, 1))[:3]


def keys(*values, **more):
    return {"keys": [{"time": t, **v} for t, v in values], **more}


def turn(degrees, axis=(0, 0, 1)):
    return {"rotate": {"axis": list(axis), "degrees": degrees}}


def test_translation_and_ends():
    a = keys((1, {"translate": [0, 0, 0]}), (3, {"translate": [4, 0, -2]}))
    for time, want in ((0, (1, 0, 0)), (1, (1, 0, 0)), (1.5, (2, 0, -0.5)), (3, (5, 0, -2)), (9, (5, 0, -2))):
        assert np.allclose(at(a, time), want), time
    assert duration(a) == 3
    assert np.allclose(at(a | {"repeat": True}, 4.5), at(a, 1.5)) and np.allclose(at(a | {"repeat": True}, 3), (1, 0, 0))
    assert np.array_equal(matrix_at(keys((0, {})), 5), np.eye(4))


def test_smooth_is_slow_at_keys():
    a = keys((0, {}), (2, {"translate": [1, 0, 0]}), interpolation="smooth")
    for time in (0.0, 0.3, 1.0, 1.7, 2.0):
        assert at(a, time)[0] == pytest.approx(1.0 + 0.5 - 0.5 * math.cos(math.pi * time / 2))


def test_scale_and_pivot():
    a = keys((0, {}), (1, {"scale": [3, 1, 0.5]}), pivot=[2, 0, 0])
    assert np.allclose(at(a, 1, (2, 1, 0)), (2, 1, 0)) and np.allclose(at(a, 0.5, (3, 0, 1)), (4, 0, 0.75))
    assert np.allclose(at(keys((0, {"scale": 2})), 0, (1, 1, 1)), (2, 2, 2))
    b = keys((0, turn(0)), (1, turn(90)), pivot=[1, 1, 0])
    assert np.allclose(at(b, 1, (2, 1, 0)), (1, 2, 0)) and np.allclose(at(b, 1, (1, 1, 7)), (1, 1, 7))
    order = keys((0, {"translate": [0, 0, 1], "scale": [2, 1, 1], **turn(90)}))
    assert np.allclose(at(order, 0), (0, 2, 1)), "scale, then rotation, then translation"


def test_whole_turns_on_one_axis():
    a = keys((0, {}), (1, turn(720, (0, 0, 9))))
    assert np.allclose(at(a, 0.125), (0, 1, 0)) and np.allclose(at(a, 0.25), (-1, 0, 0)) and np.allclose(at(a, 1), (1, 0, 0))


def test_slerp_between_axes(seed):
    """Steady, on the short way, through both ends: each part of the way is the same rotation."""
    rng = np.random.default_rng(seed)
    for _ in range(20):
        axes = rng.normal(size=(2, 3))
        a = keys((0, turn(rng.uniform(-400, 400), axes[0])), (1, turn(rng.uniform(-400, 400), axes[1])))
        steps = [matrix_at(a, s)[:3, :3] for s in np.linspace(0, 1, 6)]
        for end, key in ((0, 0), (-1, 1)):
            assert np.allclose(steps[end], rotation(**a["keys"][key]["rotate"]), atol=1e-9)
        parts = [y @ x.T for x, y in pairwise(steps)]
        assert all(np.allclose(p, parts[0], atol=1e-7) for p in parts)
        angle = math.acos(np.clip((np.trace(parts[0]) - 1) / 2, -1, 1))
        assert angle * 5 <= math.pi + 1e-6
    same = keys((0, turn(90, (0, 0, 1))), (1, turn(-90, (0, 0, -1))))     # two names of one rotation
    assert np.allclose(matrix_at(same, 0.5), matrix_at(same, 0))


def document(**animation):
    return {"meshes": [{"file": "a.obj", "transform": [{"scale": 2}], "animation": animation}]}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    return tmp_path


def test_scene_at_a_time(folder):
    """After the mesh's transform; inside other scene files too, whose own movement comes last."""
    (folder / "in.json").write_text(json.dumps(document(keys=[{"time": 0}, {"time": 2, "translate": [2, 0, 0]}])))
    outer = {"meshes": [{"file": "in.json", "animation": {"keys": [{"time": 0}, {"time": 1, **turn(90)}]}}, {"file": "a.obj"}]}
    (folder / "out.json").write_text(json.dumps(outer))
    plain = load_scene(folder / "in.json")
    assert plain.duration == 2.0 and np.allclose(plain.triangles[0, 1], (2, 0, 0))
    assert np.allclose(load_scene(folder / "in.json", 1.0).triangles[0], [[1, 0, 0], [3, 0, 0], [1, 2, 0]])
    both = load_scene(folder / "out.json", 1.0)
    assert both.duration == 2.0 and np.allclose(both.triangles[0], [[0, 1, 0], [0, 3, 0], [-2, 1, 0]])
    assert np.allclose(both.triangles[1], [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    assert load_scene("tiny").duration == 0.0


@pytest.mark.parametrize(
    "animation, says",
    [
        ({}, r"animation: 'keys' is a required property"),
        ({"keys": []}, r"animation\.keys: .*(non-empty|too short)"),
        ({"keys": [{"translate": [0, 0, 0]}]}, r"keys\[0\]: 'time' is a required property"),
        ({"keys": [{"time": -1}]}, r"keys\[0\]\.time: -1 is less than"),
        ({"keys": [{"time": 1}, {"time": 1}]}, r"meshes\[0\]\.animation: the times of its keys do not ascend"),
        ({"keys": [{"time": 0, "scale": 0}]}, r"keys\[0\]\.scale: 0 is less than or equal"),
        ({"keys": [{"time": 0, "scale": [1, -1, 1]}]}, r"keys\[0\]\.scale\[1\]: -1 is less than or equal"),
        ({"keys": [{"time": 0}, {"time": 9, **turn(9, (0, 0, 0))}]}, r"animation: the axis of a rotation is zero"),
        ({"keys": [{"time": 0, "rotate": {"axis": [1, 0, 0]}}]}, r"rotate: 'degrees' is a required property"),
        ({"keys": [{"time": 0}], "interpolation": "cubic"}, r"interpolation: 'cubic' is not one of"),
        ({"keys": [{"time": 0}], "pivot": [0, 0]}, r"pivot: \[0, 0\] is too short"),
        ({"keys": [{"time": 0, "move": [0, 0, 0]}]}, r"keys\[0\]: Additional properties"),
    ],
)
def test_mistakes(folder, animation, says):
    (folder / "s.json").write_text(json.dumps(document(**animation)))
    with pytest.raises(SceneError, match=says):
        load_scene(folder / "s.json")
