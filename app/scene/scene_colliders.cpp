#include "app/scene/scene_colliders.h"

#include <filesystem>

namespace limberg {
namespace {

constexpr size_t kMostColliders = 16;

}  // namespace

void read_colliders(const toml::table& root, const std::string& file, Scene& s) {
  namespace fs = std::filesystem;
  for (const toml::node* e : list_of_tables(root, "collider", file, kMostColliders, "mesh")) {
    Table one(e->as_table(), "collider", file);
    if (!one.has("mesh")) one.fail("mesh", "is missing; expected the path of an OBJ file");
    ColliderSpec c;
    one.text("mesh", c.path, 4000);
    if (!fs::path(c.path).is_absolute()) c.path = (fs::path(file).parent_path() / c.path).lexically_normal().string();
    one.real("scale_to_mm", c.scale_to_mm, 0, 1e6, true);
    std::optional<Vec3f> colour;
    one.colour("colour", colour);
    if (colour) c.colour = *colour;
    one.finish();
    s.colliders.push_back(std::move(c));
  }
}

}  // namespace limberg
