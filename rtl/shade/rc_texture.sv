// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Texture unit (paper Sec. 3.6): hits on textured triangles, in order, to colour and alpha. Mip level by path length, bilinear
// or trilinear filter. A hit in six cycles, twelve between two levels; misses of both caches overlap. Formulas in
// docs/whitted.md, parts and sizes in docs/texture.md.
//
//   in ─▶ cache of coordinates ─▶ rc_tex_uv ─▶ rc_tex_addr ─▶ rc_tex_cache ─▶ rc_tex_filter ─┬─▶ out
//    └───────────────────────────────── queue of hits ───────────────────────────────────────┘
// The hit itself stays in one queue meanwhile. Every part waits for the next one and for memory only.
module rc_texture import rc_pkg::*; import rc_shade_pkg::*; import rc_tex_pkg::*; #(
  parameter int unsigned UvSets   = 32,    // sets of two lines of two records: 3.75 KB
  parameter int unsigned UvDepth  = 32,    // hits that wait for their record
  parameter int unsigned UvMiss   = 8,     // lines asked for
  parameter int unsigned TexSets  = 32,    // sets of two blocks in each of four banks: 16 KB
  parameter int unsigned TexDepth = 32,    // footprints that wait for their blocks
  parameter int unsigned TexMiss  = 16,    // blocks asked for
  parameter int unsigned HitDepth = 96     // hits inside
) (
  input  logic       clk_i,
  input  logic       rst_ni,               // empties the caches
  input  line_addr_t uv_base_i,            // constant in a frame, as the next three
  input  line_addr_t tex_base_i,
  input  mip_t       mip_bias_i,
  input  logic       trilinear_i,
  input  logic       ld_valid_i,           // loader, between frames
  input  ld_kind_e   ld_kind_i,
  input  logic [7:0] ld_idx_i,
  input  line_t      ld_line_i,
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  tex_req_t   in_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output tex_t       out_o,
  output logic       uv_req_valid_o,       // memory: coordinates
  input  logic       uv_req_ready_i,
  output line_addr_t uv_req_addr_o,
  input  logic       uv_rsp_valid_i,
  input  line_t      uv_rsp_line_i,
  output logic       tex_req_valid_o,      // memory: blocks of textures
  input  logic       tex_req_ready_i,
  output line_addr_t tex_req_addr_o,
  input  logic       tex_rsp_valid_i,
  input  block64_t   tex_rsp_block_i,
  output logic       ev_uv_hit_o,          // accesses
  output logic       ev_uv_miss_o,
  output logic [2:0] ev_tex_hit_o,         // blocks looked up in this cycle
  output logic [2:0] ev_tex_miss_o
);
  // ---- the hit waits here ----------------------------------------------------------------------------------------------
  logic hits_ready, hits_valid, uv_ready, fire, rgba_valid;
  logic [$clog2(HitDepth+1)-1:0] unused_hits;
  assign in_ready_o = hits_ready && uv_ready;
  assign fire       = in_valid_i && in_ready_o;
  rc_fifo #(.data_t(hit_t), .Depth(HitDepth)) u_hits (
    .clk_i, .rst_ni,
    .in_valid_i(fire), .in_ready_o(hits_ready), .in_data_i(in_i.hit),
    .out_valid_o(hits_valid), .out_ready_i(rgba_valid && out_ready_i), .out_data_o(out_o.hit), .count_o(unused_hits)
  );

  // ---- coordinates: a line holds two records -----------------------------------------------------------------------------
  typedef struct packed {logic odd; tex_hit_t hit;} uv_data_t;
  uv_data_t uv_in, uv_out;
  line_t    uv_line;
  logic     uv_valid, uv_take;
  assign uv_in = '{odd: in_i.hit.surf.tri_idx[0],
                   hit: '{mat: in_i.hit.mat[7:0], len: in_i.len, t: in_i.hit.t, beta: in_i.hit.beta,
                          gamma: in_i.hit.gamma}};
  rc_ro_cache #(.data_t(uv_data_t), .Sets(UvSets), .Ways(2), .Depth(UvDepth), .MaxMiss(UvMiss)) u_uv_cache (
    .clk_i, .rst_ni,
    .in_valid_i(in_valid_i && hits_ready), .in_ready_o(uv_ready),
    .in_addr_i(uv_base_i + line_addr_t'(in_i.hit.surf.tri_idx[IDX_W-1:1])), .in_data_i(uv_in),
    .out_valid_o(uv_valid), .out_ready_i(uv_take), .out_line_o(uv_line), .out_data_o(uv_out),
    .req_valid_o(uv_req_valid_o), .req_ready_i(uv_req_ready_i), .req_addr_o(uv_req_addr_o),
    .rsp_valid_i(uv_rsp_valid_i), .rsp_line_i(uv_rsp_line_i),
    .ev_hit_o(ev_uv_hit_o), .ev_miss_o(ev_uv_miss_o)
  );
  tex_coord_t coord;
  logic       coord_valid, coord_ready;
  rc_tex_uv u_uv (
    .clk_i, .rst_ni,
    .in_valid_i(uv_valid), .in_ready_o(uv_take), .in_hit_i(uv_out.hit),
    .in_uv_i(tri_uv_t'(uv_out.odd ? uv_line[7:4] : uv_line[3:0])),
    .out_valid_o(coord_valid), .out_ready_i(coord_ready), .out_o(coord)
  );

  // ---- descriptors by material -----------------------------------------------------------------------------------------
  optics_t    ld_optics;
  tex_desc_t  ld_desc, desc;
  logic       ld_we, desc_re;
  logic [7:0] desc_idx;
  assign ld_optics = optics_t'(ld_line_i);
  assign ld_we     = ld_valid_i && ld_kind_i == LD_OPTICS;
  assign ld_desc   = '{srgb: ld_optics.srgb, rgba5551: ld_optics.rgba5551, wrap_t: ld_optics.wrap_t,
                       wrap_s: ld_optics.wrap_s, levels: ld_optics.levels, log2_h: ld_optics.log2_h,
                       log2_w: ld_optics.log2_w, tex_base: ld_optics.tex_base};
  rc_ram_1r1w #(.Width($bits(tex_desc_t)), .Depth(MAX_MATERIALS)) u_desc (
    .clk_i,
    .we_i(ld_we), .waddr_i(ld_idx_i), .wdata_i(ld_desc),
    .re_i(desc_re && !ld_we), .raddr_i(desc_idx), .rdata_o(desc)
  );

  // ---- texels --------------------------------------------------------------------------------------------------------------
  tex_blocks_t      blocks;
  tex_sample_t      asked, found;
  logic             asked_valid, asked_ready, found_valid, found_ready;
  logic [3:0][31:0] words;
  fp_t [3:0]        rgba;
  rc_tex_addr u_addr (
    .clk_i, .rst_ni, .tex_base_i, .mip_bias_i, .trilinear_i,
    .in_valid_i(coord_valid), .in_ready_o(coord_ready), .in_i(coord),
    .desc_re_o(desc_re), .desc_idx_o(desc_idx), .desc_i(desc),
    .out_valid_o(asked_valid), .out_ready_i(asked_ready), .out_blocks_o(blocks), .out_sample_o(asked)
  );
  rc_tex_cache #(.Sets(TexSets), .Depth(TexDepth), .MaxMiss(TexMiss)) u_cache (
    .clk_i, .rst_ni,
    .in_valid_i(asked_valid), .in_ready_o(asked_ready), .in_blocks_i(blocks), .in_sample_i(asked),
    .out_valid_o(found_valid), .out_ready_i(found_ready), .out_words_o(words), .out_sample_o(found),
    .req_valid_o(tex_req_valid_o), .req_ready_i(tex_req_ready_i), .req_addr_o(tex_req_addr_o),
    .rsp_valid_i(tex_rsp_valid_i), .rsp_block_i(tex_rsp_block_i),
    .ev_hit_o(ev_tex_hit_o), .ev_miss_o(ev_tex_miss_o)
  );
  rc_tex_filter u_filter (
    .clk_i, .rst_ni,
    .in_valid_i(found_valid), .in_ready_o(found_ready), .in_words_i(words), .in_sample_i(found),
    .out_valid_o(rgba_valid), .out_ready_i(hits_valid && out_ready_i), .out_o(rgba)
  );
  assign out_valid_o = rgba_valid && hits_valid;
  assign out_o.rgb   = rgba[2:0];
  assign out_o.a     = rgba[3];

  logic unused_ld;
  assign unused_ld = ^{ld_optics.zero5, ld_optics.zero4, ld_optics.zero3, ld_optics.inv_ior, ld_optics.ior,
                       ld_optics.zero2, ld_optics.kt_b, ld_optics.kt_g, ld_optics.zero1, ld_optics.kt_r,
                       ld_optics.kr_b, ld_optics.zero0, ld_optics.kr_g, ld_optics.kr_r};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && ld_we) NoLoad_M: assume (!desc_re);
    if (rst_ni && rgba_valid) HitWaits_A: assert (hits_valid);
    if (rst_ni && in_valid_i) IsHit_M: assume (in_i.hit.hit);
  end
`endif
endmodule
