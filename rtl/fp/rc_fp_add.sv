// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// a + b, correctly rounded to nearest even (paper Table I, "2-input adder"). Subtract by flipping the sign bit of b.
//   P1  order by magnitude, align the smaller: two guard bits and a sticky bit below the fraction
//   P2  add or subtract; the order makes the result positive
//   P3  normalise
//   P4  round and pack
// Registers: after P2 from Latency 2, after P3 from 3, after P1 from 4, the rest at the output.
module rc_fp_add #(
  parameter  int unsigned ExpW    = 7,
  parameter  int unsigned ManW    = 16,
  parameter  int unsigned Latency = 2,              // cycles, at least 1
  localparam int unsigned W       = 1 + ExpW + ManW
) (
  input  logic         clk_i,
  input  logic [W-1:0] a_i,
  input  logic [W-1:0] b_i,
  output logic [W-1:0] y_o
);
  localparam int unsigned N1 = (Latency >= 4) ? 1 : 0;
  localparam int unsigned N2 = (Latency >= 2) ? 1 : 0;
  localparam int unsigned N3 = (Latency >= 3) ? 1 : 0;
  localparam int unsigned N4 = Latency - N1 - N2 - N3;
  localparam int unsigned SigW   = 1 + ManW + 3;    // leading one, fraction, two guard bits, sticky
  localparam int unsigned CountW = $clog2(SigW + 1);
  localparam int unsigned ExtW   = SigW + ManW;     // SigW and what a shift can push out of it

  typedef struct packed {
    logic            sign;        // of the result, if it is not zero
    logic            zero_sign;   // of the result, if it is zero
    logic            nan;
    logic            is_inf;
    logic [ExpW-1:0] exp;         // of the larger operand
  } ctl_t;
  typedef struct packed {ctl_t ctl; logic sub; logic [SigW-1:0] hi; logic [SigW-1:0] lo;} p1_t;
  typedef struct packed {ctl_t ctl; logic [SigW:0] sum;} p2_t;
  typedef struct packed {ctl_t ctl; logic [CountW-1:0] count; logic [SigW:0] sig;} p3_t;
  p1_t p1_d, p1_q;
  p2_t p2_d, p2_q;
  p3_t p3_d, p3_q;
  logic [W-1:0] y_d;

  // P1: a plain comparison of the patterns orders the magnitudes; zeros, with exponent 0, come out low.
  logic            swap, a_inf, b_inf, a_nan, b_nan;
  logic [W-2:0]    flip, hi, lo;
  logic [ExpW-1:0] diff;
  logic [ManW:0]   hi_sig, lo_sig;
  logic [ExtW-1:0] ext;
  assign swap   = a_i[W-2:0] < b_i[W-2:0];
  assign flip   = (a_i[W-2:0] ^ b_i[W-2:0]) & {(W - 1) {swap}};   // not `?:`: no mispredicted branch in simulation
  assign hi     = a_i[W-2:0] ^ flip;
  assign lo     = b_i[W-2:0] ^ flip;
  assign diff   = hi[ManW+:ExpW] - lo[ManW+:ExpW];
  assign hi_sig = {1'b1, hi[ManW-1:0]} & {(ManW + 1) {hi[ManW+:ExpW] != '0}};
  assign lo_sig = {1'b1, lo[ManW-1:0]} & {(ManW + 1) {lo[ManW+:ExpW] != '0}};
  // A shift by SigW - 1 or more leaves nothing but the sticky bit.
  assign ext    = {lo_sig, {(ExtW - 1 - ManW) {1'b0}}} >> ((32'(diff) > SigW - 1) ? SigW - 1 : 32'(diff));
  assign a_inf = (&a_i[ManW+:ExpW]) && (a_i[ManW-1:0] == '0);
  assign b_inf = (&b_i[ManW+:ExpW]) && (b_i[ManW-1:0] == '0);
  assign a_nan = (&a_i[ManW+:ExpW]) && (a_i[ManW-1:0] != '0);
  assign b_nan = (&b_i[ManW+:ExpW]) && (b_i[ManW-1:0] != '0);
  assign p1_d.ctl.sign      = (a_i[W-1] && !swap) || (b_i[W-1] && swap);
  assign p1_d.ctl.zero_sign = a_i[W-1] && b_i[W-1];                // x - x = +0, -0 - 0 = -0
  assign p1_d.ctl.nan       = a_nan || b_nan || (a_inf && b_inf && p1_d.sub);
  assign p1_d.ctl.is_inf       = a_inf || b_inf;
  assign p1_d.ctl.exp       = hi[ManW+:ExpW];
  assign p1_d.sub           = a_i[W-1] != b_i[W-1];
  assign p1_d.hi            = {hi_sig, 3'b000};
  assign p1_d.lo            = {ext[ExtW-1:ManW+1], |ext[ManW:0]};
  rc_fp_pipe #(.Width($bits(p1_t)), .Stages(N1)) u_p1 (.clk_i, .d_i(p1_d), .q_o(p1_q));

  // P2: the lowest bit only carries in the one that completes the negation.
  logic unused_carry;
  assign p2_d.ctl = p1_q.ctl;
  assign {p2_d.sum, unused_carry} = {1'b0, p1_q.hi, 1'b1} + ({1'b0, p1_q.lo, 1'b0} ^ {(SigW + 2) {p1_q.sub}});
  rc_fp_pipe #(.Width($bits(p2_t)), .Stages(N2)) u_p2 (.clk_i, .d_i(p2_d), .q_o(p2_q));

  // P3
  assign p3_d.ctl = p2_q.ctl;
  rc_fp_norm #(.Width(SigW + 1)) u_norm (.x_i(p2_q.sum), .y_o(p3_d.sig), .count_o(p3_d.count));
  rc_fp_pipe #(.Width($bits(p3_t)), .Stages(N3)) u_p3 (.clk_i, .d_i(p3_d), .q_o(p3_q));

  // P4: the top bit of sig, if set, is worth twice the leading one of the larger operand.
  logic zero;
  assign zero = !p3_q.sig[SigW];
  rc_fp_round #(.ExpW(ExpW), .ManW(ManW)) u_round (
    .sign_i(zero ? p3_q.ctl.zero_sign : p3_q.ctl.sign),
    .exp_i($signed({2'b00, p3_q.ctl.exp}) + $signed((ExpW + 2)'(1)) - $signed((ExpW + 2)'(p3_q.count))),
    .man_i(p3_q.sig[SigW-1-:ManW]), .guard_i(p3_q.sig[SigW-1-ManW]), .sticky_i(|p3_q.sig[SigW-2-ManW:0]),
    .zero_i(zero), .inf_i(p3_q.ctl.is_inf), .nan_i(p3_q.ctl.nan), .y_o(y_d)
  );
  rc_fp_pipe #(.Width(W), .Stages(N4)) u_p4 (.clk_i, .d_i(y_d), .q_o(y_o));
endmodule
