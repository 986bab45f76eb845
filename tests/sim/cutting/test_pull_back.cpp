// A blade's angle held in the deformed state, at rest.
#include <Eigen/Geometry>
#include <random>

#include "sim/cutting/strokes/pull_back.h"
#include "tests/sim/cutting/patient.h"

namespace limberg::test {
namespace test_pull_back {

struct Frame {
  Vec3 normal, along;
};

Frame random_frame(std::mt19937& g) {
  std::normal_distribution<double> n;
  const Vec3 a = Vec3(n(g), n(g), n(g)).normalized(), b = Vec3(n(g), n(g), n(g));
  return {a, (b - b.dot(a) * a).normalized()};
}

TEST(PullBack, AtRestAndTurnedItIsTheAngleItself) {
  std::mt19937 g(3);
  std::uniform_real_distribution<double> u(-3, 3);
  for (int i = 0; i < 50; ++i) {
    const Frame f = random_frame(g);
    const double lean = 0.8 * u(g);
    const Vec3 expected = lean * f.along.cross(f.normal);
    EXPECT_EQ(aside_at_rest(Mat3::Identity(), f.normal, f.along, lean), expected);
    const Mat3 R = Eigen::AngleAxisd(u(g), random_frame(g).normal).toRotationMatrix();
    EXPECT_LT((aside_at_rest(R, f.normal, f.along, lean) - expected).norm(), 1e-9);
    // Turned over itself: inverted tissue counts as its rotation.
    Mat3 inverted = R;
    inverted.col(2) = -inverted.col(2);
    const Vec3 v = aside_at_rest(inverted, f.normal, f.along, lean);
    EXPECT_TRUE(v.allFinite());
    EXPECT_NEAR(v.dot(f.normal), 0, 1e-9);
  }
}

TEST(PullBack, HoldsItsAngleInTheDeformedState) {
  std::mt19937 g(5);
  std::normal_distribution<double> n;
  int held = 0;
  for (int i = 0; i < 400; ++i) {
    const Frame f = random_frame(g);
    Mat3 F = Mat3::Identity();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) F(r, c) += 0.25 * n(g);
    const double lean = 0.7 * n(g);
    const Vec3 aside = aside_at_rest(F, f.normal, f.along, lean);
    ASSERT_TRUE(aside.allFinite());
    EXPECT_NEAR(aside.dot(f.normal), 0, 1e-9);
    EXPECT_LE(aside.norm(), kMostAside + 1e-9);
    const Eigen::JacobiSVD<Mat3> svd(F);
    if (F.determinant() <= 0 || svd.singularValues()[0] > kConditionLimit * svd.singularValues()[2] ||
        aside.norm() > kMostAside - 1e-9)
      continue;
    const Vec3 d = F * (aside - f.normal), normal = (F.inverse().transpose() * f.normal).normalized(),
               right = (F * f.along).cross(normal).normalized();
    EXPECT_NEAR(d.dot(right), lean * -d.dot(normal), 1e-9 * d.norm());
    EXPECT_NEAR(d.dot((F * f.along).normalized()), 0, 1e-9 * d.norm());
    ++held;
  }
  EXPECT_GT(held, 200);
}

TEST(PullBack, ClosedForms) {
  const Vec3 normal = Vec3::UnitZ(), along = Vec3::UnitX();  // right: -y
  const double lean = 0.5;
  EXPECT_LT((aside_at_rest(Vec3(1, 1.3, 1).asDiagonal(), normal, along, lean) - Vec3(0, -lean / 1.3, 0)).norm(), 1e-12);
  EXPECT_LT((aside_at_rest(Vec3(1, 1, 0.8).asDiagonal(), normal, along, lean) - Vec3(0, -lean * 0.8, 0)).norm(), 1e-12);
  Mat3 shear = Mat3::Identity();
  shear(1, 2) = 0.4;  // deeper tissue lies further in -y: an upright blade meets what lay further in +y
  EXPECT_LT((aside_at_rest(shear, normal, along, 0) - Vec3(0, 0.4, 0)).norm(), 1e-12);
}

TEST(PullBack, BladesOnSkinThatMoved) {
  // Uniform shear: an upright stroke is a leaning plane at rest. A gradient that jumps, is flattened or inverted gives
  // an embedded blade all the same (case 34).
  Patient p(2);
  BladeContext c = p.context();
  c.gradient = [](const SkinHit&) {
    Mat3 F = Mat3::Identity();
    F(1, 2) = 0.4;
    return F;
  };
  std::vector<Int3> vertex;
  const auto incise = [&vertex](Patient& on, const BladeContext& as, const std::vector<Vec2>& path, double angle) {
    return cut_whole(as, path, 4, angle, false, [&](const Blade& blade) {
      vertex = blade.vertex;
      return on.a.cut(blade, on.seed++);
    });
  };
  ASSERT_TRUE(incise(p, c, {{-15, 2}, {15, 2}}, 90).ok());
  for (const Int3& v : vertex) {
    const Vec3 x = p.body->grid.to_mm(v);
    EXPECT_NEAR(x.y() - 2, -0.4 * x.z(), 0.015);  // vertices are moved aside by up to 8 micrometres
  }
  EXPECT_EQ(euler(p.a), Chi{2});
  for (int kind = 0; kind < 4; ++kind) {
    SCOPED_TRACE(kind);
    Patient q(2);
    BladeContext d = q.context();
    d.gradient = [kind](const SkinHit& h) -> Mat3 {
      Mat3 F = Mat3::Identity();
      const double s = std::sin(3 * h.X_mm.x()) > 0 ? 1 : -1;
      if (kind == 0) F(1, 2) = 0.9 * s;
      if (kind == 1) F(2, 2) = -0.6;
      if (kind == 2) F = Vec3(2, 1e-6, 1).asDiagonal();
      if (kind == 3) F.setConstant(std::nan(""));
      return F;
    };
    const CutResult r = incise(q, d, {{-15, 0}, {0, 1}, {-10, 8}}, 60);
    ASSERT_TRUE(r.ok()) << r.reason;
    EXPECT_EQ(q.a.check_all(), "");
    EXPECT_EQ(euler(q.a), Chi{2});
  }
}

}  // namespace test_pull_back
}  // namespace limberg::test
