// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Halves of lines the L2 cache has asked memory for ("L2 Addr FIFO", paper Fig. 6) and who waits for each.
// Memory answers in order, so the entries are a ring: allocated at the tail, sent, filled and freed
// in the same order. What was received waits here, since memory cannot be held. An entry remembers in
// which way the line's other half is, so that a line is never in two ways.
module rc_l2_mshr import rc_pkg::*; #(
  parameter  int unsigned NumClients = 8,
  parameter  int unsigned Sets       = 256,  // of the cache, a power of two
  parameter  int unsigned Ways       = 8,
  parameter  int unsigned NumMshr    = 16,   // halves, 2 or more
  localparam int unsigned WayW       = $clog2(Ways)
) (
  input  logic                  clk_i,
  input  logic                  rst_ni,
  // A miss: joins the entry of its half, else takes a new one, if there is one and it may.
  input  logic                  miss_valid_i,
  input  half_addr_t            miss_addr_i,
  input  logic                  miss_there_i,    // the line's other half is in this way
  input  logic [WayW-1:0]       miss_way_i,
  input  logic [NumClients-1:0] miss_client_i,   // one-hot
  input  logic                  miss_may_alloc_i,
  output logic                  miss_merged_o,
  output logic                  miss_alloc_o,    // neither of the two: refused
  output logic                  full_o,
  // Memory.
  output logic                  req_valid_o,
  input  logic                  req_ready_i,
  output half_addr_t            req_addr_o,
  input  logic                  rsp_valid_i,
  input  half_line_t            rsp_half_i,
  // Oldest half received; freed when taken.
  output logic                  fill_valid_o,
  input  logic                  fill_ready_i,
  input  logic [WayW-1:0]       fill_way_i,      // where it is written
  output half_addr_t            fill_addr_o,
  output logic                  fill_there_o,    // its line is in this way
  output logic [WayW-1:0]       fill_place_o,
  output half_line_t            fill_half_o,
  output logic [NumClients-1:0] fill_clients_o,
  output logic                  busy_o
);
  localparam int unsigned IdxW = $clog2(NumMshr);
  localparam int unsigned SetW = $clog2(Sets);
  typedef struct packed {logic there; logic [WayW-1:0] way;} place_t;
  typedef logic [IdxW-1:0] entry_t;
  localparam entry_t LAST = entry_t'(NumMshr - 1);

  half_addr_t [NumMshr-1:0]            addr_q;
  place_t [NumMshr-1:0]                place_q;
  logic [NumMshr-1:0][NumClients-1:0]  clients_q;
  logic [NumMshr-1:0]                  valid_q, unsent_q, match;
  entry_t                              head_q, send_q, tail_q;

  always_comb begin
    match = '0;
    if (miss_valid_i) for (int i = 0; i < NumMshr; i++) match[i] = valid_q[i] && addr_q[i] == miss_addr_i;
  end
  assign full_o        = valid_q[tail_q];
  assign miss_merged_o = match != '0;
  assign miss_alloc_o  = miss_valid_i && !miss_merged_o && !full_o && miss_may_alloc_i;
  assign req_valid_o   = unsent_q[send_q];
  assign req_addr_o    = addr_q[send_q];
  assign busy_o        = valid_q != '0;

  function automatic entry_t next(entry_t i);
    return (i == LAST) ? '0 : i + 1'b1;
  endfunction
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {valid_q, unsent_q, head_q, send_q, tail_q} <= '0;
    end else begin
      if (miss_alloc_o) begin
        valid_q[tail_q]  <= 1'b1;
        unsent_q[tail_q] <= 1'b1;
        tail_q           <= next(tail_q);
      end
      if (req_valid_o && req_ready_i) begin
        unsent_q[send_q] <= 1'b0;
        send_q           <= next(send_q);
      end
      if (fill_valid_o && fill_ready_i) begin
        valid_q[head_q]  <= 1'b0;
        head_q           <= next(head_q);
      end
    end
    if (miss_merged_o) for (int i = 0; i < NumMshr; i++) if (match[i]) clients_q[i] <= clients_q[i] | miss_client_i;
    if (fill_valid_o && fill_ready_i) begin
      for (int i = 0; i < NumMshr; i++) begin    // where the other half is now: there, or overwritten
        if (addr_q[i][HALF_ADDR_W-1:1] == fill_addr_o[HALF_ADDR_W-1:1]) place_q[i] <= '{there: 1'b1, way: fill_way_i};
        else if (addr_q[i][SetW:1] == fill_addr_o[SetW:1] && place_q[i].way == fill_way_i) place_q[i].there <= 1'b0;
      end
    end
    if (miss_alloc_o) begin                      // never of the set that is filled in this cycle
      place_q[tail_q]   <= '{there: miss_there_i, way: miss_way_i};
      addr_q[tail_q]    <= miss_addr_i;
      clients_q[tail_q] <= miss_client_i;
    end
  end

  logic                         line_ready;
  logic [$clog2(NumMshr+1)-1:0] unused_count;
  rc_fifo #(.data_t(half_line_t), .Depth(NumMshr), .Ram(1'b0)) u_lines (
    .clk_i, .rst_ni,
    .in_valid_i(rsp_valid_i), .in_ready_o(line_ready), .in_data_i(rsp_half_i),
    .out_valid_o(fill_valid_o), .out_ready_i(fill_ready_i), .out_data_o(fill_half_o), .count_o(unused_count)
  );
  assign fill_addr_o    = addr_q[head_q];
  assign {fill_there_o, fill_place_o} = place_q[head_q];
  assign fill_clients_o = clients_q[head_q];

`ifndef SYNTHESIS
  logic [$clog2(NumMshr+1)-1:0] waiting_q;   // sent and not answered
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      waiting_q <= '0;
    end else begin
      waiting_q <= waiting_q + $bits(waiting_q)'(req_valid_o && req_ready_i) - $bits(waiting_q)'(rsp_valid_i);
      if (rsp_valid_i) Asked_M: assume (waiting_q != '0);
      if (rsp_valid_i) LineRoom_A: assert (line_ready);
      NoDuplicate_A: assert ($onehot0(match));
      if (fill_valid_o) HeadHasClient_A: assert (valid_q[head_q] && !unsent_q[head_q] && fill_clients_o != '0);
      // A client that joined in the cycle in which its line leaves would wait for ever.
      if (fill_valid_o && fill_ready_i) LateMerge_A: assert (!match[head_q]);
      if (fill_valid_o && fill_ready_i && miss_alloc_o)
        OtherSet_A: assert (miss_addr_i[SetW:1] != fill_addr_o[SetW:1]);
    end
  end
`else
  logic unused_ready;
  assign unused_ready = line_ready;
`endif
endmodule
