#pragma once
// A slab under the knife with its lattice kept up to date and checked after every step.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "sim/lattice/topology.h"
#include "tests/sim/cutting/scenes.h"

namespace limberg::test {

/// Cubic lattice over the slabs of scenes.h, not aligned with anything.
inline LatticeGrid grid_over(double size_mm, double thickness_mm, double cell_mm) {
  LatticeGrid g;
  g.rest = grid();
  const double u = g.rest.half_unit_mm();
  constexpr int32_t unit = 2 << kLevels;  // its cells can be divided
  const int32_t pitch = unit * int32_t(std::lround(cell_mm / u / unit));
  g.pitch = {pitch, pitch, pitch};
  auto odd = [&](double mm) { return 2 * int32_t(std::floor(mm / u / 2)) + 1; };
  g.origin = {odd(-size_mm / 2 - 0.4 * cell_mm), odd(-size_mm / 2 - 0.3 * cell_mm),
              odd(-thickness_mm - 0.35 * cell_mm)};
  g.count = {int(size_mm / cell_mm) + 2, int(size_mm / cell_mm) + 2, int((thickness_mm + 3) / cell_mm) + 2};
  return g;
}

struct LatticeScene {
  Arrangement a;
  LatticeGrid g;
  std::shared_ptr<const LatticeTopology> t;
  uint64_t seed = 1;
  bool only_cut = false;  // the last step took nothing away
  Divide divide = Divide::fronts;

  LatticeScene(const TriMesh& mesh, const LatticeGrid& lattice, int front_levels = 0, const Grading& grading = {})
      : a(mesh, grid()), g(lattice), t(build_topology(g, material_surface(a), front_levels, grading)) {
    check();
  }

  /// With `sweep`, what is smaller than 1 mm^3 goes in the same step.
  bool cut(const Blade& blade, bool sweep = false) {
    const double before = a.volume_mm3();
    const CutResult r = a.cut(blade, seed++);
    if (!r.ok()) return false;
    if (sweep) a.sweep_debris(1.0);
    only_cut = std::abs(a.volume_mm3() - before) < 1e-9;
    update();
    return true;
  }
  bool excise_smallest() {
    const auto& c = a.components();
    int best = -1;
    for (size_t i = 0; i < c.size(); ++i)
      if (c[i].volume_mm3 > 0 && (best < 0 || c[i].volume_mm3 < c[size_t(best)].volume_mm3)) best = int(i);
    if (!a.excise(best).done) return false;
    only_cut = false;
    update();
    return true;
  }

  void update() {
    const auto before = t;
    t = update_topology(*before, material_surface(a), nullptr, divide);
    check();
    check_parents(*before);
    same_as_rebuilt();
  }

  void check() const {
    EXPECT_EQ(check_topology(*t), "");
    EXPECT_EQ(t->walks_unresolved, 0);
    EXPECT_EQ(t->pieces, a.pieces());
    EXPECT_NEAR(t->volume_mm3, a.volume_mm3(), 1e-9 * a.volume_mm3());
    // Piece by piece: the lattice's pieces are the components of positive volume less the cavities in them.
    double cavity = 0;
    std::vector<double> volume;
    for (const auto& c : a.components())
      c.volume_mm3 > 0 ? volume.push_back(c.volume_mm3) : void(cavity += c.volume_mm3);
    std::vector<double> piece = t->piece_volume_mm3;
    std::sort(volume.begin(), volume.end());
    std::sort(piece.begin(), piece.end());
    for (size_t i = 0; cavity == 0 && i < std::min(volume.size(), piece.size()); ++i)
      EXPECT_NEAR(piece[i], volume[i], 1e-9 * a.volume_mm3());
    for (const CellCopy& c : t->cells) {
      EXPECT_GT(c.fraction, -1e-9);
      EXPECT_LT(c.fraction, 1 + 1e-9);
    }
  }

  void check_parents(const LatticeTopology& before) const {
    std::vector<double> fraction(before.cells.size(), 0);
    for (size_t i = 0; i < t->cells.size(); ++i) {
      const CellCopy& c = t->cells[i];
      ASSERT_GE(t->cell_parent[i], 0);
      const size_t parent = size_t(t->cell_parent[i]);
      int32_t whole = c.cell;
      for (; whole != before.cells[parent].cell; whole = t->tree.owner(whole)) ASSERT_TRUE(t->tree.is_part(whole));
      fraction[parent] += c.fraction / double(1 << 3 * (t->tree.level(c.cell) - t->tree.level(whole)));
      for (size_t k = 0; whole == c.cell && k < 8; ++k) {
        // (Two nodes that hung on the same masters may become one when those are divided.)
        const int32_t was = before.cells[parent].node[k];
        const bool hung =
            std::any_of(before.hanging.begin(), before.hanging.end(), [&](const auto& h) { return h.node == was; });
        if (!hung) {
          ASSERT_EQ(t->node_parent[size_t(c.node[k])], was);
        }
      }
    }
    check_positions(before);
    for (size_t c = 0; c < fraction.size(); ++c) {
      EXPECT_LT(fraction[c], before.cells[c].fraction + 1e-11);
      if (only_cut) {
        EXPECT_NEAR(fraction[c], before.cells[c].fraction, 1e-11);
      }
    }
  }

  /// A state of the version before, carried over as the solver does: every corner of every copy is where it was, and
  /// what hangs is where its masters put it.
  void check_positions(const LatticeTopology& before) const {
    std::vector<Vec3> u;
    for (size_t n = 0; n < before.nodes.size(); ++n)
      u.push_back(Vec3(std::sin(1.0 * double(n)), std::cos(1.7 * double(n)), std::sin(0.3 * double(n))));
    follow(before, u);
    const std::vector<Vec3> v = carried(u);
    auto w = v;
    follow(*t, w);
    for (size_t n = 0; n < v.size(); ++n) ASSERT_LT((v[n] - w[n]).norm(), 1e-12) << "hanging node " << n;
    for (size_t i = 0; i < t->cells.size(); ++i) {
      const CellCopy& c = t->cells[i];
      const CellCopy& whole = before.cells[size_t(t->cell_parent[i])];
      const CellPlace p = t->tree.place(g, c.cell), q = t->tree.place(g, whole.cell);
      for (int k = 0; k < 8; ++k) {
        Vec3 x = Vec3::Zero();
        for (int b = 0; b < 8; ++b) {
          double weight = 1;
          for (int axis = 0; axis < 3; ++axis) {
            const double s = double(p.at[axis] + (k >> axis & 1)) / (1 << (p.level - q.level)) - q.at[axis];
            weight *= b >> axis & 1 ? s : 1 - s;
          }
          x += weight * u[size_t(whole.node[size_t(b)])];
        }
        ASSERT_LT((x - v[size_t(c.node[size_t(k)])]).norm(), 1e-12) << "cell " << c.cell << " corner " << k;
      }
    }
  }
  static void follow(const LatticeTopology& version, std::vector<Vec3>& u) {
    for (const auto& h : version.hanging) {
      Vec3 s = Vec3::Zero();
      for (size_t k = 0; k < size_t(h.count); ++k) s += u[size_t(h.master[k])] / h.count;
      u[size_t(h.node)] = s;
    }
  }
  std::vector<Vec3> carried(const std::vector<Vec3>& u) const {
    std::vector<Vec3> v;
    for (size_t n = 0; n < t->nodes.size(); ++n) v.push_back(u[size_t(t->node_parent[n])]);
    for (const auto& b : t->born) {
      v[size_t(b.node)].setZero();
      for (auto [p, w] : b.from) v[size_t(b.node)] += w * u[size_t(p)];
    }
    return v;
  }

  void same_as_rebuilt() const {
    const auto r = build_topology_like(*t, material_surface(a));
    ASSERT_EQ(r->tree.ids(), t->tree.ids());
    ASSERT_EQ(r->cells.size(), t->cells.size());
    EXPECT_EQ(r->nodes.size(), t->nodes.size());
    EXPECT_TRUE(r->links == t->links);
    EXPECT_TRUE(r->node_in_material == t->node_in_material);
    EXPECT_EQ(r->hanging.size(), t->hanging.size());
    for (size_t d = 0; d < r->tree.division.size(); ++d)
      EXPECT_EQ(r->tree.division[d].node_in_material, t->tree.division[d].node_in_material);
    for (size_t c = 0; c < r->components.size(); ++c) {
      ASSERT_EQ(bool(r->components[c]), bool(t->components[c]));
      if (!r->components[c]) continue;
      EXPECT_EQ(r->components[c]->face, t->components[c]->face);
      EXPECT_EQ(r->components[c]->of_side, t->components[c]->of_side);
    }
  }
};

}  // namespace limberg::test
