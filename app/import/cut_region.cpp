// What cuts enclose: a flood over the skin, on triangles small enough that cuts lie between them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>

#include "app/import/cut_lines.h"
#include "sim/geometry/polyline.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr size_t kMostFlooded = 2'000'000;  // triangles

struct FloodMesh {
  std::vector<Vec3> X;
  std::vector<Tri> tri;
};

/// Edges longer than `most` whose middle lies in the ball are halved, until none is left. What is halved depends on the
/// edge alone, so neighbours agree.
void divide(FloodMesh& m, double most, const Vec3& centre, double radius) {
  for (int pass = 0; pass < 12; ++pass) {
    std::unordered_map<uint64_t, int32_t> middle;
    const auto mid = [&](int32_t a, int32_t b) -> int32_t {
      const Vec3 &p = m.X[size_t(a)], &q = m.X[size_t(b)];
      if ((p - q).norm() <= most || (0.5 * (p + q) - centre).norm() > radius) return -1;
      const uint64_t key = uint64_t(std::min(a, b)) << 32 | uint32_t(std::max(a, b));
      const auto [it, fresh] = middle.insert({key, int32_t(m.X.size())});
      if (fresh) {
        const Vec3 x = 0.5 * (p + q);
        m.X.push_back(x);
      }
      return it->second;
    };
    std::vector<Tri> next;
    next.reserve(2 * m.tri.size());
    for (const Tri& t : m.tri) {
      const int32_t h[3] = {mid(t[0], t[1]), mid(t[1], t[2]), mid(t[2], t[0])};
      const int n = (h[0] >= 0) + (h[1] >= 0) + (h[2] >= 0);
      if (n == 0) {
        next.push_back(t);
      } else if (n == 3) {
        next.push_back({t[0], h[0], h[2]}), next.push_back({h[0], t[1], h[1]});
        next.push_back({h[2], h[1], t[2]}), next.push_back({h[0], h[1], h[2]});
      } else {
        for (int k = 0; k < 3; ++k) {  // turned so that edge k is halved, and the one before it is not
          const size_t a = size_t(k), b = size_t((k + 1) % 3), c = size_t((k + 2) % 3);
          if (h[a] < 0 || h[c] >= 0) continue;
          next.push_back({t[a], h[a], t[c]});
          if (h[b] < 0) {
            next.push_back({h[a], t[b], t[c]});
          } else {
            next.push_back({h[a], t[b], h[b]}), next.push_back({h[a], h[b], t[c]});
          }
          break;
        }
      }
    }
    const bool done = next.size() == m.tri.size() || next.size() > kMostFlooded;
    m.tri = std::move(next);
    if (done) break;
  }
}

}  // namespace

std::optional<CutLines::Region> CutLines::region(const SurfaceSpot& spot) const {
  if (line_.empty()) return std::nullopt;
  FloodMesh m{model_.mesh.X_mm, {}};
  double whole = 0;
  for (size_t t = 0; t < model_.mesh.tri.size(); ++t) {
    if (model_.material[t] != peer_material::skin) continue;
    const Tri& c = model_.mesh.tri[t];
    m.tri.push_back(c);
    whole += 0.5 * area_vector2(m.X[size_t(c[0])], m.X[size_t(c[1])], m.X[size_t(c[2])]).norm();
  }
  double radius = 0;
  for (const Line& l : line_)
    for (const Vec3& p : l.at_mm) radius = std::max(radius, (p - spot.at_mm).norm());
  divide(m, 2 * step_mm_, spot.at_mm, radius + 10 * step_mm_);
  const auto centre = [&](size_t t) {
    const Tri& c = m.tri[t];
    return Vec3((m.X[size_t(c[0])] + m.X[size_t(c[1])] + m.X[size_t(c[2])]) / 3);
  };
  const auto area2 = [&](size_t t) {
    const Tri& c = m.tri[t];
    return area_vector2(m.X[size_t(c[0])], m.X[size_t(c[1])], m.X[size_t(c[2])]);
  };
  // Cuts by cubes of space, so that most triangles ask for none.
  const double cube = 4 * step_mm_;
  const auto key = [&](const Vec3& p) {
    const auto part = [&](double x) { return uint64_t(int64_t(std::floor(x / cube)) + (1 << 20)) & 0x1fffff; };
    return part(p.x()) << 42 | part(p.y()) << 21 | part(p.z());
  };
  std::unordered_map<uint64_t, char> near;
  for (const Line& l : line_)
    for (const Vec3& p : l.at_mm)
      for (int i = -1; i <= 1; ++i)
        for (int k = -1; k <= 1; ++k)
          for (int j = -1; j <= 1; ++j) near[key(p + cube * Vec3(i, k, j))] = 1;

  std::unordered_map<uint64_t, int32_t> edge;  // directed
  const auto edge_key = [](int32_t a, int32_t b) { return uint64_t(uint32_t(a)) << 32 | uint32_t(b); };
  for (size_t t = 0; t < m.tri.size(); ++t)
    for (size_t k = 0; k < 3; ++k) edge[edge_key(m.tri[t][k], m.tri[t][(k + 1) % 3])] = int32_t(t);
  size_t start = m.tri.size();
  double least = 1e300;
  for (size_t t = 0; t < m.tri.size(); ++t) {
    const double d = (centre(t) - spot.at_mm).squaredNorm();
    if (d < least) least = d, start = t;
  }
  if (start == m.tri.size()) return std::nullopt;

  Region region;
  std::vector<char> in(m.tri.size(), 0);
  std::vector<int32_t> open{int32_t(start)};
  in[start] = 1;
  std::map<int32_t, std::vector<int32_t>> border;  // from a vertex to the next ones
  std::vector<std::pair<int32_t, size_t>> rim;
  while (!open.empty()) {
    const size_t t = size_t(open.back());
    open.pop_back();
    const Vec3 n = area2(t);
    region.area_mm2 += 0.5 * n.norm();
    if (region.area_mm2 > 0.5 * whole) return std::nullopt;
    for (size_t k = 0; k < 3; ++k) {
      const auto mate = edge.find(edge_key(m.tri[t][(k + 1) % 3], m.tri[t][k]));
      if (mate == edge.end()) {
        rim.push_back({int32_t(t), k});
        continue;
      }
      const size_t o = size_t(mate->second);
      if (in[o]) continue;
      const Vec3 a = centre(t), b = centre(o);
      if (near.contains(key(a))) {
        const Vec3 up = n.normalized() + area2(o).normalized();
        if (const auto met = crossing(a, b, up.norm() > 1e-6 ? Vec3(up.normalized()) : Vec3(n.normalized()))) {
          region.blade_through = region.blade_through || met->blade_through;
          rim.push_back({int32_t(t), k});
          continue;
        }
      }
      in[o] = 1, open.push_back(int32_t(o));
    }
  }
  for (const auto& [t, k] : rim) {  // not those with the region on both sides, at the end of a cut
    const int32_t a = m.tri[size_t(t)][k], b = m.tri[size_t(t)][(k + 1) % 3];
    const auto mate = edge.find(edge_key(b, a));
    if (mate == edge.end() || !in[size_t(mate->second)]) border[a].push_back(b);
  }
  std::vector<Vec3> longest;
  double most = 0;
  while (!border.empty()) {
    std::vector<Vec3> loop;
    double length = 0;
    int32_t at = border.begin()->first;
    for (auto it = border.find(at); it != border.end(); it = border.find(at)) {
      const int32_t next = it->second.back();
      it->second.pop_back();
      if (it->second.empty()) border.erase(it);
      length += (m.X[size_t(next)] - m.X[size_t(at)]).norm();
      const auto cut = nearest(m.X[size_t(at)], 3 * step_mm_);
      const Vec3 p = cut ? cut->at_mm : m.X[size_t(at)];
      if (loop.empty() || (loop.back() - p).norm() > 0.25 * step_mm_) loop.push_back(p);
      at = next;
    }
    if (length > most) most = length, longest = std::move(loop);
  }
  if (longest.size() < 3) return std::nullopt;
  longest.push_back(longest.front());
  region.outline = simplify(longest, 0.5 * step_mm_);
  if (region.outline.size() > 1) region.outline.pop_back();
  if (region.outline.size() < 3) return std::nullopt;
  return region;
}

}  // namespace limberg
