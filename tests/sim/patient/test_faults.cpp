// A cut that fails inside, at any step, leaves the patient as it was: every bit of it.
#include <gtest/gtest.h>

#include <stdexcept>

#include "sim/cutting/arrangement/fault.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/planted_defect.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_faults {

WorldSpec block(FaultPlan& fault) {
  WorldSpec spec = test::small_block({.side_mm = 50, .fat = false});
  spec.fault = &fault;
  return spec;
}

struct Act {
  const char* name;
  Command command;
};

TEST(Faults, ACutThatFailsInsideChangesNothing) {
  const std::vector<Act> acts = {{"incision across a wall", Incise{{{-15, 0.3}, {15, 0.9}}, 4, 80}},
                                 {"excision", Excise{{{-7, 4}, {6, 4}, {7, 12}, {-6, 11}}, 4}},
                                 {"undermining", Undermine{{{-1, -8}, {12, -8}, {12, 8}, {-1, 8}}, 4}},
                                 {"a piece of a stroke", InciseMore{1, {{-16, -12}, {15, -10}}, 4, 90, false}}};
  InlineWorkers workers;
  for (const Act& act : acts)
    for (const FaultPlan::Kind kind : {FaultPlan::zero, FaultPlan::thrown}) {
      SCOPED_TRACE(act.name);
      FaultPlan fault;
      World world(block(fault), workers);
      ASSERT_TRUE(world.apply(Incise{{{0.3, -17}, {-0.4, 16}}, 4, 90}).done);
      StepSettings s;
      s.max_iterations = 5;
      world.step(s);
      ASSERT_TRUE(world.apply(SetHook{1, {5, 5}}).done);
      fault = FaultPlan{};
      const Outcome count = world.apply(act.command);
      ASSERT_TRUE(count.done) << count.reason;
      const int64_t calls = fault.calls;
      ASSERT_GT(calls, 20);
      const uint64_t after = world.full_hash();
      ASSERT_TRUE(world.apply(Undo{}).done);
      const uint64_t before = world.full_hash();
      int refused = 0;
      for (int i = 0; i < 40; ++i) {
        fault = FaultPlan{};
        fault.kind = kind;
        fault.at = calls * i / 40;
        fault.until = kind == FaultPlan::zero ? INT64_MAX : fault.at + 1;  // every later sign too: no redrawing helps
        const Outcome o = world.apply(act.command);
        fault = FaultPlan{};
        if (o.done) {
          ASSERT_TRUE(world.apply(Undo{}).done);
        } else {
          ++refused;
          EXPECT_FALSE(o.reason.empty());
        }
        ASSERT_EQ(world.full_hash(), before)
            << (o.done ? "done" : o.reason) << ", fault at " << i << "/40 of " << calls;
      }
      EXPECT_GE(refused, 20);
      // And nothing lingers: the same act comes out as it did.
      const Command again = std::holds_alternative<InciseMore>(act.command)
                                ? Command(InciseMore{2, std::get<InciseMore>(act.command).path, 4, 90, false})
                                : act.command;
      ASSERT_TRUE(world.apply(again).done);
      EXPECT_EQ(world.full_hash(), after);
    }
}

// What is no refusal of a cut but a defect of the program is told as one, and the cut is taken back all the same.
TEST(Faults, ADefectInsideACutIsThrownOnAndChangesNothing) {
  const std::vector<Act> acts = {{"incision across a wall", Incise{{{-15, 0.3}, {15, 0.9}}, 4, 80}},
                                 {"excision", Excise{{{-7, 4}, {6, 4}, {7, 12}, {-6, 11}}, 4}},
                                 {"a piece of a stroke", InciseMore{1, {{-16, -12}, {15, -10}}, 4, 90, false}}};
  InlineWorkers workers;
  for (const Act& act : acts) {
    SCOPED_TRACE(act.name);
    FaultPlan fault;
    test::PlantedDefect defect;
    fault.watch = &defect;
    World world(block(fault), workers);
    ASSERT_TRUE(world.apply(Incise{{{0.3, -17}, {-0.4, 16}}, 4, 90}).done);
    ASSERT_TRUE(world.apply(SetHook{1, {5, 5}}).done);
    StepSettings s;
    s.max_iterations = 5;
    world.step(s);
    defect.calls = 0;
    ASSERT_TRUE(world.apply(act.command).done);
    const int64_t calls = defect.calls;
    ASSERT_GT(calls, 20);
    const uint64_t after = world.full_hash();
    ASSERT_TRUE(world.apply(Undo{}).done);
    const uint64_t before = world.full_hash();
    Command again = act.command;
    for (int i = 0; i <= 12; ++i) {
      defect.calls = 0, defect.at = (calls - 1) * i / 12;
      if (auto* piece = std::get_if<InciseMore>(&again)) ++piece->stroke;
      EXPECT_THROW(world.apply(again), std::out_of_range) << "sign " << defect.at << " of " << calls;
      defect.at = -1;
      ASSERT_EQ(world.full_hash(), before) << "sign " << i << "/12 of " << calls;
      if (auto piece = std::get_if<InciseMore>(&again)) {
        EXPECT_FALSE(world.apply(InciseMore{piece->stroke, {{15, -10}, {16, -10}}, 4, 90, false}).done)
            << "a stroke was left open";
      }
    }
    if (auto* piece = std::get_if<InciseMore>(&again)) ++piece->stroke;
    ASSERT_TRUE(world.apply(again).done);
    EXPECT_EQ(world.full_hash(), after);
  }
}

}  // namespace test_faults
}  // namespace limberg
