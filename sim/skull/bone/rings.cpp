#include "sim/skull/bone/rings.h"

#include <algorithm>
#include <cmath>

#include "sim/skull/simplex/dual.h"

namespace limberg::bone {

using simplex::FaceKind;

namespace {

/// From how far each corner lies off the line between its neighbours, across the ring. Of
/// independent errors of standard deviation s in all corners that distance has s sqrt(1 + w^2
/// + (1 - w)^2) in each of two directions, w and 1 - w the neighbours' shares; its median is
/// 1.18 times that (Rayleigh). The median does not see the few true kinks of a ring.
double jumps(const std::vector<Vec3>& x) {
  std::vector<double> off;
  const size_t n = x.size();
  for (size_t i = 0; i < n; ++i) {
    const Vec3 &a = x[(i + n - 1) % n], &b = x[(i + 1) % n], e = b - a;
    const double l = e.squaredNorm();
    if (!(l > 1e-12)) continue;
    const double w = e.dot(x[i] - a) / l;
    if (w <= 0 || w >= 1) continue;
    off.push_back((x[i] - a - w * e).norm() / std::sqrt(1 + w * w + (1 - w) * (1 - w)));
  }
  if (off.empty()) return 0;
  std::nth_element(off.begin(), off.begin() + std::ptrdiff_t(off.size() / 2), off.end());
  return off[off.size() / 2] / 1.18;
}

}  // namespace

std::vector<Ring> cut_rings(const simplex::Mesh& m) {
  constexpr double kStep_mm = 1.5, kShortest_mm = 10;
  constexpr int kReach = 2;  // steps to either side
  std::vector<Ring> out;
  std::vector<uint8_t> done(3 * m.nbr.size(), 0);
  const auto border = [&](int32_t h) {
    return m.kind(m.face(h)) == FaceKind::surface && m.kind(m.face(m.twin(h))) == FaceKind::wall;
  };
  for (int32_t h0 = 0; h0 < int32_t(done.size()); ++h0) {
    if (done[size_t(h0)] || !m.alive(h0 / 3) || !border(h0)) continue;
    Ring r;
    std::vector<Vec3> beside;  // normal of the face left of each edge
    for (int32_t h = h0; !done[size_t(h)];) {
      done[size_t(h)] = 1;
      r.corner_mm.push_back(m.x_mm[size_t(h / 3)]);
      beside.push_back(simplex::face_area(m, m.face(h)).vector_mm2.normalized());
      const int32_t v = m.to(h);
      for (int32_t k = 0; k < 3; ++k)
        if (border(3 * v + k)) {  // one at most: three faces meet here
          h = 3 * v + k;
          break;
        }
    }
    const size_t n = r.corner_mm.size();
    std::vector<double> at{0};
    for (size_t i = 0; i < n; ++i) at.push_back(at.back() + (r.corner_mm[(i + 1) % n] - r.corner_mm[i]).norm());
    if (at.back() < kShortest_mm) continue;
    r.noise_mm = jumps(r.corner_mm);
    const size_t k = size_t(std::lround(at.back() / kStep_mm));
    r.step_mm = at.back() / double(k);
    std::vector<Vec3> normal(k);
    size_t e = 0;
    for (size_t i = 0; i < k; ++i) {
      const double s = r.step_mm * double(i);
      while (e + 1 < n && at[e + 1] <= s) ++e;
      const double w = (s - at[e]) / std::max(at[e + 1] - at[e], 1e-12);
      r.x_mm.push_back((1 - w) * r.corner_mm[e] + w * r.corner_mm[(e + 1) % n]);
      normal[i] = beside[e];
    }
    const auto near = [&](size_t i, int j) { return (i + k + size_t(j + int(k))) % k; };
    for (size_t i = 0; i < k; ++i) {
      const Vec3 t = r.x_mm[near(i, kReach)] - r.x_mm[near(i, -kReach)];
      r.tangent.push_back(t.norm() > 0 ? Vec3(t.normalized()) : Vec3::UnitX());
      Vec3 sum = Vec3::Zero();
      for (int j = -kReach; j <= kReach; ++j) sum += normal[near(i, j)];
      sum -= sum.dot(r.tangent[i]) * r.tangent[i];
      r.normal.push_back(sum.norm() > 1e-6 ? Vec3(sum.normalized()) : Vec3(r.tangent[i].unitOrthogonal()));
    }
    out.push_back(std::move(r));
  }
  return out;
}

}  // namespace limberg::bone
