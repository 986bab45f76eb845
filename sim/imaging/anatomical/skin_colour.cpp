#include "sim/imaging/anatomical/skin_colour.h"

#include <cmath>

#include "sim/base/elementary.h"
#include "sim/imaging/anatomical/ear_shape.h"
#include "sim/imaging/anatomical/eye_shape.h"
#include "sim/imaging/anatomical/mouth_shape.h"
#include "sim/imaging/anatomical/teeth_shape.h"

namespace limberg::anatomical {
namespace {

const Vec3 kSkin(0.870, 0.690, 0.600), kFlush(0.830, 0.520, 0.450), kPale(0.890, 0.740, 0.640),
    kShade(0.700, 0.520, 0.470), kBeard(0.640, 0.560, 0.530), kVermilion(0.665, 0.425, 0.395),
    kHair(0.215, 0.160, 0.125), kWhite(0.900, 0.875, 0.850), kPink(0.800, 0.560, 0.520), kIris(0.330, 0.270, 0.190),
    kLimbus(0.120, 0.100, 0.090), kPupil(0.02, 0.02, 0.02);

double spot(const Vec3& q, const Vec3& c, double sd) { return elementary::exp(-(q - c).squaredNorm() / (2 * sd * sd)); }

double number(int x, int y, int z) {
  uint32_t h = uint32_t(x) * 0x9e3779b9u ^ uint32_t(y) * 0x85ebca6bu ^ uint32_t(z) * 0xc2b2ae35u;
  h ^= h >> 16, h *= 0x7feb352du, h ^= h >> 15, h *= 0x846ca68bu, h ^= h >> 16;
  return double(h >> 8) / 16777216.;
}

/// Smooth noise of 0 to 1, cells of 1.
double noise(const Vec3& p) {
  const int i = int(std::floor(p.x())), j = int(std::floor(p.y())), k = int(std::floor(p.z()));
  const auto s = [](double t) { return t * t * (3 - 2 * t); };
  const double u = s(p.x() - i), v = s(p.y() - j), w = s(p.z() - k);
  double sum = 0;
  for (int c = 0; c < 8; ++c)
    sum += number(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)) * (c & 1 ? u : 1 - u) * (c & 2 ? v : 1 - v) *
           (c & 4 ? w : 1 - w);
  return sum;
}

/// Through places by x, straight between.
template <size_t N>
double along(const double (&x)[N], const double (&y)[N], double at) {
  for (size_t i = 1; i < N; ++i)
    if (at <= x[i]) return y[i - 1] + (y[i] - y[i - 1]) * std::clamp((at - x[i - 1]) / (x[i] - x[i - 1]), 0., 1.);
  return y[N - 1];
}

/// How much of the scalp's hair is there: 0 to 1.
double hair(const Vec3& q) {
  // Height of the hairline by how far forwards a place lies: nape, behind and over the ear, sideburn, temple, forehead.
  static const double y[] = {-95, -62, -42, -26, -16, -4, 4, 20, 26, 40, 52, 62, 74, 88},
                      z[] = {-52, -52, -44, -18, -2, 8, 1, 0, 26, 46, 58, 72, 80, 80};
  static const Ear ear;
  constexpr double kFar_mm = 1000;
  const double line = along(y, z, q.y()) + 5 * (noise(q / 5) - 0.5) - 5 * ramp(0, 24, 24 - q.x()) * ramp(70, 84, q.y());
  return ramp(-3, 3, q.z() - line) * ramp(2, 5, ear.upon(kFar_mm, q) + 2 * (noise(q / 3) - 0.5));
}

double brow(const Vec3& q) {
  static const double x[] = {12, 20, 30, 40, 47, 53}, z[] = {28.2, 30.2, 32.6, 33.8, 32.0, 28.6},
                      h[] = {3.0, 4.2, 3.8, 3.0, 2.2, 1.0};
  if (q.x() < 10 || q.x() > 55 || q.y() < 60) return 0;
  const double off = std::abs(q.z() - along(x, z, q.x())) / along(x, h, q.x());
  return ramp(0, 1, 1.35 - off) * ramp(10, 14, q.x()) * ramp(0, 3, 55 - q.x()) *
         (0.72 + 0.28 * noise({1.3 * q.x() - 0.5 * q.z(), 0, 0.5 * q.z()}));
}

double vermilion(const Vec3& q) {
  if (q.x() > 27.5 || q.y() < 86) return 0;
  return ramp(-0.6, 0.6, Mouth::red_to_mm(q.x()) - q.z()) * ramp(-0.6, 0.6, q.z() - Mouth::red_from_mm(q.x()));
}

}  // namespace

Vec3 skin_colour(const Vec3& p) {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  const auto mix = [](const Vec3& a, const Vec3& b, double t) { return Vec3(a + std::clamp(t, 0., 1.) * (b - a)); };
  Vec3 c = kSkin;
  c = mix(c, kFlush,
          0.42 * spot(q, {40, 80, -16}, 15) + 0.28 * spot(q, {0, 120, -26}, 11) + 0.4 * spot(q, {14, 106, -28}, 8) +
              0.50 * spot(q, {82, -18, 4}, 22) + 0.20 * spot(q, {0, 98, -90}, 12));
  c = mix(c, kPale, 0.55 * spot(q, {0, 96, 58}, 30));
  c = mix(c, kShade, 0.45 * spot(q, {24, 84, 7}, 7) + 0.35 * spot(q, {33, 84, 24}, 9));
  // A shaven beard.
  if (q.y() > 0) {
    const double jaw = ramp(-34, -58, q.z()) * ramp(10, 40, q.y()) * ramp(-117, -100, q.z());
    const double lip = ramp(-37, -42, q.z()) * ramp(30, 22, q.x()) * ramp(80, 92, q.y());
    c = mix(c, kBeard, 0.40 * std::max(jaw, lip) * (0.7 + 0.5 * noise(q / 3)));
  }
  c *= 1 + 0.05 * (noise(p / 9) - 0.5) + 0.045 * (noise(p / 2.5 + Vec3(9, 9, 9)) - 0.5);
  c = mix(c, kVermilion * (0.95 + 0.1 * noise({q.x() / 1.2, q.y() / 6, q.z() / 6})), vermilion(q));
  // Where the lips meet.
  if (q.x() < 28 && q.y() > 86)
    c = mix(c, 0.42 * kVermilion,
            0.85 * elementary::exp(-1.6 * (q.z() - Mouth::line_mm(q.x())) * (q.z() - Mouth::line_mm(q.x()))));
  c = mix(c, kHair, 0.93 * hair(q) * (0.86 + 0.14 * noise({q.x() / 0.9, q.y() / 2.4, q.z() / 0.9})));
  c = mix(c, kHair, 0.88 * brow(q));
  // Nostrils and the ear's canal are dark.
  c *= 1 - 0.6 * spot(q, {7.2, 107, -28}, 3.0);
  // The eye.
  const Vec3 off = q - Eye::centre();
  if (std::abs(off.x()) < 20 && std::abs(off.z()) < 14 && q.y() > 70) {
    double low, high;
    Eye::margins(q.x(), low, high);
    const double into = std::min(high - q.z(), q.z() - low);
    const bool globe = into > 0.15 && off.norm() < 14.2 && q.x() > Eye::kEn_mm && q.x() < Eye::kEx_mm;
    if (globe) {
      const double r = Vec2(off.x(), off.z() + 0.2).norm();
      const double white = 1 - 0.30 * ramp(8, 15, std::abs(off.x())) - 0.25 * ramp(1.6, 0, high - q.z());
      Vec3 eye = mix(kPink, kWhite, ramp(17.5, 22, q.x()) * ramp(46, 43, q.x())) * white;
      const double spokes = 0.8 + 0.45 * noise({9 * off.x() / std::max(r, 0.5), 9 * off.z() / std::max(r, 0.5), r});
      eye = mix(eye, kIris * spokes, ramp(6.3, 5.6, r));
      eye = mix(eye, kLimbus, 0.75 * ramp(6.4, 5.8, r) * ramp(4.4, 5.6, r));
      c = mix(eye, kPupil, ramp(2.5, 1.9, r));
    } else {
      const double over = q.z() - high, under = low - q.z();
      if (q.x() > 19 && q.x() < Eye::kEx_mm)
        // Lashes stand where the lids are apart, and end before they meet.
        c = mix(c, kHair,
                ramp(2.5, 5, high - low) *
                    (0.85 * ramp(1.5, 0.2, std::abs(over)) + 0.35 * ramp(1.1, 0.1, std::abs(under))));
    }
  }
  return c.cwiseMax(0.).cwiseMin(1.);
}

namespace {

std::array<uint8_t, 4> bytes(const Vec3& c, double seen) {
  std::array<uint8_t, 4> out{};
  for (size_t k = 0; k < 3; ++k) out[k] = uint8_t(std::lround(255 * std::clamp(c[Eigen::Index(k)], 0., 1.)));
  out[3] = uint8_t(std::lround(255 * std::clamp(seen, 0., 1.)));
  return out;
}

}  // namespace

std::array<uint8_t, 4> colour_on_face(const Vec3& p) { return bytes(skin_colour(p), 1); }

std::array<uint8_t, 4> colour_on_bone(const Vec3& p) {
  static const Teeth upper(Teeth::Jaw::upper), lower(Teeth::Jaw::lower);
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  if (!upper.near(q, 2)) return {255, 255, 255, 0};
  const double teeth = std::min(upper.crowns(q), lower.crowns(q));
  return bytes(Vec3(0.945, 0.925, 0.865), 0.92 * ramp(0.5, 0.1, teeth));
}

}  // namespace limberg::anatomical
