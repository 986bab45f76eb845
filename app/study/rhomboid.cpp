#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/study/flaps.h"
#include "app/study/patch.h"
#include "sim/tools/procedures/catalogue.h"

namespace limberg::study {

namespace {

// ---- Rhomboid flaps

const std::vector<std::string> kRhomboid{"flap_angle", "defect_angle", "prestretch", "cell_mm", "contact"};

// Corners of rhombic flaps (figures.h): 0 A, 1 and 5 D (outer and flap), 2 and 4 E (outer and flap), 3 F, 6 C, 7 B.
constexpr double kSide_mm = 20;
constexpr Corner kD{0, 1}, kE{0, 2}, kF{0, 3}, kC{0, 6};

/// What the angles of corners that meet lack for a full turn, as they have been cut.
double charge_deg(const SkinMap& map, const Figure& f, const std::vector<Corner>& corners) {
  double q = 360;
  for (const Corner& c : corners) q -= map.cut_angle_deg(f, c, 0.2 * kSide_mm);
  return q;
}

Row run_rhomboid(const Values& v, const Run& with) {
  const double L = kSide_mm;
  // Webster's construction with any tip; at 60 degrees of flap and defect, Limberg's own figure.
  const Figure f = v[0] == 60 ? find_procedure("rhomboid").figure({L, v[1]}) : find_procedure("webster").figure({L, v[0]});
  Patch patch;
  patch.side_mm = 140, patch.prestretch_percent = v[2], patch.cell_mm = v[3], patch.undermine_mm = 14, patch.contact = v[4] > 0;
  const Done d = carry_out_on(patch, f, with);
  Row r;
  r.figures = {{"flap_angle", v[0]}, {"defect_angle", v[1]}, {"prestretch", v[2]}, {"cell_mm", v[3]}, {"contact", v[4]}};
  r.figures.push_back({"ear_donor_mm", d.height_mm(place(f, kE), L / 2)});
  r.figures.push_back({"ear_pivot_mm", d.height_mm(place(f, kC), L / 2)});
  r.figures.push_back({"at_D_F_mm", std::max(d.height_mm(place(f, kD), L / 4), d.height_mm(place(f, kF), L / 4))});
  // The strongest stitch within 8 mm of where D and F have come to lie, and elsewhere.
  double donor = 0, next = 1e-12;
  const auto lies = [&](const Corner& c) { return d.map->now_mm(place(f, c) + 0.3 * tissue_bisector(f, c)).value_or(Vec3::Zero()); };
  const Vec3 meeting = 0.5 * (lies(kD) + lies(kF));
  for (const SutureFigure& s : d.metrics.sutures) {
    const Vec3 at(s.at_mm[0], s.at_mm[1], s.at_mm[2]);
    double& of = (at - meeting).norm() < 0.4 * L ? donor : next;
    of = std::max(of, s.force_N);
  }
  r.figures.push_back({"donor_stitch_N", donor});
  r.figures.push_back({"donor_over_next", donor / next});
  // What each seam carries, its corner's key stitch with the donor's: keys were tied first, then the seams in their order.
  double donor_seam = 0, next_seam = 1e-12;
  size_t at_stitch = f.keys.size();
  const auto& sutures = d.metrics.sutures;
  for (size_t i = 0; i < f.seams.size(); ++i) {
    const Seam& s = f.seams[i];
    const double longer = std::max(length_mm(bank(f, s.a_from, s.a_to, true)), length_mm(bank(f, s.b_from, s.b_to, false)));
    double sum = i == 0 && !sutures.empty() ? sutures[0].force_N : 0;
    for (int n = int(std::floor(longer / patch.spacing_mm + 0.5)) - 1; n > 0 && at_stitch < sutures.size(); --n) sum += sutures[at_stitch++].force_N;
    if (i == 0) donor_seam = sum;
    else next_seam = std::max(next_seam, sum);
  }
  r.figures.push_back({"donor_seam_N", donor_seam});
  r.figures.push_back({"donor_seam_over_next", donor_seam / next_seam});
  for (const auto& [name, corners] : {std::pair<const char*, std::vector<Corner>>{"C", {kC}}, {"E", {kE}}, {"DF", {kD, kF}}}) {
    r.figures.push_back({std::string("charge_") + name + "_deg", charge_deg(*d.map, f, corners)});
    r.figures.push_back({std::string("deficit_") + name + "_deg", d.map->deficit_deg(f, corners, 0.4 * L)});
  }
  // The tension, evened out over discs of 3 mm: at the donor's closure, on its outer side and beyond F, and wherever else it is greatest.
  constexpr double kDisc_mm = 3, kStep_mm = 2;
  const auto at = [&](const Corner& c) { return ChartPoint(place(f, c) + kDisc_mm * tissue_bisector(f, c)); };
  const SkinMap::Stretch here = std::max(d.map->stretch(at(kD), kDisc_mm), d.map->stretch(at(kF), kDisc_mm), [](const auto& x, const auto& y) { return x.most < y.most; });
  double most = 0, elsewhere = 0;
  ChartPoint most_at{0, 0};
  for (double y = -60; y <= 60; y += kStep_mm)
    for (double x = -60; x <= 60; x += kStep_mm) {
      const ChartPoint p{x, y};
      const SkinMap::Stretch s = d.map->stretch(p, kDisc_mm);
      if (s.area_mm2 < 0.5 * std::numbers::pi * kDisc_mm * kDisc_mm) continue;
      if (s.most > most) most = s.most, most_at = p;
      if (std::min((p - place(f, kD)).norm(), (p - place(f, kF)).norm()) > 0.4 * L) elsewhere = std::max(elsewhere, s.most);
    }
  const Vec2 closing = (place(f, kF) - place(f, kD)).normalized();
  r.figures.insert(r.figures.end(), {{"stretch_D_F", here.most}, {"stretch_elsewhere", elsewhere}, {"most_at_x_mm", most_at.x()}, {"most_at_y_mm", most_at.y()},
                                     {"most_from_D_F_mm", std::min((most_at - place(f, kD)).norm(), (most_at - place(f, kF)).norm())},
                                     {"direction_off_deg", std::acos(std::min(1.0, std::abs(here.direction.head<2>().dot(closing)))) * 180 / std::numbers::pi}});
  add_common(r, d);
  char name[60];
  std::snprintf(name, sizeof name, "flap %g, defect %g degrees", v[0], v[1]);
  r.title = name;
  return r;
}

std::vector<Bar> bars_rhomboid(const std::vector<Row>& rows) {
  double residual = 0, gap = 0, stitch = 1e300, seam = 1e300, share = 1e300, far = 0, off = 0, plan = 0, up = 1e300, down = -1e300, ears = 1e300;
  bool limberg = false;
  for (const Row& r : rows) {
    residual = std::max(residual, r.at("residual")), gap = std::max(gap, r.at("gap_max_mm"));
    if (r.at("flap_angle") != 60 || r.at("defect_angle") != 60) continue;
    limberg = true;
    stitch = std::min(stitch, r.at("donor_over_next")), seam = std::min(seam, r.at("donor_seam_over_next"));
    share = std::min(share, r.at("stretch_D_F") / r.at("stretch_elsewhere"));
    far = std::max(far, r.at("most_from_D_F_mm")), off = std::max(off, r.at("direction_off_deg"));
    plan = std::max({plan, std::abs(r.at("charge_C_deg") - 60), std::abs(r.at("charge_E_deg") - 60), std::abs(r.at("charge_DF_deg") + 120)});
    up = std::min({up, r.at("deficit_C_deg"), r.at("deficit_E_deg")}), down = std::max(down, r.at("deficit_DF_deg"));
    ears = std::min(ears, std::min(r.at("ear_donor_mm"), r.at("ear_pivot_mm")) - r.at("at_D_F_mm"));
  }
  std::vector<Bar> out{at_most("largest relative residual", residual, 1e-4, "at rest, as in operate"), at_most("largest gap, mm", gap, 0.2, "closed")};
  if (!limberg) return out;
  const char* figure = "Limberg's flap: the donor's closure D-F carries the greatest tension (charge -120)";
  out.push_back(at_least("Limberg: strongest stitch at D-F over the strongest elsewhere", stitch, 1, figure));
  out.push_back(at_least("Limberg: force of the donor's seam over the next seam's", seam, 1, figure));
  out.push_back(at_least("Limberg: stretch at D-F over the largest elsewhere (beyond 8 mm)", share, 1, figure));
  out.push_back(at_most("Limberg: place of the largest stretch, from D or F, mm", far, 0.4 * kSide_mm, figure));
  out.push_back(at_most("Limberg: direction of the largest stretch there, off D-F, degrees", off, 30, "parallel to two sides of the rhombus; half of its 60 degrees"));
  out.push_back(at_most("Limberg: angle deficits as cut and sewn off +60, +60, -120, degrees", plan, 0.5, "closed form; half a degree on 4 mm is 0.03 mm of the cut edges"));
  out.push_back(at_least("Limberg: smaller angle deficit of the closed skin at C and E, degrees", up, 0, "cones of charge +60; what tension draws flat is lost"));
  out.push_back(at_most("Limberg: angle deficit of the closed skin at D-F, degrees", down, 0, "a saddle of charge -120; the same"));
  out.push_back(at_least("Limberg: lower ear (C, E) above the height at D-F, mm", ears, 0, "cones stand up, saddles do not"));
  return out;
}

std::vector<NamedChart> charts_rhomboid(const std::vector<Row>& rows) {
  return {chart("force", "Strongest stitch", rows, "flap_angle", "angle of the flap's tip, degrees", "suture_force_max_N", "force, N", kRhomboid),
          chart("dog-ear", "Dog-ear at the donor's apex", rows, "flap_angle", "angle of the flap's tip, degrees", "ear_donor_mm", "height, mm", kRhomboid)};
}

}  // namespace

Family rhomboid() {
  return {"rhomboid", "Rhomboid flaps of 20 mm sides by the angle of their tip (60: Limberg's; less: Webster's)",
          {{"flap_angle", "of the flap's tip, degrees", {30, 45, 60}, 20, 60},
           {"defect_angle", "of the defect, degrees; for Limberg's flap only", {60}, 40, 90},
           {"prestretch", "of the skin, percent, in all directions", {10}, 0, 30},
           {"cell_mm", "size of the lattice's cells", {4}, 2, 8},
           {"contact", "1: wound surfaces keep each other out", {1}, 0, 1}},
          run_rhomboid, bars_rhomboid, charts_rhomboid,
          {{"rhomboid", {"flap_angle=60", "prestretch=0,5,10"}}}};
}

}  // namespace limberg::study
