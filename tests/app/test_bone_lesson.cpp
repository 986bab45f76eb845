// Lessons on bones: read strictly, and a judge that tells a right move from a wrong one.
#include <gtest/gtest.h>

#include <map>

#include "app/assembly/lesson.h"
#include "app/head/build.h"
#include "app/program/places.h"
#include "app/scene/scene.h"
#include "app/session/workers_pool.h"
#include "sim/base/error.h"
#include "tests/sim/commands/shipped_scripts.h"

namespace limberg {
namespace test_bone_lesson {

constexpr const char* kBoneLessons[] = {"le_fort_1",   "le_fort_3",    "sagittal_split",
                                        "genioplasty", "autorotation", "craniofacial"};

Lesson shipped_lesson(const std::string& name) { return open_lesson(source_dir() + "/app/lessons/" + name + ".toml"); }

/// The bones of a lesson's scene, without the face.
std::unique_ptr<Head> bones_of(const Lesson& l, Workers& w) {
  Scene scene = load_scene(source_dir() + "/app/scenes/" + l.scene + ".toml");
  scene.head->face = false, scene.head->tissues.clear(), scene.head->face_landmarks.clear();
  return std::make_unique<Head>(head_parts(scene, w), w);
}

std::vector<Command> shipped_acts(const std::string& name) { return test::shipped_commands(name); }

/// The lesson's tolerances after these acts, but for the bone outside a skin that is not there.
std::map<std::string, Judgement> judged(const Lesson& l, const std::vector<Command>& acts) {
  InlineWorkers w;
  const auto head = bones_of(l, w);
  for (const Command& c : acts)
    if (const auto* h = std::get_if<HeadCommand>(&c)) {
      const Outcome o = head->act(*h);
      EXPECT_TRUE(o.done) << o.reason << " " << to_json_line(c);
    }
  LessonValues v = bone_values(*l.bone, *head, BoneOutside{}, acts, l.words.limits);
  v.value["undos"] = 0, v.value["time_s"] = 60;
  std::map<std::string, Judgement> out;
  for (Judgement& j : judge(l, v)) out.emplace(j.name, j);
  return out;
}

bool all_met(const std::map<std::string, Judgement>& j) {
  return std::all_of(j.begin(), j.end(), [](const auto& x) { return x.second.met; });
}
std::string listed(const std::map<std::string, Judgement>& judged) {
  std::string s;
  for (const auto& [name, j] : judged)
    s += name + (j.met ? " met" : " MISSED") + " " + std::to_string(j.value.value_or(-1)) + " " + j.why + "\n";
  return s;
}

/// The acts with the move changed.
template <class Change>
std::vector<Command> moved_otherwise(std::vector<Command> acts, Change&& change) {
  for (Command& c : acts)
    if (auto* h = std::get_if<HeadCommand>(&c))
      if (auto* m = std::get_if<MoveFragment>(h)) change(*m);
  return acts;
}

TEST(BoneLesson, EachShippedScriptMeetsItsLesson) {
  for (const std::string name : kBoneLessons) {
    SCOPED_TRACE(name);
    const auto j = judged(shipped_lesson(name), shipped_acts(name));
    EXPECT_TRUE(all_met(j)) << listed(j);
    EXPECT_EQ(j.at("pieces_wrong").value, 0.);
    EXPECT_LT(j.at("piece_mm").value.value(), 0.2);  // places in tenths, and turns in thousandths
  }
}

TEST(BoneLesson, AMoveThatIsWrongIsSeen) {
  const Lesson l = shipped_lesson("le_fort_1");
  const std::vector<Command> right = shipped_acts("le_fort_1");
  // Too short by 3 mm.
  auto j = judged(l, moved_otherwise(right, [](MoveFragment& m) { m.by.translation_mm.y() -= 3; }));
  EXPECT_NEAR(j.at("piece_mm").value.value(), 3, 1e-9);
  EXPECT_NEAR(j.at("forwards_mm").value.value(), 3, 1e-9);
  EXPECT_NE(j.at("forwards_mm").why.find("too little"), std::string::npos) << j.at("forwards_mm").why;
  for (const char* n : {"piece_mm", "forwards_mm", "cephalometry_mm"}) EXPECT_FALSE(j.at(n).met) << n;
  for (const char* n : {"pieces_wrong", "piece_deg", "sideways_mm", "upwards_mm", "midline_mm", "stays_mm"})
    EXPECT_TRUE(j.at(n).met) << n << "\n" << listed(j);
  // The wrong way: to the left instead of forwards.
  j = judged(l, moved_otherwise(right, [](MoveFragment& m) { m.by.translation_mm = {-5, 0, 0}; }));
  EXPECT_NEAR(j.at("sideways_mm").value.value(), 5, 1e-9);
  EXPECT_NEAR(j.at("midline_mm").value.value(), 5, 0.1);
  EXPECT_NEAR(j.at("forwards_mm").value.value(), 5, 1e-9);
  // Backwards.
  j = judged(l, moved_otherwise(right, [](MoveFragment& m) { m.by.translation_mm.y() *= -1; }));
  EXPECT_NEAR(j.at("piece_mm").value.value(), 10, 1e-9);
  // Turned by 6 degrees about the way.
  j = judged(l, moved_otherwise(right, [](MoveFragment& m) { m.by.rotation_deg = {0, 6, 0}; }));
  EXPECT_NEAR(j.at("piece_deg").value.value(), 6, 1e-6);
  EXPECT_FALSE(j.at("piece_deg").met);
  // Lifted off its cut: the gap is the lift.
  j = judged(l, moved_otherwise(right, [](MoveFragment& m) { m.by.translation_mm.z() -= 4; }));
  EXPECT_NEAR(j.at("osteotomy_gap_mm").value.value(), 4, 0.2);
  EXPECT_FALSE(j.at("osteotomy_gap_mm").met);
  EXPECT_FALSE(j.at("upwards_mm").met);
  // Pressed into the skull.
  j = judged(l, moved_otherwise(right, [](MoveFragment& m) { m.by.translation_mm.z() += 1.8; }));
  EXPECT_NEAR(j.at("osteotomy_overlap_mm").value.value(), 1.8, 0.3);
  EXPECT_FALSE(j.at("osteotomy_overlap_mm").met);
  // Not moved at all.
  j = judged(l, moved_otherwise(right, [](MoveFragment& m) { m.by = {}; }));
  EXPECT_NEAR(j.at("piece_mm").value.value(), 5, 1e-9);
}

TEST(BoneLesson, AWrongPieceIsSeen) {
  const Lesson l = shipped_lesson("le_fort_1");
  // Nothing was cut: the maxilla lies on the skull still.
  auto j = judged(l, {});
  EXPECT_FALSE(j.at("pieces_wrong").met);
  EXPECT_NE(j.at("pieces_wrong").why.find("lies on the maxilla"), std::string::npos) << j.at("pieces_wrong").why;
  EXPECT_FALSE(j.at("osteotomy_gap_mm").met);  // there is no cut to measure
  // The midface instead of the maxilla: the rims of the orbits go along.
  const auto other = moved_otherwise(shipped_acts("le_fort_3"), [](MoveFragment& m) { m.by.translation_mm.y() = 5; });
  j = judged(l, other);
  EXPECT_FALSE(j.at("pieces_wrong").met);
  EXPECT_NE(j.at("pieces_wrong").why.find("Or_R lies on the maxilla"), std::string::npos) << j.at("pieces_wrong").why;
  EXPECT_NEAR(j.at("stays_mm").value.value(), 5, 1e-9);
  // Of a split: one side only.
  const Lesson split = shipped_lesson("sagittal_split");
  std::vector<Command> one_side = shipped_acts("sagittal_split");
  for (size_t i = 0, cuts = 0; i < one_side.size(); ++i)
    if (const auto* h = std::get_if<HeadCommand>(&one_side[i]))
      if (std::holds_alternative<CutBoneByBlade>(*h) && ++cuts == 2) {
        one_side.erase(one_side.begin() + std::ptrdiff_t(i));
        break;
      }
  j = judged(split, one_side);
  EXPECT_FALSE(j.at("pieces_wrong").met);
  EXPECT_EQ(j.at("pieces_wrong").value, 2.);  // Co_L, and a fragment too few
  EXPECT_NEAR(j.at("stays_mm").value.value(), 6, 1e-9);
}

TEST(BoneLesson, WhatIsSetAsideCannotBePlacedAnew) {
  const Lesson l = shipped_lesson("le_fort_1");
  std::vector<Command> acts = shipped_acts("le_fort_1");
  acts.push_back(HeadCommand(PlaceLandmark{"PNS", {0, 90, -40}, false}));
  const auto j = judged(l, acts);
  EXPECT_FALSE(all_met(j));
  EXPECT_NE(j.at("piece_mm").why.find("PNS"), std::string::npos) << j.at("piece_mm").why;
  EXPECT_FALSE(j.at("piece_mm").value.has_value());
}

TEST(BoneLesson, IsReadStrictly) {
  const std::string text = R"(lesson = "A maxilla"
goal = "Forwards."
scene = "prognathic"
steps = ["cut", "move"]
[bone]
fragments = 3
stays = ["N"]
[[bone.piece]]
name = "maxilla"
holds = ["A", "ANS", "PNS"]
apart_from = ["N"]
move_mm = [0, 5, 0]
turn_deg = [1, 0, 0]
[bone.cephalometry]
overjet = 2.3
[tolerance]
piece_mm = 2
)";
  const Lesson l = parse_lesson(text, "l.toml");
  EXPECT_FALSE(l.plan.has_value());
  ASSERT_TRUE(l.bone.has_value());
  ASSERT_EQ(l.bone->pieces.size(), 1u);
  EXPECT_EQ(l.bone->pieces[0].move.translation_mm, Vec3(0, 5, 0));
  EXPECT_EQ(l.bone->fragments, 3);
  EXPECT_EQ(l.steps.size(), 2u);
  ASSERT_EQ(l.tolerances.size(), 2u);
  EXPECT_EQ(l.tolerances[0], std::pair(std::string("pieces_wrong"), 0.));  // always judged
  const auto bad = [&](const std::string& from, const std::string& to, const std::string& word) {
    std::string s = text;
    const size_t at = s.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    s.replace(at, from.size(), to);
    try {
      parse_lesson(s, "l.toml");
      ADD_FAILURE() << "taken: " << to;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).find("l.toml"), 0u) << e.what();
    }
  };
  bad("overjet = 2.3", "overjest = 2.3", "unknown figure \"overjest\"");
  bad("move_mm = [0, 5, 0]", "move_mm = [0, 5]", "not three numbers");
  bad("move_mm = [0, 5, 0]", "way_mm = [0, 5, 0]", "way_mm");
  bad("holds = [\"A\", \"ANS\", \"PNS\"]", "holds = []", "names no landmark");
  bad("holds = [\"A\", \"ANS\", \"PNS\"]", "holds = [1]", "no text");
  bad("piece_mm = 2", "gap_mm = 2", "asked of skin");
  bad("fragments = 3", "fragments = 0", "fragments");
  // A lesson on skin asks nothing of bones.
  try {
    parse_lesson(
        "lesson = \"a\"\ngoal = \"b\"\nscene = \"rhomboid\"\n[procedure]\nname = \"rhomboid\"\n[tolerance]\n"
        "piece_mm = 2\n",
        "l.toml");
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("asked of bones"), std::string::npos) << e.what();
  }
  InlineWorkers w;
  EXPECT_EQ(plan_lacks(*l.bone, bones_of(l, w)->landmarks()), "");
  BonePlan unknown = *l.bone;
  unknown.stays.push_back("Nn"), unknown.cephalometry.emplace_back("nasolabial", 100);
  EXPECT_EQ(plan_lacks(unknown, bones_of(l, w)->landmarks()), "landmark Nn on bone, figure nasolabial");
}

}  // namespace test_bone_lesson
}  // namespace limberg
