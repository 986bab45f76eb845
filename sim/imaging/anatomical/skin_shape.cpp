// All in the right half, x > 0: the left one is its mirror image.
#include "sim/imaging/anatomical/skin_shape.h"

#include "sim/imaging/anatomical/ear_shape.h"
#include "sim/imaging/anatomical/eye_shape.h"
#include "sim/imaging/anatomical/mouth_shape.h"
#include "sim/imaging/anatomical/nose_shape.h"

namespace limberg::anatomical {
namespace {

/// Half a level section of the head, without eyes, nose, lips and ears: where skin lies.
struct Section {
  double z;
  std::initializer_list<std::array<double, 2>> xy;
};
const Section kSections[] = {
    {100, {{0, 75}, {25, 70}, {45, 52}}},
    {80, {{0, 89}, {22, 85}, {40, 74}, {56, 52}, {67, 20}, {69, -15}}},
    {62, {{0, 96.5}, {20, 93.5}, {38, 85}, {53, 66}, {64, 42}, {72, 10}, {75.5, -14}}},
    {46, {{0, 99.5}, {20, 97.5}, {36, 90.5}, {50, 76}, {58, 60}, {65, 40}, {72, 10}, {75, -14}}},
    {34, {{0, 100.5}, {12, 100.3}, {24, 98}, {36, 92.5}, {47, 83}, {54, 71}, {58, 58}, {65, 36}, {71, 8}}},
    {26, {{8, 98}, {18, 96}, {29, 94.2}, {40, 89}, {50, 77}, {58, 55}, {66, 30}, {71.5, -20}}},
    {14, {{14, 87}, {22, 79}, {31, 76.5}, {41, 74}, {49, 70.5}, {56, 59}, {64, 40}, {69, 22}}},
    {2, {{15, 89}, {24, 84}, {33, 80.5}, {43, 77}, {52, 69.5}, {60, 53}, {66, 34}, {68.5, 20}, {69, -25}}},
    {-10, {{17, 92}, {26, 88.5}, {36, 84.5}, {46, 78}, {55, 66}, {62, 49}, {67, 31}, {68, 18}}},
    {-24, {{20, 92.5}, {28, 89}, {38, 82}, {47, 72.5}, {55, 58.5}, {61, 40}, {64.5, 22}, {62, -22}}},
    {-38, {{0, 104.5}, {10, 103.5}, {20, 97}, {30, 89}, {39, 79}, {47, 66.5}, {54, 51}, {59.5, 32}, {61, 14}}},
    {-45, {{0, 106.8}, {9, 105.6}, {17, 101.2}}},
    {-50, {{24, 94.5}, {33, 86}, {41, 74.5}, {48, 61}, {54, 45}, {58, 26}, {59, 10}, {0, -74}}},
    {-55, {{0, 104.6}, {9, 103.2}, {17, 98.8}}},
    {-63, {{24, 94}, {33, 83}, {41, 70}, {47, 56}, {52.5, 40}, {56.5, 22}, {56.5, 6}}},
    {-66, {{0, 100.6}, {9, 99.6}, {17, 95.8}}},
    {-74, {{0, 97}, {10, 96}, {20, 91.5}, {30, 81}, {38, 67}, {45, 52}, {50.5, 35}, {53, 18}, {51, 4}}},
    {-84, {{0, 99.4}, {10, 97.6}, {20, 90.5}, {29, 78.5}, {36, 64}, {43, 47}, {47.5, 30}, {49, 14}}},
    {-92, {{0, 99.8}, {10, 97.6}, {19, 89.5}, {27, 76.5}, {34, 61}, {40, 44}}},
    {-100, {{0, 96}, {9, 93}, {16, 86}, {22, 75}}},
};
/// Beneath the jaw, and the neck.
const Vec3 kBeneath[] = {{0, 85, -105},  {9, 83, -104.4}, {0, 70, -105},  {0, 55, -106},  {0, 42, -109},
                         {16, 68, -103}, {18, 50, -104},  {24, 40, -103}, {34, 38, -98},  {38, 20, -97},
                         {0, 34, -118},  {20, 28, -118},  {40, 10, -112}, {55, -18, -100}};

const Ellipsoid kVault({0, 2, 48}, {75.5, 97, 81}), kMidface({0, 42, -22}, {61, 52, 50}),
    kFloor({0, 42, -72}, {42, 44, 30}), kOcciput({0, -38, 22}, {60, 57, 47});
const Tube kJaw{{51, 14, -14, 10}, {45, 12, -56, 10},  {36, 40, -79, 10},
                {23, 70, -87, 10}, {8, 86, -90.5, 10}, {-8, 86, -90.5, 10}};

const Tube kSternomastoid{{53, -14, -24, 8}, {46, -9, -60, 8.5}, {34, 6, -95, 8}, {17, 19, -140, 7}};

double base(const Vec3& q) {
  double d = smin(smin(kVault(q), kOcciput(q), 30), kMidface(q), 22);
  d = smin(smin(d, kFloor(q), 16), kJaw(q), 20);
  // The neck: a cylinder, wider than deep, that leans forwards, with both sternocleidomastoids.
  const double neck = Vec2(q.x() * 54 / 56, q.y() + 21 - 0.13 * (q.z() + 75)).norm() - 54;
  d = smin(d, smax(neck, q.z() + 20, 30), 26);
  return join(d, kSternomastoid, q, 14);
}

}  // namespace

struct SkinShape::Parts {
  std::unique_ptr<Pull> pull;
  Eye eye;
  Nose nose;
  Mouth mouth;
  Ear ear;
};

SkinShape::SkinShape(RightLids right) : bare_(right == RightLids::bare) {
  auto parts = std::make_unique<Parts>();
  std::vector<Vec3> at(std::begin(kBeneath), std::end(kBeneath));
  for (const Section& s : kSections)
    for (const auto& [x, y] : s.xy) at.emplace_back(x, y, s.z);
  std::vector<double> off;
  for (const Vec3& p : at) off.push_back(-base(p));
  parts->pull = std::make_unique<Pull>(at, off, 55, true, 0.05);
  parts_ = std::move(parts);
}
SkinShape::~SkinShape() = default;

double SkinShape::cranium(const Vec3& p) const {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  const double d = smin(kVault(q), kOcciput(q), 30), w = ramp(-2, 22, q.z());
  return d < 40 && w > 0 ? d + w * (*parts_->pull)(q) : d;
}

double SkinShape::operator()(const Vec3& p) const {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  double d = base(q);
  if (d < 30) d += (*parts_->pull)(q);
  if (d > 60) return d - 20;
  d = parts_->mouth.upon(d, q);
  d = parts_->nose.upon(d, q);
  d = bare_ && p.x() > 0 ? parts_->eye.lids_upon(d, q) : parts_->eye.upon(d, q);
  return parts_->ear.upon(d, q);
}

}  // namespace limberg::anatomical
