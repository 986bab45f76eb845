#include "app/assembly/patient_of_scene.h"

#include <algorithm>
#include <cmath>

#include "app/head/build.h"
#include "app/program/shipped.h"
#include "sim/base/error.h"
#include "sim/commands/texture_script.h"
#include "sim/skull/bone/rigid_world.h"

namespace limberg {

Scene open_scene(const std::string& name_or_path) {
  std::vector<std::string> folders;
  for (const std::string& root : shipped_roots()) folders.push_back(root == "." ? "app/scenes" : root + "/app/scenes");
  return load_scene(find_scene(name_or_path, folders));
}

std::vector<Command> acts_on(const Scene& scene, const Script& script) {
  std::vector<Command> acts;
  const auto take = [&](const Script& s) {
    for (const ScriptLine& l : s.lines) acts.push_back(l.command);
  };
  if (!scene.flesh || !has_texture_places(script))
    take(script);
  else
    take(on_texture(script, *build_body(scene)));
  return acts;
}

std::unique_ptr<World> make_world(const Scene& scene, Workers& workers) {
  if (!scene.head) return std::make_unique<World>(world_spec(scene, build_body(scene)), workers);
  if (const std::string why = bone::why_no_physics(); !why.empty()) throw InputError(scene.path, 0, why);
  const HeadSettings head{1e-3 * ticks_per_solver_step(scene), scene.head->carries_skin_mm};
  if (!scene.flesh) return std::make_unique<World>(head_parts(scene, workers), workers, head);
  return std::make_unique<World>(world_spec(scene, build_body(scene)), head_parts(scene, workers), workers, head);
}

int ticks_per_solver_step(const Scene& scene) { return std::max(1, int(std::floor(1000.0 / scene.steps_per_s))); }

StepSettings step_settings(const Scene& scene, bool real_time) {
  StepSettings s;
  s.max_iterations = scene.iterations_per_step;
  s.tolerance = 1e-5;  // a patient at rest costs nothing; single precision reaches about 4e-6
  if (scene.dynamic) s.dt_s = 1e-3 * ticks_per_solver_step(scene);
  s.damping_per_s = scene.damping_per_s, s.integrator = scene.integrator;
  s.adopt_when_ready = real_time;
  s.focus = scene.focus;
  return s;
}

}  // namespace limberg
