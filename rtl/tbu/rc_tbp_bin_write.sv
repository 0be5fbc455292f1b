// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Rows of the lists that a pass writes: two references a row, four lists side by side; or eight list entries a row, one list.
// A pair a cycle while the row queue has room. flush_i, when the pass's last pair is through, writes what is left.
module rc_tbp_bin_write import rc_pkg::*; import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; (
  input  logic     clk_i,
  input  logic     rst_ni,
  input  logic     start_i,                          // a pass begins: out_i and base_i are valid
  input  out_e     out_i,
  input  idx_t [NUM_SLOTS-1:0] base_i,               // first reference, even; slot 0: first list entry, multiple of 8
  input  count_t   ids_i,                            // entries of the leaf
  input  logic     in_valid_i,
  output logic     in_ready_o,
  input  tri_ref_t in_ref_i,
  input  slot_t    in_slot_i,
  input  logic     flush_i,                          // held until flushed_o
  output logic     flushed_o,
  output logic     wr_valid_o,
  input  logic     wr_ready_i,
  output tbu_wr_t  wr_o
);
  out_e                 out_q;
  logic [NUM_SLOTS-1:0] half_valid_q;                // the first reference of a row waits
  tri_ref_t [NUM_SLOTS-1:0] half_q;
  logic [NUM_SLOTS-1:0][23:0] row_q;
  count_t               ids_left_q;
  logic [2:0]           id_q;                        // place in the row
  logic [7:0][31:0]     ids, ids_q;
  logic [7:0]           ids_strb, ids_strb_q;
  logic     take, push, push_ready, last_id, flush_ref;
  slot_t    flush_slot, slot;
  tbu_wr_t  push_row;

  assign in_ready_o = push_ready && !flush_i;
  assign take       = in_valid_i && in_ready_o;
  assign last_id    = ids_left_q == count_t'(1);
  always_comb begin
    ids      = ids_q;
    ids_strb = (id_q == '0) ? '0 : ids_strb_q;
    ids[id_q]      = 32'({in_ref_i.opaque, last_id, 24'(in_ref_i.tri_idx)});
    ids_strb[id_q] = 1'b1;
  end
  always_comb begin
    flush_slot = 2'd3;
    for (int s = 2; s >= 0; s--) if (half_valid_q[s]) flush_slot = slot_t'(s);
  end
  assign flush_ref = flush_i && half_valid_q != '0;
  assign flushed_o = flush_i && half_valid_q == '0;
  assign slot      = flush_i ? flush_slot : in_slot_i;
  always_comb begin
    push_row = '{kind: WR_REF, row: row_q[slot], strb: '1, data: {in_ref_i, half_q[slot]}};
    if (flush_i) push_row.strb = 8'h0f;
    if (out_q == OUT_IDS) push_row = '{kind: WR_LIST, row: row_q[0], strb: ids_strb, data: ids};
    case (out_q)
      OUT_REFS: push = flush_ref || (take && half_valid_q[slot]);
      OUT_IDS:  push = take && (last_id || id_q == 3'd7);
      default:  push = 1'b0;
    endcase
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      half_valid_q <= '0;
      out_q        <= OUT_NONE;
    end else if (start_i) begin
      half_valid_q <= '0;
      out_q        <= out_i;
    end else if (out_q == OUT_REFS) begin
      if (take) half_valid_q[slot] <= !half_valid_q[slot];
      if (flush_ref && push_ready) half_valid_q[slot] <= 1'b0;
    end
    if (start_i) begin
      for (int s = 0; s < NUM_SLOTS; s++) row_q[s] <= (out_i == OUT_IDS) ? 24'(base_i[s] >> 3) : 24'(base_i[s] >> 1);
      ids_left_q <= ids_i;
      id_q       <= '0;
    end else begin
      if (push && push_ready) row_q[(out_q == OUT_IDS) ? 2'd0 : slot] <= push_row.row + 1'b1;
      if (take) begin
        ids_left_q <= ids_left_q - 1'b1;
        id_q       <= id_q + 1'b1;
      end
    end
    if (take) begin
      half_q[slot] <= in_ref_i;
      {ids_q, ids_strb_q} <= {ids, ids_strb};
    end
  end
  logic [2:0] unused_count;
  rc_fifo #(.data_t(tbu_wr_t), .Depth(4)) u_rows (
    .clk_i, .rst_ni,
    .in_valid_i(push), .in_ready_o(push_ready), .in_data_i(push_row),
    .out_valid_o(wr_valid_o), .out_ready_i(wr_ready_i), .out_data_o(wr_o), .count_o(unused_count)
  );
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && take && out_q == OUT_IDS) OneList_A: assert (in_slot_i == '0 && ids_left_q != '0);
  end
`endif
endmodule
