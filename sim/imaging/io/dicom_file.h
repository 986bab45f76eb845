#pragma once
// One DICOM file: what of it a volume needs.
#include <cstdint>
#include <string>
#include <string_view>

#include "sim/geometry/vec.h"

namespace limberg::imaging {

struct DicomFile {
  std::string file, syntax, series, description, modality;
  std::string patient, instance;              // PatientID, SOPInstanceUID
  std::string image_type, body_part, kernel;  // as written: ORIGINAL\\PRIMARY\\AXIAL, HEAD, H30s
  int32_t rows = 0, columns = 0, samples = 1, frames = 1;
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
  size_t pixels_at = 0, pixel_bytes = 0;
};

constexpr size_t kDicomBytes = size_t(1) << 30;  // largest file

/// Whole file as text, or its beginning up to the pixels at least; `file_bytes`: of the whole file (0: these are all).
/// Throws InputError: no DICOM, cut short, an element that does not fit, a transfer syntax that is not read.
DicomFile parse_dicom(std::string_view bytes, const std::string& file, size_t file_bytes = 0);
/// Reads no more of a file than it must. InputError as parse_dicom, and as read_whole_file.
DicomFile read_dicom_header(const std::string& file);

}  // namespace limberg::imaging
