# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What the FP units should return: the model, and oracles that share nothing with it (apytypes, big integers)."""

from __future__ import annotations

import numpy as np
from apytypes import APyFloatArray

from raycore.model import fp24

NAN, INF, MIN_NORMAL = 0x7F8000, 0x7F0000, 0x010000


def cmp_bits(x, y):
    """lt, eq, gt as bits 2, 1, 0."""
    return ((x < y) * 4 + (x == y) * 2 + (x > y)).astype(np.uint32)


def model(a, b, c, exp_w: int = 7, man_w: int = 16) -> dict[str, np.ndarray]:
    """Results of every port of rc_fp_all by raycore.model.fp24, for arrays of bit patterns."""
    full, w = (exp_w, man_w) == (7, 16), 1 + exp_w + man_w
    x, y, z = (fp24.from_bits(v, exp_w, man_w) for v in (a, b, c))
    signed = a.astype(np.int64) - ((a.astype(np.int64) >> (w - 1)) << w)
    with np.errstate(all="ignore"):
        if full:
            real = {"add": fp24.add(x, y), "add3": fp24.add3(x, y, z), "mul": fp24.mul(x, y), "div": fp24.div(x, y),
                    "sqrt": fp24.sqrt(x)}
        else:   # sums, products and quotients of small numbers fit a double, or round twice harmlessly
            real = {"add": x + y, "add3": x + y + z, "mul": x * y, "div": x / y,
                    "sqrt": fp24.sqrt_any(x, exp_w, man_w)}
        real["pow"] = fp24.power(x, y) if full else np.zeros(len(x))       # rc_fp_all has it at full width only
        real |= {"from_sint": signed.astype(float), "from_ufix": a / 32.0}
        bits = {k: fp24.to_bits(fp24.rnd_any(v, exp_w, man_w), exp_w, man_w) for k, v in real.items()}
        return bits | {"cmp": cmp_bits(x, y), "unorm8": fp24.unorm(x, 8).astype(np.uint32),
                       "unorm10": fp24.unorm(x, 10).astype(np.uint32)}


def apy(op: str, a, b) -> np.ndarray:
    """add, mul or div by apytypes, which has gradual underflow: operands and results are flushed here.

    One case is decided apart: apytypes rounds a result just below the smallest normal number with the precision of a
    subnormal, the units with that of a normal number, before they look at the exponent.
    """
    def flush(v):
        return np.where((v >> 16) & 0x7F == 0, v & 0x800000, v).astype(np.uint64)

    x, y = (APyFloatArray.from_bits(flush(v), 7, 16) for v in (a, b))
    z = {"add": lambda: x + y, "mul": lambda: x * y, "div": lambda: x / y}[op]()
    bits = np.asarray(z.to_bits(numpy=True)).astype(np.uint32)
    nan = ((bits & INF) == INF) & ((bits & 0xFFFF) != 0)
    bits = np.where(nan, NAN, flush(bits).astype(np.uint32))
    edge = np.flatnonzero((bits & 0x7FFFFF) == MIN_NORMAL)
    p, q = (fp24.from_bits(v[edge]) for v in (a, b))
    exact = np.abs({"add": np.add, "mul": np.multiply, "div": np.divide}[op](p, q))   # a double holds enough of it
    bits[edge] = np.where(exact < 2.0**-62 - 2.0**-80, bits[edge] & 0x800000, bits[edge])
    return bits


def add3_exact(a: int, b: int, c: int) -> int:
    """add3 of finite patterns by integers of unlimited size."""
    total = 0
    for v in (a, b, c):
        e, m = (v >> 16) & 0x7F, v & 0xFFFF
        total += 0 if e == 0 else (-1) ** (v >> 23) * ((0x10000 | m) << (e - 1))   # in units of 2^-78
    if total == 0:
        return (a & b & c) & 0x800000
    sign, mag = (0x800000, -total) if total < 0 else (0, total)
    drop = mag.bit_length() - 17
    if drop <= 0:
        mag, e = mag << -drop, 1 + drop
    else:
        rest, half = mag & ((1 << drop) - 1), 1 << (drop - 1)
        mag, e = mag >> drop, 1 + drop
        mag += rest > half or (rest == half and mag & 1)
        if mag >> 17:
            mag, e = mag >> 1, e + 1
    if e < 1:
        return sign
    return sign | INF if e >= 127 else sign | e << 16 | (mag & 0xFFFF)
