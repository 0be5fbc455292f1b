// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The colour that a light gives a surface, by Phong's model (paper Sec. 3.6): the end of the light unit's pipeline, in the
// unit's beats but with its own time 0. Formulas in docs/whitted.md, schedule in docs/shade.md.
//   PHONG_RV    R . V and m . L arrive           PHONG_SP    (R . V)^shininess
//   PHONG_DS    diffuse m . L, tex is next       PHONG_SUM   diffuse + specular
//   PHONG_ATT   attenuation arrives; sum times colour is next                       PHONG_K     k
module rc_phong import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic                   clk_i,
  input  logic [LIGHT_BEATS-1:0] beat_i,           // [k]: times k, k + LIGHT_BEATS, ...
  input  logic                   ld_light_valid_i, // before a frame
  input  logic                   ld_mat_valid_i,
  input  mat_id_t                ld_idx_i,
  input  line_t                  ld_line_i,
  input  light_id_t              light_i,          // at time PHONG_IN
  input  mat_id_t                mat_i,            // at time PHONG_IN
  input  fp_t                    rv_i,             // at time PHONG_RV
  input  fp_t                    ml_i,             // at time PHONG_RV
  input  vec3_t                  tex_i,            // at times PHONG_DS to PHONG_DS + 2
  input  fp_t                    att_i,            // at time PHONG_ATT
  output fp_t                    k_o               // from time PHONG_K on: red, green, blue
);
  localparam int unsigned B      = LIGHT_BEATS;
  localparam int unsigned T_DM   = PHONG_RV + 1;            // operands of the first diffuse product
  localparam int unsigned T_KA   = PHONG_ATT + 1;           // operands of the last product

  // ---- records, in pieces that are read when they are due ---------------------------------------------------------
  typedef struct packed {fp_t shin; vec3_t diff;} diffuse_t;
  light_t    ld_light;
  material_t ld_mat;
  diffuse_t  diffuse;
  vec3_t     specular, color;
  mat_id_t   mat_ds;
  light_id_t light_sum;
  assign ld_light = ld_line_i;
  assign ld_mat   = ld_line_i;
  rc_hold #(.Width($bits(mat_id_t)), .Beats(B), .From(PHONG_IN), .To(PHONG_DS - 1)) u_mat_ds (
    .clk_i, .now_i(beat_i[PHONG_IN % B]), .in_i(mat_i), .out_o(mat_ds)
  );
  rc_hold #(.Width($bits(light_id_t)), .Beats(B), .From(PHONG_IN), .To(PHONG_SUM - 1)) u_light_sum (
    .clk_i, .now_i(beat_i[PHONG_IN % B]), .in_i(light_i), .out_o(light_sum)
  );
  rc_ram_1r1w #(.Width($bits(diffuse_t)), .Depth(MAX_MATERIALS)) u_diffuse (
    .clk_i, .we_i(ld_mat_valid_i), .waddr_i(ld_idx_i),
    .wdata_i({ld_mat.shin, ld_mat.diff_b, ld_mat.diff_g, ld_mat.diff_r}),
    .re_i(beat_i[PHONG_IN % B] && !ld_mat_valid_i), .raddr_i(mat_i), .rdata_o(diffuse)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(MAX_MATERIALS)) u_specular (
    .clk_i, .we_i(ld_mat_valid_i), .waddr_i(ld_idx_i),
    .wdata_i({ld_mat.spec_b, ld_mat.spec_g, ld_mat.spec_r}),
    .re_i(beat_i[(PHONG_DS - 1) % B] && !ld_mat_valid_i), .raddr_i(mat_ds), .rdata_o(specular)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(MAX_LIGHTS)) u_color (
    .clk_i, .we_i(ld_light_valid_i), .waddr_i(light_id_t'(ld_idx_i)),
    .wdata_i({ld_light.col_b, ld_light.col_g, ld_light.col_r}),
    .re_i(beat_i[(PHONG_SUM - 1) % B] && !ld_light_valid_i), .raddr_i(light_sum), .rdata_o(color)
  );

  // ---- (R . V)^shininess, 0 unless R . V > 0 -------------------------------------------------------------------------
  fp_t  power, sp, sp_ds;
  logic shines;
  rc_fp_pow #(.Latency(LAT_POW)) u_pow (.clk_i, .a_i(rv_i), .b_i(diffuse.shin), .y_o(power));
  rc_hold #(.Width(1), .Beats(B), .From(PHONG_RV), .To(PHONG_SP)) u_shines (
    .clk_i, .now_i(beat_i[PHONG_RV % B]), .in_i(fp_is_positive(rv_i)), .out_o(shines)
  );
  rc_carry #(.From(PHONG_SP), .To(PHONG_DS - 1)) u_sp (.clk_i, .in_i(shines ? power : FP_ZERO), .out_o(sp));
  rc_hold #(.Beats(B), .From(PHONG_DS - 1), .To(PHONG_DS), .Span(3)) u_sp_ds (
    .clk_i, .now_i(beat_i[(PHONG_DS - 1) % B]), .in_i(sp), .out_o(sp_ds)
  );

  // ---- (diff m.L tex + spec (R.V)^s) colour att -----------------------------------------------------------------------
  fp_t  ml_dm, matt, matt_ds, diff, spec, sum, lit, att_ka;
  logic dm_x, dm_y, ds_x, ds_y, sum_x, sum_y;
  assign {dm_y, dm_x}   = {beat_i[(T_DM + 1) % B], beat_i[T_DM % B]};
  assign {ds_y, ds_x}   = {beat_i[(PHONG_DS + 1) % B], beat_i[PHONG_DS % B]};
  assign {sum_y, sum_x} = {beat_i[(PHONG_SUM + 1) % B], beat_i[PHONG_SUM % B]};
  rc_hold #(.Beats(B), .From(PHONG_RV), .To(T_DM), .Span(3)) u_ml_dm (
    .clk_i, .now_i(beat_i[PHONG_RV % B]), .in_i(ml_i), .out_o(ml_dm)
  );
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_diff (
    .clk_i, .a_i(component(diffuse.diff, dm_x, dm_y)), .b_i(ml_dm), .y_o(matt)
  );
  rc_carry #(.From(T_DM + LAT_MUL), .To(PHONG_DS)) u_matt_ds (.clk_i, .in_i(matt), .out_o(matt_ds));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_tex (
    .clk_i, .a_i(matt_ds), .b_i(component(tex_i, ds_x, ds_y)), .y_o(diff)
  );
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_spec (
    .clk_i, .a_i(component(specular, ds_x, ds_y)), .b_i(sp_ds), .y_o(spec)
  );
  rc_fp_add #(.Latency(LAT_ADD)) u_add (.clk_i, .a_i(diff), .b_i(spec), .y_o(sum));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_color (
    .clk_i, .a_i(sum), .b_i(component(color, sum_x, sum_y)), .y_o(lit)
  );
  rc_hold #(.Beats(B), .From(PHONG_ATT), .To(T_KA), .Span(3)) u_att (
    .clk_i, .now_i(beat_i[PHONG_ATT % B]), .in_i(att_i), .out_o(att_ka)
  );
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_att (.clk_i, .a_i(lit), .b_i(att_ka), .y_o(k_o));

  if (PHONG_RV != PHONG_IN + 1 || PHONG_SP != PHONG_RV + LAT_POW || PHONG_SUM != PHONG_DS + LAT_MUL + LAT_ADD
      || T_KA != PHONG_SUM + LAT_MUL || PHONG_K != T_KA + LAT_MUL) begin : gen_check
    $error("rc_phong: the package promises other times");
  end
  logic unused_ld;
  assign unused_ld = ^{ld_light, ld_mat};
endmodule
