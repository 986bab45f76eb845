#pragma once
// JPEG files of several kinds for tests, written by libjpeg.
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>

// clang-format off: it uses what stands above.
#include <jpeglib.h>
// clang-format on

#include "render/image.h"

namespace limberg::test {

enum class JpegKind { baseline, progressive, grey, four_inks };

/// At quality 95, without thinning out of colours: within a few of 255 of the picture where it is smooth.
inline std::string jpeg_bytes(const Image& image, JpegKind kind = JpegKind::baseline) {
  jpeg_compress_struct c;
  jpeg_error_mgr error;
  c.err = jpeg_std_error(&error);
  jpeg_create_compress(&c);
  unsigned char* out = nullptr;
  unsigned long n = 0;
  jpeg_mem_dest(&c, &out, &n);
  c.image_width = JDIMENSION(image.width), c.image_height = JDIMENSION(image.height);
  c.input_components = kind == JpegKind::grey ? 1 : kind == JpegKind::four_inks ? 4 : 3;
  c.in_color_space = kind == JpegKind::grey ? JCS_GRAYSCALE : kind == JpegKind::four_inks ? JCS_CMYK : JCS_RGB;
  jpeg_set_defaults(&c);
  jpeg_set_quality(&c, 95, TRUE);
  if (kind == JpegKind::baseline || kind == JpegKind::progressive)
    c.comp_info[0].h_samp_factor = 1, c.comp_info[0].v_samp_factor = 1;
  if (kind == JpegKind::progressive) jpeg_simple_progression(&c);
  jpeg_start_compress(&c, TRUE);
  std::string row(size_t(c.input_components) * size_t(image.width), '\0');
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x)
      for (int k = 0; k < c.input_components; ++k) {
        const Rgb8 p = image.at(x, y);
        const uint8_t of[4] = {p.r, p.g, p.b, 0};
        row[size_t(x * c.input_components + k)] = char(of[k]);
      }
    auto* at = reinterpret_cast<JSAMPROW>(row.data());
    jpeg_write_scanlines(&c, &at, 1);
  }
  jpeg_finish_compress(&c);
  jpeg_destroy_compress(&c);
  std::string bytes(reinterpret_cast<const char*>(out), n);
  std::free(out);
  return bytes;
}

}  // namespace limberg::test
