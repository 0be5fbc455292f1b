// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Which job starts next in rc_light and rc_secondary. Both start in the same beat of LIGHT_BEATS and read the context in the four
// cycles after, from one port: so one of them starts in a beat, by turns if both want. Shadow rays that go on behind
// something transparent and those of the next light take turns, too. Combinational but for the turns.
module rc_shade_start import rc_pkg::*; import rc_shade_pkg::*; (
  input  logic clk_i,
  input  logic rst_ni,
  input  logic next_valid_i,           // the next light
  output logic next_ready_o,
  input  job_t next_i,
  input  logic again_valid_i,          // a shadow ray goes on
  output logic again_ready_o,
  input  job_t again_i,
  output logic light_valid_o,          // to rc_light; its ready does not wait for valid
  input  logic light_ready_i,
  output job_t light_o,
  input  logic sec_wants_i,            // rc_secondary may start in this cycle, and has what for
  output logic sec_start_o             // it does
);
  logic       light_wants, sec_last_q;
  logic [1:0] job_req, job_gnt;
  logic [0:0] job_idx;
  assign job_req       = {again_valid_i, next_valid_i};
  assign light_wants   = job_req != '0 && light_ready_i;
  assign sec_start_o   = sec_wants_i && !(light_wants && sec_last_q);
  assign light_valid_o = job_req != '0 && !sec_start_o;
  assign light_o       = job_idx[0] ? again_i : next_i;
  assign {again_ready_o, next_ready_o} = job_gnt & {2{light_ready_i && !sec_start_o}};
  rc_rr_arb #(.NumReq(2)) u_jobs (
    .clk_i, .rst_ni, .req_i(job_req), .ready_i(light_ready_i && !sec_start_o), .gnt_o(job_gnt), .idx_o(job_idx)
  );
  always_ff @(posedge clk_i) begin
    if (!rst_ni) sec_last_q <= 1'b0;
    else if (sec_wants_i || light_wants) sec_last_q <= sec_start_o;
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) OneStarts_A: assert (!(sec_start_o && light_valid_o));
  end
`endif
endmodule
