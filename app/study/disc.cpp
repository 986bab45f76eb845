// A disc of skin, cut round and undermined, is free: it goes back to what it was before it was stretched.
//
// One material throughout, stretched by l1 along and l2 across with its volume kept. Tissue that cannot change its
// volume and has no hold takes the deformation F that undoes the prestretch, F F0 = I: its area shrinks by 1 - 1/(l1
// l2) everywhere, whatever the lattice. The hole that it leaves opens, more along the greater tension.
//
// The tissue of fem_model.h gives way a little in volume as well. Its stress-free state is F F0 = t I with
//   mu = p0 t - lambda t (t^3 - 1),   p0 = mu / (l1 l2)^2,   lambda = lambda_Lame + mu,
// so its area shrinks by 1 - t^2/(l1 l2): by 11 % more at Poisson's ratio 0.45 and l1 l2 = 1.155, by 1 % more at 0.495.
// The first bar is the law of constant volume, at a ratio where it is meant to hold; the second is this one, at any.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "app/assembly/operation.h"
#include "app/study/study.h"
#include "app/study/wound.h"
#include "app/words/words.h"
#include "sim/patient/soft_tissue.h"

namespace limberg::study {

namespace {

enum : size_t { kAlong, kAcross, kCell, kRadius, kDepth, kPoisson };

/// t of the stress-free state, by Newton's method from t = 1, near which it lies.
double free_stretch(const Material& m) {
  const double l = m.prestretch_along * m.prestretch_across, p0 = 1 / (l * l), lambda = m.lambda_kPa() / m.mu_kPa() + 1;
  double t = 1;
  for (int i = 0; i < 50; ++i) {
    const double f = p0 * t - lambda * t * (t * t * t - 1) - 1, df = p0 - lambda * (4 * t * t * t - 1);
    t -= f / df;
  }
  return t;
}

Row run_disc(const Values& v, const Run& with) {
  BlockSpec b;
  b.name = "disc";
  const double side = std::max(60.0, 6 * v[kRadius]);
  b.size_mm = {side, side, 2.5 * v[kDepth]};
  b.skin_cell_mm = 1.1;
  Material skin;
  skin.young_kPa = 60, skin.poisson = v[kPoisson];
  skin.prestretch_along = v[kAlong], skin.prestretch_across = v[kAcross];
  b.layers = {{"skin", b.size_mm.z(), skin}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = std::min(v[kCell], b.size_mm.z());
  World world(spec, with.workers);

  std::vector<ChartPoint> circle;
  constexpr int kCorners = 48;
  for (int i = 0; i < kCorners; ++i) {
    const double a = 2 * std::numbers::pi * (i + 0.37) / kCorners;
    circle.push_back({v[kRadius] * std::cos(a), v[kRadius] * std::sin(a)});
  }
  std::vector<ChartPoint> closed = circle;
  closed.push_back(circle[0]);
  Script script;
  script.name = "study disc";
  script.lines = {{1, Incise{closed, v[kDepth], 90}}, {2, Undermine{circle, v[kDepth]}}};
  OperationSettings set;
  set.interrupted = with.interrupted;
  const OperationOutcome o = operate(world, b.size_mm.z(), script, set);

  Snapshot s;
  world.fill(s);
  const SkinArea area = central_skin(s);
  const Hole hole = central_hole(s);
  const double t = free_stretch(skin), law = 1 - t * t / (v[kAlong] * v[kAcross]);
  const double expected = 1 - 1 / (v[kAlong] * v[kAcross]), shrink = 1 - area.now_mm2 / area.rest_mm2;
  Row row;
  row.figures = {{"along", v[kAlong]},
                 {"across", v[kAcross]},
                 {"cell_mm", v[kCell]},
                 {"radius_mm", v[kRadius]},
                 {"depth_mm", v[kDepth]},
                 {"poisson", v[kPoisson]},
                 {"pieces", double(world.skin()->pieces())},
                 {"area_mm2", area.now_mm2},
                 {"area_before_mm2", area.rest_mm2},
                 {"shrink", shrink},
                 {"expected", expected},
                 {"error", std::abs(shrink - expected) / std::max(1e-12, expected)},
                 {"expected_of_law", law},
                 {"error_of_law", std::abs(shrink - law) / std::max(1e-12, law)},
                 {"hole_growth", hole.now_mm2 / hole.rest_mm2 - 1},
                 {"hole_along_over_across", hole.extent_mm.x() / hole.extent_mm.y()},
                 {"residual", o.last.residual},
                 {"nodes", double(world.skin()->solver().model().X_mm.size())},
                 {"solve_ms", o.solve_ms}};
  return row;
}

std::vector<Bar> disc_bars(const std::vector<Row>& rows) {
  double residual = 0, error = 0, law = 0, pieces = 2, elongation = 1e300;
  for (const Row& r : rows) {
    residual = std::max(residual, r.at("residual"));
    error = std::max(error, r.at("error"));
    law = std::max(law, r.at("error_of_law"));
    if (r.at("pieces") != 2) pieces = r.at("pieces");
    if (r.at("along") > r.at("across")) elongation = std::min(elongation, r.at("hole_along_over_across"));
  }
  std::vector<Bar> out{
      at_most(english("largest relative residual"), residual, 1e-4, "the tissue counts as at rest, as in operate"),
      at_most("pieces beyond disc and bed", pieces - 2, 0, "the disc is free, and nothing else is"),
      at_most("largest error of the shrinking, relative", error, 0.03,
              "area shrinks by 1 - 1/(l1 l2): a piece without hold undoes its prestretch"),
      at_most("the same against the material's own law", law, 2e-3,
              "uniform, so every lattice holds it; 2e-3: single precision, and 0.01 mm of the solver's rest on 10 mm")};
  if (elongation < 1e300)
    out.push_back(at_least("least elongation of the hole along the greater stretch", elongation, 1,
                           "a round wound becomes an ellipse along the tension lines"));
  return out;
}

std::vector<NamedChart> disc_charts(const std::vector<Row>& rows) {
  NamedChart c;
  c.name = "disc", c.title = english("Shrinking of a freed disc");
  c.chart.description = english("Share of the area lost against 1 - 1/(l1 l2)");
  c.chart.x.title = english("1 - 1/(λ₁ λ₂)"), c.chart.y.title = english("share of the area lost");
  ChartSeries theory{"theory", {}, {}, false};
  for (const Row& r : rows) {
    const std::string name = fmt::format("cells of {:g} mm", r.at("cell_mm"));
    auto& all = c.chart.series;
    auto it = all.begin();
    while (it != all.end() && it->name != name) ++it;
    if (it == all.end()) it = all.insert(it, ChartSeries{name, {}, {}, true});
    size_t at = 0;  // by x
    while (at < it->x.size() && it->x[at] < r.at("expected")) ++at;
    it->x.insert(it->x.begin() + long(at), r.at("expected"));
    it->y.insert(it->y.begin() + long(at), r.at("shrink"));
    if (theory.x.empty() || r.at("expected") > theory.x.back()) theory.x = theory.y = {0, r.at("expected")};
  }
  c.chart.series.push_back(theory);
  return {c};
}

}  // namespace

Family disc() {
  return {"disc",
          english("A disc of stretched skin, cut round and undermined: how far it shrinks against 1 - 1/(l1 l2)"),
          {{"along", "stretch l1 that the skin carries along x", {1.05, 1.1, 1.2}, 1.005, 1.5},
           {"across", "stretch l2 across", {1.05, 1.1}, 1.005, 1.5},
           {"cell_mm", "size of the lattice's cells", {3.5, 2.5}, 1.5, 8},
           {"radius_mm", "of the disc", {10}, 4, 30},
           {"depth_mm", "of cut and undermining", {3}, 1, 8},
           {"poisson", "ratio; the first bar asks for constant volume, 0.5", {0.495}, 0.3, 0.499}},
          run_disc,
          disc_bars,
          disc_charts};
}

}  // namespace limberg::study
