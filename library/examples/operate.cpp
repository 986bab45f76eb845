// A scene and a script, carried out to equilibrium: figures, and the same hash as `limberg operate` prints.
//
//   operate rhomboid recordings/rhomboid.jsonl 5
#include <fmt/core.h>
#include <limberg/limberg.h>

#include <cstdlib>

int main(int argc, char** argv) try {
  using namespace limberg;
  if (argc < 3) {
    fmt::print(stderr, "operate SCENE SCRIPT [CELL_MM]\n");
    return 2;
  }
  WorkersPool workers(2);
  Scene scene = open_scene(argv[1]);
  if (argc > 3) scene.cell_mm = std::atof(argv[3]);
  const std::unique_ptr<World> world = make_world(scene, workers);
  const Script script = load_script(argv[2]);
  const OperationOutcome done = operate(*world, scene.tools.max_depth_mm, script, {});

  std::vector<Command> commands;
  for (const ScriptLine& l : script.lines) commands.push_back(l.command);
  const Metrics m = measure_world(*world, commands);
  const LatticeFields f = lattice_fields(*world->skin());
  float pressure = 0;
  for (const float p : f.pressure_kPa) pressure = std::max(pressure, p);
  fmt::print("{} stages, residual {:.1e}\n", done.stages.size(), done.last.residual);
  fmt::print("closure {:.3f} N, gape {:.2f} mm, greatest pressure {:.1f} kPa\n", m.closure_force_N, m.wound_gape_mm,
             pressure);
  fmt::print("state_hash {:016x}\n", world->state_hash());
} catch (const limberg::InputError& e) {
  fmt::print(stderr, "operate: {}\n", e.what());
  return 2;
}
