// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Colour buffer: collects finished pixels of up to sixteen blocks, converts them to the frame buffer's format, and writes
// a block, when its last pixel is there, as rows of 32 bytes. A finished pixel frees its ray index (paper Sec. 3.2).
//   in    one pixel in three cycles: red, green, blue go through one converter (one of each width)
//   out   one block in 18 cycles and more; no block takes less than 192 to come in
// One bank of RAM per column of a block: a pixel is one bank's word, a row is one word of all.
module rc_pixbuf import rc_pkg::*, rc_rgen_pkg::*; (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic [15:0]      width_i,            // pixels; all settings are constant while a frame runs
  input  logic [15:0]      height_i,
  input  line_addr_t       fb_base_i,          // row 0, in units of 64 bytes
  input  logic [18:0]      fb_stride_i,        // from row to row, in units of 32 bytes
  input  logic             fb_rgb10_i,         // 0: RGBA8, 1: RGB10A2
  input  logic             open_valid_i,       // a block begins; it gets open_slot_o
  output logic             open_ready_o,
  input  open_t            open_i,
  output blk_slot_t        open_slot_o,
  input  logic             map_valid_i,        // a ray index gets its pixel
  input  map_t             map_i,
  input  logic             done_valid_i,       // a pixel's colour is final
  output logic             done_ready_o,
  input  done_t            done_i,
  output logic             free_valid_o,       // its ray index is free
  output ray_id_t          free_id_o,
  output logic             wr_valid_o,         // rows to memory
  input  logic             wr_ready_i,
  output addr_t            wr_addr_o,
  output logic [7:0][31:0] wr_data_o,
  output logic [7:0]       wr_strb_o,          // pixels inside the picture
  output logic             idle_o              // no block is open
);
  localparam int unsigned ROW_W = ADDR_W - 5;  // address of a row, in units of 32 bytes

  // ---- block slots ---------------------------------------------------------------------------------------------------
  logic      open, store, store_last, close;
  blk_slot_t close_slot;
  logic [$clog2(BLOCK_SLOTS+1)-1:0] free_slots;
  logic   [BLOCK_SLOTS-1:0][6:0]    left_q;      // pixels that are still to come
  block_t [BLOCK_SLOTS-1:0]         blk_q;
  rc_idx_pool #(.NumIdx(BLOCK_SLOTS)) u_slots (
    .clk_i, .rst_ni,
    .out_valid_o(open_ready_o), .out_ready_i(open_valid_i), .out_idx_o(open_slot_o),
    .free_valid_i(close), .free_idx_i(close_slot), .count_o(free_slots)
  );
  assign open   = open_valid_i && open_ready_o;
  assign idle_o = 32'(free_slots) == BLOCK_SLOTS;

  // ---- conversion: done_q's channels one after the other; its place comes out of the map meanwhile ---------------
  typedef struct packed {blk_slot_t slot; pix_t pix;} place_t;
  logic       busy_q;
  logic [1:0] chan_q;
  vec3_t      rgb_q;
  place_t     place, st_place;
  logic       take;
  assign done_ready_o = !busy_q || chan_q == 2'd2;
  assign take         = done_valid_i && done_ready_o;
  // The map is read now and can be written again from the next cycle on.
  assign free_valid_o = take;
  assign free_id_o    = done_i.id;
  rc_ram_1r1w #(.Width($bits(place_t)), .Depth(2 ** RAY_ID_W)) u_map (
    .clk_i,
    .we_i(map_valid_i), .waddr_i(map_i.id), .wdata_i({map_i.slot, map_i.pix}),
    .re_i(take), .raddr_i(done_i.id), .rdata_o(place)
  );
  always_ff @(posedge clk_i) begin
    if (!rst_ni) busy_q <= 1'b0;
    else if (done_ready_o) busy_q <= done_valid_i;
    chan_q <= done_ready_o ? 2'd0 : chan_q + 2'd1;
    if (take) rgb_q <= done_i.rgb;
  end

  fp_t        chan;
  logic [7:0] unorm8;
  logic [9:0] unorm10, blue, green_q, red_q;
  assign chan = (chan_q == 2'd0) ? rgb_q[0] : (chan_q == 2'd1) ? rgb_q[1] : rgb_q[2];
  rc_fp_to_unorm #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_CONV), .Bits(8)) u_unorm8 (
    .clk_i, .a_i(chan), .y_o(unorm8)
  );
  rc_fp_to_unorm #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_CONV), .Bits(10)) u_unorm10 (
    .clk_i, .a_i(chan), .y_o(unorm10)
  );
  assign blue = fb_rgb10_i ? unorm10 : {2'b00, unorm8};
  always_ff @(posedge clk_i) {red_q, green_q} <= {green_q, blue};

  // Place and valid go along with blue, the last channel.
  logic [LAT_CONV-1:0] st_valid_q;
  rc_delay #(.Width($bits(place_t)), .Depth(LAT_CONV)) u_place (.clk_i, .in_i(place), .out_o(st_place));
  always_ff @(posedge clk_i) begin
    if (!rst_ni) st_valid_q <= '0;
    else st_valid_q <= LAT_CONV'({st_valid_q, busy_q && chan_q == 2'd2});
  end
  assign store = st_valid_q[LAT_CONV-1];

  logic [31:0] st_pixel;
  assign st_pixel   = fb_rgb10_i ? {2'b11, blue, green_q, red_q} : {8'hFF, blue[7:0], green_q[7:0], red_q[7:0]};
  assign store_last = store && left_q[st_place.slot] == 7'd1;
  always_ff @(posedge clk_i) begin
    if (store) left_q[st_place.slot] <= left_q[st_place.slot] - 7'd1;
    if (open) begin
      left_q[open_slot_o] <= open_i.count;
      blk_q[open_slot_o]  <= open_i.blk;
    end
  end

  // ---- finished blocks, in the order in which they finished --------------------------------------------------------
  typedef enum logic [1:0] {IDLE, ADDR, READ, SEND} state_e;
  state_e           state_q;
  logic             fin_ready, fin_valid, last_row;
  blk_slot_t        fin_slot;
  block_t           fin_blk;
  logic [3:0]       cols;
  logic [2:0]       row_q;
  logic [12:0]      factor_q;                    // block rows above this one, to be multiplied
  logic [ROW_W-1:0] addr_q, term_q;
  logic [$clog2(BLOCK_SLOTS+1)-1:0] unused_fin_count;
  rc_fifo #(.data_t(blk_slot_t), .Depth(BLOCK_SLOTS)) u_finished (
    .clk_i, .rst_ni,
    .in_valid_i(store_last), .in_ready_o(fin_ready), .in_data_i(st_place.slot),
    .out_valid_o(fin_valid), .out_ready_i(close), .out_data_o(fin_slot), .count_o(unused_fin_count)
  );
  assign fin_blk  = blk_q[fin_slot];
  assign cols     = inside_count(fin_blk.x, width_i);
  assign last_row = {1'b0, row_q} + 4'd1 == inside_count(fin_blk.y, height_i);
  assign close      = state_q == SEND && wr_ready_i && last_row;
  assign close_slot = fin_slot;

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      state_q <= IDLE;
    end else begin
      unique case (state_q)
        IDLE: if (fin_valid) state_q <= ADDR;
        ADDR: if (factor_q == '0) state_q <= READ;
        READ: state_q <= SEND;
        SEND: if (wr_ready_i) state_q <= last_row ? IDLE : READ;
      endcase
    end
    // addr = base + block x + 8 stride (block y): one bit of block y a cycle, for there is time
    unique case (state_q)
      IDLE: begin
        row_q    <= '0;
        addr_q   <= {fb_base_i, 1'b0} + ROW_W'(fin_blk.x);
        factor_q <= fin_blk.y;
        term_q   <= ROW_W'({fb_stride_i, 3'b000});
      end
      ADDR: begin
        if (factor_q[0]) addr_q <= addr_q + term_q;
        factor_q <= factor_q >> 1;
        term_q   <= term_q << 1;
      end
      READ: ;
      SEND: if (wr_ready_i) begin
        row_q  <= row_q + 3'd1;
        addr_q <= addr_q + ROW_W'(fb_stride_i);
      end
    endcase
  end
  assign wr_valid_o = state_q == SEND;
  assign wr_addr_o  = {addr_q, 5'b00000};

  for (genvar x = 0; x < 8; x++) begin : gen_column
    rc_ram_1r1w #(.Width(32), .Depth(8 * BLOCK_SLOTS)) u_bank (
      .clk_i,
      .we_i(store && st_place.pix.x == 3'(x)), .waddr_i({st_place.slot, st_place.pix.y}), .wdata_i(st_pixel),
      .re_i(state_q == READ), .raddr_i({fin_slot, row_q}), .rdata_o(wr_data_o[x])
    );
    assign wr_strb_o[x] = 4'(x) < cols;
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (store) PixelExpected_A: assert (left_q[st_place.slot] != '0);
      if (store_last) FinishedRoom_A: assert (fin_ready);
      if (open) OpenCount_M: assume (open_i.count != '0 && open_i.count <= 7'd64);
      if (wr_valid_o) SlotEmpty_A: assert (left_q[fin_slot] == '0);
    end
    if (rst_ni && $past(rst_ni && done_valid_i && !done_ready_o)) DoneHeld_M: assume (done_valid_i && $stable(done_i));
    if (rst_ni && $past(rst_ni && wr_valid_o && !wr_ready_i))
      RowHeld_A: assert (wr_valid_o && $stable(wr_addr_o) && $stable(wr_data_o) && $stable(wr_strb_o));
  end
`endif
endmodule
