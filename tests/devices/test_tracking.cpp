// Tracking against a known motion: minimum-jerk reaches with tremor, seen at 120 Hz with noise.
#include <gtest/gtest.h>

#include "devices/tracking.h"
#include "tests/devices/samples.h"

namespace limberg {
namespace test_tracking {

using namespace test;

/// Where the tip truly is: quick reaches of up to 150 mm in 0.4 s with rests of 0.2 s, and a 9.5 Hz tremor.
Vec3 truth(double t) {
  static const std::vector<Vec3> goals = [] {
    Dice dice{17};
    std::vector<Vec3> g;
    for (int i = 0; i < 128; ++i) g.push_back(Vec3(dice.unit(), dice.unit(), dice.unit()) * 85);
    return g;
  }();
  const int k = int(t / 0.6);
  const double s = std::min(1.0, (t - 0.6 * k) / 0.4), blend = s * s * s * (10 - 15 * s + 6 * s * s);
  const double tremor = 0.1 * std::sin(2 * M_PI * 9.5 * t);
  return goals[size_t(k)] + blend * (goals[size_t(k) + 1] - goals[size_t(k)]) + Vec3(tremor, 0.7 * tremor, -tremor);
}

StylusSample reading(int i, double rate_hz, double noise_mm, Dice& dice) {
  const int64_t t_ns = int64_t(i * 1e9 / rate_hz);
  StylusSample s = stylus(i, t_ns, truth(double(t_ns) * 1e-9));
  s.tip_mm += noise_mm * Vec3(dice.normal(), dice.normal(), dice.normal());
  return s;
}

struct Figures {
  double rms_mm = 0, lag_ms = 0, max_step_mm = 0;
};

/// Runs 40 s. `delivery_ms`: a reading arrives so long after it was true; the stamp says when it was true.
Figures run(double noise_mm, double delivery_ms) {
  Calibration c;
  c.filter.measurement_noise_mm = noise_mm;
  StylusTracker tracker(c);
  Dice dice{4};
  int next = 0;
  std::vector<Vec3> seen;
  for (int tick = 0; tick < 40'000; ++tick) {
    while (next * 1e3 / 120 + delivery_ms <= tick) tracker.add(reading(next++, 120, noise_mm, dice));
    seen.push_back(tracker.at(int64_t(tick) * 1'000'000).tip_mm);
  }
  auto rms_at = [&](double lag_ms) {
    double sum = 0;
    for (int tick = 1000; tick < 39'900; ++tick)
      sum += (seen[size_t(tick)] - truth((tick - lag_ms) * 1e-3)).squaredNorm();
    return std::sqrt(sum / 38'900);
  };
  Figures f;
  f.rms_mm = rms_at(0);
  double best = 1e9;
  for (double lag = -5; lag <= 30; lag += 0.25)
    if (const double e = rms_at(lag); e < best) best = e, f.lag_ms = lag;
  for (size_t i = 1001; i < seen.size(); ++i) f.max_step_mm = std::max(f.max_step_mm, (seen[i] - seen[i - 1]).norm());
  return f;
}

TEST(Tracking, ErrorAndLagAgainstTheTruth) {
  // Predict-then-smooth filters of this kind reach 0.40 mm RMS and 2 ms of lag on such reaches with 0.05 mm of noise
  // and readings 8.3 ms old; with 0.3 mm of noise the noise itself, 0.52 mm over three axes, adds to that.
  const Figures fresh = run(0.05, 0), old = run(0.05, 8.3), noisy = run(0.3, 8.3);
  for (const auto& [name, f] : {std::pair{"fresh", fresh}, {"8.3 ms old", old}, {"8.3 ms old, 0.3 mm noise", noisy}})
    std::printf("  %-26s rms %.3f mm  lag %.2f ms  largest step %.2f mm\n", name, f.rms_mm, f.lag_ms, f.max_step_mm);
  EXPECT_LT(fresh.rms_mm, 0.40);
  EXPECT_LT(old.rms_mm, 0.50);
  EXPECT_LT(noisy.rms_mm, 0.50 + 0.52);
  for (const Figures& f : {fresh, old, noisy}) {
    EXPECT_LE(std::abs(f.lag_ms), 3);
    EXPECT_LT(f.max_step_mm, 1.35);  // the truth makes steps of up to 0.5 mm
  }
}

TEST(Tracking, AtRestTheNoiseIsReduced) {
  Calibration c;
  StylusTracker tracker(c);
  Dice dice{8};
  double sum = 0;
  int n = 0;
  for (int tick = 0; tick < 10'000; ++tick) {
    if (tick % 8 == 0) {
      const Vec3 noise = 0.05 * Vec3(dice.normal(), dice.normal(), dice.normal());
      tracker.add(stylus(tick / 8, int64_t(tick) * 1'000'000, Vec3(10, 20, 30) + noise));
    }
    const Vec3 p = tracker.at(int64_t(tick) * 1'000'000).tip_mm;
    if (tick > 1000) sum += (p - Vec3(10, 20, 30)).squaredNorm(), ++n;
  }
  EXPECT_LT(std::sqrt(sum / n / 3), 0.05);
}

TEST(Tracking, OrientationFollowsATurn) {
  StylusTracker tracker{Calibration{}};
  double worst = 0;
  for (int tick = 0; tick < 4000; ++tick) {
    auto at = [](double t) {
      return Eigen::Quaterniond(Eigen::AngleAxisd(2 * std::sin(t), Vec3(1, 2, 2).normalized()));
    };
    if (tick % 8 == 0) {
      StylusSample s = stylus(tick / 8, int64_t(tick) * 1'000'000, Vec3::Zero());
      const Eigen::Quaterniond q = at(tick * 1e-3);
      const double sign = tick % 16 ? -1 : 1;  // q and -q are the same rotation
      s.quat = {sign * q.w(), sign * q.x(), sign * q.y(), sign * q.z()};
      tracker.add(s);
    }
    const Pose p = tracker.at(int64_t(tick) * 1'000'000);
    if (tick > 200) worst = std::max(worst, p.orientation.angularDistance(at(tick * 1e-3)));
    EXPECT_NEAR(p.shaft.norm(), 1, 1e-9);
  }
  EXPECT_LT(worst, 0.03);  // 2 rad/s with about 10 ms of lag
  EXPECT_EQ(tracker.counts().jumps, 0);
}

TEST(Tracking, CalibrationMovesTipAndFrame) {
  Calibration c;
  c.tip_offset_mm = Vec3(0, 0, -130);
  c.world_from_tracker_mm = Vec3(10, 20, 30);
  const double h = std::sqrt(0.5);
  c.world_from_tracker_quat = {h, 0, 0, h};  // a quarter turn about z
  StylusTracker tracker(c);
  StylusSample s = stylus(0, 0, Vec3(1, 2, 3));
  s.quat = {h, h, 0, 0};  // a quarter turn about x: sensor -z becomes tracker +y
  tracker.add(s);
  const Pose p = tracker.at(0);
  // In the tracker: (1, 2 + 130, 3); turned about z: (-132, 1, 3); moved.
  EXPECT_LT((p.tip_mm - Vec3(-122, 21, 33)).norm(), 1e-9);
  EXPECT_TRUE(p.valid);
}

TEST(Tracking, SilenceMakesThePoseInvalid) {
  StylusTracker tracker{Calibration{}};
  EXPECT_FALSE(tracker.at(0).valid);
  for (int i = 0; i < 20; ++i) tracker.add(stylus(i, int64_t(i) * 8'000'000 + 1, Vec3(i, 0, 0)));
  const int64_t last = 19 * 8'000'000;
  EXPECT_TRUE(tracker.at(last + 99'000'000).valid);
  const Pose p = tracker.at(last + 102'000'000);
  EXPECT_FALSE(p.valid);
  EXPECT_LT(p.tip_mm.x(), 19 + 1000.0 / 8 * 0.026);  // never extrapolated further than the limit
  // Coming back elsewhere after a gap is a fresh start there, with no swing.
  tracker.add(stylus(20, last + 300'000'000, Vec3(50, 0, 0)));
  EXPECT_LT((tracker.at(last + 300'000'000).tip_mm - Vec3(50, 0, 0)).norm(), 1e-9);
  EXPECT_EQ(tracker.counts().restarts, 1);
}

TEST(Tracking, OutliersAreLeftOutButAMoveIsBelievedInTheEnd) {
  StylusTracker tracker{Calibration{}};
  int64_t t = 0;
  int64_t seq = 0;
  double worst = 0;
  for (int i = 0; i < 200; ++i, t += 8'333'333) {
    const bool outlier = i % 20 == 13;
    tracker.add(stylus(seq++, t, outlier ? Vec3(500, 0, 0) : Vec3(0, 0, 0)));
    worst = std::max(worst, tracker.at(t).tip_mm.norm());
  }
  EXPECT_EQ(tracker.counts().jumps, 10);
  EXPECT_LT(worst, 1e-6);
  for (int i = 0; i < 10; ++i, t += 8'333'333) tracker.add(stylus(seq++, t, Vec3(500, 0, 0)));
  EXPECT_LT((tracker.at(t).tip_mm - Vec3(500, 0, 0)).norm(), 1.0);
}

TEST(Tracking, RepeatedAndOlderReadingsAreCounted) {
  StylusTracker tracker{Calibration{}};
  tracker.add(stylus(5, 100, Vec3(0, 0, 0)));
  tracker.add(stylus(5, 200, Vec3(0, 0, 0)));
  tracker.add(stylus(6, 50, Vec3(0, 0, 0)));
  tracker.add(stylus(9, 8'000'000, Vec3(0, 0, 0)));
  EXPECT_EQ(tracker.counts().late, 2);
  EXPECT_EQ(tracker.counts().missing, 3);
}

}  // namespace test_tracking
}  // namespace limberg
