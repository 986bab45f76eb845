#include "calibration/calibration.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>

#include "calibration/toml.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/base/whole_file.h"

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

struct GloveField {
  const char* name;
  double GloveParameters::*value;
  double low, high;
};
constexpr GloveField kGlove[] = {
    {"closed_mm", &GloveParameters::closed_mm, 0, 500},
    {"open_mm", &GloveParameters::open_mm, 1, 500},
    {"grab_share", &GloveParameters::grab_share, 0.01, 0.98},
    {"release_share", &GloveParameters::release_share, 0.02, 0.99},
    {"readings", &GloveParameters::readings, 1, 20},
    {"motion_scale", &GloveParameters::motion_scale, 0.01, 100},
};
struct GloveVector {
  const char* name;
  Vec3 GloveParameters::*value;
};
constexpr GloveVector kGloveVector[] = {{"forefinger_tip_mm", &GloveParameters::forefinger_tip_mm},
                                        {"thumb_tip_mm", &GloveParameters::thumb_tip_mm},
                                        {"pointing", &GloveParameters::pointing}};
constexpr int kMostNodes = 12;  // of a distortion grid, each way

bool same(const GloveParameters& a, const GloveParameters& b) {
  for (const GloveField& f : kGlove)
    if (a.*f.value != b.*f.value) return false;
  for (const GloveVector& f : kGloveVector)
    if (a.*f.value != b.*f.value) return false;
  return true;
}

int line_of(const toml::node& n) { return int(n.source().begin.line); }

void only_keys(const toml::table& t, std::initializer_list<const char*> known, const char* where,
               const std::string& file) {
  for (const auto& [key, node] : t) {
    bool found = false;
    std::string list;
    for (const char* k : known) {
      found |= key.str() == k;
      list += (list.empty() ? "" : ", ") + std::string(k);
    }
    if (!found)
      throw InputError(
          file, line_of(node),
          std::string("unknown key \"") + std::string(key.str()) + "\" in " + where + "; expected " + list);
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
    throw InputError(file, line_of(n),
                     "\"" + key + "\" is not usable; expected a list of " + std::to_string(N) + " numbers");
  std::array<double, N> out{};
  for (size_t i = 0; i < N; ++i) out[i] = number(*a->get(i), key, -limit, limit, file);
  return out;
}

const toml::table* table(const toml::table& t, const char* key, const std::string& file) {
  const toml::node* n = t.get(key);
  if (!n) return nullptr;
  if (!n->is_table())
    throw InputError(file, line_of(*n), "\"" + std::string(key) + "\" is not usable; expected a table");
  return n->as_table();
}

/// The fewest decimals that read back to the same bits.
std::string shortest(double v) {
  char text[64];
  const bool plain = v == 0 || (std::abs(v) >= 1e-4 && std::abs(v) < 1e9);
  const auto end =
      std::to_chars(text, text + sizeof text, v, plain ? std::chars_format::fixed : std::chars_format::scientific);
  std::string s(text, end.ptr);
  if (s.find_first_of(".e") == std::string::npos) s += ".0";
  return s;
}

void read_glove(const toml::table& t, GloveParameters& g, const std::string& where, const std::string& file) {
  for (const auto& [key, node] : t) {
    bool known = false;
    for (const GloveField& f : kGlove)
      if (key.str() == f.name) known = true, g.*f.value = number(node, f.name, f.low, f.high, file);
    for (const GloveVector& f : kGloveVector)
      if (key.str() == f.name) {
        known = true;
        const auto v = numbers<3>(node, f.name, 1000, file);
        g.*f.value = Vec3(v[0], v[1], v[2]);
      }
    if (!known)
      throw InputError(
          file, line_of(node),
          "unknown key \"" + std::string(key.str()) + "\" in " + where + "; see calibration/identity.toml");
  }
  if (g.open_mm < g.closed_mm + 5 || g.release_share <= g.grab_share)
    throw InputError(
        file, 0,
        where + " is not usable: expected open_mm at least 5 above closed_mm, and release_share above grab_share");
  if (std::abs(g.pointing.norm() - 1) > 0.01)
    throw InputError(file, 0, "\"pointing\" is no direction; expected three numbers of unit length");
}

void read_distortion(const toml::table& t, DistortionGrid& d, const std::string& file) {
  only_keys(t, {"nodes", "low_mm", "high_mm", "add_mm"}, "[distortion]", file);
  const toml::node *nodes = t.get("nodes"), *low = t.get("low_mm"), *high = t.get("high_mm"), *add = t.get("add_mm");
  if (!nodes || !low || !high || !add)
    throw InputError(file, 0, "[distortion] is not whole; expected nodes, low_mm, high_mm and add_mm");
  const auto n = numbers<3>(*nodes, "nodes", kMostNodes, file), lo = numbers<3>(*low, "low_mm", 10'000, file),
             hi = numbers<3>(*high, "high_mm", 10'000, file);
  size_t count = 1;
  for (size_t i = 0; i < 3; ++i) {
    d.nodes[i] = int(n[i]);
    if (d.nodes[i] < 2 || n[i] != d.nodes[i] || !(hi[i] > lo[i]))
      throw InputError(file, line_of(*nodes),
                       "[distortion] is not usable; expected 2 to 12 nodes each way, and high_mm above low_mm");
    count *= size_t(d.nodes[i]);
  }
  d.low_mm = Vec3(lo[0], lo[1], lo[2]), d.high_mm = Vec3(hi[0], hi[1], hi[2]);
  const auto* a = add->as_array();
  if (!a || a->size() != 3 * count)
    throw InputError(file, line_of(*add),
                     "\"add_mm\" is not usable; expected a list of " + std::to_string(3 * count) + " numbers");
  d.add_mm.resize(count);
  for (size_t i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k) d.add_mm[i][k] = number(*a->get(3 * i + size_t(k)), "add_mm", -1000, 1000, file);
}

}  // namespace

Vec3 DistortionGrid::at(const Vec3& p) const {
  if (empty()) return Vec3::Zero();
  int at[3];
  double w[3];
  for (int i = 0; i < 3; ++i) {
    const int n = nodes[size_t(i)];
    const double s = std::min(std::max(0.0, (p[i] - low_mm[i]) / (high_mm[i] - low_mm[i])), 1.0) * (n - 1);
    at[i] = std::min(int(s), n - 2);
    w[i] = s - at[i];
  }
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 8; ++k) {
    double weight = 1;
    int node[3];
    for (int i = 0; i < 3; ++i) {
      const int up = k >> i & 1;
      node[i] = at[i] + up;
      weight *= up ? w[i] : 1 - w[i];
    }
    sum += weight * add_mm[size_t((node[2] * nodes[1] + node[1]) * nodes[0] + node[0])];
  }
  return sum;
}

Calibration parse_calibration(const std::string& text, const std::string& name) {
  toml::table t;
  try {
    t = toml::parse(text, name);
  } catch (const toml::parse_error& e) {
    throw InputError(name, int(e.source().begin.line),
                     std::string("is not TOML (") + std::string(e.description()) + "); expected a calibration file");
  } catch (const BrokenToml&) {
    throw InputError(name, 0, "is not TOML; expected a calibration file");
  }
  only_keys(t,
            {"limberg_calibration", "name", "device", "date", "stylus", "world", "filter", "glove", "other_glove",
             "distortion"},
            "a calibration", name);
  const auto version = t["limberg_calibration"].value<int64_t>();
  if (!version || *version != Calibration::kVersion)
    throw InputError(name, 0, "is not a calibration of a known version; expected limberg_calibration = 1");

  Calibration c;
  if (const toml::node* n = t.get("name")) {
    const auto s = n->value<std::string>();
    if (!s || s->size() > 200) throw InputError(name, line_of(*n), "\"name\" is not usable; expected a short text");
    c.name = *s;
  }
  for (const auto& [key, words] : {std::pair{"device", &c.device}, std::pair{"date", &c.date}})
    if (const toml::node* n = t.get(key)) {
      const auto s = n->value<std::string>();
      if (!s || s->size() > 200)
        throw InputError(name, line_of(*n), "\"" + std::string(key) + "\" is not usable; expected a short text");
      *words = *s;
    }
  constexpr double kFarMm = 10'000;
  if (const auto* g = table(t, "glove", name)) read_glove(*g, c.glove, "[glove]", name);
  if (const auto* g = table(t, "other_glove", name)) read_glove(*g, c.other_glove.emplace(), "[other_glove]", name);
  if (const auto* d = table(t, "distortion", name)) read_distortion(*d, c.distortion, name);
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
        throw InputError(name, line_of(*n),
                         "\"from_tracker_quat\" is not a rotation; expected w, x, y, z of unit length");
    }
  }
  if (const auto* f = table(t, "filter", name)) {
    for (const auto& [key, node] : *f) {
      const Field* field = nullptr;
      for (const Field& candidate : kFilter)
        if (key.str() == candidate.name) field = &candidate;
      if (!field)
        throw InputError(name, line_of(node),
                         "unknown key \"" + std::string(key.str()) + "\" in [filter]; see calibration/identity.toml");
      c.filter.*field->value = number(node, field->name, field->low, field->high, name);
    }
  }
  return c;
}

Calibration load_calibration(const std::string& path) {
  return parse_calibration(read_whole_file(path, 1'000'000, "a calibration: some lines of TOML"), path);
}

std::string to_toml(const Calibration& c) {
  const auto quoted = [](const std::string& text) {
    std::string q;
    for (char ch : text) {
      if (ch == '"' || ch == '\\') q += '\\';
      q += (unsigned char)ch < 0x20 || ch == 0x7F ? ' ' : ch;
    }
    return q;
  };
  auto list = [](const double* v, int n) {
    std::string s = "[";
    for (int i = 0; i < n; ++i) s += (i ? ", " : "") + shortest(v[i]);
    return s + "]";
  };
  std::string s =
      "limberg_calibration = " + std::to_string(Calibration::kVersion) + "\nname = \"" + quoted(c.name) + "\"\n";
  if (!c.device.empty()) s += "device = \"" + quoted(c.device) + "\"\n";
  if (!c.date.empty()) s += "date = \"" + quoted(c.date) + "\"\n";
  s += "\n[stylus]  # the tip in the frame of the sensor\ntip_offset_mm = " + list(c.tip_offset_mm.data(), 3) + "\n";
  s += "\n[world]  # pose of the tracker in the world; quaternion w, x, y, z\nfrom_tracker_mm = " +
       list(c.world_from_tracker_mm.data(), 3) + "\nfrom_tracker_quat = " + list(c.world_from_tracker_quat.data(), 4) +
       "\n";
  s += "\n[filter]  # see calibration.h\n";
  for (const Field& f : kFilter) s += std::string(f.name) + " = " + shortest(c.filter.*f.value) + "\n";
  const auto write_glove = [&](const char* where, const GloveParameters& g) {
    s += std::string("\n") + where + "  # see calibration.h\n";
    for (const GloveField& f : kGlove) s += std::string(f.name) + " = " + shortest(g.*f.value) + "\n";
    for (const GloveVector& f : kGloveVector) s += std::string(f.name) + " = " + list((g.*f.value).data(), 3) + "\n";
  };
  if (!same(c.glove, GloveParameters{})) write_glove("[glove]", c.glove);
  if (c.other_glove) write_glove("[other_glove]", *c.other_glove);
  if (!c.distortion.empty()) {
    const DistortionGrid& d = c.distortion;
    s += "\n[distortion]  # added to positions in the tracker's frame; x fastest\nnodes = [" +
         std::to_string(d.nodes[0]) + ", " + std::to_string(d.nodes[1]) + ", " + std::to_string(d.nodes[2]) +
         "]\nlow_mm = " + list(d.low_mm.data(), 3) + "\nhigh_mm = " + list(d.high_mm.data(), 3) + "\nadd_mm = [\n";
    for (const Vec3& v : d.add_mm)
      s += "  " + shortest(v.x()) + ", " + shortest(v.y()) + ", " + shortest(v.z()) + ",\n";
    s += "]\n";
  }
  return s;
}

void save_calibration(const Calibration& c, const std::string& path) {
  const std::string part = path + ".part", text = to_toml(c);
  std::FILE* f = std::fopen(part.c_str(), "wb");
  if (!f)
    throw InputError(path, 0,
                     std::string("cannot be written (") + std::strerror(errno) + "); expected a writable place");
  bool ok = std::fwrite(text.data(), 1, text.size(), f) == text.size();
  ok = std::fclose(f) == 0 && ok;
  if (!ok || std::rename(part.c_str(), path.c_str()) != 0) {
    const int why = errno;
    std::remove(part.c_str());
    throw InputError(path, 0,
                     std::string("cannot be written (") + std::strerror(why) + "); what was there before is unchanged");
  }
}

uint64_t calibration_hash(const Calibration& c) {
  Hash64 h;
  h.add(int32_t(Calibration::kVersion));
  for (int i = 0; i < 3; ++i) h.add(c.tip_offset_mm[i]);
  for (int i = 0; i < 3; ++i) h.add(c.world_from_tracker_mm[i]);
  for (double v : c.world_from_tracker_quat) h.add(v);
  for (const Field& f : kFilter) h.add(c.filter.*f.value);
  // What a calibration does not have leaves its hash as it was before there was such a thing.
  const auto add_glove = [&](const GloveParameters& g) {
    for (const GloveField& f : kGlove) h.add(g.*f.value);
    for (const GloveVector& f : kGloveVector)
      for (int i = 0; i < 3; ++i) h.add((g.*f.value)[i]);
  };
  if (!same(c.glove, GloveParameters{})) add_glove(c.glove);
  if (c.other_glove) h.add(int32_t(2)), add_glove(*c.other_glove);
  if (!c.distortion.empty()) {
    for (const int n : c.distortion.nodes) h.add(int32_t(n));
    for (int i = 0; i < 3; ++i) h.add(c.distortion.low_mm[i]), h.add(c.distortion.high_mm[i]);
    for (const Vec3& v : c.distortion.add_mm)
      for (int i = 0; i < 3; ++i) h.add(v[i]);
  }
  return h.value();
}

}  // namespace limberg
