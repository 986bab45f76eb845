#include "sim/imaging/io/dicom.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/imaging/io/dicom_file.h"
#include "sim/imaging/io/header.h"

namespace limberg::imaging {
namespace {

namespace fs = std::filesystem;
constexpr double kWidestGap_mm = 10;  // that is bridged by interpolation
constexpr double kAirBelow = -1500, kAirHU = -1000;

struct Series {
  struct About {
    std::string uid, description, modality;
    int slices = 0;
    int32_t columns = 0, rows = 0;
  } about;
  std::vector<DicomFile> slice;
};

std::vector<Series> gather(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code ec;
  for (fs::directory_iterator i(folder, ec), end; !ec && i != end; i.increment(ec))
    if (i->is_regular_file(ec)) files.push_back(i->path().string());
  if (ec) throw InputError(folder, 0, "the folder cannot be read (" + ec.message() + ")");
  std::sort(files.begin(), files.end());
  std::vector<Series> out;
  for (const std::string& f : files) {
    if (fs::path(f).filename() == "DICOMDIR" || !looks_like_dicom(read_beginning(f, 132))) continue;
    DicomFile d = parse_dicom(read_whole_file(f, kDicomBytes), f);
    if (!d.has_pixels) continue;  // structured reports, presentation states
    auto s = std::find_if(out.begin(), out.end(), [&](const Series& x) { return x.about.uid == d.series; });
    if (s == out.end()) {
      out.push_back({{d.series, d.description, d.modality, 0, d.columns, d.rows}, {}});
      s = out.end() - 1;
    }
    s->slice.push_back(std::move(d)), ++s->about.slices;
  }
  if (out.empty())
    throw InputError(folder, 0, "holds no DICOM slices; expected files with DICM behind 128 bytes and with pixels");
  return out;
}

std::string name_of(const Series& s) {
  return (s.about.modality.empty() ? "" : s.about.modality + " ") + "\"" + s.about.description.substr(0, 60) + "\", " +
         std::to_string(s.about.slices) + " slices of " + std::to_string(s.about.columns) + " x " +
         std::to_string(s.about.rows) + ", " + s.about.uid.substr(0, 64);
}

void check_slice(const DicomFile& d) {
  const auto refuse = [&](const std::string& what) { throw InputError(d.file, 0, what); };
  if (d.rows < 1 || d.columns < 1) refuse("the slice has no rows or columns");
  if (d.samples != 1) refuse("a pixel has " + std::to_string(d.samples) + " numbers (colour); one was expected");
  if (d.frames != 1) refuse("the file holds several frames; one slice per file was expected");
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
}

std::vector<float> pixels(const DicomFile& d) {
  const size_t n = size_t(d.rows) * size_t(d.columns), bytes = n * size_t(d.allocated / 8);
  std::string all;
  std::string_view data;
  if (d.compressed) {
    if (!gdcm_pixels(d.file, bytes, all))
      throw InputError(d.file, 0,
                       "its pixels are compressed (transfer syntax " + d.syntax +
                           "); expected Explicit or Implicit VR little endian, or a build with -DLIMBERG_GDCM=ON; a "
                           "converter such as gdcmconv --raw makes them plain");
    data = all;
  } else {
    all = read_whole_file(d.file, kDicomBytes);
    data = std::string_view(all).substr(std::min(d.pixels_at, all.size()));
  }
  if (data.size() < bytes || (!d.compressed && d.pixel_bytes < bytes))
    throw InputError(d.file, 0,
                     "the pixels are cut short: " + std::to_string(std::min(data.size(), d.pixel_bytes)) + " bytes; " +
                         std::to_string(bytes) + " were expected");
  std::vector<float> out(n);
  const int shift = d.high_bit >= 0 ? d.high_bit + 1 - d.stored : 0;
  const uint32_t mask = d.stored >= 32 ? ~0u : (1u << d.stored) - 1;
  const int32_t low = std::min(d.padding, d.padding_limit), high = std::max(d.padding, d.padding_limit);
  for (size_t i = 0; i < n; ++i) {
    const uint32_t word = d.allocated == 8 ? uint32_t(uint8_t(data[i]))
                                           : uint32_t(uint8_t(data[2 * i])) | uint32_t(uint8_t(data[2 * i + 1])) << 8;
    const uint32_t bits = word >> shift & mask;
    int32_t v = int32_t(bits);
    if (d.is_signed && bits >> (d.stored - 1) & 1) v -= int32_t(1) << d.stored;
    const int32_t pad = d.allocated == 16 && d.is_signed ? int32_t(int16_t(uint16_t(low))) : low,
                  pad_high = d.allocated == 16 && d.is_signed ? int32_t(int16_t(uint16_t(high))) : high;
    const bool padding = d.has_padding && v >= std::min(pad, pad_high) && v <= std::max(pad, pad_high);
    const double x = d.slope * v + d.intercept;
    if (!std::isfinite(x) || std::abs(x) > 1e9)
      throw InputError(d.file, 0, "a value is out of range once it is scaled");
    out[i] = padding || x < kAirBelow ? NAN : float(x);
  }
  return out;
}

Volume assemble(Series& s) {
  std::vector<DicomFile>& f = s.slice;
  for (const DicomFile& d : f) check_slice(d);
  const DicomFile& a = f.front();
  for (const DicomFile& d : f) {
    if (d.rows != a.rows || d.columns != a.columns)
      throw InputError(d.file, 0,
                       "has " + std::to_string(d.columns) + " x " + std::to_string(d.rows) + " pixels, " + a.file +
                           " of the same series has " + std::to_string(a.columns) + " x " + std::to_string(a.rows) +
                           "; slices of one size were expected");
    if (std::abs(d.row_step_mm - a.row_step_mm) > 1e-3 * a.row_step_mm ||
        std::abs(d.column_step_mm - a.column_step_mm) > 1e-3 * a.column_step_mm)
      throw InputError(d.file, 0, "has another pixel spacing than " + a.file + " of the same series");
    if ((d.across - a.across).norm() > 1e-3 || (d.down - a.down).norm() > 1e-3)
      throw InputError(d.file, 0, "lies in another direction than " + a.file + " of the same series");
  }
  if (f.size() < 2) throw InputError(a.file, 0, "the series has only this slice; at least 2 were expected");
  const Vec3 across = a.across.normalized(), down = (a.down - across * across.dot(a.down)).normalized(),
             normal = across.cross(down);
  std::stable_sort(f.begin(), f.end(), [&](const DicomFile& x, const DicomFile& y) {
    return normal.dot(x.position_mm) < normal.dot(y.position_mm);
  });
  const size_t n = f.size();
  std::vector<double> z(n), gap(n - 1);
  for (size_t i = 0; i < n; ++i) z[i] = normal.dot(f[i].position_mm);
  for (size_t i = 0; i + 1 < n; ++i) gap[i] = z[i + 1] - z[i];
  std::vector<double> sorted = gap;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[sorted.size() / 2];
  size_t even = 0;
  for (size_t i = 0; i + 1 < n; ++i) {
    if (gap[i] < 1e-3)
      throw InputError(
          f[i + 1].file, 0,
          "lies where " + f[i].file + " lies; slices at different places were expected (two series mixed?)");
    even += std::abs(gap[i] - median) <= 0.02 * median;
  }
  const bool nearly_even = 10 * even >= 8 * gap.size();
  for (size_t i = 0; i + 1 < n; ++i) {
    const double k = gap[i] / median, whole = std::round(k);
    if (nearly_even && whole >= 2 && std::abs(k - whole) < 0.05)
      throw InputError(f[i].file, 0,
                       std::to_string(int(whole) - 1) + " slices are missing between it and " + f[i + 1].file +
                           ": the gap is " + std::to_string(gap[i]) + " mm, elsewhere " + std::to_string(median) +
                           " mm");
    if (gap[i] > kWidestGap_mm && std::abs(gap[i] - median) > 0.02 * median)
      throw InputError(
          f[i].file, 0,
          "the gap to " + f[i + 1].file + " is " + std::to_string(gap[i]) + " mm; at most 10 mm are bridged");
  }
  // How far the slices drift in their own plane.
  std::vector<Vec2> drift(n);
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();
  for (size_t i = 0; i < n; ++i) {
    const Vec3 d = f[i].position_mm - f[0].position_mm;
    drift[i] = {across.dot(d), down.dot(d)};
    low = low.cwiseMin(drift[i]), high = high.cwiseMax(drift[i]);
  }
  const double dx = a.column_step_mm, dy = a.row_step_mm;
  const bool tilted = (high - low).maxCoeff() > 0.05 * std::min(dx, dy), uneven = even < gap.size();
  Volume v;
  const double step = uneven ? std::max(sorted.front(), (z.back() - z.front()) / double(4 * n))
                             : (z.back() - z.front()) / double(n - 1);
  std::array<int64_t, 3> size{a.columns, a.rows, int64_t(n)};
  Vec2 first = Vec2::Zero();
  if (tilted) {
    first = low;
    size[0] += int64_t(std::ceil((high - low).x() / dx - 1e-6)),
        size[1] += int64_t(std::ceil((high - low).y() / dy - 1e-6));
  }
  if (uneven) size[2] = int64_t(std::floor((z.back() - z.front()) / step + 1e-6)) + 1;
  v.step_mm.col(0) = dx * across, v.step_mm.col(1) = dy * down, v.step_mm.col(2) = step * normal;
  v.origin_mm = f[0].position_mm + first.x() * across + first.y() * down;
  check_extent(size, v.step_mm, a.file);
  // What the files can hold, before memory is asked for.
  for (const DicomFile& d : f)
    if (!d.compressed && d.pixel_bytes < size_t(d.rows) * size_t(d.columns) * size_t(d.allocated / 8))
      pixels(d);  // throws
  for (size_t k = 0; k < 3; ++k) v.size[k] = int32_t(size[k]);
  const size_t plane = size_t(size[0]) * size_t(size[1]);
  v.value.reserve(plane * size_t(size[2]));
  // One slice as it lies on the grid of the volume; NaN: nothing there.
  const auto on_grid = [&](size_t i) {
    std::vector<float> in = pixels(f[i]);
    if (!tilted) return in;
    std::vector<float> out(plane, NAN);
    const double sx = (drift[i] - first).x() / dx, sy = (drift[i] - first).y() / dy;
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
  };
  std::vector<float> below, above;
  size_t at = 0, have_below = n, have_above = n;
  for (int64_t k = 0; k < size[2]; ++k) {
    const double place = uneven ? z[0] + double(k) * step : z[size_t(k)];
    if (!uneven)
      at = size_t(k);
    else
      while (at + 2 < n && z[at + 1] <= place) ++at;
    if (have_below != at)
      below = have_above == at ? std::move(above) : on_grid(at), have_below = at,
      have_above = have_above == at ? n : have_above;
    const double t = uneven ? std::clamp((place - z[at]) / gap[at], 0., 1.) : 0;
    if (t > 0 && have_above != at + 1) above = on_grid(at + 1), have_above = at + 1;
    for (size_t i = 0; i < plane; ++i)
      v.value.push_back(t > 0 ? float(1 - t) * below[i] + float(t) * above[i] : below[i]);
  }
  float least = std::numeric_limits<float>::infinity();
  for (const float x : v.value)
    if (std::isfinite(x)) least = std::min(least, x);
  const float air = std::isfinite(least) ? std::max(float(kAirHU), least) : float(kAirHU);
  for (float& x : v.value)
    if (!std::isfinite(x)) x = air;
  return v;
}

}  // namespace

bool looks_like_dicom(std::string_view head) { return head.size() >= 132 && head.substr(128, 4) == "DICM"; }

Volume load_dicom(const std::string& path, const std::string& asked) {
  std::error_code ec;
  const bool folder = fs::is_directory(path, ec);
  std::string wanted = asked;
  if (!folder && wanted.empty()) wanted = parse_dicom(read_whole_file(path, kDicomBytes), path).series;
  const fs::path parent = fs::path(path).parent_path();
  std::vector<Series> all = gather(folder ? path : parent.empty() ? "." : parent.string());
  const auto list = [&] {
    std::string s;
    for (size_t i = 0; i < all.size() && i < 20; ++i) s += "; " + std::to_string(i + 1) + ": " + name_of(all[i]);
    return s;
  };
  if (wanted.empty()) {
    if (all.size() > 1)
      throw InputError(path, 0,
                       "holds " + std::to_string(all.size()) + " series; expected --series with one of them" + list());
    return assemble(all.front());
  }
  Series* found = nullptr;
  int matches = 0;
  for (size_t i = 0; i < all.size(); ++i)
    if (wanted == std::to_string(i + 1) || wanted == all[i].about.uid) found = &all[i], matches = 1, i = all.size();
  if (!found)
    for (Series& s : all)
      if (s.about.description.find(wanted) != std::string::npos) found = &s, ++matches;
  if (matches != 1)
    throw InputError(path, 0,
                     std::string(matches == 0 ? "no series is" : "several series are") + " named by \"" +
                         wanted.substr(0, 64) + "\"; expected one of them" + list());
  return assemble(*found);
}

}  // namespace limberg::imaging
