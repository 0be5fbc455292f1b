// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Reads the references of waiting jobs, the oldest first, and gives job and references away; the binning pipeline goes on
// meanwhile. An object of one job is read from its vertices. Reading begins before somebody takes the job.
// Rate: a reference a cycle, one in three cycles from vertices. SRAM: line queue 8,192 bits.
module rc_tbu_load import rc_pkg::*; import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  line_addr_t vertex_base_i,
  input  tri_first_t tri_first_i,                    // number of the triangle there
  input  line_addr_t ref_base_i,
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  list_job_t  in_i,
  output logic       read_o,                         // for one cycle: a list was read and may be overwritten
  output logic       bad_o,                          // for one cycle: a coordinate outside
  output logic       req_valid_o,
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,
  input  block64_t   rsp_block_i,
  output logic       waiting_o,                      // jobs wait
  output logic       job_valid_o,                    // then its references, so many as it says
  input  logic       job_ready_i,
  output sort_job_t  job_o,
  output logic       ref_valid_o,
  input  logic       ref_ready_i,
  output tri_ref_t   ref_o
);
  list_job_t head;
  logic      head_valid, head_done, asked_q, given_q, cmd_ready, fetch_valid, fetch_ready;
  count_t    left_q;
  logic [$clog2(NUM_JOBS+1)-1:0] unused_count;
  rc_fifo #(.data_t(list_job_t), .Depth(NUM_JOBS), .Ram(1'b0)) u_jobs (
    .clk_i, .rst_ni, .in_valid_i, .in_ready_o, .in_data_i(in_i),
    .out_valid_o(head_valid), .out_ready_i(head_done), .out_data_o(head), .count_o(unused_count)
  );
  rc_tbu_fetch u_fetch (
    .clk_i, .rst_ni,
    .cmd_valid_i(head_valid && !asked_q), .cmd_ready_o(cmd_ready), .cmd_vertices_i(head.vertices),
    .cmd_line_i(head.vertices ? vertex_base_i : ref_base_i + line_addr_t'(head.base[IDX_W-1:2])),
    .cmd_tri_i(tri_first_i), .cmd_count_i(head.job.count),
    .req_valid_o, .req_ready_i, .req_addr_o, .rsp_valid_i, .rsp_block_i,
    .out_valid_o(fetch_valid), .out_ready_i(fetch_ready), .out_ref_o(ref_o), .bad_o
  );
  assign waiting_o   = head_valid && !given_q;
  assign job_valid_o = waiting_o;
  assign job_o       = head.job;
  assign ref_valid_o = fetch_valid && given_q;
  assign fetch_ready = ref_ready_i && given_q;
  assign head_done   = ref_valid_o && ref_ready_i && left_q == count_t'(1);
  assign read_o      = head_done && !head.vertices;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {asked_q, given_q} <= '0;
    end else if (head_done) begin
      {asked_q, given_q} <= '0;
    end else begin
      if (head_valid && cmd_ready) asked_q <= 1'b1;
      if (job_valid_o && job_ready_i) given_q <= 1'b1;
    end
    if (job_valid_o && job_ready_i) left_q <= head.job.count;
    else if (ref_valid_o && ref_ready_i) left_q <= left_q - 1'b1;
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) if (rst_ni && $past(rst_ni && read_o)) ReadToTheEnd_A: assert (cmd_ready);
`endif
endmodule
