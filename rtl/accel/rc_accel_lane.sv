// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Divider, a bit a cycle: a / b for operands whose top bits are set. After QUOT_W steps q_o is the quotient with
// QUOT_W - 1 fraction bits, rounded down, and rest_o says whether something is left.
module rc_accel_lane import rc_accel_pkg::*; (
  input  logic              clk_i,
  input  logic              load_i,
  input  logic              step_i,
  input  wide_t             a_i,           // with load_i
  input  wide_t             b_i,           // with step_i, constant
  output logic [QUOT_W-1:0] q_o,
  output logic              rest_o
);
  logic [CROSS_W:0] rest_q, less;
  logic             fits;
  assign fits   = rest_q >= {1'b0, b_i};
  assign less   = rest_q - {1'b0, b_i};
  assign rest_o = rest_q != '0;
  always_ff @(posedge clk_i) begin
    if (load_i) rest_q <= {1'b0, a_i};
    else if (step_i) begin
      rest_q <= (fits ? less : rest_q) << 1;
      q_o    <= {q_o[QUOT_W-2:0], fits};
    end
  end
endmodule
