# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Pictures of a scene that moves: for each the RTL builds the tree anew and renders, in one frame of the hardware."""

import io
from dataclasses import dataclass

from raycore import dynamic, render, tbu
from raycore.errors import OptionError, SceneError
from raycore.image import build_geometry
from raycore.scene import load_scene

MAX_FRAMES = 10_000


@dataclass
class Frame:
    """One picture of a sequence. check: `dynamic.TreeCheck`, None if not asked for."""

    number: int
    time: float  # seconds
    rendered: render.Rendered
    values: dict  # `render.stats`
    check: dynamic.TreeCheck | None

    @property
    def row(self):
        """What the closing table says: text, by column of `COLUMNS`."""
        v, b = self.values, self.values["tbu"]
        return (
            str(self.number),
            f"{self.time:.3f}",
            f"{b['triangles']:,}",
            f"{b['cycles']:,}",
            "-" if b["cycles_per_triangle"] is None else f"{b['cycles_per_triangle']:.1f}",
            f"{v['render_cycles']:,}",
            f"{v['rays_per_cycle_per_rtu']:.4f}",
            *(() if self.check is None else ("same" if self.check.same else "DIFFERS",)),
        )


COLUMNS = ("frame", "seconds", "triangles", "build cycles", "a triangle", "render cycles", "rays per cycle", "check")


def times(name, frames, fps=None):
    """When the pictures are taken: spread over the scene's duration, its end left out, or 1 / fps apart from 0 on.

    Raises: OptionError, SceneError if nothing moves.
    """
    if not 1 <= frames <= MAX_FRAMES:
        raise OptionError(f"--frames {frames}: give 1 to {MAX_FRAMES}")
    if fps is not None and not 0.01 <= fps <= 1000.0:
        raise OptionError(f"--fps {fps:g}: give 0.01 to 1000 pictures a second")
    length = load_scene(name).duration
    if not length:
        raise SceneError(f"{name}: nothing moves in it; give a mesh of a scene file an animation (docs/scenes.md)")
    return [i / fps if fps else i * length / frames for i in range(frames)]


def take(name, number, time, view, memory=None, check=False, params=None, prepare=None, records=False):
    """One picture.

    Args: name: of the scene; number, time: of the picture, time in seconds; view: `image.View`; memory: `sim.Memory`;
        check: compare picture, hits and tree with the models; params: `tbu.Params`; prepare: changes the loaded scene;
        records: the RTL makes the records too.
    Returns: `Frame`. Raises: SceneError, SimError.
    """
    scene = load_scene(name, time)
    scene = prepare(scene) if prepare else scene
    geometry = build_geometry(scene, params or tbu.Params(), in_hardware=True)
    rendered = dynamic.render_frame(geometry, view, memory, hits=check, keep_memory=check, records=records)
    return Frame(number, time, rendered, render.stats(rendered), dynamic.check_frame(rendered) if check else None)


def summary(frames, checked):
    """STATS.json of a sequence: a row for each picture, and the mean of what matters."""
    rows = []
    for f in frames:
        v, b = f.values, f.values["tbu"]
        rows.append({
            "frame": f.number,
            "time": f.time,
            "triangles": b["triangles"],
            "build_cycles": b["cycles"],
            "build_cycles_per_triangle": b["cycles_per_triangle"],
            "build_bytes_per_triangle": b["bytes_per_triangle"],
            "record_cycles": v.get("records", {}).get("cycles"),
            "render_cycles": v["render_cycles"],
            "rays": v["rays"]["total"],
            "rays_per_cycle": v["rays_per_cycle_per_rtu"],
        } | ({"same": f.check.same, "tree_difference": f.check.difference} if checked else {}))  # fmt: skip
    means = ("build_cycles", "build_cycles_per_triangle", "render_cycles", "rays_per_cycle")
    return {
        "frames": rows,
        "mean": {n: None if rows[0][n] is None else sum(r[n] for r in rows) / len(rows) for n in means},
        "config": frames[0].values["config"],
    }


def moving_picture(pictures, seconds):
    """Pictures (H, W, 3) uint8 as an animated PNG that repeats. seconds: that each is shown."""
    from PIL import Image

    first, *rest = map(Image.fromarray, pictures)
    out = io.BytesIO()
    first.save(
        out, format="PNG", save_all=True, append_images=rest, duration=max(round(1000 * seconds), 1), loop=0, blend=0
    )
    return out.getvalue()
