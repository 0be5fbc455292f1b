// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Dispatcher, setup and colour buffer in a ring; the test plays everything between a primary ray and its colour.
module rc_frame_tb import rc_pkg::*, rc_rgen_pkg::*; (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             start_i,
  input  logic [15:0]      width_i,
  input  logic [15:0]      height_i,
  input  line_addr_t       fb_base_i,
  input  logic [18:0]      fb_stride_i,
  input  logic             fb_rgb10_i,
  output logic             pri_valid_o,
  input  logic             pri_ready_i,
  output pri_t             pri_o,
  input  logic             done_valid_i,
  output logic             done_ready_o,
  input  done_t            done_i,
  output logic             wr_valid_o,
  input  logic             wr_ready_i,
  output addr_t            wr_addr_o,
  output logic [7:0][31:0] wr_data_o,
  output logic [7:0]       wr_strb_o,
  output logic             all_sent_o,
  output logic             idle_o
);
  logic      blk_valid, blk_ready, open_valid, open_ready, map_valid, free_valid;
  block_t    blk;
  open_t     open;
  blk_slot_t open_slot;
  map_t      map;
  ray_id_t   free_id;
  rc_dispatch u_dispatch (
    .clk_i, .rst_ni, .start_i, .width_i, .height_i, .tile_x_i('0), .tile_y_i('0), .tile_count_i('0),
    .blk_valid_o(blk_valid), .blk_ready_i(blk_ready), .blk_o(blk), .all_sent_o
  );
  rc_setup u_setup (
    .clk_i, .rst_ni, .width_i, .height_i,
    .blk_valid_i(blk_valid), .blk_ready_o(blk_ready), .blk_i(blk),
    .open_valid_o(open_valid), .open_ready_i(open_ready), .open_o(open), .open_slot_i(open_slot),
    .pri_valid_o, .pri_ready_i, .pri_o, .map_valid_o(map_valid), .map_o(map),
    .free_valid_i(free_valid), .free_id_i(free_id)
  );
  rc_pixbuf u_pixbuf (
    .clk_i, .rst_ni, .width_i, .height_i, .fb_base_i, .fb_stride_i, .fb_rgb10_i,
    .open_valid_i(open_valid), .open_ready_o(open_ready), .open_i(open), .open_slot_o(open_slot),
    .map_valid_i(map_valid), .map_i(map),
    .done_valid_i, .done_ready_o, .done_i, .free_valid_o(free_valid), .free_id_o(free_id),
    .wr_valid_o, .wr_ready_i, .wr_addr_o, .wr_data_o, .wr_strb_o, .idle_o
  );
endmodule
