#include "sim/contact/moving_cells.h"

#include <algorithm>
#include <cmath>

namespace limberg {
namespace {

constexpr float kBoxRound_mm = 1e-3f;  // boxes are larger by this than single precision can miss
constexpr float kClose = 1e-5f;        // edges of a cell: an inverse that has come so near is found
constexpr int kChord = 6, kNewton = 12;
constexpr double kFolded = 1e-3;  // of a cell's volume at rest
constexpr size_t kCellGrain = 256;

v4 splat(float x) { return v4{x, x, x, x}; }
v4 abs4(v4 a) { return a < 0 ? -a : a; }
float dot3(v4 a, v4 b) {
  const v4 p = a * b;
  return p[0] + p[1] + p[2];
}
v4 cross(v4 a, v4 b) { return v4{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0}; }

/// A trilinear map as a polynomial of what `at` is beyond the middle of the cell.
struct Map {
  v4 c0, x, y, z, xy, xz, yz, xyz;
  explicit Map(const std::array<v4, 8>& n) {
    const v4 a0 = n[0] + n[1], d0 = n[1] - n[0], a1 = n[2] + n[3], d1 = n[3] - n[2];
    const v4 a2 = n[4] + n[5], d2 = n[5] - n[4], a3 = n[6] + n[7], d3 = n[7] - n[6];
    const v4 e0 = a0 + a1, e1 = a2 + a3, f0 = a1 - a0, f1 = a3 - a2, g0 = d0 + d1, g1 = d2 + d3, h0 = d1 - d0,
             h1 = d3 - d2;
    c0 = 0.125f * (e0 + e1), z = 0.25f * (e1 - e0);
    y = 0.25f * (f0 + f1), yz = 0.5f * (f1 - f0);
    x = 0.25f * (g0 + g1), xz = 0.5f * (g1 - g0);
    xy = 0.5f * (h0 + h1), xyz = h1 - h0;
  }
  v4 at(v4 b) const {
    const v4 bx = splat(b[0]), by = splat(b[1]), bz = splat(b[2]);
    return c0 + bx * (x + by * (xy + bz * xyz) + bz * xz) + by * (y + bz * yz) + bz * z;
  }
  /// Bounds how far from the middle anything within b edges of it is, along each axis.
  v4 most(float b) const {
    return b * (abs4(x) + abs4(y) + abs4(z) + b * (abs4(xy) + abs4(xz) + abs4(yz) + b * abs4(xyz)));
  }
  std::array<v4, 3> slope(v4 b) const {
    const v4 bx = splat(b[0]), by = splat(b[1]), bz = splat(b[2]);
    return {x + by * xy + bz * (xz + by * xyz), y + bx * xy + bz * (yz + bx * xyz), z + bx * xz + by * (yz + bx * xyz)};
  }
};

/// Columns of the inverse of the matrix with columns J; false when it is folded.
bool invert3(const std::array<v4, 3>& J, float least, v4* along) {
  const v4 r0 = cross(J[1], J[2]), r1 = cross(J[2], J[0]), r2 = cross(J[0], J[1]);
  const float det = dot3(J[0], r0);
  if (!(det > least)) return false;
  const float f = 1 / det;
  for (int a = 0; a < 3; ++a) along[a] = v4{f * r0[a], f * r1[a], f * r2[a], 0};
  return true;
}

}  // namespace

MovingCells::MovingCells(const RestTissue& tissue, const FemModel& model) : tissue_(tissue) {
  for (int32_t n : tissue.nodes()) {
    const Vec3f X = model.X_mm[size_t(n)].cast<float>();
    rest_.push_back(v4{X[0], X[1], X[2], 0});
  }
  now_ = rest_;
  box_.resize(tissue.size()), reach_.resize(tissue.size());
  inverse_.resize(tissue.size());
  std::vector<int32_t> members;
  for (size_t c = 0; c < tissue.size(); ++c)
    if (!tissue.is_empty(c)) members.push_back(int32_t(c));
  tree_ = MovingBoxes(std::move(members));
}

void MovingCells::move(std::span<const Vec3f> u) {
  for (size_t i = 0; i < now_.size(); ++i) {
    const Vec3f& d = u[size_t(tissue_.nodes()[i])];
    now_[i] = rest_[i] + v4{d[0], d[1], d[2], 0};
  }
}

void MovingCells::refit(Workers& workers) {
  workers.parallel_for(box_.size(), kCellGrain, [&](size_t first, size_t last) {
    for (size_t c = first; c < last; ++c) {
      std::array<v4, 8> n;
      for (size_t k = 0; k < 8; ++k) n[k] = now_[size_t(tissue_.slots(c)[k])];
      v4 lo = n[0], hi = n[0];
      for (size_t k = 1; k < 8; ++k) lo = n[k] < lo ? n[k] : lo, hi = n[k] > hi ? n[k] : hi;
      box_[c] = {lo - kBoxRound_mm, hi + kBoxRound_mm};
      const Map map(n);
      const v4 r = map.most(0.5f + float(RestTissue::kBeyond)) + kBoxRound_mm;
      lo = box_[c].lo - kAhead_mm, hi = box_[c].hi + kAhead_mm;
      lo = map.c0 - r > lo ? map.c0 - r : lo, hi = map.c0 + r < hi ? map.c0 + r : hi;
      reach_[c] = {box_[c].lo < lo ? box_[c].lo : lo, box_[c].hi > hi ? box_[c].hi : hi};
      Inverse& inv = inverse_[c];
      inv.middle = map.c0;
      inv.sound = invert3({map.x, map.y, map.z}, float(kFolded * tissue_.size_mm(c).prod()), inv.along);
    }
  });
  tree_.refit(reach_);
}

bool MovingCells::invert(size_t c, const Vec3f& p, float beyond, Vec3& at) const {
  const Inverse& inv = inverse_[c];
  if (!inv.sound) return false;
  const v4 q = {p[0], p[1], p[2], 0};
  const auto apply = [](const v4* along, v4 r) {
    return splat(r[0]) * along[0] + splat(r[1]) * along[1] + splat(r[2]) * along[2];
  };
  const auto within = [](v4 b, float reach) {
    return std::fabs(b[0]) <= reach && std::fabs(b[1]) <= reach && std::fabs(b[2]) <= reach;
  };
  v4 b = apply(inv.along, q - inv.middle);
  if (!within(b, 1.2f + beyond)) return false;
  std::array<v4, 8> n;
  for (size_t k = 0; k < 8; ++k) n[k] = now_[size_t(tissue_.slots(c)[k])] - q;  // small numbers: less is rounded away
  const Map map(n);
  v4 along[3] = {inv.along[0], inv.along[1], inv.along[2]};
  for (int i = 0; i < kChord + kNewton; ++i) {
    if (i >= kChord && !invert3(map.slope(b), float(kFolded * tissue_.size_mm(c).prod()), along)) return false;
    const v4 d = apply(along, -map.at(b));
    b += d;
    if (within(d, kClose)) {
      if (!within(b, 0.5f + beyond)) return false;
      at = Vec3(double(b[0]), double(b[1]), double(b[2])) + Vec3::Constant(0.5);
      return true;
    }
    if (!within(b, 2.5f)) return false;
  }
  return false;
}

Vec3 MovingCells::carried_normal(size_t c, const Vec3& at, const Vec3& N) const {
  std::array<v4, 8> n;
  for (size_t k = 0; k < 8; ++k) n[k] = now_[size_t(tissue_.slots(c)[k])];
  const std::array<v4, 3> J = Map(n).slope(v4{float(at[0]) - 0.5f, float(at[1]) - 0.5f, float(at[2]) - 0.5f, 0});
  // The cofactor of F = J / size: columns over the other two edges.
  const Vec3& s = tissue_.size_mm(c);
  const v4 sum = splat(float(N[0] * s[0])) * cross(J[1], J[2]) + splat(float(N[1] * s[1])) * cross(J[2], J[0]) +
                 splat(float(N[2] * s[2])) * cross(J[0], J[1]);
  const Vec3 v{double(sum[0]), double(sum[1]), double(sum[2])};
  const double l = v.norm();
  return l > 1e-9 ? Vec3(v / l) : Vec3(0, 0, 0);
}

}  // namespace limberg
