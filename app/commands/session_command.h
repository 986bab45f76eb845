#pragma once
// What run, replay and emulate have in common: drive a session, leave its results.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/assembly/bundle.h"
#include "app/assembly/device_specs.h"
#include "app/assembly/lesson.h"
#include "app/assembly/patient_of_scene.h"
#include "app/commands/commands.h"
#include "app/headset/shared.h"
#include "app/operating_point/operating_point.h"
#include "app/pictures/film.h"
#include "app/result/session_result.h"
#include "app/window/run_window.h"

namespace limberg {

struct SessionCall {
  std::string command;  // for result.json
  Scene scene;
  std::shared_ptr<void> scene_files;
  Calibration calibration;
  bool real_time = false;
  bool hand_waits = false;       // in real time: nobody's hand but an emulated or a recorded one (session.h)
  bool slow_motion = false;      // in real time, a live hand: the clock may run slower than the wall's (session.h)
  bool progressive_cut = false;  // incisions open while they are drawn; recordings say whether they did
  bool threads_slip = true;      // that are laid down untied; recordings from before that say nothing of it
  bool in_space = true;          // acts of the hand; recordings from before that have them all on the chart
  bool as_meant = true;          // curves, and a row's edges; recordings from before that have polygons
  std::vector<std::unique_ptr<Source>> sources;
  std::vector<LiveSource> live_sources;    // made when the clock starts
  std::shared_ptr<HeadsetShared> headset;  // what a headset among them shows; null: there is none
  std::vector<std::string> live_names;     // as they were asked for
  std::string record_file;                 // empty: none
  bool replace_record = false;
  std::string
      keep_dir;  // with a window and no record_file: recorded aside all the same; kept here when the operator says so
  uint64_t surgeon_seed = 0;
  int64_t end_tick = -1;          // -1: when the sources have ended
  int ticks_per_solver_step = 0;  // 0: as the scene asks
  double known_length_s = 0;      // for the progress line
  /// Of a recording that the session goes on with; its schedule and `taken`, or `earlier`, are done again first.
  struct GoesOn {
    std::string file;
    std::vector<std::unique_ptr<Source>> earlier;
    int64_t end_tick = 0;         // of what is done again on an even clock
    std::vector<Sample> samples;  // all that is done again
    std::vector<Blob> files;      // as they were embedded
    SessionInfo session;
  };
  std::optional<GoesOn> goes_on;
  LiveSchedule schedule;             // of a live recording: it is done again as it was
  std::vector<Sample> taken;         // its samples, in the order in which they were recorded
  std::vector<Checkpoint> expected;  // of a recording: compared in lockstep
  std::vector<StateSample> expected_states;
  std::string recorded_by;  // of a recording: SessionInfo::program
  LogDamage damage;
  std::string reproduce;                       // the command that makes the result again
  std::optional<bench::OperatingPoint> point;  // that the scene was set to (--auto)
  std::optional<FilmSettings> film;            // in lockstep: every frame goes into it
  // A window whose first word to the operator is this; empty: none. RenderUnavailable: goes on without
  std::function<std::unique_ptr<SessionWindow>(const Scene&, const std::string& word)> window;
  std::optional<Lesson> lesson;  // by which the session is judged
  std::function<void(const World& world, const Command* act, double t_s, const HandState* hands)>
      watch;  // AssemblyOptions
  CommonOptions common;
};

/// Runs it, writes recording, pictures, script, result.json and report as asked, prints a summary on standard output.
/// Returns the exit status. `after` may add to the result before it is written.
int run_session(SessionCall call, const std::function<void(Result&, Assembly&)>& after = {});

/// Writes result.json into the output folder and the JSON file, as asked; leave_result() the page too.
void leave_figures(const Result& result, const CommonOptions& common);
/// Of a command that a person ended while it drew: `interrupted`, and not `ok`.
void mark_stopped(Result& result);
void leave_result(const Result& result, const CommonOptions& common);

/// A lesson is judged on a scene that has what it is about: InputError otherwise. Says so where it was made for
/// another.
void check_lesson(const Lesson& lesson, const Scene& scene);
/// Throws InputError: it names landmarks or figures that the head lacks. Null, or a lesson on skin: nothing is asked.
void check_lesson(const Lesson& lesson, const Head* head);

/// A file's path from the root of the disk.
std::string whole_path(const std::string& file);

}  // namespace limberg
