// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Squares x up to five times, left_i times at most: a part of x^(2^n) with one multiplier. A job loads the loop in one
// beat of five and goes round it five times.
// One turn takes SHINE_TURN cycles, never a multiple of five: so the turns of a job fall on different beats, those of different
// jobs never meet, and the job stands at the output when a later one loads, SHINE_LATENCY cycles after it loaded.
module rc_shine import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic       clk_i,
  input  logic       load_i,           // the beat of x_i, and of x_o
  input  fp_t        x_i,
  input  logic [3:0] left_i,           // squarings to do
  output fp_t        x_o,
  output logic [3:0] left_o            // squarings that remain
);
  if (LIGHT_BEATS != 5 || SHINE_TURN % LIGHT_BEATS == 0) begin : gen_check
    $error("rc_shine: jobs would meet in the loop");
  end
  fp_t        in, product, square, same;
  logic [3:0] left_in, left;
  assign {in, left_in} = load_i ? {x_i, left_i} : {x_o, left_o};
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul (.clk_i, .a_i(in), .b_i(in), .y_o(product));
  rc_carry #(.Width(FP_W), .From(LAT_MUL), .To(SHINE_TURN)) u_square (.clk_i, .in_i(product), .out_o(square));
  rc_carry #(.Width(FP_W + 4), .From(0), .To(SHINE_TURN)) u_same (.clk_i, .in_i({in, left_in}), .out_o({same, left}));
  assign x_o    = (left == '0) ? same : square;
  assign left_o = (left == '0) ? '0 : left - 1'b1;
endmodule
