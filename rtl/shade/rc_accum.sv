// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Shading buffer (paper Sec. 3.6): the colour of every pixel under way, by ray index, and what waits to be added to it, and the
// decision what comes next for an index: another light, a bounce, a ray from the pixel's stack, or the end. One update in three
// cycles, component-serial (rc_shade_pkg), x, y, z being red, green, blue; formulas in docs/whitted.md:
//   T_IN   factors   T_M   amb tex, w alpha', wl tr   T_E   emis + amb tex   T_V  what is added   T_SUM  colour   T_END  all of it
// It waits for the taker of finished pixels and for nothing else: the queue of lights has a place for every index, and so has
// the queue of bounces in rc_secondary.
module rc_accum import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  input  vec3_t                   background_i,
  input  logic [4:0]              light_count_i,
  input  logic                    ld_mat_valid_i,   // before a frame
  input  mat_id_t                 ld_idx_i,
  input  line_t                   ld_line_i,
  input  logic                    k_valid_i,        // what a light would add; its update comes later
  input  job_t                    k_job_i,
  input  vec3_t                   k_i,
  input  logic                    upd_valid_i,
  output logic                    upd_ready_o,
  input  upd_t                    upd_i,
  output logic                    taken_o,          // an update was taken: then come for three cycles, of its index,
  output ray_id_t                 taken_id_o,
  input  vec3_t                   w_i,              //   the weight of the ray that came,
  input  logic                    first_i,          //   whether that is a primary ray,
  input  vec3_t                   tr_i,             //   and the transmittance of the light
  input  logic [2**RAY_ID_W-1:0]  pending_i,        // there are rays on the pixel's stack
  output logic                    start_o,          // the next light of an index starts
  output ray_id_t                 start_id_o,
  output logic                    job_valid_o,
  input  logic                    job_ready_i,
  output job_t                    job_o,
  output logic                    bounce_valid_o,   // always taken
  output bounce_t                 bounce_o,
  output logic                    done_valid_o,
  input  logic                    done_ready_i,
  output done_t                   done_o
);
  localparam int unsigned B = ACC_BEATS;
  localparam int unsigned NUM_IDS = 2 ** RAY_ID_W;
  localparam int unsigned T_IN  = 0;
  localparam int unsigned T_M   = T_IN + LAT_MUL;
  localparam int unsigned T_E   = T_M + LAT_ADD;
  localparam int unsigned T_V   = T_E + LAT_MUL;
  localparam int unsigned T_SUM = T_V + LAT_ADD;
  localparam int unsigned T_END = T_SUM + 2;
  localparam int unsigned SLOTS = T_END / B + 1;              // updates in the pipeline
  localparam int unsigned ROOM  = 2 ** $clog2(SLOTS + 2);     // and pixels that wait to leave
  typedef logic [$clog2(ROOM + 1)-1:0] room_t;

  // ---- time, as in rc_light; what was kept of the surface arrives with the index in slot 0 --------------------------
  typedef struct packed {logic bounces; logic branch;} next_t;
  typedef struct packed {ray_id_t id; upd_e kind; light_id_t light; next_t next;} slot_t;
  logic  [B-1:0]     beat_q;
  logic  [SLOTS-1:0] valid_q;
  slot_t [SLOTS-1:0] slot_q;               // [0]: only id and kind
  upd_t              upd_q;
  room_t             room_q;
  logic              accept, at_end, finish, done_pop;
  slot_t             slot_end;
  light_id_t         light;
  next_t             next_new, next_kept;
  assign upd_ready_o = beat_q[B-1] && room_q != '0;
  assign accept      = upd_valid_i && upd_ready_o;
  assign taken_o     = accept;
  assign taken_id_o  = upd_i.point.id;
  assign next_new    = '{bounces: upd_q.point.bounces, branch: upd_q.point.branch};
  assign done_pop    = done_valid_o && done_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      beat_q  <= B'(1);
      valid_q <= '0;
      room_q  <= room_t'(ROOM);
    end else begin
      beat_q <= {beat_q[B-2:0], beat_q[B-1]};
      if (beat_q[B-1]) valid_q <= {valid_q[SLOTS-2:0], accept};
      room_q <= room_q - room_t'(accept) + room_t'(at_end && !finish) + room_t'(done_pop);
    end
    if (beat_q[B-1]) begin
      upd_q           <= upd_i;
      slot_q          <= {slot_q[SLOTS-2:0], slot_q[0]};
      slot_q[0].id    <= upd_i.point.id;
      slot_q[0].kind  <= upd_i.kind;
      slot_q[1].light <= light;
      slot_q[1].next  <= (upd_q.kind == UPD_SURFACE) ? next_new : next_kept;
    end
  end

  // ---- memories: a ray index is in one place at a time, so that reads and writes never meet ----------------------------
  material_t ld_mat;
  logic      is_surface, is_miss, adds, write_end;
  vec3_t     acc, ambient, emission, k, wl, wl_end, sum;
  assign ld_mat     = ld_line_i;
  assign is_surface = upd_q.kind == UPD_SURFACE;
  assign is_miss    = upd_q.kind == UPD_MISS;
  assign adds       = is_surface || is_miss || (upd_q.kind == UPD_LIGHT && upd_q.add);
  assign write_end  = at_end && slot_end.kind == UPD_SURFACE;
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(NUM_IDS)) u_acc (
    .clk_i, .we_i(at_end && !finish), .waddr_i(slot_end.id), .wdata_i(sum),
    .re_i(accept), .raddr_i(upd_i.point.id), .rdata_o(acc)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t) + $bits(light_id_t)), .Depth(NUM_IDS)) u_k (
    .clk_i, .we_i(k_valid_i), .waddr_i(k_job_i.id), .wdata_i({k_job_i.light, k_i}),
    .re_i(accept), .raddr_i(upd_i.point.id), .rdata_o({light, k})
  );
  rc_ram_1r1w #(.Width($bits(vec3_t) + $bits(next_t)), .Depth(NUM_IDS)) u_wl (
    .clk_i, .we_i(write_end), .waddr_i(slot_end.id), .wdata_i({slot_end.next, wl_end}),
    .re_i(accept), .raddr_i(upd_i.point.id), .rdata_o({next_kept, wl})
  );
  rc_ram_1r1w #(.Width(2 * $bits(vec3_t)), .Depth(MAX_MATERIALS)) u_glow (
    .clk_i, .we_i(ld_mat_valid_i), .waddr_i(ld_idx_i),
    .wdata_i({ld_mat.emis_b, ld_mat.emis_g, ld_mat.emis_r, ld_mat.amb_b, ld_mat.amb_g, ld_mat.amb_r}),
    .re_i(accept && upd_i.kind == UPD_SURFACE), .raddr_i(upd_i.point.mat), .rdata_o({emission, ambient})
  );

  // ---- what is added: of a surface wl (emis + amb tex), of a light (wl tr) k, of a miss w background -------------------
  logic is_x, is_y, surface_m, light_m, surface_e, add_sum;
  fp_t  mul_a, mul_b, mul_y, wl_m, wl_a, emis_m, glow_e, other_in, other_e, factor_m, factor_e, added;
  fp_t  acc_in, acc_v, acc_sum, sum_v, sum_axis;
  assign {is_y, is_x} = {beat_q[(T_IN + 1) % B], beat_q[T_IN % B]};
  assign mul_a    = component(is_surface ? ambient : wl, is_x, is_y);
  assign mul_b    = component(is_surface ? upd_q.point.tex : tr_i, is_x, is_y);
  assign wl_a     = is_surface ? upd_q.point.alpha : FP_ONE;       // of a miss, w itself
  assign other_in = component(is_miss ? background_i : k, is_x, is_y);
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_m (.clk_i, .a_i(mul_a), .b_i(mul_b), .y_o(mul_y));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_wl (.clk_i, .a_i(component(w_i, is_x, is_y)), .b_i(wl_a), .y_o(wl_m));
  rc_carry #(.From(T_IN), .To(T_M)) u_emis_m (.clk_i, .in_i(component(emission, is_x, is_y)), .out_o(emis_m));
  rc_fp_add #(.Latency(LAT_ADD)) u_add_e (.clk_i, .a_i(emis_m), .b_i(mul_y), .y_o(glow_e));
  rc_carry #(.Width(2), .From(T_IN), .To(T_M)) u_kind_m (
    .clk_i, .in_i({is_surface, !is_surface && !is_miss}), .out_o({surface_m, light_m})
  );
  assign factor_m = light_m ? mul_y : wl_m;
  rc_carry #(.Width(1 + FP_W), .From(T_M), .To(T_E)) u_factor_e (
    .clk_i, .in_i({surface_m, factor_m}), .out_o({surface_e, factor_e})
  );
  rc_carry #(.From(T_IN), .To(T_E)) u_other_e (.clk_i, .in_i(other_in), .out_o(other_e));
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul_v (
    .clk_i, .a_i(factor_e), .b_i(surface_e ? glow_e : other_e), .y_o(added)
  );

  // ---- colour -----------------------------------------------------------------------------------------------------------
  assign acc_in = (is_surface || is_miss) && first_i ? FP_ZERO : component(acc, is_x, is_y);
  rc_carry #(.From(T_IN), .To(T_V)) u_acc_v (.clk_i, .in_i(acc_in), .out_o(acc_v));
  rc_fp_add #(.Latency(LAT_ADD)) u_add (.clk_i, .a_i(acc_v), .b_i(added), .y_o(sum_v));
  rc_carry #(.From(T_V), .To(T_SUM)) u_acc_sum (.clk_i, .in_i(acc_v), .out_o(acc_sum));
  rc_carry #(.Width(1), .From(T_IN), .To(T_SUM)) u_adds_sum (.clk_i, .in_i(adds), .out_o(add_sum));
  assign sum_axis = add_sum ? sum_v : acc_sum;
  rc_gather #(.From(T_SUM), .To(T_END)) u_sum (.clk_i, .in_i(sum_axis), .vec_o(sum));
  rc_gather #(.From(T_M), .To(T_END)) u_wl_end (.clk_i, .in_i(wl_m), .vec_o(wl_end));

  // ---- what comes next ----------------------------------------------------------------------------------------------------
  typedef struct packed {ray_id_t id; light_id_t light;} light_job_t;
  logic       over, more_lights, bounces, job_in_ready, done_in_ready;
  logic [4:0] next_light;
  light_job_t job_in, job_out;
  done_t      done_in;
  logic [$clog2(NUM_IDS + 1)-1:0] unused_jobs;
  logic [$clog2(ROOM + 1)-1:0]    unused_dones;
  assign slot_end       = slot_q[SLOTS-1];
  assign at_end         = valid_q[SLOTS-1] && beat_q[T_END % B];
  assign next_light     = (slot_end.kind == UPD_LIGHT) ? {1'b0, slot_end.light} + 5'd1 : '0;
  assign over           = slot_end.kind == UPD_MISS || slot_end.kind == UPD_END;
  assign more_lights    = !over && next_light < light_count_i;
  assign bounces        = !over && !more_lights && slot_end.next.bounces;
  assign finish         = at_end && !more_lights && !bounces && !pending_i[slot_end.id];
  assign start_o        = at_end && more_lights;
  assign start_id_o     = slot_end.id;
  assign bounce_valid_o = at_end && !more_lights && !finish;
  assign bounce_o       = '{id: slot_end.id, pop: !bounces, branch: slot_end.next.branch};
  assign job_in         = '{id: slot_end.id, light: light_id_t'(next_light)};
  assign job_o          = '{id: job_out.id, light: job_out.light, t_min: T_MIN};
  assign done_in        = '{id: slot_end.id, rgb: sum};
  rc_fifo #(.data_t(light_job_t), .Depth(NUM_IDS)) u_jobs (
    .clk_i, .rst_ni,
    .in_valid_i(start_o), .in_ready_o(job_in_ready), .in_data_i(job_in),
    .out_valid_o(job_valid_o), .out_ready_i(job_ready_i), .out_data_o(job_out), .count_o(unused_jobs)
  );
  rc_fifo #(.data_t(done_t), .Depth(ROOM)) u_done (
    .clk_i, .rst_ni,
    .in_valid_i(finish), .in_ready_o(done_in_ready), .in_data_i(done_in),
    .out_valid_o(done_valid_o), .out_ready_i(done_ready_i), .out_data_o(done_o), .count_o(unused_dones)
  );

  logic unused_ld;
  assign unused_ld = ^{ld_mat, k_job_i.t_min, upd_q.point};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      OneBeat_A:  assert ($onehot(beat_q));
      Room_A:     assert (room_q <= room_t'(ROOM));
      JobRoom_A:  assert (!start_o || job_in_ready);
      DoneRoom_A: assert (!finish || done_in_ready);
    end
  end
`else
  logic unused_ready;
  assign unused_ready = job_in_ready && done_in_ready;
`endif
endmodule
