// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// What the parts of the texture unit share: records, tables, and the names of the four texels of a footprint.
// Index 0 is the left column or the upper row of a footprint, 1 the right or the lower one. All texels count as words of 32
// bits: one of RGBA8, or two neighbours of RGBA5551; a block is 4x4 words in both formats.
package rc_tex_pkg;
  import rc_pkg::*;

  parameter int unsigned UV_BEATS = 6;     // one adder serves five sums
  parameter int unsigned SET_W = 8;        // bits of a set's number that are computed; small caches use the low ones
  typedef logic [SET_W-1:0] tex_set_t;

  // The used part of word 4 of optics_t.
  typedef struct packed {
    logic        srgb;
    logic        rgba5551;
    logic [1:0]  wrap_t;
    logic [1:0]  wrap_s;
    logic [3:0]  levels;
    logic [3:0]  log2_h;
    logic [3:0]  log2_w;
    logic [25:0] tex_base;
  } tex_desc_t;

  typedef struct packed {                  // a hit with its triangle's coordinates
    logic [7:0] mat;
    fp_t        len;                       // before the ray
    fp_t        t;
    fp_t        beta;
    fp_t        gamma;
  } tex_hit_t;

  typedef struct packed {                  // a place in a texture
    logic [7:0] mat;
    mip_t       mip;
    fp_t        len;                       // up to the hit
    fp_t        v;
    fp_t        u;
  } tex_coord_t;

  typedef struct packed {                  // blocks of a footprint, by bank: [0] parity of x, [1] parity of y
    logic [3:0]       used;
    line_addr_t [3:0] addr;
    tex_set_t [3:0]   set;
  } tex_blocks_t;

  typedef struct packed {                  // one level's footprint: where its texels lie, and what to do with them
    logic            add;                  // of two levels the second: mix with the first
    logic            more;                 // ... the first: the second follows
    logic            srgb;
    logic            rgba5551;
    logic [5:0]      fl;                   // weight of the second level
    logic [7:0]      fy;                   // weights of index 1
    logic [7:0]      fx;
    logic [1:0]      half;                 // RGBA5551: upper half of the word, by column
    logic [1:0][1:0] row;                  // in the block, by row
    logic [1:0][1:0] col;                  // word in the block's row, by column
    logic [1:0]      by;                   // parity of the block, by row
    logic [1:0]      bx;                   // ..., by column
  } tex_sample_t;

  // Entry i: 64 log2(1 + (i + 1/2) / 64), to nearest.
  parameter logic [63:0][7:0] LOG_TABLE = {
    256'h403f3e3d3d3c3b3a3a3938373736353433323231302f2e2d2c2b2b2a29282726,
    256'h2524232221201f1e1d1c1b1a19171615141312100f0e0d0c0a09080605040201
  };

  // Entry i: linear light of sRGB i / 255, to nearest, 4096 = 1 (IEC 61966-2-1).
  parameter logic [255:0][15:0] SRGB_TABLE = {
    256'h1000_0fdc_0fb7_0f93_0f6f_0f4c_0f28_0f05_0ee2_0ebf_0e9c_0e79_0e57_0e35_0e13_0df1,
    256'h0dcf_0dae_0d8d_0d6c_0d4b_0d2a_0d0a_0ce9_0cc9_0ca9_0c89_0c6a_0c4a_0c2b_0c0c_0bed,
    256'h0bce_0bb0_0b92_0b73_0b56_0b38_0b1a_0afd_0adf_0ac2_0aa5_0a89_0a6c_0a50_0a34_0a18,
    256'h09fc_09e0_09c5_09a9_098e_0973_0958_093e_0923_0909_08ef_08d5_08bb_08a2_0888_086f,
    256'h0856_083d_0824_080c_07f3_07db_07c3_07ab_0794_077c_0765_074d_0736_0720_0709_06f2,
    256'h06dc_06c6_06b0_069a_0684_066f_0659_0644_062f_061a_0605_05f1_05dc_05c8_05b4_05a0,
    256'h058c_0578_0565_0552_053f_052c_0519_0506_04f4_04e1_04cf_04bd_04ab_0499_0488_0476,
    256'h0465_0454_0443_0432_0422_0411_0401_03f0_03e0_03d0_03c1_03b1_03a2_0392_0383_0374,
    256'h0365_0357_0348_033a_032b_031d_030f_0301_02f4_02e6_02d9_02cb_02be_02b1_02a4_0298,
    256'h028b_027f_0272_0266_025a_024e_0243_0237_022c_0220_0215_020a_01ff_01f4_01ea_01df,
    256'h01d5_01ca_01c0_01b6_01ad_01a3_0199_0190_0186_017d_0174_016b_0162_015a_0151_0149,
    256'h0140_0138_0130_0128_0120_0118_0111_0109_0102_00fb_00f4_00ed_00e6_00df_00d9_00d2,
    256'h00cc_00c5_00bf_00b9_00b3_00ad_00a8_00a2_009c_0097_0092_008d_0088_0083_007e_0079,
    256'h0074_0070_006b_0067_0063_005f_005b_0057_0053_004f_004c_0048_0045_0042_003e_003b,
    256'h0038_0035_0032_0030_002d_002a_0028_0025_0023_0021_001f_001d_001b_0019_0017_0015,
    256'h0014_0012_0010_000f_000e_000c_000b_000a_0009_0007_0006_0005_0004_0002_0001_0000
  };

  function automatic logic [3:0] less(logic [3:0] a, logic [3:0] b);   // a - b, not below 0
    return (a > b) ? a - b : '0;
  endfunction
endpackage
