# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The benchmark on small pictures: what it prints, and that its report is whole and needs nothing else. No time is measured."""

import json
import re
import subprocess
import sys
from html.parser import HTMLParser

import pytest

from raycore import report
from raycore.toolchain import REPO


class Page(HTMLParser):
    """Tags in order, the sources of pictures, text; what is open must be closed."""

    VOID = ("meta", "img", "br")

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.sources, self.links, self.text = [], [], [], [], ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        attrs = dict(attrs)
        self.sources += [attrs["src"]] if "src" in attrs else []
        self.links += [attrs["href"]] if "href" in attrs else []
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def test_report_is_self_contained(tmp_path):
    """A run of two small frames: all tables on the terminal and in the page, four pictures a frame, nothing from a network."""
    done = subprocess.run(
        [sys.executable, "-m", "raycore.bench", "--sizes", "40x24", "--whitted", "--primary", "tiny", "--trees"]
        + ["--output", str(tmp_path)],
        cwd=REPO, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "(Table I)" in done.stdout and "Table III" in done.stdout and "Table IV" not in done.stdout
    frames = json.loads((tmp_path / "bench.json").read_text())
    assert list(frames) == ["tiny, 40x24, primary", "tiny, 40x24, primary + shadow"]

    text = (tmp_path / "bench.html").read_text()
    page = Page(text)
    assert not page.links and "script" not in page.tags and "link" not in page.tags
    assert not re.search(r"https?://|@import|url\(", text)
    assert len(page.sources) == 2 * 4 + 2 and all(s.startswith("data:image/png;base64,iVBOR") for s in page.sources)
    assert page.text.count("0 pixels differ") == 2
    rate = frames["tiny, 40x24, primary + shadow"]["rays_per_cycle_per_rtu"]
    assert f"{rate:.4f}" in page.text and f"{rate:.4f}" in done.stdout
    for word in ("commit", "Verilator", "latency 60", "L1 node/TriAccel caches", "square root", "where the slots go"):
        assert word in page.text


def test_text_is_escaped():
    table = report.Lines("<b> & co", ("a", "b"))
    table.add_row("<i>", "2", style="dim")
    table.add_row("x")
    page = Page(report.html("t", {"k": "<u>"}, [report.Section("<s>", "&", tables=[table])]))
    assert not {"b", "i", "u", "s"} & set(page.tags) and "<b> & co" in page.text and "<i>" in page.text
    assert table.rows[1] == (["x", ""], None) and table.rich().row_count == 2


def test_commit_outside_git(monkeypatch, tmp_path):
    monkeypatch.setattr(report, "REPO", tmp_path)
    assert report.commit() == "unknown"
    monkeypatch.setattr(report, "REPO", REPO)
    assert re.match(r"[0-9a-f]{40}|unknown", report.commit())


@pytest.mark.parametrize("sizes", ["40", "ax24"])
def test_wrong_sizes(sizes, tmp_path):
    done = subprocess.run([sys.executable, "-m", "raycore.bench", "--sizes", sizes, "--output", str(tmp_path)],
                          cwd=REPO, capture_output=True, text=True, check=False)  # fmt: skip
    assert done.returncode == 1 and "--sizes" in done.stderr and not list(tmp_path.iterdir())
