#include "app/assembly/assembly.h"

#include <cmath>

#include "app/head/build.h"
#include "app/program/version.h"
#include "sim/base/error.h"
#include "sim/skull/bone/rigid_world.h"

namespace limberg {

namespace {

GestureSettings gestures(const Scene& scene) {
  GestureSettings g;
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

std::unique_ptr<World> make_world(const Scene& scene, Workers& workers) {
  if (!scene.head) return std::make_unique<World>(world_spec(scene, build_body(scene)), workers);
  if (const std::string why = bone::why_no_physics(); !why.empty()) throw InputError(scene.path, 0, why);
  const HeadSettings head{1e-3 * ticks_per_solver_step(scene), scene.head->carries_skin_mm};
  if (!scene.flesh) return std::make_unique<World>(head_parts(scene, workers), workers, head);
  return std::make_unique<World>(world_spec(scene, build_body(scene)), head_parts(scene, workers), workers, head);
}

Repro blank_repro(const Scene& scene, double cell_mm, uint64_t seed) {
  Repro r;
  r.program = program_name();
  r.scene = scene.name;
  r.scene_hash = scene.hash;
  r.cell_mm = cell_mm;
  r.seed = seed;
  return r;
}

int ticks_per_solver_step(const Scene& scene) { return std::max(1, int(std::floor(1000.0 / scene.steps_per_s))); }

StepSettings step_settings(const Scene& scene, bool real_time) {
  StepSettings s;
  s.max_iterations = scene.iterations_per_step;
  s.tolerance = 1e-5;  // a patient at rest costs nothing; single precision reaches about 4e-6
  if (scene.dynamic) s.dt_s = 1e-3 * ticks_per_solver_step(scene);
  s.damping_per_s = scene.damping_per_s, s.integrator = scene.integrator;
  s.adopt_when_ready = real_time;
  return s;
}

namespace {

std::function<void(double)> steps_watched(const AssemblyOptions& o, const World& world) {
  if (!o.watch) return {};
  return [watch = o.watch, &world](double t_s) { watch(world, nullptr, t_s); };
}

}  // namespace

Assembly::Assembly(Scene scene_in, const Calibration& calibration_in, const AssemblyOptions& o)
    : scene(std::move(scene_in)),
      calibration(calibration_in),
      workers(o.workers),
      world(make_world(scene, workers)),
      head(world->head()),
      patient(std::make_unique<WorldPatient>(*world, scene.tools.max_depth_mm)),
      front(calibration, gestures(scene)),
      device(front, channels, o.record, o.record && o.real_time),
      script(open_script(o.script_file, scene)),
      repro(o.repro_dir, blank_repro(scene, scene.cell_mm, scene.seed)),
      solver(
          *patient, channels,
          SolverSettings{.step = step_settings(scene, o.real_time),
                         .progressive_cut = o.progressive_cut,
                         .schedule = o.record && o.real_time,
                         .sample_states = o.record,
                         .after_step = steps_watched(o, *world)},
          [this, watch = o.watch](const Command& c) {
            if (watch) watch(*world, &c, 0);
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
