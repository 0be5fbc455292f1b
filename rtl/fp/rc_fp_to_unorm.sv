// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Float in [0, 1] to an unsigned normalised integer: y = floor(a * (2^Bits - 1) + 1/2), exact. A colour channel.
// Below 0, -0 and NaN give 0; above 1, infinity included, gives 2^Bits - 1.
//   P1  times 2^Bits - 1, that is, shift and subtract
//   P2  shift to the binary point, round half up
// Registers: after P1 from Latency 2, the rest at the output.
module rc_fp_to_unorm #(
  parameter  int unsigned ExpW    = 7,
  parameter  int unsigned ManW    = 16,
  parameter  int unsigned Latency = 1,              // cycles, at least 1
  parameter  int unsigned Bits    = 8,              // of the result
  localparam int unsigned W       = 1 + ExpW + ManW
) (
  input  logic            clk_i,
  input  logic [W-1:0]    a_i,
  output logic [Bits-1:0] y_o
);
  localparam int unsigned N1 = (Latency >= 2) ? 1 : 0;
  localparam int unsigned N2 = Latency - N1;
  localparam int unsigned ProdW  = ManW + 1 + Bits;
  localparam logic [ExpW-1:0] BIAS = '1 >> 1;

  typedef struct packed {logic zero; logic one; logic [ExpW-1:0] down; logic [ProdW-1:0] prod;} p1_t;
  p1_t p1_d, p1_q;
  logic [Bits-1:0] y_d;

  // P1: below 1 the product has ManW fraction bits and stands BIAS - exponent, at least one, places too high.
  logic [ExpW-1:0] exp;
  logic [ManW:0]   sig;
  assign exp = a_i[ManW+:ExpW];
  assign sig = {1'b1, a_i[ManW-1:0]};
  assign p1_d.zero = a_i[W-1] || (exp == '0) || ((&exp) && (a_i[ManW-1:0] != '0));
  assign p1_d.one  = exp >= BIAS;
  assign p1_d.down = BIAS - exp;
  assign p1_d.prod = {sig, Bits'(0)} - ProdW'(sig);
  rc_fp_pipe #(.Width($bits(p1_t)), .Stages(N1)) u_p1 (.clk_i, .d_i(p1_d), .q_o(p1_q));

  // P2: keep one bit below the binary point, add it.
  logic [Bits:0]   half;
  logic            unused_half;
  assign {unused_half, half} = (Bits + 2)'(p1_q.prod >> (ManW - 1)) >> p1_q.down;
  always_comb begin
    if (p1_q.zero)     y_d = '0;
    else if (p1_q.one) y_d = '1;
    else               y_d = half[Bits:1] + Bits'(half[0]);
  end
  rc_fp_pipe #(.Width(Bits), .Stages(N2)) u_p2 (.clk_i, .d_i(y_d), .q_o(y_o));
endmodule
