// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// a + b + c with one rounding, to nearest even, of the exact sum (paper Table I, "3-input adder").
//   P1  find the largest exponent, align all three to it in a window of 2 (ManW + 1) + 3 bits, the last one sticky
//   P2  add as signed numbers
//   P3  magnitude, normalise
//   P4  round and pack
// Registers: after P2 from Latency 2, after P3 from 3, after P1 from 4, the rest at the output.
// The window is the narrowest that rounds every sum correctly, given one special case: if two operands cancel exactly,
// the third is aligned to itself, however small it is. Proof in docs/fp.md.
module rc_fp_add3 #(
  parameter  int unsigned ExpW    = 7,
  parameter  int unsigned ManW    = 16,
  parameter  int unsigned Latency = 2,              // cycles, at least 1
  localparam int unsigned W       = 1 + ExpW + ManW
) (
  input  logic         clk_i,
  input  logic [W-1:0] a_i,
  input  logic [W-1:0] b_i,
  input  logic [W-1:0] c_i,
  output logic [W-1:0] y_o
);
  localparam int unsigned N1 = (Latency >= 4) ? 1 : 0;
  localparam int unsigned N2 = (Latency >= 2) ? 1 : 0;
  localparam int unsigned N3 = (Latency >= 3) ? 1 : 0;
  localparam int unsigned N4 = Latency - N1 - N2 - N3;
  localparam int unsigned WinW   = 2 * (ManW + 1) + 3;   // weights 2^0 (leading one) to 2^-(2 ManW + 3), and sticky
  localparam int unsigned MagW   = WinW + 2;             // three operands below 2 add up to less than 8
  localparam int unsigned CountW = $clog2(MagW);
  localparam int unsigned ExtW   = WinW + ManW;

  typedef struct packed {
    logic            zero_sign;   // of the result, if it is zero
    logic            nan;
    logic            is_inf;
    logic            inf_sign;
    logic [ExpW-1:0] exp;         // the largest
  } ctl_t;
  typedef struct packed {ctl_t ctl; logic [MagW:0] total;} p2_t;
  typedef struct packed {ctl_t ctl; logic sign; logic [CountW-1:0] count; logic [MagW-1:0] mag;} p3_t;
  ctl_t                 p1_ctl_d, p1_ctl_q;
  logic [2:0]           p1_sign_d, p1_sign_q;
  logic [2:0][WinW-1:0] p1_win_d, p1_win_q;
  p2_t p2_d, p2_q;
  p3_t p3_d, p3_q;
  logic [W-1:0] y_d;

  // The significand in its window, shifted right. A shift by WinW - 1 leaves nothing but the sticky bit.
  function automatic logic [WinW-1:0] align(logic [ExpW+ManW-1:0] x, logic [ExpW-1:0] shift);
    logic [ManW:0]   sig;
    logic [ExtW-1:0] ext;
    sig = {1'b1, x[ManW-1:0]} & {(ManW + 1) {x[ManW+:ExpW] != '0}};
    ext = {sig, {(ExtW - 1 - ManW) {1'b0}}} >> ((32'(shift) > WinW - 1) ? WinW - 1 : 32'(shift));
    return {ext[ExtW-1:ManW+1], |ext[ManW:0]};
  endfunction

  // P1: all differences of exponents at once; those that are negative are never used, but for equal operands (below).
  logic [2:0][ExpW-1:0] exp;
  logic [2:0]           max, frac, is_inf, nan;
  logic [ExpW-1:0]      ab, ac, bc;                  // differences of exponents
  logic                 ab_neg, ac_neg, bc_neg;
  logic                 ab_cancel, ac_cancel, bc_cancel;
  logic                 a_top, b_top, c_top;
  assign exp    = {c_i[ManW+:ExpW], b_i[ManW+:ExpW], a_i[ManW+:ExpW]};
  assign max    = {&exp[2], &exp[1], &exp[0]};
  assign frac   = {c_i[ManW-1:0] != '0, b_i[ManW-1:0] != '0, a_i[ManW-1:0] != '0};
  assign is_inf = max & ~frac;
  assign nan    = max & frac;
  assign {ab_neg, ab} = {1'b0, exp[0]} - {1'b0, exp[1]};
  assign {ac_neg, ac} = {1'b0, exp[0]} - {1'b0, exp[2]};
  assign {bc_neg, bc} = {1'b0, exp[1]} - {1'b0, exp[2]};
  assign ab_cancel = (a_i ^ b_i) == {1'b1, {(W - 1) {1'b0}}};
  assign ac_cancel = (a_i ^ c_i) == {1'b1, {(W - 1) {1'b0}}};
  assign bc_cancel = (b_i ^ c_i) == {1'b1, {(W - 1) {1'b0}}};
  // If two operands cancel, the third counts as the largest. The two are then shifted by the same amount, whatever it is,
  // and cancel in their windows too.
  assign a_top = bc_cancel || (!ab_cancel && !ac_cancel && !ab_neg && !ac_neg);
  assign b_top = !a_top && (ac_cancel || (!ab_cancel && !bc_neg));
  assign c_top = !a_top && !b_top;
  logic [2:0][ExpW-1:0] shift;
  assign shift[0] = ({ExpW{b_top}} & -ab) | ({ExpW{c_top}} & -ac);
  assign shift[1] = ({ExpW{a_top}} & ab) | ({ExpW{c_top}} & -bc);
  assign shift[2] = ({ExpW{a_top}} & ac) | ({ExpW{b_top}} & bc);
  assign p1_win_d           = {align(c_i[W-2:0], shift[2]), align(b_i[W-2:0], shift[1]), align(a_i[W-2:0], shift[0])};
  assign p1_sign_d          = {c_i[W-1], b_i[W-1], a_i[W-1]};
  assign p1_ctl_d.exp       = ({ExpW{a_top}} & exp[0]) | ({ExpW{b_top}} & exp[1]) | ({ExpW{c_top}} & exp[2]);
  assign p1_ctl_d.zero_sign = &p1_sign_d;            // of three negative operands with sum zero, each is -0
  assign p1_ctl_d.nan       = (nan != '0) || (((is_inf & p1_sign_d) != '0) && ((is_inf & ~p1_sign_d) != '0));
  assign p1_ctl_d.is_inf    = is_inf != '0;
  assign p1_ctl_d.inf_sign  = (is_inf & p1_sign_d) != '0;
  rc_fp_pipe #(.Width($bits(ctl_t)), .Stages(N1)) u_p1_ctl (.clk_i, .d_i(p1_ctl_d), .q_o(p1_ctl_q));
  rc_fp_pipe #(.Width(3), .Stages(N1)) u_p1_sign (.clk_i, .d_i(p1_sign_d), .q_o(p1_sign_q));
  for (genvar i = 0; i < 3; i++) begin : gen_win
    rc_fp_pipe #(.Width(WinW), .Stages(N1)) u_p1_win (.clk_i, .d_i(p1_win_d[i]), .q_o(p1_win_q[i]));
  end

  // P2: two's complement; the ones that complete the negation are counted and added with the rest.
  logic [MagW:0] term_a, term_b, term_c, ones;
  assign term_a   = (MagW + 1)'(p1_win_q[0]) ^ {(MagW + 1) {p1_sign_q[0]}};
  assign term_b   = (MagW + 1)'(p1_win_q[1]) ^ {(MagW + 1) {p1_sign_q[1]}};
  assign term_c   = (MagW + 1)'(p1_win_q[2]) ^ {(MagW + 1) {p1_sign_q[2]}};
  assign ones     = (MagW + 1)'(p1_sign_q[0]) + (MagW + 1)'(p1_sign_q[1]) + (MagW + 1)'(p1_sign_q[2]);
  assign p2_d.ctl = p1_ctl_q;
  assign p2_d.total = term_a + term_b + term_c + ones;
  rc_fp_pipe #(.Width($bits(p2_t)), .Stages(N2)) u_p2 (.clk_i, .d_i(p2_d), .q_o(p2_q));

  // P3
  assign p3_d.ctl  = p2_q.ctl;
  assign p3_d.sign = p2_q.total[MagW];
  logic [MagW-1:0] mag;
  assign mag       = (p2_q.total[MagW-1:0] ^ {MagW{p3_d.sign}}) + MagW'(p3_d.sign);
  rc_fp_norm #(.Width(MagW)) u_norm (.x_i(mag), .y_o(p3_d.mag), .count_o(p3_d.count));
  rc_fp_pipe #(.Width($bits(p3_t)), .Stages(N3)) u_p3 (.clk_i, .d_i(p3_d), .q_o(p3_q));

  // P4: the top bit of mag, if set, is worth four times the leading one of the largest operand.
  logic zero, sign;
  assign zero = !p3_q.mag[MagW-1];
  assign sign = p3_q.ctl.is_inf ? p3_q.ctl.inf_sign : zero ? p3_q.ctl.zero_sign : p3_q.sign;
  rc_fp_round #(.ExpW(ExpW), .ManW(ManW)) u_round (
    .sign_i(sign),
    .exp_i($signed({2'b00, p3_q.ctl.exp}) + $signed((ExpW + 2)'(2)) - $signed((ExpW + 2)'(p3_q.count))),
    .man_i(p3_q.mag[MagW-2-:ManW]), .guard_i(p3_q.mag[MagW-2-ManW]), .sticky_i(|p3_q.mag[MagW-3-ManW:0]),
    .zero_i(zero), .inf_i(p3_q.ctl.is_inf), .nan_i(p3_q.ctl.nan), .y_o(y_d)
  );
  rc_fp_pipe #(.Width(W), .Stages(N4)) u_p4 (.clk_i, .d_i(y_d), .q_o(y_o));
endmodule
