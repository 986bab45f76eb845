#pragma once
// The joints of a drawn hand, from what a glove knows of it: the tips of forefinger and thumb, and which way the
// forefinger points.
//
// Inverse kinematics. The forefinger's three joints bend together (the last two in the ratio of 3 to 2, as a hand's do
// that grips); how far is found: the bend with which the thumb reaches its tip best, near to what fits the distance of
// the tips. The end of the forefinger lies at its tip and along its direction exactly; the turn about that direction is
// the one by which the thumb, where it is, opposes the forefinger's pad. Then the thumb reaches (FABRIK, Aristidou and
// Lasenby 2011).
// The other fingers follow: they bend with the forefinger, and further when the hand grips.
//
// Lengths are means of adults (Buryanov and Kotiuk 2010: bones of the hand by X-ray).
#include <array>

#include "render/tool_pose.h"

namespace limberg {

struct HandJoints {
  static constexpr size_t kFingers = 5;  // thumb, forefinger, middle, ring, little finger
  /// Of each finger, from the palm to the tip: the joint at the wrist's side, the two between, the tip.
  std::array<std::array<Vec3f, 4>, kFingers> finger;
  Vec3f wrist = Vec3f::Zero(), forearm = Vec3f::Zero();  // three centimetres behind it
  Vec3f dorsal = Vec3f::UnitZ();                         // unit, out of the back of the hand
  float bend_deg = 0;                                    // of the forefinger at its middle joint
};

/// Length of a finger's bones in mm, from the palm to the tip (the thumb's first is in its ball).
inline constexpr float kFingerBones_mm[HandJoints::kFingers][3] = {
    {46.2f, 31.6f, 25.5f}, {39.8f, 22.4f, 19.6f}, {44.6f, 26.3f, 21.3f}, {41.4f, 25.7f, 21.3f}, {32.7f, 18.1f, 19.7f}};

HandJoints hand_joints(const GlovePose& glove);

}  // namespace limberg
