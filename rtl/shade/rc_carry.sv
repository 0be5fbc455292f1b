// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Carries a value of a rigid pipeline from time From of its job to time To: a delay that is written as two times, so that
// it follows every change of a latency. For vectors in three cycles, and for scalars that are close.
module rc_carry #(
  parameter int unsigned Width = 24,   // bits
  parameter int unsigned From  = 0,    // cycles
  parameter int unsigned To    = 0     // cycles, not before From
) (
  input  logic             clk_i,
  input  logic [Width-1:0] in_i,
  output logic [Width-1:0] out_o
);
  if (To < From) begin : gen_check
    $error("rc_carry: a value is used before it exists");
  end
  rc_delay #(.Width(Width), .Depth(To - From)) u_delay (.clk_i, .in_i, .out_o);
endmodule
