// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The caches of one ray-tracing unit as one client of the read port, served in turn; the tag says whom an answer is for.
// So the port's arbiter and multiplexer grow by one input an RTU, and RTUs share it evenly however many caches ask.
//   Cut = 0  combinational, as if the caches were the port's own clients
//   Cut = 1  a register in the request: its arbiter and the port's are apart, a request takes a cycle more
module rc_rtu_port import rc_pkg::*; import rc_top_pkg::*; #(
  parameter bit Cut = 1'b0
) (
  input  logic                         clk_i,
  input  logic                         rst_ni,
  input  logic       [NUM_RD_TAGS-1:0] req_valid_i,     // from the caches, by tag
  output logic       [NUM_RD_TAGS-1:0] req_ready_o,
  input  half_addr_t                   tni_addr_i,      // the L2 cache asks for halves, the others for lines
  input  line_addr_t                   tri_addr_i,
  input  line_addr_t                   uv_addr_i,
  input  line_addr_t                   tex_addr_i,
  output logic       [NUM_RD_TAGS-1:0] rsp_valid_o,
  output logic                         port_valid_o,    // to the port
  input  logic                         port_ready_i,
  output line_addr_t                   port_addr_o,
  output logic       [1:0]             port_halves_o,
  output rd_tag_t                      port_tag_o,
  input  logic                         port_rsp_valid_i,
  input  rd_tag_t                      port_rsp_tag_i
);
  typedef struct packed {
    rd_tag_t    tag;
    logic [1:0] halves;
    line_addr_t addr;
  } req_t;
  req_t [NUM_RD_TAGS-1:0] reqs;
  req_t                   req, port;
  logic                   ready;
  rd_tag_t                idx;
  logic [NUM_RD_TAGS-1:0] gnt;

  always_comb begin
    reqs[RD_TNI] = '{tag: RD_TNI, halves: {tni_addr_i[0], !tni_addr_i[0]}, addr: tni_addr_i[HALF_ADDR_W-1:1]};
    reqs[RD_TRI] = '{tag: RD_TRI, halves: '1, addr: tri_addr_i};
    reqs[RD_UV]  = '{tag: RD_UV,  halves: '1, addr: uv_addr_i};
    reqs[RD_TEX] = '{tag: RD_TEX, halves: '1, addr: tex_addr_i};
  end
  rc_rr_arb #(.NumReq(NUM_RD_TAGS)) u_arb (
    .clk_i, .rst_ni, .req_i(req_valid_i), .ready_i(ready), .gnt_o(gnt), .idx_o(idx)
  );
  assign req         = reqs[idx];
  assign req_ready_o = ready ? gnt : '0;

  if (Cut) begin : gen_cut
    rc_skid #(.data_t(req_t)) u_cut (
      .clk_i, .rst_ni, .in_valid_i(ready && gnt != '0), .in_ready_o(ready), .in_data_i(req),
      .out_valid_o(port_valid_o), .out_ready_i(port_ready_i), .out_data_o(port)
    );
  end else begin : gen_direct
    assign port_valid_o = gnt != '0;
    assign port         = req;
    assign ready        = port_ready_i;
  end
  assign {port_tag_o, port_halves_o, port_addr_o} = port;

  assign rsp_valid_o = port_rsp_valid_i ? NUM_RD_TAGS'(1) << port_rsp_tag_i : '0;
endmodule
