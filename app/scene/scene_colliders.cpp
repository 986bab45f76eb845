#include "app/scene/scene_colliders.h"

namespace limberg {
namespace {

constexpr size_t kMostColliders = 16;

}  // namespace

void read_colliders(const toml::table& root, const std::string& file, Scene& s) {
  for (const toml::node* e : list_of_tables(root, "collider", file, kMostColliders, "mesh")) {
    Table one(e->as_table(), "collider", file);
    if (!one.has("mesh")) one.fail("mesh", "is missing; expected the path of an OBJ, PLY or STL file");
    ColliderSpec c;
    one.path("mesh", c.path);
    one.real("scale_to_mm", c.scale_to_mm, 0, 1e6, true);
    std::optional<Vec3f> colour;
    one.colour("colour", colour);
    if (colour) c.colour = *colour;
    one.finish();
    s.colliders.push_back(std::move(c));
  }
}

}  // namespace limberg
