#pragma once
// A hook for tests of the arrangement and the lattice: every sign that decides a cut, and every step of it, passes
// here. Null wherever the program runs. With a plan, a test can
//   count   how many signs and steps an operation takes (calls)
//   zero    make the signs from number `at` on come out as zero, as an unforeseen coincidence would, and steps fail
//   thrown  throw std::bad_alloc at number `at`, as memory at its end would
//   record  compare every sign with one that is computed in another way (watch)
// and check that a cut that is not made has changed nothing.
#include <cstdint>
#include <new>

#include "sim/geometry/exact/predicates.h"

namespace limberg {

/// Sees every sign as it is computed, with what it was computed from.
struct SignWatcher {
  virtual ~SignWatcher() = default;
  virtual void side(const Plane& plane, const PointRef& p, int sign) = 0;
  virtual void turn(const Plane& plane, const PointRef& a, const PointRef& b, const PointRef& c, int sign) = 0;
  virtual void order(int axis, const PointRef& a, const PointRef& b, int sign) = 0;
};

struct FaultPlan {
  enum Kind : uint8_t { count, zero, thrown };
  Kind kind = count;
  int64_t at = -1;              // number of the call that goes wrong, from 0
  int64_t until = -1;           // zero: the first call that is right again
  int64_t calls = 0;            // so far
  int64_t struck = 0;           // calls that were made to go wrong
  bool skip_embedding = false;  // takes blades that run through themselves
  SignWatcher* watch = nullptr;

  /// Is this call to go wrong? Counts it.
  bool strikes() {
    const int64_t n = calls++;
    if (kind == count || n < at || n >= until) return false;
    ++struck;
    if (kind == thrown) throw std::bad_alloc();
    return true;
  }
};

}  // namespace limberg
