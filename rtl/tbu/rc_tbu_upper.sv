// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Nodes above the jobs. An entry waits for the addresses of its children; with the last one its node is written and its own
// address goes to the entry above, up to the root. The node lies just below its adjacent child, where that one's pipeline
// left a slot free. Entries 0 to 63 are the binning pipeline's nodes. Entries 64 to 79 are nodes whose other child was
// donated: they wait for that child and for the node's own place, and nothing goes up, since the donor reports its job.
// Leaves of the binning pipeline get their place here. An event takes 3 cycles and, with a node, its write.
// SRAM: 80 x 56 + 80 x 24 + 64 x 6 + 16 x 4 bits = 6,848 bits.
module rc_tbu_upper import rc_pkg::*; import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; #(
  localparam int unsigned N = NUM_SORTERS
) (
  input  logic     clk_i,
  input  logic     rst_ni,
  input  logic     split_valid_i,                    // a new node of the binning pipeline
  output logic     split_ready_o,
  input  split_t   split_i,
  output logic [6:0] split_entry_o,                  // that it got
  input  logic     leaf_valid_i,
  output logic     leaf_ready_o,
  input  leaf_t    leaf_i,
  input  logic     [N-1:0] ent_offer_i,              // pipelines that work
  output logic     [N-1:0] ent_valid_o,              // an entry for a donated node is offered, to them in turn
  input  logic     [N-1:0] ent_ready_i,              // and taken; may depend on ent_valid_o
  output logic [6:0] ent_idx_o,
  input  logic     [N-1:0] don_valid_i,
  output logic     [N-1:0] don_ready_o,
  input  donated_t [N-1:0] don_i,
  input  logic     [N-1:0] sub_valid_i,
  output logic     [N-1:0] sub_ready_o,
  input  subtree_t [N-1:0] sub_i,
  output logic     ext_req_o,                        // room for nodes
  input  logic     ext_gnt_i,
  input  idx_t     ext_idx_i,
  output logic     wr_valid_o,
  input  logic     wr_ready_i,
  output tbu_wr_t  wr_o,
  output logic     done_o,                           // the root's place is known, nothing is missing below; stays
  output idx_t     root_o
);
  localparam int unsigned OWN = 64;
  localparam int unsigned DONATED = 16;
  localparam int unsigned ENTRIES = OWN + DONATED;
  typedef struct packed {split_t split; idx_t idx;} entry_t;
  typedef enum logic [2:0] {IDLE, READ, ACT, ROOM, PLACE, WRITE} state_e;
  state_e   state_q;
  subtree_t event_q;                                 // who has an address
  leaf_t    leaf_q;

  function automatic fp_t to_fp(coord_t q);          // exact: 17 significant bits
    logic [FP_MAN_W:0] size;
    logic neg;
    to_fp = '0;
    neg   = !q[COORD_W-1];
    size  = (FP_MAN_W + 1)'(neg ? coord_t'(1 << (COORD_W - 1)) - q : q - coord_t'(1 << (COORD_W - 1)));
    for (int b = 0; b <= FP_MAN_W; b++)
      if (size[b]) to_fp = {neg, FP_EXP_W'(46 + b), FP_MAN_W'(size << (FP_MAN_W - b))};
  endfunction

  // ---- free entries ----------------------------------------------------------------------------------------
  logic own_valid, don_free_valid, own_free, don_free;
  logic [5:0] own_idx;
  logic [3:0] don_idx;
  logic [6:0] unused_own;
  logic [4:0] don_left;
  rc_idx_pool #(.NumIdx(OWN)) u_own (
    .clk_i, .rst_ni, .out_valid_o(own_valid), .out_ready_i(split_valid_i && split_ready_o), .out_idx_o(own_idx),
    .free_valid_i(own_free), .free_idx_i(event_q.dest.entry[5:0]), .count_o(unused_own)
  );
  logic [N-1:0] ent_gnt;
  logic         ent_take;
  logic [$clog2(N)-1:0] unused_ent;
  rc_idx_pool #(.NumIdx(DONATED)) u_donated (
    .clk_i, .rst_ni, .out_valid_o(don_free_valid), .out_ready_i(ent_take), .out_idx_o(don_idx),
    .free_valid_i(don_free), .free_idx_i(event_q.dest.entry[3:0]), .count_o(don_left)
  );
  rc_rr_arb #(.NumReq(N)) u_ent (
    .clk_i, .rst_ni, .req_i(don_free_valid ? ent_offer_i : '0), .ready_i(1'b1), .gnt_o(ent_gnt), .idx_o(unused_ent)
  );
  assign ent_valid_o   = ent_gnt;
  assign ent_take      = (ent_gnt & ent_ready_i) != '0;
  assign ent_idx_o     = {3'b100, don_idx};
  assign split_entry_o = {1'b0, own_idx};

  // ---- one event at a time: first what goes up, then donated nodes, subtrees, leaves, new nodes -------------------
  logic [N-1:0] don_gnt, sub_gnt;
  logic [$clog2(N)-1:0] don_sel, sub_sel;
  logic idle, up_q, up_wanted_q, root_valid_q, don_take, sub_take, leaf_take;
  assign idle      = state_q == IDLE && !up_q;
  rc_rr_arb #(.NumReq(N)) u_don (
    .clk_i, .rst_ni, .req_i(don_valid_i), .ready_i(idle), .gnt_o(don_gnt), .idx_o(don_sel)
  );
  assign don_take  = idle && don_gnt != '0;
  rc_rr_arb #(.NumReq(N)) u_sub (
    .clk_i, .rst_ni, .req_i(sub_valid_i), .ready_i(idle && !don_take), .gnt_o(sub_gnt), .idx_o(sub_sel)
  );
  assign sub_take      = idle && !don_take && sub_gnt != '0;
  assign leaf_take     = idle && !don_take && !sub_take && leaf_valid_i;
  assign don_ready_o   = don_take ? don_gnt : '0;
  assign sub_ready_o   = sub_take ? sub_gnt : '0;
  assign leaf_ready_o  = leaf_take;
  assign split_ready_o = idle && !don_take && !sub_take && !leaf_take && own_valid;

  // ---- entries --------------------------------------------------------------------------------------------------
  entry_t   info, wr_info;
  idx_t     known;
  logic     is_place_q, complete, we_info, we_known, split_take, donated, seen;
  logic [6:0] wr_entry;
  logic [ENTRIES-1:0] seen_q;                        // one of the two that an entry waits for is there
  assign split_take = split_valid_i && split_ready_o;
  assign donated    = event_q.dest.entry[6];
  assign seen       = seen_q[event_q.dest.entry];
  assign complete   = seen || (!donated && (info.split.lower_empty || info.split.upper_empty));
  assign we_info    = split_take || don_take;
  assign we_known   = state_q == ACT && !complete && !is_place_q;
  assign wr_entry   = split_take ? split_entry_o : don_i[don_sel].entry;
  assign wr_info    = split_take ? '{split: split_i, idx: '0}
    : '{split: '{dest: '0, axis: don_i[don_sel].axis, pos: don_i[don_sel].pos, swap: don_i[don_sel].swap,
                 lower_empty: 1'b0, upper_empty: 1'b0}, idx: don_i[don_sel].idx};
  rc_ram_1r1w #(.Width($bits(entry_t)), .Depth(ENTRIES)) u_info (
    .clk_i, .we_i(we_info), .waddr_i(wr_entry), .wdata_i(wr_info),
    .re_i(state_q == READ), .raddr_i(event_q.dest.entry), .rdata_o(info)
  );
  rc_ram_1r1w #(.Width(IDX_W), .Depth(ENTRIES)) u_known (
    .clk_i, .we_i(we_known), .waddr_i(event_q.dest.entry), .wdata_i(event_q.idx),
    .re_i(state_q == READ), .raddr_i(event_q.dest.entry), .rdata_o(known)
  );

  // ---- the node of a complete entry --------------------------------------------------------------------------------
  idx_t  adjacent, own, place_q, slot, wr_idx_q;
  node_t node, leaf_node;
  logic  last_adjacent, only;
  assign only          = info.split.lower_empty || info.split.upper_empty;
  assign last_adjacent = only || event_q.dest.upper == info.split.swap;
  assign adjacent      = last_adjacent ? event_q.idx : known;
  assign own           = donated ? info.idx : adjacent - 1'b1;
  always_comb begin
    node = '{zero: '0, other: last_adjacent ? known : event_q.idx, upper_empty: info.split.upper_empty,
             lower_empty: info.split.lower_empty, swap: info.split.swap, axis: info.split.axis,
             split: to_fp(info.split.pos)};
    if (only) node.other = '0;
    if (donated) node.other = is_place_q ? known : event_q.idx;
    leaf_node = '{zero: '0, other: leaf_q.first, upper_empty: 1'b0, lower_empty: 1'b0, swap: 1'b0, axis: 2'd3,
                  split: FP_W'(leaf_q.count)};
  end
  assign own_free = state_q == ACT && complete && !donated;
  assign don_free = state_q == ACT && complete && donated;

  // ---- leaves: from an extent of their own, downwards, with the gap below ---------------------------------------------
  logic [7:0] left_q;                                // free slots of the extent
  logic       room;
  assign room      = left_q > 8'(leaf_q.gap);
  assign slot      = place_q - 1'b1;
  assign ext_req_o = state_q == ROOM && !room;

  logic [3:0][63:0] words;
  node_t wr_node_q;
  always_comb begin
    words = '0;
    words[wr_idx_q[1:0]] = 64'(wr_node_q);
  end
  assign wr_valid_o = state_q == WRITE;
  assign wr_o = '{kind: WR_NODE, row: 24'(wr_idx_q >> 2), strb: 8'h3 << {wr_idx_q[1:0], 1'b0}, data: words};

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      state_q <= IDLE;
      {up_q, root_valid_q, left_q} <= '0;
    end else begin
      case (state_q)
        IDLE: begin
          if (up_q) begin
            up_q <= 1'b0;
            if (event_q.dest.root) root_valid_q <= 1'b1;
            else state_q <= READ;
          end else if (don_take) begin
            state_q <= READ;
          end else if (sub_take) begin
            if (sub_i[sub_sel].dest.root) root_valid_q <= 1'b1;
            else state_q <= READ;
          end else if (leaf_take) begin
            state_q <= ROOM;
          end
        end
        READ: state_q <= ACT;
        ACT:  state_q <= complete ? WRITE : IDLE;
        ROOM: begin
          if (room) state_q <= PLACE;
          else if (ext_gnt_i) left_q <= 8'(NODE_EXTENT);
        end
        PLACE: begin
          state_q <= WRITE;
          left_q  <= left_q - 8'(leaf_q.gap) - 1'b1;
        end
        default: if (wr_ready_i) begin
          state_q <= IDLE;
          up_q    <= up_wanted_q;
        end
      endcase
    end
    if (up_q && event_q.dest.root) root_o <= event_q.idx;
    if (sub_take && sub_i[sub_sel].dest.root) root_o <= sub_i[sub_sel].idx;
    if (idle) begin
      event_q    <= don_take ? '{dest: '{root: 1'b0, upper: 1'b0, entry: don_i[don_sel].entry}, idx: don_i[don_sel].idx}
                             : sub_i[sub_sel];
      is_place_q <= don_take;
      leaf_q     <= leaf_i;
    end
    if (split_take) seen_q[split_entry_o] <= 1'b0;
    if (ent_take) seen_q[ent_idx_o] <= 1'b0;
    if (state_q == ACT && !complete) seen_q[event_q.dest.entry] <= 1'b1;
    if (state_q == ACT) begin
      {wr_idx_q, wr_node_q} <= {own, node};
      up_wanted_q <= !donated;
      if (complete && !donated) event_q <= '{dest: info.split.dest, idx: own};
    end
    if (ext_req_o && ext_gnt_i) place_q <= ext_idx_i + idx_t'(NODE_EXTENT);
    if (state_q == PLACE) begin
      {wr_idx_q, wr_node_q} <= {slot, leaf_node};
      up_wanted_q <= 1'b1;
      place_q     <= slot - idx_t'(leaf_q.gap);
      event_q     <= '{dest: leaf_q.dest, idx: slot};
      is_place_q  <= 1'b0;
    end
  end
  // A donor may report the root before what it donated is finished.
  assign done_o = root_valid_q && idle && don_left == 5'(DONATED);
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && state_q == ACT && complete && !donated && only) OneChild_A: assert (!seen);
    if (rst_ni && don_take) DonatedEntry_M: assume (don_i[don_sel].entry[6:4] == 3'b100);
  end
`endif
endmodule
