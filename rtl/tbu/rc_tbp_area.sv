// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// What the evaluators of two children must know: extents across each axis, half-surfaces, and the cost that a split must
// stay below. All is there 10 cycles after start_i; an evaluator needs rim and cap when its first candidate comes,
// the half-surface a cycle later, the limit 6 cycles later. Inputs hold from start_i until the next one.
// 3 multipliers, 16 adders.
module rc_tbp_area import rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  logic            clk_i,
  input  logic            rst_ni,
  input  logic            start_i,
  input  box_t [1:0]      box_i,
  input  num_t [1:0]      num_i,           // references
  output logic            valid_o,         // all is there
  output eval_cfg_t [1:0] cfg_o
);
  typedef logic [49:0] prod_t;             // n Hn
  logic [3:0]                step_q;
  coord_t [1:0][2:0]         ext_q;
  coord_t [1:0]              a, b;         // factors of a face, extents across the axis whose turn it is
  face_t  [1:0]              face1_q, face2_q;
  prod_t                     limit1_q, limit2_q;
  logic   [1:0]              turn, turn_end;

  assign turn     = step_q[1:0] - 2'd1;    // steps 1 to 3
  assign turn_end = step_q[1:0] - 2'd3;    // steps 3 to 5
  assign valid_o  = step_q >= 4'd10 && !start_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) step_q <= '0;
    else if (start_i) step_q <= 4'd1;
    else if (step_q != '0 && step_q != '1) step_q <= step_q + 4'd1;
  end

  for (genvar c = 0; c < 2; c++) begin : gen_child
    assign a[c] = (turn == 2'd0) ? ext_q[c][1] : ext_q[c][0];
    assign b[c] = (turn == 2'd2) ? ext_q[c][1] : ext_q[c][2];
    always_ff @(posedge clk_i) begin
      face1_q[c] <= face_t'(a[c]) * face_t'(b[c]);
      face2_q[c] <= face1_q[c];
      for (int i = 0; i < 3; i++) begin
        ext_q[c][i]          <= box_i[c].hi[i] - box_i[c].lo[i];
        cfg_o[c].axis[i].rim <= rim_t'(ext_q[c][(i+1)%3]) + rim_t'(ext_q[c][(i+2)%3]);
        if (step_q >= 4'd3 && step_q <= 4'd5 && turn_end == 2'(i)) cfg_o[c].axis[i].cap <= face2_q[c];
      end
      if (step_q == 4'd3) cfg_o[c].half <= half_t'(face2_q[c]);
      if (step_q == 4'd4 || step_q == 4'd5) cfg_o[c].half <= cfg_o[c].half + half_t'(face2_q[c]);
      if (step_q == 4'd8 + 4'(c)) cfg_o[c].limit <= {limit2_q, 4'b0000} + cost_t'({limit2_q, 3'b000});
    end
  end
  logic second;
  assign second = step_q != 4'd6;
  always_ff @(posedge clk_i) begin
    limit1_q <= prod_t'(cfg_o[second].half) * prod_t'(num_i[second]);
    limit2_q <= limit1_q;
  end
endmodule
