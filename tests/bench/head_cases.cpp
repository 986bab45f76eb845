#include "tests/bench/head_cases.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "sim/geometry/bvh.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/simplex/dual.h"

namespace limberg::bench {

using namespace simplex;

int32_t nearest_vertex(const Mesh& m, const Vec3& at) {
  int32_t best = -1;
  double near = std::numeric_limits<double>::infinity();
  for (int32_t v = 0; v < m.slots(); ++v)
    if (const double d = (m.x_mm[size_t(v)] - at).squaredNorm(); m.alive(v) && d < near) near = d, best = v;
  return best;
}

Vec3 landmark_of(const HeadModel& head, const std::string& name) {
  for (const auto& [n, x] : head.landmarks)
    if (n == name) return x;
  return Vec3::Zero();
}

std::vector<Vec3> drawn_in_front(const Mesh& bone, double z, double wide, double high) {
  constexpr int kPlaces = 56;
  constexpr double kFront_mm = 160;
  const FanTriangles fan = fan_triangles(bone);
  const Bvh bvh(fan.X_mm, fan.tri);
  std::vector<Vec3> out;
  for (int i = 0; i < kPlaces; ++i) {
    const double a = 2 * std::numbers::pi * i / kPlaces;
    const Vec3 from(wide * std::cos(a), kFront_mm, z + high * std::sin(a));
    Bvh::LineHit hit;
    if (bvh.line(from, -Vec3::UnitY(), 0, 2 * kFront_mm, std::span(&hit, 1)) > 0)
      out.push_back(from - hit.t * Vec3::UnitY());
  }
  return out;
}

namespace {

/// The bones after a cut, and which vertices the smaller piece has.
struct Freed {
  Mesh bones;
  std::vector<uint8_t> piece;
  Vec3 centre = Vec3::Zero();
  std::string refused;
};
Freed free_piece(const HeadModel& head, const bone::Osteotomy& cut, Workers& w) {
  bone::Bones bones({{"cranium", head.cranium, true}, {"mandible", head.mandible, false}}, w);
  Freed out;
  bone::Osteotomy o = cut;
  o.fragment = bones.nearest_fragment(cut.kind == bone::Osteotomy::Kind::plane ? cut.point_mm : cut.path_mm[0]);
  if (const Outcome done = bones.cut(o); !done.done) {
    out.refused = done.reason;
    return out;
  }
  out.bones = bones.mesh();
  out.piece.assign(out.bones.nbr.size(), 0);
  const bone::Fragment& f = bones.fragments().back();
  out.centre = f.centre_mm;
  for (int32_t v = 0; v < out.bones.slots(); ++v) out.piece[size_t(v)] = bones.fragment_of(v) == f.id;
  return out;
}

Mesh carried(const Mesh& bones, const std::vector<uint8_t>& piece, const Eigen::Isometry3d& by) {
  Mesh m = bones;
  for (size_t v = 0; v < m.x_mm.size(); ++v)
    if (piece[v]) m.x_mm[v] = by * m.x_mm[v];
  return m;
}

Eigen::Isometry3d motion(const Vec3& about, const Vec3& axis, double degrees, const Vec3& shift) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(shift + about).rotate(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis)).translate(-about);
  return T;
}

}  // namespace

std::vector<HeadCase> head_cases(const HeadModel& head, std::vector<std::string>& notes, Workers& w) {
  std::vector<HeadCase> out;
  Mesh bones = head.cranium;
  const int32_t first = append(bones, head.mandible);
  std::vector<uint8_t> mandible(bones.nbr.size(), 0);
  std::fill(mandible.begin() + first, mandible.end(), uint8_t(1));
  const auto region = [&](const Vec3& at, double radius) {
    return region_around(head.face, nearest_vertex(head.face, at), radius);
  };
  const auto add = [&](std::string name, const Mesh& rest, const std::vector<uint8_t>& piece,
                       const Eigen::Isometry3d& by, HeadCase::Tie tie, bool fitted = false) {
    HeadCase c;
    c.name = std::move(name), c.fitted = fitted, c.bones = rest, c.moved = carried(rest, piece, by),
    c.measured = tie.face_region;
    c.ties.push_back(std::move(tie));
    out.push_back(std::move(c));
  };
  const HeadCase::Tie front{"front", region(landmark_of(head, "sto"), 80), 3, 10};
  add("mandible 8 mm forwards", bones, mandible, motion(Vec3::Zero(), Vec3::UnitX(), 0, {0, 8, 0}), front, true);
  add("mandible turned 6 degrees", bones, mandible, motion(landmark_of(head, "Co_L"), Vec3::UnitZ(), 6, Vec3::Zero()),
      front);
  bone::Osteotomy cut;
  cut.kind = bone::Osteotomy::Kind::contour, cut.path_mm = drawn_in_front(head.cranium, 62, 33, 19);
  if (const Freed f = free_piece(head, cut, w); f.refused.empty()) {
    const HeadCase::Tie forehead{"forehead", region({0, 100, 58}, 62), 2, 15};
    add("forehead 8 mm forwards", f.bones, f.piece, motion(f.centre, Vec3::UnitX(), 0, {0, 8, 0}), forehead);
    add("forehead tilted 10 degrees, 4 mm forwards", f.bones, f.piece, motion(f.centre, Vec3::UnitX(), -10, {0, 4, 0}),
        forehead);
  } else {
    notes.push_back("The forehead could not be cut out: " + f.refused);
  }
  cut = {};
  cut.kind = bone::Osteotomy::Kind::plane, cut.point_mm = landmark_of(head, "Pog") + Vec3(0, -6, 4),
  cut.normal = Vec3(0, -0.25, 1).normalized(), cut.radius_mm = 45;
  if (const Freed f = free_piece(head, cut, w); f.refused.empty())
    add("chin 6 mm forwards, 2 down", f.bones, f.piece, motion(f.centre, Vec3::UnitX(), 0, {0, 6, -2}),
        {"chin", region(landmark_of(head, "pog'"), 55), 3, 10});
  else
    notes.push_back("The chin could not be cut off: " + f.refused);
  return out;
}

}  // namespace limberg::bench
