#include "calibration/pivot.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration/random.h"

namespace limberg {

namespace {

constexpr double kInlierMm = 3;  // four standard deviations of the static accuracy of a FASTRAK, 0.76 mm
constexpr int kRounds = 300;     // sets of four, all good with 99.9 % even if 60 % of the poses were bad
constexpr int kEnough = 4;

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Normal equations of R t - c = -p over the chosen poses: c enters by identity, so they are well scaled in mm.
struct Solution {
  Vec3 tip, dimple;
  Mat6 normal;
};

template <class Chosen>
Solution solve(const std::vector<SensorPose>& poses, const std::vector<Mat3>& R, Chosen&& chosen, size_t n) {
  Mat6 A = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  for (size_t k = 0; k < n; ++k) {
    const size_t i = chosen(k);
    A.topLeftCorner<3, 3>() += Mat3::Identity();  // R^T R
    A.topRightCorner<3, 3>() -= R[i].transpose();
    A.bottomLeftCorner<3, 3>() -= R[i];
    A.bottomRightCorner<3, 3>() += Mat3::Identity();
    b.head<3>() -= R[i].transpose() * poses[i].pos_mm;
    b.tail<3>() += poses[i].pos_mm;
  }
  const Vec6 x = A.completeOrthogonalDecomposition().solve(b);
  return {x.head<3>(), x.tail<3>(), A};
}

double misfit(const SensorPose& p, const Mat3& R, const Solution& s) {
  return (R * s.tip + p.pos_mm - s.dimple).norm();
}

}  // namespace

PivotResult calibrate_pivot(const std::vector<SensorPose>& poses, uint64_t seed, const PivotLimits& limits) {
  PivotResult r;
  r.poses = int(poses.size());
  const auto refuse = [&](const std::string& why) { r.advice += (r.advice.empty() ? "" : "; ") + why; };
  if (r.poses < std::max(kEnough, limits.poses)) {
    refuse(fmt::format("{} poses where {} are needed: keep the tip on the {} and turn the {} for longer", r.poses,
                       limits.poses, limits.where, limits.what));
    return r;
  }
  std::vector<Mat3> R;
  for (const SensorPose& p : poses) R.push_back(p.orientation.normalized().toRotationMatrix());

  // The set of four that most poses agree with.
  SmallRandom random(seed);
  std::vector<size_t> best;
  for (int round = 0; round < kRounds; ++round) {
    std::array<size_t, kEnough> four;
    for (size_t& i : four) i = random.below(poses.size());
    const Solution s = solve(
        poses, R, [&](size_t k) { return four[k]; }, kEnough);
    // A set that does not determine the tip says nothing.
    const Eigen::SelfAdjointEigenSolver<Mat6> eigen(s.normal, Eigen::EigenvaluesOnly);
    if (eigen.eigenvalues()[0] < 1e-3) continue;
    std::vector<size_t> agree;
    for (size_t i = 0; i < poses.size(); ++i)
      if (misfit(poses[i], R[i], s) <= kInlierMm) agree.push_back(i);
    if (agree.size() > best.size()) best.swap(agree);
  }
  if (best.size() < size_t(kEnough)) {
    for (size_t i = 0; i < poses.size(); ++i) best.push_back(i);  // for the figures; it will be refused
  }
  Solution s{};
  for (int pass = 0; pass < 2; ++pass) {
    s = solve(
        poses, R, [&](size_t k) { return best[k]; }, best.size());
    std::vector<size_t> agree;
    for (size_t i = 0; i < poses.size(); ++i)
      if (misfit(poses[i], R[i], s) <= kInlierMm) agree.push_back(i);
    if (agree.size() >= size_t(kEnough)) best.swap(agree);
  }
  s = solve(
      poses, R, [&](size_t k) { return best[k]; }, best.size());
  r.tip_mm = s.tip, r.dimple_mm = s.dimple;
  r.agreeing = int(best.size());
  double sum2 = 0;
  Vec3 mean = Vec3::Zero();
  for (const size_t i : best) sum2 += std::pow(misfit(poses[i], R[i], s), 2), mean += (R[i] * s.tip).normalized();
  r.residual_mm = std::sqrt(sum2 / double(best.size()));
  if (mean.norm() > 0) mean.normalize();
  std::vector<double> lean;
  for (const size_t i : best) lean.push_back(std::acos(std::clamp((R[i] * s.tip).normalized().dot(mean), -1.0, 1.0)));
  std::sort(lean.begin(), lean.end());
  r.cone_deg = 2 * lean[size_t(0.95 * double(lean.size() - 1))] * 180 / std::numbers::pi;
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(s.normal);
  r.weakest = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / double(best.size()));
  const Mat6 inverse = s.normal.completeOrthogonalDecomposition().pseudoInverse();
  r.uncertainty_mm = r.residual_mm / std::sqrt(3.0) * std::sqrt(std::max(0.0, inverse.topLeftCorner<3, 3>().trace()));
  const size_t half = best.size() / 2;
  if (half >= size_t(kEnough)) {
    const Solution a = solve(
                       poses, R, [&](size_t k) { return best[k]; }, half),
                   b = solve(
                       poses, R, [&](size_t k) { return best[half + k]; }, best.size() - half);
    r.repeat_mm = (a.tip - b.tip).norm();
  }

  const double share = double(r.agreeing) / double(r.poses);
  if (share < limits.inliers)
    refuse(
        fmt::format("only {:.0f} % of the poses agree where {:.0f} % are needed: the tip slipped or the field is "
                    "disturbed; press it into the {}, take metal away, begin again",
                    100 * share, 100 * limits.inliers, limits.where));
  if (r.cone_deg < limits.cone_deg)
    refuse(fmt::format("a cone of {:.0f} degrees where {:.0f} are needed: tilt the {} further to all sides", r.cone_deg,
                       limits.cone_deg, limits.what));
  else if (r.weakest < limits.weakest)
    refuse(
        fmt::format("the tip is not determined along one direction ({:.3f} where {:.3f} is needed): tilt the {} to all "
                    "sides, do not only spin or rock it",
                    r.weakest, limits.weakest, limits.what));
  if (r.residual_mm > limits.residual_mm)
    refuse(
        fmt::format("a residual of {:.2f} mm where {:.2f} is allowed: the tip moved or the field is disturbed; a "
                    "deeper {}, nearer to the transmitter",
                    r.residual_mm, limits.residual_mm, limits.where));
  if (r.repeat_mm > limits.repeat_mm)
    refuse(
        fmt::format("the two halves differ by {:.2f} mm where {:.2f} is allowed: turn more evenly, for longer, or more "
                    "to all sides",
                    r.repeat_mm, limits.repeat_mm));
  r.accepted = r.advice.empty();
  return r;
}

}  // namespace limberg
