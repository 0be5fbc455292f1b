// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Texture cache: up to four blocks and four words of them at once, in order, prefetching as rc_ro_cache does (Igehy et al.
// 1998; Hakura and Gupta 1997). Tags have four banks, by parity of a block's column and row: the blocks of a footprint never
// share one. Data have four banks, by parity of a word's column and row: neither do its words. Read-only, two ways, LRU.
//   E0  read the tags of each bank
//   E1  compare; misses take their ways at once, and memory is asked for them, one a cycle; the footprint goes to the queue
//   ... the queue covers the latency of memory
//   H0  head of the queue: for each block missed wait for it and write it in four cycles; then read the words
//   H1  words at the output
// Tags run ahead of the data by what is in the queue, so a way that is taken is overwritten only after all who hit it.
module rc_tex_cache import rc_pkg::*; import rc_tex_pkg::*; #(
  parameter int unsigned Sets    = 32,             // of a bank, power of two, 2 to 256
  parameter int unsigned Depth   = 32,             // footprints in the queue
  parameter int unsigned MaxMiss = 16              // blocks asked for and not yet used, at least 4
) (
  input  logic             clk_i,
  input  logic             rst_ni,                 // empties the cache
  input  logic             in_valid_i,
  output logic             in_ready_o,
  input  tex_blocks_t      in_blocks_i,
  input  tex_sample_t      in_sample_i,
  output logic             out_valid_o,
  input  logic             out_ready_i,
  output logic [3:0][31:0] out_words_o,            // by bank: [0] parity of the word's column, [1] of its row
  output tex_sample_t      out_sample_o,
  output logic             req_valid_o,            // to memory
  input  logic             req_ready_i,
  output line_addr_t       req_addr_o,
  input  logic             rsp_valid_i,            // in order of the requests; always taken
  input  block64_t         rsp_block_i,
  output logic [2:0]       ev_hit_o,               // blocks
  output logic [2:0]       ev_miss_o
);
  localparam int unsigned SetW   = $clog2(Sets);
  localparam int unsigned CountW = $clog2(MaxMiss + 1);
  typedef logic [SetW-1:0]   set_t;
  typedef logic [CountW-1:0] count_t;
  typedef struct packed {logic [1:0] bank; logic way; set_t set;} slot_t;
  typedef struct packed {slot_t slot; logic row_hi; logic col_hi;} data_addr_t;   // word of a bank
  typedef struct packed {logic [3:0] miss; logic [3:0] way; set_t [3:0] set; tex_sample_t sample;} entry_t;
  if (Sets < 2 || Sets > 1 << SET_W || MaxMiss < 4) begin : gen_bad_size
    $error("rc_tex_cache: a parameter is out of range");
  end

  function automatic logic [2:0] count_of(logic [3:0] mask);
    return 3'(mask[0]) + 3'(mask[1]) + 3'(mask[2]) + 3'(mask[3]);
  endfunction
  function automatic logic [1:0] first_of(logic [2:0] mask);   // 3 if none of these
    return (mask[1:0] != '0) ? {1'b0, !mask[0]} : {1'b1, !mask[2]};
  endfunction

  // ---- E0, E1 ----------------------------------------------------------------------------------------------------
  // A footprint is taken in every other cycle at most, so no tag is read while one is written.
  logic        e1_valid_q, e1_go, e0_fire;
  tex_blocks_t e1_blocks_q;
  tex_sample_t e1_sample_q;
  entry_t      e1_entry;
  logic [3:0]  e1_miss, e1_way, ask_q;
  assign in_ready_o = !e1_valid_q;
  assign e0_fire    = in_valid_i && in_ready_o;
  for (genvar b = 0; b < 4; b++) begin : gen_bank
    logic [Sets-1:0][1:0] valid_q;
    logic [Sets-1:0]      lru_q;                   // way to take next
    line_addr_t [1:0]     tag;
    logic [1:0]           match;
    set_t                 set;
    assign set = set_t'(e1_blocks_q.set[b]);
    for (genvar w = 0; w < 2; w++) begin : gen_way
      rc_ram_1r1w #(.Width(LINE_ADDR_W), .Depth(Sets)) u_tag (
        .clk_i,
        .we_i(e1_go && e1_miss[b] && e1_way[b] == 1'(w)), .waddr_i(set), .wdata_i(e1_blocks_q.addr[b]),
        .re_i(e0_fire), .raddr_i(set_t'(in_blocks_i.set[b])), .rdata_o(tag[w])
      );
      assign match[w] = valid_q[set][w] && tag[w] == e1_blocks_q.addr[b];
    end
    assign e1_miss[b] = e1_blocks_q.used[b] && match == '0;
    assign e1_way[b]  = (match != '0) ? match[1] : !valid_q[set][0] ? 1'b0 : !valid_q[set][1] ? 1'b1 : lru_q[set];
    always_ff @(posedge clk_i) begin
      if (!rst_ni) begin
        valid_q <= '0;
      end else if (e1_go && e1_blocks_q.used[b]) begin
        valid_q[set][e1_way[b]] <= 1'b1;
        lru_q[set]              <= !e1_way[b];
      end
    end
`ifndef SYNTHESIS
    always_ff @(posedge clk_i) if (rst_ni && e1_valid_q && e1_blocks_q.used[b]) OneWayHits_A: assert ($onehot0(match));
`endif
  end
  always_comb begin
    e1_entry = '{miss: e1_miss, way: e1_way, set: '0, sample: e1_sample_q};
    for (int b = 0; b < 4; b++) e1_entry.set[b] = set_t'(e1_blocks_q.set[b]);
  end

  // ---- requests: the misses of one footprint, one after the other ---------------------------------------------------
  line_addr_t [3:0] ask_addr_q;
  count_t           open_q;                        // blocks asked for and not yet used
  logic             queue_ready, take_block;
  assign e1_go = e1_valid_q && queue_ready
                 && (e1_miss == '0 || (ask_q == '0 && 32'(open_q) + 32'(count_of(e1_miss)) <= MaxMiss));
  assign req_valid_o = ask_q != '0;
  assign req_addr_o  = ask_addr_q[first_of(ask_q[2:0])];
  assign ev_hit_o    = e1_go ? count_of(e1_blocks_q.used & ~e1_miss) : '0;
  assign ev_miss_o   = e1_go ? count_of(e1_miss) : '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      e1_valid_q <= 1'b0;
      ask_q      <= '0;
      open_q     <= '0;
    end else begin
      e1_valid_q <= e0_fire || (e1_valid_q && !e1_go);
      if (e1_go && e1_miss != '0)          ask_q <= e1_miss;
      else if (req_valid_o && req_ready_i) ask_q <= ask_q & (ask_q - 4'd1);
      open_q     <= open_q + count_t'(ev_miss_o) - count_t'(take_block);
    end
    if (e1_go && e1_miss != '0) ask_addr_q <= e1_blocks_q.addr;
    if (e0_fire) begin
      e1_blocks_q <= in_blocks_i;
      e1_sample_q <= in_sample_i;
    end
  end

  // ---- blocks from memory, and the queue between the halves ------------------------------------------------------
  entry_t            head;
  logic              head_valid, head_fire, block_valid, block_ready;
  logic [15:0][31:0] block;                        // {row, column}
  logic [$clog2(Depth+1)-1:0] unused_queued;
  count_t                     unused_blocks;
  rc_fifo #(.data_t(block64_t), .Depth(MaxMiss), .Ram(1'b0)) u_blocks (
    .clk_i, .rst_ni,
    .in_valid_i(rsp_valid_i), .in_ready_o(block_ready), .in_data_i(rsp_block_i),
    .out_valid_o(block_valid), .out_ready_i(take_block), .out_data_o(block), .count_o(unused_blocks)
  );
  rc_fifo #(.data_t(entry_t), .Depth(Depth)) u_queue (
    .clk_i, .rst_ni,
    .in_valid_i(e1_go), .in_ready_o(queue_ready), .in_data_i(e1_entry),
    .out_valid_o(head_valid), .out_ready_i(head_fire), .out_data_o(head), .count_o(unused_queued)
  );

  // ---- H0: missed blocks first, four words a cycle ------------------------------------------------------------------
  logic [3:0] filled_q, missing;                   // banks of the head that were missed and are there now
  logic [1:0] fill_q, bank;                        // quarter of the block: rows and columns 0 and 1, or 2 and 3
  slot_t      fill_slot;
  logic       fill, h1_free;
  assign missing    = head.miss & ~filled_q;
  assign bank       = first_of(missing[2:0]);
  assign fill_slot  = '{bank: bank, way: head.way[bank], set: head.set[bank]};
  assign fill       = head_valid && missing != '0 && block_valid;
  assign take_block = fill && fill_q == 2'd3;
  assign h1_free    = !out_valid_o || out_ready_i;
  assign head_fire  = head_valid && missing == '0 && h1_free;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      filled_q    <= '0;
      fill_q      <= '0;
      out_valid_o <= 1'b0;
    end else begin
      if (fill)            fill_q <= fill_q + 2'd1;
      if (head_fire)       filled_q <= '0;
      else if (take_block) filled_q[bank] <= 1'b1;
      if (h1_free)         out_valid_o <= head_fire;
    end
    if (head_fire) out_sample_o <= head.sample;
  end

  // ---- data ----------------------------------------------------------------------------------------------------------
  for (genvar b = 0; b < 4; b++) begin : gen_data
    logic       i, j;                              // column and row of the footprint whose word is in this bank
    logic [1:0] at;
    slot_t      slot;
    data_addr_t raddr, waddr;
    assign i     = head.sample.col[0][0] != 1'(b % 2);
    assign j     = head.sample.row[0][0] != 1'(b / 2);
    assign at    = {head.sample.by[j], head.sample.bx[i]};
    assign slot  = '{bank: at, way: head.way[at], set: head.set[at]};
    assign raddr = '{slot: slot, row_hi: head.sample.row[j][1], col_hi: head.sample.col[i][1]};
    assign waddr = '{slot: fill_slot, row_hi: fill_q[1], col_hi: fill_q[0]};
    rc_ram_1r1w #(.Width(32), .Depth(4 * 2 * Sets * 4)) u_ram (
      .clk_i,
      .we_i(fill), .waddr_i(waddr), .wdata_i(block[{fill_q[1], 1'(b / 2), fill_q[0], 1'(b % 2)}]),
      .re_i(head_fire), .raddr_i(raddr), .rdata_o(out_words_o[b])
    );
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && rsp_valid_i) BlockRoom_A: assert (block_ready);
    if (rst_ni) Open_A: assert (32'(open_q) <= MaxMiss);
  end
`else
  logic unused_ready;
  assign unused_ready = block_ready;
`endif
endmodule
