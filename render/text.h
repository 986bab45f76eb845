#pragma once
// Text on an image (FreeType, DejaVu Sans). Drawn by the processor, so it looks the same with every graphics driver.
#include <memory>
#include <string>
#include <vector>

#include "render/image.h"

namespace limberg {

class TextPainter {
 public:
  /// Without the font (Debian: fonts-dejavu-core) ready() is false and nothing is drawn.
  TextPainter();
  ~TextPainter();
  bool ready() const;

  struct Style {
    double px = 16;  // height of the em
    Rgb8 colour{255, 255, 255};
    bool bold = false;
    double shadow = 0;  // strength of a dark halo, 0..1, for text on a picture
  };
  /// UTF-8; broken bytes are shown as a replacement character. Returns the width in pixels.
  double width(const std::string& text, const Style& style) const;
  /// x: left end, y: base line.
  void draw(Image& image, double x, double y, const std::string& text, const Style& style) const;
  /// Parts the text into lines no wider than `limit` px, at spaces.
  std::vector<std::string> wrap(const std::string& text, double limit, const Style& style) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg
