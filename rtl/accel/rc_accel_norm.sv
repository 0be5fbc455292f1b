// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Last stage of the record unit: unit normal and edge slack by division, differences of the corners' normals, and the three
// rows of 32 bytes of a triangle: its TriAccel record, then the halves of its triangle information.
//   step 1-6    differences, one a cycle        1-19    normal / length
//   step 1, 2   slack x longest edge, normalised        3-21    by component k
//   then        rows, one after the other; 26 cycles a triangle if they are taken at once
module rc_accel_norm import rc_pkg::*; import rc_accel_pkg::*; (
  input  logic  clk_i,
  input  logic  rst_ni,
  input  logic  in_valid_i,
  output logic  in_ready_o,
  input  proj_t in_i,
  input  logic  attr_valid_i,
  output logic  attr_ready_o,                    // with the last row
  input  attr_t attr_i,
  output logic  row_valid_o,
  input  logic  row_ready_i,
  output logic [1:0]       row_idx_o,            // 0 TriAccel, 1 and 2 information
  output logic [7:0][31:0] row_o
);
  typedef logic [4:0] step_t;                    // 0 waits
  localparam step_t LAST = step_t'(QUOT_W + 3);
  localparam logic [FP_EXP_W-1:0] BIAS = 7'd63;
  step_t      step_q;
  logic [1:0] row_q;
  logic       load, norm_step, eps_step, row_done;
  proj_t      p_q;
  assign load        = step_q == '0 && in_valid_i && attr_valid_i;
  assign in_ready_o  = load;
  assign norm_step   = step_q != '0 && step_q <= step_t'(QUOT_W);
  assign eps_step    = step_q > 5'd2 && step_q <= step_t'(QUOT_W + 2);
  assign row_valid_o = step_q == LAST;
  assign row_idx_o   = row_q;
  assign row_done    = row_valid_o && row_ready_i;
  assign attr_ready_o = row_done && row_q == 2'd2;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {step_q, row_q} <= '0;
    end else begin
      if (load || (step_q != '0 && step_q != LAST)) step_q <= step_q + 1'b1;
      else if (attr_ready_o) step_q <= '0;
      if (row_done) row_q <= row_q == 2'd2 ? '0 : row_q + 1'b1;
    end
    if (load) p_q <= in_i;
  end

  // ---- normal ------------------------------------------------------------------------------------------------
  // Components k, u, v. The length has 30 or 31 bits, of the cross product shifted as far as component k.
  norm_t [2:0] num;
  logic  [2:0][QUOT_W-1:0] q;
  logic  [2:0] rest;
  fp_t   [2:0] kuv;
  vec3_t       normal;
  wide_t       divisor;
  logic        long_n;                           // the length has 31 bits
  assign num     = {in_i.side, in_i.det};
  assign long_n  = p_q.length[NORM_W-1];
  assign divisor = long_n ? {p_q.length, 6'b0} : {p_q.length[NORM_W-2:0], 7'b0};
  for (genvar i = 0; i < 3; i++) begin : gen_lane
    norm_t own;
    assign own = (i == 0) ? p_q.det : p_q.side[(i > 0) ? i - 1 : 0];
    rc_accel_lane u_lane (
      .clk_i, .load_i(load), .step_i(norm_step), .a_i(num[i].val), .b_i(divisor), .q_o(q[i]), .rest_o(rest[i])
    );
    logic [FP_EXP_W-1:0] e;
    assign e      = BIAS - FP_EXP_W'(long_n) + FP_EXP_W'(p_q.det.shift) - FP_EXP_W'(own.shift);
    assign kuv[i] = round_quotient(own.neg, own.val == '0, q[i], rest[i], e);
  end
  always_comb begin
    case (p_q.k)
      2'd0:    normal = kuv;
      2'd1:    normal = {kuv[1], kuv[0], kuv[2]};
      default: normal = {kuv[0], kuv[2], kuv[1]};
    endcase
  end

  // ---- edge slack --------------------------------------------------------------------------------------------
  localparam int unsigned PROD_W = SLACK_W + EDGE_W + 1;
  logic [PROD_W-1:0] prod_q;
  wide_t       eps_num;
  shift_t      eps_shift_d, eps_shift_q;
  logic [QUOT_W-1:0] eps_q;
  logic        eps_rest, eps_up;
  logic [4:0]  eps_sum;                          // 16 to 32, without the leading one of numbers below 32
  exp_t        eps_exp;
  logic [8:0]  eps_code;
  always_comb begin
    eps_shift_d = '0;
    for (int i = 0; i < int'(PROD_W); i++) if (prod_q[i]) eps_shift_d = shift_t'(int'(CROSS_W) - 1 - i);
    eps_num = wide_t'(prod_q) << eps_shift_d;
  end
  always_ff @(posedge clk_i) begin
    prod_q <= PROD_W'(p_q.slack) * PROD_W'(p_q.longest);
    eps_shift_q <= eps_shift_d;
  end
  rc_accel_lane u_eps (
    .clk_i, .load_i(step_q == 5'd2), .step_i(eps_step), .a_i(eps_num), .b_i(p_q.det.val),
    .q_o(eps_q), .rest_o(eps_rest)
  );
  always_comb begin
    eps_up  = eps_rest || eps_q[12:0] != '0 || (eps_q[QUOT_W-1] && eps_q[13]);
    eps_sum = {1'b0, eps_q[QUOT_W-1] ? eps_q[17:14] : eps_q[16:13]} + 5'(eps_up);
    eps_exp = exp_t'({1'b0, p_q.det.shift}) - exp_t'({1'b0, eps_shift_q}) - exp_t'({1'b0, p_q.half})
            - exp_t'(SLACK_FRAC) - exp_t'(!eps_q[QUOT_W-1]) + exp_t'(eps_sum[4]) + 9'sd8;
    eps_code = eps_exp > 9'sd0 ? 9'd15 : {5'(-eps_exp), eps_sum[3:0]};
  end

  // ---- differences of normals ----------------------------------------------------------------------------------
  fp_t [1:0][2:0] diff_q;                        // n1 - n0, n2 - n0
  fp_t       sub_a, sub_b, sub_y;
  logic [2:0] sub_idx;
  logic [2:0] got_idx;
  step_t      got;
  assign sub_idx = 3'(step_q - 5'd1);
  assign got     = step_q - step_t'(1 + LAT_ADD);
  assign got_idx = got[2:0];
  always_comb begin
    sub_a = attr_i.n[1][0];
    sub_b = attr_i.n[0][0];
    if (sub_idx < 3'd3) begin
      sub_a = attr_i.n[1][sub_idx[1:0]];
      sub_b = attr_i.n[0][sub_idx[1:0]];
    end else if (sub_idx < 3'd6) begin
      sub_a = attr_i.n[2][2'(sub_idx - 3'd3)];
      sub_b = attr_i.n[0][2'(sub_idx - 3'd3)];
    end
  end
  rc_fp_add #(.Latency(LAT_ADD)) u_sub (.clk_i, .a_i(sub_a), .b_i(fp_neg(sub_b)), .y_o(sub_y));
  always_ff @(posedge clk_i) begin
    if (got < 5'd3) diff_q[0][got_idx[1:0]] <= sub_y;
    else if (got < 5'd6) diff_q[1][2'(got_idx - 3'd3)] <= sub_y;
  end

  // ---- rows ----------------------------------------------------------------------------------------------------
  triaccel_t  accel;
  tri_info_t  info;
  vec3_t      n0;
  fp_t [1:0][2:0] e;
  fp_t        a_u, a_v, a_k;
  always_comb begin
    case (p_q.k)
      2'd0:    {a_v, a_u, a_k} = p_q.a;
      2'd1:    {a_v, a_u, a_k} = {p_q.a[0], p_q.a[2], p_q.a[1]};
      default: {a_v, a_u, a_k} = {p_q.a[1], p_q.a[0], p_q.a[2]};
    endcase
    accel = '{
      n_u: p_q.n[0], n_v: p_q.n[1], eps_m: eps_code[3:0], eps_e: eps_code[8:4], k: p_q.k, opaque: p_q.opaque,
      a_u: a_u, a_v: a_v, mat: attr_i.mat, a_k: a_k, b_u: p_q.b[0], b_v_lo: p_q.b[1][11:0],
      g_u: p_q.g[0], g_v: p_q.g[1], b_v_hi: p_q.b[1][23:12]
    };
    if (p_q.dead) begin
      {accel.n_u, accel.n_v, accel.b_u, accel.b_v_lo, accel.b_v_hi, accel.g_u, accel.g_v} = '0;
      {accel.k, accel.eps_e, accel.eps_m} = {2'd3, 5'd31, 4'd0};
    end
    n0 = attr_i.flat ? normal : attr_i.n[0];
    e  = attr_i.flat ? '0 : diff_q;
    info = '{
      mat: attr_i.mat, a_x: p_q.a[0], a_y: p_q.a[1], a_z: p_q.a[2], n_x: normal[0], n_y: normal[1], n_z: normal[2],
      n0_x: n0[0], n0_y: n0[1], n0_z: n0[2], e1_x: e[0][0], e1_y: e[0][1], e1_z: e[0][2],
      e2_x: e[1][0], e2_y: e[1][1], e2_z: e[1][2], default: '0
    };
    case (row_q)
      2'd0:    row_o = words(accel);
      2'd1:    row_o = words(info[239:0]);
      default: row_o = words(info[479:240]);
    endcase
  end
  function automatic logic [7:0][31:0] words(half_line_t used);
    for (int w = 0; w < 4; w++) words[2*w +: 2] = {4'b0, used[w]};
  endfunction
endmodule
