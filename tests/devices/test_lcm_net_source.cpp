// The live source. The network part runs where multicast works on this machine, on a port of its own.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <time.h>

#include <lcm/lcm-cpp.hpp>

#include "devices/lcm_local_link.h"
#include "devices/lcm_net_source.h"
#include "devices/lcm_publisher.h"
#include "devices/message_codec.h"
#include "sim/base/error.h"
#include "tests/devices/samples.h"
#include "tests/own_port.h"

namespace limberg {
namespace test_lcm_net_source {

using namespace test;

struct Kept final : SampleSink {
  void on_sample(const Sample& s) override { all.push_back(s); }
  std::vector<Sample> all;
};

int64_t monotonic_ns() {
  timespec ts;
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return int64_t(ts.tv_sec) * 1'000'000'000 + ts.tv_nsec;
}

TEST(LcmNetSource, OtherNetworksAreRefusedUnlessAsked) {
  for (const char* url : {"udpm://239.255.76.67:7667?ttl=1", "udpm://239.255.76.67:7667", "udpm://10.0.0.1:7667?ttl=0",
                          "tcpq://somewhere:7700", "udpm://239.255.76.67:7667?ttl=0&ttl=3", "file:///etc/passwd", ""}) {
    LcmNetSettings s;
    s.url = url;
    EXPECT_THROW(LcmNetSource(s, 0), InputError) << url;
  }
}

TEST(LcmNetSource, AnAddressThatCannotBeOpenedSaysWhatHelps) {
  LcmNetSettings s;
  s.url = "nonsense://";
  s.allow_other_networks = true;
  try {
    LcmNetSource source(s, 0);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("ip route"), std::string::npos);
  }
}

TEST(LcmNetSource, OnlyThisMachinesAddressesAreItsOwn) {
  std::unique_ptr<LcmLocalLink> link;
  try {
    link = std::make_unique<LcmLocalLink>("udpm://239.255.76.67:7689?ttl=0");
  } catch (const InputError&) {
    GTEST_SKIP() << "no multicast on this machine";
  }
  in_addr a{};
  for (const auto& [text, own] : {std::pair{"127.0.0.1", true},
                                  {"127.3.2.1", true},
                                  {"192.0.2.77", false},
                                  {"203.0.113.5", false},
                                  {"239.255.76.67", false},
                                  {"0.0.0.0", false}}) {
    ASSERT_EQ(inet_pton(AF_INET, text, &a), 1);
    EXPECT_EQ(link->is_own(a), own) << text;
  }
  EXPECT_THROW(LcmLocalLink("udpm://192.0.2.1:7667?ttl=0"), InputError);
  EXPECT_THROW(LcmLocalLink("udpm://239.255.76.67:0?ttl=0"), InputError);
  EXPECT_THROW(LcmLocalLink("udpm://239.255.76.67:70000?ttl=0"), InputError);
}

TEST(LcmPublisher, WhatIsSentHereIsHeardHere) {
  EXPECT_THROW(LcmPublisher("udpm://239.255.76.67:7667?ttl=1", false), InputError);
  LcmNetSettings settings;
  settings.url = udpm_here(free_udp_port());
  std::unique_ptr<LcmPublisher> publisher;
  std::unique_ptr<LcmNetSource> source;
  const int64_t start = monotonic_ns();
  try {
    publisher = std::make_unique<LcmPublisher>(settings.url, false);
    source = std::make_unique<LcmNetSource>(settings, start);
  } catch (const InputError&) {
    GTEST_SKIP() << "no multicast on this machine";
  }
  TrackerSample t;
  t.role = StationRole::thumb, t.station = 2, t.pos_mm = Vec3(1, 2, 3);
  ControlSample c;
  c.kind = ControlSample::undo;
  Kept kept;
  for (const Sample& s : {Sample(stylus(0, 5, Vec3(7, 8, 9))), Sample(t), Sample(c)})
    EXPECT_TRUE(publisher->publish(s));
  EXPECT_FALSE(publisher->publish(RawSample{}));
  for (int i = 0; i < 2000 && kept.all.size() < 3; ++i) {
    source->poll(monotonic_ns() - start, kept);
    const timespec pause{0, 1'000'000};
    nanosleep(&pause, nullptr);
  }
  if (kept.all.empty()) GTEST_SKIP() << "multicast packets do not come back on this machine";
  ASSERT_EQ(kept.all.size(), 3u);
  EXPECT_EQ(std::get<StylusSample>(kept.all[0]).tip_mm, Vec3(7, 8, 9));
  EXPECT_EQ(std::get<TrackerSample>(kept.all[1]).pos_mm, Vec3(1, 2, 3));
  EXPECT_EQ(std::get<ControlSample>(kept.all[2]).kind, ControlSample::undo);
  EXPECT_EQ(source->counts().malformed, 0);
}

TEST(LcmNetSource, PacketsAreReadToTheirEndsAndNoFurther) {
  std::vector<uint8_t> packet = {'L', 'C', '0', '2', 0, 0, 0, 7, 'A', 'B', 0, 1, 2, 3};
  std::string_view channel;
  const uint8_t* data = nullptr;
  size_t n = 0;
  ASSERT_TRUE(LcmLocalLink::parse(packet.data(), packet.size(), channel, data, n));
  EXPECT_EQ(channel, "AB");
  ASSERT_EQ(n, 3u);
  EXPECT_EQ(data[2], 3);
  for (size_t cut = 0; cut < 11; ++cut)
    EXPECT_FALSE(LcmLocalLink::parse(std::vector<uint8_t>(packet.begin(), packet.begin() + long(cut)).data(), cut,
                                     channel, data, n))
        << cut;
  ASSERT_TRUE(LcmLocalLink::parse(packet.data(), 11, channel, data, n));
  EXPECT_EQ(n, 0u);
  packet[3] = '3';
  EXPECT_FALSE(LcmLocalLink::parse(packet.data(), packet.size(), channel, data, n));
  std::vector<uint8_t> endless(200, 'x');
  std::copy_n("LC02", 4, endless.begin());
  EXPECT_FALSE(LcmLocalLink::parse(endless.data(), endless.size(), channel, data, n));
}

TEST(LcmNetSource, StartsAndStopsWithoutTraffic) {
  LcmNetSettings s;
  s.url = "memq://";
  Kept kept;
  for (int i = 0; i < 3; ++i) {
    LcmNetSource source(s, monotonic_ns());
    source.poll(1'000'000'000, kept);
    EXPECT_FALSE(source.done());
  }
  EXPECT_TRUE(kept.all.empty());
}

// In slow motion a stamp is of the session's time, and silence is the wall's: a sender that was silent for 400 ms, a
// fifth of it in the session, begins anew.
TEST(LcmNetSource, StampsBySessionTimeAndMeasuresSilenceByTheWall) {
  LcmNetSettings settings;
  settings.url = udpm_here(free_udp_port());
  lcm::LCM sender(settings.url);
  if (!sender.good()) GTEST_SKIP() << "no multicast on this machine";
  const int64_t start = monotonic_ns();
  const auto slowed = std::make_shared<SlowedTime>();
  slowed->bend(0, 200, SlowedTime::kNever);
  const SourceTime time(start, slowed);
  LcmNetSource source(settings, time);
  Kept kept;
  MessageBytes bytes;
  const auto arrives = [&](int64_t seq, size_t count) {
    const size_t n = encode_message(to_message(stylus(seq, 123, Vec3(1, 0, 0))), bytes);
    sender.publish(std::string(kStylusChannel), bytes.data(), unsigned(n));
    for (int i = 0; i < 2000 && kept.all.size() < count; ++i) {
      source.poll(time.stamp_ns(time.wall_ns(monotonic_ns())), kept);
      const timespec pause{0, 1'000'000};
      nanosleep(&pause, nullptr);
    }
    return kept.all.size() == count;
  };
  if (!arrives(100, 1)) GTEST_SKIP() << "multicast packets do not come back on this machine";
  const timespec silence{0, 400'000'000};
  nanosleep(&silence, nullptr);
  const int64_t before = monotonic_ns() - start;
  EXPECT_TRUE(arrives(0, 2)) << "as a sender that has begun anew";
  const int64_t after = monotonic_ns() - start, t_ns = time_of(kept.all.back());
  EXPECT_GE(t_ns, before / 5);
  EXPECT_LE(t_ns, after / 5 + 1);
  EXPECT_LT(after - before, 1'500'000'000)
      << "a stamp of the wall's would be handed over when the session has come there";
}

TEST(LcmNetSource, GoodPacketsArriveAndBadOnesAreCounted) {
  LcmNetSettings settings;
  settings.url = udpm_here(free_udp_port());
  lcm::LCM sender(settings.url);
  if (!sender.good()) GTEST_SKIP() << "no multicast on this machine";
  const int64_t start = monotonic_ns();
  LcmNetSource source(settings, start);
  Kept kept;
  MessageBytes bytes;
  auto send = [&](std::string_view channel, size_t n) {
    sender.publish(std::string(channel), bytes.data(), unsigned(n));
  };
  auto wait_for = [&](auto ready) {
    for (int i = 0; i < 2000 && !ready(); ++i) {
      source.poll(monotonic_ns() - start, kept);
      const timespec pause{0, 1'000'000};
      nanosleep(&pause, nullptr);
    }
    return ready();
  };
  for (int i = 0; i < 20; ++i)
    send(kStylusChannel, encode_message(to_message(stylus(i, 123, Vec3(i, 0, 0), i % 2)), bytes));
  if (!wait_for([&] { return kept.all.size() >= 20; }))
    GTEST_SKIP() << "multicast packets do not come back on this machine";

  Dice dice{1};
  const size_t n = encode_message(to_message(stylus(50, 0, Vec3(0, 0, 0))), bytes);
  for (size_t cut : {size_t(0), size_t(1), size_t(7), size_t(8), n - 1, n + 1, size_t(5000)}) send(kStylusChannel, cut);
  for (int k = 0; k < 20; ++k) {
    encode_message(to_message(stylus(60 + k, 0, Vec3(0, 0, 0))), bytes);
    bytes[dice.below(n)] ^= uint8_t(1u << dice.below(8));
    send(kStylusChannel, n);
  }
  StylusSample bad = stylus(100, 0, Vec3(std::nan(""), 0, 0));
  send(kStylusChannel, encode_message(to_message(bad), bytes));
  send(kStylusChannel, encode_message(to_message(stylus(3, 0, Vec3(0, 0, 0))), bytes));  // old
  EXPECT_TRUE(wait_for([&] { return source.counts().malformed >= 29; }));
  EXPECT_EQ(kept.all.size(), 20u);

  ControlSample control;
  control.kind = ControlSample::stage;
  control.text = ShortText("defect");
  send(kControlChannel, encode_message(to_message(control), bytes));
  send(kStylusChannel, encode_message(to_message(stylus(22, 0, Vec3(1, 2, 3))), bytes));
  EXPECT_TRUE(wait_for([&] { return kept.all.size() >= 22; }));
  EXPECT_EQ(source.counts().lost, 2);  // numbers 20 and 21
  EXPECT_EQ(std::get<ControlSample>(kept.all[20]).text.str(), "defect");

  // A sender that begins anew after a silence is heard again; its numbers go on.
  const timespec silence{0, 400'000'000};
  nanosleep(&silence, nullptr);
  for (int i = 0; i < 3; ++i) send(kStylusChannel, encode_message(to_message(stylus(i, 5, Vec3(i, 7, 0))), bytes));
  EXPECT_TRUE(wait_for([&] { return kept.all.size() >= 25; }));
  EXPECT_EQ(std::get<StylusSample>(kept.all[22]).seq, 23);
  EXPECT_EQ(std::get<StylusSample>(kept.all.back()).seq, 25);
  const int64_t malformed = source.counts().malformed;
  send(kStylusChannel, encode_message(to_message(stylus(1, 5, Vec3(0, 7, 0))), bytes));  // at once: one that came twice
  EXPECT_TRUE(wait_for([&] { return source.counts().malformed > malformed; }));
  int64_t last = -1;
  for (const Sample& s : kept.all) {
    const int64_t t = std::visit([](const auto& v) { return v.t_ns; }, s);
    EXPECT_GT(t, last);
    last = t;
  }
}

}  // namespace test_lcm_net_source
}  // namespace limberg
