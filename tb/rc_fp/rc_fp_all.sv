// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Test top: every FP unit on the same three operands, each with its own latency.
module rc_fp_all #(
  parameter  int unsigned ExpW    = 7,
  parameter  int unsigned ManW    = 16,
  parameter  int unsigned Latency = 0,              // of all units; 0 gives each its default
  localparam int unsigned W       = 1 + ExpW + ManW,
  localparam int unsigned One     = (Latency == 0) ? 1 : Latency,
  localparam int unsigned Two     = (Latency == 0) ? 2 : Latency,
  localparam int unsigned Five    = (Latency == 0) ? 5 : Latency
) (
  input  logic         clk_i,
  input  logic [W-1:0] a_i,
  input  logic [W-1:0] b_i,
  input  logic [W-1:0] c_i,
  output logic [W-1:0] add_o,
  output logic [W-1:0] add3_o,
  output logic [W-1:0] mul_o,
  output logic [W-1:0] div_o,
  output logic [2:0]   cmp_o,                       // lt, eq, gt
  output logic [W-1:0] sqrt_o,                      // of a, as all below
  output logic [W-1:0] from_sint_o,                 // a as a signed integer of W bits
  output logic [W-1:0] from_ufix_o,                 // a as an unsigned number with 5 fraction bits
  output logic [7:0]   unorm8_o,
  output logic [9:0]   unorm10_o,
  output logic [W-1:0] pow_o,                       // a^b, of FP24 only
  output logic [5:0]   one_o,                       // latency of mul, cmp and the conversions
  output logic [5:0]   two_o,                       // latency of add, add3, div and sqrt
  output logic [5:0]   five_o                       // latency of pow
);
  assign one_o = 6'(One);
  assign two_o = 6'(Two);
  assign five_o = 6'(Five);

  rc_fp_add  #(.ExpW(ExpW), .ManW(ManW), .Latency(Two)) u_add  (.clk_i, .a_i, .b_i, .y_o(add_o));
  rc_fp_add3 #(.ExpW(ExpW), .ManW(ManW), .Latency(Two)) u_add3 (.clk_i, .a_i, .b_i, .c_i, .y_o(add3_o));
  rc_fp_mul  #(.ExpW(ExpW), .ManW(ManW), .Latency(One)) u_mul  (.clk_i, .a_i, .b_i, .y_o(mul_o));
  rc_fp_div  #(.ExpW(ExpW), .ManW(ManW), .Latency(Two)) u_div  (.clk_i, .a_i, .b_i, .y_o(div_o));
  rc_fp_cmp  #(.ExpW(ExpW), .ManW(ManW), .Latency(One)) u_cmp  (
    .clk_i, .a_i, .b_i, .lt_o(cmp_o[2]), .eq_o(cmp_o[1]), .gt_o(cmp_o[0])
  );
  rc_fp_sqrt #(.ExpW(ExpW), .ManW(ManW), .Latency(Two)) u_sqrt (.clk_i, .a_i, .y_o(sqrt_o));
  rc_fp_from_int #(.ExpW(ExpW), .ManW(ManW), .Latency(One), .IntW(W)) u_from_sint (
    .clk_i, .int_i(a_i), .y_o(from_sint_o)
  );
  rc_fp_from_int #(.ExpW(ExpW), .ManW(ManW), .Latency(One), .IntW(W), .FracW(5), .Signed(1'b0)) u_from_ufix (
    .clk_i, .int_i(a_i), .y_o(from_ufix_o)
  );
  rc_fp_to_unorm #(.ExpW(ExpW), .ManW(ManW), .Latency(One), .Bits(8))  u_unorm8  (.clk_i, .a_i, .y_o(unorm8_o));
  rc_fp_to_unorm #(.ExpW(ExpW), .ManW(ManW), .Latency(One), .Bits(10)) u_unorm10 (.clk_i, .a_i, .y_o(unorm10_o));
  if (W == 24 && ManW == 16) begin : gen_pow
    rc_fp_pow #(.Latency(Five)) u_pow (.clk_i, .a_i, .b_i, .y_o(pow_o));
  end else begin : gen_no_pow
    assign pow_o = '0;
  end
endmodule
