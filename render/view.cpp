#include "render/view.h"

#include <algorithm>
#include <cmath>

namespace limberg {

namespace {

Mat4f look(const Vec3f& eye, const Vec3f& right, const Vec3f& up, const Vec3f& back) {
  Mat4f m = Mat4f::Identity();
  m.block<1, 3>(0, 0) = right.transpose();
  m.block<1, 3>(1, 0) = up.transpose();
  m.block<1, 3>(2, 0) = back.transpose();
  m.block<3, 1>(0, 3) = -(m.block<3, 3>(0, 0) * eye);
  return m;
}

// The perspective matrix of a frustum given on its near plane.
Mat4f frustum(float l, float r, float b, float t, float n, float f) {
  Mat4f p = Mat4f::Zero();
  p(0, 0) = 2 * n / (r - l), p(0, 2) = (r + l) / (r - l);
  p(1, 1) = 2 * n / (t - b), p(1, 2) = (t + b) / (t - b);
  p(2, 2) = -(f + n) / (f - n), p(2, 3) = -2 * f * n / (f - n);
  p(3, 2) = -1;
  return p;
}

struct Axes {
  Vec3f right, up, back;
};

Axes axes_of(const Camera& c) {
  Vec3f back = c.eye_mm - c.target_mm;
  back = back.norm() > 0 ? Vec3f(back.normalized()) : Vec3f(Vec3f::UnitZ());
  Vec3f right = c.up.cross(back);
  if (right.norm() < 1e-4f * c.up.norm())
    right = Vec3f::UnitY().cross(back).norm() > 0.1f ? Vec3f(Vec3f::UnitY().cross(back)) : Vec3f(Vec3f::UnitX());
  right.normalize();
  return {right, back.cross(right), back};
}

}  // namespace

Vec3f View::to_pixel(const Vec3f& world_mm, int width, int height) const {
  const Eigen::Vector4f clip = projection * (to_eye * world_mm.homogeneous());
  const Vec3f ndc = clip.head<3>() / clip.w();
  const float u = 0.5f * (ndc.x() + 1), v = 0.5f * (1 - ndc.y());
  return {(x0 + u * (x1 - x0)) * float(width), (y0 + v * (y1 - y0)) * float(height), ndc.z()};
}

View View::part(float u0, float u1) const {
  View v = *this;
  const float middle = u0 + u1 - 1, half = u1 - u0;
  v.projection.row(0) = (projection.row(0) - middle * projection.row(3)) / half;
  v.x0 = x0 + u0 * (x1 - x0), v.x1 = x0 + u1 * (x1 - x0);
  return v;
}

View View::placed(float u0, float v0, float u1, float v1) const {
  View v = *this;
  v.x0 = u0 + x0 * (u1 - u0), v.x1 = u0 + x1 * (u1 - u0);
  v.y0 = v0 + y0 * (v1 - v0), v.y1 = v0 + y1 * (v1 - v0);
  return v;
}

Vec3f View::ray_through(float x_px, float y_px, int width, int height) const {
  const float u = (x_px / float(width) - x0) / (x1 - x0), v = (y_px / float(height) - y0) / (y1 - y0);
  const Mat4f back = (projection * to_eye).inverse();
  const Vec3f far_end = (back * Eigen::Vector4f(2 * u - 1, 1 - 2 * v, 0.5f, 1)).hnormalized();
  return (far_end - eye_mm).normalized();
}

View Camera::view(double aspect) const {
  const Axes a = axes_of(*this);
  const float t = near_mm * std::tan(0.5f * fov_deg * float(M_PI) / 180), r = t * float(aspect);
  View v;
  v.to_eye = look(eye_mm, a.right, a.up, a.back);
  v.projection = frustum(-r, r, -t, t, near_mm, far_mm);
  v.eye_mm = eye_mm;
  return v;
}

std::vector<View> Camera::stereo_pair(double aspect, double eye_distance_mm) const {
  const Axes a = axes_of(*this);
  const float distance = std::max((eye_mm - target_mm).norm(), near_mm);
  const float t = near_mm * std::tan(0.5f * fov_deg * float(M_PI) / 180), r = t * float(aspect);
  std::vector<View> views;
  for (const float side : {-0.5f, 0.5f}) {
    const float offset = side * float(eye_distance_mm), shift = -offset * near_mm / distance;
    View v;
    v.eye_mm = eye_mm + offset * a.right;
    v.to_eye = look(v.eye_mm, a.right, a.up, a.back);
    v.projection = frustum(-r + shift, r + shift, -t, t, near_mm, far_mm);
    views.push_back(v);
  }
  return views;
}

std::vector<View> Camera::stereo_side_by_side(double aspect, double eye_distance_mm) const {
  std::vector<View> views = stereo_pair(0.5 * aspect, eye_distance_mm);
  views[0].x1 = views[1].x0 = 0.5f;
  return views;
}

Camera look_at_ball(const Vec3f& centre_mm, float radius_mm, const Vec3f& from, const Vec3f& up, float fov_deg,
                    double aspect) {
  const float half_height = 0.5f * fov_deg * float(M_PI) / 180;
  const float half = std::min(half_height, std::atan(std::tan(half_height) * float(aspect)));
  const float distance = std::max(radius_mm, 1.0f) / std::sin(half);
  Camera c;
  c.target_mm = centre_mm;
  c.eye_mm = centre_mm + distance * from.normalized();
  c.up = up;
  c.fov_deg = fov_deg;
  c.near_mm = std::max(0.05f * distance, 1.0f);
  c.far_mm = 20 * distance;
  return c;
}

Camera look_at_box(const Vec3f& low_mm, const Vec3f& high_mm, float margin, const Vec3f& from, const Vec3f& up,
                   float fov_deg, double aspect) {
  const Vec3f centre = 0.5f * (low_mm + high_mm);
  const Vec3f half = (0.5f * margin * (high_mm - low_mm)).cwiseMax(0.5f);
  // A corner c is inside the picture when |across| <= (distance - toward) * slope, in both directions.
  const Vec3f back = from.normalized(), right = up.cross(back).normalized(), above = back.cross(right);
  const float slope_y = std::tan(0.5f * fov_deg * float(M_PI) / 180), slope_x = slope_y * float(aspect);
  float distance = 0, reach = 0;
  for (int k = 0; k < 8; ++k) {
    const Vec3f c((k & 1 ? 1 : -1) * half.x(), (k & 2 ? 1 : -1) * half.y(), (k & 4 ? 1 : -1) * half.z());
    const float toward = c.dot(back);
    distance =
        std::max({distance, toward + std::abs(c.dot(right)) / slope_x, toward + std::abs(c.dot(above)) / slope_y});
    reach = std::max(reach, c.norm());
  }
  Camera camera = look_at_ball(centre, reach, from, up, fov_deg, aspect);
  camera.eye_mm = centre + distance * back;
  camera.near_mm = std::max(0.05f * distance, 1.0f);
  camera.far_mm = 20 * distance;
  return camera;
}

}  // namespace limberg
