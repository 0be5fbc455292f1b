# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The tree that the tree-building unit makes (paper Sec. 3.7): a pure function of the references, in plain integers.

What `rtl/tbu/` must match, whatever its timing. All coordinates are q of 18 bits, x = (q - 2^17) 2^-17, 0 < q < 2^18.

1. **Part of a triangle in a node**: its box cut by the node's, lo' = max(lo, node.lo), hi' = min(hi, node.hi). The box that a
   reference holds is never changed. A triangle is *planar* on an axis if lo' = hi'.
2. **Partition** by (axis, p, pl), stable: the lower child gets lo' < p, the upper one hi' > p, and triangles that are planar
   at p go to the side that pl names (0 lower, 1 upper). Boxes of the children: node.hi or node.lo replaced by p.
3. **Cost.** e1, e2: extents across the axis, w along it, H(l) = e1 e2 + (e1 + e2) l, Hn = H(w), l = p - node.lo, nL and nR the
   counts of rule 2: cost = (nL nR = 0 ? 7 : 8) (2 Hn + 3 (H(l) nL + H(w - l) nR)). The least (cost, axis, p, pl) of all
   candidates wins; it pays if cost < 24 n Hn. n < 2^20 keeps it below 2^63; up to 2^12 references, below 2^55.
4. **Leaf**: n <= max_leaf, level = max_depth (level: inner nodes above), or the winner does not pay. n = 0: no node, the parent
   has a flag. A root without references is a leaf of count 0.
5. **n <= cap** (sorting pipelines). Candidates on each axis with w > 0: every value lo' or hi' with node.lo < p < node.hi, with
   pl = 0 and 1 (without planar triangles at p both are the same: pl = 0); p = node.lo with pl = 0 only, if a triangle
   is planar there and another is not; p = node.hi with pl = 1 only, likewise. These two make a child of no thickness.
6. **n > cap** (binning pipeline). On each axis bins of 2^s units counted from node.lo, s the least number >= 0 with
   w <= 32 * 2^s. A triangle enters at bin (lo' - node.lo) >> s and leaves at max(that, (hi' - node.lo - 1) >> s), both limited to
   31 (a triangle planar at node.hi may be one beyond). Candidates: p = node.lo + j 2^s, j = 1 to 31, strictly inside the
   node, nL = entered in bins below j, nR = n - left in bins below j. pl = 1 always: a triangle planar at p enters at j. So the
   counts are those of rule 2. No flat cells.
7. **Refinement**, if cap < n <= refine_max, whether or not the coarse winner pays. For each axis on its own: the least
   (cost, p) of rule 6 gives the coarse plane P; only w <= 1 has none, and that axis has no candidate. Window: 64 parts of
   2^t units, t = max(s - 5, 0), from P - 2^s (which is never below node.lo). For s >= 5 that is the two bins beside P; it may
   reach beyond node.hi. Bins as in rule 6 counted from the window's start with t, limited to 0 and 63. Candidates:
   start + i 2^t, i = 1 to 63, strictly inside the node (P is one of them), pl = 1. The least (cost, axis, p)
   of all axes wins and replaces the coarse one. The window's two ends need no look: they lost to P before.
8. **Adjacent child**: the one that is not empty, else the one with the larger H, the lower one if equal.

A sorting pipeline whose lists are full makes a leaf and counts it. The model does not: it has not been seen with real meshes.

numba caches compiled callers without noticing a change in another file: every compiled function calls this file only.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

COORD_BITS = 18
ONE = 1 << (COORD_BITS - 1)  # q of x = 0, and units of the grid in 1.0
MAX_TRIANGLES = 1 << 19
MAX_DEPTH = 32
MAX_LEAF = 4
CAP = 1280  # references of a sorting pipeline
REFINE_MAX = 8192
COARSE, FINE = 32, 64  # bins an axis
NO_CAP = 1 << 40  # as cap: every node by all its candidates, the exact builder with the same rules

LEAF = 3  # kind of a node; 0, 1, 2: inner, the axis
JOB = 4  # handed to a sorting pipeline (`upper_tree` only)

# Columns of the compiled builder's node table.
_KIND, _PLANE, _SIDE, _LOWER, _UPPER, _SWAP, _LEVEL, _PARENT, _FIRST, _COUNT, _BOX = range(11)
_COLUMNS = _BOX + 6
_END, _PLANAR, _START = 0, 1, 2  # events, in the order of a sweep at one position


@dataclass
class Refs:
    """References to triangles, ascending in `tri` unless a test wants otherwise.

    lo, hi: (N, 3) int64, box, grid units q. tri: (N,) int64, triangle index below 2^19. opaque: (N,) bool.
    """

    lo: np.ndarray
    hi: np.ndarray
    tri: np.ndarray
    opaque: np.ndarray

    def __len__(self):
        return len(self.tri)

    def __getitem__(self, rows) -> "Refs":
        return Refs(self.lo[rows], self.hi[rows], self.tri[rows], self.opaque[rows])

    @property
    def box(self) -> np.ndarray:
        """(2, 3) int64, box of all; a point in the middle without references."""
        if not len(self):
            return np.full((2, 3), ONE, np.int64)
        return np.stack((self.lo.min(axis=0), self.hi.max(axis=0)))


@dataclass
class Tree:
    """A tree to be walked, in canonical order: a node, all of its lower child, all of its upper child; the root is row 0.

    kind (n,): 0, 1, 2 inner node by axis, LEAF, JOB. plane: q. side: pl of the plane, -1 if unknown (a tree from memory).
    lower, upper: rows of the children, -1 if empty. swap: the adjacent child is the upper one. level: inner nodes above.
    parent: row, -1 at the root. first, count: a leaf's part of `members`. box (n, 2, 3): of the nodes, q.
    members (m,): triangle indices, opaque (m,): their flags. at (n,): index in memory, -1 if it was never there.
    """

    kind: np.ndarray
    plane: np.ndarray
    side: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    swap: np.ndarray
    level: np.ndarray
    parent: np.ndarray
    first: np.ndarray
    count: np.ndarray
    box: np.ndarray
    members: np.ndarray
    opaque: np.ndarray
    at: np.ndarray
    jumps: int = 0

    def __len__(self):
        return len(self.kind)

    def leaf(self, row: int) -> list[int]:
        """Triangle indices of a leaf (or job), in order."""
        return self.members[self.first[row] : self.first[row] + self.count[row]].tolist()

    def path(self, row: int) -> str:
        """Way from the root: L for lower, U for upper."""
        way = ""
        while self.parent[row] >= 0:
            way = ("L" if self.lower[self.parent[row]] == row else "U") + way
            row = self.parent[row]
        return way or "root"


@dataclass(frozen=True)
class Plane:
    """A split: cost of rule 3, axis, position q, side of the planar triangles, and whether it pays. axis -1: no candidate."""

    cost: int
    axis: int
    p: int
    side: int
    pays: bool


# ---- references ------------------------------------------------------------------------------------------------------


def fixed_from_fp24(bits) -> np.ndarray:
    """FP24 bit patterns, any shape, to q (int64), as `rtl/tbu` does: shift the significand. Raises: ValueError unless exact."""
    bits = np.asarray(bits, dtype=np.int64)
    exponent, significand = bits >> 16 & 0x7F, bits & 0xFFFF | 0x10000
    shift = 62 - exponent
    if np.any(shift < 0):
        raise ValueError("a coordinate is outside (-1, 1)")
    shift = np.minimum(shift, 62)
    size = np.where(exponent == 0, 0, significand >> shift)
    if np.any((size << shift != significand) & (exponent != 0)):
        raise ValueError("a coordinate is no multiple of 2^-17")
    return np.where(bits >> 23 & 1, ONE - size, ONE + size)


def fp24_from_fixed(q) -> np.ndarray:
    """q, any shape, to FP24 bit patterns (uint32): |q - 2^17| has 17 bits, so this is exact. Zero is +0."""
    x = np.asarray(q, dtype=np.int64) - ONE
    size = np.abs(x)
    top = np.frexp(size.astype(np.float64))[1] - 1  # index of the highest one
    word = (top + 46 << 16) | (size << np.maximum(16 - top, 0)) & 0xFFFF
    return np.where(size == 0, 0, word | (x < 0) << 23).astype(np.uint32)


def refs_from_vertices(bits, opaque=None) -> Refs:
    """References of triangles given by the FP24 bit patterns of their vertices.

    Args: bits (N, 3, 3): triangle, vertex, axis. opaque (N,) bool, all by default.
    Raises: ValueError if a coordinate is no multiple of 2^-17 inside (-1, 1), or with more than 2^19 triangles.
    """
    q = fixed_from_fp24(bits).reshape(-1, 3, 3)
    n = len(q)
    if n > MAX_TRIANGLES:
        raise ValueError(f"{n} triangles, at most {MAX_TRIANGLES}")
    flags = np.ones(n, bool) if opaque is None else np.asarray(opaque, bool)
    if n == 0:
        return Refs(np.zeros((0, 3), np.int64), np.zeros((0, 3), np.int64), np.zeros(0, np.int64), flags)
    return Refs(q.min(axis=1), q.max(axis=1), np.arange(n, dtype=np.int64), flags)


# ---- compiled --------------------------------------------------------------------------------------------------------


@njit(cache=True)
def _half_area(box):
    x, y, z = box[1, 0] - box[0, 0], box[1, 1] - box[0, 1], box[1, 2] - box[0, 2]
    return x * y + y * z + z * x


@njit(cache=True)
def _cost(box, axis, p, n_lower, n_upper):
    """Rule 3."""
    a1, a2 = (axis + 1) % 3, (axis + 2) % 3
    e1, e2 = box[1, a1] - box[0, a1], box[1, a2] - box[0, a2]
    w, l = box[1, axis] - box[0, axis], p - box[0, axis]
    cap, rim = e1 * e2, e1 + e2
    total = 2 * (cap + rim * w) + 3 * ((cap + rim * l) * n_lower + (cap + rim * (w - l)) * n_upper)
    return total * (7 if n_lower == 0 or n_upper == 0 else 8)


@njit(cache=True)
def _keep(best, cost, axis, p, side):
    """Candidates come in the order (axis, p, side): the first of those that cost the same stays."""
    if best[1] < 0 or cost < best[0]:
        best[0], best[1], best[2], best[3] = cost, axis, p, side


@njit(cache=True)
def _sorted_plane(lo, hi, ids, n, box, best):
    """Rule 5. best: [cost, axis, p, side], axis -1 without a candidate."""
    best[1] = -1
    events = np.empty(2 * n, np.int64)
    for axis in range(3):
        node_lo, node_hi = box[0, axis], box[1, axis]
        if node_lo == node_hi:
            continue
        size = 0
        for i in range(n):
            a, b = max(lo[ids[i], axis], node_lo), min(hi[ids[i], axis], node_hi)
            if a == b:
                events[size] = a << 2 | _PLANAR
                size += 1
            else:
                events[size] = a << 2 | _START
                events[size + 1] = b << 2 | _END
                size += 2
        ordered = np.sort(events[:size])
        lower, upper, i = 0, n, 0
        while i < size:
            p = ordered[i] >> 2
            ends, planars, starts = 0, 0, 0
            while i < size and ordered[i] >> 2 == p:
                kind = ordered[i] & 3
                if kind == _END:
                    ends += 1
                elif kind == _PLANAR:
                    planars += 1
                else:
                    starts += 1
                i += 1
            upper -= ends + planars  # now lower = #(lo' < p), upper = #(hi' > p)
            if p > node_lo and p < node_hi:
                _keep(best, _cost(box, axis, p, lower + planars, upper), axis, p, 0)
                if planars > 0:
                    _keep(best, _cost(box, axis, p, lower, upper + planars), axis, p, 1)
            elif planars > 0 and planars < n:
                if p == node_lo:
                    _keep(best, _cost(box, axis, p, planars, upper), axis, p, 0)
                else:
                    _keep(best, _cost(box, axis, p, lower, planars), axis, p, 1)
            lower += starts + planars


@njit(cache=True)
def _bin_shift(w):
    s = 0
    while w > COARSE << s:
        s += 1
    return s


@njit(cache=True)
def _fill_bins(lo, hi, ids, n, box, axis, start, shift, bins):
    """Rules 6 and 7: bins (parts, 2) counts of those that enter and leave."""
    bins[:] = 0
    last = bins.shape[0] - 1
    node_lo, node_hi = box[0, axis], box[1, axis]
    for i in range(n):
        a, b = max(lo[ids[i], axis], node_lo), min(hi[ids[i], axis], node_hi)
        enter = (a - start) >> shift
        leave = max(enter, (b - start - 1) >> shift)
        bins[min(max(enter, 0), last), 0] += 1
        bins[min(max(leave, 0), last), 1] += 1


@njit(cache=True)
def _bin_plane(bins, n, box, axis, start, shift, best):
    """Best bound between bins of one axis, against what `best` holds."""
    lower, upper = 0, n
    for j in range(1, bins.shape[0]):
        lower += bins[j - 1, 0]
        upper -= bins[j - 1, 1]
        p = start + (j << shift)
        if p < box[1, axis]:
            _keep(best, _cost(box, axis, p, lower, upper), axis, p, 1)


@njit(cache=True)
def _binned_plane(lo, hi, ids, n, box, refine, best):
    """Rules 6 and 7. best as in `_sorted_plane`."""
    best[1] = -1
    coarse = np.empty((COARSE, 2), np.int64)
    fine = np.empty((FINE, 2), np.int64)
    own = np.empty(4, np.int64)
    for axis in range(3):
        start = box[0, axis]
        s = _bin_shift(box[1, axis] - start)
        _fill_bins(lo, hi, ids, n, box, axis, start, s, coarse)
        if refine:
            own[1] = -1
            _bin_plane(coarse, n, box, axis, start, s, own)
            if own[1] >= 0:
                start = own[2] - (1 << s)
                t = max(s - 5, 0)
                _fill_bins(lo, hi, ids, n, box, axis, start, t, fine)
                _bin_plane(fine, n, box, axis, start, t, best)
        else:
            _bin_plane(coarse, n, box, axis, start, s, best)


@njit(cache=True)
def _sides(lo, hi, ref, box, axis, p, side):
    """Rule 2: bit 0 lower child, bit 1 upper child."""
    a, b = max(lo[ref, axis], box[0, axis]), min(hi[ref, axis], box[1, axis])
    if a == p and b == p:
        return 1 << side
    return (1 if a < p else 0) | (2 if b > p else 0)


@njit(cache=True)
def _grow(a, need):
    if a.shape[0] >= need:
        return a
    b = np.empty((max(need, 2 * a.shape[0]),) + a.shape[1:], a.dtype)
    b[: a.shape[0]] = a
    return b


@njit(cache=True)
def _build(lo, hi, root_box, level, cap, refine_max, max_leaf, max_depth, stop):
    """Nodes (n, _COLUMNS) in canonical order and the rows of the references in the leaves.

    The lists of waiting nodes lie on top of each other in `arena`, the next one on top.
    """
    n_all = lo.shape[0]
    arena = np.arange(max(n_all, 64))
    ids = np.empty(max(n_all, 1), np.int64)
    members = np.empty(max(2 * n_all, 64), np.int64)
    n_members = 0
    nodes = np.empty((max(2 * n_all, 64), _COLUMNS), np.int64)
    n_nodes = 0
    todo = np.empty((max_depth + 8, 5), np.int64)  # begin, count, level, parent, is upper
    todo_box = np.empty((max_depth + 8, 2, 3), np.int64)
    todo[0, 0], todo[0, 1], todo[0, 2], todo[0, 3], todo[0, 4] = 0, n_all, level, -1, 0
    todo_box[0] = root_box
    waiting = 1
    box = np.empty((2, 3), np.int64)
    below = np.empty((2, 3), np.int64)
    above = np.empty((2, 3), np.int64)
    best = np.empty(4, np.int64)
    while waiting > 0:
        waiting -= 1
        begin, n, level, parent = todo[waiting, 0], todo[waiting, 1], todo[waiting, 2], todo[waiting, 3]
        box[:] = todo_box[waiting]
        node = n_nodes
        n_nodes += 1
        nodes = _grow(nodes, n_nodes)
        if parent >= 0:
            nodes[parent, _UPPER if todo[waiting, 4] else _LOWER] = node
        nodes[node, _PLANE], nodes[node, _SIDE], nodes[node, _SWAP] = 0, -1, 0
        nodes[node, _LOWER], nodes[node, _UPPER] = -1, -1
        nodes[node, _LEVEL], nodes[node, _PARENT] = level, parent
        for a in range(3):
            nodes[node, _BOX + a], nodes[node, _BOX + 3 + a] = box[0, a], box[1, a]

        best[1] = -1
        job = stop and n > 0 and n <= cap
        if n > max_leaf and level < max_depth and not job:
            if n <= cap:
                _sorted_plane(lo, hi, arena[begin : begin + n], n, box, best)
            else:
                _binned_plane(lo, hi, arena[begin : begin + n], n, box, n <= refine_max, best)
        if best[1] < 0 or best[0] >= 24 * n * _half_area(box):  # rule 4
            members = _grow(members, n_members + n)
            members[n_members : n_members + n] = arena[begin : begin + n]
            nodes[node, _KIND], nodes[node, _FIRST], nodes[node, _COUNT] = JOB if job else LEAF, n_members, n
            n_members += n
            continue

        axis, p, side = best[1], best[2], best[3]
        ids[:n] = arena[begin : begin + n]
        n_lower, n_upper = 0, 0
        for i in range(n):
            where = _sides(lo, hi, ids[i], box, axis, p, side)
            n_lower += where & 1
            n_upper += where >> 1
        arena = _grow(arena, begin + n_lower + n_upper)
        at_upper, at_lower = begin, begin + n_upper
        for i in range(n):
            where = _sides(lo, hi, ids[i], box, axis, p, side)
            if where & 2:
                arena[at_upper] = ids[i]
                at_upper += 1
            if where & 1:
                arena[at_lower] = ids[i]
                at_lower += 1
        below[:] = box
        above[:] = box
        below[1, axis] = above[0, axis] = p
        swap = n_lower == 0 or (n_upper > 0 and _half_area(above) > _half_area(below))  # rule 8
        nodes[node, _KIND], nodes[node, _PLANE], nodes[node, _SIDE], nodes[node, _SWAP] = axis, p, side, swap
        nodes[node, _FIRST], nodes[node, _COUNT] = 0, 0
        if n_upper > 0:
            todo[waiting, 0], todo[waiting, 1] = begin, n_upper
            todo[waiting, 2], todo[waiting, 3], todo[waiting, 4] = level + 1, node, 1
            todo_box[waiting] = above
            waiting += 1
        if n_lower > 0:
            todo[waiting, 0], todo[waiting, 1] = begin + n_upper, n_lower
            todo[waiting, 2], todo[waiting, 3], todo[waiting, 4] = level + 1, node, 0
            todo_box[waiting] = below
            waiting += 1
    return nodes[:n_nodes], members[:n_members]


# ---- entry points ----------------------------------------------------------------------------------------------------


def _arrays(refs, box):
    lo = np.ascontiguousarray(refs.lo, np.int64).reshape(-1, 3)
    hi = np.ascontiguousarray(refs.hi, np.int64).reshape(-1, 3)
    return lo, hi, np.ascontiguousarray(refs.box if box is None else box, np.int64)


def _run(refs, box, level, cap, refine_max, max_leaf, max_depth, stop):
    lo, hi, box = _arrays(refs, box)
    if len(refs) > MAX_TRIANGLES:
        raise ValueError(f"{len(refs)} references, at most {MAX_TRIANGLES}")
    if len(refs) and not (lo.min() > 0 and hi.max() < 1 << COORD_BITS):
        raise ValueError(f"a coordinate is outside (0, 2^{COORD_BITS})")
    nodes, rows = _build(lo, hi, box, level, cap, refine_max, max_leaf, max_depth, stop)
    column = {name: nodes[:, i] for name, i in zip(_NAMES, range(_BOX))}
    column["swap"] = column["swap"] != 0
    return Tree(
        **column,
        box=nodes[:, _BOX:].reshape(-1, 2, 3),
        members=refs.tri[rows],
        opaque=refs.opaque[rows],
        at=np.full(len(nodes), -1),
    )


_NAMES = ("kind", "plane", "side", "lower", "upper", "swap", "level", "parent", "first", "count")


def build(refs, box=None, cap=CAP, refine_max=REFINE_MAX, max_leaf=MAX_LEAF, max_depth=MAX_DEPTH) -> Tree:
    """The whole tree of an object.

    Args: refs `Refs`; box (2, 3) q, of all triangles (by default theirs); cap: references of a sorting pipeline;
        refine_max: nodes of more references than cap and at most so many get fine bins.
    """
    return _run(refs, box, 0, cap, refine_max, max_leaf, max_depth, False)


def sort_subtree(refs, box, level=0, max_leaf=MAX_LEAF, max_depth=MAX_DEPTH) -> Tree:
    """What one sorting pipeline makes of a job: references, box of its root (2, 3) and level of its root."""
    return _run(refs, box, level, NO_CAP, 0, max_leaf, max_depth, False)


def upper_tree(refs, box=None, cap=CAP, refine_max=REFINE_MAX, max_leaf=MAX_LEAF, max_depth=MAX_DEPTH) -> Tree:
    """What the binning pipeline makes: nodes of kind JOB are subtrees of 1 to cap references for a sorting pipeline.

    `Tree.leaf(row)` has a job's triangles, `box` and `level` the rest; `gap` counts the node slots below its root.
    """
    return _run(refs, box, 0, cap, refine_max, max_leaf, max_depth, True)


def gap(tree: Tree, row: int) -> int:
    """Ancestors of a node that reach it by adjacent children alone: slots that stay free just below the root of a job."""
    free = 0
    while tree.parent[row] >= 0:
        above = tree.parent[row]
        if row != (tree.upper[above] if tree.swap[above] else tree.lower[above]):
            break
        free, row = free + 1, above
    return free


def _plane(best, n, box):
    cost, axis, p, side = (int(v) for v in best)
    if axis < 0:
        return Plane(0, -1, 0, 0, False)
    return Plane(cost, axis, p, side, cost < 24 * n * int(_half_area(box)))


def sorted_plane(refs, box) -> Plane:
    """Best split of one node by rule 5."""
    lo, hi, box = _arrays(refs, box)
    best = np.empty(4, np.int64)
    _sorted_plane(lo, hi, np.arange(len(refs)), len(refs), box, best)
    return _plane(best, len(refs), box)


def coarse_bins(refs, box) -> tuple[np.ndarray, list[int]]:
    """Bins of one node by rule 6: (axis, 32, entered / left) counts, and the shift s of each axis."""
    lo, hi, box = _arrays(refs, box)
    bins = np.zeros((3, COARSE, 2), np.int64)
    shifts = [int(_bin_shift(box[1, a] - box[0, a])) for a in range(3)]
    for a in range(3):
        _fill_bins(lo, hi, np.arange(len(refs)), len(refs), box, a, box[0, a], shifts[a], bins[a])
    return bins, shifts


def evaluate_bins(bins, n, box, axis, start, shift) -> Plane:
    """Best bound of one axis: bins (parts, 2) counted from `start` in parts of 2^shift units; n references in all."""
    box = np.ascontiguousarray(box, np.int64)
    best = np.array([0, -1, 0, 0])
    _bin_plane(np.ascontiguousarray(bins, np.int64), n, box, axis, start, shift, best)
    return _plane(best, n, box)


def fine_bins(refs, box, coarse: list[Plane]) -> tuple[np.ndarray, list[int], list[int]]:
    """Bins of the second look by rule 7: (axis, 64, 2) counts, starts and shifts, all 0 on an axis without a coarse plane.

    Args: coarse: best plane of each axis by rule 6.
    """
    lo, hi, box = _arrays(refs, box)
    bins, starts, shifts = np.zeros((3, FINE, 2), np.int64), [0] * 3, [0] * 3
    for a in range(3):
        if coarse[a].axis >= 0:
            s = int(_bin_shift(box[1, a] - box[0, a]))
            starts[a], shifts[a] = coarse[a].p - (1 << s), max(s - 5, 0)
            _fill_bins(lo, hi, np.arange(len(refs)), len(refs), box, a, starts[a], shifts[a], bins[a])
    return bins, starts, shifts


def binned_plane(refs, box, refine: bool) -> Plane:
    """Best split of one node by rule 6, or by rule 7 if `refine`."""
    lo, hi, box = _arrays(refs, box)
    best = np.empty(4, np.int64)
    _binned_plane(lo, hi, np.arange(len(refs)), len(refs), box, refine, best)
    return _plane(best, len(refs), box)


def partition(refs, box, plane: Plane) -> tuple[Refs, Refs]:
    """References of the lower and of the upper child (rule 2), in order."""
    lo, hi, box = _arrays(refs, box)
    where = np.array([_sides(lo, hi, i, box, plane.axis, plane.p, plane.side) for i in range(len(refs))], np.int64)
    return refs[where & 1 == 1], refs[where & 2 == 2]


def child_boxes(box, plane: Plane) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (2, 3) of the lower and of the upper child."""
    lower, upper = np.array(box, np.int64), np.array(box, np.int64)
    lower[1, plane.axis] = upper[0, plane.axis] = plane.p
    return lower, upper
