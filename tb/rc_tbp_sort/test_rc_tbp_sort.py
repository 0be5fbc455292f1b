# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_tbp_sort against raycore.model.tbu: every node and list of every job, walked from its root.

Extents come in any order, every port waits at random. Donated children come back as jobs of the same pipeline, and Python
writes their parents as rc_tbu_upper does.
"""

import os
import random
from collections import deque
from types import SimpleNamespace

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from raycore.model import tbu, tbu_memory
from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl(
    "prim/rc_delay.sv", "prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "fp/rc_fp_norm.sv", "fp/rc_fp_pipe.sv",
    "fp/rc_fp_round.sv", "fp/rc_fp_from_int.sv", "tbu/rc_tbu_pkg.sv", "tbu/rc_tbp_sort_pkg.sv", "tbu/rc_run_sort.sv",
    "tbu/rc_merge_sort.sv", "tbu/rc_tbp_eval.sv", "tbu/rc_tbp_area.sv", "tbu/rc_tbp_list.sv", "tbu/rc_tbp_sort_child.sv",
    "tbu/rc_tbp_sort_axis.sv", "tbu/rc_tbp_sort_refs.sv", "tbu/rc_tbp_sort_pick.sv", "tbu/rc_tbp_sort_stack.sv",
    "tbu/rc_tbp_sort_nodes.sv", "tbu/rc_tbp_sort_leafs.sv", "tbu/rc_tbp_sort_split.sv", "tbu/rc_tbp_sort_ctrl.sv",
    "tbu/rc_tbp_sort.sv",
)
NODE_EXTENT, LIST_EXTENT = 128, 256        # rc_tbu_pkg.sv
MAX_Q = (1 << 18) - 1


def refs_of(lo, hi):
    """Refs of boxes (N, 3) each, limited to (0, 2^18); triangle indices with holes."""
    n = len(lo)
    lo, hi = (np.clip(np.asarray(x, np.int64).reshape(n, 3), 1, MAX_Q) for x in (lo, hi))
    tri = np.sort(np.array(random.sample(range(1 << 19), n), np.int64))
    return tbu.Refs(lo, hi, tri, np.array([random.random() < 0.5 for _ in range(n)]))


def soup(n, size=40_000, grid=1):
    """Boxes anywhere, up to `size` wide, on multiples of `grid`."""
    r = np.random.default_rng(random.getrandbits(32))
    lo = r.integers(1, MAX_Q - size, (n, 3)) // grid * grid
    return refs_of(lo, lo + r.integers(0, size + 1, (n, 3)) // grid * grid)


def sheet(n):
    """A height field: neighbours share planes, as in a mesh."""
    side = max(1, int((n / 2) ** 0.5) + 1)
    r = np.random.default_rng(random.getrandbits(32))
    z = r.integers(100_000, 140_000, (side + 1, side + 1))
    step = 200_000 // side
    lo, hi = [], []
    for i in range(side):
        for j in range(side):
            for tri in (((i, j), (i + 1, j), (i, j + 1)), ((i + 1, j + 1), (i + 1, j), (i, j + 1))):
                p = np.array([[1 + a * step, 1 + b * step, z[a, b]] for a, b in tri])
                lo.append(p.min(axis=0))
                hi.append(p.max(axis=0))
    return refs_of(lo[:n], hi[:n])


def ball(n):
    """A bumpy, closed mesh around the centre."""
    k = int((n / 2) ** 0.5) + 1
    a, b = np.meshgrid(np.pi * np.arange(k + 1) / k, 2 * np.pi * np.arange(k + 1) / k, indexing="ij")
    r = 100_000 * (1 + 0.05 * np.sin(7 * a) * np.cos(5 * b))
    v = np.rint(131_072 + np.stack((r * np.sin(a) * np.cos(b), r * np.sin(a) * np.sin(b), 0.7 * r * np.cos(a)), axis=-1))
    near = np.stack((v[:-1, :-1], v[1:, :-1], v[:-1, 1:]), axis=2).reshape(-1, 3, 3)
    far = np.stack((v[1:, 1:], v[1:, :-1], v[:-1, 1:]), axis=2).reshape(-1, 3, 3)
    tri = np.stack((near, far), axis=1).reshape(-1, 3, 3)[:n]
    return refs_of(tri.min(axis=1), tri.max(axis=1))


def coplanar(n):
    """Overlapping boxes in one of three planes, and others on top: flat cells."""
    s = soup(n, 60_000, 1000)
    for i in range(n):
        a = i % 3
        if random.random() < 0.8:
            s.lo[i, a] = s.hi[i, a] = random.choice([1000, 120_000, 250_000])
    return s


def identical(n):
    return refs_of([[5000, 6000, 7000]] * n, [[90_000, 9000, 80_000]] * n)


def needles(n):
    """Thin boxes along random axes, crossing each other."""
    s = soup(n, 300)
    for i in range(n):
        s.lo[i, i % 3], s.hi[i, i % 3] = 1 + random.randrange(1000), MAX_Q - random.randrange(1000)
    return s


def points(n):
    s = soup(n, 1000, 4000)
    s.hi[:] = s.lo
    return s


def tiny_cell(n):
    """All inside a few units: planes run out before the depth does."""
    s = soup(n, 3)
    s.lo[:], s.hi[:] = s.lo % 4 + 1000, s.lo % 4 + 1000 + (s.hi - s.lo)
    return s


def one_flat_axis(n):
    s = soup(n, 30_000, 500)
    s.lo[:, 1] = s.hi[:, 1] = 77_777
    return s


def bars(n):
    """Bars as long as the box, and points between their ends: planes across the bars pay, so lists grow at every level."""
    r = np.random.default_rng(random.getrandbits(32))
    m = 2 * n // 5
    lo, hi = r.integers(1, 200, (n, 3)), r.integers(1800, 2000, (n, 3))
    lo[:m, 0], hi[:m, 0] = 1, MAX_Q
    lo[m:, 0] = hi[m:, 0] = r.integers(2, MAX_Q, n - m)
    return refs_of(lo, hi)


def same_but_cut(want, found, w=0, f=0):
    """Number of leaves of `found` where `want` goes on, with the same triangles; AssertionError if it differs elsewhere."""
    if found.kind[f] == tbu.LEAF and want.kind[w] != tbu.LEAF:
        below, todo = set(), [w]
        while todo:
            row = todo.pop()
            below.update(want.leaf(row) if want.kind[row] == tbu.LEAF else [])
            todo += [c[row] for c in (want.lower, want.upper) if want.kind[row] != tbu.LEAF and c[row] >= 0]
        assert found.leaf(f) == sorted(below)
        return 1
    assert found.kind[f] == want.kind[w] and found.plane[f] == want.plane[w] and found.leaf(f) == want.leaf(w)
    pairs = [(c[w], d[f]) for c, d in ((want.lower, found.lower), (want.upper, found.upper)) if want.kind[w] != tbu.LEAF]
    assert all((a < 0) == (b < 0) for a, b in pairs)
    return sum(same_but_cut(want, found, a, b) for a, b in pairs if a >= 0)


KINDS = [soup, sheet, ball, coplanar, identical, needles, points, tiny_cell, one_flat_axis,
         lambda n: soup(n, 120_000, 30_000), lambda n: soup(n, 200_000)]


class Bench:
    """Jobs in, memory out. p: chance of valid or ready in a cycle, p_wr: of wr_ready; order: extents `down`, or `any`."""

    def __init__(self, dut, p=1.0, order="down", donate=0.0, extents=400, p_wr=None):
        self.dut, self.p, self.donate, self.p_wr = dut, p, donate, p if p_wr is None else p_wr
        self.free = [list(range(extents)), list(range(extents))]
        if order == "any":
            for f in self.free:
                random.shuffle(f)
        else:
            self.free[0].reverse()
        self.nodes, self.lists, self.granted = {}, {}, [set(), set()]
        self.jobs, self.refs, self.done, self.now = deque(), deque(), [], 0
        self.held = dict.fromkeys(("job", "ref", "grant"), False)
        self.incoming, self.donated, self.upper, self.free_entries = None, {}, {}, deque(range(64, 80))
        self.counts = dict.fromkeys(("jump", "forced", "rows", "donated"), 0)
        self.times = []

    async def start(self):
        dut = self.dut
        Clock(dut.clk_i, 10, unit="ns").start()
        for name in ("rst_ni", "job_valid_i", "job_i", "ref_valid_i", "ref_i", "ext_gnt_i", "ext_idx_i", "wr_ready_i",
                     "sub_ready_i", "don_want_i", "don_ready_i", "don_ref_ready_i", "ent_valid_i", "ent_idx_i", "upper_ready_i"):
            getattr(dut, name).value = 0
        await RisingEdge(dut.clk_i)
        await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1

    def job(self, refs, box=None, level=0, gap=0, dest=None):
        """Queue a job; dest: 9 bits, by default the next number of a pretended upper node."""
        box = refs.box if box is None else np.asarray(box)
        dest = len(self.jobs) + len(self.done) & 0x3F if dest is None else dest
        word = tbu_memory.pack_box(box[0], box[1]) | len(refs) << 108 | level << 128 | gap << 134 | dest << 140
        job = SimpleNamespace(refs=refs, box=box, level=level, gap=gap, dest=dest)
        self.jobs.append((word, tbu_memory.pack_refs(refs), job))

    def grant(self, kind, num):
        """Take num extents in one piece. Returns the first index."""
        free = self.free[kind]
        if num == 1:
            e = free.pop(0)
        else:
            e = next(e for e in sorted(free) if all(e + i in free for i in range(num)))
            for i in range(num):
                free.remove(e + i)
        for i in range(num):
            self.granted[kind].add(e + i)
        return e * (LIST_EXTENT if kind else NODE_EXTENT)

    async def cycle(self):
        dut, held, p = self.dut, self.held, self.p
        chance = lambda: random.random() < p                                     # noqa: E731
        held["job"] = bool(self.jobs) and (held["job"] or chance())
        dut.job_valid_i.value = held["job"]
        if held["job"]:
            dut.job_i.value = self.jobs[0][0]
        held["ref"] = bool(self.refs) and (held["ref"] or chance())
        dut.ref_valid_i.value = held["ref"]
        if held["ref"]:
            dut.ref_i.value = self.refs[0]
        dut.wr_ready_i.value, dut.sub_ready_i.value = random.random() < self.p_wr, chance()
        dut.upper_ready_i.value = chance()
        want = random.random() < self.donate
        dut.don_want_i.value, dut.ent_valid_i.value = want, want and bool(self.free_entries)
        if self.free_entries:
            dut.ent_idx_i.value = self.free_entries[0]
        dut.don_ready_i.value = self.incoming is None and chance()
        dut.don_ref_ready_i.value = self.incoming is not None and chance()
        dut.ext_gnt_i.value = 0
        await FallingEdge(dut.clk_i)
        req = int(dut.ext_req_o.value)
        if req and chance():
            kind = random.choice([k for k in range(2) if req >> k & 1])
            dut.ext_idx_i.value = self.grant(kind, int(dut.ext_num_o.value) if kind else 1)
            dut.ext_gnt_i.value = 1 << kind
            await cocotb.triggers.ReadOnly()
        self.sample()
        self.now += 1
        await RisingEdge(dut.clk_i)

    def sample(self):
        dut, held = self.dut, self.held
        if held["job"] and dut.job_ready_o.value:
            _, words, self.active = self.jobs.popleft()
            held["job"], self.begin = False, self.now
            assert not self.refs
            self.refs.extend(words)
        if held["ref"] and dut.ref_ready_o.value:
            self.refs.popleft()
            held["ref"] = False
        self.counts["jump"] += int(dut.ev_jump_o.value)
        self.counts["forced"] += int(dut.ev_forced_o.value)
        if dut.wr_valid_o.value and dut.wr_ready_i.value:
            self.write(int(dut.wr_o.value))
        if dut.ent_ready_o.value:
            assert dut.ent_valid_i.value
            self.entry = self.free_entries.popleft()
        if dut.don_valid_o.value and dut.don_ready_i.value:
            word = int(dut.don_job_o.value)
            assert word >> 140 & 0x7F == self.entry
            self.incoming, self.incoming_job = [], word
            self.counts["donated"] += 1
        elif dut.don_ref_valid_o.value and dut.don_ref_ready_i.value:
            self.incoming.append(int(dut.don_ref_o.value))
            if len(self.incoming) == self.incoming_job >> 108 & 0xFFFFF:
                word, refs = self.incoming_job, tbu_memory.unpack_refs(self.incoming)
                q = [word >> 18 * i & MAX_Q for i in range(6)]
                self.jobs.append((word, self.incoming, SimpleNamespace(
                    refs=refs, box=np.array(q).reshape(2, 3), level=word >> 128 & 0x3F, gap=word >> 134 & 0x3F, dest=word >> 140)))
                self.incoming = None
        if dut.upper_valid_o.value and dut.upper_ready_i.value:
            word = int(dut.upper_o.value)
            entry = word >> 45
            self.donated.setdefault(entry, {})["node"] = (word >> 43 & 3, word >> 25 & MAX_Q, word >> 24 & 1, word & 0xFFFFFF)
            self.settle(entry)
        if dut.sub_valid_o.value and dut.sub_ready_i.value:
            word = int(dut.sub_o.value)
            self.active.root = word & 0xFFFFFF
            assert word >> 24 == self.active.dest
            self.done.append(self.active)
            self.times.append(self.now - self.begin)
            entry = self.active.dest & 0x7F
            if entry >= 64:
                assert self.active.gap == 0
                self.donated.setdefault(entry, {})["other"] = (self.active.root, self.active.dest >> 7 & 1)
                self.settle(entry)

    def settle(self, entry):
        """What rc_tbu_upper does: write the node when it and its other child are known."""
        e = self.donated[entry]
        if len(e) == 2:
            axis, pos, swap, idx = e["node"]
            other, upper = e["other"]
            assert upper != swap, "the other child was donated"
            split = int(tbu.fp24_from_fixed(pos))
            self.put(self.nodes, idx, split | axis << 24 | swap << 26 | other << 29)
            del self.donated[entry]
            self.free_entries.append(entry)

    def put(self, memory, idx, word):
        assert idx not in memory, f"{idx} written twice"
        memory[idx] = word

    def write(self, word):
        data, strb, row, kind = word & (1 << 256) - 1, word >> 256 & 0xFF, word >> 264 & 0xFFFFFF, word >> 288
        self.counts["rows"] += 1
        assert strb
        for i in range(8):
            if kind == 0 and i % 2 == 0 and strb >> i & 3:
                assert strb >> i & 3 == 3
                idx = 4 * row + i // 2
                assert idx // NODE_EXTENT in self.granted[0]
                self.put(self.nodes, idx, data >> 32 * i & (1 << 64) - 1)
            elif kind == 1 and strb >> i & 1:
                idx = 8 * row + i
                assert idx // LIST_EXTENT in self.granted[1]
                self.put(self.lists, idx, data >> 32 * i & 0xFFFFFFFF)
        assert kind < 2

    async def run(self, limit=400_000):
        """All jobs that wait; checks them all."""
        while self.jobs or self.refs or self.incoming is not None or self.donated or self.dut.busy_o.value:
            await self.cycle()
            assert self.now < limit, "hangs"
        for _ in range(3):
            await self.cycle()
        assert not self.refs
        self.check()

    def check(self):
        size = 1 + max(self.nodes, default=0), 1 + max(self.lists, default=0)
        nodes, lists = np.full(size[0], (1 << 64) - 1, np.uint64), np.full(size[1], 0xFFFFFFFF, np.uint32)
        for memory, array in ((self.nodes, nodes), (self.lists, lists)):
            for idx, word in memory.items():
                array[idx] = word
        cut = 0
        for job in self.done:
            for i in range(1, job.gap + 1):
                assert job.root - i not in self.nodes and (job.root - i) // NODE_EXTENT in self.granted[0]
            want = tbu.sort_subtree(job.refs, job.box, job.level)
            found = tbu_memory.walk_memory(nodes, lists, job.root, job.box)
            if self.counts["forced"]:
                cut += same_but_cut(want, found)
            else:
                differ = tbu_memory.compare(want, found)
                assert differ is None, f"job of {len(job.refs)} at level {job.level}: {differ}"
        assert cut <= self.counts["forced"], "leaves that nothing forced"
        sizes = f"{len(self.nodes)} nodes, {len(self.lists)} entries"
        self.dut._log.info(f"{len(self.done)} jobs, {self.now} cycles, {sizes}, {self.counts}")


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(p=[1.0, 0.4], order=["down", "any"])
async def kinds(dut, p, order):
    """Jobs of every kind of geometry and size, one after the other, at any level, with gaps."""
    b = Bench(dut, p, order)
    await b.start()
    cap = int(dut.Cap.value)
    for kind in random.sample(KINDS, len(KINDS) if cap < 64 else 4):
        for n in (cap, random.randint(5, cap), random.choice([1, 2, 3, 4, 5, 6])):
            b.job(kind(n), level=random.choice([0, 0, 3, 28, 30, 31, 32]), gap=random.choice([0, 0, 1, 5, 32]))
    await b.run()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def cut_by_the_box(dut):
    """The box of the job is smaller than its references, as after many planes above it."""
    b = Bench(dut, 0.8)
    await b.start()
    cap = int(dut.Cap.value)
    for _ in range(10):
        box = np.array([[80_000] * 3, [80_000 + random.choice([500, 20_000, 60_000])] * 3])
        s = random.choice(KINDS)(3 * cap)
        inside = np.all((s.lo < box[1]) & (s.hi > box[0]), axis=1)
        if inside.any():
            b.job(s[np.flatnonzero(inside)[:cap]], box)
    for face in (0, 1):                    # all in one face: no flat cell, whatever it would cost
        for n in (6, cap):
            s = one_flat_axis(n)
            box = s.box
            box[1 - face, 1] += 60_000 if face == 0 else -60_000
            b.job(s, box)
    await b.run()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def many_jumps(dut):
    """Small trees that fill many extents, none next to another, while rows wait long: jump nodes in every situation."""
    b = Bench(dut, order="any", p_wr=0.008)
    await b.start()
    b.free[0] = [e for e in b.free[0] if e % 2]
    for _ in range(50):
        b.job(points(random.randint(9, 16)), gap=random.choice([0, 0, 0, 3, 40, 60]))
    await b.run()
    assert b.counts["jump"] > 1


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def reset_midway(dut):
    """A reset at any time leaves nothing behind."""
    b = Bench(dut, 0.8)
    await b.start()
    for _ in range(8):
        for _ in range(3):
            b.job(soup(32))
        for _ in range(random.randrange(20, 1200)):
            await b.cycle()
        dut.rst_ni.value = dut.job_valid_i.value = dut.ref_valid_i.value = dut.ext_gnt_i.value = 0
        await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1
        b = Bench(dut, 0.8)
    b.job(soup(32))
    await b.run()


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def full_lists(dut):
    """Lists that outgrow their memory: leaves where the model divides on, all triangles in them, and a count."""
    b = Bench(dut, 0.9)
    await b.start()
    cap = int(dut.Cap.value)
    for n in (cap, cap - 3):
        b.job(bars(n))
    await b.run()
    assert cap < 64 or b.counts["forced"]


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(p=[1.0, 0.3])
async def donation(dut, p):
    """Another pipeline wants work, always or now and then: the trees stay the same."""
    b = Bench(dut, p, donate=1.0 if p == 1.0 else 0.5)
    await b.start()
    cap = int(dut.Cap.value)
    for kind in (soup, sheet) if p == 1.0 else (coplanar,):
        b.job(kind(cap), gap=random.choice([0, 3]))
    await b.run()
    assert p < 1.0 or cap < 128 or b.counts["donated"]


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def nonsense(dut):
    """Boxes with lo > hi, outside the job's box, or a job's box that is none: the job ends."""
    b = Bench(dut, 0.8)
    await b.start()
    cap = int(dut.Cap.value)
    b.check = lambda: None
    for n in (min(cap, 40), 17, 5, 2):
        s = soup(n)
        s.lo[::2], s.hi[::2] = s.hi[::2], s.lo[::2].copy()
        b.job(s, [[3, 3, 3], [MAX_Q] * 3])
        b.job(soup(n), [[200_000] * 3, [100_000, 250_000, 100_000]])
        b.job(soup(n), [[1] * 3, [2] * 3])
    await b.run()
    assert len(b.done) == 12


@cocotb.test(timeout_time=100, timeout_unit="ms", skip=not os.environ.get("RAYCORE_TBP_BENCH"))
async def rates(dut):
    """Cycles a triangle of whole jobs."""
    cap = int(dut.Cap.value)
    b = Bench(dut)
    await b.start()
    for kind, n in ((sheet, 530), (ball, 530), (soup, 530), (sheet, cap), (ball, cap), (soup, cap), (coplanar, cap)):
        b.job(kind(n))
        nodes, entries = len(b.nodes), len(b.lists)
        await b.run(10_000_000)
        dut._log.info(f"rate: {kind.__name__} of {n}: {b.times[-1] / n:.1f} cycles, {(len(b.nodes) - nodes) / n:.2f} nodes, "
                      f"{(len(b.lists) - entries) / n:.2f} entries a triangle")


@pytest.mark.parametrize("cap", [32, 160])
def test_rc_tbp_sort(cap):
    run_cocotb("rc_tbp_sort", SOURCES, "test_rc_tbp_sort", parameters={"Cap": cap})


@pytest.mark.skipif(not os.environ.get("RAYCORE_TBP_BENCH"), reason="a benchmark: RAYCORE_TBP_BENCH=1")
def test_rc_tbp_sort_rates():
    run_cocotb("rc_tbp_sort", SOURCES, "test_rc_tbp_sort", parameters={"Cap": 1280}, testcase="rates")
