// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
#include "axi_memory.h"

#include <cstdio>
#include <cstring>

namespace {
std::string hex(uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, "0x%08llx", static_cast<unsigned long long>(value));
  return text;
}
constexpr uint8_t POISON = 0xA5;   // data that comes with an error: nobody may use it
}  // namespace

AxiMemory::AxiMemory(const MemoryConfig& config, std::vector<uint8_t> image, std::vector<Region> regions)
    : config_(config), image_(std::move(image)), regions_(std::move(regions)), random_(config.seed) {
  for (const Region& region : regions_) {
    if (region.name != "frame") continue;
    frame_base_ = static_cast<uint32_t>(region.lo);
    frame_.assign(region.hi - region.lo, 0);
  }
  if (config_.latency == 0) config_.latency = 1;
}

void AxiMemory::complain(const std::string& text) {
  if (violation_.empty()) violation_ = text + " in cycle " + std::to_string(cycle_);
}

bool AxiMemory::pause() {
  if (config_.backpressure <= 0.0) return false;
  return static_cast<double>(random_() >> 11) * 0x1p-53 < config_.backpressure;
}

AxiResp AxiMemory::fault(decltype(AxiFault::where) where, uint64_t nth, uint32_t addr) const {
  for (const AxiFault& f : config_.faults) {
    if (f.where == where && f.what == nth) return f.resp;
    if (f.where == AxiFault::ReadLine && where == AxiFault::ReadBurst && f.what / 64 == addr / 64) return f.resp;
  }
  return AxiResp::Okay;
}

// AXI4, A3.2.1: valid and its payload hold until ready.
void AxiMemory::check_held(const AxiMasterPins& in) {
  const AxiMasterPins& was = in_before_;
  if (was.arvalid && !ready_before_.ar) {
    if (!in.arvalid || in.araddr != was.araddr || in.arlen != was.arlen) complain("AXI rule broken: AR did not hold");
  }
  if (was.awvalid && !ready_before_.aw) {
    if (!in.awvalid || in.awaddr != was.awaddr || in.awlen != was.awlen) complain("AXI rule broken: AW did not hold");
  }
  if (was.wvalid && !ready_before_.w) {
    if (!in.wvalid || in.wlast != was.wlast || std::memcmp(in.wdata, was.wdata, config_.beat_bytes) != 0) {
      complain("AXI rule broken: W did not hold");
    }
  }
}

void AxiMemory::check_burst(const char* kind, uint32_t addr, unsigned len, unsigned size, unsigned burst, bool write) {
  const uint64_t bytes = uint64_t(len + 1) * config_.beat_bytes;
  if ((1u << size) != config_.beat_bytes) complain(std::string("AXI rule broken: narrow ") + kind);
  if (burst != 1) complain(std::string("AXI rule broken: burst type of a ") + kind);
  if (addr % config_.beat_bytes != 0) complain(std::string("unaligned ") + kind + " at " + hex(addr));
  if (addr / 4096 != (addr + bytes - 1) / 4096) complain(std::string("AXI rule broken: 4 KB crossed by a ") + kind);
  for (Region& region : regions_) {
    if (region.writable == write && addr >= region.lo && addr + bytes <= region.hi) {
      region.bytes += bytes;
      return;
    }
  }
  complain("access outside windows: " + std::string(kind) + " of " + std::to_string(bytes) + " bytes at " + hex(addr));
}

void AxiMemory::accept_read(const AxiMasterPins& in) {
  counts_.read_bursts++;
  check_burst("read", in.araddr, in.arlen, in.arsize, in.arburst, false);
  reads_.push_back({.ready = cycle_ + config_.latency, .addr = in.araddr, .beats = in.arlen + 1u,
                    .resp = fault(AxiFault::ReadBurst, counts_.read_bursts, in.araddr)});
}

void AxiMemory::accept_write(const AxiMasterPins& in) {
  counts_.write_bursts++;
  check_burst("write", in.awaddr, in.awlen, in.awsize, in.awburst, true);
  writes_.push_back({.ready = UINT64_MAX, .addr = in.awaddr, .beats = in.awlen + 1u,
                     .resp = fault(AxiFault::WriteBurst, counts_.write_bursts, in.awaddr)});
}

// A write beat belongs to the oldest burst that still lacks one.
void AxiMemory::take_beat(const AxiMasterPins& in) {
  for (Burst& burst : writes_) {
    if (burst.done == burst.beats) continue;
    const uint64_t at = uint64_t(burst.addr) + uint64_t(burst.done) * config_.beat_bytes;
    const uint64_t in_frame = at - frame_base_;          // wraps far beyond its end below it
    for (unsigned b = 0; b < config_.beat_bytes; b++) {
      if (!(in.wstrb[b / 8] >> (b % 8) & 1)) continue;
      if (in_frame + b < frame_.size()) {
        frame_[in_frame + b] = in.wdata[b];
        strobed_bytes_++;
      } else if (at + b < image_.size()) {
        image_[at + b] = in.wdata[b];
      } else {
        complain("write beyond the image at " + hex(at + b));
      }
    }
    counts_.write_beats++;
    burst.done++;
    if (in.wlast != (burst.done == burst.beats)) complain("AXI rule broken: WLAST in the wrong beat");
    if (burst.done == burst.beats) burst.ready = cycle_ + config_.latency;
    return;
  }
  complain("AXI rule broken: write data without address");
}

void AxiMemory::step(const AxiMasterPins& in) {
  check_held(in);
  if (out_.rvalid && in.rready) {
    Burst& burst = reads_.front();
    counts_.read_beats++;
    if (++burst.done == burst.beats) reads_.pop_front();
    out_.rvalid = false;
  }
  if (out_.bvalid && in.bready) {
    writes_.pop_front();
    out_.bvalid = false;
  }
  if (out_.arready && in.arvalid) accept_read(in);
  if (out_.awready && in.awvalid) accept_write(in);
  if (out_.wready && in.wvalid) take_beat(in);
  cycle_++;
  in_before_ = in;
  ready_before_ = {out_.arready, out_.awready, out_.wready};
  drive();
}

void AxiMemory::drive() {
  if (!out_.rvalid && !reads_.empty() && reads_.front().ready <= cycle_ && !pause()) {
    const Burst& burst = reads_.front();
    const uint64_t at = uint64_t(burst.addr) + uint64_t(burst.done) * config_.beat_bytes;
    out_.rvalid = true;
    out_.rlast = burst.done + 1 == burst.beats;
    out_.rresp = static_cast<uint8_t>(burst.resp);
    if (burst.resp != AxiResp::Okay) {
      std::memset(out_.rdata, POISON, config_.beat_bytes);
    } else if (at + config_.beat_bytes <= image_.size()) {
      std::memcpy(out_.rdata, &image_[at], config_.beat_bytes);
    } else {
      std::memset(out_.rdata, 0, config_.beat_bytes);
    }
  }
  if (!out_.bvalid && !writes_.empty() && writes_.front().ready <= cycle_ && !pause()) {
    out_.bvalid = true;
    out_.bresp = static_cast<uint8_t>(writes_.front().resp);
  }
  // Write data is taken once its address is known.
  bool wanted = false;
  for (const Burst& burst : writes_) wanted |= burst.done != burst.beats;
  out_.arready = reads_.size() < config_.outstanding && !pause();
  out_.awready = writes_.size() < config_.outstanding && !pause();
  out_.wready = wanted && !pause();
}
