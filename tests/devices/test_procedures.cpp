// Calibration procedures against known truth, and what they refuse.
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/distortion.h"
#include "calibration/glove_range.h"
#include "calibration/pivot.h"
#include "calibration/pointing.h"
#include "calibration/registration.h"
#include "devices/fastrak/virtual_line.h"
#include "devices/glove.h"
#include "devices/rehearsal.h"
#include "tests/devices/samples.h"

namespace limberg {
namespace test_procedures {

using test::Dice;

Vec3 normal3(Dice& d) { return {d.normal(), d.normal(), d.normal()}; }

/// The noise of a FASTRAK as its maker states it: 0.76 mm RMS in space, 0.15 degrees.
constexpr double kNoiseMm = 0.44, kNoiseRad = 0.15 * M_PI / 180 / 1.7320508;

std::vector<SensorPose> poses_of(const PivotRehearsal& r, double seconds, double noise_mm = kNoiseMm,
                                 double noise_rad = kNoiseRad) {
  fastrak::LinkSettings link;
  link.role = fastrak::parse_roles("s");
  fastrak::EmulatorSettings device;
  device.seed = r.seed * 31 + 1;
  device.noise_mm = noise_mm, device.noise_rad = noise_rad;
  std::vector<SensorPose> poses;
  for (const Sample& s : fastrak::readings_of(stylus_in_dimple(r), seconds, link, device))
    if (const auto* t = std::get_if<TrackerSample>(&s))
      poses.push_back({t->pos_mm, Eigen::Quaterniond(t->quat[0], t->quat[1], t->quat[2], t->quat[3])});
  return poses;
}

TEST(Pivot, TipIsFoundWithTheNoiseOfTheDevice) {
  double worst = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    PivotRehearsal r;
    r.seed = seed;
    const PivotResult got = calibrate_pivot(poses_of(r, 9), seed);
    EXPECT_TRUE(got.accepted) << got.advice;
    worst = std::max(worst, (got.tip_mm - r.tip_mm).norm());
    EXPECT_NEAR(got.residual_mm, 0.85, 0.12);  // 0.44 mm an axis and 0.15 degrees at 130 mm
    EXPECT_LT((got.dimple_mm - r.dimple_mm).norm(), 0.3);
    EXPECT_NEAR(got.cone_deg, r.cone_deg, 4);
  }
  EXPECT_LT(worst, 0.25);
}

TEST(Pivot, ExactWithoutNoise) {
  const PivotRehearsal r;
  const PivotResult got = calibrate_pivot(poses_of(r, 6, 0, 0));
  EXPECT_LT((got.tip_mm - r.tip_mm).norm(), 1e-3);  // float32 on the line
  EXPECT_LT(got.residual_mm, 1e-3);
}

TEST(Pivot, SlipsAreLeftOut) {
  PivotRehearsal r;
  r.slips_per_s = 0.8;
  const PivotResult got = calibrate_pivot(poses_of(r, 9));
  EXPECT_TRUE(got.accepted) << got.advice;
  EXPECT_LT(got.agreeing, got.poses);
  EXPECT_LT((got.tip_mm - r.tip_mm).norm(), 0.3);
}

TEST(Pivot, BadDataIsRefusedWithAdvice) {
  const auto advice = [](const PivotRehearsal& r, double seconds) {
    const PivotResult got = calibrate_pivot(poses_of(r, seconds));
    EXPECT_FALSE(got.accepted);
    return got.advice;
  };
  PivotRehearsal narrow, slips, plane;
  narrow.cone_deg = 15;
  slips.slips_per_s = 6;
  plane.one_plane = true;
  EXPECT_NE(advice(PivotRehearsal{}, 2).find("for longer"), std::string::npos);
  EXPECT_NE(advice(narrow, 9).find("tilt the stylus further"), std::string::npos);
  EXPECT_NE(advice(slips, 9).find("slipped"), std::string::npos);
  EXPECT_FALSE(calibrate_pivot({}).accepted);
  // Rocked about one axis: the tip along that axis is anyone's guess.
  std::vector<SensorPose> rocked;
  for (int i = 0; i < 300; ++i) {
    SensorPose p;
    p.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7 * std::sin(0.1 * i), Vec3::UnitX()));
    p.pos_mm = Vec3(300, 0, 0) - p.orientation * Vec3(5, -3, 130);
    rocked.push_back(p);
  }
  const PivotResult got = calibrate_pivot(rocked);
  EXPECT_FALSE(got.accepted);
  EXPECT_NE(got.advice.find("not determined"), std::string::npos) << got.advice;
}

std::vector<SensorPose> finger_poses(const fastrak::Motion& motion, int station, double seconds, uint64_t seed,
                                     double noise_mm = kNoiseMm, double noise_rad = kNoiseRad) {
  fastrak::EmulatorSettings device;
  device.seed = seed * 31 + 1;
  device.noise_mm = noise_mm, device.noise_rad = noise_rad;
  std::vector<SensorPose> poses;
  for (const Sample& s : fastrak::readings_of(motion, seconds, {}, device))
    if (const auto* t = std::get_if<TrackerSample>(&s); t && t->station == station)
      poses.push_back({t->pos_mm, Eigen::Quaterniond(t->quat[0], t->quat[1], t->quat[2], t->quat[3])});
  return poses;
}

// A finger's station has every second reading; its tip is near, so that the sensor's place is all the noise there is:
// three axes of 0.44 mm are 0.76 mm.
TEST(Pivot, AFingersTipIsFoundAndTooSmallATurnIsRefused) {
  PivotLimits limit;
  limit.what = "hand", limit.where = "place";
  for (const int station : {1, 2}) {
    double worst = 0;
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      PivotRehearsal r;
      r.seed = seed, r.tip_mm = station == 1 ? Vec3(17, 2, -8) : Vec3(15, -2, -9);
      const PivotResult got =
          calibrate_pivot(finger_poses(finger_on_place(r, station), station, 12, seed), seed, limit);
      EXPECT_TRUE(got.accepted) << got.advice;
      EXPECT_NEAR(got.residual_mm, 0.76, 0.08);
      worst = std::max(worst, (got.tip_mm - r.tip_mm).norm());
      EXPECT_LT((got.tip_mm - r.tip_mm).norm(), 4 * got.uncertainty_mm);
    }
    EXPECT_LT(worst, 0.3) << station;
  }
  PivotRehearsal narrow;
  narrow.tip_mm = {17, 2, -8}, narrow.cone_deg = 15;
  const PivotResult got = calibrate_pivot(finger_poses(finger_on_place(narrow, 1), 1, 12, 3), 3, limit);
  EXPECT_FALSE(got.accepted);
  EXPECT_NE(got.advice.find("tilt the hand to all sides"), std::string::npos) << got.advice;
}

double off_deg(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI; }

TEST(Pointing, TheForefingersDirectionIsFoundFromOnePlaceThatItPointsAt) {
  double worst = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    PointingRehearsal r;
    r.seed = seed;
    const PointingResult got = calibrate_pointing(finger_poses(pointing_at_place(r), 1, 14, seed), r.tip_mm);
    EXPECT_TRUE(got.accepted) << got.advice;
    EXPECT_NEAR(got.cone_deg, 60, 6);
    EXPECT_LT((got.place_mm - r.place_mm).norm(), 3);
    worst = std::max(worst, off_deg(got.direction, r.direction));
  }
  EXPECT_LT(worst, 0.5);
  PointingRehearsal exact;
  exact.aim_deg = 0;
  const PointingResult got = calibrate_pointing(finger_poses(pointing_at_place(exact), 1, 14, 1, 0, 0), exact.tip_mm);
  EXPECT_LT(off_deg(got.direction, exact.direction), 1e-3);  // float32 on the line
  EXPECT_LT((got.place_mm - exact.place_mm).norm(), 1e-2);
}

TEST(Pointing, AHandThatStaysOnOneSideOrPointsElsewhereIsRefused) {
  const auto advice = [](const PointingRehearsal& r, double seconds) {
    const PointingResult got = calibrate_pointing(finger_poses(pointing_at_place(r), 1, seconds, 2), r.tip_mm);
    EXPECT_FALSE(got.accepted);
    return got.advice;
  };
  PointingRehearsal narrow, wild;
  narrow.cone_deg = 20, wild.aim_deg = 8;
  EXPECT_NE(advice(PointingRehearsal{}, 3).find("for longer"), std::string::npos);
  EXPECT_NE(advice(narrow, 14).find("to all sides"), std::string::npos);
  EXPECT_NE(advice(wild, 14).find("one and the same place"), std::string::npos);
  EXPECT_FALSE(calibrate_pointing({}, Vec3::Zero()).accepted);
}

TEST(Registration, ExactAndHeldOut) {
  Dice dice{3};
  for (int round = 0; round < 50; ++round) {
    const Eigen::Quaterniond R =
        Eigen::Quaterniond(dice.normal(), dice.normal(), dice.normal(), dice.normal()).normalized();
    const Vec3 t = 300 * normal3(dice);
    std::vector<Vec3> known, touched;
    for (int i = 0; i < 6; ++i) {
      known.push_back(80 * normal3(dice));
      touched.push_back(R.conjugate() * (known.back() - t));
    }
    const WorldRegistration got = calibrate_world(touched, known);
    ASSERT_TRUE(got.accepted) << got.advice;
    EXPECT_LT((got.translation_mm - t).norm(), 1e-9 * 300);
    EXPECT_LT(got.rotation.angularDistance(R), 1e-9);
    EXPECT_LT(got.held_out_mm, 1e-9 * 300);
    // Mirrored points are no rotation: refused, not fitted by a reflection.
    for (Vec3& p : touched) p.x() = -p.x();
    EXPECT_FALSE(calibrate_world(touched, known).accepted);
  }
}

TEST(Registration, BadPointsAreRefusedWithAdvice) {
  std::vector<Vec3> known{{-60, -60, 0}, {60, -60, 0}, {60, 60, 5}, {-60, 60, -5}, {0, 0, 20}};
  std::vector<Vec3> touched = known;
  const auto advice = [&](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    const WorldRegistration r = calibrate_world(a, b);
    EXPECT_FALSE(r.accepted);
    return r.advice;
  };
  touched[4].z() += 2.5;  // the held-out one alone
  EXPECT_NE(advice(touched, known).find("held out"), std::string::npos);
  touched = known;
  std::swap(touched[0], touched[1]);
  EXPECT_NE(advice(touched, known).find("wrong order"), std::string::npos);
  touched = known;
  for (Vec3& p : touched) p /= 25.4;
  EXPECT_NE(advice(touched, known).find("units"), std::string::npos);
  EXPECT_NE(advice({known[0], known[1]}, {known[0], known[1]}).find("needed"), std::string::npos);
  EXPECT_NE(advice({known[0]}, known).find("listed"), std::string::npos);
  std::vector<Vec3> line;
  for (int i = 0; i < 6; ++i) line.push_back(Vec3(30 * i, 0, 0.1 * i * i));
  EXPECT_NE(advice(line, line).find("line"), std::string::npos);
}

std::vector<double> apertures_of(const fastrak::Motion& motion, double seconds) {
  GloveTracker tracker{Calibration{}};
  std::vector<double> a;
  fastrak::VirtualLine line(motion, {}, {});
  for (int64_t tick = 0; tick < int64_t(seconds * 1000); ++tick) {
    for (const TrackerSample& s : line.tick(tick)) tracker.add(s);
    const HandPose h = tracker.at(tick * 1'000'000);
    if (h.valid && tick % 16 == 0) a.push_back(h.aperture_mm);
  }
  return a;
}

TEST(GloveRange, OpenAndClosedDistancesOfAMovingHand) {
  const GloveResult got = calibrate_glove(apertures_of(glove_opening(4, 18, 85), 12), 62.5);
  EXPECT_TRUE(got.accepted) << got.advice;
  EXPECT_NEAR(got.closed_mm, 18, 1);
  EXPECT_NEAR(got.open_mm, 85, 1);
  EXPECT_GE(got.cycles, 5);
  const auto advice = [&](const std::vector<double>& a) {
    const GloveResult r = calibrate_glove(a, 62.5);
    EXPECT_FALSE(r.accepted);
    return r.advice;
  };
  EXPECT_NE(advice(apertures_of(glove_opening(4, 40, 55), 12)).find("wider"), std::string::npos);
  EXPECT_NE(advice(apertures_of(glove_opening(4, 18, 85), 4)).find("closed 2 times"), std::string::npos);
  EXPECT_NE(advice(std::vector<double>(20, 30.0)).find("ten seconds"), std::string::npos);
  EXPECT_FALSE(advice(std::vector<double>(2000, 30.0)).empty());
}

TEST(Distortion, AKnownFieldIsTakenOutFivefold) {
  Dice dice{12};
  // A field such as a metal plate makes: cubic, up to some 10 mm.
  const auto bent = [](const Vec3& p) {
    const Vec3 u = (p - Vec3(350, 0, -150)) / 200;
    return Vec3(p + 4 * Vec3(u.x() * u.y() + 0.5 * u.z() * u.z() * u.z(), u.y() * u.y() - u.x(),
                             u.z() * u.x() + u.y() * u.y() * u.y()));
  };
  std::vector<Vec3> measured, known;
  for (int i = 0; i < 250; ++i) {
    const Vec3 p(150 + 400 * dice.unit(), -200 + 400 * dice.unit(), -350 + 400 * dice.unit());
    known.push_back(p);
    measured.push_back(bent(p) + 0.1 * normal3(dice));
  }
  const DistortionResult got = calibrate_distortion(measured, known);
  EXPECT_TRUE(got.accepted) << got.advice;
  std::printf("distortion: %.2f mm before, %.2f after (held out)\n", got.before_mm, got.after_mm);
  EXPECT_LT(got.after_mm * 5, got.before_mm);
  // A field without distortion gains nothing from a correction.
  for (size_t i = 0; i < known.size(); ++i) measured[i] = known[i] + 0.4 * normal3(dice);
  EXPECT_FALSE(calibrate_distortion(measured, known).accepted);
  measured.resize(10), known.resize(10);
  EXPECT_NE(calibrate_distortion(measured, known).advice.find("working space"), std::string::npos);
}

TEST(Distortion, TheTrackingCorrectsBeforeAnythingElse) {
  Calibration c;
  c.tip_offset_mm = Vec3(0, 0, 100);
  c.distortion.nodes = {2, 2, 2};
  c.distortion.low_mm = Vec3(0, 0, 0), c.distortion.high_mm = Vec3(100, 100, 100);
  c.distortion.add_mm.assign(8, Vec3::Zero());
  for (size_t i = 0; i < 8; ++i)
    if (i & 1) c.distortion.add_mm[i] = Vec3(2, 0, 0);
  StylusTracker tracker(c);
  StylusSample s = test::stylus(0, 0, Vec3(50, 20, 30));
  s.quat = {1, 0, 0, 0};
  tracker.add(s);
  EXPECT_LT((tracker.at(0).tip_mm - Vec3(51, 20, 130)).norm(), 1e-12);
}

}  // namespace test_procedures
}  // namespace limberg
