# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_tbp_bin against raycore.model.tbu.upper_tree: every plane, every job with its list, every leaf.

Memory, sorting pipelines and the table of upper nodes are Python: late, with gaps, jobs taken when it pleases them.
"""

import os
import random
from collections import deque

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge
from tbu_tb import (
    CFG,
    DEST,
    JOB,
    LEAF,
    LIST_JOB,
    SHAPES,
    SPLIT,
    WR,
    Memory,
    pack,
    package_with_depth,
    references,
    unpack,  # fmt: skip
    vertex_records,
)

from raycore.model import tbu
from raycore.model.tbu_memory import compare, pack_box, pack_refs, unpack_refs
from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "tbu/rc_tbu_pkg.sv", "tbu/rc_tbp_bin_pkg.sv",
              "tbu/rc_tbu_fix.sv", "tbu/rc_tbu_box.sv", "tbu/rc_tbu_fetch.sv", "tbu/rc_tbp_bin_class.sv", "tbu/rc_tbp_bin_write.sv",
              "tbu/rc_tbp_bin_axis.sv", "tbu/rc_tbp_bin_eval.sv", "tbu/rc_tbp_bin_plane.sv", "tbu/rc_tbp_bin_pass.sv",
              "tbu/rc_tbp_bin_ctrl.sv", "tbu/rc_tbp_bin.sv")  # fmt: skip
VERTEX, REF, LIST = 0x1000, 0x20000, 0x80000   # lines
SEED = int(os.environ.get("RAYCORE_SEED", "1"), 0)
DEPTH = int(os.environ.get("MAX_DEPTH", tbu.MAX_DEPTH))


class Bench:
    """A build: `run` to the end; then `tree` has what came out."""

    def __init__(self, dut, vertices, opaque, cap, refine_max, ref_count, latency=lambda: 5, p=1.0, job_delay=lambda: 30):
        self.dut, self.refs, self.cap, self.p = dut, references(vertices, opaque), cap, p
        self.latency, self.job_delay = latency, job_delay
        self.memory, self.now = Memory(SEED), 0
        for i, record in enumerate(vertex_records(vertices, opaque)):
            self.memory.put(VERTEX * 64 + 32 * i, record, 32)
        self.reads, self.writes, self.jobs = deque(), deque(), deque()
        self.entries, self.free, self.got = {}, list(range(128)), {}
        self.ref_count, self.list_next, self.full, self.bad = ref_count, 0, False, 0
        self.lines = self.rows = 0
        box = self.refs.box
        self.word = pack(CFG, vertex_base=VERTEX, tri_count=len(vertices), node_base=0, node_count=0, list_base=LIST,
                         list_count=1 << 20, ref_base=REF, ref_count=ref_count, refine_max=refine_max,
                         box=pack_box(box[0], box[1]), node_first=0, list_first=0, tri_first=0)  # fmt: skip
        self.held = {}

    def ready(self, name, p=None):
        value = random.random() < (self.p if p is None else p)
        getattr(self.dut, name).value = value
        return value

    async def cycle(self, start=False):
        dut = self.dut
        dut.start_i.value = start
        self.ready("req_ready_i")
        self.ready("wr_ready_i")
        self.ready("job_ready_i")
        self.ready("leaf_ready_i")
        split = self.ready("split_ready_i") and bool(self.free)
        dut.split_ready_i.value = split
        if split:
            dut.split_entry_i.value = self.free[0]
        dut.ids_gnt_i.value = 0
        due = bool(self.reads) and self.reads[0][0] <= self.now and random.random() < self.p
        dut.rsp_valid_i.value = due
        if due:
            dut.rsp_block_i.value = self.memory.get(self.reads.popleft()[1] * 64, 64)
        while self.writes and self.writes[0][0] <= self.now:
            self.memory.row(*self.writes.popleft()[1:])
        dut.wr_confirmed_i.value = not self.writes
        done = bool(self.jobs) and self.jobs[0][0] <= self.now
        dut.job_read_i.value = done
        if done:                                       # its list may now be overwritten
            _, job, base = self.jobs.popleft()
            words = [self.memory.get(REF * 64 + 16 * (base + i), 16) for i in range(job["count"])]
            self.got[job["dest"]] = ("job", job, unpack_refs(words))
        self.held_grant = random.random() < self.p
        await FallingEdge(dut.clk_i)
        if dut.ids_req_o.value and self.held_grant:
            dut.ids_gnt_i.value, dut.ids_idx_i.value = 1, self.list_next
            self.list_next += -(-int(dut.ids_count_o.value) // 256) * 256
        if dut.req_valid_o.value and dut.req_ready_i.value:
            line = int(dut.req_addr_o.value)
            self.lines += 1
            limit = (VERTEX, VERTEX + (len(self.refs) + 1) // 2) if line < REF else (REF, REF + self.ref_count // 4)
            assert limit[0] <= line < limit[1], f"reads line {line:#x}"
            last = self.reads[-1][0] if self.reads else 0
            self.reads.append((max(last, self.now + self.latency()), line))
            assert len(self.reads) <= 16
        if dut.wr_valid_o.value and dut.wr_ready_i.value:
            wr = unpack(WR, int(dut.wr_o.value))
            kind, row = wr["kind"], wr["row"]
            assert kind in (1, 2) and wr["strb"]
            assert kind == 1 or row * 2 + 1 < self.ref_count, "writes outside the working memory"
            byte = (REF if kind == 2 else LIST) * 64 + row * 32
            self.rows += 1
            self.writes.append((self.now + self.latency(), byte, wr["data"], wr["strb"]))
        if dut.split_valid_o.value and split:
            s = unpack(SPLIT, int(dut.split_o.value))
            entry = self.free.pop(0)
            self.entries[entry] = s
            self.got[s["dest"]] = ("split", s, entry)
        if dut.leaf_valid_o.value and dut.leaf_ready_i.value:
            leaf = unpack(LEAF, int(dut.leaf_o.value))
            self.got[leaf["dest"]] = ("leaf", leaf, None)
        if dut.job_valid_o.value and dut.job_ready_i.value:
            lj = unpack(LIST_JOB, int(dut.job_o.value))
            job = unpack(JOB, lj["job"])
            if lj["vertices"]:
                self.got[job["dest"]] = ("job", job, self.refs)
            else:
                assert lj["base"] % self.cap == 0 and lj["base"] < 16 * self.cap
                self.jobs.append((self.now + self.job_delay(), job, lj["base"]))
        self.busy = bool(dut.busy_o.value)
        self.full |= bool(dut.full_o.value)
        self.bad += int(dut.bad_o.value)
        self.now += 1
        await RisingEdge(dut.clk_i)

    async def run(self, limit=400_000):
        self.dut.cfg_i.value = self.word
        await self.cycle(start=True)
        await self.cycle()
        while self.busy or self.jobs or self.writes:
            await self.cycle()
            if self.full or self.bad:
                return
            assert self.now < limit, "hangs"

    def tree(self) -> tbu.Tree:
        """Canonical form; entries are named by their order, so the pool must not have been used twice."""
        rows, members, opaque = [], [], []
        box = self.refs.box

        def add(dest, box, level, parent, gap):
            kind, what, more = self.got[dest]
            row = len(rows)
            rows.append(dict(kind=0, plane=0, side=-1, lower=-1, upper=-1, swap=False, level=level, parent=parent,
                             first=len(members), count=0, box=box))  # fmt: skip
            if kind == "split":
                axis, pos = what["axis"], what["pos"]
                rows[row].update(kind=axis, plane=pos, swap=bool(what["swap"]), first=0)
                below, above = box.copy(), box.copy()
                below[1, axis] = above[0, axis] = pos
                for upper, part in ((0, below), (1, above)):
                    if not what["upper_empty" if upper else "lower_empty"]:
                        child = add(pack(DEST, root=0, upper=upper, entry=more), part, level + 1, row,
                                    gap + 1 if upper == what["swap"] else 0)  # fmt: skip
                        rows[row]["upper" if upper else "lower"] = child
            elif kind == "leaf":
                rows[row].update(kind=tbu.LEAF, count=what["count"])
                assert what["gap"] == gap
                for i in range(what["count"]):
                    entry = self.memory.get(LIST * 64 + 4 * (what["first"] + i), 4)
                    assert entry >> 24 & 1 == (i == what["count"] - 1) and entry >> 26 == 0
                    members.append(entry & 0xFFFFFF)
                    opaque.append(entry >> 25 & 1)
            else:
                rows[row].update(kind=tbu.JOB, count=what["count"])
                assert (what["level"], what["gap"], what["box"]) == (level, gap, pack_box(box[0], box[1]))
                members.extend(more.tri.tolist())
                opaque.extend(more.opaque.tolist())
                expected = self.refs[more.tri]
                assert pack_refs(more) == pack_refs(expected), "a reference was changed"
            return row

        add(pack(DEST, root=1, upper=0, entry=0), np.array(box, np.int64), 0, -1, 0)
        columns = {k: np.array([r[k] for r in rows]) for k in rows[0]}
        return tbu.Tree(**columns, members=np.array(members, np.int64), opaque=np.array(opaque, bool), at=np.full(len(rows), -1))


async def start(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    await reset(dut)


async def reset(dut):
    dut.rst_ni.value = 0
    for name in ("start_i", "cfg_i", "req_ready_i", "rsp_valid_i", "rsp_block_i", "wr_ready_i", "wr_confirmed_i", "split_ready_i",
                 "split_entry_i", "leaf_ready_i", "ids_gnt_i", "ids_idx_i", "job_ready_i", "job_read_i"):  # fmt: skip
        getattr(dut, name).value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


async def build(dut, vertices, refine_max, name, **how):
    cap = int(dut.Cap.value)
    opaque = np.random.default_rng(SEED).random(len(vertices)) < 0.7
    bench = Bench(dut, vertices, opaque, cap, refine_max, 16 * cap + 8 * len(vertices) + 64, **how)
    expected = tbu.upper_tree(bench.refs, cap=cap, refine_max=refine_max, max_depth=DEPTH)
    assert int((expected.kind < 3).sum()) <= 128, "more upper nodes than the bench has names for"
    await bench.run()
    assert not bench.full and not bench.bad
    difference = compare(expected, bench.tree())
    assert difference is None, f"{name}: {difference}"
    n = max(len(vertices), 1)
    dut._log.info(f"{name}: {len(vertices)} triangles, {len(expected)} upper nodes, {bench.now / n:.1f} cycles, "
                  f"{(64 * bench.lines + 32 * bench.rows) / n:.0f} bytes a triangle")  # fmt: skip
    return bench


@cocotb.test(timeout_time=100, timeout_unit="ms")
@cocotb.parametrize(shape=list(SHAPES))
async def shapes(dut, shape):
    """Nasty geometry, with refinement of some, all, no nodes; memory fast and slow."""
    await start(dut)
    rng = np.random.default_rng([SEED, list(SHAPES).index(shape)])
    cap = int(dut.Cap.value)
    size = {"same": 4, "dense": 7, "needles": 3, "flat": 4}.get(shape, 12) * cap
    await build(dut, SHAPES[shape](rng, size), 4 * cap, shape)
    await build(dut, SHAPES[shape](rng, size // 2 + int(rng.integers(9))), random.choice([0, 1 << 19]), f"{shape}, slow memory",
                latency=lambda: random.choice([20, 60, 100]), p=0.5, job_delay=lambda: random.choice([1, 3000]))  # fmt: skip


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def sizes(dut):
    """No triangle; up to Cap, which never go through here; one more; lists that end anywhere in a line."""
    await start(dut)
    rng = np.random.default_rng(SEED)
    cap = int(dut.Cap.value)
    for n in (0, 1, 2, cap - 1, cap, cap + 1, cap + 2, cap + 3, 2 * cap + 5):
        bench = await build(dut, SHAPES["soup"](rng, n), 1 << 19, f"{n} triangles")
        if n <= cap:
            assert bench.lines == bench.rows == 0


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def jobs_wait(dut):
    """The ring is full for long: nothing is lost, nothing overwritten."""
    await start(dut)
    rng = np.random.default_rng(SEED)
    await build(dut, SHAPES["clusters"](rng, 12 * int(dut.Cap.value)), 0, "slow sorting", job_delay=lambda: 2500)


def least_room(refs, cap, refine_max):
    """References of working memory that a build needs: the ring, and both stacks at their highest together."""
    tree = tbu.upper_tree(refs, cap=cap, refine_max=refine_max)
    counts, boxes = {0: len(refs)}, tree.box
    todo = [(0, refs)]
    while todo:                                        # the table has no counts of inner nodes
        row, part = todo.pop()
        counts[row] = len(part)
        if tree.kind[row] < tbu.LEAF:
            plane = tbu.Plane(0, int(tree.kind[row]), int(tree.plane[row]), 1, True)
            for child, below in zip((tree.lower[row], tree.upper[row]), tbu.partition(part, boxes[row], plane), strict=True):
                if child >= 0:
                    todo.append((child, below))

    def parts(row):
        return [c for c in (tree.lower[row], tree.upper[row]) if c >= 0] if tree.kind[row] < tbu.LEAF else []

    def lines(row):
        return -(-counts[row] // 4) * 4

    used = [lines(0), 0]                               # regions X and Y
    most, pending = used[0], [(0, 0)]
    while pending:
        row, region = pending.pop()
        members = [m for child in parts(row) for m in (parts(child) if counts[child] > cap else []) or [child]]
        big = sorted((m for m in members if counts[m] > cap), key=lambda m: -counts[m])
        used[1 - region] += sum(lines(m) for m in big)
        most = max(most, sum(used))
        used[region] -= lines(row)
        pending += [(m, 1 - region) for m in big]
    return 16 * cap + most


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(shape=["needles", "clusters", "grid"])
async def working_memory(dut, shape):
    """The least that does is enough; with a line less it says so, and writes nothing outside. Nothing is left behind."""
    await start(dut)
    rng = np.random.default_rng([SEED, len(shape)])
    cap = int(dut.Cap.value)
    vertices = SHAPES[shape](rng, {"needles": 3, "clusters": 6, "grid": 16}[shape] * cap)
    opaque = np.ones(len(vertices), bool)
    enough = least_room(references(vertices, opaque), cap, 0)
    for room in (enough, enough - 1, 16 * cap, 0):
        await reset(dut)
        bench = Bench(dut, vertices, opaque, cap, 0, room)
        await bench.run()
        assert not bench.bad and bench.full == (room < enough), f"{room} references, {enough} should do"
        if not bench.full:
            assert compare(tbu.upper_tree(bench.refs, cap=cap, refine_max=0), bench.tree()) is None


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def bad_coordinates(dut):
    """Outside (-1, 1), no multiple of 2^-17, infinite, no number: reported, as often as there are such triangles."""
    await start(dut)
    rng = np.random.default_rng(SEED)
    cap = int(dut.Cap.value)
    for word in (0x3F0000, 0xBF0000, 0x3E0001, 0x2D0000, 0x2E8000, 0x7F0000, 0x7F8000, 0xFEFFFF, 0x010000):
        await reset(dut)
        vertices = SHAPES["soup"](rng, cap + 8)
        bench = Bench(dut, vertices, np.ones(len(vertices), bool), cap, 0, 40 * cap)
        bad = word not in (0x3E0001,)
        at = VERTEX * 64 + 32 * int(rng.integers(len(vertices)))
        place = 24 * int(rng.integers(9))
        record = bench.memory.get(at, 32)
        bench.memory.put(at, record & ~(0xFFFFFF << place) | word << place, 32)
        await bench.run()
        assert bench.bad == bad, f"{word:#x}"


@pytest.mark.parametrize("cap", [32])
def test_rc_tbp_bin(cap):
    run_cocotb("rc_tbp_bin", SOURCES, "test_rc_tbp_bin", parameters={"Cap": cap})


def test_level_limit():
    """Nodes at the last level are leaves however many references they have."""
    sources = [package_with_depth(4) if s.name == "rc_tbu_pkg.sv" else s for s in SOURCES]
    run_cocotb("rc_tbp_bin", sources, "test_rc_tbp_bin", parameters={"Cap": 32}, env={"MAX_DEPTH": "4"},
               testcase=[f"shapes/shape={s}" for s in ("soup", "clusters", "flat", "walls")])  # fmt: skip
