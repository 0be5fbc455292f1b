// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Memory write port: rows of eight pixels (32 bytes) over the AXI4 write channels, a burst a row,
// several bursts outstanding, answers in order. A row without a pixel to write is left out: it may
// lie below the picture, outside its window.
module rc_mem_wr import rc_pkg::*; import rc_mem_pkg::*; #(
  parameter int unsigned NumWindows = 1,
  parameter int unsigned DataW      = 64,    // bits: 64, 128 or 256
  parameter int unsigned IdW        = 1,     // bits
  parameter int unsigned MaxBurst   = 16     // rows sent and not yet confirmed
) (
  input  logic                     clk_i,
  input  logic                     rst_ni,
  input  window_t [NumWindows-1:0] window_i,     // constant while rows come
  input  logic                     stop_i,       // take no more rows
  output logic                     idle_o,       // nothing is outstanding
  output logic                     err_valid_o,  // for one cycle
  output err_t                     err_o,        // address of the row's first byte
  input  logic                     wr_valid_i,
  output logic                     wr_ready_o,
  input  addr_t                    wr_addr_i,    // multiple of 32
  input  logic [7:0][31:0]         wr_data_i,
  input  logic [7:0]               wr_strb_i,    // a bit a pixel
  output logic                     ev_row_o,     // a row is sent
  output logic                     ack_o,        // a row was answered, good or bad; in order
  output logic [IdW-1:0]           m_axi_awid,
  output addr_t                    m_axi_awaddr,
  output logic [7:0]               m_axi_awlen,
  output logic [2:0]               m_axi_awsize,
  output logic [1:0]               m_axi_awburst,
  output logic                     m_axi_awvalid,
  input  logic                     m_axi_awready,
  output logic [DataW-1:0]         m_axi_wdata,
  output logic [DataW/8-1:0]       m_axi_wstrb,
  output logic                     m_axi_wlast,
  output logic                     m_axi_wvalid,
  input  logic                     m_axi_wready,
  input  logic [IdW-1:0]           m_axi_bid,
  input  logic [1:0]               m_axi_bresp,
  input  logic                     m_axi_bvalid,
  output logic                     m_axi_bready
);
  localparam int unsigned BEATS  = 256 / DataW;
  localparam int unsigned BEAT_W = (BEATS > 1) ? $clog2(BEATS) : 1;
  localparam int unsigned PIXELS = DataW / 32;             // a beat
  if (DataW != 64 && DataW != 128 && DataW != 256) begin : gen_bad_width
    $error("DataW must be 64, 128 or 256");
  end

  // ---- take a row ------------------------------------------------------------------------------------
  logic                  take, inside_any, send, open_ready;
  logic [NumWindows-1:0] in_window;
  line_addr_t            wr_line;
  assign wr_line    = wr_addr_i[ADDR_W-1:$clog2(LINE_B)];
  assign wr_ready_o = !m_axi_awvalid && !m_axi_wvalid && open_ready && !stop_i;
  assign take       = wr_valid_i && wr_ready_o && wr_strb_i != '0;
  assign inside_any = in_window != '0;
  assign send       = take && inside_any;
  assign ev_row_o   = send;
  always_comb begin
    for (int w = 0; w < NumWindows; w++)
      in_window[w] = wr_line >= window_i[w].lo && {1'b0, wr_line} < window_i[w].hi;
  end

  // ---- send it: address and data go independently ------------------------------------------------------
  logic [BEATS-1:0][DataW-1:0]  data_q;    // the beat to send is the lowest
  logic [BEATS-1:0][PIXELS-1:0] strb_q;
  logic [BEAT_W-1:0]            beat_q;
  assign m_axi_awid    = '0;
  assign m_axi_awlen   = 8'(BEATS - 1);
  assign m_axi_awsize  = 3'($clog2(DataW / 8));
  assign m_axi_awburst = AXI_BURST_INCR;
  assign m_axi_wdata   = data_q[0];
  assign m_axi_wlast   = beat_q == BEAT_W'(BEATS - 1);
  always_comb for (int p = 0; p < PIXELS; p++) m_axi_wstrb[4 * p +: 4] = {4{strb_q[0][p]}};
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {m_axi_awvalid, m_axi_wvalid, beat_q} <= '0;
    end else begin
      if (send) begin
        {m_axi_awvalid, m_axi_wvalid} <= '1;
        beat_q <= '0;
      end else begin
        if (m_axi_awready) m_axi_awvalid <= 1'b0;
        if (m_axi_wvalid && m_axi_wready) begin
          beat_q       <= beat_q + 1'b1;
          m_axi_wvalid <= !m_axi_wlast;
        end
      end
    end
    if (send) begin
      m_axi_awaddr <= wr_addr_i;
      data_q       <= wr_data_i;
      strb_q       <= wr_strb_i;
    end else if (m_axi_wready) begin
      data_q <= data_q >> DataW;
      strb_q <= strb_q >> PIXELS;
    end
  end

  // ---- answers -------------------------------------------------------------------------------------------
  addr_t open_addr;
  logic  open_valid, answer_bad;
  logic [$clog2(MaxBurst+1)-1:0] unused_count;
  rc_fifo #(.data_t(addr_t), .Depth(MaxBurst), .Ram(1'b0)) u_open (
    .clk_i, .rst_ni,
    .in_valid_i(send), .in_ready_o(open_ready), .in_data_i(wr_addr_i),
    .out_valid_o(open_valid), .out_ready_i(m_axi_bvalid), .out_data_o(open_addr), .count_o(unused_count)
  );
  assign m_axi_bready = 1'b1;
  assign idle_o       = !open_valid && !m_axi_awvalid && !m_axi_wvalid;
  assign answer_bad   = m_axi_bvalid && (!open_valid || m_axi_bresp[1] || m_axi_bid != '0);
  always_ff @(posedge clk_i) begin
    ack_o       <= rst_ni && m_axi_bvalid && open_valid;
    err_valid_o <= rst_ni && (answer_bad || (take && !inside_any));
    if (answer_bad) begin
      err_o.code <= (m_axi_bresp == AXI_RESP_DECERR) ? ERR_DECERR : ERR_SLVERR;
      err_o.addr <= open_valid ? open_addr : '0;
    end else begin
      err_o.code <= ERR_WINDOW;
      err_o.addr <= wr_addr_i;
    end
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      if (wr_valid_i) Aligned_M: assume (wr_addr_i[4:0] == '0);
      if ($past(rst_ni && m_axi_awvalid && !m_axi_awready))
        AwHeld_A: assert (m_axi_awvalid && $stable(m_axi_awaddr));
      if ($past(rst_ni && m_axi_wvalid && !m_axi_wready))
        WHeld_A: assert (m_axi_wvalid && $stable(m_axi_wdata) && $stable(m_axi_wstrb));
    end
  end
`endif
endmodule
