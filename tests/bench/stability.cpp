#include "tests/bench/stability.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "app/operating_point/cpu_clock.h"
#include "sim/testing/reference_newton.h"
#include "tests/bench/bullet_peer.h"
#include "tests/bench/stability_cases.h"

namespace limberg::bench {
namespace {

constexpr int kIterationsPerStep = 40;  // what a frame of 60 Hz holds at 8k nodes
constexpr int kMaxSteps = 300;          // 5 s at 60 Hz
constexpr int kPeerIterations = 200;
constexpr int kPeerSteps = 100;
constexpr double kPeerLimit_ms = 4000;  // CPU a case, of every peer: all of them over all cases within some ten minutes

/// Largest distance of a node from its rest place; for a floating piece after the best rigid motion.
double distance_from_rest(const FemModel& m, std::span<const Vec3> u, bool floating) {
  Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
  if (floating) {
    Eigen::Matrix3Xd from(3, u.size()), to(3, u.size());
    for (size_t i = 0; i < u.size(); ++i)
      from.col(Eigen::Index(i)) = m.X_mm[i], to.col(Eigen::Index(i)) = m.X_mm[i] + u[i];
    moved.matrix() = Eigen::umeyama(from, to, false);
  }
  double far = 0;
  for (size_t i = 0; i < u.size(); ++i) far = std::max(far, (m.X_mm[i] + u[i] - moved * m.X_mm[i]).norm());
  return std::isfinite(far) ? far : 1e300;
}

std::vector<Vec3> to_double(std::span<const Vec3f> u) {
  std::vector<Vec3> d;
  for (const Vec3f& v : u) d.push_back(v.cast<double>());
  return d;
}

struct StabilityResult {
  bool pass = false;
  int steps = 0;  // after the release, until at rest
  double distance_mm = 0;
  double ms = 0;
  std::string why;  // of a failure
};

/// The load after so many steps of its ramp.
std::vector<Spring> ramped(const StabilityCase& c, int steps) {
  std::vector<Spring> load = c.load;
  Vec3 from = Vec3::Zero();
  for (size_t i = 0; i < 8; ++i) from += double(load[0].a.w[i]) * c.model->X_mm[size_t(load[0].a.node[i])];
  load[0].target_mm = from + std::min(1.0, double(steps) / c.ramp_steps) * (load[0].target_mm - from);
  return load;
}

StabilityResult ours(const StabilityCase& c) {
  StabilityResult o;
  const double t0 = cpu_ms();
  InlineWorkers workers;
  auto solver = make_solver(workers);
  solver->set_model(c.model, {});
  if (!c.start.empty()) solver->set_displacement_mm(c.start);
  StepSettings s;
  s.max_iterations = kIterationsPerStep, s.tolerance = 1e-6;
  s.dt_s = c.dt_s, s.damping_per_s = c.damping_per_s;
  auto fail = [&](const char* why) {
    o.why = why, o.ms = cpu_ms() - t0;
    o.distance_mm = distance_from_rest(*c.model, to_double(solver->displacement_mm()), c.floating);
    return o;
  };
  auto finite = [&](const StepReport& r) {
    if (!std::isfinite(r.energy_uJ) || !std::isfinite(r.residual)) return false;
    for (const Vec3f& v : solver->displacement_mm())
      if (!v.allFinite()) return false;
    return true;
  };
  StepReport r;
  if (!c.load.empty()) {
    solver->set_springs(c.load);
    for (int k = 0; k < c.hold_steps; ++k) {
      if (k == 1 && !c.teleport.empty()) solver->set_springs(c.teleport);
      if (c.ramp_steps > 0) solver->set_springs(ramped(c, k + 1));
      r = solver->step(s);
      if (!finite(r)) return fail("not finite under load");
    }
    if (c.must_reach) {
      if (r.residual > 1e-3) return fail("no equilibrium under load");
      for (const Spring& x : c.load)
        if ((solver->position_mm(x.a) - solver->position_mm(x.b)).norm() > 0.05) return fail("a suture stays open");
    }
    solver->set_springs({});
  }
  if (c.throw_mm_per_s.norm() > 0) {
    SolverState state;
    for (size_t i = 0; i < c.model->X_mm.size(); ++i)
      for (int k = 0; k < 3; ++k) state.velocity_mm_s.push_back(float(c.throw_mm_per_s[k]));
    solver->restore(state);
    double moved = 0;
    for (int k = 0; k < 100; ++k) {
      const std::vector<Vec3> before = to_double(solver->displacement_mm());
      if (!finite(solver->step(s))) return fail("not finite in flight");
      const std::vector<Vec3> after = to_double(solver->displacement_mm());
      Vec3 p = Vec3::Zero();
      double mass = 0;
      for (size_t i = 0; i < after.size(); ++i)
        p += c.model->mass_kg[i] * (after[i] - before[i]) / c.dt_s, mass += c.model->mass_kg[i];
      moved = std::max(moved, (p / mass - c.throw_mm_per_s).norm() / c.throw_mm_per_s.norm());
    }
    // Displacements are floats: a place of d mm carries 6e-8 d, and the velocity is a difference over dt.
    const double rounding = 2 * 6e-8 * 101;
    o.distance_mm = distance_from_rest(*c.model, to_double(solver->displacement_mm()), true);
    o.steps = 100, o.ms = cpu_ms() - t0;
    o.pass = moved < 1e-6 + rounding && o.distance_mm < 1e-3 * c.length_mm;
    if (!o.pass) o.why = "momentum changed by " + std::to_string(moved);
    return o;
  }
  StepSettings look = s;
  look.max_iterations = 0;
  const double energy = solver->step(look).energy_uJ;
  const int most = c.dt_s > 0 ? std::max(kMaxSteps, int(5 / c.dt_s)) : kMaxSteps;
  for (o.steps = 1; o.steps <= most; ++o.steps) {
    r = solver->step(s);
    if (!finite(r)) return fail("not finite after the release");
    // Multipliers change the energy that is minimised between iterations; what was put in may never be exceeded.
    if (c.dt_s == 0 && r.energy_uJ > energy * (1 + 1e-4) + 1) return fail("more energy than was put in");
    o.distance_mm = distance_from_rest(*c.model, to_double(solver->displacement_mm()), c.floating);
    if (o.distance_mm < 1e-3 * c.length_mm && r.min_J > 0) {
      o.pass = true, o.ms = cpu_ms() - t0;
      return o;
    }
  }
  return fail("not at rest again");
}

StabilityResult newton(const StabilityCase& c, const FemModel& model) {
  StabilityResult o;
  const double t0 = cpu_ms();
  std::vector<Vec3> u(model.X_mm.size(), Vec3::Zero());
  if (!c.start.empty()) u = to_double(c.start);
  ReferenceElasticity::Settings s;
  s.max_iterations = kPeerIterations, s.tolerance = 1e-8;
  s.on_iterate = [&](std::span<const Vec3>) { return cpu_ms() - t0 > kPeerLimit_ms; };
  for (const std::vector<Spring>* load : {&c.load, &c.teleport}) {
    if (load->empty()) continue;
    const auto r = ReferenceElasticity(model, *load).solve(u, s);
    u = r.u;
    if (c.must_reach && load == &c.load && r.residual > 1e-3) o.why = "no equilibrium under load";
  }
  const auto r = ReferenceElasticity(model, {}).solve(u, s);
  o.steps = r.iterations, o.ms = cpu_ms() - t0;
  o.distance_mm = distance_from_rest(model, r.u, c.floating);
  o.pass = o.why.empty() && o.distance_mm < 1e-3 * c.length_mm;
  if (!o.pass && o.why.empty())
    o.why = "not at rest after " + std::to_string(r.iterations) + " iterations" +
            (o.ms > kPeerLimit_ms ? ", its time was up" : "");
  return o;
}

/// Bullet's body; its one material's constants from the case.
StabilityResult bullet(const StabilityCase& c) {
  StabilityResult o;
  const double t0 = cpu_ms(), dt = c.dt_s > 0 ? c.dt_s : 1.0 / 60;
  const auto [mu, lambda] = bullet_constants(c.young_kPa, c.poisson);
  BulletBody body(*c.model, mu, lambda);
  if (!c.start.empty()) body.set_displacement_mm(c.start);
  std::vector<Vec3> u;
  const auto lost = [&] {
    u = body.displacement_mm();
    o.distance_mm = distance_from_rest(*c.model, u, c.floating);
    return !(o.distance_mm < 1e4);
  };
  const auto done = [&](const std::string& why) {
    o.why = why, o.pass = why.empty(), o.ms = cpu_ms() - t0;
    return o;
  };
  if (c.throw_mm_per_s.norm() > 0) body.set_velocity(c.throw_mm_per_s);
  body.set_springs(c.load);
  for (int k = 0; k < std::min(c.hold_steps, kPeerSteps); ++k) {
    if (k == 1 && !c.teleport.empty()) body.set_springs(c.teleport);
    if (c.ramp_steps > 0) body.set_springs(ramped(c, k + 1));
    body.step(dt);
    if (lost()) return done("blown up under load");
    if (cpu_ms() - t0 > kPeerLimit_ms) break;
  }
  if (c.must_reach) {
    const auto at = [&](const EmbeddedPoint& p) {
      Vec3 x = Vec3::Zero();
      for (size_t i = 0; i < 8; ++i) x += double(p.w[i]) * (c.model->X_mm[size_t(p.node[i])] + u[size_t(p.node[i])]);
      return x;
    };
    for (const Spring& s : c.load)
      if ((at(s.a) - at(s.b)).norm() > 0.05) return done("a suture stays open");
  }
  body.set_springs({});
  for (o.steps = 1; o.steps <= kPeerSteps; ++o.steps) {
    body.step(dt);
    if (lost()) return done("blown up after the release");
    if (o.distance_mm < 1e-3 * c.length_mm) return done("");
    if (cpu_ms() - t0 > kPeerLimit_ms) break;
  }
  return done("not at rest " + std::to_string(o.steps) + " steps after the release");
}

/// Which cases a peer failed, by family, for the table at the end.
struct Failures {
  std::map<std::string, std::vector<std::string>> of_family;
  int cases = 0, failed = 0;
  void count(const StabilityCase& c, bool pass) {
    ++cases;
    if (!pass) ++failed, of_family[c.family].push_back(c.name);
  }
  std::string line(const char* who) const {
    std::string s = std::string(who) + " fails " + std::to_string(failed) + " of " + std::to_string(cases);
    const char* sep = ": ";
    for (const auto& [family, names] : of_family) {
      s += sep + family + " (";
      for (size_t i = 0; i < names.size(); ++i) s += (i ? "; " : "") + names[i];
      s += ")", sep = ", ";
    }
    return s;
  }
};

Row row(const StabilityCase& c, const char* method, const StabilityResult& o, bool under_test) {
  Row r;
  r.name = c.family + ": " + c.name;
  r.method = method;
  r.settings = (o.pass ? "recovered after " + std::to_string(o.steps) : "FAILED: " + o.why);
  r.time_ms = o.ms;
  r.error = o.distance_mm, r.error_unit = "mm", r.reference = "rest shape";
  r.pass = o.pass || !under_test;
  return r;
}

}  // namespace

Result stability(const StabilitySettings& settings) {
  Result out;
  const std::vector<StabilityCase> cases = stability_cases(settings.quick);
  int passed = 0, run_cases = 0;
  Failures by_newton, by_corotated, by_bullet;
  for (const StabilityCase& c : cases) {
    if (!settings.only.empty() && (c.family + ": " + c.name).find(settings.only) == std::string::npos) continue;
    ++run_cases;
    if (settings.progress) settings.progress(c.family + ": " + c.name);
    const StabilityResult o = ours(c);
    passed += o.pass;
    out.rows.push_back(row(c, "limberg (steps of 40 iterations)", o, true));
    if (!settings.quick && settings.peers && c.one_material && has_bullet()) {
      const StabilityResult k = bullet(c);
      by_bullet.count(c, k.pass);
      out.rows.push_back(row(c, "Bullet deformable", k, false));
    }
    if (settings.quick || !settings.peers || c.dt_s > 0) continue;  // the peers here are quasi-static
    const StabilityResult n = newton(c, *c.model);
    by_newton.count(c, n.pass);
    out.rows.push_back(row(c, "full Newton, same energy (iterations)", n, false));
    if (c.has_laws) continue;
    const StabilityResult k = newton(c, *corotated_twin(*c.model));
    by_corotated.count(c, k.pass);
    out.rows.push_back(row(c, "full Newton, linear corotated", k, false));
  }
  const double n = double(run_cases);
  out.bars.push_back({"cases recovered, of " + std::to_string(run_cases), double(passed), false, n, true,
                      passed == int(n), "every case has a rest state to return to"});
  if (!settings.quick && settings.peers) {
    out.notes.push_back(by_newton.line("Full Newton on the same energy"));
    out.notes.push_back(by_corotated.line("Full Newton on the linear corotated law"));
    if (by_bullet.cases) out.notes.push_back(by_bullet.line("Bullet's deformable body"));
    const std::string text = fmt::format(
        "Budget of a peer, per case: {:.0f} s of CPU time, {} Newton iterations, {} steps of Bullet after the release. "
        "Newton: quasi-static cases; Bullet: those of one tissue.",
        kPeerLimit_ms / 1000, kPeerIterations, kPeerSteps);
    out.notes.push_back(text);
  }
  return out;
}

}  // namespace limberg::bench
