#pragma once
// What this process holds just now: what a soak watches.
#include <cstdint>
#include <filesystem>

namespace limberg::bench {

struct ProcessState {
  double resident_mb = 0, trimmed_mb = 0;  // trimmed: once the allocator has given back what it can
  double allocated_mb = 0;                 // what the allocator has handed out
  int64_t files = 0, threads = 0;          // open descriptors
  int64_t left = 0;                        // entries of the folder for temporary files
};

/// Asks the allocator to give back what it can.
ProcessState process_state(const std::filesystem::path& temporary);

}  // namespace limberg::bench
