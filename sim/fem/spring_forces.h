#pragma once
// Zero-length embedded springs, in double: energy k/2 |r|^2 with r = a - target, or a - b - target (target: the slack of a stitch).
#include <span>
#include <vector>

#include "sim/fem/fem_model.h"
#include "sim/fem/simd.h"

namespace limberg::fem {

class SpringForces {
 public:
  SpringForces() = default;
  SpringForces(const FemModel& model, std::span<const Spring> springs);

  /// Adds forces of all springs to g (as a gradient; fixed nodes included) and returns energy and its noise scale. `measure`: also adds
  /// the norm of each nodal share to w.
  double add(const NodeArray& u, NodeArray& g, bool measure) const;
  size_t size() const { return items_.size(); }
  /// Index of an id, or -1.
  int find(int32_t id) const;
  /// r: a - target, or a - b - target, in mm.
  Vec3 gap_mm(size_t i, const NodeArray& u) const;
  /// Force in mN on point a.
  Vec3 force_mN(size_t i, const NodeArray& u) const { return -items_[i].k * gap_mm(i, u); }

 private:
  struct Item {
    int32_t id = 0;
    double k = 0;  // mN/mm
    Vec3 offset = Vec3::Zero();
    int count = 0;
    std::array<int32_t, 16> node{};
    std::array<double, 16> w{};
  };
  std::vector<Item> items_;
};

}  // namespace limberg::fem
