// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Counts to the number given, in C++; exits 1 if the counter disagrees.
#include <cstdlib>
#include "Vtop.h"
#include "verilated.h"
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

int main(int argc, char** argv) {
  VerilatedContext ctx;
  ctx.commandArgs(argc, argv);
  Vtop top{&ctx};
  const int cycles = argc > 1 ? std::atoi(argv[1]) : 0;
  top.rst_ni = 0;
  for (int i = 0; i < cycles + 1; i++) {
    top.clk_i = 0;
    top.eval();
    top.clk_i = 1;
    top.eval();
    top.rst_ni = 1;
    top.en_i = 1;
  }
#if VM_COVERAGE
  ctx.coveragep()->write();
#endif
  std::printf("count %d\n", static_cast<int>(top.count_o));
  return top.count_o == cycles % 256 ? 0 : 1;
}
