// Drivers that are loaded: what is refused and with which words, and the one that is shipped, against a board on a
// pseudo-terminal. Behaviour, never times.
#include <gtest/gtest.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "app/program/places.h"
#include "devices/driver/driver_port.h"
#include "devices/force/waited_source.h"
#include "sim/base/error.h"
#include "tests/devices/flat_patient.h"
#include "tests/devices/haply_board.h"

namespace limberg {
namespace test_driver {

using namespace test;

std::string driver(const std::string& name) { return binary_dir() + "/drivers/" + name + ".so"; }

/// What it says when it is refused, or "" where it is not.
template <class F>
std::string refusal(F&& f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}
void expect_words(const std::string& said, std::initializer_list<const char*> words) {
  for (const char* w : words) EXPECT_NE(said.find(w), std::string::npos) << "no \"" << w << "\" in: " << said;
  EXPECT_EQ(said.find('\n'), std::string::npos) << said;
}

TEST(Driver, WhatIsNoneIsRefusedInWords) {
  const std::string text = testing::TempDir() + "limberg-no-driver-" + std::to_string(getpid()) + ".so";
  std::ofstream(text) << "not a library";
  expect_words(refusal([] { load_driver("/no/such/driver.so"); }), {"no such file", "limberg_driver.h"});
  expect_words(refusal([] { load_driver(""); }), {"no such file"});
  expect_words(refusal([] { load_driver("/tmp"); }), {"no such file"});
  expect_words(refusal([&] { load_driver(text); }), {"cannot be loaded", "expected a shared library"});
  expect_words(refusal([] { load_driver(binary_dir() + "/parts/limberg-lcm.so"); }),
               {"no driver", "limberg_driver_abi"});
  expect_words(refusal([] { load_driver(driver("odd-abi")); }), {"version 7", "expected version 1"});
  expect_words(refusal([] { load_driver(driver("odd-without-read")); }), {"limberg_driver_read_pose", "expected"});
  unlink(text.c_str());
}

TEST(Driver, DevicesThatCannotBeAreRefusedInWords) {
  const DriverFunctions odd = load_driver(driver("odd"));
  expect_words(refusal([&] { DriverPort(odd, "absent", 1); }), {"no such device", "cannot be had"});
  expect_words(refusal([&] { DriverPort(odd, "silent", 1); }), {"no reason given"});
  expect_words(refusal([&] { DriverPort(odd, "strong", 1); }), {"peak force up to 100 N"});
  expect_words(refusal([&] { DriverPort(odd, "forceful", 1); }), {"limberg_driver_write_force"});
  const DriverFunctions haply = load_driver(driver("haply-2diy"));
  expect_words(refusal([&] { DriverPort(haply, "", 1); }), {"no port"});
  expect_words(refusal([&] { DriverPort(haply, "/no/such/port", 1); }), {"No such file"});
  expect_words(refusal([&] { DriverPort(haply, "/dev/null", 1); }), {"not a serial port"});
  expect_words(refusal([&] { DriverPort(haply, "/dev/null,levl=3", 1); }), {"levl=3", "expected level="});
  expect_words(refusal([&] { DriverPort(haply, "/dev/null,links=1/2", 1); }), {"links="});
}

TEST(Driver, PosesThatAreNoneAreCounted) {
  const DriverFunctions odd = load_driver(driver("odd"));
  PortReading r;
  for (const char* how : {"mad", "twisted"}) {
    DriverPort port(odd, how, 4);
    EXPECT_FALSE(port.read(1, r));
    EXPECT_FALSE(port.read(1, r));
    EXPECT_EQ(port.malformed(), 2) << how;
  }
  DriverPort mute(odd, "mute", 4);
  EXPECT_FALSE(mute.read(1, r));
  EXPECT_EQ(mute.malformed(), 0);
  DriverPort good(odd, "", 4);
  ASSERT_TRUE(good.read(1, r));
  EXPECT_EQ(r.pose.tip_mm.z(), 1);
  EXPECT_EQ(r.device_id, 4);
  good.answer(r, true, ForceState{}, 0);  // it gives none, and has no function for it
  EXPECT_NE(good.says().find("gives no force"), std::string::npos);
  // A late device holds less: (0.0005 + 0.001) N s/mm / (0.5 + 5) ms.
  const ForceLimits late = DriverPort(odd, "late", 4).limits();
  EXPECT_NEAR(late.delay_s, 0.005, 1e-12);
  EXPECT_NEAR(late.stiffness_N_mm, 0.0015 / 0.0055, 1e-12);
  DriverPort leaves(odd, "leaves", 4);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(leaves.read(1, r));
  EXPECT_FALSE(leaves.read(1, r));
  EXPECT_NE(leaves.says().find("gone, unplugged 1"), std::string::npos) << leaves.says();
  bool back = false;  // opened again after a second
  for (int i = 0; i < 3000 && !back; ++i) back = leaves.read(1, r);
  EXPECT_TRUE(back);
}

SimulatedHand standing(const Vec3& at) {
  SimulatedHand h;
  h.stiffness_N_mm = 50, h.damping_N_s_mm = 0.2, h.encoder_mm = 0;  // hardly moves
  h.target = [at](double) { return at; };
  return h;
}

// The board knows the inverse of what the driver computes: places and forces must come out the same.
TEST(Haply, PlacesAndForcesAreThoseOfTheLinkage) {
  const DriverFunctions haply = load_driver(driver("haply-2diy"));
  for (const Vec3& at : {Vec3(0, 0, 0), Vec3(25, 0, -12), Vec3(-30, 0, 8)}) {
    HaplyBoard board(standing(at));
    if (board.path.empty()) GTEST_SKIP() << "no pseudo-terminal";
    DriverPort port(haply, board.path, 1);
    PortReading r;
    ForceState felt;
    felt.force_N = Vec3(0.4, 0.7, -0.9);
    int answers = 0;
    for (int i = 0; i < 3000 && answers < 40; ++i) {
      answers += port.read(20, r);
      port.answer(r, true, felt, 0);
    }
    ASSERT_GE(answers, 40);
    EXPECT_EQ(board.setups, 1);
    EXPECT_EQ(board.setup(), (std::array<float, 4>{180, 13'824, 360, 13'824}));
    EXPECT_NEAR(r.pose.tip_mm.x(), at.x(), 0.1);  // the hand gives way by 0.9 N / 50 N/mm, an encoder's step is 0.03 mm
    EXPECT_NEAR(r.pose.tip_mm.y(), 0, 1e-12);
    EXPECT_NEAR(r.pose.tip_mm.z(), at.z(), 0.1);
    EXPECT_NEAR(board.felt_N().x(), 0.4, 0.01);
    EXPECT_NEAR(board.felt_N().z(), -0.9, 0.01);
    // A second program may not have the line.
    expect_words(refusal([&] { DriverPort(haply, board.path, 2); }), {"another program"});
  }
}

TEST(Haply, ADamagedLineMovesNoHandFar) {
  HaplyBoard board(standing(Vec3(10, 0, 5)));
  if (board.path.empty()) GTEST_SKIP() << "no pseudo-terminal";
  board.noise = 0.02;  // one byte in fifty: one answer in six
  DriverPort port(load_driver(driver("haply-2diy")), board.path, 1);
  PortReading r;
  int answers = 0;
  double farthest = 0;
  for (int i = 0; i < 3000 && answers < 300; ++i) {
    if (port.read(5, r)) ++answers, farthest = std::max(farthest, (r.pose.tip_mm - Vec3(10, 0, 5)).norm());
    port.answer(r, true, ForceState{}, 0);
  }
  EXPECT_GE(answers, 200);
  EXPECT_LT(farthest, 60) << "of a protocol without a checksum some damage gets through, within a hand's reach";
  board.unplug();
  for (int i = 0; i < 200 && port.says().find("gone") == std::string::npos; ++i) port.read(1, r);
  EXPECT_NE(port.says().find("gone"), std::string::npos);
}

// The whole way: a hand presses the device down onto skin, which holds it up. What it pays is what it gets.
TEST(Haply, AHandThatPressesIsHeldUp) {
  SimulatedHand hand;
  hand.encoder_mm = 0;
  hand.target = [](double t) { return Vec3(6 * std::sin(2 * t), 0, 8 - 14 * std::min(1.0, t)); };
  HaplyBoard board(hand);
  if (board.path.empty()) GTEST_SKIP() << "no pseudo-terminal";
  const int64_t start = monotonic_ns();
  ForceSourceSettings s;
  s.young_kPa = 200;
  WaitedForceSource source(std::make_unique<DriverPort>(load_driver(driver("haply-2diy")), board.path, 1), start, s);
  Snapshot skin = snapshot_of(flat_topology(12, 1));
  Samples samples;
  int64_t step = -1;
  std::vector<int64_t> depth_um;  // once the hand presses
  for (int64_t now = 0; now < 2'500'000'000; now = monotonic_ns() - start) {
    if (now > 1'500'000'000) depth_um.push_back(board.depth_um);
    if (now / 16'000'000 != step) step = now / 16'000'000, ++skin.step;
    source.look(skin), source.hold(ToolState{}), source.poll(now, samples);
    const timespec pause{0, 1'000'000};
    nanosleep(&pause, nullptr);
  }
  EXPECT_GT(samples.all.size(), 300u);
  EXPECT_GT(board.torques, 300);
  // Its middle: where this machine does other work for a moment the force is taken back, and the hand goes deeper.
  ASSERT_FALSE(depth_um.empty());
  std::nth_element(depth_um.begin(), depth_um.begin() + ptrdiff_t(depth_um.size() / 2), depth_um.end());
  const double depth_mm = double(depth_um[depth_um.size() / 2]) * 1e-3;
  std::printf("%zu readings, %lld torques, %.2f mm deep, least energy %.3f mJ; %s\n", samples.all.size(),
              (long long)board.torques, depth_mm, double(board.least_uJ) * 1e-3, source.health().c_str());
  // The hand wants to be 6 mm below the skin: 0.3 N/mm of its own against k.
  const double k = 2 * 200 / (1 - 0.45 * 0.45) * 1e-3, coupled = k * 0.7 / (k + 0.7);
  EXPECT_GT(depth_mm, 0.5 * 6 * 0.3 / (0.3 + coupled));
  EXPECT_LT(depth_mm, 5.2);
  EXPECT_GT(board.felt_N().z(), 0.2);
}

}  // namespace test_driver
}  // namespace limberg
