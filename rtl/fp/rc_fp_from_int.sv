// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Fixed point to float, rounded to nearest even: y = int_i * 2^-FracW. Zero gives +0.
//   P1  magnitude, normalise
//   P2  round and pack
// Registers: after P1 from Latency 2, the rest at the output.
module rc_fp_from_int #(
  parameter  int unsigned ExpW    = 7,
  parameter  int unsigned ManW    = 16,
  parameter  int unsigned Latency = 1,              // cycles, at least 1
  parameter  int unsigned IntW    = 16,             // bits of the operand
  parameter  int unsigned FracW   = 0,              // of these, behind the binary point (may exceed IntW)
  parameter  bit          Signed  = 1'b1,           // two's complement
  localparam int unsigned W       = 1 + ExpW + ManW
) (
  input  logic            clk_i,
  input  logic [IntW-1:0] int_i,
  output logic [W-1:0]    y_o
);
  localparam int unsigned N1 = (Latency >= 2) ? 1 : 0;
  localparam int unsigned N2 = Latency - N1;
  localparam int unsigned SigW   = (IntW > ManW + 3) ? IntW : ManW + 3;   // leading one, fraction, guard, sticky
  localparam int unsigned CountW = $clog2(SigW);
  localparam int unsigned ExpInW = ExpW + 2 + $clog2(IntW + FracW + 1);
  localparam int          TOP    = (1 << (ExpW - 1)) - 1 + int'(IntW) - 1 - int'(FracW);   // exponent of the top bit

  typedef struct packed {logic sign; logic [CountW-1:0] count; logic [SigW-1:0] sig;} p1_t;
  p1_t          p1_d, p1_q;
  logic [IntW-1:0] mag;
  logic [W-1:0] y_d;

  // P1
  assign p1_d.sign = Signed && int_i[IntW-1];
  assign mag       = p1_d.sign ? -int_i : int_i;
  rc_fp_norm #(.Width(SigW)) u_norm (.x_i(SigW'(mag) << (SigW - IntW)), .y_o(p1_d.sig), .count_o(p1_d.count));
  rc_fp_pipe #(.Width($bits(p1_t)), .Stages(N1)) u_p1 (.clk_i, .d_i(p1_d), .q_o(p1_q));

  // P2
  rc_fp_round #(.ExpW(ExpW), .ManW(ManW), .ExpInW(ExpInW)) u_round (
    .sign_i(p1_q.sign), .exp_i(ExpInW'(TOP) - $signed(ExpInW'(p1_q.count))),
    .man_i(p1_q.sig[SigW-2-:ManW]), .guard_i(p1_q.sig[SigW-2-ManW]), .sticky_i(|p1_q.sig[SigW-3-ManW:0]),
    .zero_i(!p1_q.sig[SigW-1]), .inf_i(1'b0), .nan_i(1'b0), .y_o(y_d)
  );
  rc_fp_pipe #(.Width(W), .Stages(N2)) u_p2 (.clk_i, .d_i(y_d), .q_o(y_o));
endmodule
