// Recordings: what goes in comes out, and nothing that stands in a file can do harm.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "devices/continued_source.h"
#include "devices/log_source.h"
#include "devices/message_codec.h"
#include "devices/old_controls.h"
#include "devices/recording.h"
#include "devices/unfinished.h"
#include "sim/base/error.h"
#include "tests/devices/samples.h"
#include "tests/devices/temporary.h"
#include "tests/small_files.h"

namespace limberg {
namespace test_recording {

using namespace test;

SessionInfo session() {
  SessionInfo s;
  s.program = "limberg 0.1.0 (abcdef)";
  s.scene_name = "rhomboid";
  s.scene_hash = 0xFEDCBA9876543210ull;
  s.calibration_hash = 42;
  s.seeds = {1, 2, 0xFFFFFFFFFFFFFFFFull, 4};
  s.ticks_per_solver_step = 8;
  return s;
}

std::vector<Blob> blobs() {
  std::string mesh(10'000, '\0');
  for (size_t i = 0; i < mesh.size(); ++i) mesh[i] = char(i * 7);
  return {{BlobKind::scene, "rhomboid.toml", "a = 1\n"},
          {BlobKind::mesh, "face.obj", mesh},
          {BlobKind::mesh, "empty.obj", ""},
          {BlobKind::texture, "exact.png", std::string(8192, 'x')}};
}

StateSample state(int64_t step) {
  StateSample s;
  s.step = step, s.topology = 0xfedcba9876543210u, s.vertices = 1000, s.n = StateSample::kPlaces;
  for (int32_t k = 0; k < s.n; ++k) s.at_mm[size_t(k)] = {float(k), -0.25f * float(step), 1e-3f};
  s.sutures_N = 1.5f, s.hooks_N = 0.75f;
  return s;
}

std::vector<uint8_t> recording_bytes(const TemporaryFolder& dir, int samples) {
  RecordingWriter w;
  w.open(dir / "r.lcm", session(), blobs(), true);
  int i = 0;
  for (const Sample& s : stream(samples)) {
    w.on_sample(s);
    if (++i % 100 != 0) continue;
    w.checkpoint(i * 8, uint64_t(i) << 40);
    w.state(state(i));
  }
  EXPECT_TRUE(w.finish(9000, 77));
  return bytes_of(dir / "r.lcm");
}

TEST(Recording, RoundTrip) {
  TemporaryFolder dir;
  recording_bytes(dir, 300);
  const Recording r = read_recording(dir / "r.lcm");
  EXPECT_EQ(r.damage.total(), 0) << r.damage.first_message;
  ASSERT_TRUE(r.session);
  EXPECT_EQ(r.session->program, session().program);
  EXPECT_EQ(r.session->scene_hash, session().scene_hash);
  EXPECT_EQ(r.session->seeds, session().seeds);
  ASSERT_EQ(r.blobs.size(), blobs().size());
  for (size_t i = 0; i < r.blobs.size(); ++i) {
    EXPECT_EQ(r.blobs[i].name, blobs()[i].name);
    EXPECT_EQ(r.blobs[i].data, blobs()[i].data);
  }
  EXPECT_EQ(r.blob(BlobKind::mesh, "face.obj")->data.size(), 10'000u);
  const std::vector<Sample> want = stream(300);
  ASSERT_EQ(r.samples.size(), want.size());
  for (size_t i = 0; i < want.size(); ++i) EXPECT_TRUE(same(r.samples[i], want[i])) << i;
  ASSERT_EQ(r.checkpoints.size(), 3u);
  EXPECT_EQ(r.checkpoints[1].hash, uint64_t(200) << 40);
  ASSERT_EQ(r.states.size(), 3u);
  StateDifference none;
  for (const StateSample& s : r.states) add(none, state(s.step), s);
  EXPECT_EQ(none.compared, 3);
  EXPECT_EQ(none.other_topology, 0);
  EXPECT_EQ(none.mm, 0);
  EXPECT_EQ(none.N, 0);
  ASSERT_TRUE(r.end);
  EXPECT_EQ(r.end->hash, 77u);
  EXPECT_EQ(r.end->events, r.events - 1);
}

TEST(Recording, StatesThatCannotBeAreRefused) {
  TemporaryFolder dir;
  const auto wrong = [&](auto change) {
    RecordingWriter w;
    w.open(dir / "s.lcm", session(), {}, true);
    w.state(state(4));
    StateSample s = state(5);
    change(s);
    w.state(s);
    w.finish(9, 1);
    const Recording r = read_recording(dir / "s.lcm");
    return r.states.size() == 1 && r.damage.total() == 1;
  };
  EXPECT_FALSE(wrong([](StateSample&) {}));
  EXPECT_TRUE(wrong([](StateSample& s) { s.step = 4; }));
  EXPECT_TRUE(wrong([](StateSample& s) { s.vertices = 5; }));
  EXPECT_TRUE(wrong([](StateSample& s) { s.at_mm[3][1] = std::nanf(""); }));
  EXPECT_TRUE(wrong([](StateSample& s) { s.hooks_N = 1 / 0.0f; }));
}

TEST(Recording, HowFarTwoStatesAreApart) {
  StateDifference d;
  StateSample a = state(1), b = state(1);
  b.at_mm[7][0] += 3, b.at_mm[7][2] += 4, b.sutures_N -= 0.5f;
  add(d, a, b);
  EXPECT_NEAR(d.mm, 5, 1e-5);
  EXPECT_EQ(d.N, 0.5);
  b.topology ^= 1;
  add(d, a, b);
  EXPECT_EQ(d.compared, 2);
  EXPECT_EQ(d.other_topology, 1);
}

TEST(Recording, MessagesAreThoseOfTheirDefinitions) {
  // Bytes by hand: prefix, three and four doubles, two integers, all big-endian, after the fingerprint.
  MessageBytes bytes;
  const size_t n = encode_message(to_message(stylus(5, 9, Vec3(1, 2, 3), true)), bytes);
  ASSERT_EQ(n, 8u + 4 + 8 + 8 + 8 + 4 + 24 + 32 + 4 + 4);
  EXPECT_EQ(get_big_endian<int32_t>(&bytes[8]), kSchemaVersion);
  EXPECT_EQ(get_big_endian<int64_t>(&bytes[12]), 5);
  EXPECT_EQ(get_big_endian<int64_t>(&bytes[20]), 9);
  EXPECT_EQ(get_big_endian<uint64_t>(&bytes[40]), 0x3FF0000000000000ull);  // 1.0
  EXPECT_EQ(bytes[n - 5], 1);
  // CRC-32 of "123456789" is 0xCBF43926 in every catalogue of checksums.
  EXPECT_EQ(checksum(reinterpret_cast<const uint8_t*>("123456789"), 9), 0xCBF43926u);
}

TEST(Recording, EveryBitOfASampleIsGuarded) {
  MessageBytes bytes;
  const size_t n = encode_message(to_message(stylus(5, 9, Vec3(1, 2, 3), true)), bytes);
  for (size_t bit = 0; bit < 8 * n; ++bit) {
    MessageBytes b = bytes;
    b[bit / 8] ^= uint8_t(1u << bit % 8);
    limberg_msg::stylus_t m;
    EXPECT_NE(decode_message(b.data(), n, m), nullptr) << bit;
  }
  limberg_msg::stylus_t m;
  for (size_t k = 0; k < n; ++k) EXPECT_NE(decode_message(bytes.data(), k, m), nullptr);
  EXPECT_NE(decode_message(bytes.data(), n + 1, m), nullptr);
  EXPECT_EQ(decode_message(bytes.data(), n, m), nullptr);
}

TEST(Recording, NumbersThatCannotBeAreRefused) {
  auto wrong = [](auto change) {
    StylusSample s = stylus(5, 9, Vec3(1, 2, 3)), out;
    change(s);
    return to_sample(to_message(s), out) != nullptr;
  };
  EXPECT_FALSE(wrong([](StylusSample&) {}));
  EXPECT_TRUE(wrong([](StylusSample& s) { s.tip_mm.y() = std::nan(""); }));
  EXPECT_TRUE(wrong([](StylusSample& s) { s.tip_mm.z() = INFINITY; }));
  EXPECT_TRUE(wrong([](StylusSample& s) { s.tip_mm.x() = 1e5; }));
  EXPECT_TRUE(wrong([](StylusSample& s) { s.quat = {0.9, 0, 0, 0}; }));
  EXPECT_TRUE(wrong([](StylusSample& s) { s.quat[2] = std::nan(""); }));
  EXPECT_TRUE(wrong([](StylusSample& s) { s.seq = -1; }));
  EXPECT_TRUE(wrong([](StylusSample& s) { s.t_ns = INT64_MAX; }));
  auto wrong_control = [](auto change) {
    ControlSample s, out;
    change(s);
    return to_sample(to_message(s), out) != nullptr;
  };
  EXPECT_FALSE(wrong_control([](ControlSample&) {}));
  EXPECT_TRUE(wrong_control([](ControlSample& s) { s.kind = ControlSample::kLastKind + 1; }));
  EXPECT_TRUE(wrong_control([](ControlSample& s) { s.tool = Tool(-1); }));
  EXPECT_TRUE(wrong_control([](ControlSample& s) { s.value[1] = -INFINITY; }));
  EXPECT_TRUE(wrong_control([](ControlSample& s) { s.text.c[0] = '\n'; }));
}

TEST(Recording, OneBadSampleCostsOneSample) {
  TemporaryFolder dir;
  std::vector<uint8_t> b = recording_bytes(dir, 300);
  LogReader log(b);
  LogEvent e;
  size_t at = 0;
  for (int i = 0; log.next(e);)
    if (e.channel == kStylusChannel && ++i == 100) at = size_t(e.offset) + LogReader::kHeader + e.channel.size() + 50;
  b[at] ^= 8;
  const Recording r = read_recording(b, "b");
  EXPECT_EQ(r.samples.size(), stream(300).size() - 1);
  EXPECT_EQ(r.damage.bad_payload, 1);
  EXPECT_EQ(r.damage.stream_gaps, 1);
  EXPECT_NE(r.damage.first_message.find("LIMBERG_STYLUS: wrong checksum"), std::string::npos) << r.damage.first_message;
}

// Found by `limberg bench fuzz --devices`: damage that empties the first message's checksum (0: not given) and raises
// its number put every later sample out of order, and the whole recording was lost for one message.
TEST(Recording, ABadFirstSampleThatSaysItHasNoChecksumCostsOneSample) {
  TemporaryFolder dir;
  std::vector<uint8_t> b = recording_bytes(dir, 300);
  LogReader log(b);
  LogEvent e;
  while (log.next(e) && e.channel != kStylusChannel) {
  }
  const size_t payload = size_t(e.offset) + LogReader::kHeader + e.channel.size();
  b[payload + 12 + 3] ^= 8;  // of the number, behind fingerprint and version
  std::fill_n(b.begin() + long(payload + e.size - 4), 4, uint8_t(0));
  const Recording r = read_recording(b, "b");
  EXPECT_EQ(r.samples.size(), stream(300).size() - 1);
  EXPECT_EQ(r.damage.bad_payload, 1);
  EXPECT_EQ(r.damage.out_of_order, 0);
}

TEST(Recording, RepeatedAndReversedSamplesAreOutOfOrder) {
  TemporaryFolder dir;
  RecordingWriter w;
  w.open(dir / "r.lcm", session(), {});
  for (int64_t seq : {0, 1, 1, 0, 2, 5}) w.on_sample(stylus(seq, seq * 1000, Vec3(0, 0, 0)));
  w.on_sample(stylus(6, 10, Vec3(0, 0, 0)));  // back in time
  w.finish(1, 1);
  const Recording r = read_recording(dir / "r.lcm");
  EXPECT_EQ(r.samples.size(), 4u);
  EXPECT_EQ(r.damage.out_of_order, 3);
  EXPECT_EQ(r.damage.stream_gaps, 2);
}

// Found by libFuzzer: the samples that many streams lack added up beyond 2^63.
TEST(Recording, NumbersThatLeapInEveryStreamAddUpToANumber) {
  TemporaryFolder dir;
  RecordingWriter w;
  w.open(dir / "r.lcm", session(), {});
  for (int32_t device : {1, 2, 3})
    for (const int64_t seq : {int64_t{0}, INT64_MAX - 1}) {
      StylusSample s = stylus(seq, seq == 0 ? 0 : 1000, Vec3(0, 0, 0));
      s.device_id = device;
      w.on_sample(s);
    }
  w.finish(1, 1);
  const Recording r = read_recording(dir / "r.lcm");
  EXPECT_EQ(r.samples.size(), 6u);
  EXPECT_EQ(r.damage.stream_gaps, 3'000'000'000);
}

TEST(Recording, ForeignChannelsAreSkipped) {
  TemporaryFolder dir;
  LogWriter w;
  w.open(dir / "a.lcm");
  MessageBytes bytes;
  const uint8_t other[] = {1, 2, 3};
  const int64_t start = 77'123'456'789;
  for (int i = 0; i < 10; ++i) {
    w.write(i, "CAMERA", other, 3);
    w.write(i, kStylusChannel, bytes.data(), encode_message(to_message(stylus(i, start + i, Vec3(0, 0, 0))), bytes));
  }
  w.close();
  const Recording r = read_recording(dir / "a.lcm");
  EXPECT_EQ(r.samples.size(), 10u);
  EXPECT_EQ(r.damage.unknown_channel, 10);
  EXPECT_EQ(r.damage.total(), 0);
  EXPECT_FALSE(r.session);
  EXPECT_EQ(std::get<StylusSample>(r.samples[3]).t_ns,
            456'789 + 3);  // a plain stream counts from its first millisecond
}

// A sample whose channel was hit is lost like any other, and said to be.
TEST(Recording, InASessionANameThatNobodyKnowsIsDamage) {
  TemporaryFolder dir;
  RecordingWriter w;
  w.open(dir / "r.lcm", session(), blobs(), true);
  for (int i = 0; i < 20; ++i) w.on_sample(stylus(i, 1000 + i, Vec3(0, 0, 0)));
  w.finish(100, 1);
  std::ifstream in(dir / "r.lcm", std::ios::binary);
  std::vector<uint8_t> bytes((std::istreambuf_iterator<char>(in)), {});
  ASSERT_EQ(read_recording(bytes, "r").damage.total(), 0);
  const std::string name(kStylusChannel);
  const auto hit = std::search(bytes.begin(), bytes.end(), name.begin(), name.end());
  ASSERT_NE(hit, bytes.end());
  hit[3] = 'X';
  const Recording r = read_recording(bytes, "r");
  EXPECT_EQ(r.damage.total(), 1);
  EXPECT_FALSE(r.damage.first_message.empty());
}

TEST(Recording, NothingValidIsAnInputError) {
  EXPECT_THROW(read_recording(std::vector<uint8_t>{}, "empty"), InputError);
  EXPECT_THROW(read_recording(std::vector<uint8_t>(100, 0xED), "rubbish"), InputError);
  EXPECT_THROW(read_recording("/no/such/file"), InputError);
}

TEST(Recording, AFullDiskIsReportedOnce) {
  RecordingWriter w;
  w.open("/dev/full", session(), {}, true);
  for (const Sample& s : stream(200)) w.on_sample(s);
  EXPECT_FALSE(w.finish(1, 1));
  EXPECT_NE(w.error().find("cannot be written"), std::string::npos);
}

TEST(Recording, ADiskThatFillsUpKeepsWholeEvents) {
  TemporaryFolder dir;
  std::string error;
  {
    const SmallFiles no_room(20'001);
    RecordingWriter w;
    w.open(dir / "r.lcm", session(), {});
    for (const Sample& s : stream(500)) w.on_sample(s);
    EXPECT_FALSE(w.finish(1, 1));
    error = w.error();
  }
  EXPECT_NE(error.find("events before that are kept"), std::string::npos) << error;
  const Recording r = read_recording(dir / "r.lcm");
  EXPECT_EQ(r.damage.total(), 0) << r.damage.first_message;
  EXPECT_GT(r.samples.size(), 100u);
  EXPECT_FALSE(r.end);
}

TEST(Recording, ADiskThatHasRoomAgainLosesNothing) {
  TemporaryFolder dir;
  RecordingWriter w;
  w.open(dir / "r.lcm", session(), {});
  const std::vector<Sample> all = stream(500);
  {
    const SmallFiles no_room(20'001);
    for (size_t i = 0; i < 300; ++i) w.on_sample(all[i]);
    w.flush();
    EXPECT_NE(w.error().find("events before that are kept"), std::string::npos) << w.error();
    EXPECT_FALSE(w.given_up());
  }
  for (size_t i = 300; i < all.size(); ++i) w.on_sample(all[i]);
  EXPECT_TRUE(w.finish(1, 1)) << w.error();
  const Recording r = read_recording(dir / "r.lcm");
  EXPECT_EQ(r.damage.total(), 0) << r.damage.first_message;
  EXPECT_EQ(r.samples.size(), all.size());
  EXPECT_TRUE(r.end);
}

TEST(Recording, OneWhoseFolderIsRemovedIsMadeAgain) {
  TemporaryFolder dir;
  const std::string folder = dir / "out";
  std::filesystem::create_directory(folder);
  RecordingWriter w;
  w.open(folder + "/r.lcm", session(), {});
  const std::vector<Sample> all = stream(500);
  for (size_t i = 0; i < all.size(); ++i) {
    w.on_sample(all[i]);
    if (i == 250) std::filesystem::remove_all(folder);
  }
  // It is back before the session ends: whatever kills that costs no more than it would have.
  EXPECT_GT(read_recording(folder + "/r.lcm").samples.size(), 450u);
  EXPECT_TRUE(w.finish(1, 1)) << w.error();
  EXPECT_EQ(w.path(), folder + "/r.lcm");
  const Recording r = read_recording(w.path());
  EXPECT_EQ(r.damage.total(), 0) << r.damage.first_message;
  EXPECT_EQ(r.samples.size(), all.size());
}

TEST(Recording, TheOneThatWasLeftIsFoundAndNoOther) {
  TemporaryFolder dir;
  const auto write = [&](const std::string& name, int samples, int64_t utc_ns, bool ends, uint64_t goes_on_with = 0) {
    SessionInfo info = session();
    info.utc_start_ns = utc_ns, info.seeds[SessionInfo::kGoesOnWith] = goes_on_with;
    RecordingWriter w;
    w.open(dir / name, info, {}, true);
    for (const Sample& s : stream(samples)) w.on_sample(s);
    ends ? w.finish(100'000, 1) : w.cut_short();
  };
  write("whole.lcm", 300, 1'000'000'000, true);
  EXPECT_FALSE(unfinished_recording(dir / "whole.lcm"));
  EXPECT_FALSE(longest_unfinished(dir / ""));
  write("left.lcm", 200, 2'000'000'000, false);
  write("shorter.lcm", 50, 3'000'000'000, false);
  const auto left = longest_unfinished(dir / "");
  ASSERT_TRUE(left);
  EXPECT_EQ(std::filesystem::path(left->file).filename(), "left.lcm");
  EXPECT_NEAR(left->length_s, double(time_of(stream(200).back())) * 1e-9, 1e-3);
  // Somebody has gone on with it.
  write("left-2.lcm", 250, 2'000'000'000, true, recording_mark(left->file));
  const auto next = longest_unfinished(dir / "");
  ASSERT_TRUE(next);
  EXPECT_EQ(std::filesystem::path(next->file).filename(), "shorter.lcm");
  // One that is being written is left by nobody.
  RecordingWriter w;
  w.open(next->file, session(), {}, true);
  w.flush();
  EXPECT_FALSE(unfinished_recording(next->file));
  EXPECT_FALSE(longest_unfinished(dir / ""));
}

TEST(ContinuedSource, CountsOnAndLetsGo) {
  StylusSample pressed;
  pressed.device_id = 100, pressed.seq = 41, pressed.t_ns = 900, pressed.buttons = 3;
  ControlSample control;
  control.device_id = 7, control.seq = 5;
  const auto earlier = std::make_shared<EarlierPart>(std::vector<Sample>{control, pressed}, 5000);
  ASSERT_EQ(earlier->let_go().size(), 1u);
  const auto released = std::get<StylusSample>(earlier->let_go()[0]);
  EXPECT_EQ(released.buttons, 0u);
  EXPECT_EQ(released.seq, 42);
  EXPECT_EQ(released.t_ns, 5000);
  EXPECT_EQ(released.device_id, 100);
  // Another stylus takes its place; a third device stays what it is.
  StylusSample first, second;
  first.device_id = 400, first.seq = 9, first.t_ns = 10;
  second = first, second.seq = 12, second.t_ns = 20;
  StylusSample other = first;
  other.device_id = 500;
  control.seq = 0, control.t_ns = 15;
  ContinuedSource source(std::make_unique<LogSource>(std::vector<Sample>{first, control, second, other}), earlier);
  struct : SampleSink {
    std::vector<Sample> got;
    void on_sample(const Sample& s) override { got.push_back(s); }
  } sink;
  source.poll(4999, sink);
  EXPECT_TRUE(sink.got.empty());
  source.poll(5100, sink);
  ASSERT_EQ(sink.got.size(), 4u);
  std::vector<Sample> all{Sample(pressed), earlier->let_go()[0]};
  std::map<std::pair<int, int32_t>, StreamOrder> order;
  int64_t gap = 0;
  all.insert(all.end(), sink.got.begin(), sink.got.end());
  int same_stylus = 0;
  for (const Sample& s : all)
    std::visit(
        [&](const auto& v) {
          EXPECT_TRUE((order[{stream_of(v), v.device_id}].accept(v.seq, v.t_ns, gap)));
          same_stylus += stream_of(v) == 0 && v.device_id == 100;
        },
        s);
  EXPECT_EQ(same_stylus, 4);
  EXPECT_EQ(time_of(sink.got.back()), 5020);
  EXPECT_EQ(order.size(), 3u);
}

TEST(Recording, HostileBytesNeverDoHarm) {
  TemporaryFolder dir;
  const std::vector<uint8_t> good = [&] {
    RecordingWriter w;
    w.open(dir / "s.lcm", session(), {{BlobKind::scene, "s", "x"}});
    for (const Sample& s : stream(12)) w.on_sample(s);
    w.checkpoint(1, 2);
    w.finish(3, 4);
    return bytes_of(dir / "s.lcm");
  }();
  // Keep the big chunk out of most of the work: mutations go to the headers and to everything else.
  Dice dice{2024};
  int64_t read = 0, refused = 0;
  for (int k = 0; k < 100'000; ++k) {
    std::vector<uint8_t> b = good;
    switch (k % 5) {
      case 0:  // bits
        for (size_t i = 0, n = 1 + dice.below(8); i < n; ++i) b[dice.below(b.size())] ^= uint8_t(1u << dice.below(8));
        break;
      case 1:  // cut
        b.resize(dice.below(b.size() + 1));
        break;
      case 2: {  // a word of extremes
        static constexpr uint32_t extreme[] = {0,          1,          0x7FFFFFFF, 0x80000000,
                                               0xFFFFFFFF, 0x10000002, 0xEDA1DA01, 0x00010000};
        const size_t at = dice.below(b.size() - 4);
        put_big_endian<uint32_t>(&b[at], extreme[dice.below(8)]);
        break;
      }
      case 3: {  // a piece moved over another
        const size_t n = 1 + dice.below(400), from = dice.below(b.size() - n), to = dice.below(b.size() - n);
        std::memmove(&b[to], &b[from], n);
        break;
      }
      default: {  // a piece out, random bytes in
        const size_t n = 1 + dice.below(200), at = dice.below(b.size() - n);
        b.erase(b.begin() + long(at), b.begin() + long(at + n));
        for (size_t i = 0, m = dice.below(60); i < m; ++i) b.insert(b.begin() + long(at), uint8_t(dice.next()));
      }
    }
    try {
      const Recording r = read_recording(std::move(b), "mutant");
      ++read;
      ASSERT_LE(r.samples.size(), 14u);
      for (const Sample& s : r.samples) {
        const auto* p = std::get_if<StylusSample>(&s);
        ASSERT_TRUE(!p || p->tip_mm.allFinite());
      }
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_EQ(read + refused, 100'000);
  EXPECT_GT(read, 80'000);
}

TEST(Recording, SaysWhenItsTickZeroWas) {
  const TemporaryFolder dir;
  constexpr int64_t opened_ns = 1'700'000'000'000'000'000, began_ns = opened_ns + 4'000'000'000;
  SessionInfo s = session();
  s.utc_start_ns = opened_ns;
  RecordingWriter w;
  w.open(dir / "r.lcm", s, blobs(), true);
  w.began(began_ns);  // the patient was built meanwhile
  for (const Sample& sample : stream(10)) w.on_sample(sample);
  EXPECT_TRUE(w.finish(100, 1));
  const Recording r = read_recording(dir / "r.lcm");
  ASSERT_TRUE(r.session);
  EXPECT_EQ(r.session->utc_start_ns, began_ns);
  EXPECT_EQ(r.session->scene_hash, s.scene_hash);
  EXPECT_EQ(r.damage.total(), 0);
  ASSERT_TRUE(r.end);
  EXPECT_EQ(r.blobs.size(), blobs().size());
  LogReader log(dir / "r.lcm");
  int64_t last = 0;
  for (LogEvent e; log.next(e);) {
    EXPECT_GE(e.time_us, last);
    last = e.time_us;
    if (e.channel == kStylusChannel) {
      EXPECT_GE(e.time_us, began_ns / 1000);
    }
  }
}

// A replay goes on until the end mark's tick: one of a few bytes must not keep it for ever.
TEST(Recording, NothingIsLaterThanADay) {
  const TemporaryFolder dir;
  for (const int64_t end : {kMostTicks, kMostTicks + 1, int64_t(1) << 62}) {
    RecordingWriter w;
    w.open(dir / "r.lcm", session(), blobs(), true);
    for (const Sample& sample : stream(10)) w.on_sample(sample);
    w.checkpoint(20, 7), w.checkpoint(end, 8);
    EXPECT_TRUE(w.finish(end, 1));
    const Recording r = read_recording(dir / "r.lcm");
    const bool fits = end == kMostTicks;
    EXPECT_EQ(r.end.has_value(), fits) << end;
    EXPECT_EQ(r.checkpoints.size(), fits ? 2u : 1u);
    EXPECT_EQ(r.damage.bad_payload, fits ? 0 : 2);
  }
}

TEST(Recording, RandomBytesAreRefusedQuickly) {
  Dice dice{5};
  for (int k = 0; k < 2000; ++k) {
    std::vector<uint8_t> b(1 + dice.below(2000));
    for (uint8_t& v : b) v = uint8_t(dice.next());
    if (k % 2) put_big_endian<uint32_t>(b.data(), b.size() > 4 ? LogReader::kSync : 0);
    EXPECT_THROW(read_recording(std::move(b), "random"), InputError);
  }
}

TEST(LogSource, HandsOverWhatIsDueAndNoMore) {
  struct Count final : SampleSink {
    void on_sample(const Sample& s) override {
      last = std::visit([](auto& v) { return v.t_ns; }, s), ++n;
    }
    int64_t n = 0, last = 0;
  } sink;
  LogSource source(stream(100), 3);
  int64_t before = 0;
  for (int64_t tick = 0; !source.done(); ++tick) {
    source.poll(tick * 1'000'000, sink);
    EXPECT_LE(sink.last, tick * 1'000'000);
    EXPECT_LE(sink.n - before, 2);
    before = sink.n;
    ASSERT_LT(tick, 1000);
  }
  EXPECT_EQ(sink.n, 102);
  EXPECT_EQ(source.counts().malformed, 3);
}

}  // namespace test_recording
}  // namespace limberg
