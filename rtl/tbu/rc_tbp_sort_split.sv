// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// How a node of a sorting pipeline is divided: boxes of its children, where their lists go, which of them need lists of
// events, and what becomes of them. Combinational; nothing here changes while a walk or sweep of the node is under way.
//   List A runs up from 0, list B down from its first place; the child with its lists in A is made first. Whichever end
//   the node's lists lie at, the child that stays there is written behind what is read, and the other one moves.
module rc_tbp_sort_split import rc_tbu_pkg::*, rc_tbp_sort_pkg::*; (
  input  tnode_t          node_i,
  input  logic            root_i,          // only its own plane is sought: it is child 0
  input  logic            donate_i,        // the child whose lists would go to A leaves
  input  ptr_t            refs_free_i,     // highest free places, where the node lies in A
  input  ptr_t [2:0]      free_i,
  input  num_t [2:0][1:0] num_events_i,    // of the children on each axis
  input  logic [1:0]      keep_i,          // as keep_o when it was valid
  input  logic [1:0]      found_i,         // planes of the children that pay
  input  plane_t [1:0]    plane_i,
  input  logic [1:0][TRI_W-1:0] last_tri_idx_i,
  output logic            both_o,          // there are two children
  output logic            refs_fit_o,      // there is room for the list of references that moves
  output logic            misfit_o,        // there is none for the lists of events: makes a leaf
  output logic [1:0]      keep_o,          // children that need lists of events; valid with num_events_i
  output box_t [1:0]      box_o,
  output num_t [1:0]      num_refs_o,
  output walk_t           walk_o,
  output sweep_t [2:0]    sweep_o,
  output tnode_t [1:0]    child_o,
  output logic            first_o,         // child that is made first, 1 the upper one
  output ptr_t            refs_free_o,     // free places while it is made
  output ptr_t [2:0]      free_o
);
  plane_t     cut;
  num_t [1:0] num;
  ptr_t       refs_b;                      // first places in B
  ptr_t [2:0] first_b;
  logic       b, moved_refs, moved;        // child in B, those whose lists change ends: 1 the upper one
  logic [2:0] fit;
  assign cut        = node_i.plane;
  assign num        = {cut.nr, cut.nl};
  assign both_o     = cut.nl != '0 && cut.nr != '0;
  assign b          = node_i.b_upper;
  assign refs_b     = node_i.refs_in_b ? node_i.refs : refs_free_i;
  assign moved_refs = b ^ node_i.refs_in_b;
  assign moved      = b ^ node_i.in_b;
  assign refs_fit_o = ptr_t'(node_i.count) + ptr_t'(num[moved_refs]) <= refs_b + ptr_t'(1);
  assign misfit_o   = num[moved] > num_t'(MAX_LEAF) && fit != '1;
  assign num_refs_o = root_i ? {num_t'(0), node_i.count} : num;
  assign first_o    = both_o ? donate_i == b : cut.nl == '0;
  assign refs_free_o = refs_b - ptr_t'(num[b]);
  assign walk_o     = '{divide: node_i.split, donate: donate_i, in_b: node_i.refs_in_b, first: node_i.refs,
                        num: node_i.count, b_upper: b, first_b: refs_b};
  always_comb begin
    box_o = {2{node_i.box}};
    if (!root_i) begin
      box_o[0].hi[cut.axis] = cut.pos;
      box_o[1].lo[cut.axis] = cut.pos;
    end
  end
  for (genvar a = 0; a < 3; a++) begin : gen_axis
    assign first_b[a] = node_i.in_b ? node_i.events[a] : free_i[a];
    assign fit[a]     = ptr_t'(node_i.num_events[a]) + ptr_t'(num_events_i[a][moved]) <= first_b[a] + ptr_t'(1);
    assign free_o[a]  = first_b[a] - ptr_t'(child_o[b].num_events[a]);
    always_comb begin
      sweep_o[a] = '{root: root_i, in_b: node_i.in_b, first: node_i.events[a], num: node_i.num_events[a],
                     cut: !root_i && cut.axis == 2'(a), pos: cut.pos, b_upper: b, first_b: first_b[a],
                     keep: root_i ? 2'b01 : keep_i, num_refs: num_refs_o,
                     span: {box_o[1].hi[a], box_o[1].lo[a], box_o[0].hi[a], box_o[0].lo[a]}};
    end
  end
  for (genvar c = 0; c < 2; c++) begin : gen_child
    logic   in_b, swap;
    plane_t p;
    coord_t lo, hi;
    assign in_b = b == 1'(c);
    assign p    = plane_i[c];
    assign lo   = box_o[c].lo[p.axis];
    assign hi   = box_o[c].hi[p.axis];
    // Adjacent is the child that is not empty, else the larger one: across the axis their extents are the same.
    assign swap = p.nl == '0 || (p.nr != '0 && {1'b0, lo} + {1'b0, hi} > {p.pos, 1'b0});
    assign keep_o[c] = num[c] > num_t'(MAX_LEAF) && node_i.level + level_t'(1) < level_t'(MAX_DEPTH)
                       && !(moved == 1'(c) && fit != '1) && (in_b || !donate_i);
    always_comb begin
      child_o[c] = '{box: box_o[c], level: node_i.level + level_t'(1), count: num[c], split: keep_i[c] && found_i[c],
                     plane: p, swap: swap, b_upper: 1'b0, tri_idx: last_tri_idx_i[c], refs_in_b: in_b, in_b: in_b,
                     refs: in_b ? refs_b : '0, events: '0, num_events: '0};
      if (root_i) begin
        child_o[c]         = node_i;
        child_o[c].split   = found_i[c];
        child_o[c].plane   = p;
        child_o[c].swap    = swap;
      end else begin
        for (int a = 0; a < 3; a++) begin
          if (in_b) child_o[c].events[a] = first_b[a];
          if (keep_i[c]) child_o[c].num_events[a] = num_events_i[a][c];
        end
      end
      // The adjacent child waits in B; an only child stays where it is.
      child_o[c].b_upper = (p.nl != '0 && p.nr != '0) ? swap : child_o[c].in_b ? p.nl == '0 : p.nr == '0;
    end
  end
endmodule
