#pragma once
// Text out of a file, as it may stand in a page or a drawing: between tags, or in a quoted attribute.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace limberg {

/// Length of the UTF-8 sequence at s[i], 0 when it is broken or a code point that XML forbids.
inline size_t xml_sequence(std::string_view s, size_t i) {
  const auto byte = [&](size_t k) { return k < s.size() ? uint32_t(static_cast<unsigned char>(s[k])) : 0u; };
  const uint32_t b = byte(i);
  if (b < 0x80) return b >= 0x20 || b == '\n' || b == '\t' ? 1 : 0;
  const size_t n = b >= 0xf0 && b < 0xf5 ? 4 : b >= 0xe0 && b < 0xf0 ? 3 : b >= 0xc2 && b < 0xe0 ? 2 : 0;
  if (n == 0) return 0;
  uint32_t c = b & (0xffu >> (n + 1));
  for (size_t k = 1; k < n; ++k) {
    if ((byte(i + k) & 0xc0) != 0x80) return 0;
    c = c << 6 | (byte(i + k) & 0x3f);
  }
  const uint32_t least[5]{0, 0, 0x80, 0x800, 0x10000};
  const bool forbidden = c < least[n] || (c >= 0xd800 && c < 0xe000) || c == 0xfffe || c == 0xffff || c > 0x10ffff ||
                         (c >= 0x80 && c < 0xa0);
  return forbidden ? 0 : n;
}

/// & < > " ' are escaped, control characters and broken UTF-8 become U+FFFD.
inline std::string xml_text(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (size_t i = 0; i < text.size();) {
    const size_t n = xml_sequence(text, i);
    if (n == 0) {
      out += "\ufffd";
      ++i;
      continue;
    }
    switch (text[i]) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += text.substr(i, n);
    }
    i += n;
  }
  return out;
}

}  // namespace limberg
