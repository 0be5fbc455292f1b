# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Format SystemVerilog (Verible) and Python (ruff): the files named, or those changed since the last commit.

Alignment that somebody made by hand is kept where the formatters can keep it. Look at the difference before you
commit: a table that is clearer as it was should stay as it was.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from lint import BIN, GENERATED, REPO

VERIBLE = ["--inplace", "--column_limit=120", "--indentation_spaces=2", "--wrap_spaces=4",
           "--port_declarations_indentation=indent", "--formal_parameters_indentation=indent",
           "--named_port_indentation=indent", "--named_parameter_indentation=indent",
           "--assignment_statement_alignment=preserve", "--case_items_alignment=preserve",
           "--class_member_variable_alignment=preserve", "--distribution_items_alignment=preserve",
           "--enum_assignment_statement_alignment=preserve", "--formal_parameters_alignment=preserve",
           "--module_net_variable_alignment=preserve", "--named_parameter_alignment=preserve",
           "--named_port_alignment=preserve", "--port_declarations_alignment=preserve",
           "--struct_union_members_alignment=preserve"]


def changed() -> list[str]:
    """Files that differ from the last commit, new ones included."""
    commands = (["git", "diff", "--name-only", "--diff-filter=d", "HEAD"],
                ["git", "ls-files", "--others", "--exclude-standard"])
    out = [subprocess.run(c, cwd=REPO, capture_output=True, text=True, check=True).stdout for c in commands]
    return sorted({*"\n".join(out).split("\n")} - {""})


def main(argv: list[str]) -> int:
    names = [n for n in argv or changed() if not n.startswith(GENERATED)]
    missing = [n for n in names if not (REPO / n).is_file()]
    if missing:
        print(f"error: no file {', '.join(missing)}", file=sys.stderr)
        return 1
    sv = [n for n in names if Path(n).suffix == ".sv"]
    py = [n for n in names if Path(n).suffix == ".py"]
    code = 0
    if sv:
        code |= subprocess.call([str(BIN / "verible-verilog-format"), *VERIBLE, *sv], cwd=REPO)
    if py:
        code |= subprocess.call([str(BIN / "ruff"), "format", "--no-cache", "--quiet", *py], cwd=REPO)
    print(f"formatted {len(sv)} SystemVerilog and {len(py)} Python files")
    return 1 if code else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
