#pragma once
// The files of a folder of DICOM slices, by series (dicom.h).
#include <string>
#include <vector>

#include "sim/imaging/io/dicom_file.h"

namespace limberg::imaging {

struct DicomFolderLimits {
  static constexpr int depth = 8;         // folders within folders
  static constexpr int entries = 20'000;  // files and folders
};

/// Slices of one series; of a file with several stacks of frames, those of one stack.
struct DicomSeries {
  std::string patient, uid;
  std::vector<DicomFile> slice;  // in the order of their files' names
};

struct DicomFolder {
  std::vector<DicomSeries> series;  // in the order of their first files' names
  int other_files = 0, without_pixels = 0, copies = 0, too_deep = 0;
  std::vector<std::string> unread;  // files and folders that cannot be read: name and reason

  /// What was passed over, in sentences.
  std::vector<std::string> notes() const;
};

/// A file of a medium's directory, by its name.
bool is_dicomdir(const std::string& path);
/// InputError: it cannot be read, holds too many entries, or no slice.
DicomFolder read_dicom_folder(const std::string& folder, bool with_subfolders);

}  // namespace limberg::imaging
