// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Extents for those who write a tree: NODE_EXTENT nodes each from the top of the node region downwards, so that subtrees
// written at falling addresses go on from one extent to the next; list entries upwards, several extents in one piece.
// Each client is granted in turn, in the cycle it asks if nobody else does. An extent that does not fit is never granted:
// *_full_o says so. Nothing outside a region can be written by those who write only what they were granted.
module rc_tbu_alloc import rc_pkg::*; import rc_tbu_pkg::*; #(
  parameter  int unsigned NumClients = 5,
  localparam int unsigned NumW       = COUNT_W - $clog2(LIST_EXTENT) + 1
) (
  input  logic                  clk_i,
  input  logic                  rst_ni,              // all is free
  input  idx_t                  node_first_i,        // the regions: first and behind the last, whole extents
  input  idx_t                  node_count_i,
  input  idx_t                  list_first_i,
  input  idx_t                  list_count_i,
  input  logic [NumClients-1:0] node_req_i,
  output logic [NumClients-1:0] node_gnt_o,
  output idx_t                  node_idx_o,          // lowest node of the extent
  input  logic [NumClients-1:0] list_req_i,
  input  logic [NumClients-1:0][NumW-1:0] list_num_i,   // extents
  output logic [NumClients-1:0] list_gnt_o,
  output idx_t                  list_idx_o,
  output logic                  node_full_o,
  output logic                  list_full_o
);
  localparam int unsigned ClientW = (NumClients > 1) ? $clog2(NumClients) : 1;
  localparam int unsigned NodeW = $clog2(NODE_EXTENT);
  localparam int unsigned ListW = $clog2(LIST_EXTENT);

  // ---- nodes: extents left are those below the next one ----------------------------------------------
  logic [IDX_W-1:NodeW] node_used_q, node_total, node_next;
  logic [NumClients-1:0] node_first;
  logic [ClientW-1:0]    unused_node_client;
  logic node_fits;
  assign node_total = node_count_i[IDX_W-1:NodeW] - node_first_i[IDX_W-1:NodeW];
  assign node_fits  = node_used_q < node_total;
  assign node_next  = node_count_i[IDX_W-1:NodeW] - node_used_q - 1'b1;
  assign node_idx_o = {node_next, {NodeW{1'b0}}};
  rc_rr_arb #(.NumReq(NumClients)) u_node (
    .clk_i, .rst_ni, .req_i(node_req_i), .ready_i(node_fits), .gnt_o(node_first), .idx_o(unused_node_client)
  );
  assign node_gnt_o  = node_fits ? node_first : '0;
  assign node_full_o = node_req_i != '0 && !node_fits;

  // ---- lists -------------------------------------------------------------------------------------------
  logic [IDX_W-1:ListW] list_used_q, list_total;
  logic [NumClients-1:0] list_first;
  logic [ClientW-1:0]    list_client;
  logic [NumW-1:0]       list_num;
  logic list_fits;
  assign list_total = list_count_i[IDX_W-1:ListW] - list_first_i[IDX_W-1:ListW];
  assign list_num   = list_num_i[list_client];
  assign list_fits  = (IDX_W - ListW)'(list_num) <= list_total - list_used_q;
  assign list_idx_o = {list_first_i[IDX_W-1:ListW] + list_used_q, {ListW{1'b0}}};
  rc_rr_arb #(.NumReq(NumClients)) u_list (
    .clk_i, .rst_ni, .req_i(list_req_i), .ready_i(list_fits), .gnt_o(list_first), .idx_o(list_client)
  );
  assign list_gnt_o  = list_fits ? list_first : '0;
  assign list_full_o = list_req_i != '0 && !list_fits;

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {node_used_q, list_used_q} <= '0;
    end else begin
      if (node_gnt_o != '0) node_used_q <= node_used_q + 1'b1;
      if (list_gnt_o != '0) list_used_q <= list_used_q + (IDX_W - ListW)'(list_num);
    end
  end
  logic unused_low;
  assign unused_low = ^{node_first_i[NodeW-1:0], node_count_i[NodeW-1:0],
                        list_first_i[ListW-1:0], list_count_i[ListW-1:0]};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && node_gnt_o != '0) NodesInside_A: assert (node_used_q < node_total);
    if (rst_ni && list_gnt_o != '0) ListsInside_A: assert (list_used_q <= list_total);
    if (rst_ni && list_gnt_o != '0) NotNone_A: assert (list_num != '0);
  end
`endif
endmodule
