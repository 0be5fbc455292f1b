// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Ray-tracing unit (paper Sec. 3.2, Fig. 3): the ring of setup, ray generation, T&I, shading and colour
// buffer. Wiring only; docs/seams.md says what passes where. Settings are constant while a frame runs.
module rc_rtu import rc_pkg::*, rc_rgen_pkg::*; #(
  parameter int unsigned NtSets   = 128,   // L1 node/TriAccel caches, 2 ways x 64 bytes: see docs/memory.md
  parameter int unsigned ListSets = 32,    // L1 list caches
  parameter int unsigned L2Sets   = 256,   // L2 cache, of 64 bytes
  parameter int unsigned L2Ways   = 14,
  parameter int unsigned InfoSets = 256    // triangle-information cache, 2 ways x 64 bytes
) (
  input  logic             clk_i,
  input  logic             rst_ni,         // also empties all caches
  input  tree_cfg_t        tree_i,
  input  camera_t          camera_i,
  input  shade_cfg_t       shade_i,
  input  frame_cfg_t       frame_i,
  input  logic             blk_valid_i,    // blocks of 8x8 pixels to render
  output logic             blk_ready_o,
  input  block_t           blk_i,
  input  logic             ld_valid_i,     // lights and materials, before the first block
  input  ld_kind_e         ld_kind_i,
  input  logic [7:0]       ld_idx_i,
  input  line_t            ld_line_i,
  output logic             tni_req_valid_o,   // memory: T&I unit
  input  logic             tni_req_ready_i,
  output half_addr_t       tni_req_addr_o,
  input  logic             tni_rsp_valid_i,
  input  half_line_t       tni_rsp_half_i,
  output logic             tri_req_valid_o,   // memory: triangle information
  input  logic             tri_req_ready_i,
  output line_addr_t       tri_req_addr_o,
  input  logic             tri_rsp_valid_i,
  input  line_t            tri_rsp_line_i,
  output logic             uv_req_valid_o,    // memory: texture coordinates
  input  logic             uv_req_ready_i,
  output line_addr_t       uv_req_addr_o,
  input  logic             uv_rsp_valid_i,
  input  line_t            uv_rsp_line_i,
  output logic             tex_req_valid_o,   // memory: textures
  input  logic             tex_req_ready_i,
  output line_addr_t       tex_req_addr_o,
  input  logic             tex_rsp_valid_i,
  input  block64_t         tex_rsp_block_i,
  output logic             wr_valid_o,        // memory: rows of pixels
  input  logic             wr_ready_i,
  output addr_t            wr_addr_o,
  output logic [7:0][31:0] wr_data_o,
  output logic [7:0]       wr_strb_o,
  output logic             err_valid_o,
  output err_t             err_o,
  output logic             idle_o,            // no block is open
  output rtu_ev_t          ev_o,
  output trace_t           trace_o
);
  logic      open_valid, open_ready, map_valid, free_valid;
  open_t     open;
  blk_slot_t open_slot;
  map_t      map;
  ray_id_t   free_id;
  path_ray_t path_ray;
  logic      pri_valid, pri_ready, sec_valid, sec_ready, ray_valid, ray_ready, path_ray_valid;
  logic      hit_valid, hit_ready, done_valid, done_ready;
  pri_t      pri;
  sec_t      sec;
  ray_t      ray;
  pipe_id_t  ray_home;
  hit_t      hit;
  done_t     done;
  logic      tni_err_valid, shade_err_valid;
  err_t      tni_err, shade_err;
  tni_trace_t [3:0] tni_trace;

  rc_setup u_setup (
    .clk_i, .rst_ni, .width_i(frame_i.width), .height_i(frame_i.height), .blk_valid_i, .blk_ready_o, .blk_i,
    .open_valid_o(open_valid), .open_ready_i(open_ready), .open_o(open), .open_slot_i(open_slot),
    .pri_valid_o(pri_valid), .pri_ready_i(pri_ready), .pri_o(pri), .map_valid_o(map_valid), .map_o(map),
    .free_valid_i(free_valid), .free_id_i(free_id)
  );

  rc_raygen u_raygen (
    .clk_i, .rst_ni, .cam_i(camera_i), .pri_valid_i(pri_valid), .pri_ready_o(pri_ready), .pri_i(pri),
    .sec_valid_i(sec_valid), .sec_ready_o(sec_ready), .sec_i(sec),
    .ray_valid_o(ray_valid), .ray_ready_i(ray_ready), .ray_o(ray), .ray_home_o(ray_home),
    .path_ray_valid_o(path_ray_valid), .path_ray_o(path_ray)
  );

  rc_tni #(.NtSets(NtSets), .ListSets(ListSets), .L2Sets(L2Sets), .L2Ways(L2Ways)) u_tni (
    .clk_i, .rst_ni, .cfg_i(tree_i), .in_valid_i(ray_valid), .in_ready_o(ray_ready), .in_i(ray), .in_home_i(ray_home),
    .out_valid_o(hit_valid), .out_ready_i(hit_ready), .out_o(hit),
    .req_valid_o(tni_req_valid_o), .req_ready_i(tni_req_ready_i), .req_addr_o(tni_req_addr_o),
    .rsp_valid_i(tni_rsp_valid_i), .rsp_half_i(tni_rsp_half_i),
    .err_valid_o(tni_err_valid), .err_o(tni_err), .ev_o(ev_o.tni), .trace_o(tni_trace), .ev_l2_hit_o(ev_o.l2_hit),
    .ev_l2_miss_o(ev_o.l2_miss)
  );

  rc_shade #(.InfoSets(InfoSets)) u_shade (
    .clk_i, .rst_ni, .cfg_i(shade_i), .ld_valid_i, .ld_kind_i, .ld_idx_i, .ld_line_i,
    .path_ray_valid_i(path_ray_valid), .path_ray_i(path_ray),
    .hit_valid_i(hit_valid), .hit_ready_o(hit_ready), .hit_i(hit),
    .sec_valid_o(sec_valid), .sec_ready_i(sec_ready), .sec_o(sec),
    .done_valid_o(done_valid), .done_ready_i(done_ready), .done_o(done),
    .req_valid_o(tri_req_valid_o), .req_ready_i(tri_req_ready_i), .req_addr_o(tri_req_addr_o),
    .rsp_valid_i(tri_rsp_valid_i), .rsp_line_i(tri_rsp_line_i),
    .uv_req_valid_o, .uv_req_ready_i, .uv_req_addr_o, .uv_rsp_valid_i, .uv_rsp_line_i,
    .tex_req_valid_o, .tex_req_ready_i, .tex_req_addr_o, .tex_rsp_valid_i, .tex_rsp_block_i,
    .err_valid_o(shade_err_valid), .err_o(shade_err),
    .ev_culled_o(ev_o.culled), .ev_info_hit_o(ev_o.tri_hit), .ev_info_miss_o(ev_o.tri_miss),
    .ev_uv_hit_o(ev_o.uv_hit), .ev_uv_miss_o(ev_o.uv_miss), .ev_tex_hit_o(ev_o.tex_hit), .ev_tex_miss_o(ev_o.tex_miss)
  );

  rc_pixbuf u_pixbuf (
    .clk_i, .rst_ni, .width_i(frame_i.width), .height_i(frame_i.height), .fb_base_i(frame_i.fb_base),
    .fb_stride_i(frame_i.fb_stride), .fb_rgb10_i(frame_i.rgb10),
    .open_valid_i(open_valid), .open_ready_o(open_ready), .open_i(open), .open_slot_o(open_slot),
    .map_valid_i(map_valid), .map_i(map), .done_valid_i(done_valid), .done_ready_o(done_ready), .done_i(done),
    .free_valid_o(free_valid), .free_id_o(free_id), .wr_valid_o, .wr_ready_i, .wr_addr_o, .wr_data_o, .wr_strb_o,
    .idle_o
  );

  assign err_valid_o = tni_err_valid || shade_err_valid;
  assign err_o       = tni_err_valid ? tni_err : shade_err;
  assign ev_o.pri      = pri_valid && pri_ready;
  assign ev_o.shadow   = sec_valid && sec_ready && sec.kind == RAY_SHADOW;
  assign ev_o.reflect  = sec_valid && sec_ready && sec.kind == RAY_REFLECT;
  assign ev_o.transmit = sec_valid && sec_ready && sec.kind == RAY_TRANSMIT;
  assign trace_o = '{
    pri_valid: pri_valid && pri_ready, pri: pri,
    sec_valid: sec_valid && sec_ready, sec_id: sec.id, sec_kind: sec.kind, sec_light: sec.light, sec_depth: sec.depth,
    hit_valid: hit_valid && hit_ready, hit: hit, tni: tni_trace
  };
endmodule
