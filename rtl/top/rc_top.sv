// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// RayCore: registers behind AXI4-Lite, memory behind AXI4, one interrupt, one clock.
// AXI ports keep the names that tools look for. trace_o is for simulations: leave it open on a board.
module rc_top import rc_pkg::*; import rc_top_pkg::*; #(
  parameter int unsigned DataW = 64,         // memory bus: 64, 128 or 256 bits
  parameter int unsigned IdW   = 1,          // memory bus: bits of an ID
  parameter bit          Tbu   = 1'b1,       // with the tree builder
  parameter int unsigned Cap   = 1280,       // references of a sorting pipeline of the tree builder
  parameter bit          Accel = Tbu,        // with the record unit
  parameter int unsigned NtSets   = 128,     // caches, as in rc_rtu
  parameter int unsigned ListSets = 32,
  parameter int unsigned L2Sets   = 256,
  parameter int unsigned L2Ways   = 14,
  parameter int unsigned NumRtus  = 1,       // ray-tracing units
  parameter int unsigned MaxReads = NumRtus > 1 ? 32 : 16   // reads sent and not yet answered
) (
  input  logic               clk_i,
  input  logic               rst_ni,
  output logic               irq_o,
  output trace_t [NumRtus-1:0] trace_o,

  input  logic               s_axil_awvalid,
  output logic               s_axil_awready,
  input  logic [11:0]        s_axil_awaddr,
  input  logic [2:0]         s_axil_awprot,
  input  logic               s_axil_wvalid,
  output logic               s_axil_wready,
  input  logic [31:0]        s_axil_wdata,
  input  logic [3:0]         s_axil_wstrb,
  output logic               s_axil_bvalid,
  input  logic               s_axil_bready,
  output logic [1:0]         s_axil_bresp,
  input  logic               s_axil_arvalid,
  output logic               s_axil_arready,
  input  logic [11:0]        s_axil_araddr,
  input  logic [2:0]         s_axil_arprot,
  output logic               s_axil_rvalid,
  input  logic               s_axil_rready,
  output logic [31:0]        s_axil_rdata,
  output logic [1:0]         s_axil_rresp,

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
  logic      render, build, accel, frame_end;
  idx_t      tbu_root;
  rc_tbu_pkg::tbu_stat_t tbu_stat;
  logic [31:0] accel_cycles;
  setup_t    setup;
  status_t   status;
  counters_t counters;

  rc_csr u_csr (
    .clk_i, .rst_ni,
    .s_axil_awvalid, .s_axil_awready, .s_axil_awaddr, .s_axil_awprot,
    .s_axil_wvalid, .s_axil_wready, .s_axil_wdata, .s_axil_wstrb,
    .s_axil_bvalid, .s_axil_bready, .s_axil_bresp,
    .s_axil_arvalid, .s_axil_arready, .s_axil_araddr, .s_axil_arprot,
    .s_axil_rvalid, .s_axil_rready, .s_axil_rdata, .s_axil_rresp,
    .render_o(render), .build_o(build), .accel_o(accel), .setup_o(setup), .status_i(status), .end_i(frame_end),
    .counters_i(counters), .tbu_root_i(tbu_root), .tbu_stat_i(tbu_stat), .accel_cycles_i(accel_cycles), .irq_o
  );
  rc_core #(
    .DataW(DataW), .IdW(IdW), .Tbu(Tbu), .Cap(Cap), .Accel(Accel),
    .NtSets(NtSets), .ListSets(ListSets), .L2Sets(L2Sets), .L2Ways(L2Ways),
    .NumRtus(NumRtus), .MaxReads(MaxReads)
  ) u_core (
    .clk_i, .rst_ni, .render_i(render), .build_i(build), .accel_i(accel), .setup_i(setup), .status_o(status),
    .end_o(frame_end), .counters_o(counters), .tbu_root_o(tbu_root), .tbu_stat_o(tbu_stat),
    .accel_cycles_o(accel_cycles), .trace_o,
    .m_axi_arid, .m_axi_araddr, .m_axi_arlen, .m_axi_arsize, .m_axi_arburst, .m_axi_arvalid, .m_axi_arready,
    .m_axi_rid, .m_axi_rdata, .m_axi_rresp, .m_axi_rlast, .m_axi_rvalid, .m_axi_rready,
    .m_axi_awid, .m_axi_awaddr, .m_axi_awlen, .m_axi_awsize, .m_axi_awburst, .m_axi_awvalid, .m_axi_awready,
    .m_axi_wdata, .m_axi_wstrb, .m_axi_wlast, .m_axi_wvalid, .m_axi_wready,
    .m_axi_bid, .m_axi_bresp, .m_axi_bvalid, .m_axi_bready
  );

endmodule
