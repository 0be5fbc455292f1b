# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""glTF and GLB: meshes in trimesh's order; materials, textures, cameras and lights from the file's own JSON.

trimesh is given the file without pictures and with materials named after their numbers, so that nothing it drops is lost;
texture coordinates and colours reach us as attributes of the vertices. docs/scenes.md says how materials are mapped.
"""

import base64
import copy
import io
import json
import math
import re
import struct
import urllib.parse
from dataclasses import dataclass, replace

import numpy as np

from raycore.errors import SceneError
from raycore.scene.data import Camera, Light, Material, make_material
from raycore.scene.materials import (
    bart_material,
    linear,
    read_picture,
    settle_alpha,
    texture_of,
    times,
    tinted_materials,
)
from raycore.scene.mesh import Loaded, Part, corner_uv, default_material, meshes, place, read_trimesh

MAGIC, JSON_CHUNK = 0x46546C67, 0x4E4F534A
WRAPS = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
NEAREST = (9728, 9984, 9986)
UV, COLOUR = "_RAYCORE_UV", "_RAYCORE_COLOUR"
MAX_LIGHTS = 16
MAX_SAMPLES = 20_000  # places of a map that its mean is taken from
UNREADABLE = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")  # geometry that only these can unpack
# Extensions whose meaning is used, or which change nothing in a picture of ours.
USED = {
    *("KHR_materials_transmission", "KHR_materials_ior", "KHR_materials_emissive_strength", "KHR_materials_unlit"),
    *("KHR_materials_volume", "KHR_materials_pbrSpecularGlossiness", "KHR_lights_punctual", "KHR_texture_transform"),
    *("EXT_texture_webp", "KHR_mesh_quantization", "KHR_xmp", "KHR_xmp_json_ld"),
}

F0 = 0.04  # reflectance of what is no metal and says nothing
SMOOTH = 0.25  # up to this roughness a metal's reflection grows towards grazing angles
POLISHED = 0.1  # up to this roughness what is no metal reflects
LEAST_MIRROR = 1.0 / 64.0  # reflectance below this is left to the highlight
ROUGH_METAL = 0.6  # share of a rough metal's colour that counts as diffuse


# ---- the file --------------------------------------------------------------------------------------------------------


def read_document(path):
    """A glTF or GLB file: (its JSON, [(type, bytes) of further chunks])."""
    data = path.read_bytes()
    if path.suffix.lower() == ".gltf":
        return json.loads(data.decode("utf-8")), []
    magic, version, _ = struct.unpack_from("<III", data)
    if magic != MAGIC or version != 2:
        raise ValueError("no GLB of version 2")
    chunks, at = [], 12
    while at + 8 <= len(data):
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > len(data):
            raise ValueError("its end is missing")
        chunks.append((kind, data[at + 8 : at + 8 + size]))
        at += 8 + size
    if not chunks or chunks[0][0] != JSON_CHUNK:
        raise ValueError("no JSON at its beginning")
    return json.loads(chunks[0][1].decode("utf-8")), chunks[1:]


class Document:
    """A glTF file and what hangs on it: pictures, by number, read once."""

    def __init__(self, path, notes):
        self.path, self.notes = path, notes
        self.json, self.chunks = read_document(path)
        self._pictures, self._textures = {}, {}

    def _uri(self, uri):
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            return base64.b64decode(body) if head.endswith(";base64") else urllib.parse.unquote_to_bytes(body)
        return (self.path.parent / urllib.parse.unquote(uri)).read_bytes()

    def _buffer(self, number):
        buffer = self.json["buffers"][number]
        return self._uri(buffer["uri"]) if "uri" in buffer else self.chunks[0][1]

    def picture(self, number):
        """A picture, (H, W, 4) uint8, or None if it cannot be read."""
        if number not in self._pictures:
            image = self.json["images"][number]
            try:
                if "bufferView" in image:
                    view = self.json["bufferViews"][image["bufferView"]]
                    at = view.get("byteOffset", 0)
                    data = self._buffer(view["buffer"])[at : at + view["byteLength"]]
                else:
                    data = self._uri(image["uri"])
                self._pictures[number] = read_picture(data)
            except (OSError, ValueError, KeyError, IndexError):
                what = image.get("name") or image.get("uri", "")[:60] or f"image {number}"
                self.notes.add("pictures that cannot be read, so that only factors are used", what)
                self._pictures[number] = None
        return self._pictures[number]

    def texture(self, info):
        """The `Texture` of a textureInfo, or None."""
        if info is None:
            return None
        texture = self.json["textures"][info["index"]]
        source = texture.get("extensions", {}).get("EXT_texture_webp", {}).get("source", texture.get("source"))
        if source is None:
            self.notes.add("textures in formats that cannot be read", f"texture {info['index']}")
            return None
        sampler = self.json["samplers"][texture["sampler"]] if "sampler" in texture else {}
        wrap = tuple(WRAPS[sampler.get(axis, 10497)] for axis in ("wrapS", "wrapT"))
        image = self.picture(source)
        if image is None:
            return None
        if sampler.get("magFilter") == NEAREST[0]:
            self.notes.add("textures without a filter are filtered here", f"texture {info['index']}")
        if (source, wrap) not in self._textures:
            name = self.json["images"][source].get("name") or f"image {source}"
            self._textures[source, wrap] = texture_of(image, wrap, name)
        return self._textures[source, wrap]

    def mean(self, info, usage, srgb=False):
        """Mean of a map over what uses it: (4,) in [0, 1], or None if there is none. srgb: of linear colours.

        usage: `Usage` of the material; without coordinates the whole picture counts.
        """
        texture = self.texture(info)
        if texture is None:
            return None
        image = texture.image
        if usage is not None and len(usage.uv):
            matrix = uv_matrix(_moved(info))
            uv = usage.uv @ matrix[:, :2].T + matrix[:, 2]
            size = np.array(image.shape[1::-1])
            x, y = np.floor(np.where(np.isfinite(uv), uv % 1.0, 0.0) * size).astype(np.int64).clip(0, size - 1).T
            texels, weight = image[y, x], usage.weight
        else:
            texels = image[:: max(1, image.shape[0] // 128), :: max(1, image.shape[1] // 128)].reshape(-1, 4)
            weight = np.ones(len(texels))
        values = texels / 255.0
        if srgb:
            values[:, :3] = linear(values[:, :3])
        return (values * weight[:, None]).sum(axis=0) / weight.sum()


@dataclass
class Usage:
    """Where a material is used: samples of its coordinates (k, 2), their weights (k,) by area, and the mean length of a ray
    inside its meshes, None if they are not closed."""

    uv: np.ndarray
    weight: np.ndarray
    chord: float | None = None


def usage_of(pieces):
    """`Usage` of triangles: [(triangles (n, 3, 3), uv (n, 3, 2) or None)]."""
    with_uv = [piece for piece in pieces if piece[1] is not None]
    if not with_uv:
        return Usage(np.zeros((0, 2)), np.zeros(0), mean_chord(pieces))
    triangles, uv = (np.concatenate([piece[i] for piece in with_uv]) for i in (0, 1))
    area = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    area = np.where(np.isfinite(area), area, 0.0)
    step = max(1, 4 * len(area) // MAX_SAMPLES)
    uv, area = uv[::step], area[::step]
    inside = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4], [2, 2, 2]]) / 6.0
    points = np.einsum("sc,ncd->nsd", inside, uv).reshape(-1, 2)
    weight = np.repeat(area, 4) if area.sum() > 0.0 else np.ones(len(points))
    return Usage(points, weight, mean_chord(pieces))


def mean_chord(pieces):
    """Mean length of straight lines inside closed meshes, 4 V / S (Cauchy); None if they are not closed."""
    volume = surface = 0.0
    for triangles, _ in pieces:
        t = triangles - triangles.mean(axis=(0, 1))
        normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]) / 2.0
        area = np.linalg.norm(normal, axis=1).sum()
        if not area > 0.0 or np.linalg.norm(normal.sum(axis=0)) > 1e-3 * area:
            return None
        volume += abs(np.einsum("ij,ij->", t[:, 0], normal)) / 3.0
        surface += area
    return 4.0 * volume / surface if surface > 0.0 and volume > 0.0 else None


# ---- materials -------------------------------------------------------------------------------------------------------


def phong_exponent(rough):
    """Exponent of Phong's R.V whose highlight is as wide as that of GGX with alpha = roughness^2.

    Blinn's N.H takes 2 / alpha^2 - 2 (Walter et al. 2007), and R.V a quarter of it, since R turns twice as fast as H.
    """
    return min(max((2.0 / max(rough, 1e-3) ** 4 - 2.0) / 4.0, 1.0), 1024.0)


def highlight(f0, exponent):
    """Specular colour for the normal reflectance f0: energy-conserving (n + 2) / 2, but no channel above 1."""
    f0 = np.asarray(f0, dtype=np.float64)
    return tuple(map(float, f0 * min((exponent + 2.0) / 2.0, 1.0 / max(f0.max(), 1e-6))))


def _moved(info):
    """The KHR_texture_transform of a textureInfo, {} if it has none."""
    return (info or {}).get("extensions", {}).get("KHR_texture_transform", {})


def base_map(source):
    """The textureInfo that becomes a material's texture, or None: its base colour, or what a black one emits."""
    old = source.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness")
    pbr = source.get("pbrMetallicRoughness", {})
    info = pbr.get("baseColorTexture") if old is None else old.get("diffuseTexture")
    base = pbr.get("baseColorFactor", [1, 1, 1]) if old is None else old.get("diffuseFactor", [1, 1, 1])
    if info is None and max(base[:3]) < 0.02 and any(source.get("emissiveFactor", ())):
        return source.get("emissiveTexture")
    return info


def uv_set(source):
    """Number of the set of coordinates that a material's texture uses, or the maps that become means."""
    pbr = source.get("pbrMetallicRoughness", {})
    info = base_map(source) or pbr.get("metallicRoughnessTexture") or {}
    return _moved(info).get("texCoord", info.get("texCoord", 0))


def convert(document, number, usage=None):
    """A material of the file as a `Material`. usage: `Usage` of its maps."""
    source = document.json["materials"][number]
    name = str(source.get("name") or f"material {number}")
    extras = source.get("extras")
    raw = extras.get("bart_fm") if isinstance(extras, dict) else None
    if isinstance(raw, list) and len(raw) == 12:
        return bart_material(name, raw, document.texture(base_map(source)))
    return _phong(document, source, name, _surface(document, source, name, usage), usage)


def _surface(document, source, name, usage):
    """Base colour, texture, metallic, rough, f0 of a material, whichever way it says so."""
    notes, extensions = document.notes, source.get("extensions", {})
    old = extensions.get("KHR_materials_pbrSpecularGlossiness")
    if old is not None:
        factor = old.get("diffuseFactor", [1, 1, 1, 1])
        metallic, rough, f0 = 0.0, 1.0 - old.get("glossinessFactor", 1.0), old.get("specularFactor", [1, 1, 1])
        other = document.mean(old.get("specularGlossinessTexture"), usage, srgb=True)
        if other is not None:
            notes.add("specular-glossiness maps become their mean", name)
            rough, f0 = 1.0 - (1.0 - rough) * float(other[3]), times(f0, other[:3])
    else:
        pbr = source.get("pbrMetallicRoughness", {})
        factor, f0 = pbr.get("baseColorFactor", [1, 1, 1, 1]), None
        metallic, rough = pbr.get("metallicFactor", 1.0), pbr.get("roughnessFactor", 1.0)
        other = document.mean(pbr.get("metallicRoughnessTexture"), usage)
        if other is not None:
            notes.add("metallic-roughness maps become their mean", name)
            rough, metallic = rough * float(other[1]), metallic * float(other[2])
    return {
        "texture": document.texture(base_map(source)),
        "base": tuple(max(float(c), 0.0) for c in factor[:3]),
        "alpha": float(factor[3]),
        "metallic": min(max(float(metallic), 0.0), 1.0),
        "rough": min(max(float(rough), 0.0), 1.0),
        "f0": f0,
    }


def _phong(document, source, name, surface, usage):
    notes, extensions = document.notes, source.get("extensions", {})
    texture, base, metallic, rough = (surface[k] for k in ("texture", "base", "metallic", "rough"))
    for key in ("normalTexture", "occlusionTexture"):
        if key in source:
            notes.add(f"{key.removesuffix('Texture')} maps are not used", name)
    for extension in extensions:
        if extension.startswith(("KHR_materials_", "EXT_")) and extension not in USED:
            notes.add(f"{extension} is not used", name)
    if "KHR_materials_unlit" in extensions:
        material = Material(name, base, (0.0, 0.0, 0.0), texture=texture)
        return _with_alpha(notes, material, source, surface)

    emission = np.clip(np.asarray(source.get("emissiveFactor", (0.0, 0.0, 0.0)), dtype=np.float64), 0.0, None)
    emission = emission * extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    glow = source.get("emissiveTexture")
    if glow is not None and emission.any():
        if (
            base_map(source) is glow
        ):  # all that it shows is its light: the texture multiplies that as the ambient colour
            material = Material(name, times(emission), (0.0, 0.0, 0.0), texture=texture)
            return _with_alpha(notes, material, source, surface)
        mean = document.mean(glow, usage, srgb=True)
        if mean is not None:
            notes.add("emissive maps become their mean", name)
            emission = emission * mean[:3]

    glass = extensions.get("KHR_materials_transmission", {})
    share = float(glass.get("transmissionFactor", 0.0)) * (1.0 - metallic)
    mask = document.mean(glass.get("transmissionTexture"), usage)
    if mask is not None and share:
        notes.add("transmission maps become their mean", name)
        share *= float(mask[0])
    ior = min(max(float(extensions.get("KHR_materials_ior", {}).get("ior", 1.5)) or 1.5, 1.0), 64.0)
    f0 = ((ior - 1.0) / (ior + 1.0)) ** 2 if surface["f0"] is None else np.asarray(surface["f0"], dtype=np.float64)
    mean = document.mean(base_map(source), usage, srgb=True)
    colour = np.asarray(base) * (mean[:3] if mean is not None else 1.0)
    f0 = np.broadcast_to((1.0 - metallic) * f0 + metallic * colour, 3)

    exponent = phong_exponent(rough)
    mirror = (1.0 - rough) ** 2  # share of what a surface reflects that is not scattered
    diffuse = (1.0 - metallic) * (1.0 - share) + ROUGH_METAL * metallic * (1.0 - mirror)
    optics = {}
    if share > 0.0:
        if rough > SMOOTH:
            notes.add("rough glass refracts without blur", name)
        volume = extensions.get("KHR_materials_volume", {})
        thickness = float(volume.get("thicknessFactor", 0.0))
        thick = thickness > 0.0
        deep = document.mean(volume.get("thicknessTexture"), usage)
        thickness *= 1.0 if deep is None else float(deep[1])
        if usage is not None and usage.chord is not None:
            thickness = usage.chord  # rays meet the mesh itself, as KHR_materials_volume has it for ray tracing
        colour = times(base, share, _absorbed(notes, volume, thickness, name) if thick else 1.0)
        reflect = tuple(map(float, f0))
        # Without a volume glass is a thin sheet: it reflects, and what passes goes straight on.
        optics = {"transmit": colour, "ior": ior if thick else 1.0, "reflect": reflect, "fresnel": True}
    elif metallic * mirror >= LEAST_MIRROR:
        tint = texture is not None and metallic > 0.5
        of_metal = np.asarray(base) if tint else f0
        optics = {"reflect": times(of_metal, metallic * mirror), "fresnel": rough <= SMOOTH, "tint_reflection": tint}
    elif rough <= POLISHED and f0.max() >= LEAST_MIRROR:
        optics = {"reflect": tuple(map(float, f0)), "fresnel": True}
    material = make_material(
        *(name, times(base, diffuse), highlight(f0, exponent), exponent, emission), texture=texture, **optics
    )
    return _with_alpha(notes, material, source, surface)


def _absorbed(notes, volume, thickness, name):
    """Transmittance of one of the two surfaces that a ray crosses, for a volume of this thickness."""
    distance = volume.get("attenuationDistance")
    if distance is None or not float(distance) > 0.0:
        return 1.0
    notes.add("absorption in a volume is applied where a ray crosses its surface", name)
    colour = np.asarray(volume.get("attenuationColor", (1.0, 1.0, 1.0)), dtype=np.float64)
    return np.maximum(colour, 1e-6) ** (0.5 * min(thickness / float(distance), 8.0))


def _with_alpha(notes, material, source, surface):
    """The material with the alpha that the file gives it; what is opaque all over becomes so."""
    mode = str(source.get("alphaMode", "OPAQUE")).lower()
    if mode == "opaque":
        return material
    cutoff = min(max(float(source.get("alphaCutoff", 0.5)), 0.0), 1.0)
    alpha = min(max(surface["alpha"], 0.0), 1.0)
    settled = settle_alpha(replace(material, alpha=alpha, alpha_mode=mode, alpha_cutoff=cutoff))
    if settled.alpha_mode != "opaque" and any(material.transmit):
        notes.add(f"alpha mode {mode} of glass is not used", material.name)
        return material
    return settled


def uv_matrix(moved):
    """Matrix (2, 3) of a KHR_texture_transform."""
    (ox, oy), (sx, sy) = moved.get("offset", (0.0, 0.0)), moved.get("scale", (1.0, 1.0))
    c, s = math.cos(moved.get("rotation", 0.0)), math.sin(moved.get("rotation", 0.0))
    return np.array([[c * sx, s * sy, ox], [-s * sx, c * sy, oy]])


# ---- meshes ----------------------------------------------------------------------------------------------------------


def load(path, notes):
    """A glTF or GLB file as `Loaded`. Raises: SceneError for what it needs and we lack; anything for broken files."""
    document = Document(path, notes)
    header = document.json
    _check_extensions(header, path, notes)
    sources = header.get("materials", [])
    placed, used = [], {}
    for mesh, transform in meshes(_read(document, [uv_set(source) for source in sources])):
        triangles, normals, faces = place(mesh, transform)
        name = str(getattr(getattr(mesh.visual, "material", None), "name", None) or "")
        number = int(name) if re.fullmatch(r"\d+", name) else None
        uv, colours = (mesh.vertex_attributes.get(key) for key in (UV, COLOUR))
        uv = corner_uv(_normalised(uv), faces) if uv is not None else None
        colours = _normalised(colours)[:, :3][faces].mean(axis=1) if colours is not None and len(faces) else None
        placed.append((triangles, normals, number, uv, colours))
        if number is not None:
            used.setdefault(number, []).append((triangles, uv))
    materials = {
        i: convert(document, i, usage_of(used[i])) for i in dict.fromkeys(p[2] for p in placed) if i is not None
    }
    parts = []
    for triangles, normals, number, uv, colours in placed:
        material = default_material() if number is None else materials[number]
        part = Part(triangles, normals, [material], np.zeros(len(triangles), np.int32))
        if uv is not None:  # kept even without a texture: a scene file may add one
            matrix = uv_matrix(_moved(base_map(sources[number])) if number is not None else {})
            part.uv = uv @ matrix[:, :2].T + matrix[:, 2]
        if colours is not None:
            part.materials, part.index = tinted_materials(material, colours)
        parts.append(part)
    camera, lights = views(header, notes)
    return Loaded(parts, camera, lights)


def _check_extensions(header, path, notes):
    needed = set(header.get("extensionsRequired", []))
    for name in UNREADABLE:
        if name in needed:
            raise SceneError(f"{path}: its meshes are packed by {name}, which cannot be read; unpack them first")
    for name in sorted(needed | set(header.get("extensionsUsed", []))):
        if name not in USED and not name.startswith("KHR_materials_"):
            notes.add("extensions that are not used", name)
    if header.get("animations") or header.get("skins"):
        notes.add("animations and skins are not used: the meshes stand as they are stored")


def _normalised(values):
    """Numbers of a vertex attribute: integers stand for [0, 1] or [-1, 1]."""
    values = np.asarray(values)
    if values.dtype.kind in "ui":
        return values.astype(np.float64) / np.iinfo(values.dtype).max
    return values.astype(np.float64)


def _read(document, uv_sets):
    """The meshes as trimesh reads them, from a file without what it should leave alone."""
    header = copy.deepcopy(document.json)
    for key in ("images", "textures", "samplers", "animations", "skins"):
        header.pop(key, None)
    if "materials" in header:
        header["materials"] = [{"name": str(i)} for i in range(len(header["materials"]))]
    for mesh in header.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            _prepare(document.notes, primitive, uv_sets, str(mesh.get("name") or "mesh"))
    text = json.dumps(header).encode()
    options = {"resolver": _resolver(document.path)}
    if document.path.suffix.lower() == ".gltf":
        return read_trimesh(io.BytesIO(text), file_type="gltf", **options)
    text += b" " * (-len(text) % 4)
    chunks = b"".join(
        struct.pack("<II", len(body), kind) + body for kind, body in ((JSON_CHUNK, text), *document.chunks)
    )
    return read_trimesh(
        io.BytesIO(struct.pack("<III", MAGIC, 2, 12 + len(chunks)) + chunks), file_type="glb", **options
    )


def _prepare(notes, primitive, uv_sets, name):
    """Rename the attributes of a primitive that we want as they are, and leave out the others."""
    if primitive.get("mode", 4) not in (4, 5):
        notes.add("points, lines and fans are not drawn", name)
    if primitive.get("targets"):
        notes.add("morph targets are not used", name)
    attributes = primitive["attributes"]
    wanted = f"TEXCOORD_{uv_sets[primitive['material']] if 'material' in primitive else 0}"
    kept = {UV: attributes.get(wanted), COLOUR: attributes.get("COLOR_0")}
    for key in [k for k in attributes if k.startswith(("TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_", "TANGENT"))]:
        del attributes[key]
    attributes.update({k: v for k, v in kept.items() if v is not None})


def _resolver(path):
    import trimesh

    return trimesh.resolvers.FilePathResolver(str(path))


# ---- cameras and lights ----------------------------------------------------------------------------------------------


def _node_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    out = np.eye(4)
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)))
    out[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return out


def views(header, notes):
    """First perspective camera, and lights of KHR_lights_punctual, of a glTF file: (Camera or None, [Light])."""
    nodes = header.get("nodes", [])
    defined = header.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    scenes = header.get("scenes") or [{"nodes": range(len(nodes))}]
    camera, found = None, []
    todo = [(i, np.eye(4), 0) for i in reversed(list(scenes[header.get("scene", 0)].get("nodes", [])))]
    while todo:
        index, above, depth = todo.pop()
        if depth > 64 or not 0 <= index < len(nodes):
            continue
        node = nodes[index]
        matrix = above @ _node_matrix(node)
        todo += [(i, matrix, depth + 1) for i in reversed(node.get("children", []))]
        position, forward, up = matrix[:3, 3], -matrix[:3, 2], matrix[:3, 1]
        if "camera" in node and camera is None:
            lens = header["cameras"][node["camera"]].get("perspective")
            if lens:
                fov = math.degrees(lens["yfov"])
                camera = Camera(*(tuple(map(float, v)) for v in (position, position + forward, up)), fov)
        number = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if number is not None:
            found.append((defined[number], position, forward))
    return camera, _lights(found, notes)


def _lights(found, notes):
    """Lights from (definition, position, direction of its rays)."""
    if not found:
        return []
    # Intensities are photometric and scenes differ by orders of magnitude: only colours and their ratio are kept.
    notes.add("intensities of lights are kept as ratios, without their decay over distance")
    if len(found) > MAX_LIGHTS:
        notes.add(f"{len(found)} lights, {MAX_LIGHTS} fit: the others are left out")
    power = max(float(light.get("intensity", 1.0)) for light, _, _ in found) or 1.0
    out = []
    for light, position, forward in found[:MAX_LIGHTS]:
        weight = float(light.get("intensity", 1.0)) / power
        colour = tuple(float(c) * weight for c in light.get("color", (1.0, 1.0, 1.0)))
        if light.get("type") == "directional":
            out.append(Light(tuple(map(float, -forward / np.linalg.norm(forward))), colour, directional=True))
            continue
        if light.get("type") == "spot":
            notes.add("spots shine into all directions", light.get("name"))
        out.append(Light(tuple(map(float, position)), colour))
    return out
