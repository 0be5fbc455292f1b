// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// One kd-tree traversal step, decided from the comparisons of t at the split plane (paper Sec. 3.4,
// traversal mode; slack of 1 ulp as docs/tni.md). Combinational.
//
// near_only_i: ts > tmax + 1 ulp, far_only_i: ts < tmin - 1 ulp, whole_i: the ray lies in the plane.
// Empty children are neither visited nor pushed; with nothing left to visit the step pops.
module rc_tni_step import rc_pkg::*, rc_tni_pkg::*; (
  input  visit_t visit_i,
  input  fp_t    ts_i,
  input  logic   whole_i,
  input  logic   near_only_i,
  input  logic   far_only_i,
  input  logic   ts_lt_tmin_i,
  input  logic   ts_gt_tmax_i,
  output step_t  step_o
);
  node_t node;
  idx_t  adjacent, near, far;
  logic  leaf, near_adjacent, near_empty, far_empty, near_only, far_only, both, go_near, go_far;
  fp_t   near_max, far_min;

  assign node          = visit_i.node;
  assign leaf          = node.axis == 2'd3;
  assign adjacent      = visit_i.idx + 1'b1;
  assign near_adjacent = node.swap == visit_i.neg;
  assign near          = near_adjacent ? adjacent : node.other;
  assign far           = near_adjacent ? node.other : adjacent;
  assign near_empty    = visit_i.neg ? node.upper_empty : node.lower_empty;
  assign far_empty     = visit_i.neg ? node.lower_empty : node.upper_empty;

  assign near_only = near_only_i && !whole_i;
  assign far_only  = far_only_i && !whole_i;
  assign both      = !near_only && !far_only;
  assign near_max  = (!both || whole_i) ? visit_i.tmax : ts_lt_tmin_i ? visit_i.tmin : ts_i;
  assign far_min   = (!both || whole_i) ? visit_i.tmin : ts_gt_tmax_i ? visit_i.tmax : ts_i;
  assign go_near   = !far_only && !near_empty;
  assign go_far    = !near_only && !far_empty;

  always_comb begin
    step_o          = '0;
    step_o.far_child    = '{node: far, tmin: far_min, tmax: visit_i.tmax};
    step_o.tmin     = visit_i.tmin;
    step_o.tmax     = visit_i.tmax;
    step_o.idx      = node.other;
    step_o.direct   = node.split[19:0] == 20'd1;
    if (leaf) begin
      step_o.go = (node.split[19:0] == 20'd0) ? GO_POP : GO_LEAF;
    end else if (go_near) begin
      step_o.go       = GO_NODE;
      step_o.idx      = near;
      step_o.adjacent = near_adjacent;
      step_o.tmax     = near_max;
      step_o.push     = go_far;
    end else if (go_far) begin
      step_o.go       = GO_NODE;
      step_o.idx      = far;
      step_o.adjacent = !near_adjacent;
      step_o.tmin     = far_min;
    end else begin
      step_o.go = GO_POP;
    end
  end

  logic unused;
  assign unused = ^node.zero;
endmodule
