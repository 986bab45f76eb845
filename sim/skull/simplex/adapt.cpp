#include "sim/skull/simplex/adapt.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/skull/simplex/operators.h"

namespace limberg::simplex {
namespace {

struct Measure {
  double area = 0, wanted = 0, elongation = 1;
};

class Adapter {
 public:
  Adapter(Mesh& m, const AdaptSettings& s, Delta& d)
      : m_(m), s_(s), d_(d), least_(s.min_edge_mm > 0 ? s.min_edge_mm : s.edge_mm / 8) {}

  bool pass(int number, AdaptReport& r) {
    const int64_t before = r.splits + r.merges + r.exchanges;
    int64_t room = std::max<int64_t>(8, int64_t(s_.most_per_pass * m_.faces()));
    for (int32_t f : order(m_.face_slots(), uint64_t(2 * number))) {
      if (room <= 0 || m_.vertices() + 2 > s_.max_vertices) break;
      if (!m_.alive_face(f) || is_end(m_.kind(f))) continue;
      const Measure a = measure(f);
      const bool large = a.area > std::sqrt(2.) * a.wanted, many = m_.face_size[size_t(f)] > kMostVertices,
                 thin = a.elongation > 2 && a.area > a.wanted;
      if ((large || many || thin) && t2_across(m_, f, d_)) ++r.splits, --room;
    }
    for (int32_t v : order(m_.slots(), uint64_t(2 * number + 1)))
      for (size_t k = 0; k < 3 && m_.alive(v); ++k) {
        const int32_t u = m_.nbr[size_t(v)][k];
        if (u < v) continue;
        const int32_t A = m_.left[size_t(v)][k], B = m_.face(m_.edge(u, v));
        const int32_t C = m_.left[size_t(v)][(k + 1) % 3], D = m_.left[size_t(u)][size_t(m_.slot(u, v) + 1) % 3];
        if (is_end(m_.kind(A)) || is_end(m_.kind(B))) continue;
        const int32_t a = size(A), b = size(B), c = size(C), d = size(D);
        if (room > 0 && a + b - 4 <= kMostVertices && (c > kFewest || is_end(m_.kind(C))) &&
            (d > kFewest || is_end(m_.kind(D)))) {
          const Measure x = measure(A), y = measure(B);
          if (x.area * y.area <= 0.25 * x.wanted * y.wanted && t1(m_, v, u, d_)) {
            ++r.merges, --room;
            break;
          }
        }
        const auto bad = [](int32_t n) { return (n - 6) * (n - 6); };
        if (a > kFewest && b > kFewest &&
            bad(a - 1) + bad(b - 1) + bad(c + 1) + bad(d + 1) < bad(a) + bad(b) + bad(c) + bad(d) &&
            exchange(m_, v, u, Turn::clockwise, d_))
          ++r.exchanges;
      }
    return r.splits + r.merges + r.exchanges > before;
  }

 private:
  static constexpr int32_t kFewest = 4, kMostVertices = 9;
  int32_t size(int32_t f) const { return m_.face_size[size_t(f)]; }

  std::vector<int32_t> order(int32_t n, uint64_t salt) const {  // shuffled: no direction is favoured
    std::vector<int32_t> o(static_cast<size_t>(n));
    for (int32_t i = 0; i < n; ++i) o[size_t(i)] = i;
    uint64_t s = s_.seed * 0x9e3779b97f4a7c15ull + salt;
    for (int32_t i = n; i-- > 1;) {
      s = s * 6364136223846793005ull + 1442695040888963407ull;
      std::swap(o[size_t(i)], o[size_t((s >> 33) % uint64_t(i + 1))]);
    }
    return o;
  }

  Measure measure(int32_t f) const {
    Measure out;
    Vec3 c = Vec3::Zero(), area = Vec3::Zero();
    const double n = m_.face_size[size_t(f)];
    m_.around(f, [&](int32_t h) { c += m_.x_mm[size_t(h / 3)] / n; });
    Mat3 S = Mat3::Zero();
    double H = 0;
    m_.around(f, [&](int32_t h) {
      const Vec3 a = m_.x_mm[size_t(h / 3)] - c, b = m_.x_mm[size_t(m_.to(h))] - c;
      out.area += 0.5 * a.cross(b).norm(), area += a.cross(b);
      S += a * a.transpose();
      if (s_.chord_mm > 0) H += std::abs(m_.frame(h / 3).mean_curvature_per_mm()) / n;
    });
    // Principal axes in the plane of the face: the two eigenvalues of S there.
    if (const double l = area.norm(); l > 0) {
      const Vec3 N = area / l;
      const Mat3 T = Mat3::Identity() - N * N.transpose(), Q = T * S * T;
      const double tr = Q.trace(), det = std::max(0., 0.5 * (tr * tr - (Q * Q).trace()));
      const double root = std::sqrt(std::max(0., tr * tr / 4 - det)), small = tr / 2 - root;
      out.elongation = small > 0 ? std::sqrt((tr / 2 + root) / small) : 1e9;
    }
    double h = s_.edge_at ? std::min(s_.edge_at(c), s_.edge_mm) : s_.edge_mm;
    if (s_.chord_mm > 0 && H > 0) h = std::clamp(std::sqrt(8 * s_.chord_mm / H), std::min(least_, h), h);
    out.wanted = 1.5 * std::sqrt(3.) * h * h;
    return out;
  }

  Mesh& m_;
  const AdaptSettings& s_;
  Delta& d_;
  double least_;
};

}  // namespace

AdaptReport adapt(Mesh& m, const AdaptSettings& s, Delta& delta) {
  if (!std::isfinite(s.edge_mm) || s.edge_mm <= 0)
    throw InputError("", 0, "the wanted edge must be a finite number above 0 mm");
  if (!std::isfinite(s.chord_mm) || s.chord_mm < 0 || !std::isfinite(s.min_edge_mm) || s.min_edge_mm < 0)
    throw InputError("", 0, "the chord error and the smallest edge must be finite numbers, 0 mm or more");
  AdaptReport r;
  Adapter a(m, s, delta);
  while (r.passes < s.passes && !r.settled) r.settled = !a.pass(r.passes++, r);
  return r;
}

FaceQuality face_quality(const Mesh& m) {
  FaceQuality q;
  std::vector<double> area;
  q.smallest = INT32_MAX;
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f) || is_end(m.kind(f))) continue;
    const int32_t n = m.face_size[size_t(f)];
    q.smallest = std::min(q.smallest, n), q.largest = std::max(q.largest, n);
    q.mean_deviation += std::abs(6 - n);
    Vec3 c = Vec3::Zero();
    m.around(f, [&](int32_t h) { c += m.x_mm[size_t(h / 3)] / n; });
    double a = 0;
    m.around(f, [&](int32_t h) { a += 0.5 * (m.x_mm[size_t(h / 3)] - c).cross(m.x_mm[size_t(m.to(h))] - c).norm(); });
    area.push_back(a);
  }
  if (area.empty()) return FaceQuality{};
  const double n = double(area.size());
  double mean = 0, var = 0;
  for (double a : area) mean += a / n;
  for (double a : area) var += (a - mean) * (a - mean) / n;
  q.mean_deviation /= n;
  q.area_cv = mean > 0 ? std::sqrt(var) / mean : 0;
  return q;
}

}  // namespace limberg::simplex
