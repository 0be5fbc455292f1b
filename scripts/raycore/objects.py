# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scenes with dynamic objects (paper Sec. 3.7, docs/tni.md): a static tree made once, a tree for each object that the
tree-building unit makes anew in every frame, and a top-level tree over the objects' boxes, made in the same way.

Rigid objects are *placed*: tree and records stand in coordinates of their own, are made once by the host, and are shared by
objects of equal shape; of a frame are only their instance records and the top-level tree.

Triangles are sorted: the static ones first, then object by object, the rigid ones last; in memory each shape takes the place of
the rigid objects' triangles once, and objects that are built begin at even numbers, so at lines, where the record unit can write.
All trees lie in the same node and list regions, the host's first, and indices count from the regions' beginning.
"""

import hashlib
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np

from raycore import accel, kdtree, tbu, triaccel
from raycore.errors import SceneError
from raycore.model import fp24
from raycore.model import tbu as model
from raycore.model.tbu_memory import emit

MAX_OBJECTS = 256
MARGIN = 2.0**-10  # boxes are enlarged by this much, as the scene's is
GRID = 2.0**-17
SHAPE_PARAMS = kdtree.Params(max_depth=kdtree.MAX_DEPTH - 8)  # a ray's stack holds the top-level tree's nodes too
INSTANCE = (
    *(("root", 24), ("lo_x", 24), ("placed", 1), ("zero0", 11)),
    *(("lo_y", 24), ("lo_z", 24), ("zero1", 12)),
    *(("hi_x", 24), ("hi_y", 24), ("zero2", 12)),
    *(("hi_z", 24), ("zero3", 36)),
)  # inst_t of rtl/rc_pkg.sv
INSTANCE_ROW = (
    *(("r_x", 24), ("r_y", 24), ("zero0", 12)),
    *(("c_x", 24), ("c_y", 24), ("zero1", 12)),
    *(("c_z", 24), ("r_z", 24), ("zero2", 12)),
    *(("root", 24), ("zero3", 36)),
)  # inst_row_t: three of them behind an instance
PLACE = (
    *(("m_xx", 24), ("m_xy", 24), ("zero0", 12)),
    *(("m_xz", 24), ("o_x", 24), ("zero1", 12)),
    *(("m_yx", 24), ("m_yy", 24), ("zero2", 12)),
    *(("m_yz", 24), ("o_y", 24), ("zero3", 12)),
    *(("m_zx", 24), ("m_zy", 24), ("zero4", 12)),
    *(("m_zz", 24), ("o_z", 24), ("zero5", 12)),
    ("zero6", 120),
)  # place_t, behind the rows
INSTANCE_BYTES, LINE_BYTES = 256, 64
TRIACCEL_BYTES, INFO_BYTES = 32, 64  # of a TriAccel record and of triangle information
INSTANCE_WORDS = INSTANCE_BYTES // 8
LINE_ENTRIES = LINE_BYTES // 4


@dataclass
class Part:
    """A tree that a frame of its own builds.

    first: number of its first triangle in memory, of the top-level tree of its first instance. triangles (N, 3, 3): what it is
    built from, on the grid; refs: as the unit sees them.
    """

    name: str
    first: int
    triangles: np.ndarray
    opaque: np.ndarray
    refs: model.Refs

    @property
    def rows(self):
        """Where its triangles are in memory: a slice."""
        return slice(self.first, self.first + len(self.refs))

    def tree(self, params) -> model.Tree:
        """The tree by the model."""
        return tbu.model_tree(self.refs, params)


@dataclass
class Shape:
    """What placed objects share: its triangles in memory, first to last, in coordinates of its own.

    centre (3,): of its box, in world units of these coordinates; triangles (n, 3, 3) on the grid, so that centre becomes 0.
    root: of its tree, when that is made.
    """

    first: int
    centre: np.ndarray
    triangles: np.ndarray
    root: int = -1

    @property
    def last(self):
        """One behind its last triangle."""
        return self.first + len(self.triangles)


@dataclass
class Place:
    """Where a placed object stands: x = rotation @ y + origin, in the unit box, float64. offset: see `Objects.offsets`."""

    shape: Shape
    rotation: np.ndarray
    origin: np.ndarray
    offset: int


@dataclass
class Objects:
    """The trees of a scene with dynamic objects. parts: those that are built, the objects' and then the top-level tree.

    boxes (1 + objects, 2, 3) float64: of the instances, the top-level tree's first. nodes, lists: of all trees that the host
    makes, the static one's first. numbers (N,) int64: number in the scene of each triangle in memory, of a shape's in its first
    object, of padding that of the triangle before. places: of the placed objects, which are the last instances.
    """

    static: kdtree.Tree
    parts: list
    boxes: np.ndarray
    nodes: np.ndarray
    lists: np.ndarray
    numbers: np.ndarray
    places: list = field(default_factory=list)

    @property
    def shapes(self):
        """Those of the placed objects, each once."""
        return shapes_of(self.places)

    @property
    def made(self):
        """Which triangles in memory are built anew in every frame: (N,) bool."""
        out = np.zeros(len(self.numbers), bool)
        for part in self.parts[:-1]:
            out[part.rows] = True
        return out

    @property
    def offsets(self):
        """What to add to `numbers` of a placed object's triangles, by instance: (instances,) int64."""
        out = np.zeros(len(self.boxes), np.int64)
        out[len(out) - len(self.places) :] = [p.offset for p in self.places]
        return out

    def roots(self, built):
        """Roots of the instances, those of `parts` given."""
        return [built[-1], *built[:-1], *(p.shape.root for p in self.places)]


# ---- shapes of placed objects ----------------------------------------------------------------------------------------------


def shapes_of(places):
    """The shapes of some `Place`, each once."""
    return list({id(p.shape): p.shape for p in places}.values())


def stored(scene, unit):
    """A scene as its records hold it: each shape of placed objects once, in coordinates of its own, behind all other triangles.

    Shapes are equal, and shared, if their triangles on the grid, normals, texture coordinates and materials are. Objects that are
    built begin at even numbers: where they would not, the triangle before is there again, as a point, which is in no tree.

    Args: scene, with dynamic objects; unit: of it, from `tbu.snap`.
    Returns: the scene and its `Normalised` for records, `Place` of each placed object, and `Objects.numbers`.
    Raises: SceneError if a shape does not fit between -1 and 1.
    """
    numbers, padding = _padded(scene.objects, int(scene.objects.max()) - len(scene.placed))
    triangles = unit.triangles[numbers]
    triangles[padding] = triangles[padding][:, :1]
    at, in_memory, known, places = int(numbers[-1]) + 1 if numbers.size else 0, len(numbers), {}, []
    rows, local, normals = [numbers], [triangles], [scene.normals[numbers]]
    for rigid in scene.placed:
        mine = np.arange(at, at + len(rigid.triangles))
        lo, hi = rigid.triangles.min((0, 1)), rigid.triangles.max((0, 1))
        centre = lo + (hi - lo) / 2.0
        grid = np.rint((rigid.triangles - centre) * (2.0**-unit.scale_exp / GRID))
        if np.abs(grid).max() >= model.ONE:
            raise SceneError(
                f"{scene.name}: a rigid object is larger than the scene in coordinates of its own; mark it \"dynamic\": true"
            )
        triangles = grid * GRID + 0.0
        uv = b"" if scene.uv is None else scene.uv[mine].tobytes()
        key = _digest(triangles, rigid.normals, uv, scene.face_material[mine])
        if key not in known:
            known[key] = Shape(in_memory, centre, triangles), at
            in_memory += len(mine)
            rows.append(mine)
            local.append(triangles)
            normals.append(rigid.normals)
        shape, number = known[key]
        origin = unit.to_unit(rigid.rotation @ centre + rigid.translation)
        places.append(Place(shape, rigid.rotation, origin, at - number))
        at += len(mine)
    numbers, triangles, normals = np.concatenate(rows), np.concatenate(local), np.concatenate(normals)
    own = replace(
        scene,
        triangles=unit.to_world(triangles),
        normals=normals,
        face_material=scene.face_material[numbers],
        uv=None if scene.uv is None else scene.uv[numbers],
        objects=None,
        placed=[],
    )
    kept = replace(
        unit, triangles=triangles, normals=fp24.round_to_fp24(normals), dropped=~triaccel.has_area(triangles)
    )
    return own, kept, places, numbers


def _padded(objects, count):
    """Static triangles and those of the first `count` objects, padded: numbers in the scene, and which are padding.

    objects: of a `Scene`. All but the last object are padded to an even number of triangles.
    """
    bounds = np.searchsorted(objects, np.arange(count + 2))
    times = np.ones(bounds[-1], np.int64)
    times[bounds[1:-1][np.diff(bounds)[:-1] % 2 == 1] - 1] = 2
    numbers = np.repeat(np.arange(bounds[-1]), times)
    return numbers, np.diff(numbers, prepend=-1) == 0


def _digest(*things):
    """Of arrays and bytes: the same only if all are."""
    out = hashlib.sha256()
    for thing in things:
        data = thing if isinstance(thing, bytes) else np.ascontiguousarray(thing).tobytes()
        out.update(len(data).to_bytes(8, "little") + data)
    return out.digest()


# ---- what is built ---------------------------------------------------------------------------------------------------------


def _part(name, first, triangles, opaque):
    refs = tbu.references(SimpleNamespace(triangles=triangles), opaque)
    return Part(name, first, triangles, opaque, replace(refs, tri=refs.tri + first))


_made = {}  # the host's trees of the last scene, by what they were made of: in an animation they stay the same


def _host_trees(meshes):
    """Trees of meshes (triangles, dropped, `kdtree.Params`), by the host; those that the last scene had too are not made again."""
    keys = [(_digest(triangles, dropped), params) for triangles, dropped, params in meshes]
    for old in set(_made) - set(keys):
        del _made[old]
    for key, mesh in zip(keys, meshes):
        if key not in _made:
            _made[key] = kdtree.build(*mesh)
    return [_made[key] for key in keys]


def relocated(tree, node_first, list_first, tri_first):
    """Nodes and list entries of a tree whose nodes, entries and triangles begin elsewhere than at 0."""
    leaf = tree.nodes >> np.uint64(24) & np.uint64(3) == kdtree.AXIS_LEAF
    count, ref = tree.nodes & np.uint64(0xFFFFF), tree.nodes >> np.uint64(29)
    first = np.where(count > 1, list_first, np.where(count == 1, tri_first, 0))
    first = np.where(leaf, first, np.where(ref > 0, node_first, 0))  # node 0 is nobody's child: no other child
    return tree.nodes + (first.astype(np.uint64) << np.uint64(29)), tree.lists + np.uint32(tri_first)


def _whole(count, extent):
    return -(-count // extent) * extent


def plan_objects(scene, unit, kept, places, numbers, opaque) -> Objects:
    """What is built, and the trees that the host makes.

    Args: scene; unit: of it, from `tbu.snap`; kept: `Normalised` of its records, places and numbers, from `stored`;
        opaque: (N,) bool of the records.
    Raises: SceneError with too many objects, or if indices of 24 bits do not reach.
    """
    count = int(scene.objects.max())
    if count > MAX_OBJECTS:
        raise SceneError(f"{scene.name}: {count} dynamic objects, at most {MAX_OBJECTS} fit; mark fewer meshes")
    bounds = np.searchsorted(scene.objects, np.arange(count + 2))
    parts, boxes = [], []
    for k in range(1, count + 1):
        mine = unit.triangles[bounds[k] : bounds[k + 1]]
        boxes.append(np.stack((mine.min((0, 1)) - MARGIN, mine.max((0, 1)) + MARGIN)))
        if k <= count - len(places):
            first = int(np.searchsorted(numbers, bounds[k]))
            parts.append(_part(f"object {k}", first, mine, opaque[first : first + len(mine)]))
    boxes = np.array(boxes)
    # For the builder a box is a triangle with that box. Its planes lie inside the grid, so boxes are cut there.
    inside = np.clip(boxes, GRID - 1.0, 1.0 - GRID)
    top = _part("top-level tree", 1, inside[:, [0, 1, 0]], np.ones(count, bool))
    whole = np.stack((boxes[:, 0].min(0) - MARGIN, boxes[:, 1].max(0) + MARGIN))
    n = bounds[1]
    things = Objects(None, [*parts, top], np.concatenate((whole[None], boxes)), None, None, numbers, places)
    shapes = [(kept.triangles[s.first : s.last], kept.dropped[s.first : s.last], SHAPE_PARAMS) for s in things.shapes]
    static, *trees = _host_trees([(kept.triangles[:n], kept.dropped[:n], kdtree.Params()), *shapes])
    things.static = replace(static, lists=kdtree.opaque_lists(static.lists, opaque))
    if n == 0:
        things.static = replace(static, bounds=np.zeros((2, 3)))
    things.nodes, things.lists = _beside(things.static, things.shapes, trees, opaque)
    if max(things.nodes.size, things.lists.size) > kdtree.INDEX_LIMIT:
        raise SceneError(f"{scene.name}: the trees of its shapes outgrow 24-bit indices; simplify their meshes")
    return things


def _beside(static, shapes, trees, opaque):
    """Node and list regions of the static tree and of those of shapes, each from a line on; shapes learn their roots."""
    nodes, lists, node_at, list_at = [static.nodes], [static.lists], static.nodes.size, static.lists.size
    for shape, tree in zip(shapes, trees):
        node_first, list_first = _whole(node_at, kdtree.LINE_NODES), _whole(list_at, LINE_ENTRIES)
        words, entries = relocated(tree, node_first, list_first, shape.first)
        shape.root = node_first + tree.root
        nodes += [np.full(node_first - node_at, kdtree.AXIS_LEAF << 24, np.uint64), words]  # as the host's padding: empty leaves
        lists += [np.zeros(list_first - list_at, np.uint32), kdtree.opaque_lists(entries, opaque)]
        node_at, list_at = node_first + words.size, list_first + entries.size
    return np.concatenate(nodes), np.concatenate(lists)


# ---- instance records ------------------------------------------------------------------------------------------------------


def instance_fields(roots, boxes, placed):
    """Fields of `INSTANCE`: roots (K,), boxes (K, 2, 3) float64, rounded here, placed (K,) bool."""
    corners = fp24.to_bits(fp24.round_to_fp24(np.asarray(boxes, np.float64)))
    corner = {f"{side}_{axis}": corners[:, i, j] for i, side in enumerate(("lo", "hi")) for j, axis in enumerate("xyz")}
    return {"root": np.asarray(roots), "placed": np.asarray(placed), **corner}


def place_fields(rotation, origin, roots):
    """Fields of the three `INSTANCE_ROW` and of `PLACE`, a list of four.

    Args: rotation (K, 3, 3) and origin (K, 3) of `Place`, float64, rounded here once: the way into an object is by the
        transpose of what leads out of it, bit for bit; roots (K,).
    """
    m, o = (fp24.to_bits(fp24.round_to_fp24(np.asarray(v, np.float64))) for v in (rotation, origin))
    centre = {f"c_{axis}": o[:, i] for i, axis in enumerate("xyz")}
    rows = [{f"r_{axis}": m[:, j, i] for j, axis in enumerate("xyz")} | centre | {"root": np.asarray(roots)} for i in range(3)]
    out = {f"m_{a}{b}": m[:, i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}
    return [*rows, out | {f"o_{axis}": o[:, i] for i, axis in enumerate("xyz")}]


# ---- trees by the model ----------------------------------------------------------------------------------------------------


def by_model(objects, params) -> tuple:
    """All trees as the models make them: nodes, lists, roots of the instances (the top-level tree's first)."""
    nodes, lists, roots = [objects.nodes], [objects.lists], []
    node_at, list_at = objects.nodes.size, objects.lists.size
    for part in objects.parts:
        tree = part.tree(params)
        made, entries, root = emit(tree, node_at + len(tree), list_at)
        nodes.append(made)
        lists.append(entries)
        roots.append(root)
        node_at, list_at = node_at + made.size, list_at + entries.size
    return np.concatenate(nodes), np.concatenate(lists), objects.roots(roots)


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

    def attributes(self, kept):
        """Attribute records of the objects, at the same places as their vertex records: (N, 4) uint64. kept: of `Geometry`."""
        out = np.zeros((self.vertex_first[-2], accel.ATTRIBUTE_BYTES // 8), np.uint64)
        for part, at in zip(self.objects.parts[:-1], self.vertex_first):
            records = accel.attribute_records(kept.normals[part.rows], kept.face_material[part.rows])
            out[at : at + len(records)] = records
        return out

    def registers(self, number, regions, params):
        """What the tree builder is told to build a part, and the record unit to make an object's records."""
        part = self.objects.parts[number]
        box = part.refs.box
        q = {f"TBU_{side}_{axis}": int(box[i][j]) for i, side in enumerate(("LO", "HI")) for j, axis in enumerate("XYZ")}
        if "attributes" in regions and number < len(self.objects.parts) - 1:
            q |= {
                "ATTR_BASE": regions["attributes"][0] + accel.ATTRIBUTE_BYTES * self.vertex_first[number],
                "ACCEL_BASE": regions["triaccel"][0] + TRIACCEL_BYTES * part.first,
                "INFO_BASE": regions["info"][0] + INFO_BYTES * part.first,
            }
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

    nodes, lists = [_whole(objects.nodes.size, tbu.NODE_EXTENT)], [_whole(objects.lists.size, tbu.LIST_EXTENT)]
    vertices, refs = [0], 0
    for part in objects.parts:
        sizes = tbu.sizes(len(part.refs), cap, factor)
        nodes.append(nodes[-1] + sizes.nodes)
        lists.append(lists[-1] + sizes.entries)
        vertices.append(vertices[-1] + _whole(len(part.refs), LINE_BYTES // tbu.VERTEX_BYTES))
        refs = max(refs, sizes.refs)
    if max(nodes[-1], lists[-1]) > kdtree.INDEX_LIMIT:
        raise SceneError(f"the trees of {len(objects.parts) - 1} objects outgrow 24-bit indices; simplify their meshes")
    return Room(objects, nodes, lists, vertices, refs)
