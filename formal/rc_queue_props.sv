// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Proof: a queue (rc_fifo, or rc_skid as a queue of two) never loses, invents or reorders a word.
// The solver marks one word of its choice when it goes in; it must come out, unchanged, after exactly the words that
// were in the queue before it. No queue word may come out of an empty queue, and a word in the queue shows up at the
// output within Wait cycles. Any word may be the marked one, hence this holds for all.
// Wrong = 1 claims that the marked word overtakes one other, which must fail.
module rc_queue_props #(
  parameter int unsigned Depth = 4,     // words
  parameter bit          Skid  = 1'b0,  // rc_skid instead of rc_fifo
  parameter bit          Ram   = 1'b0,  // of rc_fifo
  parameter bit          Wrong = 1'b0
) (
  input logic       clk_i,
  input logic       rst_ni,
  input logic       in_valid_i,
  input logic [1:0] in_data_i,
  input logic       out_ready_i,
  input logic       mark_i
);
  typedef logic [1:0] data_t;
  typedef logic [$clog2(Depth + 2)-1:0] count_t;
  localparam int unsigned WAIT = Ram ? 3 : 0;

  logic  in_ready, out_valid, push, pop;
  data_t out_data;

  // What a queue is: a number of words, and the place of the marked one.
  logic       started_q = 1'b0;
  count_t     count_q, ahead_q;         // words inside; of these before the marked one
  logic       marked_q;
  data_t      word_q;
  logic [1:0] idle_q;                   // cycles with a word inside and none at the output

  if (Skid) begin : gen_skid
    rc_skid #(.data_t(data_t)) u_dut (
      .clk_i, .rst_ni, .in_valid_i, .in_ready_o(in_ready), .in_data_i,
      .out_valid_o(out_valid), .out_ready_i, .out_data_o(out_data)
    );
  end else begin : gen_fifo
    logic [$clog2(Depth+1)-1:0] dut_count;
    rc_fifo #(.data_t(data_t), .Depth(Depth), .Ram(Ram)) u_dut (
      .clk_i, .rst_ni, .in_valid_i, .in_ready_o(in_ready), .in_data_i,
      .out_valid_o(out_valid), .out_ready_i, .out_data_o(out_data), .count_o(dut_count)
    );
    always_ff @(posedge clk_i) if (started_q && rst_ni) Count_A: assert (32'(dut_count) == 32'(count_q));
    // The RAM knows no reset: what its ports see in the one cycle before that of the queue is no matter.
    if (Ram) begin : gen_ram
      always_ff @(posedge clk_i) if (!started_q) Unread_M: assume (!u_dut.read);
    end
  end

  assign push = in_valid_i && in_ready;
  assign pop  = out_valid && out_ready_i;
  always_ff @(posedge clk_i) begin
    started_q <= 1'b1;
    if (!rst_ni) begin
      {count_q, marked_q, idle_q} <= '0;
    end else begin
      count_q <= count_q + count_t'(push) - count_t'(pop);
      idle_q  <= (count_q != '0 && !out_valid) ? idle_q + 1'b1 : '0;
      if (push && mark_i && !marked_q) begin
        marked_q <= 1'b1;
        word_q   <= in_data_i;
        ahead_q  <= count_q - count_t'(pop);
      end else if (marked_q && pop) begin
        if (ahead_q == '0) marked_q <= 1'b0;
        ahead_q <= ahead_q - 1'b1;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (!started_q) Reset_M: assume (!rst_ni);
    if (started_q && rst_ni) begin
      if (pop) NoneInvented_A: assert (count_q != '0);
      NoneLost_A: assert (32'(idle_q) <= WAIT && (!(count_q != '0 && !out_valid) || 32'(idle_q) < WAIT));
      Room_A: assert (32'(count_q) <= Depth && (in_ready || count_q != '0));
      if (Wrong) begin
        if (marked_q && pop && ahead_q == count_t'(1)) Overtakes_A: assert (out_data == word_q);
      end else begin
        if (marked_q && pop && ahead_q == '0) InOrder_A: assert (out_data == word_q);
      end
    end
  end
endmodule
