#include "sim/imaging/register/average_surface.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr double kSameWay = 0.5;    // cosine of 60 degrees
constexpr double kBesideIt_mm = 1;  // so far beside it is as good as at it
constexpr int kEvenings = 3;        // passes over neighbours

std::vector<Vec3> normals_of(const Surface& s) {
  std::vector<Vec3> n(s.x_mm.size(), Vec3::Zero());
  for (const Tri& t : s.tri) {
    const Vec3 &a = s.x_mm[size_t(t[0])], &b = s.x_mm[size_t(t[1])], &c = s.x_mm[size_t(t[2])];
    const Vec3 area = (b - a).cross(c - a);
    for (const int32_t v : t) n[size_t(v)] += area;
  }
  for (Vec3& v : n)
    if (const double l = v.norm(); l > 0) v /= l;
  return n;
}

/// One place of the mean as a surface has it: how far along the mean's normal.
struct Vote {
  double along_mm = 0;
  bool there = false;
};
Vote vote_of(const SurfaceTarget& surface, const Similarity& map, const Similarity& back, const Vec3& x, const Vec3& n,
             double far_mm) {
  SurfaceTarget::Place p;
  const Vec3 way = back.R * n;
  Vote v;
  if (!surface.closest_facing(back(x), way, far_mm / map.scale, p)) return v;
  const Vec3 to = map(p.point_mm) - x;
  v.along_mm = n.dot(to);
  // What lies beside it rather than above or below is where the faces that look this way end.
  v.there = !p.border && way.dot(p.normal) >= kSameWay &&
            std::abs(v.along_mm) >= kSameWay * std::max(0., to.norm() - kBesideIt_mm);
  return v;
}

/// Distances evened out over the triangles' edges; places without one take that of their neighbours.
void even_out(std::vector<double>& u, std::vector<uint8_t>& known, const std::vector<Tri>& tri, int passes) {
  std::vector<double> sum(u.size());
  std::vector<int32_t> count(u.size());
  for (int pass = 0; pass < passes; ++pass) {
    std::fill(sum.begin(), sum.end(), 0.);
    std::fill(count.begin(), count.end(), 0);
    for (const Tri& t : tri)
      for (size_t k = 0; k < 3; ++k) {
        const auto a = size_t(t[k]), b = size_t(t[(k + 1) % 3]);
        if (known[b]) sum[a] += u[b], ++count[a];
        if (known[a]) sum[b] += u[a], ++count[b];
      }
    for (size_t v = 0; v < u.size(); ++v) {
      if (count[v] == 0) continue;
      const double around = sum[v] / count[v];
      u[v] = known[v] ? 0.5 * (u[v] + around) : around;
      known[v] = 1;
    }
  }
}

/// All as large as their geometric mean: the mean itself is scaled about its middle, and the maps onto it with it.
void even_sizes(Surface& mean, std::vector<AverageSurface::One>& of) {
  double logs = 0;
  for (const AverageSurface::One& o : of) logs += elementary::log(o.map.scale);
  Similarity s;
  s.scale = elementary::exp(-logs / double(of.size()));
  const Vec3 c = limberg::middle_of(mean.x_mm);
  s.t_mm = c - s.scale * c;
  for (Vec3& x : mean.x_mm) x = s(x);
  for (AverageSurface::One& o : of) o.map = s * o.map;
}

/// How far each surface lies from the mean, and how they spread at each vertex.
void measure(AverageSurface& a, const std::vector<std::unique_ptr<SurfaceTarget>>& target, const AverageSettings& s,
             Workers& workers) {
  const size_t n = a.mean.x_mm.size();
  const std::vector<Vec3> normal = normals_of(a.mean);
  std::vector<double> sum(n), sum2(n);
  std::vector<int32_t> votes(n);
  for (size_t k = 0; k < target.size(); ++k) {
    const Similarity back = a.of[k].map.inverse();
    std::vector<double> d(n);
    std::vector<uint8_t> there(n);
    workers.parallel_for(n, 256, [&](size_t b, size_t e) {
      for (size_t v = b; v < e; ++v) {
        const Vote vote = vote_of(*target[k], a.of[k].map, back, a.mean.x_mm[v], normal[v], s.far_mm);
        d[v] = vote.along_mm, there[v] = vote.there;
      }
    });
    std::vector<double> size;
    double squares = 0;
    for (size_t v = 0; v < n; ++v)
      if (there[v]) {
        sum[v] += d[v], sum2[v] += d[v] * d[v], ++votes[v];
        squares += d[v] * d[v], size.push_back(std::abs(d[v]));
      }
    AverageSurface::One& one = a.of[k];
    one.reached = double(size.size()) / double(n);
    if (size.empty()) continue;
    one.rms_mm = std::sqrt(squares / double(size.size()));
    const auto at = size.begin() + ptrdiff_t(size.size() * 95 / 100);
    std::nth_element(size.begin(), at, size.end());
    one.p95_mm = *at;
  }
  a.spread_mm.assign(n, 0);
  size_t half = 0;
  for (size_t v = 0; v < n; ++v) {
    if (2 * size_t(votes[v]) < target.size() || votes[v] == 0) continue;
    ++half;
    const double mean = sum[v] / votes[v];
    a.spread_mm[v] = std::sqrt(std::max(0., sum2[v] / votes[v] - mean * mean));
  }
  a.half = double(half) / double(n);
}

}  // namespace

AverageSurface average_surface(const std::vector<Surface>& surfaces, const AverageSettings& s, Workers& workers) {
  if (!(s.keep > 0 && s.keep <= 1) || !(s.far_mm > 0) || !(s.still_mm > 0) || s.rounds < 1)
    throw InputError("", 0, "an average keeps a share above 0 and at most 1 of the pairs, in one round or more");
  AverageSurface a;
  if (surfaces.size() < 2) return a.reason = "one surface has no mean; expected two or more", a;
  std::vector<std::unique_ptr<SurfaceTarget>> target;
  for (size_t k = 0; k < surfaces.size(); ++k) {
    std::string lacks = surfaces[k].tri.empty() ? "has no triangles" : lacks_shape(surfaces[k]);
    if (!lacks.empty()) return a.reason = "surface " + std::to_string(k + 1) + " " + lacks, a;
    target.push_back(std::make_unique<SurfaceTarget>(surfaces[k], true));
  }
  IcpSettings fit;
  fit.keep = s.keep, fit.with_scale = s.with_scale;
  a.mean = compacted(surfaces.front());
  a.of.resize(surfaces.size());
  const size_t n = a.mean.x_mm.size();
  for (; a.rounds < s.rounds && !a.still; ++a.rounds) {
    const SurfaceTarget now(a.mean);
    for (size_t k = 0; k < surfaces.size(); ++k) {
      if (a.rounds == 0 && k == 0) continue;  // it is the mean
      const IcpResult r = a.rounds == 0 ? icp_from_anywhere(surfaces[k], now, a.mean, fit, workers)
                                        : icp(surfaces[k], now, a.of[k].map, fit, workers);
      if (!r) return a.reason = "surface " + std::to_string(k + 1) + ": " + r.reason, a;
      a.of[k].map = r.map;
    }
    if (s.with_scale) even_sizes(a.mean, a.of);
    const std::vector<Vec3> normal = normals_of(a.mean);
    std::vector<Similarity> back;
    for (const AverageSurface::One& o : a.of) back.push_back(o.map.inverse());
    std::vector<double> along(n);
    std::vector<uint8_t> known(n);
    workers.parallel_for(n, 64, [&](size_t b, size_t e) {
      for (size_t v = b; v < e; ++v) {
        int32_t votes = 0;
        for (size_t k = 0; k < surfaces.size(); ++k) {
          const Vote vote = vote_of(*target[k], a.of[k].map, back[k], a.mean.x_mm[v], normal[v], s.far_mm);
          if (vote.there) along[v] += vote.along_mm, ++votes;
        }
        known[v] = votes > 0 && 2 * size_t(votes) >= surfaces.size();
        along[v] = known[v] ? along[v] / votes : 0;
      }
    });
    even_out(along, known, a.mean.tri, kEvenings);
    double squares = 0;
    for (size_t v = 0; v < n; ++v) a.mean.x_mm[v] += along[v] * normal[v], squares += along[v] * along[v];
    a.still = std::sqrt(squares / double(n)) < s.still_mm;
  }
  measure(a, target, s, workers);
  return a;
}

}  // namespace limberg
