# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Frames whose tree the RTL builds before it renders, and maybe the records too: more room after an overflow, what was
made read back, and all of it checked."""

from dataclasses import dataclass, field

import numpy as np

from raycore import render, sim, tbu
from raycore.check import STEPS, Exact, compare_rtl
from raycore.errors import SimError
from raycore.image import View, build_geometry, build_image, region_words
from raycore.model import tbu as model
from raycore.model.tbu_memory import compare, walk_memory

ERR_TBU_NODE, ERR_TBU_LIST, ERR_TBU_REF = 11, 12, 13
OVERFLOWS = (ERR_TBU_NODE, ERR_TBU_LIST, ERR_TBU_REF)  # of err_e: these need more room, not another scene
LARGEST_FACTOR = 16


def render_frame(geometry, view=None, memory=None, hits=False, keep_memory=False, records=False, **simulation):
    """Build the tree, make the records if asked to, and render, in one frame of the RTL.

    Args: geometry: from `image.build_geometry(..., in_hardware=True)`; view: `image.View`; memory: `sim.Memory`;
        hits: keep the hit records; keep_memory: keep memory, and with it the tree; records: the RTL makes them;
        simulation: more arguments of `sim.run_frame`.
    Returns: `render.Rendered`. Raises: SimError, also if the tree does not fit with sixteen times the usual room.
    """
    factor, cap = 1, geometry.tree.params.cap
    while True:
        image = build_image(geometry, view or View(), room=tbu.sizes(len(geometry.info), cap, factor), records=records)
        try:
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


def read_tree(rendered) -> model.Tree:
    """The tree that a frame with `keep_memory` left in memory. Raises: SimError if it makes no sense."""
    image, result = rendered.image, rendered.result
    parts = (("nodes", "NODE_COUNT", "<u8"), ("lists", "LIST_COUNT", "<u4"))
    nodes, lists = (
        result.memory[image.regions[name][0] :].view(kind)[: image.registers[count]] for name, count, kind in parts
    )
    box = tbu.references(image.geometry.unit).box
    try:
        return walk_memory(nodes, lists, result.stats["counters"]["TBU_ROOT"], box)
    except ValueError as error:
        raise SimError(f"{image.geometry.scene.name}: the tree in memory makes no sense: {error}") from None


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
    found = read_tree(rendered)
    expected = tbu.model_tree(tbu.references(geometry.unit, geometry.opaque), params)
    image = build_image(build_geometry(geometry.scene, params), view)
    reference = render_fp24(image)
    exact = compare_rtl(rendered.result, reference)
    if found.jumps:  # a jump node is a step more for each ray that passes it
        exact.counters = {c: v for c, v in exact.counters.items() if c != STEPS or v[0] < v[1]}
    return TreeCheck(exact, compare(expected, found), _records(rendered, image), found.jumps, reference, image)
