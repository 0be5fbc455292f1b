// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Delay by a number of clock cycles that may be zero: the registers between the phases of an FP unit.
module rc_fp_pipe #(
  parameter int unsigned Width  = 24,   // bits
  parameter int unsigned Stages = 1     // cycles, 0 is a wire
) (
  input  logic             clk_i,
  input  logic [Width-1:0] d_i,
  output logic [Width-1:0] q_o
);
  if (Stages == 0) begin : gen_wire
    logic unused_clk;
    assign unused_clk = clk_i;
    assign q_o = d_i;
  end else if (Stages == 1) begin : gen_reg
    always_ff @(posedge clk_i) q_o <= d_i;
  end else begin : gen_regs
    logic [Stages-1:0][Width-1:0] q;
    always_ff @(posedge clk_i) q <= {q[Stages-2:0], d_i};
    assign q_o = q[Stages-1];
  end
endmodule
