# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""One picture by one of three engines, and what is known about it afterwards: statistics, hits, a summary."""

import platform
import re
import time
from dataclasses import asdict, dataclass

import numpy as np

from raycore import __version__, sim
from raycore.image import Image
from raycore.model import fp24, rgen
from raycore.toolchain import REPO

ENGINES = ("rtl", "model", "double")
PIPES = 4  # T&I pipelines of an RTU: slots a cycle
MODES = ("box", "trav1", "trav2", "isect", "miss_nt", "miss_list")  # what a slot with a ray was spent on
KINDS = ("primary", "shadow", "reflect", "transmit")  # of rays that are traced
LINE_BYTES, ROW_BYTES = 64, 32
BUILDER_COUNTERS = ("cycles", "nodes", "entries", "jumps", "jobs", "donations", "forced", "lines", "rows", "waits")
RECORD_BYTES = ("attributes", "triaccel_made", "info_made")  # regions as the harness names them
BUILDER_BYTES = ("vertices", "working", "nodes_built", "lists_built", "working_written", *RECORD_BYTES)


@dataclass
class Rendered:
    """A picture and how it came about."""

    engine: str
    image: Image
    pixels: np.ndarray  # (H, W) uint32, as in the frame buffer
    tri: np.ndarray  # (H, W) int64 triangle of the primary hit, -1: none
    t: np.ndarray  # (H, W) float64 its distance in the unit box, in lengths of the ray's direction
    memory: sim.Memory
    result: sim.SimResult | None = None  # of the RTL
    frame: object | None = None  # model.frame.Frame of the reference
    seconds: float = 0.0
    rtus: int = 1  # ray-tracing units


def _primary(result, view, geometry):
    """Triangles of the scene and distances of the primary rays from hit records."""
    tri, t = np.full((view.height, view.width), -1, np.int64), np.full((view.height, view.width), np.inf)
    rays = result.hits[(result.hits["kind"] == sim.RAY_KINDS.index("primary")) & (result.hits["hit"] == 1)]
    tri[rays["y"], rays["x"]] = geometry.in_scene(rays["tri"].astype(np.int64), rays["inst"])
    t[rays["y"], rays["x"]] = fp24.from_bits(rays["t"])
    return tri, t


def render(image, engine="rtl", memory=None, hits=False, jobs=1, **simulation):
    """Render an image.

    Args: image `image.Image`; engine: "rtl" (Verilator), "model" (bit-exact reference) or "double"; memory `sim.Memory`;
        hits: keep the hit records; jobs: parts to simulate side by side (`parts.run_frame`), by the RTL only; simulation: more
        arguments of `sim.run_frame`, but for `rtus` for one part only.
    Returns: `Rendered`; without hits the RTL leaves tri and t empty.
    Raises: SimError, and what `sim.run_frame` raises.
    """
    memory, began = memory or sim.Memory(), time.perf_counter()
    if engine == "rtl":
        if jobs > 1:
            from raycore import parts

            result = parts.run_frame(image, memory, hits, jobs, simulation.get("rtus", 1))
        else:
            result = sim.run_frame(image.memory, image.registers, memory=memory, hits=hits, **simulation)
        tri, t = _primary(result, image.view, image.geometry) if hits else (None, None)
        seconds, rtus = time.perf_counter() - began, simulation.get("rtus", 1)
        return Rendered(engine, image, result.frame, tri, t, memory, result, None, seconds, rtus)
    from raycore.model import frame as frames  # compiles for half a minute the first time

    frame = frames.render_fp24(image) if engine == "model" else frames.render_double(image)
    return Rendered(engine, image, frame.pixels, frame.tri, frame.t, memory, None, frame, time.perf_counter() - began)


# ---- statistics ----------------------------------------------------------------------------------------------------------


def rtl_parameters(rtus=1):
    """Cache geometry and pipelines, read from the RTL's own defaults."""

    def default(file, name):
        return int(re.search(rf"parameter int unsigned {name}\s*=\s*(\d+)", (REPO / "rtl" / file).read_text())[1])

    l1, l2 = default("mem/rc_l1.sv", "Ways"), default("tni/rc_tni.sv", "L2Ways")
    sets = {name: default("tni/rc_tni.sv", name) for name in ("NtSets", "ListSets", "L2Sets")}
    return {
        "rtus": rtus,
        "pipelines": default("tni/rc_tni.sv", "NumPipes"),
        "l1_node": {"sets": sets["NtSets"], "ways": l1, "line_bytes": LINE_BYTES, "each": "pipeline"},
        "l1_list": {"sets": sets["ListSets"], "ways": l1, "line_bytes": LINE_BYTES, "each": "pipeline"},
        "l2": {"sets": sets["L2Sets"], "ways": l2, "line_bytes": LINE_BYTES, "each": "rtu"},
        "triangle": {
            "sets": default("shade/rc_shade.sv", "InfoSets"),
            "ways": default("shade/rc_shade.sv", "InfoWays"),
            "line_bytes": LINE_BYTES,
            "each": "rtu",
        },
        "uv": {"sets": default("shade/rc_texture.sv", "UvSets"), "ways": 2, "line_bytes": LINE_BYTES, "each": "rtu"},
        "texture": {
            "banks": 4,
            "sets": default("shade/rc_texture.sv", "TexSets"),
            "ways": 2,
            "line_bytes": LINE_BYTES,
            "each": "rtu",
        },
    }


def config(rendered, **more):
    """Everything that decides the picture and the cycles."""
    view, geometry, memory = rendered.image.view, rendered.image.geometry, rendered.memory
    return {
        "scene": geometry.scene.name,
        "triangles": len(geometry.scene.triangles),
        "size": [view.width, view.height],
        "camera": asdict(view.camera),
        "lights": [asdict(light) for light in view.lights],
        "shadows": view.shadows,
        "max_depth": view.max_depth,
        "min_weight": view.min_weight,
        "trilinear": view.trilinear,
        "textures": len({m.texture for m in geometry.scene.materials if m.texture is not None}),
        "background": list(geometry.scene.background),
        "max_slots": view.max_slots,
        "memory": asdict(memory),
        "seed": memory.seed,
        "tree": asdict(geometry.tree.params),
        "edge_slack": rendered.image.slack,
        "rtus": rendered.rtus,
        "caches": rtl_parameters(rendered.rtus),
        "versions": {"raycore": __version__, "python": platform.python_version(), "numpy": np.__version__},
        **more,
    }


def _share(part, whole):
    return part / whole if whole else 0.0


def build_statistics(counters, triangles):
    """What a frame's counters say of the tree that it built: `tbu` of STATS.json, as docs/cli.md explains it.

    triangles: how many it built trees of; 0: of boxes only, where no figure a triangle is given.
    """
    own = {name: counters[f"TBU_{name.upper()}"] for name in BUILDER_COUNTERS}
    moved = LINE_BYTES * own["lines"] + ROW_BYTES * own["rows"]
    return {
        "triangles": triangles,
        "cycles": own["cycles"],
        "cycles_per_triangle": own["cycles"] / triangles if triangles else None,
        "bytes": moved,
        "bytes_per_triangle": moved / triangles if triangles else None,
        "root": counters["TBU_ROOT"],
        "counters": own,
    }


def record_statistics(cycles, moved, triangles):
    """What is known of records made in a frame: `records` of STATS.json, as docs/cli.md explains it.

    Args: cycles; moved: bytes; triangles: whose records they are; 0: there is nothing to make, and no figure a triangle.
    """
    return {
        "cycles": cycles,
        "cycles_per_triangle": cycles / triangles if triangles else None,
        "bytes": moved,
        "bytes_per_triangle": moved / triangles if triangles else None,
    }


def prepared(counters):
    """Cycles of a frame before its picture: until tree and records are there."""
    return max(counters["TBU_CYCLES"], counters["ACCEL_CYCLES"])


def stats(rendered, **more):
    """STATS.json of a picture, as docs/cli.md explains it; more: further entries of `config`."""
    image = rendered.image
    out = {"engine": rendered.engine}
    if rendered.result is not None:
        c = rendered.result.stats["counters"]
        cycles = c["CYCLES"]
        rays = {kind: c[f"RAYS_{kind.upper()}"] for kind in (*KINDS, "culled")}
        by_depth = rendered.result.stats.get("rays", {})
        slots = {mode: c[f"SLOTS_{mode.upper()}"] for mode in MODES}
    else:
        c, cycles, rays = {}, None, dict(rendered.frame.rays)
        by_depth = {k: np.trim_zeros(n, "b").tolist() or [0] for k, n in zip(KINDS, rendered.frame.by_depth)}
        slots = dict(zip(MODES, map(int, rendered.frame.slots))) if rendered.engine == "model" else {}
    traced, used = sum(rays[kind] for kind in KINDS), sum(slots.values())
    rays["total"] = traced
    out |= {"cycles": cycles, "rays": rays, "rays_by_depth": {k: list(by_depth.get(k, ())) for k in KINDS}}
    if image.room is not None:
        things = image.geometry.objects
        built = [len(image.geometry.info)] if things is None else [len(part.refs) for part in things.parts[:-1]]
        out["tbu"] = build_statistics(c, sum(built))
        if image.records:
            moved = rendered.result.stats["bytes"]
            made = sum(moved.get(n, 0) for n in RECORD_BYTES) + sum(LINE_BYTES * -(-n // 2) for n in built)  # vertices too
            out["records"] = record_statistics(c["ACCEL_CYCLES"], made, sum(built))
        out["render_cycles"] = cycles = cycles - rendered.result.stats.get("prepared", prepared(c))
    out["rays_per_cycle_per_rtu"] = _share(traced, rendered.rtus * cycles) if cycles else None
    out["slots_per_ray"] = _share(used, traced) if slots else None
    out["slots"] = slots | ({"bubble": c["SLOTS_BUBBLE"]} if c else {})
    out["occupancy"] = _share(used, rendered.rtus * PIPES * cycles) if cycles else None
    if c:
        pairs = {
            "l1_node": (c["NT_HITS"], c["SLOTS_MISS_NT"]),
            "l1_list": (c["LIST_HITS"], c["SLOTS_MISS_LIST"]),
            "l2": (c["L2_HITS"], c["L2_MISSES"]),
            "triangle": (c["TRI_HITS"], c["TRI_MISSES"]),
            "uv": (c["UV_HITS"], c["UV_MISSES"]),
            "texture": (c["TEX_HITS"], c["TEX_MISSES"]),
        }
        out["cache"] = {n: {"hits": h, "misses": m, "hit_rate": _share(h, h + m)} for n, (h, m) in pairs.items()}
        by_kind = dict(rendered.result.stats.get("bytes", {}))
        by_kind["total"] = sum(by_kind.values())
        out["bytes"] = by_kind
        tree = sum(by_kind.get(kind, 0) for kind in ("nodes", "lists", "triaccel"))
        texture = sum(by_kind.get(kind, 0) for kind in ("uv", "textures"))
        out["bytes_per_ray"] = {
            "tree": _share(tree, traced),
            "texture": _share(texture, traced),
            "total": _share(by_kind["total"] - sum(by_kind.get(kind, 0) for kind in BUILDER_BYTES), traced),
        }
        out["counters"] = c
        out["simulation"] = rendered.result.stats.get("sim", {})
        if "parts" in rendered.result.stats:
            out["parts"] = rendered.result.stats["parts"]
    out["seconds"] = {n: round(s, 3) for n, s in (image.geometry.seconds | {"render": rendered.seconds}).items()}
    out["config"] = config(rendered, **more)
    return out


def summary(values):
    """(what, figure) pairs that a person wants to see, from `stats`."""
    rays = values["rays"]
    named = {
        "primary": "primary",
        "shadow": "shadow",
        "reflect": "reflected",
        "transmit": "transmitted",
        "culled": "culled",
    }
    out = [("rays", ", ".join(f"{rays[kind]:,} {name}" for kind, name in named.items()))]
    deepest = max(len(depths) for depths in values["rays_by_depth"].values()) - 1
    if deepest > 0:
        levels = [sum(d[i] for d in values["rays_by_depth"].values() if i < len(d)) for i in range(deepest + 1)]
        out.append(("rays by depth", ", ".join(f"{n:,}" for n in levels)))
    if values["cycles"] is not None:
        parts = f", sum of {values['parts']} parts, caches cold in each" if "parts" in values else ""
        out.append(("cycles", f"{values['cycles']:,}{parts}"))
        if "tbu" in values:
            made = [("  of these to build the tree", "bytes to build the tree", values["tbu"])]
            if "records" in values:
                made.append(("cycles to make records, meanwhile", "bytes to make records", values["records"]))
            for cycles, moved, unit in made:
                for what, name, digits in ((cycles, "cycles", 1), (moved, "bytes", 0)):
                    each = unit[f"{name}_per_triangle"]  # None: only the top-level tree, over placed objects
                    out.append((what, f"{unit[name]:,}" + ("" if each is None else f", {each:.{digits}f} a triangle")))
        out.append(("rays per cycle per RTU", f"{values['rays_per_cycle_per_rtu']:.4f}"))
    if values["slots_per_ray"] is not None:
        out.append(("slots per ray", f"{values['slots_per_ray']:.2f}"))
    if values["cycles"] is not None:
        rate = {name: f"{cache['hit_rate']:.2%}" for name, cache in values["cache"].items()}
        out += [
            ("occupancy", f"{values['occupancy']:.2%}"),
            ("hit rate, L1 node and triangle", rate["l1_node"]),
            ("hit rate, L1 list", rate["l1_list"]),
            ("hit rate, L2", rate["l2"]),
            ("hit rate, triangle cache", rate["triangle"]),
            *(
                (f"hit rate, {name}", rate[cache])
                for cache, name in (("uv", "texture coordinates"), ("texture", "textures"))
                if values["cache"][cache]["hits"] + values["cache"][cache]["misses"]
            ),
            ("bytes per ray, tree", f"{values['bytes_per_ray']['tree']:.2f}"),
            ("bytes per ray, textures", f"{values['bytes_per_ray']['texture']:.2f}"),
            ("bytes per ray, all", f"{values['bytes_per_ray']['total']:.2f}"),
        ]
        speed = values["simulation"].get("cycles_per_second")
        if speed:
            out.append(("simulation", f"{speed / 1000:,.0f} kcycles/s"))
    return out


# ---- hits for others -------------------------------------------------------------------------------------------------------


def aov(rendered):
    """Arrays of the AOV file, world units: what the primary rays were and what they hit.

    Returns: tri (H, W) int32, -1: missed; t (H, W) float64 along the unit direction, infinite where missed; triangles
        (N, 3, 3) float64 as loaded; ray_origin, ray_dir (H, W, 3) float64, the rays that were traced, made unit length.
    """
    image = rendered.image
    view, unit = image.view, image.geometry.unit
    if rendered.frame is not None:
        org, direction = rendered.frame.org, rendered.frame.dir
    else:
        from raycore.image import register_vector

        camera = rgen.Camera(*(register_vector(image, f"CAM_{n.upper()}_") for n in rgen.Camera._fields))
        org, (direction, _) = camera.org, rgen.primary_rays(camera, view.width, view.height)
    length = np.linalg.norm(direction, axis=2)
    missed = rendered.tri < 0
    return {
        "tri": rendered.tri.astype(np.int32),
        "t": np.where(missed, np.inf, unit.length_to_world(np.where(missed, 0.0, rendered.t) * length)),
        "triangles": image.geometry.scene.triangles,
        "ray_origin": np.broadcast_to(unit.to_world(org), direction.shape).copy(),
        "ray_dir": direction / length[..., None],
    }
