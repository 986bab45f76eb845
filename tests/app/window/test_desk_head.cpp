// What the window makes of a head: picks, tissue between them, figures that follow.
#include <gtest/gtest.h>

#include "app/window/desk_head.h"
#include "app/window/live_measures.h"
#include "devices/pick.h"
#include "sim/commands/words.h"

namespace limberg {
namespace test_desk_head {

Snapshot two_sheets() {
  auto t = std::make_shared<SurfaceTopology>();
  t->version = 1;
  for (const double z : {0., 20.})
    for (const Vec3& X : {Vec3(0, 0, z), Vec3(30, 0, z), Vec3(0, 30, z)}) t->view.X_mm.push_back(X);
  t->view.tri.push_back({0, 1, 2}), t->view.tri.push_back({3, 4, 5});
  for (const Organ o : {Organ::bone, Organ::face})
    t->view.kind.push_back(FaceKind::free), t->organ.push_back(o), t->object.push_back(-1);
  t->landmark = {"M1", "M2", "M3"};
  Snapshot s;
  for (size_t v = 0; v < 6; ++v) s.x_mm.push_back((t->view.X_mm[v] + Vec3(0, 0, 5)).cast<float>());
  s.landmark_mm = {{0, 0, 0}, {3, 0, 0}, {3, 4, 0}};
  s.topology = t, s.topology_version = 1;
  return s;
}

using Names = std::vector<std::string>;  // of the landmarks that the patient has

TEST(DeskHead, APickIsThePlaceAtRestOfWhatLiesUnderTheMouse) {
  const Snapshot s = two_sheets();
  DeskHead d;
  d.see({"al_R", "Pog"});  // it came with these: they were not picked
  EXPECT_FALSE(d.tied());
  const Vec3f bary(0.5f, 0.25f, 0.25f);
  ControlSample c = d.picked(s, 0, bary);
  EXPECT_EQ(c.kind, pick::landmark);
  EXPECT_EQ(c.text.str(), "M1");
  EXPECT_EQ(c.value, (std::array<double, 4>{7.5, 7.5, 0, double(pick::bone)}));
  d.see({"al_R", "Pog", "M1"});
  EXPECT_FALSE(d.tied());
  c = d.picked(s, 1, bary);
  EXPECT_EQ(c.text.str(), "M2");
  EXPECT_EQ(c.value, (std::array<double, 4>{7.5, 7.5, 20, double(pick::face)}));
  EXPECT_FALSE(d.tied());  // the patient has not got it yet
  d.see({"al_R", "Pog", "M1", "M2"});
  const auto tie = d.tied();
  ASSERT_TRUE(tie);
  EXPECT_EQ(tie->text.str(), "M2/M1/finite_elements");
  d.mode = int(TissueKind::springs);
  EXPECT_EQ(d.tied()->text.str(), "M2/M1/springs");
  // A name of the list does not set the count back, and beside the patient the tool is asked.
  std::string("Pog").copy(d.name.data(), 4);
  d.name[3] = 0;
  EXPECT_EQ(d.picked(s, -1, bary).value[3], double(pick::touched));
  EXPECT_STREQ(d.name.data(), "M3");
  d.see({"al_R", "Pog", "M1", "M2"});
  EXPECT_EQ(d.tied()->text.str(), "M2/Pog/springs");
}

TEST(DeskHead, BonesAreActedOnThroughThePlacesPickedLast) {
  const Snapshot s = two_sheets();
  DeskHead d;
  const auto asked = [&](DeskHead::Ask what) {
    d.ask = what;
    return d.asked();
  };
  EXPECT_TRUE(asked(DeskHead::Ask::shift).empty());
  const std::vector<Vec3> at{{30, 0, 0}, {0, 30, 0}, {0, 0, 0}};
  for (const Vec3f& bary : {Vec3f(0, 1, 0), Vec3f(0, 0, 1), Vec3f(1, 0, 0)}) {
    d.picked(s, 0, bary);
    d.picked(s, 1, bary);  // the face does not count, though it is called M as well
  }
  d.see({"M1", "M2", "M3", "M4", "M5", "M6"});
  d.shift_mm = {0, 8, -1.5f}, d.turn_deg = {0, 0, 12.25f};
  auto c = asked(DeskHead::Ask::shift);
  ASSERT_EQ(c.size(), 1u);
  EXPECT_EQ(c[0].kind, pick::shift);
  EXPECT_EQ(c[0].text.str(), "0 8 -1.5 0 0 12.25");
  EXPECT_EQ(c[0].value, (std::array<double, 4>{0, 0, 0, 0}));
  c = asked(DeskHead::Ask::plate);
  ASSERT_EQ(c.size(), 1u);
  EXPECT_EQ(c[0].value, (std::array<double, 4>{0, 30, 0, 0}));
  EXPECT_EQ(c[0].text.str(), "0.0000 0.0000 0.0000");
  c = asked(DeskHead::Ask::saw_plane);
  ASSERT_EQ(c.size(), 1u);
  EXPECT_EQ(c[0].value, (std::array<double, 4>{10, 10, 0, 0}));
  double n[3]{};
  ASSERT_EQ(std::sscanf(c[0].text.str().c_str(), "%lf %lf %lf", n, n + 1, n + 2), 3);
  EXPECT_EQ(Vec3(n[0], n[1], n[2]), Vec3(0, 0, 1));
  EXPECT_TRUE(asked(DeskHead::Ask::saw_round).empty());  // a ring of four
  d.ring = 3;
  c = asked(DeskHead::Ask::saw_round);
  ASSERT_EQ(c.size(), 3u);
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(c[k].kind, pick::corner);
    EXPECT_EQ(c[k].value, (std::array<double, 4>{at[k].x(), at[k].y(), at[k].z(), double(k)}));
  }
  // The longest numbers still fit into a control's text: as the panel shows them, to a hundredth.
  d.shift_mm = {-123.456f, -123.456f, -123.456f}, d.turn_deg = d.shift_mm;
  EXPECT_EQ(asked(DeskHead::Ask::shift)[0].text.str(), "-123.46 -123.46 -123.46 -123.46 -123.46 -123.46");
  d.shift_mm = {-0.00012345f, -1.2345e-7f, 0.014999f}, d.turn_deg = {-1e6f, 1e6f, -123.456f};
  EXPECT_EQ(asked(DeskHead::Ask::shift)[0].text.str(), "0 0 0.01 -999.99 999.99 -123.46");
}

TEST(DeskHead, APickThatWasUndoneDoesNotCountUntilItIsDoneAgain) {
  const Snapshot s = two_sheets();
  DeskHead d;
  const auto pick = [&](const char* called, const Vec3f& bary) {
    d.name.fill(0);
    std::string(called).copy(d.name.data(), d.name.size() - 1);
    d.picked(s, 0, bary);
  };
  const auto plate = [&](const Names& patient) -> std::vector<double> {  // where it would begin and end
    d.see(patient);
    d.ask = DeskHead::Ask::plate;
    const auto c = d.asked();
    if (c.empty()) return {};
    double end[3]{};
    std::sscanf(c[0].text.str().c_str(), "%lf %lf %lf", end, end + 1, end + 2);
    return {c[0].value[0], c[0].value[1], end[0], end[1]};
  };
  const std::vector<double> of_12{30, 0, 0, 0}, of_23{0, 0, 0, 30};
  pick("M1", {0, 1, 0}), pick("M2", {1, 0, 0});
  EXPECT_EQ(plate({"M1", "M2"}), of_12);
  pick("M3", {0, 0, 1});
  EXPECT_EQ(plate({"M1", "M2"}), of_12);  // the patient has not got it yet, or refused it
  EXPECT_EQ(plate({"M1", "M2", "M3"}), of_23);
  EXPECT_EQ(plate({"M1", "M2"}), of_12);        // undone
  EXPECT_EQ(plate({"M1", "M2", "M3"}), of_23);  // and done again
  EXPECT_TRUE(plate({"M1"}).empty());
  pick("M1", {0, 1, 0});  // once more: it is one place, and the last now
  EXPECT_EQ(plate({"M1", "M2", "M3"}), (std::vector<double>{0, 30, 30, 0}));
}

TEST(DeskHead, WhatTheSkullLiesUponIsToldOnceAndHeardFromOthers) {
  DeskHead d;
  EXPECT_FALSE(d.laid_upon());
  d.beside = SkullBeside::mirror;
  const auto c = d.laid_upon();
  ASSERT_TRUE(c);
  EXPECT_EQ(c->kind, pick::beside);
  EXPECT_EQ(c->value[0], double(SkullBeside::mirror));
  EXPECT_FALSE(d.laid_upon());
  // A script does it: shown, and not told back.
  d.hear(in_words(HeadCommand(Superpose{SkullBeside::normal, "advanced"})));
  EXPECT_EQ(d.beside, SkullBeside::normal);
  EXPECT_FALSE(d.laid_upon());
  d.hear("landmark M1");
  EXPECT_EQ(d.beside, SkullBeside::normal);
}

TEST(LiveMeasures, FollowTheLandmarks) {
  Snapshot s = two_sheets();
  LiveMeasures live;
  const auto at = [&](const std::string& name) -> HeadMeasure {
    for (const HeadMeasure& m : live.read(s))
      if (m.name == name) return m;
    ADD_FAILURE() << name;
    return {};
  };
  EXPECT_EQ(at("M1-M2").now, 3);
  EXPECT_NEAR(at("M1-M2-M3").now, 90, 1e-9);
  EXPECT_EQ(at("M1-M2").change(), 0);
  s.landmark_mm[0] = {-2, 0, 0};
  EXPECT_EQ(at("M1-M2").now, 5);
  EXPECT_EQ(at("M1-M2").change(), 2);
  EXPECT_EQ(at("M2-M3").change(), 0);
  // Another one later: from where it was picked.
  auto t = std::make_shared<SurfaceTopology>(*s.topology);
  t->version = 2, t->landmark.push_back("M4");
  s.topology = t, s.landmark_mm.push_back({3, 4, 2});
  EXPECT_EQ(at("M3-M4").now, 2);
  EXPECT_EQ(at("M1-M2").change(), 2);
}

}  // namespace test_desk_head
}  // namespace limberg
