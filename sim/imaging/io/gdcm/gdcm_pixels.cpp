// The part limberg-gdcm.so: compressed pixels by GDCM.
#include <gdcmImage.h>
#include <gdcmImageReader.h>
#include <gdcmTrace.h>

#include <exception>
#include <string>

/// What dicom_pixels.cpp asks for (UnpackPixels there). Nothing is thrown across the border of the part.
extern "C" __attribute__((visibility("default"))) void limberg_gdcm_pixels(const std::string& file, size_t bytes,
                                                                           std::string& out, std::string& why) {
  try {
    // What is wrong is said by the caller, once, and not on the terminal.
    gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff();
    gdcm::ImageReader reader;
    reader.SetFileName(file.c_str());
    if (!reader.Read()) {
      why = "its compressed pixels cannot be read by GDCM; the file may be damaged";
      return;
    }
    const gdcm::Image& image = reader.GetImage();
    if (image.GetBufferLength() != bytes) {
      why = "its compressed pixels come to " + std::to_string(image.GetBufferLength()) + " bytes; " +
            std::to_string(bytes) + " were expected";
      return;
    }
    out.resize(bytes);
    if (!image.GetBuffer(out.data())) why = "its compressed pixels cannot be unpacked by GDCM; the file may be damaged";
  } catch (const std::exception& e) {
    why = std::string("its compressed pixels cannot be unpacked by GDCM (") + e.what() + "); the file may be damaged";
  }
}
