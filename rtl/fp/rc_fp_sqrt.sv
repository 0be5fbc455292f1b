// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Square root by a table with linear interpolation between two adjacent entries (paper Sec. 4.1 and Table I).
// The significand, doubled if the exponent is odd, lies in [1, 4); its root in [1, 2). An entry holds the root at its node
// and the step to the next node, so that one read gives both ends of the line. Monotone; error below 0.58 ulp; exact where
// the root is an FP24 number. Proof and measurement in docs/fp.md.
//   P1  read the table
//   P2  interpolate
//   P3  round half up and pack
// Registers: after P1 from Latency 2 (where block RAM has one), after P2 from 3, the rest at the output.
module rc_fp_sqrt #(
  parameter  int unsigned ExpW    = 7,
  parameter  int unsigned ManW    = 16,
  parameter  int unsigned Latency = 2,              // cycles, at least 1
  parameter  int unsigned TabW    = 8,              // fraction bits that select an entry; at most ManW are used
  parameter  int unsigned GuardW  = 4,              // fraction bits of an entry beyond the result's
  localparam int unsigned W       = 1 + ExpW + ManW
) (
  input  logic         clk_i,
  input  logic [W-1:0] a_i,
  output logic [W-1:0] y_o
);
  localparam int unsigned N1 = (Latency >= 2) ? 1 : 0;
  localparam int unsigned N2 = (Latency >= 3) ? 1 : 0;
  localparam int unsigned N3 = Latency - N1 - N2;
  localparam int unsigned IdxW  = (TabW < ManW) ? TabW : ManW;
  localparam int unsigned PosW  = ManW - IdxW;       // fraction bits that tell the place between two nodes
  localparam int unsigned NodeW = ManW + GuardW;     // fraction bits of a node
  localparam int unsigned StepW = NodeW - IdxW;
  localparam int unsigned IntW  = NodeW + PosW;      // fraction bits of an interpolated value
  localparam int unsigned Depth = 1 << (IdxW + 1);
  localparam logic [ExpW-1:0] EXP_MAX = '1;
  localparam logic [ExpW-1:0] BIAS    = '1 >> 1;

  typedef struct packed {logic [NodeW-1:0] root; logic [StepW-1:0] step;} entry_t;   // root without its leading one
  typedef entry_t [Depth-1:0] table_t;

  // Root at node i in units of 2^-NodeW, to nearest. Nodes divide [1, 2) and [2, 4] into 2^IdxW intervals each.
  function automatic longint unsigned node(int unsigned i);
    longint unsigned x, r, t;
    x = ((i < Depth / 2) ? 64'(Depth) / 2 + 64'(i) : 64'(i) * 2) << (2 * NodeW - IdxW);
    r = 0;
    for (int k = int'(NodeW) + 1; k >= 0; k--) begin
      t = r | (64'd1 << k);
      if (t * t <= x) r = t;
    end
    return (x > r * r + r) ? r + 1 : r;
  endfunction

  function automatic table_t make_table();
    table_t          t;
    longint unsigned here, next;
    here = node(0);
    for (int unsigned i = 0; i < Depth; i++) begin
      next = node(i + 1);
      t[i].root = NodeW'(here);
      t[i].step = StepW'(next - here);
      here = next;
    end
    return t;
  endfunction

  localparam table_t TABLE = make_table();

  typedef struct packed {logic sign; logic zero; logic is_inf; logic nan; logic [ExpW-1:0] exp;} ctl_t;
  ctl_t             p1_ctl_d, p1_ctl_q, p2_ctl_q;
  entry_t           p1_entry_d, p1_entry_q;
  logic [IntW-1:0]  p2_root_d, p2_root_q;
  logic [W-1:0]     y_d;

  // P1: the bias is odd, hence an even field means an odd exponent.
  logic [ExpW-1:0] exp;
  logic            max;
  assign exp = a_i[ManW+:ExpW];
  assign max = &exp;
  assign p1_ctl_d.sign   = a_i[W-1];
  assign p1_ctl_d.zero   = exp == '0;
  assign p1_ctl_d.is_inf = max && (a_i[ManW-1:0] == '0);
  assign p1_ctl_d.nan    = (max && (a_i[ManW-1:0] != '0)) || (a_i[W-1] && (exp != '0));
  assign p1_ctl_d.exp    = ExpW'(((ExpW + 1)'(exp) + (ExpW + 1)'(BIAS)) >> 1);
  assign p1_entry_d      = TABLE[{!exp[0], a_i[ManW-1-:IdxW]}];
  rc_fp_pipe #(.Width($bits(ctl_t)), .Stages(N1)) u_p1_ctl (.clk_i, .d_i(p1_ctl_d), .q_o(p1_ctl_q));
  rc_fp_pipe #(.Width($bits(entry_t)), .Stages(N1)) u_p1_entry (.clk_i, .d_i(p1_entry_d), .q_o(p1_entry_q));

  // P2: the line never leaves [1, 2), so the leading one stays implied.
  if (PosW == 0) begin : gen_direct
    assign p2_root_d = p1_entry_q.root;
    logic unused_step;
    assign unused_step = ^p1_entry_q.step;
  end else begin : gen_line
    logic [PosW-1:0] pos;
    rc_fp_pipe #(.Width(PosW), .Stages(N1)) u_p1_pos (.clk_i, .d_i(a_i[PosW-1:0]), .q_o(pos));
    assign p2_root_d = {p1_entry_q.root, PosW'(0)} + IntW'(p1_entry_q.step) * IntW'(pos);
  end
  rc_fp_pipe #(.Width($bits(ctl_t)), .Stages(N2)) u_p2_ctl (.clk_i, .d_i(p1_ctl_q), .q_o(p2_ctl_q));
  rc_fp_pipe #(.Width(IntW), .Stages(N2)) u_p2_root (.clk_i, .d_i(p2_root_d), .q_o(p2_root_q));

  // P3: a root that rounds up to 2 carries into the exponent, which never leaves its range.
  logic [ExpW+ManW-1:0] mag;
  assign mag = {p2_ctl_q.exp, p2_root_q[IntW-1-:ManW]} + (ExpW + ManW)'(p2_root_q[IntW-1-ManW]);
  always_comb begin
    if (p2_ctl_q.nan)         y_d = {1'b0, EXP_MAX, 1'b1, {(ManW - 1) {1'b0}}};
    else if (p2_ctl_q.is_inf) y_d = {1'b0, EXP_MAX, {ManW{1'b0}}};
    else if (p2_ctl_q.zero)   y_d = {p2_ctl_q.sign, {(ExpW + ManW) {1'b0}}};
    else                      y_d = {1'b0, mag};
  end
  rc_fp_pipe #(.Width(W), .Stages(N3)) u_p3 (.clk_i, .d_i(y_d), .q_o(y_o));
  if (IntW > ManW + 1) begin : gen_unused
    logic unused_root;
    assign unused_root = ^p2_root_q[IntW-2-ManW:0];
  end
endmodule
