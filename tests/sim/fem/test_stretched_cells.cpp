// What the metric lacks where cells are drawn out.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "sim/fem/elements/effective_bulk.h"
#include "sim/fem/preconditioner/stretched_cells.h"
#include "tests/sim/fem/models.h"

namespace limberg {
namespace test_stretched_cells {

FemModel box(int x, int y, int z) {
  BoxSpec b;
  b.cells = {x, y, z};
  b.size_mm = 2.0 * Vec3(x, y, z);
  b.poisson = 0.45;
  return box_model(b);
}

/// The volumetric energy's Hessian traced over x, y and z, by differences: V ke/2 (J - 1)^2 of the cell's sample point,
/// without what comes of the slope at J (J = 1 in these cases).
Mat8 volumetric(const FemModel& m, const Mat3& F) {
  const Stencil& s = m.stencils[size_t(m.cells[0].stencil)];
  const Eigen::Matrix<double, 8, 3> B = volume_gradients(s, m.cell_mm);
  const double ke = fem::effective_bulk_kPa(s, true), h = 1e-4;
  Mat8 H = Mat8::Zero();
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix<double, 8, 1> slope;  // of J, by moving corner a along i
    for (int a = 0; a < 8; ++a) {
      Mat3 up = F, down = F;
      up.row(i) += h * B.row(a), down.row(i) -= h * B.row(a);
      slope[a] = (up.determinant() - down.determinant()) / (2 * h);
    }
    H += s.volume_mm3 * ke * slope * slope.transpose();
  }
  return H;
}

TEST(StretchedCells, RowsAreWhatTheMetricLacks) {
  const FemModel m = box(2, 1, 1);
  const Mat3 R = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Mat3 Q = Eigen::AngleAxisd(1.1, Vec3(-1, 1, 2).normalized()).toRotationMatrix();
  const Mat3 F = R * Vec3(6, 1.5, 1 / 9.0).asDiagonal() * Q.transpose();  // J = 1; thin along Q's third axis
  fem::StretchedCells stretched;
  ASSERT_TRUE(stretched.follow(m, test::moved_by(m, F), true, test::engine()));
  ASSERT_EQ(stretched.rows().size(), 2u);  // a direction of each cell
  Mat8 rows = Mat8::Zero();                // the first one's
  const fem::SpringRow& r = stretched.rows()[0];
  for (size_t a = 0; a < r.node.size(); ++a)
    for (size_t b = 0; b < r.node.size(); ++b) {
      const auto corner = [&](int32_t node) {
        return std::find(m.cells[0].node.begin(), m.cells[0].node.end(), node) - m.cells[0].node.begin();
      };
      rows(corner(r.node[a]), corner(r.node[b])) += r.k_mN_per_mm * r.w[a] * r.w[b];
    }
  // Along N = Q e3 all of it, along the others nothing: squares of .17 and .67 there.
  const Mat8 H = volumetric(m, F), rest = volumetric(m, Mat3::Identity());
  for (int k = 0; k < 3; ++k) {
    // Corners moved as a gradient Q e_k asks for.
    Eigen::Matrix<double, 8, 1> x;
    for (int a = 0; a < 8; ++a) x[a] = Q.col(k).dot(m.X_mm[size_t(m.cells[0].node[size_t(a)])]);
    const double lacks = x.dot(H * x) - x.dot(rest * x), has = x.dot(rows * x);
    if (k == 2)
      EXPECT_NEAR(has, lacks, 1e-4 * lacks);
    else
      EXPECT_NEAR(has, 0, 1e-4 * x.dot(rest * x));
  }
}

TEST(StretchedCells, NothingAtRestNorForALittleMoreNorForOneNorInATangle) {
  const FemModel m = box(2, 1, 1);
  fem::StretchedCells stretched;
  EXPECT_FALSE(stretched.follow(m, test::moved_by(m, Mat3::Identity()), true, test::engine()));
  const Mat3 R = Eigen::AngleAxisd(2, Vec3::UnitX()).toRotationMatrix();
  EXPECT_FALSE(stretched.follow(m, test::moved_by(m, R), true, test::engine()));
  EXPECT_FALSE(stretched.follow(m, test::moved_by(m, Vec3(2, 1, 0.5).asDiagonal()), true, test::engine()));
  ASSERT_TRUE(stretched.follow(m, test::moved_by(m, Vec3(9, 1, 1 / 9.0).asDiagonal()), true, test::engine()));
  const int32_t id = stretched.rows()[0].id;
  EXPECT_LT(id, 0);
  EXPECT_FALSE(
      stretched.follow(m, test::moved_by(m, Vec3(10, 1, 0.1).asDiagonal()), true, test::engine()));  // near enough
  ASSERT_TRUE(stretched.follow(m, test::moved_by(m, Vec3(25, 1, 0.04).asDiagonal()), true, test::engine()));
  EXPECT_NE(stretched.rows()[0].id, id);
  EXPECT_TRUE(
      stretched.follow(m, test::moved_by(m, Mat3::Identity()), true, test::engine()));  // they are there no more
  EXPECT_TRUE(stretched.rows().empty());

  const FemModel one = box(1, 1, 1), many = box(5, 5, 5);
  EXPECT_FALSE(stretched.follow(one, test::moved_by(one, Vec3(9, 1, 1 / 9.0).asDiagonal()), true, test::engine()));
  EXPECT_FALSE(stretched.follow(many, test::moved_by(many, Vec3(9, 1, 1 / 9.0).asDiagonal()), true, test::engine()));
}

}  // namespace test_stretched_cells
}  // namespace limberg
