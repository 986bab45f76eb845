// Cells that a held surface or a body's edge cuts askew: what must be true of each by itself, since what a cut leaves
// of it may have no neighbour that holds it.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "sim/testing/reference_cells.h"
#include "tests/sim/cutting/scenes.h"
#include "tests/sim/lattice/sheet_lattice.h"

namespace limberg::test {
namespace test_held_cells {

/// Tissue of 4 to 9 mm over a bone that is no plane, or over one that is none of the lattice.
Sheet over_bone(bool curved) {
  Sheet s;
  s.size_mm = 40;
  s.top = [](double x, double y) { return 3 * std::cos(0.08 * x) * std::cos(0.06 * y + 0.3); };
  s.bottom = [=, top = s.top](double x, double y) {
    return curved ? top(x, y) - 6.5 - 2 * std::sin(0.2 * x) * std::cos(0.17 * y) : top(x, y) - 6 - 0.1 * x;
  };
  return s;
}

/// The least eigenvalue of the tangent at rest over the largest, of a copy by itself: over what moves its corners.
double least_stiffness(const FemModel& m, const fem::ReferenceCells& cells, const HexCell& c,
                       std::span<const Vec3> rest) {
  std::vector<int32_t> unknowns;
  Eigen::Matrix<double, 24, Eigen::Dynamic> of_unknowns(24, 0);  // displacements of the corners
  const auto moves = [&](int corner, int32_t node, double weight) {
    const auto at = std::find(unknowns.begin(), unknowns.end(), node);
    const Eigen::Index column = 3 * (at - unknowns.begin());
    if (at == unknowns.end()) {
      unknowns.push_back(node);
      of_unknowns.conservativeResize(24, column + 3);
      of_unknowns.rightCols(3).setZero();
    }
    for (int i = 0; i < 3; ++i)
      if (!m.fixed[size_t(node)].along(i)) of_unknowns(3 * corner + i, column + i) += weight;
  };
  for (int k = 0; k < 8; ++k) {
    const int32_t n = c.node[size_t(k)];
    const auto hangs = std::lower_bound(m.hanging.begin(), m.hanging.end(), n,
                                        [](const HangingNode& h, int32_t node) { return h.node < node; });
    if (hangs == m.hanging.end() || hangs->node != n)
      moves(k, n, 1);
    else
      for (size_t i = 0; i < size_t(hangs->count); ++i) moves(k, hangs->master[i], double(hangs->weight[i]));
  }
  const Eigen::MatrixXd H = of_unknowns.transpose() * cells.hessian(c, rest, false) * of_unknowns;
  const auto e = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly).eigenvalues();
  return e.minCoeff() / std::max(e.maxCoeff(), 1e-9);
}

// At rest a body lies in a minimum of its energy. With the volume that fits the mean gradient best (held_cells.h) a
// corner above a held surface gained energy in turning: .8 % of the cell's stiffness, on every tenth cell of a face.
TEST(HeldCells, NoneIsUnstableAtRest) {
  for (bool curved : {false, true})
    for (double h : {5.0, 3.5})
      for (double off : {0.0, 0.3, 0.6}) {
        const SheetLattice l(layered(sheet_mesh(over_bone(curved)), kSkin_mm), h, {0.5, 0.3, off});
        const fem::ReferenceCells cells(*l.m);
        const std::vector<Vec3> rest(l.m->X_mm.size(), Vec3::Zero());
        int unstable = 0, held = 0;
        for (const HexCell& c : l.m->cells) {
          if (!l.table.held_corners(c.stencil)) continue;
          ++held, unstable += least_stiffness(*l.m, cells, c, rest) < -1e-7;
        }
        EXPECT_GT(held, 20);
        EXPECT_EQ(unstable, 0) << "of " << held << "; " << h << ' ' << off;
      }
}

// A node beyond the bone that hangs on a coarser neighbour goes half the way of a master that is free: a cell that took
// it for held had a volume of up to fifty of its own, and a face that was cut over its jaw turned inside out.
TEST(HeldCells, NoneIsUnstableWhereLevelsMeet) {
  for (double off : {0.0, 0.3, 0.6}) {
    const Grading grading{{{{4, 2, 0}, {4, 2, 0}, -Vec3::UnitZ(), 7, INFINITY, 2}}, 2};
    SheetLattice l(layered(sheet_mesh(over_bone(true)), kSkin_mm), 5, {0.5, 0.3, off}, grading);
    const auto unstable = [&] {
      const fem::ReferenceCells cells(*l.m);
      const std::vector<Vec3> rest(l.m->X_mm.size(), Vec3::Zero());
      return std::count_if(l.m->cells.begin(), l.m->cells.end(),
                           [&](const HexCell& c) { return least_stiffness(*l.m, cells, c, rest) < -1e-6; });
    };
    ASSERT_GT(l.m->hanging.size(), 50u);
    EXPECT_EQ(unstable(), 0) << off;
    // and as the fine part follows a cut
    ASSERT_TRUE(l.a.cut(open_box({{9, 0}, {0, 8}, {-9, 0}, {0, -8}}, 6, -1.2), 1).ok());
    const auto was = l.t;
    l.t = update_topology(*was, material_surface(l.a));
    const EarlierModel earlier{*was, *l.m};
    const auto grown = assemble_fem(l.table, *l.t, &earlier);
    l.m = assemble_fem(l.table, *l.t);
    EXPECT_EQ(unstable(), 0) << off;
    for (size_t i = 0; i < l.m->cells.size(); ++i) EXPECT_EQ(l.m->cells[i].stencil, grown->cells[i].stencil);
  }
}

// A plug that is cut out a little above the bone lies in cells that were held. Its copies are not, and no two of their
// corners may move against each other for next to nothing: a hook sent such corners half a metre away.
TEST(HeldCells, WhatIsCutFreeIsStiffInAllItsCorners) {
  SheetLattice l(layered(sheet_mesh(over_bone(true)), kSkin_mm), 5, {0.5, 0.3, 0.3});
  const auto least = [&](bool of_free) {
    double e = 1;
    for (const HexCell& c : l.m->cells) {
      if ((l.table.held_corners(c.stencil) == 0) != of_free) continue;
      const Stencil& s = l.m->stencils[size_t(c.stencil)];
      const auto k = Eigen::SelfAdjointEigenSolver<Mat8>(s.K, Eigen::EigenvaluesOnly).eigenvalues();
      e = std::min(e, k[1] / (s.mu_kPa * s.volume_mm3 / l.m->cell_mm.squaredNorm()));
    }
    return e;
  };
  const double before = least(true), of_held = least(false);
  ASSERT_TRUE(l.a.cut(open_box({{9, 0}, {0, 8}, {-9, 0}, {0, -8}}, 6, -1.2), 1).ok());
  const auto was = l.t;
  l.t = update_topology(*was, material_surface(l.a));
  const EarlierModel earlier{*was, *l.m};
  const auto all = assemble_fem(l.table, *l.t), grown = assemble_fem(l.table, *l.t, &earlier);
  ASSERT_EQ(all->cells.size(), grown->cells.size());
  int cut_free = 0;
  for (size_t i = 0; i < all->cells.size(); ++i) {
    const HexCell& c = all->cells[i];
    EXPECT_EQ(c.stencil, grown->cells[i].stencil);
    EXPECT_EQ(c.scale, grown->cells[i].scale);
    const uint8_t held = l.table.held_corners(c.stencil);
    for (size_t k = 0; k < 8; ++k) {
      if (held >> k & 1) {
        EXPECT_TRUE(all->fixed[size_t(c.node[k])].any());
      }
    }
    const CellCopy& copy = l.t->cells[i];
    const bool usually = l.table.held_corners(l.table.of_place(l.t->tree.place(l.grid, copy.cell))) != 0;
    cut_free += usually && !held;
  }
  EXPECT_GT(cut_free, 5);
  for (size_t n = 0; n < all->mass_kg.size(); ++n) EXPECT_EQ(all->mass_kg[n], grown->mass_kg[n]);
  l.m = all;
  EXPECT_LT(of_held, 0.1 * before);  // corners that are held need none
  EXPECT_GT(least(true), 0.5 * before);
}

// Volume and sliding of a cell that layers share are measured at its centre: which must not lie far beside its matter.
TEST(HeldCells, LayersShareOnlyCellsThatTheBodyFills) {
  int shared = 0, scarce = 0;
  for (double off : {0.0, 0.2, 0.4, 0.6, 0.8}) {
    const SheetLattice l(layered(ball_mesh(20, 4, {0.3, 0.1, 0.2}), kSkin_mm), 5, {off, 0.3, 0.7});
    const double cell_mm3 = l.m->cell_mm.prod();
    for (const HexCell& c : l.m->cells) {
      const bool slides = l.m->stencils[size_t(c.stencil)].slide_kPa != 0,
                 little = l.table.body_mm3(c.stencil) < 0.25 * cell_mm3;
      shared += slides, scarce += little;
      EXPECT_FALSE(slides && little) << l.table.body_mm3(c.stencil);
    }
  }
  EXPECT_GT(shared, 100);
  EXPECT_GT(scarce, 100);
}

}  // namespace test_held_cells
}  // namespace limberg::test
