// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Second half of a T&I pipeline's arithmetic, P12 to P20: three modes on shared units (paper Fig. 5).
//
//   stage    ray-box               traversal                intersection
//   P12-P13  Fadd 3-5  far - o     Fadd 3    split - o      Fadd 3-4   h = o - A + t d
//   P14      Fmul 8-10 far t       Fmul 8    t of step 2    Fmul 8-11  h b, h g
//   P15      Fcomp 5-6             Fcomp 5-8                Fcomp 5-8  t against limits and the best hit
//   P15-P16                                                 Fadd 6-7   beta, gamma
//   P16      Fcomp 9   tmax        decide step 2            Fcomp 9    t against leaf
//   P17      Fcomp 10  hit         Fcomp 10  best, pop      Fcomp 10   t against stack
//   P17-P18                                                 Fadd 8     beta + gamma
//   P19                                                     Fcomp 11-14  edges
//
// 6 Fadd, 4 Fmul, 10 Fcomp. Never stalls. Ports carry the stage at the end of their name.
module rc_tni_back import rc_pkg::*, rc_tni_pkg::*; (
  input  logic       clk_i,
  input  vec3_t      box_lo_oper_i,
  input  vec3_t      box_hi_oper_i,
  input  mode_e      mode_oper_i,
  input  ray_const_t ray_oper_i,
  input  line_t      line_oper_i,
  input  idx_t       idx_oper_i,
  input  fp_t        tmax_oper_i,
  input  fp_t        best_oper_i,
  input  logic       best_slack_oper_i,
  input  logic       skips_oper_i,         // the triangle that the ray leaves from is in this tree
  input  entry_t     stack_next2_i,        // the stack's top
  input  step_t      step1_next1_i,
  input  logic       two_oper2_i,
  input  visit_t     visit2_oper2_i,
  input  fp_t        box_tmin_boxn_i,
  input  fp_t        ou_off_i,
  input  fp_t        ov_off_i,
  input  fp_t        t_i,
  input  fp_t        tdu_td_i,
  input  fp_t        tdv_td_i,
  input  logic       den_zero_den_i,
  // traversal
  output step_t      step_next2_o,         // where the last step leads
  output logic       two_next2_o,
  output step_t      step1_next2_o,        // its push comes first if there were two
  output entry_t     pop_next2_o,          // what a pop brings: step 1's far child, or the stack's top
  output logic       best_lt_pop_end_o,    // best hit (intersection: this hit) lies before it
  // ray-box
  output logic       box_hit_end_o,
  output fp_t        box_tmin_end_o,
  output fp_t        box_tmax_end_o,
  // intersection
  output logic       accept_end_o,         // hit, and nearer than the best
  output logic       slack_end_o,          // ... only with the edge slack
  output logic       t_le_tmax_end_o,
  output fp_t        t_end_o,
  output fp_t        beta_end_o,
  output fp_t        gamma_end_o
);
  localparam int unsigned VEC_W = 3 * FP_W;

  // ---- P_OPER to P_OPER2: the record's edges, or the box's far corner on the same way ------------------
  triaccel_t rec;
  fp_t [3:0] edges_oper, edges_oper2;
  vec3_t     far;
  assign rec = triaccel_t'(idx_oper_i[0] ? line_oper_i[7:4] : line_oper_i[3:0]);
  always_comb begin
    edges_oper = {rec.g_v, rec.g_u, rec.b_v_hi, rec.b_v_lo, rec.b_u};
    if (mode_oper_i == BOX)
      for (int i = 0; i < 3; i++) edges_oper[i] = ray_oper_i.dir[i][FP_W-1] ? box_lo_oper_i[i] : box_hi_oper_i[i];
  end
  rc_delay #(.Width(4 * FP_W), .Depth(P_OPER2 - P_OPER)) u_edges_oper2 (.clk_i, .in_i(edges_oper), .out_o(edges_oper2));
  assign far = edges_oper2[2:0];

  // ---- P_OPER2: operands of the second adders --------------------------------------------------------
  mode_e mode_oper2, mode_off2, mode_uv, mode_boxf;
  vec3_t org, dir, inv, cut_a, cut_b, off, mul, mul_off2;
  fp_t   ou, ov, tdu, tdv;
  logic [1:0] axis;
  visit_t visit2;
  rc_delay #(.Width(MODE_W + 3 * VEC_W), .Depth(P_OPER2 - P_OPER)) u_ray (
    .clk_i, .in_i({mode_oper_i, ray_oper_i.org, ray_oper_i.dir, ray_oper_i.inv_dir}),
    .out_o({mode_oper2, org, dir, inv}));
  rc_delay #(.Width(2 * FP_W), .Depth(P_OPER2 - P_OFF)) u_ouv (.clk_i, .in_i({ou_off_i, ov_off_i}), .out_o({ou, ov}));
  rc_delay #(.Width(2 * FP_W), .Depth(P_OPER2 - P_TD)) u_td (.clk_i, .in_i({tdu_td_i, tdv_td_i}), .out_o({tdu, tdv}));
  assign axis = (visit2_oper2_i.node.axis == 2'd3) ? 2'd0 : visit2_oper2_i.node.axis;
  always_comb begin
    visit2     = visit2_oper2_i;
    visit2.neg = dir[axis][FP_W-1];
    cut_a = far;
    cut_b = {fp_neg(org[2]), fp_neg(org[1]), fp_neg(org[0])};
    mul   = inv;
    if (mode_oper2 == TRAV) begin
      cut_a[0] = visit2.node.split;
      cut_b[0] = fp_neg(org[axis]);
      mul[0]   = inv[axis];
    end
    if (mode_oper2 == ISECT) begin
      cut_a = {FP_ZERO, ov, ou};
      cut_b = {FP_ZERO, tdv, tdu};
    end
  end
  for (genvar i = 0; i < 3; i++) begin : gen_cut
    rc_fp_add #(.Latency(LAT_ADD)) u_off (.clk_i, .a_i(cut_a[i]), .b_i(cut_b[i]), .y_o(off[i]));
  end

  // ---- P_OFF2: products ---------------------------------------------------------------------------------
  fp_t [3:0] edges, uv_a, uv_b, uv;
  rc_delay #(.Width(4 * FP_W), .Depth(P_OFF2 - P_OPER2)) u_edges (.clk_i, .in_i(edges_oper2), .out_o(edges));
  rc_delay #(.Width(MODE_W + VEC_W), .Depth(P_OFF2 - P_OPER2)) u_mul (
    .clk_i, .in_i({mode_oper2, mul}), .out_o({mode_off2, mul_off2}));
  assign uv_a = (mode_off2 == ISECT) ? {off[1], off[0], off[1], off[0]} : {FP_ZERO, off};
  assign uv_b = (mode_off2 == ISECT) ? edges : {FP_ZERO, mul_off2};
  for (genvar i = 0; i < 4; i++) begin : gen_uv
    rc_fp_mul #(.Latency(LAT_MUL)) u_uv (.clk_i, .a_i(uv_a[i]), .b_i(uv_b[i]), .y_o(uv[i]));
  end

  // ---- P_UV: comparisons of far t, of t at the plane, or of the hit's t ------------------------------------
  fp_t        t, best, t_limit, tmax;
  logic       best_slack, inv_huge;
  visit_t     visit2_uv;
  fp_t  [3:0] cmp_a, cmp_b;
  logic [3:0] lt, eq_unused, gt;
  rc_delay #(.Width(MODE_W + 1), .Depth(P_UV - P_OFF2)) u_mode_uv (
    .clk_i, .in_i({mode_off2, mul_off2[0][FP_W-2:0] == FP_HUGE[FP_W-2:0]}), .out_o({mode_uv, inv_huge}));
  rc_delay #(.Width(FP_W), .Depth(P_UV - P_T)) u_t (.clk_i, .in_i(t_i), .out_o(t));
  // The ray's t_min where a triangle is tested, its nearest hit so far (at first its t_max) for a box.
  rc_delay #(.Width(3 * FP_W + 1), .Depth(P_UV - P_OPER)) u_best (
    .clk_i, .in_i({best_oper_i, (mode_oper_i == ISECT) ? ray_oper_i.t_min : best_oper_i, tmax_oper_i,
                   best_slack_oper_i}),
    .out_o({best, t_limit, tmax, best_slack}));
  rc_delay #(.Width($bits(visit_t)), .Depth(P_UV - P_OPER2)) u_visit2 (.clk_i, .in_i(visit2), .out_o(visit2_uv));
  always_comb begin
    cmp_a = {4{uv[0]}};
    cmp_b = {visit2_uv.tmax, visit2_uv.tmin, ulp_down1(visit2_uv.tmin), ulp_up(visit2_uv.tmax, 23'd1)};
    if (mode_uv == BOX) begin
      cmp_a[1:0] = {t_limit, uv[1]};
      cmp_b[1:0] = {uv[2], uv[0]};
    end
    if (mode_uv == ISECT) begin
      // 0, 1: far enough away; 2: nearer if this hit is clean; 3: nearer if it used the slack.
      // t_min is positive, so that it can be compared as a pattern.
      cmp_a = {best_slack ? t : ulp_up(t, 23'd16), t, t, t};
      cmp_b = {best, best_slack ? ulp_up(best, 23'd16) : best, (t_limit > T_SLACK) ? t_limit : T_SLACK, t_limit};
    end
  end
  for (genvar i = 0; i < 4; i++) begin : gen_cmp
    rc_fp_cmp #(.Latency(LAT_CMP)) u_cmp (
      .clk_i, .a_i(cmp_a[i]), .b_i(cmp_b[i]), .lt_o(lt[i]), .eq_o(eq_unused[i]), .gt_o(gt[i]));
  end

  // ---- P_STEP2: box, the earliest of the far planes and t_max; t against the leaf -----------------------------
  fp_t  uv0, uv1, uv2, t_step2, t_max_step2, tmax_step2, early_a, early_b, early_a_boxf, early_b_boxf, box_tmax;
  logic early_lt, early_eq, early_gt_unused, t_le_tmax, clean_near, slack_near, clean_far, slack_far;
  rc_delay #(.Width(6 * FP_W), .Depth(LAT_CMP)) u_early_d (
    .clk_i, .in_i({uv[2], uv[1], uv[0], t, t_limit, tmax}), .out_o({uv2, uv1, uv0, t_step2, t_max_step2, tmax_step2}));
  rc_delay #(.Width(MODE_W), .Depth(LAT_CMP)) u_mode_boxf (.clk_i, .in_i(mode_uv), .out_o({mode_boxf}));
  always_comb begin
    early_a = lt[1] ? t_max_step2 : uv2;     // b < a of the model
    early_b = lt[0] ? uv1 : uv0;
    if (mode_boxf == ISECT) begin
      early_a = t_step2;
      early_b = tmax_step2;
    end
  end
  rc_fp_cmp #(.Latency(LAT_CMP)) u_cmp_early (
    .clk_i, .a_i(early_a), .b_i(early_b), .lt_o(early_lt), .eq_o(early_eq), .gt_o(early_gt_unused));
  rc_delay #(.Width(2 * FP_W), .Depth(LAT_CMP)) u_early (
    .clk_i, .in_i({early_a, early_b}), .out_o({early_a_boxf, early_b_boxf}));
  assign box_tmax  = early_lt ? early_a_boxf : early_b_boxf;
  assign t_le_tmax = early_lt || early_eq;
  // Of P_STEP2, until the edges are known.
  rc_delay #(.Width(4), .Depth(P_END - P_STEP2)) u_near (
    .clk_i, .in_i({lt[3], lt[2], gt[1], gt[0]}), .out_o({slack_near, clean_near, slack_far, clean_far}));
  rc_delay #(.Width(1), .Depth(P_END - P_BOXF)) u_t_le_tmax (.clk_i, .in_i(t_le_tmax), .out_o(t_le_tmax_end_o));

  // ---- P_STEP2: step 2 decides ---------------------------------------------------------------------------------
  visit_t visit2_step2;
  step_t  step2, step2_next2;
  logic   starts_in;
  logic   whole;
  rc_delay #(.Width(1), .Depth(P_UV - P_OFF2)) u_starts_in (
    .clk_i, .in_i(off[0][FP_W-2:FP_MAN_W] == '0), .out_o(starts_in));
  rc_delay #(.Width($bits(visit_t) + 1), .Depth(LAT_CMP)) u_visit2_step2 (
    .clk_i, .in_i({visit2_uv, starts_in && inv_huge}), .out_o({visit2_step2, whole}));
  rc_tni_step u_step2 (
    .visit_i(visit2_step2), .ts_i(uv0), .whole_i(whole), .near_only_i(gt[0]), .far_only_i(lt[1]), .ts_lt_tmin_i(lt[2]),
    .ts_gt_tmax_i(gt[3]), .step_o(step2));
  rc_delay #(.Width($bits(step_t)), .Depth(1)) u_step2_q (.clk_i, .in_i(step2), .out_o(step2_next2));

  // ---- P_NEXT2: both steps together ------------------------------------------------------------------------------
  rc_delay #(.Width($bits(step_t)), .Depth(P_NEXT2 - P_NEXT1)) u_step1 (
    .clk_i, .in_i(step1_next1_i), .out_o(step1_next2_o));
  rc_delay #(.Width(1), .Depth(P_NEXT2 - P_OPER2)) u_two (.clk_i, .in_i(two_oper2_i), .out_o(two_next2_o));
  assign step_next2_o = two_next2_o ? step2_next2 : step1_next2_o;
  assign pop_next2_o  = (two_next2_o && step1_next2_o.push) ? step1_next2_o.far_child : stack_next2_i;

  // ---- P_POP: box hit, or a hit's t against what a pop brings --------------------------------------------------------
  mode_e mode_pop;
  fp_t   pop_tmin, t_pop, best_pop, box_tmin_pop, box_tmax_pop, last_a, last_b;
  logic  last_lt, last_eq, last_gt_unused;
  rc_delay #(.Width(FP_W), .Depth(P_POP - P_NEXT2)) u_pop_tmin (.clk_i, .in_i(pop_next2_o.tmin), .out_o(pop_tmin));
  rc_delay #(.Width(MODE_W + 2 * FP_W), .Depth(P_POP - P_UV)) u_t_pop (
    .clk_i, .in_i({mode_uv, t, best}), .out_o({mode_pop, t_pop, best_pop}));
  rc_delay #(.Width(FP_W), .Depth(P_POP - P_BOXN)) u_box_tmin (.clk_i, .in_i(box_tmin_boxn_i), .out_o(box_tmin_pop));
  rc_delay #(.Width(FP_W), .Depth(P_POP - P_BOXF)) u_box_tmax (.clk_i, .in_i(box_tmax), .out_o(box_tmax_pop));
  assign last_a = (mode_pop == BOX) ? box_tmin_pop : (mode_pop == ISECT) ? t_pop : best_pop;
  assign last_b = (mode_pop == BOX) ? box_tmax_pop : pop_tmin;
  rc_fp_cmp #(.Latency(LAT_CMP)) u_cmp_last (
    .clk_i, .a_i(last_a), .b_i(last_b), .lt_o(last_lt), .eq_o(last_eq), .gt_o(last_gt_unused));
  rc_delay #(.Width(2), .Depth(P_END - P_POP - LAT_CMP)) u_last (
    .clk_i, .in_i({last_lt, last_lt || last_eq}), .out_o({best_lt_pop_end_o, box_hit_end_o}));
  rc_delay #(.Width(3 * FP_W), .Depth(P_END - P_POP)) u_box_end (
    .clk_i, .in_i({box_tmin_pop, box_tmax_pop, t_pop}), .out_o({box_tmin_end_o, box_tmax_end_o, t_end_o}));

  // ---- P_UV to P_END: barycentric weights and edges ----------------------------------------------------------------------
  fp_t  beta, gamma, sum, beta_sum, gamma_sum;
  logic may_hit, may_hit_end, den_zero;
  logic [8:0] eps_sum, eps;
  fp_t  eps_neg, one_eps;
  logic [9:0] one_eps_num;
  logic [3:0] in_lt, in_eq, in_gt;
  fp_t  [3:0] in_a, in_b;
  rc_fp_add #(.Latency(LAT_ADD)) u_beta (.clk_i, .a_i(uv[0]), .b_i(uv[1]), .y_o(beta));
  rc_fp_add #(.Latency(LAT_ADD)) u_gamma (.clk_i, .a_i(uv[2]), .b_i(uv[3]), .y_o(gamma));
  rc_fp_add #(.Latency(LAT_ADD)) u_sum (.clk_i, .a_i(beta), .b_i(gamma), .y_o(sum));
  rc_delay #(.Width(2 * FP_W), .Depth(P_SUM - P_BG)) u_bg (.clk_i, .in_i({beta, gamma}), .out_o({beta_sum, gamma_sum}));
  rc_delay #(.Width(2 * FP_W), .Depth(P_END - P_SUM)) u_bg_end (
    .clk_i, .in_i({beta_sum, gamma_sum}), .out_o({beta_end_o, gamma_end_o}));

  // eps = (1 + m/16) 2^-(8+e), and 1 + eps rounded up.
  assign eps = {rec.eps_e, rec.eps_m};
  rc_delay #(.Width(9), .Depth(P_SUM - P_OPER)) u_eps (.clk_i, .in_i(eps), .out_o(eps_sum));
  assign eps_neg     = {1'b1, 7'd55 - {2'b00, eps_sum[8:4]}, eps_sum[3:0], 12'd0};
  assign one_eps_num = ({1'b0, 1'b1, eps_sum[3:0], 4'd0} + (10'd1 << eps_sum[7:4]) - 10'd1) >> eps_sum[7:4];
  assign one_eps     = FP_ONE | ((eps_sum[8:4] >= 5'd9) ? fp_t'(1) : {{(FP_W - 10) {1'b0}}, one_eps_num});
  assign in_a = {sum, sum, gamma_sum, beta_sum};
  assign in_b = {FP_ONE, one_eps, eps_neg, eps_neg};
  for (genvar i = 0; i < 4; i++) begin : gen_edge
    rc_fp_cmp #(.Latency(LAT_CMP)) u_cmp (
      .clk_i, .a_i(in_a[i]), .b_i(in_b[i]), .lt_o(in_lt[i]), .eq_o(in_eq[i]), .gt_o(in_gt[i]));
  end
  assign may_hit = rec.k != 2'd3 && !(skips_oper_i && idx_oper_i == ray_oper_i.skip.tri_idx);
  rc_delay #(.Width(1), .Depth(P_END - P_OPER)) u_may_hit (.clk_i, .in_i(may_hit), .out_o(may_hit_end));
  rc_delay #(.Width(1), .Depth(P_END - P_DEN)) u_den_zero (.clk_i, .in_i(den_zero_den_i), .out_o(den_zero));

  logic edges_ok, edges_ok_end, over, over_end, slack_end;
  assign edges_ok = (in_gt[0] || in_eq[0]) && (in_gt[1] || in_eq[1]) && (in_lt[2] || in_eq[2]);
  assign over   = in_gt[3];
  rc_delay #(.Width(2), .Depth(P_END - P_SUM - LAT_CMP)) u_inside (
    .clk_i, .in_i({edges_ok, over}), .out_o({edges_ok_end, over_end}));
  assign slack_end    = negative(beta_end_o) || negative(gamma_end_o) || over_end;
  assign slack_end_o  = slack_end;
  assign accept_end_o = may_hit_end && !den_zero && edges_ok_end
                        && (slack_end ? slack_near && slack_far : clean_near && clean_far);
endmodule
