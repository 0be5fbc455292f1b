# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Host side of the tree-building unit (docs/tbu.md): what it is given, how much memory it needs, and what comes back.

The unit reads vertices on the grid of 2^-17 of the object's normalised half size. So the host snaps a scene *before* anything
is made from it: boxes, planes, nodes and TriAccel records then agree to the last bit and nothing is rounded later.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from raycore import kdtree
from raycore.errors import SceneError
from raycore.model import fp24
from raycore.model import tbu as model
from raycore.model.tbu_memory import emit, sah_cost
from raycore.scene import Normalised, normalise

VERTEX_BYTES = 32  # of a vertex record: nine FP24 numbers from bit 0, v0.x, v0.y, v0.z, v1.x ..., then flags
OPAQUE_BIT = 216
REF_BYTES, LINE_REFS = 16, 4
NODE_EXTENT, LIST_EXTENT = 128, 256  # nodes and list entries that a pipeline takes at a time (rc_tbu_pkg.sv)
NODES_EACH, ENTRIES_EACH, REFS_EACH = 5, 10, 3  # room a triangle: enough for meshes, doubled when it is not
SPARE_EXTENTS = 16  # part-used extents of all pipelines, and small scenes
SPARE_REFS = 64  # lists begin at lines
JOB_RING = 16  # lists of up to `cap` references that wait for a sorting pipeline


@dataclass(frozen=True)
class Params:
    """How the unit builds; in place of `kdtree.Params` it makes `image.build_geometry` take the unit's tree."""

    cap: int = model.CAP  # references of a sorting pipeline; model.NO_CAP: every plane is a candidate everywhere
    refine_max: int = model.REFINE_MAX
    max_leaf: int = model.MAX_LEAF
    max_depth: int = model.MAX_DEPTH
    cost_traverse: float = 1.0
    cost_intersect: float = 1.5


# ---- the scene on the grid ---------------------------------------------------------------------------------------------


def snap(scene) -> Normalised:
    """A scene in (-1, 1) with its vertices at multiples of 2^-17.

    These are exact FP24 numbers. Shared vertices stay shared. The largest half extent is in [1/2, 1), never 1: a coordinate of
    18 bits ends there. Triangles that lose their area are marked, and stay in the tree as boxes: the unit makes no exceptions.
    Raises: SceneError if no triangle keeps an area, or with more triangles than the unit can number.
    """
    if len(scene.triangles) > model.MAX_TRIANGLES:
        raise SceneError(
            f"{scene.name}: {len(scene.triangles)} triangles, the tree builder numbers {model.MAX_TRIANGLES}; simplify it"
        )
    unit = normalise(scene)
    scale_exp = unit.scale_exp
    while True:
        grid = np.rint((scene.triangles - unit.centre) * math.ldexp(1.0, 17 - scale_exp))
        if np.abs(grid).max() < model.ONE:
            break
        scale_exp += 1
    triangles = grid * 2.0**-17 + 0.0
    dropped = ~np.cross(grid[:, 1] - grid[:, 0], grid[:, 2] - grid[:, 0]).any(axis=1)
    if dropped.all():
        raise SceneError(
            f"{scene.name}: no triangle keeps an area on a grid of 2^-17; is there a stray vertex far away?"
        )
    return replace(unit, triangles=triangles, dropped=dropped, scale_exp=scale_exp)


def references(unit: Normalised, opaque=None) -> model.Refs:
    """References of a snapped scene, as the unit makes them from `vertex_records`. opaque: (N,) bool, default all."""
    return model.refs_from_vertices(fp24.to_bits(unit.triangles), opaque)


def vertex_records(unit: Normalised, opaque=None) -> np.ndarray:
    """What the unit reads: (N, 4) uint64, 32 bytes a triangle, low word first. opaque: (N,) bool, default all."""
    bits = fp24.to_bits(unit.triangles).reshape(-1, 9).astype(np.uint64)
    records = np.zeros((len(bits), VERTEX_BYTES // 8), np.uint64)
    for i in range(9):
        word, low = divmod(24 * i, 64)
        records[:, word] |= bits[:, i] << np.uint64(low)
        if low > 40:
            records[:, word + 1] |= bits[:, i] >> np.uint64(64 - low)
    word, low = divmod(OPAQUE_BIT, 64)
    flags = np.ones(len(bits), np.uint64) if opaque is None else np.asarray(opaque).astype(np.uint64)
    records[:, word] |= flags << np.uint64(low)
    return records


# ---- memory ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sizes:
    """Room for a build: nodes (8 bytes) and list entries (4 bytes) in whole extents, references (16 bytes) of working memory."""

    nodes: int
    entries: int
    refs: int

    @property
    def bytes(self) -> dict:
        """{region: bytes}."""
        return {"nodes": 8 * self.nodes, "lists": 4 * self.entries, "working": REF_BYTES * self.refs}


def sizes(triangles: int, cap: int = model.CAP, factor: int = 1) -> Sizes:
    """Room to reserve; factor: twice as much after each build that ended with an overflow.

    Overlapping triangles in one plane have taken 10 nodes and 30 list entries each, meshes 1 to 4 and 1 to 7. Lists of
    even and of odd levels lie on two stacks, together 2 to 3 references a triangle, beside the ring of waiting jobs.
    """

    def extents(count, extent):
        return (-(-count // extent) + SPARE_EXTENTS) * extent

    nodes = extents(factor * NODES_EACH * triangles, NODE_EXTENT)
    entries = extents(factor * ENTRIES_EACH * triangles, LIST_EXTENT)
    limit = kdtree.INDEX_LIMIT
    return Sizes(
        min(nodes, limit // NODE_EXTENT * NODE_EXTENT),
        min(entries, limit // LIST_EXTENT * LIST_EXTENT),
        -(-factor * REFS_EACH * triangles // LINE_REFS) * LINE_REFS + SPARE_REFS + JOB_RING * cap,
    )


# ---- trees -------------------------------------------------------------------------------------------------------------


def statistics(tree: model.Tree) -> dict:
    """Figures of a tree, named as those of `kdtree.build`, with layout that of plain depth first."""
    inner = tree.kind < model.LEAF
    leaves = ~inner
    missing = int(np.count_nonzero(inner & ((tree.lower < 0) | (tree.upper < 0))))
    stored = int(tree.count[leaves & (tree.count > 1)].sum())
    return {
        "node_count": len(tree),
        "leaf_count": int(np.count_nonzero(leaves)),
        "empty_leaf_count": missing,
        "depth": int(tree.level.max()),
        "sah_cost": sah_cost(tree),
        "list_entries": stored,
        "references": int(tree.count[leaves].sum()),
        "largest_leaf": int(tree.count[leaves].max()),
        "padding": 0,
    }


def model_tree(refs: model.Refs, params: Params) -> model.Tree:
    """The tree that the unit makes of these references, by its model."""
    return model.build(refs, None, params.cap, params.refine_max, params.max_leaf, params.max_depth)


def no_tree(unit: Normalised, params: Params | None = None) -> kdtree.Tree:
    """In place of a tree that the hardware is still to build: its box, and nothing in it."""
    bounds = (references(unit).box - model.ONE) * 2.0**-17
    return kdtree.Tree(np.zeros(0, np.uint64), np.zeros(0, np.uint32), 0, bounds, params or Params(), {})


def build_tree(unit: Normalised, params: Params | None = None) -> kdtree.Tree:
    """The unit's tree by its model, for the rest of the package: all triangles marked as opaque, as `kdtree.build` does.

    Args: unit: from `snap`. Returns: `kdtree.Tree`, nodes in the order of a single pipeline.
    Raises: SceneError if it outgrows 24-bit indices.
    """
    params = params or Params()
    refs = references(unit)
    nodes, lists, root = emit(tree := model_tree(refs, params))
    if max(len(nodes), len(lists)) >= kdtree.INDEX_LIMIT:
        raise SceneError(
            f"the tree has {len(nodes)} nodes and {len(lists)} list entries (limit {kdtree.INDEX_LIMIT - 1}); simplify the mesh"
        )
    bounds = (refs.box - model.ONE) * 2.0**-17
    return kdtree.Tree(nodes, lists, root, bounds, params, statistics(tree))
