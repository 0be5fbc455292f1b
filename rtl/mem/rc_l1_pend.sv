// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Halves of lines an L1 cache waits for, and the queue of requests to the L2 cache ("L1 Addr FIFO", paper
// Fig. 6). A half is asked for once, however many rays miss it: an entry lives from the first miss
// until the half is written into the cache. It remembers in which way the line's other half is, so that
// a line is never in two ways.
module rc_l1_pend import rc_pkg::*; #(
  parameter int unsigned Sets    = 256,   // of the cache, a power of two
  parameter int unsigned MaxPend = 24     // halves; the rays of a pipeline, then none is ever dropped
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       miss_valid_i,        // a ray missed this half
  input  half_addr_t miss_addr_i,
  input  logic       miss_there_i,        // but its line is in this way
  input  logic       miss_way_i,
  input  logic       fill_valid_i,        // this half came
  input  half_addr_t fill_addr_i,
  output logic       fill_there_o,        // its line is in this way
  output logic       fill_way_o,
  input  logic       free_valid_i,        // it is written into that way, or another if its line was not there
  input  logic       free_way_i,
  output logic       req_valid_o,         // to the L2 cache
  input  logic       req_ready_i,
  output half_addr_t req_addr_o,
  output logic       ev_drop_o,           // table full: the miss is forgotten, the ray asks again
  output logic       busy_o               // a half is waited for
);
  localparam int unsigned SetW = $clog2(Sets);
  typedef struct packed {logic there; logic way;} place_t;
  half_addr_t [MaxPend-1:0] addr_q;
  place_t     [MaxPend-1:0] place_q;
  logic [MaxPend-1:0] valid_q, same_miss, same_fill, alloc;
  logic               known, push, queue_ready;

  // Comparators are looked at only when needed: no cost in hardware, time saved in simulation.
  always_comb begin
    same_miss = '0;
    same_fill = '0;
    {fill_there_o, fill_way_o} = '0;
    if (miss_valid_i) for (int i = 0; i < MaxPend; i++) same_miss[i] = valid_q[i] && addr_q[i] == miss_addr_i;
    if (fill_valid_i) begin
      for (int i = 0; i < MaxPend; i++) begin
        same_fill[i] = valid_q[i] && addr_q[i] == fill_addr_i;
        if (same_fill[i]) {fill_there_o, fill_way_o} |= place_q[i];
      end
    end
  end
  // A half that is freed in this cycle is still known: its data are in the cache from now on, and a
  // miss seen now was looked up before. So there is no moment for a second request.
  assign known     = same_miss != '0;
  assign alloc     = ~valid_q & (valid_q + 1'b1);          // lowest free entry
  assign push      = miss_valid_i && !known && alloc != '0;
  assign ev_drop_o = miss_valid_i && !known && alloc == '0;
  assign busy_o    = valid_q != '0;

  // Where a line's other half is, after what is written now: there, or overwritten.
  function automatic place_t after(place_t place, line_addr_t line, line_addr_t written, logic way);
    if (line == written) return '{there: 1'b1, way: way};
    if (line[SetW-1:0] == written[SetW-1:0] && place.way == way) return '0;
    return place;
  endfunction
  place_t     miss_place;
  line_addr_t fill_line;
  assign fill_line  = fill_addr_i[HALF_ADDR_W-1:1];
  assign miss_place = '{there: miss_there_i, way: miss_way_i};
  always_ff @(posedge clk_i) begin
    if (!rst_ni) valid_q <= '0;
    else         valid_q <= (valid_q & ~(free_valid_i ? same_fill : '0)) | (push ? alloc : '0);
    if (free_valid_i) begin
      for (int i = 0; i < MaxPend; i++)
        place_q[i] <= after(place_q[i], addr_q[i][HALF_ADDR_W-1:1], fill_line, free_way_i);
    end
    if (push) begin
      for (int i = 0; i < MaxPend; i++) begin
        if (alloc[i]) begin
          addr_q[i]  <= miss_addr_i;
          place_q[i] <= !free_valid_i ? miss_place
                        : after(miss_place, miss_addr_i[HALF_ADDR_W-1:1], fill_line, free_way_i);
        end
      end
    end
  end

  logic [$clog2(MaxPend+1)-1:0] unused_count;
  rc_fifo #(.data_t(half_addr_t), .Depth(MaxPend), .Ram(1'b0)) u_queue (
    .clk_i, .rst_ni,
    .in_valid_i(push), .in_ready_o(queue_ready), .in_data_i(miss_addr_i),
    .out_valid_o(req_valid_o), .out_ready_i(req_ready_i), .out_data_o(req_addr_o),
    .count_o(unused_count)
  );

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (push) QueueRoom_A: assert (queue_ready);
      NoDuplicate_A: assert ($onehot0(same_miss) && $onehot0(same_fill));
      if (fill_valid_i) Asked_M: assume (same_fill != '0);   // no half that nobody asked for
    end
  end
`else
  logic unused_ready;
  assign unused_ready = queue_ready;
`endif
endmodule
