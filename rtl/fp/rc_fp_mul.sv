// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// a * b, correctly rounded to nearest even (paper Table I, "Multiplier"). The 17 x 17 bit product of the significands is
// one DSP block on most FPGAs.
//   P1  operands
//   P2  product, sum of exponents
//   P3  normalise by one place, round and pack
// Registers: after P2 from Latency 2, after P1 from 3, twice after P2 from 4 (as DSP blocks have them), the rest at the
// output.
module rc_fp_mul #(
  parameter  int unsigned ExpW    = 7,
  parameter  int unsigned ManW    = 16,
  parameter  int unsigned Latency = 1,              // cycles, at least 1
  localparam int unsigned W       = 1 + ExpW + ManW
) (
  input  logic         clk_i,
  input  logic [W-1:0] a_i,
  input  logic [W-1:0] b_i,
  output logic [W-1:0] y_o
);
  localparam int unsigned N1 = (Latency >= 3) ? 1 : 0;
  localparam int unsigned N2 = (Latency >= 4) ? 2 : (Latency >= 2) ? 1 : 0;
  localparam int unsigned N3 = Latency - N1 - N2;
  localparam int unsigned ProdW = 2 * (ManW + 1);
  localparam logic [ExpW-1:0] BIAS = '1 >> 1;

  typedef struct packed {
    logic                   sign;
    logic                   zero;
    logic                   is_inf;
    logic                   nan;
    logic signed [ExpW+1:0] exp;
    logic [ProdW-1:0]       prod;
  } p2_t;
  logic [W-1:0] a, b, y_d;
  p2_t p2_d, p2_q;

  // P1
  rc_fp_pipe #(.Width(2 * W), .Stages(N1)) u_p1 (.clk_i, .d_i({a_i, b_i}), .q_o({a, b}));

  // P2
  logic [ExpW-1:0] a_exp, b_exp;
  logic            a_zero, b_zero, a_max, b_max, a_nan, b_nan;
  assign a_exp  = a[ManW+:ExpW];
  assign b_exp  = b[ManW+:ExpW];
  assign a_zero = a_exp == '0;
  assign b_zero = b_exp == '0;
  assign a_max  = &a_exp;
  assign b_max  = &b_exp;
  assign a_nan  = a_max && (a[ManW-1:0] != '0);
  assign b_nan  = b_max && (b[ManW-1:0] != '0);
  assign p2_d.sign = a[W-1] ^ b[W-1];
  assign p2_d.zero = a_zero || b_zero;
  assign p2_d.is_inf  = a_max || b_max;
  assign p2_d.nan  = a_nan || b_nan || (p2_d.zero && p2_d.is_inf);    // 0 * inf
  assign p2_d.exp  = $signed({2'b00, a_exp}) + $signed({2'b00, b_exp}) - $signed({2'b00, BIAS});
  assign p2_d.prod = ProdW'({1'b1, a[ManW-1:0]}) * ProdW'({1'b1, b[ManW-1:0]});
  rc_fp_pipe #(.Width($bits(p2_t)), .Stages(N2)) u_p2 (.clk_i, .d_i(p2_d), .q_o(p2_q));

  // P3: the product lies in [1, 4).
  logic             two;
  logic [ProdW-2:0] sig;   // below the leading one
  assign two = p2_q.prod[ProdW-1];
  assign sig = p2_q.prod[ProdW-2:0] << !two;
  rc_fp_round #(.ExpW(ExpW), .ManW(ManW)) u_round (
    .sign_i(p2_q.sign), .exp_i(p2_q.exp + $signed((ExpW + 2)'(two))),
    .man_i(sig[ProdW-2-:ManW]), .guard_i(sig[ProdW-2-ManW]), .sticky_i(|sig[ProdW-3-ManW:0]),
    .zero_i(p2_q.zero), .inf_i(p2_q.is_inf), .nan_i(p2_q.nan), .y_o(y_d)
  );
  rc_fp_pipe #(.Width(W), .Stages(N3)) u_p3 (.clk_i, .d_i(y_d), .q_o(y_o));
endmodule
