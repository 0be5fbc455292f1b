// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Stage plan and types of the T&I pipeline (paper Sec. 3.4, Fig. 5).
//
// A value "of stage n" is a register's output during stage n; a unit of latency L that reads operands
// of stage n delivers in stage n + L. Every stage number follows from the units' latencies, so that
// deeper units give a longer ring and nothing else. With the paper's latencies there are 19 stages of
// work, P20 decides and P21 returns the ray to the top ("P21" in the paper, Sec. 3.5).
package rc_tni_pkg;
  import rc_pkg::*;

  parameter int unsigned SLOT_W      = 5;    // 32 rays a pipeline: 21 in the ring, the rest wait
  parameter int unsigned STACK_DEPTH = 32;   // paper Sec. 4.1
  parameter int unsigned SP_W        = 6;
  typedef logic [SLOT_W-1:0] slot_t;

  function automatic int unsigned later(int unsigned a, int unsigned b);
    return (a > b) ? a : b;
  endfunction

  // ---- stages, with the numbers that the paper's latencies give -----------------------------------
  localparam int unsigned P_LIST  = 1;                              // list cache is asked
  localparam int unsigned P_INDEX = P_LIST + 1;                     // P2  triangle index, address
  localparam int unsigned P_NT    = P_INDEX + 1;                    // P3  node/TriAccel cache is asked
  localparam int unsigned P_LINE  = P_NT + 1;                       // P4  hit or miss
  localparam int unsigned P_OPER  = P_LINE + 1;                     // P5  node or record, ray
  localparam int unsigned P_ND    = P_OPER + LAT_MUL;               // P6  n.d products
  localparam int unsigned P_OFF   = P_OPER + LAT_ADD;               // P7  o - A; split - o; box - o
  localparam int unsigned P_SCALE = P_OFF + LAT_MUL;                // P8  n(o - A); t of step 1; near box
  localparam int unsigned P_DEN   = P_ND + LAT_ADD3;                // P8  n.d
  localparam int unsigned P_STEP1 = P_SCALE + LAT_CMP;              // P9  comparisons of step 1
  localparam int unsigned P_NEXT1 = P_STEP1 + 1;                    // P10 outcome of step 1
  localparam int unsigned P_BOXN  = P_STEP1 + LAT_CMP;              // P10 the box's tmin
  localparam int unsigned P_NUM   = P_SCALE + LAT_ADD3;             // P10 -n.(o - A)
  localparam int unsigned P_RCP   = P_DEN + LAT_DIV;                // P10 1 / n.d
  localparam int unsigned P_QUOT  = later(P_NUM, P_RCP);            // P10
  localparam int unsigned P_T     = P_QUOT + LAT_MUL;               // P11 t
  localparam int unsigned P_TD    = P_T + LAT_MUL;                  // P12 t d
  localparam int unsigned P_OPER2 = later(P_TD, P_NEXT1);           // P12 node of step 2
  localparam int unsigned P_OFF2  = P_OPER2 + LAT_ADD;              // P14 h = o - A + t d; split - o; far box
  localparam int unsigned P_UV    = P_OFF2 + LAT_MUL;               // P15 h b, h g; t of step 2
  localparam int unsigned P_STEP2 = P_UV + LAT_CMP;                 // P16 comparisons of step 2
  localparam int unsigned P_NEXT2 = P_STEP2 + 1;                    // P17 outcome of step 2, stack write
  localparam int unsigned P_BOXF  = P_STEP2 + LAT_CMP;              // P17 the box's tmax
  localparam int unsigned P_BG    = P_UV + LAT_ADD;                 // P17 beta, gamma
  localparam int unsigned P_SUM   = P_BG + LAT_ADD;                 // P19 beta + gamma
  localparam int unsigned P_POP   = later(P_NEXT2, P_BOXF);         // P17 what a pop would bring
  localparam int unsigned P_END   = later(P_SUM, P_POP) + LAT_CMP;  // P20 everything is known
  localparam int unsigned P_TOP   = P_END + 1;                      // P21 back to the top

  // ---- state of a ray that goes round the ring ------------------------------------------------------
  // ENTER: into the coordinates of a placed object, a row of its rotation in a pass.
  typedef enum logic [2:0] {BOX = 3'd0, TRAV = 3'd1, ISECT = 3'd2, POP = 3'd3, ENTER = 3'd4} mode_e;
  localparam int unsigned MODE_W = $bits(mode_e);

  // Which tree. BOX in level OBJECT: idx names the object that may be entered next.
  typedef enum logic [1:0] {SCENE = 2'd0, TOP = 2'd1, OBJECT = 2'd2} level_e;

  typedef struct packed {
    slot_t           slot;      // where its constants, stack and hit are kept
    mode_e           mode;
    level_e          level;
    logic            placed;    // TRAV, ISECT in level OBJECT: the ray in the object's coordinates is meant
    logic            skips;     // the triangle that the ray leaves from is in this tree
    logic            direct;    // ISECT: idx is the triangle itself, BOX: the instance; not a list index
    idx_t            idx;       // node, list entry, triangle or instance; ENTER: half of a line, from INST_BASE
    fp_t             tmin;      // interval in the current node
    fp_t             tmax;
    fp_t             best;      // nearest hit so far, at first the ray's t_max
    logic            slack;     // the best hit used the edge slack
    logic            hit;
    logic [SP_W-1:0] sp;        // stack entries
    logic [15:0]     slots;     // slots taken so far
  } state_t;

  // Constants of a ray, read by slot.
  typedef struct packed {
    logic  any_hit;
    surf_t skip;
    fp_t   t_min;
    fp_t   t_max;
    vec3_t inv_dir;
    vec3_t dir;
    vec3_t org;
  } ray_const_t;

  // A component of a ray in an object's coordinates.
  typedef struct packed {
    fp_t inv_dir;
    fp_t dir;
    fp_t org;
  } ray_axis_t;

  // 72 bits, as the paper's 36 KB of stacks: four pipelines x 32 rays x 32 levels.
  typedef struct packed {
    idx_t node;
    fp_t  tmin;
    fp_t  tmax;
  } entry_t;

  // A node and what the ray's direction says about it.
  typedef struct packed {
    node_t node;
    idx_t  idx;
    fp_t   tmin;
    fp_t   tmax;
    logic  neg;                 // the ray runs down the axis: the upper child is the near one
  } visit_t;

  // Where a ray that entered an object comes back to, kept by slot.
  typedef struct packed {
    logic            last;      // no other object in that leaf of the top-level tree
    idx_t            idx;       // next list entry
    logic [SP_W-1:0] base;      // stack entries of the top-level tree
    inst_id_t        inst;      // the object, if it is placed
  } back_t;

  // A half line of an instance's record, counted from INST_BASE, and back.
  function automatic idx_t inst_half(inst_id_t inst, inst_half_t half);
    return idx_t'({inst, half});
  endfunction
  function automatic inst_id_t inst_of(idx_t half);
    return inst_id_t'(half >> INST_HALF_W);
  endfunction

  // Where a traversal step leads.
  typedef enum logic [1:0] {GO_NODE = 2'd0, GO_LEAF = 2'd1, GO_POP = 2'd2} go_e;

  typedef struct packed {
    go_e    go;
    idx_t   idx;                // GO_NODE: node; GO_LEAF: list entry or triangle
    logic   direct;             // GO_LEAF: idx is a triangle
    logic   adjacent;           // GO_NODE: it is the child next to its parent
    fp_t    tmin;
    fp_t    tmax;
    logic   push;               // the far child waits on the stack
    entry_t far_child;
  } step_t;

  // Largest and smallest neighbours of t >= 0 on the bit pattern: the traversal's slack of 1 ulp, and
  // the 16 ulp by which a slack hit must be nearer.
  function automatic fp_t ulp_up(fp_t a, logic [FP_W-2:0] n);
    logic [FP_W-1:0] sum;
    sum = {1'b0, a[FP_W-2:0]} + {1'b0, n};
    if (a[FP_W-2:0] >= FP_INF[FP_W-2:0]) return a;
    return {a[FP_W-1], (sum >= FP_INF) ? FP_INF[FP_W-2:0] : sum[FP_W-2:0]};
  endfunction

  function automatic fp_t ulp_down1(fp_t a);
    if (a[FP_W-2:0] >= FP_INF[FP_W-2:0] || a[FP_W-2:0] == '0) return a;
    return {a[FP_W-1], a[FP_W-2:0] - 1'b1};
  endfunction

  function automatic logic negative(fp_t a);   // -0 is not
    return a[FP_W-1] && a[FP_W-2:FP_MAN_W] != '0;
  endfunction

endpackage
