// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Counts what happens in a frame (docs/registers.md, 0x100 and up).
//   P1  number of events of a kind in this cycle, in all RTUs
//   P2  added up, 32 bits each
module rc_counters import rc_pkg::*, rc_top_pkg::*; #(
  parameter int unsigned NumRtus = 1
) (
  input  logic                      clk_i,
  input  logic                      rst_ni,
  input  logic                      clear_i,
  input  logic                      count_i,       // a frame runs
  input  rtu_ev_t [NumRtus-1:0]     rtu_ev_i,
  input  logic [NUM_RD_TAGS-1:0]    line_i,        // an RTU asks memory for a line, by whom it is for
  input  logic                      line_loader_i, // the loader does
  input  logic                      rd_stall_i,    // a read address waited
  input  logic                      row_i,         // a row went to the frame buffer
  output counters_t                 counters_o
);
  localparam int unsigned RTU_W = $clog2(NumRtus);
  typedef logic [4+RTU_W:0] inc_t;
  typedef logic [8+RTU_W:0] flight_t;
  inc_t [NUM_COUNTERS-1:0] p1_inc_d, p1_inc_q;

  inc_t       rays_in, rays_out;
  flight_t    flight_d, flight_q;                  // rays in the T&I units, at most 256 each
  logic [3:0] frac_q;                              // of their sum, in 1/16
  flight_t    flight_sum;
  assign flight_d   = flight_q + flight_t'(rays_in) - flight_t'(rays_out);
  assign flight_sum = flight_q + flight_t'(frac_q);

  always_comb begin
    p1_inc_d                     = '0;
    {rays_in, rays_out}          = '0;
    p1_inc_d[CNT_CYCLES]         = inc_t'(1);
    for (int r = 0; r < int'(NumRtus); r++) begin
      p1_inc_d[CNT_RAYS_PRIMARY]   += inc_t'(rtu_ev_i[r].pri);
      p1_inc_d[CNT_RAYS_SHADOW]    += inc_t'(rtu_ev_i[r].shadow);
      p1_inc_d[CNT_RAYS_CULLED]    += inc_t'(rtu_ev_i[r].culled);
      p1_inc_d[CNT_RAYS_REFLECT]   += inc_t'(rtu_ev_i[r].reflect);
      p1_inc_d[CNT_RAYS_TRANSMIT]  += inc_t'(rtu_ev_i[r].transmit);
      for (int p = 0; p < 4; p++) begin
        p1_inc_d[CNT_SLOTS_BOX]       += inc_t'(rtu_ev_i[r].tni[p].box);
        p1_inc_d[CNT_SLOTS_TRAV1]     += inc_t'(rtu_ev_i[r].tni[p].trav1);
        p1_inc_d[CNT_SLOTS_TRAV2]     += inc_t'(rtu_ev_i[r].tni[p].trav2);
        p1_inc_d[CNT_SLOTS_ISECT]     += inc_t'(rtu_ev_i[r].tni[p].isect);
        p1_inc_d[CNT_SLOTS_MISS_NT]   += inc_t'(rtu_ev_i[r].tni[p].miss_nt);
        p1_inc_d[CNT_SLOTS_MISS_LIST] += inc_t'(rtu_ev_i[r].tni[p].miss_list);
        p1_inc_d[CNT_SLOTS_BUBBLE]    += inc_t'(rtu_ev_i[r].tni[p].bubble);
        p1_inc_d[CNT_NT_HITS]         += inc_t'(rtu_ev_i[r].tni[p].nt_hit);
        p1_inc_d[CNT_LIST_HITS]       += inc_t'(rtu_ev_i[r].tni[p].list_hit);
        rays_in                       += inc_t'(rtu_ev_i[r].tni[p].ray_in);
        rays_out                      += inc_t'(rtu_ev_i[r].tni[p].ray_out);
      end
      p1_inc_d[CNT_L2_HITS]        += inc_t'(rtu_ev_i[r].l2_hit);
      p1_inc_d[CNT_L2_MISSES]      += inc_t'(rtu_ev_i[r].l2_miss);
      p1_inc_d[CNT_TRI_HITS]       += inc_t'(rtu_ev_i[r].tri_hit);
      p1_inc_d[CNT_TRI_MISSES]     += inc_t'(rtu_ev_i[r].tri_miss);
      p1_inc_d[CNT_UV_HITS]        += inc_t'(rtu_ev_i[r].uv_hit);
      p1_inc_d[CNT_UV_MISSES]      += inc_t'(rtu_ev_i[r].uv_miss);
      p1_inc_d[CNT_TEX_HITS]       += inc_t'(rtu_ev_i[r].tex_hit);
      p1_inc_d[CNT_TEX_MISSES]     += inc_t'(rtu_ev_i[r].tex_miss);
    end
    p1_inc_d[CNT_LINES_TNI]      = inc_t'(line_i[RD_TNI]);
    p1_inc_d[CNT_LINES_TRI]      = inc_t'(line_i[RD_TRI]);
    p1_inc_d[CNT_LINES_UV]       = inc_t'(line_i[RD_UV]);
    p1_inc_d[CNT_LINES_TEX]      = inc_t'(line_i[RD_TEX]);
    p1_inc_d[CNT_LINES_LOADER]   = inc_t'(line_loader_i);
    p1_inc_d[CNT_FB_ROWS]        = inc_t'(row_i);
    p1_inc_d[CNT_RD_STALL]       = inc_t'(rd_stall_i);
    p1_inc_d[CNT_RAYS_IN_FLIGHT] = flight_sum[8+RTU_W:4];
  end

  always_ff @(posedge clk_i) begin
    p1_inc_q <= (rst_ni && count_i && !clear_i) ? p1_inc_d : '0;
    flight_q <= (rst_ni && !clear_i) ? flight_d : '0;
    if (!rst_ni || clear_i) frac_q <= '0;
    else if (count_i) frac_q <= flight_sum[3:0];
    for (int c = 0; c < int'(NUM_COUNTERS); c++) begin
      if (!rst_ni || clear_i) counters_o[c] <= '0;
      else counters_o[c] <= counters_o[c] + 32'(p1_inc_q[c]);
    end
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && count_i && !clear_i) Flight_A: assert (flight_q <= flight_t'(256 * NumRtus));
  end
`endif
endmodule
