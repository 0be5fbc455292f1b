// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Which members of a family a reference belongs to, at up to two planes at once; then one (reference, slot) pair a cycle,
// lower members first. A triangle in a plane of the bins goes to the upper side: bins count it there.
module rc_tbp_bin_class import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; (
  input  logic     clk_i,
  input  logic     rst_ni,
  input  classes_t classes_i,                        // constant during a pass
  input  logic     in_valid_i,
  output logic     in_ready_o,
  input  tri_ref_t in_ref_i,
  output logic     out_valid_o,
  input  logic     out_ready_i,
  output tri_ref_t out_ref_o,
  output slot_t    out_slot_o
);
  logic [2:0] lower, upper;
  for (genvar i = 0; i < 3; i++) begin : gen_cut
    coord_t lo, hi;
    assign lo       = in_ref_i.lo[classes_i.cut[i].axis];
    assign hi       = in_ref_i.hi[classes_i.cut[i].axis];
    assign lower[i] = !classes_i.en[i] || lo < classes_i.cut[i].pos;
    assign upper[i] = classes_i.en[i] && (lo >= classes_i.cut[i].pos || hi > classes_i.cut[i].pos);
  end
  logic [NUM_SLOTS-1:0] members, members_q, rest;
  assign members[0] = lower[0] && lower[1];
  assign members[1] = lower[0] && upper[1];
  assign members[2] = upper[0] && lower[2];
  assign members[3] = upper[0] && upper[2];
  assign rest       = members_q & (members_q - 1'b1);
  assign out_valid_o = members_q != '0;
  assign in_ready_o  = !out_valid_o || (out_ready_i && rest == '0);
  always_comb begin
    out_slot_o = 2'd3;
    for (int s = 2; s >= 0; s--) if (members_q[s]) out_slot_o = slot_t'(s);
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) members_q <= '0;
    else if (in_ready_o) members_q <= in_valid_i ? members : '0;
    else if (out_ready_i) members_q <= rest;
    if (in_ready_o) out_ref_o <= in_ref_i;
  end
endmodule
