#include "devices/rehearsal.h"

#include <cmath>
#include <memory>
#include <numbers>

#include "devices/motion.h"
#include "sim/base/elementary.h"
#include "sim/geometry/rotation.h"

namespace limberg {

namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kStartS = 1.0;  // the device is being asked for its status

/// A stylus whose shaft (from tip to hand, the sensor's frame at -tip) leans by `lean` towards `about` and is spun.
Eigen::Quaterniond leaning(double lean, double about, double spin) {
  return turn_about(lean, Vec3(-elementary::sin(about), elementary::cos(about), 0)) * turn_about(spin, Vec3::UnitZ()) *
         turn_about(std::numbers::pi, Vec3::UnitX());
}

}  // namespace

fastrak::Motion stylus_in_dimple(const PivotRehearsal& r) {
  auto slips = std::make_shared<Dropouts>(r.seed, r.slips_per_s, 0.1);
  auto last_t = std::make_shared<double>(-1.0);
  auto slipping = std::make_shared<bool>(false);
  return [=](int, double t) {
    const double half = r.cone_deg / 2 * std::numbers::pi / 180;
    const double lean = r.one_plane ? half * elementary::sin(kFullTurn * 0.4 * t)
                                    : half * std::sqrt(0.5 - 0.5 * elementary::cos(kFullTurn * 0.13 * t));
    fastrak::StationPose p;
    p.orientation = leaning(lean, r.one_plane ? 0.3 : kFullTurn * 0.45 * t, 0.4 * elementary::sin(kFullTurn * 0.2 * t));
    if (t > *last_t) *slipping = slips->lost(t), *last_t = t;
    const Vec3 slip = *slipping ? Vec3(r.slip_mm * std::vector<double>{0.6, 0.8, 0.3, -0.7}[size_t(t * 7) % 4],
                                       r.slip_mm * 0.5, r.slip_mm * 0.2)
                                : Vec3(Vec3::Zero());
    p.pos_mm = r.dimple_mm + slip - p.orientation * r.tip_mm;
    return p;
  };
}

fastrak::Motion finger_on_place(const PivotRehearsal& r, int station) {
  const fastrak::Motion finger = stylus_in_dimple(r);
  return [=](int asked, double t) {
    fastrak::StationPose p = finger(1, t);
    p.pressed = false;
    if (asked != station) p.pos_mm += p.orientation * Vec3(-10, 30, -35);
    return p;
  };
}

fastrak::Motion pointing_at_place(const PointingRehearsal& r) {
  auto beside = std::make_shared<Tremor>(r.seed * 2 + 1, r.aim_deg * std::numbers::pi / 180, 0.4, 2);
  return [=](int station, double t) {
    const double half = r.cone_deg / 2 * std::numbers::pi / 180;
    const double lean = half * std::sqrt(0.5 - 0.5 * elementary::cos(kFullTurn * 0.11 * t));
    const Vec3 from = leaning(lean, kFullTurn * 0.33 * t, 0) * Vec3(0, 0, -1);
    const Vec3 tip = r.place_mm + (225 + 75 * elementary::sin(kFullTurn * 0.21 * t)) * from;
    Vec3 towards = (r.place_mm - tip).normalized();
    towards = (towards + towards.cross(beside->at(t))).normalized();
    fastrak::StationPose p;
    p.orientation = turn_about(0.5 * elementary::sin(kFullTurn * 0.17 * t), towards) *
                    Eigen::Quaterniond::FromTwoVectors(r.direction, towards);
    p.pos_mm = tip - p.orientation * r.tip_mm;
    if (station != 1) p.pos_mm += p.orientation * Vec3(-10, 30, -35);
    return p;
  };
}

double seconds_for(const TouchRehearsal& r) { return kStartS + double(r.points_mm.size()) + 0.5; }

fastrak::Motion stylus_touching(const TouchRehearsal& r) {
  auto tremor = std::make_shared<Tremor>(r.seed, 0.1, 8, 12);
  return [=](int, double t) {
    const double s = std::max(0.0, t - kStartS);
    const auto k = std::min(size_t(s), r.points_mm.size() - 1);
    const double within = s - double(k);
    const auto aim = [&](size_t i) { return Vec3(r.points_mm[i] + (i == 0 ? r.slip_mm : Vec3(Vec3::Zero()))); };
    const Vec3 from = k > 0 ? aim(k - 1) : Vec3(aim(0) + Vec3(0, 0, 60));
    const double way = minimum_jerk(within / 0.4);
    const Vec3 tip = from + way * (aim(k) - from) + Vec3(0, 0, 30 * elementary::sin(std::numbers::pi * way)) +
                     tremor->at(t) * (within < 0.4 ? 1 : 0.3);
    const Eigen::Quaterniond to_tracker = r.world_from_tracker.conjugate();
    fastrak::StationPose p;
    p.orientation = to_tracker * leaning(0.3 + 0.1 * elementary::sin(t), 0.8 * t, 0);
    p.pos_mm = to_tracker * (tip - r.world_from_tracker_mm) - p.orientation * r.tip_mm;
    p.pressed = t > kStartS && within > 0.45 && within < 0.95;
    return p;
  };
}

fastrak::Motion glove_opening(uint64_t seed, double closed_mm, double open_mm) {
  auto tremor = std::make_shared<std::array<Tremor, 2>>(
      std::array<Tremor, 2>{Tremor(seed, 0.15, 8, 12), Tremor(seed + 1, 0.15, 8, 12)});
  return [=](int station, double t) {
    const double cycle = std::fmod(t, 2.0);
    const double shut = minimum_jerk((cycle - 0.7) / 0.3) - minimum_jerk((cycle - 1.7) / 0.3);
    const double apart = open_mm - shut * (open_mm - closed_mm);
    fastrak::StationPose p;
    p.orientation = turn_about(0.4 * elementary::sin(kFullTurn * 0.21 * t), Vec3::UnitZ());
    const Vec3 centre(340 + 40 * elementary::sin(kFullTurn * 0.3 * t), -80 + 30 * elementary::sin(kFullTurn * 0.23 * t),
                      -110);
    p.pos_mm = centre + p.orientation * Vec3(0, station == 1 ? apart / 2 : -apart / 2, 0) +
               (*tremor)[size_t(station != 1)].at(t);
    return p;
  };
}

}  // namespace limberg
