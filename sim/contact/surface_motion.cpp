#include "sim/contact/surface_motion.h"

#include <algorithm>
#include <cmath>

namespace limberg {
namespace {

constexpr double kBlocksSorted_mm = 0.5;  // cells may go so far until they are sorted again
constexpr int32_t kAround = 2;            // blocks on each side
constexpr double kMostBlocks = 64;        // along an axis; beyond, blocks are larger
constexpr float kBlocksFar_mm = 1e6f;

v4 all(float x) { return v4{x, x, x, 0}; }

}  // namespace

SurfaceMotion::SurfaceMotion(const RestTissue& tissue, const FemModel& model) : tissue_(tissue) {
  for (int32_t n : tissue.nodes()) rest_.push_back(model.X_mm[size_t(n)]);
  then_.assign(rest_.size(), v4{});
  move_.assign(rest_.size(), v4{});
  block_.assign(tissue.size(), 0);
  move_of_.assign(tissue.size(), {all(-kBlocksFar_mm), all(kBlocksFar_mm)});
}

// A block is as wide as half of what can lie between the middles of two cells that count, so that two blocks around
// are enough: reach, the cell's radius on either side, and what both may move until cells are sorted again.
void SurfaceMotion::sort_into_blocks(std::span<const Vec3f> u) {
  std::vector<Vec3> middle(block_.size());
  double radius = 0;
  Vec3 lo = Vec3::Constant(1e30), hi = -lo;
  for (size_t c = 0; c < block_.size(); ++c) {
    std::array<Vec3, 8> at;
    Vec3& m = middle[c] = Vec3::Zero();
    for (size_t k = 0; k < 8; ++k) {
      const size_t i = size_t(tissue_.slots(c)[k]);
      at[k] = rest_[i] + u[size_t(tissue_.nodes()[i])].cast<double>();
      m += at[k] / 8;
    }
    for (const Vec3& p : at) radius = std::max(radius, (p - m).norm());
    lo = lo.cwiseMin(m), hi = hi.cwiseMax(m);
  }
  const double size =
      std::max((kReach_mm + 2 * radius + 2 * kBlocksSorted_mm) / kAround, (hi - lo).maxCoeff() / kMostBlocks);
  for (int a = 0; a < 3; ++a) blocks_[size_t(a)] = int32_t((hi[a] - lo[a]) / size) + 1;
  for (size_t c = 0; c < block_.size(); ++c) {
    const Vec3 p = (middle[c] - lo) / size;
    block_[c] = (int32_t(p[2]) * blocks_[1] + int32_t(p[1])) * blocks_[0] + int32_t(p[0]);
  }
  since_sorted_mm_ = 0;
}

bool SurfaceMotion::measure(std::span<const Vec3f> u) {
  float most2 = 0;
  for (size_t i = 0; i < rest_.size(); ++i) {
    const Vec3f& d = u[size_t(tissue_.nodes()[i])];
    const v4 now = {d[0], d[1], d[2], 0};
    move_[i] = now - then_[i];
    const v4 square = move_[i] * move_[i];
    most2 = std::max(most2, square[0] + (square[1] + square[2]));
    then_[i] = now;
  }
  const bool first = since_sorted_mm_ == 1e30;
  most_mm_ = first ? 1e30 : std::sqrt(double(most2));
  if (most2 == 0 && !first) return false;
  since_sorted_mm_ += std::sqrt(double(most2));
  if (since_sorted_mm_ > kBlocksSorted_mm) {
    sort_into_blocks(u);
    if (first || std::sqrt(double(most2)) > kReach_mm) {  // it may have jumped over what is near
      near_.assign(size_t(blocks_[0] * blocks_[1] * blocks_[2]), {all(-kBlocksFar_mm), all(kBlocksFar_mm)});
      move_of_.assign(move_of_.size(), {all(-kBlocksFar_mm), all(kBlocksFar_mm)});
      return true;
    }
  }
  const Box none{all(kBlocksFar_mm), all(-kBlocksFar_mm)};
  near_.assign(size_t(blocks_[0] * blocks_[1] * blocks_[2]), none);
  for (size_t c = 0; c < block_.size(); ++c) {
    Box& b = move_of_[c];
    b = none;
    for (int32_t k : tissue_.slots(c)) b.add({move_[size_t(k)], move_[size_t(k)]});
    near_[size_t(block_[c])].add(b);
  }
  int32_t step = 1;
  for (size_t a = 0; a < 3; ++a) {  // and of the blocks around, one axis after the other
    if (blocks_[a] > 1) {
      spread_ = near_;
      for (int32_t i = 0; i < int32_t(near_.size()); ++i) {
        const int32_t along = i / step % blocks_[a];
        const int32_t from = std::max(-along, -kAround), to = std::min(blocks_[a] - 1 - along, kAround);
        for (int32_t k = from; k <= to; ++k)
          if (k != 0) spread_[size_t(i)].add(near_[size_t(i + k * step)]);
      }
      near_.swap(spread_);
    }
    step *= blocks_[a];
  }
  return true;
}

}  // namespace limberg
