#pragma once
// A head of simple bones, and the cuts that the tests make in it.
#include <gtest/gtest.h>

#include "sim/patient/history.h"
#include "sim/skull/bone/bones.h"
#include "tests/sim/skull/bone/shapes.h"

namespace limberg::test {

inline Workers& inline_workers() {
  static InlineWorkers workers;
  return workers;
}

/// Bones with a history, as a patient keeps one.
class KeptBones : public bone::Bones {
 public:
  using Bones::Bones;
  KeptBones(Bones&& bones) : Bones(std::move(bones)) {}
  Outcome cut(const bone::Osteotomy& what) { return keep(Bones::cut(what)); }
  Outcome join(int32_t a, int32_t b, double smooth_mm = 0) { return keep(Bones::join(a, b, smooth_mm)); }
  Outcome move(int32_t id, const Eigen::Isometry3d& pose) { return keep(Bones::move(id, pose)); }
  Outcome work(int32_t id, const bone::SurfaceWork& what) { return keep(Bones::work(id, what)); }
  Outcome plate(const Vec3& a_mm, const Vec3& b_mm) { return keep(Bones::plate(a_mm, b_mm)); }
  Outcome unplate(int32_t id) { return keep(Bones::unplate(id)); }
  Outcome sort() { return keep(Bones::sort()); }
  Outcome release(int32_t id, bool snap = false) { return keep(Bones::release(id, snap)); }
  bool can_undo() const { return past_.can_undo() && !holds(-1); }
  bool can_redo() const { return past_.can_redo() && !holds(-1); }
  Outcome undo() {
    const Outcome o = past_.can_undo() ? take_back(past_.last()) : Outcome{false, "there is nothing to undo"};
    if (o.done) past_.went_back();
    return o;
  }
  Outcome redo() {
    const Outcome o = past_.can_redo() ? make_again(past_.last_undone()) : Outcome{false, "there is nothing to redo"};
    if (o.done) past_.went_forth();
    return o;
  }

 private:
  Outcome keep(bone::ActedOnBone acted) {
    EXPECT_EQ(acted.done, acted.change.has_value()) << "every act on bone can be taken back";
    if (acted.change) past_.push(std::move(*acted.change));
    return acted;
  }
  History<bone::BoneChange> past_;
};

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
