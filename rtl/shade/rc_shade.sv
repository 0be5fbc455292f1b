// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Shading unit (paper Sec. 3.6; shadow rays and secondary rays, Sec. 3.3): takes what the T&I unit found for a ray index, and
// answers with the next ray of its pixel or with the finished colour.
//
//   hit ─▶ rc_shade_route ◀─▶ rc_texture                            rc_paths: rays under way
//            │    │     └─ surface ─▶ rc_info ▶ rc_hitpoint ─▶ context RAM ──┐
//            │    └─ blocker ──▶ rc_through ──lights again─┐                  │
//            │                        └ blocked ─┐         ├──▶ rc_light ◀────┤ ──▶ shadow rays
//            └─ miss, shadow ray ─▶ arbiter ▶ rc_accum ──lights─┘             │
//                                               │  └──bounces──▶ rc_secondary ◀┘ ──▶ rays that go on
//                                               └──▶ finished pixels
//
// No deadlock: nothing that a hit needs waits for a ray to leave. Memory answers, each of the queues of indices has a place for
// all 256 of them, and only rc_light and rc_secondary wait for sec_ready_i; see docs/shade.md.
module rc_shade import rc_pkg::*; import rc_shade_pkg::*; #(
  parameter int unsigned InfoSets  = 256,  // cache of triangle information, a line of 480 bits a triangle
  parameter int unsigned InfoWays  = 2,
  parameter int unsigned InfoDepth = 32,   // hits that wait for their line
  parameter int unsigned InfoMiss  = 8     // lines asked for
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  shade_cfg_t cfg_i,                // constant while a frame runs
  // lights and materials, before a frame
  input  logic       ld_valid_i,
  input  ld_kind_e   ld_kind_i,
  input  logic [7:0] ld_idx_i,
  input  line_t      ld_line_i,
  // rays that are no shadow rays, when they leave ray generation
  input  logic       path_ray_valid_i,
  input  path_ray_t  path_ray_i,
  input  logic       hit_valid_i,
  output logic       hit_ready_o,
  input  hit_t       hit_i,
  output logic       sec_valid_o,
  input  logic       sec_ready_i,
  output sec_t       sec_o,
  output logic       done_valid_o,
  input  logic       done_ready_i,
  output done_t      done_o,
  // memory clients: triangle information, texture coordinates, textures
  output logic       req_valid_o,
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,
  input  line_t      rsp_line_i,
  output logic       uv_req_valid_o,
  input  logic       uv_req_ready_i,
  output line_addr_t uv_req_addr_o,
  input  logic       uv_rsp_valid_i,
  input  line_t      uv_rsp_line_i,
  output logic       tex_req_valid_o,
  input  logic       tex_req_ready_i,
  output line_addr_t tex_req_addr_o,
  input  logic       tex_rsp_valid_i,
  input  block64_t   tex_rsp_block_i,
  output logic       err_valid_o,
  output err_t       err_o,
  output logic       ev_culled_o,          // a shadow ray was not made: the light is behind the surface
  output logic       ev_info_hit_o,
  output logic       ev_info_miss_o,
  output logic       ev_uv_hit_o,
  output logic       ev_uv_miss_o,
  output logic [2:0] ev_tex_hit_o,         // blocks
  output logic [2:0] ev_tex_miss_o
);
  localparam int unsigned NUM_IDS = 2 ** RAY_ID_W;
  logic ld_mat_valid, ld_opt_valid;
  assign ld_mat_valid = ld_valid_i && ld_kind_i == LD_MATERIAL;
  assign ld_opt_valid = ld_valid_i && ld_kind_i == LD_OPTICS;

  // ---- the rays under way ------------------------------------------------------------------------------------------------
  logic    path_valid, route_taken, point_taken, accum_taken, ctx_we;
  path_t   path;
  ray_id_t route_id, accum_id;
  fp_t     ray_len, hit_len, point_len;
  vec3_t   point_org, point_dir, point_w, accum_w;
  depth_t  point_depth;
  logic    accum_first;
  tex_t    point_in;
  ctx_addr_t        ctx_waddr, ctx_raddr;
  logic [CTX_W-1:0] ctx_wdata, ctx_rdata;
  ctx_scalar_t      ctx_scalar;
  logic             unused_ctx;
  assign ctx_scalar = ctx_wdata;
  assign unused_ctx = ^ctx_scalar;
  rc_paths u_paths (
    .clk_i, .rst_ni, .ray_valid_i(path_ray_valid_i), .ray_i(path_ray_i), .path_valid_i(path_valid), .path_i(path),
    .len_valid_i(ctx_we && ctx_waddr.word == 2'd3), .len_id_i(ctx_waddr.id), .len_i(ctx_scalar.len),
    .route_re_i(route_taken), .route_id_i(route_id), .route_ray_len_o(ray_len), .route_hit_len_o(hit_len),
    .point_re_i(point_taken), .point_id_i(point_in.hit.id), .point_org_o(point_org), .point_dir_o(point_dir),
    .point_w_o(point_w), .point_len_o(point_len), .point_depth_o(point_depth),
    .accum_re_i(accum_taken), .accum_id_i(accum_id), .accum_w_o(accum_w), .accum_first_o(accum_first)
  );

  // ---- hits, textures ------------------------------------------------------------------------------------------------------
  logic     hit_upd_valid, hit_upd_ready, tex_in_valid, tex_in_ready, tex_out_valid, tex_out_ready;
  logic     surface_valid, surface_ready, blocker_valid, blocker_ready, route_err_valid, point_err_valid;
  upd_t     hit_upd;
  tex_req_t tex_in;
  tex_t     tex_out, surface, blocker;
  err_t     route_err, point_err;
  rc_shade_route u_route (
    .clk_i, .rst_ni, .mat_count_i(cfg_i.mat_count), .ld_mat_valid_i(ld_mat_valid), .ld_idx_i, .ld_line_i,
    .hit_valid_i, .hit_ready_o, .hit_i,
    .taken_o(route_taken), .taken_id_o(route_id), .ray_len_i(ray_len), .hit_len_i(hit_len),
    .upd_valid_o(hit_upd_valid), .upd_ready_i(hit_upd_ready), .upd_o(hit_upd),
    .req_valid_o(tex_in_valid), .req_ready_i(tex_in_ready), .req_o(tex_in),
    .tex_valid_i(tex_out_valid), .tex_ready_o(tex_out_ready), .tex_i(tex_out),
    .surface_valid_o(surface_valid), .surface_ready_i(surface_ready), .surface_o(surface),
    .blocker_valid_o(blocker_valid), .blocker_ready_i(blocker_ready), .blocker_o(blocker),
    .err_valid_o(route_err_valid), .err_o(route_err)
  );
  rc_texture u_texture (
    .clk_i, .rst_ni, .uv_base_i(cfg_i.uv_base), .tex_base_i(cfg_i.tex_base), .mip_bias_i(cfg_i.mip_bias),
    .trilinear_i(cfg_i.trilinear), .ld_valid_i, .ld_kind_i, .ld_idx_i, .ld_line_i,
    .in_valid_i(tex_in_valid), .in_ready_o(tex_in_ready), .in_i(tex_in),
    .out_valid_o(tex_out_valid), .out_ready_i(tex_out_ready), .out_o(tex_out),
    .uv_req_valid_o, .uv_req_ready_i, .uv_req_addr_o, .uv_rsp_valid_i, .uv_rsp_line_i,
    .tex_req_valid_o, .tex_req_ready_i, .tex_req_addr_o, .tex_rsp_valid_i, .tex_rsp_block_i,
    .ev_uv_hit_o, .ev_uv_miss_o, .ev_tex_hit_o, .ev_tex_miss_o
  );

  // ---- surfaces: triangle information, then the hit-point unit; contexts ---------------------------------------------------
  logic      info_valid, info_ready, point_valid, point_ready;
  tri_info_t info;
  point_t    point;
  rc_info #(.Sets(InfoSets), .Ways(InfoWays), .Depth(InfoDepth), .MaxMiss(InfoMiss)) u_info (
    .clk_i, .rst_ni, .info_base_i(cfg_i.info_base), .inst_base_i(cfg_i.inst_base),
    .in_valid_i(surface_valid), .in_ready_o(surface_ready), .in_i(surface),
    .out_valid_o(info_valid), .out_ready_i(info_ready), .out_o(point_in), .out_info_o(info),
    .req_valid_o, .req_ready_i, .req_addr_o, .rsp_valid_i, .rsp_line_i,
    .ev_hit_o(ev_info_hit_o), .ev_miss_o(ev_info_miss_o)
  );
  assign point_taken = info_valid && info_ready;
  rc_hitpoint u_hitpoint (
    .clk_i, .rst_ni, .max_depth_i(cfg_i.max_depth), .mat_count_i(cfg_i.mat_count),
    .ld_mat_valid_i(ld_mat_valid), .ld_idx_i, .ld_line_i,
    .in_valid_i(info_valid), .in_ready_o(info_ready), .in_i(point_in), .in_info_i(info),
    .org_i(point_org), .dir_i(point_dir), .w_i(point_w), .len_i(point_len), .depth_i(point_depth),
    .ctx_valid_o(ctx_we), .ctx_addr_o(ctx_waddr), .ctx_word_o(ctx_wdata),
    .out_valid_o(point_valid), .out_ready_i(point_ready), .out_o(point),
    .err_valid_o(point_err_valid), .err_o(point_err)
  );
  logic      light_re, sec_re;
  ctx_addr_t light_raddr, sec_raddr;
  assign ctx_raddr = light_re ? light_raddr : sec_raddr;
  rc_ram_1r1w #(.Width(CTX_W), .Depth(4 * NUM_IDS)) u_ctx (
    .clk_i, .we_i(ctx_we), .waddr_i(ctx_waddr), .wdata_i(ctx_wdata),
    .re_i(light_re || sec_re), .raddr_i(ctx_raddr), .rdata_o(ctx_rdata)
  );
  assign err_valid_o = route_err_valid || point_err_valid;
  assign err_o       = route_err_valid ? route_err : point_err;

  // ---- lights and rays that go on; they share the contexts' read port -------------------------------------------------------
  logic    next_valid, next_ready, again_valid, again_ready, light_valid, light_ready, bounce_valid, bounce_ready;
  logic    sec_wants, sec_start, k_valid, lit_valid, lit_add, end_valid, end_ready;
  logic    start_valid, block_valid, block_ready;
  job_t    next_job, again_job, light_job, k_job;
  bounce_t bounce;
  ray_id_t end_id, start_id, block_id;
  vec3_t   k, tr;
  logic [NUM_IDS-1:0] pending;             // rays on a pixel's stack
  logic [1:0] ray_valid, ray_ready;        // [0] shadow ray, [1] ray that goes on
  sec_t [1:0] ray;
  rc_shade_start u_start (
    .clk_i, .rst_ni, .next_valid_i(next_valid), .next_ready_o(next_ready), .next_i(next_job),
    .again_valid_i(again_valid), .again_ready_o(again_ready), .again_i(again_job),
    .light_valid_o(light_valid), .light_ready_i(light_ready), .light_o(light_job),
    .sec_wants_i(sec_wants), .sec_start_o(sec_start)
  );
  rc_light u_light (
    .clk_i, .rst_ni, .shadows_i(cfg_i.shadows), .ld_valid_i, .ld_kind_i, .ld_idx_i, .ld_line_i,
    .job_valid_i(light_valid), .job_ready_o(light_ready), .job_i(light_job),
    .ctx_re_o(light_re), .ctx_addr_o(light_raddr), .ctx_word_i(ctx_rdata),
    .k_valid_o(k_valid), .k_job_o(k_job), .k_o(k), .upd_valid_o(lit_valid), .upd_add_o(lit_add),
    .sec_valid_o(ray_valid[0]), .sec_ready_i(ray_ready[0]), .sec_o(ray[0]), .ev_culled_o
  );
  rc_through u_through (
    .clk_i, .rst_ni, .min_weight_i(cfg_i.min_weight), .ld_mat_valid_i(ld_mat_valid), .ld_opt_valid_i(ld_opt_valid),
    .ld_idx_i, .ld_line_i, .k_valid_i(k_valid), .k_job_i(k_job), .start_i(start_valid), .start_id_i(start_id),
    .tr_re_i(accum_taken), .tr_id_i(accum_id), .tr_o(tr),
    .in_valid_i(blocker_valid), .in_ready_o(blocker_ready), .in_i(blocker),
    .block_valid_o(block_valid), .block_ready_i(block_ready), .block_id_o(block_id),
    .job_valid_o(again_valid), .job_ready_i(again_ready), .job_o(again_job)
  );
  rc_secondary u_secondary (
    .clk_i, .rst_ni, .min_weight_i(cfg_i.min_weight), .ld_valid_i, .ld_kind_i, .ld_idx_i, .ld_line_i,
    .job_valid_i(bounce_valid), .job_ready_o(bounce_ready), .job_i(bounce),
    .start_o(sec_wants), .start_gnt_i(sec_start),
    .ctx_re_o(sec_re), .ctx_addr_o(sec_raddr), .ctx_word_i(ctx_rdata),
    .sec_valid_o(ray_valid[1]), .sec_ready_i(ray_ready[1]), .sec_o(ray[1]),
    .path_valid_o(path_valid), .path_o(path),
    .end_valid_o(end_valid), .end_ready_i(end_ready), .end_id_o(end_id), .pending_o(pending)
  );

  // ---- rays leave by turns; a register holds the one that is offered ----------------------------------------------------------
  logic       out_free;
  logic [0:0] ray_idx;
  logic [1:0] ray_gnt;
  assign out_free  = !sec_valid_o || sec_ready_i;
  assign ray_ready = ray_gnt & {2{out_free}};
  rc_rr_arb #(.NumReq(2)) u_rays (
    .clk_i, .rst_ni, .req_i(ray_valid), .ready_i(out_free), .gnt_o(ray_gnt), .idx_o(ray_idx)
  );
  always_ff @(posedge clk_i) begin
    if (!rst_ni)       sec_valid_o <= 1'b0;
    else if (out_free) sec_valid_o <= ray_valid != '0;
    if (out_free) sec_o <= ray[ray_idx];
  end

  // ---- updates of colours, from five sides --------------------------------------------------------------------------------------
  typedef struct packed {ray_id_t id; logic add;} lit_t;
  lit_t       lit, lit_in;
  logic [4:0] upd_req, upd_gnt;
  logic [2:0] upd_idx;
  logic       upd_ready, lit_room;
  upd_t       upd;
  logic [$clog2(NUM_IDS + 1)-1:0] unused_lits;
  function automatic upd_t update_of(upd_e kind, logic add, ray_id_t id);
    return '{kind: kind, add: add, point: '{id: id, mat: '0, bounces: 1'b0, branch: 1'b0, alpha: '0, tex: '0}};
  endfunction
  assign lit_in  = '{id: k_job.id, add: lit_add};
  rc_fifo #(.data_t(lit_t), .Depth(NUM_IDS)) u_lits (
    .clk_i, .rst_ni,
    .in_valid_i(lit_valid), .in_ready_o(lit_room), .in_data_i(lit_in),
    .out_valid_o(upd_req[1]), .out_ready_i(upd_ready && upd_gnt[1]), .out_data_o(lit), .count_o(unused_lits)
  );
  assign {upd_req[4:2], upd_req[0]} = {end_valid, block_valid, hit_upd_valid, point_valid};
  assign {end_ready, block_ready, hit_upd_ready, point_ready} = {upd_gnt[4:2], upd_gnt[0]} & {4{upd_ready}};
  rc_rr_arb #(.NumReq(5)) u_arb (
    .clk_i, .rst_ni, .req_i(upd_req), .ready_i(upd_ready), .gnt_o(upd_gnt), .idx_o(upd_idx)
  );
  always_comb begin
    unique case (upd_idx)
      3'd0:    upd = '{kind: UPD_SURFACE, add: 1'b0, point: point};
      3'd1:    upd = update_of(UPD_LIGHT, lit.add, lit.id);
      3'd2:    upd = hit_upd;
      3'd3:    upd = update_of(UPD_LIGHT, 1'b0, block_id);
      default: upd = update_of(UPD_END, 1'b0, end_id);
    endcase
  end
  rc_accum u_accum (
    .clk_i, .rst_ni, .background_i(cfg_i.background), .light_count_i(cfg_i.light_count),
    .ld_mat_valid_i(ld_mat_valid), .ld_idx_i, .ld_line_i, .k_valid_i(k_valid), .k_job_i(k_job), .k_i(k),
    .upd_valid_i(upd_req != '0), .upd_ready_o(upd_ready), .upd_i(upd),
    .taken_o(accum_taken), .taken_id_o(accum_id), .w_i(accum_w), .first_i(accum_first), .tr_i(tr),
    .pending_i(pending), .start_o(start_valid), .start_id_o(start_id),
    .job_valid_o(next_valid), .job_ready_i(next_ready), .job_o(next_job),
    .bounce_valid_o(bounce_valid), .bounce_o(bounce), .done_valid_o, .done_ready_i, .done_o
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
      if (hit_valid_i) Elsewhere_M: assume (!inside_q[hit_i.id] || !hit_ready_o);
      if (path_ray_valid_i) RayElsewhere_M: assume (!inside_q[path_ray_i.id]);
      if (sec_valid_o)  SecInside_A:  assert (inside_q[sec_o.id]);
      if (done_valid_o) DoneInside_A: assert (inside_q[done_o.id]);
      if (lit_valid)    LitRoom_A:    assert (lit_room);
      if (bounce_valid) BounceRoom_A: assert (bounce_ready);
      CtxPort_A: assert (!(light_re && sec_re));
    end
  end
`else
  logic unused_room;
  assign unused_room = lit_room && bounce_ready;
`endif
endmodule
