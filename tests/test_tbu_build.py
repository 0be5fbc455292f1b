# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""`raycore build` and trees of the tree builder in the rest of the package; the hardware is played by the model."""

import json
from dataclasses import replace

import numpy as np
import pytest

from raycore import build as building
from raycore import cli, image, kdtree, sim, tbu
from raycore.errors import SceneError, SimError
from raycore.model import tbu as model
from raycore.model.tbu_memory import JUMP
from raycore.scene import load_scene

COUNTERS = dict.fromkeys(building.STATISTICS, 3) | {"cycles": 5000, "lines": 70, "rows": 40}


@pytest.fixture(scope="module")
def scene():
    return load_scene("tiny_glass")


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
def obj(tmp_path):
    path = tmp_path / "tent.obj"
    path.write_text("v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1 0\nf 1 3 2\nf 1 4 3\nf 1 5 4\nf 2 5 1\nf 3 5 2\n")
    return path


def hardware(change=lambda image, run: run):
    """A stand-in for `building.run_hardware`; change: what it does to the model's result."""

    def call(image, memory):
        return change(image, replace(building.run_model(image), counters=dict(COUNTERS)))

    return call


def view(run, image, name, kind):
    lo, hi = image.regions[name]
    return run.memory[lo:hi].view(kind)


def test_image(scene):
    """Regions follow each other in whole lines; the configuration names them; vertices are where it says."""
    made = building.build_image(scene)
    at = 0x1000
    for lo, hi in made.regions.values():
        assert lo == at and lo % 64 == hi % 64 == 0
        at = hi
    assert at == len(made.memory)
    c = made.config
    places = {n: c[f"{f}_base"] * 64 for n, f in zip(made.regions, ("vertex", "node", "list", "ref"))}
    assert places == {n: lo for n, (lo, _) in made.regions.items()}
    sizes = {"nodes": 8 * c["node_count"], "lists": 4 * c["list_count"], "working": 16 * c["ref_count"]}
    assert all(hi - lo == sizes.get(n, hi - lo) for n, (lo, hi) in made.regions.items())
    opaque = np.array([m.opaque for m in scene.materials])[scene.face_material]
    assert 0 < opaque.sum() < len(opaque) and (made.refs.opaque == opaque).all()
    records = tbu.vertex_records(made.unit, opaque)
    lo = made.regions["vertices"][0]
    assert made.memory[lo:][: records.nbytes].tobytes() == records.tobytes()
    assert c["tri_count"] == len(scene.triangles)
    assert [c["box"] >> 18 * i & 0x3FFFF for i in range(6)] == made.refs.box.reshape(-1).tolist()


def test_build_by_the_model(scene):
    built = building.build(scene, "model")
    values = building.stats(built, scene)
    assert built.difference is None and values["check"]["same_tree"]
    assert values["cycles"] is None and values["bytes_per_triangle"] is None
    assert values["triangles"] == 114 and values["nodes"] == len(built.tree)
    assert values["sah_ratio"] == pytest.approx(1.0)
    assert values["waste"] == {"nodes": 0, "entries": 0, "share": 0.0}
    walk = kdtree.walk(built.kdtree)
    assert len(walk.index) == len(built.tree) and kdtree.sah_cost(built.kdtree) == pytest.approx(values["sah_cost"])
    json.dumps(values)


def test_build_by_the_rtl(scene):
    """The model's tree, by the Verilated unit, whatever the memory's timing; bytes follow from the counters."""
    for memory in (sim.Memory(), sim.Memory(latency=7, outstanding=3, backpressure=0.4, seed=5)):
        built = building.build(scene, "rtl", memory)
        values = building.stats(built, scene, memory)
        assert built.difference is None and values["check"]["same_tree"]
        c = values["counters"]
        assert c["nodes"] == len(built.tree) + built.tree.jumps and c["entries"] == values["list_entries"]
        assert c["jobs"] == 1 and c["lines"] == 57 and values["cycles"] > 114


def test_hardware_figures(scene, monkeypatch):
    """Nodes elsewhere in the region, reached by a jump: the same tree, and what was left open is counted."""

    def scatter(image, run):
        nodes, lists = view(run, image, "nodes", "<u8"), view(run, image, "lists", "<u4")
        count = image.config["node_count"]
        size = count - run.root
        nodes[count - 500 - size : count - 500] = nodes[run.root :]
        moved = nodes[count - 500 - size : count - 500]
        inner = (moved >> np.uint64(24) & np.uint64(3) != 3) & (moved >> np.uint64(29) & np.uint64(0xFFFFFF) != 0)
        moved[inner] -= np.uint64(500 << 29)
        nodes[run.root :] = 0
        nodes[count - 1] = JUMP | (run.root - 500) << 29
        many = (moved & np.uint64(3 << 24) == 3 << 24) & (moved & np.uint64(0xFFFFF) > 1)
        moved[many] += np.uint64(300 << 29)
        lists[300:][:2000] = lists[:2000].copy()
        lists[:300] = 0
        return replace(run, root=count - 1)

    monkeypatch.setattr(building, "run_hardware", hardware(scatter))
    built = building.build(scene, "rtl")
    values = building.stats(built, scene, sim.Memory())
    n, size = len(scene.triangles), len(built.tree)
    assert built.difference is None and built.tree.jumps == values["jump_nodes"] == 1
    assert values["cycles_per_triangle"] == 5000 / n and values["bytes_per_triangle"] == (70 * 64 + 40 * 32) / n
    entries = values["list_entries"]
    assert values["waste"]["nodes"] == -(-(500 + size) // 128) * 128 - size - 1
    assert values["waste"]["entries"] == -(-(300 + entries) // 256) * 256 - entries
    assert dict(building.summary(values))["cycles"].startswith("5,000")


def test_waste_without_lists(scene, monkeypatch):
    """Leaves of one triangle hold its number and no list: 600 triangles apart from each other take no list extent."""
    place = np.stack(np.meshgrid(np.arange(30.0), np.arange(20.0), [0.0], indexing="ij"), axis=-1).reshape(-1, 1, 3)
    apart = replace(
        scene,
        triangles=place + 0.2 * np.array([(0.0, 0.0, 0.0), (1.0, 0.1, 0.2), (0.3, 1.0, 0.4)]),
        face_material=np.zeros(600, np.int32),
    )
    monkeypatch.setattr(building, "run_hardware", hardware())
    built = building.build(apart, "rtl", params=tbu.Params(max_leaf=1))
    values = building.stats(built, apart)
    assert values["list_entries"] == values["waste"]["entries"] == 0 and values["leaves"] == 600


def test_wrong_hardware(scene, monkeypatch, command, tmp_path):
    """A tree that is not the model's is told with its place, after the figures are written; nonsense is an error."""

    def swap(image, run):
        lists = view(run, image, "lists", "<u4")
        lists[0] ^= 1
        return run

    monkeypatch.setattr(building, "run_hardware", hardware(swap))
    path = tmp_path / "stats.json"
    code, out, err = command("build", "tiny_glass", "--stats", path)
    assert code == 1 and "differs from the model's at" in err and "leaf of" in err and "3 leaves were made" in err
    assert not json.loads(path.read_text())["check"]["same_tree"]
    monkeypatch.setattr(building, "run_hardware", hardware(lambda image, run: replace(run, root=0)))
    code, out, err = command("build", "tiny_glass")
    assert code == 1 or "differs" in err
    monkeypatch.setattr(
        building, "run_hardware", hardware(lambda image, run: replace(run, root=image.config["node_count"]))
    )
    code, out, err = command("build", "tiny_glass")
    assert code == 1 and "makes no sense" in err


@pytest.mark.parametrize("error", [1, 2, 3])
def test_overflow_doubles_the_room(scene, monkeypatch, error):
    asked = []

    def call(image, run):
        asked.append(image.config["ref_count"] - 16 * image.params.cap - 64)
        return run if image.factor == 4 else replace(run, error=error)

    monkeypatch.setattr(building, "run_hardware", hardware(call))
    built = building.build(scene, "rtl")
    assert built.image.factor == 4 and asked == [-(-3 * 114 * f // 4) * 4 for f in (1, 2, 4)]
    monkeypatch.setattr(building, "run_hardware", hardware(lambda image, run: replace(run, error=error)))
    with pytest.raises(SimError, match=building.OVERFLOWS[error]):
        building.build(scene, "rtl")


def test_other_errors(scene, monkeypatch):
    monkeypatch.setattr(building, "run_hardware", hardware(lambda image, run: replace(run, error=6)))
    with pytest.raises(SimError, match="memory answered"):
        building.build(scene, "rtl")


def test_too_many_triangles(scene):
    n = model.MAX_TRIANGLES + 1
    many = replace(scene, triangles=np.broadcast_to(scene.triangles[:1], (n, 3, 3)))
    with pytest.raises(SceneError, match="numbers 524288"):
        tbu.snap(many)


def test_command(command, obj, tmp_path):
    path = tmp_path / "stats.json"
    code, out, err = command("build", obj, "--engine", "model", "--stats", path)
    assert (code, err) == (0, "") and str(path) in out and "SAH cost" in out
    values = json.loads(path.read_text())
    for key in ("triangles", "cycles", "cycles_per_triangle", "bytes_per_triangle", "sah_cost", "sah_cost_exact"):
        assert key in values
    assert values["triangles"] == 5 and values["config"]["file"] == str(obj)
    code, _, err = command("build", obj, "--mem-width", "128")
    assert code == 2 and "64 bits" in err
    code, _, err = command("build", obj, "--engine", "model", "--stats", tmp_path)
    assert code == 1 and "directory" in err
    code, _, err = command("build", obj, "--mem-width", "96")
    assert code == 2 and err.count("\n") == 1


def test_geometry_takes_the_units_tree(scene):
    """`image.build_geometry` with `tbu.Params`: triangles on the grid, flags of opaque ones, a tree of the model."""
    geometry = image.build_geometry(scene, tbu.Params(cap=16, refine_max=0))
    unit = tbu.snap(scene)
    assert (geometry.unit.triangles == unit.triangles).all()
    lists = geometry.tree.lists
    assert ((lists >> 25 & 1 == 1) == geometry.opaque[lists & 0xFFFFFF]).all()
    refs = tbu.references(unit, geometry.opaque)
    expected = model.build(refs, cap=16, refine_max=0)
    assert kdtree.sah_cost(geometry.tree) == pytest.approx(tbu.sah_cost(expected))
    assert (geometry.opaque == building.opaque_triangles(scene)).all()


def test_rays_pass_jump_nodes(scene):
    """Every ray goes on through a jump node, whatever its direction: same hits, bit for bit, as without any."""
    from test_tbu import scattered

    from raycore.model import fp24, rgen, tracer

    rng = np.random.default_rng(20140615)
    made = image.build_image(image.build_geometry(scene, tbu.Params(cap=16)))
    tree = made.geometry.tree
    accel = image.region_words(made, "triaccel", len(scene.triangles), 4)
    box = np.array([image.register_vector(made, "BOX_LO_"), image.register_vector(made, "BOX_HI_")])
    n = 3000
    origin = fp24.round_to_fp24(rng.uniform(-1.5, 1.5, (n, 3)))
    aim = made.geometry.unit.triangles.mean(axis=1)[rng.integers(0, len(scene.triangles), n)]
    direction = (aim - origin) * rng.choice([0.1, 1.0, 40.0], (n, 1))
    direction[::2] *= rng.choice([1.0, 1e-6, 0.0, -0.0], (n // 2, 3))
    direction[(direction == 0.0).all(axis=1)] = (-1.0, 0.0, 0.0)
    direction = fp24.round_to_fp24(direction)
    inverse = np.vectorize(rgen.inverse)(direction)
    limits = np.full(n, tracer.T_MIN), np.full(n, tracer.HUGE), np.full(n, tracer.TRI_NONE), np.full(n, tracer.NOT_PLACED)
    limits = *limits, rng.random(n) < 0.3

    def trace(nodes):
        arrays = tracer.decode(nodes, tree.lists, accel, box, tree.root)
        return tracer.trace_rays(arrays, origin, direction, inverse, *limits)

    plain = trace(tree.nodes)
    assert 0.05 < (plain[0] != tracer.TRI_NONE).mean() < 0.95
    for _ in range(5):
        jumping = trace(scattered(tree.nodes, tree.root, rng))
        for before, after in zip(plain[:-1], jumping[:-1]):
            assert np.array_equal(before, after)
        assert jumping[-1].sum() > plain[-1].sum()
