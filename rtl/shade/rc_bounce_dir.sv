// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Direction of the child of a bounce (docs/whitted.md), component-serial; times in rc_bounce_pkg:
//   T_TM   factor m          T_ED   eta d            T_V   v = d or eta d, plus factor m: mirrored or refracted
//   T_G    g . v             T_GG   2 g.v g          T_N   n = v, mirrored at the triangle if it is on the wrong side of it
//   T_N2   n . n             T_INV  1 / |n|          T_DIR n / |n|
// A direction that stays as it is goes through the same way: -0 is added twice, and it is multiplied by 1.
module rc_bounce_dir import rc_pkg::*; import rc_shade_pkg::*; import rc_bounce_pkg::*; (
  input  logic             clk_i,
  input  logic [BEATS-1:0] beat_i,
  input  fp_t              d_i,        // T_CTX
  input  fp_t              m_i,
  input  fp_t              g_i,        // T_V_IN
  input  fp_t              eta_i,      // T_ETA
  input  logic             refract_i,  // T_TURN
  input  logic             straight_i,
  input  fp_t              factor_i,   // of m: b, or -2 m.d
  output fp_t              nn_o,       // T_N2, for the square root
  input  fp_t              len_i,      // T_LEN
  output fp_t              dir_o       // T_DIR
);
  localparam fp_t NOTHING = 24'h800000;                          // -0: x + -0 = x

  // ---- v --------------------------------------------------------------------------------------------------------------
  fp_t   d_ed, d_v, m_tm, eta, factor, tm, ed, gv, gv_g, v_add_a, v_add_b, v_sum;
  logic  refract_v, straight_v;
  rc_carry #(.From(T_CTX), .To(T_ED_IN)) u_d_ed (.clk_i, .in_i(d_i), .out_o(d_ed));
  rc_carry #(.From(T_ED_IN), .To(T_V_IN)) u_d_v (.clk_i, .in_i(d_ed), .out_o(d_v));
  rc_carry #(.From(T_CTX), .To(T_TM_IN)) u_m_tm (.clk_i, .in_i(m_i), .out_o(m_tm));
  rc_spread #(.Beats(BEATS), .From(T_ETA), .To(T_ED_IN)) u_eta (
    .clk_i, .beat_i, .in_i(eta_i), .out_o(eta)
  );
  rc_spread #(.Beats(BEATS), .From(T_TURN), .To(T_TM_IN)) u_factor (
    .clk_i, .beat_i, .in_i(factor_i), .out_o(factor)
  );
  rc_spread #(.Width(2), .Beats(BEATS), .From(T_TURN), .To(T_V_IN)) u_turn_v (
    .clk_i, .beat_i, .in_i({refract_i, straight_i}), .out_o({refract_v, straight_v})
  );
  logic [BEATS-1:0] tm_beat, gg_beat;
  for (genvar k = 0; k < BEATS; k++) begin : gen_beat
    assign tm_beat[k] = beat_i[(T_TM_IN + k) % BEATS];
    assign gg_beat[k] = beat_i[(T_GG_IN + k) % BEATS];
  end
  fp_t v_gv, unused_s_tm, unused_s_gg;
  rc_trio u_mul_v (
    .clk_i, .beat_i(tm_beat), .a_i({m_tm, factor}), .b_i({d_ed, eta}), .c_i({v_gv, gv_g}), .s_i({FP_ZERO, FP_ZERO}),
    .a_o(tm), .b_o(ed), .c_o(gv), .s_o(unused_s_tm)
  );

  // The adder of v also adds up g . v.
  fp_t ed_v, gv_x, gv_y, gv_z, gv_part;
  rc_carry #(.From(T_ED), .To(T_V_IN)) u_ed_v (.clk_i, .in_i(ed), .out_o(ed_v));
  rc_carry #(.From(T_GV + 1), .To(T_G1_IN)) u_gv_y (.clk_i, .in_i(gv), .out_o(gv_y));
  rc_carry #(.From(T_G1_IN), .To(T_G1_IN + 1)) u_gv_x (.clk_i, .in_i(gv_y), .out_o(gv_x));   // came a cycle before y
  rc_carry #(.From(T_GV + 2), .To(T_G_IN)) u_gv_z (.clk_i, .in_i(gv), .out_o(gv_z));
  rc_carry #(.From(T_G1), .To(T_G_IN)) u_gv_part (.clk_i, .in_i(v_sum), .out_o(gv_part));
  always_comb begin
    v_add_a = refract_v ? ed_v : d_v;
    v_add_b = straight_v ? NOTHING : tm;
    if (beat_i[T_G1_IN % BEATS]) {v_add_b, v_add_a} = {gv_y, gv_x};
    if (beat_i[T_G_IN % BEATS]) {v_add_b, v_add_a} = {gv_z, gv_part};
  end
  rc_fp_add #(.Latency(LAT_ADD)) u_add_v (.clk_i, .a_i(v_add_a), .b_i(v_add_b), .y_o(v_sum));

  // ---- n: the reflected ray must leave on the viewer's side of the triangle, the refracted one on the other -----------
  fp_t   g_gg, v_n, gv_twice, gg, nn, n_nn, n_add_a, n_add_b, n_sum;
  logic  refract_g, straight_g, straight_inv, wrong, wrong_n;
  rc_carry #(.From(T_V_IN), .To(T_GV_IN)) u_g_gv (.clk_i, .in_i(g_i), .out_o(gv_g));
  rc_carry #(.From(T_GV_IN), .To(T_GG_IN)) u_g_gg (.clk_i, .in_i(gv_g), .out_o(g_gg));
  rc_carry #(.From(T_V), .To(T_GV_IN)) u_v_gv (.clk_i, .in_i(v_sum), .out_o(v_gv));
  rc_carry #(.From(T_GV_IN), .To(T_N_IN)) u_v_n (.clk_i, .in_i(v_gv), .out_o(v_n));
  rc_hold #(.Width(2), .Beats(BEATS), .From(T_TURN), .To(T_G)) u_turn_g (
    .clk_i, .now_i(beat_i[T_TURN % BEATS]), .in_i({refract_i, straight_i}), .out_o({refract_g, straight_g})
  );
  assign wrong = !straight_g && (fp_is_positive(v_sum) == refract_g);
  rc_spread #(.Width(1), .Beats(BEATS), .From(T_G), .To(T_N_IN)) u_wrong_n (
    .clk_i, .beat_i, .in_i(wrong), .out_o(wrong_n)
  );
  rc_spread #(.Beats(BEATS), .From(T_G), .To(T_GG_IN)) u_gv_twice (
    .clk_i, .beat_i, .in_i(fp_neg(fp_twice(v_sum))), .out_o(gv_twice)
  );
  fp_t n_dir, inv_dir;
  rc_trio u_mul_n (
    .clk_i, .beat_i(gg_beat), .a_i({g_gg, gv_twice}), .b_i({n_dir, inv_dir}), .c_i({n_nn, n_nn}),
    .s_i({FP_ZERO, FP_ZERO}), .a_o(gg), .b_o(dir_o), .c_o(nn), .s_o(unused_s_gg)
  );

  // The adder of n also adds up n . n.
  fp_t nn_x, nn_y, nn_z, nn_part;
  rc_carry #(.From(T_N), .To(T_NN_IN)) u_n_nn (.clk_i, .in_i(n_sum), .out_o(n_nn));
  rc_carry #(.From(T_NN + 1), .To(T_N1_IN)) u_nn_y (.clk_i, .in_i(nn), .out_o(nn_y));
  rc_carry #(.From(T_N1_IN), .To(T_N1_IN + 1)) u_nn_x (.clk_i, .in_i(nn_y), .out_o(nn_x));
  rc_carry #(.From(T_NN + 2), .To(T_N2_IN)) u_nn_z (.clk_i, .in_i(nn), .out_o(nn_z));
  rc_carry #(.From(T_N1), .To(T_N2_IN)) u_nn_part (.clk_i, .in_i(n_sum), .out_o(nn_part));
  always_comb begin
    n_add_a = v_n;
    n_add_b = wrong_n ? gg : NOTHING;
    if (beat_i[T_N1_IN % BEATS]) {n_add_b, n_add_a} = {nn_y, nn_x};
    if (beat_i[T_N2_IN % BEATS]) {n_add_b, n_add_a} = {nn_z, nn_part};
  end
  rc_fp_add #(.Latency(LAT_ADD)) u_add_n (.clk_i, .a_i(n_add_a), .b_i(n_add_b), .y_o(n_sum));
  assign nn_o = n_sum;

  // ---- unit length ----------------------------------------------------------------------------------------------------
  fp_t inv;
  rc_fp_div #(.Latency(LAT_DIV)) u_div (.clk_i, .a_i(FP_ONE), .b_i(len_i), .y_o(inv));
  rc_hold #(.Width(1), .Beats(BEATS), .From(T_TURN), .To(T_INV)) u_turn_inv (
    .clk_i, .now_i(beat_i[T_TURN % BEATS]), .in_i(straight_i), .out_o(straight_inv)
  );
  rc_spread #(.Beats(BEATS), .From(T_INV), .To(T_DIR_IN)) u_inv (
    .clk_i, .beat_i, .in_i(straight_inv ? FP_ONE : inv), .out_o(inv_dir)
  );
  rc_carry #(.From(T_NN_IN), .To(T_DIR_IN)) u_n_dir (.clk_i, .in_i(n_nn), .out_o(n_dir));

  if (T_G1_IN % BEATS != (T_V_IN + 4) % BEATS || T_G_IN % BEATS != (T_V_IN + 3) % BEATS
      || T_N1_IN % BEATS != (T_N_IN + 4) % BEATS || T_N2_IN % BEATS != (T_N_IN + 3) % BEATS
      || T_ED_IN % BEATS != (T_TM_IN + 1) % BEATS || T_GV_IN % BEATS != (T_TM_IN + 3) % BEATS
      || T_DIR_IN % BEATS != (T_GG_IN + 1) % BEATS || T_NN_IN % BEATS != (T_GG_IN + 3) % BEATS) begin : gen_check
    $error("rc_bounce_dir: two operations in one beat of a unit");
  end
endmodule
