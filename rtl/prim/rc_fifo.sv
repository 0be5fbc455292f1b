// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// First-in first-out queue of any depth; its oldest word is always at the output.
//   Ram = 0  flip-flops or distributed RAM, a word comes out one cycle after it went in; up to 16 words, 64 if narrow
//   Ram = 1  block RAM and two words in front of it, three cycles from input to output
// Both take and give a word every cycle and hold Depth words in all.
module rc_fifo #(
  parameter  type         data_t = logic [31:0],
  parameter  int unsigned Depth  = 4,      // words
  parameter  bit          Ram    = Depth > 16,
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
  localparam int unsigned PtrW = (Depth > 1) ? $clog2(Depth) : 1;
  typedef logic [PtrW-1:0]   ptr_t;
  typedef logic [CountW-1:0] count_t;
  localparam ptr_t LAST = ptr_t'(Depth - 1);

  ptr_t   wptr_q, rptr_q;
  count_t count_q;                         // all words inside
  logic   push, pop, read;

  assign push       = in_valid_i && in_ready_o;
  assign pop        = out_valid_o && out_ready_i;
  assign in_ready_o = count_q != count_t'(Depth);
  assign count_o    = count_q;

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {wptr_q, rptr_q, count_q} <= '0;
    end else begin
      if (push) wptr_q <= (wptr_q == LAST) ? '0 : wptr_q + 1'b1;
      if (read) rptr_q <= (rptr_q == LAST) ? '0 : rptr_q + 1'b1;
      if (push != pop) count_q <= push ? count_q + 1'b1 : count_q - 1'b1;
    end
  end

  if (Ram) begin : gen_ram
    logic       rvalid_q, front_ready;     // a word is at the RAM's output; there is room for it
    count_t     stored_q;                  // words in the RAM
    logic [1:0] front, ahead;              // words in front of the RAM now, and those to come
    data_t      rdata;
    assign front = 2'(out_valid_o) + 2'(!front_ready);
    assign ahead = front + 2'(rvalid_q) - 2'(pop);
    assign read  = stored_q != '0 && ahead < 2'd2;
    always_ff @(posedge clk_i) begin
      if (!rst_ni) begin
        {rvalid_q, stored_q} <= '0;
      end else begin
        rvalid_q <= read;
        if (push != read) stored_q <= push ? stored_q + 1'b1 : stored_q - 1'b1;
      end
    end
    rc_ram_1r1w #(.Width($bits(data_t)), .Depth(Depth)) u_ram (
      .clk_i,
      .we_i(push), .waddr_i(wptr_q), .wdata_i(in_data_i),
      .re_i(read), .raddr_i(rptr_q), .rdata_o(rdata)
    );
    rc_skid #(.data_t(data_t)) u_front (
      .clk_i, .rst_ni,
      .in_valid_i(rvalid_q), .in_ready_o(front_ready), .in_data_i(rdata),
      .out_valid_o, .out_ready_i, .out_data_o
    );
`ifndef SYNTHESIS
    always_ff @(posedge clk_i) if (rst_ni && rvalid_q) FrontRoom_A: assert (front_ready);
`endif
  end else begin : gen_flops
    data_t mem[Depth];
    always_ff @(posedge clk_i) if (push) mem[wptr_q] <= in_data_i;
    assign read        = pop;
    assign out_valid_o = count_q != '0;
    assign out_data_o  = mem[rptr_q];
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) Count_A: assert (32'(count_q) <= Depth);
    if (rst_ni && $past(rst_ni && in_valid_i && !in_ready_o))
      InHeld_M: assume (in_valid_i && $stable(in_data_i));
    if (rst_ni && $past(rst_ni && out_valid_o && !out_ready_i))
      OutHeld_A: assert (out_valid_o && $stable(out_data_o));
  end
`endif
endmodule
