// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Where the end of a ray goes in the shading unit (docs/whitted.md):
//   nothing hit, or a shadow ray that arrived or ended at an opaque triangle    update of the colour
//   a surface                                                                   triangle information
//   a triangle that is not opaque, in the way of a shadow ray                   transparent shadows
// the last two by way of the texture unit if the material is textured. In two cycles: one reads the material's flag and the
// length of the path, one passes on. A material that does not exist is reported here, before any texture is looked up for it.
// Nothing on these ways waits for a ray to leave the shading unit.
module rc_shade_route import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic [8:0] mat_count_i,
  input  logic       ld_mat_valid_i,       // before a frame
  input  mat_id_t    ld_idx_i,
  input  line_t      ld_line_i,
  input  logic       hit_valid_i,
  output logic       hit_ready_o,
  input  hit_t       hit_i,
  output logic       taken_o,              // a hit was taken: a cycle later come, of its index,
  output ray_id_t    taken_id_o,
  input  fp_t        ray_len_i,            //   the length of the path before the ray that hit a surface,
  input  fp_t        hit_len_i,            //   and before a shadow ray
  output logic       upd_valid_o,
  input  logic       upd_ready_i,
  output upd_t       upd_o,
  output logic       req_valid_o,          // to the texture unit
  input  logic       req_ready_i,
  output tex_req_t   req_o,
  input  logic       tex_valid_i,          // and back
  output logic       tex_ready_o,
  input  tex_t       tex_i,
  output logic       surface_valid_o,      // taken when ready is up; another may be offered until then
  input  logic       surface_ready_i,
  output tex_t       surface_o,
  output logic       blocker_valid_o,      // likewise
  input  logic       blocker_ready_i,
  output tex_t       blocker_o,
  output logic       err_valid_o,          // one cycle
  output err_t       err_o
);
  typedef enum logic [1:0] {TO_UPDATE, TO_SURFACE, TO_BLOCKER} to_e;
  function automatic to_e goes_to(logic hit, logic any_hit, logic opaque);
    if (!hit) return TO_UPDATE;
    if (!any_hit) return TO_SURFACE;
    return opaque ? TO_UPDATE : TO_BLOCKER;
  endfunction

  // ---- the hit, its material's flag, its length ------------------------------------------------------------------------
  logic      valid_q, unknown, unknown_q, leaves, textured, textured_mat;
  hit_t      hit_q;
  to_e       to, tex_to;
  material_t ld_mat;
  assign ld_mat      = ld_line_i;
  assign hit_ready_o = !valid_q;
  assign taken_o     = hit_valid_i && hit_ready_o;
  assign taken_id_o  = hit_i.id;
  assign unknown     = hit_i.mat >= mat_t'(mat_count_i);
  rc_ram_1r1w #(.Width(1), .Depth(MAX_MATERIALS)) u_textured (
    .clk_i, .we_i(ld_mat_valid_i), .waddr_i(ld_idx_i), .wdata_i(ld_mat.flags.textured),
    .re_i(taken_o), .raddr_i(mat_id_t'(hit_i.mat)), .rdata_o(textured_mat)
  );
  always_ff @(posedge clk_i) begin
    if (!rst_ni) valid_q <= 1'b0;
    else         valid_q <= taken_o || (valid_q && !leaves);
    if (taken_o) begin
      hit_q     <= hit_i;
      unknown_q <= unknown;
    end
    err_valid_o <= rst_ni && taken_o && hit_i.hit && unknown;
    err_o       <= '{code: ERR_MAT, addr: addr_t'(hit_i.mat)};
  end

  // ---- where it goes -----------------------------------------------------------------------------------------------------
  logic [1:0] surface_req, surface_gnt, blocker_req, blocker_gnt;      // [0] straight on, [1] with a texture
  tex_t       plain;
  logic [0:0] unused_surface, unused_blocker;
  assign to          = goes_to(hit_q.hit, hit_q.any_hit, hit_q.opaque);
  assign tex_to      = goes_to(tex_i.hit.hit, tex_i.hit.any_hit, tex_i.hit.opaque);
  assign textured    = textured_mat && !unknown_q;
  assign plain       = '{hit: hit_q, rgb: {3{FP_ONE}}, a: FP_ONE};
  assign upd_valid_o = valid_q && to == TO_UPDATE;
  assign upd_o.kind  = hit_q.any_hit ? UPD_LIGHT : UPD_MISS;
  assign upd_o.add   = !hit_q.hit;
  assign upd_o.point = '{id: hit_q.id, mat: '0, bounces: 1'b0, branch: 1'b0, alpha: '0, tex: '0};
  assign req_valid_o = valid_q && to != TO_UPDATE && textured;
  assign req_o       = '{hit: hit_q, len: hit_q.any_hit ? hit_len_i : ray_len_i};
  assign surface_req = {tex_valid_i && tex_to == TO_SURFACE, valid_q && to == TO_SURFACE && !textured};
  assign blocker_req = {tex_valid_i && tex_to == TO_BLOCKER, valid_q && to == TO_BLOCKER && !textured};
  rc_rr_arb #(.NumReq(2)) u_surface (
    .clk_i, .rst_ni, .req_i(surface_req), .ready_i(surface_ready_i), .gnt_o(surface_gnt), .idx_o(unused_surface)
  );
  rc_rr_arb #(.NumReq(2)) u_blocker (
    .clk_i, .rst_ni, .req_i(blocker_req), .ready_i(blocker_ready_i), .gnt_o(blocker_gnt), .idx_o(unused_blocker)
  );
  assign surface_valid_o = surface_req != '0;
  assign blocker_valid_o = blocker_req != '0;
  assign surface_o       = surface_gnt[1] ? tex_i : plain;
  assign blocker_o       = blocker_gnt[1] ? tex_i : plain;
  assign tex_ready_o     = (surface_gnt[1] && surface_ready_i) || (blocker_gnt[1] && blocker_ready_i);
  assign leaves          = (upd_valid_o && upd_ready_i) || (req_valid_o && req_ready_i)
                           || (surface_gnt[0] && surface_ready_i) || (blocker_gnt[0] && blocker_ready_i);

  logic unused_ld;
  assign unused_ld = ^ld_mat;
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && tex_valid_i) TexOfHit_M: assume (tex_to != TO_UPDATE);
    if (rst_ni && valid_q)     OneWay_A:   assert ($onehot({upd_valid_o, req_valid_o, surface_req[0], blocker_req[0]}));
  end
`endif
endmodule
