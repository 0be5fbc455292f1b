# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Trees of `model.tbu` in memory: records, emission, walking what the hardware wrote, and comparing.

Timing decides where the hardware puts nodes and lists, never what they say. So `walk_memory` turns a memory image into the
canonical form of `tbu.Tree`, and `compare` names the first difference. Only a build by one pipeline without donation has a
fixed image: that of `emit`.
"""

import numpy as np
from numba import njit

from raycore.model.tbu import JOB, LEAF, ONE, Refs, Tree, fixed_from_fp24, fp24_from_fixed

NODE_NONE = (1 << 24) - 1  # where a node's index stands: there is none (rc_pkg.sv)
JUMP_SPLIT = 0xFEFFFF  # most negative FP24 number: every ray goes on to the upper child (rc_tbu_pkg.sv)
JUMP = JUMP_SPLIT | 1 << 27  # axis x, adjacent child is the lower one, which is empty; the target goes into `other`
_OTHER = 29  # lowest bit of the index


# ---- records ---------------------------------------------------------------------------------------------------------


def pack_box(lo, hi) -> int:
    """A box_t: 108 bits, lo.x in the lowest 18, then lo.y, lo.z, hi.x, hi.y, hi.z."""
    word = 0
    for i, q in enumerate([*lo, *hi]):
        word |= int(q) << 18 * i
    return word


def pack_refs(refs: Refs) -> list[int]:
    """Each reference as a tri_ref_t of 128 bits; in memory 16 bytes, low byte first."""
    return [
        pack_box(refs.lo[i], refs.hi[i]) | int(refs.tri[i]) << 108 | int(refs.opaque[i]) << 127
        for i in range(len(refs))
    ]


def unpack_refs(words) -> Refs:
    """Inverse of `pack_refs`."""
    q = np.array([[w >> 18 * i & 0x3FFFF for i in range(6)] for w in words], np.int64).reshape(-1, 6)
    tri = np.array([w >> 108 & 0x7FFFF for w in words], np.int64)
    return Refs(q[:, :3].copy(), q[:, 3:].copy(), tri, np.array([w >> 127 & 1 for w in words], bool))


# ---- emission --------------------------------------------------------------------------------------------------------


@njit(cache=True)
def _post_order(kind, lower, upper, swap):
    """Rows in the order of emission: all of the other child, all of the adjacent one, then the node."""
    n = kind.size
    order = np.empty(n, np.int64)
    stack = np.empty(n + 1, np.int64)
    stack[0] = 0
    top, at = 1, n
    while top > 0:  # the reverse: a node, all of the adjacent child, all of the other one
        top -= 1
        row = stack[top]
        at -= 1
        order[at] = row
        if kind[row] < 3:
            adjacent, other = (upper[row], lower[row]) if swap[row] else (lower[row], upper[row])
            if other >= 0:
                stack[top] = other
                top += 1
            stack[top] = adjacent
            top += 1
    return order


def emit(tree: Tree, node_top: int | None = None, list_base: int = 0) -> tuple[np.ndarray, np.ndarray, int]:
    """Nodes and list entries as one pipeline without extents writes them (`docs/kdtree.md` has the layout).

    Nodes go out in post-order (other subtree, adjacent subtree, node) at falling addresses from node_top - 1, so the
    adjacent child is at own index + 1; lists at rising addresses from list_base. By default the root is node 0.

    Returns: nodes (n,) uint64, the first is the root's; list entries (m,) uint32, the first is number list_base; root's index.
    """
    if np.any(tree.kind == JOB):
        raise ValueError("a tree with jobs is not complete")
    n = len(tree)
    node_top = n if node_top is None else node_top
    order = _post_order(tree.kind, tree.lower, tree.upper, tree.swap)
    index = np.empty(n, np.int64)
    index[order] = node_top - 1 - np.arange(n)

    leaves = order[tree.kind[order] == LEAF]
    many = leaves[tree.count[leaves] > 1]
    sizes = tree.count[many]
    starts = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
    source = np.repeat(tree.first[many] - starts[:-1], sizes) + np.arange(starts[-1])
    lists = (tree.members[source] | tree.opaque[source].astype(np.int64) << 25).astype(np.uint32)
    lists[starts[1:] - 1] |= np.uint32(1 << 24)
    ref = np.zeros(n, np.int64)
    ref[many] = list_base + starts[:-1]
    single = leaves[tree.count[leaves] == 1]
    ref[single] = tree.members[tree.first[single]]

    other = np.where(tree.swap, tree.lower, tree.upper)
    inner = tree.kind < LEAF
    ref[inner] = np.where(other[inner] >= 0, index[other[inner]], 0)
    word = np.where(inner, fp24_from_fixed(np.where(inner, tree.plane, ONE)), tree.count).astype(np.int64)
    word |= tree.kind << 24 | ref << _OTHER
    word |= np.where(inner, tree.swap.astype(np.int64) << 26 | (tree.lower < 0) << 27 | (tree.upper < 0) << 28, 0)
    nodes = np.empty(n, np.uint64)
    nodes[index - index[0]] = word.astype(np.uint64)
    return nodes, lists, int(index[0])


# ---- walking ---------------------------------------------------------------------------------------------------------

_FAULTS = (
    "",
    "index outside the nodes",
    "more nodes than the memory holds: a loop",
    "both children empty",
    "the adjacent child is empty",
    "index of an empty child is not 0",
    "bits set that must be zero",
    "deeper than 64 levels",
    "a leaf's list ends outside the lists",
    "the last flag is not where the count says",
)


@njit(cache=True)
def _walk(nodes, node_base, lists, list_base, root):
    """Rows (kind, split bits, lower, upper, swap, level, parent, first, count, at), members, fault, where it was, jumps."""
    size = nodes.size
    out = np.empty((size + 1, 10), np.int64)
    entries = np.empty(lists.size + size + 1, np.int64)
    stack = np.empty((80, 4), np.int64)  # index, level, parent, is upper
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = root, 0, -1, 0
    top, rows, filled, jumps, visits = 1, 0, 0, 0, 0
    while top > 0:
        top -= 1
        index, level, parent, is_upper = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        while True:
            if index < node_base or index >= node_base + size:
                return out, rows, entries, filled, jumps, 1, index
            visits += 1
            if visits > size:
                return out, rows, entries, filled, jumps, 2, index
            word = np.int64(nodes[index - node_base])
            if word & 0x1FFFFFFF != 0xFEFFFF | 1 << 27:
                break
            jumps += 1
            index = word >> 29 & 0xFFFFFF
        if word >> 53:
            return out, rows, entries, filled, jumps, 6, index
        row = rows
        rows += 1
        if parent >= 0:
            out[parent, 3 if is_upper else 2] = row
        kind, ref = word >> 24 & 3, word >> 29 & 0xFFFFFF
        out[row, 0], out[row, 1], out[row, 4] = kind, word & 0xFFFFFF, 0
        out[row, 2], out[row, 3] = -1, -1
        out[row, 5], out[row, 6], out[row, 7], out[row, 8], out[row, 9] = level, parent, 0, 0, index
        if kind == 3:
            count = word & 0xFFFFF
            if word >> 20 & 15 or word >> 26 & 7:
                return out, rows, entries, filled, jumps, 6, index
            out[row, 7], out[row, 8] = filled, count
            if count == 1:
                entries[filled] = ref | 1 << 24
                filled += 1
            elif count > 1:
                if ref < list_base or ref + count > list_base + lists.size or filled + count > entries.size:
                    return out, rows, entries, filled, jumps, 8, index
                for i in range(count):
                    entry = np.int64(lists[ref - list_base + i])
                    if (entry >> 24 & 1 == 1) != (i == count - 1):
                        return out, rows, entries, filled, jumps, 9, index
                    if entry >> 26:
                        return out, rows, entries, filled, jumps, 6, index
                    entries[filled] = entry
                    filled += 1
            continue
        swap, no_lower, no_upper = word >> 26 & 1, word >> 27 & 1, word >> 28 & 1
        if no_lower and no_upper:
            return out, rows, entries, filled, jumps, 3, index
        if (swap and no_upper) or (not swap and no_lower):
            return out, rows, entries, filled, jumps, 4, index
        if (no_lower or no_upper) and ref != 0:
            return out, rows, entries, filled, jumps, 5, index
        if level >= 64:
            return out, rows, entries, filled, jumps, 7, index
        out[row, 4] = swap
        if not no_upper:
            stack[top, 0] = index + 1 if swap else ref
            stack[top, 1], stack[top, 2], stack[top, 3] = level + 1, row, 1
            top += 1
        if not no_lower:
            stack[top, 0] = ref if swap else index + 1
            stack[top, 1], stack[top, 2], stack[top, 3] = level + 1, row, 0
            top += 1
    return out, rows, entries, filled, jumps, 0, 0


def walk_memory(nodes, lists, root: int, box, node_base: int = 0, list_base: int = 0) -> Tree:
    """Canonical form of a tree in memory. Jump nodes are followed and counted in `jumps`; they are no rows.

    Args:
        nodes: (n,) uint64, number 0 is node `node_base`; slots that nothing points at may hold anything.
        lists: (m,) uint32, number 0 is entry `list_base`.
        root: index of the root. box: (2, 3) of the root, q.
    Returns: `Tree` with `at` (index in memory); side is -1; opaque is True for leaves of one triangle, whose node has no flag.
    Raises: ValueError with the node's index where the words make no sense.
    """
    nodes = np.ascontiguousarray(nodes, np.uint64)
    lists = np.ascontiguousarray(lists, np.uint32)
    out, rows, entries, filled, jumps, fault, where = _walk(nodes, node_base, lists, list_base, root)
    if fault:
        raise ValueError(f"node {where}: {_FAULTS[fault]}")
    out, entries = out[:rows], entries[:filled]
    kind, lower, upper, swap, level, parent, first, count, at = (out[:, i] for i in (0, 2, 3, 4, 5, 6, 7, 8, 9))
    inner = kind < LEAF
    plane = np.zeros(rows, np.int64)
    try:
        plane[inner] = fixed_from_fp24(out[inner, 1])
    except ValueError as error:
        raise ValueError(f"a split plane is off the grid: {error}") from error
    boxes = np.empty((rows, 2, 3), np.int64)
    boxes[0] = box
    for depth in range(1, int(level.max()) + 1):  # parents are a level above
        here = np.flatnonzero(level == depth)
        above = parent[here]
        boxes[here] = boxes[above]
        is_upper = (upper[above] == here).astype(np.int64)
        boxes[here, 1 - is_upper, kind[above]] = plane[above]
    single = np.repeat(count == 1, count)
    return Tree(
        kind=kind,
        plane=plane,
        side=np.full(rows, -1),
        lower=lower,
        upper=upper,
        swap=swap != 0,
        level=level,
        parent=parent,
        first=first,
        count=count,
        box=boxes,
        members=entries & 0xFFFFFF,
        opaque=(entries >> 25 & 1 == 1) | single,
        at=at,
        jumps=int(jumps),
    )


# ---- comparing -------------------------------------------------------------------------------------------------------


def _say(tree, row):
    if row >= len(tree):
        return "no node"
    if tree.kind[row] == LEAF:
        leaf = tree.leaf(row)
        return f"leaf of {len(leaf)}: {leaf[:8]}{' ...' if len(leaf) > 8 else ''}"
    if tree.kind[row] == JOB:
        return f"job of {tree.count[row]}"
    empty = [name for name, child in (("lower", tree.lower[row]), ("upper", tree.upper[row])) if child < 0]
    return (
        f"{'xyz'[tree.kind[row]]} = {tree.plane[row]}, adjacent {'upper' if tree.swap[row] else 'lower'}"
        f"{', empty ' + empty[0] if empty else ''}"
    )


def compare(expected: Tree, found: Tree) -> str | None:
    """First difference of two trees in canonical order, or None. Where nodes lie does not count, nor does `side`."""
    rows = min(len(expected), len(found))
    bad = np.zeros(rows, bool)
    for name in ("kind", "lower", "upper", "swap", "count"):
        bad |= getattr(expected, name)[:rows] != getattr(found, name)[:rows]
    bad |= (expected.plane[:rows] != found.plane[:rows]) & (expected.kind[:rows] < LEAF)
    if bad.any():
        row = int(np.argmax(bad))
    elif len(expected) != len(found):
        row = rows
    else:
        row = -1
    # Leaves before that row hold the same numbers of triangles, so their members stand at the same places.
    ends = [
        int(np.max((tree.first + tree.count)[:row] if row >= 0 else tree.first + tree.count, initial=0))
        for tree in (expected, found)
    ]
    size = min(ends)
    flags = np.repeat(expected.count != 1, expected.count)[:size]  # one triangle: its flag is not in memory
    differ = expected.members[:size] != found.members[:size]
    differ |= (expected.opaque[:size] != found.opaque[:size]) & flags
    if differ.any():
        place = int(np.argmax(differ))
        leaves = np.flatnonzero((expected.kind >= LEAF) & (expected.first <= place) & (expected.count > 0))
        row = int(leaves[np.argmax(expected.first[leaves])])
        if expected.members[place] == found.members[place]:
            return (
                f"at {expected.path(row)}, level {expected.level[row]}: opaque flag of triangle {expected.members[place]}: "
                f"expected {expected.opaque[place]}, found {found.opaque[place]}"
            )
    if row < 0:
        return None
    owner = expected if row < len(expected) else found
    where = f"at {owner.path(row)}, level {owner.level[row]}"
    if row < len(found) and found.at[row] >= 0:
        where += f", index {found.at[row]}"
    return f"{where}: expected {_say(expected, row)}; found {_say(found, row)}"


def sah_cost(tree: Tree, intersect: float = 1.5) -> float:
    """Expected cost of a random ray that meets the root's box: 1 a node, `intersect` a triangle."""
    size = (tree.box[:, 1] - tree.box[:, 0]).astype(np.float64)
    area = size[:, 0] * size[:, 1] + size[:, 1] * size[:, 2] + size[:, 2] * size[:, 0]
    inner = tree.kind < LEAF
    cost = area[inner].sum() + intersect * (area * tree.count)[~inner].sum()
    return float(cost / area[0]) if area[0] > 0.0 else 0.0
