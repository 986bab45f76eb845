#pragma once
// What result.json says of a run beside its lists (schema.h), each name once: what wrote it, the patient at its end,
// the three lanes, the story, the exercise. A command fills what it knows; the report reads all of it.
#include "app/result/schema.h"

namespace limberg {

struct ResultProgram {
  MaybeText version, commit;
};
void fields(ResultProgram& x, auto&& f) { f("version", x.version), f("commit", x.commit); }

struct ResultMachine {
  MaybeText cpu;
  MaybeCount cores;
};
void fields(ResultMachine& x, auto&& f) { f("cpu", x.cpu), f("cores", x.cores); }

/// Of every result.
struct ResultOrigin {
  ResultProgram limberg;
  MaybeText command, scene;
  ResultMachine machine;
  MaybeFlag ok;
};
void fields(ResultOrigin& x, auto&& f) {
  f("limberg", x.limberg), f("command", x.command), f("scene", x.scene), f("machine", x.machine), f("ok", x.ok);
}

/// lattice: of the skin.
struct ResultLattice {
  Maybe cell_mm;
  MaybeCount seed;  // of an operate
  MaybeCount nodes, cells, cell_copies, dofs;
};
void fields(ResultLattice& x, auto&& f) {
  f("cell_mm", x.cell_mm), f("seed", x.seed), f("nodes", x.nodes), f("cells", x.cells), f("cell_copies", x.cell_copies);
  f("dofs", x.dofs);
}

/// device/sources: what a live device sent. health: what it says of itself.
struct ResultSource {
  std::string device;
  int64_t samples = 0, samples_malformed = 0, samples_lost = 0;
  MaybeText health;
};
void fields(ResultSource& x, auto&& f) {
  f("device", x.device), f("samples", x.samples), f("samples_malformed", x.samples_malformed);
  f("samples_lost", x.samples_lost), f("health", x.health);
}

struct ResultDevice {
  MaybeCount ticks, late_ticks, skipped_ticks;
  ResultTimes wake_us, work_us, snapshot_age_ms;
  MaybeCount events_lost, samples_unrecorded, samples, samples_malformed, samples_lost, missed_presses,
      dropped_gestures;
  std::string scheduling;
  MaybeList<ResultSource> sources;
};
void fields(ResultDevice& x, auto&& f) {
  f("ticks", x.ticks), f("late_ticks", x.late_ticks), f("skipped_ticks", x.skipped_ticks), f("wake_us", x.wake_us);
  f("work_us", x.work_us), f("snapshot_age_ms", x.snapshot_age_ms), f("events_lost", x.events_lost);
  f("samples_unrecorded", x.samples_unrecorded), f("samples", x.samples);
  f("samples_malformed", x.samples_malformed), f("samples_lost", x.samples_lost);
  f("missed_presses", x.missed_presses), f("dropped_gestures", x.dropped_gestures), f("scheduling", x.scheduling);
  f("sources", x.sources);
}

/// hand: "waits", "slowed" or "live", of a session in real time; waited_ms: for so long its clock was held for the
/// patient. Of slow motion: slowed_ms, by how much the session was longer by the wall's clock than by its own, and
/// slowest_pace, of the wall's over the slowest second.
struct ResultSolver {
  MaybeCount steps, late_steps, skipped_steps;
  MaybeText hand;
  Maybe waited_ms, slowed_ms, slowest_pace;
  ResultTimes step_ms;
  Maybe residual, distance_mm;
  MaybeCount settle_steps;
  MaybeText describe;
};
void fields(ResultSolver& x, auto&& f) {
  f("steps", x.steps), f("late_steps", x.late_steps), f("skipped_steps", x.skipped_steps), f("step_ms", x.step_ms);
  f("hand", x.hand), f("waited_ms", x.waited_ms), f("slowed_ms", x.slowed_ms), f("slowest_pace", x.slowest_pace);
  f("residual", x.residual), f("distance_mm", x.distance_mm), f("settle_steps", x.settle_steps);
  f("describe", x.describe);
}

struct ResultRender {
  MaybeCount frames, skipped_frames;
  ResultTimes frame_ms;
};
void fields(ResultRender& x, auto&& f) {
  f("frames", x.frames), f("skipped_frames", x.skipped_frames), f("frame_ms", x.frame_ms);
}

struct ResultLatency {
  ResultTimes sample_to_snapshot, sample_to_frame;
};
void fields(ResultLatency& x, auto&& f) {
  f("sample_to_snapshot", x.sample_to_snapshot), f("sample_to_frame", x.sample_to_frame);
}

/// The run and the patient at its end. distance_mm: estimated, to equilibrium. A session's residual and distance stand
/// in `solver`. scene_path: of the scene's file, whole; what `export` carries the script out on again.
struct ResultRun {
  MaybeText scene_title, scene_note, scene_path, mode;
  Maybe duration_s;
  MaybeFlag interrupted;
  ResultLattice lattice;
  Maybe solve_ms, residual, distance_mm;
  MaybeText state_hash, topology_hash, scene_hash;
  MaybeList<std::string> parts;
  Maybe memory_mb;
  MaybeCount workers;
  ResultDevice device;
  ResultSolver solver;
  ResultRender render;
  ResultLatency latency_ms;
};
void fields(ResultRun& x, auto&& f) {
  f("scene_title", x.scene_title), f("scene_note", x.scene_note), f("scene_path", x.scene_path), f("mode", x.mode),
      f("duration_s", x.duration_s);
  f("interrupted", x.interrupted), f("lattice", x.lattice), f("solve_ms", x.solve_ms), f("residual", x.residual);
  f("distance_mm", x.distance_mm), f("state_hash", x.state_hash), f("topology_hash", x.topology_hash);
  f("scene_hash", x.scene_hash), f("parts", x.parts), f("memory_mb", x.memory_mb), f("workers", x.workers);
  f("device", x.device), f("solver", x.solver), f("render", x.render), f("latency_ms", x.latency_ms);
}

/// series: of the solver, an entry a step or thinner; null where a value is missing. unsettled: how many entries of
/// closure_N are of tissue out of balance, and no forces of the patient (settled_forces.h).
struct ResultSeries {
  MaybeList<double> t_s, residual, distance_mm, closure_N, suture_max_N;
  MaybeCount unsettled;
};
void fields(ResultSeries& x, auto&& f) {
  f("t_s", x.t_s), f("residual", x.residual), f("distance_mm", x.distance_mm), f("closure_N", x.closure_N);
  f("suture_max_N", x.suture_max_N), f("unsettled", x.unsettled);
}

/// What was done. script: a line for each act. reproduce: the call that makes the result again. repro: files of cuts
/// that were refused. recording_error: why the recording is cut short.
struct ResultStory {
  MaybeList<ResultStage> stages;
  ResultSeries series;
  MaybeCount commands;
  MaybeList<std::string> script;
  MaybeList<ResultRefusal> refused;
  std::string reproduce;
  MaybeList<std::string> repro;
  std::string recording_error;
};
void fields(ResultStory& x, auto&& f) {
  f("stages", x.stages), f("series", x.series), f("commands", x.commands), f("script", x.script);
  f("refused", x.refused), f("reproduce", x.reproduce), f("repro", x.repro);
  f("recording_error", x.recording_error);
}
/// Of which nothing is told but how the result is made again.
inline ResultStory made_by(const std::string& call) {
  ResultStory story;
  story.reproduce = call;
  return story;
}

/// metrics: what is no number of its own. The numbers stand in the table of measures (sim/measure/table.h).
struct ResultPatient {
  MaybeList<ResultSuture> sutures;
  MaybeList<ResultPoint> predicted;
  MaybeList<ResultLandmark> landmarks;
  std::optional<ResultVector> penetration_at_mm;
};
void fields(ResultPatient& x, auto&& f) {
  f("sutures", x.sutures), f("predicted", x.predicted), f("landmarks", x.landmarks);
  f("penetration_at_mm", x.penetration_at_mm);
}

/// balance: forces on the tissue at the end. relative: |sum| over the sum of magnitudes.
struct ResultBalance {
  ResultVector hooks_N{}, supports_N{}, sum_N{};
  double relative = 0;
  std::optional<ResultVector> loads_N{};  // weight and loads, of scenes with such
};
void fields(ResultBalance& x, auto&& f) {
  f("hooks_N", x.hooks_N), f("loads_N", x.loads_N), f("supports_N", x.supports_N), f("sum_N", x.sum_N),
      f("relative", x.relative);
}

/// exercise/design: against the plan.
struct ResultDesignError {
  Maybe corner_mean_mm, corner_max_mm, angle_max_deg, limb_max_percent;
  MaybeCount corners, missing;
};
void fields(ResultDesignError& x, auto&& f) {
  f("corner_mean_mm", x.corner_mean_mm), f("corner_max_mm", x.corner_max_mm), f("angle_max_deg", x.angle_max_deg);
  f("limb_max_percent", x.limb_max_percent), f("corners", x.corners), f("missing", x.missing);
}

/// exercise: the hand's figures are absent where a script was carried out without one.
struct ResultExercise {
  Maybe time_s, path_mm;
  MaybeCount movements;
  Maybe tracked_s, pressed_s;
  MaybeCount tracking_gaps;
  Maybe tracking_lost_s;
  MaybeCount osteotomies, bone_moves;
  int64_t cuts = 0, hooks = 0, hook_moves = 0, stitches = 0, threads_cut = 0, undos = 0, redos = 0, refused = 0;
  int64_t gaps_open = 0, peaks_over_2_5_N = 0, peaks_over_5_N = 0;
  ResultDesignError design;
};
void fields(ResultExercise& x, auto&& f) {
  f("time_s", x.time_s), f("path_mm", x.path_mm), f("movements", x.movements), f("tracked_s", x.tracked_s);
  f("pressed_s", x.pressed_s), f("tracking_gaps", x.tracking_gaps), f("tracking_lost_s", x.tracking_lost_s);
  f("osteotomies", x.osteotomies), f("bone_moves", x.bone_moves);
  f("cuts", x.cuts), f("hooks", x.hooks), f("hook_moves", x.hook_moves), f("stitches", x.stitches);
  f("threads_cut", x.threads_cut), f("undos", x.undos), f("redos", x.redos), f("refused", x.refused);
  f("gaps_open", x.gaps_open), f("peaks_over_2_5_N", x.peaks_over_2_5_N), f("peaks_over_5_N", x.peaks_over_5_N);
  f("design", x.design);
}

/// lesson: what it asked and whether it is met.
struct ResultLesson {
  MaybeText title, goal, file;
  MaybeList<ResultTolerance> tolerances;
  MaybeFlag all_met;
  MaybeList<std::string> steps, hints;
  MaybeCount shown_acts;
  MaybeList<std::string> to_do_better;
};
void fields(ResultLesson& x, auto&& f) {
  f("title", x.title), f("goal", x.goal), f("file", x.file), f("tolerances", x.tolerances);
  f("all_met", x.all_met), f("steps", x.steps);
  f("hints", x.hints), f("shown_acts", x.shown_acts), f("to_do_better", x.to_do_better);
}

/// pictures: files, relative to the result's folder.
struct ResultPictures {
  std::string overview, tension;
};
void fields(ResultPictures& x, auto&& f) { f("overview", x.overview), f("tension", x.tension); }

}  // namespace limberg
