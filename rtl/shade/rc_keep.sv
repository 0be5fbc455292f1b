// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Keeps values of a rigid pipeline that are there in one cycle only, at time From of their job, for the times To to
// To + Beats - 1. As rc_hold, but a word of a small RAM for each job in between, not registers that shift: for what is wide
// and is needed long after.
module rc_keep #(
  parameter int unsigned Width = 72,   // bits
  parameter int unsigned Beats = 4,    // cycles a job
  parameter int unsigned From  = 0,    // cycles
  parameter int unsigned To    = 2     // cycles, at least From + 2
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             now_i,      // it is the beat of time From
  input  logic             next_i,     // it is the beat of time To - 1
  input  logic [Width-1:0] in_i,
  output logic [Width-1:0] out_o
);
  if (To < From + 2) begin : gen_check
    $error("rc_keep: a value is used before it exists");
  end
  localparam int unsigned LATER = (To - From - 2) / Beats;        // jobs that came between it and its reading
  localparam int unsigned WORDS = (To - From - 1) / Beats + 1;    // in use then
  localparam int unsigned PTR_W = (WORDS > 1) ? $clog2(WORDS) : 1;
  typedef logic [PTR_W-1:0] ptr_t;
  ptr_t wptr_q;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) wptr_q <= '0;
    else if (now_i) wptr_q <= wptr_q + 1'b1;
  end
  rc_ram_1r1w #(.Width(Width), .Depth(2 ** PTR_W)) u_ram (
    .clk_i, .we_i(now_i), .waddr_i(wptr_q), .wdata_i(in_i),
    .re_i(next_i), .raddr_i(wptr_q - ptr_t'(LATER + 1)), .rdata_o(out_o)
  );
endmodule
