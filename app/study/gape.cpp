// How far a straight incision gapes, by the blade's angle and the skin's prestretch.
//
// A block of skin on fat, stretched alike in both directions, cut along y = 0. Everything in it is the mirror image of
// itself at that plane: the block has an odd number of cells across, so the cut halves a row of cells. So an upright
// blade must open it evenly, on the average along it, and a leaning one, which undercuts one bank, must not.
#include <fmt/format.h>

#include <cmath>

#include "app/assembly/operation.h"
#include "app/study/study.h"
#include "app/study/wound.h"
#include "app/words/words.h"
#include "sim/patient/soft_tissue.h"

namespace limberg::study {

namespace {

enum : size_t { kAngle, kPrestretch, kGapeCell, kLength, kGapeDepth, kRefine };

// The sides are three wounds apart, where a slit's field has fallen to a tenth.
constexpr double kGapeBlock_mm = 10, kGapeSkinCell_mm = 1.1;  // about: an odd number of them too

double odd_multiple(double cell, double about) {
  const int n = int(std::lround(about / cell));
  return cell * (n % 2 ? n : n + 1);
}

Row run_gape(const Values& v, const Run& with) {
  BlockSpec b;
  b.name = "gape";
  const double side = odd_multiple(v[kGapeCell], std::max(80.0, 3 * v[kLength]));
  b.size_mm = {side, side, kGapeBlock_mm};
  b.skin_cell_mm = side / std::round(odd_multiple(kGapeSkinCell_mm, side) / kGapeSkinCell_mm);
  b.layers = skin_on_fat(kGapeBlock_mm, v[kPrestretch]);
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = v[kGapeCell];
  spec.refine_fronts = v[kRefine] != 0;
  World world(spec, with.workers);

  Script script;
  script.name = "study gape";
  script.lines.push_back({1, Incise{{{-v[kLength] / 2, 0}, {v[kLength] / 2, 0}}, v[kGapeDepth], v[kAngle]}});
  OperationSettings set;
  set.interrupted = with.interrupted;
  const OperationOutcome o = operate(world, kGapeBlock_mm, script, set);

  Snapshot s;
  world.fill(s);
  const StraightWound wound(s);
  Row row;
  row.figures = {{"angle_deg", v[kAngle]},    {"prestretch_percent", v[kPrestretch]},
                 {"cell_mm", v[kGapeCell]},   {"length_mm", v[kLength]},
                 {"depth_mm", v[kGapeDepth]}, {"refine_fronts", v[kRefine]}};
  const std::string name = fmt::format("{:g}°, {:g} %", v[kAngle], v[kPrestretch]);
  row.profile.name = name;
  double most = 0, left_sum = 0, right_sum = 0;
  for (int i = -24; i <= 24; ++i) {
    const double x = v[kLength] / 2 * i / 24.0, g = wound.gape_mm(x);
    row.profile.x.push_back(x), row.profile.y.push_back(g);
    most = std::max(most, g);
    const auto l = wound.left(x), r = wound.right(x);
    if (l && r) left_sum += l->moved_mm().y(), right_sum -= r->moved_mm().y();
  }
  const double nan = std::nan(""), q = v[kLength] / 4;
  const auto l = wound.left(0), r = wound.right(0);
  const double left = l ? l->moved_mm().y() : nan, right = r ? -r->moved_mm().y() : nan;
  row.figures.insert(row.figures.end(), {{"gape_mid_mm", wound.gape_mm(0)},
                                         {"gape_max_mm", most},
                                         {"gape_quarter_mm", (wound.gape_mm(q) + wound.gape_mm(-q)) / 2},
                                         {"left_mm", left},
                                         {"right_mm", right},
                                         {"step_mm", l && r ? l->x_mm.z() - r->x_mm.z() : nan},
                                         {"asymmetry", std::abs(left_sum - right_sum) /
                                                           std::max(1e-12, std::abs(left_sum) + std::abs(right_sum))},
                                         {"residual", o.last.residual},
                                         {"nodes", double(world.skin()->solver().model().X_mm.size())},
                                         {"solve_ms", o.solve_ms}});
  return row;
}

std::vector<Bar> gape_bars(const std::vector<Row>& rows) {
  std::vector<Bar> out;
  double residual = 0, upright = -1, leaning = 1e300, rise = 1e300;
  for (const Row& a : rows) {
    residual = std::max(residual, a.at("residual"));
    const bool opens = a.at("prestretch_percent") > 0;
    if (a.at("angle_deg") == 90 && opens) upright = std::max(upright, a.at("asymmetry"));
    if (std::abs(a.at("angle_deg") - 90) >= 40 && opens) leaning = std::min(leaning, a.at("asymmetry"));
    for (const Row& b : rows) {
      bool same = true;
      for (const char* k : {"angle_deg", "cell_mm", "length_mm", "depth_mm", "refine_fronts"})
        same &= a.at(k) == b.at(k);
      if (same && b.at("prestretch_percent") > a.at("prestretch_percent"))
        rise = std::min(rise, b.at("gape_mid_mm") - a.at("gape_mid_mm"));
    }
  }
  out.push_back(
      at_most(english("largest relative residual"), residual, 1e-4, "the tissue counts as at rest, as in operate"));
  if (upright >= 0)
    out.push_back(
        at_most("90 degrees: difference of the banks over the gape", upright, 0.01,
                "the patient is its own mirror image; a blade's points lie up to 0.008 mm to either side of the "
                "border of two small cells, and the one that holds its end ties its bank: even along the wound, "
                "up to 0.03 at one place"));
  if (leaning < 1e300)
    out.push_back(at_least("40 degrees and more from upright: difference of the banks over the gape", leaning, 0.01,
                           "the undercut bank is thinner: more than the upright blade's tolerance"));
  if (rise < 1e300)
    out.push_back(at_least("least rise of the gape with prestretch, mm", rise, 1e-3,
                           "more tension parts the same wound further; 0.001 mm is the solver's noise"));
  return out;
}

std::vector<NamedChart> gape_charts(const std::vector<Row>& rows) {
  NamedChart by, along;
  by.name = "gape", by.title = english("Gape at the middle");
  by.chart.description = english("Gape at the middle against prestretch, one line for each angle of the blade");
  by.chart.x.title = english("prestretch, %"), by.chart.y.title = english("gape, mm");
  by.chart.y.min = 0;
  for (const Row& r : rows) {
    std::string name = fmt::format("{:g}°", r.at("angle_deg"));
    for (const char* k : {"cell_mm", "length_mm", "depth_mm", "refine_fronts"})  // named where they differ
      for (const Row& other : rows)
        if (other.at(k) != r.at(k)) {
          name += fmt::format(", {:.3g}", r.at(k));
          break;
        }
    auto& all = by.chart.series;
    auto it = all.begin();
    while (it != all.end() && it->name != name) ++it;
    if (it == all.end()) it = all.insert(it, ChartSeries{name, {}, {}, true});
    it->x.push_back(r.at("prestretch_percent"));
    it->y.push_back(r.at("gape_mid_mm"));
  }
  along.name = "gape-along", along.title = english("Gape along the wound");
  along.chart.description = english("Gape along the wound, one line for each member");
  along.chart.x.title = english("along the wound, mm"), along.chart.y.title = english("gape, mm");
  for (const Row& r : rows) along.chart.series.push_back(r.profile);
  return {by, along};
}

}  // namespace

Family gape() {
  return {"gape",
          english("A straight incision in stretched skin: how far it gapes, by the blade's angle and the prestretch"),
          {{"angle_deg", "between blade and skin, 90 = upright", {90, 60, 45}, 30, 150},
           {"prestretch_percent", "of the skin, alike along and across the wound", {5, 10, 20}, 0, 40},
           {"cell_mm", "size of the lattice's cells", {2.5}, 1.5, 8},
           {"length_mm", "of the incision", {40}, 10, 60},
           {"depth_mm", "of the incision; the skin is 1.5 mm thick", {3}, 1, 8},
           {"refine_fronts", "1: cells in which the cut ends are divided, 0: they are not", {1}, 0, 1}},
          run_gape,
          gape_bars,
          gape_charts};
}

}  // namespace limberg::study
