#pragma once
// Limberg as a library: open reconstructive surgery on skin, fat and bone, without window, device or clock.
//
//   #include <limberg/limberg.h>
//   using namespace limberg;
//
//   WorkersPool workers(4);                                     // or InlineWorkers: this thread alone, the same bits
//   Scene scene = open_scene("rhomboid");                       // a shipped scene, or a file    (app/scene/scene.h)
//   std::unique_ptr<World> world = make_world(scene, workers);  // the patient              (sim/patient/world.h)
//
//   Outcome o = world->apply(Incise{.path = {{-12, 0}, {12, 0}}, .depth_mm = 4});    // (sim/commands/command.h)
//   if (!o.done) fmt::print("refused: {}\n", o.reason);         // and nothing has changed
//   world->step(step_settings(scene, false));                   // towards equilibrium, as often as you like
//
//   Snapshot seen;                                              // places, stitches, hooks (sim/patient/snapshot.h)
//   world->fill(seen);
//   Metrics m = measure_world(*world, commands);                // forces, stretch, dog-ears (sim/measure/metrics.h)
//   LatticeFields f = lattice_fields(*world->skin());           // stress of each cell (sim/measure/lattice_fields.h)
//
//   operate(*world, scene.tools.max_depth_mm, load_script("zplasty.jsonl"), {});     // (app/assembly/operation.h)
//   Recording r = read_recording("session.lcm");                // hands, as they were recorded (devices/recording.h)
//
// Units are mm, s, kg; hence mN, kPa, uJ. Names say other ones (force_N). A place on the skin is a point of its chart
// in mm (sim/body/body.h), so that nothing depends on a mesh. Errors of input are InputError: FILE:LINE: what is wrong;
// what was expected.
//
// Nothing here is global: as many patients as there is memory for may be used at once, each by one thread at a time.
// Results are the same bits for any number of workers and on every machine.
//
// Each header below begins with the story of its part. docs/library.md says how to link, what is compatible with what,
// and which parts can be linked alone.
#include "app/assembly/bundle.h"            // the scene of a recording
#include "app/assembly/operation.h"         // a script carried out to equilibrium
#include "app/assembly/patient_of_scene.h"  // open_scene, make_world
#include "app/program/shipped.h"            // where shipped scenes and scripts lie
#include "app/program/version.h"
#include "app/scene/scene.h"
#include "app/session/workers_pool.h"
#include "devices/recording.h"
#include "sim/base/error.h"
#include "sim/commands/procedures/catalogue.h"  // thirteen classical operations as scripts
#include "sim/commands/script.h"
#include "sim/measure/lattice_fields.h"
#include "sim/measure/patient.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
