#include "sim/commands/script_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"

namespace limberg {

using Json = nlohmann::ordered_json;
using L = ScriptLimits;

struct ScriptReader::Data {
  std::string name;
  int line = 0;
  Json json;
};

std::string ScriptReader::number(double v) { return fmt::format("{:g}", v); }

ScriptReader::ScriptReader(std::string_view text, const std::string& name, int line) : data_(new Data{name, line, {}}) {
  Json& json_ = data_->json;
  if (text.size() > L::line_bytes) fail("the line is longer than " + std::to_string(L::line_bytes) + " bytes");
  check_depth(text);
  std::vector<std::pair<int, std::string>> keys;  // of the objects that are open, by depth
  std::string twice;
  const auto watch = [&](int depth, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_end) std::erase_if(keys, [&](const auto& k) { return k.first > depth; });
    if (event == Json::parse_event_t::key) {
      const auto& k = value.get_ref<const std::string&>();
      if (std::find(keys.begin(), keys.end(), std::pair(depth, k)) != keys.end()) twice = k;
      keys.emplace_back(depth, k);
      if (keys.size() > 100) keys.clear(), twice = "(more than 100 keys)";
    }
    return true;
  };
  try {
    json_ = Json::parse(text.begin(), text.end(), watch);
  } catch (const Json::parse_error& e) {
    fail("broken JSON near column " + std::to_string(e.byte) + "; expected one whole JSON object on the line");
  } catch (const Json::exception&) {
    fail("a number is out of range; expected finite numbers");
  }
  if (!json_.is_object()) fail("expected one JSON object on the line");
  if (!twice.empty()) fail("key \"" + shown(twice) + "\" is given twice; expected each key once");
}

ScriptReader::~ScriptReader() = default;

void ScriptReader::fail(const std::string& what) const { throw InputError(data_->name, data_->line, what); }

bool ScriptReader::has(const char* key) const { return data_->json.contains(key); }
bool ScriptReader::is_list(const char* key) const { return has(key) && data_->json[key].is_array(); }

void ScriptReader::only(const std::vector<const char*>& keys, const std::string& where) const {
  for (const auto& [k, v] : data_->json.items()) {
    if (std::any_of(keys.begin(), keys.end(), [&k = k](const char* want) { return k == want; })) continue;
    std::string list;
    for (const char* want : keys) list += (list.empty() ? "" : ", ") + std::string(want);
    fail("unknown key \"" + shown(k) + "\" in " + where + "; expected " + list);
  }
}

std::string ScriptReader::text(const char* key, bool required, size_t max_bytes) const {
  if (!has(key)) {
    if (required) missing(key, "a text");
    return {};
  }
  const Json& v = data_->json[key];
  if (!v.is_string()) fail(quoted(key) + " is not a text");
  const auto& s = v.get_ref<const std::string&>();
  if (required && s.empty()) fail(quoted(key) + " is empty");
  if (s.size() > max_bytes) fail(quoted(key) + " is longer than " + std::to_string(max_bytes) + " bytes");
  return s;
}

int64_t ScriptReader::integer(const char* key, int64_t lo, int64_t hi) const {
  if (!has(key)) missing(key, "an integer");
  const Json& v = data_->json[key];
  const std::string range = "; expected an integer from " + std::to_string(lo) + " to " + std::to_string(hi);
  if (!v.is_number_integer()) fail(quoted(key) + " is not an integer" + range);
  if (v.is_number_unsigned() && v.get<uint64_t>() > uint64_t(INT64_MAX)) fail(quoted(key) + " is out of range" + range);
  const int64_t i = v.get<int64_t>();
  if (i < lo || i > hi) fail(quoted(key) + " is " + std::to_string(i) + range);
  return i;
}

bool ScriptReader::boolean(const char* key, bool otherwise) const {
  if (!has(key)) return otherwise;
  if (!data_->json[key].is_boolean()) fail(quoted(key) + " is neither true nor false; expected one of them");
  return data_->json[key].get<bool>();
}

double ScriptReader::real(const char* key, double otherwise, double lo, double hi, bool open) const {
  if (!has(key)) return otherwise;
  const Json& v = data_->json[key];
  const std::string range =
      std::string("; expected a number ") + (open ? "above " : "from ") + number(lo) + " to " + number(hi);
  if (!v.is_number()) fail(quoted(key) + " is not a number" + range);
  const double d = v.get<double>();
  if (!std::isfinite(d) || d < lo || d > hi || (open && d == lo)) fail(quoted(key) + " is " + number(d) + range);
  return d;
}

bool ScriptReader::has_places(const char* key) const {
  if (!has(key)) return false;
  const Json& v = data_->json[key];
  const Json& first = v.is_array() && !v.empty() && v[0].is_structured() ? v[0] : v;
  return first.is_object() || (first.is_array() && first.size() == 3 && first[0].is_number());
}

std::vector<Landmark> ScriptReader::landmarks(const char* key) const {
  std::vector<Landmark> out;
  if (!has(key)) return out;
  if (!data_->json[key].is_object() || data_->json[key].size() > L::landmarks)
    fail(quoted(key) + " is no list of at most " + std::to_string(L::landmarks) +
         " named points; expected {\"name\":[x, y], ...}");
  for (const auto& [name, at] : data_->json[key].items()) {
    if (name.empty() || name.size() > L::name_bytes) fail(quoted(key) + " holds a name that is empty or too long");
    double c[2];
    coordinates(&at, c, 2, key);
    out.push_back({name, {c[0], c[1]}});
  }
  return out;
}

std::optional<PlannedProcedure> ScriptReader::plan(const char* key) const {
  if (!has(key)) return std::nullopt;
  const std::string expected =
      "; expected {\"procedure\":\"NAME\",\"values\":{...},\"at\":[x, y],\"turn_deg\":0,\"mirror\":false}";
  const Json& p = data_->json[key];
  if (!p.is_object() || !p.contains("procedure") || !p["procedure"].is_string())
    fail(quoted(key) + " names no procedure" + expected);
  PlannedProcedure out;
  out.procedure = p["procedure"].get<std::string>();
  for (const auto& [k, v] : p.items()) {
    if (k == "procedure") continue;
    if (k == "values" && v.is_object() && v.size() <= 32) {
      for (const auto& [name, value] : v.items()) {
        if (!value.is_number() || !std::isfinite(value.get<double>()))
          fail("\"values\" holds something that is not a number" + expected);
        out.values.emplace_back(name, value.get<double>());
      }
    } else if (k == "at") {
      double c[2];
      coordinates(&v, c, 2, "at");
      out.at = {c[0], c[1]};
    } else if (k == "turn_deg" && v.is_number() && std::abs(v.get<double>()) <= 3600) {
      out.turn_deg = v.get<double>();
    } else if (k == "mirror" && v.is_boolean()) {
      out.mirrored = v.get<bool>();
    } else {
      fail(quoted(key) + " holds \"" + shown(k) + "\", which is unknown or of a wrong kind" + expected);
    }
  }
  return out;
}

StitchPick ScriptReader::stitch(const char* key) const {
  if (!has(key)) missing(key, "the number of a stitch or a place [x, y]");
  if (data_->json[key].is_array()) return {0, point(key)};
  return {int(integer(key, 1, L::max_id)), {0, 0}};
}

FragmentPick ScriptReader::fragment(const char* key) const {
  if (is_list(key)) return {-1, place(key)};
  if (!has(key)) fail(quoted(key) + " is missing; expected the number of a fragment or a place [x, y, z] on it");
  return {int32_t(integer(key, 0, L::max_id)), Vec3::Zero()};
}

size_t ScriptReader::choice(const char* key, std::span<const char* const> names) const {
  const std::string given = text(key, true, 40);
  const auto at = std::find(names.begin(), names.end(), given);
  if (at == names.end())
    fail(quoted(key) + " is \"" + shown(given) + "\"; expected " + listed({names.begin(), names.end()}));
  return size_t(at - names.begin());
}

std::string ScriptReader::listed(const std::vector<std::string>& names) {
  std::string s;
  for (size_t i = 0; i < names.size(); ++i) s += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
  return s;
}

ChartPoint ScriptReader::point(const char* key) const {
  if (!has(key)) missing(key, "a point [x, y]");
  double c[2];
  coordinates(&data_->json[key], c, 2, key);
  return {c[0], c[1]};
}

Vec3 ScriptReader::place(const char* key, Textures textures) const {
  if (!has(key)) missing(key, "a place [x, y, z]");
  return place_of(&data_->json[key], key, textures);
}

// Of a texture place the third number is none.
Vec3 ScriptReader::place_of(const void* value, const char* key, Textures textures) const {
  const Json& v = *static_cast<const Json*>(value);
  double c[3] = {0, 0, std::numeric_limits<double>::quiet_NaN()};
  if (textures == Textures::none || !v.is_object()) {
    coordinates(&v, c, 3, key);
  } else {
    if (v.size() != 1 || !v.contains("uv"))
      fail(quoted(key) + " holds an object that is no place; expected {\"uv\": [u, v]}, [x, y, z] or [x, y]");
    coordinates(&v["uv"], c, 2, key);
  }
  return {c[0], c[1], c[2]};
}

size_t ScriptReader::list_size(const char* key, size_t least, const char* of) const {
  const std::string list = std::string("a list of points [[") + of + "], ...]";
  if (!has(key)) missing(key, list);
  const Json& v = data_->json[key];
  if (!v.is_array()) fail(quoted(key) + " is not " + list);
  if (v.size() < least || v.size() > L::path_points)
    fail(quoted(key) + " has " + std::to_string(v.size()) + " points; expected " + std::to_string(least) + " to " +
         std::to_string(L::path_points));
  return v.size();
}

std::vector<ChartPoint> ScriptReader::path(const char* key, size_t least) const {
  std::vector<ChartPoint> p;
  p.reserve(list_size(key, least, "x, y"));
  for (const Json& e : data_->json[key]) {
    double c[2];
    coordinates(&e, c, 2, key);
    p.emplace_back(c[0], c[1]);
  }
  return p;
}

std::vector<Vec3> ScriptReader::places(const char* key, size_t least, Textures textures) const {
  std::vector<Vec3> p;
  p.reserve(list_size(key, least, "x, y, z"));
  for (const Json& e : data_->json[key]) p.push_back(place_of(&e, key, textures));
  return p;
}

std::string ScriptReader::shown(const std::string& s) {
  std::string out;
  for (char c : s.substr(0, 40)) out += (c >= ' ' && c != 127) ? c : '?';
  return out + (s.size() > 40 ? "..." : "");
}

void ScriptReader::missing(const char* key, const std::string& what) const {
  fail("key " + quoted(key) + " is missing; expected " + what);
}

void ScriptReader::coordinates(const void* value, double* out, size_t n, const char* key) const {
  const Json& v = *static_cast<const Json*>(value);
  const std::string want = n == 2 ? "; expected points [x, y]" : "; expected [x, y, z]";
  if (!v.is_array() || v.size() != n)
    fail(quoted(key) + " holds something that is not " + std::to_string(n) + " numbers" + want);
  for (size_t i = 0; i < n; ++i) {
    if (!v[i].is_number()) fail(quoted(key) + " holds a coordinate that is not a number" + want);
    out[i] = v[i].get<double>();
    if (!std::isfinite(out[i]) || std::abs(out[i]) > L::coordinate_mm)
      fail(quoted(key) + " holds the coordinate " + number(out[i]) + "; expected at most " + number(L::coordinate_mm) +
           " mm");
  }
}

void ScriptReader::check_depth(std::string_view text) const {
  int depth = 0;
  bool in_text = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '[' || c == '{') {
      if (++depth > 4) fail("brackets are nested too deeply; expected an object of numbers and points");
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
}

}  // namespace limberg
