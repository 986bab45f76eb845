#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "app/study/flaps.h"
#include "app/study/patch.h"
#include "app/study/sewn_metric.h"
#include "app/words/words.h"
#include "sim/commands/plan_numbers.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/measure/skin_strain.h"

namespace limberg::study {

namespace {

// ---- Rhomboid flaps

const std::vector<std::string> kRhomboid{"flap_angle", "defect_angle", "prestretch", "cell_mm",   "contact",
                                         "side_mm",    "depth_mm",     "bed",        "spacing_mm"};

// Corners of rhombic flaps (figures.h): 0 A, 1 and 5 D (outer and flap), 2 and 4 E (outer and flap), 3 F, 6 C, 7 B.
constexpr Corner kD{0, 1}, kE{0, 2}, kF{0, 3}, kC{0, 6};

/// What the angles of corners that meet lack for a full turn, as they have been cut.
double charge_deg(const SkinMap& map, const Figure& f, const std::vector<Corner>& corners, double side_mm) {
  double q = 360;
  for (const Corner& c : corners) q -= map.cut_angle_deg(f, c, 0.2 * side_mm);
  return q;
}

/// The largest principal stress of the skin, evened out over discs of the chart.
class Tension {
 public:
  explicit Tension(const Snapshot& s) {
    const SurfaceView& v = s.topology->view;
    const std::vector<MembraneState> states = skin_states(v, s.x_mm, *s.topology->body);
    for (size_t t = 0; t < states.size(); ++t) {
      if (!(states[t].area_mm2 > 0)) continue;
      Vec3 middle = Vec3::Zero();
      for (const int32_t i : v.tri[t]) middle += v.X_mm[size_t(i)] / 3;
      parts_.push_back({s.topology->body->to_chart(middle), states[t].area_mm2, states[t].stress_kPa});
    }
    std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) { return a.at.x() < b.at.x(); });
  }
  /// 0 where less than half of the disc is skin.
  double mean_kPa(const ChartPoint& p, double radius_mm) const {
    double area = 0, sum = 0;
    for (auto i = std::lower_bound(parts_.begin(), parts_.end(), p.x() - radius_mm,
                                   [](const Part&a, double x) { return a.at.x() < x; });
         i != parts_.end() && i->at.x() <= p.x() + radius_mm; ++i)
      if ((i->at - p).norm() <= radius_mm) area += i->area_mm2, sum += i->area_mm2 * i->stress_kPa;
    return area < 0.5 * std::numbers::pi * radius_mm * radius_mm ? 0 : sum / area;
  }

 private:
  struct Part {
    ChartPoint at;
    double area_mm2, stress_kPa;
  };
  std::vector<Part> parts_;
};

Row run_rhomboid(const Values& v, const Run& with) {
  const double L = v[5];
  // Webster's construction with any tip; at 60 degrees of flap and defect, Limberg's own figure.
  const Figure f =
      v[0] == 60 ? find_procedure("rhomboid").figure({L, v[1]}) : find_procedure("webster").figure({L, v[0]});
  Patch patch;
  patch.side_mm = 7 * L, patch.prestretch_percent = v[2], patch.cell_mm = v[3], patch.undermine_mm = 0.7 * L,
  patch.contact = v[4] > 0;
  patch.depth_mm = v[6], patch.push_mm = v[8], patch.spacing_mm = v[9];
  if (v[7] <= 0) patch.support = Support::none, patch.side_mm = 6.4 * L, patch.region_mm = 3 * L;
  for (const Corner& c : {kE, kC}) patch.ears.push_back(place(f, c) + 0.15 * L * tissue_bisector(f, c));
  const Done d = carry_out_on(patch, f, with);
  Row r;
  r.figures = {{"flap_angle", v[0]}, {"defect_angle", v[1]}, {"prestretch", v[2]}, {"cell_mm", v[3]},
               {"contact", v[4]},    {"side_mm", L},         {"depth_mm", v[6]},   {"bed", v[7]},
               {"push_mm", v[8]},    {"spacing_mm", v[9]}};
  r.figures.push_back({"ear_donor_mm", d.height_mm(place(f, kE), L / 2)});
  r.figures.push_back({"ear_pivot_mm", d.height_mm(place(f, kC), L / 2)});
  r.figures.push_back({"at_D_F_mm", std::max(d.height_mm(place(f, kD), L / 4), d.height_mm(place(f, kF), L / 4))});
  r.figures.push_back({"ear_donor_middle_mm", d.middle_height_mm(place(f, kE), L / 2, L / 8)});
  r.figures.push_back({"ear_pivot_middle_mm", d.middle_height_mm(place(f, kC), L / 2, L / 8)});
  r.figures.push_back({"found_by", double(d.found_by)});
  // The most that any stitch has borne at rest: the donor's key stitch D-F, tied first, and every other.
  double key_peak = 0, other_peak = 1e-12;
  for (size_t i = 0; i < d.metrics.sutures.size(); ++i)
    (i ? other_peak : key_peak) = std::max(i ? other_peak : key_peak, d.metrics.sutures[i].peak_N);
  r.figures.insert(r.figures.end(), {{"key_D_F_peak_N", key_peak}, {"other_peak_N", other_peak}});
  for (size_t i = 1; i < 3 && i < d.metrics.sutures.size(); ++i)
    r.figures.push_back({i == 1 ? "key_tip_B_peak_N" : "key_tip_A_peak_N", d.metrics.sutures[i].peak_N});
  // The strongest stitch within 8 mm of where D and F have come to lie, and elsewhere.
  double donor = 0, next = 1e-12;
  const auto lies = [&](const Corner& c) {
    return d.map->now_mm(place(f, c) + 0.3 * tissue_bisector(f, c)).value_or(Vec3::Zero());
  };
  const Vec3 meeting = 0.5 * (lies(kD) + lies(kF));
  for (const SutureFigure& s : d.metrics.sutures) {
    const Vec3 at(s.at_mm[0], s.at_mm[1], s.at_mm[2]);
    double& of = (at - meeting).norm() < 0.4 * L ? donor : next;
    of = std::max(of, s.force_N);
  }
  r.figures.push_back({"donor_stitch_N", donor});
  r.figures.push_back({"donor_over_next", donor / next});
  // What each seam carries, its corner's key stitch with the
  // donor's: keys were tied first, then the seams in their order.
  double donor_seam = 0, next_seam = 1e-12;
  size_t at_stitch = f.keys.size();
  const auto& sutures = d.metrics.sutures;
  for (size_t i = 0; i < f.seams.size(); ++i) {
    const Seam& s = f.seams[i];
    const double longer =
        std::max(path_length(bank(f, s.a_from, s.a_to, true)), path_length(bank(f, s.b_from, s.b_to, false)));
    double sum = i == 0 && !sutures.empty() ? sutures[0].force_N : 0;
    for (int n = int(parts_of_row(longer, patch.spacing_mm)) - 1; n > 0 && at_stitch < sutures.size(); --n)
      sum += sutures[at_stitch++].force_N;
    if (i == 0)
      donor_seam = sum;
    else
      next_seam = std::max(next_seam, sum);
  }
  r.figures.push_back({"donor_seam_N", donor_seam});
  r.figures.push_back({"donor_seam_over_next", donor_seam / next_seam});
  const SewnSkin sewn = sewn_skin(*d.shown, d.commands);
  r.figures.insert(r.figures.end(), {{"sewn_sum_deg", sewn.sum_deg()},
                                     {"sewn_stray_deg", sewn.stray_deg()},
                                     {"sewn_unpaired", double(sewn.unpaired)}});
  for (const auto& [name, corners] :
       {std::pair<const char*, std::vector<Corner>>{"C", {kC}}, {"E", {kE}}, {"DF", {kD, kF}}}) {
    r.figures.push_back({std::string("sewn_") + name + "_deg", sewn.charge_deg(f, corners).value_or(std::nan(""))});
    r.figures.push_back({std::string("charge_") + name + "_deg", charge_deg(*d.map, f, corners, L)});
    for (const double reach : {0.2, 0.4, 0.6}) {
      const std::string t = fmt::format("deficit_{}_{:g}_deg", name, reach);
      r.figures.push_back({t, d.map->deficit_deg(f, corners, reach * L)});
    }
    for (const double reach :
         {0.2, 0.3, 0.4, 0.5, 0.6, 0.75, 0.9}) {  // sides: the next of the three points lies one side away
      const std::string t = fmt::format("curvature_{}_{:g}_deg", name, reach);
      r.figures.push_back({t, d.map->curvature_deg(f, corners, reach * L, 0.15 * L)});
    }
  }
  // The tension, evened out over discs of 3 mm: at the donor's closure,
  // on its outer side and beyond F, and wherever else it is greatest.
  constexpr double kDisc_mm = 3, kStep_mm = 2;
  const auto at = [&](const Corner& c) { return ChartPoint(place(f, c) + kDisc_mm * tissue_bisector(f, c)); };
  const SkinMap::Stretch here = std::max(d.map->stretch(at(kD), kDisc_mm), d.map->stretch(at(kF), kDisc_mm),
                                         [](const auto& x, const auto& y) { return x.most < y.most; });
  double most = 0, elsewhere = 0;
  ChartPoint most_at{0, 0};
  for (double y = -3 * L; y <= 3 * L; y += kStep_mm)
    for (double x = -3 * L; x <= 3 * L; x += kStep_mm) {
      const ChartPoint p{x, y};
      const SkinMap::Stretch s = d.map->stretch(p, kDisc_mm);
      if (s.area_mm2 < 0.5 * std::numbers::pi * kDisc_mm * kDisc_mm) continue;
      if (s.most > most) most = s.most, most_at = p;
      if (std::min((p - place(f, kD)).norm(), (p - place(f, kF)).norm()) > 0.4 * L)
        elsewhere = std::max(elsewhere, s.most);
    }
  // The same of the largest principal Cauchy stress in the skin's plane: what pulls at the seams, where stretch alone
  // says nothing of how the skin is held across.
  const Tension tension(*d.shown);
  const double pull = std::max(tension.mean_kPa(at(kD), kDisc_mm), tension.mean_kPa(at(kF), kDisc_mm));
  double pull_elsewhere = 0;
  for (double y = -3 * L; y <= 3 * L; y += kStep_mm)
    for (double x = -3 * L; x <= 3 * L; x += kStep_mm)
      if (const ChartPoint p{x, y}; std::min((p - place(f, kD)).norm(), (p - place(f, kF)).norm()) > 0.4 * L)
        pull_elsewhere = std::max(pull_elsewhere, tension.mean_kPa(p, kDisc_mm));
  r.figures.insert(r.figures.end(), {{"stress_D_F_kPa", pull}, {"stress_elsewhere_kPa", pull_elsewhere}});
  const Vec2 closing = (place(f, kF) - place(f, kD)).normalized();
  r.figures.insert(r.figures.end(),
                   {{"stretch_D_F", here.most},
                    {"stretch_elsewhere", elsewhere},
                    {"most_at_x_mm", most_at.x()},
                    {"most_at_y_mm", most_at.y()},
                    {"most_from_D_F_mm", std::min((most_at - place(f, kD)).norm(), (most_at - place(f, kF)).norm())},
                    {"direction_off_deg", std::acos(std::min(1.0, std::abs(here.direction.head<2>().dot(closing)))) *
                                              180 / std::numbers::pi}});
  add_common(r, d);
  const std::string name = fmt::format("{:g} in {:g} degrees, {:g} %, {:g} mm", v[0], v[1], v[2], v[3]);
  r.title = name;
  return r;
}

/// Keeps the least and the largest of what is asked.
struct Range {
  double least = 1e300, most = -1e300;
  void operator()(double v) { least = std::min(least, v), most = std::max(most, v); }
};

/// Deficits of the rest metric as measured, and what geometry makes of Limberg's figure.
constexpr std::pair<const char*, double> kSewn[] = {{"sewn_C_deg", 60}, {"sewn_E_deg", 60}, {"sewn_DF_deg", -120}};

/// What Limberg's own flap must show, of the rows of one lattice.
void add_limberg(std::vector<Bar>& out, const std::vector<const Row*>& rows) {
  std::map<std::string, Range> sewn;
  Range key, share, far, off, plan, sheet, stress, seam, ears, cones, saddle, bends, slack_cones, slack_saddle;
  bool alone = false, slack = false;
  for (const Row* one : rows) {
    const Row& r = *one;
    key(r.at("key_D_F_peak_N") / r.at("other_peak_N")), share(r.at("stretch_D_F") / r.at("stretch_elsewhere"));
    far(r.at("most_from_D_F_mm") / r.at("side_mm")), off(r.at("direction_off_deg"));
    plan(std::max({std::abs(r.at("charge_C_deg") - 60), std::abs(r.at("charge_E_deg") - 60),
                   std::abs(r.at("charge_DF_deg") + 120)}));
    for (const auto& [name, charge] : kSewn)
      sewn[name](std::isfinite(r.at(name)) ? std::abs(r.at(name) - charge) : 360);
    sheet(std::abs(r.at("sewn_sum_deg")) + 360 * r.at("sewn_unpaired"));
    stress(r.at("stress_D_F_kPa") / r.at("stress_elsewhere_kPa")), seam(r.at("donor_seam_over_next"));
    if (r.at("prestretch") > 0) continue;  // tension draws cones flat
    const double least = std::min(r.at("curvature_C_0.2_deg"), r.at("curvature_E_0.2_deg"));
    if (r.at("bed") > 0) {
      slack = true;
      ears(std::min(r.at("ear_donor_mm"), r.at("ear_pivot_mm")) - r.at("at_D_F_mm"));
      slack_cones(least), slack_saddle(r.at("curvature_DF_0.6_deg"));
    } else {
      alone = true;
      cones(least), saddle(r.at("curvature_DF_0.6_deg")), bends(r.at("curvature_DF_0.9_deg") / r.at("sewn_DF_deg"));
    }
  }
  const std::string with = fmt::format("Limberg, {:g} mm cells", rows[0]->at("cell_mm"));
  const std::string who = with;
  const char* figure = "Limberg's flap: the donor's closure D-F carries the greatest tension (charge -120)";
  out.push_back(at_least(who + ": most that the donor's key stitch D-F has borne at rest over the most of any other",
                         key.least, 1, figure));
  out.push_back(
      at_least(who + ": stretch at D-F over the largest elsewhere (beyond 0.4 sides)", share.least, 1, figure));
  out.push_back(at_most(who + ": place of the largest stretch, from D or F, sides", far.most, 0.4, figure));
  out.push_back(at_most(who + ": direction of the largest stretch there, off D-F, degrees", off.most, 30,
                        "parallel to two sides of the rhombus; half of its 60 degrees"));
  out.push_back(at_most(who + ": angle deficits as cut and sewn off +60, +60, -120, degrees", plan.most, 0.5,
                        "closed form; half a degree on 4 mm is 0.03 mm of the cut edges"));
  // Where the skin's edge is cut and which places of it each stitch joins, as the model has them.
  for (const auto& [name, charge] : kSewn) {
    const std::string line = fmt::format(": rest metric at {:.{}} as sewn, off {:+g}, degrees", name + 5,
                                         int(std::string(name).size()) - 9, charge);
    out.push_back(at_most(who + line, sewn[name].most, 2,
                          "closed form; the edges lie on their grid within 8 um, and the piece that gives a direction "
                          "may be half a mm long"));
  }
  out.push_back(at_most(who + ": rest metric, sum of all deficits, degrees", sheet.most, 0.1,
                        "Gauss and Bonnet: one sheet; rounding"));
  out.push_back(at_least(who + ": largest principal Cauchy stress at D-F over that elsewhere (beyond 0.4 sides)",
                         stress.least, 1, figure));
  out.push_back(
      at_least(who + ": what the donor's seam carries over any other seam of its length", seam.least, 1, figure));
  if (slack) {
    out.push_back(at_least(who + ", slack, on fat: curvature within 0.2 sides of C and E, the smaller, degrees",
                           slack_cones.least, 0, "cones of charge +60; what the fat holds flat is lost"));
    out.push_back(at_most(who + ", slack, on fat: curvature within 0.6 sides of D-F, degrees", slack_saddle.most, 0,
                          "a saddle of charge -120; the same"));
    out.push_back(at_least(who + ", slack, on fat: lower ear (C, E) above the height at D-F, mm", ears.least, 0,
                           "cones stand up, saddles do not"));
  }
  if (alone) {
    out.push_back(at_least(who + ", slack skin alone: curvature within 0.2 sides of C and E, the smaller, degrees",
                           cones.least, 45,
                           "+60 by the theorem of Gauss and Bonnet, less the quarter that the plate's heights are good "
                           "to; farther out skin bends back to where it is held, and a loop encloses less"));
    out.push_back(at_most(who + ", slack skin alone: curvature within 0.6 sides of D-F, degrees", saddle.most, 0,
                          "a saddle of charge -120, spread by the greatest tension of all"));
    out.push_back(at_least(who + ", slack skin alone: share of the -120 at D-F that bends within 0.9 sides",
                           bends.least, 0, "the same; the rest is stretched away"));
  }
}

std::vector<Bar> bars_rhomboid(const std::vector<Row>& rows) {
  Range residual, gap;
  std::map<double, std::vector<const Row*>, std::greater<>> limberg;  // by lattice, coarse to fine
  for (const Row& r : rows) {
    residual(r.at("residual")), gap(r.at("gap_max_mm"));
    if (r.at("flap_angle") == 60 && r.at("defect_angle") == 60) limberg[r.at("cell_mm")].push_back(&r);
  }
  std::vector<Bar> out{
      at_most(english("largest relative residual"), residual.most, 1e-4, english("at rest, as in operate")),
      at_most(english("largest gap, mm"), gap.most, 0.2, english("closed"))};
  for (const auto& [cell, of_cell] : limberg) add_limberg(out, of_cell);
  return out;
}

std::vector<NamedChart> charts_rhomboid(const std::vector<Row>& rows) {
  return {chart("force", english("Strongest stitch"), rows, "flap_angle", english("angle of the flap's tip, degrees"),
                "suture_force_max_N", english("force, N"), kRhomboid),
          chart("dog-ear", english("Dog-ear at the donor's apex"), rows, "flap_angle",
                english("angle of the flap's tip, degrees"), "ear_donor_mm", english("height, mm"), kRhomboid)};
}

}  // namespace

Family rhomboid() {
  return {"rhomboid",
          english("Rhomboid flaps of 20 mm sides by the angle of their tip (60: Limberg's; less: Webster's)"),
          {{"flap_angle", "of the flap's tip, degrees", {30, 45, 60}, 20, 60},
           {"defect_angle", "of the defect, degrees; for Limberg's flap only", {60}, 40, 90},
           {"prestretch", "of the skin, percent, in all directions", {10}, 0, 30},
           {"cell_mm", "size of the lattice's cells; at most 1.5 without a bed", {5, 3.5}, 1, 8},
           {"contact", "1: wound surfaces keep each other out", {1}, 0, 1},
           {"side_mm", "of the defect and the flap", {20}, 10, 60},
           {"depth_mm", "of cut and undermining: how thick the flap is", {2}, 1.5, 8},
           {"bed", "1: on fat; 0: 1.5 mm of skin with nothing beneath it, held at three sides' lengths", {1}, 0, 1},
           {"push_mm", "height of the pushes that look for other equilibria; 0: none", {2}, 0, 10},
           {"spacing_mm", "of the stitches", {4}, 1, 8}},
          run_rhomboid,
          bars_rhomboid,
          charts_rhomboid,
          {{"rhomboid", {"flap_angle=60", "prestretch=0,5,10", "cell_mm=5,3.5"}},
           {"rhomboid", {"flap_angle=60", "prestretch=0", "bed=0", "cell_mm=1.5,1.2"}}}};
}

}  // namespace limberg::study
