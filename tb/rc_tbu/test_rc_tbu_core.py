# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_tbu_core: whole trees by the binning pipeline and stand-ins for the sorting pipelines, in Python, walked in memory.

A stand-in makes one leaf of its job, or divides it once and donates the other child, whenever it likes. So the table of
upper nodes, the loader, routes, extents and ports work as in a real build, and trees are checked node by node. Then faults:
regions too small, bad coordinates, memory errors: each ends with its code, and the next build is right.
"""

import os
import random
from collections import deque

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge
from tbu_tb import CFG, DEST, DONATED, JOB, SHAPES, SUBTREE, WR, Memory, pack, references, unpack, vertex_records

from raycore.model import tbu
from raycore.model.tbu_memory import NODE_NONE, pack_box, unpack_refs, walk_memory
from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "prim/rc_rr_arb.sv", "prim/rc_idx_pool.sv",
              "tbu/rc_tbu_pkg.sv", "tbu/rc_tbp_bin_pkg.sv", "tbu/rc_tbu_fix.sv", "tbu/rc_tbu_box.sv", "tbu/rc_tbu_fetch.sv",
              "tbu/rc_tbp_bin_class.sv", "tbu/rc_tbp_bin_write.sv", "tbu/rc_tbp_bin_axis.sv", "tbu/rc_tbp_bin_eval.sv",
              "tbu/rc_tbp_bin_plane.sv", "tbu/rc_tbp_bin_pass.sv", "tbu/rc_tbp_bin_ctrl.sv", "tbu/rc_tbp_bin.sv",
              "tbu/rc_tbu_load.sv", "tbu/rc_tbu_route.sv", "tbu/rc_tbu_upper.sv", "tbu/rc_tbu_alloc.sv",
              "tbu/rc_tbu_port.sv", "tbu/rc_tbu_core.sv")  # fmt: skip
VERTEX, REF, LIST, NODE = 0x1000, 0x20000, 0x80000, 0xC0000   # lines
SORTERS = 4
SEED = int(os.environ.get("RAYCORE_SEED", "1"), 0)
OK, E_NODE, E_LIST, E_REF, E_COUNT, E_COORD, E_BUS = range(7)
INPUTS = {"job_ready": 1, "ref_ready": 1, "don_valid": 1, "don_job": 149, "don_ref_valid": 1, "don_ref": 128, "ent_ready": 1,
          "donated_valid": 1, "donated": 52, "sub_valid": 1, "sub": 33, "ext_req": 2, "ext_num": 4, "row_valid": 1, "row": 290,
          "sort_idle": 1, "ev_forced": 0}  # fmt: skip
OUTPUTS = {"job_valid": 1, "job": 149, "ref_valid": 1, "ref": 128, "don_ready": 1, "don_ref_ready": 1, "ent_valid": 1,
           "donated_ready": 1, "sub_ready": 1, "ext_gnt": 2, "ext_idx": 24, "row_ready": 1}  # fmt: skip


class Sorter:
    """One stand-in: `steps` is a generator that goes on once a cycle; `out` is driven, `got` was sampled."""

    def __init__(self, bench):
        self.bench = bench
        self.reset()

    def reset(self):
        self.out, self.got = dict.fromkeys(INPUTS, 0), {}
        self.place, self.left = 0, 0
        self.steps = self.run()
        next(self.steps)

    def until(self, valid, ready, **values):
        """Hold `valid` until it is taken."""
        self.out.update(values)
        self.out[valid] = 1
        while True:
            yield
            if self.got[ready]:
                break
        self.out[valid] = 0

    def extent(self, which, num=1):
        self.out["ext_req"], self.out["ext_num"] = 1 << which, num
        while True:
            yield
            if self.got["ext_gnt"] >> which & 1:
                break
        self.out["ext_req"] = 0
        return self.got["ext_idx"]

    def put_node(self, index, word):
        self.bench.nodes_written += 1
        row = pack(WR, kind=0, row=index // 4, strb=3 << 2 * (index % 4), data=word << 64 * (index % 4))
        yield from self.until("row_valid", "row_ready", row=row)

    def leaf(self, words, gap):
        """A leaf of references; returns its index."""
        refs = unpack_refs(words)
        if self.left < gap + 2:
            self.place, self.left = (yield from self.extent(0)) + 128, 128
        index = self.place - 1
        if len(refs) == 1:
            yield from self.put_node(index, 1 | 3 << 24 | int(refs.tri[0]) << 29)
        else:
            n = len(refs)
            first = yield from self.extent(1, -(-n // 256))
            entries = [int(t) | int(o) << 25 | (i == n - 1) << 24
                       for i, (t, o) in enumerate(zip(refs.tri, refs.opaque, strict=True))]  # fmt: skip
            for at in range(0, n, 8):
                part = entries[at : at + 8]
                data = sum(e << 32 * i for i, e in enumerate(part))
                self.bench.entries_written += len(part)
                yield from self.until("row_valid", "row_ready", row=pack(WR, kind=1, row=(first + at) // 8,
                                                                      strb=(1 << len(part)) - 1, data=data))  # fmt: skip
            yield from self.put_node(index, n | 3 << 24 | first << 29)
        return index

    def run(self):
        yield
        while True:
            self.out["sort_idle"] = 1
            self.out["job_ready"] = random.random() < self.bench.p
            yield
            if not (self.out["job_ready"] and self.got["job_valid"]):
                continue
            self.out["job_ready"] = self.out["sort_idle"] = 0
            job, words = unpack(JOB, self.got["job"]), []
            while len(words) < job["count"]:
                self.out["ref_ready"] = random.random() < self.bench.p
                yield
                if self.out["ref_ready"] and self.got["ref_valid"]:
                    words.append(self.got["ref"])
            self.out["ref_ready"] = 0
            for _ in range(self.bench.think()):
                yield
            donated = yield from self.donate(job, words)
            if donated is None:
                index = yield from self.leaf(words, job["gap"])
            else:
                index, entry, plane, swap = donated
                yield from self.until("donated_valid", "donated_ready", donated=pack(
                    DONATED, entry=entry, axis=plane.axis, pos=plane.p, swap=swap, idx=index))  # fmt: skip
            self.left -= self.place - index + job["gap"]
            self.place = index - job["gap"]
            yield from self.until("sub_valid", "sub_ready", sub=pack(SUBTREE, dest=job["dest"], idx=index))

    def donate(self, job, words):
        refs = unpack_refs(words)
        box = np.array([[job["box"] >> 18 * (3 * h + a) & 0x3FFFF for a in range(3)] for h in (0, 1)])
        if not self.bench.want or len(refs) < 6 or random.random() > self.bench.p_donate:
            return None
        plane = tbu.sorted_plane(refs, box)
        if plane.axis < 0:
            return None
        parts, boxes = tbu.partition(refs, box, plane), tbu.child_boxes(box, plane)
        if not len(parts[0]) or not len(parts[1]):
            return None
        size = [b[1] - b[0] for b in boxes]
        half = [int(s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) for s in size]
        swap = int(half[1] > half[0])
        self.out["ent_ready"] = 1
        while True:
            yield
            if self.got["ent_valid"]:
                break
        self.out["ent_ready"], entry = 0, self.bench.ent_idx
        other = 1 - swap
        below = pack(JOB, dest=pack(DEST, root=0, upper=other, entry=entry), gap=0, level=job["level"] + 1,
                     count=len(parts[other]), box=pack_box(boxes[other][0], boxes[other][1]))  # fmt: skip
        yield from self.until("don_valid", "don_ready", don_job=below)
        index = {r: w for r, w in zip(refs.tri.tolist(), words, strict=True)}
        for t in parts[other].tri.tolist():
            yield from self.until("don_ref_valid", "don_ref_ready", don_ref=index[t])
        self.bench.donations += 1
        adjacent = yield from self.leaf([index[t] for t in parts[swap].tri.tolist()], job["gap"] + 1)
        return adjacent - 1, entry, plane, swap


class Bench:
    def __init__(self, dut, p=1.0, latency=lambda: 5, think=lambda: 20, p_donate=0.0):
        self.dut, self.p, self.latency, self.think, self.p_donate = dut, p, latency, think, p_donate
        self.sorters = [Sorter(self) for _ in range(SORTERS)]
        self.reads, self.writes, self.now = deque(), deque(), 0
        self.spoil_read = self.spoil_write = None

    def fill(self, vertices, opaque):
        self.memory = Memory(SEED)
        for i, record in enumerate(vertex_records(vertices, opaque)):
            self.memory.put(VERTEX * 64 + 32 * i, record, 32)
        self.refs = references(vertices, opaque)

    async def cycle(self, start=False):
        dut = self.dut
        dut.start_i.value = start
        for name, width in INPUTS.items():
            getattr(dut, f"{name}_i").value = sum(s.out[name] << width * i for i, s in enumerate(self.sorters))
        due = bool(self.reads) and self.reads[0][0] <= self.now and random.random() < self.p
        dut.rd_rsp_valid_i.value, dut.mem_err_i.value, dut.wr_ack_i.value = due, 0, 0
        if due:
            line = self.reads.popleft()[1]
            dut.rd_rsp_block_i.value = self.memory.get(line * 64, 64)
            dut.mem_err_i.value = line == self.spoil_read
        dut.rd_ready_i.value = len(self.reads) < 16 and random.random() < self.p
        dut.wr_ready_i.value = len(self.writes) < 16 and random.random() < self.p
        if self.writes and self.writes[0][0] <= self.now:
            _, byte, data, strb = self.writes.popleft()
            self.memory.row(byte, data, strb)
            dut.wr_ack_i.value = 1
            if byte // 64 == self.spoil_write:
                dut.mem_err_i.value = 1
        dut.wr_idle_i.value = not self.writes
        await FallingEdge(dut.clk_i)
        outs = {name: int(getattr(dut, f"{name}_o").value) for name in OUTPUTS}
        self.want, self.ent_idx = bool(dut.don_want_o.value), int(dut.ent_idx_o.value)
        self.done, self.busy = bool(dut.done_o.value), bool(dut.busy_o.value)
        if dut.rd_valid_o.value and dut.rd_ready_i.value:
            line = int(dut.rd_addr_o.value)
            limit = (VERTEX, VERTEX + (len(self.refs) + 1) // 2) if line < REF else (REF, REF + self.ref_count // 4)
            assert limit[0] <= line < limit[1], f"reads line {line:#x}"
            self.reads.append((max(self.reads[-1][0] if self.reads else 0, self.now + self.latency()), line))
        if dut.wr_valid_o.value and dut.wr_ready_i.value:
            byte = int(dut.wr_addr_o.value)
            limits = ((REF, self.ref_count * 16), (LIST, self.list_count * 4), (NODE, self.node_count * 8))
            assert any(base * 64 <= byte < base * 64 + size for base, size in limits), f"writes {byte:#x}"
            self.writes.append((max(self.writes[-1][0] if self.writes else 0, self.now + self.latency()), byte,
                                int(dut.wr_data_o.value), int(dut.wr_strb_o.value)))  # fmt: skip
        await RisingEdge(dut.clk_i)
        for i, s in enumerate(self.sorters):
            s.got = {name: outs[name] >> width * i & (1 << width) - 1 for name, width in OUTPUTS.items()}
            if dut.sort_rst_no.value:
                next(s.steps)
            else:
                s.reset()
        self.now += 1

    async def build(self, vertices, opaque, refine_max=0, nodes=256, lists=512, refs=None, tri_count=None, limit=40_000):
        """One build; returns its code."""
        cap = int(self.dut.Cap.value)
        self.fill(vertices, opaque)
        self.node_count, self.list_count = 128 * nodes, 256 * lists
        self.ref_count = 16 * cap + 8 * len(vertices) + 64 if refs is None else refs
        self.nodes_written = self.entries_written = self.donations = 0
        box, begin = self.refs.box, self.now
        self.dut.cfg_i.value = pack(
            CFG, vertex_base=VERTEX, tri_count=len(vertices) if tri_count is None else tri_count, node_base=NODE,
            node_count=self.node_count, list_base=LIST, list_count=self.list_count, ref_base=REF, ref_count=self.ref_count,
            refine_max=refine_max, box=pack_box(box[0], box[1]), node_first=0, list_first=0, tri_first=0)  # fmt: skip
        await self.cycle(start=True)
        await self.cycle()
        assert self.busy
        while not self.done:
            await self.cycle()
            assert self.now - begin < limit, "hangs"
        assert not self.reads and not self.writes, "ended before memory did"
        self.took = self.now - begin
        await self.cycle()
        assert not self.busy
        code = int(self.dut.err_o.value)
        assert (int(self.dut.root_o.value) == NODE_NONE) == (code != OK), "a root without a tree, or none"
        return code

    def check(self, cap, refine_max):
        """The tree in memory against the model; jobs are leaves, or inner nodes by one donation."""
        refs = self.refs
        expected = tbu.upper_tree(refs, cap=cap, refine_max=refine_max)
        nodes = np.array([self.memory.get(NODE * 64 + 8 * i, 8) for i in range(self.node_count)], np.uint64)
        lists = np.array([self.memory.get(LIST * 64 + 4 * i, 4) for i in range(self.list_count)], np.uint32)
        found = walk_memory(nodes, lists, int(self.dut.root_o.value), refs.box)

        def job(row, members, box, depth):
            if found.kind[row] == tbu.LEAF:
                assert found.leaf(row) == members.tri.tolist()
                return
            plane = tbu.sorted_plane(members, box)
            assert (found.kind[row], found.plane[row]) == (plane.axis, plane.p)
            parts, boxes = tbu.partition(members, box, plane), tbu.child_boxes(box, plane)
            for child, part, below in zip((found.lower[row], found.upper[row]), parts, boxes, strict=True):
                job(child, part, below, depth + 1)

        def walk(row, want):
            if expected.kind[want] == tbu.JOB:
                first = expected.first[want]
                tri = expected.members[first : first + expected.count[want]]
                job(row, refs[tri], expected.box[want], 0)
                return
            where = f"at {expected.path(want)}"
            for name in ("kind", "swap", "count"):
                assert getattr(found, name)[row] == getattr(expected, name)[want], f"{where}: {name}"
            if expected.kind[want] == tbu.LEAF:
                assert found.leaf(row) == expected.leaf(want), where
                return
            assert found.plane[row] == expected.plane[want], where
            for side in ("lower", "upper"):
                a, b = getattr(found, side)[row], getattr(expected, side)[want]
                assert (a < 0) == (b < 0), f"{where}: {side}"
                if a >= 0:
                    walk(a, b)

        walk(0, 0)
        return expected


async def reset(dut):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = 0
    for name in [*INPUTS, "start", "cfg", "rd_ready", "rd_rsp_valid", "rd_rsp_block", "wr_ready", "wr_ack", "wr_idle", "mem_err"]:
        getattr(dut, f"{name}_i").value = 0
    await RisingEdge(dut.clk_i)
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1


def flags(n):
    return np.random.default_rng(SEED).random(n) < 0.7


def stat(dut):
    word = int(dut.stat_o.value)
    names = ("cycles", "nodes", "entries", "jumps", "jobs", "donations", "forced", "lines", "rows", "waits")
    return {n: word >> 32 * (len(names) - 1 - i) & 0xFFFFFFFF for i, n in enumerate(names)}


@cocotb.test(timeout_time=50, timeout_unit="ms")
@cocotb.parametrize(p=[1.0, 0.4], p_donate=[0.0, 0.7])
async def trees(dut, p, p_donate):
    """Builds one after the other; slow and fast memory and pipelines; with and without donation."""
    await reset(dut)
    rng, cap = np.random.default_rng([SEED, int(10 * p), int(10 * p_donate)]), int(dut.Cap.value)
    latency = random.choice([lambda: 5, lambda: random.choice([10, 60])])
    bench = Bench(dut, p, latency, lambda: random.choice([1, 30, 500]), p_donate)
    donations = 0
    for n, shape in ((0, "soup"), (1, "soup"), (cap, "soup"), (8 * cap, "soup"), (4 * cap, "same"), (9 * cap, "walls"),
                     (6 * cap, "dense"), (5 * cap, "clusters")):  # fmt: skip
        refine = random.choice([0, 3 * cap])
        assert await bench.build(SHAPES[shape](rng, n), flags(n), refine) == OK
        expected = bench.check(cap, refine)
        figures = stat(dut)
        assert figures["donations"] == bench.donations and figures["jobs"] == (expected.kind == tbu.JOB).sum()
        leaves = expected.kind == tbu.LEAF
        own = int((expected.kind < 3).sum() + leaves.sum()) + bench.donations
        assert figures["nodes"] == bench.nodes_written + own
        assert figures["entries"] == bench.entries_written + int(expected.count[leaves].sum())
        assert figures["jumps"] == 0 and 0 <= bench.took - figures["cycles"] < 8
        donations += bench.donations
        dut._log.info(f"{shape}: {n} triangles, {figures}")
    assert (donations > 0) == (p_donate > 0)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def regions_too_small(dut):
    """Nodes, lists, working memory: the code, nothing outside; one step larger, down to the least that does."""
    await reset(dut)
    assert int(dut.root_o.value) == NODE_NONE
    rng, cap = np.random.default_rng(SEED), int(dut.Cap.value)
    bench = Bench(dut, 0.7, lambda: random.choice([5, 40]))
    v = SHAPES["soup"](rng, 5 * cap)
    for code, name in ((E_NODE, "nodes"), (E_LIST, "lists"), (E_REF, "refs")):
        for size in (0, 1, 2, 16 * cap, 19 * cap) if name == "refs" else (0, 1, 2):
            assert await bench.build(v, flags(len(v)), **{name: size}) == code, f"{name} {size}"
    assert await bench.build(v, flags(len(v))) == OK
    bench.check(cap, 0)
    same = SHAPES["same"](rng, 17 * cap)               # a leaf that needs two extents in one piece
    assert await bench.build(same, flags(len(same)), lists=1) == E_LIST
    assert await bench.build(same, flags(len(same)), lists=2, nodes=1) == OK
    bench.check(cap, 0)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def faults(dut):
    """Bad coordinates, too many triangles, memory errors at any time: the code, and the next build is right."""
    await reset(dut)
    rng, cap = np.random.default_rng(SEED), int(dut.Cap.value)
    bench = Bench(dut, 0.7, lambda: random.choice([5, 40]), p_donate=0.5)
    v = SHAPES["soup"](rng, 4 * cap)
    assert await bench.build(v, flags(len(v)), tri_count=(1 << 19) + 1) == E_COUNT
    for n in (cap // 2, 4 * cap):                      # by the loader, by the binning pipeline
        bad = SHAPES["soup"](rng, n)
        bad[n // 2, 1, 2] = 1
        records = vertex_records(bad, flags(n))
        fill = bench.fill

        def spoilt(vertices, opaque, n=n, records=records, fill=fill):
            fill(vertices, opaque)
            bench.memory.put(VERTEX * 64 + 32 * (n // 2), records[n // 2] | 0xFFFFFF << 24 * 5, 32)

        bench.fill = spoilt
        assert await bench.build(bad, flags(n)) == E_COORD
        bench.fill = fill
    assert await bench.build(v, flags(len(v))) == OK
    bench.check(cap, 0)
    for line in (VERTEX, VERTEX + 7, REF + 4 * cap + 3, REF + 1):
        bench.spoil_read = line
        assert await bench.build(v, flags(len(v))) == E_BUS, f"read of {line:#x}"
        bench.spoil_read = None
    for line in (REF + 4 * cap, REF + 1, NODE + bench.node_count // 8 - 1, LIST):
        bench.spoil_write = line
        assert await bench.build(v, flags(len(v))) == E_BUS, f"write of {line:#x}"
        bench.spoil_write = None
    assert await bench.build(v, flags(len(v))) == OK
    bench.check(cap, 0)


@pytest.mark.parametrize("cap", [16])
def test_rc_tbu_core(cap):
    run_cocotb("rc_tbu_core", SOURCES, "test_rc_tbu_core", parameters={"Cap": cap})
