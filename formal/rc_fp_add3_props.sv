// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Proof: the result of rc_fp_add3 does not depend on the order of its operands, and with c = 0 it is that of rc_fp_add.
module rc_fp_add3_props #(
  parameter int unsigned ExpW = 3,
  parameter int unsigned ManW = 1
) (
  input logic                 clk_i,
  input logic [ExpW+ManW:0] a_i,
  input logic [ExpW+ManW:0] b_i,
  input logic [ExpW+ManW:0] c_i
);
  localparam int unsigned W = 1 + ExpW + ManW;

  logic [W-1:0] y, y_swap, y_turn, y_add, c_q;
  logic         valid_q = 1'b0;
  rc_fp_add3 #(.ExpW(ExpW), .ManW(ManW), .Latency(1)) u_add3 (.clk_i, .a_i, .b_i, .c_i, .y_o(y));
  rc_fp_add3 #(.ExpW(ExpW), .ManW(ManW), .Latency(1)) u_swap (.clk_i, .a_i(b_i), .b_i(a_i), .c_i, .y_o(y_swap));
  rc_fp_add3 #(.ExpW(ExpW), .ManW(ManW), .Latency(1)) u_turn (.clk_i, .a_i(b_i), .b_i(c_i), .c_i(a_i), .y_o(y_turn));
  rc_fp_add #(.ExpW(ExpW), .ManW(ManW), .Latency(1)) u_add (.clk_i, .a_i, .b_i, .y_o(y_add));
  always_ff @(posedge clk_i) {valid_q, c_q} <= {1'b1, c_i};

  always_ff @(posedge clk_i) begin
    if (valid_q) begin
      Swap_A: assert (y == y_swap);
      Turn_A: assert (y == y_turn);
      if (c_q[ManW+:ExpW] == '0) Add_A: assert (y[W-2:0] == y_add[W-2:0]);
    end
  end
endmodule
