// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Types of the memory ports.
package rc_mem_pkg;
  import rc_pkg::*;
  // A region that may be read or written, in lines: lo <= line < hi. The end has one bit more, so a
  // region may reach the end of the address space; lo = hi is empty.
  typedef struct packed {
    line_addr_t             lo;
    logic [LINE_ADDR_W:0]   hi;
  } window_t;

  parameter logic [1:0] AXI_BURST_INCR  = 2'b01;
  parameter logic [1:0] AXI_RESP_DECERR = 2'b11;   // bit 1: an error of either kind
endpackage
