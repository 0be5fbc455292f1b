// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Who starts in rc_light and rc_secondary, for any wishes and any beats: only one at a time, somebody whenever somebody can, and
// nobody is passed over for ever. A chance of a job is a cycle in which it wants to start and its unit can.
module rc_shade_start_props import rc_pkg::*; import rc_shade_pkg::*; (
  input logic clk_i,
  input logic next_valid_i,
  input logic again_valid_i,
  input logic light_ready_i,
  input logic sec_wants_i
);
  logic next_ready, again_ready, light_valid, sec_start;
  job_t light;
  logic started_q;                         // after the reset
  initial started_q = 1'b0;
  always_ff @(posedge clk_i) started_q <= 1'b1;
  rc_shade_start u_dut (
    .clk_i, .rst_ni(started_q), .next_valid_i, .next_ready_o(next_ready), .next_i('{id: 8'd1, light: '0, t_min: '0}),
    .again_valid_i, .again_ready_o(again_ready), .again_i('{id: 8'd2, light: '0, t_min: '0}),
    .light_valid_o(light_valid), .light_ready_i, .light_o(light), .sec_wants_i, .sec_start_o(sec_start)
  );

  // Chances that were missed, one after the other
  logic       next_starts, again_starts, light_starts;
  logic [2:0] next_missed_q, again_missed_q, sec_missed_q;
  assign next_starts  = next_valid_i && next_ready;
  assign again_starts = again_valid_i && again_ready;
  assign light_starts = light_valid && light_ready_i;
  always_ff @(posedge clk_i) begin
    if (!started_q) begin
      {next_missed_q, again_missed_q, sec_missed_q} <= '0;
    end else begin
      if (next_starts) next_missed_q <= '0;
      else if (next_valid_i && light_ready_i && next_missed_q != '1) next_missed_q <= next_missed_q + 1'b1;
      if (again_starts) again_missed_q <= '0;
      else if (again_valid_i && light_ready_i && again_missed_q != '1) again_missed_q <= again_missed_q + 1'b1;
      if (sec_start) sec_missed_q <= '0;
      else if (sec_wants_i && sec_missed_q != '1) sec_missed_q <= sec_missed_q + 1'b1;

      if ($past(started_q && next_valid_i && !next_ready))   NextHeld_M:  assume (next_valid_i);
      if ($past(started_q && again_valid_i && !again_ready)) AgainHeld_M: assume (again_valid_i);
      One_A:   assert ($onehot0({next_starts, again_starts, sec_start}));
      Light_A: assert (light_starts == (next_starts || again_starts));
      Right_A: assert (!light_starts || light.id == (next_starts ? 8'd1 : 8'd2));
      Busy_A:  assert ((light_starts || sec_start) == (sec_wants_i || (light_ready_i && (next_valid_i || again_valid_i))));
      Wish_A:  assert (!sec_start || sec_wants_i);
      NextInTime_A:  assert (next_missed_q <= 3'd3);
      AgainInTime_A: assert (again_missed_q <= 3'd3);
      SecInTime_A:   assert (sec_missed_q <= 3'd1);
    end
  end
endmodule
