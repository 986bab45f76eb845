#include "app/words/typeset.h"

#include <algorithm>

namespace limberg {
namespace {

constexpr std::string_view kThin = "\u202f";
constexpr std::string_view kUnits[] = {"mm²", "mm³", "cm³", "mm",  "cm", "m", "mN", "N/mm", "N",  "kPa", "ms",
                                       "s",   "min", "h",   "kHz", "Hz", "g", "mJ", "MB",   "px", "%",   "°"};

bool digit(char c) { return c >= '0' && c <= '9'; }
bool letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || static_cast<unsigned char>(c) >= 0x80;
}

/// The length of the unit that stands there as a word; 0: none.
size_t unit_at(std::string_view text, size_t at) {
  for (const std::string_view unit : kUnits) {
    if (text.substr(at, unit.size()) != unit) continue;
    const size_t end = at + unit.size();
    const bool word_goes_on = end < text.size() && (letter(text[end]) || digit(text[end]));
    // An entity or a closing sign of the page ends a word too; so does a thin space, whose first byte looks like a
    // letter's.
    if (!word_goes_on || text.substr(end, kThin.size()) == kThin || text.substr(end, 3) == "–") return unit.size();
  }
  return 0;
}

}  // namespace

std::string thin_spaces(std::string_view text) {
  std::string out;
  out.reserve(text.size() + 8);
  for (size_t i = 0; i < text.size(); ++i) {
    const bool thin = text.substr(i, kThin.size()) == kThin;
    if ((text[i] != ' ' && !thin) || out.empty() || !digit(out.back())) {
      out += text[i];
      continue;
    }
    const size_t next = i + (thin ? kThin.size() : 1);
    if (unit_at(text, next) == 0) {
      out += text[i];
      continue;
    }
    if (text.substr(next, 2) != "°") out += kThin;
    i = next - 1;
  }
  return out;
}

std::string with_decimals(std::string_view text, char mark) {
  std::string out(text);
  if (mark == '.') return out;
  for (size_t i = 0; i < text.size();) {
    if (!digit(text[i])) {
      ++i;
      continue;
    }
    const size_t begin = i;
    size_t points = 0, point = 0;
    while (i < text.size() && (digit(text[i]) || (text[i] == '.' && i + 1 < text.size() && digit(text[i + 1]))))
      points += text[i] == '.', point = text[i] == '.' ? i : point, ++i;
    const bool in_word =
        begin > 0 && ((letter(text[begin - 1]) && static_cast<unsigned char>(text[begin - 1]) < 0x80) ||
                      text[begin - 1] == '.' || text[begin - 1] == '/');
    const bool goes_on = i < text.size() && (text[i] == '/' || text[i] == '_');
    if (points == 1 && !in_word && !goes_on) out[point] = mark;
  }
  return out;
}

std::string typeset_page(std::string_view html, char mark) {
  static constexpr std::string_view kAsItIs[] = {"script", "style", "code", "pre", "footer", "title"};
  std::string out;
  out.reserve(html.size() + html.size() / 64);
  for (size_t at = 0; at < html.size();) {
    const size_t tag = std::min(html.find('<', at), html.size());
    out += with_decimals(thin_spaces(html.substr(at, tag - at)), mark);
    if (tag == html.size()) break;
    size_t end = html.find('>', tag);
    end = end == html.npos ? html.size() : end + 1;
    for (const std::string_view name : kAsItIs) {
      const size_t after = tag + 1 + name.size();
      if (html.substr(tag + 1, name.size()) != name || after >= html.size() ||
          (html[after] != '>' && html[after] != ' '))
        continue;
      const std::string close = "</" + std::string(name) + ">";
      const size_t last = html.find(close, end);
      end = last == html.npos ? html.size() : last + close.size();
      break;
    }
    out += html.substr(tag, end - tag);
    at = end;
  }
  return out;
}

}  // namespace limberg
