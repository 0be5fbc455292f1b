// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// a^b = 2^(b log2 a) for a, b >= 0, in FP24 (paper Table I, "Exp. unit"). Two tables: the logarithm by a parabola through the ends
// and the middle of an interval, with 30 fraction bits since b multiplies its error; the exponential by a line. Relative
// error below 2^-16 for a <= 1 and b <= 1024; monotone in a and in b; proof and measurement in docs/fp.md.
//   P1  read the logarithm's table
//   P2  log2 a = exponent + interpolated logarithm of the significand
//   P3  times the significand of b
//   P4  times b's power of two: integer and fraction; read the exponential's table
//   P5  interpolate 2^fraction
//   P6  round and pack; the integer is the exponent
// Registers: after P3 from Latency 2, after P4 from 3, after P1 from 4, after P2 from 5, after P5 from 6, the rest at the output.
module rc_fp_pow #(
  parameter int unsigned Latency = 5                // cycles, at least 1
) (
  input  logic        clk_i,
  input  logic [23:0] a_i,
  input  logic [23:0] b_i,
  output logic [23:0] y_o
);
  localparam int unsigned N1 = (Latency >= 4) ? 1 : 0;
  localparam int unsigned N2 = (Latency >= 5) ? 1 : 0;
  localparam int unsigned N3 = (Latency >= 2) ? 1 : 0;
  localparam int unsigned N4 = (Latency >= 3) ? 1 : 0;
  localparam int unsigned N5 = (Latency >= 6) ? 1 : 0;
  localparam int unsigned N6 = Latency - N1 - N2 - N3 - N4 - N5;
  localparam int unsigned LOG_IDX_W  = 7;           // fraction bits of a that select an entry
  localparam int unsigned LOG_POS_W  = 16 - LOG_IDX_W;
  localparam int unsigned BOW_W      = 2 * LOG_POS_W - 1;
  localparam int unsigned LOG_FRAC_W = 30;          // fraction bits of the logarithm
  localparam int unsigned LOG_W      = 7 + LOG_FRAC_W;          // signed, below 64 in size
  localparam int unsigned PROD_W     = LOG_W + 17;
  localparam int unsigned EXP_IDX_W  = 8;           // bits of the fraction of b log2 a that select an entry
  localparam int unsigned EXP_POS_W  = 14;          // and that tell the place between two nodes
  localparam int unsigned EXP_FRAC_W = EXP_IDX_W + EXP_POS_W;
  localparam int unsigned NODE_W     = 20;          // fraction bits of a node of the exponential
  localparam int unsigned ROOT_W     = NODE_W + EXP_POS_W;      // fraction bits of an interpolated value
  localparam int unsigned BIG        = 23;          // b >= 2^BIG is out of range for every a but 1: |log2 a| > 2^-17

  // ---- tables: computed with 62 fraction bits, rounded to nearest ------------------------------------------------------
  typedef logic [63:0] fix_t;
  function automatic fix_t fix_mul(fix_t a, fix_t b);           // a, b, and the product below 4, truncated
    return fix_t'((128'(a) * 128'(b)) >> 62);
  endfunction

  typedef struct packed {logic [LOG_FRAC_W-1:0] node; logic [23:0] step; logic [13:0] bulge;} log_t;
  typedef log_t [(1<<LOG_IDX_W)-1:0] log_table_t;

  // log2(1 + i / 256), one bit by each squaring
  function automatic fix_t log2_of(int unsigned i);
    fix_t x, r;
    x = (fix_t'(i) + 64'd256) << 54;
    r = '0;
    for (int k = 0; k < 50; k++) begin
      x = fix_mul(x, x);
      r = (r << 1) | fix_t'(x[63]);
      if (x[63]) x = x >> 1;
    end
    return r << 12;
  endfunction

  function automatic log_table_t make_log();
    log_table_t t;
    fix_t       here, next, mid;
    here = '0;
    for (int unsigned i = 0; i < (1 << LOG_IDX_W); i++) begin
      next = (i == (1 << LOG_IDX_W) - 1) ? fix_t'(1) << 62 : log2_of(2 * i + 2);
      mid  = log2_of(2 * i + 1) - ((here + next) >> 1);
      t[i].node  = LOG_FRAC_W'(((here >> 31) + 64'd1) >> 1);
      t[i].step  = 24'((((next >> 31) + 64'd1) >> 1) - (((here >> 31) + 64'd1) >> 1));
      t[i].bulge = 14'(((mid >> 31) + 64'd1) >> 1);
      here = next;
    end
    return t;
  endfunction

  typedef struct packed {logic [NODE_W-1:0] node; logic [12:0] step;} exp_t;       // node without its leading one
  typedef exp_t [(1<<EXP_IDX_W)-1:0] exp_table_t;
  localparam fix_t ROOT256 = 64'h402C6BE96AF2FB58;              // 2^(1/256)

  function automatic exp_table_t make_exp();
    exp_table_t t;
    fix_t       here, next;
    here = fix_t'(1) << 62;
    for (int unsigned i = 0; i < (1 << EXP_IDX_W); i++) begin
      next = fix_mul(here, ROOT256);
      t[i].node = NODE_W'(((here >> 41) + 64'd1) >> 1);
      t[i].step = 13'((((next >> 41) + 64'd1) >> 1) - (((here >> 41) + 64'd1) >> 1));
      here = next;
    end
    return t;
  endfunction

  localparam log_table_t LOG = make_log();
  localparam exp_table_t EXP = make_exp();

  // ---- P1 ---------------------------------------------------------------------------------------------------------------
  typedef struct packed {logic nan; logic is_inf; logic zero;} kind_t;             // of the result, else by the tables
  typedef struct packed {
    kind_t                kind;
    logic [22:0]          b;
    logic [6:0]           a_exp;
    logic [LOG_POS_W-1:0] pos;
    logic [BOW_W-1:0]     bow;                                  // pos (1 - pos)
  } p1_t;
  p1_t  p1_d, p1_q;
  log_t p1_entry_d, p1_entry_q;
  logic [BOW_W-1:0] pos;
  logic a_zero, b_zero, a_max, b_max;
  assign a_zero = a_i[22:16] == '0;
  assign b_zero = b_i[22:16] == '0;
  assign a_max  = &a_i[22:16];
  assign b_max  = &b_i[22:16];
  assign p1_d.kind.nan    = (a_max && a_i[15:0] != '0) || (b_max && b_i[15:0] != '0)
                            || (a_i[23] && !a_zero) || (b_i[23] && !b_zero);
  assign p1_d.kind.is_inf = a_max && !b_zero;
  assign p1_d.kind.zero   = a_zero && !b_zero;
  assign p1_d.b     = b_i[22:0];
  assign p1_d.a_exp = a_i[22:16];
  assign pos        = BOW_W'(a_i[LOG_POS_W-1:0]);
  assign p1_d.pos   = a_i[LOG_POS_W-1:0];
  assign p1_d.bow   = pos * (BOW_W'(1 << LOG_POS_W) - pos);
  assign p1_entry_d = LOG[a_i[15-:LOG_IDX_W]];
  rc_fp_pipe #(.Width($bits(p1_t)), .Stages(N1)) u_p1 (.clk_i, .d_i(p1_d), .q_o(p1_q));
  rc_fp_pipe #(.Width($bits(log_t)), .Stages(N1)) u_p1_entry (.clk_i, .d_i(p1_entry_d), .q_o(p1_entry_q));

  // ---- P2: the bow is 1/4, 2^16 in its units, in the middle, where the logarithm is `bulge` above the line ---------------
  localparam int unsigned SUM_W = LOG_FRAC_W + 16;
  typedef struct packed {kind_t kind; logic [22:0] b; logic signed [LOG_W-1:0] log;} p2_t;
  p2_t              p2_d, p2_q;
  logic [SUM_W-1:0] sum;
  assign sum = {p1_entry_q.node, 16'd0} + (SUM_W'(p1_entry_q.step) * SUM_W'(p1_q.pos) << (16 - LOG_POS_W))
               + SUM_W'(p1_entry_q.bulge) * SUM_W'(p1_q.bow);
  assign p2_d.kind = p1_q.kind;
  assign p2_d.b    = p1_q.b;
  assign p2_d.log  = {p1_q.a_exp - 7'd63, sum[SUM_W-1:16]};      // below 1 is negative
  rc_fp_pipe #(.Width($bits(p2_t)), .Stages(N2)) u_p2 (.clk_i, .d_i(p2_d), .q_o(p2_q));

  // ---- P3 ----------------------------------------------------------------------------------------------------------------
  typedef struct packed {kind_t kind; logic [6:0] b_exp; logic signed [PROD_W-1:0] prod;} p3_t;
  p3_t p3_d, p3_q;
  assign p3_d.kind  = p2_q.kind;
  assign p3_d.b_exp = p2_q.b[22:16];
  assign p3_d.prod  = PROD_W'($signed(p2_q.log)) * PROD_W'($signed({2'b01, p2_q.b[15:0]}));
  rc_fp_pipe #(.Width($bits(p3_t)), .Stages(N3)) u_p3 (.clk_i, .d_i(p3_d), .q_o(p3_q));

  // ---- P4: b below 2^BIG; a product below -64 or from 64 on is cut to where the exponent is out of range -----------------
  localparam int unsigned POWER_W = PROD_W - (LOG_FRAC_W + 16 - EXP_FRAC_W - BIG + 1);
  typedef struct packed {kind_t kind; logic signed [7:0] exp; logic [EXP_POS_W-1:0] pos; exp_t entry;} p4_t;
  p4_t                         p4_d, p4_q;
  logic signed [POWER_W-1:0]   power;
  logic [6:0]                  right;
  logic                        big;
  assign right     = 7'(63 + BIG - 1) - p3_q.b_exp;
  assign power     = $signed(p3_q.prod[PROD_W-1-:POWER_W]) >>> right;
  assign big       = (p3_q.b_exp >= 7'(63 + BIG)) ? p3_q.prod != '0
                     : power[POWER_W-1:EXP_FRAC_W+7] != {(POWER_W - EXP_FRAC_W - 7) {power[POWER_W-1]}};
  assign p4_d.kind  = p3_q.kind;
  assign p4_d.exp   = big ? {p3_q.prod[PROD_W-1], {7{!p3_q.prod[PROD_W-1]}}} : power[EXP_FRAC_W+:8];
  assign p4_d.pos   = power[EXP_POS_W-1:0];
  assign p4_d.entry = EXP[power[EXP_FRAC_W-1-:EXP_IDX_W]];
  rc_fp_pipe #(.Width($bits(p4_t)), .Stages(N4)) u_p4 (.clk_i, .d_i(p4_d), .q_o(p4_q));

  // ---- P5: the line never leaves [1, 2), so the leading one stays implied --------------------------------------------------
  typedef struct packed {kind_t kind; logic signed [8:0] exp; logic [ROOT_W-1:0] man;} p5_t;
  p5_t         p5_d, p5_q;
  logic [23:0] y_d;
  assign p5_d.kind = p4_q.kind;
  assign p5_d.exp  = 9'($signed(p4_q.exp)) + 9'sd63;
  assign p5_d.man  = {p4_q.entry.node, EXP_POS_W'(0)} + ROOT_W'(p4_q.entry.step) * ROOT_W'(p4_q.pos);
  rc_fp_pipe #(.Width($bits(p5_t)), .Stages(N5)) u_p5 (.clk_i, .d_i(p5_d), .q_o(p5_q));

  // ---- P6 ------------------------------------------------------------------------------------------------------------------
  rc_fp_round u_round (
    .sign_i(1'b0), .exp_i(p5_q.exp),
    .man_i(p5_q.man[ROOT_W-1-:16]), .guard_i(p5_q.man[ROOT_W-17]), .sticky_i(|p5_q.man[ROOT_W-18:0]),
    .zero_i(p5_q.kind.zero), .inf_i(p5_q.kind.is_inf), .nan_i(p5_q.kind.nan), .y_o(y_d)
  );
  rc_fp_pipe #(.Width(24), .Stages(N6)) u_p6 (.clk_i, .d_i(y_d), .q_o(y_o));

  logic unused;
  assign unused = ^{sum[15:0], p3_q.prod[PROD_W-POWER_W-1:0]};
endmodule
