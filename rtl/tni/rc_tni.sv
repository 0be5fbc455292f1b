// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Traversal and intersection unit: four pipelines and their common L2 cache (paper Sec. 3.2 and 3.5).
//
// A ray goes to the pipeline it prefers, or if that has no free slot to another, in turn; hits come back in any
// order. Rays that are likely to need the same lines should prefer the same pipeline: then the L1 caches hold
// different lines. The pipelines are independent of each other but for the L2 cache. 32 slots a pipeline: 128 rays.
// Rates: one ray in and one hit out a cycle.
module rc_tni import rc_pkg::*; #(
  parameter int unsigned NumPipes = 4,
  parameter int unsigned NtSets   = 128,   // of each L1, 2 ways x 64 bytes
  parameter int unsigned ListSets = 32,
  parameter int unsigned L2Sets   = 256,   // of 64 bytes
  parameter int unsigned L2Ways   = 14,
  parameter int unsigned L1Lock   = 64     // cycles
) (
  input  logic       clk_i,
  input  logic       rst_ni,               // also empties the caches
  input  tree_cfg_t  cfg_i,
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  ray_t       in_i,
  input  pipe_id_t   in_home_i,            // the pipeline it prefers
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output hit_t       out_o,
  output logic       req_valid_o,          // halves of lines from memory
  input  logic       req_ready_i,
  output half_addr_t req_addr_o,
  input  logic       rsp_valid_i,
  input  half_line_t rsp_half_i,
  output logic       err_valid_o,
  output err_t       err_o,
  output tni_ev_t [NumPipes-1:0] ev_o,
  output tni_trace_t [NumPipes-1:0] trace_o,   // for simulations
  output logic       ev_l2_hit_o,
  output logic       ev_l2_miss_o          // also what is already on its way
);
  localparam int unsigned PIPE_W = (NumPipes > 1) ? $clog2(NumPipes) : 1;
  logic [NumPipes-1:0] in_valid, in_ready, out_valid, out_ready, pipe_err_valid;
  hit_t [NumPipes-1:0] out;
  err_t [NumPipes-1:0] pipe_err;
  logic [2*NumPipes-1:0] l1_req_valid, l1_req_ready, l1_fill_valid, l1_fill_ready;
  half_addr_t [2*NumPipes-1:0] l1_req_addr;
  half_addr_t fill_addr;
  logic       fill_both;
  line_t      fill_line;

  // ---- rays in, hits out -----------------------------------------------------------------------------------
  logic [PIPE_W-1:0]   in_idx_unused, home, out_idx;
  logic [NumPipes-1:0] in_turn;
  rc_rr_arb #(.NumReq(NumPipes)) u_in (
    .clk_i, .rst_ni, .req_i(in_ready), .ready_i(in_valid_i), .gnt_o(in_turn), .idx_o(in_idx_unused));
  assign home       = PIPE_W'(in_home_i);
  assign in_valid   = (32'(in_home_i) < NumPipes && in_ready[home]) ? NumPipes'(1) << home : in_turn;
  assign in_ready_o = in_ready != '0;

  logic [NumPipes-1:0] out_gnt;
  logic                skid_ready;
  rc_rr_arb #(.NumReq(NumPipes)) u_out (
    .clk_i, .rst_ni, .req_i(out_valid), .ready_i(skid_ready), .gnt_o(out_gnt), .idx_o(out_idx));
  assign out_ready = skid_ready ? out_gnt : '0;
  // Offered only when there is room: until it is taken, the grant may still go to another pipeline.
  rc_skid #(.data_t(hit_t)) u_skid (
    .clk_i, .rst_ni, .in_valid_i(out_valid != '0 && skid_ready), .in_ready_o(skid_ready), .in_data_i(out[out_idx]),
    .out_valid_o, .out_ready_i, .out_data_o(out_o));

  // ---- pipelines ---------------------------------------------------------------------------------------------
  for (genvar p = 0; p < NumPipes; p++) begin : gen_pipe
    rc_tni_pipe #(.NtSets(NtSets), .ListSets(ListSets), .L1Lock(L1Lock)) u_pipe (
      .clk_i, .rst_ni, .cfg_i,
      .in_valid_i(in_valid_i && in_valid[p]), .in_ready_o(in_ready[p]), .in_i,
      .out_valid_o(out_valid[p]), .out_ready_i(out_ready[p]), .out_o(out[p]),
      .req_valid_o({l1_req_valid[NumPipes+p], l1_req_valid[p]}),
      .req_ready_i({l1_req_ready[NumPipes+p], l1_req_ready[p]}),
      .req_addr_o({l1_req_addr[NumPipes+p], l1_req_addr[p]}),
      .fill_valid_i({l1_fill_valid[NumPipes+p], l1_fill_valid[p]}),
      .fill_ready_o({l1_fill_ready[NumPipes+p], l1_fill_ready[p]}),
      .fill_addr_i(fill_addr), .fill_both_i(fill_both), .fill_line_i(fill_line),
      .err_valid_o(pipe_err_valid[p]), .err_o(pipe_err[p]), .ev_o(ev_o[p]), .trace_o(trace_o[p]));
  end

  logic l2_miss, l2_merge, unused_l2_busy;
  rc_l2 #(.NumClients(2 * NumPipes), .Sets(L2Sets), .Ways(L2Ways)) u_l2 (
    .clk_i, .rst_ni, .req_valid_i(l1_req_valid), .req_ready_o(l1_req_ready), .req_addr_i(l1_req_addr),
    .fill_valid_o(l1_fill_valid), .fill_ready_i(l1_fill_ready), .fill_addr_o(fill_addr), .fill_both_o(fill_both),
    .fill_line_o(fill_line),
    .mem_req_valid_o(req_valid_o), .mem_req_ready_i(req_ready_i), .mem_req_addr_o(req_addr_o),
    .mem_rsp_valid_i(rsp_valid_i), .mem_rsp_half_i(rsp_half_i),
    .ev_hit_o(ev_l2_hit_o), .ev_miss_o(l2_miss), .ev_merge_o(l2_merge), .busy_o(unused_l2_busy));
  assign ev_l2_miss_o = l2_miss || l2_merge;

  // ---- errors: one a cycle is enough, the first ends the frame -------------------------------------------------
  always_comb begin
    err_valid_o = pipe_err_valid != '0;
    err_o       = pipe_err[0];
    for (int p = 1; p < NumPipes; p++) if (pipe_err_valid[p]) err_o = pipe_err[p];
  end
endmodule
