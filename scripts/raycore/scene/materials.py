# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Materials of files: colours, pictures, what a mapping has to tell, and how many materials there may be."""

import io
from dataclasses import fields, replace

import numpy as np

from raycore.scene.data import MAX_MATERIALS, Material, Texture, make_material

MAX_COLOURS = 128  # materials that vertex or face colours of one mesh may become
SHOWN_NAMES = 4


class Notes:
    """What could not be mapped: one line for each kind, naming where."""

    def __init__(self):
        self._kinds = {}

    def add(self, kind, name=None):
        """Note a kind of thing, once for each name."""
        names = self._kinds.setdefault(kind, {})
        if name is not None:
            names[str(name)] = True

    def lines(self):
        """The notes as text, in the order in which kinds came up."""
        out = []
        for kind, names in self._kinds.items():
            shown = list(names)[:SHOWN_NAMES]
            more = f" and {len(names) - len(shown)} more" if len(names) > len(shown) else ""
            out.append(f"{kind}: {', '.join(shown)}{more}" if shown else kind)
        return out


# ---- colours ---------------------------------------------------------------------------------------------------------


def linear(srgb):
    """sRGB in [0, 1] to linear."""
    srgb = np.asarray(srgb, dtype=np.float64)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def unit_colour(value):
    """Three numbers from a colour of bytes or of floats."""
    value = np.asarray(value)
    rgb = value[:3].astype(np.float64)
    return rgb / 255.0 if value.dtype.kind in "ui" else rgb


def times(*colours):
    """Product of colours, as a tuple."""
    return tuple(map(float, np.prod(np.broadcast_arrays(*(np.asarray(c, dtype=np.float64) for c in colours)), axis=0)))


def bart_material(name, raw, texture=None):
    """A material of the BART scenes (Lext et al. 2001): the `fm` of their extended NFF, used as it is.

    Twelve numbers: ambient, diffuse and specular colour, shininess, transmittance T, refractive index. As in NFF, the
    specular colour is also the weight of the reflected ray, and T that of the refracted one.
    """
    numbers = [float(x) for x in raw]
    ambient, diffuse, specular = tuple(numbers[0:3]), tuple(numbers[3:6]), tuple(numbers[6:9])
    shine, transmittance, ior = numbers[9:]
    glass = {"transmit": (transmittance,) * 3, "ior": ior or 1.0} if transmittance > 0.0 else {}
    shine = min(max(shine, 0.0), 1024.0)
    return Material(name, ambient, diffuse, specular, shine, reflect=specular, texture=texture, **glass)


# ---- pictures --------------------------------------------------------------------------------------------------------


def read_picture(source):
    """(H, W, 4) uint8 of a picture file: its bytes, a path, or an opened `PIL.Image`. Raises: OSError, ValueError."""
    try:
        return _read_picture(source)
    except OSError:
        raise
    except Exception as error:  # whatever a decoder raises on a broken or enormous file
        raise ValueError(" ".join(str(error).split())[:100] or type(error).__name__) from None


def _read_picture(source):
    from PIL import Image

    if isinstance(source, bytes):
        source = Image.open(io.BytesIO(source))
    elif not isinstance(source, Image.Image):
        source = Image.open(source)
    if source.mode.startswith(("I", "F")):  # 16 bits a channel, which Pillow would cut off
        values = np.asarray(source, dtype=np.float64)
        grey = np.clip(values / (65535.0 if values.max() > 255.0 else 255.0) * 255.0, 0, 255).astype(np.uint8)
        source = Image.fromarray(grey)
    return np.array(source.convert("RGBA"))


def _small(image):
    """Every so many texels of a picture, for means: at most 256 x 256 of them."""
    return image[:: max(1, image.shape[0] // 256), :: max(1, image.shape[1] // 256)]


def mean_colour(image, srgb=True):
    """Mean linear RGB of a picture (H, W, 4) uint8, of its opaque part if it has transparent ones."""
    pixels = _small(image).reshape(-1, 4) / 255.0
    weight = pixels[:, 3] if pixels[:, 3].sum() > 0.0 else np.ones(len(pixels))
    rgb = linear(pixels[:, :3]) if srgb else pixels[:, :3]
    return (rgb * weight[:, None]).sum(axis=0) / weight.sum()


def mean_channels(image):
    """Mean of the four channels as numbers in [0, 1]: of pictures that hold data, not colours."""
    return _small(image).reshape(-1, 4).mean(axis=0) / 255.0


def flatten(material):
    """The material without its texture, which becomes its mean colour and its mean alpha."""
    if material.texture is None:
        return material
    colour = mean_colour(material.texture.image, material.texture.srgb)
    reflect = times(material.reflect, colour) if material.tint_reflection else material.reflect
    return replace(
        material,
        ambient=times(material.ambient, colour),
        diffuse=times(material.diffuse, colour),
        transmit=times(material.transmit, colour),
        reflect=reflect,
        alpha=material.alpha * float(mean_channels(material.texture.image)[3]),
        texture=None,
    )


def settle_alpha(material):
    """The material as opaque if its alpha is 1 (or above the cutoff) everywhere."""
    if material.alpha_mode == "opaque":
        return material
    least = material.alpha
    if material.texture is not None:
        least *= float(material.texture.image[..., 3].min()) / 255.0
    if least >= (material.alpha_cutoff if material.alpha_mode == "mask" else 1.0):
        return replace(material, alpha=1.0, alpha_mode="opaque")
    return material


# ---- many materials --------------------------------------------------------------------------------------------------


def palette(colours, limit=MAX_COLOURS):
    """Colours (N, 3), bytes: (table (M, 3) in [0, 1], index (N,)), coarsened until there are at most `limit`."""
    for shift in range(8):
        coarse = (colours.astype(np.int64) >> shift) << shift
        codes, index = np.unique(coarse @ np.array([65536, 256, 1]), return_inverse=True)
        if codes.size <= limit:
            break
    index = index.reshape(-1)
    return np.stack([np.bincount(index, colours[:, c]) / np.bincount(index) for c in range(3)], axis=1) / 255.0, index


def colour_materials(colours, name):
    """Materials for the sRGB bytes (N, 3) of faces, and the material of each face."""
    table, index = palette(colours)
    return [make_material(f"{name} colour {i}", linear(rgb)) for i, rgb in enumerate(table)], index


def tinted_materials(material, colours):
    """One material with the linear colours (N, 3), in [0, 1], of faces multiplied in, and the material of each face."""
    table, index = palette(np.rint(np.clip(colours, 0.0, 1.0) * 255.0))
    if len(table) == 1 and (table == 1.0).all():
        return [material], index
    return [
        replace(
            material,
            name=f"{material.name} colour {i}",
            ambient=times(material.ambient, c),
            diffuse=times(material.diffuse, c),
            transmit=times(material.transmit, c),
        )
        for i, c in enumerate(table)
    ], index


def merge_materials(materials, face_material, notes=None):
    """Equal materials become one; where more than fit remain, the rarest join the nearest in colour of their kind."""
    keys, remap, merged = {}, np.empty(len(materials), np.int32), []
    for i, m in enumerate(materials):
        key = tuple(getattr(m, f.name) for f in fields(m))
        if key not in keys:
            keys[key] = len(merged)
            merged.append(m)
        remap[i] = keys[key]
    face_material = remap[face_material]
    used = np.unique(face_material)  # a material that no face has takes no place
    if len(merged) > MAX_MATERIALS >= len(used):
        place = np.zeros(len(merged), np.int32)
        place[used] = np.arange(len(used))
        merged, face_material = [merged[i] for i in used], place[face_material]
    if len(merged) > MAX_MATERIALS:
        if notes is not None:
            notes.add(f"{len(merged)} materials, {MAX_MATERIALS} fit: the rarest take the place of the most similar")
        use = np.bincount(face_material, minlength=len(merged))
        kept = np.sort(np.argsort(-use, kind="stable")[:MAX_MATERIALS])
        looks = np.array([_looks(m) for m in merged])
        nearest = ((looks[:, None] - looks[kept][None]) ** 2).sum(axis=2).argmin(axis=1)
        face_material = kept.searchsorted(kept[nearest])[face_material]
        merged = [merged[i] for i in kept]
    return merged, face_material.astype(np.int32)


def _looks(material):
    m = material
    kind = (10.0 * any(m.reflect), 10.0 * (not m.opaque), 10.0 * (m.texture is not None))
    texture = mean_colour(m.texture.image, m.texture.srgb) if m.texture is not None else np.ones(3)
    return (*m.ambient, *(np.asarray(m.diffuse) * texture), *m.specular, *m.emission, *m.reflect, *m.transmit, *kind)


def texture_of(image, wrap=("repeat", "repeat"), name=""):
    """A `Texture` of a picture (H, W, 4)."""
    return Texture(image, *wrap, name=str(name))
