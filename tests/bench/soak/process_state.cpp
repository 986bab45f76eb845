#include "tests/bench/soak/process_state.h"

#include <malloc.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

namespace limberg::bench {

namespace {

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
  const auto m = mallinfo2();
  s.allocated_mb = double(m.uordblks + m.hblkhd) / 1e6;
  s.files = entries("/proc/self/fd"), s.threads = entries("/proc/self/task"), s.left = entries(temporary);
  return s;
}

}  // namespace limberg::bench
