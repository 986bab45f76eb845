// Where a peer's places lie, what cuts enclose, and what becomes of each kind of act.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/import/carried_acts.h"
#include "app/import/cut_lines.h"
#include "sim/commands/script.h"
#include "tests/app/import/peer_fixture.h"

namespace limberg {
namespace test_carried_acts {

using nlohmann::json;
using test::PeerFixture;

std::optional<FoundPlace> find(const PeerModel& m, const std::string& place, std::string& reason) {
  const PeerHistory h = parse_peer_history("[{\"excise\":{" + place + "}}]", "h");
  EXPECT_EQ(h.act[0].wrong, "");
  return find_place(m, h.act[0].post[0].place, reason);
}

TEST(PeerPlaces, TextureAndDisplacementGiveThePoint) {
  const PeerFixture f;
  const PeerModel m = f.model();
  EXPECT_NEAR(m.history_mm, PeerFixture::history_mm(), 1e-12);
  EXPECT_NEAR(m.median_depth_mm(), 2, 1e-9);
  std::string reason;
  for (int i = 0; i < 200; ++i) {
    const double x = 3 + 54 * std::fmod(i * 0.618, 1), y = 3 + 34 * std::fmod(i * 0.414, 1);
    const Vec3 moved(4 * std::fmod(i * 0.23, 1) - 2, 4 * std::fmod(i * 0.77, 1) - 2, 0.2);
    const auto p = find(m, PeerFixture::place(x, y, moved), reason);
    ASSERT_TRUE(p) << reason;
    EXPECT_LT((p->start.at_mm - Vec3(x, y, 12)).norm(), 1e-4);  // textures are floats
    EXPECT_LT((p->spot.at_mm - Vec3(x + moved.x(), y + moved.y(), 12)).norm(), 1e-4);
    EXPECT_NEAR(p->moved_mm, 0.2, 1e-4);
  }
}

// The mucosa is 12 mm below, and so is a point in the middle of the slab from either side.
TEST(PeerPlaces, StayOnTheirSideOfALip) {
  const PeerFixture f;
  const PeerModel m = f.model();
  std::string reason;
  const auto top = find(m, PeerFixture::place(45, 20, Vec3(0, 0, -7)), reason);
  ASSERT_TRUE(top);
  EXPECT_NEAR(top->spot.at_mm.z(), 12, 1e-6);
  // Over the margin, where the way is short, it goes round.
  const auto round = find(m, PeerFixture::place(58, 20, Vec3(2, 0, -6)), reason);
  ASSERT_TRUE(round);
  EXPECT_LT((round->spot.at_mm - Vec3(60, 20, 6)).norm(), 1e-3);
}

TEST(PeerPlaces, OfACutFaceLiesWhereTheSkinEnds) {
  const PeerFixture f;
  std::string reason;
  const auto p = find(f.model(), PeerFixture::place(20, 20, Vec3(1, 0, 0), 4), reason);
  ASSERT_TRUE(p);
  EXPECT_TRUE(p->inner);
  EXPECT_LT((p->inner_mm - Vec3(21, 20, 10)).norm(), 1e-4);
  EXPECT_LT((p->spot.at_mm - Vec3(21, 20, 12)).norm(), 1e-4);
}

TEST(PeerPlaces, OffTheTextureAreRefused) {
  const PeerFixture f;
  std::string reason;
  EXPECT_FALSE(find(f.model(), PeerFixture::place(20, 400), reason));
  EXPECT_NE(reason.find("no triangle of material 2"), std::string::npos) << reason;
  // Periphery has no area on the texture at all.
  EXPECT_FALSE(find(f.model(), PeerFixture::place(20, 20, Vec3::Zero(), 1), reason));
}

SurfaceSpot on_top(const PeerModel& m, double x, double y) {
  const auto c = m.all.closest(Vec3(x, y, 12));
  return {c.triangle, c.bary, c.point_mm};
}

TEST(CutLines, EncloseAndCross) {
  const PeerFixture f;
  const PeerModel m = f.model();
  CutLines cuts(m);
  EXPECT_FALSE(cuts.region(on_top(m, 20, 20)));
  const auto ring = [&](double r) {
    std::vector<SurfaceSpot> posts;
    for (int i = 0; i <= 12; ++i)
      posts.push_back(on_top(m, 25 + r * std::cos(i * M_PI / 6), 20 + r * std::sin(i * M_PI / 6)));
    posts.back() = posts.front();
    return cuts.through(posts);
  };
  cuts.add(ring(8), false);
  const auto in = cuts.region(on_top(m, 25.3, 20.2));
  ASSERT_TRUE(in);
  const double area = 0.5 * 12 * 64 * std::sin(M_PI / 6);
  EXPECT_NEAR(in->area_mm2, area, 0.06 * area);  // triangles of a step or two along the rim
  EXPECT_GE(in->outline.size(), 10u);
  for (const Vec3& p : in->outline) EXPECT_NEAR((p - Vec3(25, 20, 12)).norm(), 8, 0.4);
  EXPECT_FALSE(cuts.region(on_top(m, 40, 20)));  // the rest of the skin is more than half of it
  EXPECT_TRUE(cuts.crossing(Vec3(32, 20, 12), Vec3(34, 20, 12), Vec3::UnitZ()));
  EXPECT_FALSE(cuts.crossing(Vec3(34, 20, 12), Vec3(36, 20, 12), Vec3::UnitZ()));
  EXPECT_FALSE(cuts.crossing(Vec3(32, 20, 0), Vec3(34, 20, 0), Vec3::UnitZ())) << "of the mucosa below";
  const auto near = cuts.nearest(Vec3(34, 20, 12), 5);
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->distance_mm, 1, 0.02);
}

TEST(CutLines, FindTheShorterWayRound) {
  const PeerFixture f;
  const PeerModel m = f.model();
  CutLines cuts(m);
  cuts.add(cuts.through({on_top(m, 10, 10), on_top(m, 40, 10), on_top(m, 40, 30)}), false);
  cuts.add(cuts.through({on_top(m, 20, 10), on_top(m, 20, 30)}), false);  // meets the first one
  cuts.add(cuts.through({on_top(m, 50, 10), on_top(m, 50, 30)}), false);  // does not
  const auto at = [&](double x, double y) { return *cuts.nearest(Vec3(x, y, 12), 1); };
  const auto way = cuts.way(at(20, 28), at(40, 28));
  ASSERT_FALSE(way.empty());
  double length = 0;
  for (size_t i = 0; i + 1 < way.size(); ++i) length += (way[i + 1] - way[i]).norm();
  EXPECT_NEAR(length, 18 + 20 + 18, 0.6);
  EXPECT_TRUE(cuts.way(at(20, 28), at(50, 28)).empty());
}

CarriedOperation carried(const PeerModel& m, const std::vector<std::string>& acts) {
  return carry(parse_peer_history(PeerFixture::history(acts), "h.hst"), m, {});
}
std::vector<json> lines(const CarriedOperation& o, const std::string& action) {
  std::vector<json> out;
  for (const std::string& l : o.script)
    if (json j = json::parse(l); j["action"] == action) out.push_back(j);
  return out;
}
Vec3 at(const json& p) { return Vec3(p[0].get<double>(), p[1].get<double>(), p[2].get<double>()); }

TEST(CarriedActs, EveryKindComesToALineThatTheProgramReads) {
  const PeerFixture f;
  using F = PeerFixture;
  const CarriedOperation o =
      carried(f.model(),
              {F::incision({{10, 14}, {22, 14}, {22, 26}, {10, 26}}, false, true), F::excise(16, 20),
               F::incision({{23, 20}, {34, 20}, {34, 30}}, true, false),
               F::undermine({{23, 16}, {38, 16}, {38, 30}}, true, true),
               F::deep_cut({{50, 10}, {48, 20}, {50, 30}}, true, true), F::hook(0, F::place(30, 22)),
               R"({"moveHook":[0,3,2.5,2]})", R"({"pausePhysics":0})",
               F::suture(3, F::place(24, 20.4, Vec3::Zero(), 2, "0"), F::place(24, 19.6, Vec3::Zero(), 2, "1"), false),
               F::suture(4, F::place(33, 20.4, Vec3::Zero(), 2, "0"), F::place(33, 19.6, Vec3::Zero(), 2, "1"), true),
               F::suture(5, F::place(30, 22, Vec3::Zero(), 4, "0"), F::place(30, 18, Vec3::Zero(), 5, "1"), false),
               R"({"deleteSuture":3})", R"({"deleteHook":0})"});
  for (const CarriedAct& a : o.act)
    EXPECT_NE(a.fate, CarriedAct::Fate::refused) << a.name << (a.notes.empty() ? "" : a.notes[0]);
  std::string text = "{\"limberg_script\":1,\"scene\":\"slab\"}\n";
  for (const std::string& l : o.script) text += l + "\n";
  EXPECT_EQ(parse_script(text, "carried").lines.size(), o.script.size());

  ASSERT_EQ(lines(o, "cut_through").size(), 1u);
  EXPECT_TRUE(lines(o, "cut_through")[0]["open_start"].get<bool>());
  EXPECT_LT((at(lines(o, "move")[0]["to"]) - Vec3(30, 25, 20)).norm(), 1e-9);
  ASSERT_EQ(lines(o, "suture").size(), 3u);
  EXPECT_EQ(lines(o, "suture")[2]["surface_a"], "under");
  EXPECT_EQ(lines(o, "suture")[2]["surface_b"], "bed");
  EXPECT_GT(lines(o, "suture")[2]["a"][2].get<double>(), lines(o, "suture")[2]["b"][2].get<double>());
  EXPECT_EQ(lines(o, "suture_between").size(), 1u);
  EXPECT_EQ(lines(o, "cut_suture").size(), 1u);
  EXPECT_EQ(lines(o, "release").size(), 1u);
  EXPECT_GE(lines(o, "stage").size(), 5u);
  // The account names lines of the script, of which the first is its head.
  for (const CarriedAct& a : o.act)
    if (a.name == "undermine") {
      EXPECT_EQ(json::parse(o.script[size_t(a.first) - 2])["action"], "undermine");
    }
}

TEST(CarriedActs, AClosedIncisionAndItsExcisionAreOnePlug) {
  const PeerFixture f;
  const CarriedOperation o = carried(
      f.model(),
      {PeerFixture::incision({{10, 14}, {22, 14}, {22, 26}, {10, 26}}, false, true), PeerFixture::excise(16, 20)});
  const auto excised = lines(o, "excise");
  ASSERT_EQ(excised.size(), 1u);
  ASSERT_EQ(excised[0]["outline"].size(), 4u) << excised[0].dump();
  EXPECT_LT((at(excised[0]["outline"][1]) - Vec3(22, 14, 12)).norm(), 1e-3);
  EXPECT_NEAR(excised[0]["depth_mm"], 2, 0.3);
}

TEST(CarriedActs, ATInBeginsAtTheNearestCut) {
  const PeerFixture f;
  const CarriedOperation o = carried(f.model(), {PeerFixture::incision({{10, 20}, {40, 20}}),
                                                 PeerFixture::incision({{25, 23}, {25, 35}}, true, false)});
  const json path = lines(o, "incise")[1]["path"];
  EXPECT_LT((at(path[0]) - Vec3(25, 20, 12)).norm(), 0.05);
  EXPECT_NEAR(o.act[2].moved_mm, 3, 0.05);
}

TEST(CarriedActs, UnderminingIsClosedAlongTheCut) {
  const PeerFixture f;
  const CarriedOperation o = carried(f.model(), {PeerFixture::incision({{10, 10}, {30, 10}, {30, 30}}),
                                                 PeerFixture::undermine({{12, 13}, {12, 28}, {28, 28}}, true, true)});
  const json outline = lines(o, "undermine")[0]["outline"];
  bool corner = false;
  for (const json& p : outline) corner = corner || (at(p) - Vec3(30, 10, 12)).norm() < 0.5;
  EXPECT_TRUE(corner) << outline.dump();
  // So deep goes the incision at least.
  EXPECT_GT(lines(o, "incise")[0]["depth_mm"].get<double>(), lines(o, "undermine")[0]["depth_mm"].get<double>());
}

// The two ends of a stitch lie on the same cut: each stays on the bank that it was recorded from.
TEST(CarriedActs, AStitchStaysOnItsBank) {
  const PeerFixture f;
  const CarriedOperation o =
      carried(f.model(), {PeerFixture::incision({{10, 20}, {40, 20}}),
                          PeerFixture::suture(0, PeerFixture::place(25, 22, Vec3(0, -2, 0), 2, "0"),
                                              PeerFixture::place(25, 17, Vec3(0, 3.4, 0), 2, "1"), false)});
  const json s = lines(o, "suture")[0];
  EXPECT_NEAR(at(s["a"]).y(), 20.3, 0.05);
  EXPECT_NEAR(at(s["b"]).y(), 19.7, 0.05);
}

TEST(CarriedActs, ACutOnTheBedOfAFlapBeginsThere) {
  const PeerFixture f;
  using F = PeerFixture;
  const auto deep_cut = [](const std::string& a, const std::string& b) {
    return R"({"makeDeepCut":[{"deepCutObject":0,"openIn":false,"openOut":false,"pointNumber":2},{"deepCutPoint":{)" +
           a + R"(,"postNormal":[0,0,1]}},{"deepCutPoint":{)" + b + R"(,"postNormal":[0,0,1]}}]})";
  };
  const std::string on_bed[] = {F::place(20, 12, Vec3::Zero(), 5), F::place(20, 18, Vec3::Zero(), 5)};
  const CarriedOperation o =
      carried(f.model(), {F::undermine({{12, 8}, {28, 8}, {28, 22}, {12, 22}}, false, false),
                          deep_cut(on_bed[0], on_bed[1]), deep_cut(F::place(20, 12), on_bed[1])});
  ASSERT_EQ(o.act.size(), 4u);
  EXPECT_EQ(o.act[2].fate, CarriedAct::Fate::carried);
  ASSERT_EQ(lines(o, "cut_through").size(), 1u);
  const json cut = lines(o, "cut_through")[0];
  EXPECT_EQ(cut["from_bed"], true);
  for (const json& p : cut["path"]) EXPECT_LT(at(p).z(), 12 - 1) << "below the skin, which lies at 12";
  EXPECT_EQ(o.act[3].fate, CarriedAct::Fate::refused) << "partly on skin";
}

TEST(CarriedActs, WhatCannotBeCarriedSaysWhyAndTheRestIs) {
  const PeerFixture f;
  using F = PeerFixture;
  const CarriedOperation o = carried(
      f.model(), {F::excise(20, 20), F::excise(20, 900), R"({"moveHook":[5,0,0,0]})", R"({"deleteSuture":1})",
                  R"({"periostealUndermine":[{"periostealTriangle":{)" + F::place(10, 10, Vec3::Zero(), 7, "", true) +
                      R"(}},{"periostealTriangle":{)" + F::place(20, 10, Vec3::Zero(), 7, "", true) +
                      R"(}},{"periostealTriangle":{)" + F::place(20, 20, Vec3::Zero(), 8, "", true) + "}}]}",
                  F::incision({{10, 20}, {40, 20}})});
  using Fate = CarriedAct::Fate;
  const Fate expected[] = {Fate::passed,  Fate::refused, Fate::refused, Fate::refused,
                           Fate::refused, Fate::changed, Fate::carried};
  ASSERT_EQ(o.act.size(), std::size(expected));
  for (size_t i = 0; i < o.act.size(); ++i) {
    EXPECT_EQ(o.act[i].fate, expected[i]) << i;
    EXPECT_EQ(o.act[i].notes.empty(), expected[i] == Fate::passed || expected[i] == Fate::carried) << i;
    EXPECT_EQ(o.act[i].first == 0, expected[i] == Fate::passed || expected[i] == Fate::refused) << i;
  }
  EXPECT_EQ(o.count(Fate::refused), 4);
  EXPECT_EQ(lines(o, "undermine").size(), 1u);
  EXPECT_NEAR(lines(o, "undermine")[0]["depth_mm"], 1.25 * 12 + 1, 0.01);  // at most: it follows the periosteum
  EXPECT_EQ(lines(o, "undermine")[0]["above_held_mm"], 0.5);
}

}  // namespace test_carried_acts
}  // namespace limberg
