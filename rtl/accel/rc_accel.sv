// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Record unit: TriAccel records and triangle information from vertex and attribute records (paper Sec. 6, future work: a
// dynamic object then needs nothing of the processor but its vertices). Three stages with a triangle in each; docs/accel.md
// has formats, arithmetic and rates. A bad coordinate ends it: no more is asked for or written.
module rc_accel import rc_pkg::*; import rc_accel_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       start_i,                    // for one cycle, when not busy
  input  accel_cfg_t cfg_i,                      // constant while busy; at least one triangle
  output logic       busy_o,
  output logic       done_o,                     // for one cycle: all rows were answered
  output logic       bad_o,                      // for one cycle: a coordinate is off the grid, there is no done_o
  output idx_t       bad_idx_o,                  // of the triangle
  output logic [31:0] cycles_o,                  // of the last run
  output logic       rd_valid_o,                 // lines to read; at most 8 on their way
  input  logic       rd_ready_i,
  output line_addr_t rd_addr_o,
  input  logic       rd_rsp_valid_i,             // in order
  input  block64_t   rd_rsp_block_i,
  output logic       wr_valid_o,                 // rows to write
  input  logic       wr_ready_i,
  output addr_t      wr_addr_o,
  output logic [7:0][31:0] wr_data_o,
  input  logic       wr_ack_i                    // a row was answered, in order
);
  logic         halt, rec_valid, rec_ready, attr_valid, attr_ready, last;
  logic [216:0] rec;
  attr_t        attr;
  rc_accel_fetch u_fetch (
    .clk_i, .rst_ni, .start_i,
    .vertex_line_i(cfg_i.vertex_base), .attr_line_i(cfg_i.attr_base), .count_i(cfg_i.tri_count),
    .halt_i(halt), .req_valid_o(rd_valid_o), .req_ready_i(rd_ready_i), .req_addr_o(rd_addr_o),
    .rsp_valid_i(rd_rsp_valid_i), .rsp_block_i(rd_rsp_block_i),
    .rec_valid_o(rec_valid), .rec_ready_i(rec_ready), .rec_o(rec),
    .attr_valid_o(attr_valid), .attr_ready_i(attr_ready), .attr_o(attr), .last_o(last)
  );
  logic   cross_valid, cross_ready, cross_bad, proj_valid, proj_ready;
  cross_t whole;
  proj_t  proj;
  rc_accel_cross u_cross (
    .clk_i, .rst_ni, .eye_i(cfg_i.eye), .in_valid_i(rec_valid), .in_ready_o(rec_ready), .in_rec_i(rec),
    .out_valid_o(cross_valid), .out_ready_i(cross_ready), .out_o(whole), .bad_o(cross_bad)
  );
  rc_accel_proj u_proj (
    .clk_i, .rst_ni, .slack_i(cfg_i.slack),
    .in_valid_i(cross_valid && !cross_bad), .in_ready_o(cross_ready), .in_i(whole),
    .out_valid_o(proj_valid), .out_ready_i(proj_ready), .out_o(proj)
  );
  logic       row_valid;
  logic [1:0] row_idx;
  rc_accel_norm u_norm (
    .clk_i, .rst_ni, .in_valid_i(proj_valid), .in_ready_o(proj_ready), .in_i(proj),
    .attr_valid_i(attr_valid), .attr_ready_o(attr_ready), .attr_i(attr),
    .row_valid_o(row_valid), .row_ready_i(wr_ready_i), .row_idx_o(row_idx), .row_o(wr_data_o)
  );

  // ---- rows ------------------------------------------------------------------------------------------------
  idx_t       idx_q, cross_idx_q;                // of the triangle that is written, and of that in the first stage
  logic [4:0] open_q;                            // rows not yet answered
  logic       halted_q, all_q, row_take;
  assign halt       = halted_q;
  assign wr_valid_o = row_valid && !halt && open_q != '1;
  assign row_take   = wr_valid_o && wr_ready_i;
  assign wr_addr_o  = row_idx == 2'd0 ? {cfg_i.accel_base, 6'b0} + {3'b0, idx_q, 5'b0}
                                      : {cfg_i.info_base, 6'b0} + {2'b0, idx_q, row_idx[1], 5'b0};
  assign bad_o      = cross_valid && cross_bad && !halted_q;
  assign bad_idx_o  = cross_idx_q;
  assign done_o     = busy_o && all_q && open_q == '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {busy_o, halted_q, all_q, open_q, cycles_o} <= '0;
    end else begin
      open_q <= open_q + 5'(row_take) - 5'(wr_ack_i);
      if (bad_o) halted_q <= 1'b1;
      if (start_i) {busy_o, all_q, cycles_o} <= {1'b1, 1'b0, 32'd0};
      else begin
        if (row_take && attr_ready && last) all_q <= 1'b1;
        if (done_o) busy_o <= 1'b0;
        if (busy_o && !halted_q) cycles_o <= cycles_o + 1'b1;
      end
    end
    if (start_i) {idx_q, cross_idx_q} <= '0;
    else begin
      if (attr_ready) idx_q <= idx_q + 1'b1;
      if (cross_valid && cross_ready && !cross_bad) cross_idx_q <= cross_idx_q + 1'b1;
    end
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && start_i) Idle_M: assume (!busy_o);
    if (rst_ni && wr_ack_i) Written_A: assert (open_q != '0);
  end
`endif
endmodule
