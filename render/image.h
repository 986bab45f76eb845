#pragma once
// A picture in memory, PNG files, and JPEG of photographs. Rows run from the top down, three bytes a pixel, sRGB.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace limberg {

struct Rgb8 {
  uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Rgb8&) const = default;
};

struct Image {
  int width = 0, height = 0;
  std::vector<uint8_t> rgb;  // 3 * width * height

  Image() = default;
  Image(int w, int h, Rgb8 fill = {});
  bool empty() const { return rgb.empty(); }
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  Rgb8 at(int x, int y) const {
    const uint8_t* p = &rgb[3 * (size_t(y) * size_t(width) + size_t(x))];
    return {p[0], p[1], p[2]};
  }
  void set(int x, int y, Rgb8 c) {
    uint8_t* p = &rgb[3 * (size_t(y) * size_t(width) + size_t(x))];
    p[0] = c.r, p[1] = c.g, p[2] = c.b;
  }
  /// Mixes c over the pixel; alpha in [0, 1]. Outside the picture nothing happens.
  void blend(int x, int y, Rgb8 c, double alpha);
  bool operator==(const Image&) const = default;
};

/// Writes beside the file and renames, so that an existing file is never lost half way. InputError when it cannot.
void write_png(const std::string& file, const Image& image);

/// The bytes of a PNG file; empty for an empty picture.
std::string encode_png(const Image& image);

constexpr size_t kMostPng = size_t(32) << 20;     // bytes of a file that is read
constexpr size_t kMostPixels = size_t(64) << 20;  // of a picture that is read: 192 MB
constexpr size_t kMostPngSide = 16384;
/// InputError when the file is missing, is not a PNG, is damaged or too large. Any PNG is converted to 8-bit RGB.
Image read_png(const std::string& file);
Image decode_png(std::string_view bytes, const std::string& name);

/// The same of JPEG: baseline or progressive, in colours or in grey; a picture of four inks is refused. What its camera
/// says of how it was held (Exif) is not looked at: a texture's places are those of the file.
Image decode_jpeg(std::string_view bytes, const std::string& name);
/// The bytes of a JPEG with all its colours (4:4:4), for what is looked at and not measured; `quality` from 1 to 100 as
/// libjpeg has it. Empty for an empty picture, or one of more than 65,500 pixels a side, which JPEG has not.
std::string encode_jpeg(const Image& image, int quality);
inline bool is_png(std::string_view bytes) { return bytes.starts_with("\x89PNG\r\n\x1a\n"); }
inline bool is_jpeg(std::string_view bytes) { return bytes.starts_with("\xff\xd8\xff"); }
/// PNG or JPEG, by its first bytes.
Image decode_picture(std::string_view bytes, const std::string& name);
Image read_picture(const std::string& file);

/// Averages blocks of factor x factor pixels; width and height must be multiples of factor.
Image shrink(const Image& image, int factor);

}  // namespace limberg
