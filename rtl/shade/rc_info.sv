// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Triangle information of surfaces, in the scene's coordinates: a cache of lines of 480 bits that answers in order (paper
// Sec. 3.6), and a way for what lies in a placed object.
//   NOT_PLACED   one lookup: the line of triangle information as it is
//   placed       the line of its instance's place first, unless the last one looked up was the same; then the line of triangle
//                information, turned by rc_place
// A place goes through the queue like any line and stays at its end until the next one comes, so a surface finds that of its own
// instance there. Rays that are close hit the same object, hence few lookups of places. A surface is taken with the lookup
// of its information; until then another may be offered: only the place that was looked up is remembered. Whoever offers
// settles for one after a while, or places alone would be looked up.
module rc_info import rc_pkg::*; import rc_shade_pkg::*; #(
  parameter int unsigned Sets    = 256,    // of the cache, power of two
  parameter int unsigned Ways    = 2,      // 1 or 2
  parameter int unsigned Depth   = 32,     // lookups in the queue
  parameter int unsigned MaxMiss = 8       // lines asked for and not yet used
) (
  input  logic       clk_i,
  input  logic       rst_ni,               // empties the cache
  input  line_addr_t info_base_i,          // constant while a frame runs
  input  line_addr_t inst_base_i,
  input  logic       in_valid_i,           // taken when ready is up; another may be offered until then
  output logic       in_ready_o,
  input  tex_t       in_i,
  output logic       out_valid_o,          // in order
  input  logic       out_ready_i,
  output tex_t       out_o,
  output tri_info_t  out_info_o,
  output logic       req_valid_o,          // to memory
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,          // in order of the requests; always taken
  input  line_t      rsp_line_i,
  output logic       ev_hit_o,             // lookups, those of places included
  output logic       ev_miss_o
);
  typedef struct packed {logic place; tex_t tex;} entry_t;            // place: a line of a place, and who asked for it

  // ---- lookups -------------------------------------------------------------------------------------------------------------
  inst_id_t   inst_q;                      // whose place was looked up last; NOT_PLACED: none yet
  surf_t      surf;
  logic       ask_place, ask_ready;
  line_addr_t place_addr, ask_addr;
  assign surf       = in_i.hit.surf;
  assign ask_place  = surf.inst != NOT_PLACED && surf.inst != inst_q;
  assign place_addr = inst_base_i + line_addr_t'(surf.inst) * line_addr_t'(INST_LINES) + line_addr_t'(PLACE_LINE);
  assign ask_addr   = ask_place ? place_addr : info_base_i + line_addr_t'(surf.tri_idx);
  assign in_ready_o = ask_ready && !ask_place;
  always_ff @(posedge clk_i) begin
    if (!rst_ni)                                   inst_q <= NOT_PLACED;
    else if (in_valid_i && ask_ready && ask_place) inst_q <= surf.inst;
  end

  // ---- lines -----------------------------------------------------------------------------------------------------------------
  logic   line_valid, line_ready;
  line_t  line;
  entry_t ask, entry;
  assign ask = '{place: ask_place, tex: in_i};
  rc_ro_cache #(.data_t(entry_t), .Sets(Sets), .Ways(Ways), .Depth(Depth), .MaxMiss(MaxMiss)) u_cache (
    .clk_i, .rst_ni,
    .in_valid_i, .in_ready_o(ask_ready), .in_addr_i(ask_addr), .in_data_i(ask),
    .out_valid_o(line_valid), .out_ready_i(line_ready), .out_line_o(line), .out_data_o(entry),
    .req_valid_o, .req_ready_i, .req_addr_o, .rsp_valid_i, .rsp_line_i, .ev_hit_o, .ev_miss_o
  );

  // ---- the place that counts from here on; rc_place is empty when a new one comes, for all before it has left ------------------
  place_t      place;
  vec3_t [2:0] rot_q;
  vec3_t       origin_q;
  logic        unused_place;
  assign place        = line;
  assign unused_place = ^{place.zero0, place.zero1, place.zero2, place.zero3, place.zero4, place.zero5, place.zero6};
  always_ff @(posedge clk_i) begin
    if (line_valid && entry.place) begin
      rot_q[0] <= {place.m_xz, place.m_xy, place.m_xx};
      rot_q[1] <= {place.m_yz, place.m_yy, place.m_yx};
      rot_q[2] <= {place.m_zz, place.m_zy, place.m_zx};
      origin_q <= {place.o_z, place.o_y, place.o_x};
    end
  end

  // ---- information, as it is or turned -----------------------------------------------------------------------------------------
  logic      placed, turned_valid, turned_taken;
  tri_info_t turned;
  assign placed = line_valid && !entry.place && entry.tex.hit.surf.inst != NOT_PLACED;
  rc_place u_place (
    .clk_i, .rst_ni, .rot_i(rot_q), .origin_i(origin_q),
    .in_valid_i(placed), .in_ready_o(turned_taken), .in_info_i(line),
    .out_valid_o(turned_valid), .out_ready_i, .out_info_o(turned)
  );
  assign out_valid_o = placed ? turned_valid : line_valid && !entry.place;
  assign out_o       = entry.tex;
  assign out_info_o  = placed ? turned : line;
  assign line_ready  = entry.place || (placed ? turned_taken : out_ready_i);

`ifndef SYNTHESIS
  inst_id_t place_inst_q;                  // whose place rc_place has
  always_ff @(posedge clk_i) begin
    if (!rst_ni)                        place_inst_q <= NOT_PLACED;
    else if (line_valid && entry.place) place_inst_q <= entry.tex.hit.surf.inst;
    if (rst_ni && placed) RightPlace_A: assert (place_inst_q == entry.tex.hit.surf.inst);
    if (rst_ni && $past(rst_ni && out_valid_o && !out_ready_i)) begin
      OutHeld_A: assert (out_valid_o && $stable(out_o) && $stable(out_info_o));
    end
  end
`endif
endmodule
