#include "app/report/html.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

#include "render/image.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg::html {

namespace {

std::string trimmed(double v, int decimals) {
  const std::string s = fmt::format("{:.{}f}", v, decimals);
  std::string t = s;
  if (t.find('.') != std::string::npos) {
    while (t.back() == '0') t.pop_back();
    if (t.back() == '.') t.pop_back();
  }
  if (t == "-0") t = "0";
  if (t[0] == '-') t.replace(0, 1, "\u2212");
  return t;
}

std::string superscript(int n) {
  static const char* const digit[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string s = n < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(n))) s += digit[c - '0'];
  return s;
}

}  // namespace

std::string number(double value, int digits) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  if (value == 0) return "0";
  int power = int(std::floor(std::log10(std::abs(value)) + 1e-12));
  // Rounding may carry into the next power: 0.9996 with three digits is 1.
  const double scale = std::pow(10.0, digits - 1 - power);
  const double rounded = std::isfinite(scale) && scale > 0 ? std::round(value * scale) / scale : value;
  if (std::abs(rounded) >= std::pow(10.0, power + 1)) ++power;
  if (power < -3 || power > 6) {
    const double mantissa = rounded / std::pow(10.0, power);
    const std::string m = trimmed(mantissa, std::max(0, digits - 1));
    return (m == "1" ? "" : m + "\u202f×\u202f") + "10" + superscript(power);
  }
  return trimmed(rounded, std::max(0, digits - 1 - power));
}

std::string quantity(const std::optional<double>& value, std::string_view unit, int digits) {
  if (!value || !std::isfinite(*value)) return "–";
  if (unit == "degrees" || unit == "deg") unit = "°";
  if (unit == "mm2") unit = "mm²";
  return number(*value, digits) + (unit.empty() || unit == "°" ? "" : "\u202f") + std::string(unit);
}

std::string base64(std::string_view bytes) {
  static const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t v = 0;
    for (size_t k = 0; k < 3; ++k)
      v = v << 8 | (i + k < bytes.size() ? uint32_t(static_cast<unsigned char>(bytes[i + k])) : 0u);
    for (size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? letters[v >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string svg_data_url(std::string_view svg) { return "data:image/svg+xml;base64," + base64(svg); }

std::string picture_data_url(const std::string& file, int widest) {
  try {
    std::string bytes = read_whole_file(file, kMostPng, "a PNG picture");
    Image image = decode_png(bytes, file);
    if (const int factor = (image.width + widest - 1) / widest; factor > 1) {
      image = shrink(image, factor);
      bytes = encode_png(image);
    }
    if (bytes.empty()) return {};
    const std::string jpeg = encode_jpeg(image, kPagePictureQuality);
    if (!jpeg.empty() && jpeg.size() < bytes.size()) return "data:image/jpeg;base64," + base64(jpeg);
    return "data:image/png;base64," + base64(bytes);
  } catch (const InputError&) {
    return {};  // none, or damaged
  }
}

}  // namespace limberg::html
