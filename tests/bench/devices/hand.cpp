#include "tests/bench/devices/hand.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>

#include "devices/motion.h"

namespace limberg::bench {

namespace {
constexpr int64_t kHandTickNs = 1'000'000;
constexpr double kFullTurn = 2 * std::numbers::pi;
}  // namespace

fastrak::Motion reaching_hand(uint64_t seed) {
  RandomStream random(seed);
  auto goals = std::make_shared<std::vector<Vec3>>();
  for (int i = 0; i < 512; ++i) {
    const double x = random.uniform(), y = random.uniform();
    goals->push_back(Vec3(350, 0, -120) + 85 * Vec3(x, y, random.uniform()));
  }
  return [goals](int station, double t) {
    t = std::max(0.0, t);
    const double reach = std::floor(t / 0.6);
    const auto k = size_t(reach) % (goals->size() - 1);
    const double blend = minimum_jerk((t - 0.6 * reach) / 0.4), tremor = 0.1 * std::sin(kFullTurn * 9.5 * t);
    fastrak::StationPose p;
    p.pos_mm = (*goals)[k] + blend * ((*goals)[k + 1] - (*goals)[k]) + Vec3(tremor, 0.7 * tremor, -tremor) +
               Vec3(0, 40.0 * station, 0);
    p.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.4 * std::sin(kFullTurn * 0.7 * t), Vec3(0.6, 0, 0.8)));
    return p;
  };
}

TrackingFigures tracking_trial(const TrackingTrial& trial) {
  const fastrak::Motion truth = reaching_hand(trial.seed);
  fastrak::LinkSettings link;
  if (!trial.two_stations) link.role = fastrak::parse_roles("s");
  fastrak::EmulatorSettings device;
  device.seed = trial.seed + 1;
  device.noise_mm = trial.noise_mm;
  fastrak::VirtualLine line(truth, link, device);
  Calibration c;
  c.filter = trial.filter;
  c.filter.measurement_noise_mm = std::max(1e-3, trial.noise_mm);
  StylusTracker tracker(c);
  const int64_t settle = 1500, end = int64_t(trial.seconds * 1000);
  std::vector<Vec3> seen;
  TrackingFigures f;
  double turn2 = 0;
  int64_t readings = 0;
  for (int64_t tick = 0; tick < end; ++tick) {
    for (const TrackerSample& s : line.tick(tick))
      if (s.station == 1) tracker.add(as_stylus(s)), ++readings;
    const Pose p = tracker.at(tick * kHandTickNs);
    if (tick < settle) continue;
    seen.push_back(p.tip_mm);
    const fastrak::StationPose t = truth(1, double(tick) * 1e-3);
    const double turned = p.orientation.angularDistance(t.orientation) * 180 / std::numbers::pi;
    turn2 += turned * turned;
  }
  const auto rms_at = [&](double lag_ms) {
    double sum2 = 0;
    size_t n = 0;
    for (size_t i = 0; i < seen.size(); i += 3, ++n)
      sum2 += (seen[i] - truth(1, (double(settle) + double(i) - lag_ms) * 1e-3).pos_mm).squaredNorm();
    return std::sqrt(sum2 / double(n));
  };
  f.rms_mm = rms_at(0);
  f.rms_shifted_mm = 1e9;
  for (double lag = -10; lag <= 40; lag += 0.5)
    if (const double r = rms_at(lag); r < f.rms_shifted_mm) f.rms_shifted_mm = r, f.lag_ms = lag;
  for (size_t i = 1; i < seen.size(); ++i) f.max_step_mm = std::max(f.max_step_mm, (seen[i] - seen[i - 1]).norm());
  f.turn_rms_deg = std::sqrt(turn2 / double(seen.size()));
  f.rate_hz = double(readings) / (double(end) * 1e-3);

  // At rest: the same device, a hand that does not move.
  fastrak::VirtualLine still(
      [](int station, double) {
        return fastrak::StationPose{Vec3(350, 40.0 * station, -120), Eigen::Quaterniond::Identity(), false};
      },
      link, device);
  StylusTracker at_rest(c);
  Vec3 sum = Vec3::Zero(), sum2 = Vec3::Zero();
  int n = 0;
  for (int64_t tick = 0; tick < 11'000; ++tick) {
    for (const TrackerSample& s : still.tick(tick))
      if (s.station == 1) at_rest.add(as_stylus(s));
    const Vec3 p = at_rest.at(tick * kHandTickNs).tip_mm;
    if (tick >= 1500) sum += p, sum2 += p.cwiseProduct(p), ++n;
  }
  const Vec3 mean = sum / n;
  f.jitter_mm = std::sqrt(std::max(0.0, (sum2 / n - mean.cwiseProduct(mean)).mean()));
  return f;
}

GrabFigures grab_trial(const GrabTrial& trial) {
  GrabFigures f;
  Calibration c;
  c.glove.closed_mm = 15, c.glove.open_mm = 80;
  c.filter.measurement_noise_mm = trial.noise_mm;
  const GrabDetector thresholds(c.glove);
  constexpr double kStart = 1.0;  // the line shakes hands in the meantime

  // The distance of the tips over time.
  struct Close {
    double begin_s, hold_s, seconds;
  };
  RandomStream random(trial.seed);
  auto closes = std::make_shared<std::vector<Close>>();
  double t = kStart + trial.idle_s + 1;
  for (int i = 0; i < trial.grabs; ++i) {
    Close k;
    k.begin_s = t + 0.2 * random.uniform();
    k.seconds = 0.12 + 0.3 * random.uniform();
    k.hold_s = 0.25 + 0.3 * random.uniform();
    t = k.begin_s + 2 * k.seconds + k.hold_s + 0.35;
    closes->push_back(k);
  }
  const double end_s = t + 0.5, idle_end = kStart + trial.idle_s;
  const double phase[6] = {random.uniform() * 6, random.uniform() * 6, random.uniform() * 6,
                           random.uniform() * 6, random.uniform() * 6, random.uniform() * 6};
  const auto tremor = std::make_shared<std::array<Tremor, 2>>(
      std::array<Tremor, 2>{Tremor(random.next(), 0.25, 8, 12), Tremor(random.next(), 0.25, 8, 12)});
  const GloveParameters glove = c.glove;
  auto next = std::make_shared<size_t>(0);  // times asked for hardly ever go back
  const auto aperture = [=](double s) {
    if (s < idle_end) {
      // A relaxed hand: never less than 40 % open, once closer, once wider.
      const double wave =
          0.5 + 0.25 * std::sin(kFullTurn * 0.11 * s + phase[0]) + 0.25 * std::sin(kFullTurn * 0.37 * s + phase[1]);
      return glove.closed_mm + (0.40 + 0.55 * wave) * (glove.open_mm - glove.closed_mm);
    }
    while (*next > 0 && s < (*closes)[*next].begin_s) --*next;
    while (*next + 1 < closes->size() && s >= (*closes)[*next + 1].begin_s) ++*next;
    if (closes->empty()) return glove.open_mm;
    const Close& k = (*closes)[*next];
    const double shut =
        minimum_jerk((s - k.begin_s) / k.seconds) - minimum_jerk((s - k.begin_s - k.seconds - k.hold_s) / k.seconds);
    return glove.open_mm - shut * (glove.open_mm - glove.closed_mm);
  };
  const fastrak::Motion motion = [=](int station, double s) {
    const auto wave = [&](double hz, int i) { return std::sin(kFullTurn * hz * s + phase[i]); };
    // Up to some 0.5 m/s, along the line between the fingers too.
    const Vec3 centre(350 + 60 * wave(0.6, 2) + 30 * wave(1.1, 3), -60 + 70 * wave(0.7, 4) + 25 * wave(1.3, 5),
                      -120 + 40 * wave(0.5, 3));
    fastrak::StationPose p;
    p.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * wave(0.4, 5), Vec3::UnitZ()));
    p.pos_mm = centre + p.orientation * Vec3(0, (station == 1 ? 0.5 : -0.5) * aperture(s), 0) +
               (*tremor)[size_t(station != 1)].at(s);
    return p;
  };
  fastrak::EmulatorSettings device;
  device.seed = trial.seed + 7;
  device.noise_mm = trial.noise_mm;
  device.damage_per_byte = trial.damage_per_byte;
  fastrak::VirtualLine line(motion, {}, device);
  GloveTracker tracker(c);
  std::vector<int64_t> grabs;
  bool closed = false;
  const auto ticks = int64_t(end_s * 1000);
  for (int64_t tick = 0; tick < ticks; ++tick) {
    for (const TrackerSample& s : line.tick(tick)) tracker.add(s), ++f.readings;
    const HandPose h = tracker.at(tick * kHandTickNs);
    if (h.closed && !closed) grabs.push_back(tick);
    closed = h.closed;
    if (double(tick) * 1e-3 < idle_end)
      f.least_aperture_mm = std::min(f.least_aperture_mm, aperture(double(tick) * 1e-3));
  }
  f.damaged = line.link().counts().parser.damaged;
  f.idle_s = trial.idle_s;
  f.meant = trial.grabs;
  std::vector<double> delay;
  size_t g = 0;
  for (; g < grabs.size() && double(grabs[g]) * 1e-3 < idle_end; ++g) ++f.false_grabs;
  for (const Close& k : *closes) {
    double s = k.begin_s;
    while (aperture(s) > thresholds.close_below_mm()) s += 1e-4;
    // A grab up to 20 ms before the crossing is the prediction at work.
    for (; g < grabs.size() && double(grabs[g]) * 1e-3 < s - 0.02; ++g) ++f.extra;
    if (g < grabs.size() && double(grabs[g]) * 1e-3 < k.begin_s + 2 * k.seconds + k.hold_s)
      delay.push_back(double(grabs[g++]) - s * 1e3);
    else
      ++f.missed;
  }
  f.extra += int64_t(grabs.size() - g);
  for (const double d : delay) f.in_time += d <= trial.within_ms;
  if (!delay.empty()) {
    std::sort(delay.begin(), delay.end());
    f.median_ms = delay[delay.size() / 2], f.worst_ms = delay.back();
  }
  return f;
}

}  // namespace limberg::bench
