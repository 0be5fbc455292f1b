// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Counts enabled cycles; only there to test the build helper. Never counts past Limit.
module rc_counter #(
  parameter int unsigned Width = 8,
  parameter int unsigned Limit = 200
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             en_i,
  output logic [Width-1:0] count_o
);
  logic [Width-1:0] count_q;
  logic             inner_q;
  assign count_o = count_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) count_q <= '0;
    else if (en_i) count_q <= count_q + 1'b1;
    inner_q <= en_i;
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) Limit_A: assert (count_q <= Width'(Limit) && (inner_q || !inner_q));
  end
`endif
endmodule
