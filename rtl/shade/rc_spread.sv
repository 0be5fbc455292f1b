// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Keeps a scalar of a rigid pipeline that is there at time From of its job for the three cycles To, To + 1, To + 2 in which a
// vector uses it: rc_hold, for any two times.
module rc_spread #(
  parameter int unsigned Width = 24,   // bits
  parameter int unsigned Beats = 5,    // cycles a job, at least 3
  parameter int unsigned From  = 0,    // cycles
  parameter int unsigned To    = 1     // cycles, after From
) (
  input  logic             clk_i,
  input  logic [Beats-1:0] beat_i,
  input  logic [Width-1:0] in_i,
  output logic [Width-1:0] out_o
);
  logic [Width-1:0] last;              // at time To - 1
  if (To == From + 1) begin : gen_wire
    assign last = in_i;
  end else begin : gen_hold
    rc_hold #(.Width(Width), .Beats(Beats), .From(From), .To(To - 1)) u_hold (
      .clk_i, .now_i(beat_i[From % Beats]), .in_i, .out_o(last)
    );
  end
  rc_hold #(.Width(Width), .Beats(Beats), .From(To - 1), .To(To), .Span(3)) u_spread (
    .clk_i, .now_i(beat_i[(To - 1) % Beats]), .in_i(last), .out_o
  );
endmodule
