// Building a tissue: the primal prisms, their tetrahedra, and the dual.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <queue>

#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/polyline.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/tissue_feet.h"

namespace limberg::simplex {
namespace {

using Tet = std::array<int32_t, 4>;

double volume6(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

using Patch = TissuePatch;

std::string make_patch(const Mesh& face, std::span<const int32_t> region, Patch& p) {
  std::map<int32_t, int32_t>
      node;  // face of the mesh -> node; ordered, so that numbers do not depend on the region's order
  std::vector<uint8_t> in(face.nbr.size(), 0);
  for (int32_t v : region) {
    if (!face.alive(v)) return "the region of the face names vertex " + std::to_string(v) + ", which does not exist";
    if (in[size_t(v)]++) return "the region of the face names vertex " + std::to_string(v) + " twice";
    for (int32_t f : face.left[size_t(v)]) {
      if (is_end(face.kind(f))) return "the region of the face reaches a hole or a cut";
      node.try_emplace(f, 0);
    }
  }
  if (region.empty()) return "the region of the face is empty";
  for (auto& [f, n] : node) {
    n = int32_t(p.top.size());
    p.top.push_back(face_centre(face, f));
    p.normal.push_back(face_area(face, f).vector_mm2.normalized());
  }
  p.near.resize(p.top.size());
  std::map<std::array<int32_t, 2>, int> edges;  // directed
  for (int32_t v : region) {
    const Row& l = face.left[size_t(v)];
    p.tri.push_back({node[l[2]], node[l[0]], node[l[1]]});
    for (size_t k = 0; k < 3; ++k) ++edges[{p.tri.back()[k], p.tri.back()[(k + 1) % 3]}];
  }
  std::vector<int> leaves(p.top.size(), 0);
  for (const auto& [e, n] : edges) {
    const bool inner = edges.contains({e[1], e[0]});
    if (!inner) p.border.push_back(e), ++leaves[size_t(e[0])];
    if (!inner || e[0] < e[1]) p.near[size_t(e[0])].push_back(e[1]), p.near[size_t(e[1])].push_back(e[0]);
  }
  if (p.border.empty()) return "the region of the face is the whole surface; a patch was expected";
  if (*std::max_element(leaves.begin(), leaves.end()) > 1)
    return "the region of the face is pinched: two of its borders touch";
  std::vector<int32_t> stack{region[0]};
  size_t reached = 1;
  in[size_t(region[0])] = 2;
  while (!stack.empty()) {
    const int32_t v = stack.back();
    stack.pop_back();
    for (int32_t u : face.nbr[size_t(v)])
      if (in[size_t(u)] == 1) in[size_t(u)] = 2, ++reached, stack.push_back(u);
  }
  if (reached != region.size()) return "the region of the face is in several parts";
  return "";
}

bool upright(const Patch& p, const Tri& t, const std::vector<Vec3>& bottom) {
  const Vec3 &a = bottom[size_t(t[0])], &b = bottom[size_t(t[1])], &c = bottom[size_t(t[2])];
  const Vec3 &x = p.top[size_t(t[0])], &y = p.top[size_t(t[1])], &z = p.top[size_t(t[2])];
  // All tetrahedra that a diagonal may give: each corner of one side over the whole other side.
  bool up = true;
  for (const Vec3* u : {&x, &y, &z}) up &= volume6(a, b, c, *u) > 0;
  for (const Vec3* u : {&a, &b, &c}) up &= volume6(x, z, y, *u) > 0;
  return up;
}

/// Opposite places on the skull, all prisms upright. Where no evening out of places on the bone achieves that (over the
/// mouth, the nose, an orbit's rim), the nodes of what folds stay above the bone, on their ways to it: `hovers`.
std::string drop(const Patch& p, const Bvh& bvh, double farthest, std::vector<Vec3>& bottom,
                 std::vector<uint8_t>& hovers) {
  constexpr int kRounds = 30, kMore = 80;
  constexpr double kShorter = 0.85, kLeast = 0.05;
  const size_t n = p.top.size();
  std::vector<Vec3> d(n);
  for (size_t i = 0; i < n; ++i) {
    if (!way_to_bone(bvh, p.top[i], p.normal[i], farthest, d[i]))
      return "the skull is farther from the face than " + std::to_string(farthest) + " mm";
  }
  hovers.assign(n, 0);
  std::vector<double> share(n, 1);
  const auto even = [&](const std::vector<uint8_t>* only) {
    std::vector<Vec3> next = d;
    for (size_t i = 0; i < n; ++i) {
      if (only && !(*only)[i]) continue;
      Vec3 mean = Vec3::Zero();
      for (int32_t j : p.near[i]) mean += d[size_t(j)] / double(p.near[i].size());
      next[i] = 0.5 * (d[i] + mean);
    }
    d = std::move(next);
  };
  for (int round = 0; round < kRounds + kMore; ++round) {
    bottom.resize(n);
    for (size_t i = 0; i < n; ++i)
      bottom[i] = hovers[i] ? p.top[i] + share[i] * d[i] : bvh.closest(p.top[i] + d[i]).point_mm;
    std::vector<uint8_t> bad(n, 0);
    bool good = true;
    for (const Tri& t : p.tri)
      if (!upright(p, t, bottom)) {
        good = false;
        for (int32_t v : t) bad[size_t(v)] = 1;
      }
    if (good) return "";
    if (round < kRounds) {
      even(nullptr);
      continue;
    }
    for (size_t i = 0; i < n; ++i) {
      if (!bad[i]) continue;
      if (!hovers[i]) d[i] = bottom[i] - p.top[i];
      hovers[i] = 1, share[i] *= kShorter;
      if (share[i] < kLeast)
        return "the two regions do not lie opposite to one another: layers between them would fold";
    }
    even(&bad);
  }
  return "the two regions do not lie opposite to one another: layers between them would fold";
}

/// Nodes in layers from the bone to the face, and three tetrahedra a prism.
std::string stack_layers(const Patch& p, const std::vector<Vec3>& bottom, Tissue& t) {
  const int32_t n = int32_t(p.top.size());
  for (int32_t l = 0; l <= t.layers; ++l)
    for (int32_t i = 0; i < n; ++i) {
      const double w = double(l) / t.layers;
      t.node_mm.push_back((1 - w) * bottom[size_t(i)] + w * p.top[size_t(i)]);
    }
  for (int32_t l = 0; l < t.layers; ++l)
    for (Tri v : p.tri) {
      std::sort(v.begin(), v.end());
      const int32_t a = l * n, b = (l + 1) * n;
      for (const auto& corners : prism_tets({0, 1, 2})) {
        Tet q{};
        for (size_t c = 0; c < 4; ++c)
          q[c] = corners[c] < 3 ? a + v[size_t(corners[c])] : b + v[size_t(corners[c] - 3)];
        const auto at = [&](size_t k) -> const Vec3& { return t.node_mm[size_t(q[k])]; };
        if (volume6(at(0), at(1), at(2), at(3)) < 0) std::swap(q[0], q[1]);
        if (!(volume6(at(0), at(1), at(2), at(3)) > 0))
          return "the two regions do not lie opposite to one another: a layer between them would have no thickness";
        t.tet.push_back(q);
      }
    }
  return "";
}

/// A triangle of a tetrahedron: two tetrahedra share one, or it lies on the boundary.
using Nodes3 = std::array<int32_t, 3>;  // ascending
struct Facet {
  Nodes3 key;
  int32_t tet, k;
};

std::vector<Facet> facets_of(const std::vector<Tet>& tet) {
  std::vector<Facet> facet;
  for (int32_t i = 0; i < int32_t(tet.size()); ++i)
    for (int32_t k = 0; k < 4; ++k) {
      Nodes3 key{};
      for (int32_t j = 0, c = 0; j < 4; ++j)
        if (j != k) key[size_t(c++)] = tet[size_t(i)][size_t(j)];
      std::sort(key.begin(), key.end());
      facet.push_back({key, i, k});
    }
  std::sort(facet.begin(), facet.end(),
            [](const Facet& a, const Facet& b) { return a.key != b.key ? a.key < b.key : a.tet < b.tet; });
  return facet;
}

/// Where the tissue stands on: the triangles of the skull's faces, and which of them it may reach.
struct Ground {
  const Mesh& skull;
  FanTriangles fan;
  Bvh bvh;
};

/// The foot of a boundary vertex, carried by three vertices of the skull. The fan's centre is none of them: the
/// triangle of a face's vertices that is nearest to the foot carries it.
BoneAnchor anchor_at(const Ground& g, int32_t vertex, const Vec3& foot, int32_t triangle) {
  const Mesh& skull = g.skull;
  BoneAnchor a;
  a.vertex = vertex;
  const std::vector<int32_t> ring = skull.ring(g.fan.face[size_t(triangle)]);
  const Tri& ft = g.fan.tri[size_t(triangle)];
  const size_t at = size_t(std::find(ring.begin(), ring.end(), ft[1]) - ring.begin());
  a.skull[0] = ft[1], a.skull[1] = ft[2], a.skull[2] = ring[(at + 1 + ring.size() / 2) % ring.size()];
  const Vec3 &A = skull.x_mm[size_t(a.skull[0])], &B = skull.x_mm[size_t(a.skull[1])],
             &C = skull.x_mm[size_t(a.skull[2])];
  const LocalFrame f = local_frame(foot, A, B, C);
  for (size_t k = 0; k < 3; ++k) a.weight[k] = f.e[k];
  a.height_mm = f.L_mm;
  a.axes = axes_of(a, skull);
  return a;
}

/// The dual of the tetrahedra: a vertex for each of them and for each triangle of the boundary, an edge across each
/// triangle and each edge of the boundary. Edges carry the area that they cross, for their stiffness.
class Dual {
 public:
  Dual(Tissue& tissue, const Mesh& face, std::span<const int32_t> region, const Patch& patch, const Ground& ground,
       const std::vector<uint8_t>& hovers)
      : t_(tissue), face_(face), ground_(ground), hovers_(hovers), n_(int32_t(patch.top.size())) {
    for (size_t i = 0; i < region.size(); ++i) {
      Nodes3 key = patch.tri[i];
      for (int32_t& v : key) v += t_.layers * n_;
      std::sort(key.begin(), key.end());
      top_[key] = region[i];
    }
  }

  std::string build() {
    for (const Tet& q : t_.tet) {
      Vec3 c = Vec3::Zero();
      for (int32_t v : q) c += 0.25 * t_.node_mm[size_t(v)];
      add(c, TissueRole::inside);
    }
    const std::vector<Facet> facet = facets_of(t_.tet);
    for (size_t i = 0; i < facet.size();) {
      const Facet& f = facet[i];
      if (i + 1 == facet.size() || facet[i + 1].key != f.key) {
        add_boundary(f);
        ++i;
        continue;
      }
      if (i + 2 < facet.size() && facet[i + 2].key == f.key) return kFolds;
      join(f.tet, size_t(f.k), facet[i + 1].tet, size_t(facet[i + 1].k), area(f.key));
      i += 2;
    }
    return join_boundary();
  }

 private:
  static constexpr const char* kFolds = "the region of the face folds onto itself";

  double area(const Nodes3& f) const {
    const auto x = [&](size_t k) -> const Vec3& { return t_.node_mm[size_t(f[k])]; };
    return 0.5 * (x(1) - x(0)).cross(x(2) - x(0)).norm();
  }
  void add(const Vec3& x, TissueRole r) {
    t_.nbr.push_back({-1, -1, -1, -1});
    t_.x_mm.push_back(x), t_.role.push_back(r);
    t_.rest_mm.push_back({}), t_.k_mN_per_mm.push_back({1, 1, 1, 1});
  }
  void join(int32_t a, size_t slot_a, int32_t b, size_t slot_b, double A) {
    t_.nbr[size_t(a)][slot_a] = b, t_.nbr[size_t(b)][slot_b] = a;
    t_.k_mN_per_mm[size_t(a)][slot_a] = t_.k_mN_per_mm[size_t(b)][slot_b] = A;
  }
  void add_boundary(const Facet& f) {
    const int32_t b = t_.vertices();
    const bool over = f.key[0] >= t_.layers * n_, under = f.key[2] < n_;
    Vec3 c = Vec3::Zero();
    for (int32_t v : f.key) c += t_.node_mm[size_t(v)] / 3;
    add(c, over ? TissueRole::face : under ? TissueRole::skull : TissueRole::side);
    boundary_.push_back(f.key);
    join(f.tet, size_t(f.k), b, 0, area(f.key));
    if (over) {
      t_.link.push_back({b, top_.at(f.key)});
      t_.x_mm.back() = face_.x_mm[size_t(t_.link.back().second)];
    }
    if (under) {
      const Bvh::Closest q = ground_.bvh.closest(c);
      const bool over_bone = hovers_[size_t(f.key[0])] || hovers_[size_t(f.key[1])] || hovers_[size_t(f.key[2])];
      t_.x_mm.back() = over_bone ? c : q.point_mm;
      t_.anchor.push_back(anchor_at(ground_, b, t_.x_mm.back(), q.triangle));
    }
    for (const auto& [u, v] : {std::pair{0, 1}, {1, 2}, {0, 2}})
      rim_[{f.key[size_t(u)], f.key[size_t(v)]}].push_back(b);  // keys are sorted
  }
  std::string join_boundary() {
    std::vector<size_t> used(t_.nbr.size(), 1);
    const int32_t tets = int32_t(t_.tet.size());
    for (const auto& [e, two] : rim_) {
      if (two.size() != 2) return kFolds;
      // The primal triangle that such an edge crosses has no area of its own: a third of its two facets stands for it.
      const double A = (area(boundary_[size_t(two[0] - tets)]) + area(boundary_[size_t(two[1] - tets)])) / 6;
      join(two[0], used[size_t(two[0])]++, two[1], used[size_t(two[1])]++, A);
    }
    return "";
  }

  Tissue& t_;
  const Mesh& face_;
  const Ground& ground_;
  const std::vector<uint8_t>& hovers_;
  const int32_t n_;                                             // nodes of a layer
  std::map<Nodes3, int32_t> top_;                               // triangle of the face's side -> vertex of the face
  std::map<std::array<int32_t, 2>, std::vector<int32_t>> rim_;  // boundary edge -> boundary vertices
  std::vector<Nodes3> boundary_;                                // nodes of boundary vertex i + tets
};

/// Smooths the dual with its ends held, and takes that as its shape at rest.
void settle(Tissue& t, const Mesh& face, const Mesh& skull, Workers& workers) {
  t.before_mm = t.x_mm;
  record_rest(t);
  follow(t, face, skull);
  TissueLaw smooth;
  smooth.mode = TissueKind::smoothing, smooth.alpha = 1;
  for (int i = 0; i < 400; ++i)
    if (step(t, smooth, workers).max_move_mm < 1e-4) break;
  t.before_mm = t.x_mm;
  record_rest(t);
}

/// From the areas that edges cross to their stiffness. Young's modulus over an edge is the mean of its two ends'; a
/// boundary vertex has that of its tetrahedron.
void stiffen(Tissue& t, const TissueSettings& s) {
  const double skin = s.skin_kPa > 0 ? s.skin_kPa : s.young_kPa;
  const size_t under_skin = t.tet.size() / size_t(s.layers) * size_t(s.layers - 1);
  const int32_t tets = int32_t(t.tet.size());
  const auto young = [&](int32_t v) {
    return size_t(v < tets ? v : t.nbr[size_t(v)][0]) >= under_skin ? skin : s.young_kPa;
  };
  for (size_t v = 0; v < t.nbr.size(); ++v)
    for (size_t k = 0; k < 4; ++k) {
      const double l = t.rest_mm[v][k];
      t.k_mN_per_mm[v][k] =
          s.young_kPa > 0 && l > 0 ? 0.5 * (young(int32_t(v)) + young(t.nbr[v][k])) * t.k_mN_per_mm[v][k] / l : 1;
    }
}

std::string below(const TissueFloor& f) {
  char words[160];
  std::snprintf(words, sizeof words,
                " are thinner than %.2g mm, or so flat or folded that a tetrahedron has a mean ratio below %.2g",
                f.thickness_mm, f.shape);
  return words;
}

}  // namespace

TissueQuality quality_of(const Tissue& t) {
  TissueQuality q;
  if (t.layers < 1 || t.tet.empty()) return q;
  std::vector<double> ratio, length;
  for (const Tet& c : t.tet)
    ratio.push_back(
        mean_ratio(t.node_mm[size_t(c[0])], t.node_mm[size_t(c[1])], t.node_mm[size_t(c[2])], t.node_mm[size_t(c[3])]));
  const size_t n = t.node_mm.size() / size_t(t.layers + 1), top = n * size_t(t.layers);
  for (size_t i = 0; i < n; ++i) length.push_back((t.node_mm[top + i] - t.node_mm[i]).norm());
  std::sort(ratio.begin(), ratio.end()), std::sort(length.begin(), length.end());
  q.least_ratio = ratio.front(), q.low_ratio = ratio[ratio.size() / 100];
  q.thinnest_mm = length.front(), q.median_mm = length[n / 2], q.p95_mm = length[n * 95 / 100],
  q.thickest_mm = length.back();
  q.columns = int(n), q.hovering = t.hovering;
  return q;
}

std::vector<int32_t> region_around(const Mesh& m, int32_t v, double radius) {
  std::vector<int32_t> region;
  if (!m.alive(v)) return region;
  std::vector<double> far(m.nbr.size(), std::numeric_limits<double>::infinity());
  using Item = std::pair<double, int32_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  far[size_t(v)] = 0;
  open.push({0, v});
  while (!open.empty()) {
    const auto [d, u] = open.top();
    open.pop();
    if (d > far[size_t(u)]) continue;
    region.push_back(u);
    for (int32_t t : m.nbr[size_t(u)])
      if (const double w = d + (m.x_mm[size_t(t)] - m.x_mm[size_t(u)]).norm(); w <= radius && w < far[size_t(t)])
        far[size_t(t)] = w, open.push({w, t});
  }
  return region;
}

std::vector<int32_t> region_within(const Mesh& m, std::span<const Vec3> outline) {
  if (outline.size() < 3) return {};
  const Vec3 middle = std::accumulate(outline.begin(), outline.end(), Vec3(Vec3::Zero())) / double(outline.size());
  Vec3 normal = Vec3::Zero();  // twice the area's vector
  for (size_t i = 0; i < outline.size(); ++i)
    normal += (outline[i] - middle).cross(outline[(i + 1) % outline.size()] - middle);
  if (!(normal.norm() > 0)) return {};
  normal.normalize();
  const Vec3 e1 = normal.unitOrthogonal(), e2 = normal.cross(e1);
  const auto flat = [&](const Vec3& x) { return Vec2((x - middle).dot(e1), (x - middle).dot(e2)); };
  std::vector<Vec2> polygon;
  for (const Vec3& x : outline) polygon.push_back(flat(x));
  int32_t first = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v) && inside_polygon(polygon, flat(m.x_mm[size_t(v)])))
      if (const double d = (m.x_mm[size_t(v)] - middle).squaredNorm(); d < least) least = d, first = v;
  std::vector<int32_t> region;
  if (first < 0) return region;
  std::vector<uint8_t> seen(m.nbr.size(), 0);
  region.push_back(first), seen[size_t(first)] = 1;
  for (size_t i = 0; i < region.size(); ++i)
    for (const int32_t t : m.nbr[size_t(region[i])])
      if (t >= 0 && !seen[size_t(t)] && inside_polygon(polygon, flat(m.x_mm[size_t(t)])))
        seen[size_t(t)] = 1, region.push_back(t);
  return region;
}

std::vector<int32_t> patch_of(const Mesh& m, std::vector<int32_t> region) {
  std::vector<uint8_t> in(m.nbr.size(), 0);
  for (const int32_t v : region)
    in[size_t(v)] = m.alive(v) && std::none_of(m.left[size_t(v)].begin(), m.left[size_t(v)].end(),
                                               [&](int32_t f) { return is_end(m.kind(f)); });
  // Where a face is entered and left more than once, two borders touch at its middle.
  for (bool pinched = true; pinched;) {
    pinched = false;
    for (const int32_t v : region)
      for (const int32_t f : m.left[size_t(v)]) {
        if (!in[size_t(v)]) break;
        const std::vector<int32_t> ring = m.ring(f);
        int entries = 0;
        for (size_t k = 0; k < ring.size(); ++k)
          entries += !in[size_t(ring[k])] && in[size_t(ring[(k + 1) % ring.size()])];
        if (entries < 2) continue;
        for (const int32_t u : ring) in[size_t(u)] = 0;
        pinched = true;
      }
  }
  std::vector<int32_t> stack;
  const auto first = std::find_if(region.begin(), region.end(), [&](int32_t v) { return in[size_t(v)] == 1; });
  if (first != region.end()) stack.push_back(*first), in[size_t(*first)] = 2;
  while (!stack.empty()) {
    const int32_t v = stack.back();
    stack.pop_back();
    for (const int32_t u : m.nbr[size_t(v)])
      if (in[size_t(u)] == 1) in[size_t(u)] = 2, stack.push_back(u);
  }
  std::erase_if(region, [&](int32_t v) { return in[size_t(v)] != 2; });
  return region;
}

TissueResult build_tissue(const Mesh& face, std::span<const int32_t> region, const Mesh& skull,
                          std::span<const int32_t> skull_region, const TissueSettings& s, Workers& workers) {
  TissueResult out;
  const auto refuse = [&](std::string why) {
    out.reason = std::move(why);
    return out;
  };
  if (s.layers < 1 || s.layers > 16) return refuse("a tissue has 1 to 16 layers");
  if (!std::isfinite(s.young_kPa) || s.young_kPa < 0)
    return refuse("the stiffness must be a finite number of kPa, 0 or more");
  if (!(s.max_thickness_mm > 0)) return refuse("the largest thickness must be above 0 mm");
  Patch p;
  if (std::string why = make_patch(face, region, p); !why.empty()) return refuse(why);
  FanTriangles fan = fan_triangles(skull);
  std::vector<int32_t> subset;
  if (!skull_region.empty()) {
    std::vector<uint8_t> in(skull.face_edge.size(), 0);
    for (int32_t v : skull_region) {
      if (!skull.alive(v))
        return refuse("the region of the skull names vertex " + std::to_string(v) + ", which does not exist");
      for (int32_t f : skull.left[size_t(v)]) in[size_t(f)] = 1;
    }
    for (size_t t = 0; t < fan.face.size(); ++t)
      if (in[size_t(fan.face[t])]) subset.push_back(int32_t(t));
  }
  if (fan.tri.empty() || (!skull_region.empty() && subset.empty()))
    return refuse("the region of the skull has no surface");
  Bvh bvh(fan.X_mm, fan.tri, subset);
  const Ground ground{skull, std::move(fan), std::move(bvh)};
  std::vector<Vec3> bottom;
  std::vector<uint8_t> hovers;
  if (s.mend) {
    TissueFeet feet = sound_feet(p, ground.bvh, s.max_thickness_mm, s.layers, s.floor);
    for (const int32_t i : feet.unsound) out.unsound.push_back(region[size_t(i)]);
    if (!feet.unsound.empty()) return refuse("columns under the face" + below(s.floor));
    bottom = std::move(feet.bottom), hovers = std::move(feet.hovers);
  } else if (std::string why = drop(p, ground.bvh, s.max_thickness_mm, bottom, hovers); !why.empty()) {
    return refuse(why);
  }

  Tissue& t = out.tissue;
  t.layers = s.layers;
  if (std::string why = stack_layers(p, bottom, t); !why.empty()) return refuse(why);
  t.hovering = int(std::count_if(hovers.begin(), hovers.end(), [](uint8_t h) { return h != 0; }));
  if (const TissueQuality q = quality_of(t); q.least_ratio < s.floor.shape || q.thinnest_mm < s.floor.thickness_mm)
    return refuse("columns between face and bone" + below(s.floor));
  if (std::string why = Dual(t, face, region, p, ground, hovers).build(); !why.empty()) return refuse(why);
  settle(t, face, skull, workers);
  stiffen(t, s);
  if (const auto bad = find_fault(t)) return refuse(*bad);
  return out;
}

Mat3 axes_of(const BoneAnchor& a, const Mesh& skull) {
  const Vec3 &A = skull.x_mm[size_t(a.skull[0])], &B = skull.x_mm[size_t(a.skull[1])],
             &C = skull.x_mm[size_t(a.skull[2])];
  const Vec3 N = (B - A).cross(C - A), e = B - A;
  if (!(N.norm() > 1e-9 * e.squaredNorm()) || !(e.norm() > 0)) return Mat3::Identity();
  Mat3 Q;
  Q.col(0) = e.normalized(), Q.col(2) = N.normalized(), Q.col(1) = Q.col(2).cross(Q.col(0));
  return Q;
}

void follow(Tissue& t, const Mesh& face, const Mesh& skull) {
  for (const auto& [v, f] : t.link) {
    if (!face.alive(f))
      throw InputError("", 0, "the tissue hangs on vertex " + std::to_string(f) + " of the face, which has gone");
    t.x_mm[size_t(v)] = face.x_mm[size_t(f)];
  }
  for (const BoneAnchor& a : t.anchor) {
    Vec3 x = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) {
      if (!skull.alive(a.skull[k]))
        throw InputError(
            "", 0, "the tissue is anchored on vertex " + std::to_string(a.skull[k]) + " of the skull, which has gone");
      x += a.weight[k] * skull.x_mm[size_t(a.skull[k])];
    }
    const Vec3 N = (skull.x_mm[size_t(a.skull[1])] - skull.x_mm[size_t(a.skull[0])])
                       .cross(skull.x_mm[size_t(a.skull[2])] - skull.x_mm[size_t(a.skull[0])]);
    if (const double l = N.norm(); l > 0) x += a.height_mm / l * N;
    t.x_mm[size_t(a.vertex)] = x;
  }
}

std::optional<std::string> find_fault(const Tissue& t) {
  const size_t n = t.nbr.size();
  if (t.x_mm.size() != n || t.before_mm.size() != n || t.role.size() != n || t.rest_mm.size() != n ||
      t.k_mN_per_mm.size() != n || t.x0_mm.size() != n || t.turn.size() != n || t.bent_mm.size() != n)
    return "the arrays of the tissue differ in length";
  for (size_t v = 0; v < n; ++v) {
    const auto name = "vertex " + std::to_string(v) + " of the tissue ";
    if (!t.x_mm[v].allFinite()) return name + "is not at a finite place";
    for (size_t k = 0; k < 4; ++k) {
      const int32_t u = t.nbr[v][k];
      if (u < 0 || size_t(u) >= n || size_t(u) == v) return name + "does not have four neighbours";
      for (size_t j = k + 1; j < 4; ++j)
        if (t.nbr[v][j] == u) return name + "has a neighbour twice";
      if (std::count(t.nbr[size_t(u)].begin(), t.nbr[size_t(u)].end(), int32_t(v)) != 1)
        return name + "has a neighbour that does not have it in turn";
    }
  }
  return std::nullopt;
}

uint64_t hash(const Tissue& t) {
  Hash64 h;
  for (size_t v = 0; v < t.nbr.size(); ++v) {
    for (size_t k = 0; k < 4; ++k) h.add(t.nbr[v][k]), h.add(t.rest_mm[v][k]), h.add(t.k_mN_per_mm[v][k]);
    for (int k = 0; k < 3; ++k) h.add(t.x_mm[v][k]), h.add(t.before_mm[v][k]);
    for (int k = 0; k < 9; ++k) h.add(t.turn[v].data()[k]);
    h.add(t.role[v]);
  }
  return h.value();
}

}  // namespace limberg::simplex
