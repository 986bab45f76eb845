#pragma once
// Nearest neighbours among points: a k-d tree over a copy of them.
// Build O(n log n); queries are const and allocate nothing. The same
// points give the same answers everywhere (ties go to the lower index).
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

class PointTree {
 public:
  PointTree() = default;
  explicit PointTree(std::span<const Vec3> points);

  struct Nearest {
    int32_t index = -1;  // -1: nothing within the distance asked for
    double distance = std::numeric_limits<double>::infinity();
  };
  Nearest nearest(const Vec3& p, double max_distance = std::numeric_limits<double>::infinity()) const;
  /// The `count` nearest ones, nearest first, into `out` (fewer when there are fewer points).
  void nearest(const Vec3& p, size_t count, std::vector<Nearest>& out) const;
  const Vec3& point(int32_t i) const { return x_[size_t(i)]; }
  size_t size() const { return x_.size(); }

 private:
  void build(size_t begin, size_t end);
  template <class Visit>
  void walk(const Vec3& p, size_t begin, size_t end, double& radius2, Visit&& visit) const;
  std::vector<Vec3> x_;
  std::vector<int32_t> order_;  // a range's middle is its splitting point
  std::vector<uint8_t> axis_;   // of that point
};

}  // namespace limberg
