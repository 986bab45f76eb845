#include "sim/contact/surface_motion.h"

#include <algorithm>
#include <cmath>

namespace limberg {
namespace {

constexpr size_t kGrain = 2048;
constexpr double kReach_mm = 4;   // what comes nearer than kTrusted_mm and the motion of both
constexpr double kMostBlocks = 40;  // along an axis; beyond, blocks are larger

}  // namespace

SurfaceMotion::SurfaceMotion(const ContactSurface& s, const FemModel& model) {
  std::vector<int32_t> copy(s.carrier.begin(), s.carrier.end());
  for (int32_t v : s.vertex) copy.push_back(s.view->cell_copy[size_t(v)]);
  std::sort(copy.begin(), copy.end());
  copy.erase(std::unique(copy.begin(), copy.end()), copy.end());
  for (int32_t c : copy) {
    const auto& n = s.lattice->cells[size_t(c)].node;
    node_.insert(node_.end(), n.begin(), n.end());
  }
  std::sort(node_.begin(), node_.end());
  node_.erase(std::unique(node_.begin(), node_.end()), node_.end());
  for (int32_t n : node_) rest_.push_back(model.X_mm[size_t(n)]);
  for (int32_t c : copy) {
    const auto& n = s.lattice->cells[size_t(c)].node;
    std::array<int32_t, 8> slot{};
    for (size_t k = 0; k < 8; ++k) slot[k] = int32_t(std::lower_bound(node_.begin(), node_.end(), n[k]) - node_.begin());
    slot_.push_back(slot);
  }
  for (const ContactPlace& p : s.place)
    carrier_of_place_.push_back(size_t(std::lower_bound(copy.begin(), copy.end(), s.carrier[size_t(p.triangle)]) - copy.begin()));
  then_.assign(node_.size(), Vec3f::Zero());
  move_.assign(node_.size(), 0);
  block_.assign(slot_.size(), 0);
  block_move_.assign(1, 0);
}

void SurfaceMotion::sort_into_blocks(std::span<const Vec3f> u) {
  std::vector<Vec3> at(node_.size()), middle(slot_.size());
  for (size_t i = 0; i < node_.size(); ++i) {
    at[i] = rest_[i] + u[size_t(node_[i])].cast<double>();
  }
  double radius = 0;
  Vec3 lo = Vec3::Constant(1e30), hi = -lo;
  for (size_t c = 0; c < slot_.size(); ++c) {
    Vec3& m = middle[c] = Vec3::Zero();
    for (int32_t k : slot_[c]) m += at[size_t(k)] / 8;
    for (int32_t k : slot_[c]) radius = std::max(radius, (at[size_t(k)] - m).norm());
    lo = lo.cwiseMin(m), hi = hi.cwiseMax(m);
  }
  const double size = std::max(2 * radius + kReach_mm, (hi - lo).maxCoeff() / kMostBlocks);
  for (int a = 0; a < 3; ++a) blocks_[size_t(a)] = int32_t((hi[a] - lo[a]) / size) + 1;
  for (size_t c = 0; c < slot_.size(); ++c) {
    const Vec3 p = (middle[c] - lo) / size;
    block_[c] = (int32_t(p[2]) * blocks_[1] + int32_t(p[1])) * blocks_[0] + int32_t(p[0]);
  }
  block_move_.assign(size_t(blocks_[0] * blocks_[1] * blocks_[2]), 0);
}

double SurfaceMotion::measure(std::span<const Vec3f> u, Workers& workers) {
  workers.parallel_for(node_.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vec3f now = u[size_t(node_[i])];
      move_[i] = (now - then_[i]).squaredNorm();
      then_[i] = now;
    }
  });
  float most2 = 0;
  for (float m : move_) most2 = std::max(most2, m);
  const double most = since_sorted_mm_ == 1e30 ? 1e30 : std::sqrt(double(most2));
  if (most > kTrusted_mm || since_sorted_mm_ > kTrusted_mm) {
    sort_into_blocks(u);
    since_sorted_mm_ = 0;
    std::fill(block_move_.begin(), block_move_.end(), most);
    return most;
  }
  since_sorted_mm_ += most;
  std::fill(block_move_.begin(), block_move_.end(), 0);
  if (most == 0) return 0;
  for (size_t c = 0; c < slot_.size(); ++c) {
    float m = 0;
    for (int32_t k : slot_[c]) m = std::max(m, move_[size_t(k)]);
    double& b = block_move_[size_t(block_[c])];
    b = std::max(b, double(m));
  }
  int32_t step = 1;
  for (size_t a = 0; a < 3; ++a) {  // and of the blocks beside, one axis after the other
    spread_ = block_move_;
    for (int32_t i = 0; i < int32_t(block_move_.size()); ++i) {
      const int32_t along = i / step % blocks_[a];
      if (along > 0) spread_[size_t(i)] = std::max(spread_[size_t(i)], block_move_[size_t(i - step)]);
      if (along + 1 < blocks_[a]) spread_[size_t(i)] = std::max(spread_[size_t(i)], block_move_[size_t(i + step)]);
    }
    block_move_.swap(spread_);
    step *= blocks_[a];
  }
  for (double& b : block_move_) b = std::sqrt(b);
  return most;
}

}  // namespace limberg
