#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/study/flaps.h"
#include "app/study/patch.h"
#include "sim/tools/procedures/catalogue.h"

namespace limberg::study {

namespace {

// ---- Rhomboid flaps

const std::vector<std::string> kRhomboid{"flap_angle", "defect_angle", "prestretch", "cell_mm"};

Row run_rhomboid(const Values& v, const Run& with) {
  const double L = 20;
  // Webster's construction with any tip; at 60 degrees of flap and defect, Limberg's own figure.
  const Figure f = v[0] == 60 ? find_procedure("rhomboid").figure({L, v[1]}) : find_procedure("webster").figure({L, v[0]});
  const Done d = carry_out_on({.side_mm = 140, .prestretch_percent = v[2], .cell_mm = v[3], .undermine_mm = 14}, f, with);
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

}  // namespace

Family rhomboid() {
  return {"rhomboid", "Rhomboid flaps of 20 mm sides by the angle of their tip (60: Limberg's; less: Webster's)",
          {{"flap_angle", "of the flap's tip, degrees", {30, 45, 60}, 20, 60},
           {"defect_angle", "of the defect, degrees; for Limberg's flap only", {60}, 40, 90},
           {"prestretch", "of the skin, percent, in all directions", {10}, 0, 30},
           {"cell_mm", "size of the lattice's cells", {4}, 2, 8}},
          run_rhomboid, bars_rhomboid, charts_rhomboid};
}

}  // namespace limberg::study
