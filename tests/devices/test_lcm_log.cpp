// The log format: against the packaged library in both directions, and against damage.
#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>

#include "devices/lcm_log.h"
#include "sim/base/error.h"
#include "tests/devices/samples.h"
#include "tests/devices/temporary.h"

namespace limberg {
namespace test_lcm_log {

using test::bytes_of;
using test::Dice;
using test::TemporaryFolder;

/// n events, event i with i % 60 + 8 bytes of payload, all equal to i.
void write_log(const std::string& path, int n) {
  LogWriter w;
  w.open(path);
  for (int i = 0; i < n; ++i) {
    const std::vector<uint8_t> data(size_t(i % 60 + 8), uint8_t(i));
    ASSERT_TRUE(w.write(1000 * i, i % 2 ? "ODD" : "EVEN", data.data(), data.size()));
  }
  ASSERT_TRUE(w.close());
  EXPECT_EQ(w.events(), n);
}

struct Got {
  int64_t events = 0, first = -1;
  LogDamage damage;
};

Got read_all(std::vector<uint8_t> bytes) {
  LogReader r(std::move(bytes));
  Got got;
  LogEvent e;
  while (r.next(e)) {
    if (got.events++ == 0) got.first = e.number;
    unsigned sum = 0;  // touch every byte, so that a sanitizer sees a bad range
    for (size_t i = 0; i < e.size; ++i) sum += e.data[i];
    for (char c : e.channel) sum += unsigned(c);
    EXPECT_LT(sum, 1u << 30);
  }
  got.damage = r.damage();
  return got;
}

TEST(LcmLog, RoundTrip) {
  TemporaryFolder dir;
  write_log(dir / "a.lcm", 200);
  LogReader r(dir / "a.lcm");
  LogEvent e;
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(r.next(e));
    EXPECT_EQ(e.number, i);
    EXPECT_EQ(e.time_us, 1000 * i);
    EXPECT_EQ(e.channel, i % 2 ? "ODD" : "EVEN");
    ASSERT_EQ(e.size, size_t(i % 60 + 8));
    EXPECT_EQ(e.data[e.size - 1], uint8_t(i));
  }
  EXPECT_FALSE(r.next(e));
  EXPECT_EQ(r.damage().total(), 0);
}

TEST(LcmLog, OursIsReadByThePackagedLibrary) {
  TemporaryFolder dir;
  write_log(dir / "a.lcm", 100);
  lcm::LogFile file((dir / "a.lcm"), "r");
  ASSERT_TRUE(file.good());
  for (int i = 0; i < 100; ++i) {
    const lcm::LogEvent* e = file.readNextEvent();
    ASSERT_NE(e, nullptr) << i;
    EXPECT_EQ(e->eventnum, i);
    EXPECT_EQ(e->timestamp, 1000 * i);
    EXPECT_EQ(e->channel, i % 2 ? "ODD" : "EVEN");
    ASSERT_EQ(e->datalen, i % 60 + 8);
    EXPECT_EQ(static_cast<const uint8_t*>(e->data)[0], uint8_t(i));
  }
  EXPECT_EQ(file.readNextEvent(), nullptr);
}

TEST(LcmLog, ThePackagedLibrarysIsReadByUs) {
  TemporaryFolder dir;
  {
    lcm::LogFile file((dir / "b.lcm"), "w");
    ASSERT_TRUE(file.good());
    for (int i = 0; i < 100; ++i) {
      uint8_t data[3] = {1, 2, uint8_t(i)};
      lcm::LogEvent e{};
      e.timestamp = 5 * i;
      e.channel = "THEIRS";
      e.datalen = 3;
      e.data = data;
      ASSERT_EQ(file.writeEvent(&e), 0);
    }
  }
  const Got got = read_all(bytes_of(dir / "b.lcm"));
  EXPECT_EQ(got.events, 100);
  EXPECT_EQ(got.damage.total(), 0);
}

TEST(LcmLog, NoFileADirectoryAndAnEmptyFile) {
  TemporaryFolder dir;
  EXPECT_THROW(LogReader(dir / "none.lcm"), InputError);
  EXPECT_THROW(LogReader(dir / ""), InputError);
  EXPECT_THROW(LogReader("/dev/null"), InputError);
  EXPECT_EQ(read_all({}).events, 0);
}

// The table of reference behaviour: one damage costs at most the events it touches.
class LcmLogDamage : public ::testing::Test {
 protected:
  void SetUp() override {
    write_log(dir_ / "a.lcm", kEvents);
    bytes_ = bytes_of(dir_ / "a.lcm");
    LogReader r(bytes_);
    LogEvent e;
    while (r.next(e)) offset_.push_back(size_t(e.offset));
  }
  static constexpr int kEvents = 1000;
  TemporaryFolder dir_;
  std::vector<uint8_t> bytes_;
  std::vector<size_t> offset_;
};

TEST_F(LcmLogDamage, CutAtEveryByteOfTheLastEvents) {
  for (size_t size = offset_[990]; size < bytes_.size(); ++size) {
    const size_t whole = size_t(std::upper_bound(offset_.begin(), offset_.end(), size) - offset_.begin()) - 1;
    const Got got = read_all({bytes_.begin(), bytes_.begin() + long(size)});
    ASSERT_EQ(got.events, int64_t(whole)) << size;
    ASSERT_EQ(got.damage.truncated, offset_[whole] == size ? 0 : 1) << size;
    ASSERT_EQ(got.damage.total(), got.damage.truncated);
  }
}

TEST_F(LcmLogDamage, SyncWord) {
  bytes_[offset_[500] + 2] ^= 4;
  const Got got = read_all(bytes_);
  EXPECT_EQ(got.events, kEvents - 1);
  EXPECT_EQ(got.damage.bad_sync, 1);
  EXPECT_EQ(got.damage.missing, 1);
  EXPECT_NE(got.damage.first_message.find(std::to_string(offset_[500])), std::string::npos);
}

TEST_F(LcmLogDamage, Lengths) {
  for (const auto& [at, value] :
       {std::pair{20, 0x7F}, {20, 0x80}, {23, 0x40}, {24, 0x3B}, {25, 1}, {26, 1}, {27, 0x20}}) {
    std::vector<uint8_t> b = bytes_;
    b[offset_[500] + size_t(at)] ^= uint8_t(value);
    const Got got = read_all(b);
    EXPECT_GE(got.events, kEvents - 1) << at;
    EXPECT_EQ(got.damage.bad_length + got.damage.bad_sync, 1) << at;
  }
}

TEST_F(LcmLogDamage, AnEventNumberIsNotALoss) {
  bytes_[offset_[500] + 9] ^= 0x10;
  const Got got = read_all(bytes_);
  EXPECT_EQ(got.events, kEvents);
  EXPECT_EQ(got.damage.missing, 0);
}

TEST_F(LcmLogDamage, EventsCutOutAreMissed) {
  bytes_.erase(bytes_.begin() + long(offset_[300]), bytes_.begin() + long(offset_[317]));
  const Got got = read_all(bytes_);
  EXPECT_EQ(got.events, kEvents - 17);
  EXPECT_EQ(got.damage.missing, 17);
}

TEST_F(LcmLogDamage, RubbishInFrontBetweenAndBehind) {
  Dice dice{3};
  std::vector<uint8_t> rubbish(5000);
  for (uint8_t& b : rubbish) b = uint8_t(dice.next());
  for (size_t at : {size_t(0), offset_[500], bytes_.size()}) {
    std::vector<uint8_t> b = bytes_;
    b.insert(b.begin() + long(at), rubbish.begin(), rubbish.end());
    const Got got = read_all(b);
    EXPECT_EQ(got.events, kEvents) << at;
    EXPECT_EQ(got.damage.bad_sync, 1) << at;
    EXPECT_EQ(got.damage.skipped_bytes, 5000) << at;
  }
}

TEST(LcmLog, ManySyncWordsDoNotTakeForever) {
  // Sync words with lengths that reach beyond the end: the worst case for a search that starts again each time.
  std::vector<uint8_t> b;
  for (int i = 0; i < 200'000; ++i) {
    const uint8_t header[] = {0xED, 0xA1, 0xDA, 0x01};
    b.insert(b.end(), header, header + 4);
  }
  const Got got = read_all(b);
  EXPECT_EQ(got.events, 0);
  EXPECT_GT(got.damage.total(), 0);
}

TEST(LcmLog, AFullDiskIsReported) {
  LogWriter w;
  w.open("/dev/full", true);
  const std::vector<uint8_t> data(100, 1);
  bool ok = true;
  for (int i = 0; i < 1000 && ok; ++i) ok = w.write(2000 * i, "X", data.data(), data.size());
  EXPECT_FALSE(ok);
  EXPECT_NE(w.error().find("/dev/full"), std::string::npos);
  EXPECT_EQ(w.events(), 0);
  EXPECT_FALSE(w.close());
}

TEST(LcmLog, ASecondOfLogIsOnTheDisk) {
  TemporaryFolder dir;
  LogWriter w;
  w.open(dir / "a.lcm");
  const uint8_t byte = 1;
  for (int i = 0; i <= 300; ++i) w.write(10'000 * i, "X", &byte, 1);
  EXPECT_GE(read_all(bytes_of(dir / "a.lcm")).events, 200);
}

TEST(LcmLog, AnExistingFileStays) {
  TemporaryFolder dir;
  write_log(dir / "a.lcm", 3);
  LogWriter w;
  EXPECT_THROW(w.open(dir / "a.lcm"), InputError);
  EXPECT_EQ(read_all(bytes_of(dir / "a.lcm")).events, 3);
  EXPECT_THROW(w.open(dir / "no/such/folder.lcm"), InputError);
}

}  // namespace test_lcm_log
}  // namespace limberg
