// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Sorts a stream into runs of Run items on the way, one item a cycle without a pause: an insertion sorter. While a
// finished run leaves from the front, the items of the next one are sorted in behind it; a tag tells the two apart.
//   in    taken every cycle; smaller keys come first, equal keys keep their order
//   out   a run leaves, one item a cycle, from the cycle after its last item came; the last run of a stream may be shorter
module rc_run_sort #(
  parameter int unsigned KeyW  = 20,       // bits
  parameter int unsigned ItemW = 12,       // bits that go along with a key
  parameter int unsigned Run   = 16        // items
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             in_valid_i,
  input  logic [KeyW-1:0]  in_key_i,
  input  logic [ItemW-1:0] in_item_i,
  input  logic             end_i,          // no more items: with the last one or later
  output logic             out_valid_o,
  output logic [KeyW-1:0]  out_key_o,
  output logic [ItemW-1:0] out_item_o,
  output logic             idle_o          // nothing is inside
);
  localparam int unsigned CountW = $clog2(Run + 1);
  typedef logic [CountW-1:0] count_t;
  typedef struct packed {logic valid; logic tag; logic [KeyW-1:0] key; logic [ItemW-1:0] item;} entry_t;

  entry_t [Run-1:0] e_q;
  entry_t [Run-1:0] rest;                  // what stays after the front one has left
  entry_t           fresh;
  logic   [Run-1:0] ahead;                // stays before the new item
  count_t           count_q, leave_q;      // items of the run that is being sorted; of the one that leaves
  logic             tag_q, end_q, full, close;

  assign out_valid_o = leave_q != '0;
  assign out_key_o   = e_q[0].key;
  assign out_item_o  = e_q[0].item;
  assign idle_o      = count_q == '0 && leave_q == '0;
  assign full        = in_valid_i && count_q == count_t'(Run - 1);
  assign close       = end_q && count_q != '0 && leave_q <= count_t'(1);   // the run ends early
  assign fresh       = {1'b1, tag_q, in_key_i, in_item_i};

  for (genvar i = 0; i < Run; i++) begin : gen_entry
    if (i == Run - 1) begin : gen_last
      assign rest[i] = out_valid_o ? '0 : e_q[i];
    end else begin : gen_mid
      assign rest[i] = out_valid_o ? e_q[i+1] : e_q[i];
    end
    assign ahead[i] = rest[i].valid && (rest[i].tag != tag_q || rest[i].key <= in_key_i);
    always_ff @(posedge clk_i) begin
      if (!rst_ni) begin
        e_q[i].valid <= 1'b0;
      end else begin
        if (!in_valid_i || ahead[i])      e_q[i] <= rest[i];
        else if (i == 0 || ahead[(i == 0) ? 0 : i-1]) e_q[i] <= fresh;
        else                               e_q[i] <= rest[(i == 0) ? 0 : i-1];
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {count_q, leave_q, tag_q, end_q} <= '0;
    end else begin
      end_q <= (end_q || end_i) && !(idle_o && !end_i);
      if (full || close) begin
        count_q <= '0;
        leave_q <= full ? count_t'(Run) : count_q;
        tag_q   <= !tag_q;
      end else begin
        if (in_valid_i) count_q <= count_q + 1'b1;
        if (out_valid_o) leave_q <= leave_q - 1'b1;
      end
    end
  end

`ifndef SYNTHESIS
  logic            last_valid_q;           // the item that left in the cycle before was of this run
  logic [KeyW-1:0] last_key_q;
  always_ff @(posedge clk_i) begin
    last_valid_q <= rst_ni && leave_q > count_t'(1);
    last_key_q   <= out_key_o;
    if (rst_ni) begin
      if (out_valid_o && last_valid_q) Ascending_A: assert (last_key_q <= out_key_o);
      if (full || close) RunGone_A: assert (leave_q <= count_t'(1));
      if (end_q) NoMore_M: assume (!in_valid_i);
      if (out_valid_o) HasItem_A: assert (e_q[0].valid);
    end
  end
`endif
endmodule
