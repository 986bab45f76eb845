// Bone as a solid: walls and cortices of known thickness under blur, networks of nodes with a known neck, cavities.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/imaging/solid/bone_parts.h"
#include "sim/imaging/solid/bone_solid.h"
#include "sim/imaging/solid/cortex_fit.h"
#include "sim/imaging/solid/even_grid.h"
#include "sim/imaging/solid/least_cut.h"
#include "sim/imaging/solid/wall_sheets.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"

namespace limberg {
namespace test_bone_solid {

using namespace imaging;

double step_up(double t, double blur) { return 0.5 * std::erfc(-t / (blur * std::sqrt(2.))); }

/// A volume of a function of places, with voxels of h.
template <class F>
Volume volume_of(const Vec3& low, const Vec3& high, double h, F&& f) {
  Volume v;
  for (size_t k = 0; k < 3; ++k) v.size[k] = int32_t((high - low)[Eigen::Index(k)] / h) + 1;
  v.step_mm = h * Mat3::Identity(), v.origin_mm = low;
  for (int32_t k = 0; k < v.size[2]; ++k)
    for (int32_t j = 0; j < v.size[1]; ++j)
      for (int32_t i = 0; i < v.size[0]; ++i) v.value.push_back(float(f(v.place(Vec3(i, j, k)))));
  return v;
}

TEST(Cortex, IsFoundWhereItIsUnderAnyBlur) {
  // Exactly the model: the answer is that of the numbers that went in, to the end of the iterations.
  for (const double blur : {0.4, 0.8, 1.5})
    for (const double thick : {0.8, 2., 5.})
      for (const double outer : {-0.7, 0., 0.9}) {
        std::vector<double> f;
        for (int i = -30; i <= 30; ++i) {
          const double t = 0.2 * i;
          f.push_back(450 + (1100 - 450) * step_up(t - outer + thick, blur) - (1100 - 45) * step_up(t - outer, blur));
        }
        const Cortex c = fit_cortex(f, 0.2, blur, 1100);
        ASSERT_TRUE(c.found) << blur << " " << thick;
        EXPECT_NEAR(c.outer_mm, outer, 0.02) << blur << " " << thick;
        if (thick > blur) {
          EXPECT_NEAR(c.outer_mm - c.inner_mm, thick, 0.05) << blur << " " << thick;
        }
      }
}

TEST(Cortex, IsFoundUnderABoxAsUnderANormalDistribution) {
  // The height of a slice is a box. Its profile by sums, not by the formula that is tested.
  for (const double box : {1., 3., 5.}) {
    const double sd = 0.6, outer = 0.4, thick = 3;
    std::vector<ProfileSample> f;
    for (double t = -7; t <= 7; t += 0.5) {
      double sum = 0;
      constexpr int kParts = 400;
      for (int k = 0; k < kParts; ++k) {
        const double x = t + box * ((k + 0.5) / kParts - 0.5);
        sum += 450 + (1100 - 450) * step_up(x - outer + thick, sd) - (1100 - 45) * step_up(x - outer, sd);
      }
      f.push_back({t, sum / kParts, 1});
    }
    const Cortex c = fit_cortex(f, {sd, box}, 1100);
    ASSERT_TRUE(c.found) << box;
    EXPECT_NEAR(c.outer_mm, outer, 0.02) << box;
    EXPECT_NEAR(c.outer_mm - c.inner_mm, thick, 0.05) << box;
    // A normal distribution of the same standard deviation is not the same.
    EXPECT_LT(c.rms, 1) << box;
  }
}

TEST(Cortex, InTallSlicesIsWhereItIsAllAround) {
  // A ball of bone with a cortex of 2 mm, in pixels of 1 mm and slices of 4: each voxel the mean of what it holds.
  InlineWorkers w;
  Volume fine = volume_of({-32, -32, -32}, {32, 32, 31}, 1, [&](const Vec3& x) {
    const double r = x.norm(), sd = 0.6;
    return 450 + (1100 - 450) * step_up(r - 18, sd) - (1100 - 45) * step_up(r - 20, sd);
  });
  Volume tall = fine;
  tall.size[2] = fine.size[2] / 4, tall.step_mm(2, 2) = 4, tall.origin_mm.z() += 1.5, tall.value.clear();
  for (int32_t k = 0; k < tall.size[2]; ++k)
    for (int32_t j = 0; j < fine.size[1]; ++j)
      for (int32_t i = 0; i < fine.size[0]; ++i) {
        float sum = 0;
        for (int32_t s = 0; s < 4; ++s) sum += fine.value[fine.index(i, j, 4 * k + s)] / 4;
        tall.value.push_back(sum);
      }
  simplex::Mesh m = simplex::make_sphere({0, 0, 0}, 21, 3);  // a millimetre outside of it
  const CortexReport r = put_on_cortex_in_slices(m, tall, {1000, 1100, 1200}, 0, w);
  EXPECT_GT(r.found, 0.95 * r.vertices);
  double upright = 0, flat = 0;
  for (const Vec3& x : m.x_mm) {
    double& most = std::abs(x.z()) < 0.5 * x.norm() ? upright : flat;
    most = std::max(most, std::abs(x.norm() - 20));
  }
  EXPECT_LT(upright, 0.3);  // the bar for a surface of the issue, in pixels of a millimetre,
  EXPECT_LT(flat, 1);       // and a quarter of a slice where they lie flat on it
}

TEST(Cortex, AnIsovalueIsOffByAMillimetreWhereTheModelIsNot) {
  // A thick cortex under the blur of 2 mm voxels: 250 HU lies outside it, half-way between the materials on it.
  const double blur = 1.2;
  std::vector<double> f;
  for (int i = -25; i <= 25; ++i) f.push_back(1100 - (1100 - 45) * step_up(0.2 * i, blur));
  double at_250 = 0;
  for (size_t i = 0; i + 1 < f.size(); ++i)
    if (f[i] >= 250 && f[i + 1] < 250) at_250 = 0.2 * (double(i) - 25 + (f[i] - 250) / (f[i] - f[i + 1]));
  EXPECT_GT(at_250, 0.9);
  EXPECT_NEAR(fit_cortex(f, 0.2, blur, 1100).outer_mm, 0, 0.02);
}

TEST(WallSheet, ThicknessAndPlaceAreThoseOfTheBlurredWall) {
  // A wall of 0.5 mm in soft tissue, blurred to 1.2 mm: its crest is 20 % of cortical bone.
  for (const double wall : {0.5, 1.}) {
    const double middle = 0.37, blur = 1.2;
    const Volume v = volume_of({-8, -8, -8}, {8, 8, 8}, 0.5, [&](const Vec3& x) {
      return 45 + (1100 - 45) * (step_up(x.z() - middle + wall / 2, blur) - step_up(x.z() - middle - wall / 2, blur));
    });
    const WallSheet s = wall_sheet(VolumeSampler(v), Vec3(0.1, 0.2, 0), Vec3::UnitZ(), 5, 1100);
    EXPECT_NEAR(s.thickness_mm, wall, 0.03);
    EXPECT_NEAR(s.middle_mm.z(), middle, 0.03);
    EXPECT_GT(s.contrast, 100);
  }
  // Nothing there: no wall.
  const Volume even = volume_of({-8, -8, -8}, {8, 8, 8}, 1, [](const Vec3&) { return 45.; });
  EXPECT_EQ(wall_sheet(VolumeSampler(even), Vec3::Zero(), Vec3::UnitZ(), 5, 1100).thickness_mm, 0);
}

TEST(LeastCut, GoesThroughTheNeck) {
  // Two cubes of 8 nodes with a bar of 2 x 2 between them: 4 ties are cut, wherever in the bar they are weakest.
  const GridSize n{26, 8, 8};
  std::vector<uint8_t> in(nodes(n), 0), a = in, b = in;
  const auto at = [&](int i, int j, int k) {
    return size_t(i) + size_t(n[0]) * (size_t(j) + size_t(n[1]) * size_t(k));
  };
  for (int i = 0; i < 26; ++i)
    for (int j = 0; j < 8; ++j)
      for (int k = 0; k < 8; ++k)
        if (i < 8 || i >= 18 || (j >= 3 && j < 5 && k >= 3 && k < 5)) in[at(i, j, k)] = 1;
  a[at(0, 0, 0)] = b[at(25, 7, 7)] = 1;
  const LeastCut c = least_cut(n, in, a, b, [&](size_t i, size_t j) {
    const auto x = node_at(n, i), y = node_at(n, j);
    return x[0] == 12 && y[0] == 13 ? 0.5 : 1.;
  });
  ASSERT_EQ(c.through.size(), 4u);
  for (const auto& [i, j] : c.through) {
    EXPECT_EQ(node_at(n, i)[0], 12);
    EXPECT_EQ(node_at(n, j)[0], 13);
  }
  int64_t first = 0;
  for (size_t i = 0; i < in.size(); ++i) first += c.first[i];
  EXPECT_EQ(first, 8 * 8 * 8 + 5 * 4);
}

/// A shell of bone, 8 mm thick, with radius 40 mm: diploe that is no bone by its density within, and a sinus.
Volume shell(double sinus_radius) {
  return volume_of({-52, -52, -52}, {52, 52, 52}, 1, [&](const Vec3& x) {
    const double r = x.norm();
    if (r > 50) return -1000.;
    double v = r < 40 && r > 32 ? 1100. : 45.;
    if (r < 37 && r > 35 && std::abs(x.z()) < 6 && x.x() > 0) v = 100;  // marrow, 2 mm wide
    if ((x - Vec3(0, 0, 36)).norm() < sinus_radius) v = -1000;
    return v;
  });
}

TEST(BoneSolid, MarrowIsFilledAndASinusStaysHollowBehindItsPassage) {
  InlineWorkers w;
  BoneSolidSettings s;
  s.sigma_voxels = 0, s.least_cavity_mm3 = 50, s.narrow_mm = 2;
  const BoneSolid b = bone_solid(shell(2.8), s, w);
  EXPECT_EQ(b.pieces, 1);
  EXPECT_GT(b.filled_mm3, 400);
  // The hollow of the shell itself (33 mm) and the sinus.
  ASSERT_EQ(b.cavity.size(), 2u);
  EXPECT_NEAR(b.cavity[0].volume_mm3, 4. / 3 * M_PI * 32 * 32 * 32, 0.06 * b.cavity[0].volume_mm3);
  EXPECT_LT((b.cavity[1].centre_mm - Vec3(0, 0, 36)).norm(), 1);
  // Bone is bounded by one closed surface: each hollow has its passage.
  const LevelSet surface = surface_of(b);
  LevelSetSettings q;
  q.grid_mm = b.step_mm, q.edge_mm = 4;
  LevelSetReport r;
  const simplex::Mesh m = mesh_level_set(surface, q, w, &r);
  EXPECT_EQ(r.dropped, 0);
  EXPECT_EQ(simplex::census(m).components, 1);
  EXPECT_EQ(simplex::find_fault(m).value_or(""), "");
}

TEST(BoneSolid, SaysWhatItCannotDo) {
  InlineWorkers w;
  const auto why = [&](const Volume& v, const BoneSolidSettings& s) {
    try {
      bone_solid(v, s, w);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  BoneSolidSettings s;
  EXPECT_NE(why(volume_of({0, 0, 0}, {9, 9, 9}, 1, [](const Vec3&) { return 40.; }), s).find("no bone"),
            std::string::npos);
  EXPECT_NE(why({}, s).find("empty"), std::string::npos);
  s.body = 300;
  EXPECT_NE(why(shell(0), s).find("above that of the body"), std::string::npos);
  // A shell has a hollow for a brain, but a block has none.
  s = {};
  const BoneSolid block = bone_solid(volume_of({-30, -30, -30}, {30, 30, 30}, 2,
                                               [](const Vec3& x) {
                                                 const double r = x.cwiseAbs().maxCoeff();
                                                 return r < 15 ? 1100. : r < 25 ? 45. : -1000.;
                                               }),
                                     s, w);
  EXPECT_THROW(part_bones(block, 250, w), InputError);
}

}  // namespace test_bone_solid
}  // namespace limberg
