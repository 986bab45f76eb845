#include "app/window/orbit.h"

#include <algorithm>
#include <cmath>

namespace limberg {

void turn(Camera& c, float dx, float dy) {
  const Vec3f up = c.up.normalized(), arm = c.eye_mm - c.target_mm;
  const float distance = std::max(arm.norm(), 1e-3f);
  const float polar = std::acos(std::clamp(arm.dot(up) / distance, -1.0f, 1.0f));
  const float wanted = std::clamp(polar - dy, 0.03f, float(M_PI) - 0.03f);
  Vec3f flat = arm - arm.dot(up) * up;
  if (flat.norm() < 1e-4f * distance) flat = up.unitOrthogonal();
  flat = Eigen::AngleAxisf(-dx, up) * flat.normalized();
  c.eye_mm = c.target_mm + distance * (std::cos(wanted) * up + std::sin(wanted) * flat);
}

void shift(Camera& c, float dx_px, float dy_px, int height_px) {
  const Vec3f back = (c.eye_mm - c.target_mm).normalized(), right = c.up.cross(back).normalized(),
              above = back.cross(right);
  const float mm_per_px = 2 * (c.eye_mm - c.target_mm).norm() * std::tan(0.5f * c.fov_deg * float(M_PI) / 180) /
                          float(std::max(height_px, 1));
  const Vec3f move = mm_per_px * (dy_px * above - dx_px * right);
  c.eye_mm += move, c.target_mm += move;
}

void approach(Camera& c, float factor) {
  const Vec3f arm = c.eye_mm - c.target_mm;
  const float distance = std::clamp(arm.norm() * factor, 10.0f, 3000.0f);
  c.eye_mm = c.target_mm + distance * arm.normalized();
  c.near_mm = std::max(0.05f * distance, 1.0f), c.far_mm = 20 * distance;
}

}  // namespace limberg
