// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Last phase of the FP units: round to nearest even, then pack. Combinational.
// Overflow gives infinity. Underflow, a biased exponent of zero or less after rounding, gives zero with the result's sign
// (docs/fp.md: subnormals do not exist, and the decision falls after rounding with unbounded exponent).
module rc_fp_round #(
  parameter  int unsigned ExpW  = 7,
  parameter  int unsigned ManW  = 16,
  parameter  int unsigned ExpInW = ExpW + 2,        // bits of the signed, biased exponent
  localparam int unsigned W     = 1 + ExpW + ManW
) (
  input  logic                     sign_i,
  input  logic signed [ExpInW-1:0] exp_i,           // of 1.man_i
  input  logic [ManW-1:0]          man_i,           // fraction; the leading one is implied
  input  logic                     guard_i,         // the bit below man_i
  input  logic                     sticky_i,        // any bit below guard_i
  input  logic                     zero_i,          // the result is an exact zero
  input  logic                     inf_i,           // beats zero_i
  input  logic                     nan_i,           // beats inf_i
  output logic [W-1:0]             y_o
);
  localparam logic [ExpW-1:0] EXP_MAX = '1;

  logic signed [ExpInW-1:0] exp;
  logic [ManW-1:0]          man;
  logic                     up, under, over;

  assign up         = guard_i && (sticky_i || man_i[0]);
  assign {exp, man} = {exp_i, man_i} + (ExpInW + ManW)'(up);   // a carry out of the fraction raises the exponent
  assign under      = exp <= 0;
  assign over       = exp >= $signed(ExpInW'(EXP_MAX));

  always_comb begin
    if (nan_i)                y_o = {1'b0, EXP_MAX, 1'b1, {(ManW - 1) {1'b0}}};
    else if (inf_i)           y_o = {sign_i, EXP_MAX, {ManW{1'b0}}};
    else if (zero_i || under) y_o = {sign_i, {(ExpW + ManW) {1'b0}}};
    else if (over)            y_o = {sign_i, EXP_MAX, {ManW{1'b0}}};
    else                      y_o = {sign_i, exp[ExpW-1:0], man};
  end
endmodule
