# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Proofs by sby of the control of secondary rays: stacks have one owner, none is lost or overflows, nothing waits for ever."""

import pytest
from test_formal import prove

FILES = ["prim/rc_ram_1r1w.sv", "../formal/rc_fifo_bag.sv", "prim/rc_idx_pool.sv", "shade/rc_sec_stack.sv"]
# What parts assume of their inputs is proved, not assumed; before the first reset a memory may do as it likes.
PASSES = ["chformal -assume2assert c:u_dut.* c:u_dut.*.Choice_M %d", "chformal -assert -skip 1 c:u_dut.*"]


def prove_stacks(name, engine, **options):
    return prove(name, "rc_sec_stack_props", FILES, engine, passes=PASSES, **options)


SIZES = {"2 pixels 1 stack": {"IdW": 1, "NumStacks": 1}}


@pytest.mark.parametrize("size", SIZES)
def test_stacks(size):
    """For any length of time (property-directed reachability)."""
    status, folder = prove_stacks(f"stacks {size}".replace(" ", "_"), "abc pdr", mode="prove", parameters=SIZES[size])
    assert status == "PASS", f"trace in {folder}"
