// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Host registers: the block generated from rc_regs.rdl, its fields named as the core names them.
// AXI ports keep the names that tools look for.
module rc_csr import rc_pkg::*, rc_top_pkg::*; (
  input  logic        clk_i,
  input  logic        rst_ni,
  input  logic        s_axil_awvalid,
  output logic        s_axil_awready,
  input  logic [11:0] s_axil_awaddr,
  input  logic [2:0]  s_axil_awprot,
  input  logic        s_axil_wvalid,
  output logic        s_axil_wready,
  input  logic [31:0] s_axil_wdata,
  input  logic [3:0]  s_axil_wstrb,
  output logic        s_axil_bvalid,
  input  logic        s_axil_bready,
  output logic [1:0]  s_axil_bresp,
  input  logic        s_axil_arvalid,
  output logic        s_axil_arready,
  input  logic [11:0] s_axil_araddr,
  input  logic [2:0]  s_axil_arprot,
  output logic        s_axil_rvalid,
  input  logic        s_axil_rready,
  output logic [31:0] s_axil_rdata,
  output logic [1:0]  s_axil_rresp,

  output logic        render_o,            // one cycle: start a frame that renders
  output logic        build_o,             // one cycle: start a frame that builds a tree
  output logic        accel_o,             // one cycle: start a frame that makes records
  output setup_t      setup_o,
  input  status_t     status_i,
  input  logic        end_i,               // one cycle, with the final status
  input  counters_t   counters_i,
  input  idx_t        tbu_root_i,
  input  rc_tbu_pkg::tbu_stat_t tbu_stat_i,
  input  logic [31:0] accel_cycles_i,
  output logic        irq_o
);
  rc_regs_pkg::rc_regs__in_t  hw_in;
  rc_regs_pkg::rc_regs__out_t hw;

  rc_regs u_regs (
    .clk(clk_i), .rst_n(rst_ni),
    .s_axil_awready, .s_axil_awvalid, .s_axil_awaddr, .s_axil_awprot,
    .s_axil_wready, .s_axil_wvalid, .s_axil_wdata, .s_axil_wstrb,
    .s_axil_bready, .s_axil_bvalid, .s_axil_bresp,
    .s_axil_arready, .s_axil_arvalid, .s_axil_araddr, .s_axil_arprot,
    .s_axil_rready, .s_axil_rvalid, .s_axil_rdata, .s_axil_rresp,
    .hwif_in(hw_in), .hwif_out(hw)
  );

  // ---- control ------------------------------------------------------------------------------------
  assign render_o = hw.CTRL.render.value;
  assign build_o  = hw.CTRL.build.value;
  assign accel_o  = hw.CTRL.accel.value;
  assign irq_o    = (hw.IRQ_STATUS.done.value && hw.IRQ_ENABLE.done.value) ||
                    (hw.IRQ_STATUS.error.value && hw.IRQ_ENABLE.error.value);

  // ---- set-up ---------------------------------------------------------------------------------------
  assign setup_o = '{
    tree: '{
      node_base:  hw.NODE_BASE.line.value,   node_count: hw.NODE_COUNT.value.value,
      root:       hw.NODE_ROOT.value.value,
      list_base:  hw.LIST_BASE.line.value,   list_count: hw.LIST_COUNT.value.value,
      accel_base: hw.ACCEL_BASE.line.value,  tri_count:  hw.TRI_COUNT.value.value,
      inst_base:  hw.INST_BASE.line.value,   inst_count: hw.INST_COUNT.value.value,
      box_lo:     {hw.BOX_LO_Z.value.value, hw.BOX_LO_Y.value.value, hw.BOX_LO_X.value.value},
      box_hi:     {hw.BOX_HI_Z.value.value, hw.BOX_HI_Y.value.value, hw.BOX_HI_X.value.value},
      max_slots:  hw.MAX_SLOTS.value.value
    },
    camera: '{
      org: {hw.CAM_ORG_Z.value.value, hw.CAM_ORG_Y.value.value, hw.CAM_ORG_X.value.value},
      c:   {hw.CAM_C_Z.value.value, hw.CAM_C_Y.value.value, hw.CAM_C_X.value.value},
      u:   {hw.CAM_U_Z.value.value, hw.CAM_U_Y.value.value, hw.CAM_U_X.value.value},
      v:   {hw.CAM_V_Z.value.value, hw.CAM_V_Y.value.value, hw.CAM_V_X.value.value}
    },
    frame: '{
      fb_base: hw.FB_BASE.line.value,        fb_stride: hw.FB_STRIDE.rows32.value,
      rgb10:   hw.FB_FORMAT.rgb10.value,
      width:   hw.SIZE.width.value,          height:    hw.SIZE.height.value
    },
    tile_x: hw.TILE_FIRST.x.value, tile_y: hw.TILE_FIRST.y.value, tile_count: hw.TILE_COUNT.value.value,
    background: {hw.BACKGROUND_B.value.value, hw.BACKGROUND_G.value.value, hw.BACKGROUND_R.value.value},
    shadows:     hw.OPTIONS.shadows.value,   trilinear:   hw.OPTIONS.trilinear.value,
    max_depth:   hw.MAX_DEPTH.value.value,   min_weight:  hw.MIN_WEIGHT.value.value,
    mip_bias:    hw.MIP_BIAS.value.value,
    info_base:   hw.INFO_BASE.line.value,
    uv_base:     hw.UV_BASE.line.value,      uv_count:    hw.UV_COUNT.value.value,
    tex_base:    hw.TEX_BASE.line.value,     tex_lines:   hw.TEX_LINES.value.value,
    mat_base:    hw.MAT_BASE.line.value,     mat_count:   hw.MAT_COUNT.value.value,
    light_base:  hw.LIGHT_BASE.line.value,   light_count: hw.LIGHT_COUNT.value.value,
    vertex_base: hw.VERTEX_BASE.line.value,
    ref_base:    hw.REF_BASE.line.value,     ref_count:   hw.REF_COUNT.value.value,
    refine_max:  hw.TBU_REFINE.value.value,
    tri_box: '{
      hi: {hw.TBU_HI_Z.value.value, hw.TBU_HI_Y.value.value, hw.TBU_HI_X.value.value},
      lo: {hw.TBU_LO_Z.value.value, hw.TBU_LO_Y.value.value, hw.TBU_LO_X.value.value}
    },
    attr_base:   hw.ATTR_BASE.line.value,    slack: hw.ACCEL_SLACK.value.value,
    eye: {hw.ACCEL_EYE_Z.value.value, hw.ACCEL_EYE_Y.value.value, hw.ACCEL_EYE_X.value.value},
    node_first: hw.TBU_NODE_FIRST.value.value, list_first: hw.TBU_LIST_FIRST.value.value,
    tri_first: hw.TBU_TRI_FIRST.value.value
  };

  // ---- status and counters --------------------------------------------------------------------------
  always_comb begin
    hw_in.frame_busy                  = status_i.busy;
    hw_in.STATUS.busy.next            = status_i.busy;
    hw_in.STATUS.done.next            = status_i.done;
    hw_in.STATUS.error.next           = status_i.error;
    hw_in.IRQ_STATUS.done.hwset       = end_i;
    hw_in.IRQ_STATUS.error.hwset      = end_i && status_i.error;
    hw_in.ERROR.code.next             = status_i.err.code;
    hw_in.ERROR_ADDR.value.next       = status_i.err.addr;
    hw_in.CYCLES.value.next           = counters_i[CNT_CYCLES];
    hw_in.RAYS_PRIMARY.value.next     = counters_i[CNT_RAYS_PRIMARY];
    hw_in.RAYS_SHADOW.value.next      = counters_i[CNT_RAYS_SHADOW];
    hw_in.RAYS_CULLED.value.next      = counters_i[CNT_RAYS_CULLED];
    hw_in.SLOTS_BOX.value.next        = counters_i[CNT_SLOTS_BOX];
    hw_in.SLOTS_TRAV1.value.next      = counters_i[CNT_SLOTS_TRAV1];
    hw_in.SLOTS_TRAV2.value.next      = counters_i[CNT_SLOTS_TRAV2];
    hw_in.SLOTS_ISECT.value.next      = counters_i[CNT_SLOTS_ISECT];
    hw_in.SLOTS_MISS_NT.value.next    = counters_i[CNT_SLOTS_MISS_NT];
    hw_in.SLOTS_MISS_LIST.value.next  = counters_i[CNT_SLOTS_MISS_LIST];
    hw_in.SLOTS_BUBBLE.value.next     = counters_i[CNT_SLOTS_BUBBLE];
    hw_in.NT_HITS.value.next          = counters_i[CNT_NT_HITS];
    hw_in.LIST_HITS.value.next        = counters_i[CNT_LIST_HITS];
    hw_in.L2_HITS.value.next          = counters_i[CNT_L2_HITS];
    hw_in.L2_MISSES.value.next        = counters_i[CNT_L2_MISSES];
    hw_in.TRI_HITS.value.next         = counters_i[CNT_TRI_HITS];
    hw_in.TRI_MISSES.value.next       = counters_i[CNT_TRI_MISSES];
    hw_in.LINES_TNI.value.next        = counters_i[CNT_LINES_TNI];
    hw_in.LINES_TRI.value.next        = counters_i[CNT_LINES_TRI];
    hw_in.LINES_LOADER.value.next     = counters_i[CNT_LINES_LOADER];
    hw_in.FB_ROWS.value.next          = counters_i[CNT_FB_ROWS];
    hw_in.RD_STALL.value.next         = counters_i[CNT_RD_STALL];
    hw_in.RAYS_IN_FLIGHT.value.next   = counters_i[CNT_RAYS_IN_FLIGHT];
    hw_in.RAYS_REFLECT.value.next     = counters_i[CNT_RAYS_REFLECT];
    hw_in.RAYS_TRANSMIT.value.next    = counters_i[CNT_RAYS_TRANSMIT];
    hw_in.UV_HITS.value.next          = counters_i[CNT_UV_HITS];
    hw_in.UV_MISSES.value.next        = counters_i[CNT_UV_MISSES];
    hw_in.TEX_HITS.value.next         = counters_i[CNT_TEX_HITS];
    hw_in.TEX_MISSES.value.next       = counters_i[CNT_TEX_MISSES];
    hw_in.LINES_UV.value.next         = counters_i[CNT_LINES_UV];
    hw_in.LINES_TEX.value.next        = counters_i[CNT_LINES_TEX];
    hw_in.TBU_ROOT.value.next         = 32'(tbu_root_i);
    hw_in.TBU_CYCLES.value.next       = tbu_stat_i.cycles;
    hw_in.TBU_NODES.value.next        = tbu_stat_i.nodes;
    hw_in.TBU_ENTRIES.value.next      = tbu_stat_i.entries;
    hw_in.TBU_JUMPS.value.next        = tbu_stat_i.jumps;
    hw_in.TBU_JOBS.value.next         = tbu_stat_i.jobs;
    hw_in.TBU_DONATIONS.value.next    = tbu_stat_i.donations;
    hw_in.TBU_FORCED.value.next       = tbu_stat_i.forced;
    hw_in.TBU_LINES.value.next        = tbu_stat_i.lines;
    hw_in.TBU_ROWS.value.next         = tbu_stat_i.rows;
    hw_in.TBU_WAITS.value.next        = tbu_stat_i.waits;
    hw_in.ACCEL_CYCLES.value.next     = accel_cycles_i;
  end

endmodule
