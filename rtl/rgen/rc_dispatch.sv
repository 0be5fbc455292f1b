// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Hands the picture out in blocks of 8x8 pixels (paper Sec. 4.1): tiles of 16x16 in raster order, the blocks of a tile
// in Morton order, to whichever RTU asks, in turn if several do. Blocks outside the picture are left out.
// Each RTU has one block in a register in front of it, so that valid need not wait for ready. A frame may be a range
// of the picture's tiles: a first one, and how many.
module rc_dispatch import rc_pkg::*; #(
  parameter int unsigned NumRtus = 1
) (
  input  logic                 clk_i,
  input  logic                 rst_ni,
  input  logic                 start_i,        // begin a frame
  input  logic [15:0]          width_i,        // pixels; constant while a frame runs
  input  logic [15:0]          height_i,
  input  logic [11:0]          tile_x_i,       // the first tile, inside the picture
  input  logic [11:0]          tile_y_i,
  input  logic [23:0]          tile_count_i,   // 0, or more than follow: all that follow
  output logic   [NumRtus-1:0] blk_valid_o,
  input  logic   [NumRtus-1:0] blk_ready_i,
  output block_t [NumRtus-1:0] blk_o,
  output logic                 all_sent_o      // every block of the frame was taken
);
  localparam int unsigned RtuW = (NumRtus > 1) ? $clog2(NumRtus) : 1;

  logic   active_q, in_picture, give, tile_end, last;
  logic [23:0] left_q;                         // tiles still to hand out; meaningless after 0
  block_t blk_q, blk_d, last_blk;
  logic   tile_end_x, tile_end_y;
  logic [NumRtus-1:0] gnt;
  logic [RtuW-1:0]    unused_gnt_idx;

  assign last_blk.x = 13'((width_i - 16'd1) >> 3);
  assign last_blk.y = 13'((height_i - 16'd1) >> 3);
  assign in_picture = blk_q.x <= last_blk.x && blk_q.y <= last_blk.y;
  assign tile_end_x = blk_q.x[12:1] == last_blk.x[12:1];
  assign tile_end_y = blk_q.y[12:1] == last_blk.y[12:1];
  assign tile_end   = blk_q.x[0] && blk_q.y[0];
  assign last       = tile_end && ((tile_end_x && tile_end_y) || left_q == 24'd1);

  always_comb begin
    blk_d = blk_q;
    {blk_d.x[0], blk_d.y[0]} = {blk_q.x[0], blk_q.y[0]} + 2'd1;      // Morton: x = i1, y = i0
    if (tile_end) begin
      blk_d.x[12:1] = tile_end_x ? '0 : blk_q.x[12:1] + 12'd1;
      if (tile_end_x) blk_d.y[12:1] = blk_q.y[12:1] + 12'd1;
    end
  end

  rc_rr_arb #(.NumReq(NumRtus)) u_arb (
    .clk_i, .rst_ni, .req_i(~blk_valid_o | blk_ready_i), .ready_i(active_q && in_picture),
    .gnt_o(gnt), .idx_o(unused_gnt_idx)
  );
  assign give = active_q && in_picture && gnt != '0;

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      active_q    <= 1'b0;
      blk_valid_o <= '0;
    end else begin
      if (start_i) active_q <= width_i != '0 && height_i != '0;
      else if (last && (give || !in_picture)) active_q <= 1'b0;
      blk_valid_o <= (blk_valid_o & ~blk_ready_i) | (give ? gnt : '0);
    end
    if (start_i) begin
      blk_q  <= '{x: {tile_x_i, 1'b0}, y: {tile_y_i, 1'b0}};
      left_q <= tile_count_i;
    end else if (give || !in_picture) begin
      blk_q <= blk_d;
      if (tile_end) left_q <= left_q - 24'd1;
    end
    for (int i = 0; i < NumRtus; i++) if (give && gnt[i]) blk_o[i] <= blk_q;
  end
  assign all_sent_o = !active_q && blk_valid_o == '0;

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && start_i) StartOnce_M: assume (all_sent_o);
    if (rst_ni && start_i && width_i != '0 && height_i != '0)
      FirstInside_M: assume ({tile_x_i, 4'b0} < width_i && {tile_y_i, 4'b0} < height_i);
    if (rst_ni && !all_sent_o) SizeHeld_M: assume ($stable(width_i) && $stable(height_i));
  end
  for (genvar i = 0; i < NumRtus; i++) begin : gen_held
    always_ff @(posedge clk_i) begin
      if (rst_ni && $past(rst_ni && blk_valid_o[i] && !blk_ready_i[i]))
        BlkHeld_A: assert (blk_valid_o[i] && $stable(blk_o[i]));
    end
  end
`endif
endmodule
