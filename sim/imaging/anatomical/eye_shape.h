#pragma once
// Globe, lids and palpebral fissure upon a face. Right half.
#include "sim/imaging/anatomical/fields.h"

namespace limberg::anatomical {

class Eye {
 public:
  static Vec3 centre() { return {31.5, 71.4, 15.3}; }
  static constexpr double kGlobe_mm = 12.0, kIris_mm = 5.9;
  static constexpr double kEn_mm = 16.6, kEx_mm = 45.6;

  /// Heights of the lids' margins where the fissure is x mm from the middle.
  static void margins(double x, double& low, double& high) {
    const double t = (x - kEn_mm) / (kEx_mm - kEn_mm), line = 13.0 + 2.4 * t;
    if (t <= 0 || t >= 1) {
      low = high = line - 0.6 * (t <= 0 ? -t : t - 1) * (kEx_mm - kEn_mm);
      low = -low + 2 * line;
      return;
    }
    const double s = elementary::pow(t, 0.72), up = 4 * s * (1 - s), down = 4 * t * (1 - t);
    high = line + 6.0 * up * (0.8 + 0.2 * up), low = line - 4.4 * down * (0.8 + 0.2 * down);
  }

  /// Closed lids, in which fissure() and globe_mm() are cut.
  double lids_upon(double face, const Vec3& q) const {
    return near_.holds(q) ? carve(smin(face, lids_(q), 5), crease_, q, 2.2) : face;
  }

  /// How far within the fissure between parted lids a place lies, below 0 outside. It is cut towards the globe's
  /// middle, so that margins stand upright on their lids.
  static double fissure(const Vec3& q) {
    const Vec3 d = q - parted_centre();
    const double r = d.norm();
    if (r < kLeastFissure_mm || d.y() < 0) return -kLeastFissure_mm;
    // Margins are told where skin lies, which is farther from the globe at the corners.
    const double skin_mm = kSkin_mm + kSkinAtSide_mm * ramp(0.35, 0.85, d.x() / r) +
                           kSkinAtNose_mm * ramp(-0.35, -0.8, d.x() / r),
                 out = std::max(1., skin_mm / r);
    double low, high;
    margins(parted_centre().x() + out * d.x(), low, high);
    const double z = parted_centre().z() + out * d.z();
    return kSteepest * std::min(high - z, z - low) / out;
  }

  /// The bare globe that parted lids lie against: two spheres, as El Hage and Le Grand 1980 describe an adult eye (of
  /// 12 and 8 mm, their middles 5 mm apart), so much smaller that it is 24.0 mm long and its cornea 11.5 mm wide.
  static double globe_mm(const Vec3& q) {
    const Vec3 d = q - parted_centre();
    return std::min(d.norm() - kBare_mm, (d - Vec3(0, kCornea_y_mm, 0)).norm() - kCornea_mm);
  }
  static Vec3 parted_centre() { return centre() - Vec3(0, 0.4, 0); }
  static constexpr double kBare_mm = 11.5, kCornea_mm = 7.8, kCornea_y_mm = 4.7, kLimbus_mm = 5.75, kPupil_mm = 2;

  /// What fills the fissure's inner corner: caruncle and the fold beside it.
  double caruncle(const Vec3& q) const { return smin(caruncle_(q), smax(bed_(q), q.x() - 20.5, 1), 1.2); }

  double upon(double face, const Vec3& q) const {
    if (!near_.holds(q)) return face;
    double d = lids_upon(face, q);
    double low, high;
    margins(q.x(), low, high);
    const double fissure = 0.75 * std::max(q.z() - high, low - q.z());
    const double open = std::max(fissure, 74 - q.y());
    d = smax(d, -open, 0.9);
    double globe = (q - centre()).norm() - kGlobe_mm;
    globe = smin(globe, (q - centre() - Vec3(0, 5.3, 0)).norm() - 7.9, 1.2);
    globe = smin(globe, bed_(q), 1.5);
    globe = smin(globe, caruncle_(q), 1.2);
    return std::min(d, globe);
  }

 private:
  static constexpr double kSkin_mm = 14.4, kSkinAtSide_mm = 1.8, kSkinAtNose_mm = 4.5, kLeastFissure_mm = 5,
                          kSteepest = 0.75;
  Ball near_{{31.5, 78, 15}, 34};
  Ellipsoid lids_{{31.0, 70.9, 15.2}, {17.6, 13.5, 15.2}};
  Ellipsoid bed_{{30.6, 70.5, 14.6}, {17.0, 12.4, 12}};
  Ellipsoid caruncle_{{18.4, 78.6, 13.3}, {2.4, 3.0, 2.0}};
  Tube crease_{{18, 87, 20, 0.5}, {23, 85.4, 25.2, 1.0}, {31, 85.0, 27.4, 1.0}, {38.5, 82.6, 25.4, 0.8}};
};

}  // namespace limberg::anatomical
