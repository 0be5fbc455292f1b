# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""FP24 arithmetic, bit for bit what `rtl/fp/` computes (paper Sec. 4.1 and Table I).

A number is {sign, 7 exponent bits, 16 fraction bits}, bias 63. Subnormals do not exist: a result whose exponent field,
after rounding with an unbounded exponent, would be 0 or less is a zero with the result's sign. Field 127 holds infinity
(fraction 0) and NaN. Rounding is to nearest, ties to even.

Values are float64 that hold an FP24 number exactly; every function here expects such operands and returns such a result,
so a comparison is the plain comparison of the two float64 (false with NaN, and -0 == +0).

Three layers:

* scalar functions compiled by numba (`fadd`, `fmul`, ...), to be called from other compiled loops;
* the same on arrays, as ufuncs (`add`, `mul`, ...), and conversions to and from bit patterns (`to_bits`, `from_bits`);
* `*_any`, on arrays and for any split of exponent and fraction bits up to FP24, for tests at small widths.

Why float64 suffices: a double carries 53 >= 2 * 17 + 2 bits, hence rounding the double sum, product or quotient of two
FP24 numbers once more gives the correctly rounded FP24 result (Figueroa 1995). A sum of three needs the care of `fadd3`.

numba caches compiled callers without noticing a change in this file: delete `__pycache__` after editing it.
"""

import decimal
import math

import numpy as np
from numba import njit, vectorize

EXP_W = 7  # exponent bits
MAN_W = 16  # fraction bits
BIAS = 63
NAN_BITS = 0x7F8000  # the only NaN that a unit produces
INF_BITS = 0x7F0000
MIN_NORMAL = 2.0**-62
MAX_FINITE = (2.0 - 2.0**-16) * 2.0**63

SQRT_TAB_W = 8  # fraction bits that select an entry of the square root table
SQRT_GUARD_W = 4  # fraction bits of a table entry beyond the result's

POW_LOG_W = 7  # fraction bits that select an entry of the logarithm's table
POW_LOG_FRAC_W = 30  # fraction bits of the logarithm
POW_EXP_W = 8  # fraction bits that select an entry of the exponential's table
POW_EXP_POS_W = 14  # and that tell the place between two nodes
POW_NODE_W = 20  # fraction bits of a node of the exponential
POW_BIG = 23  # b >= 2^POW_BIG is out of range for every a but 1

_DROP = 52 - MAN_W  # fraction bits of a double beyond FP24's
_HALF = (1 << (_DROP - 1)) - 1
_KEEP = ~((1 << _DROP) - 1)
_OVERFLOW = 2.0**64


# ---- scalars, for compiled loops -------------------------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def _bits64(x):
    return np.float64(x).view(np.int64)


@njit(cache=True, error_model="numpy")
def _float64(u):
    return np.int64(u).view(np.float64)


@njit(cache=True, error_model="numpy")
def rnd(x):
    """Round any double to FP24: nearest even, overflow to infinity, underflow (after rounding) to a signed zero."""
    u = _bits64(x)
    r = _float64((u + _HALF + ((u >> _DROP) & 1)) & _KEEP)
    a = abs(r)
    if a < MIN_NORMAL:
        return math.copysign(0.0, x)
    if a >= _OVERFLOW:
        return math.copysign(math.inf, x)
    if x != x:
        return math.nan
    return r


@njit(cache=True, error_model="numpy")
def fadd(a, b):
    """a + b, correctly rounded (error <= 1/2 ulp). x - x = +0, inf - inf = NaN."""
    return rnd(a + b)


@njit(cache=True, error_model="numpy")
def fsub(a, b):
    """a - b, correctly rounded (error <= 1/2 ulp)."""
    return rnd(a - b)


@njit(cache=True, error_model="numpy")
def fmul(a, b):
    """a * b, correctly rounded (error <= 1/2 ulp). 0 * inf = NaN."""
    return rnd(a * b)


@njit(cache=True, error_model="numpy")
def fdiv(a, b):
    """a / b, correctly rounded (error <= 1/2 ulp). x / 0 is a signed infinity; 0 / 0 and inf / inf are NaN."""
    return rnd(a / b)


@njit(cache=True, error_model="numpy")
def _add_odd(x, y):
    """x + y as a double, rounded to odd: exact, or the neighbour of the exact sum whose last bit is 1."""
    s = x + y
    t = s - x
    e = (x - (s - t)) + (y - t)  # Knuth's TwoSum: s + e is the exact sum
    if e != 0.0:
        u = _bits64(s)
        if u & 1 == 0:
            s = _float64(u + 1 if (e > 0.0) == (s > 0.0) else u - 1)
    return s


@njit(cache=True, error_model="numpy")
def fadd3(a, b, c):
    """a + b + c with one rounding of the exact sum (error <= 1/2 ulp); order of operands does not matter.

    An exact sum of zero is +0 unless all three operands are -0. Method: two TwoSums leave a double and two errors; these
    are joined by sums rounded to odd, which lose nothing that the last rounding needs (Boldo and Melquiond 2008).
    """
    h = a + b
    t = h - a
    e1 = (a - (h - t)) + (b - t)
    s = h + c
    t = s - h
    e2 = (h - (s - t)) + (c - t)
    if e1 == 0.0 and e2 == 0.0:
        return rnd(s)
    if e1 != e1 or e2 != e2:  # an infinity or a NaN among the operands
        return rnd(s)
    return rnd(_add_odd(s, _add_odd(e1, e2)))


def sqrt_table(man_w=MAN_W, tab_w=SQRT_TAB_W, guard_w=SQRT_GUARD_W):
    """Nodes of the square root table: 2^(tab_w + 1) + 1 integers with man_w + guard_w fraction bits, rounded to nearest.

    Node i is sqrt(u_i). The first half covers u in [1, 2), u_i = 1 + i / 2^tab_w (even exponent); the second u in [2, 4],
    u_i = 2 * (1 + (i - 2^tab_w) / 2^tab_w) (odd exponent). The RTL computes the same integers at elaboration.
    """
    n, frac = 1 << tab_w, man_w + guard_w
    nodes = []
    for i in range(2 * n + 1):
        scaled = (n + i) << (2 * frac - tab_w) if i < n else (2 * i) << (2 * frac - tab_w)
        root = math.isqrt(scaled)
        nodes.append(root + (scaled > root * root + root))  # nearest; a tie cannot happen
    return np.array(nodes, dtype=np.int64)


_SQRT = sqrt_table()
_SQRT_FRAC_W = MAN_W - SQRT_TAB_W


@njit(cache=True, error_model="numpy")
def fsqrt(x):
    """Square root by a table with linear interpolation between two adjacent entries (paper Sec. 4.1).

    Error <= 0.58 ulp (proof and measurement in docs/fp.md); monotone; exact wherever the root is an FP24 number.
    sqrt(-0) = -0, sqrt(x < 0) = NaN.
    """
    if not x > 0.0:
        return x if x == 0.0 else math.nan
    if x == math.inf:
        return x
    u = _bits64(x)
    e = (u >> 52) - 1023
    i = ((e & 1) << SQRT_TAB_W) | ((u >> (52 - SQRT_TAB_W)) & ((1 << SQRT_TAB_W) - 1))
    f = (u >> _DROP) & ((1 << _SQRT_FRAC_W) - 1)
    y = (_SQRT[i] << _SQRT_FRAC_W) + (_SQRT[i + 1] - _SQRT[i]) * f
    shift = SQRT_GUARD_W + _SQRT_FRAC_W
    y = (y + (1 << (shift - 1))) >> shift  # [2^16, 2^17]
    return _float64(((e >> 1) + 1022 << 52) + (y << _DROP))  # the leading one of y adds 1 to the exponent


def pow_tables():
    """Tables of `fpow`: nodes of log2(1 + i / 128), 129 integers; how far the logarithm is above the line in the middle between
    two nodes, 128; nodes of 2^(j / 256), 257. Each is the exact value, rounded to nearest, with POW_LOG_FRAC_W, again that, and
    POW_NODE_W fraction bits. The RTL computes the same integers at elaboration, in another way.
    """
    with decimal.localcontext(decimal.Context(prec=40)):
        ln2, n, m = decimal.Decimal(2).ln(), 1 << POW_LOG_W, 1 << POW_EXP_W
        logs = [(1 + decimal.Decimal(i) / (2 * n)).ln() / ln2 * 2**POW_LOG_FRAC_W for i in range(2 * n + 1)]
        bulges = [logs[2 * i + 1] - (logs[2 * i] + logs[2 * i + 2]) / 2 for i in range(n)]
        exps = [(ln2 * j / m).exp() * 2**POW_NODE_W for j in range(m + 1)]
        return tuple(np.array([round(v) for v in values], dtype=np.int64) for values in (logs[::2], bulges, exps))


_POW_LOG, _POW_BULGE, _POW_EXP = pow_tables()


@njit(cache=True, error_model="numpy")
def fpow(a, b):
    """a^b for a, b >= 0 as 2^(b log2 a), by a table with parabolas for the logarithm and one with lines for the exponential.

    Relative error of a result in the normal range for a <= 1: below 2^-17 (1.31 + b / 3000), hence 2^-16 for b <= 1024 (proof
    and measurement in docs/fp.md). Monotone in a and in b. a^0 = 1 and 1^b = 1, whatever a and b; a^1 = a; 0^b = 0 and
    inf^b = inf for b > 0; a^inf = 0 for a < 1, inf for a > 1. NaN if an operand is NaN or below 0.
    """
    if not (a >= 0.0 and b >= 0.0):
        return math.nan
    if b == 0.0:
        return 1.0
    if a == 0.0 or a == math.inf:
        return a if a > 0.0 else 0.0
    u = _bits64(a)
    pos_w = MAN_W - POW_LOG_W
    i, pos = (u >> (52 - POW_LOG_W)) & ((1 << POW_LOG_W) - 1), (u >> _DROP) & ((1 << pos_w) - 1)
    bow = pos * ((1 << pos_w) - pos)  # 2^16 in the middle
    log = (_POW_LOG[i] << 16) + ((_POW_LOG[i + 1] - _POW_LOG[i]) * pos << (16 - pos_w)) + _POW_BULGE[i] * bow
    log = (((u >> 52) - 1023) << POW_LOG_FRAC_W) + (log >> 16)
    if log == 0:
        return 1.0
    v = _bits64(b)
    e = (v >> 52) - 1023
    if e >= POW_BIG:
        return 0.0 if log < 0 else math.inf
    frac_w = POW_EXP_W + POW_EXP_POS_W
    power = log * (1 << MAN_W | (v >> _DROP) & ((1 << MAN_W) - 1)) >> min(POW_LOG_FRAC_W + MAN_W - frac_w - e, 63)
    n = power >> frac_w
    if n < -(BIAS + 1) or n > BIAS:
        return 0.0 if n < 0 else math.inf
    j, pos = (power >> POW_EXP_POS_W) & ((1 << POW_EXP_W) - 1), power & ((1 << POW_EXP_POS_W) - 1)
    y = (_POW_EXP[j] << POW_EXP_POS_W) + (_POW_EXP[j + 1] - _POW_EXP[j]) * pos
    return rnd(math.ldexp(float(y), n - POW_NODE_W - POW_EXP_POS_W))


@njit(cache=True, error_model="numpy")
def ulp_add(x, n):
    """x moved up by n units in the last place (down for n < 0), as the RTL does it: by an integer added to the pattern.

    The magnitude pattern {exponent, fraction} of x > 0 grows by n, that of x < 0 shrinks by n. It saturates at zero
    (the sign of x stays: zero is never crossed) and at infinity. Patterns below the smallest normal number read as zero,
    so a zero has pattern 0 and stays zero for n < 2^16. Infinities and NaN come back unchanged.
    """
    a = abs(x)
    if not a < math.inf:
        return x
    negative = math.copysign(1.0, x) < 0.0
    p = np.int64(0)
    if a != 0.0:
        p = (_bits64(a) >> _DROP) - ((1023 - BIAS) << MAN_W)
    p = p - n if negative else p + n
    if p < (1 << MAN_W):
        r = 0.0
    elif p >= INF_BITS:
        r = math.inf
    else:
        r = _float64((p + ((1023 - BIAS) << MAN_W)) << _DROP)
    return -r if negative else r


@njit(cache=True, error_model="numpy")
def from_int(i):
    """Integer, |i| < 2^53, to FP24 (error <= 1/2 ulp)."""
    return rnd(float(i))


@njit(cache=True, error_model="numpy")
def to_uint(x, bits):
    """FP24 to an unsigned integer of `bits` <= 32 bits: rounded half up, clamped to [0, 2^bits - 1]; NaN gives 0."""
    top = float((1 << bits) - 1)
    if not x > 0.0:
        return np.int64(0)
    return np.int64(math.floor(min(x, top) + 0.5))


@njit(cache=True, error_model="numpy")
def to_unorm(x, bits):
    """FP24 in [0, 1] to an unsigned normalised integer: floor(x * (2^bits - 1) + 1/2), exact; clamped; NaN gives 0."""
    if not x > 0.0:
        return np.int64(0)
    return np.int64(math.floor(min(x, 1.0) * float((1 << bits) - 1) + 0.5))


@njit(cache=True, error_model="numpy")
def to_unorm8(x):
    """`to_unorm` to 8 bits: a colour channel of the frame buffer."""
    return to_unorm(x, 8)


# ---- arrays ----------------------------------------------------------------------------------------------------------


@vectorize(cache=True)
def round_to_fp24(x):
    """`rnd` on arrays: float64 of any value to the nearest FP24 number."""
    return rnd(x)


@vectorize(cache=True)
def add(a, b):
    """`fadd` on arrays."""
    return fadd(a, b)


@vectorize(cache=True)
def sub(a, b):
    """`fsub` on arrays."""
    return fsub(a, b)


@vectorize(cache=True)
def add3(a, b, c):
    """`fadd3` on arrays."""
    return fadd3(a, b, c)


@vectorize(cache=True)
def mul(a, b):
    """`fmul` on arrays."""
    return fmul(a, b)


@vectorize(cache=True)
def div(a, b):
    """`fdiv` on arrays."""
    return fdiv(a, b)


@vectorize(cache=True)
def sqrt(x):
    """`fsqrt` on arrays."""
    return fsqrt(x)


@vectorize(cache=True)
def power(a, b):
    """`fpow` on arrays."""
    return fpow(a, b)


@vectorize(cache=True)
def unorm(x, bits):
    """`to_unorm` on arrays."""
    return to_unorm(x, bits)


def to_bits(x, exp_w=EXP_W, man_w=MAN_W):
    """Bit patterns, uint32, of an array of float64 that hold FP24 numbers (or those of a smaller format). NaN is canonical.

    Raises: ValueError if a value is not representable; round it first.
    """
    x = np.asarray(x, dtype=np.float64)
    bias, drop = (1 << (exp_w - 1)) - 1, 52 - man_w
    u = x.view(np.uint64) if x.flags.c_contiguous else x.copy().view(np.uint64)
    sign = u >> np.uint64(63) << np.uint64(exp_w + man_w)
    mag = u & np.uint64((1 << 63) - 1)
    field = (mag >> np.uint64(drop)).astype(np.int64) - ((1023 - bias) << man_w)
    inf = ((1 << exp_w) - 1) << man_w
    special = ~np.isfinite(x)
    lossy = (mag & np.uint64((1 << drop) - 1)) != 0
    bad = ~special & (x != 0) & (lossy | (field < (1 << man_w)) | (field >= inf))
    if np.any(bad):
        raise ValueError(f"{x[bad].flat[0]!r} is not an FP24 number: round it first")
    field = np.where(x == 0, 0, np.where(special, inf, field))
    bits = np.where(np.isnan(x), inf | (1 << (man_w - 1)), field.astype(np.uint64) | sign)
    return bits.astype(np.uint32)


def from_bits(bits, exp_w=EXP_W, man_w=MAN_W):
    """float64 array of the values of bit patterns; patterns with exponent 0 are zeros, as the units read them."""
    bits = np.asarray(bits).astype(np.int64)
    bias = (1 << (exp_w - 1)) - 1
    e = (bits >> man_w) & ((1 << exp_w) - 1)
    m = bits & ((1 << man_w) - 1)
    mag = ((e + 1023 - bias) << 52) | (m << (52 - man_w))
    special = ((0x7FF << 52) | (m != 0).astype(np.int64) << 51).astype(np.int64)
    mag = np.where(e == 0, 0, np.where(e == (1 << exp_w) - 1, special, mag))
    sign = (bits >> (exp_w + man_w)) & 1
    sign = np.where(np.isnan(mag.view(np.float64)), 0, sign)
    return (mag | sign << 63).view(np.float64)


# ---- any width -------------------------------------------------------------------------------------------------------


def rnd_any(x, exp_w, man_w):
    """Round float64 arrays to 1-exp_w-man_w by the rules of FP24. Exact for what fits a double."""
    x = np.asarray(x, dtype=np.float64)
    bias = (1 << (exp_w - 1)) - 1
    m, e = np.frexp(x)  # |m| in [1/2, 1)
    r = np.ldexp(np.rint(np.ldexp(m, man_w + 1)), e - man_w - 1)
    r = np.where(np.abs(r) < 2.0 ** (1 - bias), np.copysign(0.0, x), r)
    r = np.where(np.abs(r) >= 2.0 ** (bias + 1), np.copysign(np.inf, x), r)
    return np.where(np.isnan(x), np.nan, r)


def sqrt_any(x, exp_w, man_w, tab_w=SQRT_TAB_W, guard_w=SQRT_GUARD_W):
    """`fsqrt` on arrays for 1-exp_w-man_w; a format with fewer than tab_w fraction bits looks its root up directly."""
    x = np.asarray(x, dtype=np.float64)
    tab_w = min(tab_w, man_w)
    table, frac_w = sqrt_table(man_w, tab_w, guard_w), man_w - tab_w
    ok = (x > 0) & (x < np.inf)
    m, e = np.frexp(np.where(ok, x, 1.0))
    e = e - 1
    man = np.ldexp(m, man_w + 1).astype(np.int64) - (1 << man_w)
    i = ((e & 1) << tab_w) | (man >> frac_w)
    y = (table[i] << frac_w) + (table[i + 1] - table[i]) * (man & ((1 << frac_w) - 1))
    shift = guard_w + frac_w
    y = (y + (1 << (shift - 1))) >> shift
    r = rnd_any(np.ldexp(y.astype(np.float64), (e >> 1) - man_w), exp_w, man_w)
    return np.where(ok, r, np.where((x == 0) | (x == np.inf), x, np.nan))
