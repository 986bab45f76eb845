#include "sim/cutting/strokes/pull_back.h"

#include <Eigen/SVD>
#include <algorithm>

namespace limberg {

Vec3 aside_at_rest(const Mat3& F, const Vec3& normal, const Vec3& along, double lean) {
  const Vec3 right = along.cross(normal);
  if (!F.allFinite() || (F - Mat3::Identity()).norm() < kAsAtRest) return lean * right;
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 U = svd.matrixU();
  Vec3 sigma = svd.singularValues();
  const Mat3& V = svd.matrixV();
  const bool inverted = U.determinant() * V.determinant() < 0;
  if (inverted) {
    U.col(2) = -U.col(2);  // the singular value that has changed its sign is the smallest
    sigma.setOnes();
  } else {
    sigma = sigma.cwiseMax(sigma.maxCoeff() / kConditionLimit);
  }
  const auto forth = [&](const Vec3& x) -> Vec3 { return U * sigma.asDiagonal() * (V.transpose() * x); };
  const auto back = [&](const Vec3& x) -> Vec3 { return V * sigma.cwiseInverse().asDiagonal() * (U.transpose() * x); };
  const Vec3 n = (U * sigma.cwiseInverse().asDiagonal() * (V.transpose() * normal)).normalized();
  const Vec3 r = forth(along).cross(n).normalized();
  const Vec3 D = back(-n + lean * r);
  const double down = -D.dot(normal);
  // A blade that would run along the skin, or out of it, at rest: as flat as can be, the way it leans.
  Vec3 aside = D + down * normal;
  if (down <= 1e-3 * aside.norm()) return aside.norm() > 0 ? Vec3(kMostAside * aside.normalized()) : Vec3(lean * right);
  aside /= down;
  const double length = aside.norm();
  return length > kMostAside ? Vec3(aside * (kMostAside / length)) : aside;
}

}  // namespace limberg
