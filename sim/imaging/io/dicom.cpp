#include "sim/imaging/io/dicom.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/imaging/io/dicom_folder.h"
#include "sim/imaging/io/dicom_pixels.h"
#include "sim/imaging/io/dicom_series.h"

namespace limberg::imaging {
namespace {

namespace fs = std::filesystem;

/// The folder that a path stands for; a slice is looked for among the files beside it only.
DicomFolder folder_of(const std::string& path) {
  std::error_code ec;
  if (fs::is_directory(path, ec)) return read_dicom_folder(path, true);
  const fs::path parent = fs::path(path).parent_path();
  return read_dicom_folder(parent.empty() ? "." : parent.string(), is_dicomdir(path));
}

bool names_one_slice(const std::string& path) {
  std::error_code ec;
  return !fs::is_directory(path, ec) && !is_dicomdir(path);
}

SeriesAbout about(DicomSeries& s, int number, const LoadSettings& settings) {
  SeriesAbout a;
  const DicomFile& d = s.slice.front();
  a.number = number, a.uid = s.uid, a.patient = s.patient, a.description = d.description, a.modality = d.modality;
  a.body_part = d.body_part, a.kernel = d.kernel, a.image_type = d.image_type;
  a.slices = int(s.slice.size()), a.columns = d.columns, a.rows = d.rows;
  a.column_step_mm = d.column_step_mm, a.row_step_mm = d.row_step_mm;
  try {
    if (d.compressed && !compression_of(d).run_length)
      if (const std::string why = why_no_gdcm(); !why.empty())
        throw InputError(d.file, 0, "its pixels are compressed (" + compression_of(d).name + "): " + why);
    grid_of(s, settings.bridge_missing);
  } catch (const InputError& e) {
    a.refused = e.what();
  }
  const bool placed = std::all_of(s.slice.begin(), s.slice.end(), [](const DicomFile& x) {
    return x.has_position && x.has_direction && x.across.cross(x.down).norm() > 0.9;
  });
  if (!placed) return a;
  const SlicePlaces p = places_of(s.slice);
  a.gap_mm = p.median_mm, a.tilt_deg = p.tilt_deg;
  a.extent_mm = {a.columns * a.column_step_mm, a.rows * a.row_step_mm, p.z_mm.back() - p.z_mm.front()};
  a.height_mm = std::abs(p.across.z()) * a.extent_mm.x() + std::abs(p.down.z()) * a.extent_mm.y() +
                std::abs(p.normal.z()) * a.extent_mm.z();
  a.axial = std::abs(p.normal.z()) >= p.normal.cwiseAbs().maxCoeff();
  return a;
}

/// A series by number, UID or part of its description.
size_t find_series(const DicomFolder& all, const std::string& wanted, const std::string& path,
                   const std::string& list) {
  std::vector<size_t> found;
  for (size_t i = 0; i < all.series.size() && found.empty(); ++i)
    if (wanted == std::to_string(i + 1)) found = {i};
  for (size_t i = 0; i < all.series.size() && found.empty(); ++i)
    if (wanted == all.series[i].uid) found.push_back(i);
  if (found.empty())
    for (size_t i = 0; i < all.series.size(); ++i)
      if (all.series[i].slice.front().description.find(wanted) != std::string::npos) found.push_back(i);
  if (found.size() != 1)
    throw InputError(path, 0,
                     std::string(found.empty() ? "no series is" : "several series are") + " named by \"" +
                         wanted.substr(0, 64) + "\"; expected one of them" + list);
  return found.front();
}

/// A refusal that may come of files which were passed over says so.
[[noreturn]] void refuse_with(const InputError& e, const std::vector<std::string>& unread) {
  std::string what = e.what();
  if (const std::string file = e.file() + ": "; !e.file().empty() && what.starts_with(file)) what.erase(0, file.size());
  if (!unread.empty())
    what += "; " + std::to_string(unread.size()) +
            " of its folder cannot be read, the first of them: " + unread.front().substr(0, 400);
  throw InputError(e.file(), e.line(), what);
}

}  // namespace

bool looks_like_dicom(std::string_view head) { return head.size() >= 132 && head.substr(128, 4) == "DICM"; }

std::string line_of(const SeriesAbout& s) {
  return std::to_string(s.number) + ": " + (s.modality.empty() ? "" : s.modality.substr(0, 16) + " ") + "\"" +
         s.description.substr(0, 60) + "\", " + std::to_string(s.slices) + " slices of " + std::to_string(s.columns) +
         " x " + std::to_string(s.rows) + ", " + s.uid.substr(0, 64);
}

std::vector<SeriesAbout> list_series(const std::string& path, const LoadSettings& settings) {
  DicomFolder all = folder_of(path);
  std::vector<SeriesAbout> out;
  for (DicomSeries& s : all.series) out.push_back(about(s, int(out.size()) + 1, settings));
  return out;
}

LoadedVolume load_dicom(const std::string& path, const LoadSettings& settings) {
  std::string wanted = settings.series;
  DicomFile one;
  const bool by_slice = names_one_slice(path) && wanted.empty();
  if (by_slice) one = read_dicom_header(path).front();
  DicomFolder all = folder_of(path);
  const auto list = [&] {
    std::string s;
    const bool patients = std::any_of(all.series.begin(), all.series.end(),
                                      [&](const DicomSeries& x) { return x.patient != all.series.front().patient; });
    for (size_t i = 0; i < all.series.size() && i < 16; ++i) {
      const DicomSeries& x = all.series[i];
      SeriesAbout a;
      a.number = int(i) + 1, a.uid = x.uid, a.slices = int(x.slice.size());
      const DicomFile& d = x.slice.front();
      a.description = d.description, a.modality = d.modality, a.columns = d.columns, a.rows = d.rows;
      s += "; " + line_of(a) + (patients ? ", patient " + x.patient.substr(0, 32) : "");
    }
    return s;
  };
  size_t chosen = 0;
  const auto of_it = [&](const DicomSeries& x) { return x.uid == one.series && x.patient == one.patient; };
  const auto stacks = by_slice ? std::count_if(all.series.begin(), all.series.end(), of_it) : 0;
  if (stacks > 1)
    throw InputError(path, 0,
                     fmt::format("holds {} stacks of frames; expected --series with one of them", stacks) + list());
  if (by_slice) {
    chosen = size_t(std::find_if(all.series.begin(), all.series.end(), of_it) - all.series.begin());
    if (chosen == all.series.size()) throw InputError(path, 0, "has no pixels; expected a slice of a series");
  } else if (!wanted.empty()) {
    chosen = find_series(all, wanted, path, list());
  } else if (all.series.size() > 1) {
    throw InputError(
        path, 0, "holds " + std::to_string(all.series.size()) + " series; expected --series with one of them" + list());
  }
  try {
    LoadedVolume out = volume_of(all.series[chosen], settings.bridge_missing);
    for (std::string& n : all.notes()) out.notes.push_back(std::move(n));
    return out;
  } catch (const InputError& e) {
    refuse_with(e, all.unread);
  }
}

}  // namespace limberg::imaging
