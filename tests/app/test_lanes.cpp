// Histograms: percentiles against sorted values, exact extremes,
// nothing outside. The render lane draws when a hand has moved.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "app/session/lanes.h"
#include "app/session/render_lane.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_lanes {

TEST(Histogram, PercentilesWithinABucket) {
  std::mt19937_64 rng(7);
  std::lognormal_distribution<double> dist(std::log(20'000.0), 2.0);
  auto h = std::make_unique<Histogram>();
  std::vector<int64_t> all;
  for (int i = 0; i < 20'000; ++i) all.push_back(int64_t(dist(rng))), h->add(all.back());
  std::sort(all.begin(), all.end());
  for (const double p : {0.0, 0.5, 0.95, 0.99, 0.999}) {
    const double exact = double(all[size_t(p * double(all.size()))]);
    // A bucket spans 1/32 of its lower end: the upper end is reported.
    EXPECT_GE(double(h->percentile_ns(p)), exact) << p;
    EXPECT_LE(double(h->percentile_ns(p)), exact * (1 + 1.0 / 32) + 1) << p;
  }
  EXPECT_EQ(h->max_ns(), all.back());
  EXPECT_EQ(h->percentile_ns(1.0), all.back());
  EXPECT_EQ(h->total(), 20'000u);
}

TEST(Histogram, SmallAndExtremeValues) {
  Histogram h;
  EXPECT_EQ(h.percentile_ns(0.5), 0);
  h.add(-5);
  EXPECT_EQ(h.percentile_ns(0.5), 0);
  h.add(31), h.add(32), h.add(int64_t(1) << 60);
  EXPECT_EQ(h.percentile_ns(0.25), 31);
  EXPECT_EQ(h.percentile_ns(0.5), 32);
  EXPECT_EQ(h.max_ns(), int64_t(1) << 60);
}

struct Hands final : PictureSink {
  void second_hand(const SecondHand& hand, const SecondHand& second) override { glove = hand, other = second; }
  void frame(const Snapshot&, const ToolState&) override { ++frames; }
  void stage(const std::string&, const Snapshot&) override {}
  SecondHand glove, other;
  void same_frame() override { ++same; }
  int frames = 0, same = 0;
};

TEST(RenderLane, DrawsAgainWhenTheGloveHasMoved) {
  auto channels = std::make_unique<Channels>();
  Hands sink;
  RenderLane lane(*channels, &sink, true);
  channels->patient_to_render.writing().snapshot = test::snapshot_of(test::flat_topology(2, 1));
  channels->patient_to_render.publish();
  HandState hand;
  const auto drawn = [&] {
    const int before = sink.frames;
    channels->hand_to_render.writing() = hand, channels->hand_to_render.publish();
    lane.frame();
    return sink.frames - before;
  };
  EXPECT_EQ(drawn(), 1);  // the patient
  hand.glove.forefinger_mm[0] = 7;
  EXPECT_EQ(drawn(), 0) << "there is no glove";
  hand.glove.valid = 1;
  EXPECT_EQ(drawn(), 1);
  EXPECT_EQ(sink.glove.forefinger_mm[0], 7);
  EXPECT_EQ(drawn(), 0);
  hand.glove.forefinger_mm[1] += 0.01;
  EXPECT_EQ(drawn(), 0) << "cannot be seen";
  hand.glove.thumb_mm[2] += 0.1;
  EXPECT_EQ(drawn(), 1);
  hand.other_glove.valid = 1, hand.other_glove.thumb_mm[0] = 3;
  EXPECT_EQ(drawn(), 1);
  EXPECT_EQ(sink.other.thumb_mm[0], 3);
  hand.glove.pointed_mm[2] += 5;
  EXPECT_EQ(drawn(), 0) << "it points at nothing";
  hand.glove.points = 1;
  EXPECT_EQ(drawn(), 1);
  hand.glove.pointing[1] = 0.01;
  EXPECT_EQ(drawn(), 1);
  hand.glove.closed = 1;
  EXPECT_EQ(drawn(), 1);
  hand.glove.valid = 0;
  EXPECT_EQ(drawn(), 1);
}

TEST(RenderLane, DrawsAgainWhenThePatientHasMovedVisibly) {
  auto channels = std::make_unique<Channels>();
  Hands sink;
  RenderLane lane(*channels, &sink, true);
  Snapshot patient = test::snapshot_of(test::flat_topology(2, 1));
  const auto drawn = [&] {
    const int before = sink.frames;
    channels->patient_to_render.writing().snapshot = patient, channels->patient_to_render.publish();
    lane.frame();
    return sink.frames - before;
  };
  EXPECT_EQ(drawn(), 1);
  EXPECT_EQ(drawn(), 0);
  patient.x_mm[1].z() += 0.5f * float(kVisible_mm);
  EXPECT_EQ(drawn(), 0) << "cannot be seen";
  patient.x_mm[1].z() += 0.8f * float(kVisible_mm);
  EXPECT_EQ(drawn(), 1) << "small motions add up";
  patient.sutures.emplace_back();
  EXPECT_EQ(drawn(), 1);
  EXPECT_EQ(sink.frames, 3);
  EXPECT_EQ(sink.same, 2) << "who keeps every frame hears of those that are not drawn";
}

}  // namespace test_lanes
}  // namespace limberg
