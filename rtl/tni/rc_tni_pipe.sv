// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// One unified traversal and intersection pipeline (paper Sec. 3.4, Fig. 4 and 5): a ring of 21 stages
// (19 of work, one that decides, one that returns) in which up to 21 rays loop until they have their hit.
//   P1   list cache                       P5-P19  arithmetic (rc_tni_front, rc_tni_back)
//   P2   triangle index, line address     P7      stack read         P17  stack write
//   P3   node/TriAccel cache              P20     next state of the ray
//   P4   hit or miss, ray constants       P21     back to P1, or out; a free place takes a new ray
// With dynamic objects a ray goes through their top-level tree and into the trees of those whose box it meets, then through
// the static tree (Sec. 3.7); rc_tni_next has the order.
// A ray whose line is not in its L1 cache idles through the pass and asks again in the next one
// ("looping for the next chance", Sec. 3.5): nothing ever stalls, and no ray waits for another.
//
// A bad index is reported (err_*) and not looked up; the ray then idles until the unit is reset.
module rc_tni_pipe import rc_pkg::*, rc_tni_pkg::*; #(
  parameter int unsigned NtSets   = 128,   // L1 node/TriAccel cache, 2 ways x 64 bytes
  parameter int unsigned ListSets = 32,    // L1 list cache
  parameter int unsigned L1Lock   = 64     // cycles a filled line stays if not used
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  tree_cfg_t  cfg_i,
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  ray_t       in_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output hit_t       out_o,
  // to the L2 cache: [0] nodes and TriAccel, [1] lists
  output logic       [1:0] req_valid_o,
  input  logic       [1:0] req_ready_i,
  output half_addr_t [1:0] req_addr_o,
  input  logic       [1:0] fill_valid_i,
  output logic       [1:0] fill_ready_o,
  input  half_addr_t       fill_addr_i,
  input  logic             fill_both_i,
  input  line_t            fill_line_i,
  output logic       err_valid_o,
  output err_t       err_o,
  output tni_ev_t    ev_o,
  output tni_trace_t trace_o               // for simulations
);
  // ---- the ring ------------------------------------------------------------------------------------------
  logic   [P_TOP:1] v_q;                   // a ray is here
  logic   [P_TOP:1] a_q;                   // ... and works in this pass
  state_t           next, fresh, top;
  logic             next_done, done_q, loops, enter_valid;
  slot_t            enter_slot;
  fp_t              best_oper;
  logic             act_index, act_line, with_top;
  assign with_top = cfg_i.inst_count != '0;
  assign loops = v_q[P_TOP] && !done_q;
  always_comb begin
    fresh      = '0;
    fresh.slot = enter_slot;
    fresh.mode = BOX;
    // With dynamic objects first their top-level tree (Sec. 3.7), else the scene's box at once.
    fresh.level  = with_top ? TOP : SCENE;
    fresh.direct = 1'b1;
  end
  for (genvar i = 1; i <= P_TOP; i++) begin : gen_p   // a register by itself for each stage, as in rc_delay
    state_t s_q;
    if (i == 1) begin : gen_enter
      always_ff @(posedge clk_i) s_q <= loops ? top : fresh;
    end else if (i == P_OPER + 1) begin : gen_best
      always_ff @(posedge clk_i) begin
        s_q      <= gen_p[i-1].s_q;
        s_q.best <= best_oper;
      end
    end else if (i == P_TOP) begin : gen_next
      always_ff @(posedge clk_i) s_q <= next;
    end else begin : gen_pass
      always_ff @(posedge clk_i) s_q <= gen_p[i-1].s_q;
    end
  end
  assign top = gen_p[P_TOP].s_q;
  always_ff @(posedge clk_i) begin
    a_q            <= {a_q[P_TOP-1:1], 1'b1};
    a_q[P_INDEX+1] <= act_index;
    a_q[P_LINE+1]  <= act_line;
    done_q         <= next_done;
    if (!rst_ni) v_q <= '0;
    else v_q <= {v_q[P_TOP-1:1], loops || enter_valid};
  end

  // Is idx a place in a list (of triangles, or of objects in the top-level tree)? Does the box lie in a record?
  function automatic logic in_list(mode_e mode, level_e level, logic direct);
    return !direct && (mode == ISECT || (mode == BOX && level == OBJECT));
  endfunction
  function automatic logic in_record(mode_e mode, level_e level);
    return mode == BOX && level != SCENE;
  endfunction

  // ---- P_LIST: ask the list cache -------------------------------------------------------------------------
  logic  list_want, list_bad, list_hit, list_miss, list_bad_q;
  line_t list_line;
  logic [1:0] unused_halves;
  logic [3:0] unused_list;
  assign list_want = v_q[P_LIST] && in_list(gen_p[P_LIST].s_q.mode, gen_p[P_LIST].s_q.level, gen_p[P_LIST].s_q.direct);
  assign list_bad  = list_want && gen_p[P_LIST].s_q.idx >= cfg_i.list_count;
  rc_l1 #(.Sets(ListSets), .Lock(L1Lock)) u_l1_list (
    .clk_i, .rst_ni,
    .lookup_valid_i(list_want && !list_bad),
    .lookup_addr_i({cfg_i.list_base + line_addr_t'(gen_p[P_LIST].s_q.idx[IDX_W-1:4]), gen_p[P_LIST].s_q.idx[3]}),
    .hit_o(list_hit), .miss_o(list_miss), .line_o(list_line), .halves_o(unused_halves),
    .req_valid_o(req_valid_o[1]), .req_ready_i(req_ready_i[1]), .req_addr_o(req_addr_o[1]),
    .fill_valid_i(fill_valid_i[1]), .fill_ready_o(fill_ready_o[1]), .fill_addr_i, .fill_both_i, .fill_line_i,
    .ev_conflict_o(unused_list[0]), .ev_drop_o(unused_list[1]), .ev_locked_o(unused_list[2]), .busy_o(unused_list[3]));
  always_ff @(posedge clk_i) list_bad_q <= rst_ni && list_bad;

  // ---- P_INDEX: which node or triangle, and where it is -----------------------------------------------------
  state_t      si;
  list_entry_t entry;
  idx_t        what, what_q, half;          // half: of a line, where a record is
  logic        from_list, last_index, nt_any, nt_want, nt_bad, nt_want_q;
  half_addr_t  nt_addr_q;
  assign si        = gen_p[P_INDEX].s_q;
  assign entry     = si.idx[0] ? list_entry_t'(list_line[si.idx[3:1]][57:32])
                               : list_entry_t'(list_line[si.idx[3:1]][25:0]);
  assign from_list = in_list(si.mode, si.level, si.direct);
  assign what      = from_list ? entry.tri_idx : si.idx;
  assign half      = (si.mode == BOX) ? inst_half(inst_id_t'(what), BOX_HALF) : what;
  assign last_index = !from_list || entry.last;
  assign act_index = v_q[P_INDEX] && (from_list ? list_hit : 1'b1) && !nt_bad;
  assign nt_any    = si.mode == TRAV || si.mode == ISECT || si.mode == ENTER || in_record(si.mode, si.level);
  assign nt_want   = act_index && nt_any;
  assign nt_bad    = v_q[P_INDEX] && (from_list ? list_hit : nt_any) && si.mode != ENTER   // its box was there
                     && what >= ((si.mode == TRAV) ? cfg_i.node_count :
                                 (si.mode == ISECT) ? cfg_i.tri_count : cfg_i.inst_count);
  always_ff @(posedge clk_i) begin
    what_q    <= what;
    nt_want_q <= nt_want;
    nt_addr_q <= (si.mode == TRAV) ? {cfg_i.node_base + line_addr_t'(what[IDX_W-1:3]), what[2]}
                                   : {((si.mode == ISECT) ? cfg_i.accel_base : cfg_i.inst_base)
                                      + line_addr_t'(half[IDX_W-1:1]), half[0]};
  end

  // ---- P_NT, P_LINE: node/TriAccel cache, and the ray's constants ---------------------------------------------
  state_t     sl, sq;                      // also P_QUOT: what a pass ENTER made
  logic       nt_hit, nt_miss;
  logic [1:0] nt_halves, halves_oper_q;
  line_t      nt_line, line_oper_q;
  ray_const_t ray_oper;
  idx_t       what_oper;
  logic [3:0] unused_nt;
  rc_l1 #(.Sets(NtSets), .Lock(L1Lock)) u_l1_nt (
    .clk_i, .rst_ni,
    .lookup_valid_i(nt_want_q), .lookup_addr_i(nt_addr_q),
    .hit_o(nt_hit), .miss_o(nt_miss), .line_o(nt_line), .halves_o(nt_halves),
    .req_valid_o(req_valid_o[0]), .req_ready_i(req_ready_i[0]), .req_addr_o(req_addr_o[0]),
    .fill_valid_i(fill_valid_i[0]), .fill_ready_o(fill_ready_o[0]), .fill_addr_i, .fill_both_i, .fill_line_i,
    .ev_conflict_o(unused_nt[0]), .ev_drop_o(unused_nt[1]), .ev_locked_o(unused_nt[2]), .busy_o(unused_nt[3]));
  assign sl       = gen_p[P_LINE].s_q;
  assign sq       = gen_p[P_QUOT].s_q;
  assign act_line = a_q[P_LINE] && (nt_hit || sl.mode == POP || (sl.mode == BOX && !in_record(sl.mode, sl.level)));
  always_ff @(posedge clk_i) {halves_oper_q, line_oper_q} <= {nt_halves, nt_line};
  rc_delay #(.Width(IDX_W), .Depth(P_OPER - P_NT)) u_what (.clk_i, .in_i(what_q), .out_o(what_oper));

  // ---- P_OPER to P_END: arithmetic -----------------------------------------------------------------------------
  state_t so;
  entry_t stack_scale, stack_next2, pop_next2, pop;
  step_t  step1_next1, step1_next2, step_next2, step;
  visit_t visit2_oper2;
  logic   two_oper2, two_next2, two, den_zero, le_tmax_step1, lt_stack_step1, best_le_tmax, best_lt_stack, best_lt_pop;
  fp_t    box_tmin_boxn, ou, ov, t_t, tdu, tdv, box_tmin, box_tmax, t, beta, gamma;
  logic   box_hit, accept, slack, t_le_tmax;
  assign so        = gen_p[P_OPER].s_q;
  // In its first box a ray has no hit yet.
  assign best_oper = (so.mode == BOX && so.level == fresh.level) ? ray_oper.t_max : so.best;
  vec3_t     box_lo, box_hi;
  idx_t      next_oper;
  logic      placed_oper, skips_oper, placed, skips;
  ray_axis_t entered;
  rc_tni_box u_box (
    .mode_i(so.mode), .level_i(so.level), .line_i(line_oper_q), .inst_i(what_oper), .skip_i(ray_oper.skip.inst),
    .scene_lo_i(cfg_i.box_lo), .scene_hi_i(cfg_i.box_hi), .scene_root_i(cfg_i.root), .lo_o(box_lo), .hi_o(box_hi),
    .next_o(next_oper), .placed_o(placed_oper), .skips_o(skips_oper));
  rc_tni_front u_front (
    .clk_i, .box_lo_oper_i(box_lo), .box_hi_oper_i(box_hi), .mode_oper_i(so.mode), .ray_oper_i(ray_oper),
    .line_oper_i(line_oper_q), .halves_oper_i(halves_oper_q), .idx_oper_i(what_oper), .tmin_oper_i(so.tmin),
    .tmax_oper_i(so.tmax), .best_oper_i(best_oper), .stack_tmin_scale_i(stack_scale.tmin), .step1_next1_o(step1_next1),
    .two_oper2_o(two_oper2), .visit2_oper2_o(visit2_oper2), .box_tmin_boxn_o(box_tmin_boxn), .ou_off_o(ou),
    .ov_off_o(ov), .t_o(t_t), .tdu_td_o(tdu), .tdv_td_o(tdv), .den_zero_den_o(den_zero), .entered_quot_o(entered),
    .best_le_tmax_step1_o(le_tmax_step1), .best_lt_stack_step1_o(lt_stack_step1));
  rc_tni_back u_back (
    .clk_i, .box_lo_oper_i(box_lo), .box_hi_oper_i(box_hi), .mode_oper_i(so.mode), .ray_oper_i(ray_oper),
    .line_oper_i(line_oper_q), .idx_oper_i(what_oper), .tmax_oper_i(so.tmax), .best_oper_i(best_oper),
    .best_slack_oper_i(so.slack), .skips_oper_i(so.skips), .stack_next2_i(stack_next2), .step1_next1_i(step1_next1),
    .two_oper2_i(two_oper2),
    .visit2_oper2_i(visit2_oper2), .box_tmin_boxn_i(box_tmin_boxn), .ou_off_i(ou), .ov_off_i(ov), .t_i(t_t),
    .tdu_td_i(tdu), .tdv_td_i(tdv), .den_zero_den_i(den_zero), .step_next2_o(step_next2), .two_next2_o(two_next2),
    .step1_next2_o(step1_next2), .pop_next2_o(pop_next2), .best_lt_pop_end_o(best_lt_pop), .box_hit_end_o(box_hit),
    .box_tmin_end_o(box_tmin), .box_tmax_end_o(box_tmax), .accept_end_o(accept), .slack_end_o(slack),
    .t_le_tmax_end_o(t_le_tmax), .t_end_o(t), .beta_end_o(beta), .gamma_end_o(gamma));
  rc_delay #(.Width(2), .Depth(P_END - P_STEP1)) u_best (
    .clk_i, .in_i({le_tmax_step1, lt_stack_step1}), .out_o({best_le_tmax, best_lt_stack}));

  // ---- stack: read before P_SCALE, written at P_NEXT2 -------------------------------------------------------------
  state_t sr, sn;
  logic   pushes, popped1, push1, push2, overflow;
  logic [1:0] pushed_next2, pushed;
  assign sr = gen_p[P_SCALE-1].s_q;
  assign sn = gen_p[P_NEXT2].s_q;
  assign pushes  = v_q[P_NEXT2] && a_q[P_NEXT2] && sn.mode == TRAV;
  assign popped1 = two_next2 && step_next2.go == GO_POP && step1_next2.push;   // popped before it was pushed
  assign push1   = pushes && step1_next2.push && !popped1;
  assign push2   = pushes && two_next2 && step_next2.push;
  assign pushed_next2 = {1'b0, push1} + {1'b0, push2};
  assign overflow     = 32'(sn.sp) + 32'(pushed_next2) > STACK_DEPTH;
  rc_tni_stack u_stack (
    .clk_i, .rd_valid_i(v_q[P_SCALE-1] && sr.sp != '0), .rd_slot_i(sr.slot), .rd_sp_i(sr.sp), .rd_entry_o(stack_scale),
    .wr_first_i((push1 || push2) && !overflow), .wr_second_i(push1 && push2 && !overflow), .wr_slot_i(sn.slot),
    .wr_sp_i(sn.sp), .wr_entry_first_i(push1 ? step1_next2.far_child : step_next2.far_child),
    .wr_entry_second_i(step_next2.far_child));
  rc_delay #(.Width($bits(entry_t)), .Depth(P_NEXT2 - P_SCALE)) u_stack_top (
    .clk_i, .in_i(stack_scale), .out_o(stack_next2));
  logic popped1_end;
  rc_delay #(.Width($bits(step_t) + $bits(entry_t) + 4), .Depth(P_END - P_NEXT2)) u_step (
    .clk_i, .in_i({step_next2, pop_next2, pushed_next2, popped1, two_next2}),
    .out_o({step, pop, pushed, popped1_end, two}));

  // ---- P_END: what the ray does next ----------------------------------------------------------------------------------
  state_t s;
  logic   act, any_hit, opaque, last, hit_valid, enters;
  idx_t   tri_idx;                         // of a box: the root of its tree, or the first row of a placed object
  mat_t   mat;
  triaccel_t rec_oper;
  logic   unused;
  back_t  back;
  surf_t  hit_surf;
  assign rec_oper = triaccel_t'(what_oper[0] ? line_oper_q[7:4] : line_oper_q[3:0]);
  assign unused   = ^{rec_oper, sl, sq};
  assign s   = gen_p[P_END].s_q;
  assign act = v_q[P_END] && a_q[P_END];
  rc_delay #(.Width(4 + MAT_W + IDX_W), .Depth(P_END - P_OPER)) u_tri (
    .clk_i, .in_i({ray_oper.any_hit, rec_oper.opaque, placed_oper, skips_oper, rec_oper.mat,
                   (so.mode == BOX || so.mode == ENTER) ? next_oper : what_oper}),
    .out_o({any_hit, opaque, placed, skips, mat, tri_idx}));
  rc_delay #(.Width(1), .Depth(P_END - P_INDEX)) u_last (.clk_i, .in_i(last_index), .out_o(last));
  assign hit_valid = act && s.mode == ISECT && accept;
  assign hit_surf  = '{inst: (s.level == OBJECT) ? back.inst : NOT_PLACED, tri_idx: tri_idx};
  rc_tni_next u_next (
    .state_i(s), .act_i(act), .step_i(step), .pop_i(pop), .pushed_i(pushed), .popped1_i(popped1_end), .root_i(tri_idx),
    .placed_i(placed), .skips_i(skips),
    .last_i(last), .back_i(back), .box_hit_i(box_hit), .box_tmin_i(box_tmin), .box_tmax_i(box_tmax), .accept_i(accept),
    .over_i(any_hit && opaque), .t_i(t), .slack_i(slack), .t_le_tmax_i(t_le_tmax), .best_le_tmax_i(best_le_tmax),
    .best_lt_stack_i(best_lt_stack), .best_lt_pop_i(best_lt_pop), .next_o(next), .enters_o(enters), .done_o(next_done));
  rc_ram_1r1w #(.Width($bits(back_t)), .Depth(1 << SLOT_W)) u_back_to (
    .clk_i, .we_i(enters), .waddr_i(s.slot),
    .wdata_i({last, s.idx + 1'b1, s.sp, placed ? inst_of(tri_idx) : NOT_PLACED}),
    .re_i(v_q[P_END-1] && gen_p[P_END-1].s_q.level == OBJECT), .raddr_i(gen_p[P_END-1].s_q.slot), .rdata_o(back));

  rc_tni_rays u_rays (
    .clk_i, .rst_ni, .in_valid_i, .in_ready_o, .in_i, .out_valid_o, .out_ready_i, .out_o,
    .enter_valid_o(enter_valid), .enter_ready_i(!loops), .enter_slot_o(enter_slot),
    .rd_valid_i(v_q[P_LINE]), .rd_slot_i(sl.slot),
    .rd_object_i(sl.placed && sl.level == OBJECT && (sl.mode == TRAV || sl.mode == ISECT)), .rd_ray_o(ray_oper),
    .axis_valid_i(v_q[P_QUOT] && a_q[P_QUOT] && sq.mode == ENTER), .axis_slot_i(sq.slot),
    .axis_row_i(inst_half_t'(sq.idx)), .axis_i(entered),
    .hit_valid_i(hit_valid), .hit_slot_i(s.slot), .hit_surf_i(hit_surf), .hit_opaque_i(opaque), .hit_mat_i(mat),
    .hit_beta_i(beta), .hit_gamma_i(gamma),
    .done_valid_i(v_q[P_TOP] && done_q), .done_slot_i(gen_p[P_TOP].s_q.slot), .done_hit_i(gen_p[P_TOP].s_q.hit),
    .done_t_i(gen_p[P_TOP].s_q.best));

  // ---- errors and events ------------------------------------------------------------------------------------------------
  logic slots_bad, stack_bad;
  assign slots_bad = v_q[P_END] && s.slots == cfg_i.max_slots;
  assign stack_bad = pushes && overflow;
  always_ff @(posedge clk_i) begin
    err_valid_o <= rst_ni && (list_bad_q || nt_bad || stack_bad || slots_bad);
    if (list_bad_q)     err_o <= '{code: ERR_LIST, addr: addr_t'(si.idx)};
    else if (nt_bad)    err_o <= '{code: (si.mode == TRAV) ? ERR_NODE : (si.mode == ISECT) ? ERR_TRI : ERR_INST,
                                   addr: addr_t'(what)};
    else if (stack_bad) err_o <= '{code: ERR_STACK, addr: addr_t'(step_next2.idx)};
    else                err_o <= '{code: ERR_SLOTS, addr: addr_t'(s.idx)};
  end
  always_comb begin
    ev_o           = '0;
    ev_o.box       = act && (s.mode == BOX || s.mode == POP || s.mode == ENTER);
    ev_o.trav1     = act && s.mode == TRAV && !two;
    ev_o.trav2     = act && s.mode == TRAV && two;
    ev_o.isect     = act && s.mode == ISECT;
    ev_o.bubble    = !v_q[P_END];
    ev_o.miss_list = list_miss;
    ev_o.miss_nt   = nt_miss;
    ev_o.list_hit  = list_hit;
    ev_o.nt_hit    = nt_hit;
    ev_o.ray_in    = in_valid_i && in_ready_o;
    ev_o.ray_out   = out_valid_o && out_ready_i;
  end
  assign trace_o = '{
    valid: v_q[P_END], ray: s.slot, lost: !act, two: ev_o.trav2, done: next_done, slots: next.slots, out: ev_o.ray_out
  };
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (v_q[P_OPER] && a_q[P_OPER] && so.mode == TRAV) InRange_A: assert (what_oper < cfg_i.node_count);
    if (v_q[P_OPER] && a_q[P_OPER] && so.mode == ISECT) TriInRange_A: assert (what_oper < cfg_i.tri_count);
  end
`endif
endmodule
