# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_top with its record unit: frames that make records alone, beside a tree, and before a picture that reads them; errors,
windows, and the memory ports shared with the tree builder. Records equal the model's."""
import os
import random
from types import SimpleNamespace

import cocotb
import numpy as np
from standin import sources
from test_rc_build import BUILD, CAP, ERR_CONFIG, ERR_COORD, ERR_NODE, RENDER, VERTICES, Bench, Object

from raycore import accel, image, triaccel
from raycore.model import accel as model
from raycore.model import fp24
from raycore.tbutil import run_cocotb
from raycore.toolchain import REPO

RECORDS = 4
ACCEL, INFO, ATTRS = 0x12000, 0x14000, 0x16800
FENCE = 64                                                         # bytes beside a region that must stay


class Made(Object):
    """An object with attributes, and the records that must come."""

    def __init__(self, rng, count):
        super().__init__(rng, count)
        bits = [int.from_bytes(r.astype("<u8").tobytes(), "little") for r in self.vertices]
        corners = fp24.from_bits(np.array([[b >> 24 * i & 0xFFFFFF for i in range(9)] for b in bits], np.uint32))
        unit = SimpleNamespace(triangles=corners.reshape(-1, 3, 3))
        opaque = np.array([b >> 216 & 1 for b in bits], bool)
        normals = rng.normal(size=(count, 3, 3))
        normals = fp24.round_to_fp24(normals / np.linalg.norm(normals, axis=2, keepdims=True))
        flat, material = rng.random(count) < 0.5, rng.integers(0, 4096, count)
        view = model.Slack(tuple(int(e) for e in rng.integers(-900, 901, 3)), int(rng.integers(128, 400)))
        self.attributes = accel.attribute_records(normals, material, flat).astype("<u8").tobytes()
        rec, geometric, _ = accel.records(unit, view)
        self.accel = triaccel.pack(rec, material, opaque).astype("<u8").tobytes()
        n0, d1, d2 = model.corner_normals(normals, geometric, flat)
        columns = np.concatenate((unit.triangles[:, 0], geometric, n0, d1, d2), axis=1)
        self.info = image._pack_columns(image.TRI_INFO, image.INFO_COLUMNS, columns, mat=material).astype("<u8").tobytes()
        self.regs |= {"ACCEL_BASE": ACCEL, "INFO_BASE": INFO, "ATTR_BASE": ATTRS, "ACCEL_SLACK": view.least}
        self.regs |= {f"ACCEL_EYE_{a}": e & 0xFFFF for a, e in zip("XYZ", view.eye)}
        assert count <= 100


class RecordBench(Bench):
    async def give(self, thing, **changes):
        """As for the tree; nothing of earlier records is left, and what is beside them is known."""
        self.ram.write(ACCEL - FENCE, bytes(random.getrandbits(8) for _ in range(ATTRS - ACCEL + FENCE)))
        self.ram.write(ATTRS, thing.attributes)
        await super().give(thing, **changes)
        self.before = self.ram.read(ACCEL - FENCE, ATTRS - ACCEL + FENCE)

    def check_records(self, thing):
        """Every byte from before the first record to behind the last."""
        want = bytearray(self.before)
        want[FENCE : FENCE + len(thing.accel)] = thing.accel
        at = INFO - ACCEL + FENCE
        want[at : at + len(thing.info)] = thing.info
        assert self.ram.read(ACCEL - FENCE, len(want)) == bytes(want)

    def check_none(self):
        assert self.ram.read(ACCEL - FENCE, len(self.before)) == self.before


def begin(dut):
    seed = int(os.environ["RAYCORE_SEED"])
    return RecordBench(dut, seed), np.random.default_rng(seed)


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def sequences(dut):
    """Each sum of the three things that a frame can do."""
    bench, rng = begin(dut)
    await bench.begin()
    for count, pauses, control in (
        (1, 0.0, RECORDS), (2 * CAP, 0.0, RECORDS | BUILD), (33, 0.4, RECORDS | BUILD | RENDER), (2, 0.2, RECORDS | BUILD),
        (3 * CAP, 0.3, BUILD | RECORDS), (50, 0.0, RECORDS | RENDER), (9, 0.0, BUILD | RENDER),
        (100, 0.1, RECORDS | BUILD | RENDER)):  # fmt: skip
        bench.pauses = pauses
        thing = Made(rng, count)
        # What the frame does not need may be nonsense.
        nonsense = {"NODE_COUNT": 0, "NODE_BASE": 0xFFFFFFC0} if control == RECORDS else {}
        if not control & RECORDS:
            nonsense |= {"ACCEL_SLACK": 0, "ATTR_BASE": 0xFFFFFFC0}
        await bench.give(thing, NODE_ROOT=5, **nonsense)
        assert await bench.frame(control) == (0, 0)
        made = await bench.read("ACCEL_CYCLES")
        assert (made > 30 * count) == bool(control & RECORDS)
        if control & RECORDS:
            bench.check_records(thing)
        else:
            bench.check_none()
        if control & BUILD:
            await bench.check_tree(thing)
        if control & RENDER:                                       # reads triangle information
            await bench.check_picture(await bench.read("TBU_ROOT") if control & BUILD else 5)
        assert (await bench.read("TBU_CYCLES") > 0) == bool(control & BUILD)
        for name in nonsense:
            bench.made.regs[name] = thing.regs[name]


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def errors(dut):
    """Registers that make no sense, bad vertices, a tree that does not fit, a memory that fails; then a good frame."""
    bench, rng = begin(dut)
    await bench.begin()
    thing = Made(rng, 2 * CAP)
    cases = [
        ({"ACCEL_SLACK": 127}, RECORDS, ERR_CONFIG, 0x204), ({"ACCEL_SLACK": 8193}, RECORDS | BUILD, ERR_CONFIG, 0x204),
        ({"ATTR_BASE": 0xFFFFFFC0}, RECORDS, ERR_CONFIG, 0x200), ({"ACCEL_BASE": 0xFFFFFFC0}, RECORDS, ERR_CONFIG, 0x64),
        ({"INFO_BASE": 0xFFFFFFC0}, RECORDS, ERR_CONFIG, 0x6C), ({"VERTEX_BASE": 0xFFFFFFC0}, RECORDS, ERR_CONFIG, 0x98),
        ({"TRI_COUNT": 0}, RECORDS, ERR_CONFIG, 0x68), ({"NODE_COUNT": 128}, RECORDS | BUILD, ERR_NODE, 128)]
    for changes, control, code, blamed in cases:
        bench.pauses = random.choice([0.0, 0.3])
        await bench.give(thing, **changes)
        assert await bench.frame(control) == (code, blamed), changes
        if code == ERR_CONFIG:
            bench.check_none()
        await bench.give(thing)
        assert await bench.frame(RECORDS | BUILD) == (0, 0)
        bench.check_records(thing)
        await bench.check_tree(thing)
    for control in (RECORDS, RECORDS | BUILD | RENDER):
        await bench.give(thing)
        n = int(rng.integers(2 * CAP))
        bench.ram.write(VERTICES + 32 * n, (0x3F0000).to_bytes(3, "little"))
        code, blamed = await bench.frame(control)
        assert code == ERR_COORD and (blamed == n or control & BUILD)
        assert await bench.read("FB_ROWS") == 0
        await bench.give(thing)
        assert await bench.frame(control) == (0, 0)
        bench.check_records(thing)


def test_rc_records():
    run_cocotb("rc_top", sources(tbu=True), "test_rc_records", parameters={"Tbu": 1, "Cap": CAP},
               build_args=[str(p) for p in sorted((REPO / "lint").glob("*.vlt"))], public=["s_axil*", "m_axi*"])
