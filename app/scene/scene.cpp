#include "app/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>

#include "app/scene/scene_colliders.h"
#include "app/scene/scene_head_read.h"
#include "app/scene/scene_lattice.h"
#include "app/scene/scene_layers.h"
#include "app/scene/scene_loads.h"
#include "app/scene/scene_regions.h"
#include "app/scene/surface_picture.h"
#include "app/scene/toml_table.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/base/whole_file.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;
constexpr size_t kMaxBytes = 1 << 20;

/// [[body.tag]]: what the faces of each material are.
void read_tags(Table& t, Scene& s) {
  const toml::node* n = t.node("tag");
  if (!n) return;
  const toml::array* all = n->as_array();
  if (!all || all->empty() || all->size() > 1000)
    t.fail("tag", "is no list of 1 to 1000 tables; expected [[body.tag]] with material and what");
  for (const char* key : {"deep_direction", "deep_angle_deg", "deep_center_mm", "deep_plane_mm"})
    if (t.has(key)) t.fail(key, "says what is held, and so do the tags of the materials; expected one of them");
  for (const toml::node& e : *all) {
    if (!e.is_table()) t.fail("tag", "holds something else than tables; expected [[body.tag]] with material and what");
    Table one(e.as_table(), "body.tag", s.path);
    ObjTag tag;
    std::string what;
    for (const char* key : {"material", "what"})
      if (!one.has(key)) one.fail(key, "is missing; expected the name of a material, and what its faces are");
    one.text("material", tag.material, 200), one.text("what", what);
    const auto* known = std::find(std::begin(kObjTagNames), std::end(kObjTagNames), what);
    if (known == std::end(kObjTagNames))
      one.fail("what", "is of no known kind; expected \"skin\", \"mucosa\", \"held\", \"held_softly\" or \"cut\"");
    tag.what = ObjTag::What(known - std::begin(kObjTagNames));
    if (tag.what == ObjTag::What::held_softly) one.real("stiffness_kPa_mm", tag.stiffness_kPa_mm, 0, 1e4, true);
    for (const ObjTag& other : s.obj.tags)
      if (other.material == tag.material) one.fail("material", "is tagged twice; expected each material once");
    one.finish();
    s.obj.tags.push_back(std::move(tag));
  }
}

void read_tension(Table& t, Scene& s) {
  constexpr size_t kMostPlaces = 1000;
  t.path("tension_file", s.tension.file);
  const std::string expected = "; expected a list of 1 to " + std::to_string(kMostPlaces) +
                               " rows [x, y, z, dx, dy, dz], a place in mm and the way of the lines there";
  for (const auto& [x, y, z, dx, dy, dz] : t.rows<6>("tension_points", 1, kMostPlaces, "row", expected)) {
    const Vec3 along(dx, dy, dz);
    if (!(along.norm() > 1e-6)) t.fail("tension_points", "holds lines that run nowhere" + expected);
    s.tension.places.push_back({{x, y, z}, along.normalized()});
  }
  if (!s.tension.places.empty() && !s.tension.file.empty())
    t.fail("tension_file", "is given beside tension_points; expected one of them");
}

void read_body(Table t, Scene& s, const std::string& file) {
  if (!t.present()) throw InputError(file, 0, "[body] is missing; expected source = \"block\" or \"obj\"");
  std::string source;
  if (!t.has("source")) t.fail("source", "is missing; expected \"block\" or \"obj\"");
  t.text("source", source);
  Vec3 tension = Vec3::UnitX();
  t.direction("tension_direction", tension);
  if (source == "block") {
    s.source = Scene::Source::block;
    s.block.name = s.name;
    s.block.tension_direction = tension;
    read_sides(t, s);
    t.vector("size_mm", s.block.size_mm, 1000);
    if (s.block.size_mm.minCoeff() < 1)
      t.fail("size_mm", "has a side of " + number(s.block.size_mm.minCoeff()) + " mm; expected 1 to 1000 mm");
    if (tension.head<2>().norm() < 1e-3 * tension.norm())
      t.fail("tension_direction", "stands upright on the skin; expected a direction in its plane");
    t.real("skin_cell_mm", s.block.skin_cell_mm, 0.1, 100);
    if (s.block.size_mm.x() * s.block.size_mm.y() / (s.block.skin_cell_mm * s.block.skin_cell_mm) > 2e6)
      t.fail("skin_cell_mm", "makes more than 4 million triangles; expected larger skin cells");
  } else if (source == "obj") {
    s.source = Scene::Source::obj;
    s.obj.tension_direction = tension;
    if (!t.has("mesh")) t.fail("mesh", "is missing; expected the path of an OBJ, PLY or STL file");
    t.path("mesh", s.obj.path);
    if (t.has("texture")) t.path("texture", s.texture);
    t.real("scale_to_mm", s.obj.scale_to_mm, 0, 1e6, true);
    read_tags(t, s);
    read_tension(t, s);
    t.direction("deep_direction", s.obj.deep_direction);
    t.real("deep_angle_deg", s.obj.deep_angle_deg, 0, 180);
    if (t.has("deep_center_mm")) t.vector("deep_center_mm", s.obj.deep_center_mm.emplace(Vec3::Zero()), 1e6);
    t.real("deep_plane_mm", s.obj.deep_plane_mm, -1e6, 1e6);
    t.vector("chart_origin_mm", s.obj.chart_origin_mm, 1e6);
    t.direction("chart_e1", s.obj.chart_e1);
    t.direction("chart_e2", s.obj.chart_e2);
    if (s.obj.chart_e1.cross(s.obj.chart_e2).norm() < 1e-3 * s.obj.chart_e1.norm() * s.obj.chart_e2.norm())
      t.fail("chart_e2", "is parallel to chart_e1; expected two directions that span the chart");
  } else {
    t.fail("source", "is of no known kind; expected \"block\" or \"obj\"");
  }
  t.finish();
}

}  // namespace

Vec3 Scene::Camera::eye_mm() const { return target_mm + distance_mm * from.normalized(); }

Scene parse_scene(const std::string& text, const std::string& path, std::shared_ptr<const LawCatalogue> laws) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InputError(path, 0, "the file is empty; expected a scene");
  if (text.size() > kMaxBytes) throw InputError(path, 0, "the scene is larger than 1 MB; expected less");
  const toml::table root = parse_toml(text, path, "a scene");

  Scene s;
  s.path = path;
  s.text = text;
  s.name = fs::path(path).stem().string();
  Table top(&root, "", path);
  top.text("name", s.name, 200);
  top.text("note", s.note, 10'000);
  top.finish({"head", "body", "collider", "layer", "region", "lattice", "loads", "build", "springs", "solver", "tools",
              "landmarks", "camera"});

  s.head = read_head(root, path);
  s.flesh = !s.head || root.contains("body");
  if (!s.flesh)
    for (const char* key : {"collider", "layer", "region", "lattice", "loads", "springs", "build"})
      if (const toml::node* n = root.get(key))
        throw InputError(path, int(n->source().begin.line),
                         std::string(key) + " belongs to a [body], and there is none; expected a [body] or no " + key);
  if (s.flesh) read_body(section(root, "body", path), s, path), read_colliders(root, path, s);
  s.laws = laws ? laws : shipped_laws();
  std::optional<TissueLibrary> library;
  const auto tissues = [&](Table& of) -> const TissueLibrary& {
    if (library) return *library;
    const std::string file = find_tissues(path);
    if (file.empty())
      of.fail("tissue",
              "cannot be looked up: there is no tissues.toml beside the scene or in the folder above; expected one");
    s.tissues = read_whole_file(file, kMaxBytes, "a library of tissues");
    return library.emplace(parse_tissues(s.tissues, file, *s.laws));
  };
  if (s.flesh) {
    SceneLayers read = read_layers(root, path, *s.laws, tissues);
    s.thickness = std::move(read.thickness), s.layer_line = std::move(read.line);
    (s.source == Scene::Source::block ? s.block.layers : s.obj.layers) = std::move(read.layers);
    read_regions(root, path, s, tissues);
  }

  read_lattice(root, path, s);
  read_loads(root, path, s);

  Table build = section(root, "build", path);
  build.boolean("can_cut", s.can_cut);
  build.boolean("dynamic", s.dynamic);
  build.choice("contact", [&](int v) {
    s.contact = v < 0 ? ContactChoice::automatic : v ? ContactChoice::on : ContactChoice::off;
  });
  build.real("contact_friction", s.contact_friction, 0, 1);
  build.finish();

  Table springs = section(root, "springs", path);
  springs.real("suture_N_per_mm", s.suture_N_per_mm, 0, 1e4, true);
  springs.real("suture_bite_mm", s.suture_bite_mm, 0, 10);
  springs.real("hook_N_per_mm", s.hook_N_per_mm, 0, 1e4, true);
  springs.real("hook_tip_mm", s.hook_tip_mm, 0, 10);
  springs.finish();

  Table solver = section(root, "solver", path);
  solver.boolean("focus", s.focus);
  solver.integer("iterations_per_step", 1, 1000, [&](int64_t v) { s.iterations_per_step = int(v); });
  solver.real("steps_per_s", s.steps_per_s, 1, 1000);
  solver.real("damping_per_s", s.damping_per_s, 0, 1e4);
  if (std::string name = "backward_euler"; solver.has("integrator")) {
    solver.text("integrator", name);
    if (name != "backward_euler" && name != "bdf2")
      solver.fail("integrator", "is \"" + name + "\"; expected \"backward_euler\" or \"bdf2\"");
    s.integrator = name == "bdf2" ? Integrator::bdf2 : Integrator::backward_euler;
  } else {
    solver.text("integrator", name);
  }
  solver.integer("seed", 0, std::numeric_limits<int64_t>::max(), [&](int64_t v) { s.seed = uint64_t(v); });
  solver.finish();

  Table tools = section(root, "tools", path);
  tools.real("max_depth_mm", s.tools.max_depth_mm, 0, 200, true);
  tools.real("default_depth_mm", s.tools.default_depth_mm, 0, 200, true);
  tools.real("default_spacing_mm", s.tools.default_spacing_mm, 0.5, 100);
  tools.real("reach_mm", s.tools.reach_mm, 0.1, 50);
  if (bool on = false; tools.has("progressive_cut"))
    tools.boolean("progressive_cut", on), s.tools.progressive_cut = on;
  else
    tools.boolean("progressive_cut", on);
  if (s.tools.default_depth_mm > s.tools.max_depth_mm)
    tools.fail("default_depth_mm", "is larger than max_depth_mm; expected at most " + number(s.tools.max_depth_mm));
  tools.finish();

  if (const toml::node* n = root.get("landmarks")) {
    if (!n->is_table() || n->as_table()->size() > 50)
      throw InputError(path, int(n->source().begin.line),
                       "landmarks is no table of at most 50 places; expected [landmarks] with NAME = [x, y]");
    for (const auto& [name, at] : *n->as_table()) {
      const toml::array* a = at.as_array();
      const auto x = a && a->size() == 2 ? a->get(0)->value<double>() : std::nullopt,
                 y = x ? a->get(1)->value<double>() : std::nullopt;
      if (!y || !(std::abs(*x) <= 1e4) || !(std::abs(*y) <= 1e4))
        throw InputError(path, int(at.source().begin.line),
                         "landmarks." + std::string(name.str()).substr(0, 40) + " is no place; expected [x, y] in mm");
      s.landmarks.push_back({std::string(name.str()), {*x, *y}});
    }
  }

  Table camera = section(root, "camera", path);
  camera.vector("target_mm", s.camera.target_mm, 1e4);
  camera.direction("from", s.camera.from);
  camera.direction("up", s.camera.up);
  if (s.camera.from.cross(s.camera.up).norm() < 1e-3 * s.camera.from.norm() * s.camera.up.norm())
    camera.fail("up", "points along the line of sight; expected a direction across it");
  camera.real("distance_mm", s.camera.distance_mm, 10, 5000);
  camera.real("fov_deg", s.camera.fov_deg, 5, 120);
  camera.finish();

  Hash64 h;
  h.add(text);
  if (!s.tissues.empty()) h.add(s.tissues);
  for (const NamedFile& f : files_of(s)) h.add(read_whole_file(f.path, ObjLimits::file_bytes, f.what));
  s.hash = h.value();
  return s;
}

bool differs_in_words_only(const Scene& scene, const std::string& text, uint64_t hash) {
  return parse_toml(text, scene.path, "a scene") == parse_toml(scene.text, scene.path, "a scene") &&
         parse_scene(text, scene.path).hash == hash;  // its files are those of this one, too
}

namespace {

/// Of the files that a scene may name, those that it does.
auto adder_to(std::vector<NamedFile>& out) {
  return [&out](const std::string& path, const char* what, bool given = true) {
    if (!path.empty()) out.push_back({path, what, given});
  };
}

}  // namespace

std::vector<NamedFile> files_of(const Scene& s) {
  std::vector<NamedFile> out;
  const auto add = adder_to(out);
  if (s.source == Scene::Source::obj) add(s.obj.path, "the surface that the scene names");
  for (const ColliderSpec& c : s.colliders) add(c.path, "a collider that the scene names");
  for (const RegionSpec& r : s.regions) add(r.volume, "a region that the scene names");
  add(s.tension.file, "lines of tension that the scene names");
  for (const ThicknessSpec& t : s.thickness)
    for (const std::string& file : {t.file, t.down_to}) add(file, "thicknesses that the scene names");
  if (s.head) {
    for (const std::string& f : s.head->bone_files) add(f, "a simplex mesh that the scene names");
    add(s.head->face_file, "a simplex mesh that the scene names");
  }
  return out;
}

std::vector<NamedFile> looks_of(const Scene& s) {
  std::vector<NamedFile> out;
  const auto add = adder_to(out);
  const auto picture = [&](const std::string& said, const std::string& surface) {
    const SurfacePicture of = said.empty() ? picture_of_surface(surface) : SurfacePicture{{}, said};
    add(of.materials, "the material file of a surface", false);
    add(of.picture, "the picture on a surface", !said.empty());
  };
  if (s.flesh && s.source == Scene::Source::obj) picture(s.texture, s.obj.path);
  if (!s.head) return out;
  if (!s.head->texture_file.empty()) {
    add(s.head->texture_file, "the surface that a face's colours are of");
    picture(s.head->picture_file, s.head->texture_file);
  }
  for (const std::string& f : s.head->normal_files) add(f, "a normal skull");
  return out;
}

Scene load_scene(const std::string& path) {
  return parse_scene(read_whole_file(path, kMaxBytes, "a scene file"), path);
}

std::string find_scene(const std::string& name_or_path, const std::vector<std::string>& folders) {
  std::error_code ec;
  if (fs::exists(name_or_path, ec) && !fs::is_directory(name_or_path, ec))
    return name_or_path;  // an --out folder may have the name
  std::vector<std::string> names;
  for (const auto& f : folders) {
    const fs::path candidate = fs::path(f) / (name_or_path + ".toml");
    if (name_or_path.find('/') == std::string::npos && fs::exists(candidate, ec)) return candidate.string();
    for (fs::directory_iterator it(f, ec), end; !ec && it != end; it.increment(ec))
      if (it->path().extension() == ".toml") names.push_back(it->path().stem().string());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::string list;
  for (const auto& n : names) list += (list.empty() ? "" : ", ") + n;
  throw InputError(name_or_path, 0,
                   "no such scene; expected a scene file" + (list.empty() ? "" : " or one of: " + list));
}

// What the scene says, else a PNG or JPEG that its material file names, if it is there.
std::string picture_on(const Scene& scene) {
  if (scene.source != Scene::Source::obj || !scene.texture.empty()) return scene.texture;
  return picture_of_surface(scene.obj.path).picture;
}

std::shared_ptr<const Body> build_body(const Scene& scene, SurfaceReport* report) {
  if (scene.source == Scene::Source::obj) {
    auto body = std::make_shared<Body>(load_obj(scene.obj, report));
    body->name = scene.name;
    body->laws = scene.laws;
    if (!scene.texture.empty()) body->rgb.clear();  // a picture is finer
    for (const ColliderSpec& c : scene.colliders) body->colliders.push_back(load_collider(c));
    if (scene.tension.given()) body->tension = tension_lines_of(scene.tension, *body);
    add_thickness(scene, *body);
    add_regions(scene, *body);
    if (const double side = (body->box_max_mm - body->box_min_mm).minCoeff(); scene.cell_mm > side)
      throw InputError(scene.path, 0,
                       "lattice.cell_mm is " + number(scene.cell_mm) + ", larger than the surface's smallest side of " +
                           number(side) + " mm; expected cells that fit into it");
    check_fine_places(scene, body);
    check_load_places(scene, body);
    return body;
  }
  auto body = std::make_shared<Body>(make_block(scene.block));
  body->laws = scene.laws;
  for (const ColliderSpec& c : scene.colliders) body->colliders.push_back(load_collider(c));
  add_thickness(scene, *body);
  add_regions(scene, *body);
  if (report) *report = validate_surface(body->surface, body->grid, scene.path);
  check_fine_places(scene, body);
  check_load_places(scene, body);
  return body;
}

// Of the zone of smaller cells around a load's patch.
constexpr double kAroundLoad_mm = 8;

WorldSpec world_spec(const Scene& scene, std::shared_ptr<const Body> body) {
  WorldSpec w;
  w.body = std::move(body);
  if (const std::string file = picture_on(scene); !file.empty()) w.image = skin_image(file);
  w.cell_mm = scene.cell_mm;
  w.suture_k_N_per_mm = scene.suture_N_per_mm;
  w.suture_bite_mm = scene.suture_bite_mm;
  w.hook_k_N_per_mm = scene.hook_N_per_mm;
  w.hook_tip_mm = scene.hook_tip_mm;
  w.can_cut = scene.can_cut;
  w.refine_fronts = scene.refine_fronts;
  w.refine_pockets = scene.refine_pockets;
  w.region_mm = scene.region_mm;
  w.fine = scene.fine, w.wound_level = scene.wound_level;
  w.dynamic = scene.dynamic;
  w.contact = scene.contact, w.contact_friction = scene.contact_friction;
  w.gravity_m_s2 = scene.gravity_m_s2, w.loads = scene.loads;
  for (const SkinLoad& l : scene.loads)
    if (scene.load_level > 0)
      w.fine.push_back({l.at, l.at, l.radius_mm + kAroundLoad_mm, FineZone{}.depth_mm, scene.load_level});
  w.seed = scene.seed;
  return w;
}

}  // namespace limberg
