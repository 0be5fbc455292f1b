// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Times of rc_bounce and its parts, in cycles of a job (rc_shade_pkg; docs/bounce.md has the schedule), and what they pass on.
// T_NAME_IN is when the operation that makes NAME starts, T_NAME when its (x component's) result is there.
package rc_bounce_pkg;
  import rc_pkg::*;
  import rc_shade_pkg::*;

  parameter int unsigned BEATS = LIGHT_BEATS;

  // The last time up to `latest` that is in the same beat as time `like`.
  function automatic int unsigned last_beat(int unsigned latest, int unsigned like);
    return latest - (latest % BEATS + BEATS - like % BEATS) % BEATS;
  endfunction

  // ---- Snell's law: one multiplier (ee, ce, cc), one adder (k1, b, k), the square root --------------------------------
  parameter int unsigned T_CTX   = 1;                             // context: x, y, z, scalars
  parameter int unsigned T_MAT   = T_CTX + 4;                     // the scalars are in slot 1
  parameter int unsigned T_ETA   = T_MAT + 1;                     // flags, eta
  parameter int unsigned T_EE_IN = T_ETA;
  parameter int unsigned T_EE    = T_EE_IN + LAT_MUL;             // eta eta
  parameter int unsigned T_CE_IN = T_EE_IN + 1;
  parameter int unsigned T_CE    = T_CE_IN + LAT_MUL;             // eta c
  parameter int unsigned T_CC_IN = next_beat(T_CE, T_EE_IN + 2, BEATS);
  parameter int unsigned T_CC    = T_CC_IN + LAT_MUL;             // (eta c)^2
  parameter int unsigned T_K1_IN = T_EE;
  parameter int unsigned T_K1    = T_K1_IN + LAT_ADD;             // 1 - eta eta, or 1 - alpha'
  parameter int unsigned T_K_IN  = next_beat(later(T_K1, T_CC), T_K1_IN + 2, BEATS);
  parameter int unsigned T_K     = T_K_IN + LAT_ADD;              // k
  parameter int unsigned T_SEL   = next_beat(T_K + 2, 0, BEATS);  // from here on the slot tells whether k > 0
  parameter int unsigned T_SK    = T_K + LAT_SQRT;                // sqrt k
  parameter int unsigned T_B_IN  = next_beat(T_SK, T_K1_IN + 1, BEATS);
  parameter int unsigned T_B     = T_B_IN + LAT_ADD;              // b
  parameter int unsigned T_TURN  = later(T_B, T_SEL);             // which child it is, and its factor of m

  // ---- direction (rc_bounce_dir): two trios of multipliers, two adders with their dot products ------------------------
  parameter int unsigned T_TM_IN = T_TURN + 1;                    // trio: a
  parameter int unsigned T_TM    = T_TM_IN + LAT_MUL;             // factor times m
  parameter int unsigned T_ED_IN = last_beat(T_TM - LAT_MUL, T_TM_IN + 1);                  // b
  parameter int unsigned T_ED    = T_ED_IN + LAT_MUL;             // eta d
  parameter int unsigned T_V_IN  = T_TM;
  parameter int unsigned T_V     = T_V_IN + LAT_ADD;              // v: direction, not yet of unit length
  parameter int unsigned T_GV_IN = next_beat(T_V, T_TM_IN + 3, BEATS);                      // c
  parameter int unsigned T_GV    = T_GV_IN + LAT_MUL;             // products g v
  parameter int unsigned T_G1_IN = next_beat(T_GV + 1, T_V_IN + 4, BEATS);
  parameter int unsigned T_G1    = T_G1_IN + LAT_ADD;             // x + y
  parameter int unsigned T_G_IN  = next_beat(later(T_G1, T_GV + 2), T_V_IN + 3, BEATS);
  parameter int unsigned T_G     = T_G_IN + LAT_ADD;              // g . v
  parameter int unsigned T_GG_IN = T_G + 1;                       // trio: a
  parameter int unsigned T_GG    = T_GG_IN + LAT_MUL;             // 2 g.v g
  parameter int unsigned T_N_IN  = T_GG;
  parameter int unsigned T_N     = T_N_IN + LAT_ADD;              // n: v on the right side of the triangle
  parameter int unsigned T_NN_IN = next_beat(T_N, T_GG_IN + 3, BEATS);                      // c
  parameter int unsigned T_NN    = T_NN_IN + LAT_MUL;             // squares
  parameter int unsigned T_N1_IN = next_beat(T_NN + 1, T_N_IN + 4, BEATS);
  parameter int unsigned T_N1    = T_N1_IN + LAT_ADD;             // x + y
  parameter int unsigned T_N2_IN = next_beat(later(T_N1, T_NN + 2), T_N_IN + 3, BEATS);
  parameter int unsigned T_N2    = T_N2_IN + LAT_ADD;             // n . n
  parameter int unsigned T_LEN_IN = next_beat(T_N2, T_K + 3, BEATS);                        // square root
  parameter int unsigned T_LEN   = T_LEN_IN + LAT_SQRT;           // |n|
  parameter int unsigned T_INV   = T_LEN + LAT_DIV;               // 1 / |n|
  parameter int unsigned T_DIR_IN = next_beat(T_INV + 1, T_GG_IN + 1, BEATS);               // b
  parameter int unsigned T_DIR   = T_DIR_IN + LAT_MUL;            // n / |n|

  // ---- origin ---------------------------------------------------------------------------------------------------------
  parameter int unsigned T_O_IN  = T_V_IN;
  parameter int unsigned T_O     = T_O_IN + LAT_ADD;

  // ---- weight (rc_bounce_weight): a trio and two multipliers, a trio of adders ----------------------------------------
  parameter int unsigned T_X_IN  = T_SK;                          // adders: s
  parameter int unsigned T_X     = T_X_IN + LAT_ADD;              // x = 1 - cosine
  parameter int unsigned T_X2_IN = T_X;
  parameter int unsigned T_X2    = T_X2_IN + LAT_MUL;
  parameter int unsigned T_X4_IN = next_beat(T_X2, T_X2_IN + 1, BEATS);
  parameter int unsigned T_X4    = T_X4_IN + LAT_MUL;
  parameter int unsigned T_X5_IN = T_X4;                          // trio: s
  parameter int unsigned T_X5    = T_X5_IN + LAT_MUL;
  parameter int unsigned T_RISE_IN = next_beat(T_X5 + 1, T_X5_IN + 2, BEATS);               // b
  parameter int unsigned T_RISE  = T_RISE_IN + LAT_MUL;           // (1 - kr') x^5
  parameter int unsigned T_UKR_IN = last_beat(T_RISE_IN - LAT_ADD, T_X_IN + 4);             // adders: c
  parameter int unsigned T_UKR   = T_UKR_IN + LAT_ADD;            // 1 - kr'
  parameter int unsigned T_KR_IN = last_beat(T_UKR_IN - LAT_MUL, T_X5_IN + 4);              // c
  parameter int unsigned T_KR    = T_KR_IN + LAT_MUL;             // kr'
  parameter int unsigned T_F_IN  = next_beat(T_RISE, T_X_IN + 2, BEATS);                    // adders: b
  parameter int unsigned T_F     = T_F_IN + LAT_ADD;              // F, or kr' + kt
  parameter int unsigned T_UF_IN = next_beat(T_F, T_X_IN + 1, BEATS);                       // adders: a
  parameter int unsigned T_UF    = T_UF_IN + LAT_ADD;             // 1 - F
  parameter int unsigned T_TF_IN = next_beat(T_UF, T_X2_IN + 2, BEATS);
  parameter int unsigned T_TF    = T_TF_IN + LAT_MUL;             // kt (1 - F)
  parameter int unsigned T_SH_IN = T_TF;
  parameter int unsigned T_SH    = T_SH_IN + LAT_MUL;             // T tex, or w alpha'
  parameter int unsigned T_W_IN  = next_beat(T_SH, T_X5_IN + 1, BEATS);                     // a
  parameter int unsigned T_W     = T_W_IN + LAT_MUL;              // weight
  parameter int unsigned T_HEAVY = T_W + 2 + LAT_CMP;             // > MIN_WEIGHT, all components seen

  parameter int unsigned T_END   = later(later(T_DIR + 2, T_O + 2), T_HEAVY + 1);
  parameter int unsigned SLOTS   = T_END / BEATS + 1;             // jobs inside

  // ---- what is passed on ----------------------------------------------------------------------------------------------
  typedef struct packed {                  // of mat_flags_t
    logic alpha;                           // not ALPHA_OPAQUE
    logic tex_kr;
    logic fresnel;
    logic transmits;
    logic reflects;
  } optic_flags_t;

  typedef struct packed {                  // which child a job makes; none set: the reflected one
    logic tir;                             // of a material that transmits: all light is reflected
    logic fresnel;
    logic refract;                         // transmitted, refracted
    logic straight;                        // transmitted, in the same direction
  } turn_t;

  typedef struct packed {                  // a job: half of a bounce if that may have two children
    ray_id_t id;
    logic    branch;
    logic    second;                       // of the two: the reflected one; the transmitted one goes first
  } half_t;

  typedef struct packed {                  // a ray that is to be traced, as the stacks keep it
    depth_t depth;
    surf_t  skip;
    vec3_t  w;
    fp_t    len;
    vec3_t  dir;
    vec3_t  org;
  } child_t;
endpackage
