// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Memory of lists that grow towards each other: list A from the bottom up, list B from the top down. One word is read a
// cycle, and one is written to each list: even and odd places are RAMs of their own, and a list that finds the other one in
// its RAM waits in a queue for a cycle, after which they alternate. rdata_o follows re_i by one cycle.
module rc_tbp_list import rc_tbp_sort_pkg::*; #(
  parameter int unsigned Width = 12,       // bits
  parameter int unsigned Depth = 5120      // words, even
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             re_i,
  input  ptr_t             rptr_i,
  output logic [Width-1:0] rdata_o,
  input  logic [1:0]            wr_valid_i,  // [0] A, [1] B
  input  ptr_t [1:0]            wr_ptr_i,    // each list in order, up or down, or from anywhere anew
  input  logic [1:0][Width-1:0] wr_data_i,
  output logic             room_o,           // six more words of each list may come
  output logic             idle_o            // all is written
);
  localparam int unsigned QUEUE = 12;
  localparam int unsigned AddrW = $clog2(Depth / 2);
  typedef struct packed {ptr_t ptr; logic [Width-1:0] data;} word_t;

  logic  [1:0]            valid, take, bank, in_ready;
  word_t [1:0]            word;
  logic  [1:0][$clog2(QUEUE+1)-1:0] count;
  logic  [1:0][Width-1:0] rdata;
  logic                   rbank_q, clash, first;
  for (genvar i = 0; i < 2; i++) begin : gen_side
    rc_fifo #(.data_t(word_t), .Depth(QUEUE), .Ram(1'b0)) u_queue (
      .clk_i, .rst_ni,
      .in_valid_i(wr_valid_i[i]), .in_ready_o(in_ready[i]), .in_data_i({wr_ptr_i[i], wr_data_i[i]}),
      .out_valid_o(valid[i]), .out_ready_i(take[i]), .out_data_o(word[i]), .count_o(count[i])
    );
    assign bank[i] = word[i].ptr[0];
    logic [1:0] put;                       // the words that go to RAM i
    assign put[0] = take[0] && bank[0] == 1'(i);
    assign put[1] = take[1] && bank[1] == 1'(i);
    word_t mine;
    assign mine = put[0] ? word[0] : word[1];
    rc_ram_1r1w #(.Width(Width), .Depth(Depth / 2)) u_ram (
      .clk_i, .we_i(put != '0), .waddr_i(mine.ptr[AddrW:1]), .wdata_i(mine.data),
      .re_i(re_i && rptr_i[0] == 1'(i)), .raddr_i(rptr_i[AddrW:1]), .rdata_o(rdata[i])
    );
  end
  assign clash   = valid == 2'b11 && bank[0] == bank[1];
  assign first   = count[1] > count[0];    // the longer queue goes first
  assign take[0] = valid[0] && !(clash && first);
  assign take[1] = valid[1] && !(clash && !first);
  assign rdata_o = rdata[rbank_q];
  assign room_o  = 32'(count[0]) <= QUEUE - 6 && 32'(count[1]) <= QUEUE - 6;
  assign idle_o  = valid == '0;
  always_ff @(posedge clk_i) if (re_i) rbank_q <= rptr_i[0];
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      for (int i = 0; i < 2; i++) begin
        if (wr_valid_i[i]) begin
          Room_M: assume (in_ready[i]);
          Inside_A: assert (32'(wr_ptr_i[i]) < Depth);
        end
      end
      if (re_i) ReadInside_A: assert (32'(rptr_i) < Depth);
    end
  end
`endif
endmodule
