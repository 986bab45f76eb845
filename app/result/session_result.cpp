#include "app/result/session_result.h"

#include "app/assembly/exercise.h"
#include "app/head/report.h"
#include "app/report/report_names.h"
#include "app/result/metrics.h"
#include "app/result/schema.h"
#include "sim/commands/strokes.h"

namespace limberg {

namespace {

void fill_parts(Result& r, const Assembly& a) {
  int n = 0;
  const auto part = [&](const std::string& name) { r.set("/parts/" + std::to_string(n++), name); };
  if (a.scene.flesh) {
    part(a.scene.source == Scene::Source::block ? "block" : "surface");
    part("lattice");
    part("elastic solver");
  }
  if (a.scene.flesh && a.scene.can_cut) part("cutter");
  if (a.scene.flesh && a.scene.dynamic) part("dynamics");
  if (a.head) {
    part("bones");
    part("fragments, with a Bullet world while one is held");
    if (a.head->has_face()) part("face");
    if (!a.head->tissues().empty()) part("tissue between face and bone");
  }
  part("device front end");
}

void fill_lanes(Result& r, Assembly& a, const SessionFigures& f) {
  r.set("/device/ticks", f.device.ticks ? f.device.ticks : uint64_t(f.ticks));
  r.set("/device/late_ticks", f.device.late);
  r.set("/device/skipped_ticks", f.device.skipped);
  r.set_times("/device/wake_us", f.device.wake, 1e-3, {.p999 = true});
  r.set_times("/device/work_us", f.device.work, 1e-3, {.p999 = true});
  r.set_times("/device/snapshot_age_ms", f.device.age, 1e-6, {});
  r.set("/device/events_lost", a.device.events_lost() + uint64_t(a.solver.event_gaps()));
  r.set("/device/samples_unrecorded", a.device.samples_lost());
  const FrontEndCounts c = a.front.counts();
  r.set("/device/samples", c.sources.samples);
  r.set("/device/samples_malformed", c.sources.malformed);
  r.set("/device/samples_lost", c.sources.lost);
  r.set("/device/missed_presses", c.missed_presses);
  r.set("/device/dropped_gestures", int64_t(a.solver.dropped_gestures()));
  if (!f.scheduling.empty()) r.set("/device/scheduling", f.scheduling);
  r.set("/solver/steps", a.solver.steps());
  r.set("/solver/late_steps", f.solver.late);
  r.set("/solver/skipped_steps", f.solver.skipped);
  r.set_times("/solver/step_ms", f.solver.work, 1e-6, {.p95 = true});
  r.set("/solver/residual", a.solver.last().residual);
  r.set("/solver/distance_mm", a.solver.last().distance_mm);
  r.set("/solver/settle_steps", f.settle_steps);
  r.set("/solver/describe",
        a.world->skin() ? a.world->solver().describe() : std::string("simplex meshes of face and bone"));
  r.set("/render/frames", a.render.frames());
  r.set("/render/skipped_frames", f.render.skipped);
  r.set_times("/render/frame_ms", f.render.work, 1e-6, {.p95 = true});
  r.set_times("/latency_ms/sample_to_snapshot", f.sample_to_snapshot, 1e-6, {.max = false});
  r.set_times("/latency_ms/sample_to_frame", f.sample_to_frame, 1e-6, {.max = false});
}

void fill_story(Result& r, const Assembly& a) {
  for (const StageRow& s : a.solver.stages())
    append(r, "/stages",
           ResultStage{s.name,
                       report_names::stage_picture(s.number, s.name),
                       {},
                       s.t_s,
                       double(s.shown.residual),
                       int64_t(s.shown.sutures.size()),
                       {}});
  const SolverSeries& s = a.solver.series();
  r.set("/series/t_s", std::span<const float>(s.t_s));
  r.set("/series/residual", std::span<const float>(s.residual));
  r.set("/series/distance_mm", std::span<const float>(s.distance_mm));
  r.set("/series/closure_N", std::span<const float>(s.closure_N));
  r.set("/series/suture_max_N", std::span<const float>(s.suture_max_N));
  r.set("/commands", a.solver.commands());
  for (size_t i = 0; i < a.done.size(); ++i) r.set("/script/" + std::to_string(i), to_json_line(a.done[i]));
  r.set_empty_list("/refused");
  for (const Refusal& x : a.solver.refused()) append(r, "/refused", ResultRefusal{x.t_s, x.command, x.reason});
}

}  // namespace

void fill_session(Result& r, Assembly& a, const SessionFigures& f, bool real_time, const Lesson* lesson) {
  r.set("/scene_title", a.scene.name);
  r.set("/scene_note", a.scene.note);
  r.set("/mode", real_time ? "realtime" : "lockstep");
  r.set("/duration_s", f.duration_s);
  r.set("/interrupted", f.interrupted);
  r.set_hash("/state_hash", f.state_hash);
  r.set_hash("/topology_hash", a.patient->topology_hash());
  r.set_hash("/scene_hash", a.scene.hash);
  fill_parts(r, a);
  r.set("/memory_mb", peak_memory_mb());
  r.set("/workers", a.workers.count());
  fill_lanes(r, a, f);
  if (a.head) fill_head(r, *a.head);
  if (!a.world->skin()) {
    fill_story(r, a);
    return;
  }
  MeasureAlso also;
  also.landmarks = a.scene.landmarks;
  if (lesson)
    also.plan = lesson->plan,
    also.landmarks.insert(also.landmarks.end(), lesson->landmarks.begin(), lesson->landmarks.end());
  const Metrics metrics = measure_world(*a.world, a.done, also);
  fill_metrics(r, metrics);
  const Skin skin(a.world->spec().body);
  Exercise e = exercise(a.done, metrics, plan_of(skin, also.plan, join_strokes(a.done)));
  e.time_s = f.duration_s;
  e.hand = a.solver.hand();
  e.refused = int(a.solver.refused().size());
  print_judgements(fill_exercise(r, e, metrics, lesson));
  fill_story(r, a);
}

void fill_damage(Result& r, const LogDamage& d) {
  if (d.total() == 0) return;
  r.set("/damage/events", d.total());
  r.set("/damage/truncated", d.truncated);
  r.set("/damage/bad_sync", d.bad_sync);
  r.set("/damage/bad_length", d.bad_length);
  r.set("/damage/bad_payload", d.bad_payload);
  r.set("/damage/out_of_order", d.out_of_order);
  r.set("/damage/missing", d.missing);
  r.set("/damage/skipped_bytes", d.skipped_bytes);
  r.set("/damage/first", d.first_message);
}

}  // namespace limberg
