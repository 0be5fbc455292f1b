# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""From a scene and a view to what the hardware is given: bytes in memory and values of registers.

The layouts here and in `objects` are those of `rtl/rc_pkg.sv` (node_t, list_entry_t, triaccel_t, inst_t, inst_row_t, place_t,
tri_info_t, light_t, material_t, optics_t, tri_uv_t), lowest bit first; tests/test_image.py reads that file and fails where the
two part. docs/seams.md says what the records mean.
"""

import math
import time
from dataclasses import dataclass, field, replace

import numpy as np

from raycore import accel, kdtree, regs, tbu, texture, triaccel
from raycore.errors import OptionError, SceneError
from raycore.model import fp24, pixbuf, rgen
from raycore.objects import (
    INSTANCE,
    INSTANCE_ROW,
    INSTANCE_WORDS,
    PLACE,
    Objects,
    Room,
    by_model,
    instance_fields,
    place_fields,
    plan_objects,
    stored,
)
from raycore.scene import Camera, Light, Normalised, Scene, default_camera, default_lights, normalise

WORD_BITS = 60  # used bits of a 64-bit word in memory
ALIGN = 64  # bases and ends of regions
FIRST_ADDRESS = 0x1000  # so that a stray zero address lies in no region
TILE = pixbuf.TILE * pixbuf.BLOCK  # pixels a side of a tile
MAX_LIGHTS = 16
MAX_MATERIALS = 256
MAX_SHININESS = 1024.0
MAX_DEPTH, DEFAULT_DEPTH = 15, 4  # bounces; the default of a scene that has something to bounce at
MIN_WEIGHT = 1.0 / 256.0  # default: rays that weigh no more are not traced
ALPHA_MODES = ("opaque", "mask", "blend")  # alpha_e
MAX_SIDE, MAX_PIXELS = 16384, 1 << 26
BOX_MARGIN = 2.0**-10  # the scene's box is enlarged by this much before it is rounded
SLACK_GROWTH, MAX_SLACK = 1.5, 64.0  # see edge_slack
FAR = 2.0**20  # no eye and no lamp may be further off, in half sizes of the scene

NODE = (("split", 24), ("axis", 2), ("swap", 1), ("lower_empty", 1), ("upper_empty", 1), ("other", 24), ("zero", 7))
LIST_ENTRY = (("tri_idx", 24), ("last", 1), ("opaque", 1))
TRIACCEL = (
    *(("n_u", 24), ("n_v", 24), ("eps_m", 4), ("eps_e", 5), ("k", 2), ("opaque", 1)),
    *(("a_u", 24), ("a_v", 24), ("mat", 12)),
    *(("a_k", 24), ("b_u", 24), ("b_v_lo", 12)),
    *(("g_u", 24), ("g_v", 24), ("b_v_hi", 12)),
)
TRI_INFO = (
    *(("a_x", 24), ("a_y", 24), ("mat", 12)),
    *(("a_z", 24), ("n_x", 24), ("zero1", 12)),
    *(("n_y", 24), ("n_z", 24), ("zero2", 12)),
    *(("n0_x", 24), ("n0_y", 24), ("zero3", 12)),
    *(("n0_z", 24), ("e1_x", 24), ("zero4", 12)),
    *(("e1_y", 24), ("e1_z", 24), ("zero5", 12)),
    *(("e2_x", 24), ("e2_y", 24), ("zero6", 12)),
    *(("e2_z", 24), ("zero7", 36)),
)
LIGHT = (
    *(("pos_x", 24), ("pos_y", 24), ("directional", 1), ("zero0", 11)),
    *(("pos_z", 24), ("col_r", 24), ("zero1", 12)),
    *(("col_g", 24), ("col_b", 24), ("zero2", 12)),
    *(("att_c", 24), ("att_l", 24), ("zero3", 12)),
    *(("att_q", 24), ("zero4", 36), ("zero5", 60), ("zero6", 120)),
)
MATERIAL = (
    *(("amb_r", 24), ("amb_g", 24)),
    *(("textured", 1), ("alpha_mode", 2), ("reflects", 1), ("transmits", 1), ("fresnel", 1), ("tex_kr", 1), ("zero", 5)),
    *(("amb_b", 24), ("diff_r", 24), ("zero1", 12)),
    *(("diff_g", 24), ("diff_b", 24), ("zero2", 12)),
    *(("spec_r", 24), ("spec_g", 24), ("zero3", 12)),
    *(("spec_b", 24), ("emis_r", 24), ("zero4", 12)),
    *(("emis_g", 24), ("emis_b", 24), ("zero5", 12)),
    *(("shin", 24), ("alpha", 24), ("zero6", 12)),
    *(("cutoff", 24), ("zero7", 36)),
)
OPTICS = (
    *(("kr_r", 24), ("kr_g", 24), ("zero0", 12)),
    *(("kr_b", 24), ("kt_r", 24), ("zero1", 12)),
    *(("kt_g", 24), ("kt_b", 24), ("zero2", 12)),
    *(("ior", 24), ("inv_ior", 24), ("zero3", 12)),
    *(("tex_base", 26), ("log2_w", 4), ("log2_h", 4), ("levels", 4)),
    *(("wrap_s", 2), ("wrap_t", 2), ("rgba5551", 1), ("srgb", 1), ("zero4", 16), ("zero5", 180)),
)
TRI_UV = texture.TRI_UV

# Columns of the arrays that raycore.model works on, in its order, as fields of the records.
INFO_COLUMNS = tuple(f"{v}_{c}" for v in ("a", "n", "n0", "e1", "e2") for c in "xyz")
LIGHT_COLUMNS = ("directional", "pos_x", "pos_y", "pos_z", "col_r", "col_g", "col_b", "att_c", "att_l", "att_q")
MATERIAL_COLUMNS = (
    *(f"{v}_{c}" for v in ("amb", "diff", "spec", "emis") for c in "rgb"),
    *("shin", "alpha", "cutoff"),
    *(f"{v}_{c}" for v in ("kr", "kt") for c in "rgb"),
    *("ior", "inv_ior", "textured", "alpha_mode", "reflects", "transmits", "fresnel", "tex_kr"),
)
UV_COLUMNS = ("u0", "v0", "du1", "dv1", "du2", "dv2", "mip")
TEXTURE_COLUMNS = texture.DESCRIPTOR_COLUMNS


# ---- records ---------------------------------------------------------------------------------------------------------


def places(layout):
    """Where the fields of a layout lie: {name: (word, lowest bit in the word, width)}; unused bits are left out."""
    out, at = {}, 0
    for name, width in layout:
        if not name.startswith("zero"):
            out[name] = (at // WORD_BITS, at % WORD_BITS, width)
            if at % WORD_BITS + width > WORD_BITS:
                raise ValueError(f"field {name} does not lie in one word")
        at += width
    return out


def pack_records(layout, fields):
    """Records as words in memory.

    Args: layout, e.g. `TRI_INFO`; fields: {name: (N,) unsigned integers}; fields not named are 0.
    Returns: (N, words) uint64.
    Raises: ValueError if a value does not fit its field, KeyError for a field that is not in the layout.
    """
    where = places(layout)
    count = len(next(iter(fields.values())))
    words = np.zeros((count, -(-sum(w for _, w in layout) // WORD_BITS)), np.uint64)
    for name, values in fields.items():
        word, low, width = where[name]
        values = np.asarray(values).astype(np.uint64)
        if values.size and int(values.max()) >> width:
            raise ValueError(f"{name}: {int(values.max())} does not fit in {width} bits")
        words[:, word] |= values << np.uint64(low)
    return words


def unpack_records(layout, words):
    """Inverse of `pack_records`: {name: (N,) uint64}."""
    return {
        name: words[:, word] >> np.uint64(low) & np.uint64((1 << width) - 1)
        for name, (word, low, width) in places(layout).items()
    }


def _columns(layout, words, names):
    """The named fields of records as (N, len(names)) float64, of FP24 patterns or small integers."""
    fields, width = unpack_records(layout, words), dict(layout)
    columns = [fp24.from_bits(fields[n]) if width[n] == 24 else fields[n].astype(np.float64) for n in names]
    return np.ascontiguousarray(np.stack(columns, axis=1))


def _pack_columns(layout, names, table, **more):
    width = dict(layout)
    fields = {n: fp24.to_bits(v.copy()) if width[n] == 24 else v for n, v in zip(names, np.asarray(table).T)}
    return pack_records(layout, fields | more)


# ---- geometry: what does not depend on the view ------------------------------------------------------------------------


@dataclass
class Geometry:
    """A scene made ready: normalised mesh, tree, and the records of its triangles.

    kept: with dynamic objects the scene as memory holds it (`objects.stored`); otherwise `scene` itself. unit and all records
    follow its triangles, N of them; `in_scene` leads from their numbers to those of the scene.
    """

    scene: Scene
    unit: Normalised
    tree: kdtree.Tree
    info: np.ndarray  # (N, 8) uint64
    materials: np.ndarray  # (M, 16) uint64
    uv: np.ndarray  # (N, 4) uint64; (0, 4) if nothing is textured
    textures: np.ndarray  # (B, 8) uint64, blocks of 64 bytes
    opaque: np.ndarray  # (N,) bool, of the triangles' materials
    notes: list  # one line for each thing that had to be changed
    seconds: dict  # of each step
    objects: Objects | None = None  # dynamic ones with trees of their own; then `tree` holds all of the trees
    roots: list | None = None  # of the instances, if the trees are there
    kept: Scene | None = None

    def __post_init__(self):
        self.kept = self.kept or self.scene

    @property
    def rows(self):
        """Number in memory of each triangle of the scene: (triangles,) int64."""
        out = np.arange(len(self.scene.triangles))
        if self.objects is None:
            return out
        return np.searchsorted(self.objects.numbers, out - self.objects.offsets[self.scene.objects])

    def in_scene(self, tri, inst):
        """Triangles of the scene from integers of those in memory, in placed objects inst; -1, none, stays."""
        if self.objects is None:
            return tri
        return np.where(tri < 0, tri, self.objects.numbers[tri] + self.objects.offsets[inst])


def material_table(materials, textured=True):
    """Materials as (M, 29) float64, columns `MATERIAL_COLUMNS`, not rounded; textured: whether textures are used."""
    table = [
        (
            *(*m.ambient, *m.diffuse, *m.specular, *m.emission, m.shininess, m.alpha, m.alpha_cutoff),
            *(*m.reflect, *m.transmit, m.ior, 1.0 / m.ior if m.ior else math.inf),
            *(textured and m.texture is not None, ALPHA_MODES.index(m.alpha_mode)),
            *(any(m.reflect), any(m.transmit), m.fresnel, m.tint_reflection),
        )
        for m in materials
    ]
    return np.array(table, dtype=np.float64).reshape(-1, len(MATERIAL_COLUMNS))


def check_material(material, where):
    """Refuse what the hardware cannot shade. Raises: SceneError."""
    m = material
    what = f"{where}: material {m.name}:"
    if m.alpha_mode not in ALPHA_MODES:
        raise SceneError(f"{what} alpha mode '{m.alpha_mode}' is none of {', '.join(ALPHA_MODES)}")
    for name in ("ambient", "diffuse", "specular", "emission", "reflect", "transmit"):
        colour = np.asarray(getattr(m, name), dtype=np.float64)
        if colour.shape != (3,) or not np.isfinite(fp24.round_to_fp24(colour)).all() or (colour < 0.0).any():
            raise SceneError(f"{what} {name} colour {tuple(colour.tolist())} is not three numbers from 0 to 2^63")
    if not 0.0 <= m.shininess <= MAX_SHININESS:
        raise SceneError(f"{what} shininess {m.shininess:g} is not a number from 0 to {MAX_SHININESS:g}")
    for name in ("alpha", "alpha_cutoff"):
        if not 0.0 <= getattr(m, name) <= 1.0:
            raise SceneError(f"{what} {name} {getattr(m, name):g} is not a number from 0 to 1")
    if not 1.0 / 64.0 <= m.ior <= 64.0:
        raise SceneError(f"{what} ior {m.ior:g} is not a number from 1/64 to 64")
    if any(m.transmit) and m.alpha_mode != "opaque":
        raise SceneError(f"{what} it transmits and has alpha mode {m.alpha_mode}; only one of both is possible")


def _textures(scene, unit):
    """What texturing needs: fields of the materials' textures or None, coordinate records (N, 4), blocks (B, 8), notes."""
    used = list(dict.fromkeys(m.texture for m in scene.materials if m.texture is not None))
    if not used or scene.uv is None:
        notes = ["its textures are not used: it has no texture coordinates"] if used else []
        return None, np.zeros((0, 4), np.uint64), np.zeros((0, 8), np.uint64), notes
    if np.shape(scene.uv) != scene.triangles.shape[:2] + (2,):
        raise SceneError(f"{scene.name}: texture coordinates of shape {np.shape(scene.uv)}, not one pair a corner")
    try:
        region, table, notes = texture.build_textures(used)
    except ValueError as error:
        raise SceneError(f"{scene.name}: {error}") from None
    rows = np.zeros((len(scene.materials), table.shape[1]), np.int64)
    for row, material in zip(rows, scene.materials):
        if material.texture is not None:
            row[:] = table[used.index(material.texture)]
    fields = dict(zip(TEXTURE_COLUMNS, rows.T))
    sizes = np.stack((1 << fields["log2_w"], 1 << fields["log2_h"]), axis=1)[scene.face_material]
    wraps = np.stack((fields["wrap_s"], fields["wrap_t"]), axis=1)[scene.face_material]
    uv = pack_records(TRI_UV, texture.uv_records(scene.uv, unit.triangles, sizes, wraps))
    return fields, uv, region.view("<u8").reshape(-1, 8), notes


def _materials(scene, textures):
    """Both blocks of the material records: (M, 16) uint64. textures: fields of the texture of each material, or None."""
    for material in scene.materials:
        check_material(material, scene.name)
    table = fp24.round_to_fp24(material_table(scene.materials, textures is not None))
    column = dict(zip(MATERIAL_COLUMNS, table.T))
    for flag, v in (("reflects", "kr"), ("transmits", "kt")):  # of what the records hold
        column[flag][:] = np.any([column[f"{v}_{c}"] != 0.0 for c in "rgb"], axis=0)
    width = dict(MATERIAL + OPTICS)
    fields = {n: fp24.to_bits(v.copy()) if width[n] == 24 else v for n, v in column.items()}
    own = {n for n, _ in MATERIAL}
    optics = {n: v for n, v in fields.items() if n not in own} | (textures or {})
    material = {n: v for n, v in fields.items() if n in own}
    return np.concatenate((pack_records(MATERIAL, material), pack_records(OPTICS, optics)), axis=1)


def _opaque(materials):
    """(M,) bool of material records: whether nothing passes, so that a hit ends a shadow ray."""
    fields = unpack_records(MATERIAL, materials)
    return (fields["alpha_mode"] == ALPHA_MODES.index("opaque")) & (fields["transmits"] == 0)


def build_geometry(scene, params=None, in_hardware=False):
    """Normalise a scene, build its tree and its records.

    Args: scene `Scene`; params `kdtree.Params`, or `tbu.Params` for the tree that the tree-building unit makes;
        in_hardware: leave the tree to the unit, which builds it in the frame (`build_image` with `room`).
    A scene's dynamic objects get trees of their own where the unit builds, else there is one tree over everything.
    Returns: `Geometry`. Triangles without area keep their index and a record that never hits.
    Raises: SceneError if it does not fit the hardware.
    """
    if len(scene.materials) > MAX_MATERIALS:
        raise SceneError(f"{scene.name}: {len(scene.materials)} materials, at most {MAX_MATERIALS} fit; merge some")
    began = time.perf_counter()
    by_unit = in_hardware or isinstance(params, tbu.Params)
    dynamic = by_unit and scene.objects is not None
    build_tree = tbu.no_tree if in_hardware or dynamic else tbu.build_tree
    unit = tbu.snap(scene) if by_unit else normalise(scene)
    kept, kept_unit, places, numbers = stored(scene, unit) if dynamic else (scene, unit, [], None)
    normalised = time.perf_counter()
    tree = build_tree(unit, params) if by_unit else kdtree.build(unit.triangles, unit.dropped, params)
    built = time.perf_counter()
    fields, uv, blocks, notes = _textures(kept, kept_unit)
    textured = time.perf_counter()
    materials = _materials(scene, fields)
    opaque = _opaque(materials)[kept.face_material]
    tree.lists = kdtree.opaque_lists(tree.lists, opaque)
    things, roots = (plan_objects(scene, unit, kept_unit, places, numbers, opaque) if dynamic else None), None
    if dynamic and not in_hardware:
        nodes, lists, roots = by_model(things, tree.params)
        tree = replace(tree, nodes=nodes, lists=lists, root=things.static.root)
    make_info = accel.triangle_info if by_unit else triaccel.triangle_info
    info = make_info(kept_unit if by_unit else unit.triangles, kept.normals)
    columns = np.concatenate((info.vertex, info.normal, info.n0, info.dn1, info.dn2), axis=1)
    info_words = _pack_columns(TRI_INFO, INFO_COLUMNS, columns, mat=kept.face_material)
    return Geometry(
        scene,
        kept_unit,
        tree,
        info_words,
        materials,
        uv,
        blocks,
        opaque,
        notes,
        {
            "normalise": normalised - began,
            "tree": built - normalised,
            "textures": textured - built,
            "records": time.perf_counter() - textured,
        },
        things,
        roots,
        kept,
    )


# ---- the view ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class View:
    """One picture of a scene, in world units. camera, lights, max_depth: None takes the file's own or a sensible default."""

    width: int = 320
    height: int = 192
    camera: Camera | None = None
    lights: list[Light] | None = None
    shadows: bool = True
    fb_format: int = pixbuf.RGBA8
    max_depth: int | None = None  # bounces; None: what the scene asks for, see default_depth
    min_weight: float = MIN_WEIGHT
    trilinear: bool = False
    max_slots: int = 65535


def complete_view(scene, view):
    """The view with its defaults filled in. Raises: OptionError if it makes no sense."""
    width, height = view.width, view.height
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE and width * height <= MAX_PIXELS):
        raise OptionError(
            f"picture size {width}x{height}: give 1x1 to {MAX_SIDE}x{MAX_SIDE}, at most {MAX_PIXELS >> 20} Mpixel"
        )
    camera = view.camera or default_camera(scene, width / height)
    rgen.camera_vectors(camera.eye, camera.target, camera.up, camera.fov, width, height)  # refuses what is no view
    lights = list(default_lights(scene, camera) if view.lights is None else view.lights)
    if len(lights) > MAX_LIGHTS:
        raise OptionError(f"{len(lights)} lights, at most {MAX_LIGHTS} fit; leave some out")
    depth = default_depth(scene) if view.max_depth is None else view.max_depth
    if not 0 <= depth <= MAX_DEPTH:
        raise OptionError(f"depth {depth}: give 0 to {MAX_DEPTH} bounces")
    if not 0.0 <= view.min_weight < 1.0:
        raise OptionError(f"least weight {view.min_weight:g}: give a number from 0 to less than 1")
    return replace(view, camera=camera, lights=lights, max_depth=depth)


def default_depth(scene):
    """Bounces where nothing is said: the scene's own, else 4 if a triangle of it is a mirror or lets light through, else 0."""
    if scene.depth is not None:
        return scene.depth
    used = [scene.materials[i] for i in np.unique(scene.face_material)]
    return DEFAULT_DEPTH if any(any(m.reflect) or not m.opaque for m in used) else 0


def light_table(lights, unit):
    """Lights in the unit box as (L, 10) float64, columns `LIGHT_COLUMNS`, not rounded.

    Attenuation is in normalised distance: world distance = distance * 2^scale_exp.
    Raises: OptionError for a light that 24-bit numbers cannot hold.
    """
    table = np.zeros((len(lights), len(LIGHT_COLUMNS)))
    for row, light in zip(table, lights):
        position = np.asarray(light.position, dtype=np.float64)
        if light.directional:
            length = np.linalg.norm(position)
            if not 0.0 < length < math.inf:
                raise OptionError("a directional light needs a direction that is not zero")
            row[1:4] = position / length
        else:
            row[1:4] = unit.to_unit(position)
            if not np.all(np.abs(row[1:4]) <= FAR):
                where = ",".join(f"{p:g}" for p in position)
                raise OptionError(f"light {where}: more than {FAR:.0f} times the scene's size away; bring it nearer")
        row[0] = light.directional
        row[4:7] = light.colour
        c, l, q = light.attenuation
        row[7:10] = c, l * 2.0**unit.scale_exp, q * 4.0**unit.scale_exp
    if not np.isfinite(fp24.round_to_fp24(table)).all():
        raise OptionError("a light's colour or attenuation is too large for 24-bit numbers")
    return table


def camera_arguments(camera, unit, width, height):
    """Arguments of `rgen.camera_vectors` for a camera in world units."""
    eye, target = unit.to_unit(camera.eye), unit.to_unit(camera.target)
    if not (np.all(np.abs(eye) <= FAR) and np.all(np.isfinite(target))):
        where = ",".join(f"{p:g}" for p in camera.eye)
        raise OptionError(f"camera {where}: more than {FAR:.0f} times the scene's size away; bring it nearer")
    return eye, target, camera.up, camera.fov, width, height


def edge_slack(eye, bounds, triangles):
    """Distances (N,) by which the edges of triangles (N, 3, 3) are moved outwards, for an eye in the unit box's coordinates.

    The error of a hit's distance t is about 2^-17 t, and on a steep triangle it moves the hit point across an edge. So the
    slack that an eye amid the scene needs (2^-17) grows with the distance from which a scene is looked at, and for
    triangles that are further than a half size from the eye with theirs. Figures: docs/cli.md, Edge slack.
    """
    outside = np.linalg.norm(np.maximum(np.maximum(bounds[0] - eye, eye - bounds[1]), 0.0))
    far = np.linalg.norm(triangles.mean(axis=1) - eye, axis=1) - 1.0
    return triaccel.EDGE_SLACK * np.minimum(1.0 + SLACK_GROWTH * np.maximum(outside, far), MAX_SLACK)


# ---- the image ---------------------------------------------------------------------------------------------------------


@dataclass
class Image:
    """Everything that a frame needs.

    memory: uint8 by address, from 0 to the end of the textures; the frame buffer follows it.
    registers: {name of raycore.regs: value}, what the host writes before CTRL.
    regions: {name: (lo, hi)} byte addresses, hi exclusive, what a frame may touch; "frame" is written, and nodes, lists
        and working memory where the tree is built.
    room: for the tree if the frame builds it, in which case nodes and lists hold nothing yet; of a scene with dynamic
        objects for all their trees, beside the static one.
    records: whether the frame makes the records, in which case TriAccel and triangle information hold nothing yet, with
        dynamic objects nothing of those that are built.
    slack: mean of `edge_slack`.
    """

    geometry: Geometry
    view: View
    memory: np.ndarray
    registers: dict
    regions: dict = field(default_factory=dict)
    slack: float = triaccel.EDGE_SLACK
    room: tbu.Sizes | Room | None = None
    records: bool = False

    @property
    def sizes(self):
        """{region: bytes}."""
        return {name: hi - lo for name, (lo, hi) in self.regions.items()}


def _builder_registers(geometry, regions, room):
    """What the tree builder is told: values of registers."""
    box = tbu.references(geometry.unit).box
    q = {f"TBU_{side}_{axis}": int(box[i][j]) for i, side in enumerate(("LO", "HI")) for j, axis in enumerate("XYZ")}
    return q | {
        "NODE_COUNT": room.nodes,
        "NODE_ROOT": 0,
        "LIST_COUNT": room.entries,
        "VERTEX_BASE": regions["vertices"][0],
        "REF_BASE": regions["working"][0],
        "REF_COUNT": room.refs,
        "TBU_REFINE": geometry.tree.params.refine_max,
    }


def pack_instances(roots, things):
    """Records of the top-level tree and the objects: (K, 32) uint64. roots: of all of them; things: `objects.Objects`."""
    words = np.zeros((len(things.boxes), INSTANCE_WORDS), np.uint64)
    first = len(words) - len(things.places)  # placed object
    boxes = pack_records(INSTANCE, instance_fields(roots, things.boxes, np.arange(len(words)) >= first))
    words[:, : boxes.shape[1]] = boxes
    if things.places:
        rotation, origin = np.stack([p.rotation for p in things.places]), np.stack([p.origin for p in things.places])
        *rows, place = place_fields(rotation, origin, roots[first:])
        parts = (boxes[first:], *(pack_records(INSTANCE_ROW, row) for row in rows), pack_records(PLACE, place))
        whole = np.concatenate(parts, axis=1)
        words[first:, : whole.shape[1]] = whole
    return words


def _snapped_records(geometry, eye):
    """TriAccel records of a snapped geometry, and their edge slack. eye (3,), in the unit box.

    Edge slack grows with the distance of the eye, which stands elsewhere for each object that shares a shape: a triangle gets
    the greatest slack that one of them needs.
    """
    unit, things = geometry.unit, geometry.objects
    view = accel.slack(eye, geometry.tree.bounds)
    rec, _, slack = accel.records(unit, view)
    vertices = accel.grid(unit)
    for shape in things.shapes if things is not None else ():
        mine = slice(shape.first, shape.last)
        eyes = [(eye - p.origin) @ p.rotation for p in things.places if p.shape is shape]
        views = [replace(accel.slack(e, geometry.tree.bounds), least=view.least) for e in eyes]
        factors = np.stack([accel.model.slack_factors(vertices[mine], v) for v in views])
        for i in np.unique(most := factors.argmax(axis=0)):
            these = np.arange(shape.first, shape.last)[most == i]
            part, _, slack[these] = accel.records(replace(unit, triangles=unit.triangles[these]), views[i])
            rec.eps_code[these] = part.eps_code
    return rec, slack


def _trees(geometry, room):
    """Nodes and lists as they lie in memory before the frame."""
    tree, things = geometry.tree, geometry.objects
    if room is None:
        return tree.nodes.astype("<u8"), tree.lists.astype("<u4")
    nodes, lists = np.zeros(room.nodes, "<u8"), np.zeros(room.entries, "<u4")
    if things is not None:
        nodes[: things.nodes.size] = things.nodes
        lists[: things.lists.size] = things.lists
    return nodes, lists


def build_image(scene, view=None, params=None, room=None, records=False):
    """Memory image and registers of one frame.

    Args: scene: `Scene`, or `Geometry` to use a tree again; view: `View`; params: of the tree, as in `build_geometry`;
        room: `tbu.Sizes`, with dynamic objects `objects.Room`, if the frame is to build the tree of a snapped geometry;
        records: the frame is to make the records of a snapped geometry from its vertices, with dynamic objects and `room`
            those of the triangles that are built.
    Returns: `Image`.
    Raises: SceneError, OptionError if scene or view do not fit the hardware.
    """
    geometry = scene if isinstance(scene, Geometry) else None
    view = complete_view(geometry.scene if geometry else scene, view or View())
    geometry = geometry or build_geometry(scene, params)
    unit, tree, scene, kept = geometry.unit, geometry.tree, geometry.scene, geometry.kept
    arguments = camera_arguments(view.camera, unit, view.width, view.height)
    lights = fp24.round_to_fp24(light_table(view.lights, unit))
    snapped = isinstance(tree.params, tbu.Params)
    if snapped:
        rec, slack = _snapped_records(geometry, arguments[0])
    else:
        slack = edge_slack(arguments[0], tree.bounds, unit.triangles)
        rec = triaccel.records(unit.triangles, unit.dropped, slack)
    words = triaccel.pack(rec, kept.face_material, geometry.opaque)
    things = geometry.objects
    nodes, lists = _trees(geometry, room)
    given = np.ones((len(words), 1), bool)
    if records:
        given[slice(None) if things is None else things.made] = False
    parts = {
        "nodes": nodes,
        "lists": lists,
        "triaccel": words.astype("<u8") * given,
        "info": geometry.info.astype("<u8") * given,
        "materials": geometry.materials.astype("<u8"),
        "lights": _pack_columns(LIGHT, LIGHT_COLUMNS, lights).astype("<u8"),
        "uv": geometry.uv.astype("<u8"),
        "textures": geometry.textures.astype("<u8"),
    }
    if things is not None:
        roots = geometry.roots or things.roots([0] * len(things.parts))  # those are known when they are built
        parts["instances"] = pack_instances(roots, things).astype("<u8")
    if room is not None or records:
        vertices = tbu.vertex_records(unit, geometry.opaque) if things is None else room.vertices()
        parts["vertices"] = vertices.astype("<u8")
    if records:
        attributes = accel.attribute_records(kept.normals, kept.face_material) if things is None else room.attributes(kept)
        parts["attributes"] = attributes.astype("<u8")
    if room is not None:
        parts["working"] = np.zeros(room.bytes["working"], np.uint8)
    stride = -(-4 * view.width // 32) * 32
    regions, at = {}, FIRST_ADDRESS
    for name, size in (*((n, p.nbytes) for n, p in parts.items()), ("frame", stride * view.height)):
        end = at + -(-size // ALIGN) * ALIGN
        regions[name] = (at, end)
        at = end
    if at > 1 << 32:
        raise SceneError(
            f"{scene.name}: needs {at >> 20} MB of memory, 32-bit addresses reach 4096 MB; simplify the mesh"
        )
    memory = np.zeros(regions["frame"][0], np.uint8)
    for name, part in parts.items():
        data = np.ascontiguousarray(part).reshape(-1).view(np.uint8)
        memory[regions[name][0] : regions[name][0] + data.size] = data

    registers = {
        "SIZE": regs.pack("SIZE", width=view.width, height=view.height),
        "FB_BASE": regions["frame"][0],
        "FB_STRIDE": stride,
        "FB_FORMAT": view.fb_format,
        "OPTIONS": regs.pack("OPTIONS", shadows=int(view.shadows), trilinear=int(view.trilinear)),
        "MAX_SLOTS": view.max_slots,
        "MAX_DEPTH": view.max_depth,
        "MIN_WEIGHT": int(fp24.to_bits(fp24.round_to_fp24(np.float64(view.min_weight)))),
        "MIP_BIAS": texture.mip_bias(view.camera.fov, view.height) & 0xFFF,
        "NODE_BASE": regions["nodes"][0],
        "NODE_COUNT": tree.nodes.size,
        "NODE_ROOT": tree.root,
        "LIST_BASE": regions["lists"][0],
        "LIST_COUNT": tree.lists.size,
        "ACCEL_BASE": regions["triaccel"][0],
        "TRI_COUNT": len(words),
        "INFO_BASE": regions["info"][0],
        "MAT_BASE": regions["materials"][0],
        "MAT_COUNT": len(scene.materials),
        "LIGHT_BASE": regions["lights"][0],
        "LIGHT_COUNT": len(view.lights),
        "UV_BASE": regions["uv"][0],
        "UV_COUNT": len(geometry.uv),
        "TEX_BASE": regions["textures"][0],
        "TEX_LINES": len(geometry.textures),
    }
    if things is not None:
        registers |= {
            "NODE_COUNT": nodes.size,
            "NODE_ROOT": things.static.root,
            "LIST_COUNT": lists.size,
            "INST_BASE": regions["instances"][0],
            "INST_COUNT": len(things.boxes),
        }
    elif room is not None:
        registers |= _builder_registers(geometry, regions, room)
    if records:
        seen_from = accel.slack(arguments[0], tree.bounds)
        eye = {f"ACCEL_EYE_{a}": e & 0xFFFF for a, e in zip("XYZ", seen_from.eye)}
        registers |= {"ATTR_BASE": regions["attributes"][0], "ACCEL_SLACK": seen_from.least} | eye
        registers["VERTEX_BASE"] = regions["vertices"][0]
    bounds = tree.bounds if things is None else things.static.bounds
    camera = rgen.camera_registers(*arguments)
    vectors = {
        "BACKGROUND_": dict(zip("RGB", scene.background)),
        "BOX_LO_": dict(zip("XYZ", bounds[0] - BOX_MARGIN)),
        "BOX_HI_": dict(zip("XYZ", bounds[1] + BOX_MARGIN)),
        **{f"CAM_{n.upper()}_": dict(zip("XYZ", getattr(camera, n))) for n in camera._fields},
    }
    for name, parts in vectors.items():
        registers |= {name + c: int(fp24.to_bits(fp24.round_to_fp24(np.float64(v)))) for c, v in parts.items()}
    return Image(geometry, view, memory, registers, regions, float(slack.mean()), room, records)


def tile_range(image, first, count):
    """Registers that limit a frame to a range of its tiles of 16x16 pixels, in raster order.

    Args: image `Image`; first: number of the first tile; count: how many.
    Returns: {register: value} to add to those of the image.
    Raises: OptionError if the picture does not have them.
    """
    columns, tiles = -(-image.view.width // TILE), tile_count(image.view)
    if not (0 <= first < tiles and 1 <= count <= tiles - first):
        raise OptionError(f"tiles {first} to {first + count - 1} are not in a picture of {tiles} tiles")
    y, x = divmod(first, columns)
    return {"TILE_FIRST": regs.pack("TILE_FIRST", x=x, y=y), "TILE_COUNT": count}


def tile_count(view):
    """Tiles of 16x16 pixels in a view's picture, those at its edges included."""
    return -(-view.width // TILE) * -(-view.height // TILE)


# ---- reading an image back -----------------------------------------------------------------------------------------------


def region_words(image, name, count, words):
    """The first `count` records of `words` 64-bit words of a region: (count, words) uint64."""
    base = image.regions[name][0]
    return image.memory[base : base + 8 * words * count].view("<u8").reshape(count, words)


def register_vector(image, prefix, axes="XYZ"):
    """Three FP24 registers as (3,) float64."""
    return fp24.from_bits(np.array([image.registers[prefix + a] for a in axes]))


def read_lights(image):
    """(L, 10) float64, columns `LIGHT_COLUMNS`."""
    return _columns(LIGHT, region_words(image, "lights", image.registers["LIGHT_COUNT"], 8), LIGHT_COLUMNS)


def read_materials(image):
    """(M, 29) float64, columns `MATERIAL_COLUMNS`."""
    words = region_words(image, "materials", image.registers["MAT_COUNT"], 16)
    own = [n for n in MATERIAL_COLUMNS if n in dict(MATERIAL)]
    optics = [n for n in MATERIAL_COLUMNS if n not in own]
    columns = dict(zip(own, _columns(MATERIAL, words[:, :8], own).T))
    columns |= dict(zip(optics, _columns(OPTICS, words[:, 8:], optics).T))
    return np.ascontiguousarray(np.stack([columns[n] for n in MATERIAL_COLUMNS], axis=1))


def read_optics_textures(image):
    """Textures of the materials: (M, 10) int64, columns `TEXTURE_COLUMNS` and two zeros; zeros if it has none."""
    fields = unpack_records(OPTICS, region_words(image, "materials", image.registers["MAT_COUNT"], 16)[:, 8:])
    columns = [fields[n].astype(np.int64) for n in TEXTURE_COLUMNS]
    return np.stack([*columns, *[np.zeros_like(columns[0])] * 2], axis=1)


def read_uv(image):
    """Texture coordinates: (N, 7) float64, columns `UV_COLUMNS`; mip in 1/64 levels. (0, 7) if nothing is textured."""
    out = _columns(TRI_UV, region_words(image, "uv", image.registers["UV_COUNT"], 4), UV_COLUMNS)
    out[:, 6] -= np.where(out[:, 6] >= 2048.0, 4096.0, 0.0)
    return out


def read_textures(image):
    """Texture blocks: (B, 8) uint64."""
    return region_words(image, "textures", image.registers["TEX_LINES"], 8)


def read_info(image):
    """Triangle information: (N, 5, 3) float64 in the order of `INFO_COLUMNS`, and (N,) int64 materials."""
    words = region_words(image, "info", image.registers["TRI_COUNT"], 8)
    mat = unpack_records(TRI_INFO, words)["mat"].astype(np.int64)
    return _columns(TRI_INFO, words, INFO_COLUMNS).reshape(-1, 5, 3), mat
