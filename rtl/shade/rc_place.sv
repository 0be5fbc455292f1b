// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Brings the triangle information of a placed object into the scene's coordinates: its five vectors times the rotation, vertex 0
// plus the origin besides. Additions in the order of raycore.model.shade.place: (m_x x + m_y y) + m_z z, then the origin.
// Two rows times vectors start in a cycle, from time 0 of the job:
//   time    0    1    2    3    4    5    6    7
//   unit 0  a.x  a.y  a.z  n0.x n0.y n0.z e2.x e2.y
//   unit 1  n.x  n.y  n.z  e1.x e1.y e1.z e2.z
//   T_PROD  three products   T_SUM  sum of two   T_DOT  and of the third   T_ORG  a plus the origin
//   T_OUT   all is there; e2.y, the last, straight from its adder
// One job at a time: it is in at time 0, and is taken with its result. So nothing but the result is kept here.
module rc_place import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic        clk_i,
  input  logic        rst_ni,
  input  vec3_t [2:0] rot_i,               // rows of the rotation; they and the origin hold while a job is inside
  input  vec3_t       origin_i,
  input  logic        in_valid_i,
  output logic        in_ready_o,          // only when the result is taken
  input  tri_info_t   in_info_i,           // in the object's coordinates
  output logic        out_valid_o,
  input  logic        out_ready_i,
  output tri_info_t   out_info_o           // in the scene's
);
  localparam int unsigned STEPS  = 8;                                 // of two of the fifteen components
  localparam int unsigned T_PROD = LAT_MUL;
  localparam int unsigned T_SUM  = T_PROD + LAT_ADD;
  localparam int unsigned T_DOT  = T_SUM + LAT_ADD;
  localparam int unsigned T_LAST = T_DOT + STEPS - 1;                 // e2.y
  localparam int unsigned T_ORG  = T_DOT + LAT_ADD;
  localparam int unsigned T_OUT  = later(T_LAST, T_ORG + 3);          // a.z is kept at T_ORG + 2

  // ---- time: at[k] is set at time k of the job ---------------------------------------------------------------------------
  logic [T_OUT:0] at;
  logic [T_OUT:1] at_q;
  logic           busy_q, done_q, leave;
  assign at          = {at_q, in_valid_i && !busy_q};
  assign out_valid_o = at[T_OUT] || done_q;
  assign leave       = out_valid_o && out_ready_i;
  assign in_ready_o  = leave;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      at_q   <= '0;
      busy_q <= 1'b0;
      done_q <= 1'b0;
    end else begin
      at_q   <= at[T_OUT-1:0];
      busy_q <= (busy_q || in_valid_i) && !leave;
      done_q <= out_valid_o && !leave;
    end
  end

  // ---- two units: a row times a vector -------------------------------------------------------------------------------------
  typedef struct packed {vec3_t e2; vec3_t e1; vec3_t n0; vec3_t n; vec3_t a;} tri_t;
  tri_t        own;
  vec3_t [1:0] row, vec;
  fp_t   [1:0] dot;
  logic        is_first, is_second, is_x, is_y;
  assign own.a  = {in_info_i.a_z, in_info_i.a_y, in_info_i.a_x};
  assign own.n  = {in_info_i.n_z, in_info_i.n_y, in_info_i.n_x};
  assign own.n0 = {in_info_i.n0_z, in_info_i.n0_y, in_info_i.n0_x};
  assign own.e1 = {in_info_i.e1_z, in_info_i.e1_y, in_info_i.e1_x};
  assign own.e2 = {in_info_i.e2_z, in_info_i.e2_y, in_info_i.e2_x};
  assign is_first  = at[2:0] != '0;
  assign is_second = at[5:3] != '0;
  assign is_x      = at[0] || at[3] || at[6];
  assign is_y      = at[1] || at[4] || at[7];
  assign vec[0]    = is_first ? own.a : is_second ? own.n0 : own.e2;
  assign vec[1]    = is_first ? own.n : is_second ? own.e1 : own.e2;
  assign row[0]    = is_x ? rot_i[0] : is_y ? rot_i[1] : rot_i[2];
  assign row[1]    = at[6] ? rot_i[2] : row[0];
  for (genvar u = 0; u < 2; u++) begin : gen_dot
    fp_t [2:0] prod;
    fp_t       sum, prod_z;
    for (genvar i = 0; i < 3; i++) begin : gen_mul
      rc_fp_mul #(.Latency(LAT_MUL)) u_mul (.clk_i, .a_i(row[u][i]), .b_i(vec[u][i]), .y_o(prod[i]));
    end
    rc_fp_add #(.Latency(LAT_ADD)) u_sum (.clk_i, .a_i(prod[0]), .b_i(prod[1]), .y_o(sum));
    rc_carry #(.Width(FP_W), .From(T_PROD), .To(T_SUM)) u_prod_z (.clk_i, .in_i(prod[2]), .out_o(prod_z));
    rc_fp_add #(.Latency(LAT_ADD)) u_dot (.clk_i, .a_i(sum), .b_i(prod_z), .y_o(dot[u]));
  end
  fp_t origin, moved;
  assign origin = component(origin_i, at[T_DOT], at[T_DOT+1]);
  rc_fp_add #(.Latency(LAT_ADD)) u_origin (.clk_i, .a_i(dot[0]), .b_i(origin), .y_o(moved));

  // ---- the result ------------------------------------------------------------------------------------------------------------
  tri_t res_q, res;
  always_ff @(posedge clk_i) begin
    for (int i = 0; i < 3; i++) begin
      if (at[T_ORG+i])   res_q.a[i]  <= moved;
      if (at[T_DOT+i])   res_q.n[i]  <= dot[1];
      if (at[T_DOT+3+i]) res_q.n0[i] <= dot[0];
      if (at[T_DOT+3+i]) res_q.e1[i] <= dot[1];
    end
    if (at[T_DOT+6]) res_q.e2[0] <= dot[0];
    if (at[T_LAST])  res_q.e2[1] <= dot[0];
    if (at[T_DOT+6]) res_q.e2[2] <= dot[1];
  end
  always_comb begin
    res = res_q;
    if (at[T_LAST]) res.e2[1] = dot[0];
    out_info_o = in_info_i;                                           // the material
    {out_info_o.a_z, out_info_o.a_y, out_info_o.a_x}    = res.a;
    {out_info_o.n_z, out_info_o.n_y, out_info_o.n_x}    = res.n;
    {out_info_o.n0_z, out_info_o.n0_y, out_info_o.n0_x} = res.n0;
    {out_info_o.e1_z, out_info_o.e1_y, out_info_o.e1_x} = res.e1;
    {out_info_o.e2_z, out_info_o.e2_y, out_info_o.e2_x} = res.e2;
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) OneTime_A: assert ($onehot0({at, done_q}) && (busy_q || (at_q == '0 && !done_q)));
    if (rst_ni && busy_q) begin
      InHeld_M: assume (in_valid_i && $stable(in_info_i) && $stable(rot_i) && $stable(origin_i));
    end
    if (rst_ni && $past(rst_ni && out_valid_o && !out_ready_i)) begin
      OutHeld_A: assert (out_valid_o && $stable(out_info_o));
    end
  end
`endif
endmodule
