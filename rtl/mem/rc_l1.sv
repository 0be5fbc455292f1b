// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// L1 cache of a T&I pipeline, "looping for the next chance" (paper Sec. 3.5, Fig. 6): one lookup a
// cycle, never stalls. A ray that misses goes on idle and looks again in its next loop; meanwhile
// what it wants is fetched, once.
//   S0  read tag and line of all ways
//   S1  compare; hit and line, or miss and request
// A line is 64 bytes, but is fetched by halves: rays that part soon leave much of a line unread. What else the
// L2 cache has of the line comes along.
// A fill writes between lookups. It never waits for them: a lookup of the same set in the cycle of
// the write misses without a request (conflict).
//
// Against livelock, which the paper does not mention: rays that need more lines of a set than it has
// ways could evict each other's lines for ever. A filled line is locked until it was hit once or at
// least Lock cycles passed; a fill that finds all ways locked waits, at most 2 * Lock cycles.
module rc_l1 import rc_pkg::*; #(
  parameter int unsigned Sets     = 256,   // power of two
  parameter int unsigned Ways     = 2,     // 1 or 2
  parameter int unsigned MaxPend  = 24,    // halves asked for; at least the rays in the pipeline
  parameter int unsigned FillFifo = 2,     // fills received and not yet written
  parameter int unsigned Lock     = 64     // cycles, longer than a ray's loop; 0: no protection
) (
  input  logic       clk_i,
  input  logic       rst_ni,               // empties the cache
  input  logic       lookup_valid_i,       // S0
  input  half_addr_t lookup_addr_i,
  output logic       hit_o,                // S1: also the event that is counted
  output logic       miss_o,               // S1: lookup without hit
  output line_t      line_o,               // S1, valid if hit_o:
  output logic [1:0] halves_o,             //     these halves of it, the one asked for among them
  output logic       req_valid_o,          // to the L2 cache
  input  logic       req_ready_i,
  output half_addr_t req_addr_o,
  input  logic       fill_valid_i,         // from the L2 cache
  output logic       fill_ready_o,
  input  half_addr_t fill_addr_i,          // as requested
  input  logic       fill_both_i,          // the other half came along
  input  line_t      fill_line_i,
  output logic       ev_conflict_o,        // part of the misses: met a fill of its set
  output logic       ev_drop_o,            // part of the misses: no entry left, not asked for
  output logic       ev_locked_o,          // a fill waits for a locked set
  output logic       busy_o                // fills are on their way
);
  localparam int unsigned SetW = $clog2(Sets);
  localparam int unsigned TagW = LINE_ADDR_W - SetW;
  typedef logic [SetW-1:0] set_t;
  typedef logic [TagW-1:0] tag_t;
  typedef struct packed {half_addr_t addr; logic both; line_t line;} fill_t;
  if (Ways != 1 && Ways != 2) begin : gen_bad_ways
    $error("Ways must be 1 or 2");
  end

  logic [Sets-1:0][Ways-1:0][1:0] valid_q; // by half
  logic [Sets-1:0][Ways-1:0] locked_q;     // may not be evicted
  logic [Sets-1:0][Ways-1:0] fresh_q;      // filled since the last tick of the lock's timer
  logic [Sets-1:0]           lru_q;        // way to evict next

  // ---- fill: the oldest one received goes to its line's other half, else to an invalid way, else to one that may be
  //      evicted
  fill_t fill;
  set_t  fill_set;
  logic  fill_valid, fill_open, fill_fire, fill_there, place_way;
  logic [0:0]      fill_way;
  logic [1:0]      fill_halves;
  logic [Ways-1:0] fill_used, fill_lock;
  logic [$clog2(FillFifo+1)-1:0] unused_count;
  rc_fifo #(.data_t(fill_t), .Depth(FillFifo), .Ram(1'b0)) u_fill (
    .clk_i, .rst_ni,
    .in_valid_i(fill_valid_i), .in_ready_o(fill_ready_o), .in_data_i({fill_addr_i, fill_both_i, fill_line_i}),
    .out_valid_o(fill_valid), .out_ready_i(fill_open), .out_data_o(fill), .count_o(unused_count)
  );
  assign fill_set    = fill.addr[SetW:1];
  assign fill_halves = {fill.both || fill.addr[0], fill.both || !fill.addr[0]};
  assign fill_lock   = fill_used & locked_q[fill_set];
  assign fill_open   = fill_there || fill_lock != '1;
  assign fill_fire = fill_valid && fill_open;
  always_comb begin
    for (int w = 0; w < Ways; w++) fill_used[w] = valid_q[fill_set][w] != '0;
  end
  always_comb begin
    if      (fill_there)         fill_way = place_way;
    else if (!fill_used[0])      fill_way = 1'b0;
    else if (!fill_used[Ways-1]) fill_way = 1'(Ways - 1);
    else if (fill_lock[0])       fill_way = 1'(Ways - 1);
    else if (fill_lock[Ways-1])  fill_way = 1'b0;
    else                         fill_way = (Ways == 1) ? 1'b0 : lru_q[fill_set];
  end
  assign ev_locked_o = fill_valid && !fill_open;

  // ---- S0: read --------------------------------------------------------------------------------
  set_t lookup_set;
  logic conflict;
  tag_t  [Ways-1:0] tag;
  line_t [Ways-1:0] line;
  assign lookup_set = lookup_addr_i[SetW:1];
  assign conflict   = fill_fire && lookup_set == fill_set;
  for (genvar w = 0; w < Ways; w++) begin : gen_way
    rc_ram_1r1w #(.Width(TagW), .Depth(Sets)) u_tag (
      .clk_i,
      .we_i(fill_fire && fill_way == 1'(w)), .waddr_i(fill_set), .wdata_i(fill.addr[HALF_ADDR_W-1:SetW+1]),
      .re_i(lookup_valid_i && !conflict), .raddr_i(lookup_set), .rdata_o(tag[w])
    );
    for (genvar h = 0; h < 2; h++) begin : gen_half
      rc_ram_1r1w #(.Width(LINE_W / 2), .Depth(Sets)) u_ram (
        .clk_i,
        .we_i(fill_fire && fill_way == 1'(w) && fill_halves[h]), .waddr_i(fill_set), .wdata_i(fill.line[4*h +: 4]),
        .re_i(lookup_valid_i && !conflict), .raddr_i(lookup_set), .rdata_o(line[w][4*h +: 4])
      );
    end
  end

  // ---- S1: compare -----------------------------------------------------------------------------
  logic            s1_valid_q, s1_conflict_q;
  half_addr_t      s1_addr_q;
  set_t            s1_set;
  logic [Ways-1:0] there, match;           // the line, the half
  assign s1_set = s1_addr_q[SetW:1];
  always_ff @(posedge clk_i) begin
    s1_valid_q    <= rst_ni && lookup_valid_i;
    s1_conflict_q <= conflict;
    s1_addr_q     <= lookup_addr_i;
  end
  always_comb begin
    for (int w = 0; w < Ways; w++) begin
      there[w] = s1_valid_q && !s1_conflict_q && valid_q[s1_set][w] != '0 && tag[w] == s1_addr_q[HALF_ADDR_W-1:SetW+1];
      match[w] = there[w] && valid_q[s1_set][w][s1_addr_q[0]];
    end
  end
  assign hit_o         = match != '0;
  assign miss_o        = s1_valid_q && !hit_o;
  assign line_o        = match[Ways-1] ? line[Ways-1] : line[0];
  assign halves_o      = match[Ways-1] ? valid_q[s1_set][Ways-1] : valid_q[s1_set][0];
  assign ev_conflict_o = s1_valid_q && s1_conflict_q;

  rc_l1_pend #(.Sets(Sets), .MaxPend(MaxPend)) u_pend (
    .clk_i, .rst_ni,
    .miss_valid_i(miss_o && !s1_conflict_q), .miss_addr_i(s1_addr_q),
    .miss_there_i(there != '0), .miss_way_i(Ways == 2 && there[Ways-1]),
    .fill_valid_i(fill_valid), .fill_addr_i(fill.addr), .fill_there_o(fill_there), .fill_way_o(place_way),
    .free_valid_i(fill_fire), .free_way_i(fill_way),
    .req_valid_o, .req_ready_i, .req_addr_o, .ev_drop_o, .busy_o
  );

  // ---- state of the lines ------------------------------------------------------------------------
  // A locked line sees two ticks before its lock ends: Lock to 2 * Lock cycles.
  localparam int unsigned TimerW = (Lock > 1) ? $clog2(Lock) : 1;
  logic [TimerW-1:0] timer_q;
  logic              tick;
  assign tick = timer_q == TimerW'(Lock - 1);
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      valid_q  <= '0;
      locked_q <= '0;
      fresh_q  <= '0;
      timer_q  <= '0;
    end else begin
      timer_q <= tick ? '0 : timer_q + 1'b1;
      if (tick) begin
        locked_q <= locked_q & fresh_q;
        fresh_q  <= '0;
      end
      if (hit_o) begin
        locked_q[s1_set] <= locked_q[s1_set] & ~match & (tick ? fresh_q[s1_set] : '1);
        lru_q[s1_set]    <= match[0];      // the way that was not hit
      end
      if (fill_fire) begin                 // last: a new line wins over what is said of the old one
        valid_q[fill_set][fill_way]  <= fill_halves | (fill_there ? valid_q[fill_set][fill_way] : '0);
        locked_q[fill_set][fill_way] <= Lock != 0;
        fresh_q[fill_set][fill_way]  <= Lock != 0;
        lru_q[fill_set]              <= !fill_way;
      end
    end
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) if (rst_ni) OneWay_A: assert ($onehot0(there));
`endif
endmodule
