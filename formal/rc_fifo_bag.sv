// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Stand-in for rc_fifo in proofs where all words of a queue differ (asserted) and their order does not matter: a set, of which
// the solver chooses the word that comes next. So a proof holds for queues in any order, and needs no pointers.
module rc_fifo #(
  parameter  type         data_t = logic [1:0],
  parameter  int unsigned Depth  = 4,
  parameter  bit          Ram    = 1'b0,
  parameter  int unsigned Salt   = 0,              // which of the solver's inputs chooses (set by the harness)
  localparam int unsigned CountW = $clog2(Depth + 1)
) (
  input  logic              clk_i,
  input  logic              rst_ni,
  input  logic              in_valid_i,
  output logic              in_ready_o,
  input  data_t             in_data_i,
  output logic              out_valid_o,
  input  logic              out_ready_i,
  output data_t             out_data_o,
  output logic [CountW-1:0] count_o
);
  localparam int unsigned W = $bits(data_t);
  logic [2**W-1:0] bag_q, bag_d;
  logic [W-1:0]    choice, word_q;
  logic            valid_q, push, pop;
  assign choice      = rc_sec_stack_props.choice_i[Salt][W-1:0];
  assign out_valid_o = valid_q;
  assign out_data_o  = word_q;
  assign push        = in_valid_i && in_ready_o;
  assign pop         = valid_q && out_ready_i;
  assign in_ready_o  = 32'(count_o) != Depth;
  always_comb begin
    bag_d = bag_q;
    if (pop) bag_d[word_q] = 1'b0;
    if (push) bag_d[in_data_i] = 1'b1;
    count_o = '0;
    for (int i = 0; i < 2**W; i++) count_o += CountW'(bag_q[i]);
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {bag_q, valid_q} <= '0;
    end else begin
      bag_q <= bag_d;
      if (!valid_q || pop) begin
        valid_q <= bag_d != '0;
        word_q  <= choice;
      end
      Choice_M:   assume (bag_d == '0 || bag_d[choice]);
      Distinct_A: assert (!push || !bag_q[in_data_i]);
      Word_A:     assert (!valid_q || bag_q[word_q]);
    end
  end
endmodule
