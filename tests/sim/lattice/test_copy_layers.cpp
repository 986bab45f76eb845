#include <gtest/gtest.h>

#include "sim/lattice/copy_layers.h"
#include "tests/sim/cutting/scenes.h"
#include "tests/sim/lattice/sheet_lattice.h"

namespace limberg::test {
namespace test_copy_layers {

constexpr double kSkinYoung_kPa = 60, kFatYoung_kPa = 15, kNu = 0.45;
constexpr double kSkinDensity = 1.1e-6, kFatDensity = 0.9e-6;  // kg/mm^3
double shear_modulus(double young) { return young / (2 * (1 + kNu)); }

// 60 x 60 x 11.5 mm that nothing holds.
Body skin_on_fat(bool block) {
  Sheet sheet;
  sheet.cells = 10, sheet.below = SurfaceTag::free;
  sheet.top = [](double, double) { return 0.0; };
  sheet.bottom = [](double, double) { return -11.5; };
  Body b = layered(sheet_mesh(sheet), kSkin_mm);
  b.is_box = block;
  b.layers[0].material.young_kPa = kSkinYoung_kPa, b.layers[1].material.young_kPa = kFatYoung_kPa;
  b.layers[0].material.density_kg_mm3 = kSkinDensity, b.layers[1].material.density_kg_mm3 = kFatDensity;
  for (Layer& l : b.layers) l.material.poisson = kNu;
  return b;
}

// A cut slab, as a block or as a surface like any other.
struct CutSlab {
  SheetLattice l;
  std::shared_ptr<const LatticeTopology> t;
  std::shared_ptr<const FemModel> m;
  CutSlab(bool block, double cell_mm, const Vec3& shift = Vec3::Zero())
      : l(skin_on_fat(block), cell_mm, block ? Vec3::Zero() : shift), t(l.t), m(l.m) {}
  void cut(const Blade& blade) {
    ASSERT_TRUE(l.a.cut(blade, 1).ok());
    const MaterialSurface surface = material_surface(l.a);
    const auto next = update_topology(*t, surface);
    const EarlierModel before{*t, *m};
    m = assemble_fem(l.table, *next, &before, &surface);
    t = next;
  }
  /// Per piece, the one that reaches deepest last: energy of the even shear u_x = y (uJ), which no layer slides in.
  std::vector<double> shear() const { return per_piece(false); }
  std::vector<double> mass_kg() const { return per_piece(true); }

 private:
  std::vector<double> per_piece(bool of_mass) const {
    std::vector<double> e(size_t(t->pieces), 0), foot(size_t(t->pieces), 1e9);
    std::vector<bool> seen(m->mass_kg.size());
    for (size_t c = 0; c < m->cells.size(); ++c) {
      const HexCell& cell = m->cells[c];
      const Stencil& s = m->stencils[size_t(cell.stencil)];
      Eigen::Matrix<double, 8, 1> u;
      for (int n = 0; n < 8; ++n) u[n] = (n >> 1 & 1) ? m->cell_mm.y() : 0;
      const size_t piece = size_t(t->cells[c].piece);
      if (!of_mass) e[piece] += 0.5 * double(cell.scale) * u.dot(s.K * u);
      for (int32_t n : cell.node) {
        foot[piece] = std::min(foot[piece], m->X_mm[size_t(n)].z());
        if (of_mass && !seen[size_t(n)]) e[piece] += m->mass_kg[size_t(n)], seen[size_t(n)] = true;
      }
    }
    std::vector<double> sorted;
    while (sorted.size() < e.size()) {
      const size_t at = size_t(std::max_element(foot.begin(), foot.end()) - foot.begin());
      sorted.push_back(e[at]), foot[at] = -1e30;
    }
    return sorted;
  }
};

/// mu/2 of the shear per mm^2 of the sheet: so much skin and so much fat.
double shear_per_mm2(double skin_mm, double fat_mm) {
  return 0.5 * (shear_modulus(kSkinYoung_kPa) * skin_mm + shear_modulus(kFatYoung_kPa) * fat_mm);
}
constexpr double kSize_mm = 60, kFat_mm = 10;

// A sheet through the whole slab below the skin: the upper piece has all of the skin, the lower has none.
TEST(CopyLayers, AFlapKeepsItsSkinAndTheBedHasNone) {
  for (const bool block : {true, false})
    for (const double cell : {5.0, 3.5})
      for (const double depth : {1.5, 2.0, 3.1}) {
        SCOPED_TRACE(testing::Message() << (block ? "block " : "surface ") << cell << " mm, " << depth << " mm deep");
        CutSlab s(block, cell, {0.3, 0.6, 0.45});
        s.cut(sheet({-35, -35, -depth}, {70, 0, 0.001}, {0, 70, 0}, 14, 14));
        const std::vector<double> e = s.shear();
        ASSERT_EQ(e.size(), 2u);
        const double area = kSize_mm * kSize_mm;
        const double flap = area * shear_per_mm2(kSkin_mm, depth - kSkin_mm),
                     bed = area * shear_per_mm2(0, kFat_mm + kSkin_mm - depth);
        // .8 % of a surface's skin is lost at its rim (cut_cells.h), and shares are rounded to 1/256 of a cell.
        EXPECT_NEAR(e[0], flap, (block ? 0.005 : 0.02) * flap);
        EXPECT_NEAR(e[1], bed, (block ? 0.005 : 0.02) * bed);
      }
}

// A flap of skin weighs as skin, and what it leaves as fat.
TEST(CopyLayers, EachPieceWeighsAsItsOwnLayers) {
  for (const bool block : {true, false})
    for (const double depth : {1.5, 2.0, 3.1}) {
      SCOPED_TRACE(testing::Message() << (block ? "block, " : "surface, ") << depth << " mm deep");
      CutSlab s(block, 5, {0.3, 0.6, 0.45});
      const double whole = s.mass_kg()[0];
      s.cut(sheet({-35, -35, -depth}, {70, 0, 0.001}, {0, 70, 0}, 14, 14));
      const std::vector<double> m = s.mass_kg();
      ASSERT_EQ(m.size(), 2u);
      const double flap = kSize_mm * kSize_mm * (kSkinDensity * kSkin_mm + kFatDensity * (depth - kSkin_mm)),
                   bed = kSize_mm * kSize_mm * kFatDensity * (kFat_mm + kSkin_mm - depth);
      EXPECT_NEAR(m[0], flap, (block ? 0.002 : 0.01) * flap);
      EXPECT_NEAR(m[1], bed, (block ? 0.002 : 0.01) * bed);
      EXPECT_NEAR(m[0] + m[1], whole, 5e-4 * whole);  // 1/512 of a fifth: what the rounded shares may change
    }
}

// Askew through skin and fat: both sides together have what there was, and each its own part.
TEST(CopyLayers, ALeaningCutPartsTheLayersWhereItMeetsThem) {
  const double lean = 1.2;  // mm aside a mm of depth
  for (const bool block : {true, false}) {
    SCOPED_TRACE(block ? "block" : "surface");
    CutSlab s(block, 5, {0.3, 0.6, 0.45});
    const double whole = s.shear()[0];
    s.cut(sheet({1 - 2 * lean, -35, 2}, {0, 70, 0}, {16 * lean, 0, -16}, 20, 5));
    const double middle = 1;
    std::vector<double> e = s.shear();
    ASSERT_EQ(e.size(), 2u);
    EXPECT_NEAR(e[0] + e[1], whole, 1e-3 * whole);
    // The part at smaller x: at depth z it reaches to middle + lean z.
    const auto part = [&](double from, double to) {  // mm^2 of its cross-section between two depths
      return (kSize_mm / 2 + middle) * (to - from) + 0.5 * lean * (to * to - from * from);
    };
    const double left = 0.5 * kSize_mm *
                        (shear_modulus(kSkinYoung_kPa) * part(0, kSkin_mm) +
                         shear_modulus(kFatYoung_kPa) * part(kSkin_mm, kSkin_mm + kFat_mm));
    const double nearest = std::abs(e[0] - left) < std::abs(e[1] - left) ? e[0] : e[1];
    EXPECT_NEAR(nearest, left, 0.01 * left);
  }
}

// An undermining that begins at an incision: the flap's cells have lost their bed, and what is round the corner is one
// piece with it.
TEST(CopyLayers, APieceRoundACornerHasItsOwnLayers) {
  CutSlab s(true, 5);
  s.cut(strip({{-0.4, -35}, {-0.4, 35}}, 3, -2.6));
  s.cut(sheet({-1.4, -35, -2.5}, {36, 0, 0}, {0, 70, 0}, 7, 14));
  const std::vector<double> e = s.shear();
  ASSERT_EQ(e.size(), 2u);
  const double flap = (kSize_mm / 2 + 0.4) * kSize_mm * shear_per_mm2(kSkin_mm, 1),
               whole = kSize_mm * kSize_mm * shear_per_mm2(kSkin_mm, kFat_mm);
  const double found = std::min(e[0], e[1]);
  EXPECT_NEAR(found, flap, 0.02 * flap);
  EXPECT_NEAR(e[0] + e[1], whole, 0.005 * whole);
}

TEST(CopyLayers, AnUprightIncisionLeavesTheMixture) {
  CutSlab s(true, 5);
  const size_t stencils = s.m->stencils.size();
  s.cut(strip({{0.3, -35}, {1.7, 35}}, 3, -20));
  EXPECT_EQ(s.m->stencils.size(), stencils);
  EXPECT_EQ(s.t->pieces, 2);
}

// A cut further on changes nothing of the copies that it does not touch, and those that it touches are as if all had
// been cut at once.
TEST(CopyLayers, AfterEachCutAsIfMadeAnew) {
  CutSlab s(false, 5, {0.3, 0.6, 0.45});
  s.cut(strip({{-14, -2}, {15, 3}}, 3, -3.3));
  s.cut(sheet({-12, -14, -2.2}, {24, 0, -0.3}, {0, 20, 0.2}, 8, 8));
  s.cut(strip({{2, -22}, {3, 20}}, 3, -4));
  s.cut(sheet({-5, 2, -3}, {18, 0, 0.2}, {0, 18, 0}, 6, 6));
  const MaterialSurface surface = material_surface(s.l.a);
  const auto again = assemble_fem(s.l.table, *s.t, nullptr, &surface);
  int mixed = 0;
  for (size_t c = 0; c < again->cells.size(); ++c) {
    EXPECT_EQ(again->cells[c], s.m->cells[c]) << c;
    mixed += s.m->cells[c].stencil != s.l.table.of_place(s.t->tree.place(s.t->grid, s.t->cells[c].cell));
  }
  EXPECT_GT(mixed, 30);
}

// What was taken out is not missed by what stays.
TEST(CopyLayers, WhatStaysAfterAnExcisionHasItsLayers) {
  CutSlab s(true, 5);
  s.cut(sheet({-35, -35, -2}, {70, 0, 0.001}, {0, 70, 0}, 14, 14));
  const auto& parts = s.l.a.components();
  int skin = 0;
  for (size_t i = 0; i < parts.size(); ++i)
    if (parts[i].volume_mm3 < parts[size_t(skin)].volume_mm3) skin = int(i);
  ASSERT_TRUE(s.l.a.excise(skin).done);
  const MaterialSurface surface = material_surface(s.l.a);
  const auto t = update_topology(*s.t, surface);
  s.m = assemble_fem(s.l.table, *t, nullptr, &surface), s.t = t;
  const double bed = kSize_mm * kSize_mm * shear_per_mm2(0, kFat_mm - 0.5);
  ASSERT_EQ(s.shear().size(), 1u);
  EXPECT_NEAR(s.shear()[0], bed, 0.02 * bed);
}

}  // namespace test_copy_layers
}  // namespace limberg::test
