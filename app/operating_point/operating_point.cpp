#include "app/operating_point/operating_point.h"

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/result/json_nesting.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

/// Sets `key` of the table [table], replacing its line or adding one.
std::string with_value(const std::string& text, const std::string& table, const std::string& key,
                       const std::string& value) {
  std::istringstream in(text);
  std::string out, line;
  bool inside = false, set = false;
  const auto trimmed = [](const std::string& s) {
    const size_t a = s.find_first_not_of(" \t");
    return a == std::string::npos ? std::string() : s.substr(a);
  };
  while (std::getline(in, line)) {
    const std::string t = trimmed(line);
    if (!t.empty() && t[0] == '[') {
      if (inside && !set) out += key + " = " + value + "\n", set = true;
      inside = t.compare(0, table.size() + 2, "[" + table + "]") == 0;
    } else if (inside && !set && t.compare(0, key.size(), key) == 0 && t.find('=') != std::string::npos &&
               trimmed(t.substr(key.size()))[0] == '=') {
      out += key + " = " + value + "    # for the time of a frame\n", set = true;
      continue;
    }
    out += line + "\n";
  }
  if (!set) out += (inside ? "" : "\n[" + table + "]\n") + key + " = " + value + "\n";
  return out;
}

}  // namespace

Scene at_operating_point(const Scene& scene, double cell_mm, int iterations) {
  char cell[32];
  std::snprintf(cell, sizeof cell, "%.6g", cell_mm);
  std::string number = cell;
  if (number.find_first_of(".e") == std::string::npos) number += ".0";
  const std::string text = with_value(with_value(scene.text, "lattice", "cell_mm", number), "solver",
                                      "iterations_per_step", std::to_string(iterations));
  Scene out = parse_scene(text, scene.path);
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
