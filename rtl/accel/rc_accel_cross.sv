// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// First stage of the record unit: exact integers of a triangle, one multiplication and one normalisation a cycle.
//   step 0-2    a vertex each: to fixed point, edges, sum of vertices
//   3-8         products of the cross product          9-11    squares of the distance from the eye
//   12-17       squares of the projected edges         12-21   normalised: cross product, edges, the longest square
//   18-26       squares of the scaled cross product, in halves of 15 bits
//   29          done: out_valid_o until taken
// A product is used two cycles after its step. Every LAST + 1 cycles a triangle at best.
module rc_accel_cross import rc_pkg::*; import rc_accel_pkg::*; (
  input  logic         clk_i,
  input  logic         rst_ni,
  input  eye_t [2:0]   eye_i,
  input  logic         in_valid_i,             // holds until taken
  output logic         in_ready_o,
  input  logic [216:0] in_rec_i,               // vertex record
  output logic         out_valid_o,
  input  logic         out_ready_i,
  output cross_t       out_o,
  output logic         bad_o                   // with out_valid_o: a coordinate is off the grid
);
  typedef logic [4:0] step_t;
  localparam step_t STEP_CROSS = 5'd3, STEP_EYE = 5'd9, STEP_EDGES = 5'd12, STEP_SQUARE = 5'd18, STEP_IDLE = 5'd27,
                    LAST = 5'd29;
  typedef logic signed [EDGE_W-1:0] edge_t;    // 19 bits: edges are below 2^18 in size
  typedef logic signed [EDGE_W:0]   sum_t;
  typedef logic signed [CROSS_W:0]  comp_t;

  step_t step_q;
  logic  go;
  assign go          = step_q == '0 ? in_valid_i : step_q != LAST;
  assign in_ready_o  = step_q == 5'd2;
  assign out_valid_o = step_q == LAST;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) step_q <= '0;
    else if (go) step_q <= step_q + 1'b1;
    else if (out_valid_o && out_ready_i) step_q <= '0;
  end

  // ---- vertices ------------------------------------------------------------------------------------------
  vec3_t       vertex;
  edge_t [2:0] fix, v0_q, e1_q, e2_q;
  logic  [2:0] bad;
  sum_t  [2:0] sum_q;                          // of three vertices
  assign vertex = step_q == '0 ? in_rec_i[71:0] : step_q == 5'd1 ? in_rec_i[143:72] : in_rec_i[215:144];
  for (genvar i = 0; i < 3; i++) begin : gen_axis
    logic              neg;
    logic [FP_MAN_W:0] mag;
    rc_tbu_fix u_fix (.x_i(vertex[i]), .neg_o(neg), .mag_o(mag), .bad_o(bad[i]));
    assign fix[i] = neg ? -edge_t'({1'b0, mag}) : edge_t'({1'b0, mag});
    always_ff @(posedge clk_i) begin
      if (step_q == '0) begin
        v0_q[i]  <= fix[i];
        sum_q[i] <= sum_t'(fix[i]);
      end
      if (step_q == 5'd1) e1_q[i] <= fix[i] - v0_q[i];
      if (step_q == 5'd2) e2_q[i] <= fix[i] - v0_q[i];
      if (step_q == 5'd1 || step_q == 5'd2) sum_q[i] <= sum_q[i] + sum_t'(fix[i]);
    end
  end
  always_ff @(posedge clk_i) begin
    if (step_q == '0) begin
      bad_o        <= bad != '0;
      out_o.a      <= vertex;
      out_o.opaque <= in_rec_i[216];
    end else if (step_q <= 5'd2) bad_o <= bad_o || bad != '0;
  end

  // ---- cross product and its largest component -------------------------------------------------------------
  // n: signed, below 2^37 in size.
  comp_t [2:0] n_q;
  wide_t [2:0] size;
  logic [1:0]  k_d, u_q, v_q;
  always_comb begin
    for (int i = 0; i < 3; i++) size[i] = n_q[i][CROSS_W] ? wide_t'(-n_q[i]) : n_q[i][CROSS_W-1:0];
    k_d = 2'd0;
    if (size[1] > size[0]) k_d = 2'd1;
    if (size[2] > size[k_d]) k_d = 2'd2;
  end
  function automatic logic [1:0] after(logic [1:0] axis);
    return axis == 2'd2 ? 2'd0 : axis + 2'd1;
  endfunction
  always_ff @(posedge clk_i) begin
    if (step_q == STEP_EDGES - 5'd1) begin
      {out_o.k, u_q, v_q} <= {k_d, after(k_d), after(after(k_d))};
      out_o.dead <= size[k_d] == '0;
    end
  end

  // ---- multiplier: operands by step, product, sums -----------------------------------------------------------
  edge_t [2:0] eye_dist;                       // sum of vertices minus three times the eye, in 2^-8: 17 bits
  edge_t [1:0] e3;                             // v1 to v2, projected
  logic [2:0][1:0][14:0] half;                 // of the scaled cross product, components k, u, v: low and high half
  edge_t       p1_a_q, p1_b_q, mul_a, mul_b;
  step_t       p1_step_q, p2_step_q;
  logic signed [2*EDGE_W-1:0] p2_q;
  always_comb begin
    for (int i = 0; i < 3; i++)
      eye_dist[i] = edge_t'(sum_q[i] >>> (GRID - EYE_FRAC)) - edge_t'(eye_i[i]) - (edge_t'(eye_i[i]) <<< 1);
    e3[0] = e2_q[u_q] - e1_q[u_q];
    e3[1] = e2_q[v_q] - e1_q[v_q];
    mul_a = '0;
    mul_b = '0;
    case (step_q)
      5'd3:  {mul_a, mul_b} = {e1_q[1], e2_q[2]};
      5'd4:  {mul_a, mul_b} = {e1_q[2], e2_q[1]};
      5'd5:  {mul_a, mul_b} = {e1_q[2], e2_q[0]};
      5'd6:  {mul_a, mul_b} = {e1_q[0], e2_q[2]};
      5'd7:  {mul_a, mul_b} = {e1_q[0], e2_q[1]};
      5'd8:  {mul_a, mul_b} = {e1_q[1], e2_q[0]};
      5'd9:  {mul_a, mul_b} = {2{eye_dist[0]}};
      5'd10: {mul_a, mul_b} = {2{eye_dist[1]}};
      5'd11: {mul_a, mul_b} = {2{eye_dist[2]}};
      5'd12: {mul_a, mul_b} = {2{e1_q[u_q]}};
      5'd13: {mul_a, mul_b} = {2{e1_q[v_q]}};
      5'd14: {mul_a, mul_b} = {2{e2_q[u_q]}};
      5'd15: {mul_a, mul_b} = {2{e2_q[v_q]}};
      5'd16: {mul_a, mul_b} = {2{e3[0]}};
      5'd17: {mul_a, mul_b} = {2{e3[1]}};
      5'd18: {mul_a, mul_b} = {edge_t'(half[0][0]), edge_t'(half[0][0])};
      5'd19: {mul_a, mul_b} = {edge_t'(half[0][1]), edge_t'(half[0][0])};
      5'd20: {mul_a, mul_b} = {edge_t'(half[0][1]), edge_t'(half[0][1])};
      5'd21: {mul_a, mul_b} = {edge_t'(half[1][0]), edge_t'(half[1][0])};
      5'd22: {mul_a, mul_b} = {edge_t'(half[1][1]), edge_t'(half[1][0])};
      5'd23: {mul_a, mul_b} = {edge_t'(half[1][1]), edge_t'(half[1][1])};
      5'd24: {mul_a, mul_b} = {edge_t'(half[2][0]), edge_t'(half[2][0])};
      5'd25: {mul_a, mul_b} = {edge_t'(half[2][1]), edge_t'(half[2][0])};
      5'd26: {mul_a, mul_b} = {edge_t'(half[2][1]), edge_t'(half[2][1])};
      default: ;
    endcase
  end

  // Places of a product among the sums: component of the cross product, even or odd, low, middle or high part.
  logic [1:0]  cross_axis, part;
  logic        cross_first, edge_first, edge_done_q;
  logic [36:0] edge_sum_q, longest_q;
  logic [61:0] addend;
  assign cross_axis  = p2_step_q < 5'd5 ? 2'd0 : p2_step_q < 5'd7 ? 2'd1 : 2'd2;
  assign cross_first = p2_step_q[0];           // steps 3, 5, 7
  assign edge_first  = !p2_step_q[0];          // 12, 14, 16
  assign part        = 2'((p2_step_q - STEP_SQUARE) % 5'd3);
  assign addend      = part == 2'd0 ? 62'($unsigned(p2_q)) : part == 2'd1 ? 62'($unsigned(p2_q)) << 16
                     : 62'($unsigned(p2_q)) << 30;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) {p1_step_q, p2_step_q} <= '0;
    else {p2_step_q, p1_step_q} <= {p1_step_q, step_q};
    {p1_a_q, p1_b_q} <= {mul_a, mul_b};
    p2_q <= p1_a_q * p1_b_q;
    edge_done_q <= 1'b0;
    if (p2_step_q >= STEP_CROSS && p2_step_q < STEP_EYE)
      n_q[cross_axis] <= cross_first ? p2_q : n_q[cross_axis] - p2_q;
    if (p2_step_q >= STEP_EYE && p2_step_q < STEP_EDGES)
      out_o.eye_dist <= p2_q[33:0] + (p2_step_q == STEP_EYE ? '0 : out_o.eye_dist);
    if (p2_step_q >= STEP_EDGES && p2_step_q < STEP_SQUARE) begin
      edge_sum_q  <= p2_q[36:0] + (edge_first ? '0 : edge_sum_q);
      edge_done_q <= !edge_first;
    end
    if (step_q == '0) longest_q <= '0;
    else if (edge_done_q && edge_sum_q > longest_q) longest_q <= edge_sum_q;
    if (p2_step_q >= STEP_SQUARE && p2_step_q < STEP_IDLE)
      out_o.square <= addend + (p2_step_q == STEP_SQUARE ? '0 : out_o.square);
  end

  // ---- normalised: one a cycle -----------------------------------------------------------------------------------
  // Of 37 bits, but edges, which lie in the upper 18 of them.
  wide_t       nrm_in;
  shift_t      nrm_zeros, nrm_shift;
  logic [37:0] nrm_out;
  logic        nrm_neg;
  edge_t       nrm_edge;                       // b_u, b_v, g_u, g_v times component k: e2v, -e2u, -e1v, e1u
  logic [1:0]  nrm_idx;
  assign nrm_idx = 2'(step_q - 5'd17);
  always_comb begin
    case (nrm_idx)
      2'd0:    nrm_edge = e2_q[v_q];
      2'd1:    nrm_edge = -e2_q[u_q];
      2'd2:    nrm_edge = -e1_q[v_q];
      default: nrm_edge = e1_q[u_q];
    endcase
    nrm_neg = nrm_edge[EDGE_W-1];
    case (step_q)
      5'd12:        nrm_in = size[out_o.k];
      5'd13, 5'd15: nrm_in = size[u_q];
      5'd14, 5'd16: nrm_in = size[v_q];
      5'd21:        nrm_in = longest_q;
      default:      nrm_in = {nrm_neg ? 18'(-nrm_edge) : nrm_edge[17:0], 19'b0};
    endcase
    nrm_zeros = '0;
    for (int i = 0; i < int'(CROSS_W); i++) if (nrm_in[i]) nrm_zeros = shift_t'(int'(CROSS_W) - 1 - i);
    case (step_q)
      5'd15, 5'd16: nrm_shift = out_o.det.shift;               // as far as component k
      5'd21:        nrm_shift = nrm_zeros + shift_t'(nrm_zeros[0]);   // even, to 37 or 38 bits
      default:      nrm_shift = nrm_zeros;
    endcase
    nrm_out = {1'b0, nrm_in} << nrm_shift;
  end
  always_ff @(posedge clk_i) begin
    case (step_q)
      5'd12: begin
        out_o.det <= '{neg: n_q[out_o.k][CROSS_W], shift: nrm_shift, val: nrm_out[CROSS_W-1:0]};
        half[0]   <= nrm_out[36:7];
      end
      5'd13: out_o.side[0] <= '{neg: n_q[u_q][CROSS_W], shift: nrm_shift, val: nrm_out[CROSS_W-1:0]};
      5'd14: out_o.side[1] <= '{neg: n_q[v_q][CROSS_W], shift: nrm_shift, val: nrm_out[CROSS_W-1:0]};
      5'd15: half[1] <= nrm_out[36:7];
      5'd16: half[2] <= nrm_out[36:7];
      5'd17, 5'd18, 5'd19, 5'd20: begin
        out_o.edge_neg[nrm_idx]   <= nrm_neg;
        out_o.edge_shift[nrm_idx] <= nrm_shift[4:0];
        out_o.edge_val[nrm_idx]   <= nrm_out[36:19];
      end
      5'd21: {out_o.longest, out_o.half} <= {nrm_out, nrm_shift[5:1]};
      default: ;
    endcase
  end
endmodule
