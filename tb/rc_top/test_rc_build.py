# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_top with its tree builder: frames that build, render or both, over AXI4-Lite and a memory that pauses, with the
stand-in for the ray-tracing unit, whose picture depends on the root and on the nodes near it. Trees equal the model's."""
import os
import random
from dataclasses import replace
from types import SimpleNamespace

import cocotb
import numpy as np
from cocotb.triggers import RisingEdge
from host import Host
from standin import scene, sources

from raycore import tbu
from raycore.model import tbu as model
from raycore.model.tbu_memory import NODE_NONE, compare, walk_memory
from raycore.tbutil import run_cocotb
from raycore.toolchain import REPO

RENDER, BUILD = 1, 2
ERR_SLVERR, ERR_WINDOW, ERR_CONFIG = 6, 8, 10
ERR_NODE, ERR_LIST, ERR_REF, ERR_COUNT, ERR_COORD = 11, 12, 13, 14, 15
VERTICES, NODES, LISTS, REFS = 0x18000, 0x20000, 0x30000, 0x38000
CAP, REFINE = 32, 100


class Object:
    """Random triangles on the grid, what the builder makes of them, and what it is told."""

    def __init__(self, rng, count, first=0):
        corner = rng.uniform(-0.8, 0.8, (count, 1, 3))
        vertices = np.rint((corner + rng.uniform(-0.15, 0.15, (count, 3, 3))) * 2**17) / 2**17
        unit = SimpleNamespace(triangles=vertices)
        opaque = rng.random(count) < 0.7
        self.vertices = tbu.vertex_records(unit, opaque)
        refs = tbu.references(unit, opaque)
        refs = replace(refs, tri=refs.tri + first)
        self.box = refs.box
        self.tree = model.build(refs, cap=CAP, refine_max=REFINE)
        room = tbu.sizes(count, CAP)
        self.regs = {
            "NODE_BASE": NODES, "NODE_COUNT": room.nodes, "LIST_BASE": LISTS, "LIST_COUNT": room.entries,
            "VERTEX_BASE": VERTICES, "REF_BASE": REFS, "REF_COUNT": room.refs, "TRI_COUNT": count, "TBU_REFINE": REFINE}
        for side, corner_of in zip(("LO", "HI"), self.box):
            self.regs |= {f"TBU_{side}_{axis}": int(q) for axis, q in zip("XYZ", corner_of)}
        assert VERTICES + 32 * count <= NODES and REFS + 16 * room.refs <= 1 << 18


class Bench(Host):
    """A host whose scene is the stand-in's with an object to build."""

    def __init__(self, dut, seed):
        super().__init__(dut, 1 << 18)
        self.made = scene(seed, 21, 13)
        self.pauses = 0.0

    async def pause(self):
        """Hold back answers of the memory at random."""
        channels = (self.ram.write_if.aw_channel, self.ram.write_if.w_channel, self.ram.write_if.b_channel,
                    self.ram.read_if.ar_channel, self.ram.read_if.r_channel)
        while True:
            for channel in channels:
                channel.pause = random.random() < self.pauses
            await RisingEdge(self.dut.clk_i)

    async def begin(self):
        await self.reset()
        await self.set_up(self.made)
        cocotb.start_soon(self.pause())
        await self.write("IRQ_ENABLE", 1)

    async def give(self, thing, **changes):
        """Put an object into memory and its registers; nothing of an earlier tree is left."""
        self.ram.write(NODES, bytes((1 << 18) - NODES))
        self.ram.write(VERTICES, thing.vertices.astype("<u8").tobytes())
        for name, value in (thing.regs | changes).items():
            self.made.regs[name] = value
            await self.write(name, value)

    async def frame(self, control):
        """Run a frame. Returns: (ERROR, ERROR_ADDR)."""
        await self.write("CTRL", control)
        assert await self.read("STATUS") & 1
        await self.wait_irq()
        await self.write("IRQ_STATUS", 3)
        status = await self.read("STATUS")
        code = await self.read("ERROR")
        assert status == (0b110 if code else 0b010)
        return code, await self.read("ERROR_ADDR")

    async def check_tree(self, thing):
        nodes = np.frombuffer(self.ram.read(NODES, 8 * thing.regs["NODE_COUNT"]), "<u8")
        lists = np.frombuffer(self.ram.read(LISTS, 4 * thing.regs["LIST_COUNT"]), "<u4")
        found = walk_memory(nodes, lists, await self.read("TBU_ROOT"), thing.box)
        assert compare(thing.tree, found) is None
        assert await self.read("TBU_NODES") == len(found) + found.jumps
        assert await self.read("TBU_JUMPS") == found.jumps

    async def check_picture(self, root):
        """The stand-in's picture of the tree that lies in memory."""
        self.made.regs["NODE_ROOT"] = root
        self.made.image = bytearray(self.ram.read(0, 1 << 18))
        self.check_frame(self.made)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def sequences(dut):
    """Objects one after the other: built and rendered at once, built alone and rendered later, rendered again."""
    rng = np.random.default_rng(int(os.environ["RAYCORE_SEED"]))
    bench = Bench(dut, int(os.environ["RAYCORE_SEED"]))
    await bench.begin()
    assert await bench.read("TBU_ROOT") == NODE_NONE
    for count, pauses in ((1, 0.0), (3 * CAP, 0.0), (20, 0.4), (5 * CAP, 0.3)):
        bench.pauses = pauses
        thing = Object(rng, count)
        await bench.give(thing, NODE_ROOT=0xABCDEF)                # out of range, and not used
        assert await bench.frame(BUILD | RENDER) == (0, 0)
        root = await bench.read("TBU_ROOT")
        await bench.check_tree(thing)
        await bench.check_picture(root)
        cycles = await bench.read("TBU_CYCLES"), await bench.read("CYCLES")
        assert 0 < cycles[0] < cycles[1]
        assert await bench.read("TBU_LINES") >= (count + 1) // 2 and await bench.read("TBU_ROWS") > 0
        assert await bench.read("FB_ROWS") == 3 * 13 and await bench.read("RAYS_PRIMARY") == 6 * 64
        assert await bench.read("RAYS_IN_FLIGHT") == 6 * 64 // 16
        await bench.write("NODE_ROOT", root)                       # again, without building
        bench.ram.write(bench.made.regs["FB_BASE"], bytes(13 * bench.made.regs["FB_STRIDE"]))
        assert await bench.frame(RENDER) == (0, 0)
        await bench.check_picture(root)
        assert await bench.read("TBU_CYCLES") == 0 and await bench.read("TBU_ROOT") == root
    thing = Object(rng, 2 * CAP)                                   # alone: what it does not need may be nonsense
    nonsense = {"SIZE": 0, "MAT_COUNT": 0, "LIGHT_COUNT": 99, "FB_BASE": 0xFFFFFFC0, "ACCEL_BASE": 0xFFFFFFC0}
    before = {name: bench.made.regs.get(name, 0) for name in nonsense}
    await bench.give(thing, **nonsense)
    picture = bench.ram.read(0x10000, 0x4000)
    assert await bench.frame(BUILD) == (0, 0)
    await bench.check_tree(thing)
    assert await bench.read("FB_ROWS") == 0 and bench.ram.read(0x10000, 0x4000) == picture
    await bench.give(thing, **before)
    assert await bench.frame(RENDER | BUILD) == (0, 0)
    await bench.check_picture(await bench.read("TBU_ROOT"))


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def errors(dut):
    """Every way a build can end badly: its code, the register or size to blame, no picture, and then a good frame."""
    rng = np.random.default_rng(int(os.environ["RAYCORE_SEED"]))
    bench = Bench(dut, int(os.environ["RAYCORE_SEED"]))
    await bench.begin()
    thing = Object(rng, 4 * CAP)
    bent = np.array(thing.vertices)
    bent[CAP, 0] = 0x7F0000                                        # infinite: x of a vertex
    cases = [
        ({"NODE_COUNT": 256}, ERR_NODE, 256), ({"LIST_COUNT": 256}, ERR_LIST, 256), ({"REF_COUNT": 64}, ERR_REF, 64),
        ({"TRI_COUNT": (1 << 19) + 1, "INFO_BASE": 0}, ERR_COUNT, (1 << 19) + 1),
        ({"TRI_COUNT": 1 << 23, "INFO_BASE": 0}, ERR_COUNT, 1 << 23),
        ({"NODE_COUNT": 200}, ERR_CONFIG, 0x54), ({"NODE_COUNT": 0}, ERR_CONFIG, 0x54), ({"LIST_COUNT": 300}, ERR_CONFIG, 0x60),
        ({"TRI_COUNT": 0}, ERR_CONFIG, 0x68), ({"VERTEX_BASE": 0xFFFFFFC0}, ERR_CONFIG, 0x98),
        ({"REF_BASE": 0xFFFFFFC0}, ERR_CONFIG, 0x9C), ({"NODE_BASE": 0xFFFFFFC0}, ERR_CONFIG, 0x50),
        ({"LIST_BASE": 0xFFFFFFC0}, ERR_CONFIG, 0x5C), ({"TBU_NODE_FIRST": 64}, ERR_CONFIG, 0x248),
        ({"TBU_NODE_FIRST": 1 << 20}, ERR_CONFIG, 0x248), ({"TBU_LIST_FIRST": 128}, ERR_CONFIG, 0x24C),
        ({"TBU_LIST_FIRST": 1 << 20}, ERR_CONFIG, 0x24C), ({"TBU_TRI_FIRST": (1 << 19) - 4 * CAP + 1}, ERR_CONFIG, 0x250)]
    for n, (changes, code, blamed) in enumerate(cases):
        bench.pauses = random.choice([0.0, 0.3])
        old = {name: bench.made.regs.get(name, 0) for name in changes}
        await bench.give(thing, **changes)
        outside = bench.ram.read(NODES + 8 * changes.get("NODE_COUNT", 1 << 12), 64)
        control = random.choice([BUILD, BUILD | RENDER]) if code != ERR_COUNT else BUILD | RENDER
        assert await bench.frame(control) == (code, blamed), changes
        assert await bench.read("FB_ROWS") == 0
        assert code == ERR_CONFIG or await bench.read("TBU_ROOT") == NODE_NONE, changes
        assert bench.ram.read(NODES + 8 * changes.get("NODE_COUNT", 1 << 12), 64) == outside
        for name, value in old.items():
            bench.made.regs[name] = value
            await bench.write(name, value)
        if n % 3 == 0:
            await bench.give(thing)
            assert await bench.frame(BUILD | RENDER) == (0, 0)
            await bench.check_tree(thing)
            await bench.check_picture(await bench.read("TBU_ROOT"))
    await bench.give(SimpleNamespace(vertices=bent, regs=thing.regs))
    code, _ = await bench.frame(BUILD | RENDER)
    assert code == ERR_COORD
    # The picture may not read what only the builder may.
    await bench.give(thing)
    assert await bench.frame(BUILD) == (0, 0)
    root = await bench.read("TBU_ROOT")
    for base in (VERTICES, REFS):
        bench.ram.write(NODES + root // 8 * 64 + 48, (base // 64).to_bytes(8, "little") + (4).to_bytes(8, "little"))
        await bench.write("NODE_ROOT", root)
        assert await bench.frame(RENDER) == (ERR_WINDOW, base + 32)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def parts_of_regions(dut):
    """Objects one after the other in the same regions: trees side by side, numbers from the regions' beginning."""
    rng = np.random.default_rng(int(os.environ["RAYCORE_SEED"]))
    bench = Bench(dut, int(os.environ["RAYCORE_SEED"]))
    await bench.begin()
    node, entry, tri, built = 0, 0, 0, []
    for count in (3 * CAP, 1, 2 * CAP):
        bench.pauses = random.choice([0.0, 0.3])
        thing = Object(rng, count, tri)
        nodes, lists = bench.ram.read(NODES, 8 * node), bench.ram.read(LISTS, 4 * entry)
        if built:
            bench.ram.write(VERTICES, thing.vertices.astype("<u8").tobytes())
        room = [("NODE", node, node + 1024), ("LIST", entry, entry + 1024)]
        firsts = {f"TBU_{n}_FIRST": at for n, at, _ in room} | {f"{n}_COUNT": end for n, _, end in room}
        if not built:
            await bench.give(thing, **firsts, TBU_TRI_FIRST=tri)
        else:
            for name, value in (thing.regs | firsts | {"TBU_TRI_FIRST": tri}).items():
                await bench.write(name, value)
        assert await bench.frame(BUILD) == (0, 0)
        assert (bench.ram.read(NODES, 8 * node), bench.ram.read(LISTS, 4 * entry)) == (nodes, lists)
        built.append((thing, await bench.read("TBU_ROOT")))
        assert node <= built[-1][1] < node + 1024
        node, entry, tri = node + 1024, entry + 1024, tri + count
    nodes = np.frombuffer(bench.ram.read(NODES, 8 * node), "<u8")
    lists = np.frombuffer(bench.ram.read(LISTS, 4 * entry), "<u4")
    for thing, root in built:
        assert compare(thing.tree, walk_memory(nodes, lists, root, thing.box)) is None
    for changes, code in (({"TBU_NODE_FIRST": node - 1024 + 896}, ERR_NODE), ({"TBU_LIST_FIRST": entry - 256}, ERR_LIST)):
        thing = Object(rng, 4 * CAP)                               # too little room above what belongs to others
        for name, value in (thing.regs | firsts | changes).items():
            await bench.write(name, value)
        bench.ram.write(VERTICES, thing.vertices.astype("<u8").tobytes())
        at = 8 * changes.get("TBU_NODE_FIRST", 0), 4 * changes.get("TBU_LIST_FIRST", 0)
        below = bench.ram.read(NODES, at[0]), bench.ram.read(LISTS, at[1])
        assert (await bench.frame(BUILD))[0] == code
        assert below == (bench.ram.read(NODES, at[0]), bench.ram.read(LISTS, at[1]))


@cocotb.test(timeout_time=40, timeout_unit="ms")
async def nonsense(dut):
    """A box that is not that of the triangles, even one upside down: a tree or an error, never a hang or a row outside."""
    rng = np.random.default_rng(int(os.environ["RAYCORE_SEED"]))
    bench = Bench(dut, int(os.environ["RAYCORE_SEED"]))
    await bench.begin()
    names = [f"TBU_{side}_{axis}" for side in ("LO", "HI") for axis in "XYZ"]
    for count in (CAP, 2 * CAP, 4 * CAP, 4 * CAP):
        thing = Object(rng, count)
        await bench.give(thing, **{n: int(rng.integers(1, 1 << 18)) for n in rng.choice(names, 3, replace=False)})
        vertices = bench.ram.read(VERTICES, 32 * count)
        code, _ = await bench.frame(BUILD)
        dut._log.info(f"{count} triangles: error {code}")
        assert code in (0, ERR_NODE, ERR_LIST, ERR_REF, ERR_COORD)
        assert bench.ram.read(VERTICES, 32 * count) == vertices
        await bench.give(thing)
        assert await bench.frame(BUILD | RENDER) == (0, 0)
        await bench.check_tree(thing)
        await bench.check_picture(await bench.read("TBU_ROOT"))


def test_rc_build():
    run_cocotb("rc_top", sources(tbu=True), "test_rc_build", parameters={"Tbu": 1, "Cap": CAP},
               build_args=[str(p) for p in sorted((REPO / "lint").glob("*.vlt"))], public=["s_axil*", "m_axi*"])
