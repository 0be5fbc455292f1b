# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Our pictures beside those of an independent renderer, Mitsuba 3: `python -m raycore.mitsuba SCENE -o DIR`.

Mitsuba is given the scene with its nearest materials. `whitted` lets it find the hits, interpolate normals, filter textures,
refract, reflect and evaluate its own BSDFs, and follows rays as docs/whitted.md says; `path` is its own path tracer. Written are
the scene for Mitsuba, both pictures and the pair of them. docs/pictures.md says what differs by construction.
"""

import argparse
import hashlib
import math
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from raycore.errors import RayCoreError
from raycore.scene import default_camera, default_lights, load_scene

THRESHOLD = 1.0 / 256.0  # rays of less weight are not traced
LEAVE = 1e-4  # of the scene: how far a ray starts from the surface that it leaves


# ---- conversion ------------------------------------------------------------------------------------------------------


def _rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def encode(linear):
    """Linear light to sRGB bytes."""
    x = np.clip(linear, 0.0, 1.0)
    x = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)
    return np.round(255.0 * x).astype(np.uint8)


def _decode(srgb):
    """sRGB bytes to linear light."""
    x = srgb / 255.0
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def _picture(texture, folder, channel="colour", scale=1.0):
    """A texture for Mitsuba: its colours times a number, or its alpha, as a file."""
    colour, raw = channel == "colour", channel != "colour" or not texture.srgb
    pixels = np.ascontiguousarray(texture.image[..., :3] if colour else texture.image[..., 3])
    if scale != 1.0:
        pixels = np.round(pixels * scale).astype(np.uint8) if raw else encode(_decode(pixels) * scale)
    name = "".join(c if c.isalnum() else "_" for c in texture.name) or "texture"
    digest = hashlib.sha256(pixels.tobytes()).hexdigest()[:8]  # names need not differ, pictures do
    path = folder / f"{name}-{digest}.png"
    Image.fromarray(pixels).save(path)
    # Mitsuba has one way to wrap for both directions: that of u.
    return {"type": "bitmap", "filename": str(path), "wrap_mode": texture.wrap_s, "raw": raw}


def _reflectance(material, folder):
    """The diffuse colour times the texture. Of a textured material's colour only its mean counts."""
    if material.texture is None or not any(material.diffuse):
        return _rgb(np.clip(material.diffuse, 0.0, 1.0))
    return _picture(material.texture, folder, scale=float(np.clip(np.mean(material.diffuse), 0.0, 1.0)))


def dull(material, folder):
    """What a light sees of a material: Lambert, and a rough conductor whose highlight is as high and wide as Phong's."""
    diffuse = {"type": "diffuse", "reflectance": _reflectance(material, folder)}
    if not any(material.specular):
        return [diffuse]
    alpha2 = 2.0 / (4.0 * material.shininess + 2.0)
    shine = {"type": "roughconductor", "material": "none", "distribution": "beckmann", "alpha": math.sqrt(alpha2)}
    return [
        diffuse,
        {**shine, "specular_reflectance": _rgb(np.minimum(4.0 * alpha2 * np.array(material.specular), 1.0))},
    ]


def polished(material):
    """What reflects or refracts, or None."""
    if any(material.transmit):
        clear = {"type": "dielectric", "int_ior": float(material.ior), "ext_ior": 1.0}
        return {**clear, "specular_transmittance": _rgb(material.transmit)}
    if not any(material.reflect):
        return None
    if material.fresnel:
        root = math.sqrt(min(max(material.reflect), 0.9))
        return {
            "type": "plastic",
            "int_ior": (1.0 + root) / (1.0 - root),
            "ext_ior": 1.0,
            "diffuse_reflectance": _rgb((0, 0, 0)),
        }
    return {"type": "conductor", "material": "none", "specular_reflectance": _rgb(material.reflect)}


def whole(material, folder):
    """One BSDF for the path tracer."""
    parts, mirror = dull(material, folder), polished(material)
    if any(material.transmit):
        out = mirror
    elif mirror is not None and material.fresnel:
        out = {**mirror, "diffuse_reflectance": parts[0]["reflectance"]}
    elif mirror is not None:
        weight = float(max(material.reflect))
        mirror["specular_reflectance"] = _rgb(np.array(material.reflect) / weight)
        out = {"type": "blendbsdf", "weight": weight, "a": parts[0], "b": mirror}
    else:
        out = parts[0]
    if not any(material.transmit):
        out = {"type": "twosided", "inside": out}
    if material.alpha_mode != "opaque":
        opacity = float(material.alpha) if material.texture is None else _picture(material.texture, folder, "alpha")
        out = {"type": "mask", "opacity": opacity, "inside": out}
    return out


def _write_ply(path, triangles, normals, uv):
    """Triangles with vertices of their own, as binary PLY."""
    fields = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]
    rows = np.concatenate((triangles, normals, uv), axis=2).reshape(-1, 8).astype("<f4")
    faces = np.empty(len(triangles), dtype=[("n", "u1"), ("i", "<i4", 3)])
    faces["n"], faces["i"] = 3, np.arange(3 * len(triangles)).reshape(-1, 3)
    head = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(rows)}",
        *(f"property float {f}" for f in fields),
    ]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    path.write_bytes("\n".join(head).encode() + rows.tobytes() + faces.tobytes())


def convert(scene, folder, size, samples, depth):
    """The scene as a dictionary for `mitsuba.load_dict`; meshes and pictures go to the folder."""
    import mitsuba as mi

    camera, lo_hi = default_camera(scene, size[0] / size[1]), scene.bounds
    transform = mi.ScalarTransform4f
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}}
    out = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": depth + 2, "rr_depth": 64},
        "sensor": {
            "type": "perspective",
            "fov": float(camera.fov),
            "fov_axis": "y",
            "near_clip": 1e-3,
            "far_clip": 1e4,
            "to_world": transform().look_at(origin=list(camera.eye), target=list(camera.target), up=list(camera.up)),
            "film": film,
            "sampler": {"type": "independent", "sample_count": samples},
        },
        "background": {"type": "constant", "radiance": _rgb(scene.background)},
    }
    for i, light in enumerate(default_lights(scene, camera)):
        colour = np.pi * np.array(light.colour)  # a colour of ours is what a white wall sends back
        if light.directional:
            out[f"light{i}"] = {
                "type": "directional",
                "direction": [-v for v in light.position],
                "irradiance": _rgb(colour),
            }
        else:
            # Ours falls off as the scene says; Mitsuba's by the square, and is as bright in the middle of the scene.
            d = np.linalg.norm(np.array(light.position) - np.clip(camera.target, *lo_hi))
            att = 1.0 / np.dot(light.attenuation, (1.0, d, d * d))
            out[f"light{i}"] = {
                "type": "point",
                "position": list(light.position),
                "intensity": _rgb(colour * att * d * d),
            }
    uv = np.zeros((len(scene.triangles), 3, 2)) if scene.uv is None else scene.uv
    for i, material in enumerate(scene.materials):
        mine = scene.face_material == i
        if not mine.any():
            continue
        path = folder / f"m{i}.ply"
        _write_ply(path, scene.triangles[mine], scene.normals[mine], uv[mine])
        out[f"m{i}"] = {"type": "ply", "filename": str(path), "bsdf": whole(material, folder)}
        if any(material.emission):
            out[f"m{i}"]["glow"] = {"type": "area", "radiance": _rgb(material.emission)}
    return out


# ---- Whitted ray tracing with Mitsuba's parts ------------------------------------------------------------------------


class Whitted:
    """Follows rays as docs/whitted.md says; geometry, textures and BSDFs are Mitsuba's."""

    def __init__(self, scene, described, folder, depth):
        import mitsuba as mi

        self.mi, self.source, self.depth = mi, scene, depth
        self.lights = default_lights(scene)
        self.scene = mi.load_dict(described, optimize=False)
        self.dull = [[mi.load_dict(part) for part in dull(m, folder)] for m in scene.materials]
        self.polished = [None if (p := polished(m)) is None else mi.load_dict(p) for m in scene.materials]
        self.colour = [
            None if m.texture is None else mi.load_dict(_picture(m.texture, folder)) for m in scene.materials
        ]
        self.alpha = [
            None if m.texture is None else mi.load_dict(_picture(m.texture, folder, "alpha")) for m in scene.materials
        ]
        self.leave = LEAVE * float(np.ptp(scene.bounds, axis=0).max()) / 2.0
        self.contexts = [mi.BSDFContext() for _ in range(3)]
        self.contexts[0].component, self.contexts[1].component = 0, 1

    def hit(self, origin, direction):
        """(hit, number of its material) or (None, 0)."""
        si = self.scene.ray_intersect(self.mi.Ray3f(origin, direction))
        return (si, int(si.shape.id()[1:])) if si.is_valid() else (None, 0)

    def opacity(self, si, i):
        """alpha' of docs/whitted.md."""
        material = self.source.materials[i]
        if material.alpha_mode == "opaque":
            return 1.0
        a = material.alpha * (1.0 if self.alpha[i] is None else self.alpha[i].eval_1(si))
        return a if material.alpha_mode == "blend" else float(a >= material.alpha_cutoff)

    def tint(self, si, i):
        return np.ones(3) if self.colour[i] is None else np.array(self.colour[i].eval(si))

    def through(self, origin, direction, distance):
        """What comes from a light: transparent shadows."""
        share, gone = np.ones(3), 0.0
        while True:
            si, i = self.hit(origin + gone * direction, direction)
            if si is None or gone + si.t >= distance - self.leave:
                return share
            material = self.source.materials[i]
            if any(material.transmit):
                share = share * material.transmit * self.tint(si, i)
            else:
                share = share * (1.0 - self.opacity(si, i))
            gone += si.t + self.leave
            if share.max() <= THRESHOLD:
                return np.zeros(3)

    def lit(self, si, i, p, normal):
        """Light that a hit point sends back along the ray."""
        total = np.zeros(3)
        for light in self.lights:
            to = np.array(light.position) - (0.0 if light.directional else p)
            distance = 1e30 if light.directional else np.linalg.norm(to)
            direction = to / np.linalg.norm(to)
            if direction @ normal <= 0.0:
                continue
            wo = si.to_local(self.mi.Vector3f(direction))
            seen = sum(np.array(part.eval(self.contexts[2], si, wo)) for part in self.dull[i])
            if seen.max() <= 0.0:
                continue
            c, l, q = light.attenuation
            att = 1.0 if light.directional else 1.0 / (c + l * distance + q * distance**2)
            total += seen * np.pi * light.colour * att * self.through(p, direction, distance)
        return total

    def trace(self, origin, direction):
        """The colour that a primary ray brings back."""
        total, stack = np.zeros(3), [(np.asarray(origin, dtype=np.float64), direction, np.ones(3), 0)]
        while stack:
            origin, direction, weight, depth = stack.pop()
            si, i = self.hit(origin, direction)
            if si is None:
                total += weight * self.source.background
                continue
            material, normal, p = self.source.materials[i], np.array(si.n), np.array(si.p)
            inside = normal @ direction > 0.0
            if inside:
                normal = -normal
            share = self.opacity(si, i)
            lit = np.add(material.emission, self.tint(si, i) * material.ambient)
            if inside and not any(material.transmit):  # Mitsuba's surfaces have one side, ours have two
                si.sh_frame = self.mi.Frame3f(-si.sh_frame.n)
                si.wi = si.to_local(-self.mi.Vector3f(direction))
            total += weight * share * (lit + self.lit(si, i, p + 0.1 * self.leave * normal, normal))
            if depth >= self.depth:
                continue
            children = []
            if share < 1.0:
                children.append((direction, np.full(3, 1.0 - share), -1.0))
            if self.polished[i] is not None:
                for component in (0, 1) if any(material.transmit) else (0,):
                    sample, value = self.polished[i].sample(self.contexts[component], si, 0.5, [0.5, 0.5])
                    towards = np.array(si.to_world(sample.wo))
                    value = np.array(value)
                    if component == 1:  # radiance grows with the square of the index and shrinks again on the way out
                        value = value * float(sample.eta) ** 2 * self.tint(si, i)
                    children.append((towards, share * value, 1.0 if component == 0 else -1.0))
            for towards, part, side in children:
                if (weight * part).max() > THRESHOLD:
                    stack.append((p + side * self.leave * normal, towards, weight * part, depth + 1))
        return total

    def picture(self, size, samples):
        """(H, W, 3): samples (a square number) in each pixel."""
        camera = default_camera(self.source, size[0] / size[1])
        eye, target, up = (np.array(v, dtype=np.float64) for v in (camera.eye, camera.target, camera.up))
        ahead = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(ahead, up)
        right /= np.linalg.norm(right)
        top, tangent, grid = np.cross(right, ahead), math.tan(math.radians(camera.fov) / 2.0), math.isqrt(samples)
        out = np.zeros((size[1], size[0], 3))
        for y in range(size[1]):
            for x in range(size[0]):
                for s in range(grid * grid):
                    px = 2.0 * (x + (s % grid + 0.5) / grid) / size[0] - 1.0
                    py = 1.0 - 2.0 * (y + (s // grid + 0.5) / grid) / size[1]
                    d = ahead + tangent * (py * top + px * size[0] / size[1] * right)
                    out[y, x] += np.minimum(self.trace(eye, d / np.linalg.norm(d)), 1.0)
            if sys.stderr.isatty():
                print(f"\rline {y + 1} of {size[1]} ", end="\r", file=sys.stderr, flush=True)
        return out / grid**2


# ---- command ---------------------------------------------------------------------------------------------------------


def ours(scene, size, depth, engine):
    """Our picture (H, W, 3), linear, of 10 bits a channel."""
    from raycore.image import View, build_geometry, build_image
    from raycore.model.pixbuf import RGB10A2, unpack
    from raycore.render import render

    image = build_image(build_geometry(scene), View(*size, fb_format=RGB10A2, max_depth=depth))
    return unpack(render(image, engine).pixels, RGB10A2) / 1023.0


def compare(name, folder, size, samples, integrator, engine):
    """Render one scene by both; returns the mean difference of the pictures and writes them side by side."""
    try:
        import mitsuba as mi
    except ImportError:
        raise RayCoreError("Mitsuba 3 is not installed; `make compare` installs it") from None
    mi.set_variant("scalar_rgb")
    scene = load_scene(name)
    depth = 10 if scene.depth is None else scene.depth
    folder.mkdir(parents=True, exist_ok=True)
    described = convert(scene, folder, size, samples, depth)
    state = mi.parser.parse_dict(mi.parser.ParserConfig(mi.variant()), described)
    mi.parser.write_file(state, str(folder / "scene.xml"))
    if integrator == "path":
        theirs = np.array(mi.render(mi.load_dict(described, optimize=False)))[..., :3]
    else:
        theirs = Whitted(scene, described, folder, depth).picture(size, samples)
    mine = ours(scene, size, depth, engine)
    Image.fromarray(encode(theirs)).save(folder / "mitsuba.png")
    Image.fromarray(encode(mine)).save(folder / "ours.png")
    pair = np.concatenate((encode(mine), np.full((size[1], 4, 3), 255, np.uint8), encode(theirs)), axis=1)
    Image.fromarray(pair).save(folder / "pair.png")
    return float(np.abs(mine - np.clip(theirs, 0.0, 1.0)).mean())


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m raycore.mitsuba", description=__doc__.split("\n\n")[0])
    parser.add_argument("scene", help="as for `raycore render`")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="where everything is written")
    parser.add_argument("--size", default="320x192", help="width x height")
    parser.add_argument("--samples", type=int, help="of Mitsuba, in each pixel (whitted: 4, path: 256)")
    parser.add_argument("--integrator", choices=("whitted", "path"), default="whitted")
    parser.add_argument("--engine", choices=("rtl", "model", "double"), default="double", help="of our picture")
    given = parser.parse_args(arguments)
    try:
        size = tuple(int(n) for n in given.size.lower().split("x"))
        if len(size) != 2 or min(size) < 1:
            raise ValueError
    except ValueError:
        parser.error(f"--size {given.size}: expected WxH")
    samples = given.samples or (4 if given.integrator == "whitted" else 256)
    try:
        difference = compare(given.scene, given.output, size, samples, given.integrator, given.engine)
    except RayCoreError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(f"{given.output / 'pair.png'}: ours, Mitsuba; mean difference {difference:.4f} of full scale")
    return 0


if __name__ == "__main__":
    sys.exit(main())
