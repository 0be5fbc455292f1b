// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Reads vertex and attribute records, two a line, a line of each in turn. Depth lines of each are asked for or wait in here,
// so answers always find room; vertices are given away before the attributes of their triangle.
module rc_accel_fetch import rc_pkg::*; import rc_accel_pkg::*; #(
  parameter int unsigned Depth = 4               // lines of a kind
) (
  input  logic         clk_i,
  input  logic         rst_ni,
  input  logic         start_i,
  input  line_addr_t   vertex_line_i,
  input  line_addr_t   attr_line_i,
  input  idx_t         count_i,                  // triangles, not 0
  input  logic         halt_i,                   // ask for nothing more
  output logic         req_valid_o,
  input  logic         req_ready_i,
  output line_addr_t   req_addr_o,
  input  logic         rsp_valid_i,
  input  block64_t     rsp_block_i,
  output logic         rec_valid_o,
  input  logic         rec_ready_i,
  output logic [216:0] rec_o,
  output logic         attr_valid_o,
  input  logic         attr_ready_i,
  output attr_t        attr_o,
  output logic         last_o                    // with attr_ready_i: all triangles are through
);
  localparam int unsigned CreditW = $clog2(Depth + 1);
  // Requests: vertices, then attributes of the same two triangles; a pair needs a credit.
  logic       attr_next_q, take, free, room;
  idx_t       lines_q;                           // of each kind still to ask for
  line_addr_t vertex_q, attr_q;
  logic [CreditW-1:0] credit_q;
  assign room        = credit_q != '0;
  assign req_valid_o = lines_q != '0 && (attr_next_q || (room && !halt_i));
  assign req_addr_o  = attr_next_q ? attr_q : vertex_q;
  assign take        = req_valid_o && req_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {attr_next_q, lines_q} <= '0;
      credit_q <= CreditW'(Depth);
    end else begin
      credit_q <= credit_q - CreditW'(take && !attr_next_q) + CreditW'(free);
      if (start_i) lines_q <= count_i[IDX_W-1:1] + idx_t'(count_i[0]);
      else if (take && attr_next_q) lines_q <= lines_q - 1'b1;
      if (take) attr_next_q <= !attr_next_q;
    end
    if (start_i) {vertex_q, attr_q} <= {vertex_line_i, attr_line_i};
    else if (take && attr_next_q) attr_q <= attr_q + 1'b1;
    else if (take) vertex_q <= vertex_q + 1'b1;
  end

  // Answers, in the same order, to their queue.
  logic [1:0] in_valid, in_ready, out_valid, out_ready;
  logic       attr_came_q;
  block64_t [1:0] line;
  logic [1:0][CreditW-1:0] unused_count;
  assign in_valid = {rsp_valid_i && attr_came_q, rsp_valid_i && !attr_came_q};
  for (genvar i = 0; i < 2; i++) begin : gen_queue
    rc_fifo #(.data_t(block64_t), .Depth(Depth), .Ram(1'b0)) u_queue (
      .clk_i, .rst_ni, .in_valid_i(in_valid[i]), .in_ready_o(in_ready[i]), .in_data_i(rsp_block_i),
      .out_valid_o(out_valid[i]), .out_ready_i(out_ready[i]), .out_data_o(line[i]), .count_o(unused_count[i])
    );
  end

  // Records: the lower half of a line, then the upper one unless it is padding.
  idx_t rec_left_q, attr_left_q;
  logic rec_upper_q, attr_upper_q, rec_take, attr_take;
  logic [255:0] rec, attr;
  assign rec          = line[0][{rec_upper_q, 2'b0} +: 4];
  assign attr         = line[1][{attr_upper_q, 2'b0} +: 4];
  assign rec_o        = rec[216:0];
  assign attr_o       = attr[ATTR_W-1:0];
  assign rec_valid_o  = out_valid[0];
  assign attr_valid_o = out_valid[1];
  assign rec_take     = rec_valid_o && rec_ready_i;
  assign attr_take    = attr_valid_o && attr_ready_i;
  assign last_o       = attr_left_q == idx_t'(1);
  assign out_ready    = {attr_take && (attr_upper_q || last_o), rec_take && (rec_upper_q || rec_left_q == idx_t'(1))};
  assign free         = out_ready[1];
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {rec_upper_q, attr_upper_q, attr_came_q} <= '0;
    end else begin
      if (rsp_valid_i) attr_came_q <= !attr_came_q;
      if (rec_take) rec_upper_q <= !rec_upper_q && !out_ready[0];
      if (attr_take) attr_upper_q <= !attr_upper_q && !out_ready[1];
    end
    if (start_i) {rec_left_q, attr_left_q} <= {count_i, count_i};
    else begin
      if (rec_take) rec_left_q <= rec_left_q - 1'b1;
      if (attr_take) attr_left_q <= attr_left_q - 1'b1;
    end
  end
  logic unused_rec;
  assign unused_rec = ^{rec[255:217], attr[255:ATTR_W]};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && rsp_valid_i) Room_A: assert (in_ready[attr_came_q]);
    if (rst_ni && start_i) NotEmpty_M: assume (count_i != '0 && lines_q == '0);
  end
`else
  logic unused_ready;
  assign unused_ready = ^in_ready;
`endif
endmodule
