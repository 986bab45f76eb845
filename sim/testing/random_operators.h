#pragma once
// Random sequences of operators with every invariant checked after each: for the tests and for `limberg bench simplex`.
#include <array>
#include <cstdint>
#include <string>

#include "sim/skull/simplex/mesh.h"

namespace limberg::simplex {

struct RandomOperators {
  static constexpr int kinds = 7;
  static constexpr const char* name[kinds] = {"t1", "t2", "exchange", "t3", "t4", "t3_spokes", "t4_edges"};
  int64_t operations = 0;  // tried
  int64_t sequences = 0;   // each from the mesh given
  std::array<int64_t, kinds> done{}, refused{};
  int64_t undone = 0;  // whole stretches taken back, bit for bit
  std::string fault;   // what broke first, with the number of the operation; empty: nothing
  uint64_t hash = 0;   // of the mesh at the end
};

/// Tries `operations` operators, in sequences of `length` that each begin with `mesh`,
/// chosen and placed by `seed` (some of them senseless on purpose). After each: find_fault,
/// the change of V, E, F and chi that its kind promises, and an unchanged hash when it was
/// refused. Now and then the last stretch is undone and the hash compared. Stops at a fault.
RandomOperators random_operators(const Mesh& mesh, int64_t operations, uint64_t seed, int64_t length = 150);

}  // namespace limberg::simplex
