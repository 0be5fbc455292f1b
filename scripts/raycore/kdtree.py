# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Exact SAH kd-tree builder in O(n log n) with split clipping, and the layout of nodes in memory.

Source: I. Wald and V. Havran, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", 2006
(event lists that stay sorted, "perfect splits", three-way handling of planar triangles). What differs, and why:

* Every plane lies on the FP24 grid, for that is what the hardware reads. Clipped bounds are rounded outwards to the
  grid; bounds at vertices are exact, since vertices are FP24 numbers already.
* A plane may lie on a face of its own node when planar triangles lie there and others do not. The child is then flat.
  Walls and floors leave the rest of a room that way.
* Nodes use the hardware's layout (8 bytes, adjacent child, flags for empty children); see `Tree`.

`docs/kdtree.md` has the layout in pictures and figures for real meshes.
"""

import time
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from raycore.errors import SceneError
from raycore.model import fp24

MAX_DEPTH = 32  # inner nodes on a path from the root: entries of a ray's stack (paper Sec. 3.4)
INDEX_LIMIT = (1 << 24) - 1  # node, list and triangle indices have 24 bits; all ones means "none"
COUNT_LIMIT = 1 << 20  # triangles of one leaf
LINE_NODES = 8  # nodes of 8 bytes in a block of 64

AXIS_LEAF = 3
LIST_TRIANGLE, LIST_OPAQUE = np.uint32((1 << 24) - 1), np.uint32(1 << 25)  # fields of list_entry_t
_EMPTY = 4  # kind of an empty leaf while building; never stored
_END, _PLANAR, _START = 0, 1, 2  # event types in the order in which a sweep meets them at one position
_BOTH, _LEFT, _RIGHT = 0, 1, 2
_REF_MASK = (1 << 30) - 1

# Clipping runs in double precision on coordinates in [-1, 1]; errors stay below 1e-11. Boxes are enlarged by this much
# before a triangle is clipped, so that rounding can only make a clipped triangle too large.
_CLIP_SLACK = 1e-10


@dataclass(frozen=True)
class Params:
    """Constants of the builder. Costs are relative; `empty_bonus` multiplies the cost of a split with an empty side."""

    cost_traverse: float = 1.0
    cost_intersect: float = 1.5
    empty_bonus: float = 0.9
    max_leaf: int = 1  # no split at or below this many triangles
    max_depth: int = MAX_DEPTH
    clip: bool = True  # split clipping; without it boxes are cut, as a hardware builder does
    flat_cells: bool = True
    layout: str = "pack"  # "dfs": plain depth first; "lines": no parent ends a line; "pack": see docs/kdtree.md


@dataclass
class Tree:
    """A kd-tree in the hardware's layout.

    nodes: uint64. Inner node: [23:0] split plane (FP24 bits), [25:24] axis, [26] swap: the child at index + 1 is the
        upper one, [27]/[28] lower/upper child is an empty leaf (never stored), [52:29] index of the other child (0 if
        it is empty). Leaf: [25:24] = 3, [19:0] count, [52:29] first list entry, or the triangle itself if count = 1.
    lists: uint32, [23:0] triangle, [24] last of its leaf, [25] opaque; ascending in a leaf.
    bounds: (2, 3) float64, box of all triangles, exact FP24 numbers.
    stats: counts, cost and times; `node_count` excludes padding.
    """

    nodes: np.ndarray
    lists: np.ndarray
    root: int
    bounds: np.ndarray
    params: Params = field(default_factory=Params)
    stats: dict = field(default_factory=dict)


# ---- small helpers ---------------------------------------------------------------------------------------------------


@njit(cache=True)
def _key(x):
    """FP24 number to an integer of the same order (FP24 numbers are exact in single precision)."""
    i = np.int64(np.float32(x + 0.0).view(np.int32))  # + 0.0: one pattern for zero
    return i ^ ((i >> 31) & 0x7FFFFFFF)


@njit(cache=True)
def _value(key):
    i = key ^ ((key >> 31) & 0x7FFFFFFF)
    return np.float64(np.int32(i).view(np.float32))


@njit(cache=True)
def _event(key, kind, ref):
    return (key << 32) | (np.int64(kind) << 30) | np.int64(ref)


@njit(cache=True)
def _grid(x, up):
    """Next FP24 number at or above (up) or below x."""
    r = fp24.rnd(x)
    if up and r < x:
        return fp24.ulp_add(r, 1) if r != 0.0 else fp24.MIN_NORMAL
    if not up and r > x:
        return fp24.ulp_add(r, -1) if r != 0.0 else -fp24.MIN_NORMAL
    return r


@njit(cache=True)
def _grow(a, need):
    if a.size >= need:
        return a
    b = np.empty(max(need, 2 * a.size), a.dtype)
    for i in range(a.size):  # a loop compiles several times faster than slices do
        b[i] = a[i]
    return b


@njit(cache=True)
def _sort(a, begin, end):
    """Sort a[begin:end] in place (heap sort)."""
    n = end - begin
    start = n // 2
    while n > 1:
        if start > 0:
            start -= 1
            top = a[begin + start]
        else:
            n -= 1
            top = a[begin + n]
            a[begin + n] = a[begin]
        i = start
        while 2 * i + 1 < n:
            child = 2 * i + 1
            if child + 1 < n and a[begin + child + 1] > a[begin + child]:
                child += 1
            if a[begin + child] <= top:
                break
            a[begin + i] = a[begin + child]
            i = child
        a[begin + i] = top


@njit(cache=True)
def _half_area(lo, hi):
    x, y, z = hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]
    return x * y + y * z + z * x


# ---- clipping --------------------------------------------------------------------------------------------------------


@njit(cache=True)
def _clip(tris, ref, lo, hi, slack, poly, out):
    """Bounds of a triangle inside a box (Sutherland and Hodgman 1974), rounded outwards to the FP24 grid.

    tris (N, 3, 3), ref the triangle, lo and hi (3,); poly (2, 12, 3) scratch; out (2, 3) bounds, inside the box.
    Returns False if nothing is left.
    """
    n = 3
    cur = 0
    for i in range(3):
        for a in range(3):
            poly[0, i, a] = tris[ref, i, a]
    for a in range(3):
        for side in range(2):
            plane = lo[a] - slack if side == 0 else hi[a] + slack
            sign = 1.0 if side == 0 else -1.0
            outside = False
            for i in range(n):
                if (poly[cur, i, a] - plane) * sign < 0.0:
                    outside = True
                    break
            if not outside:
                continue
            m = 0
            dst = 1 - cur
            for i in range(n):
                j = i + 1 if i + 1 < n else 0
                p = (poly[cur, i, a] - plane) * sign
                q = (poly[cur, j, a] - plane) * sign
                if p >= 0.0:
                    for c in range(3):
                        poly[dst, m, c] = poly[cur, i, c]
                    m += 1
                if (p > 0.0 and q < 0.0) or (p < 0.0 and q > 0.0):
                    t = p / (p - q)
                    for c in range(3):
                        poly[dst, m, c] = poly[cur, i, c] + t * (poly[cur, j, c] - poly[cur, i, c])
                    poly[dst, m, a] = plane
                    m += 1
            n = m
            cur = dst
            if n == 0:
                return False
    for a in range(3):
        low = poly[cur, 0, a]
        high = low
        for i in range(1, n):
            v = poly[cur, i, a]
            low = min(low, v)
            high = max(high, v)
        out[0, a] = min(max(_grid(low, False), lo[a]), hi[a])
        out[1, a] = max(min(_grid(high, True), hi[a]), lo[a])
    return True


@njit(cache=True)
def _cut(tris, ref, lo, hi, out):
    """Bounds of a triangle cut to a box: what is known without clipping."""
    for a in range(3):
        low = min(tris[ref, 0, a], tris[ref, 1, a], tris[ref, 2, a])
        high = max(tris[ref, 0, a], tris[ref, 1, a], tris[ref, 2, a])
        out[0, a] = min(max(low, lo[a]), hi[a])
        out[1, a] = max(min(high, hi[a]), lo[a])


# ---- the builder -----------------------------------------------------------------------------------------------------


@njit(cache=True)
def _sweep(events, begin, end, axis, n, lo, hi, ct, ci, bonus, flat, best):
    """Cheapest plane of one axis. best: [cost, axis, key, planar side], replaced if something cheaper is found.

    Costs are multiplied by the node's half area, so that flat nodes need no special case.
    """
    a1, a2 = (axis + 1) % 3, (axis + 2) % 3
    e1, e2 = hi[a1] - lo[a1], hi[a2] - lo[a2]
    cap, rim = e1 * e2, e1 + e2
    area = cap + rim * (hi[axis] - lo[axis])
    key_lo, key_hi = _key(lo[axis]), _key(hi[axis])
    left = 0
    right = n
    i = begin
    while i < end:
        key = events[i] >> 32
        ends = 0
        planars = 0
        starts = 0
        while i < end and events[i] >> 32 == key:
            kind = (events[i] >> 30) & 3
            if kind == _END:
                ends += 1
            elif kind == _PLANAR:
                planars += 1
            else:
                starts += 1
            i += 1
        right -= planars + ends
        inner = key > key_lo and key < key_hi
        # A face of the node is a candidate only if it takes planar triangles away from others.
        face = (
            flat and planars > 0 and ((key == key_lo and right > 0) or (key == key_hi and left > 0)) and key_lo < key_hi
        )
        if inner or face:
            p = _value(key)
            area_l = cap + rim * (p - lo[axis])
            area_r = cap + rim * (hi[axis] - p)
            for side in range(2):  # planar triangles go left, then right
                if face and ((side == 0) != (key == key_lo)):
                    continue
                nl = left + planars if side == 0 else left
                nr = right if side == 0 else right + planars
                cost = ct * area + ci * (area_l * nl + area_r * nr)
                if nl == 0 or nr == 0:
                    cost *= bonus
                if cost < best[0]:
                    best[0] = cost
                    best[1] = axis
                    best[2] = key
                    best[3] = side
                if planars == 0:
                    break
        left += starts + planars


@njit(cache=True)
def _emit(bounds, ref, fresh, room, counts):
    """Append the events of a clipped triangle to a child's unsorted lists: one an axis, `room` apart in `fresh`."""
    for a in range(3):
        low, high = _key(bounds[0, a]), _key(bounds[1, a])
        if low == high:
            fresh[a * room + counts[a]] = _event(low, _PLANAR, ref)
            counts[a] += 1
        else:
            fresh[a * room + counts[a]] = _event(low, _START, ref)
            fresh[a * room + counts[a] + 1] = _event(high, _END, ref)
            counts[a] += 2


@njit(cache=True)
def _build(tris, ids, events, sizes, scene_lo, scene_hi, ct, ci, bonus, max_leaf, max_depth, clip, flat):
    """Depth-first build. tris (N, 3, 3), ids (N,) their numbers in the scene, events the sorted
    lists of the whole scene one after the other, sizes (3,) their lengths.

    The event lists of waiting nodes lie on top of each other in one array: a node's lists are the top of it when its
    turn comes, and its children's replace them.

    Returns arrays over nodes (kind, split, left, right, first, count, half area, depth) and the leaf lists.
    """
    n_all = tris.shape[0]
    arena = np.empty(4 * events.size + 64, np.int64)
    for i in range(events.size):
        arena[i] = events[i]
    side_of = np.zeros(n_all, np.int64)
    fresh_l = np.empty(4096, np.int64)
    fresh_r = np.empty(4096, np.int64)
    out_l = np.empty(4096, np.int64)
    out_r = np.empty(4096, np.int64)
    count_l = np.zeros(3, np.int64)
    count_r = np.zeros(3, np.int64)
    size_l = np.zeros(3, np.int64)
    size_r = np.zeros(3, np.int64)
    poly = np.empty((2, 12, 3))
    bounds_l = np.empty((2, 3))
    bounds_r = np.empty((2, 3))
    best = np.empty(4)

    cap = max(64, 4 * n_all)
    kind = np.empty(cap, np.int64)
    split = np.empty(cap, np.float64)
    child_l = np.empty(cap, np.int64)
    child_r = np.empty(cap, np.int64)
    first = np.empty(cap, np.int64)
    count = np.empty(cap, np.int64)
    area = np.empty(cap, np.float64)
    depth_of = np.empty(cap, np.int64)
    lists = np.empty(max(64, 4 * n_all), np.int64)
    n_nodes = 0
    n_lists = 0

    # Waiting nodes: boxes, and [arena begin, events x, y, z, triangles, depth, parent, is right child].
    todo_box = np.empty((2 * max_depth + 8, 2, 3))
    todo = np.empty((2 * max_depth + 8, 8), np.int64)
    for a in range(3):
        todo_box[0, 0, a], todo_box[0, 1, a] = scene_lo[a], scene_hi[a]
        todo[0, 1 + a] = sizes[a]
    todo[0, 0] = 0
    todo[0, 4], todo[0, 5], todo[0, 6], todo[0, 7] = n_all, 0, -1, 0
    waiting = 1
    lo = np.empty(3)
    hi = np.empty(3)
    mid_l = np.empty(3)
    mid_r = np.empty(3)

    while waiting > 0:
        waiting -= 1
        begin, n, depth, parent = todo[waiting, 0], todo[waiting, 4], todo[waiting, 5], todo[waiting, 6]
        b0 = begin
        b1 = b0 + todo[waiting, 1]
        b2 = b1 + todo[waiting, 2]
        b3 = b2 + todo[waiting, 3]
        for a in range(3):
            lo[a], hi[a] = todo_box[waiting, 0, a], todo_box[waiting, 1, a]
        node_area = _half_area(lo, hi)

        node = n_nodes
        n_nodes += 1
        if n_nodes > kind.size:
            kind, split, area = _grow(kind, n_nodes), _grow(split, n_nodes), _grow(area, n_nodes)
            child_l, child_r = _grow(child_l, n_nodes), _grow(child_r, n_nodes)
            first, count, depth_of = _grow(first, n_nodes), _grow(count, n_nodes), _grow(depth_of, n_nodes)
        area[node] = node_area
        depth_of[node] = depth
        if parent >= 0:
            if todo[waiting, 7] == 0:
                child_l[parent] = node
            else:
                child_r[parent] = node

        best[0] = ci * n * node_area  # a leaf's cost: a plane must be cheaper
        best[1] = -1.0
        if n > max_leaf and depth < max_depth:
            for a in range(3):
                s0 = b0 if a == 0 else (b1 if a == 1 else b2)
                s1 = b1 if a == 0 else (b2 if a == 1 else b3)
                _sweep(arena, s0, s1, a, n, lo, hi, ct, ci, bonus, flat, best)

        if best[1] < 0.0:
            kind[node] = AXIS_LEAF if n > 0 else _EMPTY
            split[node] = 0.0
            first[node] = n_lists
            count[node] = n
            lists = _grow(lists, n_lists + n)
            for i in range(b0, b1):
                if (arena[i] >> 30) & 3 != _END:
                    lists[n_lists] = ids[arena[i] & _REF_MASK]
                    n_lists += 1
            _sort(lists, first[node], n_lists)
            continue

        axis = int(best[1])
        key = np.int64(best[2])
        planar_left = best[3] == 0.0
        plane = _value(key)
        kind[node] = axis
        split[node] = plane
        first[node] = 0
        count[node] = 0

        # Classify against the plane.
        s0 = b0 if axis == 0 else (b1 if axis == 1 else b2)
        s1 = b1 if axis == 0 else (b2 if axis == 1 else b3)
        n_left = 0
        n_right = 0
        for i in range(s0, s1):
            e = arena[i]
            k = e >> 32
            what = (e >> 30) & 3
            ref = e & _REF_MASK
            if what == _START:
                side_of[ref] = _RIGHT if k >= key else _BOTH
                n_right += k >= key
            elif what == _END:
                if k <= key:
                    side_of[ref] = _LEFT
                    n_left += 1
            else:
                goes_left = k < key or (k == key and planar_left)
                side_of[ref] = _LEFT if goes_left else _RIGHT
                n_left += goes_left
                n_right += not goes_left

        # Clip what lies on both sides, and sort its new events.
        n_both = n - n_left - n_right
        room = 2 * n_both
        fresh_l = _grow(fresh_l, 3 * room)
        fresh_r = _grow(fresh_r, 3 * room)
        for a in range(3):
            count_l[a] = 0
            count_r[a] = 0
            mid_l[a] = hi[a]
            mid_r[a] = lo[a]
        mid_l[axis] = plane
        mid_r[axis] = plane
        n_both_l = 0
        n_both_r = 0
        if n_both > 0:
            for i in range(s0, s1):
                e = arena[i]
                if (e >> 30) & 3 != _START or side_of[e & _REF_MASK] != _BOTH:
                    continue
                ref = e & _REF_MASK
                in_l = True
                in_r = True
                if clip:
                    in_l = _clip(tris, ref, lo, mid_l, _CLIP_SLACK, poly, bounds_l)
                    in_r = _clip(tris, ref, mid_r, hi, _CLIP_SLACK, poly, bounds_r)
                if not clip or not (in_l or in_r):
                    in_l = True
                    in_r = True
                    _cut(tris, ref, lo, mid_l, bounds_l)
                    _cut(tris, ref, mid_r, hi, bounds_r)
                if in_l:
                    _emit(bounds_l, ref, fresh_l, room, count_l)
                    n_both_l += 1
                if in_r:
                    _emit(bounds_r, ref, fresh_r, room, count_r)
                    n_both_r += 1
            for a in range(3):
                _sort(fresh_l, a * room, a * room + count_l[a])
                _sort(fresh_r, a * room, a * room + count_r[a])

        # Hand the events down, merged with the new ones: both lists stay sorted.
        need = b3 - b0 + 6 * n_both + 64
        out_l = _grow(out_l, need)
        out_r = _grow(out_r, need)
        wl = 0
        wr = 0
        for a in range(3):
            s0 = b0 if a == 0 else (b1 if a == 1 else b2)
            s1 = b1 if a == 0 else (b2 if a == 1 else b3)
            fl = 0
            fr = 0
            wl0 = wl
            wr0 = wr
            for i in range(s0, s1):
                e = arena[i]
                side = side_of[e & _REF_MASK]
                if side == _LEFT:
                    while fl < count_l[a] and fresh_l[a * room + fl] < e:
                        out_l[wl] = fresh_l[a * room + fl]
                        wl += 1
                        fl += 1
                    out_l[wl] = e
                    wl += 1
                elif side == _RIGHT:
                    while fr < count_r[a] and fresh_r[a * room + fr] < e:
                        out_r[wr] = fresh_r[a * room + fr]
                        wr += 1
                        fr += 1
                    out_r[wr] = e
                    wr += 1
            while fl < count_l[a]:
                out_l[wl] = fresh_l[a * room + fl]
                wl += 1
                fl += 1
            while fr < count_r[a]:
                out_r[wr] = fresh_r[a * room + fr]
                wr += 1
                fr += 1
            size_l[a] = wl - wl0
            size_r[a] = wr - wr0

        # The left child comes next, hence on top.
        arena = _grow(arena, begin + wl + wr)
        for i in range(wr):
            arena[begin + i] = out_r[i]
        for i in range(wl):
            arena[begin + wr + i] = out_l[i]
        for child in range(2):
            w = waiting
            waiting += 1
            for a in range(3):
                todo_box[w, 0, a] = mid_r[a] if child == 0 else lo[a]
                todo_box[w, 1, a] = hi[a] if child == 0 else mid_l[a]
                todo[w, 1 + a] = size_r[a] if child == 0 else size_l[a]
            todo[w, 0] = begin if child == 0 else begin + wr
            todo[w, 4] = n_right + n_both_r if child == 0 else n_left + n_both_l
            todo[w, 5] = depth + 1
            todo[w, 6] = node
            todo[w, 7] = 1 - child

    return (
        kind[:n_nodes],
        split[:n_nodes],
        child_l[:n_nodes],
        child_r[:n_nodes],
        first[:n_nodes],
        count[:n_nodes],
        area[:n_nodes],
        depth_of[:n_nodes],
        lists[:n_lists],
    )


# ---- layout ----------------------------------------------------------------------------------------------------------


@njit(cache=True)
def _chain(node, kind, child_l, child_r, area, adjacent, other):
    """Follow adjacent children from `node` to a leaf: choose both children on the way, return the length."""
    length = 1
    while kind[node] < AXIS_LEAF:
        left, right = child_l[node], child_r[node]
        if kind[right] == _EMPTY:
            adjacent[node], other[node] = left, -1
        elif kind[left] == _EMPTY:
            adjacent[node], other[node] = right, -1
        elif area[right] > area[left]:
            adjacent[node], other[node] = right, left
        else:
            adjacent[node], other[node] = left, right
        node = adjacent[node]
        length += 1
    return length


@njit(cache=True)
def _place(kind, child_l, child_r, area, mode):
    """Slot of every stored node. mode 0: depth first; 1: chains avoid the end of a line; 2: chains packed into lines.

    Adjacent children form chains of consecutive slots that end in a leaf; where a chain starts is free. A chain of up
    to 8 nodes crosses no line unless it starts too late in one. Modes 1 and 2 leave slots free so that no chain crosses
    more lines than it must; mode 2 first fills them with chains that hang from a node of the same line (largest area
    first), then with any recent one that fits.
    """
    n = kind.size
    slot = np.empty(n, np.int64)
    adjacent = np.empty(n, np.int64)
    other = np.empty(n, np.int64)
    for i in range(n):
        slot[i] = adjacent[i] = other[i] = -1
    stack = np.empty(n + 1, np.int64)
    lengths = np.empty(n + 1, np.int64)
    parents = np.empty(n + 1, np.int64)  # slot of the parent
    stack[0], parents[0] = 0, -1
    lengths[0] = _chain(0, kind, child_l, child_r, area, adjacent, other)
    top = 1
    cursor = 0
    window = 48
    while top > 0:
        pick = top - 1
        offset = cursor % LINE_NODES
        if mode > 0:
            fits = (offset + lengths[pick] - 1) // LINE_NODES == (lengths[pick] - 1) // LINE_NODES
            if mode == 2 and offset > 0:
                line = cursor // LINE_NODES
                found = -1
                best = -1.0
                for j in range(top - 1, max(top - 1 - window, -1), -1):
                    near = parents[j] // LINE_NODES == line
                    if offset + lengths[j] <= LINE_NODES and (near or (best < 0.0 and not fits)):
                        value = area[stack[j]] if near else -0.5
                        if value > best:
                            best, found = value, j
                if found >= 0:
                    pick, fits = found, True
            if not fits:
                if mode == 2 or offset == LINE_NODES - 1:
                    cursor += LINE_NODES - offset
        node = stack[pick]
        for j in range(pick, top - 1):
            stack[j], lengths[j], parents[j] = stack[j + 1], lengths[j + 1], parents[j + 1]
        top -= 1
        while True:
            slot[node] = cursor
            cursor += 1
            if kind[node] >= AXIS_LEAF:
                break
            if other[node] >= 0:
                stack[top], parents[top] = other[node], slot[node]
                lengths[top] = _chain(other[node], kind, child_l, child_r, area, adjacent, other)
                top += 1
            node = adjacent[node]
    return slot, adjacent, other, cursor


def _pack(built, params):
    """Node words and list entries from the builder's arrays; returns nodes, lists, layout statistics."""
    kind, split, child_l, child_r, first, count, area, _, leaf_tris = built
    mode = {"dfs": 0, "lines": 1, "pack": 2}[params.layout]
    slot, adjacent, other, size = _place(kind, child_l, child_r, area, mode)
    stored = np.flatnonzero(slot >= 0)
    nodes = np.full(size, AXIS_LEAF << 24, np.uint64)  # padding reads as a leaf without triangles

    # List entries, ascending inside a leaf; a leaf of one triangle has none.
    leaves = np.flatnonzero((kind == AXIS_LEAF) & (slot >= 0))
    leaves = leaves[np.argsort(slot[leaves], kind="stable")]
    many = leaves[count[leaves] > 1]
    sizes = count[many].astype(np.int64)
    starts = np.concatenate(([0], np.cumsum(sizes)))
    source = np.repeat(first[many] - starts[:-1], sizes) + np.arange(starts[-1])
    lists = leaf_tris[source].astype(np.uint32) | LIST_OPAQUE
    if many.size:
        lists[starts[1:] - 1] |= np.uint32(1 << 24)

    ref = np.zeros(kind.size, np.uint64)
    ref[many] = starts[:-1]
    single = leaves[count[leaves] == 1]
    ref[single] = leaf_tris[first[single]]
    nodes[slot[leaves]] = count[leaves].astype(np.uint64) | np.uint64(AXIS_LEAF << 24) | (ref[leaves] << np.uint64(29))

    inner = stored[kind[stored] < AXIS_LEAF]
    left, right = child_l[inner], child_r[inner]
    word = fp24.to_bits(split[inner]).astype(np.uint64)
    word |= kind[inner].astype(np.uint64) << np.uint64(24)
    word |= (adjacent[inner] == right).astype(np.uint64) << np.uint64(26)
    word |= (kind[left] == _EMPTY).astype(np.uint64) << np.uint64(27)
    word |= (kind[right] == _EMPTY).astype(np.uint64) << np.uint64(28)
    has_other = other[inner] >= 0
    word |= np.where(has_other, slot[other[inner]], 0).astype(np.uint64) << np.uint64(29)
    nodes[slot[inner]] = word

    line = slot // LINE_NODES
    near_adj = line[inner] == line[adjacent[inner]]
    near_other = has_other & (line[inner] == line[other[inner]])
    children = inner.size + np.count_nonzero(has_other)
    visits = float((area[adjacent[inner]]).sum() + (area[other[inner]] * has_other).sum())
    near = float((area[adjacent[inner]] * near_adj).sum() + (area[other[inner]] * near_other).sum())
    stats = {
        "padding": int(size - stored.size),
        "adjacent_in_line": float(near_adj.mean()) if inner.size else 1.0,
        "children_in_line": float((near_adj.sum() + near_other.sum()) / children) if children else 1.0,
        # Weighted by area, i.e. by how often a random ray goes from a node to that child.
        "visits_in_line": near / visits if visits > 0.0 else 1.0,
        "line_end_parents": int(np.count_nonzero(slot[inner] % LINE_NODES == LINE_NODES - 1)),
    }
    return nodes, lists, stats


def _sort_events(tris):
    """Sorted event lists of whole triangles (N, 3, 3), one an axis."""
    out = []
    lo, hi = tris.min(axis=1) + 0.0, tris.max(axis=1) + 0.0
    refs = np.arange(tris.shape[0], dtype=np.int64)
    for a in range(3):
        keys = []
        for bound in (lo[:, a], hi[:, a]):
            i = bound.astype(np.float32).view(np.int32).astype(np.int64)
            keys.append(i ^ ((i >> 31) & 0x7FFFFFFF))
        flat = keys[0] == keys[1]
        low = (keys[0] << 32) | (np.where(flat, _PLANAR, _START) << 30) | refs
        high = ((keys[1] << 32) | (_END << 30) | refs)[~flat]
        out.append(np.sort(np.concatenate((low, high))))
    return out


def build(tri24, mask=None, params=None):
    """Build the tree of a scene.

    Args:
        tri24: (N, 3, 3) float64, vertices that are FP24 numbers in [-1, 1] (`scene.normalise`).
        mask: (N,) bool, triangles to leave out (no area); their indices stay reserved.
        params: `Params`.
    Returns: `Tree`. Every point of a triangle lies in the closed box of a leaf that lists the triangle.
    Raises: SceneError if an index or a leaf outgrows its bits; ValueError if a vertex is not an FP24 number in [-1, 1].
    """
    params = params or Params()
    if not 1 <= params.max_depth <= MAX_DEPTH:
        raise ValueError(f"max_depth {params.max_depth} is outside 1..{MAX_DEPTH}")
    began = time.perf_counter()
    tri24 = np.ascontiguousarray(tri24, dtype=np.float64)
    if tri24.shape[0] >= INDEX_LIMIT:
        raise SceneError(f"{tri24.shape[0]} triangles, at most {INDEX_LIMIT - 1} fit 24-bit indices; simplify the mesh")
    ids = np.arange(tri24.shape[0], dtype=np.int32) if mask is None else np.flatnonzero(~mask).astype(np.int32)
    if ids.size == 0:
        nodes = np.array([AXIS_LEAF << 24], np.uint64)
        stats = {
            "node_count": 1,
            "leaf_count": 1,
            "empty_leaf_count": 0,
            "depth": 0,
            "sah_cost": 0.0,
            "list_entries": 0,
        }
        stats |= {
            "padding": 0,
            "adjacent_in_line": 1.0,
            "children_in_line": 1.0,
            "visits_in_line": 1.0,
            "line_end_parents": 0,
        }
        return Tree(nodes, np.zeros(0, np.uint32), 0, np.zeros((2, 3)), params, stats)
    tris = tri24[ids] + 0.0
    if not np.all(np.abs(tris) <= 1.0) or np.any(tris != fp24.round_to_fp24(tris)):
        raise ValueError("vertices must be FP24 numbers in [-1, 1]")
    lo, hi = tris.min(axis=(0, 1)), tris.max(axis=(0, 1))
    events = _sort_events(tris)
    built = _build(
        tris,
        ids,
        np.concatenate(events),
        np.array([e.size for e in events]),
        lo,
        hi,
        float(params.cost_traverse),
        float(params.cost_intersect),
        float(params.empty_bonus),
        int(params.max_leaf),
        int(params.max_depth),
        bool(params.clip),
        bool(params.flat_cells),
    )
    built_at = time.perf_counter()
    kind, _, _, _, _, count, area, depth_of, leaf_tris = built
    if count.max() >= COUNT_LIMIT:
        raise SceneError(
            f"a leaf holds {count.max()} triangles, more than {COUNT_LIMIT - 1}; remove coincident triangles"
        )
    nodes, lists, layout_stats = _pack(built, params)
    if nodes.size >= INDEX_LIMIT or lists.size >= INDEX_LIMIT:
        raise SceneError(
            f"the tree has {nodes.size} nodes and {lists.size} list entries (limit {INDEX_LIMIT - 1}); simplify the mesh"
        )
    root_area = area[0] if area[0] > 0.0 else 1.0
    inner, leaf = kind < AXIS_LEAF, kind == AXIS_LEAF
    cost = params.cost_traverse * area[inner].sum() + params.cost_intersect * (area[leaf] * count[leaf]).sum()
    stats = {
        "node_count": int(np.count_nonzero(kind != _EMPTY)),
        "leaf_count": int(np.count_nonzero(leaf)),
        "empty_leaf_count": int(np.count_nonzero(kind == _EMPTY)),
        "depth": int(depth_of.max()),
        "sah_cost": float(cost / root_area),
        "list_entries": int(lists.size),
        "references": int(leaf_tris.size),
        "largest_leaf": int(count.max()),
        "build_seconds": built_at - began,
        "layout_seconds": time.perf_counter() - built_at,
        **layout_stats,
    }
    return Tree(nodes, lists, 0, np.stack((lo, hi)), params, stats)


# ---- reading a tree back ---------------------------------------------------------------------------------------------


def opaque_lists(lists, opaque):
    """List entries (m,) uint32, of which those of triangles that are not opaque lose their flag. opaque (N,) bool."""
    return lists & ~np.where(opaque[lists & LIST_TRIANGLE], 0, LIST_OPAQUE).astype(np.uint32)


@dataclass
class Walk:
    """A tree decoded from its words alone: one row a stored node, parents before children."""

    index: np.ndarray  # slot in the node array
    axis: np.ndarray  # 3: leaf
    split: np.ndarray
    box: np.ndarray  # (n, 2, 3)
    depth: np.ndarray
    parent: np.ndarray  # row, -1 at the root
    leaf_rows: np.ndarray  # rows of the leaves
    leaf_begin: np.ndarray  # (leaves + 1,) where each leaf's triangles begin in `members`
    members: np.ndarray
    empty: np.ndarray  # (m, 2, 3) boxes of the empty leaves

    @property
    def leaves(self):
        """[(row, triangles)] of every leaf."""
        parts = np.split(self.members, self.leaf_begin[1:-1])
        return list(zip(self.leaf_rows.tolist(), parts))


def walk(tree):
    """Decode every reachable node of a `Tree`, a level at a time. Raises: ValueError where the words make no sense."""

    def need(good, what):
        if not np.all(good):
            raise ValueError(f"{what}: node {index[np.argmin(good)]}")

    levels, empty = [], [np.zeros((0, 2, 3))]
    index, box = np.array([tree.root], np.int64), tree.bounds[None].astype(np.float64)
    parent, done = np.array([-1]), 0
    seen = np.zeros(tree.nodes.size, bool)
    while index.size:
        need(index < tree.nodes.size, "outside the tree")
        need(~seen[index] & (np.bincount(index)[index] == 1), "has two parents")
        seen[index] = True
        word = tree.nodes[index].astype(np.int64)
        axis, ref = word >> 24 & 3, word >> 29 & 0xFFFFFF
        leaf = axis == AXIS_LEAF
        swap, no_lower, no_upper = (((word >> bit & 1) == 1) & ~leaf for bit in (26, 27, 28))
        need(tree.nodes[index] >> np.uint64(53) == 0, "bits set that must be zero")
        need(~leaf | (word >> 20 & 15 == 0) & (word >> 26 & 7 == 0), "leaf with bits set that must be zero")
        need(~(no_lower & no_upper), "both children empty")
        need(~(no_lower & ~swap) & ~(no_upper & swap), "the adjacent child is the empty one")
        need(~(no_lower | no_upper) | (ref == 0), "index of an empty child is not 0")
        split = np.where(leaf, 0.0, fp24.from_bits(word & 0xFFFFFF))
        rows = np.flatnonzero(~leaf)
        at = axis[rows]
        lower, upper = box[rows].copy(), box[rows].copy()
        lower[np.arange(rows.size), 1, at] = upper[np.arange(rows.size), 0, at] = split[rows]
        inside = np.ones(index.size, bool)
        inside[rows] = (box[rows, 0, at] <= split[rows]) & (split[rows] <= box[rows, 1, at])
        need(inside, "plane outside its box")
        levels.append((index, axis, split, box, np.full(index.size, len(levels)), parent))
        empty += [lower[no_lower[rows]], upper[no_upper[rows]]]
        go_lower, go_upper = ~no_lower[rows], ~no_upper[rows]
        to_lower = np.where(swap, ref, index + 1)[rows][go_lower]
        to_upper = np.where(swap, index + 1, ref)[rows][go_upper]
        parent = np.concatenate((rows[go_lower], rows[go_upper])) + done
        done += index.size
        index, box = np.concatenate((to_lower, to_upper)), np.concatenate((lower[go_lower], upper[go_upper]))

    index, axis, split, box, depth, parent = (np.concatenate(column) for column in zip(*levels))
    leaf_rows = np.flatnonzero(axis == AXIS_LEAF)
    word = tree.nodes[index[leaf_rows]].astype(np.int64)
    count, ref = word & 0xFFFFF, word >> 29 & 0xFFFFFF
    begin = np.concatenate(([0], np.cumsum(count)))
    owner = np.repeat(np.arange(leaf_rows.size), count)
    entry = ref[owner] + np.arange(begin[-1]) - begin[:-1][owner]
    members = ref[owner]
    many = count[owner] > 1
    if many.any():
        if entry[many].max() >= tree.lists.size:
            raise ValueError("a leaf's list ends outside the lists")
        words = tree.lists[entry[many]].astype(np.int64)
        last = np.arange(begin[-1]) + 1 == begin[1:][owner]
        if np.any((words >> 24 & 1 == 1) != last[many]):
            raise ValueError("a list does not end where its leaf says")
        members[many] = words & 0xFFFFFF
    return Walk(index, axis, split, box, depth, parent, leaf_rows, begin, members, np.concatenate(empty))


def sah_cost(tree):
    """SAH cost recomputed from the words: expected cost of a random ray that meets the scene's box."""
    w = walk(tree)
    size = w.box[:, 1] - w.box[:, 0]
    area = size[:, 0] * size[:, 1] + size[:, 1] * size[:, 2] + size[:, 2] * size[:, 0]
    cost = tree.params.cost_traverse * area[w.axis < AXIS_LEAF].sum()
    cost += tree.params.cost_intersect * (area[w.leaf_rows] * np.diff(w.leaf_begin)).sum()
    return float(cost / area[0]) if area[0] > 0.0 else 0.0


def stack_depth(tree):
    """Most entries that a ray's stack can hold: nodes on a path whose children are both stored."""
    w = walk(tree)
    words = tree.nodes[w.index]
    pushes = ((w.axis < AXIS_LEAF) & ((words >> np.uint64(27) & np.uint64(3)) == 0)).astype(int)
    for depth in range(1, int(w.depth.max()) + 1):
        level = w.depth == depth
        pushes[level] += pushes[w.parent[level]]
    return int(pushes.max())
