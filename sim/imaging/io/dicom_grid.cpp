// What the headers of a series say about its grid.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/imaging/io/dicom_pixels.h"
#include "sim/imaging/io/dicom_series.h"
#include "sim/imaging/io/header.h"

namespace limberg::imaging {
namespace {

constexpr double kWidestGap_mm = 10;  // that is bridged by interpolation
constexpr double kEven = 0.02;        // of the median: by so much even gaps differ
constexpr double kWideGap = 1.8;      // times its neighbours and the median: a slice may be missing there
constexpr size_t kPlacesNamed = 5;

void check_slice(const DicomFile& d) {
  const auto refuse = [&](const std::string& what) { throw InputError(d.name(), 0, what); };
  if (d.rows < 1 || d.columns < 1) refuse("the slice has no rows or columns");
  if (d.samples != 1) refuse("a pixel has " + std::to_string(d.samples) + " numbers (colour); one was expected");
  if (d.frame < 0)
    refuse(
        fmt::format("holds {} frames and does not say where each of them lies; expected a group for each (Enhanced "
                    "CT), or one slice per file",
                    d.frames));
  if (d.allocated != 8 && d.allocated != 16)
    refuse(std::to_string(d.allocated) + " bits per pixel are not read; expected 8 or 16");
  if (d.stored < 1 || d.stored > d.allocated || d.high_bit >= d.allocated ||
      (d.high_bit >= 0 && d.high_bit + 1 < d.stored))
    refuse("bits stored, bits allocated and high bit do not go together");
  if (!d.has_position || !d.has_direction)
    refuse("does not say where the slice lies; expected Image Position and Image Orientation (Patient)");
  if (!d.has_spacing) refuse("does not say how far its pixels are apart; expected Pixel Spacing");
  for (const double l : {d.row_step_mm, d.column_step_mm})
    if (!(l >= VolumeLimits::min_step_mm && l <= VolumeLimits::max_step_mm))
      refuse("a pixel is " + std::to_string(l) + " mm long; expected 0.001 to 100 mm");
  if (std::abs(d.across.norm() - 1) > 0.01 || std::abs(d.down.norm() - 1) > 0.01 ||
      std::abs(d.across.dot(d.down)) > 0.01)
    refuse("the directions of the slice are not two unit vectors at a right angle");
  if (!std::isfinite(d.slope) || d.slope == 0) refuse("the rescale slope is 0");
  if (!d.compressed && d.pixel_bytes < size_t(d.frame + 1) * d.frame_bytes())
    DicomPixels().bytes_of(d);  // throws: they are cut short
  if (d.compressed) compression_of(d);
}

void check_same(const DicomFile& d, const DicomFile& a) {
  if (d.rows != a.rows || d.columns != a.columns)
    throw InputError(d.name(), 0,
                     "has " + std::to_string(d.columns) + " x " + std::to_string(d.rows) + " pixels, " + a.name() +
                         " of the same series has " + std::to_string(a.columns) + " x " + std::to_string(a.rows) +
                         "; slices of one size were expected");
  if (std::abs(d.row_step_mm - a.row_step_mm) > 1e-3 * a.row_step_mm ||
      std::abs(d.column_step_mm - a.column_step_mm) > 1e-3 * a.column_step_mm)
    throw InputError(d.name(), 0, "has another pixel spacing than " + a.name() + " of the same series");
  if ((d.across - a.across).norm() > 1e-3 || (d.down - a.down).norm() > 1e-3)
    throw InputError(d.name(), 0, "lies in another direction than " + a.name() + " of the same series");
}

/// Gaps, one by one: what is refused, and what is said.
struct Gaps {
  size_t even = 0;
  int missing = 0;              // slices that an even series lacks
  std::vector<size_t> lacking;  // gaps where they lack
};

Gaps check_gaps(const std::vector<DicomFile>& f, const SlicePlaces& p, bool bridge_missing,
                std::vector<std::string>& notes) {
  Gaps out;
  const size_t n = p.gap.size();
  for (size_t i = 0; i < n; ++i) {
    if (p.gap[i] < 1e-3)
      throw InputError(
          f[i + 1].name(), 0,
          "lies where " + f[i].name() + " lies; slices at different places were expected (two series mixed?)");
    out.even += std::abs(p.gap[i] - p.median_mm) <= kEven * p.median_mm;
  }
  const bool nearly_even = 10 * out.even >= 8 * n;
  std::vector<size_t> wide;
  for (size_t i = 0; i < n; ++i) {
    const double k = p.gap[i] / p.median_mm, whole = std::round(k);
    const bool lacks = nearly_even && whole >= 2 && std::abs(k - whole) < 0.05;
    if (lacks && !bridge_missing)
      throw InputError(f[i].name(), 0,
                       std::to_string(int(whole) - 1) + (whole < 2.5 ? " slice is" : " slices are") +
                           " missing between it and " + f[i + 1].name() + ": the gap is " + std::to_string(p.gap[i]) +
                           " mm, elsewhere " + std::to_string(p.median_mm) +
                           " mm; expected all slices (limberg fit --bridge-missing interpolates them)");
    if (p.gap[i] > kWidestGap_mm && std::abs(p.gap[i] - p.median_mm) > kEven * p.median_mm)
      throw InputError(
          f[i].name(), 0,
          "the gap to " + f[i + 1].name() + " is " + std::to_string(p.gap[i]) + " mm; at most 10 mm are bridged");
    if (lacks) {
      out.missing += int(whole) - 1, out.lacking.push_back(i);
    } else if (k > kWideGap && (i == 0 || p.gap[i] > kWideGap * p.gap[i - 1]) &&
               (i + 1 == n || p.gap[i] > kWideGap * p.gap[i + 1])) {
      wide.push_back(i);
    }
  }
  const auto places = [&](const std::vector<size_t>& gaps) {
    std::string s;
    for (size_t i = 0; i < gaps.size() && i < kPlacesNamed; ++i)
      s += fmt::format("{}{:.4g} to {:.4g}", i ? ", " : "", p.z_mm[gaps[i]], p.z_mm[gaps[i] + 1]);
    return s + (gaps.size() > kPlacesNamed ? ", and elsewhere" : "") + " mm along the slices' normal";
  };
  if (out.missing > 0)
    notes.push_back(fmt::format("{} {} missing, from {}: bridged by linear interpolation", out.missing,
                                out.missing == 1 ? "slice is" : "slices are", places(out.lacking)));
  if (!wide.empty())
    notes.push_back(fmt::format(
        "{} between slices {} more than 1.8 times those beside {}, from {}: a slice may be missing there; bridged by "
        "linear interpolation",
        wide.size() == 1 ? "a gap" : std::to_string(wide.size()) + " gaps", wide.size() == 1 ? "is" : "are",
        wide.size() == 1 ? "it" : "them", places(wide)));
  return out;
}

}  // namespace

SlicePlaces places_of(std::vector<DicomFile>& f) {
  SlicePlaces p;
  const DicomFile a = f.front();
  p.across = a.across.normalized();
  p.down = (a.down - p.across * p.across.dot(a.down)).normalized();
  p.normal = p.across.cross(p.down);
  std::stable_sort(f.begin(), f.end(), [&](const DicomFile& x, const DicomFile& y) {
    return p.normal.dot(x.position_mm) < p.normal.dot(y.position_mm);
  });
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();
  for (const DicomFile& d : f) {
    p.z_mm.push_back(p.normal.dot(d.position_mm));
    if (p.z_mm.size() > 1) p.gap.push_back(p.z_mm.back() - p.z_mm[p.z_mm.size() - 2]);
    const Vec3 way = d.position_mm - f.front().position_mm;
    p.drift_mm.emplace_back(p.across.dot(way), p.down.dot(way));
    low = low.cwiseMin(p.drift_mm.back()), high = high.cwiseMax(p.drift_mm.back());
  }
  if (p.gap.empty()) return p;
  std::vector<double> sorted = p.gap;
  std::sort(sorted.begin(), sorted.end());
  p.median_mm = sorted[sorted.size() / 2];
  p.tilted = (high - low).maxCoeff() > 0.05 * std::min(a.column_step_mm, a.row_step_mm);
  const double whole_mm = p.z_mm.back() - p.z_mm.front();
  if (p.tilted && whole_mm > 0) {
    const Vec2& d = p.drift_mm.back();
    p.tilt_deg = elementary::atan2(d.y() < 0 ? -d.norm() : d.norm(), whole_mm) * 180 / M_PI;
  }
  return p;
}

SeriesGrid grid_of(DicomSeries& s, bool bridge_missing) {
  std::vector<DicomFile>& f = s.slice;
  for (const DicomFile& d : f) check_slice(d);
  for (const DicomFile& d : f) check_same(d, f.front());
  if (f.size() < 2) throw InputError(f.front().name(), 0, "the series has only this slice; at least 2 were expected");
  SeriesGrid g;
  g.at = places_of(f);
  const SlicePlaces& p = g.at;
  const DicomFile& a = f.front();
  const size_t n = f.size();
  const double dx = a.column_step_mm, dy = a.row_step_mm, whole_mm = p.z_mm.back() - p.z_mm.front();
  g.size = {a.columns, a.rows, int64_t(n)};
  if (p.tilted) {
    Vec2 low = Vec2::Zero(), high = Vec2::Zero();
    double bend = 0;  // of the drift beside an even one
    for (size_t i = 0; i < n; ++i) {
      low = low.cwiseMin(p.drift_mm[i]), high = high.cwiseMax(p.drift_mm[i]);
      bend = std::max(
          bend, (p.drift_mm[i] - p.drift_mm.back() * ((p.z_mm[i] - p.z_mm[0]) / std::max(whole_mm, 1e-9))).norm());
    }
    g.first_mm = low;
    g.size[0] += int64_t(std::ceil((high - low).x() / dx - 1e-6));
    g.size[1] += int64_t(std::ceil((high - low).y() / dy - 1e-6));
    g.notes.push_back(bend > 0.5 * std::min(dx, dy)
                          ? fmt::format("the slices drift in their own plane, by {:.3g} mm: evened out by linear "
                                        "interpolation",
                                        (high - low).maxCoeff())
                          : fmt::format("the gantry was tilted by {:.1f} degrees: the sheared grid is evened out by "
                                        "linear interpolation",
                                        p.tilt_deg));
  }
  const Gaps gaps = check_gaps(f, p, bridge_missing, g.notes);
  const auto [least, most] = std::minmax_element(p.gap.begin(), p.gap.end());
  g.resampled = gaps.even < p.gap.size();
  if (!g.resampled) {
    g.step_mm = whole_mm / double(n - 1);
  } else if (gaps.even + gaps.lacking.size() == p.gap.size()) {  // even but for those that lack: slices stay in place
    g.size[2] = int64_t(n) + gaps.missing;
    g.step_mm = whole_mm / double(g.size[2] - 1);
  } else {
    g.step_mm = std::max(*least, whole_mm / double(4 * n));
    g.size[2] = int64_t(std::floor(whole_mm / g.step_mm + 1e-6)) + 1;
    g.notes.push_back(
        fmt::format("gaps between slices are uneven, {:.4g} to {:.4g} mm: slices are every {:.4g} mm now, by linear "
                    "interpolation",
                    *least, *most, g.step_mm));
  }
  Mat3 step_mm;
  step_mm.col(0) = dx * p.across, step_mm.col(1) = dy * p.down, step_mm.col(2) = g.step_mm * p.normal;
  check_extent(g.size, step_mm, a.file);
  return g;
}

}  // namespace limberg::imaging
