#include "app/operating_point/operating_point.h"

#include <fmt/format.h>

#include <sstream>

#include "app/result/json_nesting.h"
#include "app/result/read_result.h"
#include "calibration/toml.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {
namespace {

/// The value of `key` in [table], however the file wrote either: under a heading, dotted or inline.
template <class T>
void put(toml::table& root, const char* table, const char* key, T value) {
  root.insert(table, toml::table{});  // unless it is there
  root[table].as_table()->insert_or_assign(key, value);
}

// Smaller cells keep their share of cell_mm.
void scale_fine_cells(toml::table& root, double by) {
  const auto scale = [by](toml::table* t, const char* key) {
    if (!t) return;
    const auto size_mm = (*t)[key].value<double>();
    if (size_mm) t->insert_or_assign(key, std::stod(fmt::format("{:.6g}", *size_mm * by)));
  };
  toml::table* lattice = root["lattice"].as_table();
  scale(lattice, "wound_cell_mm");
  scale(root["loads"].as_table(), "cell_mm");
  if (toml::array* fine = lattice ? (*lattice)["fine"].as_array() : nullptr)
    for (toml::node& zone : *fine) scale(zone.as_table(), "cell_mm");
}

/// operating_point
struct ResultOperatingPoint {
  Maybe cell_mm;
  MaybeCount iterations;
  Maybe frame_ms, error_mm, budget_ms;
  bool fits = false;
  std::string scene_hash;
};
void fields(ResultOperatingPoint& x, auto&& f) {
  f("cell_mm", x.cell_mm), f("iterations", x.iterations), f("frame_ms", x.frame_ms), f("error_mm", x.error_mm);
  f("budget_ms", x.budget_ms), f("fits", x.fits), f("scene_hash", x.scene_hash);
}

}  // namespace

Scene at_operating_point(const Scene& scene, double cell_mm, int iterations) {
  toml::table root = toml::parse(scene.text, scene.path);
  put(root, "lattice", "cell_mm", std::stod(fmt::format("{:.6g}", cell_mm)));
  scale_fine_cells(root, cell_mm / scene.cell_mm);
  put(root, "solver", "iterations_per_step", int64_t(iterations));
  std::ostringstream text;
  text << root << "\n";
  Scene out = parse_scene(text.str(), scene.path, scene.laws);
  out.name = scene.name;
  return out;
}

void fill_operating_point(Result& r, const bench::OperatingPoint& p) {
  write_fields(
      r, "/operating_point",
      ResultOperatingPoint{p.cell_mm, p.iterations, p.frame_ms, p.error_mm, p.budget_ms, p.fits, hex(p.scene_hash)});
}

bench::OperatingPoint read_operating_point(const std::string& file, const Scene& scene) {
  const auto wrong = [&](const std::string& what) {
    return InputError(file, 0, what + "; expected the result.json of limberg bench accuracy " + scene.name);
  };
  constexpr size_t kMost = size_t(64) << 20;
  const std::string text = read_whole_file(file, kMost, "the result.json of limberg bench accuracy " + scene.name);
  if (text.empty()) throw wrong("is empty");
  if (json_nesting(text) > 64) throw wrong("nests deeper than 64 levels");
  const nlohmann::json j = nlohmann::json::parse(text, nullptr, false);
  if (!j.is_object() || !j.contains("operating_point") || !j["operating_point"].is_object())
    throw wrong("holds no operating point");
  ResultOperatingPoint o;
  result_json::read(j["operating_point"], o);
  fields(o, [&](const char* name, const auto& v) {
    using V = std::decay_t<decltype(v)>;
    if constexpr (std::is_same_v<V, Maybe> || std::is_same_v<V, MaybeCount>)
      if (!v) throw wrong(std::string("its operating point has no ") + name);
  });
  if (!(*o.cell_mm > 0 && *o.cell_mm < 1e4) || !(*o.iterations >= 1 && *o.iterations <= 10'000))
    throw wrong("its operating point has a cell size or a number of iterations that cannot be");
  if (o.scene_hash != hex(scene.hash)) throw wrong("was measured on another scene");
  bench::OperatingPoint p;
  p.cell_mm = *o.cell_mm, p.frame_ms = *o.frame_ms, p.error_mm = *o.error_mm, p.budget_ms = *o.budget_ms;
  p.iterations = int(*o.iterations), p.fits = true, p.scene_hash = scene.hash;
  return p;
}

}  // namespace limberg
