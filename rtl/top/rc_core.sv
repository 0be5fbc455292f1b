// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// RayCore without its registers: frame control, dispatcher, ray-tracing unit, memory ports.
module rc_core import rc_pkg::*; import rc_mem_pkg::*; import rc_top_pkg::*; #(
  parameter int unsigned DataW = 64,         // memory bus: 64, 128 or 256 bits
  parameter int unsigned IdW   = 1           // memory bus: bits of an ID
) (
  input  logic               clk_i,
  input  logic               rst_ni,
  input  logic               start_i,
  input  setup_t             setup_i,        // constant while busy
  output status_t            status_o,
  output logic               end_o,          // one cycle, with the final status
  output counters_t          counters_o,
  output trace_t             trace_o,        // for simulations

  output logic [IdW-1:0]     m_axi_arid,
  output addr_t              m_axi_araddr,
  output logic [7:0]         m_axi_arlen,
  output logic [2:0]         m_axi_arsize,
  output logic [1:0]         m_axi_arburst,
  output logic               m_axi_arvalid,
  input  logic               m_axi_arready,
  input  logic [IdW-1:0]     m_axi_rid,
  input  logic [DataW-1:0]   m_axi_rdata,
  input  logic [1:0]         m_axi_rresp,
  input  logic               m_axi_rlast,
  input  logic               m_axi_rvalid,
  output logic               m_axi_rready,
  output logic [IdW-1:0]     m_axi_awid,
  output addr_t              m_axi_awaddr,
  output logic [7:0]         m_axi_awlen,
  output logic [2:0]         m_axi_awsize,
  output logic [1:0]         m_axi_awburst,
  output logic               m_axi_awvalid,
  input  logic               m_axi_awready,
  output logic [DataW-1:0]   m_axi_wdata,
  output logic [DataW/8-1:0] m_axi_wstrb,
  output logic               m_axi_wlast,
  output logic               m_axi_wvalid,
  input  logic               m_axi_wready,
  input  logic [IdW-1:0]     m_axi_bid,
  input  logic [1:0]         m_axi_bresp,
  input  logic               m_axi_bvalid,
  output logic               m_axi_bready
);
  // ---- frame control --------------------------------------------------------------------------------
  logic                      unit_rst_n, stop, clear, count;
  logic                      load_start, load_busy, trace_start, all_sent, rtu_idle, rd_idle, wr_idle;
  logic                      bad;
  addr_t                     bad_reg;
  window_t [NUM_WINDOWS-1:0] rd_window;
  window_t                   wr_window;
  logic                      rtu_err_valid, rd_err_valid, wr_err_valid;
  err_t                      rtu_err, rd_err, wr_err;

  rc_setup_check u_setup_check (
    .clk_i, .setup_i, .rd_window_o(rd_window), .wr_window_o(wr_window), .bad_o(bad), .bad_reg_o(bad_reg)
  );
  rc_frame_ctrl #(.NumErr(3)) u_ctrl (
    .clk_i, .rst_ni, .start_i, .status_o, .end_o, .clear_o(clear), .count_o(count),
    .bad_i(bad), .bad_reg_i(bad_reg),
    .err_valid_i({wr_err_valid, rd_err_valid, rtu_err_valid}), .err_i({wr_err, rd_err, rtu_err}),
    .unit_rst_no(unit_rst_n), .stop_o(stop),
    .load_start_o(load_start), .load_busy_i(load_busy),
    .trace_start_o(trace_start), .units_idle_i(all_sent && rtu_idle), .ports_idle_i(rd_idle && wr_idle)
  );

  // ---- lights and materials ---------------------------------------------------------------------------
  logic       [NUM_RD_CLIENTS-1:0] req_valid, req_ready, rsp_valid, ev_line;
  line_addr_t [NUM_RD_CLIENTS-1:0] req_addr;
  logic  [NUM_RD_CLIENTS-1:0][1:0] req_halves;
  block64_t                        rsp_block;
  line_t                           rsp_line, ld_line;
  half_addr_t                      tni_req_addr;
  logic                            ld_valid;
  ld_kind_e                        ld_kind;
  logic       [7:0]                ld_idx;
  assign rsp_line = used_bits(rsp_block);
  assign req_addr[RD_TNI] = tni_req_addr[HALF_ADDR_W-1:1];
  always_comb begin
    req_halves         = '1;
    req_halves[RD_TNI] = {tni_req_addr[0], !tni_req_addr[0]};
  end
  rc_loader u_loader (
    .clk_i, .rst_ni(unit_rst_n), .start_i(load_start), .busy_o(load_busy),
    .light_base_i(setup_i.light_base), .light_count_i(setup_i.light_count[4:0]),
    .mat_base_i(setup_i.mat_base), .mat_count_i(setup_i.mat_count[8:0]),
    .req_valid_o(req_valid[RD_LOADER]), .req_ready_i(req_ready[RD_LOADER]), .req_addr_o(req_addr[RD_LOADER]),
    .rsp_valid_i(rsp_valid[RD_LOADER]), .rsp_line_i(rsp_line),
    .ld_valid_o(ld_valid), .ld_kind_o(ld_kind), .ld_idx_o(ld_idx), .ld_line_o(ld_line)
  );

  // ---- rays ---------------------------------------------------------------------------------------------
  logic       blk_valid, blk_ready;
  block_t     blk;
  shade_cfg_t shade_cfg;
  rtu_ev_t    rtu_ev;
  logic             wr_valid, wr_ready;
  addr_t            wr_addr;
  logic [7:0][31:0] wr_data;
  logic [7:0]       wr_strb;
  assign shade_cfg = '{
    info_base: setup_i.info_base, uv_base: setup_i.uv_base, tex_base: setup_i.tex_base, mip_bias: setup_i.mip_bias,
    trilinear: setup_i.trilinear, max_depth: setup_i.max_depth, min_weight: setup_i.min_weight,
    mat_count: setup_i.mat_count[8:0], light_count: setup_i.light_count[4:0],
    shadows: setup_i.shadows, background: setup_i.background
  };
  rc_dispatch #(.NumRtus(1)) u_dispatch (
    .clk_i, .rst_ni(unit_rst_n), .start_i(trace_start),
    .width_i(setup_i.frame.width), .height_i(setup_i.frame.height),
    .blk_valid_o(blk_valid), .blk_ready_i(blk_ready), .blk_o(blk), .all_sent_o(all_sent)
  );
  rc_rtu u_rtu (
    .clk_i, .rst_ni(unit_rst_n),
    .tree_i(setup_i.tree), .camera_i(setup_i.camera), .shade_i(shade_cfg), .frame_i(setup_i.frame),
    .blk_valid_i(blk_valid), .blk_ready_o(blk_ready), .blk_i(blk),
    .ld_valid_i(ld_valid), .ld_kind_i(ld_kind), .ld_idx_i(ld_idx), .ld_line_i(ld_line),
    .tni_req_valid_o(req_valid[RD_TNI]), .tni_req_ready_i(req_ready[RD_TNI]), .tni_req_addr_o(tni_req_addr),
    .tni_rsp_valid_i(rsp_valid[RD_TNI]), .tni_rsp_half_i(rsp_line[3:0]),
    .tri_req_valid_o(req_valid[RD_TRI]), .tri_req_ready_i(req_ready[RD_TRI]), .tri_req_addr_o(req_addr[RD_TRI]),
    .tri_rsp_valid_i(rsp_valid[RD_TRI]), .tri_rsp_line_i(rsp_line),
    .uv_req_valid_o(req_valid[RD_UV]), .uv_req_ready_i(req_ready[RD_UV]), .uv_req_addr_o(req_addr[RD_UV]),
    .uv_rsp_valid_i(rsp_valid[RD_UV]), .uv_rsp_line_i(rsp_line),
    .tex_req_valid_o(req_valid[RD_TEX]), .tex_req_ready_i(req_ready[RD_TEX]), .tex_req_addr_o(req_addr[RD_TEX]),
    .tex_rsp_valid_i(rsp_valid[RD_TEX]), .tex_rsp_block_i(rsp_block),
    .wr_valid_o(wr_valid), .wr_ready_i(wr_ready), .wr_addr_o(wr_addr), .wr_data_o(wr_data), .wr_strb_o(wr_strb),
    .err_valid_o(rtu_err_valid), .err_o(rtu_err), .idle_o(rtu_idle),
    .ev_o(rtu_ev), .trace_o
  );

  // ---- memory ---------------------------------------------------------------------------------------------
  logic ev_row, unused_ack;
  rc_mem_rd #(.NumClients(NUM_RD_CLIENTS), .NumWindows(NUM_WINDOWS), .DataW(DataW), .IdW(IdW)) u_mem_rd (
    .clk_i, .rst_ni, .window_i(rd_window), .stop_i(stop), .idle_o(rd_idle),
    .err_valid_o(rd_err_valid), .err_o(rd_err),
    .req_valid_i(req_valid), .req_ready_o(req_ready), .req_addr_i(req_addr), .req_halves_i(req_halves),
    .rsp_valid_o(rsp_valid), .rsp_block_o(rsp_block), .ev_line_o(ev_line),
    .m_axi_arid, .m_axi_araddr, .m_axi_arlen, .m_axi_arsize, .m_axi_arburst, .m_axi_arvalid, .m_axi_arready,
    .m_axi_rid, .m_axi_rdata, .m_axi_rresp, .m_axi_rlast, .m_axi_rvalid, .m_axi_rready
  );
  rc_mem_wr #(.NumWindows(1), .DataW(DataW), .IdW(IdW)) u_mem_wr (
    .clk_i, .rst_ni, .window_i(wr_window), .stop_i(stop), .idle_o(wr_idle),
    .err_valid_o(wr_err_valid), .err_o(wr_err),
    .wr_valid_i(wr_valid), .wr_ready_o(wr_ready), .wr_addr_i(wr_addr), .wr_data_i(wr_data), .wr_strb_i(wr_strb),
    .ev_row_o(ev_row), .ack_o(unused_ack),
    .m_axi_awid, .m_axi_awaddr, .m_axi_awlen, .m_axi_awsize, .m_axi_awburst, .m_axi_awvalid, .m_axi_awready,
    .m_axi_wdata, .m_axi_wstrb, .m_axi_wlast, .m_axi_wvalid, .m_axi_wready,
    .m_axi_bid, .m_axi_bresp, .m_axi_bvalid, .m_axi_bready
  );
  rc_counters u_counters (
    .clk_i, .rst_ni, .clear_i(clear), .count_i(count), .rtu_ev_i(rtu_ev), .line_i(ev_line),
    .rd_stall_i(m_axi_arvalid && !m_axi_arready), .row_i(ev_row), .counters_o
  );

endmodule
