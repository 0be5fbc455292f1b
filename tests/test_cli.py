# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The command line: what it writes, and that wrong input ends with one clear line and nothing left behind."""

import json
import re

import numpy as np
import pytest
from PIL import Image as Picture

from raycore import cli, regress, sim
from raycore.check import channels
from raycore.image import View, build_image
from raycore.model.frame import render_fp24
from raycore.scene import load_scene, parse_camera, parse_light

OBJ = """
v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
v 0 1 0
f 1 3 2
f 1 4 3
f 1 5 4
f 2 5 1
f 3 5 2
"""
VIEW = ("--camera", "2,2.5,4:0,0.3,0:0,1,0:40", "--light", "-3,4,2", "--light", "2,5,1:0.3,0.3,0.4")


@pytest.fixture
def run(capfd, monkeypatch):
    """Run the command in this process: (exit code, stdout, stderr)."""
    monkeypatch.delenv("RAYCORE_DEBUG", raising=False)

    def call(*arguments):
        with pytest.raises(SystemExit) as end:
            cli.app([str(a) for a in arguments])
        out, err = capfd.readouterr()
        return end.value.code or 0, out, err

    return call


@pytest.fixture
def obj(tmp_path):
    path = tmp_path / "tent.obj"
    path.write_text(OBJ)
    return path


# ---- what it writes ----------------------------------------------------------------------------------------------------------


def test_tree_by_the_host(run, obj, tmp_path):
    """--tree host is the default, and cpu another name of it; the tree builder's is another tree."""
    rules = []
    for number, who in enumerate([(), ("--tree", "host"), ("--tree", "cpu"), ("--tree", "model")]):
        stats = tmp_path / f"{number}.json"
        size = ("--size", "40x24", "--engine", "model", "--stats", stats)
        code, _, err = run("render", obj, "-o", tmp_path / "a.png", *size, *who)
        assert code == 0, err
        rules.append(json.loads(stats.read_text())["config"]["tree"])
    assert rules[0] == rules[1] == rules[2] != rules[3]


def test_render_by_the_reference(run, obj, tmp_path):
    png, stats, aov = tmp_path / "a.png", tmp_path / "a.json", tmp_path / "a.npz"
    code, out, err = run(
        *("render", obj, "-o", png, "--size", "61x34", *VIEW, "--engine", "model", "--stats", stats, "--aov", aov)
    )
    assert (code, err) == (0, "")
    assert "61x34" in out and str(png) in out

    scene = load_scene(obj)
    lights = [parse_light("-3,4,2"), parse_light("2,5,1:0.3,0.3,0.4")]
    frame = render_fp24(build_image(scene, View(61, 34, parse_camera(VIEW[1]), lights)))
    assert np.array_equal(np.asarray(Picture.open(png)), channels(frame.pixels))

    values = json.loads(stats.read_text())
    traced = sum(n for kind, n in frame.rays.items() if kind != "culled")
    assert values["rays"] == frame.rays | {"total": traced} and values["rays"]["reflect"] == 0
    assert {kind: sum(n) for kind, n in values["rays_by_depth"].items()} | {"culled": frame.culled} == frame.rays
    assert sum(values["slots"].values()) == frame.slots.sum()
    assert np.isclose(values["slots_per_ray"] * values["rays"]["total"], frame.slots.sum())
    config = values["config"]
    assert config["size"] == [61, 34] and config["camera"]["fov"] == 40 and len(config["lights"]) == 2
    assert config["memory"] == {"width": 64, "latency": 60, "outstanding": 16, "backpressure": 0.0, "seed": 1}
    assert config["tree"]["max_depth"] == 32 and config["caches"]["l2"]["sets"] > 0

    hits = np.load(aov)
    assert set(hits.files) == {"tri", "t", "triangles", "ray_origin", "ray_dir"}
    assert hits["tri"].dtype == np.int32 and hits["tri"].shape == hits["t"].shape == (34, 61)
    assert np.array_equal(hits["tri"], frame.tri) and np.array_equal(hits["triangles"], scene.triangles)
    assert np.allclose(np.linalg.norm(hits["ray_dir"], axis=2), 1.0, atol=1e-12)
    assert np.allclose(hits["ray_origin"], (2.0, 2.5, 4.0), atol=1e-4) and hits["ray_origin"].shape == (34, 61, 3)
    seen = hits["tri"] >= 0
    assert 100 < seen.sum() < seen.size and np.isinf(hits["t"][~seen]).all()
    points = hits["ray_origin"] + np.where(seen, hits["t"], 0.0)[..., None] * hits["ray_dir"]
    a, b, c = (hits["triangles"][hits["tri"][seen], i] for i in range(3))
    normal = np.cross(b - a, c - a)
    off = np.einsum("ij,ij->i", points[seen] - a, normal) / np.linalg.norm(normal, axis=1)
    assert np.abs(off).max() < 3e-4  # world units; the scene is 2 wide, an ulp of t is 6e-5


def test_the_top_row_is_the_top(run, tmp_path):
    """A triangle that fills the upper half of the view is in the upper rows, one on the right in the right columns."""
    path = tmp_path / "half.obj"
    path.write_text("v -9 0.1 0\nv 9 0.1 0\nv 0 20 0\nf 1 2 3\nv 0.5 -9 0\nv 20 -9 0\nv 0.5 0 0\nf 4 5 6\n")
    aov, png = tmp_path / "a.npz", tmp_path / "a.png"
    view = ("--camera", "0,0,2:0,0,0:0,1,0:90", "--light", "0,0,5")
    code, _, _ = run("render", path, "-o", png, "--size", "40x40", *view, "--engine", "model", "--aov", aov)
    tri = np.load(aov)["tri"]
    assert code == 0
    assert (tri[:18, 5:35] == 0).all() and not (tri[20:] == 0).any()
    assert (tri[30:35, 26:30] == 1).all() and not (tri[:, :24] == 1).any()
    rgb = np.asarray(Picture.open(png)).astype(int)
    assert (rgb[5, 20] != rgb[35, 5]).any()


def test_check_by_the_reference(run, obj, tmp_path):
    png, stats = tmp_path / "a.png", tmp_path / "a.json"
    code, out, err = run("render", obj, "-o", png, "--size", "40x24", "--engine", "model", "--check", "--stats", stats)
    assert (code, err) == (0, "")
    assert "PSNR" in out and "Embree" in out and "MISSED" not in out
    assert Picture.open(tmp_path / "a.diff.png").size == (40, 24)
    found = json.loads(stats.read_text())["check"]
    assert found["embree"]["same_hit"] > 0.999 and found["embree"]["holes"] == 0 and "rtl" not in found


def test_double_precision_engine(run, obj, tmp_path):
    code, out, _ = run("render", obj, "-o", tmp_path / "a.png", "--size", "20x12", "--engine", "double", "--no-shadows")
    assert code == 0 and "0 shadow" in out


def test_render_by_the_rtl(run, tmp_path):
    """The tiny scene through the Verilated RTL: every pixel, hit and counter is the reference's."""
    png, stats, aov = tmp_path / "a.png", tmp_path / "a.json", tmp_path / "a.npz"
    code, out, err = run("render", "tiny", "-o", png, "--size", "36x20", "--stats", stats, "--aov", aov, "--check")
    assert code == 0, err
    values = json.loads(stats.read_text())
    found = values["check"]["rtl"]
    assert (found["pixel_mismatches"], found["hit_mismatches"], found["counter_mismatches"]) == (0, 0, {})
    assert found["rays_compared"] == values["rays"]["total"]
    frame = render_fp24(build_image(load_scene("tiny"), View(36, 20)))
    assert np.array_equal(np.asarray(Picture.open(png)), channels(frame.pixels))
    assert np.array_equal(np.load(aov)["tri"], frame.tri)

    cycles, rays = values["cycles"], values["rays"]["total"]
    slots = {name: n for name, n in values["slots"].items() if name != "bubble"}
    assert np.isclose(values["rays_per_cycle_per_rtu"], rays / cycles)
    assert np.isclose(values["slots_per_ray"], sum(slots.values()) / rays)
    assert np.isclose(values["occupancy"], sum(slots.values()) / (4 * cycles)) and 0.0 < values["occupancy"] <= 1.0
    assert {"nodes", "lists", "triaccel", "info", "materials", "lights", "frame"} <= set(values["bytes"])
    assert values["bytes"]["frame"] >= 36 * 20 * 4
    for cache in ("l1_node", "l1_list", "l2", "triangle"):
        assert values["cache"][cache]["hits"] + values["cache"][cache]["misses"] > 0
    assert {kind: sum(values["rays_by_depth"][kind]) for kind in sim.RAY_KINDS} == {
        kind: values["rays"][kind] for kind in sim.RAY_KINDS
    }


ROOM = {
    "meshes": [{"file": "tent.obj", "material": "pane"}, {"file": "floor.obj", "material": "floor"}],
    "materials": {
        "pane": {"diffuse": [0.1, 0.1, 0.1], "reflect": [0.2, 0.2, 0.2], "transmit": [0.7, 0.7, 0.7], "ior": 1.2},
        "floor": {"diffuse": [1, 1, 1], "texture": {"file": "checks.png", "wrap_s": "mirror"}},
    },
    "camera": {"eye": [2, 2.5, 4], "target": [0, 0.3, 0], "fov": 40},
    "lights": [{"position": [-3, 4, 2]}],
    "background": [0.02, 0.03, 0.05],
}
FLOOR = (
    "v -4 -0.1 -4\nv 4 -0.1 -4\nv 4 -0.1 4\nv -4 -0.1 4\nvt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\nf 1/1 3/3 2/2\nf 1/1 4/4 3/3\n"
)


@pytest.fixture
def room(obj, tmp_path):
    """A glass tent on a textured floor."""
    (tmp_path / "floor.obj").write_text(FLOOR)
    checks = np.kron(np.indices((4, 4)).sum(axis=0) % 2, np.ones((8, 8))).astype(np.uint8)
    picture = np.array([[20, 40, 90, 255], [230, 200, 60, 255]], np.uint8)[checks]
    Picture.fromarray(picture).save(tmp_path / "checks.png")
    path = tmp_path / "room.json"
    path.write_text(json.dumps(ROOM))
    return path


def test_bounces_and_textures(run, room, tmp_path):
    """Options reach the picture: depth, least weight, textures, filter; each changes what it should and is reported."""

    def shot(*options):
        png, stats = tmp_path / "a.png", tmp_path / "a.json"
        code, out, err = run(
            *("render", room, "-o", png, "--size", "60x40", "--engine", "model", "--stats", stats, *options)
        )
        assert (code, err) == (0, ""), err
        return np.asarray(Picture.open(png)).astype(int), json.loads(stats.read_text()), out

    picture, values, out = shot()
    assert values["config"]["max_depth"] == 4 and values["config"]["textures"] == 1 and "depth 4" in out
    assert len(values["rays_by_depth"]["transmit"]) == 5 and values["rays"]["reflect"] > 100
    assert "transmitted" in out and "rays by depth" in out
    flat, values, _ = shot("--depth", "0")
    assert values["rays"]["reflect"] == values["rays"]["transmit"] == 0 and (flat != picture).any()
    _, deep, _ = shot("--depth", "15", "--min-weight", "0")
    _, light, _ = shot("--depth", "15", "--min-weight", "0.3")
    assert light["rays"]["total"] < deep["rays"]["total"]
    plain, values, _ = shot("--no-textures")
    assert values["config"]["textures"] == 0 and (plain != picture).any()
    assert np.abs(plain.mean(axis=(0, 1)) - picture.mean(axis=(0, 1))).max() < 12, "the mean colour takes its place"
    compact, _, _ = shot("--compact-textures")
    assert 0 < np.abs(compact - picture).max() < 24
    smooth, values, _ = shot("--trilinear")
    assert values["config"]["trilinear"] and (smooth != picture).any()


def test_srgb(run, room, tmp_path):
    """--srgb encodes ten linear bits; without it the frame buffer's bytes are kept."""
    for name, options in (("linear", ()), ("srgb", ("--srgb",))):
        code, _, err = run(
            *("render", room, "-o", tmp_path / f"{name}.png", "--size", "40x30", "--engine", "model", *options)
        )
        assert (code, err) == (0, "")
    linear = np.asarray(Picture.open(tmp_path / "linear.png")) / 255.0
    encoded = Picture.open(tmp_path / "srgb.png")
    assert "srgb" in encoded.info
    value = np.asarray(encoded) / 255.0
    decoded = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    assert np.abs(decoded - linear).max() < 0.5 / 255 + 0.5 / 1023 + 2.3 * 0.5 / 255
    dark = linear < 0.1
    assert len(np.unique(np.asarray(encoded)[dark])) > len(
        np.unique(np.asarray(Picture.open(tmp_path / "linear.png"))[dark])
    )


def test_notes(run, obj, tmp_path):
    """What a file asks for and does not get is said on stderr, a line each, and in what info prints."""
    obj.write_text("mtllib nowhere.mtl\n" + OBJ.replace("\nf", "\nusemtl red\nf", 1))
    code, _, err = run("render", obj, "-o", tmp_path / "a.png", "--size", "8x8", "--engine", "model")
    assert code == 0 and len(err.splitlines()) == 2
    assert all(line.startswith("raycore: note: ") for line in err.splitlines()) and "nowhere.mtl" in err
    code, out, err = run("info", obj, "--json")
    assert code == 0 and not err and len(json.loads(out)["warnings"]) == 2


def test_info_of_materials(run, room):
    code, out, _ = run("info", room, "--json")
    values = json.loads(out)
    assert code == 0 and values["default_depth"] == 4
    assert values["materials_by_kind"] == {
        "glass": {"materials": 1, "textured": 0, "triangles": 5},
        "plain": {"materials": 1, "textured": 1, "triangles": 2},
    }
    assert values["textures"] == [
        {"name": "checks.png", "size": [32, 32], "levels": 6, "format": "RGBA8", "wrap": ["mirror", "repeat"]}
    ]
    assert values["bytes"]["uv"] == 7 * 32 + 32 and values["bytes"]["materials"] == 2 * 128
    assert values["bytes"]["textures"] == 64 * (64 + 16 + 4 + 1 + 1 + 1)
    code, out, _ = run("info", room, "--compact-textures")
    assert code == 0 and "checks.png, 32x32, 6 levels, RGBA5551" in out and "1 glass (5 triangles)" in out
    code, out, _ = run("info", room, "--no-textures", "--json")
    assert json.loads(out)["textures"] == [] and json.loads(out)["bytes"]["textures"] == 0


def test_info(run, obj):
    code, out, err = run("info", obj, "--json")
    values = json.loads(out)
    assert (code, err) == (0, "") and values["triangles"] == 5
    assert values["bounds"] == [[-1, 0, -1], [1, 1, 1]]
    assert values["bytes"]["info"] == 5 * 64 and values["bytes"]["triaccel"] == 192
    assert {"nodes", "leaves", "empty_leaves", "depth", "sah_cost", "list_entries"} <= set(values)
    code, out, _ = run("info", obj)
    assert code == 0 and re.search(r"^triangles +5 ", out, re.M)


@pytest.mark.parametrize("arguments", [("--help",), ("render", "--help"), ("info", "--help")])
def test_help_teaches(run, arguments):
    code, out, _ = run(*arguments)
    assert code == 0
    assert "raycore" in out and ("Examples" in out or len(arguments) == 1)


def test_version(run):
    assert re.fullmatch(r"raycore \d+\.\d+\.\d+\n", run("version")[1])


# ---- wrong input -------------------------------------------------------------------------------------------------------------


def files(folder):
    """Scene files that are no scenes."""
    (folder / "empty.obj").write_text("")
    (folder / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    (folder / "nan.obj").write_text("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
    (folder / "broken.glb").write_bytes(b"glTF" + bytes(40))
    (folder / "broken.ply").write_text("ply\nformat ascii 1.0\nelement vertex 9\n")
    (folder / "text.txt").write_text("hello")
    (folder / "broken.json").write_text('{"meshes": [{"file": "points.obj"}], "depth": 99}')


WRONG_SCENES = {
    "missing.obj": "no such file",
    "empty.obj": "empty",
    "points.obj": "no triangles",
    "nan.obj": "NaN",
    "flat.obj": "area",
    "broken.glb": "cannot be read",
    "broken.ply": "cannot be read|no triangles",
    "text.txt": "not supported",
    "broken.json": "depth: 99 is greater than the maximum of 15",
    ".": "is a directory",
}
WRONG_OPTIONS = [
    (("--size", "abc"), "--size abc: expected WIDTHxHEIGHT"),
    (("--size", "0x10"), "picture size 0x10"),
    (("--size", "-5x10"), "--size -5x10"),
    (("--size", "99999x10"), "picture size 99999x10"),
    (("--size", "16384x16384"), "at most 64 Mpixel"),
    (("--colour", "red"), "--colour"),
    (("--camera", "1,2"), "camera '1,2'"),
    (("--camera", "0,0,1:0,0,1"), "same point"),
    (("--camera", "0,0,1:0,0,0:0,0,1"), "up vector"),
    (("--camera", "0,0,1:0,0,0:0,1,0:180"), "field of view"),
    (("--camera", "nan,0,1:0,0,0"), "nan"),
    (("--light", "1,2"), "light"),
    (("--light", "1,2,x"), "light"),
    (("--light", "1,2,3:-1,0,0"), "light colour"),
    (("--light", "0,0,1e30"), "times the scene's size away"),
    (("--light", "1,2,3") * 17, "17 lights"),
    (("--mem-latency", "0"), "memory latency"),
    (("--mem-latency", "soon"), "mem-latency"),
    (("--mem-width", "65"), "memory width"),
    (("--backpressure", "1.5"), "back-pressure"),
    (("--seed", "-1"), "seed"),
    (("--engine", "gpu"), "engine"),
    (("--depth", "16"), "depth 16: give 0 to 15"),
    (("--depth", "-1"), "depth -1"),
    (("--depth", "deep"), "--depth"),
    (("--min-weight", "1"), "least weight 1"),
    (("--min-weight", "-0.1"), "least weight -0.1"),
    (("--min-weight", "nan"), "least weight nan"),
    (("--waves", "w.fst"), "waveforms"),
    (("--rtus", "0"), "--rtus 0: there can be 1 to 16"),
    (("--rtus", "17"), "--rtus 17"),
    (("--rtus", "2"), "only the engine rtl"),
    (("--stats", "nowhere/s.json"), "does not exist"),
    (("--aov", "."), "is a directory"),
]


def one_line(err):
    assert err.startswith("raycore: ") and err.count("\n") == 1 and err.endswith("\n"), err


@pytest.mark.parametrize("command", ["render", "info"])
@pytest.mark.parametrize("name", WRONG_SCENES)
def test_wrong_scenes(run, tmp_path, command, name):
    files(tmp_path)
    before = sorted(p.name for p in tmp_path.iterdir())
    extra = ("-o", tmp_path / "a.png", "--engine", "model") if command == "render" else ()
    code, out, err = run(command, tmp_path / name, *extra)
    one_line(err)
    assert code in (1, 2) and not out and re.search(WRONG_SCENES[name], err)
    assert sorted(p.name for p in tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    "options, message", WRONG_OPTIONS, ids=lambda v: " ".join(v[:2]) if isinstance(v, tuple) else ""
)
def test_wrong_options(run, obj, tmp_path, monkeypatch, options, message):
    monkeypatch.chdir(tmp_path)
    engine = () if "--engine" in options else ("--engine", "model")
    code, out, err = run("render", obj, "-o", "a.png", "--size", "16x8", *engine, *options)
    one_line(err)
    assert code in (1, 2) and not out and message in err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["tent.obj"]


@pytest.mark.parametrize("output", [".", "nowhere/a.png", "/proc/a.png"])
def test_outputs_that_cannot_be_written(run, obj, tmp_path, monkeypatch, output):
    monkeypatch.chdir(tmp_path)
    code, _, err = run("render", obj, "-o", output, "--engine", "model")
    one_line(err)
    assert code == 1 and output in err


def test_outputs_must_differ(run, obj, tmp_path):
    code, _, err = run("render", obj, "-o", tmp_path / "a", "--stats", tmp_path / "a", "--engine", "model")
    one_line(err)
    assert code == 2 and "same name" in err


@pytest.mark.parametrize("arguments", [("paint",), ("render", "x.obj"), ("--size",)])
def test_wrong_commands(run, arguments):
    code, _, err = run(*arguments)
    one_line(err)
    assert code == 2


def test_a_failed_run_keeps_the_old_picture(run, obj, tmp_path, monkeypatch):
    png = tmp_path / "a.png"
    png.write_bytes(b"old")
    monkeypatch.setattr("raycore.model.frame.render_fp24", lambda image: 1 / 0)
    code, _, err = run("render", obj, "-o", png, "--engine", "model")
    one_line(err)
    assert code == 1 and "internal error, ZeroDivisionError" in err
    assert png.read_bytes() == b"old" and len(list(tmp_path.iterdir())) == 2


def test_differences_end_with_a_failure(run, tmp_path, monkeypatch):
    """A simulation whose picture is not the reference's must not look like a success."""
    image = build_image(load_scene("tiny"), View(16, 8))
    frame = render_fp24(image)

    def wrong(*_, **__):
        pixels = frame.pixels.copy()
        pixels[0, 0] ^= 1
        return sim.SimResult(pixels, np.empty(0, sim.HIT_DTYPE), {"counters": COUNTERS, "bytes": {}})

    monkeypatch.setattr(sim, "build", lambda **_: None)
    monkeypatch.setattr(sim, "run_frame", wrong)
    code, out, err = run("render", "tiny", "-o", tmp_path / "a.png", "--size", "16x8", "--check")
    one_line(err)
    assert code == 1 and "differs from the reference in 1 pixels" in err and "pixel 0,0" in out


COUNTERS = dict.fromkeys(
    (
        *("CYCLES", "RAYS_PRIMARY", "RAYS_SHADOW", "RAYS_CULLED", "SLOTS_BUBBLE", "NT_HITS", "LIST_HITS"),
        *("L2_HITS", "L2_MISSES", "TRI_HITS", "TRI_MISSES", "RAYS_REFLECT", "RAYS_TRANSMIT"),
        *("UV_HITS", "UV_MISSES", "TEX_HITS", "TEX_MISSES"),
        *(f"SLOTS_{mode}" for mode in ("BOX", "TRAV1", "TRAV2", "ISECT", "MISS_NT", "MISS_LIST")),
    ),
    1,
)


# ---- the regression's own parts ----------------------------------------------------------------------------------------------


def test_cases_have_names_of_their_own():
    for level in ("quick", "normal"):
        names = [c.name for c in (*regress.frame_cases(level, 1), *regress.fault_cases(level, 1))]
        assert len(set(names)) == len(names)
    assert len(regress.fault_cases("normal", 1)) >= 200


def test_faults_repeat_and_reach_every_region():
    images = regress.Images()
    clean = {"axi": {"read_bursts": 500, "write_bursts": 48}}
    kinds = set()
    for case in regress.fault_cases("normal", 1):
        if case.build:
            continue
        image = images.image(case.scene, regress.FAULT_VIEW)
        memory, faults, model, _, what = regress.spoil(case, image, clean)
        again = regress.spoil(case, image, clean)
        assert np.array_equal(memory, again[0]) and (faults, model, what) == (again[1], again[2], again[4])
        assert (memory != image.memory).any() == (not faults)
        kinds.add(faults[0][0] if faults else what.split()[-1])
    assert kinds >= set(regress.FLIPPED)
    assert kinds >= {f"{k}-{w}" for k in ("slverr", "decerr") for w in ("at", "write-at", "addr")}


@pytest.mark.parametrize("outcome, ok", [("done", False), ("code 6", True), ("code 7", False), ("hang", False)])
def test_a_fault_must_end_as_it_should(monkeypatch, outcome, ok):
    image = regress.Images().image("tiny", regress.FAULT_VIEW)
    monkeypatch.setattr(regress, "spoil", lambda *_: (image.memory, [], sim.Memory(), (6,), "slverr-at 1"))

    def run_frame(*_, **__):
        if outcome == "hang":
            raise sim.SimError("nothing happened")
        if outcome != "done":
            raise sim.FrameError("error", int(outcome[-1]), 0, {})
        return sim.SimResult(None, None, {"counters": {"CYCLES": 1}})

    monkeypatch.setattr(sim, "run_frame", run_frame)
    assert regress.run_fault(regress.FaultCase(1), image, {}).ok == ok
