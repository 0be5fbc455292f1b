// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// rc_top for the C++ harness: the fields of the trace become ports of their own, so that no width or
// bit position is written down in C++. Nothing else happens here.
module rc_sim_top import rc_pkg::*; #(
  parameter int unsigned DataW = 64,       // memory bus, bits
  parameter bit          Tbu   = 1'b0,     // with the tree builder
  parameter int unsigned Cap   = 1280,     // references of a sorting pipeline
  parameter int unsigned NtSets   = 128,  // caches, as in rc_rtu
  parameter int unsigned ListSets = 64,
  parameter int unsigned L2Sets   = 256,
  parameter int unsigned L2Ways   = 13
) (
  input  logic               clk_i,
  input  logic               rst_ni,
  output logic               irq_o,
  // AXI4-Lite, registers
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
  // AXI4, memory
  output logic               m_axi_arvalid,
  input  logic               m_axi_arready,
  output logic [ADDR_W-1:0]  m_axi_araddr,
  output logic [7:0]         m_axi_arlen,
  output logic [2:0]         m_axi_arsize,
  output logic [1:0]         m_axi_arburst,
  input  logic               m_axi_rvalid,
  output logic               m_axi_rready,
  input  logic [DataW-1:0]   m_axi_rdata,
  input  logic [1:0]         m_axi_rresp,
  input  logic               m_axi_rlast,
  output logic               m_axi_awvalid,
  input  logic               m_axi_awready,
  output logic [ADDR_W-1:0]  m_axi_awaddr,
  output logic [7:0]         m_axi_awlen,
  output logic [2:0]         m_axi_awsize,
  output logic [1:0]         m_axi_awburst,
  output logic               m_axi_wvalid,
  input  logic               m_axi_wready,
  output logic [DataW-1:0]   m_axi_wdata,
  output logic [DataW/8-1:0] m_axi_wstrb,
  output logic               m_axi_wlast,
  input  logic               m_axi_bvalid,
  output logic               m_axi_bready,
  input  logic [1:0]         m_axi_bresp,
  // trace
  output logic               pri_valid_o,
  output ray_id_t            pri_id_o,
  output logic [15:0]        pri_x_o,
  output logic [15:0]        pri_y_o,
  output logic               sec_valid_o,
  output ray_id_t            sec_id_o,
  output logic [1:0]         sec_kind_o,
  output light_id_t          sec_light_o,
  output depth_t             sec_depth_o,
  output logic               hit_valid_o,
  output ray_id_t            hit_id_o,
  output logic               hit_hit_o,
  output idx_t               hit_tri_o,
  output fp_t                hit_t_o,
  output fp_t                hit_beta_o,
  output fp_t                hit_gamma_o,
  output logic [3:0]         slot_valid_o,   // by T&I pipeline
  output logic [3:0]         slot_lost_o,
  output logic [3:0]         slot_two_o,
  output logic [3:0]         slot_done_o,
  output logic [3:0]         slot_out_o,
  output logic [3:0][7:0]    slot_ray_o,
  output logic [3:0][15:0]   slot_count_o
);
  trace_t trace;
  logic   unused_arid, unused_awid;        // one ID: the memory answers in order

  rc_top #(.DataW(DataW), .Tbu(Tbu), .Cap(Cap), .NtSets(NtSets), .ListSets(ListSets), .L2Sets(L2Sets), .L2Ways(L2Ways)) u_top (
    .*, .m_axi_arid(unused_arid), .m_axi_rid(1'b0), .m_axi_awid(unused_awid), .m_axi_bid(1'b0), .trace_o(trace)
  );

  assign {pri_valid_o, pri_id_o, pri_x_o, pri_y_o} = {trace.pri_valid, trace.pri};
  assign {sec_valid_o, sec_id_o, sec_kind_o, sec_light_o, sec_depth_o} =
         {trace.sec_valid, trace.sec_id, trace.sec_kind, trace.sec_light, trace.sec_depth};
  assign {hit_valid_o, hit_id_o, hit_hit_o} = {trace.hit_valid, trace.hit.id, trace.hit.hit};
  assign {hit_tri_o, hit_t_o, hit_beta_o, hit_gamma_o} =
         {trace.hit.tri_idx, trace.hit.t, trace.hit.beta, trace.hit.gamma};
  for (genvar p = 0; p < 4; p++) begin : gen_slot
    assign {slot_valid_o[p], slot_lost_o[p], slot_two_o[p], slot_done_o[p], slot_out_o[p]} =
           {trace.tni[p].valid, trace.tni[p].lost, trace.tni[p].two, trace.tni[p].done, trace.tni[p].out};
    assign {slot_ray_o[p], slot_count_o[p]} = {3'b0, trace.tni[p].ray, trace.tni[p].slots};
  end

endmodule
