# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Where the slots of the T&I pipelines go: in all, by what they were spent on, and by pixel (docs/performance.md).

    rays per cycle = 4 pipelines x occupancy / slots per ray

Counters give the first, hit records the second: the harness notes for each ray how many slots it took, how many of them were
lost to misses and in how many two traversal steps were taken. So what has to add up can be checked: `Profile.check`.
"""

import io
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from raycore.errors import OptionError, RayCoreError
from raycore.render import MODES, PIPES

NAMES = {
    "box": "box of the scene",
    "trav1": "one traversal step",
    "trav2": "two traversal steps",
    "isect": "intersection",
    "miss_nt": "lost to L1 node/triangle misses",
    "miss_list": "lost to L1 list misses",
    "bubble": "no ray",
}
COLOURS = ("#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377", "#dddddd")  # of NAMES, in order
LOST = ("miss_nt", "miss_list")


@dataclass
class Profile:
    """Slots of one picture.

    slots: by NAMES, only those that the engine knows; rays: traced ones; cycles: of the picture, None by the model;
    per_pixel, lost_per_pixel: (H, W) int64, all rays of a pixel, misses included; steps_per_pixel: (H, W) int64 work without
    misses, a slot with two traversal steps as two: the same whatever the memory does.
    """

    slots: dict
    rays: int
    cycles: int | None
    per_pixel: np.ndarray
    lost_per_pixel: np.ndarray
    steps_per_pixel: np.ndarray
    rtus: int = 1

    @property
    def used(self):
        """Slots with a ray."""
        return sum(n for name, n in self.slots.items() if name != "bubble")

    @property
    def slots_per_ray(self):
        """What a ray takes, in slots."""
        return self.used / self.rays if self.rays else 0.0

    @property
    def occupancy(self):
        """Slots with a ray of all, None without cycles."""
        return self.used / (self.rtus * PIPES * self.cycles) if self.cycles else None

    def check(self, reference=None):
        """Raise RayCoreError unless the slots of all pixels are those that the counters counted, and the steps of every pixel those
        of reference, a `model.frame.Frame` of the same tree."""
        lost = sum(self.slots.get(name, 0) for name in LOST)
        for what, pixels, counted in (("slots", self.per_pixel, self.used), ("misses", self.lost_per_pixel, lost)):
            if pixels.sum() != counted:
                raise RayCoreError(f"--profile: the pixels have {pixels.sum():,} {what}, the counters {counted:,}")
        if reference is not None:
            wrong = np.argwhere(self.steps_per_pixel != reference.work.sum(axis=2))
            if len(wrong):
                y, x = wrong[0]
                raise RayCoreError(
                    f"--profile: {len(wrong)} pixels take other steps than the reference; the first, {x},{y}, "
                    f"{self.steps_per_pixel[y, x]} instead of {reference.work[y, x].sum()}"
                )

    def values(self):
        """`profile` of STATS.json."""
        whole = sum(self.slots.values())
        return {
            "slots": self.slots,
            "share": {name: n / whole if whole else 0.0 for name, n in self.slots.items()},
            "per_ray": {name: n / self.rays if self.rays else 0.0 for name, n in self.slots.items()},
            "slots_per_ray": self.slots_per_ray,
            "occupancy": self.occupancy,
            "pixel": {
                "mean": float(self.per_pixel.mean()),
                "median": float(np.median(self.per_pixel)),
                "p99": float(np.percentile(self.per_pixel, 99)),
                "max": int(self.per_pixel.max()),
                "lost_mean": float(self.lost_per_pixel.mean()),
            },
        }


def profile(rendered):
    """The slots of a picture.

    Args: rendered: `render.Rendered`, by the RTL with hit records, or by the model.
    Returns: `Profile`. Raises: OptionError if nothing is known of its slots.
    """
    view = rendered.image.view
    if rendered.engine == "model":
        f = rendered.frame
        slots = dict(zip(MODES, map(int, f.slots)))  # the model has no caches: nothing is lost, no slot is empty
        return Profile(
            slots, int(f.by_depth.sum()), None, f.work[..., 0], np.zeros(f.tri.shape, np.int64), f.work.sum(axis=2)
        )
    if rendered.result is None or not rendered.result.hits.size:
        raise OptionError("--profile: only the engines rtl and model have slots")
    c, hits = rendered.result.stats["counters"], rendered.result.hits
    cycles = c["CYCLES"] - (c["TBU_CYCLES"] if rendered.image.room is not None else 0)
    pixels = {name: np.zeros((view.height, view.width), np.int64) for name in ("slots", "lost", "twos")}
    for name, counts in pixels.items():
        np.add.at(counts, (hits["y"], hits["x"]), hits[name])
    slots = {name: c[f"SLOTS_{name.upper()}"] for name in NAMES}
    steps = pixels["slots"] - pixels["lost"] + pixels["twos"]
    return Profile(slots, hits.size, cycles, pixels["slots"], pixels["lost"], steps, rendered.rtus)


# ---- for people ------------------------------------------------------------------------------------------------------------


def table(found):
    """Table: what the slots were spent on."""
    whole = sum(found.slots.values())
    factors = f"{found.slots_per_ray:.2f} slots per ray"
    if found.cycles:
        pipes = found.rtus * PIPES
        speed = pipes * found.occupancy / found.slots_per_ray
        factors = f"{pipes} pipelines x {found.occupancy:.1%} occupancy / {factors} = {speed:.4f} rays per cycle"
    out = Table(title="Slots of the T&I pipelines", title_justify="left", caption=factors, caption_justify="left")
    for name in ("spent on", "slots", "share", "per ray"):
        out.add_column(name, justify="left" if name == "spent on" else "right")
    for name, n in found.slots.items():
        out.add_row(NAMES[name], f"{n:,}", f"{n / whole:.1%}", f"{n / found.rays:.2f}")
    out.add_section()
    out.add_row("all with a ray", f"{found.used:,}", f"{found.used / whole:.1%}", f"{found.slots_per_ray:.2f}")
    return out


def figure(width, height):
    """A matplotlib figure that needs no screen, and keeps no state."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    plot = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(plot)
    return plot


def png(plot):
    """A figure as PNG."""
    out = io.BytesIO()
    plot.savefig(out, format="png", dpi=110, metadata={"Software": None})
    return out.getvalue()


def bars(profiles):
    """PNG: slots per ray as stacked bars. profiles: {name: `Profile.values`}."""
    plot = figure(9, 1.6 + 0.55 * len(profiles))
    axes = plot.subplots()
    places = np.arange(len(profiles))
    left = np.zeros(len(profiles))
    for (name, text), colour in zip(NAMES.items(), COLOURS, strict=True):
        length = np.array([values["per_ray"].get(name, 0.0) for values in profiles.values()])
        if length.any():
            axes.barh(places, length, left=left, height=0.6, color=colour, label=text)
        left += length
    axes.set_yticks(places, list(profiles))
    axes.invert_yaxis()
    axes.set_xlabel("slots per ray")
    axes.spines[["top", "right"]].set_visible(False)
    plot.legend(loc="outside lower center", ncols=4, fontsize="small", frameon=False)
    return png(plot)


def heat_map(per_pixel, what="slots"):
    """PNG: slots of each pixel's rays, with a colour bar. The scale ends at the 99.5th percentile: few pixels would darken all."""
    top = max(float(np.percentile(per_pixel, 99.5)), 1.0)
    height, width = per_pixel.shape
    plot = figure(9, min(max(8.0 * height / width, 2.0), 12.0))
    axes = plot.subplots()
    shown = axes.imshow(per_pixel, cmap="inferno", vmin=0.0, vmax=top, interpolation="nearest")
    axes.set_axis_off()
    bar = plot.colorbar(shown, ax=axes, extend="max" if per_pixel.max() > top else "neither", shrink=0.9)
    bar.set_label(f"{what} of all rays of a pixel")
    return png(plot)
