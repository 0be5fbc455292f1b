// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Memory read port: lines of 64 bytes, or halves of them, for several clients over one AXI4 read channel, one burst
// a request, one ID, so that answers come in order. A client may stand for several: a tag comes back with the answer.
//   request   round robin; checked against the windows; noted in the order queue; to AR
//   answer    beats are put together; the line goes to the client at the head of the order queue
// Nothing a memory can answer hangs it: beats are counted, whatever RLAST says, and beats that
// nobody asked for are swallowed. A request outside the windows is not sent but answered with zeros.
module rc_mem_rd import rc_pkg::*; import rc_mem_pkg::*; #(
  parameter int unsigned NumClients = 4,
  parameter int unsigned TagW       = 1,     // bits
  parameter int unsigned NumWindows = 4,
  parameter int unsigned DataW      = 64,    // bits: 64, 128 or 256
  parameter int unsigned IdW        = 1,     // bits
  parameter int unsigned MaxBurst   = 16     // lines asked for and not yet answered, up to 64
) (
  input  logic                        clk_i,
  input  logic                        rst_ni,
  input  window_t [NumWindows-1:0]    window_i,      // constant while requests come
  input  logic                        stop_i,        // take no more requests
  output logic                        idle_o,        // nothing is outstanding
  output logic                        err_valid_o,   // for one cycle
  output err_t                        err_o,         // address of the line's first byte
  input  logic [NumClients-1:0]       req_valid_i,
  output logic [NumClients-1:0]       req_ready_o,
  input  line_addr_t [NumClients-1:0] req_addr_i,
  input  logic [NumClients-1:0][1:0]  req_halves_i,  // 01 the lower, 10 the upper, 11 both
  input  logic [NumClients-1:0][TagW-1:0] req_tag_i,
  output logic [NumClients-1:0]       rsp_valid_o,   // one-hot; per client in order of its requests
  output logic [TagW-1:0]             rsp_tag_o,     // of that request
  output block64_t                    rsp_block_o,   // of one half: in both places
  output logic [NumClients-1:0]       ev_line_o,     // a request goes to memory for this client
  output logic [TagW-1:0]             ev_tag_o,
  output logic [IdW-1:0]              m_axi_arid,
  output addr_t                       m_axi_araddr,
  output logic [7:0]                  m_axi_arlen,
  output logic [2:0]                  m_axi_arsize,
  output logic [1:0]                  m_axi_arburst,
  output logic                        m_axi_arvalid,
  input  logic                        m_axi_arready,
  input  logic [IdW-1:0]              m_axi_rid,
  input  logic [DataW-1:0]            m_axi_rdata,
  input  logic [1:0]                  m_axi_rresp,
  input  logic                        m_axi_rlast,
  input  logic                        m_axi_rvalid,
  output logic                        m_axi_rready
);
  localparam int unsigned BEATS   = LINE_B * 8 / DataW;
  localparam int unsigned BEAT_W  = $clog2(BEATS);
  localparam int unsigned WORDS   = DataW / 64;            // words a beat
  localparam int unsigned CLIENTW = (NumClients > 1) ? $clog2(NumClients) : 1;
  localparam int unsigned CNT_W   = $clog2(MaxBurst + 1);
  typedef struct packed {
    logic [CLIENTW-1:0] client;
    logic [TagW-1:0]    tag;
    logic               sent;                              // false: outside the windows
    logic               half;                              // only one
    half_addr_t         addr;
  } order_t;
  if (DataW != 64 && DataW != 128 && DataW != 256) begin : gen_bad_width
    $error("DataW must be 64, 128 or 256");
  end

  // ---- requests ------------------------------------------------------------------------------------
  logic [NumClients-1:0] gnt;
  logic [CLIENTW-1:0]    gnt_idx;
  logic [NumWindows-1:0] in_window;
  line_addr_t            gnt_addr;
  logic [1:0]            gnt_halves;
  order_t                order, head;
  logic                  may_take, order_ready, head_valid, head_done;
  logic [CNT_W-1:0]      unused_count;
  assign may_take = order_ready && !stop_i && (!m_axi_arvalid || m_axi_arready);
  assign gnt_addr   = req_addr_i[gnt_idx];
  assign gnt_halves = req_halves_i[gnt_idx];
  assign order      = '{client: gnt_idx, tag: req_tag_i[gnt_idx], sent: in_window != '0, half: gnt_halves != '1,
                        addr: {gnt_addr, gnt_halves == 2'b10}};
  rc_rr_arb #(.NumReq(NumClients)) u_arb (
    .clk_i, .rst_ni, .req_i(may_take ? req_valid_i : '0), .ready_i(1'b1), .gnt_o(gnt), .idx_o(gnt_idx)
  );
  assign req_ready_o = gnt;
  always_comb begin
    for (int w = 0; w < NumWindows; w++)
      in_window[w] = gnt_addr >= window_i[w].lo && {1'b0, gnt_addr} < window_i[w].hi;
  end
  rc_fifo #(.data_t(order_t), .Depth(MaxBurst), .Ram(1'b0)) u_order (
    .clk_i, .rst_ni,
    .in_valid_i(gnt != '0), .in_ready_o(order_ready), .in_data_i(order),
    .out_valid_o(head_valid), .out_ready_i(head_done), .out_data_o(head), .count_o(unused_count)
  );
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      m_axi_arvalid <= 1'b0;
      ev_line_o     <= '0;
    end else begin
      if (!m_axi_arvalid || m_axi_arready) m_axi_arvalid <= gnt != '0 && in_window != '0;
      ev_line_o <= (in_window != '0) ? gnt : '0;
    end
    if (gnt != '0) begin
      m_axi_araddr <= {order.addr, 5'b0};
      m_axi_arlen  <= order.half ? 8'(BEATS / 2 - 1) : 8'(BEATS - 1);
      ev_tag_o     <= order.tag;
    end
  end
  assign m_axi_arid    = '0;
  assign m_axi_arsize  = 3'($clog2(DataW / 8));
  assign m_axi_arburst = AXI_BURST_INCR;

  // ---- answers -------------------------------------------------------------------------------------
  logic [CNT_W-1:0]  sent_q;               // bursts that AR took and R has not finished
  logic [BEAT_W-1:0] beat_q;
  logic              outside, beat, expected, last_beat, last;
  assign outside      = head_valid && !head.sent;          // answered now, at the cost of one cycle
  assign m_axi_rready = !outside;
  assign beat         = m_axi_rvalid && m_axi_rready;
  assign expected     = sent_q != '0;
  assign last_beat    = beat_q == (head.half ? BEAT_W'(BEATS / 2 - 1) : BEAT_W'(BEATS - 1));
  assign last         = beat && expected && last_beat;
  assign head_done    = outside || last;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {sent_q, beat_q, rsp_valid_o} <= '0;
    end else begin
      sent_q <= sent_q + CNT_W'(m_axi_arvalid && m_axi_arready) - CNT_W'(last);
      if (beat && expected) beat_q <= last_beat ? '0 : beat_q + 1'b1;
      rsp_valid_o <= head_done ? NumClients'(1) << head.client : '0;
    end
    rsp_tag_o <= head.tag;
    for (int b = 0; b < BEATS; b++) begin
      for (int w = 0; w < WORDS; w++) begin
        if (outside) rsp_block_o[b * WORDS + w] <= '0;
        else if (beat && (beat_q == BEAT_W'(b) || (head.half && beat_q == BEAT_W'(b % (BEATS / 2)))))
          rsp_block_o[b * WORDS + w] <= m_axi_rdata[64 * w +: 64];
      end
    end
  end
  assign idle_o = !head_valid && rsp_valid_o == '0;

  // ---- errors: all are reported, the receiver latches the first -------------------------------------
  logic beat_bad;
  assign beat_bad = beat && (!expected || m_axi_rresp[1] || m_axi_rid != '0
                             || m_axi_rlast != last_beat);
  always_ff @(posedge clk_i) begin
    err_valid_o <= rst_ni && (beat_bad || (gnt != '0 && in_window == '0));
    if (beat_bad) begin
      err_o.code <= (m_axi_rresp == AXI_RESP_DECERR) ? ERR_DECERR : ERR_SLVERR;
      err_o.addr <= expected ? {head.addr, 5'b0} : '0;
    end else begin
      err_o.code <= ERR_WINDOW;
      err_o.addr <= {order.addr, 5'b0};
    end
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) begin
      // The answer belongs to the head: a burst under way has its entry there.
      if (expected && !outside) HeadIsSent_A: assert (head_valid && head.sent);
      OneClient_A: assert ($onehot0(rsp_valid_o));
      if ($past(rst_ni && m_axi_arvalid && !m_axi_arready))
        ArHeld_A: assert (m_axi_arvalid && $stable(m_axi_araddr) && $stable(m_axi_arlen));
      if (gnt != '0) SomeHalf_A: assert (gnt_halves != '0);
      if (beat_q != '0) MidBurst_A: assert (head_valid && head.sent);
    end
  end
`endif
endmodule
