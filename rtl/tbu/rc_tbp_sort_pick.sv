// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The best plane of a node: of the best ones of its axes the one that costs least, of equal ones that of the lower axis.
// Two axes are compared in the first cycle, the third one at the output. 2 comparators.
module rc_tbp_sort_pick import rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  logic        clk_i,
  input  best_t [2:0] best_i,
  output logic        found_o,             // one that pays; a cycle after best_i
  output plane_t      plane_o
);
  typedef struct packed {cost_t cost; logic found; plane_t plane;} axis_t;
  axis_t [2:0] best;
  axis_t xy_q, z_q;
  logic  y, z;
  for (genvar a = 0; a < 3; a++) begin : gen_axis
    assign best[a] = {best_i[a].cost, best_i[a].found, 2'(a), best_i[a].pos, best_i[a].pl, best_i[a].nl, best_i[a].nr};
  end
  assign y = best[1].found && (!best[0].found || best[1].cost < best[0].cost);
  assign z = z_q.found && (!xy_q.found || z_q.cost < xy_q.cost);
  always_ff @(posedge clk_i) begin
    xy_q <= y ? best[1] : best[0];
    z_q  <= best[2];
  end
  assign {found_o, plane_o} = z ? {z_q.found, z_q.plane} : {xy_q.found, xy_q.plane};
endmodule
