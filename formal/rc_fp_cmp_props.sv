// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Proof: rc_fp_cmp is a total order on everything but NaN, a NaN is unordered, -0 equals +0, and the order is that of
// the real numbers: it agrees with the integer order of the patterns of positive normal numbers, and -a < -b is b < a.
module rc_fp_cmp_props #(
  parameter int unsigned ExpW = 7,
  parameter int unsigned ManW = 16
) (
  input logic                 clk_i,
  input logic [ExpW+ManW:0] a_i,
  input logic [ExpW+ManW:0] b_i,
  input logic [ExpW+ManW:0] c_i
);
  localparam int unsigned W = 1 + ExpW + ManW;
  localparam logic [W-1:0] SIGN = {1'b1, {(W - 1) {1'b0}}};

  typedef struct packed {logic lt; logic eq; logic gt;} order_t;
  order_t       ab, ba, bc, ac, neg;
  logic [W-1:0] a_q, b_q, c_q;
  logic         valid_q = 1'b0;
  rc_fp_cmp #(.ExpW(ExpW), .ManW(ManW)) u_ab (.clk_i, .a_i, .b_i, .lt_o(ab.lt), .eq_o(ab.eq), .gt_o(ab.gt));
  rc_fp_cmp #(.ExpW(ExpW), .ManW(ManW)) u_ba (
    .clk_i, .a_i(b_i), .b_i(a_i), .lt_o(ba.lt), .eq_o(ba.eq), .gt_o(ba.gt)
  );
  rc_fp_cmp #(.ExpW(ExpW), .ManW(ManW)) u_bc (
    .clk_i, .a_i(b_i), .b_i(c_i), .lt_o(bc.lt), .eq_o(bc.eq), .gt_o(bc.gt)
  );
  rc_fp_cmp #(.ExpW(ExpW), .ManW(ManW)) u_ac (.clk_i, .a_i, .b_i(c_i), .lt_o(ac.lt), .eq_o(ac.eq), .gt_o(ac.gt));
  rc_fp_cmp #(.ExpW(ExpW), .ManW(ManW)) u_neg (
    .clk_i, .a_i(a_i ^ SIGN), .b_i(b_i ^ SIGN), .lt_o(neg.lt), .eq_o(neg.eq), .gt_o(neg.gt)
  );
  always_ff @(posedge clk_i) {valid_q, a_q, b_q, c_q} <= {1'b1, a_i, b_i, c_i};

  function automatic logic is_nan(logic [W-1:0] x);
    return (&x[ManW+:ExpW]) && (x[ManW-1:0] != '0);
  endfunction
  function automatic logic is_zero(logic [W-1:0] x);
    return x[ManW+:ExpW] == '0;
  endfunction
  function automatic logic is_pos(logic [W-1:0] x);   // and normal, or infinite
    return !x[W-1] && !is_zero(x);
  endfunction

  always_ff @(posedge clk_i) begin
    if (valid_q) begin
      if (is_nan(a_q) || is_nan(b_q)) begin
        Unordered_A: assert (ab == '0);
      end else begin
        One_A: assert ($onehot(ab));
        Mirror_A: assert (ba == {ab.gt, ab.eq, ab.lt} && neg == ba);
        if (is_zero(a_q) && is_zero(b_q)) Zeros_A: assert (ab.eq);
        if (is_pos(a_q) && is_pos(b_q)) Patterns_A: assert (ab.lt == (a_q < b_q) && ab.eq == (a_q == b_q));
        if (is_pos(a_q) && (is_zero(b_q) || b_q[W-1])) Positive_A: assert (ab.gt);
        if (!is_nan(c_q)) begin
          if (ab.lt && bc.lt) Transitive_A: assert (ac.lt);
          if (ab.eq) Same_A: assert (ac == bc);
        end
      end
    end
  end
endmodule
