// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Delays a word by Depth cycles, 0 for a wire. For payload: it has no reset, so valid bits do not
// belong here.
module rc_delay #(
  parameter int unsigned Width = 1,    // bits
  parameter int unsigned Depth = 1     // cycles
) (
  input  logic             clk_i,
  input  logic [Width-1:0] in_i,
  output logic [Width-1:0] out_o
);
  if (Depth == 0) begin : gen_wire
    logic unused_clk;
    assign unused_clk = clk_i;
    assign out_o = in_i;
  end else begin : gen_shift
    logic [Depth-1:0][Width-1:0] stage_q;
    always_ff @(posedge clk_i) begin
      stage_q[0] <= in_i;
      for (int i = 1; i < Depth; i++) stage_q[i] <= stage_q[i-1];
    end
    assign out_o = stage_q[Depth-1];
  end
endmodule
