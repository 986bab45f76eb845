// A vertex and its three neighbours: closed forms, and the round trip of the shape code in every case.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "sim/skull/simplex/generators.h"
#include "tests/sim/skull/simplex/random.h"

namespace limberg::simplex {
namespace test_shape {

using test::Random;
constexpr double kPi = std::numbers::pi;

double size(const Vec3& P, const Vec3& A, const Vec3& B, const Vec3& C) {
  return std::max({(A - B).norm(), (B - C).norm(), (C - A).norm(), (P - A).norm(), (P - B).norm(), (P - C).norm()});
}

/// Relative error of decode(encode(P)).
double trip(const Vec3& P, const Vec3& A, const Vec3& B, const Vec3& C, ShapeCode code = ShapeCode::angle) {
  return (decode(encode(P, A, B, C, code), A, B, C) - P).norm() / size(P, A, B, C);
}

TEST(VertexShape, FrameFollowsTheDefinitions) {
  Random rnd(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 A = rnd.vec(), B = rnd.vec(), C = rnd.vec(), P = rnd.vec();
    const LocalFrame f = local_frame(P, A, B, C);
    if (f.area2_mm2 < 0.05) continue;
    // Circumcentre of the triangle and of the tetrahedron from their definitions.
    const Vec3 b = B - A, c = C - A, n = b.cross(c);
    const Vec3 o = A + (n.cross(b) * c.squaredNorm() + c.cross(n) * b.squaredNorm()) / (2 * n.squaredNorm());
    EXPECT_NEAR((o - A).norm(), f.r_mm, 1e-10 * f.r_mm);
    const Vec3 F = f.e[0] * A + f.e[1] * B + f.e[2] * C;
    EXPECT_LT((F + f.L_mm * f.N - P).norm(), 1e-12);
    EXPECT_NEAR(f.k_mm2, f.r_mm * f.r_mm - (F - o).squaredNorm(), 1e-9 * f.r_mm * f.r_mm);
    Mat3 M;
    M << b.transpose(), c.transpose(), (P - A).transpose();
    if (std::abs(M.determinant()) < 1e-3) continue;
    const Vec3 O = A + M.inverse() * Vec3(b.squaredNorm() / 2, c.squaredNorm() / 2, (P - A).squaredNorm() / 2);
    const double R = (O - A).norm(), s = f.L_mm > 0 ? 1 : -1;
    EXPECT_NEAR(f.mean_curvature_per_mm(), s / R, 1e-8 / f.r_mm);
    EXPECT_NEAR(f.sin_phi, s * f.r_mm / R, 1e-8);
    EXPECT_NEAR(f.cos_phi, -s * (O - o).dot(f.N) / R, 1e-8);  // (O below the plane, P above: a shallow cap)
  }
}

TEST(VertexShape, AngleOfKnownPlaces) {
  const Vec3 A(1, 0, 0), B(-0.5, std::sqrt(0.75), 0), C(-0.5, -std::sqrt(0.75), 0);  // r = 1, centre at the origin
  EXPECT_DOUBLE_EQ(local_frame({0, 0, 0}, A, B, C).phi(), 0);
  EXPECT_NEAR(local_frame({0, 0, 1}, A, B, C).phi(), kPi / 2, 1e-15);  // O in the plane
  EXPECT_NEAR(local_frame({0, 0, -1}, A, B, C).phi(), -kPi / 2, 1e-15);
  EXPECT_GT(local_frame({0, 0, 1e4}, A, B, C).phi(), kPi - 1e-3);  // a spike
  // A cap of height L over a circle of radius 1: R = (1 + L^2) / 2 L.
  for (double L : {1e-6, 0.1, 0.5, 2., 30.})
    EXPECT_NEAR(local_frame({0, 0, L}, A, B, C).mean_curvature_per_mm(), 2 * L / (1 + L * L), 1e-15);
}

TEST(VertexShape, RoundTripOfRandomPlacesNeedsTheBit) {
  Random rnd(2);
  int far = 0, by_height = 0, bit_matters = 0;
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const Vec3 A = rnd.vec(), B = rnd.vec(), C = rnd.vec(), P = rnd.vec();
    const LocalFrame f = local_frame(P, A, B, C);
    if (f.degenerate) continue;
    VertexShape s = encode(P, A, B, C);
    worst = std::max(worst, trip(P, A, B, C));
    far += s.branch == ShapeBranch::far, by_height += s.branch == ShapeBranch::height;
    if (s.branch == ShapeBranch::far) {
      s.branch = ShapeBranch::near;  // the published coding
      bit_matters += (decode(s, A, B, C) - P).norm() > 1e-3 * size(P, A, B, C);
    }
  }
  EXPECT_LT(worst, 1e-12);
  EXPECT_GT(far, 20000);  // feet outside the circumcircle are common in a random tetrahedron
  EXPECT_GT(bit_matters, far * 9 / 10);
  EXPECT_LT(by_height, 20000);  // the angle serves nearly always
}

TEST(VertexShape, RoundTripWhereItIsHard) {
  Random rnd(3);
  const auto check = [&](const Vec3& P, const Vec3& A, const Vec3& B, const Vec3& C, const char* what) {
    // A metric parameter e carries a rounding of eps |e|, which decode multiplies with an edge: 1e-12 while |e| < 1000
    // or so. The normal of a thin triangle carries eps |B - A| |C - A| / (2 area).
    const LocalFrame f = local_frame(P, A, B, C);
    const double thin = (B - A).norm() * (C - A).norm() / f.area2_mm2;
    const double allowed =
        std::max(1e-12, 10 * 2.2e-16 * (std::abs(f.e[0]) + std::abs(f.e[1]) + std::abs(f.e[2]) + thin));
    const double e = trip(P, A, B, C);
    EXPECT_LT(e, allowed) << what;
    EXPECT_LT(trip(P, A, B, C, ShapeCode::height), allowed) << what;
  };
  for (int i = 0; i < 3000; ++i) {
    const Vec3 A = rnd.vec(), B = rnd.vec(), C = rnd.vec();
    const LocalFrame f = local_frame(A, A, B, C);
    if (f.area2_mm2 < 0.02) continue;
    const Vec3 n = (B - A).cross(C - A), N = n.normalized();
    const Vec3 o =
        A + (n.cross(B - A) * (C - A).squaredNorm() + (C - A).cross(n) * (B - A).squaredNorm()) / (2 * n.squaredNorm());
    const Vec3 u = (A - o).normalized(), w = N.cross(u);
    const double a = rnd.uniform(0, 2 * kPi), r = f.r_mm;
    const Vec3 e = std::cos(a) * u + std::sin(a) * w;
    for (double d : {0., 0.3 * r, r, 1.7 * r, 40 * r}) {
      check(o + d * e, A, B, C, "in the plane");
      for (double L : {1e-9, 1e-3, 0.2, 1., 50., 1e4})
        for (double sign : {-1., 1.}) check(o + d * e + sign * L * r * N, A, B, C, "over the plane");
      // Where the two roots meet: L^2 = d^2 - r^2, and beside it.
      if (d > r)
        for (double off : {0., 1e-12, 1e-8, 1e-4})
          check(o + d * e + std::sqrt(d * d - r * r) * (1 + off) * N, A, B, C, "double root");
    }
    check(A, A, B, C, "at a neighbour");
    check(o + r * e, A, B, C, "on the circumcircle");
    const Vec3 thin = A + (B - A) * 0.4 + 1e-4 * (C - A);
    check(o + rnd.vec(), A, B, thin, "thin triangle");
  }
}

TEST(VertexShape, LinesAndPointsDoNotBreakAnything) {
  const Vec3 A(0, 0, 0), B(1, 0, 0), C(2, 0, 0);
  for (const Vec3& P : {Vec3(1, 1, 0), Vec3(0, 0, 0), Vec3(0.3, 1e-300, 0)}) {
    const LocalFrame f = local_frame(P, A, B, C);
    EXPECT_TRUE(f.degenerate);
    EXPECT_EQ(f.mean_curvature_per_mm(), 0);
    EXPECT_TRUE(decode(encode(P, A, B, C), A, B, C).isApprox(Vec3(1, 0, 0)));
  }
  EXPECT_TRUE(decode(encode(A, A, A, A), A, A, A).allFinite());
}

TEST(VertexShape, InvariantUnderSimilarities) {
  Random rnd(4);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 A = rnd.vec(), B = rnd.vec(), C = rnd.vec(), P = rnd.vec();
    if (local_frame(P, A, B, C).area2_mm2 < 0.05) continue;
    const Mat3 R = Eigen::Quaterniond(rnd.uniform(-1, 1), rnd.uniform(-1, 1), rnd.uniform(-1, 1), 1.5)
                       .normalized()
                       .toRotationMatrix();
    const double scale = std::pow(10, rnd.uniform(-4, 4));
    const Vec3 t = scale * rnd.vec(3);
    auto g = [&](const Vec3& x) { return Vec3(scale * (R * x) + t); };
    for (ShapeCode code : {ShapeCode::angle, ShapeCode::height}) {
      const Vec3 Q = decode(encode(P, A, B, C, code), g(A), g(B), g(C));
      EXPECT_LT((Q - g(P)).norm(), 1e-11 * scale);
    }
    // (e2 and e3 change places too: not the mirror image, but finite)
    const Vec3 mirror = decode(encode(P, A, B, C), A, C, B);
    EXPECT_TRUE(mirror.allFinite());
  }
}

TEST(Curvature, ExactOnSpheres) {
  for (const Mesh& m :
       {make_sphere({1, 2, 3}, 7, 0), make_sphere({0, 0, 0}, 7, 3), make_sphere_of_faces({5, 0, 0}, 7, 1002)})
    for (int32_t v = 0; v < m.slots(); ++v) EXPECT_NEAR(m.frame(v).mean_curvature_per_mm(), 1. / 7, 1e-10);
}

TEST(Curvature, ConvergesOnCylinderAndTorus) {
  double before = 0;
  for (int around : {24, 48, 96}) {
    const double row = 2 * kPi * 10 / around * std::sqrt(0.75);  // regular hexagons: whole rows
    const Mesh m = make_cylinder(10, row * std::lround(30 / row), around);
    double worst = 0;
    for (int32_t v = 0; v < m.slots(); ++v)
      if (std::abs(m.x_mm[size_t(v)].z() - 15) < 8)
        worst = std::max(worst, std::abs(m.frame(v).mean_curvature_per_mm() - 1 / 20.));
    if (before > 0) {
      EXPECT_LT(worst, 0.35 * before);  // second order would be a quarter
    }
    before = worst;
  }
  EXPECT_LT(before, 2e-3 / 20);
  // A torus of nearly regular hexagons at its top circle, where H = 1 / 2r.
  const Mesh t = make_torus(100, 10, 462, 40);
  double worst = 0;
  for (int32_t v = 0; v < t.slots(); ++v) {
    const Vec3& x = t.x_mm[size_t(v)];
    const double rho = std::hypot(x.x(), x.y()), c = (rho - 100) / 10;
    const double H = 0.5 * (1. / 10 + c / rho);
    worst = std::max(worst, std::abs(t.frame(v).mean_curvature_per_mm() - H));
  }
  EXPECT_LT(worst, 0.15 * 0.05);  // stars stretched by a tenth (inside against outside) see directions unevenly
}

}  // namespace test_shape
}  // namespace limberg::simplex
