// How far the edges of a sewn incision gape between its stitches, by the stitch, the spacing, the prestretch and the
// cells at the wound: an incision along y = 0 in stretched skin on fat, closed by a row of stitches, looked at over the
// two middle spacings.
//
// There is no closed form for stitches in skin on fat; cells of half the size say how far a figure is off. For a
// membrane there is one: stitches that close the edges whole over 2 `bite` each, s apart, leave a row of cracks without
// end of length 2a = s - 2 bite. Remote tension sigma opens them in the middle by
//
//   (4 sigma s / (pi E)) arccosh(1 / cos(pi a / s))
//
// (Westergaard 1939; Tada, Paris and Irwin, The stress analysis of cracks handbook, part 7), with
// sigma / E = 2 epsilon for a prestretch 1 + epsilon both ways and constant volume.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/assembly/operation.h"
#include "app/result/metrics.h"
#include "app/study/patch.h"
#include "app/study/planar_law.h"
#include "app/study/study.h"
#include "app/study/wound.h"
#include "app/words/words.h"
#include "sim/base/error.h"
#include "sim/patient/soft_tissue.h"

namespace limberg::study {

namespace {

enum : size_t {
  kStitchKind,
  kStitchSpacing,
  kStitchPrestretch,
  kStitchCell,
  kStitchHalvings,
  kStitchBite,
  kStitchMembrane
};
enum Kind { kSingle, kRunning, kBuried, kBoth };

const std::vector<std::string> kStitchParameters = {
    "kind", "spacing_mm", "prestretch_percent", "cell_mm", "halvings", "bite_mm", "membrane"};

constexpr double kStitchBlock_mm = 10, kStitchDepth_mm = 3, kBuriedDepth_mm = 1;
constexpr double kStitchLength_mm = 36;       // about: an even number of spacings
constexpr double kStitchesApart_mm = 0.6;     // of a membrane's stitches: two that are nearer than half a mm are one
constexpr int kCracks = 3;                    // of the membrane: its sides are planes of symmetry of an endless row
constexpr double kSmallStrain_percent = 0.5;  // 1 % makes the gape 2 % smaller than the linear law, 3 % 7 %

double side_mm(double cell_mm) {
  return 2 * cell_mm * std::ceil(0.5 * 3 * kStitchLength_mm / cell_mm);  // an even number of cells
}

WorldSpec skin_of(const Values& v, double cell_mm) {
  BlockSpec b;
  b.name = "stitches";
  const double side = side_mm(v[kStitchCell]);
  b.size_mm = {side, side, kStitchBlock_mm};
  b.skin_cell_mm = 1.1;
  b.layers = skin_on_fat(kStitchBlock_mm, v[kStitchPrestretch]);
  WorldSpec spec;
  spec.cell_mm = v[kStitchCell];
  if (v[kStitchMembrane] == 0) {
    spec.body = std::make_shared<Body>(make_block(b));
    spec.wound_level = int(v[kStitchHalvings]);
    spec.refine_fronts = true;
    spec.contact = ContactChoice::automatic;
    spec.suture_bite_mm = std::min(v[kStitchBite], 0.5 * v[kStitchSpacing]);
    return spec;
  }
  b.size_mm = {kCracks * v[kStitchSpacing], 2 * kCracks * v[kStitchSpacing], cell_mm};
  b.sides = {SideHold::sliding, SideHold::sliding, SideHold::sliding, SideHold::sliding, SideHold::free};
  b.layers = {b.layers[0]};
  b.layers[0].material = membrane_material(b.layers[0].material.mu_kPa(), 1 + v[kStitchPrestretch] / 100);
  auto body = std::make_shared<Body>(make_block(b));
  body->laws = laws_with_membrane();
  spec.body = body;
  spec.cell_mm = cell_mm;
  spec.suture_bite_mm = 0;
  spec.suture_k_N_per_mm = 2;  // a hundred times what the tension on a stitch stretches by a micrometre
  return spec;
}

/// Where the stitches are: an even number of them, so that the middle lies between two.
std::vector<double> places_mm(const Values& v) {
  const double spacing_mm = v[kStitchSpacing];
  const int n =
      v[kStitchMembrane] != 0 ? kCracks - 1 : 2 * std::max(1, int(std::lround(0.5 * kStitchLength_mm / spacing_mm)));
  std::vector<double> x;
  for (int i = 0; i < n; ++i) x.push_back(spacing_mm * (i - 0.5 * (n - 1)));
  return x;
}

Script sewn(const Values& v, double y_mm, double fine_mm) {
  const std::vector<double> x = places_mm(v);
  const double end = x.back() + 0.5 * v[kStitchSpacing],
               depth = v[kStitchMembrane] != 0 ? fine_mm + 1 : kStitchDepth_mm;
  Script script;
  script.name = "study stitches";
  const auto add = [&](Command c) { script.lines.push_back({int(script.lines.size()) + 1, std::move(c)}); };
  add(Incise{{{-end, y_mm}, {end, y_mm}}, depth, 90});
  constexpr double aside_mm = 0.7;
  if (v[kStitchMembrane] != 0) {
    for (const double at : x) {
      const int n = std::max(2, int(2 * v[kStitchBite] / kStitchesApart_mm));
      for (int i = 0; i <= n; ++i) {
        const double s = at + v[kStitchBite] * (2.0 * i / n - 1);
        add(Suture{{s, y_mm + aside_mm}, {s, y_mm - aside_mm}, 0});
      }
    }
    return script;
  }
  const std::vector<ChartPoint> left{{x.front(), y_mm + aside_mm}, {x.back(), y_mm + aside_mm}},
      right{{x.front(), y_mm - aside_mm}, {x.back(), y_mm - aside_mm}};
  const int kind = int(v[kStitchKind]);
  if (kind == kBuried || kind == kBoth) add(SutureRow{left, right, v[kStitchSpacing], kBuriedDepth_mm});
  if (kind != kBuried) add(SutureRow{left, right, v[kStitchSpacing], 0, kind == kRunning});
  return script;
}

/// Of the row of cracks, in the middle of one. Half of a height H belongs to each bank and its far side is held: as the
/// cracks open the tension falls by 4/3 E (mean opening) / H, the mean opening being
/// (4 sigma s / (pi E)) ln(1 / cos(pi a / s)).
double cracks_mm(const Values& v) {
  const double s = v[kStitchSpacing], a = 0.5 * s - v[kStitchBite], strain = v[kStitchPrestretch] / 100;
  if (!(a > 0)) return 0;
  const double open = 4 * s / std::numbers::pi, c = std::cos(std::numbers::pi * a / s);
  const double sigma_over_E = 2 * strain / (1 + 4.0 / 3 * open * std::log(1 / c) / (2 * kCracks * s));
  return open * sigma_over_E * std::acosh(1 / c);
}

Row run_stitches(const Values& v, const Run& with) {
  if (v[kStitchMembrane] != 0 && !(v[kStitchBite] >= kStitchesApart_mm && 2 * v[kStitchBite] < v[kStitchSpacing]))
    throw InputError(
        "", 0,
        fmt::format("study stitches: a membrane's bite_mm is {:g}; expected {:g} or more and less than half of "
                    "spacing_mm, which is {:g}",
                    v[kStitchBite], kStitchesApart_mm, v[kStitchSpacing]));
  const double fine_mm = v[kStitchCell] / std::pow(2, v[kStitchHalvings]);
  const WorldSpec spec = skin_of(v, fine_mm);
  const double y_mm = 0.5 * fine_mm;  // halves the small cells
  World world(spec, with.workers);
  OperationSettings set;
  set.interrupted = with.interrupted;
  const Script script = sewn(v, y_mm, fine_mm);
  const OperationOutcome o = operate(world, spec.body->box_max_mm.z() - spec.body->box_min_mm.z() + 2, script, set);

  auto s = std::make_shared<Snapshot>();
  world.fill(*s, true);
  std::vector<Command> done;
  for (const ScriptLine& line : script.lines) done.push_back(line.command);
  const Metrics m = measure_world(world, done);
  const StraightWound wound(*s);
  Row row;
  for (size_t i = 0; i < kStitchParameters.size(); ++i) row.figures.push_back({kStitchParameters[i], v[i]});
  row.profile.name = fmt::format("{:g}, {:g} mm, {:g} %", v[kStitchKind], v[kStitchSpacing], v[kStitchPrestretch]);
  constexpr int samples = 96;
  double mean = 0;
  for (int i = -samples / 2; i <= samples / 2; ++i) {
    const double x = 2 * v[kStitchSpacing] * i / samples, g = wound.gape_mm(x);
    row.profile.x.push_back(x), row.profile.y.push_back(g);
    mean += g * (std::abs(i) == samples / 2 ? 0.5 : 1) / samples;
  }
  std::vector<double> sorted = row.profile.y;
  std::sort(sorted.begin(), sorted.end());
  const double p95 = sorted[size_t(0.95 * samples)], most = sorted.back();
  row.figures.insert(
      row.figures.end(),
      {{"gape_between_mm", wound.gape_mm(0)},
       {"gape_at_stitch_mm", 0.5 * (wound.gape_mm(0.5 * v[kStitchSpacing]) + wound.gape_mm(-0.5 * v[kStitchSpacing]))},
       {"gape_mean_mm", mean},
       {"gape_p95_mm", p95},
       {"gape_widest_mm", most},
       {"expected_mm", v[kStitchMembrane] != 0 ? cracks_mm(v) : std::nan("")},
       {"closure_line_N_per_m", m.closure_line_N_per_m},
       {"suture_force_max_N", m.suture_force_max_N},
       {"residual", o.last.residual},
       {"nodes", double(world.skin()->solver().model().X_mm.size())},
       {"solve_ms", o.solve_ms}});
  row.title = fmt::format("stitches {:g} mm apart, {:g} % of prestretch", v[kStitchSpacing], v[kStitchPrestretch]);
  row.shown = s;
  return row;
}

bool whole_bites(const Row& r) { return r.at("membrane") != 0 || 2 * r.at("bite_mm") <= r.at("spacing_mm"); }

std::vector<Bar> stitches_bars(const std::vector<Row>& rows) {
  std::vector<Bar> out;
  double residual = 0, cracks = -1, settles = -1;
  for (const Row& r : rows) residual = std::max(residual, r.at("residual"));
  out.push_back(
      at_most(english("largest relative residual"), residual, 1e-4, "the tissue counts as at rest, as in operate"));

  const auto least_rise = [&](const char* key) {
    double rise = 1e300;
    for (const auto& g : groups(rows, key, kStitchParameters))
      for (size_t i = 1; i < g.size(); ++i)
        if (whole_bites(*g[i - 1]) && whole_bites(*g[i]))
          rise = std::min(rise, g[i]->at("gape_between_mm") - g[i - 1]->at("gape_between_mm"));
    return rise;
  };
  if (const double rise = least_rise("spacing_mm"); rise < 1e300)
    out.push_back(
        at_least("least rise of the gape with the spacing, mm", rise, 1e-3,
                 "a longer edge between two stitches of the same bite bows further; 0.001 mm is the solver's noise"));
  if (const double rise = least_rise("prestretch_percent"); rise < 1e300)
    out.push_back(at_least("least rise of the gape with prestretch, mm", rise, 1e-3,
                           "more tension parts the same edge further; 0.001 mm is the solver's noise"));

  for (const auto& g : groups(rows, "halvings", kStitchParameters)) {
    if (g.size() < 2) continue;
    const Row &fine = *g[g.size() - 1], &coarse = *g[g.size() - 2];
    if (fine.at("halvings") - coarse.at("halvings") != 1) continue;
    if (fine.at("membrane") == 0) {
      settles = std::max(settles, std::abs(1 - coarse.at("gape_mean_mm") / fine.at("gape_mean_mm")));
    } else if (fine.at("prestretch_percent") <= kSmallStrain_percent) {
      const double limit = 2 * fine.at("gape_between_mm") - coarse.at("gape_between_mm");
      cracks = std::max(cracks, std::abs(limit / fine.at("expected_mm") - 1));
    }
  }
  if (cracks >= 0)
    out.push_back(at_most(
        "membrane: gape between two stitches against a row of cracks, relative", cracks, 0.05,
        "extrapolated by order 1 from the last two cells, as the end of a crack asks, where strain goes as "
        "1 over the root of the distance; 0.05: what was left of three cells, 0.03 on 2026-11-27, and as much"));
  if (settles >= 0)
    out.push_back(at_most("on fat: the mean gape's change with the last halving, relative", settles, 0.4,
                          "order 1: about as much again is to come; 0.33 at 6 mm and 10 % on 2026-11-27"));
  return out;
}

std::vector<NamedChart> stitches_charts(const std::vector<Row>& rows) {
  NamedChart along;
  along.name = "gape-between", along.title = english("Gape along the two middle spacings");
  along.chart.description = english("Gape along the wound, one line for each member");
  along.chart.x.title = english("along the wound, mm"), along.chart.y.title = english("gape, mm"),
  along.chart.y.min = 0;
  for (const Row& r : rows) along.chart.series.push_back(r.profile);
  return {chart("gape-spacing", english("Gape in the middle between two stitches"), rows, "spacing_mm",
                english("spacing, mm"), "gape_between_mm", english("gape, mm"), kStitchParameters),
          along};
}

}  // namespace

Family stitches() {
  return {"stitches",
          english("A sewn incision in stretched skin: how far its edges gape between the stitches"),
          {{"kind",
            "0: single stitches, 1: one running thread, 2: buried 1 mm deep, 3: single over buried",
            {0, 1, 2, 3},
            0,
            3},
           {"spacing_mm", "of the stitches", {4, 6, 8}, 2, 24},
           {"prestretch_percent", "of the skin, alike along and across the wound", {5, 10}, 0.1, 30},
           {"cell_mm", "size of the lattice's cells", {5}, 2, 8},
           {"halvings", "of the cells at the wound", {3}, 0, 3},
           {"bite_mm", "of skin that a stitch holds, at most half the spacing", {2}, 0, 8},
           {"membrane",
            "1: a membrane that is closed over twice the bite at each stitch, to compare with a row of cracks",
            {0},
            0,
            1}},
          run_stitches,
          stitches_bars,
          stitches_charts,
          {{"stitches", {}},
           {"stitches", {"kind=0", "spacing=4,6", "prestretch=10", "halvings=2,3"}},
           {"stitches", {"kind=0", "spacing=20", "prestretch=0.2", "halvings=1,2", "bite=5", "membrane=1"}}}};
}

}  // namespace limberg::study
