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
    // A register by itself for each stage: in a packed array Verilator would shift every bit of all
    // of them, at a third of the time of a whole simulation.
    for (genvar i = 0; i < Depth; i++) begin : gen_stage
      logic [Width-1:0] word_q;
      if (i == 0) begin : gen_first
        always_ff @(posedge clk_i) word_q <= in_i;
      end else begin : gen_next
        always_ff @(posedge clk_i) word_q <= gen_stage[i-1].word_q;
      end
    end
    assign out_o = gen_stage[Depth-1].word_q;
  end
endmodule
