# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Proofs by sby of the control of secondary rays: stacks have one owner, none is lost or overflows, nothing waits for ever."""

import pytest
from test_formal import prove

# Queues are sets here, which hold for any order of words and have no pointers; tests of queues are elsewhere.
FILES = ["prim/rc_ram_1r1w.sv", "../formal/rc_fifo_bag.sv", "prim/rc_idx_pool.sv", "shade/rc_sec_stack.sv"]
# What parts assume of their inputs is proved, not assumed; before the first reset a memory may do as it likes.
PASSES = ["chformal -assume2assert c:u_dut.* c:u_dut.*.Choice_M %d", "chformal -assert -skip 1 c:u_dut.*"]


def prove_stacks(name, engine, **options):
    return prove(name, "rc_sec_stack_props", FILES, engine, passes=PASSES, **options)


@pytest.mark.parametrize("pixels, stacks, entries", [(2, 1, 4), (2, 2, 4), (4, 1, 2), (4, 2, 2)])
def test_stacks(pixels, stacks, entries):
    """For any length of time (property-directed reachability)."""
    status, folder = prove_stacks(f"stacks_{pixels}_{stacks}_{entries}", "abc pdr", mode="prove", parameters={
        "IdW": pixels.bit_length() - 1, "NumStacks": stacks, "Entries": entries})
    assert status == "PASS", f"trace in {folder}"


def test_rays_come_back():
    """Last in, first out, through the memory of rays: two pixels, two levels, any length of time."""
    parameters = {"IdW": 1, "NumStacks": 1, "Entries": 2, "Data": 1}
    status, folder = prove_stacks("stacks_data", "abc pdr", mode="prove", parameters=parameters)
    assert status == "PASS", f"trace in {folder}"


@pytest.mark.parametrize("wrong, stacks", [(1, 2), (2, 1)])
def test_wrong_property_fails(wrong, stacks):
    """That waiting pixels never start while another has rays on its stack, or that the deepest ray is never pushed, fails."""
    status, folder = prove_stacks(f"stacks_wrong_{wrong}", "abc bmc3", depth=40, parameters={
        "IdW": 1, "NumStacks": stacks, "Entries": 2, "Wrong": wrong})
    assert status == "FAIL"
    assert list(folder.glob("engine_0/trace*.vcd")), "no trace"
