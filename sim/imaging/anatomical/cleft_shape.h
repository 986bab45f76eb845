#pragma once
// An incomplete cleft of the left upper lip (x < 0), upon a face that was made whole: where a place of the face with a
// cleft lies on the whole one, the gap, and its red margins.
//
// Textbooks describe it in words (as remembered of Millard 1976): the lip is short beside the gap, most on the medial
// side, where the bow of Cupid is drawn up with its peak; red lip runs up both edges and gets thinner; the wing of the
// nose is wide and flat. The lengths are choices that look like it: no table of shapes was at hand.
#include <algorithm>

#include "sim/imaging/anatomical/mouth_shape.h"

namespace limberg::anatomical {

class Cleft {
 public:
  /// The place of the whole face that lies here. Distances of that face grow by kStretch times as much at most (1.75
  /// was the most, looked at every quarter of a millimetre).
  static Vec3 whole(const Vec3& p) {
    const double ala = elementary::exp(-(p - Vec3(-14, 103, -36)).squaredNorm() / (2 * 10 * 10));
    const double dome = elementary::exp(-(p - Vec3(-8, 114, -22)).squaredNorm() / (2 * 7 * 7));
    Vec3 w = p + Vec3(kWider_mm * ala, kFlatter_mm * dome, 0);
    const double line = Mouth::line_mm(std::abs(w.x()));
    if (w.z() <= line || w.z() >= kUnmoved_mm) return w;
    // What lies over the mouth's line is pressed together, so that the margin comes to lie higher by `up`.
    const double up = short_mm(w.x()), high = kUnmoved_mm - line;
    w.z() = line + std::max(0., (w.z() - line - up) * high / (high - up));
    return w;
  }
  static constexpr double kStretch = 2.1;

  /// The gap beside and above the mouth: mm in its plane, above 0 within.
  static double gap(const Vec3& p) {
    static const Capsule wedge({-9.8, 0, -52.5}, {-7.8, 0, -43.3}, 4.3, 1.1);
    const double line = Mouth::line_mm(std::abs(p.x()));
    return -std::max({wedge({p.x(), 0, p.z()}), line - p.z(), 70 - p.y()});
  }

  /// Where the picture of the whole face shows what this place looks like: red lip along the gap's edges.
  static Vec3 pictured(const Vec3& p) {
    Vec3 w = whole(p);
    const double x = std::min(std::abs(w.x()), Mouth::kCorner_mm), line = Mouth::line_mm(x);
    const double off = std::max(0., -gap(p));
    if (p.z() < line) return w;
    const double t = std::clamp((p.z() - kBelow_mm) / (kAbove_mm - kBelow_mm), 0., 1.);
    const double lateral = ramp(-7, -9, p.x());
    const double red = (kRedBelow_mm + t * (kRedAbove_mm - kRedBelow_mm)) * (1 - 0.1 * lateral);
    const double most = Mouth::red_to_mm(x) - line - kDark_mm;
    const double up = kDark_mm + most * std::min(1., off / red) + kQuick * std::max(0., off - red);
    w.z() = std::min(w.z(), line + up);
    return w;
  }

 private:
  static constexpr double kWider_mm = 2.5, kFlatter_mm = 1.5;
  static constexpr double kUnmoved_mm = -37.5;                  // above it no lip is shorter
  static constexpr double kMedial_mm = 4.5, kLateral_mm = 1.5;  // by so much the margin lies higher beside the gap
  static constexpr double kRedBelow_mm = 5.5, kRedAbove_mm = 1.7, kBelow_mm = -53, kAbove_mm = -42;  // of red lip
  static constexpr double kDark_mm = 1.2;  // over the line where lips meet, which is dark on the picture
  static constexpr double kQuick = 2;      // beyond the red lip its picture's skin passes so much faster

  static double short_mm(double x) {
    return kMedial_mm * ramp(3, -6, x) - (kMedial_mm - kLateral_mm) * ramp(-8, -13, x) -
           kLateral_mm * ramp(-13, -25, x);
  }
};

}  // namespace limberg::anatomical
