#pragma once
// One slice of a DICOM file: what of it a volume needs.
//
// A file holds one slice, or several frames (Enhanced CT). Each frame is a slice here:
// it says itself where it lies, or the groups that all frames share do (PS3.3 C.7.6.16).
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg::imaging {

struct DicomFile {
  std::string file, syntax, series, description, modality;
  std::string patient, instance;              // PatientID, SOPInstanceUID
  std::string image_type, body_part, kernel;  // as written: ORIGINAL\\PRIMARY\\AXIAL, HEAD, H30s
  std::string stack;                          // of the frames that make up one volume; may be empty
  int32_t rows = 0, columns = 0, samples = 1;
  int32_t frames = 1;  // of the file
  int32_t frame = 0;   // this one's number, from 0; -1: no group says where each of several lies
  int32_t allocated = 0, stored = 0, high_bit = -1;
  bool is_signed = false;
  double slope = 1, intercept = 0;
  bool has_padding = false;
  int32_t padding = 0, padding_limit = 0;
  bool has_position = false, has_direction = false, has_spacing = false;
  Vec3 position_mm = Vec3::Zero(), across = Vec3::UnitX(),
       down = Vec3::UnitY();                   // unit vectors along a row, along a column
  double row_step_mm = 1, column_step_mm = 1;  // between rows, between columns
  bool has_pixels = false, compressed = false;
  size_t pixels_at = 0, pixel_bytes = 0;  // of all frames

  /// Of one frame, plain.
  size_t frame_bytes() const { return size_t(rows) * size_t(columns) * size_t(allocated / 8); }
  /// For messages: the file, and which of its frames.
  std::string name() const { return frames == 1 || frame < 0 ? file : file + ", frame " + std::to_string(frame + 1); }
};

constexpr size_t kDicomBytes = size_t(1) << 30;  // largest file
constexpr int32_t kDicomFrames = 20'000;         // most frames of a file

/// Whole file as text, or its beginning up to the pixels at least; `file_bytes`: of the whole file (0: these are all).
/// One entry for each frame, at least one. Throws InputError: no DICOM, cut short, an element that does not fit, a
/// transfer syntax that is not read, more frames than kDicomFrames, groups for another number than there are.
std::vector<DicomFile> parse_dicom(std::string_view bytes, const std::string& file, size_t file_bytes = 0);
/// Reads no more of a file than it must. InputError as parse_dicom, and as read_whole_file.
std::vector<DicomFile> read_dicom_header(const std::string& file);

}  // namespace limberg::imaging
