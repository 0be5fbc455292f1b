// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// First half of a T&I pipeline's arithmetic, P5 to P12: three modes on shared units (paper Fig. 5), and a fourth, ENTER, that
// brings a ray into the coordinates of a placed object, by a row r of the rotation and its centre c.
//
//   stage    ray-box               traversal                intersection              enter
//   P5-P6    Fadd 0-2  near - o    Fadd 0    split - o      Fadd 0-2   o - A          o - c
//   P5                                                      Fmul 0-1, 8  n d          r d
//   P6-P7                                                   TFadd 0    n.d            r.d: the new d
//   P7       Fmul 2-4  near t      Fmul 2    t of step 1    Fmul 2-4   n (o - A)      r (o - c)
//   P8       Fcomp 0-1, 2          Fcomp 0-3                Fcomp 0-1  best against leaf, against stack (box: Fcomp 2)
//   P8-P9                                                   TFadd 1    n.(o - A)      r.(o - c): the new o
//   P8-P9                                                   Fdiv 0     1 / n.d        1 / r.d: its inverse
//   P9       Fcomp 4   tmin        decide step 1
//   P10                                                     Fmul 5     t
//   P11                                                     Fmul 6-7   t d
//
// 3 Fadd, 2 TFadd, 9 Fmul, 5 Fcomp, 1 Fdiv. Along the triangle's axis k the normal is 1, which ENTER has no axis of. Never stalls. Ports carry the stage at the end of their name.
module rc_tni_front import rc_pkg::*, rc_tni_pkg::*; (
  input  logic       clk_i,
  input  vec3_t      box_lo_oper_i,
  input  vec3_t      box_hi_oper_i,
  input  mode_e      mode_oper_i,
  input  ray_const_t ray_oper_i,
  input  line_t      line_oper_i,       // the 64-byte block,
  input  logic [1:0] halves_oper_i,     // these halves of it
  input  idx_t       idx_oper_i,        // node or triangle in it
  input  fp_t        tmin_oper_i,
  input  fp_t        tmax_oper_i,
  input  fp_t        best_oper_i,
  input  fp_t        stack_tmin_scale_i,   // of the stack's top
  output step_t      step1_next1_o,
  output logic       two_oper2_o,       // step 2 follows, at this node and interval
  output visit_t     visit2_oper2_o,    // (neg is not set yet)
  output fp_t        box_tmin_boxn_o,
  output fp_t        ou_off_o,          // o - A along u and v
  output fp_t        ov_off_o,
  output fp_t        t_o,               // of P_T
  output fp_t        tdu_td_o,          // t d along u and v
  output fp_t        tdv_td_o,
  output logic       den_zero_den_o,    // the ray is parallel to the triangle
  output ray_axis_t  entered_quot_o,    // ENTER: a component of the ray in the object's coordinates
  output logic       best_le_tmax_step1_o,
  output logic       best_lt_stack_step1_o
);
  localparam int unsigned VEC_W = 3 * FP_W;

  // ---- P_OPER: node and record, components along their axes ----------------------------------------
  node_t      node, adjacent, other;
  triaccel_t  rec;
  logic [1:0] k, u, v, axis;
  vec3_t      cut_a, cut_b, scale_d, scale;
  fp_t        d_u, d_v, n_k;
  assign node     = node_t'(line_oper_i[idx_oper_i[2:0]]);
  assign adjacent = node_t'(line_oper_i[idx_oper_i[2:0] + 3'd1]);
  assign other    = node_t'(line_oper_i[node.other[2:0]]);
  assign axis     = (node.axis == 2'd3) ? 2'd0 : node.axis;
  assign rec      = triaccel_t'(idx_oper_i[0] ? line_oper_i[7:4] : line_oper_i[3:0]);
  assign k        = (mode_oper_i == ENTER) ? 2'd2 : (rec.k == 2'd3) ? 2'd0 : rec.k;
  assign u        = (k == 2'd2) ? 2'd0 : k + 2'd1;
  assign v        = (u == 2'd2) ? 2'd0 : u + 2'd1;
  assign d_u      = ray_oper_i.dir[u];
  assign d_v      = ray_oper_i.dir[v];
  assign n_k      = (mode_oper_i == ENTER) ? rec.b_u : FP_ONE;      // r_z lies there
  always_comb begin
    cut_b   = ray_oper_i.org;
    scale_d = ray_oper_i.inv_dir;
    for (int i = 0; i < 3; i++) cut_a[i] = ray_oper_i.dir[i][FP_W-1] ? box_hi_oper_i[i] : box_lo_oper_i[i];
    if (mode_oper_i == TRAV) begin
      cut_a[0]   = node.split;
      cut_b[0]   = ray_oper_i.org[axis];
      scale_d[0] = ray_oper_i.inv_dir[axis];
    end
    if (mode_oper_i == ISECT || mode_oper_i == ENTER) begin
      cut_a   = {ray_oper_i.org[k], ray_oper_i.org[v], ray_oper_i.org[u]};
      cut_b   = {rec.a_k, rec.a_v, rec.a_u};
      scale_d = {n_k, rec.n_v, rec.n_u};
    end
  end

  // ---- P_OPER to P_SCALE ---------------------------------------------------------------------------
  vec3_t off, scaled;
  rc_delay #(.Width(VEC_W), .Depth(P_OFF - P_OPER)) u_scale (.clk_i, .in_i(scale_d), .out_o(scale));
  for (genvar i = 0; i < 3; i++) begin : gen_cut
    rc_fp_add #(.Latency(LAT_ADD)) u_off (.clk_i, .a_i(cut_a[i]), .b_i(fp_neg(cut_b[i])), .y_o(off[i]));
    rc_fp_mul #(.Latency(LAT_MUL)) u_scaled (.clk_i, .a_i(off[i]), .b_i(scale[i]), .y_o(scaled[i]));
  end
  assign ou_off_o = off[0];
  assign ov_off_o = off[1];

  // ---- P_SCALE: comparisons of near t, of t at the plane, or of the best hit -------------------------
  mode_e      mode_scale;
  fp_t        tmin_scale, tmax_scale, best_scale;
  fp_t  [3:0] cmp_a, cmp_b;
  logic [3:0] lt, eq, gt;
  rc_delay #(.Width(MODE_W + 3 * FP_W), .Depth(P_SCALE - P_OPER)) u_state (
    .clk_i, .in_i({mode_oper_i, tmin_oper_i, tmax_oper_i, best_oper_i}),
    .out_o({mode_scale, tmin_scale, tmax_scale, best_scale}));
  always_comb begin
    cmp_a = {4{scaled[0]}};
    cmp_b = {tmax_scale, tmin_scale, ulp_down1(tmin_scale), ulp_up(tmax_scale, 23'd1)};
    if (mode_scale == BOX) begin
      cmp_a[2:0] = {best_scale, scaled[2], scaled[0]};
      cmp_b[2:0] = {stack_tmin_scale_i, FP_ZERO, scaled[1]};
    end
    if (mode_scale == ISECT) begin
      cmp_a[1:0] = {best_scale, best_scale};
      cmp_b[1:0] = {stack_tmin_scale_i, tmax_scale};
    end
  end
  for (genvar i = 0; i < 4; i++) begin : gen_cmp
    rc_fp_cmp #(.Latency(LAT_CMP)) u_cmp (
      .clk_i, .a_i(cmp_a[i]), .b_i(cmp_b[i]), .lt_o(lt[i]), .eq_o(eq[i]), .gt_o(gt[i]));
  end
  mode_e mode_step1;
  rc_delay #(.Width(MODE_W), .Depth(LAT_CMP)) u_mode_step1 (.clk_i, .in_i({mode_scale}), .out_o({mode_step1}));
  assign best_le_tmax_step1_o  = lt[0] || eq[0];
  assign best_lt_stack_step1_o = (mode_step1 == BOX) ? lt[2] : lt[1];

  // ---- P_STEP1: box, the latest of the near planes and 0 ---------------------------------------------
  vec3_t scaled_step1;
  fp_t   box_a, box_b, box_a_boxn, box_b_boxn;
  logic  box_lt, box_eq_unused, box_gt_unused;
  rc_delay #(.Width(VEC_W), .Depth(LAT_CMP)) u_scaled (.clk_i, .in_i(scaled), .out_o(scaled_step1));
  assign box_a = lt[0] ? scaled_step1[1] : scaled_step1[0];
  assign box_b = lt[1] ? FP_ZERO : scaled_step1[2];
  rc_fp_cmp #(.Latency(LAT_CMP)) u_cmp_box (
    .clk_i, .a_i(box_a), .b_i(box_b), .lt_o(box_lt), .eq_o(box_eq_unused), .gt_o(box_gt_unused));
  rc_delay #(.Width(2 * FP_W), .Depth(LAT_CMP)) u_box (
    .clk_i, .in_i({box_a, box_b}), .out_o({box_a_boxn, box_b_boxn}));
  assign box_tmin_boxn_o = box_lt ? box_b_boxn : box_a_boxn;

  // ---- P_STEP1: step 1 decides; a ray lies in the plane if it starts there and never leaves it ---------
  visit_t visit1_oper, visit1;
  logic   inv_huge, starts_in;
  step_t  step1;
  assign visit1_oper = '{node: node, idx: idx_oper_i, tmin: tmin_oper_i, tmax: tmax_oper_i,
                         neg: ray_oper_i.dir[axis][FP_W-1]};
  rc_delay #(.Width($bits(visit_t) + 1), .Depth(P_STEP1 - P_OPER)) u_visit1 (
    .clk_i, .in_i({visit1_oper, ray_oper_i.inv_dir[axis][FP_W-2:0] == FP_HUGE[FP_W-2:0]}), .out_o({visit1, inv_huge}));
  rc_delay #(.Width(1), .Depth(P_STEP1 - P_OFF)) u_starts_in (
    .clk_i, .in_i(off[0][FP_W-2:FP_MAN_W] == '0), .out_o(starts_in));
  rc_tni_step u_step1 (
    .visit_i(visit1), .ts_i(scaled_step1[0]), .whole_i(starts_in && inv_huge), .near_only_i(gt[0]),
    .far_only_i(lt[1]), .ts_lt_tmin_i(lt[2]), .ts_gt_tmax_i(gt[3]), .step_o(step1));
  rc_delay #(.Width($bits(step_t)), .Depth(1)) u_step1_q (.clk_i, .in_i(step1), .out_o(step1_next1_o));

  // ---- P_NEXT1: step 2 follows if its node lies in the same block, in a half that is here ----------------------------------------
  // Only in traversal mode: a TriAccel record read as a node can look like two steps, and step 1 like a push, which an
  // intersection's pop would take for the stack's top.
  node_t  adjacent_next1, other_next1;
  idx_t   idx_next1;
  visit_t visit2;
  logic   trav_next1, two;
  logic [1:0] halves_next1;
  rc_delay #(.Width(2 * $bits(node_t) + IDX_W + 3), .Depth(P_NEXT1 - P_OPER)) u_children (
    .clk_i, .in_i({adjacent, other, idx_oper_i, halves_oper_i, mode_oper_i == TRAV}),
    .out_o({adjacent_next1, other_next1, idx_next1, halves_next1, trav_next1}));
  assign two    = trav_next1 && step1_next1_o.go == GO_NODE && step1_next1_o.idx[IDX_W-1:3] == idx_next1[IDX_W-1:3]
                  && halves_next1[step1_next1_o.idx[2]];
  assign visit2 = '{node: step1_next1_o.adjacent ? adjacent_next1 : other_next1, idx: step1_next1_o.idx,
                    tmin: step1_next1_o.tmin, tmax: step1_next1_o.tmax, neg: 1'b0};
  rc_delay #(.Width($bits(visit_t) + 1), .Depth(P_OPER2 - P_NEXT1)) u_visit2 (
    .clk_i, .in_i({visit2, two}), .out_o({visit2_oper2_o, two_oper2_o}));

  // ---- intersection: t = -n.(o - A) / n.d, and t d ---------------------------------------------------------
  fp_t nd_u, nd_v, nd_k, den, den_quot, num, num_quot, rcp, rcp_quot, d_u_t, d_v_t;
  rc_fp_mul #(.Latency(LAT_MUL)) u_nd_u (.clk_i, .a_i(rec.n_u), .b_i(d_u), .y_o(nd_u));
  rc_fp_mul #(.Latency(LAT_MUL)) u_nd_v (.clk_i, .a_i(rec.n_v), .b_i(d_v), .y_o(nd_v));
  rc_fp_mul #(.Latency(LAT_MUL)) u_nd_k (.clk_i, .a_i(n_k), .b_i(ray_oper_i.dir[k]), .y_o(nd_k));
  rc_fp_add3 #(.Latency(LAT_ADD3)) u_den (.clk_i, .a_i(nd_u), .b_i(nd_v), .c_i(nd_k), .y_o(den));
  rc_fp_div #(.Latency(LAT_DIV)) u_rcp (.clk_i, .a_i(FP_ONE), .b_i(den), .y_o(rcp));
  assign den_zero_den_o = den[FP_W-2:FP_MAN_W] == '0;

  rc_fp_add3 #(.Latency(LAT_ADD3)) u_num (.clk_i, .a_i(scaled[0]), .b_i(scaled[1]), .c_i(scaled[2]), .y_o(num));
  rc_delay #(.Width(FP_W), .Depth(P_QUOT - P_NUM)) u_num_quot (.clk_i, .in_i(fp_neg(num)), .out_o(num_quot));
  rc_delay #(.Width(FP_W), .Depth(P_QUOT - P_RCP)) u_rcp_quot (.clk_i, .in_i(rcp), .out_o(rcp_quot));
  rc_fp_mul #(.Latency(LAT_MUL)) u_t (.clk_i, .a_i(num_quot), .b_i(rcp_quot), .y_o(t_o));

  // The ray in an object's coordinates.
  rc_delay #(.Width(FP_W), .Depth(P_QUOT - P_DEN)) u_den_quot (.clk_i, .in_i(den), .out_o(den_quot));
  assign entered_quot_o.org     = fp_neg(num_quot);
  assign entered_quot_o.dir     = den_quot;
  assign entered_quot_o.inv_dir = fp_inverse(rcp_quot);

  rc_delay #(.Width(2 * FP_W), .Depth(P_T - P_OPER)) u_d_uv (.clk_i, .in_i({d_u, d_v}), .out_o({d_u_t, d_v_t}));
  rc_fp_mul #(.Latency(LAT_MUL)) u_tdu (.clk_i, .a_i(t_o), .b_i(d_u_t), .y_o(tdu_td_o));
  rc_fp_mul #(.Latency(LAT_MUL)) u_tdv (.clk_i, .a_i(t_o), .b_i(d_v_t), .y_o(tdv_td_o));
endmodule
