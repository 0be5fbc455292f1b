# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The command `raycore`: pictures of scenes, computed by the RTL, and what a scene takes. docs/cli.md explains the files."""

import contextlib
import json
import os
import re
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from typer.core import TyperGroup

from raycore import __version__
from raycore.cli_sweep import sweep
from raycore.errors import OptionError, OutputError, RayCoreError
from raycore.output import as_json as _json
from raycore.output import claim as _claim
from raycore.output import encode_srgb as _encode_srgb
from raycore.output import npz as _npz
from raycore.output import png as _png
from raycore.output import status as _status
from raycore.output import table as _table
from raycore.output import write as _write
from raycore.toolchain import ToolchainError

BAD_INPUT, FAILED, INTERRUPTED = 2, 1, 130
_UsageError = typer.BadParameter.__mro__[1]


class _Commands(TyperGroup):
    """Ends every error with one line on stderr and an exit code."""

    def main(self, args=None, prog_name="raycore", standalone_mode=True, **more):
        try:
            code = super().main(args, prog_name or "raycore", standalone_mode=False, **more)
        except _UsageError as error:
            command = error.ctx.command_path if error.ctx else "raycore"
            _die(f"{' '.join(error.format_message().split())} (see {command} --help)", BAD_INPUT)
        except (RayCoreError, ToolchainError) as error:
            _die(error, BAD_INPUT if isinstance(error, OptionError) else FAILED)
        except (KeyboardInterrupt, typer.Abort):
            _die("interrupted", INTERRUPTED)
        except MemoryError:
            _die("out of memory; take a smaller picture or a simpler scene", FAILED)
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            code = FAILED
        except Exception as error:
            if os.environ.get("RAYCORE_DEBUG"):
                raise
            _die(f"internal error, {type(error).__name__}: {error} (RAYCORE_DEBUG=1 shows where)", FAILED)
        if not standalone_mode:
            return code
        sys.exit(code if isinstance(code, int) else 0)


def _die(message, code):
    print(f"raycore: {' '.join(str(message).split())}", file=sys.stderr)
    sys.exit(code)


app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="Render scenes on RayCore, an open hardware ray tracer: the RTL itself computes every pixel, under Verilator.",
)


class Engine(StrEnum):
    """Who computes the picture."""

    rtl = "rtl"
    model = "model"
    double = "double"


class BuildEngine(StrEnum):
    """Who builds the tree of `raycore build`."""

    rtl = "rtl"
    model = "model"


class RecordMaker(StrEnum):
    """Who makes TriAccel records and triangle information of a tree that the RTL builds."""

    host = "host"
    rtl = "rtl"


class TreeBuilder(StrEnum):
    """Who builds the tree; cpu is another name of the host."""

    host = "host"
    cpu = "cpu"
    model = "model"
    rtl = "rtl"


# ---- arguments ----------------------------------------------------------------------------------------------------------------


def _size(text):
    found = re.fullmatch(r"(\d{1,9})[xX](\d{1,9})", text)
    if not found:
        raise OptionError(f"--size {text}: expected WIDTHxHEIGHT, such as 320x192")
    return int(found[1]), int(found[2])


def _scene(name, textures=True, compact=False):
    from raycore.scene import compact_textures, load_scene, without_textures

    scene = load_scene(name)
    scene = scene if textures else without_textures(scene)
    return compact_textures(scene) if compact else scene


def _note(lines):
    """What was changed on the way, on stderr."""
    for line in lines:
        print(f"raycore: note: {' '.join(line.split())}", file=sys.stderr)


# ---- commands --------------------------------------------------------------------------------------------------------------


@app.callback()
def _main():
    pass


@app.command(no_args_is_help=True)
def render(
    scene: Annotated[
        str,
        typer.Argument(
            metavar="SCENE", help="glTF, GLB, OBJ, PLY, STL or AFF file, JSON of ours, or one of our scenes by name."
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="OUT.png", help="The picture, row 0 at the top.")],
    size: Annotated[str, typer.Option(metavar="WxH", help="Size of the picture in pixels.")] = "320x192",
    camera: Annotated[
        str | None,
        typer.Option(
            metavar="EYE:TARGET:UP:FOV",
            help="`ex,ey,ez:tx,ty,tz:ux,uy,uz:fov`, vertical field of view in degrees. "
            "Default: the file's own camera, or a view that frames the scene.",
        ),
    ] = None,
    light: Annotated[
        list[str] | None,
        typer.Option(
            metavar="X,Y,Z[:R,G,B]",
            help="A point light; repeat for more, at most 16. Default: the file's own, or a lamp.",
        ),
    ] = None,
    depth: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Bounces at mirrors, glass and what is not opaque, 0 to 15. "
            "Default: 4 if the scene has any of them (or what its file says), else 0.",
        ),
    ] = None,
    min_weight: Annotated[
        float,
        typer.Option(
            metavar="W", help="Rays that could add no more than this to a pixel are not traced; 0 to less than 1."
        ),
    ] = 1.0 / 256.0,
    no_shadows: Annotated[bool, typer.Option("--no-shadows", help="Trace no shadow rays.")] = False,
    trilinear: Annotated[
        bool, typer.Option("--trilinear", help="Blend two mip levels instead of taking the nearer one.")
    ] = False,
    no_textures: Annotated[
        bool, typer.Option("--no-textures", help="Use the mean colour of each texture instead of it.")
    ] = False,
    compact_textures: Annotated[
        bool,
        typer.Option("--compact-textures", help="Store 16 bits a texel (RGBA5551) instead of 32: half the traffic."),
    ] = False,
    srgb: Annotated[
        bool,
        typer.Option(
            "--srgb",
            help="Encode the PNG for screens: the frame buffer gets 10 bits a channel, the host makes them sRGB. "
            "Default: the frame buffer's linear 8 bits as they are, which look dark.",
        ),
    ] = False,
    mem_latency: Annotated[int, typer.Option(metavar="N", help="Cycles from address to data, 1 to 1000000.")] = 60,
    mem_width: Annotated[int, typer.Option(metavar="BITS", help="Memory bus: 64, 128 or 256 bits.")] = 64,
    backpressure: Annotated[
        float, typer.Option(metavar="P", help="Probability that a memory channel pauses for a cycle.")
    ] = 0.0,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the pauses.")] = 1,
    stats: Annotated[Path | None, typer.Option(metavar="STATS.json", help="All counters and what they mean.")] = None,
    aov: Annotated[
        Path | None, typer.Option(metavar="HITS.npz", help="Rays and hits of all pixels, in world units.")
    ] = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Compare with the bit-exact reference, with double precision and with Embree; "
            "writes a difference picture `OUT.diff.png`.",
        ),
    ] = False,
    profile: Annotated[
        bool,
        typer.Option(
            "--profile",
            help="Say where the slots of the T&I pipelines go; writes `OUT.slots.png`, bars by what they were spent on, and "
            "`OUT.heat.png`, slots of each pixel.",
        ),
    ] = False,
    jobs: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=1,
            max=256,
            help="Split the picture into N simulations at a time. The same pixels and hits; cycles are the sum of all parts, "
            "each of which starts with cold caches.",
        ),
    ] = 1,
    waves: Annotated[Path | None, typer.Option(metavar="WAVES.fst", help="Record waveforms; slow.")] = None,
    waves_from: Annotated[int, typer.Option(metavar="CYCLE", min=0, help="Where the waveforms begin.")] = 0,
    waves_cycles: Annotated[int | None, typer.Option(metavar="N", min=1, help="How many cycles they last.")] = None,
    engine: Annotated[
        Engine, typer.Option(help="rtl: the hardware; model: its bit-exact reference; double: double precision.")
    ] = Engine.rtl,
    tree: Annotated[
        TreeBuilder,
        typer.Option(help="host, or cpu: exact SAH with clipping, one tree over everything; model: the tree that the tree builder "
            "makes; rtl: the unit builds it, in the same run of the hardware, before the picture. By these two, dynamic objects "
            "have trees of their own, which rigid ones share."),
    ] = TreeBuilder.host,
    accel: Annotated[
        RecordMaker,
        typer.Option(help="With --tree rtl. host: TriAccel records and triangle information are given; "
            "rtl: the record unit makes them from vertices, while the tree is built."),
    ] = RecordMaker.host,
    rtus: Annotated[
        int, typer.Option(metavar="N", help="Ray-tracing units that share the picture and the memory, 1 to 16.")
    ] = 1,
):
    """Render SCENE to a PNG.

    Examples, from simple to thorough:

    `raycore render hall -o hall.png`

    `raycore render bunny.obj -o bunny.png --size 800x480 --light 0.2,0.5,0.2`

    `raycore render room.glb -o room.png --camera 0,2,8:0,1,0:0,1,0:50 --light 3,4,2 --light -3,4,2:0.5,0.4,0.3`

    `raycore render still_life -o still.png --depth 10 --srgb`

    `raycore render room.glb -o room.png --stats room.json --aov room.npz --check`

    `raycore render kitchen -o kitchen.png --depth 10 --profile`

    `raycore render kitchen -o kitchen.png --size 800x480 --jobs 4`

    `raycore render room.glb -o room.png --no-shadows --mem-latency 200 --mem-width 128`

    `raycore render chess -o chess.png --tree rtl --accel rtl --check`

    `raycore render tiny -o tiny.png --size 32x32 --waves tiny.fst --waves-from 1000 --waves-cycles 5000`
    """
    from raycore import sim
    from raycore.image import View, build_geometry, build_image, complete_view
    from raycore.model.pixbuf import RGB10A2, RGBA8, unpack
    from raycore.scene import parse_camera, parse_light
    from raycore.tbu import Params

    outputs = {"--output": output, "--stats": stats, "--aov": aov, "--waves": waves}
    difference = output.with_suffix(".diff.png") if check else None
    bars, heat = (output.with_suffix(f".{what}.png") if profile else None for what in ("slots", "heat"))
    for option, path in (*outputs.items(), ("--check", difference), ("--profile", bars), ("--profile", heat)):
        _claim(path, option)
    named = [p.resolve() for p in (*outputs.values(), difference, bars, heat) if p is not None]
    if len(set(named)) < len(named):
        raise OptionError("two outputs have the same name")
    if waves is not None and engine is not Engine.rtl:
        raise OptionError("--waves: only the engine rtl has waveforms")
    if profile and engine is Engine.double:
        raise OptionError("--profile: only the engines rtl and model have slots")
    in_hardware = tree is TreeBuilder.rtl
    if jobs > 1 and (engine is not Engine.rtl or in_hardware or waves is not None):
        raise OptionError("--jobs: only pictures by the engine rtl can be split, without --waves and --tree rtl")
    if in_hardware and engine is not Engine.rtl:
        raise OptionError("--tree rtl: only the engine rtl builds trees")
    if accel is RecordMaker.rtl and not in_hardware:
        raise OptionError("--accel rtl: only with --tree rtl")
    if not 1 <= rtus <= sim.MAX_RTUS:
        raise OptionError(f"--rtus {rtus}: there can be 1 to {sim.MAX_RTUS}")
    if rtus > 1 and engine is not Engine.rtl:
        raise OptionError("--rtus: only the engine rtl has RTUs")
    simulation = {"records": True} if accel is RecordMaker.rtl else {}
    memory = sim.Memory(
        width=mem_width, latency=mem_latency, outstanding=sim.outstanding(rtus), backpressure=backpressure, seed=seed
    )
    width, height = _size(size)
    view = View(
        width,
        height,
        parse_camera(camera) if camera else None,
        [parse_light(text) for text in light] if light else None,
        not no_shadows,
        RGB10A2 if srgb else RGBA8,
        max_depth=depth,
        min_weight=min_weight,
        trilinear=trilinear,
    )

    console = Console(stderr=True)
    with _status(console, f"Loading {scene}"):
        loaded = _scene(scene, not no_textures, compact_textures)
        complete_view(loaded, view)  # what is wrong with the view shows before the tree is built
    with _status(console, f"Building the tree of {len(loaded.triangles):,} triangles"):
        geometry = build_geometry(loaded, None if tree in (TreeBuilder.host, TreeBuilder.cpu) else Params(), in_hardware)
        image = None if in_hardware else build_image(geometry, view)
    _note((*loaded.warnings, *geometry.notes))

    from raycore import dynamic
    from raycore import profile as profiling
    from raycore import render as rendering
    from raycore.check import channels

    if engine is Engine.rtl:
        with _status(console, "Building the simulator if the RTL has changed"):
            sim.build(mem_width=mem_width, waves=waves is not None, tbu=in_hardware, rtus=rtus)
        simulation |= {"waves": waves, "waves_from": waves_from, "waves_cycles": waves_cycles, "rtus": rtus}
    hits = check or profile or aov is not None
    if in_hardware:
        rendered = dynamic.render_frame(geometry, view, memory, hits, keep_memory=check, **simulation)
        image = rendered.image
    else:
        with _status(console, f"Simulating {jobs} parts") if jobs > 1 else contextlib.nullcontext():
            rendered = rendering.render(image, engine.value, memory, hits, jobs, **simulation)
    if srgb:
        _write(output, _png(_encode_srgb(unpack(rendered.pixels, RGB10A2)), srgb=True))
    else:
        _write(output, _png(channels(rendered.pixels)))
    values = rendering.stats(rendered, file=scene)
    if aov is not None:
        with _status(console, "Writing the hits"):
            _write(aov, _npz(rendering.aov(rendered)))
    found = None
    if profile:
        found = profiling.profile(rendered)
        found.check()
        values["profile"] = found.values()
        _write(bars, profiling.bars({loaded.name: values["profile"]}))
        _write(heat, profiling.heat_map(found.per_pixel))
    report = None
    if check:
        from raycore.check import check as run_check

        with _status(console, "Checking (the first time this compiles the reference, about a minute)"):
            if in_hardware:  # everything is measured with the model's tree, which must be that of the RTL
                built = dynamic.check_frame(rendered)
                report = run_check(built.image, rendered.result, built.reference, built.exact)
            else:
                report = run_check(image, rendered.result, rendered.frame if engine is Engine.model else None)
        values["check"] = report.values()
        if in_hardware:
            values["check"]["tree"] = {"same": built.difference is None, "difference": built.difference}
            values["check"]["records"] = {"same": built.records is None, "difference": built.records}
        _write(difference, _png(report.picture))
        if found is not None and report.ok and not (in_hardware and built.jumps):  # a jump node is a step more
            found.check(report.reference)
    if stats is not None:
        _write(stats, _json(values))

    rows = [
        (
            "scene",
            f"{image.geometry.scene.name}, {len(loaded.triangles):,} triangles, "
            f"{values['tbu']['counters']['nodes'] if in_hardware else image.geometry.tree.nodes.size:,} nodes",
        ),
        ("picture", f"{width}x{height} in {rendered.seconds:.1f} s by {engine.value}, depth {image.view.max_depth}"),
        *rendering.summary(values),
    ]
    out = Console(highlight=False, width=max(100, Console().width) if not sys.stdout.isatty() else None)
    out.print(_table(rows))
    if found is not None:
        out.print()
        out.print(profiling.table(found))
    if report is not None:
        marks = [
            (what, got, f"target {want}" if want else "", "" if fine else "MISSED")
            for what, got, want, fine in report.rows()
        ]
        out.print()
        out.print(_table(marks))
        for line in report.exact.examples if report.exact else ():
            out.print(f"  {line}", markup=False)
        if in_hardware:
            out.print(f"tree as the model's, node by node: {'yes' if built.difference is None else 'NO'}")
            if accel is RecordMaker.rtl:
                out.print(f"records as the model's, bit by bit: {'yes' if built.records is None else 'NO'}")
    files = [p for p in (output, difference, bars, heat, stats, aov, waves) if p is not None]
    out.print("wrote " + ", ".join(map(str, files)), markup=False, soft_wrap=True)
    if report is not None and not report.ok:
        e = report.exact
        raise RayCoreError(
            f"the RTL differs from the reference in {e.pixels} pixels, {e.hits} hits and {len(e.counters)} counters"
        )
    if in_hardware and check and built.difference is not None:
        raise RayCoreError(f"the tree differs from the model's {built.difference}")
    if in_hardware and check and built.records is not None:
        raise RayCoreError(f"the RTL differs from the model {built.records}")


@app.command(no_args_is_help=True)
def animate(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="A scene file (JSON) with animations, or one of ours by name.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FOLDER", help="For the pictures; made if it is not there.")
    ],
    frames: Annotated[int, typer.Option(metavar="N", help="How many pictures.")] = 24,
    fps: Annotated[
        float | None,
        typer.Option(metavar="F", help="Pictures a second. Default: N pictures make one round of the scene."),
    ] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="As for `raycore render`.")] = "160x96",
    depth: Annotated[int | None, typer.Option(metavar="N", help="As for `raycore render`.")] = None,
    camera: Annotated[str | None, typer.Option(metavar="EYE:TARGET:UP:FOV", help="As for `raycore render`.")] = None,
    no_shadows: Annotated[bool, typer.Option("--no-shadows", help="As for `raycore render`.")] = False,
    no_textures: Annotated[bool, typer.Option("--no-textures", help="As for `raycore render`.")] = False,
    linear: Annotated[
        bool, typer.Option("--linear", help="The frame buffer's linear 8 bits as they are. Default: sRGB, for screens.")
    ] = False,
    mem_latency: Annotated[int, typer.Option(metavar="N", help="As for `raycore render`.")] = 60,
    mem_width: Annotated[int, typer.Option(metavar="BITS", help="As for `raycore render`.")] = 64,
    backpressure: Annotated[float, typer.Option(metavar="P", help="As for `raycore render`.")] = 0.0,
    seed: Annotated[int, typer.Option(metavar="N", help="As for `raycore render`.")] = 1,
    stats: Annotated[Path | None, typer.Option(metavar="STATS.json", help="The table and more.")] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Compare every picture, hit and tree with the bit-exact references.")
    ] = False,
    accel: Annotated[RecordMaker, typer.Option(help="As for `raycore render`.")] = RecordMaker.host,
):
    """Render SCENE as it moves: the hardware builds the tree anew for every picture.

    Writes `FOLDER/frame_0000.png` and so on, and `FOLDER/animation.png`, an animated PNG that browsers show.

    Examples:

    `raycore animate pendulum -o build/pendulum`

    `raycore animate carousel -o build/carousel --frames 12 --size 320x192 --check`
    """
    from raycore import animate as animation
    from raycore import sim
    from raycore.check import channels
    from raycore.image import View
    from raycore.model.pixbuf import RGB10A2, RGBA8, unpack
    from raycore.scene import parse_camera, without_textures

    _claim(stats, "--stats")
    if output.exists() and not output.is_dir():
        raise OutputError(f"--output {output}: is a file; give a folder")
    _claim(output.parent / output.name, "--output") if not output.exists() else None
    memory = sim.Memory(width=mem_width, latency=mem_latency, backpressure=backpressure, seed=seed)
    view = View(
        *_size(size),
        parse_camera(camera) if camera else None,
        shadows=not no_shadows,
        fb_format=RGBA8 if linear else RGB10A2,
        max_depth=depth,
    )
    moments = animation.times(scene, frames, fps)
    output.mkdir(exist_ok=True)
    console = Console(stderr=True)
    with _status(console, "Building the simulator if the RTL has changed"):
        sim.build(mem_width=mem_width, tbu=True)
    taken, pictures = [], []
    for i, time in enumerate(moments):
        with _status(console, f"Picture {i + 1} of {frames}"):
            frame = animation.take(
                scene,
                i,
                time,
                view,
                memory,
                check,
                prepare=without_textures if no_textures else None,
                records=accel is RecordMaker.rtl,
            )
        pixels = frame.rendered.pixels
        pictures.append(channels(pixels) if linear else _encode_srgb(unpack(pixels, RGB10A2)))
        _write(output / f"frame_{i:04d}.png", _png(pictures[-1], srgb=not linear))
        taken.append(frame)
    step = moments[1] if frames > 1 else 1.0
    _write(output / "animation.png", animation.moving_picture(pictures, step))
    values = animation.summary(taken, check)
    if stats is not None:
        _write(stats, _json(values))

    table = Table(box=None, pad_edge=False)
    for column in animation.COLUMNS[: len(taken[0].row)]:
        table.add_column(column, justify="right")
    for frame in taken:
        table.add_row(*frame.row)
    out = Console(highlight=False, width=max(100, Console().width) if not sys.stdout.isatty() else None)
    out.print(table)
    m = values["mean"]
    each = m["build_cycles_per_triangle"]  # None: only trees over boxes
    out.print(
        f"mean: {m['build_cycles']:,.0f} cycles to build{'' if each is None else f', {each:.1f} a triangle'}; "
        f"{m['render_cycles']:,.0f} to render, {m['rays_per_cycle']:.4f} rays per cycle"
    )
    out.print(f"wrote {frames} pictures and animation.png to {output}", markup=False, soft_wrap=True)
    wrong = [f for f in taken if f.check is not None and not f.check.same]
    if wrong:
        e = wrong[0].check
        raise RayCoreError(
            f"{len(wrong)} of {frames} pictures differ from the references; the first, {wrong[0].number}, in "
            f"{e.exact.pixels} pixels, {e.exact.hits} hits, {len(e.exact.counters)} counters"
            + (f", and its tree {e.difference}" if e.difference else "")
            + (f", and {e.records}" if e.records else "")
        )


app.command(no_args_is_help=True)(sweep)


@app.command(no_args_is_help=True)
def build(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="As for `raycore render`.")],
    stats: Annotated[Path | None, typer.Option(metavar="STATS.json", help="All figures and what they mean.")] = None,
    engine: Annotated[
        BuildEngine,
        typer.Option(help="rtl: the tree-building unit; model: the tree that it must build, without cycles."),
    ] = BuildEngine.rtl,
    refine_max: Annotated[
        int, typer.Option(metavar="N", min=0, max=1 << 19, help="Nodes of up to N triangles get fine bins.")
    ] = 8192,
    mem_latency: Annotated[int, typer.Option(metavar="N", help="As for `raycore render`.")] = 60,
    mem_width: Annotated[int, typer.Option(metavar="BITS", help="As for `raycore render`.")] = 64,
    backpressure: Annotated[float, typer.Option(metavar="P", help="As for `raycore render`.")] = 0.0,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the pauses.")] = 1,
):
    """Build the tree of SCENE by the tree-building unit and compare it, node by node, with the model's.

    Examples:

    `raycore build chess`

    `raycore build bunny.obj --stats bunny.json --mem-latency 200`
    """
    from raycore import build as building
    from raycore import sim
    from raycore.tbu import Params

    _claim(stats, "--stats")
    memory = sim.Memory(width=mem_width, latency=mem_latency, backpressure=backpressure, seed=seed)
    console = Console(stderr=True)
    with _status(console, f"Loading {scene}"):
        loaded = _scene(scene)
    with _status(console, f"Building the tree of {len(loaded.triangles):,} triangles"):
        built = building.build(loaded, engine.value, memory, Params(refine_max=refine_max))
    values = building.stats(built, loaded, memory if engine is BuildEngine.rtl else None, file=scene)
    if stats is not None:
        _write(stats, _json(values))
    rows = [("scene", f"{loaded.name}, by {engine.value}"), *building.summary(values)]
    Console(highlight=False, width=max(100, Console().width) if not sys.stdout.isatty() else None).print(_table(rows))
    if stats is not None:
        print(f"wrote {stats}")
    if built.difference is not None:
        full = built.run.counters.get("forced", 0)
        why = f"; {full} leaves were made because a pipeline's lists were full" if full else ""
        raise RayCoreError(f"the tree differs from the model's {built.difference}{why}")


@app.command(no_args_is_help=True)
def info(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="As for `raycore render`.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False,
    no_textures: Annotated[bool, typer.Option("--no-textures", help="As for `raycore render`.")] = False,
    compact_textures: Annotated[bool, typer.Option("--compact-textures", help="As for `raycore render`.")] = False,
):
    """Show what SCENE takes: triangles, materials, textures, tree, memory; and what of its file is not used.

    Examples:

    `raycore info hall`

    `raycore info bunny.obj --json`
    """
    from raycore.info import rows, scene_info

    console = Console(stderr=True)
    with _status(console, f"Reading {scene}"):
        values = scene_info(scene, not no_textures, compact_textures)
    if as_json:
        print(json.dumps(values, indent=2))
        return
    Console(highlight=False).print(_table(rows(values)))
    _note(values["warnings"])


@app.command()
def version():
    """Print the version."""
    print(f"raycore {__version__}")


main = app

if __name__ == "__main__":
    app()
