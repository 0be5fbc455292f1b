// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Gives the lists of leaves of a sorting pipeline their places, rising, and makes rows of 32 bytes of them. An entry a
// cycle. A list lies in one piece: where what is left of an extent is too little, extents in one piece are asked for; if
// they do not follow on what is left, that stays unused.
module rc_tbp_sort_leafs import rc_pkg::*, rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  logic        clk_i,
  input  logic        rst_ni,
  input  logic        list_valid_i,        // a leaf begins; held until list_ready_o
  output logic        list_ready_o,
  input  num_t        list_num_i,          // entries
  output idx_t        list_idx_o,          // first entry
  input  logic        in_valid_i,          // then so many entries
  output logic        in_ready_o,
  input  list_entry_t in_entry_i,
  input  logic        flush_i,             // write what there is; until idle_o
  output logic        idle_o,
  output logic        ext_req_o,           // held until ext_gnt_i
  output logic [3:0]  ext_num_o,           // extents in one piece
  input  logic        ext_gnt_i,
  input  idx_t        ext_idx_i,           // first entry
  output logic        row_valid_o,
  input  logic        row_ready_i,
  output tbu_wr_t     row_o
);
  localparam int unsigned EXT_W = $clog2(LIST_EXTENT);
  idx_t next_q;                            // next place
  idx_t left_q;                            // places from there on
  logic fits;
  assign fits         = left_q >= idx_t'(list_num_i);
  assign list_ready_o = list_valid_i && fits;
  assign list_idx_o   = next_q;
  assign ext_req_o    = list_valid_i && !fits;
  assign ext_num_o    = list_num_i[11:EXT_W] + 4'(list_num_i[EXT_W-1:0] != '0);

  logic follows, put, same_row;
  assign follows = next_q + left_q == ext_idx_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      left_q <= '0;
    end else if (ext_gnt_i) begin
      left_q <= idx_t'({ext_num_o, EXT_W'(0)}) + (follows ? left_q : '0);
    end else if (put) begin
      left_q <= left_q - idx_t'(1);
    end
    if (ext_gnt_i && !follows) next_q <= ext_idx_i;
    else if (put) next_q <= next_q + idx_t'(1);
  end

  logic [7:0]       used_q;                // entries of the row
  logic [7:0][31:0] data_q;
  logic [20:0]      row_q;
  assign same_row    = row_q == next_q[23:3];
  assign in_ready_o  = same_row || used_q == '0 || row_ready_i;
  assign put         = in_valid_i && in_ready_o;
  assign row_valid_o = used_q != '0 && (flush_i || (in_valid_i && !same_row));
  assign idle_o      = used_q == '0;
  assign row_o.kind  = WR_LIST;
  assign row_o.row   = {3'b000, row_q};
  assign row_o.strb  = used_q;
  assign row_o.data  = data_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      used_q <= '0;
    end else begin
      if (row_valid_o && row_ready_i) used_q <= '0;
      if (put) used_q <= (same_row ? used_q : 8'd0) | 8'd1 << next_q[2:0];
    end
    if (put) begin
      row_q <= next_q[23:3];
      data_q[next_q[2:0]] <= {6'd0, in_entry_i};
    end
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (list_valid_i) ListNum_M: assume (list_num_i != '0);
      if (ext_gnt_i) GrantAsked_M: assume (ext_req_o && ext_idx_i[EXT_W-1:0] == '0);
      if (put) InExtent_A: assert (left_q != '0);
      if (flush_i || list_valid_i) Alone_M: assume (!in_valid_i);
    end
  end
`endif
endmodule
