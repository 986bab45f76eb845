#include "app/operating_point/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "app/operating_point/accuracy_probe.h"
#include "app/operating_point/cpu_clock.h"
#include "app/operating_point/kept_trials.h"
#include "app/report/svg_chart.h"
#include "sim/base/error.h"
#include "sim/fem/solver/lbfgs_solver.h"

namespace limberg::bench {
namespace {

constexpr double converged = 3e-6;
constexpr int iterations_to_rest = 1500;

std::array<int64_t, 3> key(const Vec3& X) {
  return {std::llround(X[0] * 1e6), std::llround(X[1] * 1e6), std::llround(X[2] * 1e6)};
}

/// Places with a value each, found by rest position.
struct Field {
  std::map<std::array<int64_t, 3>, Vec3> x;
  Field() = default;
  Field(const Probe& p, const ElasticSolver& s) {
    const std::vector<Vec3> at = places_mm(p, s);
    for (size_t i = 0; i < at.size(); ++i) x[key(p.X_mm[i])] = at[i];
  }
};

/// Root mean square and largest distance over the places that both have.
Vec2 distance(const Field& a, const Field& b) {
  double sum = 0, most = 0, n = 0;
  for (const auto& [k, v] : a.x)
    if (const auto it = b.x.find(k); it != b.x.end()) {
      const double d = (v - it->second).squaredNorm();
      sum += d, most = std::max(most, d), ++n;
    }
  return {n > 0 ? std::sqrt(sum / n) : 0, std::sqrt(most)};
}

/// One model with its state before the pull and its equilibrium after it.
struct Subject {
  Probe probe;
  std::unique_ptr<fem::LbfgsSolver> solver;
  SolverState before;
  Field after;

  Subject(Probe p, Workers& workers, bool direct) : probe(std::move(p)) {
    // Tetrahedra have no lattice that a multilevel cycle could use.
    solver =
        std::make_unique<fem::LbfgsSolver>(workers, true, direct ? fem::MetricPolicy{1 << 30} : fem::MetricPolicy{});
    solver->set_gravity(probe.gravity_m_s2);
    solver->set_model(probe.model, {});
    pull(0);
    rest();
    before = solver->save();
    for (int f = 1; f <= probe_frames; ++f) {  // along the path of the trial: not another branch
      pull(double(f) / probe_frames);
      StepSettings s;
      s.max_iterations = 40;
      solver->step(s);
    }
    rest();
    after = Field(probe, *solver);
  }
  void pull(double share) {
    Spring h = probe.hook;
    h.target_mm += share * probe.pull_mm;
    solver->set_springs(std::span(&h, 1));
  }
  void rest() {
    StepSettings s;
    s.max_iterations = iterations_to_rest, s.tolerance = converged;
    solver->step(s);
  }
};

void run_trial(Subject& s, AccuracyTrial& t, const Field& fine, double frame_s, int steps_a_frame) {
  s.pull(0);
  s.solver->restore(s.before);
  StepSettings set;
  set.max_iterations = std::max(1, t.iterations / std::max(1, steps_a_frame)), set.tolerance = 1e-5;
  if (steps_a_frame > 0) set.dt_s = frame_s / steps_a_frame;
  StepSettings none = set;
  none.max_iterations = 0;
  s.solver->step(none);  // the metric for this kind of step: made when a scene opens
  Times frames;
  for (int f = 1; f <= probe_frames; ++f) {
    const double before = cpu_ms();
    s.pull(double(f) / probe_frames);
    for (int k = 0; k < std::max(1, steps_a_frame); ++k) s.solver->step(set);
    frames.add(cpu_ms() - before);
  }
  const Field now(s.probe, *s.solver);
  std::sort(frames.ms.begin(), frames.ms.end());
  t.nodes = s.probe.model->X_mm.size();
  t.frame_ms = frames.median(), t.frame_p95_ms = frames.ms[frames.ms.size() * 95 / 100];
  const Vec2 e = distance(now, fine);
  t.error_mm = e[0], t.error_max_mm = e[1];
  t.behind_mm = distance(now, s.after)[0], t.lattice_mm = distance(s.after, fine)[0];
}

void mark(AccuracyReport& r) {
  for (AccuracyTrial& t : r.trials) {
    t.pareto = t.material == "scene" && t.step == "quasi-static" &&
               std::none_of(r.trials.begin(), r.trials.end(), [&](const AccuracyTrial& o) {
                 return o.material == t.material && o.step == t.step && o.frame_ms <= t.frame_ms &&
                        o.error_mm <= t.error_mm && (o.frame_ms < t.frame_ms || o.error_mm < t.error_mm);
               });
  }
  AccuracyTrial* best = nullptr;
  const auto better = [&](const AccuracyTrial& a, const AccuracyTrial& b) {
    const bool fa = a.frame_p95_ms <= r.budget_ms, fb = b.frame_p95_ms <= r.budget_ms;
    return fa != fb ? fa : fa ? a.error_mm < b.error_mm : a.frame_p95_ms < b.frame_p95_ms;
  };
  for (AccuracyTrial& t : r.trials)
    if (t.own_kind && (!best || better(t, *best))) best = &t;
  if (!best) return;
  // Iterations beyond what this slow pull needs cost nothing at rest and are there when the hand is quick: of the
  // settings within a twentieth of the least error, the one with the most that fits.
  const double least = best->error_mm;
  for (AccuracyTrial& t : r.trials)
    if (t.own_kind && t.frame_p95_ms <= r.budget_ms && t.error_mm <= 1.05 * least && t.iterations > best->iterations)
      best = &t;
  best->chosen = true;
  r.point.cell_mm = best->cell_mm, r.point.iterations = best->iterations, r.point.frame_ms = best->frame_p95_ms;
  r.point.error_mm = best->error_mm, r.point.fits = best->frame_p95_ms <= r.budget_ms;
}

std::string settings_of(const AccuracyTrial& t) {
  return fmt::format("{}{}{}, {} iterations, p95 {:.2f} ms, lattice {:.3f} + behind {:.3f} mm, worst {:.2f} mm",
                     t.pareto ? "[Pareto] " : "", t.chosen ? "[chosen] " : "", std::to_string(t.nodes) + " nodes",
                     t.iterations, t.frame_p95_ms, t.lattice_mm, t.behind_mm, t.error_max_mm);
}

}  // namespace

AccuracyReport accuracy(const Scene& scene, const AccuracySettings& set) {
  AccuracyReport r;
  r.scene = scene.name;
  r.budget_ms = set.budget_ms > 0 ? set.budget_ms : 500 / scene.steps_per_s;
  r.point.budget_ms = r.budget_ms, r.point.scene_hash = scene.hash;
  const double start = cpu_ms(), frame_s = 1 / scene.steps_per_s;
  const auto spent = [&] { return (cpu_ms() - start) / 1000; };
  const auto say = [&](const std::string& s) {
    if (set.progress) set.progress(s);
  };
  const auto stopped = [&] { return spent() > set.limit_s || (set.interrupted && set.interrupted()); };
  InlineWorkers workers;
  const std::shared_ptr<const Body> body = build_body(scene);
  std::vector<double> factors =
      set.quick ? std::vector<double>{1.6, 1.25, 1, 0.8} : std::vector<double>{2, 1.6, 1.25, 1, 0.8, 0.65};
  const std::vector<int> iterations = set.quick ? std::vector<int>{4, 10, 20} : std::vector<int>{2, 5, 10, 20, 40};
  r.reference_cell_mm = scene.cell_mm * (set.quick ? 0.65 : 0.5);

  const auto labelled = [&](double cell) { return fmt::format("cells of {:.3g} mm", cell); };
  const std::string title = fmt::format("limberg bench accuracy{}, scene {:016x}, finest {:.9g} mm",
                                        set.quick ? " --quick" : "", scene.hash, r.reference_cell_mm);
  const KeptTrials kept(set.keep_file, title);
  std::optional<Field> fine_field;  // made when the first trial needs it
  const auto fine = [&]() -> const Field& {
    if (!fine_field) {
      say("reference, " + labelled(r.reference_cell_mm));
      fine_field = Subject(make_probe(scene, body, r.reference_cell_mm, workers), workers, false).after;
    }
    return *fine_field;
  };
  // `subject` gives null when there is no such thing.
  const auto add = [&](AccuracyTrial t, const std::function<Subject*()>& subject,
                       const std::function<const Field&()>& truth, int steps_a_frame) {
    if (const AccuracyTrial* done = kept.find(t)) {
      r.trials.push_back(*done);
      ++r.kept;
      return;
    }
    if (stopped()) {
      ++r.left_out;
      return;
    }
    Subject* s = subject();
    if (!s) return;
    run_trial(*s, t, truth(), frame_s, steps_a_frame);
    r.trials.push_back(t);
    kept.add(t);
  };
  for (double f : factors) {
    AccuracyTrial t;
    t.cell_mm = scene.cell_mm * f;
    std::unique_ptr<Subject> made;
    const auto subject = [&] {
      if (!made) {
        say(labelled(t.cell_mm));
        made = std::make_unique<Subject>(make_probe(scene, body, t.cell_mm, workers), workers, false);
      }
      return made.get();
    };
    for (int steps :
         set.quick ? (scene.dynamic ? std::vector<int>{1} : std::vector<int>{0}) : std::vector<int>{0, 1, 2}) {
      t.step = steps == 0 ? "quasi-static" : steps == 1 ? "backward Euler" : "backward Euler, 2 a frame";
      t.own_kind = scene.dynamic ? steps == 1 : steps == 0;
      for (int its : iterations) {
        if (!t.own_kind && its != 10 && its != 40) continue;
        t.iterations = its;
        add(t, subject, fine, steps);
      }
    }
  }
  if (!set.quick) {
    struct Other {
      const char *element, *material;
      std::shared_ptr<const FemModel> (*make)(const FemModel&);
    };
    const Other others[] = {{"hexahedra, fully integrated", "scene", with_full_integration},
                            {"linear tetrahedra", "scene", with_tetrahedra},
                            {"hexahedra", "scene, nu .49", [](const FemModel& m) { return with_poisson(m, 0.49); }},
                            {"hexahedra", "scene, nu .499", [](const FemModel& m) { return with_poisson(m, 0.499); }},
                            {"hexahedra", "Mooney-Rivlin", with_mooney_rivlin}};
    for (const Other& o : others) {
      const bool own = std::string(o.material) == "scene", tets = std::string(o.element) == "linear tetrahedra";
      const auto make = [&](double factor) -> std::unique_ptr<Subject> {
        Probe p = make_probe(scene, body, scene.cell_mm * factor, workers);
        p.model = o.make(*p.model);
        if (!p.model) return nullptr;
        return std::make_unique<Subject>(std::move(p), workers, tets);
      };
      // Another material has an equilibrium of its own; its reference is as fine as the time allows.
      std::optional<Field> own_truth;
      const auto truth = [&]() -> const Field& {
        if (own) return fine();
        if (!own_truth) own_truth = make(0.65)->after;
        return *own_truth;
      };
      for (double f : {1.6, 1.0}) {
        std::unique_ptr<Subject> made;
        const auto subject = [&] {
          if (!made) {
            say(std::string(o.element) + ", " + o.material);
            made = make(f);
          }
          return made.get();
        };
        AccuracyTrial t;
        t.cell_mm = scene.cell_mm * f, t.element = o.element, t.material = o.material, t.own_kind = false;
        for (int its : {10, 40}) t.iterations = its, add(t, subject, truth, 0);
      }
    }
  }
  mark(r);
  r.cpu_s = spent();
  return r;
}

Result AccuracyReport::result() const {
  Result out;
  const std::string reference = fmt::format("equilibrium with cells of {:.3g} mm", reference_cell_mm);
  for (const AccuracyTrial& t : trials) {
    const std::string label = fmt::format("{:.3g} mm cells", t.cell_mm);
    out.rows.push_back({label, t.element + "; " + t.material + "; " + t.step, settings_of(t), t.frame_ms, false,
                        t.error_mm, "mm", reference, true});
  }
  out.bars.push_back({"frame of the chosen setting, 95th percentile (ms)", point.frame_ms, false, budget_ms, false,
                      point.fits, "the budget asked for"});
  std::string text = fmt::format(
      "operating point for {:.2f} ms a frame: cells of {:.3g} mm, {} iterations: error {:.3f} mm (root mean square), "
      "{:.2f} ms at the 95th percentile{}",
      budget_ms, point.cell_mm, point.iterations, point.error_mm, point.frame_ms,
      point.fits ? "" : "; nothing fits the budget, this is the fastest");
  out.notes.push_back(text);
  text = fmt::format(
      "{} trials in {:.0f} s of CPU time{}. Times are those of tetrahedra and other laws on the general path in double "
      "precision, of the scenes' element on the vectorised one.",
      trials.size() - kept, cpu_s,
      left_out ? (", " + std::to_string(left_out) + " left out for want of time").c_str() : "");
  out.notes.push_back(text);
  if (kept)
    out.notes.push_back(std::to_string(kept) + " more trials were taken from an earlier run into the same folder.");
  return out;
}

std::string AccuracyReport::csv() const {
  std::string s =
      "cell_mm,nodes,element,material,step,iterations,frame_ms,frame_p95_ms,error_rms_mm,error_max_mm,lattice_rms_mm,"
      "behind_rms_mm,pareto,chosen\n";
  for (const AccuracyTrial& t : trials) {
    const std::string line =
        fmt::format("{:.4g},{},\"{}\",\"{}\",\"{}\",{},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},{:.5f},{},{}\n", t.cell_mm,
                    t.nodes, t.element, t.material, t.step, t.iterations, t.frame_ms, t.frame_p95_ms, t.error_mm,
                    t.error_max_mm, t.lattice_mm, t.behind_mm, int(t.pareto), int(t.chosen));
    s += line;
  }
  return s;
}

std::string AccuracyReport::svg() const {
  LineChart c;
  c.description = "Error against run time of " + scene + ", with the Pareto front";
  c.x = {"CPU time of a frame, ms (median)", true, {}, {}}, c.y = {"error, mm (root mean square)", true, {}, {}};
  c.height = 460;
  ChartSeries front{"Pareto front", {}, {}, true}, chosen{"chosen for the budget", {}, {}, true},
      others{"other elements", {}, {}, true};
  std::map<double, ChartSeries, std::greater<>> by_cell;
  for (const AccuracyTrial& t : trials) {
    if (t.material != "scene") continue;
    ChartSeries* s = nullptr;
    if (t.element != "hexahedra") {
      s = &others;
    } else if (t.step == "quasi-static") {
      s = &by_cell[t.cell_mm];
      const std::string name = fmt::format("{:.3g} mm cells", t.cell_mm);
      s->name = name, s->markers = true;
    } else {
      continue;
    }
    if (s == &others && !s->x.empty()) s->x.push_back(std::nan("")), s->y.push_back(std::nan(""));
    s->x.push_back(t.frame_ms), s->y.push_back(t.error_mm);
  }
  std::vector<const AccuracyTrial*> on;
  for (const AccuracyTrial& t : trials) {
    if (t.pareto) on.push_back(&t);
    if (t.chosen) chosen.x.push_back(t.frame_ms), chosen.y.push_back(t.error_mm);
  }
  std::sort(on.begin(), on.end(), [](auto* a, auto* b) { return a->frame_ms < b->frame_ms; });
  for (const AccuracyTrial* t : on) front.x.push_back(t->frame_ms), front.y.push_back(t->error_mm);
  c.series.push_back(front);
  for (auto& [cell, s] : by_cell) c.series.push_back(s);
  if (!others.x.empty()) c.series.push_back(others);
  c.series.push_back(chosen);
  c.x_marks.push_back({budget_ms, "budget"});
  return limberg::svg(c);
}

}  // namespace limberg::bench
