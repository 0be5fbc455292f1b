# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The memory image: records as rc_pkg.sv lays them out, regions, registers, and what does not fit."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from raycore import image, kdtree, regs, tbu, texture, triaccel
from raycore.errors import OptionError, SceneError
from raycore.model import fp24, pixbuf, shade
from raycore.scene import Camera, Light, Material, Scene, Texture, face_normals, make_material

PACKAGE = (Path(__file__).resolve().parents[1] / "rtl/rc_pkg.sv").read_text()
TYPES = re.sub(r"//[^\n]*", "", PACKAGE)
STRUCTS = {
    "node_t": image.NODE,
    "list_entry_t": image.LIST_ENTRY,
    "triaccel_t": image.TRIACCEL,
    "tri_info_t": image.TRI_INFO,
    "light_t": image.LIGHT,
    "material_t": image.MATERIAL,
    "optics_t": image.OPTICS,
    "tri_uv_t": image.TRI_UV,
    "inst_t": image.INSTANCE,
    "inst_row_t": image.INSTANCE_ROW,
    "place_t": image.PLACE,
}


def make_scene(triangles, materials=None, **more):
    """A flat-shaded scene of triangles (N, 3, 3)."""
    triangles = np.asarray(triangles, dtype=np.float64)
    normals = np.repeat(face_normals(triangles)[:, None], 3, axis=1)
    materials = materials or [make_material("grey", (0.5, 0.5, 0.5))]
    return Scene("test", triangles, normals, np.zeros(len(triangles), np.int32), materials, **more)


def soup(rng, count):
    return 40.0 + 6.0 * (rng.uniform(-1, 1, (count, 1, 3)) + rng.normal(0, 0.2, (count, 3, 3)))


# ---- one source for the layouts ----------------------------------------------------------------------------------------


def struct_fields(name):
    """Fields of a packed struct in rc_pkg.sv, lowest bit first: ((name, width), ...)."""
    widths = {"fp_t": 24, "idx_t": constant("IDX_W"), "mat_t": constant("MAT_W"), "logic": 1, "mip_t": vector("mip_t")}
    widths["alpha_e"] = int(re.search(r"enum logic \[(\d+):0\] \{[^}]*\} alpha_e;", TYPES)[1]) + 1
    body = re.search(r"typedef struct packed \{([^}]*)\} " + name + ";", TYPES)[1]
    found = re.findall(r"(\w+)\s*(?:\[(\d+):0\])?\s+(\w+)\s*;", body)
    assert len(found) == body.count(";")
    fields = []
    for kind, high, field in reversed(found):
        if kind.endswith("_flags_t"):
            fields += struct_fields(kind)
        else:
            fields.append((field, int(high) + 1 if high else widths[kind]))
    return tuple(fields)


def vector(name):
    return int(re.search(rf"typedef logic (?:signed )?\[(\d+):0\]\s+{name};", TYPES)[1]) + 1


def enum_names(name, prefix):
    """Names of an enumeration in the order of their values, in lower case, without the prefix."""
    body = re.search(r"typedef enum logic \[\d+:0\] \{([^}]*)\} " + name + ";", TYPES)[1]
    pairs = sorted((int(v), n) for n, v in re.findall(rf"{prefix}(\w+)\s*=\s*\d+'d(\d+)", body))
    assert [v for v, _ in pairs] == list(range(len(pairs))) and len(pairs) == body.count("=")
    return tuple(n.lower() for _, n in pairs)


def constant(name):
    return int(re.search(rf"parameter int unsigned {name}\s*=\s*(\d+)", PACKAGE)[1])


@pytest.mark.parametrize("name", STRUCTS)
def test_layout_is_that_of_the_package(name):
    assert STRUCTS[name] == struct_fields(name)


def test_constants_are_those_of_the_package():
    assert image.WORD_BITS == constant("WORD_W")
    assert image.ALIGN == constant("LINE_B")
    assert image.MAX_LIGHTS == constant("MAX_LIGHTS")
    assert image.MAX_MATERIALS == constant("MAX_MATERIALS")
    assert image.MATERIAL_COLUMNS == shade.MATERIAL_COLUMNS
    assert image.ALPHA_MODES == enum_names("alpha_e", "ALPHA_") and list(texture.WRAPS) == list(enum_names("wrap_e", "WRAP_"))


@pytest.mark.parametrize("layout", STRUCTS.values())
def test_records_come_back(layout, seed):
    rng = np.random.default_rng(seed)
    fields = {n: rng.integers(0, 1 << w, 50, dtype=np.uint64) for n, w in layout if not n.startswith("zero")}
    words = image.pack_records(layout, fields)
    assert not (words >> np.uint64(60)).any()
    back = image.unpack_records(layout, words)
    assert all(np.array_equal(back[n], v) for n, v in fields.items())
    # Every field has bits of its own.
    ones = sum(
        int(image.pack_records(layout, {n: [(1 << w) - 1]}).sum()) for n, w in layout if not n.startswith("zero")
    )
    full = image.pack_records(layout, {n: [(1 << w) - 1] for n, w in layout if not n.startswith("zero")})
    assert ones == int(full.sum())


def test_field_that_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="mat: 4096 does not fit in 12 bits"):
        image.pack_records(image.TRI_INFO, {"mat": [4096]})


def test_triaccel_packer_follows_the_layout(seed):
    rng = np.random.default_rng(seed)
    tri = fp24.round_to_fp24(rng.uniform(-1, 1, (64, 3, 3)))
    rec = triaccel.records(tri)
    fields = image.unpack_records(image.TRIACCEL, triaccel.pack(rec, np.arange(64) + 100))
    assert np.array_equal(fields["mat"], np.arange(64) + 100)
    assert np.array_equal(fields["k"], rec.k)
    assert np.array_equal(fields["eps_e"] << np.uint64(4) | fields["eps_m"], rec.eps_code)
    assert fields["opaque"].all()
    for name, want in (("n_u", rec.n[:, 0]), ("n_v", rec.n[:, 1]), ("a_u", rec.a[:, 0]), ("a_v", rec.a[:, 1])):
        assert np.array_equal(fields[name], fp24.to_bits(want.copy())), name
    for name, want in (("a_k", rec.a[:, 2]), ("b_u", rec.b[:, 0]), ("g_u", rec.g[:, 0]), ("g_v", rec.g[:, 1])):
        assert np.array_equal(fields[name], fp24.to_bits(want.copy())), name
    assert np.array_equal(fields["b_v_lo"] | fields["b_v_hi"] << np.uint64(12), fp24.to_bits(rec.b[:, 1].copy()))


def test_nodes_and_lists_follow_the_layout(seed):
    tri = fp24.round_to_fp24(np.clip(soup(np.random.default_rng(seed), 200) / 6.0 - 6.7, -1, 1))
    tree = kdtree.build(tri, ~triaccel.has_area(tri))
    nodes = image.unpack_records(image.NODE, tree.nodes[:, None])
    walk = kdtree.walk(tree)
    inner = walk.axis < 3
    assert np.array_equal(nodes["axis"][walk.index], walk.axis)
    assert np.array_equal(fp24.from_bits(nodes["split"][walk.index][inner]), walk.split[inner])
    entries = image.unpack_records(image.LIST_ENTRY, tree.lists[:, None].astype(np.uint64))
    for row, members in walk.leaves:
        first, count = int(nodes["other"][walk.index[row]]), int(nodes["split"][walk.index[row]])
        assert count == len(members)
        if count > 1:
            assert np.array_equal(entries["tri_idx"][first : first + count], members)
            assert entries["last"][first : first + count].tolist() == [0] * (count - 1) + [1]


# ---- the image -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def mixed(seed):
    """A scene of several materials, with one triangle that has no area, and a view of it."""
    rng = np.random.default_rng(seed)
    triangles = soup(rng, 120)
    triangles[17] = triangles[17, 0]
    materials = [make_material(f"m{i}", rng.uniform(0, 1, 3), rng.uniform(0, 1, 3), 2.0**i) for i in range(5)]
    scene = make_scene(triangles, materials)
    scene.face_material[:] = np.arange(120) % 5
    lights = [
        Light((50.0, 60.0, 41.0), (1.0, 0.5, 0.25), attenuation=(1.0, 0.5, 0.125)),
        Light((0, 3, 4), directional=True),
    ]
    return image.build_image(scene, image.View(37, 21, lights=lights))


def test_regions_are_apart_aligned_and_registered(mixed):
    at = image.FIRST_ADDRESS
    for lo, hi in mixed.regions.values():
        assert lo == at and lo % 64 == 0 and hi % 64 == 0 and hi >= lo
        at = hi
    r = mixed.registers
    names = ("NODE_BASE", "LIST_BASE", "ACCEL_BASE", "INFO_BASE", "MAT_BASE", "LIGHT_BASE")
    names += ("UV_BASE", "TEX_BASE", "FB_BASE")
    assert [r[n] for n in names] == [lo for lo, _ in mixed.regions.values()]
    sizes = (8 * r["NODE_COUNT"], 4 * r["LIST_COUNT"], *(s * r["TRI_COUNT"] for s in (32, 64)))
    sizes += (128 * r["MAT_COUNT"], 64 * r["LIGHT_COUNT"], 32 * r["UV_COUNT"], 64 * r["TEX_LINES"], r["FB_STRIDE"] * 21)
    assert [-(-s // 64) * 64 for s in sizes] == list(mixed.sizes.values())
    assert r["FB_STRIDE"] % 32 == 0 and 0 <= r["FB_STRIDE"] - 4 * 37 < 32
    assert regs.unpack("SIZE", r["SIZE"]) == {"width": 37, "height": 21}
    assert mixed.memory.size == mixed.regions["frame"][0] and not mixed.memory[: image.FIRST_ADDRESS].any()


def test_every_set_up_register_has_a_value(mixed):
    settable = {
        n
        for n, f in regs.FIELDS.items()
        if any(a == "RW" for _, _, a in f.values()) and not n.startswith(("IRQ", "TILE"))  # all tiles after reset
    }
    settable -= {n for n in settable if n.startswith("INST_") or n.endswith("_FIRST")}  # for some frames, else 0
    builder = {n for n in settable if n.startswith(("TBU_", "VERTEX_", "REF_"))}
    unit = {n for n in settable if n.startswith(("ATTR_", "ACCEL_SLACK", "ACCEL_EYE_"))}
    assert set(mixed.registers) == settable - builder - unit
    geometry = image.build_geometry(mixed.geometry.scene, in_hardware=True)
    room = image.build_image(geometry, mixed.view, room=tbu.sizes(1))
    assert set(room.registers) == settable - unit
    made = image.build_image(geometry, mixed.view, records=True)
    assert set(made.registers) == settable - builder | {"VERTEX_BASE"}
    for name, value in mixed.registers.items():
        assert value == sum(v << regs.FIELDS[name][f][0] for f, v in regs.unpack(name, value).items()), name


def test_records_hold_the_scene(mixed):
    geometry = mixed.geometry
    info, mat = image.read_info(mixed)
    assert np.array_equal(mat, geometry.scene.face_material)
    assert np.array_equal(info[:, 0], geometry.unit.triangles[:, 0])
    keep = ~geometry.unit.dropped
    assert np.abs(info[keep, 1] - face_normals(geometry.unit.triangles)[keep]).max() < 2.0**-17
    words = image.region_words(mixed, "triaccel", 120, 4)
    assert np.flatnonzero(image.unpack_records(image.TRIACCEL, words)["k"] == 3).tolist() == [17]
    table = image.read_materials(mixed)
    assert np.array_equal(table[:, 12], 2.0 ** np.arange(5))
    assert np.abs(table[:, 3:6] - [m.diffuse for m in geometry.scene.materials]).max() < 2.0**-17


def test_the_box_holds_the_scene_with_a_margin(mixed):
    lo, hi = image.register_vector(mixed, "BOX_LO_"), image.register_vector(mixed, "BOX_HI_")
    v = mixed.geometry.unit.triangles[~mixed.geometry.unit.dropped]
    assert np.allclose(v.min(axis=(0, 1)) - lo, 2.0**-10, atol=2.0**-16)
    assert np.allclose(hi - v.max(axis=(0, 1)), 2.0**-10, atol=2.0**-16)


def test_light_in_the_unit_box_attenuates_as_in_the_world(mixed):
    point, sun = image.read_lights(mixed)
    unit, light = mixed.geometry.unit, mixed.view.lights[0]
    assert np.allclose(unit.to_world(point[1:4]), light.position, atol=1e-3)
    distance = 7.0
    c, l, q = light.attenuation
    near = unit.to_unit(light.position) - unit.to_unit(np.asarray(light.position) + (distance, 0, 0))
    d = np.linalg.norm(near)
    assert math.isclose(point[7] + point[8] * d + point[9] * d * d, c + l * distance + q * distance**2, rel_tol=1e-4)
    assert sun[0] == 1.0 and np.allclose(sun[1:4], (0.0, 0.6, 0.8), atol=2.0**-17)


OPTICS = {
    "ambient": (0.01, 0.02, 0.03),
    "diffuse": (0.11, 0.12, 0.13),
    "specular": (0.21, 0.22, 0.23),
    "emission": (3.1, 0.32, 0.33),
    "shininess": 77.7,
    "reflect": (0.41, 0.42, 0.43),
    "transmit": (0.51, 0.52, 0.53),
    "ior": 1.5,
    "fresnel": True,
    "alpha": 0.6,
    "alpha_cutoff": 0.7,
}


def test_material_records():
    """Every field of a material is where the model looks for it, in every combination of flags."""
    base = Material("all", **OPTICS)
    changes = [{}, {"reflect": (0, 0, 0)}, {"transmit": (0, 0, 0)}, {"fresnel": False}, {"tint_reflection": True}]
    changes += [{"transmit": (0, 0, 0), "alpha_mode": mode} for mode in ("mask", "blend")]
    materials = [replace(base, **c) for c in changes]
    triangles = soup(np.random.default_rng(1), 21)
    scene = make_scene(triangles, materials)
    scene.face_material[:] = np.arange(21) % 7
    table = image.read_materials(image.build_image(scene))
    assert table.shape == (7, 29)
    for row, m in zip(table, materials):
        assert np.array_equal(row, fp24.round_to_fp24(row))
        want = (*m.ambient, *m.diffuse, *m.specular, *m.emission, m.shininess, m.alpha, m.alpha_cutoff)
        want += (*m.reflect, *m.transmit, m.ior, 1.0 / m.ior)
        assert np.allclose(row[:23], want, rtol=2.0**-17, atol=0)
    # textured, alpha mode, reflects, transmits, fresnel, texture tints the reflection
    flags = [(0, 0, 1, 1, 1, 0), (0, 0, 0, 1, 1, 0), (0, 0, 1, 0, 1, 0), (0, 0, 1, 1, 0, 0), (0, 0, 1, 1, 1, 1)]
    flags += [(0, 1, 1, 0, 1, 0), (0, 2, 1, 0, 1, 0)]
    assert np.array_equal(table[:, 23:], flags)


def test_opaque_flags():
    """What ends a shadow ray is flagged in list entries and in triangle records alike."""
    clear, solid = make_material("clear", (1, 1, 1), transmit=(1, 1, 1)), make_material("solid", (1, 1, 1))
    mask = make_material("mask", (1, 1, 1), alpha_mode="mask")
    scene = make_scene(soup(np.random.default_rng(2), 300), [clear, solid, mask])
    scene.face_material[:] = np.arange(300) % 3
    built = image.build_image(scene)
    want = np.arange(300) % 3 == 1
    accel = image.unpack_records(image.TRIACCEL, image.region_words(built, "triaccel", 300, 4))
    assert np.array_equal(accel["opaque"], want)
    low = built.regions["lists"][0]
    lists = built.memory[low : low + 4 * built.registers["LIST_COUNT"]].view("<u4").astype(np.uint64)
    entries = image.unpack_records(image.LIST_ENTRY, lists[:, None])
    assert len(lists) > 100 and np.array_equal(entries["opaque"], want[entries["tri_idx"].astype(int)])


def test_path_registers():
    view = image.View(64, 32, Camera((0, 0, 3), (0, 0, 0), fov=53.13010235), max_depth=7, min_weight=0.01, trilinear=True)
    r = image.build_image(make_scene(ONE), view).registers
    assert r["MAX_DEPTH"] == 7 and regs.unpack("OPTIONS", r["OPTIONS"]) == {"shadows": 1, "trilinear": 1}
    assert fp24.from_bits(np.array([r["MIN_WEIGHT"]]))[0] == pytest.approx(0.01, rel=2.0**-17)
    assert r["MIP_BIAS"] == 4096 - 5 * 64, "the picture is as high as its distance: a pixel takes 1/32"
    assert r["UV_COUNT"] == r["TEX_LINES"] == 0


def test_textures_in_memory(seed):
    """Blocks, descriptors and coordinates are those of raycore.texture, each at its material and triangle."""
    rng = np.random.default_rng(seed)
    pictures = [rng.integers(0, 256, size, dtype=np.uint8) for size in ((8, 16, 4), (5, 4, 4), (8, 16, 4))]
    first = Texture(pictures[0], "mirror", "clamp", name="first")
    odd = Texture(pictures[1], srgb=False, compact=True, name="odd")
    again = Texture(pictures[0].copy(), "mirror", "clamp")
    grey = make_material("plain", (0.5, 0.5, 0.5))
    materials = [grey, *(replace(grey, name=f"t{i}", texture=t) for i, t in enumerate((first, odd, again)))]
    scene = make_scene(soup(rng, 40), materials, uv=rng.uniform(-5, 5, (40, 3, 2)))
    scene.face_material[:] = np.arange(40) % 4
    scene.uv[5] *= 1e-4  # a texel covers all of it: its level is negative
    geometry = image.build_geometry(scene)
    assert geometry.notes == ["odd: 4x5 resampled to 4x8"]
    built = image.build_image(geometry)
    # one texture of 16x8 RGBA8: 8 + 2 blocks, and one each of 4x2, 2x1, 1x1; then 4x8 of 16 bits: 2 + 1 + 1 + 1
    table = image.read_optics_textures(built)
    assert table[0].tolist() == [0] * 10
    assert table[1].tolist() == table[3].tolist() == [0, 4, 3, 5, 1, 2, 0, 1, 0, 0]
    assert table[2].tolist() == [13, 2, 3, 4, 0, 0, 1, 0, 0, 0]
    assert image.read_materials(built)[:, 23].tolist() == [0, 1, 1, 1]
    blocks = image.read_textures(built)
    assert blocks.shape == (13 + 5, 8) and built.registers["TEX_LINES"] == 18
    texels = blocks[:8].reshape(2, 4, 8).view(np.uint8).reshape(2, 4, 4, 4, 4).transpose(0, 2, 1, 3, 4).reshape(8, 16, 4)
    assert np.array_equal(texels, pictures[0])
    uv = image.read_uv(built)
    assert uv.shape == (40, 7)
    corners = uv[:, :2], uv[:, :2] + uv[:, 2:4], uv[:, :2] + uv[:, 4:6]
    shift = np.stack([c - scene.uv[:, i] for i, c in enumerate(corners)], axis=1)
    assert np.abs(shift - shift[:, :1]).max() < 2.0**-12, "all corners are shifted alike"
    assert np.abs(shift - np.rint(shift)).max() < 2.0**-12
    assert np.abs(shift[3::4, :, 1]).max() < 2.0**-12, "clamped coordinates stay"
    assert np.abs(np.rint(shift[1::4, :, 0]) % 2).max() == 0, "mirrored ones move by two"
    edges = scene.uv[:, 1:] - scene.uv[:, :1]
    sizes = np.array([[1, 1], [16, 8], [4, 8], [16, 8]])[scene.face_material]
    texel_area = np.abs(np.linalg.det(edges * sizes[:, None]))
    unit = geometry.unit.triangles
    area = np.linalg.norm(np.cross(unit[:, 1] - unit[:, 0], unit[:, 2] - unit[:, 0]), axis=1)
    assert np.abs(uv[:, 6] - 32 * np.log2(texel_area / area))[np.arange(40) % 4 > 0].max() <= 0.51
    assert uv[5, 6] < 0 < uv[6, 6]


def test_textures_without_coordinates():
    scene = make_scene(ONE, [replace(make_material("m", (1, 1, 1)), texture=Texture(np.zeros((2, 2, 4), np.uint8)))])
    geometry = image.build_geometry(scene)
    assert "no texture coordinates" in geometry.notes[0]
    assert image.read_materials(image.build_image(geometry))[0, 23] == 0
    with pytest.raises(SceneError, match="texture coordinates of shape"):
        image.build_geometry(replace(scene, uv=np.zeros((2, 3, 2))))


def test_default_depth():
    """Scenes without anything to bounce at take no bounces, others four, or what they ask for."""
    plain = make_material("plain", (1, 1, 1))
    for material, depth in (
        (plain, 0),
        (replace(plain, reflect=(0, 0, 0.1)), 4),
        (replace(plain, transmit=(0, 0.1, 0)), 4),
        (replace(plain, alpha_mode="mask"), 4),
    ):
        assert image.default_depth(make_scene(ONE, [material])) == depth
    assert image.default_depth(make_scene(ONE, [plain, replace(plain, reflect=(1, 1, 1))])) == 0, "not used"
    assert image.default_depth(make_scene(ONE, [plain], depth=9)) == 9


def test_edge_slack_grows_with_the_distance():
    """Of the eye from the box, and of a triangle from the eye where that is more than a half size further."""
    bounds = np.array([[-1.0, -0.5, -1.0], [1.0, 0.5, 1.0]])
    triangles = np.array([0.0, 0.5, 1.0, -1.0])[:, None, None] * np.ones((1, 3, 1)) * (1.0, 0.0, 0.0)

    def slack(*eye):
        return (image.edge_slack(np.array(eye), bounds, triangles) / triaccel.EDGE_SLACK).tolist()

    assert slack(0.0, 0.0, 0.0) == [1.0] * 4
    assert slack(-1.0, 0.0, 0.0) == [1.0, 1.75, 2.5, 1.0]
    assert slack(3.0, 0.0, 0.0) == [4.0, 4.0, 4.0, 5.5]
    assert slack(1e5, 0.0, 0.0) == [image.MAX_SLACK] * 4


def test_a_tree_can_be_used_again(mixed):
    again = image.build_image(mixed.geometry, replace(mixed.view, fb_format=pixbuf.RGB10A2, shadows=False))
    assert np.array_equal(again.memory, mixed.memory)
    changed = {n for n in mixed.registers if mixed.registers[n] != again.registers[n]}
    assert changed == {"FB_FORMAT", "OPTIONS"}


# ---- what does not fit -----------------------------------------------------------------------------------------------------

ONE = [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]
NAN = math.nan


@pytest.mark.parametrize(
    "view, message",
    [
        (image.View(0, 10), "picture size 0x10"),
        (image.View(10, -1), "picture size 10x-1"),
        (image.View(16385, 1), "picture size 16385x1"),
        (image.View(16384, 16384), "at most 64 Mpixel"),
        (image.View(8, 8, lights=[Light((0, 0, 1))] * 17), "17 lights, at most 16"),
        (image.View(8, 8, lights=[Light((1e9, 0, 0))]), "light 1e\\+09,0,0: more than"),
        (image.View(8, 8, lights=[Light((NAN, 0, 0))]), "light nan,0,0"),
        (image.View(8, 8, lights=[Light((0, 0, 0), directional=True)]), "a direction that is not zero"),
        (image.View(8, 8, lights=[Light((0, 0, 1), (1e30, 0, 0))]), "too large for 24-bit"),
        (image.View(8, 8, max_depth=16), "depth 16: give 0 to 15"),
        (image.View(8, 8, max_depth=-1), "depth -1"),
        (image.View(8, 8, min_weight=1.0), "least weight 1"),
        (image.View(8, 8, min_weight=NAN), "least weight nan"),
        (image.View(8, 8, Camera((0, 0, 1e9), (0, 0, 0))), "camera 0,0,1e\\+09: more than"),
        (image.View(8, 8, Camera((0, 0, 1), (0, 0, 1))), "eye and target"),
        (image.View(8, 8, Camera((0, 1, 0), (0, 0, 0))), "parallel"),
    ],
)
def test_views_that_make_no_sense(view, message):
    with pytest.raises(OptionError, match=message) as error:
        image.build_image(make_scene(ONE), view)
    assert "\n" not in str(error.value)


def test_too_many_materials():
    with pytest.raises(SceneError, match="257 materials, at most 256"):
        image.build_image(make_scene(ONE, [make_material("m", (0, 0, 0))] * 257))


@pytest.mark.parametrize(
    "change, message",
    [
        ({"diffuse": (-1, 0, 0)}, "diffuse colour"),
        ({"ambient": (1e30, 0, 0)}, "ambient colour"),
        ({"emission": (NAN, 0, 0)}, "emission colour"),
        ({"reflect": (0, 0, math.inf)}, "reflect colour"),
        ({"shininess": -1.0}, "shininess -1 is not a number from 0 to 1024"),
        ({"shininess": 1025.0}, "shininess 1025"),
        ({"shininess": NAN}, "shininess nan"),
        ({"alpha": 1.5}, "alpha 1.5"),
        ({"alpha_cutoff": NAN}, "alpha_cutoff nan"),
        ({"ior": 0.0}, "ior 0"),
        ({"alpha_mode": "glass"}, "alpha mode 'glass'"),
        ({"alpha_mode": "blend", "transmit": (1, 1, 1)}, "it transmits and has alpha mode blend"),
    ],
)
def test_impossible_materials(change, message):
    with pytest.raises(SceneError, match=message) as error:
        image.build_image(make_scene(ONE, [replace(make_material("m", (0, 0, 0)), **change)]))
    assert "\n" not in str(error.value) and "material m" in str(error.value)
