#pragma once
// What a page says, as text: numbers as people read them; pictures as addresses that hold them.
#include <optional>
#include <string>
#include <string_view>

namespace limberg::html {

/// `digits` significant digits without needless zeros; powers of ten outside 1e-3 .. 1e6, written 3.2 × 10⁻⁵.
std::string number(double value, int digits = 3);

/// The number with a thin space and its unit, of degrees without; a dash when there is none.
std::string quantity(const std::optional<double>& value, std::string_view unit, int digits = 3);

std::string base64(std::string_view bytes);

/// An SVG drawing as a data: URL: as a picture it can run nothing.
std::string svg_data_url(std::string_view svg);

/// The file as a data: URL, or empty when it is absent, larger than 32 MB or no PNG. A picture wider than `widest` is
/// made smaller by a whole factor, so that the page stays light.
std::string png_data_url(const std::string& file, int widest);

}  // namespace limberg::html
