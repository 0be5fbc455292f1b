// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Light unit (paper Sec. 3.6; culling, Sec. 3.3): what one light does to one hit point, by Phong's model, and the shadow ray
// towards it. One job in five cycles, component-serial (rc_shade_pkg); formulas in docs/whitted.md, schedule in docs/shade.md.
//   T_CTX   context arrives                      T_L     l = light - P
//   T_DD    l . l       T_D   |l|                T_INV   1 / |l|         T_DIR  L = l / |l|
//   T_GL    g . L       T_ML  m . L              T_DL    d . L, all with T_DD and T_AT on one 3-input adder
//   T_AT    c + l D + q D^2                      T_ATT   1 / that, in another beat of the divider
//   T_RV    R . V, in a free beat of l's adder   T_K     the light's colour (rc_phong)         T_END  all of it
// Never stalls: a job enters only if the queue of shadow rays has room for the ray of every job inside.
module rc_light import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             shadows_i,
  input  logic             ld_valid_i,           // before a frame
  input  ld_kind_e         ld_kind_i,
  input  mat_id_t          ld_idx_i,
  input  line_t            ld_line_i,
  input  logic             job_valid_i,
  output logic             job_ready_o,
  input  job_t             job_i,
  output logic             ctx_re_o,             // context RAM, in the four cycles after a job: answers a cycle later
  output ctx_addr_t        ctx_addr_o,
  input  logic [CTX_W-1:0] ctx_word_i,
  output logic             k_valid_o,            // the light's colour, for every job
  output job_t             k_job_o,
  output vec3_t            k_o,
  output logic             upd_valid_o,          // with k_valid_o, for jobs that make no shadow ray
  output logic             upd_add_o,
  output logic             sec_valid_o,
  input  logic             sec_ready_i,
  output sec_t             sec_o,
  output logic             ev_culled_o
);
  localparam int unsigned B = LIGHT_BEATS;
  localparam int unsigned T_CTX    = 1;
  localparam int unsigned T_CTX_S  = T_CTX + 3;                                         // scalars of the context
  localparam int unsigned T_L      = T_CTX + LAT_ADD;
  localparam int unsigned T_DD_IN  = T_L + LAT_MUL + 2;
  localparam int unsigned T_DD     = T_DD_IN + LAT_ADD3;
  localparam int unsigned T_D      = T_DD + LAT_SQRT;
  localparam int unsigned T_INV    = T_D + LAT_DIV;
  localparam int unsigned T_DIR_IN = T_INV + 1;
  localparam int unsigned T_DIR    = T_DIR_IN + LAT_MUL;
  localparam int unsigned T_GL_IN  = next_beat(T_DIR + LAT_MUL + 2, T_DD_IN + 1, B);
  localparam int unsigned T_ML_IN  = next_beat(T_DIR + LAT_MUL + 2, T_DD_IN + 2, B);
  localparam int unsigned T_DL_IN  = next_beat(T_DIR + LAT_MUL + 2, T_DD_IN + 3, B);
  localparam int unsigned T_GL     = T_GL_IN + LAT_ADD3;
  localparam int unsigned T_ML     = T_ML_IN + LAT_ADD3;
  localparam int unsigned T_DL     = T_DL_IN + LAT_ADD3;
  // attenuation: products in the free beats of the multiplier of l l
  localparam int unsigned T_AL_IN  = next_beat(T_D + 1, T_L + 3, B);
  localparam int unsigned T_AQ_IN  = next_beat(T_D + 1, T_L + 4, B);
  localparam int unsigned T_AREC   = earlier(T_AL_IN, T_AQ_IN);                        // its constants are there
  localparam int unsigned T_AL     = T_AL_IN + LAT_MUL;
  localparam int unsigned T_AQ     = T_AQ_IN + LAT_MUL;
  localparam int unsigned T_AT_IN  = next_beat(later(T_AL, T_AQ) + 1, T_DD_IN + 4, B);
  localparam int unsigned T_AT     = T_AT_IN + LAT_ADD3;
  localparam int unsigned T_ATT_IN = next_beat(T_AT + 1, T_D + 1, B);
  localparam int unsigned T_ATT    = T_ATT_IN + LAT_DIV;
  // specular: 2 m.L m.d in a free beat of the multiplier of L
  localparam int unsigned T_RM_IN  = next_beat(T_ML + 1, T_DIR_IN + 3, B);
  localparam int unsigned T_RM     = T_RM_IN + LAT_MUL;
  localparam int unsigned T_RV_IN  = next_beat(later(T_RM, T_DL) + 1, T_CTX + 3, B);
  localparam int unsigned T_RV     = T_RV_IN + LAT_ADD;
  localparam int unsigned T_PHONG  = T_RV - PHONG_RV;                                   // time 0 of rc_phong
  localparam int unsigned T_TEX    = T_PHONG + PHONG_DS;
  localparam int unsigned T_K      = T_PHONG + PHONG_K;
  localparam int unsigned T_END    = T_K + 2;
  localparam int unsigned SLOTS    = T_END / B + 1;                                    // jobs in the pipeline
  localparam int unsigned ROOM     = 2 ** $clog2(SLOTS + 6);                           // and shadow rays that wait
  typedef logic [$clog2(ROOM + 1)-1:0] room_t;

  // ---- time: beat_q[k] is set in the cycles T = k, k + B, ...; slot_q[k] is the job in its times k B to k B + B - 1 -------
  // The scalars of the context arrive in the last cycle of slot 0. What only the shadow ray needs waits in rc_light_end.
  typedef struct packed {ray_id_t id; light_id_t light; mat_id_t mat;} slot_t;
  logic  [B-1:0]     beat_q;
  logic  [SLOTS-1:0] valid_q;
  job_t              job_q;                // of slot 0
  slot_t [SLOTS-1:1] slot_q;
  ctx_scalar_t       ctx_s;                // at time T_CTX_S
  room_t             room_q;               // jobs that may enter
  logic              accept, sec_pop;
  assign ctx_s       = ctx_word_i;
  assign job_ready_o = beat_q[B-1] && room_q != '0;
  assign accept      = job_valid_i && job_ready_o;
  assign sec_pop     = sec_valid_o && sec_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      beat_q  <= B'(1);
      valid_q <= '0;
      room_q  <= room_t'(ROOM);
    end else begin
      beat_q <= {beat_q[B-2:0], beat_q[B-1]};
      if (beat_q[B-1]) valid_q <= {valid_q[SLOTS-2:0], accept};
      room_q <= room_q - room_t'(accept) + room_t'(upd_valid_o) + room_t'(sec_pop);
    end
    if (beat_q[B-1]) begin
      job_q  <= job_i;
      slot_q <= {slot_q[SLOTS-2:1], {job_q.id, job_q.light, ctx_s.mat}};
    end
  end

  // ---- lights, in pieces that are read when they are due; beats pass while they are loaded, too -----------------------
  typedef struct packed {logic directional; vec3_t pos;} place_t;
  typedef struct packed {fp_t q; fp_t l; fp_t c;} atten_t;
  logic   ld_light_valid, ld_mat_valid;
  light_t ld_light;
  place_t place;
  atten_t atten;
  assign ld_light_valid = ld_valid_i && ld_kind_i == LD_LIGHT;
  assign ld_mat_valid   = ld_valid_i && ld_kind_i == LD_MATERIAL;
  assign ld_light       = ld_line_i;
  rc_ram_1r1w #(.Width($bits(place_t)), .Depth(MAX_LIGHTS)) u_place (
    .clk_i, .we_i(ld_light_valid), .waddr_i(light_id_t'(ld_idx_i)),
    .wdata_i({ld_light.directional, ld_light.pos_z, ld_light.pos_y, ld_light.pos_x}),
    .re_i(beat_q[(T_CTX - 1) % B] && !ld_light_valid), .raddr_i(job_q.light), .rdata_o(place)
  );
  rc_ram_1r1w #(.Width($bits(atten_t)), .Depth(MAX_LIGHTS)) u_atten (
    .clk_i, .we_i(ld_light_valid), .waddr_i(light_id_t'(ld_idx_i)),
    .wdata_i({ld_light.att_q, ld_light.att_l, ld_light.att_c}),
    .re_i(beat_q[(T_AREC - 1) % B] && !ld_light_valid), .raddr_i(slot_q[(T_AREC - 1) / B].light), .rdata_o(atten)
  );

  // ---- vector to the light, its length ----------------------------------------------------------------------------------
  ctx_axis_t ctx;
  fp_t       pos, pos_l, to_add_a, to_add_b, to_add_y, to, rm_rv, dl_rv;
  logic      dir_l;
  assign ctx_re_o   = valid_q[0] && !beat_q[B-1];
  assign ctx_addr_o = '{id: job_q.id, word: {beat_q[2] || beat_q[3], beat_q[1] || beat_q[3]}};
  assign ctx        = ctx_word_i;
  assign pos        = component(place.pos, beat_q[T_CTX % B], beat_q[(T_CTX + 1) % B]);
  assign to_add_a   = beat_q[T_RV_IN % B] ? dl_rv : pos;
  assign to_add_b   = fp_neg(beat_q[T_RV_IN % B] ? rm_rv : ctx.p);
  rc_fp_add #(.Latency(LAT_ADD)) u_add_to (.clk_i, .a_i(to_add_a), .b_i(to_add_b), .y_o(to_add_y));
  rc_carry #(.Width(1 + FP_W), .From(T_CTX), .To(T_L)) u_pos_l (
    .clk_i, .in_i({place.directional, pos}), .out_o({dir_l, pos_l})
  );
  assign to = dir_l ? pos_l : to_add_y;

  // The multiplier of l l makes att_l D and att_q D^2 in its free beats.
  fp_t   dd_a, dd_b, dd_y, d_al, dd_aq, sum, len, quotient;
  vec3_t dd_in, gl_in, ml_in, dl_in, at_in, sum_in;
  always_comb begin
    {dd_b, dd_a} = {to, to};
    if (beat_q[T_AL_IN % B]) {dd_b, dd_a} = {atten.l, d_al};
    if (beat_q[T_AQ_IN % B]) {dd_b, dd_a} = {atten.q, dd_aq};
  end
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_dd (.clk_i, .a_i(dd_a), .b_i(dd_b), .y_o(dd_y));
  rc_gather #(.From(T_L + LAT_MUL), .To(T_DD_IN)) u_dd_in (.clk_i, .in_i(dd_y), .vec_o(dd_in));
  always_comb begin
    sum_in = dd_in;
    if (beat_q[T_GL_IN % B]) sum_in = gl_in;
    if (beat_q[T_ML_IN % B]) sum_in = ml_in;
    if (beat_q[T_DL_IN % B]) sum_in = dl_in;
    if (beat_q[T_AT_IN % B]) sum_in = at_in;
  end
  rc_fp_add3 #(.Latency(LAT_ADD3)) u_add3 (.clk_i, .a_i(sum_in[0]), .b_i(sum_in[1]), .c_i(sum_in[2]), .y_o(sum));
  rc_fp_sqrt #(.Latency(LAT_SQRT)) u_sqrt (.clk_i, .a_i(sum), .y_o(len));

  // ---- attenuation --------------------------------------------------------------------------------------------------------
  fp_t  at_div, att, att_phong;
  logic dir_att;
  rc_hold #(.Beats(B), .From(T_D), .To(T_AL_IN)) u_d_al (
    .clk_i, .now_i(beat_q[T_D % B]), .in_i(len), .out_o(d_al)
  );
  rc_hold #(.Beats(B), .From(T_DD), .To(T_AQ_IN)) u_dd_aq (
    .clk_i, .now_i(beat_q[T_DD % B]), .in_i(sum), .out_o(dd_aq)
  );
  rc_hold #(.Beats(B), .From(T_AREC), .To(T_AT_IN)) u_ac_at (
    .clk_i, .now_i(beat_q[T_AREC % B]), .in_i(atten.c), .out_o(at_in[0])
  );
  rc_hold #(.Beats(B), .From(T_AL), .To(T_AT_IN)) u_al_at (
    .clk_i, .now_i(beat_q[T_AL % B]), .in_i(dd_y), .out_o(at_in[1])
  );
  rc_hold #(.Beats(B), .From(T_AQ), .To(T_AT_IN)) u_aq_at (
    .clk_i, .now_i(beat_q[T_AQ % B]), .in_i(dd_y), .out_o(at_in[2])
  );
  rc_hold #(.Beats(B), .From(T_AT), .To(T_ATT_IN)) u_at_div (
    .clk_i, .now_i(beat_q[T_AT % B]), .in_i(sum), .out_o(at_div)
  );
  rc_fp_div #(.Latency(LAT_DIV)) u_div (
    .clk_i, .a_i(FP_ONE), .b_i(beat_q[T_ATT_IN % B] ? at_div : len), .y_o(quotient)
  );
  rc_hold #(.Width(1), .Beats(B), .From(T_CTX), .To(T_ATT)) u_dir_att (
    .clk_i, .now_i(beat_q[T_CTX % B]), .in_i(place.directional), .out_o(dir_att)
  );
  assign att = dir_att ? FP_ONE : quotient;
  rc_hold #(.Beats(B), .From(T_ATT), .To(T_PHONG + PHONG_ATT)) u_att_phong (
    .clk_i, .now_i(beat_q[T_ATT % B]), .in_i(att), .out_o(att_phong)
  );

  // ---- direction to the light, and what it makes with normals and view -------------------------------------------------------
  fp_t inv, to_dir, ml_rm, md_rm, dir_a, dir_b, dir, g_dir, m_dir, d_dir, gl, ml, dl;
  rc_hold #(.Beats(B), .From(T_INV), .To(T_DIR_IN), .Span(3)) u_inv (
    .clk_i, .now_i(beat_q[T_INV % B]), .in_i(quotient), .out_o(inv)
  );
  rc_carry #(.From(T_L), .To(T_DIR_IN)) u_to_dir (.clk_i, .in_i(to), .out_o(to_dir));
  rc_hold #(.Beats(B), .From(T_CTX_S), .To(T_RM_IN)) u_md_rm (
    .clk_i, .now_i(beat_q[T_CTX_S % B]), .in_i(ctx_s.md), .out_o(md_rm)
  );
  assign dir_a = beat_q[T_RM_IN % B] ? fp_twice(ml_rm) : to_dir;
  assign dir_b = beat_q[T_RM_IN % B] ? md_rm : inv;
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_dir (.clk_i, .a_i(dir_a), .b_i(dir_b), .y_o(dir));
  rc_carry #(.From(T_CTX), .To(T_DIR)) u_g_dir (.clk_i, .in_i(ctx.g), .out_o(g_dir));
  rc_carry #(.From(T_CTX), .To(T_DIR)) u_m_dir (.clk_i, .in_i(ctx.m), .out_o(m_dir));
  rc_carry #(.From(T_CTX), .To(T_DIR)) u_d_dir (.clk_i, .in_i(ctx.d), .out_o(d_dir));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_gl (.clk_i, .a_i(g_dir), .b_i(dir), .y_o(gl));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_ml (.clk_i, .a_i(m_dir), .b_i(dir), .y_o(ml));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_dl (.clk_i, .a_i(d_dir), .b_i(dir), .y_o(dl));
  rc_gather #(.From(T_DIR + LAT_MUL), .To(T_GL_IN)) u_gl_in (.clk_i, .in_i(gl), .vec_o(gl_in));
  rc_gather #(.From(T_DIR + LAT_MUL), .To(T_ML_IN)) u_ml_in (.clk_i, .in_i(ml), .vec_o(ml_in));
  rc_gather #(.From(T_DIR + LAT_MUL), .To(T_DL_IN)) u_dl_in (.clk_i, .in_i(dl), .vec_o(dl_in));

  // ---- R . V = d.L - 2 m.L m.d, with R the mirrored L, V = -d ---------------------------------------------------------------
  fp_t   ml_rv, k_axis;
  vec3_t tex, tex_phong;
  rc_hold #(.Beats(B), .From(T_ML), .To(T_RM_IN)) u_ml_rm (
    .clk_i, .now_i(beat_q[T_ML % B]), .in_i(sum), .out_o(ml_rm)
  );
  rc_hold #(.Beats(B), .From(T_RM), .To(T_RV_IN)) u_rm_rv (
    .clk_i, .now_i(beat_q[T_RM % B]), .in_i(dir), .out_o(rm_rv)
  );
  rc_hold #(.Beats(B), .From(T_DL), .To(T_RV_IN)) u_dl_rv (
    .clk_i, .now_i(beat_q[T_DL % B]), .in_i(sum), .out_o(dl_rv)
  );
  rc_hold #(.Beats(B), .From(T_ML), .To(T_RV)) u_ml_rv (
    .clk_i, .now_i(beat_q[T_ML % B]), .in_i(sum), .out_o(ml_rv)
  );
  logic [B-1:0] phong_beat;
  for (genvar k = 0; k < B; k++) begin : gen_phong_beat
    assign phong_beat[k] = beat_q[(T_PHONG + k) % B];
  end
  rc_gather #(.From(T_CTX), .To(T_CTX_S)) u_tex (.clk_i, .in_i(ctx.tex), .vec_o(tex));
  rc_keep #(.Width($bits(vec3_t)), .Beats(B), .From(T_CTX_S), .To(T_TEX)) u_tex_phong (
    .clk_i, .rst_ni, .now_i(beat_q[T_CTX_S % B]), .next_i(beat_q[(T_TEX - 1) % B]), .in_i(tex), .out_o(tex_phong)
  );
  rc_phong u_phong (
    .clk_i, .beat_i(phong_beat),
    .ld_light_valid_i(ld_light_valid), .ld_mat_valid_i(ld_mat_valid), .ld_idx_i, .ld_line_i,
    .light_i(slot_q[T_PHONG / B].light), .mat_i(slot_q[T_PHONG / B].mat),
    .rv_i(to_add_y), .ml_i(ml_rv), .tex_i(tex_phong), .att_i(att_phong), .k_o(k_axis)
  );

  // ---- the end -------------------------------------------------------------------------------------------------------------
  rc_gather #(.From(T_K), .To(T_END)) u_k (.clk_i, .in_i(k_axis), .vec_o(k_o));
  assign k_valid_o = valid_q[SLOTS-1] && beat_q[T_END % B];
  rc_light_end #(
    .TCtx(T_CTX), .TCtxS(T_CTX_S), .TD(T_D), .TDir(T_DIR), .TGl(T_GL), .TMl(T_ML), .TAtt(T_ATT), .TEnd(T_END),
    .Room(ROOM)
  ) u_end (
    .clk_i, .rst_ni, .shadows_i, .beat_i(beat_q), .end_i(k_valid_o), .id_i(slot_q[SLOTS-1].id),
    .light_i(slot_q[SLOTS-1].light), .t_min_i(job_q.t_min), .point_i(ctx.p), .scalar_i(ctx_s), .sum_i(sum), .len_i(len),
    .dir_i(dir), .directional_i(dir_att), .k_job_o, .upd_valid_o, .upd_add_o, .sec_valid_o, .sec_ready_i, .sec_o,
    .ev_culled_o
  );

  // Every shared unit is asked for one thing at a time.
  if (T_CTX_S != B - 1) begin : gen_check_ctx
    $error("rc_light: the scalars of the context must arrive in the last cycle of slot 0");
  end
  if (T_GL_IN % B != (T_DD_IN + 1) % B || T_ML_IN % B != (T_DD_IN + 2) % B || T_DL_IN % B != (T_DD_IN + 3) % B
      || T_AT_IN % B != (T_DD_IN + 4) % B || T_ATT_IN % B == T_D % B || T_RV_IN % B != (T_CTX + 3) % B
      || T_AL_IN % B != (T_L + 3) % B || T_AQ_IN % B != (T_L + 4) % B
      || T_RM_IN % B != (T_DIR_IN + 3) % B) begin : gen_check
    $error("rc_light: two operations in one beat of a unit");
  end
  logic unused;
  assign unused = ^{ld_light, ctx.w, ctx_s};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      OneBeat_A: assert ($onehot(beat_q));
      Room_A:    assert (room_q <= room_t'(ROOM));
    end
  end
`endif
endmodule
