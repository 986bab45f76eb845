#include "tests/bench/fuzz/case.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/base/error.h"

namespace limberg::fuzz {

namespace {

using Json = nlohmann::json;
constexpr const char* kKinds[] = {"cut", "excise", "undo", "redo", "replay", "fault"};

Json json_of(const Op& op) {
  Json j{{"kind", kKinds[op.kind]}};
  if (!op.name.empty()) j["name"] = op.name;
  if (op.kind == Op::cut || op.kind == Op::fault) {
    j["seed"] = op.seed;
    Json& v = j["vertex"] = Json::array();
    for (const Int3& p : op.vertex) v.push_back({p.x, p.y, p.z});
    Json& t = j["tri"] = Json::array();
    for (const Tri& x : op.tri) t.push_back({x[0], x[1], x[2]});
    j["seeds"] = op.seed_of_tri;
    for (size_t i = 0; i < op.shared.size(); ++i)
      if (op.shared[i].first >= 0) j["shared"].push_back({i, op.shared[i].first, op.shared[i].second});
    if (op.sweep_mm3 >= 0) j["sweep_mm3"] = op.sweep_mm3;
  }
  if (op.kind == Op::excise) j["which"] = op.which;
  if (op.kind == Op::replay) j["cell_mm"] = op.cell_mm;
  if (op.kind == Op::fault)
    j["fault"] = {{"place", op.place}, {"thrown", op.thrown}, {"lasting", op.lasting}, {"in_lattice", op.in_lattice}};
  return j;
}

Op op_of(const Json& j) {
  Op op;
  const std::string kind = j.at("kind");
  size_t k = 0;
  while (k < std::size(kKinds) && kind != kKinds[k]) ++k;
  if (k == std::size(kKinds)) throw std::runtime_error("an operation of unknown kind \"" + kind + "\"");
  op.kind = Op::Kind(k);
  op.name = j.value("name", "");
  op.seed = j.value("seed", uint64_t(0));
  if (j.contains("vertex"))
    for (const Json& p : j["vertex"]) op.vertex.push_back({p.at(0), p.at(1), p.at(2)});
  if (j.contains("tri"))
    for (const Json& t : j["tri"]) op.tri.push_back({t.at(0), t.at(1), t.at(2)});
  if (j.contains("seeds")) op.seed_of_tri = j["seeds"].get<std::vector<uint8_t>>();
  op.shared.assign(op.vertex.size(), {-1, -1});
  if (j.contains("shared"))
    for (const Json& s : j["shared"]) op.shared.at(s.at(0)) = {s.at(1), s.at(2)};
  op.sweep_mm3 = j.value("sweep_mm3", -1.0);
  op.which = j.value("which", 0);
  op.cell_mm = j.value("cell_mm", 0.0);
  if (j.contains("fault")) {
    const Json& f = j["fault"];
    op.place = f.at("place");
    op.thrown = f.at("thrown");
    op.lasting = f.at("lasting");
    op.in_lattice = f.at("in_lattice");
  }
  return op;
}

}  // namespace

TriMesh make_body(const BodySpec& spec) {
  TriMesh m;
  const RestGrid g;
  const int n = spec.columns + 1;
  const double step = spec.size_mm / spec.columns;
  for (int layer = 0; layer < 2; ++layer)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const double x = i * step - spec.size_mm / 2, y = j * step - spec.size_mm / 2;
        const double top = spec.wave_mm * std::sin(0.31 * x + 0.2) * std::cos(0.27 * y - 0.4);
        m.X_mm.push_back(g.to_mm(g.to_grid({x, y, layer ? -spec.thickness_mm : top})));
      }
  const auto id = [n](int layer, int i, int j) { return int32_t((layer * n + j) * n + i); };
  const auto quad = [&](int32_t a, int32_t b, int32_t c, int32_t d, bool turned, SurfaceTag tag) {
    const std::array<Tri, 2> two =
        turned ? std::array<Tri, 2>{Tri{a, b, d}, Tri{b, c, d}} : std::array<Tri, 2>{Tri{a, b, c}, Tri{a, c, d}};
    for (const Tri& t : two) m.tri.push_back(t), m.tag.push_back(tag), m.uv.push_back({});
  };
  const SurfaceTag side = spec.loose ? SurfaceTag::free : SurfaceTag::fixed;
  const int c = spec.columns;
  for (int j = 0; j < c; ++j)
    for (int i = 0; i < c; ++i) {
      quad(id(0, i, j), id(0, i + 1, j), id(0, i + 1, j + 1), id(0, i, j + 1), (i + j) % 2, SurfaceTag::skin);
      quad(id(1, i, j), id(1, i, j + 1), id(1, i + 1, j + 1), id(1, i + 1, j), j % 2, SurfaceTag::fixed);
    }
  for (int i = 0; i < c; ++i) {  // seen from outside: top left, bottom left, bottom right, top right
    quad(id(0, i, 0), id(1, i, 0), id(1, i + 1, 0), id(0, i + 1, 0), false, side);
    quad(id(0, i + 1, c), id(1, i + 1, c), id(1, i, c), id(0, i, c), true, side);
    quad(id(0, 0, i + 1), id(1, 0, i + 1), id(1, 0, i), id(0, 0, i), false, side);
    quad(id(0, c, i), id(1, c, i), id(1, c, i + 1), id(0, c, i + 1), true, side);
  }
  return m;
}

LatticeGrid make_lattice(const Case& c, double cell_mm) {
  LatticeGrid g;
  const double u = g.rest.half_unit_mm();
  // The pitch of the case's own cells is a multiple of four, so
  // that half of it is still even; of more if they will be divided.
  const int32_t unit = c.front_levels ? 2 << kLevels : 4, base = unit * int32_t(std::lround(c.cell_mm / u / unit));
  const int32_t pitch = cell_mm == c.cell_mm       ? base
                        : cell_mm == c.cell_mm / 2 ? base / 2
                                                   : 2 * int32_t(std::lround(cell_mm / u / 2));
  const auto odd = [&](double mm) { return 2 * int32_t(std::floor(mm / u / 2)) - 1; };
  const double low = -c.body.size_mm / 2 - c.lattice_shift * c.cell_mm;
  g.origin = {odd(low), odd(low), odd(-c.body.thickness_mm - c.lattice_shift * c.cell_mm)};
  g.pitch = {pitch, pitch, pitch};
  const auto count = [&](double top, int32_t origin) { return int32_t(std::floor((top / u - origin) / pitch)) + 1; };
  g.count = {count(c.body.size_mm / 2, g.origin.x), count(c.body.size_mm / 2, g.origin.y),
             count(c.body.wave_mm, g.origin.z)};
  return g;
}

std::string to_json(const Case& c) {
  Json j;
  j["body"] = {{"size_mm", c.body.size_mm},
               {"thickness_mm", c.body.thickness_mm},
               {"wave_mm", c.body.wave_mm},
               {"columns", c.body.columns},
               {"loose", c.body.loose}};
  j["cell_mm"] = c.cell_mm;
  j["lattice_shift"] = c.lattice_shift;
  if (c.front_levels) j["front_levels"] = c.front_levels;
  j["violation"] = c.violation;
  j["ops"] = Json::array();
  for (const Op& op : c.ops) j["ops"].push_back(json_of(op));
  return j.dump();
}

Case case_from_json(const std::string& text, const std::string& file) {
  try {
    const Json j = Json::parse(text);
    Case c;
    const Json& b = j.at("body");
    c.body.size_mm = b.at("size_mm");
    c.body.thickness_mm = b.at("thickness_mm");
    c.body.wave_mm = b.at("wave_mm");
    c.body.columns = b.at("columns");
    c.body.loose = b.value("loose", false);
    c.cell_mm = j.at("cell_mm");
    c.lattice_shift = j.at("lattice_shift");
    c.front_levels = j.value("front_levels", 0);
    c.violation = j.value("violation", "");
    for (const Json& op : j.at("ops")) c.ops.push_back(op_of(op));
    return c;
  } catch (const std::exception& e) {
    throw InputError(file, 0, std::string(e.what()) + "; expected a fuzz case");
  }
}

Case read_case(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file, 0, "cannot be read");
  std::ostringstream text;
  text << in.rdbuf();
  return case_from_json(text.str(), file);
}

void write_case(const Case& c, const std::string& file) {
  std::ofstream out(file);
  out << to_json(c) << '\n';
  if (!out.flush()) throw InputError(file, 0, "cannot be written");
}

}  // namespace limberg::fuzz
