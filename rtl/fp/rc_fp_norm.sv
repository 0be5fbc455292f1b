// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Normaliser: shifts left until the top bit is set and counts the places. Zero stays zero (its count means nothing).
// Counting and shifting are one: each step looks at the top 2^k bits and shifts by 2^k if they are all zero, which costs
// no more depth than the count alone. Combinational.
module rc_fp_norm #(
  parameter  int unsigned Width  = 20,              // bits, at least 2
  localparam int unsigned CountW = $clog2(Width)
) (
  input  logic [Width-1:0]  x_i,
  output logic [Width-1:0]  y_o,
  output logic [CountW-1:0] count_o
);
  // A variable shift by 0 or 2^k, not an `if`: the same multiplexer in hardware, and no mispredicted branch in simulation.
  always_comb begin
    y_o = x_i;
    for (int k = CountW - 1; k >= 0; k--) begin
      count_o[k] = (y_o >> (Width - (1 << k))) == '0;
      y_o = y_o << (CountW'(count_o[k]) << k);
    end
  end
endmodule
