// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Round-robin arbiter, combinational from req_i to the grant. After a grant was taken the next
// requester in index order comes first, so a requester waits for at most NumReq - 1 others.
module rc_rr_arb #(
  parameter  int unsigned NumReq = 4,
  localparam int unsigned IdxW   = (NumReq > 1) ? $clog2(NumReq) : 1
) (
  input  logic              clk_i,
  input  logic              rst_ni,
  input  logic [NumReq-1:0] req_i,
  input  logic              ready_i,   // the grant is taken in this cycle
  output logic [NumReq-1:0] gnt_o,     // one-hot, zero if nobody asks
  output logic [IdxW-1:0]   idx_o      // the same as a number
);
  logic [NumReq-1:0] after_q;          // requesters that come after the last one granted
  logic [NumReq-1:0] first;

  assign first = (req_i & after_q) != '0 ? req_i & after_q : req_i;
  assign gnt_o = first & (~first + 1'b1);   // lowest bit set
  always_comb begin
    idx_o = '0;
    for (int i = 0; i < NumReq; i++) if (gnt_o[i]) idx_o |= IdxW'(i);
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) after_q <= '0;
    else if (ready_i && gnt_o != '0) after_q <= ~(gnt_o | (gnt_o - 1'b1));
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    OneHot_A:  assert ($onehot0(gnt_o));
    Granted_A: assert ((gnt_o & ~req_i) == '0 && (gnt_o == '0) == (req_i == '0));
  end
`endif
endmodule
