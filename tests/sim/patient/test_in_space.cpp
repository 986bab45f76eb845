// Places in space: acts on sides that the chart does not see, cuts right through, loose pieces, faces of a cut.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/commands/script.h"
#include "sim/commands/texture_script.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/lip.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_in_space {

Command line(const std::string& text) { return parse_command(text, "test", 1); }

void settle(World& world, int steps = 300) {
  StepSettings s;
  s.max_iterations = 20;
  for (int i = 0; i < steps; ++i) {
    const StepReport r = world.step(s);
    if (world.settled() && r.residual <= 1e-4 && !r.preconditioner_pending) return;
  }
}

/// Area of the wound's walls at rest, both banks.
double wall_mm2(const World& world) {
  const SurfaceView& v = world.skin()->topology()->view;
  double area = 0;
  for (size_t t = 0; t < v.tri.size(); ++t)
    if (v.kind[t] == FaceKind::wall) {
      const Vec3 a = v.X_mm[size_t(v.tri[t][0])];
      area += 0.5 * (v.X_mm[size_t(v.tri[t][1])] - a).cross(v.X_mm[size_t(v.tri[t][2])] - a).norm();
    }
  return area;
}

/// How far corners of the present surface that lay within reach of a place at rest have moved, in the mean: those of
/// triangles of that kind that look along `facing` (zero: all).
Vec3 moved_mm(const World& world, const Vec3& X, double reach_mm, FaceKind kind, const Vec3& facing = Vec3::Zero()) {
  Snapshot s;
  world.fill(s);
  const SurfaceView& v = s.topology->view;
  Vec3 moved = Vec3::Zero();
  double n = 0;
  for (size_t t = 0; t < v.tri.size(); ++t) {
    const Tri& c = v.tri[t];
    const Vec3 a = v.X_mm[size_t(c[0])], up = (v.X_mm[size_t(c[1])] - a).cross(v.X_mm[size_t(c[2])] - a).normalized();
    if (v.kind[t] != kind || (!facing.isZero() && up.dot(facing) < 0.5)) continue;
    for (const int32_t i : c)
      if ((v.X_mm[size_t(i)] - X).norm() <= reach_mm)
        moved += s.x_mm[size_t(i)].cast<double>() - v.X_mm[size_t(i)], ++n;
  }
  EXPECT_GT(n, 0) << X.transpose();
  return moved / n;
}

/// Mean opening of a wound along y, over the corners of its rim.
double gape_mm(const World& world) {
  Snapshot s;
  world.fill(s);
  const SurfaceView& v = s.topology->view;
  double sum[2] = {0, 0}, n[2] = {0, 0};
  for (size_t t = 0; t < v.tri.size(); ++t)
    for (size_t k = 0; k < 3; ++k) {
      if (v.kind[t] != FaceKind::skin || !(v.rim[t] >> k & 1)) continue;
      const size_t i = size_t(v.tri[t][k]);
      const double middle =
          (v.X_mm[size_t(v.tri[t][0])] + v.X_mm[size_t(v.tri[t][1])] + v.X_mm[size_t(v.tri[t][2])]).y() / 3;
      const bool far = middle > v.X_mm[i].y();
      sum[far] += double(s.x_mm[i].y()) - v.X_mm[i].y(), ++n[far];
    }
  return sum[1] / n[1] - sum[0] / n[0];
}

TEST(InSpace, ThePenLeavesThePatientAndIsRefusedOffTheSkin) {
  InlineWorkers workers;
  World world(test::lip(), workers);
  const uint64_t before = world.skin()->full_hash();
  EXPECT_TRUE(world.apply(line(R"({"action":"mark","path":[[-6,14,0],[6,14,0]]})")).done);
  const Outcome off = world.apply(line(R"({"action":"mark","path":[[-6,14,0],[6,14,-9]],"wipes":true})"));
  EXPECT_FALSE(off.done);
  EXPECT_NE(off.reason.find("(6.00, 14.00, -9.00) mm lies 9.0 mm off the skin"), std::string::npos) << off.reason;
  const Outcome texture = world.apply(line(R"({"action":"mark","path":[{"uv":[0.5,0.5]}]})"));
  EXPECT_FALSE(texture.done) << "it has no texture";
  EXPECT_EQ(world.skin()->full_hash(), before);
  EXPECT_FALSE(world.apply(Undo{}).done) << "nothing was done";
}

TEST(InSpace, AWedgeIsCutThroughALipAndTakenOut) {
  InlineWorkers workers;
  World world(test::lip(), workers);
  const double before = world.skin()->volume_mm3();
  const Outcome cut = world.apply(line(
      R"({"action":"cut_through","path":[[-6.3,20.5,8],[0.2,8,8],[6.4,20.5,8]],"normals":[[0,0,1],[0,0,1],[0,0,1]],"open_start":true,"open_end":true})"));
  ASSERT_TRUE(cut.done) << cut.reason;
  EXPECT_EQ(world.skin()->pieces(), 2);
  const Outcome taken = world.apply(line(R"({"action":"excise","at":[0,19,8]})"));
  ASSERT_TRUE(taken.done) << taken.reason;
  EXPECT_EQ(world.skin()->pieces(), 1);
  // A triangular prism: apex at y = 8, margin at y = 22, sides through the posts, as thick as the lip.
  const double left = 0.2 - 6.5 * 14 / 12.5, right = 0.2 + 6.2 * 14 / 12.5;
  EXPECT_NEAR(world.skin()->removed_volume_mm3(), 0.5 * (right - left) * 14 * 8, 0.01 * 0.5 * (right - left) * 14 * 8);
  EXPECT_NEAR(world.skin()->volume_mm3() + world.skin()->removed_volume_mm3(), before, 1e-6 * before);
  // Sewn through skin in front and mucosa behind, it closes. The notch is 14 mm wide at the margin.
  ASSERT_TRUE(
      world
          .apply(line(
              R"({"action":"suture_row","a":[[-6.9,20.5,8],[-0.6,8.8,8]],"b":[[7,20.5,8],[1,8.8,8]],"spacing_mm":3})"))
          .done);
  const Outcome back = world.apply(line(R"({"action":"suture","a":[-5.6,18,0],"b":[5.8,18,0]})"));
  ASSERT_TRUE(back.done) << back.reason;
  settle(world);
  EXPECT_TRUE(world.settled());
  Snapshot s;
  world.fill(s);
  for (const auto& stitch : s.sutures) EXPECT_LT(stitch.gap_mm, 0.5) << stitch.id;
}

/// A mouth that is shut: two lips 8 mm thick with 0.4 mm between their margins, before a plate that is held; all of one
/// section, along x.
std::string shut_mouth_obj() {
  const std::array<double, 6> y{-26, -20, -0.2, 0.2, 20, 26};
  const std::array<double, 4> z{-10, -4, 6, 14};
  constexpr int n = 20;
  const auto solid = [](int j, int k) {
    return j >= 0 && j < 5 && k >= 0 && k < 3 && (k == 0 || j == 0 || j == 4 || (k == 2 && j != 2));
  };
  std::string obj;
  for (int i = 0; i <= n; ++i)
    for (const double h : y)
      for (const double d : z)
        obj += "v " + std::to_string(44.0 * i / n - 22) + " " + std::to_string(h) + " " + std::to_string(d) + "\n";
  const auto at = [](int i, int j, int k) { return " " + std::to_string(1 + (i * 6 + j) * 4 + k); };
  for (int j = 0; j < 5; ++j)
    for (int k = 0; k < 3; ++k) {
      if (!solid(j, k)) continue;
      obj += "f" + at(0, j, k) + at(0, j, k + 1) + at(0, j + 1, k + 1) + at(0, j + 1, k) + "\n";
      obj += "f" + at(n, j, k) + at(n, j + 1, k) + at(n, j + 1, k + 1) + at(n, j, k + 1) + "\n";
      const auto side = [&](int j0, int k0, int j1, int k1) {
        for (int i = 0; i < n; ++i)
          obj += "f" + at(i, j0, k0) + at(i, j1, k1) + at(i + 1, j1, k1) + at(i + 1, j0, k0) + "\n";
      };
      if (!solid(j - 1, k)) side(j, k + 1, j, k);
      if (!solid(j + 1, k)) side(j + 1, k, j + 1, k + 1);
      if (!solid(j, k - 1)) side(j, k, j + 1, k);
      if (!solid(j, k + 1)) side(j + 1, k + 1, j, k + 1);
    }
  return obj;
}

TEST(InSpace, AnOpenEndStopsBetweenTheLipsOfAShutMouth) {
  WorldSpec spec = test::lip();
  ObjSpec o;
  o.path = "mouth.obj", o.deep_angle_deg = 0, o.deep_plane_mm = 9.9, o.layers = spec.body->layers;
  auto body = std::make_shared<Body>(parse_obj(shut_mouth_obj(), o));
  spec.body = body;
  InlineWorkers workers;
  World world(spec, workers);
  const Outcome cut = world.apply(line(
      R"({"action":"cut_through","path":[[-6.1,4.1,14],[-6.1,12,14],[6.2,12,14],[6.2,4.1,14]],"normals":[[0,0,1],[0,0,1],[0,0,1],[0,0,1]],"open_start":true,"open_end":true})"));
  ASSERT_TRUE(cut.done) << cut.reason;
  const SurfaceView& v = world.skin()->topology()->view;
  for (size_t t = 0; t < v.tri.size(); ++t)
    if (v.kind[t] == FaceKind::wall)
      for (const int32_t c : v.tri[t]) ASSERT_GT(v.X_mm[size_t(c)].y(), 0) << "the other lip is cut";
  const Outcome taken = world.apply(line(R"({"action":"excise","at":[0,6,14]})"));
  ASSERT_TRUE(taken.done) << taken.reason;
  EXPECT_NEAR(world.skin()->removed_volume_mm3(), 12.3 * 11.8 * 8, 0.01 * 12.3 * 11.8 * 8);
}

/// The same lip, its back held to bone from y = 0 to so far.
WorldSpec lip_on_bone(double held_to_mm) {
  WorldSpec spec = test::lip();
  auto body = std::make_shared<Body>(*spec.body);
  for (size_t t = 0; t < body->surface.tri.size(); ++t) {
    bool back = true;
    for (const int32_t c : body->surface.tri[t]) {
      const Vec3& X = body->surface.X_mm[size_t(c)];
      back = back && X.z() == 0 && X.y() <= held_to_mm;
    }
    if (back) body->surface.tag[t] = SurfaceTag::fixed;
  }
  spec.body = body;
  return spec;
}

TEST(InSpace, ALoosePieceTakesAStripOfPeriosteumWithItAndNoMore) {
  for (const double held_to_mm : {10.0, 22.0}) {
    InlineWorkers workers;
    World world(lip_on_bone(held_to_mm), workers);
    ASSERT_TRUE(
        world
            .apply(line(
                R"({"action":"cut_through","path":[[-6.3,20.5,8],[0.2,8,8],[6.4,20.5,8]],"open_start":true,"open_end":true})"))
            .done);
    const Outcome taken = world.apply(line(R"({"action":"excise","at":[0,19,8]})"));
    EXPECT_EQ(taken.done, held_to_mm < 15) << held_to_mm << taken.reason;
  }
}

TEST(InSpace, AClosedCutThroughOpensToBothSidesAndStopsAtItsPosts) {
  InlineWorkers workers;
  World world(test::lip(), workers);
  const Outcome cut = world.apply(line(R"({"action":"cut_through","path":[[-7.3,11.1,8],[7.2,11.4,8]]})"));
  ASSERT_TRUE(cut.done) << cut.reason;
  EXPECT_EQ(world.skin()->pieces(), 1);
  EXPECT_NEAR(wall_mm2(world), 2 * 14.5 * 8, 0.01 * 2 * 14.5 * 8);  // a rectangle, two banks
  EXPECT_FALSE(world.apply(line(R"({"action":"excise","at":[0,19,8]})")).done);
}

TEST(InSpace, TheBackIsCutAsTheFrontIs) {
  // The same incision on both sides of a lip that is symmetric about its middle plane: as much wall, the same gape.
  double wall[2], gape[2];
  for (const int back : {0, 1}) {
    InlineWorkers workers;
    World world(test::lip({.cell_mm = 2, .prestretch = 1.1}), workers);
    const double z = back ? 0 : 8;
    const Outcome o = world.apply(Incise{{{-8, 11.2}, {8, 11.2}}, 3, 90});
    InSpace c{Incise{{{-8, 11.2}, {8, 11.2}}, 3, 90}, {z, z}};
    if (back) {
      ASSERT_TRUE(world.apply(Undo{}).done);
      ASSERT_TRUE(world.apply(c).done);
    } else {
      ASSERT_TRUE(o.done) << o.reason;
    }
    wall[back] = wall_mm2(world);
    const auto topology = world.skin()->topology();
    const SurfaceView& v = topology->view;
    for (size_t t = 0; t < v.tri.size(); ++t)  // none of it on the other side
      for (size_t k = 0; k < 3; ++k)
        if (v.rim[t] >> k & 1) EXPECT_NEAR(v.X_mm[size_t(v.tri[t][k])].z(), z, 1e-3);
    settle(world);
    gape[back] = gape_mm(world);
  }
  EXPECT_NEAR(wall[0], 2 * 16 * 3.15, 0.03 * 2 * 16 * 3.15);  // kWallExtra below the depth asked
  EXPECT_NEAR(wall[1], wall[0], 0.01 * wall[0]);
  EXPECT_GT(gape[0], 0.5);
  EXPECT_NEAR(gape[1], gape[0], 0.05 * gape[0]);
}

TEST(InSpace, AnActThatTheChartCanSeeIsTheSameThere) {
  // Given in space, a front incision differs from the chart's by nothing but the chart's origin.
  double wall[2];
  for (const bool in_space : {false, true}) {
    InlineWorkers workers;
    World world(test::small_block(), workers);
    const Outcome o =
        world.apply(line(in_space ? R"({"action":"incise","path":[[-9,1,0],[3,2,0],[9,-4,0]],"depth_mm":4})"
                                  : R"({"action":"incise","path":[[-9,1],[3,2],[9,-4]],"depth_mm":4})"));
    ASSERT_TRUE(o.done) << o.reason;
    wall[in_space] = wall_mm2(world);
  }
  EXPECT_NEAR(wall[0], wall[1], 0.01 * wall[0]);
}

TEST(InSpace, AHookHoldsTheFlapFromBelowOrItsBed) {
  for (const bool bed : {false, true}) {
    InlineWorkers workers;
    World world(test::small_block({.cell_mm = 4}), workers);
    ASSERT_TRUE(world.apply(Incise{{{-8, 8}, {-8, -8}, {8, -8}, {8, 8}}, 4, 90}).done);
    ASSERT_TRUE(world.apply(Undermine{{{-9, 9}, {-9, -9}, {9, -9}, {9, 9}}, 4}).done);
    const Outcome o = world.apply(line(bed ? R"({"action":"hook","id":1,"at":[0,-5,-3.85],"surface":"bed"})"
                                           : R"({"action":"hook","id":1,"at":[0,-5,-3.85],"surface":"under"})"));
    ASSERT_TRUE(o.done) << o.reason;
    ASSERT_TRUE(world.apply(MoveHook{1, {0, -5, 2}}).done);
    settle(world);
    const double under = moved_mm(world, {0, -5, -3.85}, 2, FaceKind::wall, -Vec3::UnitZ()).z(),
                 of_bed = moved_mm(world, {0, -5, -3.85}, 2, FaceKind::wall, Vec3::UnitZ()).z();
    if (bed) {
      EXPECT_GT(of_bed, 3);  // what lies on it is lifted with it
    } else {
      EXPECT_GT(under, 4);
      EXPECT_LT(std::abs(of_bed), 0.3);
    }
  }
}

TEST(InSpace, WhatIsTakenBackLeavesNoTrace) {
  for (const char* text : {R"({"action":"cut_through","path":[[0,19,8],[0.3,9,8]],"open_start":true})",
                           R"({"action":"incise","path":[[-8,11,0],[8,11,0]],"depth_mm":3})",
                           R"({"action":"undermine","outline":[[-6,8,0],[6,8,0],[6,16,0],[-6,16,0]],"depth_mm":3})",
                           R"({"action":"excise","outline":[[-4,9,0],[4,9,0],[4,14,0],[-4,14,0]],"depth_mm":3})",
                           R"({"action":"suture","a":[-2,7.5,0],"b":[-2,8.5,0]})"}) {
    InlineWorkers workers;
    World world(test::lip(), workers);
    ASSERT_TRUE(world.apply(line(R"({"action":"incise","path":[[-6,8,0],[6,8,0]],"depth_mm":3})")).done);
    const uint64_t was = world.skin()->topology_hash();
    const Outcome o = world.apply(line(text));
    ASSERT_TRUE(o.done) << text << o.reason;
    const uint64_t cut = world.skin()->topology_hash();
    ASSERT_TRUE(world.apply(Undo{}).done);
    EXPECT_EQ(world.skin()->topology_hash(), was) << text;
    ASSERT_TRUE(world.apply(Redo{}).done);
    EXPECT_EQ(world.skin()->topology_hash(), cut) << text;
  }
}

TEST(InSpace, WhatCannotBeDoneIsRefusedAndChangesNothing) {
  InlineWorkers workers;
  World world(test::lip(), workers);
  const uint64_t was = world.skin()->full_hash();
  const std::pair<const char*, const char*> refused[]{
      {R"({"action":"incise","path":[[0,11,30],[8,11,30]]})", "off the skin"},
      {R"({"action":"incise","path":[[0,11,8],[0,11,0]],"depth_mm":2})", "turns too far"},
      {R"({"action":"cut_through","path":[[-3,11,8],[3,11,8]],"normals":[[1,0,0],[1,0,0]]})",
       "come out on the other side"},
      {R"({"action":"cut_through","path":[[0,5,8],[0,9,8]],"open_end":true})", "no free margin"},
      {R"({"action":"excise","at":[0,19,8]})", "still attached"},
      {R"({"action":"hook","id":1,"at":[0,11,4],"surface":"bed"})", "no cut face"},
      {R"({"action":"hook","id":1,"at":[0,11],"surface":"bed"})", "[x, y, z]"},
      {R"({"action":"suture","a":[0,11,60],"b":[0,12,8]})", "(0.00, 11.00, 60.00) mm lies off the skin"},
      {R"({"action":"suture","a":[0,11,8],"b":[0,12,8],"depth_mm":1})", "no wound's edge near (0.00, 11.00, 8.00)"},
      {R"({"action":"suture_row","a":[[0,11,8],[4,11,8]],"b":[[0,12,8],[4,12,8]],"spacing_mm":2,"depth_mm":1})",
       "no wound's edge near (0.00, 11.00, 8.00)"},
  };
  for (const auto& [text, why] : refused) {
    const Outcome o = world.apply(line(text));
    EXPECT_FALSE(o.done) << text;
    EXPECT_NE(o.reason.find(why), std::string::npos) << text << ": " << o.reason;
    EXPECT_EQ(world.skin()->full_hash(), was) << text;
  }
}

TEST(InSpace, LinesGoThereAndBack) {
  for (
      const char* text :
      {R"({"action":"incise","path":[[-8.0,11.0,0.5],[8.0,11.0,0.25]],"depth_mm":3.0,"angle_deg":90.0})",
       R"({"action":"undermine","outline":[[-6.0,8.0,0.0],[6.0,8.0,0.0],[6.0,16.0,1.5]],"depth_mm":3.0})",
       R"({"action":"excise","at":[1.0,2.0,3.0]})", R"({"action":"excise","at":[1.0,2.0]})",
       R"({"action":"hook","id":1,"at":[0.0,-5.0,-3.5],"surface":"under"})",
       R"({"action":"suture","a":[1.0,2.0,3.0],"b":[4.0,5.0,6.0],"surface_b":"bed"})",
       R"({"action":"suture_between","from":1,"to":[1.0,2.0,3.0],"spacing_mm":4.0})",
       R"({"action":"cut_suture","at":[1.0,2.0,3.0]})",
       R"({"action":"cut_through","path":[[0.0,1.0,2.0],[3.0,4.0,5.0]],"normals":[[0.0,0.0,1.0],[0.0,0.0,1.0]],"open_end":true})"})
    EXPECT_EQ(to_json_line(line(text)), text);
  for (const char* mixed :
       {R"({"action":"suture","a":[1,2,3],"b":[4,5]})", R"({"action":"incise","path":[[1,2,3],[4,5]]})",
        R"({"action":"incise","path":[[1,2],[4,5,6]]})",
        R"({"action":"cut_through","path":[[0,1,2],[3,4,5]],"normals":[[0,0,1]]})",
        R"({"action":"cut_through","path":[[0,1,2],[3,4,5]],"normals":[[0,0,1],[0,0,0]]})",
        R"({"action":"hook","id":1,"at":[0,1,2],"surface":"nowhere"})"})
    EXPECT_THROW(line(mixed), InputError) << mixed;
}

// A picture that lies over the skin as the chart does: an act by its texture is the act on the chart.
TEST(ByTexture, AnActIsThatOfThePlacesWhereItsTextureLies) {
  InlineWorkers workers;
  WorldSpec spec = test::small_block({});
  auto body = std::make_shared<Body>(*spec.body);
  TriMesh& m = body->surface;
  m.uv.assign(m.tri.size(), {});
  const auto uv_of = [](const Vec3& X) { return Eigen::Vector2d(0.5 + X.x() / 100, 0.25 + X.y() / 200); };
  for (size_t t = 0; t < m.tri.size(); ++t) {  // skin only: elsewhere the picture has no width
    double lowest = 1e9;
    for (int32_t v : m.tri[t]) lowest = std::min(lowest, m.X_mm[size_t(v)].z());
    for (size_t k = 0; k < 3; ++k)
      if (lowest > -1e-9) m.uv[t][k] = uv_of(m.X_mm[size_t(m.tri[t][k])]).cast<float>();
  }
  spec.body = body;
  const auto parse = [](const std::string& text) { return parse_command(text, "x", 1); };
  const auto run = [&](const std::vector<std::string>& lines) {
    World world(spec, workers);
    for (const std::string& l : lines) {
      const Outcome o = world.apply(parse(l));
      EXPECT_TRUE(o.done) << l << ": " << o.reason;
    }
    Snapshot s;
    world.fill(s);
    EXPECT_EQ(s.hooks.size(), 1u);
    return s.hooks.at(0).at_mm;
  };
  const Vec3f by_place = run(
      {R"({"action":"incise","path":[[-6,1,0],[6,1,0]],"depth_mm":3})", R"({"action":"hook","id":1,"at":[0,3,0]})"});
  const Vec3f by_texture = run({R"({"action":"incise","path":[{"uv":[0.44,0.255]},{"uv":[0.56,0.255]}],"depth_mm":3})",
                                R"({"action":"hook","id":1,"at":{"uv":[0.5,0.265]}})"});
  EXPECT_LT((by_place - by_texture).norm(), 1e-3f);
  // Where it lies is told to whoever asks before; what the skin does not have is refused with its line.
  Script script = parse_script(
      "{\"limberg_script\":1,\"scene\":\"x\"}\n"
      "{\"action\":\"hook\",\"id\":1,\"at\":{\"uv\":[0.5,0.265]}}\n",
      "s");
  EXPECT_TRUE(has_texture_places(script));
  EXPECT_NE(to_json_line(script.lines[0].command).find(R"("at":{"uv":[0.5,0.265]})"), std::string::npos);
  const Script laid = on_texture(script, *body);
  EXPECT_FALSE(has_texture_places(laid));
  EXPECT_LT((places_of(std::get<InSpace>(laid.lines[0].command))[0] - Vec3(0, 3, 0)).norm(), 1e-3);
  World world(spec, workers);
  const Outcome off = world.apply(parse(R"({"action":"hook","id":1,"at":{"uv":[3,3]}})"));
  EXPECT_FALSE(off.done);
  EXPECT_NE(off.reason.find("nowhere"), std::string::npos) << off.reason;
  script.lines[0].command = parse(R"({"action":"hook","id":1,"at":{"uv":[3,3]}})");
  EXPECT_THROW(on_texture(script, *body), InputError);
  const auto plain = std::make_shared<Body>(*test::small_block({}).body);
  plain->surface.uv.clear();
  std::string reason;
  EXPECT_FALSE(place_on_texture(*plain, {0.5, 0.265}, reason));
  EXPECT_NE(reason.find("no texture"), std::string::npos);
}

// A picture that lies twice on the skin tells of two places; at an edge, where two triangles meet, of one.
TEST(ByTexture, APlaceThatIsTwoIsRefused) {
  Body body;
  body.surface.X_mm = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {10, 0, 0}, {14, 0, 0}, {10, 4, 0}};
  body.surface.tri = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}};
  using V = Eigen::Vector2f;
  body.surface.uv = {{V(0, 0), V(1, 0), V(1, 1)}, {V(0, 0), V(1, 1), V(0, 1)}, {V(2, 2), V(3, 2), V(2, 3)}};
  std::string reason;
  const auto edge = place_on_texture(body, {0.5, 0.5}, reason);
  ASSERT_TRUE(edge) << reason;
  EXPECT_LT((*edge - Vec3(2, 2, 0)).norm(), 1e-5);
  EXPECT_TRUE(place_on_texture(body, {2.2, 2.2}, reason));
  body.surface.uv[2] = {V(0, 0), V(1, 0), V(0, 1)};
  body.surface.tag = {SurfaceTag::skin, SurfaceTag::skin, SurfaceTag::fixed};
  EXPECT_TRUE(place_on_texture(body, {0.3, 0.2}, reason)) << "what is no skin does not count";
  body.surface.tag.clear();
  EXPECT_FALSE(place_on_texture(body, {0.3, 0.2}, reason));
  EXPECT_NE(reason.find("two places"), std::string::npos) << reason;
}

// Only places on skin are by texture: where a hook is carried to, and directions, are in the world.
TEST(ByTexture, WhatIsNoPlaceOnSkinIsRefused) {
  for (const char* line : {R"({"action":"move_hook","id":1,"to_mm":{"uv":[0.5,0.5]}})",
                           R"({"action":"hook","id":1,"at":{"vu":[0.5,0.5]}})", R"({"action":"hook","id":1,"at":{}})",
                           R"({"action":"hook","id":1,"at":{"uv":[0.5]}})",
                           R"({"action":"incise","path":[{"uv":[0.5,0.5]},[3,4]],"depth_mm":3})"})
    EXPECT_THROW(parse_command(line, "x", 1), InputError) << line;
  EXPECT_NO_THROW(parse_command(R"({"action":"incise","path":[{"uv":[0.5,0.5]},[3,4,0]],"depth_mm":3})", "x", 1));
}

}  // namespace test_in_space
}  // namespace limberg
