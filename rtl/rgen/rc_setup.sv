// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Setup processing (paper Sec. 3.3): turns a block into its pixels in Morton order, gives each a free ray index of
// 8 bits, and tells the colour buffer where the colour of that index will go. Pixels outside the picture are skipped,
// one a cycle; with its last pixel inside, a block is through. The ray index stays with the pixel until its colour is
// final.
module rc_setup import rc_pkg::*, rc_rgen_pkg::*; (
  input  logic        clk_i,
  input  logic        rst_ni,
  input  logic [15:0] width_i,               // pixels; constant while a frame runs
  input  logic [15:0] height_i,
  input  logic        blk_valid_i,           // from the dispatcher
  output logic        blk_ready_o,
  input  block_t      blk_i,
  output logic        open_valid_o,          // to the colour buffer, which answers with a block slot
  input  logic        open_ready_i,
  output open_t       open_o,
  input  blk_slot_t   open_slot_i,
  output logic        pri_valid_o,           // to ray generation
  input  logic        pri_ready_i,
  output pri_t        pri_o,
  output logic        map_valid_o,           // to the colour buffer, with each primary ray
  output map_t        map_o,
  input  logic        free_valid_i,          // a ray index comes back
  input  ray_id_t     free_id_i
);
  logic       busy_q, in_picture, id_valid;
  block_t     blk_q;
  blk_slot_t  slot_q;
  logic [5:0] i_q;
  logic [6:0] left_q;                        // pixels inside that are still to come
  pix_t       pix;
  ray_id_t    id;
  logic [8:0] unused_id_count;

  // A block is taken when the colour buffer has a slot for it, never before: a pixel always has its place.
  assign open_valid_o = blk_valid_i && !busy_q;
  assign blk_ready_o  = open_ready_i && !busy_q;
  assign open_o       = '{count: 7'(inside_count(blk_i.x, width_i)) * 7'(inside_count(blk_i.y, height_i)), blk: blk_i};

  assign pix    = '{x: {i_q[5], i_q[3], i_q[1]}, y: {i_q[4], i_q[2], i_q[0]}};   // paper Sec. 3.3
  assign pri_o  = '{id: id, x: {blk_q.x, pix.x}, y: {blk_q.y, pix.y}};
  assign in_picture = pri_o.x < width_i && pri_o.y < height_i;

  rc_idx_pool #(.NumIdx(2 ** RAY_ID_W)) u_ids (
    .clk_i, .rst_ni,
    .out_valid_o(id_valid), .out_ready_i(map_valid_o), .out_idx_o(id),
    .free_valid_i, .free_idx_i(free_id_i), .count_o(unused_id_count)
  );
  assign pri_valid_o = busy_q && in_picture && id_valid;
  assign map_valid_o = pri_valid_o && pri_ready_i;
  assign map_o       = '{id: id, slot: slot_q, pix: pix};

  always_ff @(posedge clk_i) begin
    if (!rst_ni) busy_q <= 1'b0;
    else if (!busy_q) busy_q <= blk_valid_i && blk_ready_o;
    else if (map_valid_o && left_q == 7'd1) busy_q <= 1'b0;
    if (!busy_q) begin
      blk_q  <= blk_i;
      slot_q <= open_slot_i;
      i_q    <= '0;
      left_q <= open_o.count;
    end else begin
      if (map_valid_o || !in_picture) i_q <= i_q + 6'd1;
      if (map_valid_o) left_q <= left_q - 7'd1;
    end
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && blk_valid_i) BlkInside_M: assume ({blk_i.x, 3'b0} < width_i && {blk_i.y, 3'b0} < height_i);
    if (rst_ni && busy_q) AllPixels_A: assert ({1'b0, i_q} + left_q <= 7'd64);
    if (rst_ni && $past(rst_ni && pri_valid_o && !pri_ready_i)) PriHeld_A: assert (pri_valid_o && $stable(pri_o));
  end
`endif
endmodule
