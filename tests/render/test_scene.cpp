// What the renderer is handed, checked without any graphics driver.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "render/colour_map.h"
#include "render/overlay.h"
#include "render/render_scene.h"
#include "render/stitches.h"
#include "render/textures.h"
#include "render/view.h"
#include "render/visible.h"
#include "tests/render/sample_head.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_scene {

using testing::sample_head;
using testing::sample_snapshot;

TEST(TissueMesh, EveryTriangleIsThereOnceAndGrouped) {
  const Snapshot s = sample_snapshot();
  const TissueMesh m = make_tissue_mesh(*s.topology);
  ASSERT_EQ(m.tri.size(), s.topology->view.tri.size());
  std::set<int32_t> seen(m.tri_source.begin(), m.tri_source.end());
  EXPECT_EQ(seen.size(), m.tri.size());
  for (size_t t = 0; t < m.tri.size(); ++t) {
    const Part expected = t < m.skin_triangles                      ? Part::skin
                          : t < m.skin_triangles + m.wall_triangles ? Part::wall
                                                                    : Part::side;
    for (size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(m.part[m.tri[t][k]], expected);
      EXPECT_EQ(m.source[m.tri[t][k]], s.topology->view.tri[size_t(m.tri_source[t])][k]);
    }
  }
  EXPECT_GT(m.wall_triangles, 0u);
}

TEST(TissueMesh, SharpEdgesAreNotSmoothed) {
  // Skin normals of a flat slab must be exactly upright up to its rim, whatever hangs below.
  Snapshot s = sample_snapshot({.wave_mm = 0});
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  for (size_t v = 0; v < scene.x_mm.size(); ++v) {
    if (scene.mesh->part[v] == Part::skin) {
      EXPECT_EQ(scene.normal[v], Vec3f(Vec3f::UnitZ()));
    }
    if (scene.mesh->part[v] == Part::wall) {
      EXPECT_NEAR(scene.normal[v].z(), 0, 1e-6);
    }
    // Walls and sides of this slab are parallel to its axes, so no normal may be mixed over an edge.
    if (scene.mesh->part[v] != Part::skin) {
      EXPECT_NEAR(scene.normal[v].cwiseAbs().maxCoeff(), 1, 1e-6);
    }
  }
}

TEST(TissueMesh, RimHasSkinOnItsLeft) {
  const Snapshot s = sample_snapshot({.wave_mm = 0});
  const TissueMesh m = make_tissue_mesh(*s.topology);
  ASSERT_FALSE(m.rim.empty());
  const auto& X = s.topology->view.X_mm;
  for (const auto& [a, b] : m.rim) {
    const Vec3 middle = 0.5 * (X[size_t(a)] + X[size_t(b)]);
    const Vec3 right = (X[size_t(b)] - X[size_t(a)]).cross(Vec3::UnitZ()).normalized();
    const Vec3 p = middle + 0.3 * right;  // the wound is a lens around the origin: going right goes into it
    EXPECT_LT(std::abs(p.y()) - 6 * (1 - p.x() * p.x() / 144), 1.3) << middle.transpose();
    EXPECT_NEAR(middle.z(), 0, 1e-9);
  }
}

TEST(TissueMesh, RimDistanceIsTheNearestEdge) {
  const Snapshot s = sample_snapshot({.wave_mm = 0});
  const TissueMesh m = make_tissue_mesh(*s.topology);
  const auto& X = s.topology->view.X_mm;
  for (size_t v = 0; v < m.source.size(); v += 3) {
    double nearest = double(kRimReach_mm);
    if (m.part[v] == Part::skin)
      for (const auto& [a, b] : m.rim) {
        const Vec3 p = m.X_mm[v].cast<double>(), d = X[size_t(b)] - X[size_t(a)];
        const double t = std::clamp((p - X[size_t(a)]).dot(d) / d.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (p - X[size_t(a)] - t * d).norm());
      }
    ASSERT_NEAR(m.rim_mm[v], nearest, 1e-4);
  }
}

TEST(Normals, FollowTheWave) {
  // Against the exact normal of z = f(x, y); the error of area weighting is of second order in the 1 mm cells.
  const double w = 0.8;
  Snapshot s = sample_snapshot({.wound = false, .wave_mm = w});
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  double worst = 0;
  for (size_t v = 0; v < scene.x_mm.size(); ++v) {
    const double x = scene.x_mm[v].x(), y = scene.x_mm[v].y();
    if (scene.mesh->part[v] != Part::skin || std::abs(x) > 28 || std::abs(y) > 28) continue;
    const Vec3 exact =
        Vec3(-w * 0.16 * std::cos(0.16 * x) * std::cos(0.13 * y), w * 0.13 * std::sin(0.16 * x) * std::sin(0.13 * y), 1)
            .normalized();
    worst = std::max(worst, (scene.normal[v].cast<double>() - exact).norm());
  }
  // |f'''| h^2 / 6 = 0.8 * 0.16^3 / 6 = 5e-4; single precision adds 1e-5.
  EXPECT_LT(worst, 1.2e-3);
}

TEST(SceneBuilder, SurvivesIncompleteSnapshots) {
  SceneBuilder builder;
  EXPECT_TRUE(builder.build(Snapshot{}).x_mm.empty());
  Snapshot s = sample_snapshot();
  s.x_mm.pop_back();  // does not fit its topology
  EXPECT_TRUE(builder.build(s).x_mm.empty());
  s = sample_snapshot();
  s.field.clear();
  s.sutures[0].a_mm = Vec3f::Constant(NAN);
  s.sutures[1].b_mm = s.sutures[1].a_mm;  // closed: no direction of its own
  s.hooks[0].handle_mm = s.hooks[0].at_mm;
  const RenderScene& scene = builder.build(s);
  EXPECT_TRUE(scene.field.empty());
  for (const PropVertex& v : scene.props.vertex) {
    ASSERT_TRUE(v.x_mm.allFinite());
    ASSERT_NEAR(v.normal.norm(), 1, 1e-3);
  }
}

TEST(SceneBuilder, ClosedStitchLiesAcrossTheWound) {
  Snapshot s = sample_snapshot({.wave_mm = 0, .sutures = 1, .hooks = 0});
  s.sutures[0].a_mm = Vec3f(0, -6, 0), s.sutures[0].b_mm = Vec3f(0, -6, 0);
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  float lo = 1e9f, hi = -1e9f;
  for (const PropVertex& v : scene.props.vertex) lo = std::min(lo, v.x_mm.y()), hi = std::max(hi, v.x_mm.y());
  EXPECT_LT(lo, -7.9f);  // two bites of 2.2 mm on either side of the edge at y = -6
  EXPECT_GT(hi, -4.1f);
}

TEST(SceneBuilder, ARunningThreadHasItsKnotsAtItsEnds) {
  Snapshot s = sample_snapshot({.wave_mm = 0, .sutures = 5, .hooks = 0});
  const auto drawn = [&](int32_t thread) {  // vertices per stitch
    for (SutureState& k : s.sutures) k.thread = thread;
    SceneBuilder builder;
    std::vector<int> n;
    const std::vector<PropVertex>& vertex = builder.build(s).props.vertex;
    for (const SutureState& k : s.sutures)
      n.push_back(int(std::count_if(vertex.begin(), vertex.end(), [&](const PropVertex& v) {
        return v.id == (uint32_t(Part::suture) << 24 | uint32_t(k.id));
      })));
    return n;
  };
  const std::vector<int> single = drawn(0), running = drawn(3);
  ASSERT_EQ(single.size(), 5u);
  for (size_t i = 0; i < 5; ++i) {
    if (i == 0 || i == 4)
      EXPECT_EQ(running[i], single[i]);
    else
      EXPECT_LT(running[i], single[i]);
    EXPECT_GT(running[i], 0);
  }
}

// A thread that is sewn bite after bite has no knot at its last bite: it goes on to the needle, or lies beside it.
TEST(SceneBuilder, AThreadThatIsBeingSewnGoesOnToTheNeedle) {
  Snapshot s = sample_snapshot({.wave_mm = 0, .sutures = 3, .hooks = 0});
  for (SutureState& k : s.sutures) k.thread = 1;
  const auto loose = [&](const ToolPose& tool) {  // how far the thread reaches that is no stitch yet
    SceneBuilder builder;
    float far = 0;
    for (const PropVertex& v : builder.build(s, tool).props.vertex)
      if (v.id == uint32_t(Part::suture) << 24) far = std::max(far, (v.x_mm - s.sutures.back().b_mm).norm());
    return far;
  };
  const auto of_last = [&] {
    SceneBuilder builder;
    const std::vector<PropVertex>& vertex = builder.build(s).props.vertex;
    return std::count_if(vertex.begin(), vertex.end(), [&](const PropVertex& v) {
      return v.id == (uint32_t(Part::suture) << 24 | uint32_t(s.sutures.back().id));
    });
  };
  EXPECT_EQ(loose({}), 0) << "it is tied";
  const auto with_knot = of_last();
  s.sewn.thread = 1, s.sewn.bites = 3, s.sewn.end_mm = s.sutures.back().b_mm;
  EXPECT_LT(of_last(), with_knot);
  EXPECT_NEAR(loose({}), 17, 2) << "its end lies beside the wound";
  float nearest = 1e9f;  // it comes out of the hole, beside the edge that holds the bite
  SceneBuilder kept;     // the scene is its own
  for (const PropVertex& v : kept.build(s).props.vertex)
    if (v.id == uint32_t(Part::suture) << 24) nearest = std::min(nearest, (v.x_mm - s.sutures.back().b_mm).norm());
  EXPECT_GT(nearest, 1.2f);
  ToolPose needle;
  needle.visible = true, needle.kind = ToolPose::Kind::needle_holder, needle.tip_mm = s.sewn.end_mm + Vec3f(0, 0, 40);
  EXPECT_NEAR(loose(needle), 45, 6) << "it comes to the needle";
}

// A thread in no hand falls on the skin, and lies on it all along.
TEST(SceneBuilder, ALooseThreadLiesOnTheSkin) {
  for (const double wave_mm : {0.0, 0.8}) {
    Snapshot s = sample_snapshot({.wave_mm = wave_mm, .sutures = 3, .hooks = 0});
    for (SutureState& k : s.sutures) k.thread = 1;
    s.sewn.thread = 1, s.sewn.bites = 3, s.sewn.end_mm = s.sutures.back().b_mm;
    SceneBuilder builder;
    const RenderScene& scene = builder.build(s);
    float highest = -1e9f, far = 0;
    int n = 0;
    for (const PropVertex& v : scene.props.vertex) {
      if (v.id != uint32_t(Part::suture) << 24) continue;
      const NearestSkin at = nearest_skin(scene, v.x_mm);
      highest = std::max(highest, (v.x_mm - at.x).dot(at.normal)), ++n;
      far = std::max(far, (v.x_mm - s.sewn.end_mm).norm());
    }
    EXPECT_GT(n, 100);
    EXPECT_GT(far, 10);
    EXPECT_LT(highest, 0.75f) << "a thread is 0.3 mm thick";
  }
}

TEST(SceneBuilder, ThreadLiesOverWhatStandsUpBetweenItsHoles) {
  // The skin rises between the holes of a closed stitch, as
  // beside the end of a scar: the thread must not run beneath it.
  Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 1, .hooks = 0});
  const auto hump = [](const Vec3f& x) { return 2.5f * std::exp(-x.head<2>().squaredNorm() / 2); };
  for (size_t v = 0; v < s.x_mm.size(); ++v)
    if (s.x_mm[v].z() > -1e-3f) s.x_mm[v].z() += hump(s.x_mm[v]);
  s.sutures[0].a_mm = s.sutures[0].b_mm = Vec3f(0, 0, 2.5f);
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  ASSERT_FALSE(scene.props.vertex.empty());
  // From one hole to the other a part of the thread is above the skin everywhere.
  float lo = 1e9f, hi = -1e9f;
  for (const PropVertex& v : scene.props.vertex) lo = std::min(lo, v.x_mm.x()), hi = std::max(hi, v.x_mm.x());
  ASSERT_GT(hi - lo, 3);
  for (float x = -1.6f; x < 1.7f; x += 0.2f) {
    bool above = false;
    for (const PropVertex& v : scene.props.vertex)
      above |= std::abs(v.x_mm.x() - x) < 0.25f && v.x_mm.z() > hump(v.x_mm) + 0.1f;
    EXPECT_TRUE(above) << x;
  }
}

TEST(SceneBuilder, ThreadLiesOverAFoldOfLargeTriangles) {
  // A fold along a diagonal of 12 mm squares, whose corners are all farther off than the stitch is long: the skin rises
  // from the stitch to both sides, by 2.5 mm at a distance of 12 (|x| + |y|).
  Snapshot s = sample_snapshot({.cells = 5, .wound = false, .wave_mm = 0, .sutures = 1, .hooks = 0});
  for (Vec3f& x : s.x_mm)
    if ((x - Vec3f(6, -6, 0)).norm() < 1e-3f || (x - Vec3f(-6, 6, 0)).norm() < 1e-3f) x.z() = 2.5f;
  s.sutures[0].a_mm = s.sutures[0].b_mm = Vec3f(0, 0, 0);
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  for (float x = -2.0f; x < 2.1f; x += 0.2f) {
    bool above = false;
    for (const PropVertex& v : scene.props.vertex)
      above |= std::abs(v.x_mm.x() - x) < 0.25f && v.x_mm.z() > 2.5f * std::abs(v.x_mm.x() - v.x_mm.y()) / 12 + 0.05f;
    EXPECT_TRUE(above) << x;
  }
}

TEST(SceneBuilder, ThreadLiesAboveAnEdgeThatIsRolledIn) {
  // The nearest piece of skin to the stitch looks down, as the lip of
  // a wound that is turned under: up is where the skin around looks.
  Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 1, .hooks = 0});
  for (size_t v = 0; v < s.x_mm.size(); ++v)
    if (const Vec3& X = s.topology->view.X_mm[v]; X.z() > -1e-6 && X.norm() < 1.2) s.x_mm[v].x() = -s.x_mm[v].x();
  s.sutures[0].a_mm = s.sutures[0].b_mm = Vec3f(0, 0, 0);
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  ASSERT_FALSE(scene.props.vertex.empty());
  float sum = 0;
  for (const PropVertex& v : scene.props.vertex) sum += v.x_mm.z();
  EXPECT_GT(sum / float(scene.props.vertex.size()), 0.1f);
}

TEST(SceneBuilder, ThreadOfOneLipIsNotLaidOverTheOther) {
  // Skin that is folded over the stitch, 2 mm above it, and looks down at it.
  Snapshot s = sample_snapshot({.wound = false, .wave_mm = 0, .sutures = 1, .hooks = 0});
  for (size_t v = 0; v < s.x_mm.size(); ++v) {
    const Vec3& X = s.topology->view.X_mm[v];
    const auto on = float(X.x() - 2);
    if (X.z() < -1e-6 || on < 0) continue;
    const bool over = on > float(M_PI);
    s.x_mm[v].x() = over ? 2 - (on - float(M_PI)) : 2 + std::sin(on);
    s.x_mm[v].z() = over ? 2 : 1 - std::cos(on);
  }
  s.sutures[0].a_mm = s.sutures[0].b_mm = Vec3f(0, 0, 0);
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  ASSERT_FALSE(scene.props.vertex.empty());
  float highest = -1;
  for (const PropVertex& v : scene.props.vertex) highest = std::max(highest, v.x_mm.z());
  EXPECT_GT(highest, 0.1f);
  EXPECT_LT(highest, 1.9f);
}

TEST(Visible, ClosedSurfaceShowsItsFrontAndWhatIsInTheFrame) {
  const Snapshot s = sample_snapshot();
  SceneBuilder builder;
  const RenderScene& scene = builder.build(s);
  const Camera camera = look_at_ball(Vec3f(8, 0, 0), 15, Vec3f(0.05f, -0.6f, 0.8f), Vec3f::UnitZ(), 25, 4.0 / 3);
  const View view = camera.view(4.0 / 3);
  VisibleTriangles visible;
  visible.look(scene.x_mm, view.projection * view.to_eye, 320, 240);
  std::vector<std::array<uint32_t, 3>> kept;
  const size_t said = visible.append(scene.mesh->tri, kept);
  ASSERT_EQ(said, kept.size());
  const std::set<std::array<uint32_t, 3>> there(kept.begin(), kept.end());
  size_t turned = 0, outside = 0;
  for (const auto& t : scene.mesh->tri) {
    const Vec3f &a = scene.x_mm[t[0]], &b = scene.x_mm[t[1]], &c = scene.x_mm[t[2]];
    const bool front = (b - a).cross(c - a).dot(view.eye_mm - a) > 0;
    bool in = false;
    for (const Vec3f& p : {a, b, c}) {
      const Vec3f px = view.to_pixel(p, 320, 240);
      in |= px.x() >= 0 && px.x() <= 320 && px.y() >= 0 && px.y() <= 240;
    }
    if (front && in) {
      EXPECT_TRUE(there.count(t));
    }
    turned += !front, outside += !in;
  }
  EXPECT_GT(turned, scene.mesh->tri.size() / 3);
  EXPECT_GT(outside, scene.mesh->tri.size() / 10);
  EXPECT_LT(kept.size(), scene.mesh->tri.size() * 2 / 3);
}

TEST(SceneBuilder, APlateLiesOnTheBone) {
  Snapshot s = sample_head();
  SceneBuilder builder;
  const size_t without = builder.build(s, {}).props.vertex.size();
  const Vec3f half(58, 76, 78);  // of the egg of bone
  const auto on_egg = [&](float x, float z) {
    return Vec3f(x, -half.y() * std::sqrt(1 - x * x / (half.x() * half.x()) - z * z / (half.z() * half.z())), z);
  };
  const Vec3f a = on_egg(-9, -10), b = on_egg(8, -16);
  s.plate_mm.push_back({a, b});
  const RenderScene& scene = builder.build(s, {});
  ASSERT_GT(scene.props.vertex.size(), without);
  float highest = 0, lowest = 0, first = 1e9f, last = 1e9f;
  for (size_t v = without; v < scene.props.vertex.size(); ++v) {
    const Vec3f x = scene.props.vertex[v].x_mm;
    ASSERT_TRUE(x.allFinite());
    EXPECT_NEAR(scene.props.vertex[v].normal.norm(), 1, 1e-3);
    const float above = (x.cwiseQuotient(half).norm() - 1) * half.y();
    highest = std::max(highest, above), lowest = std::min(lowest, above);
    first = std::min(first, (x - a).norm()), last = std::min(last, (x - b).norm());
  }
  // A plate of 1.5 mm and the heads of its screws, seen; what lies
  // in bone is hidden there, no deeper than the plate is thick.
  EXPECT_GT(highest, 1.2f);
  EXPECT_LT(highest, 3);
  EXPECT_GT(lowest, -1.5f);
  EXPECT_LT(first, 2);
  EXPECT_LT(last, 2);
}

TEST(SceneBuilder, APlateIsBentOverAStepOfBone) {
  // Two sheets of bone, one 6 mm higher, 2 mm apart; the plate begins 4
  // mm before the step and ends 18 mm behind it, or the other way round.
  auto t = std::make_shared<SurfaceTopology>();
  t->version = 1, t->hash = 1;
  Snapshot s;
  for (const auto& [from, z] : {std::pair{-30, 0.}, {2, 6.}}) {
    const auto base = int32_t(s.x_mm.size());
    constexpr int32_t kColumns = 15, kRows = 11;
    for (int32_t i = 0; i < kColumns * kRows; ++i) {
      const Vec3 X(from + 2 * (i % kColumns) + (z == 0 ? 2 : 0), 2 * (i / kColumns) - 10, z);
      t->view.X_mm.push_back(X), s.x_mm.push_back(X.cast<float>());
    }
    for (int32_t r = 0; r + 1 < kRows; ++r)
      for (int32_t c = 0; c + 1 < kColumns; ++c) {
        const int32_t a = base + r * kColumns + c, d = a + kColumns;
        for (const Tri& k : {Tri{a, a + 1, d + 1}, Tri{a, d + 1, d}})
          t->view.tri.push_back(k), t->view.kind.push_back(FaceKind::free), t->organ.push_back(Organ::bone),
              t->object.push_back(0);
      }
  }
  s.topology = t, s.topology_version = 1;
  SceneBuilder builder;
  const size_t without = builder.build(s, {}).props.vertex.size();
  for (const bool turned : {false, true}) {
    const Vec3f low(-4, 1, 0), high(20, 1, 6);
    s.plate_mm = {turned ? std::array{high, low} : std::array{low, high}};
    const RenderScene& scene = builder.build(s, {});
    ASSERT_GT(scene.props.vertex.size(), without + 100);
    float deepest = 1e9f, highest = -1e9f;
    for (size_t v = without; v < scene.props.vertex.size(); ++v) {
      const Vec3f& x = scene.props.vertex[v].x_mm;
      deepest = std::min(deepest, x.z() - (x.x() < 2 ? 0 : 6));
      highest = std::max(highest, x.z() - 6);
    }
    EXPECT_GT(deepest, -1) << "it is drawn within bone";  // plate and screws are flush with it, or nearly
    EXPECT_LT(highest, 3);
  }
}

TEST(Props, TubeFacesOutwards) {
  PropMesh m;
  const std::array<Vec3f, 4> path{Vec3f(0, 0, 0), Vec3f(5, 0, 0), Vec3f(5, 0, 0), Vec3f(5, 5, 2)};
  const std::array<float, 4> radius{1, 1, 1, 0.5f};
  add_tube(m, path, radius, {});
  ASSERT_FALSE(m.tri.empty());
  for (const auto& [a, b, c] : m.tri) {
    const Vec3f n = (m.vertex[b].x_mm - m.vertex[a].x_mm).cross(m.vertex[c].x_mm - m.vertex[a].x_mm);
    if (n.norm() < 1e-4f) continue;
    const Vec3f mean = m.vertex[a].normal + m.vertex[b].normal + m.vertex[c].normal;
    EXPECT_GT(n.dot(mean), 0);
  }
  PropMesh none;
  add_tube(none, std::span(path).subspan(1, 2), std::span(radius).subspan(1, 2), {});  // one point, twice
  EXPECT_TRUE(none.tri.empty());
}

TEST(Region, HoldsTheWound) {
  Vec3f low, high;
  ASSERT_TRUE(operated_box(sample_snapshot({.sutures = 0, .hooks = 0}), low, high));
  EXPECT_NEAR(low.x(), -12, 1.01);  // a lens of 24 x 12 mm, cut out in squares of 1 mm
  EXPECT_NEAR(high.x(), 12, 1.01);
  EXPECT_NEAR(high.y() - low.y(), 12, 2.01);
  EXPECT_FALSE(operated_box(sample_snapshot({.wound = false, .sutures = 0, .hooks = 0}), low, high));
  skin_box(*sample_snapshot().topology->body, low, high);
  EXPECT_EQ(low, Vec3f(-30, -30, 0));
  EXPECT_EQ(high, Vec3f(30, 30, 0));
}

TEST(Camera, SeesTheWholeBoxAndNoMore) {
  const Vec3f low(-20, -5, -3), high(10, 40, 6);
  for (const double aspect : {0.6, 1.0, 16.0 / 9}) {
    const View v = look_at_box(low, high, 1, Vec3f(0.2f, -0.7f, 0.7f), Vec3f::UnitZ(), 24, aspect).view(aspect);
    float reach = 0;
    for (int k = 0; k < 8; ++k) {
      const Vec3f p =
          v.to_pixel(Vec3f(k & 1 ? low.x() : high.x(), k & 2 ? low.y() : high.y(), k & 4 ? low.z() : high.z()), 2, 2);
      reach = std::max({reach, std::abs(p.x() - 1), std::abs(p.y() - 1)});
    }
    EXPECT_NEAR(reach, 1, 1e-3);  // the outermost corner lies on the edge of the picture
  }
}

TEST(Camera, SeesTheWholeBall) {
  for (const double aspect : {0.5, 1.0, 16.0 / 9}) {
    const Vec3f centre(3, -4, 5);
    const View v = look_at_ball(centre, 20, Vec3f(0, -1, 1), Vec3f::UnitZ(), 25, aspect).view(aspect);
    const Vec3f middle = v.to_pixel(centre, 1000, 1000);
    EXPECT_NEAR(middle.x(), 500, 0.1);
    EXPECT_NEAR(middle.y(), 500, 0.1);
    for (int i = 0; i < 200; ++i) {
      const float a = 0.7f * float(i), z = -1 + 2 * (float(i) + 0.5f) / 200, r = std::sqrt(1 - z * z);
      const Vec3f p = v.to_pixel(centre + 20 * Vec3f(r * std::cos(a), r * std::sin(a), z), 1000, 1000);
      EXPECT_TRUE(p.x() >= -0.5f && p.x() <= 1000.5f && p.y() >= -0.5f && p.y() <= 1000.5f && std::abs(p.z()) < 1);
    }
  }
}

TEST(Camera, StereoMeetsAtTheTarget) {
  Camera c;
  c.eye_mm = Vec3f(0, -200, 100), c.target_mm = Vec3f(0, 0, 0);
  const std::vector<View> eyes = c.stereo_side_by_side(16.0 / 9);
  ASSERT_EQ(eyes.size(), 2u);
  const auto in_half = [&](size_t e, const Vec3f& p) {
    return eyes[e].to_pixel(p, 1600, 900).x() - (e ? 800.0f : 0.0f);
  };
  EXPECT_NEAR(in_half(0, c.target_mm), in_half(1, c.target_mm), 0.05);
  const Vec3f nearer(0, -20, 10), farther(0, 20, -10);
  EXPECT_GT(in_half(0, nearer), in_half(1, nearer) + 0.2f);    // in front of the screen: crossed
  EXPECT_LT(in_half(0, farther), in_half(1, farther) - 0.2f);  // behind it: uncrossed
}

TEST(ColourMap, LightnessGrowsEvenly) {
  double before = lightness(viridis(0));
  EXPECT_NEAR(before, 15, 2);
  for (int i = 1; i <= 100; ++i) {
    const double now = lightness(viridis(i / 100.0));
    EXPECT_GT(now, before) << i;
    EXPECT_LT(now - before, 2.0) << i;
    before = now;
  }
  EXPECT_NEAR(before, 91, 2);
  EXPECT_EQ(viridis(NAN), viridis(0));
  EXPECT_EQ(viridis(7), viridis(1));
}

TEST(Textures, TilesRepeatWithoutSeam) {
  for (const Texels& t : {skin_texture(256), grid_texture(256), detail_texture(128)}) {
    // The step over the seam is no larger than the largest step inside.
    for (int c = 0; c < 3; ++c) {
      int inside = 0, seam = 0;
      const auto at = [&](int x, int y) {
        return int(t.rgba[4 * (size_t(y) * size_t(t.width) + size_t(x)) + size_t(c)]);
      };
      for (int y = 0; y < t.height; ++y) {
        for (int x = 0; x + 1 < t.width; ++x) inside = std::max(inside, std::abs(at(x, y) - at(x + 1, y)));
        seam = std::max(seam, std::abs(at(t.width - 1, y) - at(0, y)));
      }
      EXPECT_LE(seam, inside + 8);
    }
  }
}

TEST(Textures, SlopesAreThoseOfTheHeights) {
  // Added up along a line of texels, slopes give the heights again; around the tile they give nothing.
  const Texels detail = detail_texture(256), slope = slope_texture(detail);
  for (const size_t c : {size_t(0), size_t(1)})
    for (const int y : {0, 77, 200}) {
      const auto at = [&](const Texels& t, int x, size_t k) {
        return double(t.rgba[4 * (size_t(y) * 256 + size_t((x + 256) % 256)) + k]);
      };
      double sum = 0, worst = 0;
      for (int x = 0; x < 256; ++x) {
        const double d = (at(slope, x, 2 * c) - 127.5) / kSlopeGain,
                     exact = 0.5 * (at(detail, x + 1, c) - at(detail, x - 1, c));
        if (std::abs(exact) < 127.0 / kSlopeGain) worst = std::max(worst, std::abs(d - exact));
        sum += d;
      }
      EXPECT_LT(worst, 0.5 / kSlopeGain + 0.02);  // half a level of the texture
      EXPECT_LT(std::abs(sum) / 256, 0.5 / kSlopeGain + 0.5);
    }
}

TEST(Overlay, RoundSteps) {
  EXPECT_DOUBLE_EQ(round_step(15, 6), 5);
  EXPECT_DOUBLE_EQ(round_step(0.9, 6), 0.2);
  EXPECT_DOUBLE_EQ(round_step(6, 6), 1);
  EXPECT_EQ(round_step(0, 5), 1);
  EXPECT_EQ(round_step(NAN, 5), 1);
  EXPECT_EQ(tick_label(0.15000000001, 0.05), "0.15");
  EXPECT_EQ(tick_label(-0.0, 5), "0");
}

// Two triangles of bone and one of a cut through it that meets the first of them in an edge.
TEST(TissueMesh, BoneKnowsHowFarItIsFromTheSaw) {
  SurfaceTopology top;
  top.view.X_mm = {Vec3(0, 0, 0), Vec3(10, 0, 0), Vec3(5, 2, 0), Vec3(5, 0, -8), Vec3(5, 9, 0)};
  const auto add = [&](const Tri& t, Organ o) {
    top.view.tri.push_back(t), top.view.kind.push_back(FaceKind::free), top.organ.push_back(o), top.object.push_back(0);
  };
  add({0, 1, 2}, Organ::bone), add({1, 0, 3}, Organ::bone_cut), add({0, 2, 4}, Organ::bone);
  const TissueMesh m = make_tissue_mesh(top);
  EXPECT_TRUE(m.rim.empty());  // that is of skin
  const float wanted[] = {0, 0, 2, kRimReach_mm, kRimReach_mm};
  for (size_t v = 0; v < m.source.size(); ++v)
    EXPECT_NEAR(m.rim_mm[v], m.part[v] == Part::bone ? wanted[m.source[v]] : kRimReach_mm, 1e-5f) << m.source[v];
}

// The lamp stands over the upper left of what is operated on, whichever way that faces.
TEST(Scene, TheLampLooksAtTheWound) {
  const auto lamp = [](const Vec3& out, const Vec3& up, bool cut, const Vec3f& towards_eye = Vec3f::Zero()) {
    SurfaceTopology top;
    auto body = std::make_shared<Body>();
    body->chart_e1 = Vec3::UnitX(), body->chart_e2 = Vec3::UnitY();
    top.body = body;
    const Vec3 right = up.cross(out);
    for (const Vec3& X : {Vec3(0, 0, 0), right, up}) top.view.X_mm.push_back(X);
    top.view.tri.push_back({0, 1, 2}), top.view.kind.push_back(FaceKind::skin);
    top.view.rim.push_back(cut ? 1 : 0);
    top.depth_mm = top.layers_mm = SharedArray<float>(3, 0);
    return make_tissue_mesh(top, towards_eye).lamp;
  };
  EXPECT_LT((lamp(Vec3::UnitZ(), Vec3::UnitY(), true) - kLamp).norm(), 1e-6f);
  EXPECT_LT((lamp(Vec3::UnitX(), Vec3::UnitY(), false) - kLamp).norm(), 1e-6f);  // nothing is cut yet
  // A cheek that is looked at from its side, and is not cut yet, does not lie in the shadow of its face.
  EXPECT_LT((lamp(Vec3::UnitZ(), Vec3::UnitY(), false, {0.3f, 0, 1}) - kLamp).norm(), 1e-6f);
  EXPECT_NEAR(lamp(Vec3::UnitZ(), Vec3::UnitY(), false, {300, 0, 0}).x(), kLamp.z(), 1e-6f);
  EXPECT_LT((lamp(Vec3::UnitZ(), Vec3::UnitY(), true, {300, 0, 0}) - kLamp).norm(), 1e-6f);
  for (const Vec3& out : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 0, -1)}) {
    const Vec3f at = lamp(out, Vec3::UnitY(), true);
    EXPECT_NEAR(at.dot(out.cast<float>()), kLamp.z(), 1e-6f);
    EXPECT_NEAR(at.y(), kLamp.y(), 1e-6f);
    EXPECT_NEAR(at.dot(Vec3(Vec3::UnitY().cross(out)).cast<float>()), kLamp.x(), 1e-6f);
  }
}

}  // namespace test_scene
}  // namespace limberg
