# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The model of the tree builder against a naive builder that takes every rule from its definition, and against the host's."""

import os

import numpy as np
import pytest

from raycore import kdtree, tbu
from raycore.model import fp24
from raycore.model import tbu as model
from raycore.model.tbu_memory import JUMP, compare, emit, pack_refs, sah_cost, unpack_refs, walk_memory

SEED = int(os.environ.get("RAYCORE_SEED", "20140615"))
MIDDLE, TOP = 1 << 17, (1 << 18) - 1


# ---- meshes: (N, 3, 3) coordinates q -----------------------------------------------------------------------------------


def soup(rng, count, size, lo=1, hi=TOP):
    centre = rng.integers(lo, hi + 1, (count, 1, 3))
    return np.clip(centre + np.rint(rng.normal(0, size, (count, 3, 3))).astype(int), lo, hi)


def grid(n, step, height):
    x, y = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    points = np.stack((1000 + step * x, 1000 + step * y, height(x, y)), axis=2)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])


def meshes():
    rng = np.random.default_rng(SEED)
    print(f"seed {SEED}")
    one = np.array([[[MIDDLE - 900, MIDDLE, MIDDLE + 5], [MIDDLE + 700, MIDDLE + 3, MIDDLE], [MIDDLE, TOP, 1]]])
    yield "none", np.zeros((0, 3, 3), int)
    yield "one", one
    yield "two", np.concatenate((one, one[:, ::-1] // 2 + 1))
    yield "five", soup(rng, 5, 30000)
    yield "five of one plane", soup(rng, 5, 30000) * (1, 1, 0) + (0, 0, 77)
    yield "identical", np.repeat(one, 60, axis=0)
    yield "points", np.repeat(rng.integers(1, TOP + 1, (60, 1, 3)), 3, axis=1)
    yield "points in a line", np.repeat(rng.integers(1, 40, (60, 1, 1)) * [[[1, 0, 0]]] + [[[0, 5, 5]]], 3, axis=1)
    yield "one point", np.full((30, 3, 3), MIDDLE)
    yield "coplanar", soup(rng, 80, 20000) * (1, 1, 0) + (0, 0, MIDDLE)
    yield (
        "needles",
        np.clip(soup(rng, 80, 1) + np.rint(rng.normal(0, 1, (80, 3, 3)) * [60000, 9, 2]).astype(int), 1, TOP),
    )
    yield "terrain", grid(7, 9001, lambda x, y: 90000 + 5000 * ((3 * x + 5 * y) % 7))
    yield "plane", grid(6, 16384, lambda x, y: 0 * x + 4096)
    yield "few values", rng.integers(1, 6, (90, 3, 3)) * 1024  # every rule for ties
    yield "fewer values", rng.integers(MIDDLE, MIDDLE + 3, (60, 3, 3))
    yield "small box", rng.integers(5000, 5040, (80, 3, 3))  # bins of one and two units
    yield "flat box", soup(rng, 80, 9000) % (TOP, TOP, 3) + 1
    yield (
        "corners",
        np.array([[[1, 1, 1], [TOP, 1, 1], [1, TOP, TOP]]] * 3 + [[[TOP] * 3] * 3] * 4 + [[[1] * 3] * 3] * 4),
    )
    yield "whole range", soup(rng, 100, 6000)
    yield "clusters", np.concatenate((soup(rng, 60, 3, 800, 900), soup(rng, 60, 20000), soup(rng, 30, 4000)))
    faces = soup(rng, 60, 12000, 20000, 90000)
    floor = grid(5, 14000, lambda x, y: 0 * x + 20000)
    yield "floor", np.concatenate((floor, faces))
    yield "wall", np.concatenate((floor[..., [2, 0, 1]] * (1, 1, 1) + (70000, 0, 0), np.minimum(faces, 90000)))


MESHES = dict(meshes())


def refs_of(mesh, opaque=None):
    return model.refs_from_vertices(model.fp24_from_fixed(mesh), opaque)


# ---- the naive builder -------------------------------------------------------------------------------------------------


def parts(refs, box):
    """[(lo', hi')] of the references, tuples of three."""
    return [
        (
            tuple(max(int(refs.lo[i, a]), box[0][a]) for a in range(3)),
            tuple(min(int(refs.hi[i, a]), box[1][a]) for a in range(3)),
        )
        for i in range(len(refs))
    ]


def half(box):
    x, y, z = (box[1][a] - box[0][a] for a in range(3))
    return x * y + x * z + y * z


def cut(box, axis, p):
    below, above = [list(box[0]), list(box[1])], [list(box[0]), list(box[1])]
    below[1][axis] = above[0][axis] = p
    return below, above


def who(part, axis, p, pl):
    """Numbers of those that go to the lower and to the upper child."""
    lower, upper = [], []
    for i, (lo, hi) in enumerate(part):
        planar = lo[axis] == hi[axis] == p
        if lo[axis] < p or (planar and pl == 0):
            lower.append(i)
        if hi[axis] > p or (planar and pl == 1):
            upper.append(i)
    return lower, upper


def price(part, box, axis, p, pl):
    (lower, upper), (below, above) = who(part, axis, p, pl), cut(box, axis, p)
    cost = 2 * half(box) + 3 * (half(below) * len(lower) + half(above) * len(upper))
    return (7 if not lower or not upper else 8) * cost


def all_planes(part, box):
    for axis in range(3):
        first, last = box[0][axis], box[1][axis]
        planar = {p: sum(lo[axis] == hi[axis] == p for lo, hi in part) for p in (first, last)}
        for p in {v[axis] for pair in part for v in pair}:
            if first < p < last:
                yield axis, p, 0
                yield axis, p, 1
            elif first < last and 0 < planar[p] < len(part):
                yield axis, p, 0 if p == first else 1


def best_of(part, box, planes):
    return min(((price(part, box, *plane), *plane) for plane in planes), default=None)


def coarse_planes(box, axis):
    w, s = box[1][axis] - box[0][axis], 0
    while w / 2**s > 32:
        s += 1
    return s, [(axis, p, 1) for p in range(box[0][axis] + 2**s, box[1][axis], 2**s)]


def bin_planes(part, box, refine):
    for axis in range(3):
        s, planes = coarse_planes(box, axis)
        if refine and planes:
            middle = best_of(part, box, planes)[2]
            step, start = max(1, 2**s // 32), middle - 2**s
            planes = [
                (axis, start + i * step, 1) for i in range(1, 64) if box[0][axis] < start + i * step < box[1][axis]
            ]
        yield from planes


def naive(refs, box, cap, refine_max, level=0):
    """(axis, p, lower, upper, swap) of an inner node, children None if empty; (triangles,) of a leaf."""
    part, n = parts(refs, box), len(refs)
    best = None
    if n > 4 and level < 32:
        planes = all_planes(part, box) if n <= cap else bin_planes(part, box, n <= refine_max)
        best = best_of(part, box, planes)
    if best is None or best[0] >= 24 * n * half(box):
        return (refs.tri.tolist(),)
    _, axis, p, pl = best
    (lower, upper), (below, above) = who(part, axis, p, pl), cut(box, axis, p)
    children = [
        naive(refs[rows], inside, cap, refine_max, level + 1) if rows else None
        for rows, inside in ((lower, below), (upper, above))
    ]
    swap = not lower or (bool(upper) and half(above) > half(below))
    return axis, p, *children, swap


def as_tuples(tree, row=0):
    if row < 0:
        return None
    if tree.kind[row] == model.LEAF:
        return (tree.leaf(row),)
    children = [as_tuples(tree, int(child[row])) for child in (tree.lower, tree.upper)]
    return int(tree.kind[row]), int(tree.plane[row]), *children, bool(tree.swap[row])


# ---- trees -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MESHES)
def test_is_the_naive_tree(name):
    """Exact, binned, and binned with a second look for some or all nodes."""
    refs = refs_of(MESHES[name])
    for cap, refine_max in ((model.NO_CAP, 0), (16, 0), (16, 50), (5, 1000)):
        tree = model.build(refs, cap=cap, refine_max=refine_max)
        assert as_tuples(tree) == naive(refs, refs.box.tolist(), cap, refine_max), (cap, refine_max)


@pytest.mark.parametrize("name", [n for n in MESHES if n != "none"])
def test_is_the_hosts_tree_without_clipping(name):
    """With no bins the rules are those of the host's builder: its tree must be the same, node by node."""
    mesh = MESHES[name]
    refs, params = refs_of(mesh), kdtree.Params(empty_bonus=7 / 8, max_leaf=4, clip=False, layout="dfs")
    host = kdtree.build((mesh - MIDDLE) * 2.0**-17, None, params)
    tree = model.build(refs, cap=model.NO_CAP)
    assert compare(tree, walk_memory(host.nodes, host.lists, host.root, refs.box)) is None
    assert sah_cost(tree) == pytest.approx(host.stats["sah_cost"], rel=1e-9)


@pytest.mark.parametrize("name", MESHES)
def test_nothing_is_lost(name):
    """Every point of a triangle's box lies in the closed box of a leaf that lists it; lists ascend; counts agree."""
    refs = refs_of(MESHES[name])
    for cap in (model.NO_CAP, 16):
        tree = model.build(refs, cap=cap, refine_max=40)
        leaves = np.flatnonzero(tree.kind == model.LEAF)
        assert tree.count[leaves].sum() == len(tree.members)
        assert tree.level.max() <= 32
        for row in leaves:
            leaf = tree.leaf(row)
            assert leaf == sorted(set(leaf))
            assert len(leaf) > 0 or row == 0
            touches = np.all((refs.lo[leaf] <= tree.box[row, 1]) & (refs.hi[leaf] >= tree.box[row, 0]), axis=1)
            assert touches.all()
        rng = np.random.default_rng(SEED)
        owner = np.repeat(leaves, tree.count[leaves])
        for tri in range(len(refs)):
            boxes = tree.box[owner[tree.members == tri]]
            points = rng.integers(refs.lo[tri], refs.hi[tri] + 1, (20, 3))
            points = np.concatenate((points, refs.lo[tri : tri + 1], refs.hi[tri : tri + 1]))
            inside = np.all((boxes[:, None, 0] <= points) & (points <= boxes[:, None, 1]), axis=2)
            assert inside.any(axis=0).all(), tri


def test_deep():
    """No node lies deeper than 32 inner nodes, whoever builds it."""
    x = np.array([max(1, TOP >> i // 2) for i in range(120)])
    mesh = np.repeat(np.stack((x, x[::-1], np.arange(1, 121)), axis=1)[:, None], 3, axis=1)
    mesh[:, 1] += (0, 0, 900)
    for cap in (model.NO_CAP, 16):
        refs = refs_of(mesh)
        for start in (0, 28, 31, 32):
            tree = model.sort_subtree(refs, refs.box, start)
            assert tree.level.max() <= 32
            assert tree.level.min() == start
        shallow = model.build(refs, cap=cap, max_depth=3)
        assert shallow.level.max() == 3
        assert shallow.count.max() > 4


def test_large_numbers():
    """Costs of the largest node there can be do not wrap: half a million references over the whole range."""
    n = model.MAX_TRIANGLES
    lo = np.ones((n, 3), np.int64)
    hi = np.full((n, 3), TOP)
    hi[: n // 2, 0] = lo[n // 2 :, 0] = MIDDLE
    refs = model.Refs(lo, hi, np.arange(n), np.ones(n, bool))
    box = refs.box
    for plane in (model.sorted_plane(refs, box), model.binned_plane(refs, box, False)):
        l, w, n_lower, n_upper = plane.p - 1, TOP - 1, n // 2, n // 2
        assert plane.axis == 0 and plane.pays == (plane.p == MIDDLE)
        if plane.p < MIDDLE:
            n_upper = n
        elif plane.p > MIDDLE:
            n_lower = n
        halves = [w * w + 2 * w * e for e in (l, w - l)]
        assert plane.cost == 8 * (2 * 3 * w * w + 3 * (halves[0] * n_lower + halves[1] * n_upper))
    with pytest.raises(ValueError, match="references"):
        model.build(model.Refs(*(np.concatenate((v, v[:1])) for v in (lo, hi, refs.tri, refs.opaque))))


# ---- the parts of the unit alone ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [n for n in MESHES if len(MESHES[n]) > 5])
def test_steps_of_a_node(name):
    """Bins, their evaluation, the second look and the partition, each through its own entry."""
    refs = refs_of(MESHES[name])
    rng = np.random.default_rng(SEED)
    whole = refs.box
    for _ in range(6):
        box = np.sort(rng.integers(whole[0], whole[1] + 1, (2, 3)), axis=0)
        box[:, rng.integers(3)] = whole[:, rng.integers(3)]
        box.sort(axis=0)
        node = refs[np.all((refs.lo <= box[1]) & (refs.hi >= box[0]), axis=1)]
        if not len(node):
            continue
        part = parts(node, box.tolist())
        exact = model.sorted_plane(node, box)
        want = best_of(part, box.tolist(), all_planes(part, box.tolist()))
        assert want is None if exact.axis < 0 else (exact.cost, exact.axis, exact.p, exact.side) == want

        bins, shifts = model.coarse_bins(node, box)
        coarse = [model.evaluate_bins(bins[a], len(node), box, a, box[0, a], shifts[a]) for a in range(3)]
        assert (bins.sum(axis=1) == len(node)).all()
        for a in range(3):
            s, planes = coarse_planes(box.tolist(), a)
            best = best_of(part, box.tolist(), planes)
            assert s == shifts[a]
            assert best is None if coarse[a].axis < 0 else (coarse[a].cost, coarse[a].axis, coarse[a].p, 1) == best
        fine, starts, shifts = model.fine_bins(node, box, coarse)
        looks = [
            model.evaluate_bins(fine[a], len(node), box, a, starts[a], shifts[a]) if coarse[a].axis >= 0 else coarse[a]
            for a in range(3)
        ]
        for found, refine in ((coarse, False), (looks, True)):
            best = min((p for p in found if p.axis >= 0), key=lambda p: (p.cost, p.axis, p.p), default=None)
            plane = model.binned_plane(node, box, refine)
            want = best_of(part, box.tolist(), bin_planes(part, box.tolist(), refine))
            assert (best is None and want is None) if plane.axis < 0 else plane == best
            if best is not None:
                assert (plane.cost, plane.axis, plane.p, plane.side) == want
                assert plane.pays == (plane.cost < 24 * len(node) * half(box.tolist()))
                lower, upper = model.partition(node, box, plane)
                rows = who(part, plane.axis, plane.p, plane.side)
                assert [lower.tri.tolist(), upper.tri.tolist()] == [node.tri[r].tolist() for r in rows]
                assert [b.tolist() for b in model.child_boxes(box, plane)] == list(
                    cut(box.tolist(), plane.axis, plane.p)
                )


@pytest.mark.parametrize("name", ["clusters", "floor", "terrain", "few values", "none", "five"])
def test_upper_tree_and_jobs(name):
    """The binner's nodes and the sorting pipelines' subtrees together are the whole tree; gaps are where ancestors lie."""
    refs = refs_of(MESHES[name])
    cap, refine_max = 20, 60
    whole, upper = (f(refs, cap=cap, refine_max=refine_max) for f in (model.build, model.upper_tree))
    nodes, lists, root = emit(whole)
    found = walk_memory(nodes, lists, root, refs.box)

    def same(a, b):
        """Row a of the whole tree, row b of the upper one."""
        assert (a < 0) == (b < 0)
        if a < 0:
            return
        if upper.kind[b] != model.JOB:
            assert whole.kind[a] == upper.kind[b] and whole.plane[a] == upper.plane[b]
            same(whole.lower[a], upper.lower[b])
            same(whole.upper[a], upper.upper[b])
            return
        job = upper.leaf(b)
        assert 1 <= len(job) <= cap
        tree = model.sort_subtree(refs[np.array(job)], upper.box[b], upper.level[b])
        assert as_tuples(tree) == as_tuples(whole, a)
        free = model.gap(upper, b)
        above, index = a, found.at[a]
        for step in range(free):
            above = whole.parent[above]
            assert found.at[above] == index - 1 - step
        above = whole.parent[above]
        assert above < 0 or found.at[above] != index - 1 - free

    same(0, 0)


# ---- memory ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MESHES)
def test_memory_image(name):
    """What is emitted is walked to the same tree, wherever it lies, and is what the rest of the package reads."""
    rng = np.random.default_rng(SEED)
    refs = refs_of(MESHES[name], rng.random(len(MESHES[name])) < 0.5)
    tree = model.build(refs, cap=16, refine_max=50)
    for node_top, list_base in ((None, 0), (5000, 700)):
        nodes, lists, root = emit(tree, node_top, list_base)
        found = walk_memory(nodes, lists, root, refs.box, node_base=root, list_base=list_base)
        assert compare(tree, found) is None
        assert (found.box == tree.box).all() and (found.level == tree.level).all()
        assert root == (0 if node_top is None else node_top - len(tree)) and found.jumps == 0
    nodes, lists, root = emit(tree)
    bounds = (refs.box - MIDDLE) * 2.0**-17
    walk = kdtree.walk(kdtree.Tree(nodes, lists, root, bounds))
    assert sorted(walk.members.tolist()) == sorted(tree.members.tolist())
    assert ((lists >> 25 & 1 == 1) == refs.opaque[lists & 0xFFFFFF]).all()


def scattered(nodes, root, rng):
    """The same tree in pieces: some nodes and their adjacent chains lie elsewhere, reached by jump nodes."""
    memory = {i: int(w) for i, w in enumerate(nodes)}
    top = len(nodes)
    for index in sorted(rng.choice(len(nodes), len(nodes) // 4, replace=False).tolist(), reverse=True):
        chain, at = [], index  # up to the leaf, or to a jump node that was made before
        while True:
            chain.append(memory[at])
            if memory[at] >> 24 & 3 == 3 or memory[at] & 0x1FFFFFFF == JUMP:
                break
            at += 1
        top += rng.integers(3)
        for i, word in enumerate(chain):
            memory[top + i] = word
        memory[index] = JUMP | top << 29
        top += len(chain)
    out = np.full(top, 0x123456789ABC, np.uint64)
    for index, word in memory.items():
        out[index] = word
    return out


@pytest.mark.parametrize("name", ["clusters", "floor", "five", "one"])
def test_jump_nodes(name):
    rng = np.random.default_rng(SEED)
    refs = refs_of(MESHES[name])
    tree = model.build(refs, cap=16, refine_max=50)
    nodes, lists, root = emit(tree)
    for _ in range(5):
        found = walk_memory(scattered(nodes, root, rng), lists, root, refs.box)
        assert compare(tree, found) is None
        assert found.jumps > 0 or len(nodes) < 4
    alone = np.array([JUMP | 1 << 29, nodes[0]], np.uint64)
    if name == "one":
        assert compare(tree, walk_memory(alone, lists, 0, refs.box)) is None


def test_compare_names_the_difference():
    refs = refs_of(MESHES["clusters"])
    tree = model.build(refs, cap=16)
    nodes, lists, root = emit(tree)
    inner = np.flatnonzero(tree.kind < model.LEAF)[5]
    at = walk_memory(nodes, lists, root, refs.box).at[inner]
    for wrong, text in (
        (nodes[at] ^ np.uint64(1), f"at {tree.path(inner)}, level {tree.level[inner]}, index {at}"),
        (nodes[at] ^ np.uint64(1 << 24), "expected"),
    ):
        changed = nodes.copy()
        changed[at] = wrong
        try:
            assert text in compare(tree, walk_memory(changed, lists, root, refs.box))
        except ValueError as error:
            assert "grid" in str(error) or "node" in str(error)
    for bit, text in ((0, "leaf of"), (25, "opaque flag")):
        changed = lists.copy()
        changed[7] ^= np.uint32(1 << bit)
        assert text in compare(tree, walk_memory(nodes, changed, root, refs.box))
    changed = lists.copy()
    changed[7] ^= np.uint32(1 << 24)
    with pytest.raises(ValueError, match="last flag"):
        walk_memory(nodes, changed, root, refs.box)
    other = model.build(refs, cap=model.NO_CAP)
    assert compare(tree, other) is not None
    assert compare(tree, model.build(refs, cap=16)) is None
    # The same nodes, one leaf more at the end.
    deeper = model.build(refs, cap=16, max_leaf=1)
    assert compare(tree, deeper) and compare(deeper, tree)


@pytest.mark.parametrize(
    "words, lists, text",
    [
        ([1 << 24 | 1 << 53], [], "zero"),
        ([3 << 24 | 2 | 5 << 29], [0], "outside the lists"),
        ([0x3E0000 | 9 << 29, 3 << 24 | 1], [], "outside the nodes"),
        ([0x3E0000, 3 << 24 | 1], [], "loop"),
        ([0x3E0000 | 3 << 27], [], "both children"),
        ([0x3E0000 | 1 << 27], [], "adjacent"),
        ([0x3E0000 | 1 << 28 | 4 << 29, 3 << 24 | 1], [], "not 0"),
        ([0x2D0001 | 1 << 28, 3 << 24 | 1], [], "grid"),
        ([JUMP], [], "loop"),
    ],
)
def test_walk_refuses_nonsense(words, lists, text):
    with pytest.raises(ValueError, match=text):
        walk_memory(np.array(words, np.uint64), np.array(lists, np.uint32), 0, [[1] * 3, [TOP] * 3])


# ---- records and numbers -----------------------------------------------------------------------------------------------


def test_fixed_point():
    """All 2^18 - 1 coordinates there and back, against the floating-point value."""
    q = np.arange(1, 1 << 18)
    bits = model.fp24_from_fixed(q)
    assert (fp24.from_bits(bits) == (q - MIDDLE) * 2.0**-17).all()
    assert (model.fixed_from_fp24(bits) == q).all()
    assert model.fixed_from_fp24([0x800000, 0, 0x80FFFF]).tolist() == [MIDDLE] * 3
    for bad, text in (
        ([0x3F0000], "outside"),
        ([0xBF0000], "outside"),
        ([0x2D0000], "multiple"),
        ([0x3D0001], "multiple"),
    ):
        with pytest.raises(ValueError, match=text):
            model.fixed_from_fp24(bad)


def test_reference_records():
    """The fields of tri_ref_t lie where rc_tbu_pkg.sv says."""
    mesh = np.array([[[3, 20, 100], [5, 10, 300], [4, 30, 200]]])
    refs = model.Refs(*(getattr(refs_of(mesh), n) for n in ("lo", "hi")), np.array([0x4ABCD]), np.array([True]))
    word = pack_refs(refs)[0]
    assert [word >> 18 * i & 0x3FFFF for i in range(6)] == [3, 10, 100, 5, 30, 300]
    assert word >> 108 == 0x4ABCD | 1 << 19
    back = unpack_refs([word])
    assert all((getattr(back, n) == getattr(refs, n)).all() for n in ("lo", "hi", "tri", "opaque"))
    with pytest.raises(ValueError, match="coordinate"):
        model.build(model.Refs(refs.lo * 0, refs.hi, refs.tri, refs.opaque))


# ---- the host ----------------------------------------------------------------------------------------------------------


def scene_of(triangles):
    from raycore.scene import Material, Scene

    triangles = np.asarray(triangles, np.float64)
    n = len(triangles)
    return Scene(
        "test", triangles, np.zeros((n, 3, 3)), np.zeros(n, np.int32), [Material("m", (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))]
    )


@pytest.mark.parametrize("scale", [1.0, 0.75, 1e-3, 3e5, 1.0 - 2.0**-20])
def test_snap(scale):
    """Vertices are on the grid, inside the range, close to where they were; shared ones stay shared."""
    rng = np.random.default_rng(SEED)
    mesh = soup(rng, 200, 3000) - MIDDLE
    mesh[0], mesh[1, 0] = [[-TOP // 2] * 3, [TOP // 2] * 3, [0] * 3], [TOP // 2] * 3
    scene = scene_of(mesh / (TOP // 2) * scale)
    unit = tbu.snap(scene)
    q = unit.triangles * 2.0**17
    assert (q == np.rint(q)).all() and 2**16 <= np.abs(q).max() < 2**17
    assert np.abs(unit.to_world(unit.triangles) - scene.triangles).max() <= 0.51 * 2.0**-17 * 2.0**unit.scale_exp
    assert (unit.triangles[0, 1] == unit.triangles[1, 0]).all()
    refs = tbu.references(unit)
    assert (refs.lo == q.min(axis=1) + MIDDLE).all() and (refs.hi == q.max(axis=1) + MIDDLE).all()


def test_vertex_records():
    rng = np.random.default_rng(SEED)
    unit = tbu.snap(scene_of(rng.normal(0, 1, (50, 3, 3))))
    opaque = rng.random(50) < 0.5
    records = tbu.vertex_records(unit, opaque)
    assert records.shape == (50, 4) and records.dtype == np.uint64
    bits = fp24.to_bits(unit.triangles)
    for tri in range(50):
        word = int.from_bytes(records[tri].astype("<u8").tobytes(), "little")
        assert [word >> 24 * i & 0xFFFFFF for i in range(9)] == bits[tri].reshape(-1).tolist()
        assert word >> 216 == opaque[tri]


def test_sizes():
    for n in (0, 1, 1000, 1 << 19):
        size = tbu.sizes(n)
        assert size.nodes % 128 == 0 and size.entries % 256 == 0
        assert size.nodes >= min(5 * n, 1 << 20) and size.refs >= 3 * n and size.nodes < 1 << 24
        assert size.bytes["working"] == 16 * size.refs
        assert tbu.sizes(n, factor=2).refs >= size.refs
