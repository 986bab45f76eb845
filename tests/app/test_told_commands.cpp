// Commands of a panel at the solver's side: a snap is a grab and a let go that belong together.
#include <gtest/gtest.h>

#include "app/session/solver_lane.h"
#include "sim/commands/script.h"
#include "tests/app/fake_patient.h"

namespace limberg {
namespace test_told_commands {

/// Notes what it is told; grabs nothing while `holds_fast`.
class NotingPatient final : public Patient {
 public:
  Outcome apply(const Command& c) override {
    told.emplace_back(action_name(c));
    if (holds_fast && told.back() == "grab") return {false, "the fragment is plated; expected a free one"};
    return {true, {}};
  }
  StepReport step(const StepSettings& s) override { return body_.step(s); }
  void fill(Snapshot& s) const override { body_.fill(s); }
  std::shared_ptr<const SurfaceTopology> topology() const override { return body_.topology(); }
  uint64_t topology_hash() const override { return body_.topology_hash(); }
  uint64_t state_hash() const override { return body_.state_hash(); }

  std::vector<std::string> told;
  bool holds_fast = false;

 private:
  FakePatient body_;
};

struct Side {
  NotingPatient patient;
  std::unique_ptr<Channels> channels = std::make_unique<Channels>();
  SolverLane solver{patient, *channels, {}};
  int64_t tick = 0;

  std::vector<std::string> hears(std::vector<Command> commands) {
    for (Command& c : commands) {
      ToolEvent e;
      e.kind = ToolEvent::told, e.command = std::make_shared<const Command>(std::move(c));
      channels->events.push(e);
    }
    patient.told.clear();
    solver.step(tick += 8);
    return patient.told;
  }
};

using Names = std::vector<std::string>;

TEST(ToldCommands, AreAppliedInTheirOrder) {
  Side side;
  EXPECT_EQ(side.hears({HeadCommand(PlateFragments{}), Stage{"plated"}, HeadCommand(SortFragments{})}),
            (Names{"plate", "stage", "sort"}));
  EXPECT_EQ(side.solver.commands(), 3u);
  ASSERT_EQ(side.solver.stages().size(), 1u);
  EXPECT_EQ(side.solver.stages()[0].name, "plated");
  ToolEvent nothing_yet;
  nothing_yet.kind = ToolEvent::told;
  side.channels->events.push(nothing_yet);
  EXPECT_TRUE(side.hears({}).empty());
}

TEST(ToldCommands, WhatWasNotGrabbedIsNotLetGo) {
  const std::vector<Command> snap{HeadCommand(GrabFragment{}), HeadCommand(LetGo{true, 0})};
  Side side;
  EXPECT_EQ(side.hears(snap), (Names{"grab", "let_go"}));
  EXPECT_TRUE(side.hears({HeadCommand(LetGo{true, 0})}).empty());  // nothing is held any more
  side.patient.holds_fast = true;
  EXPECT_EQ(side.hears(snap), Names{"grab"});
  ASSERT_EQ(side.solver.refused().size(), 1u);  // the grab, and no second one for the same click
  EXPECT_EQ(side.solver.refused()[0].command, "grab");
}

}  // namespace test_told_commands
}  // namespace limberg
