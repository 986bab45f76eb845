#pragma once
// A session put together: scene and calibration in, lanes out, ready for lockstep or real time.
//
// The order matters and is kept here: workers, patient, channels, front end, lanes.
#include <functional>
#include <memory>
#include <string>

#include "app/assembly/patient_of_scene.h"
#include "app/assembly/repro.h"
#include "app/assembly/world_patient.h"
#include "app/scene/scene.h"
#include "app/session/session.h"
#include "app/session/workers_pool.h"
#include "sim/commands/script.h"
#include "sim/skull/head/head.h"

namespace limberg {

struct AssemblyOptions {
  int workers = 1;
  bool record = false;           // pass samples on to a recorder
  bool real_time = false;        // take a new preconditioner as soon as it is there
  bool progressive_cut = false;  // incisions open while they are drawn
  bool threads_slip = true;      // that are laid down untied (gestures.h)
  bool in_space = true;          // acts of the hand where the chart does not see them (command_builder.h)
  bool as_meant = true;          // drawn curves are curves, a row has two edges (stroke_path.h, gestures.h)
  bool draw_frames = false;      // frames for the sink, not only stages
  PictureSink* sink = nullptr;
  std::string repro_dir;    // where refused cuts leave a file to try them again; empty: nowhere
  std::string script_file;  // the session's own script; empty: none
  /// Looks at the patient after each act, and (null) after each step, which has a time and hands; changes nothing.
  std::function<void(const World& world, const Command* act, double t_s, const HandState* hands)> watch = {};
};

class Assembly {
 public:
  Assembly(Scene scene, const Calibration& calibration, const AssemblyOptions& options);

  SessionLanes lanes(Recorder* recorder) { return {device, solver, render, recorder}; }
  /// Solver steps and frames as the scene asks.
  SessionSettings session_settings() const;

  const Scene scene;
  const Calibration calibration;
  WorkersPool workers;
  const std::unique_ptr<World> world;
  const Head* const head;  // null: no bone
  const std::unique_ptr<Patient> patient;
  Channels channels;
  DeviceFrontEnd front;
  DeviceLane device;
  std::unique_ptr<ScriptWriter> script;
  std::vector<Command> done;  // every command that was carried out
  std::string script_error;   // the session goes on without its script when the disk is full
  ReproWriter repro;
  SolverLane solver;
  RenderLane render;
};

/// What every repro file of this scene begins with.
Repro blank_repro(const Scene& scene, double cell_mm, uint64_t seed);

}  // namespace limberg
