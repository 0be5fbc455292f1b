// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Texture filter: the four texels of a footprint to a colour, red, green, blue and alpha in four cycles (beats). Exact in
// integers, rounded once at the end; widths in docs/whitted.md. Four multipliers. Rigid; a footprint enters if the queue
// at the end has a place for it.
//   F0  byte of each texel; sRGB table, or scaled
//   F1  linear light, 4096 = 1: upper and lower pair by fx
//   F2  the two by fy, 2^28 = 1
//   F3  with the level before, by fl, 2^34 = 1
//   F4  to FP24; four channels into the queue
module rc_tex_filter import rc_pkg::*; import rc_tex_pkg::*; #(
  parameter int unsigned Depth = 4                 // places in the queue
) (
  input  logic             clk_i,
  input  logic             rst_ni,
  input  logic             in_valid_i,
  output logic             in_ready_o,
  input  logic [3:0][31:0] in_words_i,
  input  tex_sample_t      in_sample_i,
  output logic             out_valid_o,
  input  logic             out_ready_i,
  output fp_t [3:0]        out_o                   // [0] red, [3] alpha
);
  localparam int unsigned CountW = $clog2(Depth + 1);
  typedef struct packed {
    logic valid; logic [1:0] channel; logic add; logic more; logic [5:0] fl; logic [7:0] fy; logic [7:0] fx;
  } ctl_t;

  // ---- F0: texels as four bytes, [2 j + i] the one of row j, column i; they move down by a byte in each beat ---------
  logic [3:0][31:0]  f0_texel_q, texel;
  ctl_t              f0_q, f1_q, f2_q, f3_q;
  logic              f0_srgb_q, accept;
  logic [CountW-1:0] inside_q;                     // results to come or in the queue
  function automatic logic [31:0] widen(logic [15:0] t);
    return {{8{t[15]}}, t[14:10], t[14:12], t[9:5], t[9:7], t[4:0], t[4:2]};
  endfunction
  always_comb begin
    for (int k = 0; k < 4; k++) begin
      logic [31:0] word;
      word = in_words_i[{in_sample_i.row[k/2][0], in_sample_i.col[k%2][0]}];
      texel[k] = !in_sample_i.rgba5551 ? word : widen(in_sample_i.half[k%2] ? word[31:16] : word[15:0]);
    end
  end
  assign in_ready_o = (!f0_q.valid || f0_q.channel == 2'd3) && inside_q != CountW'(Depth);
  assign accept     = in_valid_i && in_ready_o;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      inside_q <= '0;
    end else begin
      inside_q <= inside_q + CountW'(accept && !in_sample_i.more) - CountW'(out_valid_o && out_ready_i);
    end
    if (accept) begin
      f0_q       <= '{valid: 1'b1, channel: 2'd0, add: in_sample_i.add, more: in_sample_i.more, fl: in_sample_i.fl,
                      fy: in_sample_i.fy, fx: in_sample_i.fx};
      f0_srgb_q  <= in_sample_i.srgb;
      f0_texel_q <= texel;
    end else if (f0_q.valid) begin
      f0_q.channel <= f0_q.channel + 2'd1;
      if (f0_q.channel == 2'd3) f0_q.valid <= 1'b0;
      for (int k = 0; k < 4; k++) f0_texel_q[k] <= 32'(f0_texel_q[k][31:8]);
    end
    f1_q <= f0_q;
    f2_q <= f1_q;
    f3_q <= f2_q;
    if (!rst_ni) {f0_q.valid, f1_q.valid, f2_q.valid, f3_q.valid} <= '0;
  end

  // ---- F1: linear light ----------------------------------------------------------------------------------------------
  logic [3:0][12:0] f1_srgb_q, f1_scaled_q, f1_linear;
  logic             f1_is_srgb_q;
  always_ff @(posedge clk_i) begin
    for (int k = 0; k < 4; k++) begin
      f1_srgb_q[k]   <= SRGB_TABLE[f0_texel_q[k][7:0]][12:0];
      // c 4096 / 255 to nearest: 16 c, and 16 c / 255, which is (c + 8) / 16 for all c
      f1_scaled_q[k] <= {1'b0, f0_texel_q[k][7:0], 4'd0} + 13'(f0_texel_q[k][7:4]) + 13'(f0_texel_q[k][3]);
    end
    f1_is_srgb_q <= f0_srgb_q && f0_q.channel != 2'd3;
  end
  assign f1_linear = f1_is_srgb_q ? f1_srgb_q : f1_scaled_q;

  // ---- F2, F3: a + (b - a) f, in units of the fraction ------------------------------------------------------------------
  function automatic logic [20:0] mix_x(logic [12:0] a, logic [12:0] b, logic [7:0] f);
    logic signed [13:0] step;
    step = $signed({1'b0, b}) - $signed({1'b0, a});
    return {a, 8'd0} + 21'(22'(step) * $signed(22'(f)));
  endfunction
  function automatic logic [28:0] mix_y(logic [20:0] a, logic [20:0] b, logic [7:0] f);
    logic signed [21:0] step;
    step = $signed({1'b0, b}) - $signed({1'b0, a});
    return {a, 8'd0} + 29'(30'(step) * $signed(30'(f)));
  endfunction
  logic [1:0][20:0] f2_row_q;
  logic [28:0]      f3_level_q;
  always_ff @(posedge clk_i) begin
    for (int j = 0; j < 2; j++) f2_row_q[j] <= mix_x(f1_linear[2*j], f1_linear[2*j+1], f1_q.fx);
    f3_level_q <= mix_y(f2_row_q[0], f2_row_q[1], f2_q.fy);
  end

  // ---- levels: the first waits, by channel, for the second ---------------------------------------------------------------
  logic [3:0][28:0] first_q;
  logic [28:0]      from;
  logic signed [29:0] between;
  logic [34:0]      f4_q;
  logic             f4_valid_q, last_valid;
  logic [1:0]       f4_channel_q, last_channel;
  assign between = $signed({1'b0, f3_level_q}) - $signed({1'b0, from});
  assign from = f3_q.add ? first_q[f3_q.channel] : f3_level_q;
  always_ff @(posedge clk_i) begin
    if (f3_q.valid && f3_q.more) first_q[f3_q.channel] <= f3_level_q;
    f4_q <= {from, 6'd0} + 35'(36'(between) * $signed(36'(f3_q.fl)));
    f4_channel_q <= f3_q.channel;
    f4_valid_q   <= rst_ni && f3_q.valid && !f3_q.more;
  end

  // ---- F4: to FP24; the last channel takes the others along -------------------------------------------------------------
  fp_t       channel;
  fp_t [2:0] before_q;
  logic      queue_ready, push;
  logic [LAT_CONV:0][2:0] conv_q;
  logic [CountW-1:0] unused_count;
  rc_fp_from_int #(.Latency(LAT_CONV), .IntW(35), .FracW(34), .Signed(1'b0)) u_conv (
    .clk_i, .int_i(f4_q), .y_o(channel)
  );
  assign conv_q[0] = {f4_valid_q, f4_channel_q};
  for (genvar k = 0; k < LAT_CONV; k++) begin : gen_conv
    always_ff @(posedge clk_i) conv_q[k+1] <= conv_q[k] & {rst_ni, 2'b11};
  end
  assign {last_valid, last_channel} = conv_q[LAT_CONV];
  always_ff @(posedge clk_i) before_q <= {channel, before_q[2:1]};
  assign push = last_valid && last_channel == 2'd3;
  rc_fifo #(.data_t(logic [3:0][FP_W-1:0]), .Depth(Depth)) u_queue (
    .clk_i, .rst_ni,
    .in_valid_i(push), .in_ready_o(queue_ready), .in_data_i({channel, before_q}),
    .out_valid_o, .out_ready_i, .out_data_o(out_o), .count_o(unused_count)
  );
  logic unused_place;
  assign unused_place = ^{in_sample_i.bx, in_sample_i.by, in_sample_i.row[1][1], in_sample_i.row[0][1],
                          in_sample_i.col[1][1], in_sample_i.col[0][1], f3_q.fx, f3_q.fy};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) if (rst_ni && push) QueueRoom_A: assert (queue_ready);
`else
  logic unused_ready;
  assign unused_ready = queue_ready;
`endif
endmodule
