// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// a / b, correctly rounded to nearest even (paper Table I, "Divider"): a non-restoring array, one row a quotient bit.
// A row adds or subtracts the divisor by the sign of the partial remainder and needs one adder, half of a restoring row.
// ManW + 3 rows give a bit in front of the binary point, ManW + 1 behind it and a rounding bit; the remainder is not
// needed, because a quotient of two numbers of ManW + 1 bits never lies half way between two such numbers.
// Registers: Latency - 1 of them divide the rows evenly (up to one a row), rounding is with the last group; the rest
// stand at the output.
module rc_fp_div #(
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
  localparam int unsigned Rows   = ManW + 3;
  localparam int unsigned Groups = (Latency < Rows) ? Latency : Rows;
  localparam int unsigned RemW   = ManW + 2;         // partial remainder: signed, not larger than the divisor
  localparam logic [ExpW-1:0] BIAS = '1 >> 1;

  typedef struct packed {
    logic                   sign;
    logic                   zero;
    logic                   is_inf;
    logic                   nan;
    logic signed [ExpW+1:0] exp;
  } ctl_t;
  ctl_t ctl_d;

  logic [ExpW-1:0] a_exp, b_exp;
  logic            a_zero, b_zero, a_max, b_max, a_nan, b_nan;
  assign a_exp  = a_i[ManW+:ExpW];
  assign b_exp  = b_i[ManW+:ExpW];
  assign a_zero = a_exp == '0;
  assign b_zero = b_exp == '0;
  assign a_max  = &a_exp;
  assign b_max  = &b_exp;
  assign a_nan  = a_max && (a_i[ManW-1:0] != '0);
  assign b_nan  = b_max && (b_i[ManW-1:0] != '0);
  assign ctl_d.sign = a_i[W-1] ^ b_i[W-1];
  assign ctl_d.zero = a_zero || b_max;
  assign ctl_d.is_inf  = a_max || b_zero;
  assign ctl_d.nan  = a_nan || b_nan || (a_zero && b_zero) || (a_max && b_max);
  assign ctl_d.exp  = $signed({2'b00, a_exp}) - $signed({2'b00, b_exp}) + $signed({2'b00, BIAS});

  // Group g holds rows FIRST to LAST - 1. Row 0 is the difference of the significands. A quotient bit is set where the
  // remainder is not negative; the others follow from it.
  for (genvar g = 0; g < Groups; g++) begin : gen_group
    localparam int unsigned First = (g * Rows) / Groups;
    localparam int unsigned Last  = ((g + 1) * Rows) / Groups;
    ctl_t              ctl;
    logic [ManW:0]     div;
    logic [RemW-1:0]   rem_in, rem;
    logic [Rows-1:0]   quo_in, quo;
    logic              minus;
    if (g == 0) begin : gen_first
      assign ctl    = ctl_d;
      assign div    = {1'b1, b_i[ManW-1:0]};
      assign rem_in = RemW'({1'b1, a_i[ManW-1:0]});
      assign quo_in = '0;
    end else begin : gen_next
      rc_fp_pipe #(.Width($bits(ctl_t)), .Stages(1)) u_ctl (.clk_i, .d_i(gen_group[g-1].ctl), .q_o(ctl));
      rc_fp_pipe #(.Width(ManW + 1), .Stages(1)) u_div (.clk_i, .d_i(gen_group[g-1].div), .q_o(div));
      rc_fp_pipe #(.Width(RemW), .Stages(1)) u_rem (.clk_i, .d_i(gen_group[g-1].rem), .q_o(rem_in));
      rc_fp_pipe #(.Width(Rows), .Stages(1)) u_quo (.clk_i, .d_i(gen_group[g-1].quo), .q_o(quo_in));
    end
    always_comb begin
      rem   = rem_in;
      quo   = quo_in;
      minus = 1'b1;
      for (int unsigned i = First; i < Last; i++) begin
        // Minus the divisor is its complement plus one; the one goes where the doubled remainder has its zero.
        minus = !rem[RemW-1];
        if (i == 0) rem = rem - RemW'(div);
        else        rem = {rem[RemW-2:0], minus} + (RemW'(div) ^ {RemW{minus}});
        quo = {quo[Rows-2:0], !rem[RemW-1]};
      end
    end
  end

  // The quotient lies in (1/2, 2).
  ctl_t            ctl;
  logic [Rows-1:0] quo;
  logic [ManW:0]   sig;   // fraction and rounding bit
  logic [W-1:0]    y_d;
  assign ctl = gen_group[Groups-1].ctl;
  assign quo = gen_group[Groups-1].quo;
  assign sig = quo[Rows-1] ? quo[Rows-2-:ManW+1] : quo[ManW:0];
  rc_fp_round #(.ExpW(ExpW), .ManW(ManW)) u_round (
    .sign_i(ctl.sign), .exp_i(ctl.exp - $signed((ExpW + 2)'(!quo[Rows-1]))),
    .man_i(sig[ManW:1]), .guard_i(sig[0]), .sticky_i(1'b1),
    .zero_i(ctl.zero), .inf_i(ctl.is_inf), .nan_i(ctl.nan), .y_o(y_d)
  );
  rc_fp_pipe #(.Width(W), .Stages(Latency - Groups + 1)) u_out (.clk_i, .d_i(y_d), .q_o(y_o));
endmodule
