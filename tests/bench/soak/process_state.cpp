#include "tests/bench/soak/process_state.h"

#include <malloc.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

// The allocator of a sanitizer, where one is built in, counts for itself; mallinfo knows nothing of it.
extern "C" size_t __sanitizer_get_current_allocated_bytes() __attribute__((weak));

namespace limberg::bench {

namespace {

double allocated_mb() {
  if (__sanitizer_get_current_allocated_bytes) return double(__sanitizer_get_current_allocated_bytes()) / 1e6;
  const auto m = mallinfo2();
  return double(m.uordblks + m.hblkhd) / 1e6;
}

double resident_mb() {
  int64_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return double(resident) * double(sysconf(_SC_PAGESIZE)) / 1e6;
}

int64_t entries(const std::filesystem::path& folder) {
  std::error_code ec;
  const std::filesystem::directory_iterator all(folder, ec);
  return ec ? 0 : std::distance(begin(all), end(all));
}

}  // namespace

ProcessState process_state(const std::filesystem::path& temporary) {
  ProcessState s;
  s.resident_mb = resident_mb();
  malloc_trim(0);
  s.trimmed_mb = resident_mb();
  s.allocated_mb = allocated_mb();
  s.files = entries("/proc/self/fd"), s.threads = entries("/proc/self/task"), s.left = entries(temporary);
  return s;
}

}  // namespace limberg::bench
