// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Builds one tree by rc_tbu_tb and a memory: bursts in order, `latency` cycles before the first beat, one beat a cycle for reads
// and writes together, whichever did not go last first.
// Usage: Vrc_tbu_tb MEMORY CFG_WORDS LATENCY MAX_CYCLES OUT
// MEMORY: bytes from address 0, read and overwritten. CFG_WORDS: tbu_cfg_t, 32-bit words in hexadecimal, low first, with commas.
// OUT: text; code, root, the words of tbu_stat_t, low first, then beats read and written.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>
#include <vector>

#include "Vtop.h"
#include "verilated.h"
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

namespace {
struct Beat {
    uint64_t due, byte;
    bool last;
};
struct Row {
    uint64_t data[4];
    uint8_t strb[4];
};
}  // namespace

int main(int argc, char** argv) {
    if (argc < 6) {
        std::fprintf(stderr, "error: usage: MEMORY CFG_WORDS LATENCY MAX_CYCLES OUT\n");
        return 1;
    }
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const auto top = std::make_unique<Vtop>(context.get());
    const uint64_t latency = std::strtoull(argv[3], nullptr, 0), max_cycles = std::strtoull(argv[4], nullptr, 0);

    std::FILE* file = std::fopen(argv[1], "r+b");
    if (!file) return std::fprintf(stderr, "error: cannot open %s\n", argv[1]), 1;
    std::fseek(file, 0, SEEK_END);
    std::vector<uint8_t> memory(std::ftell(file));
    std::rewind(file);
    if (std::fread(memory.data(), 1, memory.size(), file) != memory.size()) return 1;

    int word = 0;
    for (char* at = std::strtok(argv[2], ","); at; at = std::strtok(nullptr, ",")) top->cfg_i[word++] = std::strtoul(at, nullptr, 16);

    std::deque<Beat> reads;
    std::deque<uint64_t> addresses, answers;
    std::deque<Row> rows;
    Row row{};
    int beat = 0;
    uint64_t now = 0, read_beats = 0, write_beats = 0;
    bool done = false, read_last = false;
    top->clk_i = 0;
    top->rst_ni = 0;
    while (!done && now < max_cycles) {
        top->rst_ni = now > 3;
        top->start_i = now == 5;
        // One beat a cycle: an offered read beat, or room for a write beat.
        const bool can_read = !reads.empty() && reads.front().due <= now;
        const bool read_turn = can_read && (!top->m_axi_wvalid || !read_last);
        top->m_axi_rvalid = read_turn;
        if (read_turn) {
            uint64_t data = 0;
            if (reads.front().byte + 8 <= memory.size()) std::memcpy(&data, &memory[reads.front().byte], 8);
            top->m_axi_rdata = data;
            top->m_axi_rlast = reads.front().last;
        }
        top->m_axi_wready = !read_turn;
        top->m_axi_arready = 1;
        top->m_axi_awready = 1;
        top->m_axi_bvalid = !answers.empty() && answers.front() <= now;
        top->eval();
        if (top->m_axi_rvalid && top->m_axi_rready) {
            reads.pop_front();
            ++read_beats;
            read_last = true;
        }
        if (top->m_axi_bvalid && top->m_axi_bready) answers.pop_front();
        if (top->rst_ni && top->m_axi_arvalid)
            for (int b = 0; b < 8; ++b) reads.push_back({now + latency, top->m_axi_araddr + 8ULL * b, b == 7});
        if (top->rst_ni && top->m_axi_awvalid) addresses.push_back(top->m_axi_awaddr);
        if (top->rst_ni && top->m_axi_wvalid && top->m_axi_wready) {
            row.data[beat] = top->m_axi_wdata;
            row.strb[beat] = top->m_axi_wstrb;
            beat = (beat + 1) % 4;
            if (beat == 0) rows.push_back(row);
            ++write_beats;
            read_last = false;
        }
        while (!addresses.empty() && !rows.empty()) {
            for (int b = 0; b < 32; ++b) {
                const uint64_t byte = addresses.front() + b;
                if (byte < memory.size() && (rows.front().strb[b / 8] >> (b % 8) & 1))
                    memory[byte] = static_cast<uint8_t>(rows.front().data[b / 8] >> 8 * (b % 8));
            }
            addresses.pop_front();
            rows.pop_front();
            answers.push_back(now + latency);
        }
        done = top->done_o;
        top->clk_i = 1;
        top->eval();
        top->clk_i = 0;
        top->eval();
        ++now;
        context->timeInc(1);
    }
    std::FILE* out = std::fopen(argv[5], "w");
    if (!out) return 1;
    std::fprintf(out, "%d %u", top->err_o, top->root_o);
    for (size_t i = 0; i < sizeof(top->stat_o) / 4; ++i) std::fprintf(out, " %u", top->stat_o[i]);
    std::fprintf(out, " %llu %llu\n", (unsigned long long)read_beats, (unsigned long long)write_beats);
    std::fclose(out);
    std::rewind(file);
    std::fwrite(memory.data(), 1, memory.size(), file);
    std::fclose(file);
    top->final();
#if VM_COVERAGE
    context->coveragep()->write(context->coverageFilename().c_str());
#endif
    if (!done) std::fprintf(stderr, "error: not done after %llu cycles\n", (unsigned long long)now);
    return done ? 0 : 1;
}
