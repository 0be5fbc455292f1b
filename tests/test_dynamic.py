# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Frames whose tree the RTL builds, and scenes that move: the whole chip under Verilator against the models."""

import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image as Picture

from raycore import animate, cli, dynamic, regress, sim, tbu
from raycore.errors import OptionError, SceneError, SimError
from raycore.image import View, build_geometry, build_image
from raycore.scene import load_scene

TENT = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1 0\nf 1 3 2\nf 1 4 3\nf 1 5 4\nf 2 5 1\nf 3 5 2\n"


@pytest.fixture
def command(capfd, monkeypatch):
    """Run the command in this process: (exit code, stdout, stderr)."""
    monkeypatch.delenv("RAYCORE_DEBUG", raising=False)

    def call(*arguments):
        with pytest.raises(SystemExit) as end:
            cli.app([str(a) for a in arguments])
        return end.value.code or 0, *capfd.readouterr()

    return call


@pytest.fixture
def moving(tmp_path):
    """Two tents, of which one turns and rises."""
    (tmp_path / "tent.obj").write_text(TENT)
    keys = [{"time": 0}, {"time": 2, "rotate": {"axis": [0, 1, 0], "degrees": 90}, "translate": [0, 1, 0]}]
    document = {
        "meshes": [
            {"file": "tent.obj", "transform": [{"scale": 3}, {"translate": [0, -2, 0]}]},
            {"file": "tent.obj", "animation": {"keys": keys}},
        ],
        "camera": {"eye": [2, 2, 6], "target": [0, 0, 0]},
    }
    path = tmp_path / "moving.json"
    path.write_text(json.dumps(document))
    return path


def test_image():
    """Room for the tree, vertices, registers of the builder; everything else as for the tree of the model."""
    scene = load_scene("tiny_glass")
    geometry = build_geometry(scene, in_hardware=True)
    room = tbu.sizes(len(scene.triangles))
    image = build_image(geometry, View(16, 8), room=room)
    plain = build_image(build_geometry(scene, tbu.Params()), View(16, 8))
    lo, hi = image.regions["vertices"]
    records = tbu.vertex_records(geometry.unit, geometry.opaque).astype("<u8")
    assert (image.memory[lo:][: records.nbytes] == records.reshape(-1).view(np.uint8)).all()
    assert not image.memory[slice(*image.regions["nodes"])].any()
    assert image.registers["NODE_COUNT"] == room.nodes and image.registers["REF_COUNT"] == room.refs
    assert not geometry.opaque.all()
    box = tbu.references(geometry.unit).box
    assert [image.registers[f"TBU_{s}_{a}"] for s in ("LO", "HI") for a in "XYZ"] == box.reshape(-1).tolist()
    for name in ("triaccel", "info", "materials", "uv", "textures", "lights"):
        assert (image.memory[slice(*image.regions[name])] == plain.memory[slice(*plain.regions[name])]).all(), name
    own = {n for n in image.registers if "BASE" in n or "COUNT" in n or n.startswith(("TBU", "NODE"))}
    assert all(plain.registers[n] == v for n, v in image.registers.items() if n not in own)


@pytest.mark.parametrize(("pauses", "records"), [(0.0, False), (0.4, True)])
def test_frame_of_the_rtl(seed, pauses, records):
    """Mirrors, glass, masks; what the tree says of transparency comes from the vertex records."""
    geometry = build_geometry(load_scene("tiny_glass"), in_hardware=True)
    memory = sim.Memory(latency=17, backpressure=pauses, seed=seed)
    frame = dynamic.render_frame(geometry, View(24, 16, max_depth=4), memory, True, True, records, progress=False)
    check = dynamic.check_frame(frame)
    assert check.same, (check.exact.examples, check.difference, check.records)
    stats = frame.result.stats
    c, moved = stats["counters"], stats["bytes"]
    shared = 64 * -(-len(geometry.info) // 2) if records else 0      # vertices read by the record unit
    assert moved["vertices"] == 64 * c["TBU_LINES"] + shared and moved["nodes_built"] + moved["lists_built"] == 32 * c["TBU_ROWS"]
    assert c["TBU_NODES"] > 100 and 0 < c["TBU_CYCLES"] < c["CYCLES"]
    spoilt = replace(frame.result, memory=frame.result.memory.copy())
    at = frame.image.regions["nodes"][0] + 8 * c["TBU_ROOT"]
    spoilt.memory[at + 1] ^= 1                                     # the root's plane
    assert dynamic.check_frame(replace(frame, result=spoilt)).difference.startswith("at root")
    if records:
        assert (c["ACCEL_CYCLES"], moved["triaccel_made"]) > (30 * len(geometry.info), 0)
        for region, text in (("info", "in 1 records of triangle information"), ("triaccel", "in 1 TriAccel records")):
            spoilt.memory[frame.image.regions[region][0]] ^= 1
            assert dynamic.check_frame(replace(frame, result=spoilt)).records.startswith(text)
    spoilt.memory[at : at + 8] = 255
    with pytest.raises(SimError, match="makes no sense"):
        dynamic.check_frame(replace(frame, result=spoilt))


def test_more_room(monkeypatch):
    """A tree that outgrows its room gets twice as much, until it has enough; other errors end it."""
    geometry = build_geometry(load_scene("tiny_glass"), in_hardware=True)
    sizes, asked = tbu.sizes, []

    def small(triangles, cap, factor=1):
        asked.append(factor)
        return sizes(triangles, cap) if factor == 4 else replace(sizes(triangles, cap), nodes=128)

    monkeypatch.setattr(tbu, "sizes", small)
    monkeypatch.setattr(dynamic, "LARGEST_FACTOR", 4)
    dynamic.render_frame(geometry, View(8, 8), progress=False)
    assert asked == [1, 2, 4]
    monkeypatch.setattr(dynamic, "LARGEST_FACTOR", 2)
    with pytest.raises(sim.FrameError, match="room for 128 nodes is too little") as error:
        dynamic.render_frame(geometry, View(8, 8), progress=False)
    assert error.value.code == dynamic.ERR_TBU_NODE and error.value.addr == 128


def test_image_without_records():
    """What the record unit reads is there, what it writes is not."""
    geometry = build_geometry(load_scene("tiny"), in_hardware=True)
    image = build_image(geometry, View(16, 8), room=tbu.sizes(27), records=True)
    for name in ("triaccel", "info"):
        assert not image.memory[slice(*image.regions[name])].any()
    assert image.memory[slice(*image.regions["attributes"])].any()
    assert image.registers["ATTR_BASE"] == image.regions["attributes"][0] and image.registers["ACCEL_SLACK"] >= 128
    alone = build_image(build_geometry(load_scene("tiny"), tbu.Params()), View(16, 8), records=True)
    result = sim.run_frame(alone.memory, alone.registers, control=sim.RECORDS | sim.RENDER, progress=False)
    plain = build_image(build_geometry(load_scene("tiny"), tbu.Params()), View(16, 8))
    other = sim.run_frame(plain.memory, plain.registers, progress=False)
    assert (result.frame == other.frame).all() and result.stats["counters"]["TBU_CYCLES"] == 0


def test_build_alone():
    """A frame without a picture leaves the tree and no pixels."""
    geometry = build_geometry(load_scene("tiny"), in_hardware=True)
    image = build_image(geometry, View(8, 8), room=tbu.sizes(27))
    result = sim.run_frame(image.memory, image.registers, control=sim.BUILD_TREE, keep_memory=True, progress=False)
    assert result.frame.size == 0 and result.stats["bytes"]["frame"] == 0
    assert result.memory[slice(*image.regions["nodes"])].any()


def test_render_command(command, tmp_path):
    out, stats = tmp_path / "a.png", tmp_path / "a.json"
    code, text, _ = command("render", "tiny", "-o", out, "--size", "16x8", "--tree", "rtl", "--accel", "rtl", "--check",
                            "--stats", stats)  # fmt: skip
    assert code == 0 and "node by node: yes" in text and "bit by bit: yes" in text and "to build the tree" in text
    values = json.loads(stats.read_text())
    assert values["tbu"]["triangles"] == 27 and values["check"]["tree"] == {"same": True, "difference": None}
    assert values["check"]["records"] == {"same": True, "difference": None}
    assert values["cycles"] == values["render_cycles"] + max(values["tbu"]["cycles"], values["records"]["cycles"])
    assert values["records"]["bytes"] == 160 * 27 + 64               # an odd number: half a line more of each that is read
    assert values["rays_per_cycle_per_rtu"] == values["rays"]["total"] / values["render_cycles"]
    assert 0 < values["tbu"]["bytes_per_triangle"] < 200
    code, _, err = command("render", "tiny", "-o", out, "--tree", "rtl", "--engine", "model")
    assert code == 2 and "only the engine rtl builds trees" in err
    code, _, err = command("render", "tiny", "-o", out, "--accel", "rtl")
    assert code == 2 and err == "raycore: --accel rtl: only with --tree rtl\n"


def test_records_of_objects(command, moving, tmp_path):
    """Of a dynamic object, whose triangles behind five static ones begin at an even number."""
    document = json.loads(moving.read_text())
    document["meshes"][1]["dynamic"] = True
    moving.write_text(json.dumps(document))
    arguments = moving, "--size", "24x16", "--accel", "rtl", "--check", "--stats", tmp_path / "s.json"
    code, text, _ = command("render", *arguments, "-o", tmp_path / "a.png", "--tree", "rtl")
    assert code == 0 and "node by node: yes" in text and "bit by bit: yes" in text and "to make records" in text
    values = json.loads((tmp_path / "s.json").read_text())
    assert values["records"]["bytes"] == 96 * 5 + 128 * 3 and values["tbu"]["triangles"] == 5
    code, text, _ = command("animate", *arguments, "-o", tmp_path / "pictures", "--frames", 2)
    assert code == 0 and text.count("same") == 2
    frames = json.loads((tmp_path / "s.json").read_text())["frames"]
    assert all(f["same"] and f["record_cycles"] > 150 for f in frames)


def test_animate_command(command, moving, tmp_path):
    folder, stats = tmp_path / "pictures", tmp_path / "s.json"
    code, text, _ = command("animate", moving, "-o", folder, "--frames", 2, "--size", "24x16", "--check", "--stats", stats)
    assert code == 0 and text.count("same") == 2
    with Picture.open(folder / "animation.png") as whole:
        assert whole.n_frames == 2 and whole.info["duration"] == 1000.0
    shots = [np.asarray(Picture.open(folder / f"frame_000{i}.png")) for i in range(2)]
    assert shots[0].shape == (16, 24, 3) and (shots[0] != shots[1]).any()
    values = json.loads(stats.read_text())
    assert [f["time"] for f in values["frames"]] == [0.0, 1.0] and all(f["same"] for f in values["frames"])
    assert values["mean"]["build_cycles"] == sum(f["build_cycles"] for f in values["frames"]) / 2


def test_differences_are_an_error(command, moving, tmp_path, monkeypatch):
    check = dynamic.check_frame
    monkeypatch.setattr(dynamic, "check_frame", lambda rendered: replace(check(rendered), difference="somewhere"))
    code, text, err = command("animate", moving, "-o", tmp_path / "f", "--frames", 1, "--size", "8x8", "--check")
    assert code == 1 and "DIFFERS" in text and "1 of 1 pictures differ" in err and "somewhere" in err


def test_wrong_animations(command, moving, tmp_path):
    for arguments, expected, says in (
        (("tiny", "-o", tmp_path / "f"), 1, "nothing moves in it"),
        ((moving, "-o", moving), 1, "is a file; give a folder"),
        ((moving, "-o", tmp_path / "no" / "f"), 1, "does not exist; make it first"),
        ((moving, "-o", tmp_path / "f", "--frames", 0), 2, "--frames 0"),
        ((moving, "-o", tmp_path / "f", "--fps", 0), 2, "--fps 0"),
    ):
        code, _, err = command("animate", *arguments)
        assert code == expected and says in err and err.count("\n") == 1, arguments


def test_times(moving):
    assert animate.times(moving, 4) == [0.0, 0.5, 1.0, 1.5]
    assert animate.times(moving, 3, 10) == [0.0, 0.1, 0.2]
    with pytest.raises(OptionError):
        animate.times(moving, 100_000)
    with pytest.raises(SceneError):
        animate.times("tiny", 3)


@pytest.mark.parametrize("name", ["pendulum", "carousel", "dice"])
def test_our_scenes_move(name):
    """They load at any time, are small, keep their bounds, and come round to where they began."""
    first = load_scene(name)
    later = load_scene(name, 0.3 * first.duration)
    again = load_scene(name, first.duration)
    assert 1000 < len(first.triangles) < 12000 and first.camera and first.lights and not first.warnings
    assert len(later.triangles) == len(first.triangles) and (later.bounds == first.bounds).all()
    moved = (later.triangles != first.triangles).any(axis=(1, 2)).mean()
    assert 0.05 < moved < 0.999
    np.testing.assert_allclose(again.triangles, first.triangles, atol=1e-9)


def test_regression_has_such_frames():
    for level in ("quick", "normal"):
        built = [c for c in regress.frame_cases(level, 1) if c.build]
        assert built and all("built" in c.name for c in built)
    assert {c.scene for c in built if c.records} >= {"chess", "pendulum", "dice", "carousel"}
