#include "app/scene/scene_layers.h"

#include <limits>

namespace limberg {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kStiffest_kPa = 1e8;

void need(Table& t, const char* key, double known, const char* all) {
  if (!t.has(key) && std::isnan(known)) t.fail(key, std::string("is missing; expected ") + all);
}

void read_constants(Table& t, Material& m, const LawCatalogue::Entry& law) {
  std::string all;
  for (const auto& c : law.constants) all += (all.empty() ? "" : ", ") + c.key + (c.required ? "" : " (optional)");
  for (const auto& c : law.constants) {
    const auto at =
        std::find_if(m.law.constants.begin(), m.law.constants.end(), [&](const auto& k) { return k.key == c.key; });
    const bool known = at != m.law.constants.end();
    if (c.required && !known && !t.has(c.key.c_str()))
      t.fail(c.key.c_str(), "is missing; law " + law.name + " expected " + all);
    std::vector<double> value;
    t.numbers(c.key.c_str(), value, c.least, c.most, c.above, c.most_values);
    if (value.empty()) continue;
    if (known)
      at->value = std::move(value);
    else
      m.law.constants.push_back({c.key, std::move(value)});
  }
}

}  // namespace

Material unknown_material() {
  Material m;
  m.young_kPa = m.poisson = kUnknown;
  return m;
}

void read_material(Table& t, Material& m, const LawCatalogue& laws) {
  std::string law;
  t.text("law", law, 60);
  if (!law.empty()) {
    if (!laws.find(law)) t.fail("law", "is \"" + law + "\", which is no law; expected one of " + laws.names());
    const bool same = law == m.law.name || (law == kDefaultLaw && m.law.name.empty());
    if (!same) m.law = {law, {}}, m.young_kPa = kUnknown;
  }
  const bool plain = m.law.name.empty() || m.law.name == kDefaultLaw;
  const char* all = plain ? "name, thickness_mm, young_kPa and poisson (or a tissue that gives them)"
                          : "name, thickness_mm, poisson and the constants of the law";
  if (plain) {
    need(t, "young_kPa", m.young_kPa, all);
    t.real("young_kPa", m.young_kPa, 0, kStiffest_kPa, true);
    m.law = {};
  }
  need(t, "poisson", m.poisson, all);
  t.real("poisson", m.poisson, 0, 0.499);
  double density = m.density_kg_mm3 * 1e9;
  if (t.has("density_kg_m3"))
    t.real("density_kg_m3", density, 1, 1e5), m.density_kg_mm3 = density * 1e-9;
  else
    t.real("density_kg_m3", density, 1, 1e5);
  t.real("prestretch_along", m.prestretch_along, 0.8, 1.5);
  t.real("prestretch_across", m.prestretch_across, 0.8, 1.5);
  constexpr const char* prony = "[[share, time_s], ...], shares above 0 that sum to less than 1, times above 0";
  std::vector<std::pair<double, double>> terms;
  for (const PronyTerm& p : m.prony) terms.push_back({p.share, p.time_s});
  t.pairs("prony", terms, prony);
  m.prony.clear();
  double shares = 0;
  for (auto [share, time] : terms) {
    if (!(share > 0) || !(time > 0))
      t.fail("prony", std::string("holds a share or a time that is not above 0; expected ") + prony);
    shares += share;
    m.prony.push_back({share, time});
  }
  if (!(shares < 1)) t.fail("prony", "has shares that sum to " + number(shares) + std::string("; expected ") + prony);
  if (plain) return;
  read_constants(t, m, *laws.find(m.law.name));
  try {
    m.young_kPa = 2 * (1 + m.poisson) * layer_response(m, &laws).mu_kPa;
  } catch (const InputError& e) {
    t.fail("law", std::string("cannot be made: ") + e.what());
  }
}

const NamedTissue* named_tissue(Table& t, const std::function<const TissueLibrary&(Table&)>& library) {
  std::string tissue;
  t.text("tissue", tissue, 60);
  if (tissue.empty()) return nullptr;
  const TissueLibrary& from = library(t);
  const NamedTissue* found = from.find(tissue);
  if (!found)
    t.fail("tissue", "is \"" + tissue + "\", which " + from.path + " does not hold; expected one of " + from.names());
  return found;
}

namespace {

constexpr size_t kMostPlaces = 1000;

ThicknessSpec read_thickness(Table& t) {
  ThicknessSpec out;
  t.path("thickness_file", out.file);
  t.path("down_to", out.down_to);
  const std::string expected = "; expected a list of 1 to " + std::to_string(kMostPlaces) +
                               " places [x, y, z, thickness], all in mm, the thickness from 0.1 to 100";
  for (const auto& [x, y, z, thick] : t.rows<4>("thickness_points", 1, kMostPlaces, "place", expected)) {
    if (!(thick >= ThicknessLimits::least_mm && thick <= ThicknessLimits::most_mm))
      t.fail("thickness_points", "holds a thickness of " + number(thick) + " mm" + expected);
    out.points.push_back({{x, y, z}, thick});
  }
  const int given = int(!out.points.empty()) + int(!out.file.empty()) + int(!out.down_to.empty());
  if (given > 1)
    t.fail(out.file.empty() ? "down_to" : "thickness_file",
           "is given beside another thickness by place; expected one of thickness_points, thickness_file, down_to");
  if (!out.down_to.empty()) t.real("scale_to_mm", out.scale_to_mm, 0, 1e6, true);
  return out;
}

}  // namespace

SceneLayers read_layers(const toml::table& root, const std::string& file, const LawCatalogue& laws,
                        const std::function<const TissueLibrary&(Table&)>& library) {
  const toml::node* n = root.get("layer");
  const toml::array* a = n ? n->as_array() : nullptr;
  if (!a || a->empty())
    throw InputError(file, n ? int(n->source().begin.line) : 0, "no layers; expected at least one [[layer]]");
  if (a->size() > 16) throw InputError(file, int(n->source().begin.line), "more than 16 layers; expected at most 16");
  SceneLayers out;
  for (const toml::node& e : *a) {
    if (!e.is_table()) throw InputError(file, int(e.source().begin.line), "a layer is not a table; expected [[layer]]");
    Table t(e.as_table(), "layer", file);
    Layer l;
    l.material = unknown_material();
    l.thickness_mm = kUnknown;
    if (const NamedTissue* tissue = named_tissue(t, library)) {
      l.material = tissue->material;
      if (tissue->thickness_mm > 0) l.thickness_mm = tissue->thickness_mm;
      l.name = tissue->name;
      l.material.tissue = tissue->name;
    }
    if (!t.has("name") && l.name.empty())
      t.fail("name", "is missing; expected name, thickness_mm, young_kPa and poisson in every layer");
    t.text("name", l.name, 40);
    need(t, "thickness_mm", l.thickness_mm, "name, thickness_mm, young_kPa and poisson in every layer");
    t.real("thickness_mm", l.thickness_mm, 0, 1000, true);
    out.thickness.push_back(read_thickness(t)), out.line.push_back(int(e.source().begin.line));
    if (out.thickness.back().given() && out.layers.size() + 1 == a->size())
      t.fail("name",
             "is that of the last layer, which reaches down to the bottom; expected no thickness by place there");
    read_material(t, l.material, laws);
    t.finish();
    out.layers.push_back(std::move(l));
  }
  return out;
}

void add_thickness(const Scene& scene, Body& body) {
  for (size_t l = 0; l < scene.thickness.size(); ++l) try {
      if (!scene.thickness[l].given()) continue;
      body.thickness_mm.resize(l + 1);
      body.thickness_mm[l] = thickness_of(scene.thickness[l], body, l);
    } catch (const InputError& e) {
      if (!e.file().empty()) throw;
      throw InputError(scene.path, scene.layer_line[l], e.what());
    }
}

}  // namespace limberg
