// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
#include "options.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <unistd.h>

#include "rc_regs.h"

namespace {
const char USAGE[] =
    "usage: rc_sim --image IMAGE.bin --regs REGS.txt [options]\n"
    "  --image FILE          memory from address 0\n"
    "  --regs FILE           set-up registers, lines of NAME VALUE\n"
    "  --control N           what to start: sum of 1 render, 2 build the tree, 4 make records (1)\n"
    "  --memory-after FILE   write the memory as the frame left it, without the frame buffer\n"
    "  --fb FILE             write the frame buffer, height x stride bytes\n"
    "  --hits FILE           write a record of 24 bytes for each finished ray\n"
    "  --stats FILE          write counters as JSON\n"
    "  --mem-latency N       cycles from address to data (60)\n"
    "  --mem-outstanding N   bursts accepted and not yet answered (16)\n"
    "  --backpressure P      probability that a memory channel pauses for a cycle (0)\n"
    "  --seed N              of the pauses (1)\n"
    "  --slverr-at K, --decerr-at K               answer the K-th read burst with an error (from 1)\n"
    "  --slverr-addr A, --decerr-addr A           answer reads of this 64-byte line with an error\n"
    "  --slverr-write-at K, --decerr-write-at K   answer the K-th write burst with an error\n"
    "  --max-cycles N        give up after N cycles\n"
    "  --watchdog N          give up after N cycles without a finished ray or a memory beat (200000)\n"
    "  --waves FILE          record an FST (needs the build with tracing)\n"
    "  --waves-from C, --waves-cycles N           only this part of it\n"
    "  --progress            progress line even if stderr is no terminal\n";

uint64_t number(const std::string& option, const std::string& text) {
  char* end = nullptr;
  errno = 0;
  const uint64_t value = std::strtoull(text.c_str(), &end, 0);
  if (text.empty() || *end != 0 || errno != 0 || text[0] == '-') {
    throw UsageError(option + ": '" + text + "' is not a number");
  }
  return value;
}

uint64_t at_least_one(const std::string& option, const std::string& text) {
  const uint64_t value = number(option, text);
  if (value == 0 || value > 1'000'000) throw UsageError(option + " must be 1 to 1000000, is " + text);
  return value;
}

double probability(const std::string& option, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !(value >= 0.0 && value < 1.0)) {
    throw UsageError(option + " must be at least 0 and below 1, is '" + text + "'");
  }
  return value;
}

// What a register was last set to.
uint64_t written(const std::vector<RegisterWrite>& writes, uint32_t offset) {
  uint64_t last = 0;
  for (const RegisterWrite& w : writes) {
    if (w.offset == offset) last = w.value;
  }
  return last;
}
}  // namespace

Options parse_options(int argc, char** argv) {
  Options o;
  o.progress = isatty(fileno(stderr));
  for (int i = 1; i < argc; i++) {
    const std::string name = argv[i];
    if (name[0] == '+') continue;   // Verilator's own
    if (name == "--help") {
      std::fputs(USAGE, stdout);
      std::exit(0);
    }
    if (name == "--progress") {
      o.progress = true;
      continue;
    }
    if (i + 1 == argc) throw UsageError(name + ": unknown option, or its value is missing (--help)");
    const std::string value = argv[++i];
    auto fault = [&](AxiResp resp, decltype(AxiFault::where) where) {
      o.memory.faults.push_back({resp, where, number(name, value)});
    };
    if (name == "--image") o.image = value;
    else if (name == "--regs") o.registers = value;
    else if (name == "--fb") o.frame = value;
    else if (name == "--hits") o.hits = value;
    else if (name == "--stats") o.stats = value;
    else if (name == "--memory-after") o.memory_after = value;
    else if (name == "--control") o.control = uint32_t(number(name, value));
    else if (name == "--waves") o.waves = value;
    else if (name == "--waves-from") o.waves_from = number(name, value);
    else if (name == "--waves-cycles") o.waves_cycles = number(name, value);
    else if (name == "--max-cycles") o.max_cycles = number(name, value);
    else if (name == "--watchdog") o.watchdog = number(name, value);
    else if (name == "--mem-latency") o.memory.latency = unsigned(at_least_one(name, value));
    else if (name == "--mem-outstanding") o.memory.outstanding = unsigned(at_least_one(name, value));
    else if (name == "--backpressure") o.memory.backpressure = probability(name, value);
    else if (name == "--seed") o.memory.seed = number(name, value);
    else if (name == "--slverr-at") fault(AxiResp::SlvErr, AxiFault::ReadBurst);
    else if (name == "--decerr-at") fault(AxiResp::DecErr, AxiFault::ReadBurst);
    else if (name == "--slverr-addr") fault(AxiResp::SlvErr, AxiFault::ReadLine);
    else if (name == "--decerr-addr") fault(AxiResp::DecErr, AxiFault::ReadLine);
    else if (name == "--slverr-write-at") fault(AxiResp::SlvErr, AxiFault::WriteBurst);
    else if (name == "--decerr-write-at") fault(AxiResp::DecErr, AxiFault::WriteBurst);
    else throw UsageError("unknown option " + name + " (--help)");
  }
  if (o.image.empty()) throw UsageError("--image is missing (--help)");
  if (o.control < 1 || o.control > 7) throw UsageError("--control must be 1 to 7");
  if (o.registers.empty()) throw UsageError("--regs is missing (--help)");
  return o;
}

std::vector<uint8_t> read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw UsageError(path + ": " + std::strerror(errno));
  std::vector<uint8_t> data(static_cast<size_t>(file.tellg()));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(data.data()), std::streamsize(data.size()))) {
    throw UsageError(path + ": cannot be read");
  }
  return data;
}

std::vector<RegisterWrite> read_registers(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw UsageError(path + ": " + std::strerror(errno));
  std::vector<RegisterWrite> writes;
  std::string line;
  for (unsigned n = 1; std::getline(file, line); n++) {
    const std::string where = path + " line " + std::to_string(n);
    std::istringstream words(line.substr(0, line.find('#')));
    std::string name, value, rest;
    if (!(words >> name)) continue;
    if (!(words >> value) || words >> rest) throw UsageError(where + ": expected NAME VALUE");
    RegisterWrite write{UINT32_MAX, uint32_t(number(where, value))};
    for (const reg::Name& r : reg::NAMES) {
      if (name == r.name) write.offset = r.offset;
    }
    if (write.offset == UINT32_MAX) {
      if (name[0] < '0' || name[0] > '9') throw UsageError(where + ": no register " + name);
      write.offset = uint32_t(number(where, name));
    }
    writes.push_back(write);
  }
  return writes;
}

std::vector<Region> frame_regions(const std::vector<RegisterWrite>& writes, uint32_t control) {
  auto value = [&](uint32_t offset) -> uint64_t { return written(writes, offset); };
  std::vector<Region> regions;
  // Records of a region, from docs/seams.md; a region ends on a multiple of 64 bytes.
  auto add = [&](const char* name, uint32_t base, uint64_t bytes, bool writable = false) {
    const uint64_t lo = value(base) / 64 * 64;
    regions.push_back({name, lo, lo + (bytes + 63) / 64 * 64, writable});
  };
  add("nodes", reg::NODE_BASE, 8 * value(reg::NODE_COUNT));
  add("lists", reg::LIST_BASE, 4 * value(reg::LIST_COUNT));
  add("triaccel", reg::ACCEL_BASE, 32 * value(reg::TRI_COUNT));
  add("info", reg::INFO_BASE, 64 * value(reg::TRI_COUNT));
  add("materials", reg::MAT_BASE, 128 * value(reg::MAT_COUNT));
  add("lights", reg::LIGHT_BASE, 64 * value(reg::LIGHT_COUNT));
  add("uv", reg::UV_BASE, 32 * value(reg::UV_COUNT));
  add("textures", reg::TEX_BASE, 64 * value(reg::TEX_LINES));
  add("instances", reg::INST_BASE, 256 * value(reg::INST_COUNT));
  if (control & 2) {               // the tree builder's; what it writes has names of its own
    add("vertices", reg::VERTEX_BASE, 32 * value(reg::TRI_COUNT));
    add("working", reg::REF_BASE, 16 * value(reg::REF_COUNT));
    add("nodes_built", reg::NODE_BASE, 8 * value(reg::NODE_COUNT), true);
    add("lists_built", reg::LIST_BASE, 4 * value(reg::LIST_COUNT), true);
    add("working_written", reg::REF_BASE, 16 * value(reg::REF_COUNT), true);
  }
  if (control & 4) {               // the record unit's
    if (!(control & 2)) add("vertices", reg::VERTEX_BASE, 32 * value(reg::TRI_COUNT));
    add("attributes", reg::ATTR_BASE, 32 * value(reg::TRI_COUNT));
    add("triaccel_made", reg::ACCEL_BASE, 32 * value(reg::TRI_COUNT), true);
    add("info_made", reg::INFO_BASE, 64 * value(reg::TRI_COUNT), true);
  }
  const uint64_t stride = value(reg::FB_STRIDE) / 32 * 32;
  add("frame", reg::FB_BASE, stride * (value(reg::SIZE) >> 16), true);
  if (regions.back().hi > uint64_t(1) << 32) throw UsageError("the frame buffer does not fit in 4 GB");
  return regions;
}

uint64_t frame_pixels(const std::vector<RegisterWrite>& writes) {
  const uint64_t size = written(writes, reg::SIZE), first = written(writes, reg::TILE_FIRST);
  const uint64_t width = size & 0xFFFF, height = size >> 16, columns = (width + 15) / 16;
  uint64_t pixels = 0, left = written(writes, reg::TILE_COUNT);
  if (left == 0) left = UINT64_MAX;
  for (uint64_t tile = (first >> 16 & 0xFFF) * columns + (first & 0xFFF); left > 0 && columns > 0; tile++, left--) {
    const uint64_t x = tile % columns * 16, y = tile / columns * 16;
    if (y >= height) break;
    pixels += std::min<uint64_t>(16, width - x) * std::min<uint64_t>(16, height - y);
  }
  return pixels;
}
