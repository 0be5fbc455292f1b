# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Reference T&I unit: one ray through the kd-tree, bit for bit and slot for slot what `rtl/tni/` computes.

The order of operations is that of docs/tni.md (paper Sec. 3.4 and Fig. 5; Wald 2004 in vertex-relative form). Values are
float64 that hold FP24 numbers, see `raycore.model.fp24`. A *slot* is one pass of a ray through the 19 stages; cache
misses cost further slots in hardware, which this model does not have.

With dynamic objects there are three kinds of trees: the top-level tree, whose leaves list objects, a subtree for each object,
and the static tree. The top-level tree comes first (Sec. 3.7); what was hit in it limits the static tree. A *placed* object
stands in coordinates of its own, and rays that enter it are brought there; t is the same in both.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from . import fp24
from .fp24 import fadd, fadd3, fdiv, fmul, fsub, ulp_add
from .rgen import inverse

HUGE = 2.0**62  # 1/0, and "no limit"
T_MIN = 2.0**-14
T_SLACK = 2.0**-9
SLACK_ULP = 16  # a hit that used the edge slack must be this much nearer than one that did not
STACK_DEPTH = 32
TRI_NONE = (1 << 24) - 1

BOX, TRAV1, TRAV2, ISECT = range(4)  # slot kinds, indices of a slot count
AT_BASE, EARLY = -1, -2  # in place of a leaf: the walk is over, its stack is empty or what lies on it is too far
TRI, SLACK, INST = range(3)  # best_i: triangle, whether it used the slack, placed object that it is in
NOT_PLACED = 0  # the triangle lies in the scene's coordinates
ROWS = 3  # slots that bring a ray into an object's coordinates
T, BETA, GAMMA = range(3)  # best_f


class TreeArrays(NamedTuple):
    """What the tracer reads, decoded from the memory image; see `decode`."""

    split: np.ndarray  # (nodes,) float64
    meta: np.ndarray  # (nodes,) int64: bits 59:24 of the node
    low: np.ndarray  # (nodes,) int64: bits 23:0, a leaf's count
    list: np.ndarray  # (entries,) int64
    accel: np.ndarray  # (triangles, 9) float64: n_u n_v a_u a_v a_k b_u b_v g_u g_v
    k: np.ndarray  # (triangles,) int64, 3 never hits
    mat: np.ndarray  # (triangles,) int64
    opaque: np.ndarray  # (triangles,) bool
    eps: np.ndarray  # (triangles,) float64
    one_eps: np.ndarray  # (triangles,) float64
    box: np.ndarray  # (2, 3) float64
    root: int
    inst_root: np.ndarray  # (instances,) int64: roots of the top-level tree [0] and of the objects; none: no such tree
    inst_box: np.ndarray  # (instances, 2, 3) float64
    inst_placed: np.ndarray  # (instances,) bool: the object has coordinates of its own
    inst_rows: np.ndarray  # (instances, 3, 6) float64: a row of the rotation into them, and the point that becomes 0
    inst_place: np.ndarray  # (instances, 3, 4) float64: rotation out of them, and where their 0 is


def decode(nodes, entries, accel_words, box, root, instances=()):
    """Decode memory words into `TreeArrays`.

    Args: nodes (n,) uint64; entries (m,) uint32; accel_words (t, 4) uint64; box (2, 3) FP24 values; root node index;
        instances (i, 32) uint64: the top-level tree and the objects, none without dynamic objects.
    """
    nodes = np.asarray(nodes, dtype=np.uint64)
    words = np.asarray(accel_words, dtype=np.uint64)
    records = np.asarray(instances, dtype=np.uint64).reshape(-1, 32)
    f24 = np.uint64(0xFFFFFF)

    def field(word, shift):
        return fp24.from_bits((words[:, word] >> np.uint64(shift)) & f24)

    def corner(word, shift):
        return fp24.from_bits((records[:, word] >> np.uint64(shift)) & f24)

    low, high = ((words[:, n] >> np.uint64(48)) & np.uint64(0xFFF) for n in (2, 3))
    b_v = fp24.from_bits(low | (high << np.uint64(12)))
    accel = np.stack(
        [field(0, 0), field(0, 24), field(1, 0), field(1, 24), field(2, 0), field(2, 24), b_v, field(3, 0), field(3, 24)],
        axis=1,
    )
    flags = (words[:, 0] >> np.uint64(48)).astype(np.int64)
    m, e = 16 + (flags & 15), (flags >> 4) & 31
    return TreeArrays(
        split=fp24.from_bits(nodes & f24),
        meta=((nodes >> np.uint64(24)) & np.uint64(0xFFFFFFFFF)).astype(np.int64),
        low=(nodes & f24).astype(np.int64),
        list=np.asarray(entries).astype(np.int64),
        accel=np.ascontiguousarray(accel),
        k=(flags >> 9) & 3,
        mat=((words[:, 1] >> np.uint64(48)) & np.uint64(0xFFF)).astype(np.int64),
        opaque=(flags >> 11) & 1 == 1,
        eps=np.ldexp(m.astype(np.float64), -12 - e),
        one_eps=1.0 + np.ceil(np.ldexp(m.astype(np.float64), 4 - e)) * 2.0**-16,
        box=np.asarray(box, dtype=np.float64),
        root=int(root),
        inst_root=(records[:, 0] & f24).astype(np.int64),
        inst_box=np.ascontiguousarray(
            np.stack([corner(0, 24), corner(1, 0), corner(1, 24), corner(2, 0), corner(2, 24), corner(3, 0)], axis=1)
        ).reshape(-1, 2, 3),
        inst_placed=(records[:, 0] >> np.uint64(48)) & np.uint64(1) == 1,
        inst_rows=np.ascontiguousarray(
            np.stack(
                [corner(w + i, shift) for w in (4, 8, 12) for i, shift in ((0, 0), (0, 24), (2, 24), (1, 0), (1, 24), (2, 0))],
                axis=1,
            )
        ).reshape(-1, 3, 6),
        inst_place=np.ascontiguousarray(
            np.stack([corner(16 + 2 * i + j // 2, 24 * (j % 2)) for i in range(3) for j in range(4)], axis=1)
        ).reshape(-1, 3, 4),
    )


@njit(cache=True, error_model="numpy")
def box_test(box, org, dir, inv_dir, t_max):
    """Ray-box mode: (hit, tmin, tmax) of the ray against a box; t_max: its nearest hit so far, at first its own limit."""
    tn = np.empty(3)
    tf = np.empty(3)
    for i in range(3):
        neg = math.copysign(1.0, dir[i]) < 0.0
        tn[i] = fmul(fsub(box[1 if neg else 0, i], org[i]), inv_dir[i])
        tf[i] = fmul(fsub(box[0 if neg else 1, i], org[i]), inv_dir[i])
    a = tn[1] if tn[0] < tn[1] else tn[0]
    b = 0.0 if tn[2] < 0.0 else tn[2]
    tmin = b if a < b else a
    a = tf[1] if tf[1] < tf[0] else tf[0]
    b = t_max if t_max < tf[2] else tf[2]
    tmax = b if b < a else a
    return tmin <= tmax, tmin, tmax


@njit(cache=True, error_model="numpy")
def intersect(a, k, eps, one_eps, org, dir):
    """Intersection mode: (inside, slack, t, beta, gamma) of a ray and a TriAccel record, before t is judged."""
    if k == 3:
        return False, False, 0.0, 0.0, 0.0
    u = 0 if k == 2 else k + 1
    v = 0 if u == 2 else u + 1
    ou, ov, ow = fsub(org[u], a[2]), fsub(org[v], a[3]), fsub(org[k], a[4])
    den = fadd3(fmul(a[0], dir[u]), fmul(a[1], dir[v]), dir[k])
    num = -fadd3(fmul(a[0], ou), fmul(a[1], ov), ow)
    t = fmul(num, fdiv(1.0, den))
    hu, hv = fadd(ou, fmul(t, dir[u])), fadd(ov, fmul(t, dir[v]))
    beta = fadd(fmul(hu, a[5]), fmul(hv, a[6]))
    gamma = fadd(fmul(hu, a[7]), fmul(hv, a[8]))
    s = fadd(beta, gamma)
    inside = den != 0.0 and beta >= -eps and gamma >= -eps and s <= one_eps
    return inside, beta < 0.0 or gamma < 0.0 or s > 1.0, t, beta, gamma


@njit(cache=True, error_model="numpy")
def _to_leaf(tree, node, tmin, tmax, org, dir, inv_dir, best, stack_node, stack_t, sp, base, slots):
    """Traversal slots until a leaf: (leaf, AT_BASE or EARLY; tmin, tmax, sp). base: where the tree's own stack begins."""
    while True:
        line = node >> 3
        steps, leaf, pop = 0, -1, False
        while True:  # up to two steps, the second only within the same 64-byte block
            steps += 1
            meta = tree.meta[node]
            axis = meta & 3
            if axis == 3:
                if tree.low[node] & 0xFFFFF == 0:
                    pop = True
                else:
                    leaf = node
                break
            o, inv = org[axis], inv_dir[axis]
            diff = fsub(tree.split[node], o)
            ts = fmul(diff, inv)
            neg = math.copysign(1.0, dir[axis]) < 0.0
            swap, lower_empty, upper_empty = (meta >> 2) & 1, (meta >> 3) & 1, (meta >> 4) & 1
            other, adjacent = (meta >> 5) & 0xFFFFFF, node + 1
            near = adjacent if (swap == 1) == neg else other
            far = other if (swap == 1) == neg else adjacent
            near_empty, far_empty = (upper_empty, lower_empty) if neg else (lower_empty, upper_empty)
            whole = diff == 0.0 and abs(inv) == HUGE
            near_only = not whole and ts > ulp_add(tmax, 1)
            far_only = not whole and ts < ulp_add(tmin, -1)
            near_max, far_min = tmax, tmin
            if not (whole or near_only or far_only):
                near_max = tmin if ts < tmin else ts
                far_min = tmax if ts > tmax else ts
            go_near = not far_only and near_empty == 0
            go_far = not near_only and far_empty == 0
            if go_near:
                if go_far:
                    if sp == STACK_DEPTH:
                        raise ValueError("the tree is deeper than the stack")
                    stack_node[sp], stack_t[sp, 0], stack_t[sp, 1] = far, far_min, tmax
                    sp += 1
                node, tmax = near, near_max
            elif go_far:
                node, tmin = far, far_min
            else:
                pop = True
            if pop or steps == 2 or node >> 3 != line:
                break
        slots[TRAV1 if steps == 1 else TRAV2] += 1
        if pop:
            if sp == base:
                return AT_BASE, tmin, tmax, sp
            if best < stack_t[sp - 1, 0]:
                return EARLY, tmin, tmax, sp
            sp -= 1
            node, tmin, tmax = stack_node[sp], stack_t[sp, 0], stack_t[sp, 1]
        elif leaf >= 0:
            return leaf, tmin, tmax, sp


@njit(cache=True, error_model="numpy")
def _of_leaf(tree, leaf):
    """A leaf's index, and whether it is that of its only triangle or object: else its list begins there."""
    return (tree.meta[leaf] >> 5) & 0xFFFFFF, tree.low[leaf] & 0xFFFFF == 1


@njit(cache=True, error_model="numpy")
def _listed(tree, index, direct):
    """The triangle or object at a leaf's index, and whether it is its last."""
    if direct:
        return index, True
    entry = tree.list[index]
    return entry & 0xFFFFFF, (entry >> 24) & 1 == 1


@njit(cache=True, error_model="numpy")
def _walk(tree, root, tmin, tmax, ray, inst, best_f, best_i, stack_node, stack_t, base, slots):
    """The nearest triangle of a tree, if nearer than the best so far: (AT_BASE or EARLY, whether it ends the ray).

    inst: the placed object whose tree it is. best_f (3,) float64 and best_i (3,) int64: the best hit so far, by T, BETA, GAMMA
    and TRI, SLACK, INST; a nearer one is stored there.
    """
    org, dir, inv_dir, t_min, skip, skip_inst, any_hit = ray
    slack_min = T_SLACK if T_SLACK > t_min else t_min
    node, sp = root, base
    while True:
        leaf, tmin, tmax, sp = _to_leaf(
            tree, node, tmin, tmax, org, dir, inv_dir, best_f[T], stack_node, stack_t, sp, base, slots
        )
        if leaf < 0:
            return leaf, False
        # ---- intersection slots, one triangle each
        index, direct = _of_leaf(tree, leaf)
        while True:
            tri, last = _listed(tree, index, direct)
            slots[ISECT] += 1
            inside, slack, t, beta, gamma = intersect(tree.accel[tri], tree.k[tri], tree.eps[tri], tree.one_eps[tri], org, dir)
            best, best_slack = best_f[T], best_i[SLACK] != 0
            if slack and not best_slack:
                nearer = ulp_add(t, SLACK_ULP) < best
            elif best_slack and not slack:
                nearer = t < ulp_add(best, SLACK_ULP)
            else:
                nearer = t < best
            skipped = tri == skip and inst == skip_inst
            if inside and not skipped and nearer and t > (slack_min if slack else t_min):
                best_f[T], best_f[BETA], best_f[GAMMA] = t, beta, gamma
                best_i[TRI], best_i[SLACK], best_i[INST] = tri, slack, inst
                if any_hit and tree.opaque[tri]:
                    return EARLY, True
            if last:
                break
            index += 1
        if sp == base:
            return AT_BASE, False
        if best_f[T] <= tmax or best_f[T] < stack_t[sp - 1, 0]:
            return EARLY, False
        sp -= 1
        node, tmin, tmax = stack_node[sp], stack_t[sp, 0], stack_t[sp, 1]


@njit(cache=True, error_model="numpy")
def into_object(rows, org, dir):
    """A ray in the coordinates of a placed object: (org, dir, inv_dir). rows (3, 6): of `TreeArrays.inst_rows`."""
    o, d, inv = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        r = rows[i]
        d[i] = fadd3(fmul(r[0], dir[0]), fmul(r[1], dir[1]), fmul(r[2], dir[2]))
        o[i] = fadd3(fmul(r[0], fsub(org[0], r[3])), fmul(r[1], fsub(org[1], r[4])), fmul(r[2], fsub(org[2], r[5])))
        inv[i] = inverse(d[i])
    return o, d, inv


@njit(cache=True, error_model="numpy")
def _walk_objects(tree, ray, best_f, best_i, stack_node, stack_t, slots):
    """The top-level tree, and the tree of each object whose box the ray meets. Returns: whether that ends the ray."""
    org, dir, inv_dir, t_min, skip, skip_inst, any_hit = ray
    slots[BOX] += 1
    hit, tmin, tmax = box_test(tree.inst_box[0], org, dir, inv_dir, best_f[T])
    if not hit:
        return False
    node, sp = tree.inst_root[0], 0
    while True:
        leaf, tmin, tmax, sp = _to_leaf(
            tree, node, tmin, tmax, org, dir, inv_dir, best_f[T], stack_node, stack_t, sp, 0, slots
        )
        if leaf < 0:
            return False
        index, direct = _of_leaf(tree, leaf)
        while True:
            thing, last = _listed(tree, index, direct)
            slots[BOX] += 1
            hit, tmin, tmax = box_test(tree.inst_box[thing], org, dir, inv_dir, best_f[T])
            if hit:
                within, inst = ray, NOT_PLACED
                if tree.inst_placed[thing]:
                    slots[BOX] += ROWS
                    o, d, inv = into_object(tree.inst_rows[thing], org, dir)
                    within, inst = (o, d, inv, t_min, skip, skip_inst, any_hit), thing
                end, over = _walk(
                    tree, tree.inst_root[thing], tmin, tmax, within, inst, best_f, best_i, stack_node, stack_t, sp, slots
                )
                if over:
                    return True
                if last and end == EARLY and sp > 0:
                    slots[BOX] += 1  # something of the object lies on the stack: a slot to read what lies below
            if last:
                break
            index += 1
        # What lies on the stack begins where this leaf ends, so the leaf's own end need not be kept.
        if sp == 0 or best_f[T] < stack_t[sp - 1, 0]:
            return False
        sp -= 1
        node, tmin, tmax = stack_node[sp], stack_t[sp, 0], stack_t[sp, 1]


@njit(cache=True, error_model="numpy")
def trace_ray(tree, org, dir, inv_dir, t_min, t_max, skip, skip_inst, any_hit, slots):
    """One ray: (triangle or TRI_NONE, t, beta, gamma, mat, opaque, inst). Adds to slots (4,) int64, by BOX, TRAV1, TRAV2, ISECT.

    org, dir, inv_dir: (3,) FP24 values. t_min: T_MIN or more; nothing nearer counts. any_hit: stop at the first hit that is
    opaque (shadow rays); of others the nearest is kept. skip, skip_inst: triangle never hit, and the placed object that it is
    in. inst: the placed object that was hit, or NOT_PLACED. mat, opaque: of the triangle's record; 0 and False if nothing was
    hit. Raises: ValueError on a tree deeper than the stack.
    """
    ray = (org, dir, inv_dir, t_min, skip, skip_inst, any_hit)
    best_f, best_i = np.array([t_max, 0.0, 0.0]), np.array([TRI_NONE, 0, NOT_PLACED])
    stack_node, stack_t = np.empty(STACK_DEPTH, dtype=np.int64), np.empty((STACK_DEPTH, 2))
    over = tree.inst_root.size > 0 and _walk_objects(tree, ray, best_f, best_i, stack_node, stack_t, slots)
    if not over:
        slots[BOX] += 1
        hit, tmin, tmax = box_test(tree.box, org, dir, inv_dir, best_f[T])
        if hit:
            _walk(tree, tree.root, tmin, tmax, ray, NOT_PLACED, best_f, best_i, stack_node, stack_t, 0, slots)
    tri, inst = best_i[TRI], best_i[INST]
    if tri == TRI_NONE:
        return tri, best_f[T], best_f[BETA], best_f[GAMMA], np.int64(0), False, inst
    return tri, best_f[T], best_f[BETA], best_f[GAMMA], tree.mat[tri], tree.opaque[tri], inst


@njit(cache=True, error_model="numpy")
def trace_rays(tree, org, dir, inv_dir, t_min, t_max, skip, skip_inst, any_hit):
    """Many rays, arrays of `trace_ray`'s arguments: (triangle, t, beta, gamma, mat, opaque, inst, slots (n, 4) int64)."""
    n = org.shape[0]
    tri = np.empty(n, dtype=np.int64)
    t, beta, gamma = np.empty(n), np.empty(n), np.empty(n)
    mat, opaque, inst = np.empty(n, np.int64), np.empty(n, np.bool_), np.empty(n, np.int64)
    slots = np.zeros((n, 4), dtype=np.int64)
    for i in range(n):
        tri[i], t[i], beta[i], gamma[i], mat[i], opaque[i], inst[i] = trace_ray(
            tree, org[i], dir[i], inv_dir[i], t_min[i], t_max[i], skip[i], skip_inst[i], any_hit[i], slots[i]
        )
    return tri, t, beta, gamma, mat, opaque, inst, slots
