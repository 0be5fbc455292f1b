# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The Verilator regression: `python -m raycore.regress [--quick | --full]`, also `make sim` and `make sim-full`.

1. Frames. Scenes of our own at sizes, memory latencies, widths and back-pressures of all kinds: every pixel, every hit
   record and every counter that does not depend on the memory must be that of the bit-exact reference.
2. Faults. Images with bits flipped at random, and memories that answer SLVERR and DECERR: the frame must end, done or with
   an error status, without an assertion, without breaking a rule of AXI and without an access outside its windows.
3. Units. The random tests of the arithmetic units and of the T&I unit, with more operands than `make test` takes.

Every case has a name; `--only NAME` repeats it alone.
"""

import argparse
import os
import subprocess
import sys
import threading
import time
import zlib
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field, replace

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from raycore import check, dynamic, scene, sim, tbu
from raycore.errors import RayCoreError
from raycore.image import View, build_geometry, build_image
from raycore.model.pixbuf import RGB10A2
from raycore.toolchain import REPO

FAULT_VIEW = View(24, 16, max_slots=4096, max_depth=4)  # a ray that loops in a broken tree ends the frame soon
FAULT_CYCLES = 20_000_000
ERR_SLVERR, ERR_DECERR = 6, 7  # err_e of rtl/rc_pkg.sv
FLIPPED = {  # how often
    **{"nodes": 7, "lists": 4, "instances": 4, "triaccel": 4, "info": 3},
    **{"materials": 2, "lights": 1, "uv": 2, "textures": 1},
}
DEEPEST = 15


@dataclass(frozen=True)
class FrameCase:
    """A frame to compare with the reference."""

    scene: str
    view: View
    memory: sim.Memory
    build: bool = False  # the RTL builds the tree first
    records: bool = False  # and makes the records

    @property
    def name(self):
        """What `--only` takes."""
        v, m = self.view, self.memory
        parts = [self.scene, f"{v.width}x{v.height}", f"{m.width}bit", f"lat{m.latency}"]
        parts += [f"bp{m.backpressure:g}s{m.seed}"] if m.backpressure else []
        parts += [f"out{m.outstanding}"] if m.outstanding != 16 else []
        parts += [] if v.shadows else ["noshadows"]
        parts += [f"depth{v.max_depth}"] if v.max_depth else []
        parts += ["trilinear"] if v.trilinear else []
        parts += [f"{len(v.lights)}lights"] if v.lights is not None else []
        parts += ["rgb10"] if v.fb_format == RGB10A2 else []
        parts += ["built"] if self.build else []
        parts += ["records"] if self.records else []
        return "frame/" + "-".join(parts)


@dataclass(frozen=True)
class FaultCase:
    """A frame that may fail, but must end."""

    seed: int
    scene: str = "tiny"
    build: bool = False  # the RTL builds the tree first

    @property
    def records(self):
        """Whether the RTL makes the records too."""
        return self.build and self.seed % 2 == 1

    @property
    def name(self):
        """What `--only` takes."""
        return f"fault/{self.scene}-{self.seed}" + ("-built" if self.build else "")


@dataclass
class Outcome:
    """What became of a case."""

    case: str
    ok: bool
    what: str
    cycles: int = 0
    rays: int = 0
    seconds: float = 0.0
    details: list = field(default_factory=list)


# ---- what to run -----------------------------------------------------------------------------------------------------------


def _lights(name, count):
    """The scene's own light and `count - 1` dimmer ones beside it."""
    loaded = scene.load_scene(name)
    first = scene.default_lights(loaded)[0]
    step = 0.07 * np.ptp(loaded.bounds, axis=0).max()
    places = [
        np.asarray(first.position) - (step * (i % 4), 0.3 * step * (i // 4), step * (i % 3)) for i in range(count)
    ]
    colour = tuple(c / count for c in first.colour)
    return [replace(first, position=tuple(map(float, p)), colour=colour, directional=False) for p in places]


def frame_cases(level, seed):
    """Frames of a level: "quick", "normal" or "full"."""
    rng = np.random.default_rng(seed)
    memory = sim.Memory()

    def cases(name, view, *memories):
        return [FrameCase(name, view, m) for m in memories or (memory,)]

    out = cases("tiny", View(40, 24), memory, replace(memory, latency=1), replace(memory, latency=400))
    out += cases("tiny", View(37, 19), replace(memory, latency=17, backpressure=0.4, seed=int(rng.integers(1000))))
    out += cases("nasty", View(64, 48))
    out += cases("tiny_glass", View(48, 32, max_depth=5), memory, replace(memory, latency=400))
    out += cases("carousel", View(40, 24, max_depth=3), replace(memory, latency=100))  # dynamic objects
    out += cases("dice", View(40, 24, max_depth=4), replace(memory, latency=100))  # placed ones
    out += _built_cases(level, np.random.default_rng([seed, 1]))
    if level == "quick":
        return out
    for depth in (0, 1, DEEPEST):
        pauses = replace(memory, latency=int(rng.integers(1, 401)), backpressure=0.3, seed=int(rng.integers(1000)))
        out += cases("tiny_glass", View(41, 30, max_depth=depth, min_weight=0.0), memory, pauses)
    out += cases("tiny_glass", View(48, 32, max_depth=5, trilinear=True), memory, replace(memory, width=256, latency=7))
    out += cases("tiny_glass", View(48, 32, max_depth=5, lights=_lights("tiny_glass", 16)))
    out += cases("mirror_box", View(48, 32, max_depth=DEEPEST))
    for name in ("kitchen", "room", "living_room", "glass", "cards"):
        out += cases(name, View(96, 56, max_depth=10), memory, replace(memory, latency=int(rng.integers(1, 401)),
                     backpressure=0.2, seed=int(rng.integers(1000))))  # fmt: skip
    out += cases("tiny", View(1, 1)) + cases("tiny", View(7, 65)) + cases("tiny", View(33, 33, fb_format=RGB10A2))
    out += cases("tiny", View(40, 24, shadows=False)) + cases("tiny", View(40, 24, lights=_lights("tiny", 16)))
    out += cases("tiny", View(40, 24), *(replace(memory, width=w) for w in (128, 256)))
    out += cases("tiny", View(40, 24), replace(memory, outstanding=1, latency=30))
    for name in ("hall", "still_life", "organic"):
        out += cases(name, View(96, 56), *(replace(memory, latency=n) for n in (1, 60, 400)))
        for pause in (0.1, 0.5):
            pauses = replace(
                memory, latency=int(rng.integers(1, 401)), backpressure=pause, seed=int(rng.integers(1000))
            )
            out += cases(name, View(96, 56), pauses)
    out += cases("hall", View(160, 96), memory, replace(memory, width=128, backpressure=0.2))
    if level == "full":
        for name in ("kitchen", "room", "living_room", "glass", "cards", "mirror_box"):
            out += cases(name, View(320, 192, max_depth=10), *(replace(memory, width=w) for w in sim.MEM_WIDTHS))
            out += cases(name, View(320, 192, max_depth=0)) + cases(name, View(200, 120, max_depth=DEEPEST, trilinear=True))
        for name in ("hall", "still_life", "organic", "nasty"):
            out += cases(name, View(320, 192), *(replace(memory, width=w) for w in sim.MEM_WIDTHS))
            out += cases(name, View(800, 480)) + cases(name, View(800, 480, shadows=False))
            for _ in range(20):
                view = View(
                    int(rng.integers(1, 200)), int(rng.integers(1, 120)), lights=_lights(name, int(rng.integers(1, 17)))
                )
                pauses = replace(
                    memory,
                    width=int(rng.choice(sim.MEM_WIDTHS)),
                    latency=int(rng.integers(1, 401)),
                    backpressure=float(rng.choice([0.0, 0.05, 0.3, 0.8])),
                    outstanding=int(rng.choice([1, 2, 16])),
                    seed=int(rng.integers(1000)),
                )
                out += cases(name, view, pauses)
    return out


def _built_cases(level, rng):
    """Frames whose tree the RTL builds."""
    names = ("tiny", "nasty")
    if level != "quick":
        names = ("tiny", "tiny_glass", "nasty", "glass_room", "gloss", "chess", "pendulum", "dice", "carousel")
    rounds = {"quick": 1, "normal": 2, "full": 10}[level]
    out = []
    for n, name in enumerate(names):
        view = View(48, 32, max_depth=4) if level != "full" else View(160, 96, max_depth=6)
        for i in range(rounds):
            memory = sim.Memory(
                latency=int(rng.integers(1, 401)) if i else 60,
                backpressure=float(rng.choice([0.1, 0.4])) if i else 0.0,
                seed=int(rng.integers(1000)),
            )
            out.append(FrameCase(name, view, memory, True, (n + i) % 2 == 1))
    return out


def fault_cases(level, seed):
    """Broken frames of a level."""
    count = {"quick": 20, "normal": 200, "full": 2000}[level]
    scenes = ("tiny", "tiny_glass", "tiny_glass", "nasty")
    plain = [FaultCase(seed + i, scenes[i % len(scenes)]) for i in range(count)]
    moving = [FaultCase(seed + i, ("pendulum", "dice")[i % 2]) for i in range(count // 10)]  # with dynamic objects
    return plain + [FaultCase(seed + i, ("tiny_glass", "nasty")[i % 2], True) for i in range(count // 4)] + moving


# ---- running it ------------------------------------------------------------------------------------------------------------


class Images:
    """Geometry, images and reference frames, each made once. Not for several threads at a time."""

    def __init__(self):
        self._geometry, self._image, self._frame, self._clean, self._unbuilt = {}, {}, {}, {}, {}

    def unbuilt(self, name):
        """The geometry of a scene whose tree the RTL is to build."""
        if name not in self._unbuilt:
            self._unbuilt[name] = build_geometry(scene.load_scene(name), in_hardware=True)
        return self._unbuilt[name]

    def image(self, name, view):
        """The memory image of a scene."""
        if name not in self._geometry:
            loaded = scene.load_scene(name)  # with dynamic objects as the tree-building unit has it: a tree for each
            self._geometry[name] = build_geometry(loaded, None if loaded.objects is None else tbu.Params())
        key = (name, repr(view))
        if key not in self._image:
            self._image[key] = build_image(self._geometry[name], view)
        return self._image[key]

    def reference(self, name, view):
        """The reference frame of it."""
        from raycore.model.frame import render_fp24

        key = (name, repr(view))
        if key not in self._frame:
            self._frame[key] = render_fp24(self.image(name, view))
        return self._frame[key]

    def to_spoil(self, case):
        """The image of a `FaultCase`, and counters of its frame without a fault."""
        key = (case.scene, case.build, case.records)
        if key not in self._clean:
            if case.build:
                geometry = self.unbuilt(case.scene)
                image = build_image(geometry, FAULT_VIEW, room=tbu.sizes(len(geometry.info)), records=case.records)
            else:
                image = self.image(case.scene, FAULT_VIEW)
            stats = sim.run_frame(image.memory, image.registers, control=_control(image), progress=False).stats
            self._clean[key] = image, stats
        return self._clean[key]


def _control(image):
    """What is written to CTRL for an image."""
    return sim.RENDER | sim.BUILD_TREE * (image.room is not None) | sim.RECORDS * image.records


def run_frame(case, image, reference):
    """Run a `FrameCase`. Returns: `Outcome`."""
    began = time.perf_counter()
    result = sim.run_frame(image.memory, image.registers, memory=case.memory, hits=True, progress=False)
    exact = check.compare_rtl(result, reference)
    what = "same" if exact.same else f"{exact.pixels} pixels, {exact.hits} hits, {len(exact.counters)} counters differ"
    details = exact.examples + [f"{c}: RTL {a}, reference {b}" for c, (a, b) in exact.counters.items()]
    cycles = result.stats["counters"]["CYCLES"]
    return Outcome(case.name, exact.same, what, cycles, exact.rays, time.perf_counter() - began, details)


_REFERENCE = threading.Lock()  # the reference is compiled code that runs once at a time


def run_built(case, geometry):
    """Run a `FrameCase` whose tree the RTL builds; the tree is compared too. Returns: `Outcome`."""
    began = time.perf_counter()
    frame = dynamic.render_frame(
        geometry, case.view, case.memory, hits=True, keep_memory=True, records=case.records, progress=False
    )
    with _REFERENCE:
        found = dynamic.check_frame(frame)
    exact = found.exact
    what = "same, tree too" if found.same else f"{exact.pixels} pixels, {exact.hits} hits, {len(exact.counters)} counters differ"
    details = exact.examples + [f"{c}: RTL {a}, reference {b}" for c, (a, b) in exact.counters.items()]
    details += [f"tree: {found.difference}"] if found.difference else []
    details += [f"differs {found.records}"] if found.records else []
    cycles = frame.result.stats["counters"]["CYCLES"]
    return Outcome(case.name, found.same, what, cycles, exact.rays, time.perf_counter() - began, details)


def _some_region(image, rng):
    """A region that a frame of this image reads."""
    if image.room is not None and rng.random() < 0.7:
        # Nodes and lists are written before they are read, and so may records be.
        return "attributes" if image.records and rng.random() < 0.3 else "vertices"
    names = [n for n in FLIPPED if image.regions.get(n, (0, 0))[1] > image.regions.get(n, (0, 0))[0]]
    often = np.array([FLIPPED[n] for n in names], float)
    return names[rng.choice(len(names), p=often / often.sum())]


def spoil(case, image, clean):
    """Put a fault into a frame.

    Args: case `FaultCase`; image `image.Image`; clean: statistics of a run without a fault.
    Returns: (memory, faults for `sim.run_frame`, memory model, expected error codes or None, what was done).
    """
    rng = np.random.default_rng([case.seed, zlib.crc32(case.scene.encode()), int(case.build)][: 3 if case.build else 2])
    memory = image.memory.copy()
    model = sim.Memory(
        latency=int(rng.choice([1, 60, 200])),
        backpressure=float(rng.choice([0.0, 0.3])),
        seed=int(rng.integers(1 << 30)),
    )
    if rng.random() < 0.25:
        kind, code = (("slverr", ERR_SLVERR), ("decerr", ERR_DECERR))[rng.integers(2)]
        bursts, writes = clean["axi"]["read_bursts"], clean["axi"]["write_bursts"]
        where = rng.integers(3)
        if where == 0:
            # Up to half of a clean run's bursts: a cache may need fewer when answers come in another rhythm.
            option, value, sure = f"{kind}-at", int(rng.integers(1, max(bursts // 2, 2))), True
        elif where == 1:
            option, value, sure = f"{kind}-write-at", int(rng.integers(1, writes + 1)), True
        else:
            region = _some_region(image, rng)
            low, high = image.regions[region]
            option, value, sure = f"{kind}-addr", int(rng.integers(low // 64, high // 64)) * 64, False
        return memory, [(option, value)], model, (code,) if sure else None, f"{option} {value:#x}"
    region = _some_region(image, rng)
    low, high = image.regions[region]
    flips = int(2 ** rng.uniform(0, 9))
    at = rng.integers(0, (high - low) * 8, flips)
    np.bitwise_xor.at(memory, low + at // 8, (1 << (at % 8)).astype(np.uint8))
    return memory, [], model, None, f"{flips} bits of {region}"


def run_fault(case, image, clean):
    """Run a `FaultCase`. Returns: `Outcome`."""
    began = time.perf_counter()
    memory, faults, model, expected, done = spoil(case, image, clean)
    try:
        result = sim.run_frame(
            memory,
            image.registers,
            memory=model,
            faults=faults,
            control=_control(image),
            progress=False,
            max_cycles=FAULT_CYCLES,
        )
        what, code, cycles = "done", 0, result.stats["counters"]["CYCLES"]
    except sim.FrameError as error:
        what, code, cycles = f"error {error.code}", error.code, error.stats.get("counters", {}).get("CYCLES", 0)
    except RayCoreError as error:
        return Outcome(case.name, False, "FAILED", 0, 0, time.perf_counter() - began, [f"{done}: {error}"])
    ok = expected is None or code in expected
    details = [] if ok else [f"{done}: expected error {expected[0]}, the frame ended with {what}"]
    return Outcome(case.name, ok, what, cycles, 0, time.perf_counter() - began, details)


UNIT_TESTS = {
    # folder of tests: {variable: value at "normal", at "full"}
    "tb/rc_fp": {"RAYCORE_FP_PAIRS": ("1e7", "1e8")},
    "tb/rc_tni": {"TNI_RAYS": ("6000", "60000")},
    **{f"tb/{unit}": {"RAYCORE_ALL_BUILDS": ("1", "1")} for unit in ("rc_raygen", "rc_shade", "rc_secondary", "rc_texture")},
}


def run_units(level, folder):
    """Run a unit's random tests with many operands. Returns: `Outcome`."""
    began = time.perf_counter()
    env = os.environ | {name: values[level == "full"] for name, values in UNIT_TESTS[folder].items()}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", folder], cwd=REPO, env=env, capture_output=True, text=True
    )
    lines = [line for line in done.stdout.splitlines() if line.strip()] or done.stderr.splitlines() or ["no output"]
    what = " ".join(f"{k}={v}" for k, v in env.items() if k in UNIT_TESTS[folder])
    details = [] if done.returncode == 0 else lines[-20:]
    return Outcome(f"units/{folder}", done.returncode == 0, what, 0, 0, time.perf_counter() - began, details)


def run_all(level, seed, only="", jobs=2, console=None):
    """Run the regression. Returns: list of `Outcome`, in the order of the cases."""
    console = console or Console()
    frames = [c for c in frame_cases(level, seed) if only in c.name]
    faults = [c for c in fault_cases(level, seed) if only in c.name]
    units = [] if level == "quick" else [f for f in UNIT_TESTS if only in f"units/{f}"]
    console.print(f"seed {seed}: {len(frames)} frames, {len(faults)} broken frames, {len(units)} units")
    images, outcomes = Images(), {}
    for width in sorted({c.memory.width for c in frames if not c.build} | ({64} if faults else set())):
        sim.build(mem_width=width)
    if any(c.build for c in (*frames, *faults)):
        sim.build(tbu=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as progress, ThreadPoolExecutor(jobs) as pool:

        def collect(text, work):
            """Run (function, arguments) pairs in the pool."""
            task = progress.add_task(text, total=len(work))
            futures = {pool.submit(_guard, *w): i for i, w in enumerate(work)}
            for future in as_completed(futures):
                outcome = future.result()
                outcomes[outcome.case] = outcome
                if not outcome.ok:
                    progress.console.print(f"FAILED {outcome.case}: {outcome.what}", markup=False)
                    for line in outcome.details:
                        progress.console.print(f"  {line}", markup=False)
                progress.advance(task)
                if not console.is_terminal and (work[0][0] is not run_fault or len(outcomes) % 50 == 0):
                    console.print(
                        f"{time.strftime('%H:%M:%S')} {len(outcomes)} done, {outcome.case}: {outcome.what}",
                        markup=False,
                    )

        if frames:
            with_reference = []
            task = progress.add_task("references", total=len(frames))
            for case in frames:
                if case.build:
                    with_reference.append((run_built, case, images.unbuilt(case.scene)))
                    progress.advance(task)
                    continue
                image = images.image(case.scene, case.view)
                with_reference.append((run_frame, case, image, images.reference(case.scene, case.view)))
                progress.advance(task)
            collect("frames", with_reference)
        if faults:
            collect(
                "faults",
                [(run_fault, c, *images.to_spoil(c)) for c in faults],
            )
        for folder in units:
            collect(folder, [(run_units, level, folder)])
    order = [c.name for c in (*frames, *faults)] + [f"units/{f}" for f in units]
    return [outcomes[name] for name in order]


def _guard(run, *arguments):
    """A case that raises has failed; the others go on."""
    try:
        return run(*arguments)
    except Exception as error:
        name = getattr(arguments[0], "name", str(arguments[-1]))
        return Outcome(name, False, type(error).__name__, details=[" ".join(str(error).split())])


def report(outcomes, console):
    """Print the closing tables. Returns: number of failures."""
    table = Table(box=None, pad_edge=False)
    for name, align in (
        ("case", "left"),
        ("rays", "right"),
        ("cycles", "right"),
        ("seconds", "right"),
        ("result", "left"),
    ):
        table.add_column(name, justify=align, no_wrap=name == "case")
    faults = [o for o in outcomes if o.case.startswith("fault/")]
    for o in outcomes:
        if o not in faults:
            table.add_row(
                o.case, f"{o.rays:,}" if o.rays else "", f"{o.cycles:,}" if o.cycles else "", f"{o.seconds:.1f}", o.what
            )
    console.print(table)
    if faults:
        ends = sorted({o.what for o in faults})
        counts = ", ".join(f"{sum(o.what == e for o in faults)} {e}" for e in ends)
        console.print(f"{len(faults)} broken frames ended: {counts}", markup=False)
    failed = [o for o in outcomes if not o.ok]
    for o in failed:
        console.print(f"FAILED {o.case}: {o.what}", markup=False)
    console.print(f"{len(outcomes) - len(failed)} passed, {len(failed)} failed")
    return len(failed)


def main(arguments=None):
    """Command line. Returns: exit code."""
    parser = argparse.ArgumentParser(prog="python -m raycore.regress", description=__doc__.splitlines()[0])
    level = parser.add_mutually_exclusive_group()
    level.add_argument("--quick", dest="level", action="store_const", const="quick", help="a minute")
    level.add_argument("--full", dest="level", action="store_const", const="full", help="hours")
    parser.add_argument("--seed", type=int, default=1, help="of sizes, pauses and faults (1)")
    parser.add_argument("--only", default="", metavar="NAME", help="cases whose name contains NAME")
    parser.add_argument("--jobs", type=int, default=2, help="simulations at a time (2)")
    parser.add_argument("--no-units", action="store_true", help="frames and faults only")
    options = parser.parse_args(arguments)
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    if options.no_units:
        UNIT_TESTS.clear()
    try:
        outcomes = run_all(options.level or "normal", options.seed, options.only, max(options.jobs, 1), console)
    except RayCoreError as error:
        print(f"raycore.regress: {error}", file=sys.stderr)
        return 1
    if not outcomes:
        print(f"raycore.regress: no case has '{options.only}' in its name", file=sys.stderr)
        return 2
    return 1 if report(outcomes, console) else 0


if __name__ == "__main__":
    sys.exit(main())
