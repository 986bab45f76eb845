#include "devices/calibrating.h"

#include <cmath>

#include "devices/glove.h"

namespace limberg {

std::vector<StylusSample> stylus_readings(std::span<const Sample> samples) {
  std::vector<StylusSample> r;
  for (const Sample& s : samples) {
    if (const auto* t = std::get_if<TrackerSample>(&s); t && t->role == StationRole::stylus)
      r.push_back(as_stylus(*t));
    else if (const auto* p = std::get_if<StylusSample>(&s))
      r.push_back(*p);
  }
  return r;
}

Eigen::Quaterniond rotation_of(const StylusSample& s) {
  return Eigen::Quaterniond(s.quat[0], s.quat[1], s.quat[2], s.quat[3]).normalized();
}

std::vector<Touch> touches(std::span<const StylusSample> readings, const Vec3& tip_offset_mm) {
  std::vector<Touch> all;
  std::vector<const StylusSample*> press;
  const auto end = [&] {
    constexpr size_t kFewest = 12;  // a tenth of a second
    if (press.size() >= kFewest) {
      const size_t from = press.size() / 5, to = press.size() - from;
      Touch t;
      double sum2 = 0;
      std::vector<Vec3> tips;
      for (size_t i = from; i < to; ++i) {
        const Vec3 tip = press[i]->tip_mm + rotation_of(*press[i]) * tip_offset_mm;
        t.sensor_mm += press[i]->tip_mm, t.tip_mm += tip, tips.push_back(tip);
      }
      t.readings = int(tips.size());
      t.sensor_mm /= t.readings, t.tip_mm /= t.readings;
      for (const Vec3& p : tips) sum2 += (p - t.tip_mm).squaredNorm();
      t.spread_mm = std::sqrt(sum2 / t.readings);
      all.push_back(t);
    }
    press.clear();
  };
  for (const StylusSample& s : readings) {
    if (s.buttons & 1)
      press.push_back(&s);
    else
      end();
  }
  end();
  return all;
}

std::vector<double> apertures(std::span<const Sample> samples, const Calibration& calibration, bool other,
                              int64_t* readings) {
  const StationRole forefinger = other ? StationRole::other_forefinger : StationRole::forefinger,
                    thumb = other ? StationRole::other_thumb : StationRole::thumb;
  GloveTracker tracker(calibration);
  constexpr int64_t kStepNs = 16'000'000;
  std::vector<double> aperture;
  int64_t next = 0, count = 0;
  for (const Sample& s : samples) {
    const auto* t = std::get_if<TrackerSample>(&s);
    if (!t || (t->role != forefinger && t->role != thumb)) continue;
    ++count;
    for (; next < t->t_ns; next += kStepNs)
      if (const HandPose h = tracker.at(next); h.valid) aperture.push_back(h.aperture_mm);
    TrackerSample reading = *t;
    reading.role = t->role == thumb ? StationRole::thumb : StationRole::forefinger;
    tracker.add(reading);
  }
  if (readings) *readings = count;
  return aperture;
}

}  // namespace limberg
