// Layers thinner than a cell: 1.5 mm of skin in cells of 3 mm.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/model/box_model.h"
#include "sim/fem/solver/elastic_solver.h"
#include "tests/bench/laws.h"
#include "tests/bench/layered_block.h"

namespace limberg::bench {
namespace {

constexpr double kSkin_mm = 1.5;

enum class Load { hook, beam };
struct LayerCase {
  const char* name;
  Load load;
  Vec3 size_mm;
  double force_mN;  // in all
};
constexpr double kPatch_mm = 6;

/// Cells of h mm, held by its end or by its bottom and sides.
FemModel block(const LayerCase& c, double h, double skin_kPa, double nu) {
  LayeredBlock b;
  b.cells = {int(std::lround(c.size_mm[0] / h)), int(std::lround(c.size_mm[1] / h)),
             int(std::lround(c.size_mm[2] / h))};
  b.size_mm = c.size_mm, b.skin_mm = kSkin_mm, b.skin_kPa = skin_kPa, b.poisson = nu;
  FemModel m = layered_block(b);
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    const Vec3& X = std::as_const(m.X_mm)[i];
    m.fixed.set(i, c.load == Load::beam ? X[0] < -0.5 * c.size_mm[0] + 1e-9
                                        : X[2] < 1e-9 || std::fabs(X[0]) > 0.5 * c.size_mm[0] - 1e-9 ||
                                              std::fabs(X[1]) > 0.5 * c.size_mm[1] - 1e-9);
  }
  return m;
}

/// The mean displacement of where the load is, under a load of the
/// given force spread evenly (springs so long that it stays). Hook:
/// up, on a square of the skin. Beam: down, on the whole end.
struct LayerAnswer {
  double moved_mm = 0, ms = 0, residual = 0;
  size_t nodes = 0;
};
LayerAnswer answer(const LayerCase& c, double h, double skin_kPa, double nu) {
  const FemModel m = block(c, h, skin_kPa, nu);
  std::vector<HeldPlace> at;
  std::vector<Vec3> X;
  constexpr double step = 0.75;  // the same points on every mesh, in the middle of squares
  if (c.load == Load::hook) {
    for (double x = -kPatch_mm / 2 + step / 2; x < kPatch_mm / 2; x += step)
      for (double y = -kPatch_mm / 2 + step / 2; y < kPatch_mm / 2; y += step) X.push_back({x, y, c.size_mm[2]});
  } else {
    for (double y = -c.size_mm[1] / 2 + step / 2; y < c.size_mm[1] / 2; y += step)
      for (double z = step / 2; z < c.size_mm[2]; z += step) X.push_back({c.size_mm[0] / 2, y, z});
  }
  std::vector<Spring> springs;
  constexpr double far_mm = 1e4;
  for (const Vec3& x : X) {
    Spring s;
    s.id = int32_t(springs.size()) + 1, s.to_world = true, s.a = embed(m, x);
    s.k_N_per_mm = c.force_mN * 1e-3 / double(X.size()) / far_mm;
    s.target_mm = x + Vec3(0, 0, c.load == Load::hook ? far_mm : -far_mm);
    springs.push_back(s);
    at.push_back(s.a);
  }
  InlineWorkers one;
  auto solver = make_solver(one);
  solver->set_model(std::make_shared<FemModel>(m), {});
  solver->set_springs(springs);
  StepSettings s;
  s.max_iterations = 1500, s.tolerance = 3e-6;
  LayerAnswer a;
  const double start = cpu_ms();
  a.residual = solver->step(s).residual;
  a.ms = cpu_ms() - start;
  a.nodes = m.X_mm.size();
  for (size_t i = 0; i < at.size(); ++i) a.moved_mm += (solver->position_mm(at[i]) - X[i])[2] / double(at.size());
  return a;
}

}  // namespace

Result layers(const LawsSettings& settings) {
  Result out;
  const LayerCase cases[] = {{"hook on skin over fat", Load::hook, {36, 36, 9}, 300},
                             {"beam of 9 mm bent", Load::beam, {36, 12, 9}, 20},
                             {"flap of 3 mm bent", Load::beam, {24, 12, 3}, 2}};
  for (const LayerCase& c : cases)
    for (const double skin : {60.0, 600.0}) {
      if (settings.quick && skin > 100) continue;
      const double nu = 0.49;
      const std::string what = fmt::format("skin {:.0f} kPa, fat 15 kPa", skin);
      if (settings.progress) settings.progress(std::string(c.name) + ", " + what);
      const LayerAnswer fine = answer(c, 0.75, skin, nu);
      for (const double h : {3.0, 1.5}) {  // (the same thickness of skin: at 1.5 mm it has its own cells)
        const LayerAnswer a = answer(c, h, skin, nu);
        const double error = 100 * (a.moved_mm / fine.moved_mm - 1);
        const std::string how =
            fmt::format("cells of {:.2g} mm: {:.4f} mm, 0.75 mm: {:.4f} mm; {} and {} nodes; residual {:.1e}, {:.1e}",
                        h, a.moved_mm, fine.moved_mm, a.nodes, fine.nodes, a.residual, fine.residual);
        out.rows.push_back({c.name, what, how, a.ms, false, error, "%", "cells of 0.75 mm", true});
        if (h == 3)
          out.bars.push_back({std::string(c.name) + ", " + what + ": error at 3 mm (%)", std::fabs(error), false, 5,
                              false, std::fabs(error) <= 5, "issue: within 5 % of a mesh that resolves the skin"});
      }
    }
  out.notes.push_back(
      "Layers: error of the displacement under the load; each load spread over the same points on every mesh. nu "
      "0.49.");
  return out;
}

}  // namespace limberg::bench
