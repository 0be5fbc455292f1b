// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Looks at the set-up before a frame: works out which lines of memory it may read and refuses what
// makes no sense. Results follow the set-up by two cycles.
//   P1  ends of the regions, size of the frame buffer
//   P2  verdict
module rc_setup_check import rc_pkg::*, rc_top_pkg::*; (
  input  logic                      clk_i,
  input  setup_t                    setup_i,
  output window_t [NUM_WINDOWS-1:0] windows_o,
  output logic                      bad_o,
  output addr_t                     bad_reg_o     // offset of the register that is wrong
);
  // One bit more than a line address, so that the end of a region cannot wrap.
  typedef logic [LINE_ADDR_W:0] end_t;
  localparam int unsigned SIZE_W = 19 + 16;       // stride x height, in 32 bytes

  line_addr_t [NUM_WINDOWS-1:0] base;
  end_t       [NUM_WINDOWS-1:0] lines;            // 64-byte lines of a region, rounded up
  end_t       [NUM_WINDOWS-1:0] p1_end_q;
  logic [SIZE_W-1:0]            p1_frame_q;       // bytes / 32
  logic [SIZE_W-1:0]            frame_end;

  assign base  = {setup_i.light_base, setup_i.mat_base, setup_i.info_base,
                  setup_i.tree.accel_base, setup_i.tree.list_base, setup_i.tree.node_base};
  assign lines = {end_t'(setup_i.light_count),                 // records of 64 bytes
                  end_t'(setup_i.mat_count),
                  end_t'(setup_i.tree.tri_count),
                  (end_t'(setup_i.tree.tri_count) + 27'd1) >> 1,     // 32
                  (end_t'(setup_i.tree.list_count) + 27'd15) >> 4,   // 4
                  (end_t'(setup_i.tree.node_count) + 27'd7) >> 3};   // 8
  assign frame_end = p1_frame_q + SIZE_W'({setup_i.frame.fb_base, 1'b0});

  always_ff @(posedge clk_i) begin
    for (int w = 0; w < int'(NUM_WINDOWS); w++) p1_end_q[w] <= end_t'(base[w]) + lines[w];
    p1_frame_q <= SIZE_W'(setup_i.frame.fb_stride) * SIZE_W'(setup_i.frame.height);
  end

  for (genvar w = 0; w < NUM_WINDOWS; w++) begin : gen_window
    assign windows_o[w] = '{lo: base[w], hi: p1_end_q[w][LINE_ADDR_W-1:0]};
  end

  // Offsets as in rc_regs.rdl; tb/rc_top checks each of them.
  localparam addr_t [NUM_WINDOWS-1:0] BASE_REG = {32'h78, 32'h70, 32'h6C, 32'h64, 32'h5C, 32'h50};
  logic  bad;
  addr_t bad_reg;
  always_comb begin
    {bad, bad_reg} = '0;
    for (int w = 0; w < int'(NUM_WINDOWS); w++) begin
      if (p1_end_q[w][LINE_ADDR_W]) {bad, bad_reg} = {1'b1, BASE_REG[w]};   // ends beyond 4 GB - 64
    end
    if (setup_i.light_count > 16'(MAX_LIGHTS)) {bad, bad_reg} = {1'b1, 32'h7C};
    if (setup_i.mat_count == '0 || setup_i.mat_count > 16'(MAX_MATERIALS)) {bad, bad_reg} = {1'b1, 32'h74};
    if (setup_i.tree.root >= setup_i.tree.node_count) {bad, bad_reg} = {1'b1, 32'h58};
    if (setup_i.tree.node_count == '0) {bad, bad_reg} = {1'b1, 32'h54};
    if (|frame_end[SIZE_W-1:ADDR_W-5]) {bad, bad_reg} = {1'b1, 32'h24};     // ends beyond 4 GB - 32
    if (setup_i.frame.fb_stride < (19'(setup_i.frame.width) + 19'd7) >> 3) {bad, bad_reg} = {1'b1, 32'h28};
    if (setup_i.frame.width == '0 || setup_i.frame.height == '0) {bad, bad_reg} = {1'b1, 32'h20};
  end

  always_ff @(posedge clk_i) {bad_o, bad_reg_o} <= {bad, bad_reg};

endmodule
