// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Types of the binning pipeline. A pass works on a family: a node P, its two children and their four children, numbered as
// in a heap. The members that a pass tells apart, four at most, have a slot each: its list is a stream, its bins a bank.
package rc_tbp_bin_pkg;
  import rc_pkg::*;
  import rc_tbu_pkg::*;

  parameter int unsigned NUM_SLOTS  = 4;
  parameter int unsigned BINS       = 32;    // a node and axis; twice as many, in two banks, when refining
  parameter int unsigned FINE_SHIFT = 5;     // two bins in 64 parts
  parameter int unsigned NUM_JOBS   = 16;    // lists that wait for a sorting pipeline
  typedef logic [1:0] slot_t;
  typedef logic [2:0] member_t;              // 0 P, 1 its lower child, 2 upper, 3 to 6 theirs
  typedef logic [3:0] shift_t;
  typedef logic [5:0] bin_t;
  typedef logic [62:0] cost_t;               // up to 24 (nL + nR) Hn
  typedef struct packed {                    // what an evaluation found
    logic        pays;
    logic [1:0]  axis;
    coord_t      pos;
    count_t      n_lower;
    count_t      n_upper;
    bin_t [2:0]  bin;                        // of each axis's best plane, if its extent is two units or more
  } plane_t;

  typedef struct packed {                    // a node that the binning pipeline works on
    dest_t       dest;
    logic [5:0]  gap;
    level_t      level;
    count_t      count;
    box_t        box;
    plane_t      plane;
    logic        final_plane;                // refined, or not to be
    logic        in_y;                       // its list lies in region Y
    idx_t        base;                       // its list: first reference
  } bnode_t;

  typedef struct packed {                    // bins of one slot: bin i of an axis begins at base + (i << shift)
    point_t       base;
    shift_t [2:0] shift;
  } slot_cfg_t;

  typedef struct packed {logic [1:0] axis; coord_t pos;} cut_t;
  typedef struct packed {                    // how a pass tells members apart
    logic [2:0]   en;                        // P, lower child, upper child are divided
    cut_t [2:0]   cut;
  } classes_t;
  typedef struct packed {                    // what a pass needs to know of a member that it bins
    box_t         box;
    count_t       count;
    bin_t [2:0]   bin;                       // refining: the coarse planes
  } binned_t;
  typedef enum logic [1:0] {OUT_NONE = 2'd0, OUT_REFS = 2'd1, OUT_IDS = 2'd2} out_e;

  typedef struct packed {                    // a pass over one list
    logic       vertices;                    // else a list of references
    line_addr_t line;
    count_t     count;
    classes_t   classes;
    logic       fine;
    logic [NUM_SLOTS-1:0] bin_en;            // slots whose members are binned
    out_e       out;
    idx_t [NUM_SLOTS-1:0] base;              // where lists are written; slot 0: list entries
  } pass_t;

  typedef struct packed {                    // an inner node whose children are not yet written
    dest_t      dest;
    logic [1:0] axis;
    coord_t     pos;
    logic       swap;
    logic       lower_empty;
    logic       upper_empty;
  } split_t;
  typedef struct packed {dest_t dest; logic [5:0] gap; idx_t first; count_t count;} leaf_t;
  typedef struct packed {                    // a job and where its references are
    logic       vertices;                    // from the vertex records, all of them
    idx_t       base;                        // else first reference
    sort_job_t  job;
  } list_job_t;
endpackage
