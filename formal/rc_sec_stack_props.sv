// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Proof: the control of secondary rays (rc_sec_stack) at small sizes. The solver plays everything else: pixels in any
// order, bounces whose children are traced or not, windows and room that are granted or not. Rays are their depth.
//   no overflow      stacks of Entries - 1 rays suffice if no ray is deeper than that (Overflow_A, Underflow_A)
//   no two owners    OneOwner_A, Owner_A; none lost: NoneLost_A
//   nothing waits    for ever: a pixel with a stack never waits for one (Holder_A); if a job waits and none may start, every stack
//                    is held by a pixel that does not wait (Served_A); a job that may start is overtaken once (Fair_A);
//                    a pop goes as soon as there is room (PopGoes_A)
//   last in, first out, each ray once: Lifo_A, Once_A
// Wrong = 1 claims that a pixel that waits never starts while another has rays on a stack, 2 that no ray of depth Entries - 1 is popped:
// both must fail.
module rc_sec_stack_props #(
  parameter int unsigned IdW       = 1,
  parameter int unsigned NumStacks = 1,
  parameter int unsigned Entries   = 4,
  parameter int unsigned Slots     = 1,      // windows from a start to the child
  parameter int unsigned Start     = 2,      // beat in which jobs start, 0 to 3
  parameter bit          Data      = 1'b0,   // look at what the memory of rays gives, too
  parameter int unsigned Wrong     = 0
) (
  input logic           clk_i,
  input logic           rst_ni,
  input logic           job_valid_i,
  input logic [IdW-1:0] job_id_i,
  input logic           job_pop_i,
  input logic           job_branch_i,
  input logic           job_new_i,           // a primary ray of a new pixel hit something
  input logic           gnt_i,
  input logic           traced_i,
  input logic           pop_room_i,
  input logic [3:0][3:0] choice_i             // of the queues, see rc_fifo_bag.sv
);
  localparam int unsigned NumIds = 2 ** IdW;
  localparam int unsigned PtrW   = $clog2(Entries);
  localparam int unsigned StackW = (NumStacks > 1) ? $clog2(NumStacks) : 1;
  typedef logic [IdW-1:0]  id_t;
  typedef logic [PtrW-1:0] depth_t;
  typedef struct packed {logic valid; id_t id; logic branch; logic second;} slot_t;

  // ---- the bounce unit ------------------------------------------------------------------------------------------------
  logic              started_q = 1'b0;
  logic  [4:0]       beat_q;
  slot_t [Slots-1:0] slot_q;
  slot_t             start_slot, child;
  logic              start_valid, start, child_valid, issue, ended, pop_take, pop_valid;
  id_t               pop_id;
  depth_t            pop_data;
  logic [NumIds-1:0] pending;
  assign start            = start_valid && gnt_i && beat_q[Start];
  assign start_slot.valid = start;
  assign child            = slot_q[Slots-1];
  assign child_valid      = child.valid && beat_q[0];
  always_ff @(posedge clk_i) begin
    started_q <= 1'b1;
    if (!rst_ni) begin
      beat_q <= 5'd1;
      slot_q <= '0;
    end else begin
      beat_q <= {beat_q[3:0], beat_q[4]};
      if (beat_q[Start]) begin
        for (int i = 1; i < Slots; i++) slot_q[i] <= slot_q[i-1];
        slot_q[0] <= start_slot;
      end
    end
  end

  // ---- pixels ---------------------------------------------------------------------------------------------------------
  logic   [NumIds-1:0]              inside_q, ray_q, waits_q, plain_q, pops_q, branching_q;   // it has a job inside; it has a ray ...
  logic   [NumIds-1:0]              bounce_q, pushed_q;  // it has a bounce inside, whose first child was pushed
  depth_t [NumIds-1:0]              depth_q;                                                  // ... of this depth
  depth_t [NumIds-1:0]              count_q;
  depth_t [NumIds-1:0][Entries-1:0] rays_q;              // its stack, as it should be
  depth_t                           cur_depth, top;
  logic                             last, push, leave_q;                                       // leave: a ray was pushed to go at once
  assign cur_depth = job_new_i ? '0 : depth_q[job_id_i];
  assign top       = rays_q[pop_id][depth_t'(count_q[pop_id] - 1'b1)];
  assign last      = !child.branch || child.second;
  assign push      = child_valid && !last && traced_i;
  always_ff @(posedge clk_i) begin
    leave_q <= child_valid && last && !issue && !ended;
    if (!rst_ni) begin
      {inside_q, ray_q, waits_q, plain_q, pops_q, branching_q, bounce_q, pushed_q, count_q} <= '0;
    end else begin
      if (job_valid_i) begin
        inside_q[job_id_i] <= 1'b1;
        ray_q[job_id_i]    <= 1'b0;
        depth_q[job_id_i]  <= cur_depth;
        pops_q[job_id_i]   <= job_pop_i;
        bounce_q[job_id_i] <= !job_pop_i;
        pushed_q[job_id_i] <= 1'b0;
        waits_q[job_id_i]  <= !job_pop_i && job_branch_i && !pending[job_id_i];
        plain_q[job_id_i]  <= !job_pop_i && !(job_branch_i && !pending[job_id_i]);
      end
      if (start) begin
        {waits_q[start_slot.id], plain_q[start_slot.id]} <= '0;
        branching_q[start_slot.id] <= start_slot.branch;
      end
      if (child_valid && last) branching_q[child.id] <= 1'b0;
      if (push) begin
        pushed_q[child.id] <= 1'b1;
        rays_q[child.id][count_q[child.id]] <= depth_q[child.id] + 1'b1;
        count_q[child.id]                   <= count_q[child.id] + 1'b1;
      end
      if (issue) begin
        {inside_q[child.id], bounce_q[child.id], pushed_q[child.id], ray_q[child.id]} <= 4'b0001;
        depth_q[child.id] <= depth_q[child.id] + 1'b1;
      end
      if (ended) {inside_q[child.id], bounce_q[child.id]} <= '0;
      if (pop_valid) begin
        {inside_q[pop_id], pops_q[pop_id], bounce_q[pop_id], pushed_q[pop_id], ray_q[pop_id]} <= 5'b00001;
        depth_q[pop_id] <= top;
        count_q[pop_id] <= count_q[pop_id] - 1'b1;
      end
    end
  end

  rc_sec_stack #(.IdW(IdW), .NumStacks(NumStacks), .Entries(Entries), .data_t(depth_t)) u_dut (
    .clk_i, .rst_ni, .job_valid_i, .job_id_i, .job_pop_i, .job_branch_i,
    .start_valid_o(start_valid), .start_ready_i(gnt_i && beat_q[Start]), .start_id_o(start_slot.id),
    .start_branch_o(start_slot.branch), .start_second_o(start_slot.second), .beat_i(beat_q), .next_id_i(child.id),
    .child_valid_i(child_valid), .child_id_i(child.id), .child_branch_i(child.branch), .child_second_i(child.second),
    .child_traced_i(traced_i), .child_data_i(depth_t'(depth_q[child.id] + 1'b1)), .issue_o(issue), .end_o(ended),
    .pop_room_i, .pop_take_o(pop_take), .pop_valid_o(pop_valid), .pop_id_o(pop_id), .pop_data_o(pop_data), .pending_o(pending)
  );

  defparam u_dut.u_wait.Salt = 1, u_dut.u_pops.Salt = 2, u_dut.u_free.u_freed.Salt = 3;

  // ---- what holds -----------------------------------------------------------------------------------------------------
  logic [NumIds-1:0] holds, any, levels;      // a stack; rays on it, no more than the depth of the one that is traced
  logic [NumIds-1:0] known;                   // the stack that the DUT has noted for it is its own
  logic [IdW:0]      holders;
  assign holds = pending | branching_q;
  always_comb begin
    holders = '0;
    known   = '1;
    for (int i = 0; i < NumIds; i++) begin
      if (u_dut.give_q && u_dut.give_id_q == id_t'(i)) begin
        known[i] = holds[i] && u_dut.owner_q[u_dut.give_stack_q] == id_t'(i) && u_dut.u_free.used_q[u_dut.give_stack_q];
      end else if (holds[i]) begin
        known[i] = u_dut.owner_q[u_dut.u_held.mem[i][PtrW+:StackW]] == id_t'(i)
                   && u_dut.u_free.used_q[u_dut.u_held.mem[i][PtrW+:StackW]]
                   && u_dut.u_held.mem[i][PtrW-1:0] == count_q[i] - depth_t'(u_dut.pop2_q && u_dut.pop2_id_q == id_t'(i));
      end
      holders  += (IdW + 1)'(holds[i]);
      any[i]    = count_q[i] != '0;
      levels[i] = !(ray_q[i] || bounce_q[i]) || 32'(count_q[i]) <= 32'(depth_q[i]) + 32'(pushed_q[i]);
      for (int k = 0; k < Entries; k++) if (depth_t'(k) < count_q[i] && rays_q[i][k] <= depth_t'(k)) levels[i] = 1'b0;
    end
  end
  always_ff @(posedge clk_i) begin
    if (!started_q) Reset_M: assume (!rst_ni);
    if (started_q && rst_ni) begin
      if (job_valid_i) begin
        OnePlace_M: assume (!inside_q[job_id_i]);
        Pop_M:      assume (!job_pop_i || pending[job_id_i]);
        Ray_M:      assume (job_pop_i || job_new_i || ray_q[job_id_i]);
        New_M:      assume (!job_new_i || (!job_pop_i && !pending[job_id_i]));
        Depth_M:    assume (job_pop_i || cur_depth != '1);       // MAX_DEPTH
      end
      if (issue || ended) Once_A: assert (inside_q[child.id] && !(issue && ended));
      if (pop_valid) Pop_A: assert (inside_q[pop_id] && count_q[pop_id] != '0);
      if (Data && pop_valid) Lifo_A: assert (pop_data == top);
      Pending_A: assert ((~inside_q & (pending ^ any)) == '0);
      Holder_A:  assert ((waits_q & holds) == '0);
      Levels_A:  assert (levels == '1);
      Known_A:   assert (known == '1);
      Stacks_A: assert (holders <= (IdW + 1)'(NumStacks));
      if (waits_q != '0 && !start_valid) Served_A: assert (holders == (IdW + 1)'(NumStacks));
      if (plain_q != '0) PlainServed_A: assert (start_valid);
      if (beat_q[1] && pop_room_i && pops_q != '0 && !leave_q) PopGoes_A: assert (pop_take);
      if (Wrong == 1 && start) Overtakes_A: assert (!waits_q[start_slot.id] || pending == '0);
      if (Wrong == 2 && pop_valid) Deep_A: assert (top != '1);
    end
  end
endmodule
