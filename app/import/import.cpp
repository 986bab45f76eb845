#include "app/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "render/image.h"
#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/base/whole_file.h"
#include "sim/geometry/io/obj_text.h"
#include "sim/geometry/sided_patch.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostModel = size_t(256) << 20, kMostText = size_t(16) << 20;
// Files do not say their unit. A face of 20 to 30 units is one of centimetres; the peer's infant lips measure some 4.
constexpr double kSmall_units = 10, kLarge_mm = 10, kSmall_mm = 20;

std::string lower(std::string s) {
  for (char& c : s) c = c >= 'A' && c <= 'Z' ? char(c + 32) : c;
  return s;
}

/// A file of that name in one of the folders; upper and lower case are one where no name is exact. Empty: none.
std::string look_for(const std::string& name, const std::vector<std::string>& folders) {
  std::error_code ec;
  for (const std::string& folder : folders)
    if (const fs::path file = fs::path(folder) / name; fs::is_regular_file(file, ec)) return file.string();
  for (const std::string& folder : folders)
    for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec))
      if (lower(it->path().filename().string()) == lower(name) && it->is_regular_file(ec)) return it->path().string();
  return {};
}

std::string needed(const std::string& name, const std::vector<std::string>& folders, const std::string& by, int line,
                   const char* what) {
  const std::string file = look_for(name, folders);
  if (!file.empty()) return file;
  std::string list;
  for (const std::string& f : folders) list += (list.empty() ? "" : ", ") + (f.empty() ? "." : f);
  throw InputError(by, line,
                   limberg::quoted(name, 200) + " is not there; expected " + what + " in " + list + " (see --models)");
}

std::string safe_name(const std::string& stem) {
  std::string s = stem.substr(0, 80);
  for (char& c : s)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_')) c = '_';
  return s.empty() ? "operation" : s;
}

double largest_coordinate_span(const std::string& obj, const std::string& file, const PeerScene& scene) {
  const PeerModel m = parse_peer_model(obj, file, scene, nullptr, "", 1);
  return (m.high_mm - m.low_mm).maxCoeff();
}

/// Why tissue cannot be kept out of it, or nothing: much of it lies in there from the beginning. (The peer keeps named
/// places out, and lets all others through.)
std::string why_not_outside(const Collider& c, const TriMesh& tissue) {
  constexpr double kDeep_mm = 1, kMost = 0.1;  // collider_contacts.h leaves what lies deeper where it is
  const SidedPatch patch(c.mesh);
  Vec3 low = c.mesh.X_mm[0], high = low;
  for (const Vec3& X : c.mesh.X_mm) low = low.cwiseMin(X), high = high.cwiseMax(X);
  size_t near = 0, deep = 0;
  double deepest_mm = 0;
  Bvh::Closest last;
  for (const Vec3& X : tissue.X_mm) {
    if ((X.array() < low.array()).any() || (X.array() > high.array()).any()) continue;
    const double depth_mm = patch.depth_mm(X, last);
    ++near, deep += depth_mm > kDeep_mm, deepest_mm = std::max(deepest_mm, depth_mm);
  }
  if (double(deep) <= kMost * double(near)) return {};
  return fmt::format("{} places of the tissue's surface lie in it at rest, up to {:.1f} mm deep", deep, deepest_mm);
}

/// The colours of a surface's vertices, from its picture at the first place that each has on it. Empty: there is none.
std::vector<Vec3f> colours_by_picture(const std::string& obj, const std::string& obj_file, const std::string& picture) {
  if (picture.empty()) return {};
  const Image image = read_picture(picture);
  const ObjText read = parse_obj_text(obj, obj_file, {500'000, 1'000'000});
  std::vector<Vec3f> rgb(read.v.size(), Vec3f::Constant(-1));
  for (const ObjText::Corner& c : read.corner) {
    if (c.vt < 0 || rgb[size_t(c.v)].x() >= 0) continue;
    const Eigen::Vector2f uv = read.vt[size_t(c.vt)];
    const auto pixel = [](float part, int n) { return std::clamp(int(std::floor(part * float(n))), 0, n - 1); };
    const Rgb8 p = image.at(pixel(uv.x(), image.width), pixel(1 - uv.y(), image.height));
    rgb[size_t(c.v)] = Vec3f(p.r, p.g, p.b) / 255;
  }
  if (std::any_of(rgb.begin(), rgb.end(), [](const Vec3f& c) { return c.x() < 0; })) return {};
  return rgb;
}

/// What cannot be used is left out, and said.
void read_colliders(Imported& x, const std::vector<std::string>& folders) {
  constexpr size_t kMost = 16;  // of a scene of ours
  for (size_t i = 0; i < x.scene.colliders.size(); ++i) {
    const std::string& name = x.scene.colliders[i];
    const std::string file = look_for(fs::path(name).filename().string(), folders);
    std::string why = file.empty() ? "is not there" : x.colliders.size() == kMost ? "is one too many" : "";
    if (why.empty()) try {
        ColliderSpec spec;
        spec.path = file, spec.scale_to_mm = x.unit_mm;
        const std::string obj = read_whole_file(file, kMostModel, "a collider");
        const auto collider = std::make_shared<Collider>(*parse_collider(obj, spec));
        try {
          collider->rgb = colours_by_picture(obj, file, look_for(x.scene.collider_texture[i], folders));
        } catch (const InputError&) {
          // in one colour, as ours are
        }
        why = why_not_outside(*collider, x.model.mesh);
        if (why.empty()) x.colliders.push_back(collider);
      } catch (const InputError& e) {
        why = e.what();
      }
    if (!why.empty())
      x.colliders_left_out.push_back(
          fmt::format(english("Nothing keeps tissue out of {}: {}."), limberg::quoted(name, 200), why));
  }
}

/// Tissue of another kind: what cannot be used is left out, and said.
void read_volumes(Imported& x, const std::vector<std::string>& folders) {
  constexpr size_t kMost = 64;                       // of a scene of ours
  constexpr double kLeast = 0.01, kMostStiff = 1e4;  // beyond, a weight says that something does not give at all
  for (size_t i = 0; i < x.scene.volumes.size(); ++i) {
    const std::string& name = x.scene.volumes[i];
    const double stiffness = x.scene.volume_stiffness[i];
    const std::string file = look_for(fs::path(name).filename().string(), folders);
    std::string why = file.empty()                ? "is not there"
                      : !(stiffness > 0)          ? "has no weight"
                      : x.volumes.size() == kMost ? "is one too many"
                                                  : "";
    if (why.empty()) try {
        ColliderSpec spec;
        spec.path = file, spec.scale_to_mm = x.unit_mm, spec.what = "region";
        x.volumes.push_back({name, load_collider(spec), std::clamp(stiffness, kLeast, kMostStiff)});
      } catch (const InputError& e) {
        why = e.what();
      }
    if (!why.empty())
      x.volumes_left_out.push_back(
          fmt::format(english("{} is as soft as the rest: it {}."), limberg::quoted(name, 200), why));
  }
}

/// The picture of the skin, if it is there and can be read.
void read_texture(Imported& x, const std::vector<std::string>& folders) {
  if (x.scene.texture.empty()) return;
  x.texture_file = look_for(x.scene.texture, folders);
  if (x.texture_file.empty()) {
    x.texture_why = "it is not there";
    return;
  }
  try {
    std::string bytes = read_whole_file(x.texture_file, kMostPng, "a picture");
    decode_picture(bytes, x.texture_file);
    x.texture = std::move(bytes);
  } catch (const InputError& e) {
    x.texture_why = e.what();
  }
}

std::vector<std::string> missing_of(const Imported& x) {
  std::vector<std::string> out;
  const auto list = [](const std::vector<std::string>& names) {
    std::string s;
    for (const std::string& n : names) s += (s.empty() ? "" : ", ") + n;
    return s;
  };
  out.insert(out.end(), x.colliders_left_out.begin(), x.colliders_left_out.end());
  if (!x.scene.scenery.empty()) out.push_back(fmt::format(english("Scenery is not drawn: {}."), list(x.scene.scenery)));
  out.insert(out.end(), x.volumes_left_out.begin(), x.volumes_left_out.end());
  if (x.scene.strain_most > 0)
    out.push_back(fmt::format(
        english("The peer's limits of stretch, {:g} to {:g}, are not carried: our tissue stiffens by its law."),
        x.scene.strain_least, x.scene.strain_most));
  out.push_back(english("The skin has no tension of its own at rest, as the peer's has none."));
  if (x.bed_file.empty()) out.push_back(english("There are no deep points: the skin is taken as 2 mm everywhere."));
  if (x.texture.empty() && !x.scene.texture.empty())
    out.push_back(fmt::format(english("The picture of the skin, {}, is not drawn: {}."),
                              limberg::quoted(x.scene.texture, 200), x.texture_why));
  out.push_back(english("Of the peer's pictures that of the skin alone is drawn: wounds look as ours do."));
  return out;
}

}  // namespace

Imported import_peer(const ImportSettings& s) {
  Imported x;
  const fs::path input(s.input);
  const std::string ending = lower(input.extension().string());
  if (ending != ".hst" && ending != ".smd")
    throw InputError(s.input, 0,
                     "is neither a history nor a scene of the peer by its name; expected NAME.hst or NAME.smd");
  std::vector<std::string> folders{input.parent_path().string().empty() ? "." : input.parent_path().string()};
  folders.insert(folders.end(), s.models.begin(), s.models.end());
  x.name = safe_name(input.stem().string());
  PeerHistory history;
  std::string scene_name;
  int scene_line = 0;
  if (ending == ".hst") {
    x.history_file = s.input;
    history = parse_peer_history(read_whole_file(s.input, kMostText, "a history"), s.input);
    for (const PeerAct& a : history.act)
      if (a.kind == PeerAct::Kind::load_scene && a.wrong.empty() && scene_name.empty())
        scene_name = fs::path(a.scene).filename().string(), scene_line = a.line;
    if (scene_name.empty())
      throw InputError(s.input, 0, "names no scene; expected an act loadSceneFile with the name of a .smd file");
    x.scene_file = needed(scene_name, folders, s.input, scene_line, "the scene");
  } else {
    x.scene_file = s.input;
  }
  x.scene = parse_peer_scene(read_whole_file(x.scene_file, kMostText, "a scene"), x.scene_file);
  folders.push_back(fs::path(x.scene_file).parent_path().string());
  x.model_file = needed(x.scene.object, folders, x.scene_file, x.scene.object_line, "the model");
  const std::string obj = read_whole_file(x.model_file, kMostModel, "a model");
  x.bed_file = look_for(fs::path(x.scene.object).stem().string() + ".bed", folders);
  std::optional<PeerBed> bed;
  if (!x.bed_file.empty()) bed = parse_peer_bed(read_whole_file(x.bed_file, kMostModel, "deep points"), x.bed_file);
  x.unit_mm = s.unit_mm;
  if (!(x.unit_mm > 0)) {
    x.unit_guessed = true;
    // (at a length that every model can have; the real one is checked below)
    x.unit_mm = largest_coordinate_span(obj, x.model_file, x.scene) < kSmall_units ? kSmall_mm : kLarge_mm;
  }
  x.model = parse_peer_model(obj, x.model_file, x.scene, bed ? &*bed : nullptr, x.bed_file, x.unit_mm);
  read_colliders(x, folders);
  read_volumes(x, folders);
  read_texture(x, folders);
  x.skin_mm = x.model.median_depth_mm();
  if (!(x.skin_mm > 0)) x.skin_mm = 2;
  CarrySettings c;
  // An infant's lip wants finer stitches than a cheek: by the cells that the peer thought fit for it.
  const double fine_mm = x.model.history_mm > 0 ? x.model.history_mm : 1;
  x.spacing_mm = c.spacing_mm = s.spacing_mm > 0 ? s.spacing_mm : std::clamp(6 * fine_mm, 1.5, 3.0);
  x.bite_mm = std::clamp(3 * fine_mm, 0.5, 2.0);
  x.operation = carry(history, x.model, c);
  x.mended = history.mended;
  x.mended.insert(x.mended.end(), x.scene.mended.begin(), x.scene.mended.end());
  // What moves: the wound and as much around it again.
  x.region_mm = 1.6 * x.operation.reach_mm + 20;
  x.cell_mm = s.cell_mm > 0 ? s.cell_mm : std::clamp(4 * x.model.history_mm, 1.5, 5.0);
  const Vec3 size = x.model.high_mm - x.model.low_mm;
  x.cell_mm = std::min(x.cell_mm, size.minCoeff());
  x.triangles = int64_t(x.model.mesh.tri.size());
  for (const int material : x.model.material)
    x.held += material == peer_material::periosteum || material == peer_material::periphery;
  x.missing = missing_of(x);
  return x;
}

}  // namespace limberg
