// Prints the hash of the fixed history: see compilers.sh.
#include <cstdio>

#include "tests/sim/cutting/compilers/history.h"

int main() {
  const uint64_t h = limberg::test::history_hash();
  std::printf("%016llx %s\n", (unsigned long long)h, h == limberg::test::kHistoryHash ? "as committed" : "DIFFERENT");
  return h == limberg::test::kHistoryHash ? 0 : 1;
}
