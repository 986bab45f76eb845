#include "app/commands/operate_head.h"

#include <cstdio>

#include "app/assembly/assembly.h"
#include "app/assembly/exercise.h"
#include "app/assembly/operation.h"
#include "app/commands/this_call.h"
#include "app/commands/unfinished.h"
#include "app/export/page_model.h"
#include "app/head/build.h"
#include "app/head/report.h"
#include "app/pictures/pictures.h"
#include "app/program/interrupt.h"
#include "app/report/viewer.h"
#include "app/result/metrics.h"
#include "app/result/progress.h"
#include "app/result/session_result.h"
#include "app/session/clock.h"
#include "app/session/workers_pool.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

int operate_head(const Scene& scene, const Script& script, const Lesson* lesson, bool keep_going,
                 const CommonOptions& common) {
  WorkersPool workers(common.worker_count());
  const int64_t t0 = RealClock::monotonic_ns();
  const std::unique_ptr<World> world = make_world(scene, workers);
  const Head& head = *world->head();
  if (lesson) check_lesson(*lesson, &head);
  const double built_s = double(RealClock::monotonic_ns() - t0) * 1e-9;
  WorldPatient patient(*world, scene.tools.max_depth_mm);
  Progress progress("operate");
  OperationSettings set;
  set.interrupted = interrupted;
  set.progress = [&](size_t done, size_t total) { progress.show(double(done), double(total), "actions"); };
  set.keep_going = keep_going;
  std::string notes;
  std::vector<Command> actions;  // that were carried out
  std::optional<PageModel> model;
  Snapshot now;
  if (!common.out_dir.empty() && viewer_is_built()) patient.fill(now), model.emplace("act").frame(0, now);
  set.on_done = [&](const ScriptLine& l, const std::string& note) {
    actions.push_back(l.command);
    if (model) patient.fill(now), model->acted(l.command, now);
    if (!note.empty())
      notes += "  note      line " + std::to_string(l.line) + ", " + action_name(l.command) + ": " + note + "\n";
  };
  Snapshot first;
  if (!common.out_dir.empty()) patient.fill_with_field(first);  // for the pictures
  const OperationOutcome o = operate(patient, script, set);
  progress.clear();
  const bool whole = !tell_unfinished(o, script.lines.size(), script.name);
  std::printf("scene       %s, built in %.1f s\n", scene.name.c_str(), built_s);
  std::fputs(notes.c_str(), stdout);
  print_head(head);
  std::printf("solve       %.0f ms, residual %.1e\nstate_hash  %s\n", o.solve_ms, o.last.residual,
              hex(patient.state_hash()).c_str());
  Result r("operate", scene.name);
  ResultRun run;
  run.scene_title = scene.name, run.scene_note = scene.note, run.scene_path = whole_path(scene.path);
  run.solve_ms = o.solve_ms, run.residual = o.last.residual;
  run.state_hash = hex(patient.state_hash()), run.topology_hash = hex(patient.topology_hash());
  run.memory_mb = peak_memory_mb();
  ResultStory story;
  fill_unfinished(run, story, o);
  write_fields(r, "", run);
  story.script = script_of(actions);
  write_fields(r, "", story);
  fill_head(r, head);
  VerdictOf look;
  look.residual = o.last.residual, look.cut_short = o.interrupted;
  std::optional<Metrics> metrics;
  if (world->skin()) {
    metrics = measure_world(*world, actions);
    fill_metrics(r, *metrics);
    look.metrics = &*metrics, look.body = world->skin()->spec().body.get(),
    look.cell_mm = world->skin()->spec().cell_mm, look.wound_level = world->skin()->spec().wound_level;
  }
  if (head.has_face()) {
    Snapshot s;
    patient.fill(s);
    look.bone = bone_outside(s);
  }
  const std::vector<Judgement> judged =
      fill_exercise(r, exercise(actions, metrics.value_or(Metrics{}), std::nullopt),
                    !lesson        ? LessonValues{}
                    : lesson->bone ? bone_values(*lesson->bone, head, look.bone, actions, lesson->words.limits)
                                   : lesson_values(metrics.value_or(Metrics{}), std::nullopt),
                    lesson);
  print_judgements(judged);
  look.judged = judged;
  const std::vector<ResultVerdict> verdict = verdict_of(look);
  fill_verdict(r, verdict);
  for (const StageRow& s : o.stages) append(r, "/stages", stage_of(s));
  const bool at_rest = o.last.residual <= 1e-4;
  bool reached = whole && at_rest && !is_bad(verdict);
  r.set_ok(reached);
  if (!common.out_dir.empty()) {
    Snapshot last;
    patient.fill_with_field(last);
    if (o.interrupted) leave_figures(r, common);  // who is in a hurry may not wait for the pictures
    if (!draw_head_pictures(common.out_dir, o.stages, first, last, scene_camera(scene), head, common.words()))
      mark_stopped(r), reached = false;
    if (model) model->ended(last), model->leave(common.out_dir, scene.name, scene_camera(scene), kHeadAspect);
    leave_head_figures(r, head, scene.head->normal_files, common.out_dir, last, scene_camera(scene), workers);
  }
  write_fields(r, "", made_by(this_call()));
  leave_result(r, common);
  print_verdict(verdict);
  if (!at_rest && !o.interrupted) say("the patient did not come to rest: the face still moves");
  return reached ? kDone : kGoalMissed;
}

}  // namespace limberg
