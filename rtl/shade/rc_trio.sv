// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Three component-serial vector operations a, b, c and a scalar one s on two functional units, in five beats:
//   beat_i     0     1     2     3     4
//   unit 0    a.x   a.y   a.z   c.x   c.y
//   unit 1    c.z   b.x   b.y   b.z    s
// So b starts in beat 1 after a, c in beat 3, s in beat 4. Results follow after the unit's latency.
module rc_trio import rc_pkg::*; #(
  parameter bit Add = 1'b0             // adders, not multipliers
) (
  input  logic       clk_i,
  input  logic [4:0] beat_i,           // [0]: the beat of a's x component
  input  fp_t  [1:0] a_i,
  input  fp_t  [1:0] b_i,
  input  fp_t  [1:0] c_i,
  input  fp_t  [1:0] s_i,
  output fp_t        a_o,
  output fp_t        b_o,
  output fp_t        c_o,
  output fp_t        s_o
);
  localparam int unsigned LATENCY = Add ? LAT_ADD : LAT_MUL;
  fp_t [1:0] in0, in1;
  fp_t       y0, y1;
  always_comb begin
    in0 = (beat_i[3] || beat_i[4]) ? c_i : a_i;
    in1 = b_i;
    if (beat_i[0]) in1 = c_i;
    if (beat_i[4]) in1 = s_i;
  end
  if (Add) begin : gen_add
    rc_fp_add #(.Latency(LAT_ADD)) u_unit0 (.clk_i, .a_i(in0[0]), .b_i(in0[1]), .y_o(y0));
    rc_fp_add #(.Latency(LAT_ADD)) u_unit1 (.clk_i, .a_i(in1[0]), .b_i(in1[1]), .y_o(y1));
  end else begin : gen_mul
    rc_fp_mul #(.Latency(LAT_MUL)) u_unit0 (.clk_i, .a_i(in0[0]), .b_i(in0[1]), .y_o(y0));
    rc_fp_mul #(.Latency(LAT_MUL)) u_unit1 (.clk_i, .a_i(in1[0]), .b_i(in1[1]), .y_o(y1));
  end
  assign a_o = y0;
  assign b_o = y1;
  assign c_o = beat_i[LATENCY % 5] ? y1 : y0;
  assign s_o = y1;
endmodule
