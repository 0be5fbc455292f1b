// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Comparison of a and b (paper Table I, "Comparator"): exactly one output is set, or none if an operand is NaN.
// -0 equals +0. All registers stand at the output.
module rc_fp_cmp #(
  parameter  int unsigned ExpW    = 7,
  parameter  int unsigned ManW    = 16,
  parameter  int unsigned Latency = 1,              // cycles, at least 1
  localparam int unsigned W       = 1 + ExpW + ManW
) (
  input  logic         clk_i,
  input  logic [W-1:0] a_i,
  input  logic [W-1:0] b_i,
  output logic         lt_o,
  output logic         eq_o,
  output logic         gt_o
);
  logic a_zero, b_zero, nan, mag_lt, mag_eq, lt, eq;

  assign a_zero = a_i[ManW+:ExpW] == '0;
  assign b_zero = b_i[ManW+:ExpW] == '0;
  assign nan    = ((&a_i[ManW+:ExpW]) && (a_i[ManW-1:0] != '0)) || ((&b_i[ManW+:ExpW]) && (b_i[ManW-1:0] != '0));
  assign mag_lt = a_i[W-2:0] < b_i[W-2:0];
  assign mag_eq = a_i[W-2:0] == b_i[W-2:0];
  assign eq     = (a_zero && b_zero) || (mag_eq && (a_i[W-1] == b_i[W-1]));
  assign lt     = (a_i[W-1] && !b_i[W-1]) || ((a_i[W-1] == b_i[W-1]) && (mag_lt != a_i[W-1]));   // unless equal
  rc_fp_pipe #(.Width(3), .Stages(Latency)) u_p1 (
    .clk_i, .d_i({!nan && lt && !eq, !nan && eq, !nan && !lt && !eq}), .q_o({lt_o, eq_o, gt_o})
  );
endmodule
