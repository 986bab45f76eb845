#include "render/hand_shape.h"

#include <algorithm>
#include <cmath>

namespace limberg {

namespace {

constexpr float kDegree = 3.14159265f / 180;

// The palm's frame: x along the fingers, y towards the thumb, z out of its back; the wrist in the origin.
const std::array<Vec3f, HandJoints::kFingers> kKnuckle{
    {{20, 20, -9}, {84, 24, 0}, {84, 3, 3}, {77, -16, 2}, {69, -33, -2}}};
constexpr float kSplay_deg[HandJoints::kFingers] = {0, 4, 0, -5, -11};
const Vec3f kThumbAtRest = Vec3f(0.72f, 0.6f, -0.35f);  // its direction in an open hand

/// The joints of a finger that bends by `bend` (0 straight, 1 closed), in the palm's frame.
std::array<Vec3f, 4> bent_finger(size_t f, float bend) {
  std::array<Vec3f, 4> p;
  p[0] = kKnuckle[f];
  const float middle = 95 * bend, angle[3] = {62 * bend, middle, middle * 2 / 3}, splay = kSplay_deg[f] * (1 - bend);
  float sum = 0;
  for (size_t k = 0; k < 3; ++k) {
    sum += angle[k];
    const float c = std::cos(sum * kDegree), s = std::sin(sum * kDegree), w = splay * kDegree;
    p[k + 1] = p[k] + kFingerBones_mm[f][k] * Vec3f(c * std::cos(w), c * std::sin(w), -s);
  }
  return p;
}

/// Out of the pad of a finger's end.
Vec3f palmar(const std::array<Vec3f, 4>& finger) {
  const Vec3f u = (finger[3] - finger[2]).normalized();
  return Vec3f(u.z(), 0, -u.x()).normalized();
}

/// Where the thumb's tip likes to be: in an open hand away from the palm, in a closed one at the forefinger's pad.
Vec3f thumb_at_rest(const std::array<Vec3f, 4>& forefinger, float open) {
  const float length = kFingerBones_mm[0][0] + kFingerBones_mm[0][1] + kFingerBones_mm[0][2];
  const Vec3f spread = kKnuckle[0] + 0.97f * length * kThumbAtRest.normalized();
  return open * spread + (1 - open) * (forefinger[3] + 12 * palmar(forefinger) + Vec3f(0, 2, 0));
}

/// The thumb's joints with its tip as near to `to` as they reach (palm's frame).
std::array<Vec3f, 4> reach(const Vec3f& to) {
  const Vec3f root = kKnuckle[0];
  std::array<Vec3f, 4> p;
  // From a thumb that bows away from the palm: its joints bend the way that they can.
  const Vec3f d = (to - root).normalized();
  Vec3f bow = Vec3f(-0.2f, 0.8f, 0.5f);
  bow = (bow - bow.dot(d) * d).normalized();
  const float share[4] = {0, 0.42f, 0.74f, 1}, far = (to - root).norm();
  const auto height = [&](size_t bone, float along) {
    const float l = kFingerBones_mm[0][bone];
    return std::sqrt(std::max(4.0f, l * l - along * along));
  };
  const float out[4] = {0, height(0, share[1] * far), height(2, (1 - share[2]) * far), 0};
  for (size_t k = 0; k < 4; ++k) p[k] = root + share[k] * (to - root) + out[k] * bow;
  for (int round = 0; round < 400; ++round) {
    p[3] = to;
    for (size_t k = 3; k-- > 0;) p[k] = p[k + 1] + kFingerBones_mm[0][k] * (p[k] - p[k + 1]).normalized();
    p[0] = root;
    for (size_t k = 0; k < 3; ++k) p[k + 1] = p[k] + kFingerBones_mm[0][k] * (p[k + 1] - p[k]).normalized();
  }
  return p;
}

struct Fit {
  float cost = 1e30f, bend = 0;
  Eigen::Matrix3f turn;  // of the palm's frame
  Vec3f wrist, thumb;    // thumb: the tip in the palm's frame
};

/// With that bend of the forefinger. `side`: -1 mirrors y, a left hand.
Fit fit(float bend, float likely, float open, const Vec3f& tip, const Vec3f& along, const Vec3f& thumb,
        const Vec3f& thumbwards, float side) {
  const std::array<Vec3f, 4> f = bent_finger(1, bend);
  const auto hand = [&](const Vec3f& x) { return Vec3f(x.x(), side * x.y(), x.z()); };
  const Vec3f end = hand(f[3]), u = hand(f[3] - f[2]).normalized();
  const Eigen::Quaternionf first = Eigen::Quaternionf::FromTwoVectors(u, along);
  // The thumb opposes the forefinger's pad, from its side.
  const Vec3f is = first * hand(0.9f * palmar(f) + 0.45f * Vec3f::UnitY());
  const float roll = std::atan2(along.dot(is.cross(thumbwards)), is.dot(thumbwards));
  Fit out;
  out.bend = bend;
  out.turn = (Eigen::AngleAxisf(roll, along) * first).toRotationMatrix();
  out.wrist = tip - out.turn * end;
  out.thumb = hand(out.turn.transpose() * (thumb - out.wrist));
  const float length = kFingerBones_mm[0][0] + kFingerBones_mm[0][1] + kFingerBones_mm[0][2];
  const float far = (out.thumb - kKnuckle[0]).norm(), over = std::max({0.0f, far - 0.99f * length, 42 - far});
  const float strained = (out.thumb - thumb_at_rest(f, open)).norm();
  out.cost = 30 * over * over + 0.03f * strained * strained + 900 * (bend - likely) * (bend - likely);
  return out;
}

}  // namespace

HandJoints hand_joints(const GlovePose& g) {
  constexpr float kClosed_mm = 10, kOpen_mm = 85;
  const float side = g.left ? -1.0f : 1.0f;
  const float apart = (g.thumb_mm - g.forefinger_mm).norm();
  const float open = std::clamp((apart - kClosed_mm) / (kOpen_mm - kClosed_mm), 0.0f, 1.0f);
  const float likely = 0.45f - 0.35f * open;
  const Vec3f along = g.pointing.norm() > 1e-6f ? Vec3f(g.pointing.normalized()) : Vec3f(Vec3f::UnitX());
  // The nearer the tips, the less they tell of the turn about the forefinger.
  constexpr float kTells_mm = 40;
  Vec3f across = g.thumb_mm - g.forefinger_mm;
  across -= across.dot(along) * along;
  across += std::max(0.0f, kTells_mm - across.norm()) * (g.thumbwards - g.thumbwards.dot(along) * along);
  const auto with = [&](float bend) {
    return fit(bend, likely, open, g.forefinger_mm, along, g.thumb_mm, across, side);
  };
  // Coarsely, then finely: what lies between two bends is no corner.
  constexpr int kSteps = 24;
  Fit best;
  for (int k = 0; k <= kSteps; ++k)
    if (const Fit f = with(float(k) / kSteps); f.cost < best.cost) best = f;
  for (float step = 0.5f / kSteps; step > 2e-4f; step *= 0.5f)
    for (const float b : {best.bend - step, best.bend + step})
      if (b >= 0 && b <= 1)
        if (const Fit f = with(b); f.cost < best.cost) best = f;

  HandJoints h;
  const auto place = [&](const Vec3f& x) { return Vec3f(best.wrist + best.turn * Vec3f(x.x(), side * x.y(), x.z())); };
  // The other fingers lie in the palm further than the forefinger, which points; those of a hand that grips still more.
  const float in_palm = g.closed ? 0.3f : 0.2f;
  for (size_t f = 0; f < HandJoints::kFingers; ++f) {
    const float bend = f == 1 ? best.bend : std::min(0.9f, best.bend + 0.05f * float(f) + in_palm);
    const std::array<Vec3f, 4> p = f == 0 ? reach(best.thumb) : bent_finger(f, bend);
    for (size_t k = 0; k < 4; ++k) h.finger[f][k] = place(p[k]);
  }
  h.finger[0][3] = g.thumb_mm;  // it is there, whatever the hand's size
  h.wrist = place(Vec3f::Zero()), h.forearm = place(Vec3f(-30, -3, 2));
  h.dorsal = best.turn.col(2);
  h.bend_deg = 95 * best.bend;
  return h;
}

}  // namespace limberg
