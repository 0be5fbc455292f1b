# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_accel against raycore.model.accel: every row of every triangle, bit for bit, with waits on every port."""

import os
import random
from types import SimpleNamespace

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore import accel, image, tbu, triaccel
from raycore.model import accel as model
from raycore.model import fp24
from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl("prim/rc_fifo.sv", "prim/rc_delay.sv", "fp/rc_fp_pipe.sv", "fp/rc_fp_norm.sv", "fp/rc_fp_round.sv", "fp/rc_fp_add.sv",
              "tbu/rc_tbu_fix.sv", *(f"accel/rc_accel{n}.sv" for n in ("_pkg", "_lane", "_root", "_cross", "_proj", "_norm",
              "_fetch", "")))  # fmt: skip
CFG = (("vertex_base", 26), ("attr_base", 26), ("accel_base", 26), ("info_base", 26), ("tri_count", 24),
       ("eye_z", 16), ("eye_y", 16), ("eye_x", 16), ("slack", 14))  # fmt: skip
VERTEX, ATTR, ACCEL, INFO = 0x100, 0x40000, 0x3000000, 0x3F00000
TOP = (1 << 17) - 1
SEED = int(os.environ.get("RAYCORE_SEED", "1"), 0)
ROUNDS = int(os.environ.get("RAYCORE_ACCEL_ROUNDS", "3"))
KINDS = ("soup", "tiny", "extreme", "axis", "plane", "needle", "none", "tent", "same", "half", "sharp")


def triangles(rng, kind, n):
    """Vertices (n, 3, 3) in 2^-17."""
    if kind == "soup":
        return rng.integers(-TOP, TOP + 1, (n, 3, 3))
    if kind == "tiny":                                 # edges of a few units
        return rng.integers(-TOP + 9, TOP - 8, (n, 1, 3)) + rng.integers(-8, 9, (n, 3, 3))
    if kind == "extreme":
        return rng.choice([-TOP, -TOP + 1, -1, 0, 1, TOP - 1, TOP], (n, 3, 3))
    if kind == "axis":                                 # right angles, normals along an axis, edges of powers of two
        base = rng.integers(-(1 << 15), 1 << 15, (n, 3))
        out = np.repeat(base[:, None], 3, axis=1)
        for tri in out:
            i, j = rng.permutation(3)[:2]
            tri[1, i] += rng.choice([-1, 1]) << rng.integers(0, 17)
            tri[2, j] += rng.choice([-1, 1]) << rng.integers(0, 17)
        return np.clip(out, -TOP, TOP)
    if kind == "plane":                                # x = y: equal components of the normal
        out = rng.integers(-TOP, TOP + 1, (n, 3, 3))
        out[..., 1] = out[..., 0] * rng.choice([-1, 1])
        return out
    if kind == "needle":
        a, b = rng.integers(-TOP + 2, TOP - 1, (2, n, 3))
        return np.stack((a, b, b + rng.integers(-1, 2, (n, 3))), axis=1)
    if kind == "none":                                 # no area: points, lines, vertices twice
        a, d = rng.integers(-(1 << 12), 1 << 12, (2, n, 3))
        return a[:, None] + d[:, None] * rng.integers(-3, 4, (n, 3, 1))
    if kind == "tent":                                 # ties in rounding: edges and heights of few bits
        return rng.integers(-4, 5, (n, 3, 3)) << rng.integers(0, 15, (n, 1, 1))
    if kind == "half":                                 # determinant a power of two: quotients that lie exactly between two
        a, b = 1 << rng.integers(12, 17, n), 1 << rng.integers(12, 17, n)
        z, p, q = np.zeros(n, np.int64), rng.integers(0, 1 << 10, n), rng.integers(0, 1 << 10, n)
        far = rng.random(n) < 0.3
        q[far] = rng.integers(1 << 17, TOP * 2, far.sum()) | 1
        e1, e2 = np.stack((a, z, p), axis=1), np.stack((q, b, rng.integers(0, 1 << 18, n) // a), axis=1)
        v0 = np.where(q[:, None] > TOP, (-TOP, 0, 0), rng.integers(-100, 100, (n, 3)))
        return np.roll(np.stack((v0, v0 + e1, v0 + e2), axis=1), rng.integers(3), axis=2)
    if kind == "sharp":                                # edge slack next to a bound of its code
        pool = rng.integers(-TOP // 2, TOP // 2, (400_000, 3, 3))
        e1, e2 = pool[:, 1] - pool[:, 0], pool[:, 2] - pool[:, 0]
        normal = np.cross(e1, e2)
        k = np.abs(normal).argmax(axis=1)[:, None]
        square = [(e**2).sum(axis=1, keepdims=True) - np.take_along_axis(e, k, axis=1) ** 2 for e in (e1, e2, e2 - e1)]
        with np.errstate(divide="ignore"):
            eps = np.sqrt(np.max(square, axis=0)) / np.abs(np.take_along_axis(normal, k, axis=1))
        m = 32.0 * np.frexp(eps)[0][:, 0]
        return pool[np.abs(m - np.rint(m)).argsort()[:n]]
    return np.repeat(rng.integers(-TOP, TOP + 1, (1, 3, 3)), n, axis=0)


def normals(rng, n):
    """FP24 numbers (n, 3, 3): unit vectors, any numbers, zeros of both signs."""
    v = rng.normal(size=(n, 3, 3))
    v /= np.linalg.norm(v, axis=2, keepdims=True)
    odd = rng.random((n, 3, 3)) < 0.1
    v[odd] = rng.choice([0.0, -0.0, 1.0, -1.0, 2.0**-62, 2.0**63], odd.sum())
    return fp24.round_to_fp24(v)


class Job:
    """Triangles, their memory, and the rows that must come: {byte address: 32 bytes}."""

    def __init__(self, rng, vertices, view, bases=(VERTEX, ATTR, ACCEL, INFO)):
        n = len(vertices)
        unit = SimpleNamespace(triangles=vertices * 2.0**-17 + 0.0)
        opaque, flat = rng.random(n) < 0.6, rng.random(n) < 0.3
        material = rng.integers(0, 4096, n)
        corner = normals(rng, n)
        self.count, self.view, self.bases = n, view, bases
        self.lines = {}
        for base, records in ((bases[0], tbu.vertex_records(unit, opaque)),
                              (bases[1], accel.attribute_records(corner, material, flat))):  # fmt: skip
            data = records.astype("<u8").tobytes() + rng.bytes(32 * (n % 2))
            for i in range(0, len(data), 64):
                self.lines[base + i // 64] = int.from_bytes(data[i:i + 64], "little")
        rec, geometric, _ = accel.records(unit, view)
        words = triaccel.pack(rec, material, opaque)
        n0, d1, d2 = model.corner_normals(corner, geometric, flat)
        columns = np.concatenate((unit.triangles[:, 0], geometric, n0, d1, d2), axis=1)
        info = image._pack_columns(image.TRI_INFO, image.INFO_COLUMNS, columns, mat=material)
        self.rows = {64 * bases[2] + 32 * i: w.astype("<u8").tobytes() for i, w in enumerate(words)}
        for i, w in enumerate(info):
            data = w.astype("<u8").tobytes()
            self.rows |= {64 * bases[3] + 64 * i: data[:32], 64 * bases[3] + 64 * i + 32: data[32:]}
        self.cfg = dict(zip(("vertex_base", "attr_base", "accel_base", "info_base"), bases))
        self.cfg |= {"tri_count": n, "slack": view.least}
        self.cfg |= {f"eye_{a}": e & 0xFFFF for a, e in zip("xyz", view.eye)}


class Bench:
    def __init__(self, dut):
        self.dut, self.reads, self.acks, self.now = dut, [], [], 0

    async def reset(self):
        """Also takes away what is on its way."""
        d = self.dut
        self.reads, self.acks = [], []
        for name in ("start_i", "rd_ready_i", "rd_rsp_valid_i", "wr_ready_i", "wr_ack_i"):
            getattr(d, name).value = 0
        d.rst_ni.value = 0
        for _ in range(3):
            await RisingEdge(d.clk_i)
        d.rst_ni.value = 1
        await RisingEdge(d.clk_i)

    async def run(self, job, p=1.0, latency=5, stop=None):
        """A run to its end, to cycle `stop`, or until nothing happens after a bad triangle.

        Returns: rows, cycles, that triangle or None.
        """
        d, rows, bad, last = self.dut, {}, None, self.now
        began = self.now
        word = 0
        for name, width in CFG:
            assert 0 <= job.cfg[name] < 1 << width
            word = word << width | job.cfg[name]
        d.cfg_i.value, d.start_i.value = word, 1
        while True:
            ready = random.random() < p, random.random() < p
            d.rd_ready_i.value, d.wr_ready_i.value = ready
            answer = bool(self.reads) and self.reads[0][0] <= self.now and random.random() < p
            ack = bool(self.acks) and self.acks[0] <= self.now and random.random() < p
            d.rd_rsp_valid_i.value, d.wr_ack_i.value = answer, ack
            if answer:
                d.rd_rsp_block_i.value = self.reads.pop(0)[1]
            if ack:
                self.acks.pop(0)
            await FallingEdge(d.clk_i)
            if d.rd_valid_o.value and ready[0]:
                self.reads.append((self.now + latency, job.lines[int(d.rd_addr_o.value)]))
                assert len(self.reads) <= 8
            if d.wr_valid_o.value and ready[1]:
                at = int(d.wr_addr_o.value)
                assert at not in rows, f"row {at:#x} written twice"
                rows[at] = int(d.wr_data_o.value).to_bytes(32, "little")
                self.acks.append(self.now + latency)
                last = self.now
            done, busy = bool(d.done_o.value), bool(d.busy_o.value)
            if d.bad_o.value:
                assert bad is None
                bad, last = int(d.bad_idx_o.value), self.now
            self.now += 1
            await RisingEdge(d.clk_i)
            d.start_i.value = 0
            if stop is not None and self.now - began == stop:
                return rows, stop, None
            if done:
                assert busy and bad is None and not self.reads and not self.acks
                return rows, self.now - began, None
            if bad is not None and not self.reads and not self.acks and self.now > last + 200:
                return rows, self.now - began, bad
            assert self.now < last + 3000 + 20 * latency, "hangs"


def compare(job, rows):
    """Every row, and no other."""
    assert rows.keys() == job.rows.keys()
    for at, data in job.rows.items():
        assert rows[at] == data, f"row {at:#x}: {rows[at].hex()}, expected {data.hex()}"


def view(rng):
    """An eye amid the scene, near it, or far off; any least slack."""
    size = rng.choice([0.5, 3.0, 64.0])
    eye = rng.uniform(-size, size, 3) * (1 << model.EYE_FRAC)
    eye[rng.random(3) < 0.1] = rng.choice([-1, 1]) * model.EYE_MAX
    least = rng.choice([model.SLACK_ONE, model.SLACK_MAX, rng.integers(model.SLACK_ONE, 1000)])
    return model.Slack(tuple(int(e) for e in eye), int(least))


def begin(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    return Bench(dut), np.random.default_rng(SEED)


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def records(dut):
    """All kinds of triangles, odd and even numbers of them, one run after the other without a reset."""
    bench, rng = begin(dut)
    await bench.reset()
    for round_ in range(ROUNDS):
        for kind in KINDS:
            n = 80 if kind in ("half", "sharp") else int(rng.choice([1, 2, 3, 20, 41]))
            job = Job(rng, triangles(rng, kind, n), model.Slack() if kind == "sharp" else view(rng))
            p, latency = random.choice([(1.0, 1), (1.0, 60), (0.5, 5), (0.1, 2), (0.8, 200)])
            rows, _, bad = await bench.run(job, p, latency)
            assert bad is None
            compare(job, rows)
        dut._log.info(f"round {round_ + 1} of {ROUNDS}")


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def rate(dut):
    """Cycles a triangle, memory that never waits: at most 40."""
    bench, rng = begin(dut)
    await bench.reset()
    job = Job(rng, triangles(rng, "soup", 200), model.Slack())
    rows, cycles, _ = await bench.run(job, 1.0, 60)
    compare(job, rows)
    dut._log.info(f"{cycles / 200:.1f} cycles a triangle")
    assert cycles < 40 * 200
    assert abs(int(dut.cycles_o.value) - cycles) < 4


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def bad(dut):
    """Coordinates off the grid or outside it: the triangle is told, earlier ones may be written, it and later ones are not."""
    bench, rng = begin(dut)
    for value in (0x3F0000, 0xBF0000, 0x7F0000, 0x7F8000, 0x2D0000, 0x2E8000, 0x010000, 0x7EFFFF):
        await bench.reset()
        job = Job(rng, triangles(rng, "soup", 12), view(rng))
        n, corner = int(rng.integers(12)), int(rng.integers(9))
        line, at = VERTEX + n // 2, 256 * (n % 2) + 24 * corner
        job.lines[line] = job.lines[line] & ~(0xFFFFFF << at) | value << at
        rows, _, told = await bench.run(job, random.choice([1.0, 0.4]), 20)
        assert told == n
        spoilt = {64 * ACCEL + 32 * i for i in range(n, 12)}
        assert all(rows[a] == job.rows[a] for a in rows) and not spoilt & rows.keys()


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def last_addresses(dut):
    """Regions that end where memory ends, and one that begins at 0."""
    bench, rng = begin(dut)
    await bench.reset()
    end = 1 << 26
    job = Job(rng, triangles(rng, "soup", 6), view(rng), (0, end - 3, end - 6, end - 12))
    rows, _, _ = await bench.run(job, 0.7, 9)
    compare(job, rows)


@cocotb.test(timeout_time=100, timeout_unit="ms")
async def resets(dut):
    """Reset in the middle, then a run as if nothing had been."""
    bench, rng = begin(dut)
    for _ in range(10):
        await bench.reset()
        job = Job(rng, triangles(rng, "soup", 9), view(rng))
        rows, _, _ = await bench.run(job, 0.6, 7, int(rng.integers(1, 500)))
        await bench.reset()
        rows, _, _ = await bench.run(job, 0.6, 7)
        compare(job, rows)


def test_rc_accel():
    run_cocotb("rc_accel", SOURCES, "test_rc_accel")
