// Scripts carried out to equilibrium: how far a thread is drawn before the tissue has followed it.
#include <gtest/gtest.h>

#include <vector>

#include "app/operation.h"
#include "sim/tools/script.h"
#include "tests/app/fake_patient.h"

namespace limberg {
namespace {

/// Draws a thread by a part in each of ten steps. What a part disturbs (`disturbs`, relative residual) goes down by 1 % with each iteration.
class Drawn final : public Patient {
 public:
  explicit Drawn(double disturbs) : disturbs_(disturbs) {}
  std::vector<double> before_part;  // residual when a part was drawn

  Outcome apply(const Command&) override {
    parts_ = 10;
    return {true, {}};
  }
  StepReport step(const StepSettings& s) override {
    StepReport out;
    if (parts_ > 0) before_part.push_back(residual_), residual_ += disturbs_, --parts_;
    for (; out.iterations < s.max_iterations && residual_ > s.tolerance; ++out.iterations) residual_ *= 0.99;
    out.residual = residual_;
    return out;
  }
  bool settled() const override { return parts_ == 0; }
  void fill(Snapshot& s) const override { flat_.fill(s); }
  std::shared_ptr<const SurfaceTopology> topology() const override { return flat_.topology(); }
  uint64_t topology_hash() const override { return 1; }
  uint64_t state_hash() const override { return 1; }

 private:
  FakePatient flat_;
  double disturbs_, residual_ = 0;
  int parts_ = 0;
};

Script one_stitch() { return parse_script("{\"limberg_script\":1,\"scene\":\"rhomboid\"}\n{\"action\":\"suture\",\"a\":[1,1],\"b\":[1,-1]}\n", "stitch.jsonl"); }

// Undisturbed parts would add up to ten times what one disturbs.
TEST(Operation, AThreadWaitsForTheTissue) {
  Drawn stiff(0.5);
  operate(stiff, one_stitch(), {});
  ASSERT_EQ(stiff.before_part.size(), 10u);
  for (const double r : stiff.before_part) EXPECT_LT(r, 0.5);
  for (size_t i = 2; i < 10; ++i) EXPECT_LT(stiff.before_part[i], 0.02) << i;  // .41 + .5, after 400 iterations: .0163
}

// Tissue that follows at once is not given more iterations than before.
TEST(Operation, WhatFollowsIsNotWaitedFor) {
  Drawn soft(1e-4);
  operate(soft, one_stitch(), {});
  ASSERT_EQ(soft.before_part.size(), 10u);
  for (size_t i = 1; i < 10; ++i) EXPECT_GT(soft.before_part[i], 0.8e-4) << i;  // 20 iterations leave .818
}

}  // namespace
}  // namespace limberg
