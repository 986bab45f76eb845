#include "app/export/page_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace limberg {

namespace {

constexpr float kKept_mm = 6, kFar_mm = 20, kCube_mm = 2.5f, kFarCube_mm = 5;

/// What is drawn together: a cube of a size, and what its vertices belong to.
struct Cluster {
  int level;
  std::array<int, 3> cube;
  uint32_t parts;
  size_t faces;
  auto operator<=>(const Cluster&) const = default;
};

}  // namespace

TissueMesh coarser_away(const TissueMesh& mesh, const Vec3f& low, const Vec3f& high) {
  const size_t n = mesh.source.size();
  // Of each vertex of the view: the vertices here that it has been split into.
  std::vector<std::vector<uint32_t>> splits(mesh.vertices_of_view);
  for (uint32_t v = 0; v < n; ++v) splits[size_t(mesh.source[v])].push_back(v);
  std::map<Cluster, std::vector<int32_t>> clusters;
  for (size_t s = 0; s < splits.size(); ++s) {
    if (splits[s].empty()) continue;
    uint32_t parts = 0;
    for (const uint32_t v : splits[s]) parts |= 1u << unsigned(mesh.part[v]);
    const Vec3f& X = mesh.X_mm[splits[s][0]];
    const float away = (low - X).cwiseMax(X - high).cwiseMax(0.0f).norm();
    if ((parts & ~(1u << unsigned(Part::skin) | 1u << unsigned(Part::side))) != 0 || away < kKept_mm) continue;
    const int level = away < kFar_mm ? 1 : 2;
    const float cube = level == 1 ? kCube_mm : kFarCube_mm;
    const auto at = [&](int k) { return int(std::floor(X[k] / cube)); };
    clusters[{level, {at(0), at(1), at(2)}, parts, splits[s].size()}].push_back(int32_t(s));
  }
  std::vector<Vec3f> normal;
  vertex_normals(mesh.tri, mesh.X_mm, normal);
  std::vector<uint32_t> to(n);
  for (uint32_t v = 0; v < n; ++v) to[v] = v;
  for (const auto& [key, members] : clusters) {
    if (members.size() < 2) continue;
    Vec3f middle = Vec3f::Zero();
    for (const int32_t s : members) middle += mesh.X_mm[splits[size_t(s)][0]] / float(members.size());
    const auto off = [&](int32_t s) { return (mesh.X_mm[splits[size_t(s)][0]] - middle).squaredNorm(); };
    const int32_t kept =
        *std::min_element(members.begin(), members.end(), [&](int32_t a, int32_t b) { return off(a) < off(b); });
    for (const int32_t s : members)
      for (const uint32_t v : splits[size_t(s)]) {
        float best = -2;
        for (const uint32_t w : splits[size_t(kept)])
          if (mesh.part[w] == mesh.part[v] && normal[w].dot(normal[v]) > best)
            best = normal[w].dot(normal[v]), to[v] = w;
      }
  }

  TissueMesh out = mesh;
  out.tri.clear(), out.tri_source.clear();
  size_t at = 0;
  for (const Part part : kTissueParts) {
    const size_t before = out.tri.size(), end = at + mesh.triangles_of[size_t(part)];
    for (; at < end; ++at) {
      const std::array<uint32_t, 3> t{to[mesh.tri[at][0]], to[mesh.tri[at][1]], to[mesh.tri[at][2]]};
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      out.tri.push_back(t), out.tri_source.push_back(mesh.tri_source[at]);
    }
    out.triangles_of[size_t(part)] = out.tri.size() - before;
  }
  out.skin_triangles = out.triangles_of[size_t(Part::skin)], out.wall_triangles = out.triangles_of[size_t(Part::wall)];
  // Vertices in the order in which triangles come to them.
  constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> place(n, kNone), order;
  for (auto& t : out.tri)
    for (uint32_t& v : t) {
      if (place[v] == kNone) place[v] = uint32_t(order.size()), order.push_back(v);
      v = place[v];
    }
  const auto keep = [&](auto& list) {
    if (list.size() != n) return;
    auto kept = list;
    kept.resize(order.size());
    for (size_t i = 0; i < order.size(); ++i) kept[i] = list[order[i]];
    list = std::move(kept);
  };
  keep(out.source), keep(out.X_mm), keep(out.chart_mm), keep(out.depth_mm), keep(out.rim_mm), keep(out.uv);
  keep(out.rgba), keep(out.part);
  return out;
}

}  // namespace limberg
