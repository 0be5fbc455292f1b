// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Bins of four slots on three axes at once, and the best plane of a slot from them: a pair a cycle while binning, then 32 or
// 64 cycles and about 14 more a slot. Evaluation clears the bins that it reads; after reset all are cleared (128 cycles).
// Multipliers: 9. SRAM: 6 counters x 128 x 20 bits = 15,360 bits.
module rc_tbp_bin_plane import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; (
  input  logic      clk_i,
  input  logic      rst_ni,
  output logic      ready_o,                         // cleared, and no triangle on its way
  input  logic      fine_i,
  input  slot_cfg_t [NUM_SLOTS-1:0] cfg_i,           // constant from the first pair to the last evaluation
  input  logic      in_valid_i,
  input  slot_t     in_slot_i,
  input  box_t      in_box_i,
  input  logic      eval_valid_i,                    // held until done_o, with what follows
  input  slot_t     eval_slot_i,
  input  box_t      eval_box_i,
  input  count_t    eval_count_i,
  output logic      done_o,                          // for one cycle, with plane_o
  output plane_t    plane_o
);
  typedef enum logic [2:0] {CLEAR, IDLE, OPERANDS, SWEEP, DRAIN, PICK, DONE} state_e;
  state_e state_q;
  logic [$clog2(NUM_SLOTS*BINS)-1:0] count_q;        // bins: of all slots when clearing
  logic   start, sweep, swept_q, last_bin;
  bin_t   swept_bin_q;
  slot_t  sweep_slot;
  bin_t   sweep_bin;
  logic [2:0] axis_busy, eval_busy, has;
  assign start      = state_q == IDLE && eval_valid_i && axis_busy == '0;
  assign sweep      = state_q == CLEAR || state_q == SWEEP;
  assign sweep_slot = (state_q == CLEAR) ? count_q[6:5] : eval_slot_i;
  assign sweep_bin  = (state_q == CLEAR) ? bin_t'(count_q[4:0]) : count_q[5:0];
  assign last_bin   = count_q == ((state_q == CLEAR) ? '1 : fine_i ? 7'(2 * BINS - 1) : 7'(BINS - 1));
  assign ready_o    = state_q == IDLE && axis_busy == '0;
  assign done_o     = state_q == DONE;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      state_q <= CLEAR;
      {count_q, swept_q} <= '0;
    end else begin
      swept_q <= state_q == SWEEP;
      if (sweep) count_q <= last_bin ? '0 : count_q + 1'b1;
      case (state_q)
        CLEAR:    if (last_bin) state_q <= IDLE;
        IDLE:     if (start) state_q <= OPERANDS;
        OPERANDS: state_q <= SWEEP;
        SWEEP:    if (last_bin) state_q <= DRAIN;
        DRAIN:    if (!swept_q && eval_busy == '0) state_q <= PICK;
        PICK:     state_q <= DONE;
        default:  state_q <= IDLE;
      endcase
    end
    swept_bin_q <= sweep_bin;
  end

  cost_t  [2:0] cost, leaf_cost;
  bin_t   [2:0] bin;
  coord_t [2:0] pos;
  count_t [2:0] n_lower, n_upper;
  point_t       extent;
  for (genvar a = 0; a < 3; a++) begin : gen_axis
    localparam int unsigned A1 = (a + 1) % 3;
    localparam int unsigned A2 = (a + 2) % 3;
    count_t enter, leave;
    assign extent[a] = eval_box_i.hi[a] - eval_box_i.lo[a];
    rc_tbp_bin_axis u_bins (
      .clk_i, .rst_ni, .fine_i(fine_i && state_q != CLEAR),
      .in_valid_i, .in_slot_i, .in_base_i(cfg_i[in_slot_i].base[a]), .in_shift_i(cfg_i[in_slot_i].shift[a]),
      .in_lo_i(in_box_i.lo[a]), .in_hi_i(in_box_i.hi[a]), .busy_o(axis_busy[a]),
      .sweep_i(sweep), .sweep_slot_i(sweep_slot), .sweep_bin_i(sweep_bin), .enter_o(enter), .leave_o(leave)
    );
    rc_tbp_bin_eval u_eval (
      .clk_i, .rst_ni, .start_i(start), .count_i(eval_count_i),
      .e1_i(extent[A1]), .e2_i(extent[A2]), .width_i(extent[a]), .lo_i(eval_box_i.lo[a]),
      .base_i(cfg_i[eval_slot_i].base[a]), .shift_i(cfg_i[eval_slot_i].shift[a]), .limit_i(eval_box_i.hi[a]),
      .bin_valid_i(swept_q), .bin_i(swept_bin_q), .enter_i(enter), .leave_i(leave), .busy_o(eval_busy[a]),
      .has_o(has[a]), .cost_o(cost[a]), .bin_o(bin[a]), .pos_o(pos[a]),
      .n_lower_o(n_lower[a]), .n_upper_o(n_upper[a]), .leaf_cost_o(leaf_cost[a])
    );
  end

  // ---- best axis, the first one if equal ---------------------------------------------------------------------
  logic [1:0] best;
  always_comb begin
    best = 2'd0;
    if (has[1] && (!has[0] || cost[1] < cost[0])) best = 2'd1;
    if (has[2] && (!has[best] || cost[2] < cost[best])) best = 2'd2;
  end
  always_ff @(posedge clk_i) begin
    if (state_q == PICK) begin
      plane_o <= '{pays: has[best] && cost[best] < leaf_cost[0], axis: best, pos: pos[best],
                   n_lower: n_lower[best], n_upper: n_upper[best], bin: bin};
    end
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && in_valid_i) Ready_M: assume (state_q == IDLE && !eval_valid_i);
    if (rst_ni && state_q == PICK) OneLeaf_A: assert (leaf_cost[0] == leaf_cost[1] && leaf_cost[0] == leaf_cost[2]);
    if (rst_ni && state_q == PICK)
      for (int a = 0; a < 3; a++)
        if (has[a]) NobodyLost_A: assert (n_lower[a] + n_upper[a] >= eval_count_i);
  end
`else
  logic unused_leaf;
  assign unused_leaf = ^{leaf_cost[1], leaf_cost[2]};
`endif
endmodule
