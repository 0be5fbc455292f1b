// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// One pass over a list: read it, tell members of the family apart, write their lists, bin those that are to be divided,
// evaluate. All of it streams at one (reference, slot) pair a cycle; what is written is confirmed before done_o.
module rc_tbp_bin_pass import rc_pkg::*; import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       start_i,                        // for one cycle; pass_i and member_i constant until done_o
  input  pass_t      pass_i,
  input  binned_t [NUM_SLOTS-1:0] member_i,
  output logic       done_o,                         // for one cycle
  output logic       plane_valid_o,                  // for one cycle: what an evaluation found
  output slot_t      plane_slot_o,
  output plane_t     plane_o,
  output logic       bad_o,                          // for one cycle: a coordinate outside
  input  tri_first_t tri_first_i,                    // number of the first triangle, where vertices are read
  output logic       req_valid_o,
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,
  input  block64_t   rsp_block_i,
  output logic       wr_valid_o,
  input  logic       wr_ready_i,
  output tbu_wr_t    wr_o,
  input  logic       wr_confirmed_i                  // no row of references is on its way
);
  typedef enum logic [2:0] {IDLE, SETUP, START, FLOW, FLUSH, EVAL, CONFIRM} state_e;
  state_e state_q;
  slot_t  slot_q;
  count_t left_q;
  logic   ref_valid, ref_ready, pair_valid, pair_ready, cmd_ready, plane_ready, flushed, eval_done, ref_take;
  tri_ref_t in_ref, pair_ref;
  slot_t    pair_slot;
  slot_cfg_t [NUM_SLOTS-1:0] cfg_q;

  assign ref_take = ref_valid && ref_ready;
  assign done_o   = state_q == CONFIRM && (pass_i.out != OUT_REFS || (wr_confirmed_i && !wr_valid_o));
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      state_q <= IDLE;
      slot_q  <= '0;
    end else begin
      case (state_q)
        IDLE:  if (start_i) state_q <= SETUP;
        SETUP: begin
          slot_q <= slot_q + 1'b1;
          if (slot_q == '1) state_q <= START;
        end
        START: if (cmd_ready && plane_ready) state_q <= FLOW;
        FLOW:  if (left_q == '0 && !pair_valid) state_q <= FLUSH;
        FLUSH: if (flushed) state_q <= EVAL;
        EVAL:
          if (!pass_i.bin_en[slot_q] || eval_done) begin
            slot_q <= slot_q + 1'b1;
            if (slot_q == '1) state_q <= CONFIRM;
          end
        default: if (done_o) state_q <= IDLE;
      endcase
    end
    if (state_q == START) left_q <= pass_i.count;
    else if (ref_take) left_q <= left_q - 1'b1;
  end

  // ---- bins of a slot: 32 over the node, or 64 about the bound between two of those -------------------------------
  slot_cfg_t setup;
  for (genvar a = 0; a < 3; a++) begin : gen_setup
    coord_t lo, width;
    shift_t shift;
    assign lo    = member_i[slot_q].box.lo[a];
    assign width = member_i[slot_q].box.hi[a] - lo;
    always_comb begin
      shift = '0;                                    // least that covers the node
      for (int s = 0; s < int'(COORD_W - $clog2(BINS)); s++)
        if (width > coord_t'(BINS << s)) shift = shift_t'(s + 1);
    end
    always_comb begin
      setup.base[a]  = lo;
      setup.shift[a] = shift;
      if (pass_i.fine && width > coord_t'(1)) begin
        setup.base[a]  = lo + ((coord_t'(member_i[slot_q].bin[a]) - 1'b1) << shift);
        setup.shift[a] = (shift > shift_t'(FINE_SHIFT)) ? shift - shift_t'(FINE_SHIFT) : '0;
      end
    end
  end
  always_ff @(posedge clk_i) if (state_q == SETUP) cfg_q[slot_q] <= setup;

  // ---- the stream ------------------------------------------------------------------------------------------------
  rc_tbu_fetch u_fetch (
    .clk_i, .rst_ni,
    .cmd_valid_i(state_q == START && plane_ready), .cmd_ready_o(cmd_ready),
    .cmd_vertices_i(pass_i.vertices), .cmd_line_i(pass_i.line), .cmd_tri_i(tri_first_i),
    .cmd_count_i(pass_i.count),
    .req_valid_o, .req_ready_i, .req_addr_o, .rsp_valid_i, .rsp_block_i,
    .out_valid_o(ref_valid), .out_ready_i(ref_ready), .out_ref_o(in_ref), .bad_o
  );
  rc_tbp_bin_class u_class (
    .clk_i, .rst_ni, .classes_i(pass_i.classes),
    .in_valid_i(ref_valid), .in_ready_o(ref_ready), .in_ref_i(in_ref),
    .out_valid_o(pair_valid), .out_ready_i(pair_ready), .out_ref_o(pair_ref), .out_slot_o(pair_slot)
  );
  rc_tbp_bin_write u_write (
    .clk_i, .rst_ni,
    .start_i(state_q == START), .out_i(pass_i.out), .base_i(pass_i.base), .ids_i(pass_i.count),
    .in_valid_i(pair_valid), .in_ready_o(pair_ready), .in_ref_i(pair_ref), .in_slot_i(pair_slot),
    .flush_i(state_q == FLUSH), .flushed_o(flushed), .wr_valid_o, .wr_ready_i, .wr_o
  );
  rc_tbp_bin_plane u_plane (
    .clk_i, .rst_ni, .ready_o(plane_ready), .fine_i(pass_i.fine), .cfg_i(cfg_q),
    .in_valid_i(pair_valid && pair_ready && pass_i.bin_en[pair_slot]), .in_slot_i(pair_slot),
    .in_box_i('{hi: pair_ref.hi, lo: pair_ref.lo}),
    .eval_valid_i(state_q == EVAL && pass_i.bin_en[slot_q]), .eval_slot_i(slot_q),
    .eval_box_i(member_i[slot_q].box), .eval_count_i(member_i[slot_q].count),
    .done_o(eval_done), .plane_o
  );
  assign plane_valid_o = eval_done;
  assign plane_slot_o  = slot_q;
`ifndef SYNTHESIS
  count_t [NUM_SLOTS-1:0] seen_q;                    // references of each slot
  always_ff @(posedge clk_i) begin
    if (state_q == START) seen_q <= '0;
    else if (pair_valid && pair_ready) seen_q[pair_slot] <= seen_q[pair_slot] + 1'b1;
    if (rst_ni && state_q == EVAL)
      for (int s = 0; s < NUM_SLOTS; s++)
        if (pass_i.bin_en[s]) CountsAgree_A: assert (seen_q[s] == member_i[s].count);
    if (rst_ni && state_q == FLOW && left_q == '0) NoMore_A: assert (!ref_valid);
  end
`endif
endmodule
