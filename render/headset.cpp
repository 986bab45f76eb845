#include "render/headset.h"

#include <cmath>

namespace limberg {

View eye_view(const Vec3f& at_mm, const Eigen::Quaternionf& turned, const EyeAngles& a, float n, float f) {
  View v;
  v.eye_mm = at_mm;
  const Eigen::Matrix3f back = turned.normalized().toRotationMatrix().transpose();
  v.to_eye.block<3, 3>(0, 0) = back;
  v.to_eye.block<3, 1>(0, 3) = -(back * at_mm);
  const float l = std::tan(a.left), r = std::tan(a.right), u = std::tan(a.up), d = std::tan(a.down);
  v.projection.setZero();
  v.projection(0, 0) = 2 / (r - l), v.projection(0, 2) = (r + l) / (r - l);
  v.projection(1, 1) = 2 / (u - d), v.projection(1, 2) = (u + d) / (u - d);
  v.projection(2, 2) = -(f + n) / (f - n), v.projection(2, 3) = -2 * f * n / (f - n);
  v.projection(3, 2) = -1;
  return v;
}

}  // namespace limberg
