// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Stand-in for the ray-tracing unit with its ports, to test what is around it. For each block of pixels it
// reads the upper half of a line of nodes, a line of triangle information, of texture coordinates and a block of
// textures, then "traces" one ray a pixel and paints
//   pixel (x, y) = low 32 bits of (node word 4 + info word 0 + last light word 0 + last material's words 0, optics too
//                  + uv word 1 + root) + high 32 bits of texture word 7, ^ {y, x}
// node word 7 = 1 reports ERR_NODE with the low bits of word 6; 2 asks for a line outside all windows;
// 3 stops for ever; 4 asks for the line at the address in word 6.
module rc_rtu import rc_pkg::*; #(
  parameter int unsigned NtSets   = 2,       // it has no caches
  parameter int unsigned ListSets = 2,
  parameter int unsigned L2Sets   = 2,
  parameter int unsigned L2Ways   = 2
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  tree_cfg_t        tree_i,
  input  camera_t          camera_i,
  input  shade_cfg_t       shade_i,
  input  frame_cfg_t       frame_i,
  input  logic             blk_valid_i,
  output logic             blk_ready_o,
  input  block_t           blk_i,
  input  logic             ld_valid_i,
  input  ld_kind_e         ld_kind_i,
  input  logic [7:0]       ld_idx_i,
  input  line_t            ld_line_i,
  output logic             tni_req_valid_o,
  input  logic             tni_req_ready_i,
  output half_addr_t       tni_req_addr_o,
  input  logic             tni_rsp_valid_i,
  input  half_line_t       tni_rsp_half_i,
  output logic             tri_req_valid_o,
  input  logic             tri_req_ready_i,
  output line_addr_t       tri_req_addr_o,
  input  logic             tri_rsp_valid_i,
  input  line_t            tri_rsp_line_i,
  output logic             uv_req_valid_o,
  input  logic             uv_req_ready_i,
  output line_addr_t       uv_req_addr_o,
  input  logic             uv_rsp_valid_i,
  input  line_t            uv_rsp_line_i,
  output logic             tex_req_valid_o,
  input  logic             tex_req_ready_i,
  output line_addr_t       tex_req_addr_o,
  input  logic             tex_rsp_valid_i,
  input  block64_t         tex_rsp_block_i,
  output logic             wr_valid_o,
  input  logic             wr_ready_i,
  output addr_t            wr_addr_o,
  output logic [7:0][31:0] wr_data_o,
  output logic [7:0]       wr_strb_o,
  output logic             err_valid_o,
  output err_t             err_o,
  output logic             idle_o,
  output rtu_ev_t          ev_o,
  output trace_t           trace_o
);
  typedef enum logic [2:0] {WAIT, ASK, ANSWER, RAYS, ROWS, HANG} state_e;
  state_e state_q;
  block_t blk_q;
  line_t  node_q;
  logic [31:0] info_q, light_q, mat_q, optics_q, uv_q, tex_q, colour;
  logic [3:0]  asked_q, answered_q;
  logic [5:0]  n_q;                        // ray in the block
  logic [2:0]  row_q;
  logic        outside_q;
  line_addr_t  node_lines, line_no;
  logic        hit_q;
  ray_id_t     id_q;

  logic [15:0] x0, y;
  assign x0         = {blk_q.x, 3'b0};
  assign y          = {blk_q.y, row_q};
  assign node_lines = LINE_ADDR_W'(tree_i.node_count >> 3);
  assign colour     = 32'(tree_i.root) + node_q[4][31:0] + info_q + light_q + mat_q + optics_q + uv_q + tex_q;

  assign blk_ready_o     = state_q == WAIT;
  assign idle_o          = state_q == WAIT;
  assign tni_req_valid_o = state_q == ASK && !asked_q[0];
  assign line_no         = (LINE_ADDR_W'(tree_i.root >> 3) + LINE_ADDR_W'(blk_q.x) + LINE_ADDR_W'(blk_q.y)) % node_lines;
  assign tni_req_addr_o  = !outside_q           ? {tree_i.node_base + line_no, 1'b1} :
                           node_q[7] == 60'd4   ? {node_q[6][LINE_ADDR_W-1:0], 1'b1} : '1;
  assign tri_req_valid_o = state_q == ASK && !asked_q[1];
  assign tri_req_addr_o  = shade_i.info_base + LINE_ADDR_W'(blk_q.x) % LINE_ADDR_W'(tree_i.tri_count);
  assign uv_req_valid_o  = state_q == ASK && !asked_q[2];
  assign uv_req_addr_o   = shade_i.uv_base + LINE_ADDR_W'(blk_q.y[0]);
  assign tex_req_valid_o = state_q == ASK && !asked_q[3];
  assign tex_req_addr_o  = shade_i.tex_base + LINE_ADDR_W'(blk_q.x[1:0]);
  assign wr_valid_o      = state_q == ROWS;
  assign wr_addr_o       = {frame_i.fb_base, 6'b0} + 32'(y) * {8'b0, frame_i.fb_stride, 5'b0} + {14'b0, x0, 2'b0};
  always_comb begin
    for (int i = 0; i < 8; i++) begin
      wr_data_o[i] = colour ^ {y, x0 + 16'(i)};
      wr_strb_o[i] = (x0 + 16'(i) < frame_i.width) && (y < frame_i.height);
    end
    trace_o                 = '0;
    trace_o.pri_valid       = state_q == RAYS;
    trace_o.pri             = '{id: {2'b0, n_q}, x: x0 + 16'(n_q[2:0]), y: {blk_q.y, n_q[5:3]}};
    ev_o                    = '0;
    ev_o.pri                = state_q == RAYS;
    ev_o.tni[0].ray_in      = state_q == RAYS;
    ev_o.tni[0].ray_out     = trace_o.hit_valid;
    ev_o.tni[3].trav2       = state_q == RAYS;
    ev_o.tni[2].trav2       = state_q == RAYS;
    trace_o.hit_valid       = hit_q;
    trace_o.hit             = '{id: id_q, any_hit: 1'b0, hit: 1'b1, surf: surf_t'(id_q), t: FP_ONE, default: '0};
    ev_o.tni[0].ray_out     = hit_q;
  end

  always_ff @(posedge clk_i) begin
    hit_q <= rst_ni && state_q == RAYS;
    id_q  <= {2'b0, n_q};
    err_valid_o <= 1'b0;
    err_o <= '{code: ERR_NODE, addr: node_q[6][31:0]};
    if (ld_valid_i && ld_kind_i == LD_LIGHT && 5'(ld_idx_i) + 5'd1 == shade_i.light_count) light_q <= ld_line_i[0][31:0];
    if (ld_valid_i && ld_kind_i == LD_MATERIAL && 9'(ld_idx_i) + 9'd1 == shade_i.mat_count) mat_q <= ld_line_i[0][31:0];
    if (ld_valid_i && ld_kind_i == LD_OPTICS && 9'(ld_idx_i) + 9'd1 == shade_i.mat_count) optics_q <= ld_line_i[0][31:0];
    if (!rst_ni) begin
      state_q <= WAIT;
      {light_q, mat_q, optics_q} <= '0;
    end else begin
      if (tni_req_valid_o && tni_req_ready_i) asked_q[0] <= 1'b1;
      if (tri_req_valid_o && tri_req_ready_i) asked_q[1] <= 1'b1;
      if (uv_req_valid_o && uv_req_ready_i) asked_q[2] <= 1'b1;
      if (tex_req_valid_o && tex_req_ready_i) asked_q[3] <= 1'b1;
      if (uv_rsp_valid_i) begin
        answered_q[2] <= 1'b1;
        uv_q          <= uv_rsp_line_i[1][31:0];
      end
      if (tex_rsp_valid_i) begin
        answered_q[3] <= 1'b1;
        tex_q         <= tex_rsp_block_i[7][63:32];
      end
      if (tni_rsp_valid_i) begin
        answered_q[0] <= 1'b1;
        node_q        <= {tni_rsp_half_i, {$bits(half_line_t){1'b0}}};
      end
      if (tri_rsp_valid_i) begin
        answered_q[1] <= 1'b1;
        info_q        <= tri_rsp_line_i[0][31:0];
      end
      unique case (state_q)
        WAIT: if (blk_valid_i) begin
          state_q <= ASK;
          blk_q   <= blk_i;
          {asked_q, answered_q, n_q, row_q, outside_q} <= '0;
        end
        ASK: if (&asked_q) state_q <= ANSWER;
        ANSWER: if (&answered_q) begin
          state_q <= RAYS;
          err_valid_o <= node_q[7] == 60'd1;
          if ((node_q[7] == 60'd2 || node_q[7] == 60'd4) && !outside_q) begin
            state_q   <= ASK;
            {asked_q, answered_q} <= '0;
            outside_q <= 1'b1;
          end
          if (node_q[7] == 60'd3) state_q <= HANG;
        end
        RAYS: begin
          n_q <= n_q + 6'd1;
          if (&n_q) state_q <= ROWS;
        end
        ROWS: if (wr_ready_i) begin
          row_q <= row_q + 3'd1;
          if (&row_q) state_q <= WAIT;
        end
        default: ;
      endcase
    end
  end

  logic unused;
  assign unused = ^{camera_i, tree_i, shade_i, node_q, tri_rsp_line_i, uv_rsp_line_i, tex_rsp_block_i, ld_line_i, frame_i};
endmodule
