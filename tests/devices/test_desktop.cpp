// SpaceMouse and mouse: bytes to poses, and a daemon that is made of a socket here.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <cstring>

#include "devices/desktop_source.h"
#include "tests/devices/samples.h"
#include "tests/devices/temporary.h"

namespace limberg {
namespace test_desktop {

int64_t monotonic_ns() {
  timespec ts;
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return int64_t(ts.tv_sec) * 1'000'000'000 + ts.tv_nsec;
}

void send(DesktopDecoder& d, std::array<int32_t, 8> v, size_t piece = 32) {
  uint8_t b[32];
  std::memcpy(b, v.data(), 32);
  for (size_t at = 0; at < 32; at += piece) d.feed(b + at, std::min(piece, 32 - at));
}

TEST(Desktop, ASpaceMouseMovesWhilePushed) {
  DesktopDecoder d{DesktopSettings{}};
  send(d, {0, 350, 0, 0, 0, 0, 0, 8}, 5);
  for (int i = 0; i < 100; ++i) d.advance(0.01);
  EXPECT_NEAR(d.pose().tip_mm.x(), 120, 1e-6);
  send(d, {0, 0, 35, 0, 0, 0, 0, 8});  // a tenth of the push: a hundredth of the speed; its y is up
  for (int i = 0; i < 100; ++i) d.advance(0.01);
  EXPECT_NEAR(d.pose().tip_mm.x(), 120, 1e-6);
  EXPECT_NEAR(d.pose().tip_mm.z(), 1.2, 1e-6);
  send(d, {0, 0, 0, 0, 0, 350, 0, 8});
  d.advance(0.5);
  EXPECT_NEAR(2 * std::acos(d.pose().quat[0]), 1.0, 1e-9);
  send(d, {1, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(d.pose().buttons, 1u);
  send(d, {1, 1, 0, 0, 0, 0, 0, 0});
  send(d, {2, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(d.pose().buttons, 2u);
  send(d, {77, 0, 0, 0, 0, 0, 0, 0});
  send(d, {0, 1 << 30, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(d.malformed(), 2);
  d.let_go();
  const Vec3 there = d.pose().tip_mm;
  d.advance(1);
  EXPECT_EQ(d.pose().tip_mm, there);
  EXPECT_EQ(d.pose().buttons, 0u);
}

TEST(Desktop, AMouseMovesByItsCounts) {
  DesktopSettings set;
  set.kind = DesktopSettings::mouse;
  DesktopDecoder d(set);
  const uint8_t packets[] = {8, 10, 5, 0x28 | 1, 0, uint8_t(-4), 0x18, uint8_t(-20), 0};
  d.feed(packets, sizeof packets);
  EXPECT_NEAR(d.pose().tip_mm.x(), -1.0, 1e-12);
  EXPECT_NEAR(d.pose().tip_mm.y(), 0.1, 1e-12);
  EXPECT_EQ(d.pose().buttons, 0u);
  const uint8_t stray[] = {0, 0, 9, 1, 0};
  d.feed(stray, sizeof stray);
  EXPECT_EQ(d.malformed(), 2);
  EXPECT_EQ(d.pose().buttons, 1u);
}

TEST(Desktop, RandomBytesKeepThePoseInItsBox) {
  test::Dice dice{5};
  for (const auto kind : {DesktopSettings::space_mouse, DesktopSettings::mouse}) {
    DesktopSettings set;
    set.kind = kind;
    DesktopDecoder d(set);
    for (int i = 0; i < 200'000; ++i) {
      const auto b = uint8_t(dice.below(3) ? 0 : dice.next());
      d.feed(&b, 1);
      if (i % 64 == 0) d.advance(0.01);
      ASSERT_LE(d.pose().tip_mm.cwiseAbs().maxCoeff(), 150);
    }
  }
}

struct Count final : SampleSink {
  void on_sample(const Sample& s) override { last = std::get<StylusSample>(s), ++n; }
  StylusSample last;
  int n = 0;
};

TEST(Desktop, TheDaemonMayComeAndGo) {
  test::TemporaryFolder dir;
  DesktopSettings set;
  set.path = dir / "spnav.sock";
  const int64_t start = monotonic_ns();
  DesktopSource source(set, start);
  Count c;
  const auto wait = [&](auto&& until) {
    for (const int64_t end = monotonic_ns() + 15'000'000'000; monotonic_ns() < end && !until();) {
      source.poll(monotonic_ns() - start, c);
      const timespec pause{0, 5'000'000};
      nanosleep(&pause, nullptr);
    }
    return until();
  };
  ASSERT_TRUE(wait([&] { return source.health().find("No such file") != std::string::npos; })) << source.health();
  sockaddr_un a{};
  a.sun_family = AF_UNIX;
  std::strncpy(a.sun_path, set.path.c_str(), sizeof a.sun_path - 1);
  const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&a), sizeof a), 0);
  ASSERT_EQ(listen(listener, 1), 0);
  const int client = accept(listener, nullptr, nullptr);
  ASSERT_GE(client, 0);
  const int32_t push[8] = {0, 0, 0, -350, 0, 0, 0, 8}, press[8] = {1, 0, 0, 0, 0, 0, 0, 0};
  ASSERT_EQ(write(client, push, sizeof push), 32);
  ASSERT_EQ(write(client, press, sizeof press), 32);
  EXPECT_TRUE(wait([&] { return c.n > 10 && c.last.buttons == 1 && c.last.tip_mm.y() > 1; }));
  close(client);
  EXPECT_TRUE(wait([&] { return c.last.buttons == 0; }));
  close(listener);
}

}  // namespace test_desktop
}  // namespace limberg
