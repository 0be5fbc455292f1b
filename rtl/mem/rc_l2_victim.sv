// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Which way of an L2 set to replace: an empty one, else the oldest, of several the lowest. A new line has age 1, one that was
// hit age 0; to make room all lines of the set age until the oldest is 3. So lines that were never hit go before those
// that were, and rays that scatter do not wash the upper nodes of the tree out. After Jaleel, Theobald, Steely and Emer, "High
// Performance Cache Replacement Using Re-Reference Interval Prediction" (ISCA 2010), where new lines have age 2.
module rc_l2_victim #(
  parameter  int unsigned Sets = 256,   // power of two
  parameter  int unsigned Ways = 8,     // 2 or more
  localparam int unsigned SetW = $clog2(Sets),
  localparam int unsigned WayW = $clog2(Ways)
) (
  input  logic            clk_i,
  input  logic            rst_ni,
  input  logic            use_valid_i,  // this way was hit or filled
  input  logic            use_new_i,    // with a new line: the set is set_i, the way way_o
  input  logic [SetW-1:0] use_set_i,
  input  logic [WayW-1:0] use_way_i,
  input  logic [SetW-1:0] set_i,        // which way of this set ...
  input  logic [Ways-1:0] valid_i,      // ... of which these hold a line ...
  output logic [WayW-1:0] way_o         // ... shall go, in the same cycle
);
  typedef logic [1:0] age_t;
  localparam age_t OLDEST = 2'd3, NEW = 2'd1, HIT = 2'd0;
  age_t [Ways-1:0] age_q [Sets];
  age_t [Ways-1:0] age, used;
  age_t            max_age;
  logic [Ways-1:0] empty, choice;
  assign age   = age_q[set_i];
  assign empty = ~valid_i;
  always_comb begin
    max_age = '0;
    for (int w = 0; w < Ways; w++) if (age[w] > max_age) max_age = age[w];
    for (int w = 0; w < Ways; w++) choice[w] = (empty != '0) ? empty[w] : age[w] == max_age;
    way_o = '0;
    for (int w = Ways - 1; w >= 0; w--) if (choice[w]) way_o = WayW'(w);
  end
  always_comb begin
    used = age_q[use_set_i];
    if (use_new_i && empty == '0) for (int w = 0; w < Ways; w++) used[w] = used[w] + (OLDEST - max_age);
    used[use_way_i] = use_new_i ? NEW : HIT;
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni)          age_q <= '{default: '0};
    else if (use_valid_i) age_q[use_set_i] <= used;
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i)
    if (rst_ni && use_valid_i && use_new_i) Replaced_A: assert (use_set_i == set_i && use_way_i == way_o);
`endif
endmodule
