// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Two or more that write rows share a write port (rc_mem_wr): in turn, a row at a time, combinational; answers go to whom
// the row was from. MaxBurst rows may be on their way in all.
module rc_mem_share import rc_pkg::*; #(
  parameter int unsigned NumWriters = 2,
  parameter int unsigned MaxBurst   = 16       // as rc_mem_wr has
) (
  input  logic                             clk_i,
  input  logic                             rst_ni,     // with nothing on its way
  input  logic [NumWriters-1:0]            wr_valid_i, // rows that have something to write
  output logic [NumWriters-1:0]            wr_ready_o,
  input  addr_t [NumWriters-1:0]           wr_addr_i,
  input  logic [NumWriters-1:0][7:0][31:0] wr_data_i,
  input  logic [NumWriters-1:0][7:0]       wr_strb_i,
  output logic [NumWriters-1:0]            ack_o,
  output logic [NumWriters-1:0]            idle_o,     // no row is on its way
  output logic                             port_valid_o,
  input  logic                             port_ready_i,
  output addr_t                            port_addr_o,
  output logic [7:0][31:0]                 port_data_o,
  output logic [7:0]                       port_strb_o,
  input  logic                             port_ack_i
);
  localparam int unsigned WriterW = (NumWriters > 1) ? $clog2(NumWriters) : 1;
  localparam int unsigned CountW  = $clog2(MaxBurst + 1);
  logic [NumWriters-1:0] gnt;
  logic [WriterW-1:0]    sel, owner;
  logic                  room, take, owned;
  logic [CountW-1:0]     unused_count;
  logic [NumWriters-1:0][CountW-1:0] open_q;
  rc_rr_arb #(.NumReq(NumWriters)) u_arb (
    .clk_i, .rst_ni, .req_i(wr_valid_i), .ready_i(take), .gnt_o(gnt), .idx_o(sel)
  );
  assign port_valid_o = gnt != '0 && room;
  assign take         = port_valid_o && port_ready_i;
  assign wr_ready_o   = (room && port_ready_i) ? gnt : '0;
  assign port_addr_o  = wr_addr_i[sel];
  assign port_data_o  = wr_data_i[sel];
  assign port_strb_o  = wr_strb_i[sel];
  rc_fifo #(.data_t(logic [WriterW-1:0]), .Depth(MaxBurst), .Ram(1'b0)) u_owner (
    .clk_i, .rst_ni, .in_valid_i(take), .in_ready_o(room), .in_data_i(sel),
    .out_valid_o(owned), .out_ready_i(port_ack_i), .out_data_o(owner), .count_o(unused_count)
  );
  always_comb begin
    for (int w = 0; w < int'(NumWriters); w++) begin
      ack_o[w]  = port_ack_i && owned && owner == WriterW'(w);
      idle_o[w] = open_q[w] == '0;
    end
  end
  always_ff @(posedge clk_i) begin
    for (int w = 0; w < int'(NumWriters); w++) begin
      if (!rst_ni) open_q[w] <= '0;
      else open_q[w] <= open_q[w] + CountW'(take && gnt[w]) - CountW'(ack_o[w]);
    end
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && port_ack_i) Written_A: assert (owned);
  end
`endif
endmodule
