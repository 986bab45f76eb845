#include "sim/fem/materials/rotation_svd.h"

#include <cmath>
#include <utility>

namespace limberg {
namespace {

/// Some unit vector perpendicular to the unit vector a.
Vec3 perpendicular(const Vec3& a) {
  int k = 0;
  a.cwiseAbs().minCoeff(&k);
  return a.cross(Vec3::Unit(k)).normalized();
}

}  // namespace

RotationSvd rotation_svd(const Mat3& F) {
  RotationSvd r;
  // One-sided Jacobi: columns of A = F V are made perpendicular. No squared condition number.
  Mat3 A = F;
  Mat3& V = r.V;
  for (int sweep = 0; sweep < 12; ++sweep) {
    bool rotated = false;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        const double a = A.col(p).squaredNorm(), b = A.col(q).squaredNorm(), c = A.col(p).dot(A.col(q));
        if (std::fabs(c) <= 1e-16 * std::sqrt(a * b) || c == 0) continue;
        rotated = true;
        const double zeta = (b - a) / (2 * c);
        const double t = (zeta >= 0 ? 1 : -1) / (std::fabs(zeta) + std::sqrt(1 + zeta * zeta));
        const double cs = 1 / std::sqrt(1 + t * t), sn = cs * t;
        for (Mat3* m : {&A, &V}) {
          const Vec3 x = m->col(p), y = m->col(q);
          m->col(p) = cs * x - sn * y;
          m->col(q) = sn * x + cs * y;
        }
      }
    if (!rotated) break;
  }
  // Largest first; a swap of columns with a change of sign keeps V a rotation.
  for (auto [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}})
    if (A.col(p).squaredNorm() < A.col(q).squaredNorm())
      for (Mat3* m : {&A, &V}) {
        const Vec3 x = m->col(p);
        m->col(p) = m->col(q);
        m->col(q) = -x;
      }
  const double n0 = A.col(0).norm();
  if (n0 == 0) {
    r.s.setZero();
    r.U = V;
    return r;
  }
  const Vec3 u0 = A.col(0) / n0;
  Vec3 u1 = A.col(1) - u0 * u0.dot(A.col(1));
  const double n1 = u1.norm();
  if (n1 > 1e-300 && n1 > 1e-15 * n0)
    u1 /= n1;
  else
    u1 = perpendicular(u0);
  const Vec3 u2 = u0.cross(u1);
  r.U.col(0) = u0, r.U.col(1) = u1, r.U.col(2) = u2;
  r.s = Vec3(n0, u1.dot(A.col(1)), u2.dot(A.col(2)));
  return r;
}

}  // namespace limberg
