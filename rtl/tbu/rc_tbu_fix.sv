// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// FP24 coordinate to fixed point, combinational: x = +-mag 2^-17. bad_o: no multiple of 2^-17 within (-1, 1).
module rc_tbu_fix import rc_pkg::*; (
  input  fp_t               x_i,
  output logic              neg_o,
  output logic [FP_MAN_W:0] mag_o,
  output logic              bad_o
);
  localparam int unsigned TOP = 62;                  // exponent of numbers in [0.5, 1): 2^17 x = significand
  logic [FP_EXP_W-1:0] e, right;
  logic [FP_MAN_W:0]   sig, lost;
  assign e     = x_i[FP_MAN_W +: FP_EXP_W];
  assign sig   = (e == '0) ? '0 : {1'b1, x_i[FP_MAN_W-1:0]};
  assign right = FP_EXP_W'(TOP) - e;
  assign lost  = sig & ~({(FP_MAN_W + 1) {1'b1}} << right);
  assign mag_o = sig >> right;
  assign neg_o = x_i[FP_W-1];
  assign bad_o = lost != '0;                         // right wraps for larger numbers, and all is lost
endmodule
