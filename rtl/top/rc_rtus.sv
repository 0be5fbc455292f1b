// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The ray-tracing units: each is a client of the read port; they share the write port, a row each in turn. Settings,
// lights and materials go to all. Of errors in one cycle that of the lowest unit is reported. Wiring only.
module rc_rtus import rc_pkg::*; import rc_top_pkg::*; #(
  parameter int unsigned NumRtus  = 1,
  parameter int unsigned NtSets   = 128,  // caches, as in rc_rtu
  parameter int unsigned ListSets = 32,
  parameter int unsigned L2Sets   = 256,
  parameter int unsigned L2Ways   = 14
) (
  input  logic                     clk_i,
  input  logic                     rst_ni,
  input  tree_cfg_t                tree_i,
  input  camera_t                  camera_i,
  input  shade_cfg_t               shade_i,
  input  frame_cfg_t               frame_i,
  input  logic       [NumRtus-1:0] blk_valid_i,
  output logic       [NumRtus-1:0] blk_ready_o,
  input  block_t     [NumRtus-1:0] blk_i,
  input  logic                     ld_valid_i,
  input  ld_kind_e                 ld_kind_i,
  input  logic [7:0]               ld_idx_i,
  input  line_t                    ld_line_i,
  output logic       [NumRtus-1:0] req_valid_o,      // to rc_mem_rd
  input  logic       [NumRtus-1:0] req_ready_i,
  output line_addr_t [NumRtus-1:0] req_addr_o,
  output logic  [NumRtus-1:0][1:0] req_halves_o,
  output rd_tag_t    [NumRtus-1:0] req_tag_o,
  input  logic       [NumRtus-1:0] rsp_valid_i,
  input  rd_tag_t                  rsp_tag_i,
  input  block64_t                 rsp_block_i,
  output logic                     wr_valid_o,       // to rc_mem_wr
  input  logic                     wr_ready_i,
  output addr_t                    wr_addr_o,
  output logic [7:0][31:0]         wr_data_o,
  output logic [7:0]               wr_strb_o,
  output logic                     err_valid_o,
  output err_t                     err_o,
  output logic                     idle_o,           // no block is open
  output rtu_ev_t    [NumRtus-1:0] ev_o,
  output trace_t     [NumRtus-1:0] trace_o
);
  localparam int unsigned WR_IDX_W = (NumRtus > 1) ? $clog2(NumRtus) : 1;
  if (NumRtus < 1 || NumRtus > 16) begin : gen_bad_num
    $error("NumRtus must be 1 to 16");
  end

  logic  [NumRtus-1:0]            wr_valid, gnt, err_valid, idle;
  addr_t [NumRtus-1:0]            wr_addr;
  logic  [NumRtus-1:0][7:0][31:0] wr_data;
  logic  [NumRtus-1:0][7:0]       wr_strb;
  err_t  [NumRtus-1:0]            err;
  logic  [WR_IDX_W-1:0]              wr_idx;
  line_t                          rsp_line;
  assign rsp_line = used_bits(rsp_block_i);

  for (genvar r = 0; r < int'(NumRtus); r++) begin : gen_rtu
    logic [NUM_RD_TAGS-1:0] rd_valid, rd_ready, rsp_valid;
    half_addr_t             tni_addr;
    line_addr_t             tri_addr, uv_addr, tex_addr;
    rc_rtu #(.NtSets(NtSets), .ListSets(ListSets), .L2Sets(L2Sets), .L2Ways(L2Ways)) u_rtu (
      .clk_i, .rst_ni, .tree_i, .camera_i, .shade_i, .frame_i,
      .blk_valid_i(blk_valid_i[r]), .blk_ready_o(blk_ready_o[r]), .blk_i(blk_i[r]),
      .ld_valid_i, .ld_kind_i, .ld_idx_i, .ld_line_i,
      .tni_req_valid_o(rd_valid[RD_TNI]), .tni_req_ready_i(rd_ready[RD_TNI]), .tni_req_addr_o(tni_addr),
      .tni_rsp_valid_i(rsp_valid[RD_TNI]), .tni_rsp_half_i(rsp_line[3:0]),
      .tri_req_valid_o(rd_valid[RD_TRI]), .tri_req_ready_i(rd_ready[RD_TRI]), .tri_req_addr_o(tri_addr),
      .tri_rsp_valid_i(rsp_valid[RD_TRI]), .tri_rsp_line_i(rsp_line),
      .uv_req_valid_o(rd_valid[RD_UV]), .uv_req_ready_i(rd_ready[RD_UV]), .uv_req_addr_o(uv_addr),
      .uv_rsp_valid_i(rsp_valid[RD_UV]), .uv_rsp_line_i(rsp_line),
      .tex_req_valid_o(rd_valid[RD_TEX]), .tex_req_ready_i(rd_ready[RD_TEX]), .tex_req_addr_o(tex_addr),
      .tex_rsp_valid_i(rsp_valid[RD_TEX]), .tex_rsp_block_i(rsp_block_i),
      .wr_valid_o(wr_valid[r]), .wr_ready_i(wr_ready_i && gnt[r]),
      .wr_addr_o(wr_addr[r]), .wr_data_o(wr_data[r]), .wr_strb_o(wr_strb[r]),
      .err_valid_o(err_valid[r]), .err_o(err[r]), .idle_o(idle[r]), .ev_o(ev_o[r]), .trace_o(trace_o[r])
    );
    rc_rtu_port #(.Cut(NumRtus > 1)) u_port (
      .clk_i, .rst_ni, .req_valid_i(rd_valid), .req_ready_o(rd_ready),
      .tni_addr_i(tni_addr), .tri_addr_i(tri_addr), .uv_addr_i(uv_addr), .tex_addr_i(tex_addr),
      .rsp_valid_o(rsp_valid),
      .port_valid_o(req_valid_o[r]), .port_ready_i(req_ready_i[r]), .port_addr_o(req_addr_o[r]),
      .port_halves_o(req_halves_o[r]), .port_tag_o(req_tag_o[r]),
      .port_rsp_valid_i(rsp_valid_i[r]), .port_rsp_tag_i(rsp_tag_i)
    );
  end

  rc_rr_arb #(.NumReq(NumRtus)) u_wr_arb (
    .clk_i, .rst_ni, .req_i(wr_valid), .ready_i(wr_ready_i), .gnt_o(gnt), .idx_o(wr_idx)
  );
  assign wr_valid_o = wr_valid != '0;
  assign wr_addr_o  = wr_addr[wr_idx];
  assign wr_data_o  = wr_data[wr_idx];
  assign wr_strb_o  = wr_strb[wr_idx];

  always_comb begin
    {err_valid_o, err_o} = {1'b0, err[0]};
    for (int r = int'(NumRtus) - 1; r >= 0; r--)
      if (err_valid[r]) {err_valid_o, err_o} = {1'b1, err[r]};
  end
  assign idle_o = idle == '1;
endmodule
