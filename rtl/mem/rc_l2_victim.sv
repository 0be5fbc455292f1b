// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Which way of an L2 set to replace: an empty one, else the one that the tree of pseudo-LRU bits
// points to. Node 1 is the root, the children of node n are 2n and 2n + 1; a bit points to the half
// used longer ago. Where the number of ways is no power of two, halves without a way are passed by.
module rc_l2_victim #(
  parameter  int unsigned Sets = 256,   // power of two
  parameter  int unsigned Ways = 8,     // 2 or more
  localparam int unsigned SetW = $clog2(Sets),
  localparam int unsigned WayW = $clog2(Ways)
) (
  input  logic            clk_i,
  input  logic            rst_ni,
  input  logic            use_valid_i,  // this way was hit or filled
  input  logic [SetW-1:0] use_set_i,
  input  logic [WayW-1:0] use_way_i,
  input  logic [SetW-1:0] set_i,        // which way of this set ...
  input  logic [Ways-1:0] valid_i,      // ... of which these hold a line ...
  output logic [WayW-1:0] way_o         // ... shall go, in the same cycle
);
  localparam int unsigned Leaves = 2 ** WayW;
  logic [Sets-1:0][Leaves-1:1] tree_q;
  logic [Leaves-1:1]           used;
  logic [Ways-1:0]             empty;
  assign empty = ~valid_i & (valid_i + 1'b1);   // lowest empty way, one-hot

  always_comb begin                        // follow the bits to the way to replace
    logic [Leaves-1:1] tree;
    logic [WayW-1:0]   node;
    logic              exists;
    tree  = tree_q[set_i];
    node  = WayW'(1);
    way_o = '0;
    for (int l = WayW - 1; l >= 0; l--) begin
      exists   = 32'(way_o) + 2 ** l < Ways;              // a way in the upper half
      way_o[l] = tree[node] && exists;
      node     = WayW'({node, way_o[l]});
    end
    if (empty != '0) begin
      way_o = '0;
      for (int w = 0; w < Ways; w++) if (empty[w]) way_o |= WayW'(w);
    end
  end
  always_comb begin                        // turn the bits on the path away from the way used
    logic [WayW-1:0] node;
    used = tree_q[use_set_i];
    node = WayW'(1);
    for (int l = WayW - 1; l >= 0; l--) begin
      used[node] = !use_way_i[l];
      node = WayW'({node, use_way_i[l]});
    end
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni)          tree_q <= '0;
    else if (use_valid_i) tree_q[use_set_i] <= used;
  end
endmodule
