// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// External memory behind an AXI4 port: latency, bandwidth of one beat a cycle, limited outstanding
// bursts, random gaps, injected errors. Watches that the master keeps the rules of AXI4 and stays
// inside the regions that a frame may touch. Knows nothing of Verilator.
#pragma once
#include <cstdint>
#include <deque>
#include <random>
#include <string>
#include <vector>

inline constexpr unsigned MAX_BEAT_BYTES = 128;

// One direction's wires, as the master drives them in this cycle.
struct AxiMasterPins {
  bool arvalid = false, rready = false, awvalid = false, wvalid = false, bready = false;
  uint32_t araddr = 0, awaddr = 0;
  uint8_t arlen = 0, arsize = 0, arburst = 0, awlen = 0, awsize = 0, awburst = 0;
  bool wlast = false;
  uint8_t wstrb[MAX_BEAT_BYTES / 8] = {};
  uint8_t wdata[MAX_BEAT_BYTES] = {};
};

// The other direction's, as the memory drives them in the next cycle.
struct AxiSlavePins {
  bool arready = false, rvalid = false, rlast = false, awready = false, wready = false, bvalid = false;
  uint8_t rresp = 0, bresp = 0;
  uint8_t rdata[MAX_BEAT_BYTES] = {};
};

enum class AxiResp : uint8_t { Okay = 0, SlvErr = 2, DecErr = 3 };

// An error to answer with: the n-th read or write burst (from 1), or every read of a 64-byte line.
struct AxiFault {
  AxiResp resp;
  enum { ReadBurst, WriteBurst, ReadLine } where;
  uint64_t what;
};

struct MemoryConfig {
  unsigned beat_bytes = 8;
  unsigned latency = 60;         // cycles from address to first beat, and from last write beat to response
  unsigned outstanding = 16;     // bursts accepted and not yet answered, reads and writes apart
  double backpressure = 0.0;     // probability that a channel pauses for a cycle
  uint64_t seed = 1;
  std::vector<AxiFault> faults;
};

// A range of addresses that may be read, or one that may be written. What is written must lie in the image, except for
// the region "frame".
struct Region {
  std::string name;
  uint64_t lo = 0, hi = 0;       // hi exclusive
  bool writable = false;
  uint64_t bytes = 0;            // moved so far
};

class AxiMemory {
 public:
  AxiMemory(const MemoryConfig& config, std::vector<uint8_t> image, std::vector<Region> regions);

  // One cycle: what the master drove, answered with what the memory drives next.
  void step(const AxiMasterPins& in);
  const AxiSlavePins& out() const { return out_; }

  const std::vector<uint8_t>& frame_buffer() const { return frame_; }
  const std::vector<uint8_t>& image() const { return image_; }   // with what was written into it
  const std::vector<Region>& regions() const { return regions_; }
  const std::string& violation() const { return violation_; }  // empty while all is well
  uint64_t pixels() const { return strobed_bytes_ / 4; }
  bool idle() const { return reads_.empty() && writes_.empty(); }
  size_t reads_outstanding() const { return reads_.size(); }
  size_t writes_outstanding() const { return writes_.size(); }

  struct Counts {
    uint64_t read_bursts = 0, read_beats = 0, write_bursts = 0, write_beats = 0;
  };
  const Counts& counts() const { return counts_; }

 private:
  struct Burst {
    uint64_t ready = 0;          // first cycle in which it may be answered
    uint32_t addr = 0;
    unsigned beats = 0, done = 0;
    AxiResp resp = AxiResp::Okay;
  };

  void accept_read(const AxiMasterPins& in);
  void accept_write(const AxiMasterPins& in);
  void take_beat(const AxiMasterPins& in);
  void drive();
  void check_held(const AxiMasterPins& in);
  void check_burst(const char* kind, uint32_t addr, unsigned len, unsigned size, unsigned burst, bool write);
  AxiResp fault(decltype(AxiFault::where) where, uint64_t nth, uint32_t addr) const;
  bool pause();
  void complain(const std::string& text);

  MemoryConfig config_;
  std::vector<uint8_t> image_, frame_;
  std::vector<Region> regions_;
  uint32_t frame_base_ = 0;
  std::deque<Burst> reads_, writes_;
  AxiMasterPins in_before_;
  struct { bool ar = false, aw = false, w = false; } ready_before_;
  AxiSlavePins out_;
  Counts counts_;
  uint64_t cycle_ = 0, strobed_bytes_ = 0;
  std::string violation_;
  std::mt19937_64 random_;
};
