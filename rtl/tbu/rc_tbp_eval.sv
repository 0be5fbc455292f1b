// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Cost of split candidates of a node on one axis, one a cycle, and the best of those that pay (paper Sec. 3.7; docs/tbu.md):
//   cost = (nL nR = 0 ? 7 : 8) (2 Hn + 3 (H(l) nL + H(w - l) nR)),  H(l) = e1 e2 + (e1 + e2) l
// H(w - l) is what H(l) leaves of a sum that is the same for all l: three multipliers. 12 cycles from candidate to best.
//   E1 l   E2, E3 (e1 + e2) l   E4 H(l)   E5 H(w - l)   E6, E7 times nL, nR   E8 sum   E9 times 3   E10 + 2 Hn   E11 times 7 or 8
//   E12 compare
// Candidates come in ascending order of position. cfg_i is constant while they do, limit from E10 on, half from E9 on.
// 3 multipliers, 7 adders, 2 comparators.
module rc_tbp_eval import rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  coord_t     lo_i,                 // of the node on this axis
  input  eval_axis_t cfg_i,
  input  half_t      half_i,               // Hn
  input  cost_t      limit_i,              // 24 n Hn
  input  logic       clear_i,              // forget the best, while nothing is in the pipeline
  input  logic       in_valid_i,
  input  cand_t      in_i,
  output logic       busy_o,               // candidates are in the pipeline
  output best_t      best_o
);
  localparam int unsigned LAT = 12;
  typedef logic [36:0] strip_t;            // (e1 + e2) l
  typedef logic [49:0] prod_t;             // H n, and the sum of two
  typedef logic [51:0] sum_t;

  logic [LAT-1:1] valid_q;
  assign busy_o = valid_q != '0;
  always_ff @(posedge clk_i) valid_q <= rst_ni ? (LAT - 1)'({valid_q, in_valid_i}) : '0;

  num_t  e5_nl, e5_nr;
  cand_t e10_cand, e11_cand_q;
  logic  e10_empty;
  rc_delay #(.Width(2 * $bits(num_t)), .Depth(5)) u_counts (.clk_i, .in_i({in_i.nl, in_i.nr}), .out_o({e5_nl, e5_nr}));
  rc_delay #(.Width($bits(cand_t)), .Depth(10)) u_cand (.clk_i, .in_i(in_i), .out_o(e10_cand));
  assign e10_empty = e10_cand.nl == '0 || e10_cand.nr == '0;

  coord_t e1_len_q;
  strip_t e2_strip_q, e3_strip_q;
  half_t  e4_low_q, e5_low_q, e5_high_q;   // H(l), H(w - l)
  prod_t  e6_low_q, e6_high_q, e7_low_q, e7_high_q, e8_sum_q;
  sum_t   e9_sum_q, e10_sum_q;
  cost_t  e11_cost_q;
  always_ff @(posedge clk_i) begin
    e1_len_q   <= in_i.pos - lo_i;
    e2_strip_q <= strip_t'(cfg_i.rim) * strip_t'(e1_len_q);
    e3_strip_q <= e2_strip_q;
    e4_low_q   <= half_t'(e3_strip_q) + half_t'(cfg_i.cap);
    e5_low_q   <= e4_low_q;
    e5_high_q  <= cfg_i.both - e4_low_q;
    e6_low_q   <= prod_t'(e5_low_q) * prod_t'(e5_nl);
    e6_high_q  <= prod_t'(e5_high_q) * prod_t'(e5_nr);
    e7_low_q   <= e6_low_q;
    e7_high_q  <= e6_high_q;
    e8_sum_q   <= e7_low_q + e7_high_q;
    e9_sum_q   <= sum_t'(e8_sum_q) + {1'b0, e8_sum_q, 1'b0};
    e10_sum_q  <= e9_sum_q + sum_t'({half_i, 1'b0});
    e11_cost_q <= {e10_sum_q, 3'b000} - (e10_empty ? cost_t'(e10_sum_q) : '0);
    e11_cand_q <= e10_cand;
  end

  // E12: the first of equal ones stays, but at one position a later one may replace it (rc_tbp_sort_axis says which).
  logic better, same;
  assign better = e11_cost_q < (best_o.found ? best_o.cost : limit_i);
  assign same   = best_o.found && e11_cand_q.late && e11_cost_q == best_o.cost && e11_cand_q.pos == best_o.pos;
  always_ff @(posedge clk_i) begin
    if (clear_i) begin
      best_o.found <= 1'b0;
    end else if (valid_q[LAT-1] && (better || same)) begin
      best_o <= {1'b1, e11_cost_q, e11_cand_q.pos, e11_cand_q.pl, e11_cand_q.nl, e11_cand_q.nr};
    end
  end

`ifndef SYNTHESIS
  logic   past_q;                          // something came before, since clear_i
  coord_t last_pos_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni || clear_i) past_q <= 1'b0;
    else if (in_valid_i) past_q <= 1'b1;
    if (in_valid_i) last_pos_q <= in_i.pos;
    if (rst_ni) begin
      if (clear_i) ClearEmpty_M: assume (!busy_o && !in_valid_i);
      if (in_valid_i) Inside_M: assume (in_i.pos >= lo_i);
      if (in_valid_i && past_q && !clear_i) Ascending_M: assume (in_i.pos >= last_pos_q);
    end
  end
`endif
endmodule
