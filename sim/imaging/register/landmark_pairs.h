#pragma once
// Pairs of places for a superposition, as text: a name and six numbers a line, x y z of it in A, then in B, in mm;
// # begins a comment.
#include <string>
#include <vector>

#include "sim/geometry/vec.h"

namespace limberg {

struct LandmarkPairs {
  std::vector<Vec3> a_mm, b_mm;
};

/// `name` stands for the file in errors. InputError: a line without six numbers, or with one that no surface has
/// (SurfaceFileLimits::extent_mm).
LandmarkPairs parse_landmark_pairs(const std::string& text, const std::string& name);

}  // namespace limberg
