# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What commands share: files that appear whole or not at all, and lines for people."""

import contextlib
import io
import json
import os
import tempfile
from pathlib import Path

from rich.table import Table

from raycore.errors import OutputError


def claim(path, option):
    """Refuse a path that cannot be written, before anything long begins."""
    if path is None:
        return
    if path.is_dir():
        raise OutputError(f"{option} {path}: is a directory; give a file name")
    folder = path.parent
    if not folder.is_dir():
        raise OutputError(f"{option} {path}: the folder {folder} does not exist; make it first")
    try:
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".raycore-"):
            pass
    except OSError as error:
        raise OutputError(f"{option} {path}: cannot be written ({error.strerror})") from None


def write(path, data):
    """Write a file whole or not at all."""
    part = None
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".raycore-", delete=False) as stream:
            part = Path(stream.name)
            stream.write(data)
        umask = os.umask(0)
        os.umask(umask)
        part.chmod(0o666 & ~umask)
        part.replace(path)
    except OSError as error:
        if part is not None:
            part.unlink(missing_ok=True)
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from None


def png(rgb, srgb=False):
    """A picture (H, W, 3) as PNG; srgb: it says that it is meant so."""
    from PIL import Image, PngImagePlugin

    info = PngImagePlugin.PngInfo()
    if srgb:
        info.add(b"sRGB", b"\0")
    out = io.BytesIO()
    Image.fromarray(rgb).save(out, format="PNG", pnginfo=info)
    return out.getvalue()


def encode_srgb(rgb10):
    """Linear channels of 10 bits to sRGB of 8: (H, W, 3) uint8."""
    import numpy as np

    linear = np.arange(1024) / 1023.0
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.rint(255.0 * curve).astype(np.uint8)[rgb10]


def npz(arrays):
    """Arrays by name as a compressed NPZ file."""
    import numpy as np

    out = io.BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


def as_json(values):
    """JSON for people too."""
    return (json.dumps(values, indent=2) + "\n").encode()


def table(rows):
    """Rows of text, aligned."""
    out = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    out.add_column(no_wrap=True)
    for _ in range(max(map(len, rows)) - 1):
        out.add_column(overflow="fold")
    for row in rows:
        out.add_row(*map(str, row))
    return out


def status(console, text):
    """A line that says what is going on, on a terminal only."""
    return console.status(text) if console.is_terminal else contextlib.nullcontext()
