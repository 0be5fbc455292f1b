// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Reads a list of references, four a line, or makes them from vertex records, two a line. Up to Depth lines are asked for or
// wait in the queue, so answers always find room. A reference a cycle from lists, one in three cycles from vertices.
// A bad reference (rc_tbu_box) is reported by bad_o when it is given away. Commands are taken one after the other.
module rc_tbu_fetch import rc_pkg::*; import rc_tbu_pkg::*; #(
  parameter int unsigned Depth = 16                  // lines
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       cmd_valid_i,
  output logic       cmd_ready_o,
  input  logic       cmd_vertices_i,
  input  line_addr_t cmd_line_i,
  input  tri_first_t cmd_tri_i,                      // number of the first vertex record's triangle
  input  count_t     cmd_count_i,                    // references, not 0
  output logic       req_valid_o,
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,
  input  block64_t   rsp_block_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output tri_ref_t   out_ref_o,
  output logic       bad_o                           // for one cycle
);
  localparam int unsigned CREDIT_W = $clog2(Depth + 1);
  logic                vertices_q, busy_q;
  count_t              left_q;                       // references not yet read from the queue
  count_t              made_q;                       // triangle of the next vertex record
  logic [COUNT_W-2:0]  lines_q;                      // lines still to ask for
  logic [CREDIT_W-1:0] credit_q, unused_count;
  logic                line_valid, line_done, queue_ready;
  block64_t            line;
  logic [1:0]          part_q;
  logic                part_valid, part_take, last_part;
  tri_ref_t            list_ref;

  assign cmd_ready_o = !busy_q;
  assign req_valid_o = lines_q != '0 && credit_q != '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {busy_q, lines_q, part_q} <= '0;
      credit_q <= CREDIT_W'(Depth);
    end else begin
      credit_q <= credit_q - CREDIT_W'(req_valid_o && req_ready_i) + CREDIT_W'(line_done);
      if (cmd_valid_i && cmd_ready_o) begin
        busy_q  <= 1'b1;
        lines_q <= cmd_vertices_i ? (COUNT_W - 1)'((cmd_count_i + 1'b1) >> 1)
                                  : (COUNT_W - 1)'(cmd_count_i >> 2) + (COUNT_W - 1)'(cmd_count_i[1:0] != '0);
        part_q  <= '0;
      end else begin
        if (req_valid_o && req_ready_i) lines_q <= lines_q - 1'b1;
        if (part_take) part_q <= line_done ? '0 : part_q + 1'b1;
        if (part_take && left_q == count_t'(1)) busy_q <= 1'b0;
      end
    end
    if (cmd_valid_i && cmd_ready_o) begin
      vertices_q <= cmd_vertices_i;
      left_q     <= cmd_count_i;
      made_q     <= count_t'(cmd_tri_i);
      req_addr_o <= cmd_line_i;
    end else begin
      if (req_valid_o && req_ready_i) req_addr_o <= req_addr_o + 1'b1;
      if (part_take) {left_q, made_q} <= {left_q - 1'b1, made_q + 1'b1};
    end
  end
  rc_fifo #(.data_t(block64_t), .Depth(Depth), .Ram(1'b1)) u_lines (
    .clk_i, .rst_ni,
    .in_valid_i(rsp_valid_i), .in_ready_o(queue_ready), .in_data_i(rsp_block_i),
    .out_valid_o(line_valid), .out_ready_i(line_done), .out_data_o(line), .count_o(unused_count)
  );

  // ---- take lines apart ----------------------------------------------------------------------------------
  logic     box_ready, box_valid, box_out_ready, box_bad, list_ready;
  tri_ref_t box_ref;
  assign list_ref   = line[{part_q, 1'b0} +: 2];
  assign last_part  = left_q == count_t'(1) || (vertices_q ? part_q[0] : part_q == 2'd3);
  assign part_valid = line_valid && busy_q;
  assign list_ready = out_ready_i && !box_valid;     // a box of the command before comes first
  assign part_take  = part_valid && (vertices_q ? box_ready : list_ready);
  assign line_done  = part_take && last_part;
  rc_tbu_box u_box (
    .clk_i, .rst_ni,
    .in_valid_i(part_valid && vertices_q), .in_ready_o(box_ready),
    .in_rec_i(line[{part_q[0], 2'b0} +: 4]), .in_idx_i(made_q[TRI_W-1:0]),
    .out_valid_o(box_valid), .out_ready_i(box_out_ready), .out_ref_o(box_ref), .out_bad_o(box_bad)
  );
  assign box_out_ready = out_ready_i;
  assign out_valid_o   = box_valid || (part_valid && !vertices_q);
  assign out_ref_o     = box_valid ? box_ref : list_ref;
  assign bad_o         = box_valid && box_out_ready && box_bad;
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && rsp_valid_i) Room_A: assert (queue_ready);
    if (rst_ni && cmd_valid_i) NotEmpty_M: assume (cmd_count_i != '0);
  end
`else
  logic unused_ready;
  assign unused_ready = queue_ready;
`endif
endmodule
