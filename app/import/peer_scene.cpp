#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>

#include "app/import/lenient_json.h"
#include "app/import/peer_files.h"
#include "sim/base/error.h"
#include "sim/base/quoted.h"

namespace limberg {
namespace {

const LenientJson* part(const LenientJson& root, const char* name, LenientJson::Kind kind, const std::string& file) {
  const LenientJson* v = root.find(name);
  if (v && !v->is(kind))
    throw InputError(file, v->line, fmt::format("{} is {}; expected {}", name, kind_words(v->kind), kind_words(kind)));
  return v;
}

/// A model's name: a file beside the scene, never a way out of its folder.
std::string model_name(const std::string& name, const std::string& file, int line) {
  if (name.empty() || name.size() > 200 || name.find_first_of("/\\") != std::string::npos || name == "." ||
      name == "..")
    throw InputError(file, line,
                     limberg::quoted(name) + " is no name of a model; expected a file's name without a folder");
  for (const char c : name)
    if (static_cast<unsigned char>(c) < ' ' || c == 127)
      throw InputError(file, line, limberg::quoted(name) + " is no name of a model; expected printable characters");
  return name;
}

std::vector<std::string> names_in(const LenientJson& root, const char* key, const std::string& file) {
  std::vector<std::string> out;
  if (const LenientJson* v = part(root, key, LenientJson::Kind::object, file))
    for (size_t i = 0; i < v->key.size(); ++i) out.push_back(model_name(v->key[i], file, v->item[i].line));
  return out;
}

double property(const LenientJson& of, const char* key, double least, double most, const std::string& file) {
  const LenientJson* v = part(of, key, LenientJson::Kind::number, file);
  if (!v) return 0;
  if (!(v->number >= least && v->number <= most))
    throw InputError(file, v->line, fmt::format("{} is {:g}; expected {:g} to {:g}", key, v->number, least, most));
  return v->number;
}

/// The picture that a number stands for, by textureFiles. `number` may be null.
std::string picture_numbered(const LenientJson& root, const LenientJson* number, const std::string& file) {
  const LenientJson* files = root.find("textureFiles");
  if (!number || !number->is(LenientJson::Kind::number) || !files) return {};
  for (size_t i = 0; i < files->key.size(); ++i)
    if (files->item[i].is(LenientJson::Kind::number) && files->item[i].number == number->number)
      return model_name(files->key[i], file, files->item[i].line);
  return {};
}

}  // namespace

PeerScene parse_peer_scene(std::string_view text, const std::string& file) {
  PeerScene s;
  s.file = file;
  const LenientJson root = parse_lenient_json(text, file, &s.mended);
  if (!root.is(LenientJson::Kind::object))
    throw InputError(file, root.line, fmt::format("the scene is {}; expected an object", kind_words(root.kind)));
  const LenientJson* objects = part(root, "dynamicObjects", LenientJson::Kind::object, file);
  if (!objects || objects->key.empty())
    throw InputError(file, root.line, "dynamicObjects names no model; expected the OBJ file of the tissue");
  if (objects->key.size() > 1)
    throw InputError(file, objects->line,
                     fmt::format("dynamicObjects names {} models; expected one", objects->key.size()));
  s.object_line = objects->item[0].line;
  s.object = model_name(objects->key[0], file, s.object_line);
  // The first of an object's texture maps is the picture of its skin.
  if (const LenientJson* maps = objects->item[0].find("textureMaps"); maps && !maps->item.empty())
    s.texture = picture_numbered(root, &maps->item[0], file);
  s.scenery = names_in(root, "staticObjects", file);
  s.volumes = names_in(root, "tetrahedralSubsets", file);
  // Weights of small strains, in those of the tissue round about.
  const char* const weight = "lowTetWeight";
  const LenientJson* all = root.find("tetrahedralProperties");
  const double usual = all && all->is(LenientJson::Kind::object) ? property(*all, weight, 0, 1e12, file) : 0;
  for (const std::string& name : s.volumes) {
    const LenientJson* of = root.find("tetrahedralSubsets")->find(name);
    const double own = of && of->is(LenientJson::Kind::object) ? property(*of, weight, 0, 1e12, file) : 0;
    s.volume_stiffness.push_back(usual > 0 && own > 0 ? own / usual : 0);
  }
  s.colliders = names_in(root, "fixedCollisionSets", file);
  const LenientJson* still = root.find("staticObjects");
  for (const std::string& name : s.colliders) {
    const LenientJson* object = still ? still->find(name) : nullptr;
    s.collider_texture.push_back(picture_numbered(root, object ? object->find("textureMap") : nullptr, file));
  }
  if (const LenientJson* p = part(root, "tetrahedralProperties", LenientJson::Kind::object, file)) {
    s.subdivisions = int(property(*p, "maxDimMegatetSubdivs", 1, 10'000, file));
    s.levels = int(property(*p, "nTetSizeLevels", 1, 12, file));
    s.stitch_spacing = property(*p, "autoSutureSpacing", 0, 100, file);
    s.strain_least = property(*p, "minStrain", 0, 100, file), s.strain_most = property(*p, "maxStrain", 0, 100, file);
  }
  return s;
}

PeerBed parse_peer_bed(std::string_view text, const std::string& file) {
  PeerBed bed;
  int line = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    std::string_view l = text.substr(at, end - at);
    at = end + 1;
    ++line;
    const auto fail = [&](const std::string& what) { throw InputError(file, line, what); };
    const auto next = [&](auto& v) {
      size_t a = l.find_first_not_of(" \t\r");
      if (a == std::string_view::npos) return false;
      size_t b = std::min(l.find_first_of(" \t\r", a), l.size());
      const auto [stop, ec] = std::from_chars(l.data() + a, l.data() + b, v);
      const bool good = ec == std::errc() && stop == l.data() + b;
      l.remove_prefix(b);
      return good;
    };
    if (l.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    int32_t vertex = -1;
    Vec3 p = Vec3::Zero();
    if (!next(vertex) || !next(p[0]) || !next(p[1]) || !next(p[2]) ||
        l.find_first_not_of(" \t\r") != std::string_view::npos)
      fail("is no deep point; expected a vertex number and three coordinates");
    if (vertex < 0 || vertex >= PeerLimits::vertices)
      fail(fmt::format("names vertex {}; expected one of a model", vertex));
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > PeerLimits::coordinate)
      fail("holds a coordinate that cannot be used; expected finite numbers of at most 10000");
    if (bed.vertex.size() == size_t(PeerLimits::vertices)) fail("more than 2 million deep points");
    bed.vertex.push_back(vertex), bed.deep.push_back(p);
  }
  return bed;
}

}  // namespace limberg
