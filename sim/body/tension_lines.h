#pragma once
// Relaxed skin tension lines that run differently in different places: across a forehead, round an eye, down beside a
// mouth. Skin is stretched more along them at rest, and its fibres run along them.
//
// They are given at places, in a list or a file of one place a line: x y z dx dy dz. A way and its opposite are the
// same: between places the way is the axis along which the mean of d dT of the nearest eight (between_places.h) is
// largest, of vectors laid into the skin's plane.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/body/body.h"

namespace limberg {

struct TensionPlace {
  Vec3 at_mm = Vec3::Zero(), along = Vec3::UnitX();
};

struct TensionSpec {
  std::vector<TensionPlace> places;
  std::string file;
  bool given() const { return !places.empty() || !file.empty(); }
};

struct TensionLimits {
  static constexpr size_t file_bytes = size_t(16) << 20, places = 100'000;
};

/// Throws InputError with file and line. `file` is the name in messages.
std::vector<TensionPlace> parse_tension_lines(std::string_view text, const std::string& file);

/// Body::tension. Where no way can be told (the mean of ways that cross, or one that stands upright on the skin) it is
/// that of tension_direction. Throws InputError: what cannot be read.
std::vector<Vec3f> tension_lines_of(const TensionSpec& spec, const Body& body);

/// How the lines run at a place of a triangle of the surface; not laid into its plane.
Vec3 tension_along(const Body& body, int32_t triangle, const std::array<double, 3>& bary);
/// The same of a point on that triangle or beside it.
Vec3 tension_along(const Body& body, int32_t triangle, const Vec3& X_mm);

}  // namespace limberg
