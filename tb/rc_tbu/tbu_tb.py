# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What the tests of the tree-building unit share: geometry, packed records, memory."""

import random
import re
from pathlib import Path

import numpy as np

from raycore.model.tbu import ONE, Refs, fp24_from_fixed, refs_from_vertices
from raycore.tbu_sim import CONFIG
from raycore.tbutil import RTL, TB_BUILD

TOP = 2 * ONE - 1                          # largest coordinate
SLVERR, DECERR, WINDOW = 6, 7, 8           # err_e of rc_pkg.sv
DEST = (("root", 1), ("upper", 1), ("entry", 7))
JOB = (("dest", 9), ("gap", 6), ("level", 6), ("count", 20), ("box", 108))
LIST_JOB = (("vertices", 1), ("base", 24), ("job", 149))
SPLIT = (("dest", 9), ("axis", 2), ("pos", 18), ("swap", 1), ("lower_empty", 1), ("upper_empty", 1))
LEAF = (("dest", 9), ("gap", 6), ("first", 24), ("count", 20))
WR = (("kind", 2), ("row", 24), ("strb", 8), ("data", 256))
DONATED = (("entry", 7), ("axis", 2), ("pos", 18), ("swap", 1), ("idx", 24))
SUBTREE = (("dest", 9), ("idx", 24))
CFG = CONFIG


def package_with_depth(levels: int) -> Path:
    """A copy of rc_tbu_pkg.sv that stops dividing after so many levels: 32 of them take more than a test can build."""
    text, found = re.subn(r"(MAX_DEPTH +)= \d+;", rf"\g<1>= {levels};", (RTL / "tbu/rc_tbu_pkg.sv").read_text())
    assert found == 1
    path = TB_BUILD / f"rc_tbu_pkg-depth{levels}" / "rc_tbu_pkg.sv"
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    return path


def pack(fields, **values) -> int:
    """A packed struct; `fields` (name, width), the first one highest."""
    assert {n for n, _ in fields} == set(values), f"{set(values)} is not {fields}"
    word = 0
    for name, width in fields:
        value = int(values[name])
        assert 0 <= value < 1 << width, f"{name} = {value} has more than {width} bits"
        word = word << width | value
    return word


def unpack(fields, word: int) -> dict:
    """Inverse of `pack`."""
    out = {}
    for name, width in reversed(fields):
        out[name] = word & (1 << width) - 1
        word >>= width
    return out


# ---- geometry: vertices (N, 3, 3) int64, q ------------------------------------------------------------------------------


def soup(rng, n, size=0.1):
    """Triangles anywhere, `size` of the box across."""
    centre = rng.integers(1, TOP + 1, (n, 1, 3))
    return np.clip(centre + (rng.uniform(-1, 1, (n, 3, 3)) * size * ONE).astype(np.int64), 1, TOP)


def grid(rng, n, step=4096):
    """A height field: neighbours share vertices."""
    m = max(int((n / 2) ** 0.5), 1)
    z = rng.integers(ONE - 3000, ONE + 3000, (m + 1, m + 1))
    quads = []
    for i in range(m):
        for j in range(m):
            p = [[1 + (i + a) * step, 1 + (j + b) * step, z[i + a, j + b]] for a, b in ((0, 0), (1, 0), (0, 1), (1, 1))]
            quads += [[p[0], p[1], p[2]], [p[1], p[3], p[2]]]
    return np.clip(np.array(quads[:n]), 1, TOP)


def flat(rng, n):
    """All in one plane, overlapping."""
    v = soup(rng, n, 0.3)
    v[:, :, rng.integers(3)] = ONE + 5
    return v


def walls(rng, n):
    """Planar triangles on few planes that bins meet exactly."""
    v = soup(rng, n, 0.2)
    for t in v:
        t[:, rng.integers(3)] = 1 + 4096 * rng.integers(0, 63)
    v[0], v[1] = 1, 1 + (1 << 17)
    return v


def same(rng, n):
    """One triangle n times: no split pays."""
    return np.repeat(soup(rng, 1, 0.4), n, axis=0)


def needles(rng, n):
    """Long boxes that go through everything."""
    v = soup(rng, n, 0.01)
    for t in v:
        t[0, (a := rng.integers(3))], t[1, a] = 1, TOP
    return v


def points(rng, n):
    """Triangles of no extent, a few places taken often."""
    return np.repeat(rng.integers(1, TOP + 1, (n, 1, 3)) // 9999 * 9999 + 1, 3, axis=1)


def dense(rng, n):
    """Nearly all in a corner of a few units, and one far away: deep trees, cells of one unit."""
    v = 77 + rng.integers(0, 9, (n, 3, 3))
    v[-1] = [[TOP, TOP, TOP], [TOP - 5, TOP, TOP], [TOP, TOP - 9, TOP]]
    return v


def clusters(rng, n):
    """Some heaps of different size, large triangles between them."""
    place = rng.integers(1, TOP + 1, (5, 1, 3))
    spread = np.array([300, 2000, 9000, 20000, 40])
    which = rng.integers(0, 5, n)
    v = place[which] + (rng.normal(0, 1, (n, 3, 3)) * spread[which][:, None, None]).astype(np.int64)
    v[:: 17] = soup(rng, len(v[::17]), 0.8)
    return np.clip(v, 1, TOP)


SHAPES = {f.__name__: f for f in (soup, grid, flat, walls, same, needles, points, dense, clusters)}


def references(vertices, opaque) -> Refs:
    """References of triangles, (N, 3, 3) q, as the model makes them from FP24."""
    return refs_from_vertices(fp24_from_fixed(vertices).reshape(-1, 3, 3), opaque)


def vertex_records(vertices, opaque) -> list[int]:
    """Records of 32 bytes, as numbers of 256 bits."""
    words = fp24_from_fixed(vertices).reshape(-1, 9)
    return [sum(int(c) << 24 * i for i, c in enumerate(t)) | int(o) << 216 for t, o in zip(words, opaque, strict=True)]


class Memory:
    """Words of 32 bits by index; what was never written reads as noise."""

    def __init__(self, seed):
        self.words, self.rng = {}, random.Random(seed)

    def word(self, index):
        if index not in self.words:
            self.words[index] = self.rng.getrandbits(32)
        return self.words[index]

    def put(self, byte, value, size):
        for i in range(size // 4):
            self.words[byte // 4 + i] = value >> 32 * i & 0xFFFFFFFF

    def get(self, byte, size):
        return sum(self.word(byte // 4 + i) << 32 * i for i in range(size // 4))

    def row(self, byte, data, strb):
        for i in range(8):
            if strb >> i & 1:
                self.words[byte // 4 + i] = data >> 32 * i & 0xFFFFFFFF
