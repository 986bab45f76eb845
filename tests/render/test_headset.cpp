// The views of a headset: as those of a camera where they are the same.
#include <gtest/gtest.h>

#include <cmath>

#include "render/headset.h"

namespace limberg {
namespace test_headset {

TEST(Headset, AnEyeThatSeesEvenlyIsACamera) {
  Camera c;
  c.eye_mm = {10, 20, 300}, c.target_mm = {10, 20, 0}, c.up = Vec3f::UnitY(), c.fov_deg = 40;
  const float half = 20 * 3.14159265f / 180, wide = std::atan(1.5f * std::tan(half));
  const View a = c.view(1.5),
             b = eye_view(c.eye_mm, Eigen::Quaternionf::Identity(), {-wide, wide, half, -half}, c.near_mm, c.far_mm);
  EXPECT_LT((a.to_eye - b.to_eye).norm(), 1e-4f);
  EXPECT_LT((a.projection - b.projection).norm(), 1e-3f);
}

TEST(Headset, WhatLiesOnTheEdgeOfAnAngleLiesOnTheEdgeOfThePicture) {
  const EyeAngles angles{-0.9f, 0.6f, 0.7f, -0.8f};  // an outer and an inner side, as eyes have
  const Eigen::Quaternionf turned(Eigen::AngleAxisf(0.4f, Vec3f(0.2f, 1, -0.3f).normalized()));
  const Vec3f at(5, -70, 110);
  const View v = eye_view(at, turned, angles);
  const auto px = [&](float right, float up) {
    return v.to_pixel(at + turned * Vec3f(200 * std::tan(right), 200 * std::tan(up), -200), 1000, 800);
  };
  EXPECT_NEAR(px(angles.left, 0).x(), 0, 0.05);
  EXPECT_NEAR(px(angles.right, 0).x(), 1000, 0.05);
  EXPECT_NEAR(px(0, angles.up).y(), 0, 0.05);
  EXPECT_NEAR(px(0, angles.down).y(), 800, 0.05);
}

}  // namespace test_headset
}  // namespace limberg
