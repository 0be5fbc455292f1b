// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Runs one frame on the Verilated RayCore: memory image and register values in, frame buffer, hit
// records and counters out. See docs/simulation.md for the files and exit codes.
#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <string>

#include "Vtop.h"
#include "axi_memory.h"
#include "options.h"
#include "rc_regs.h"
#include "verilated.h"
#include "verilated_syms.h"
#if VM_TRACE_FST
#include "verilated_fst_c.h"
#endif
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

namespace {

enum ExitCode { OK = 0, BAD_USAGE = 1, FRAME_ERROR = 2, HANG = 3, VIOLATION = 4, ASSERTION = 5 };

// A run that did not end well: one line for people and an exit code for scripts.
struct Failure : std::runtime_error {
  Failure(ExitCode code, const std::string& text) : std::runtime_error(text), code(code) {}
  ExitCode code;
};

// What is written for each finished ray; raycore/sim.py reads it.
struct HitRecord {
  uint16_t x, y;
  uint8_t kind, light, hit, depth;   // kind: ray_kind_e of rc_pkg.sv
  uint32_t tri, t, beta, gamma;
  uint16_t slots, lost, twos, inst;   // inst: placed object, 0 none
};
static_assert(sizeof(HitRecord) == 32);

// What a ray took in the T&I unit: slots, of these lost to misses and with two traversal steps.
struct Work {
  uint16_t slots = 0, lost = 0, twos = 0;
};

// Follows the slots of a T&I unit's four pipelines. Rays leave a pipeline in the order in which they finish, and hits leave the
// unit in the order in which they leave the pipelines, one a cycle: so no name has to go with a count.
class SlotTrace {
 public:
  // What a cycle brings, a bit a pipeline; ray has 8 bits a pipeline, count 16.
  void step(unsigned valid, unsigned lost, unsigned two, unsigned done, unsigned out, uint32_t ray, uint64_t count) {
    if (!(valid | out)) return;
    for (int p = 0; p < 4; p++) {
      if (out >> p & 1 && !finished_[p].empty()) {
        leaving_.push_back(finished_[p].front());
        finished_[p].pop_front();
      }
      if (!(valid >> p & 1)) continue;
      Work& w = work_[p][ray >> 8 * p & 31];
      w.lost += lost >> p & 1;
      w.twos += two >> p & 1;
      if (done >> p & 1) {
        w.slots = uint16_t(count >> 16 * p);
        finished_[p].push_back(std::exchange(w, {}));
      }
    }
  }
  Work leave() {                 // of the hit that leaves the unit
    if (leaving_.empty()) return {};
    const Work w = leaving_.front();
    leaving_.pop_front();
    return w;
  }

 private:
  Work work_[4][32];             // of the rays in each pipeline
  std::deque<Work> finished_[4], leaving_;   // of rays that are finished, of hits on their way out
};

// The pixel of a ray index and the ray that is under way for it.
struct Pixel {
  uint16_t x = 0, y = 0;
  uint8_t kind = 0, light = 0, depth = 0;
};
const char* const KINDS[] = {"primary", "shadow", "reflect", "transmit"};

class Output {
 public:
  Output(const std::string& path) : path_(path), file_(path.empty() ? nullptr : std::fopen(path.c_str(), "wb")) {
    if (!path.empty() && !file_) throw UsageError(path + ": " + std::strerror(errno));
  }
  ~Output() { if (file_) std::fclose(file_); }
  Output(const Output&) = delete;
  explicit operator bool() const { return file_ != nullptr; }
  FILE* file() const { return file_; }
  void write(const void* data, size_t bytes) {
    if (file_ && std::fwrite(data, 1, bytes, file_) != bytes) throw UsageError(path_ + ": cannot be written");
  }
  void close() {
    if (file_ && std::fclose(std::exchange(file_, nullptr)) != 0) throw UsageError(path_ + ": cannot be written");
  }

 private:
  std::string path_;
  FILE* file_;
};

class Simulation {
 public:
  Simulation(const Options& options, VerilatedContext& context);
  ~Simulation() {
#if VM_COVERAGE
    context_.coveragep()->write();   // the counts lie in the model; those of hierarchical blocks go with final()
#endif
    top_->final();
  }
  void run();                    // throws Failure
  void write_results();

 private:
  using Clock = std::chrono::steady_clock;

  void tick();
  void trace_rays();
  void check();
  void show_progress(bool last);
  void report_waits() const;
  void write_register(uint32_t offset, uint32_t value);
  uint32_t read_register(uint32_t offset);
  void write_stats();

  const Options& options_;
  VerilatedContext& context_;
  std::unique_ptr<Vtop> top_;
  MemoryConfig memory_config_;
  std::vector<RegisterWrite> writes_;
  std::unique_ptr<AxiMemory> memory_;
  AxiMasterPins pins_;
  Output hits_, frame_, stats_, memory_after_;
#if VM_TRACE_FST
  std::unique_ptr<VerilatedFstC> waves_;
#endif
  static constexpr size_t RTUS = sizeof(Vtop::hit_valid_o) / sizeof(CData);
  Pixel pixel_[RTUS][256];       // by ray index
  SlotTrace slots_[RTUS];
  std::map<uint32_t, uint32_t> counters_;
  uint32_t error_code_ = 0, error_addr_ = 0;
  uint64_t cycle_ = 0, last_life_ = 0;
  uint64_t rays_[4][16] = {};    // by kind and depth
  uint64_t rays_total_ = 0, pixels_total_ = 0;
  bool progress_shown_ = false;
  Clock::time_point start_ = Clock::now(), last_progress_ = start_;
};

// AXI data ports are integers or arrays of words: little-endian bytes either way.
template <class Port> void to_port(Port& port, const uint8_t* bytes) { std::memcpy(&port, bytes, sizeof port); }
template <class Port> void from_port(const Port& port, uint8_t* bytes) { std::memcpy(bytes, &port, sizeof port); }

Simulation::Simulation(const Options& options, VerilatedContext& context)
    : options_(options), context_(context), memory_config_(options.memory), writes_(read_registers(options.registers)),
      hits_(options.hits), frame_(options.frame), stats_(options.stats),
      memory_after_(options.memory_after) {
  memory_config_.beat_bytes = sizeof top_->m_axi_rdata;
  memory_ = std::make_unique<AxiMemory>(memory_config_, read_file(options.image), frame_regions(writes_, options.control));
  pixels_total_ = frame_pixels(writes_);
  if (!options.waves.empty()) {
#if VM_TRACE_FST
    Output(options.waves).close();   // the FST writer does not say if it cannot
    context.traceEverOn(true);
#else
    throw UsageError("--waves needs the build with tracing");
#endif
  }
  top_ = std::make_unique<Vtop>(&context);
#if VM_TRACE_FST
  if (!options.waves.empty()) {
    waves_ = std::make_unique<VerilatedFstC>();
    top_->trace(waves_.get(), 99);
    waves_->open(options.waves.c_str());
  }
#endif
}

// One clock cycle: drive the pins, let them settle, look, clock.
void Simulation::tick() {
  Vtop& t = *top_;
  const AxiSlavePins& out = memory_->out();
  t.m_axi_arready = out.arready;
  t.m_axi_rvalid = out.rvalid;
  t.m_axi_rlast = out.rlast;
  t.m_axi_rresp = out.rresp;
  if (out.rvalid) to_port(t.m_axi_rdata, out.rdata);
  t.m_axi_awready = out.awready;
  t.m_axi_wready = out.wready;
  t.m_axi_bvalid = out.bvalid;
  t.m_axi_bresp = out.bresp;
  t.clk_i = 0;
  t.eval();
#if VM_TRACE_FST
  const bool dump = waves_ && cycle_ >= options_.waves_from && cycle_ - options_.waves_from < options_.waves_cycles;
  if (dump) waves_->dump(context_.time());
#endif
  pins_.arvalid = t.m_axi_arvalid;
  pins_.araddr = t.m_axi_araddr;
  pins_.arlen = t.m_axi_arlen;
  pins_.arsize = t.m_axi_arsize;
  pins_.arburst = t.m_axi_arburst;
  pins_.rready = t.m_axi_rready;
  pins_.awvalid = t.m_axi_awvalid;
  pins_.awaddr = t.m_axi_awaddr;
  pins_.awlen = t.m_axi_awlen;
  pins_.awsize = t.m_axi_awsize;
  pins_.awburst = t.m_axi_awburst;
  pins_.bready = t.m_axi_bready;
  pins_.wvalid = t.m_axi_wvalid;
  if (pins_.wvalid) {
    pins_.wlast = t.m_axi_wlast;
    from_port(t.m_axi_wdata, pins_.wdata);
    from_port(t.m_axi_wstrb, pins_.wstrb);
  }
  if (t.rst_ni) {
    trace_rays();
    if ((out.rvalid && pins_.rready) || (out.wready && pins_.wvalid)) last_life_ = cycle_;
  }
  context_.timeInc(5);
  t.clk_i = 1;
  t.eval();
#if VM_TRACE_FST
  if (dump) waves_->dump(context_.time());
#endif
  context_.timeInc(5);
  if (t.rst_ni) memory_->step(pins_);
  cycle_++;
}

void Simulation::trace_rays() {
  const Vtop& t = *top_;
  for (size_t r = 0; r < RTUS; r++) {
    if (hits_) {
      slots_[r].step(t.slot_valid_o[r], t.slot_lost_o[r], t.slot_two_o[r], t.slot_done_o[r], t.slot_out_o[r], t.slot_ray_o[r],
                     t.slot_count_o[r]);
    }
    if (t.hit_valid_o[r]) {        // before the events that may give its index away again
      const Pixel& p = pixel_[r][t.hit_id_o[r]];
      rays_[p.kind][p.depth]++;
      rays_total_++;
      last_life_ = cycle_;
      if (hits_) {
        const Work w = slots_[r].leave();
        const HitRecord record{p.x, p.y, p.kind, p.light, t.hit_hit_o[r], p.depth,
                               t.hit_tri_o[r], t.hit_t_o[r], t.hit_beta_o[r], t.hit_gamma_o[r], w.slots, w.lost, w.twos,
                               uint16_t(t.hit_inst_o[r])};
        hits_.write(&record, sizeof record);
      }
    }
    if (t.pri_valid_o[r]) pixel_[r][t.pri_id_o[r]] = {t.pri_x_o[r], t.pri_y_o[r], 0, 0, 0};
    if (t.sec_valid_o[r]) {
      Pixel& p = pixel_[r][t.sec_id_o[r]];
      p.kind = t.sec_kind_o[r];
      p.light = t.sec_light_o[r];
      p.depth = t.sec_depth_o[r];
    }
  }
}

void Simulation::check() {
  if (context_.gotError()) throw Failure(ASSERTION, "an assertion failed in cycle " + std::to_string(cycle_));
  if (!memory_->violation().empty()) throw Failure(VIOLATION, memory_->violation());
  if (cycle_ - last_life_ > options_.watchdog) {
    report_waits();
    throw Failure(HANG, "nothing happened for " + std::to_string(options_.watchdog) + " cycles, at cycle " +
                            std::to_string(cycle_));
  }
  if (cycle_ >= options_.max_cycles) {
    report_waits();
    throw Failure(HANG, "the frame is not done after " + std::to_string(cycle_) + " cycles (--max-cycles)");
  }
}

void Simulation::show_progress(bool last) {
  const auto now = Clock::now();
  if (!last && now - last_progress_ < std::chrono::seconds(1)) return;
  last_progress_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const uint64_t done = memory_->pixels();
  char left[32] = "";
  if (!last && done > 0) {
    std::snprintf(left, sizeof left, ", %.0f s left", seconds * double(pixels_total_ - std::min(done, pixels_total_)) / double(done));
  }
  std::fprintf(stderr, "\r%" PRIu64 " rays, %" PRIu64 "/%" PRIu64 " pixels, %" PRIu64 " kcycles, %.0f kcycles/s%s   %s",
               rays_total_, done, pixels_total_, cycle_ / 1000, double(cycle_) / seconds / 1000.0, left, last ? "\n" : "");
  std::fflush(stderr);
  progress_shown_ = true;
}

// What sim/watch.vlt made public: of each pair of valid and ready, who offers and who does not take.
void Simulation::report_waits() const {
  if (progress_shown_) std::fputc('\n', stderr);
  std::fprintf(stderr, "memory: %zu reads and %zu writes outstanding\n", memory_->reads_outstanding(), memory_->writes_outstanding());
  if (!context_.scopeNameMap()) return;
  for (const auto& [scope_name, scope] : *context_.scopeNameMap()) {
    if (!scope->varsp()) continue;
    auto value_of = [&](const std::string& name) -> int {   // -1: no such signal, or a wide one
      const auto found = scope->varsp()->find(name.c_str());
      if (found == scope->varsp()->end()) return -1;
      if (found->second.vltype() == VLVT_UINT16) return *static_cast<const SData*>(found->second.datap());
      return found->second.vltype() == VLVT_UINT8 ? *static_cast<const CData*>(found->second.datap()) : -1;
    };
    for (const auto& [var_name, var] : *scope->varsp()) {
      const std::string name = var_name;
      const int value = value_of(name);
      if (value < 0 || var.isParam() || name.find("ready") != std::string::npos) continue;
      const size_t at = name.find("_valid");
      if (at == std::string::npos) {
        std::fprintf(stderr, "%s.%s = %d\n", scope_name, var_name, value);
        continue;
      }
      const std::string wire = name.substr(0, at);
      const int ready = value_of(wire + "_ready" + name.substr(at + 6));
      if (value == 0) std::fprintf(stderr, "%s.%s: nothing to give\n", scope_name, wire.c_str());
      else if (ready < 0) std::fprintf(stderr, "%s.%s: valid %d\n", scope_name, wire.c_str(), value);
      else if (value & ~ready) std::fprintf(stderr, "%s.%s: WAITS, valid %d but ready %d\n", scope_name, wire.c_str(), value, ready);
      else std::fprintf(stderr, "%s.%s: moves\n", scope_name, wire.c_str());
    }
  }
}

void Simulation::write_register(uint32_t offset, uint32_t value) {
  Vtop& t = *top_;
  t.s_axil_awaddr = offset & 0xFFF;
  t.s_axil_wdata = value;
  t.s_axil_wstrb = 0xF;
  t.s_axil_awvalid = t.s_axil_wvalid = t.s_axil_bready = 1;
  for (bool done = false; !done;) {
    t.clk_i = 0;
    t.eval();                    // to see what the coming edge takes
    const bool aw = t.s_axil_awready, w = t.s_axil_wready;
    done = t.s_axil_bvalid;
    const uint8_t resp = t.s_axil_bresp;
    tick();
    if (aw) t.s_axil_awvalid = 0;
    if (w) t.s_axil_wvalid = 0;
    if (done && resp != 0) throw UsageError("register write to offset " + std::to_string(offset) + " answers with an error");
    check();
  }
  t.s_axil_bready = 0;
}

uint32_t Simulation::read_register(uint32_t offset) {
  Vtop& t = *top_;
  t.s_axil_araddr = offset & 0xFFF;
  t.s_axil_arvalid = t.s_axil_rready = 1;
  for (;;) {
    t.clk_i = 0;
    t.eval();
    const bool ar = t.s_axil_arready, done = t.s_axil_rvalid;
    const uint32_t value = t.s_axil_rdata;
    tick();
    if (ar) t.s_axil_arvalid = 0;
    check();
    if (done) {
      t.s_axil_rready = 0;
      return value;
    }
  }
}

void Simulation::run() {
  Vtop& t = *top_;
  t.rst_ni = 0;
  for (int i = 0; i < 4; i++) tick();
  t.rst_ni = 1;
  if (read_register(reg::ID) != 0x52435254) throw Failure(VIOLATION, "the ID register does not answer");
  for (const RegisterWrite& w : writes_) write_register(w.offset, w.value);
  write_register(reg::IRQ_ENABLE, 1);
  last_life_ = cycle_;
  start_ = last_progress_ = Clock::now();
  write_register(reg::CTRL, options_.control);
  while (!t.irq_o) {
    tick();
    check();
    if (options_.progress && cycle_ % 4096 == 0) show_progress(false);
  }
  if (progress_shown_) show_progress(true);

  for (const reg::Name& r : reg::NAMES) {
    if (r.offset >= reg::FIRST_COUNTER && r.offset < reg::END_COUNTERS) counters_[r.offset] = read_register(r.offset);
  }
  const uint32_t status = read_register(reg::STATUS);
  const uint32_t code = error_code_ = read_register(reg::ERROR);
  const uint32_t addr = error_addr_ = read_register(reg::ERROR_ADDR);
  if (!memory_->idle()) throw Failure(VIOLATION, "done, but memory accesses are outstanding");
  if (status & 4) {
    static const char* const CAUSE[] = {
        "no cause", "node index %u outside its region", "list index %u outside its region",
        "triangle index %u outside its region", "tree deeper than the stack (ray %u)",
        "a ray took more slots than MAX_SLOTS (ray %u)", "memory answered SLVERR at 0x%08x", "memory answered DECERR at 0x%08x",
        "address 0x%08x outside every window", "material index %u outside its region",
        "registers that make no sense (register 0x%03x)",
        "room for %u nodes is too little for the tree", "room for %u list entries is too little for the tree",
        "working memory of %u references is too little for the tree builder", "%u triangles are too many for the tree builder",
        "a vertex is off the grid or outside it", "instance index %u outside its region"};
    char text[128];
    std::snprintf(text, sizeof text, code < std::size(CAUSE) ? CAUSE[code] : "unknown cause", addr);
    throw Failure(FRAME_ERROR, "the frame ended in error " + std::to_string(code) + ": " + text);
  }
  if (status != 2) throw Failure(VIOLATION, "interrupt, but the frame is not done");
}

void Simulation::write_stats() {
  if (!stats_) return;
  FILE* f = stats_.file();
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  const AxiMemory::Counts& c = memory_->counts();
  std::fprintf(f, "{\n  \"counters\": {");
  const char* sep = "\n";
  for (const reg::Name& r : reg::NAMES) {
    if (r.offset < reg::FIRST_COUNTER || r.offset >= reg::END_COUNTERS) continue;
    std::fprintf(f, "%s    \"%s\": %" PRIu32, sep, r.name, counters_[r.offset]);
    sep = ",\n";
  }
  std::fprintf(f, "\n  },\n  \"bytes\": {");
  sep = "";
  for (const Region& region : memory_->regions()) {
    std::fprintf(f, "%s\"%s\": %" PRIu64, sep, region.name.c_str(), region.bytes);
    sep = ", ";
  }
  std::fprintf(f, "},\n  \"axi\": {\"read_bursts\": %" PRIu64 ", \"read_beats\": %" PRIu64 ", \"write_bursts\": %" PRIu64 ", \"write_beats\": %" PRIu64 "},\n",
               c.read_bursts, c.read_beats, c.write_bursts, c.write_beats);
  std::fprintf(f, "  \"error\": {\"code\": %u, \"addr\": %u},\n", error_code_, error_addr_);
  std::fprintf(f, "  \"rays\": {");           // by kind: a list by depth, as long as it has to be
  for (int kind = 0; kind < 4; kind++) {
    int deepest = 15;
    while (deepest > 0 && rays_[kind][deepest] == 0) deepest--;
    std::fprintf(f, "%s\"%s\": [", kind ? ", " : "", KINDS[kind]);
    for (int d = 0; d <= deepest; d++) std::fprintf(f, "%s%" PRIu64, d ? ", " : "", rays_[kind][d]);
    std::fprintf(f, "]");
  }
  std::fprintf(f, "},\n");
  std::fprintf(f, "  \"sim\": {\"cycles\": %" PRIu64 ", \"seconds\": %.3f, \"cycles_per_second\": %.0f},\n", cycle_, seconds, double(cycle_) / seconds);
  std::fprintf(f, "  \"memory\": {\"bits\": %u, \"latency\": %u, \"outstanding\": %u, \"backpressure\": %g, \"seed\": %" PRIu64 "}\n}\n",
               memory_config_.beat_bytes * 8, memory_config_.latency, memory_config_.outstanding, memory_config_.backpressure, memory_config_.seed);
}

void Simulation::write_results() {
  frame_.write(memory_->frame_buffer().data(), memory_->frame_buffer().size());
  memory_after_.write(memory_->image().data(), memory_->image().size());
  write_stats();
  frame_.close();
  hits_.close();
  stats_.close();
  memory_after_.close();
#if VM_TRACE_FST
  if (waves_) waves_->close();
#endif
}

}  // namespace

int main(int argc, char** argv) {
  VerilatedContext context;
  context.commandArgs(argc, argv);
  context.fatalOnError(false);   // a failed assertion ends the run below, with its cycle
  int code = OK;
  try {
    const Options options = parse_options(argc, argv);
    Simulation simulation(options, context);
    try {
      simulation.run();
    } catch (const Failure& failure) {
      std::fprintf(stderr, "rc_sim: %s\n", failure.what());
      code = failure.code;
    }
    simulation.write_results();
  } catch (const UsageError& error) {
    std::fprintf(stderr, "rc_sim: %s\n", error.what());
    code = BAD_USAGE;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "rc_sim: not enough memory\n");
    code = BAD_USAGE;
  }
  return code;
}
