// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Transparent shadows (paper Sec. 3.3): a shadow ray ended at a triangle that is not opaque. How much of the light comes through
// by its material and texture, whether that is worth going on, and where the ray starts again. It also keeps what comes
// through so far for every index: 1 when a light starts. One blocker in eight cycles on one multiplier, one adder, one
// comparator (rc_shade_pkg); formulas in docs/whitted.md:
//   T_A     alpha a              T_KT    kt tex                     T_TM    t + T_MIN, in another beat of the adder
//   T_CUT   compared             T_REST  1 - alpha'                 T_TR    new transmittance      T_END   compared
// Never stalls: the queues of both outcomes have a place for every index.
module rc_through import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic     clk_i,
  input  logic     rst_ni,
  input  fp_t      min_weight_i,
  input  logic     ld_mat_valid_i,     // before a frame: materials
  input  logic     ld_opt_valid_i,     // and their optics
  input  mat_id_t  ld_idx_i,
  input  line_t    ld_line_i,
  input  logic     k_valid_i,          // a light has made a shadow ray
  input  job_t     k_job_i,
  input  logic     start_i,            // the next light of an index starts
  input  ray_id_t  start_id_i,
  input  logic     tr_re_i,            // what comes through for an index, a cycle later until the next is asked for
  input  ray_id_t  tr_id_i,
  output vec3_t    tr_o,
  input  logic     in_valid_i,         // blocker
  output logic     in_ready_o,
  input  tex_t     in_i,
  output logic     block_valid_o,      // the light is blocked
  input  logic     block_ready_i,
  output ray_id_t  block_id_o,
  output logic     job_valid_o,        // the shadow ray starts again
  input  logic     job_ready_i,
  output job_t     job_o
);
  localparam int unsigned B = THRU_BEATS;
  localparam int unsigned NUM_IDS = 2 ** RAY_ID_W;
  localparam int unsigned T_A_IN    = 0;
  localparam int unsigned T_A       = T_A_IN + LAT_MUL;
  localparam int unsigned T_KT_IN   = 1;                                      // x; the next beats y, z
  localparam int unsigned T_KT      = T_KT_IN + LAT_MUL;
  localparam int unsigned T_CUT     = T_A + LAT_CMP;
  localparam int unsigned T_REST    = T_CUT + LAT_ADD;
  localparam int unsigned T_TM_IN   = next_beat(0, T_CUT + 1, B);
  localparam int unsigned T_TM      = T_TM_IN + LAT_ADD;
  localparam int unsigned T_TR_IN   = next_beat(later(T_REST + 1, T_KT), 5, B);   // x; the last beats are y, z
  localparam int unsigned T_TR      = T_TR_IN + LAT_MUL;
  localparam int unsigned T_END     = T_TR + 2 + LAT_CMP;
  localparam int unsigned SLOTS     = T_END / B + 1;                          // blockers in the pipeline

  // ---- time, as in rc_hitpoint; the light's number arrives in slot 0 -------------------------------------------------
  typedef struct packed {ray_id_t id; light_id_t light;} slot_t;
  logic  [B-1:0]     beat_q;
  logic  [SLOTS-1:0] valid_q;
  slot_t [SLOTS-1:0] slot_q;               // [0]: only id
  tex_t              in_q;
  logic              accept, at_end, is_x, is_y;
  light_id_t         light;
  slot_t             slot_end;
  assign in_ready_o = beat_q[B-1];
  assign accept     = in_valid_i && in_ready_o;
  assign at_end     = valid_q[SLOTS-1] && beat_q[T_END % B];
  assign slot_end   = slot_q[SLOTS-1];
  assign {is_y, is_x} = {beat_q[T_KT_IN + 1], beat_q[T_KT_IN]};
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      beat_q  <= B'(1);
      valid_q <= '0;
    end else begin
      beat_q <= {beat_q[B-2:0], beat_q[B-1]};
      if (beat_q[B-1]) valid_q <= {valid_q[SLOTS-2:0], accept};
    end
    if (beat_q[B-1]) begin
      in_q            <= in_i;
      slot_q          <= {slot_q[SLOTS-2:0], slot_q[0]};
      slot_q[0].id    <= in_i.hit.id;
      slot_q[1].light <= light;
    end
  end

  // ---- memories; a ray index is in one place at a time ------------------------------------------------------------------
  typedef struct packed {alpha_e mode; logic transmits; fp_t cutoff; fp_t alpha;} rule_t;
  material_t          ld_mat;
  optics_t            ld_opt;
  rule_t              rule;
  vec3_t              kt, tr_kept, tr_in, tr_read, tr_end;
  logic [NUM_IDS-1:0] partial_q;           // something was in the way of this light
  logic               partial_in_q, partial_read_q;
  assign ld_mat  = ld_line_i;
  assign ld_opt  = ld_line_i;
  assign tr_in   = partial_in_q ? tr_kept : {3{FP_ONE}};
  assign tr_o    = partial_read_q ? tr_read : {3{FP_ONE}};
  rc_ram_1r1w #(.Width($bits(rule_t)), .Depth(MAX_MATERIALS)) u_rules (
    .clk_i, .we_i(ld_mat_valid_i), .waddr_i(ld_idx_i),
    .wdata_i({ld_mat.flags.alpha_mode, ld_mat.flags.transmits, ld_mat.cutoff, ld_mat.alpha}),
    .re_i(accept), .raddr_i(mat_id_t'(in_i.hit.mat)), .rdata_o(rule)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(MAX_MATERIALS)) u_kt (
    .clk_i, .we_i(ld_opt_valid_i), .waddr_i(ld_idx_i), .wdata_i({ld_opt.kt_b, ld_opt.kt_g, ld_opt.kt_r}),
    .re_i(accept), .raddr_i(mat_id_t'(in_i.hit.mat)), .rdata_o(kt)
  );
  rc_ram_1r1w #(.Width($bits(light_id_t)), .Depth(NUM_IDS)) u_light (
    .clk_i, .we_i(k_valid_i), .waddr_i(k_job_i.id), .wdata_i(k_job_i.light),
    .re_i(accept), .raddr_i(in_i.hit.id), .rdata_o(light)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(NUM_IDS)) u_tr_in (      // twice, for two readers
    .clk_i, .we_i(at_end), .waddr_i(slot_end.id), .wdata_i(tr_end),
    .re_i(accept), .raddr_i(in_i.hit.id), .rdata_o(tr_kept)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(NUM_IDS)) u_tr_out (
    .clk_i, .we_i(at_end), .waddr_i(slot_end.id), .wdata_i(tr_end),
    .re_i(tr_re_i), .raddr_i(tr_id_i), .rdata_o(tr_read)
  );
  always_ff @(posedge clk_i) begin
    if (accept)  partial_in_q   <= partial_q[in_i.hit.id];
    if (tr_re_i) partial_read_q <= partial_q[tr_id_i];
    if (!rst_ni) begin
      partial_q <= '0;
    end else begin
      if (start_i) partial_q[start_id_i]  <= 1'b0;
      if (at_end)  partial_q[slot_end.id] <= 1'b1;
    end
  end

  // ---- the one multiplier: alpha a; kt tex; tr tau --------------------------------------------------------------------
  logic       now_tr, transmits_tr, cut_lt, cmp_eq, cmp_gt;
  fp_t        mul_a, mul_b, mul_y, tau_tr, tr_tr, rest_tr, a_cut, cutoff_a, alpha_cut;
  fp_t        add_a, add_b, add_y, t_end;
  logic [1:0] mode_cut;
  assign now_tr = beat_q[T_TR_IN % B] || beat_q[(T_TR_IN + 1) % B] || beat_q[(T_TR_IN + 2) % B];
  always_comb begin
    {mul_b, mul_a} = {component(in_q.rgb, is_x, is_y), component(kt, is_x, is_y)};
    if (beat_q[T_A_IN % B]) {mul_b, mul_a} = {in_q.a, rule.alpha};
    if (now_tr) {mul_b, mul_a} = {transmits_tr ? tau_tr : rest_tr, tr_tr};
  end
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul (.clk_i, .a_i(mul_a), .b_i(mul_b), .y_o(mul_y));
  rc_carry #(.From(T_KT), .To(T_TR_IN)) u_tau_tr (.clk_i, .in_i(mul_y), .out_o(tau_tr));
  rc_carry #(.From(T_KT_IN), .To(T_TR_IN)) u_tr_tr (.clk_i, .in_i(component(tr_in, is_x, is_y)), .out_o(tr_tr));
  rc_spread #(.Width(1), .Beats(B), .From(0), .To(T_TR_IN)) u_transmits_tr (
    .clk_i, .beat_i(beat_q), .in_i(rule.transmits), .out_o(transmits_tr)
  );

  // ---- the one adder: 1 - alpha'; t + T_MIN -----------------------------------------------------------------------------
  rc_carry #(.From(T_A), .To(T_CUT)) u_a_cut (.clk_i, .in_i(mul_y), .out_o(a_cut));
  rc_hold #(.Width($bits(alpha_e)), .Beats(B), .From(0), .To(T_CUT)) u_mode_cut (
    .clk_i, .now_i(beat_q[0]), .in_i(rule.mode), .out_o(mode_cut)
  );
  assign alpha_cut = coverage(alpha_e'(mode_cut), cmp_eq || cmp_gt, a_cut);
  assign add_a     = beat_q[T_TM_IN] ? in_q.hit.t : FP_ONE;
  assign add_b     = beat_q[T_TM_IN] ? T_MIN : fp_neg(alpha_cut);
  rc_fp_add #(.Latency(LAT_ADD)) u_add (.clk_i, .a_i(add_a), .b_i(add_b), .y_o(add_y));
  rc_spread #(.Beats(B), .From(T_REST), .To(T_TR_IN)) u_rest_tr (
    .clk_i, .beat_i(beat_q), .in_i(add_y), .out_o(rest_tr)
  );
  rc_hold #(.Beats(B), .From(T_TM), .To(T_END)) u_t_end (
    .clk_i, .now_i(beat_q[T_TM % B]), .in_i(add_y), .out_o(t_end)
  );

  // ---- the one comparator: alpha a with the cutoff; transmittance with what is worth a ray ----------------------------
  logic [1:0] worth_q;
  logic       worth;
  rc_hold #(.Beats(B), .From(0), .To(T_A)) u_cutoff_a (
    .clk_i, .now_i(beat_q[0]), .in_i(rule.cutoff), .out_o(cutoff_a)
  );
  rc_fp_cmp #(.Latency(LAT_CMP)) u_cmp (
    .clk_i, .a_i(mul_y), .b_i(beat_q[T_A % B] ? cutoff_a : min_weight_i), .lt_o(cut_lt), .eq_o(cmp_eq), .gt_o(cmp_gt)
  );
  rc_gather #(.From(T_TR), .To(T_END)) u_tr_end (.clk_i, .in_i(mul_y), .vec_o(tr_end));
  always_ff @(posedge clk_i) worth_q <= {worth_q[0], cmp_gt};
  assign worth = cmp_gt || worth_q != '0;

  // ---- the end ------------------------------------------------------------------------------------------------------------
  job_t       again;
  logic [1:0] room;
  logic [1:0][$clog2(NUM_IDS + 1)-1:0] unused_count;
  assign again = '{id: slot_end.id, light: slot_end.light, t_min: fp_up16(t_end)};
  rc_fifo #(.data_t(ray_id_t), .Depth(NUM_IDS)) u_blocks (
    .clk_i, .rst_ni,
    .in_valid_i(at_end && !worth), .in_ready_o(room[0]), .in_data_i(slot_end.id),
    .out_valid_o(block_valid_o), .out_ready_i(block_ready_i), .out_data_o(block_id_o), .count_o(unused_count[0])
  );
  rc_fifo #(.data_t(job_t), .Depth(NUM_IDS)) u_again (
    .clk_i, .rst_ni,
    .in_valid_i(at_end && worth), .in_ready_o(room[1]), .in_data_i(again),
    .out_valid_o(job_valid_o), .out_ready_i(job_ready_i), .out_data_o(job_o), .count_o(unused_count[1])
  );

  if (T_TR_IN % B != 5 || T_TM_IN % B == T_CUT % B || T_TM_IN >= B) begin : gen_check
    $error("rc_through: two operations in one beat of a unit");
  end
  logic unused_in;
  assign unused_in = ^{ld_mat, ld_opt, k_job_i.t_min, in_q.hit, cut_lt};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      OneBeat_A: assert ($onehot(beat_q));
      Room_A:    assert (!at_end || (worth ? room[1] : room[0]));
      if (accept) IsBlocker_M: assume (in_i.hit.hit && in_i.hit.any_hit && !in_i.hit.opaque);
    end
  end
`else
  logic unused_room;
  assign unused_room = &room;
`endif
endmodule
