// Forms of known size: a cone, a parallel wound, a stretched skin.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "sim/measure/skin_shape.h"
#include "tests/sim/measure/views.h"

namespace limberg {
namespace test_skin_shape {

TEST(DogEar, ConeHasItsHeightAndVolume) {
  const auto body = measured_block({60, 60, 10}, 0.5);
  const Skin skin(body);
  const SurfaceView v = view_of(*body);
  const Vec2 c(7, -4);
  const double h = 5, R = 12;
  const auto cone = [&](const Vec3& X) {
    const double r = (X.head<2>() - c).norm();
    return Vec3(X.x(), X.y(), X.z() + (X.z() == 0 ? h * std::max(0.0, 1 - r / R) : 0));
  };
  const auto x = deformed(v, cone);
  const DogEar d = dog_ear(v, x, skin);
  const double cell = 0.5;
  EXPECT_NEAR(d.height_mm, h, h / R * cell);  // the apex lies within a cell of a vertex
  EXPECT_LT((d.at_mm.head<2>() - c).norm(), cell);
  const double volume = std::numbers::pi * R * R * h / 3;
  EXPECT_NEAR(d.volume_mm3, volume, 0.005 * volume);  // facets of 0.5 mm on a circle of 12
  // A field elsewhere sees nothing; one around the apex as much.
  const Vec3 far(-20, 15, 0), near(c.x(), c.y(), 0);
  EXPECT_EQ(dog_ear(v, x, skin, std::span(&far, 1), 5).volume_mm3, 0);
  EXPECT_NEAR(dog_ear(v, x, skin, std::span(&near, 1), 13).volume_mm3, d.volume_mm3, 1e-9);
  // A pit is no ear.
  const auto pit = deformed(v, [&](const Vec3& X) { return Vec3(X.x(), X.y(), 2 * X.z() - cone(X).z()); });
  EXPECT_EQ(dog_ear(v, pit, skin).height_mm, 0);
  EXPECT_EQ(dog_ear(v, pit, skin).volume_mm3, 0);
  EXPECT_NEAR(dog_ear(v, pit, skin).rms_mm, d.rms_mm, 1e-6);
}

TEST(DogEar, APieceThatNothingHoldsIsNone) {
  const auto body = measured_block({60, 60, 10}, 2);
  const Skin skin(body);
  SurfaceView v = view_of(*body);
  const size_t own = v.X_mm.size();
  const auto n = int32_t(own);
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(6, 0, 0), Vec3(0, 6, 0), Vec3(1, 1, -2)}) v.X_mm.push_back(p);
  v.tri.push_back({n, n + 1, n + 2}), v.kind.push_back(FaceKind::skin);
  for (const Tri& t : {Tri{n, n + 3, n + 1}, Tri{n + 1, n + 3, n + 2}, Tri{n + 2, n + 3, n}})
    v.tri.push_back(t), v.kind.push_back(FaceKind::wall);
  auto x = deformed(v, [](const Vec3& X) { return X.z() == 0 && X.norm() < 5 ? Vec3(X + Vec3(0, 0, 1.5)) : X; });
  for (size_t i = own; i < x.size(); ++i) x[i].z() += 569;
  const DogEar d = dog_ear(v, x, skin);
  EXPECT_NEAR(d.height_mm, 1.5, 1e-5);
  EXPECT_LT(d.volume_mm3, 200);
}

TEST(WoundGape, ParallelBanks) {
  const SurfaceView v = two_banks(30);
  for (double w : {0.0, 0.3, 2.0, 7.5}) {
    const auto x = deformed(v, [](const Vec3& X) { return X; });
    auto open = x;
    for (size_t i = open.size() / 2; i < open.size(); ++i) open[i].x() += float(w);
    const WoundGape g = wound_gape(v, open);
    EXPECT_NEAR(g.gape_mm, w, 1e-5);  // float positions
    EXPECT_NEAR(g.mean_mm, w, 1e-5);
    EXPECT_NEAR(g.rim_length_mm, 60, 1e-9);
  }
}

TEST(WoundGape, WedgeOpensToItsEnd) {
  const SurfaceView v = two_banks(40);
  auto x = deformed(v, [](const Vec3& X) { return X; });
  for (size_t i = x.size() / 2; i < x.size(); ++i) x[i].x() += 0.1f * x[i].y();
  const WoundGape g = wound_gape(v, x);
  EXPECT_NEAR(g.gape_mm, 3.8, 0.1);  // 95 % of a ramp to 4 mm, square to a bank that leans by 1/10
  EXPECT_NEAR(g.mean_mm, 2.0, 0.05);
}

TEST(WoundGape, OverlappingBanksAreClosedAndNoWoundIsNone) {
  const SurfaceView v = two_banks(20);
  auto x = deformed(v, [](const Vec3& X) { return X; });
  for (size_t i = x.size() / 2; i < x.size(); ++i) x[i].x() -= 0.4f;
  EXPECT_LE(wound_gape(v, x).gape_mm, 0.4 + 1e-5);
  const auto body = measured_block({20, 16, 5}, 2);
  const SurfaceView whole = view_of(*body);
  EXPECT_EQ(wound_gape(whole, deformed(whole, [](const Vec3& X) { return X; })).rim_length_mm, 0);
}

// Banks that meet but for a stretch of 4 mm between two stitches: 95 % of a rim of 100 mm cannot tell.
TEST(WoundGape, AStretchBetweenStitchesIsSeenWhere95PercentAreNot) {
  const SurfaceView v = two_banks(100);
  auto x = deformed(v, [](const Vec3& X) { return X; });
  for (size_t i = x.size() / 2; i < x.size(); ++i)
    if (x[i].y() >= 40 && x[i].y() <= 44) x[i].x() += 5;
  const WoundGape g = wound_gape(v, x);
  EXPECT_LT(g.gape_mm, kOpen_mm);
  EXPECT_GT(g.widest_mm, 4);
  EXPECT_NEAR(g.widest_at_mm.y(), 42, 2.5);
  EXPECT_GE(g.open_mm, 6);   // of both banks
  EXPECT_LE(g.open_mm, 14);  // and little more than that
  EXPECT_EQ(g.lost_mm, 0);
  EXPECT_EQ(wound_gape(v, deformed(v, [](const Vec3& X) { return X; })).open_mm, 0);
}

// A crumpled triangle has no way across its edge. What its neighbours look at is looked at from there too, unless the
// bit is as long as an eye would see.
TEST(WoundGape, AShortStretchThatLooksElsewhereIsAsFarAsItsNeighbours) {
  for (const double edge_mm : {0.25, 1.0}) {
    SurfaceView v = two_banks(40);
    for (size_t i = 0; i < v.X_mm.size(); ++i) {
      Vec3 X = v.X_mm[i];
      X.y() *= edge_mm;
      v.X_mm.set(i, X);
    }
    auto x = deformed(v, [](const Vec3& X) { return X; });
    for (size_t i = x.size() / 2; i < x.size(); ++i) x[i].x() += 1.7f;
    EXPECT_EQ(wound_gape(v, x).open_mm, 0);
    x[3 * 20 + 1].x() -= 0.8f;  // a point of the edge draws back, and the skin behind it has no area left
    for (const size_t k : {19, 20, 21}) x[3 * k] = x[3 * k + 1];
    const WoundGape g = wound_gape(v, x);
    EXPECT_EQ(g.lost_mm > 0, edge_mm == 1) << edge_mm;
    EXPECT_LT(g.widest_mm, 1.7 + 0.8 + edge_mm);
  }
}

// A cut of 20 mm with both its ends, closed and opened as a lens: round them one sees the other bank of the same edge.
TEST(WoundGape, RoundTheEndsOfACutTheOtherBankIsSeen) {
  SurfaceView v = two_banks(20);
  const auto half = int32_t(v.X_mm.size() / 2);
  for (Tri& t : v.tri)
    for (int32_t& i : t)
      if (i == half + 1 || i == half + 3 * 20 + 1) i -= half;  // the banks' first and last points are one
  const auto lens = [&](double width) {
    auto x = deformed(v, [](const Vec3& X) { return X; });
    for (int32_t j = 1; j < 20; ++j)
      x[size_t(half + 3 * j + 1)].x() += float(width * std::sin(std::numbers::pi * j / 20));
    return wound_gape(v, x);
  };
  const WoundGape closed = lens(0), open = lens(1.5);
  EXPECT_EQ(closed.rim_length_mm, 40);
  EXPECT_LT(closed.gape_mm, 1e-6);
  EXPECT_LT(closed.mean_mm, 1e-6);
  EXPECT_LE(open.gape_mm, open.widest_mm);
  EXPECT_NEAR(open.widest_mm, 1.5, 0.02);
  EXPECT_NEAR(open.mean_mm, 1.5 * 2 / std::numbers::pi, 0.05);  // of a sine; banks lean by up to 0.24
  EXPECT_EQ(open.open_mm, 0);
}

// The last skin of one bank is crumpled, so that its edges look away from the other bank, which they lie at.
TEST(WoundGape, RoundTheEndOfACutACrumpledEdgeStillSeesTheOtherBank) {
  SurfaceView v = two_banks(20);
  const auto half = int32_t(v.X_mm.size() / 2);
  for (Tri& t : v.tri)
    for (int32_t& i : t)
      if (i == half + 1 || i == half + 3 * 20 + 1) i -= half;
  auto x = deformed(v, [](const Vec3& X) { return X; });
  for (const int32_t j : {0, 1, 2}) x[size_t(half + 3 * j)].x() = -1;  // behind the edge, on the other bank's side
  EXPECT_LT(wound_gape(v, x).widest_mm, 1e-6);
  for (const int32_t j : {1, 2}) x[size_t(half + 3 * j + 1)].x() += 0.8f;  // where it does open it is seen to
  EXPECT_NEAR(wound_gape(v, x).widest_mm, 0.8, 0.05);
}

// A flap's tip of 30 degrees that lies far from its wound: what is behind its edge's back is no other bank.
TEST(WoundGape, TheOtherSideOfATipIsNoBank) {
  SurfaceView v;
  constexpr int n = 20;
  v.X_mm = {Vec3(0, 0, 0), Vec3(0, 0, -3)};
  for (int j = 1; j <= n; ++j)
    for (const double side : {-1.0, 1.0})
      for (const double z : {0.0, -3.0}) v.X_mm.push_back({side * j * std::tan(std::numbers::pi / 12), double(j), z});
  const auto at = [](int j, int side) { return j == 0 ? 0 : 2 + 4 * (j - 1) + 2 * side; };
  const auto add = [&](int a, int b, int c, FaceKind kind) { v.tri.push_back({a, b, c}), v.kind.push_back(kind); };
  for (int j = 0; j < n; ++j) {
    add(at(j, 0), at(j + 1, 1), at(j + 1, 0), FaceKind::skin);
    if (j > 0) add(at(j, 0), at(j, 1), at(j + 1, 1), FaceKind::skin);
    for (const int side : {0, 1}) {
      int a = at(j, side), b = at(j + 1, side);
      if (side == 1) std::swap(a, b);
      add(a, b, b + 1, FaceKind::wall), add(a, b + 1, a + 1, FaceKind::wall);
    }
  }
  const WoundGape g = wound_gape(v, deformed(v, [](const Vec3& X) { return X; }));
  EXPECT_NEAR(g.rim_length_mm, 2 * n / std::cos(std::numbers::pi / 12), 1e-6);
  EXPECT_NEAR(g.lost_mm, g.rim_length_mm, 1e-9);
}

// A chip that was cut off and flew away is no open wound; one that lies in its place is looked at.
// Beyond a slit, as between two lips, lies another bank, though it lay a little behind one's back at rest.
TEST(WoundGape, WhatLayBeyondASlitIsABank) {
  SurfaceView v = two_banks(30);
  for (size_t i = v.X_mm.size() / 2; i < v.X_mm.size(); ++i) v.X_mm.set(i, v.X_mm[i] + Vec3(-1, 0, -1.6));
  const auto x = deformed(v, [](const Vec3& X) { return X.z() < -1 ? Vec3(X + Vec3(1.3, 0, 1.6)) : X; });
  const WoundGape g = wound_gape(v, x);
  EXPECT_NEAR(g.gape_mm, 0.3, 1e-5);
  EXPECT_EQ(g.open_mm, 0);
}

TEST(WoundGape, AChipThatNothingHoldsAndThatLiesElsewhereIsNone) {
  SurfaceView v = two_banks(20);
  const auto half = int32_t(v.X_mm.size() / 2);
  v.tri.push_back({0, 3, 6}), v.kind.push_back(FaceKind::fixed);  // the left bank is held, the right one is the chip
  const auto away = [&](float by) {
    auto x = deformed(v, [](const Vec3& X) { return X; });
    for (size_t i = size_t(half); i < x.size(); ++i) x[i].x() += by;
    return wound_gape(v, x);
  };
  const WoundGape lies = away(0.3f), gone = away(300);
  EXPECT_NEAR(lies.rim_length_mm, 40, 1e-9);
  EXPECT_NEAR(lies.gape_mm, 0.3, 1e-5);
  EXPECT_NEAR(gone.rim_length_mm, 20, 1e-9);  // that of the bank it left behind
  EXPECT_NEAR(gone.open_mm, 20, 1e-9);
}

TEST(WoundGape, AnEdgeThatLooksAtNoOtherIsOpen) {
  const SurfaceView v = two_banks(20);
  auto x = deformed(v, [](const Vec3& X) { return X; });
  for (size_t i = x.size() / 2; i < x.size(); ++i) x[i].x() -= 40;  // carried over the other bank, and beyond
  const WoundGape g = wound_gape(v, x);
  EXPECT_NEAR(g.lost_mm, 40, 1e-6);
  EXPECT_NEAR(g.open_mm, 40, 1e-6);
}

// A bank that was drawn 3 mm over the other, .1 mm above it: it does not gape, and it is no good edge.
TEST(WoundGape, AnEdgeOverOtherSkinOverlaps) {
  const SurfaceView v = two_banks(20);
  const auto drawn = [&](float over, float up) {
    auto x = deformed(v, [](const Vec3& X) { return X; });
    for (size_t i = x.size() / 2; i < x.size(); ++i) x[i].x() -= over, x[i].z() += up;
    return wound_gape(v, x);
  };
  EXPECT_EQ(drawn(1, 0.1f).over_mm, 0);  // apposed, as ever
  const WoundGape g = drawn(3, 0.1f), high = drawn(3, 4), far = drawn(8, 0.1f);
  EXPECT_EQ(high.over_mm, 0);  // stands off
  EXPECT_EQ(far.over_mm, 0);   // lies elsewhere
  EXPECT_GT(far.open_mm, 30);
  EXPECT_NEAR(g.over_mm, 40, 1e-9);
  EXPECT_EQ(g.open_mm, 0);
}

TEST(TurnedSkin, AFlapOnItsFaceIsSeen) {
  const auto body = measured_block({60, 60, 10}, 1);
  const Skin skin(body);
  const SurfaceView v = view_of(*body);
  const auto lies = deformed(v, [](const Vec3& X) { return X; });
  EXPECT_EQ(turned_skin(v, lies, skin).area_mm2, 0);
  // The quarter beyond x = 15 is folded back about that line, as a page is turned.
  const auto folded =
      deformed(v, [](const Vec3& X) { return X.z() == 0 && X.x() > 15 ? Vec3(30 - X.x(), X.y(), 0.5) : X; });
  const TurnedSkin t = turned_skin(v, folded, skin);
  EXPECT_NEAR(t.area_mm2, 15 * 60, 1);
  EXPECT_NEAR(t.at_mm.x(), 22.5, 0.1);
  // Skin that stands upright, as the wall of a fold, is not on its face.
  const auto upright =
      deformed(v, [](const Vec3& X) { return X.z() == 0 && X.x() > 15 ? Vec3(15, X.y(), X.x() - 15) : X; });
  EXPECT_EQ(turned_skin(v, upright, skin).area_mm2, 0);
}

// A plate with skin on both sides, as an ear, is drawn aside by more than half of its thickness: the nearest original
// skin of one side is the other's then, and nothing lies on its face. Folded back it does.
TEST(TurnedSkin, AThinFoldThatMovesLiesNotOnItsFace) {
  auto body = measured_block({40, 40, 10}, 1);
  for (Vec3& X : body->surface.X_mm) X.z() *= 0.2;  // 2 mm
  for (size_t t = 0; t < body->surface.tri.size(); ++t) {
    bool below = true;
    for (const int32_t v : body->surface.tri[t]) below &= body->surface.X_mm[size_t(v)].z() < -1.99;
    if (below) body->surface.tag[t] = SurfaceTag::skin;
  }
  const Skin skin(body);
  const SurfaceView v = view_of(*body);
  ASSERT_LT(skin.nearest({0, 0, -1.9}).normal.z(), -0.9) << "the lower side is no skin";
  EXPECT_EQ(turned_skin(v, deformed(v, [](const Vec3& X) { return Vec3(X.x(), X.y(), X.z() + 1.5); }), skin).area_mm2,
            0);
  const auto folded =
      deformed(v, [](const Vec3& X) { return X.z() == 0 && X.x() > 10 ? Vec3(20 - X.x(), X.y(), 0.5) : X; });
  EXPECT_NEAR(turned_skin(v, folded, skin).area_mm2, 10 * 40, 1);
}

TEST(Rim, IsWhereSkinMeetsWall) {
  const auto places = rim_mm(two_banks(10));
  EXPECT_EQ(places.size(), 20u);
  for (const Vec3& p : places) EXPECT_EQ(Vec2(p.x(), p.z()), Vec2(0, 0));
}

TEST(Compression, IsTheVolumeOfTheMap) {
  const auto body = measured_block({20, 16, 5}, 2);
  const SurfaceView v = view_of(*body);
  Mat3 F;
  F << 1.1, 0.2, 0, 0, 0.9, 0.1, 0.05, 0, 1.02;
  EXPECT_NEAR(compression(v, deformed(v, [&](const Vec3& X) -> Vec3 { return F * X + Vec3(100, 0, 0); })),
              F.determinant() - 1, 1e-5);
}

TEST(SkinArea, OfAPolygonOnStretchedSkin) {
  const auto body = measured_block({40, 40, 5}, 0.5);
  const SurfaceView v = view_of(*body);
  const std::vector<ChartPoint> square{{-10, -5}, {10, -5}, {10, 5}, {-10, 5}};
  const auto x = deformed(v, [](const Vec3& X) { return Vec3(1.25 * X.x(), X.y(), X.z()); });
  EXPECT_NEAR(skin_area_mm2(v, x, *body, square), 250, 1e-3);  // the square runs along the grid
  EXPECT_EQ(skin_area_mm2(v, x, *body, std::span(square).first(2)), 0);
}

TEST(CornerPosition, ChoosesTheBankThatLiesTowards) {
  SurfaceView v = two_banks(20);
  BlockSpec spec;
  spec.size_mm = {50, 50, 10};
  const Skin skin(std::make_shared<Body>(make_block(spec)));
  auto x = deformed(v, [](const Vec3& X) { return X; });
  for (size_t i = 0; i < x.size(); ++i) x[i].x() += i < x.size() / 2 ? -3.f : 4.f;
  const auto left = corner_position_mm(v, x, skin, {0, 7}, {-1, 7}),
             right = corner_position_mm(v, x, skin, {0, 7}, {1, 7});
  ASSERT_TRUE(left && right);
  EXPECT_NEAR((*left - Vec3(-3, 7, 0)).norm(), 0, 1e-5);
  EXPECT_NEAR((*right - Vec3(4, 7, 0)).norm(), 0, 1e-5);
  EXPECT_FALSE(corner_position_mm(v, x, skin, {20, 7}, {0, 7}));
  EXPECT_FALSE(corner_position_mm(v, x, skin, {900, 7}, {0, 7}));
}

TEST(Elongation, OfAStretchedSkinIsItsStretch) {
  const auto body = measured_block({60, 60, 5}, 1);
  const Skin skin(body);
  const SurfaceView v = view_of(*body);
  const auto x = deformed(v, [](const Vec3& X) { return Vec3(X.x(), 1.3 * X.y(), X.z()); });
  const auto e = elongation(v, x, skin, {{-17, 0}, {0, 10}, {0, -10}, {17, 0}});
  ASSERT_TRUE(e);
  EXPECT_NEAR(*e, 1.3, 1e-5);
}

TEST(Elongation, IsTakenInTheSkinOutsideTheFlaps) {
  const SurfaceView v = two_banks(20);
  BlockSpec spec;
  spec.size_mm = {50, 50, 10};
  const Skin skin(std::make_shared<Body>(make_block(spec)));
  // Flap CAB lies left of the limb below A, so the skin outside at A is on the right bank; at B on the left.
  const CentralLimb limb{{-10, 5}, {0, 15}, {0, 5}, {10, 15}};
  auto x = deformed(v, [](const Vec3& X) { return X; });
  for (size_t i = x.size() / 2; i < x.size(); ++i) x[i].y() += 3;
  const auto e = elongation(v, x, skin, limb);
  ASSERT_TRUE(e);
  EXPECT_NEAR(*e, 1.3, 1e-5);
}

}  // namespace test_skin_shape
}  // namespace limberg
