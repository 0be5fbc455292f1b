// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Sorting pipeline of the tree-building unit (paper Sec. 3.7): takes a subtree whose references fit its memory, sorts
// their bounds, and makes all of its nodes by the exact surface-area heuristic, one event a cycle an axis. docs/tbu.md
//   load   2 cycles a reference, with runs of 16 events sorted on the way; then 4-way merge passes, all axes at once
//   node   n + 6 cycles: class of its references, and the children's lists of them. Then its longest list of events + 14
//          cycles: the children's lists of events are made, and swept for their best planes at once; not if both are
//          leaves. 6 cycles more for the stack
//   leaf   3 cycles, more if the leaf before had a long list, which goes out meanwhile
// Memory, bits: spans 3 x Cap x 36, triangles Cap x 20, lists of events 3 x 4 Cap x 12, of references 2 Cap x 11, classes
// 3 x Cap x 2, stack 32 x 362: 300 Cap + 11.6 K; for Cap = 1280 49.4 KB of the paper's 51.3.
// 21 multipliers, as in Table I: 6 evaluators of 3, and 3 for the areas of the children (rc_tbp_area).
// Of 18 to 55 bits: 60 adders; 106 comparators by size, 48 of them in the run sorters and 9 in the merges.
module rc_tbp_sort import rc_pkg::*, rc_tbu_pkg::*, rc_tbp_sort_pkg::*; #(
  parameter int unsigned Cap = 1280        // references, at most 2047
) (
  input  logic       clk_i,
  input  logic       rst_ni,               // also before each tree: it forgets the extents of the last one
  output logic       busy_o,               // a job is in work, or rows wait to be written
  input  logic       job_valid_i,
  output logic       job_ready_o,
  input  sort_job_t  job_i,
  input  logic       ref_valid_i,          // then job_i.count of these, ascending in triangle index
  output logic       ref_ready_o,
  input  tri_ref_t   ref_i,
  output logic [1:0] ext_req_o,            // [0] nodes, [1] list entries; held until ext_gnt_i
  output logic [3:0] ext_num_o,            // list extents in one piece, 1 to 8
  input  logic [1:0] ext_gnt_i,            // one at a time
  input  idx_t       ext_idx_i,            // first node or entry
  output logic       wr_valid_o,
  input  logic       wr_ready_i,
  output tbu_wr_t    wr_o,
  output logic       sub_valid_o,          // the job is done
  input  logic       sub_ready_i,
  output subtree_t   sub_o,
  input  logic       don_want_i,           // another pipeline is idle, and no job waits for it
  output logic       don_valid_o,          // a job for it
  input  logic       don_ready_i,
  output sort_job_t  don_job_o,
  output logic       don_ref_valid_o,      // then its references
  input  logic       don_ref_ready_i,
  output tri_ref_t   don_ref_o,
  input  logic       ent_valid_i,          // an entry of the upper-node table is free
  output logic       ent_ready_o,          // and is taken
  input  logic [6:0] ent_idx_i,
  output logic       upper_valid_o,        // a node that rc_tbu_upper writes
  input  logic       upper_ready_i,
  output donated_t   upper_o,
  output logic       ev_jump_o,            // a jump node was made
  output logic       ev_forced_o           // a leaf was made because a list would not fit
);
  if (Cap > MAX_CAP || Cap < 16 || Cap % 2 != 0) begin : gen_bad_cap
    $error("Cap must be even, 16 to 2047");
  end

  logic            start, ld_valid, ld_sort, sort_end, area_start, area_valid, pl, walk_start, dividing, walk_busy;
  logic            sweep_start, active, get_valid, class_valid, list_valid, list_ready, out_valid, out_ready, out_last;
  logic            out_donate, entry_ready, node_valid, node_ready, node_adj, node_skip, flush, nodes_idle, leafs_idle;
  ref_t            ld_idx, get_idx, class_idx;
  num_t            sort_max, list_num;
  box_t            node_box, get_box;
  box_t [1:0]      box;
  num_t [1:0]      num_refs, walk_num;
  walk_t           walk;
  num_t [2:0][1:0] num_events;
  sweep_t [2:0]    sweep;
  eval_cfg_t [1:0] cfg;
  logic [2:0]      sort_busy, sort_side, sweep_busy, cut;
  logic [2:0][1:0] side;
  logic [1:0]      side_cut, side_class, found;
  best_t [2:0][1:0] best;
  plane_t [1:0]    plane;
  tri_ref_t        out_ref;
  list_entry_t     entry;
  idx_t            list_idx, node_idx;
  node_t           node;
  logic [5:0]      node_gap;
  logic [1:0][TRI_W-1:0] last_tri_idx;

  rc_tbp_sort_ctrl #(.Cap(Cap)) u_ctrl (
    .clk_i, .rst_ni, .job_valid_i, .job_ready_o, .job_i, .ref_valid_i, .ref_ready_o, .ref_tri_idx_i(ref_i.tri_idx),
    .start_o(start), .ld_valid_o(ld_valid), .ld_sort_o(ld_sort), .ld_idx_o(ld_idx),
    .sort_end_o(sort_end), .sort_max_o(sort_max), .sort_busy_i(sort_busy != '0), .sort_side_i(sort_side == '1),
    .area_start_o(area_start), .box_o(box), .num_refs_o(num_refs), .node_box_o(node_box), .pl_o(pl),
    .walk_start_o(walk_start), .walk_o(walk), .dividing_i(dividing), .walk_busy_i(walk_busy), .walk_num_i(walk_num),
    .last_tri_idx_i(last_tri_idx), .num_events_i(num_events),
    .sweep_start_o(sweep_start), .sweep_o(sweep), .sweep_busy_i(sweep_busy != '0), .found_i(found), .plane_i(plane),
    .list_valid_o(list_valid), .list_num_o(list_num), .list_ready_i(list_ready), .list_idx_i(list_idx),
    .node_valid_o(node_valid), .node_ready_i(node_ready), .node_o(node), .node_adj_o(node_adj), .node_skip_o(node_skip),
    .node_gap_o(node_gap), .node_idx_i(node_idx), .flush_o(flush), .flushed_i(nodes_idle && leafs_idle),
    .sub_valid_o, .sub_ready_i, .sub_o, .don_want_i, .don_valid_o, .don_ready_i, .don_job_o,
    .ent_valid_i, .ent_ready_o, .ent_idx_i, .upper_valid_o, .upper_ready_i, .upper_o, .active_o(active), .ev_forced_o
  );
  rc_tbp_area u_area (
    .clk_i, .rst_ni, .start_i(area_start), .box_i(box), .num_i(num_refs), .valid_o(area_valid), .cfg_o(cfg)
  );

  // ---- references and axes -------------------------------------------------------------------------------------------
  rc_tbp_sort_refs #(.Cap(Cap)) u_refs (
    .clk_i, .rst_ni, .ld_valid_i(ld_valid), .ld_idx_i(ld_idx), .ld_tri_idx_i(ref_i.tri_idx), .ld_opaque_i(ref_i.opaque),
    .walk_start_i(walk_start), .walk_i(walk), .dividing_o(dividing), .busy_o(walk_busy), .num_o(walk_num),
    .last_tri_idx_o(last_tri_idx), .get_valid_o(get_valid), .get_idx_o(get_idx), .get_box_i(get_box),
    .class_i(side_cut), .class_valid_o(class_valid), .class_idx_o(class_idx), .class_o(side_class),
    .out_valid_o(out_valid), .out_ready_i(out_ready), .out_ref_o(out_ref), .out_last_o(out_last),
    .out_donate_o(out_donate)
  );
  assign side_cut = cut[0] ? side[0] : cut[1] ? side[1] : side[2];
  for (genvar a = 0; a < 3; a++) begin : gen_axis
    assign cut[a] = sweep[a].cut;
    rc_tbp_sort_axis #(.Cap(Cap)) u_axis (
      .clk_i, .rst_ni, .start_i(start), .ld_valid_i(ld_valid), .ld_sort_i(ld_sort), .ld_idx_i(ld_idx),
      .ld_span_i({ref_i.hi[a], ref_i.lo[a]}), .sort_end_i(sort_end), .sort_max_i(sort_max),
      .sort_busy_o(sort_busy[a]), .sort_side_o(sort_side[a]),
      .get_valid_i(get_valid), .get_idx_i(get_idx), .get_span_o({get_box.hi[a], get_box.lo[a]}),
      .span_i({node_box.hi[a], node_box.lo[a]}), .cut_i(cut[a]), .pos_i(sweep[a].pos), .pl_i(pl), .class_o(side[a]),
      .class_clear_i(walk_start && walk.divide), .class_valid_i(class_valid), .class_idx_i(class_idx),
      .class_i(side_class), .num_events_o(num_events[a]), .sweep_start_i(sweep_start), .sweep_i(sweep[a]), .cfg_i(cfg),
      .cfg_axis_i({cfg[1].axis[a], cfg[0].axis[a]}), .sweep_busy_o(sweep_busy[a]), .best_o(best[a])
    );
  end
  for (genvar c = 0; c < 2; c++) begin : gen_child
    rc_tbp_sort_pick u_pick (
      .clk_i, .best_i({best[2][c], best[1][c], best[0][c]}), .found_o(found[c]), .plane_o(plane[c])
    );
  end

  // ---- what goes out -------------------------------------------------------------------------------------------------
  logic    nodes_row, leafs_row, row_ready, leafs_turn, leafs_held_q;
  tbu_wr_t nodes_wr, leafs_wr;
  assign don_ref_valid_o = out_valid && out_donate;
  assign don_ref_o       = out_ref;
  assign out_ready       = out_donate ? don_ref_ready_i : entry_ready;
  assign entry           = '{opaque: out_ref.opaque, last: out_last, tri_idx: idx_t'(out_ref.tri_idx)};
  rc_tbp_sort_nodes u_nodes (
    .clk_i, .rst_ni, .active_i(active), .in_valid_i(node_valid), .in_ready_o(node_ready), .in_node_i(node),
    .in_adj_i(node_adj), .in_skip_i(node_skip), .in_gap_i(node_gap), .in_idx_o(node_idx),
    .flush_i(flush), .idle_o(nodes_idle), .ext_req_o(ext_req_o[0]), .ext_gnt_i(ext_gnt_i[0]), .ext_idx_i,
    .row_valid_o(nodes_row), .row_ready_i(row_ready && !leafs_turn), .row_o(nodes_wr), .ev_jump_o
  );
  rc_tbp_sort_leafs u_leafs (
    .clk_i, .rst_ni, .list_valid_i(list_valid), .list_ready_o(list_ready), .list_num_i(list_num),
    .list_idx_o(list_idx), .in_valid_i(out_valid && !out_donate), .in_ready_o(entry_ready), .in_entry_i(entry),
    .flush_i(flush), .idle_o(leafs_idle), .ext_req_o(ext_req_o[1]), .ext_num_o, .ext_gnt_i(ext_gnt_i[1]), .ext_idx_i,
    .row_valid_o(leafs_row), .row_ready_i(row_ready && leafs_turn), .row_o(leafs_wr)
  );
  // Rows of nodes go first, but a row of a list that waits already stays.
  assign leafs_turn = leafs_row && (leafs_held_q || !nodes_row);
  always_ff @(posedge clk_i) leafs_held_q <= rst_ni && leafs_turn && !row_ready;
  rc_skid #(.data_t(tbu_wr_t)) u_row (
    .clk_i, .rst_ni, .in_valid_i(nodes_row || leafs_row), .in_ready_o(row_ready),
    .in_data_i(leafs_turn ? leafs_wr : nodes_wr), .out_valid_o(wr_valid_o), .out_ready_i(wr_ready_i), .out_data_o(wr_o)
  );
  assign busy_o = active || wr_valid_o;

`ifndef SYNTHESIS
  logic [9:0] swept_q;                     // a sweep began so many cycles ago
  always_ff @(posedge clk_i) begin
    swept_q <= rst_ni ? {swept_q[8:0], sweep_start} : '0;
    if (rst_ni && swept_q[9]) AreaThere_A: assert (area_valid);   // before the first cost is compared
  end
`endif
endmodule
