// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Free list of the indices 0 to NumIdx - 1, all of them free after reset. Indices that were never
// used come from a counter, so nothing has to be written at reset; freed ones wait in a queue.
module rc_idx_pool #(
  parameter  int unsigned NumIdx = 256,
  localparam int unsigned IdxW   = (NumIdx > 1) ? $clog2(NumIdx) : 1,
  localparam int unsigned CountW = $clog2(NumIdx + 1)
) (
  input  logic              clk_i,
  input  logic              rst_ni,
  output logic              out_valid_o,   // out_idx_o is free; taken when out_ready_i
  input  logic              out_ready_i,
  output logic [IdxW-1:0]   out_idx_o,
  input  logic              free_valid_i,  // give an index back; there is always room
  input  logic [IdxW-1:0]   free_idx_i,
  output logic [CountW-1:0] count_o        // free indices
);
  logic [CountW-1:0] fresh_q;              // next index never used; NumIdx: none left
  logic [CountW-1:0] freed;
  logic              fresh, freed_valid, freed_ready;
  logic [IdxW-1:0]   freed_idx;

  assign fresh       = fresh_q != CountW'(NumIdx);
  assign out_valid_o = fresh || freed_valid;
  assign out_idx_o   = fresh ? fresh_q[IdxW-1:0] : freed_idx;
  assign count_o     = CountW'(NumIdx) - fresh_q + freed;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) fresh_q <= '0;
    else if (fresh && out_ready_i) fresh_q <= fresh_q + 1'b1;
  end
  rc_fifo #(.data_t(logic [IdxW-1:0]), .Depth(NumIdx)) u_freed (
    .clk_i, .rst_ni,
    .in_valid_i(free_valid_i), .in_ready_o(freed_ready), .in_data_i(free_idx_i),
    .out_valid_o(freed_valid), .out_ready_i(out_ready_i && !fresh), .out_data_o(freed_idx),
    .count_o(freed)
  );
`ifndef SYNTHESIS
  logic [NumIdx-1:0] used_q;               // checks that an index has one owner
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      used_q <= '0;
    end else begin
      if (out_valid_o && out_ready_i) used_q[out_idx_o] <= 1'b1;
      if (free_valid_i) used_q[free_idx_i] <= 1'b0;
      if (free_valid_i) FreedOnce_M: assume (used_q[free_idx_i] && freed_ready);
      if (out_valid_o)  OneOwner_A:  assert (!used_q[out_idx_o]);
    end
  end
`endif
endmodule
