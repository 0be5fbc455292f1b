# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The memory image: records as rc_pkg.sv lays them out, regions, registers, and what does not fit."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from raycore import image, kdtree, regs, triaccel
from raycore.errors import OptionError, SceneError
from raycore.model import fp24, pixbuf
from raycore.scene import Camera, Light, Material, Scene, face_normals, make_material

PACKAGE = (Path(__file__).resolve().parents[1] / "rtl/rc_pkg.sv").read_text()
STRUCTS = {
    "node_t": image.NODE,
    "list_entry_t": image.LIST_ENTRY,
    "triaccel_t": image.TRIACCEL,
    "tri_info_t": image.TRI_INFO,
    "light_t": image.LIGHT,
    "material_t": image.MATERIAL,
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
    widths = {"fp_t": 24, "idx_t": constant("IDX_W"), "mat_t": constant("MAT_W"), "logic": 1}
    body = re.search(r"typedef struct packed \{([^}]*)\} " + name + ";", re.sub(r"//[^\n]*", "", PACKAGE))[1]
    fields = []
    for kind, high, field in re.findall(r"(\w+)\s*(?:\[(\d+):0\])?\s+(\w+)\s*;", body):
        fields.append((field, int(high) + 1 if high else widths[kind]))
    assert len(fields) == body.count(";")
    return tuple(reversed(fields))


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
        assert lo == at and lo % 64 == 0 and hi % 64 == 0 and hi > lo
        at = hi
    r = mixed.registers
    names = ("NODE_BASE", "LIST_BASE", "ACCEL_BASE", "INFO_BASE", "MAT_BASE", "LIGHT_BASE", "FB_BASE")
    assert [r[n] for n in names] == [lo for lo, _ in mixed.regions.values()]
    sizes = (8 * r["NODE_COUNT"], 4 * r["LIST_COUNT"], *(s * r["TRI_COUNT"] for s in (32, 64)))
    sizes += (64 * r["MAT_COUNT"], 64 * r["LIGHT_COUNT"], r["FB_STRIDE"] * 21)
    assert [-(-s // 64) * 64 for s in sizes] == list(mixed.sizes.values())
    assert r["FB_STRIDE"] % 32 == 0 and 0 <= r["FB_STRIDE"] - 4 * 37 < 32
    assert regs.unpack("SIZE", r["SIZE"]) == {"width": 37, "height": 21}
    assert mixed.memory.size == mixed.regions["frame"][0] and not mixed.memory[: image.FIRST_ADDRESS].any()


def test_every_set_up_register_has_a_value(mixed):
    settable = {
        n for n, f in regs.FIELDS.items() if any(a == "RW" for _, _, a in f.values()) and not n.startswith("IRQ")
    }
    assert set(mixed.registers) == settable
    for name, value in mixed.registers.items():
        assert value == sum(v << regs.FIELDS[name][f][0] for f, v in regs.unpack(name, value).items()), name


def test_records_hold_the_scene(mixed):
    geometry = mixed.geometry
    info, mat = image.read_info(mixed)
    assert np.array_equal(mat, geometry.scene.face_material)
    assert np.array_equal(info[:, 0], geometry.unit.triangles[:, 0])
    keep = ~geometry.unit.dropped
    assert np.abs(info[keep, 1] - face_normals(geometry.scene.triangles)[keep]).max() < 2.0**-10
    words = image.region_words(mixed, "triaccel", 120, 4)
    assert np.flatnonzero(image.unpack_records(image.TRIACCEL, words)["k"] == 3).tolist() == [17]
    table = image.read_materials(mixed)
    assert np.array_equal(table[:, 9], np.arange(5))
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


@pytest.mark.parametrize("shininess, log2", [(0.1, 0), (1, 0), (2, 1), (11, 3), (12, 4), (32, 5), (200, 8), (1e9, 8)])
def test_shininess_becomes_a_power_of_two(shininess, log2):
    assert image.material_table([Material("m", (0, 0, 0), (0, 0, 0), (0, 0, 0), shininess)])[0, 9] == log2


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


@pytest.mark.parametrize("material", [Material("m", (0, 0, 0), (-1, 0, 0)), Material("m", (1e30, 0, 0), (0, 0, 0))])
def test_impossible_colours(material):
    with pytest.raises(SceneError, match="colour"):
        image.build_image(make_scene(ONE, [material]))
