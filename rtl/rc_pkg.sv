// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Types and constants shared by two or more units: the only place where a width or a record layout
// is written down. scripts/raycore/image.py packs the records; docs/seams.md explains them.
package rc_pkg;

  // ---- 24-bit floating point, 1-7-16 (paper Sec. 4.1) ------------------------------------------
  parameter int unsigned FP_EXP_W = 7;
  parameter int unsigned FP_MAN_W = 16;
  parameter int unsigned FP_W     = 1 + FP_EXP_W + FP_MAN_W;
  typedef logic [FP_W-1:0] fp_t;
  typedef fp_t [2:0] vec3_t;               // [0] x, [1] y, [2] z

  // Latencies of the functional units in cycles (paper Sec. 3.4). Deeper values give longer
  // pipelines, aligned by construction, with the same results.
  parameter int unsigned LAT_ADD  = 2;
  parameter int unsigned LAT_ADD3 = 2;
  parameter int unsigned LAT_MUL  = 1;
  parameter int unsigned LAT_CMP  = 1;
  parameter int unsigned LAT_DIV  = 2;
  parameter int unsigned LAT_SQRT = 2;
  parameter int unsigned LAT_POW  = 5;
  parameter int unsigned LAT_CONV = 1;     // integer to float and back

  parameter fp_t FP_ZERO   = 24'h000000;
  parameter fp_t FP_ONE    = 24'h3F0000;
  parameter fp_t FP_INF    = 24'h7F0000;
  parameter fp_t FP_HUGE   = 24'h7D0000;   // 2^62: stands for 1/0 and for "no limit"
  parameter fp_t T_MIN     = 24'h310000;   // 2^-14: nearest hit that counts
  parameter fp_t T_SLACK   = 24'h360000;   // 2^-9: nearest hit that counts if it used the edge slack
  parameter fp_t HIT_LIFT  = 24'h2E0000;   // 2^-17: hit points float this far above their triangle

  function automatic fp_t fp_neg(fp_t a);
    return a ^ {1'b1, {(FP_W - 1) {1'b0}}};
  endfunction

  function automatic fp_t fp_inverse(fp_t quot);   // 1/d as rays carry it: 1/0 is +-FP_HUGE, nothing else is infinite
    return (quot[FP_W-2:0] == FP_INF[FP_W-2:0]) ? {quot[FP_W-1], FP_HUGE[FP_W-2:0]} : quot;
  endfunction

  // ---- indices ----------------------------------------------------------------------------------
  parameter int unsigned RAY_ID_W = 8;     // paper Sec. 3.3
  parameter int unsigned IDX_W    = 24;    // nodes, list entries, triangles
  parameter int unsigned MAT_W    = 12;
  typedef logic [RAY_ID_W-1:0] ray_id_t;
  typedef logic [1:0]          pipe_id_t;  // pipeline of a T&I unit (paper: four)
  typedef logic [IDX_W-1:0]    idx_t;
  typedef logic [MAT_W-1:0]    mat_t;
  parameter idx_t TRI_NONE = '1;           // no triangle
  parameter idx_t NODE_NONE = '1;          // no node
  parameter int unsigned INST_W = 9;       // instances: the top-level tree and the objects
  typedef logic [INST_W-1:0]   inst_id_t;
  parameter inst_id_t NOT_PLACED = '0;     // of a triangle in the scene's coordinates
  typedef struct packed {                  // a triangle, and the placed object that it is in
    inst_id_t inst;
    idx_t     tri_idx;
  } surf_t;
  parameter surf_t SURF_NONE = '{inst: NOT_PLACED, tri_idx: TRI_NONE};

  // ---- memory -----------------------------------------------------------------------------------
  parameter int unsigned ADDR_W = 32;      // bytes
  parameter int unsigned LINE_B = 64;      // bytes a block in memory
  parameter int unsigned LINE_ADDR_W = ADDR_W - $clog2(LINE_B);
  parameter int unsigned HALF_ADDR_W = LINE_ADDR_W + 1;    // half a block: what the T&I unit's caches fetch
  parameter int unsigned LINE_W = 480;     // bits a line in SRAM: eight words of 60 used bits
  parameter int unsigned WORD_W = 60;
  typedef logic [ADDR_W-1:0]      addr_t;
  typedef logic [LINE_ADDR_W-1:0] line_addr_t;
  typedef logic [HALF_ADDR_W-1:0] half_addr_t;
  typedef logic [7:0][WORD_W-1:0] line_t;
  typedef logic [3:0][WORD_W-1:0] half_line_t;
  typedef logic [7:0][63:0]       block64_t;   // a block as it lies in memory: texels use all bits

  function automatic line_t used_bits(block64_t b);
    for (int w = 0; w < 8; w++) used_bits[w] = b[w][WORD_W-1:0];
  endfunction

  // ---- records in memory (low bit of word 0 first) ------------------------------------------------
  // Node, 8 bytes. Inner: adjacent child at index + 1. Empty children are flagged, never stored.
  typedef struct packed {
    logic [6:0] zero;                      // [59:53]
    idx_t       other;                     // [52:29] inner: index of the child that is not adjacent
                                           //         leaf: first list entry; count 1: the triangle
    logic       upper_empty;               // [28]
    logic       lower_empty;               // [27]
    logic       swap;                      // [26] the adjacent child is the upper one
    logic [1:0] axis;                      // [25:24] 0 x, 1 y, 2 z, 3 leaf
    fp_t        split;                     // [23:0] leaf: [19:0] triangle count
  } node_t;

  // List entry, 4 bytes in memory, the low 26 bits used; two in a word, at bits 0 and 32.
  typedef struct packed {
    logic opaque;                          // [25]
    logic last;                            // [24] last entry of its leaf
    idx_t tri_idx;                         // [23:0]
  } list_entry_t;

  // TriAccel record, 32 bytes = four words of 60 bits (EXPERIMENTS recipe T, Wald 2004).
  typedef struct packed {
    logic [11:0] b_v_hi;  fp_t g_v;  fp_t g_u;                                     // word 3
    logic [11:0] b_v_lo;  fp_t b_u;  fp_t a_k;                                     // word 2
    mat_t        mat;     fp_t a_v;  fp_t a_u;                                     // word 1
    logic opaque; logic [1:0] k; logic [4:0] eps_e; logic [3:0] eps_m; fp_t n_v; fp_t n_u;  // word 0
  } triaccel_t;                            // k = 3 never hits

  // Instance, 256 bytes: a tree and its box; the way into the object's coordinates and out of them, if it is placed. Record 0
  // is the top-level tree, whose lists name the others.
  //   bytes 0-31 inst_t   32-127 three rows inst_row_t   128-191 place_t
  parameter int unsigned INST_LINES  = 4;
  parameter int unsigned PLACE_LINE  = 2;  // place_t
  parameter int unsigned INST_HALF_W = $clog2(2 * INST_LINES);
  typedef logic [INST_HALF_W-1:0] inst_half_t;
  parameter inst_half_t BOX_HALF = 'd0, ROW_FIRST = 'd1, ROW_LAST = 'd3;   // halves of lines: inst_t, inst_row_t
  typedef struct packed {
    logic [35:0] zero3;                  fp_t hi_z;                                 // word 3
    logic [11:0] zero2;  fp_t hi_y;      fp_t hi_x;                                 // word 2
    logic [11:0] zero1;  fp_t lo_z;      fp_t lo_y;                                 // word 1
    logic [10:0] zero0;  logic placed;   fp_t lo_x;      idx_t root;                // word 0
  } inst_t;
  // A row of the rotation into an object's coordinates, on the units of the intersection mode: r . d, r . (o - c). The numbers lie
  // where a TriAccel record has n_u, n_v, b_u and a.
  typedef struct packed {
    logic [35:0] zero3;                  idx_t root;                                // word 3
    logic [11:0] zero2;  fp_t r_z;       fp_t c_z;                                  // word 2
    logic [11:0] zero1;  fp_t c_y;       fp_t c_x;                                  // word 1
    logic [11:0] zero0;  fp_t r_y;       fp_t r_x;                                  // word 0
  } inst_row_t;
  // The rotation out of them, and where their origin lies.
  typedef struct packed {
    logic [119:0] zero6;                                                            // words 6-7
    logic [11:0] zero5;  fp_t o_z;       fp_t m_zz;                                 // word 5
    logic [11:0] zero4;  fp_t m_zy;      fp_t m_zx;                                 // word 4
    logic [11:0] zero3;  fp_t o_y;       fp_t m_yz;                                 // word 3
    logic [11:0] zero2;  fp_t m_yy;      fp_t m_yx;                                 // word 2
    logic [11:0] zero1;  fp_t o_x;       fp_t m_xz;                                 // word 1
    logic [11:0] zero0;  fp_t m_xy;      fp_t m_xx;                                 // word 0
  } place_t;

  // Triangle information, 64 bytes = eight words of 60 bits.
  typedef struct packed {
    logic [35:0] zero7;              fp_t e2_z;   // word 7   e1 = n1 - n0, e2 = n2 - n0
    logic [11:0] zero6;  fp_t e2_y;  fp_t e2_x;   // word 6
    logic [11:0] zero5;  fp_t e1_z;  fp_t e1_y;   // word 5
    logic [11:0] zero4;  fp_t e1_x;  fp_t n0_z;   // word 4
    logic [11:0] zero3;  fp_t n0_y;  fp_t n0_x;   // word 3   n0: normal at vertex 0
    logic [11:0] zero2;  fp_t n_z;   fp_t n_y;    // word 2   n: unit normal of the plane
    logic [11:0] zero1;  fp_t n_x;   fp_t a_z;    // word 1   a: vertex 0
    mat_t        mat;    fp_t a_y;   fp_t a_x;    // word 0
  } tri_info_t;

  // Light, 64 bytes. Position of a point light, or unit vector towards a directional one.
  typedef struct packed {
    logic [119:0] zero6;                                    // words 6-7
    logic [59:0]  zero5;                                    // word 5
    logic [35:0]  zero4;                 fp_t att_q;        // word 4   1 / (c + l D + q D^2)
    logic [11:0]  zero3;   fp_t att_l;   fp_t att_c;        // word 3
    logic [11:0]  zero2;   fp_t col_b;   fp_t col_g;        // word 2
    logic [11:0]  zero1;   fp_t col_r;   fp_t pos_z;        // word 1
    logic [10:0]  zero0;   logic directional; fp_t pos_y; fp_t pos_x;   // word 0
  } light_t;

  // Phong material, 128 bytes: a block of colours and a block of optics and texture. docs/seams.md says how they are used.
  typedef enum logic [1:0] {
    ALPHA_OPAQUE = 2'd0,                   // alpha is 1
    ALPHA_MASK   = 2'd1,                   // 1 where alpha is at least the cutoff, else 0
    ALPHA_BLEND  = 2'd2                    // the ray goes straight on with the rest
  } alpha_e;
  typedef struct packed {
    logic [4:0] zero;
    logic       tex_kr;                    // the texture tints the reflectance (metals)
    logic       fresnel;                   // the reflectance grows towards grazing angles, by Schlick
    logic       transmits;                 // kt is not 0; only with ALPHA_OPAQUE
    logic       reflects;                  // kr is not 0
    alpha_e     alpha_mode;
    logic       textured;
  } mat_flags_t;
  typedef struct packed {
    logic [35:0]  zero7;                     fp_t cutoff;   // word 7
    logic [11:0]  zero6;   fp_t alpha;       fp_t shin;     // word 6   shininess, 0 to 1024
    logic [11:0]  zero5;   fp_t emis_b;      fp_t emis_g;   // word 5
    logic [11:0]  zero4;   fp_t emis_r;      fp_t spec_b;   // word 4
    logic [11:0]  zero3;   fp_t spec_g;      fp_t spec_r;   // word 3
    logic [11:0]  zero2;   fp_t diff_b;      fp_t diff_g;   // word 2
    logic [11:0]  zero1;   fp_t diff_r;      fp_t amb_b;    // word 1
    mat_flags_t   flags;   fp_t amb_g;       fp_t amb_r;    // word 0
  } material_t;
  typedef struct packed {
    logic [179:0] zero5;                                    // words 5-7
    logic [15:0]  zero4;                                    // word 4: texture
    logic         srgb;                    // colours are sRGB, to be made linear
    logic         rgba5551;                // 16 bits a texel, 8x4 a block; else RGBA8, 4x4 a block
    logic [1:0]   wrap_t;                  // wrap_e, of v
    logic [1:0]   wrap_s;                  // of u
    logic [3:0]   levels;                  // mip levels, 1 to 13
    logic [3:0]   log2_h;                  // of level 0, 0 to 12
    logic [3:0]   log2_w;
    logic [25:0]  tex_base;                // block of level 0, from TEX_BASE
    logic [11:0]  zero3;   fp_t inv_ior;     fp_t ior;      // word 3
    logic [11:0]  zero2;   fp_t kt_b;        fp_t kt_g;     // word 2   transmittance
    logic [11:0]  zero1;   fp_t kt_r;        fp_t kr_b;     // word 1
    logic [11:0]  zero0;   fp_t kr_g;        fp_t kr_r;     // word 0   reflectance (at normal incidence)
  } optics_t;
  typedef enum logic [1:0] {WRAP_REPEAT = 2'd0, WRAP_MIRROR = 2'd1, WRAP_CLAMP = 2'd2} wrap_e;
  typedef enum logic [1:0] {LD_LIGHT = 2'd0, LD_MATERIAL = 2'd1, LD_OPTICS = 2'd2} ld_kind_e;   // what the loader gives

  // Texture coordinates of a triangle, 32 bytes = four words of 60 bits; used where its material is textured.
  parameter int unsigned MIP_FRAC_W = 6;   // mip levels are fixed-point numbers with so many bits of fraction
  typedef logic signed [11:0] mip_t;
  typedef struct packed {
    logic [59:0] zero3;                                     // word 3
    logic [11:0] zero2;  fp_t dv2;   fp_t du2;              // word 2   vertex 2 minus vertex 0
    logic [11:0] zero1;  fp_t dv1;   fp_t du1;              // word 1   vertex 1 minus vertex 0
    mip_t        mip;    fp_t v0;    fp_t u0;               // word 0   log2 sqrt(texel area / area)
  } tri_uv_t;

  parameter int unsigned MAX_LIGHTS    = 16;
  parameter int unsigned MAX_MATERIALS = 256;
  typedef logic [3:0] light_id_t;

  // ---- between units ------------------------------------------------------------------------------
  typedef enum logic [1:0] {RAY_PRIMARY = 2'd0, RAY_SHADOW = 2'd1, RAY_REFLECT = 2'd2, RAY_TRANSMIT = 2'd3} ray_kind_e;
  typedef logic [3:0] depth_t;             // bounces before a ray: 0 primary; at most 15 (paper Sec. 3.3)

  typedef struct packed {
    ray_id_t id;
    logic    any_hit;                      // shadow ray: the first opaque hit found ends it
    surf_t   skip;                         // triangle the ray leaves from; SURF_NONE: none
    fp_t     t_min;                        // nothing nearer counts; T_MIN or more
    fp_t     t_max;                        // FP_HUGE: no limit
    vec3_t   inv_dir;                      // 1/0 is +-FP_HUGE
    vec3_t   dir;                          // unit length
    vec3_t   org;
  } ray_t;

  typedef struct packed {
    ray_id_t id;
    logic    any_hit;                      // as in the ray
    logic    hit;
    logic    opaque;                       // of the triangle's record, 0 without a hit
    mat_t    mat;                          // of the triangle's record, 0 without a hit
    surf_t   surf;                         // SURF_NONE if nothing was hit
    fp_t     t;
    fp_t     beta;                         // barycentric weights of vertices 1 and 2
    fp_t     gamma;
  } hit_t;

  typedef struct packed {                  // dispatcher to setup: an 8x8 block, in blocks
    logic [12:0] x;
    logic [12:0] y;
  } block_t;

  typedef struct packed {                  // setup to ray generation: a primary ray to make
    ray_id_t     id;
    logic [15:0] x;                        // pixel; row 0 is the top
    logic [15:0] y;
  } pri_t;

  typedef struct packed {                  // shading to ray generation: a ray that is not primary
    ray_id_t   id;
    ray_kind_e kind;
    light_id_t light;                      // of a shadow ray
    depth_t    depth;                      // of the surface, for a shadow ray
    surf_t     skip;
    fp_t       t_min;
    fp_t       t_max;
    vec3_t     dir;
    vec3_t     org;
  } sec_t;

  typedef struct packed {                  // ray generation to shading: a ray that is not a shadow ray leaves
    ray_id_t id;
    logic    primary;
    vec3_t   dir;
    vec3_t   org;
  } path_ray_t;

  typedef struct packed {                  // shading to colour buffer: a pixel is finished
    ray_id_t id;
    vec3_t   rgb;                          // [0] red
  } done_t;

  typedef struct packed {                  // registers that make primary rays, see docs/seams.md
    vec3_t org;
    vec3_t c;
    vec3_t u;
    vec3_t v;
  } camera_t;

  // What the host tells the T&I unit about the tree; constant while a frame runs.
  typedef struct packed {
    line_addr_t  node_base;  idx_t node_count;  idx_t root;
    line_addr_t  list_base;  idx_t list_count;
    line_addr_t  accel_base; idx_t tri_count;
    line_addr_t  inst_base;  idx_t inst_count;   // 0: no dynamic objects, the static tree alone
    vec3_t       box_lo;     vec3_t box_hi;
    logic [15:0] max_slots;                // slots a ray may take before the frame ends in error
  } tree_cfg_t;

  // What the host tells the shading unit and the colour buffer; constant while a frame runs.
  typedef struct packed {
    line_addr_t info_base;                 // triangle information, tree_cfg_t.tri_count records
    line_addr_t inst_base;                 // instances, of which placed objects' are read
    line_addr_t uv_base;                   // texture coordinates, as many records
    line_addr_t tex_base;                  // textures
    mip_t       mip_bias;                  // log2 of the angle of a pixel
    logic       trilinear;
    depth_t     max_depth;                 // bounces
    fp_t        min_weight;                // rays that weigh no more are not traced
    logic [8:0] mat_count;                 // 1 to MAX_MATERIALS
    logic [4:0] light_count;               // 0 to MAX_LIGHTS
    logic       shadows;                   // trace shadow rays
    vec3_t      background;                // [0] red
  } shade_cfg_t;

  typedef struct packed {
    line_addr_t  fb_base;                  // row 0, the top row
    logic [18:0] fb_stride;                // from row to row, in 32 bytes
    logic        rgb10;                    // pixel format: RGB10A2, not RGBA8
    logic [15:0] width;                    // pixels, not 0
    logic [15:0] height;
  } frame_cfg_t;

  // ---- errors that end a frame (docs/registers: ERROR.code) -----------------------------------------
  typedef enum logic [4:0] {
    ERR_NONE   = 5'd0,
    ERR_NODE   = 5'd1,                     // node index outside its region
    ERR_LIST   = 5'd2,                     // list index outside its region
    ERR_TRI    = 5'd3,                     // triangle index outside its region
    ERR_STACK  = 5'd4,                     // tree deeper than the stack
    ERR_SLOTS  = 5'd5,                     // a ray took more slots than allowed
    ERR_SLVERR = 5'd6,                     // memory answered SLVERR
    ERR_DECERR = 5'd7,                     // memory answered DECERR
    ERR_WINDOW = 5'd8,                     // address outside every window
    ERR_MAT    = 5'd9,                     // material index outside its region
    ERR_CONFIG = 5'd10,                    // registers that make no sense (zero size, too many lights)
    ERR_TBU_NODE  = 5'd11,                 // tree builder: node region too small
    ERR_TBU_LIST  = 5'd12,                 // tree builder: list region too small
    ERR_TBU_REF   = 5'd13,                 // tree builder: working memory too small
    ERR_TBU_COUNT = 5'd14,                 // tree builder: too many triangles
    ERR_TBU_COORD = 5'd15,                 // tree builder: coordinate off the grid or outside it
    ERR_INST      = 5'd16                  // instance index outside its region
  } err_e;
  typedef struct packed {
    err_e  code;
    addr_t addr;                           // index or byte address that was wrong
  } err_t;

  // ---- counter events of one T&I pipeline, one cycle -------------------------------------------------
  typedef struct packed {
    logic box;                             // slots by mode
    logic trav1;
    logic trav2;
    logic isect;
    logic miss_nt;                         // slot lost: L1 node/TriAccel miss
    logic miss_list;                       // slot lost: L1 list miss
    logic bubble;                          // no ray in the slot
    logic nt_hit;                          // accesses
    logic list_hit;
    logic ray_in;
    logic ray_out;
  } tni_ev_t;

  // Counter events of one ray-tracing unit, one cycle.
  typedef struct packed {
    tni_ev_t [3:0] tni;                    // by pipeline
    logic          l2_hit;                 // accesses
    logic          l2_miss;
    logic          tri_hit;                // triangle cache, accesses
    logic          tri_miss;
    logic          uv_hit;                 // cache of texture coordinates, accesses
    logic          uv_miss;
    logic [2:0]    tex_hit;                // texture cache: blocks looked up in this cycle
    logic [2:0]    tex_miss;
    logic          pri;                    // a primary ray was issued
    logic          shadow;                 // a shadow ray was issued
    logic          reflect;                // a reflected ray was
    logic          transmit;               // a refracted ray, or one that goes straight on, was
    logic          culled;                 // a shadow ray was not worth one
  } rtu_ev_t;

  // ---- what a simulation may watch: one struct a cycle and RTU, no hardware cost ---------------------
  typedef struct packed {                  // the slot that ends in this cycle in a T&I pipeline
    logic        valid;                    // it had a ray
    logic [4:0]  ray;                      // which of the pipeline's
    logic        lost;                     // to a miss
    logic        two;                      // it took two traversal steps
    logic        done;                     // the ray is finished
    logic [15:0] slots;                    // slots it has taken, this one included
    logic        out;                      // a hit left the pipeline; in the order in which rays finish
  } tni_trace_t;
  typedef struct packed {
    logic      pri_valid;                  // a primary ray was issued for pixel (x, y)
    pri_t      pri;
    logic      sec_valid;                  // a ray that is not primary was issued
    ray_id_t   sec_id;
    ray_kind_e sec_kind;
    light_id_t sec_light;
    depth_t    sec_depth;
    logic      hit_valid;                  // a ray finished
    hit_t      hit;
    tni_trace_t [3:0] tni;                 // by pipeline
  } trace_t;

endpackage
