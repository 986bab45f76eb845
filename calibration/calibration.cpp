#include "calibration/calibration.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

#include "calibration/toml.h"
#include "sim/error.h"
#include "sim/hash.h"

namespace limberg {

namespace {

/// The filter's numbers by name, with the range that makes sense; one list for reading, writing and hashing.
struct Field {
  const char* name;
  double FilterParameters::*value;
  double low, high;
};
constexpr Field kFilter[] = {
    {"process_noise_mm2_s3", &FilterParameters::process_noise_mm2_s3, 1e-3, 1e9},
    {"measurement_noise_mm", &FilterParameters::measurement_noise_mm, 1e-4, 100},
    {"turn_process_noise_rad2_s3", &FilterParameters::turn_process_noise_rad2_s3, 1e-6, 1e6},
    {"turn_measurement_noise_rad", &FilterParameters::turn_measurement_noise_rad, 1e-6, 1},
    {"euro_min_cutoff_hz", &FilterParameters::euro_min_cutoff_hz, 1e-3, 1e4},
    {"euro_beta_per_mm", &FilterParameters::euro_beta_per_mm, 0, 1e3},
    {"euro_derivative_cutoff_hz", &FilterParameters::euro_derivative_cutoff_hz, 1e-3, 1e4},
    {"max_prediction_ms", &FilterParameters::max_prediction_ms, 0, 1000},
    {"stale_ms", &FilterParameters::stale_ms, 1, 60'000},
    {"max_speed_mm_s", &FilterParameters::max_speed_mm_s, 1, 1e6},
    {"max_turn_deg", &FilterParameters::max_turn_deg, 0.1, 360},
    {"latency_ms", &FilterParameters::latency_ms, 0, 1000},
};

int line_of(const toml::node& n) { return int(n.source().begin.line); }

void only_keys(const toml::table& t, std::initializer_list<const char*> known, const char* where, const std::string& file) {
  for (const auto& [key, node] : t) {
    bool found = false;
    std::string list;
    for (const char* k : known) {
      found |= key.str() == k;
      list += (list.empty() ? "" : ", ") + std::string(k);
    }
    if (!found)
      throw InputError(file, line_of(node), std::string("unknown key \"") + std::string(key.str()) + "\" in " + where + "; expected " + list);
  }
}

double number(const toml::node& n, const std::string& key, double low, double high, const std::string& file) {
  const auto v = n.value<double>();
  if (!v || !n.is_number() || !std::isfinite(*v) || *v < low || *v > high) {
    std::ostringstream range;
    range << low << " to " << high;
    throw InputError(file, line_of(n), "\"" + key + "\" is not usable; expected a number from " + range.str());
  }
  return *v;
}

template <size_t N>
std::array<double, N> numbers(const toml::node& n, const std::string& key, double limit, const std::string& file) {
  const auto* a = n.as_array();
  if (!a || a->size() != N)
    throw InputError(file, line_of(n), "\"" + key + "\" is not usable; expected a list of " + std::to_string(N) + " numbers");
  std::array<double, N> out{};
  for (size_t i = 0; i < N; ++i) out[i] = number(*a->get(i), key, -limit, limit, file);
  return out;
}

const toml::table* table(const toml::table& t, const char* key, const std::string& file) {
  const toml::node* n = t.get(key);
  if (!n) return nullptr;
  if (!n->is_table()) throw InputError(file, line_of(*n), "\"" + std::string(key) + "\" is not usable; expected a table");
  return n->as_table();
}

/// The fewest decimals that read back to the same bits.
std::string shortest(double v) {
  char text[64];
  const bool plain = v == 0 || (std::abs(v) >= 1e-4 && std::abs(v) < 1e9);
  const auto end = std::to_chars(text, text + sizeof text, v, plain ? std::chars_format::fixed : std::chars_format::scientific);
  std::string s(text, end.ptr);
  if (s.find_first_of(".e") == std::string::npos) s += ".0";
  return s;
}

}  // namespace

Calibration parse_calibration(const std::string& text, const std::string& name) {
  toml::table t;
  try {
    t = toml::parse(text, name);
  } catch (const toml::parse_error& e) {
    throw InputError(name, int(e.source().begin.line), std::string("is not TOML (") + std::string(e.description()) + "); expected a calibration file");
  } catch (const BrokenToml&) {
    throw InputError(name, 0, "is not TOML; expected a calibration file");
  }
  only_keys(t, {"limberg_calibration", "name", "stylus", "world", "filter"}, "a calibration", name);
  const auto version = t["limberg_calibration"].value<int64_t>();
  if (!version || *version != Calibration::kVersion)
    throw InputError(name, 0, "is not a calibration of a known version; expected limberg_calibration = 1");

  Calibration c;
  if (const toml::node* n = t.get("name")) {
    const auto s = n->value<std::string>();
    if (!s || s->size() > 200) throw InputError(name, line_of(*n), "\"name\" is not usable; expected a short text");
    c.name = *s;
  }
  constexpr double kFarMm = 10'000;
  if (const auto* s = table(t, "stylus", name)) {
    only_keys(*s, {"tip_offset_mm"}, "[stylus]", name);
    if (const toml::node* n = s->get("tip_offset_mm")) {
      const auto v = numbers<3>(*n, "tip_offset_mm", kFarMm, name);
      c.tip_offset_mm = Vec3(v[0], v[1], v[2]);
    }
  }
  if (const auto* w = table(t, "world", name)) {
    only_keys(*w, {"from_tracker_mm", "from_tracker_quat"}, "[world]", name);
    if (const toml::node* n = w->get("from_tracker_mm")) {
      const auto v = numbers<3>(*n, "from_tracker_mm", kFarMm, name);
      c.world_from_tracker_mm = Vec3(v[0], v[1], v[2]);
    }
    if (const toml::node* n = w->get("from_tracker_quat")) {
      c.world_from_tracker_quat = numbers<4>(*n, "from_tracker_quat", 2, name);
      double qq = 0;
      for (double v : c.world_from_tracker_quat) qq += v * v;
      if (std::abs(std::sqrt(qq) - 1) > 0.01)
        throw InputError(name, line_of(*n), "\"from_tracker_quat\" is not a rotation; expected w, x, y, z of unit length");
    }
  }
  if (const auto* f = table(t, "filter", name)) {
    for (const auto& [key, node] : *f) {
      const Field* field = nullptr;
      for (const Field& candidate : kFilter)
        if (key.str() == candidate.name) field = &candidate;
      if (!field) throw InputError(name, line_of(node), "unknown key \"" + std::string(key.str()) + "\" in [filter]; see calibration/identity.toml");
      c.filter.*field->value = number(node, field->name, field->low, field->high, name);
    }
  }
  return c;
}

Calibration load_calibration(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, 0, std::string("cannot be opened (") + std::strerror(errno) + "); expected a calibration file");
  std::string text;
  char part[4096];
  while (in.read(part, sizeof part), in.gcount() > 0) {
    text.append(part, size_t(in.gcount()));
    if (text.size() > 1'000'000) throw InputError(path, 0, "is too large for a calibration; expected some lines of TOML");
  }
  if (in.bad()) throw InputError(path, 0, "cannot be read; expected a calibration file");
  return parse_calibration(text, path);
}

std::string to_toml(const Calibration& c) {
  std::string quoted;
  for (char ch : c.name) {
    if (ch == '"' || ch == '\\') quoted += '\\';
    quoted += (unsigned char)ch < 0x20 || ch == 0x7F ? ' ' : ch;
  }
  auto list = [](const double* v, int n) {
    std::string s = "[";
    for (int i = 0; i < n; ++i) s += (i ? ", " : "") + shortest(v[i]);
    return s + "]";
  };
  std::string s = "limberg_calibration = " + std::to_string(Calibration::kVersion) + "\nname = \"" + quoted + "\"\n";
  s += "\n[stylus]  # the tip in the frame of the sensor\ntip_offset_mm = " + list(c.tip_offset_mm.data(), 3) + "\n";
  s += "\n[world]  # pose of the tracker in the world; quaternion w, x, y, z\nfrom_tracker_mm = " +
       list(c.world_from_tracker_mm.data(), 3) + "\nfrom_tracker_quat = " + list(c.world_from_tracker_quat.data(), 4) + "\n";
  s += "\n[filter]  # see calibration.h\n";
  for (const Field& f : kFilter) s += std::string(f.name) + " = " + shortest(c.filter.*f.value) + "\n";
  return s;
}

void save_calibration(const Calibration& c, const std::string& path) {
  const std::string part = path + ".part", text = to_toml(c);
  std::FILE* f = std::fopen(part.c_str(), "wb");
  if (!f) throw InputError(path, 0, std::string("cannot be written (") + std::strerror(errno) + "); expected a writable place");
  bool ok = std::fwrite(text.data(), 1, text.size(), f) == text.size();
  ok = std::fclose(f) == 0 && ok;
  if (!ok || std::rename(part.c_str(), path.c_str()) != 0) {
    const int why = errno;
    std::remove(part.c_str());
    throw InputError(path, 0, std::string("cannot be written (") + std::strerror(why) + "); what was there before is unchanged");
  }
}

uint64_t calibration_hash(const Calibration& c) {
  Hash64 h;
  h.add(int32_t(Calibration::kVersion));
  for (int i = 0; i < 3; ++i) h.add(c.tip_offset_mm[i]);
  for (int i = 0; i < 3; ++i) h.add(c.world_from_tracker_mm[i]);
  for (double v : c.world_from_tracker_quat) h.add(v);
  for (const Field& f : kFilter) h.add(c.filter.*f.value);
  return h.value();
}

}  // namespace limberg
