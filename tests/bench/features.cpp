#include "tests/bench/features.h"

#include <fmt/format.h>
#include <malloc.h>

#include <cmath>

#include "app/operating_point/accuracy_probe.h"
#include "app/operating_point/cpu_clock.h"
#include "app/session/workers_pool.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "sim/patient/soft_tissue.h"

namespace limberg::bench {
namespace {

double allocated_mb() {
  const auto m = mallinfo2();
  return double(m.uordblks + m.hblkhd) / 1e6;
}

/// Something whose frames are timed: a patient, or a solver alone.
class Run {
 public:
  virtual ~Run() = default;
  virtual void frame(int f) = 0;
  virtual std::string size() const = 0;
  std::string refused;
  double memory_mb = 0;
  Times taken;
};

std::string nodes_of(const FemModel& m) {
  size_t free = 0;
  for (Held h : m.fixed) free += !h.all();
  return fmt::format("{} nodes, {} free", m.X_mm.size(), free);
}

struct FeaturePatient {
  WorldSpec spec;
  StepSettings step;
  std::vector<Command> acts;  // before the pull
  bool with_field = false;    // every frame
};

class WorldRun final : public Run {
 public:
  WorldRun(const FeaturePatient& p, const Scene& scene, int frames) : p_(p), count_(frames) {
    WorldSpec spec = p.spec;
    spec.body = build_body(scene);
    world_ = std::make_unique<World>(spec, workers_);
    for (const Command& a : p.acts) {
      const Outcome o = world_->apply(a);
      if (!o.done && refused.empty()) refused = o.reason;
      for (int k = 0; k < 3; ++k) world_->step(p.step);
    }
    world_->apply(SetHook{1, {0, 4}});
    world_->fill(shown_);
    at_ = shown_.hooks.empty() ? Vec3::Zero() : Vec3(shown_.hooks[0].handle_mm.cast<double>());
    for (int k = 0; k < 5; ++k) world_->step(p.step);
  }
  void frame(int f) override {
    world_->apply(MoveHook{1, at_ + double(f) / count_ * Vec3(0, 6, 6), 0});
    world_->step(p_.step);
    if (p_.with_field) world_->fill(shown_, true);
  }
  std::string size() const override { return nodes_of(world_->skin()->solver().model()); }
  World& world() { return *world_; }
  Vec3 handle_mm() const { return at_; }

 private:
  FeaturePatient p_;
  int count_;
  InlineWorkers workers_;
  std::unique_ptr<World> world_;
  Snapshot shown_;
  Vec3 at_ = Vec3::Zero();
};

/// The elasticity solver on a model, with nothing around it.
class SolverRun final : public Run {
 public:
  SolverRun(std::shared_ptr<const FemModel> model, const Spring& hook, const Vec3& pull_mm, const StepSettings& step,
            int frames, Workers* workers = nullptr, bool estimate_error = true)
      : hook_(hook),
        from_mm_(hook.target_mm),
        pull_mm_(pull_mm),
        step_(step),
        count_(frames),
        solver_(std::make_unique<fem::LbfgsSolver>(workers ? *workers : inline_, true, fem::MetricPolicy{},
                                                   fem::MinimiserPolicy{0, estimate_error})) {
    solver_->set_model(std::move(model), {});
    for (int k = 0; k < 5; ++k) frame(0);
  }
  void frame(int f) override {
    hook_.target_mm = from_mm_ + double(f) / count_ * pull_mm_;
    solver_->set_springs(std::span(&hook_, 1));
    solver_->step(step_);
  }
  std::string size() const override { return nodes_of(solver_->model()); }

 private:
  Spring hook_;
  Vec3 from_mm_, pull_mm_;
  StepSettings step_;
  int count_;
  InlineWorkers inline_;
  std::unique_ptr<ElasticSolver> solver_;
};

struct Variant {
  std::string how;
  std::function<std::unique_ptr<Run>()> make;
  bool idle = false;  // present, but with nothing to do: must cost nothing
};

/// All variants frame by frame in turn, the first one (off) twice: how far the two differ is the noise of this run.
class Trials {
 public:
  Trials(Result& out, int frames) : out_(out), frames_(frames) {}

  double memory_of(const std::string& part, const std::string& how) const {
    for (const Row& r : out_.rows)
      if (r.name == part && r.method == how) return r.error;
    return 0;
  }

  void add(const std::string& part, const std::vector<Variant>& variants) {
    std::vector<std::unique_ptr<Run>> runs;
    const auto make = [&](const Variant& v) {
      const double before = allocated_mb();
      runs.push_back(v.make());
      runs.back()->memory_mb = allocated_mb() - before;
    };
    for (const Variant& v : variants) make(v);
    make(variants[0]);
    const size_t n = runs.size();
    for (int f = 1; f <= frames_; ++f)
      for (size_t k = 0; k < n; ++k) {
        Run& r = *runs[(k + size_t(f)) % n];
        const double start = cpu_ms();
        r.frame(f);
        r.taken.add(cpu_ms() - start);
      }
    // Median over frames of the ratio to the run that is off, of the same frame: what disturbs a frame disturbs both.
    const auto ratio = [&](const Run& r) {
      Times t;
      for (size_t f = 0; f < r.taken.ms.size(); ++f) t.add(r.taken.ms[f] / runs[0]->taken.ms[f]);
      return t.median();
    };
    const double noise = ratio(*runs[n - 1]) - 1;
    for (size_t k = 0; k + 1 < n; ++k) {
      const Run& r = *runs[k];
      const double x = ratio(r);
      const std::string text =
          fmt::format("step x {:.3f} of off, memory {:+.1f} MB of off; {}; off against off: x {:.3f}{}", x,
                      r.memory_mb - runs[0]->memory_mb, r.size(), 1 + noise,
                      r.refused.empty() ? "" : (", refused: " + r.refused.substr(0, 60)).c_str());
      out_.rows.push_back({part, variants[k].how, text, r.taken.median(), false, r.memory_mb, "MB",
                           "the allocator's count; time: one step of 10 iterations", true});
      if (!variants[k].idle) continue;
      // Three standard deviations of a median of n frames are about 3.8 /
      // sqrt(n) of their scatter; the run's own twin says how much that is.
      const double cost = 100 * (x - 1), bound = 2 + 100 * std::fabs(noise);
      const std::string source =
          fmt::format("off must cost nothing: 2 % and the noise of this run (off against off {:+.1f} %)", 100 * noise);
      out_.bars.push_back(
          {part + ", " + variants[k].how + ": more than off (%)", cost, false, bound, false, cost <= bound, source});
    }
  }

 private:
  Result& out_;
  int frames_;
};

std::shared_ptr<const FemModel> with_upper_points(const FemModel& from, const LawPtr& law, bool viscous) {
  auto m = std::make_shared<FemModel>(from);
  double top = -1e300;
  for (const Vec3& X : from.X_mm) top = std::max(top, X[2]);
  std::vector<uint8_t> upper(from.stencils.size(), 0);
  for (const HexCell& c : from.cells) upper[size_t(c.stencil)] |= from.X_mm[size_t(c.node[7])][2] > top - 1e-6;
  const int32_t index = int32_t(m->laws.size());
  m->laws.push_back(law);
  for (size_t i = 0; i < upper.size(); ++i)
    for (int q = 0; upper[i] && q < 4; ++q) {
      const Vec3 at(q & 1 ? 0.79 : 0.21, q & 2 ? 0.79 : 0.21, 0.75);
      const double volume = from.stencils[i].volume_mm3 / 8;
      if (viscous) {
        ViscousPoint p;
        p.at = at, p.volume_mm3 = volume, p.law = index, p.terms = {{0.5, 0.3}};
        m->stencils[i].viscous.push_back(p);
      } else {
        MaterialPoint p;
        p.at = at, p.volume_mm3 = volume, p.law = index;
        m->stencils[i].points.push_back(p);
      }
    }
  return m;
}

std::shared_ptr<const FemModel> without_sliding(const FemModel& from, size_t& shared) {
  auto m = std::make_shared<FemModel>(from);
  std::vector<uint8_t> slides(from.stencils.size(), 0);
  for (size_t i = 0; i < slides.size(); ++i)
    if (from.stencils[i].slide_kPa != 0) slides[i] = 1, m->stencils[i].slide_kPa = 0;
  shared = 0;
  for (const HexCell& c : from.cells) shared += slides[size_t(c.stencil)];
  return m;
}

}  // namespace

Result features(const Scene& scene, const FeatureSettings& set) {
  Result out;
  const int frames = set.quick ? 24 : 48;
  Trials trials(out, frames);
  const auto wanted = [&](const std::string& part) {
    const bool yes = set.only.empty() || part.find(set.only) != std::string::npos;
    if (yes && set.progress) set.progress(part);
    return yes;
  };
  FeaturePatient base;
  base.spec = world_spec(scene, nullptr);
  base.spec.can_cut = true, base.spec.contact = ContactChoice::off, base.spec.refine_fronts = false,
  base.spec.dynamic = false, base.spec.region_mm = 0;
  if (set.quick) base.spec.cell_mm = 2 * scene.cell_mm;
  base.step.max_iterations = 10;  // all of them: the same work in every frame
  const double depth = std::min(scene.tools.default_depth_mm, scene.tools.max_depth_mm);
  const Incise incision{{{-20, 0}, {20, 0}}, depth, 90, false};
  FeaturePatient cut = base;
  cut.acts = {incision};
  const auto patient = [&](const FeaturePatient& p) {
    return [&scene, p, frames] { return std::make_unique<WorldRun>(p, scene, frames); };
  };
  const auto changed = [](FeaturePatient p, const auto& change) {
    change(p);
    return p;
  };

  if (wanted("everything off")) {
    // The bare solver on the patient's own model, with the patient's hook.
    const FeaturePatient plain = changed(base, [](FeaturePatient& p) { p.spec.can_cut = false; });
    trials.add("everything off",
               {{"the elasticity solver alone",
                 [&scene, plain, frames]() -> std::unique_ptr<Run> {
                   WorldRun w(plain, scene, frames);
                   Spring h;
                   h.id = 1, h.to_world = true, h.k_N_per_mm = plain.spec.hook_k_N_per_mm, h.target_mm = w.handle_mm();
                   const FemModel& m = w.world().skin()->solver().model();
                   size_t nearest = 0;
                   for (size_t i = 0; i < m.X_mm.size(); ++i)
                     if ((m.X_mm[i] - h.target_mm).squaredNorm() < (m.X_mm[nearest] - h.target_mm).squaredNorm())
                       nearest = i;
                   h.a.node[0] = int32_t(nearest), h.a.w[0] = 1;
                   return std::make_unique<SolverRun>(std::make_shared<FemModel>(m), h, Vec3(0, 6, 6), plain.step,
                                                      frames);
                 }},
                {"a patient that can be pulled only", patient(plain), true},
                {"a patient that can be cut", patient(base), true}});
  }
  if (wanted("cutting"))
    trials.add("cutting",
               {{"off: can_cut = false", patient(changed(base, [](FeaturePatient& p) { p.spec.can_cut = false; }))},
                {"on, nothing cut", patient(base), true},
                {"on, one incision of 40 mm", patient(cut)}});
  if (wanted("contact")) {
    const auto touch = [](FeaturePatient& p) { p.spec.contact = ContactChoice::automatic; };
    trials.add("contact",
               {{"off, nothing cut", patient(base)}, {"auto, nothing cut", patient(changed(base, touch)), true}});
    trials.add("contact in a wound",
               {{"off, one incision", patient(cut)}, {"auto, one incision", patient(changed(cut, touch))}});
    // Sewn, so that edges press: without a coefficient friction costs nothing.
    const FeaturePatient sewn = changed(cut, [&](FeaturePatient& p) {
      touch(p);
      p.acts.push_back(SutureRow{{{-18, 1}, {18, 1}}, {{-18, -1}, {18, -1}}, 2});
    });
    trials.add("friction of contact",
               {{"off, sewn", patient(sewn)},
                {"0.1, sewn", patient(changed(sewn, [](FeaturePatient& p) { p.spec.contact_friction = 0.1; }))}});
  }
  if (wanted("divided fronts")) {
    const auto divide = [](FeaturePatient& p) { p.spec.refine_fronts = true; };
    trials.add("divided fronts",
               {{"off, one incision", patient(cut)}, {"on, one incision", patient(changed(cut, divide))}});
  }
  if (wanted("progressive incision")) {
    FeaturePatient drawn = base;
    for (int k = 0; k < 4; ++k)
      drawn.acts.push_back(InciseMore{1, {{-20.0 + 10 * k, 0}, {-10.0 + 10 * k, 0}}, depth, 90, k == 3});
    trials.add("progressive incision",
               {{"off: the whole stroke at once", patient(cut)}, {"on: in four pieces", patient(drawn)}});
  }
  if (wanted("undo depth")) {
    FeaturePatient many = cut;
    for (int k = 1; k <= 8; ++k) many.acts.push_back(Incise{{{-15, 5.0 * k + 3}, {15, 5.0 * k + 3}}, depth, 90, false});
    trials.add("undo depth", {{"1 incision to undo", patient(cut)}, {"9 incisions to undo", patient(many)}});
    const std::string note = fmt::format(
        "undo: {:.2f} MB for each incision of 30 mm, its wound included",
        (trials.memory_of("undo depth", "9 incisions to undo") - trials.memory_of("undo depth", "1 incision to undo")) /
            8);
    out.notes.push_back(note);
  }
  if (wanted("sutures")) {
    const auto sew = [](FeaturePatient& p) {
      p.acts.push_back(SutureRow{{{-18, 1}, {18, 1}}, {{-18, -1}, {18, -1}}, 2});
    };
    trials.add("sutures",
               {{"none, one incision", patient(cut)}, {"19 across the incision", patient(changed(cut, sew))}});
  }
  if (wanted("dynamics")) {
    const auto move = [&](FeaturePatient& p) { p.spec.dynamic = true, p.step.dt_s = 1 / scene.steps_per_s; };
    trials.add("dynamics",
               {{"off: quasi-static", patient(cut)}, {"on: one implicit step a frame", patient(changed(cut, move))}});
  }
  if (wanted("tension field"))
    trials.add("tension field",
               {{"off", patient(cut)},
                {"on: every frame", patient(changed(cut, [](FeaturePatient& p) { p.with_field = true; }))}});
  if (wanted("region") && scene.source == Scene::Source::block) {
    trials.add("region of interest", {{"off: the whole block", patient(cut)},
                                      {"on, all of the block inside",
                                       patient(changed(cut, [](FeaturePatient& p) { p.spec.region_mm = 1e4; })), true},
                                      {"on: 40 mm about the middle, the rest absent",
                                       patient(changed(cut, [](FeaturePatient& p) { p.spec.region_mm = 40; }))}});
  }

  // On plain finite elements: the same cells with and without.
  InlineWorkers workers;
  const bool solvers = wanted("fibres") || wanted("viscoelasticity") || wanted("thin layers") ||
                       wanted("second worker") || wanted("error estimate");
  if (!solvers) return out;
  const Probe probe = make_probe(scene, build_body(scene), base.spec.cell_mm, workers);
  const auto alone = [&](std::shared_ptr<const FemModel> model, const StepSettings& step, Workers* w = nullptr) {
    return [&probe, model, step, frames, w]() -> std::unique_ptr<Run> {
      return std::make_unique<SolverRun>(std::make_shared<FemModel>(*model), probe.hook, probe.pull_mm, step, frames,
                                         w);
    };
  };
  if (wanted("fibres")) {
    const auto fibrous =
        with_upper_points(*probe.model, dispersed_fibres({50, 1.5, 0.15}, {{{1, 1, 0}}, {{1, -1, 0}}}), false);
    trials.add("fibres (solver alone)", {{"off", alone(probe.model, base.step)},
                                         {"on: two families in the uppermost cells", alone(fibrous, base.step)}});
  }
  if (wanted("viscoelasticity")) {
    const auto viscous = with_upper_points(*probe.model, neo_hookean(20), true);
    StepSettings moving = base.step;
    moving.dt_s = 1 / scene.steps_per_s;
    trials.add("viscoelasticity (solver alone)",
               {{"off, quasi-static", alone(probe.model, base.step)},
                {"layers that relax, quasi-static steps", alone(viscous, base.step), true}});
    trials.add("viscoelasticity, dynamic", {{"off", alone(probe.model, moving)},
                                            {"on: one Prony term in the uppermost cells", alone(viscous, moving)}});
  }
  if (wanted("thin layers")) {
    size_t shared = 0;
    const auto averaged = without_sliding(*probe.model, shared);
    const std::string how = fmt::format("on: sliding in {} of {} cells", shared, probe.model->cells.size());
    trials.add("thin layers (solver alone)",
               {{"off: layers of a cell averaged", alone(averaged, base.step)}, {how, alone(probe.model, base.step)}});
  }
  if (wanted("error estimate"))
    trials.add("error estimate (solver alone)", {{"off",
                                                  [&]() -> std::unique_ptr<Run> {
                                                    return std::make_unique<SolverRun>(
                                                        std::make_shared<FemModel>(*probe.model), probe.hook,
                                                        probe.pull_mm, base.step, frames, nullptr, false);
                                                  }},
                                                 {"on", alone(probe.model, base.step)}});
  if (wanted("second worker")) {
    WorkersPool two(2);
    trials.add("second worker (CPU time of both)",
               {{"off", alone(probe.model, base.step)}, {"on", alone(probe.model, base.step, &two)}});
  }
  out.notes.push_back(
      "memory: of body, patient and solver together, in rows of the solver alone of that; each row's ratio is the "
      "median over the frames of on / off of the same frame, all run in turn");
  return out;
}

}  // namespace limberg::bench
