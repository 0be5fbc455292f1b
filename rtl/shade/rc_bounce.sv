// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Bounce unit (paper Sec. 3.3, 3.6): the reflected or the transmitted ray of a hit point, and what it weighs. A job makes one of
// them, in five cycles, so that the same functional units serve both; a bounce that may have two children is two jobs, the
// transmitted one first. Formulas in docs/whitted.md, schedule in docs/bounce.md, times in rc_bounce_pkg:
//   T_CTX   context arrives      T_ETA   flags, eta      T_K    1 - eta^2 + (eta c)^2      T_SK   its root      T_B   eta c - that
//   T_TURN  which child it is    T_O     origin          T_DIR  direction (rc_bounce_dir)
//   T_W     weight, T_HEAVY whether that is enough (rc_bounce_weight)                      T_END  all of it
// Never stalls: who starts a job must have room for what comes out.
module rc_bounce import rc_pkg::*; import rc_shade_pkg::*; import rc_bounce_pkg::*; (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  fp_t              min_weight_i,
  input  logic             ld_valid_i,       // before a frame
  input  ld_kind_e         ld_kind_i,
  input  mat_id_t          ld_idx_i,
  input  line_t            ld_line_i,
  output logic             start_beat_o,     // a job may start in this cycle
  input  logic             start_i,
  input  half_t            start_half_i,
  output logic             ctx_re_o,         // context RAM: answers a cycle later
  output ctx_addr_t        ctx_addr_o,
  input  logic [CTX_W-1:0] ctx_word_i,
  output logic [BEATS-1:0] end_beat_o,       // [0]: children come in this beat
  output ray_id_t          next_id_o,        // in the cycle before: of the job that ends
  output logic             child_valid_o,
  output half_t            child_half_o,
  output logic             child_traced_o,   // it exists, and weighs enough
  output logic             child_transmit_o,
  output child_t           child_o
);
  // ---- time: as in rc_light. The material's flags are in a slot from the third on, tir from T_SEL on ------------------
  typedef struct packed {half_t half; logic tir; optic_flags_t flags; ctx_scalar_t ctx;} slot_t;
  logic  [BEATS-1:0] beat_q;
  logic  [SLOTS-1:0] valid_q;
  slot_t [SLOTS-1:0] slot_q;
  optic_flags_t      flags;
  logic              total_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      beat_q  <= BEATS'(1);
      valid_q <= '0;
    end else begin
      beat_q <= {beat_q[BEATS-2:0], beat_q[BEATS-1]};
      if (beat_q[BEATS-1]) valid_q <= {valid_q[SLOTS-2:0], start_i};
    end
    if (beat_q[BEATS-1]) begin
      slot_q                    <= {slot_q[SLOTS-2:0], slot_q[0]};
      slot_q[0].half            <= start_half_i;
      slot_q[1].ctx             <= ctx_word_i;
      slot_q[2].flags           <= flags;
      slot_q[T_SEL / BEATS].tir <= total_q && slot_q[T_SEL / BEATS - 1].flags.transmits;
    end
  end
  assign start_beat_o = beat_q[BEATS-1];
  assign ctx_re_o     = valid_q[0] && !beat_q[BEATS-1];
  assign ctx_addr_o   = '{id: slot_q[0].half.id, word: {beat_q[2] || beat_q[3], beat_q[1] || beat_q[3]}};

  // Which child a job makes
  function automatic turn_t turn_of(slot_t s);
    logic transmitted;
    transmitted = s.half.branch ? !s.half.second : !(s.flags.reflects || s.tir);
    return '{tir: s.tir, fresnel: s.flags.fresnel, refract: transmitted && s.flags.transmits,
             straight: transmitted && !s.flags.transmits};
  endfunction

  // ---- materials, in pieces that are read when they are due; beats pass while they are loaded, too --------------------
  typedef struct packed {fp_t inv_ior; fp_t ior;} ior_t;
  material_t  ld_mat;
  optics_t    ld_optics;
  mat_flags_t ld_flags;
  logic       ld_we_mat, ld_we_optics;
  ior_t       iors;
  vec3_t      kr, kt;
  assign ld_mat       = ld_line_i;
  assign ld_optics    = ld_line_i;
  assign ld_flags     = ld_mat.flags;
  assign ld_we_mat    = ld_valid_i && ld_kind_i == LD_MATERIAL;
  assign ld_we_optics = ld_valid_i && ld_kind_i == LD_OPTICS;
  rc_ram_1r1w #(.Width($bits(optic_flags_t)), .Depth(MAX_MATERIALS)) u_flags (
    .clk_i, .we_i(ld_we_mat), .waddr_i(ld_idx_i),
    .wdata_i({ld_flags.alpha_mode != ALPHA_OPAQUE, ld_flags.tex_kr, ld_flags.fresnel, ld_flags.transmits,
              ld_flags.reflects}),
    .re_i(beat_q[T_MAT % BEATS] && !ld_valid_i), .raddr_i(slot_q[T_MAT/BEATS].ctx.mat), .rdata_o(flags)
  );
  rc_ram_1r1w #(.Width($bits(ior_t)), .Depth(MAX_MATERIALS)) u_ior (
    .clk_i, .we_i(ld_we_optics), .waddr_i(ld_idx_i), .wdata_i({ld_optics.inv_ior, ld_optics.ior}),
    .re_i(beat_q[T_MAT % BEATS] && !ld_valid_i), .raddr_i(slot_q[T_MAT/BEATS].ctx.mat), .rdata_o(iors)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(MAX_MATERIALS)) u_kr (
    .clk_i, .we_i(ld_we_optics), .waddr_i(ld_idx_i), .wdata_i({ld_optics.kr_b, ld_optics.kr_g, ld_optics.kr_r}),
    .re_i(beat_q[(T_KR_IN - 1) % BEATS] && !ld_valid_i), .raddr_i(slot_q[(T_KR_IN - 1) / BEATS].ctx.mat), .rdata_o(kr)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(MAX_MATERIALS)) u_kt (
    .clk_i, .we_i(ld_we_optics), .waddr_i(ld_idx_i), .wdata_i({ld_optics.kt_b, ld_optics.kt_g, ld_optics.kt_r}),
    .re_i(beat_q[(T_F_IN - 1) % BEATS] && !ld_valid_i), .raddr_i(slot_q[(T_F_IN - 1) / BEATS].ctx.mat), .rdata_o(kt)
  );

  // ---- Snell's law ----------------------------------------------------------------------------------------------------
  slot_t        slot_eta, slot_k1, slot_x;
  optic_flags_t flags_k1;
  fp_t          eta, eta_ce, cos_ce, snell_a, snell_b, snell_y, ee_k1, ce_cc, ce_b, cc_k, k1_k;
  fp_t          sum_a, sum_b, sum, root, sk_b, nn, nn_len;
  function automatic fp_t cosine(fp_t md);                     // between the ray and the normal; 0 beyond a right angle
    return fp_is_positive(fp_neg(md)) ? fp_neg(md) : FP_ZERO;
  endfunction
  assign slot_eta = slot_q[T_ETA/BEATS];
  assign slot_k1  = slot_q[T_K1_IN/BEATS];
  assign slot_x   = slot_q[T_X_IN/BEATS];
  assign flags_k1 = (T_K1_IN < 2 * BEATS) ? flags : slot_k1.flags;
  assign eta      = slot_eta.ctx.from_inside ? iors.ior : iors.inv_ior;
  rc_carry #(.Width(2 * FP_W), .From(T_ETA), .To(T_CE_IN)) u_eta_ce (
    .clk_i, .in_i({cosine(slot_eta.ctx.md), eta}), .out_o({cos_ce, eta_ce})
  );
  always_comb begin
    {snell_b, snell_a} = {ce_cc, ce_cc};
    if (beat_q[T_EE_IN % BEATS]) {snell_b, snell_a} = {eta, eta};
    if (beat_q[T_CE_IN % BEATS]) {snell_b, snell_a} = {cos_ce, eta_ce};
  end
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_snell (.clk_i, .a_i(snell_a), .b_i(snell_b), .y_o(snell_y));
  rc_carry #(.From(T_EE), .To(T_K1_IN)) u_ee_k1 (.clk_i, .in_i(snell_y), .out_o(ee_k1));
  rc_carry #(.From(T_CE), .To(T_CC_IN)) u_ce_cc (.clk_i, .in_i(snell_y), .out_o(ce_cc));
  rc_hold #(.Beats(BEATS), .From(T_CE), .To(T_B_IN)) u_ce_b (
    .clk_i, .now_i(beat_q[T_CE % BEATS]), .in_i(snell_y), .out_o(ce_b)
  );
  rc_carry #(.From(T_CC), .To(T_K_IN)) u_cc_k (.clk_i, .in_i(snell_y), .out_o(cc_k));
  rc_carry #(.From(T_K1), .To(T_K_IN)) u_k1_k (.clk_i, .in_i(sum), .out_o(k1_k));
  rc_carry #(.From(T_SK), .To(T_B_IN)) u_sk_b (.clk_i, .in_i(root), .out_o(sk_b));
  always_comb begin
    {sum_b, sum_a} = {fp_neg(flags_k1.transmits ? ee_k1 : slot_k1.ctx.alpha), FP_ONE};
    if (beat_q[T_K_IN % BEATS]) {sum_b, sum_a} = {cc_k, k1_k};
    if (beat_q[T_B_IN % BEATS]) {sum_b, sum_a} = {fp_neg(sk_b), ce_b};
  end
  rc_fp_add #(.Latency(LAT_ADD)) u_add_snell (.clk_i, .a_i(sum_a), .b_i(sum_b), .y_o(sum));
  always_ff @(posedge clk_i) if (beat_q[T_K % BEATS]) total_q <= !fp_is_positive(sum);
  rc_carry #(.From(T_N2), .To(T_LEN_IN)) u_nn_len (.clk_i, .in_i(nn), .out_o(nn_len));
  rc_fp_sqrt #(.Latency(LAT_SQRT)) u_sqrt (.clk_i, .a_i(beat_q[T_K % BEATS] ? sum : nn_len), .y_o(root));

  // ---- which child it is, its direction -------------------------------------------------------------------------------
  ctx_axis_t ctx;
  slot_t     slot_turn;
  turn_t     turn;
  fp_t       b_turn, factor, p_o, g_o, org, dir;
  logic      lift_o;
  assign ctx       = ctx_word_i;
  assign slot_turn = slot_q[T_TURN/BEATS];
  assign turn      = turn_of(slot_turn);
  rc_carry #(.From(T_B), .To(T_TURN)) u_b_turn (.clk_i, .in_i(sum), .out_o(b_turn));
  assign factor = turn.refract ? b_turn : fp_neg(fp_twice(slot_turn.ctx.md));
  rc_bounce_dir u_dir (
    .clk_i, .beat_i(beat_q), .d_i(ctx.d), .m_i(ctx.m), .g_i(g_o), .eta_i(eta),
    .refract_i(turn.refract), .straight_i(turn.straight), .factor_i(factor), .nn_o(nn), .len_i(root), .dir_o(dir)
  );

  // Hit points float above their triangle; a transmitted ray starts as far below.
  function automatic fp_t fp_down16(fp_t a);                     // a times 2^-16, as the multiplier makes it
    logic [FP_EXP_W-1:0] e;
    e = a[FP_MAN_W+:FP_EXP_W];
    if (e == '1) return a;
    return (e > FP_EXP_W'(16)) ? {a[FP_W-1], e - FP_EXP_W'(16), a[FP_MAN_W-1:0]} : {a[FP_W-1], {(FP_W - 1) {1'b0}}};
  endfunction
  rc_carry #(.From(T_CTX), .To(T_O_IN)) u_p_o (.clk_i, .in_i(ctx.p), .out_o(p_o));
  rc_carry #(.From(T_CTX), .To(T_O_IN)) u_g_o (.clk_i, .in_i(ctx.g), .out_o(g_o));
  rc_spread #(.Width(1), .Beats(BEATS), .From(T_TURN), .To(T_O_IN)) u_lift_o (
    .clk_i, .beat_i(beat_q), .in_i(turn.refract || turn.straight), .out_o(lift_o)
  );
  rc_fp_add #(.Latency(LAT_ADD)) u_add_o (                       // x + -0 = x
    .clk_i, .a_i(p_o), .b_i(fp_neg(lift_o ? fp_down16(g_o) : FP_ZERO)), .y_o(org)
  );

  // ---- its weight -----------------------------------------------------------------------------------------------------
  fp_t   w, alpha_sh;
  logic  heavy, heavy_end, tex_kr;
  rc_spread #(.Width(1), .Beats(BEATS), .From(T_KR_IN - 1), .To(T_KR_IN)) u_tex_kr (
    .clk_i, .beat_i(beat_q), .in_i(slot_q[(T_KR_IN - 1) / BEATS].flags.tex_kr), .out_o(tex_kr)
  );
  rc_spread #(.Beats(BEATS), .From(T_SH_IN - 1), .To(T_SH_IN)) u_alpha_sh (
    .clk_i, .beat_i(beat_q), .in_i(slot_q[(T_SH_IN - 1) / BEATS].ctx.alpha), .out_o(alpha_sh)
  );
  rc_bounce_weight u_weight (
    .clk_i, .min_weight_i, .beat_i(beat_q), .w_i(ctx.w), .tex_i(ctx.tex), .rest_i(sum),
    .cosine_i((slot_x.ctx.from_inside && slot_x.flags.transmits) ? root : cosine(slot_x.ctx.md)),
    .kr_i(component(kr, beat_q[T_KR_IN % BEATS], beat_q[(T_KR_IN + 1) % BEATS])), .tex_kr_i(tex_kr),
    .kt_i(component(kt, beat_q[T_F_IN % BEATS], beat_q[(T_F_IN + 1) % BEATS])), .turn_i(turn), .alpha_i(alpha_sh),
    .w_o(w), .heavy_o(heavy)
  );

  // ---- the end --------------------------------------------------------------------------------------------------------
  slot_t slot_end;
  turn_t turn_end;
  assign slot_end = slot_q[SLOTS-1];
  assign turn_end = turn_of(slot_end);
  rc_hold #(.Width(1), .Beats(BEATS), .From(T_HEAVY), .To(T_END)) u_heavy_end (
    .clk_i, .now_i(beat_q[T_HEAVY % BEATS]), .in_i(heavy), .out_o(heavy_end)
  );
  rc_gather #(.From(T_W), .To(T_END)) u_w (.clk_i, .in_i(w), .vec_o(child_o.w));
  rc_gather #(.From(T_O), .To(T_END)) u_org (.clk_i, .in_i(org), .vec_o(child_o.org));
  rc_gather #(.From(T_DIR), .To(T_END)) u_child_dir (.clk_i, .in_i(dir), .vec_o(child_o.dir));
  for (genvar i = 0; i < BEATS; i++) begin : gen_end_beat
    assign end_beat_o[i] = beat_q[(T_END + i) % BEATS];
  end
  assign next_id_o        = slot_q[(T_END - 1) / BEATS].half.id;
  assign child_valid_o    = valid_q[SLOTS-1] && end_beat_o[0];
  assign child_half_o     = slot_end.half;
  assign child_transmit_o = turn_end.refract || turn_end.straight;
  assign child_traced_o   = heavy_end && (turn_end.refract ? !slot_end.tir : turn_end.straight ? slot_end.flags.alpha
                                          : slot_end.flags.reflects || slot_end.tir);
  assign child_o.depth    = slot_end.ctx.depth + 1'b1;
  assign child_o.skip     = slot_end.ctx.surf;
  assign child_o.len      = slot_end.ctx.len;

  if (T_CTX != 1) begin : gen_check_ctx
    $error("rc_bounce: the scalars of the context must arrive in the last cycle of slot 0");
  end
  if (T_CC_IN % BEATS != (T_EE_IN + 2) % BEATS || T_K_IN % BEATS != (T_K1_IN + 2) % BEATS
      || T_B_IN % BEATS != (T_K1_IN + 1) % BEATS || T_LEN_IN % BEATS == T_K % BEATS || T_KR_IN < 2 * BEATS + 1
      || T_X_IN < 2 * BEATS || T_SEL < 3 * BEATS) begin : gen_check
    $error("rc_bounce: two operations in one beat of a unit");
  end
  logic unused_ld;
  assign unused_ld = ^{ld_mat, ld_optics};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      OneBeat_A: assert ($onehot(beat_q));
      Start_A:   assert (!start_i || beat_q[BEATS-1]);
    end
  end
`endif
endmodule
