# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Benchmark: `python -m raycore.bench`, also `make bench`. Rays per cycle, slots, hit rates and bytes, beside the paper's.

Without arguments it renders our own scenes. With `--views VIEWS.json --meshes FOLDER` it renders the meshes that the file
names, {"sibenik.ply": {"camera": "...", "light": "..."}, ...}, as the options of `raycore render`. Every scene is rendered
with primary rays alone and with a shadow ray to each light; memory is 64 bits, 60 cycles, 16 bursts.

Pixels come first: every frame is compared with the bit-exact reference unless --fast, and a difference fails the run.
Writes build/bench.json.
"""

import argparse
import json
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from raycore import check, render, sim
from raycore.errors import RayCoreError
from raycore.image import View, build_geometry, build_image
from raycore.model import frame
from raycore.scene import load_scene, parse_camera, parse_light
from raycore.toolchain import BUILD

OURS = ("hall", "still_life", "organic")

# Paper Table III, 800x480, primary rays (each casts a shadow ray): Mrays/s of four RTUs at 84 MHz, hit rates of L1 node,
# L1 list, L2 and triangle cache in percent, MB/s that are not texture.
PAPER = {
    "sibenik": (21.4, (99, 99, 73, 97), 30),
    "conference": (21.1, (99, 99, 65, 99), 62),
}


def paper_row(mesh):
    """(rays per cycle per RTU, hit rates, bytes per ray) of the paper for a mesh's name, or None."""
    for name, (mrays, hits, mbytes) in PAPER.items():
        if mesh.startswith(name) and "textured" not in mesh:
            return mrays / 84.0 / 4.0, hits, mbytes / mrays
    return None


def measure(geometry, view, exact):
    """Statistics of one frame. Raises: RayCoreError if a pixel, hit or count is not that of the reference."""
    image = build_image(geometry, view)
    rendered = render.render(image, "rtl", sim.Memory(), hits=exact)
    values = render.stats(rendered)
    if exact:
        report = check.compare_rtl(rendered.result, frame.render_fp24(image))
        if report.pixels or report.hits or report.counters:
            raise RayCoreError(f"{geometry.scene.name}: the RTL differs from the reference")
    return values


def row(name, rays, values):
    """Cells of a line of the table."""
    cache = values["cache"]
    return [
        name, rays, f"{values['rays_per_cycle_per_rtu']:.4f}", f"{values['slots_per_ray']:.2f}", f"{values['occupancy']:.1%}",
        " / ".join(f"{100 * cache[c]['hit_rate']:.1f}" for c in ("l1_node", "l1_list", "l2", "triangle")),
        f"{values['bytes_per_ray']['tree']:.2f}", f"{values['bytes_per_ray']['total']:.2f}",
        f"{values['simulation'].get('cycles_per_second', 0) / 1000:.0f}",
    ]  # fmt: skip


def main(argv):
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="raycore.bench", description=__doc__, formatter_class=raw)
    parser.add_argument("scene", nargs="*", help="scenes of ours or meshes; default: all of --views, else our own")
    parser.add_argument("--views", type=Path, help="JSON with camera and light of each mesh")
    parser.add_argument("--meshes", type=Path, default=Path(), help="folder of the meshes that --views names")
    parser.add_argument("--size", default="800x480")
    parser.add_argument("--fast", action="store_true", help="do not compare with the reference")
    args = parser.parse_args(argv)
    console = Console(width=140)
    width, height = (int(n) for n in args.size.split("x"))
    views = {k: v for k, v in json.loads(args.views.read_text()).items() if isinstance(v, dict)} if args.views else {}
    scenes = args.scene or list(views) or list(OURS)

    table = Table(title=f"{args.size}, 64-bit memory, 60 cycles; hit rates count every access, repeats after a miss included")
    for column in ("scene", "rays", "rays/cycle/RTU", "slots/ray", "occupancy", "L1 NT / list / L2 / triangle %",
                   "bytes/ray tree", "all", "kcycles/s"):  # fmt: skip
        table.add_column(column, justify="left" if column in ("scene", "rays") else "right")
    results = {}
    for name in scenes:
        view = views.get(name, {})
        camera = parse_camera(view["camera"]) if "camera" in view else None
        lights = [parse_light(view["light"])] if "light" in view else None
        geometry = build_geometry(load_scene(str(args.meshes / name) if name in views else name))
        for rays, shadows in (("primary", False), ("primary + shadow", True)):
            console.print(f"[dim]{name}, {rays}[/dim]")
            values = measure(geometry, View(width, height, camera, lights, shadows), not args.fast)
            results[f"{name}, {rays}"] = values
            table.add_row(*row(name, rays, values))
        if (paper := paper_row(name)) is not None:
            speed, hits, per_ray = paper
            cells = ["", "the paper's", f"{speed:.4f}", "", "", " / ".join(map(str, hits)), f"{per_ray:.1f}", "", ""]
            table.add_row(*cells, style="dim")
    console.print(table)
    BUILD.mkdir(parents=True, exist_ok=True)
    (BUILD / "bench.json").write_text(json.dumps(results, indent=1, default=str))
    console.print("wrote build/bench.json")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except RayCoreError as err:
        sys.exit(f"raycore.bench: {err}")
