#include "render/text.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <cmath>

namespace limberg {

namespace {

constexpr const char* kFolders[] = {"/usr/share/fonts/truetype/dejavu/", "/usr/share/fonts/TTF/",
                                    "/usr/share/fonts/dejavu/"};

// The next character of UTF-8 text; U+FFFD for anything broken.
uint32_t next_character(const std::string& s, size_t& i) {
  const auto byte = [&](size_t k) { return k < s.size() ? uint32_t(static_cast<unsigned char>(s[k])) : 0u; };
  const uint32_t b = byte(i++);
  if (b < 0x80) return b;
  const int more = b >= 0xf0 && b < 0xf5 ? 3 : b >= 0xe0 && b < 0xf0 ? 2 : b >= 0xc2 && b < 0xe0 ? 1 : 0;
  if (more == 0) return 0xfffd;
  uint32_t c = b & (0x3fu >> more);
  for (int k = 0; k < more; ++k) {
    const uint32_t d = byte(i);
    if ((d & 0xc0) != 0x80) return 0xfffd;
    c = c << 6 | (d & 0x3f);
    ++i;
  }
  return c;
}

}  // namespace

struct TextPainter::Impl {
  FT_Library library = nullptr;
  FT_Face plain = nullptr, bold = nullptr;

  Impl() {
    if (FT_Init_FreeType(&library)) {
      library = nullptr;
      return;
    }
    for (const char* folder : kFolders) {
      if (!plain && FT_New_Face(library, (std::string(folder) + "DejaVuSans.ttf").c_str(), 0, &plain)) plain = nullptr;
      if (!bold && FT_New_Face(library, (std::string(folder) + "DejaVuSans-Bold.ttf").c_str(), 0, &bold))
        bold = nullptr;
    }
    if (!bold) bold = plain;
  }
  ~Impl() {
    if (library) FT_Done_FreeType(library);  // frees the faces too
  }

  // Calls put(x, y, coverage) for every touched pixel; returns the advance.
  template <class Put>
  double walk(const std::string& text, const Style& style, bool draw, Put&& put) const {
    FT_Face face = style.bold ? bold : plain;
    if (!face || FT_Set_Char_Size(face, 0, FT_F26Dot6(std::lround(style.px * 64)), 72, 72)) return 0;
    double x = 0;
    FT_UInt before = 0;
    for (size_t i = 0; i < text.size();) {
      const uint32_t c = next_character(text, i);
      const FT_UInt glyph = FT_Get_Char_Index(face, c < 0x20 ? ' ' : c);
      FT_Vector kern{0, 0};
      if (before && glyph) FT_Get_Kerning(face, before, glyph, FT_KERNING_UNFITTED, &kern);
      x += double(kern.x) / 64;
      before = glyph;
      if (FT_Load_Glyph(face, glyph, FT_LOAD_NO_HINTING)) continue;
      if (draw && !FT_Render_Glyph(face->glyph, FT_RENDER_MODE_NORMAL)) {
        const FT_Bitmap& bm = face->glyph->bitmap;
        const int ox = int(std::lround(x)) + face->glyph->bitmap_left, oy = -face->glyph->bitmap_top;
        for (int v = 0; v < int(bm.rows); ++v)
          for (int u = 0; u < int(bm.width); ++u)
            if (const uint8_t a = bm.buffer[v * bm.pitch + u]) put(ox + u, oy + v, a / 255.0);
      }
      x += double(face->glyph->linearHoriAdvance) / 65536;
    }
    return x;
  }
};

TextPainter::TextPainter() : impl_(std::make_unique<Impl>()) {}
TextPainter::~TextPainter() = default;
bool TextPainter::ready() const { return impl_->plain != nullptr; }

double TextPainter::width(const std::string& text, const Style& style) const {
  return impl_->walk(text, style, false, [](int, int, double) {});
}

void TextPainter::draw(Image& image, double x, double y, const std::string& text, const Style& style) const {
  const int x0 = int(std::lround(x)), y0 = int(std::lround(y));
  if (style.shadow > 0) {
    const int r = std::max(1, int(std::lround(style.px / 9)));
    const double each = style.shadow / (1.5 * r * r);
    impl_->walk(text, style, true, [&](int u, int v, double a) {
      for (int dy = -r; dy <= r; ++dy)
        for (int dx = -r; dx <= r; ++dx)
          if (dx * dx + dy * dy <= r * r) image.blend(x0 + u + dx, y0 + v + dy, {0, 0, 0}, a * each);
    });
  }
  impl_->walk(text, style, true, [&](int u, int v, double a) { image.blend(x0 + u, y0 + v, style.colour, a); });
}

std::vector<std::string> TextPainter::wrap(const std::string& text, double limit, const Style& style) const {
  std::vector<std::string> lines;
  std::string line;
  for (size_t i = 0; i <= text.size();) {
    const size_t end = std::min(text.find(' ', i), text.size());
    const std::string word = text.substr(i, end - i), longer = line.empty() ? word : line + " " + word;
    if (!line.empty() && width(longer, style) > limit) {
      lines.push_back(line);
      line = word;
    } else {
      line = longer;
    }
    i = end + 1;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

}  // namespace limberg
