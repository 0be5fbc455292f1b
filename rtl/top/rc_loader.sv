// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Before the first ray: reads lights (a line each) and materials (two lines each) into the tables of the
// shading units. They are few and every ray needs them, so they stay on the chip (docs/seams.md).
module rc_loader import rc_pkg::*; (
  input  logic       clk_i,
  input  logic       rst_ni,               // soft reset at the start of a frame
  input  logic       start_i,
  output logic       busy_o,               // from the cycle after start until the last line is given
  // set-up, constant while busy
  input  line_addr_t light_base_i,
  input  logic [4:0] light_count_i,
  input  line_addr_t mat_base_i,
  input  logic [8:0] mat_count_i,
  // memory
  output logic       req_valid_o,
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,
  input  line_t      rsp_line_i,
  // tables
  output logic       ld_valid_o,
  output ld_kind_e   ld_kind_o,
  output logic [7:0] ld_idx_o,
  output line_t      ld_line_o
);
  // One cursor for requests and one for answers: lights first, then materials.
  typedef struct packed {
    logic       mats;
    logic [8:0] idx;                       // light or material
    logic       second;                    // line of a material
  } cursor_t;
  cursor_t req_q, rsp_q;
  logic    req_busy_q, rsp_busy_q;

  function automatic logic is_last(cursor_t c, logic [8:0] mats);
    return c.mats && c.second && c.idx + 9'd1 == mats;
  endfunction

  function automatic cursor_t next(cursor_t c, logic [4:0] lights);
    if (c.mats && !c.second) return '{mats: 1'b1, idx: c.idx, second: 1'b1};
    if (!c.mats && c.idx + 9'd1 == 9'(lights)) return '{mats: 1'b1, idx: '0, second: 1'b0};
    return '{mats: c.mats, idx: c.idx + 9'd1, second: 1'b0};
  endfunction

  assign busy_o      = req_busy_q || rsp_busy_q;
  assign req_valid_o = req_busy_q;
  assign req_addr_o  = req_q.mats ? mat_base_i + LINE_ADDR_W'({req_q.idx, req_q.second})
                                  : light_base_i + LINE_ADDR_W'(req_q.idx);
  assign ld_valid_o  = rsp_valid_i;
  assign ld_kind_o   = !rsp_q.mats ? LD_LIGHT : rsp_q.second ? LD_OPTICS : LD_MATERIAL;
  assign ld_idx_o    = rsp_q.idx[7:0];
  assign ld_line_o   = rsp_line_i;

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {req_busy_q, rsp_busy_q} <= '0;
    end else if (start_i) begin
      {req_busy_q, rsp_busy_q} <= '1;
    end else begin
      if (req_valid_o && req_ready_i && is_last(req_q, mat_count_i)) req_busy_q <= 1'b0;
      if (rsp_valid_i && is_last(rsp_q, mat_count_i)) rsp_busy_q <= 1'b0;
    end
    if (start_i) begin
      req_q <= '{mats: light_count_i == '0, idx: '0, second: 1'b0};
      rsp_q <= '{mats: light_count_i == '0, idx: '0, second: 1'b0};
    end else begin
      if (req_valid_o && req_ready_i) req_q <= next(req_q, light_count_i);
      if (rsp_valid_i) rsp_q <= next(rsp_q, light_count_i);
    end
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && start_i) Count_M: assume (mat_count_i != '0 && !busy_o);
    if (rst_ni && rsp_valid_i) Asked_M: assume (rsp_busy_q && rsp_q != req_q);
  end
`endif
endmodule
