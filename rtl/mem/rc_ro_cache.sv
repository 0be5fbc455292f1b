// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Read-only cache that answers in order and prefetches, after Igehy, Eldridge and Proudfoot,
// "Prefetching in a Texture Cache Architecture" (1998). Holds triangle information (paper Sec. 3.6).
//   E0  read the tags of the set
//   E1  compare; a miss takes its way at once and asks memory; either way into the queue
//   ... the queue covers the latency of memory
//   H0  head of the queue: read the line, or wait for it from memory and write it
//   H1  line and payload at the output
// Tags run ahead of the data by exactly what is in the queue, so a way that a later request takes
// is overwritten only after every earlier request has read it: no checks are needed.
module rc_ro_cache import rc_pkg::*; #(
  parameter type         data_t   = logic [7:0],   // payload that travels with a request
  parameter int unsigned Sets     = 256,           // power of two
  parameter int unsigned Ways     = 2,             // 1 or 2
  parameter int unsigned Depth    = 32,            // requests in the queue
  parameter int unsigned MaxMiss  = 8              // lines asked for and not yet used
) (
  input  logic       clk_i,
  input  logic       rst_ni,                       // empties the cache
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  line_addr_t in_addr_i,
  input  data_t      in_data_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output line_t      out_line_o,
  output data_t      out_data_o,
  output logic       req_valid_o,                  // to memory
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,                  // in order of the requests; always taken
  input  line_t      rsp_line_i,
  output logic       ev_hit_o,
  output logic       ev_miss_o
);
  localparam int unsigned SetW   = $clog2(Sets);
  localparam int unsigned TagW   = LINE_ADDR_W - SetW;
  localparam int unsigned SlotW  = $clog2(Sets * Ways);
  localparam int unsigned CountW = $clog2(MaxMiss + 1);
  typedef logic [SetW-1:0]   set_t;
  typedef logic [TagW-1:0]   tag_t;
  typedef logic [SlotW-1:0]  slot_t;
  typedef struct packed {slot_t slot; logic miss; data_t data;} entry_t;
  if (Ways != 1 && Ways != 2) begin : gen_bad_ways
    $error("Ways must be 1 or 2");
  end

  // ---- E0: read the tags, unless the request before is about to write them ---------------------------
  logic       e1_valid_q, e1_done, e1_miss, e0_fire;
  line_addr_t e1_addr_q;
  data_t      e1_data_q;
  set_t       e1_set;
  logic [0:0] e1_way;
  tag_t [Ways-1:0] tag;
  assign in_ready_o = !e1_valid_q || (e1_done && !(e1_miss && in_addr_i[SetW-1:0] == e1_set));
  assign e0_fire    = in_valid_i && in_ready_o;
  for (genvar w = 0; w < Ways; w++) begin : gen_tag
    rc_ram_1r1w #(.Width(TagW), .Depth(Sets)) u_ram (
      .clk_i,
      .we_i(e1_done && e1_miss && e1_way == 1'(w)), .waddr_i(e1_set), .wdata_i(e1_addr_q[LINE_ADDR_W-1:SetW]),
      .re_i(e0_fire), .raddr_i(in_addr_i[SetW-1:0]), .rdata_o(tag[w])
    );
  end

  // ---- E1: compare -------------------------------------------------------------------------------------
  logic [Sets-1:0][Ways-1:0] valid_q;
  logic [Sets-1:0]           lru_q;                // way to take next
  logic [Ways-1:0]           match;
  logic [CountW-1:0]         open_q;               // misses whose line has not been used
  logic                      queue_ready, take_line;
  entry_t                    e1_entry;
  assign e1_set = e1_addr_q[SetW-1:0];
  always_comb begin
    for (int w = 0; w < Ways; w++)
      match[w] = valid_q[e1_set][w] && tag[w] == e1_addr_q[LINE_ADDR_W-1:SetW];
    if      (match != '0)              e1_way = 1'(match[Ways-1] && Ways == 2);
    else if (!valid_q[e1_set][0])      e1_way = 1'b0;
    else if (!valid_q[e1_set][Ways-1]) e1_way = 1'(Ways - 1);
    else                               e1_way = (Ways == 1) ? 1'b0 : lru_q[e1_set];
  end
  assign e1_miss  = match == '0;
  assign e1_done  = e1_valid_q && queue_ready && !(e1_miss && open_q == CountW'(MaxMiss));
  assign e1_entry = '{slot: slot_t'({e1_way, e1_set}), miss: e1_miss, data: e1_data_q};
  assign ev_hit_o  = e1_done && !e1_miss;
  assign ev_miss_o = e1_done && e1_miss;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      e1_valid_q <= 1'b0;
      valid_q    <= '0;
      open_q     <= '0;
    end else begin
      e1_valid_q <= e0_fire || (e1_valid_q && !e1_done);
      open_q     <= open_q + CountW'(ev_miss_o) - CountW'(take_line);
      if (e1_done) begin
        valid_q[e1_set][e1_way] <= 1'b1;
        lru_q[e1_set]           <= !e1_way;
      end
    end
    if (e0_fire) begin
      e1_addr_q <= in_addr_i;
      e1_data_q <= in_data_i;
    end
  end

  // ---- requests, lines and the queue between the halves ----------------------------------------------
  entry_t head;
  logic   head_valid, head_fire, line_valid, ask_ready, line_ready;
  line_t  new_line;
  logic [$clog2(Depth+1)-1:0] unused_queued;
  logic [CountW-1:0]          unused_asked, unused_lines;
  rc_fifo #(.data_t(line_addr_t), .Depth(MaxMiss), .Ram(1'b0)) u_ask (
    .clk_i, .rst_ni,
    .in_valid_i(ev_miss_o), .in_ready_o(ask_ready), .in_data_i(e1_addr_q),
    .out_valid_o(req_valid_o), .out_ready_i(req_ready_i), .out_data_o(req_addr_o), .count_o(unused_asked)
  );
  rc_fifo #(.data_t(line_t), .Depth(MaxMiss), .Ram(1'b0)) u_lines (
    .clk_i, .rst_ni,
    .in_valid_i(rsp_valid_i), .in_ready_o(line_ready), .in_data_i(rsp_line_i),
    .out_valid_o(line_valid), .out_ready_i(take_line), .out_data_o(new_line), .count_o(unused_lines)
  );
  rc_fifo #(.data_t(entry_t), .Depth(Depth)) u_queue (
    .clk_i, .rst_ni,
    .in_valid_i(e1_done), .in_ready_o(queue_ready), .in_data_i(e1_entry),
    .out_valid_o(head_valid), .out_ready_i(head_fire), .out_data_o(head), .count_o(unused_queued)
  );

  // ---- H0, H1: the line ----------------------------------------------------------------------------------
  line_t h1_line, h1_new_q;
  logic  h1_miss_q, h1_free;
  assign h1_free   = !out_valid_o || out_ready_i;
  assign head_fire = head_valid && h1_free && (!head.miss || line_valid);
  assign take_line = head_fire && head.miss;
  rc_ram_1r1w #(.Width(LINE_W), .Depth(Sets * Ways)) u_data (
    .clk_i,
    .we_i(take_line), .waddr_i(head.slot), .wdata_i(new_line),
    .re_i(head_fire && !head.miss), .raddr_i(head.slot), .rdata_o(h1_line)
  );
  always_ff @(posedge clk_i) begin
    if (!rst_ni)      out_valid_o <= 1'b0;
    else if (h1_free) out_valid_o <= head_fire;
    if (head_fire) begin
      h1_miss_q  <= head.miss;
      h1_new_q   <= new_line;
      out_data_o <= head.data;
    end
  end
  assign out_line_o = h1_miss_q ? h1_new_q : h1_line;

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (e1_valid_q)  OneWayHits_A: assert ($onehot0(match));
      if (ev_miss_o)   AskRoom_A:    assert (ask_ready);
      if (rsp_valid_i) LineRoom_A:   assert (line_ready);
    end
  end
`else
  logic unused_ready;
  assign unused_ready = &{ask_ready, line_ready};
`endif
endmodule
