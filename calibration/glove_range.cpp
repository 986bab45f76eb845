#include "calibration/glove_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace limberg {

namespace {

double median(std::vector<double> v) {
  if (v.empty()) return 0;
  std::nth_element(v.begin(), v.begin() + long(v.size() / 2), v.end());
  return v[v.size() / 2];
}

/// The split with the largest variance between the heaps.
double otsu(const std::vector<double>& v) {
  const auto [low, high] = std::minmax_element(v.begin(), v.end());
  constexpr int kBins = 256;
  std::vector<double> count(kBins, 0.0);
  const double width = std::max(1e-9, (*high - *low) / kBins);
  double total = 0, sum = 0;
  for (const double x : v) {
    const int b = std::min(kBins - 1, int((x - *low) / width));
    ++count[size_t(b)], ++total, sum += b;
  }
  // A gap between the heaps scores alike all along it: its middle is taken.
  double best = -1, below = 0, below_sum = 0;
  int first = 0, last = 0;
  for (int b = 0; b + 1 < kBins; ++b) {
    below += count[size_t(b)], below_sum += b * count[size_t(b)];
    if (below == 0 || below == total) continue;
    const double d = below_sum / below - (sum - below_sum) / (total - below), score = below * (total - below) * d * d;
    if (score > best * (1 + 1e-12))
      best = score, first = last = b;
    else if (score >= best * (1 - 1e-12))
      last = b;
  }
  return *low + (0.5 * (first + last) + 1) * width;
}

}  // namespace

GloveResult calibrate_glove(const std::vector<double>& aperture, double rate_hz, const GloveLimits& limits) {
  GloveResult r;
  const auto refuse = [&](const std::string& why) { r.advice += (r.advice.empty() ? "" : "; ") + why; };
  if (double(aperture.size()) < 2 * limits.held_s * rate_hz) {
    refuse(
        fmt::format("{:.1f} s of a tracked hand: open and close it slowly for ten seconds, holding it open and closed "
                    "for a second each",
                    double(aperture.size()) / std::max(1.0, rate_hz)));
    return r;
  }
  const double split = otsu(aperture);
  std::vector<double> low, high;
  for (const double a : aperture) (a < split ? low : high).push_back(a);
  r.closed_mm = median(low), r.open_mm = median(high);
  // The spread of a hand that is held closed: around the median, whatever the way there adds on one side.
  std::vector<double> off;
  for (const double a : low)
    if (a <= r.closed_mm + (split - r.closed_mm) / 2) off.push_back(std::abs(a - r.closed_mm));
  r.spread_mm = 1.4826 * median(off);
  const double range = r.open_mm - r.closed_mm, close_at = r.closed_mm + limits.grab_share * range,
               open_at = r.closed_mm + limits.release_share * range;
  bool closed = false;
  for (const double a : aperture) {
    if (!closed && a < close_at)
      closed = true, ++r.cycles;
    else if (closed && a > open_at)
      closed = false;
  }
  double held_closed = 0, held_open = 0;
  for (const double a : aperture) held_closed += a<close_at, held_open += a> r.open_mm - limits.grab_share * range;
  if (range < limits.range_mm)
    refuse(
        fmt::format("open and closed hand differ by {:.0f} mm where {:.0f} are needed: open the hand wider, or fix the "
                    "sensors nearer to the tips",
                    range, limits.range_mm));
  else {
    if (r.cycles < limits.cycles)
      refuse(fmt::format("the hand was closed {} times where {} are needed", r.cycles, limits.cycles));
    if (held_closed < limits.held_s * rate_hz || held_open < limits.held_s * rate_hz)
      refuse(
          fmt::format("held closed for {:.1f} s and open for {:.1f} s where {:.1f} are needed: hold each for a second",
                      held_closed / rate_hz, held_open / rate_hz, limits.held_s));
    if ((limits.release_share - limits.grab_share) * range < limits.band_sigma * r.spread_mm)
      refuse(fmt::format(
          "the closed hand wavers by {:.1f} mm, too much for a band of {:.1f} mm: hold it still, or open it wider",
          r.spread_mm, (limits.release_share - limits.grab_share) * range));
  }
  r.accepted = r.advice.empty();
  return r;
}

}  // namespace limberg
