#include "app/study/zplasty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/study/patch.h"
#include "app/study/seams.h"
#include "app/words/words.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/geometry/vec.h"

namespace limberg::study {

namespace {

// Beyond the figure: the pocket reaches from 1.5 limbs (along the
// central one) to 1.9 or 2 from the middle, as the protocol asks.
constexpr double kUndermined_mm = kLimb_mm;
const std::vector<std::string> kKeys{"angle", "prestretch", "cell_mm"};

Row run_zplasty(const Values& v, Patch patch, const Run& with) {
  const double t = v[0], p = v[1], L = kLimb_mm;
  patch.prestretch_percent = p, patch.cell_mm = v[2];
  const Figure f = find_procedure("z_plasty").figure({L, t, t});
  const Corner C{0, 0}, A{0, 1}, B2{0, 2}, D{0, 3}, B{0, 4}, A1{0, 5};
  // The outer corners; a push goes 0.15 limbs outside them, into skin that stays in one piece.
  for (const Corner& c : {A, B}) patch.ears.push_back(place(f, c) + 0.15 * L * tissue_bisector(f, c));
  const Done d = carry_out_on(patch, f, with);
  const DogEar a = d.shape(place(f, A), L / 2), b = d.shape(place(f, B), L / 2), around = d.shape({0, 0}, 2.2 * L);
  const double tips = std::max(d.height_mm(place(f, C), L / 4), d.height_mm(place(f, D), L / 4));
  const double volume = d.shape(place(f, A), L).volume_mm3 + d.shape(place(f, B), L).volume_mm3;
  // The same evened out over discs of an eighth of a limb: what stands up as a whole, not the lips of a seam.
  const auto evened = [&](const Corner& c) {
    double most = 0;
    for (double y = -L / 2; y <= L / 2; y += 1.5)
      for (double x = -L / 2; x <= L / 2; x += 1.5)
        if (const Vec2 q(x, y); q.norm() <= L / 2)
          most = std::max(most, d.map->mean_now_mm(place(f, c) + q, L / 8).value_or(Vec3::Zero()).z());
    return most;
  };
  // With nothing beneath, skin may as well go down: the two are mirror images of each other.
  const auto dent = [&](const Corner& c) {
    double most = 0;
    if (patch.support != Support::none) return most;
    for (double y = -L / 2; y <= L / 2; y += 1)
      for (double x = -L / 2; x <= L / 2; x += 1)
        if (const Vec2 q(x, y); q.norm() <= L / 2)
          if (const auto now = d.map->now_mm(place(f, c) + q)) most = std::max(most, -now->z());
    return most;
  };
  const double up_A = std::max(a.height_mm, dent(A)), up_B = std::max(b.height_mm, dent(B));
  const auto middle = [&](const Corner& c) { return d.middle_height_mm(place(f, c), L / 2, L / 8); };
  const double theory = std::sqrt(5 - 4 * std::cos(t / kDeg)), gained = d.metrics.elongation.value_or(std::nan("")),
               ear = std::max(up_A, up_B);
  const std::vector<ChartPoint> corners{place(f, A), place(f, B), place(f, C), place(f, D)};
  const double p95 = d.map->percentile(0.95, 2 * L, corners, 0.1 * L),
               p99 = d.map->percentile(0.99, 2 * L, corners, 0.1 * L);
  const auto outside = [&](const Corner& c) { return d.map->now_mm(place(f, c) + 0.05 * tissue_bisector(f, c)); };
  const auto flat = [](const std::optional<Vec3>& x, const std::optional<Vec3>& y) {
    return x && y ? (*x - *y).head<2>().norm() : std::nan("");
  };
  const SeamsLie lie = seams_lie(*d.map, f, patch.spacing_mm);
  // As they have been cut: the angles that the seams bring together, against the plan's charges.
  double charge_off = 0;
  for (const auto& [sign, meeting] :
       {std::pair<int, std::vector<Corner>>{1, {A}}, {1, {B}}, {-1, {C, B2}}, {-1, {D, A1}}}) {
    double q = 360;
    for (const Corner& c : meeting) q -= d.map->cut_angle_deg(f, c, 0.2 * L);
    charge_off = std::max(charge_off, std::isfinite(q) ? std::abs(q - sign * t) : 360);
  }
  // The pocket is the hull of discs around the figure's corners,
  // of which the middle's nearest and farthest are A and C.
  const bool pocket = patch.support == Support::fat;
  const double undermined_least = pocket ? (patch.undermine_mm + place(f, A).norm()) / L : std::nan(""),
               undermined_most = pocket ? (patch.undermine_mm + place(f, C).norm()) / L : std::nan("");
  Row r;
  r.figures = {
      {"angle", t},
      {"prestretch", p},
      {"cell_mm", v[2]},
      {"elongation", gained},
      {"theory", theory},
      {"gain_of_theory", (gained - 1) / (theory - 1)},
      {"elongation_flat", flat(outside(A), outside(B)) / L},
      {"elongation_4L", flat(d.map->now_mm({0, 2 * L}), d.map->now_mm({0, -2 * L})) / (4 * L)},
      {"open_elongation", d.open_elongation},
      {"ear_A_mm", up_A},
      {"ear_B_mm", up_B},
      {"ear_mm", ear},
      {"ear_limbs", ear / L},
      {"ear_evened_mm", std::max(evened(A), evened(B))},
      {"ear_middle_mm", std::max(middle(A), middle(B))},
      {"at_C_D_mm", tips},
      {"ear_volume_mm3", volume},
      {"rms_mm", around.rms_mm},
      // What is sewn together there: A's and B's own edges; the flaps' tips into the ends of the lateral limbs.
      {"deficit_A_deg", d.map->deficit_deg(f, {A}, 0.3 * L)},
      {"deficit_B_deg", d.map->deficit_deg(f, {B}, 0.3 * L)},
      {"deficit_C_deg", d.map->deficit_deg(f, {C, B2}, 0.3 * L)},
      {"deficit_D_deg", d.map->deficit_deg(f, {D, A1}, 0.3 * L)},
      // Enclosed within 0.4 limbs, where the protocol reads it.
      {"curvature_A_deg", d.map->curvature_deg(f, {A}, 0.4 * L, 0.15 * L)},
      {"curvature_B_deg", d.map->curvature_deg(f, {B}, 0.4 * L, 0.15 * L)},
      {"curvature_C_deg", d.map->curvature_deg(f, {C, B2}, 0.4 * L, 0.15 * L)},
      {"curvature_D_deg", d.map->curvature_deg(f, {D, A1}, 0.4 * L, 0.15 * L)},
      {"charge_off_deg", charge_off},
      {"side_limbs", patch.side_mm / L},
      {"undermined_least_limbs", undermined_least},
      {"undermined_most_limbs", undermined_most},
      {"slack_share", d.map->slack_share(2.2 * L, 1 + p / 100)},
      {"turned_share", d.map->turned_share(2.2 * L)},
      {"least_opening_deg", lie.least_opening_deg},
      {"most_step_mm", lie.most_step_mm},
      {"most_tip_mm", lie.most_tip_mm},
      {"strain_p95", p95 - 1},
      {"strain_p99", p99 - 1},
      {"closing_uJ", d.closing_uJ},
      // Alberini et al. 2021: what is gained for the largest strain that it costs, times the narrower flap's sine.
      {"efficiency", (gained - 1) / std::max(1e-3, p99 - 1) * std::sin(std::min(t, 90.0) / kDeg)},
      // What is gained for the work of closing it: strain energy goes with the square of the strain.
      {"gain_per_root_work", (gained - 1) / std::sqrt(std::max(1e-9, d.closing_uJ))},
      {"equilibria", double(d.equilibria)},
      {"found_by", double(d.found_by)},
      {"pushed_gain", 1 - d.closing_uJ / std::max(1e-9, d.closing_uJ + d.energy_as_closed_uJ - d.energy_uJ)}};
  add_common(r, d);
  const std::string name = fmt::format("{:g} degrees, {:g} %, {:g} mm", t, p, v[2]);
  r.title = name;
  return r;
}

/// "prestretch 10, cell_mm 5" as "10 %, 5 mm": a legend holds two lattices of four prestretches.
std::string short_name(std::string name) {
  const auto put = [&](const std::string& key, const std::string& unit) {
    const size_t at = name.find(key);
    if (at == std::string::npos) return;
    name.erase(at, key.size());
    name.insert(std::min(name.find(',', at), name.size()), unit);
  };
  put("prestretch ", " %"), put("cell_mm ", " mm"), put("angle ", "°");
  return name;
}

std::vector<NamedChart> charts_z(const std::vector<Row>& rows) {
  std::vector<NamedChart> out{
      chart("elongation", english("Elongation of the central limb"), rows, "angle", english("angle, degrees"),
            "elongation", english("times its length"), kKeys),
      chart("dog-ear", english("Height of the dog-ears"), rows, "angle", english("angle, degrees"), "ear_mm",
            english("height, mm; dashed: stands up"), kKeys),
      chart("dog-ear-by-prestretch", english("Height of the dog-ears"), rows, "prestretch",
            english("prestretch, percent"), "ear_mm", english("height, mm; dashed: stands up"), kKeys),
      chart("efficiency", english("Gain for the work of closing"), rows, "angle", english("angle, degrees"),
            "gain_per_root_work", english("gain over root of the work, 1/√µJ"), kKeys),
      chart("strain-efficiency", english("Gain for the largest strain"), rows, "angle", english("angle, degrees"),
            "efficiency", english("gain over strain, times sine of the angle"), kKeys),
      chart("ear-efficiency", english("Gain for the dog-ear"), rows, "angle", english("angle, degrees"), "elongation",
            english("gain over height, 1/mm"), kKeys)};
  // The last is of a quotient: the group's rows come in the order of the points.
  const auto by_angle = groups(rows, "angle", kKeys);
  for (size_t g = 0; g < by_angle.size(); ++g)
    for (size_t i = 0; i < by_angle[g].size(); ++i) out.back().chart.series[g].y[i] = gain_per_ear(*by_angle[g][i]);
  for (NamedChart& c : out)
    for (ChartSeries& one : c.chart.series) one.name = one.name.empty() ? "model" : short_name(one.name);
  // What geometry alone promises beside it; the height from which
  // skin counts as standing up (half a skin's thickness or 1 mm).
  ChartSeries theory;
  theory.name = "theory", theory.markers = true;
  for (const auto& g : groups(rows, "angle", kKeys)) {
    if (g.size() < theory.x.size()) continue;
    theory.x.clear(), theory.y.clear();
    for (const Row* r : g) theory.x.push_back(r->at("angle")), theory.y.push_back(r->at("theory"));
  }
  out[0].chart.series.push_back(std::move(theory));
  for (const size_t i : {1, 2}) out[i].chart.y_marks = {{1, ""}};
  for (const Row& r : rows)
    if (r.at("prestretch") != rows[0].at("prestretch")) return out;
  out.erase(out.begin() + 2);  // one prestretch: no curve over it
  return out;
}

std::vector<NamedChart> charts_planar(const std::vector<Row>& rows) {
  NamedChart gain = chart("gain", english("Share of the theoretical gain"), rows, "angle", english("angle, degrees"),
                          "gain_of_theory", english("gain over theory"), kKeys);
  gain.chart.y_marks = {{0.53, "membrane of triangles"}};
  return {chart("elongation", english("Elongation of the central limb"), rows, "angle", english("angle, degrees"),
                "elongation", english("times its length"), kKeys),
          gain};
}

}  // namespace

Row run_z(const Values& v, const Run& with) {
  Patch p;
  p.side_mm = 10 * kLimb_mm, p.undermine_mm = kUndermined_mm, p.contact = v[3] > 0, p.depth_mm = v[4], p.push_mm = v[5],
  p.spacing_mm = v[6], p.fronts = v[7] > 0;
  Row r = run_zplasty(v, p, with);
  r.figures.insert(r.figures.begin() + 3,
                   {{"contact", v[3]}, {"depth_mm", v[4]}, {"push_mm", v[5]}, {"spacing_mm", v[6]}, {"fronts", v[7]}});
  return r;
}

Row run_plate(const Values& v, const Run& with) {
  Patch p;
  p.push_mm = 0.1 * kLimb_mm;
  if (v[3] > 0) {
    p.side_mm = 10 * kLimb_mm, p.undermine_mm = kUndermined_mm, p.contact = true, p.depth_mm = 1.5;
  } else {
    p.support = Support::none;
    p.side_mm = 10.4 * kLimb_mm, p.region_mm = 5 * kLimb_mm;
  }
  Row r = run_zplasty(v, p, with);
  r.figures.insert(r.figures.begin() + 3, {"bed", v[3]});
  return r;
}

Row run_planar(const Values& v, const Run& with) {
  Patch p;
  p.support = Support::plane;
  p.side_mm = 12.4 * kLimb_mm, p.region_mm = 6 * kLimb_mm;
  p.spacing_mm = 0.05 * kLimb_mm, p.inset_mm = 0.1, p.corner_mm = 0.15;
  return run_zplasty(v, p, with);
}

Family zplasty() {
  return {"zplasty",
          english("Z-plasties of 20 mm limbs by angle and prestretch: what they gain, and where the skin stands up"),
          {{"angle", "of both flaps, degrees", {30, 45, 60, 75, 90}, 20, 100},
           {"prestretch", "of the skin, percent, in all directions", {0, 5, 10, 15}, 0, 30},
           {"cell_mm", "size of the lattice's cells", {3.5}, 2, 8},
           {"contact", "1: wound surfaces keep each other out", {1}, 0, 1},
           {"depth_mm", "of cut and undermining: how thick the flaps are", {2}, 1.5, 8},
           {"push_mm", "height of the pushes that look for other equilibria; 0: none", {2}, 0, 10},
           {"spacing_mm", "of the stitches", {3}, 1, 8},
           {"fronts", "1: cells in which a cut ends are divided, 0: they are not", {1}, 0, 1}},
          run_z,
          bars_z,
          charts_z,
          {{"zplasty", {"prestretch=0,5,10", "cell_mm=5,3.5"}}, {"planar", {"prestretch=0"}}}};
}

Family plate() {
  return {
      "plate",
      english("The same Z-plasties in a flap of nothing but 1.5 mm of skin: on a bed that it can rise from, or with "
              "nothing beneath it"),
      {{"angle", "of both flaps, degrees", {30, 45, 60, 75, 90}, 20, 100},
       {"prestretch", "of the skin, percent, in all directions", {0, 5, 10, 15}, 0, 30},
       {"cell_mm", "size of the lattice's cells; at most 1.5 without a bed", {3.5}, 1, 5},
       {"bed",
        "1: fat, which it is raised from by a limb around the figure; 0: nothing, held at five limbs",
        {1},
        0,
        1}},
      run_plate,
      bars_plate,
      charts_z};
}

Family planar() {
  return {"planar",
          english("The same Z-plasties in a membrane that cannot leave its plane, held at six limbs: the control of "
                  "the elongation"),
          {{"angle", "of both flaps, degrees", {30, 45, 60, 75, 90}, 20, 100},
           {"prestretch", "of the membrane, percent, in all directions", {0, 10}, 0, 30},
           {"cell_mm", "size of the lattice's cells", {2.5}, 1, 8}},
          run_planar,
          bars_planar,
          charts_planar};
}

}  // namespace limberg::study
