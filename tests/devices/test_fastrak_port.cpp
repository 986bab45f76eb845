// The FASTRAK over a pseudo-terminal: bytes and states, never times (what comes over one may be late by any amount).
#include <gtest/gtest.h>
#include <time.h>

#include "devices/fastrak/port.h"
#include "devices/fastrak/source.h"
#include "devices/message_codec.h"

namespace limberg::fastrak {
namespace test_fastrak_port {

int64_t monotonic_ns() {
  timespec ts;
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return int64_t(ts.tv_sec) * 1'000'000'000 + ts.tv_nsec;
}

struct Count final : SampleSink {
  void on_sample(const Sample& s) override {
    if (const auto* t = std::get_if<TrackerSample>(&s)) {
      ++readings, last = *t;
      wrong_order |= t->t_ns <= last_ns || t->true_ns > t->t_ns;
      last_ns = t->t_ns;
    }
    if (const auto* r = std::get_if<RawSample>(&s)) raw += r->n;
  }
  int64_t readings = 0, raw = 0, last_ns = -1;
  bool wrong_order = false;
  TrackerSample last;
};

/// Polls until so many readings have come, for at most 20 s.
bool wait_for(FastrakSource& source, Count& c, int64_t readings, int64_t start_ns) {
  for (const int64_t end = monotonic_ns() + 20'000'000'000; monotonic_ns() < end;) {
    source.poll(monotonic_ns() - start_ns, c);
    if (c.readings >= readings) return true;
    const timespec pause{0, 2'000'000};
    nanosleep(&pause, nullptr);
  }
  return false;
}

TEST(FastrakPort, ShakesHandsAndReadsAndSurvivesUnplugging) {
  EmulatedPort device(hand_at_work(3));
  SourceSettings s = parse_source(device.path() + ",fts");
  const int64_t start = monotonic_ns();
  FastrakSource source(s, start);
  Count c;
  ASSERT_TRUE(wait_for(source, c, 60, start)) << source.health();
  EXPECT_NE(source.health().find("running"), std::string::npos) << source.health();
  EXPECT_FALSE(c.wrong_order);
  EXPECT_GT(c.raw, 60 * 33);
  // A second program may not have the same line.
  SerialPort second;
  EXPECT_FALSE(second.open(device.path(), 115200));
  EXPECT_NE(second.why().find("another program"), std::string::npos);

  device.unplug();
  const int64_t before = c.readings;
  for (int i = 0; i < 200 && source.health().find("running") != std::string::npos; ++i) {
    const timespec pause{0, 20'000'000};
    nanosleep(&pause, nullptr);
    source.poll(monotonic_ns() - start, c);
  }
  EXPECT_EQ(source.health().find("running"), std::string::npos);
  device.plug_in();
  source.look_at(device.path());
  ASSERT_TRUE(wait_for(source, c, before + 100, start)) << source.health();
  EXPECT_FALSE(c.wrong_order);
}

TEST(FastrakPort, APortThatIsNotThereIsWaitedFor) {
  FastrakSource source(parse_source("/no/such/port,s"), monotonic_ns());
  std::string said;
  for (int i = 0; i < 100 && said.find("No such file") == std::string::npos; ++i) {
    const timespec pause{0, 10'000'000};
    nanosleep(&pause, nullptr);
    said = source.health();
  }
  EXPECT_NE(said.find("No such file"), std::string::npos) << said;
  SerialPort p;
  EXPECT_FALSE(p.open("/dev/null", 115200));
  EXPECT_NE(p.why().find("not a serial port"), std::string::npos);
}

}  // namespace test_fastrak_port
}  // namespace limberg::fastrak
