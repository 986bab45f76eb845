// Tissue between a face and a skull.
#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>
#include <thread>

#include "sim/base/error.h"
#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"
#include "sim/skull/simplex/motion.h"
#include "sim/skull/simplex/tissue.h"

namespace limberg::simplex {
namespace test_tissue {

struct Head {
  Mesh face = make_sphere({0, 0, 0}, 60, 3), skull = make_sphere_of_faces({0, 0, 0}, 48, 600);
  std::vector<int32_t> region;
  explicit Head(double radius = 22) { region = region_around(face, 5, radius); }
  TissueResult tissue(int layers, double young_kPa = 10) const {
    InlineWorkers w;
    TissueSettings s;
    s.layers = layers, s.young_kPa = young_kPa;
    return build_tissue(face, region, skull, {}, s, w);
  }
};

double volume(const Tissue& t) {
  double sum = 0;
  for (const auto& q : t.tet) {
    const Vec3 &a = t.node_mm[size_t(q[0])], &b = t.node_mm[size_t(q[1])], &c = t.node_mm[size_t(q[2])],
               &d = t.node_mm[size_t(q[3])];
    const double v = (b - a).cross(c - a).dot(d - a) / 6;
    EXPECT_GT(v, 0);
    sum += v;
  }
  return sum;
}

TEST(Tissue, EveryVertexHasFourNeighbours) {
  const Head head;
  for (int k : {1, 2, 3, 5}) {
    const TissueResult r = head.tissue(k);
    ASSERT_TRUE(r) << r.reason;
    const Tissue& t = r.tissue;
    EXPECT_EQ(find_fault(t).value_or(""), "");
    const int64_t T = int64_t(head.region.size());
    EXPECT_EQ(int64_t(t.tet.size()), 3 * k * T);
    EXPECT_EQ(int64_t(t.link.size()), T);
    EXPECT_EQ(int64_t(t.anchor.size()), T);
    const int64_t side = std::count(t.role.begin(), t.role.end(), TissueRole::side);
    EXPECT_EQ(side % (2 * k), 0);  // two triangles per layer and border edge
    EXPECT_EQ(t.vertices(), 3 * k * T + 2 * T + side);
    // A shell between the radii 48 and 60 over the cap's solid angle: 0.49 of the face's prism.
    double outer = 0;
    for (int32_t v : head.region) outer += 0.5 * head.face.frame(v).area2_mm2;
    EXPECT_GT(volume(t), 0.5 * outer * 12 / 4);
    for (size_t v = 0; v < t.role.size(); ++v) {
      const double R = t.x_mm[v].norm();
      EXPECT_GT(R, 46);
      EXPECT_LT(R, 60.01);
    }
    for (const auto& [v, f] : t.link) EXPECT_EQ(t.x_mm[size_t(v)], head.face.x_mm[size_t(f)]);
  }
}

TEST(Tissue, TheConstructionDoesNotDependOnTheOrderOfTheRegion) {
  Head head;
  const Tissue a = head.tissue(2).tissue;
  std::reverse(head.region.begin(), head.region.end());
  const Tissue b = head.tissue(2).tissue;
  EXPECT_EQ(a.tet.size(), b.tet.size());
  EXPECT_NEAR(volume(a), volume(b), 1e-9 * volume(a));
}

// A circle drawn on a ball holds what lies within its cone on that side, whichever way round it is drawn.
TEST(Tissue, ADrawnRegionIsWhatTheLineEncloses) {
  const Mesh ball = make_sphere({5, 0, 0}, 60, 4);
  const double half_deg = 25;
  std::vector<Vec3> circle;
  const Vec3 axis = Vec3(1, 2, 1).normalized(), e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
  for (int i = 0; i < 90; ++i) {
    const double a = i * M_PI / 45, h = half_deg * M_PI / 180;
    circle.push_back(Vec3(5, 0, 0) + 60 * (std::cos(h) * axis + std::sin(h) * (std::cos(a) * e1 + std::sin(a) * e2)));
  }
  const std::vector<Vec3> other_way(circle.rbegin(), circle.rend());
  for (const auto& line : {circle, other_way}) {
    const std::vector<int32_t> region = region_within(ball, line);
    std::vector<uint8_t> in(ball.nbr.size(), 0);
    for (const int32_t v : region) in[size_t(v)] = 1;
    EXPECT_GT(region.size(), 20u);
    for (int32_t v = 0; v < ball.slots(); ++v) {
      const double deg = std::acos((ball.x_mm[size_t(v)] - Vec3(5, 0, 0)).normalized().dot(axis)) * 180 / M_PI;
      EXPECT_TRUE(std::abs(deg - half_deg) < 0.5 || bool(in[size_t(v)]) == (deg < half_deg)) << deg;
    }
  }
  // Concave: an L of two arms leaves out the corner between them.
  const Mesh sheet = make_plane(60, 60, 3);
  const std::vector<Vec3> l{{-20, -20, 0}, {20, -20, 0}, {20, -10, 0}, {-10, -10, 0}, {-10, 20, 0}, {-20, 20, 0}};
  Vec3 centre = Vec3::Zero();
  for (const Vec3& x : sheet.x_mm) centre += x / double(sheet.x_mm.size());
  std::vector<Vec3> there;
  for (const Vec3& x : l) there.push_back(x + centre);
  const std::vector<int32_t> arms = region_within(sheet, there);
  EXPECT_GT(arms.size(), 20u);
  for (const int32_t v : arms) {
    const Vec3 x = sheet.x_mm[size_t(v)] - centre;
    EXPECT_TRUE(x.x() <= -10 || x.y() <= -10) << x.transpose();
  }
  EXPECT_TRUE(region_within(sheet, std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}}).empty());
  EXPECT_TRUE(region_within(sheet, std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}).empty()) << "a line of no width";
  EXPECT_TRUE(region_within(sheet, std::vector<Vec3>{{900, 0, 0}, {901, 0, 0}, {900, 1, 0}}).empty());
}

TEST(Tissue, RegionsThatCannotBeAreRefusedWithReasons) {
  Head head;
  InlineWorkers w;
  TissueSettings s;
  const auto reason = [&](const std::vector<int32_t>& region, const Mesh& face, const Mesh& skull) {
    return build_tissue(face, region, skull, {}, s, w).reason;
  };
  std::vector<int32_t> all;
  for (int32_t v = 0; v < head.face.slots(); ++v) all.push_back(v);
  EXPECT_NE(reason(all, head.face, head.skull).find("whole surface"), std::string::npos);
  EXPECT_NE(reason({}, head.face, head.skull).find("empty"), std::string::npos);
  EXPECT_NE(reason({3, 99999}, head.face, head.skull).find("does not exist"), std::string::npos);
  EXPECT_NE(reason({3, 3}, head.face, head.skull).find("twice"), std::string::npos);
  std::vector<int32_t> two = head.region;
  for (int32_t v : region_around(head.face, 700, 15)) two.push_back(v);
  EXPECT_NE(reason(two, head.face, head.skull).find("parts"), std::string::npos);
  EXPECT_NE(reason(head.region, head.face, make_sphere({900, 0, 0}, 10, 2)).find("farther"), std::string::npos);
  const Mesh sheet = make_plane(60, 60, 4);
  EXPECT_NE(reason(region_around(sheet, end_contours(sheet)[0].rim[0], 15), sheet, head.skull).find("hole"),
            std::string::npos);
  s.layers = 0;
  EXPECT_NE(reason(head.region, head.face, head.skull).find("layers"), std::string::npos);
  s.layers = 1, s.young_kPa = NAN;
  EXPECT_NE(reason(head.region, head.face, head.skull).find("stiffness"), std::string::npos);
}

TEST(Springs, LawsAreContinuousAndStiffen) {
  for (Stiffening kind : {Stiffening::none, Stiffening::biphasic, Stiffening::quadratic, Stiffening::exponential}) {
    SpringLaw law;
    law.kind = kind;
    const double l0 = 4, h = 1e-6;
    EXPECT_EQ(law.force_over_k0(l0, l0), 0);
    EXPECT_NEAR((law.force_over_k0(l0 + h, l0) - law.force_over_k0(l0 - h, l0)) / (2 * h), 1, 1e-4);
    for (double l = 2; l < 8; l += 0.01) {
      const double slope = (law.force_over_k0(l + h, l0) - law.force_over_k0(l - h, l0)) / (2 * h);
      EXPECT_GT(slope, 0);
      EXPECT_TRUE(std::abs(l - l0 * 1.15) < 1e-3 || slope <= law.tangent_over_k0(l, l0) * (1 + 1e-4)) << l;
    }
    const double at20 = law.force_over_k0(1.2 * l0, l0), at40 = law.force_over_k0(1.4 * l0, l0);
    EXPECT_GE(at40, (kind == Stiffening::none ? 2 - 1e-12 : 2.2) * at20);
  }
}

TEST(Springs, AtRestNothingMovesAndNothingPulls) {
  const Head head;
  InlineWorkers w;
  Tissue t = head.tissue(3).tissue;
  TissueLaw law;
  for (int i = 0; i < 20; ++i) EXPECT_LT(step(t, law, w).max_move_mm, 1e-12);
  std::vector<Vec3> pull(head.face.x_mm.size(), Vec3::Zero()), mN = pull;
  pull_face(t, law, pull, &mN);
  for (const Vec3& f : mN) EXPECT_LT(f.norm(), 1e-9);
}

/// How far the middle of the region moves along the normal, and across it, when the skull moves by `out_mm`.
std::pair<double, double> follows(double out_mm, double shape) {
  Head head;
  InlineWorkers w;
  Tissue t = head.tissue(2).tissue;
  const Mesh before = head.face;
  const Vec3 out = head.face.x_mm[5].normalized();
  for (Vec3& x : head.skull.x_mm) x += out_mm * out;
  record_shape(head.face);
  // The far side of the face is held.
  for (size_t v = 0; v < head.face.x_mm.size(); ++v)
    if (head.face.x_mm[v].dot(out) < 0) head.face.flags[v] |= kLocked;
  Law law;
  law.zone[0] = {Constraint::shape, 0.2, 0.9, 1, false};
  law.external_stiffness = 2;
  Motion motion(w);
  EXPECT_TRUE(motion.set_law(law));
  TissueLaw springs;
  springs.shape = shape;
  std::vector<Vec3> pull(head.face.x_mm.size());
  StepReport r;
  for (int i = 0; i < 3000; ++i) {
    follow(t, head.face, head.skull);
    if (i % 8 == 0) turn_shape(t, w);
    step(t, springs, w);
    std::fill(pull.begin(), pull.end(), Vec3::Zero());
    pull_face(t, springs, pull);
    r = motion.step(head.face, {pull, {}});
  }
  EXPECT_LT(r.max_move_mm, 0.01);
  for (size_t v = 0; v < before.x_mm.size(); ++v)
    EXPECT_TRUE(before.x_mm[v].dot(out) >= 0 || head.face.x_mm[v] == before.x_mm[v]);
  const Vec3 moved = head.face.x_mm[5] - before.x_mm[5];
  return {moved.dot(out), (moved - moved.dot(out) * out).norm()};
}

TEST(Springs, TheFaceFollowsTheSkull) {
  const auto [back, across] = follows(-4, 0);    // springs pull
  const auto [forth, beside] = follows(4, 0.5);  // springs whose inside keeps its shape push
  std::printf("skull back 4 mm, springs: %.2f mm (%.2f across); forth 4 mm, half shape: %.2f mm (%.2f across)\n", back,
              across, forth, beside);
  EXPECT_LT(back, -0.4);
  EXPECT_GT(back, -4.1);
  EXPECT_GT(forth, 0.4);
  EXPECT_LT(forth, 4.1);
  EXPECT_LT(across, 1);
  EXPECT_LT(beside, 1);
}

TEST(ShapeMode, IsExactForRigidMotionsEvenByHalfATurn) {
  // Ends are put where a rigid motion takes them; what lies between finds its place by itself, from where it was.
  for (double degrees : {25., 90., 180.}) {
    Head head(14);
    InlineWorkers w;
    Tissue t = head.tissue(2).tissue;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translate(Vec3(3, -8, 5)).rotate(Eigen::AngleAxisd(degrees * M_PI / 180, Vec3(2, 1, -0.5).normalized()));
    const std::vector<Vec3> rest = t.x_mm;
    for (size_t v = 0; v < rest.size(); ++v)
      if (t.role[v] == TissueRole::face || t.role[v] == TissueRole::skull) t.x_mm[v] = T * rest[v];
    TissueLaw law;
    law.mode = TissueKind::shape;
    for (int i = 0; i < 4000; ++i) {
      if (i % 4 == 0) turn_shape(t, w);
      step(t, law, w);
    }
    double far = 0;
    for (size_t v = 0; v < rest.size(); ++v) far = std::max(far, (t.x_mm[v] - T * rest[v]).norm());
    EXPECT_LT(far, 1e-9) << degrees;
    std::vector<Vec3> pull(head.face.x_mm.size(), Vec3::Zero());
    turn_shape(t, w);
    pull_face(t, law, pull);
    for (const Vec3& f : pull) EXPECT_LT(f.norm(), 1e-9);  // and nothing pulls the face
  }
}

TEST(ShapeMode, SmallDisplacementsAreHarmonicInTheConductances) {
  // To first order the turns do not matter: what the ends do is passed on as by Laplace's equation with k for
  // conductances, up to the part that turns add. Equal shifts of all ends are passed on whole, and a stiffer layer
  // follows its own end more.
  Head head(16);
  InlineWorkers w;
  TissueSettings s;
  s.layers = 3, s.young_kPa = 10;
  const auto follows = [&](double skin_kPa) {
    s.skin_kPa = skin_kPa;
    Tissue t = build_tissue(head.face, head.region, head.skull, {}, s, w).tissue;
    const Vec3 by = 0.01 * head.face.x_mm[5].normalized();
    const std::vector<Vec3> rest = t.x_mm;
    for (size_t v = 0; v < rest.size(); ++v)
      if (t.role[v] == TissueRole::face) t.x_mm[v] += by;
    TissueLaw law;
    law.mode = TissueKind::shape;
    for (int i = 0; i < 3000; ++i) {
      if (i % 8 == 0) turn_shape(t, w);
      step(t, law, w);
    }
    double mean = 0;
    int64_t n = 0;
    for (size_t v = 0; v < rest.size(); ++v)
      if (t.role[v] == TissueRole::inside) mean += (t.x_mm[v] - rest[v]).dot(by) / by.squaredNorm(), ++n;
    return mean / double(n);
  };
  const double even = follows(0), skinned = follows(200);
  EXPECT_GT(even, 0.3);
  EXPECT_LT(even, 0.7);
  EXPECT_GT(skinned, even + 0.05);
}

TEST(ZeroModes, AreTheKernelOfTheStiffnessMatrixOfTheSpringsThatRun) {
  // The forces of the law that is stepped, differentiated: at rest
  // their stiffness matrix has as many zero eigenvalues as are counted.
  const Head head(9);
  InlineWorkers w;
  for (int k : {1, 2}) {
    Tissue t = head.tissue(k).tissue;
    std::vector<size_t> at;
    for (size_t v = 0; v < t.role.size(); ++v)
      if (t.role[v] == TissueRole::inside || t.role[v] == TissueRole::side) at.push_back(v);
    const Eigen::Index n = Eigen::Index(3 * at.size());
    // One iteration from rest, undamped and of a small step, moves
    // each vertex by alpha D^-1 F: the matrix D^-1 K by differences.
    TissueLaw law;
    law.spring.kind = Stiffening::none, law.alpha = 1;
    const std::vector<Vec3> rest = t.x_mm;
    const auto moves = [&](const std::vector<Vec3>& x) {
      t.x_mm = x, t.before_mm = x;
      step(t, law, w);
      Eigen::VectorXd d(n);
      for (size_t i = 0; i < at.size(); ++i) d.segment<3>(Eigen::Index(3 * i)) = t.x_mm[at[i]] - x[at[i]];
      return d;
    };
    Eigen::MatrixXd K(n, n);
    constexpr double h = 1e-5;
    for (Eigen::Index j = 0; j < n; ++j) {
      std::vector<Vec3> plus = rest, minus = rest;
      plus[at[size_t(j / 3)]][j % 3] += h, minus[at[size_t(j / 3)]][j % 3] -= h;
      K.col(j) = (moves(minus) - moves(plus)) / (2 * h);
    }
    t.x_mm = rest;
    const Eigen::VectorXd sizes = K.bdcSvd().singularValues();
    const int64_t zero = (sizes.array() < 1e-8 * sizes[0]).count();
    const ZeroModes z = zero_energy_modes(t);
    EXPECT_EQ(z.dofs, int64_t(n));
    EXPECT_EQ(zero, z.modes) << k << " layers";
    EXPECT_GT(z.modes, 0);
    // With a share of the shape force none is left.
    law.shape = 0.2;
    turn_shape(t, w);
    for (Eigen::Index j = 0; j < n; ++j) {
      std::vector<Vec3> plus = rest, minus = rest;
      plus[at[size_t(j / 3)]][j % 3] += h, minus[at[size_t(j / 3)]][j % 3] -= h;
      K.col(j) = (moves(minus) - moves(plus)) / (2 * h);
    }
    EXPECT_GT(K.bdcSvd().singularValues().minCoeff(), 1e-4);
  }
}

TEST(ZeroModes, SpringsLeaveMostOfTheTissueFree) {
  const Head head(16);
  const double lo[] = {0.5, 0.7, 0.8}, hi[] = {0.8, 0.9, 0.95};  // 0.64, 0.82, 0.88 for a patch of 36 triangles
  for (int k : {1, 2, 3}) {
    const Tissue t = head.tissue(k).tissue;
    const ZeroModes z = zero_energy_modes(t);
    EXPECT_GE(z.modes, z.dofs - z.springs);
    const double part = double(z.modes) / (double(z.dofs) / 3);
    std::printf("%d layers: %lld of %lld modes, %.2f per free vertex\n", k, static_cast<long long>(z.modes),
                static_cast<long long>(z.dofs), part);
    EXPECT_GT(part, lo[k - 1]);
    EXPECT_LT(part, hi[k - 1]);
  }
}

TEST(Stiffness, BoundHoldsUnderLargeElongation) {
  Head head;
  InlineWorkers w;
  for (Stiffening kind : {Stiffening::biphasic, Stiffening::quadratic, Stiffening::exponential}) {
    Tissue t = head.tissue(2).tissue;
    TissueLaw law;
    law.spring.kind = kind, law.alpha = 1e6;
    Mesh skull = head.skull;
    for (Vec3& x : skull.x_mm) x *= 0.6;  // elongated two and a half times
    follow(t, head.face, skull);
    TissueStep s;
    for (int i = 0; i < 800; ++i) {
      s = step(t, law, w);
      ASSERT_LT(s.max_move_mm, 30);
    }
    EXPECT_LT(s.alpha, 2);
    EXPECT_LT(s.max_move_mm, 0.5);
    EXPECT_GT(s.longest_elongation, 0.3);
  }
  Tissue t = head.tissue(1).tissue;
  TissueLaw bad;
  bad.gamma = 2;
  EXPECT_THROW(step(t, bad, w), InputError);
  bad = {};
  bad.spring.ratio = 0.5;
  EXPECT_THROW(step(t, bad, w), InputError);
  bad = {};
  bad.mode = TissueKind::finite_elements;
  EXPECT_THROW(step(t, bad, w), InputError);
}

}  // namespace test_tissue
}  // namespace limberg::simplex
