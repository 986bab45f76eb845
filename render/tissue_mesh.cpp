#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <span>

#include "render/render_scene.h"
#include "sim/body/tension_lines.h"
#include "sim/geometry/polyline.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

// Two faces at a vertex are shaded smoothly together when their rest normals differ by less than this.
constexpr float kCreaseCos = 0.77f;  // 40 degrees

Part part_of(const SurfaceTopology& topology, size_t t) {
  switch (topology.organ_of(t)) {
    case Organ::face:
      return Part::face;
    case Organ::bone:
      return Part::bone;
    case Organ::bone_cut:
      return Part::bone_cut;
    default:
      break;
  }
  switch (topology.view.kind[t]) {
    case FaceKind::skin:
      return Part::skin;
    case FaceKind::wall:
      return Part::wall;
    default:
      return Part::side;
  }
}

// One render vertex that a surface vertex has been split into.
struct Split {
  Part part;
  bool has_normal;
  Vec3f normal;
  Eigen::Vector2f uv;
  uint32_t index;
};

// Where a rest position lies on a curve that fills the body's box: triangles in this order have most corners from their
// predecessors, which a driver then need not work out again.
uint64_t along_curve(const Vec3& X, const Vec3& low, double per_mm) {
  uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    uint64_t k = uint64_t(std::clamp((X[axis] - low[axis]) * per_mm, 0.0, 1023.0));  // ten bits, spread to every third
    k = (k | k << 16) & 0x30000ff, k = (k | k << 8) & 0x300f00f, k = (k | k << 4) & 0x30c30c3,
    k = (k | k << 2) & 0x9249249;
    key |= k << axis;
  }
  return key;
}

void sort_along_curve(const SurfaceView& view, std::span<uint32_t> triangles,
                      std::vector<std::pair<uint64_t, uint32_t>>& room) {
  if (triangles.empty()) return;
  Vec3 low = Vec3::Constant(1e30), high = -low;
  const auto middle = [&](uint32_t t) -> Vec3 {
    const Tri& tri = view.tri[t];
    return (view.X_mm[size_t(tri[0])] + view.X_mm[size_t(tri[1])] + view.X_mm[size_t(tri[2])]) / 3;
  };
  for (const uint32_t t : triangles) low = low.cwiseMin(middle(t)), high = high.cwiseMax(middle(t));
  const double per_mm = 1023 / std::max((high - low).maxCoeff(), 1e-9);
  room.clear();
  for (const uint32_t t : triangles) room.emplace_back(along_curve(middle(t), low, per_mm), t);
  std::sort(room.begin(), room.end());
  for (size_t i = 0; i < room.size(); ++i) triangles[i] = room[i].second;
}

// Fills rim_mm of one part. Its vertices are sorted by x, so an edge only looks at those within reach of it.
void measure_rim(const SurfaceView& view, TissueMesh& mesh, Part part, const std::vector<std::array<int32_t, 2>>& rim) {
  std::vector<std::pair<float, uint32_t>> by_x;
  for (size_t v = 0; v < mesh.source.size(); ++v)
    if (mesh.part[v] == part) by_x.emplace_back(mesh.X_mm[v].x(), uint32_t(v));
  std::sort(by_x.begin(), by_x.end());
  for (const auto& [i, j] : rim) {
    const Vec3f a = view.X_mm[size_t(i)].cast<float>(), b = view.X_mm[size_t(j)].cast<float>();
    const float low = std::min(a.x(), b.x()) - kRimReach_mm, high = std::max(a.x(), b.x()) + kRimReach_mm;
    for (auto it = std::lower_bound(by_x.begin(), by_x.end(), std::pair(low, uint32_t(0)));
         it != by_x.end() && it->first <= high; ++it)
      mesh.rim_mm[it->second] = std::min(mesh.rim_mm[it->second], distance_to_segment(mesh.X_mm[it->second], a, b));
  }
}

/// In steps of some degrees: a lamp is not moved for every cut.
Vec3 rounded(const Vec3& direction) {
  constexpr double kStep = 0.2;
  const Vec3 round = (direction.normalized() / kStep).array().round() * kStep;
  return round.normalized();
}

/// The way that skin beside cuts faces at rest. None where it faces every way, as that of a lip that is cut through
/// does.
std::optional<Vec3> wound_normal(const SurfaceView& view) {
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (size_t t = 0; t < view.rim.size(); ++t) {
    if (view.rim[t] == 0 || view.kind[t] != FaceKind::skin) continue;
    const Tri& c = view.tri[t];
    sum += area_vector2(view.X_mm[size_t(c[0])], view.X_mm[size_t(c[1])], view.X_mm[size_t(c[2])]).normalized();
    ++count;
  }
  constexpr double kAgree = 0.7;
  if (!(count > 0 && sum.norm() > kAgree * count)) return std::nullopt;
  return rounded(sum);
}

/// The way that what will be operated on faces, while nothing is cut: of a cheek that is looked at, not the face's own.
Vec3 side_seen(const Body& body, const Vec3& towards_eye) {
  constexpr double kAside = 0.94;  // cosine: more than 20 degrees
  const bool aside = towards_eye.norm() > 0 && towards_eye.normalized().dot(body.chart_normal()) < kAside;
  return aside && !body.is_box ? rounded(towards_eye) : body.chart_normal();
}

Vec3f lamp_over(const Body& body, const Vec3& normal) {
  Vec3 up = body.chart_e2 - body.chart_e2.dot(normal) * normal;
  if (up.norm() < 0.2) up = body.chart_normal() - body.chart_normal().dot(normal) * normal;  // skin that faces up
  up.normalize();
  return (double(kLamp.x()) * up.cross(normal) + double(kLamp.y()) * up + double(kLamp.z()) * normal)
      .cast<float>()
      .normalized();
}

/// TissueMesh::tension_twice of a place on a triangle of the body.
Eigen::Vector2f tension_twice(const Body& body, int32_t triangle, const Vec3& X) {
  const Vec3 along = tension_along(body, triangle, X);
  const Eigen::Vector2d d(along.dot(body.chart_e1), along.dot(body.chart_e2));
  const double n2 = d.squaredNorm();
  if (!(n2 > 1e-4)) return {0, 0};
  return Eigen::Vector2d((d.x() * d.x() - d.y() * d.y()) / n2, 2 * d.x() * d.y() / n2).cast<float>();
}

}  // namespace

TissueMesh make_tissue_mesh(const SurfaceTopology& topology, const Vec3f& towards_eye) {
  const SurfaceView& view = topology.view;
  const SharedArray<float>& depth = topology.layers_mm.get();
  TissueMesh mesh;
  mesh.version = topology.version;
  mesh.hash = topology.hash;
  mesh.vertices_of_view = view.X_mm.size();
  if (topology.body) {
    const Body& body = *topology.body;
    mesh.layers = body.layers;
    mesh.lamp = lamp_over(body, wound_normal(view).value_or(side_seen(body, towards_eye.cast<double>())));
    const Eigen::Vector2d along(body.tension_direction.dot(body.chart_e1), body.tension_direction.dot(body.chart_e2));
    if (along.norm() > 1e-3) mesh.tension_chart = along.normalized().cast<float>();
  }

  const size_t n = view.tri.size();
  if (view.uv.size() == n) mesh.image = topology.image;
  mesh.image_part = topology.image_on == Organ::face ? Part::face : Part::skin;
  std::vector<uint32_t> order;
  order.reserve(n);
  std::vector<std::pair<uint64_t, uint32_t>> room;
  for (const Part wanted : kTissueParts) {
    const size_t before = order.size();
    for (size_t t = 0; t < n; ++t)
      if (part_of(topology, t) == wanted) order.push_back(uint32_t(t));
    sort_along_curve(view, std::span(order).subspan(before), room);
    mesh.triangles_of[size_t(wanted)] = order.size() - before;
    if (wanted == Part::skin) mesh.skin_triangles = order.size();
    if (wanted == Part::wall) mesh.wall_triangles = order.size() - mesh.skin_triangles;
  }

  const bool coloured = topology.rgba.size() == view.X_mm.size();
  const bool lines = topology.body && !topology.body->tension.empty();
  std::vector<std::vector<Split>> splits(view.X_mm.size());
  mesh.tri.reserve(n);
  mesh.tri_source.reserve(n);
  for (const uint32_t t : order) {
    const Tri& tri = view.tri[t];
    const Part part = part_of(topology, t);
    const Vec3 cross = (view.X_mm[size_t(tri[1])] - view.X_mm[size_t(tri[0])])
                           .cross(view.X_mm[size_t(tri[2])] - view.X_mm[size_t(tri[0])]);
    // Slivers say nothing about the direction of the surface: they join whatever is there.
    const bool good = cross.norm() > 1e-4;
    const Vec3f normal = good ? Vec3f(cross.normalized().cast<float>()) : Vec3f(Vec3f::Zero());
    std::array<uint32_t, 3> corner{};
    for (size_t k = 0; k < 3; ++k) {
      const size_t v = size_t(tri[k]);
      const Eigen::Vector2f uv = mesh.image ? view.uv[t][k] : Eigen::Vector2f(0, 0);
      Split* found = nullptr;
      for (Split& s : splits[v])
        if (s.part == part && (!mesh.image || part != mesh.image_part || s.uv == uv) &&
            (!good || !s.has_normal || s.normal.dot(normal) > kCreaseCos)) {
          found = &s;
          break;
        }
      if (!found) {
        splits[v].push_back({part, good, normal, uv, uint32_t(mesh.source.size())});
        found = &splits[v].back();
        const Vec3& X = view.X_mm[v];
        const Vec2 chart = topology.body ? topology.body->to_chart(X) : Vec2(X.head<2>());
        mesh.source.push_back(int32_t(v));
        mesh.X_mm.push_back(X.cast<float>());
        mesh.chart_mm.push_back(chart.cast<float>());
        mesh.depth_mm.push_back(v < depth.size() ? depth[v] : 0.0f);
        mesh.part.push_back(part);
        if (mesh.image) mesh.uv.push_back(uv);
        if (lines)
          mesh.tension_twice.push_back(part == Part::skin ? tension_twice(*topology.body, view.origin[t], X)
                                                          : Eigen::Vector2f(0, 0));
        if (coloured) mesh.rgba.push_back(topology.rgba[v]);
      } else if (!found->has_normal && good) {
        found->has_normal = true, found->normal = normal;
      }
      corner[k] = found->index;
    }
    mesh.tri.push_back(corner);
    mesh.tri_source.push_back(int32_t(t));
  }

  // Rim: directed edges of one part's triangles whose twin belongs to a cut through it.
  const auto rim_between = [&](Part part, Part cut) {
    std::set<std::array<int32_t, 2>> of_cut;
    for (size_t t = 0; t < n; ++t)
      if (part_of(topology, t) == cut)
        for (size_t k = 0; k < 3; ++k) of_cut.insert({view.tri[t][k], view.tri[t][(k + 1) % 3]});
    std::vector<std::array<int32_t, 2>> rim;
    for (size_t t = 0; t < n && !of_cut.empty(); ++t)
      if (part_of(topology, t) == part)
        for (size_t k = 0; k < 3; ++k) {
          const int32_t a = view.tri[t][k], b = view.tri[t][(k + 1) % 3];
          if (of_cut.count({b, a})) rim.push_back({a, b});
        }
    return rim;
  };
  mesh.rim_mm.assign(mesh.source.size(), kRimReach_mm);
  mesh.rim = rim_between(Part::skin, Part::wall);
  measure_rim(view, mesh, Part::skin, mesh.rim);
  measure_rim(view, mesh, Part::bone, rim_between(Part::bone, Part::bone_cut));
  return mesh;
}

void vertex_normals(const std::vector<std::array<uint32_t, 3>>& tri, const std::vector<Vec3f>& x_mm,
                    std::vector<Vec3f>& normal) {
  normal.assign(x_mm.size(), Vec3f::Zero());
  for (const auto& [a, b, c] : tri) {
    const Vec3f n = (x_mm[b] - x_mm[a]).cross(x_mm[c] - x_mm[a]);  // twice the area long
    normal[a] += n, normal[b] += n, normal[c] += n;
  }
  for (Vec3f& n : normal) {
    const float length = n.norm();
    if (length > 0) n /= length;
  }
}

}  // namespace limberg
