#pragma once
// The pixels of one DICOM file as bytes: plain, run lengths (unpacked here), or by GDCM (the part limberg-gdcm.so).
#include <string>

#include "sim/imaging/io/dicom_file.h"

namespace limberg::imaging {

/// What a transfer syntax is called, "JPEG lossless, 1.2.840.10008.1.2.4.70" say; `lossy`: it loses something.
struct Compression {
  std::string name;
  bool lossy = false, run_length = false;
};
/// InputError where neither this program nor GDCM reads it.
Compression compression_of(const DicomFile& d);

/// Why compressed pixels other than run lengths cannot be read; empty: they can.
std::string why_no_gdcm();

/// Reads slices one after the other. Of a compressed file of several frames, what it holds is kept for the next of its
/// frames: only the last file.
class DicomPixels {
 public:
  /// rows x columns numbers of allocated / 8 bytes each, lowest byte first. InputError: cut short, damaged, a
  /// compression that is not read.
  std::string bytes_of(const DicomFile& d);

 private:
  std::string file_, kept_;  // as packed (run lengths), or plain
};

}  // namespace limberg::imaging
