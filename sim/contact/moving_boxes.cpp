#include "sim/contact/moving_boxes.h"

#include <algorithm>
#include <utility>

namespace limberg {
namespace {

constexpr float kFar_mm = 1e30f;
constexpr uint32_t kSteps = 1023;  // of the curve, along the longest axis

/// Every third bit: those of a number of ten bits.
uint32_t spread(uint32_t v) {
  v = (v | (v << 16)) & 0x030000ff;
  v = (v | (v << 8)) & 0x0300f00f;
  v = (v | (v << 4)) & 0x030c30c3;
  return (v | (v << 2)) & 0x09249249;
}

}  // namespace

MovingBoxes::MovingBoxes(std::vector<int32_t> members) : order_(std::move(members)) {
  for (size_t n = order_.size(); n > 0;) {
    n = (n + 3) / 4;
    level_.emplace_back(n);
    if (n == 1) break;
  }
}

void MovingBoxes::sort(std::span<const Box> box) {
  if (order_.empty()) return;
  const auto middle = [&](int32_t i) { return 0.5f * (box[size_t(i)].lo + box[size_t(i)].hi); };
  v4 lo = middle(order_[0]), hi = lo;
  for (int32_t i : order_) {
    const v4 m = middle(i);
    lo = m < lo ? m : lo, hi = m > hi ? m : hi;
  }
  const v4 size = hi - lo;
  const float most = std::max({size[0], size[1], size[2]}), steps_per_mm = most > 0 ? float(kSteps) / most : 0;
  std::vector<std::pair<uint32_t, int32_t>> by;
  by.reserve(order_.size());
  for (int32_t i : order_) {
    const v4 m = middle(i) - lo;
    uint32_t code = 0;
    for (int a = 0; a < 3; ++a) code |= spread(std::min(kSteps, uint32_t(m[a] * steps_per_mm))) << a;
    by.push_back({code, i});
  }
  std::sort(by.begin(), by.end());
  for (size_t k = 0; k < by.size(); ++k) order_[k] = by[k].second;
  refit(box);
}

void MovingBoxes::refit(std::span<const Box> box) {
  for (size_t level = 0; level < level_.size(); ++level)
    for (size_t k = 0; k < level_[level].size(); ++k) {
      Four& f = level_[level][k];
      f.lo.fill(v4{} + kFar_mm), f.hi.fill(v4{} - kFar_mm);
      for (size_t j = 0; j < 4; ++j) {
        const size_t child = 4 * k + j;
        if (child >= (level == 0 ? order_.size() : level_[level - 1].size())) continue;
        for (size_t a = 0; a < 3; ++a) {
          if (level == 0) {
            const Box& b = box[size_t(order_[child])];
            f.lo[a][j] = b.lo[a], f.hi[a][j] = b.hi[a];
          } else {
            const v4 &l = level_[level - 1][child].lo[a], &h = level_[level - 1][child].hi[a];
            f.lo[a][j] = std::min({l[0], l[1], l[2], l[3]}), f.hi[a][j] = std::max({h[0], h[1], h[2], h[3]});
          }
        }
      }
    }
}

}  // namespace limberg
