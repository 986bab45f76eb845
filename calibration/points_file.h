#pragma once
// Places that a tip is to touch, as text: x y z in mm of the world, one place a line, with blanks, commas or semicolons
// between the numbers; # begins a comment.
#include <string>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

/// `name` stands for the file in errors. InputError: a line that is no place, or one farther than 100 m.
std::vector<Vec3> parse_points(const std::string& text, const std::string& name);

}  // namespace limberg
