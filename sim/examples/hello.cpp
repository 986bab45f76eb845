// A whole program on sim/ alone: a block of skin on fat, one incision, three stitches, and their forces at rest.
//
//   ninja -C build limberg_hello && build/limberg_hello
#include <fmt/core.h>

#include "sim/body/block.h"
#include "sim/patient/world.h"

using namespace limberg;

namespace {

WorldSpec stretched_block() {
  BlockSpec block;
  block.size_mm = {60, 60, 10};
  block.skin_cell_mm = 1.2;
  Material skin, fat;
  skin.young_kPa = 60, skin.prestretch_along = skin.prestretch_across = 1.08;
  fat.young_kPa = 12;
  block.layers = {{"skin", 1.5, skin}, {"fat", 8.5, fat}};  // from the skin down, mm
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(block));
  spec.cell_mm = 3.5;
  return spec;
}

void settle(World& world) {
  StepSettings settings;
  for (int step = 0; step < 300; ++step)
    if (world.step(settings).residual < 1e-4 && world.settled()) return;
}

void act(World& world, const char* name, const Command& command) {
  const Outcome outcome = world.apply(command);  // a refused command has changed nothing
  fmt::print("{}: {}\n", name, outcome.done ? "done" : outcome.reason);
}

void print_stitches(const World& world) {
  Snapshot seen;
  world.fill(seen);
  for (const SutureState& s : seen.sutures)
    fmt::print("stitch {}: gap {:.3f} mm, {:.3f} N\n", s.id, s.gap_mm, s.force_N);
}

}  // namespace

int main() {
  InlineWorkers workers;  // everything on this thread
  World world(stretched_block(), workers);
  act(world, "incise", Incise{.path = {{-12, 0}, {12, 0}}, .depth_mm = 4});
  settle(world);
  act(world, "sew", SutureRow{.a = {{-6, 1}, {6, 1}}, .b = {{-6, -1}, {6, -1}}, .spacing_mm = 6});
  print_stitches(world);  // the wound gapes
  settle(world);
  print_stitches(world);  // the threads are tight
}
