#pragma once
// A volume of numbers (a CT in Hounsfield units, say) and where it lies.
//
// Read from NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI-1 (nifti.h) and DICOM series (dicom.h): three
// dimensions, one number per voxel, raw or compressed with gzip or zlib, in the file itself or beside it, either byte
// order. Places are in mm in the frame left, posterior, superior
// (files in right-anterior-superior are turned), with the whole affine: origin, spacing, direction.
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct Volume {
  std::array<int32_t, 3> size{0, 0, 0};
  Mat3 step_mm = Mat3::Identity();  // column k: from a voxel to the next along axis k
  Vec3 origin_mm = Vec3::Zero();    // centre of voxel (0, 0, 0)
  std::vector<float> value;         // axis 0 runs fastest

  size_t index(int32_t i, int32_t j, int32_t k) const {
    return size_t(i) + size_t(size[0]) * (size_t(j) + size_t(size[1]) * size_t(k));
  }
  Vec3 place(const Vec3& voxel) const { return origin_mm + step_mm * voxel; }
};

/// Sides of a voxel.
double longest_step_mm(const Volume& volume);
double shortest_step_mm(const Volume& volume);

/// Trilinear interpolation at places in mm; outside the outermost voxel centres the nearest value inside holds on.
class VolumeSampler {
 public:
  explicit VolumeSampler(const Volume& v) : v_(v), to_voxel_(v.step_mm.inverse()) {}
  double value(const Vec3& x_mm) const;
  /// Central difference over half of the smallest voxel side, per mm.
  Vec3 gradient(const Vec3& x_mm) const;
  bool inside(const Vec3& x_mm) const;

 private:
  const Volume& v_;
  Mat3 to_voxel_;
};

struct VolumeLimits {
  static constexpr int64_t voxels = int64_t(256) << 20;  // 512 x 512 x 1024: 1.1 GB in memory
  static constexpr double min_step_mm = 1e-3, max_step_mm = 100;
  static constexpr size_t header_bytes = size_t(1) << 20;
};

/// How a file or folder is read.
struct LoadSettings {
  std::string series;           // which one, where a folder holds several (dicom.h); empty: it holds one
  bool bridge_missing = false;  // slices that an even series lacks are interpolated, gaps of 10 mm at most
};
/// A volume and what was done to it or passed over, in sentences (a tilt evened out, gaps bridged).
struct LoadedVolume {
  Volume volume;
  std::vector<std::string> notes;
};

/// By its first bytes: NRRD, MetaImage, NIfTI-1, DICOM; a folder is one of DICOM slices, and so is a DICOMDIR. Throws
/// InputError(file, line, ...): a field missing or not understood, a size that is absurd or does not match the data, a
/// voxel without extent, data that are cut short or damaged.
LoadedVolume load_volume(const std::string& path, const LoadSettings& settings);
/// The same without its notes.
Volume load_volume(const std::string& path, const std::string& series = {});

}  // namespace limberg
