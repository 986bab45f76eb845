#pragma once
// The synthetic head's operations whose outcome the modes of the
// tissue are compared on: what is cut, what moves, what is tied.
#include <string>
#include <vector>

#include "sim/imaging/synthetic/synthetic_head.h"
#include "sim/skull/face/face_model.h"

namespace limberg::bench {

/// An operation: bones before and after, and regions of the face that hang on them.
struct HeadCase {
  std::string name;
  bool fitted = false;  // the constants of the spring and shape modes were chosen on this one
  simplex::Mesh bones, moved;
  struct Tie {
    std::string name;
    std::vector<int32_t> face_region;
    int layers = 2;
    double young_kPa = 10;
  };
  std::vector<Tie> ties;
  std::vector<int32_t> measured;  // vertices of the face over which errors are taken
};

/// The vertex of a mesh nearest to a place.
int32_t nearest_vertex(const simplex::Mesh& mesh, const Vec3& at_mm);
Vec3 landmark_of(const HeadModel& head, const std::string& name);
/// An ellipse about (0, z) as wide and high as said, drawn on the outer surface of the bone as seen from in front.
std::vector<Vec3> drawn_in_front(const simplex::Mesh& bone, double z_mm, double half_wide_mm, double half_high_mm);

/// Mandible 8 mm forwards (fitted); forehead 8 mm forwards; mandible turned by 6 degrees about its left condyle;
/// forehead tilted by 10 degrees and 4 mm forwards; chin cut off and carried 6 mm forwards and 2 down. What cannot be
/// cut is left out and said in `notes`.
std::vector<HeadCase> head_cases(const HeadModel& head, std::vector<std::string>& notes, Workers& workers);

}  // namespace limberg::bench
