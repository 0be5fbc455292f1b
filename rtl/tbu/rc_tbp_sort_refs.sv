// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The references of a sorting pipeline: which triangle each one is, and the lists of references of nodes, in the order
// in which they came (ascending in triangle index). A walk reads the list of a node, one reference a cycle:
//   C0 list   C1 triangle; spans (in the axes)   C2 a leaf's are given out   C3 class by the spans
//   C4 to the children's lists, class to the axes; donated ones are given out
// rc_tbp_list holds the lists; what is given out waits in a queue. 6 cycles from walk_start_i to the first class.
module rc_tbp_sort_refs import rc_tbu_pkg::*, rc_tbp_sort_pkg::*; #(
  parameter int unsigned Cap = 1280        // references
) (
  input  logic        clk_i,
  input  logic        rst_ni,
  input  logic        ld_valid_i,          // load: its list is that of the root, in A
  input  ref_t        ld_idx_i,
  input  logic [TRI_W-1:0] ld_tri_idx_i,
  input  logic        ld_opaque_i,
  input  logic        walk_start_i,
  input  walk_t       walk_i,
  output logic        dividing_o,          // classes are still to come
  output logic        busy_o,              // lists are not written, or something is not given out
  output num_t [1:0]  num_o,               // references of the lower and upper child so far
  output logic [1:0][TRI_W-1:0] last_tri_idx_o,   // the last one of them
  output logic        get_valid_o,         // C1: read the spans
  output ref_t        get_idx_o,
  input  box_t        get_box_i,           // C2
  input  logic [1:0]  class_i,             // C3: [0] in the lower child, [1] in the upper one
  output logic        class_valid_o,       // C4
  output ref_t        class_idx_o,
  output logic [1:0]  class_o,
  output logic        out_valid_o,
  input  logic        out_ready_i,
  output tri_ref_t    out_ref_o,
  output logic        out_last_o,          // of a leaf
  output logic        out_donate_o         // donated, else of a leaf
);
  localparam int unsigned QUEUE = 8;
  localparam int unsigned IdxW  = $clog2(Cap);
  typedef struct packed {logic opaque; logic [TRI_W-1:0] tri_idx;} id_t;
  typedef struct packed {logic last; tri_ref_t data;} out_t;

  // ---- C0: read ahead only what the queue can take ---------------------------------------------------------------
  walk_t      walk_q;
  num_t       index_q;
  logic       running_q, c0_valid, list_room, list_idle;
  logic [3:0] out_count;
  assign c0_valid = running_q && index_q != walk_q.num && list_room
                    && ((walk_q.divide && !walk_q.donate) || out_count <= 4'd3);
  always_ff @(posedge clk_i) begin
    if (!rst_ni) running_q <= 1'b0;
    else running_q <= walk_start_i || (running_q && index_q != walk_q.num);
    if (walk_start_i) walk_q <= walk_i;
    index_q <= walk_start_i ? '0 : index_q + num_t'(c0_valid);
  end

  // ---- C1 to C4 ----------------------------------------------------------------------------------------------------
  logic c1_valid_q, c2_valid_q, c3_valid_q, c4_valid_q, c1_last_q, c2_last_q;
  ref_t c1_idx, c2_idx_q, c3_idx_q, c4_idx_q;
  box_t c3_box_q, c4_box_q;
  id_t  c2_id, c3_id_q, c4_id_q;
  logic [1:0] c4_class_q;
  assign get_valid_o   = c1_valid_q;
  assign get_idx_o     = c1_idx;
  assign class_valid_o = c4_valid_q;
  assign class_idx_o   = c4_idx_q;
  assign class_o       = c4_class_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {c1_valid_q, c2_valid_q, c3_valid_q, c4_valid_q} <= '0;
    end else begin
      c1_valid_q <= c0_valid;
      c2_valid_q <= c1_valid_q;
      c3_valid_q <= c2_valid_q && walk_q.divide;
      c4_valid_q <= c3_valid_q;
    end
    c1_last_q  <= index_q + num_t'(1) == walk_q.num;
    c2_last_q  <= c1_last_q;
    {c4_idx_q, c3_idx_q, c2_idx_q} <= {c3_idx_q, c2_idx_q, c1_idx};
    {c4_id_q, c3_id_q}             <= {c3_id_q, c2_id};
    {c4_box_q, c3_box_q}           <= {c3_box_q, get_box_i};
    c4_class_q <= class_i;
    for (int c = 0; c < 2; c++) begin
      if (walk_start_i) num_o[c] <= '0;
      else if (c4_valid_q && c4_class_q[c]) num_o[c] <= num_o[c] + num_t'(1);
      if (c4_valid_q && c4_class_q[c]) last_tri_idx_o[c] <= c4_id_q.tri_idx;
    end
  end
  rc_ram_1r1w #(.Width($bits(id_t)), .Depth(Cap)) u_id (
    .clk_i, .we_i(ld_valid_i), .waddr_i(IdxW'(ld_idx_i)), .wdata_i({ld_opaque_i, ld_tri_idx_i}),
    .re_i(c1_valid_q), .raddr_i(IdxW'(c1_idx)), .rdata_o(c2_id)
  );

  // ---- lists -------------------------------------------------------------------------------------------------------
  logic       a_child;
  logic [1:0] put;                         // to A, to B
  ptr_t [1:0] put_q;
  assign a_child = !walk_q.b_upper;
  assign put     = {c4_valid_q && c4_class_q[!a_child], c4_valid_q && c4_class_q[a_child] && !walk_q.donate};
  always_ff @(posedge clk_i) begin
    if (walk_start_i) put_q <= {walk_i.first_b, ptr_t'(0)};
    else put_q <= {put_q[1] - ptr_t'(put[1]), put_q[0] + ptr_t'(put[0])};
  end
  rc_tbp_list #(.Width($bits(ref_t)), .Depth(2 * Cap)) u_list (
    .clk_i, .rst_ni,
    .re_i(c0_valid), .rptr_i(walk_q.in_b ? walk_q.first - ptr_t'(index_q) : walk_q.first + ptr_t'(index_q)),
    .rdata_o(c1_idx),
    .wr_valid_i(ld_valid_i ? 2'b01 : put), .wr_ptr_i(ld_valid_i ? {2{ptr_t'(ld_idx_i)}} : put_q),
    .wr_data_i({2{ld_valid_i ? ld_idx_i : c4_idx_q}}), .room_o(list_room), .idle_o(list_idle)
  );

  // ---- give out ----------------------------------------------------------------------------------------------------
  out_t out_in;
  logic out_put, out_room;
  assign out_put = walk_q.divide ? c4_valid_q && walk_q.donate && c4_class_q[a_child] : c2_valid_q;
  assign out_in  = walk_q.divide ? {1'b0, c4_id_q, c4_box_q} : {c2_last_q, c2_id, get_box_i};
  rc_fifo #(.data_t(out_t), .Depth(QUEUE), .Ram(1'b0)) u_out (
    .clk_i, .rst_ni, .in_valid_i(out_put), .in_ready_o(out_room), .in_data_i(out_in),
    .out_valid_o, .out_ready_i, .out_data_o({out_last_o, out_ref_o}), .count_o(out_count)
  );
  assign out_donate_o = walk_q.divide;
  assign dividing_o   = running_q || c1_valid_q || c2_valid_q || c3_valid_q || c4_valid_q;
  assign busy_o       = dividing_o || !list_idle || out_valid_o;

`ifndef SYNTHESIS
  logic             past_q;
  logic [TRI_W-1:0] last_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni || walk_start_i) past_q <= 1'b0;
    else if (c2_valid_q) past_q <= 1'b1;
    if (c2_valid_q) last_q <= c2_id.tri_idx;
    if (rst_ni) begin
      if (walk_start_i) WalkIdle_M: assume (!busy_o);
      if (out_put) OutRoom_A: assert (out_room);
      if (c2_valid_q && past_q) Ascending_A: assert (last_q < c2_id.tri_idx);
      if (c4_valid_q) Somewhere_A: assert (c4_class_q != '0);
      if (put[0] && !walk_q.in_b) BehindA_A: assert (put_q[0] < walk_q.first + ptr_t'(index_q));
      if (put[1] && walk_q.in_b)  BehindB_A: assert (put_q[1] > walk_q.first - ptr_t'(index_q));
      if (put[0] && walk_q.in_b)  RoomA_A: assert (put_q[0] + ptr_t'(walk_q.num) <= walk_q.first);
      if (put[1] && !walk_q.in_b) RoomB_A: assert (put_q[1] >= ptr_t'(walk_q.num) && 32'(put_q[1]) < 2 * Cap);
    end
  end
`endif
endmodule
