// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Secondary rays: bounces of pixels come as jobs, reflected and transmitted rays leave, one at a time from a pixel; the second
// child of a bounce waits on the pixel's stack until a job pops it. rc_bounce makes the rays, rc_sec_stack keeps jobs and stacks.
//   start_o       in the last of five beats: a job wants to read its context in the next four cycles, as those of rc_light do
//   path_valid_o  weight, length and depth of a ray, in the cycle before it shows up at sec_o or earlier
//   end_valid_o   a bounce without a ray: the path ends
// A job starts, and a ray is popped, only if the queue of rays has room for it: nothing inside waits.
module rc_secondary import rc_pkg::*; import rc_shade_pkg::*; import rc_bounce_pkg::*; #(
  parameter int unsigned NumStacks = 64          // 1 to 256, of 16 entries
) (
  input  logic                   clk_i,
  input  logic                   rst_ni,
  input  fp_t                    min_weight_i,
  input  logic                   ld_valid_i,     // before a frame
  input  ld_kind_e               ld_kind_i,
  input  mat_id_t                ld_idx_i,
  input  line_t                  ld_line_i,
  input  logic                   job_valid_i,
  output logic                   job_ready_o,    // always
  input  bounce_t                job_i,
  output logic                   start_o,
  input  logic                   start_gnt_i,
  output logic                   ctx_re_o,       // context RAM: answers a cycle later
  output ctx_addr_t              ctx_addr_o,
  input  logic [CTX_W-1:0]       ctx_word_i,
  output logic                   sec_valid_o,
  input  logic                   sec_ready_i,
  output sec_t                   sec_o,
  output logic                   path_valid_o,
  output path_t                  path_o,
  output logic                   end_valid_o,
  input  logic                   end_ready_i,
  output ray_id_t                end_id_o,
  output logic [2**RAY_ID_W-1:0] pending_o       // the pixel has rays on a stack
);
  localparam int unsigned ROOM    = 2 ** $clog2(SLOTS + 6);      // rays inside and in the queue
  localparam int unsigned NUM_IDS = 2 ** RAY_ID_W;
  typedef logic [$clog2(ROOM + 1)-1:0] room_t;
  typedef struct packed {
    ray_id_t id;
    logic    transmit;
    depth_t  depth;
    surf_t   skip;
    vec3_t   dir;
    vec3_t   org;
  } out_t;

  logic       start_beat, start, start_valid, child_valid, child_traced, child_transmit, issue, ended;
  logic       pop_take, pop_valid;
  logic [4:0] end_beat;
  half_t      start_half, child_half;
  ray_id_t    next_id, pop_id;
  child_t     child, popped, leaving;
  room_t      room_q;
  assign job_ready_o = 1'b1;
  assign start_o     = start_beat && start_valid && room_q > room_t'(1);     // one is left for a pop, which goes first
  assign start       = start_o && start_gnt_i;

  rc_bounce u_bounce (
    .clk_i, .rst_ni, .min_weight_i, .ld_valid_i, .ld_kind_i, .ld_idx_i, .ld_line_i,
    .start_beat_o(start_beat), .start_i(start), .start_half_i(start_half),
    .ctx_re_o, .ctx_addr_o, .ctx_word_i, .end_beat_o(end_beat), .next_id_o(next_id),
    .child_valid_o(child_valid), .child_half_o(child_half), .child_traced_o(child_traced),
    .child_transmit_o(child_transmit), .child_o(child)
  );
  rc_sec_stack #(.IdW(RAY_ID_W), .NumStacks(NumStacks), .data_t(child_t)) u_stack (
    .clk_i, .rst_ni, .job_valid_i, .job_id_i(job_i.id), .job_pop_i(job_i.pop), .job_branch_i(job_i.branch),
    .start_valid_o(start_valid), .start_ready_i(start), .start_id_o(start_half.id), .start_branch_o(start_half.branch),
    .start_second_o(start_half.second), .beat_i(end_beat), .next_id_i(next_id),
    .child_valid_i(child_valid), .child_id_i(child_half.id), .child_branch_i(child_half.branch),
    .child_second_i(child_half.second), .child_traced_i(child_traced), .child_data_i(child),
    .issue_o(issue), .end_o(ended), .pop_room_i(room_q != '0), .pop_take_o(pop_take),
    .pop_valid_o(pop_valid), .pop_id_o(pop_id), .pop_data_o(popped), .pending_o
  );

  // ---- room: of every job inside and every ray in the queue; a job leaves its place to the ray that it makes ----------
  logic freed, sec_pop;
  assign freed   = child_valid && ((child_half.branch && !child_half.second) || ended);
  assign sec_pop = sec_valid_o && sec_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) room_q <= room_t'(ROOM);
    else room_q <= room_q - room_t'(start) - room_t'(pop_take) + room_t'(freed) + room_t'(sec_pop);
  end

  // ---- rays that leave; what a stack gives was transmitted ------------------------------------------------------------
  out_t                        in, out;
  logic                        sec_in_ready, end_in_ready;
  logic [$clog2(ROOM+1)-1:0]    unused_sec;
  logic [$clog2(NUM_IDS+1)-1:0] unused_end;
  assign leaving      = pop_valid ? popped : child;
  assign path_valid_o = issue || pop_valid;
  assign path_o       = '{id: in.id, w: leaving.w, len: leaving.len, depth: leaving.depth};
  assign in = '{id: pop_valid ? pop_id : child_half.id, transmit: pop_valid || child_transmit, depth: leaving.depth,
                skip: leaving.skip, dir: leaving.dir, org: leaving.org};
  rc_fifo #(.data_t(out_t), .Depth(ROOM), .Ram(1'b0)) u_sec (
    .clk_i, .rst_ni, .in_valid_i(path_valid_o), .in_ready_o(sec_in_ready), .in_data_i(in),
    .out_valid_o(sec_valid_o), .out_ready_i(sec_ready_i), .out_data_o(out), .count_o(unused_sec)
  );
  assign sec_o = '{id: out.id, kind: out.transmit ? RAY_TRANSMIT : RAY_REFLECT, light: '0, depth: out.depth,
                   skip: out.skip, t_min: T_MIN, t_max: FP_HUGE, dir: out.dir, org: out.org};
  rc_fifo #(.data_t(ray_id_t), .Depth(NUM_IDS)) u_end (
    .clk_i, .rst_ni, .in_valid_i(ended), .in_ready_o(end_in_ready), .in_data_i(child_half.id),
    .out_valid_o(end_valid_o), .out_ready_i(end_ready_i), .out_data_o(end_id_o), .count_o(unused_end)
  );

  if (NumStacks < 1 || NumStacks > NUM_IDS) begin : gen_check
    $error("rc_secondary: 1 to %0d stacks", NUM_IDS);
  end
`ifndef SYNTHESIS
  logic [NUM_IDS-1:0] inside_q;                  // checks that a pixel is in one place
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      inside_q <= '0;
    end else begin
      if (sec_pop) inside_q[out.id] <= 1'b0;
      if (end_valid_o && end_ready_i) inside_q[end_id_o] <= 1'b0;
      if (job_valid_i) inside_q[job_i.id] <= 1'b1;
    end
    if (rst_ni) begin
      OnePlace_M: assume (!job_valid_i || !inside_q[job_i.id]);
      PopHasRay_M: assume (!job_valid_i || !job_i.pop || pending_o[job_i.id]);
      Room_A:     assert (room_q <= room_t'(ROOM));
      SecRoom_A:  assert (!path_valid_o || sec_in_ready);
      EndRoom_A:  assert (!ended || end_in_ready);
      OneRay_A:   assert (!(issue && pop_valid));
    end
  end
`endif
endmodule
