// Photographs: what a camera or a scanner lays on a face is a JPEG file, and pages hold their pictures so.
#include <fmt/format.h>

#include <algorithm>
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

// clang-format off: it uses what stands above.
#include <jpeglib.h>
// clang-format on

#include "render/image.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

/// libjpeg reports errors by a call that must not return; as with libpng (image.cpp) it jumps, over nothing that has a
/// destructor.
struct JpegError {
  jpeg_error_mgr manager;
  std::jmp_buf back;
  bool cut_short = false;
};
[[noreturn]] void jpeg_leave(j_common_ptr c) { std::longjmp(reinterpret_cast<JpegError*>(c->err)->back, 1); }
void jpeg_silent(j_common_ptr) {}
/// Warnings: what is cut short goes on in grey, which nobody sees as damage.
void jpeg_warned(j_common_ptr c, int level) {
  if (level < 0) reinterpret_cast<JpegError*>(c->err)->cut_short = true;
}

enum class JpegRead { whole, damaged, too_large, four_inks };

JpegRead read_jpeg_rows(std::string_view bytes, Image& image) {
  jpeg_decompress_struct d;
  JpegError error;
  d.err = jpeg_std_error(&error.manager);
  error.manager.error_exit = jpeg_leave;
  error.manager.output_message = jpeg_silent;
  error.manager.emit_message = jpeg_warned;
  if (setjmp(error.back)) {
    jpeg_destroy_decompress(&d);
    return JpegRead::damaged;
  }
  jpeg_create_decompress(&d);
  jpeg_mem_src(&d, reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&d, TRUE);
  JpegRead out = JpegRead::whole;
  if (d.image_width > kMostPngSide || d.image_height > kMostPngSide ||
      size_t(d.image_width) * d.image_height > kMostPixels)
    out = JpegRead::too_large;  // before room is asked for
  else if (d.num_components != 1 && d.num_components != 3)
    out = JpegRead::four_inks;
  if (out != JpegRead::whole) {
    jpeg_destroy_decompress(&d);
    return out;
  }
  d.out_color_space = JCS_RGB;
  d.dct_method = JDCT_ISLOW;                         // the same bits with and without vector instructions
  d.mem->max_memory_to_use = long(kMostPixels) * 8;  // of a progressive picture
  jpeg_start_decompress(&d);
  image.width = int(d.output_width), image.height = int(d.output_height);
  const size_t stride = 3 * size_t(image.width);
  image.rgb.resize(stride * size_t(image.height));
  while (d.output_scanline < d.output_height && !error.cut_short) {
    JSAMPROW row = image.rgb.data() + stride * d.output_scanline;
    jpeg_read_scanlines(&d, &row, 1);
  }
  if (!error.cut_short) jpeg_finish_decompress(&d);
  jpeg_destroy_decompress(&d);
  return error.cut_short ? JpegRead::damaged : JpegRead::whole;
}

struct JpegBytes {
  unsigned char* at = nullptr;  // libjpeg's
  unsigned long size = 0;
};

/// False where libjpeg has no room.
bool write_jpeg_rows(const Image& image, int quality, JpegBytes& out) {
  jpeg_compress_struct c;
  JpegError error;
  c.err = jpeg_std_error(&error.manager);
  error.manager.error_exit = jpeg_leave;
  error.manager.output_message = jpeg_silent;
  if (setjmp(error.back)) {
    jpeg_destroy_compress(&c);
    return false;
  }
  jpeg_create_compress(&c);
  jpeg_mem_dest(&c, &out.at, &out.size);
  c.image_width = JDIMENSION(image.width), c.image_height = JDIMENSION(image.height);
  c.input_components = 3, c.in_color_space = JCS_RGB;
  jpeg_set_defaults(&c);
  jpeg_set_quality(&c, quality, TRUE);
  for (int k = 0; k < c.num_components; ++k)  // thin lines of colour stay
    c.comp_info[k].h_samp_factor = c.comp_info[k].v_samp_factor = 1;
  c.dct_method = JDCT_ISLOW;  // the same bits with and without vector instructions
  c.optimize_coding = TRUE;
  jpeg_start_compress(&c, TRUE);
  const size_t stride = 3 * size_t(image.width);
  while (c.next_scanline < c.image_height) {
    JSAMPROW row = const_cast<JSAMPROW>(image.rgb.data() + stride * c.next_scanline);
    jpeg_write_scanlines(&c, &row, 1);
  }
  jpeg_finish_compress(&c);
  jpeg_destroy_compress(&c);
  return true;
}

}  // namespace

std::string encode_jpeg(const Image& image, int quality) {
  if (image.empty() || std::max(image.width, image.height) > JPEG_MAX_DIMENSION) return {};
  JpegBytes bytes;
  const bool whole = write_jpeg_rows(image, quality, bytes);
  std::string out;
  if (whole) out.assign(reinterpret_cast<const char*>(bytes.at), bytes.size);
  std::free(bytes.at);
  return out;
}

Image decode_jpeg(std::string_view bytes, const std::string& name) {
  if (!is_jpeg(bytes)) throw InputError(name, 0, "is not a JPEG picture; expected one");
  Image image;
  switch (read_jpeg_rows(bytes, image)) {
    case JpegRead::whole:
      return image;
    case JpegRead::damaged:
      throw InputError(name, 0, "is a damaged JPEG picture; expected a whole one");
    case JpegRead::too_large:
      throw InputError(name, 0,
                       fmt::format("says that it is a larger picture than is read; expected at most {} pixels and {} a "
                                   "side",
                                   kMostPixels, kMostPngSide));
    case JpegRead::four_inks:
      throw InputError(name, 0, "is a JPEG picture of four inks, for print; expected one in colours or in grey");
  }
  return image;
}

}  // namespace limberg
