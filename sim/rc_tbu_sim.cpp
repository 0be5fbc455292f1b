// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Builds one tree by rc_tbu_sim_top and a memory of 64 bits: bursts in order, latency cycles to the first beat and to a write's
// answer, one beat a cycle for reads and writes together, in turn where both want it; random pauses.
// Usage: Vrc_tbu_sim_top MEMORY CFG LATENCY OUTSTANDING BACKPRESSURE SEED MAX_CYCLES OUT
// MEMORY: bytes from address 0, read and overwritten. CFG: tbu_cfg_t, 32-bit words in hexadecimal, low first, with commas.
// OUT: text; tbu_err_e, root, the words of tbu_stat_t, low first. Exits 2 if the build is not done after MAX_CYCLES.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>
#include <random>
#include <vector>

#include "Vtop.h"
#include "verilated.h"
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

namespace {
constexpr int BEATS_LINE = 8, BEATS_ROW = 4, BEAT_B = 8;
constexpr int EXIT_HANGS = 2;

struct Beat {
  uint64_t due, byte;
  bool last;
};
struct Row {
  uint64_t data[BEATS_ROW];
  uint8_t strb[BEATS_ROW];
};

int fail(const char* what, const char* path) {
  std::fprintf(stderr, "error: cannot %s %s\n", what, path);
  return 1;
}
}  // namespace

int main(int argc, char** argv) {
  if (argc < 9) return fail("run without", "MEMORY CFG LATENCY OUTSTANDING BACKPRESSURE SEED MAX_CYCLES OUT");
  const auto context = std::make_unique<VerilatedContext>();
  context->commandArgs(argc, argv);
  const auto top = std::make_unique<Vtop>(context.get());
  const uint64_t latency = std::strtoull(argv[3], nullptr, 0);
  const size_t outstanding = std::strtoull(argv[4], nullptr, 0);
  std::mt19937_64 random(std::strtoull(argv[6], nullptr, 0));
  std::bernoulli_distribution pauses(std::strtod(argv[5], nullptr));
  const bool pausing = std::strtod(argv[5], nullptr) > 0.0;
  const uint64_t max_cycles = std::strtoull(argv[7], nullptr, 0);
  const auto go = [&] { return !pausing || !pauses(random); };

  std::FILE* file = std::fopen(argv[1], "r+b");
  if (!file) return fail("open", argv[1]);
  std::fseek(file, 0, SEEK_END);
  std::vector<uint8_t> memory(std::ftell(file));
  std::rewind(file);
  if (std::fread(memory.data(), 1, memory.size(), file) != memory.size()) return fail("read", argv[1]);
  int word = 0;
  for (char* at = std::strtok(argv[2], ","); at; at = std::strtok(nullptr, ","))
    top->cfg_i[word++] = std::strtoul(at, nullptr, 16);

  std::deque<Beat> reads;                            // beats to give, in order
  std::deque<uint64_t> addresses, answers;           // of rows to come; times
  std::deque<Row> rows;
  Row row{};
  int beat = 0;
  uint64_t now = 0;
  bool done = false, read_last = false, read_held = false, answer_held = false;
  top->clk_i = 0;
  for (; !done && now < max_cycles; ++now) {
    top->rst_ni = now > 3;
    top->start_i = now == 5;
    // The bus carries a read beat, or has room for a write beat; what was offered stays offered.
    const bool due = !reads.empty() && reads.front().due <= now;
    read_held = read_held || (due && (!top->m_axi_wvalid || !read_last) && go());
    top->m_axi_rvalid = read_held;
    if (read_held) {
      uint64_t data = 0;
      if (reads.front().byte + BEAT_B <= memory.size()) std::memcpy(&data, &memory[reads.front().byte], BEAT_B);
      top->m_axi_rdata = data;
      top->m_axi_rlast = reads.front().last;
    }
    answer_held = answer_held || (!answers.empty() && answers.front() <= now && go());
    top->m_axi_bvalid = answer_held;
    top->m_axi_wready = !read_held && go();
    top->m_axi_arready = reads.size() <= (outstanding - 1) * BEATS_LINE && go();
    top->m_axi_awready = addresses.size() + rows.size() + answers.size() < outstanding && go();
    top->eval();
    if (read_held && top->m_axi_rready) {
      reads.pop_front();
      read_held = false;
      read_last = true;
    }
    if (answer_held && top->m_axi_bready) {
      answers.pop_front();
      answer_held = false;
    }
    if (top->rst_ni && top->m_axi_arvalid && top->m_axi_arready)
      for (int b = 0; b < BEATS_LINE; ++b)
        reads.push_back({now + latency, uint64_t{top->m_axi_araddr} + uint64_t(BEAT_B * b), b == BEATS_LINE - 1});
    if (top->rst_ni && top->m_axi_awvalid && top->m_axi_awready) addresses.push_back(top->m_axi_awaddr);
    if (top->rst_ni && top->m_axi_wvalid && top->m_axi_wready) {
      row.data[beat] = top->m_axi_wdata;
      row.strb[beat] = top->m_axi_wstrb;
      beat = (beat + 1) % BEATS_ROW;
      if (beat == 0) rows.push_back(row);
      read_last = false;
    }
    while (!addresses.empty() && !rows.empty()) {
      for (int b = 0; b < BEATS_ROW * BEAT_B; ++b) {
        const uint64_t byte = addresses.front() + b;
        if (byte < memory.size() && (rows.front().strb[b / BEAT_B] >> (b % BEAT_B) & 1))
          memory[byte] = static_cast<uint8_t>(rows.front().data[b / BEAT_B] >> 8 * (b % BEAT_B));
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
    context->timeInc(1);
  }
  std::FILE* out = std::fopen(argv[8], "w");
  if (!out) return fail("write", argv[8]);
  std::fprintf(out, "%d %u", top->err_o, top->root_o);
  for (size_t i = 0; i < sizeof(top->stat_o) / 4; ++i) std::fprintf(out, " %u", top->stat_o[i]);
  std::fprintf(out, "\n");
  std::fclose(out);
  std::rewind(file);
  if (std::fwrite(memory.data(), 1, memory.size(), file) != memory.size()) return fail("write", argv[1]);
  std::fclose(file);
  top->final();
#if VM_COVERAGE
  context->coveragep()->write(context->coverageFilename().c_str());
#endif
  if (!done) std::fprintf(stderr, "error: not done after %llu cycles\n", static_cast<unsigned long long>(now));
  return done ? 0 : EXIT_HANGS;
}
