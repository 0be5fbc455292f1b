// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The tree-building unit with its memory ports, for simulation: AXI4 outside, windows as the host would set them.
module rc_tbu_sim_top import rc_pkg::*; import rc_mem_pkg::*; import rc_tbu_pkg::*; #(
  parameter int unsigned Cap   = 1280,
  parameter int unsigned DataW = 64
) (
  input  logic                clk_i,
  input  logic                rst_ni,
  input  logic                start_i,
  input  tbu_cfg_t            cfg_i,
  output logic                busy_o,
  output logic                done_o,
  output logic [2:0]          err_o,
  output idx_t                root_o,
  output tbu_stat_t           stat_o,
  output logic                m_axi_arid,
  output addr_t               m_axi_araddr,
  output logic [7:0]          m_axi_arlen,
  output logic [2:0]          m_axi_arsize,
  output logic [1:0]          m_axi_arburst,
  output logic                m_axi_arvalid,
  input  logic                m_axi_arready,
  input  logic                m_axi_rid,
  input  logic [DataW-1:0]    m_axi_rdata,
  input  logic [1:0]          m_axi_rresp,
  input  logic                m_axi_rlast,
  input  logic                m_axi_rvalid,
  output logic                m_axi_rready,
  output logic                m_axi_awid,
  output addr_t               m_axi_awaddr,
  output logic [7:0]          m_axi_awlen,
  output logic [2:0]          m_axi_awsize,
  output logic [1:0]          m_axi_awburst,
  output logic                m_axi_awvalid,
  input  logic                m_axi_awready,
  output logic [DataW-1:0]    m_axi_wdata,
  output logic [DataW/8-1:0]  m_axi_wstrb,
  output logic                m_axi_wlast,
  output logic                m_axi_wvalid,
  input  logic                m_axi_wready,
  input  logic                m_axi_bid,
  input  logic [1:0]          m_axi_bresp,
  input  logic                m_axi_bvalid,
  output logic                m_axi_bready
);
  function automatic window_t region(line_addr_t base, logic [31:0] bytes);
    return '{lo: base, hi: {1'b0, base} + (LINE_ADDR_W + 1)'((bytes + 32'd63) >> 6)};
  endfunction
  window_t [1:0] rd_window;
  window_t [2:0] wr_window;
  logic       rd_valid, rd_ready, rsp_valid, wr_valid, wr_ready, wr_ack, wr_idle, rd_idle, rd_err, wr_err, ev_line, ev_row;
  line_addr_t rd_addr;
  block64_t   rsp_block;
  addr_t      wr_addr;
  logic [7:0][31:0] wr_data;
  logic [7:0] wr_strb;
  err_t       rd_err_what, wr_err_what;
  tbu_err_e   err;
  assign err_o        = err;
  assign rd_window[0] = region(cfg_i.vertex_base, 32'(cfg_i.tri_count) << 5);
  assign rd_window[1] = region(cfg_i.ref_base, 32'(cfg_i.ref_count) << 4);
  assign wr_window[0] = region(cfg_i.node_base, 32'(cfg_i.node_count) << 3);
  assign wr_window[1] = region(cfg_i.list_base, 32'(cfg_i.list_count) << 2);
  assign wr_window[2] = rd_window[1];
  rc_tbu #(.Cap(Cap)) u_tbu (
    .clk_i, .rst_ni, .start_i, .cfg_i, .busy_o, .done_o, .err_o(err), .root_o, .stat_o,
    .rd_valid_o(rd_valid), .rd_ready_i(rd_ready), .rd_addr_o(rd_addr), .rd_rsp_valid_i(rsp_valid),
    .rd_rsp_block_i(rsp_block), .wr_valid_o(wr_valid), .wr_ready_i(wr_ready), .wr_addr_o(wr_addr), .wr_data_o(wr_data),
    .wr_strb_o(wr_strb), .wr_ack_i(wr_ack), .wr_idle_i(wr_idle), .mem_err_i(rd_err || wr_err)
  );
  rc_mem_rd #(.NumClients(1), .NumWindows(2), .DataW(DataW)) u_rd (
    .req_tag_i('0), .rsp_tag_o(), .ev_tag_o(),
    .clk_i, .rst_ni, .window_i(rd_window), .stop_i(1'b0), .idle_o(rd_idle), .err_valid_o(rd_err), .err_o(rd_err_what),
    .req_valid_i(rd_valid), .req_ready_o(rd_ready), .req_addr_i(rd_addr), .req_halves_i('1), .rsp_valid_o(rsp_valid),
    .rsp_block_o(rsp_block), .ev_line_o(ev_line),
    .m_axi_arid, .m_axi_araddr, .m_axi_arlen, .m_axi_arsize, .m_axi_arburst, .m_axi_arvalid, .m_axi_arready,
    .m_axi_rid, .m_axi_rdata, .m_axi_rresp, .m_axi_rlast, .m_axi_rvalid, .m_axi_rready
  );
  rc_mem_wr #(.NumWindows(3), .DataW(DataW)) u_wr (
    .clk_i, .rst_ni, .window_i(wr_window), .stop_i(1'b0), .idle_o(wr_idle), .err_valid_o(wr_err), .err_o(wr_err_what),
    .wr_valid_i(wr_valid), .wr_ready_o(wr_ready), .wr_addr_i(wr_addr), .wr_data_i(wr_data), .wr_strb_i(wr_strb),
    .ev_row_o(ev_row), .ack_o(wr_ack),
    .m_axi_awid, .m_axi_awaddr, .m_axi_awlen, .m_axi_awsize, .m_axi_awburst, .m_axi_awvalid, .m_axi_awready,
    .m_axi_wdata, .m_axi_wstrb, .m_axi_wlast, .m_axi_wvalid, .m_axi_wready,
    .m_axi_bid, .m_axi_bresp, .m_axi_bvalid, .m_axi_bready
  );
`ifndef SYNTHESIS
  // No error of the window kind: the unit asks for and writes nothing outside.
  always_ff @(posedge clk_i) begin
    if (rst_ni && rd_err) ReadInside_A: assert (rd_err_what.code != ERR_WINDOW);
    if (rst_ni && wr_err) WriteInside_A: assert (wr_err_what.code != ERR_WINDOW);
    if (rst_ni && done_o) Quiet_A: assert (rd_idle && wr_idle);
  end
`endif
endmodule
