#include "tests/bench/graded.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "app/assembly/operation.h"
#include "app/operating_point/cpu_clock.h"
#include "app/program/shipped.h"
#include "app/result/metrics.h"
#include "sim/patient/soft_tissue.h"
#include "tests/sim/lattice/sheet_lattice.h"

namespace limberg::bench {
namespace {

using test::SheetLattice;

// As in verification_thickness.cpp: under 1 N along, under .5 N upwards.
constexpr double kAlong_mm = 1.820, kUpwards_mm = 1.769;
constexpr double kNoLimit_mm = std::numeric_limits<double>::infinity();

struct Subject {
  std::string name;
  size_t nodes = 0;
  double time_ms = 0, error = 0;  // %
  bool is_graded = false;
};

/// Who beats whom: by error, at no more nodes or no more time.
void compare(Result& out, const std::string& of, const std::vector<Subject>& all) {
  for (const Subject& g : all) {
    if (!g.is_graded) continue;
    std::string ahead, behind;
    for (const Subject& u : all) {
      if (u.is_graded) continue;
      const bool better = std::fabs(g.error) < std::fabs(u.error);
      if (better && g.nodes <= u.nodes) ahead += " " + u.name + " (nodes)";
      if (better && g.time_ms <= u.time_ms) ahead += " " + u.name + " (time)";
      if (!better && u.nodes <= g.nodes) behind += " " + u.name + " (nodes)";
      if (!better && u.time_ms <= g.time_ms) behind += " " + u.name + " (time)";
    }
    out.notes.push_back(of + ", " + g.name + ": ahead of" + (ahead.empty() ? " none" : ahead) + "; behind" +
                        (behind.empty() ? " none" : behind));
  }
}

// --- patch ---------------------------------------------------------------------------------------------------------

struct PatchLattice {
  std::string name;
  double cell_mm;
  Grading grading;
  std::string like = {};  // the uniform lattice of its smallest cells
};

Grading around_patch(std::initializer_list<std::array<double, 3>> radius_depth_level) {
  Grading g;
  for (const auto& [radius, depth, level] : radius_depth_level) {
    GradedZone z;
    z.radius_mm = radius, z.depth_mm = depth, z.level = int(level);
    g.zones.push_back(z);
  }
  return g;
}

std::vector<PatchLattice> patch_lattices(bool quick) {
  std::vector<PatchLattice> all{{"5 mm", 5, {}}, {"3.5 mm", 3.5, {}}};
  if (!quick)
    for (const double h : {2.5, 1.75, 1.25}) all.push_back({fmt::format("{:g} mm", h), h, {}});
  all.push_back({"5 mm, 2.5 within 10", 5, around_patch({{10, kNoLimit_mm, 1}}), "2.5 mm"});
  if (!quick) {
    all.push_back({"5 mm, 2.5 within 16", 5, around_patch({{16, kNoLimit_mm, 1}}), "2.5 mm"});
    all.push_back({"5 mm, 2.5 within 16, 1.25 within 8 and 3 deep", 5, around_patch({{16, kNoLimit_mm, 1}, {8, 3, 2}}),
                   "1.25 mm"});
    all.push_back({"5 mm, 1.25 within 8", 5, around_patch({{8, kNoLimit_mm, 2}}), "1.25 mm"});
    all.push_back({"5 mm, 1.25 within 16", 5, around_patch({{16, kNoLimit_mm, 2}}), "1.25 mm"});
    all.push_back({"3.5 mm, 1.75 within 10", 3.5, around_patch({{10, kNoLimit_mm, 1}}), "1.75 mm"});
    all.push_back({"3.5 mm, 1.75 within 16", 3.5, around_patch({{16, kNoLimit_mm, 1}}), "1.75 mm"});
  }
  return all;
}

/// The program's solver on a hook that pulls the patch by 4 mm.
struct LiveSolve {
  double step_ms = 0;  // of 10 iterations
  int iterations = 0;  // to a residual of 1e-5
  bool at_rest = false;
};
LiveSolve live_solve(const SheetLattice& l) {
  InlineWorkers workers;
  const auto solver = make_solver(workers);
  solver->set_model(l.m, {});
  Spring s;
  s.id = 1, s.to_world = true, s.k_N_per_mm = 0.5;
  Vec3 middle = Vec3::Zero();
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i) {
      const Vec3 X(-2.75 + 0.5 * i, -2.75 + 0.5 * j, l.body->box_max_mm.z() - 1e-6);
      s.a_wide.push_back(embed_in_copy(*l.t, l.t->copy(cell_of(*l.t, X), 0), X));
      middle += X / 144;
    }
  s.a = s.a_wide[0], s.target_mm = middle + Vec3(2, 0, 4);
  solver->set_springs(std::span(&s, 1));
  StepSettings set;
  set.max_iterations = 1;
  solver->step(set);  // with the factor
  LiveSolve out;
  out.iterations = 1;
  Times steps;
  set.max_iterations = 10;
  for (int i = 0; i < 100 && !out.at_rest; ++i) {
    const double before = cpu_ms();
    const StepReport r = solver->step(set);
    steps.add(cpu_ms() - before);
    out.iterations += r.iterations, out.at_rest = r.residual <= 1e-5;
  }
  out.step_ms = steps.median();
  return out;
}

void patch(Result& out, const GradedSettings& set) {
  std::vector<Subject> along, upwards;
  for (const PatchLattice& p : patch_lattices(set.quick)) {
    if (set.progress) set.progress("patch, " + p.name);
    const SheetLattice l(test::as_block(test::slab(0)), p.cell_mm, Vec3::Zero(), p.grading);
    const LiveSolve live = live_solve(l);
    for (const bool up : {false, true}) {
      const double before = cpu_ms();
      const Vec3 move = patch_move(l, up ? Vec3(0, 0, 0.01) : Vec3(0.02, 0, 0));
      const double time = cpu_ms() - before;
      const double error = 100 * 50 * (up ? move.z() / kUpwards_mm : move.x() / kAlong_mm) - 100;
      std::vector<Subject>& all = up ? upwards : along;
      std::string from;
      for (const Subject& u : all)
        if (u.name == p.like) from = fmt::format(", {:+.1f} % from uniform {}", error - u.error, p.like);
      all.push_back({p.name, l.m->X_mm.size(), time, error, !p.grading.empty()});
      out.rows.push_back(
          {std::string("skin on fat, a patch pulled ") + (up ? "upwards" : "along"),
           p.grading.empty() ? "uniform" : "graded",
           fmt::format("{}: {} nodes; {:.2f} ms a step, {} iterations to rest{}{}", p.name, l.m->X_mm.size(),
                       live.step_ms, live.iterations, live.at_rest ? "" : " (not)", from),
           time, false, error, "%", "CalculiX, 20-node hexahedra", true});
    }
  }
  compare(out, "along", along), compare(out, "upwards", upwards);
}

// --- rhomboid ------------------------------------------------------------------------------------------------------

struct FlapLattice {
  std::string name;
  double cell_mm;
  std::vector<FineZone> fine;
  int wound_level = 0;
};

std::vector<FlapLattice> flap_lattices(bool quick) {
  // The flap and its defect lie within 27 mm of [-2, 0].
  const auto zone = [](double radius_mm, int level, double depth_mm) {
    return std::vector<FineZone>{{{-2, 0}, {-2, 0}, radius_mm, depth_mm, level}};
  };
  if (quick) return {{"7 mm", 7, {}}, {"7 mm, 3.5 at the wound", 7, {}, 1}, {"5 mm", 5, {}}};
  return {{"5 mm", 5, {}},
          {"3.5 mm", 3.5, {}},
          {"2.5 mm", 2.5, {}},
          {"5 mm, 2.5 at the wound", 5, {}, 1},
          {"3.5 mm, 1.75 at the wound", 3.5, {}, 1},
          {"2.5 mm, 1.25 at the wound", 2.5, {}, 1},
          {"3.5 mm, 0.88 at the wound", 3.5, {}, 2},
          {"5 mm, 2.5 within 30", 5, zone(30, 1, 4.5)},
          {"3.5 mm, 1.75 within 30, 4 deep", 3.5, zone(30, 1, 4)},
          {"1.75 mm", 1.75, {}}};
}

struct FlapFigures {
  size_t nodes = 0;
  double cpu_ms = 0, residual = 0;
  Times steps;
  Metrics key;
};

FlapFigures carry_out(const Scene& scene, const std::shared_ptr<const Body>& body, const Script& script,
                      const FlapLattice& lattice) {
  WorldSpec spec = world_spec(scene, body);
  spec.cell_mm = lattice.cell_mm, spec.fine = lattice.fine, spec.wound_level = lattice.wound_level;
  InlineWorkers workers;
  World world(spec, workers);
  FlapFigures f;
  OperationSettings set;
  set.on_done = [&](const ScriptLine&, const std::string&) {
    StepSettings one;
    const double before = cpu_ms();
    world.step(one);
    f.steps.add(cpu_ms() - before);
  };
  const double before = cpu_ms();
  const OperationOutcome o = operate(world, scene.tools.max_depth_mm, script, set);
  f.cpu_ms = cpu_ms() - before;
  f.residual = o.last.residual, f.nodes = world.skin()->solver().model().X_mm.size();
  std::vector<Command> actions;
  for (const ScriptLine& l : script.lines) actions.push_back(l.command);
  f.key = measure_world(world, actions);
  return f;
}

std::string figures_of(const FlapFigures& f) {
  return fmt::format(
      "{} nodes, {:.0f} ms; a step {:.1f} ms, longest {:.1f}; closure {:.3f} N, largest stitch {:.3f} N, "
      "dog-ear {:.2f} mm, stress p95 {:.1f} kPa; residual {:.0e}",
      f.nodes, f.cpu_ms, f.steps.median(), f.steps.percentile(1), f.key.closure_force_N, f.key.suture_force_max_N,
      f.key.dog_ear_mm, f.key.stress_p95_kPa, f.residual);
}

void rhomboid(Result& out, const GradedSettings& set) {
  const Scene scene = load_scene(shipped_file("app/scenes/rhomboid.toml"));
  const std::shared_ptr<const Body> body = build_body(scene);
  const Script script = load_script(shipped_file("recordings/rhomboid.jsonl"));
  const std::vector<FlapLattice> all = flap_lattices(set.quick);
  std::vector<FlapFigures> made;
  for (const FlapLattice& l : all) {
    if (set.progress) set.progress("rhomboid, " + l.name);
    made.push_back(carry_out(scene, body, script, l));
    if (set.progress) set.progress(figures_of(made.back()));
  }
  const FlapFigures& finest = made.back();
  std::vector<Subject> closure, ear;
  for (size_t i = 0; i < all.size(); ++i) {
    const FlapFigures& f = made[i];
    const bool is_graded = !all[i].fine.empty() || all[i].wound_level > 0;
    const auto off = [&](double value, double truth) { return 100 * (value / truth - 1); };
    const double closure_off = off(f.key.closure_force_N, finest.key.closure_force_N),
                 ear_off = off(f.key.dog_ear_mm, finest.key.dog_ear_mm);
    if (i + 1 < all.size()) {
      closure.push_back({all[i].name, f.nodes, f.cpu_ms, closure_off, is_graded});
      ear.push_back({all[i].name, f.nodes, f.cpu_ms, ear_off, is_graded});
    }
    out.rows.push_back(
        {"rhomboid, closure force",
         i + 1 == all.size() ? "reference"
         : is_graded         ? "graded"
                             : "uniform",
         fmt::format("{}: {}; largest stitch {:+.0f} %, dog-ear {:+.0f} %, stress p95 {:+.0f} %", all[i].name,
                     figures_of(f), off(f.key.suture_force_max_N, finest.key.suture_force_max_N), ear_off,
                     off(f.key.stress_p95_kPa, finest.key.stress_p95_kPa)),
         f.cpu_ms, false, closure_off, "%", "uniform, " + all.back().name, f.residual <= 1e-4});
  }
  compare(out, "rhomboid, closure force", closure), compare(out, "rhomboid, dog-ear", ear);
}

}  // namespace

Result graded(const GradedSettings& set) {
  Result out;
  const auto wanted = [&](const char* part) { return std::string(part).find(set.only) != std::string::npos; };
  if (wanted("patch")) patch(out, set);
  if (wanted("rhomboid")) rhomboid(out, set);
  return out;
}

}  // namespace limberg::bench
