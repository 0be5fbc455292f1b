# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_tbu_upper alone: random trees whose jobs finish in any order, read back node by node; more nodes than entries.

The binning pipeline is Python: it makes nodes depth first, and waits when the table is full. Jobs report some time later,
some of them with a donated part, whose place and whose child's address come in either order.
"""

import os
import random
from collections import deque

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge
from tbu_tb import DEST, DONATED, LEAF, SPLIT, SUBTREE, WR, pack, unpack

from raycore.model.tbu import fp24_from_fixed
from raycore.tbutil import rtl, run_cocotb

SOURCES = rtl("prim/rc_skid.sv", "prim/rc_ram_1r1w.sv", "prim/rc_fifo.sv", "prim/rc_rr_arb.sv", "prim/rc_idx_pool.sv",
              "tbu/rc_tbu_pkg.sv", "tbu/rc_tbp_bin_pkg.sv", "tbu/rc_tbu_upper.sv")  # fmt: skip
SEED = int(os.environ.get("RAYCORE_SEED", "1"), 0)
ROOT = pack(DEST, root=1, upper=0, entry=0)


class Node:
    """A node of the tree wanted: kind job, leaf, or an axis; children [lower, upper], None if empty."""

    def __init__(self, depth, comb=False):
        self.gap = 0
        r = random.random() if depth < 4 else 1.0      # large trees need more entries than there are
        self.kind = "leaf" if r < (0.02 if depth else 0.4) else "job" if depth == 0 or r < 0.1 else random.randrange(3)
        if comb:                                       # long ways of adjacent children, leaves with many places below
            self.kind = random.randrange(3) if depth else "leaf"
        self.first, self.count = random.getrandbits(24), random.getrandbits(20)
        self.donates = self.kind == "job" and random.random() < 0.3
        if self.donates:
            self.axis, self.pos, self.swap = random.randrange(3), random.randrange(1, 1 << 18), random.randrange(2)
        if self.kind in (0, 1, 2):
            self.pos, self.swap = random.choice([1, 1 << 17, (1 << 18) - 1, random.randrange(1, 1 << 18)]), random.randrange(2)
            self.child = [None, None]
            self.child[self.swap] = Node(depth - 1, comb)
            self.child[1 - self.swap] = Node(random.randrange(min(depth, 6)) if comb else depth - 1, comb)
            if not comb and random.random() < 0.15:
                self.child[1 - self.swap] = None


class Bench:
    def __init__(self, dut, p, delay):
        self.dut, self.p, self.delay = dut, p, delay
        self.nodes, self.now, self.waited = {}, 0, 0
        self.top = 1 << 23                             # places of jobs, falling
        self.subs = [[] for _ in range(4)]             # (due, word) by pipeline, any order
        self.dons = [[] for _ in range(4)]
        self.offer_sub, self.offer_don = [None] * 4, [None] * 4
        self.entry_for, self.extent = deque(), 1 << 12
        self.split = self.leaf = None

    def place(self, gap):
        """A free place with `gap` free ones below, and something between."""
        place = self.top
        self.top -= gap + 1 + random.randrange(9)
        return place

    def put(self, index, word):
        assert index not in self.nodes, f"node {index:#x} written twice"
        self.nodes[index] = word

    async def cycle(self):
        dut = self.dut
        dut.wr_ready_i.value = random.random() < self.p
        for name, word in (("split", self.split), ("leaf", self.leaf)):
            getattr(dut, f"{name}_valid_i").value = word is not None
            if word is not None:
                getattr(dut, f"{name}_i").value = word
        for name, width, todo, offer in (("sub", 33, self.subs, self.offer_sub), ("don", 52, self.dons, self.offer_don)):
            for i in range(4):
                due = [x for x in todo[i] if x[0] <= self.now]
                if offer[i] is None and due and random.random() < self.p:
                    offer[i] = random.choice(due)
                    todo[i].remove(offer[i])
            getattr(dut, f"{name}_valid_i").value = sum((o is not None) << i for i, o in enumerate(offer))
            getattr(dut, f"{name}_i").value = sum(o[1] << width * i for i, o in enumerate(offer) if o is not None)
        dut.ent_offer_i.value = random.randrange(16)
        dut.ent_ready_i.value = 15 if self.entry_for else 0
        dut.ext_gnt_i.value = 0
        grant = random.random() < self.p
        await FallingEdge(dut.clk_i)
        if dut.ext_req_o.value and grant:
            dut.ext_gnt_i.value, dut.ext_idx_i.value = 1, self.extent
            self.extent += 128
        for name, offer in (("sub", self.offer_sub), ("don", self.offer_don)):
            ready = int(getattr(dut, f"{name}_ready_o").value)
            for i in range(4):
                if offer[i] is not None and ready >> i & 1:
                    offer[i] = None
        offered = int(dut.ent_valid_o.value)
        assert offered & ~int(dut.ent_offer_i.value) == 0 and offered.bit_count() <= 1
        if offered and self.entry_for:
            self.donate(*self.entry_for.popleft(), int(dut.ent_idx_o.value))
        if dut.wr_valid_o.value and dut.wr_ready_i.value:
            wr = unpack(WR, int(dut.wr_o.value))
            at = [i for i in range(4) if wr["strb"] >> 2 * i & 3]
            assert wr["kind"] == 0 and len(at) == 1 and wr["strb"] == 3 << 2 * at[0]
            self.put(4 * wr["row"] + at[0], wr["data"] >> 64 * at[0] & (1 << 64) - 1)
        self.taken = (bool(dut.split_ready_o.value), int(dut.split_entry_o.value), bool(dut.leaf_ready_o.value))
        self.done = bool(dut.done_o.value)
        self.now += 1
        assert self.now < 100_000, "hangs"
        await RisingEdge(dut.clk_i)

    def later(self, todo, word):
        random.choice(todo).append((self.now + self.delay(), word))

    def donate(self, node, dest, entry):
        """The adjacent child at a place, its parent below, the other child somewhere else; both told, in any order."""
        adjacent = self.place(node.gap + 1)
        other = self.place(0)
        self.put(adjacent, "adjacent")
        self.put(other, "other")
        node.at, node.other = adjacent - 1, other
        self.later(self.dons, pack(DONATED, entry=entry, axis=node.axis, pos=node.pos, swap=node.swap, idx=adjacent - 1))
        self.later(self.subs, pack(SUBTREE, dest=pack(DEST, root=0, upper=1 - node.swap, entry=entry), idx=other))
        self.later(self.subs, pack(SUBTREE, dest=dest, idx=adjacent - 1))

    async def make(self, node, dest, gap):
        node.gap = gap
        if node.kind == "job" and node.donates:
            self.entry_for.append((node, dest))
        elif node.kind == "job":
            node.at = self.place(gap)
            self.put(node.at, "job")
            self.later(self.subs, pack(SUBTREE, dest=dest, idx=node.at))
        elif node.kind == "leaf":
            self.leaf = pack(LEAF, dest=dest, gap=gap, first=node.first, count=node.count)
            while True:
                await self.cycle()
                if self.taken[2]:
                    break
            self.leaf = None
        else:
            empty = [c is None for c in node.child]
            self.split = pack(SPLIT, dest=dest, axis=node.kind, pos=node.pos, swap=node.swap, lower_empty=empty[0],
                              upper_empty=empty[1])  # fmt: skip
            while True:
                await self.cycle()
                if self.taken[0]:
                    break
                self.waited += 1
            self.split, entry = None, self.taken[1]
            assert entry < 64
            for upper in random.sample([0, 1], 2):
                if node.child[upper] is not None:
                    await self.make(node.child[upper], pack(DEST, root=0, upper=upper, entry=entry),
                                    gap + 1 if upper == node.swap else 0)  # fmt: skip

    def check(self, node, index, gap=0):
        word = self.nodes.pop(index)
        if node.kind == "job" and not node.donates:
            assert word == "job" and index == node.at
        elif node.kind == "leaf":
            assert word == node.count | 3 << 24 | node.first << 29
            assert index % 128 >= gap, "the free places below a leaf are not all in its extent"
        elif node.kind == "job":
            assert index == node.at
            assert word == int(fp24_from_fixed(node.pos)) | node.axis << 24 | node.swap << 26 | node.other << 29
            assert self.nodes.pop(index + 1) == "adjacent" and self.nodes.pop(node.other) == "other"
        else:
            empty = [c is None for c in node.child]
            low = int(fp24_from_fixed(node.pos)) | node.kind << 24 | node.swap << 26 | empty[0] << 27 | empty[1] << 28
            assert word & 0x1FFFFFFF == low and word >> 53 == 0
            self.check(node.child[node.swap], index + 1, gap + 1)
            if node.child[1 - node.swap] is None:
                assert word >> 29 == 0
            else:
                self.check(node.child[1 - node.swap], word >> 29)


@cocotb.test(timeout_time=20, timeout_unit="ms")
@cocotb.parametrize(p=[1.0, 0.4], delay=[2, 4000])
async def random_trees(dut, p, delay):
    """Every node at the right place with the right words, and no others; with late jobs the table fills."""
    Clock(dut.clk_i, 10, unit="ns").start()
    waited = donated = 0
    for n in range(12):
        dut.rst_ni.value = 0
        for name in ("split_valid", "leaf_valid", "ent_ready", "ent_offer", "don_valid", "sub_valid", "ext_gnt", "wr_ready"):
            getattr(dut, f"{name}_i").value = 0
        await RisingEdge(dut.clk_i)
        await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1
        random.seed(f"{SEED} {p} {delay} {n}")
        bench = Bench(dut, p, lambda: random.randrange(delay))
        tree = Node((0, 1, 30, 8)[n % 4], n % 4 == 2)
        await bench.make(tree, ROOT, 0)
        bench.done = False
        while not bench.done:
            await bench.cycle()
        assert not any(bench.subs) and not any(bench.dons) and bench.offer_sub == bench.offer_don == [None] * 4
        donated += sum(v == "other" for v in bench.nodes.values())
        bench.check(tree, int(dut.root_o.value))
        assert not bench.nodes, "nodes that nobody points at"
        waited = max(waited, bench.waited)
    assert donated and (delay < 100 or waited > 0), "the table was never full"


def test_rc_tbu_upper():
    run_cocotb("rc_tbu_upper", SOURCES, "test_rc_tbu_upper")
