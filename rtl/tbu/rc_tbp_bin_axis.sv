// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Bins of the four slots on one axis: a triangle is counted where it enters and where it leaves; one a cycle, never stalls.
//   B0  distance from the first bin      B1  bin number, 0 below and the last above
//   B2  read both counters               B3  add one and write
// A read of a counter that is being written takes the new value from B3 (RAMs may not collide). Sweeping a slot reads its
// bins one a cycle, given one cycle later, and clears them. While it does so no triangle may come.
module rc_tbp_bin_axis import rc_pkg::*; import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; (
  input  logic      clk_i,
  input  logic      rst_ni,
  input  logic      fine_i,                          // 64 bins in two banks; constant while triangles come
  input  logic      in_valid_i,
  input  slot_t     in_slot_i,
  input  coord_t    in_base_i,                       // of the slot's bins
  input  shift_t    in_shift_i,
  input  coord_t    in_lo_i,
  input  coord_t    in_hi_i,
  output logic      busy_o,                          // triangles are on their way
  input  logic      sweep_i,
  input  slot_t     sweep_slot_i,
  input  bin_t      sweep_bin_i,
  output count_t    enter_o,                         // of the bin swept a cycle ago
  output count_t    leave_o
);
  localparam int unsigned DEPTH = NUM_SLOTS * BINS;
  typedef logic [$clog2(DEPTH)-1:0] addr_t;
  function automatic addr_t place(slot_t slot, bin_t bin, logic fine);
    return fine ? {slot[1], bin} : {slot, bin[4:0]};
  endfunction

  // ---- B0, B1 ----------------------------------------------------------------------------------------
  // The last unit that a triangle reaches is hi - 1; a planar one leaves in the bin that it enters.
  logic   b0_valid_q, b1_valid_q;
  slot_t  b0_slot_q;
  shift_t b0_shift_q;
  logic   b0_lo_neg_q, b0_hi_neg_q;
  coord_t b0_lo_q, b0_hi_q;
  bin_t   bin_last, lo_bin, hi_bin;
  coord_t lo_far, hi_far;
  addr_t  b1_enter_q, b1_leave_q;
  assign bin_last = fine_i ? bin_t'(2 * BINS - 1) : bin_t'(BINS - 1);
  assign lo_far   = b0_lo_q >> b0_shift_q;
  assign hi_far   = b0_hi_q >> b0_shift_q;
  assign lo_bin   = b0_lo_neg_q ? '0 : (lo_far > coord_t'(bin_last)) ? bin_last : bin_t'(lo_far);
  assign hi_bin   = b0_hi_neg_q ? '0 : (hi_far > coord_t'(bin_last)) ? bin_last : bin_t'(hi_far);
  always_ff @(posedge clk_i) begin
    {b1_valid_q, b0_valid_q} <= rst_ni ? {b0_valid_q, in_valid_i} : '0;
    b0_slot_q   <= in_slot_i;
    b0_shift_q  <= in_shift_i;
    b0_lo_neg_q <= in_lo_i < in_base_i;
    b0_hi_neg_q <= in_hi_i <= in_base_i;
    b0_lo_q     <= in_lo_i - in_base_i;
    b0_hi_q     <= in_hi_i - in_base_i - 1'b1;
    b1_enter_q  <= place(b0_slot_q, lo_bin, fine_i);
    b1_leave_q  <= place(b0_slot_q, (hi_bin > lo_bin) ? hi_bin : lo_bin, fine_i);
  end

  // ---- B2, B3: the same for both counters ----------------------------------------------------------------
  logic  b2_valid_q, swept_q;
  addr_t sweep_addr, swept_addr_q;
  assign sweep_addr = place(sweep_slot_i, sweep_bin_i, fine_i);
  assign busy_o     = b0_valid_q || b1_valid_q || b2_valid_q;
  always_ff @(posedge clk_i) begin
    {b2_valid_q, swept_q} <= rst_ni ? {b1_valid_q, sweep_i} : '0;
    swept_addr_q <= sweep_addr;
  end
  addr_t  [1:0] b1_addr, b2_addr_q;
  count_t [1:0] rdata, count;
  assign b1_addr = {b1_leave_q, b1_enter_q};
  for (genvar c = 0; c < 2; c++) begin : gen_counter
    logic   b2_fwd_q, fwd;
    count_t b2_new_q, sum;
    assign fwd   = b1_valid_q && b2_valid_q && b1_addr[c] == b2_addr_q[c];
    assign count[c] = b2_fwd_q ? b2_new_q : rdata[c];
    assign sum   = count[c] + 1'b1;
    always_ff @(posedge clk_i) begin
      b2_fwd_q     <= rst_ni && fwd;
      b2_new_q     <= sum;
      b2_addr_q[c] <= b1_addr[c];
    end
    rc_ram_1r1w #(.Width(COUNT_W), .Depth(DEPTH)) u_ram (
      .clk_i,
      .we_i(b2_valid_q || swept_q), .waddr_i(swept_q ? swept_addr_q : b2_addr_q[c]), .wdata_i(swept_q ? '0 : sum),
      .re_i((b1_valid_q && !fwd) || sweep_i), .raddr_i(sweep_i ? sweep_addr : b1_addr[c]), .rdata_o(rdata[c])
    );
  end
  assign {leave_o, enter_o} = rdata;
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && (sweep_i || swept_q)) Apart_M: assume (!b1_valid_q && !b2_valid_q);
  end
`endif
endmodule
