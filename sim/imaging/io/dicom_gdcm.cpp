#include "sim/imaging/io/dicom.h"

#ifdef LIMBERG_HAS_GDCM
#include <gdcmImage.h>
#include <gdcmImageReader.h>

#include "sim/base/error.h"
#endif

namespace limberg::imaging {

#ifdef LIMBERG_HAS_GDCM
bool gdcm_pixels(const std::string& file, size_t bytes, std::string& out) {
  gdcm::ImageReader reader;
  reader.SetFileName(file.c_str());
  if (!reader.Read())
    throw InputError(file, 0, "its compressed pixels cannot be read by GDCM; the file may be damaged");
  const gdcm::Image& image = reader.GetImage();
  if (image.GetBufferLength() != bytes)
    throw InputError(file, 0,
                     "its compressed pixels come to " + std::to_string(image.GetBufferLength()) + " bytes; " +
                         std::to_string(bytes) + " were expected");
  out.resize(bytes);
  if (!image.GetBuffer(out.data()))
    throw InputError(file, 0, "its compressed pixels cannot be unpacked by GDCM; the file may be damaged");
  return true;
}
#else
bool gdcm_pixels(const std::string&, size_t, std::string&) { return false; }
#endif

}  // namespace limberg::imaging
