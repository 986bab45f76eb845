#pragma once
// What can be seen of a motion: one rule for everybody who draws again only when a picture would look different (the
// render lane: whether there is a frame at all; the window: whether its picture of the patient still stands).
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// A quarter of a pixel when the skin block fills a picture that is 1280 wide.
inline constexpr double kVisible_mm = 0.02;

inline bool visibly_moved(const Vec3f& a, const Vec3f& b) {
  return double((a - b).squaredNorm()) > kVisible_mm * kVisible_mm;
}
inline bool visibly_moved(const double (&a)[3], const double (&b)[3], double scale = 1) {
  double d2 = 0;
  for (int i = 0; i < 3; ++i) d2 += (a[i] - b[i]) * (a[i] - b[i]);
  return scale * scale * d2 > kVisible_mm * kVisible_mm;
}
/// Any of them; or there are more, or fewer.
inline bool visibly_moved(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  if (a.size() != b.size()) return true;
  for (size_t i = 0; i < a.size(); ++i)
    if (visibly_moved(a[i], b[i])) return true;
  return false;
}

}  // namespace limberg
