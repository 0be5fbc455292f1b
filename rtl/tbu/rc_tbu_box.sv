// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Reference of a triangle from its record of 32 bytes: nine FP24 coordinates (vertex 0 x, y, z, vertex 1 ...), then opaque
// at bit 216. A vertex a cycle: to fixed point, then into the box; a triangle in three cycles, one vertex after the other.
// A coordinate must be a multiple of 2^-17 within (-1, 1), else bad_o with the reference: no rounding could keep boxes exact.
module rc_tbu_box import rc_pkg::*; import rc_tbu_pkg::*; (
  input  logic         clk_i,
  input  logic         rst_ni,
  input  logic         in_valid_i,
  output logic         in_ready_o,
  input  logic [255:0] in_rec_i,
  input  logic [TRI_W-1:0] in_idx_i,
  output logic         out_valid_o,
  input  logic         out_ready_i,
  output tri_ref_t     out_ref_o,
  output logic         out_bad_o
);
  localparam coord_t      ZERO = coord_t'(1 << (COORD_W - 1));

  // ---- to fixed point ---------------------------------------------------------------------------------
  logic [1:0]  vertex_q;
  vec3_t       vertex;
  point_t      fix;
  logic [2:0]  bad;
  assign vertex = in_rec_i[72 * vertex_q +: 72];
  for (genvar a = 0; a < 3; a++) begin : gen_axis
    logic              neg;
    logic [FP_MAN_W:0] mag;
    rc_tbu_fix u_fix (.x_i(vertex[a]), .neg_o(neg), .mag_o(mag), .bad_o(bad[a]));
    assign fix[a] = neg ? ZERO - coord_t'(mag) : ZERO + coord_t'(mag);
  end

  // ---- box -------------------------------------------------------------------------------------------
  logic   last, step, full_q, bad_q;
  point_t lo_q, hi_q;
  logic [TRI_W-1:0] idx_q;
  logic   opaque_q;
  assign last       = vertex_q == 2'd2;
  assign step       = in_valid_i && (!full_q || out_ready_i);
  assign in_ready_o = step && last;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {vertex_q, full_q} <= '0;
    end else begin
      if (step) vertex_q <= last ? '0 : vertex_q + 1'b1;
      if (step && last) full_q <= 1'b1;
      else if (out_ready_i) full_q <= 1'b0;
    end
    if (step) begin
      for (int a = 0; a < 3; a++) begin
        if (vertex_q == '0 || fix[a] < lo_q[a]) lo_q[a] <= fix[a];
        if (vertex_q == '0 || fix[a] > hi_q[a]) hi_q[a] <= fix[a];
      end
      bad_q    <= (vertex_q != '0 && bad_q) || bad != '0;
      idx_q    <= in_idx_i;
      opaque_q <= in_rec_i[216];
    end
  end
  assign out_valid_o = full_q;
  assign out_ref_o   = '{opaque: opaque_q, tri_idx: idx_q, hi: hi_q, lo: lo_q};
  assign out_bad_o   = bad_q;
  logic unused_rec;
  assign unused_rec = ^in_rec_i[255:217];
endmodule
