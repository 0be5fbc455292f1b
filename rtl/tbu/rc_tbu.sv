// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Tree-building unit (paper Sec. 3.7): one binning pipeline and four sorting pipelines build the kd-tree of an object from its
// vertices. docs/tbu.md has the rules, the seams and the figures. It is a client of rc_mem_rd and the only one of an rc_mem_wr.
module rc_tbu import rc_pkg::*; import rc_tbu_pkg::*; #(
  parameter int unsigned Cap = 1280                  // references of a sorting pipeline, multiple of 4, at most 2044
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       start_i,                        // for one cycle, when not busy
  input  tbu_cfg_t   cfg_i,                          // constant while busy
  output logic       busy_o,
  output logic       done_o,                         // for one cycle; what follows stays
  output tbu_err_e   err_o,                          // TBU_OK: there is a tree
  output idx_t       root_o,
  output tbu_stat_t  stat_o,
  output logic       rd_valid_o,                     // lines to read; at most 16 on their way
  input  logic       rd_ready_i,
  output line_addr_t rd_addr_o,
  input  logic       rd_rsp_valid_i,                 // in order
  input  block64_t   rd_rsp_block_i,
  output logic       wr_valid_o,                     // rows to write; at most 16 on their way
  input  logic       wr_ready_i,
  output addr_t      wr_addr_o,
  output logic [7:0][31:0] wr_data_o,
  output logic [7:0] wr_strb_o,
  input  logic       wr_ack_i,                       // a row was answered, in order
  input  logic       wr_idle_i,                      // no row is on its way
  input  logic       mem_err_i                       // for one cycle: reading or writing failed
);
  localparam int unsigned N = NUM_SORTERS;
  logic sort_rst_n, don_want;
  logic [6:0] ent_idx;
  logic [N-1:0] sort_busy, forced, job_valid, job_ready, ref_valid, ref_ready, row_valid, row_ready, unused_jump;
  logic [N-1:0] don_valid, don_ready, don_ref_valid, don_ref_ready, ent_valid, ent_ready, donated_valid, donated_ready;
  logic [N-1:0] sub_valid, sub_ready;
  logic [N-1:0][1:0] ext_req, ext_gnt;
  logic [N-1:0][3:0] ext_num;
  idx_t      [N-1:0] ext_idx;
  sort_job_t [N-1:0] job, don_job;
  tri_ref_t  [N-1:0] job_ref, don_ref;
  donated_t  [N-1:0] donated;
  subtree_t  [N-1:0] sub;
  tbu_wr_t   [N-1:0] row;
  rc_tbu_core #(.Cap(Cap)) u_core (
    .clk_i, .rst_ni, .start_i, .cfg_i, .busy_o, .done_o, .err_o, .root_o, .stat_o,
    .rd_valid_o, .rd_ready_i, .rd_addr_o, .rd_rsp_valid_i, .rd_rsp_block_i,
    .wr_valid_o, .wr_ready_i, .wr_addr_o, .wr_data_o, .wr_strb_o, .wr_ack_i, .wr_idle_i, .mem_err_i,
    .sort_rst_no(sort_rst_n), .sort_idle_i(~sort_busy), .ev_forced_i(forced),
    .job_valid_o(job_valid), .job_ready_i(job_ready), .job_o(job),
    .ref_valid_o(ref_valid), .ref_ready_i(ref_ready), .ref_o(job_ref),
    .don_want_o(don_want), .don_valid_i(don_valid), .don_ready_o(don_ready), .don_job_i(don_job),
    .don_ref_valid_i(don_ref_valid), .don_ref_ready_o(don_ref_ready), .don_ref_i(don_ref),
    .ent_valid_o(ent_valid), .ent_ready_i(ent_ready), .ent_idx_o(ent_idx),
    .donated_valid_i(donated_valid), .donated_ready_o(donated_ready), .donated_i(donated),
    .sub_valid_i(sub_valid), .sub_ready_o(sub_ready), .sub_i(sub),
    .ext_req_i(ext_req), .ext_num_i(ext_num), .ext_gnt_o(ext_gnt), .ext_idx_o(ext_idx),
    .row_valid_i(row_valid), .row_ready_o(row_ready), .row_i(row)
  );
  for (genvar i = 0; i < N; i++) begin : gen_sort
    rc_tbp_sort #(.Cap(Cap)) u_sort (
      .clk_i, .rst_ni(sort_rst_n), .busy_o(sort_busy[i]),
      .job_valid_i(job_valid[i]), .job_ready_o(job_ready[i]), .job_i(job[i]),
      .ref_valid_i(ref_valid[i]), .ref_ready_o(ref_ready[i]), .ref_i(job_ref[i]),
      .ext_req_o(ext_req[i]), .ext_num_o(ext_num[i]), .ext_gnt_i(ext_gnt[i]), .ext_idx_i(ext_idx[i]),
      .wr_valid_o(row_valid[i]), .wr_ready_i(row_ready[i]), .wr_o(row[i]),
      .sub_valid_o(sub_valid[i]), .sub_ready_i(sub_ready[i]), .sub_o(sub[i]),
      .don_want_i(don_want), .don_valid_o(don_valid[i]), .don_ready_i(don_ready[i]), .don_job_o(don_job[i]),
      .don_ref_valid_o(don_ref_valid[i]), .don_ref_ready_i(don_ref_ready[i]), .don_ref_o(don_ref[i]),
      .ent_valid_i(ent_valid[i]), .ent_ready_o(ent_ready[i]), .ent_idx_i(ent_idx),
      .upper_valid_o(donated_valid[i]), .upper_ready_i(donated_ready[i]), .upper_o(donated[i]),
      .ev_jump_o(unused_jump[i]), .ev_forced_o(forced[i])
    );
  end
endmodule
