// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// What the parts of the shading unit share: the beats of time, and the records they pass on.
//
// Component-serial units (docs/shade.md): a job (a ray, a light, an update of a colour) enters in the last beat before its
// time 0 and uses a functional unit in consecutive cycles for x, y and z. In the rigid pipelines
//   T_NAME   is a time in cycles of the job, of the x component if it is a vector's; a localparam, from LAT_*
//   x_name   is value x at time T_NAME
// and the beat, T modulo the beats of the unit, says which operation owns a shared unit in a cycle.
package rc_shade_pkg;
  import rc_pkg::*;

  // Beats of a job. Six would do, since only the T&I unit may bound the speed and it ends at most one ray in six cycles;
  // no more are spent than the busiest functional unit needs.
  parameter int unsigned HIT_BEATS   = 4;  // two 3-input adders serve 3 components and 4 sums
  parameter int unsigned LIGHT_BEATS = 5;  // one 3-input adder serves 5 sums
  parameter int unsigned ACC_BEATS   = 3;  // one adder serves 3 components
  parameter int unsigned THRU_BEATS  = 8;  // one multiplier serves 7 products

  // Times of rc_phong, which rc_light feeds
  parameter int unsigned PHONG_IN  = 0;                                   // names of light and material
  parameter int unsigned PHONG_RV  = PHONG_IN + 1;                        // R . V and m . L
  parameter int unsigned PHONG_SP  = PHONG_RV + LAT_POW;                  // power
  parameter int unsigned PHONG_DS  = PHONG_RV + 1 + ((LAT_POW > LAT_MUL) ? LAT_POW : LAT_MUL);   // texture's colour
  parameter int unsigned PHONG_SUM = PHONG_DS + LAT_MUL + LAT_ADD;
  parameter int unsigned PHONG_ATT = PHONG_SUM + LAT_MUL - 1;             // attenuation
  parameter int unsigned PHONG_K   = PHONG_ATT + 1 + LAT_MUL;             // k

  function automatic int unsigned later(int unsigned a, int unsigned b);
    return (a > b) ? a : b;
  endfunction

  function automatic int unsigned earlier(int unsigned a, int unsigned b);
    return (a < b) ? a : b;
  endfunction

  // The first time from `earliest` on that is in the same beat as time `like`.
  function automatic int unsigned next_beat(int unsigned earliest, int unsigned like, int unsigned beats);
    return earliest + (like % beats + beats - earliest % beats) % beats;
  endfunction

  // ---- small functions on numbers -----------------------------------------------------------------
  function automatic fp_t component(vec3_t v, logic is_x, logic is_y);
    return is_x ? v[0] : is_y ? v[1] : v[2];
  endfunction

  function automatic logic fp_is_positive(fp_t a);              // a > 0, false for NaN
    return !a[FP_W-1] && a[FP_MAN_W+:FP_EXP_W] != '0 && a <= FP_INF;
  endfunction

  function automatic fp_t fp_up16(fp_t a);                      // the 16th number after a > 0; at most infinity
    fp_t y;
    y = a + fp_t'(16);
    return (a >= FP_INF) ? a : (y > FP_INF) ? FP_INF : y;
  endfunction

  function automatic fp_t fp_neg_if(fp_t a, logic negate);
    return a ^ {negate, {(FP_W - 1) {1'b0}}};
  endfunction

  function automatic fp_t fp_twice(fp_t a);                     // exact, or infinity
    logic [FP_EXP_W-1:0] e;
    e = a[FP_MAN_W+:FP_EXP_W];
    if (e == '0 || e == '1) return a;
    if (e == '1 - 1'b1) return {a[FP_W-1], FP_INF[FP_W-2:0]};
    return {a[FP_W-1], e + 1'b1, a[FP_MAN_W-1:0]};
  endfunction

  // alpha' of docs/whitted.md; a: alpha of material and texture, keep: it is at least the cutoff
  function automatic fp_t coverage(alpha_e mode, logic keep, fp_t a);
    return (mode == ALPHA_OPAQUE) ? FP_ONE : (mode != ALPHA_MASK) ? a : keep ? FP_ONE : FP_ZERO;
  endfunction

  // ---- context of a ray index: four words, as the hit-point unit makes them and light and bounce unit take them -------
  typedef logic [$clog2(MAX_MATERIALS)-1:0] mat_id_t;
  typedef struct packed {                  // words 0 to 2: component x, y, z
    fp_t w;                                // weight of the ray that came: red, green, blue
    fp_t tex;                              // texture's colour, or 1
    fp_t d;                                // direction of the ray that came
    fp_t m;                                // shading normal
    fp_t g;                                // normal of the plane, towards the viewer
    fp_t p;                                // hit point
  } ctx_axis_t;
  parameter int unsigned CTX_W = $bits(ctx_axis_t);
  typedef struct packed {                  // word 3
    logic [CTX_W-$bits(surf_t)-$bits(mat_id_t)-$bits(depth_t)-1-3*FP_W-1:0] zero;
    logic    from_inside;                  // the ray came from behind the triangle
    depth_t  depth;                        // of the ray that came
    fp_t     len;                          // length of the path up to here
    fp_t     alpha;                        // alpha' of docs/whitted.md
    surf_t   surf;
    mat_id_t mat;
    fp_t     md;                           // m . d
  } ctx_scalar_t;
  typedef struct packed {ray_id_t id; logic [1:0] word;} ctx_addr_t;

  // ---- jobs -----------------------------------------------------------------------------------------
  typedef struct packed {                  // one light for one hit point
    ray_id_t   id;
    light_id_t light;
    fp_t       t_min;                      // of its shadow ray: T_MIN, or where it starts again
  } job_t;

  typedef struct packed {                  // what comes after the last light
    ray_id_t id;
    logic    pop;                          // nothing more here: a ray from the pixel's stack
    logic    branch;                       // bounce, and the material may have two children
  } bounce_t;

  typedef struct packed {                  // a ray's share in its pixel, and its past; written when the ray is made
    ray_id_t id;
    vec3_t   w;
    fp_t     len;
    depth_t  depth;
  } path_t;

  typedef struct packed {                  // what the texture unit takes
    hit_t hit;
    fp_t  len;                             // length of the path before the ray
  } tex_req_t;
  typedef struct packed {                  // ... and gives
    hit_t  hit;
    vec3_t rgb;
    fp_t   a;
  } tex_t;

  typedef enum logic [1:0] {
    UPD_MISS    = 2'd0,                    // nothing hit: plus the background, the path ends
    UPD_SURFACE = 2'd1,                    // a hit point: plus emission and ambient; first light
    UPD_LIGHT   = 2'd2,                    // a light is done: plus what waits, or not; next light
    UPD_END     = 2'd3                     // a bounce that makes no ray: the path ends
  } upd_e;
  typedef struct packed {                  // what the hit-point unit tells of a hit point beside its context
    ray_id_t id;
    mat_id_t mat;
    logic    bounces;                      // rays may go on from it
    logic    branch;                       // even two
    fp_t     alpha;                        // alpha'
    vec3_t   tex;
  } point_t;
  typedef struct packed {
    upd_e   kind;
    logic   add;                           // of UPD_LIGHT: it is seen
    point_t point;                         // all of it for UPD_SURFACE, else its id
  } upd_t;
endpackage
