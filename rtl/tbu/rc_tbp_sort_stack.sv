// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Stack of a sorting pipeline: a frame for each node whose children are being made, with the child that waits. A frame
// turns once, from its first child to the waiting one, and keeps where the first one's root went. The frame on top, its
// waiting child and its node are at the outputs, two cycles after a push or pop.
module rc_tbp_sort_stack import rc_pkg::*, rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       clear_i,
  input  logic       push_i,
  input  frame_t     frame_i,
  input  logic       late_i,               // no child waits
  input  tnode_t     waiting_i,
  input  logic       turn_i,               // the first child is done, it is the waiting one's turn
  input  idx_t       back_i,               // root of the first child
  input  logic       pop_i,
  output logic [5:0] depth_o,              // frames
  output logic       late_o,               // the frame on top has turned
  output tnode_t     waiting_o,
  output logic       donated_o,            // the other child of the frame on top was donated
  output donated_t   upper_o,              // its node, from pop_i to the next one; its place is not filled in
  output node_t      node_o
);
  logic [5:0]           depth_q;
  logic [4:0]           top;
  logic [MAX_DEPTH-1:0] late_q;
  idx_t                 other;
  frame_t               frame;
  assign top       = 5'(depth_q - 6'd1);
  assign depth_o   = depth_q;
  assign late_o    = late_q[top];
  assign donated_o = frame.donated;
  always_ff @(posedge clk_i) begin
    if (!rst_ni || clear_i) depth_q <= '0;
    else depth_q <= depth_q + 6'(push_i) - 6'(pop_i);
    if (push_i) late_q[depth_q[4:0]] <= late_i;
    if (turn_i) late_q[top] <= 1'b1;
    if (pop_i) upper_o <= '{entry: frame.entry, axis: frame.axis, pos: frame.pos, swap: frame.swap, idx: '0};
  end
  rc_ram_1r1w #(.Width($bits(frame_t) + $bits(tnode_t)), .Depth(MAX_DEPTH)) u_frames (
    .clk_i, .we_i(push_i), .waddr_i(depth_q[4:0]), .wdata_i({frame_i, waiting_i}),
    .re_i(!push_i), .raddr_i(top), .rdata_o({frame, waiting_o})
  );
  rc_ram_1r1w #(.Width(IDX_W), .Depth(MAX_DEPTH)) u_other (
    .clk_i, .we_i(turn_i), .waddr_i(top), .wdata_i(back_i), .re_i(!turn_i), .raddr_i(top), .rdata_o(other)
  );
  always_comb begin
    node_o             = '0;
    node_o.split       = frame.split;
    node_o.axis        = frame.axis;
    node_o.swap        = frame.swap;
    node_o.lower_empty = frame.lower_empty;
    node_o.upper_empty = frame.upper_empty;
    if (!frame.lower_empty && !frame.upper_empty) node_o.other = other;
  end
`ifndef SYNTHESIS
  logic steady_q;                          // depth_q is what it was
  always_ff @(posedge clk_i) begin
    steady_q <= !push_i && !pop_i && !clear_i;
    if (rst_ni) begin
      if (push_i) StackRoom_A: assert (32'(depth_q) < MAX_DEPTH);
      if (pop_i || turn_i) StackUsed_A: assert (depth_q != '0 && steady_q);
      if (pop_i) Turned_A: assert (late_o);
    end
  end
`endif
endmodule
