// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Order of work of the binning pipeline. A family takes two levels at once, so a list is read twice and written once for both:
//   HEAD   plane of P, from the pass that wrote its list; at most refine_max references: refined by one more pass
//   pass A bins of children with more than Cap references; refined likewise
//   pass B P's list again: a list for each child or grandchild, bins of those with more than Cap references
// Up to Cap references: a job, its list in the job ring. More: to the region that P's list is not in, and pushed, the smallest
// on top, which goes next. If no split pays, or at level 32: a leaf, its references become list entries.
// Working memory: NUM_JOBS lists of Cap references, then region X from below and region Y from above, both stacks.
// The stack of pending nodes: 64 x 253 bits = 16,192 bits.
module rc_tbp_bin_ctrl import rc_pkg::*; import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; #(
  parameter int unsigned Cap = 1280                  // references of a sorting pipeline, multiple of 4
) (
  input  logic      clk_i,
  input  logic      rst_ni,
  input  tbu_cfg_t  cfg_i,
  input  logic      start_i,
  output logic      busy_o,
  output logic      waits_o,                         // for a place in the job ring or an upper node's entry
  output logic      full_o,                          // working memory is too small
  output logic      pass_start_o,
  output pass_t     pass_o,
  output binned_t [NUM_SLOTS-1:0] member_o,
  input  logic      pass_done_i,
  input  logic      plane_valid_i,
  input  slot_t     plane_slot_i,
  input  plane_t    plane_i,
  output logic      split_valid_o,                   // an upper node; its children name the entry that it gets
  input  logic      split_ready_i,
  output split_t    split_o,
  input  logic [6:0] split_entry_i,
  output logic      leaf_valid_o,
  input  logic      leaf_ready_i,
  output leaf_t     leaf_o,
  output logic      ids_req_o,                       // room for ids_count_o list entries in one piece
  input  logic      ids_gnt_i,
  input  idx_t      ids_idx_i,
  output count_t    ids_count_o,
  output logic      job_valid_o,
  input  logic      job_ready_i,
  output list_job_t job_o,
  input  logic      job_read_i                       // the oldest job's list was read
);
  localparam idx_t   RING = idx_t'(NUM_JOBS * Cap);
  localparam count_t CAP  = count_t'(Cap);
  localparam int unsigned STACK = 64;
  if (Cap % 4 != 0 || Cap < 8) begin : gen_bad_cap
    $error("Cap must be a multiple of 4, 8 or more");
  end
  typedef enum logic [4:0] {
    IDLE, ROOT, HEAD, SPLIT_P, CHILDREN, REFINE, SPLIT_L, SPLIT_U, SORT, PLACE, WRITE, PUSH, POP, POPPED,
    LEAF_ROOM, LEAF_IDS, LEAF, SMALL, PASS
  } state_e;
  typedef bnode_t [6:0] family_t;
  state_e  state_q, after_q;                         // after_q: where to go on when the pass is done
  family_t fam_q;
  logic    vertices_q, fine_q;                       // of the pass under way
  logic [NUM_SLOTS-1:0] bin_en_q;
  out_e    out_q;
  idx_t    leaf_first_q;
  logic [2:0] en_q;                                  // who of P, lower and upper child is divided

  function automatic idx_t room(count_t n);          // lists begin at whole lines
    return idx_t'({n[COUNT_W-1:2] + (COUNT_W - 2)'(n[1:0] != '0), 2'b00});
  endfunction
  function automatic bnode_t child(bnode_t p, logic upper, logic [6:0] entry);
    logic   adjacent, longer;                        // with equal extents across, the longer one is the larger one
    coord_t below, above;
    below    = p.plane.pos - p.box.lo[p.plane.axis];
    above    = p.box.hi[p.plane.axis] - p.plane.pos;
    longer   = above > below;
    adjacent = upper == (p.plane.n_lower == '0 || (p.plane.n_upper != '0 && longer));
    child             = p;
    child.dest        = '{root: 1'b0, upper: upper, entry: entry};
    child.gap         = adjacent ? p.gap + 1'b1 : '0;
    child.level       = p.level + 1'b1;
    child.count       = upper ? p.plane.n_upper : p.plane.n_lower;
    child.plane.pays  = 1'b0;
    child.final_plane = p.level + 1'b1 == level_t'(MAX_DEPTH);
    if (upper) child.box.lo[p.plane.axis] = p.plane.pos;
    else       child.box.hi[p.plane.axis] = p.plane.pos;
  endfunction

  // ---- members of the slots ----------------------------------------------------------------------------------------
  member_t [NUM_SLOTS-1:0] at;
  logic [NUM_SLOTS-1:0]    used, big;              // big: to a region, else a job
  bnode_t [NUM_SLOTS-1:0]  mem;
  assign at = {3'd6, en_q[2] ? 3'd5 : 3'd2, 3'd4, !en_q[0] ? 3'd0 : en_q[1] ? 3'd3 : 3'd1};
  for (genvar s = 0; s < NUM_SLOTS; s++) begin : gen_slot
    assign mem[s]   = fam_q[at[s]];
    assign used[s]  = (s == 0 || (en_q[0] && (s == 2 || (s == 1 && en_q[1]) || (s == 3 && en_q[2]))))
                      && mem[s].count != '0;
    assign big[s] = used[s] && mem[s].count > CAP;
    assign member_o[s] = '{box: mem[s].box, count: mem[s].count, bin: mem[s].plane.bin};
  end

  // ---- the pass -------------------------------------------------------------------------------------------------------
  always_comb begin
    pass_o.vertices = vertices_q;
    pass_o.line     = vertices_q ? cfg_i.vertex_base : cfg_i.ref_base + line_addr_t'(fam_q[0].base[IDX_W-1:2]);
    pass_o.count    = fam_q[0].count;
    pass_o.fine     = fine_q;
    pass_o.bin_en   = bin_en_q;
    pass_o.out      = out_q;
    for (int i = 0; i < 3; i++)
      pass_o.classes.cut[i] = '{axis: fam_q[i].plane.axis, pos: fam_q[i].plane.pos};
    pass_o.classes.en = en_q;
    for (int s = 0; s < NUM_SLOTS; s++)
      pass_o.base[s] = (out_q == OUT_IDS) ? leaf_first_q : mem[s].base;
  end
  logic [NUM_SLOTS-1:0] to_bin, to_refine;
  always_comb begin
    for (int s = 0; s < NUM_SLOTS; s++) begin
      to_bin[s]    = big[s] && !mem[s].final_plane;
      to_refine[s] = to_bin[s] && mem[s].count <= cfg_i.refine_max;
    end
  end

  // ---- places in working memory ------------------------------------------------------------------------------------------
  idx_t x_top_q, y_top_q, largest_room;
  logic [4:0] jobs_q;                                // lists in the ring
  logic [3:0] ring_q;                                // next place in it
  logic [NUM_SLOTS-1:0] placed_q, waits;
  slot_t largest, first_job;
  slot_t [NUM_SLOTS-1:0] order_q;
  logic [2:0] order_count_q, push_q;
  logic  any_large, any_job, y_next, fits, job_take, place_large, place_job;
  always_comb begin
    largest   = '0;
    first_job = '0;
    waits     = used & ~placed_q;
    for (int s = NUM_SLOTS - 1; s >= 0; s--) begin
      if (waits[s] && !big[s]) first_job = slot_t'(s);
      if (waits[s] && big[s] && (!(waits[largest] && big[largest]) || mem[s].count >= mem[largest].count))
        largest = slot_t'(s);
    end
    any_large = (waits & big) != '0;
    any_job   = (waits & ~big) != '0;
  end
  assign y_next       = state_q != ROOT && !fam_q[0].in_y;
  assign largest_room = room(mem[largest].count);
  assign fits         = x_top_q <= y_top_q && largest_room <= y_top_q - x_top_q;
  assign place_large  = (state_q == PLACE || state_q == ROOT) && any_large && fits;
  assign place_job    = state_q == PLACE && !any_large && any_job && jobs_q != 5'(NUM_JOBS);
  assign full_o       = (state_q == PLACE || state_q == ROOT) && any_large && !fits;

  // ---- pending nodes ---------------------------------------------------------------------------------------------------------
  logic [6:0] depth_q;
  bnode_t popped, pushed;
  logic   push, pop;
  assign pushed = mem[order_q[push_q[1:0]]];
  assign push   = state_q == PUSH && big[order_q[push_q[1:0]]] && push_q != order_count_q;
  assign pop    = state_q == POP && depth_q != '0;
  rc_ram_1r1w #(.Width($bits(bnode_t)), .Depth(STACK)) u_stack (
    .clk_i,
    .we_i(push), .waddr_i(depth_q[5:0]), .wdata_i(pushed),
    .re_i(pop), .raddr_i(depth_q[5:0] - 1'b1), .rdata_o(popped)
  );

  // ---- to others ---------------------------------------------------------------------------------------------------------------
  member_t split_at;
  logic    swap, split_take;
  bnode_t  split_node, lower, upper, job_node;
  assign split_at      = (state_q == SPLIT_P) ? 3'd0 : (state_q == SPLIT_L) ? 3'd1 : 3'd2;
  assign split_node    = fam_q[split_at];
  assign split_valid_o = (state_q == SPLIT_P || state_q == SPLIT_L || state_q == SPLIT_U) && split_node.plane.pays;
  assign split_take    = split_valid_o && split_ready_i;
  assign lower = child(split_node, 1'b0, split_entry_i);
  assign upper = child(split_node, 1'b1, split_entry_i);
  assign swap  = upper.gap != '0;
  assign split_o = '{dest: split_node.dest, axis: split_node.plane.axis, pos: split_node.plane.pos, swap: swap,
                     lower_empty: split_node.plane.n_lower == '0, upper_empty: split_node.plane.n_upper == '0};
  assign ids_req_o   = state_q == LEAF_ROOM;
  assign ids_count_o = fam_q[0].count;
  assign leaf_valid_o = state_q == LEAF;
  assign leaf_o = '{dest: fam_q[0].dest, gap: fam_q[0].gap, first: leaf_first_q, count: fam_q[0].count};
  assign job_valid_o = (state_q == PUSH && push_q != order_count_q && !big[order_q[push_q[1:0]]]) || state_q == SMALL;
  assign job_take    = job_valid_o && job_ready_i;
  assign job_node = (state_q == SMALL) ? fam_q[0] : pushed;
  assign job_o = '{vertices: state_q == SMALL, base: job_node.base,
                   job: '{dest: job_node.dest, gap: job_node.gap, level: job_node.level, count: job_node.count,
                          box: job_node.box}};
  assign waits_o = (split_valid_o && !split_ready_i) || (state_q == PLACE && !any_large && any_job && !place_job);
  assign busy_o  = state_q != IDLE;

  // ---- states --------------------------------------------------------------------------------------------------------------------
  logic begin_q;                                     // a cycle later, when places and members are in their registers
  assign pass_start_o = begin_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      state_q <= IDLE;
      {begin_q, depth_q, jobs_q, ring_q, en_q} <= '0;
    end else begin
      begin_q <= 1'b0;
      jobs_q  <= jobs_q + 5'(place_job) - 5'(job_read_i);
      if (place_job) ring_q <= ring_q + 1'b1;
      if (push) depth_q <= depth_q + 1'b1;
      else if (pop) depth_q <= depth_q - 1'b1;
      case (state_q)
        IDLE: if (start_i) begin
          state_q <= (cfg_i.tri_count == '0) ? LEAF : (cfg_i.tri_count <= CAP) ? SMALL : ROOT;
        end
        ROOT: if (fits) {state_q, begin_q, after_q} <= {PASS, 1'b1, HEAD};
        HEAD: begin
          if (to_refine[0]) {state_q, begin_q, after_q} <= {PASS, 1'b1, SPLIT_P};
          else state_q <= SPLIT_P;
        end
        SPLIT_P: begin
          if (!split_node.plane.pays) state_q <= LEAF_ROOM;
          else if (split_take) {state_q, en_q} <= {CHILDREN, 3'b001};
        end
        CHILDREN: begin
          if (to_bin != '0) {state_q, begin_q, after_q} <= {PASS, 1'b1, REFINE};
          else state_q <= SORT;
        end
        REFINE: begin
          if (to_refine != '0) {state_q, begin_q, after_q} <= {PASS, 1'b1, SPLIT_L};
          else state_q <= SPLIT_L;
        end
        SPLIT_L: begin
          if (split_take) en_q[1] <= 1'b1;
          if (!split_valid_o || split_take) state_q <= SPLIT_U;
        end
        SPLIT_U: begin
          if (split_take) en_q[2] <= 1'b1;
          if (!split_valid_o || split_take) state_q <= SORT;
        end
        SORT:  state_q <= PLACE;
        PLACE: if (waits == '0) state_q <= WRITE;
        WRITE: {state_q, begin_q, after_q} <= {PASS, 1'b1, PUSH};
        PUSH:  if (push_q == order_count_q) state_q <= POP;
        POP: begin
          en_q    <= '0;
          state_q <= pop ? POPPED : IDLE;
        end
        POPPED:    state_q <= HEAD;
        LEAF_ROOM: if (ids_gnt_i) state_q <= LEAF_IDS;
        LEAF_IDS:  {state_q, begin_q, after_q} <= {PASS, 1'b1, LEAF};
        LEAF:      if (leaf_ready_i) state_q <= POP;
        SMALL:     if (job_ready_i) state_q <= POP;
        PASS:      if (pass_done_i) state_q <= after_q;
        default:   state_q <= IDLE;
      endcase
    end
  end

  // ---- data of the states ------------------------------------------------------------------------------------------------------
  always_ff @(posedge clk_i) begin
    case (state_q)
      IDLE: begin
        x_top_q <= RING;
        y_top_q <= {cfg_i.ref_count[IDX_W-1:2], 2'b00};
        fam_q[0] <= '{dest: '{root: 1'b1, upper: 1'b0, entry: '0}, gap: '0, level: '0, count: cfg_i.tri_count,
                      box: cfg_i.box, plane: '0, final_plane: 1'b0, in_y: 1'b0, base: RING};
        leaf_first_q <= '0;
      end
      POPPED:    fam_q[0] <= popped;
      LEAF_ROOM: leaf_first_q <= ids_idx_i;
      default: ;
    endcase
    if (state_q == IDLE || state_q == SORT) {placed_q, order_count_q, push_q} <= '0;
    if (split_take) begin
      fam_q[{split_at[1:0], 1'b1}] <= lower;
      fam_q[{split_at[1:0], 1'b1} + 1'b1] <= upper;
    end
    for (int i = 0; i < 3; i++)                        // what was evaluated, and refined if it should be, stays
      if (state_q == ((i == 0) ? SPLIT_P : REFINE)) fam_q[i].final_plane <= 1'b1;
    if (plane_valid_i) fam_q[at[plane_slot_i]].plane <= plane_i;
    if (place_large) begin
      fam_q[at[largest]].in_y <= y_next;
      fam_q[at[largest]].base <= y_next ? y_top_q - largest_room : x_top_q;
      if (y_next) y_top_q <= y_top_q - largest_room;
      else        x_top_q <= x_top_q + largest_room;
    end
    if (place_job) fam_q[at[first_job]].base <= idx_t'(ring_q) * idx_t'(Cap);
    if (place_large || place_job) begin
      placed_q[place_large ? largest : first_job] <= 1'b1;
      order_q[order_count_q[1:0]] <= place_large ? largest : first_job;
      order_count_q <= order_count_q + 1'b1;
    end
    if (push || (job_take && state_q == PUSH)) push_q <= push_q + 1'b1;
    if (state_q == PASS && pass_done_i && (after_q == PUSH || after_q == LEAF)) begin   // P's list is no longer needed
      if (fam_q[0].in_y) y_top_q <= fam_q[0].base + room(fam_q[0].count);
      else               x_top_q <= fam_q[0].base;
    end
    if (state_q != PASS) begin
      vertices_q <= state_q == ROOT;
      fine_q     <= state_q == HEAD || state_q == REFINE;
      bin_en_q   <= (state_q == HEAD || state_q == REFINE) ? to_refine : (state_q == LEAF_IDS) ? '0 : to_bin;
      out_q      <= (state_q == ROOT || state_q == WRITE) ? OUT_REFS : (state_q == LEAF_IDS) ? OUT_IDS : OUT_NONE;
    end
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && state_q == POP && !pop)
      NothingLeft_A: assert (x_top_q == RING && y_top_q == {cfg_i.ref_count[IDX_W-1:2], 2'b00});
    if (rst_ni && push) StackRoom_A: assert (32'(depth_q) < STACK);
  end
`endif
endmodule
