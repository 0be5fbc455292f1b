// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Looks at the set-up before a frame: works out which lines of memory it may read and write, and
// refuses what makes no sense. Windows follow the set-up by one cycle, the verdict by two. While a tree is
// built or records are made the windows are those of the builders at work, later those of the picture.
module rc_setup_check import rc_pkg::*; import rc_mem_pkg::*; import rc_top_pkg::*; import rc_tbu_pkg::*;
  import rc_accel_pkg::slack_t, rc_accel_pkg::SLACK_MAX, rc_accel_pkg::SLACK_FRAC; #(
  parameter bit Tbu   = 1'b1,                     // there is a tree builder
  parameter bit Accel = 1'b1                      // there is a record unit
) (
  input  logic                      clk_i,
  input  setup_t                    setup_i,
  input  logic                      render_i,     // what the frame does; the verdict is about that
  input  logic                      build_i,
  input  logic                      accel_i,
  input  logic                      building_i,   // whose windows
  output window_t [NUM_WINDOWS-1:0] rd_window_o,
  output window_t [NUM_WR_WINDOWS-1:0] wr_window_o,
  output logic                      bad_o,
  output addr_t                     bad_reg_o     // offset of the register that is wrong
);
  // One bit more than a line address: no sum of a base and a size in lines wraps.
  typedef logic [LINE_ADDR_W:0] lines_t;
  localparam lines_t ALL_LINES = lines_t'(1) << LINE_ADDR_W;
  localparam int unsigned FRAME_W = 19 + 16;      // stride x height, in 32 bytes

  // ---- P1: ends of the regions ---------------------------------------------------------------------
  localparam int unsigned N = NUM_WINDOWS + 3;     // vertices, working memory, attributes are the builders' alone
  localparam int unsigned NODES = 0, LISTS = 1, ACCEL = 2, INFO = 3;
  localparam int unsigned VERTICES = NUM_WINDOWS, REFS = NUM_WINDOWS + 1, ATTRS = NUM_WINDOWS + 2;
  line_addr_t [N-1:0] base;
  lines_t     [N-1:0] lines;                      // 64-byte lines of a region, rounded up
  window_t    [N-1:0] region;
  logic       [N-1:0] p1_over_q;                  // ends behind the last line
  logic       [FRAME_W-1:0]     frame_rows, frame_end, p1_frame_end_q;
  assign base  = {setup_i.attr_base, setup_i.ref_base, setup_i.vertex_base, setup_i.tree.inst_base,
                  setup_i.tex_base, setup_i.uv_base, setup_i.light_base, setup_i.mat_base,
                  setup_i.info_base, setup_i.tree.accel_base, setup_i.tree.list_base, setup_i.tree.node_base};
  assign lines = {(lines_t'(setup_i.tree.tri_count) + lines_t'(1)) >> 1,      // 32
                  (lines_t'(setup_i.ref_count) + lines_t'(3)) >> 2,           // 16
                  (lines_t'(setup_i.tree.tri_count) + lines_t'(1)) >> 1,      // 32
                  lines_t'(setup_i.tree.inst_count) << $clog2(INST_LINES),    // 256
                  lines_t'(setup_i.tex_lines),
                  (lines_t'(setup_i.uv_count) + lines_t'(1)) >> 1,            // 32-byte records
                  lines_t'(setup_i.light_count),                              // 64
                  lines_t'(setup_i.mat_count) << 1,                           // 128
                  lines_t'(setup_i.tree.tri_count),
                  (lines_t'(setup_i.tree.tri_count) + lines_t'(1)) >> 1,      // 32
                  (lines_t'(setup_i.tree.list_count) + lines_t'(15)) >> 4,    // 4
                  (lines_t'(setup_i.tree.node_count) + lines_t'(7)) >> 3};    // 8
  assign frame_rows = FRAME_W'(setup_i.frame.fb_stride) * FRAME_W'(setup_i.frame.height);
  assign frame_end  = ((frame_rows + FRAME_W'(1)) >> 1) + FRAME_W'(setup_i.frame.fb_base);

  always_comb for (int w = 0; w < int'(N); w++) region[w] = '{lo: base[w], hi: lines_t'(base[w]) + lines[w]};

  always_ff @(posedge clk_i) begin
    rd_window_o    <= region[NUM_WINDOWS-1:0];
    wr_window_o    <= '0;                         // an end of 0: nothing is inside
    wr_window_o[0] <= '{lo: setup_i.frame.fb_base, hi: frame_end[LINE_ADDR_W:0]};
    if (building_i) begin
      rd_window_o    <= '0;
      wr_window_o    <= '0;
      rd_window_o[0] <= region[VERTICES];
      if (build_i) begin
        rd_window_o[1]   <= region[REFS];
        wr_window_o[2:0] <= {region[REFS], region[LISTS], region[NODES]};
      end
      if (accel_i) begin
        rd_window_o[2]   <= region[ATTRS];
        wr_window_o[4:3] <= {region[INFO], region[ACCEL]};
      end
    end
    for (int w = 0; w < int'(N); w++) p1_over_q[w] <= region[w].hi > ALL_LINES;
    p1_frame_end_q <= frame_end;
  end

  // ---- P2: verdict; offsets as in rc_regs.rdl, tb/rc_core checks each of them ------------------------
  localparam addr_t [N-1:0] BASE_REG = {32'h200, 32'h9C, 32'h98, 32'h240,
                                         32'hD8, 32'hD0, 32'h78, 32'h70, 32'h6C, 32'h64, 32'h5C, 32'h50};
  logic         bad;
  addr_t        bad_reg;
  logic [N-1:0] used;                             // regions of this frame
  always_comb begin
    used           = '0;
    used[INFO:0]   = {{2{accel_i}}, {2{build_i}}};
    used[VERTICES] = build_i || accel_i;
    used[REFS]     = build_i;
    used[ATTRS]    = accel_i;
    if (render_i) used[NUM_WINDOWS-1:0] = '1;
    {bad, bad_reg} = '0;
    for (int w = int'(N) - 1; w >= 0; w--)
      if (p1_over_q[w] && used[w]) {bad, bad_reg} = {1'b1, BASE_REG[w]};
    if (render_i) begin
      if (setup_i.light_count > 16'(MAX_LIGHTS)) {bad, bad_reg} = {1'b1, 32'h7C};
      if (setup_i.tree.inst_count > IDX_W'(1 << INST_W)) {bad, bad_reg} = {1'b1, 32'h244};
      if (setup_i.mat_count == '0 || setup_i.mat_count > 16'(MAX_MATERIALS)) {bad, bad_reg} = {1'b1, 32'h74};
      if (!build_i && setup_i.tree.root >= setup_i.tree.node_count) {bad, bad_reg} = {1'b1, 32'h58};
    end
    if (build_i) begin                             // extents are given out whole
      if (setup_i.tri_first != '0 && IDX_W'(setup_i.tri_first) + setup_i.tree.tri_count > IDX_W'(1 << TRI_W))
        {bad, bad_reg} = {1'b1, 32'h250};
      if (setup_i.list_first % IDX_W'(LIST_EXTENT) != '0 || setup_i.list_first > setup_i.tree.list_count)
        {bad, bad_reg} = {1'b1, 32'h24C};
      if (setup_i.node_first % IDX_W'(NODE_EXTENT) != '0 || setup_i.node_first > setup_i.tree.node_count)
        {bad, bad_reg} = {1'b1, 32'h248};
      if (setup_i.tree.tri_count == '0) {bad, bad_reg} = {1'b1, 32'h68};
      if (setup_i.tree.list_count % IDX_W'(LIST_EXTENT) != '0) {bad, bad_reg} = {1'b1, 32'h60};
      if (setup_i.tree.node_count % IDX_W'(NODE_EXTENT) != '0) {bad, bad_reg} = {1'b1, 32'h54};
    end
    if (accel_i) begin
      if (setup_i.tree.tri_count == '0) {bad, bad_reg} = {1'b1, 32'h68};
      if (setup_i.slack < slack_t'(1 << SLACK_FRAC) || setup_i.slack > SLACK_MAX) {bad, bad_reg} = {1'b1, 32'h204};
    end
    if ((render_i || build_i) && setup_i.tree.node_count == '0) {bad, bad_reg} = {1'b1, 32'h54};
    if (render_i) begin
      if ({setup_i.tile_x, 4'b0} >= setup_i.frame.width || {setup_i.tile_y, 4'b0} >= setup_i.frame.height)
        {bad, bad_reg} = {1'b1, 32'h220};
      if (p1_frame_end_q > FRAME_W'(ALL_LINES)) {bad, bad_reg} = {1'b1, 32'h24};
      if (setup_i.frame.fb_stride < (19'(setup_i.frame.width) + 19'd7) >> 3) {bad, bad_reg} = {1'b1, 32'h28};
      if (setup_i.frame.width == '0 || setup_i.frame.height == '0) {bad, bad_reg} = {1'b1, 32'h20};
    end
    if ((build_i && !Tbu) || (accel_i && !Accel)) {bad, bad_reg} = {1'b1, 32'h08};
  end

  always_ff @(posedge clk_i) {bad_o, bad_reg_o} <= {bad, bad_reg};

endmodule
