# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Proofs by sby of who starts next in the shading unit: lights, lights again, bounces."""

import pytest
from test_formal import prove

FILES = ["rc_pkg.sv", "shade/rc_shade_pkg.sv", "prim/rc_rr_arb.sv", "shade/rc_shade_start.sv"]


def test_nobody_waits_for_ever():
    """One starts at a time, one whenever one can, and each within its fourth chance, a bounce within its second; for any length of
    time."""
    status, folder = prove("start", "rc_shade_start_props", FILES, "abc pdr", mode="prove")
    assert status == "PASS", f"trace in {folder}"


@pytest.mark.parametrize("wrong", ["NextInTime_A"])
def test_a_tighter_bound_fails(wrong, tmp_path, monkeypatch):
    """The proof can fail: a light may miss three chances, so two are refuted."""
    import test_formal

    text = (test_formal.HERE / "rc_shade_start_props.sv").read_text()
    tight = text.replace("next_missed_q <= 3'd3", "next_missed_q <= 3'd2")
    assert tight != text
    (tmp_path / "rc_shade_start_props.sv").write_text(tight)
    monkeypatch.setattr(test_formal, "HERE", tmp_path)
    (tmp_path / "yosys.py").write_text((test_formal.REPO / "formal" / "yosys.py").read_text())
    status, _ = prove("start_wrong", "rc_shade_start_props", FILES, "smtbmc yices", mode="bmc", depth=12)
    assert status == "FAIL"
