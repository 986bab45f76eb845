// All in the right half, x > 0: the left one is its mirror image.
#include "sim/imaging/anatomical/bone_shape.h"

#include "sim/base/elementary.h"
#include "sim/imaging/anatomical/teeth_shape.h"

namespace limberg::anatomical {
namespace {

constexpr double kScalp_mm = 5.6, kVault_mm = 6.6, kLeastSkin_mm = 2.8, kJoint_mm = 2.0, kBetweenTeeth_mm = 0.3;

// ---- skull ----
const Ellipsoid kBase({0, 12, -3}, {40, 48, 17}), kClivus({0, -10, -14}, {20, 22, 9}),
    kNuchal({0, -40, -9}, {46, 38, 13});
const Ellipsoid kMaxilla({0, 64, -24}, {31, 22.5, 26}), kEthmoid({0, 66, 8}, {14.5, 22, 19}),
    kWing({37, 57, 10}, {17, 20, 21});
const Ellipsoid kGlenoid({51, 9, 2}, {13, 15, 8});
const Tube kEminence{{43, 21.5, -4.5, 4.5}, {58, 20.5, -4, 4.5}};
const Tube kMastoid{{53, -14, 2, 12}, {52, -15, -12, 10}, {50, -15, -26, 6}};
const Tube kStyloid{{45, -6, -12, 4}, {41, 2, -34, 1.6}};
const Capsule kCondyleOfOcciput({13, -12, -18}, {17, -22, -19}, 5.5, 5.5);
const Tube kZygoma{{33, 70.5, -15, 8.5}, {43, 66, -13, 8}, {50.5, 58, -8, 7}};
const Tube kArch{{50.5, 57, -7.5, 5.2}, {57, 44, -5.6, 4.2}, {60.4, 28, -4, 3.9}, {60.4, 14, -1.5, 4}, {56, 2, 1, 5}};
const Tube kLateralRim{{51, 59, -7, 6.5}, {50.5, 61, 4, 5}, {50.2, 64, 15, 4.8}, {47.5, 67, 24, 5}};
const Tube kLowerRim{{15, 83, -1, 4.6}, {26, 80.5, -4, 5}, {38, 75, -5.8, 6}, {48, 66, -3, 6}};
const Tube kFrontalProcess{{8.5, 88.5, 20, 4.5}, {12.5, 86, 4, 4.6}, {15.5, 83, -12, 6.5}};
const Tube kNasal{{0, 85.8, 22, 5.6}, {0, 92, 12, 4.8}, {0, 99, 1, 3.2}},
    kNasalSide{{4.5, 85, 22, 5.5}, {6, 90, 10, 4.4}, {5.4, 95.5, 0, 2.6}};
const Tube kCanineWall{{17, 78, -14, 8.5}, {19, 80, -28, 6.5}, {17, 82, -38, 5.5}};
const Tube kUpperAlveolus{{-11, 84.5, -39, 5.6}, {0, 87.0, -39, 5.4}, {11, 84.5, -39, 5.6},
                          {19, 77, -38.5, 6},    {24, 66, -38, 6.2},  {25.5, 52, -37.5, 6}};
const Tube kSpine{{0, 83, -32, 5.5}, {0, 90, -30.6, 3.8}, {0, 93.4, -29.8, 2.4}},
    kBackSpine{{0, 50, -33, 3.2}, {0, 43, -32.4, 1.6}};
const Tube kPterygoid{{17, 47, -6, 5}, {17.5, 43, -20, 3.6}, {18.5, 40, -34, 2.6}};
// ---- what is taken away ----
const Ellipsoid kPiriform({0, 96, -17.5}, {11.8, 20, 12.5}), kNose({0, 62, -15.5}, {11.5, 36, 13.6}),
    kMouth({0, 60, -53}, {17.5, 30, 17.5});
const Capsule kPiriformTop({0, 99, -10}, {0, 106, -5}, 6, 5.2);
const Capsule kApex({28, 70, 14}, {18.5, 53, 12}, 12, 4), kInfratemporal({46, 50, -14}, {49, 30, -10}, 6, 11);
const Capsule kForamen({0, -24, -60}, {0, -24, 10}, 16, 16);
const Ellipsoid kMaxillarySinus({23.5, 62, -17}, {8.6, 12.5, 10.5}), kFrontalSinus({9, 87.6, 33}, {9, 3.4, 8});
const Capsule kOstium({22, 62, -10}, {8, 60, -10}, 2.8, 2.8), kDuct({5.5, 85.8, 29}, {5, 70, -8}, 2.7, 2.7);
const Ellipsoid kSphenoid({0, 18, 4}, {15, 16, 13}), kSella({0, 20, 17}, {7, 6, 6});
const Ball kJointBall{{51, 12, -8}, 26};

double orbit(const Vec3& q) {
  static const Ellipsoid e({0, 0, 0}, {19.5, 21, 17.2});
  static const double c = elementary::cos(20 * M_PI / 180), s = elementary::sin(20 * M_PI / 180);
  const Vec3 d = q - Vec3(31.5, 82, 15.8);
  return smin(e({c * d.x() - s * d.y(), s * d.x() + c * d.y(), d.z()}), kApex(q), 5);
}

double bump(const Vec3& q, const Vec3& c, double sd) { return elementary::exp(-(q - c).squaredNorm() / (2 * sd * sd)); }

// ---- mandible ----
const Tube kCondyle{{44.5, 11.4, -8.2, 4.2}, {50, 11.2, -7.6, 4.9}, {57, 10, -8, 4.2}};
const Tube kBehind{
    {50.5, 10.6, -11, 4.6}, {50, 9, -20, 4.6}, {49.4, 7, -34, 5.2}, {49.2, 6, -48, 5.6}, {48.8, 10, -60, 6}};
const Tube kCoronoid{{48.6, 33, -13, 2.4}, {48.4, 31.5, -24, 4.0}, {47.6, 30, -40, 5.2}, {43.5, 34, -53, 6}};
const Tube kRamus{{49, 18, -31, 4.6}, {48, 19, -42, 5.4}, {46.6, 20, -58, 6.4}};
const Tube kLowerBorder{{48.8, 10, -60, 6},   {44, 26, -70, 6.4}, {35.5, 45, -79.5, 6.6},
                        {24, 64, -86.5, 6.8}, {11, 77, -90, 6.8}, {0, 79.5, -90.6, 7}};
const Tube kBody{{44, 33, -55, 6.2}, {35.5, 47, -65, 7}, {26, 65, -73, 7}, {12, 78, -78, 6.6}, {0, 80.8, -79, 6.6}};
const Tube kLowerAlveolus{{34, 42, -60, 5},   {28, 53, -62.5, 5.4},     {24, 62, -64.5, 5.4},
                          {19, 74, -68, 5.4}, {10.5, 82.4, -70.5, 5.2}, {0, 84.6, -71, 5.0}};
const Ellipsoid kChin({0, 80.6, -90.5}, {15, 8.6, 7.6});

}  // namespace

struct BoneShape::Parts {
  const SkinShape& skin;
  Teeth upper{Teeth::Jaw::upper}, lower{Teeth::Jaw::lower};

  double braincase(const Vec3& q) const {  // outer table
    double d = skin.cranium(q) + kScalp_mm + 7 * bump(q, {66, 50, 22}, 20);
    // What lies beneath a plane from the roofs of the orbits to the nuchal line is face and base.
    static const Vec3 n = Vec3(0, 0.33, -0.944).normalized();
    return smax(d, n.dot(q - Vec3(0, 88, 21)), 9);
  }
  double brain(const Vec3& q) const {
    double d = skin.cranium(q) + kScalp_mm + kVault_mm + 8.5 * bump(q, {0, 92, 33}, 13) -
               2 * bump(q, {68, 10, 25}, 26) + 6 * bump(q, {66, 50, 22}, 20);
    const double floor = -15 + 15 * ramp(-12, 3, q.y()) + 31 * ramp(38, 55, q.y());
    d = smax(d, 0.75 * (floor - q.z()), 6);
    return smax(d, -smax(kSphenoid(q), -kSella(q), 3), 5);
  }
  double solid(const Vec3& q) const {
    double d = smin(braincase(q), smin(smin(kBase(q), kNuchal(q), 16), kClivus(q), 8), 12);
    d = smin(smin(d, kMaxilla(q), 8), kEthmoid(q), 5);
    d = join(join(d, kMastoid, q, 8), kStyloid, q, 4);
    d = join(smin(d, kGlenoid(q), 8), kEminence, q, 5);
    d = join(smin(d, kCondyleOfOcciput(q), 5), kZygoma, q, 6);
    d = join(join(d, kLateralRim, q, 6), kLowerRim, q, 5);
    d = join(join(d, kFrontalProcess, q, 5), kCanineWall, q, 6);
    d = join(smin(d, kWing(q), 8), kNasalSide, q, 4);
    return join(d, kNasal, q, 4);
  }
};

BoneShape::BoneShape(const SkinShape& skin) : parts_(new Parts{skin}) {}
BoneShape::~BoneShape() = default;

double BoneShape::upper_teeth(const Vec3& p) const { return parts_->upper.crowns({std::abs(p.x()), p.y(), p.z()}); }
double BoneShape::lower_teeth(const Vec3& p) const {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  return std::max(parts_->lower.crowns(q), kBetweenTeeth_mm - parts_->upper.crowns(q));
}

double BoneShape::skull(const Vec3& p) const {
  const Parts& a = *parts_;
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  double d = a.solid(q);
  d = smax(d, -a.brain(q), 2);
  d = smax(d, -kForamen(q), 4);
  d = smax(d, -orbit(q), 3);
  d = smax(d, -kInfratemporal(q), 5);
  d = join(d, kArch, q, 4);  // bridges the fossa
  d = join(d, kUpperAlveolus, q, 5);
  if (a.upper.near(q, 30)) d = smin(d, a.upper.roots(q), 2);
  d = smax(d, -kMouth(q), 4);
  d = smax(d, -smin(smin(kPiriform(q), kNose(q), 6), kPiriformTop(q), 4), 2.5);
  d = smax(d, -smin(kMaxillarySinus(q), kOstium(q), 2), 1);
  d = smax(d, -smin(kFrontalSinus(q), kDuct(q), 2), 1);
  d = join(join(d, kSpine, q, 3), kBackSpine, q, 3);
  d = join(d, kPterygoid, q, 4);
  if (kJointBall.holds(q)) d = smax(d, kJoint_mm - smin(smin(kCondyle(q), kBehind(q), 4), kCoronoid(q), 4), 1.5);
  if (d < 12) d = smax(d, a.skin(q) + kLeastSkin_mm, 1);
  if (a.upper.near(q, 20)) d = smin(d, a.upper.crowns(q), 1.2);
  return d;
}

double BoneShape::mandible(const Vec3& p) const {
  const Parts& a = *parts_;
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  double d = smin(kCondyle(q), kBehind(q), 5);
  d = join(join(d, kCoronoid, q, 7), kRamus, q, 9);
  d = join(join(d, kLowerBorder, q, 9), kBody, q, 10);
  d = smin(join(d, kLowerAlveolus, q, 7), kChin(q), 7);
  if (a.lower.near(q, 30)) d = smin(d, a.lower.roots(q), 2);
  if (d < 12) d = smax(d, a.skin(q) + kLeastSkin_mm, 1);
  if (a.lower.near(q, 20)) d = smin(d, lower_teeth(p), 1.2);
  return d;
}

}  // namespace limberg::anatomical
