// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The rays under way, by index: origin and direction, weight, length of the path before, depth. A primary ray has weight 1,
// length 0, depth 0 whatever is stored. Three readers, each a cycle after it asks and until it asks again. A ray index is in
// one place at a time, so reads and writes never meet.
module rc_paths import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic      clk_i,
  input  logic      rst_ni,
  input  logic      ray_valid_i,           // a ray leaves ray generation that is not a shadow ray
  input  path_ray_t ray_i,
  input  logic      path_valid_i,          // before, for one that is not primary
  input  path_t     path_i,
  input  logic      len_valid_i,           // the path up to a hit point: where its shadow rays begin
  input  ray_id_t   len_id_i,
  input  fp_t       len_i,
  input  logic      route_re_i,            // reader 1, for textures
  input  ray_id_t   route_id_i,
  output fp_t       route_ray_len_o,       // before the ray
  output fp_t       route_hit_len_o,       // before its shadow rays
  input  logic      point_re_i,            // reader 2, the hit-point unit
  input  ray_id_t   point_id_i,
  output vec3_t     point_org_o,
  output vec3_t     point_dir_o,
  output vec3_t     point_w_o,
  output fp_t       point_len_o,
  output depth_t    point_depth_o,
  input  logic      accum_re_i,            // reader 3, the shading buffer
  input  ray_id_t   accum_id_i,
  output vec3_t     accum_w_o,
  output logic      accum_first_o          // a primary ray
);
  localparam int unsigned NUM_IDS = 2 ** RAY_ID_W;
  typedef struct packed {depth_t depth; fp_t len; vec3_t w;} past_t;
  logic [NUM_IDS-1:0] pri_q;
  logic               route_pri_q, point_pri_q;
  fp_t                route_len;
  past_t              point_past;
  vec3_t              accum_w;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      pri_q <= '0;
    end else begin
      if (path_valid_i) pri_q[path_i.id] <= 1'b0;
      if (ray_valid_i && ray_i.primary) pri_q[ray_i.id] <= 1'b1;
    end
    if (route_re_i) route_pri_q   <= pri_q[route_id_i];
    if (point_re_i) point_pri_q   <= pri_q[point_id_i];
    if (accum_re_i) accum_first_o <= pri_q[accum_id_i];
  end

  rc_ram_1r1w #(.Width(FP_W), .Depth(NUM_IDS)) u_ray_len (
    .clk_i, .we_i(path_valid_i), .waddr_i(path_i.id), .wdata_i(path_i.len),
    .re_i(route_re_i), .raddr_i(route_id_i), .rdata_o(route_len)
  );
  rc_ram_1r1w #(.Width(FP_W), .Depth(NUM_IDS)) u_hit_len (
    .clk_i, .we_i(len_valid_i), .waddr_i(len_id_i), .wdata_i(len_i),
    .re_i(route_re_i), .raddr_i(route_id_i), .rdata_o(route_hit_len_o)
  );
  assign route_ray_len_o = route_pri_q ? FP_ZERO : route_len;

  rc_ram_1r1w #(.Width(2 * $bits(vec3_t)), .Depth(NUM_IDS)) u_rays (
    .clk_i, .we_i(ray_valid_i), .waddr_i(ray_i.id), .wdata_i({ray_i.dir, ray_i.org}),
    .re_i(point_re_i), .raddr_i(point_id_i), .rdata_o({point_dir_o, point_org_o})
  );
  rc_ram_1r1w #(.Width($bits(past_t)), .Depth(NUM_IDS)) u_pasts (
    .clk_i, .we_i(path_valid_i), .waddr_i(path_i.id), .wdata_i({path_i.depth, path_i.len, path_i.w}),
    .re_i(point_re_i), .raddr_i(point_id_i), .rdata_o(point_past)
  );
  assign point_w_o     = point_pri_q ? {3{FP_ONE}} : point_past.w;
  assign point_len_o   = point_pri_q ? FP_ZERO : point_past.len;
  assign point_depth_o = point_pri_q ? '0 : point_past.depth;

  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(NUM_IDS)) u_weights (
    .clk_i, .we_i(path_valid_i), .waddr_i(path_i.id), .wdata_i(path_i.w),
    .re_i(accum_re_i), .raddr_i(accum_id_i), .rdata_o(accum_w)
  );
  assign accum_w_o = accum_first_o ? {3{FP_ONE}} : accum_w;
endmodule
