# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The command `raycore sweep`."""

import re
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from raycore.errors import OptionError, OutputError, RayCoreError
from raycore.output import as_json, claim, status, write

COLUMNS = {
    "nt_sets": "node sets",
    "list_sets": "list sets",
    "l2_sets": "L2 sets",
    "l2_ways": "ways",
    "mem_width": "bus",
    "mem_latency": "latency",
    "sram_kb": "KB",
}


def numbers(option, text):
    """Whole numbers of a list such as 64,128. Raises: OptionError."""
    if not re.fullmatch(r"\d{1,7}(,\d{1,7})*", text):
        raise OptionError(f"{option} {text}: expected whole numbers with commas, such as 64,128")
    return sorted({int(n) for n in text.split(",")})


def result_table(rows, best):
    """Table of the points; best: the row to mark."""
    caption = "L1 sets of two ways; bus in bits; KB of SRAM in a unit; hits of L1 node / list / L2"
    table = Table(box=None, pad_edge=False, caption=caption)
    for column in (*COLUMNS.values(), "rays/cycle", "slots/ray", "busy", "hits %", "bytes/ray", ""):
        table.add_column(column, justify="right", no_wrap=True)
    for row in rows:
        rates = " / ".join(f"{100 * row[f'hit_rate_{name}']:.1f}" for name in ("l1_node", "l1_list", "l2"))
        table.add_row(
            *(f"{row[name]:g}" for name in COLUMNS),
            f"{row['rays_per_cycle']:.4f}",
            f"{row['slots_per_ray']:.2f}",
            f"{row['occupancy']:.1%}",
            rates,
            f"{row['bytes_per_ray']:.2f}",
            "fastest" if row is best else "" if row["exact"] else "DIFFERS",
        )
    return table


def sweep(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="As for `raycore render`.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FOLDER", help="For tables and plots; made if it is not there.")
    ],
    nt_sets: Annotated[str, typer.Option(metavar="N,N,…", help="Sets of each L1 node and triangle cache, two ways.")] = "128",
    list_sets: Annotated[str, typer.Option(metavar="N,N,…", help="Sets of each L1 list cache, two ways.")] = "32",
    l2_sets: Annotated[str, typer.Option(metavar="N,N,…", help="Sets of the L2 cache.")] = "256",
    l2_ways: Annotated[str, typer.Option(metavar="N,N,…", help="Ways of the L2 cache.")] = "14",
    mem_width: Annotated[str, typer.Option(metavar="N,N,…", help="Memory bus: of 64, 128, 256 bits.")] = "64",
    mem_latency: Annotated[str, typer.Option(metavar="N,N,…", help="Cycles from address to data.")] = "60",
    budget: Annotated[
        float | None,
        typer.Option(metavar="KB", min=0.0, help="Leave out what takes more SRAM; the paper's unit has 507.1."),
    ] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="As for `raycore render`.")] = "160x96",
    camera: Annotated[str | None, typer.Option(metavar="EYE:TARGET:UP:FOV", help="As for `raycore render`.")] = None,
    light: Annotated[list[str] | None, typer.Option(metavar="X,Y,Z[:R,G,B]", help="As for `raycore render`.")] = None,
    depth: Annotated[int | None, typer.Option(metavar="N", help="As for `raycore render`.")] = None,
    no_shadows: Annotated[bool, typer.Option("--no-shadows", help="As for `raycore render`.")] = False,
    jobs: Annotated[int, typer.Option(metavar="N", min=1, max=256, help="Simulations at a time on this machine.")] = 1,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="A Dask scheduler, such as tcp://10.0.0.1:8786, whose workers simulate."),
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Run again what FOLDER has results of already.")] = False,
):
    """Render SCENE on many configurations of caches and memory: all combinations of the lists.

    Every picture must be the reference's, bit for bit. Writes `sweep.csv`, `sweep.json`, `sram.png` and, with more than one
    latency, `latency.png`. A sweep that was interrupted goes on where it was.

    Examples:

    `raycore sweep hall -o build/hall --mem-latency 20,60,200,400`

    `raycore sweep kitchen -o build/kitchen --depth 10 --nt-sets 64,128,256 --l2-ways 8,13 --budget 507.1 --jobs 4`

    `raycore sweep kitchen -o build/kitchen --mem-width 64,128,256 --scheduler tcp://10.0.0.1:8786`
    """
    from raycore import sweep
    from raycore.image import View, build_geometry, build_image
    from raycore.scene import load_scene, parse_camera, parse_light

    lists = {
        "nt_sets": nt_sets,
        "list_sets": list_sets,
        "l2_sets": l2_sets,
        "l2_ways": l2_ways,
        "mem_width": mem_width,
        "mem_latency": mem_latency,
    }
    wanted = sweep.points({k: numbers(f"--{k.replace('_', '-')}", v) for k, v in lists.items()}, budget)
    found = re.fullmatch(r"(\d{1,9})[xX](\d{1,9})", size)
    if not found:
        raise OptionError(f"--size {size}: expected WIDTHxHEIGHT, such as 320x192")
    view = View(
        int(found[1]),
        int(found[2]),
        parse_camera(camera) if camera else None,
        [parse_light(text) for text in light] if light else None,
        not no_shadows,
        max_depth=depth,
    )
    if output.exists() and not output.is_dir():
        raise OutputError(f"--output {output}: is a file; give a folder")
    claim(output / "sweep.json" if output.exists() else output, "--output")

    console = Console(stderr=True)
    with status(console, f"Loading {scene} and building its tree"):
        loaded = load_scene(scene)
        image = build_image(build_geometry(loaded), view)
    output.mkdir(exist_ok=True)
    sign = sweep.signature(image)
    results = {} if fresh else sweep.known(output / "sweep.json", sign)
    todo = [p for p in wanted if p.key not in results]

    def keep():
        rows = [results[p.key] for p in wanted if p.key in results]
        values = {"scene": loaded.name, "size": [view.width, view.height], "signature": sign, "points": results}
        write(output / "sweep.json", as_json(values))
        write(output / "sweep.csv", sweep.as_csv(rows))
        return rows

    if todo:
        with status(console, "Computing the reference (the first time this compiles it, about a minute)"):
            from raycore.model.frame import render_fp24

            task = sweep.Task(image.memory, image.registers, render_fp24(image))
        bar = Progress(
            TextColumn("Simulating"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        with bar:
            row = bar.add_task("", total=len(wanted), completed=len(wanted) - len(todo))
            outcomes = sweep.distributed(task, todo, scheduler) if scheduler else sweep.local(task, todo, jobs)
            for point, outcome in outcomes:
                if outcome[1]:
                    raise RayCoreError(f"{point} differs from the reference: {outcome[1][0]}")
                results[point.key] = sweep.figures(image, point, outcome)
                keep()
                bar.advance(row)
    rows = keep()
    best = max(rows, key=lambda r: r["rays_per_cycle"])
    write(output / "sram.png", sweep.sram_plot(rows, budget))
    files = ["sweep.csv", "sweep.json", "sram.png"]
    if len({r["mem_latency"] for r in rows}) > 1:
        write(output / "latency.png", sweep.latency_plot(rows))
        files.append("latency.png")
    out = Console(highlight=False, width=max(140, Console().width) if not sys.stdout.isatty() else None)
    out.print(result_table(rows, best))
    kept = f", {len(wanted) - len(todo)} of them from before" if len(todo) < len(wanted) else ""
    out.print(f"{len(rows)} configurations{kept}; pixels, hits and counters of all are the reference's")
    out.print(f"wrote {', '.join(files)} to {output}", markup=False, soft_wrap=True)
