// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// From texture coordinates to texels: mip level by path length (paper Sec. 3.6, Park et al. 2011), position, wrapping, blocks
// of memory. Integers only; formulas in docs/whitted.md. A footprint a cycle, two for a hit between two levels.
//   A1  read the texture's descriptor             A5  fixed-point position; blocks of the larger levels
//   A2  log2 of the length                        A6  the four texels' columns and rows, wrapped
//   A3  level                                     A7  addresses of their blocks, by bank
//   A4  sizes of the level; a second footprint for the next level
// The stages move together when the last one does.
module rc_tex_addr import rc_pkg::*; import rc_tex_pkg::*; (
  input  logic        clk_i,
  input  logic        rst_ni,
  input  line_addr_t  tex_base_i,
  input  mip_t        mip_bias_i,
  input  logic        trilinear_i,
  input  logic        in_valid_i,
  output logic        in_ready_o,
  input  tex_coord_t  in_i,
  output logic        desc_re_o,           // descriptor of a material, one cycle later
  output logic [7:0]  desc_idx_o,
  input  tex_desc_t   desc_i,              // ... until the next one is read
  output logic        out_valid_o,
  input  logic        out_ready_i,
  output tex_blocks_t out_blocks_o,
  output tex_sample_t out_sample_o
);
  typedef logic signed [14:0] lambda_t;    // 6 bits of fraction
  typedef logic signed [23:0] fixed_t;     // texels, 8 bits of fraction
  localparam logic [5:0] RIGHT_MAX = 6'd41;

  logic a1_valid_q, a2_valid_q, a3_valid_q, a4_valid_q, a5_valid_q, a6_valid_q;
  logic step, load;                        // stages from A4 move; those before do
  logic a3_pair, a3_second_q;              // two levels; the first one has left A3
  assign step       = !out_valid_o || out_ready_i;
  assign load       = step && !(a3_valid_q && a3_pair && !a3_second_q);
  assign in_ready_o = load;
  assign desc_re_o  = load && in_valid_i;
  assign desc_idx_o = in_i.mat;
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      {a1_valid_q, a2_valid_q, a3_valid_q, a3_second_q} <= '0;
      {a4_valid_q, a5_valid_q, a6_valid_q, out_valid_o} <= '0;
    end else begin
      if (load) {a1_valid_q, a2_valid_q, a3_valid_q} <= {in_valid_i, a1_valid_q, a2_valid_q};
      if (step) {a4_valid_q, a5_valid_q, a6_valid_q, out_valid_o} <= {a3_valid_q, a4_valid_q, a5_valid_q, a6_valid_q};
      if (step) a3_second_q <= !load;
    end
  end

  // ---- A1 to A3: level -----------------------------------------------------------------------------------------------
  typedef struct packed {
    logic srgb; logic rgba5551; logic [1:0] wrap_t; logic [1:0] wrap_s; logic [3:0] log2_h; logic [3:0] log2_w;
  } shape_t;
  typedef struct packed {shape_t shape; line_addr_t base; fp_t v; fp_t u;} place_t;
  tex_coord_t a1_q;
  place_t     a2_q, a3_q;
  lambda_t    a2_lambda_q, log2_len, lambda, top, clamped;
  logic [3:0] a2_levels_q, a3_level_q;
  logic [5:0] a3_fl_q;
  // As docs/whitted.md: the exponent, and a table for the leading bits of the fraction.
  assign log2_len = (a1_q.len[FP_MAN_W+:FP_EXP_W] == '0) ? -15'sd4096
                  : $signed({2'b00, a1_q.len[FP_MAN_W+:FP_EXP_W], 6'd0}) - $signed(15'(63 * 64))
                    + $signed(15'(LOG_TABLE[a1_q.len[FP_MAN_W-1-:6]]));
  assign lambda   = a2_lambda_q + lambda_t'(mip_bias_i) + (trilinear_i ? 15'sd0 : 15'sd32);
  assign top      = lambda_t'({less(a2_levels_q, 4'd1), 6'd0});
  assign clamped  = (lambda < 0) ? '0 : (lambda > top) ? top : lambda;
  always_ff @(posedge clk_i) begin
    if (load) begin
      a1_q        <= in_i;
      a2_q        <= '{shape: '{srgb: desc_i.srgb, rgba5551: desc_i.rgba5551, wrap_t: desc_i.wrap_t,
                                wrap_s: desc_i.wrap_s, log2_h: desc_i.log2_h, log2_w: desc_i.log2_w},
                       base: tex_base_i + desc_i.tex_base, v: a1_q.v, u: a1_q.u};
      a2_levels_q <= desc_i.levels;
      a2_lambda_q <= log2_len + lambda_t'(a1_q.mip);
      a3_q        <= a2_q;
      a3_level_q  <= clamped[9:6];
      a3_fl_q     <= trilinear_i ? clamped[5:0] : '0;
    end
  end

  // ---- A4: sizes, all as logarithms --------------------------------------------------------------------------------
  // Blocks of level k: 2^p(k), p(k) = max(a - k, 0) + max(b - k, 0), a and b of level 0. p falls by 2 from a + b to |a - b|,
  // then by 1 to 0, and stays 0. So the blocks of the levels before one are a number with ones at the places p(k), that is
  // at those above p(level), plus one for each level after the first single block.
  typedef struct packed {
    place_t place; logic add; logic more; logic [5:0] fl;
    logic [3:0] log2_h; logic [3:0] log2_w; logic [3:0] row_log2;
    logic [4:0] p_top; logic [3:0] p_even; logic [4:0] p_here; logic [3:0] singles;
    logic [5:0] right_v; logic [5:0] right_u; logic [3:0] level;
  } a4_t;
  a4_t        a4_d, a4_q;
  logic [3:0] level, per_block, log2_a, log2_b, log2_w, log2_h, column_log2;
  // The significand, 24 places above its last bit, goes this far to the right: u 2^(log2_w + 8) as an integer.
  function automatic logic [5:0] right(logic [FP_EXP_W-1:0] exp, logic [3:0] log2_size);
    logic signed [8:0] r;
    r = 9'sd95 - $signed({2'b00, exp}) - $signed({5'd0, log2_size});
    return (r < 0) ? '0 : (r > 9'(RIGHT_MAX)) ? RIGHT_MAX : r[5:0];
  endfunction
  assign a3_pair     = a3_fl_q != '0;
  assign level       = a3_level_q + 4'(a3_second_q);
  assign per_block   = a3_q.shape.rgba5551 ? 4'd3 : 4'd2;
  assign log2_w      = less(a3_q.shape.log2_w, level);
  assign log2_h      = less(a3_q.shape.log2_h, level);
  assign log2_a      = less(a3_q.shape.log2_w, per_block);
  assign log2_b      = less(a3_q.shape.log2_h, 4'd2);
  assign column_log2 = less(log2_h, 4'd2);
  assign a4_d = '{place: a3_q, add: a3_second_q, more: a3_pair && !a3_second_q, fl: a3_fl_q,
                  log2_h: log2_h, log2_w: log2_w, row_log2: less(log2_w, per_block),
                  p_top: 5'(log2_a) + 5'(log2_b), p_even: (log2_a > log2_b) ? log2_a - log2_b : log2_b - log2_a,
                  p_here: 5'(less(log2_w, per_block)) + 5'(column_log2),
                  singles: less(level, (log2_a > log2_b) ? log2_a : log2_b),
                  right_v: right(a3_q.v[FP_MAN_W+:FP_EXP_W], log2_h),
                  right_u: right(a3_q.u[FP_MAN_W+:FP_EXP_W], log2_w), level: level};
  always_ff @(posedge clk_i) if (step) a4_q <= a4_d;

  // ---- A5: position, offset ------------------------------------------------------------------------------------------
  // floor(u 2^(log2_w + 8)): its low bits, or, if the texture is clamped, the nearest number that fits.
  function automatic fixed_t fixed(fp_t u, logic [5:0] places, logic clamp);
    logic [57:0] ext;
    logic [23:0] whole;
    logic        negative;
    negative = u[FP_W-1];
    ext   = {1'b1, u[FP_MAN_W-1:0], 41'd0} >> places;
    whole = ext[40:17];
    if (u[FP_MAN_W+:FP_EXP_W] == '0 || u[FP_W-2:0] > FP_INF[FP_W-2:0]) return '0;
    if (clamp && ext[57:40] != '0) return {negative, {23{!negative}}};
    return negative ? ~whole + 24'(ext[16:0] == '0) : whole;
  endfunction
  typedef struct packed {
    tex_sample_t sample; line_addr_t base; logic [20:0] offset; logic [3:0] row_log2; logic [3:0] level;
    logic [3:0] log2_h; logic [3:0] log2_w; logic [1:0] wrap_t; logic [1:0] wrap_s; fixed_t y; fixed_t x;
  } a5_t;
  a5_t         a5_d, a5_q;
  logic [20:0] larger;
  always_comb begin
    for (int p = 0; p < 21; p++)
      larger[p] = 5'(p) > a4_q.p_here && 5'(p) <= a4_q.p_top
                  && (5'(p) <= 5'(a4_q.p_even) || (p % 2 == 1) == a4_q.p_even[0]);
    a5_d          = '0;
    a5_d.base     = a4_q.place.base;
    a5_d.offset   = larger + 21'(a4_q.singles);
    a5_d.row_log2 = a4_q.row_log2;
    a5_d.level    = a4_q.level;
    a5_d.log2_h   = a4_q.log2_h;
    a5_d.log2_w   = a4_q.log2_w;
    a5_d.wrap_t   = a4_q.place.shape.wrap_t;
    a5_d.wrap_s   = a4_q.place.shape.wrap_s;
    a5_d.y        = fixed(a4_q.place.v, a4_q.right_v, a4_q.place.shape.wrap_t[1]);
    a5_d.x        = fixed(a4_q.place.u, a4_q.right_u, a4_q.place.shape.wrap_s[1]);
    a5_d.sample.add      = a4_q.add;
    a5_d.sample.more     = a4_q.more;
    a5_d.sample.srgb     = a4_q.place.shape.srgb;
    a5_d.sample.rgba5551 = a4_q.place.shape.rgba5551;
    a5_d.sample.fl       = a4_q.fl;
  end
  always_ff @(posedge clk_i) if (step) a5_q <= a5_d;

  // ---- A6: half a texel back; the texel there and the one behind it ------------------------------------------------------
  function automatic logic [11:0] wrap_texel(logic signed [16:0] i, logic [3:0] log2_size, logic [1:0] wrap);
    logic [12:0] size;
    logic [11:0] last;
    size = 13'd1 << log2_size;
    last = 12'(size - 13'd1);
    if (wrap[1]) return i[16] ? '0 : (i > $signed({5'd0, last})) ? last : i[11:0];
    return (i[11:0] ^ {12{wrap == WRAP_MIRROR && (i[12:0] & size) != '0}}) & last;
  endfunction
  typedef struct packed {
    tex_sample_t sample; line_addr_t base; logic [3:0] row_log2; logic [3:0] level;
    logic [1:0][11:0] y; logic [1:0][11:0] x;
  } a6_t;
  a6_t a6_d, a6_q;
  logic signed [16:0] x_before, x_behind, y_before, y_behind;
  // (x - 128) >> 8 and (x + 128) >> 8
  assign x_before = 17'(a5_q.x >>> 8) - 17'(!a5_q.x[7]);
  assign x_behind = 17'(a5_q.x >>> 8) + 17'(a5_q.x[7]);
  assign y_before = 17'(a5_q.y >>> 8) - 17'(!a5_q.y[7]);
  assign y_behind = 17'(a5_q.y >>> 8) + 17'(a5_q.y[7]);
  always_comb begin
    a6_d.sample    = a5_q.sample;
    a6_d.sample.fx = a5_q.x[7:0] ^ 8'h80;
    a6_d.sample.fy = a5_q.y[7:0] ^ 8'h80;
    a6_d.base      = a5_q.base + line_addr_t'(a5_q.offset);
    a6_d.row_log2  = a5_q.row_log2;
    a6_d.level     = a5_q.level;
    a6_d.x         = {wrap_texel(x_behind, a5_q.log2_w, a5_q.wrap_s), wrap_texel(x_before, a5_q.log2_w, a5_q.wrap_s)};
    a6_d.y         = {wrap_texel(y_behind, a5_q.log2_h, a5_q.wrap_t), wrap_texel(y_before, a5_q.log2_h, a5_q.wrap_t)};
  end
  always_ff @(posedge clk_i) if (step) a6_q <= a6_d;

  // ---- A7: blocks by bank ------------------------------------------------------------------------------------------------
  // Two neighbours, also those at the two edges of a texture that repeats, are one block or differ in parity.
  logic [1:0][11:0] word;                  // column in words
  logic [1:0][9:0]  bank_x, bank_y;        // by parity: the block of that parity
  logic [1:0]       used_x, used_y;
  tex_blocks_t      blocks;
  tex_sample_t      sample;
  always_comb begin
    sample = a6_q.sample;
    for (int i = 0; i < 2; i++) begin
      word[i]        = a6_q.sample.rgba5551 ? a6_q.x[i] >> 1 : a6_q.x[i];
      sample.half[i] = a6_q.x[i][0];
      sample.col[i]  = word[i][1:0];
      sample.row[i]  = a6_q.y[i][1:0];
      sample.bx[i]   = word[i][2];
      sample.by[i]   = a6_q.y[i][2];
    end
    for (int p = 0; p < 2; p++) begin
      bank_x[p] = (word[0][2] == 1'(p)) ? word[0][11:2] : word[1][11:2];
      bank_y[p] = (a6_q.y[0][2] == 1'(p)) ? a6_q.y[0][11:2] : a6_q.y[1][11:2];
      used_x[p] = word[0][2] == 1'(p) || word[1][2] == 1'(p);
      used_y[p] = a6_q.y[0][2] == 1'(p) || a6_q.y[1][2] == 1'(p);
    end
    for (int b = 0; b < 4; b++) begin
      blocks.used[b] = used_x[b%2] && used_y[b/2];
      blocks.addr[b] = a6_q.base + ((line_addr_t'(bank_y[b/2]) << a6_q.row_log2) | line_addr_t'(bank_x[b%2]));
      // Squares of blocks lie in sets of their own, whatever the texture's size; levels and small textures are spread.
      blocks.set[b]  = {bank_y[b/2][4], bank_x[b%2][4], bank_y[b/2][3], bank_x[b%2][3],
                        bank_y[b/2][2], bank_x[b%2][2], bank_y[b/2][1], bank_x[b%2][1]}
                       ^ a6_q.base[SET_W-1:0] ^ {1'b0, a6_q.level, 3'd0};
    end
  end
  always_ff @(posedge clk_i) begin
    if (step) begin
      out_blocks_o <= blocks;
      out_sample_o <= sample;
    end
  end
  logic unused_bits;
  assign unused_bits = ^{a1_q.mat, a1_q.len[FP_W-1], a1_q.len[FP_MAN_W-7:0], clamped[14:10]};
endmodule
