// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Traversal stacks of one pipeline: 32 rays x 32 levels x 72 bits = 9 KB (paper Sec. 4.1: 36 KB for four).
//
// A pass may push two entries, so even and odd levels lie in two RAMs. A ray's top is read at P7 and
// written at P17 of the same pass; different rays never share a word, so reads and writes cannot meet.
// Latency of a read: 1 cycle.
module rc_tni_stack import rc_pkg::*, rc_tni_pkg::*; (
  input  logic            clk_i,
  input  logic            rd_valid_i,       // the top: level rd_sp_i - 1; rd_sp_i > 0
  input  slot_t           rd_slot_i,
  input  logic [SP_W-1:0] rd_sp_i,
  output entry_t          rd_entry_o,
  input  logic            wr_first_i,       // push one entry at level wr_sp_i
  input  logic            wr_second_i,      // ... and another above it (only with the first)
  input  slot_t           wr_slot_i,
  input  logic [SP_W-1:0] wr_sp_i,
  input  entry_t          wr_entry_first_i,
  input  entry_t          wr_entry_second_i
);
  localparam int unsigned ROWS = (1 << SLOT_W) * STACK_DEPTH / 2;
  localparam int unsigned LEVEL_W = SP_W - 1;
  logic [LEVEL_W-1:0] rd_level, level_first, level_second;
  logic               rd_odd_q;
  entry_t [1:0]       rdata;
  assign rd_level     = LEVEL_W'(rd_sp_i - 1'b1);
  assign level_first  = LEVEL_W'(wr_sp_i);
  assign level_second = LEVEL_W'(wr_sp_i + 1'b1);

  always_ff @(posedge clk_i) if (rd_valid_i) rd_odd_q <= rd_level[0];
  for (genvar b = 0; b < 2; b++) begin : gen_bank
    logic first_here, we;
    assign first_here = level_first[0] == 1'(b);
    assign we         = first_here ? wr_first_i : wr_second_i;
    rc_ram_1r1w #(.Width($bits(entry_t)), .Depth(ROWS)) u_ram (
      .clk_i, .we_i(we),
      .waddr_i({wr_slot_i, first_here ? level_first[LEVEL_W-1:1] : level_second[LEVEL_W-1:1]}),
      .wdata_i(first_here ? wr_entry_first_i : wr_entry_second_i),
      .re_i(rd_valid_i && rd_level[0] == 1'(b)), .raddr_i({rd_slot_i, rd_level[LEVEL_W-1:1]}), .rdata_o(rdata[b]));
  end
  assign rd_entry_o = rdata[rd_odd_q];

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (wr_second_i) FirstToo_A: assert (wr_first_i);
    if (wr_first_i)  Room_A: assert (32'(wr_sp_i) + 32'(wr_second_i) < STACK_DEPTH);
    if (rd_valid_i)  NotEmpty_A: assert (rd_sp_i != '0);
  end
`endif
endmodule
