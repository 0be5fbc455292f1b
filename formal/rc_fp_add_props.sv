// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Proof: rc_fp_add commutes, a + b = -(-a - b) but for a sum of zero, and x + 0 = x.
module rc_fp_add_props #(
  parameter int unsigned ExpW = 7,
  parameter int unsigned ManW = 16
) (
  input logic                 clk_i,
  input logic [ExpW+ManW:0] a_i,
  input logic [ExpW+ManW:0] b_i
);
  localparam int unsigned W = 1 + ExpW + ManW;
  localparam logic [W-1:0] SIGN = {1'b1, {(W - 1) {1'b0}}};

  logic [W-1:0] y, y_swap, y_neg, a_q, b_q;
  logic         valid_q = 1'b0, nan, zero;
  rc_fp_add #(.ExpW(ExpW), .ManW(ManW), .Latency(1)) u_add (.clk_i, .a_i, .b_i, .y_o(y));
  rc_fp_add #(.ExpW(ExpW), .ManW(ManW), .Latency(1)) u_swap (.clk_i, .a_i(b_i), .b_i(a_i), .y_o(y_swap));
  rc_fp_add #(.ExpW(ExpW), .ManW(ManW), .Latency(1)) u_neg (.clk_i, .a_i(a_i ^ SIGN), .b_i(b_i ^ SIGN), .y_o(y_neg));
  always_ff @(posedge clk_i) {valid_q, a_q, b_q} <= {1'b1, a_i, b_i};
  assign nan  = (&y[ManW+:ExpW]) && (y[ManW-1:0] != '0);
  assign zero = y[ManW+:ExpW] == '0;

  always_ff @(posedge clk_i) begin
    if (valid_q) begin
      Commutes_A: assert (y == y_swap);
      if (!nan && !zero) SignFlips_A: assert (y_neg == (y ^ SIGN));
      if (nan) NanStays_A: assert (y_neg == y && y == {1'b0, {ExpW{1'b1}}, 1'b1, {(ManW - 1) {1'b0}}});
      if (zero) ZeroStays_A: assert (y_neg[W-2:0] == '0 && y[W-2:0] == '0);
      if (b_q[ManW+:ExpW] == '0 && a_q[ManW+:ExpW] != '0 && !nan) Neutral_A: assert (y == a_q);
    end
  end
endmodule
