#include "sim/skull/face/face_feet.h"

#include <algorithm>

namespace limberg::simplex {

Vec3 place_of(const BoneAnchor& a, const Mesh& m) {
  const Vec3 &A = m.x_mm[size_t(a.skull[0])], &B = m.x_mm[size_t(a.skull[1])], &C = m.x_mm[size_t(a.skull[2])];
  Vec3 x = a.weight[0] * A + a.weight[1] * B + a.weight[2] * C;
  const Vec3 N = (B - A).cross(C - A);
  if (const double l = N.norm(); l > 0) x += a.height_mm / l * N;
  return x;
}

Foot make_foot(const BoneAnchor& a, const Mesh& bones, const Mesh& rest) {
  Foot f;
  f.at = a, f.rest_mm = place_of(a, rest), f.now_mm = place_of(a, bones);
  f.turn = axes_of(a, bones) * axes_of(a, rest).transpose();
  return f;
}

Carry carry(Foot& f, const Mesh& bones) {
  Carry out;
  const Vec3 x = place_of(f.at, bones);
  const Mat3 turn = axes_of(f.at, bones) * f.at.axes.transpose();
  out.far_mm = (x - f.now_mm).norm();
  if (out.far_mm > 0 || turn != f.now_turn) out.Q = turn * f.now_turn.transpose(), out.c = x - out.Q * f.now_mm;
  f.now_mm = x, f.now_turn = turn;
  return out;
}

Standing::Standing(const Mesh& m, std::span<const int32_t> region) : bones_(m), fan_(fan_triangles(m)) {
  std::vector<uint8_t> in(m.face_edge.size(), region.empty());
  for (int32_t v : region)
    if (m.alive(v))
      for (int32_t f : m.left[size_t(v)]) in[size_t(f)] = 1;
  build(in);
}

Standing::Standing(const Mesh& m, const Vec3& lo, const Vec3& hi) : bones_(m), fan_(fan_triangles(m)) {
  std::vector<uint8_t> in(m.face_edge.size(), 0);
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f)) continue;
    Vec3 a = Vec3::Constant(1e300), b = -a;  // its own box
    m.around(f, [&](int32_t h) {
      const Vec3& x = m.x_mm[size_t(m.from(h))];
      a = a.cwiseMin(x), b = b.cwiseMax(x);
    });
    in[size_t(f)] = (b.array() >= lo.array()).all() && (a.array() <= hi.array()).all();
  }
  build(in);
}

void Standing::build(const std::vector<uint8_t>& in) {
  std::vector<int32_t> subset;
  for (size_t t = 0; t < fan_.face.size(); ++t)
    if (in[size_t(fan_.face[t])] && bones_.kind(fan_.face[t]) == FaceKind::surface) subset.push_back(int32_t(t));
  if (!subset.empty()) bvh_ = Bvh(fan_.X_mm, fan_.tri, subset);
}

double Standing::stand(const Vec3& p, BoneAnchor& a) const {
  if (bvh_.empty()) return -1;
  const Bvh::Closest c = bvh_.closest(p);
  const Tri& t = fan_.tri[size_t(c.triangle)];
  const std::vector<int32_t> ring = bones_.ring(fan_.face[size_t(c.triangle)]);
  const size_t at = size_t(std::find(ring.begin(), ring.end(), t[1]) - ring.begin());
  a.skull[0] = t[1], a.skull[1] = t[2], a.skull[2] = ring[(at + 1 + ring.size() / 2) % ring.size()];
  const LocalFrame f =
      local_frame(p, bones_.x_mm[size_t(a.skull[0])], bones_.x_mm[size_t(a.skull[1])], bones_.x_mm[size_t(a.skull[2])]);
  for (size_t k = 0; k < 3; ++k) a.weight[k] = f.e[k];
  a.height_mm = f.L_mm;
  a.axes = axes_of(a, bones_);
  return c.distance_mm;
}

bool moved_as_one(const std::vector<Vec3>& was, const Mesh& now, Eigen::Isometry3d& map) {
  constexpr double kSame_mm = 1e-9;
  if (was.size() != now.x_mm.size()) return false;
  int32_t a = -1, b = -1, c = -1;
  bool moved = false;
  for (int32_t v = 0; v < now.slots(); ++v) {
    if (!now.alive(v)) continue;
    if (a < 0) a = v;
    moved |= now.x_mm[size_t(v)] != was[size_t(v)];
  }
  if (!moved) return false;
  const auto at = [&](int32_t v) -> const Vec3& { return was[size_t(v)]; };
  double far = 0;
  for (int32_t v = 0; v < now.slots(); ++v)
    if (now.alive(v))
      if (const double d = (at(v) - at(a)).squaredNorm(); d > far) far = d, b = v;
  if (b < 0) return false;
  far = 0;
  for (int32_t v = 0; v < now.slots(); ++v)
    if (now.alive(v))
      if (const double d = (at(v) - at(a)).cross(at(b) - at(a)).squaredNorm(); d > far) far = d, c = v;
  if (c < 0) return false;
  const auto axes = [&](const std::vector<Vec3>& x) {
    Mat3 Q;
    Q.col(0) = (x[size_t(b)] - x[size_t(a)]).normalized();
    Q.col(2) = Q.col(0).cross(x[size_t(c)] - x[size_t(a)]).normalized(), Q.col(1) = Q.col(2).cross(Q.col(0));
    return Q;
  };
  map.setIdentity();
  map.linear() = axes(now.x_mm) * axes(was).transpose();
  map.translation() = now.x_mm[size_t(a)] - map.linear() * at(a);
  for (int32_t v = 0; v < now.slots(); ++v)
    if (now.alive(v) && (map * at(v) - now.x_mm[size_t(v)]).norm() > kSame_mm) return false;
  return true;
}

}  // namespace limberg::simplex
