// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Square root, a bit a cycle, rounded down: after Width steps root_o, and rest_o says whether something is left.
module rc_accel_root #(
  parameter int unsigned Width = 31        // bits of the root; the square has twice as many
) (
  input  logic               clk_i,
  input  logic               load_i,
  input  logic               step_i,       // Width times; not more
  input  logic [2*Width-1:0] square_i,     // with load_i
  output logic [Width-1:0]   root_o,
  output logic               rest_o
);
  logic [2*Width-1:0] square_q;
  logic [Width+1:0]   rest_q;
  logic [Width+2:0]   next, trial;         // the rest with two more bits of the square; what a one would take
  logic               fits;
  assign next   = {rest_q[Width:0], square_q[2*Width-1-:2]};
  assign trial  = {1'b0, root_o, 2'b01};
  assign fits   = next >= trial;
  assign rest_o = rest_q != '0;
  always_ff @(posedge clk_i) begin
    if (load_i) begin
      square_q <= square_i;
      rest_q   <= '0;
      root_o   <= '0;
    end else if (step_i) begin
      square_q <= square_q << 2;
      rest_q   <= fits ? (Width + 2)'(next - trial) : next[Width+1:0];
      root_o   <= {root_o[Width-2:0], fits};
    end
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) if (step_i && !load_i) Small_A: assert (!rest_q[Width+1]);
`endif
endmodule
