// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Ray generation (paper Sec. 3.3): makes primary rays from pixels, and gives all others their 1/d. One ray in four
// cycles; a ray from the shading unit, when there is one, goes first, so that unit always drains.
//
// Component-serial: a ray uses a functional unit in three consecutive cycles for x, y, z, and the fourth is left for a
// scalar. So one TFadd serves v and |v|^2, one Fdiv serves 1/|v| and 1/d (modulo schedule, initiation interval 4; the
// paper spends 3 Fadd, 2 TFadd, 6 Fmul). Times T_x count cycles from a ray's first, and are fixed at elaboration:
//   T_CONV   px, py = x + 1/2, y + 1/2         two beats
//   T_MUL    px u_i, py v_i
//   T_V      v_i = c_i + px u_i + py v_i
//   T_SQ     v_i v_i
//   T_LEN    |v|^2                              scalar beat of T_V's unit
//   T_SQRT   |v|
//   T_INV    1 / |v|                            scalar beat of T_IDIR's unit
//   T_DIR    d_i = v_i / |v|
//   T_IDIR   1 / d_i                            d_i that the shading unit made comes in here
//   T_OUT    last component of 1 / d
// The pipeline never stalls: a ray enters only if the queue of contexts has room, and each ray in the pipeline or in
// the other two queues has its entry there. docs/raygen.md shows the schedule as a table.
module rc_raygen import rc_pkg::*; (
  input  logic    clk_i,
  input  logic    rst_ni,
  input  camera_t cam_i,                      // constant while a frame runs
  input  logic    pri_valid_i,
  output logic    pri_ready_o,
  input  pri_t    pri_i,
  input  logic    sec_valid_i,
  output logic    sec_ready_o,
  input  sec_t    sec_i,
  output logic    ray_valid_o,
  input  logic    ray_ready_i,
  output ray_t    ray_o,
  output pipe_id_t  ray_home_o,              // pipeline it prefers: the same for all rays of a block of 8x8 pixels
  output logic      path_ray_valid_o,         // a ray that is no shadow ray, when it leaves
  output path_ray_t path_ray_o
);
  localparam int unsigned BEATS = 4;          // x, y, z, scalar

  // The first cycle from `earliest` on that is the same beat as `like`.
  function automatic int unsigned next_beat(int unsigned earliest, int unsigned like);
    return earliest + ((like + BEATS - earliest % BEATS) % BEATS);
  endfunction

  localparam int unsigned T_CONV = 0;
  localparam int unsigned T_MUL  = T_CONV + LAT_CONV + 2;               // both held in registers
  localparam int unsigned T_V    = T_MUL + LAT_MUL;
  localparam int unsigned T_SQ   = T_V + LAT_ADD3;
  localparam int unsigned T_LEN  = next_beat(T_SQ + LAT_MUL + 2, T_V + 3);
  localparam int unsigned T_SQRT = T_LEN + LAT_ADD3;
  localparam int unsigned T_INV  = T_SQRT + LAT_SQRT;
  localparam int unsigned T_DIR  = T_INV + LAT_DIV + 1;                 // 1/|v| held in a register
  localparam int unsigned T_IDIR = next_beat(T_DIR + LAT_MUL, T_INV + 1);
  localparam int unsigned T_OUT  = T_IDIR + LAT_DIV + 2;
  localparam int unsigned SLOTS  = T_OUT / BEATS + 1;                   // rays in the pipeline
  // Room for these, for one that enters or leaves, and for two while the T&I unit hesitates.
  localparam int unsigned DEPTH  = 2 ** $clog2(SLOTS + 4);

  if (T_LEN % BEATS != (T_V + 3) % BEATS) begin : gen_check_len
    $error("rc_raygen: |v|^2 is not in the scalar beat of its adder");
  end
  if (T_INV % BEATS != (T_IDIR + 3) % BEATS) begin : gen_check_inv
    $error("rc_raygen: 1/|v| is not in the scalar beat of its divider");
  end

  function automatic fp_t component(vec3_t v, logic [1:0] beat);
    return (beat == 2'd0) ? v[0] : (beat == 2'd1) ? v[1] : v[2];
  endfunction

  // ---- time: beat_q is 0 in a ray's first cycle; slot_q[k] is the ray in its cycles 4k to 4k + 3 ----------------
  typedef struct packed {logic valid; logic sec;} slot_t;
  logic [1:0]        beat_q;
  slot_t [SLOTS-1:0] slot_q;
  logic              accept;

  function automatic logic [1:0] beat_of(int unsigned start);           // 0, 1, 2: x, y, z of what starts then
    return 2'((32'(beat_q) + BEATS - start % BEATS) % BEATS);
  endfunction

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      beat_q <= '0;
      slot_q <= '0;
    end else begin
      beat_q <= beat_q + 2'd1;
      if (beat_q == 2'd3) slot_q <= {slot_q[SLOTS-2:0], slot_t'{valid: accept, sec: sec_valid_i}};
    end
  end

  // ---- entry: secondary rays first (paper Sec. 3.3: else a circular wait could lock the ring) ---------------------
  typedef struct packed {
    ray_id_t id;
    logic    any_hit;
    logic    primary;
    surf_t   skip;
    fp_t     t_min;
    fp_t     t_max;
    vec3_t   org;
  } ctx_t;
  ctx_t ctx_in, ctx_out;
  logic ctx_in_ready, ctx_out_valid, leave;
  logic [3:0][$clog2(DEPTH + 1)-1:0] unused_count;
  assign sec_ready_o = beat_q == 2'd3 && ctx_in_ready;
  assign pri_ready_o = sec_ready_o && !sec_valid_i;
  assign accept      = sec_ready_o && (sec_valid_i || pri_valid_i);
  assign ctx_in = sec_valid_i ? '{id: sec_i.id, any_hit: sec_i.kind == RAY_SHADOW, primary: 1'b0, skip: sec_i.skip,
                                  t_min: sec_i.t_min, t_max: sec_i.t_max, org: sec_i.org}
                              : '{id: pri_i.id, any_hit: 1'b0, primary: 1'b1, skip: SURF_NONE,
                                  t_min: T_MIN, t_max: FP_HUGE, org: cam_i.org};
  rc_fifo #(.data_t(ctx_t), .Depth(DEPTH)) u_ctx (
    .clk_i, .rst_ni,
    .in_valid_i(accept), .in_ready_o(ctx_in_ready), .in_data_i(ctx_in),
    .out_valid_o(ctx_out_valid), .out_ready_i(leave), .out_data_o(ctx_out),
    .count_o(unused_count[0])
  );

  logic [15:0] x_q, y_q;

  // Directions that the shading unit made wait here until they are due at the divider.
  vec3_t sec_dir;
  logic  sec_dir_ready, sec_dir_valid, sec_due;
  rc_fifo #(.data_t(vec3_t), .Depth(DEPTH)) u_sec_dir (
    .clk_i, .rst_ni,
    .in_valid_i(accept && sec_valid_i), .in_ready_o(sec_dir_ready), .in_data_i(sec_i.dir),
    .out_valid_o(sec_dir_valid), .out_ready_i(sec_due && beat_of(T_IDIR) == 2'd2), .out_data_o(sec_dir),
    .count_o(unused_count[1])
  );
  // The place of its pixel's block in its tile is the pipeline that a ray prefers.
  pipe_id_t home;
  logic     home_ready, home_valid;
  rc_ram_1r1w #(.Width($bits(pipe_id_t)), .Depth(2 ** RAY_ID_W)) u_home (
    .clk_i, .we_i(accept && !sec_valid_i), .waddr_i(pri_i.id), .wdata_i({pri_i.y[3], pri_i.x[3]}),
    .re_i(accept && sec_valid_i), .raddr_i(sec_i.id), .rdata_o(home)
  );
  rc_fifo #(.data_t(pipe_id_t), .Depth(DEPTH)) u_homes (
    .clk_i, .rst_ni,
    .in_valid_i(slot_q[0].valid && beat_q == 2'd0), .in_ready_o(home_ready),
    .in_data_i(slot_q[0].sec ? home : {y_q[3], x_q[3]}),
    .out_valid_o(home_valid), .out_ready_i(leave), .out_data_o(ray_home_o), .count_o(unused_count[3])
  );
  logic unused_sec;
  assign unused_sec = ^{sec_i.light, sec_i.depth};

  // ---- pixel to px, py ------------------------------------------------------------------------------------------
  fp_t         conv, px_q, py_q;
  always_ff @(posedge clk_i) begin
    if (beat_q == 2'd3) {x_q, y_q} <= {pri_i.x, pri_i.y};
    if (beat_of(T_CONV + LAT_CONV) == 2'd0) px_q <= conv;
    if (beat_of(T_CONV + LAT_CONV) == 2'd1) py_q <= conv;
  end
  // x + 1/2 is exact: it has 17 significant bits.
  rc_fp_from_int #(
    .ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_CONV), .IntW(17), .FracW(1), .Signed(1'b0)
  ) u_conv (.clk_i, .int_i({beat_of(T_CONV) == 2'd0 ? x_q : y_q, 1'b1}), .y_o(conv));

  // ---- v, |v|^2, 1 / |v| ------------------------------------------------------------------------------------------
  fp_t pu, pv, sum3, sq, inv_len_q, v_late, dir_pri, len, quot;
  fp_t sq_x_q, sq_y_q, sq_z;
  rc_fp_mul #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_MUL)) u_mul_u (
    .clk_i, .a_i(px_q), .b_i(component(cam_i.u, beat_of(T_MUL))), .y_o(pu)
  );
  rc_fp_mul #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_MUL)) u_mul_v (
    .clk_i, .a_i(py_q), .b_i(component(cam_i.v, beat_of(T_MUL))), .y_o(pv)
  );
  // Three cycles of a delayed stream side by side are its x, y and z.
  rc_delay #(.Width(FP_W), .Depth(T_LEN - T_SQ - LAT_MUL - 2)) u_sq_z (.clk_i, .in_i(sq), .out_o(sq_z));
  always_ff @(posedge clk_i) {sq_x_q, sq_y_q} <= {sq_y_q, sq_z};
  logic v_beat;
  assign v_beat = beat_of(T_V) != 2'd3;
  rc_fp_add3 #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_ADD3)) u_add3 (
    .clk_i,
    .a_i(v_beat ? component(cam_i.c, beat_of(T_V)) : sq_x_q),
    .b_i(v_beat ? pu : sq_y_q),
    .c_i(v_beat ? pv : sq_z),
    .y_o(sum3)
  );
  rc_fp_mul #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_MUL)) u_mul_sq (.clk_i, .a_i(sum3), .b_i(sum3), .y_o(sq));
  rc_fp_sqrt #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_SQRT)) u_sqrt (.clk_i, .a_i(sum3), .y_o(len));
  always_ff @(posedge clk_i) if (beat_of(T_INV + LAT_DIV) == 2'd0) inv_len_q <= quot;

  // ---- d and 1 / d --------------------------------------------------------------------------------------------------
  fp_t dir_mul, dir_ser, dir_x_q, dir_y_q, dir_z, inv_x_q, inv_y_q, inv_z;
  rc_delay #(.Width(FP_W), .Depth(T_DIR - T_SQ)) u_v_late (.clk_i, .in_i(sum3), .out_o(v_late));
  rc_fp_mul #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_MUL)) u_mul_dir (
    .clk_i, .a_i(v_late), .b_i(inv_len_q), .y_o(dir_mul)
  );
  rc_delay #(.Width(FP_W), .Depth(T_IDIR - T_DIR - LAT_MUL)) u_dir_pri (.clk_i, .in_i(dir_mul), .out_o(dir_pri));

  // The ray whose x, y or z is at the divider; it may be one slot further on for the later ones.
  slot_t idir_slot;
  always_comb begin
    unique case (beat_of(T_IDIR))
      2'd0:    idir_slot = slot_q[T_IDIR/BEATS];
      2'd1:    idir_slot = slot_q[(T_IDIR+1)/BEATS];
      default: idir_slot = slot_q[(T_IDIR+2)/BEATS];
    endcase
  end
  assign sec_due = idir_slot.valid && idir_slot.sec;
  assign dir_ser = sec_due ? component(sec_dir, beat_of(T_IDIR)) : dir_pri;
  rc_fp_div #(.ExpW(FP_EXP_W), .ManW(FP_MAN_W), .Latency(LAT_DIV)) u_div (
    .clk_i, .a_i(FP_ONE), .b_i(beat_of(T_IDIR) == 2'd3 ? len : dir_ser), .y_o(quot)
  );
  assign inv_z = fp_inverse(quot);
  rc_delay #(.Width(FP_W), .Depth(LAT_DIV)) u_dir_z (.clk_i, .in_i(dir_ser), .out_o(dir_z));
  always_ff @(posedge clk_i) begin
    {dir_x_q, dir_y_q} <= {dir_y_q, dir_z};
    {inv_x_q, inv_y_q} <= {inv_y_q, inv_z};
  end

  // ---- exit -----------------------------------------------------------------------------------------------------------
  typedef struct packed {vec3_t inv_dir; vec3_t dir;} vectors_t;
  vectors_t vec_in, vec_out;
  logic     vec_push, vec_ready, vec_valid;
  assign vec_in   = '{inv_dir: {inv_z, inv_y_q, inv_x_q}, dir: {dir_z, dir_y_q, dir_x_q}};
  assign vec_push = slot_q[T_OUT/BEATS].valid && beat_of(T_OUT) == 2'd0;
  rc_fifo #(.data_t(vectors_t), .Depth(DEPTH)) u_vec (
    .clk_i, .rst_ni,
    .in_valid_i(vec_push), .in_ready_o(vec_ready), .in_data_i(vec_in),
    .out_valid_o(vec_valid), .out_ready_i(leave), .out_data_o(vec_out),
    .count_o(unused_count[2])
  );
  assign leave       = ray_valid_o && ray_ready_i;
  assign ray_valid_o = vec_valid;
  assign ray_o = '{id: ctx_out.id, any_hit: ctx_out.any_hit, skip: ctx_out.skip, t_min: ctx_out.t_min,
                   t_max: ctx_out.t_max, inv_dir: vec_out.inv_dir, dir: vec_out.dir, org: ctx_out.org};
  assign path_ray_valid_o = leave && !ctx_out.any_hit;
  assign path_ray_o = '{id: ctx_out.id, primary: ctx_out.primary, dir: vec_out.dir, org: ctx_out.org};

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      VecRoom_A: assert (!vec_push || vec_ready);
      SecDirRoom_A: assert (!(accept && sec_valid_i) || sec_dir_ready);
      SecDirThere_A: assert (!sec_due || beat_of(T_IDIR) == 2'd3 || sec_dir_valid);
      CtxThere_A: assert (!vec_valid || (ctx_out_valid && home_valid));
      HomeRoom_A: assert (!slot_q[0].valid || beat_q != 2'd0 || home_ready);
      SecFirst_A: assert (!(pri_valid_i && pri_ready_o && sec_valid_i));
    end
    if (rst_ni && $past(rst_ni && pri_valid_i && !pri_ready_o)) PriHeld_M: assume (pri_valid_i && $stable(pri_i));
    if (rst_ni && $past(rst_ni && sec_valid_i && !sec_ready_o)) SecHeld_M: assume (sec_valid_i && $stable(sec_i));
    if (rst_ni && $past(rst_ni && ray_valid_o && !ray_ready_i)) RayHeld_A: assert (ray_valid_o && $stable(ray_o));
  end
`endif
endmodule
