// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Merge sort of a stream (the paper's sorting TBP has such hardware, Sec. 3.7): stable, any length up to that of the
// caller's memory, smaller keys first. docs/merge_sort.md
//   load    one item a cycle; sorted runs of Run items go to side 0 of the memory (rc_run_sort)
//   passes  each merges groups of four runs from one side to the other, one item a cycle, and a few cycles a group
// The caller's memory has two sides of MaxLen items, one read and one write a cycle; the key of an item that is read comes
// with it, RdLat cycles after the read, so that the caller may keep keys elsewhere. How many passes there are follows
// from max_len_i alone: several sorters whose lengths differ a little end on the same side.
module rc_merge_sort #(
  parameter  int unsigned KeyW   = 20,     // bits
  parameter  int unsigned ItemW  = 12,     // bits that go along with a key
  parameter  int unsigned MaxLen = 2560,   // items
  parameter  int unsigned Run    = 16,     // items of a run: power of two
  parameter  int unsigned RdLat  = 2,      // cycles, at least 1
  localparam int unsigned IdxW   = (MaxLen > 1) ? $clog2(MaxLen) : 1,
  localparam int unsigned LenW   = $clog2(MaxLen + 1)
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             start_i,        // a stream begins, and with it the load; only when idle
  input  logic [LenW-1:0]  max_len_i,      // with end_i: not less than the items that came
  input  logic             in_valid_i,     // taken every cycle
  input  logic [KeyW-1:0]  in_key_i,
  input  logic [ItemW-1:0] in_item_i,
  input  logic             end_i,          // no more items: with the last one or later
  output logic             busy_o,         // from start_i until the result lies there
  output logic [LenW-1:0]  len_o,          // items of the result
  output logic             side_o,         // where it lies
  output logic             rd_valid_o,     // memory
  output logic             rd_side_o,
  output logic [IdxW-1:0]  rd_idx_o,
  input  logic [KeyW-1:0]  rd_key_i,       // RdLat cycles later
  input  logic [ItemW-1:0] rd_item_i,
  output logic             wr_valid_o,
  output logic             wr_side_o,
  output logic [IdxW-1:0]  wr_idx_o,
  output logic [KeyW-1:0]  wr_key_o,       // for a memory that keeps keys
  output logic [ItemW-1:0] wr_item_o
);
  localparam int unsigned WAYS  = 4;
  localparam int unsigned DEPTH = RdLat + 3;           // items read ahead of each run: the way round takes so long
  localparam int unsigned LvlW  = $clog2(DEPTH + 1);
  localparam int unsigned PosW  = $clog2(4 * MaxLen + 4 * Run) + 1;   // ends of runs reach beyond the stream's end
  typedef logic [PosW-1:0] pos_t;
  typedef logic [LenW-1:0] len_t;
  typedef logic [LvlW-1:0] lvl_t;
  typedef struct packed {logic [KeyW-1:0] key; logic [ItemW-1:0] item;} word_t;
  if (2 ** $clog2(Run) != Run || RdLat < 1) begin : gen_bad_parameter
    $error("Run must be a power of two, RdLat at least 1");
  end

  typedef enum logic [2:0] {IDLE, LOAD, PASS, GROUP, MERGE} state_e;
  state_e state_q;
  len_t   len_q, max_len_q;
  logic   side_q, ended_q;                 // where the items are read
  pos_t   width_q, group_q;                // length of a run, start of the group

  // ---- load --------------------------------------------------------------------------------------------------------
  logic             run_valid, run_idle;
  logic [KeyW-1:0]  run_key;
  logic [ItemW-1:0] run_item;
  rc_run_sort #(.KeyW(KeyW), .ItemW(ItemW), .Run(Run)) u_run (
    .clk_i, .rst_ni, .in_valid_i, .in_key_i, .in_item_i, .end_i,
    .out_valid_o(run_valid), .out_key_o(run_key), .out_item_o(run_item), .idle_o(run_idle)
  );

  // ---- merge: items of each run are read ahead into a queue; the smallest of the four heads goes out ---------------
  len_t  [WAYS-1:0] left_q, unread_q;      // items of each run that have not gone out; that were not read
  len_t  [WAYS-1:0] part;                  // items of each run of the group that begins
  logic  [WAYS-1:0][IdxW-1:0] ptr_q;       // next one to read
  lvl_t  [WAYS-1:0] level_q;               // items read, on their way or in the queue
  word_t [WAYS-1:0] head;
  logic  [WAYS-1:0] head_valid, has, pop, want, unused_ready;
  logic  [1:0]      rd_way, sel_lo, sel_hi, sel;
  logic             fire, group_done;
  logic [RdLat-1:0]      rd_valid_q;
  logic [RdLat-1:0][1:0] rd_way_q;

  for (genvar w = 0; w < WAYS; w++) begin : gen_way
    logic [$clog2(DEPTH+1)-1:0] unused_count;
    pos_t start;
    assign start   = group_q + pos_t'(w) * width_q;
    assign part[w] = (pos_t'(len_q) <= start) ? '0
                   : (pos_t'(len_q) - start < width_q) ? len_t'(pos_t'(len_q) - start) : len_t'(width_q);
    rc_fifo #(.data_t(word_t), .Depth(DEPTH), .Ram(1'b0)) u_queue (
      .clk_i, .rst_ni,
      .in_valid_i(rd_valid_q[RdLat-1] && rd_way_q[RdLat-1] == 2'(w)), .in_ready_o(unused_ready[w]),
      .in_data_i({rd_key_i, rd_item_i}),
      .out_valid_o(head_valid[w]), .out_ready_i(pop[w]), .out_data_o(head[w]), .count_o(unused_count)
    );
    assign has[w]  = left_q[w] != '0;
    assign pop[w]  = fire && sel == 2'(w);
    assign want[w] = state_q == MERGE && unread_q[w] != '0 && level_q[w] != lvl_t'(DEPTH);
    always_ff @(posedge clk_i) begin
      if (!rst_ni) begin
        level_q[w] <= '0;
      end else if (pop[w] != (rd_valid_o && rd_way == 2'(w))) begin
        level_q[w] <= pop[w] ? level_q[w] - 1'b1 : level_q[w] + 1'b1;
      end
      if (state_q == GROUP) begin
        left_q[w]   <= part[w];
        unread_q[w] <= part[w];
        ptr_q[w]    <= IdxW'(start);
      end else begin
        if (pop[w]) left_q[w] <= left_q[w] - 1'b1;
        if (rd_valid_o && rd_way == 2'(w)) begin
          unread_q[w] <= unread_q[w] - 1'b1;
          ptr_q[w]    <= ptr_q[w] + 1'b1;
        end
      end
    end
  end

  // The run with the fewest items ahead is read next: it is the one that could hold up the others.
  always_comb begin
    rd_way = '0;
    for (int w = WAYS - 1; w >= 0; w--) begin
      if (want[w] && (!want[rd_way] || level_q[w] <= level_q[rd_way])) rd_way = 2'(w);
    end
  end
  assign rd_valid_o = want != '0;
  assign rd_side_o  = side_q;
  assign rd_idx_o   = ptr_q[rd_way];
  always_ff @(posedge clk_i) begin
    rd_valid_q <= rst_ni ? RdLat'({rd_valid_q, rd_valid_o}) : '0;
    rd_way_q   <= (2 * RdLat)'({rd_way_q, rd_way});
  end

  // Of equal keys the one of the earlier run goes first: that is what makes the sort stable.
  assign sel_lo = (has[1] && (!has[0] || head[1].key < head[0].key)) ? 2'd1 : 2'd0;
  assign sel_hi = (has[3] && (!has[2] || head[3].key < head[2].key)) ? 2'd3 : 2'd2;
  assign sel    = (has[sel_hi] && (!has[sel_lo] || head[sel_hi].key < head[sel_lo].key)) ? sel_hi : sel_lo;
  assign fire   = state_q == MERGE && has != '0 && (has & ~head_valid) == '0;
  assign group_done = state_q == MERGE && has == '0;

  // ---- sequence ----------------------------------------------------------------------------------------------------
  logic wr_run, wr_merge;
  assign wr_run   = run_valid;
  assign wr_merge = fire;
  assign busy_o   = state_q != IDLE;
  assign len_o    = len_q;
  assign side_o   = side_q;
  always_ff @(posedge clk_i) begin
    wr_valid_o <= rst_ni && (wr_run || wr_merge);
    wr_side_o  <= (state_q == MERGE) && !side_q;
    wr_key_o   <= wr_run ? run_key : head[sel].key;
    wr_item_o  <= wr_run ? run_item : head[sel].item;
    if (wr_valid_o) wr_idx_o <= wr_idx_o + 1'b1;
    if (start_i || state_q == PASS) wr_idx_o <= '0;
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      state_q <= IDLE;
      ended_q <= 1'b0;
    end else begin
      unique case (state_q)
        IDLE:  if (start_i) state_q <= LOAD;
        LOAD:  if (ended_q && run_idle) state_q <= PASS;
        PASS:  if (wr_valid_o) state_q <= PASS;                    // what goes out last is written
               else if (width_q >= pos_t'(max_len_q)) state_q <= IDLE;
               else if (len_q == '0) state_q <= PASS;              // an empty stream still changes sides
               else state_q <= GROUP;
        GROUP: state_q <= MERGE;
        MERGE: if (group_done) state_q <= (group_q + (width_q << 2) >= pos_t'(len_q)) ? PASS : GROUP;
        default: state_q <= IDLE;
      endcase
      if (start_i) ended_q <= 1'b0;
      else if (end_i) ended_q <= 1'b1;
    end
    if (start_i) begin
      len_q   <= '0;
      side_q  <= 1'b0;
      width_q <= pos_t'(Run);
    end
    if (end_i) max_len_q <= max_len_i;
    if (in_valid_i) len_q <= len_q + 1'b1;
    group_q <= (state_q == PASS) ? '0 : (group_done) ? group_q + (width_q << 2) : group_q;
    if ((group_done && group_q + (width_q << 2) >= pos_t'(len_q))
        || (state_q == PASS && len_q == '0 && width_q < pos_t'(max_len_q))) begin
      side_q  <= !side_q;
      width_q <= width_q << 2;
    end
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (start_i) StartIdle_M: assume (state_q == IDLE && run_idle);
      if (in_valid_i) LoadOpen_M: assume (state_q == LOAD && !ended_q && 32'(len_q) < MaxLen);
      if (end_i) Bound_M: assume (max_len_i >= len_q + len_t'(in_valid_i) && 32'(max_len_i) <= MaxLen);
      if (wr_valid_o) InStream_A: assert (len_t'(wr_idx_o) < len_q);
      if (rd_valid_q[RdLat-1]) QueueRoom_A: assert (unused_ready[rd_way_q[RdLat-1]]);
      if (state_q == GROUP) QueuesEmpty_A: assert (head_valid == '0 && rd_valid_q == '0);
    end
  end
`endif
endmodule
