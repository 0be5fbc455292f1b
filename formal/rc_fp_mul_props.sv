// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Proof: rc_fp_mul returns the FP24 number nearest to the exact product, the even one of two at equal distance.
// The specification shares no step with the unit: it measures the distance of the result from the product.
// Wrong = 1 states instead that products are never rounded up, which must fail.
module rc_fp_mul_props #(
  parameter int unsigned ExpW  = 7,
  parameter int unsigned ManW  = 16,
  parameter bit          Wrong = 1'b0
) (
  input logic                 clk_i,
  input logic [ExpW+ManW:0] a_i,
  input logic [ExpW+ManW:0] b_i
);
  localparam int unsigned W     = 1 + ExpW + ManW;
  localparam int unsigned ProdW = 2 * ManW + 2;
  localparam int          BIAS  = (1 << (ExpW - 1)) - 1;
  localparam int          EMAX  = (1 << ExpW) - 1;

  logic [W-1:0] y, y_swap, y_neg, a_q, b_q;
  logic         valid_q = 1'b0;
  rc_fp_mul #(.ExpW(ExpW), .ManW(ManW)) u_mul (.clk_i, .a_i, .b_i, .y_o(y));
  rc_fp_mul #(.ExpW(ExpW), .ManW(ManW)) u_swap (.clk_i, .a_i(b_i), .b_i(a_i), .y_o(y_swap));
  rc_fp_mul #(.ExpW(ExpW), .ManW(ManW)) u_neg (.clk_i, .a_i({!a_i[W-1], a_i[W-2:0]}), .b_i, .y_o(y_neg));
  always_ff @(posedge clk_i) {valid_q, a_q, b_q} <= {1'b1, a_i, b_i};

  function automatic logic is_nan(logic [W-1:0] x);
    return (&x[ManW+:ExpW]) && (x[ManW-1:0] != '0);
  endfunction
  function automatic logic is_inf(logic [W-1:0] x);
    return (&x[ManW+:ExpW]) && (x[ManW-1:0] == '0);
  endfunction
  function automatic logic is_zero(logic [W-1:0] x);
    return x[ManW+:ExpW] == '0;
  endfunction

  // The exact product is prod * 2^(exp - BIAS - 2 ManW); 1 <= prod * 2^-2ManW < 4.
  logic [ProdW-1:0] prod;
  int               exp, top;
  logic             two, big, sign;
  assign prod = ProdW'({1'b1, a_q[ManW-1:0]}) * ProdW'({1'b1, b_q[ManW-1:0]});
  assign exp  = int'(a_q[ManW+:ExpW]) + int'(b_q[ManW+:ExpW]) - BIAS;
  assign two  = prod[ProdW-1];
  assign top  = exp + int'(two);
  // At least 2 - 2^-(ManW+1) in units of its leading one: rounds up to the next power of two.
  assign big  = two ? (&prod[ProdW-1-:ManW+2]) : (&prod[ProdW-2-:ManW+2]);
  assign sign = a_q[W-1] ^ b_q[W-1];

  // The result in units of 2^(exp - BIAS - 2 ManW), its distance from the product and half of its last place.
  int             k;
  logic [ProdW:0] res, gap, half;
  assign k    = int'(y[ManW+:ExpW]) - exp;
  assign res  = (ProdW + 1)'({1'b1, y[ManW-1:0]}) << (int'(ManW) + k);
  assign gap = (res > {1'b0, prod}) ? res - {1'b0, prod} : {1'b0, prod} - res;
  // Below a power of two the numbers lie twice as close.
  assign half = (ProdW + 1)'(1) << (int'(ManW) + k - 1 - int'(y[ManW-1:0] == '0 && res > {1'b0, prod}));

  always_ff @(posedge clk_i) begin
    if (valid_q) begin
      if (Wrong) begin
        if (!is_nan(y) && !is_inf(y) && !is_zero(y)) NeverUp_A: assert (res <= {1'b0, prod});
      end else begin
        Commutes_A: assert (y == y_swap);
        if (!is_nan(y)) SignFlips_A: assert (y_neg == {!y[W-1], y[W-2:0]});
        if (is_nan(a_q) || is_nan(b_q) || (is_inf(a_q) && is_zero(b_q)) || (is_zero(a_q) && is_inf(b_q))) begin
          Nan_A: assert (y == {1'b0, {ExpW{1'b1}}, 1'b1, {(ManW - 1) {1'b0}}});
        end else begin
          Sign_A: assert (y[W-1] == sign);
          if (is_inf(a_q) || is_inf(b_q)) Inf_A: assert (is_inf(y));
          else if (is_zero(a_q) || is_zero(b_q)) Zero_A: assert (y[W-2:0] == '0);
          else if (top > EMAX - 1 || (top == EMAX - 1 && big)) Overflow_A: assert (is_inf(y));
          else if (top < 0 || (top == 0 && !big)) Underflow_A: assert (y[W-2:0] == '0);
          else begin
            Normal_A: assert (!is_zero(y) && !is_nan(y) && !is_inf(y) && (k == 0 || k == 1));
            Nearest_A: assert (gap < half || (gap == half && !y[0]));
          end
        end
      end
    end
  end
endmodule
