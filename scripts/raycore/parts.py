# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""One picture in several simulations at a time, each with a range of its tiles (`raycore render --jobs`).

Pixels and hits are those of one simulation, for no ray depends on another. Cycles and misses are not: every part starts with
cold caches, and a part's last rays have the pipelines for themselves.
"""

import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path

import numpy as np

from raycore import sim
from raycore.image import TILE, tile_count, tile_range

SUMMED = ("counters", "bytes", "axi")  # of the statistics: numbers by name


def split(tiles, jobs):
    """Ranges of tiles (first, count), as even as they can be; no more of them than tiles."""
    jobs = min(jobs, tiles)
    ends = [tiles * i // jobs for i in range(jobs + 1)]
    return [(a, b - a) for a, b in pairwise(ends)]


def run_frame(image, memory, hits, jobs, rtus=1):
    """Simulate a picture in parts, each in a process of its own.

    Args: image `image.Image`; memory `sim.Memory`; hits: keep the hit records; jobs: parts; rtus: units of each.
    Returns: `sim.SimResult`, statistics added up (`join_statistics`), hits part by part. Raises: as `sim.run_frame`.
    """
    ranges = split(tile_count(image.view), jobs)
    sim.build(mem_width=memory.width, rtus=rtus)  # once, not by all of them
    began = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="raycore-") as folder, ThreadPoolExecutor(len(ranges)) as pool:
        path = Path(folder) / "image.bin"
        path.write_bytes(bytes(image.memory))

        def run(part):
            registers = image.registers | tile_range(image, *part)
            return sim.run_frame(path, registers, memory=memory, hits=hits, rtus=rtus, progress=False)

        results = list(pool.map(run, ranges))
    seconds = time.perf_counter() - began
    y, x = np.indices(results[0].frame.shape)
    tile = y // TILE * -(-image.view.width // TILE) + x // TILE
    frame = np.zeros_like(results[0].frame)
    for (first, count), result in zip(ranges, results):
        own = (tile >= first) & (tile < first + count)
        frame[own] = result.frame[own]
    statistics = join_statistics([r.stats for r in results], seconds)
    return sim.SimResult(frame, np.concatenate([r.hits for r in results]), statistics)


def join_statistics(parts, seconds):
    """Statistics of all parts as if one had come after the other: everything counted is a sum, cycles too.

    Args: parts: statistics of `sim.SimResult`; seconds: that all of them took, side by side.
    """
    out = dict(parts[0])
    for name in SUMMED:
        out[name] = {key: sum(p[name][key] for p in parts) for key in parts[0][name]}
    out["rays"] = {}
    for kind in parts[0]["rays"]:
        depths = np.zeros((len(parts), max(len(p["rays"][kind]) for p in parts)), np.int64)
        for row, p in zip(depths, parts):
            row[: len(p["rays"][kind])] = p["rays"][kind]
        out["rays"][kind] = depths.sum(axis=0).tolist()
    cycles = sum(p["sim"]["cycles"] for p in parts)
    out["sim"] = {"cycles": cycles, "seconds": round(seconds, 3), "cycles_per_second": round(cycles / max(seconds, 1e-9))}
    out["parts"] = len(parts)
    return out
