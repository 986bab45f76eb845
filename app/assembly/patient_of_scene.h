#pragma once
// The patient that a scene asks for, and how it is stepped.
//
//   Scene scene = open_scene("rhomboid");                            // a shipped one, or a file
//   std::unique_ptr<World> world = make_world(scene, workers);
//   world->step(step_settings(scene, false));
#include <memory>
#include <string>
#include <vector>

#include "app/scene/scene.h"
#include "sim/commands/script.h"
#include "sim/patient/world.h"

namespace limberg {

/// The scene of a name or path as the user typed it: a path, or one of the scenes shipped (shipped.h says where they
/// are looked for). InputError as load_scene, or with the names to be had.
Scene open_scene(const std::string& name_or_path);

/// The acts of a script in their order, those by texture at the places where they lie on this scene's body
/// (texture_script.h). The body is built only where there are such places. InputError for one that it does not have.
std::vector<Command> acts_on(const Scene& scene, const Script& script);

/// Skin, head, or both. InputError: what build_body and head_parts throw; a head where no fragment can be held.
std::unique_ptr<World> make_world(const Scene& scene, Workers& workers);
int ticks_per_solver_step(const Scene& scene);
/// `real_time`: a new preconditioner is taken as soon as it is there.
StepSettings step_settings(const Scene& scene, bool real_time);

}  // namespace limberg
