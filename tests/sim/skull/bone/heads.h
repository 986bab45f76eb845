#pragma once
// A head of simple bones, and the cuts that the tests make in it.
#include "sim/skull/bone/bones.h"
#include "tests/sim/skull/bone/shapes.h"

namespace limberg::test {

inline Workers& inline_workers() {
  static InlineWorkers workers;
  return workers;
}

/// Cranium (fixed, number 0) and mandible (1).
inline bone::Bones simple_head(int levels = 3) {
  std::vector<bone::NamedMesh> all;
  all.push_back({"cranium", skull_shell(levels), true});
  simplex::Mesh jaw = mandible(levels);
  for (Vec3& x : jaw.x_mm) x += Vec3(0, 20, -90);
  all.push_back({"mandible", jaw, false});
  return bone::Bones(std::move(all), inline_workers());
}

/// In the forehead.
inline bone::Osteotomy window(double radius_mm = 26) {
  bone::Osteotomy o;
  o.path_mm = on_ellipsoid(circle({0, 68, 30}, {0, 1, 0.5}, radius_mm, 80));
  return o;
}
/// Through the mandible, left of the middle.
inline bone::Osteotomy chin() {
  bone::Osteotomy o;
  o.kind = bone::Osteotomy::Kind::plane, o.point_mm = {12, 57, -90}, o.normal = {1, 0, 0}, o.radius_mm = 15;
  return o;
}
inline Eigen::Isometry3d moved(const Vec3& by, double angle = 0, const Vec3& axis = Vec3::UnitZ()) {
  Eigen::Isometry3d p = Eigen::Isometry3d::Identity();
  p.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  p.translation() = by;
  return p;
}

}  // namespace limberg::test
