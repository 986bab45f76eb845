#include "app/headset/room.h"

#include <algorithm>
#include <cmath>

namespace limberg {

namespace {

constexpr float kCloth = -1;  // PropVertex::metal

/// Ahead along the floor: where it looks, or where its crown points when it looks straight down.
Vec3 ahead_of(const RoomPose& head) {
  Vec3 ahead = -(head.turned * Vec3::UnitZ());
  ahead.y() = 0;
  if (ahead.norm() < 0.2) {
    ahead = head.turned * Vec3::UnitY();
    ahead.y() = 0;
  }
  return ahead.norm() > 1e-6 ? Vec3(ahead.normalized()) : Vec3(-Vec3::UnitZ());
}

/// Axes as columns: to the right, upwards, back.
Eigen::Matrix3d axes(const Vec3& up, const Vec3& ahead) {
  Eigen::Matrix3d m;
  m.col(0) = ahead.cross(up), m.col(1) = up, m.col(2) = -ahead;
  return m;
}

/// A box whose sides lie along the columns of `turn`.
void add_box(PropMesh& mesh, const Vec3f& centre, const Eigen::Matrix3f& turn, const Vec3f& half,
             const PropLook& look) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const Vec3f n = side * turn.col(axis), a = turn.col((axis + 1) % 3), b = side * turn.col((axis + 2) % 3);
      const float ha = half[(axis + 1) % 3], hb = half[(axis + 2) % 3];
      const uint32_t first = uint32_t(mesh.vertex.size());
      const Vec3f c = centre + half[axis] * n;
      for (const auto& [u, v] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}})
        mesh.vertex.push_back({c + u * ha * a + v * hb * b, n, look.colour, look.metal, look.id});
      mesh.tri.push_back({first, first + 1, first + 2});
      mesh.tri.push_back({first, first + 2, first + 3});
    }
}

}  // namespace

PatientPlace PatientPlace::before(const RoomPose& head, bool floor, const Camera& camera, const RoomSettings& set) {
  const Vec3 ahead = ahead_of(head);
  const Vec3 up = camera.up.cast<double>().normalized();
  Vec3 from_camera = (camera.target_mm - camera.eye_mm).cast<double>();
  from_camera -= from_camera.dot(up) * up;
  if (from_camera.norm() < 1e-6) from_camera = up.unitOrthogonal();
  PatientPlace p;
  p.turn_ = axes(up, from_camera.normalized()) * axes(Vec3::UnitY(), ahead).transpose();
  p.mm_per_m_ = 1000 / set.scale;
  p.anchor_mm_ = camera.target_mm.cast<double>();
  p.ahead_ = ahead;
  p.at_m_ = head.at_m + set.reach_m * ahead;
  const double below_eyes = head.at_m.y() - set.below_m;
  p.at_m_.y() = floor ? std::min(set.table_m, below_eyes) : below_eyes;
  return p;
}

PropMesh room_props(const PatientPlace& place, const Vec3f& low_mm, const Vec3f& high_mm, double floor_below_m) {
  PropMesh mesh;
  const float mm = float(place.mm_per_m());
  Eigen::Matrix3f turn;  // the room's axes in the patient's frame
  for (int k = 0; k < 3; ++k) turn.col(k) = place.direction(Vec3::Unit(k)).cast<float>();
  // The table's top lies just below the tissue's lowest corner; its sides reach beyond the tissue.
  float lowest = 0;
  for (int k = 0; k < 8; ++k) {
    const Vec3f c(k & 1 ? low_mm.x() : high_mm.x(), k & 2 ? low_mm.y() : high_mm.y(), k & 4 ? low_mm.z() : high_mm.z());
    const float h = c.dot(turn.col(1));
    lowest = k == 0 ? h : std::min(lowest, h);
  }
  const Vec3f middle = 0.5f * (low_mm + high_mm);
  const Vec3f top = middle + (lowest - 0.004f * mm - middle.dot(turn.col(1))) * turn.col(1);
  const Vec3f half(0.45f * mm, 0.02f * mm, 0.28f * mm);
  add_box(mesh, top - half.y() * turn.col(1), turn, half, {{0.05f, 0.20f, 0.17f}, kCloth, 0});
  add_box(mesh, top - (2 * half.y() + 0.25f * mm) * turn.col(1), turn, {0.10f * mm, 0.25f * mm, 0.10f * mm},
          {{0.16f, 0.17f, 0.18f}, kCloth, 0});
  // A floor of tiles, so that one sees where it is.
  constexpr int kTiles = 8;
  const float tile = 0.5f * mm;
  const Vec3f ground = top - float(floor_below_m) * mm * turn.col(1);
  for (int i = -kTiles; i < kTiles; ++i)
    for (int j = -kTiles; j < kTiles; ++j) {
      const float grey = (i + j) & 1 ? 0.100f : 0.118f;
      const Vec3f corner = ground + float(i) * tile * turn.col(0) + float(j) * tile * turn.col(2);
      const Vec3f a = tile * turn.col(2), b = tile * turn.col(0), n = turn.col(1), colour(grey, grey, 1.03f * grey);
      const uint32_t first = uint32_t(mesh.vertex.size());
      for (const Vec3f& x : {corner, Vec3f(corner + a), Vec3f(corner + a + b), Vec3f(corner + b)})
        mesh.vertex.push_back({x, n, colour, kCloth, 0});
      mesh.tri.push_back({first, first + 1, first + 2});
      mesh.tri.push_back({first, first + 2, first + 3});
    }
  return mesh;
}

BoardPlace tablet_place(const PatientPlace& place, const RoomPose& head, double width_over_height) {
  constexpr double kWidth_m = 0.42, kLeft_m = 0.24, kBehind_m = 0.30, kAbove_m = 0.14;
  const Vec3 ahead = place.ahead(), up = Vec3::UnitY();
  const Vec3 centre = place.at_m() - kLeft_m * ahead.cross(up) + kBehind_m * ahead + kAbove_m * up;
  const Vec3 to_eyes = (head.at_m - centre).normalized();
  const Vec3 right = up.cross(to_eyes).normalized(), above = to_eyes.cross(right);
  const auto in_patient = [&](const Vec3& v) { return Vec3f((place.mm_per_m() * place.direction(v)).cast<float>()); };
  BoardPlace b;
  b.centre_mm = place.to_patient(centre).cast<float>();
  b.right_mm = in_patient(0.5 * kWidth_m * right);
  b.up_mm = in_patient(0.5 * kWidth_m / width_over_height * above);
  return b;
}

}  // namespace limberg
