// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Types shared by the setup unit and the colour buffer.
package rc_rgen_pkg;
  import rc_pkg::*;

  parameter int unsigned BLOCK_SLOTS = 16;  // blocks in work; a block stays until its last path ends
  typedef logic [$clog2(BLOCK_SLOTS)-1:0] blk_slot_t;

  typedef struct packed {                  // pixel of a block
    logic [2:0] y;
    logic [2:0] x;
  } pix_t;

  typedef struct packed {                  // a block to keep pixels for
    logic [6:0] count;                     // pixels inside the picture
    block_t     blk;
  } open_t;

  typedef struct packed {                  // where the colour of a ray index goes
    ray_id_t   id;
    blk_slot_t slot;
    pix_t      pix;
  } map_t;

  // Columns (or rows) of block number blk that lie inside a picture of that many, 1 to 8; blk is not outside.
  function automatic logic [3:0] inside_count(logic [12:0] blk, logic [15:0] size);
    logic [15:0] rest;
    rest = size - {blk, 3'b000};
    return (rest[15:3] != '0) ? 4'd8 : {1'b0, rest[2:0]};
  endfunction
endpackage
