// Rooms: the file, and the talk with an emulated hand that does the steps well or badly.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/program/temporary_folder.h"
#include "app/room/connected.h"
#include "app/room/setup.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_room {

namespace fs = std::filesystem;

struct Talked {
  SetUpOutcome outcome;
  std::string words;
};
/// With these answers, a line each; then none comes any more.
Talked talked(const EmulatedHand& hand, const std::string& answers = "", bool check_only = false,
              const Calibration& from = {}) {
  std::istringstream in(answers);
  std::ostringstream out;
  const auto hands = emulated_hands(hand, "emulated:test");
  Talked t;
  t.outcome = set_up(*hands, {in, out, true}, from, check_only);
  t.words = out.str();
  return t;
}
const RoomCheck* check_of(const SetUpOutcome& o, const std::string& step, const std::string& what) {
  for (const RoomCheck& c : o.checks)
    if (c.step == step && c.what.find(what) != std::string::npos) return &c;
  return nullptr;
}

TEST(Room, AGoodHandSetsUpAllAndFindsTheTruth) {
  const Talked t = talked({});
  EXPECT_TRUE(t.outcome.usable) << t.words;
  EXPECT_TRUE(t.outcome.not_good.empty()) << t.words;
  // What the emulated room has (devices/rehearsal.h).
  const Calibration& c = t.outcome.calibration;
  EXPECT_LT((c.tip_offset_mm - Vec3(2, -3, 130)).norm(), 0.3);
  EXPECT_LT((c.world_from_tracker_mm - Vec3(-320, 60, 140)).norm(), 0.6);
  EXPECT_NEAR(c.glove.closed_mm, 18, 1);
  EXPECT_NEAR(c.glove.open_mm, 85, 1);
  for (const RoomCheck& k : t.outcome.checks) EXPECT_TRUE(k.good()) << in_words(k);
  const RoomCheck* noise = check_of(t.outcome, "rest", "stylus: noise");
  ASSERT_TRUE(noise);
  EXPECT_NEAR(noise->value, 0.2, 0.05);  // as the hand's file has it, an axis
  for (const char* step : {"rest", "tip", "table", "hand", "stroke", "reach", "grab"})
    EXPECT_TRUE(t.outcome.heard.contains(step)) << step;
}

struct Fault {
  const char *name, *step, *what, *advice;
  EmulatedHand hand;
};
EmulatedHand with(std::vector<double> EmulatedHand::*field, double bad) {
  EmulatedHand h;
  h.*field = {bad};
  return h;
}

TEST(Room, EachFaultIsFoundWhereItIs) {
  EmulatedHand noisy = with(&EmulatedHand::noise_mm, 2.0);
  const Fault faults[] = {
      {"noise", "rest", "noise of a reading", "trembles", noisy},
      {"losses", "rest", "missing", "readings are lost", with(&EmulatedHand::lost, 0.2)},
      {"narrow", "tip", "how far it was turned", "tilt the stylus further", with(&EmulatedHand::cone_deg, 12)},
      {"beside", "table", "residual of the corners", "residual", with(&EmulatedHand::touch_off_mm, 12)},
      {"too few", "table", "points touched", "4 touches were felt", with(&EmulatedHand::touches, 4)},
      {"too many", "table", "points touched", "6 touches were felt", with(&EmulatedHand::touches, 6)},
      {"half open", "hand", "between open and closed", "open", with(&EmulatedHand::open_mm, 30)},
      {"moved sheet", "stroke", "beside the edge", "did the sheet move", with(&EmulatedHand::line_off_mm, 8)},
      {"worn switch", "stroke", "times that it was pressed", "worn", with(&EmulatedHand::lets_go, 2)},
      {"lazy grab", "grab", "grabs that were felt", "not every grab", with(&EmulatedHand::grabs, 2)},
      {"one more", "grab", "grabs that nobody did", "more grabs", with(&EmulatedHand::grabs, 4)},
      {"short arm", "reach", "from left to right", "go as far as you will work", with(&EmulatedHand::reach_mm, 120)}};
  for (const Fault& f : faults) {
    const Talked t = talked(f.hand);
    const RoomCheck* c = check_of(t.outcome, f.step, f.what);
    ASSERT_TRUE(c) << f.name;
    EXPECT_FALSE(c->good()) << f.name << ": " << in_words(*c);
    EXPECT_NE(t.words.find(f.advice), std::string::npos) << f.name << ": " << f.advice;
    EXPECT_FALSE(t.outcome.not_good.empty()) << f.name;
    const bool calibrates = std::string("tip table hand").find(f.step) != std::string::npos;
    if (calibrates) {
      EXPECT_FALSE(t.outcome.usable) << f.name;
    }
  }
}

TEST(Room, ASecondTryMayBeGood) {
  EmulatedHand h;
  h.cone_deg = {10, 50}, h.touch_off_mm = {12, 0};
  const Talked t = talked(h);
  EXPECT_TRUE(t.outcome.usable);
  EXPECT_TRUE(t.outcome.not_good.empty());
  // Of the tries only the last one counts.
  for (const RoomCheck& k : t.outcome.checks) EXPECT_TRUE(k.good()) << in_words(k);
}

TEST(Room, APersonLeavesOutGoesBackAndQuits) {
  const Talked left = talked({}, "\ns\n");  // the tip
  EXPECT_FALSE(left.outcome.usable);
  ASSERT_EQ(left.outcome.not_good.size(), 3u) << left.words;  // and what hangs on it: the touches, the stroke
  EXPECT_EQ(left.outcome.not_good[0], "The tip of the stylus");
  EXPECT_FALSE(left.outcome.ended);

  const Talked back = talked({}, "\n\nb\n\n\n");
  size_t told = 0;
  for (size_t at = back.words.find("Step 2 of 7"); at != std::string::npos; at = back.words.find("Step 2 of 7", at + 1))
    ++told;
  EXPECT_EQ(told, 2u);
  EXPECT_TRUE(back.outcome.usable);

  const Talked quit = talked({}, "\nq\n");
  EXPECT_TRUE(quit.outcome.ended);
  EXPECT_FALSE(quit.outcome.usable);
  EXPECT_TRUE(quit.outcome.heard.contains("rest"));
  EXPECT_FALSE(quit.outcome.heard.contains("tip"));

  const Talked lost = talked({}, "what?\n\n");
  EXPECT_NE(lost.words.find("Enter goes on, s leaves the step out"), std::string::npos);
  EXPECT_TRUE(lost.outcome.usable);
}

TEST(Room, OnlyWhatTheDevicesHaveIsAsked) {
  EmulatedHand h;
  h.glove = false;
  Talked t = talked(h);
  EXPECT_EQ(t.words.find("A grab"), std::string::npos);
  EXPECT_NE(t.words.find("A stroke"), std::string::npos);
  EXPECT_TRUE(t.outcome.usable) << t.words;
  h.glove = true, h.stylus = false;
  t = talked(h);
  EXPECT_NE(t.words.find("A grab"), std::string::npos);
  EXPECT_EQ(t.words.find("A stroke"), std::string::npos);
  EXPECT_TRUE(t.outcome.usable) << t.words;
  // A check asks for no calibration, and judges by the one that is there.
  const Calibration good = talked({}).outcome.calibration;
  const Talked checked = talked({}, "", true, good);
  EXPECT_EQ(checked.words.find("The tip of the stylus"), std::string::npos);
  EXPECT_TRUE(checked.outcome.not_good.empty()) << checked.words;
  EXPECT_FALSE(talked({}, "", true, {}).outcome.not_good.empty());  // by none the stroke lies elsewhere
}

TEST(Room, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const std::string dir = (folder.path() / "OP 2").string();
  fs::create_directories(dir);
  Room r;
  r.name = "OP 2", r.date = "2026-11-28", r.devices = {"fastrak:/dev/tty\"USB0\\,fts", "lcm"};
  r.calibration = dir + "/calibration.toml";
  r.checks = {{"rest", "stylus: noise", "mm", 0.25, 0.9, true}, {"tip", "poses", "", 592, 200, false}};
  const std::string text = to_toml(r);
  const Room again = parse_room(text, "room.toml", dir);
  EXPECT_EQ(to_toml(again), text);
  EXPECT_EQ(again.devices, r.devices);
  EXPECT_EQ(again.calibration, r.calibration);
  ASSERT_EQ(again.checks.size(), 2u);
  EXPECT_FALSE(again.checks[1].at_most);
  EXPECT_TRUE(again.checks[1].good());
  std::ofstream(dir + "/room.toml") << text;
  EXPECT_EQ(open_room(folder.path().string(), "OP 2").devices, r.devices);
  EXPECT_EQ(open_room(dir).name, "OP 2");
  fs::create_directories(folder.path() / "broken");
  std::ofstream(folder.path() / "broken/room.toml") << "limberg_room = 7";
  std::vector<std::string> broken;
  EXPECT_EQ(rooms_in(folder.path().string(), broken).size(), 1u);
  ASSERT_EQ(broken.size(), 1u);
  EXPECT_NE(broken[0].find("room.toml:1"), std::string::npos) << broken[0];
  for (const char* bad : {"", "a/b", "..", ".x", "-x", "a\nb", "a\x01"}) EXPECT_THROW(check_room_name(bad), InputError);
  for (const char* wrong :
       {"", "limberg_room = 1", "limberg_room = 1\ndevices = []", "limberg_room = 1\ndevices = [3]",
        "limberg_room = 1\ndevices = [\"lcm\"]\nother = 1", "limberg_room = 1\ndevices = [\"lcm\"]\ncheck = 3"})
    EXPECT_THROW(parse_room(wrong, "r", ""), InputError) << wrong;
}

TEST(Room, AnEmulatedHandIsReadStrictly) {
  const EmulatedHand h = parse_emulated_hand("limberg_hand = 1\nseed = 7\nglove = false\ncone_deg = [10, 50]\n", "h");
  EXPECT_EQ(h.seed, 7u);
  EXPECT_FALSE(h.glove);
  EXPECT_EQ(h.cone_deg, (std::vector<double>{10, 50}));
  for (const char* wrong : {"", "limberg_hand = 1\nlost = 2", "limberg_hand = 1\ncones = 3",
                            "limberg_hand = 1\nstylus = false\nglove = false"})
    EXPECT_THROW(parse_emulated_hand(wrong, "h"), InputError) << wrong;
}

TEST(Room, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const std::string there = (folder.path() / "port").string();
  std::ofstream(there) << "x";
  EXPECT_EQ(missing_of("fastrak:" + there + ",fts"), "");
  EXPECT_NE(missing_of("fastrak:" + there + "2,fts").find("is not there"), std::string::npos);
  EXPECT_NE(missing_of("driver:" + there).find(there), std::string::npos);  // no driver
  EXPECT_NE(missing_of("spacemouse:" + there + "2").find("spacenavd"), std::string::npos);
  EXPECT_EQ(missing_of("lcm"), "");  // is heard or not
  EXPECT_THROW(missing_of("nothing:else"), InputError);
  bool headset = false;
  for (const ConnectedThing& t : connected_things()) {
    EXPECT_FALSE(t.can.empty()) << t.what;
    headset |= t.what == "headset";
  }
  EXPECT_TRUE(headset);
}

}  // namespace test_room
}  // namespace limberg
