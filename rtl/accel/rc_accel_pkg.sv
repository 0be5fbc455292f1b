// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Types of the record unit, which makes TriAccel records and triangle information from vertices. docs/accel.md explains it.
package rc_accel_pkg;
  import rc_pkg::*;

  parameter int unsigned CROSS_W = 37;       // bits of a component of the cross product, without its sign
  parameter int unsigned QUOT_W  = 19;       // bits of a quotient: 17, one to round by, a leading zero or one more
  parameter int unsigned NORM_W  = 31;       // bits of a normal's length
  parameter int unsigned EDGE_W  = 19;       // bits of an edge's length, rounded down; signed edges have as many
  parameter int unsigned GRID    = 17;       // a coordinate is a multiple of 2^-17
  parameter int unsigned EYE_W   = 16;       // signed, in 2^-8
  parameter int unsigned EYE_FRAC = 8;
  parameter int unsigned SLACK_W = 14;       // factor of the edge slack, in 2^-7
  parameter int unsigned SLACK_FRAC = 7;
  parameter logic [SLACK_W-1:0] SLACK_MAX = SLACK_W'(64 << SLACK_FRAC);
  typedef logic [CROSS_W-1:0]     wide_t;
  typedef logic [5:0]             shift_t;
  typedef logic signed [8:0]      exp_t;     // exponents between operations
  typedef logic [SLACK_W-1:0]     slack_t;
  typedef logic signed [EYE_W-1:0] eye_t;

  // What the host says; constant while records are made.
  typedef struct packed {
    line_addr_t vertex_base;                 // 32 bytes a triangle, as for the tree builder
    line_addr_t attr_base;                   // 32 bytes a triangle: attr_t from bit 0
    line_addr_t accel_base;
    line_addr_t info_base;
    idx_t       tri_count;
    eye_t [2:0] eye;                         // [0] x
    slack_t     slack;                       // least factor of the edge slack
  } accel_cfg_t;

  // Attribute record, 32 bytes, the low 229 bits used.
  typedef struct packed {
    logic        flat;                       // [228] the plane's normal is the normal everywhere
    mat_t        mat;                        // [227:216]
    vec3_t [2:0] n;                          // [215:0] at vertices 0, 1, 2
  } attr_t;
  parameter int unsigned ATTR_W = 229;

  typedef struct packed {logic neg; shift_t shift; wide_t val;} norm_t;   // x = val 2^-shift, top bit set unless x = 0

  // From the first stage: exact integers.
  typedef struct packed {
    logic        opaque;
    logic        dead;                       // no area
    logic [1:0]  k;
    vec3_t       a;                          // vertex 0
    norm_t       det;                        // component k of the cross product
    norm_t [1:0] side;                       // components u and v
    logic [3:0]  edge_neg;                   // b_u, b_v, g_u, g_v times component k: signs, and sizes
    logic [3:0][4:0]  edge_shift;            // of 18 bits
    logic [3:0][17:0] edge_val;
    logic [37:0] longest;                    // square of the longest projected edge, shifted by 2 half
    logic [4:0]  half;
    logic [33:0] eye_dist;                   // square of |sum of vertices - 3 eye|
    logic [61:0] square;                     // of the normal's length
  } cross_t;

  // From the second stage.
  typedef struct packed {
    logic        opaque;
    logic        dead;
    logic [1:0]  k;
    vec3_t       a;
    norm_t       det;
    norm_t [1:0] side;
    fp_t [1:0]   n;                          // n_u, n_v
    fp_t [1:0]   b;
    fp_t [1:0]   g;
    logic [4:0]  half;
    slack_t      slack;
    logic [EDGE_W:0]   longest;              // length, rounded up
    logic [NORM_W-1:0] length;
  } proj_t;

  // Quotient of normalised operands to FP24, to nearest even. q: QUOT_W bits, the first or second is the first one;
  // rest: something is left; e: biased exponent if the first one is set.
  function automatic fp_t round_quotient(logic neg, logic zero, logic [QUOT_W-1:0] q, logic rest,
                                         logic [FP_EXP_W-1:0] e);
    logic [FP_MAN_W:0]   sig;                // without the leading one, with the bit to round by
    logic                sticky;
    logic [FP_EXP_W-1:0] exponent;
    logic [FP_W-2:0]     word;
    sig      = q[QUOT_W-1] ? q[QUOT_W-2:1] : q[QUOT_W-3:0];
    sticky   = rest || (q[QUOT_W-1] && q[0]);
    exponent = q[QUOT_W-1] ? e : e - 1'b1;
    word     = {exponent, sig[FP_MAN_W:1]} + (FP_W - 1)'(sig[0] && (sticky || sig[1]));
    return zero ? FP_ZERO : {neg, word};
  endfunction
endpackage
