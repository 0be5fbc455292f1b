// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Texture coordinates and path length of a hit, with one adder and one multiplier: a hit in six cycles (docs/whitted.md).
// Rigid from entry to the queue behind it; a hit enters if the queue has a place for every one inside.
//   T_MUL  beta du1, beta dv1, gamma du2, gamma dv2 in four cycles
//   T_MUL  adder: u0 + beta du1, then v
//   T_SUM  adder: ... + gamma du2, then v
//   T_LEN  adder: len + t, in the cycles that these leave
//   T_OUT  all of it goes to the queue
module rc_tex_uv import rc_pkg::*; import rc_shade_pkg::*; import rc_tex_pkg::*; #(
  parameter int unsigned Depth = 8         // places in the queue
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       in_valid_i,
  output logic       in_ready_o,
  input  tex_hit_t   in_hit_i,
  input  tri_uv_t    in_uv_i,
  output logic       out_valid_o,
  input  logic       out_ready_i,
  output tex_coord_t out_o
);
  localparam int unsigned B = UV_BEATS;
  localparam int unsigned T_IN  = 0;
  localparam int unsigned T_MUL = T_IN + LAT_MUL;
  localparam int unsigned T_SUM = next_beat(later(T_MUL + LAT_ADD, T_MUL + 2), T_MUL + 2, B);
  localparam int unsigned T_LEN = (T_MUL + 4) % B;                  // the operands are there in the times 0 to B - 1
  localparam int unsigned T_U   = T_SUM + LAT_ADD;
  localparam int unsigned T_V   = T_U + 1;
  localparam int unsigned T_L   = T_LEN + LAT_ADD;
  localparam int unsigned T_OUT = later(T_V, T_L) + 1;
  localparam int unsigned SLOTS = T_OUT / B + 1;                    // hits in the pipeline
  localparam int unsigned CountW = $clog2(Depth + 1);

  // ---- time: beat_q[k] is set in the cycles T = k, k + B, ...; slot_q[k] is the hit in its times k B to k B + B - 1 -------
  typedef struct packed {logic [7:0] mat; mip_t mip;} slot_t;
  logic  [B-1:0]      beat_q;
  logic  [SLOTS-1:0]  valid_q;
  slot_t [SLOTS-1:0]  slot_q;
  tex_hit_t           hit_q;
  tri_uv_t            uv_q;
  logic  [CountW-1:0] inside_q;            // hits that have entered and not left the queue
  logic               accept;
  assign in_ready_o = beat_q[B-1] && inside_q != CountW'(Depth);
  assign accept     = in_valid_i && in_ready_o;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      beat_q   <= B'(1);
      valid_q  <= '0;
      inside_q <= '0;
    end else begin
      beat_q   <= {beat_q[B-2:0], beat_q[B-1]};
      if (beat_q[B-1]) valid_q <= SLOTS'({valid_q, accept});
      inside_q <= inside_q + CountW'(accept) - CountW'(out_valid_o && out_ready_i);
    end
    if (beat_q[B-1]) begin
      slot_q <= ($bits(slot_q))'({slot_q, in_hit_i.mat, in_uv_i.mip});
      hit_q  <= in_hit_i;
      uv_q   <= in_uv_i;
    end
  end

  // ---- products ------------------------------------------------------------------------------------------------------
  fp_t weight, edge_in, prod, first_in, first_mul, prod_sum;
  assign weight  = (beat_q[T_IN % B] || beat_q[(T_IN + 1) % B]) ? hit_q.beta : hit_q.gamma;
  assign edge_in = beat_q[T_IN % B] ? uv_q.du1 : beat_q[(T_IN + 1) % B] ? uv_q.dv1
                 : beat_q[(T_IN + 2) % B] ? uv_q.du2 : uv_q.dv2;
  rc_fp_mul #(.Latency(LAT_MUL)) u_mul (.clk_i, .a_i(weight), .b_i(edge_in), .y_o(prod));
  assign first_in = beat_q[T_IN % B] ? uv_q.u0 : uv_q.v0;
  rc_carry #(.From(T_IN), .To(T_MUL)) u_first_mul (.clk_i, .in_i(first_in), .out_o(first_mul));
  rc_carry #(.From(T_MUL + 2), .To(T_SUM)) u_prod_sum (.clk_i, .in_i(prod), .out_o(prod_sum));

  // ---- sums ------------------------------------------------------------------------------------------------------------
  fp_t  add_a, add_b, sum, sum_sum;
  logic is_first, is_len;
  assign is_first = beat_q[T_MUL % B] || beat_q[(T_MUL + 1) % B];
  assign is_len   = beat_q[T_LEN];
  assign add_a    = is_first ? first_mul : is_len ? hit_q.len : sum_sum;
  assign add_b    = is_first ? prod : is_len ? hit_q.t : prod_sum;
  rc_fp_add #(.Latency(LAT_ADD)) u_add (.clk_i, .a_i(add_a), .b_i(add_b), .y_o(sum));
  rc_carry #(.From(T_MUL + LAT_ADD), .To(T_SUM)) u_sum_sum (.clk_i, .in_i(sum), .out_o(sum_sum));

  // ---- the queue -------------------------------------------------------------------------------------------------------
  tex_coord_t coord;
  logic       push, queue_ready;
  logic [CountW-1:0] unused_count;
  rc_hold #(.Width(FP_W), .Beats(B), .From(T_U), .To(T_OUT)) u_u (
    .clk_i, .now_i(beat_q[T_U % B]), .in_i(sum), .out_o(coord.u)
  );
  rc_hold #(.Width(FP_W), .Beats(B), .From(T_V), .To(T_OUT)) u_v (
    .clk_i, .now_i(beat_q[T_V % B]), .in_i(sum), .out_o(coord.v)
  );
  rc_hold #(.Width(FP_W), .Beats(B), .From(T_L), .To(T_OUT)) u_l (
    .clk_i, .now_i(beat_q[T_L % B]), .in_i(sum), .out_o(coord.len)
  );
  assign coord.mat = slot_q[SLOTS-1].mat;
  assign coord.mip = slot_q[SLOTS-1].mip;
  assign push      = valid_q[SLOTS-1] && beat_q[T_OUT % B];
  rc_fifo #(.data_t(tex_coord_t), .Depth(Depth)) u_queue (
    .clk_i, .rst_ni,
    .in_valid_i(push), .in_ready_o(queue_ready), .in_data_i(coord),
    .out_valid_o, .out_ready_i, .out_data_o(out_o), .count_o(unused_count)
  );

  if (T_SUM % B != (T_MUL + 2) % B) begin : gen_check
    $error("rc_tex_uv: two sums in one beat of the adder");
  end
  logic unused_uv;
  assign unused_uv = ^{uv_q.zero1, uv_q.zero2, uv_q.zero3, uv_q.mip, hit_q.mat};
`ifndef SYNTHESIS
  always_ff @(posedge clk_i) begin
    if (rst_ni) OneBeat_A: assert ($onehot(beat_q));
    if (rst_ni && push) QueueRoom_A: assert (queue_ready);
  end
`else
  logic unused_ready;
  assign unused_ready = queue_ready;
`endif
endmodule
