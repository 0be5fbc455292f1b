// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Jobs to sorting pipelines that are free: from the loader, and from other pipelines that donate a subtree, one of them at a
// time (paper Sec. 3.7 has no donation). A job holds its way until its last reference is through; both ways run at the same
// time, a reference a cycle each. want_o invites donations: a pipeline is free, no job waits, the bus is free.
module rc_tbu_route import rc_tbu_pkg::*; #(
  localparam int unsigned N = NUM_SORTERS
) (
  input  logic      clk_i,
  input  logic      rst_ni,
  input  logic      load_waiting_i,                  // jobs of the loader come first
  input  logic      load_valid_i,
  output logic      load_ready_o,
  input  sort_job_t load_job_i,
  input  logic      load_ref_valid_i,
  output logic      load_ref_ready_o,
  input  tri_ref_t  load_ref_i,
  output logic      want_o,
  input  logic      [N-1:0] don_valid_i,
  output logic      [N-1:0] don_ready_o,
  input  sort_job_t [N-1:0] don_job_i,
  input  logic      [N-1:0] don_ref_valid_i,
  output logic      [N-1:0] don_ref_ready_o,
  input  tri_ref_t  [N-1:0] don_ref_i,
  output logic      [N-1:0] job_valid_o,             // to the pipelines
  input  logic      [N-1:0] job_ready_i,
  output sort_job_t [N-1:0] job_o,
  output logic      [N-1:0] ref_valid_o,
  input  logic      [N-1:0] ref_ready_i,
  output tri_ref_t  [N-1:0] ref_o
);
  localparam int unsigned IdW = $clog2(N);
  typedef logic [IdW-1:0] id_t;
  count_t       load_left_q, don_left_q;             // references to come; 0: the way is free
  id_t          load_to_q, don_to_q, don_from_q;
  logic [N-1:0] load_gnt, don_gnt, don_to;
  id_t          load_sel, don_from, don_to_sel;
  logic         load_free, don_free, load_fire, don_fire;
  assign load_free = load_left_q == '0;
  assign don_free  = don_left_q == '0;

  rc_rr_arb #(.NumReq(N)) u_load (
    .clk_i, .rst_ni, .req_i(load_free ? job_ready_i : '0), .ready_i(load_valid_i), .gnt_o(load_gnt), .idx_o(load_sel)
  );
  assign load_fire    = load_valid_i && load_gnt != '0;
  assign load_ready_o = load_gnt != '0;

  // A donor goes on as soon as another pipeline than the loader's is free.
  rc_rr_arb #(.NumReq(N)) u_donor (
    .clk_i, .rst_ni, .req_i(don_free ? don_valid_i : '0), .ready_i(don_fire), .gnt_o(don_gnt), .idx_o(don_from)
  );
  assign don_to   = job_ready_i & ~(load_valid_i ? load_gnt : '0);
  assign don_fire = don_gnt != '0 && don_to != '0;
  always_comb begin
    don_to_sel = '0;
    for (int i = N - 1; i >= 0; i--) if (don_to[i]) don_to_sel = id_t'(i);
  end
  assign want_o = job_ready_i != '0 && !load_waiting_i && don_free && don_valid_i == '0;

  always_comb begin
    for (int i = 0; i < N; i++) begin
      automatic logic from_load = load_fire && load_gnt[i];
      automatic logic loading   = !load_free && load_to_q == id_t'(i);
      automatic logic donating  = !don_free && don_to_q == id_t'(i);
      job_valid_o[i] = from_load || (don_fire && don_to_sel == id_t'(i));
      job_o[i]       = from_load ? load_job_i : don_job_i[don_from];
      ref_valid_o[i] = (loading && load_ref_valid_i) || (donating && don_ref_valid_i[don_from_q]);
      ref_o[i]       = loading ? load_ref_i : don_ref_i[don_from_q];
      don_ready_o[i]     = don_fire && don_gnt[i];
      don_ref_ready_o[i] = !don_free && don_from_q == id_t'(i) && ref_ready_i[don_to_q];
    end
    load_ref_ready_o = !load_free && ref_ready_i[load_to_q];
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {load_left_q, don_left_q} <= '0;
    end else begin
      if (load_fire) load_left_q <= load_job_i.count;
      else if (load_ref_valid_i && load_ref_ready_o) load_left_q <= load_left_q - 1'b1;
      if (don_fire) don_left_q <= don_job_i[don_from].count;
      else if (!don_free && don_ref_valid_i[don_from_q] && ref_ready_i[don_to_q]) don_left_q <= don_left_q - 1'b1;
    end
    if (load_fire) load_to_q <= load_sel;
    if (don_fire) {don_from_q, don_to_q} <= {don_from, don_to_sel};
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && load_fire) LoadCount_M: assume (load_job_i.count != '0);
    if (rst_ni && don_fire) DonCount_M: assume (don_job_i[don_from].count != '0);
    if (rst_ni && !load_free && !don_free) Apart_A: assert (load_to_q != don_to_q);
  end
`endif
endmodule
