#pragma once
// One DICOM series as a volume (dicom.h says what is read, evened out and refused).
#include <array>
#include <string>
#include <vector>

#include "sim/imaging/io/dicom_folder.h"
#include "sim/imaging/io/volume.h"

namespace limberg::imaging {

/// Where the slices of a series lie. Sorted along their normal.
struct SlicePlaces {
  Vec3 across, down, normal;      // unit vectors at right angles
  std::vector<double> z_mm, gap;  // of each slice along the normal; from each to the next
  double median_mm = 0;           // of the gaps
  std::vector<Vec2> drift_mm;     // of each slice in its own plane, from the first
  bool tilted = false;            // they drift by more than a twentieth of a pixel
  double tilt_deg = 0;            // from the first to the last; above 0 towards `down`; 0 unless tilted
};
/// `slice` has at least one, each with place and direction; it is sorted.
SlicePlaces places_of(std::vector<DicomFile>& slice);

/// How a series becomes a grid, found without its pixels.
struct SeriesGrid {
  SlicePlaces at;
  bool resampled = false;  // along the normal: gaps are uneven
  double step_mm = 0;
  std::array<int64_t, 3> size{0, 0, 0};
  Vec2 first_mm = Vec2::Zero();  // where the grid begins in the plane of the first slice
  std::vector<std::string> notes;
};
/// Sorts the slices. InputError: what dicom.h refuses, as far as headers show it.
SeriesGrid grid_of(DicomSeries& s, bool bridge_missing);
LoadedVolume volume_of(DicomSeries& s, bool bridge_missing);

}  // namespace limberg::imaging
