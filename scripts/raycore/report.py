# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Results as one HTML file that needs nothing else: tables, pictures and plots in it, no reference to a network."""

import base64
import io
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from rich.table import Table

from raycore.toolchain import REPO


@dataclass
class Lines:
    """A table for the terminal and for the report. Rows are (cells, style), style "dim" or "bold" or None."""

    title: str
    columns: tuple
    left: int = 1  # columns of text; the rest are numbers
    rows: list = field(default_factory=list)

    def add_row(self, *cells, style=None):
        """Add a row of text; cells that are missing are empty."""
        self.rows.append(([*cells, *[""] * (len(self.columns) - len(cells))], style))

    def rich(self):
        """The table for a terminal."""
        table = Table(title=self.title)
        for i, column in enumerate(self.columns):
            table.add_column(column, justify="left" if i < self.left else "right")
        for cells, style in self.rows:
            table.add_row(*cells, style=style)
        return table


def from_rich(table):
    """The same table as `Lines`. table: a rich table of plain text."""
    left = sum(column.justify == "left" for column in table.columns[:1])
    out = Lines(str(table.title or ""), tuple(str(column.header) for column in table.columns), left)
    for cells in zip(*(column.cells for column in table.columns)):
        out.add_row(*map(str, cells))
    return out


@dataclass
class Picture:
    """A PNG with what it shows."""

    caption: str
    png: bytes
    pixelated: bool = False  # every pixel counts: no smoothing

    @property
    def uri(self):
        """The PNG as a data URI."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode()


@dataclass
class Section:
    """A heading with what stands below it."""

    title: str
    text: str = ""
    tables: list = field(default_factory=list)
    rows: list = field(default_factory=list)  # of pictures side by side: [(heading, [Picture])]


def png(rgb):
    """(H, W, 3) uint8 as PNG."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(rgb).save(out, format="PNG")
    return out.getvalue()


def commit():
    """The commit of this checkout, and if it was changed since; "unknown" outside git."""

    def git(*args):
        return subprocess.run(["git", *args], cwd=REPO, capture_output=True, text=True, check=True).stdout.strip()

    try:
        return git("rev-parse", "HEAD") + (", with changes" if git("status", "--porcelain", "--untracked-files=no") else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def html(title, facts, sections):
    """The report as text. facts: {what: value} at its head; sections: of `Section`.

    Raises: ToolchainError without jinja2.
    """
    try:
        import jinja2
    except ImportError:
        from raycore.toolchain import ToolchainError

        raise ToolchainError("the report needs jinja2: run `make setup`") from None
    env = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    template = env.from_string(Path(__file__).with_name("report.html.j2").read_text())
    return template.render(title=title, facts=facts, sections=sections)
