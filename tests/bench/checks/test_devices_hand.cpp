// The hand through emulator, line, stamps and filters against its truth.
#include <gtest/gtest.h>

#include "tests/bench/devices/hand.h"

namespace limberg::bench {
namespace test_devices_hand {

// Reference: a simulation of the same motion and noise, readings 60 times a second and 8.3 ms late, constant-velocity
// Kalman filter predicted to the tick and One-Euro filter behind it: 0.40 mm RMS, 2 ms, 1.35 mm from tick to tick
// (2026-11-21). Here the readings come through the line, with its times. Measured on that day: the default filter,
// which is made for quiet strokes, 0.53 mm at 2.0 ms and 0.94 mm; one that opens sooner 0.41 mm at 1.0 ms. The bars
// leave a tenth for another compiler's sines.
TEST(DevicesHand, ErrorAndLagAtSixtyHertzAStation) {
  const auto print = [](const char* name, const TrackingFigures& f) {
    std::printf("%-16s rms %.3f mm, lag %.1f ms, jitter %.3f mm, step %.2f mm, turn %.2f deg, %.1f Hz\n", name,
                f.rms_mm, f.lag_ms, f.jitter_mm, f.max_step_mm, f.turn_rms_deg, f.rate_hz);
  };
  const TrackingFigures f = tracking_trial({});
  print("60 Hz, default", f);
  EXPECT_NEAR(f.rate_hz, 60, 1.5);
  EXPECT_LE(f.rms_mm, 0.58);
  EXPECT_LE(f.lag_ms, 2.0);
  EXPECT_LE(f.jitter_mm, 0.06);
  EXPECT_LE(f.max_step_mm, 1.35);
  TrackingTrial open;
  open.filter.process_noise_mm2_s3 = 1e5, open.filter.euro_beta_per_mm = 2;
  const TrackingFigures g = tracking_trial(open);
  print("60 Hz, open", g);
  EXPECT_LE(g.rms_mm, 0.45);
  EXPECT_LE(g.lag_ms, 1.5);
  EXPECT_LE(g.max_step_mm, 1.5);  // 1.42 measured; the price of the shorter lag
  TrackingTrial one;
  one.two_stations = false;
  const TrackingFigures h = tracking_trial(one);
  print("120 Hz, default", h);
  EXPECT_LT(h.rms_mm, f.rms_mm);
}

// Without times of their own for the two stations, a moving hand would open and close by itself.
TEST(DevicesHand, TheDistanceOfTheTipsDoesNotDependOnMotion) {
  const double apart = 45;
  const fastrak::Motion swing = [&](int station, double t) {
    fastrak::StationPose p;  // 0.75 m/s along the line between the fingers
    p.pos_mm = Vec3(350, 120 * std::sin(2 * M_PI * t) + (station == 1 ? apart : 0), -100);
    return p;
  };
  fastrak::EmulatorSettings device;
  device.noise_mm = 0;
  fastrak::VirtualLine line(swing, {}, device);
  GloveTracker tracker{Calibration{}};
  double worst = 0, skew = 0;
  Vec3 last[2] = {Vec3::Zero(), Vec3::Zero()};
  for (int64_t tick = 0; tick < 5000; ++tick) {
    for (const TrackerSample& s : line.tick(tick)) tracker.add(s), last[s.station - 1] = s.pos_mm;
    const HandPose h = tracker.at(tick * 1'000'000);
    if (tick < 1500) continue;
    worst = std::max(worst, std::abs(h.aperture_mm - apart));
    skew = std::max(skew, std::abs((last[0] - last[1]).norm() - apart));
  }
  std::printf("distance off by %.2f mm at most, without stamps %.2f\n", worst, skew);
  EXPECT_GT(skew, 5.0);
  EXPECT_LT(worst, 2.0);
}

TEST(DevicesHand, AnHourOfIdleHandAndAThousandGrabs) {
  GrabTrial t;
  t.idle_s = 3600;
  const GrabFigures idle = grab_trial(t);
  std::printf("idle %.0f s: %lld false grabs, %lld readings, %lld damaged, least aperture %.1f mm\n", idle.idle_s,
              (long long)idle.false_grabs, (long long)idle.readings, (long long)idle.damaged, idle.least_aperture_mm);
  EXPECT_EQ(idle.false_grabs, 0);
  EXPECT_GT(idle.damaged, 500);
  GrabTrial g;
  g.grabs = 1000;
  g.seed = 3;
  const GrabFigures f = grab_trial(g);
  std::printf("grabs: %lld of %lld in time, %lld missed, %lld extra, median %.0f ms, worst %.0f ms\n",
              (long long)f.in_time, (long long)f.meant, (long long)f.missed, (long long)f.extra, f.median_ms,
              f.worst_ms);
  EXPECT_GE(f.in_time, 999);
  EXPECT_EQ(f.extra, 0);
}

}  // namespace test_devices_hand
}  // namespace limberg::bench
