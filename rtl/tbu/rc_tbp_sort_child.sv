// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Counts along the sorted events of a child on one axis, makes a split candidate of each event, and finds the best
// (rc_tbp_eval). One event a cycle. Of several events at a position
//   end, planar before   nL as it was, nR without the ends: planar references go up; it counts after the last of them
//   planar after         one planar reference after the other goes down; it counts after the last of them
//   start                nL before the first start: the same, or a dearer one
// so one of the candidates is the true one, and no other one costs less. On the node's own faces only planar references
// lie: they alone go to the flat child there, if there are others.
module rc_tbp_sort_child import rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       start_i,              // a list begins; what follows holds until the next one
  input  num_t       num_refs_i,
  input  num_t       missing_i,            // references whose start is not in the list
  input  span_t      span_i,
  input  eval_axis_t cfg_i,
  input  half_t      half_i,
  input  cost_t      limit_i,
  input  logic       ev_valid_i,
  input  coord_t     ev_pos_i,
  input  logic       ev_start_i,           // start, or planar after
  input  logic       ev_planar_i,
  output logic       busy_o,
  output num_t       nl_o,                 // references that have started; all of them in the end
  output best_t      best_o
);
  num_t  nl_q, nr_q, nl, nr;
  logic  at_lo, at_hi, cand_valid, cand_valid_q, all_flat_q;
  cand_t cand, cand_q;
  coord_t len_q;
  best_t best;
  assign nl    = nl_q + num_t'(ev_start_i);
  assign nr    = nr_q - num_t'(ev_start_i == ev_planar_i);
  assign at_lo = ev_pos_i == span_i.lo;
  assign at_hi = ev_pos_i == span_i.hi;
  assign nl_o  = nl_q;

  always_comb begin
    cand       = '{pos: ev_pos_i, pl: !ev_start_i, late: !ev_start_i || ev_planar_i,
                   nl: (ev_start_i && !ev_planar_i) ? nl_q : nl, nr: nr};
    cand_valid = ev_valid_i;
    if (ev_planar_i && at_lo) begin        // none is left of it
      cand.nl    = num_refs_i - nr;
      cand_valid = ev_valid_i && ev_start_i && !at_hi;
    end else if (ev_planar_i && at_hi) begin
      cand.nr    = num_refs_i - nl_q;
      cand_valid = ev_valid_i && !ev_start_i && nl_q != '0;
    end
  end
  always_ff @(posedge clk_i) begin
    cand_valid_q <= rst_ni && cand_valid;
    cand_q       <= cand;
    len_q        <= ev_pos_i - span_i.lo;
    if (start_i) begin
      nl_q <= missing_i;
      nr_q <= num_refs_i;
      all_flat_q <= 1'b0;
    end else if (ev_valid_i) begin
      nl_q <= nl;
      nr_q <= nr;
      if (at_lo && nr == '0) all_flat_q <= 1'b1;    // no other references: no candidate at all
    end
  end

  logic eval_busy;
  rc_tbp_eval u_eval (
    .clk_i, .rst_ni, .cfg_i, .half_i, .limit_i, .clear_i(start_i), .in_valid_i(cand_valid_q), .in_i(cand_q),
    .in_len_i(len_q), .busy_o(eval_busy), .best_o(best)
  );
  assign busy_o = cand_valid_q || eval_busy;
  always_comb begin
    best_o = best;
    best_o.found = best.found && !all_flat_q;
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && ev_valid_i && !start_i) begin
      LeftBound_A:  assert (nl <= num_refs_i);
      RightBound_A: assert (nr <= num_refs_i);        // also: not below 0
      InSpan_A:     assert (ev_pos_i >= span_i.lo && ev_pos_i <= span_i.hi);
      FacePlanar_A: assert (ev_planar_i || (!at_lo && !at_hi));
    end
  end
`endif
endmodule
