#pragma once
// The constants of contact (contact_finder.h says what each is for).

namespace limberg::contact_constants {

// The spring of a pair.
inline constexpr double stiffness = 8;    // times that of a column of tissue of one cell's height
inline constexpr double slack_mm = 0.01;  // overlap that does not push: cuts that coincide, at rest or after rounding
inline constexpr double soft_mm = 0.04;   // overlap beyond it over which the stiffness sets in
inline constexpr double most_mm = 0.4;    // deeper overlaps push no harder than this one

// Broad phase: relative motion of cell copies after which candidates are collected anew, and places queried anew.
inline constexpr double margin_mm = 1, query_mm = 0.4;
// What slows down is queried before that, once its moves since the last query are so many times the latest one: pairs
// that were missed would else be found long after the tissue has come to rest without them (2026-11-27: by then wounds
// of the shipped rhomboid were .03 to .16 mm from where they came to rest with them, in a fifth of the frames).
inline constexpr double query_slowing = 4, query_least_mm = 0.01;
// Narrow phase: sheets so near to a place are its pairs.
inline constexpr double guard_mm = 0.5;

// Persistence: a pair is projected anew beyond these.
inline constexpr double slide_mm = 0.15, turn_deg = 5, weight_step = 0.25;
// Damping: beyond this a place has left the neighbourhood in which its projections are counted.
inline constexpr double neighbourhood_mm = 1;

// Where a pair's weight falls from 1 to 0.
inline constexpr double facing_full = 0.5, facing_none = 0.2;  // minus the cosine between the two normals
inline constexpr double deep_full_mm = 0.6, deep_none_mm = 2;  // depth; flaps thinner than that are none
inline constexpr double other_full = 1.25, other_none = 2;     // the way out through this sheet over the shortest one

}  // namespace limberg::contact_constants
