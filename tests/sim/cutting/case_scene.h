#pragma once
// A body under the knife with its lattice, for the named cases: after every operation the whole signature is checked,
// and every case is run three times, taken back step by step, and made again.
//
//   I1 mates, I3 closed oriented surface, I9, I11, I13 junctions and sectors   Arrangement::check_all
//   I4 volume          exact modulo 2^61 - 1, and 1e-12 of the body's in doubles
//   I5, I6 mass        children's fractions sum to the parent's; the lattice's volume is the surface's
//   I7 parents         the node partition refines the one before
//   I12, I14, I16      contradictions are refused or thrown by the code itself
//   I15 pieces         of the lattice = components of positive volume
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "sim/base/union_find.h"
#include "sim/cutting/arrangement/store.h"
#include "sim/lattice/topology.h"
#include "tests/bench/fuzz/checks.h"
#include "tests/sim/cutting/scenes.h"

namespace limberg::test {

using Chi = std::vector<int>;

/// A flat closed slab [-sx/2, sx/2] x [-sy/2, sy/2] x [-thickness,
/// 0] with nx by ny squares of skin. All but the skin is fixed.
inline TriMesh flat_slab(double sx, double sy, double thickness, int nx, int ny) {
  TriMesh m;
  const RestGrid g = grid();
  for (int layer = 0; layer < 2; ++layer)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        m.X_mm.push_back(g.to_mm(g.to_grid({sx * i / nx - sx / 2, sy * j / ny - sy / 2, layer ? -thickness : 0.0})));
  const auto id = [&](int layer, int i, int j) { return int32_t((layer * (ny + 1) + j) * (nx + 1) + i); };
  const auto quad = [&](int32_t a, int32_t b, int32_t c, int32_t d, SurfaceTag tag) {
    for (const Tri& t : {Tri{a, b, c}, Tri{a, c, d}}) m.tri.push_back(t), m.tag.push_back(tag), m.uv.push_back({});
  };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      quad(id(0, i, j), id(0, i + 1, j), id(0, i + 1, j + 1), id(0, i, j + 1), SurfaceTag::skin);
      quad(id(1, i, j), id(1, i, j + 1), id(1, i + 1, j + 1), id(1, i + 1, j), SurfaceTag::fixed);
    }
  for (int i = 0; i < nx; ++i) {
    quad(id(0, i, 0), id(1, i, 0), id(1, i + 1, 0), id(0, i + 1, 0), SurfaceTag::fixed);
    quad(id(0, i + 1, ny), id(1, i + 1, ny), id(1, i, ny), id(0, i, ny), SurfaceTag::fixed);
  }
  for (int j = 0; j < ny; ++j) {
    quad(id(0, 0, j + 1), id(1, 0, j + 1), id(1, 0, j), id(0, 0, j), SurfaceTag::fixed);
    quad(id(0, nx, j), id(1, nx, j), id(1, nx, j + 1), id(0, nx, j + 1), SurfaceTag::fixed);
  }
  return m;
}

/// Cubic cells over a box, beginning a share of a cell outside its low corner.
inline LatticeGrid lattice_over(const TriMesh& m, double cell_mm, double share = 0.37) {
  LatticeGrid g;
  g.rest = grid();
  Vec3 lo = m.X_mm[0], hi = lo;
  for (const Vec3& x : m.X_mm) lo = lo.cwiseMin(x), hi = hi.cwiseMax(x);
  const double u = g.rest.half_unit_mm();
  const int32_t pitch = 8 * int32_t(std::lround(cell_mm / u / 8));
  const auto odd = [&](double mm) { return 2 * int32_t(std::floor(mm / u / 2)) - 1; };
  g.pitch = {pitch, pitch, pitch};
  g.origin = {odd(lo.x() - share * cell_mm), odd(lo.y() - share * cell_mm), odd(lo.z() - share * cell_mm)};
  const auto count = [&](double top, int32_t from) { return int32_t(std::floor((top / u - from) / pitch)) + 1; };
  g.count = {count(hi.x(), g.origin.x), count(hi.y(), g.origin.y), count(hi.z(), g.origin.z)};
  return g;
}

class CaseScene {
 public:
  Arrangement a;
  LatticeGrid g;
  std::shared_ptr<const LatticeTopology> t;
  uint64_t seed = 1;
  CutResult last;

  explicit CaseScene(const TriMesh& m, double cell_mm = 5) : CaseScene(m, lattice_over(m, cell_mm)) {}
  CaseScene(const TriMesh& m, const LatticeGrid& lattice)
      : a(m, grid()), g(lattice), t(build_topology(g, material_surface(a))), initial_(a.full_hash()) {
    body_mm3_ = volume_ = a.volume_mm3();
    check();
  }

  /// A cut that must be made.
  const CutResult& cut(const Blade& blade) {
    attempt(blade);
    EXPECT_TRUE(last.ok()) << last.reason;
    return last;
  }
  /// A cut that may be refused; then nothing has changed.
  bool attempt(const Blade& blade) {
    const uint64_t before = a.full_hash(), volume = a.store().volume_residue;
    const uint64_t s = seed++;
    last = a.cut(blade, s);
    if (!last.ok()) {
      EXPECT_NE(last.reason, "");
      EXPECT_EQ(a.full_hash(), before);
      return false;
    }
    EXPECT_EQ(a.store().volume_residue, volume);
    step([this, blade, s] { return a.cut(blade, s).ok(); }, before, true);
    return true;
  }
  ExciseResult excise(int32_t component) {
    const uint64_t before = a.full_hash();
    const ExciseResult e = a.excise(component);
    EXPECT_TRUE(e.done) << e.reason;
    volume_ -= e.volume_mm3;
    step([this, component] { return a.excise(component).done; }, before, false);
    return e;
  }
  ExciseResult excise_at(const Vec3& at) { return excise(a.loose_component_near(at, 3)); }
  /// As part of the last cut.
  DebrisResult sweep(double below_mm3) {
    const auto middle = t;
    const DebrisResult d = a.sweep_debris(below_mm3);
    if (d.pieces == 0) return d;
    volume_ -= d.volume_mm3;
    const auto redo = std::move(steps_.back().redo);
    steps_.back().redo = [this, redo, below_mm3] { return redo() && (a.sweep_debris(below_mm3), true); };
    t = skip_version(*middle, *update_topology(*middle, material_surface(a)));
    EXPECT_EQ(fuzz::check_parents(*steps_.back().lattice, *t, false), "");
    steps_.back().after = a.full_hash();
    check();
    return d;
  }
  void expect(int pieces, const Chi& chi) const {
    EXPECT_EQ(a.pieces(), pieces);
    EXPECT_EQ(euler(a), chi);
  }
  /// Every step back and forth again (case 38), then all back.
  void take_back() {
    for (size_t i = steps_.size(); i-- > 0;) {
      ASSERT_TRUE(a.undo());
      ASSERT_EQ(a.full_hash(), steps_[i].before);
      ASSERT_TRUE(steps_[i].redo());
      ASSERT_EQ(a.full_hash(), steps_[i].after);
      ASSERT_TRUE(a.undo());
      t = steps_[i].lattice;
    }
    EXPECT_EQ(a.full_hash(), initial_);
    EXPECT_EQ(a.check_all(), "");
    for (size_t i = 0; i < steps_.size(); ++i) {  // and all of it forth
      ASSERT_TRUE(steps_[i].redo());
      ASSERT_EQ(a.full_hash(), steps_[i].after);
    }
  }
  uint64_t signature() const { return a.full_hash() ^ t->hash() * 0x9e3779b97f4a7c15ull; }

  // --- What the cases ask -------------------------------------------------------------------------------------------
  std::vector<int32_t> walls() const {
    std::vector<int32_t> out;
    for (int32_t f = 0; f < int32_t(a.faces().size()); ++f)
      if (a.faces()[f].live() && a.orig_tris()[a.faces()[f].orig].op > 0) out.push_back(f);
    return out;
  }
  Vec3 centre(int32_t f) const {
    const auto& v = a.faces()[size_t(f)].v;
    return (a.point_mm(v[0]) + a.point_mm(v[1]) + a.point_mm(v[2])) / 3;
  }
  double area(int32_t f) const {
    const auto& v = a.faces()[size_t(f)].v;
    return 0.5 * (a.point_mm(v[1]) - a.point_mm(v[0])).cross(a.point_mm(v[2]) - a.point_mm(v[0])).norm();
  }
  /// Edges at which `n` live faces of walls meet.
  int wall_edges_with(int n) const {
    int found = 0;
    for (int32_t f : walls())
      for (size_t k = 0; k < 3; ++k) {
        const int32_t p = a.faces()[size_t(f)].v[k], q = a.faces()[size_t(f)].v[(k + 1) % 3];
        int count = 0;
        int32_t lowest = INT32_MAX;
        for (int32_t h = a.store().edges.first(p, q); h >= 0; h = a.store().edges.next(h))
          if (a.orig_tris()[a.faces()[size_t(h / 3)].orig].op > 0) ++count, lowest = std::min(lowest, h / 3);
        found += count == n && lowest == f;
      }
    return found;
  }
  /// Connected lines of crack front: edges of one live face.
  int fronts() const {
    std::vector<std::pair<int32_t, int32_t>> edges;
    for (int32_t f : walls())
      for (size_t k = 0; k < 3; ++k) {
        const int32_t p = a.faces()[size_t(f)].v[k], q = a.faces()[size_t(f)].v[(k + 1) % 3];
        const int32_t h = a.store().edges.first(p, q);
        if (h >= 0 && a.store().edges.next(h) < 0) edges.push_back({p, q});
      }
    UnionFind line(size_t(a.point_count()));
    std::set<int32_t> lines;
    for (const auto& [p, q] : edges) line.unite(p, q);
    for (const auto& [p, q] : edges) lines.insert(line.find(p));
    return int(lines.size());
  }

 private:
  struct Step {
    std::function<bool()> redo;
    uint64_t before = 0, after = 0;
    std::shared_ptr<const LatticeTopology> lattice;
  };
  void step(std::function<bool()> redo, uint64_t before, bool only_cut) {
    const auto old = t;
    steps_.push_back({std::move(redo), before, a.full_hash(), old});
    t = update_topology(*old, material_surface(a));
    EXPECT_EQ(fuzz::check_parents(*old, *t, only_cut), "");
    check();
  }
  void check() const {
    EXPECT_EQ(a.check_all(), "");
    EXPECT_EQ(check_topology(*t), "");
    EXPECT_EQ(t->walks_unresolved, 0);
    EXPECT_EQ(t->pieces, a.pieces());
    EXPECT_NEAR(a.volume_mm3(), volume_, 1e-12 * body_mm3_ * double(steps_.size() + 1));
    EXPECT_NEAR(t->volume_mm3, a.volume_mm3(), 1e-10 * body_mm3_);
    EXPECT_EQ(fuzz::check_same(*t, *build_topology(g, material_surface(a))), "");
  }
  uint64_t initial_;
  double body_mm3_ = 0, volume_ = 0;
  std::vector<Step> steps_;
};

/// Defines a named case: the body below, run three times to the same bits, each time taken back and made again.
#define CUT_CASE(name, ...)                      \
  void name(CaseScene& s);                       \
  TEST(CutCases, name) {                         \
    uint64_t signature = 0;                      \
    for (int run = 0; run < 3; ++run) {          \
      CaseScene s(__VA_ARGS__);                  \
      name(s);                                   \
      if (run == 0) signature = s.signature();   \
      EXPECT_EQ(s.signature(), signature);       \
      if (run == 0) s.take_back();               \
      if (::testing::Test::HasFailure()) return; \
    }                                            \
  }                                              \
  void name(CaseScene& s)

inline TriMesh case_slab() { return flat_slab(60, 60, 12, 20, 20); }
inline TriMesh wavy_case_slab() { return wavy_slab(60, 12, 20, 0.8); }
inline const std::vector<Vec2> kRhombus{{10, 0}, {0, 6}, {-10, 0}, {0, -6}};

}  // namespace limberg::test
