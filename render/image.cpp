#include "render/image.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {

Image::Image(int w, int h, Rgb8 fill) : width(w), height(h), rgb(3 * size_t(w) * size_t(h)) {
  for (size_t i = 0; i < rgb.size(); i += 3) rgb[i] = fill.r, rgb[i + 1] = fill.g, rgb[i + 2] = fill.b;
}

void Image::blend(int x, int y, Rgb8 c, double alpha) {
  if (!contains(x, y) || alpha <= 0) return;
  const double a = std::min(alpha, 1.0);
  uint8_t* p = &rgb[3 * (size_t(y) * size_t(width) + size_t(x))];
  p[0] = uint8_t(std::lround(p[0] + (c.r - p[0]) * a));
  p[1] = uint8_t(std::lround(p[1] + (c.g - p[1]) * a));
  p[2] = uint8_t(std::lround(p[2] + (c.b - p[2]) * a));
}

namespace {

// libpng reports errors by a call that must not return; an exception leaves its C frames, so it jumps to setjmp. The
// functions below keep everything with a destructor outside of the part that may be jumped over.
[[noreturn]] void leave(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void ignore(png_structp, png_const_charp) {}

void append(png_structp png, png_bytep data, png_size_t n) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), n);
}
void flush_nothing(png_structp) {}

void take(png_structp png, png_bytep data, png_size_t n) {
  std::string_view& left = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (n > left.size()) png_error(png, "cut short");
  std::memcpy(data, left.data(), n);
  left.remove_prefix(n);
}

bool encode_rows(const Image& image, std::string& out) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, ignore);
  if (!png) return false;
  png_infop info = png_create_info_struct(png);
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &out, append, flush_nothing);
  png_set_IHDR(png, info, png_uint_32(image.width), png_uint_32(image.height), 8, PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, 3);  // five times faster than the default and barely larger on rendered pictures
  png_set_filter(png, 0, PNG_FILTER_UP);
  png_write_info(png, info);
  const size_t stride = 3 * size_t(image.width);
  for (int y = 0; y < image.height; ++y) png_write_row(png, image.rgb.data() + stride * size_t(y));
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

// libpng believes the length that a chunk claims, and clears as much: 1.8 GB for a file of 100 bytes. No chunk that is
// read, and no row, needs more than the largest file.
png_voidp room_within_file(png_structp, png_alloc_size_t n) { return n > kMostPng ? nullptr : std::malloc(n); }
void return_room(png_structp, png_voidp room) { std::free(room); }

/// `too_large`: why not.
bool read_rows(std::string_view bytes, Image& image, bool& too_large) {
  png_structp png =
      png_create_read_struct_2(PNG_LIBPNG_VER_STRING, nullptr, leave, ignore, nullptr, room_within_file, return_room);
  if (!png) return false;
  png_infop info = png_create_info_struct(png);
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // ours follow, and are told
  png_set_read_fn(png, &bytes, take);
  png_read_info(png, info);
  const size_t wide = png_get_image_width(png, info), high = png_get_image_height(png, info);
  too_large = wide > kMostPngSide || high > kMostPngSide || wide * high > kMostPixels;
  if (too_large) png_error(png, "too large");  // before room is asked for
  png_set_expand(png);
  png_set_strip_16(png);
  png_set_strip_alpha(png);
  png_set_gray_to_rgb(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  image.width = int(png_get_image_width(png, info));
  image.height = int(png_get_image_height(png, info));
  const size_t stride = png_get_rowbytes(png, info);
  if (stride != 3 * size_t(image.width)) png_error(png, "unexpected layout");
  image.rgb.resize(stride * size_t(image.height));
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < image.height; ++y) png_read_row(png, image.rgb.data() + stride * size_t(y), nullptr);
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

}  // namespace

std::string encode_png(const Image& image) {
  std::string out;
  if (image.empty() || !encode_rows(image, out)) return {};
  return out;
}

void write_png(const std::string& file, const Image& image) {
  if (image.empty()) throw InputError(file, 0, "an empty picture cannot be written; expected at least one pixel");
  const std::string bytes = encode_png(image);
  if (bytes.empty()) throw InputError(file, 0, "a picture cannot be encoded");
  write_whole_file(file, bytes);
}

Image read_png(const std::string& file) { return decode_png(read_whole_file(file, kMostPng, "a PNG picture"), file); }

Image read_picture(const std::string& file) {
  return decode_picture(read_whole_file(file, kMostPng, "a picture"), file);
}

Image decode_picture(std::string_view bytes, const std::string& name) {
  if (is_jpeg(bytes)) return decode_jpeg(bytes, name);
  if (!is_png(bytes)) throw InputError(name, 0, "is neither a PNG nor a JPEG picture; expected one of them");
  return decode_png(bytes, name);
}

Image decode_png(std::string_view bytes, const std::string& name) {
  if (!is_png(bytes)) throw InputError(name, 0, "is not a PNG picture; expected one");
  Image image;
  bool too_large = false;
  if (!read_rows(bytes, image, too_large))
    throw InputError(name, 0,
                     too_large
                         ? fmt::format("says that it is a larger picture than is read; expected at most {} pixels "
                                       "and {} a side",
                                       kMostPixels, kMostPngSide)
                         : "is a damaged PNG picture; expected a whole one");
  return image;
}

Image shrink(const Image& image, int factor) {
  if (factor <= 1) return image;
  Image out(image.width / factor, image.height / factor);
  const int n = factor * factor;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      int sum[3]{};
      for (int dy = 0; dy < factor; ++dy) {
        const uint8_t* p = &image.rgb[3 * (size_t(y * factor + dy) * size_t(image.width) + size_t(x * factor))];
        for (int dx = 0; dx < factor; ++dx, p += 3) sum[0] += p[0], sum[1] += p[1], sum[2] += p[2];
      }
      out.set(x, y, {uint8_t((sum[0] + n / 2) / n), uint8_t((sum[1] + n / 2) / n), uint8_t((sum[2] + n / 2) / n)});
    }
  return out;
}

}  // namespace limberg
