# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Textures as the hardware wants them: sizes of powers of two, mip levels, blocks of 64 bytes, records of coordinates.

Formats and formulas are in docs/whitted.md (Texture unit), reasons and precision in docs/texture.md; the unit is
modelled by `raycore.model.texture`.
"""

import math

import numpy as np

from raycore.model import fp24
from raycore.model.texture import (
    BLOCK,
    CLAMP,
    LINEAR64,
    MIP_FRAC_W,
    MIRROR,
    REPEAT,
    SRGB64,
    linear_to_srgb,
)
from raycore.scene import Texture

MAX_LOG2 = 12  # sides of level 0
MAX_BLOCKS = 1 << 26  # tex_base has 26 bits
MIP_MIN, MIP_MAX = -2048, 2047  # mip_t
WRAPS = {"repeat": REPEAT, "mirror": MIRROR, "clamp": CLAMP}

# Columns of a descriptor, as raycore.model.texture takes them; the names are the fields of optics_t.
DESCRIPTOR_COLUMNS = ("tex_base", "log2_w", "log2_h", "levels", "wrap_s", "wrap_t", "rgba5551", "srgb")
# tri_uv_t of rc_pkg as a layout of raycore.image
TRI_UV = (
    *(("u0", 24), ("v0", 24), ("mip", 12)),
    *(("du1", 24), ("dv1", 24), ("zero1", 12)),
    *(("du2", 24), ("dv2", 24), ("zero2", 12)),
    ("zero3", 60),
)


# ---- levels ----------------------------------------------------------------------------------------------------------


def _to_linear(pixels, srgb):
    """(H, W, 4) uint8 to float32 in linear light."""
    out = LINEAR64.astype(np.float32)[pixels]
    if srgb:
        out[..., :3] = SRGB64.astype(np.float32)[pixels[..., :3]]
    return out


def _to_bytes(linear, srgb):
    out = np.clip(linear, 0.0, 1.0)
    if srgb:
        out[..., :3] = linear_to_srgb(out[..., :3])
    return np.rint(out * 255.0).astype(np.uint8)


def _premultiplied(linear):
    out = linear.copy()
    out[..., :3] *= linear[..., 3:]
    return out


def _divided(premultiplied, plain):
    """Colours divided by alpha again; where all is transparent, the colours of `plain`, filtered without alpha."""
    alpha = premultiplied[..., 3:]
    rgb = np.where(alpha > 0.0, premultiplied[..., :3] / np.where(alpha > 0.0, alpha, 1.0), plain[..., :3])
    return np.concatenate((rgb, alpha), axis=-1)


def _halve(x):
    """Mean of 2x2 texels, of 2x1 or 1x2 where a side is 1 already."""
    if x.shape[0] > 1:
        x = (x[0::2] + x[1::2]) / 2
    if x.shape[1] > 1:
        x = (x[:, 0::2] + x[:, 1::2]) / 2
    return x


def _resample(x, size, wrap, axis):
    """x (float) along an axis to `size` samples, by a tent as wide as a sample of the coarser grid; edges by `wrap`."""
    old = x.shape[axis]
    if old == size:
        return x
    scale = old / size
    reach = max(scale, 1.0)
    center = (np.arange(size) + 0.5) * scale - 0.5
    first = np.floor(center - reach).astype(np.int64)
    out, total = 0.0, 0.0
    shape = [1] * x.ndim
    shape[axis] = size
    for tap in range(math.ceil(2 * reach) + 2):
        i = first + tap
        weight = np.maximum(1.0 - np.abs(i - center) / reach, 0.0).astype(x.dtype)
        if wrap == REPEAT:
            i = i % old
        elif wrap == MIRROR:
            i = np.minimum(i % (2 * old), 2 * old - 1 - i % (2 * old))
        else:
            i = np.clip(i, 0, old - 1)
        out = out + np.take(x, i, axis=axis) * weight.reshape(shape)
        total = total + weight
    return out / total.reshape(shape)


def fitting_size(height, width):
    """The size that an image gets: the next powers of two, at most 4096."""
    return tuple(min(1 << (n - 1).bit_length(), 1 << MAX_LOG2) for n in (height, width))


def mip_levels(texture: Texture):
    """All levels of a texture, the largest first, down to 1x1, as a list of (H, W, 4) uint8 arrays.

    Filters run in linear light on colours with alpha multiplied in, and divide by it at the end: the colour of a transparent
    texel, often black, does not bleed into a cut-out's edge. A level comes from the exact one before it, not from its bytes.
    """
    pixels = np.ascontiguousarray(texture.image, dtype=np.uint8)
    height, width = pixels.shape[:2]
    size = fitting_size(height, width)
    plain = _to_linear(pixels, texture.srgb)
    exact = _premultiplied(plain)
    if size != (height, width):
        plain, exact = (
            _resample(_resample(x, size[0], WRAPS[texture.wrap_t], 0), size[1], WRAPS[texture.wrap_s], 1)
            for x in (plain, exact)
        )
        pixels = _to_bytes(_divided(exact, plain), texture.srgb)
    levels = [pixels]
    while levels[-1].shape[:2] != (1, 1):
        plain, exact = _halve(plain), _halve(exact)
        levels.append(_to_bytes(_divided(exact, plain), texture.srgb))
    return levels


# ---- blocks ----------------------------------------------------------------------------------------------------------


def pack_blocks(level, rgba5551):
    """A level, (H, W, 4) uint8, as blocks: (n, 64) uint8, row by row. Places outside a small level are 0."""
    height, width = level.shape[:2]
    wide = 8 if rgba5551 else 4
    if rgba5551:
        c = np.rint(level * (31 / 255)).astype(np.uint16)
        words = c[..., 0] | c[..., 1] << 5 | c[..., 2] << 10 | (level[..., 3] >= 128).astype(np.uint16) << 15
    else:
        words = np.ascontiguousarray(level).view("<u4")[..., 0]
    rows, columns = -(-height // 4), -(-width // wide)
    full = np.zeros((4 * rows, wide * columns), words.dtype.newbyteorder("<"))
    full[:height, :width] = words
    blocks = full.reshape(rows, 4, columns, wide).transpose(0, 2, 1, 3)
    return np.ascontiguousarray(blocks).reshape(rows * columns, -1).view(np.uint8)


def build_textures(textures):
    """The TEX region of a list of `raycore.scene.Texture`.

    Returns: (region, uint8 of whole blocks; descriptors, (N, 10) int64, two columns spare after `DESCRIPTOR_COLUMNS`;
    notes, a list of sentences on images whose size had to be changed).
    Raises: ValueError for what is no image, or more than 4 GB.
    """
    parts, descriptors, notes, at = [], np.zeros((len(textures), 10), np.int64), [], 0
    for row, texture in zip(descriptors, textures):
        shape, name = np.shape(texture.image), texture.name or "texture"
        if len(shape) != 3 or shape[2] != 4 or 0 in shape:
            raise ValueError(f"{name}: an array of shape {shape}, not (height, width, 4)")
        levels = mip_levels(texture)
        height, width = levels[0].shape[:2]
        if (height, width) != shape[:2]:
            notes.append(f"{name}: {shape[1]}x{shape[0]} resampled to {width}x{height}")
        row[:8] = (
            *(at, width.bit_length() - 1, height.bit_length() - 1, len(levels)),
            *(WRAPS[texture.wrap_s], WRAPS[texture.wrap_t], texture.compact, texture.srgb),
        )
        for level in levels:
            parts.append(pack_blocks(level, texture.compact))
            at += len(parts[-1])
        if at > MAX_BLOCKS:
            raise ValueError(f"textures need more than {MAX_BLOCKS * BLOCK >> 30} GB")
    region = np.concatenate(parts).reshape(-1) if parts else np.zeros(0, np.uint8)
    return region, descriptors, notes


# ---- coordinates -------------------------------------------------------------------------------------------------------


def mip_constants(uv, triangles, sizes):
    """64 log2 sqrt(texel area / area) of triangles, (N,) int64, rounded and kept in 12 bits (Park et al. 2011).

    Args: uv (N, 3, 2); triangles (N, 3, 3) in the unit box; sizes (N, 2): width and height of level 0.
    No texel area gives the least number (the finest level), no area 0.
    """
    e1, e2 = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    area = np.linalg.norm(np.cross(e1, e2), axis=1)
    d1, d2 = ((uv[:, i] - uv[:, 0]) * sizes for i in (1, 2))
    texels = np.abs(d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        mip = np.rint((1 << MIP_FRAC_W) / 2 * (np.log2(texels) - np.log2(area)))
    mip = np.where((area > 0.0) & ~np.isnan(mip), mip, 0.0)
    return np.clip(mip, MIP_MIN, MIP_MAX).astype(np.int64)


def shifted(uv, wraps):
    """Coordinates less whole repeats, two of a mirrored texture, that bring their middle next to 0; clamped ones stay.

    Args: uv (N, 3, 2) float64; wraps (N, 2). Returns: (N, 3, 2).
    """
    period = np.array([1.0, 2.0, 0.0, 0.0])[np.asarray(wraps, dtype=np.int64)]
    middle = (uv.min(axis=1) + uv.max(axis=1)) / 2
    shift = period * np.rint(middle / np.where(period > 0.0, period, 1.0))
    return uv - shift[:, None]


def uv_records(uv, triangles, sizes, wraps):
    """Fields of tri_uv_t for N triangles.

    Args: uv (N, 3, 2), v downwards in the image; triangles (N, 3, 3) in the unit box; sizes (N, 2) int: width, height
    of level 0 of each triangle's texture; wraps (N, 2): wrap_s, wrap_t. Coordinates that are not finite count as 0.
    Returns: {field: (N,) unsigned}, for `raycore.image.pack_records` with `TRI_UV`.
    """
    uv = np.asarray(uv, dtype=np.float64)
    uv = np.where(np.isfinite(uv), uv, 0.0)
    mip = mip_constants(uv, np.asarray(triangles, dtype=np.float64), np.asarray(sizes, dtype=np.float64))
    uv = shifted(uv, wraps)
    first = fp24.round_to_fp24(uv[:, 0])
    # Less the rounded first vertex: so the others are met to within one rounding of their own.
    second, third = (fp24.round_to_fp24(uv[:, i] - first) for i in (1, 2))
    fields = {"mip": mip & 0xFFF}
    for name, value in (("0", first), ("1", second), ("2", third)):
        for axis in (0, 1):
            fields[("" if name == "0" else "d") + "uv"[axis] + name] = fp24.to_bits(value[:, axis].copy())
    return fields


def uv_rows(fields):
    """Records as the model takes them, (N, 7) float64: u0 v0 du1 dv1 du2 dv2 mip."""
    columns = [fp24.from_bits(fields[n]) for n in ("u0", "v0", "du1", "dv1", "du2", "dv2")]
    mip = np.asarray(fields["mip"]).astype(np.int64)
    return np.stack([*columns, (mip ^ 0x800) - 0x800], axis=1)


def mip_bias(fov, height):
    """MIP_BIAS of a view: 64 log2 of the angle of a pixel, 2 tan(fov / 2) / height; fov in degrees, of the height."""
    bias = round((1 << MIP_FRAC_W) * math.log2(2.0 * math.tan(math.radians(fov) / 2) / height))
    return min(max(bias, MIP_MIN), MIP_MAX)
