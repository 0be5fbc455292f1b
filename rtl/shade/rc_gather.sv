// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Collects a vector whose x, y, z arrive at times From, From + 1, From + 2 of a job: vec_o holds it at time To.
module rc_gather import rc_pkg::*; #(
  parameter int unsigned From = 0,     // cycles
  parameter int unsigned To   = 2      // cycles, not before From + 2
) (
  input  logic  clk_i,
  input  fp_t   in_i,
  output vec3_t vec_o
);
  fp_t newest, middle_q, oldest_q;
  rc_carry #(.Width(FP_W), .From(From + 2), .To(To)) u_carry (.clk_i, .in_i, .out_o(newest));
  always_ff @(posedge clk_i) {oldest_q, middle_q} <= {middle_q, newest};
  assign vec_o = {newest, middle_q, oldest_q};
endmodule
