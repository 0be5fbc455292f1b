# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""How speed grows with the number of ray-tracing units: `python -m raycore.scaling SCENE --rtus 1 2 4 6 8`.

One frame of the RTL for each number, all with the same memory. Speedup is relative to the first number, in cycles: six RTUs are
six times as fast as one if nothing that they share is scarce. Each frame is compared with the bit-exact reference unless --fast.
Prints a table and writes it as JSON, and a plot beside it.
"""

import argparse
import io
import json
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from raycore import check, render, sim
from raycore.errors import OptionError, OutputError, RayCoreError
from raycore.image import View, build_geometry, build_image
from raycore.model import frame, pixbuf
from raycore.scene import load_scene, parse_camera, parse_light
from raycore.toolchain import BUILD

DEFAULT_RTUS = (1, 2, 4, 6, 8)
BUS_FULL = 0.85  # share of cycles with a beat from which on the bus is what holds the RTUs up
FEW_BLOCKS = 40  # blocks an RTU below which its last ones decide
COLUMNS = ("RTUs", "cycles", "speedup", "efficiency", "rays/cycle/RTU", "occupancy", "slots/ray", "bytes/ray", "bus busy",
           "reads open", "L2 hits", "blocks/RTU", "bound by")  # fmt: skip


def measure(image, rtus, width=64, latency=60, reference=None):
    """One frame on so many RTUs: a dict of what `COLUMNS` names, and all statistics as `stats`.

    Args: image `image.Image`; width, latency: of the memory; reference: `model.frame.Frame` to compare with, or None.
    Raises: RayCoreError if a pixel, hit record or count is not the reference's.
    """
    memory = sim.Memory(width=width, latency=latency, outstanding=sim.outstanding(rtus))
    rendered = render.render(image, "rtl", memory, hits=reference is not None, rtus=rtus)
    if reference is not None:
        report = check.compare_rtl(rendered.result, reference)
        if not report.same:
            raise RayCoreError(f"{rtus} RTUs: the RTL differs from the reference: {'; '.join(report.examples)}")
    values = render.stats(rendered)
    axi, cycles = rendered.result.stats["axi"], values["cycles"]
    busy = axi["read_beats"] / cycles
    blocks = len(pixbuf.block_order(image.view.width, image.view.height)) / rtus
    return {
        "rtus": rtus,
        "cycles": cycles,
        "rays": values["rays"]["total"],
        "rays_per_cycle": values["rays"]["total"] / cycles,
        "rays_per_cycle_per_rtu": values["rays_per_cycle_per_rtu"],
        "occupancy": values["occupancy"],
        "slots_per_ray": values["slots_per_ray"],
        "bytes_per_ray": values["bytes_per_ray"]["total"],
        "bus_busy": busy,
        # From address to last data, were each burst alone: the least number of reads that are open on the average.
        "reads_open": (axi["read_bursts"] * latency + axi["read_beats"]) / cycles,
        "l2_hit_rate": values["cache"]["l2"]["hit_rate"],
        "blocks_per_rtu": blocks,
        "bound": "bus" if busy >= BUS_FULL else "last blocks" if rtus > 1 and blocks < FEW_BLOCKS else "RTUs",
        "stats": values,
    }


def curve(image, counts=DEFAULT_RTUS, width=64, latency=60, reference=None, done=None):
    """Frames on each number of RTUs: `measure` of each, with `speedup` and `efficiency` (speedup an RTU) added.

    Args: counts: numbers of RTUs, the others are compared with the first; done: called with each row; the rest: as `measure`.
    Raises: OptionError for counts that make no sense, and as `measure`.
    """
    if not counts or len(set(counts)) < len(counts) or any(not 1 <= n <= sim.MAX_RTUS for n in counts):
        raise OptionError(f"numbers of RTUs must be different and 1 to {sim.MAX_RTUS}, not {' '.join(map(str, counts))}")
    rows = []
    for rtus in counts:
        row = measure(image, rtus, width, latency, reference)
        first = rows[0] if rows else row
        row["speedup"] = first["cycles"] / row["cycles"] * first["rtus"]
        row["efficiency"] = row["speedup"] / rtus
        rows.append(row)
        if done:
            done(row)
    return rows


def table(rows, title=None):
    """The rows of `curve` as a rich table."""
    out = Table(title=title)
    for column in COLUMNS:
        out.add_column(column, justify="left" if column == "bound by" else "right")
    for row in rows:
        out.add_row(
            str(row["rtus"]), f"{row['cycles']:,}", f"{row['speedup']:.2f}", f"{row['efficiency']:.1%}",
            f"{row['rays_per_cycle_per_rtu']:.4f}", f"{row['occupancy']:.1%}", f"{row['slots_per_ray']:.1f}",
            f"{row['bytes_per_ray']:.1f}", f"{row['bus_busy']:.1%}", f"{row['reads_open']:.1f}",
            f"{row['l2_hit_rate']:.1%}", f"{row['blocks_per_rtu']:.0f}", row["bound"],
        )  # fmt: skip
    return out


def plot(curves):
    """Speedup and bus load over the number of RTUs as a PNG. Args: curves: {name: rows of `curve`}. Returns: its bytes."""
    try:
        import matplotlib
    except ImportError:
        raise OptionError("the plot needs matplotlib, which `make lint` installs; --no-plot does without") from None
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 4), layout="constrained")
    most = max(row["rtus"] for rows in curves.values() for row in rows)
    left.plot([1, most], [1, most], "--", color="grey", linewidth=1, label="as many times as RTUs")
    for name, rows in curves.items():
        counts = [row["rtus"] for row in rows]
        left.plot(counts, [row["speedup"] for row in rows], "o-", label=name)
        right.plot(counts, [100 * row["bus_busy"] for row in rows], "o-", label=name)
    left.set(xlabel="RTUs", ylabel="speedup", xlim=(0, None), ylim=(0, None))
    right.set(xlabel="RTUs", ylabel="cycles with a beat of read data, %", xlim=(0, None), ylim=(0, 100))
    left.legend()
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=120)
    pyplot.close(figure)
    return out.getvalue()


def main(argv):
    """Command line."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="raycore.scaling", description=__doc__, formatter_class=raw)
    parser.add_argument("scene", help="file, or one of our scenes")
    parser.add_argument("--rtus", nargs="+", type=int, default=list(DEFAULT_RTUS), metavar="N", help="1 2 4 6 8")
    parser.add_argument("--size", default="320x192", metavar="WxH", help="of the picture in pixels (320x192)")
    parser.add_argument("--depth", type=int, metavar="N", help="bounces (default: the scene's)")
    parser.add_argument("--camera", help="as in raycore render")
    parser.add_argument("--light", action="append", help="as in raycore render, repeat for more")
    parser.add_argument("--mem-width", type=int, default=64, help="memory bus in bits (64)")
    parser.add_argument("--mem-latency", type=int, default=60, help="cycles (60)")
    parser.add_argument("--fast", action="store_true", help="do not compare with the reference")
    parser.add_argument("--no-plot", action="store_true", help="write the JSON only")
    parser.add_argument("-o", "--output", type=Path, metavar="OUT.json", help="(build/scaling-SCENE.json)")
    args = parser.parse_args(argv)
    width, _, height = args.size.partition("x")
    if not (width.isdigit() and height.isdigit()):
        raise OptionError(f"--size {args.size}: give WIDTHxHEIGHT")
    output = args.output or BUILD / f"scaling-{Path(args.scene).stem}.json"
    output.parent.mkdir(parents=True, exist_ok=True) if args.output is None else None
    if not output.parent.is_dir() or output.is_dir():
        raise OutputError(f"--output {output}: no such folder, or a folder itself")
    for rtus in args.rtus:
        if not 1 <= rtus <= sim.MAX_RTUS:
            raise OptionError(f"--rtus {rtus}: there can be 1 to {sim.MAX_RTUS}")
    camera = parse_camera(args.camera) if args.camera else None
    lights = [parse_light(text) for text in args.light] if args.light else None
    console = Console(width=150)
    console.print(f"[dim]loading {args.scene}, building its tree[/dim]")
    view = View(int(width), int(height), camera, lights, max_depth=args.depth)
    image = build_image(build_geometry(load_scene(args.scene)), view)
    if not args.fast:
        console.print("[dim]rendering the reference[/dim]")
    reference = None if args.fast else frame.render_fp24(image)

    def tell(row):
        console.print(f"[dim]{row['rtus']} RTUs: {row['cycles']:,} cycles, {row['speedup']:.2f} times[/dim]")

    rows = curve(image, args.rtus, args.mem_width, args.mem_latency, reference, tell)
    name = f"{image.geometry.scene.name}, {args.size}, depth {image.view.max_depth}"
    console.print(table(rows, f"{name}; memory of {args.mem_width} bits, {args.mem_latency} cycles"))
    written = {
        "scene": image.geometry.scene.name,
        "size": [image.view.width, image.view.height],
        "max_depth": image.view.max_depth,
        "camera": asdict(image.view.camera),
        "memory": {"width": args.mem_width, "latency": args.mem_latency},
        "compared": not args.fast,
        "rows": rows,
    }
    output.write_text(json.dumps(written, indent=1, default=lambda v: v.item() if isinstance(v, np.generic) else str(v)) + "\n")
    console.print(f"wrote {output}")
    if not args.no_plot:
        output.with_suffix(".png").write_bytes(plot({name: rows}))
        console.print(f"wrote {output.with_suffix('.png')}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except RayCoreError as err:
        sys.exit(f"raycore.scaling: {err}")
