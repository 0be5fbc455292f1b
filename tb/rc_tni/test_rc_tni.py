# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_tni against raycore.model.tracer: every hit bit for bit, every step accounted for, whatever the memory does."""

import os
import random

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge
from tni_bench import INST_BASE, Bench, Objects, blocks, ray_word, soup, turned

from raycore import kdtree
from raycore.tbutil import package_with_latencies, rtl, run_cocotb

SOURCES = [
    "prim/rc_delay.sv", "prim/rc_fifo.sv", "prim/rc_idx_pool.sv", "prim/rc_ram_1r1w.sv", "prim/rc_rr_arb.sv",
    "prim/rc_skid.sv", "fp/rc_fp_pipe.sv", "fp/rc_fp_norm.sv", "fp/rc_fp_round.sv", "fp/rc_fp_add.sv",
    "fp/rc_fp_add3.sv", "fp/rc_fp_mul.sv", "fp/rc_fp_cmp.sv", "fp/rc_fp_div.sv", "mem/rc_l1_pend.sv", "mem/rc_l1.sv",
    "mem/rc_l2_mshr.sv", "mem/rc_l2_victim.sv", "mem/rc_l2.sv", "tni/rc_tni_pkg.sv", "tni/rc_tni_step.sv",
    "tni/rc_tni_box.sv", "tni/rc_tni_front.sv", "tni/rc_tni_back.sv", "tni/rc_tni_stack.sv", "tni/rc_tni_rays.sv",
    "tni/rc_tni_next.sv", "tni/rc_tni_pipe.sv", "tni/rc_tni.sv",
]  # fmt: skip
HIT_W = 120  # hit_t without the id
EVENTS = ["ray_out", "ray_in", "list_hit", "nt_hit", "bubble", "miss_list", "miss_nt", "isect", "trav2", "trav1", "box"]


async def start(dut, bench, max_slots=0xFFFF):
    Clock(dut.clk_i, 10, unit="ns").start()
    dut.rst_ni.value = 0
    for port in (dut.in_valid_i, dut.in_home_i, dut.out_ready_i, dut.rsp_valid_i, dut.req_ready_i):
        port.value = 0
    dut.cfg_i.value = bench.cfg(max_slots)
    await ClockCycles(dut.clk_i, 3)
    dut.rst_ni.value = 1


async def memory(dut, half, latency, p_ready):
    """Answer halves of lines in order after `latency(i)` cycles, one a cycle at most."""
    cycle, queue = 0, []
    ready = False
    while True:
        await RisingEdge(dut.clk_i)
        cycle += 1
        if ready and dut.req_valid_o.value:
            queue.append((cycle + latency(), int(dut.req_addr_o.value)))
        dut.rsp_valid_i.value = 0
        if queue and queue[0][0] <= cycle:
            dut.rsp_valid_i.value, dut.rsp_half_i.value = 1, half(queue.pop(0)[1])
        ready = random.random() < p_ready
        dut.req_ready_i.value = ready


async def count_events(dut, totals):
    while True:
        await RisingEdge(dut.clk_i)
        word = int(dut.ev_o.value)
        for p in range(4):
            for i, name in enumerate(EVENTS):
                totals[name] = totals.get(name, 0) + (word >> (11 * p + i) & 1)


async def trace(dut, rays, p_valid=1.0, p_ready=1.0, patience=40_000):
    """Send every ray, at most 256 in flight; returns hit words without the id, by ray, and the cycles it took.

    The slowest memory gives a ray in 1,500 cycles; none in `patience` cycles means that rays are lost or stuck.
    """
    hits, owner, free, sent, cycle, last = {}, {}, list(range(256)), 0, 0, 0
    valid = ready = False
    while len(hits) < len(rays):
        await RisingEdge(dut.clk_i)
        cycle += 1
        assert cycle < last + patience, f"{len(rays) - len(hits)} of {len(rays)} rays never came back"
        assert not dut.err_valid_o.value, f"error {int(dut.err_o.value):09x}"
        if valid and dut.in_ready_o.value:
            sent, valid = sent + 1, False
        if ready and dut.out_valid_o.value:
            word = int(dut.out_o.value)
            ident = word >> HIT_W
            hits[owner.pop(ident)] = word & ((1 << HIT_W) - 1)
            free.append(ident)
            last = cycle
        if not valid and sent < len(rays) and free and random.random() < p_valid:
            ident = free.pop(random.randrange(len(free)))
            owner[ident] = sent
            dut.in_i.value, valid = ray_word(ident, rays[sent]), True
            dut.in_home_i.value = random.randrange(4)
        dut.in_valid_i.value = valid
        ready = random.random() < p_ready
        dut.out_ready_i.value = ready
    dut.in_valid_i.value = 0
    return [hits[i] for i in range(len(rays))], cycle


async def compare(dut, bench, count, latency, p_ready):
    """Random rays through a bench: hits and slots against the model. Returns: events, the model's slots, cycles."""
    rays = bench.random_rays(count)
    want, slots = bench.expect(rays)
    await start(dut, bench)
    tasks = [cocotb.start_soon(memory(dut, bench.half, latency, p_ready)), cocotb.start_soon(count_events(dut, got := {}))]
    hits, cycles = await trace(dut, rays, p_valid=random.choice([0.3, 1.0]), p_ready=p_ready)
    await ClockCycles(dut.clk_i, 5)
    for task in tasks:
        task.cancel()
    wrong = [i for i in range(count) if hits[i] != want[i]]
    assert not wrong, f"{len(wrong)} of {count} rays differ, first {wrong[0]}: {rays[wrong[0]]}\n" \
                      f"got  {hits[wrong[0]]:028x}\nwant {want[wrong[0]]:028x}"  # fmt: skip
    total = dict(zip(("box", "trav1", "trav2", "isect"), slots.sum(0).tolist(), strict=True))
    # A second step needs its half of the line in the cache, which depends on timing: steps count, not slots.
    assert (got["box"], got["isect"]) == (total["box"], total["isect"]), (got, total)
    assert got["trav1"] + 2 * got["trav2"] == total["trav1"] + 2 * total["trav2"], (got, total)
    assert 0 < got["trav2"] <= total["trav2"]
    assert got["ray_in"] == got["ray_out"] == count
    return got, total, cycles


@cocotb.test()
async def random_rays(dut):
    """Rays of every kind through soups of triangles and rows of boxes: hits and slots equal the model's.

    Among boxes, rays that start at a vertex's height and stay there make TriAccel records look like nodes in whose plane
    the ray lies.
    """
    seed, count = int(os.environ["RAYCORE_SEED"]), int(os.environ.get("TNI_RAYS", "1500"))
    for mesh, latency, p_ready in [(soup(400, 0.15, seed), lambda: 60, 1.0),
                                   (soup(3000, 0.02, seed), lambda: random.randint(1, 400), 0.5),
                                   (soup(60, 0.6, seed), lambda: 1, 0.9), (blocks(4), lambda: 20, 1.0)]:  # fmt: skip
        triangles = len(mesh)
        bench = Bench(mesh, kdtree.Params(max_leaf=random.choice([1, 2, 4])))
        got, total, cycles = await compare(dut, bench, count, latency, p_ready)
        cocotb.log.info("%d triangles: %d cycles, %.1f slots a ray, %d lost to misses", triangles, cycles,
                        sum(total.values()) / count, got["miss_nt"] + got["miss_list"])  # fmt: skip


@cocotb.test()
async def objects(dut):
    """Dynamic objects before a static tree: apart, one within the other, none hit, many, nothing static, listed twice."""
    seed, count = int(os.environ["RAYCORE_SEED"]), int(os.environ.get("TNI_RAYS", "1500"))
    worlds = [
        Objects(soup(300, 0.15, seed), [soup(40, 0.1, seed + i) * 0.3 + [0.5 * i - 0.6, 0.1 * i, 0.2] for i in range(4)]),
        Objects(soup(30, 0.3, seed), [soup(80, 0.3, seed + i) for i in range(3)], kdtree.Params(max_leaf=1)),
        Objects(soup(200, 0.1, seed) * 0.2, [blocks(2) * 0.1 + [(i % 4) / 2 - 0.8, i // 4 % 4 / 2 - 0.8, i // 16 / 2 - 0.8]
                                             for i in range(64)], kdtree.Params(max_leaf=4)),
        Objects(soup(300, 0.1, seed) * 0.3 - 0.5, [soup(50, 0.1, seed) * 0.1 + 0.8]),
        Objects(np.zeros((0, 3, 3)), [soup(100, 0.2, seed), soup(60, 0.2, seed + 1) * 0.5]),
        Objects(soup(100, 0.2, seed), [soup(60, 0.3, seed), soup(30, 0.3, seed + 1)], cut=True),
    ]
    for bench in worlds:
        latency, p_ready = random.choice([(lambda: 60, 1.0), (lambda: random.randint(1, 400), 0.5), (lambda: 1, 0.9)])
        _, total, _ = await compare(dut, bench, count, latency, p_ready)
        cocotb.log.info("%d objects: slots a ray %s", len(bench.instances) - 1, {k: v / count for k, v in total.items()})


@cocotb.test()
async def placed_objects(dut):
    """Objects in coordinates of their own: one shape in many places, beside others that are not placed, all listed twice."""
    seed, count = int(os.environ["RAYCORE_SEED"]), int(os.environ.get("TNI_RAYS", "1500"))
    rng = np.random.default_rng(seed)
    shapes = [soup(80, 0.3, seed) * 0.3, blocks(2) * 0.2, soup(30, 0.2, seed + 1) * 0.4]

    def places(n, reach):
        return [(int(rng.integers(2)), turned(rng), rng.uniform(-reach, reach, 3)) for _ in range(n)]

    worlds = [
        Objects(soup(200, 0.1, seed) * 0.5, [*shapes, *shapes[:1] * 9], places=[None] * 3 + places(9, 0.7)),
        Objects(soup(60, 0.2, seed), [*shapes[:2], *shapes[:1] * 4], kdtree.Params(max_leaf=1), True, places(6, 0.2)),
        Objects(np.zeros((0, 3, 3)), [*shapes, *shapes[:1] * 60], kdtree.Params(max_leaf=4), places=places(63, 0.8)),
    ]
    for bench in worlds:
        latency, p_ready = random.choice([(lambda: 60, 1.0), (lambda: random.randint(1, 400), 0.5), (lambda: 1, 0.9)])
        _, total, _ = await compare(dut, bench, count, latency, p_ready)
        cocotb.log.info("%d objects: slots a ray %s", len(bench.instances) - 1, {k: v / count for k, v in total.items()})


@cocotb.test()
async def bad_memory(dut):
    """Bad indices are reported with their cause, and never asked for."""
    bench = Bench(soup(300, 0.2, 7))
    rays = bench.random_rays(40)
    inner = [i for i, n in enumerate(bench.tree.nodes) if int(n) >> 24 & 3 != 3]
    for what, code in [("node", 1), ("list", 2), ("tri", 3), ("loop", 5), ("instance", 16), ("root", 1)]:
        if what == "instance":
            bench = Objects(soup(100, 0.2, 7), [soup(60, 0.2, i) for i in range(5)], kdtree.Params(max_leaf=4))
            rays, rest = bench.random_rays(40), len(bench.instances)
            bench.instances = bench.instances[:2]
        if what == "root":
            bench.instances = np.zeros(rest)
            for line, words in bench.lines.items():
                if line >= INST_BASE:
                    words[0], words[4] = (w & ~0xFFFFFF | 0xFFFFF0 for w in (words[0], words[4]))
        saved = {k: list(v) for k, v in bench.lines.items()}
        for line, words in bench.lines.items():
            for i in range(8):
                if what == "tri" and 0x4000 <= line < 0x8000:
                    words[i] |= 0x0FFFFFF0 << 32 & 0xFFFFFF << 32 | 0xFFFFF0
                if line < 0x4000 and words[i] >> 24 & 3 == 3 and what == "list":
                    words[i] = words[i] & ~(0xFFFFFF << 29 | 0xFFFFF) | 0xFFFFF0 << 29 | 2
                if line < 0x4000 and words[i] >> 24 & 3 != 3 and what in ("node", "loop"):
                    far = 0xFFFFF0 if what == "node" else bench.tree.root
                    words[i] = words[i] & ~(0xFFFFFF << 29 | 3 << 27) | far << 29
        await start(dut, bench, max_slots=2000)
        task = cocotb.start_soon(memory(dut, bench.half, lambda: 20, 1.0))
        dut.out_ready_i.value = 1
        for cycle in range(120_000):
            await RisingEdge(dut.clk_i)
            dut.in_valid_i.value = 1
            dut.in_i.value = ray_word(cycle % 256, rays[cycle % len(rays)])
            if dut.err_valid_o.value:
                break
        assert dut.err_valid_o.value, f"{what}: no error"
        got = int(dut.err_o.value) >> 32
        assert got == code or (what == "loop" and got in (4, 5)), f"{what}: code {got}"
        task.cancel()
        dut.in_valid_i.value = 0
        bench.lines = saved
    assert inner


# Deeper units must give a longer ring and the same hits; its loop must still fit the L1 lock twice.
DEEP = {"ADD": 4, "ADD3": 5, "MUL": 3, "CMP": 2, "DIV": 9}


@pytest.mark.parametrize("config", ["paper", "deep"])
def test_rc_tni(config):
    """Small caches with the paper's latencies, default ones (frames test those too) with deep pipelines."""
    if config == "paper":
        run_cocotb("rc_tni", rtl(*SOURCES), "test_rc_tni", parameters={"NtSets": 16, "ListSets": 8, "L2Sets": 16},
                   env={"TNI_RAYS": "400"})
    else:
        sources = [package_with_latencies(**DEEP), *rtl(*SOURCES, package=False)]
        run_cocotb("rc_tni", sources, "test_rc_tni", parameters={"L1Lock": 128}, env={"TNI_RAYS": "300"})
