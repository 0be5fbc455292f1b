// SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
// Command line and input files of the harness.
#pragma once
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "axi_memory.h"

// Wrong input: one line for people.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RegisterWrite {
  uint32_t offset, value;
};

struct Options {
  std::string image, registers;                // in
  std::string frame, hits, stats, waves;       // out, empty: not wanted
  std::string memory_after;
  uint32_t control = 1;                        // what is written to CTRL
  uint64_t waves_from = 0, waves_cycles = UINT64_MAX;
  uint64_t max_cycles = UINT64_MAX, watchdog = 200'000;
  bool progress = false;
  MemoryConfig memory;
};

// Throws UsageError.
Options parse_options(int argc, char** argv);
std::vector<uint8_t> read_file(const std::string& path);

// Lines of `NAME value` or `offset value`; # begins a comment.
std::vector<RegisterWrite> read_registers(const std::string& path);

// What a frame with these registers may touch: worked out here and not in the RTL, to check the RTL.
// control: as written to CTRL.
std::vector<Region> frame_regions(const std::vector<RegisterWrite>& writes, uint32_t control);

// Pixels that a frame with these registers renders: those of the picture, or of its range of tiles.
uint64_t frame_pixels(const std::vector<RegisterWrite>& writes);
