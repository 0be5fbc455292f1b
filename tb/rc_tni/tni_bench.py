# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What the T&I tests share: a small scene in memory, rays of every kind, packed structs, a memory that answers lines."""

import random

import numpy as np

from raycore import kdtree, objects, triaccel
from raycore.model import fp24, rgen, tracer

NODE_BASE, LIST_BASE, ACCEL_BASE, INST_BASE = 0x40, 0x4000, 0x8000, 0xC000  # line addresses
LINE_WORDS = 8
WORD_MASK = (1 << 60) - 1


class Bench:
    """A scene's tree as memory lines, as `tree_cfg_t` and as the model's arrays."""

    instances = np.zeros((0, 32), np.uint64)

    def __init__(self, triangles, params=None):
        self.triangles = fp24.round_to_fp24(np.asarray(triangles, dtype=np.float64))
        dropped = ~triaccel.has_area(self.triangles)
        self.tree = kdtree.build(self.triangles, dropped, params)
        kinds = np.random.default_rng(len(triangles))
        records = triaccel.pack(
            triaccel.records(self.triangles, dropped), kinds.integers(0, 4096, len(triangles)), kinds.random(len(triangles)) < 0.6
        )
        grow = np.array([[-(2.0**-10)] * 3, [2.0**-10] * 3])
        self.box = fp24.round_to_fp24(self.tree.bounds + grow)
        self.arrays = tracer.decode(self.tree.nodes, self.tree.lists, records, self.box, self.tree.root)
        self.aims = [(t, i, tracer.NOT_PLACED) for i, t in enumerate(self.triangles)]  # where it stands, number, placed object
        self.lines = {}
        self._store(NODE_BASE, self.tree.nodes)
        lists = np.concatenate([self.tree.lists, np.zeros(len(self.tree.lists) % 2, dtype=np.uint32)])
        self._store(LIST_BASE, lists.view(np.uint64))
        self._store(ACCEL_BASE, records.reshape(-1))

    def _store(self, base, words):
        for i, word in enumerate(words):
            line = self.lines.setdefault(base + i // LINE_WORDS, [0] * LINE_WORDS)
            line[i % LINE_WORDS] = int(word) & WORD_MASK

    def half(self, addr):
        """`half_line_t` at the address of half a line; KeyError outside the regions: the unit must not ask for it."""
        return sum(w << (60 * i) for i, w in enumerate(self.lines[addr >> 1][4 * (addr & 1) :][:4]))

    def cfg(self, max_slots=0xFFFF):
        """`tree_cfg_t`."""
        return pack(
            (NODE_BASE, 26), (len(self.tree.nodes), 24), (self.tree.root, 24), (LIST_BASE, 26), (len(self.tree.lists), 24),
            (ACCEL_BASE, 26), (len(self.triangles), 24), (INST_BASE, 26), (len(self.instances), 24),
            (vec3(self.box[0]), 72), (vec3(self.box[1]), 72), (max_slots, 16),
        )  # fmt: skip

    def random_rays(self, count):
        """Rays inside and outside the box, axis-parallel, in split planes, towards and beside vertices, from just above an edge.

        Shadow rays too.
        """
        lo, hi = self.box
        planes = self.arrays.split[(self.arrays.meta & 3) != 3]
        rays = []
        for _ in range(count):
            org = np.array([random.uniform(lo[i] - 0.3, hi[i] + 0.3) for i in range(3)])
            aim, tri, inst = random.choice(self.aims)
            weights = np.array([random.random() for _ in range(3)])
            kind = random.randrange(10)
            target = aim[random.randrange(3)] if kind == 0 else (weights[:, None] * aim).sum(0) / weights.sum()
            direction = target - org
            if kind == 1:  # parallel to one or two axes
                for i in random.sample(range(3), random.randint(1, 2)):
                    direction[i] = random.choice([0.0, -0.0])
            if kind == 2 and len(planes):  # in or from a split plane
                axis = random.randrange(3)
                org[axis] = random.choice(planes)
                direction[axis] = random.choice([0.0, direction[axis]])
            if kind == 8:  # at a vertex's height, and staying there
                axis = random.choice([0, 0, 1, 2])
                org[axis], direction[axis] = aim[0, axis], 0.0
            if kind == 9:  # so near an edge that its slack decides, and whether a hit that used it is far enough away
                target = aim[0] + random.random() * (aim[1] - aim[0])
                org = target - direction / np.linalg.norm(direction) * 2.0 ** random.uniform(-14, -8)
                direction = target - org
            if kind == 3:
                direction = np.array([random.uniform(-1, 1) for _ in range(3)])
            length = np.linalg.norm(direction)
            direction = direction / length if length > 0 else np.array([1.0, 0.0, 0.0])
            shadow = random.random() < 0.4
            rays.append({
                "org": fp24.round_to_fp24(org), "dir": fp24.round_to_fp24(direction),
                "t_max": float(fp24.round_to_fp24(length * random.choice([0.5, 1.0, 2.0]))) if shadow else tracer.HUGE,
                "skip": tri if random.random() < 0.3 else tracer.TRI_NONE,
                "skip_inst": inst if random.random() < 0.8 else random.choice(self.aims)[2],
                "any_hit": shadow,
                "t_min": tracer.T_MIN if random.random() < 0.6 else
                float(fp24.round_to_fp24(tracer.T_MIN + length * random.choice([0.001, 0.5, 0.9, 1.1]) + 2.0**-8)),
            })  # fmt: skip
            rays[-1]["inv_dir"] = np.array([rgen.inverse(d) for d in rays[-1]["dir"]])
        return rays

    def expect(self, rays):
        """(hit_t without the id for every ray, slots (n, 4)) from the model."""
        names = ("org", "dir", "inv_dir", "t_min", "t_max", "skip", "skip_inst", "any_hit")
        columns = (np.array([r[k] for r in rays]) for k in names)
        tri, t, beta, gamma, mat, opaque, inst, slots = tracer.trace_rays(self.arrays, *columns)
        t, beta, gamma = fp24.to_bits(t), fp24.to_bits(beta), fp24.to_bits(gamma)
        hits = []
        for i, ray in enumerate(rays):
            hit = tri[i] != tracer.TRI_NONE
            hits.append(pack((int(ray["any_hit"]), 1), (int(hit), 1), (int(opaque[i]), 1), (int(mat[i]), 12), (int(inst[i]), 9),
                             (int(tri[i]), 24), (int(t[i]), 24), (int(beta[i]), 24), (int(gamma[i]), 24)))  # fmt: skip
        return hits, slots


class Objects(Bench):
    """A static tree and dynamic objects, each with a tree of its own, and a tree over their boxes.

    Triangles are those of the static tree, then those of each object. cut: the top-level tree is one plane through the
    middle with every object on both sides, so that each is listed twice. places: for each object None, or the number of the
    object whose shape it is, rotation (3, 3) and origin (3,) with which it is placed; its own triangles then count for nothing.
    """

    def __init__(self, static, things, params=None, cut=False, places=None):
        groups = [fp24.round_to_fp24(np.clip(g, -1.0, 1.0)) for g in (static, *things)]
        super().__init__(np.concatenate(groups))
        records = np.array([self.lines[ACCEL_BASE + i // 2][4 * (i % 2) :][:4] for i in range(len(self.triangles))], np.uint64)
        grow = np.array([[-(2.0**-10)] * 3, [2.0**-10] * 3])
        nodes, lists, roots, first = [], [], [], 0

        def add(tree, at):
            """Append a tree; its triangles count from `at`. Returns: its root."""
            node_at, list_at = sum(map(len, nodes)), sum(map(len, lists))
            words, entries = objects.relocated(tree, node_at, list_at, at)
            nodes.append(words)
            lists.append(entries)
            return node_at + tree.root

        places = places or [None] * len(things)
        stand = [p and (p[0] + 1, *p[1:]) for p in places]  # by number of the group, the static tree's first
        world = [g if p is None else groups[p[0]] @ p[1].T + p[2] for g, p in zip(groups[1:], stand)]
        starts = np.cumsum([0, *map(len, groups)])
        self.aims = [(t, i, tracer.NOT_PLACED) for i, t in enumerate(groups[0])]
        for thing, (g, p) in enumerate(zip(world, stand, strict=True), 1):
            at, inst = (starts[thing], tracer.NOT_PLACED) if p is None else (starts[p[0]], thing)
            self.aims += [(t, int(at + i), inst) for i, t in enumerate(g)]
        boxes = [np.stack((g.min((0, 1)), g.max((0, 1)))) + grow for g in world]
        for group in groups:
            if not len(group):  # a leaf without triangles
                nodes.append(np.array([3 << 24], np.uint64))
                roots.append(0)
                continue
            roots.append(add(kdtree.build(group, ~triaccel.has_area(group), params), first))
            first += len(group)
        corners = fp24.round_to_fp24(np.array(boxes))
        inside = np.clip(corners, -1.0, 1.0)  # planes lie within the scene
        if cut:
            at, n = sum(map(len, nodes)), len(boxes)
            (plane,) = numbers([corners[:, :, 0].mean()])
            leaf = 3 << 24 | n | sum(map(len, lists)) << 29
            nodes.append(np.array([plane | at + 2 << 29, leaf, leaf], np.uint64))
            lists.append(np.array([i + 1 | (i == n - 1) << 24 for i in range(n)], np.uint32))
            roots.append(at)
        else:
            things = inside[:, [0, 1, 0]]  # triangles with these boxes
            roots.append(add(kdtree.build(things, np.zeros(len(things), bool), params), 1))
        whole = np.stack((corners[:, 0].min(0), corners[:, 1].max(0)))
        self.tree = kdtree.Tree(np.concatenate(nodes), np.concatenate(lists), roots[0], self.tree.bounds, None, {})
        of_shape = [roots[p[0]] if p else root for root, p in zip(roots[1:-1], stand, strict=True)]
        self.instances = np.array(
            [instance(*v) for v in zip([roots[-1], *of_shape], [whole + grow, *corners], [None, *stand], strict=True)], np.uint64
        )
        some = groups[0] if len(static) else np.zeros((1, 1, 3))
        self.box = fp24.round_to_fp24(np.stack((some.min((0, 1)), some.max((0, 1)))) + grow)
        self.arrays = tracer.decode(self.tree.nodes, self.tree.lists, records, self.box, self.tree.root, self.instances)
        self._store(NODE_BASE, self.tree.nodes)
        pairs = np.concatenate([self.tree.lists, np.zeros(len(self.tree.lists) % 2, dtype=np.uint32)])
        self._store(LIST_BASE, pairs.view(np.uint64))
        self._store(INST_BASE, self.instances.reshape(-1))


def numbers(v):
    """FP24 patterns of numbers, as integers."""
    return fp24.to_bits(fp24.round_to_fp24(np.asarray(v, dtype=np.float64))).astype(int).tolist()


def instance(root, box, place=None):
    """An instance's record as 32 words: `inst_t`, three times `inst_row_t`, `place_t`. place: shape, rotation, origin."""
    lo, hi = map(numbers, box)
    words = [root | lo[0] << 24, lo[1] | lo[2] << 24, hi[0] | hi[1] << 24, hi[2]] + [0] * 28
    if place is not None:
        words[0] |= 1 << 48
        rotation, c = numbers(place[1]), numbers(place[2])
        for i, (x, y, z) in enumerate(zip(*rotation)):  # the way in is by the transpose
            words[4 * i + 4 : 4 * i + 8] = [x | y << 24, c[0] | c[1] << 24, c[2] | z << 24, root]
        for i, (x, y, z) in enumerate(rotation):
            words[2 * i + 16 : 2 * i + 18] = [x | y << 24, z | c[i] << 24]
    return words


def turned(rng):
    """A random rotation (3, 3), sometimes by a quarter turn so that it has zeros and ones."""
    if rng.random() < 0.3:
        return np.eye(3)[rng.permutation(3)] * rng.choice([-1.0, 1.0], 3)
    return np.linalg.qr(rng.normal(size=(3, 3)))[0]


def pack(*fields):
    """Packed struct from (value, width), the first field highest."""
    word = 0
    for value, width in fields:
        assert 0 <= value < 1 << width, (value, width)
        word = word << width | value
    return word


def vec3(v):
    """`vec3_t` from three FP24 values."""
    bits = fp24.to_bits(np.asarray(v, dtype=np.float64))
    return int(bits[0]) | int(bits[1]) << 24 | int(bits[2]) << 48


def ray_word(ident, ray):
    """`ray_t`."""
    t_min, t_max = (int(b) for b in fp24.to_bits(np.array([ray["t_min"], ray["t_max"]])))
    return pack(
        (ident, 8), (int(ray["any_hit"]), 1), (int(ray["skip_inst"]), 9), (int(ray["skip"]), 24), (t_min, 24), (t_max, 24),
        (vec3(ray["inv_dir"]), 72), (vec3(ray["dir"]), 72), (vec3(ray["org"]), 72),
    )  # fmt: skip


def soup(count, size, seed):
    """`count` random triangles of about `size` in [-1, 1], some flat, some along the axes, some without area, some twice."""
    rng = np.random.default_rng(seed)
    centre = rng.uniform(-0.9, 0.9, (count, 1, 3))
    tri = np.clip(centre + rng.normal(0, size, (count, 3, 3)), -1, 1)
    tri[::5, :, 1] = tri[::5, :1, 1]  # planes of one axis: flat cells, planar events
    tri[::17, 2] = tri[::17, 1]  # no area
    tri[1::23] = tri[::23][: len(tri[1::23])]  # duplicates
    return tri


def blocks(n):
    """n^3 boxes in rows, 12 axis-parallel triangles each: a ray along a row meets many vertices at its own height."""
    at = (np.arange(n) + 0.25) * 2 / n - 1
    lo = np.stack(np.meshgrid(at, at, at), axis=-1).reshape(-1, 1, 1, 3)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    corners = [[q[i], q[j], q[k]] for q in quads for i, j, k in ((0, 1, 2), (0, 2, 3))]
    unit = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)])[corners]
    return (lo + unit / n).reshape(-1, 3, 3)
