// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// L2 cache of a T&I unit, shared by its L1 caches (paper Sec. 3.5, Fig. 6). One lookup a cycle; a
// miss leaves the way free for the lookups behind it (hit under miss, several misses).
//   S0  choose a client (round robin), read the tags of its set
//   S1  compare; take the request: hit, or miss noted in rc_l2_mshr; or refuse it, if that is full
//   S2  the line of the way that hit is read
//   R   line on the way to its clients; it stays until all of them have taken it
// Lines are fetched by halves (rc_l1); a hit delivers the whole line, or what there is of it.
// A client is taken or refused in S1, so it can be there every second cycle; two clients fill the
// pipeline. A half from memory goes to R and into the cache in one cycle, before a hit that waits in
// S2; S0 and S1 hold no lookup of its set then, all others pass.
// Refused clients wait for an entry in turn and hold nobody else up; see docs/memory.md for bounds.
module rc_l2 import rc_pkg::*; #(
  parameter int unsigned NumClients = 8,    // four node/TriAccel and four list caches
  parameter int unsigned Sets       = 256,  // power of two
  parameter int unsigned Ways       = 14,   // 2 or more
  parameter int unsigned NumMshr    = 16    // halves on their way from memory
) (
  input  logic                        clk_i,
  input  logic                        rst_ni,       // empties the cache
  input  logic [NumClients-1:0]       req_valid_i,  // from the L1 caches
  output logic [NumClients-1:0]       req_ready_o,
  input  half_addr_t [NumClients-1:0] req_addr_i,
  output logic [NumClients-1:0]       fill_valid_o, // several at once: it is for all of them
  input  logic [NumClients-1:0]       fill_ready_i,
  output half_addr_t                  fill_addr_o,  // as requested
  output logic                        fill_both_o,  // the line's other half comes along
  output line_t                       fill_line_o,
  output logic                        mem_req_valid_o,
  input  logic                        mem_req_ready_i,
  output half_addr_t                  mem_req_addr_o,
  input  logic                        mem_rsp_valid_i,  // in order of the requests; always taken
  input  half_line_t                  mem_rsp_half_i,
  output logic                        ev_hit_o,
  output logic                        ev_miss_o,        // asked from memory
  output logic                        ev_merge_o,       // was already asked for
  output logic                        busy_o
);
  localparam int unsigned SetW    = $clog2(Sets);
  localparam int unsigned WayW    = $clog2(Ways);
  localparam int unsigned TagW    = LINE_ADDR_W - SetW;
  localparam int unsigned ClientW = (NumClients > 1) ? $clog2(NumClients) : 1;
  typedef logic [SetW-1:0]       set_t;
  typedef logic [TagW-1:0]       tag_t;
  typedef logic [NumClients-1:0] clients_t;

  logic adv;                               // S1 and S2 move

  // ---- half a line from memory: to the way that holds the other half, else to the one that is to go ---
  logic            fill_valid, fill_fire, fill_there;
  half_addr_t      fill_addr;
  half_line_t      fill_half;
  clients_t        fill_clients;
  set_t            fill_set;
  logic [WayW-1:0] fill_way, place_way, victim_way;
  assign fill_set = fill_addr[SetW:1];
  assign fill_way = fill_there ? place_way : victim_way;

  // ---- S0: arbitration and tags --------------------------------------------------------------------
  clients_t             s0_req, s0_gnt, owner;
  clients_t             wait_q;            // refused for want of an entry
  clients_t             s1_client_q;       // one-hot, zero if S1 is empty
  logic [ClientW-1:0]   s0_idx, unused_owner_idx;
  half_addr_t           s0_addr, s1_addr_q;
  logic                 s0_fire, mshr_full, owner_done;
  tag_t [Ways-1:0]      tag;
  assign s0_req  = adv ? req_valid_i & ~s1_client_q & (~wait_q | (mshr_full ? '0 : owner)) : '0;
  assign s0_addr = req_addr_i[s0_idx];
  // A line that waits stops new lookups of its set: so it is written soon, and while nobody reads there.
  assign s0_fire = s0_gnt != '0 && !(fill_valid && s0_addr[SetW:1] == fill_set);
  rc_rr_arb #(.NumReq(NumClients)) u_arb (
    .clk_i, .rst_ni, .req_i(s0_req), .ready_i(s0_fire), .gnt_o(s0_gnt), .idx_o(s0_idx)
  );
  // Only the owner, one of the refused clients in turn, may take the next entry: nobody starves.
  rc_rr_arb #(.NumReq(NumClients)) u_owner (
    .clk_i, .rst_ni, .req_i(wait_q), .ready_i(owner_done), .gnt_o(owner), .idx_o(unused_owner_idx)
  );
  for (genvar w = 0; w < Ways; w++) begin : gen_tag
    rc_ram_1r1w #(.Width(TagW), .Depth(Sets)) u_ram (
      .clk_i,
      .we_i(fill_fire && fill_way == WayW'(w)), .waddr_i(fill_set), .wdata_i(fill_addr[HALF_ADDR_W-1:SetW+1]),
      .re_i(s0_fire), .raddr_i(s0_addr[SetW:1]), .rdata_o(tag[w])
    );
  end

  // ---- S1: hit, miss or refusal --------------------------------------------------------------------
  logic [Sets-1:0][Ways-1:0][1:0] valid_q; // by half
  logic                      s1_valid, s1_hit, s1_miss, s1_taken, merged, alloc;
  set_t                      s1_set;
  logic [WayW-1:0]           s1_way;
  logic [Ways-1:0]           s1_there;
  logic [1:0]                s1_halves;
  assign s1_valid = s1_client_q != '0;
  assign s1_set   = s1_addr_q[SetW:1];
  always_comb begin
    {s1_way, s1_halves} = '0;
    for (int w = 0; w < Ways; w++) begin
      s1_there[w] = s1_valid && valid_q[s1_set][w] != '0 && tag[w] == s1_addr_q[HALF_ADDR_W-1:SetW+1];
      if (s1_there[w]) s1_way |= WayW'(w);
      if (s1_there[w]) s1_halves |= valid_q[s1_set][w];
    end
  end
  assign s1_hit      = adv && s1_halves[s1_addr_q[0]];
  assign s1_miss     = adv && s1_valid && !s1_halves[s1_addr_q[0]];
  assign s1_taken    = s1_hit || merged || alloc;
  assign req_ready_o = s1_taken ? s1_client_q : '0;
  assign owner_done  = s1_taken && (owner & s1_client_q) != '0;
  assign ev_hit_o    = s1_hit;
  assign ev_miss_o   = alloc;
  assign ev_merge_o  = merged;

  rc_l2_mshr #(.NumClients(NumClients), .Sets(Sets), .Ways(Ways), .NumMshr(NumMshr)) u_mshr (
    .clk_i, .rst_ni,
    .miss_valid_i(s1_miss), .miss_addr_i(s1_addr_q), .miss_there_i(s1_there != '0), .miss_way_i(s1_way),
    .miss_client_i(s1_client_q),
    .miss_may_alloc_i(wait_q == '0 || (owner & s1_client_q) != '0),
    .miss_merged_o(merged), .miss_alloc_o(alloc), .full_o(mshr_full),
    .req_valid_o(mem_req_valid_o), .req_ready_i(mem_req_ready_i), .req_addr_o(mem_req_addr_o),
    .rsp_valid_i(mem_rsp_valid_i), .rsp_half_i(mem_rsp_half_i),
    .fill_valid_o(fill_valid), .fill_ready_i(fill_fire), .fill_way_i(fill_way), .fill_addr_o(fill_addr),
    .fill_there_o(fill_there), .fill_place_o(place_way), .fill_half_o(fill_half), .fill_clients_o(fill_clients), .busy_o
  );

  // ---- S2: read one way; R: deliver ------------------------------------------------------------------
  clients_t   s2_client_q, r_client_q;
  half_addr_t s2_addr_q;
  line_t      s2_line;
  logic       s2_both_q, s2_valid, s2_fire, r_free;
  assign s2_valid  = s2_client_q != '0;
  assign r_free    = (r_client_q & ~fill_ready_i) == '0;
  assign fill_fire = fill_valid && r_free && !(s1_valid && s1_set == fill_set);
  assign s2_fire   = s2_valid && r_free && !fill_fire;
  assign adv       = !s2_valid || s2_fire;
  for (genvar h = 0; h < 2; h++) begin : gen_half
    rc_ram_1r1w #(.Width(LINE_W / 2), .Depth(Sets * Ways)) u_ram (
      .clk_i,
      .we_i(fill_fire && fill_addr[0] == 1'(h)), .waddr_i({fill_way, fill_set}), .wdata_i(fill_half),
      .re_i(s1_hit), .raddr_i({s1_way, s1_set}), .rdata_o(s2_line[4*h +: 4])
    );
  end
  assign fill_valid_o = r_client_q;

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {s1_client_q, s2_client_q, r_client_q, wait_q} <= '0;
      valid_q <= '0;
    end else begin
      if (adv) s1_client_q <= s0_fire ? s0_gnt : '0;
      if (adv) s2_client_q <= s1_hit ? s1_client_q : '0;
      if      (fill_fire) r_client_q <= fill_clients;
      else if (s2_fire)   r_client_q <= s2_client_q;
      else                r_client_q <= r_client_q & ~fill_ready_i;
      if (s1_taken)     wait_q <= wait_q & ~s1_client_q;
      else if (s1_miss) wait_q <= wait_q | s1_client_q;
      if (fill_fire) valid_q[fill_set][fill_way] <= (fill_there ? valid_q[fill_set][fill_way] : '0)
                                                    | {fill_addr[0], !fill_addr[0]};
    end
    if (adv) s1_addr_q <= s0_addr;
    if (adv) {s2_addr_q, s2_both_q} <= {s1_addr_q, s1_halves == '1};
    if      (fill_fire) {fill_addr_o, fill_both_o, fill_line_o} <= {fill_addr, 1'b0, {2{fill_half}}};
    else if (s2_fire)   {fill_addr_o, fill_both_o, fill_line_o} <= {s2_addr_q, s2_both_q, s2_line};
  end

  logic [Ways-1:0] fill_used;
  always_comb begin
    for (int w = 0; w < Ways; w++) fill_used[w] = valid_q[fill_set][w] != '0;
  end
  // A hit in the same cycle as a half from memory goes unnoted: one write port is enough.
  rc_l2_victim #(.Sets(Sets), .Ways(Ways)) u_victim (
    .clk_i, .rst_ni,
    .use_valid_i(s1_hit || fill_fire), .use_new_i(fill_fire && !fill_there), .use_set_i(fill_fire ? fill_set : s1_set),
    .use_way_i(fill_fire ? fill_way : s1_way),
    .set_i(fill_set), .valid_i(fill_used), .way_o(victim_way)
  );

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      OneWay_A: assert ($onehot0(s1_there));
      if (s1_miss) NotLost_A: assert (s1_taken || mshr_full || wait_q != '0);
      if ($past(rst_ni && fill_valid_o != '0)) begin
        if ($past(fill_valid_o & ~fill_ready_i) != '0)
          FillHeld_A: assert ((fill_valid_o == $past(fill_valid_o & ~fill_ready_i)) && $stable(fill_line_o)
                              && $stable(fill_addr_o) && $stable(fill_both_o));
      end
    end
  end
  for (genvar c = 0; c < NumClients; c++) begin : gen_held   // not a loop: $past would look at the past of its index
    always_ff @(posedge clk_i) begin
      if (rst_ni && $past(rst_ni && req_valid_i[c] && !req_ready_o[c]))
        ReqHeld_M: assume (req_valid_i[c] && $stable(req_addr_i[c]));
    end
  end
`endif
endmodule
