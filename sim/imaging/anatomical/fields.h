#pragma once
// Signed distances that the anatomical head is put together from. mm; below 0 is inside.
//
// Smooth minimum and maximum, capsules and ellipsoids are those of the synthetic head (synthetic/head_shape.h). What is
// added: bent tubes, ellipsoids in axes of their own, and a field that is pulled onto places.
#include <array>
#include <cmath>
#include <initializer_list>
#include <vector>

#include "sim/base/elementary.h"
#include "sim/imaging/synthetic/head_shape.h"

namespace limberg::anatomical {

using shape::Capsule;
using shape::Ellipsoid;
using shape::smax;
using shape::smin;

/// A bent tube through places, each with its radius, along Catmull and Rom's curve.
class Tube {
 public:
  /// x, y, z, radius.
  explicit Tube(std::initializer_list<std::array<double, 4>> at);
  double operator()(const Vec3& p) const {
    double d = 1e300;
    for (const Capsule& c : part_) d = std::min(d, c(p));
    return d;
  }
  /// The distance is no less than this.
  double at_least(const Vec3& p) const { return (p - middle_).norm() - far_; }

 private:
  std::vector<Capsule> part_;
  Vec3 middle_;
  double far_ = 0;
};

/// smin(d, tube, k) and smax(d, -tube, k), where the tube is too far to matter without its distance.
inline double join(double d, const Tube& tube, const Vec3& p, double k) {
  return tube.at_least(p) >= d + k ? d : smin(d, tube(p), k);
}
inline double carve(double d, const Tube& tube, const Vec3& p, double k) {
  return tube.at_least(p) >= k - d ? d : smax(d, -tube(p), k);
}

/// An ellipsoid whose axes are the columns of a turn.
struct Turned {
  Mat3 back;
  Vec3 c;
  Ellipsoid e;
  Turned(const Vec3& centre, const Vec3& radii, const Mat3& axes)
      : back(axes.transpose()), c(centre), e(Vec3::Zero(), radii) {}
  double operator()(const Vec3& p) const { return e(back * (p - c)); }
};

/// A ball outside of which a group of fields need not be looked at.
struct Ball {
  Vec3 c;
  double r;
  bool holds(const Vec3& p) const { return (p - c).squaredNorm() < r * r; }
};

/// 0 at a, 1 at b, smooth between and the same beyond; b may lie below a.
inline double ramp(double a, double b, double x) {
  const double t = std::clamp((x - a) / (b - a), 0., 1.);
  return t * t * (3 - 2 * t);
}

/// A smooth field that takes values at places (Wendland's C2 function of compact support, Wendland 1995; the weights
/// solve a linear system). Added to a distance it pulls its surface onto these places.
class Pull {
 public:
  /// `mirrored`: every place off x = 0 counts on both sides. `slack`: added to the diagonal of the system; the surface
  /// then passes by places that ask for ripples. Throws InputError where two places coincide.
  Pull(std::vector<Vec3> places, const std::vector<double>& values, double reach_mm, bool mirrored, double slack = 0);
  double operator()(const Vec3& p) const;

 private:
  struct At {
    Vec3 c;
    double w;
  };
  double reach_;
  std::vector<At> at_;
  // Which of them reach into a cell of a coarse grid.
  Vec3 low_ = Vec3::Zero();
  std::array<int, 3> cells_{1, 1, 1};
  std::vector<std::vector<int>> near_;
};

}  // namespace limberg::anatomical
