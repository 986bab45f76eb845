#include "sim/imaging/io/dicom_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "sim/base/error.h"
#include "sim/imaging/io/dicom_pixels.h"

namespace limberg::imaging {
namespace {

constexpr double kAirBelow = -1500, kAirHU = -1000;

/// Scaled; NaN: padding, or below what air can have. `no_tissue` counts these.
std::vector<float> pixels(const DicomFile& d, DicomPixels& reader, int64_t& no_tissue) {
  const size_t n = size_t(d.rows) * size_t(d.columns);
  const std::string data = reader.bytes_of(d);
  std::vector<float> out(n);
  const int shift = d.high_bit >= 0 ? d.high_bit + 1 - d.stored : 0;
  const uint32_t mask = d.stored >= 32 ? ~0u : (1u << d.stored) - 1;
  const int32_t low = std::min(d.padding, d.padding_limit), high = std::max(d.padding, d.padding_limit);
  const bool narrow = d.allocated == 16 && d.is_signed;  // padding is written as the pixels are
  const int32_t pad = narrow ? int32_t(int16_t(uint16_t(low))) : low,
                pad_high = narrow ? int32_t(int16_t(uint16_t(high))) : high;
  for (size_t i = 0; i < n; ++i) {
    const uint32_t word = d.allocated == 8 ? uint32_t(uint8_t(data[i]))
                                           : uint32_t(uint8_t(data[2 * i])) | uint32_t(uint8_t(data[2 * i + 1])) << 8;
    const uint32_t bits = word >> shift & mask;
    int32_t v = int32_t(bits);
    if (d.is_signed && bits >> (d.stored - 1) & 1) v -= int32_t(1) << d.stored;
    const bool padding = d.has_padding && v >= std::min(pad, pad_high) && v <= std::max(pad, pad_high);
    const double x = d.slope * v + d.intercept;
    if (!std::isfinite(x) || std::abs(x) > 1e9)
      throw InputError(d.name(), 0, "a value is out of range once it is scaled");
    const bool none = padding || x < kAirBelow;
    no_tissue += none;
    out[i] = none ? NAN : float(x);
  }
  return out;
}

/// One slice as it lies on the grid of the volume; NaN: nothing there.
std::vector<float> sheared(const std::vector<float>& in, const DicomFile& a, const Vec2& drift_mm,
                           const std::array<int64_t, 3>& size) {
  const size_t plane = size_t(size[0]) * size_t(size[1]);
  std::vector<float> out(plane, NAN);
  const double sx = drift_mm.x() / a.column_step_mm, sy = drift_mm.y() / a.row_step_mm;
  for (int64_t r = 0; r < size[1]; ++r)
    for (int64_t c = 0; c < size[0]; ++c) {
      const double px = double(c) - sx, py = double(r) - sy;
      if (!(px >= -1e-6 && py >= -1e-6 && px <= a.columns - 1 + 1e-6 && py <= a.rows - 1 + 1e-6)) continue;
      const int32_t x = std::clamp(int32_t(px), 0, std::max(0, a.columns - 2)),
                    y = std::clamp(int32_t(py), 0, std::max(0, a.rows - 2));
      const int32_t x1 = std::min(x + 1, a.columns - 1), y1 = std::min(y + 1, a.rows - 1);
      const float u = float(std::clamp(px - x, 0., 1.)), w = float(std::clamp(py - y, 0., 1.));
      const auto g = [&](int32_t q, int32_t p) { return in[size_t(p) * size_t(a.columns) + size_t(q)]; };
      const float mixed = (1 - w) * ((1 - u) * g(x, y) + u * g(x1, y)) + w * ((1 - u) * g(x, y1) + u * g(x1, y1));
      out[size_t(r) * size_t(size[0]) + size_t(c)] = mixed;  // NaN beside padding: padding
    }
  return out;
}

}  // namespace

LoadedVolume volume_of(DicomSeries& s, bool bridge_missing) {
  SeriesGrid g = grid_of(s, bridge_missing);
  const SlicePlaces& p = g.at;
  const std::vector<DicomFile>& f = s.slice;
  const DicomFile& a = f.front();
  const size_t n = f.size();
  LoadedVolume out;
  Volume& v = out.volume;
  v.step_mm.col(0) = a.column_step_mm * p.across, v.step_mm.col(1) = a.row_step_mm * p.down;
  v.step_mm.col(2) = g.step_mm * p.normal;
  v.origin_mm = a.position_mm + g.first_mm.x() * p.across + g.first_mm.y() * p.down;
  for (size_t k = 0; k < 3; ++k) v.size[k] = int32_t(g.size[k]);
  const size_t plane = size_t(g.size[0]) * size_t(g.size[1]);
  int64_t no_tissue = 0, read = 0;
  DicomPixels reader;
  const auto on_grid = [&](size_t i) {
    std::vector<float> in = pixels(f[i], reader, no_tissue);
    read += int64_t(in.size());
    return p.tilted ? sheared(in, a, p.drift_mm[i] - g.first_mm, g.size) : in;
  };
  // The pixels of one slice before memory for all is asked for: a file may promise more than it holds.
  std::vector<float> below = on_grid(0), above;
  v.value.reserve(plane * size_t(g.size[2]));
  size_t at = 0, have_below = 0, have_above = n;
  for (int64_t k = 0; k < g.size[2]; ++k) {
    const double place = p.z_mm[0] + double(k) * g.step_mm, nearly = 1e-6 * g.step_mm;
    if (!g.resampled)
      at = size_t(k);
    else
      while (at + 1 < n && p.z_mm[at + 1] <= place + nearly) ++at;
    if (have_below != at) {
      below = have_above == at ? std::move(above) : on_grid(at);
      if (have_above == at) have_above = n;
      have_below = at;
    }
    const bool between = g.resampled && at + 1 < n && place > p.z_mm[at] + nearly;
    if (!between) {
      v.value.insert(v.value.end(), below.begin(), below.end());
      continue;
    }
    if (have_above != at + 1) above = on_grid(at + 1), have_above = at + 1;
    const float t = float((place - p.z_mm[at]) / p.gap[at]);
    for (size_t i = 0; i < plane; ++i) v.value.push_back((1 - t) * below[i] + t * above[i]);
  }
  float least = std::numeric_limits<float>::infinity();
  for (const float x : v.value)
    if (std::isfinite(x)) least = std::min(least, x);
  const float air = std::isfinite(least) ? std::max(float(kAirHU), least) : float(kAirHU);
  for (float& x : v.value)
    if (!std::isfinite(x)) x = air;
  out.notes = std::move(g.notes);
  if (no_tissue > 0)
    out.notes.push_back(fmt::format("{:.2g} % of the pixels are padding or below {:g}: {:g} now",
                                    100. * double(no_tissue) / double(read), kAirBelow, double(air)));
  std::set<std::string> compressions;
  for (const DicomFile& d : f)
    if (d.compressed) {
      const Compression c = compression_of(d);
      compressions.insert(c.name + (c.lossy ? "; it loses detail" : ""));
    }
  for (const std::string& c : compressions) out.notes.push_back("its pixels were compressed (" + c + ")");
  return out;
}

}  // namespace limberg::imaging
