// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Which box a ray-box pass tests, and where a ray goes that meets it. The scene's box and the static tree's root are registers,
// those of other trees lie in instance records. A placed object is entered by its rows (mode ENTER), the last of which has the
// root again. Combinational, at P_OPER.
module rc_tni_box import rc_pkg::*, rc_tni_pkg::*; (
  input  mode_e    mode_i,
  input  level_e   level_i,
  input  line_t    line_i,                 // BOX: an instance's first line; ENTER: one of its rows'
  input  idx_t     inst_i,                 // BOX: which instance
  input  inst_id_t skip_i,                 // what the ray leaves from
  input  vec3_t    scene_lo_i,
  input  vec3_t    scene_hi_i,
  input  idx_t     scene_root_i,
  output vec3_t    lo_o,
  output vec3_t    hi_o,
  output idx_t     next_o,                 // root, or first row of a placed object; ENTER: root, if the last row
  output logic     placed_o,               // BOX: of a placed object
  output logic     skips_o                 // BOX: the triangle that the ray leaves from is in it
);
  inst_t     inst;
  inst_row_t row;
  logic      unused;
  assign inst     = inst_t'(line_i[3:0]);
  assign row      = inst_row_t'(line_i[7:4]);
  assign lo_o     = (level_i == SCENE) ? scene_lo_i : {inst.lo_z, inst.lo_y, inst.lo_x};
  assign hi_o     = (level_i == SCENE) ? scene_hi_i : {inst.hi_z, inst.hi_y, inst.hi_x};
  assign placed_o = level_i == OBJECT && inst.placed;
  assign skips_o  = skip_i == (placed_o ? inst_id_t'(inst_i) : NOT_PLACED);
  always_comb begin
    if (mode_i == ENTER)       next_o = row.root;
    else if (level_i == SCENE) next_o = scene_root_i;
    else if (placed_o)         next_o = inst_half(inst_id_t'(inst_i), ROW_FIRST);
    else                       next_o = inst.root;
  end
  assign unused = ^{inst, row, inst_i};
endmodule
