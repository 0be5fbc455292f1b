# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Frames whose tree the RTL builds before it renders, and maybe the records too: more room after an overflow, what was
made read back, and all of it checked.

With dynamic objects there is a frame without a picture for each of their trees, and their records, and one for the top-level tree,
then the picture.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from raycore import objects, render, sim, tbu
from raycore.check import STEPS, Exact, compare_rtl
from raycore.errors import SimError
from raycore.image import INSTANCE_WORDS, View, build_geometry, build_image, pack_instances, region_words
from raycore.model import tbu as model
from raycore.model.tbu_memory import compare, walk_memory

ERR_TBU_NODE, ERR_TBU_LIST, ERR_TBU_REF = 11, 12, 13
OVERFLOWS = (ERR_TBU_NODE, ERR_TBU_LIST, ERR_TBU_REF)  # of err_e: these need more room, not another scene
LARGEST_FACTOR = 16


def render_frame(geometry, view=None, memory=None, hits=False, keep_memory=False, records=False, **simulation):
    """Build the tree, make the records if asked to, and render, in one frame of the RTL; with dynamic objects, of each its tree
    and records in a frame of its own.

    Args: geometry: from `image.build_geometry(..., in_hardware=True)`; view: `image.View`; memory: `sim.Memory`;
        hits: keep the hit records; keep_memory: keep memory, and with it the tree; records: the RTL makes them;
        simulation: more arguments of `sim.run_frame`.
    Returns: `render.Rendered`. Raises: SimError, also if the tree does not fit with sixteen times the usual room.
    """
    factor, cap = 1, geometry.tree.params.cap
    while True:
        try:
            if geometry.objects is not None:
                return _render_objects(geometry, view or View(), factor, memory, hits, keep_memory, records, simulation)
            room = tbu.sizes(len(geometry.info), cap, factor)
            image = build_image(geometry, view or View(), room=room, records=records)
            return render.render(
                image,
                "rtl",
                memory,
                hits,
                control=sim.BUILD_TREE | sim.RENDER | sim.RECORDS * records,
                cap=cap,
                keep_memory=keep_memory,
                **simulation,
            )
        except sim.FrameError as error:
            if error.code not in OVERFLOWS or factor == LARGEST_FACTOR:
                raise
            factor *= 2


def _render_objects(geometry, view, factor, memory, hits, keep_memory, records, simulation):
    """`render_frame` with dynamic objects. The host puts the roots of finished trees into the instances' records, beside those of
    its own, which are known before."""
    params = geometry.tree.params
    image = build_image(geometry, view, room=objects.room(geometry.objects, params.cap, factor), records=records)
    top = len(geometry.objects.parts) - 1  # its boxes have no records
    data, roots, stats = image.memory, [], []
    quiet = {k: v for k, v in simulation.items() if not k.startswith("waves")}  # those show the picture
    for number in range(top + 1):
        registers = image.registers | image.room.registers(number, image.regions, params)
        built = sim.run_frame(
            data,
            registers,
            memory=memory or sim.Memory(),
            control=sim.BUILD_TREE | sim.RECORDS * (records and number < top),
            cap=params.cap,
            keep_memory=True,
            **quiet,
        )
        data = built.memory
        roots.append(built.stats["counters"]["TBU_ROOT"])
        stats.append(built.stats)
    instances = pack_instances(geometry.objects.roots(roots), geometry.objects).astype("<u8").reshape(-1).view("u1")
    data[image.regions["instances"][0] :][: instances.size] = instances
    rendered = render.render(
        replace(image, memory=data), "rtl", memory, hits, tbu=True, cap=params.cap, keep_memory=keep_memory, **simulation
    )
    rendered.result.stats = _together([*stats, rendered.result.stats])
    return rendered


def _together(frames):
    """Statistics of frames one after the other as those of one: cycles, what was built and bytes add up. prepared: cycles until
    trees and records were there."""
    out = dict(frames[-1])
    counters = dict(out["counters"])
    for name in counters:
        if name in ("CYCLES", "ACCEL_CYCLES") or (name.startswith("TBU_") and name != "TBU_ROOT"):
            counters[name] = sum(f["counters"][name] for f in frames)
    moved = {}
    for f in frames:
        for name, count in f["bytes"].items():
            moved[name] = moved.get(name, 0) + count
    return out | {"counters": counters, "bytes": moved, "prepared": sum(render.prepared(f["counters"]) for f in frames)}


def _read_tree(rendered, root, box) -> model.Tree:
    image, result = rendered.image, rendered.result
    parts = (("nodes", "NODE_COUNT", "<u8"), ("lists", "LIST_COUNT", "<u4"))
    nodes, lists = (
        result.memory[image.regions[name][0] :].view(kind)[: image.registers[count]] for name, count, kind in parts
    )
    try:
        return walk_memory(nodes, lists, root, box)
    except ValueError as error:
        raise SimError(f"{image.geometry.scene.name}: the tree in memory makes no sense: {error}") from None


def read_tree(rendered) -> model.Tree:
    """The tree that a frame with `keep_memory` left in memory. Raises: SimError if it makes no sense."""
    box = tbu.references(rendered.image.geometry.unit).box
    return _read_tree(rendered, rendered.result.stats["counters"]["TBU_ROOT"], box)


def _compare_trees(rendered):
    """Every tree that was built beside the model's: the first difference or None, and the number of jump nodes."""
    geometry = rendered.image.geometry
    params = geometry.tree.params
    if geometry.objects is None:
        found = read_tree(rendered)
        return compare(tbu.model_tree(tbu.references(geometry.unit, geometry.opaque), params), found), found.jumps
    low, _ = rendered.image.regions["instances"]
    words = rendered.result.memory[low:][: objects.INSTANCE_BYTES * len(geometry.objects.boxes)].view("<u8")
    roots = (words[::INSTANCE_WORDS] & 0xFFFFFF).astype(int).tolist()
    difference, jumps = None, 0
    built = len(geometry.objects.parts)
    for part, root in zip(geometry.objects.parts, [*roots[1:built], roots[0]]):  # the trees of placed objects are the host's
        found = _read_tree(rendered, root, part.refs.box)
        differs = compare(part.tree(params), found)
        difference = difference or (differs and f"{part.name}, {differs}")
        jumps += found.jumps
    return difference, jumps


@dataclass
class TreeCheck:
    """A frame of `render_frame` beside the models.

    exact: pixels, hits and counters against the reference on the model's tree; difference: the first one between the
    trees, None if there is none; records: likewise between records; jumps: jump nodes, which the model's tree does not have.
    """

    exact: Exact
    difference: str | None
    records: str | None
    jumps: int
    reference: object = field(repr=False)  # model.frame.Frame
    image: object = field(repr=False)  # of the model's tree

    @property
    def same(self):
        """Nothing differs."""
        return self.exact.same and self.difference is None and self.records is None


def _records(rendered, image) -> str | None:
    """The first difference between the records that a frame left in memory and those of an image, as text."""
    for name, words in (("triaccel", 4), ("info", 8)):
        count = image.registers["TRI_COUNT"]
        low = rendered.image.regions[name][0]
        got = rendered.result.memory[low : low + 8 * words * count].view("<u8").reshape(count, words)
        wrong = np.flatnonzero((got != region_words(image, name, count, words)).any(axis=1))
        if wrong.size:
            return f"in {wrong.size} {'TriAccel records' if name == 'triaccel' else 'records of triangle information'}, "\
                f"the first of triangle {wrong[0]}"
    return None


def check_frame(rendered) -> TreeCheck:
    """Compare a frame with hits and memory with the reference on the model's tree, and the tree with the model's."""
    from raycore.model.frame import render_fp24

    geometry, view = rendered.image.geometry, rendered.image.view
    params = geometry.tree.params
    difference, jumps = _compare_trees(rendered)
    image = build_image(build_geometry(geometry.scene, params), view)
    reference = render_fp24(image)
    exact = compare_rtl(rendered.result, reference)
    if jumps:  # a jump node is a step more for each ray that passes it
        exact.counters = {c: v for c, v in exact.counters.items() if c != STEPS or v[0] < v[1]}
    return TreeCheck(exact, difference, _records(rendered, image), jumps, reference, image)
