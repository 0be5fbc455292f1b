// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// rc_top for the C++ harness: the fields of the trace become ports of their own, arrays by RTU, so that no width or
// bit position is written down in C++. Nothing else happens here.
module rc_sim_top import rc_pkg::*; #(
  parameter int unsigned DataW = 64,       // memory bus, bits
  parameter bit          Tbu   = 1'b0,     // with the tree builder
  parameter int unsigned Cap   = 1280,     // references of a sorting pipeline
  parameter int unsigned NtSets   = 128,     // caches, as in rc_rtu
  parameter int unsigned ListSets = 32,
  parameter int unsigned L2Sets   = 256,
  parameter int unsigned L2Ways   = 14,
  parameter int unsigned NumRtus = 1       // ray-tracing units
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
  // trace, by RTU
  output logic               pri_valid_o [NumRtus],
  output ray_id_t            pri_id_o [NumRtus],
  output logic [15:0]        pri_x_o [NumRtus],
  output logic [15:0]        pri_y_o [NumRtus],
  output logic               sec_valid_o [NumRtus],
  output ray_id_t            sec_id_o [NumRtus],
  output logic [1:0]         sec_kind_o [NumRtus],
  output light_id_t          sec_light_o [NumRtus],
  output depth_t             sec_depth_o [NumRtus],
  output logic               hit_valid_o [NumRtus],
  output ray_id_t            hit_id_o [NumRtus],
  output logic               hit_hit_o [NumRtus],
  output idx_t               hit_tri_o [NumRtus],
  output inst_id_t           hit_inst_o [NumRtus],
  output fp_t                hit_t_o [NumRtus],
  output fp_t                hit_beta_o [NumRtus],
  output fp_t                hit_gamma_o [NumRtus],
  output logic [3:0]         slot_valid_o [NumRtus],   // by T&I pipeline
  output logic [3:0]         slot_lost_o [NumRtus],
  output logic [3:0]         slot_two_o [NumRtus],
  output logic [3:0]         slot_done_o [NumRtus],
  output logic [3:0]         slot_out_o [NumRtus],
  output logic [3:0][7:0]    slot_ray_o [NumRtus],
  output logic [3:0][15:0]   slot_count_o [NumRtus]
);
  trace_t [NumRtus-1:0] trace;
  logic   unused_arid, unused_awid;        // one ID: the memory answers in order

  rc_top #(
    .DataW(DataW), .Tbu(Tbu), .Cap(Cap), .NtSets(NtSets), .ListSets(ListSets), .L2Sets(L2Sets), .L2Ways(L2Ways), .NumRtus(NumRtus)
  ) u_top (
    .*, .m_axi_arid(unused_arid), .m_axi_rid(1'b0), .m_axi_awid(unused_awid), .m_axi_bid(1'b0), .trace_o(trace)
  );

  for (genvar r = 0; r < int'(NumRtus); r++) begin : gen_trace
    assign {pri_valid_o[r], pri_id_o[r], pri_x_o[r], pri_y_o[r]} = {trace[r].pri_valid, trace[r].pri};
    assign {sec_valid_o[r], sec_id_o[r], sec_kind_o[r], sec_light_o[r], sec_depth_o[r]} =
           {trace[r].sec_valid, trace[r].sec_id, trace[r].sec_kind, trace[r].sec_light, trace[r].sec_depth};
    assign {hit_valid_o[r], hit_id_o[r], hit_hit_o[r]} = {trace[r].hit_valid, trace[r].hit.id, trace[r].hit.hit};
    assign {hit_inst_o[r], hit_tri_o[r], hit_t_o[r], hit_beta_o[r], hit_gamma_o[r]} =
           {trace[r].hit.surf, trace[r].hit.t, trace[r].hit.beta, trace[r].hit.gamma};
    for (genvar p = 0; p < 4; p++) begin : gen_slot
      assign {slot_valid_o[r][p], slot_lost_o[r][p], slot_two_o[r][p], slot_done_o[r][p], slot_out_o[r][p]} =
             {trace[r].tni[p].valid, trace[r].tni[p].lost, trace[r].tni[p].two, trace[r].tni[p].done, trace[r].tni[p].out};
      assign {slot_ray_o[r][p], slot_count_o[r][p]} = {3'b0, trace[r].tni[p].ray, trace[r].tni[p].slots};
    end
  end

endmodule
