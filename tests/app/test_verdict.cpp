// A patient with one thing wrong at a time: each is seen, named, placed, and bad where its limit says so.
#include <gtest/gtest.h>

#include <cmath>

#include "app/assembly/verdict.h"
#include "app/result/verdict_words.h"
#include "sim/body/block.h"
#include "sim/lattice/fem_assembly.h"

namespace limberg {
namespace test_verdict {

class Verdict : public ::testing::Test {
 protected:
  Verdict() {
    BlockSpec b;
    b.size_mm = {60, 60, 10};
    b.layers = {{"skin", 1.5, {}}, {"fat", 8.5, {}}};
    body = make_block(b);
    m.gape.rim_length_mm = 80;
    m.gape.gape_mm = m.wound_gape_mm = 0.4;
    m.gape.widest_mm = 1.2;
    m.scar_length_mm = 40;
    m.sutures.resize(2);
    m.sutures[0].id = 1, m.sutures[1].id = 2;
    m.sutures[0].force_N = m.sutures[1].force_N = 0.2;
  }
  std::vector<ResultVerdict> look() const {
    VerdictOf of;
    of.metrics = &m, of.body = &body, of.cell_mm = 3.5, of.wound_level = level, of.judged = judged, of.bone = bone,
    of.pace = pace;
    of.residual = residual;
    return verdict_of(of);
  }
  /// The light of the line whose name begins so; "" where there is none.
  static std::string light(const std::vector<ResultVerdict>& v, const std::string& what) {
    for (const ResultVerdict& l : v)
      if (l.what.starts_with(what)) return l.light;
    return "";
  }
  Body body;
  Metrics m;
  std::vector<Judgement> judged;
  std::optional<BoneOutside> bone;
  std::optional<Pace> pace;
  double residual = 1e-6;
  int level = 0;
};

TEST_F(Verdict, AClosedWoundWhoseEdgesAreApartBetweenStitchesNeedsMoreOfThem) {
  m.gape.gape_mm = 0.51, m.gape.gape_at_mm = Vec3(7, -3, 0);
  const auto v = look();
  EXPECT_FALSE(is_bad(v));
  EXPECT_EQ(light(v, kClosedWhole), "good");
  EXPECT_EQ(light(v, "edges apart between stitches"), "warn");
  m.gape.gape_mm = 0.5;
  EXPECT_EQ(light(look(), "edges apart between stitches"), "");
  m.gape.gape_mm = 0.51, m.gape.open_mm = 1;  // not closed at all: that is said, and nothing about stitches
  EXPECT_EQ(light(look(), "edges apart between stitches"), "");
}

TEST_F(Verdict, AWoundWhoseWholeEdgeIsClosedIsGoodAndOnlyThatIsClosed) {
  const auto v = look();
  EXPECT_FALSE(is_bad(v));
  EXPECT_EQ(light(v, kClosedWhole), "good");
  for (const ResultVerdict& l : v) EXPECT_EQ(l.light, "good") << l.what;
  // One stretch between stitches stands open; 95 % of the edge and every stitch are as before.
  m.gape.widest_mm = 4, m.gape.open_mm = 3, m.gape.widest_at_mm = Vec3(7, -3, 0);
  const auto open = look();
  EXPECT_TRUE(is_bad(open));
  EXPECT_EQ(light(open, kClosedWhole), "");
  EXPECT_EQ(light(open, "wound gape, widest"), "bad");
  EXPECT_EQ(light(open, "wound gape, 95 %"), "good");
  EXPECT_EQ(light(open, "edge of the wound that is open"), "bad");
  EXPECT_EQ(open[0].light, "bad") << "what is wrong comes first";
  EXPECT_EQ(open[0].place, "(7.0, -3.0) mm");
}

TEST_F(Verdict, EdgesThatMeetDoNotCloseAWoundThatShowsItsFat) {
  EXPECT_EQ(light(look(), kClosedWhole), "good");
  m.raw = {7.5, 1.8, Vec3(7, -3, 0)};
  EXPECT_EQ(light(look(), kClosedWhole), "");
  m.sutures.clear();  // a flap that a hook holds up shows it, and is no fault
  EXPECT_FALSE(is_bad(look()));
}

TEST_F(Verdict, AWoundWithoutAStitchIsToldAndNoFault) {
  m.sutures.clear();
  m.gape.widest_mm = 11, m.gape.gape_mm = 10, m.gape.open_mm = 70;
  const auto v = look();
  EXPECT_FALSE(is_bad(v));
  EXPECT_EQ(light(v, "open wound"), "told");
  EXPECT_EQ(light(v, kClosedWhole), "");
  // A lesson that asks for it makes it one.
  judged = {{"wound_gape_mm", "mm", 2, 10.0, "", false}};
  EXPECT_EQ(light(look(), "wound gape, 95 %"), "bad");
}

TEST_F(Verdict, EachFaultIsSeen) {
  const auto alone = [&](const std::string& what, const std::string& expected, auto&& fault) {
    const Metrics sound = m;
    fault();
    const auto v = look();
    EXPECT_EQ(light(v, what), expected) << what;
    EXPECT_EQ(is_bad(v), expected == "bad") << what;
    EXPECT_TRUE(v[0].what.starts_with(what)) << v[0].what;
    m = sound, bone.reset(), pace.reset(), residual = 1e-6;
  };
  alone("skin on its face", "bad", [&] { m.turned = {40, Vec3(1, 2, 0)}; });
  alone("skin on its face", "warn", [&] { m.turned = {8, Vec3(1, 2, 0)}; });
  level = 1;  // cells of half the size at the wound bend skin more sharply
  alone("skin on its face", "bad", [&] { m.turned = {4, Vec3(1, 2, 0)}; });
  level = 0;
  alone("raw tissue above the skin", "bad", [&] { m.raw = {4.1, 1.2, Vec3(1, 2, 0)}; });
  alone("raw tissue above the skin", "warn", [&] { m.raw = {1.1, 1.2, Vec3(1, 2, 0)}; });
  alone("edge of the wound that lies over", "bad", [&] { m.gape.over_mm = 3; });
  alone("edge of the wound that lies over", "warn", [&] { m.gape.over_mm = 1; });
  const double told_from_none_mm3 = kLeastFraction * std::pow(3.5, 3);  // of a cell
  alone("tissue inside out", "warn", [&] { m.inverted_cells = 1, m.inverted_mm3 = 0.9 * told_from_none_mm3; });
  alone("tissue inside out", "bad", [&] { m.inverted_cells = 1, m.inverted_mm3 = 1.1 * told_from_none_mm3; });
  alone("dog-ear", "bad", [&] { m.dog_ear_mm = 8.4; });
  alone("tissue in tissue", "bad", [&] { m.penetration.p99_mm = 1; });
  alone("stitches that hold nothing: both", "bad", [&] { m.one_bank = {2}; });
  alone("stitches that hold nothing: slack", "warn", [&] { m.slack = {1, 2}; });
  alone("largest force of a stitch", "bad", [&] { m.suture_force_max_N = 6.4, m.suture_force_max_id = 2; });
  alone("largest force of a stitch", "warn", [&] { m.suture_force_max_N = 3; });
  alone("closure force", "bad", [&] { m.closure_force_N = 16; });
  alone("bites of a stitch apart", "bad", [&] { m.suture_gap_max_mm = 0.3; });
  alone("skin stretched beyond", "warn", [&] { m.beyond_law_mm2 = 3; });
  alone("bone outside the skin", "bad", [&] { bone = BoneOutside{1.5, 20, Vec3(1, 2, 3), 2}; });
  alone("patient behind the hand", "bad", [&] { pace = Pace{5000, 0, 400, 900}; });
  alone("patient behind the hand", "warn", [&] { pace = Pace{5000, 0, 100, 900}; });
  alone("solver steps skipped", "warn", [&] { pace = Pace{3400, 1664, 40, 90}; });
  alone("time added by slow motion", "warn", [&] { pace = Pace{3400, 0, 40, 90, SlowedPace{60, 0.7, 0.43}}; });
  alone("not at rest", "bad", [&] { residual = 1e-3; });
  alone("not at rest", "bad", [&] { residual = std::nan(""); });
}

TEST_F(Verdict, SlowMotionIsToldByTheTimeThatItAdded) {
  pace = Pace{3400, 0, 40, 90};
  EXPECT_EQ(light(look(), "time added"), "") << "a session in real time has none";
  pace->slowed = SlowedPace{60, 0.59, 0.43};
  EXPECT_EQ(light(look(), "time added"), "good");
  pace->slowed = SlowedPace{60, 0.61, 0.43};
  const auto v = look();
  EXPECT_EQ(light(v, "time added"), "warn");
  EXPECT_EQ(v[0].unit, "s");
  EXPECT_EQ(v[0].value, 0.61);
  EXPECT_EQ(v[0].place, "slowest second: 0.43 of real time");
}

TEST_F(Verdict, ALessonsOwnToleranceWinsAndWhatElseItAsksIsALine) {
  m.dog_ear_mm = 5;
  judged = {{"dog_ear_mm", "mm", 6, 5.0, "", true},
            {"corner_mm", "mm", 2, std::nullopt, "nothing was drawn", false},
            {"undos", "", 3, 1.0, "", true}};
  const auto v = look();
  EXPECT_EQ(light(v, "dog-ear"), "good");
  EXPECT_EQ(light(v, "lesson: dog_ear_mm"), "") << "one line for each thing";
  EXPECT_EQ(light(v, "lesson: corner_mm"), "bad");
  EXPECT_EQ(light(v, "lesson: undos"), "good");
  EXPECT_EQ(in_words(v[0]), "lesson: corner_mm: not measured, nothing was drawn; at most 2 mm");
}

TEST_F(Verdict, BadComesBeforeWhatIsWorthALookBeforeWhatIsGood) {
  m.slack = {1}, m.inverted_mm3 = 2, m.dog_ear_mm = 9;
  const auto v = look();
  const auto rank = [](const std::string& l) { return l == "bad" ? 0 : l == "warn" ? 1 : l == "told" ? 2 : 3; };
  for (size_t i = 1; i < v.size(); ++i) EXPECT_LE(rank(v[i - 1].light), rank(v[i].light));
  for (const ResultVerdict& l : v) {
    EXPECT_FALSE(l.what.empty());
    EXPECT_TRUE(l.light == "good" || !l.source.empty()) << l.what << ": a limit has a source";
  }
}

}  // namespace test_verdict
}  // namespace limberg
