#pragma once
// Makes the operations of a fuzz run: what a surgeon might do, and what nobody would.
//
// Generic cases have coordinates in general position. In adversarial ones every axis of every blade is rounded to
// something that is there already: a grid of 16 units, whole millimetres, the columns of the body's vertices, planes of
// the lattice, vertices of earlier blades; the first try of a cut takes them as they are.
#include "tests/bench/fuzz/random.h"
#include "tests/bench/fuzz/runner.h"

namespace limberg::fuzz {

class Generator {
 public:
  Generator(uint64_t seed, bool adversarial) : random_{seed}, adversarial_(adversarial) {}

  /// A body and a lattice, without operations.
  Case start(int front_levels = 0);
  /// The next operation, in view of what there is.
  Op next(const Runner& runner, int32_t number);

 private:
  enum Snap : uint8_t { none, units16, whole_mm, body_columns, planes, past };
  void begin_blade(const Runner& runner);
  Int3 place(const Vec3& mm);
  Vec2 around(double share);  // a random place over the body, within this share of its half size
  void finish_strip(Op& op, const std::vector<Vec2>& path, double top, double bottom, bool closed, const Vec2& lean);

  Op incise(int bends);
  Op loop(bool through);
  Op cross(const Runner& runner);
  Op deepen(const Runner& runner, int32_t number);
  Op prolong(const Runner& runner, int32_t number);
  Op undermine(const Runner& runner);
  Op sheet();
  Op plug();
  Op again(const Runner& runner);
  Op fold();
  Op fan();

  Random random_;
  bool adversarial_;
  Case case_;
  double step_ = 6;  // mm along a strip
  Snap snap_[3] = {none, none, none};
  std::vector<Int3> past_;
};

}  // namespace limberg::fuzz
