# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What the tests of the shading unit share: numbers, records as words and as the model wants them, builds."""

import os
import random
import re
from dataclasses import dataclass, field

import numpy as np

from raycore.model import fp24, shade
from raycore.tbutil import RTL, TB_BUILD, rtl, run_cocotb

HUGE, NAN_BITS, TRI_NONE = 0x7D0000, fp24.NAN_BITS, (1 << 24) - 1
CORNERS = [0x000000, 0x800000, 0x010000, 0x810000, 0x3F0000, 0xBF0000, 0x7EFFFF, 0xFEFFFF, 0x7F0000, 0xFF0000, NAN_BITS,
           0x000001, 0x80FFFF, 0x7F0001, 0xFFFFFF, 0x7E0000, 0x7DFFFF, 0x020000]


def bits(values):
    """Patterns, as a list, of FP24 numbers."""
    return [int(b) for b in fp24.to_bits(np.asarray(values, dtype=np.float64))]


def nearest(values):
    """Patterns of any numbers, rounded."""
    return bits(fp24.round_to_fp24(np.asarray(values, dtype=np.float64)))


def floats(patterns):
    """The values of patterns, as a tuple."""
    return tuple(float(v) for v in fp24.from_bits(np.asarray(patterns)))


def same(a, b):
    """True if two lists of patterns have the same values: a record's own NaN and tiny numbers may pass through a unit."""
    return bits(floats(a)) == bits(floats(b))


def vec(patterns):
    """A vec3_t."""
    return patterns[0] | patterns[1] << 24 | patterns[2] << 48


def unvec(word):
    return [word >> s & 0xFFFFFF for s in (0, 24, 48)]


def line(numbers, top):
    """A record in memory: two numbers a word of 60 bits, `top` at bit 48 of the first (rc_pkg: tri_info_t and others)."""
    word = top << 48
    for i, b in enumerate(numbers):
        word |= b << (60 * (i // 2) + 24 * (i % 2))
    return word


def unit(rng):
    v = np.array([rng.gauss(0, 1) for _ in range(3)])
    return v / np.linalg.norm(v)


class Numbers:
    """Random operands: `wild` is the share of patterns that are corners or random bits."""

    def __init__(self, rng: random.Random, wild: float):
        self.rng, self.wild = rng, wild

    def spoil(self, patterns):
        """The patterns, some replaced."""
        rng = self.rng
        return [(rng.choice(CORNERS) if rng.random() < 0.5 else rng.randrange(1 << 24)) if rng.random() < self.wild else b
                for b in patterns]

    def point(self):
        return self.spoil(nearest([self.rng.uniform(-1, 1) for _ in range(3)]))

    def direction(self):
        return self.spoil(nearest(unit(self.rng)))

    def color(self):
        return self.spoil(nearest([self.rng.random() for _ in range(3)]))


def pack(*fields):
    """A packed struct: (value, bits) of each field, the first one highest."""
    word = 0
    for value, width in fields:
        assert 0 <= value < 1 << width, (value, width)
        word = word << width | int(value)
    return word


@dataclass
class Material:
    """Phong colours, alpha, optics: the two blocks of a material in memory, and the record of the model."""

    ambient: list
    diffuse: list
    specular: list
    emission: list
    shin: int
    alpha: int = 0x3F0000
    cutoff: int = 0x3E0000
    kr: list = field(default_factory=lambda: [0] * 3)
    kt: list = field(default_factory=lambda: [0] * 3)
    ior: int = 0x3F0000
    inv_ior: int = 0x3F0000
    textured: bool = False
    mode: int = shade.ALPHA_OPAQUE
    reflects: bool = False
    transmits: bool = False
    fresnel: bool = False
    tex_kr: bool = False
    texture: int = 0                                      # word 4 of the optics

    @classmethod
    def random(cls, num: Numbers, effects=True):
        """Any material. effects: textured, transparent and mirroring ones, too."""
        rng = num.rng
        mat = cls(num.color(), num.color(), num.color(), num.color(), *num.spoil(nearest([rng.uniform(0, 100)])))
        if effects:
            mat.alpha, mat.cutoff = num.spoil(nearest([rng.random(), rng.random()]))
            mat.kr, mat.kt = num.color(), num.color()
            ior = rng.uniform(0.6, 2.5)
            mat.ior, mat.inv_ior = num.spoil(nearest([ior, 1 / ior]))
            mat.textured, mat.reflects, mat.fresnel, mat.tex_kr = (rng.random() < 0.5 for _ in range(4))
            mat.mode = rng.choice([shade.ALPHA_OPAQUE, shade.ALPHA_OPAQUE, shade.ALPHA_MASK, shade.ALPHA_BLEND])
            mat.transmits = mat.mode == shade.ALPHA_OPAQUE and rng.random() < 0.5
        return mat

    @property
    def opaque(self):
        return self.mode == shade.ALPHA_OPAQUE and not self.transmits

    @property
    def line(self):
        bits = (self.tex_kr, self.fresnel, self.transmits, self.reflects)
        flags = pack(*((b, 1) for b in bits), (self.mode, 2), (self.textured, 1))
        return line(self.ambient + self.diffuse + self.specular + self.emission + [self.shin, self.alpha, self.cutoff], flags)

    @property
    def optics_line(self):
        return line(self.kr + self.kt + [self.ior, self.inv_ior], 0) | self.texture << 240

    @property
    def record(self):
        return np.array([*floats(self.ambient + self.diffuse + self.specular + self.emission),
                         *floats([self.shin, self.alpha, self.cutoff]), *floats(self.kr + self.kt + [self.ior, self.inv_ior]),
                         self.textured, self.mode, self.reflects, self.transmits, self.fresnel, self.tex_kr], dtype=np.float64)


@dataclass
class Light:
    directional: bool
    pos: list
    color: list
    att: list

    @classmethod
    def random(cls, num: Numbers):
        directional = num.rng.random() < 0.4
        att = num.spoil(nearest([num.rng.random(), num.rng.random(), num.rng.choice([0.0, num.rng.random() * 4])]))
        return cls(directional, num.direction() if directional else num.point(), num.color(), att)

    @property
    def line(self):
        return line(self.pos + self.color + self.att, int(self.directional))

    @property
    def record(self):
        return np.array([float(self.directional), *floats(self.pos + self.color + self.att)])


@dataclass
class Triangle:
    a: list
    n: list
    n0: list
    e1: list
    e2: list
    mat: int

    @classmethod
    def random(cls, num: Numbers, mat: int):
        rng = num.rng
        n = unit(rng)
        if rng.random() < 0.5:                            # flat: all normals that of the plane
            normals = [n, np.zeros(3), np.zeros(3)]
        else:
            v = [w / np.linalg.norm(w) for w in (n + 0.5 * unit(rng) for _ in range(3))]
            normals = [v[0], v[1] - v[0], v[2] - v[0]]
        if rng.random() < 0.02:
            normals = [np.zeros(3)] * 3                   # no shading normal at all
        return cls(num.point(), num.spoil(nearest(n)), *[num.spoil(nearest(v)) for v in normals], mat)

    @property
    def line(self):
        return line(self.a + self.n + self.n0 + self.e1 + self.e2, self.mat)

    @property
    def record(self):
        return np.array([floats(v) for v in (self.a, self.n, self.n0, self.e1, self.e2)])

    def placed(self, place):
        """In the scene's coordinates, by the model, as a triangle of an object with such a `Place`."""
        return Triangle(*map(bits, shade.FP24.place(self.record, place.record)), self.mat)


@dataclass
class Place:
    """Rows of a rotation, each followed by a coordinate of the origin."""

    rows: list

    @classmethod
    def random(cls, num: Numbers):
        rotation = np.linalg.qr(np.array([unit(num.rng) for _ in range(3)]))[0]
        return cls([num.spoil([*nearest(row), o]) for row, o in zip(rotation, num.point())])

    @property
    def line(self):
        return line([b for row in self.rows for b in row], 0)

    @property
    def record(self):
        return np.array([floats(row) for row in self.rows])


@dataclass
class Context:
    """A hit point as the model has it, and its patterns."""

    values: tuple                                         # P, g, m, d, m . d
    length: float = 0.0
    inside: bool = False

    @classmethod
    def of_hit(cls, org, d, t, beta, gamma, triangle, length=0):
        """All patterns but the triangle; length: of the path before the ray."""
        p, g, m, md, way, inside = shade.FP24.hit_point(floats(org), floats(d), *floats([t, beta, gamma]), triangle.record,
                                                        floats([length])[0])
        return cls((p, g, m, floats(d), md), way, inside)

    @property
    def words(self):
        """[P, g, m, d] as patterns, and m . d."""
        return [bits(v) for v in self.values[:4]], bits([self.values[4]])[0]


def hit_word(ray_id, any_hit, hit, opaque, mat, surf, t, beta, gamma):
    """A hit_t, 128 bits. surf: a surf_t, the placed object above the triangle."""
    return pack((ray_id, 8), (any_hit, 1), (hit, 1), (opaque, 1), (mat, 12), (surf, 33), (t, 24), (beta, 24), (gamma, 24))


def tex_word(hit, rgb, a):
    """A tex_t, 224 bits."""
    return pack((hit, 128), (vec(rgb), 72), (a, 24))


def point_word(ray_id, mat, bounces, branch, alpha, tex):
    """A point_t, 114 bits."""
    return pack((ray_id, 8), (mat, 8), (bounces, 1), (branch, 1), (alpha, 24), (vec(tex), 72))


async def load(dut, records, valid="ld_valid_i"):
    """Give (kind, index, line) to the loader port, one a cycle; kind is ignored by parts with a port for each."""
    from cocotb.triggers import RisingEdge

    for kind, index, record in records:
        name = valid if isinstance(valid, str) else valid[kind]
        if name is None:
            continue
        getattr(dut, name).value = 1
        if hasattr(dut, "ld_kind_i"):
            dut.ld_kind_i.value = kind
        dut.ld_idx_i.value, dut.ld_line_i.value = index, record
        await RisingEdge(dut.clk_i)
        getattr(dut, name).value = 0


LD_LIGHT, LD_MATERIAL, LD_OPTICS = range(3)


def random_weights(num: Numbers):
    """(t, beta, gamma) of a hit."""
    rng = num.rng
    beta = rng.random()
    return num.spoil(nearest([rng.uniform(0.01, 3), beta, rng.random() * (1 - beta)]))


LATENCIES = {
    "paper": {},
    "one": dict(ADD=1, ADD3=1, MUL=1, DIV=1, SQRT=1, POW=1),
    "deep": dict(ADD=4, ADD3=5, MUL=3, CMP=2, DIV=9, SQRT=4, POW=7, CONV=2),
    "odd": dict(ADD=3, ADD3=3, MUL=2, DIV=5, SQRT=3, POW=3),
    "long": dict(ADD=2, ADD3=4, MUL=5, DIV=20, SQRT=6, POW=2),
}
PRIM = [f"prim/rc_{n}.sv" for n in ("delay", "ram_1r1w", "skid", "fifo", "rr_arb", "idx_pool")]
UNITS = [f"fp/rc_fp_{n}.sv" for n in ("pipe", "norm", "round", "add", "add3", "cmp", "mul", "div", "sqrt", "pow", "from_int")]
PARTS = ["shade/rc_shade_pkg.sv", *[f"shade/rc_{n}.sv" for n in ("carry", "hold", "gather", "keep", "phong", "light_end")]]
SHADE = sorted((str(f.relative_to(RTL)) for f in (RTL / "shade").glob("*.sv") if str(f.relative_to(RTL)) not in PARTS),
               key=lambda name: ("_pkg" not in name, name)) + ["mem/rc_ro_cache.sv"]      # what rc_shade needs besides


def some(count):
    """`count`, or a part of it on the builds with other latencies, which are there for the schedules."""
    return count if os.environ["LATENCIES"] == "paper" else max(1, count // 4)


def run(top, latencies, files, test_module):
    """Run the tests of `test_module` on `top`, built from `files` and all below, with a package of other latencies."""
    text = (RTL / "rc_pkg.sv").read_text()
    for name, cycles in LATENCIES[latencies].items():
        text, n = re.subn(rf"(LAT_{name} +)= \d+;", rf"\1= {cycles};", text)
        assert n == 1, f"LAT_{name} not found in rc_pkg.sv"
    package = TB_BUILD / f"rc_shade-{latencies}" / "rc_pkg.sv"
    package.parent.mkdir(parents=True, exist_ok=True)
    if not package.exists() or package.read_text() != text:
        package.write_text(text)
    # The define gives each set of latencies a build folder of its own.
    run_cocotb(top, [package, *rtl(*PRIM, *UNITS, *PARTS, *files, package=False)], test_module,
               defines={"LATENCIES": latencies}, env={"LATENCIES": latencies})
