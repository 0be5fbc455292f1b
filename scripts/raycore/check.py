# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Is a picture right? RTL against the reference, bit for bit; 24 bits against double precision; hits against Embree."""

from dataclasses import dataclass, field

import numpy as np

from raycore import sim
from raycore.model import fp24, pixbuf, rgen, tracer
from raycore.model.frame import REFLECT, SHADOW, TRANSMIT, Frame

# Targets of the project, shown beside what was measured.
PSNR_DB, AGREEMENT, HOLES_PPM = 38.0, 0.999, 25.0
PSNR_BOUNCED_DB = 36.0  # of pictures with mirrors, glass or alpha, where a difference may grow from bounce to bounce

NEAR = 2.0**-10  # two hits at distances this close, relative, count as one: shared edges, coincident triangles
STEADY = 0.01  # a surface is steady where five rays within 0.1 pixel hit it at distances this close, relative
SLOT_COUNTERS = ("SLOTS_BOX", "SLOTS_TRAV1", "SLOTS_TRAV2", "SLOTS_ISECT")
STEPS = "traversal steps"  # one of them in a slot or two: whether a second finds its half of the line depends on timing
RAY_COUNTERS = {kind: f"RAYS_{kind.upper()}" for kind in ("primary", "shadow", "culled", "reflect", "transmit")}
_EXAMPLES = 5


@dataclass
class Exact:
    """Where the RTL and the reference differ."""

    pixels: int = 0
    hits: int = 0
    rays: int = 0  # rays compared
    counters: dict = field(default_factory=dict)  # {counter: (RTL, reference)} where they differ
    examples: list = field(default_factory=list)

    @property
    def same(self):
        """Nothing differs."""
        return not (self.pixels or self.hits or self.counters)


def _bits(x):
    return fp24.to_bits(np.ascontiguousarray(x))


def expected_hits(frame):
    """Hit records of a reference frame as the harness writes them: (rays,) `sim.HIT_DTYPE`, pixels row by row.

    A pixel's rays are in the order in which they are issued, which is that in which they finish: it has one ray at a time.
    """
    out = np.zeros(len(frame.log), sim.HIT_DTYPE)
    pixel = np.repeat(np.arange(frame.tri.size), np.diff(frame.start))
    out["y"], out["x"] = np.divmod(pixel, frame.tri.shape[1])
    for name in ("kind", "light", "hit", "depth", "inst"):
        out[name] = frame.log[name]
    out["tri"] = np.where(frame.log["tri"] < 0, tracer.TRI_NONE, frame.log["tri"])
    for name in ("t", "beta", "gamma"):
        out[name] = _bits(frame.log[name].astype(np.float64))
    return out


def compare_rtl(result, frame):
    """Compare a simulation with the reference.

    Args: result: `sim.SimResult` with hits; frame: `frame.render_fp24` of the same image.
    Returns: `Exact`. A ray too many or too few is a mismatch; after a wrong ray those that follow from it are mismatches too.
    """
    exact = Exact()
    wrong = np.argwhere(result.frame != frame.pixels)
    exact.pixels = len(wrong)
    for y, x in wrong[:_EXAMPLES]:
        exact.examples.append(f"pixel {x},{y}: RTL {result.frame[y, x]:08x}, reference {frame.pixels[y, x]:08x}")

    want, got = expected_hits(frame), result.hits
    height, width = frame.tri.shape
    known = (got["x"] < width) & (got["y"] < height)
    got = got[known]
    pixel = got["y"].astype(np.int64) * width + got["x"]
    order = np.argsort(pixel, kind="stable")
    got, pixel = got[order], pixel[order]
    first = np.searchsorted(pixel, np.arange(height * width + 1))
    counts, expected = np.diff(first), np.diff(frame.start)
    place = np.arange(got.size) - first[pixel]  # of a ray among its pixel's
    paired = place < expected[pixel]
    ours, theirs = want[frame.start[pixel[paired]] + place[paired]], got[paired]
    shadow = ours["kind"] == SHADOW
    differs = {name: ours[name] != theirs[name] for name in ("kind", "depth", "hit")}
    differs["light"] = shadow & (ours["light"] != theirs["light"])
    # Where nothing was hit, distance and weights mean nothing; nor does the triangle of a shadow ray.
    for name in ("tri", "inst"):
        differs[name] = (ours[name] != theirs[name]) & ((ours["hit"] == 1) | ~shadow)
    for name in ("t", "beta", "gamma"):
        differs[name] = (ours[name] != theirs[name]) & (ours["hit"] == 1)
    bad = np.logical_or.reduce(list(differs.values()))
    exact.hits = int(np.count_nonzero(bad) + np.abs(counts - expected).sum() + np.count_nonzero(~known))
    exact.rays = want.size

    # The first wrong ray of a pixel tells most: of those with one, a few.
    wrong = np.flatnonzero(bad)
    where = pixel[paired][wrong]
    for i in wrong[np.unique(where, return_index=True)[1]][:_EXAMPLES]:
        names = [name for name in differs if differs[name][i]]
        exact.examples.append(f"{_ray_name(ours[i])}: RTL has another {', '.join(names)}")
    for p in np.setdiff1d(np.flatnonzero(counts != expected), where)[:_EXAMPLES]:
        exact.examples.append(f"pixel {p % width},{p // width}: RTL {counts[p]} rays, reference {expected[p]}")
    if not known.all():
        exact.examples.append(f"{np.count_nonzero(~known)} rays of pixels outside the picture")

    counters = result.stats.get("counters", {})
    reference = dict(zip(SLOT_COUNTERS, map(int, frame.slots)))
    for of in (reference, counters := dict(counters)):
        if "SLOTS_TRAV2" in of:
            of[STEPS] = of.pop("SLOTS_TRAV1") + 2 * of.pop("SLOTS_TRAV2")
    reference |= {counter: frame.rays[kind] for kind, counter in RAY_COUNTERS.items()}
    exact.counters = {c: (counters[c], n) for c, n in reference.items() if counters.get(c, n) != n}
    return exact


def _ray_name(ray):
    kind = "reflected" if ray["kind"] == REFLECT else "transmitted" if ray["kind"] == TRANSMIT else "primary"
    if ray["kind"] == SHADOW:
        kind = f"shadow ray to light {ray['light']}"
    else:
        kind += " ray"
    return f"{kind} at depth {ray['depth']} of pixel {ray['x']},{ray['y']}"


# ---- double precision ----------------------------------------------------------------------------------------------------


def channels(pixels, fb_format=pixbuf.RGBA8):
    """Pixels of the frame buffer as (H, W, 3) uint8 channels, 10 bits shortened to 8."""
    rgb = pixbuf.unpack(pixels, fb_format)
    return (rgb >> 2 if fb_format == pixbuf.RGB10A2 else rgb).astype(np.uint8)


def psnr(a, b):
    """Peak signal to noise ratio in dB of two pictures of 8-bit channels; infinite if they are equal."""
    error = np.mean((np.asarray(a, np.float64) - np.asarray(b, np.float64)) ** 2)
    return float("inf") if error == 0.0 else float(10.0 * np.log10(255.0**2 / error))


def same_rays(a, b):
    """Pixels whose rays meet the same things in two frames, in the same order: (H, W) bool.

    Which of several blockers ends a shadow ray depends on the order in which they are found and is no matter.
    """
    rays = np.diff(a.start)
    same = rays == np.diff(b.start)
    which = np.repeat(np.flatnonzero(same), rays[same])
    mine = [np.repeat(same, np.diff(f.start)) for f in (a, b)]
    one, other = (f.log[m] for f, m in zip((a, b), mine))
    differs = np.logical_or.reduce([one[name] != other[name] for name in ("kind", "light", "depth", "hit")])
    differs |= (a.log_tri[mine[0]] != b.log_tri[mine[1]]) & (one["kind"] != SHADOW)
    same[which[differs]] = False
    return same.reshape(a.tri.shape)


def _finite(decibels):
    return None if np.isinf(decibels) else round(decibels, 3)


def difference(a, b, gain=16):
    """Picture of where two pictures differ: absolute differences of channels, `gain` times as bright."""
    return np.minimum(np.abs(a.astype(np.int64) - b.astype(np.int64)) * gain, 255).astype(np.uint8)


# ---- Embree ----------------------------------------------------------------------------------------------------------------


class Embree:
    """Intel's Embree on the triangles of a scene as loaded, in the unit box (a shift and a power of two)."""

    def __init__(self, geometry):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        triangles = geometry.unit.to_unit(geometry.scene.triangles).astype(np.float32)
        self._scene = EmbreeScene()
        self._mesh = TriangleMesh(self._scene, np.ascontiguousarray(triangles))

    def trace(self, org, direction):
        """Nearest hits: triangle (-1: none) and distance, in lengths of the direction, of rays (..., 3) from org (3,)."""
        d = np.ascontiguousarray(direction.reshape(-1, 3), dtype=np.float32)
        o = np.ascontiguousarray(np.broadcast_to(org.astype(np.float32), d.shape))
        hits = self._scene.run(o, d, query="INTERSECT", output=True)
        tri = np.asarray(hits["primID"]).astype(np.int64)
        t = np.where(tri < 0, np.inf, np.asarray(hits["tfar"], np.float64))
        return tri.reshape(direction.shape[:-1]), t.reshape(direction.shape[:-1])


@dataclass
class Agreement:
    """Primary hits beside Embree's; fractions of all pixels."""

    same_triangle: float
    same_hit: float  # the same triangle, or another at the same distance, or both missed
    steady: float  # pixels where five rays within 0.1 pixel see one surface
    holes: int  # steady pixels where we miss, or hit something behind
    false: int  # steady pixels where we hit something in front
    disagree: np.ndarray  # (H, W) bool: not the same hit

    @property
    def holes_ppm(self):
        """Holes in a million pixels."""
        return 1e6 * self.holes / self.disagree.size


def compare_embree(image, frame, embree=None):
    """Compare the primary hits of a frame with Embree on the very same rays. Returns: `Agreement`."""
    embree = embree or Embree(image.geometry)
    tri, t = embree.trace(frame.org, frame.dir)
    ours = np.where(frame.tri < 0, np.inf, frame.t)
    both = (frame.tri >= 0) & (tri >= 0)
    near = np.abs(np.where(both, ours, 0.0) - np.where(both, t, 0.0)) <= NEAR * np.where(both, t, 0.0)
    near = (both & near) | ((frame.tri < 0) & (tri < 0))
    agree = (frame.tri == tri) | near

    camera = _camera(image)
    y, x = np.indices(frame.tri.shape)
    spread = [t]
    for dx, dy in ((-0.1, 0.0), (0.1, 0.0), (0.0, -0.1), (0.0, 0.1)):
        d = camera.c + (x + 0.5 + dx)[..., None] * camera.u + (y + 0.5 + dy)[..., None] * camera.v
        spread.append(embree.trace(frame.org, d / np.linalg.norm(d, axis=-1, keepdims=True))[1])
    nearest, farthest = np.minimum.reduce(spread), np.maximum.reduce(spread)
    surface = farthest <= nearest * (1.0 + STEADY)
    nothing = np.isinf(nearest)
    surface &= ~nothing
    holes = surface & (ours > farthest * (1.0 + STEADY))
    false = (surface & (ours < nearest * (1.0 - STEADY))) | (nothing & (frame.tri >= 0))
    return Agreement(
        same_triangle=float(np.mean(frame.tri == tri)),
        same_hit=float(np.mean(agree)),
        steady=float(np.mean(surface | nothing)),
        holes=int(np.count_nonzero(holes)),
        false=int(np.count_nonzero(false)),
        disagree=~agree,
    )


def _camera(image):
    from raycore.image import register_vector

    return rgen.Camera(*(register_vector(image, f"CAM_{n.upper()}_") for n in rgen.Camera._fields))


# ---- all of it -------------------------------------------------------------------------------------------------------------


@dataclass
class Report:
    """Everything that `--check` found out."""

    exact: Exact | None  # None: no RTL ran
    psnr: float  # where triangles coincide, double precision shows the reference's choice
    psnr_any: float  # it shows the one that it met
    coincident: int  # pixels where the two choices differ
    same: float  # pixels whose rays meet what those in double precision meet, of all
    psnr_same: float  # of these
    agreement: Agreement
    reference: Frame
    double: Frame
    picture: np.ndarray  # (H, W, 3) uint8, difference between 24 bits and double precision, amplified

    @property
    def ok(self):
        """The RTL computed what the reference computed."""
        return self.exact is None or self.exact.same

    def values(self):
        """For STATS.json."""
        out = {
            "psnr_db": _finite(self.psnr),
            "psnr_any_db": _finite(self.psnr_any),
            "coincident": self.coincident,
            "same_rays": {"pixels": self.same, "psnr_db": _finite(self.psnr_same)},
            "embree": {
                "same_triangle": self.agreement.same_triangle,
                "same_hit": self.agreement.same_hit,
                "steady": self.agreement.steady,
                "holes": self.agreement.holes,
                "holes_ppm": self.agreement.holes_ppm,
                "false": self.agreement.false,
            },
        }
        if self.exact is not None:
            out["rtl"] = {
                "pixel_mismatches": self.exact.pixels,
                "hit_mismatches": self.exact.hits,
                "rays_compared": self.exact.rays,
                "counter_mismatches": {c: {"rtl": a, "reference": b} for c, (a, b) in self.exact.counters.items()},
                "examples": self.exact.examples,
            }
        return out

    def rows(self):
        """(what, measured, target, fine) for people."""
        out, a = [], self.agreement
        bounced = self.reference.rays["reflect"] + self.reference.rays["transmit"] > 0
        target = PSNR_BOUNCED_DB if bounced else PSNR_DB
        if self.exact is not None:
            e = self.exact
            out += [
                ("pixels that differ from the reference", f"{e.pixels:,}", "0", e.pixels == 0),
                (f"hits that differ, of {e.rays:,} rays", f"{e.hits:,}", "0", e.hits == 0),
                ("counters that differ", ", ".join(e.counters) or "0", "0", not e.counters),
            ]
        return [
            *out,
            ("PSNR against double precision", f"{self.psnr:.1f} dB", f"≥ {target:g} dB", self.psnr >= target),
            (f"  with its own choice in {self.coincident:,} pixels of coincident triangles", f"{self.psnr_any:.1f} dB", "", True),
            (
                "  where all rays meet the same triangles",
                f"{self.psnr_same:.1f} dB, {self.same:.2%} of the picture",
                "",
                True,
            ),
            ("primary hits as Embree's", f"{a.same_hit:.4%}", f"≥ {AGREEMENT:.1%}", a.same_hit >= AGREEMENT),
            ("  of these on the same triangle", f"{a.same_triangle:.4%}", "", True),
            ("holes", f"{a.holes} ({a.holes_ppm:.0f} ppm)", f"≤ {HOLES_PPM:g} ppm", a.holes_ppm <= HOLES_PPM),
            ("hits in front of the surface", f"{a.false}", "", True),
        ]


def check(image, result=None, reference=None, exact=None):
    """Check a frame.

    Args: image `image.Image`; result `sim.SimResult` with hits, None: check the reference alone; reference
        `frame.render_fp24` of the image if it is there already; exact: `compare_rtl` of these two, likewise.
    Returns: `Report`.
    """
    from raycore.model import frame as frames

    reference = reference or frames.render_fp24(image)
    free, double = frames.render_double(image), frames.render_double(image, reference.tri)
    a, b, any_b = (channels(f.pixels, image.view.fb_format) for f in (reference, double, free))
    if exact is None and result is not None:
        exact = compare_rtl(result, reference)
    same = same_rays(reference, double)
    return Report(
        exact,
        psnr(a, b),
        psnr(a, any_b),
        int(np.count_nonzero(free.tri != double.tri)),
        float(np.mean(same)),
        psnr(a[same], b[same]) if same.any() else float("inf"),
        compare_embree(image, reference),
        reference,
        double,
        difference(a, b),
    )
