#include "calibration/registration.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

namespace limberg {

WorldRegistration calibrate_world(const std::vector<Vec3>& touched, const std::vector<Vec3>& known,
                                  const RegistrationLimits& limits) {
  WorldRegistration r;
  const auto refuse = [&](const std::string& why) { r.advice += (r.advice.empty() ? "" : "; ") + why; };
  if (touched.size() != known.size()) {
    refuse(fmt::format("{} points were touched and {} are listed: touch each once, in the order of the list",
                       touched.size(), known.size()));
    return r;
  }
  if (touched.size() < size_t(limits.points) + 1) {
    refuse(fmt::format("{} points where {} are needed, the last of them to check the others", touched.size(),
                       limits.points + 1));
    return r;
  }
  const size_t n = touched.size() - 1;
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  for (size_t i = 0; i < n; ++i) a += touched[i] / double(n), b += known[i] / double(n);
  Mat3 B = Mat3::Zero();
  double a2 = 0;
  for (size_t i = 0; i < n; ++i) {
    B += (known[i] - b) * (known[i] - b).transpose();
    a2 += (touched[i] - a).squaredNorm();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> shape(B);
  r.spread_mm = std::sqrt(std::max(0.0, shape.eigenvalues()[1]) / double(n));
  if (r.spread_mm < limits.spread_mm) {
    refuse(
        fmt::format("the points lie nearly on a line ({:.1f} mm beside it where {:.1f} are needed): choose points "
                    "further apart to both sides",
                    r.spread_mm, limits.spread_mm));
    return r;
  }
  Eigen::Matrix3Xd from(3, n), to(3, n);
  for (size_t i = 0; i < n; ++i) from.col(Eigen::Index(i)) = touched[i], to.col(Eigen::Index(i)) = known[i];
  const Mat3 R = Eigen::umeyama(from, to, false).topLeftCorner<3, 3>();
  r.rotation = Eigen::Quaterniond(R).normalized();
  if (r.rotation.w() < 0) r.rotation.coeffs() = -r.rotation.coeffs();
  r.translation_mm = b - R * a;
  double along = 0, sum2 = 0;
  for (size_t i = 0; i < n; ++i) along += (known[i] - b).dot(R * (touched[i] - a));
  r.scale = a2 > 0 ? along / a2 : 1;
  for (size_t i = 0; i < n; ++i) sum2 += (R * touched[i] + r.translation_mm - known[i]).squaredNorm();
  r.residual_mm = std::sqrt(sum2 / double(n));
  r.held_out_mm = (R * touched[n] + r.translation_mm - known[n]).norm();
  if (std::abs(r.scale - 1) > 0.05)
    refuse(fmt::format(
        "the touched points are {:.2f} times as far apart as the listed ones: check the list's units and order",
        1 / r.scale));
  if (r.residual_mm > limits.residual_mm)
    refuse(
        fmt::format("a residual of {:.2f} mm where {:.2f} is allowed: a point was touched in the wrong order, or metal "
                    "disturbs the field",
                    r.residual_mm, limits.residual_mm));
  if (r.held_out_mm > limits.held_out_mm)
    refuse(
        fmt::format("{:.2f} mm off at the point that was held out where {:.2f} is allowed: touch more points, spread "
                    "around where you work",
                    r.held_out_mm, limits.held_out_mm));
  r.accepted = r.advice.empty();
  return r;
}

}  // namespace limberg
