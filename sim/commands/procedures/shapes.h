#pragma once
// Lines that the figures are drawn with.
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/commands/plan_numbers.h"

namespace limberg::figures {

using limberg::turned;
inline Vec2 along(double deg) { return direction(deg); }
/// Both ends included; `n` pieces.
inline std::vector<Vec2> arc(const Vec2& centre, double radius, double from_deg, double to_deg, int n) {
  std::vector<Vec2> out;
  for (int i = 0; i <= n; ++i) out.push_back(centre + radius * along(from_deg + (to_deg - from_deg) * i / n));
  return out;
}
inline std::vector<Vec2> reversed(std::vector<Vec2> p) { return {p.rbegin(), p.rend()}; }

/// Collects a wound's corners and gives the last one's number.
struct Walk {
  std::vector<Vec2> at;
  int operator()(const Vec2& p) {
    at.push_back(p);
    return int(at.size()) - 1;
  }
  /// All but the first point, which stands already.
  int on(const std::vector<Vec2>& path) {
    at.insert(at.end(), path.begin() + 1, path.end());
    return int(at.size()) - 1;
  }
  /// All but the first and the last.
  void between(const std::vector<Vec2>& path) { at.insert(at.end(), path.begin() + 1, path.end() - 1); }
};

/// A seam of one wound with itself.
inline Seam seam(int a_from, int a_to, int b_from, int b_to) {
  return {{0, a_from}, {0, a_to}, {0, b_from}, {0, b_to}};
}

}  // namespace limberg::figures
