// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Stacks of secondary rays (paper Sec. 3.3), one to a pixel that needs one, and the jobs that wait for the bounce unit:
//   plain     bounces with one child at most, and all of pixels that have a stack
//   waiting   bounces that may have two children, of pixels without a stack: they start when one is free
//   pops      pixels that go on with a ray from their stack
// A bounce that may have two children is two jobs of the unit, the transmitted child first: it is pushed. If no reflected one
// follows it is popped at once. What happens in each beat (beat_i[k]), so that nothing meets in a memory:
//   0  a child comes: push; or a stack is given back      1  pop: which stack?      2  pop: read it; the last ray frees the stack
//   3  pop: the ray leaves; a stack that was given is noted                         4  which stack has the child that comes?
// docs/bounce.md argues why nothing can wait for ever; formal/rc_sec_stack_props.sv proves it at small sizes.
module rc_sec_stack #(
  parameter  int unsigned IdW       = 8,                  // a ray index, 2^IdW pixels
  parameter  int unsigned NumStacks = 64,
  parameter  int unsigned Entries   = 16,                 // one more than a stack ever holds
  parameter  type         data_t    = logic [31:0],       // a ray
  localparam int unsigned NumIds    = 2 ** IdW
) (
  input  logic              clk_i,
  input  logic              rst_ni,
  input  logic              job_valid_i,     // there is always room
  input  logic [IdW-1:0]    job_id_i,
  input  logic              job_pop_i,
  input  logic              job_branch_i,
  output logic              start_valid_o,   // the next job of the unit; may change until it is taken
  input  logic              start_ready_i,   // at most every fifth cycle
  output logic [IdW-1:0]    start_id_o,
  output logic              start_branch_o,
  output logic              start_second_o,
  input  logic [4:0]        beat_i,
  input  logic [IdW-1:0]    next_id_i,       // beat 4: of the child that comes
  input  logic              child_valid_i,   // beat 0
  input  logic [IdW-1:0]    child_id_i,
  input  logic              child_branch_i,
  input  logic              child_second_i,
  input  logic              child_traced_i,
  input  data_t             child_data_i,
  output logic              issue_o,         // beat 0: the child is to be traced now
  output logic              end_o,           // beat 0: the bounce makes no ray
  input  logic              pop_room_i,
  output logic              pop_take_o,      // beat 1: takes a place for a ray
  output logic              pop_valid_o,     // beat 3
  output logic [IdW-1:0]    pop_id_o,
  output data_t             pop_data_o,
  output logic [NumIds-1:0] pending_o        // pixels with a ray on a stack
);
  localparam int unsigned StackW = (NumStacks > 1) ? $clog2(NumStacks) : 1;
  localparam int unsigned PtrW   = $clog2(Entries);
  localparam int unsigned RamW   = $clog2(NumStacks * Entries);
  localparam int unsigned CountW = $clog2(NumIds + 1);
  typedef logic [IdW-1:0]    id_t;
  typedef logic [StackW-1:0] stack_t;
  typedef logic [PtrW-1:0]   ptr_t;
  typedef logic [RamW-1:0]   addr_t;
  typedef struct packed {stack_t nr; ptr_t count;} held_t;    // of a pixel: its stack, how many rays are on it
  typedef struct packed {logic branch; id_t id;} plain_t;

  logic [NumIds-1:0] pending_q;
  assign pending_o = pending_q;

  // ---- jobs that wait -------------------------------------------------------------------------------------------------
  logic   holds, plain_valid, plain_ready, plain_pop, wait_valid, wait_ready, wait_pop;
  logic   pops_valid, pops_ready, pops_pop;
  logic   in_pop, in_plain, in_wait;
  plain_t plain;
  id_t    wait_id, pops_id;
  logic [2:0][CountW-1:0] unused_count;
  assign holds    = pending_q[job_id_i];
  assign in_pop   = job_valid_i && job_pop_i;
  assign in_wait  = job_valid_i && !job_pop_i && job_branch_i && !holds;
  assign in_plain = job_valid_i && !job_pop_i && !in_wait;
  rc_fifo #(.data_t(plain_t), .Depth(NumIds)) u_plain (
    .clk_i, .rst_ni, .in_valid_i(in_plain), .in_ready_o(plain_ready), .in_data_i({job_branch_i, job_id_i}),
    .out_valid_o(plain_valid), .out_ready_i(plain_pop), .out_data_o(plain), .count_o(unused_count[0])
  );
  rc_fifo #(.data_t(id_t), .Depth(NumIds)) u_wait (
    .clk_i, .rst_ni, .in_valid_i(in_wait), .in_ready_o(wait_ready), .in_data_i(job_id_i),
    .out_valid_o(wait_valid), .out_ready_i(wait_pop), .out_data_o(wait_id), .count_o(unused_count[1])
  );
  rc_fifo #(.data_t(id_t), .Depth(NumIds)) u_pops (
    .clk_i, .rst_ni, .in_valid_i(in_pop), .in_ready_o(pops_ready), .in_data_i(job_id_i),
    .out_valid_o(pops_valid), .out_ready_i(pops_pop), .out_data_o(pops_id), .count_o(unused_count[2])
  );

  // ---- start: the second half of what was started; else plain and waiting jobs in turn --------------------------------
  logic   second_q, turn_q, free_valid, use_wait, give_q;
  id_t    started_id_q, give_id_q;
  stack_t free_stack, give_stack_q;
  assign use_wait       = !second_q && wait_valid && free_valid && (turn_q || !plain_valid);
  assign start_valid_o  = second_q || plain_valid || (wait_valid && free_valid);
  assign start_id_o     = second_q ? started_id_q : use_wait ? wait_id : plain.id;
  assign start_branch_o = second_q || use_wait || plain.branch;
  assign start_second_o = second_q;
  assign wait_pop       = start_ready_i && use_wait;
  assign plain_pop      = start_ready_i && !second_q && !use_wait && plain_valid;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {second_q, turn_q, give_q} <= '0;
    end else begin
      if (start_ready_i && start_valid_o) begin
        second_q <= start_branch_o && !second_q;
        if (!second_q) turn_q <= !use_wait;
      end
      if (beat_i[3]) give_q <= 1'b0;
      if (wait_pop) give_q <= 1'b1;
    end
    if (start_ready_i && !second_q) started_id_q <= start_id_o;
    if (wait_pop) {give_id_q, give_stack_q} <= {wait_id, free_stack};
  end

  // ---- a child comes --------------------------------------------------------------------------------------------------
  held_t held;
  logic  push, last, leave_q, pushed_q, give_back;
  id_t   child_id_q;
  assign push      = child_valid_i && child_branch_i && !child_second_i && child_traced_i;
  assign last      = child_valid_i && (!child_branch_i || child_second_i);        // no more comes of this bounce
  assign issue_o   = last && child_traced_i;
  assign end_o     = last && !child_traced_i && !(child_branch_i && pushed_q);
  assign give_back = last && child_branch_i && held.count == '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {leave_q, pushed_q} <= '0;
    end else begin
      if (child_valid_i && !last) pushed_q <= child_traced_i;
      leave_q <= last && child_branch_i && !child_traced_i && pushed_q;               // what was pushed goes at once
    end
    if (child_valid_i) child_id_q <= child_id_i;
  end

  // ---- pops -----------------------------------------------------------------------------------------------------------
  // What goes at once has the place for a ray that its job had.
  logic pop_start, pop1_q, pop2_q, pop_last;
  id_t  pop_id, pop1_id_q, pop2_id_q;
  ptr_t pop_count;
  assign pops_pop   = beat_i[1] && !leave_q && pop_room_i;
  assign pop_take_o = pops_pop && pops_valid;
  assign pop_start  = leave_q || pop_take_o;
  assign pop_id     = leave_q ? child_id_q : pops_id;
  assign pop_count  = held.count - 1'b1;
  assign pop_last   = pop1_q && pop_count == '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {pop1_q, pop2_q} <= '0;
      pending_q        <= '0;
    end else begin
      pop1_q <= pop_start;
      pop2_q <= pop1_q;
      if (push) pending_q[child_id_i] <= 1'b1;
      if (pop_last) pending_q[pop1_id_q] <= 1'b0;
    end
    pop1_id_q <= pop_id;
    pop2_id_q <= pop1_id_q;
  end
  assign pop_valid_o = pop2_q;
  assign pop_id_o    = pop2_id_q;

  // ---- memories -------------------------------------------------------------------------------------------------------
  logic  held_we, held_re;
  id_t   held_waddr;
  held_t held_wdata;
  always_comb begin
    held_we    = give_q && beat_i[3];
    held_waddr = give_id_q;
    held_wdata = '{nr: give_stack_q, count: '0};
    if (push) begin
      held_we    = 1'b1;
      held_waddr = child_id_i;
      held_wdata = '{nr: held.nr, count: held.count + 1'b1};
    end
    if (pop1_q) begin
      held_we    = 1'b1;
      held_waddr = pop1_id_q;
      held_wdata = '{nr: held.nr, count: pop_count};
    end
  end
  assign held_re = pop_start || beat_i[4];
  rc_ram_1r1w #(.Width($bits(held_t)), .Depth(NumIds)) u_held (
    .clk_i, .we_i(held_we), .waddr_i(held_waddr), .wdata_i(held_wdata),
    .re_i(held_re), .raddr_i(beat_i[1] ? pop_id : next_id_i), .rdata_o(held)
  );
  rc_ram_1r1w #(.Width($bits(data_t)), .Depth(NumStacks * Entries)) u_rays (
    .clk_i, .we_i(push), .waddr_i(addr_t'({held.nr, held.count})), .wdata_i(child_data_i),
    .re_i(pop1_q), .raddr_i(addr_t'({held.nr, pop_count})), .rdata_o(pop_data_o)
  );
  logic [$clog2(NumStacks+1)-1:0] free_count;
  logic unused_free;
  assign unused_free = ^free_count;
  rc_idx_pool #(.NumIdx(NumStacks)) u_free (
    .clk_i, .rst_ni, .out_valid_o(free_valid), .out_ready_i(wait_pop), .out_idx_o(free_stack),
    .free_valid_i(give_back || pop_last), .free_idx_i(held.nr), .count_o(free_count)
  );

  if (Entries != 2 ** PtrW) begin : gen_check
    $error("rc_sec_stack: the entries of a stack must be a power of two");
  end
`ifndef SYNTHESIS
  // Checks: a stack's pixel; pixels that hold one; starts of the other kind while a job of this kind may start
  id_t        owner_q[NumStacks];
  logic [$clog2(NumStacks+1)-1:0] holders_q;
  logic [1:0] plain_passed_q, wait_passed_q;
  logic       first_start;
  assign first_start = start_ready_i && start_valid_o && !second_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {holders_q, plain_passed_q, wait_passed_q} <= '0;
    end else begin
      holders_q <= holders_q + $bits(holders_q)'(first_start && start_branch_o && !pending_q[start_id_o])
                   - $bits(holders_q)'((last && child_branch_i && !pending_q[child_id_i]) || pop_last);
      if (first_start) begin
        plain_passed_q <= (plain_valid && use_wait) ? plain_passed_q + 1'b1 : '0;
        wait_passed_q  <= (wait_valid && free_valid && !use_wait) ? wait_passed_q + 1'b1 : '0;
      end
    end
    if (wait_pop) owner_q[free_stack] <= wait_id;
  end
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      OneBeat_M:   assume ($onehot(beat_i));
      Child_M:     assume (!child_valid_i || beat_i[0]);
      QueueRoom_A: assert ((!in_plain || plain_ready) && (!in_wait || wait_ready) && (!in_pop || pops_ready));
      // Who has a stack never waits for one, and a job that is plain does not need one.
      HolderGoesOn_A: assert (!wait_valid || !pending_q[wait_id]);
      PlainHasStack_A: assert (!plain_valid || !plain.branch || pending_q[plain.id]);
      if (child_valid_i && child_branch_i) Owner_A: assert (owner_q[held.nr] == child_id_i);
      if (pop1_q) PopOwner_A: assert (owner_q[held.nr] == pop1_id_q);
      NoneLost_A:  assert (holders_q + free_count == $bits(holders_q)'(NumStacks));
      Fair_A:      assert (plain_passed_q <= 2'd1 && wait_passed_q <= 2'd1);
      Overflow_A:  assert (!push || held.count != '1);           // rays on a stack have different depths, 1 to 15
      Underflow_A: assert (!pop1_q || (held.count != '0 && pending_q[pop1_id_q]));
      Given_A:     assert (!(give_q && wait_pop) || beat_i[3]);  // noted before the next is given
      Beats_A:     assert ((!pop1_q || beat_i[2]) && (!pop2_q || beat_i[3]));
    end
  end
`endif
endmodule
