#include "app/scene/scene_head_read.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <iterator>

namespace limberg {

namespace {

namespace fs = std::filesystem;
constexpr size_t kMostLandmarks = 200, kMostTissues = 50, kMostBones = 20;

std::vector<std::string> texts(Table& t, const toml::table& head, const char* key, const char* expected) {
  std::vector<std::string> out;
  const toml::node* n = head.get(key);
  const toml::array* a = n ? n->as_array() : nullptr;
  if (n && (!a || a->size() > kMostBones))
    t.fail(key, std::string("is no list of at most 20 names; expected ") + expected);
  if (a)
    for (const toml::node& e : *a) {
      const std::optional<std::string> s = e.value<std::string>();
      if (!s || s->empty() || s->size() > 4000)
        t.fail(key, std::string("holds something that is no name; expected ") + expected);
      out.push_back(*s);
    }
  return out;
}

/// A place, or the name of a landmark.
void place(Table& t, const toml::table& table, const char* key, Vec3& at, std::string& name) {
  const toml::node* n = table.get(key);
  if (!n) t.fail(key, "is missing; expected a place [x, y, z] or the name of a landmark");
  if (n->is_string())
    t.text(key, name, 60);
  else
    t.vector(key, at, 1e4);
}

/// Places, or names of landmarks, each.
void places(Table& t, const toml::table& table, const char* key, size_t least, std::vector<Vec3>& at,
            std::vector<std::string>& names) {
  constexpr size_t kMost = 200;
  const std::string expected =
      fmt::format("expected {} = [\"Zy_R\", \"Go_R\"] or places [x, y, z], {} to {}", key, least, kMost);
  const toml::node* n = table.get(key);
  const toml::array* a = n ? n->as_array() : nullptr;
  if (!a || a->size() < least || a->size() > kMost) t.fail(key, "is no list of places; " + expected);
  for (const toml::node& e : *a) {
    Vec3& x = at.emplace_back(Vec3::Zero());
    std::string& name = names.emplace_back();
    if (const auto s = e.value<std::string>(); s && !s->empty() && s->size() <= 60) {
      name = *s;
      continue;
    }
    const toml::array* v = e.as_array();
    bool good = v && v->size() == 3;
    for (size_t k = 0; good && k < 3; ++k) {
      const std::optional<double> number = (*v)[k].value<double>();
      good = number && std::abs(*number) <= 1e4;
      if (good) x[Eigen::Index(k)] = *number;
    }
    if (!good) t.fail(key, "holds something that is no place; " + expected);
  }
}

void read_landmarks(const toml::table& head, const char* key, const std::string& file,
                    std::vector<std::pair<std::string, Vec3>>& out) {
  const toml::node* n = head.get(key);
  if (!n) return;
  const toml::table* t = n->as_table();
  if (!t || t->size() > kMostLandmarks)
    throw InputError(file, int(n->source().begin.line),
                     std::string("head.") + key + " is no table of at most 200 places; expected NAME = [x, y, z]");
  Table each(t, std::string("head.") + key, file);
  for (const auto& [name, at] : *t) {
    const std::string k(name.str());
    if (k.size() > 40)
      throw InputError(file, int(at.source().begin.line),
                       "a landmark's name is longer than 40 bytes; expected a short one");
    each.vector(k.c_str(), out.emplace_back(k, Vec3::Zero()).second, 1e4);
  }
}

void read_name(Table& t, std::string& name) {
  if (!t.has("name")) t.fail("name", "is missing; expected a name");
  t.text("name", name, 60);
}

HeadScene::TissueAt read_tissue(const toml::table& table, const std::string& file) {
  Table t(&table, "head.tissue", file);
  HeadScene::TissueAt out;
  ConnectTissue& c = out.tissue;
  read_name(t, c.name);
  const bool drawn = t.has("face_outline");
  if (drawn) {
    if (t.has("face")) t.fail("face", "stands beside face_outline; expected one of the two");
    if (!t.has("bone") && t.has("bone_radius_mm")) t.fail("bone_radius_mm", "has no bone; expected bone as well");
    places(t, table, "face_outline", 3, c.face_outline_mm, out.outline_names);
  } else {
    place(t, table, "face", c.face_mm, out.face_name);
    t.real("face_radius_mm", c.face_radius_mm, 0, 500, true);
  }
  if (t.has("bone"))
    place(t, table, "bone", c.bone_mm, out.bone_name);
  else
    c.bone_mm = c.face_mm, out.bone_name = out.face_name;
  t.real("bone_radius_mm", c.bone_radius_mm, 0, 500);
  t.integer("layers", 1, 16, [&](int64_t v) { c.layers = int(v); });
  t.real("young_kPa", c.young_kPa, 0, 1e6, true);
  if (t.has("mode")) {
    std::string mode;
    t.text("mode", mode, 40);
    const auto* at = std::find(std::begin(kTissueKinds), std::end(kTissueKinds), mode);
    if (at == std::end(kTissueKinds)) t.fail("mode", std::string("is of no known kind; expected ") + kTissueKindList);
    c.mode = TissueKind(at - std::begin(kTissueKinds));
  }
  t.finish({"bone", "mode", "face_outline"});
  return out;
}

HeadScene::MuscleAt read_muscle(const toml::table& table, const std::string& file) {
  Table t(&table, "head.muscle", file);
  HeadScene::MuscleAt out;
  simplex::FaceBundle& b = out.bundle;
  read_name(t, b.name);
  places(t, table, "path", 2, b.path_mm, out.names);
  t.real("radius_mm", b.radius_mm, 0.1, 100);
  t.real("young_kPa", b.young_kPa, 0.01, 1e6);
  t.real("k1_kPa", b.k1_kPa, 0, 1e6);
  t.real("k2", b.k2, 1e-6, 1e4);
  t.finish({"path"});
  return out;
}

HeadScene::SlideAt read_slide(const toml::table& table, const std::string& file) {
  Table t(&table, "head.slide", file);
  HeadScene::SlideAt out;
  simplex::FaceSlide& s = out.slide;
  read_name(t, s.name);
  place(t, table, "at", s.at_mm, out.landmark);
  t.real("radius_mm", s.radius_mm, 0.1, 500);
  t.real("kPa_per_mm", s.kPa_per_mm, 1e-4, 1e4);
  t.finish();
  return out;
}

/// The tables of head.KEY, each as `read` has it.
template <class Read, class Out>
void read_list(const toml::table& head, const char* key, const std::string& file, Read read, std::vector<Out>& out) {
  constexpr size_t kMost = 50;
  const toml::node* n = head.get(key);
  if (!n) return;
  const toml::array* a = n->as_array();
  if (!a || a->size() > kMost || !a->is_array_of_tables())
    throw InputError(file, int(n->source().begin.line),
                     fmt::format("head.{0} is no list of at most {1} tables; expected [[head.{0}]]", key, kMost));
  for (const toml::node& e : *a) out.push_back(read(*e.as_table(), file));
}

/// Its surfaces are read when a skull is laid upon them; here they are only looked for.
void read_normal_skull(Table& t, const toml::table& head, const std::string& file, std::vector<std::string>& out) {
  constexpr const char* kKey = "normal_skull";
  if (const toml::node* n = head.get(kKey); n && n->is_string()) {
    t.path(kKey, out.emplace_back());
  } else {
    out = texts(t, head, kKey, "normal_skull = \"skull.obj\" or [\"cranium.stl\", \"mandible.stl\"]");
    for (std::string& f : out) f = beside(file, f);
  }
  for (const std::string& f : out) {
    std::error_code ec;
    if (!fs::is_regular_file(f, ec)) t.fail(kKey, f + " cannot be read; expected a surface");
  }
}

/// Three rows of a turn and a shift, the turn to rounding of what was written.
std::optional<Eigen::Isometry3d> read_isometry(Table& t, const toml::table& head, const char* key) {
  const toml::node* n = head.get(key);
  if (!n) return std::nullopt;
  Eigen::Isometry3d m = Eigen::Isometry3d::Identity();
  const toml::array* rows = n->as_array();
  bool good = rows && rows->size() == 3;
  for (size_t i = 0; good && i < 3; ++i) {
    const toml::array* row = (*rows)[i].as_array();
    good = row && row->size() == 4;
    for (size_t j = 0; good && j < 4; ++j) {
      const std::optional<double> v = (*row)[j].value<double>();
      good = v && std::isfinite(*v) && std::abs(*v) < 1e6;
      if (good) m.matrix()(Eigen::Index(i), Eigen::Index(j)) = *v;
    }
  }
  constexpr double kRounding = 1e-6;
  const Mat3 R = m.linear();
  good = good && (R * R.transpose() - Mat3::Identity()).norm() < kRounding && R.determinant() > 0;
  if (!good) t.fail(key, "is no turn with a shift; expected three rows of four numbers");
  return m;
}

}  // namespace

std::optional<HeadScene> read_head(const toml::table& root, const std::string& file) {
  if (!root.contains("head")) return std::nullopt;
  HeadScene h;
  Table t = section(root, "head", file);
  const toml::table& table = *root.get("head")->as_table();
  std::string source = "synthetic";
  t.text("source", source);
  if (source == "synthetic") {
    t.real("mandible_scale", h.mandible_scale, 0.8, 1.2);
    t.real("ramus_left", h.ramus_left, 0.7, 1.3);
    t.real("vault_wide", h.vault_wide, 0.7, 1.3);
    t.real("vault_long", h.vault_long, 0.7, 1.3);
    t.real("forehead_flat", h.forehead_flat, 0, 1);
    // Memory grows with their number: finer edges than these would take more than 1.4 GB (docs/limits.md).
    t.real("edge_mm", h.edge_mm, 1.5, 12);
    t.real("face_edge_mm", h.face_edge_mm, 1.5, 12);
  } else if (source == "anatomical") {
    h.source = HeadScene::Source::anatomical;
    t.real("edge_mm", h.edge_mm, 1.5, 12);
    t.real("face_edge_mm", h.face_edge_mm, 1.5, 12);
  } else if (source == "files") {
    h.source = HeadScene::Source::files;
    h.bone_files = texts(t, table, "bones", "bones = [\"cranium.txt\", ...]");
    if (h.bone_files.empty()) t.fail("bones", "is missing or empty; expected bones = [\"cranium.txt\", ...]");
    h.fixed = {fs::path(h.bone_files.front()).stem().string()};
    for (std::string& f : h.bone_files) f = beside(file, f);
    if (t.has("axes")) {
      std::string axes;
      t.text("axes", axes);
      if (axes != "lps" && axes != "head")
        t.fail("axes",
               "are no known ones; expected \"lps\" (left, posterior, superior) or \"head\" (right, forwards, up)");
      h.axes = axes == "lps" ? simplex::Axes::left_posterior_superior : simplex::Axes::right_forwards_up;
    }
    if (t.has("face") && table.get("face")->is_string())
      t.path("face", h.face_file);
    else
      h.face = false;
  } else {
    t.fail("source", "is of no known kind; expected \"synthetic\", \"anatomical\" or \"files\"");
  }
  if (t.has("face") && !table.get("face")->is_string()) t.boolean("face", h.face);
  if (h.source == HeadScene::Source::files && h.face && h.face_file.empty())
    t.fail("face", "is true without a file; expected face = \"face.txt\"");
  if (t.has("face_texture")) {
    if (!h.face) t.fail("face_texture", "without a face; expected a head with one");
    t.path("face_texture", h.texture_file);
  }
  for (const char* key : {"face_picture", "face_texture_scale_to_mm"})
    if (t.has(key) && h.texture_file.empty()) t.fail(key, "without face_texture; expected a surface that wears it");
  t.path("face_picture", h.picture_file);
  t.real("face_texture_scale_to_mm", h.texture_scale_to_mm, 0, 1e6, true);
  if (t.has("fixed")) h.fixed = texts(t, table, "fixed", "fixed = [\"cranium\"]");
  t.integer("iterations_per_step", 1, 1000, [&](int64_t v) { h.iterations_per_step = int(v); });
  if (t.has("show_face")) {
    std::string shown;
    t.text("show_face", shown);
    if (shown != "solid" && shown != "clear" && shown != "hidden")
      t.fail("show_face", "is of no known kind; expected \"solid\", \"clear\" or \"hidden\"");
    h.shown = shown == "solid" ? FaceShown::solid : shown == "clear" ? FaceShown::clear : FaceShown::hidden;
  }
  t.vector("offset_mm", h.offset_mm, 1e4);
  read_normal_skull(t, table, file, h.normal_files);
  h.picture_from_head = read_isometry(t, table, "picture_from_head");
  t.real("carries_skin_mm", h.carries_skin_mm, 0, 1000);
  t.finish({"source", "bones", "axes", "face", "fixed", "show_face", "picture_from_head", "normal_skull", "tissue",
            "muscle", "slide", "landmarks", "face_landmarks"});
  if (const toml::node* n = table.get("tissue")) {
    const toml::array* a = n->as_array();
    if (!a || a->size() > kMostTissues)
      throw InputError(file, int(n->source().begin.line),
                       "head.tissue is no list of at most 50 tables; expected [[head.tissue]]");
    for (const toml::node& e : *a) {
      if (!e.is_table())
        throw InputError(file, int(e.source().begin.line),
                         "head.tissue holds something that is no table; expected [[head.tissue]]");
      if (!h.face)
        throw InputError(file, int(e.source().begin.line), "head.tissue without a face; expected a head with one");
      h.tissues.push_back(read_tissue(*e.as_table(), file));
    }
  }
  read_list(table, "muscle", file, read_muscle, h.muscles);
  read_list(table, "slide", file, read_slide, h.slides);
  read_landmarks(table, "landmarks", file, h.landmarks);
  read_landmarks(table, "face_landmarks", file, h.face_landmarks);
  if (!h.face && !h.face_landmarks.empty())
    throw InputError(file, 0, "head.face_landmarks without a face; expected a head with one");
  return h;
}

}  // namespace limberg
