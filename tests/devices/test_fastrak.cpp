// The FASTRAK without a line: protocol, conversation and emulator in simulated time.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "devices/fastrak/emulator.h"
#include "devices/fastrak/link.h"
#include "devices/fastrak/source.h"
#include "sim/base/error.h"
#include "tests/devices/samples.h"

namespace limberg::fastrak {
namespace test_fastrak {

using test::Dice;
constexpr int64_t kMs = 1'000'000;

struct Take final : Parser::Sink {
  void on_record(const Record& r) override { got.push_back(r); }
  void on_reply(std::span<const char> text) override { replies.emplace_back(text.data(), text.size()); }
  std::vector<Record> got;
  std::vector<std::string> replies;
};

Record record(Dice& dice, int station) {
  Record r;
  r.station = station;
  r.pos_mm = 500 * Vec3(dice.unit() - 0.5, dice.unit() - 0.5, dice.unit() - 0.5);
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(dice.normal(), dice.normal(), dice.normal(), dice.normal()).normalized();
  r.quat = {q.w(), q.x(), q.y(), q.z()};
  return r;
}

std::vector<uint8_t> bytes_of(const Record& r, const Layout& l) {
  std::array<uint8_t, kLongest> b;
  const size_t n = encode(r, l, b);
  EXPECT_EQ(n, l.record_bytes(r.station));
  return {b.begin(), b.begin() + long(n)};
}

TEST(FastrakProtocol, BinaryAndAsciiOfOnePoseAgree) {
  Dice dice{1};
  Layout binary, ascii;
  ascii.binary = false;
  binary.has_switch[1] = ascii.has_switch[1] = true;
  EXPECT_EQ(binary.record_bytes(1), 33u);
  EXPECT_EQ(ascii.record_bytes(2), 56u);
  Parser a, b;
  a.reset(binary), b.reset(ascii);
  Take ta, tb;
  for (int i = 0; i < 1000; ++i) {
    Record r = record(dice, 1 + i % 2);
    r.pressed = i % 4 == 1;
    for (uint8_t x : bytes_of(r, binary)) a.feed(x, i, ta);
    for (uint8_t x : bytes_of(r, ascii)) b.feed(x, i, tb);
    ASSERT_EQ(ta.got.size(), size_t(i + 1));
    ASSERT_EQ(tb.got.size(), size_t(i + 1));
    const Record &p = ta.got.back(), &q = tb.got.back();
    EXPECT_LT((p.pos_mm - r.pos_mm).norm(), 1e-3);
    EXPECT_LT((q.pos_mm - r.pos_mm).cwiseAbs().maxCoeff(), 0.0501);  // hundredths of a centimetre
    for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(p.quat[k], q.quat[k], 2e-4);
    EXPECT_EQ(p.pressed, r.pressed);
    EXPECT_EQ(q.pressed, r.pressed);
    EXPECT_EQ(p.station, r.station);
  }
}

TEST(FastrakProtocol, BeginsInTheMiddleAndFindsTheNextRecord) {
  Dice dice{2};
  const Layout layout;
  const std::vector<uint8_t> first = bytes_of(record(dice, 1), layout), second = bytes_of(record(dice, 2), layout);
  for (size_t from = 1; from + 1 < first.size(); ++from) {  // of a lone LF it cannot be known what it ends
    Parser p;
    p.reset(layout);
    Take take;
    for (size_t i = from; i < first.size(); ++i) p.feed(first[i], 0, take);
    for (uint8_t x : second) p.feed(x, 7, take);
    ASSERT_EQ(take.got.size(), 1u) << from;
    EXPECT_EQ(take.got[0].station, 2);
    EXPECT_EQ(take.got[0].t_ns, 7);
    EXPECT_EQ(p.counts().skipped_bytes, int64_t(first.size() - from));
  }
}

TEST(FastrakProtocol, OnlyWhatStandsBehindALineEndIsARecord) {
  Dice dice{21};
  const Layout layout;
  const std::vector<uint8_t> first = bytes_of(record(dice, 1), layout), second = bytes_of(record(dice, 2), layout),
                             third = bytes_of(record(dice, 1), layout);
  Parser p;
  p.reset(layout);
  Take take;
  for (uint8_t x : first) p.feed(x, 0, take);
  p.feed('x', 0, take);  // a stray byte: what follows looks like a record, but could be the inside of something
  for (uint8_t x : second) p.feed(x, 0, take);
  EXPECT_EQ(take.got.size(), 1u);
  for (uint8_t x : third) p.feed(x, 0, take);
  ASSERT_EQ(take.got.size(), 2u);
  EXPECT_EQ(take.got[1].station, 1);
}

TEST(FastrakProtocol, OneDamagedByteCostsOneRecordOrTwo) {
  Dice dice{3};
  const Layout layout;
  int64_t lost = 0, hits = 0;
  for (int round = 0; round < 3000; ++round) {
    Parser p;
    p.reset(layout);
    Take take;
    const size_t hit = dice.below(33);
    const int how = int(dice.below(3));
    for (int k = 0; k < 5; ++k) {
      const Record r = record(dice, 1 + k % 2);
      std::vector<uint8_t> b = bytes_of(r, layout);
      if (k == 2 && how == 0) b[hit] = uint8_t(b[hit] + 1 + dice.below(255));
      if (k == 2 && how == 1) b.erase(b.begin() + long(hit));
      if (k == 2 && how == 2) b.insert(b.begin() + long(hit), uint8_t(dice.next()));
      for (uint8_t x : b) p.feed(x, 0, take);
    }
    ++hits;
    lost += 5 - int64_t(take.got.size());
    // What follows the damage by more than a record is taken again, whatever happened.
    ASSERT_GE(take.got.size(), 3u) << how << " at " << hit;
  }
  EXPECT_LT(double(lost) / double(hits), 1.2);
}

TEST(FastrakProtocol, WhatTheChecksLetThroughIsKnown) {
  Dice dice{4};
  Layout binary, ascii;
  ascii.binary = false;
  const Record r = record(dice, 1);
  // Position and quaternion are 28 of 33 bytes. A byte of a position passes unless it leaves the reach; of a quaternion
  // only when the length stays within 1 %: the two lower bytes of each number, and a sign.
  const double any = accepted_share(r, binary, 0, 0), far = accepted_share(r, binary, 3, 3);
  EXPECT_GT(any, 12.0 / 33 * 0.8);
  EXPECT_LT(any, (12 + 8 + 2) / 33.0);
  EXPECT_LT(far, any / 2);
  // In ASCII nearly every wrong byte is no digit.
  EXPECT_LT(accepted_share(r, ascii, 0, 0), 0.03);
}

TEST(FastrakProtocol, StationsRolesAndSpecs) {
  EXPECT_EQ(parse_roles("fts")[2], StationRole::stylus);
  EXPECT_EQ(parse_roles("-s")[0], StationRole::none);
  EXPECT_EQ(parse_roles("ftFT")[3], StationRole::other_thumb);
  for (const char* bad : {"", "f", "ff", "x", "-", "ftsss", "ftft", "ftF"})
    EXPECT_THROW(parse_roles(bad), InputError) << bad;
  const SourceSettings s = parse_source("/dev/x,s,ascii,9600");
  EXPECT_EQ(s.path, "/dev/x");
  EXPECT_FALSE(s.link.binary);
  EXPECT_EQ(s.link.baud, 9600);
  for (const char* bad : {"", ",ft", "/dev/x,300", "/dev/x,12x", "/dev/x,q"})
    EXPECT_THROW(parse_source(bad), InputError) << bad;
}

/// Link and emulator with nothing between them, a millisecond a step.
struct Table final : Link::Receiver {
  explicit Table(const LinkSettings& l, const EmulatorSettings& e = {}, Motion motion = hand_at_work(5))
      : device(std::move(motion), e), link(l) {
    device.keep_sent = true;
    link.opened(0);
  }
  void on_reading(const TrackerSample& s) override { readings.push_back(s); }
  void run(int64_t ms) {
    for (const int64_t end = now + ms * kMs; now < end; now += kMs) step();
  }
  void step() {
    const std::vector<uint8_t> out = link.take_output();
    if (connected) device.receive(out.data(), out.size(), now);
    std::vector<uint8_t> in = device.send(now);
    if (!connected) in.clear();
    // Pieces of one to so many bytes, as a line gives them.
    for (size_t at = 0; at < in.size();) {
      const size_t n = std::min(in.size() - at, 1 + dice.below(piece));
      link.receive(in.data() + at, n, now, *this);
      at += n;
    }
    link.tick(now);
  }
  Emulator device;
  Link link;
  Dice dice{6};
  size_t piece = 40;
  bool connected = true;
  int64_t now = 0;
  std::vector<TrackerSample> readings;
  int64_t of(int station) const {
    return std::count_if(readings.begin(), readings.end(), [&](const auto& r) { return r.station == station; });
  }
};

TEST(FastrakLink, TwoStationsAtSixtyHertzEach) {
  Table t{LinkSettings{}};
  t.run(500);
  EXPECT_EQ(t.link.phase(), Link::Phase::run);
  EXPECT_NE(t.link.status().find("FASTRAK"), std::string::npos);
  EXPECT_TRUE(t.device.centimetres());
  EXPECT_TRUE(t.device.layout().binary);
  t.readings.clear(), t.device.sent.clear();
  t.run(10'000);
  EXPECT_NEAR(double(t.of(1)), 600, 2);
  EXPECT_NEAR(double(t.of(2)), 600, 2);
  EXPECT_EQ(t.link.counts().parser.damaged, 0);
  // Every reading is one that was sent, at the time at which it was sampled.
  size_t k = 0;
  double worst_ms = 0;
  for (const TrackerSample& r : t.readings) {
    while (k < t.device.sent.size() &&
           (t.device.sent[k].record.station != r.station || std::abs(t.device.sent[k].sample_ns - r.true_ns) > 4 * kMs))
      ++k;
    ASSERT_LT(k, t.device.sent.size());
    EXPECT_LT((r.pos_mm - t.device.sent[k].record.pos_mm).norm(), 1e-3);
    EXPECT_EQ(r.role, r.station == 1 ? StationRole::forefinger : StationRole::thumb);
    worst_ms = std::max(worst_ms, std::abs(double(r.true_ns - t.device.sent[k].sample_ns)) * 1e-6);
  }
  EXPECT_LT(worst_ms, 4.1);  // the first readings; a line by the millisecond and bytes in one lump
}

TEST(FastrakLink, AsciiStylusWithSwitchAtItsRate) {
  LinkSettings l;
  l.role = parse_roles("--s");
  l.binary = false;
  Table t{l};
  t.piece = 1;
  t.run(4500);
  EXPECT_EQ(t.of(1) + t.of(2), 0);
  EXPECT_NEAR(double(t.of(3)), 120 * 4.2, 20);
  std::set<uint32_t> states;
  for (const auto& r : t.readings) states.insert(r.buttons);
  EXPECT_EQ(states, (std::set<uint32_t>{0, 1}));
}

TEST(FastrakLink, FindsAStreamThatRunsAlready) {
  Table t{LinkSettings{}};
  t.run(700);
  t.link.opened(t.now);  // the program was started anew; the device did not notice
  t.readings.clear();
  t.run(3000);
  EXPECT_EQ(t.link.phase(), Link::Phase::run);
  EXPECT_GT(t.readings.size(), 200u);
}

TEST(FastrakLink, DamageCostsReadingsAndNothingElse) {
  EmulatorSettings e;
  e.damage_per_byte = 1e-3;
  Table t{LinkSettings{}, e};
  t.run(60'000);
  const double sent = double(t.device.sent.size()), got = double(t.readings.size());
  EXPECT_GT(got, 0.92 * sent);  // 3.3 % of the records are hit, each costs at most two
  EXPECT_LT(got, sent);
  EXPECT_GT(t.link.counts().parser.damaged, 100);
  int64_t last[5] = {-1, -1, -1, -1, -1};
  for (const auto& r : t.readings) {
    EXPECT_GT(r.true_ns, last[r.station]);
    last[r.station] = r.true_ns;
  }
}

TEST(FastrakLink, AStationThatDisappearsAndComesBack) {
  Table t{LinkSettings{}};
  t.run(1000);
  t.device.plug(1, false), t.device.plug(2, false);
  t.run(2500);  // no record: it asks again; the stations are not there, and it goes on asking
  EXPECT_GE(t.link.counts().restarts, 1);
  EXPECT_NE(t.link.phase(), Link::Phase::run);
  t.device.plug(1, true), t.device.plug(2, true);
  t.readings.clear();
  t.run(3000);
  EXPECT_EQ(t.link.phase(), Link::Phase::run);
  EXPECT_GT(t.of(2), 30);
  EXPECT_GT(t.link.counts().refused_setup, 0);
}

TEST(FastrakLink, ADeafDeviceIsReinitialised) {
  Table t{LinkSettings{}};
  t.device.receive(reinterpret_cast<const uint8_t*>("\x19"), 1,
                   0);  // someone has just started it: ten seconds of silence
  t.run(8'000);
  EXPECT_NE(t.link.phase(), Link::Phase::run);
  t.run(25'000);
  EXPECT_EQ(t.link.phase(), Link::Phase::run);
}

TEST(FastrakLink, WrongRateIsGarbageAndRecovers) {
  Table t{LinkSettings{}};
  t.connected = false;
  Dice dice{8};
  for (int64_t i = 0; i < 3000; ++i, t.now += kMs) {
    uint8_t noise[12];
    for (uint8_t& b : noise) b = uint8_t(dice.next());
    t.link.receive(noise, sizeof noise, t.now, t);
    t.link.tick(t.now);
    t.link.take_output();
  }
  EXPECT_TRUE(t.readings.empty());
  t.connected = true;
  t.run(16'000);
  EXPECT_EQ(t.link.phase(), Link::Phase::run);
}

TEST(FastrakLink, ErrorLettersPassAndAreCounted) {
  Table t{LinkSettings{}};
  t.run(500);
  t.device.error('A');
  t.run(500);
  EXPECT_GT(t.link.counts().parser.errors, 40);
  EXPECT_EQ(t.readings.back().status, 'A');
}

TEST(FastrakLink, CrossingTheHemisphereDoesNotMirrorTheHand) {
  const Motion through = [](int station, double t) {
    StationPose p;
    p.pos_mm = Vec3(300 * std::cos(0.5 * t), 20.0 * station, 80);  // 150 mm/s, through x = 0 and back
    return p;
  };
  Table t{LinkSettings{}, {}, through};
  t.run(12'000);
  EXPECT_GT(t.link.counts().mirrored, 300);
  for (const auto& r : t.readings)
    ASSERT_LT((r.pos_mm - through(r.station, double(r.true_ns) * 1e-9).pos_mm).norm(), 3.0) << double(r.true_ns) * 1e-9;
}

TEST(FastrakLink, StampsFollowTheDeviceNotTheOperatingSystem) {
  Dice dice{9};
  Stamps stamps(16'666'667);
  double sum2 = 0, raw2 = 0;
  int n = 0;
  for (int i = 0; i < 2000; ++i) {
    const double true_ns = i * 16'670'000.0;  // 0.02 % slower than it says
    double late = 3e5 + 1e6 * dice.unit() * dice.unit();
    if (i % 50 == 7) late += 12e6;  // a lump
    if (i % 37 == 5) continue;      // lost
    const double e = double(stamps.stamp(int64_t(true_ns + late))) - true_ns;
    if (i < 100) continue;
    sum2 += std::pow(e - 3e5, 2), raw2 += std::pow(late - 3e5, 2), ++n;
  }
  EXPECT_LT(std::sqrt(sum2 / n), 2.5e5);  // 0.25 ms
  EXPECT_LT(std::sqrt(sum2), std::sqrt(raw2) / 5);
}

}  // namespace test_fastrak
}  // namespace limberg::fastrak
