// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Keeps a scalar of a rigid pipeline that is there in one cycle only, at time From of its job, for the times To to
// To + Span - 1. One register a job, not one a cycle as in rc_carry: register k holds it for the Beats cycles from
// From + 1 + k Beats on.
module rc_hold #(
  parameter int unsigned Width = 24,   // bits
  parameter int unsigned Beats = 4,    // cycles a job
  parameter int unsigned From  = 0,    // cycles
  parameter int unsigned To    = 1,    // cycles, after From
  parameter int unsigned Span  = 1     // cycles: 3 if all components of a vector use the value
) (
  input  logic             clk_i,
  input  logic             now_i,      // it is the beat of time From
  input  logic [Width-1:0] in_i,
  output logic [Width-1:0] out_o
);
  localparam int unsigned Regs = (To - From + Beats - 1) / Beats;
  if (To <= From || To + Span - 1 > From + Regs * Beats) begin : gen_check
    $error("rc_hold: a value is not there while it is used");
  end
  logic [Regs-1:0][Width-1:0] value_q;
  always_ff @(posedge clk_i) begin
    if (now_i) begin
      value_q[0] <= in_i;
      for (int i = 1; i < Regs; i++) value_q[i] <= value_q[i-1];
    end
  end
  assign out_o = value_q[Regs-1];
endmodule
