// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// rc_merge_sort with a memory of keys and items that answers RdLat cycles later, and a port to read the result.
module rc_merge_sort_mem #(
  parameter  int unsigned KeyW   = 8,
  parameter  int unsigned ItemW  = 12,
  parameter  int unsigned MaxLen = 300,
  parameter  int unsigned Run    = 16,
  parameter  int unsigned RdLat  = 2,
  localparam int unsigned IdxW   = $clog2(MaxLen),
  localparam int unsigned LenW   = $clog2(MaxLen + 1)
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             start_i,
  input  logic [LenW-1:0]  max_len_i,
  input  logic             in_valid_i,
  input  logic [KeyW-1:0]  in_key_i,
  input  logic [ItemW-1:0] in_item_i,
  input  logic             end_i,
  output logic             busy_o,
  output logic [LenW-1:0]  len_o,
  output logic             side_o,
  output logic             wr_valid_o,
  input  logic [IdxW-1:0]  res_idx_i,      // place of the result; KeyW + ItemW bits RdLat cycles later
  output logic [KeyW+ItemW-1:0] res_o
);
  logic             rd_valid, rd_side, wr_side;
  logic [IdxW-1:0]  rd_idx, wr_idx;
  logic [KeyW-1:0]  wr_key;
  logic [ItemW-1:0] wr_item;
  logic [1:0][KeyW+ItemW-1:0] side_word;
  logic [KeyW+ItemW-1:0]      word;
  logic             side_q;
  for (genvar s = 0; s < 2; s++) begin : gen_side
    rc_ram_1r1w #(.Width(KeyW + ItemW), .Depth(MaxLen)) u_ram (
      .clk_i, .we_i(wr_valid_o && wr_side == 1'(s)), .waddr_i(wr_idx), .wdata_i({wr_key, wr_item}),
      .re_i(busy_o ? rd_valid && rd_side == 1'(s) : side_o == 1'(s)),
      .raddr_i(busy_o ? rd_idx : res_idx_i), .rdata_o(side_word[s])
    );
  end
  always_ff @(posedge clk_i) side_q <= busy_o ? rd_side : side_o;
  rc_delay #(.Width(KeyW + ItemW), .Depth(RdLat - 1)) u_late (.clk_i, .in_i(side_word[side_q]), .out_o(word));
  assign res_o = word;
  rc_merge_sort #(.KeyW(KeyW), .ItemW(ItemW), .MaxLen(MaxLen), .Run(Run), .RdLat(RdLat)) u_sort (
    .clk_i, .rst_ni, .start_i, .max_len_i, .in_valid_i, .in_key_i, .in_item_i, .end_i, .busy_o, .len_o, .side_o,
    .rd_valid_o(rd_valid), .rd_side_o(rd_side), .rd_idx_o(rd_idx),
    .rd_key_i(word[KeyW+ItemW-1:ItemW]), .rd_item_i(word[ItemW-1:0]),
    .wr_valid_o, .wr_side_o(wr_side), .wr_idx_o(wr_idx), .wr_key_o(wr_key), .wr_item_o(wr_item)
  );
endmodule
