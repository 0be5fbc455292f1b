// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Shading unit (paper Sec. 3.6; shadow rays, Sec. 3.3): takes what the T&I unit found for a ray index, and answers with a shadow
// ray or with the finished colour.
//
//   hit ──primary hit──▶ cache ──▶ rc_hitpoint ──▶ context RAM ─────┐
//    │                                  │                           ▼
//    │                               updates ◀── updates ─────── rc_light ──▶ shadow rays
//    │                                  │       (no shadow ray)     ▲
//    └─primary miss, shadow ray─▶ arbiter ▶ rc_accum ──jobs─────────┘
//                                             └──▶ finished pixels
//
// No deadlock: nothing that a hit needs waits for a shadow ray to leave. Memory answers, each of the queues of indices has a
// place for all 256 of them, and only rc_light waits for sec_ready_i; see docs/shade.md.
module rc_shade import rc_pkg::*; import rc_shade_pkg::*; #(
  parameter int unsigned InfoSets  = 256,  // cache of triangle information, a line of 480 bits a triangle
  parameter int unsigned InfoWays  = 2,
  parameter int unsigned InfoDepth = 32,   // hits that wait for their line
  parameter int unsigned InfoMiss  = 8     // lines asked for
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  // constant while a frame runs
  input  vec3_t      org_i,                // camera
  input  vec3_t      background_i,
  input  logic       shadows_i,
  input  logic [4:0] light_count_i,
  input  logic [8:0] mat_count_i,
  input  line_addr_t info_base_i,
  // lights and materials, before a frame
  input  logic       ld_valid_i,
  input  logic       ld_light_i,           // 1 light, 0 material
  input  logic [7:0] ld_idx_i,
  input  line_t      ld_line_i,
  // directions of primary rays
  input  logic       dir_valid_i,
  input  ray_id_t    dir_id_i,
  input  vec3_t      dir_i,
  input  logic       hit_valid_i,
  output logic       hit_ready_o,
  input  hit_t       hit_i,
  output logic       sec_valid_o,
  input  logic       sec_ready_i,
  output sec_t       sec_o,
  output logic       done_valid_o,
  input  logic       done_ready_i,
  output done_t      done_o,
  // memory client
  output logic       req_valid_o,
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,
  input  line_t      rsp_line_i,
  output logic       err_valid_o,
  output err_t       err_o,
  output logic       ev_culled_o,          // a shadow ray was not made: the light is behind the surface
  output logic       ev_info_hit_o,
  output logic       ev_info_miss_o
);
  localparam int unsigned NUM_IDS = 2 ** RAY_ID_W;
  logic ld_light_valid, ld_mat_valid;
  assign ld_light_valid = ld_valid_i && ld_light_i;
  assign ld_mat_valid   = ld_valid_i && !ld_light_i;

  // ---- primary hits: triangle information, then the hit-point unit -----------------------------------------------------
  logic             hit_is_surface, info_in_ready, info_valid, info_ready;
  hit_t             info_hit;
  line_t            info_line;
  vec3_t            hit_dir;
  logic             ctx_we, ctx_re;
  ctx_addr_t        ctx_waddr, ctx_raddr;
  logic [CTX_W-1:0] ctx_wdata, ctx_rdata;
  logic             point_valid;
  ray_id_t          point_id;
  mat_id_t          point_mat;
  assign hit_is_surface = hit_i.hit && !hit_i.any_hit;
  rc_ro_cache #(
    .data_t(hit_t), .Sets(InfoSets), .Ways(InfoWays), .Depth(InfoDepth), .MaxMiss(InfoMiss)
  ) u_info (
    .clk_i, .rst_ni,
    .in_valid_i(hit_valid_i && hit_is_surface), .in_ready_o(info_in_ready),
    .in_addr_i(info_base_i + line_addr_t'(hit_i.tri_idx)), .in_data_i(hit_i),
    .out_valid_o(info_valid), .out_ready_i(info_ready), .out_line_o(info_line), .out_data_o(info_hit),
    .req_valid_o, .req_ready_i, .req_addr_o, .rsp_valid_i, .rsp_line_i,
    .ev_hit_o(ev_info_hit_o), .ev_miss_o(ev_info_miss_o)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(NUM_IDS)) u_dirs (
    .clk_i, .we_i(dir_valid_i), .waddr_i(dir_id_i), .wdata_i(dir_i),
    .re_i(info_valid && info_ready), .raddr_i(info_hit.id), .rdata_o(hit_dir)
  );
  rc_hitpoint u_hitpoint (
    .clk_i, .rst_ni, .org_i, .mat_count_i,
    .in_valid_i(info_valid), .in_ready_o(info_ready), .in_hit_i(info_hit), .in_info_i(info_line), .dir_i(hit_dir),
    .ctx_valid_o(ctx_we), .ctx_addr_o(ctx_waddr), .ctx_word_o(ctx_wdata),
    .out_valid_o(point_valid), .out_id_o(point_id), .out_mat_o(point_mat), .err_valid_o, .err_o
  );
  rc_ram_1r1w #(.Width(CTX_W), .Depth(4 * NUM_IDS)) u_ctx (
    .clk_i, .we_i(ctx_we), .waddr_i(ctx_waddr), .wdata_i(ctx_wdata),
    .re_i(ctx_re), .raddr_i(ctx_raddr), .rdata_o(ctx_rdata)
  );

  // ---- lights -------------------------------------------------------------------------------------------------------------
  logic  job_valid, job_ready, k_valid, light_upd_valid, light_upd_add;
  job_t  job, k_job;
  vec3_t k;
  rc_light u_light (
    .clk_i, .rst_ni, .shadows_i,
    .ld_light_valid_i(ld_light_valid), .ld_mat_valid_i(ld_mat_valid), .ld_idx_i, .ld_line_i,
    .job_valid_i(job_valid), .job_ready_o(job_ready), .job_i(job),
    .ctx_re_o(ctx_re), .ctx_addr_o(ctx_raddr), .ctx_word_i(ctx_rdata),
    .k_valid_o(k_valid), .k_job_o(k_job), .k_o(k), .upd_valid_o(light_upd_valid), .upd_add_o(light_upd_add),
    .sec_valid_o, .sec_ready_i, .sec_o, .ev_culled_o
  );

  // ---- updates of colours, from three sides ---------------------------------------------------------------------------------
  typedef struct packed {ray_id_t id; mat_id_t mat;} point_t;
  typedef struct packed {ray_id_t id; logic add;} lit_t;
  point_t     point, point_in;
  lit_t       lit, lit_in;
  logic [2:0] upd_req, upd_gnt;
  logic [1:0] upd_idx, queue_ready;
  logic       upd_ready;
  upd_t       upd;
  logic [1:0][$clog2(NUM_IDS + 1)-1:0] unused_count;
  assign point_in = '{id: point_id, mat: point_mat};
  assign lit_in   = '{id: k_job.id, add: light_upd_add};
  rc_fifo #(.data_t(point_t), .Depth(NUM_IDS)) u_points (
    .clk_i, .rst_ni,
    .in_valid_i(point_valid), .in_ready_o(queue_ready[0]), .in_data_i(point_in),
    .out_valid_o(upd_req[0]), .out_ready_i(upd_ready && upd_gnt[0]), .out_data_o(point), .count_o(unused_count[0])
  );
  rc_fifo #(.data_t(lit_t), .Depth(NUM_IDS)) u_lits (
    .clk_i, .rst_ni,
    .in_valid_i(light_upd_valid), .in_ready_o(queue_ready[1]), .in_data_i(lit_in),
    .out_valid_o(upd_req[1]), .out_ready_i(upd_ready && upd_gnt[1]), .out_data_o(lit), .count_o(unused_count[1])
  );
  assign upd_req[2]  = hit_valid_i && !hit_is_surface;
  assign hit_ready_o = hit_is_surface ? info_in_ready : upd_ready && upd_gnt[2];
  rc_rr_arb #(.NumReq(3)) u_arb (
    .clk_i, .rst_ni, .req_i(upd_req), .ready_i(upd_ready), .gnt_o(upd_gnt), .idx_o(upd_idx)
  );
  always_comb begin
    unique case (upd_idx)
      2'd0:    upd = '{id: point.id, kind: UPD_AMBIENT, add: 1'b0, mat: point.mat};
      2'd1:    upd = '{id: lit.id, kind: UPD_LIGHT, add: lit.add, mat: '0};
      default: upd = '{id: hit_i.id, kind: hit_i.any_hit ? UPD_LIGHT : UPD_MISS, add: !hit_i.hit, mat: '0};
    endcase
  end
  rc_accum u_accum (
    .clk_i, .rst_ni, .background_i, .light_count_i,
    .ld_mat_valid_i(ld_mat_valid), .ld_idx_i, .ld_line_i,
    .k_valid_i(k_valid), .k_job_i(k_job), .k_i(k),
    .upd_valid_i(upd_req != '0), .upd_ready_o(upd_ready), .upd_i(upd),
    .job_valid_o(job_valid), .job_ready_i(job_ready), .job_o(job),
    .done_valid_o, .done_ready_i, .done_o
  );

`ifndef SYNTHESIS
  // A ray index is here or elsewhere, never both: all of the above rests on it.
  logic [NUM_IDS-1:0] inside_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      inside_q <= '0;
    end else begin
      if (hit_valid_i && hit_ready_o) inside_q[hit_i.id] <= 1'b1;
      if (sec_valid_o && sec_ready_i) inside_q[sec_o.id] <= 1'b0;
      if (done_valid_o && done_ready_i) inside_q[done_o.id] <= 1'b0;
      if (hit_valid_i) Elsewhere_M:   assume (!inside_q[hit_i.id] || !hit_ready_o);
      if (dir_valid_i) DirElsewhere_M: assume (!inside_q[dir_id_i]);
      if (sec_valid_o)  SecInside_A:  assert (inside_q[sec_o.id]);
      if (done_valid_o) DoneInside_A: assert (inside_q[done_o.id]);
      if (point_valid)     PointRoom_A: assert (queue_ready[0]);
      if (light_upd_valid) LitRoom_A:   assert (queue_ready[1]);
    end
  end
`else
  logic unused_ready;
  assign unused_ready = &queue_ready;
`endif
endmodule
