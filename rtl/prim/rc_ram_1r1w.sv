// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// One write port, one read port; rdata_o follows re_i by one cycle, then holds.
// Every memory of the design is one of these: a new technology replaces this file.
module rc_ram_1r1w #(
  parameter  int unsigned Width = 32,    // bits
  parameter  int unsigned Depth = 512,   // words
  localparam int unsigned AddrW = (Depth > 1) ? $clog2(Depth) : 1
) (
  input  logic             clk_i,
  input  logic             we_i,
  input  logic [AddrW-1:0] waddr_i,
  input  logic [Width-1:0] wdata_i,
  input  logic             re_i,
  input  logic [AddrW-1:0] raddr_i,
  output logic [Width-1:0] rdata_o
);
  logic [Width-1:0] mem[Depth];
  always_ff @(posedge clk_i) begin
    if (we_i) mem[waddr_i] <= wdata_i;
    if (re_i) rdata_o <= mem[raddr_i];
`ifndef SYNTHESIS   // RAMs differ in what a colliding read returns, so forbid it
    if (we_i && re_i) NoCollision_A: assert (waddr_i != raddr_i);
`endif
  end
endmodule
