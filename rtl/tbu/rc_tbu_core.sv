// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// The tree-building unit without its sorting pipelines (paper Sec. 3.7): the binning pipeline, the loader of jobs, the table
// of upper nodes, extents, memory ports, and the order of a build:
//   start_i -> all is cleared -> run -> the root's address is known, every row is confirmed -> done_o
// An error holds what goes to memory, waits for what is on its way and ends with err_o; the next build starts clean.
module rc_tbu_core import rc_pkg::*; import rc_tbu_pkg::*; import rc_tbp_bin_pkg::*; #(
  parameter  int unsigned Cap = 1280,                // references of a sorting pipeline, multiple of 4
  localparam int unsigned N   = NUM_SORTERS
) (
  input  logic       clk_i,
  input  logic       rst_ni,
  input  logic       start_i,                        // for one cycle, when not busy
  input  tbu_cfg_t   cfg_i,                          // constant while busy
  output logic       busy_o,
  output logic       done_o,                         // for one cycle; what follows stays
  output tbu_err_e   err_o,
  output idx_t       root_o,                         // NODE_NONE: no tree, or an error
  output tbu_stat_t  stat_o,
  output logic       rd_valid_o,                     // a client of rc_mem_rd
  input  logic       rd_ready_i,
  output line_addr_t rd_addr_o,
  input  logic       rd_rsp_valid_i,
  input  block64_t   rd_rsp_block_i,
  output logic       wr_valid_o,                     // rc_mem_wr
  input  logic       wr_ready_i,
  output addr_t      wr_addr_o,
  output logic [7:0][31:0] wr_data_o,
  output logic [7:0] wr_strb_o,
  input  logic       wr_ack_i,
  input  logic       wr_idle_i,                      // no row is on its way
  input  logic       mem_err_i,                      // either reported an error
  output logic       sort_rst_no,                    // to the sorting pipelines, i of each port to pipeline i
  input  logic       [N-1:0] sort_idle_i,            // nothing inside that must be written
  input  logic       [N-1:0] ev_forced_i,            // a leaf was made because lists were full
  output logic       [N-1:0] job_valid_o,
  input  logic       [N-1:0] job_ready_i,
  output sort_job_t  [N-1:0] job_o,
  output logic       [N-1:0] ref_valid_o,
  input  logic       [N-1:0] ref_ready_i,
  output tri_ref_t   [N-1:0] ref_o,
  output logic       don_want_o,
  input  logic       [N-1:0] don_valid_i,
  output logic       [N-1:0] don_ready_o,
  input  sort_job_t  [N-1:0] don_job_i,
  input  logic       [N-1:0] don_ref_valid_i,
  output logic       [N-1:0] don_ref_ready_o,
  input  tri_ref_t   [N-1:0] don_ref_i,
  output logic       [N-1:0] ent_valid_o,
  input  logic       [N-1:0] ent_ready_i,
  output logic [6:0] ent_idx_o,
  input  logic       [N-1:0] donated_valid_i,
  output logic       [N-1:0] donated_ready_o,
  input  donated_t   [N-1:0] donated_i,
  input  logic       [N-1:0] sub_valid_i,
  output logic       [N-1:0] sub_ready_o,
  input  subtree_t   [N-1:0] sub_i,
  input  logic       [N-1:0][1:0] ext_req_i,         // [0] nodes, [1] list entries
  input  logic       [N-1:0][3:0] ext_num_i,
  output logic       [N-1:0][1:0] ext_gnt_o,         // one at a time
  output idx_t       [N-1:0] ext_idx_o,              // of the one granted
  input  logic       [N-1:0] row_valid_i,
  output logic       [N-1:0] row_ready_o,
  input  tbu_wr_t    [N-1:0] row_i
);
  localparam int unsigned NUM_W = COUNT_W - $clog2(LIST_EXTENT) + 1;

  // ---- the order of a build ------------------------------------------------------------------------------------
  typedef enum logic [2:0] {IDLE, CLEAR, BEGIN_BUILD, RUN, HALT, DONE} state_e;
  state_e   state_q;
  tbu_err_e err;
  logic     clear_n, begin_build, bin_busy, reads_idle, rows_gone, tree_done, finished, quiet;
  logic     ref_full, node_full, list_full, bin_bad, load_bad, bus_bad_q;
  idx_t     root;
  assign clear_n     = rst_ni && state_q != CLEAR;
  assign sort_rst_no = clear_n;
  assign begin_build = state_q == BEGIN_BUILD;
  assign busy_o      = state_q != IDLE;
  assign done_o      = state_q == DONE;
  assign quiet       = reads_idle && wr_idle_i;
  assign finished    = tree_done && !bin_busy && sort_idle_i == '1 && rows_gone && quiet;
  always_comb begin
    err = TBU_OK;
    if (bus_bad_q)           err = TBU_BUS;
    if (node_full)           err = TBU_NODE;
    if (list_full)           err = TBU_LIST;
    if (ref_full)            err = TBU_REF;
    if (bin_bad || load_bad) err = TBU_COORD;
    if (cfg_i.tri_count > count_t'(1 << TRI_W)) err = TBU_COUNT;
  end
  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      state_q   <= IDLE;
      err_o     <= TBU_OK;
      bus_bad_q <= 1'b0;
    end else begin
      bus_bad_q <= mem_err_i;
      case (state_q)
        IDLE:        if (start_i) state_q <= CLEAR;
        CLEAR: begin
          err_o   <= TBU_OK;
          state_q <= BEGIN_BUILD;
        end
        BEGIN_BUILD, RUN: begin
          if (err != TBU_OK) begin
            err_o   <= err;
            state_q <= HALT;
          end else begin
            state_q <= (state_q == RUN && finished) ? DONE : RUN;
          end
        end
        HALT:    if (quiet) state_q <= DONE;
        default: state_q <= IDLE;
      endcase
    end
    if (!rst_ni || state_q == CLEAR)                      root_o <= NODE_NONE;
    else if (state_q == RUN && finished && err == TBU_OK) root_o <= root;
  end

  // ---- binning, loading, routing ---------------------------------------------------------------------------------
  logic       [1:0] req_valid, req_ready, rsp_valid;
  line_addr_t [1:0] req_addr;
  logic       bin_wr_valid, bin_wr_ready, confirmed, split_valid, split_ready, leaf_valid, leaf_ready, upper_wr_valid;
  logic       upper_wr_ready, ids_req, ids_gnt, job_valid, job_ready, job_read, bin_waits;
  tbu_wr_t    bin_wr, upper_wr;
  split_t     split;
  leaf_t      leaf;
  logic [6:0] split_entry;
  count_t     ids_count;
  list_job_t  list_job;
  idx_t       node_idx, list_idx;
  rc_tbp_bin #(.Cap(Cap)) u_bin (
    .clk_i, .rst_ni(clear_n), .cfg_i, .start_i(begin_build && err == TBU_OK), .busy_o(bin_busy), .full_o(ref_full),
    .bad_o(bin_bad), .waits_o(bin_waits),
    .req_valid_o(req_valid[0]), .req_ready_i(req_ready[0]), .req_addr_o(req_addr[0]), .rsp_valid_i(rsp_valid[0]),
    .rsp_block_i(rd_rsp_block_i), .wr_valid_o(bin_wr_valid), .wr_ready_i(bin_wr_ready), .wr_o(bin_wr),
    .wr_confirmed_i(confirmed), .split_valid_o(split_valid), .split_ready_i(split_ready), .split_o(split),
    .split_entry_i(split_entry), .leaf_valid_o(leaf_valid), .leaf_ready_i(leaf_ready), .leaf_o(leaf),
    .ids_req_o(ids_req), .ids_gnt_i(ids_gnt), .ids_idx_i(list_idx), .ids_count_o(ids_count),
    .job_valid_o(job_valid), .job_ready_i(job_ready), .job_o(list_job), .job_read_i(job_read)
  );
  logic      load_waiting, load_valid, load_ready, load_ref_valid, load_ref_ready;
  sort_job_t load_job;
  tri_ref_t  load_ref;
  rc_tbu_load u_load (
    .clk_i, .rst_ni(clear_n), .vertex_base_i(cfg_i.vertex_base), .tri_first_i(cfg_i.tri_first),
    .ref_base_i(cfg_i.ref_base),
    .in_valid_i(job_valid), .in_ready_o(job_ready), .in_i(list_job), .read_o(job_read), .bad_o(load_bad),
    .req_valid_o(req_valid[1]), .req_ready_i(req_ready[1]), .req_addr_o(req_addr[1]), .rsp_valid_i(rsp_valid[1]),
    .rsp_block_i(rd_rsp_block_i), .waiting_o(load_waiting),
    .job_valid_o(load_valid), .job_ready_i(load_ready), .job_o(load_job),
    .ref_valid_o(load_ref_valid), .ref_ready_i(load_ref_ready), .ref_o(load_ref)
  );
  rc_tbu_route u_route (
    .clk_i, .rst_ni(clear_n), .load_waiting_i(load_waiting), .load_valid_i(load_valid), .load_ready_o(load_ready),
    .load_job_i(load_job), .load_ref_valid_i(load_ref_valid), .load_ref_ready_o(load_ref_ready), .load_ref_i(load_ref),
    .want_o(don_want_o), .don_valid_i, .don_ready_o, .don_job_i, .don_ref_valid_i, .don_ref_ready_o, .don_ref_i,
    .job_valid_o, .job_ready_i, .job_o, .ref_valid_o, .ref_ready_i, .ref_o
  );

  // ---- upper nodes, extents: the last client is the binning pipeline ------------------------------------------------
  logic [N:0] node_req, node_gnt, list_req, list_gnt;
  logic [N:0][NUM_W-1:0] list_num;
  assign list_num[N] = NUM_W'(ids_count >> $clog2(LIST_EXTENT)) + NUM_W'(ids_count[$clog2(LIST_EXTENT)-1:0] != '0);
  assign list_req[N] = ids_req;
  assign ids_gnt     = list_gnt[N];
  for (genvar i = 0; i < N; i++) begin : gen_ext
    assign node_req[i]  = ext_req_i[i][0];
    assign list_req[i]  = ext_req_i[i] == 2'b10;
    assign list_num[i]  = NUM_W'(ext_num_i[i]);
    assign ext_gnt_o[i] = {list_gnt[i], node_gnt[i]};
    assign ext_idx_o[i] = node_gnt[i] ? node_idx : list_idx;
  end
  rc_tbu_upper u_upper (
    .clk_i, .rst_ni(clear_n), .split_valid_i(split_valid), .split_ready_o(split_ready), .split_i(split),
    .split_entry_o(split_entry), .leaf_valid_i(leaf_valid), .leaf_ready_o(leaf_ready), .leaf_i(leaf),
    .ent_offer_i(~job_ready_i), .ent_ready_i, .ent_valid_o, .ent_idx_o,
    .don_valid_i(donated_valid_i), .don_ready_o(donated_ready_o),
    .don_i(donated_i), .sub_valid_i, .sub_ready_o, .sub_i,
    .ext_req_o(node_req[N]), .ext_gnt_i(node_gnt[N]), .ext_idx_i(node_idx),
    .wr_valid_o(upper_wr_valid), .wr_ready_i(upper_wr_ready), .wr_o(upper_wr),
    .done_o(tree_done), .root_o(root)
  );
  rc_tbu_alloc #(.NumClients(N + 1)) u_alloc (
    .clk_i, .rst_ni(clear_n), .node_first_i(cfg_i.node_first), .node_count_i(cfg_i.node_count),
    .list_first_i(cfg_i.list_first), .list_count_i(cfg_i.list_count),
    .node_req_i(node_req), .node_gnt_o(node_gnt), .node_idx_o(node_idx),
    .list_req_i(list_req), .list_num_i(list_num), .list_gnt_o(list_gnt), .list_idx_o(list_idx),
    .node_full_o(node_full), .list_full_o(list_full)
  );

  // ---- memory ----------------------------------------------------------------------------------------------------------
  logic ev_line, ev_row;
  logic [2:0] ev_nodes, ev_jumps;
  logic [3:0] ev_entries;
  rc_tbu_port #(.NumWriters(N + 2)) u_port (
    .clk_i, .rst_ni(clear_n), .halt_i(state_q != RUN), .reads_idle_o(reads_idle), .rows_gone_o(rows_gone),
    .node_base_i(cfg_i.node_base), .list_base_i(cfg_i.list_base), .ref_base_i(cfg_i.ref_base),
    .req_valid_i(req_valid), .req_ready_o(req_ready), .req_addr_i(req_addr), .rsp_valid_o(rsp_valid),
    .wr_valid_i({bin_wr_valid, upper_wr_valid, row_valid_i}), .wr_ready_o({bin_wr_ready, upper_wr_ready, row_ready_o}),
    .wr_i({bin_wr, upper_wr, row_i}), .confirmed_o(confirmed), .ev_line_o(ev_line), .ev_row_o(ev_row),
    .ev_nodes_o(ev_nodes), .ev_entries_o(ev_entries), .ev_jumps_o(ev_jumps),
    .rd_valid_o, .rd_ready_i, .rd_addr_o, .rd_rsp_valid_i,
    .wr_valid_o, .wr_ready_i, .wr_addr_o, .wr_data_o, .wr_strb_o, .wr_ack_i
  );
  always_ff @(posedge clk_i) begin
    if (!rst_ni || state_q == CLEAR) begin
      stat_o <= '0;
    end else if (state_q == RUN) begin
      stat_o.cycles    <= stat_o.cycles + 1'b1;
      stat_o.jobs      <= stat_o.jobs + 32'(load_valid && load_ready);
      stat_o.donations <= stat_o.donations + 32'((don_valid_i & don_ready_o) != '0);
      stat_o.lines     <= stat_o.lines + 32'(ev_line);
      stat_o.forced    <= stat_o.forced + 32'($countones(ev_forced_i));
      stat_o.waits     <= stat_o.waits + 32'(bin_waits);
      if (ev_row) begin
        stat_o.rows    <= stat_o.rows + 1'b1;
        stat_o.nodes   <= stat_o.nodes + 32'(ev_nodes);
        stat_o.jumps   <= stat_o.jumps + 32'(ev_jumps);
        stat_o.entries <= stat_o.entries + 32'(ev_entries);
      end
    end
  end
endmodule
