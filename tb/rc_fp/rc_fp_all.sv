// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Test top: every FP unit on the same three operands, all results in the same cycle (MaxLat after their operands).
module rc_fp_all #(
  parameter  int unsigned ExpW = 7,
  parameter  int unsigned ManW = 16,
  parameter  int unsigned Deeper = 0,               // cycles added to every unit's default latency
  localparam int unsigned W    = 1 + ExpW + ManW,
  localparam int unsigned MaxLat = 2 + Deeper
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
  output logic [7:0]   latency_o
);
  logic [W-1:0] mul, from_sint, from_ufix;
  logic [2:0]   cmp;
  logic [7:0]   unorm8;
  logic [9:0]   unorm10;
  assign latency_o = 8'(MaxLat);

  rc_fp_add  #(.ExpW(ExpW), .ManW(ManW), .Latency(2 + Deeper)) u_add  (.clk_i, .a_i, .b_i, .y_o(add_o));
  rc_fp_add3 #(.ExpW(ExpW), .ManW(ManW), .Latency(2 + Deeper)) u_add3 (.clk_i, .a_i, .b_i, .c_i, .y_o(add3_o));
  rc_fp_mul  #(.ExpW(ExpW), .ManW(ManW), .Latency(1 + Deeper)) u_mul  (.clk_i, .a_i, .b_i, .y_o(mul));
  rc_fp_div  #(.ExpW(ExpW), .ManW(ManW), .Latency(2 + Deeper)) u_div  (.clk_i, .a_i, .b_i, .y_o(div_o));
  rc_fp_cmp  #(.ExpW(ExpW), .ManW(ManW), .Latency(1 + Deeper)) u_cmp  (
    .clk_i, .a_i, .b_i, .lt_o(cmp[2]), .eq_o(cmp[1]), .gt_o(cmp[0])
  );
  rc_fp_sqrt #(.ExpW(ExpW), .ManW(ManW), .Latency(2 + Deeper)) u_sqrt (.clk_i, .a_i, .y_o(sqrt_o));
  rc_fp_from_int #(.ExpW(ExpW), .ManW(ManW), .Latency(1 + Deeper), .IntW(W)) u_from_sint (
    .clk_i, .int_i(a_i), .y_o(from_sint)
  );
  rc_fp_from_int #(.ExpW(ExpW), .ManW(ManW), .Latency(1 + Deeper), .IntW(W), .FracW(5), .Signed(1'b0)) u_from_ufix (
    .clk_i, .int_i(a_i), .y_o(from_ufix)
  );
  rc_fp_to_unorm #(.ExpW(ExpW), .ManW(ManW), .Latency(1 + Deeper), .Bits(8))  u_unorm8  (.clk_i, .a_i, .y_o(unorm8));
  rc_fp_to_unorm #(.ExpW(ExpW), .ManW(ManW), .Latency(1 + Deeper), .Bits(10)) u_unorm10 (.clk_i, .a_i, .y_o(unorm10));

  always_ff @(posedge clk_i) begin                  // units of one cycle wait for those of two
    mul_o       <= mul;
    cmp_o       <= cmp;
    from_sint_o <= from_sint;
    from_ufix_o <= from_ufix;
    unorm8_o    <= unorm8;
    unorm10_o   <= unorm10;
  end
endmodule
