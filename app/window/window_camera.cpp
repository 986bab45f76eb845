#include "app/window/window_camera.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "app/window/orbit.h"
#include "app/window/ray_cast.h"
#include "devices/skin_chart.h"

namespace limberg {

Camera fitted(const Camera& camera, double aspect) {
  constexpr double kWide = 1.25, kDegree = 3.14159265358979 / 180;
  Camera c = camera;
  if (aspect < kWide)
    c.fov_deg = float(2 / kDegree * std::atan(std::tan(0.5 * kDegree * double(camera.fov_deg)) * kWide / aspect));
  return c;
}

bool look_at_plan(Camera& camera, const LessonPlan& plan, const Snapshot& s) {
  constexpr double kSeen = 0.55;                     // cosine: so obliquely is a plan still seen well
  constexpr float kShare = 0.4f, kNearest_mm = 130;  // of the height of the picture that the plan fills
  if (!has_surface(s) || !s.topology->body || s.topology->body->is_box) return false;
  SkinChart chart;
  chart.build(*s.topology);
  Vec3 centre = Vec3::Zero(), normal = Vec3::Zero();
  std::vector<Vec3> places;
  for (const PlannedAct& a : plan.acts)
    if (const auto line = drawn_line(a.command))
      for (const ChartPoint& p : line->path)
        if (const SkinTouch at = chart.at(s, p, 2); at.triangle >= 0)
          places.push_back(at.x_mm), centre += at.x_mm, normal += at.normal;
  if (places.size() < 2 || !(normal.norm() > 1e-6)) return false;
  centre /= double(places.size()), normal.normalize();
  double reach = 0;
  for (const Vec3& p : places) reach = std::max(reach, (p - centre).norm());
  if ((camera.eye_mm.cast<double>() - centre).normalized().dot(normal) > kSeen &&
      (camera.eye_mm.cast<double>() - centre).norm() < 12 * reach)
    return false;
  const float half = std::tan(0.5f * camera.fov_deg * float(M_PI) / 180);
  const float far_mm = std::max(kNearest_mm, float(reach) / (kShare * half));
  camera.target_mm = centre.cast<float>(), camera.eye_mm = (centre + double(far_mm) * normal).cast<float>();
  approach(camera, 1);
  return true;
}

void keep_out_of(const Snapshot& s, bool no_face, Camera& camera, Vec3f& guarded_mm) {
  constexpr float kFar_mm = 3000, kRoom_mm = 12;
  if (!has_surface(s) || (camera.eye_mm - guarded_mm).norm() < 1e-3f) return;
  const Vec3f arm = camera.eye_mm - camera.target_mm;
  const float far_mm = arm.norm();
  if (far_mm > 0) {
    const Vec3f out = arm / far_mm;
    const RayHit hit = cast_ray(s, camera.target_mm + kFar_mm * out, -out, no_face);
    const float least = kFar_mm - hit.distance_mm + kRoom_mm;
    if (hit.triangle >= 0 && far_mm < least) approach(camera, least / far_mm);
  }
  guarded_mm = camera.eye_mm;
}

}  // namespace limberg
