# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The tree builder against brute force: costs, clipping, leaf membership, rays, layout and words."""

import itertools
import os
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from numba import njit

from raycore import kdtree, scene, triaccel
from raycore.model import fp24

SEED = int(os.environ.get("RAYCORE_SEED", "20140615"))


def fp(points):
    return fp24.round_to_fp24(np.asarray(points, dtype=np.float64)) + 0.0


def no_area(tris):
    return ~triaccel.has_area(tris)


def soup(rng, count, size):
    return fp(np.clip(rng.uniform(-1, 1, (count, 1, 3)) + rng.normal(0, size, (count, 3, 3)), -1, 1))


def grid(n, height=None):
    """2 n^2 triangles over [-1, 1]^2, z from `height(x, y)` or 0."""
    x = np.linspace(-1, 1, n + 1)
    points = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1)
    z = height(points[..., 0], points[..., 1]) if height else np.zeros(points.shape[:2])
    points = np.concatenate((points, z[..., None]), axis=2)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return fp(np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))]))


def box(lo, hi):
    """The 12 triangles of a box."""
    corners = np.array(list(itertools.product(*zip(lo, hi))))
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return fp([corners[[q[i], q[j], q[k]]] for q in quads for i, j, k in ((0, 1, 2), (0, 2, 3))])


def meshes():
    """Name and triangles of meshes that are easy to get wrong."""
    rng = np.random.default_rng(SEED)
    print(f"seed {SEED}")
    one = fp([[[-0.5, 0, 0.25], [0.5, 0.125, 0], [0, 0.75, -0.5]]])
    yield "one", one
    yield "two", np.concatenate((one, one[:, ::-1] * 0.5))
    yield "five", soup(rng, 5, 0.3)
    yield "identical", np.repeat(one, 100, axis=0)
    yield "twice", np.repeat(soup(rng, 60, 0.2), 2, axis=0)
    yield "plane", grid(12)
    yield "plane twice", np.concatenate((grid(6), grid(6)))
    yield "terrain", grid(20, lambda x, y: 0.3 * np.sin(5 * x) * np.cos(4 * y))
    yield "soup of small", soup(rng, 600, 0.03)
    yield "soup of large", soup(rng, 150, 0.7)
    yield "needles", fp(rng.uniform(-1, 1, (200, 1, 3)) + rng.normal(0, 1, (200, 3, 3)) * [0.3, 1e-3, 1e-4]).clip(-1, 1)
    yield (
        "room",
        np.concatenate((box((-1, -1, -1), (1, 1, 1)), box((-0.5, -1, -0.25), (0, 0, 0.5)), soup(rng, 40, 0.02))),
    )
    yield (
        "boxes in rows",
        np.concatenate(
            [
                box((x, y, -0.5), (x + 0.125, y + 0.125, 0.5))
                for x in np.arange(-1, 1, 0.25)
                for y in np.arange(-1, 1, 0.25)
            ]
        ),
    )
    yield "near zero", soup(rng, 100, 0.05) * 2.0**-30
    noisy = grid(8)
    noisy[..., 2] = fp(rng.normal(0, 1e-17, noisy.shape[:2]))
    yield "plane with noise", noisy
    degenerate = soup(rng, 120, 0.2)
    degenerate[::3, 2] = degenerate[::3, 1]
    degenerate[1::9, 1:] = degenerate[1::9, :1]
    yield "zero area", degenerate
    yield "floor", np.concatenate((grid(8, lambda x, y: 0.0 * x - 1.0), soup(rng, 30, 0.05) * (0.5, 0.5, 0.25)))


MESHES = dict(meshes())


@njit(cache=True)
def cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(cache=True)
def moeller(tri, org, inv):
    """Moeller and Trumbore 1997, both sides."""
    dx, dy, dz = 1.0 / inv[0], 1.0 / inv[1], 1.0 / inv[2]
    ax, ay, az = tri[0, 0], tri[0, 1], tri[0, 2]
    e1x, e1y, e1z = tri[1, 0] - ax, tri[1, 1] - ay, tri[1, 2] - az
    e2x, e2y, e2z = tri[2, 0] - ax, tri[2, 1] - ay, tri[2, 2] - az
    sx, sy, sz = org[0] - ax, org[1] - ay, org[2] - az
    px, py, pz = cross(dx, dy, dz, e2x, e2y, e2z)
    det = e1x * px + e1y * py + e1z * pz
    if det == 0.0:
        return False, 0.0
    qx, qy, qz = cross(sx, sy, sz, e1x, e1y, e1z)
    u = (sx * px + sy * py + sz * pz) / det
    v = (dx * qx + dy * qy + dz * qz) / det
    t = (e2x * qx + e2y * qy + e2z * qz) / det
    return u >= 0.0 and v >= 0.0 and u + v <= 1.0 and t > 0.0, t


@njit(cache=True)
def trace(nodes, lists, root, lo, hi, tris, org, inv):
    """Nearest hit of one ray (tri, t) by the tree alone, in double precision; every overlap of intervals is widened."""
    t0, t1 = 0.0, np.inf
    for a in range(3):
        x, y = (lo[a] - 1e-6 - org[a]) * inv[a], (hi[a] + 1e-6 - org[a]) * inv[a]
        t0, t1 = max(t0, min(x, y)), min(t1, max(x, y))
    stack = np.empty((64, 3))
    top = 0
    best, best_t = -1, np.inf
    if t0 > t1:
        return best, best_t
    stack[0, 0], stack[0, 1], stack[0, 2] = root, t0, t1
    top = 1
    while top > 0:
        top -= 1
        node = np.int64(stack[top, 0])
        t0, t1 = stack[top, 1], stack[top, 2]
        word = np.int64(nodes[node])
        axis = (word >> 24) & 3
        ref = (word >> 29) & 0xFFFFFF
        if axis == 3:
            count = word & 0xFFFFF
            for i in range(count):
                tri = ref if count == 1 else np.int64(lists[ref + i]) & 0xFFFFFF
                hit, t = moeller(tris[tri], org, inv)
                if hit and (t < best_t or (t == best_t and tri < best)):
                    best, best_t = tri, t
            continue
        bits = word & 0xFFFFFF
        plane = 0.0
        if bits & 0x7FFFFF:
            plane = (1.0 + (bits & 0xFFFF) / 65536.0) * 2.0 ** (((bits >> 16) & 127) - 63)
            if bits >> 23:
                plane = -plane
        swap, no_lower, no_upper = (word >> 26) & 1, (word >> 27) & 1, (word >> 28) & 1
        lower = ref if swap else node + 1
        upper = node + 1 if swap else ref
        ts = (plane - org[axis]) * inv[axis]
        slack = 1e-9 + 1e-9 * abs(ts)
        near_lower = inv[axis] > 0
        for far in range(1, -1, -1):  # far first on the stack
            is_lower = near_lower == (far == 0)
            if (is_lower and no_lower) or (not is_lower and no_upper):
                continue
            if far == 1 and ts > t1 + slack:
                continue
            if far == 0 and ts < t0 - slack:
                continue
            stack[top, 0] = lower if is_lower else upper
            stack[top, 1] = max(t0, ts - slack) if far == 1 else t0
            stack[top, 2] = t1 if far == 1 else min(t1, ts + slack)
            top += 1
    return best, best_t


@njit(cache=True)
def trace_all(tris, use, org, inv):
    """Nearest hit of one ray by trying every triangle."""
    best, best_t = -1, np.inf
    for i in range(tris.shape[0]):
        if use[i]:
            hit, t = moeller(tris[i], org, inv)
            if hit and t < best_t:
                best, best_t = i, t
    return best, best_t


def rays(rng, tris, count):
    """Rays from all round at random points of triangles, some along the axes, some between grid points."""
    pick = rng.integers(0, len(tris), count)
    w = rng.dirichlet((1, 1, 1), count)
    aim = (tris[pick] * w[:, :, None]).sum(axis=1)
    direction = rng.normal(0, 1, (count, 3))
    direction[::5] = np.sign(direction[::5]) * np.eye(3)[rng.integers(0, 3, len(direction[::5]))] + 1e-13
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return aim - direction * rng.uniform(0.01, 3, (count, 1)), direction


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("max_leaf", [1, 2, 8])
def test_rays_agree_with_brute_force(name, max_leaf):
    """The nearest hit through the tree is the nearest of all triangles, for rays from anywhere."""
    tris, rng = MESHES[name], np.random.default_rng(SEED + 1)
    dropped = no_area(tris)
    tree = kdtree.build(tris, dropped, kdtree.Params(max_leaf=max_leaf))
    scale = np.abs(tris).max()
    org, direction = rays(rng, tris / scale, 300)
    for o, d in zip(org * scale, direction):
        with np.errstate(divide="ignore"):
            inv = 1.0 / d
        want, want_t = trace_all(tris, ~dropped, o, inv)
        got, got_t = trace(tree.nodes, tree.lists, tree.root, *tree.bounds, tris, o, inv)
        assert got_t == want_t, f"{name}: ray {o} {d} found triangle {got} at {got_t}, not {want} at {want_t}"


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("clip", [True, False])
def test_leaves_hold_every_point(name, clip):
    """A point of a triangle lies in the closed box of a leaf that lists it, and every leaf it lies well inside does."""
    tris, rng = MESHES[name], np.random.default_rng(SEED + 2)
    dropped = no_area(tris)
    tree = kdtree.build(tris, dropped, kdtree.Params(clip=clip))
    w = kdtree.walk(tree)
    boxes = np.concatenate((w.box[w.leaf_rows], w.empty))
    holds = np.zeros((len(boxes), len(tris)), bool)
    for i, (_, members) in enumerate(w.leaves):
        assert np.all(np.diff(members) > 0), "lists ascend"
        holds[i, members] = True
    assert not holds[:, dropped].any()
    weights = np.concatenate((np.eye(3), np.full((1, 3), 1 / 3), rng.dirichlet((0.4, 0.4, 0.4), 40)))
    scale = np.abs(tris).max()
    for t in np.flatnonzero(~dropped):
        points = weights @ tris[t]
        margin = 1e-9 * scale
        closed = np.all((points[:, None] >= boxes[:, 0] - margin) & (points[:, None] <= boxes[:, 1] + margin), axis=2)
        inside = np.all((points[:, None] > boxes[:, 0] + margin) & (points[:, None] < boxes[:, 1] - margin), axis=2)
        assert (closed & holds[:, t]).any(axis=1).all()
        assert not (inside & ~holds[:, t]).any()


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("max_depth", [32, 5])
def test_words_and_limits(name, max_depth):
    """Decoding the words finds a well-formed tree within its limits, whose cost is what the builder says."""
    tris = MESHES[name]
    dropped = no_area(tris)
    tree = kdtree.build(tris, dropped, kdtree.Params(max_depth=max_depth))
    w = kdtree.walk(tree)
    assert w.depth.max() <= max_depth and kdtree.stack_depth(tree) <= max_depth
    assert tree.stats["depth"] >= w.depth.max()
    assert tree.stats["leaf_count"] == len(w.leaves) and tree.stats["empty_leaf_count"] == len(w.empty)
    assert tree.stats["node_count"] == len(w.index) == len(tree.nodes) - tree.stats["padding"]
    assert kdtree.sah_cost(tree) == pytest.approx(tree.stats["sah_cost"], rel=1e-9)
    listed = np.unique(w.members)
    assert np.array_equal(listed, np.flatnonzero(~dropped))
    assert tree.lists.size == (sizes := np.diff(w.leaf_begin))[sizes > 1].sum()
    assert not (tree.lists >> np.uint32(26)).any() and (tree.lists >> np.uint32(25) & 1).all()
    padding = np.delete(tree.nodes, w.index)
    assert (padding == 3 << 24).all(), "a spare slot reads as a leaf without triangles"


def root_planes(tris, p):
    """Cost (unnormalised) of each vertex coordinate as plane of the whole box: {(axis, plane): cost}, and of a leaf."""
    lo, hi = tris.min(axis=(0, 1)), tris.max(axis=(0, 1))
    t_lo, t_hi = tris.min(axis=1), tris.max(axis=1)

    def half_area(s):
        return s[0] * s[1] + s[1] * s[2] + s[2] * s[0]

    costs = {}
    for axis in range(3):
        for plane in np.unique(tris[..., axis]):
            flat = ((t_lo[:, axis] == plane) & (t_hi[:, axis] == plane)).sum()
            left, right = (t_lo[:, axis] < plane).sum(), (t_hi[:, axis] > plane).sum()
            sides = [(left + flat, right), (left, right + flat)]
            if plane == lo[axis]:  # a flat child of planar triangles alone, if others remain
                sides = [(flat, right)] if flat and right else []
            elif plane == hi[axis]:
                sides = [(left, flat)] if flat and left else []
            lower, upper = hi - lo, hi - lo
            lower[axis], upper[axis] = plane - lo[axis], hi[axis] - plane
            for nl, nr in sides:
                cost = p.cost_traverse * half_area(hi - lo)
                cost += p.cost_intersect * (half_area(lower) * nl + half_area(upper) * nr)
                cost *= p.empty_bonus if nl == 0 or nr == 0 else 1.0
                costs[axis, plane] = min(cost, costs.get((axis, plane), np.inf))
    return costs, p.cost_intersect * len(tris) * half_area(hi - lo)


@pytest.mark.parametrize("name", MESHES)
def test_root_plane_is_the_cheapest(name):
    """The root's plane costs what exhaustive search finds; a root that is a leaf has no cheaper plane."""
    tris = MESHES[name][~no_area(MESHES[name])]
    p = kdtree.Params(max_leaf=1)
    w = kdtree.walk(kdtree.build(tris, None, p))
    costs, leaf = root_planes(tris, p)
    cheapest = min(costs.values(), default=np.inf)
    if w.axis[0] == 3:
        assert len(tris) == 1 or cheapest >= leaf
    else:
        assert costs[w.axis[0], w.split[0]] == pytest.approx(cheapest, rel=1e-12) and cheapest < leaf


def planes_of(bounds, lo, hi, p):
    """Every choice at a node in rational arithmetic: [(cost, axis or 3: leaf, plane, planar triangles go to the left)]."""
    low, high = (np.array([b[k] for b in bounds.values()]) for k in (0, 1))
    lo_, size = [Fraction(float(x)) for x in lo], [Fraction(float(h)) - Fraction(float(l)) for l, h in zip(lo, hi)]
    traverse, intersect, bonus = (Fraction(x) for x in (p.cost_traverse, p.cost_intersect, p.empty_bonus))
    whole = size[0] * size[1] + size[1] * size[2] + size[2] * size[0]
    out = [(intersect * len(bounds) * whole, 3, 0.0, True)]
    for axis in range(3):
        u, v = size[(axis + 1) % 3], size[(axis + 2) % 3]
        for plane in np.unique(np.concatenate((low[:, axis], high[:, axis]))):
            flat = int(np.count_nonzero((low[:, axis] == plane) & (high[:, axis] == plane)))
            left, right = int(np.count_nonzero(low[:, axis] < plane)), int(np.count_nonzero(high[:, axis] > plane))
            sides = [(left + flat, right, True), (left, right + flat, False)][: 2 if flat else 1]
            if plane == lo[axis] or plane == hi[axis]:
                keep = plane == lo[axis]
                useful = flat and (right if keep else left) and lo[axis] < hi[axis]
                sides = [s for s in sides if s[2] == keep] if useful else []
            at = Fraction(float(plane)) - lo_[axis]
            for nl, nr, to_left in sides:
                cost = (u * v + (u + v) * at) * nl + (u * v + (u + v) * (size[axis] - at)) * nr
                cost = (traverse * whole + intersect * cost) * (bonus if nl == 0 or nr == 0 else 1)
                out.append((cost, axis, float(plane), to_left))
    return out


def naive_build(tris, bounds, lo, hi, depth, p, took, leaves):
    """The same tree in the plainest way: every plane of every node anew, no event lists, exact costs.

    Where several planes cost the same, as far as double precision can tell, it takes the one that the builder took: rounding
    decides there. A triangle on both sides of a plane is clipped by `kdtree._clip`, which has a test of its own, or cut.

    Args: bounds {triangle: (2, 3) what it occupies of the node}; took {(depth, *lo, *hi): axis and plane of the builder's node};
        leaves of the builder.
    Returns: {(lo, hi, triangles)} of the leaves.
    """
    if not bounds:
        return set()
    leaf = {(tuple(lo), tuple(hi), tuple(sorted(bounds)))}
    if len(bounds) <= p.max_leaf or depth == p.max_depth:
        return leaf
    choices = planes_of(bounds, lo, hi, p)
    limit = min(choices)[0] * (1 + Fraction(1, 1 << 45))
    wanted = took.get((depth, *lo, *hi))
    tied = [c[1:] for c in choices if c[0] <= limit and c[1:3] == wanted]
    if not tied:
        return {("builder", wanted, "cheapest", min(choices)[1:], depth, tuple(lo), tuple(hi))}
    poly = np.empty((2, 12, 3))
    for axis, plane, to_left in tied:  # planar triangles may cost the same on either side
        if axis == 3:
            return leaf
        halves, boxes = ({}, {}), np.array(((lo, hi), (lo, hi)))
        boxes[0, 1, axis] = boxes[1, 0, axis] = plane
        for i, b in bounds.items():
            if b[0, axis] == plane == b[1, axis]:
                halves[0 if to_left else 1][i] = b
            elif b[1, axis] <= plane:
                halves[0][i] = b
            elif b[0, axis] >= plane:
                halves[1][i] = b
            else:
                out = np.empty((2, 2, 3))
                inside = [p.clip and kdtree._clip(tris, i, *boxes[k], kdtree._CLIP_SLACK, poly, out[k]) for k in (0, 1)]
                for k in (0, 1):
                    if not any(inside):
                        out[k] = np.clip((tris[i].min(axis=0), tris[i].max(axis=0)), *boxes[k])
                    if inside[k] or not any(inside):
                        halves[k][i] = out[k]
        found = set().union(*(naive_build(tris, halves[k], *boxes[k], depth + 1, p, took, leaves) for k in (0, 1)))
        if found <= leaves:
            break
    return found


@pytest.mark.parametrize("name", ["five", "twice", "plane", "needles", "room", "boxes in rows", "zero area", "floor"])
@pytest.mark.parametrize("clip", [True, False])
def test_whole_tree_is_that_of_a_naive_builder(name, clip):
    """Leaf by leaf the tree of a builder that searches every node from scratch; every plane is the cheapest, exactly."""
    tris = MESHES[name][~no_area(MESHES[name])]
    p = kdtree.Params(clip=clip, max_depth=9)
    w = kdtree.walk(kdtree.build(tris, None, p))
    got = {(tuple(w.box[row, 0]), tuple(w.box[row, 1]), tuple(members.tolist())) for row, members in w.leaves}
    took = {
        (w.depth[row], *w.box[row].reshape(-1)): (int(w.axis[row]), float(w.split[row])) for row in range(len(w.axis))
    }
    bounds = {i: np.stack((t.min(axis=0), t.max(axis=0))) for i, t in enumerate(tris)}
    assert naive_build(tris, bounds, tris.min(axis=(0, 1)), tris.max(axis=(0, 1)), 0, p, took, got) == got


def exact_clip(tri, lo, hi):
    """Bounds of a triangle in a box in rational arithmetic, or None."""
    poly = [[Fraction(float(c)) for c in v] for v in tri]
    for a, (bound, sign) in itertools.product(range(3), ((lo, 1), (hi, -1))):
        plane, out = Fraction(float(bound[a])), []
        for p, q in zip(poly, poly[1:] + poly[:1]):
            dp, dq = sign * (p[a] - plane), sign * (q[a] - plane)
            if dp >= 0:
                out.append(p)
            if dp * dq < 0:
                out.append([x + dp / (dp - dq) * (y - x) for x, y in zip(p, q)])
        poly = out
        if not poly:
            return None
    return [[f(v[a] for v in poly) for a in range(3)] for f in (min, max)]


def test_clipping_against_rational_arithmetic():
    """Clipped bounds enclose the exact ones, lie on the FP24 grid and are at most one step of it too large."""
    rng = np.random.default_rng(SEED + 3)
    poly, out = np.empty((2, 12, 3)), np.empty((2, 3))
    clipped = 0
    for i in range(1500):
        tri = soup(rng, 1, (0.6, 0.05, 0.005)[i % 3])[0]
        if i % 4 == 0:
            tri[:, i % 3] = tri[0, i % 3]  # parallel to a face
        a, b = fp(rng.uniform(tri.min(axis=0), tri.max(axis=0))), fp(rng.uniform(tri.min(axis=0), tri.max(axis=0)))
        lo, hi = np.minimum(a, b), np.maximum(a, b)
        got = kdtree._clip(tri[None], 0, lo, hi, kdtree._CLIP_SLACK, poly, out)
        want = exact_clip(tri, lo, hi)
        if want is None:
            continue
        assert got
        clipped += 1
        assert np.array_equal(out, fp(out)) and np.all(out[0] >= lo) and np.all(out[1] <= hi)
        for a in range(3):
            assert Fraction(out[0, a]) <= want[0][a] and Fraction(out[1, a]) >= want[1][a]
            step = 2.0**-16 * max(abs(out[0, a]), abs(out[1, a]))
            slack = 1e-8 if i % 3 == 0 else 1e-6  # the enlarged box, seen along a grazing triangle
            assert float(want[0][a]) - out[0, a] <= step + slack and out[1, a] - float(want[1][a]) <= step + slack
    assert clipped > 500


def test_word_by_hand():
    """Two triangles apart in x, one in a corner of the other half: every field of the words, worked out by hand."""
    near = [[-1, -1, -1], [-0.5, -1, -1], [-1, -0.5, -0.5]]  # x in [-1, -0.5]
    far = [[0.5, -1, -1], [1, 1, 1], [0.5, 1, 1]]  # x in [0.5, 1]
    tree = kdtree.build(fp([near, far]), None, kdtree.Params(max_leaf=1, layout="dfs"))
    # Half areas: box 12; a plane at x = -0.5 cuts 0.5 of 2 off: 4 + 4 * 0.5 = 6 and 4 + 4 * 1.5 = 10, one triangle
    # each: 12 + 1.5 * 16 = 36, the same at 0.5; a leaf costs 36 as well, so no plane is cheaper and the root stays a
    # leaf.
    assert list(tree.nodes) == [3 << 24 | 2]
    assert list(tree.lists) == [1 << 25 | 0, 1 << 25 | 1 << 24 | 1]
    # Cheaper traversal: planes x = -0.5 and x = 0.5 tie, the lower one is met first. Lower child (6) is the leaf of
    # triangle 0; the upper one (10) is larger, hence adjacent (swap) and cut again: x = 0.5 leaves its lower part
    # empty.
    tree = kdtree.build(fp([near, far]), None, kdtree.Params(cost_traverse=0.1, max_leaf=0, layout="dfs"))
    minus_half, half = 0x800000 | 62 << 16, 62 << 16
    assert int(tree.nodes[0]) & 0x1FFFFFFF == 1 << 26 | 0 << 24 | minus_half
    assert int(tree.nodes[1]) & 0xFFFFFF == half and int(tree.nodes[1]) >> 24 & 3 == 0
    assert int(tree.nodes[1]) >> 26 & 7 == 0b011, "adjacent is the upper child, the lower is empty"
    assert int(tree.nodes[1]) >> 29 == 0
    other = int(tree.nodes[0]) >> 29
    w = kdtree.walk(tree)
    assert dict(zip(w.index, w.axis))[other] < 3 or int(tree.nodes[other]) == 3 << 24 | 1 | 0 << 29
    assert {int(m[0]) for _, m in w.leaves} == {0, 1} and all(m.size == 1 for _, m in w.leaves)
    assert tree.lists.size == 0, "single triangles stand in their leaf"


@pytest.mark.parametrize("name", ["terrain", "room", "soup of large"])
def test_layouts_hold_the_same_tree(name):
    """Layouts move nodes about and change nothing else; "pack" keeps more children in their parent's line, if there are many."""
    tris = MESHES[name]
    shapes, near = [], []
    for layout in ("dfs", "lines", "pack"):
        tree = kdtree.build(tris, no_area(tris), kdtree.Params(layout=layout))
        w = kdtree.walk(tree)
        shapes.append(sorted((tuple(w.box[row].ravel()), tuple(members)) for row, members in w.leaves))
        near.append(tree.stats["children_in_line"])
        if layout == "dfs":
            assert tree.stats["padding"] == 0
    assert shapes[0] == shapes[1] == shapes[2]
    assert near[0] < near[2] or name != "terrain"


def test_deterministic():
    """Two builds give the same words."""
    tris = MESHES["soup of large"]
    a, b = kdtree.build(tris), kdtree.build(tris.copy())
    assert np.array_equal(a.nodes, b.nodes) and np.array_equal(a.lists, b.lists)


def test_flat_cells_take_walls_away():
    """A floor on the face of the box goes into a cell of no thickness, which makes rays above it cheaper."""
    tris = np.concatenate((box((-1, -1, -1), (1, 1, 1)), soup(np.random.default_rng(SEED), 200, 0.05)))
    with_flat = kdtree.build(tris, None, kdtree.Params())
    without = kdtree.build(tris, None, kdtree.Params(flat_cells=False))
    size = np.ptp(kdtree.walk(with_flat).box, axis=1)
    assert (size == 0.0).any() and with_flat.stats["sah_cost"] < without.stats["sah_cost"]


def test_flat_cells_need_others():
    """A plane on the node's face is a candidate only if it parts planar triangles from others."""
    lo, hi = -np.ones(3), np.ones(3)
    floor = [kdtree._event(kdtree._key(-1.0), kdtree._PLANAR, i) for i in range(5)]
    ball = [kdtree._event(kdtree._key(z), kind, 5) for z, kind in ((-1.0, kdtree._START), (1.0, kdtree._END))]
    for events, n, found in ((floor, 5, False), (floor + ball, 6, True), (ball, 1, False)):
        best = np.array([1e9, -1.0, 0.0, 0.0])
        kdtree._sweep(np.array(sorted(events)), 0, len(events), 2, n, lo, hi, 1.0, 1.5, 0.9, True, best)
        assert (best[1] == 2.0) == found
        # Half area 12, flat child 4 with five triangles, the rest 12 with one.
        assert not found or (best[0] == 12.0 + 1.5 * (4.0 * 5 + 12.0 * 1) and best[3] == 0.0)


def test_clipping_pays():
    """Long triangles across the grain: clipped boxes give a cheaper tree."""
    soups = [soup(np.random.default_rng(SEED + i), 150, 0.7) for i in range(8)]  # a single one may have no good plane

    def cost(clip):
        return sum(kdtree.build(s, None, kdtree.Params(clip=clip)).stats["sah_cost"] for s in soups)

    assert cost(clip=True) < 0.98 * cost(clip=False)


def test_nothing_to_build():
    """No triangle, or none with an area: one leaf without triangles."""
    for tris, mask in ((np.zeros((0, 3, 3)), None), (np.zeros((3, 3, 3)), np.ones(3, bool))):
        tree = kdtree.build(tris, mask)
        assert list(tree.nodes) == [3 << 24] and tree.lists.size == 0 and tree.root == 0


def test_refuses_what_is_not_fp24():
    """Vertices off the grid or outside [-1, 1] would make tree and records disagree."""
    for bad in (1.0 / 3.0, 1.5, np.nan):
        tris = MESHES["one"].copy()
        tris[0, 0, 0] = bad
        with pytest.raises(ValueError, match="FP24"):
            kdtree.build(tris)


FOLDER = os.environ.get("RAYCORE_SCENES")


@pytest.mark.skipif(not FOLDER, reason="RAYCORE_SCENES names no folder of meshes")
@pytest.mark.parametrize(
    "name", ["teapot.obj", "CornellBox-Sphere.obj", "stanford_bunny.obj", "sibenik.ply", "conference.ply"]
)
def test_real_meshes(name):
    """Real meshes: under a minute, well formed, and Embree's agreement with rays through the tree."""
    path = Path(FOLDER) / name
    if not path.exists():
        pytest.skip(f"no {name} there")
    unit = scene.normalise(scene.load_scene(path))
    tree = kdtree.build(unit.triangles, unit.dropped)
    assert tree.stats["build_seconds"] + tree.stats["layout_seconds"] < 60
    w = kdtree.walk(tree)
    listed = np.unique(w.members)
    assert np.array_equal(listed, np.flatnonzero(~unit.dropped)) and w.depth.max() <= 32
    assert kdtree.sah_cost(tree) == pytest.approx(tree.stats["sah_cost"], rel=1e-9)
    rng = np.random.default_rng(SEED)
    org, direction = rays(rng, unit.triangles[~unit.dropped], 100)
    wrong = 0
    for o, d in zip(org, direction):
        want = trace_all(unit.triangles, ~unit.dropped, o, 1.0 / d)[1]
        wrong += want != trace(tree.nodes, tree.lists, tree.root, *tree.bounds, unit.triangles, o, 1.0 / d)[1]
    assert wrong == 0
