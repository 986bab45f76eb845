#pragma once
// Contacts against differences: of their energy, and of the reference's gradient.
#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/fem/forces/contact_forces.h"
#include "sim/testing/reference_newton.h"

namespace limberg::test {

inline NodeArray nodes_of(const std::vector<Vec3>& u) {
  NodeArray a(u.size());
  for (size_t i = 0; i < u.size(); ++i) a[i] = {float(u[i][0]), float(u[i][1]), float(u[i][2]), 0};
  return a;
}

inline std::vector<Vec3> vectors_of(const NodeArray& a) {
  std::vector<Vec3> out;
  for (size_t i = 0; i < a.size(); ++i) out.push_back({double(a[i].x), double(a[i].y), double(a[i].z)});
  return out;
}

inline constexpr double kDifference_mm = 1.0 / 1024;

struct GradientCheck {
  double worst = 0, largest = 0;  // off the central differences of the energy; component of the gradient
};

inline GradientCheck against_differences(fem::ContactForces& f, const NodeArray& at, const NodeArray& g) {
  NodeArray ignored(at.size());
  const auto shifted = [&](size_t i, int axis, double d) {
    NodeArray v = at;
    (&v[i].x)[axis] += float(d);
    return std::pair(f.add(v, ignored, false), double((&v[i].x)[axis]));
  };
  GradientCheck out;
  for (size_t i = 0; i < at.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const auto [e1, x1] = shifted(i, axis, kDifference_mm);
      const auto [e0, x0] = shifted(i, axis, -kDifference_mm);
      out.worst = std::max(out.worst, std::abs((e1 - e0) / (x1 - x0) - double((&g[i].x)[axis])));
      out.largest = std::max(out.largest, double(std::abs((&g[i].x)[axis])));
    }
  return out;
}

/// How far what the contacts add to the reference's Hessian is off the differences of what they add to its gradient, at
/// worst, by the columns of every `every`-th node; mN/mm.
inline double hessian_off(const ReferenceElasticity& none, const ReferenceElasticity& with, const std::vector<Vec3>& u,
                          const Eigen::MatrixXd& H, size_t every) {
  const double h = 1e-4;
  double worst = 0;
  for (size_t i = 0; i < u.size(); i += every)
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3> a = u, b = u, ga, gb, na, nb;
      a[i][axis] += h, b[i][axis] -= h;
      with.gradient(a, ga), with.gradient(b, gb), none.gradient(a, na), none.gradient(b, nb);
      for (size_t j = 0; j < u.size(); ++j)
        worst = std::max(worst, (((ga[j] - na[j]) - (gb[j] - nb[j])) / (2 * h) -
                                 H.block<3, 1>(Eigen::Index(3 * j), Eigen::Index(3 * i) + axis))
                                    .norm());
    }
  return worst;
}

}  // namespace limberg::test
