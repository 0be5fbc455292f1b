# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Materials, textures and lights of files: what glTF and MTL say, mapped as docs/scenes.md tells, and what is said of the rest."""

import base64
import io
import json
import math

import numpy as np
import pytest
from PIL import Image as Picture

from raycore.errors import SceneError
from raycore.scene import Texture, compact_textures, load_scene, without_textures
from raycore.scene.gltf import mean_chord, phong_exponent
from raycore.scene.materials import MAX_COLOURS, Notes, linear, merge_materials, read_picture
from raycore.scene.obj import parse_statement

QUAD = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
QUAD_UV = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)
FACES = np.array([0, 1, 2, 0, 2, 3], np.uint16)
RED, GREEN, BLUE, WHITE = (255, 0, 0, 255), (0, 255, 0, 255), (0, 0, 255, 255), (255, 255, 255, 255)


def png(pixels):
    """A PNG file of pixels (H, W, 4)."""
    out = io.BytesIO()
    Picture.fromarray(np.asarray(pixels, np.uint8)).save(out, format="PNG")
    return out.getvalue()


def four():
    """2 x 2 texels, red green above blue white."""
    return np.array([[RED, GREEN], [BLUE, WHITE]], np.uint8)


class Gltf:
    """Builds a glTF document: quads side by side, one for each material."""

    def __init__(self):
        self.data = b""
        self.json = {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": []}],
            **{k: [] for k in ("nodes", "meshes", "materials", "accessors", "bufferViews", "images", "textures")},
        }

    def view(self, data):
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values, **more):
        kind = {"f": 5126, "B": 5121, "H": 5123}[values.dtype.char]
        shape = "SCALAR" if values.ndim == 1 else f"VEC{values.shape[1]}"
        entry = {"bufferView": self.view(values.tobytes()), "componentType": kind, "count": len(values), "type": shape}
        self.json["accessors"].append(entry | more)
        return len(self.json["accessors"]) - 1

    def texture(self, pixels, data=None, **more):
        """Number of a texture with a picture of its own."""
        self.json["images"].append({"bufferView": self.view(data or png(pixels)), "mimeType": "image/png"})
        self.json["textures"].append({"source": len(self.json["images"]) - 1} | more)
        return len(self.json["textures"]) - 1

    def quad(self, material=None, uv=QUAD_UV, normalized=False, attributes=(), positions=QUAD):
        number = len(self.json["meshes"])
        accessors = {"POSITION": self.accessor(positions)}
        if uv is not None:
            accessors["TEXCOORD_0"] = self.accessor(uv, **({"normalized": True} if normalized else {}))
        for name, values in dict(attributes).items():
            accessors[name] = self.accessor(values)
        primitive = {"attributes": accessors, "indices": self.accessor(FACES)}
        if material is not None:
            self.json["materials"].append(material)
            primitive["material"] = len(self.json["materials"]) - 1
        self.json["meshes"].append({"primitives": [primitive]})
        self.json["nodes"].append({"mesh": number, "translation": [2 * number, 0, 0]})
        self.json["scenes"][0]["nodes"].append(number)
        return self

    def load(self, folder, name="a.gltf"):
        (folder / "a.bin").write_bytes(self.data)
        self.json["buffers"] = [{"uri": "a.bin", "byteLength": len(self.data)}]
        document = {k: v for k, v in self.json.items() if v or k == "nodes"}
        (folder / name).write_text(json.dumps(document))
        return load_scene(folder / name)


def gltf_material(folder, material, **quad):
    """One material of a glTF file, and the scene."""
    scene = Gltf().quad(material, **quad).load(folder)
    return scene.materials[0], scene


# ---- glTF ------------------------------------------------------------------------------------------------------------


def test_plain_metallic_roughness(tmp_path):
    m, scene = gltf_material(
        tmp_path,
        {"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 0.3], "metallicFactor": 0}},
    )
    assert (m.name, m.alpha, m.alpha_mode, m.texture) == ("paint", 1.0, "opaque", None)
    assert np.allclose(m.diffuse, (0.5, 0.25, 0.125)) and np.allclose(m.ambient, np.multiply(0.12, m.diffuse))
    assert not any(m.reflect) and not any(m.transmit) and not any(m.emission)
    assert m.shininess == 1.0 and np.allclose(m.specular, 0.04 * 1.5), "rough: as wide as it can be"
    assert scene.warnings == []


def test_phong_exponent():
    """The highlight falls to half where that of the microfacets does."""
    for rough in (0.2, 0.3, 0.5):
        n, alpha = phong_exponent(rough), rough**2
        half_angle = math.acos(0.5 ** (1.0 / n)) / 2.0  # of N.H, where R.V turns twice as far
        blinn = math.cos(half_angle) ** (2.0 / alpha**2 - 2.0)
        assert blinn == pytest.approx(0.5, abs=0.03)
    assert phong_exponent(0.0) == 1024.0 and phong_exponent(1.0) == 1.0


def test_metals_reflect(tmp_path):
    base = [0.9, 0.6, 0.3, 1.0]
    m, _ = gltf_material(tmp_path, {"pbrMetallicRoughness": {"baseColorFactor": base, "roughnessFactor": 0.0}})
    assert np.allclose(m.reflect, base[:3]) and m.fresnel and not m.tint_reflection and np.allclose(m.diffuse, 0)
    m, _ = gltf_material(tmp_path, {"pbrMetallicRoughness": {"baseColorFactor": base, "roughnessFactor": 0.5}})
    assert np.allclose(m.reflect, np.multiply(0.25, base[:3])) and not m.fresnel
    assert np.allclose(m.diffuse, np.multiply(0.6 * 0.75, base[:3]))
    m, _ = gltf_material(tmp_path, {"pbrMetallicRoughness": {"baseColorFactor": base}})
    assert not any(m.reflect), "rough metals scatter what they reflect"
    g = Gltf()
    number = g.texture(four())
    g.quad({"pbrMetallicRoughness": {"baseColorTexture": {"index": number}, "roughnessFactor": 0.0}})
    m = g.load(tmp_path).materials[0]
    assert m.tint_reflection and np.allclose(m.reflect, 1.0) and m.texture is not None


def test_polished_surfaces_reflect(tmp_path):
    m, _ = gltf_material(tmp_path, {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.05}})
    assert np.allclose(m.reflect, 0.04) and m.fresnel
    m, _ = gltf_material(tmp_path, {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.4}})
    assert not any(m.reflect)


GLASS = {"metallicFactor": 0, "roughnessFactor": 0, "baseColorFactor": [0.5, 0.8, 1.0, 1.0]}


@pytest.mark.parametrize("ior", [None, 1.33, 2.0])
def test_glass_with_a_volume_refracts(tmp_path, ior):
    extensions = {
        "KHR_materials_transmission": {"transmissionFactor": 0.75},
        "KHR_materials_volume": {"thicknessFactor": 1.0},
    }
    if ior is not None:
        extensions["KHR_materials_ior"] = {"ior": ior}
    m, scene = gltf_material(tmp_path, {"pbrMetallicRoughness": GLASS, "extensions": extensions})
    n = ior or 1.5
    assert np.allclose(m.transmit, np.multiply(0.75, GLASS["baseColorFactor"][:3])) and m.ior == n
    assert np.allclose(m.reflect, ((n - 1) / (n + 1)) ** 2) and m.fresnel and not m.opaque
    assert np.allclose(m.diffuse, np.multiply(0.25, GLASS["baseColorFactor"][:3])) and scene.warnings == []


def test_thin_glass_goes_straight_on(tmp_path):
    m, _ = gltf_material(
        tmp_path,
        {
            "pbrMetallicRoughness": GLASS,
            "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1.0},
                "KHR_materials_ior": {"ior": 1.7},
            },
        },
    )
    assert m.ior == 1.0 and any(m.transmit) and np.allclose(m.reflect, (0.7 / 2.7) ** 2)


def test_absorption_is_split_between_two_surfaces(tmp_path):
    m, scene = gltf_material(
        tmp_path,
        {
            "pbrMetallicRoughness": GLASS | {"baseColorFactor": [1, 1, 1, 1]},
            "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1.0},
                "KHR_materials_volume": {
                    "thicknessFactor": 2.0,
                    "attenuationDistance": 1.0,
                    "attenuationColor": [0.5, 0.9, 1.0],
                },
            },
        },
    )
    assert np.allclose(np.square(m.transmit), (0.25, 0.81, 1.0)) and "absorption" in scene.warnings[0]


def test_mean_chord():
    """Of a ball two thirds of its width, of a thin plate twice its thickness, of open meshes unknown."""
    import trimesh

    ball, plate = trimesh.creation.icosphere(subdivisions=4, radius=3.0), trimesh.creation.box((100, 100, 0.1))
    assert mean_chord([(np.asarray(ball.triangles) + 50.0, None)]) == pytest.approx(4.0, rel=0.01)
    assert mean_chord([(np.asarray(plate.triangles), None)] * 2) == pytest.approx(0.2, rel=0.01)
    assert mean_chord([(np.asarray(plate.triangles)[:5], None)]) is None and mean_chord([]) is None


def test_absorption_of_closed_meshes(tmp_path):
    """Rays cross the mesh: its own thickness counts, not the stated one."""
    volume = {"thicknessFactor": 99.0, "attenuationDistance": 1.0, "attenuationColor": [0.5, 0.9, 1.0]}
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_volume": volume}
    material = {"pbrMetallicRoughness": GLASS | {"baseColorFactor": [1, 1, 1, 1]}, "extensions": extensions}
    box = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], np.float32)
    sides = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]
    g = Gltf().quad(material, uv=None, positions=box)
    g.json["meshes"][0]["primitives"][0]["indices"] = g.accessor(np.array(sides, np.uint16))
    m = g.load(tmp_path).materials[0]
    assert np.allclose(m.transmit, np.power((0.5, 0.9, 1.0), 0.5 * 4 / 6))


def test_thickness_maps_count_by_their_mean(tmp_path):
    g = Gltf()
    number = g.texture([[(0, 255, 0, 255), (0, 0, 0, 255)]])
    volume = {"thicknessFactor": 4.0, "thicknessTexture": {"index": number}}
    volume |= {"attenuationDistance": 1.0, "attenuationColor": [0.5, 0.9, 1.0]}
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_volume": volume}
    pbr = GLASS | {"baseColorFactor": [1, 1, 1, 1]}
    m = g.quad({"pbrMetallicRoughness": pbr, "extensions": extensions}).load(tmp_path).materials[0]
    assert np.allclose(np.square(m.transmit), (0.25, 0.81, 1.0), atol=0.01) and m.ior == 1.5


def test_transmission_map_becomes_its_mean(tmp_path):
    g = Gltf()
    number = g.texture([[(255, 0, 0, 255), (0, 0, 0, 255)]])
    extension = {"KHR_materials_transmission": {"transmissionFactor": 1.0, "transmissionTexture": {"index": number}}}
    scene = g.quad({"name": "pane", "pbrMetallicRoughness": GLASS, "extensions": extension}).load(tmp_path)
    assert np.allclose(scene.materials[0].transmit, np.multiply(0.5, GLASS["baseColorFactor"][:3]), atol=0.02)
    assert scene.warnings == ["transmission maps become their mean: pane"]


def test_maps_are_averaged_where_they_are_used(tmp_path):
    """An atlas: each material uses one half of the same metallic-roughness map."""
    g = Gltf()
    number = g.texture([[(0, 255, 0, 255), (0, 0, 255, 255)]])  # left: rough, no metal; right: smooth metal
    for offset in (0.0, 0.5):
        uv = (QUAD_UV * (0.5, 1.0) + (offset, 0.0)).astype(np.float32)
        g.quad({"name": f"at {offset}", "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": number}}}, uv=uv)
    by_name = {m.name: m for m in g.load(tmp_path).materials}
    assert by_name["at 0.0"].shininess == 1.0 and not any(by_name["at 0.0"].reflect)
    assert by_name["at 0.5"].shininess == 1024.0 and np.allclose(by_name["at 0.5"].reflect, 1.0)


def test_emission(tmp_path):
    m, _ = gltf_material(
        tmp_path,
        {
            "emissiveFactor": [1.0, 0.5, 0.25],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
        },
    )
    assert np.allclose(m.emission, (4, 2, 1))
    g = Gltf()
    number = g.texture([[(255, 255, 255, 255), (0, 0, 0, 255)]])
    lamp = {"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": number}}
    scene = g.quad(lamp).quad({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}, **lamp}).load(tmp_path)
    mean, shown = sorted(scene.materials, key=lambda m: m.texture is not None)
    assert np.allclose(mean.emission, 0.5, atol=0.02) and "emissive maps" in scene.warnings[0]
    assert np.allclose(shown.ambient, 1.0) and not any(shown.diffuse), "what only shines shows its picture"


def test_unlit(tmp_path):
    m, _ = gltf_material(
        tmp_path,
        {"pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 1]}, "extensions": {"KHR_materials_unlit": {}}},
    )
    assert np.allclose(m.ambient, (0.1, 0.2, 0.3)) and not any(m.diffuse) and not any(m.specular)


@pytest.mark.parametrize(
    "mode, alphas, factor, want",
    [
        ("MASK", (0, 255), 1.0, ("mask", 1.0)),
        ("MASK", (255, 255), 1.0, ("opaque", 1.0)),
        ("MASK", (200, 255), 1.0, ("opaque", 1.0)),  # never below the cutoff
        ("BLEND", (255, 255), 1.0, ("opaque", 1.0)),
        ("BLEND", (255, 255), 0.25, ("blend", 0.25)),
        ("BLEND", (0, 255), 1.0, ("blend", 1.0)),
        ("OPAQUE", (0, 255), 0.5, ("opaque", 1.0)),
    ],
)
def test_alpha(tmp_path, mode, alphas, factor, want):
    g = Gltf()
    number = g.texture([[(255, 255, 255, a) for a in alphas]])
    pbr = {"baseColorTexture": {"index": number}, "baseColorFactor": [1, 1, 1, factor], "metallicFactor": 0}
    m = g.quad({"alphaMode": mode, "alphaCutoff": 0.7, "pbrMetallicRoughness": pbr}).load(tmp_path).materials[0]
    assert (m.alpha_mode, m.alpha) == want
    assert m.alpha_mode != "mask" or m.alpha_cutoff == 0.7


def test_alpha_of_glass_is_told(tmp_path):
    extension = {"KHR_materials_transmission": {"transmissionFactor": 1.0}}
    pbr = GLASS | {"baseColorFactor": [1, 1, 1, 0.5]}
    m, scene = gltf_material(
        tmp_path, {"name": "g", "alphaMode": "BLEND", "pbrMetallicRoughness": pbr, "extensions": extension}
    )
    assert (
        m.alpha_mode == "opaque" and any(m.transmit) and scene.warnings == ["alpha mode blend of glass is not used: g"]
    )


# ---- textures and coordinates -----------------------------------------------------------------------------------------


def colour_at(scene, point):
    """sRGB bytes of the texture where a point lies on the first quad that holds it."""
    for tri, uv, index in zip(scene.triangles, scene.uv, scene.face_material):
        edges = np.stack((tri[1] - tri[0], tri[2] - tri[0]), axis=1)
        (b, c), *_ = np.linalg.lstsq(edges, np.asarray(point, float) - tri[0], rcond=None)
        if min(b, c, 1 - b - c) > -1e-9 and np.allclose(edges @ (b, c), np.asarray(point, float) - tri[0]):
            texture = scene.materials[index].texture
            h, w = texture.image.shape[:2]
            u, v = ((1 - b - c) * uv[0] + b * uv[1] + c * uv[2]) % 1.0
            return tuple(texture.image[int(v * h), int(u * w)].tolist())
    raise AssertionError("no quad there")


CORNERS = {(0.25, 0.75): RED, (0.75, 0.75): GREEN, (0.25, 0.25): BLUE, (0.75, 0.25): WHITE}


@pytest.mark.parametrize("kind", ["float", "byte", "short", "data uri"])
def test_gltf_textures(tmp_path, kind):
    """The picture stands upright, whatever the coordinates are made of and wherever it is stored."""
    g = Gltf()
    number = g.texture(four())
    if kind == "data uri":
        uri = "data:image/png;base64," + base64.b64encode(png(four())).decode()
        g.json["images"][0] = {"uri": uri}
    types = {"byte": (np.uint8, 255), "short": (np.uint16, 65535)}
    uv = QUAD_UV if kind not in types else (QUAD_UV * types[kind][1]).astype(types[kind][0])
    g.quad({"pbrMetallicRoughness": {"baseColorTexture": {"index": number}}}, uv=uv, normalized=kind in types)
    scene = g.load(tmp_path)
    assert scene.uv.min() == 0.0 and scene.uv.max() == 1.0
    for (x, y), colour in CORNERS.items():
        assert colour_at(scene, (x, y, 0)) == colour


def test_second_set_of_coordinates(tmp_path):
    g = Gltf()
    number = g.texture(four())
    wrong = np.zeros((4, 2), np.float32)
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": number, "texCoord": 1}}}
    scene = g.quad(material, uv=wrong, attributes={"TEXCOORD_1": QUAD_UV}).load(tmp_path)
    for (x, y), colour in CORNERS.items():
        assert colour_at(scene, (x, y, 0)) == colour


def test_texture_transform(tmp_path):
    """The example of KHR_texture_transform: the lower left quadrant of the picture, turned clockwise by 90 degrees."""
    picture = np.zeros((4, 4, 4), np.uint8)
    picture[2:, :2] = four()  # its lower left quadrant
    g = Gltf()
    number = g.texture(picture)
    moved = {"offset": [0, 1], "rotation": math.pi / 2, "scale": [0.5, 0.5]}
    info = {"index": number, "extensions": {"KHR_texture_transform": moved}}
    scene = g.quad({"pbrMetallicRoughness": {"baseColorTexture": info}}).load(tmp_path)
    # red green / blue white turned clockwise is blue red / white green
    turned = {(0.25, 0.75): BLUE, (0.75, 0.75): RED, (0.25, 0.25): WHITE, (0.75, 0.25): GREEN}
    for (x, y), colour in turned.items():
        assert colour_at(scene, (x, y, 0)) == colour


def test_samplers(tmp_path):
    g = Gltf()
    g.json["samplers"] = [{"wrapS": 33648, "wrapT": 33071, "magFilter": 9728}]
    number = g.texture(four(), sampler=0)
    scene = g.quad({"pbrMetallicRoughness": {"baseColorTexture": {"index": number}}}).load(tmp_path)
    texture = scene.materials[0].texture
    assert (texture.wrap_s, texture.wrap_t) == ("mirror", "clamp") and "without a filter" in scene.warnings[0]


def test_instances_keep_their_coordinates(tmp_path):
    """A mirrored instance has its faces turned, and their coordinates with them."""
    g = Gltf()
    number = g.texture(four())
    g.quad({"pbrMetallicRoughness": {"baseColorTexture": {"index": number}}})
    g.json["nodes"][0] |= {"scale": [-1, 1, 1]}
    scene = g.load(tmp_path)
    for (x, y), colour in CORNERS.items():
        assert colour_at(scene, (-x, y, 0)) == colour


def test_broken_pictures_are_told(tmp_path):
    g = Gltf()
    broken, missing = g.texture(None, data=b"no picture"), g.texture(four())
    g.json["images"][1] = {"uri": "nowhere.png"}
    for number in (broken, missing):
        g.quad({"pbrMetallicRoughness": {"baseColorTexture": {"index": number}, "metallicFactor": 0}})
    scene = g.load(tmp_path)
    assert all(m.texture is None for m in scene.materials)
    (line,) = scene.warnings
    assert line.startswith("pictures that cannot be read") and "image 0" in line and "nowhere.png" in line


def test_textures_without_coordinates(tmp_path):
    g = Gltf()
    number = g.texture([[RED, RED]])
    pbr = {"baseColorTexture": {"index": number}, "metallicFactor": 0}
    scene = g.quad({"name": "bare", "pbrMetallicRoughness": pbr}, uv=None).load(tmp_path)
    assert scene.uv is None and np.allclose(scene.materials[0].diffuse, (1, 0, 0))
    assert scene.warnings == ["textures of meshes without coordinates become their mean colour: bare"]


def test_vertex_colours_multiply(tmp_path):
    """COLOR_0 is linear and multiplies the base colour; the texture stays."""
    colours = np.array([[255, 255, 255, 255]] * 4, np.uint8)
    g = Gltf()
    number = g.texture(four())
    pbr = {"baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": number}, "metallicFactor": 0}
    g.quad({"name": "white", "pbrMetallicRoughness": pbr}, attributes={"COLOR_0": colours})
    g.quad({"name": "grey", "pbrMetallicRoughness": pbr}, attributes={"COLOR_0": colours // 2})
    by_name = {m.name: m for m in g.load(tmp_path).materials}
    assert set(by_name) == {"white", "grey colour 0"} and by_name["grey colour 0"].texture is not None
    assert np.allclose(by_name["white"].diffuse, (0.5, 1, 1))
    assert np.allclose(by_name["grey colour 0"].diffuse, np.multiply(127 / 255, (0.5, 1, 1)))


# ---- what cannot be mapped ------------------------------------------------------------------------------------------


def test_unused_things_are_told(tmp_path):
    g = Gltf()
    number = g.texture(four())
    extra = {"normalTexture": {"index": number}, "occlusionTexture": {"index": number}}
    extra["extensions"] = {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}
    g.json["extensionsUsed"] = ["KHR_materials_clearcoat", "KHR_materials_variants", "ACME_secret"]
    g.json["animations"] = [{"channels": [], "samplers": []}]
    scene = g.quad({"name": "m", "pbrMetallicRoughness": {"metallicFactor": 0}, **extra}).load(tmp_path)
    text = "\n".join(scene.warnings)
    for part in (
        "normal maps are not used: m",
        "occlusion maps are not used: m",
        "KHR_materials_clearcoat",
        "animations",
    ):
        assert part in text
    assert "ACME_secret" in text and all("\n" not in w for w in scene.warnings)


def test_packed_meshes_are_refused(tmp_path):
    g = Gltf().quad()
    g.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    with pytest.raises(SceneError, match="packed by KHR_draco_mesh_compression"):
        g.load(tmp_path)


def test_lights_are_told(tmp_path):
    g = Gltf().quad()
    g.json["extensionsUsed"] = ["KHR_lights_punctual"]
    lights = [{"type": "spot", "intensity": 10, "spot": {}}, *[{"type": "point", "intensity": 5}] * 19]
    g.json["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    for i in range(20):
        g.json["nodes"].append({"extensions": {"KHR_lights_punctual": {"light": i}}})
        g.json["scenes"][0]["nodes"].append(len(g.json["nodes"]) - 1)
    scene = g.load(tmp_path)
    assert len(scene.lights) == 16 and scene.lights[0].colour == (1, 1, 1) and scene.lights[1].colour == (0.5, 0.5, 0.5)
    text = "\n".join(scene.warnings)
    assert "20 lights, 16 fit" in text and "spots" in text and "ratios" in text


def test_notes_are_short():
    notes = Notes()
    for i in range(9):
        notes.add("things are not used", f"m{i}")
    notes.add("a fact")
    assert notes.lines() == ["things are not used: m0, m1, m2, m3 and 5 more", "a fact"]


def test_bart_numbers(tmp_path):
    """The twelve numbers of BART's `fm`, kept in the extras, are used as they are: NFF's Ks mirrors, T lets through."""
    raw = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.05, 0.06, 0.07, 97.5, 0.85, 1.55]
    m, _ = gltf_material(tmp_path, {"name": "fm08", "extras": {"bart_fm": raw}})
    assert m.ambient == tuple(raw[:3]) and m.diffuse == tuple(raw[3:6]) and m.specular == m.reflect == tuple(raw[6:9])
    assert (m.shininess, m.transmit, m.ior, m.fresnel) == (97.5, (0.85,) * 3, 1.55, False)
    m, _ = gltf_material(tmp_path, {"extras": {"bart_fm": [0.0] * 9 + [255.0, 0.0, 0.0]}})
    assert not any(m.transmit) and m.ior == 1.0 and m.shininess == 255.0


# ---- MTL --------------------------------------------------------------------------------------------------------------

OBJ = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"


def mtl_material(folder, text, obj=OBJ):
    """One material of an MTL file, and the scene."""
    (folder / "m.mtl").write_text("newmtl m\n" + text)
    (folder / "m.obj").write_text(obj)
    scene = load_scene(folder / "m.obj")
    return scene.materials[0], scene


def test_mtl_colours(tmp_path):
    m, scene = mtl_material(
        tmp_path, "Ka 0.5 0.25 0 # said\nKd 0.1 0.2 0.3\nKs .4 .5 .6\nNs 77.5\nKe 3 2 1\nd 1.0\nillum 2\n"
    )
    assert np.allclose(m.ambient, (0.06, 0.03, 0)) and m.diffuse == (0.1, 0.2, 0.3) and m.specular == (0.4, 0.5, 0.6)
    assert m.shininess == 77.5 and m.emission == (3, 2, 1) and m.opaque and not any(m.reflect) and not scene.warnings
    m, _ = mtl_material(tmp_path, "Ka 1 1 1\nKd 0.1 0.2 0.3\nNs 0\n")
    assert np.allclose(m.ambient, np.multiply(0.12, m.diffuse)) and m.shininess == 1.0


@pytest.mark.parametrize("illum, fresnel", [(3, False), (5, True), (8, False)])
def test_mtl_mirrors(tmp_path, illum, fresnel):
    m, _ = mtl_material(tmp_path, f"Kd 0 0 0\nKs 0.9 0.8 0.7\nillum {illum}\n")
    assert m.reflect == (0.9, 0.8, 0.7) and m.fresnel == fresnel and not any(m.transmit)


def test_mtl_glass(tmp_path):
    m, _ = mtl_material(tmp_path, "Kd 0 0 0\nKs 0.3 0.3 0.3\nNi 1.5\nillum 7\n")
    assert m.fresnel and np.allclose(m.reflect, 0.04) and m.transmit == (1, 1, 1) and m.ior == 1.5
    m, _ = mtl_material(tmp_path, "Ks 0.3 0.3 0.3\nNi 1.5\nTf 0.1 0.2 0.2\nillum 6\n")
    assert not m.fresnel and m.reflect == (0.3, 0.3, 0.3) and np.allclose(m.transmit, (0.5, 0.7, 0.7))
    for text in ("d 0.25", "Tr 0.75"):
        m, _ = mtl_material(tmp_path, f"Kd 1 1 1\nNi 1.2\n{text}\nillum 4\n")
        assert np.allclose(m.transmit, 0.75) and np.allclose(m.diffuse, 0.25) and m.alpha_mode == "opaque"
    m, scene = mtl_material(tmp_path, "Ks 0.5 0.5 0.5\nillum 7\n")
    assert not any(m.transmit) and m.reflect == (0.5, 0.5, 0.5) and "taken for a mirror: m" in scene.warnings[0]


@pytest.mark.parametrize(
    "text, alpha", [("d 0.25", 0.25), ("Tr 0.25", 0.75), ("d -halo 0.5", 0.5), ("d 0.3\nTr 0.3", 0.3)]
)
def test_mtl_opacity(tmp_path, text, alpha):
    m, _ = mtl_material(tmp_path, f"Kd 1 1 1\n{text}\nillum 2\n")
    assert (m.alpha_mode, m.alpha) == ("blend", alpha) and not any(m.transmit)


def test_mtl_textures(tmp_path):
    """map_Kd, found whatever the case and the folder that the file names, upright; -s and -o move it."""
    (tmp_path / "Four.PNG").write_bytes(png(four()))
    m, scene = mtl_material(tmp_path, "Kd 0.5 1 1\nmap_Kd C:\\\\textures\\four.png\n")
    assert m.texture is not None and m.diffuse == (0.5, 1, 1) and not scene.warnings
    for (x, y), colour in CORNERS.items():
        assert colour_at(scene, (x, y, 0)) == colour
    _, scene = mtl_material(tmp_path, "map_Kd -s 0.5 0.5 1 -o 0.5 0 -clamp on Four.PNG\n")
    assert colour_at(scene, (0.5, 0.5, 0)) == WHITE, "the lower right quadrant"
    assert scene.materials[0].texture.wrap_s == "clamp"
    m, scene = mtl_material(tmp_path, "Kd 0 0 0\nmap_Kd Four.PNG\n")
    assert m.diffuse == (1, 1, 1) and "black Kd" in scene.warnings[0]
    m, scene = mtl_material(tmp_path, "map_Kd none.png\nmap_Bump b.png\nmap_Ks Four.PNG\nKs 1 1 1\n")
    assert m.texture is None and np.allclose(m.specular, linear(four()[..., :3] / 255.0).reshape(-1, 3).mean(axis=0))
    text = "\n".join(scene.warnings)
    assert "none.png" in text and "bump maps are not used: m" in text and "map_ks becomes its mean" in text


def test_mtl_cutouts(tmp_path):
    """map_d, or the alpha of map_Kd, cuts out; shades of it blend."""
    (tmp_path / "four.png").write_bytes(png(four()))
    (tmp_path / "cut.png").write_bytes(png([[(0, 0, 0, 255), WHITE], [WHITE, WHITE]]))
    m, _ = mtl_material(tmp_path, "Kd 1 1 1\nmap_Kd four.png\nmap_d cut.png\n")
    assert m.alpha_mode == "mask" and m.texture.image[..., 3].tolist() == [[0, 255], [255, 255]]
    m, _ = mtl_material(tmp_path, "Kd 1 1 1\nmap_d cut.png\n")
    assert m.alpha_mode == "mask" and (m.texture.image[..., :3] == 255).all()
    (tmp_path / "fade.png").write_bytes(png([[(9, 9, 9, 40 * i) for i in range(6)]]))
    m, _ = mtl_material(tmp_path, "map_Kd fade.png\n")
    assert m.alpha_mode == "blend"
    (tmp_path / "empty.png").write_bytes(png([[(9, 9, 9, 0)] * 2]))
    m, _ = mtl_material(tmp_path, "map_Kd empty.png\n")
    assert m.alpha_mode == "opaque" and (m.texture.image[..., 3] == 255).all()


def test_mtl_statements():
    """Options before file names with blanks."""
    s = parse_statement("-bm 0.3 -s 2 3 -o 0.5 -clamp on -imfchan l my file.png".split())
    assert (s.file, s.scale, s.offset, s.wrap) == ("my file.png", (2.0, 3.0), (0.5, 0.0), "clamp")
    assert parse_statement("-mm 0 1 a.png".split()).file == "a.png"
    assert parse_statement([]) is None


def test_mtl_files_and_names(tmp_path):
    """Two libraries, names with blanks, material files that are missing, materials that nobody defines."""
    (tmp_path / "my a.mtl").write_text("newmtl deep red\nKd 1 0 0\n")
    (tmp_path / "b.mtl").write_text("newmtl blue\nKd 0 0 1\n")
    faces = "usemtl deep red\nf 1 2 3\nusemtl blue\nf 1 3 4\nusemtl ghost\nf 1 2 4\n"
    text = "mtllib my a.mtl\nmtllib b.mtl c.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\n" + faces
    (tmp_path / "n.obj").write_text(text)
    scene = load_scene(tmp_path / "n.obj")
    assert {m.name for m in scene.materials} == {"deep red", "blue", "default"}
    text = "\n".join(scene.warnings)
    assert "c.mtl" in text and "ghost" in text
    used = {scene.materials[m].name: tuple(t[2]) for m, t in zip(scene.face_material, scene.triangles)}
    assert used["deep red"] == (1, 1, 0) and used["blue"] == (0, 1, 1)


# ---- pictures and scenes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA", "CMYK", "I;16"])
def test_pictures_of_all_kinds(tmp_path, mode):
    """White and black stay what they are in every kind of picture."""
    if mode == "I;16":
        picture = Picture.fromarray(np.array([[0, 65535]], np.uint16))
    else:
        picture = Picture.fromarray(np.array([[[0] * 3, [255] * 3]], np.uint8)).convert(mode)
    path = tmp_path / ("a.tif" if mode in ("CMYK", "I;16") else "a.png")
    picture.save(path)
    assert read_picture(path).tolist() == [[[0, 0, 0, 255], [255, 255, 255, 255]]]


def test_equal_textures_are_one(tmp_path):
    g = Gltf()
    numbers = [g.texture(four()), g.texture(four()), g.texture(four()[::-1])]
    for number in numbers:
        g.quad({"name": "m", "pbrMetallicRoughness": {"baseColorTexture": {"index": number}}})
    scene = g.load(tmp_path)
    assert len(scene.triangles) == 6 and len({m.texture for m in scene.materials}) == 2
    a, b = Texture(four()), Texture(four(), wrap_s="clamp")
    assert a == Texture(four().copy(), name="other") and hash(a) == hash(Texture(four())) and a != b


def test_merging_keeps_glass_and_textures():
    """Where too many materials come, one of another kind is never taken for glass or a textured one."""
    from raycore.scene import make_material

    glass = make_material("glass", (0.5, 0.5, 0.5), transmit=(1, 1, 1))
    plain = [make_material(f"p{i}", (0.5, 0.5, i / 600)) for i in range(600)]
    index = np.concatenate((np.zeros(50, int), np.arange(601)))
    notes = Notes()
    merged, faces = merge_materials([glass, *plain], index, notes)
    assert len(merged) == 256 and "601 materials" in notes.lines()[0]
    assert {merged[f].name for f in faces[:51]} == {"glass"}
    assert all(not any(merged[f].transmit) for f in faces[51:])
    assert MAX_COLOURS < 256


def test_without_and_compact_textures(tmp_path):
    g = Gltf()
    number = g.texture([[RED, RED]])
    pbr = {"baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": number}, "roughnessFactor": 0}
    scene = g.quad({"pbrMetallicRoughness": pbr}).load(tmp_path)
    plain = without_textures(scene).materials[0]
    assert plain.texture is None and np.allclose(plain.reflect, (0.5, 0, 0)) and without_textures(scene).uv is None
    assert compact_textures(scene).materials[0].texture.compact and not scene.materials[0].texture.compact
