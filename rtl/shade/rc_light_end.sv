// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The end of the light unit (rc_light, whose times these are): a shadow ray, or at once an update of the colour. k is kept
// elsewhere in either case, although the shadow ray may yet be blocked: the ray index is all that the ray brings back.
//   TCtx    hit point, x first       TCtxS   scalars of the context, t_min      TD    distance       TDir   direction, x first
//   TGl     g . L                    TMl     m . L                              TAtt  kind of light
//   TEnd    culled or not (paper Sec. 3.3): into the queue of shadow rays, or out as an update
module rc_light_end import rc_pkg::*; import rc_shade_pkg::*; #(
  parameter int unsigned TCtx  = 1,
  parameter int unsigned TCtxS = 4,
  parameter int unsigned TD    = 10,
  parameter int unsigned TDir  = 14,
  parameter int unsigned TGl   = 19,
  parameter int unsigned TMl   = 20,
  parameter int unsigned TAtt  = 23,
  parameter int unsigned TEnd  = 39,
  parameter int unsigned Room  = 16                // shadow rays that wait; the caller sees to it that they fit
) (
  input  logic                   clk_i,
  input  logic                   rst_ni,
  input  logic                   shadows_i,
  input  logic [LIGHT_BEATS-1:0] beat_i,           // [k]: times k, k + LIGHT_BEATS, ...
  input  logic                   end_i,            // it is time TEnd of a job
  input  ray_id_t                id_i,             // at time TEnd
  input  light_id_t              light_i,
  input  fp_t                    t_min_i,
  input  fp_t                    point_i,
  input  ctx_scalar_t            scalar_i,
  input  fp_t                    sum_i,
  input  fp_t                    len_i,
  input  fp_t                    dir_i,
  input  logic                   directional_i,
  output job_t                   k_job_o,
  output logic                   upd_valid_o,
  output logic                   upd_add_o,
  output logic                   sec_valid_o,
  input  logic                   sec_ready_i,
  output sec_t                   sec_o,
  output logic                   ev_culled_o
);
  localparam int unsigned B = LIGHT_BEATS;
  typedef struct packed {depth_t depth; surf_t skip; fp_t t_min; vec3_t org;} origin_t;
  vec3_t   org, dir;
  origin_t origin, origin_end;
  sec_t    sec;
  rc_gather #(.From(TCtx), .To(TCtxS)) u_org (.clk_i, .in_i(point_i), .vec_o(org));
  assign origin = '{depth: scalar_i.depth, skip: scalar_i.surf, t_min: t_min_i, org: org};
  rc_keep #(.Width($bits(origin_t)), .Beats(B), .From(TCtxS), .To(TEnd)) u_origin (
    .clk_i, .rst_ni, .now_i(beat_i[TCtxS % B]), .next_i(beat_i[(TEnd - 1) % B]), .in_i(origin), .out_o(origin_end)
  );
  rc_gather #(.From(TDir), .To(TDir + 2)) u_dir (.clk_i, .in_i(dir_i), .vec_o(dir));
  rc_keep #(.Width($bits(vec3_t)), .Beats(B), .From(TDir + 2), .To(TEnd)) u_sec_dir (
    .clk_i, .rst_ni, .now_i(beat_i[(TDir + 2) % B]), .next_i(beat_i[(TEnd - 1) % B]), .in_i(dir), .out_o(sec.dir)
  );

  logic faces_g, faces_m, visible, directional, sec_ready, leaves;
  fp_t  len_end;
  logic [$clog2(Room + 1)-1:0] unused_count;
  rc_hold #(.Width(1), .Beats(B), .From(TGl), .To(TEnd)) u_faces_g (
    .clk_i, .now_i(beat_i[TGl % B]), .in_i(fp_is_positive(sum_i)), .out_o(faces_g)
  );
  rc_hold #(.Width(1), .Beats(B), .From(TMl), .To(TEnd)) u_faces_m (
    .clk_i, .now_i(beat_i[TMl % B]), .in_i(fp_is_positive(sum_i)), .out_o(faces_m)
  );
  rc_hold #(.Beats(B), .From(TD), .To(TEnd)) u_len_end (
    .clk_i, .now_i(beat_i[TD % B]), .in_i(len_i), .out_o(len_end)
  );
  rc_hold #(.Width(1), .Beats(B), .From(TAtt), .To(TEnd)) u_directional (
    .clk_i, .now_i(beat_i[TAtt % B]), .in_i(directional_i), .out_o(directional)
  );
  assign visible     = faces_g && faces_m;
  assign leaves      = end_i && visible && shadows_i;
  assign k_job_o     = '{id: id_i, light: light_i, t_min: origin_end.t_min};
  assign upd_valid_o = end_i && !leaves;
  assign upd_add_o   = visible;
  assign ev_culled_o = end_i && !visible;
  assign sec.id      = id_i;
  assign sec.kind    = RAY_SHADOW;
  assign sec.light   = light_i;
  assign sec.depth   = origin_end.depth;
  assign sec.skip    = origin_end.skip;
  assign sec.t_min   = origin_end.t_min;
  assign sec.t_max   = directional ? FP_HUGE : len_end;
  assign sec.org     = origin_end.org;
  rc_fifo #(.data_t(sec_t), .Depth(Room)) u_sec (
    .clk_i, .rst_ni,
    .in_valid_i(leaves), .in_ready_o(sec_ready), .in_data_i(sec),
    .out_valid_o(sec_valid_o), .out_ready_i(sec_ready_i), .out_data_o(sec_o), .count_o(unused_count)
  );
  logic unused;
  assign unused = ^scalar_i;
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) SecRoom_A: assert (!leaves || sec_ready);
  end
`else
  logic unused_ready;
  assign unused_ready = sec_ready;
`endif
endmodule
