#pragma once
// The plan on paper, before the first cut: wound, cuts, which edge is sewn to which, and where the angles say that the
// skin will stand up or be drawn tight.
#include <string>

#include "sim/commands/procedures/figure.h"

namespace limberg {

/// An SVG picture, y up, about 640 pixels wide. Excised skin is filled; each seam
/// has a colour and a letter on both its banks; places of positive charge (dog-ears
/// to be expected) are circles, of negative charge squares, with q in degrees.
std::string plan_svg(const Figure& figure, const std::string& title);

}  // namespace limberg
