#pragma once
// What the tissue lies against and what does not move: teeth, gums, a globe, bone. Nothing holds to it, and nothing
// goes into it (contact/collider_contacts.h).
#include <memory>
#include <string>
#include <string_view>

#include "sim/geometry/tri_mesh.h"

namespace limberg {

struct Collider {
  std::string name;
  TriMesh mesh;                       // closed, in the body's frame, mm; neither uv nor tags
  Vec3f colour{0.88f, 0.85f, 0.80f};  // sRGB, 0 to 1
  std::vector<Vec3f> rgb;             // the same of each vertex, where the file has colours; else empty

  const Vec3f& colour_of(size_t vertex) const { return rgb.empty() ? colour : rgb[vertex]; }
};

struct ColliderSpec {
  std::string path;  // of an OBJ file
  double scale_to_mm = 1;
  Vec3f colour = Collider().colour;
  std::string what = "collider";  // in messages
  bool closed = true;             // false: it may be open and look either way
};

/// Throws InputError, with file and line, where the surface is open at an edge, holds no volume or is longer than 1 m.
/// One that is inside out as a whole is turned. It may have several parts, which may run through each other; polygons
/// are taken as fans.
std::shared_ptr<const Collider> load_collider(const ColliderSpec& spec);
/// The same from text; spec.path is only the name in messages.
std::shared_ptr<const Collider> parse_collider(std::string_view text, const ColliderSpec& spec);

}  // namespace limberg
