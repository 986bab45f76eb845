#pragma once
// The analytic head: skull, mandible and skin as signed distances, so that every test knows what the truth is.
//
// Places in mm: x to the right, y forwards, z upwards, origin midway between the ear canals
// (porion), z = 0 the Frankfurt plane. Below 0 is inside. The values are distances near the
// surfaces and bounds elsewhere: they never grow faster than `kLipschitz` mm a mm, so a
// block whose centre is farther from zero than that times its radius holds no surface.
//
//   skull      vault, forehead, base, maxilla, zygomas with arches, nasal
//              bones, upper alveolar arch, mastoids, less the brain with the
//              foramen magnum, orbits, piriform aperture with the nasal
//              cavity, palate. One solid of genus 3: a tunnel under each
//              zygomatic arch, one from the piriform aperture to the choanae.
//              The orbits are pits (no optic canal), the sinuses are apart
//              (`sinus`), so that every wall is thick enough to be meshed.
//   mandible   rami with condyles and coronoids, body, alveolar arch,
//              chin. A solid of its own, a joint's gap below the skull
//   skin       the filled skull thickened by what textbooks give for soft
//              tissue, cheeks, masseters, lids, nose, lips, ears, neck
//
// Teeth are not there: the edges of the alveolar arches stand for the incisors.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// What may differ from the normal head: factors of 1, lengths in mm.
struct HeadSpec {
  double mandible_scale = 1;  // length of the body: below 1 class II, above 1 class III
  double ramus_left = 1;      // height of the left ramus: asymmetry
  double vault_wide = 1, vault_long = 1;
  double forehead_flat = 0;              // 0..1: forehead set back, by 12 mm at 1
  double edge_mm = 4, face_edge_mm = 5;  // wanted edges of the meshes
  bool anatomical = false;               // the anatomical head (anatomical_head.h): of the above, edges only
};

namespace shape {

/// Segment from a to b, thickened by a radius that goes from ra to rb.
struct Capsule {
  Vec3 a, ab;
  double over_length2, ra, dr;
  Capsule(const Vec3& a_, const Vec3& b, double r0, double r1)
      : a(a_), ab(b - a_), over_length2(1 / std::max(ab.squaredNorm(), 1e-12)), ra(r0), dr(r1 - r0) {}
  double operator()(const Vec3& p) const {
    const Vec3 d = p - a;
    const double t = std::clamp(d.dot(ab) * over_length2, 0., 1.);
    return (d - t * ab).norm() - (ra + t * dr);
  }
};

/// First-order distance to an ellipsoid; deep inside (below half the smallest radius) constant.
struct Ellipsoid {
  Vec3 c, over;  // centre, 1 / radii
  double deepest;
  Ellipsoid(const Vec3& centre, const Vec3& r) : c(centre), over(r.cwiseInverse()), deepest(-0.5 * r.minCoeff()) {}
  double operator()(const Vec3& p) const {
    const Vec3 u = (p - c).cwiseProduct(over);
    const double k0 = u.norm(), k1 = u.cwiseProduct(over).norm();
    return k0 <= 0.5 ? deepest : std::max(deepest, k0 * (k0 - 1) / k1);
  }
};

/// Minimum and maximum rounded over a width k (polynomial; a fillet of about k / 4).
inline double smin(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.);
  return std::min(a, b) - h * h / (4 * k);
}
inline double smax(double a, double b, double k) { return -smin(-a, -b, k); }

}  // namespace shape

class HeadShape {
 public:
  /// Throws InputError on a spec outside what keeps the parts apart: scales 0.7 to 1.3 (mandible 0.8 to 1.2), forehead
  /// 0 to 1, edges 1 to 12 mm.
  explicit HeadShape(const HeadSpec& spec);

  double skull(const Vec3& p) const;
  double mandible(const Vec3& p) const;
  double skin(const Vec3& p) const;
  double bone(const Vec3& p) const { return std::min(skull(p), mandible(p)); }
  /// Parts that only an image shows: air in the sinuses, the brain, an eyeball and its socket.
  double sinus(const Vec3& p) const;
  double brain(const Vec3& p) const;
  double eye(const Vec3& p) const;
  double orbit(const Vec3& p) const;
  double airway(const Vec3& p) const;

  /// Where the spec moves a place of the normal mandible to: a longer body carries everything before the ramus
  /// forwards, a shorter left ramus lifts the angle, less and less towards the chin.
  Vec3 mandible_place(const Vec3& p) const;
  const HeadSpec& spec() const { return spec_; }

  static constexpr double kLipschitz = 1.8;
  static constexpr double kNeck_mm = -118;  // the skin ends at this height
  /// A box around everything.
  static Vec3 low_mm() { return {-105, -122, kNeck_mm}; }
  static Vec3 high_mm() { return {105, 138, 134}; }

 private:
  struct Bump {
    Vec3 c;
    double mm, over_2s2;
  };
  double solid(const Vec3& q) const;  // skull before anything is taken away; q: x mirrored to the right
  HeadSpec spec_;
  shape::Ellipsoid vault_, brain_;
  std::vector<std::vector<shape::Capsule>> rods_;  // of the mandible, both sides
  std::vector<shape::Capsule> lower_lip_;
  std::vector<Bump> bump_;
};

}  // namespace limberg
