#include "calibration/pointing.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace limberg {

namespace {

using Mat5 = Eigen::Matrix<double, 5, 5>;
using Vec5 = Eigen::Matrix<double, 5, 1>;

constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr int kMostRounds = 60;

struct Line {
  Vec3 tip_mm;
  Mat3 R;
};

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

double misfit(const Line& l, const Vec3& c, const Vec3& d) {
  return angle_between(l.R.transpose() * (c - l.tip_mm), d);
}

Vec3 closest_to(const std::vector<Line>& lines, const Vec3& d) {
  Mat3 A = 1e-9 * Mat3::Identity();
  Vec3 b = Vec3::Zero();
  for (const Line& l : lines) {
    const Vec3 w = l.R * d;
    const Mat3 P = Mat3::Identity() - w * w.transpose();
    A += P, b += P * l.tip_mm;
  }
  return A.ldlt().solve(b);
}

/// Gauss-Newton; the normal equations at the end.
Mat5 fit(const std::vector<Line>& lines, Vec3& c, Vec3& d) {
  Mat5 A;
  for (int round = 0; round < kMostRounds; ++round) {
    const Vec3 e1 = d.unitOrthogonal(), e2 = d.cross(e1);
    A = Mat5::Zero();
    Vec5 b = Vec5::Zero();
    for (const Line& l : lines) {
      const Vec3 v = l.R.transpose() * (c - l.tip_mm);
      const double far = std::max(v.norm(), 1e-6);
      const Vec3 u = v / far;
      Eigen::Matrix<double, 3, 5> J;
      J.leftCols<3>() = (Mat3::Identity() - u * u.transpose()) * l.R.transpose() / far;
      J.col(3) = -e1, J.col(4) = -e2;
      A += J.transpose() * J, b -= J.transpose() * (u - d);
    }
    const Vec5 x = A.completeOrthogonalDecomposition().solve(b);
    if (!x.allFinite()) break;
    c += x.head<3>();
    d = (d + x[3] * e1 + x[4] * e2).normalized();
    if (x.head<3>().norm() < 1e-9 && x.tail<2>().norm() < 1e-12) break;
  }
  return A;
}

}  // namespace

PointingResult calibrate_pointing(const std::vector<SensorPose>& poses, const Vec3& tip_mm, const Vec3& first,
                                  const PointingLimits& limits) {
  PointingResult r;
  r.poses = int(poses.size());
  if (r.poses < std::max(10, limits.poses)) {
    r.advice = fmt::format("{} poses where {} are needed: point at the place for longer", r.poses, limits.poses);
    return r;
  }
  std::vector<Line> lines;
  for (const SensorPose& p : poses) {
    const Mat3 R = p.orientation.normalized().toRotationMatrix();
    lines.push_back({p.pos_mm + R * tip_mm, R});
  }
  Vec3 d = first.normalized(), c = closest_to(lines, d);
  fit(lines, c, d);
  std::vector<Line> best = lines;
  std::sort(best.begin(), best.end(), [&](const Line& a, const Line& b) { return misfit(a, c, d) < misfit(b, c, d); });
  best.resize(best.size() * 9 / 10);
  const Mat5 A = fit(best, c, d);
  r.direction = d, r.place_mm = c;
  double sum2 = 0;
  Vec3 mean = Vec3::Zero();
  for (const Line& l : best) sum2 += std::pow(misfit(l, c, d), 2), mean += (c - l.tip_mm).normalized();
  const double rms = std::sqrt(sum2 / double(best.size()));
  r.residual_deg = rms * kDegPerRad;
  std::vector<double> off;
  for (const Line& l : best) off.push_back(angle_between(c - l.tip_mm, mean));
  std::sort(off.begin(), off.end());
  r.cone_deg = 2 * off[size_t(0.95 * double(off.size() - 1))] * kDegPerRad;
  const Mat5 inverse = A.completeOrthogonalDecomposition().pseudoInverse();
  r.uncertainty_deg = rms / std::sqrt(2.0) * std::sqrt(std::max(0.0, inverse(3, 3) + inverse(4, 4))) * kDegPerRad;

  const auto refuse = [&](const std::string& why) { r.advice += (r.advice.empty() ? "" : "; ") + why; };
  if (!c.allFinite() || !d.allFinite())
    refuse("the lines of the forefinger meet nowhere: point at one place from several sides");
  else if (r.cone_deg < limits.cone_deg)
    refuse(fmt::format("it pointed from within {:.0f} degrees where {:.0f} are needed: go round the place to all sides",
                       r.cone_deg, limits.cone_deg));
  if (!(r.residual_deg <= limits.residual_deg))
    refuse(
        fmt::format("the forefinger was {:.1f} degrees beside the place where {:.1f} are allowed: keep pointing at "
                    "one and the same place while the hand moves",
                    r.residual_deg, limits.residual_deg));
  if (!(r.uncertainty_deg <= limits.uncertainty_deg))
    refuse(fmt::format("the direction is known to {:.1f} degrees where {:.1f} are needed: from more sides, for longer",
                       r.uncertainty_deg, limits.uncertainty_deg));
  r.accepted = r.advice.empty();
  return r;
}

}  // namespace limberg
