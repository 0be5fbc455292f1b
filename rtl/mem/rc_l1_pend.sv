// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Lines an L1 cache waits for, and the queue of requests to the L2 cache ("L1 Addr FIFO", paper
// Fig. 6). A line is asked for once, however many rays miss it: an entry lives from the first miss
// until the line is written into the cache.
module rc_l1_pend import rc_pkg::*; #(
  parameter int unsigned MaxPend = 24     // lines; the rays of a pipeline, then none is ever dropped
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       miss_valid_i,        // a ray missed this line
  input  line_addr_t miss_addr_i,
  input  logic       free_valid_i,        // this line is written into the cache
  input  line_addr_t free_addr_i,
  output logic       req_valid_o,         // to the L2 cache
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  output logic       ev_drop_o,           // table full: the miss is forgotten, the ray asks again
  output logic       busy_o               // a line is waited for
);
  line_addr_t [MaxPend-1:0] addr_q;
  logic [MaxPend-1:0] valid_q, same_miss, same_free, alloc;
  logic               known, push, queue_ready;

  // Comparators are looked at only when needed: no cost in hardware, time saved in simulation.
  always_comb begin
    same_miss = '0;
    same_free = '0;
    if (miss_valid_i) for (int i = 0; i < MaxPend; i++) same_miss[i] = valid_q[i] && addr_q[i] == miss_addr_i;
    if (free_valid_i) for (int i = 0; i < MaxPend; i++) same_free[i] = valid_q[i] && addr_q[i] == free_addr_i;
  end
  // A line that is freed in this cycle is still known: its data are in the cache from now on, and a
  // miss seen now was looked up before. So there is no moment for a second request.
  assign known     = same_miss != '0;
  assign alloc     = ~valid_q & (valid_q + 1'b1);          // lowest free entry
  assign push      = miss_valid_i && !known && alloc != '0;
  assign ev_drop_o = miss_valid_i && !known && alloc == '0;
  assign busy_o    = valid_q != '0;

  always_ff @(posedge clk_i) begin
    if (!rst_ni) valid_q <= '0;
    else         valid_q <= (valid_q & ~same_free) | (push ? alloc : '0);
    if (push) for (int i = 0; i < MaxPend; i++) if (alloc[i]) addr_q[i] <= miss_addr_i;
  end

  logic [$clog2(MaxPend+1)-1:0] unused_count;
  rc_fifo #(.data_t(line_addr_t), .Depth(MaxPend), .Ram(1'b0)) u_queue (
    .clk_i, .rst_ni,
    .in_valid_i(push), .in_ready_o(queue_ready), .in_data_i(miss_addr_i),
    .out_valid_o(req_valid_o), .out_ready_i(req_ready_i), .out_data_o(req_addr_o),
    .count_o(unused_count)
  );

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (push) QueueRoom_A: assert (queue_ready);
      NoDuplicate_A: assert ($onehot0(same_miss) && $onehot0(same_free));
      if (free_valid_i) Asked_M: assume (same_free != '0);   // no line that nobody asked for
    end
  end
`else
  logic unused_ready;
  assign unused_ready = queue_ready;
`endif
endmodule
