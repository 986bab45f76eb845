#pragma once
// What a hand might do next on a patient: strokes at once and drawn, along and across what it drew before, sheets,
// plugs, stitches, hooks, and second thoughts. Coordinates are often those of earlier strokes or whole millimetres.
#include <deque>

#include "tests/bench/fuzz/random.h"
#include "tests/bench/fuzz/world_runner.h"

namespace limberg::fuzz {

class WorldGenerator {
 public:
  explicit WorldGenerator(uint64_t seed) : random_{seed} {}
  /// A patient, without acts.
  WorldCase start();
  Command next();

 private:
  Vec2 point();
  Vec2 near(const Vec2& p, double by) { return p + Vec2(random_.real(-by, by), random_.real(-by, by)); }
  std::vector<Vec2> stroke();
  std::vector<Vec2> ring();
  double depth();
  void begin_stroke();
  Command other();

  Random random_;
  WorldCase case_;
  std::vector<std::vector<Vec2>> drawn_;
  std::deque<Command> queue_;  // the rest of a drawn stroke
  int strokes_ = 0;
};

}  // namespace limberg::fuzz
