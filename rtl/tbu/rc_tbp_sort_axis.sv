// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// One axis of a sorting pipeline: the coordinates of all references on it, the sorted lists of their events, and what is
// done with them. One thing at a time:
//   load   a reference in two cycles: its span, cut by the box, to the bank; its events inside the box to the sorter
//   sort   rc_merge_sort with the list memory's two ends as its two sides; keys come from the bank
//   class  a reference a cycle: on which side of the plane it is, and which of its events each child keeps
//   sweep  an event a cycle: to the lists of the children that keep it, and to their evaluators; 13 cycles more
// A list holds the events strictly inside its node, and both of each planar reference. Starts and ends on the node's own
// faces, or beyond, are missing from it: nL begins with the references whose start is missing.
module rc_tbp_sort_axis import rc_tbu_pkg::*, rc_tbp_sort_pkg::*; #(
  parameter int unsigned Cap = 1280        // references
) (
  input  logic            clk_i,
  input  logic            rst_ni,
  // load and sort
  input  logic            start_i,         // a job begins
  input  logic            ld_valid_i,      // at most every second cycle
  input  logic            ld_sort_i,       // its events are needed
  input  ref_t            ld_idx_i,
  input  span_t           ld_span_i,
  input  logic            sort_end_i,      // all is loaded, two cycles or more ago
  input  num_t            sort_max_i,      // events at most, for all axes the same
  output logic            sort_busy_o,
  output logic            sort_side_o,     // the list lies in B
  // read a span: one cycle later
  input  logic            get_valid_i,
  input  ref_t            get_idx_i,
  output span_t           get_span_o,
  // class: flags of the span that was got, one cycle later still
  input  span_t           span_i,          // of the node; of the job, while it is loaded
  input  logic            cut_i,           // the plane is across this axis
  input  coord_t          pos_i,
  input  logic            pl_i,
  output logic [1:0]      class_o,         // [0] in the lower child, [1] in the upper one; if cut_i
  input  logic            class_clear_i,   // a node begins
  input  logic            class_valid_i,   // one cycle after class_o
  input  ref_t            class_idx_i,
  input  logic [1:0]      class_i,
  output num_t [1:0]      num_events_o,    // of each child
  // sweep
  input  logic            sweep_start_i,
  input  sweep_t          sweep_i,         // holds until the next one
  input  eval_cfg_t [1:0] cfg_i,
  input  eval_axis_t [1:0] cfg_axis_i,
  output logic            sweep_busy_o,
  output best_t [1:0]     best_o
);
  localparam int unsigned KEY_W  = $bits(event_key_t);
  localparam int unsigned ITEM_W = $bits(event_t);
  localparam int unsigned IdxW   = $clog2(Cap);
  localparam int unsigned LenW   = $clog2(2 * Cap + 1);
  localparam ptr_t TOP = ptr_t'(4 * Cap - 1);

  function automatic ptr_t place(logic in_b, ptr_t first, ptr_t i);
    return in_b ? first - i : first + i;
  endfunction

  // ---- load: L1 lo <= hi whatever comes, L2 cut by the box, L3 start, L4 end ----------------------------------------
  typedef struct packed {logic sort; ref_t idx; span_t span;} load_t;
  logic  l1_valid_q, l2_valid_q, l3_valid_q, l4_valid_q;
  load_t l1_q, l2_q, l3_q, l4_q;
  logic  l3_planar, l4_planar_q, l3_keep, l4_keep;
  function automatic coord_t clamp(coord_t x, span_t span);
    return (x < span.lo) ? span.lo : (x > span.hi) ? span.hi : x;
  endfunction
  always_ff @(posedge clk_i) begin
    {l4_valid_q, l3_valid_q, l2_valid_q, l1_valid_q} <= rst_ni ? {l3_valid_q, l2_valid_q, l1_valid_q, ld_valid_i} : '0;
    l1_q         <= {ld_sort_i, ld_idx_i, ld_span_i};
    l2_q         <= l1_q;
    if (l1_q.span.hi < l1_q.span.lo) l2_q.span.hi <= l1_q.span.lo;
    l3_q         <= l2_q;
    l3_q.span.lo <= clamp(l2_q.span.lo, span_i);
    l3_q.span.hi <= clamp(l2_q.span.hi, span_i);
    l4_q         <= l3_q;
    l4_planar_q  <= l3_planar;
  end
  assign l3_planar = l3_q.span.lo == l3_q.span.hi;
  assign l3_keep   = l3_planar || l3_q.span.lo != span_i.lo;
  assign l4_keep   = l4_planar_q || l4_q.span.hi != span_i.hi;

  logic       sort_in, sort_rd_valid, sort_rd_side, sort_wr_valid, sort_wr_side;
  event_key_t sort_in_key, sort_rd_key, unused_sort_wr_key;
  event_t     sort_in_event, sort_wr_event;
  logic [$clog2(2*Cap)-1:0] sort_rd_idx, sort_wr_idx;
  logic [LenW-1:0]          unused_len;
  assign sort_in       = (l3_valid_q && l3_q.sort && l3_keep) || (l4_valid_q && l4_q.sort && l4_keep);
  assign sort_in_key   = l3_valid_q ? event_key_t'{l3_q.span.lo, 1'b1, !l3_planar}
                                    : event_key_t'{l4_q.span.hi, 1'b0, l4_planar_q};
  assign sort_in_event = l3_valid_q ? event_t'{1'b1, l3_q.idx} : event_t'{1'b0, l4_q.idx};

  // ---- memories ----------------------------------------------------------------------------------------------------
  // Events are read in S0 and come in S1, their spans in S2.
  logic       s0_valid, s1_valid_q, s2_valid_q, list_room, list_idle;
  event_t     s1_event, s2_event_q;
  ptr_t       s0_ptr;
  span_t      s2_span;
  logic [1:0] s2_class, list_wr;
  ptr_t [1:0] list_ptr;
  event_t     list_event;
  ptr_t [1:0] put_q;                        // next place in A and B
  logic [1:0] put;
  event_t     put_event;
  assign list_wr    = sort_wr_valid ? {sort_wr_side, !sort_wr_side} : put;
  assign list_ptr   = sort_wr_valid ? {TOP - ptr_t'(sort_wr_idx), ptr_t'(sort_wr_idx)} : put_q;
  assign list_event = sort_wr_valid ? sort_wr_event : put_event;
  rc_tbp_list #(.Width(ITEM_W), .Depth(4 * Cap)) u_list (
    .clk_i, .rst_ni,
    .re_i(sort_rd_valid || s0_valid),
    .rptr_i(sort_rd_valid ? place(sort_rd_side, sort_rd_side ? TOP : '0, ptr_t'(sort_rd_idx)) : s0_ptr),
    .rdata_o(s1_event), .wr_valid_i(list_wr), .wr_ptr_i(list_ptr), .wr_data_i({2{list_event}}),
    .room_o(list_room), .idle_o(list_idle)
  );
  logic s1_key_q;                          // the sorter's read
  ref_t bank_idx;
  assign bank_idx = (s1_valid_q || s1_key_q) ? s1_event.idx : get_idx_i;
  rc_ram_1r1w #(.Width($bits(span_t)), .Depth(Cap)) u_bank (
    .clk_i, .we_i(l3_valid_q), .waddr_i(IdxW'(l3_q.idx)), .wdata_i(l3_q.span),
    .re_i(s1_valid_q || s1_key_q || get_valid_i), .raddr_i(IdxW'(bank_idx)), .rdata_o(s2_span)
  );
  rc_ram_1r1w #(.Width(2), .Depth(Cap)) u_class (
    .clk_i, .we_i(class_valid_i), .waddr_i(IdxW'(class_idx_i)), .wdata_i(class_i),
    .re_i(s1_valid_q), .raddr_i(IdxW'(s1_event.idx)), .rdata_o(s2_class)
  );
  assign get_span_o = s2_span;

  logic   planar;                          // the reference whose span is read
  coord_t s2_pos;
  assign planar      = s2_span.lo == s2_span.hi;
  assign s2_pos      = s2_event_q.start ? s2_span.lo : s2_span.hi;
  assign sort_rd_key = {s2_pos, s2_event_q.start, s2_event_q.start ^ planar};
  rc_merge_sort #(.KeyW(KEY_W), .ItemW(ITEM_W), .MaxLen(2 * Cap), .Run(16), .RdLat(2)) u_sort (
    .clk_i, .rst_ni, .start_i, .max_len_i(LenW'(sort_max_i)),
    .in_valid_i(sort_in), .in_key_i(sort_in_key), .in_item_i(sort_in_event), .end_i(sort_end_i),
    .busy_o(sort_busy_o), .len_o(unused_len), .side_o(sort_side_o),
    .rd_valid_o(sort_rd_valid), .rd_side_o(sort_rd_side), .rd_idx_o(sort_rd_idx),
    .rd_key_i(sort_rd_key), .rd_item_i(s2_event_q),
    .wr_valid_o(sort_wr_valid), .wr_side_o(sort_wr_side), .wr_idx_o(sort_wr_idx),
    .wr_key_o(unused_sort_wr_key), .wr_item_o(sort_wr_event)
  );

  // ---- class -------------------------------------------------------------------------------------------------------
  logic [1:0] starts, ends, starts_q, ends_q, starts_2q, ends_2q;   // the child keeps this event
  num_t [1:0] gone_q, missing_q;           // events, and starts, that a child does not have
  logic       below_q, above_q, on_q;      // starts below the plane, ends above it, lies in it
  assign class_o   = {above_q || (on_q && pl_i), below_q || (on_q && !pl_i)};
  assign starts[0] = planar || s2_span.lo > span_i.lo;
  assign ends[1]   = planar || s2_span.hi < span_i.hi;
  assign ends[0]   = planar || s2_span.hi < (cut_i ? pos_i : span_i.hi);
  assign starts[1] = planar || s2_span.lo > (cut_i ? pos_i : span_i.lo);
  always_ff @(posedge clk_i) begin
    below_q <= s2_span.lo < pos_i && pos_i != span_i.lo;    // in a flat child there are only planar references
    above_q <= s2_span.hi > pos_i && pos_i != span_i.hi;
    on_q    <= planar && s2_span.lo == pos_i;
    {starts_2q, ends_2q, starts_q, ends_q} <= {starts_q, ends_q, starts, ends};
    for (int c = 0; c < 2; c++) begin
      if (start_i || class_clear_i) begin
        {gone_q[c], missing_q[c]} <= '0;
      end else if (class_valid_i && class_i[c]) begin
        gone_q[c]    <= gone_q[c] + num_t'(!starts_2q[c]) + num_t'(!ends_2q[c]);
        missing_q[c] <= missing_q[c] + num_t'(!starts_2q[c]);
      end else if (c == 0) begin           // the root
        if (l3_valid_q && !l3_keep) missing_q[0] <= missing_q[0] + num_t'(1);
        if ((l3_valid_q && !l3_keep) || (l4_valid_q && !l4_keep)) gone_q[0] <= gone_q[0] + num_t'(1);
      end
    end
  end
  for (genvar c = 0; c < 2; c++) begin : gen_num
    assign num_events_o[c] = (sweep_i.num_refs[c] << 1) - gone_q[c];
  end

  // ---- sweep: S0 list, S1 bank and class, S2 key, S3 which child keeps it, S4 write and count ----------------------
  typedef struct packed {event_t e; coord_t pos; logic planar; logic [1:0] child;} s3_t;
  s3_t        s3_q, s4_q;
  logic       s3_valid_q, s4_valid_q, a_child;
  num_t       index_q;                     // next event to read
  logic       running_q;
  logic [1:0] keep, got;                   // the child has it
  logic [1:0] child_busy;
  num_t [1:0] num_left;
  assign s0_valid = running_q && index_q != sweep_i.num && list_room;
  assign s0_ptr   = place(sweep_i.in_b, sweep_i.first, ptr_t'(index_q));
  assign keep[0]  = s3_q.child[0] && (s3_q.planar || !sweep_i.cut || s3_q.pos < sweep_i.pos);
  assign keep[1]  = s3_q.child[1] && (s3_q.planar || !sweep_i.cut || s3_q.pos > sweep_i.pos);
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {s1_valid_q, s1_key_q, s2_valid_q, s3_valid_q, s4_valid_q, running_q} <= '0;
    end else begin
      {s4_valid_q, s3_valid_q, s2_valid_q, s1_valid_q} <= {s3_valid_q, s2_valid_q, s1_valid_q, s0_valid};
      s1_key_q  <= sort_rd_valid;
      running_q <= sweep_start_i || (running_q && index_q != sweep_i.num);
    end
    index_q    <= sweep_start_i ? '0 : index_q + num_t'(s0_valid);
    s2_event_q <= s1_event;
    s3_q       <= {s2_event_q, s2_pos, planar, sweep_i.root ? 2'b01 : s2_class};
    s4_q       <= s3_q;
    s4_q.child <= keep;
  end
  assign sweep_busy_o = running_q || s1_valid_q || s2_valid_q || s3_valid_q || s4_valid_q || !list_idle
                        || child_busy != '0;

  assign got       = s4_valid_q ? s4_q.child : 2'b00;
  assign a_child   = !sweep_i.b_upper;
  assign put[0]    = got[a_child] && sweep_i.keep[a_child] && !sweep_i.root;
  assign put[1]    = got[!a_child] && sweep_i.keep[!a_child] && !sweep_i.root;
  assign put_event = s4_q.e;
  always_ff @(posedge clk_i) begin
    if (sweep_start_i) put_q <= {sweep_i.first_b, ptr_t'(0)};
    else put_q <= {put_q[1] - ptr_t'(put[1]), put_q[0] + ptr_t'(put[0])};
  end
  for (genvar c = 0; c < 2; c++) begin : gen_child
    rc_tbp_sort_child u_child (
      .clk_i, .rst_ni, .start_i(sweep_start_i), .num_refs_i(sweep_i.num_refs[c]), .missing_i(missing_q[c]),
      .span_i(sweep_i.span[c]), .cfg_i(cfg_axis_i[c]), .half_i(cfg_i[c].half), .limit_i(cfg_i[c].limit),
      .ev_valid_i(got[c] && sweep_i.keep[c]), .ev_pos_i(s4_q.pos), .ev_start_i(s4_q.e.start), .ev_planar_i(s4_q.planar),
      .busy_o(child_busy[c]), .nl_o(num_left[c]), .best_o(best_o[c])
    );
  end

`ifndef SYNTHESIS
  logic             swept_q, s4_past_q;
  logic [KEY_W-1:0] s4_key, s4_key_q;
  assign s4_key = {s4_q.pos, s4_q.e.start, s4_q.e.start ^ s4_q.planar};
  always_ff @(posedge clk_i) begin
    swept_q <= rst_ni && (sweep_start_i || (swept_q && sweep_busy_o));
    if (s4_valid_q) s4_key_q <= s4_key;
    if (!rst_ni || sweep_start_i) s4_past_q <= 1'b0;
    else if (s4_valid_q) s4_past_q <= 1'b1;
    if (rst_ni) begin
      if (s4_valid_q && s4_past_q) EventOrder_A: assert (s4_key_q <= s4_key);
      if (ld_valid_i) LoadPace_M: assume (!l1_valid_q);
      if (sweep_start_i) SweepIdle_M: assume (!sweep_busy_o && !sort_busy_o);
      if (sort_wr_valid) SortRoom_A: assert (!s4_valid_q && list_room);
      // A list in A is read before it is written over; a list in B likewise, from its other end.
      if (put[0] && !sweep_i.in_b) BehindA_A: assert (put_q[0] < sweep_i.first + ptr_t'(index_q));
      if (put[1] && sweep_i.in_b)  BehindB_A: assert (put_q[1] > sweep_i.first - ptr_t'(index_q));
      if (put[0] && sweep_i.in_b)  RoomA_A: assert (put_q[0] + ptr_t'(sweep_i.num) <= sweep_i.first);
      if (put[1] && !sweep_i.in_b) RoomB_A: assert (put_q[1] >= ptr_t'(sweep_i.num) && put_q[1] <= TOP);
      if (swept_q && !sweep_busy_o) begin
        for (int c = 0; c < 2; c++) begin
          if (sweep_i.keep[c]) Counted_A: assert (num_left[c] == sweep_i.num_refs[c]);
        end
        if (!sweep_i.root) begin
          if (sweep_i.keep[a_child]) LengthA_A: assert (put_q[0] == ptr_t'(num_events_o[a_child]));
          if (sweep_i.keep[!a_child]) LengthB_A: assert (sweep_i.first_b - put_q[1] == ptr_t'(num_events_o[!a_child]));
        end
      end
    end
  end
`endif
endmodule
