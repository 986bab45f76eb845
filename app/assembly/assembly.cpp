#include "app/assembly/assembly.h"

#include "app/program/version.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

GestureSettings gestures(const Scene& scene, const AssemblyOptions& o) {
  GestureSettings g;
  g.threads_slip = o.threads_slip, g.in_space = o.in_space, g.as_meant = o.as_meant;
  g.reach_mm = scene.tools.reach_mm;
  g.default_depth_mm = scene.tools.default_depth_mm;
  g.default_spacing_mm = scene.tools.default_spacing_mm;
  return g;
}

std::unique_ptr<ScriptWriter> open_script(const std::string& file, const Scene& scene) {
  if (file.empty()) return nullptr;
  return std::make_unique<ScriptWriter>(file, ScriptHeader{scene.name, "written by a session as it went"},
                                        ScriptWriter::Existing::replace);
}

}  // namespace

Repro blank_repro(const Scene& scene, double cell_mm, uint64_t seed) {
  Repro r;
  r.program = program_name();
  r.scene = scene.name;
  r.scene_hash = scene.hash;
  r.cell_mm = cell_mm;
  r.seed = seed;
  return r;
}

namespace {

std::function<void(double, const HandState&)> steps_watched(const AssemblyOptions& o, const World& world) {
  if (!o.watch) return {};
  return [watch = o.watch, &world](double t_s, const HandState& hands) { watch(world, nullptr, t_s, &hands); };
}

}  // namespace

Assembly::Assembly(Scene scene_in, const Calibration& calibration_in, const AssemblyOptions& o)
    : scene(std::move(scene_in)),
      calibration(calibration_in),
      workers(o.workers),
      world(make_world(scene, workers)),
      head(world->head()),
      patient(std::make_unique<WorldPatient>(*world, scene.tools.max_depth_mm)),
      front(calibration, gestures(scene, o)),
      device(front, channels, o.record, o.record && o.real_time),
      script(open_script(o.script_file, scene)),
      repro(o.repro_dir, blank_repro(scene, scene.cell_mm, scene.seed)),
      solver(
          *patient, channels,
          SolverSettings{.step = step_settings(scene, o.real_time),
                         .progressive_cut = o.progressive_cut,
                         .in_space = o.in_space,
                         .as_meant = o.as_meant,
                         .schedule = o.record && o.real_time,
                         .sample_states = o.record,
                         .after_step = steps_watched(o, *world)},
          [this, watch = o.watch](const Command& c) {
            if (watch) watch(*world, &c, 0, nullptr);
            done.push_back(c);
            repro.done(c);
            if (!script || !script_error.empty()) return;
            try {
              script->append(c);
            } catch (const InputError& e) {
              script_error = e.what();
            }
          },
          [this](const Command& c, const std::string& reason) { repro.refused(c, reason, patient->topology_hash()); }),
      render(channels, o.sink, o.draw_frames) {}

SessionSettings Assembly::session_settings() const {
  SessionSettings s;
  s.ticks_per_solver_step = ticks_per_solver_step(scene);
  return s;
}

}  // namespace limberg
