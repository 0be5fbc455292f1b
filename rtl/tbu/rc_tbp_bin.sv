// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Binning pipeline (paper Sec. 3.7): the upper nodes of a tree, down to subtrees that a sorting pipeline can hold. Reads the
// triangles once, then two levels by two reads and one write of each list. An object of at most Cap triangles is one job
// that is read from its vertices elsewhere; nothing of it goes through here.
// Rate: a (reference, member) pair a cycle, a reference from vertices in three cycles; about 150 cycles between passes.
// SRAM: bins 15,360 + line queue 8,192 + pending nodes 16,192 bits = 4.9 KB; the paper's has 13.42 KB. Multipliers: 9.
module rc_tbp_bin import rc_pkg::*; import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; #(
  parameter int unsigned Cap = 1280                  // references of a sorting pipeline, multiple of 4
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  tbu_cfg_t   cfg_i,
  input  logic       start_i,                        // for one cycle
  output logic       busy_o,
  output logic       full_o,                         // working memory is too small: it waits for its reset
  output logic       waits_o,                        // for a place in the job ring or the table of upper nodes
  output logic       bad_o,                          // for one cycle: a coordinate outside
  output logic       req_valid_o,                    // lines to read
  input  logic       req_ready_i,
  output line_addr_t req_addr_o,
  input  logic       rsp_valid_i,
  input  block64_t   rsp_block_i,
  output logic       wr_valid_o,                     // references, and entries of leaves
  input  logic       wr_ready_i,
  output tbu_wr_t    wr_o,
  input  logic       wr_confirmed_i,                 // no row of references is on its way
  output logic       split_valid_o,                  // an upper node, to rc_tbu_upper
  input  logic       split_ready_i,
  output split_t     split_o,
  input  logic [6:0] split_entry_i,
  output logic       leaf_valid_o,                   // a leaf, likewise; its list is written here
  input  logic       leaf_ready_i,
  output leaf_t      leaf_o,
  output logic       ids_req_o,                      // room for ids_count_o list entries in one piece
  input  logic       ids_gnt_i,
  input  idx_t       ids_idx_i,
  output count_t     ids_count_o,
  output logic       job_valid_o,
  input  logic       job_ready_i,
  output list_job_t  job_o,
  input  logic       job_read_i                      // the oldest job's list was read
);
  logic    pass_start, pass_done, plane_valid;
  pass_t   pass;
  binned_t [NUM_SLOTS-1:0] member;
  slot_t   plane_slot;
  plane_t  plane;
  rc_tbp_bin_ctrl #(.Cap(Cap)) u_ctrl (
    .clk_i, .rst_ni, .cfg_i, .start_i, .busy_o, .full_o, .waits_o,
    .pass_start_o(pass_start), .pass_o(pass), .member_o(member), .pass_done_i(pass_done),
    .plane_valid_i(plane_valid), .plane_slot_i(plane_slot), .plane_i(plane),
    .split_valid_o, .split_ready_i, .split_o, .split_entry_i, .leaf_valid_o, .leaf_ready_i, .leaf_o,
    .ids_req_o, .ids_gnt_i, .ids_idx_i, .ids_count_o, .job_valid_o, .job_ready_i, .job_o, .job_read_i
  );
  rc_tbp_bin_pass u_pass (
    .clk_i, .rst_ni, .start_i(pass_start), .pass_i(pass), .member_i(member), .done_o(pass_done),
    .plane_valid_o(plane_valid), .plane_slot_o(plane_slot), .plane_o(plane), .bad_o,
    .tri_first_i(cfg_i.tri_first),
    .req_valid_o, .req_ready_i, .req_addr_o, .rsp_valid_i, .rsp_block_i,
    .wr_valid_o, .wr_ready_i, .wr_o, .wr_confirmed_i
  );
endmodule
