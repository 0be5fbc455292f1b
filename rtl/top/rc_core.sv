// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// RayCore without its registers: frame control, tree builder, record unit, dispatcher, ray-tracing units, memory ports.
module rc_core import rc_pkg::*; import rc_mem_pkg::*; import rc_top_pkg::*; import rc_tbu_pkg::*; #(
  parameter int unsigned DataW = 64,         // memory bus: 64, 128 or 256 bits
  parameter int unsigned IdW   = 1,          // memory bus: bits of an ID
  parameter bit          Tbu   = 1'b1,       // with the tree builder
  parameter int unsigned Cap   = 1280,       // references of a sorting pipeline of the tree builder
  parameter bit          Accel = Tbu,        // with the record unit
  parameter int unsigned NtSets   = 128,     // caches, as in rc_rtu
  parameter int unsigned ListSets = 32,
  parameter int unsigned L2Sets   = 256,
  parameter int unsigned L2Ways   = 14,
  parameter int unsigned NumRtus  = 1,       // ray-tracing units
  parameter int unsigned MaxReads = NumRtus > 1 ? 32 : 16   // reads sent and not yet answered
) (
  input  logic               clk_i,
  input  logic               rst_ni,
  input  logic               render_i,       // start a frame that renders, builds a tree, makes records, or all of it
  input  logic               build_i,
  input  logic               accel_i,
  input  setup_t             setup_i,        // constant while busy
  output status_t            status_o,
  output logic               end_o,          // one cycle, with the final status
  output counters_t          counters_o,
  output idx_t               tbu_root_o,     // of the tree builder, until the next build; NODE_NONE: no tree
  output tbu_stat_t          tbu_stat_o,
  output logic [31:0]        accel_cycles_o, // of the record unit
  output trace_t [NumRtus-1:0] trace_o,      // for simulations

  output logic [IdW-1:0]     m_axi_arid,
  output addr_t              m_axi_araddr,
  output logic [7:0]         m_axi_arlen,
  output logic [2:0]         m_axi_arsize,
  output logic [1:0]         m_axi_arburst,
  output logic               m_axi_arvalid,
  input  logic               m_axi_arready,
  input  logic [IdW-1:0]     m_axi_rid,
  input  logic [DataW-1:0]   m_axi_rdata,
  input  logic [1:0]         m_axi_rresp,
  input  logic               m_axi_rlast,
  input  logic               m_axi_rvalid,
  output logic               m_axi_rready,
  output logic [IdW-1:0]     m_axi_awid,
  output addr_t              m_axi_awaddr,
  output logic [7:0]         m_axi_awlen,
  output logic [2:0]         m_axi_awsize,
  output logic [1:0]         m_axi_awburst,
  output logic               m_axi_awvalid,
  input  logic               m_axi_awready,
  output logic [DataW-1:0]   m_axi_wdata,
  output logic [DataW/8-1:0] m_axi_wstrb,
  output logic               m_axi_wlast,
  output logic               m_axi_wvalid,
  input  logic               m_axi_wready,
  input  logic [IdW-1:0]     m_axi_bid,
  input  logic [1:0]         m_axi_bresp,
  input  logic               m_axi_bvalid,
  output logic               m_axi_bready
);
  // ---- frame control --------------------------------------------------------------------------------
  logic                      unit_rst_n, build_rst_n, stop, clear, count;
  logic                      render, build, building, build_start, build_done, accel, accel_start, accel_done;
  logic                      load_start, load_busy, trace_start, all_sent, rtu_idle, rd_idle, wr_idle;
  logic                      bad;
  addr_t                     bad_reg;
  window_t [NUM_WINDOWS-1:0] rd_window;
  window_t [NUM_WR_WINDOWS-1:0] wr_window;
  logic                      rtu_err_valid, rd_err_valid, wr_err_valid, tbu_err_valid, accel_err_valid;
  err_t                      rtu_err, rd_err, wr_err, tbu_err, accel_err;

  rc_setup_check #(.Tbu(Tbu), .Accel(Accel)) u_setup_check (
    .clk_i, .setup_i, .render_i(render), .build_i(build), .accel_i(accel), .building_i(building),
    .rd_window_o(rd_window), .wr_window_o(wr_window), .bad_o(bad), .bad_reg_o(bad_reg)
  );
  rc_frame_ctrl #(.NumErr(5)) u_ctrl (
    .clk_i, .rst_ni, .render_i, .build_i, .accel_i, .status_o, .end_o, .clear_o(clear), .count_o(count),
    .bad_i(bad), .bad_reg_i(bad_reg),
    .err_valid_i({accel_err_valid, tbu_err_valid, wr_err_valid, rd_err_valid, rtu_err_valid}),
    .err_i({accel_err, tbu_err, wr_err, rd_err, rtu_err}),
    .render_o(render), .build_o(build), .accel_o(accel),
    .unit_rst_no(unit_rst_n), .build_rst_no(build_rst_n), .stop_o(stop), .build_start_o(build_start),
    .accel_start_o(accel_start), .building_o(building), .build_done_i(build_done), .accel_done_i(accel_done),
    .load_start_o(load_start), .load_busy_i(load_busy),
    .trace_start_o(trace_start), .units_idle_i(all_sent && rtu_idle), .ports_idle_i(rd_idle && wr_idle)
  );

  // ---- read port ----------------------------------------------------------------------------------------
  localparam int unsigned NUM_RD = RD_RTU + NumRtus;
  logic       [NUM_RD-1:0] req_valid, req_ready, rsp_valid, ev_line;
  line_addr_t [NUM_RD-1:0] req_addr;
  logic  [NUM_RD-1:0][1:0] req_halves;
  rd_tag_t    [NUM_RD-1:0] req_tag;
  rd_tag_t                 rsp_tag, ev_tag;
  block64_t                rsp_block;
  line_t                   ld_line;
  logic                    ld_valid;
  ld_kind_e                ld_kind;
  logic       [7:0]        ld_idx;
  assign req_halves[RD_RTU-1:0] = '1;
  assign req_tag[RD_RTU-1:0]    = '0;

  // ---- tree ---------------------------------------------------------------------------------------------
  // Writers while the memory ports are theirs: [0] the tree builder, [1] the record unit.
  logic                  wr_ready, wr_ack, made_valid;
  addr_t                 made_addr;
  logic [7:0][31:0]      made_data;
  logic [7:0]            made_strb;
  logic [1:0]            mk_valid, mk_ready, mk_ack;
  logic                  tbu_wr_idle, unused_mk_idle;
  addr_t [1:0]           mk_addr;
  logic [1:0][7:0][31:0] mk_data;
  logic [1:0][7:0]       mk_strb;
  tree_cfg_t        tree;
  always_comb begin
    tree = setup_i.tree;
    if (build) tree.root = tbu_root_o;
  end
  if (Tbu) begin : gen_tbu
    tbu_cfg_t cfg;
    tbu_err_e err;
    idx_t     built_root;
    logic     rd_valid, unused_busy;
    assign cfg = '{
      vertex_base: setup_i.vertex_base,
      tri_count: setup_i.tree.tri_count[IDX_W-1:COUNT_W] != '0 ? '1 : setup_i.tree.tri_count[COUNT_W-1:0],
      node_base: setup_i.tree.node_base, node_count: setup_i.tree.node_count,
      list_base: setup_i.tree.list_base, list_count: setup_i.tree.list_count,
      ref_base: setup_i.ref_base, ref_count: setup_i.ref_count, refine_max: setup_i.refine_max, box: setup_i.tri_box,
      node_first: setup_i.node_first, list_first: setup_i.list_first, tri_first: setup_i.tri_first
    };
    rc_tbu #(.Cap(Cap)) u_tbu (
      .clk_i, .rst_ni(rst_ni && build_rst_n), .start_i(build_start), .cfg_i(cfg),
      .busy_o(unused_busy), .done_o(build_done), .err_o(err), .root_o(built_root), .stat_o(tbu_stat_o),
      .rd_valid_o(rd_valid), .rd_ready_i(req_ready[RD_TBU]), .rd_addr_o(req_addr[RD_TBU]),
      .rd_rsp_valid_i(rsp_valid[RD_TBU]), .rd_rsp_block_i(rsp_block),
      .wr_valid_o(mk_valid[0]), .wr_ready_i(mk_ready[0]), .wr_addr_o(mk_addr[0]), .wr_data_o(mk_data[0]),
      .wr_strb_o(mk_strb[0]), .wr_ack_i(mk_ack[0]), .wr_idle_i(tbu_wr_idle),
      .mem_err_i(rd_err_valid || wr_err_valid)
    );
    always_ff @(posedge clk_i) begin           // frames without a build reset the builder and leave its root
      if (!rst_ni || build_start) tbu_root_o <= NODE_NONE;
      else if (build_done)        tbu_root_o <= built_root;
    end
    assign req_valid[RD_TBU] = building && rd_valid;
    // What the ports report is reported once.
    assign tbu_err_valid     = build_done && err != TBU_OK && err != TBU_BUS;
    always_comb begin
      case (err)
        TBU_NODE:  tbu_err = '{code: ERR_TBU_NODE,  addr: addr_t'(setup_i.tree.node_count)};
        TBU_LIST:  tbu_err = '{code: ERR_TBU_LIST,  addr: addr_t'(setup_i.tree.list_count)};
        TBU_REF:   tbu_err = '{code: ERR_TBU_REF,   addr: addr_t'(setup_i.ref_count)};
        TBU_COUNT: tbu_err = '{code: ERR_TBU_COUNT, addr: addr_t'(setup_i.tree.tri_count)};
        default:   tbu_err = '{code: ERR_TBU_COORD, addr: '0};
      endcase
    end
  end else begin : gen_no_tbu
    assign {build_done, mk_valid[0], mk_addr[0], mk_data[0], mk_strb[0], tbu_root_o, tbu_stat_o} = '0;
    assign {req_valid[RD_TBU], req_addr[RD_TBU], tbu_err_valid} = '0;
    assign tbu_err = '{code: ERR_NONE, addr: '0};
  end

  // ---- records ------------------------------------------------------------------------------------------
  if (Accel) begin : gen_accel
    rc_accel_pkg::accel_cfg_t cfg;
    idx_t bad_idx;
    logic rd_valid, unused_busy;
    assign cfg = '{
      vertex_base: setup_i.vertex_base, attr_base: setup_i.attr_base, accel_base: setup_i.tree.accel_base,
      info_base: setup_i.info_base, tri_count: setup_i.tree.tri_count, eye: setup_i.eye, slack: setup_i.slack
    };
    rc_accel u_accel (
      .clk_i, .rst_ni(rst_ni && build_rst_n), .start_i(accel_start), .cfg_i(cfg), .busy_o(unused_busy),
      .done_o(accel_done), .bad_o(accel_err_valid), .bad_idx_o(bad_idx), .cycles_o(accel_cycles_o),
      .rd_valid_o(rd_valid), .rd_ready_i(req_ready[RD_ACCEL]), .rd_addr_o(req_addr[RD_ACCEL]),
      .rd_rsp_valid_i(rsp_valid[RD_ACCEL]), .rd_rsp_block_i(rsp_block),
      .wr_valid_o(mk_valid[1]), .wr_ready_i(mk_ready[1]), .wr_addr_o(mk_addr[1]), .wr_data_o(mk_data[1]),
      .wr_ack_i(mk_ack[1])
    );
    assign req_valid[RD_ACCEL] = building && rd_valid;
    assign mk_strb[1]          = '1;
    assign accel_err           = '{code: ERR_TBU_COORD, addr: addr_t'(bad_idx)};
  end else begin : gen_no_accel
    assign {accel_done, accel_err_valid, accel_cycles_o, mk_valid[1], mk_addr[1], mk_data[1], mk_strb[1]} = '0;
    assign {req_valid[RD_ACCEL], req_addr[RD_ACCEL]} = '0;
    assign accel_err = '{code: ERR_NONE, addr: '0};
  end
  if (Tbu || Accel) begin : gen_share
    rc_mem_share #(.NumWriters(2), .MaxBurst(16)) u_share (
      .clk_i, .rst_ni(rst_ni && build_rst_n), .wr_valid_i(mk_valid), .wr_ready_o(mk_ready), .wr_addr_i(mk_addr),
      .wr_data_i(mk_data), .wr_strb_i(mk_strb), .ack_o(mk_ack), .idle_o({unused_mk_idle, tbu_wr_idle}),
      .port_valid_o(made_valid), .port_ready_i(building && wr_ready), .port_addr_o(made_addr), .port_data_o(made_data),
      .port_strb_o(made_strb), .port_ack_i(building && wr_ack)
    );
  end else begin : gen_no_share
    assign {made_valid, made_addr, made_data, made_strb, mk_ready, mk_ack, tbu_wr_idle, unused_mk_idle} = '0;
  end

  // ---- lights and materials ---------------------------------------------------------------------------
  rc_loader u_loader (
    .clk_i, .rst_ni(unit_rst_n), .start_i(load_start), .busy_o(load_busy),
    .light_base_i(setup_i.light_base), .light_count_i(setup_i.light_count[4:0]),
    .mat_base_i(setup_i.mat_base), .mat_count_i(setup_i.mat_count[8:0]),
    .req_valid_o(req_valid[RD_LOADER]), .req_ready_i(req_ready[RD_LOADER]), .req_addr_o(req_addr[RD_LOADER]),
    .rsp_valid_i(rsp_valid[RD_LOADER]), .rsp_line_i(used_bits(rsp_block)),
    .ld_valid_o(ld_valid), .ld_kind_o(ld_kind), .ld_idx_o(ld_idx), .ld_line_o(ld_line)
  );

  // ---- rays ---------------------------------------------------------------------------------------------
  logic   [NumRtus-1:0] blk_valid, blk_ready;
  block_t [NumRtus-1:0] blk;
  shade_cfg_t           shade_cfg;
  rtu_ev_t [NumRtus-1:0] rtu_ev;
  logic             wr_valid;
  addr_t            wr_addr;
  logic [7:0][31:0] wr_data;
  logic [7:0]       wr_strb;
  assign shade_cfg = '{
    info_base: setup_i.info_base, inst_base: setup_i.tree.inst_base, uv_base: setup_i.uv_base,
    tex_base: setup_i.tex_base, mip_bias: setup_i.mip_bias,
    trilinear: setup_i.trilinear, max_depth: setup_i.max_depth, min_weight: setup_i.min_weight,
    mat_count: setup_i.mat_count[8:0], light_count: setup_i.light_count[4:0],
    shadows: setup_i.shadows, background: setup_i.background
  };
  rc_dispatch #(.NumRtus(NumRtus)) u_dispatch (
    .clk_i, .rst_ni(unit_rst_n), .start_i(trace_start),
    .width_i(setup_i.frame.width), .height_i(setup_i.frame.height),
    .tile_x_i(setup_i.tile_x), .tile_y_i(setup_i.tile_y), .tile_count_i(setup_i.tile_count),
    .blk_valid_o(blk_valid), .blk_ready_i(blk_ready), .blk_o(blk), .all_sent_o(all_sent)
  );
  rc_rtus #(
    .NumRtus(NumRtus), .NtSets(NtSets), .ListSets(ListSets), .L2Sets(L2Sets), .L2Ways(L2Ways)
  ) u_rtus (
    .clk_i, .rst_ni(unit_rst_n),
    .tree_i(tree), .camera_i(setup_i.camera), .shade_i(shade_cfg), .frame_i(setup_i.frame),
    .blk_valid_i(blk_valid), .blk_ready_o(blk_ready), .blk_i(blk),
    .ld_valid_i(ld_valid), .ld_kind_i(ld_kind), .ld_idx_i(ld_idx), .ld_line_i(ld_line),
    .req_valid_o(req_valid[NUM_RD-1:RD_RTU]), .req_ready_i(req_ready[NUM_RD-1:RD_RTU]),
    .req_addr_o(req_addr[NUM_RD-1:RD_RTU]), .req_halves_o(req_halves[NUM_RD-1:RD_RTU]),
    .req_tag_o(req_tag[NUM_RD-1:RD_RTU]),
    .rsp_valid_i(rsp_valid[NUM_RD-1:RD_RTU]), .rsp_tag_i(rsp_tag), .rsp_block_i(rsp_block),
    .wr_valid_o(wr_valid), .wr_ready_i(!building && wr_ready),
    .wr_addr_o(wr_addr), .wr_data_o(wr_data), .wr_strb_o(wr_strb),
    .err_valid_o(rtu_err_valid), .err_o(rtu_err), .idle_o(rtu_idle),
    .ev_o(rtu_ev), .trace_o
  );

  // ---- memory ---------------------------------------------------------------------------------------------
  // First the builders write, then the colour buffer.
  logic ev_row;
  rc_mem_rd #(
    .NumClients(NUM_RD), .TagW($bits(rd_tag_t)), .NumWindows(NUM_WINDOWS), .DataW(DataW), .IdW(IdW), .MaxBurst(MaxReads)
  ) u_mem_rd (
    .clk_i, .rst_ni, .window_i(rd_window), .stop_i(stop), .idle_o(rd_idle),
    .err_valid_o(rd_err_valid), .err_o(rd_err),
    .req_valid_i(req_valid), .req_ready_o(req_ready), .req_addr_i(req_addr), .req_halves_i(req_halves),
    .req_tag_i(req_tag), .rsp_valid_o(rsp_valid), .rsp_tag_o(rsp_tag), .rsp_block_o(rsp_block),
    .ev_line_o(ev_line), .ev_tag_o(ev_tag),
    .m_axi_arid, .m_axi_araddr, .m_axi_arlen, .m_axi_arsize, .m_axi_arburst, .m_axi_arvalid, .m_axi_arready,
    .m_axi_rid, .m_axi_rdata, .m_axi_rresp, .m_axi_rlast, .m_axi_rvalid, .m_axi_rready
  );
  rc_mem_wr #(.NumWindows(NUM_WR_WINDOWS), .DataW(DataW), .IdW(IdW)) u_mem_wr (
    .clk_i, .rst_ni, .window_i(wr_window), .stop_i(stop), .idle_o(wr_idle),
    .err_valid_o(wr_err_valid), .err_o(wr_err),
    .wr_valid_i(building ? made_valid : wr_valid), .wr_ready_o(wr_ready),
    .wr_addr_i(building ? made_addr : wr_addr), .wr_data_i(building ? made_data : wr_data),
    .wr_strb_i(building ? made_strb : wr_strb), .ev_row_o(ev_row), .ack_o(wr_ack),
    .m_axi_awid, .m_axi_awaddr, .m_axi_awlen, .m_axi_awsize, .m_axi_awburst, .m_axi_awvalid, .m_axi_awready,
    .m_axi_wdata, .m_axi_wstrb, .m_axi_wlast, .m_axi_wvalid, .m_axi_wready,
    .m_axi_bid, .m_axi_bresp, .m_axi_bvalid, .m_axi_bready
  );
  logic [NUM_RD_TAGS-1:0] rtu_line;
  assign rtu_line = (ev_line[NUM_RD-1:RD_RTU] != '0) ? NUM_RD_TAGS'(1) << ev_tag : '0;
  rc_counters #(.NumRtus(NumRtus)) u_counters (
    .clk_i, .rst_ni, .clear_i(clear), .count_i(count), .rtu_ev_i(building ? '0 : rtu_ev),
    .line_i(rtu_line), .line_loader_i(ev_line[RD_LOADER]),
    .rd_stall_i(m_axi_arvalid && !m_axi_arready), .row_i(ev_row && !building), .counters_o
  );

endmodule
