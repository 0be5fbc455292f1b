// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Best plane of one axis from its bins, in whole numbers (docs/tbu.md): half-areas of 38 bits, costs of 63, no division.
// A bin a cycle, LATENCY cycles from the last to the result. What a leaf costs, 24 n Hn, goes through the same multipliers.
//   E1  count up, length below the plane   E2  (e1 + e2) length      E3  half-areas of both sides
//   E4  times their counts                 E5  sum                   E6  2 Hn + 3 sum
//   E7  times 8, or 7 if a side is empty   E8  least, the lower plane if equal
// Multipliers: one of 19 x 18 bits and two of 38 x 20.
module rc_tbp_bin_eval import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; #(
  localparam int unsigned HALF_W = 2 * COORD_W + 2   // half-area of a node
) (
  input  logic   clk_i,
  input  logic   rst_ni,
  input  logic   start_i,                            // with the operands below, constant until the last bin is in
  input  count_t count_i,                            // of the node
  input  coord_t e1_i,                               // extents across
  input  coord_t e2_i,
  input  coord_t width_i,                            // along
  input  coord_t lo_i,                               // of the node
  input  coord_t base_i,                             // of the bins
  input  shift_t shift_i,
  input  coord_t limit_i,                            // planes below it
  input  logic   bin_valid_i,                        // three cycles after start_i or later, first bin first
  input  bin_t   bin_i,
  input  count_t enter_i,
  input  count_t leave_i,
  output logic   busy_o,
  output logic   has_o,                              // a plane was found; the rest is its
  output cost_t  cost_o,
  output bin_t   bin_o,                              // it begins there
  output coord_t pos_o,
  output count_t n_lower_o,
  output count_t n_upper_o,
  output cost_t  leaf_cost_o
);
  typedef logic [HALF_W-1:0] half_t;
  typedef logic [HALF_W+COUNT_W-1:0] prod_t;
  typedef struct packed {                            // what goes along
    logic   leaf;                                    // not a plane but the whole node
    bin_t   bin;
    coord_t pos;
    count_t n_lower;
    count_t n_upper;
  } item_t;

  // ---- counts run on from bin to bin, beside the pipe ----------------------------------------------------------------------
  count_t n_lower_q, n_upper_q, sum_lower, sum_upper;
  assign sum_lower = n_lower_q + enter_i;
  assign sum_upper = n_upper_q - leave_i;
  always_ff @(posedge clk_i) begin
    if (start_i) {n_lower_q, n_upper_q} <= {count_t'(0), count_i};
    else if (bin_valid_i) {n_lower_q, n_upper_q} <= {sum_lower, sum_upper};
  end

  // ---- E1: operands in turn: e1 e2, then the whole node, then the planes ---------------------------------------
  logic   start_q, e1_valid_q, e1_area_q;
  item_t  e1_q;
  logic [COORD_W:0] e1_a_q;
  coord_t e1_b_q, pos;
  logic [COORD_W:0] pos_wide;                        // may lie beyond all coordinates
  assign pos_wide = {1'b0, base_i} + ((COORD_W + 1)'(bin_i + 1'b1) << shift_i);
  assign pos      = pos_wide[COORD_W-1:0];
  always_ff @(posedge clk_i) begin
    start_q    <= rst_ni && start_i;
    e1_area_q  <= start_i;
    e1_valid_q <= rst_ni && (start_q || (bin_valid_i && bin_i != '1 && pos_wide < {1'b0, limit_i}));   // none behind 63
    e1_a_q     <= start_i ? (COORD_W + 1)'(e1_i) : (COORD_W + 1)'(e1_i) + (COORD_W + 1)'(e2_i);
    e1_b_q     <= start_i ? e2_i : start_q ? width_i : pos - lo_i;
    e1_q.leaf  <= start_q;
    e1_q.bin   <= bin_i + 1'b1;
    e1_q.pos   <= pos;
    if (start_i || start_q) {e1_q.n_lower, e1_q.n_upper} <= {start_q ? count_i : '0, count_t'(0)};
    else if (bin_valid_i) {e1_q.n_lower, e1_q.n_upper} <= {sum_lower, sum_upper};
  end

  // ---- E2 to E7 -------------------------------------------------------------------------------------------------
  logic  e2_valid_q, e2_area_q, e3_valid_q, e4_valid_q, e5_valid_q, e6_valid_q, e7_valid_q;
  item_t e2_q, e3_q, e4_q, e5_q, e6_q, e7_q;
  half_t e2_len_q, area_q, half_q, e3_lower_q, e3_upper_q;
  prod_t e4_lower_q, e4_upper_q;
  logic [HALF_W+COUNT_W:0] e5_sum_q;
  cost_t e6_cost_q, e7_cost_q;
  always_ff @(posedge clk_i) begin
    {e7_valid_q, e6_valid_q, e5_valid_q, e4_valid_q, e3_valid_q, e2_valid_q} <=
      rst_ni ? {e6_valid_q, e5_valid_q, e4_valid_q, e3_valid_q, e2_valid_q, e1_valid_q} : '0;
    {e7_q, e6_q, e5_q, e4_q, e3_q, e2_q} <= {e6_q, e5_q, e4_q, e3_q, e2_q, e1_q};
    e2_area_q  <= e1_area_q;
    e2_len_q   <= half_t'(e1_a_q) * half_t'(e1_b_q);
    if (e2_area_q) area_q <= e2_len_q;
    if (e2_valid_q && e2_q.leaf) half_q <= area_q + e2_len_q;
    e3_lower_q <= area_q + e2_len_q;
    e3_upper_q <= half_q - e2_len_q;
    e4_lower_q <= prod_t'(e3_lower_q) * prod_t'(e3_q.n_lower);
    e4_upper_q <= prod_t'(e3_upper_q) * prod_t'(e3_q.n_upper);
    e5_sum_q   <= {1'b0, e4_lower_q} + {1'b0, e4_upper_q};
    e6_cost_q  <= (e5_q.leaf ? '0 : cost_t'({half_q, 1'b0})) + cost_t'(e5_sum_q) + cost_t'({e5_sum_q, 1'b0});
    e7_cost_q  <= (e6_cost_q << 3)
                  - ((!e6_q.leaf && (e6_q.n_lower == '0 || e6_q.n_upper == '0)) ? e6_cost_q : '0);
  end

  // ---- E8 ---------------------------------------------------------------------------------------------------------
  item_t best_q;
  assign busy_o = start_q || e1_valid_q || e2_valid_q || e3_valid_q || e4_valid_q || e5_valid_q || e6_valid_q
                  || e7_valid_q;
  always_ff @(posedge clk_i) begin
    if (start_i) has_o <= 1'b0;
    if (e7_valid_q) begin
      if (e7_q.leaf) begin
        leaf_cost_o <= e7_cost_q;
      end else if (!has_o || e7_cost_q < cost_o) begin
        has_o  <= 1'b1;
        cost_o <= e7_cost_q;
        best_q <= e7_q;
      end
    end
  end
  assign bin_o     = best_q.bin;
  assign pos_o     = best_q.pos;
  assign n_lower_o = best_q.n_lower;
  assign n_upper_o = best_q.n_upper;
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && start_i) Idle_M: assume (!busy_o);
    if (rst_ni && e7_valid_q && e7_q.leaf) LeafEmpty_A: assert (e7_q.n_upper == '0);
  end
`endif
endmodule
