#include "sim/geometry/spline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.h"

namespace limberg {

std::vector<Vec2> spline_through(std::span<const Vec2> control, double spacing) {
  std::vector<Vec2> p;
  for (const Vec2& q : control)
    if (p.empty() || (q - p.back()).norm() > 1e-9) p.push_back(q);
  if (p.size() < 3) return p;
  const double corner = elementary::cos(60 * std::numbers::pi / 180);
  const bool closed = p.size() > 3 && (p.front() - p.back()).norm() < 1e-9;
  const size_t n = p.size();
  const auto smooth = [&](size_t i) {  // does the curve run on through control point i?
    if (!closed && (i == 0 || i + 1 == n)) return false;
    const Vec2 &before = i == 0 ? p[n - 2] : p[i - 1], &after = i + 1 == n ? p[1] : p[i + 1];
    return (p[i] - before).normalized().dot((after - p[i]).normalized()) > corner;
  };
  std::vector<Vec2> out{p[0]};
  for (size_t i = 0; i + 1 < n; ++i) {
    const Vec2 &b = p[i], &c = p[i + 1];
    // At a free end or a corner the neighbour is mirrored in the segment's middle: the curve leaves it straight.
    const Vec2 a = smooth(i) ? (i == 0 ? p[n - 2] : p[i - 1]) : Vec2(2 * b - c);
    const Vec2 d = smooth(i + 1) ? (i + 2 == n ? p[1] : p[i + 2]) : Vec2(2 * c - b);
    const double t1 = std::sqrt((b - a).norm()), t2 = t1 + std::sqrt((c - b).norm()),
                 t3 = t2 + std::sqrt((d - c).norm());
    const int parts = std::max(1, int(std::ceil((c - b).norm() / spacing)));
    for (int k = 1; k < parts; ++k) {  // Barry and Goldman's pyramid
      const double t = t1 + (t2 - t1) * k / parts;
      const Vec2 a1 = ((t1 - t) * a + t * b) / t1, a2 = ((t2 - t) * b + (t - t1) * c) / (t2 - t1),
                 a3 = ((t3 - t) * c + (t - t2) * d) / (t3 - t2);
      const Vec2 b1 = ((t2 - t) * a1 + t * a2) / t2, b2 = ((t3 - t) * a2 + (t - t1) * a3) / (t3 - t1);
      out.push_back(((t2 - t) * b1 + (t - t1) * b2) / (t2 - t1));
    }
    out.push_back(c);
  }
  return out;
}

}  // namespace limberg
