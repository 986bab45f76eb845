#include "sim/imaging/synthetic/head_shape.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

using shape::Capsule;
using shape::Ellipsoid;
using shape::smax;
using shape::smin;

// All on the right side (x > 0) where they come in pairs: the caller mirrors.
const Ellipsoid kForehead({0, 62, 32}, {55, 32, 36}), kBase({0, 10, -3}, {40, 50, 16}),
    kMaxilla({0, 68, -28}, {31, 25, 27});
const Ellipsoid kSphenoid({0, 18, 0}, {14, 16, 13}), kSella({0, 20, 17}, {7, 6, 6}), kGlenoid({50, 2, 0}, {12, 16, 7});
const Capsule kMastoid({53, -12, -2}, {51, -14, -24}, 12, 7), kOccipitalCondyle({14, -12, -14}, {18, -22, -16}, 6, 6);
const Capsule kZygoma({36, 76, -14}, {53, 62, -6}, 9, 8), kLateralRim({53, 62, -4}, {51, 67, 24}, 5.5, 6.5),
    kLowerRim({17, 86, -1}, {37, 79, -7}, 5, 6);
const Capsule kFrontalProcess({9, 91, 18}, {15, 86, -14}, 6.5, 7), kInfraorbital({23, 78, -10}, {36, 73, -14}, 10, 10);
const Capsule kNasalSide({4, 86, 22}, {5.5, 95, -7}, 6, 5);
const Ellipsoid kWing({38, 60, 10}, {18, 22, 20});
const Capsule kNasal({0, 86.5, 22}, {0, 102.5, -5}, 6.5, 4.5), kSpine({0, 85, -38}, {0, 95.5, -35}, 5, 2.2);
const Capsule kArch[] = {
    {{53, 60, -6}, {60.5, 38, -4}, 5, 4}, {{60.5, 38, -4}, {62, 18, -1}, 4, 4}, {{62, 18, -1}, {57, 2, 1}, 4, 5}};
const Capsule kUpperArch[] = {{{0, 88.5, -47.5}, {13, 83.4, -47.5}, 7, 7},
                              {{13, 83.4, -47.5}, {22, 74, -47.5}, 7, 7},
                              {{22, 74, -47.5}, {27, 56, -47.5}, 7, 7}};
// Taken away.
const Ellipsoid kRoof({0, 66, 8}, {70, 34, 27}), kPiriform({0, 98, -21}, {11.5, 20, 13}),
    kNose({0, 64, -19}, {13.5, 36, 15.5}), kMouth({0, 62, -57}, {17, 28, 14});
const Capsule kPiriformTop({0, 100, -12}, {0, 106, -8}, 6, 5);
const Capsule kApex({28, 70, 14}, {17, 48, 11}, 12, 4), kFossa({47, 52, -12}, {50, 32, -9}, 6, 11);
const Capsule kForamen({0, -22, -60}, {0, -22, 20}, 16, 16);
const Ellipsoid kEye({31, 76, 14}, {12.5, 12.5, 12.5}), kMaxillarySinus({23, 66, -22}, {7, 12, 11}),
    kFrontalSinus({0, 84, 36}, {14, 4, 9});

/// The orbit's mouth: an ellipsoid that looks 22 degrees outwards.
double orbit_mouth(const Vec3& q) {
  static const Ellipsoid e({0, 0, 0}, {19, 21, 15.5});
  static const double c = elementary::cos(22 * M_PI / 180), s = elementary::sin(22 * M_PI / 180);
  const Vec3 d = q - Vec3(31, 82, 14.5);
  return e({c * d.x() - s * d.y(), s * d.x() + c * d.y(), d.z()});
}

// Skin beyond the thickened skull.
const Ellipsoid kCheek({35, 66, -34}, {18, 19, 24}), kMasseter({46, 26, -40}, {18, 24, 38}),
    kTemple({44, 42, 16}, {20, 30, 34}), kBuccal({42, 50, -36}, {18, 26, 34});
const Ellipsoid kFloor({0, 44, -80}, {32, 34, 17}), kInMouth({0, 56, -60}, {34, 27, 26}),
    kThroat({0, 34, -34}, {34, 26, 30}), kLid({31, 77, 14}, {15, 13.5, 13.5});
const Capsule kNeck({0, -20, -20}, {0, -26, -190}, 50, 55);
const Capsule kDorsum({0, 87.5, 20}, {0, 112.5, -25}, 3.5, 9), kTip({0, 108, -27}, {0, 115, -26}, 9, 8),
    kAla({8, 103, -29}, {11.5, 103, -29}, 6.5, 6), kColumella({0, 100, -38}, {0, 108, -33}, 7, 6);
const Capsule kUpperLip[] = {{{0, 100.5, -51}, {11, 98, -51}, 5.5, 5.2}, {{11, 98, -51}, {24, 88, -55}, 5.2, 4}};

/// Parts of one bent rod share their ends: no fillet between them, which would be a knot.
template <class Parts>
double rod(const Parts& parts, const Vec3& p) {
  double d = 1e300;
  for (const Capsule& c : parts) d = std::min(d, c(p));
  return d;
}

Vec3 right(const Vec3& p) { return {std::abs(p.x()), p.y(), p.z()}; }

/// A rim that leans backwards, and what fills it.
const Capsule kEar[] = {{{68, -3, 16}, {72, -8, 27}, 3.5, 3.5},   {{72, -8, 27}, {76, -20, 29}, 3.5, 3.5},
                        {{76, -20, 29}, {79, -27, 17}, 3.5, 3.5}, {{79, -27, 17}, {77, -22, 0}, 3.5, 3.5},
                        {{77, -22, 0}, {71, -9, -22}, 3.5, 4},    {{71, -9, -22}, {67, -3, -20}, 4, 4}};
const Capsule kConcha[] = {{{70, -12, 14}, {69, -10, -10}, 8, 7}, {{74.5, -17.5, 18}, {73, -14, -4}, 7.5, 6}};

double ear(const Vec3& q) { return smin(rod(kEar, q), rod(kConcha, q), 4); }

}  // namespace

HeadShape::HeadShape(const HeadSpec& s)
    : spec_(s),
      vault_({0, 2, 52}, {71 * s.vault_wide, 91 * s.vault_long, 66}),
      brain_({0, 2, 53}, {71 * s.vault_wide - 6.5, 91 * s.vault_long - 7, 59.5}) {
  const auto within = [](double v, double lo, double hi, const char* what) {
    if (!(v >= lo && v <= hi))
      throw InputError("", 0,
                       std::string(what) + " of a synthetic head must lie between " + std::to_string(lo) + " and " +
                           std::to_string(hi));
  };
  within(s.mandible_scale, 0.8, 1.2, "mandible_scale"), within(s.ramus_left, 0.7, 1.3, "ramus_left");
  within(s.vault_wide, 0.85, 1.2, "vault_wide"), within(s.vault_long, 0.85, 1.2, "vault_long"),
      within(s.forehead_flat, 0, 1, "forehead_flat");
  within(s.edge_mm, 1, 12, "edge_mm"), within(s.face_edge_mm, 1, 12, "face_edge_mm");

  for (double side : {1., -1.}) {
    const auto at = [&](double x, double y, double z) { return mandible_place({side * x, y, z}); };
    const auto line = [&](std::initializer_list<std::array<double, 4>> points) {
      const std::array<double, 4>* last = nullptr;
      rods_.emplace_back();
      for (const auto& p : points) {
        if (last)
          rods_.back().emplace_back(at((*last)[0], (*last)[1], (*last)[2]), at(p[0], p[1], p[2]), (*last)[3], p[3]);
        last = &p;
      }
    };
    line({{50, 11, -19, 5.5},
          {48, 9, -32, 6.5},
          {45, 8, -58, 6.5},
          {39, 36, -74, 7},
          {27, 62, -83, 7},
          {11, 78, -88, 7},
          {0, 80.5, -89, 7}});
    line({{45, 10, -17, 4.5}, {55, 10, -17, 4.5}});
    line({{46.5, 29, -20, 4},
          {46.5, 25, -36, 6},
          {44, 21, -60, 6.5},
          {37, 38, -66, 6.5},
          {26, 62, -73, 6.5},
          {10, 79, -76, 7},
          {0, 81.5, -76, 7}});
    line({{47.5, 18, -36, 5.5}, {45, 14, -58, 6}});
    line({{34, 44, -62, 5}, {24, 64, -63, 5}, {10, 81.5, -64, 5}, {0, 85.5, -64.5, 5}});
    line({{0, 83.5, -92, 6}, {9, 81.5, -92, 5}});
  }
  lower_lip_ = {{mandible_place({0, 98, -62.5}), mandible_place({11, 95.5, -62}), 5.5, 5.2},
                {mandible_place({11, 95.5, -62}), Vec3(24, 87.5, -57), 5.2, 4}};
  bump_ = {{{0, 97, 27}, 0.6, 6},   {{0, 107, -4}, -4.2, 8}, {{0, 100, -58}, 0.5, 12}, {{0, 96, -39}, 6.5, 8},
           {{0, 90, -90}, 4, 10},   {{68, 20, -2}, 1.5, 12}, {{-68, 20, -2}, 1.5, 12}, {{46, 18, -48}, 7, 18},
           {{-46, 18, -48}, 7, 18}, {{38, 62, -44}, 6, 17},  {{-38, 62, -44}, 6, 17}};
  for (Bump& b : bump_) {
    b.over_2s2 = 1 / (2 * b.over_2s2 * b.over_2s2);
    if (b.c.z() < -42) b.c = mandible_place(b.c);
  }
}

Vec3 HeadShape::mandible_place(const Vec3& p) const {
  const double rise = p.x() < 0 ? (1 - spec_.ramus_left) * 41 : 0;
  const double lifted = p.z() + rise * std::clamp((-17 - p.z()) / 41, 0., 1.) * std::clamp((82 - p.y()) / 60, 0., 1.);
  return {p.x(), p.y() > 12 ? 12 + (p.y() - 12) * spec_.mandible_scale : p.y(), lifted};
}

double HeadShape::solid(const Vec3& q) const {
  double vault = vault_(q), forehead = kForehead(q);
  if (spec_.forehead_flat > 0) {
    const Vec3 n = Vec3(0, 1, 0.12).normalized();
    const double plane = n.dot(q - Vec3(0, 95 - 12 * spec_.forehead_flat, 50));
    vault = smax(vault, plane, 12), forehead = smax(forehead, plane, 12);
  }
  double d = smin(smin(vault, forehead, 10), kBase(q), 10);
  d = smin(smin(d, kMaxilla(q), 10), kMastoid(q), 10);
  d = smin(smin(d, kGlenoid(q), 8), kOccipitalCondyle(q), 5);
  d = smin(smin(d, kZygoma(q), 5), kLateralRim(q), 5);
  d = smin(smin(d, kLowerRim(q), 5), kFrontalProcess(q), 5);
  d = smin(smin(d, kInfraorbital(q), 5), kWing(q), 8);
  d = smin(smin(d, kNasalSide(q), 5), kNasal(q), 5);
  return smin(smin(d, rod(kUpperArch, q), 5), rod(kArch, q), 4);
}

double HeadShape::brain(const Vec3& p) const {
  const Vec3 q = right(p);
  double b = smax(brain_(q), -(q.z() + 2 + 0.1 * q.y()) / 1.005, 8);
  if (spec_.forehead_flat > 0)
    b = smax(b, Vec3(0, 1, 0.12).normalized().dot(q - Vec3(0, 88 - 12 * spec_.forehead_flat, 50)), 12);
  return smax(smax(b, -kRoof(q), 8), -smax(kSphenoid(q), -kSella(q), 3), 5);
}

double HeadShape::orbit(const Vec3& p) const {
  const Vec3 q = right(p);
  return smin(orbit_mouth(q), kApex(q), 5);
}

double HeadShape::airway(const Vec3& p) const {
  const Vec3 q = right(p);
  return smin(smin(kPiriform(q), kNose(q), 6), kPiriformTop(q), 4);
}

double HeadShape::skull(const Vec3& p) const {
  const Vec3 q = right(p);
  double d = solid(q);
  d = smax(d, -brain(p), 2);
  d = smax(d, -kForamen(q), 4);
  d = smax(d, -orbit(p), 4);
  d = smax(d, -kFossa(q), 5);
  d = smin(d, rod(kArch, q), 4);  // the arches bridge the fossa
  d = smax(d, -kMouth(q), 5);
  d = smax(d, -airway(p), 3);
  return smin(d, kSpine(q), 3);
}

double HeadShape::mandible(const Vec3& p) const {
  const size_t half = rods_.size() / 2;  // each side by itself, so that left and right are treated alike
  double side[2];
  for (size_t s = 0; s < 2; ++s) {
    side[s] = rod(rods_[s * half], p);
    for (size_t i = 1; i < half; ++i) side[s] = smin(side[s], rod(rods_[s * half + i], p), 5);
  }
  return smin(side[0], side[1], 3);
}

double HeadShape::skin(const Vec3& p) const {
  const Vec3 q = right(p);
  double d = smin(solid(q), mandible(p), 8);
  d = smin(smin(smin(d, kInMouth(q), 10), kThroat(q), 10), kFloor(q), 10);
  double thick = 5.5;
  for (const Bump& b : bump_) thick += b.mm * elementary::exp(-(p - b.c).squaredNorm() * b.over_2s2);
  d -= thick;
  d = smin(smin(d, kCheek(q), 12), kMasseter(q), 12);
  d = smin(smin(d, kTemple(q), 12), kNeck(q), 12);
  d = smin(smin(d, kBuccal(q), 12), kLid(q), 6);
  d = smin(d, smin(rod(kUpperLip, q), rod(lower_lip_, q), 3), 6);
  const double nose = smin(smin(kDorsum(q), kTip(q), 5), smin(kAla(q), kColumella(q), 4), 5);
  d = smin(d, nose, 5);
  return smin(d, ear(q), 4);
}

double HeadShape::sinus(const Vec3& p) const {
  const Vec3 q = right(p);
  return std::min(kMaxillarySinus(q), kFrontalSinus(q));
}

double HeadShape::eye(const Vec3& p) const { return kEye(right(p)); }

}  // namespace limberg
