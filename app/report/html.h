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

/// Of JPEG pictures in pages: a choice. Those of patients keep 42 dB and a sixth to a third of their bytes
/// (measured 2026-11-29).
constexpr int kPagePictureQuality = 92;

/// The PNG file as a data: URL, or empty when it is absent, larger than 32 MB or no PNG. So that the page stays light a
/// picture wider than `widest` is made smaller by a whole factor, and what has fewer bytes as a JPEG is one (fine:
/// kPagePictureQuality); the file stays what is measured.
std::string picture_data_url(const std::string& file, int widest);

}  // namespace limberg::html
