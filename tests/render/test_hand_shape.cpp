// The drawn hand: where the sensors say, of one size, bending as the tips come together.
#include <gtest/gtest.h>

#include <cmath>

#include "render/hand_shape.h"

namespace limberg {
namespace test_hand_shape {

GlovePose at(float apart_mm, bool left = false) {
  GlovePose g;
  g.visible = true, g.left = left;
  // The thumb below and behind the forefinger's tip, as it is in a hand that points.
  g.forefinger_mm = Vec3f(10, 20, 30);
  g.pointing = Vec3f(1, 0.1f, -0.2f).normalized();
  const Vec3f way(-0.45f, left ? -0.3f : 0.3f, -0.84f);
  g.thumb_mm = g.forefinger_mm + apart_mm * way.normalized();
  g.closed = apart_mm < 25;
  const Vec3f across = way - way.dot(g.pointing) * g.pointing;
  g.thumbwards = across.normalized();
  return g;
}

/// mm by which the bones of a finger are longer or shorter than a hand's.
float misfit(const HandJoints& h, size_t f) {
  float worst = 0;
  for (size_t k = 0; k < 3; ++k)
    worst = std::max(worst, std::abs((h.finger[f][k + 1] - h.finger[f][k]).norm() - kFingerBones_mm[f][k]));
  return worst;
}

TEST(HandShape, TheTipsAreWhereTheSensorsSayAndTheBonesKeepTheirLength) {
  float bend = 1e9f;
  for (float apart = 10; apart <= 100; apart += 2) {
    const GlovePose g = at(apart);
    const HandJoints h = hand_joints(g);
    EXPECT_LT((h.finger[1][3] - g.forefinger_mm).norm(), 1e-3f);
    EXPECT_LT((h.finger[0][3] - g.thumb_mm).norm(), 1e-3f);
    EXPECT_LT(((h.finger[1][3] - h.finger[1][2]).normalized() - g.pointing).norm(), 1e-4f);
    for (size_t f = 1; f < HandJoints::kFingers; ++f) EXPECT_LT(misfit(h, f), 1e-3f);
    EXPECT_LT(misfit(h, 0), 0.5f) << apart;
    EXPECT_LT(h.bend_deg, bend + 0.5f) << "a wider hand bends its fingers less, at " << apart;
    bend = h.bend_deg;
  }
  EXPECT_GT(hand_joints(at(12)).bend_deg - hand_joints(at(90)).bend_deg, 25);
}

// What is moved as a whole is drawn moved as a whole, and a little motion moves every joint a little.
TEST(HandShape, ItMovesWithTheHandAndDoesNotJump) {
  const Eigen::Quaternionf turn(Eigen::AngleAxisf(1.1f, Vec3f(0.3f, -0.5f, 0.8f).normalized()));
  const Vec3f by(40, -70, 15);
  float most = 0;
  HandJoints last;
  for (float apart = 10; apart <= 100; apart += 0.5f) {
    GlovePose g = at(apart);
    g.closed = false;
    const HandJoints h = hand_joints(g);
    GlovePose moved = g;
    moved.forefinger_mm = turn * g.forefinger_mm + by, moved.thumb_mm = turn * g.thumb_mm + by;
    moved.pointing = turn * g.pointing, moved.thumbwards = turn * g.thumbwards;
    const HandJoints m = hand_joints(moved);
    for (size_t f = 0; f < HandJoints::kFingers; ++f)
      for (size_t k = 0; k < 4; ++k) {
        EXPECT_LT((m.finger[f][k] - (turn * h.finger[f][k] + by)).norm(), 0.3f) << apart;
        if (apart > 10) most = std::max(most, (h.finger[f][k] - last.finger[f][k]).norm());
      }
    last = h;
  }
  std::printf("at most %.2f mm for half a mm\n", double(most));
  EXPECT_LT(most, 4);
}

TEST(HandShape, AHandThatGripsBendsTheOtherFingersFurtherAndALeftOneIsTheMirrorImage) {
  GlovePose g = at(20);
  g.closed = false;
  const HandJoints open = hand_joints(g);
  g.closed = true;
  const HandJoints closed = hand_joints(g);
  for (size_t f = 2; f < HandJoints::kFingers; ++f)
    EXPECT_LT((closed.finger[f][3] - closed.finger[f][0]).norm(), (open.finger[f][3] - open.finger[f][0]).norm() - 2);
  EXPECT_LT((closed.finger[1][1] - open.finger[1][1]).norm(), 1e-3f);
  const auto mirrored = [](const Vec3f& x) { return Vec3f(x.x(), -x.y(), x.z()); };
  GlovePose m = g;
  m.left = true;
  m.forefinger_mm = mirrored(g.forefinger_mm), m.thumb_mm = mirrored(g.thumb_mm), m.pointing = mirrored(g.pointing);
  m.thumbwards = mirrored(g.thumbwards);
  const HandJoints left = hand_joints(m);
  for (size_t f = 0; f < HandJoints::kFingers; ++f)
    for (size_t k = 0; k < 4; ++k) EXPECT_LT((left.finger[f][k] - mirrored(closed.finger[f][k])).norm(), 0.3f);
}

}  // namespace test_hand_shape
}  // namespace limberg
