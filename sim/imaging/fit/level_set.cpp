#include "sim/imaging/fit/level_set.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/union_find.h"
#include "sim/imaging/fit/graded_grid.h"
#include "sim/imaging/fit/march_tet.h"
#include "sim/skull/simplex/adapt.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/motion.h"

namespace limberg {
namespace {

using namespace simplex;

constexpr int kBlock = 8;  // cubes along a side
constexpr double kFoldedCosine = 0.2;

struct Grid {
  Vec3 low;
  double step;
  std::array<int64_t, 3> n;  // nodes
  Vec3 place(int64_t i, int64_t j, int64_t k) const { return low + step * Vec3(double(i), double(j), double(k)); }
  int64_t index(int64_t i, int64_t j, int64_t k) const { return i + n[0] * (j + n[1] * k); }
};

Grid make_grid(const LevelSet& s, double step) {
  const Vec3 size = s.high_mm - s.low_mm;
  if (!size.allFinite() || !(size.minCoeff() > 0) || !std::isfinite(step) || !(step > 0))
    throw InputError("", 0, "a box with extent and a grid above 0 mm were expected");
  Grid g{s.low_mm, step, {}};
  double all = 1;
  for (size_t a = 0; a < 3; ++a) {
    const double cubes = std::max(1., std::ceil(size[Eigen::Index(a)] / step - 1e-9));
    all *= cubes + 1;
    if (!(all <= 4e8)) throw InputError("", 0, "the grid has more than 4e8 places; a coarser one was expected");
    g.n[a] = int64_t(cubes) + 1;
  }
  return g;
}

/// The six tetrahedra about the diagonal 0 - 7 of a cube; corner bits: 1 = +x, 2 = +y, 4 = +z. All of positive volume.
constexpr int kTet[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

/// Only the triangles of the largest component; returns how many others there were.
int keep_largest(std::vector<Tri>& tri, size_t vertices) {
  UnionFind joined(vertices);
  for (const Tri& t : tri)
    for (size_t k = 1; k < 3; ++k) joined.unite(t[0], t[k]);
  std::vector<int64_t> count(vertices, 0);
  for (const Tri& t : tri) ++count[size_t(joined.find(t[0]))];
  const auto best = int32_t(std::max_element(count.begin(), count.end()) - count.begin());
  const int parts = int(std::count_if(count.begin(), count.end(), [](int64_t c) { return c > 0; }));
  std::erase_if(tri, [&](const Tri& t) { return joined.find(t[0]) != best; });
  return parts - 1;
}

class Mesher {
 public:
  Mesher(const LevelSet& s, const LevelSetSettings& settings, Workers& w)
      : s_(s), set_(settings), workers_(w), motion_(w) {}

  Mesh run(LevelSetReport& r) {
    std::vector<Vec3> X;
    std::vector<Tri> tri;
    if (set_.edge_at)
      march_graded(
          s_, [&](const Vec3& p) { return std::min(set_.grid_of_edge * set_.edge_at(p), set_.grid_mm); }, workers_, X,
          tri, &r.evaluations);
    else
      march(s_, set_.grid_mm, workers_, X, tri, &r.evaluations);
    r.triangles = int64_t(tri.size());
    if (tri.empty()) throw InputError("", 0, "there is no surface in the box");
    r.dropped = keep_largest(tri, X.size());
    Mesh m = from_triangles(X, tri, DualPlacement::centroid);
    AdaptSettings a;
    a.edge_mm = set_.edge_mm, a.edge_at = set_.edge_at, a.passes = 1, a.most_per_pass = 0.5;
    int32_t before = 0;
    for (int pass = 0; pass < set_.passes; ++pass) {
      before = m.vertices();
      a.seed = uint64_t(pass) + 1;
      Delta d;
      const AdaptReport done = adapt(m, a, d);
      const bool nearly = m.vertices() > before - before / 10;
      if (done.splits + done.merges > 0) compact(m);
      smooth(m, nearly ? set_.smoothing : 2, nearly);
      if (nearly && done.splits + done.merges < m.faces() / 50 && pass > 0) break;
    }
    smooth(m, 2 * set_.smoothing, true);
    workers_.parallel_for(m.nbr.size(), 256, [&](size_t b, size_t e) {
      for (size_t v = b; v < e; ++v)
        if (!on_rim(m, int32_t(v))) put_on_surface(s_, m.x_mm[v], 2 * set_.edge_mm);
    });
    for (size_t v = 0; v < m.nbr.size(); ++v)
      if (on_rim(m, int32_t(v))) put_rim(m.x_mm[v]);
    unfold(m);
    m.before_mm = m.x_mm;
    compact(m, true);
    record_shape(m);
    measure(m, r);
    return m;
  }

 private:
  static bool on_rim(const Mesh& m, int32_t v) {
    for (int32_t f : m.left[size_t(v)])
      if (is_end(m.kind(f))) return true;
    return false;
  }

  /// Onto the side of the box that is nearest (merging draws the rim inwards), and onto the surface within it.
  void put_rim(Vec3& p) const {
    double best = 2 * set_.edge_mm;
    int axis = -1;
    double side = 0;
    for (int a = 0; a < 3; ++a)
      for (double at : {s_.low_mm[a], s_.high_mm[a]})
        if (std::abs(p[a] - at) < best) best = std::abs(p[a] - at), axis = a, side = at;
    if (axis >= 0) p[axis] = side;
    for (int i = 0; i < 12; ++i) {
      LevelAt l = level_at(s_, p);
      const double length = l.gradient.norm();
      if (axis >= 0) l.gradient[axis] = 0;
      const double g2 = l.gradient.squaredNorm();
      if (!(g2 > 1e-3) || std::abs(l.distance_mm) < 1e-4) return;
      p -= std::clamp(l.distance_mm * length / g2, -set_.edge_mm, set_.edge_mm) * l.gradient;
    }
  }

  /// Evens the vertices out; with `pull`, along the surface.
  void smooth(Mesh& m, int iterations, bool pull) {
    Law law;
    law.zone[0].constraint = pull ? Constraint::angle : Constraint::tangent;
    law.zone[0].alpha = 0.5, law.zone[0].beta = pull ? 0.5 : 0;
    law.external_stiffness = pull ? 1 : 0, law.max_step_mm = 0.5 * set_.edge_mm, law.gamma = 0.6;
    motion_.set_law(law);
    std::vector<int32_t> rim;
    for (int32_t v = 0; v < m.slots(); ++v)
      if (m.alive(v) && on_rim(m, v)) rim.push_back(v), m.flags[size_t(v)] |= kLocked, put_rim(m.x_mm[size_t(v)]);
    m.before_mm = m.x_mm;
    for (int i = 0; i < iterations; ++i) {
      force_.assign(m.nbr.size(), Vec3::Zero());
      if (pull)
        workers_.parallel_for(m.nbr.size(), 256, [&](size_t b, size_t e) {
          for (size_t v = b; v < e; ++v) {
            if (!m.alive(int32_t(v))) continue;
            const LevelAt l = level_at(s_, m.x_mm[v]);
            force_[v] = -std::clamp(l.distance_mm, -set_.edge_mm, set_.edge_mm) * l.gradient.normalized();
          }
        });
      motion_.step(m, {force_, {}});
    }
    for (int32_t v : rim) m.flags[size_t(v)] = uint8_t(m.flags[size_t(v)] & ~kLocked);
  }

  bool folded(const Mesh& m, int32_t v) const {
    const LocalFrame f = m.frame(v);
    return !f.degenerate && f.N.dot(level_at(s_, m.x_mm[size_t(v)]).gradient.normalized()) < kFoldedCosine;
  }

  /// Vertices that look the wrong way go between their neighbours and back on the surface from there.
  void unfold(Mesh& m) const {
    for (int round = 0; round < 8; ++round) {
      bool any = false;
      for (int32_t v = 0; v < m.slots(); ++v) {
        if (!m.alive(v) || on_rim(m, v) || !folded(m, v)) continue;
        Row around = m.nbr[size_t(v)];
        for (int32_t u : around)
          if (!on_rim(m, u)) even(m, u);
        even(m, v);
        any = true;
      }
      if (!any) break;
    }
  }
  void even(Mesh& m, int32_t v) const {
    Vec3 p = Vec3::Zero();
    for (int32_t u : m.nbr[size_t(v)]) p += m.x_mm[size_t(u)] / 3;
    if (put_on_surface(s_, p, set_.edge_mm)) m.x_mm[size_t(v)] = p;
  }

  void measure(const Mesh& m, LevelSetReport& r) const {
    std::vector<double> far(m.nbr.size(), 0), turn(m.nbr.size(), 1);
    workers_.parallel_for(m.nbr.size(), 256, [&](size_t b, size_t e) {
      for (size_t v = b; v < e; ++v) {
        const LevelAt l = level_at(s_, m.x_mm[v]);
        far[v] = std::abs(l.distance_mm);
        const LocalFrame f = m.frame(int32_t(v));
        if (!f.degenerate && !on_rim(m, int32_t(v))) turn[v] = f.N.dot(l.gradient.normalized());
      }
    });
    for (size_t v = 0; v < far.size(); ++v)
      r.rms_mm += far[v] * far[v] / double(far.size()), r.max_mm = std::max(r.max_mm, far[v]),
                                                        r.folded += turn[v] < kFoldedCosine;
    r.rms_mm = std::sqrt(r.rms_mm);
    int64_t n = 0;
    for (int32_t f = 0; f < m.face_slots(); ++f) {
      if (!m.alive_face(f) || is_end(m.kind(f))) continue;
      const double d = std::abs(level_at(s_, face_centre(m, f)).distance_mm);
      r.face_rms_mm += d * d, r.face_max_mm = std::max(r.face_max_mm, d), ++n;
    }
    if (n > 0) r.face_rms_mm = std::sqrt(r.face_rms_mm / double(n));
  }

  const LevelSet& s_;
  const LevelSetSettings& set_;
  Workers& workers_;
  Motion motion_;
  std::vector<Vec3> force_;
};

}  // namespace

LevelAt level_at(const LevelSet& s, const Vec3& p) {
  // Four places on a tetrahedron: their mean is the value to second order, their differences the gradient.
  constexpr double h = 0.02;
  static const Vec3 corner[4] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  LevelAt out;
  double mean = 0;
  for (const Vec3& c : corner) {
    const double f = s.distance_mm(p + h * c);
    out.gradient += f / (4 * h) * c, mean += f / 4;
  }
  out.distance_mm = mean / std::max(out.gradient.norm(), 0.05);
  return out;
}

bool put_on_surface(const LevelSet& s, Vec3& p, double reach) {
  const Vec3 start = p;
  for (int i = 0; i < 12; ++i) {
    const LevelAt l = level_at(s, p);
    const double g = l.gradient.norm();
    if (!(g > 1e-6)) break;
    p -= std::clamp(l.distance_mm, -reach, reach) / g * l.gradient;
    if (!((p - start).norm() <= reach)) break;
    if (std::abs(l.distance_mm) < 1e-4) return true;
  }
  const bool good = (p - start).norm() <= reach && std::abs(level_at(s, p).distance_mm) < 1e-2;
  if (!good) p = start;
  return good;
}

void march(const LevelSet& s, double step, Workers& workers, std::vector<Vec3>& X, std::vector<Tri>& tri,
           int64_t* evaluations) {
  const Grid g = make_grid(s, step);
  const std::array<int64_t, 3> blocks = {(g.n[0] + kBlock - 2) / kBlock, (g.n[1] + kBlock - 2) / kBlock,
                                         (g.n[2] + kBlock - 2) / kBlock};
  const size_t all = size_t(blocks[0] * blocks[1] * blocks[2]);
  const double radius = 0.5 * kBlock * step * std::sqrt(3.);
  std::vector<Patch> patch(all);
  std::vector<int64_t> asked(all, 0);
  workers.parallel_for(all, 4, [&](size_t first, size_t last) {
    std::array<double, (kBlock + 1) * (kBlock + 1) * (kBlock + 1)> f{};
    for (size_t b = first; b < last; ++b) {
      const int64_t i0 = int64_t(b) % blocks[0] * kBlock, j0 = int64_t(b) / blocks[0] % blocks[1] * kBlock,
                    k0 = int64_t(b) / (blocks[0] * blocks[1]) * kBlock;
      const double middle = s.distance_mm(g.place(i0, j0, k0) + Vec3::Constant(0.5 * kBlock * step));
      ++asked[b];
      if (std::abs(middle) > s.lipschitz * radius) continue;
      const int64_t ni = std::min<int64_t>(kBlock, g.n[0] - 1 - i0), nj = std::min<int64_t>(kBlock, g.n[1] - 1 - j0),
                    nk = std::min<int64_t>(kBlock, g.n[2] - 1 - k0);
      const auto at = [&](int64_t i, int64_t j, int64_t k) {
        return size_t((k * (kBlock + 1) + j) * (kBlock + 1) + i);
      };
      for (int64_t k = 0; k <= nk; ++k)
        for (int64_t j = 0; j <= nj; ++j)
          for (int64_t i = 0; i <= ni; ++i) f[at(i, j, k)] = s.distance_mm(g.place(i0 + i, j0 + j, k0 + k));
      asked[b] += (ni + 1) * (nj + 1) * (nk + 1);
      for (int64_t k = 0; k < nk; ++k)
        for (int64_t j = 0; j < nj; ++j)
          for (int64_t i = 0; i < ni; ++i) {
            int inside = 0;
            for (int c = 0; c < 8; ++c) inside += f[at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2))] < 0;
            if (inside == 0 || inside == 8) continue;
            for (const auto& t : kTet) {
              std::array<int64_t, 4> node{};
              std::array<double, 4> value{};
              for (size_t c = 0; c < 4; ++c) {
                const int64_t x = i + (t[c] & 1), y = j + (t[c] >> 1 & 1), z = k + (t[c] >> 2);
                node[c] = g.index(i0 + x, j0 + y, k0 + z), value[c] = f[at(x, y, z)];
              }
              march_tet(node, value, patch[b]);
            }
          }
    }
  });
  number_vertices(
      patch, [&](int64_t v) { return g.place(v % g.n[0], v / g.n[0] % g.n[1], v / (g.n[0] * g.n[1])); },
      [&](int64_t, const Vec3& x) { return s.distance_mm(x); }, X, tri);
  if (evaluations) {
    *evaluations = 0;
    for (int64_t n : asked) *evaluations += n;
  }
}

Mesh mesh_level_set(const LevelSet& s, const LevelSetSettings& settings, Workers& workers, LevelSetReport* report) {
  LevelSetReport mine;
  Mesh m = Mesher(s, settings, workers).run(mine);
  if (report) *report = mine;
  return m;
}

}  // namespace limberg
