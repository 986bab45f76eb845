// What must come out of Z-plasties: a protocol for simulators that claim the classical
// statements, and reference figures of two models that were computed for it with other programs:
//   a planar membrane of triangles (neo-Hookean, constant volume,
//   disc of six limbs, sutured node to node, ten elements to a limb),
//   and a plate of the same law with bending on a one-sided bed
//   (thickness 0.075 limbs). The membrane's figures are good to 3 %;
//   the plate's heights to 25 % and its thresholds to 10 degrees.
//
// A bar that begins with a number is the protocol's, of that clause, and asks what it asks:
//   1   10 limbs square, skin elements of at most 2.5 mm (eight to
//       a limb of 20 mm), undermined 1.5 to 2 limbs; 0, 5 and 10 %
//       of prestretch; 30, 45, 60, 75 and 90 degrees; two lattices
//   2   the three edge maps; gaps below 0.2 mm; relative residual 1e-4
//   3   what is to be told (kReported)
//   4a  elongation rises strictly from 30 to 75 degrees in all settings, each within (1, sqrt(5 - 4 cos angle)]
//   4b  the planar control (prestretch none): gain over theory 0.53 +- 0.05; elongation within 3 % of the membrane's
//   4c  dog-ears rise with the angle and are highest at the ends of the central limb, not at the flaps' tips
//   4d  an efficiency index - gain over the 99th percentile of the strain, times
//       the sine; or gain over the dog-ear; or gain over the root of the work -
//       peaks inside 50 to 75 degrees: one of them is asked for, not each
//   4e  the dog-ear at 90 degrees above 1.2 times that at 60; without
//       prestretch the gain from 75 to 90 below half of that from 45 to 60
//   4f  at 10 %: 45 and 60 degrees flat (below 0.5 mm), 90 above 2 mm; without
//       prestretch all stand up (above 1 mm), the higher the larger the angle;
//       heights within 25 % and elongations within 3 % of the plate's
// A bar without a number is our own.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "app/study/patch.h"
#include "app/study/zplasty.h"

namespace limberg::study {

namespace {

constexpr const char* kProtocol = "protocol";

struct Reference {
  double angle, prestretch, elongation, open;  // open: of the wound before it is sewn; 0: not known
};
constexpr Reference kMembrane[] = {{20, 0, 1.061, 0},      {30, 0, 1.128, 0},      {45, 0, 1.254, 0},
                                   {50, 0, 1.299, 0},      {60, 0, 1.390, 0},      {70, 0, 1.484, 0},
                                   {75, 0, 1.528, 0},      {80, 0, 1.571, 0},      {90, 0, 1.648, 0},
                                   {20, 10, 1.064, 1.121}, {30, 10, 1.135, 1.178}, {45, 10, 1.269, 1.258},
                                   {50, 10, 1.318, 1.283}, {60, 10, 1.416, 1.327}, {70, 10, 1.516, 1.363},
                                   {75, 10, 1.564, 1.380}, {80, 10, 1.611, 1.394}, {90, 10, 1.696, 1.418}};

struct Height {
  double angle, prestretch, height_mm, elongation;  // height of a limb of 20 mm
};
constexpr Height kPlate[] = {{30, 0, 3.8, 1.101},  {45, 0, 6.8, 1.174},  {60, 0, 9.2, 1.256}, {75, 0, 11, 1.324},
                             {90, 0, 12, 1.356},   {30, 5, 0, 1.134},    {45, 5, 0, 1.259},   {60, 5, 2.6, 1.396},
                             {75, 5, 5.3, 1.513},  {90, 5, 7.5, 1.594},  {45, 10, 0, 1.272},  {60, 10, 0, 1.412},
                             {75, 10, 2.1, 1.563}, {90, 10, 4.4, 1.681}, {75, 15, 0, 1.581},  {90, 15, 2.7, 1.724}};

/// What the protocol wants to be told of every member: gain in space and in the plane, far field, strain, force, work,
/// and the five measures of what is not flat.
constexpr const char* kReported[] = {"elongation",      "elongation_flat", "elongation_4L",      "strain_p95",
                                     "strain_p99",      "closure_force_N", "suture_force_max_N", "closing_uJ",
                                     "ear_mm",          "ear_limbs",       "ear_volume_mm3",     "rms_mm",
                                     "curvature_A_deg", "curvature_B_deg", "slack_share"};

/// Rows of one setting but the angle.
struct Group {
  std::vector<const Row*> rows;  // by angle
  double at(double angle, const char* what) const {
    for (const Row* r : rows)
      if (r->at("angle") == angle) return r->at(what);
    return std::nan("");
  }
  double prestretch() const { return rows[0]->at("prestretch"); }
};

std::vector<Group> groups_of(const std::vector<Row>& rows) {
  std::vector<Group> out;
  for (auto& g : groups(rows, "angle", {"angle", "prestretch", "cell_mm", "contact", "depth_mm", "bed"}))
    out.push_back({std::move(g)});
  return out;
}

/// Keeps the worst of some values; nothing when there were none.
struct Worst {
  std::optional<double> least, most;
  void operator()(double v) {
    if (!std::isfinite(v)) return;
    least = std::min(least.value_or(v), v), most = std::max(most.value_or(v), v);
  }
};

void add_rest(std::vector<Bar>& out, const std::vector<Row>& rows) {
  Worst residual, gap, turned, opening, step, tip;
  for (const Row& r : rows)
    residual(r.at("residual")), gap(r.at("gap_max_mm")), turned(r.at("turned_share")),
        opening(r.at("least_opening_deg")), step(r.at("most_step_mm")), tip(r.at("most_tip_mm"));
  if (residual.most)
    out.push_back(at_most("2  largest relative residual", *residual.most, 1e-4, "protocol: equilibrium"));
  if (gap.most) out.push_back(at_most("2  largest gap of a stitch, mm", *gap.most, 0.2, "protocol: closed"));
  if (turned.most)
    out.push_back(at_most("   largest share of skin that lies on its side", *turned.most, 0.01,
                          "flaps lie beside each other; a cone of 90 degrees is no steeper than 41"));
  if (opening.least)
    out.push_back(at_least("   least angle between the banks at a stitch, degrees", *opening.least, 60,
                           "180 is flat, 0 is one on the other; a cone of 90 degrees opens by 97"));
  if (step.most)
    out.push_back(at_most("   largest step between the edges at a stitch, mm", *step.most, 1.5,
                          "the skin's thickness: beyond it skin does not meet skin"));
  if (tip.most)
    out.push_back(at_most("   farthest tip of a flap from its corner, mm", *tip.most, 3,
                          "twice the skin's thickness; the stitch holds both 0.9 mm from it"));
}

void add_elongation(std::vector<Bar>& out, const std::vector<Row>& rows) {
  Worst rise, elongation, over;
  for (const Group& g : groups_of(rows))
    for (size_t i = 1; i < g.rows.size(); ++i)
      if (g.rows[i]->at("angle") <= 75) rise(g.rows[i]->at("elongation") - g.rows[i - 1]->at("elongation"));
  for (const Row& r : rows) elongation(r.at("elongation")), over(r.at("elongation") / r.at("theory"));
  if (rise.least)
    out.push_back(at_least("4a least rise of the elongation from angle to angle, to 75", *rise.least, 0,
                           "protocol: rises strictly, in all settings"));
  if (elongation.least)
    out.push_back(at_least("4a least elongation", *elongation.least, 1, "protocol: a Z-plasty lengthens"));
  if (over.most)
    out.push_back(at_most("4a largest elongation over theory", *over.most, 1,
                          "protocol: sqrt(5 - 4 cos angle), without any resistance"));
}

/// Where a figure over the angle is greatest: the vertex of the
/// parabola through the greatest and its neighbours, as the angles
/// tried are 15 degrees apart; the end where it is greatest at an end.
template <class What>
double peak_at(const Group& g, What what) {
  size_t k = 0;
  for (size_t i = 1; i < g.rows.size(); ++i)
    if (what(*g.rows[i]) > what(*g.rows[k])) k = i;
  const double x = g.rows[k]->at("angle");
  if (k == 0 || k + 1 == g.rows.size()) return x;
  const double a = g.rows[k - 1]->at("angle") - x, b = g.rows[k + 1]->at("angle") - x, y = what(*g.rows[k]),
               fa = (what(*g.rows[k - 1]) - y) / a, fb = (what(*g.rows[k + 1]) - y) / b;
  const double curve = (fb - fa) / (b - a), slope = fa - curve * a;
  return curve < 0 ? x - slope / (2 * curve) : x;
}

void add_heights(std::vector<Bar>& out, const std::vector<Row>& rows) {
  Worst rise, tips, ratio, saturation, flat, over, high, none, with_tension, sixty, slack_rise;
  int settings = 0, no_index = 0;
  const auto inside = [](double angle) { return angle >= 50 && angle <= 75; };
  // Lips that the stitches raise beside every seam, at saddles too, are no dog-ear, and grow with the tension.
  const auto above_lips = [](const Group& g, double angle) { return g.at(angle, "ear_mm") - g.at(angle, "at_C_D_mm"); };
  for (const Group& g : groups_of(rows)) {
    const double p = g.prestretch();
    for (size_t i = 0; i < g.rows.size(); ++i) {
      const Row& r = *g.rows[i];
      if (i) rise(r.at("ear_mm") - g.rows[i - 1]->at("ear_mm"));
      if (i && p == 0) slack_rise(r.at("ear_mm") - g.rows[i - 1]->at("ear_mm"));
      if (r.at("ear_mm") > 0.5) tips(r.at("at_C_D_mm") - r.at("ear_mm"));  // flat ones stand nowhere
      if (p == 0) none(r.at("ear_mm"));
      for (const Group& h : groups_of(rows))  // the same with more tension
        if (h.rows[0]->at("cell_mm") == r.at("cell_mm") && h.prestretch() > p)
          with_tension(above_lips(h, r.at("angle")) - above_lips(g, r.at("angle")));
    }
    if (g.rows.size() >= 4) {
      ++settings;
      const auto strain = [](const Row& r) { return r.at("efficiency"); };
      const auto root = [](const Row& r) { return r.at("gain_per_root_work"); };
      no_index += !inside(peak_at(g, strain)) && !inside(peak_at(g, root)) && !inside(peak_at(g, gain_per_ear));
    }
    ratio(g.at(90, "ear_mm") / std::max(g.at(60, "ear_mm"), 1e-3));
    if (p == 0)
      saturation((g.at(90, "elongation") - g.at(75, "elongation")) / (g.at(60, "elongation") - g.at(45, "elongation")));
    if (p == 10)
      flat(g.at(45, "ear_mm")), flat(g.at(60, "ear_mm")), over(above_lips(g, 45)), over(above_lips(g, 60)),
          high(g.at(90, "ear_mm")), sixty(g.at(60, "ear_mm"));
  }
  if (rise.least)
    out.push_back(at_least("4c least rise of the dog-ear from angle to angle, mm", *rise.least, 0,
                           "protocol: rises with the angle"));
  if (tips.most)
    out.push_back(at_most("4c height at the flaps' tips less that at the limb's ends, mm", *tips.most, 0,
                          "protocol: cones at the limb's ends (charge +angle), saddles at the tips"));
  if (with_tension.most)
    out.push_back(at_most("   largest rise of the dog-ear, above the seams at the tips, with the prestretch, mm",
                          *with_tension.most, 0.05, "tension flattens; 0.05 mm is the lattice's noise"));
  if (settings)
    out.push_back(at_most("4d settings in which none of the three efficiency indices peaks inside 50 to 75 degrees",
                          no_index, 0, "protocol: one of them does"));
  if (ratio.least) out.push_back(at_least("4e dog-ear at 90 over 60 degrees, least", *ratio.least, 1.2, kProtocol));
  if (saturation.most)
    out.push_back(at_most("4e no prestretch: gain from 75 to 90 over that from 45 to 60", *saturation.most, 0.5,
                          "protocol: the ears eat the gain"));
  if (flat.most)
    out.push_back(at_most("4f 10 % prestretch: dog-ear at 45 and 60 degrees, mm", *flat.most, 0.5,
                          "protocol: flat; the plate is so to 65 degrees"));
  if (over.most)
    out.push_back(at_most("   the same above the seams at the flaps' tips, mm", *over.most, 0.5,
                          "the plate has no lips at its seams: stitches pull above the middle of what they join and "
                          "raise both banks, at saddles too"));
  if (sixty.most)
    out.push_back(at_most("   10 % prestretch: dog-ear at 60 degrees, mm", *sixty.most, 1,
                          "the classical statement: flat; skin stands up from 1 mm on"));
  if (high.least)
    out.push_back(at_least("   10 % prestretch: dog-ear at 90 degrees stands up, mm", *high.least, 1,
                           "the classical statement: a dog-ear; the same"));
  if (high.least)
    out.push_back(
        at_least("4f 10 % prestretch: dog-ear at 90 degrees, mm", *high.least, 2, "protocol; the plate has 4.4 mm"));
  if (slack_rise.least)
    out.push_back(at_least("4f no prestretch: least rise of the dog-ear from angle to angle, mm", *slack_rise.least, 0,
                           "protocol: every angle has one, and heights rise with the angle"));
  if (none.least)
    out.push_back(at_least("4f no prestretch: least dog-ear of any angle, mm", *none.least, 1,
                           "protocol: every angle has one; it counts from 1 mm on"));
}

/// The same members on the finest lattice and on the next: largest relative change of the elongation, and root of the
/// mean square of the change of the dog-ear relative to the mean height.
void add_lattices(std::vector<Bar>& out, const std::vector<Row>& rows) {
  Worst cells;
  for (const Row& r : rows) cells(r.at("cell_mm"));
  if (!cells.least) return;
  out.push_back(at_most("1  cells of the finest lattice, mm", *cells.least, 2.5, "protocol: eight elements to a limb"));
  Worst side, least, most;
  for (const Row& r : rows)
    side(r.at("side_limbs")), least(r.at("undermined_least_limbs")), most(r.at("undermined_most_limbs"));
  if (side.least) out.push_back(at_least("1  side of the skin, limbs", *side.least, 10, "protocol: 10 limbs square"));
  if (least.least) {
    out.push_back(
        at_least("1  undermined from the middle, least, limbs", *least.least, 1.5, "protocol: 1.5 to 2 limbs"));
    out.push_back(at_most("1  undermined from the middle, most, limbs", *most.most, 2,
                          "the same; at 90 degrees the flaps' own corners lie 1.12 limbs from the middle"));
  }
  // Five angles, three prestretches, two lattices.
  std::map<std::pair<double, double>, int> lattices;
  for (const Row& r : rows) ++lattices[{r.at("angle"), r.at("prestretch")}];
  int missing = 0;
  for (const double angle : {30, 45, 60, 75, 90})
    for (const double p : {0, 5, 10}) {
      const auto there = lattices.find({angle, p});
      missing += std::max(0, 2 - (there == lattices.end() ? 0 : there->second));
    }
  out.push_back(at_most("1  members of the protocol that are missing (5 angles, 0, 5 and 10 %, 2 lattices)", missing, 0,
                        kProtocol));
  Worst edges;
  for (const Row& r : rows) edges(r.at("charge_off_deg"));
  if (edges.most)
    out.push_back(
        at_most("2  angle deficits as cut and sewn off + + - - the angle, degrees", *edges.most, 0.5,
                "protocol: the three edge maps; closed form, half a degree on 4 mm is 0.03 mm of the cut edges"));
  int untold = 0;
  for (const Row& r : rows)
    for (const char* name : kReported) untold += !std::isfinite(r.at(name));
  out.push_back(at_most("3  figures that the protocol asks for and no member tells", untold, 0, kProtocol));
  Worst coarser;
  for (const Row& r : rows)
    if (r.at("cell_mm") > *cells.least) coarser(r.at("cell_mm"));
  if (!coarser.least) return;
  Worst elongation;
  double square = 0, mean = 0;
  int n = 0;
  for (const Row& fine : rows)
    for (const Row& coarse : rows) {
      if (fine.at("cell_mm") != *cells.least || coarse.at("cell_mm") != *coarser.least ||
          fine.at("angle") != coarse.at("angle") || fine.at("prestretch") != coarse.at("prestretch"))
        continue;
      elongation(std::abs(fine.at("elongation") / coarse.at("elongation") - 1));
      square += std::pow(fine.at("ear_mm") - coarse.at("ear_mm"), 2), mean += fine.at("ear_mm"), ++n;
      break;
    }
  if (!elongation.most) return;
  out.push_back(at_most("   largest change of an elongation from the coarser lattice, relative", *elongation.most, 0.03,
                        "no more than the protocol allows against the plate"));
  out.push_back(at_most("   change of the dog-ears from the coarser lattice, relative",
                        std::sqrt(square / n) / (mean / n), 0.25, "the same"));
}

/// Heights and elongations against the plate's, each.
void add_plate(std::vector<Bar>& out, const std::vector<Row>& rows, const std::string& who) {
  Worst standing, flat, elongation;
  for (const Row& r : rows)
    for (const Height& h : kPlate) {
      if (h.angle != r.at("angle") || h.prestretch != r.at("prestretch")) continue;
      if (h.height_mm > 0)
        standing(std::abs(r.at("ear_mm") / h.height_mm - 1));
      else
        flat(r.at("ear_mm"));
      elongation(std::abs(r.at("elongation") / h.elongation - 1));
    }
  if (elongation.most)
    out.push_back(at_most("4f elongation against the plate's, " + who + ", relative", *elongation.most, 0.03,
                          "protocol: 3 % on the elongation"));
  if (standing.most)
    out.push_back(at_most("4f height against the plate's where it stands up, " + who + ", relative", *standing.most,
                          0.25, "protocol: 25 % on heights"));
  if (flat.most)
    out.push_back(at_most("4f height where the plate is flat, " + who + ", mm", *flat.most, 0.5,
                          "protocol: flat is below 0.5 mm"));
}

}  // namespace

std::vector<Bar> bars_planar(const std::vector<Row>& rows) {
  std::vector<Bar> out;
  add_rest(out, rows);
  add_elongation(out, rows);
  Worst gain, error, open, height;
  for (const Row& r : rows) {
    if (r.at("prestretch") == 0) gain(r.at("gain_of_theory"));
    height(r.at("rms_mm"));
    for (const Reference& x : kMembrane) {
      if (x.angle != r.at("angle") || x.prestretch != r.at("prestretch")) continue;
      error(std::abs(r.at("elongation") / x.elongation - 1));
      if (x.open > 0) open(std::abs(r.at("open_elongation") / x.open - 1));
    }
  }
  if (gain.least) {
    out.push_back(at_least("4b planar: gain over theory, least", *gain.least, 0.48, "protocol: 0.53 +- 0.05"));
    out.push_back(at_most("4b planar: gain over theory, largest", *gain.most, 0.58, "protocol: 0.53 +- 0.05"));
  }
  if (error.most)
    out.push_back(at_most("4b planar: elongation against the membrane, relative", *error.most, 0.03,
                          "protocol: 3 % of the membrane of triangles"));
  if (open.most)
    out.push_back(
        at_most("4b planar: the open wound's length against the membrane, relative", *open.most, 0.03, "the same"));
  if (height.most)
    out.push_back(at_most("4b planar: root of the mean square of the height, mm", *height.most, 1e-3, "it has none"));
  return out;
}

std::vector<Bar> bars_plate(const std::vector<Row>& rows) {
  std::vector<Bar> out;
  add_rest(out, rows);
  add_elongation(out, rows);
  add_heights(out, rows);
  add_plate(out, rows, "skin alone");
  return out;
}

std::vector<Bar> bars_z(const std::vector<Row>& rows) {
  std::vector<Bar> out;
  add_lattices(out, rows);
  add_rest(out, rows);
  add_elongation(out, rows);
  add_heights(out, rows);
  add_plate(out, rows, "on fat");
  return out;
}

}  // namespace limberg::study
