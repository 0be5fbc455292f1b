// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// All building blocks of rtl/prim/ in the sizes that differ, for one test build.
module rc_prim_all #(
  parameter int unsigned NumQueues = 7,
  parameter int unsigned NumReq    = 5,
  parameter int unsigned NumIdx    = 20
) (
  input  logic                         clk_i,
  input  logic                         rst_ni,
  // queues 0: skid; 1 to 4: flip-flops, 1, 2, 5, 16 words; 5, 6: RAM, 5 and 33 words
  input  logic [NumQueues-1:0]         in_valid_i,
  output logic [NumQueues-1:0]         in_ready_o,
  input  logic [NumQueues-1:0][31:0]   in_data_i,
  output logic [NumQueues-1:0]         out_valid_o,
  input  logic [NumQueues-1:0]         out_ready_i,
  output logic [NumQueues-1:0][31:0]   out_data_o,
  output logic [NumQueues-1:0][7:0]    count_o,
  input  logic [NumReq-1:0]            req_i,
  input  logic                         req_ready_i,
  output logic [NumReq-1:0]            gnt_o,
  output logic [2:0]                   gnt_idx_o,
  output logic                         idx_valid_o,
  input  logic                         idx_ready_i,
  output logic [4:0]                   idx_o,
  input  logic                         free_valid_i,
  input  logic [4:0]                   free_idx_i,
  output logic [4:0]                   free_count_o,
  input  logic [7:0]                   delay_i,
  output logic [2:0][7:0]              delay_o        // by 0, 1, 7 cycles
);
  assign count_o[0] = '0;
  rc_skid u_skid (
    .clk_i, .rst_ni, .in_valid_i(in_valid_i[0]), .in_ready_o(in_ready_o[0]), .in_data_i(in_data_i[0]),
    .out_valid_o(out_valid_o[0]), .out_ready_i(out_ready_i[0]), .out_data_o(out_data_o[0])
  );
  localparam int unsigned DEPTH[7] = '{0, 1, 2, 5, 16, 5, 33};
  for (genvar q = 1; q < NumQueues; q++) begin : gen_queue
    logic [$clog2(DEPTH[q]+1)-1:0] count;
    assign count_o[q] = 8'(count);
    rc_fifo #(.Depth(DEPTH[q]), .Ram(q > 4)) u_fifo (
      .clk_i, .rst_ni, .in_valid_i(in_valid_i[q]), .in_ready_o(in_ready_o[q]), .in_data_i(in_data_i[q]),
      .out_valid_o(out_valid_o[q]), .out_ready_i(out_ready_i[q]), .out_data_o(out_data_o[q]), .count_o(count)
    );
  end
  rc_rr_arb #(.NumReq(NumReq)) u_arb (
    .clk_i, .rst_ni, .req_i, .ready_i(req_ready_i), .gnt_o, .idx_o(gnt_idx_o)
  );
  rc_idx_pool #(.NumIdx(NumIdx)) u_pool (
    .clk_i, .rst_ni, .out_valid_o(idx_valid_o), .out_ready_i(idx_ready_i), .out_idx_o(idx_o),
    .free_valid_i, .free_idx_i, .count_o(free_count_o)
  );
  rc_delay #(.Width(8), .Depth(0)) u_delay0 (.clk_i, .in_i(delay_i), .out_o(delay_o[0]));
  rc_delay #(.Width(8), .Depth(1)) u_delay1 (.clk_i, .in_i(delay_i), .out_o(delay_o[1]));
  rc_delay #(.Width(8), .Depth(7)) u_delay7 (.clk_i, .in_i(delay_i), .out_o(delay_o[2]));
endmodule
