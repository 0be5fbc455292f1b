// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// What a sorting pipeline does next: depth first, the adjacent child last, so that nodes come in post-order.
//   job    load, sort, sweep: the root's best plane
//   node   no plane that pays: leaf. Else: class of its references and their lists; then the children's lists of events
//          and best planes in one sweep, if one of them has more references than a leaf
//   stack  a frame for each node whose children are being made, with the adjacent child while the other one is made
// A leaf's list goes out while the next node begins. Where a list of references or events would not fit its memory a leaf
// is made, and counted (ev_forced_o).
module rc_tbp_sort_ctrl import rc_pkg::*, rc_tbu_pkg::*, rc_tbp_sort_pkg::*; #(
  parameter int unsigned Cap    = 1280,    // references
  parameter int unsigned DonMin = 64       // references of a child that is worth donating
) (
  input  logic            clk_i,
  input  logic            rst_ni,
  input  logic            job_valid_i,
  output logic            job_ready_o,
  input  sort_job_t       job_i,
  input  logic            ref_valid_i,
  output logic            ref_ready_o,
  input  logic [TRI_W-1:0] ref_tri_idx_i,
  output logic            start_o,         // a job begins
  output logic            ld_valid_o,      // a reference is loaded
  output logic            ld_sort_o,
  output ref_t            ld_idx_o,
  output logic            sort_end_o,
  output num_t            sort_max_o,
  input  logic            sort_busy_i,
  input  logic            sort_side_i,
  output logic            area_start_o,
  output box_t [1:0]      box_o,           // of the children
  output num_t [1:0]      num_refs_o,
  output box_t            node_box_o,
  output logic            pl_o,
  output logic            walk_start_o,
  output walk_t           walk_o,
  input  logic            dividing_i,
  input  logic            walk_busy_i,
  input  num_t [1:0]      walk_num_i,
  input  logic [1:0][TRI_W-1:0] last_tri_idx_i,
  input  num_t [2:0][1:0] num_events_i,
  output logic            sweep_start_o,
  output sweep_t [2:0]    sweep_o,
  input  logic            sweep_busy_i,
  input  logic  [1:0]     found_i,         // of child 0 and 1, a cycle after the sweep
  input  plane_t [1:0]    plane_i,
  output logic            list_valid_o,    // a leaf's list is to begin
  output num_t            list_num_o,
  input  logic            list_ready_i,
  input  idx_t            list_idx_i,
  output logic            node_valid_o,
  input  logic            node_ready_i,
  output node_t           node_o,
  output logic            node_adj_o,
  output logic            node_skip_o,
  output logic [5:0]      node_gap_o,
  input  idx_t            node_idx_i,
  output logic            flush_o,
  input  logic            flushed_i,
  output logic            sub_valid_o,
  input  logic            sub_ready_i,
  output subtree_t        sub_o,
  input  logic            don_want_i,
  output logic            don_valid_o,
  input  logic            don_ready_i,
  output sort_job_t       don_job_o,
  input  logic            ent_valid_i,
  output logic            ent_ready_o,
  input  logic [6:0]      ent_idx_i,
  output logic            upper_valid_o,
  input  logic            upper_ready_i,
  output donated_t        upper_o,
  output logic            active_o,
  output logic            ev_forced_o
);
  typedef enum logic [4:0] {
    IDLE, LOAD, DRAIN, SORT, SWEEP, PICK, ROOT, PUSH, SPLIT, DONATE, CLASS, KEEP, LEAF, BACK, TOP, UPPER, FLUSH, REPORT
  } state_e;
  state_e     state_q, state_d;
  tnode_t     cur_q;                       // the node in work
  dest_t      dest_q;
  logic [5:0] gap_q;
  logic       root_q, odd_q, small_job, donate_q;
  num_t       loaded_q;
  logic [2:0] drain_q;
  ptr_t       refs_free_q;                 // highest free places below B's lists
  ptr_t [2:0] free_q;

  // ---- a job ---------------------------------------------------------------------------------------------------------
  assign job_ready_o = state_q == IDLE;
  assign start_o     = job_ready_o && job_valid_i;
  assign active_o    = state_q != IDLE;
  assign ref_ready_o = state_q == LOAD && !odd_q && loaded_q != cur_q.count;
  assign ld_valid_o  = ref_valid_i && ref_ready_o;
  assign ld_idx_o    = ref_t'(loaded_q);
  assign small_job   = cur_q.count <= num_t'(MAX_LEAF) || cur_q.level >= level_t'(MAX_DEPTH);
  assign ld_sort_o   = !small_job;
  assign sort_end_o  = state_q == DRAIN && drain_q == '0;
  assign sort_max_o  = small_job ? '0 : cur_q.count << 1;

  // ---- the node's children ---------------------------------------------------------------------------------------------
  logic         both, refs_fit, misfit, first, divide, donate, other;
  logic [1:0]   keep, keep_q, found_q;
  plane_t [1:0] plane_q;
  tnode_t [1:0] child;
  ptr_t         refs_free;
  ptr_t [2:0]   free;
  logic [6:0]   entry_q;
  rc_tbp_sort_split u_split (
    .node_i(cur_q), .root_i(root_q), .donate_i(donate_q), .refs_free_i(refs_free_q), .free_i(free_q), .num_events_i,
    .keep_i(keep_q), .found_i(found_q), .plane_i(plane_q), .last_tri_idx_i, .both_o(both), .refs_fit_o(refs_fit),
    .misfit_o(misfit), .keep_o(keep), .box_o, .num_refs_o, .walk_o, .sweep_o, .child_o(child), .first_o(first),
    .refs_free_o(refs_free), .free_o(free)
  );
  assign node_box_o    = cur_q.box;
  assign pl_o          = cur_q.plane.pl;
  assign other         = !cur_q.b_upper;   // the other child: 1 the upper one
  assign divide        = state_q == SPLIT && refs_fit && !walk_busy_i;
  assign donate        = don_want_i && ent_valid_i && both && num_refs_o[other] >= num_t'(DonMin);
  assign ent_ready_o   = divide && donate;
  assign don_valid_o   = state_q == DONATE;
  assign don_job_o     = '{dest: '{root: 1'b0, upper: other, entry: entry_q}, gap: '0,
                           level: cur_q.level + level_t'(1), count: count_t'(num_refs_o[other]), box: box_o[other]};
  assign area_start_o  = divide || sort_end_o;
  assign walk_start_o  = (divide && !donate) || (don_valid_o && don_ready_i)
                         || (state_q == LEAF && node_ready_i && cur_q.count > num_t'(1));
  assign sweep_start_o = (state_q == SORT && !sort_busy_i) || (state_q == KEEP && keep != '0);
  assign ev_forced_o   = (state_q == SPLIT && !refs_fit) || (state_q == KEEP && misfit);

  // ---- stack and nodes -------------------------------------------------------------------------------------------------
  logic       top_donated, top_late, pop;
  logic [5:0] depth;                       // frames
  tnode_t     waiting;
  frame_t     frame;
  node_t      top_node;
  fp_t        split;
  donated_t   upper;
  idx_t       back_q;                      // root of the subtree that was made last
  rc_fp_from_int #(.IntW(COORD_W), .FracW(COORD_W - 1)) u_split_plane (
    .clk_i, .int_i({~cur_q.plane.pos[COORD_W-1], cur_q.plane.pos[COORD_W-2:0]}), .y_o(split)   // q - 2^17
  );
  assign frame = '{axis: cur_q.plane.axis, pos: cur_q.plane.pos, split: split, swap: cur_q.swap,
                   lower_empty: cur_q.plane.nl == '0, upper_empty: cur_q.plane.nr == '0, donated: donate_q,
                   entry: entry_q};
  rc_tbp_sort_stack u_stack (
    .clk_i, .rst_ni, .clear_i(start_o), .push_i(state_q == PUSH), .frame_i(frame), .late_i(!both || donate_q),
    .waiting_i(child[cur_q.b_upper]), .turn_i(state_q == TOP && !top_late), .back_i(back_q), .pop_i(pop),
    .depth_o(depth), .late_o(top_late), .waiting_o(waiting), .donated_o(top_donated), .upper_o(upper), .node_o(top_node)
  );
  assign list_num_o    = cur_q.count;
  assign list_valid_o  = state_q == LEAF && cur_q.count > num_t'(1) && !walk_busy_i;
  assign node_valid_o  = (state_q == LEAF && (cur_q.count <= num_t'(1) || (list_valid_o && list_ready_i)))
                         || (state_q == TOP && top_late);
  assign pop           = state_q == TOP && top_late && node_ready_i;
  assign node_adj_o    = state_q == TOP;
  assign node_skip_o   = state_q == TOP && top_donated;
  assign node_gap_o    = (depth == 6'(state_q == TOP)) ? gap_q : '0;
  always_comb begin
    node_o = top_node;
    if (state_q == LEAF) begin
      node_o       = '0;
      node_o.split = fp_t'(cur_q.count);
      node_o.axis  = 2'd3;
      if (cur_q.count == num_t'(1)) node_o.other = idx_t'(cur_q.tri_idx);
      else if (cur_q.count != '0) node_o.other = list_idx_i;
    end
  end
  assign flush_o       = state_q == FLUSH && !walk_busy_i;
  assign sub_valid_o   = state_q == REPORT;
  assign sub_o         = '{dest: dest_q, idx: back_q};
  assign upper_valid_o = state_q == UPPER;
  always_comb begin
    upper_o     = upper;
    upper_o.idx = back_q;
  end

  // ---- sequence --------------------------------------------------------------------------------------------------------
  always_comb begin
    state_d = state_q;
    unique case (state_q)
      IDLE:    if (job_valid_i) state_d = LOAD;
      LOAD:    if (loaded_q == cur_q.count) state_d = DRAIN;
      DRAIN:   if (drain_q == '0) state_d = small_job ? LEAF : SORT;
      SORT:    if (!sort_busy_i) state_d = SWEEP;
      SWEEP:   if (!sweep_busy_i) state_d = PICK;
      PICK:    state_d = root_q ? ROOT : PUSH;
      ROOT:    state_d = child[0].split ? SPLIT : LEAF;
      PUSH:    state_d = child[first].split ? SPLIT : LEAF;
      SPLIT:   if (!refs_fit) state_d = LEAF;
               else if (divide) state_d = donate ? DONATE : CLASS;
      DONATE:  if (don_ready_i) state_d = CLASS;
      CLASS:   if (!dividing_i) state_d = KEEP;
      KEEP:    state_d = (keep == '0) ? PUSH : SWEEP;
      LEAF:    if (node_ready_i) state_d = (depth == '0) ? FLUSH : TOP;
      BACK:    state_d = (depth == '0) ? FLUSH : TOP;             // the stack reads the next frame
      TOP:     if (!top_late) state_d = waiting.split ? SPLIT : LEAF;
               else if (node_ready_i) state_d = top_donated ? UPPER : BACK;
      UPPER:   if (upper_ready_i) state_d = BACK;
      FLUSH:   if (flushed_i && !walk_busy_i) state_d = REPORT;
      REPORT:  if (sub_ready_i) state_d = IDLE;
      default: state_d = IDLE;
    endcase
  end

  always_ff @(posedge clk_i) begin
    if (!rst_ni) state_q <= IDLE;
    else state_q <= state_d;
    odd_q   <= ld_valid_o;                 // two events a reference
    drain_q <= (state_q == DRAIN) ? drain_q - 3'd1 : 3'd6;
    if (ld_valid_o) loaded_q <= loaded_q + num_t'(1);
    unique case (state_q)
      IDLE: begin
        {dest_q, gap_q, cur_q} <= {job_i.dest, job_i.gap, tnode_t'(0)};
        {cur_q.level, cur_q.count, cur_q.box} <= {job_i.level, num_t'(job_i.count), job_i.box};
        for (int a = 0; a < 3; a++) if (job_i.box.hi[a] < job_i.box.lo[a]) cur_q.box.hi[a] <= job_i.box.lo[a];
        {root_q, donate_q, loaded_q} <= {1'b1, 1'b0, num_t'(0)};
        refs_free_q <= ptr_t'(2 * Cap - 1);
        free_q      <= {3{ptr_t'(4 * Cap - 1)}};
      end
      LOAD: if (ld_valid_o) cur_q.tri_idx <= ref_tri_idx_i;
      SORT: begin
        cur_q.in_b   <= sort_side_i;
        cur_q.events <= sort_side_i ? {3{ptr_t'(4 * Cap - 1)}} : '0;
        for (int a = 0; a < 3; a++) cur_q.num_events[a] <= num_events_i[a][0];
      end
      PICK: {found_q, plane_q} <= {found_i, plane_i};
      ROOT: begin
        cur_q  <= child[0];
        root_q <= 1'b0;
      end
      SPLIT: begin
        if (!refs_fit) cur_q.split <= 1'b0;
        donate_q <= divide && donate;
        entry_q  <= ent_idx_i;
      end
      KEEP: keep_q <= keep;
      PUSH: begin
        cur_q       <= child[first];
        donate_q    <= 1'b0;
        refs_free_q <= refs_free;
        free_q      <= free;
      end
      TOP: if (!top_late) cur_q <= waiting;
      default: ;
    endcase
    if (node_valid_o && node_ready_i) back_q <= node_idx_i;
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (start_o) JobFits_M: assume (32'(job_i.count) <= Cap);
      if (state_q == KEEP) CountsRight_A: assert (walk_num_i == num_refs_o);
      if (state_q == PUSH) NotEmpty_A: assert (num_refs_o != '0);
      if (state_q == SPLIT) Deeper_A: assert (cur_q.level < level_t'(MAX_DEPTH));
    end
  end
`endif
endmodule
