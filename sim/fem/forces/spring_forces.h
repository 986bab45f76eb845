#pragma once
// Zero-length embedded springs, in double: energy k/2 |r|^2 with r
// = a - target, or a - b - target (target: the slack of a stitch).
//
// Threads: spans of lengths l_i = |a - b| share a thread of length L that slides without friction.
// What of it lies in span i is s_i >= 0, sum s_i = L, and it goes where it makes the energy least:
//
//   E = min over s of  sum_i k/2 (l_i - s_i)^2   =>   s_i = max(0, l_i - m),  sum_i s_i = L,  tension of span i
//                                                                                             = k min(l_i, m).
//
// So every span that thread can still leave pulls with the same tension T = k m. A span whose
// thread is used up (s_i = 0: the edges have met there) pulls with less, k l_i: what is missing to
// T is the pressure of edge on edge. A thread that is longer than the way through its bites pulls
// nothing (m = 0). E is convex in the l_i, and its gradient is continuous, also where l_i = 0.
//
// What lies along the wound from one stitch to the next does not slide away: in a
// hand every bite holds its own by friction, and a thread that could take it would
// gather the wound like a purse. Such a span keeps |target| of the thread for itself:
// l_i = max(0, |a - b| - |target|), and L is what the spans leave. It pulls only when
// it is longer than that; T = 0 there, so E stays convex with a continuous gradient.
#include <algorithm>
#include <span>
#include <vector>

#include "sim/base/simd.h"
#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

/// Whether two springs hold the same places by the same rule: one is the other with another target, or another length
/// of its thread.
inline bool held_alike(const Spring& a, const Spring& b) {
  return a.id == b.id && a.thread == b.thread && a.to_world == b.to_world && a.k_N_per_mm == b.k_N_per_mm &&
         std::ranges::equal(a.held_a(), b.held_a()) && (a.to_world || std::ranges::equal(a.held_b(), b.held_b()));
}

class SpringForces {
 public:
  SpringForces() = default;
  SpringForces(const FemModel& model, std::span<const Spring> springs);

  /// Adds forces of all springs to g (as a gradient; fixed nodes included) and returns energy and its noise scale.
  /// `measure`: also adds the norm of each nodal share to w.
  double add(const NodeArray& u, NodeArray& g, bool measure) const;
  size_t size() const { return items_.size(); }
  /// m of a thread of length L through spans of the given lengths (any order; it is sorted in place).
  static double thread_stretch_mm(std::vector<double>& length_mm, double thread_mm);
  /// Index of an id, or -1.
  int find(int32_t id) const;
  /// r: a - target, or a - b - target, in mm; a - b in a thread.
  Vec3 gap_mm(size_t i, const NodeArray& u) const;
  /// Force in mN on point a.
  Vec3 force_mN(size_t i, const NodeArray& u) const;

 private:
  struct Item {
    int32_t id = 0;
    double k = 0;  // mN/mm
    Vec3 offset = Vec3::Zero();
    int thread = -1;     // index into threads_
    double keep_mm = 0;  // of the thread
    std::vector<int32_t> node;
    std::vector<double> w;
  };
  struct Thread {
    double length_mm = 0;
    std::vector<size_t> spans;  // items
  };
  double length_mm(const Item& item, const Vec3& r) const;  // l
  double stretch_mm(const Thread& thread, const NodeArray& u) const;
  void pull(const Item& item, const Vec3& force, NodeArray& g, bool measure) const;
  std::vector<Item> items_;
  std::vector<Thread> threads_;
};

}  // namespace limberg::fem
