# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The ground: requirement files, make targets, file lists, hygiene, seeds, and that the checks can fail."""
import os
import re
import subprocess
import sys
from pathlib import Path

import filelist
import pytest
import rtl_coverage

import lint
from raycore.toolchain import REPO, ToolchainError, run, verilator_env

MAKEFILE = (REPO / "Makefile").read_text()


def pins(name):
    """Requirement lines of requirements/<name>.txt, continued lines joined."""
    text = (REPO / "requirements" / f"{name}.txt").read_text().replace("\\\n", " ")
    return [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]


@pytest.mark.parametrize("name", ["render", "dev", "mitsuba", "cluster"])
def test_requirements_are_pinned_with_hashes(name):
    lines = pins(name)
    assert len(lines) > (1 if name == "mitsuba" else 10)
    for line in lines:
        assert re.fullmatch(r"[\w.-]+(\[[\w,]+\])?==\S+(\s+;[^#]*?)?(\s+--hash=sha256:[0-9a-f]{64})+\s*", line), line[:80]


@pytest.mark.parametrize("name", ["render", "dev", "mitsuba", "cluster"])
def test_requirements_name_no_host(name):
    text = (REPO / "requirements" / f"{name}.txt").read_text()
    assert not re.search(r"https?:|--index|--extra-index|--find-links|--trusted-host|@ ", text)


def test_both_sets_agree():
    render, dev = ({re.split(r"==|\s", line)[0].lower(): re.split(r"==|\s", line)[1] for line in pins(n)}
                   for n in ("render", "dev"))
    assert {n: (v, dev[n]) for n, v in render.items() if n in dev and dev[n] != v} == {}


def test_every_pin_of_the_inputs_is_in_the_outputs():
    for name in ("render", "dev", "mitsuba", "cluster"):
        wanted = [s for line in (REPO / f"requirements/{name}.in").read_text().splitlines()
                  if (s := line.split("#")[0].strip()) and not s.startswith("-")]
        have = " ".join(pins(name)).lower()
        for want in wanted:
            assert re.search(rf"(^|\s){re.escape(want.lower())}(==|\s)", have), f"{want}: run `make requirements`"


def test_help_lists_every_target():
    phony = {t for line in re.findall(r"^\.PHONY: (.*)$", MAKEFILE, re.MULTILINE) for t in line.split()}
    shown = subprocess.run(["make", "--no-print-directory", "help"], cwd=REPO, capture_output=True, text=True, check=True)
    listed = set(re.findall(r"^  ([a-z-]+) +\S", shown.stdout, re.MULTILINE))
    assert listed == phony
    assert {"render", "test", "info", "sim", "sim-full", "bench", "lint", "format", "waves", "formal", "synth",
            "coverage", "clean", "distclean", "setup"} <= listed


def test_help_is_the_default():
    assert ".DEFAULT_GOAL := help" in MAKEFILE


def test_targets_whose_program_fails_fail():
    done = subprocess.run(["make", "--no-print-directory", "waves"], cwd=REPO, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "usage: make waves TEST=" in done.stderr


def test_readme_names_only_targets_there_are():
    targets = set(re.findall(r"^([a-z][a-z-]*):", MAKEFILE, re.MULTILINE))
    for doc in ("README.md", "CONTRIBUTING.md"):
        for target in re.findall(r"(?:`|^)make ([a-z][a-z-]*)", (REPO / doc).read_text(), re.MULTILINE):
            assert target in targets, f"{doc}: make {target}"


@pytest.mark.parametrize("doc", sorted(p.relative_to(REPO).as_posix() for p in
                                       [*REPO.glob("*.md"), *(REPO / "docs").rglob("*.md")]))
def test_links_in_documents_lead_somewhere(doc):
    text = re.sub(r"```.*?```", "", (REPO / doc).read_text(), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
        if not re.match(r"[a-z]+:", target):
            assert (REPO / doc).parent.joinpath(target).exists(), f"{doc}: {target}"


def test_file_lists_are_complete():
    assert filelist.problems() == []


def test_file_list_check_finds_a_missing_and_a_doubled_file(monkeypatch, tmp_path):
    lines = filelist.LIST.read_text().splitlines()
    broken = tmp_path / "rc.f"
    broken.write_text("\n".join([*lines[:-1], lines[-2]]) + "\n")
    monkeypatch.setattr(filelist, "LIST", broken)
    text = "\n".join(filelist.problems())
    assert f"lacks {lines[-1]}" in text and f"lists {lines[-2]} twice" in text and "raycore.core differs" in text


def test_packages_come_before_their_users():
    seen: set[str] = set()
    for name in filelist.listed():
        text = filelist.strip_comments((filelist.RTL / name).read_text())
        own = set(re.findall(r"^\s*package\s+(\w+)", text, re.MULTILINE))
        used = {p for p in re.findall(r"\b(\w+_pkg)::", text)} - own
        assert used <= seen, f"{name} uses {used - seen}"
        seen |= own


def test_hygiene():
    assert lint.check_hygiene() == []


SPDX = "// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1\n"


@pytest.mark.parametrize("body, finding", [
    ("module rc_x; endmodule\n", "no SPDX line"),
    (SPDX + "module rc_y; endmodule\n", "expected rc_x alone"),
    (SPDX + "module rc_x; initial a = 1; endmodule\n", "initial block"),
    (SPDX + "module rc_x; `ifdef XILINX\n`endif endmodule\n", "`ifdef"),
    (SPDX + "module rc_x;\t endmodule\n", "tab"),
    (SPDX + "module rc_x; \nendmodule\n", "blank at the end"),
    (SPDX + "module rc_x; endmodule", "no newline at the end"),
    (SPDX + "module rc_x; // verilator lint_off WIDTH\nendmodule\n", "pragma"),
    (SPDX + "// see /" + "home/me/notes\nmodule rc_x; endmodule\n", "absolute path"),
    (SPDX + "module rc_x;\n" + "  logic a;\n" * 300 + "endmodule\n", "the limit is 300"),
])
def test_hygiene_finds(body, finding):
    assert any(finding in line for line in lint.hygiene_of("rtl/prim/rc_x.sv", body))


def test_hygiene_accepts_clean_text():
    body = SPDX + ("// An initial thought, in a real interface: comments are free.\nmodule rc_x;\n"
                   "`ifndef SYNTHESIS\n`endif\nendmodule\n")
    assert lint.hygiene_of("rtl/prim/rc_x.sv", body) == []


def test_seed_is_in_the_header():
    done = subprocess.run([sys.executable, "-m", "pytest", "--collect-only", "tests/test_ground.py"], cwd=REPO,
                          env={**os.environ, "RAYCORE_SEED": "1234"}, capture_output=True, text=True, check=False)
    assert "RAYCORE_SEED=1234" in done.stdout


def test_seed_differs_between_tests_only(seed, request):
    import random
    again = random.Random(f"{os.environ['RAYCORE_SEED']}/{request.node.nodeid}").randrange(1 << 32)
    other = random.Random(f"{os.environ['RAYCORE_SEED']}/elsewhere").randrange(1 << 32)
    assert seed == again != other


def test_toolchain_works_without_ccache(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("OBJCACHE", "ccache")
    env = verilator_env()
    assert "OBJCACHE" not in env
    assert Path(env["VERILATOR_ROOT"], "bin/verilator").is_file()


def test_toolchain_replaces_the_flags_of_an_outer_make(monkeypatch):
    monkeypatch.setenv("MAKEFLAGS", "-j8 --jobserver-auth=3,4")
    monkeypatch.setenv("MAKELEVEL", "1")
    env = verilator_env()
    assert "jobserver" not in env["MAKEFLAGS"] and "CFG_CXXFLAGS_STD" in env["MAKEFLAGS"]
    assert "MAKELEVEL" not in env


def test_toolchain_says_what_failed(tmp_path):
    with pytest.raises(ToolchainError, match=r"a trial failed with exit code 3[\s\S]*some words"):
        run([sys.executable, "-c", "print('some words'); raise SystemExit(3)"], what="a trial", log=tmp_path / "log")
    with pytest.raises(ToolchainError, match="cannot start no-such-tool"):
        run(["no-such-tool"], what="a trial")


def test_coverage_merges_runs(tmp_path, capsys):
    def point(kind, line, comment, lines, count):
        keys = {"f": str(REPO / "rtl/rc_pkg.sv"), "l": line, "n": 3, "page": f"{kind}/rc_x", "o": comment, "S": lines}
        return "C '" + "".join(f"\x01{k}\x02{v}" for k, v in keys.items()) + f"' {count}\n"

    head = "# SystemC::Coverage-3\n"
    (tmp_path / "a.dat").write_text(head + point("v_line", 10, "block", "10-12", 4) + point("v_branch", 11, "if", "11", 0) +
                                    point("v_branch", 13, "if", "13-14", 0) + point("v_toggle", 10, "x:0->1", "", 2))
    (tmp_path / "b.dat").write_text(head + point("v_line", 10, "block", "10-12", 0) + point("v_branch", 13, "if", "13-14", 1) +
                                    point("v_branch", 20, "if", "20", 0) + point("v_toggle", 10, "x:1->0", "", 0))
    args = ["--dir", str(tmp_path), "--lcov", str(tmp_path / "c.info")]
    assert rtl_coverage.main(args) == 0
    assert "lines 5 of 6 (83.3 %), toggles 1 of 2 (50.0 %)" in capsys.readouterr().out
    info = (tmp_path / "c.info").read_text()
    assert "DA:12,4" in info and "DA:14,1" in info and "DA:20,0" in info and "LF:6\nLH:5" in info
    assert rtl_coverage.main([*args, "--min-lines", "90"]) == 1


def test_coverage_reasons_name_functions(tmp_path):
    lines = rtl_coverage.explained()
    text = (REPO / "rtl/fp/rc_fp_sqrt.sv").read_text().splitlines()
    mine = sorted(n for name, n in lines if name == "rtl/fp/rc_fp_sqrt.sv")
    assert "node(" in text[mine[0] - 1] and "endfunction" in text[mine[-1] - 1]
    stale = tmp_path / "coverage.txt"
    stale.write_text("rtl/fp/rc_fp_sqrt.sv: gone: no reason\n")
    with pytest.raises(ValueError, match="no function gone"):
        rtl_coverage.explained(stale)


def test_coverage_without_data_fails(tmp_path, capsys):
    assert rtl_coverage.main(["--dir", str(tmp_path)]) == 1
    assert "no coverage files" in capsys.readouterr().err
