# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""The build helper: builds are shared and kept, failures of every kind fail."""
import os
import shutil
from pathlib import Path

import pytest

from raycore import tbutil
from raycore.tbutil import build_verilated, run_cocotb, run_verilated
from raycore.toolchain import ToolchainError

HERE = Path(__file__).parent / "tbutil"
COUNTER = HERE / "rc_counter.sv"


@pytest.fixture(autouse=True)
def cocotb_module(monkeypatch):
    monkeypatch.syspath_prepend(HERE)


@pytest.mark.parametrize("width", [8, 5])
def test_parameters_reach_the_rtl(width):
    run = run_cocotb("rc_counter", [COUNTER], "counter_tests", parameters={"Width": width, "Limit": 25 * (width - 4)},
                     testcase="counts", env={"EXPECT_WIDTH": str(width)})
    assert (run / "results.xml").is_file()


def test_failing_test_fails():
    with pytest.raises(AssertionError, match="1 of 1 cocotb tests failed"):
        run_cocotb("rc_counter", [COUNTER], "counter_tests", testcase="expects_nonsense")


def test_failing_assertion_fails():
    with pytest.raises(AssertionError, match="Limit_A"):
        run_cocotb("rc_counter", [COUNTER], "counter_tests", testcase="goes_past_the_limit")


def test_unknown_testcase_fails():
    with pytest.raises(AssertionError):
        run_cocotb("rc_counter", [COUNTER], "counter_tests", testcase="there_is_no_such_test")


@pytest.mark.parametrize("public", [(), ("rc_counter.inner_q",)])
def test_inner_signals_only_on_request(public):
    run_cocotb("rc_counter", [COUNTER], "counter_tests", testcase="sees_inner", public=public,
               env={"EXPECT_INNER": str(len(public))})


def test_waves(monkeypatch):
    monkeypatch.setenv("WAVES", "1")
    run = run_cocotb("rc_counter", [COUNTER], "counter_tests", testcase="counts", env={"EXPECT_WIDTH": "8"})
    assert (run / "dump.fst").stat().st_size > 100


def test_rebuilt_by_content_only(tmp_path, monkeypatch):
    monkeypatch.setattr(tbutil, "TB_BUILD", tmp_path / "tb")
    source = tmp_path / "rc_counter.sv"
    shutil.copy(COUNTER, source)
    exe = build_verilated("rc_counter", [source], [HERE / "counter_main.cpp"], opt="-O0")
    assert "count 44" in run_verilated(exe, 300 - 256)
    made = exe.stat().st_mtime_ns
    os.utime(source)
    assert build_verilated("rc_counter", [source], [HERE / "counter_main.cpp"], opt="-O0") == exe
    assert exe.stat().st_mtime_ns == made, "rebuilt though only the date changed"
    source.write_text(source.read_text().replace("count_q + 1'b1", "count_q + 2'd2"))
    with pytest.raises(RuntimeError, match="WIDTH"):      # warnings are errors, and say so
        build_verilated("rc_counter", [source], [HERE / "counter_main.cpp"], opt="-O0")
    source.write_text(source.read_text().replace("count_q + 2'd2", "count_q + Width'(2)"))
    exe = build_verilated("rc_counter", [source], [HERE / "counter_main.cpp"], opt="-O0")
    with pytest.raises(AssertionError, match="count 88"):
        run_verilated(exe, 44)


def test_broken_source_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(tbutil, "TB_BUILD", tmp_path / "tb")
    source = tmp_path / "rc_broken.sv"
    source.write_text("module rc_broken; logic a; assign a = nothing; endmodule\n")
    with pytest.raises(ToolchainError, match=r"building rc_broken failed[\s\S]*nothing"):
        build_verilated("rc_broken", [source], [HERE / "counter_main.cpp"])
