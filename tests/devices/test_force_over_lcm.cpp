// A force device in another program: its poses over LCM, the forces that answer them. Behaviour, never times: what
// comes over a network may be late by any amount.
#include <gtest/gtest.h>
#include <time.h>

#include <fstream>
#include <iterator>
#include <map>
#include <regex>

#include "app/program/places.h"
#include "devices/force/lcm_force_port.h"
#include "devices/force/waited_source.h"
#include "devices/lcm_publisher.h"
#include "devices/message_codec.h"
#include "devices/monotonic.h"
#include "sim/base/error.h"
#include "tests/devices/flat_patient.h"
#include "tests/devices/samples.h"
#include "tests/own_port.h"

namespace limberg {
namespace test_force_over_lcm {

using namespace test;

/// A session's device thread and a laboratory's program, by turns.
struct Bench {
  explicit Bench(const std::string& url)
      : skin(snapshot_of(flat_topology(12, 1))),
        start_ns(monotonic_ns()),
        source(std::make_unique<LcmForcePort>(url, start_ns), start_ns),
        out(url, false),
        in(url) {}

  /// Another millisecond: `pose` is sent where there is one, what came is kept.
  void tick(const StylusSample* pose) {
    if (pose) out.publish(*pose), sent[pose->seq] = pose->t_ns;
    const timespec pause{0, 1'000'000};
    nanosleep(&pause, nullptr);
    const int64_t now_ns = monotonic_ns() - start_ns;
    if (now_ns / 16'000'000 != step) step = now_ns / 16'000'000, ++skin.step;
    source.look(skin), source.hold(tool), source.poll(now_ns, samples);
    in.receive(0, [this](std::string_view channel, const uint8_t* data, size_t n) {
      limberg_msg::force_t m;
      if (channel != kForceChannel) return;
      ASSERT_EQ(decode_message(data, n, m), nullptr);
      forces.push_back(m);
    });
  }

  Snapshot skin;
  ToolState tool;
  int64_t start_ns, step = -1;
  WaitedForceSource source;
  LcmPublisher out;
  LcmLocalLink in;
  Samples samples;
  std::map<int64_t, int64_t> sent;  // number, time
  std::vector<limberg_msg::force_t> forces;
};

std::unique_ptr<Bench> bench() {
  try {
    auto b = std::make_unique<Bench>(udpm_here(free_udp_port()));
    const StylusSample first = stylus(0, 77, Vec3(0, 0, 9));
    for (int i = 0; i < 200 && b->forces.empty(); ++i) b->tick(i == 0 ? &first : nullptr);
    return b->forces.empty() ? nullptr : std::move(b);
  } catch (const InputError&) {
    return nullptr;
  }
}

TEST(ForceOverLcm, EachPoseIsAnsweredByWhatIsFeltThere) {
  const auto b = bench();
  if (!b) GTEST_SKIP() << "multicast packets do not come back on this machine";
  for (int64_t seq = 1; seq < 900; ++seq) {
    const StylusSample s = stylus(seq, 5'000 + 3 * seq, Vec3(1, 2, seq < 150 ? 1 : -2));
    b->tick(&s);
    StylusSample other = s;  // of somebody else: never answered
    other.device_id = 8, other.seq = 1'000'000 + seq, other.tip_mm.z() = -20;
    if (seq % 10 == 0) b->out.publish(other);
  }
  const double k = 2 * 60 / (1 - 0.45 * 0.45) * 1e-3, held = 0.002 / 0.0015,
               coupled = k * held / (k + held);  // N/mm: half space, in series
  int64_t last = -1, seq = -1, touched = 0, answered = 0;
  for (const auto& m : b->forces) {
    EXPECT_GT(m.seq, last), last = m.seq;
    if (m.pose_seq < 0) continue;
    EXPECT_EQ(m.device_id, 7);
    ASSERT_TRUE(b->sent.contains(m.pose_seq));
    EXPECT_EQ(m.t_device_ns, b->sent[m.pose_seq]);
    EXPECT_GE(m.pose_seq, seq);
    answered += m.pose_seq > seq, seq = m.pose_seq;
    EXPECT_GE(m.after_ns, 0);
    touched += m.state == 2;
    if (m.pose_seq > 0 && m.pose_seq < 140) {
      EXPECT_EQ(m.state, 1);
      EXPECT_EQ(m.force_mN[2], 0);
    }
  }
  EXPECT_GT(answered, 300) << "most poses of a second";
  EXPECT_GT(touched, 100);
  const auto& m = b->forces.back();
  EXPECT_EQ(m.state, 2);
  EXPECT_NEAR(m.stiffness_mN_mm, 1e3 * coupled, 1e-6);
  EXPECT_NEAR(m.depth_mm, 2, 1e-9);
  EXPECT_NEAR(m.plane_mm[2], 0, 1e-9);
  EXPECT_NEAR(m.normal[2], 1, 1e-9);
  EXPECT_NEAR(m.force_mN[2], 1e3 * coupled * 2, 30);
  // Everybody else hears of a stylus that the surface holds up.
  ASSERT_GT(b->samples.all.size(), 300u);
  EXPECT_NEAR(std::get<StylusSample>(b->samples.all.back()).tip_mm.z(), 0, 1e-9);

  // Silence: no force, and no pose that it would answer.
  for (int i = 0; i < 2000 && b->forces.back().state != 0; ++i) b->tick(nullptr);
  EXPECT_EQ(b->forces.back().state, 0);
  EXPECT_EQ(b->forces.back().pose_seq, -1);
  for (const double f : b->forces.back().force_mN) EXPECT_EQ(f, 0);
}

TEST(ForceOverLcm, DamagedPosesAreCountedAndFeelNothing) {
  const auto b = bench();
  if (!b) GTEST_SKIP() << "multicast packets do not come back on this machine";
  StylusSample bad = stylus(5, 0, Vec3(0, std::nan(""), 0));
  b->out.publish(bad);
  bad = stylus(6, 0, Vec3(0, 0, -20'000));
  b->out.publish(bad);
  for (int i = 0; i < 2000 && b->source.counts().malformed < 2; ++i) b->tick(nullptr);
  EXPECT_EQ(b->source.counts().malformed, 2);
  for (const auto& m : b->forces) EXPECT_LE(m.pose_seq, 0);
}

TEST(ForceOverLcm, ForcesStayOnThisMachine) {
  for (const char* url :
       {"udpm://239.255.76.67:7667?ttl=1", "udpm://239.255.76.67:7667", "memq://", "tcpq://somewhere:7700", ""})
    EXPECT_THROW(LcmForcePort(url, 0), InputError) << url;
}

/// The numbers that a laboratory copies, in page and client, are those of the types.
TEST(ForceOverLcm, PageAndClientHaveTheFingerprintsOfTheTypes) {
  const auto slurp = [](const std::string& name) {
    std::ifstream in(source_dir() + name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  char stylus_hash[20], force_hash[20];
  std::snprintf(stylus_hash, sizeof stylus_hash, "0x%016llX", (unsigned long long)limberg_msg::stylus_t::getHash());
  std::snprintf(force_hash, sizeof force_hash, "0x%016llX", (unsigned long long)limberg_msg::force_t::getHash());
  for (const char* name : {"/docs/devices.md", "/devices/clients/force_client.py"})
    for (const char* hash : {stylus_hash, force_hash})
      EXPECT_NE(slurp(name).find(hash), std::string::npos) << name << " does not have " << hash;
  EXPECT_EQ(limberg_msg::force_t{}.getEncodedSize(), 160);
  EXPECT_EQ(limberg_msg::stylus_t{}.getEncodedSize(), 104);
}

}  // namespace test_force_over_lcm
}  // namespace limberg
