# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""A tree built by the tree-building unit: its memory before, the run, its memory after, and what is known about the tree.

`raycore build` is this module on the command line; docs/tbu.md says what the unit does with the memory.
"""

import time
from dataclasses import asdict, dataclass, field

import numpy as np

from raycore import __version__, kdtree, sim, tbu, tbu_sim
from raycore.errors import SceneError, SimError
from raycore.image import ALIGN, FIRST_ADDRESS
from raycore.model import tbu as model
from raycore.model.tbu_memory import compare, emit, pack_box, sah_cost, walk_memory
from raycore.scene import Normalised

ENGINES = ("rtl", "model")
OVERFLOWS = {
    1: "node region",
    2: "list region",
    3: "working memory",
}  # tbu_err_e: these need more room, not another scene
ERRORS = {4: "too many triangles", 5: "a coordinate off the grid or outside it", 6: "the memory answered with an error"}
STATISTICS = (
    "cycles",
    "nodes",
    "entries",
    "jumps",
    "jobs",
    "donations",
    "forced",
    "lines",
    "rows",
    "waits",
)  # tbu_stat_t
LINE_BYTES, ROW_BYTES = 64, 32
LARGEST_FACTOR = 16


# ---- what the unit is given --------------------------------------------------------------------------------------------


@dataclass
class BuildImage:
    """Memory and configuration of a build.

    memory: uint8 by address, from 0; only the vertices hold anything. regions: {name: (lo, hi)} byte addresses, hi exclusive.
    config: {field of tbu_cfg_t: value}, addresses in lines of 64 bytes, box as 108 bits.
    """

    memory: np.ndarray
    regions: dict
    config: dict
    refs: model.Refs
    unit: Normalised
    params: tbu.Params
    factor: int = 1


def opaque_triangles(scene) -> np.ndarray:
    """(N,) bool: a hit ends a shadow ray."""
    return np.array([m.opaque for m in scene.materials])[scene.face_material]


def build_image(scene, params: tbu.Params | None = None, factor: int = 1) -> BuildImage:
    """Make a scene ready for the unit. factor: multiplies the room, see `tbu.sizes`. Raises: SceneError."""
    params = params or tbu.Params()
    unit, opaque = tbu.snap(scene), opaque_triangles(scene)
    refs = tbu.references(unit, opaque)
    vertices = tbu.vertex_records(unit, opaque).astype("<u8")
    room = tbu.sizes(len(refs), params.cap, factor)
    regions, at = {}, FIRST_ADDRESS
    for name, size in (("vertices", vertices.nbytes), *room.bytes.items()):
        end = at + -(-size // ALIGN) * ALIGN
        regions[name] = (at, end)
        at = end
    if at > 1 << 32:
        raise SceneError(
            f"{scene.name}: needs {at >> 20} MB of memory, 32-bit addresses reach 4096 MB; simplify the mesh"
        )
    memory = np.zeros(at, np.uint8)
    memory[regions["vertices"][0] :][: vertices.nbytes] = vertices.reshape(-1).view(np.uint8)
    config = {
        "vertex_base": regions["vertices"][0] // ALIGN,
        "tri_count": len(refs),
        "node_base": regions["nodes"][0] // ALIGN,
        "node_count": room.nodes,
        "list_base": regions["lists"][0] // ALIGN,
        "list_count": room.entries,
        "ref_base": regions["working"][0] // ALIGN,
        "ref_count": room.refs,
        "refine_max": params.refine_max,
        "box": pack_box(*refs.box),
    }
    return BuildImage(memory, regions, config, refs, unit, params, factor)


# ---- the run -----------------------------------------------------------------------------------------------------------


@dataclass
class HardwareRun:
    """What a build left behind. error: tbu_err_e. root: index in the node region. counters: fields of tbu_stat_t."""

    memory: np.ndarray
    root: int
    error: int
    counters: dict = field(default_factory=dict)


def run_hardware(image: BuildImage, memory: sim.Memory) -> HardwareRun:
    """Build on the Verilated RTL. Raises: SimError if it hangs, OptionError, ToolchainError."""
    after, root, error, counters = tbu_sim.run(image.memory, image.config, image.params.cap, memory)
    return HardwareRun(after, root, error, counters)


def run_model(image: BuildImage) -> HardwareRun:
    """The same by the model: memory as a single sorting pipeline leaves it, and no cycles."""
    p = image.params
    tree = model.build(image.refs, None, p.cap, p.refine_max, p.max_leaf, p.max_depth)
    nodes, lists, root = emit(tree, image.config["node_count"])
    if root < 0:
        return HardwareRun(image.memory, 0, 1)
    if len(lists) > image.config["list_count"]:
        return HardwareRun(image.memory, 0, 2)
    memory = image.memory.copy()
    for name, offset, part in (("nodes", 8 * root, nodes.astype("<u8")), ("lists", 0, lists.astype("<u4"))):
        memory[image.regions[name][0] + offset :][: part.nbytes] = part.view(np.uint8)
    return HardwareRun(memory, root, 0)


# ---- what came out -----------------------------------------------------------------------------------------------------


@dataclass
class Built:
    """A finished build. tree: as read back from memory; difference: from the model's tree, None if there is none."""

    engine: str
    image: BuildImage
    run: HardwareRun
    nodes: np.ndarray  # (node_count,) uint64, the whole region
    lists: np.ndarray  # (list_count,) uint32
    tree: model.Tree
    difference: str | None
    sah_exact: float
    seconds: dict

    @property
    def kdtree(self) -> kdtree.Tree:
        """For the rest of the package. Nodes keep their places, jump nodes included."""
        bounds = (self.image.refs.box - model.ONE) * 2.0**-17
        stats = tbu.statistics(self.tree)
        return kdtree.Tree(self.nodes, self.lists, self.run.root, bounds, self.image.params, stats)


def _fail(scene, run):
    raise SimError(
        f"{scene.name}: the tree builder stopped: {(OVERFLOWS | ERRORS).get(run.error, f'error {run.error}')}"
    )


def build(scene, engine="rtl", memory: sim.Memory | None = None, params: tbu.Params | None = None) -> Built:
    """Build the tree of a scene, with twice the room after each overflow, and compare it with the model's.

    Args: engine: of `ENGINES`; memory: of the simulation. Raises: SceneError, SimError.
    """
    factor, seconds = 1, {}

    def timed(name, function, *arguments):
        began = time.perf_counter()
        out = function(*arguments)
        seconds[name] = round(seconds.get(name, 0.0) + time.perf_counter() - began, 3)
        return out

    while True:
        image = timed("prepare", build_image, scene, params, factor)
        if engine == "rtl":
            run = timed("run", run_hardware, image, memory or sim.Memory())
        else:
            run = timed("run", run_model, image)
        if run.error not in OVERFLOWS or factor == LARGEST_FACTOR:
            break
        factor *= 2
    if run.error:
        _fail(scene, run)
    p, c = image.params, image.config
    nodes = run.memory[image.regions["nodes"][0] :][: 8 * c["node_count"]].view("<u8")
    lists = run.memory[image.regions["lists"][0] :][: 4 * c["list_count"]].view("<u4")
    try:
        tree = timed("read", walk_memory, nodes, lists, run.root, image.refs.box)
    except ValueError as error:
        raise SimError(f"{scene.name}: the tree in memory makes no sense: {error}") from None
    expected = timed("model", model.build, image.refs, None, p.cap, p.refine_max, p.max_leaf, p.max_depth)
    exact = timed("exact", model.build, image.refs, None, model.NO_CAP, 0, p.max_leaf, p.max_depth)
    difference = compare(expected, tree)
    return Built(engine, image, run, nodes, lists, tree, difference, sah_cost(exact), seconds)


def waste(built: Built) -> dict:
    """Places in extents that were taken and hold nothing: {"nodes", "entries"} counts, "share": of all bytes of the tree.

    Nodes are taken from the region's end downwards, entries from its beginning upwards. A pipeline that reads its tree back
    finds nothing of extents that nobody wrote into; there are none but the last of each pipeline.
    """
    tree, c = built.tree, built.image.config
    lowest = int(tree.at.min()) // tbu.NODE_EXTENT * tbu.NODE_EXTENT
    taken = c["node_count"] - lowest if built.engine == "rtl" else len(tree)
    many = np.flatnonzero((tree.kind == model.LEAF) & (tree.count > 1))
    first = (built.nodes[tree.at[many]] >> np.uint64(29) & np.uint64(0xFFFFFF)).astype(np.int64)
    top = int((first + tree.count[many]).max(initial=0))
    used = int(tree.count[many].sum())
    entries = -(-top // tbu.LIST_EXTENT) * tbu.LIST_EXTENT if built.engine == "rtl" else top
    lost = {"nodes": taken - len(tree) - tree.jumps, "entries": entries - used}
    whole = 8 * len(tree) + 4 * used
    return lost | {"share": (8 * (lost["nodes"] + tree.jumps) + 4 * lost["entries"]) / whole}


def stats(built: Built, scene, memory: sim.Memory | None = None, **more) -> dict:
    """STATS.json of a build, as docs/cli.md explains it; cycles and bytes are null without the RTL."""
    image, counters, tree = built.image, built.run.counters, built.tree
    n, figures = len(image.refs), tbu.statistics(tree)
    cycles = counters.get("cycles")
    moved = LINE_BYTES * counters["lines"] + ROW_BYTES * counters["rows"] if counters else None
    return {
        "engine": built.engine,
        "triangles": n,
        "cycles": cycles,
        "cycles_per_triangle": cycles / n if counters else None,
        "bytes": moved,
        "bytes_per_triangle": moved / n if counters else None,
        "sah_cost": figures["sah_cost"],
        "sah_cost_exact": built.sah_exact,
        "sah_ratio": figures["sah_cost"] / built.sah_exact if built.sah_exact else 1.0,
        "depth": figures["depth"],
        "nodes": figures["node_count"],
        "leaves": figures["leaf_count"],
        "largest_leaf": figures["largest_leaf"],
        "list_entries": figures["list_entries"],
        "jump_nodes": tree.jumps,
        "waste": waste(built),
        "check": {"same_tree": built.difference is None, "difference": built.difference},
        "counters": counters,
        "reserved": {name: hi - lo for name, (lo, hi) in image.regions.items()} | {"factor": image.factor},
        "seconds": built.seconds,
        "config": {
            "scene": scene.name,
            "without_area": int(np.count_nonzero(image.unit.dropped)),
            "tree": asdict(image.params),
            "memory": asdict(memory) if memory else None,
            "versions": {"raycore": __version__, "numpy": np.__version__},
            **more,
        },
    }


def summary(values: dict) -> list[tuple[str, str]]:
    """(what, figure) pairs for people, from `stats`."""
    v = values
    out = [("triangles", f"{v['triangles']:,}")]
    if v["cycles"] is not None:
        out += [
            ("cycles", f"{v['cycles']:,}, {v['cycles_per_triangle']:.1f} a triangle"),
            ("bytes moved", f"{v['bytes']:,}, {v['bytes_per_triangle']:.0f} a triangle"),
        ]
    return out + [
        ("nodes", f"{v['nodes']:,}, {v['jump_nodes']:,} jump nodes beside them, {v['leaves']:,} leaves"),
        ("depth of the tree", f"{v['depth']}"),
        ("largest leaf", f"{v['largest_leaf']} triangles"),
        ("list entries", f"{v['list_entries']:,}"),
        (
            "waste",
            f"{v['waste']['nodes']:,} nodes, {v['waste']['entries']:,} entries, {v['waste']['share']:.2%} of the tree",
        ),
        ("SAH cost", f"{v['sah_cost']:.2f}, {v['sah_ratio']:.4f} of the exact builder's with the same rules"),
    ]
