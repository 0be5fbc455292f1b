// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// What a sorting pipeline does next: depth first, the child that is not adjacent first, so that nodes come in post-order.
//   job    load, sort, sweep: the root's best plane
//   node   no plane that pays: leaf. Else: class of its references and their lists; then the children's lists of events and
//          best planes in one sweep, if one of them has more references than a leaf
//   stack  a frame for each node whose children are being made; with it the adjacent child, while the other one is made
// Where a list of references or events would not fit its memory a leaf is made, and counted (ev_forced_o).
module rc_tbp_sort_ctrl import rc_pkg::*, rc_tbu_pkg::*, rc_tbp_sort_pkg::*; #(
  parameter int unsigned Cap     = 1280,   // references
  parameter int unsigned DonMin  = 64      // references of a child that is worth donating
) (
  input  logic            clk_i,
  input  logic            rst_ni,
  input  logic            job_valid_i,
  output logic            job_ready_o,
  input  sort_job_t       job_i,
  input  logic            ref_valid_i,
  output logic            ref_ready_o,
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
  input  logic            area_valid_i,
  output box_t            node_box_o,
  output logic            pl_o,
  output logic            walk_start_o,
  output walk_t           walk_o,
  input  logic            walk_busy_i,
  input  num_t [1:0]      walk_num_i,
  input  num_t [2:0][1:0] num_events_i,
  output logic            sweep_start_o,
  output sweep_t [2:0]    sweep_o,
  input  logic            sweep_busy_i,
  input  logic  [1:0]     found_i,         // of child 0 and 1
  input  plane_t [1:0]    plane_i,
  output logic            list_valid_o,    // lists of leaves
  input  logic            list_ready_i,
  input  idx_t            list_idx_i,
  output logic            entry_en_o,      // what a walk gives out goes to the list of a leaf
  output logic            single_o,        // or is the only one of a leaf: read_valid_i takes it
  input  logic            entry_valid_i,   // one goes
  input  logic            entry_last_i,
  input  logic [TRI_W-1:0] entry_tri_i,
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
  localparam ptr_t EVENT_TOP = ptr_t'(4 * Cap - 1);
  localparam ptr_t REF_TOP   = ptr_t'(2 * Cap - 1);
  typedef enum logic [4:0] {
    IDLE, LOAD, DRAIN, SORT, SWEEP_START, SWEEP, PICK, PUSH, NODE, SPLIT, DONATE, CLASS, KEEP,
    LEAF, ENTRIES, LEAF_NODE, BACK, TOP, INNER, UPPER, FLUSH, REPORT
  } state_e;
  state_e     state_q, state_d;
  tnode_t     cur_q;                       // the node in work
  dest_t      dest_q;
  logic [5:0] gap_q;
  logic       root_q, odd_q, small_job;
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

  // ---- children of the node: SPLIT on ----------------------------------------------------------------------------------
  plane_t     cut;
  logic       swap_q, b_upper_q, both, refs_fit, donate_q, donating;
  logic [1:0] keep_d, keep_q;
  logic [6:0] entry_q;
  span_t      cut_span;
  ptr_t       refs_b;
  ptr_t [2:0] first_b;
  num_t [1:0] num;                         // references of child 0, 1
  logic [2:0] events_fit;
  logic       leaves;                      // both children are
  logic       moved_refs, moved;           // the child whose list changes ends: 1 the upper one
  assign cut        = cur_q.plane;
  assign num        = {cut.nr, cut.nl};
  assign leaves     = num[0] <= num_t'(MAX_LEAF) && num[1] <= num_t'(MAX_LEAF);
  assign both       = cut.nl != '0 && cut.nr != '0;
  assign cut_span   = {cur_q.box.hi[cut.axis], cur_q.box.lo[cut.axis]};
  assign refs_b     = cur_q.refs_in_b ? cur_q.refs : refs_free_q;
  assign moved_refs = cur_q.refs_in_b ? !b_upper_q : b_upper_q;
  assign moved      = cur_q.in_b ? !b_upper_q : b_upper_q;
  assign refs_fit   = ptr_t'(cur_q.count) + ptr_t'(num[moved_refs]) <= refs_b + ptr_t'(1);
  for (genvar a = 0; a < 3; a++) begin : gen_axis
    assign first_b[a]    = cur_q.in_b ? cur_q.events[a] : free_q[a];
    assign events_fit[a] = ptr_t'(cur_q.num_events[a]) + ptr_t'(num_events_i[a][moved]) <= first_b[a] + ptr_t'(1);
    always_comb begin
      sweep_o[a] = '{root: root_q, in_b: cur_q.in_b, first: cur_q.events[a], num: cur_q.num_events[a],
                     cut: !root_q && cut.axis == 2'(a), pos: cut.pos, b_upper: b_upper_q, first_b: first_b[a],
                     keep: root_q ? 2'b01 : keep_q, num_refs: num_refs_o,
                     span: {box_o[1].hi[a], box_o[1].lo[a], box_o[0].hi[a], box_o[0].lo[a]}};
    end
  end
  for (genvar c = 0; c < 2; c++) begin : gen_keep
    assign keep_d[c] = num[c] > num_t'(MAX_LEAF) && cur_q.level + level_t'(1) < level_t'(MAX_DEPTH)
                       && !(moved == 1'(c) && events_fit != '1) && !(donate_q && b_upper_q != 1'(c));
  end
  assign num_refs_o = root_q ? {num_t'(0), cur_q.count} : num;
  assign node_box_o = cur_q.box;
  assign pl_o       = cut.pl;
  always_comb begin
    box_o = {2{cur_q.box}};
    if (!root_q) begin
      box_o[0].hi[cut.axis] = cut.pos;
      box_o[1].lo[cut.axis] = cut.pos;
    end
  end
  assign donating      = don_want_i && ent_valid_i && both && num[!b_upper_q] >= num_t'(DonMin);
  assign ev_forced_o   = (state_q == SPLIT && !refs_fit) || (state_q == KEEP && num[moved] > num_t'(MAX_LEAF) && events_fit != '1);
  assign ent_ready_o   = state_q == SPLIT && refs_fit && donating;
  assign don_valid_o   = state_q == DONATE;
  assign don_job_o     = '{dest: '{root: 1'b0, upper: !b_upper_q, entry: entry_q}, gap: '0, level: cur_q.level + level_t'(1),
                           count: count_t'(num[!b_upper_q]), box: box_o[!b_upper_q]};
  assign area_start_o  = (state_q == SPLIT && refs_fit) || (state_q == DRAIN && drain_q == '0);
  assign walk_start_o  = (state_q == SPLIT && refs_fit && !donating) || (state_q == DONATE && don_ready_i)
                         || (state_q == LEAF && (cur_q.count == num_t'(1) || list_ready_i));
  assign walk_o        = '{divide: cur_q.split, donate: donate_q, in_b: cur_q.refs_in_b, first: cur_q.refs, num: cur_q.count,
                           b_upper: b_upper_q, first_b: refs_b};
  assign sweep_start_o = state_q == SWEEP_START;

  // ---- the children as nodes -------------------------------------------------------------------------------------------
  tnode_t [1:0] child;
  logic         swap;                      // the adjacent child is the upper one
  logic         first;                     // child that is made first
  for (genvar c = 0; c < 2; c++) begin : gen_child
    logic c_in_b;
    assign c_in_b = b_upper_q == 1'(c);
    always_comb begin
      child[c] = '{box: box_o[c], level: cur_q.level + level_t'(1), count: num[c], split: keep_q[c] && found_i[c],
                   plane: plane_i[c], refs_in_b: c_in_b, in_b: c_in_b,
                   refs: c_in_b ? refs_b : '0, events: '0, num_events: '0};
      for (int a = 0; a < 3; a++) begin
        if (c_in_b) child[c].events[a] = first_b[a];
        if (keep_q[c]) child[c].num_events[a] = num_events_i[a][c];
      end
    end
  end
  assign swap  = cut.nl == '0 || (cut.nr != '0 && {1'b0, cut_span.lo} + {1'b0, cut_span.hi} > {cut.pos, 1'b0});
  assign first = both ? donate_q == b_upper_q : cut.nl == '0;

  // ---- stack and nodes -----------------------------------------------------------------------------------------------------
  logic   top_donated, top_late;           // the frame on top waits for its adjacent, or only, child
  tnode_t waiting;
  frame_t frame_in;
  idx_t   back_q, list_q;                  // root of the subtree that was made last; the leaf's list, or its triangle
  logic [5:0] depth;                       // frames
  assign frame_in = '{axis: cut.axis, pos: cut.pos, swap: swap_q, lower_empty: cut.nl == '0,
                      upper_empty: cut.nr == '0, donated: donate_q, entry: entry_q};
  rc_tbp_sort_stack u_stack (
    .clk_i, .rst_ni, .clear_i(start_o),
    .push_i(state_q == PUSH), .frame_i(frame_in), .late_i(!both || donate_q), .waiting_i(child[b_upper_q]),
    .read_i(state_q == BACK), .turn_i(state_q == TOP && !top_late), .back_i(back_q), .pop_i(state_q == INNER && node_ready_i),
    .depth_o(depth), .late_o(top_late), .donated_o(top_donated), .upper_o, .waiting_o(waiting),
    .leaf_i(state_q == LEAF_NODE), .leaf_count_i(cur_q.count), .leaf_first_i(list_q), .node_o
  );
  assign list_valid_o = state_q == LEAF && cur_q.count > num_t'(1);
  assign single_o     = state_q == ENTRIES && cur_q.count == num_t'(1);
  assign entry_en_o   = state_q == ENTRIES && cur_q.count != num_t'(1);
  assign node_valid_o = state_q == LEAF_NODE || state_q == INNER;
  assign node_adj_o   = state_q == INNER;
  assign node_skip_o  = state_q == INNER && top_donated;
  assign node_gap_o   = (depth == 6'(state_q == INNER)) ? gap_q : '0;
  assign flush_o      = state_q == FLUSH;
  assign sub_valid_o  = state_q == REPORT;
  assign sub_o        = '{dest: dest_q, idx: back_q};
  assign upper_valid_o = state_q == UPPER;

  // ---- sequence ------------------------------------------------------------------------------------------------------------
  always_comb begin
    state_d = state_q;
    unique case (state_q)
      IDLE:        if (job_valid_i) state_d = LOAD;
      LOAD:        if (loaded_q == cur_q.count) state_d = DRAIN;
      DRAIN:       if (drain_q == '0) state_d = small_job ? NODE : SORT;
      SORT:        if (!sort_busy_i && area_valid_i) state_d = SWEEP_START;
      SWEEP_START: state_d = SWEEP;
      SWEEP:       if (!sweep_busy_i) state_d = PICK;
      PICK:        state_d = root_q ? NODE : PUSH;
      PUSH:        state_d = NODE;
      NODE:        state_d = cur_q.split ? SPLIT : LEAF;
      SPLIT:       state_d = !refs_fit ? NODE : donating ? DONATE : CLASS;
      DONATE:      if (don_ready_i) state_d = CLASS;
      CLASS:       if (!walk_busy_i && (area_valid_i || leaves)) state_d = KEEP;
      KEEP:        state_d = (keep_d == '0) ? PUSH : SWEEP_START;
      LEAF:        if (cur_q.count == '0 || walk_start_o) state_d = (cur_q.count == '0) ? LEAF_NODE : ENTRIES;
      ENTRIES:     if (entry_valid_i && entry_last_i) state_d = LEAF_NODE;
      LEAF_NODE:   if (node_ready_i) state_d = BACK;
      BACK:        state_d = (depth == '0) ? FLUSH : TOP;
      TOP:         state_d = top_late ? INNER : NODE;
      INNER:       if (node_ready_i) state_d = top_donated ? UPPER : BACK;
      UPPER:       if (upper_ready_i) state_d = BACK;
      FLUSH:       if (flushed_i) state_d = REPORT;
      REPORT:      if (sub_ready_i) state_d = IDLE;
      default:     state_d = IDLE;
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
        loaded_q    <= '0;
        root_q      <= 1'b1;
        refs_free_q <= REF_TOP;
        free_q      <= {3{EVENT_TOP}};
      end
      DRAIN: if (small_job) root_q <= 1'b0;
      SORT: begin
        cur_q.in_b   <= sort_side_i;
        cur_q.events <= sort_side_i ? {3{EVENT_TOP}} : '0;
        for (int a = 0; a < 3; a++) cur_q.num_events[a] <= num_events_i[a][0];
      end
      PICK: if (root_q) begin
        {cur_q.split, cur_q.plane} <= {found_i[0], plane_i[0]};
        root_q <= 1'b0;
      end
      NODE: begin
        swap_q    <= swap;
        b_upper_q <= both ? swap : cur_q.in_b ? cut.nl == '0 : cut.nr == '0;
        donate_q  <= 1'b0;
      end
      SPLIT: begin
        if (!refs_fit) cur_q.split <= 1'b0;
        donate_q <= refs_fit && donating;
        entry_q  <= ent_idx_i;
      end
      KEEP: keep_q <= keep_d;
      PUSH: begin
        cur_q       <= child[first];
        refs_free_q <= refs_b - ptr_t'(num[b_upper_q]);
        for (int a = 0; a < 3; a++) free_q[a] <= first_b[a] - ptr_t'(child[b_upper_q].num_events[a]);
      end
      LEAF: list_q <= list_idx_i;
      ENTRIES: if (single_o) list_q <= idx_t'(entry_tri_i);
      TOP: if (!top_late) cur_q <= waiting;
      default: ;
    endcase
    if (node_valid_o && node_ready_i) back_q <= node_idx_i;
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (start_o) JobFits_M: assume (32'(job_i.count) <= Cap);
      if (state_q == KEEP) CountsRight_A: assert (walk_num_i == num);
      if (state_q == PUSH) NotBoth_A: assert (num[0] != '0 || num[1] != '0);
      if (state_q == SPLIT) Deeper_A: assert (cur_q.level < level_t'(MAX_DEPTH));
    end
  end
`endif
endmodule
