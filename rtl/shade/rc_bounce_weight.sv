// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Weight of the child of a bounce (docs/whitted.md), component-serial; times in rc_bounce_pkg. Components are red, green, blue.
//   T_X    x = 1 - cosine, at least 0     T_X5   x^5               T_KR   kr' = kr, or kr tex        T_UKR  1 - kr'
//   T_RISE (1 - kr') x^5                  T_F    F = kr' + that by Schlick, or kr' + kt (total reflection)
//   T_UF   1 - F                          T_TF   kt (1 - F)        T_SH   share: T tex (refracted), w alpha' (reflected)
//   T_W    weight: w times the share, the share times R, or w (1 - alpha')         T_HEAVY  a component is > MIN_WEIGHT
module rc_bounce_weight import rc_pkg::*; import rc_shade_pkg::*; import rc_bounce_pkg::*; (
  input  logic             clk_i,
  input  fp_t              min_weight_i,
  input  logic [BEATS-1:0] beat_i,
  input  fp_t              w_i,        // T_CTX
  input  fp_t              tex_i,
  input  fp_t              rest_i,     // T_K1: 1 - alpha', if the material does not transmit
  input  fp_t              cosine_i,   // T_X_IN
  input  fp_t              kr_i,       // T_KR_IN
  input  logic             tex_kr_i,   // T_KR_IN, for all components
  input  fp_t              kt_i,       // T_F_IN
  input  turn_t            turn_i,     // T_TURN
  input  fp_t              alpha_i,    // T_SH_IN, for all components
  output fp_t              w_o,        // T_W
  output logic             heavy_o     // T_HEAVY
);
  logic [BEATS-1:0] x_beat, x5_beat;
  for (genvar k = 0; k < BEATS; k++) begin : gen_beat
    assign x_beat[k]  = beat_i[(T_X_IN + 1 + k) % BEATS];        // the trio's a comes a beat after its s
    assign x5_beat[k] = beat_i[(T_X5_IN + 1 + k) % BEATS];
  end

  // ---- x^5 ------------------------------------------------------------------------------------------------------------
  fp_t x_sum, x, x_x5, x2, x5, x5_rise, tf, tf_a, tf_b, kt_tf, uf_tf;
  assign x = fp_is_positive(x_sum) ? x_sum : FP_ZERO;
  always_comb begin
    {tf_b, tf_a} = {uf_tf, kt_tf};
    if (beat_i[T_X2_IN % BEATS]) {tf_b, tf_a} = {x, x};
    if (beat_i[T_X4_IN % BEATS]) {tf_b, tf_a} = {x2, x2};
  end
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_tf (.clk_i, .a_i(tf_a), .b_i(tf_b), .y_o(tf));
  rc_carry #(.From(T_X2), .To(T_X4_IN)) u_x2 (.clk_i, .in_i(tf), .out_o(x2));
  rc_hold #(.Beats(BEATS), .From(T_X), .To(T_X5_IN)) u_x_x5 (
    .clk_i, .now_i(beat_i[T_X % BEATS]), .in_i(x), .out_o(x_x5)
  );
  rc_spread #(.Beats(BEATS), .From(T_X5), .To(T_RISE_IN)) u_x5 (
    .clk_i, .beat_i, .in_i(x5), .out_o(x5_rise)
  );

  // ---- R and T --------------------------------------------------------------------------------------------------------
  fp_t  tex_kr, tex_sh, w_sh, w_w, product, kr_y, kr, kr_f, kr_r, ukr, ukr_rise, rise, rise_f, f, f_uf, uf;
  fp_t  kt_sh, r, r_w;
  logic fresnel_f, fresnel_r, tir_r, fresnel_sh, refract_sh, refract_w, straight_w;
  rc_carry #(.From(T_CTX), .To(T_KR_IN)) u_tex_kr (.clk_i, .in_i(tex_i), .out_o(tex_kr));
  rc_carry #(.From(T_KR_IN), .To(T_SH_IN)) u_tex_sh (.clk_i, .in_i(tex_kr), .out_o(tex_sh));
  rc_carry #(.From(T_CTX), .To(T_SH_IN)) u_w_sh (.clk_i, .in_i(w_i), .out_o(w_sh));
  rc_carry #(.From(T_SH_IN), .To(T_W_IN)) u_w_w (.clk_i, .in_i(w_sh), .out_o(w_w));
  rc_carry #(.From(T_KR), .To(T_UKR_IN)) u_kr (.clk_i, .in_i(kr_y), .out_o(kr));
  rc_carry #(.From(T_UKR_IN), .To(T_F_IN)) u_kr_f (.clk_i, .in_i(kr), .out_o(kr_f));
  rc_carry #(.From(T_F_IN), .To(T_F)) u_kr_r (.clk_i, .in_i(kr_f), .out_o(kr_r));
  rc_carry #(.From(T_UKR), .To(T_RISE_IN)) u_ukr (.clk_i, .in_i(ukr), .out_o(ukr_rise));
  rc_carry #(.From(T_RISE), .To(T_F_IN)) u_rise (.clk_i, .in_i(rise), .out_o(rise_f));
  rc_carry #(.From(T_F), .To(T_UF_IN)) u_f (.clk_i, .in_i(f), .out_o(f_uf));
  rc_carry #(.From(T_UF), .To(T_TF_IN)) u_uf (.clk_i, .in_i(uf), .out_o(uf_tf));
  rc_carry #(.From(T_F_IN), .To(T_TF_IN)) u_kt_tf (.clk_i, .in_i(kt_i), .out_o(kt_tf));
  rc_carry #(.From(T_TF_IN), .To(T_SH_IN)) u_kt_sh (.clk_i, .in_i(kt_tf), .out_o(kt_sh));
  rc_spread #(.Width(1), .Beats(BEATS), .From(T_TURN), .To(T_F_IN)) u_turn_f (
    .clk_i, .beat_i, .in_i(turn_i.fresnel), .out_o(fresnel_f)
  );
  rc_spread #(.Width(2), .Beats(BEATS), .From(T_TURN), .To(T_F)) u_turn_r (
    .clk_i, .beat_i, .in_i({turn_i.fresnel, turn_i.tir}), .out_o({fresnel_r, tir_r})
  );
  rc_spread #(.Width(2), .Beats(BEATS), .From(T_TURN), .To(T_SH_IN)) u_turn_sh (
    .clk_i, .beat_i, .in_i({turn_i.fresnel, turn_i.refract}), .out_o({fresnel_sh, refract_sh})
  );
  rc_spread #(.Width(2), .Beats(BEATS), .From(T_TURN), .To(T_W_IN)) u_turn_w (
    .clk_i, .beat_i, .in_i({turn_i.refract, turn_i.straight}), .out_o({refract_w, straight_w})
  );
  rc_trio #(.Add(1'b1)) u_add (
    .clk_i, .beat_i(x_beat), .a_i({fp_neg(f_uf), FP_ONE}), .b_i({fresnel_f ? rise_f : kt_i, kr_f}),
    .c_i({fp_neg(kr), FP_ONE}), .s_i({fp_neg(cosine_i), FP_ONE}), .a_o(uf), .b_o(f), .c_o(ukr), .s_o(x_sum)
  );
  always_comb begin
    r = kr_r;
    if (fresnel_r || tir_r) r = f;
    if (fresnel_r && tir_r) r = FP_ONE;
  end
  rc_carry #(.From(T_F), .To(T_W_IN)) u_r (.clk_i, .in_i(r), .out_o(r_w));

  // ---- weight ---------------------------------------------------------------------------------------------------------
  fp_t  sh_a, sh_b, sh_y, sh, rest_w, w_a, w_b;
  logic gt, first, heavy_q, unused_lt, unused_eq;
  always_comb begin
    {sh_b, sh_a} = {alpha_i, w_sh};
    if (refract_sh) {sh_b, sh_a} = {tex_sh, fresnel_sh ? tf : kt_sh};
  end
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_sh (.clk_i, .a_i(sh_a), .b_i(sh_b), .y_o(sh_y));
  rc_carry #(.From(T_SH), .To(T_W_IN)) u_sh (.clk_i, .in_i(sh_y), .out_o(sh));
  rc_spread #(.Beats(BEATS), .From(T_K1), .To(T_W_IN)) u_rest_w (
    .clk_i, .beat_i, .in_i(rest_i), .out_o(rest_w)
  );
  always_comb begin
    {w_b, w_a} = {r_w, sh};                                      // reflected: alpha' w R
    if (refract_w) {w_b, w_a} = {sh, w_w};                  // alpha' is 1: the material is opaque
    if (straight_w) {w_b, w_a} = {rest_w, w_w};
  end
  rc_trio u_mul (
    .clk_i, .beat_i(x5_beat), .a_i({w_b, w_a}), .b_i({x5_rise, ukr_rise}), .c_i({tex_kr, kr_i}), .s_i({x_x5, tf}),
    .a_o(w_o), .b_o(rise), .c_o(product), .s_o(x5)
  );
  logic tex_kr_y;
  fp_t  kr_same;
  rc_carry #(.Width(FP_W + 1), .From(T_KR_IN), .To(T_KR)) u_kr_same (
    .clk_i, .in_i({tex_kr_i, kr_i}), .out_o({tex_kr_y, kr_same})
  );
  assign kr_y = tex_kr_y ? product : kr_same;
  rc_fp_cmp #(.Latency(LAT_CMP)) u_cmp (
    .clk_i, .a_i(w_o), .b_i(min_weight_i), .lt_o(unused_lt), .eq_o(unused_eq), .gt_o(gt)
  );
  assign first   = beat_i[(T_W + LAT_CMP) % BEATS];
  assign heavy_o = gt || heavy_q;
  always_ff @(posedge clk_i) heavy_q <= gt || (heavy_q && !first);

  if (T_X5_IN != T_X4 || T_KR_IN % BEATS != (T_X5_IN + 4) % BEATS || T_RISE_IN % BEATS != (T_X5_IN + 2) % BEATS
      || T_W_IN % BEATS != (T_X5_IN + 1) % BEATS || T_UF_IN % BEATS != (T_X_IN + 1) % BEATS
      || T_F_IN % BEATS != (T_X_IN + 2) % BEATS || T_UKR_IN % BEATS != (T_X_IN + 4) % BEATS || T_KR_IN <= T_ETA
      || T_X4_IN % BEATS != (T_X2_IN + 1) % BEATS || T_TF_IN % BEATS != (T_X2_IN + 2) % BEATS) begin : gen_check
    $error("rc_bounce_weight: two operations in one beat of a unit");
  end
endmodule
