# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The order of pixels (paper Sec. 3.3 and 4.1) and the formats of the frame buffer, as in docs/seams.md."""

import numpy as np

from . import fp24

RGBA8, RGB10A2 = 0, 1  # FB_FORMAT

BLOCK = 8  # pixels a side of a block, the work that is handed to an RTU
TILE = 2  # blocks a side of a tile

# Paper Sec. 3.3: from the counter i5 i4 i3 i2 i1 i0, x = i5 i3 i1 and y = i4 i2 i0.
_I = np.arange(BLOCK * BLOCK)
MORTON_X = (_I >> 3 & 4) | (_I >> 2 & 2) | (_I >> 1 & 1)
MORTON_Y = (_I >> 2 & 4) | (_I >> 1 & 2) | (_I & 1)


def block_order(width, height):
    """Blocks in the order in which the dispatcher hands them out.

    Args: width, height: pixels. Returns: (blocks, 2) int array of x, y in blocks.
    """
    across, down = -(-width // BLOCK), -(-height // BLOCK)
    order = [
        (tx + (i >> 1), ty + (i & 1))
        for ty in range(0, down, TILE)
        for tx in range(0, across, TILE)
        for i in range(TILE * TILE)
        if tx + (i >> 1) < across and ty + (i & 1) < down
    ]
    return np.array(order, dtype=np.int64).reshape(-1, 2)


def pixel_order(width, height):
    """Pixels in the order in which one RTU starts their primary rays: (width * height, 2) int array of x, y."""
    corner = block_order(width, height) * BLOCK
    x = (corner[:, :1] + MORTON_X).reshape(-1)
    y = (corner[:, 1:] + MORTON_Y).reshape(-1)
    inside = (x < width) & (y < height)
    return np.stack([x[inside], y[inside]], axis=1)


def pack(rgb, fb_format=RGBA8):
    """Colours to pixels of 32 bits.

    Args: rgb: (..., 3) FP24 values, 1 is white; clamped, NaN is 0. fb_format: RGBA8 (red in the lowest byte, alpha 255)
        or RGB10A2 (red in the low ten bits, alpha 3).
    Returns: (...) uint32.
    Raises: ValueError for another format.
    """
    if fb_format not in (RGBA8, RGB10A2):
        raise ValueError(f"frame buffer format {fb_format} is neither RGBA8 nor RGB10A2")
    bits, alpha = (8, 255 << 24) if fb_format == RGBA8 else (10, 3 << 30)
    channel = fp24.unorm(np.asarray(rgb, dtype=np.float64), bits).astype(np.uint32)
    red, green, blue = (channel[..., i] << np.uint32(i * bits) for i in range(3))
    return red | green | blue | np.uint32(alpha)


def unpack(pixels, fb_format=RGBA8):
    """The colours of pixels: (...) uint32 to (..., 3) integers of 8 or 10 bits, in uint16.

    Raises: ValueError for a format that is neither RGBA8 nor RGB10A2.
    """
    if fb_format not in (RGBA8, RGB10A2):
        raise ValueError(f"frame buffer format {fb_format} is neither RGBA8 nor RGB10A2")
    bits = 8 if fb_format == RGBA8 else 10
    pixels = np.asarray(pixels, dtype=np.uint32)
    shifts = np.array([0, bits, 2 * bits], dtype=np.uint32)
    return (pixels[..., None] >> shifts & np.uint32((1 << bits) - 1)).astype(np.uint16)
