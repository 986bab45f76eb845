// The anatomical head: distances, meshes, landmarks against what is published, occlusion, joints, colours.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "sim/base/error.h"
#include "sim/geometry/bvh.h"
#include "sim/imaging/anatomical/anatomical_head.h"
#include "sim/imaging/anatomical/bone_shape.h"
#include "sim/imaging/anatomical/norms.h"
#include "sim/imaging/anatomical/skin_colour.h"
#include "sim/imaging/fit/graded_grid.h"
#include "sim/measure/cephalometry.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {
namespace test_anatomical_head {

using anatomical::BoneShape;
using anatomical::SkinShape;

const SkinShape& skin() {
  static const SkinShape s;
  return s;
}
const BoneShape& bone() {
  static const BoneShape b(skin());
  return b;
}
std::map<std::string, Vec3> landmarks() {
  std::map<std::string, Vec3> out;
  for (const auto& [name, p] : anatomical_landmarks()) out[name] = p;
  return out;
}

struct Random {
  uint64_t s = 7;
  double operator()() {
    s = s * 6364136223846793005ull + 1442695040888963407ull;
    return double(s >> 11) / 9007199254740992.;
  }
  Vec3 in(const Vec3& low, const Vec3& high) {
    return low + Vec3((*this)(), (*this)(), (*this)()).cwiseProduct(high - low);
  }
};
const Vec3 kLow(-90, -100, -110), kHigh(90, 128, 130);

TEST(AnatomicalShape, BothSidesAreAlikeAndDistancesKeepTheirBound) {
  Random r;
  double worst_bone = 0, worst_skin = 0;
  for (int i = 0; i < 6000; ++i) {
    const Vec3 p = r.in(kLow, kHigh), other(-p.x(), p.y(), p.z());
    EXPECT_EQ(skin()(p), skin()(other));
    EXPECT_EQ(bone().skull(p), bone().skull(other));
    const Vec3 q = p + 0.5 * (Vec3(r(), r(), r()) - Vec3::Constant(0.5));
    const double l = (q - p).norm();
    if (std::abs(skin()(p)) < 10) worst_skin = std::max(worst_skin, std::abs(skin()(p) - skin()(q)) / l);
    if (std::abs(bone().skull(p)) < 10)
      worst_bone = std::max(worst_bone, std::abs(bone().skull(p) - bone().skull(q)) / l);
  }
  EXPECT_LT(worst_skin, SkinShape::kLipschitz);
  EXPECT_LT(worst_bone, BoneShape::kLipschitz);
}

TEST(AnatomicalShape, SkinLiesOverBoneEverywhere) {
  Random r;
  double thinnest = 1e9;
  int inside = 0;
  for (int i = 0; i < 40000; ++i) {
    const Vec3 p = r.in(kLow, kHigh);
    if (std::min(bone().skull(p), bone().mandible(p)) < 0) thinnest = std::min(thinnest, -skin()(p)), ++inside;
  }
  EXPECT_GT(inside, 2000);
  EXPECT_GT(thinnest, 1.5);
}

TEST(AnatomicalShape, TheCondyleHasRoomInItsFossaAndTeethMeetWithoutOverlap) {
  Random r;
  double joint = 1e9, teeth = 1e9;
  for (int i = 0; i < 30000; ++i) {
    const Vec3 p = r.in({38, -2, -22}, {62, 26, 2});
    if (bone().mandible(p) < 0) joint = std::min(joint, bone().skull(p));
    const Vec3 q = r.in({-30, 45, -62}, {30, 100, -44});
    if (bone().lower_teeth(q) < 0) teeth = std::min(teeth, bone().upper_teeth(q));
  }
  EXPECT_GT(joint, 1.2);
  EXPECT_LT(joint, 3.0) << "the condyle lies in the fossa";
  EXPECT_GT(teeth, 0.2);
  EXPECT_LT(teeth, 0.6) << "they meet";
}

TEST(AnatomicalShape, HollowsAreWhereTheyShouldBe) {
  const auto hollow = [](const Vec3& p) { return bone().skull(p) > 1; };
  EXPECT_TRUE(hollow({0, 2, 60})) << "braincase";
  EXPECT_TRUE(hollow({31, 75, 15})) << "orbit";
  EXPECT_TRUE(hollow({0, 75, -16})) << "nose";
  EXPECT_TRUE(hollow({23.5, 62, -17})) << "maxillary sinus";
  EXPECT_TRUE(hollow({9, 87.6, 33})) << "frontal sinus";
  EXPECT_TRUE(hollow({0, -24, -18})) << "foramen magnum";
  EXPECT_LT(bone().skull({9, 92.3, 33}), -0.2) << "outer wall of the frontal sinus";
  EXPECT_LT(bone().skull({23.5, 62, -4.2}), -0.2) << "floor of the orbit";
}

TEST(AnatomicalLandmarks, LieOnTheirSurfacesAndInPairs) {
  const auto at = landmarks();
  EXPECT_GE(at.size(), 60u);
  for (const LandmarkRule& rule : anatomical_landmark_rules()) {
    const std::string name = rule.pair ? std::string(rule.name) + "_R" : rule.name;
    ASSERT_TRUE(at.count(name)) << name << " is met by no ray";
    const Vec3 p = at.at(name);
    const double d = rule.surface == LandmarkRule::Surface::skin       ? skin()(p)
                     : rule.surface == LandmarkRule::Surface::mandible ? bone().mandible(p)
                                                                       : bone().skull(p);
    EXPECT_NEAR(d, 0, 1e-6) << name;
    if (rule.pair) {
      const Vec3 l = at.at(std::string(rule.name) + "_L");
      EXPECT_LT((Vec3(-l.x(), l.y(), l.z()) - p).norm(), 1e-6) << name;
    }
  }
}

TEST(AnatomicalLandmarks, ProportionsAreWithinOneStandardDeviationOfWhatIsPublished) {
  const auto at = landmarks();
  for (const anatomical::Norm& n : anatomical::norms()) {
    const double mm = (at.at(n.a) - at.at(n.b)).norm();
    EXPECT_NEAR(mm, n.mm, n.sd) << n.name << " (" << n.source << ")";
  }
  std::vector<NamedPoint> points;
  for (const auto& [name, p] : at) points.push_back({name, p, 0});
  int judged = 0;
  for (const CephalometricRow& row : cephalometry(points)) {
    ASSERT_TRUE(row.value) << row.measure->name;
    if (!row.measure->norm || !row.measure->norm_sd) continue;
    EXPECT_NEAR(*row.value, *row.measure->norm, *row.measure->norm_sd) << row.measure->name;
    ++judged;
  }
  EXPECT_GE(judged, 15);
}

/// Edges that go through another triangle, by signs of volumes; triangles that share a corner are left out.
bool pierces(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q, const Vec3& r) {
  const auto volume = [](const Vec3& x, const Vec3& y, const Vec3& z, const Vec3& w) {
    return (y - x).cross(z - x).dot(w - x);
  };
  if (volume(p, q, r, a) * volume(p, q, r, b) >= 0) return false;
  const double u = volume(a, b, p, q), v = volume(a, b, q, r), w = volume(a, b, r, p);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}
/// Triangles of the drawn fans that cross another one.
size_t crossing(const simplex::Mesh& m) {
  const simplex::FanTriangles f = simplex::fan_triangles(m);
  constexpr double kCell_mm = 3;
  std::map<std::array<int, 3>, std::vector<size_t>> cells;
  const auto cell = [&](double x) { return int(std::floor(x / kCell_mm)); };
  for (size_t t = 0; t < f.tri.size(); ++t) {
    Vec3 low = f.X_mm[size_t(f.tri[t][0])], high = low;
    for (const int32_t v : f.tri[t]) low = low.cwiseMin(f.X_mm[size_t(v)]), high = high.cwiseMax(f.X_mm[size_t(v)]);
    for (int i = cell(low.x()); i <= cell(high.x()); ++i)
      for (int j = cell(low.y()); j <= cell(high.y()); ++j)
        for (int k = cell(low.z()); k <= cell(high.z()); ++k) cells[{i, j, k}].push_back(t);
  }
  std::set<size_t> bad;
  for (const auto& [at, all] : cells)
    for (size_t i = 0; i < all.size(); ++i)
      for (size_t j = i + 1; j < all.size(); ++j) {
        const Tri &A = f.tri[all[i]], &B = f.tri[all[j]];
        bool shared = false, hit = false;
        for (const int32_t x : A) shared |= std::find(B.begin(), B.end(), x) != B.end();
        const auto X = [&](const Tri& t, size_t k) { return f.X_mm[size_t(t[k % 3])]; };
        for (size_t k = 0; k < 3 && !shared && !hit; ++k)
          hit = pierces(X(A, k), X(A, k + 1), X(B, 0), X(B, 1), X(B, 2)) ||
                pierces(X(B, k), X(B, k + 1), X(A, 0), X(A, 1), X(A, 2));
        if (hit) bad.insert({all[i], all[j]});
      }
  return bad.size();
}

// Where a wall is thinner than the edges, or between two teeth, flat faces may still cross: bars of what is there. One
// test with all that needs the meshes: they take long to make.
TEST(AnatomicalMeshes, AreClosedLieOnTheSurfaceAndHardlyMeetThemselvesOrEachOther) {
  InlineWorkers w;
  const HeadModel h = make_anatomical_head({}, w);
  struct Part {
    const char* name;
    const simplex::Mesh& mesh;
    const LevelSetReport& report;
    double least_cm3, most_cm3;
    int64_t ends, genus;
    double crossing;
  };
  for (const Part& p : {Part{"cranium", h.cranium, h.cranium_report, 450, 1000, 0, -1, 0.01},
                        Part{"mandible", h.mandible, h.mandible_report, 40, 110, 0, -1, 0.02},
                        Part{"face", h.face, h.face_report, 3500, 5500, 1, 0, 0.002}}) {
    SCOPED_TRACE(p.name);
    EXPECT_LT(p.report.rms_mm, 0.02);
    EXPECT_FALSE(simplex::find_fault(p.mesh)) << "a closed, oriented surface";
    const simplex::Census c = simplex::census(p.mesh);
    EXPECT_EQ(c.end_contours, p.ends);
    if (p.genus >= 0) {
      EXPECT_EQ(c.genus, p.genus);
    }
    const double cm3 = 1e-3 * simplex::extent(p.mesh).volume_mm3;
    EXPECT_GT(cm3, p.least_cm3);
    EXPECT_LT(cm3, p.most_cm3);
    EXPECT_LT(double(crossing(p.mesh)), p.crossing * double(simplex::fan_triangles(p.mesh).tri.size()));
  }
  EXPECT_LT(h.cranium.vertices() + h.mandible.vertices() + h.face.vertices(), 45000);

  const simplex::FanTriangles skull = simplex::fan_triangles(h.cranium);
  const Bvh at(skull.X_mm, skull.tri);
  double least = 1e9;
  for (int32_t v = 0; v < h.mandible.slots(); ++v)
    if (h.mandible.alive(v)) least = std::min(least, at.closest(h.mandible.x_mm[size_t(v)], 20).distance_mm);
  EXPECT_GT(least, 0.05) << "the mandible touches the skull";
  EXPECT_LT(least, 1.0) << "teeth meet";
}

TEST(GradedGrid, IsAManifoldThatIsFineWhereItShouldBe) {
  InlineWorkers w;
  const LevelSet ball{[](const Vec3& p) { return (p - Vec3(1, 2, 3)).norm() - 30; }, 1, {-40, -40, -40}, {45, 45, 45}};
  std::vector<Vec3> X;
  std::vector<Tri> T;
  march_graded(
      ball, [](const Vec3& p) { return p.x() > 0 ? 1. : 6.; }, w, X, T);
  EXPECT_NO_THROW(simplex::from_triangles(X, T));
  double area = 0, fine = 0, coarse = 0;
  int fines = 0, coarses = 0;
  for (const Tri& t : T) {
    const Vec3 a = X[size_t(t[0])], b = X[size_t(t[1])], c = X[size_t(t[2])];
    const double s = 0.5 * (b - a).cross(c - a).norm();
    area += s;
    if (a.x() > 12) fine += s, ++fines;
    if (a.x() < -12) coarse += s, ++coarses;
  }
  EXPECT_NEAR(area, 4 * M_PI * 900, 0.01 * 4 * M_PI * 900);
  EXPECT_LT(12 * fine / fines, coarse / coarses);
  EXPECT_THROW(march_graded(
                   {ball.distance_mm, 1, {0, 0, 0}, {0, 1, 1}}, [](const Vec3&) { return 1.; }, w, X, T),
               InputError);
}

TEST(AnatomicalColour, EyesLipsHairAndTeethHaveTheirColours) {
  const auto light = [](const Vec3& c) { return c.sum() / 3; };
  const Vec3 cheek = anatomical::skin_colour({30, 85, -30}), pupil = anatomical::skin_colour({31.5, 84.6, 15.1}),
             white = anatomical::skin_colour({40, 80, 15}), lip = anatomical::skin_colour({0, 108, -60}),
             scalp = anatomical::skin_colour({0, 0, 128}), forehead = anatomical::skin_colour({0, 99, 55});
  EXPECT_LT(light(pupil), 0.1);
  EXPECT_GT(light(white), light(cheek));
  EXPECT_GT(lip.x() / lip.y(), 1.1 * cheek.x() / cheek.y()) << "redder than a flushed cheek, whatever the light";
  EXPECT_LT(light(scalp), 0.5 * light(forehead));
  EXPECT_EQ(anatomical::colour_on_bone({0, 0, 124})[3], 0);
  const Vec3 edge = landmarks().at("Is");
  EXPECT_GT(anatomical::colour_on_bone(edge)[3], 200);
}

TEST(AnatomicalHead, RefusesEdgesThatMakeNoSense) {
  InlineWorkers w;
  EXPECT_THROW(make_anatomical_head({.edge_mm = 0.2}, w), InputError);
}

}  // namespace test_anatomical_head
}  // namespace limberg
