# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scenes with dynamic objects (paper Sec. 3.7, docs/tni.md): a static tree made once, a tree for each object that the
tree-building unit makes anew in every frame, and a top-level tree over the objects' boxes, made in the same way.

Triangles are sorted: the static ones first, then object by object. All trees lie in the same node and list regions, the static
one first, and indices count from the regions' beginning.
"""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from raycore import kdtree, tbu
from raycore.errors import SceneError
from raycore.model import fp24
from raycore.model import tbu as model
from raycore.model.tbu_memory import emit

MAX_OBJECTS = 256
MARGIN = 2.0**-10  # boxes are enlarged by this much, as the scene's is
GRID = 2.0**-17
INSTANCE = (
    *(("root", 24), ("lo_x", 24), ("zero0", 12)),
    *(("lo_y", 24), ("lo_z", 24), ("zero1", 12)),
    *(("hi_x", 24), ("hi_y", 24), ("zero2", 12)),
    *(("hi_z", 24), ("zero3", 36)),
)  # inst_t of rtl/rc_pkg.sv
INSTANCE_BYTES, LINE_BYTES = 32, 64


@dataclass
class Part:
    """A tree that a frame of its own builds.

    first: number of its first triangle, of the top-level tree of its first instance. triangles (N, 3, 3): what it is built
    from, on the grid; refs: as the unit sees them.
    """

    name: str
    first: int
    triangles: np.ndarray
    opaque: np.ndarray
    refs: model.Refs

    def tree(self, params) -> model.Tree:
        """The tree by the model."""
        return tbu.model_tree(self.refs, params)


@dataclass
class Objects:
    """The trees of a scene with dynamic objects. parts: those of the objects, then the top-level tree.

    boxes (1 + objects, 2, 3) float64: of the instances, the top-level tree's first.
    """

    static: kdtree.Tree
    parts: list
    boxes: np.ndarray

    @property
    def triangles(self):
        """How many are built anew in every frame."""
        return sum(len(p.refs) for p in self.parts[:-1])


def _part(name, first, triangles, opaque):
    refs = tbu.references(SimpleNamespace(triangles=triangles), opaque)
    return Part(name, first, triangles, opaque, replace(refs, tri=refs.tri + first))


_static = {}  # the last static tree, by what it was made of: in an animation it stays the same


def _static_tree(triangles, dropped, params):
    key = (triangles.tobytes(), dropped.tobytes(), params)
    if key not in _static:
        _static.clear()
        _static[key] = kdtree.build(triangles, dropped, params)
    made = _static[key]
    return replace(made, nodes=made.nodes.copy(), lists=made.lists.copy())


def plan_objects(scene, unit, opaque, params=None) -> Objects:
    """What is built, and the static tree. unit: from `tbu.snap`; opaque (N,) bool; params: `kdtree.Params` of the static tree.

    Raises: SceneError with too many objects.
    """
    count = int(scene.objects.max())
    if count > MAX_OBJECTS:
        raise SceneError(f"{scene.name}: {count} dynamic objects, at most {MAX_OBJECTS} fit; mark fewer meshes")
    bounds = np.searchsorted(scene.objects, np.arange(count + 2))
    parts, boxes = [], []
    for k in range(1, count + 1):
        mine = slice(bounds[k], bounds[k + 1])
        part = _part(f"object {k}", int(bounds[k]), unit.triangles[mine], opaque[mine])
        parts.append(part)
        boxes.append((part.refs.box - model.ONE) * GRID + [[-MARGIN], [MARGIN]])
    boxes = np.array(boxes)
    # For the builder a box is a triangle with that box. Its planes lie inside the grid, so boxes are cut there.
    inside = np.clip(boxes, GRID - 1.0, 1.0 - GRID)
    top = _part("top-level tree", 1, inside[:, [0, 1, 0]], np.ones(count, bool))
    whole = np.stack((boxes[:, 0].min(0) - MARGIN, boxes[:, 1].max(0) + MARGIN))
    n = bounds[1]
    static = _static_tree(unit.triangles[:n], unit.dropped[:n], params)
    static.lists &= ~np.where(opaque[static.lists & 0xFFFFFF], 0, 1 << 25).astype(np.uint32)
    if n == 0:
        static = replace(static, bounds=np.zeros((2, 3)))
    return Objects(static, [*parts, top], np.concatenate((whole[None], boxes)))


def instance_fields(roots, boxes):
    """Fields of `INSTANCE`: roots (K,), boxes (K, 2, 3) float64, rounded here."""
    corners = fp24.to_bits(fp24.round_to_fp24(np.asarray(boxes, np.float64)))
    places = {f"{side}_{axis}": corners[:, i, j] for i, side in enumerate(("lo", "hi")) for j, axis in enumerate("xyz")}
    return {"root": np.asarray(roots), **places}


def by_model(objects, params) -> tuple:
    """All trees as the models make them: nodes, lists, roots of the instances (the top-level tree's first)."""
    nodes, lists, roots = [objects.static.nodes], [objects.static.lists], []
    node_at, list_at = objects.static.nodes.size, objects.static.lists.size
    for part in objects.parts:
        tree = part.tree(params)
        made, entries, root = emit(tree, node_at + len(tree), list_at)
        nodes.append(made)
        lists.append(entries)
        roots.append(root)
        node_at, list_at = node_at + made.size, list_at + entries.size
    return np.concatenate(nodes), np.concatenate(lists), [roots[-1], *roots[:-1]]


# ---- room for trees that the RTL builds ------------------------------------------------------------------------------------


@dataclass
class Room:
    """Where the trees lie. node_first, list_first, vertex_first: of each part, and behind the last; vertices in records."""

    objects: Objects
    node_first: list
    list_first: list
    vertex_first: list
    refs: int

    @property
    def nodes(self):
        """Of the whole node region."""
        return self.node_first[-1]

    @property
    def entries(self):
        """Of the whole list region."""
        return self.list_first[-1]

    @property
    def triangles(self):
        """How many are built anew in every frame."""
        return self.objects.triangles

    @property
    def bytes(self):
        """{region: bytes}, as `tbu.Sizes` has it."""
        return {"nodes": 8 * self.nodes, "lists": 4 * self.entries, "working": tbu.REF_BYTES * self.refs}

    def vertices(self):
        """Vertex records of all parts, each part at the beginning of a line: (N, 4) uint64."""
        out = np.zeros((self.vertex_first[-1], tbu.VERTEX_BYTES // 8), np.uint64)
        for part, at in zip(self.objects.parts, self.vertex_first):
            records = tbu.vertex_records(SimpleNamespace(triangles=part.triangles), part.opaque)
            out[at : at + len(records)] = records
        return out

    def registers(self, number, regions, params):
        """What the tree builder is told to build a part."""
        part = self.objects.parts[number]
        box = part.refs.box
        q = {f"TBU_{side}_{axis}": int(box[i][j]) for i, side in enumerate(("LO", "HI")) for j, axis in enumerate("XYZ")}
        return q | {
            "NODE_COUNT": self.node_first[number + 1],
            "LIST_COUNT": self.list_first[number + 1],
            "TBU_NODE_FIRST": self.node_first[number],
            "TBU_LIST_FIRST": self.list_first[number],
            "TBU_TRI_FIRST": part.first,
            "TRI_COUNT": len(part.refs),
            "VERTEX_BASE": regions["vertices"][0] + tbu.VERTEX_BYTES * self.vertex_first[number],
            "REF_BASE": regions["working"][0],
            "REF_COUNT": self.refs,
            "TBU_REFINE": params.refine_max,
        }


def room(objects, cap=model.CAP, factor=1) -> Room:
    """Room for the trees of a scene; factor: as in `tbu.sizes`. Raises: SceneError if indices of 24 bits do not reach."""

    def whole(count, extent):
        return -(-count // extent) * extent

    nodes, lists = [whole(objects.static.nodes.size, tbu.NODE_EXTENT)], [whole(objects.static.lists.size, tbu.LIST_EXTENT)]
    vertices, refs = [0], 0
    for part in objects.parts:
        sizes = tbu.sizes(len(part.refs), cap, factor)
        nodes.append(nodes[-1] + sizes.nodes)
        lists.append(lists[-1] + sizes.entries)
        vertices.append(vertices[-1] + whole(len(part.refs), LINE_BYTES // tbu.VERTEX_BYTES))
        refs = max(refs, sizes.refs)
    if max(nodes[-1], lists[-1]) > kdtree.INDEX_LIMIT:
        raise SceneError(f"the trees of {len(objects.parts) - 1} objects outgrow 24-bit indices; simplify their meshes")
    return Room(objects, nodes, lists, vertices, refs)
