// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The rays of one pipeline: input buffer, constants, hits, output buffer. 32 slots, one a ray; a ray
// holds its slot from the moment it comes in until its hit leaves, so nothing here can overflow.
//   in    constants to RAM, slot to the queue of rays that wait for the ring
//   ring  constants read by slot (one cycle), those in an object's coordinates written and read likewise; hits written by slot
//   out   finished slots wait in a queue; hit and index are read back and the slot is free again
module rc_tni_rays import rc_pkg::*, rc_tni_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  ray_t       in_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output hit_t       out_o,
  // ring
  output logic       enter_valid_o,        // a ray waits; taken when enter_ready_i
  input  logic       enter_ready_i,
  output slot_t      enter_slot_o,
  input  logic       rd_valid_i,
  input  slot_t      rd_slot_i,
  input  logic       rd_object_i,          // in the coordinates of the placed object that it entered last
  output ray_const_t rd_ray_o,             // one cycle later
  input  logic       axis_valid_i,         // ENTER: a component of that
  input  slot_t      axis_slot_i,
  input  inst_half_t axis_row_i,
  input  ray_axis_t  axis_i,
  input  logic       hit_valid_i,          // a nearer hit
  input  slot_t      hit_slot_i,
  input  surf_t      hit_surf_i,
  input  logic       hit_opaque_i,
  input  mat_t       hit_mat_i,
  input  fp_t        hit_beta_i,
  input  fp_t        hit_gamma_i,
  input  logic       done_valid_i,         // the ray is finished
  input  slot_t      done_slot_i,
  input  logic       done_hit_i,
  input  fp_t        done_t_i
);
  localparam int unsigned SLOTS = 1 << SLOT_W;
  typedef struct packed {slot_t slot; logic hit; fp_t t;} outcome_t;
  typedef struct packed {logic opaque; mat_t mat; surf_t surf; fp_t beta; fp_t gamma;} where_t;
  typedef struct packed {ray_id_t id; logic any_hit;} name_t;

  // ---- in ---------------------------------------------------------------------------------------------
  logic        slot_valid, in_fire, free_valid;
  slot_t       slot, free_slot;
  ray_const_t  in_const, rd_scene;
  ray_axis_t [2:0] rd_axis;
  logic        rd_object_q;
  logic [SLOT_W:0] free_count_unused, wait_count_unused, done_count_unused;
  logic        wait_ready, done_ready;
  assign in_ready_o = slot_valid;
  assign in_fire    = in_valid_i && slot_valid;
  assign in_const   = '{any_hit: in_i.any_hit, skip: in_i.skip, t_min: in_i.t_min, t_max: in_i.t_max,
                        inv_dir: in_i.inv_dir, dir: in_i.dir, org: in_i.org};
  rc_idx_pool #(.NumIdx(SLOTS)) u_free (
    .clk_i, .rst_ni, .out_valid_o(slot_valid), .out_ready_i(in_fire), .out_idx_o(slot),
    .free_valid_i(free_valid), .free_idx_i(free_slot), .count_o(free_count_unused));
  rc_fifo #(.data_t(slot_t), .Depth(SLOTS)) u_wait (
    .clk_i, .rst_ni, .in_valid_i(in_fire), .in_ready_o(wait_ready), .in_data_i(slot),
    .out_valid_o(enter_valid_o), .out_ready_i(enter_ready_i), .out_data_o(enter_slot_o), .count_o(wait_count_unused));
  rc_ram_1r1w #(.Width($bits(ray_const_t)), .Depth(SLOTS)) u_const (
    .clk_i, .we_i(in_fire), .waddr_i(slot), .wdata_i(in_const), .re_i(rd_valid_i), .raddr_i(rd_slot_i),
    .rdata_o(rd_scene));
  for (genvar i = 0; i < 3; i++) begin : gen_axis
    rc_ram_1r1w #(.Width($bits(ray_axis_t)), .Depth(SLOTS)) u_axis (
      .clk_i, .we_i(axis_valid_i && axis_row_i == ROW_FIRST + inst_half_t'(i)), .waddr_i(axis_slot_i), .wdata_i(axis_i),
      .re_i(rd_valid_i && rd_object_i), .raddr_i(rd_slot_i), .rdata_o(rd_axis[i]));
  end
  always_ff @(posedge clk_i) rd_object_q <= rd_object_i;
  always_comb begin
    rd_ray_o = rd_scene;
    if (rd_object_q)
      for (int i = 0; i < 3; i++) {rd_ray_o.inv_dir[i], rd_ray_o.dir[i], rd_ray_o.org[i]} = rd_axis[i];
  end

  // ---- out: a finished slot is read, then offered -----------------------------------------------------------
  outcome_t    done;
  where_t      where;
  name_t       name;
  logic        done_valid, read, out_hit_q;
  fp_t         out_t_q;
  rc_fifo #(.data_t(outcome_t), .Depth(SLOTS)) u_done (
    .clk_i, .rst_ni, .in_valid_i(done_valid_i), .in_ready_o(done_ready),
    .in_data_i({done_slot_i, done_hit_i, done_t_i}),
    .out_valid_o(done_valid), .out_ready_i(read), .out_data_o(done), .count_o(done_count_unused));
  assign read       = done_valid && (!out_valid_o || out_ready_i);
  assign free_valid = read;
  assign free_slot  = done.slot;
  rc_ram_1r1w #(.Width($bits(where_t)), .Depth(SLOTS)) u_where (
    .clk_i, .we_i(hit_valid_i), .waddr_i(hit_slot_i),
    .wdata_i({hit_opaque_i, hit_mat_i, hit_surf_i, hit_beta_i, hit_gamma_i}),
    .re_i(read), .raddr_i(done.slot), .rdata_o(where));
  rc_ram_1r1w #(.Width($bits(name_t)), .Depth(SLOTS)) u_name (
    .clk_i, .we_i(in_fire), .waddr_i(slot), .wdata_i({in_i.id, in_i.any_hit}),
    .re_i(read), .raddr_i(done.slot), .rdata_o(name));
  always_ff @(posedge clk_i) begin
    if (!rst_ni) out_valid_o <= 1'b0;
    else if (read) out_valid_o <= 1'b1;
    else if (out_ready_i) out_valid_o <= 1'b0;
    if (read) {out_hit_q, out_t_q} <= {done.hit, done.t};
  end
  always_comb begin
    out_o = '{id: name.id, any_hit: name.any_hit, hit: out_hit_q, opaque: 1'b0, mat: '0, surf: SURF_NONE, t: out_t_q,
              beta: FP_ZERO, gamma: FP_ZERO};
    if (out_hit_q) {out_o.opaque, out_o.mat, out_o.surf, out_o.beta, out_o.gamma} = where;
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && in_fire)      WaitRoom_A: assert (wait_ready);
    if (rst_ni && done_valid_i) DoneRoom_A: assert (done_ready);
  end
`endif
endmodule
