// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Types of the tree-building unit (paper Sec. 3.7). docs/tbu.md says how they are used.
package rc_tbu_pkg;
  import rc_pkg::*;

  parameter int unsigned COORD_W     = 18;   // q stands for (q - 2^17) * 2^-17; 0 never occurs
  parameter int unsigned TRI_W       = 19;   // triangles of an object: 512 K
  parameter int unsigned COUNT_W     = 20;   // references of a node
  parameter int unsigned NUM_SORTERS = 4;
  parameter int unsigned MAX_DEPTH   = 32;   // inner nodes on a path (paper Sec. 3.4)
  parameter int unsigned MAX_LEAF    = 4;    // no split at so many references or fewer (paper Sec. 3.7)
  parameter int unsigned NODE_EXTENT = 128;  // nodes, 1 KB
  parameter int unsigned LIST_EXTENT = 256;  // list entries, 1 KB
  parameter fp_t         JUMP_SPLIT  = 24'hFEFFFF;   // plane of a jump node: most negative, every ray is above it
  typedef logic [COORD_W-1:0]     coord_t;
  typedef coord_t [2:0]           point_t;   // [0] x
  typedef logic [COUNT_W-1:0]     count_t;
  typedef logic [TRI_W-1:0]       tri_first_t;   // number of the first triangle of an object
  typedef logic [5:0]             level_t;   // inner nodes above a node

  // Reference to a triangle, 16 bytes in memory. The box is never clipped.
  typedef struct packed {
    logic             opaque;                // [127]
    logic [TRI_W-1:0] tri_idx;               // [126:108]
    point_t           hi;                    // [107:54]
    point_t           lo;                    // [53:0]
  } tri_ref_t;

  typedef struct packed {point_t hi; point_t lo;} box_t;

  // Where the address of a subtree's root goes: a side of an entry of the upper-node table, or the tree's root.
  typedef struct packed {
    logic       root;                        // the whole tree
    logic       upper;                       // upper child of the entry, else the lower one
    logic [6:0] entry;                       // 0 to 63 the binner's, 64 to 79 donated nodes
  } dest_t;

  // A subtree for a sorting pipeline; its references follow, ascending in triangle index.
  typedef struct packed {
    dest_t      dest;
    logic [5:0] gap;                         // node slots to leave free just below the subtree's root
    level_t     level;
    count_t     count;                       // 1 or more
    box_t       box;
  } sort_job_t;

  typedef struct packed {                    // a finished subtree
    dest_t dest;
    idx_t  idx;                              // of its root node
  } subtree_t;

  // An inner node whose other child was donated: written by rc_tbu_upper when that child's subtree_t (dest.entry) came
  // too, before or after this. Its place is known here, and with it its adjacent child, idx + 1; no child is empty.
  typedef struct packed {
    logic [6:0] entry;                       // 64 to 79
    logic [1:0] axis;
    coord_t     pos;
    logic       swap;
    idx_t       idx;                         // its own place, left free
  } donated_t;

  // 32 bytes to write: nodes 4*row to 4*row+3, list entries 8*row to 8*row+7, or references 2*row and 2*row+1.
  typedef enum logic [1:0] {WR_NODE = 2'd0, WR_LIST = 2'd1, WR_REF = 2'd2} wr_kind_e;
  typedef struct packed {
    wr_kind_e         kind;
    logic [23:0]      row;
    logic [7:0]       strb;                  // a bit for 4 bytes
    logic [7:0][31:0] data;
  } tbu_wr_t;

  // How a build ended. An error stops it: nothing is written outside a region, and there is no tree.
  typedef enum logic [2:0] {
    TBU_OK    = 3'd0,
    TBU_NODE  = 3'd1,                        // node region too small
    TBU_LIST  = 3'd2,                        // list region too small
    TBU_REF   = 3'd3,                        // working memory too small
    TBU_COUNT = 3'd4,                        // more than 2^TRI_W triangles
    TBU_COORD = 3'd5,                        // coordinate outside (0, 2^18) or between two
    TBU_BUS   = 3'd6                         // memory answered with an error
  } tbu_err_e;

  typedef struct packed {                    // figures of the last build
    logic [31:0] cycles;
    logic [31:0] nodes;                      // written, jump nodes included
    logic [31:0] entries;                    // of lists, written
    logic [31:0] jumps;
    logic [31:0] jobs;                       // from the binning pipeline
    logic [31:0] donations;
    logic [31:0] forced;                     // leaves, because a sorting pipeline's lists were full
    logic [31:0] lines;                      // of 64 bytes, read
    logic [31:0] rows;                       // of 32 bytes, written
    logic [31:0] waits;                      // cycles that the binning pipeline waited for a place in ring or table
  } tbu_stat_t;

  // What the host says; constant while a tree is built.
  typedef struct packed {
    idx_t       node_first;                  // what lies below belongs to other trees; whole extents
    idx_t       list_first;
    tri_first_t tri_first;                   // number of the triangle at vertex_base
    line_addr_t vertex_base;                 // 32 bytes a triangle: nine FP24 numbers, then flags
    count_t     tri_count;
    line_addr_t node_base;   idx_t node_count;   // whole extents
    line_addr_t list_base;   idx_t list_count;
    line_addr_t ref_base;    idx_t ref_count;    // working memory, references
    count_t     refine_max;                  // nodes up to so many references get fine bins
    box_t       box;                         // of all triangles
  } tbu_cfg_t;
endpackage
