// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Two-entry valid/ready register: cuts every combinational path, keeps one item per cycle.
module rc_skid #(parameter type data_t = logic [31:0]) (
  input  logic  clk_i,
  input  logic  rst_ni,
  input  logic  in_valid_i,
  output logic  in_ready_o,
  input  data_t in_data_i,
  output logic  out_valid_o,
  input  logic  out_ready_i,
  output data_t out_data_o
);
  logic  out_free, skid_valid_q;
  data_t skid_data_q;
  assign in_ready_o = !skid_valid_q;
  assign out_free   = !out_valid_o || out_ready_i;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {out_valid_o, skid_valid_q} <= '0;
    end else begin
      if (out_free) out_valid_o <= in_valid_i || skid_valid_q;
      skid_valid_q <= !out_free && (in_valid_i || skid_valid_q);
    end
    if (out_free) out_data_o <= skid_valid_q ? skid_data_q : in_data_i;
    if (!skid_valid_q) skid_data_q <= in_data_i;
  end
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && $past(rst_ni && in_valid_i && !in_ready_o))
      InHeld_M: assume (in_valid_i && $stable(in_data_i));
    if (rst_ni && $past(rst_ni && out_valid_o && !out_ready_i))
      OutHeld_A: assert (out_valid_o && $stable(out_data_o));
  end
`endif
endmodule
