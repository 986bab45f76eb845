#include "app/operating_point/operating_point.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/result/json_nesting.h"
#include "calibration/toml.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

/// The value of `key` in [table], however the file wrote either: under a heading, dotted or inline.
template <class T>
void put(toml::table& root, const char* table, const char* key, T value) {
  root.insert(table, toml::table{});  // unless it is there
  root[table].as_table()->insert_or_assign(key, value);
}

}  // namespace

Scene at_operating_point(const Scene& scene, double cell_mm, int iterations) {
  toml::table root = toml::parse(scene.text, scene.path);
  put(root, "lattice", "cell_mm", std::stod(fmt::format("{:.6g}", cell_mm)));
  put(root, "solver", "iterations_per_step", int64_t(iterations));
  std::ostringstream text;
  text << root << "\n";
  Scene out = parse_scene(text.str(), scene.path, scene.laws);
  out.name = scene.name;
  return out;
}

void fill_operating_point(Result& r, const bench::OperatingPoint& p) {
  r.set("/operating_point/cell_mm", p.cell_mm);
  r.set("/operating_point/iterations", p.iterations);
  r.set("/operating_point/frame_ms", p.frame_ms);
  r.set("/operating_point/error_mm", p.error_mm);
  r.set("/operating_point/budget_ms", p.budget_ms);
  r.set("/operating_point/fits", p.fits);
  r.set_hash("/operating_point/scene_hash", p.scene_hash);
}

bench::OperatingPoint read_operating_point(const std::string& file, const Scene& scene) {
  const auto wrong = [&](const std::string& what) {
    return InputError(file, 0, what + "; expected the result.json of limberg bench accuracy " + scene.name);
  };
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in || text.str().empty()) throw wrong("cannot be read");
  if (json_nesting(text.str()) > 64) throw wrong("nests deeper than 64 levels");
  const nlohmann::json j = nlohmann::json::parse(text.str(), nullptr, false);
  if (!j.is_object() || !j.contains("operating_point") || !j["operating_point"].is_object())
    throw wrong("holds no operating point");
  const nlohmann::json& o = j["operating_point"];
  const auto number = [&](const char* name) {
    if (!o.contains(name) || !o[name].is_number()) throw wrong(std::string("its operating point has no ") + name);
    return o[name].get<double>();
  };
  bench::OperatingPoint p;
  p.cell_mm = number("cell_mm"), p.frame_ms = number("frame_ms"), p.error_mm = number("error_mm"),
  p.budget_ms = number("budget_ms");
  const double its = number("iterations");
  if (!(p.cell_mm > 0 && p.cell_mm < 1e4) || !(its >= 1 && its <= 1e4))
    throw wrong("its operating point has a cell size or a number of iterations that cannot be");
  p.iterations = int(its), p.fits = true, p.scene_hash = scene.hash;
  if (!o.contains("scene_hash") || o["scene_hash"] != hex(scene.hash)) throw wrong("was measured on another scene");
  return p;
}

}  // namespace limberg
