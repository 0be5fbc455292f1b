// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Cost of split candidates of a node on one axis, one a cycle, and the best of those that pay (paper Sec. 3.7; docs/tbu.md):
//   cost = (nL nR = 0 ? 7 : 8) (2 Hn + 3 (H(l) nL + H(w - l) nR)),  H(l) = e1 e2 + (e1 + e2) l
// With Hn = H(w), H(w - l) is e1 e2 + Hn - H(l): three multipliers. 7 cycles from candidate to best.
//   E1 (e1 + e2) l   E2 H(l), H(w - l)   E3 times nL, nR   E4 sum   E5 3 times that and 2 Hn   E6 times 7 or 8   E7 compare
// Candidates come in ascending order of position. cfg_i and half_i are constant from E2 on, limit_i in E7.
// 3 multipliers, 6 adders, 3 comparators (two of 55 bits).
module rc_tbp_eval import rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  eval_axis_t cfg_i,
  input  half_t      half_i,               // Hn
  input  cost_t      limit_i,              // 24 n Hn
  input  logic       clear_i,              // forget the best, while nothing is in the pipeline
  input  logic       in_valid_i,
  input  cand_t      in_i,
  input  coord_t     in_len_i,             // l: from the node's lower face
  output logic       busy_o,               // candidates are in the pipeline
  output best_t      best_o
);
  localparam int unsigned LAT = 7;
  typedef logic [36:0] strip_t;            // (e1 + e2) l
  typedef logic [49:0] prod_t;             // H n, and the sum of two
  typedef logic [51:0] sum_t;

  logic [LAT-1:1] valid_q;
  assign busy_o = valid_q != '0;
  always_ff @(posedge clk_i) valid_q <= rst_ni ? (LAT - 1)'({valid_q, in_valid_i}) : '0;

  num_t  e2_nl, e2_nr;
  cand_t e5_cand, e6_cand_q;
  logic  e5_empty;
  rc_delay #(.Width(2 * $bits(num_t)), .Depth(2)) u_counts (.clk_i, .in_i({in_i.nl, in_i.nr}), .out_o({e2_nl, e2_nr}));
  rc_delay #(.Width($bits(cand_t)), .Depth(5)) u_cand (.clk_i, .in_i(in_i), .out_o(e5_cand));
  assign e5_empty = e5_cand.nl == '0 || e5_cand.nr == '0;

  strip_t e1_strip_q;
  half_t  e2_low_q, e2_high_q;             // H(l), H(w - l)
  prod_t  e3_low_q, e3_high_q, e4_sum_q;
  sum_t   e5_sum_q;
  cost_t  e6_cost_q;
  always_ff @(posedge clk_i) begin
    e1_strip_q <= strip_t'(cfg_i.rim) * strip_t'(in_len_i);
    e2_low_q   <= half_t'(cfg_i.cap) + half_t'(e1_strip_q);
    e2_high_q  <= half_i - half_t'(e1_strip_q);
    e3_low_q   <= prod_t'(e2_low_q) * prod_t'(e2_nl);
    e3_high_q  <= prod_t'(e2_high_q) * prod_t'(e2_nr);
    e4_sum_q   <= e3_low_q + e3_high_q;
    e5_sum_q   <= sum_t'(e4_sum_q) + {1'b0, e4_sum_q, 1'b0} + sum_t'({half_i, 1'b0});
    e6_cost_q  <= {e5_sum_q, 3'b000} - (e5_empty ? cost_t'(e5_sum_q) : '0);
    e6_cand_q  <= e5_cand;
  end

  // E7: the first of equal ones stays, but at one position a later one may replace it (rc_tbp_sort_axis says which).
  logic better, same;
  assign better = e6_cost_q < (best_o.found ? best_o.cost : limit_i);
  assign same   = best_o.found && e6_cand_q.late && e6_cost_q == best_o.cost && e6_cand_q.pos == best_o.pos;
  always_ff @(posedge clk_i) begin
    if (clear_i) begin
      best_o.found <= 1'b0;
    end else if (valid_q[LAT-1] && (better || same)) begin
      best_o <= {1'b1, e6_cost_q, e6_cand_q.pos, e6_cand_q.pl, e6_cand_q.nl, e6_cand_q.nr};
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
      if (in_valid_i && past_q && !clear_i) Ascending_M: assume (in_i.pos >= last_pos_q);
    end
  end
`endif
endmodule
