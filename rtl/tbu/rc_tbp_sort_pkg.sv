// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Types inside a sorting pipeline, wide enough for 2047 references. "Child 0" is the lower child of the node in work.
package rc_tbp_sort_pkg;
  import rc_pkg::*;
  import rc_tbu_pkg::*;

  parameter int unsigned MAX_CAP = 2047;
  typedef logic [10:0] ref_t;              // place of a reference in the pipeline's memory
  typedef logic [11:0] num_t;              // references or events of a node
  typedef logic [12:0] ptr_t;              // place in a list memory
  typedef logic [18:0] rim_t;              // e1 + e2, extents of a box across an axis
  typedef logic [35:0] face_t;             // e1 e2
  typedef logic [37:0] half_t;             // half a surface: e1 e2 + (e1 + e2) w
  typedef logic [54:0] cost_t;             // 8 (2 Hn + 3 (H nL + H' nR)), or 24 n Hn

  // Events of a reference on an axis, in the order of a sweep at one position: end, planar (before), planar (after), start.
  // The last two of these are `start`; a planar reference is one with lo = hi, and has the two in the middle.
  typedef struct packed {logic start; ref_t idx;} event_t;
  typedef struct packed {coord_t pos; logic start; logic odd;} event_key_t; // odd: start and not planar, or the reverse

  typedef struct packed {coord_t hi; coord_t lo;} span_t;
  typedef struct packed {                  // of a child and axis
    rim_t  rim;                            // e1 + e2
    face_t cap;                            // e1 e2
  } eval_axis_t;
  typedef struct packed {                  // of a child
    eval_axis_t [2:0] axis;
    half_t            half;                // Hn
    cost_t            limit;               // 24 n Hn: what costs less pays
  } eval_cfg_t;

  typedef struct packed {                  // a candidate
    coord_t pos;
    logic   pl;                            // where planar references go: 1 upper
    logic   late;                          // of equal ones at a position the last counts, not the first
    num_t   nl;
    num_t   nr;
  } cand_t;
  typedef struct packed {                  // the best of an axis
    logic   found;                         // one that pays
    cost_t  cost;
    coord_t pos;
    logic   pl;
    num_t   nl;
    num_t   nr;
  } best_t;

  // A walk over the list of references of a node.
  typedef struct packed {
    logic        divide;                   // into lists of the children, and tell the axes; else give them out: a leaf
    logic        donate;                   // give out those of the child whose list would go to A instead
    logic        in_b;
    ptr_t        first;
    num_t        num;
    logic        b_upper;                  // as in sweep_t
    ptr_t        first_b;
  } walk_t;

  typedef struct packed {                  // the plane that divides a node, and how many references its children get
    logic [1:0] axis;
    coord_t     pos;
    logic       pl;
    num_t       nl;
    num_t       nr;
  } plane_t;

  // A sweep over the events of a node on one axis: of the root, or of both children while their lists are made.
  typedef struct packed {
    logic        root;                     // child 0 is the node itself, its list stays
    logic        in_b;                     // where the list lies
    ptr_t        first;
    num_t        num;
    logic        cut;                      // the children are cut on this axis
    coord_t      pos;                      // there
    logic        b_upper;                  // the upper child's list goes to B, else the lower one's
    ptr_t        first_b;                  // its first place
    logic  [1:0] keep;                     // of child 0 and 1: make a list
    num_t  [1:0] num_refs;
    span_t [1:0] span;                     // of child 0 and 1
  } sweep_t;

  typedef struct packed {                  // a node that is to be made
    box_t       box;
    level_t     level;
    num_t       count;
    logic       split;                     // else a leaf
    plane_t     plane;
    logic       swap;                      // the adjacent child is the upper one
    logic       b_upper;                   // the upper child's lists go to B, else the lower one's
    logic [TRI_W-1:0] tri_idx;             // a leaf of one
    logic       refs_in_b;                 // its list of references lies in B and runs down, else in A and up
    logic       in_b;                      // its lists of events likewise
    ptr_t       refs;                      // first place of the list of references
    ptr_t [2:0] events;                    // of the lists of events
    num_t [2:0] num_events;
  } tnode_t;

  typedef struct packed {                  // an inner node whose children are being made
    logic [1:0] axis;
    coord_t     pos;
    fp_t        split;                     // the same as a number
    logic       swap;
    logic       lower_empty;
    logic       upper_empty;
    logic       donated;                   // rc_tbu_upper writes it
    logic [6:0] entry;
  } frame_t;
endpackage
