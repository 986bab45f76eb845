#pragma once
// Small sound files of every kind that the readers of images and
// surfaces take, as bytes: what the fuzzer damages, and what tests read.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg::fuzz {

/// A number into the bytes of a file, in either byte order.
template <class T>
void put(std::string& s, size_t at, T v, bool big) {
  char b[sizeof(T)];
  std::memcpy(b, &v, sizeof(T));
  if (big) std::reverse(b, b + sizeof(T));
  std::memcpy(s.data() + at, b, sizeof(T));
}

/// What voxel (i, j, k) of nifti() holds before slope and intercept.
inline double nifti_voxel(int i, int j, int k) { return 100 + i + 10 * j - 7 * k; }
/// NIfTI-1, 3 x 4 x 5 of int16, spacing 2, 3, 4 mm. `form`: 1
/// its place is a qform without a turn, 2 an sform, 0 neither.
std::string nifti(bool big, int form, float slope = 1, float intercept = 0);

/// NRRD and MetaImage, 3 x 4 x 5 of int16, with the data behind the header; `packed`: through zlib or gzip.
std::string nrrd(bool packed);
std::string meta_image(bool packed);

/// One slice of a DICOM series.
struct Slice {
  bool explicit_vr = true, sequence = true;
  std::string series = "1.2.3", description = "head", syntax;  // syntax: empty for the plain one
  Vec3 at = Vec3::Zero();
  int columns = 6, rows = 5, number = 0;
  double slope = 1, intercept = 0, spacing = 2;
  std::function<int16_t(int, int)> value = [](int i, int j) { return int16_t(i + 10 * j); };
  std::string modality = "CT";
  std::string image_type, body_part, kernel, patient;  // empty: not in the file
  Vec3 across = Vec3::UnitX(), down = Vec3::UnitY();
  int padding = 0, frames = 1;  // 0: none
  bool run_length = false;      // pixels in fragments, run length encoded (PS3.5 annex G)
  std::string stack = "1";      // of a frame
};
std::string dicom(const Slice& slice);
/// Enhanced CT: all in one file, each with a group of its own; what is of the whole file is the first slice's.
/// Sequences are with their lengths or without.
std::string enhanced_dicom(const std::vector<Slice>& frames, bool with_lengths);

/// A tetrahedron of volume 1: corners (0 0 0), (1 0 0), (0 2 0), (0 0 3). STL and PLY as text or binary.
std::string obj_file();
std::string stl_file(bool binary);
enum class Ply { text, little, big };
std::string ply_file(Ply form);

}  // namespace limberg::fuzz
