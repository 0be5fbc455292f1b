// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Streams operands through rc_fp_all, one triple a cycle, and its results back, each after its unit's latency.
// Usage: Vrc_fp_all OPERANDS RESULTS
// OPERANDS: uint32, n of a, then n of b, then n of c. RESULTS: uint32, n of each output in the order of PORTS.
#include <cstdint>
#include <cstdio>
#include <memory>
#include <vector>

#include "Vtop.h"
#include "verilated.h"
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

namespace {
constexpr int PORTS = 11;

int fail(const char* what, const char* path) {
    std::fprintf(stderr, "error: cannot %s %s\n", what, path);
    return 1;
}
}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) return fail("run without", "OPERANDS RESULTS");
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const auto top = std::make_unique<Vtop>(context.get());

    std::FILE* in = std::fopen(argv[1], "rb");
    if (!in) return fail("open", argv[1]);
    std::fseek(in, 0, SEEK_END);
    const size_t n = std::ftell(in) / (3 * sizeof(uint32_t));
    std::rewind(in);
    std::vector<uint32_t> op(3 * n), out(PORTS * n);
    if (std::fread(op.data(), sizeof(uint32_t), op.size(), in) != op.size()) return fail("read", argv[1]);
    std::fclose(in);

    top->eval();
    const size_t one = top->one_o, two = top->two_o, five = top->five_o, most = five > two ? five : two;
    const size_t latency[PORTS] = {two, two, one, two, one, two, one, one, one, one, five};
    for (size_t i = 1; i < n + most; ++i) {                   // i: clock edges so far
        const size_t j = i <= n ? i - 1 : n - 1;
        top->a_i = op[j];
        top->b_i = op[n + j];
        top->c_i = op[2 * n + j];
        top->clk_i = 1;
        top->eval();
        const uint32_t y[PORTS] = {top->add_o,  top->add3_o,      top->mul_o,       top->div_o,    top->cmp_o,
                                   top->sqrt_o, top->from_sint_o, top->from_ufix_o, top->unorm8_o, top->unorm10_o, top->pow_o};
        for (int p = 0; p < PORTS; ++p)
            if (i >= latency[p] && i - latency[p] < n) out[p * n + i - latency[p]] = y[p];
        top->clk_i = 0;
        top->eval();
    }
    top->final();
#if VM_COVERAGE
    context->coveragep()->write();
#endif

    std::FILE* f = std::fopen(argv[2], "wb");
    if (!f) return fail("open", argv[2]);
    if (std::fwrite(out.data(), sizeof(uint32_t), out.size(), f) != out.size()) return fail("write", argv[2]);
    std::fclose(f);
    return 0;
}
