#pragma once
// A fixed history of cuts, excisions and undos; the hash of all that comes of it. The same on every compiler, at every
// level of optimisation.
#include <cstdint>

#include "sim/base/hash.h"
#include "sim/cutting/arrangement/store.h"
#include "tests/bench/fuzz/generator.h"

namespace limberg::test {

/// Committed: what the history below came to when it was written.
inline constexpr uint64_t kHistoryHash = 0x1cc7cebaa7d58fceull;

/// Two histories of 30 operations, one of them adversarial, with their lattices.
inline uint64_t history_hash() {
  Hash64 h;
  for (uint64_t seed : {3ull, 8ull}) {
    fuzz::Generator g(seed, seed == 8);
    const fuzz::Case c = g.start();
    fuzz::Runner r(c, {0, true, false});
    for (int32_t i = 0; i < 30; ++i) {
      const std::string why = r.apply(g.next(r, i));
      h.add(uint64_t(why.size()));
      h.add(r.arrangement().full_hash());
      h.add(r.lattice()->hash());
      h.add(int32_t(r.arrangement().pieces()));
    }
    h.add(r.counts().done);
  }
  return h.value();
}

}  // namespace limberg::test
