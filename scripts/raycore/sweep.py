# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Sweeps of cache geometry and memory: one picture on many configurations of the RTL (`raycore sweep`, docs/cli.md).

Every configuration is a simulation of its own and must give the reference's pixels, hits and counters; the reference is
computed once. Simulations run side by side here (`local`) or on the workers of a Dask scheduler (`distributed`). What is known
already, from the results of an earlier run of the same RTL and picture, is not run again.
"""

import csv
import hashlib
import io
import itertools
import json
import math
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass

import numpy as np

from raycore import render, sim
from raycore.errors import OptionError, RayCoreError
from raycore.image import Image

LINE_BITS, LINE_ADDR_BITS = 480, 26  # LINE_W, LINE_ADDR_W of rc_pkg.sv
L1_WAYS = 2  # rc_l1
# KB of an RTU that no cache of a sweep is part of: triangle information, coordinates, textures, stacks, queues. As slang elaborates
# it; tests/test_sweep.py compares.
OTHER_SRAM_KB = 209.20
DEFAULTS = {"nt_sets": 128, "list_sets": 32, "l2_sets": 256, "l2_ways": 14}
NAMES = {"nt_sets": "NtSets", "list_sets": "ListSets", "l2_sets": "L2Sets", "l2_ways": "L2Ways"}  # parameters of the RTL
MAX_POINTS = 10_000


@dataclass(frozen=True, order=True)
class Point:
    """One configuration: sets of each L1 cache, geometry of the L2 cache, memory."""

    nt_sets: int = DEFAULTS["nt_sets"]
    list_sets: int = DEFAULTS["list_sets"]
    l2_sets: int = DEFAULTS["l2_sets"]
    l2_ways: int = DEFAULTS["l2_ways"]
    mem_width: int = 64
    mem_latency: int = 60

    def __post_init__(self):
        for name, least in (("nt_sets", 2), ("list_sets", 2), ("l2_sets", 2)):
            n = getattr(self, name)
            if not least <= n <= 1 << 14 or n & (n - 1):
                raise OptionError(f"--{name.replace('_', '-')} {n}: give a power of two, {least} to {1 << 14}")
        if not 2 <= self.l2_ways <= 64:
            raise OptionError(f"--l2-ways {self.l2_ways}: give 2 to 64")
        sim.Memory(width=self.mem_width, latency=self.mem_latency)  # checks the rest

    @property
    def key(self):
        """Text by which results are found again."""
        return "-".join(str(v) for v in asdict(self).values())

    @property
    def caches(self):
        """Parameters of the RTL; none for the default, which every other command builds too."""
        chosen = {NAMES[name]: getattr(self, name) for name in NAMES}
        return {} if chosen == {NAMES[name]: n for name, n in DEFAULTS.items()} else chosen

    @property
    def memory(self):
        """`sim.Memory` of the point."""
        return sim.Memory(width=self.mem_width, latency=self.mem_latency)

    @property
    def sram_kb(self):
        """KB of SRAM of an RTU: data and tags of the caches as in rc_l1.sv and rc_l2.sv, and the rest."""

        def cache(sets, ways):
            return sets * ways * (LINE_BITS + LINE_ADDR_BITS - int(math.log2(sets))) / 8192

        l1 = render.PIPES * (cache(self.nt_sets, L1_WAYS) + cache(self.list_sets, L1_WAYS))
        return l1 + cache(self.l2_sets, self.l2_ways) + OTHER_SRAM_KB


def points(lists, budget=None):
    """All combinations of the lists, {field of `Point`: values}, that take no more than budget KB of SRAM, in order.

    Raises: OptionError if none is left, or too many.
    """
    count = math.prod(len(v) for v in lists.values())
    if count > MAX_POINTS:
        raise OptionError(f"{count} configurations are too many; give fewer values, at most {MAX_POINTS} in all")
    every = sorted({Point(**dict(zip(lists, values))) for values in itertools.product(*lists.values())})
    kept = [p for p in every if budget is None or p.sram_kb <= budget]
    if not kept:
        least = min(p.sram_kb for p in every)
        raise OptionError(f"--budget {budget:g}: no configuration is that small; the smallest takes {least:.1f} KB")
    return kept


# ---- running ---------------------------------------------------------------------------------------------------------------


@dataclass
class Task:
    """What a worker needs to run points of one picture."""

    memory: np.ndarray  # of the image
    registers: dict
    reference: object  # model.frame.Frame


def run_point(task, point):
    """Simulate a point. Returns: (statistics of `sim.SimResult`, differences from the reference in words: none if it is right)."""
    from raycore.check import compare_rtl

    result = sim.run_frame(
        task.memory, task.registers, memory=point.memory, hits=True, caches=point.caches, progress=False
    )
    exact = compare_rtl(result, task.reference)
    wrong = [*exact.examples, *(f"counter {c}: {a}, reference {b}" for c, (a, b) in exact.counters.items())]
    return result.stats, wrong


def local(task, todo, jobs):
    """Run points on this machine, jobs at a time: yields (point, outcome) as they come. Simulations are processes of their own."""
    with ThreadPoolExecutor(jobs) as pool:
        running = {pool.submit(run_point, task, p): p for p in todo}
        try:
            for done in as_completed(running):
                yield running[done], done.result()
        finally:
            for future in running:
                future.cancel()


def distributed(task, todo, address):
    """Run points on the workers of a Dask scheduler: yields (point, outcome) as they come.

    A worker runs the same checkout, and builds what it simulates there. Raises: OptionError without Dask or scheduler.
    """
    try:
        from dask.distributed import Client
        from dask.distributed import as_completed as completed
    except ImportError:
        raise OptionError("--scheduler: Dask is not installed; run `make cluster` once") from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError, TimeoutError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise OptionError(f"--scheduler {address}: no scheduler answers there ({reason})") from None
    with client:
        shared = client.scatter(task, broadcast=True)
        running = {client.submit(run_point, shared, p, pure=False): p for p in todo}
        for future in completed(running):
            yield running[future], future.result()


def signature(image: Image):
    """Text that is another one for any other picture or RTL: results of one signature may be kept."""
    digest = hashlib.sha256(np.ascontiguousarray(image.memory).tobytes())
    digest.update(json.dumps(image.registers, sort_keys=True, default=int).encode())
    for path in [*sim.rtl_sources(), *sorted((sim.REPO / "sim").glob("*.[chs]*"))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def figures(image, point, outcome):
    """What is kept of a point, from `run_point`."""
    stats, wrong = outcome
    empty = np.empty((0, 0), np.uint32)
    rendered = render.Rendered(
        "rtl", image, empty, None, None, point.memory, sim.SimResult(empty, np.empty(0, sim.HIT_DTYPE), stats)
    )
    values = render.stats(rendered)
    return {
        **asdict(point),
        "sram_kb": round(point.sram_kb, 2),
        "cycles": values["cycles"],
        "rays": values["rays"]["total"],
        "rays_per_cycle": values["rays_per_cycle_per_rtu"],
        "slots_per_ray": values["slots_per_ray"],
        "occupancy": values["occupancy"],
        **{f"hit_rate_{name}": values["cache"][name]["hit_rate"] for name in ("l1_node", "l1_list", "l2", "triangle", "texture")},
        "bytes_per_ray": values["bytes_per_ray"]["total"],
        "exact": not wrong,
    }


def known(path, sign):
    """Results of an earlier run with this signature: {key: figures}. Raises: RayCoreError if the file is of something else."""
    if not path.is_file():
        return {}
    try:
        values = json.loads(path.read_text())
        return dict(values["points"]) if values["signature"] == sign else {}
    except (OSError, ValueError, KeyError, TypeError):
        raise RayCoreError(f"{path}: is no result of a sweep; take another folder") from None


# ---- what comes out ----------------------------------------------------------------------------------------------------------


def as_csv(rows):
    """Rows of `figures` as CSV, bytes."""
    out = io.StringIO()
    writer = csv.DictWriter(out, rows[0].keys(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue().encode()


def _geometry(row):
    return f"{row['nt_sets']} / {row['list_sets']} / {row['l2_sets']}x{row['l2_ways']}"


def sram_plot(rows, budget=None):
    """PNG: rays per cycle over KB of SRAM, a mark for each geometry, a colour for each memory."""
    from raycore.profile import figure, png

    plot = figure(8.5, 5.0)
    axes = plot.subplots()
    for memory in sorted({(r["mem_width"], r["mem_latency"]) for r in rows}):
        own = sorted((r for r in rows if (r["mem_width"], r["mem_latency"]) == memory), key=lambda r: r["sram_kb"])
        places = [(r["sram_kb"], r["rays_per_cycle"]) for r in own]
        axes.plot(*zip(*places), "o", label=f"{memory[0]} bits, {memory[1]} cycles")
        if len(own) <= 16:
            for r, place in zip(own, places):
                axes.annotate(_geometry(r), place, fontsize=6, xytext=(4, 4), textcoords="offset points")
    if budget is not None:
        axes.axvline(budget, color="#888888", linestyle="--", linewidth=1)
    axes.set(xlabel="KB of SRAM in an RTU", ylabel="rays per cycle")
    axes.set_ylim(0, 1.08 * max(r["rays_per_cycle"] for r in rows))
    axes.grid(alpha=0.3)
    axes.legend(title="memory", fontsize="small")
    return png(plot)


def latency_plot(rows):
    """PNG: rays per cycle over the memory's latency, a line for each geometry and width of the bus."""
    from raycore.profile import figure, png

    plot = figure(8.5, 5.0)
    axes = plot.subplots()
    lines = {}
    for r in sorted(rows, key=lambda r: r["mem_latency"]):
        lines.setdefault((_geometry(r), r["mem_width"]), []).append((r["mem_latency"], r["rays_per_cycle"]))
    for (geometry, width), values in lines.items():
        axes.plot(*zip(*values), "o-", label=f"{geometry}, {width} bits")
    axes.set(xlabel="latency of the memory, cycles", ylabel="rays per cycle")
    axes.set_ylim(0, 1.08 * max(r["rays_per_cycle"] for r in rows))
    axes.grid(alpha=0.3)
    if len(lines) <= 16:
        axes.legend(title="L1 node / L1 list / L2 sets x ways", fontsize="x-small", title_fontsize="x-small")
    return png(plot)
