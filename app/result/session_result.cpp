#include "app/result/session_result.h"

#include "app/assembly/exercise.h"
#include "app/head/report.h"
#include "app/report/report_names.h"
#include "app/result/metrics.h"
#include "app/result/settled_forces.h"
#include "app/result/times.h"
#include "sim/commands/script.h"
#include "sim/commands/strokes.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

namespace {

/// damage: of a recording, in events.
struct ResultDamage {
  int64_t events, truncated, bad_sync, bad_length, bad_payload, out_of_order, missing, skipped_bytes;
  MaybeText first;
};
void fields(ResultDamage& x, auto&& f) {
  f("events", x.events), f("truncated", x.truncated), f("bad_sync", x.bad_sync), f("bad_length", x.bad_length);
  f("bad_payload", x.bad_payload), f("out_of_order", x.out_of_order), f("missing", x.missing);
  f("skipped_bytes", x.skipped_bytes), f("first", x.first);
}

std::vector<std::string> parts_of(const Assembly& a) {
  std::vector<std::string> parts;
  if (a.scene.flesh)
    parts = {a.scene.source == Scene::Source::block ? "block" : "surface", "lattice", "elastic solver"};
  if (a.scene.flesh && a.scene.can_cut) parts.push_back("cutter");
  if (a.scene.flesh && a.scene.dynamic) parts.push_back("dynamics");
  if (a.head) {
    parts.push_back("bones");
    parts.push_back("fragments, with a Bullet world while one is held");
    if (a.head->has_face()) parts.push_back("face");
    if (!a.head->tissues().empty()) parts.push_back("tissue between face and bone");
  }
  parts.push_back("device front end");
  return parts;
}

ResultDevice device_of(Assembly& a, const SessionFigures& f) {
  const FrontEndCounts c = a.front.counts();
  ResultDevice d;
  d.ticks = f.device.ticks ? int64_t(f.device.ticks) : f.ticks;
  d.late_ticks = f.device.late;
  d.skipped_ticks = f.device.skipped;
  d.wake_us = times_of(f.device.wake, 1e-3, {.p999 = true});
  d.work_us = times_of(f.device.work, 1e-3, {.p999 = true});
  d.snapshot_age_ms = times_of(f.device.age, 1e-6, {});
  d.events_lost = int64_t(a.device.events_lost()) + a.solver.event_gaps();
  d.samples_unrecorded = a.device.samples_lost();
  d.samples = c.sources.samples;
  d.samples_malformed = c.sources.malformed;
  d.samples_lost = c.sources.lost;
  d.missed_presses = c.missed_presses;
  d.dropped_gestures = a.solver.dropped_gestures();
  d.scheduling = f.scheduling;
  return d;
}

ResultSolver solver_of(Assembly& a, const SessionFigures& f) {
  ResultSolver s;
  s.steps = a.solver.steps();
  s.late_steps = f.solver.late;
  s.skipped_steps = f.solver.skipped;
  s.step_ms = times_of(f.solver.work, 1e-6, {.p95 = true});
  s.residual = a.solver.last().residual;
  s.distance_mm = a.solver.last().distance_mm;
  s.settle_steps = f.settle_steps;
  if (!f.hand.empty()) s.hand = f.hand, s.waited_ms = double(f.waited_ns) * 1e-6;
  if (f.hand == "slowed") s.slowed_ms = double(f.slowed_ns) * 1e-6, s.slowest_pace = f.slowest;
  s.describe = a.world->skin() ? a.world->skin()->solver().describe() : std::string("simplex meshes of face and bone");
  return s;
}

ResultStory story_of(const Assembly& a) {
  ResultStory story;
  std::vector<ResultStage> stages;
  for (const StageRow& s : a.solver.stages()) {
    stages.push_back(stage_of(s));
    stages.back().t_s = s.t_s, stages.back().sutures = s.shown.sutures.size();
  }
  story.stages = unless_empty(std::move(stages));
  story.series = series_of(a.solver.series());
  story.commands = a.solver.commands();
  story.script = script_of(a.done);
  story.refused.emplace();
  for (const Refusal& x : a.solver.refused()) story.refused->push_back({x.t_s, {}, x.command, x.reason});
  return story;
}

}  // namespace

ResultStage stage_of(const StageRow& s) {
  ResultStage stage;
  stage.name = s.name;
  stage.picture = report_names::stage_picture(s.number, s.name);
  stage.residual = double(s.shown.residual);
  return stage;
}

ResultSeries series_of(const SolverSeries& s) {
  const auto list = [](const std::vector<float>& v) { return std::vector<double>(v.begin(), v.end()); };
  ResultSeries told{list(s.t_s), list(s.residual), list(s.distance_mm), list(s.closure_N), list(s.suture_max_N), {}};
  const SettledForces settled = settled_forces(*told.residual, *told.closure_N, *told.suture_max_N);
  if (settled.pulling > 0) told.unsettled = int64_t(settled.unsettled);
  return told;
}

MaybeList<std::string> script_of(std::span<const Command> done) {
  std::vector<std::string> lines;
  for (const Command& c : done) lines.push_back(to_json_line(c));
  return unless_empty(std::move(lines));
}

void fill_verdict(Result& r, std::span<const ResultVerdict> verdict) {
  r.set_empty_list("/verdict");
  for (const ResultVerdict& v : verdict) {
    const std::string at = "/verdict/" + std::to_string(r.entries("/verdict"));
    write_fields(r, at, v);
    if (v.unit.empty()) r.set(at + "/unit", "");  // of every line, that a reader need not ask
    if (v.place.empty()) r.set(at + "/place", "");
  }
}

namespace {

/// What a look at the session tells that no figure of the skin does.
VerdictOf looked_at(Assembly& a, const SessionFigures& f) {
  VerdictOf v;
  v.residual = a.solver.last().residual;
  v.cut_short = f.interrupted || f.closed;
  v.pace = Pace{int64_t(a.solver.steps()), int64_t(f.solver.skipped), double(f.device.age.percentile_ns(0.99)) * 1e-6,
                double(f.device.age.max_ns()) * 1e-6};
  if (f.hand == "slowed") v.pace->slowed = SlowedPace{f.duration_s, double(f.slowed_ns) * 1e-9, f.slowest};
  if (a.head && a.head->has_face()) {
    Snapshot s;
    a.patient->fill(s);
    v.bone = bone_outside(s);
  }
  return v;
}

}  // namespace

std::vector<ResultVerdict> fill_session(Result& r, Assembly& a, const SessionFigures& f, bool real_time,
                                        const Lesson* lesson, bool printed) {
  ResultRun run;
  run.scene_title = a.scene.name, run.scene_note = a.scene.note;
  run.mode = real_time ? "realtime" : "lockstep";
  run.duration_s = f.duration_s;
  run.interrupted = f.interrupted;
  run.state_hash = hex(f.state_hash);
  run.topology_hash = hex(a.patient->topology_hash());
  run.scene_hash = hex(a.scene.hash);
  run.parts = parts_of(a);
  run.memory_mb = peak_memory_mb();
  run.workers = a.workers.count();
  run.device = device_of(a, f);
  run.solver = solver_of(a, f);
  run.render = {a.render.frames(), f.render.skipped, times_of(f.render.work, 1e-6, {.p95 = true})};
  run.latency_ms = {times_of(f.sample_to_snapshot, 1e-6, {.max = false}),
                    times_of(f.sample_to_frame, 1e-6, {.max = false})};
  write_fields(r, "", run);
  if (a.head) fill_head(r, *a.head);
  VerdictOf look = looked_at(a, f);
  if (!a.world->skin()) {
    std::vector<Judgement> judged;
    if (a.head) {
      Exercise e = exercise(a.done, {}, std::nullopt);
      e.time_s = f.duration_s, e.hand = a.solver.hand(), e.refused = int(a.solver.refused().size());
      judged = fill_exercise(
          r, e, lesson ? bone_values(*lesson->bone, *a.head, look.bone, a.done, lesson->words.limits) : LessonValues{},
          lesson);
      if (printed) print_judgements(judged);
    }
    look.judged = judged;
    write_fields(r, "", story_of(a));
    std::vector<ResultVerdict> verdict = verdict_of(look);
    fill_verdict(r, verdict);
    return verdict;
  }
  MeasureAlso also;
  also.landmarks = a.scene.landmarks;
  if (lesson)
    also.plan = lesson->plan,
    also.landmarks.insert(also.landmarks.end(), lesson->landmarks.begin(), lesson->landmarks.end());
  const Metrics metrics = measure_world(*a.world, a.done, also);
  fill_metrics(r, metrics);
  const Skin skin(a.world->skin()->spec().body);
  Exercise e = exercise(a.done, metrics, plan_of(skin, also.plan, join_strokes(a.done)));
  e.time_s = f.duration_s;
  e.hand = a.solver.hand();
  e.refused = int(a.solver.refused().size());
  const std::vector<Judgement> judged = fill_exercise(
      r, e,
      lesson && lesson->bone ? bone_values(*lesson->bone, *a.head, look.bone, a.done, lesson->words.limits)
                             : lesson_values(metrics, e.design),
      lesson);
  if (printed) print_judgements(judged);
  write_fields(r, "", story_of(a));
  look.metrics = &metrics, look.body = a.world->skin()->spec().body.get();
  look.cell_mm = a.world->skin()->spec().cell_mm, look.wound_level = a.world->skin()->spec().wound_level;
  look.judged = judged;
  std::vector<ResultVerdict> verdict = verdict_of(look);
  fill_verdict(r, verdict);
  return verdict;
}

void fill_damage(Result& r, const LogDamage& d) {
  if (d.total() == 0) return;
  write_fields(r, "/damage",
               ResultDamage{d.total(), d.truncated, d.bad_sync, d.bad_length, d.bad_payload, d.out_of_order, d.missing,
                            d.skipped_bytes, d.first_message});
}

}  // namespace limberg
