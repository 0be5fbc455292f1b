// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Gives nodes of a sorting pipeline their places and makes rows of 32 bytes of them. Nodes come in post-order and get
// falling places: the adjacent child of a node is just above it, and the result is the depth-first layout (paper
// Sec. 3.7). A node a cycle. An extent is asked for ahead, when the one in use is nearly full; where it does not lie just
// below, a jump node at its top leads back to the node that came last.
module rc_tbp_sort_nodes import rc_pkg::*, rc_tbu_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       active_i,             // a job is in work: ask for extents
  input  logic       in_valid_i,
  output logic       in_ready_o,           // may depend on in_valid_i
  input  node_t      in_node_i,
  input  logic       in_adj_i,             // its adjacent child is the node that came last
  input  logic       in_skip_i,            // only keep its place free
  input  logic [5:0] in_gap_i,             // so many places below it stay free too
  output idx_t       in_idx_o,             // its place
  input  logic       flush_i,              // write what there is; until idle_o
  output logic       idle_o,
  output logic       ext_req_o,            // held until ext_gnt_i
  input  logic       ext_gnt_i,
  input  idx_t       ext_idx_i,            // first node of the extent
  output logic       row_valid_o,
  input  logic       row_ready_i,
  output tbu_wr_t    row_o,
  output logic       ev_jump_o             // a jump node was made
);
  localparam int unsigned AHEAD = 16;      // places left when an extent is asked for
  typedef logic [8:0] left_t;              // up to two extents
  idx_t  next_q, next_base_q, last_q;      // next place; extent in reserve; the node that came last
  left_t left_q;                           // places from next_q down
  logic  next_valid_q, room, below, jump, put, put_jump, same_row, row_free;
  idx_t  top, place;
  node_t node;

  assign room      = left_q > left_t'(in_gap_i);
  // The extent in reserve continues the one in use.
  assign below     = next_base_q + idx_t'(NODE_EXTENT) + idx_t'(left_q) == next_q + idx_t'(1);
  assign top       = next_base_q + idx_t'(NODE_EXTENT - 1);
  assign jump      = in_valid_i && !room && next_valid_q && !below && in_adj_i;
  assign put_jump  = jump && row_free;
  assign in_ready_o = in_valid_i && room && row_free;
  assign in_idx_o  = next_q;
  assign put       = in_ready_o || put_jump;
  assign place     = jump ? top : next_q;
  always_comb begin
    node = in_node_i;
    if (jump) begin
      node             = '0;
      node.split       = JUMP_SPLIT;
      node.lower_empty = 1'b1;
      node.other       = last_q;
    end
  end
  assign ev_jump_o = put_jump;
  assign ext_req_o = active_i && !next_valid_q && (left_q <= left_t'(AHEAD) || (in_valid_i && !room));

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      left_q       <= '0;
      next_valid_q <= 1'b0;
    end else begin
      if (ext_req_o && ext_gnt_i) next_valid_q <= 1'b1;
      if (in_ready_o) begin
        left_q <= left_q - left_t'(in_gap_i) - left_t'(1);
      end else if (in_valid_i && !room && next_valid_q && (below || !in_adj_i || put_jump)) begin
        left_q       <= below ? left_q + left_t'(NODE_EXTENT) : left_t'(NODE_EXTENT) - left_t'(put_jump);
        next_valid_q <= 1'b0;
      end
    end
    if (ext_req_o && ext_gnt_i) next_base_q <= ext_idx_i;
    if (in_ready_o) next_q <= next_q - idx_t'(in_gap_i) - idx_t'(1);
    else if (in_valid_i && !room && next_valid_q && !below && (!in_adj_i || put_jump))
      next_q <= put_jump ? top - idx_t'(1) : top;
    if (put) last_q <= place;
  end

  // ---- the row in work goes out when a node of another row comes ---------------------------------------------------
  logic [3:0]       used_q;                // nodes of the row
  logic [3:0][63:0] data_q;
  logic [21:0]      row_q;
  assign same_row    = row_q == place[23:2];
  assign row_free    = same_row || used_q == '0 || row_ready_i;
  assign row_valid_o = used_q != '0 && (flush_i || ((jump || (in_valid_i && room)) && !same_row));
  assign idle_o      = used_q == '0;
  assign row_o.kind  = WR_NODE;
  assign row_o.row   = {2'b00, row_q};
  assign row_o.data  = data_q;
  for (genvar i = 0; i < 4; i++) begin : gen_strb
    assign row_o.strb[2*i+:2] = {2{used_q[i]}};
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      used_q <= '0;
    end else begin
      if (row_valid_o && row_ready_i) used_q <= '0;
      if (put && (!in_skip_i || put_jump)) used_q <= (same_row ? used_q : 4'd0) | 4'd1 << place[1:0];
    end
    if (put) begin
      row_q <= place[23:2];
      data_q[place[1:0]] <= {4'b0000, node};
    end
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (flush_i) FlushAlone_M: assume (!in_valid_i);
      if (ext_gnt_i) GrantAsked_M: assume (ext_req_o && ext_idx_i[6:0] == '0);
      if (in_ready_o && in_adj_i) Adjacent_A: assert (in_idx_o + idx_t'(1) == last_q);
      if (in_ready_o) InExtent_A: assert (left_q != '0);
    end
  end
`endif
endmodule
