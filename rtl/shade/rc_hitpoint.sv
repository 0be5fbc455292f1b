// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Hit-point unit (paper Sec. 3.6): from the hit of a ray on its path, its texture and its triangle to the context that lights
// and bounce need: hit point, normals, m . d, what the texture leaves of the weight. One ray in four cycles, component-serial
// (rc_shade_pkg); formulas in docs/seams.md and docs/whitted.md, schedule in docs/shade.md. Never stalls: the context RAM has
// a place for every index, and a ray enters only if the queue behind has room for all rays inside.
//   T_TD     t d, beta e1, gamma e2, n d         T_A    alpha a, in the fourth beat of t d's multiplier
//   T_P      p = o + t d                         T_Q    q = p - a
//   T_S      s = n0 + beta e1 + gamma e2         T_ND   n . d, in the fourth beat of the same adder
//   T_G      n and s turned towards the viewer   T_WAY  length of the path, in the fourth beat of q's adder
//   T_NQ     g . q        T_DELTA   lift - g . q, in the fourth beat of p's adder       T_POS  P = p + delta g
//   T_SS     s . s        T_LEN     |s|          T_INV  1 / |s|         T_M  m          T_MD   m . d
//   T_W      four words of context are written
module rc_hitpoint import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  depth_t           max_depth_i,
  input  logic [8:0]       mat_count_i,
  input  logic             ld_mat_valid_i, // before a frame
  input  mat_id_t          ld_idx_i,
  input  line_t            ld_line_i,
  input  logic             in_valid_i,
  output logic             in_ready_o,
  input  tex_t             in_i,
  input  tri_info_t        in_info_i,
  input  vec3_t            org_i,          // ray of in_i.hit.id, in the four cycles after it was taken
  input  vec3_t            dir_i,
  input  vec3_t            w_i,            // its weight, length and depth
  input  fp_t              len_i,
  input  depth_t           depth_i,
  output logic             ctx_valid_o,    // four cycles a ray
  output ctx_addr_t        ctx_addr_o,
  output logic [CTX_W-1:0] ctx_word_o,
  output logic             out_valid_o,    // after the last word
  input  logic             out_ready_i,
  output point_t           out_o,
  output logic             err_valid_o,    // one cycle
  output err_t             err_o
);
  localparam int unsigned B = HIT_BEATS;
  localparam int unsigned T_IN       = 0;
  localparam int unsigned T_TD       = T_IN + LAT_MUL;
  localparam int unsigned T_A_IN     = T_IN + 3;                                        // after the last t d
  localparam int unsigned T_A        = T_A_IN + LAT_MUL;
  localparam int unsigned T_CUT      = T_A + LAT_CMP;                                   // compared with the cutoff
  localparam int unsigned T_P        = T_TD + LAT_ADD;
  localparam int unsigned T_WAY_IN   = next_beat(T_IN, T_P + 3, B);
  localparam int unsigned T_WAY      = T_WAY_IN + LAT_ADD;
  localparam int unsigned T_Q        = T_P + LAT_ADD;
  localparam int unsigned T_S        = T_TD + LAT_ADD3;
  localparam int unsigned T_ND_IN    = T_TD + 3;
  localparam int unsigned T_ND       = T_ND_IN + LAT_ADD3;
  localparam int unsigned T_G        = T_ND + 1;
  localparam int unsigned T_GQ       = later(T_G, T_Q);                                 // operands of g q
  localparam int unsigned T_NQ_IN    = T_GQ + LAT_MUL + 2;
  localparam int unsigned T_NQ       = T_NQ_IN + LAT_ADD3;
  localparam int unsigned T_DELTA_IN = next_beat(T_NQ + 1, T_TD + 3, B);
  localparam int unsigned T_DELTA    = T_DELTA_IN + LAT_ADD;
  localparam int unsigned T_LIFT     = T_DELTA + 1 + LAT_MUL;                           // delta g
  localparam int unsigned T_POS      = T_LIFT + LAT_ADD;
  localparam int unsigned T_SS_IN    = next_beat(T_G + LAT_MUL + 2, T_NQ_IN + 1, B);
  localparam int unsigned T_LEN_IN   = T_SS_IN + LAT_ADD3;
  localparam int unsigned T_LEN      = T_LEN_IN + LAT_SQRT;
  localparam int unsigned T_INV      = T_LEN + LAT_DIV;
  localparam int unsigned T_M_IN     = T_INV + 1;
  localparam int unsigned T_M        = T_M_IN + LAT_MUL;
  localparam int unsigned T_MD_IN    = next_beat(T_M + LAT_MUL + 2, T_NQ_IN + 2, B);
  localparam int unsigned T_MD       = T_MD_IN + LAT_ADD3;
  localparam int unsigned T_W        = next_beat(later(T_POS, T_MD - 2), T_IN, B);
  localparam int unsigned SLOTS      = T_W / B + 1;                                     // rays in the pipeline
  localparam int unsigned ROOM       = 2 ** $clog2(SLOTS + 6);                          // and hit points that wait
  typedef logic [$clog2(ROOM + 1)-1:0] room_t;

  // ---- time: beat_q[k] is set in the cycles T = k, k + B, ...; valid_q[k]: there is a ray in its times k B to k B + B - 1 --
  typedef struct packed {vec3_t e2; vec3_t e1; vec3_t n0; vec3_t n; vec3_t a;} tri_t;
  logic [B-1:0]     beat_q;
  logic [SLOTS-1:0] valid_q;
  tri_t             tri_q;
  tex_t             in_q;
  mat_id_t          mat_q;
  room_t            room_q;                // rays that may enter
  logic             accept, is_x, is_y;    // x and y of everything that enters at T_IN
  assign in_ready_o = beat_q[B-1] && room_q != '0;
  assign accept     = in_valid_i && in_ready_o;
  assign {is_y, is_x} = {beat_q[(T_IN + 1) % B], beat_q[T_IN % B]};
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      beat_q  <= B'(1);
      valid_q <= '0;
      room_q  <= room_t'(ROOM);
    end else begin
      beat_q <= {beat_q[B-2:0], beat_q[B-1]};
      if (beat_q[B-1]) valid_q <= {valid_q[SLOTS-2:0], accept};
      room_q <= room_q - room_t'(accept) + room_t'(out_valid_o && out_ready_i);
    end
    if (beat_q[B-1]) begin
      in_q     <= in_i;
      mat_q    <= mat_id_t'(in_info_i.mat);
      tri_q.a  <= {in_info_i.a_z, in_info_i.a_y, in_info_i.a_x};
      tri_q.n  <= {in_info_i.n_z, in_info_i.n_y, in_info_i.n_x};
      tri_q.n0 <= {in_info_i.n0_z, in_info_i.n0_y, in_info_i.n0_x};
      tri_q.e1 <= {in_info_i.e1_z, in_info_i.e1_y, in_info_i.e1_x};
      tri_q.e2 <= {in_info_i.e2_z, in_info_i.e2_y, in_info_i.e2_x};
    end
  end
  // A record of the host's with a material that does not exist: its pixel takes another's, and the frame ends in error.
  always_ff @(posedge clk_i) begin
    err_valid_o <= rst_ni && accept && in_info_i.mat >= mat_t'(mat_count_i);
    err_o       <= '{code: ERR_MAT, addr: addr_t'(in_info_i.mat)};
  end

  // ---- what is not computed with (all of point but alpha) waits for the context to be written; rays leave in order -------
  typedef struct packed {alpha_e mode; point_t point; surf_t surf; depth_t depth; vec3_t w;} rest_t;
  typedef struct packed {mat_flags_t flags; fp_t cutoff; fp_t alpha;} rule_t;
  material_t ld_mat;
  rule_t     rule;
  rest_t     rest_in, rest;
  logic      goes_through, leave, rest_ready, rest_valid;
  logic [$clog2(SLOTS + 2)-1:0] unused_rest;
  assign ld_mat = ld_line_i;
  rc_ram_1r1w #(.Width($bits(rule_t)), .Depth(MAX_MATERIALS)) u_rules (
    .clk_i, .we_i(ld_mat_valid_i), .waddr_i(ld_idx_i), .wdata_i({ld_mat.flags, ld_mat.cutoff, ld_mat.alpha}),
    .re_i(accept), .raddr_i(mat_id_t'(in_info_i.mat)), .rdata_o(rule)
  );
  assign goes_through = rule.flags.transmits || rule.flags.alpha_mode != ALPHA_OPAQUE;
  assign rest_in = '{
    mode: rule.flags.alpha_mode, surf: in_q.hit.surf, depth: depth_i, w: w_i,
    point: '{id: in_q.hit.id, mat: mat_q, tex: in_q.rgb, alpha: '0,
             bounces: depth_i < max_depth_i && (rule.flags.reflects || goes_through),
             branch: rule.flags.reflects && goes_through}
  };
  rc_fifo #(.data_t(rest_t), .Depth(SLOTS + 1), .Ram(1'b0)) u_rest (
    .clk_i, .rst_ni,
    .in_valid_i(valid_q[0] && beat_q[0]), .in_ready_o(rest_ready), .in_data_i(rest_in),
    .out_valid_o(rest_valid), .out_ready_i(leave), .out_data_o(rest), .count_o(unused_rest)
  );

  // ---- hit point on the ray --------------------------------------------------------------------------------------
  fp_t d_in, n_in, a_in, n0_in, a_p, n0_td, o_td;
  fp_t td_a, td_b, td, be, ge;
  fp_t p_add_a, p_add_b, p_add_y, q_add_a, q_add_b, q_add_y, delta, nq_d;    // p and q are p_add_y and q_add_y
  assign d_in  = component(dir_i, is_x, is_y);
  assign n_in  = component(tri_q.n, is_x, is_y);
  assign a_in  = component(tri_q.a, is_x, is_y);
  assign n0_in = component(tri_q.n0, is_x, is_y);
  rc_carry #(.From(T_IN), .To(T_TD)) u_o_td (.clk_i, .in_i(component(org_i, is_x, is_y)), .out_o(o_td));
  assign td_a = beat_q[T_A_IN % B] ? rule.alpha : in_q.hit.t;
  assign td_b = beat_q[T_A_IN % B] ? in_q.a : d_in;
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_td (.clk_i, .a_i(td_a), .b_i(td_b), .y_o(td));
  assign p_add_a = beat_q[T_DELTA_IN % B] ? HIT_LIFT : o_td;
  assign p_add_b = beat_q[T_DELTA_IN % B] ? fp_neg(nq_d) : td;
  rc_fp_add #(.Latency(LAT_ADD)) u_add_p (.clk_i, .a_i(p_add_a), .b_i(p_add_b), .y_o(p_add_y));
  rc_carry #(.From(T_IN), .To(T_P)) u_a_p (.clk_i, .in_i(a_in), .out_o(a_p));
  assign q_add_a = beat_q[T_WAY_IN % B] ? len_i : p_add_y;
  assign q_add_b = beat_q[T_WAY_IN % B] ? in_q.hit.t : fp_neg(a_p);
  rc_fp_add #(.Latency(LAT_ADD)) u_add_q (.clk_i, .a_i(q_add_a), .b_i(q_add_b), .y_o(q_add_y));

  // ---- what the texture leaves of the weight -----------------------------------------------------------------------
  // alpha' itself is chosen in the end.
  fp_t  cutoff_a, a_cut, a_w, way_w;
  logic unused_lt, cut_eq, cut_gt, keep_w;
  rc_hold #(.Beats(B), .From(T_A_IN), .To(T_A)) u_cutoff_a (
    .clk_i, .now_i(beat_q[T_A_IN % B]), .in_i(rule.cutoff), .out_o(cutoff_a)
  );
  rc_fp_cmp #(.Latency(LAT_CMP)) u_cut (
    .clk_i, .a_i(td), .b_i(cutoff_a), .lt_o(unused_lt), .eq_o(cut_eq), .gt_o(cut_gt)
  );
  rc_carry #(.From(T_A), .To(T_CUT)) u_a_cut (.clk_i, .in_i(td), .out_o(a_cut));
  rc_hold #(.Width(1 + FP_W), .Beats(B), .From(T_CUT), .To(T_W + 3)) u_a_w (
    .clk_i, .now_i(beat_q[T_CUT % B]), .in_i({cut_eq || cut_gt, a_cut}), .out_o({keep_w, a_w})
  );
  rc_hold #(.Beats(B), .From(T_WAY), .To(T_W + 3)) u_way_w (
    .clk_i, .now_i(beat_q[T_WAY % B]), .in_i(q_add_y), .out_o(way_w)
  );

  // ---- s, and n . d in the beat that it leaves free -----------------------------------------------------------------
  fp_t   nd, s_nd, e1_in, e2_in;
  vec3_t nd_in, s_add;
  assign {e2_in, e1_in} = {component(tri_q.e2, is_x, is_y), component(tri_q.e1, is_x, is_y)};
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_be (.clk_i, .a_i(in_q.hit.beta), .b_i(e1_in), .y_o(be));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_ge (.clk_i, .a_i(in_q.hit.gamma), .b_i(e2_in), .y_o(ge));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_nd (.clk_i, .a_i(n_in), .b_i(d_in), .y_o(nd));
  rc_gather #(.From(T_TD), .To(T_ND_IN)) u_nd_in (.clk_i, .in_i(nd), .vec_o(nd_in));
  rc_carry #(.From(T_IN), .To(T_TD)) u_n0_td (.clk_i, .in_i(n0_in), .out_o(n0_td));
  assign s_add = beat_q[T_ND_IN % B] ? nd_in : {ge, be, n0_td};
  rc_fp_add3 #(.Latency(LAT_ADD3)) u_add3_s (
    .clk_i, .a_i(s_add[0]), .b_i(s_add[1]), .c_i(s_add[2]), .y_o(s_nd)
  );

  // ---- turn both normals towards the viewer; from here on all is one pipeline of g and one of s ---------------------
  logic flip, inside_w;
  fp_t  n_g, g, s_g, s_f;
  rc_hold #(.Width(1), .Beats(B), .From(T_ND), .To(T_G), .Span(3)) u_flip (
    .clk_i, .now_i(beat_q[T_ND % B]), .in_i(fp_is_positive(s_nd)), .out_o(flip)
  );
  rc_hold #(.Width(1), .Beats(B), .From(T_ND), .To(T_W + 3)) u_inside_w (
    .clk_i, .now_i(beat_q[T_ND % B]), .in_i(fp_is_positive(s_nd)), .out_o(inside_w)
  );
  rc_carry #(.From(T_IN), .To(T_G)) u_n_g (.clk_i, .in_i(n_in), .out_o(n_g));
  rc_carry #(.From(T_S), .To(T_G)) u_s_g (.clk_i, .in_i(s_nd), .out_o(s_g));
  assign g   = fp_neg_if(n_g, flip);
  assign s_f = fp_neg_if(s_g, flip);

  // ---- the second 3-input adder: g . q, s . s, m . d ------------------------------------------------------------------
  fp_t   g_gq, q_gq, gq, ss, md_prod, sum;
  vec3_t gq_in, ss_in, md_in, sum_in;
  rc_carry #(.From(T_G), .To(T_GQ)) u_g_gq (.clk_i, .in_i(g), .out_o(g_gq));
  rc_carry #(.From(T_Q), .To(T_GQ)) u_q_gq (.clk_i, .in_i(q_add_y), .out_o(q_gq));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_gq (.clk_i, .a_i(g_gq), .b_i(q_gq), .y_o(gq));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_ss (.clk_i, .a_i(s_f), .b_i(s_f), .y_o(ss));
  rc_gather #(.From(T_GQ + LAT_MUL), .To(T_NQ_IN)) u_gq_in (.clk_i, .in_i(gq), .vec_o(gq_in));
  rc_gather #(.From(T_G + LAT_MUL), .To(T_SS_IN)) u_ss_in (.clk_i, .in_i(ss), .vec_o(ss_in));
  rc_gather #(.From(T_M + LAT_MUL), .To(T_MD_IN)) u_md_in (.clk_i, .in_i(md_prod), .vec_o(md_in));
  assign sum_in = beat_q[T_NQ_IN % B] ? gq_in : beat_q[T_SS_IN % B] ? ss_in : md_in;
  rc_fp_add3 #(.Latency(LAT_ADD3)) u_add3_sum (
    .clk_i, .a_i(sum_in[0]), .b_i(sum_in[1]), .c_i(sum_in[2]), .y_o(sum)
  );

  // ---- lift the hit point ---------------------------------------------------------------------------------------------
  // g . q is flip ? -(n . q) : n . q to the bit (but for the sign of a zero, which the sum below swallows).
  fp_t g_dg, dg, p_lift, pos;
  rc_hold #(.Beats(B), .From(T_NQ), .To(T_DELTA_IN)) u_nq_d (
    .clk_i, .now_i(beat_q[T_NQ % B]), .in_i(sum), .out_o(nq_d)
  );
  rc_hold #(.Beats(B), .From(T_DELTA), .To(T_DELTA + 1), .Span(3)) u_delta (
    .clk_i, .now_i(beat_q[T_DELTA % B]), .in_i(p_add_y), .out_o(delta)
  );
  rc_carry #(.From(T_GQ), .To(T_DELTA + 1)) u_g_dg (.clk_i, .in_i(g_gq), .out_o(g_dg));
  rc_carry #(.From(T_P), .To(T_LIFT)) u_p_lift (.clk_i, .in_i(p_add_y), .out_o(p_lift));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_dg (.clk_i, .a_i(delta), .b_i(g_dg), .y_o(dg));
  rc_fp_add #(.Latency(LAT_ADD)) u_add_pos (.clk_i, .a_i(p_lift), .b_i(dg), .y_o(pos));

  // ---- shading normal -------------------------------------------------------------------------------------------------
  fp_t len, inv, inv_m, s_m, m, d_m, md;
  rc_fp_sqrt #(.Latency(LAT_SQRT)) u_sqrt (.clk_i, .a_i(sum), .y_o(len));
  rc_fp_div #(.Latency(LAT_DIV)) u_div (.clk_i, .a_i(FP_ONE), .b_i(len), .y_o(inv));
  rc_hold #(.Beats(B), .From(T_INV), .To(T_M_IN), .Span(3)) u_inv_m (
    .clk_i, .now_i(beat_q[T_INV % B]), .in_i(inv), .out_o(inv_m)
  );
  rc_carry #(.From(T_G), .To(T_M_IN)) u_s_m (.clk_i, .in_i(s_f), .out_o(s_m));
  rc_carry #(.From(T_IN), .To(T_M)) u_d_m (.clk_i, .in_i(d_in), .out_o(d_m));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_m (.clk_i, .a_i(s_m), .b_i(inv_m), .y_o(m));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_md (.clk_i, .a_i(m), .b_i(d_m), .y_o(md_prod));
  rc_hold #(.Beats(B), .From(T_MD), .To(T_W + 3)) u_md (
    .clk_i, .now_i(beat_q[T_MD % B]), .in_i(sum), .out_o(md)
  );

  // ---- the context ------------------------------------------------------------------------------------------------------
  ctx_axis_t   axis_w;
  ctx_scalar_t scalar_w;
  point_t      point_w;
  logic        at_x, at_y, at_end, point_ready;
  logic [$clog2(ROOM + 1)-1:0] unused_points;
  assign {at_end, at_y, at_x} = {beat_q[(T_W + 3) % B], beat_q[(T_W + 1) % B], beat_q[T_W % B]};
  rc_carry #(.From(T_POS), .To(T_W)) u_pos_w (.clk_i, .in_i(pos), .out_o(axis_w.p));
  rc_carry #(.From(T_DELTA + 1), .To(T_W)) u_g_w (.clk_i, .in_i(g_dg), .out_o(axis_w.g));
  rc_carry #(.From(T_M), .To(T_W)) u_m_w (.clk_i, .in_i(m), .out_o(axis_w.m));
  rc_carry #(.From(T_M), .To(T_W)) u_d_w (.clk_i, .in_i(d_m), .out_o(axis_w.d));
  assign axis_w.tex = component(rest.point.tex, at_x, at_y);
  assign axis_w.w   = component(rest.w, at_x, at_y);
  always_comb begin
    point_w       = rest.point;
    point_w.alpha = coverage(rest.mode, keep_w, a_w);
  end
  assign scalar_w = '{zero: '0, from_inside: inside_w, depth: rest.depth, len: way_w, alpha: point_w.alpha,
                      surf: rest.surf, mat: point_w.mat, md: md};
  assign leave       = valid_q[SLOTS-1] && at_end;
  assign ctx_valid_o = valid_q[SLOTS-1];
  assign ctx_addr_o  = '{id: point_w.id, word: {at_end || !(at_x || at_y), at_end || at_y}};
  assign ctx_word_o  = at_end ? scalar_w : axis_w;
  rc_fifo #(.data_t(point_t), .Depth(ROOM)) u_points (
    .clk_i, .rst_ni,
    .in_valid_i(leave), .in_ready_o(point_ready), .in_data_i(point_w),
    .out_valid_o, .out_ready_i, .out_data_o(out_o), .count_o(unused_points)
  );

  // Every shared unit is asked for one thing at a time.
  if (T_A_IN % B != (T_IN + 3) % B || T_WAY_IN % B != (T_P + 3) % B || T_WAY_IN > T_IN + 3
      || T_DELTA_IN % B != (T_TD + 3) % B || T_NQ_IN % B == T_SS_IN % B || T_NQ_IN % B == T_MD_IN % B
      || T_SS_IN % B == T_MD_IN % B || T_W % B != 0) begin : gen_check
    $error("rc_hitpoint: two operations in one beat of a unit");
  end
  logic unused_info;
  assign unused_info = ^{in_info_i.zero1, in_info_i.zero2, in_info_i.zero3, in_info_i.zero4, in_info_i.zero5,
                         in_info_i.zero6, in_info_i.zero7, in_q.hit, ld_mat, rule.flags};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      OneBeat_A:   assert ($onehot(beat_q));
      Room_A:      assert (room_q <= room_t'(ROOM));
      RestRoom_A:  assert (rest_ready && (!valid_q[SLOTS-1] || rest_valid));
      PointRoom_A: assert (!leave || point_ready);
      if (accept) IsSurface_M: assume (in_i.hit.hit && !in_i.hit.any_hit);
    end
  end
`else
  logic unused_ready;
  assign unused_ready = &{rest_ready, rest_valid, point_ready};
`endif
endmodule
