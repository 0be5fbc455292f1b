// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// What a ray does next, at the end of a pass (paper Sec. 3.4 and 3.7, docs/tni.md). Combinational.
//
// A tree is walked until nothing is left to visit, or the best hit lies before all of it. After the static tree (SCENE) the
// ray is done; after the top-level tree (TOP) comes the static tree; after an object's (OBJECT) the next object of the leaf
// from which it was entered, or what lies on the stack below. If the object left entries above that, a pass of its own (POP)
// reads the stack once more. Before a placed object is entered come three passes (ENTER) that bring the ray there.
module rc_tni_next import rc_pkg::*, rc_tni_pkg::*; (
  input  state_t     state_i,
  input  logic       act_i,                // the pass did its work: nothing it needed was missing
  input  step_t      step_i,               // TRAV: the last step
  input  entry_t     pop_i,                // what a pop brings
  input  logic [1:0] pushed_i,             // TRAV: entries
  input  logic       popped1_i,            // TRAV: step 2 pops what step 1 would have pushed
  input  idx_t       root_i,               // BOX, ENTER: of the tree in it; BOX of a placed object: its first row
  input  logic       placed_i,             // BOX: it is a placed object's
  input  logic       skips_i,              // BOX: in it is the triangle that the ray leaves from
  input  logic       last_i,               // of a list
  input  back_t      back_i,               // OBJECT, but for BOX
  input  logic       box_hit_i,
  input  fp_t        box_tmin_i,
  input  fp_t        box_tmax_i,
  input  logic       accept_i,             // ISECT: a nearer hit
  input  logic       over_i,               // ISECT: ... which ends the ray
  input  fp_t        t_i,
  input  logic       slack_i,
  input  logic       t_le_tmax_i,          // this hit, the best so far, against the leaf's end
  input  logic       best_le_tmax_i,
  input  logic       best_lt_stack_i,      // BOX, ISECT: best so far against the stack's top
  input  logic       best_lt_pop_i,        // TRAV, POP: best so far, ISECT: this hit, against what a pop brings
  output state_t     next_o,
  output logic       enters_o,             // goes into an object
  output logic       done_o
);
  logic [SP_W-1:0] base, sp;
  logic at_base, pop_far, finished, wanted, pops, statics;
  assign base     = (state_i.level == OBJECT) ? back_i.base : '0;
  assign at_base  = state_i.sp == base && !(state_i.mode == TRAV && popped1_i);
  assign pop_far  = (state_i.mode == BOX || (state_i.mode == ISECT && !accept_i)) ? best_lt_stack_i : best_lt_pop_i;
  assign finished = at_base || pop_far
                    || (state_i.mode == ISECT && (accept_i ? t_le_tmax_i : best_le_tmax_i));
  assign enters_o = act_i && state_i.mode == BOX && state_i.level == OBJECT && box_hit_i;

  always_comb begin
    next_o       = state_i;
    next_o.slots = state_i.slots + 1'b1;
    done_o       = 1'b0;
    wanted       = 1'b0;                   // nothing left here: pop, or this tree is finished
    pops         = 1'b0;                   // take what lies on the stack
    statics      = 1'b0;                   // on to the static tree
    sp           = state_i.sp;             // BOX, POP: of the top-level tree
    unique case (state_i.mode)
      BOX: begin
        next_o.mode   = placed_i ? ENTER : TRAV;
        next_o.idx    = root_i;
        next_o.tmin   = box_tmin_i;
        next_o.tmax   = box_tmax_i;
        next_o.placed = 1'b0;
        next_o.skips  = skips_i;
        if (!box_hit_i) begin
          unique case (state_i.level)
            OBJECT: begin                  // the next one of the leaf
              next_o.mode = BOX;
              next_o.idx  = state_i.idx + 1'b1;
              pops        = last_i && sp != '0 && !pop_far;
              statics     = last_i && (sp == '0 || pop_far);
            end
            TOP:     statics = 1'b1;
            default: done_o = 1'b1;
          endcase
        end
      end
      TRAV: begin
        next_o.mode   = (step_i.go != GO_LEAF) ? TRAV : (state_i.level == TOP) ? BOX : ISECT;
        next_o.level  = (step_i.go == GO_LEAF && state_i.level == TOP) ? OBJECT : state_i.level;
        next_o.direct = step_i.direct;
        next_o.idx    = step_i.idx;
        next_o.tmin   = step_i.tmin;
        next_o.tmax   = step_i.tmax;
        next_o.sp     = state_i.sp + SP_W'(pushed_i);
        wanted        = step_i.go == GO_POP;
      end
      ISECT: begin
        next_o.idx = state_i.idx + 1'b1;
        wanted     = last_i;
        if (accept_i) begin
          next_o.best  = t_i;
          next_o.slack = slack_i;
          next_o.hit   = 1'b1;
        end
      end
      ENTER: begin
        next_o.idx = state_i.idx + 1'b1;
        if (inst_half_t'(state_i.idx) == ROW_LAST) begin
          next_o.mode   = TRAV;
          next_o.placed = 1'b1;
          next_o.idx    = root_i;
        end
      end
      default: begin                       // POP
        pops    = !pop_far;
        statics = pop_far;
      end
    endcase

    if (wanted && !finished) pops = 1'b1;
    if (wanted && finished) begin
      unique case (state_i.level)
        OBJECT: begin
          next_o.sp = base;
          if (!back_i.last) begin
            next_o.mode   = BOX;
            next_o.direct = 1'b0;
            next_o.idx    = back_i.idx;
          end else if (base == '0 || (at_base && pop_far)) begin
            statics = 1'b1;
          end else if (at_base) begin
            pops         = 1'b1;
          end else begin
            next_o.mode  = POP;
            next_o.level = TOP;
          end
        end
        TOP:     statics = 1'b1;
        default: done_o = 1'b1;
      endcase
    end
    if (pops) begin
      next_o.mode = TRAV;
      next_o.idx  = pop_i.node;
      next_o.tmin = pop_i.tmin;
      next_o.tmax = pop_i.tmax;
      next_o.sp   = (popped1_i && state_i.mode == TRAV) ? sp : sp - 1'b1;
      if (state_i.level == OBJECT && (state_i.mode == BOX || finished)) next_o.level = TOP;
    end
    if (statics) begin
      next_o.mode  = BOX;
      next_o.level = SCENE;
      next_o.sp    = '0;
    end
    if (state_i.mode == ISECT && accept_i && over_i) done_o = 1'b1;   // others let a shadow ray go on (docs/whitted.md)
    if (!act_i) begin                      // the same again
      next_o       = state_i;
      next_o.slots = state_i.slots + 1'b1;
      done_o       = 1'b0;
    end
  end
  logic unused;
  assign unused = ^{step_i, back_i.inst};
endmodule
