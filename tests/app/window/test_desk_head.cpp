// What the window makes of a head: picks, tissue between them, figures that follow.
#include <gtest/gtest.h>

#include "app/window/desk_head.h"
#include "app/window/live_measures.h"
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
  const auto landmark = [&](int32_t triangle) {
    return std::get<PlaceLandmark>(std::get<HeadCommand>(std::get<Command>(d.picked(s, triangle, bary))));
  };
  PlaceLandmark l = landmark(0);
  EXPECT_EQ(l.name, "M1");
  EXPECT_EQ(l.at_mm, Vec3(7.5, 7.5, 0));
  EXPECT_FALSE(l.on_face);
  d.see({"al_R", "Pog", "M1"});
  EXPECT_FALSE(d.tied());
  l = landmark(1);
  EXPECT_EQ(l.name, "M2");
  EXPECT_EQ(l.at_mm, Vec3(7.5, 7.5, 20));
  EXPECT_TRUE(l.on_face);
  EXPECT_FALSE(d.tied());  // the patient has not got it yet
  const std::vector<Vec3f> now{{0, 0, 0}, {0, 0, 0}, {1, 2, 3}, {4, 5, 6}};
  d.see({"al_R", "Pog", "M1", "M2"}, now);
  const auto tissue = [&] { return std::get<ConnectTissue>(std::get<HeadCommand>(*d.tied())); };
  ASSERT_TRUE(d.tied());
  EXPECT_EQ(tissue().name, "M2-M1");
  EXPECT_EQ(tissue().face_mm, Vec3(4, 5, 6));  // where they are now
  EXPECT_EQ(tissue().bone_mm, Vec3(1, 2, 3));
  EXPECT_EQ(tissue().mode, TissueKind::finite_elements);
  d.tissue.mode = TissueKind::springs, d.tissue.young_kPa = 12;
  EXPECT_EQ(tissue().mode, TissueKind::springs);
  EXPECT_EQ(tissue().young_kPa, 12);
  // A name of the list does not set the count back, and beside the patient the tool is asked.
  std::string("Pog").copy(d.name.data(), 4);
  d.name[3] = 0;
  const auto touched = std::get<ControlSample>(d.picked(s, -1, bary));
  EXPECT_EQ(touched.kind, ControlSample::name_place);
  EXPECT_EQ(touched.value[3], double(kTouchedBone));
  EXPECT_EQ(touched.text.str(), "Pog");
  EXPECT_STREQ(d.name.data(), "M3");
  d.see({"al_R", "Pog", "M1", "M2"}, now);
  EXPECT_EQ(tissue().name, "M2-Pog");
  // Of three places on the face or more an outline, where that is asked for.
  d.outlined = true;
  EXPECT_TRUE(tissue().face_outline_mm.empty());
  for (int i = 0; i < 2; ++i) landmark(1);
  const std::vector<Vec3f> all{{0, 0, 0}, {0, 0, 0}, {1, 2, 3}, {4, 5, 6}, {10, 5, 6}, {4, 11, 6}};
  d.see({"al_R", "Pog", "M1", "M2", "M3", "M4"}, all);
  EXPECT_EQ(tissue().face_outline_mm, (std::vector<Vec3>{{4, 5, 6}, {10, 5, 6}, {4, 11, 6}}));
  EXPECT_EQ(tissue().face_mm, Vec3(6, 7, 6));
  d.outlined = false;
  EXPECT_TRUE(tissue().face_outline_mm.empty());
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
  const auto act = [&]<class C>(std::type_identity<C>, DeskHead::Ask what) {
    const auto c = asked(what);
    EXPECT_EQ(c.size(), 1u);
    return std::get<C>(std::get<HeadCommand>(c.at(0)));
  };
  const auto moved = [&] { return act(std::type_identity<MoveFragment>{}, DeskHead::Ask::shift); };
  EXPECT_EQ(moved().fragment.at_mm, at[2]);
  EXPECT_EQ(moved().fragment.id, -1);
  EXPECT_EQ(moved().by.translation_mm, Vec3(0, 8, -1.5));
  EXPECT_EQ(moved().by.rotation_deg, Vec3(0, 0, 12.25));
  const auto plate = act(std::type_identity<PlateFragments>{}, DeskHead::Ask::plate);
  EXPECT_EQ(plate.a_mm, at[1]);
  EXPECT_EQ(plate.b_mm, at[2]);
  EXPECT_EQ(act(std::type_identity<JoinFragments>{}, DeskHead::Ask::join).a.at_mm, at[1]);
  d.saw_radius_mm = 30;
  const auto plane = act(std::type_identity<CutBone>{}, DeskHead::Ask::saw_plane);
  EXPECT_EQ(plane.point_mm, Vec3(10, 10, 0));
  EXPECT_EQ(plane.normal, Vec3(0, 0, 1));
  EXPECT_EQ(plane.radius_mm, 30);
  EXPECT_TRUE(asked(DeskHead::Ask::saw_round).empty());  // a ring of four
  d.ring = 3;
  EXPECT_EQ(act(std::type_identity<CutBone>{}, DeskHead::Ask::saw_round).contour_mm, at);
  const auto snap = asked(DeskHead::Ask::snap);
  ASSERT_EQ(snap.size(), 2u);
  EXPECT_EQ(std::get<GrabFragment>(std::get<HeadCommand>(snap[0])).fragment.at_mm, at[2]);
  EXPECT_TRUE(std::get<LetGo>(std::get<HeadCommand>(snap[1])).snap);
  // As the panel shows them, to a hundredth.
  d.shift_mm = {-0.00012345f, -1.2345e-7f, 0.014999f}, d.turn_deg = {-1e6f, 1e6f, -123.456f};
  EXPECT_EQ(moved().by.translation_mm, Vec3(0, 0, 0.01));
  EXPECT_EQ(moved().by.rotation_deg, Vec3(-999.99, 999.99, -123.46));
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
    const auto p = std::get<PlateFragments>(std::get<HeadCommand>(c[0]));
    return {p.a_mm.x(), p.a_mm.y(), p.b_mm.x(), p.b_mm.y()};
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
  EXPECT_EQ(std::get<Superpose>(std::get<HeadCommand>(*c)).on, SkullBeside::mirror);
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
