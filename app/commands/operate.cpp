#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "app/assembly/cases.h"
#include "app/assembly/exercise.h"
#include "app/assembly/operation.h"
#include "app/commands/closure_force.h"
#include "app/commands/left_recordings.h"
#include "app/commands/numbers.h"
#include "app/commands/operate_head.h"
#include "app/commands/operate_orders.h"
#include "app/commands/session_command.h"
#include "app/commands/this_call.h"
#include "app/commands/unfinished.h"
#include "app/export/page_model.h"
#include "app/pictures/pictures.h"
#include "app/program/interrupt.h"
#include "app/program/shipped.h"
#include "app/report/report_names.h"
#include "app/report/viewer.h"
#include "app/result/discretisation.h"
#include "app/result/error_goal.h"
#include "app/result/metrics.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/session_result.h"
#include "app/result/tables.h"
#include "app/session/workers_pool.h"
#include "sim/base/error.h"
#include "sim/commands/strokes.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

namespace {

struct OperateOptions {
  std::string scene, script, lesson, fields, of_case;
  double cell_mm = 0;
  std::vector<double> cells;
  std::string error;  // --error
  double limit_s = 600;
  std::vector<std::string> orders;
  bool keep_going = false;
  CommonOptions common;
};

/// One run's row of the convergence table.
struct Row {
  double cell_mm = 0, solve_ms = 0, residual = 0, distance_mm = 0;
  double fitted_mm = 0;  // cube root of a cell of the lattice, which is fitted to a block
  size_t nodes = 0;
  Metrics key;
};

std::vector<SizedFigures> figures_of(const std::vector<Row>& rows) {
  std::vector<SizedFigures> out;
  for (const Row& x : rows) out.push_back({x.fitted_mm, x.key, x.distance_mm});
  return out;
}

/// What came of --error, in words and in the result; true: every figure is as near as was asked for.
bool tell_error_goal(Result& r, const ErrorGoal& goal, double share) {
  ResultErrorGoal told{share, goal.met(), goal.why(), {}};
  std::printf("asked for   %g %% of each figure: %s; it ended because %s\n", 100 * share,
              goal.met() ? "reached" : "not reached", goal.why().c_str());
  for (const GoalRow& x : goal.rows()) {
    std::printf("  %-20s %10.4g +- %-8.2g %s (%.2g allowed)\n", x.name.c_str(), x.value, x.error,
                x.met() ? "reached" : "missed", x.allowed);
    told.figures.push_back({x.name, x.value, x.error, x.allowed, x.met()});
  }
  write_fields(r, "/error_goal", told);
  return goal.met();
}

void fill_convergence(Result& r, const std::vector<Row>& rows) {
  for (size_t i = 0; i < rows.size(); ++i) {
    const Row& x = rows[i];
    ResultConvergence c{x.cell_mm,
                        x.key.closure_force_N,
                        x.key.suture_gap_max_mm,
                        x.key.suture_force_max_N,
                        x.key.dog_ear_mm,
                        x.residual,
                        x.solve_ms,
                        x.nodes,
                        x.fitted_mm,
                        x.distance_mm,
                        {}};
    if (i > 0) {
      const Metrics& y = rows[i - 1].key;  // the coarser one before it
      c.difference = {x.key.closure_force_N - y.closure_force_N, x.key.suture_gap_max_mm - y.suture_gap_max_mm,
                      x.key.dog_ear_mm - y.dog_ear_mm};
    }
    append(r, "/convergence", c);
  }
  const std::vector<FigureError> errors = discretisation_errors(figures_of(rows));
  fill_discretisation(r, errors);
  if (!errors.empty()) std::printf("%-20s %10s %10s %12s\n", "figure", "finest", "+-", "extrapolated");
  for (const FigureError& e : errors) {
    const Extrapolation& x = e.estimate;
    std::printf("%-20s %10.4g %10.2g %12s  %s\n", e.name.c_str(), x.value, x.error.value_or(0),
                x.extrapolated ? std::to_string(*x.extrapolated).c_str() : "-", x.says.c_str());
  }
}

void fill_operation(Result& r, const World& world, const Scene& scene, const OperationOutcome& o,
                    const Metrics& metrics) {
  const FemModel& m = world.skin()->solver().model();
  size_t free_nodes = 0;
  for (const Held h : m.fixed) free_nodes += !h.all();
  ResultRun run;
  run.scene_title = scene.name, run.scene_note = scene.note, run.scene_path = whole_path(scene.path);
  run.lattice = {world.skin()->spec().cell_mm,
                 int64_t(world.skin()->spec().seed),
                 m.X_mm.size(),
                 o.cells,
                 m.cells.size(),
                 3 * free_nodes};
  run.solve_ms = o.solve_ms, run.residual = o.last.residual, run.distance_mm = o.last.distance_mm;
  run.state_hash = hex(world.state_hash()), run.topology_hash = hex(world.topology_hash());
  run.memory_mb = peak_memory_mb();
  ResultStory story;
  fill_unfinished(run, story, o);
  write_fields(r, "", run);
  fill_metrics(r, metrics);
  std::vector<ResultStage> stages;
  for (const StageRow& s : o.stages) stages.push_back(stage_of(s)), stages.back().sutures = s.shown.sutures.size();
  story.stages = unless_empty(std::move(stages));
  story.series.residual.emplace(o.series.residual.begin(), o.series.residual.end());
  story.series.distance_mm.emplace(o.series.distance_mm.begin(), o.series.distance_mm.end());
  write_fields(r, "", story);
}

constexpr const char* kFieldsHeader =
    "chart_x_mm,chart_y_mm,area_mm2,stretch,least_stretch,stress_kPa,least_stress_kPa,angle_to_fibres_deg,perfusion_"
    "index";

/// Every skin triangle at rest: where, how it is stretched and pulled, which way, and what reaches it.
void write_fields(const std::string& file, const World& world) {
  Snapshot s;
  world.fill(s);
  const SurfaceView& view = s.topology->view;
  const Body& body = *world.skin()->spec().body;
  const Skin skin(world.skin()->spec().body);
  const std::vector<MembraneState> states = skin_states(view, s.x_mm, body);
  const Perfusion p = perfusion(view, skin);
  std::string text = std::string(kFieldsHeader) + "\n";
  std::string line;
  for (size_t t = 0; t < states.size(); ++t) {
    const MembraneState& m = states[t];
    if (!(m.area_mm2 > 0)) continue;
    const ChartPoint c = body.to_chart(
        (view.X_mm[size_t(view.tri[t][0])] + view.X_mm[size_t(view.tri[t][1])] + view.X_mm[size_t(view.tri[t][2])]) /
        3);
    line = fmt::format("{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},{:.4f},{:.4f},{:.2f},{:.3f}\n", c.x(), c.y(), m.area_mm2,
                       m.stretch, m.least_stretch, m.stress_kPa, m.least_stress_kPa, m.angle_deg, double(p.index[t]));
    text += line;
  }
  write_whole_file(file, text);
}

/// What a case names, as far as the call does not.
OperateOptions with_case(OperateOptions opt) {
  if (opt.of_case.empty()) {
    if (opt.scene.empty() || opt.script.empty())
      throw InputError("", 0,
                       "operate wants a scene and a script; expected SCENE SCRIPT or --case NAME, as in "
                       "limberg operate --help");
    return opt;
  }
  const Case c = open_case(opt.of_case);
  opt.scene = c.lesson.scene, opt.script = c.script;
  if (opt.lesson.empty()) opt.lesson = c.lesson.file;
  return opt;
}

int run_operate(const OperateOptions& asked) {
  catch_interrupts();
  const OperateOptions opt = with_case(asked);
  opt.common.prepare();
  offer_to_continue({opt.common.out_dir});
  if (!opt.fields.empty()) check_writable(opt.fields), check_replaces(opt.fields, kFieldsHeader, "a table of fields");
  const Scene scene = open_scene(opt.scene);
  const std::string script_file = given_or_shipped(opt.script);
  std::optional<Repro> repro;
  if (std::error_code ec; std::filesystem::is_regular_file(script_file, ec))
    if (const std::string text = read_whole_file(script_file); looks_like_repro(text))
      repro = parse_repro(text, opt.script);
  if (repro && repro->scene_hash != scene.hash)
    throw InputError(opt.script, 0,
                     "was written with another scene (" + repro->scene + ", hash " + hex(repro->scene_hash) +
                         "); expected that of " + scene.name + ", hash " + hex(scene.hash));
  const Script script = repro ? script_of(*repro, opt.script) : load_script(script_file);
  std::optional<double> share;
  if (!opt.error.empty() && !(share = parse_share(opt.error)))
    throw InputError("", 0, "--error: '" + opt.error + "' is none; expected a share of each figure from 0.1% to 100%");
  std::optional<Lesson> lesson;
  if (!opt.lesson.empty()) lesson = open_lesson(opt.lesson);
  if (lesson) check_lesson(*lesson, scene);
  if (scene.head) {
    if (!opt.cells.empty() || share || !opt.orders.empty() || !opt.fields.empty())
      throw InputError(
          opt.scene, 0,
          "has a head: --cells, --error, --orders and --fields are for scenes of skin; expected none of them");
    return operate_head(scene, script, lesson ? &*lesson : nullptr, opt.keep_going, opt.common);
  }
  std::vector<double> cells = opt.cells;
  for (size_t i = 1; i < cells.size(); ++i)
    if (!(cells[i] < cells[i - 1])) {
      const std::string t = fmt::format("--cells: {:g} mm after {:g} mm; expected different sizes, coarse to fine",
                                        cells[i], cells[i - 1]);
      throw InputError("", 0, t);
    }
  std::optional<ErrorGoal> goal;  // says which sizes follow
  if (share) cells = {goal.emplace(*share, scene.cell_mm, opt.limit_s).next_mm()};
  if (cells.empty()) cells.push_back(opt.cell_mm > 0 ? opt.cell_mm : repro ? repro->cell_mm : scene.cell_mm);
  const std::shared_ptr<const Body> body = build_body(scene);
  WorkersPool workers(opt.common.worker_count());

  if (!opt.orders.empty()) return compare_orders(opt.orders, opt.cell_mm, opt.common, scene, script, body, workers);

  std::vector<Command> actions;
  for (const ScriptLine& l : script.lines) actions.push_back(l.command);
  MeasureAlso also{lesson ? lesson->plan : script.header.plan, scene.landmarks, {}};
  also.landmarks.insert(also.landmarks.end(), script.header.landmarks.begin(), script.header.landmarks.end());
  if (lesson) also.landmarks.insert(also.landmarks.end(), lesson->landmarks.begin(), lesson->landmarks.end());
  const Skin skin(body);
  // a bad plan is refused before the work
  const std::optional<PlanOnSkin> planned = plan_of(skin, also.plan, join_strokes(actions));

  Result result("operate", scene.name);
  std::vector<Row> rows;
  std::vector<ResultVerdict> verdict;  // of the finest
  std::vector<Command> carried_out;    // of the finest
  bool at_rest = true, whole = true, stopped = false;
  for (size_t i = 0; i < cells.size(); ++i) {
    WorldSpec spec = world_spec(scene, body);
    spec.cell_mm = cells[i];
    if (repro) spec.seed = repro->seed;
    World world(spec, workers);
    ReproWriter refused(repro ? "" : opt.common.repro(), blank_repro(scene, cells[i], spec.seed));
    bool again = false;  // the repro's cut is refused again
    const std::string label = fmt::format("{:g} mm cells", cells[i]);
    Progress progress(label);
    OperationSettings set;
    set.interrupted = interrupted;
    set.keep_going = opt.keep_going;
    carried_out.clear();
    std::optional<PageModel> model;
    Snapshot now;
    if (!opt.common.out_dir.empty() && viewer_is_built()) world.fill(now), model.emplace("act").frame(0, now);
    set.on_done = [&](const ScriptLine& l, const std::string& note) {
      if (i == 0 && !note.empty() && !std::holds_alternative<Undo>(l.command) &&
          !std::holds_alternative<Redo>(l.command)) {
        progress.clear();
        say(fmt::format("{}:{}: {}: {}", script.name, l.line, action_name(l.command), note));
      }
      carried_out.push_back(l.command), refused.done(l.command);
      if (model) world.fill(now), model->acted(l.command, now);
    };
    set.on_refusal = [&](const Command& c, const std::string& reason) {
      progress.clear();
      if (const std::string file = refused.refused(c, reason, world.topology_hash()); !file.empty())
        say("the refused cut can be tried again: limberg operate " + opt.scene + " " + file);
      if (!refused.error().empty()) say(refused.error());
      if (!repro || carried_out.size() != repro->commands.size()) return;
      again = true;
      std::printf("repro       %zu commands, then refused again: %s\n", carried_out.size(), reason.c_str());
      std::printf("topology    %s, %s\n", hex(world.topology_hash()).c_str(),
                  world.topology_hash() == repro->topology_hash ? "as recorded"
                                                                : ("recorded " + hex(repro->topology_hash)).c_str());
    };
    set.progress = [&](size_t done, size_t total) { progress.show(double(done), double(total), "actions"); };
    OperationOutcome o;
    try {
      o = operate(world, scene.tools.max_depth_mm, script, set);
    } catch (const InputError&) {
      if (!again) throw;
      return kGoalMissed;
    }
    progress.clear();
    if (again) return kGoalMissed;
    if (repro && !o.interrupted) std::printf("repro       the cut that was refused is carried out\n");
    if (tell_unfinished(o, script.lines.size(), script.name)) whole = false;
    if (o.interrupted) cells.resize(i + 1), goal.reset();  // what was done by then is all there is
    at_rest &= o.last.residual <= 1e-4;
    rows.push_back({cells[i], o.solve_ms, o.last.residual, o.last.distance_mm,
                    std::cbrt(world.skin()->solver().model().cell_mm.prod()),
                    world.skin()->solver().model().X_mm.size(), measure_world(world, carried_out, also)});
    std::printf(
        "%-12s %7zu nodes  %8.0f ms  residual %.1e  off by about %.1e mm  closure %.3f N  gap %.3f mm  dog-ear %.2f mm "
        " state_hash %s\n",
        label.c_str(), rows.back().nodes, o.solve_ms, o.last.residual, o.last.distance_mm,
        rows.back().key.closure_force_N, rows.back().key.suture_gap_max_mm, rows.back().key.dog_ear_mm,
        hex(world.state_hash()).c_str());
    if (goal && goal->go_on(figures_of(rows), o.solve_ms / 1000)) cells.push_back(goal->next_mm());
    if (i + 1 < cells.size()) continue;
    fill_operation(result, world, scene, o, rows.back().key);
    fill_closure(result, o.closure);
    const Exercise done = exercise(carried_out, rows.back().key, planned);
    const std::vector<Judgement> judged =
        fill_exercise(result, done, lesson_values(rows.back().key, done.design), lesson ? &*lesson : nullptr);
    print_judgements(judged);
    VerdictOf look;
    look.metrics = &rows.back().key, look.body = body.get(), look.cell_mm = cells[i], look.judged = judged;
    look.wound_level = spec.wound_level;
    look.residual = o.last.residual, look.stalled = o.stalled, look.cut_short = o.interrupted;
    verdict = verdict_of(look);
    fill_verdict(result, verdict);
    if (!opt.fields.empty()) write_fields(opt.fields, world);
    if (!opt.common.out_dir.empty()) {
      Snapshot last;
      world.fill(last, true);                                // with the tension
      if (o.interrupted) leave_figures(result, opt.common);  // who is in a hurry may not wait for the pictures
      stopped = !draw_report_pictures(opt.common.out_dir, o.stages, last, opt.common.words());
      if (model) model->ended(last), model->leave(opt.common.out_dir, scene.name, report_camera(last), kReportAspect);
    }
  }
  if (rows.size() > 1) fill_convergence(result, rows);
  const bool near_enough = !goal || tell_error_goal(result, *goal, *share);
  ResultStory story = made_by(this_call());
  story.script = script_of(carried_out);
  write_fields(result, "", story);
  const bool reached = whole && at_rest && !is_bad(verdict) && near_enough && !stopped;
  result.set_ok(reached);
  if (stopped) mark_stopped(result);
  leave_result(result, opt.common);
  print_verdict(verdict);
  if (!at_rest && !interrupted()) say("the patient did not come to rest: relative residual above 1e-4");
  return reached ? kDone : kGoalMissed;
}

}  // namespace

void add_operate(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<OperateOptions>();
  CLI::App* c = app.add_subcommand("operate", "Carry out an operation script to equilibrium, at any resolution");
  c->add_option("SCENE", o->scene, "Scene file, or the name of a shipped scene");
  c->add_option("SCRIPT", o->script, "Operation script (JSON lines), or a repro-N.json of a refused cut");
  c->add_option("--case", o->of_case, "Scene, script and lesson of this case of the library (limberg cases)")
      ->type_name("NAME")
      ->excludes(c->get_option("SCENE"));
  CLI::Option* one = c->add_option("--cell-mm", o->cell_mm, "Cell size instead of the scene's")
                         ->type_name("H")
                         ->check(number_from(0.05, 100.0));
  CLI::Option* several = c->add_option("--cells", o->cells,
                                       "Several cell sizes, coarse to fine: a table of what changes, and the error of "
                                       "every figure by extrapolation")
                             ->type_name("H,H,...")
                             ->delimiter(',')
                             ->check(number_from(0.05, 100.0))
                             ->excludes(one);
  CLI::Option* orders = c->add_option("--orders", o->orders,
                                      "Close in several orders and compare: as-written, reversed, alternating, or "
                                      "numbers of the suture lines as 2-1-3")
                            ->type_name("ORDER,...")
                            ->delimiter(',')
                            ->excludes(several);
  CLI::Option* error = c->add_option("--error", o->error,
                                     "Smaller and smaller cells, until the lattice's error of each figure (forces, "
                                     "dog-ear, gape, stress, elongation) is below so much of it")
                           ->type_name("P%")
                           ->excludes(one)
                           ->excludes(several)
                           ->excludes(orders);
  c->add_option("--limit-s", o->limit_s, "--error: no size that would take longer to solve (default 600)")
      ->type_name("S")
      ->check(number_from(0.1, 1e6))
      ->needs(error);
  c->add_option("--judge", o->lesson, "Judge the result by this lesson: its file, or the name of a shipped one")
      ->type_name("LESSON")
      ->excludes(orders);
  c->add_flag("--keep-going", o->keep_going,
              "Leave out actions that the patient refuses, say which and why, and carry out the others; exit status 3")
      ->excludes(orders);
  c->add_option("--fields", o->fields,
                "Write stretch, stress, their direction and the perfusion index of every skin triangle")
      ->type_name("CSV")
      ->excludes(orders);
  o->common.add_out(*c), o->common.add_words(*c), o->common.add_json(*c), o->common.add_workers(*c),
      o->common.add_repro(*c);
  c->footer("Example: limberg operate rhomboid recordings/rhomboid.jsonl --cells 5,3.5,2.5 --out out/operate");
  c->callback([o, &chosen] { chosen = [o] { return run_operate(*o); }; });
}

}  // namespace limberg
