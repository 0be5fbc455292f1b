// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Types between the registers (rc_csr) and the frame control (rc_core).
package rc_top_pkg;
  import rc_pkg::*;
  import rc_tbu_pkg::box_t, rc_tbu_pkg::count_t, rc_tbu_pkg::tri_first_t;
  import rc_accel_pkg::eye_t, rc_accel_pkg::slack_t;

  // What the host set up. Counts are as wide as their registers: rc_setup_check looks at them
  // before anything else does.
  typedef struct packed {
    tree_cfg_t   tree;
    camera_t     camera;
    frame_cfg_t  frame;
    logic [11:0] tile_x;                     // first tile of 16x16 pixels, and how many
    logic [11:0] tile_y;
    logic [23:0] tile_count;
    vec3_t       background;
    logic        shadows;
    logic        trilinear;
    depth_t      max_depth;
    fp_t         min_weight;
    mip_t        mip_bias;
    line_addr_t  info_base;
    line_addr_t  uv_base;
    idx_t        uv_count;
    line_addr_t  tex_base;
    line_addr_t  tex_lines;
    line_addr_t  mat_base;
    logic [15:0] mat_count;
    line_addr_t  light_base;
    logic [15:0] light_count;
    line_addr_t  vertex_base;                // what follows is for the tree builder
    line_addr_t  ref_base;
    idx_t        ref_count;
    count_t      refine_max;
    box_t        tri_box;
    idx_t        node_first;                 // of what it may write
    idx_t        list_first;
    tri_first_t  tri_first;
    line_addr_t  attr_base;                  // what follows is for the record unit
    slack_t      slack;
    eye_t [2:0]  eye;
  } setup_t;

  typedef struct packed {
    logic busy;
    logic done;
    logic error;
    err_t err;
  } status_t;

  // Regions that a frame reads: nodes, lists, TriAccel, triangle information, materials, lights, texture coordinates,
  // textures, instances. Regions that builders write: nodes, lists, working memory, TriAccel, triangle information.
  parameter int unsigned NUM_WINDOWS    = 9;
  parameter int unsigned NUM_WR_WINDOWS = 5;

  // Clients of the read port: the loader, the builders, then the ray-tracing units.
  parameter int unsigned RD_LOADER = 0;
  parameter int unsigned RD_TBU    = 1;
  parameter int unsigned RD_ACCEL  = 2;
  parameter int unsigned RD_RTU    = 3;
  // Whom an RTU's request is for: its tag.
  parameter int unsigned NUM_RD_TAGS = 4;
  typedef logic [$clog2(NUM_RD_TAGS)-1:0] rd_tag_t;
  parameter rd_tag_t RD_TNI = 2'd0;        // L2 cache
  parameter rd_tag_t RD_TRI = 2'd1;        // triangle cache
  parameter rd_tag_t RD_UV  = 2'd2;        // cache of texture coordinates
  parameter rd_tag_t RD_TEX = 2'd3;        // texture cache

  // Counters, in the order of their registers.
  typedef enum logic [4:0] {
    CNT_CYCLES, CNT_RAYS_PRIMARY, CNT_RAYS_SHADOW, CNT_RAYS_CULLED,
    CNT_SLOTS_BOX, CNT_SLOTS_TRAV1, CNT_SLOTS_TRAV2, CNT_SLOTS_ISECT,
    CNT_SLOTS_MISS_NT, CNT_SLOTS_MISS_LIST, CNT_SLOTS_BUBBLE,
    CNT_NT_HITS, CNT_LIST_HITS, CNT_L2_HITS, CNT_L2_MISSES, CNT_TRI_HITS, CNT_TRI_MISSES,
    CNT_LINES_TNI, CNT_LINES_TRI, CNT_LINES_LOADER, CNT_FB_ROWS, CNT_RD_STALL, CNT_RAYS_IN_FLIGHT,
    CNT_RAYS_REFLECT, CNT_RAYS_TRANSMIT, CNT_UV_HITS, CNT_UV_MISSES, CNT_TEX_HITS, CNT_TEX_MISSES,
    CNT_LINES_UV, CNT_LINES_TEX
  } counter_e;
  parameter int unsigned NUM_COUNTERS = 31;
  typedef logic [NUM_COUNTERS-1:0][31:0] counters_t;
endpackage
