#pragma once
// Acts on skin whose places are given in space, [x, y, z] at rest, instead of on the chart: anywhere on a body, the
// back of a lip and the far side of a head as well (skin_view.h).
#include <span>
#include <variant>
#include <vector>

#include "sim/commands/skin_acts.h"

namespace limberg {

using SkinAct = std::variant<Incise, Undermine, Excise, ExcisePiece, SetHook, Suture, SutureRow, SutureCorner,
                             SutureBetween, CutSuture, SutureBite, Mark>;

/// Of every place of the act, in the order of its fields, x and y stand in the act and z here. Of a place that is given
/// by the texture of the skin u and v stand in the act, and z is NaN (body/texture_places.h says where it lies).
struct InSpace {
  SkinAct act;
  std::vector<double> z_mm;
};

/// Its places, in the order of its fields.
std::vector<Vec3> places_of(const InSpace& c);
bool has_texture_places(const InSpace& c);
/// The same act at other places, as many as it has.
SkinAct with_points(const InSpace& c, std::span<const ChartPoint> points);
/// The same act on the plane that fits its places best: lengths and areas for words. Not for cutting.
SkinAct flattened(const InSpace& c);

}  // namespace limberg
