// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Shading buffer (paper Sec. 3.6): the colour of every ray index and what waits to be added to it, and the decision what comes
// next for an index: another light, or the end. One update in three cycles, component-serial (rc_shade_pkg), x, y, z being
// red, green, blue:
//   T_IN    colour so far, by kind of update       T_SUM   plus k if the light is visible       T_END   all of it
// It waits for the taker of finished pixels and for nothing else: the queue of jobs has a place for every index.
module rc_accum import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  vec3_t      background_i,
  input  logic [4:0] light_count_i,
  input  logic       ld_mat_valid_i,   // before a frame
  input  mat_id_t    ld_idx_i,
  input  line_t      ld_line_i,
  input  logic       k_valid_i,        // what a light would add; its update comes later
  input  job_t       k_job_i,
  input  vec3_t      k_i,
  input  logic       upd_valid_i,
  output logic       upd_ready_o,
  input  upd_t       upd_i,
  output logic       job_valid_o,
  input  logic       job_ready_i,
  output job_t       job_o,
  output logic       done_valid_o,
  input  logic       done_ready_i,
  output done_t      done_o
);
  localparam int unsigned B = ACC_BEATS;
  localparam int unsigned NUM_IDS = 2 ** RAY_ID_W;
  localparam int unsigned T_IN  = 0;
  localparam int unsigned T_SUM = T_IN + LAT_ADD;
  localparam int unsigned T_END = T_SUM + 2;
  localparam int unsigned SLOTS = T_END / B + 1;              // updates in the pipeline
  localparam int unsigned ROOM  = 2 ** $clog2(SLOTS + 2);     // and pixels that wait to leave
  typedef logic [$clog2(ROOM + 1)-1:0] room_t;

  // ---- time, as in rc_light; the light's number arrives with k in slot 0 --------------------------------------------
  typedef struct packed {upd_t upd; light_id_t light;} slot_t;
  logic  [B-1:0]     beat_q;
  logic  [SLOTS-1:0] valid_q;
  slot_t [SLOTS-1:0] slot_q;
  room_t             room_q;
  logic              accept, finish, proceed, done_pop;
  slot_t             slot_end;
  light_id_t         light;
  assign upd_ready_o = beat_q[B-1] && room_q != '0;
  assign accept      = upd_valid_i && upd_ready_o;
  assign done_pop    = done_valid_o && done_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      beat_q  <= B'(1);
      valid_q <= '0;
      room_q  <= room_t'(ROOM);
    end else begin
      beat_q <= {beat_q[B-2:0], beat_q[B-1]};
      if (beat_q[B-1]) valid_q <= {valid_q[SLOTS-2:0], accept};
      room_q <= room_q - room_t'(accept) + room_t'(proceed) + room_t'(done_pop);
    end
    if (beat_q[B-1]) begin
      slot_q          <= {slot_q[SLOTS-2:0], slot_q[0]};
      slot_q[0].upd   <= upd_i;
      slot_q[1].light <= light;
    end
  end

  // ---- memories: a ray index is in one place at a time, so that reads and writes never meet ----------------------------
  material_t ld_mat;
  vec3_t     acc, ambient, k, sum;
  assign ld_mat = ld_line_i;
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(NUM_IDS)) u_acc (
    .clk_i, .we_i(proceed), .waddr_i(slot_end.upd.id), .wdata_i(sum),
    .re_i(accept && upd_i.kind == UPD_LIGHT), .raddr_i(upd_i.id), .rdata_o(acc)
  );
  rc_ram_1r1w #(.Width($bits(vec3_t) + $bits(light_id_t)), .Depth(NUM_IDS)) u_k (
    .clk_i, .we_i(k_valid_i), .waddr_i(k_job_i.id), .wdata_i({k_job_i.light, k_i}),
    .re_i(accept && upd_i.kind == UPD_LIGHT), .raddr_i(upd_i.id), .rdata_o({light, k})
  );
  rc_ram_1r1w #(.Width($bits(vec3_t)), .Depth(MAX_MATERIALS)) u_ambient (
    .clk_i, .we_i(ld_mat_valid_i), .waddr_i(ld_idx_i), .wdata_i({ld_mat.amb_b, ld_mat.amb_g, ld_mat.amb_r}),
    .re_i(accept && upd_i.kind == UPD_AMBIENT), .raddr_i(upd_i.mat), .rdata_o(ambient)
  );

  // ---- colour -----------------------------------------------------------------------------------------------------------
  logic  is_x, is_y, add_sum;
  vec3_t base;
  fp_t   base_in, base_sum, added, sum_axis;
  assign {is_y, is_x} = {beat_q[(T_IN + 1) % B], beat_q[T_IN % B]};
  always_comb begin
    unique case (slot_q[0].upd.kind)
      UPD_MISS:    base = background_i;
      UPD_AMBIENT: base = ambient;
      default:     base = acc;
    endcase
  end
  assign base_in = component(base, is_x, is_y);
  rc_fp_add #(.Latency(LAT_ADD)) u_add (.clk_i, .a_i(base_in), .b_i(component(k, is_x, is_y)), .y_o(added));
  rc_carry #(.Width(1 + FP_W), .From(T_IN), .To(T_SUM)) u_base_sum (
    .clk_i, .in_i({slot_q[0].upd.kind == UPD_LIGHT && slot_q[0].upd.add, base_in}), .out_o({add_sum, base_sum})
  );
  assign sum_axis = add_sum ? added : base_sum;
  rc_gather #(.From(T_SUM), .To(T_END)) u_sum (.clk_i, .in_i(sum_axis), .vec_o(sum));

  // ---- what comes next ----------------------------------------------------------------------------------------------------
  logic       at_end, last, job_in_ready, done_in_ready;
  logic [4:0] next_light;
  job_t       job_in;
  done_t      done_in;
  logic [$clog2(NUM_IDS + 1)-1:0] unused_jobs;
  logic [$clog2(ROOM + 1)-1:0]    unused_dones;
  assign slot_end   = slot_q[SLOTS-1];
  assign at_end     = valid_q[SLOTS-1] && beat_q[T_END % B];
  assign next_light = (slot_end.upd.kind == UPD_LIGHT) ? {1'b0, slot_end.light} + 5'd1 : '0;
  assign last       = slot_end.upd.kind == UPD_MISS || next_light >= light_count_i;
  assign finish     = at_end && last;
  assign proceed    = at_end && !last;
  assign job_in     = '{id: slot_end.upd.id, light: light_id_t'(next_light)};
  assign done_in    = '{id: slot_end.upd.id, rgb: sum};
  rc_fifo #(.data_t(job_t), .Depth(NUM_IDS)) u_jobs (
    .clk_i, .rst_ni,
    .in_valid_i(proceed), .in_ready_o(job_in_ready), .in_data_i(job_in),
    .out_valid_o(job_valid_o), .out_ready_i(job_ready_i), .out_data_o(job_o), .count_o(unused_jobs)
  );
  rc_fifo #(.data_t(done_t), .Depth(ROOM)) u_done (
    .clk_i, .rst_ni,
    .in_valid_i(finish), .in_ready_o(done_in_ready), .in_data_i(done_in),
    .out_valid_o(done_valid_o), .out_ready_i(done_ready_i), .out_data_o(done_o), .count_o(unused_dones)
  );

  logic unused_ld;
  assign unused_ld = ^{ld_mat, slot_end.upd.mat, slot_end.upd.add};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      OneBeat_A:  assert ($onehot(beat_q));
      Room_A:     assert (room_q <= room_t'(ROOM));
      JobRoom_A:  assert (!proceed || job_in_ready);
      DoneRoom_A: assert (!finish || done_in_ready);
    end
  end
`endif
endmodule
