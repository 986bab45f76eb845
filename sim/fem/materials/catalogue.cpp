#include "sim/fem/materials/catalogue.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/materials/limited.h"
#include "sim/fem/materials/muscle.h"

namespace limberg {
namespace {

std::string text(double v) {
  std::ostringstream s;
  s << v;
  return s.str();
}

/// Complete, in range, nothing unknown.
void check(const LawSpec& spec, const LawCatalogue::Entry& e) {
  const auto fail = [&](const std::string& what) { throw InputError("", 0, "law " + e.name + ": " + what); };
  for (const auto& given : spec.constants)
    if (std::none_of(e.constants.begin(), e.constants.end(), [&](const auto& c) { return c.key == given.key; }))
      fail("unknown constant " + given.key);
  for (const auto& c : e.constants) {
    const auto at =
        std::find_if(spec.constants.begin(), spec.constants.end(), [&](const auto& g) { return g.key == c.key; });
    if (at == spec.constants.end()) {
      if (c.required) fail(c.key + " is missing");
      continue;
    }
    if (at->value.empty() || int(at->value.size()) > c.most_values)
      fail(c.key + " holds " + std::to_string(at->value.size()) + " numbers; expected 1 to " +
           std::to_string(c.most_values));
    for (double v : at->value)
      if (!std::isfinite(v) || v < c.least || v > c.most || (c.above && v == c.least))
        fail(c.key + " is " + text(v) + "; expected a number " + (c.above ? "above " : "from ") + text(c.least) +
             " to " + text(c.most));
  }
}

// Constants of an isotropic law at rest: shear modulus, s and W_12 of the header.
struct AtRest {
  double mu_kPa, s_kPa, W12_kPa;
};

bool is_isotropic(const Mat9& C) {
  const double spread = std::max({std::fabs(C(0, 0) - C(4, 4)), std::fabs(C(4, 4) - C(8, 8)),
                                  std::fabs(C(0, 4) - C(4, 8)), std::fabs(C(4, 8) - C(0, 8))});
  return spread <= 1e-6 * std::fabs(C(0, 0));
}

// A law without stress at rest whose sides press each other (W_12 > 0) holds its volume: lambda of its own is W_12. A
// law of shape alone has W_12 <= 0 there, or leaves its pressure to the cell (s > 0).
void check_volume(const std::string& name, bool complete, bool isotropic, const AtRest& c, double poisson) {
  constexpr double rounding = 1e-6;
  constexpr double poisson_as_written = 5e-4;  // a ratio given with three digits
  const bool at_rest = isotropic && std::fabs(c.s_kPa) <= rounding * c.mu_kPa;
  const double own = c.W12_kPa / (2 * (c.W12_kPa + c.mu_kPa));
  if (complete && !at_rest)
    throw InputError("", 0, "law " + name + " is said to be complete, and is not isotropic and free of stress at rest");
  if (complete && !(std::fabs(own - poisson) <= poisson_as_written))
    throw InputError("", 0,
                     "law " + name + " holds its volume by itself, with a Poisson's ratio of " + text(own) +
                         "; expected poisson = " + text(own) + ", not " + text(poisson));
  if (!complete && at_rest && c.W12_kPa > rounding * c.mu_kPa)
    throw InputError("", 0,
                     "law " + name + " resists change of volume by itself (lambda " + text(c.W12_kPa) +
                         " kPa), which the cell would add to; expected an entry that says it is complete, or an energy "
                         "of shape alone");
}

LayerLaw skin_fibres(const LawCatalogue::Values& v) {
  const double a = v.number("fibre_angle_deg") * std::numbers::pi / 180, c = elementary::cos(a), s = elementary::sin(a);
  std::vector<FibreFamily> families{{{c, s, 0}}};
  if (std::fabs(c * s) > 1e-9) families.push_back({{c, -s, 0}});  // at 0 and 90 degrees both are the same
  return {v.number("mu_kPa"),
          dispersed_fibres({v.number("k1_kPa"), v.number("k2"), v.number("kappa")}, std::move(families)), 1};
}

LayerLaw muscle_fibres(const LawCatalogue::Values& v) {
  std::vector<LawPtr> parts{dispersed_fibres({v.number("k1_kPa"), v.number("k2"), 0}, {{Vec3::UnitX()}})};
  if (const double pull = v.number("active_kPa"), activation = v.number("activation"); pull * activation > 0)
    parts.push_back(active_fibres(pull, activation, Vec3::UnitX()));
  return {v.number("mu_kPa"), parts.size() == 1 ? parts[0] : sum_of(std::move(parts)), 1};
}

LayerLaw ogden_terms(const LawCatalogue::Values& v) {
  const std::vector<double> mu = v.list("mu_kPa"), alpha = v.list("alpha");
  if (mu.size() != alpha.size())
    throw InputError("", 0, "law ogden: mu_kPa and alpha differ in length; expected one pair per term");
  std::vector<OgdenTerm> terms;
  for (size_t i = 0; i < mu.size(); ++i) terms.push_back({mu[i], alpha[i]});
  return {0, ogden(std::move(terms)), 8};
}

LayerLaw limited_matrix(const LawCatalogue::Values& v) {
  return {v.number("mu_kPa"),
          stretch_limits(v.number("stretch_least"), v.number("stretch_most"), v.number("limit_kPa")), 8};
}

LawCatalogue make_shipped() {
  constexpr double stiffest = 1e8;  // kPa; above any tissue
  const LawCatalogue::Constant mu{"mu_kPa", 0, stiffest, true};
  LawCatalogue c;
  c.add({kDefaultLaw,
         "mu/2 (|F|^2 - 3) with mu of young_kPa and poisson (Smith, de Goes, Kim 2018, without the logarithm); all in "
         "constants of the cell",
         {},
         [](const LawCatalogue::Values&) { return LayerLaw{}; }});
  c.add({"gasser-ogden-holzapfel",
         "matrix mu/2 (|F|^2 - 3) and dispersed fibres k1/(2 k2)(exp(k2 E^2) - 1) that only pull, two families at +- "
         "fibre_angle_deg from the tension lines (Gasser, Ogden, Holzapfel 2006)",
         {mu,
          {"k1_kPa", 0, stiffest, true},
          {"k2", 0, 1e3, true},
          {"kappa", 0, 1.0 / 3},
          {"fibre_angle_deg", 0, 90, false, false, 0}},
         skin_fibres});
  c.add({"muscle",
         "matrix mu/2 (|F|^2 - 3) and fibres along the direction: passive k1/(2 k2)(exp(k2 E^2) - 1) that only pull "
         "(Holzapfel, Gasser, Ogden 2000), and activation times active_kPa (1 - ((l - 1)/.56)^2) at a length l (van "
         "Soest, Bobbert 1993)",
         {mu,
          {"k1_kPa", 0, stiffest, true},
          {"k2", 0, 1e3, true},
          {"active_kPa", 0, 1e4, false, false, 0},
          {"activation", 0, 1, false, false, 0}},
         muscle_fibres});
  c.add({"ogden",
         "sum mu_p/alpha_p (s1^alpha_p + s2^alpha_p + s3^alpha_p - 3); shear modulus sum mu_p alpha_p / 2 (Ogden 1972)",
         {{"mu_kPa", -stiffest, stiffest, false, true, 0, 6}, {"alpha", -100, 100, false, true, 0, 6}},
         ogden_terms});
  c.add({"mooney-rivlin",
         "c10 (I1 - 3) + c01 (I2 - 3); shear modulus 2 (c10 + c01) (Mooney 1940)",
         {{"c10_kPa", 0, stiffest}, {"c01_kPa", 0, stiffest}},
         [](const LawCatalogue::Values& v) {
           return LayerLaw{0, mooney_rivlin(v.number("c10_kPa"), v.number("c01_kPa")), 8};
         }});
  c.add({"strain-limited",
         "matrix mu/2 (|F|^2 - 3) and, beyond stretch_least and stretch_most, limit_kPa/2 times the square of what a "
         "principal stretch lies beyond: tissue that gives up to a length and then hardly",
         {mu,
          {"stretch_least", 0, 1, true, false, 0.5},
          {"stretch_most", 1, 100, true, false, 1.5},
          {"limit_kPa", 0, 1e5, true, false, 1000}},
         limited_matrix});
  c.add({"corotated",
         "mu |F - R|^2: linear in the rotated frame; for comparison",
         {mu},
         [](const LawCatalogue::Values& v) {
           return LayerLaw{0, corotated(v.number("mu_kPa")), 8};
         }});
  c.add({"saint-venant-kirchhoff",
         "mu |(F^T F - I)/2|^2: softens when pressed; for comparison",
         {mu},
         [](const LawCatalogue::Values& v) {
           return LayerLaw{0, st_venant_kirchhoff(v.number("mu_kPa")), 8};
         }});
  return c;
}

}  // namespace

double LawCatalogue::Values::number(const char* key) const { return list(key).front(); }

std::vector<double> LawCatalogue::Values::list(const char* key) const {
  for (const auto& g : spec_.constants)
    if (g.key == key) return g.value;
  for (const auto& c : known_)
    if (c.key == key && !c.required) return {c.otherwise};
  throw InputError("", 0, std::string("constant ") + key + " is missing");
}

LawCatalogue& LawCatalogue::add(Entry e) {
  if (e.name.empty() || find(e.name))
    throw InputError("", 0, "a law named \"" + e.name + "\" cannot be added; expected a name of its own");
  entries_.push_back(std::move(e));
  return *this;
}

const LawCatalogue::Entry* LawCatalogue::find(const std::string& name) const {
  for (const Entry& e : entries_)
    if (e.name == name) return &e;
  return nullptr;
}

std::string LawCatalogue::names() const {
  std::string s;
  for (const Entry& e : entries_) s += (s.empty() ? "" : ", ") + e.name;
  return s;
}

std::shared_ptr<const LawCatalogue> shipped_laws() {
  static const auto laws = std::make_shared<const LawCatalogue>(make_shipped());
  return laws;
}

LayerResponse layer_response(const Material& m, const LawCatalogue* laws) {
  LayerResponse r;
  if (m.law.name.empty() || m.law.name == kDefaultLaw) {
    r.matrix_mu_kPa = r.mu_kPa = m.mu_kPa();
    r.lambda_kPa = m.lambda_kPa() + m.mu_kPa();
    r.whole = neo_hookean(r.mu_kPa);
    return r;
  }
  const LawCatalogue& known = laws ? *laws : *shipped_laws();
  const LawCatalogue::Entry* e = known.find(m.law.name);
  if (!e) throw InputError("", 0, "no law is named \"" + m.law.name + "\"; expected one of " + known.names());
  check(m.law, *e);
  const LayerLaw l = e->make({m.law, e->constants});
  if (!(l.matrix_mu_kPa >= 0) || (l.points_per_part != 1 && l.points_per_part != 8) ||
      (l.matrix_mu_kPa == 0 && !l.points))
    throw InputError("", 0,
                     "law " + e->name + " makes no use of its layer; expected a matrix or a law at 1 or 8 points");
  r.matrix_mu_kPa = l.matrix_mu_kPa, r.points = l.points, r.points_per_part = l.points_per_part;
  const LawPtr matrix = l.matrix_mu_kPa > 0 ? neo_hookean(l.matrix_mu_kPa) : nullptr;
  r.whole = !matrix ? l.points : !l.points ? matrix : sum_of({matrix, l.points});
  const LawPtr isotropic = matrix ? matrix : l.points;
  const Mat3 I = Mat3::Identity();
  const Mat9 C = isotropic->tangent_kPa(I, false);
  const double s = isotropic->at(I).P_kPa.trace() / 3, W11 = (C(0, 0) + C(4, 4) + C(8, 8)) / 3,
               W12 = (C(0, 4) + C(4, 8) + C(0, 8)) / 3;
  r.mu_kPa = 0.5 * (W11 - W12 + s);
  r.lambda_kPa = 2 * r.mu_kPa * m.poisson / (1 - 2 * m.poisson) + s - W12;
  if (!(r.mu_kPa > 0) || !std::isfinite(r.mu_kPa))
    throw InputError("", 0,
                     "law " + e->name + " has no stiffness at rest; expected constants whose shear modulus is above 0");
  check_volume(e->name, l.complete, is_isotropic(C), {r.mu_kPa, s, W12}, m.poisson);
  if (l.complete) r.lambda_kPa = 0;
  if (!(r.lambda_kPa > 0) && !l.complete)
    throw InputError("", 0,
                     "law " + e->name + " does not hold its volume with a Poisson's ratio of " + text(m.poisson) +
                         "; expected a larger one");
  if (l.points) {  // does a turn about the skin's normal change anything?
    const Mat3 F = Vec3(1.2, 0.9, 1).asDiagonal(), G = Vec3(0.9, 1.2, 1).asDiagonal();
    r.directed = std::fabs(l.points->at(F).energy_kPa - l.points->at(G).energy_kPa) >
                     1e-9 * (std::fabs(l.points->at(F).energy_kPa) + 1e-12) ||
                 l.points_per_part == 1;
  }
  return r;
}

double rest_pressure_kPa(const LayerResponse& r, const Mat3& M, const Vec3& n) {
  double p = r.matrix_mu_kPa * (M.transpose() * n).squaredNorm();
  if (r.points) p += n.dot(r.points->at(M).P_kPa * M.transpose() * n);
  return p;
}

}  // namespace limberg
