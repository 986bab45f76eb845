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
  std::array<int, 3> facing;  // of all its smooth faces together: two edges of a block are not one
  size_t faces;
  auto operator<=>(const Cluster&) const = default;
};

}  // namespace

TissueMesh coarser_away(const TissueMesh& mesh, const Vec3f& low, const Vec3f& high) {
  const size_t n = mesh.source.size();
  // Of each vertex of the view: the vertices here that it has been split into.
  std::vector<std::vector<uint32_t>> splits(mesh.vertices_of_view);
  for (uint32_t v = 0; v < n; ++v) splits[size_t(mesh.source[v])].push_back(v);
  std::vector<Vec3f> normal;
  vertex_normals(mesh.tri, mesh.X_mm, normal);
  std::map<Cluster, std::vector<int32_t>> by_place;
  for (size_t s = 0; s < splits.size(); ++s) {
    if (splits[s].empty()) continue;
    uint32_t parts = 0;
    Vec3f facing = Vec3f::Zero();
    for (const uint32_t v : splits[s]) parts |= 1u << unsigned(mesh.part[v]), facing += normal[v];
    const Vec3f& X = mesh.X_mm[splits[s][0]];
    const float away = (low - X).cwiseMax(X - high).cwiseMax(0.0f).norm();
    if ((parts & ~(1u << unsigned(Part::skin) | 1u << unsigned(Part::side))) != 0 || away < kKept_mm) continue;
    const int level = away < kFar_mm ? 1 : 2;
    const float cube = level == 1 ? kCube_mm : kFarCube_mm;
    const auto at = [&](int k) { return int(std::floor(X[k] / cube)); };
    const auto way = [&](int k) { return int(std::lround(facing[k])); };
    by_place[{level, {at(0), at(1), at(2)}, parts, {way(0), way(1), way(2)}, splits[s].size()}].push_back(int32_t(s));
  }
  std::vector<std::vector<int32_t>> clusters;
  for (auto& [key, members] : by_place)
    if (members.size() > 1) clusters.push_back(std::move(members));

  std::vector<uint32_t> to(n);
  for (uint32_t v = 0; v < n; ++v) to[v] = v;
  std::vector<int32_t> cluster_of(n, -1);
  for (size_t c = 0; c < clusters.size(); ++c) {
    Vec3f middle = Vec3f::Zero();
    for (const int32_t s : clusters[c]) middle += mesh.X_mm[splits[size_t(s)][0]] / float(clusters[c].size());
    const auto off = [&](int32_t s) { return (mesh.X_mm[splits[size_t(s)][0]] - middle).squaredNorm(); };
    const int32_t kept = *std::min_element(clusters[c].begin(), clusters[c].end(),
                                           [&](int32_t i, int32_t j) { return off(i) < off(j); });
    for (const int32_t s : clusters[c])
      for (const uint32_t v : splits[size_t(s)]) {
        cluster_of[v] = int32_t(c);
        // Where the picture on the skin has a seam, on the same side of it.
        const auto apart = [&](uint32_t w) { return mesh.uv.empty() ? 0.0f : (mesh.uv[w] - mesh.uv[v]).norm(); };
        float best = -4;
        for (const uint32_t w : splits[size_t(kept)])
          if (const float like = normal[w].dot(normal[v]) - apart(w); mesh.part[w] == mesh.part[v] && like > best)
            best = like, to[v] = w;
      }
  }
  // What would turn a triangle over comes apart again.
  const auto across = [&](uint32_t a, uint32_t b, uint32_t c) -> Vec3f {
    return (mesh.X_mm[b] - mesh.X_mm[a]).cross(mesh.X_mm[c] - mesh.X_mm[a]);
  };
  for (bool turned = true; turned;) {
    turned = false;
    for (const auto& [a, b, c] : mesh.tri) {
      if (to[a] == to[b] || to[b] == to[c] || to[c] == to[a]) continue;
      if (across(to[a], to[b], to[c]).dot(across(a, b, c)) >= 0) continue;
      for (const uint32_t v : {a, b, c})
        if (cluster_of[v] >= 0 && to[v] != v) {
          for (const int32_t s : clusters[size_t(cluster_of[v])])
            for (const uint32_t w : splits[size_t(s)]) to[w] = w;
          turned = true;
        }
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
