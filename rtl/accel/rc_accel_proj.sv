// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Second stage of the record unit: the six quotients by component k of the cross product, the length of the normal, of the
// longest projected edge and of the distance from the eye; all at once, a bit a cycle, 33 cycles a triangle.
module rc_accel_proj import rc_pkg::*; import rc_accel_pkg::*; (
  input  logic   clk_i,
  input  logic   rst_ni,
  input  slack_t slack_i,                        // least factor of the edge slack
  input  logic   in_valid_i,
  output logic   in_ready_o,
  input  cross_t in_i,
  output logic   out_valid_o,
  input  logic   out_ready_i,
  output proj_t  out_o
);
  typedef logic [5:0] step_t;                    // 0 waits; 1 to NORM_W work; then done
  localparam step_t LAST = step_t'(NORM_W + 1);
  step_t step_q;
  logic  load, div_step, edge_step, norm_step;
  assign in_ready_o  = step_q == '0;
  assign out_valid_o = step_q == LAST;
  assign load        = in_valid_i && in_ready_o;
  assign norm_step   = step_q != '0 && step_q != LAST;
  assign edge_step   = norm_step && step_q <= step_t'(EDGE_W);
  assign div_step    = norm_step && step_q <= step_t'(QUOT_W);
  always_ff @(posedge clk_i) begin
    if (!rst_ni) step_q <= '0;
    else if (load || norm_step) step_q <= step_q + 1'b1;
    else if (out_valid_o && out_ready_i) step_q <= '0;
  end

  typedef struct packed {
    logic        opaque;
    logic        dead;
    logic [1:0]  k;
    vec3_t       a;
    norm_t       det;
    norm_t [1:0] side;
    logic [4:0]  half;
  } held_t;
  held_t c_q;
  always_ff @(posedge clk_i) begin
    if (load) c_q <= '{opaque: in_i.opaque, dead: in_i.dead, k: in_i.k, a: in_i.a, det: in_i.det, side: in_i.side,
                       half: in_i.half};
  end

  // ---- quotients -----------------------------------------------------------------------------------------
  // n_u, n_v, b_u, b_v, g_u, g_v: exponents and signs, to be put together at the end.
  norm_t [5:0] num;
  logic  [5:0][QUOT_W-1:0] q;
  logic  [5:0] rest, neg_q, zero_q;
  logic  [5:0][FP_EXP_W-1:0] exp_q;
  fp_t   [5:0] y;
  localparam exp_t BIAS = 9'sd63;
  assign num[1:0] = in_i.side;
  for (genvar i = 0; i < 4; i++) begin : gen_edge
    assign num[2+i] = '{neg: in_i.edge_neg[i], shift: shift_t'(in_i.edge_shift[i]), val: {in_i.edge_val[i], 19'b0}};
  end
  for (genvar i = 0; i < 6; i++) begin : gen_lane
    // An edge is worth 2^17 more than the cross product, and lies 19 bits further up.
    localparam exp_t SCALE = (i < 2) ? BIAS : BIAS + exp_t'(GRID) - exp_t'(CROSS_W - EDGE_W + 1);
    rc_accel_lane u_lane (
      .clk_i, .load_i(load), .step_i(div_step), .a_i(num[i].val), .b_i(c_q.det.val), .q_o(q[i]), .rest_o(rest[i])
    );
    always_ff @(posedge clk_i) begin
      if (load) begin
        neg_q[i]  <= num[i].neg != in_i.det.neg;
        zero_q[i] <= num[i].val == '0;
        exp_q[i]  <= FP_EXP_W'(SCALE + exp_t'({1'b0, in_i.det.shift}) - exp_t'({1'b0, num[i].shift}));
      end
    end
    assign y[i] = round_quotient(neg_q[i], zero_q[i], q[i], rest[i], exp_q[i]);
  end

  // ---- roots -----------------------------------------------------------------------------------------------
  logic [EDGE_W-1:0]  edge_len, eye_len;
  logic [NORM_W-1:0]  length;
  logic               edge_rest, unused_dist_rest, unused_rest;
  logic signed [EDGE_W:0] factor;                // (distance - 1) / 2, in 2^-7: two bits fewer
  rc_accel_root #(.Width(NORM_W)) u_length (
    .clk_i, .load_i(load), .step_i(norm_step), .square_i(in_i.square), .root_o(length), .rest_o(unused_rest)
  );
  rc_accel_root #(.Width(EDGE_W)) u_edge (
    .clk_i, .load_i(load), .step_i(edge_step), .square_i(in_i.longest), .root_o(edge_len), .rest_o(edge_rest)
  );
  rc_accel_root #(.Width(EDGE_W)) u_dist (
    .clk_i, .load_i(load), .step_i(edge_step), .square_i({4'b0, in_i.eye_dist}),
    .root_o(eye_len), .rest_o(unused_dist_rest)
  );
  assign factor = ($signed({1'b0, eye_len}) - (EDGE_W + 1)'(1 << EYE_FRAC)) >>> (EYE_FRAC + 1 - SLACK_FRAC);
  always_comb begin
    out_o = '{
      opaque: c_q.opaque, dead: c_q.dead, k: c_q.k, a: c_q.a, det: c_q.det, side: c_q.side,
      n: y[1:0], b: y[3:2], g: y[5:4], half: c_q.half, slack: slack_t'(factor),
      longest: {1'b0, edge_len} + (EDGE_W + 1)'(edge_rest), length: length
    };
    if (factor < $signed((EDGE_W + 1)'(slack_i))) out_o.slack = slack_i;
    else if (factor > $signed((EDGE_W + 1)'(SLACK_MAX))) out_o.slack = SLACK_MAX;
  end
endmodule
