// `limberg rooms`, with an emulated hand and its answers on standard input; and `run --room`.
#include <nlohmann/json.hpp>

#include "tests/app/cli.h"

namespace test_cli_rooms {

using nlohmann::json;

class RoomsCli : public Cli {
 protected:
  std::string hand(const std::string& more = "") { return file("hand.toml", "limberg_hand = 1\n" + more); }
  std::string rooms(const std::string& rest) const { return "rooms --folder " + path("rooms") + " " + rest; }
};

TEST_F(RoomsCli, IsSetUpSavedListedAndTried) {
  const Outcome none = run(rooms("--json " + path("none.json")));
  EXPECT_EQ(none.status, 0) << none.err;
  EXPECT_NE(none.out.find("none yet"), std::string::npos) << none.out;
  EXPECT_NE(none.out.find("mouse and keyboard"), std::string::npos);
  EXPECT_GE(json::parse(slurp(dir_ / "none.json"))["connected"].size(), 5u);

  const std::string set_up =
      rooms("\"OP 2\" --device emulated:" + hand("cone_deg = [10, 50]\n") + " --json " + path("r.json"));
  const Outcome o = run(set_up);
  EXPECT_EQ(o.status, 0) << o.out << o.err;
  EXPECT_NE(o.out.find("Not good: a cone of"), std::string::npos) << o.out;  // the first try
  const json r = json::parse(slurp(dir_ / "r.json"));
  ASSERT_EQ(r["rooms"].size(), 1u);
  for (const json& c : r["rooms"][0]["checks"]) EXPECT_TRUE(c["good"].get<bool>()) << c;
  for (const char* f : {"room.toml", "calibration.toml", "tip.lcm", "table.lcm", "hand.lcm"})
    EXPECT_TRUE(fs::exists(dir_ / "rooms/OP 2" / f)) << f;
  // What it kept of a step calibrates alike.
  ASSERT_EQ(run("calibrate stylus " + path("'rooms/OP 2/tip.lcm'") + " --out " + path("tip.toml")).status, 0);
  const auto tip_line = [](const std::string& text) { return text.substr(text.find("tip_offset_mm"), 60); };
  EXPECT_EQ(tip_line(slurp(dir_ / "tip.toml")), tip_line(slurp(dir_ / "rooms/OP 2/calibration.toml")));

  const Outcome listed = run(rooms(""));
  EXPECT_NE(listed.out.find("can be used: limberg run --room \"OP 2\""), std::string::npos) << listed.out;
  EXPECT_EQ(run(rooms("\"OP 2\"")).status, 0);
  EXPECT_EQ(run(rooms("\"OP 2\" --check")).status, 0);
  expect_refused(set_up, {"set up already", "--replace"});
  // The sheet has moved since: a check finds it, and changes nothing.
  const std::string before = slurp(dir_ / "rooms/OP 2/room.toml");
  hand("line_off_mm = 9\n");
  EXPECT_EQ(run(rooms("\"OP 2\" --check")).status, 3);
  EXPECT_EQ(slurp(dir_ / "rooms/OP 2/room.toml"), before);
  // What it needs is gone.
  fs::remove(dir_ / "hand.toml");
  const Outcome gone = run(rooms("\"OP 2\""));
  EXPECT_EQ(gone.status, 3);
  EXPECT_NE(gone.out.find("is not there"), std::string::npos) << gone.out;
}

TEST_F(RoomsCli, WhatIsNotGoodIsNotSaved) {
  const Outcome o = run(rooms("bad --device emulated:" + hand("cone_deg = 5\n")));
  EXPECT_EQ(o.status, 3);
  EXPECT_NE(o.out.find("nothing was saved"), std::string::npos) << o.out;
  EXPECT_FALSE(fs::exists(dir_ / "rooms/bad"));
  // A stroke that is off calibrates nothing: the room is saved, with its figure.
  const Outcome off = run(rooms("off --device emulated:" + hand("line_off_mm = 9\n")));
  EXPECT_EQ(off.status, 3) << off.err;
  EXPECT_NE(slurp(dir_ / "rooms/off/room.toml").find("beside the edge"), std::string::npos);
  EXPECT_NE(run(rooms("")).out.find("of its figures bad"), std::string::npos);

  expect_refused(rooms("nowhere"), {"there is no room \"nowhere\"", "--device"});
  expect_refused(rooms("a/b --device lcm"), {"no name of a room"});
  expect_refused(rooms("x --device emulated:" + path("none.toml")), {"none.toml"});
  expect_refused(rooms("x --device emulated:" + hand("lost = 7\n")), {"hand.toml:2", "lost"});
  expect_refused(rooms("x --device log:" + path("a.lcm")), {"no live device"});
  expect_refused(rooms("x --device fastrak:/dev/none,s --device emulated:" + hand()), {"beside others"});
  expect_refused(rooms("--device lcm"), {"without a name"});
}

TEST_F(RoomsCli, ARunHasItsDevicesAndCalibration) {
  ASSERT_EQ(run(rooms("emulated --device emulated:" + hand())).status, 0);
  expect_refused("run " + file("small.toml", small_scene()) + " --headless --room " + path("rooms/emulated"),
                 {"emulated hand", "operates on nobody"});
  expect_refused("run --headless --room nowhere", {"there is no room"});
  // The same with a device that is there: a FASTRAK on a pseudo-terminal.
  std::string room = slurp(dir_ / "rooms/emulated/room.toml");
  const size_t at = room.find("emulated:");
  room.replace(at, room.find('"', at) - at, "fastrak-emulator:fts");
  file("rooms/emulated/room.toml", room);
  const Outcome o = run("run " + path("small.toml") + " --headless --seconds 0.5 --room " + path("rooms/emulated") +
                        " --record " + path("r.lcm") + " --json " + path("r.json"));
  EXPECT_TRUE(o.status == 0 || o.status == 3) << o.err;
  EXPECT_EQ(json::parse(slurp(dir_ / "r.json"))["device"]["sources"][0]["device"], "fastrak-emulator:fts");
  const std::string calibration = slurp(dir_ / "rooms/emulated/calibration.toml");
  EXPECT_NE(slurp(dir_ / "r.lcm").find(calibration.substr(calibration.find("tip_offset_mm"), 60)), std::string::npos);
}

}  // namespace test_cli_rooms
