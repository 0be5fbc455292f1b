// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Life of a frame: check the set-up, build the tree and make records, reset the ray-tracing units, load lights and materials, trace,
// end. Building, making records, or all that follows, may be left out. The first error stops the memory ports; when they are quiet the units are reset and the
// frame ends with that error, so nothing that waits for an answer is ever reset (docs/seams.md).
module rc_frame_ctrl import rc_pkg::*; import rc_top_pkg::*; #(
  parameter int unsigned NumErr = 4              // sources of errors; a lower one wins a tie
) (
  input  logic              clk_i,
  input  logic              rst_ni,
  input  logic              render_i,            // start: a picture, a tree, or both; ignored while busy
  input  logic              build_i,
  input  logic              accel_i,             // make records, beside the tree or alone
  output status_t           status_o,
  output logic              end_o,               // with the final status, one cycle
  output logic              clear_o,             // a frame begins, one cycle
  output logic              count_o,             // a frame runs
  input  logic              bad_i,               // the set-up makes no sense
  input  addr_t             bad_reg_i,
  input  logic [NumErr-1:0] err_valid_i,
  input  err_t [NumErr-1:0] err_i,
  output logic              render_o,            // what this frame does
  output logic              build_o,
  output logic              accel_o,
  output logic              unit_rst_no,         // soft reset of the ray-tracing units; not of the memory ports
  output logic              build_rst_no,        // of the builders; their results stay until the next frame
  output logic              stop_o,              // memory ports: take no more requests
  output logic              build_start_o,
  output logic              accel_start_o,
  output logic              building_o,          // the memory ports are the builders'
  input  logic              build_done_i,
  input  logic              accel_done_i,
  output logic              load_start_o,
  input  logic              load_busy_i,
  output logic              trace_start_o,
  input  logic              units_idle_i,        // all blocks sent, nothing in the units
  input  logic              ports_idle_i         // nothing outstanding in the memory ports
);
  typedef enum logic [2:0] {IDLE, CHECK, BUILD, LOAD, TRACE, STOP, END} state_e;
  state_e     state_d, state_q;
  logic [3:0] wait_d, wait_q;                    // cycles since something last happened

  // The set-up check has two stages. "Idle" may lag behind a word that moves from unit to unit by
  // a few cycles; eight quiet cycles in a row cannot.
  localparam logic [3:0] CHECK_CYCLES = 4'd3;
  localparam logic [3:0] QUIET_CYCLES = 4'd8;

  logic  start, failed;
  err_t  err_d;
  always_comb begin
    {failed, err_d} = '0;
    for (int e = int'(NumErr) - 1; e >= 0; e--)
      if (err_valid_i[e]) {failed, err_d} = {1'b1, err_i[e]};
    if (state_q == CHECK) begin                  // nothing runs yet that could report
      failed = bad_i && wait_q == CHECK_CYCLES;
      err_d  = '{code: ERR_CONFIG, addr: bad_reg_i};
    end
  end

  assign start = render_i || build_i || accel_i;
  always_comb begin
    state_d       = state_q;
    wait_d        = '0;
    build_start_o = 1'b0;
    accel_start_o = 1'b0;
    load_start_o  = 1'b0;
    trace_start_o = 1'b0;
    unique case (state_q)
      IDLE: if (start) state_d = CHECK;
      CHECK: begin
        wait_d = wait_q + 4'd1;
        if (wait_q == CHECK_CYCLES) begin
          state_d       = failed ? END : (build_o || accel_o) ? BUILD : LOAD;
          build_start_o = !failed && build_o;
          accel_start_o = !failed && accel_o;
          load_start_o  = !failed && !build_o && !accel_o;
          wait_d        = '0;
        end
      end
      BUILD: begin                               // then the windows change, and any error shows
        if (!building_o && ports_idle_i) wait_d = wait_q + 4'd1;
        if (failed) begin
          state_d = STOP;
          wait_d  = '0;
        end else if (wait_q == QUIET_CYCLES) begin
          state_d      = render_o ? LOAD : END;
          load_start_o = render_o;
          wait_d       = '0;
        end
      end
      LOAD: begin
        if (failed) state_d = STOP;
        else if (!load_busy_i) begin
          state_d       = TRACE;
          trace_start_o = 1'b1;
        end
      end
      TRACE: begin
        if (units_idle_i && ports_idle_i) wait_d = wait_q + 4'd1;
        if (failed) begin
          state_d = STOP;
          wait_d  = '0;
        end else if (wait_q == QUIET_CYCLES) state_d = END;
      end
      STOP: begin
        if (ports_idle_i) wait_d = wait_q + 4'd1;
        if (wait_q == QUIET_CYCLES) state_d = END;
      end
      END: state_d = IDLE;
      default: state_d = IDLE;
    endcase
  end

  assign clear_o     = state_q == IDLE && start;
  assign count_o     = state_q != IDLE && state_q != END;
  assign stop_o      = state_q == STOP || state_q == END;      // the units' reset takes hold after END
  assign unit_rst_no = state_q == LOAD || state_q == TRACE || state_q == STOP || load_start_o;
  assign build_rst_no = state_q != CHECK || build_start_o || accel_start_o;
  assign end_o       = state_q == END;

  logic [1:0] open_q;                            // who still builds: tree builder, record unit
  assign building_o = open_q != '0;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      state_q  <= IDLE;
      wait_q   <= '0;
      status_o <= '0;
      {render_o, build_o, accel_o, open_q} <= '0;
    end else begin
      state_q <= state_d;
      wait_q  <= wait_d;
      if (clear_o) {render_o, build_o, accel_o, open_q} <= {render_i, build_i, accel_i, accel_i, build_i};
      else if (state_q == END) open_q <= '0;
      else if (state_q == BUILD && !failed) open_q <= open_q & ~{accel_done_i, build_done_i};
      if (clear_o) begin
        status_o <= '{busy: 1'b1, err: '{code: ERR_NONE, default: '0}, default: '0};
      end else begin
        if (failed && count_o && !status_o.error) {status_o.error, status_o.err} <= {1'b1, err_d};
        if (state_d == END) {status_o.busy, status_o.done} <= 2'b01;
      end
    end
  end

`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni && end_o) PortsQuiet_A: assert (ports_idle_i);
  end
`endif
endmodule
