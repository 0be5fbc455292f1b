// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Stack of a sorting pipeline: a frame for each node whose children are being made, with the child that waits. A frame turns
// once, from its first child to the waiting one, and keeps where the first one's root went. Makes the node's record.
//   read_i, a cycle later waiting_o, donated_o; two cycles later node_o, of the frame on top
module rc_tbp_sort_stack import rc_pkg::*, rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       clear_i,
  input  logic       push_i,
  input  frame_t     frame_i,
  input  logic       late_i,               // no child waits
  input  tnode_t     waiting_i,
  input  logic       read_i,
  input  logic       turn_i,               // one cycle after read_i: the first child is done, the waiting one's turn
  input  idx_t       back_i,               // root of the subtree that was made last
  input  logic       pop_i,
  output logic [5:0] depth_o,              // frames
  output logic       late_o,               // the frame on top has turned
  output logic       donated_o,            // the frame on top is one whose other child was donated
  output donated_t   upper_o,              // its node, once it has its place back_i
  output tnode_t     waiting_o,
  input  logic       leaf_i,               // node_o is this leaf, not the frame on top
  input  num_t       leaf_count_i,
  input  idx_t       leaf_first_i,
  output node_t      node_o
);
  logic [5:0]           depth_q;
  logic [4:0]           top;
  logic [MAX_DEPTH-1:0] late_q;
  idx_t                 other;
  fp_t                  plane;
  frame_t               frame;
  assign top     = 5'(depth_q - 6'd1);
  assign depth_o = depth_q;
  assign late_o  = late_q[top];
  assign donated_o = frame.donated;
  assign upper_o   = '{entry: frame.entry, axis: frame.axis, pos: frame.pos, swap: frame.swap, idx: back_i};
  always_ff @(posedge clk_i) begin
    if (!rst_ni || clear_i) depth_q <= '0;
    else depth_q <= depth_q + 6'(push_i) - 6'(pop_i);
    if (push_i) late_q[depth_q[4:0]] <= late_i;
    if (turn_i) late_q[top] <= 1'b1;
  end
  rc_ram_1r1w #(.Width($bits(frame_t) + $bits(tnode_t)), .Depth(MAX_DEPTH)) u_frames (
    .clk_i, .we_i(push_i), .waddr_i(depth_q[4:0]), .wdata_i({frame_i, waiting_i}),
    .re_i(read_i), .raddr_i(top), .rdata_o({frame, waiting_o})
  );
  rc_ram_1r1w #(.Width(IDX_W), .Depth(MAX_DEPTH)) u_other (
    .clk_i, .we_i(turn_i), .waddr_i(top), .wdata_i(back_i), .re_i(read_i), .raddr_i(top), .rdata_o(other)
  );

  // q - 2^17 in two's complement is q with its top bit inverted.
  rc_fp_from_int #(.IntW(COORD_W), .FracW(COORD_W - 1)) u_plane (
    .clk_i, .int_i({~frame.pos[COORD_W-1], frame.pos[COORD_W-2:0]}), .y_o(plane)
  );
  always_comb begin
    node_o = '0;
    if (leaf_i) begin
      node_o.split = fp_t'(leaf_count_i);
      node_o.axis  = 2'd3;
      node_o.other = leaf_first_i;
    end else begin
      node_o.split       = plane;
      node_o.axis        = frame.axis;
      node_o.swap        = frame.swap;
      node_o.lower_empty = frame.lower_empty;
      node_o.upper_empty = frame.upper_empty;
      if (!frame.lower_empty && !frame.upper_empty) node_o.other = other;
    end
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (push_i) StackRoom_A: assert (32'(depth_q) < MAX_DEPTH);
      if (pop_i || turn_i) StackUsed_A: assert (depth_q != '0);
      if (pop_i) Turned_A: assert (late_o);
    end
  end
`endif
endmodule
