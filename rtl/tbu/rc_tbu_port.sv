// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Memory ports of the tree-building unit. Reads: two clients, in turn, answers by the order of requests. Writes: rows of all
// who write, in turn, as addresses; rows without strobes are left out. Keeps count of rows of references on their way, since
// a list may be read only when its write answers are in. Halted, it asks for nothing more.
module rc_tbu_port import rc_pkg::*; import rc_tbu_pkg::*; #(
  parameter int unsigned NumWriters = 6,
  parameter int unsigned MaxBurst   = 16             // lines, and rows, on their way
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       halt_i,
  output logic       reads_idle_o,                   // no line is on its way
  input  line_addr_t node_base_i,
  input  line_addr_t list_base_i,
  input  line_addr_t ref_base_i,
  input  logic       [1:0] req_valid_i,
  output logic       [1:0] req_ready_o,
  input  line_addr_t [1:0] req_addr_i,
  output logic       [1:0] rsp_valid_o,
  input  logic       [NumWriters-1:0] wr_valid_i,
  output logic       [NumWriters-1:0] wr_ready_o,
  input  tbu_wr_t    [NumWriters-1:0] wr_i,
  output logic       rows_gone_o,                    // no row waits in here, and all were answered
  output logic       confirmed_o,                    // no row of references is on its way
  output logic       ev_line_o,                      // a line is asked for
  output logic       ev_row_o,                       // a row is given to memory; the next three belong to it
  output logic [2:0] ev_nodes_o,
  output logic [3:0] ev_entries_o,
  output logic [2:0] ev_jumps_o,
  output logic       rd_valid_o,                     // to rc_mem_rd
  input  logic       rd_ready_i,
  output line_addr_t rd_addr_o,
  input  logic       rd_rsp_valid_i,
  output logic       wr_valid_o,                     // to rc_mem_wr
  input  logic       wr_ready_i,
  output addr_t      wr_addr_o,
  output logic [7:0][31:0] wr_data_o,
  output logic [7:0] wr_strb_o,
  input  logic       wr_ack_i                        // a row was confirmed, in order
);
  localparam int unsigned CNT_W = $clog2(MaxBurst + 1);
  localparam int unsigned WriterW = (NumWriters > 1) ? $clog2(NumWriters) : 1;

  // ---- reads -------------------------------------------------------------------------------------------------
  logic [1:0] rd_gnt;
  logic       rd_sel, rd_in_valid, rd_in_ready, rd_skid_valid, order_ready, order_valid, order_head, rd_fire;
  typedef struct packed {logic client; line_addr_t addr;} read_t;
  read_t      rd_head;
  logic [CNT_W-1:0] unused_order_count;
  rc_rr_arb #(.NumReq(2)) u_rd_arb (
    .clk_i, .rst_ni, .req_i(req_valid_i), .ready_i(rd_in_ready), .gnt_o(rd_gnt), .idx_o(rd_sel)
  );
  assign rd_in_valid = rd_gnt != '0;
  assign req_ready_o = rd_in_ready ? rd_gnt : '0;
  rc_skid #(.data_t(read_t)) u_rd (
    .clk_i, .rst_ni, .in_valid_i(rd_in_valid && rd_in_ready), .in_ready_o(rd_in_ready),
    .in_data_i('{client: rd_sel, addr: req_addr_i[rd_sel]}),
    .out_valid_o(rd_skid_valid), .out_ready_i(rd_fire), .out_data_o(rd_head)
  );
  assign rd_valid_o = rd_skid_valid && order_ready && !halt_i;
  assign rd_addr_o  = rd_head.addr;
  assign rd_fire    = rd_valid_o && rd_ready_i;
  assign ev_line_o  = rd_fire;
  rc_fifo #(.data_t(logic), .Depth(MaxBurst), .Ram(1'b0)) u_order (
    .clk_i, .rst_ni, .in_valid_i(rd_fire), .in_ready_o(order_ready), .in_data_i(rd_head.client),
    .out_valid_o(order_valid), .out_ready_i(rd_rsp_valid_i), .out_data_o(order_head), .count_o(unused_order_count)
  );
  assign rsp_valid_o  = (rd_rsp_valid_i && order_valid) ? 2'b01 << order_head : '0;
  assign reads_idle_o = !order_valid;

  // ---- writes ------------------------------------------------------------------------------------------------
  logic [NumWriters-1:0] wr_gnt;
  logic [WriterW-1:0]    wr_sel;
  logic       wr_in_ready, wr_skid_valid, wr_fire, kinds_ready, kinds_valid, kinds_head;
  tbu_wr_t    wr_in, wr_head;
  logic [CNT_W-1:0] unused_kinds_count;
  logic [CNT_W:0]   refs_q;                          // rows of references in here and in memory
  rc_rr_arb #(.NumReq(NumWriters)) u_wr_arb (
    .clk_i, .rst_ni, .req_i(wr_valid_i), .ready_i(wr_in_ready), .gnt_o(wr_gnt), .idx_o(wr_sel)
  );
  assign wr_ready_o = wr_in_ready ? wr_gnt : '0;
  assign wr_in      = wr_i[wr_sel];
  logic wr_push;
  assign wr_push    = wr_gnt != '0 && wr_in_ready && wr_in.strb != '0;
  rc_skid #(.data_t(tbu_wr_t)) u_wr (
    .clk_i, .rst_ni, .in_valid_i(wr_push), .in_ready_o(wr_in_ready), .in_data_i(wr_in),
    .out_valid_o(wr_skid_valid), .out_ready_i(wr_fire), .out_data_o(wr_head)
  );
  assign wr_valid_o = wr_skid_valid && kinds_ready && !halt_i;
  assign wr_fire    = wr_valid_o && wr_ready_i;
  assign wr_data_o  = wr_head.data;
  assign wr_strb_o  = wr_head.strb;
  always_comb begin
    case (wr_head.kind)
      WR_NODE: wr_addr_o = {node_base_i, 6'b0} + {3'b0, wr_head.row, 5'b0};
      WR_LIST: wr_addr_o = {list_base_i, 6'b0} + {3'b0, wr_head.row, 5'b0};
      default: wr_addr_o = {ref_base_i, 6'b0} + {3'b0, wr_head.row, 5'b0};
    endcase
  end
  rc_fifo #(.data_t(logic), .Depth(MaxBurst), .Ram(1'b0)) u_kinds (
    .clk_i, .rst_ni, .in_valid_i(wr_fire), .in_ready_o(kinds_ready), .in_data_i(wr_head.kind == WR_REF),
    .out_valid_o(kinds_valid), .out_ready_i(wr_ack_i), .out_data_o(kinds_head), .count_o(unused_kinds_count)
  );
  assign confirmed_o = refs_q == '0;
  assign rows_gone_o = wr_valid_i == '0 && !wr_skid_valid && !kinds_valid;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) refs_q <= '0;
    else refs_q <= refs_q + (CNT_W + 1)'(wr_push && wr_in.kind == WR_REF)
                          - (CNT_W + 1)'(wr_ack_i && kinds_valid && kinds_head);
  end

  // ---- figures -----------------------------------------------------------------------------------------------
  localparam logic [28:0] JUMP = {2'b01, 1'b0, 2'b00, JUMP_SPLIT};   // lower child empty, axis x
  assign ev_row_o = wr_fire;
  always_comb begin
    {ev_nodes_o, ev_jumps_o, ev_entries_o} = '0;
    for (int i = 0; i < 4; i++) begin
      if (wr_head.kind == WR_NODE && wr_head.strb[2*i]) begin
        ev_nodes_o += 1'b1;
        if (wr_head.data[2*i][28:0] == JUMP) ev_jumps_o += 1'b1;
      end
    end
    for (int i = 0; i < 8; i++) if (wr_head.kind == WR_LIST && wr_head.strb[i]) ev_entries_o += 1'b1;
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && rd_rsp_valid_i) Asked_A: assert (order_valid);
    if (rst_ni && wr_ack_i) Written_A: assert (kinds_valid);
  end
`endif
endmodule
