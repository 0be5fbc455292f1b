# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""FP units against the model, bit for bit, and against apytypes, big integers and double precision.

RAYCORE_FP_PAIRS sets the number of random operand pairs a unit (default 1 million).
"""

import itertools
import os

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from fp_harness import HERE, PORTS, run_units, sources
from fp_oracle import add3_exact, apy, model

from raycore.model import fp24
from raycore.tbutil import run_cocotb

PAIRS = int(float(os.environ.get("RAYCORE_FP_PAIRS", "1e6")))
BLOCK = 1_000_000   # pairs compared at a time
MIN = 0x010000

SPECIAL = np.array(
    [s << 23 | v for s in (0, 1) for v in (
        0x000000, 0x000001, 0x008000, 0x00FFFF,                       # zero, subnormals
        0x010000, 0x010001, 0x018000, 0x01FFFF, 0x020000,             # smallest normal numbers
        0x1F0000, 0x200000, 0x2E0000, 0x3D0000,                       # roots of the smallest, ...
        0x3E0000, 0x3EFFFF, 0x3F0000, 0x3F0001, 0x3F8000, 0x3FFFFF, 0x400000, 0x400001,   # about 1 and 2
        0x4E0000, 0x4F0000, 0x4F0001, 0x500000, 0x5EFFFF, 0x5F0000,   # 2^15 to 2^17: integers; root of the largest
        0x7D0000, 0x7E0000, 0x7EFFFE, 0x7EFFFF,                       # largest numbers
        0x7F0000, 0x7F0001, 0x7F8000, 0x7FFFFF)], dtype=np.uint32)    # infinity, NaN


def compare(a, b, c, *, exp_w=7, man_w=16, latency=0, only=PORTS):
    """All units on all operands against the model. Returns the results of the RTL."""
    a, b, c = (np.asarray(v, dtype=np.uint32) for v in (a, b, c))
    got, want = run_units(a, b, c, exp_w=exp_w, man_w=man_w, latency=latency), model(a, b, c, exp_w, man_w)
    for port in only:
        bad = np.flatnonzero(got[port] != want[port])
        if bad.size:
            i = bad[0]
            pytest.fail(f"{port}: {bad.size} of {a.size} results differ from the model, first a={a[i]:06x} b={b[i]:06x} "
                        f"c={c[i]:06x}: RTL {got[port][i]:06x}, model {want[port][i]:06x}")
    return got


def random_operands(rng, n):
    """Three arrays of patterns. A quarter each: any; close exponents; one nearly cancels another; sparse fractions."""
    a, b, c = (rng.integers(0, 1 << 24, n, dtype=np.uint32) for _ in range(3))
    def near(x, lo, hi):   # x's exponent shifted by lo to hi - 1, the rest from y
        return lambda y: (((x >> 16 & 0x7F).astype(np.int64) + rng.integers(lo, hi, n)).clip(0, 127) << 16
                          | y & 0x80FFFF).astype(np.uint32)
    kind = rng.integers(0, 4, n)
    b = np.where(kind == 1, near(a, -3, 4)(b), b)
    b = np.where(kind == 2, ((a ^ 0x800000) + rng.integers(-3, 4, n)) & 0xFFFFFF, b).astype(np.uint32)
    c = np.where(kind != 0, near(a, -42, 5)(c), c)
    sparse = np.uint32(0xFF0000) | np.uint32(1) << rng.integers(0, 16, n, dtype=np.uint32)
    a, b, c = (np.where(kind == 3, v & sparse | rng.integers(0, 2, n, dtype=np.uint32), v) for v in (a, b, c))
    order = rng.permuted(np.tile(np.arange(3), (n, 1)), axis=1)       # the small one may stand anywhere
    return [np.choose(order[:, k], (a, b, c)) for k in range(3)]


def test_special_triples():
    """Every combination of 70 special values in three operands."""
    a, b, c = (v.ravel() for v in np.meshgrid(SPECIAL, SPECIAL, SPECIAL))
    compare(a, b, c)


def test_exponent_differences(seed):
    """Every pair of exponent fields; the third operand at every distance from the larger."""
    rng = np.random.default_rng(seed)
    pairs = np.array(list(itertools.product(range(128), range(128))))
    for _ in range(6):
        ea, eb = pairs.T
        ec = rng.permutation(pairs)[:, 0]
        sm = [rng.integers(0, 2, len(pairs)) << 23 | rng.choice([0, 0xFFFF, 1, 0x8000, -1], len(pairs)) for _ in range(3)]
        ops = [s & 0x800000 | e << 16 | np.where(s < 0, rng.integers(0, 1 << 16, len(pairs)), s & 0xFFFF)
               for s, e in zip(sm, (ea, eb, ec))]
        compare(*ops)


def test_random_operands(seed):
    """Random operands against the model, and add, mul and div against apytypes; divider error in ulp."""
    print(f"seed {seed}, {PAIRS} operands")
    rng, worst = np.random.default_rng(seed), 0.0
    for lo in range(0, PAIRS, BLOCK):
        a, b, c = random_operands(rng, min(BLOCK, PAIRS - lo))
        got = compare(a, b, c)
        with np.errstate(all="ignore"):
            for op in ("add", "mul", "div"):
                want = apy(op, a, b)
                bad = np.flatnonzero(got[op] != want)
                assert not bad.size, (f"{op}: {bad.size} results differ from apytypes, first a={a[bad[0]]:06x} "
                                      f"b={b[bad[0]]:06x}: RTL {got[op][bad[0]]:06x}, apytypes {want[bad[0]]:06x}")
            x, y = fp24.from_bits(a) / fp24.from_bits(b), fp24.from_bits(got["div"])
            normal = np.isfinite(y) & (y != 0)
            ulp = np.ldexp(1.0, np.frexp(y[normal])[1] - 17)
            worst = max(worst, np.max(np.abs(x - y)[normal] / ulp))
    print(f"div: worst error {worst:.6f} ulp")
    assert worst <= 0.5


def test_add3_against_integers(seed):
    """add3 against integers of unlimited size, most operands close to cancelling."""
    rng = np.random.default_rng(seed)
    ops = random_operands(rng, 120_000)
    finite = np.all([(v >> 16 & 0x7F) != 127 for v in ops], axis=0)
    a, b, c = (v[finite] for v in ops)
    got = run_units(a, b, c)["add3"]
    for i, (x, y, z) in enumerate(zip(a.tolist(), b.tolist(), c.tolist())):
        assert got[i] == add3_exact(x, y, z), f"{x:06x} + {y:06x} + {z:06x}: RTL {got[i]:06x}, exact {add3_exact(x, y, z):06x}"


def test_one_operand_units_on_all_inputs():
    """sqrt and conversions on all 2^24 patterns; error of sqrt against double precision, monotonicity, exact squares."""
    a = np.arange(1 << 24, dtype=np.uint32)
    zero = np.zeros_like(a)
    got = compare(a, zero, zero, only=("sqrt", "from_sint", "from_ufix", "unorm8", "unorm10"))
    lo, hi = 0x010000, 0x7F0000                                       # the positive normal numbers, in order
    x, y = fp24.from_bits(a[lo:hi]), fp24.from_bits(got["sqrt"][lo:hi])
    exact = np.sqrt(x)
    error = np.abs(y - exact) / np.ldexp(1.0, np.frexp(exact)[1] - 17)
    print(f"sqrt: worst error {error.max():.6f} ulp at {lo + error.argmax():06x}, "
          f"{np.mean(y != fp24.rnd_any(exact, 7, 16)):.4%} not correctly rounded")
    assert error.max() < 0.58
    assert np.all(np.diff(y) >= 0)
    square = fp24.rnd_any(exact, 7, 16) == exact
    # Roots with 8 fraction bits in [1, sqrt 2), 7 in [sqrt 2, 2): 107 + 74, for each of 63 pairs of exponents.
    assert square.sum() == 63 * (107 + 74) and np.array_equal(y[square], exact[square])
    # unorm against its definition in integers: floor(x * top + 1/2), x = m * 2^(e - 79)
    e, m = a.astype(np.int64) >> 16 & 0x7F, a.astype(np.int64) & 0xFFFF | 0x10000
    for port, top in (("unorm8", 255), ("unorm10", 1023)):
        shift = np.clip(79 - e, 1, 40)
        want = (m * top + (1 << (shift - 1))) >> shift
        want = np.where(e >= 63, top, want)
        want = np.where((a >> 23 == 1) | (e == 0) | (e == 127) & (m != 0x10000), 0, want)
        assert np.array_equal(got[port], want.astype(np.uint32))


# ---- power -----------------------------------------------------------------------------------------------------------

ONE, TWO, INF, NAN = 0x3F0000, 0x400000, 0x7F0000, 0x7F8000
FEW = 1.31                                          # units of 2^-17: see docs/fp.md


def power_operands(rng, n):
    """Pairs of patterns for a^b, half with a in (0, 1], half with a in [1, 2^16]; exponents of every size, a third at most 1024
    and so that the result is in the normal range."""
    a = rng.integers(0x010000, ONE + 1, n, dtype=np.uint32)
    near = ONE - (2.0 ** rng.uniform(0, 17, n)).astype(np.uint32)
    a = np.where(rng.random(n) < 0.5, near, a)
    up = (2.0 ** rng.uniform(0, 20, n)).astype(np.uint32) - 1 + ONE
    a = np.where(rng.random(n) < 0.5, up, a).astype(np.uint32)
    b = rng.integers(0, INF + 1, n, dtype=np.uint32)
    log = np.abs(np.log2(np.maximum(fp24.from_bits(a), 2.0**-62)))
    fits = rng.random(n) * np.minimum(1024, 62 / np.maximum(log, 1e-9))
    fits = fp24.to_bits(fp24.rnd_any(fits, 7, 16))
    return a, np.where(rng.random(n) < 0.34, fits, b).astype(np.uint32)


def power_error(a, b, y):
    """Errors of y = a^b, patterns, in units of 2^-17 of the result, where that is in the normal range; a and b there."""
    a, b, y = (fp24.from_bits(v) for v in (a, b, y))
    with np.errstate(all="ignore"):
        exact = np.power(a, b)                                        # in double precision
    normal = (exact >= 2.0**-62) & (exact <= fp24.MAX_FINITE)
    a, b, y, exact = (v[normal] for v in (a, b, y, exact))
    return np.abs(y / exact - 1) * 2.0**17, a, b


def test_power_special_values():
    """The cases that docs/fp.md lists, for every size of the other operand."""
    rng = np.random.default_rng(11)
    n = 1000
    positive = np.concatenate([SPECIAL[(SPECIAL >= MIN) & (SPECIAL < INF)], rng.integers(MIN, INF, n, dtype=np.uint32)])
    less, more = positive[positive < ONE], positive[positive > ONE]
    tiny = np.array([0, 1, 0xFFFF, 0x800000, 0x80FFFF], dtype=np.uint32)                # all are zero
    nans = np.array([0x7F0001, NAN, 0x7FFFFF, 0xFF0001, 0xFFFFFF], dtype=np.uint32)
    any_b = np.concatenate([tiny, positive, [np.uint32(INF)]])
    negative = positive | 0x800000
    whole = np.array([int(v) for v in fp24.to_bits(np.arange(1.0, 63.0))], dtype=np.uint32)
    for name, a, b, want in (
        ("a^0", any_b, tiny, ONE), ("1^b", [ONE], any_b, ONE),
        ("0^b", tiny, [*positive, INF], 0), ("inf^b", [INF], [*positive, INF], INF),
        ("less^inf", less, [INF], 0), ("more^inf", more, [INF], INF),
        ("less^2^23", less, [0x560000], 0), ("more^2^23", more, [0x560000], INF),
        ("nan^b", nans, [*any_b, *nans, *negative], NAN), ("a^nan", [*any_b, *negative], nans, NAN),
        ("negative^b", [*negative, 0xFF0000], any_b, NAN), ("a^negative", any_b, [*negative, 0xFF0000], NAN),
        ("half^whole", [0x3E0000], whole, ONE - (np.arange(1, 63, dtype=np.uint32) << 16)),
        ("two^whole", [TWO], whole, ONE + (np.arange(1, 63, dtype=np.uint32) << 16)),
    ):
        x, y = (v.ravel() for v in np.meshgrid(np.asarray(a, dtype=np.uint32), np.asarray(b, dtype=np.uint32)))
        got = run_units(x, y)["pow"]
        bad = np.flatnonzero(got != want)
        assert not bad.size, f"{name}: {x[bad[0]]:06x}^{y[bad[0]]:06x} is {got[bad[0]]:06x}"
    got = run_units(positive, np.full_like(positive, ONE))["pow"]
    assert np.array_equal(got, positive), "a^1 is not a"


def test_power_of_all_numbers_to_one(seed):
    """All a in (0, 1] whose power is in the normal range or just below it, for several b: error, monotonicity."""
    rng = np.random.default_rng(seed)
    bs = [0.5, 1.0, 2.0, rng.uniform(2, 8), rng.uniform(8, 64), rng.uniform(64, 512), rng.uniform(512, 1024), 1024.0]
    for b in fp24.rnd_any(np.array(bs), 7, 16):
        lo = int(fp24.to_bits(fp24.rnd_any(np.array([2.0 ** max(-62, -65 / b)]), 7, 16))[0])
        a = np.arange(lo, ONE + 1, dtype=np.uint32)
        b_bits = np.full_like(a, fp24.to_bits(np.array([b]))[0])
        y = compare(a, b_bits, b_bits, only=("pow",))["pow"]
        error, x, _ = power_error(a, b_bits, y)
        print(f"a^{b:.6g}: {error.size} in the normal range, worst error {error.max():.3f} 2^-17 at a = {x[error.argmax()]!r}")
        assert error.max() < min(2.0, FEW + b / 3000)
        assert np.all(np.diff(y.astype(np.int64)) >= 0), f"a^{b} is not monotone in a"


def test_power_of_random_pairs(seed):
    """Random pairs against the model and double precision; monotone in both operands."""
    rng = np.random.default_rng(seed)
    worst_below, worst_above = 0.0, 0.0
    for lo in range(0, PAIRS, BLOCK):
        n = min(BLOCK, PAIRS - lo)
        a, b = power_operands(rng, n)
        y = compare(a, b, b, only=("pow",))["pow"]
        error, x, e = power_error(a, b, y)
        assert error.size > n // 4
        assert np.all(error[x <= 1] < FEW + e[x <= 1] / 3000) and np.all(error[x > 1] < FEW + e[x > 1] / 840)
        usual = e <= 1024
        worst_below = max(worst_below, error[usual & (x <= 1)].max())
        worst_above = max(worst_above, error[usual & (x > 1)].max())
        up_a, up_b = (run_units(a + i, b + j)["pow"].astype(np.int64) for i, j in ((1, 0), (0, 1)))
        y = y.astype(np.int64)
        grows = np.where(a >= ONE, up_b >= y, up_b <= y) | (b >= INF - 1)
        assert np.all(up_a >= y) and np.all(grows), "not monotone"
    print(f"pow: worst error for b <= 1024 {worst_below:.3f} 2^-17 for a <= 1, {worst_above:.3f} 2^-17 above 1")
    assert worst_below < 2 and worst_above < 4


def power_ties():
    """Pairs (2^k, b) whose result lies on a tie of the last rounding, or one unit of its last fraction bit beside it."""
    _, _, nodes = fp24.pow_tables()
    place = np.arange(1 << 14)
    a, b = [], []
    k, m = (v.ravel() for v in np.meshgrid(np.arange(1, 63), np.arange(-3, 7)))
    for j in range(256):
        y = (nodes[j] << 14) + (nodes[j + 1] - nodes[j]) * place
        for frac in j << 14 | np.flatnonzero(np.abs((y & 0x3FFFF) - 0x20000) < 2):      # fraction, 22 bits
            for t in frac + (np.arange(62) << 22):
                sig = -(-t * 2.0**m // k).astype(np.int64)                           # k sig 2^-m is t and less than 1 more
                ok = (sig >= 1 << 16) & (sig < 1 << 17) & (np.floor(k * sig * 2.0**-m) == t)
                if ok.any():
                    i = np.flatnonzero(ok)[0]
                    a.append(63 + k[i] << 16)
                    b.append((63 + 16 - 22 - m[i] << 16) + sig[i] - (1 << 16))
                    break
    return np.array(a, dtype=np.uint32), np.array(b, dtype=np.uint32)


def test_power_on_ties():
    """Rounding where it is closest: a tie, or just above or below one, with an even and an odd last place."""
    a, b = power_ties()
    print(f"{a.size} pairs")
    assert a.size > 50
    compare(a, b, b, only=("pow",))


def test_small_format_on_all_triples():
    """The same RTL as a 1-3-4 format: all 2^24 triples, hence all pairs."""
    i = np.arange(1 << 24, dtype=np.uint32)
    compare(i & 255, i >> 8 & 255, i >> 16, exp_w=3, man_w=4)


def test_wide_range_in_eight_bits(seed):
    """The same RTL as a 1-5-2 format, where operands of add3 leave its window: random triples, all from 10 million on."""
    if PAIRS >= 10_000_000:
        i = np.arange(1 << 24, dtype=np.uint32)
    else:
        i = np.random.default_rng(seed).integers(0, 1 << 24, min(PAIRS, 500_000), dtype=np.uint32)
    compare(i & 255, i >> 8 & 255, i >> 16, exp_w=5, man_w=2)


@pytest.mark.parametrize("latency", [1, 3, 4, 6, 25])
def test_latency_changes_no_result(seed, latency):
    """Shallower and deeper pipelines give the same numbers."""
    rng = np.random.default_rng(seed)
    compare(*random_operands(rng, 50_000), latency=latency)
    a, b = power_operands(rng, 50_000)
    compare(a, b, b, latency=latency, only=("pow",))


# ---- latency and throughput, cycle by cycle --------------------------------------------------------------------------

PAPER_LATENCY = {"add": 2, "add3": 2, "mul": 1, "cmp": 1, "div": 2, "sqrt": 2,
                 "from_sint": 1, "from_ufix": 1, "unorm8": 1, "unorm10": 1, "pow": 5}


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(unit=list(PORTS))
async def latency_and_throughput(dut, unit):
    """New operands every cycle: after exactly the latency, each result stands at the output for exactly one cycle."""
    latency = int(dut.Latency.value) or PAPER_LATENCY[unit]
    ops = [np.asarray(v) for v in random_operands(np.random.default_rng(7), 64)]
    ops[0][:24] = (np.arange(24) % 2 * 0x3F0000)                      # changes every cycle, in every unit
    want = model(*ops)[unit]
    Clock(dut.clk_i, 10, unit="ns").start()
    for i in range(64 + latency):
        await FallingEdge(dut.clk_i)
        if i >= latency:
            value = getattr(dut, f"{unit}_o").value.to_unsigned()
            assert value == want[i - latency], f"{unit}, operands {i - latency}: {value:06x} instead of {want[i - latency]:06x}"
        j = min(i, 63)
        dut.a_i.value, dut.b_i.value, dut.c_i.value = (int(v[j]) for v in ops)


@pytest.mark.parametrize("latency", [0, 5])
def test_latency(latency):
    """Each unit takes its default latency (the paper's) or the one it is given, with a result in every cycle."""
    run_cocotb("rc_fp_all", [*sources(), HERE / "rc_fp_all.sv"], "test_rc_fp", parameters={"Latency": latency})
