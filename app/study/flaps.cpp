// Families of whole operations: Z-plasties by angle, rhomboid flaps by shape, fusiform excisions by ratio.
//
// Every member is a procedure of the repertoire (sim/tools/procedures) laid on a flat patch of skin and carried out to rest.
// The body is the gape study's: 1.5 mm of skin at 60 kPa on 8.5 mm of fat at 15 kPa that carries 0.8 of the skin's
// prestretch; sides and base are held. Lengths are those of the prestretched skin, so an elongation is already divided by
// the prestretch.
#include "app/study/flaps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/metrics.h"
#include "app/operation.h"
#include "app/study/wound.h"
#include "sim/measure/skin_shape.h"
#include "sim/measure/skin_strain.h"
#include "sim/tools/procedures/catalogue.h"
#include "sim/tools/procedures/operation.h"

namespace limberg::study {

namespace {

constexpr double kBlock_mm = 10, kSkinCell_mm = 1.2, kDeg = 180 / std::numbers::pi;

/// An operation done: the patient's figures and what it looks like.
struct Done {
  Metrics metrics;
  std::shared_ptr<Snapshot> shown = std::make_shared<Snapshot>();
  std::shared_ptr<const Skin> skin;
  double residual = 0, solve_ms = 0, energy_uJ = 0;
  size_t nodes = 0;

  /// Highest skin above the flat within `radius` of a chart point.
  double height_mm(const ChartPoint& p, double radius) const {
    const Vec3 at = skin->body().chart_origin_mm + p.x() * skin->body().chart_e1 + p.y() * skin->body().chart_e2;
    return dog_ear(shown->topology->view, shown->x_mm, *skin, std::array<Vec3, 1>{at}, radius).height_mm;
  }
};

struct Patch {
  double side_mm = 120, prestretch_percent = 10, cell_mm = 4, undermine_mm = 12;
};

Done carry_out_on(const Patch& patch, const Figure& figure, const Run& with) {
  BlockSpec b;
  b.name = "patch";
  b.size_mm = {patch.side_mm, patch.side_mm, kBlock_mm};
  b.skin_cell_mm = kSkinCell_mm;
  b.tension_direction = {0, 1, 0};
  b.layers = skin_on_fat(kBlock_mm, patch.prestretch_percent);
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = patch.cell_mm;
  Done done;
  done.skin = std::make_shared<Skin>(spec.body);
  World world(spec, with.workers);

  OperationPlan plan;
  plan.undermine_margin_mm = patch.undermine_mm;
  Script script;
  script.name = "study";
  std::vector<Command> commands = carry_out(figure, OnSkin(*done.skin, {}), plan);
  for (Command& c : commands) script.lines.push_back({int(script.lines.size()) + 1, c});
  OperationSettings set;
  set.interrupted = with.interrupted;
  const OperationOutcome o = operate(world, kBlock_mm, script, set);
  world.fill(*done.shown, true);
  done.metrics = measure_world(world, commands);
  done.residual = o.last.residual, done.solve_ms = o.solve_ms, done.energy_uJ = o.last.energy_uJ;
  done.nodes = world.solver().model().X_mm.size();
  return done;
}

void add_common(Row& r, const Done& d) {
  r.figures.insert(r.figures.end(), {{"closure_force_N", d.metrics.closure_force_N}, {"suture_force_max_N", d.metrics.suture_force_max_N},
                                     {"gap_max_mm", d.metrics.suture_gap_max_mm}, {"stretch_p99", d.metrics.stretch_p99},
                                     {"residual", d.residual}, {"nodes", double(d.nodes)}, {"solve_ms", d.solve_ms}});
  r.shown = d.shown;
}

// Rows that differ in nothing but `key`, in its order: the families' groups.
std::vector<std::vector<const Row*>> groups(const std::vector<Row>& rows, const std::string& key, const std::vector<std::string>& parameters) {
  std::vector<std::vector<const Row*>> out;
  for (const Row& r : rows) {
    auto same = [&](const std::vector<const Row*>& g) {
      return std::all_of(parameters.begin(), parameters.end(), [&](const std::string& p) { return p == key || g[0]->at(p) == r.at(p); });
    };
    auto it = std::find_if(out.begin(), out.end(), same);
    if (it == out.end()) it = out.emplace(it);
    it->push_back(&r);
  }
  for (auto& g : out) std::sort(g.begin(), g.end(), [&](const Row* a, const Row* b) { return a->at(key) < b->at(key); });
  return out;
}

NamedChart chart(const std::string& name, const std::string& title, const std::vector<Row>& rows, const std::string& x, const std::string& x_title,
                 const std::string& y, const std::string& y_title, const std::vector<std::string>& parameters) {
  NamedChart c;
  c.name = name, c.title = title;
  c.chart.description = title + ", one line for each setting";
  c.chart.x.title = x_title, c.chart.y.title = y_title;
  for (const auto& g : groups(rows, x, parameters)) {
    ChartSeries s;
    s.markers = true;
    for (const std::string& p : parameters) {
      if (p == x || std::all_of(rows.begin(), rows.end(), [&](const Row& r) { return r.at(p) == rows[0].at(p); })) continue;
      char t[60];
      std::snprintf(t, sizeof t, "%s%s %g", s.name.empty() ? "" : ", ", p.c_str(), g[0]->at(p));
      s.name += t;
    }
    for (const Row* r : g) s.x.push_back(r->at(x)), s.y.push_back(r->at(y));
    c.chart.series.push_back(std::move(s));
  }
  return c;
}

// ---- Z-plasty

const std::vector<std::string> kZ{"angle", "prestretch", "cell_mm"};
constexpr double kLimb_mm = 20;

Row run_z(const Values& v, const Run& with) {
  const double t = v[0], p = v[1], L = kLimb_mm;
  const Figure f = find_procedure("z_plasty").figure({L, t, t});
  const Done d = carry_out_on({200, p, v[2], 0.8 * L}, f, with);
  const Corner C{0, 0}, A{0, 1}, D{0, 3}, B{0, 4};
  const double a = d.height_mm(place(f, A), L / 2), b = d.height_mm(place(f, B), L / 2);
  const double c = d.height_mm(place(f, C), L / 4), e = d.height_mm(place(f, D), L / 4);
  const double theory = std::sqrt(5 - 4 * std::cos(t / kDeg)), gained = d.metrics.elongation.value_or(std::nan(""));
  Row r;
  r.figures = {{"angle", t}, {"prestretch", p}, {"cell_mm", v[2]}, {"elongation", gained}, {"theory", theory},
               {"gain_of_theory", (gained - 1) / (theory - 1)}, {"ear_A_mm", a}, {"ear_B_mm", b}, {"ear_mm", std::max(a, b)},
               {"at_C_D_mm", std::max(c, e)},
               // Alberini et al. 2021: what is gained for the largest strain that it costs, times the narrower flap's sine.
               {"efficiency", (gained - 1) / std::max(1e-3, d.metrics.stretch_p99 / (1 + p / 100) - 1) * std::sin(std::min(t, 90.0) / kDeg)},
               {"energy_uJ", d.energy_uJ}};
  add_common(r, d);
  char name[60];
  std::snprintf(name, sizeof name, "%g degrees, %g %%, %g mm", t, p, v[2]);
  r.title = name;
  return r;
}

// The protocol's checks, each where its members are there.
std::vector<Bar> bars_z(const std::vector<Row>& rows) {
  std::vector<Bar> out;
  double residual = 0, gap = 0, least_rise = 1e300, over = -1e300, least = 1e300, ear_rise = 1e300, at_tips = -1e300;
  double ear90 = 1e300, flat = -1e300, high = 1e300, none = 1e300, peak_lo = 1e300, peak_hi = -1e300, saturates = -1e300;
  for (const Row& r : rows) {
    residual = std::max(residual, r.at("residual")), gap = std::max(gap, r.at("gap_max_mm"));
    over = std::max(over, r.at("elongation") / r.at("theory")), least = std::min(least, r.at("elongation"));
    at_tips = std::max(at_tips, r.at("at_C_D_mm") - r.at("ear_mm"));
  }
  for (const auto& g : groups(rows, "angle", kZ)) {
    const auto at = [&](double angle, const char* what) {
      for (const Row* r : g)
        if (r->at("angle") == angle) return r->at(what);
      return std::nan("");
    };
    double best = -1, best_angle = 0;
    for (size_t i = 0; i < g.size(); ++i) {
      if (g[i]->at("efficiency") > best) best = g[i]->at("efficiency"), best_angle = g[i]->at("angle");
      if (i == 0) continue;
      if (g[i]->at("angle") <= 75) least_rise = std::min(least_rise, g[i]->at("elongation") - g[i - 1]->at("elongation"));
      ear_rise = std::min(ear_rise, g[i]->at("ear_mm") - g[i - 1]->at("ear_mm"));
    }
    if (g.size() >= 4) peak_lo = std::min(peak_lo, best_angle), peak_hi = std::max(peak_hi, best_angle);
    const double e60 = at(60, "ear_mm"), e90 = at(90, "ear_mm"), p = g[0]->at("prestretch");
    if (std::isfinite(e60 + e90)) ear90 = std::min(ear90, e90 / std::max(e60, 1e-3));
    if (p == 10 && std::isfinite(at(45, "ear_mm") + e60)) flat = std::max({flat, e60, at(45, "ear_mm")});
    if (p == 10 && std::isfinite(e90)) high = std::min(high, e90);
    if (p == 0)
      for (const Row* r : g) none = std::min(none, r->at("ear_mm"));
    const double late = at(90, "elongation") - at(75, "elongation"), early = at(60, "elongation") - at(45, "elongation");
    if (p == 0 && std::isfinite(late + early)) saturates = std::max(saturates, late / early);
  }
  out.push_back(at_most("largest relative residual", residual, 1e-4, "the protocol's equilibrium"));
  out.push_back(at_most("largest gap, mm", gap, 0.2, "the protocol's closure"));
  if (least_rise < 1e300) out.push_back(at_least("least rise of the elongation from angle to angle, up to 75 degrees", least_rise, 1e-3, "it rises strictly; 0.001 is what a residual of 1e-5 leaves open"));
  out.push_back(at_least("least elongation", least, 1, "a Z-plasty lengthens"));
  out.push_back(at_most("largest elongation over theory", over, 1, "sqrt(5 - 4 cos angle) is the plane figure's, without any resistance"));
  if (ear_rise < 1e300) out.push_back(at_least("least rise of the dog-ear with the angle, mm", ear_rise, -0.05, "cones of charge +angle; 0.05 mm is the lattice's noise"));
  out.push_back(at_most("height at the flaps' tips above that at the limb's ends, mm", at_tips, 0, "cones stand at the ends of the central limb (charge +angle), saddles at the tips"));
  if (ear90 < 1e300) out.push_back(at_least("dog-ear at 90 over 60 degrees", ear90, 1.2, "validation protocol (e)"));
  if (flat > -1e300) out.push_back(at_most("10 % prestretch: dog-ear at 45 and 60 degrees, mm", flat, 0.5, "plate model: flat up to 65 degrees, good to 10 degrees"));
  if (high < 1e300) out.push_back(at_least("10 % prestretch: dog-ear at 90 degrees, mm", high, 2, "plate model: 4.4 mm for a limb of 20 mm"));
  if (none < 1e300) out.push_back(at_least("no prestretch: least dog-ear of any angle, mm", none, 0.5, "without tension every angle has one"));
  if (saturates > -1e300) out.push_back(at_most("no prestretch: gain from 75 to 90 over that from 45 to 60", saturates, 0.5, "the ears eat the gain"));
  if (peak_hi > -1e300) {
    out.push_back(at_least("angle of greatest efficiency, least", peak_lo, 50, "Alberini et al. 2021: a broad optimum between 50 and 75 degrees"));
    out.push_back(at_most("angle of greatest efficiency, largest", peak_hi, 75, "the same"));
  }
  return out;
}

std::vector<NamedChart> charts_z(const std::vector<Row>& rows) {
  return {chart("elongation", "Elongation of the central limb", rows, "angle", "angle, degrees", "elongation", "times its length", kZ),
          chart("dog-ear", "Height of the dog-ears", rows, "angle", "angle, degrees", "ear_mm", "height, mm", kZ),
          chart("efficiency", "Efficiency index", rows, "angle", "angle, degrees", "efficiency", "gain over strain, times sine of the angle", kZ)};
}

// ---- Rhomboid flaps

const std::vector<std::string> kRhomboid{"flap_angle", "defect_angle", "prestretch", "cell_mm"};

Row run_rhomboid(const Values& v, const Run& with) {
  const double L = 20;
  // Webster's construction with any tip; at 60 degrees of flap and defect, Limberg's own figure.
  const Figure f = v[0] == 60 ? find_procedure("rhomboid").figure({L, v[1]}) : find_procedure("webster").figure({L, v[0]});
  const Done d = carry_out_on({140, v[2], v[3], 14}, f, with);
  Row r;
  r.figures = {{"flap_angle", v[0]}, {"defect_angle", v[1]}, {"prestretch", v[2]}, {"cell_mm", v[3]}};
  // Corners as rhombic flaps have them: 2 the donor's apex, 6 the pivot, 1 and 3 the donor's ends that meet.
  r.figures.push_back({"ear_donor_mm", d.height_mm(place(f, {0, 2}), L / 2)});
  r.figures.push_back({"ear_pivot_mm", d.height_mm(place(f, {0, 6}), L / 2)});
  r.figures.push_back({"donor_stitch_N", d.metrics.sutures.empty() ? 0 : d.metrics.sutures.front().force_N});
  r.figures.push_back({"donor_over_next", [&] {
                         double next = 1e-12;
                         for (size_t i = 1; i < d.metrics.sutures.size(); ++i) next = std::max(next, d.metrics.sutures[i].force_N);
                         return d.metrics.sutures.empty() ? 0 : d.metrics.sutures.front().force_N / next;
                       }()});
  add_common(r, d);
  char name[60];
  std::snprintf(name, sizeof name, "flap %g, defect %g degrees", v[0], v[1]);
  r.title = name;
  return r;
}

std::vector<Bar> bars_rhomboid(const std::vector<Row>& rows) {
  double residual = 0, gap = 0, limberg = 1e300;
  for (const Row& r : rows) {
    residual = std::max(residual, r.at("residual")), gap = std::max(gap, r.at("gap_max_mm"));
    if (r.at("flap_angle") == 60 && r.at("defect_angle") == 60) limberg = std::min(limberg, r.at("donor_over_next"));
  }
  std::vector<Bar> out{at_most("largest relative residual", residual, 1e-4, "at rest, as in operate"), at_most("largest gap, mm", gap, 0.2, "closed")};
  if (limberg < 1e300)
    out.push_back(at_least("Limberg: the donor's stitch over the next strongest", limberg, 1, "the greatest tension is where D meets F (charge -120)"));
  return out;
}

std::vector<NamedChart> charts_rhomboid(const std::vector<Row>& rows) {
  return {chart("force", "Strongest stitch", rows, "flap_angle", "angle of the flap's tip, degrees", "suture_force_max_N", "force, N", kRhomboid),
          chart("dog-ear", "Dog-ear at the donor's apex", rows, "flap_angle", "angle of the flap's tip, degrees", "ear_donor_mm", "height, mm", kRhomboid)};
}

// ---- Fusiform excisions

const std::vector<std::string> kFusiform{"ratio", "prestretch", "cell_mm"};

Row run_fusiform(const Values& v, const Run& with) {
  const double W = 14;
  const Figure f = find_procedure("fusiform").figure({W, v[0]});
  const Done d = carry_out_on({std::max(120.0, W * v[0] + 60), v[1], v[2], 10}, f, with);
  const Seam& s = f.seams[0];
  const double left = d.height_mm(place(f, s.a_from), W / 2), right = d.height_mm(place(f, s.a_to), W / 2);
  double drawn = 0;  // vertex angle: the larger tip's charge
  for (const Charge& c : charges(f)) drawn = std::max(drawn, c.q_deg);
  const double L = W * v[0], vertex = 4 * std::atan(1 / v[0]), R = (L * L + W * W) / (4 * W);
  Row r;
  r.figures = {{"ratio", v[0]}, {"prestretch", v[1]}, {"cell_mm", v[2]},
               {"vertex_deg", drawn},
               {"vertex_form_deg", vertex * kDeg}, {"scar_mm", length_mm(bank(f, s.a_from, s.a_to, true))}, {"scar_form_mm", R * vertex},
               {"ear_mm", std::max(left, right)}};
  add_common(r, d);
  char name[60];
  std::snprintf(name, sizeof name, "%g to 1", v[0]);
  r.title = name;
  return r;
}

std::vector<Bar> bars_fusiform(const std::vector<Row>& rows) {
  double residual = 0, gap = 0, scar = 0, fall = 1e300;
  for (const Row& r : rows) {
    residual = std::max(residual, r.at("residual")), gap = std::max(gap, r.at("gap_max_mm"));
    scar = std::max(scar, std::abs(r.at("scar_mm") / r.at("scar_form_mm") - 1));
  }
  for (const auto& g : groups(rows, "ratio", kFusiform))
    for (size_t i = 1; i < g.size(); ++i) fall = std::min(fall, g[i - 1]->at("ear_mm") - g[i]->at("ear_mm"));
  std::vector<Bar> out{at_most("largest relative residual", residual, 1e-4, "at rest, as in operate"), at_most("largest gap, mm", gap, 0.2, "closed"),
                       at_most("scar length against the closed form, relative", scar, 0.003, "chords of 12 equal pieces of an arc of at most 106 degrees")};
  if (fall < 1e300) out.push_back(at_least("least fall of the dog-ear with the ratio, mm", fall, 0, "narrower tips stand up less"));
  return out;
}

std::vector<NamedChart> charts_fusiform(const std::vector<Row>& rows) {
  return {chart("dog-ear", "Height of the dog-ears", rows, "ratio", "length over width", "ear_mm", "height, mm", kFusiform),
          chart("force", "Sum of the stitches' forces", rows, "ratio", "length over width", "closure_force_N", "force, N", kFusiform)};
}

}  // namespace

Family zplasty() {
  return {"zplasty", "Z-plasties of 20 mm limbs by angle and prestretch: what they gain, and where the skin stands up",
          {{"angle", "of both flaps, degrees", {30, 45, 60, 75, 90}, 20, 100},
           {"prestretch", "of the skin, percent, in all directions", {0, 5, 10, 15}, 0, 30},
           {"cell_mm", "size of the lattice's cells", {5, 4}, 2, 8}},
          run_z, bars_z, charts_z};
}

Family rhomboid() {
  return {"rhomboid", "Rhomboid flaps of 20 mm sides by the angle of their tip (60: Limberg's; less: Webster's)",
          {{"flap_angle", "of the flap's tip, degrees", {30, 45, 60}, 20, 60},
           {"defect_angle", "of the defect, degrees; for Limberg's flap only", {60}, 40, 90},
           {"prestretch", "of the skin, percent, in all directions", {10}, 0, 30},
           {"cell_mm", "size of the lattice's cells", {4}, 2, 8}},
          run_rhomboid, bars_rhomboid, charts_rhomboid};
}

Family fusiform() {
  return {"fusiform", "Spindle-shaped excisions 14 mm wide by their ratio of length to width",
          {{"ratio", "length over width", {2, 3, 4, 5, 6}, 1.5, 8},
           {"prestretch", "of the skin, percent, in all directions", {5}, 0, 30},
           {"cell_mm", "size of the lattice's cells", {4}, 2, 8}},
          run_fusiform, bars_fusiform, charts_fusiform};
}

}  // namespace limberg::study
