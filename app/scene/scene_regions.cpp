#include "app/scene/scene_regions.h"

#include "app/scene/scene_layers.h"
#include "sim/geometry/polyline.h"

namespace limberg {
namespace {

constexpr size_t kMostRegions = 64, kMostPoints = 1000;
constexpr const char* kPlaces = "expected one of volume, path_mm, outline, paint";

std::string list_of(size_t least, const char* what) {
  return "; expected a list of " + std::to_string(least) + " to " + std::to_string(kMostPoints) + what;
}

void read_place(Table& t, const Scene& s, RegionSpec& r) {
  int given = 0;
  for (const char* key : {"volume", "path_mm", "outline", "paint"}) given += t.has(key);
  if (given != 1)
    t.fail("name",
           std::string(given ? "is said to be in several places at once; " : "is said to be nowhere; ") + kPlaces);
  if (t.has("volume")) {
    t.path("volume", r.volume);
    t.real("scale_to_mm", r.scale_to_mm, 0, 1e6, true);
  }
  for (const auto& p : t.rows<3>("path_mm", 1, kMostPoints, "point", list_of(1, " points [x, y, z] in mm")))
    r.path_mm.emplace_back(p[0], p[1], p[2]);
  if (!r.path_mm.empty()) {
    if (!t.has("radius_mm")) t.fail("radius_mm", "is missing; expected the radius of the bundle about path_mm");
    t.real("radius_mm", r.radius_mm, 0, 500, true);
  }
  for (const auto& p : t.rows<2>("outline", 3, kMostPoints, "point", list_of(3, " places [x, y] in mm")))
    r.outline_mm.emplace_back(p[0], p[1]);
  if (t.has("outline") && !(std::abs(signed_area(r.outline_mm)) > 1e-6))
    t.fail("outline", "holds no area; expected a polygon, in mm on the chart");
  if (t.has("paint")) {
    if (s.source != Scene::Source::obj)
      t.fail("paint", "names a material of an OBJ, and the body is a block; expected outline");
    t.text("paint", r.paint, 200);
  }
  if (t.has("outline") || t.has("paint")) {
    std::vector<double> depth;
    t.numbers("depth_mm", depth, 0, 1000, false, 2);
    if (depth.size() == 1 || (depth.size() == 2 && !(depth[0] < depth[1])))
      t.fail("depth_mm", "is no range; expected [from, to], mm below the skin");
    if (depth.size() == 2) r.from_mm = depth[0], r.to_mm = depth[1];
  }
  if (t.has("direction")) t.direction("direction", r.direction.emplace(Vec3::UnitX()));
}

/// A muscle that the scene does not say to be active is at rest, and can be activated.
void rest_at_first(Material& m, const LawCatalogue& laws) {
  const LawCatalogue::Entry* law = laws.find(m.law.name);
  const auto is_activation = [](const auto& c) { return c.key == kActivation; };
  if (!law || std::none_of(law->constants.begin(), law->constants.end(), is_activation)) return;
  if (std::none_of(m.law.constants.begin(), m.law.constants.end(), is_activation))
    m.law.constants.push_back({kActivation, {0}});
}

}  // namespace

void read_regions(const toml::table& root, const std::string& file, Scene& s,
                  const std::function<const TissueLibrary&(Table&)>& library) {
  for (const toml::node* e : list_of_tables(root, "region", file, kMostRegions, "name")) {
    Table t(e->as_table(), "region", file);
    RegionSpec r;
    r.material = unknown_material();
    if (const NamedTissue* tissue = named_tissue(t, library))
      r.material = tissue->material, r.material.tissue = tissue->name;
    if (!t.has("name")) t.fail("name", "is missing; expected what the region is called");
    t.text("name", r.name, 40);
    for (const RegionSpec& other : s.regions)
      if (other.name == r.name) t.fail("name", "is that of another region; expected one of its own");
    read_place(t, s, r);
    t.colour("colour", r.colour);
    read_material(t, r.material, *s.laws);
    rest_at_first(r.material, *s.laws);
    t.finish();
    s.region_line.push_back(int(e->source().begin.line));
    s.regions.push_back(std::move(r));
  }
}

void add_regions(const Scene& scene, Body& body) {
  for (size_t i = 0; i < scene.regions.size(); ++i) try {
      body.regions.push_back(std::make_shared<Region>(scene.regions[i], body));
    } catch (const InputError& e) {
      if (!e.file().empty()) throw;
      throw InputError(scene.path, scene.region_line[i], e.what());
    }
}

}  // namespace limberg
